"""What is known on the way to a plan: the best plan so far, and what no plan passes.

In: φ of a plan, and its upper bound once that has been tried. Out: a few words for progress.
"""

from __future__ import annotations

import numpy as np

from elastocal.planning.aim import Aim
from elastocal.planning.certificate import Bound
from elastocal.study.criteria import CRITERIA, root_inverse
from elastocal.study.study import Study
from elastocal.wording.numbers import number, short, shown_unit


def bracket(study: Study, aim: Aim, value: float, bound: Bound | None) -> str:
    """The loss of the best plan so far and the bound on it, as "ρ0 2.8 µm, at least 2.7 µm: …".

    Args:
        study: The study.
        aim: What its plans are to be good for.
        value: φ of the plan; with a floor its loss is too large, by less than is shown.
        bound: The bound; None as long as it has not been tried from fresh starts.
    """
    count = study.experiments.count
    upper = np.inf if bound is None else bound.upper(count)
    if not value > 0.0:
        return ""
    gain = 100.0 * (1.0 - np.sqrt(min(value / upper, 1.0)))
    room = f"{short(gain)} % to gain at most"
    criterion = CRITERIA[study.criterion]
    if criterion.measured is not root_inverse:
        return room if np.isfinite(upper) else ""
    losses = [aim.loss(phi) for phi in (value, max(value, upper))]
    factor, unit = shown_unit(criterion.unit(study.springs), np.array(losses[:1]))
    best, least = (f"{number(factor * loss, 4)} {unit}" for loss in losses)
    so_far = f"{'promise' if aim.promise else criterion.symbol} {best}"
    return f"{so_far}, at least {least}: {room}" if np.isfinite(upper) else f"{so_far} so far"
