"""Nuisance parameters of a fit on the screen: what was found of each, beside what was expected."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.identification.left_out_error import left_out_error, repeats_left
from elastocal.identification.nuisance_found import NuisanceFound, nuisance_found
from elastocal.identification.result import Identification
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording.lists import springs_in_short

_HALF = 12  # characters of a drawn value, on each side of zero
_ALONG = "what was fitted along"
_MOST = 3.0  # prior uncertainties that fit


def show_fitted_along(found: Identification) -> None:
    """What was fitted along, and what it is worth where an experiment is left out."""
    table = Table(
        title="fitted along, in units of what was expected", title_justify="left",
        box=box.SIMPLE_HEAD,
    )  # fmt: skip
    for column in ("nuisance", "found", "± error", "expected", "unit"):
        left = column in ("nuisance", "unit")
        table.add_column(column, justify="left" if left else "right", no_wrap=True)
    table.add_column(f"{-_MOST:g} … {_MOST:g}", no_wrap=True)
    told = nuisance_found(found)
    for one in told:
        scale, unit = (1e9, f"n{one.unit}") if one.unit else (1.0, "uncertainties")
        table.add_row(
            Text(one.name),
            "held at 0" if one.held else f"{scale * one.value:.3g}",
            f"{scale * one.standard_error:.2g}",
            f"{scale * one.mean:.3g} ± {scale * one.deviation:.2g}",
            unit,
            _drawn(one),
        )
    if told:
        whole(table)
    if found.alone is None:
        return
    mixed, alone = left_out_error(found), left_out_error(found.alone)
    gone, stay = repeats_left(found, mixed), repeats_left(found, alone)
    out.print(
        Text(
            f"Left out one after the other{gone}, experiments are predicted to "
            f"{micrometres(mixed.seen)} (RMS; promised {micrometres(mixed.promised)}); with the "
            f"joints alone{'' if stay == gone else stay} to {micrometres(alone.seen)} (promised "
            f"{micrometres(alone.promised)})."
        )
    )


def in_short(found: Identification) -> tuple[str, ...]:
    """Names of what was fitted, nuisance parameters as one, and many springs beside the joints."""
    besides = {one.name for one in nuisance_found(found)}
    fitted = [name for name in found.fitted if name not in besides]
    names = springs_in_short(fitted, found.model.springs.of_joints)
    return (*names, _ALONG) if besides else names


def _drawn(one: NuisanceFound) -> str:
    """Estimate and error on a scale of prior uncertainties, zero in the middle."""
    value, error = one.relative
    bar = [" "] * (2 * _HALF + 1)

    def place(at: float) -> int:
        return _HALF + round(_HALF * min(max(at / _MOST, -1.0), 1.0))

    low, high = place(value - error), place(value + error)
    bar[low : high + 1] = "─" * (high + 1 - low)
    bar[_HALF] = "┼" if low <= _HALF <= high else "│"
    bar[place(value)] = "●"
    return "".join(bar)
