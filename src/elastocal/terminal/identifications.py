"""Identifications and validations as tables and small pictures."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.identification.doubts import SELDOM, doubts, is_weak
from elastocal.identification.nuisance_found import nuisance_found
from elastocal.identification.result import Identification
from elastocal.identification.search import Searched
from elastocal.identification.validation import Validation, doubts_of_validation, summary
from elastocal.measuring.measurements import Quantity
from elastocal.robot.joint_kinds import PRISMATIC
from elastocal.terminal.console import micrometres, out, whole
from elastocal.terminal.fitted_along import show_fitted_along
from elastocal.wording import ended, worded
from elastocal.wording.identification import SURE, chance
from elastocal.wording.lists import counted, springs_in_short
from elastocal.wording.numbers import probability

_BAR = 25  # characters of a drawn interval
_MOST = 20  # experiments listed one by one


def show_identification(found: Identification, beyond: Searched | None = None) -> None:
    """Compliances with their intervals, what is weak in them, what else explains the readings."""
    data = found.measurements
    title = (
        f"{counted(len(found.identified), 'compliance')} from "
        f"{counted(len(data.cases), 'experiment')}, {counted(len(data), 'reading')}"
    )
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    confidence = f"{100 * found.how.confidence:g} %"
    for column in ("joint", "compliance", "± error", "interval", "unit", "stiffness", "unit"):
        left = column in ("joint", "unit")
        table.add_column(column, justify="left" if left else "right", no_wrap=True)
    table.add_column(f"{confidence} interval", no_wrap=True)
    index = found.index
    largest = float(np.abs(found.interval).max())
    for j, name in enumerate(found.identified):
        k, error = float(found.compliance[j]), float(found.standard_error[j])
        low, high = (float(v) for v in found.interval[j])
        kind = found.model.springs.kinds[index[j]]
        table.add_row(
            Text(name),
            f"{1e6 * k:.5g}",
            f"{1e6 * error:.2g}",
            f"{1e6 * low:.4g} … {1e6 * high:.4g}",
            f"µ{kind.compliance}",
            f"{1e-6 / k:.4g}" if k > 0.0 else "–",
            "N/µm" if kind is PRISMATIC else "MN·m/rad",
            _interval(low, k, high, largest),
        )
    whole(table)
    besides = {one.name for one in nuisance_found(found)}
    along = [n for n in found.fitted if n not in found.identified and n not in besides]
    if along:
        short = springs_in_short(along, found.model.springs.of_joints)
        out.print(Text(f"Known from before, and fitted along: {', '.join(short)}"))
    made = () if found.nuisance is None else found.nuisance.unknowns.springs.names
    known = [n for n in found.model.names if n not in found.fitted and n not in made]
    if known:
        out.print(Text(f"Taken as known exactly: {', '.join(known)}"))
    if found.nuisance is not None:
        show_fitted_along(found)
    out.print(Text(_noise(found)))
    out.print(Text(_linear(found)))
    odd = (*doubts(found), *(() if beyond is None else beyond.doubts))
    for doubt in odd:
        begins = "Weak" if is_weak(doubt) else "Note"
        out.print(Text(f"{begins}: {ended(worded(doubt))}", style="yellow"))
    if not odd:
        out.print(Text("Nothing weak was found in this result.", style="green"))


def _interval(low: float, middle: float, high: float, largest: float) -> str:
    """An interval drawn on a scale from zero to the largest value."""
    scale = largest if largest > 0.0 else 1.0
    places = [round((_BAR - 1) * min(max(v / scale, 0.0), 1.0)) for v in (low, middle, high)]
    bar = [" "] * _BAR
    bar[places[0] : places[2] + 1] = "─" * (places[2] + 1 - places[0])
    bar[places[1]] = "●"
    return "│" + "".join(bar)


def _noise(found: Identification) -> str:
    kinds = found.measurements.quantities
    sizes = [(summary(found.residual[kind.readings]), kind.unit) for kind in kinds]
    each = "; of the rotations ".join(
        f"root mean square {micrometres(size.rms, unit)}, largest {micrometres(size.largest, unit)}"
        for size, unit in sizes
    )
    text = (
        f"Residuals: {each}"
        + (
            f"; noise {found.scale:.3g} times what σ promises{_of_kinds(found)}"
            if np.isfinite(found.scale)
            else ""
        )
        + f" (χ² = {found.chi_square:.4g}, {found.dof} degrees of freedom)"
    )
    lack = found.lack_of_fit
    if lack is not None and lack.fit_dof > 0:
        text += f"; lack of fit against repeats: {probability(lack.p_value)}"
    return text + "."


def _of_kinds(found: Identification) -> str:
    """The noise of positions and of rotations, if there are both."""
    if len({noise.scale for noise in found.noise_of_kinds}) < 2:
        return ""
    return ", " + ", ".join(f"{n.scale:.3g} of {n.kind.name}s" for n in found.noise_of_kinds)


def _linear(found: Identification) -> str:
    if found.how.linear:
        return "Linear model of the deflections, as in the paper."
    shift = found.linear_shift
    j = int(np.argmax(shift))
    return (
        f"Model: equilibrium under load, {found.iterations} steps; the linear model would be up to "
        f"{shift[j]:.2g} standard errors off ({found.identified[j]})."
    )


def show_validation(found: Validation) -> None:
    """Deflection before and after the model."""
    data = found.measurements
    kind = "kept aside" if found.kept_aside else "left out in turn"
    title = f"{counted(len(data.cases), 'experiment')}, {kind}: "
    for quantity in data.quantities:
        what = "deflection" if quantity.unit == "m" else quantity.name
        whole(_before_and_after(found, quantity, f"{title}{what} before and after the model"))
    if found.coordinates:
        test = f"χ² = {found.chi_square:.4g} with {found.dof} degrees of freedom, "
        test += f"{probability(found.p_value)}"
        if not found.tested:
            test = "no test: the noise was found from these readings"
        out.print(
            f"{100 * found.inside:.3g} % of {found.coordinates} coordinates lie inside their "
            f"{100 * found.confidence:g} % prediction intervals ({test})."
        )
    lost = np.unique(data.case[~found.predicted])
    if len(lost):
        what = "it knows" if len(lost) == 1 else "each of them knows"
        out.print(
            Text(
                f"Weak: {len(lost)} of {counted(len(data.cases), 'experiment')} cannot be "
                f"predicted from the others, since {what} a compliance alone; `after` is the "
                "residual of the fit there, and does not count.",
                style="yellow",
            )
        )
    if found.repeated:
        (doubt,) = (d for d in doubts_of_validation(found) if d.code == "same-load-cases")
        out.print(Text(f"Weak: {ended(worded(doubt))}", style="yellow"))
    if SURE <= found.p_value < SELDOM:
        out.print(Text(f"Note: errors so large come {chance(found.p_value)}.", style="yellow"))
    if found.beyond_chance:
        out.print(
            Text(
                "Weak: the errors are larger than noise and compliances explain; the model lacks "
                "something, or the readings are worse than promised.",
                style="yellow",
            )
        )


def _before_and_after(found: Validation, kind: Quantity, title: str) -> Table:
    """The errors of one kind, experiment by experiment and over all."""
    data, unit = found.measurements, kind.unit
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("experiment", "before", "after", "removed"):
        table.add_column(column, justify="left" if column == "experiment" else "right")
    before, after = (found.by_experiment(error, kind) for error in (found.before, found.after))
    read = np.bincount(data.case[kind.readings], minlength=len(data.cases)) > 0
    shown = np.flatnonzero(read)
    if len(shown) > _MOST:  # the worst ones
        shown = np.sort(shown[np.argsort(-after[shown])[:_MOST]])
    for i in shown.tolist():
        sizes = (micrometres(before[i], unit), micrometres(after[i], unit))
        table.add_row(Text(data.names[i]), *sizes, _removed(before[i], after[i]))
    table.add_section()
    first, last = found.sizes(kind)
    for name, value in vars(first).items():
        rest = getattr(last, name)
        label = {"rms": "root mean square", "mean": "mean", "largest": "largest"}[name]
        sizes = (micrometres(value, unit), micrometres(rest, unit))
        table.add_row(label, *sizes, _removed(value, rest))
    return table


def _removed(before: float, after: float) -> str:
    return f"{100 * (1 - after / before):.1f} %" if before > 0.0 else "–"
