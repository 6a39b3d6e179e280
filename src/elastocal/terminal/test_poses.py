"""What plans are worth at each test pose, and along paths."""

from __future__ import annotations

from collections.abc import Mapping

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.planning.along_paths import Shares
from elastocal.planning.assessment import Assessment
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath
from elastocal.terminal.console import micrometres, whole
from elastocal.wording.lists import counted


def show_test_poses(study: Study, plans: Mapping[str, Assessment], better: Shares) -> None:
    """Errors at the test poses, plan by plan; nothing if all are plain poses that count.

    Args:
        study: The study.
        plans: What plans are worth, by name; without a name in a table of one.
        better: How often each plan is better than the first, along paths; see `better_along`.
    """
    if all(pose.weight and not isinstance(pose, TestPath) for pose in study.test_poses):
        return
    first, several = next(iter(plans), ""), len(plans) > 1
    table = Table(title="At the test poses", title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("test pose")
    if several:
        table.add_column("plan")
    for column in ("share", "ρ0", "worst", "at point"):
        table.add_column(column, justify="right")
    if several:
        table.add_column(Text(f"better than {first}"), justify="right")
    for i, (pose, share) in enumerate(zip(study.test_poses, study.shares, strict=True)):
        label = pose.name
        if isinstance(pose, TestPath):
            label += f" ({counted(len(pose.cases), 'point')})"
        for name, worth in plans.items():
            worst = worth.worst_points[i]
            cells = [Text(label)]
            if several:
                cells.append(Text(name))
            cells.append(Text(f"{100 * share:.3g} %" if share else "judged only"))
            cells.append(Text(micrometres(worth.rho0_each[i])))
            cells.append(Text("" if worst is None else micrometres(worst.rho0)))
            cells.append(Text("" if worst is None else worst.name))
            if several:
                found = better.get(pose.name, {}).get(name, {}).get(first)
                cells.append(Text("" if found is None else f"at {100 * found:.3g} % of points"))
            table.add_row(*cells)
            label = ""
    whole(table)


def where_judged(study: Study) -> str:
    """Where the accuracy of plans is judged, in a few words."""
    path = study.only_path
    return f"along the {len(path.cases)} points of {path.name}" if path else "at the test poses"
