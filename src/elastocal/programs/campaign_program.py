"""The robot program of a calibration campaign: every repeat a full cycle of loading.

In: a study, load cases, repeats. Out: a `RobotProgram`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, IntArray
from elastocal.constraints import margins_at
from elastocal.constraints.watch import watch_of
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError, InputError
from elastocal.motion.margins import Vias, blocked, motion_margins
from elastocal.motion.space import MotionSpace
from elastocal.planning.assessment import TOLERANCE, assess, broken_on_the_way
from elastocal.programs.approach import Approach, approaches
from elastocal.programs.robot_program import (
    Ask,
    Measure,
    Move,
    Provenance,
    RobotProgram,
    Settle,
    Step,
    check_limits,
)
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.study.study import Study
from elastocal.wording import ended, worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import described
from elastocal.wording.watch import watch

ROUNDING = 0.51e-4
"""What a value may be beyond a limit [degrees, mm]: run sheets have four decimals."""
STANDARD_GRAVITY = 9.80665
"""Weight of a kilogram [N/kg], for the masses in messages."""


def campaign_program(
    study: Study,
    cases: LoadCases,
    repeats: IntArray,
    *,
    name: str = "",
    home: ArrayLike | None = None,
    approach: Approach | None = None,
    speed: float = 0.1,
    digest: str = "",
    via: Vias = (),
) -> RobotProgram:
    """Program of a calibration campaign, in the order of the load cases.

    Every repeat is a full cycle: approach from the same side, go to the pose, measure unloaded,
    load, measure loaded, unload. The robot never moves with the load on. Of absolute readings a
    repeat is: approach, pose, measure; what the flange carries, it carries on the way too.

    Args:
        study: The study, from which the load cases are judged again.
        cases: S load cases.
        repeats: (S,) how often each is measured.
        name: Name of the program, the study's if empty.
        home: (n,) where to start and to end [rad or m]; None to start at the first approach point.
        approach: How poses are approached and measured; the usual if None.
        speed: Share of full speed, in (0, 1].
        digest: SHA-256 of the plan file.
        via: Configurations passed on the way, see `motion.Vias`.

    Raises:
        InfeasibleError: load cases or via points break constraints of the study or limits of the
            robot, or a motion collides.
        InputError: an argument is out of range, or a configuration cannot be approached.
    """
    must, rest = broken_on_the_way(study, via)
    if violations := (*assess(study, cases, repeats).violations, *must):
        raise InfeasibleError(worded(violations[0])).with_doubts(*violations)
    approach = approach or Approach()
    robot = study.robot
    q = _inside(robot, cases.q, "load case")
    amount = np.where(robot.prismatic, approach.length, approach.angle) * ~study.held
    before, same = approaches(robot, q, amount, study.bounds, study.constraints, study.motion_space)
    beside = np.stack([_inside(robot, before, "approach point"), q], axis=1).reshape(-1, q.shape[1])
    start, notes = ([], []) if home is None else _home(study, home)
    notes += [f"On the way, where nothing is measured, {ended(worded(doubt))}" for doubt in rest]
    labels = [f"{kind}{i + 1}" for i in range(len(cases)) for kind in ("AP", "P")]
    m = int(np.sum(repeats))
    passed = list(via) or [np.zeros((0, q.shape[1]))] * (len(q) + 1)
    between = _inside(robot, np.concatenate(passed), "via point")
    labels += [f"V{i + 1}" for i in range(len(between))]
    seen = watch_of(study.constraints)
    program = RobotProgram(
        name=name or study.name,
        purpose=f"Calibration campaign: {counted(m, 'experiment')} in "
        f"{counted(len(cases), 'configuration')}.",
        robot=robot,
        targets=np.vstack([*start, beside, between]),
        target_names=(*(["H0"] * len(start)), *labels),
        steps=_steps(
            study, cases, repeats, len(start), approach.settle, [len(part) for part in passed]
        ),
        speed=speed,
        provenance=Provenance(study.name, digest),
        notes=(
            *_notes(bool(start), same, weighs=study.experiments.weighs),
            watch(seen.watched, seen.unwatched),
            *notes,
        ),
        watched=bool(study.motion_space.clearances),
        carries=study.experiments.weighs,
    )
    _refuse_collisions(study.motion_space, program)
    return program


def _inside(robot: Robot, q: Array, what: str) -> Array:
    """Configurations whose values are at a limit of the robot where rounding put them beyond it.

    Raises:
        InfeasibleError: a value is further out; names configuration, joint, value and limit.
    """
    inside = np.clip(q, robot.lower, robot.upper)
    for i, j in np.argwhere(~(robot.shown_scale * np.abs(inside - q) <= ROUNDING)).tolist():
        unit = robot.joints[j].kind.unit
        raise InfeasibleError(
            f"{what} {i + 1} has joint {robot.joint_names[j]!r} at {described(q[i, j], unit, 9)}, "
            f"its limit is {described(inside[i, j], unit, 9)}"
        )
    return inside


def _refuse_collisions(space: MotionSpace, program: RobotProgram) -> None:
    """Refuse a program in which a motion from target to target collides."""
    order = [step.target for step in program.steps if isinstance(step, Move)]
    pairs = list(dict.fromkeys(pairwise(order)))
    if not pairs or not space.clearances:
        return
    starts, goals = (program.targets[[pair[end] for pair in pairs]] for end in (0, 1))
    margins = motion_margins(space, starts, goals)
    for i in np.flatnonzero(~margins.free).tolist():
        names = tuple(program.target_names[target] for target in pairs[i])
        doubt = replace(blocked(margins, i), about=names)
        raise InfeasibleError(worded(doubt)).with_doubts(doubt)


def _notes(home: bool, same: bool, *, weighs: bool) -> tuple[str, ...]:
    notes = ["Forces act at the load point of the tool, in the axes of the robot base."]
    if weighs:
        notes = ["Every pose is measured once, as the arm stands there under what it carries."]
    if not same:
        notes.append("Not all poses are approached from the same side: limits are in the way.")
    if not home:
        notes.append("No home position: the first motion starts where the robot stands.")
    return tuple(notes)


def _steps(
    study: Study,
    cases: LoadCases,
    repeats: IntArray,
    first: int,
    settle: float,
    passed: Sequence[int],
) -> tuple[Step, ...]:
    """All cycles in order; `first` is the number of the first approach point, 1 if home is 0.

    `passed` says how many via points lie before each pose and before the end; those from and to
    home are left out if there is no home.
    """
    after = first + 2 * len(cases)
    ways = np.split(np.arange(after, after + sum(passed)), np.cumsum(passed)[:-1])
    steps: list[Step] = [Move(0)] if first else []
    markers = " ".join(study.experiments.tool.targets)
    m, experiment, approach = int(np.sum(repeats)), 0, first
    carried = np.zeros(6)
    for i, wrench in enumerate(cases.wrench):
        approach = first + 2 * i
        if study.experiments.weighs and (wrench != carried).any():
            steps.append(Ask(f"{carried_text(wrench, study.gravity)} The robot moves next."))
            carried = wrench
        if i or first:
            steps += [Move(target) for target in ways[i].tolist()]
        for _ in range(int(repeats[i])):
            experiment += 1
            head = f"Experiment {experiment}/{m}"
            steps += [Move(approach), Move(approach + 1), Settle(settle)]
            if study.experiments.weighs:
                there = bool(wrench.any())
                text = f"{head}: pose {i + 1}. Measure {markers}."
                steps.append(Measure(text, experiment, i + 1, loaded=there))
                continue
            free = f"{head}: pose {i + 1}. NO load. Measure {markers}."
            bent = f"{head}: pose {i + 1}. LOADED. Measure {markers}."
            steps += [
                Measure(free, experiment, i + 1, loaded=False),
                Ask(f"{head}: {load_text(wrench)}."),
                Settle(settle),
                Measure(bent, experiment, i + 1, loaded=True),
                Ask(f"{head}: take the load off. The robot moves next."),
            ]
    back = [Move(target) for target in ways[-1].tolist()] if first else []
    return (*steps, *back, Move(0 if first else approach))


def carried_text(wrench: Array, gravity: Array) -> str:
    """What the flange is to carry from here on, by its weight under this gravity (3,)."""
    size = float(np.linalg.norm(wrench[:3]))
    if size == 0.0:
        return "Take the payload off the flange."
    return (
        f"Mount the payload of {_plain(size / float(np.linalg.norm(gravity)), 3)} kg on the flange."
    )


def load_text(wrench: Array) -> str:
    """What to load, in words: force, moment, and the mass if it is a hanging weight."""
    force, moment = wrench[:3], wrench[3:]
    size = float(np.linalg.norm(force))
    parts = []
    if size > 0.0 and np.hypot(force[0], force[1]) <= 1e-9 * size and force[2] < 0.0:
        parts.append(f"hang {_plain(size / STANDARD_GRAVITY, 3)} kg")
    elif size > 0.0:
        parts.append(f"apply {_plain(size)} N")
    if size > 0.0:
        parts.append(f"Fx {_plain(force[0])} Fy {_plain(force[1])} Fz {_plain(force[2])} N")
    if np.linalg.norm(moment) > 0.0:
        parts.append(f"Tx {_plain(moment[0])} Ty {_plain(moment[1])} Tz {_plain(moment[2])} N.m")
    return ", ".join(parts)


def _plain(value: float, decimals: int = 2) -> str:
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def _home(study: Study, home: ArrayLike) -> tuple[list[Array], list[str]]:
    """Home within the limits of the robot, and a note on all of the study that it breaks."""
    robot = study.robot
    q = np.asarray(home, dtype=float)
    if q.shape != (len(robot.joints),):
        raise InputError(f"home needs {len(robot.joints)} joint values, found {q.size}")
    check_limits(robot, q[None], ["home"])
    constraints = [c.on_the_way for c in (*study.joint_limits, *study.constraints)]
    room = margins_at(constraints, Posture(robot, q[None]))[:, 0]
    return [q], [
        f"Home breaks {c.name} by {described(-float(margin), c.unit)}."
        for c, margin in zip(constraints, room, strict=True)
        if margin < -TOLERANCE
    ]
