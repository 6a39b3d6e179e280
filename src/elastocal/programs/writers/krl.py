"""KUKA KRL: a module of .src and .dat for KR C4 and KR C5 (KSS 8), with notes for KR C2.

Names have at most 24 characters; axis values are degrees or millimetres in E6AXIS, axes that the
robot does not have are left out and then stay where they are.

Source: KRL syntax as in KUKA's quick guide for KSS 8; message structures as in the public
reference of System.Messages.
"""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import Axes, axes, readings
from elastocal.programs.writers.names import identifier, words
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 24
MESSAGE = 78  # of 80 characters in a message
SAY = "EC_SAY"
RESERVED = words(
    """
    AND ANIN ANOUT B_AND B_EXOR B_NOT B_OR BOOL BRAKE CASE CAST_FROM CAST_TO CCLOSE CHANNEL
    CHAR CIOCTL CIRC CIRC_REL CONFIRM CONST CONTINUE COPEN CREAD CWRITE DECL DEF DEFAULT
    DEFDAT DEFFCT DELAY DIGIN DISTANCE DO ELSE END ENDDAT ENDFCT ENDFOR ENDIF ENDLOOP
    ENDSPLINE ENDSWITCH ENDWHILE ENUM ERR_RAISE EXIT EXOR EXT EXTFCT FALSE FOR FRAME GLOBAL
    GOTO HALT IF IMPORT INI INT INTERRUPT IS LIN LIN_REL LOOP MAXIMUM MINIMUM NOT OFF ON OR
    PATH POS PRIO PTP PTP_REL PUBLIC PULSE REAL REPEAT RESUME RETURN SCIRC SEC SIGNAL SLIN
    SPL SPLINE SPTP SREAD STRUC SWITCH SWRITE THEN TO TRIGGER TRUE UNTIL WAIT WHEN WHILE
    AXIS E6AXIS E6POS BAS HOME CELL SPS EC_SAY A1 A2 A3 A4 A5 A6 E1 E2 E3 E4 E5 E6
    """
)
_LARGEST = 1e6


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """The two files of a KRL module."""
    robot = program.robot
    layout = axes(robot, settings, "KRL", 6)
    points = [f"X{label}" for label in program.target_names]
    name = identifier(program.name, LONGEST_NAME, RESERVED | set(points))
    values = readings(
        program, settings, "KRL", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    )
    data = [_axis_values(layout, row.tolist()) for row in values]
    trigger = _output(settings.trigger)
    lines = ["&ACCESS RVP", "&REL 1", f"DEF {name} ( )"]
    lines += [f"; {line}" for line in header(program, settings, 100, units="degrees, mm")]
    lines += [f"; {line}" for line in _axis_names(program, layout)]
    percent = max(1, round(100.0 * program.speed))
    lines += [
        ";FOLD INI",
        "  BAS (#INITMOV,0)",
        f"  BAS (#VEL_PTP,{percent})",
        f"  BAS (#ACC_PTP,{percent})",
        "  BAS (#TOOL,1) ; the empty calibration tool, with its load data",
        "  BAS (#BASE,0)",
        ";ENDFOLD (INI)",
    ]
    for step in program.steps:
        lines += _step(step, points, trigger)
    lines.append("END")
    if program.experiments:
        lines += _SAY_SUBPROGRAM
    declared = [f"DECL E6AXIS {p}={{{d}}}" for p, d in zip(points, data, strict=True)]
    dat = ["&ACCESS RVP", "&REL 1", f"DEFDAT {name}"]
    dat += [f"; {line}" for line in header(program, settings, 100, units="degrees, mm")]
    dat += ["EXT BAS (BAS_COMMAND :IN,REAL :IN )", *declared, "ENDDAT"]
    return {f"{name}.src": _text(lines), f"{name}.dat": _text(dat)}


def _text(lines: list[str]) -> str:
    return "\n".join(lines) + "\n"


def _labels(layout: Axes) -> list[str]:
    return [f"A{i + 1}" for i in range(len(layout.arm))] + [
        f"E{i + 1}" for i in range(len(layout.external))
    ]


def _axis_values(layout: Axes, row: list[float]) -> str:
    pairs = zip(_labels(layout), layout.order, strict=True)
    return ",".join(f"{label} {row[i]:.4f}" for label, i in pairs)


def _axis_names(program: RobotProgram, layout: Axes) -> list[str]:
    """Which joint of the model is which axis, where the names differ."""
    names = program.robot.joint_names
    pairs = zip(_labels(layout), layout.order, strict=True)
    different = [f"{label} is {names[i]}" for label, i in pairs if names[i] != label]
    return wrapped(f"Axes: {', '.join(different)}.", 100) if different else []


def _output(trigger: str) -> int | None:
    if not trigger:
        return None
    if not trigger.isdigit() or not 1 <= int(trigger) <= 4096:
        raise InputError(f"KRL outputs have numbers from 1 to 4096, found {trigger[:40]!r}")
    return int(trigger)


def _step(step: Step, points: list[str], trigger: int | None) -> list[str]:
    if isinstance(step, Move):
        return [f"PTP {points[step.target]}"]
    if isinstance(step, Settle):
        return [f"WAIT SEC {step.seconds:.2f}"]
    assert isinstance(step, Ask | Measure)
    said = [f'{SAY} ("{line}")' for line in wrapped(step.text, MESSAGE)]
    pulse = isinstance(step, Measure) and trigger is not None
    return [*said, *([f"PULSE ($OUT[{trigger}],TRUE,0.5)"] if pulse else []), "HALT"]


_SAY_SUBPROGRAM = [
    "",
    f"DEF {SAY} (TEXT[] :OUT)",
    "DECL CHAR TEXT[]",
    "; Shows a line in the message window. On a KR C2 (KSS 5) remove the lines from",
    "; here to END: the operator then reads the line above each HALT.",
    "DECL KRLMSG_T EC_MSG",
    "DECL KRLMSGPAR_T EC_PAR[3]",
    "DECL KRLMSGOPT_T EC_OPT",
    "DECL INT EC_HANDLE",
    'EC_MSG={MODUL[] "ELASTOCAL",NR 1,MSG_TXT[] " "}',
    "EC_MSG.MSG_TXT[]=TEXT[]",
    "EC_PAR[1]={PAR_TYPE #EMPTY}",
    "EC_PAR[2]={PAR_TYPE #EMPTY}",
    "EC_PAR[3]={PAR_TYPE #EMPTY}",
    "EC_OPT={VL_STOP TRUE,CLEAR_P_RESET TRUE,CLEAR_P_SR FALSE,LOG_TO_DB FALSE}",
    "EC_HANDLE=SET_KRLMSG(#NOTIFY,EC_MSG,EC_PAR[],EC_OPT)",
    "END",
]
