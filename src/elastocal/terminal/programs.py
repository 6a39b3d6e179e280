"""What a robot program does, for the one who wrote it."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle
from elastocal.terminal.console import out, whole


def show_program(program: RobotProgram, controller: str, *, coupled: bool, shows: str) -> None:
    """Targets, and what is done in which order.

    `coupled` if joint values were converted; `shows` is what the controller may show otherwise.
    """
    robot = program.robot
    table = Table(
        title=Text(f"{program.name}: {program.purpose}"),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
    )
    table.add_column("target")
    for joint in robot.joints:
        table.add_column(Text(f"{joint.name} {joint.kind.shown_unit}"), justify="right")
    table.add_column("visits", justify="right")
    visits = [step.target for step in program.steps if isinstance(step, Move)]
    for i, (label, q) in enumerate(zip(program.target_names, program.targets, strict=True)):
        values = [f"{value:z.3f}" for value in robot.shown_scale * q]
        table.add_row(label, *values, f"{visits.count(i)}×")
    whole(table)
    out.print(Text("Joint values of the model; AP: approach point, P: pose, H: home."))
    waits = sum(step.seconds for step in program.steps if isinstance(step, Settle))
    stops = sum(isinstance(step, Ask | Measure) for step in program.steps)
    measured = sum(isinstance(step, Measure) for step in program.steps)
    out.print(
        Text(
            f"{controller}: {len(visits)} motions at {100.0 * program.speed:g} % speed, "
            f"{measured} measurements, {stops} stops for the operator, {waits:g} s of settling."
        )
    )
    notes = [*program.notes]
    if not coupled:
        notes.append(
            "Joint values are the model's: compare one pose with the controller's display."
        )
    notes += [shows] * bool(shows)
    for note in notes:
        out.print(Text(f"Note: {note}", style="yellow"))
    out.print(Text("Check the program at low speed first.", style="bold"))
