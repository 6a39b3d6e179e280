"""KUKA KRL: a module of .src and .dat for KR C4 and KR C5 (KSS 8), with notes for KR C2.

Names have at most 24 characters; axis values are degrees or millimetres in E6AXIS, axes that the
robot does not have are left out and then stay where they are. Points have names in the .dat as long
as there are few; a long program has them in its motions and is called page by page.

Source: KRL syntax as in KUKA's quick guide for KSS 8; message structures as in the public
reference of System.Messages; frames of modules as in KUKA's templates.
"""

from __future__ import annotations

from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import Axes, axes, readings
from elastocal.programs.writers.names import program_name, words
from elastocal.programs.writers.pages import page_names, paged, room
from elastocal.programs.writers.settings import Settings, output_number
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 24
MOST_MOVES = 1000  # of a page
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
    IR_STOPM P00 P00_EXT MSGLIB USER_GRP USERSPOT USER_SPS BRAKETEST BRAKETESTREQ MASREF_USER
    BAS_COMMAND CELL_EXT H50 HW_INF SPS_USER TM_USEROUTPUT TOOL_CHANGE USR_DATA WEAV_DEF
    NEW_SERV SERVICE STOPMESS COLLDETECT FLT_SERV BACKUP LOADDATA SUCCESS FDAT LDAT PDAT
    KRLMSG_T KRLMSGPAR_T KRLMSGOPT_T KRLMSGDLGSK_T SET_KRLMSG SET_KRLDLG EXISTS_KRLMSG
    CLEAR_KRLMSG GET_MSGBUFFER ABS SQRT SIN COS TAN ACOS ATAN2 INVERSE FORWARD VARSTATE
    STRLEN STRDECLLEN STRCLEAR STRADD STRFIND STRCOMP STRCOPY TIMER CONFIG OPTION
    """
)
_LARGEST = 1e6


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """The two files of a KRL module, and those of its pages."""
    robot = program.robot
    layout = axes(robot, settings, "KRL", 6)
    parts = paged(program.steps, MOST_MOVES)
    points = [f"X{label}" for label in program.target_names]
    longest = LONGEST_NAME - room(len(parts))
    name = program_name(program, settings, "krl", longest, RESERVED | set(points))
    names = page_names(name, len(parts))
    values = readings(
        program, settings, "KRL", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    )
    data = [f"{{{_axis_values(layout, row)}}}" for row in values.tolist()]
    trigger = output_number(settings, "KRL", 1, 4096)
    start = START.format(name=name)
    head = header(program, settings, 100, units="degrees, mm", start=start)
    if len(parts) > 1:
        head += wrapped(f"It calls its {len(parts)} pages, {names[0]} to {names[-1]}.", 100)
    head = [_comment(line) for line in head]
    lines = [*_OPENING, f"DEF {name} ( )", *head]
    lines += [_comment(line) for line in _axis_names(program, layout)]
    percent = max(1, round(100.0 * program.speed))
    tool = "the empty calibration tool" if program.experiments else "the tool of the path"
    lines += [
        ";FOLD INI",
        "  GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
        "  INTERRUPT ON 3",
        "  BAS (#INITMOV,0)",
        f"  BAS (#VEL_PTP,{percent})",
        f"  BAS (#ACC_PTP,{percent})",
        f"  BAS (#TOOL,1) ; {tool}, with its load data",
        "  BAS (#BASE,0)",
        ";ENDFOLD (INI)",
    ]
    said = _SAY_SUBPROGRAM if program.experiments else []
    dat = [*_OPENING, f"DEFDAT {name}", *head, "EXT BAS (BAS_COMMAND :IN,REAL :IN )"]
    if len(parts) == 1:
        dat += [f"DECL E6AXIS {p}={d}" for p, d in zip(points, data, strict=True)]
        lines += [line for step in program.steps for line in _step(step, points, trigger)]
        pages = {}
    else:
        lines += [f"{page} ( )" for page in names]
        pages = {
            f"{page}.src": _text(
                [
                    *_OPENING,
                    f"DEF {page} ( )",
                    *head,
                    *(line for step in part for line in _step(step, data, trigger)),
                    "END",
                    *said,
                ]
            )
            for page, part in zip(names, parts, strict=True)
        }
        said = []
    return {
        f"{name}.src": _text([*lines, "END", *said]),
        f"{name}.dat": _text([*dat, "ENDDAT"]),
        **pages,
    }


_OPENING = ("&ACCESS RVP", "&REL 1")
START = "Start: copy all files of {name} to the controller, select {name}, run it in T1 first."


def _comment(line: str) -> str:
    """A remark; one that begins like a fold is kept from being one."""
    return f"; - {line}" if line.upper().startswith(("FOLD", "ENDFOLD")) else f"; {line}"


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
    f"DEF {SAY} (TEXT[] :IN)",
    "DECL CHAR TEXT[]",
    "; Shows a line in the message window of KSS 8. A KR C2 (KSS 5) has no SET_KRLMSG: put a",
    f"; semicolon before every line that begins with {SAY}, and remove the file's lines from",
    f"; DEF {SAY} on. The operator then reads the lines above each HALT.",
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
