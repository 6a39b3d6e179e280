"""ABB RAPID: one module for IRC5 and OmniCore.

Identifiers have at most 32 characters, strings 80. Targets are jointtarget values in degrees and
millimetres; unused external axes are 9E9, axes that an arm with fewer than six joints lacks are 0.
Data are local, so that modules can stand side by side in one task; a long program has its targets
in its motions and is called page by page, each page a module of its own.

Source: RAPID reference manuals of ABB (instructions, data types, kernel).
"""

from __future__ import annotations

import re

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import ARM_AXES, Axes, axes, readings
from elastocal.programs.writers.names import program_name, words
from elastocal.programs.writers.pages import page_names, paged, room
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import has_forearm

LONGEST_NAME = 32
MOST_MOVES = 2000  # of a page
DISPLAY = 40  # characters on a line of the pendant
RESERVED = words(
    """
    ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF
    ENDMODULE ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO
    IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY
    RETURN STEP SYSMODULE TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR
    MAIN USER BASE NUM BOOL STRING JOINTTARGET ROBTARGET TOOLDATA WOBJDATA SPEEDDATA
    ZONEDATA TOOL0 WOBJ0 FINE LOAD0 VMAX PI HIGH LOW EDGE STEMPTY LOADDATA POS ORIENT POSE
    CONFDATA ROBJOINT EXTJOINT SIGNALDO SIGNALDI CLOCK INTNUM ERRNUM BYTE DNUM SWITCH
    MOVEJ MOVEL MOVEC MOVEABSJ MOVEEXTJ STOP WAITTIME WAITUNTIL WAITDI WAITDO TPWRITE TPERASE
    TPREADFK TPREADNUM VELSET ACCSET PULSEDO SET RESET SETDO SETAO INCR DECR ADD CLEAR OPEN
    CLOSE CONFJ CONFL SINGAREA GRIPLOAD LOAD UNLOAD BREAK OFFS RELTOOL CROBT CJOINTT CALCROBT
    CALCJOINTT ABS SQRT SIN COS TAN ROUND TRUNC STRLEN STRPART NUMTOSTR
    V5 V10 V20 V30 V40 V50 V60 V80 V100 V150 V200 V300 V400 V500 V600 V800 V1000 V1500 V2000
    V2500 V3000 V4000 V5000 V6000 V7000 Z0 Z1 Z5 Z10 Z15 Z20 Z30 Z40 Z50 Z60 Z80 Z100 Z150 Z200
    """
)
ROD = (
    "Something follows {third}, as a rod does that moves the forearm: ABB arms with such a rod "
    "show {third} as the angle of the forearm to the base, here it is that of the model; if this "
    "arm does so, say controller: {{couple: {{{third}: {{{second}: 1}}}}}} in the study first."
)
_LARGEST = 1e6
_RUN = "Run_"
_ANSWER = "nAnswer"


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One module with one procedure to call, and one for each page."""
    robot = program.robot
    layout = axes(robot, settings, "RAPID", 6)
    parts = paged(program.steps, MOST_MOVES)
    points = [f"j{label}" for label in program.target_names]
    longest = LONGEST_NAME - len(_RUN) - room(len(parts))
    name = program_name(program, settings, "rapid", longest, RESERVED | set(points) | {_ANSWER})
    names = page_names(name, len(parts))
    values = readings(
        program, settings, "RAPID", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    )
    data = [_target(layout, row) for row in values.tolist()]
    trigger = _signal(settings.trigger)
    head = header(
        program,
        settings,
        76,
        units="degrees, mm",
        start=START.format(name=name),
        shows=shows(robot, settings),
    )
    if len(parts) > 1:
        pages = f"{names[0]} to {names[-1]}"
        head += wrapped(f"It calls its {len(parts)} pages, the modules {pages}.", 76)
    head += [*_axis_names(program, layout), "Replace tool0 by your tool, with its load."]
    top = [f"  ! {line}" for line in head]
    answer = [f"  LOCAL VAR num {_ANSWER}:=0;"] if program.experiments else []
    percent = max(1, round(100.0 * program.speed))
    lines = [f"MODULE {name}", *top]
    files = {}
    if len(parts) == 1:
        for point, target in zip(points, data, strict=True):
            lines.append(f"  LOCAL CONST jointtarget {point}:={target};")
        lines += answer
        body = [line for step in program.steps for line in _step(step, points, trigger)]
    else:
        body = [f"{_RUN}{page};" for page in names]
        for page, part in zip(names, parts, strict=True):
            inside = [line for step in part for line in _step(step, data, trigger)]
            files[f"{page}.mod"] = _module([f"MODULE {page}", *top, *answer], page, inside)
    body = [f"VelSet {percent},1000;", *body, "VelSet 100,5000;"]
    return {f"{name}.mod": _module(lines, name, body), **files}


START = "Start: load every module of {name} into the task that moves the robot, call Run_{name}."


def shows(robot: Robot, settings: Settings) -> str:
    """What this controller may show otherwise than the model; empty if that is settled."""
    if settings.converted or not has_forearm(robot):
        return ""
    _, second, third = [joint.name for joint in robot.joints if not joint.prismatic][:3]
    rods = any(follower.leader == third for follower in robot.followers)
    return ROD.format(second=second, third=third) if rods else ""


def _module(head: list[str], name: str, body: list[str]) -> str:
    inside = ["", f"  PROC {_RUN}{name}()", *(f"    {line}" for line in body), "  ENDPROC"]
    return "\n".join([*head, *inside, "ENDMODULE"]) + "\n"


def _target(layout: Axes, row: list[float]) -> str:
    arm = [f"{row[i]:.4f}" for i in layout.arm] + ["0"] * (ARM_AXES - len(layout.arm))
    outside = [f"{row[i]:.4f}" for i in layout.external] + ["9E9"] * (6 - len(layout.external))
    return f"[[{','.join(arm)}],[{','.join(outside)}]]"


def _axis_names(program: RobotProgram, layout: Axes) -> list[str]:
    names = program.robot.joint_names
    arm = [f"rax_{k + 1} {names[i]}" for k, i in enumerate(layout.arm)]
    outside = [f"eax_{'abcdef'[k]} {names[i]}" for k, i in enumerate(layout.external)]
    return wrapped(f"Axes: {', '.join([*arm, *outside])}.", 76)


def _signal(trigger: str) -> str:
    if trigger and not re.fullmatch(rf"[A-Za-z]\w{{0,{LONGEST_NAME - 1}}}", trigger, re.ASCII):
        raise InputError(
            f"RAPID outputs have names of letters, digits and underscores, found {trigger[:40]!r}"
        )
    return trigger


def _step(step: Step, points: list[str], trigger: str) -> list[str]:
    if isinstance(step, Move):
        return [f"MoveAbsJ {points[step.target]}\\NoEOffs,v1000,fine,tool0;"]
    if isinstance(step, Settle):
        return [f"WaitTime \\InPos,{step.seconds:.2f};"]
    assert isinstance(step, Ask | Measure)
    lines = ["TPErase;"] + [f'TPWrite "{line}";' for line in wrapped(step.text, DISPLAY)]
    if isinstance(step, Measure) and trigger:
        lines.append(f"PulseDO \\PLength:=0.5,{trigger};")
    empty = ",".join(["stEmpty"] * 4)
    return [*lines, f'TPReadFK {_ANSWER},"Done? Then go on.",{empty},"Go on";']
