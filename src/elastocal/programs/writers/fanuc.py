"""FANUC: one teach pendant program as ASCII (.ls) for R-30iA and later.

Names have eight characters, which every controller takes; remarks 32, messages 24. Positions are
joint values in degrees and millimetres of motion group 1: J1 to J6, then E1 to E3.

Source: programs printed by controllers, in public repositories; operator's manuals of FANUC.
"""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import Axes, axes, readings
from elastocal.programs.writers.names import identifier, words
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 8
REMARK = 32
MESSAGE = 24
MOST_LINES = 9999
MOST_POSITIONS = 1000
RESERVED = words(
    """
    CON PRN AUX NUL COM1 COM2 COM3 COM4 COM5 COM6 COM7 COM8 COM9 LPT1 LPT2 LPT3 LPT4 LPT5
    LPT6 LPT7 LPT8 LPT9 ABORT CALL DISPENSE END ENDFOR FOR IF JMP LBL MAIN MESSAGE MONITOR
    OFFSET PAUSE RUN SELECT SKIP TIMER WAIT
    """
)
_LARGEST = 1e5  # ten characters with sign, point and four decimals


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One program."""
    robot = program.robot
    layout = axes(robot, settings, "a FANUC motion group", 3)
    name = identifier(program.name, LONGEST_NAME, RESERVED).upper()
    values = readings(
        program, settings, "FANUC", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    )
    trigger = _output(settings.trigger)
    body = [f"  !{line} ;" for line in header(program, settings, REMARK, units="deg, mm")]
    body += ["  UFRAME_NUM=0 ;", "  UTOOL_NUM=1 ;"]
    percent = max(1, round(100.0 * program.speed))
    for step in program.steps:
        body += _step(step, program.target_names, percent, trigger)
    if len(body) > MOST_LINES or len(values) > MOST_POSITIONS:
        raise InputError(
            f"the program has {len(body)} lines and {len(values)} positions, a FANUC program "
            f"takes {MOST_LINES} and {MOST_POSITIONS}; split the plan"
        )
    lines = _attributes(name, len(body))
    lines += [f"{number:4d}:{line}" for number, line in enumerate(body, 1)]
    lines.append("/POS")
    for number, row in enumerate(values.tolist(), 1):
        lines += _position(number, program, layout, row)
    lines.append("/END")
    return {f"{name}.ls": "\n".join(lines) + "\n"}


def _attributes(name: str, count: int) -> list[str]:
    return [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER\t\t= MNEDITOR;",
        'COMMENT\t\t= "elastocal";',
        "PROG_SIZE\t= 0;",
        "FILE_NAME\t= ;",
        "VERSION\t\t= 0;",
        f"LINE_COUNT\t= {count};",
        "MEMORY_SIZE\t= 0;",
        "PROTECT\t\t= READ_WRITE;",
        "TCD:  STACK_SIZE\t= 0,",
        "      TASK_PRIORITY\t= 50,",
        "      TIME_SLICE\t= 0,",
        "      BUSY_LAMP_OFF\t= 0,",
        "      ABORT_REQUEST\t= 0,",
        "      PAUSE_REQUEST\t= 0;",
        "DEFAULT_GROUP\t= 1,*,*,*,*;",
        "CONTROL_CODE\t= 00000000 00000000;",
        "/MN",
    ]


def _position(number: int, program: RobotProgram, layout: Axes, row: list[float]) -> list[str]:
    labels = [f"J{i + 1}" for i in range(len(layout.arm))]
    labels += [f"E{i + 1}" for i in range(len(layout.external))]
    joints = program.robot.joints
    cells = [
        f"{label}={row[i]:10.4f} {joints[i].kind.key:>3}"
        for label, i in zip(labels, layout.order, strict=True)
    ]
    rows = ["\t" + ",\t".join(cells[k : k + 3]) for k in range(0, len(cells), 3)]
    return [
        f"P[{number}]{{",
        "   GP1:",
        "\tUF : 0, UT : 1,\t",
        *(f"{line}," for line in rows[:-1]),
        rows[-1],
        "};",
    ]


def _output(trigger: str) -> int | None:
    if not trigger:
        return None
    if not trigger.isdigit() or not 1 <= int(trigger) <= 9999:
        raise InputError(f"FANUC outputs have numbers from 1 to 9999, found {trigger[:40]!r}")
    return int(trigger)


def _step(step: Step, labels: tuple[str, ...], percent: int, trigger: int | None) -> list[str]:
    if isinstance(step, Move):
        note = f"  !to {labels[step.target]} ;"
        return [note, f"J P[{step.target + 1}] {percent}% FINE    ;"]
    if isinstance(step, Settle):
        return [f"  WAIT {step.seconds:6.2f}(sec) ;"]
    assert isinstance(step, Ask | Measure)
    text = step.text.replace(";", ",").replace("[", "(").replace("]", ")")
    lines = [f"  MESSAGE[{line}] ;" for line in wrapped(text, MESSAGE)]
    if isinstance(step, Measure) and trigger is not None:
        lines.append(f"  DO[{trigger}]=PULSE,0.5sec ;")
    return [*lines, "  PAUSE ;"]
