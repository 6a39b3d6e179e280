"""What the command line shows: tables and progress bars, by rich."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from elastocal.arrays import Array
from elastocal.certification import Certificate
from elastocal.certification import Progress as Tell
from elastocal.checkup import Checkup
from elastocal.constraints import describe
from elastocal.criteria import POSITION_ERRORS
from elastocal.evaluation import Evaluation
from elastocal.loads import FixedVector, FreeDirection, Load
from elastocal.planning import Plan
from elastocal.robot import Robot
from elastocal.study import Study

out = Console(highlight=False, soft_wrap=False)
err = Console(stderr=True, highlight=False)


@contextmanager
def progress(title: str) -> Iterator[Tell]:
    """A bar on standard error while something longer than a second runs."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(title, total=1.0)

        def tell(what: str, share: float) -> None:
            bar.update(task, description=f"{title}: {what}", completed=share)

        yield tell


def show_plan(plan: Plan) -> None:
    """The plan as a run sheet, its accuracy and its certificate."""
    worth = plan.assessment
    _whole(_run_sheet(plan.study.robot, plan))
    out.print(Text(f"Nearest constraint of {_nearest(plan)}"))
    if plan.free_joints:
        out.print(Text(f"{', '.join(plan.free_joints)}: free, set as the cell requires."))
    out.print(_errors(plan.study, {"standard error": worth.standard_error}))
    out.print(
        f"ρ0 = [bold]{micrometres(worth.rho0)}[/bold]: root mean square position error "
        "after compensation at the test poses"
    )
    out.print(Text(certificate_sentence(plan.certificate, plan.count)))


def _whole(table: Table) -> None:
    """Print a table without cutting numbers off, wider than the terminal if need be."""
    room = out.options.update(max_width=1000)
    width = max(out.width, Measurement.get(out, room, table).maximum)
    out.print(table, width=width, crop=False, no_wrap=True, overflow="ignore", soft_wrap=True)


def _run_sheet(robot: Robot, plan: Plan) -> Table:
    wrench = plan.load_cases.wrench
    title = f"{plan.count} experiments in {len(plan.repeats)} configurations"
    common = len(np.unique(wrench, axis=0)) == 1
    if common:
        title += f", force [{_vector(wrench[0, :3])}] N"
        if wrench[0, 3:].any():
            title += f", torque [{_vector(wrench[0, 3:])}] N·m"
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("#", justify="right")
    for joint in robot.joints:
        table.add_column(f"{joint.name} {joint.shown[1]}", justify="right")
    if not common:
        table.add_column("force N", justify="right")
    if not common and wrench[:, 3:].any():
        table.add_column("torque N·m", justify="right")
    table.add_column("repeat", justify="right")
    scale = robot.shown_scale
    for i, q in enumerate(plan.load_cases.q):
        cells = [str(i + 1), *(f"{v + 0.0:.2f}" for v in scale * q)]
        if not common:
            cells.append(_vector(wrench[i, :3]))
        if not common and wrench[:, 3:].any():
            cells.append(_vector(wrench[i, 3:]))
        table.add_row(*cells, f"{plan.repeats[i]}×")
    return table


def _nearest(plan: Plan) -> str:
    """Which constraint each configuration is nearest to, configurations of one kind together."""
    groups: dict[str, list[str]] = {}
    for i, near in enumerate(plan.assessment.nearest):
        room = f" ({describe(near.margin, near.unit)})" if near.margin > 1e-6 else " (reached)"
        groups.setdefault(near.name + room, []).append(str(i + 1))
    return "; ".join(f"{', '.join(numbers)}: {name}" for name, numbers in groups.items())


def _vector(vector: Array) -> str:
    return " ".join(f"{value + 0.0:.5g}" for value in vector)


def _errors(study: Study, columns: dict[str, Array]) -> Table:
    from elastocal.io.plan_file import spring_unit

    table = Table(
        title="Standard errors of the compliances", title_justify="left", box=box.SIMPLE_HEAD
    )
    table.add_column("joint")
    for name in columns:
        table.add_column(name, justify="right")
    table.add_column("unit")
    for j, name in enumerate(study.springs.names):
        values = [f"{1e9 * column[j]:.3g}" for column in columns.values()]
        table.add_row(Text(name), *values, Text(f"1e-9 {spring_unit(study.robot, name)}"))
    return table


def certificate_sentence(certificate: Certificate, count: int) -> str:
    """What the certificate says, in words."""
    c = certificate
    if c.kind == "none":
        return (
            f"No certificate: {c.criterion} is not concave, so no bound on the best plan is known."
        )
    share = 100.0 * (1.0 - np.sqrt(min(max(c.efficiency, 0.0), 1.0)))
    room = f"efficiency {c.efficiency:.4f}, at most {share:.2g} % to gain in the error"
    what = {"test-pose": "ρ0", "worst": "worst ρ0", "G": "worst coordinate"}.get(c.criterion)
    if what:
        sentence = f"No plan of {count} experiments has {what} below {micrometres(c.lower_bound)}: "
        sentence += room
    else:
        sentence = f"Against every plan of {count} experiments, by {c.criterion}: {room}"
    sentence += (
        f". Numerical certificate: {c.fresh_starts} fresh random starts did not refute it, "
        f"{c.attained} of them reached the same maximum."
    )
    if c.floored:
        sentence += (
            " The criterion leaves some compliances out; a small floor keeps them identifiable."
        )
    return sentence


def show_check(study: Study, found: Checkup) -> None:
    """What the study means."""
    robot, e = study.robot, study.experiments
    out.print(
        f"[bold]{escape(study.name)}[/bold]: robot {escape(robot.name)}, {len(robot.joints)} joints"
    )
    table = Table(title="Joints", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("joint", "moves", "planned between", "compliance"):
        table.add_column(column)
    for j, joint in enumerate(robot.joints):
        scale, unit = joint.shown
        room = f"{scale * study.limits[0, j]:.6g} … {scale * study.limits[1, j]:.6g} {unit}"
        role = "to identify" if joint.name in study.springs.names else "taken as rigid"
        table.add_row(Text(joint.name), "slides" if joint.prismatic else "turns", room, role)
    out.print(table)
    points = ", ".join(
        f"{name} {_vector(1e3 * point)} mm"
        for name, point in zip(e.tool.marker_names, e.tool.markers, strict=True)
    )
    out.print(
        Text(
            f"Calibration tool {e.tool.name!r}: load at {_vector(1e3 * e.tool.load_point)} "
            f"mm of the flange, measured: {points}"
        )
    )
    out.print(Text(f"Load: {_load(e.force, 'N')}; torque: {_load(e.moment, 'N·m')}; base frame"))
    for pose in study.test_poses:
        out.print(Text(f"Test pose {pose.name!r} (weight {pose.weight:g}): {_pose(study, pose)}"))
    least = f", at most {e.max_configurations} configurations" if e.max_configurations else ""
    out.print(
        f"{e.count} experiments{least}; criterion {study.criterion}; "
        f"σ = {1e3 * study.sigma:g} mm per coordinate"
    )
    out.print(
        f"The load point reaches {found.reach:.3f} m from the base; "
        f"{100 * found.feasible_share:.3g} % of random configurations are feasible"
        + (f", most are refused by: {escape(found.bottleneck)}" if found.bottleneck else "")
    )
    for remark in found.remarks:
        out.print(Text(f"Note: {remark}.", style="yellow"))
    if found.problem is None:
        out.print(f"[green]Identifiable:[/green] {escape(', '.join(study.springs.names))}")


def _load(load: Load, unit: str) -> str:
    if isinstance(load, FixedVector):
        return f"fixed [{_vector(load.value)}] {unit}" if load.size else "none"
    assert isinstance(load, FreeDirection)
    where = (
        f"within {np.degrees(load.half_angle):g}° of [{' '.join(f'{v:g}' for v in load.axis)}]"
        if load.is_cone
        else "in any direction"
    )
    return f"up to {load.largest:g} {unit} {where}"


def _pose(study: Study, pose: Any) -> str:
    if pose.case is None:
        return "given as a matrix"
    scale = study.robot.shown_scale
    values = " ".join(f"{v + 0.0:.1f}" for v in scale * pose.case.q[0])
    return f"q = {values}, force {_vector(pose.case.wrench[0, :3])} N at {pose.tool.name!r}"


def show_evaluations(
    study: Study, results: dict[str, tuple[int, int, Evaluation]], random: dict[int, Array]
) -> None:
    """Plans side by side: name → (experiments, configurations, evaluation).

    `random` has ρ0 of random plans for each number of experiments.
    """
    table = Table(
        title=f"Plans under study {study.name!r}", title_justify="left", box=box.SIMPLE_HEAD
    )
    for column in ("plan", "m", "configs", "ρ0", "bound", "efficiency", "verdict"):
        table.add_column(column, justify="left" if column in ("plan", "verdict") else "right")
    for name, (count, configurations, result) in results.items():
        proof = result.certificate
        known = proof.kind != "none"
        length = known and proof.criterion in POSITION_ERRORS
        bound = micrometres(proof.lower_bound) if length else "–"
        verdict = Text("holds", "green") if result.accepted else Text("refused", "bold red")
        table.add_row(
            Text(name),
            str(count),
            str(configurations),
            micrometres(result.assessment.rho0),
            bound,
            f"{proof.efficiency:.4f}" if known else "–",
            verdict,
        )
    _whole(table)
    errors = {name: result.assessment.standard_error for name, (_, _, result) in results.items()}
    out.print(_errors(study, errors))
    for name, (_, _, result) in results.items():
        for sentence in (*result.objections, *result.unidentified):
            out.print(Text(f"{name}: {sentence}", "red"))
    for m, rho0 in random.items():
        low, middle, high = np.quantile(rho0, (0.05, 0.5, 0.95), method="inverted_cdf")
        out.print(
            f"{len(rho0)} random feasible plans of {m} experiments: ρ0 median "
            f"{micrometres(middle)}, 5 % below {micrometres(low)}, 95 % below {micrometres(high)}"
        )
        for name, (count, _, result) in results.items():
            if count == m:
                better = float((rho0 < result.assessment.rho0).mean())
                factor = middle / result.assessment.rho0
                out.print(
                    Text(
                        f"{name}: {factor:.2f}× better than the random median, "
                        f"{100 * better:.3g} % of random plans are better"
                    )
                )


def micrometres(length: float) -> str:
    """A length in micrometres, or millimetres if it is large."""
    if not np.isfinite(length):
        return "∞"
    return f"{1e6 * length:.4g} µm" if abs(length) < 1e-3 else f"{1e3 * length:.4g} mm"
