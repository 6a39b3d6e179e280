"""Robot programs, before any controller's language: targets in joint space and what is done there.

A calibration campaign (`campaign_program.py`) and a path become a `RobotProgram`, which the
writers turn into files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from elastocal import __version__
from elastocal.arrays import Array, freeze
from elastocal.errors import InputError
from elastocal.robot.chain import Robot

LONGEST_SETTLE = 300.0
"""Longest settling time that every controller can wait [s]."""
_ROUNDING = 1e-9
_LABEL = re.compile(r"[A-Za-z]\w{0,11}", re.ASCII)


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
        study: Name of the study.
        digest: SHA-256 of the file it was made from, empty if there is none.
        made_by: Program and version.
        of: What that file is: a plan or a path.
        beside: What else it was made from, as (what it is, SHA-256).
    """

    study: str = ""
    digest: str = ""
    made_by: str = f"elastocal {__version__}"
    of: str = "plan"
    beside: tuple[tuple[str, str], ...] = ()

    @property
    def sources(self) -> tuple[tuple[str, str], ...]:
        """Every file it was made from, as (what it is, SHA-256)."""
        return (*(((self.of, self.digest),) if self.digest else ()), *self.beside)


@dataclass(frozen=True)
class RobotProgram:
    """Steps in order of execution, and the targets that they go to.

    Attributes:
        name: What the user calls it; every writer makes a name of it that its controller takes.
        purpose: One sentence on what the program does.
        robot: The robot; targets are in the order of its joints.
        targets: (T, n) joint values [rad or m], inside the joint limits.
        target_names: T short names of letters and digits, each once: H0, AP1, P1, AP2, P2, ….
        steps: What is done.
        speed: Share of the controller's full speed, in (0, 1].
        provenance: Where it comes from.
        notes: Further sentences for the header.
        watched: Whether motions from target to target were checked for collisions.
        carries: Whether the robot moves with what loads it.
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
    watched: bool = False
    carries: bool = False

    def __post_init__(self) -> None:
        freeze(self, "targets")
        targets, n = self.targets, len(self.robot.joints)
        if targets.ndim != 2 or targets.shape[1] != n or len(targets) != len(self.target_names):
            raise InputError(
                f"a program for {self.robot.name!r} needs targets of shape (T, {n}) with T names; "
                f"found {targets.shape} and {len(self.target_names)} names"
            )
        names = set(self.target_names)
        if len(names) != len(targets) or not all(map(_LABEL.fullmatch, names)):
            raise InputError(
                "targets are called by up to 12 letters and digits, a letter first, each once"
            )
        if not 0.0 < self.speed <= 1.0:
            raise InputError(
                f"the speed must be above 0 and at most 100 %, found {100.0 * self.speed:g} %"
            )
        check_limits(self.robot, targets, self.target_names)
        for step in self.steps:
            if isinstance(step, Settle) and not 0.0 <= step.seconds <= LONGEST_SETTLE:
                raise InputError(
                    f"the settling time must be from 0 to {LONGEST_SETTLE:g} s, found "
                    f"{step.seconds:g}"
                )

    @property
    def experiments(self) -> int:
        """Number of experiments in the program."""
        return len({step.experiment for step in self.steps if isinstance(step, Measure)})


def check_limits(robot: Robot, targets: Array, names: Sequence[str]) -> None:
    """Refuse targets outside the joint limits.

    Raises:
        InputError: names target and joint.
    """
    good = (targets >= robot.lower - _ROUNDING) & (targets <= robot.upper + _ROUNDING)
    for i, j in np.argwhere(~(good & np.isfinite(targets))).tolist():
        joint, value = robot.joints[j], targets[i, j]
        scale, unit = joint.kind.shown
        if not np.isfinite(value):
            raise InputError(f"target {names[i]}: joint {joint.name!r} has no finite value")
        raise InputError(
            f"target {names[i]}: joint {joint.name!r} is at {scale * value:.6g}{unit}, "
            f"expected {scale * joint.lower:.6g} to {scale * joint.upper:.6g}{unit}"
        )


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
        provenance=provenance or Provenance(),
    )
