"""ABB RAPID: one module for IRC5 and OmniCore.

Identifiers have at most 32 characters, strings 80. Targets are jointtarget values in degrees and
millimetres; unused external axes are 9E9, axes that an arm with fewer than six joints lacks are 0.

Source: RAPID reference manuals of ABB (instructions, data types, kernel).
"""

from __future__ import annotations

import re

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import ARM_AXES, Axes, axes, readings
from elastocal.programs.writers.names import identifier, words
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 32
DISPLAY = 40  # characters on a line of the pendant
RESERVED = words(
    """
    ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF
    ENDMODULE ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO
    IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY
    RETURN STEP SYSMODULE TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR
    MAIN USER BASE NUM BOOL STRING JOINTTARGET ROBTARGET TOOLDATA WOBJDATA SPEEDDATA
    ZONEDATA TOOL0 WOBJ0 FINE V1000
    """
)
_LARGEST = 1e6
_RUN = "Run_"
_ANSWER = "nAnswer"


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One module with one procedure to call."""
    robot = program.robot
    layout = axes(robot, settings, "RAPID", 6)
    points = [f"j{label}" for label in program.target_names]
    taken = RESERVED | set(points) | {_ANSWER}
    name = identifier(program.name, LONGEST_NAME - len(_RUN), taken)
    values = readings(
        program, settings, "RAPID", scale=robot.shown_scale, decimals=4, largest=_LARGEST
    )
    trigger = _signal(settings.trigger)
    lines = [f"MODULE {name}"]
    lines += [f"  ! {line}" for line in header(program, settings, 76, units="degrees, mm")]
    lines += [f"  ! {line}" for line in _axis_names(program, layout)]
    lines.append("  ! Replace tool0 by your tool, with its load.")
    for point, row in zip(points, values.tolist(), strict=True):
        lines.append(f"  CONST jointtarget {point}:={_target(layout, row)};")
    if program.experiments:
        lines.append(f"  VAR num {_ANSWER}:=0;")
    percent = max(1, round(100.0 * program.speed))
    lines += ["", f"  PROC {_RUN}{name}()", f"    VelSet {percent},1000;"]
    for step in program.steps:
        lines += [f"    {line}" for line in _step(step, points, trigger)]
    lines += ["    VelSet 100,5000;", "  ENDPROC", "ENDMODULE"]
    return {f"{name}.mod": "\n".join(lines) + "\n"}


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
