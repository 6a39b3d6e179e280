"""FANUC: one teach pendant program as ASCII (.ls) for R-30iA and later.

Names have sixteen characters: controllers print programs with up to seventeen; remarks 32, messages
24. Positions are joint values in degrees and millimetres of motion group 1: J1 to J6, then E1 to
E3. A program holds so many positions and lines; a longer one is called page by page.

Source: programs printed by controllers, in public repositories; operator's manuals of FANUC.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import Axes, axes, readings
from elastocal.programs.writers.names import DEVICES, identifier, program_name, words
from elastocal.programs.writers.pages import page_names, paged, room
from elastocal.programs.writers.settings import Settings, output_number
from elastocal.programs.writers.wording import header, wrapped
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import has_forearm

LONGEST_NAME = 16
REMARK = 32
MESSAGE = 24
MOST_LINES = 9999
MOST_POSITIONS = 1000
MOST_MOVES = 500  # of a page
RESERVED = words(
    """
    ABORT CALL DISPENSE END ENDFOR FOR IF JMP LBL MAIN MESSAGE MONITOR
    OFFSET PAUSE RUN SELECT SKIP TIMER WAIT
    """
)
ELEVATION = (
    "FANUC arms show J3 as the elevation of the forearm, which J2 does not change; here it is that "
    "of the model: if this arm does so, say controller: {preset: fanuc} in the study first."
)
_LARGEST = 1e5  # ten characters with sign, point and four decimals


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One program, and one for each page."""
    robot = program.robot
    layout = axes(robot, settings, "a FANUC motion group", 3)
    trigger = output_number(settings, "FANUC", 1, 9999)
    percent = max(1, round(100.0 * program.speed))

    def body(steps: Sequence[Step], numbers: Mapping[int, int]) -> list[str]:
        labels = program.target_names
        return [li for s in steps for li in _step(s, labels, numbers, percent, trigger)]

    # A page has room for the lines of its head besides.
    whole = range(len(program.target_names))
    numbered = {target: target + 1 for target in whole}
    parts = [list(program.steps)]
    if len(whole) > MOST_POSITIONS or len(body(program.steps, numbered)) > MOST_LINES - _HEAD:
        most = MOST_LINES - _HEAD
        parts = paged(program.steps, MOST_MOVES, most, lambda s: len(body([s], numbered)))
    longest = LONGEST_NAME - room(len(parts))
    name = program_name(program, _upper(settings), "fanuc", longest, RESERVED).upper()
    names = page_names(name, len(parts))
    values = readings(
        program, settings, "FANUC", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    ).tolist()
    head = header(
        program,
        settings,
        REMARK,
        units="deg, mm",
        start=START.format(name=name),
        shows=shows(robot, settings),
    )
    if len(parts) > 1:
        head += wrapped(f"It calls its {len(parts)} pages, {names[0]} to {names[-1]}.", REMARK)
    top = [f"  !{line} ;" for line in head]
    frames = ["  UFRAME_NUM=0 ;", "  UTOOL_NUM=1 ;"]
    files = {}
    if len(parts) > 1:
        calls = [f"  CALL {page}    ;" for page in names]
        files[f"{name}.ls"] = _program(name, [*top, *frames, *calls], [])
    for page, part in zip(names, parts, strict=True):
        used = dict.fromkeys(step.target for step in part if isinstance(step, Move))
        targets = list(used) if len(parts) > 1 else list(whole)
        numbers = {target: i for i, target in enumerate(targets, 1)}
        positions = [
            line
            for target, i in numbers.items()
            for line in _position(i, program, layout, values[target])
        ]
        files[f"{page}.ls"] = _program(page, [*top, *frames, *body(part, numbers)], positions)
    return files


def shows(robot: Robot, settings: Settings) -> str:
    """What this controller may show otherwise than the model; empty if that is settled."""
    return "" if settings.converted or not has_forearm(robot) else ELEVATION


_HEAD = 400  # lines that are kept free for the header of a page
START = "Start: load all of {name}, select {name}, run it in T1 first."


def _upper(settings: Settings) -> Settings:
    """Settings whose name, if given, is as the controller shows it.

    Raises:
        InputError: it has small letters.
    """
    name = settings.name
    if name != name.upper():
        upper = identifier(name, LONGEST_NAME, {*RESERVED, *DEVICES}).upper()
        raise InputError(f"{name}: not a program name for fanuc, {upper!r} would be one")
    return settings


def _program(name: str, body: list[str], positions: list[str]) -> str:
    if len(body) > MOST_LINES:
        raise InputError(
            f"a FANUC program takes {MOST_LINES} lines, {name} would have {len(body)}: texts of "
            "its header or of one stop are too long"
        )
    lines = _attributes(name, len(body))
    lines += [f"{number:4d}:{line}" for number, line in enumerate(body, 1)]
    return "\n".join([*lines, "/POS", *positions, "/END"]) + "\n"


def _attributes(name: str, count: int) -> list[str]:
    return [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER\t\t= MNEDITOR;",
        'COMMENT\t\t= "elastocal";',
        "PROG_SIZE\t= 0;",
        f"CREATE\t\t= {_DATE};",
        f"MODIFIED\t= {_DATE};",
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


_DATE = "DATE 00-01-01  TIME 00:00:00"  # the same plan gives the same file, whenever it is made


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


def _step(
    step: Step,
    labels: tuple[str, ...],
    numbers: Mapping[int, int],
    percent: int,
    trigger: int | None,
) -> list[str]:
    if isinstance(step, Move):
        note = f"  !to {labels[step.target]} ;"
        return [note, f"J P[{numbers[step.target]}] {percent}% FINE    ;"]
    if isinstance(step, Settle):
        return [f"  WAIT {step.seconds:6.2f}(sec) ;"]
    assert isinstance(step, Ask | Measure)
    lines = [f"  MESSAGE[{line}] ;" for line in wrapped(step.text, MESSAGE)]
    if isinstance(step, Measure) and trigger is not None:
        lines.append(f"  DO[{trigger}]=PULSE,0.5sec ;")
    return [*lines, "  PAUSE ;"]
