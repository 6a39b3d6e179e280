"""One sentence under a picture: what there is to see.

In: the values of the picture. Out: text.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.drawing.stage import DrawnCase
from elastocal.drawing.surfaces import APERTURES, WALLS
from elastocal.planning.certificate import Certificate
from elastocal.planning.plan import Plan
from elastocal.planning.trade_off import TradeOff
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number


def of_random(random: Array | None) -> str:
    """What the histogram leaves out."""
    if random is None or not len(random):
        return ""
    lost = int((~np.isfinite(random)).sum())
    beyond = "Random plans beyond the axis are counted in the last bar."
    if not lost:
        return beyond
    return f"{lost} of {len(random)} random plans cannot tell the compliances apart. {beyond}"


def of_experiments(plan: Plan, trade_off: TradeOff) -> str:
    """What twice or half the experiments would bring."""
    known = dict(zip(trade_off.counts.tolist(), trade_off.rho0.tolist(), strict=True))
    m = plan.count
    said = [
        f"{counted(count, 'experiment')} {verb} {length(known[count])}"
        for count, verb in ((2 * m, "would bring"), (m // 2, "would leave"))
        if count in known and count != m
    ]
    if said:
        return "; ".join(said) + "."
    if plan.study.prior.any():
        return "What was known before counts in every point."
    return "Four times the experiments halve the error."


def of_configurations(trade_off: TradeOff) -> str:
    """From where on more configurations are not worth the way."""
    errors = trade_off.rho0_configurations
    if len(errors) < 2:
        return ""
    enough = int(np.argmax(errors <= 1.01 * errors.min()))
    count = int(trade_off.configurations[enough])
    if enough == len(errors) - 1:
        return "Every further configuration still helps by more than 1 %."
    first = int(trade_off.configurations[0])
    below = f"Fewer than {first} cannot tell the compliances apart. " if first > 1 else ""
    noun = "configuration comes" if count == 1 else "configurations come"
    return f"{below}{count} {noun} within 1 % of the best; more would only cost setting-up time."


def of_hours(plan: Plan) -> str:
    """What the hours are made of."""
    times = plan.schedule
    parts = ", ".join(f"{number(minutes, 3)} min {what}" for what, minutes in times.minutes.items())
    return f"This plan: about {number(times.hours, 2)} h, of it {parts}."


def of_peak(certificate: Certificate) -> str:
    """What the peak of the sensitivity function says."""
    excess = certificate.peak_ratio - 1.0
    if not np.isfinite(excess):
        return ""
    if excess < 1e-3:
        return (
            "No other experiment would tell more than those of the optimal design: the "
            "equivalence theorem is satisfied to within the search's precision."
        )
    return (
        f"Some experiment would tell {number(100.0 * excess, 2)} % more than those of the design "
        "behind the bound, so the bound is loose by at most as much."
    )


def of_test(figure: DrawnCase) -> str:
    """What a picture of a test pose shows."""
    return f"{figure.label}, a path, at its first point" if len(figure.trace) else figure.label


def of_scene(plan: Plan) -> list[str]:
    """What cannot be drawn, so that nobody looks for it."""
    study = plan.study
    missing = [pose.name for pose in study.test_poses if pose.case is None]
    said = []
    if missing:
        said.append(f"Given by its regressor, so without a picture: {', '.join(missing)}.")
    drawn = (*WALLS, *APERTURES)
    undrawn = [c.name for c in study.constraints if not isinstance(c, drawn)]
    if undrawn:
        said.append(f"Constraints without a picture: {', '.join(undrawn)}.")
    return said
