"""Robot programs, before any controller's language: targets in joint space and what is done there.

In: a study with load cases and repeats, or a path. Out: a `RobotProgram`, which the writers in
`io/exports` turn into files.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from elastocal import __version__
from elastocal.approach import approaches
from elastocal.arrays import Array, IntArray, frozen
from elastocal.assessment import assess
from elastocal.constraints import describe, margins_at
from elastocal.errors import InfeasibleError, InputError
from elastocal.load_case import LoadCases
from elastocal.posture import Posture
from elastocal.robot import Robot
from elastocal.study import Study

STANDARD_GRAVITY = 9.80665
"""Weight of a kilogram [N/kg], for the masses in messages."""
LONGEST_SETTLE = 300.0
"""Longest settling time that every controller can wait [s]."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Move:
    """Joint motion to target number `target`, ending at rest."""

    target: int


@dataclass(frozen=True)
class Settle:
    """Wait until nothing swings any more [s]."""

    seconds: float


@dataclass(frozen=True)
class Ask:
    """Stop; the operator does what `text` says and confirms."""

    text: str


@dataclass(frozen=True)
class Measure:
    """Stop and measure; the instrument is triggered or the operator does it and confirms.

    Attributes:
        text: What the operator reads.
        experiment: Running number from 1.
        configuration: Number of the load case from 1.
        loaded: Whether the load of the load case acts.
    """

    text: str
    experiment: int
    configuration: int
    loaded: bool


Step = Move | Settle | Ask | Measure


@dataclass(frozen=True)
class Provenance:
    """Where a program comes from.

    Attributes:
        study: Name of the study, or of what was compensated.
        digest: SHA-256 of the file it was made from, empty if there is none.
        made_by: Program and version.
    """

    study: str = ""
    digest: str = ""
    made_by: str = f"elastocal {__version__}"


@dataclass(frozen=True)
class RobotProgram:
    """Steps in order of execution, and the targets that they go to.

    Attributes:
        name: What the user calls it; every writer makes a name of it that its controller takes.
        purpose: One sentence on what the program does.
        robot: The robot; targets are in the order of its joints.
        targets: (T, n) joint values [rad or m], inside the joint limits.
        target_names: T short names: H0, AP1, P1, AP2, P2, ….
        steps: What is done.
        speed: Share of the controller's full speed, in (0, 1].
        provenance: Where it comes from.
        notes: Further sentences for the header.
    """

    name: str
    purpose: str
    robot: Robot
    targets: Array
    target_names: tuple[str, ...]
    steps: tuple[Step, ...]
    speed: float = 0.1
    provenance: Provenance = field(default_factory=Provenance)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        targets, n = frozen(self.targets), len(self.robot.joints)
        if targets.ndim != 2 or targets.shape[1] != n or len(targets) != len(self.target_names):
            raise InputError(
                f"a program for {self.robot.name!r} needs targets of shape (T, {n}) with T names; "
                f"found {targets.shape} and {len(self.target_names)} names"
            )
        if not 0.0 < self.speed <= 1.0:
            raise InputError(
                f"the speed must be above 0 and at most 100 %, found {100.0 * self.speed:g} %"
            )
        _check_limits(self.robot, targets, self.target_names)
        for step in self.steps:
            if isinstance(step, Settle) and not 0.0 <= step.seconds <= LONGEST_SETTLE:
                raise InputError(
                    f"the settling time must be from 0 to {LONGEST_SETTLE:g} s, found "
                    f"{step.seconds:g}"
                )
        object.__setattr__(self, "targets", targets)

    @property
    def experiments(self) -> int:
        """Number of experiments in the program."""
        return len({step.experiment for step in self.steps if isinstance(step, Measure)})


def _check_limits(robot: Robot, targets: Array, names: Sequence[str]) -> None:
    for i, q in enumerate(targets):
        for j, joint in enumerate(robot.joints):
            scale, unit = joint.shown
            if not np.isfinite(q[j]):
                raise InputError(f"target {names[i]}: joint {joint.name!r} has no finite value")
            if not joint.lower - _ROUNDING <= q[j] <= joint.upper + _ROUNDING:
                raise InputError(
                    f"target {names[i]}: joint {joint.name!r} is at {scale * q[j]:.6g}{unit}, "
                    f"expected {scale * joint.lower:.6g} to {scale * joint.upper:.6g}{unit}"
                )


def program(
    study: Study,
    cases: LoadCases,
    repeats: IntArray,
    *,
    name: str = "",
    home: ArrayLike | None = None,
    prebias: float = np.radians(0.5),
    prebias_sliding: float = 1e-3,
    settle: float = 2.0,
    speed: float = 0.1,
    digest: str = "",
) -> RobotProgram:
    """Program of a calibration campaign, in the order of the load cases.

    Every repeat is a full cycle: approach from the same side, go to the pose, measure unloaded,
    load, measure loaded, unload. The robot never moves with the load on.

    Args:
        study: The study, from which the load cases are judged again.
        cases: S load cases.
        repeats: (S,) how often each is measured.
        name: Name of the program, the study's if empty.
        home: (n,) where to start and to end [rad or m]; None to start at the first approach point.
        prebias: Approach distance of joints that turn [rad].
        prebias_sliding: Approach distance of joints that slide [m].
        settle: Wait before every measurement [s].
        speed: Share of full speed, in (0, 1].
        digest: SHA-256 of the plan file.

    Raises:
        InfeasibleError: the load cases break constraints of the study, or home does.
        InputError: an argument is out of range, or a configuration cannot be approached.
    """
    worth = assess(study, cases, repeats)
    if worth.violations:
        raise InfeasibleError(worth.violations[0])
    for what, value in (("approach distance", prebias), ("approach distance", prebias_sliding)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"the {what} must not be negative, found {value:g}")
    robot, limits = study.robot, study.limits
    q = np.clip(cases.q, limits[0], limits[1])
    amount = np.where(robot.prismatic, prebias_sliding, prebias)
    before, same = approaches(robot, q, amount, limits, study.constraints)
    before = np.clip(before, limits[0], limits[1])
    start = [] if home is None else [_home(study, home)]
    steps: list[Step] = [Move(0)] if start else []
    m, experiment = int(np.sum(repeats)), 0
    for i in range(len(cases)):
        for _ in range(int(repeats[i])):
            experiment += 1
            head = f"Experiment {experiment}/{m}"
            where = (len(start) + 2 * i, len(start) + 2 * i + 1)
            steps += _cycle(study, cases.wrench[i], where, i + 1, experiment, head, settle)
    steps.append(Move(0) if start else Move(where[0]))
    labels = ["H0"] * len(start)
    for i in range(len(cases)):
        labels += [f"AP{i + 1}", f"P{i + 1}"]
    notes = [] if same else ["Not all poses are approached from the same side: limits in the way."]
    notes.append("Forces act at the load point of the tool, in the axes of the robot base.")
    if not start:
        notes.append("No home position: the first motion starts where the robot stands.")
    return RobotProgram(
        name=name or study.name,
        purpose=f"Calibration campaign: {m} experiments in {len(cases)} configurations.",
        robot=robot,
        targets=np.vstack([*start, np.stack([before, q], axis=1).reshape(-1, q.shape[1])]),
        target_names=tuple(labels),
        steps=tuple(steps),
        speed=speed,
        provenance=Provenance(study.name, digest),
        notes=tuple(notes),
    )


def _cycle(
    study: Study,
    wrench: Array,
    where: tuple[int, int],
    configuration: int,
    experiment: int,
    head: str,
    settle: float,
) -> list[Step]:
    """One experiment: approach, pose, unloaded, loaded, unloaded again."""
    markers = " ".join(study.experiments.tool.marker_names)
    free = f"{head}: pose {configuration}. NO load. Measure {markers}."
    bent = f"{head}: pose {configuration}. LOADED. Measure {markers}."
    return [
        Move(where[0]),
        Move(where[1]),
        Settle(settle),
        Measure(free, experiment, configuration, loaded=False),
        Ask(f"{head}: {load_text(wrench)}."),
        Settle(settle),
        Measure(bent, experiment, configuration, loaded=True),
        Ask(f"{head}: take the load off. The robot moves next."),
    ]


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


def _home(study: Study, home: ArrayLike) -> Array:
    """Home, checked against limits and constraints."""
    robot = study.robot
    q = np.asarray(home, dtype=float)
    if q.shape != (len(robot.joints),):
        raise InputError(f"home needs {len(robot.joints)} joint values, found {q.size}")
    _check_limits(robot, q[None], ["home"])
    if study.constraints:
        room = margins_at(study.constraints, Posture(robot, q[None]))[:, 0]
        worst = int(np.argmin(room))
        if room[worst] < -1e-5:
            c = study.constraints[worst]
            raise InfeasibleError(
                f"home breaks {c.name} by {describe(-float(room[worst]), c.unit)}"
            )
    return q


def path_program(
    robot: Robot,
    q: ArrayLike,
    *,
    name: str,
    purpose: str = "",
    speed: float = 0.1,
    provenance: Provenance | None = None,
) -> RobotProgram:
    """Program that goes through joint targets one after the other: a corrected path, say.

    Args:
        robot: The robot.
        q: (T, n) joint targets [rad or m].
        name: Name of the program.
        purpose: One sentence for the header.
        speed: Share of full speed, in (0, 1].
        provenance: Where the path comes from.

    Raises:
        InputError: no targets, or one outside the joint limits.
    """
    targets = np.asarray(q, dtype=float)
    if targets.ndim != 2 or not len(targets):
        raise InputError(f"a path needs targets of shape (T, n), found {targets.shape}")
    return RobotProgram(
        name=name,
        purpose=purpose or f"Path through {len(targets)} joint targets.",
        robot=robot,
        targets=targets,
        target_names=tuple(f"P{i + 1}" for i in range(len(targets))),
        steps=tuple(Move(i) for i in range(len(targets))),
        speed=speed,
        provenance=provenance or Provenance(name),
    )
