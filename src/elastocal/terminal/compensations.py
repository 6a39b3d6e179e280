"""What a compensation did."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.arrays import Array
from elastocal.compensation.compensate import Compensation
from elastocal.files.paths.path_file import ToolPath
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording import ended, together, worded

_MOST_REMARKS = 10


def show_compensation(done: Compensation, task: ToolPath, residual: Array | None) -> None:
    """Deflection before and after along the path, and what is odd."""
    count, good = len(done), int(done.converged.sum())
    out.print(
        Text(
            f"{good} of {count} points corrected, {done.rule} rule, tool {done.arm.tool.name!r}, "
            f"{'geometry and ' if done.calibrated else ''}compliances of {_springs(done) or 'none'}"
        )
    )
    table = Table(box=box.SIMPLE_HEAD, title="Position error of the TCP", title_justify="left")
    table.add_column("")
    for column in ("RMS mm", "mean mm", "largest mm", "at point"):
        table.add_column(column, justify="right")
    rows = [
        ("before, by the model", np.linalg.norm(done.before, axis=1)),
        ("after, by the model", np.linalg.norm(done.after, axis=1)),
        ("expected after (ρ0)", done.rho0),
    ]
    if done.floor.any() or done.model.model_error > 0.0:
        rows.append(("expected with what follows", done.expected))
    if residual is not None:
        rows.append(("after, in truth", np.linalg.norm(residual, axis=1)))
    for title, sizes in rows:
        if np.isfinite(sizes).any():
            worst = int(np.nanargmax(sizes))
            rms = np.sqrt(np.nanmean(sizes**2))
            values = [_mm(v) for v in (rms, np.nanmean(sizes), sizes[worst])]
            table.add_row(title, *values, Text(task.names[worst] if values[-1] != "0" else ""))
    whole(table)
    if not done.covariance.any():
        out.print("The model has no covariance: it is taken as exact, ρ0 is zero.")
    else:
        out.print(Text(_limit(done, residual)))
    out.print(Text(_besides(done)))
    for note in (*task.remarks, *map(worded, done.notes)):
        out.print(Text(f"Note: {ended(note)}", style="yellow"))
    odd = [i for i, doubts in enumerate(done.doubts) if doubts]
    for i in odd[:_MOST_REMARKS]:
        text = f"Point {task.names[i]} (line {task.lines[i]}): {ended(together(done.doubts[i]))}"
        out.print(Text(text, style="yellow"))
    if len(odd) > _MOST_REMARKS:
        out.print(f"… and {len(odd) - _MOST_REMARKS} more points with remarks.")


_MANY = 12  # names of springs that are listed


def _springs(done: Compensation) -> str:
    """Names of the springs that are compensated."""
    names = done.model.names
    own = [n for n, j in zip(names, done.model.springs.joint.tolist(), strict=True) if j >= 0]
    if len(names) <= _MANY:
        return ", ".join(names)
    return f"{', '.join(own)} and {len(names) - len(own)} springs besides"


def _limit(done: Compensation, residual: Array | None) -> str:
    """What stays below the limit, and whether it does in truth."""
    what = "what was calibrated is" if done.calibrated else "the compliances are"
    said = (
        f"With 95 % the RMS over all points is below {micrometres(done.limit)}, as far as {what} "
        "uncertain"
    )
    if residual is None or not np.isfinite(residual).all():
        return f"{said}."
    size = float(np.sqrt(np.mean(np.sum(residual**2, axis=1))))
    is_ = "is" if size <= done.limit else "is not"
    return f"{said}; in truth it {is_}, and that is without friction and discrepancy there."


def _besides(done: Compensation) -> str:
    """What stands beside ρ0: what the model was seen to lack, and the floor."""
    told = []
    if done.calibrated:
        return (
            f"Beside ρ0 stand {micrometres(done.model.model_error)} that the calibrated robot "
            "leaves of any reading, beyond the noise of the instrument."
        )
    if done.model.model_error > 0.0:
        told.append(
            f"{micrometres(done.model.model_error)} by which left-out experiments were off, more "
            "than their noise explains"
        )
    if done.floor.any():
        size = float(np.sqrt(np.mean(done.floor**2)))
        told.append(f"{micrometres(size)} that no calibration takes away, friction and discrepancy")
    if not told:
        return "ρ0 is without nuisance: friction, links, bearings and foot are not in it."
    return f"Beside ρ0 stand {' and '.join(told)}."


def _mm(length: float) -> str:
    """Millimetres with four digits; what is below a tenth of a nanometre is rounding."""
    return "0" if length < 1e-13 else f"{1e3 * length:.4g}"
