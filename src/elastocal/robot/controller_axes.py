"""Coupling: from the joint values of the model to those a controller shows, and back.

Controllers count turns with signs and zeros of their own, and some show an angle that another
joint moves too: on a FANUC arm J3 is the angle of the forearm over the horizontal, which J2
changes. All of it is one affine map, the same for files, programs and checks at the robot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.wording.numbers import described

_WORST_CONDITION = 1e6
_PARALLEL = 1.0 - 1e-6


@dataclass(frozen=True)
class Coupling:
    """controller = matrix · model + offset, in rad and m, joints in the order of the chain.

    Attributes:
        joint_names: Names of the n joints.
        matrix: (n, n) invertible.
        offset: (n,) controller values where the model is at zero [rad or m].
    """

    joint_names: tuple[str, ...]
    matrix: Array
    offset: Array

    def __post_init__(self) -> None:
        n = len(self.joint_names)
        freeze(self, "matrix", "offset")
        matrix, offset = self.matrix, self.offset
        if matrix.shape != (n, n) or offset.shape != (n,):
            raise InputError(
                f"the coupling of {n} joints needs a {n}x{n} matrix and {n} offsets, found "
                f"{'x'.join(map(str, matrix.shape))} and {offset.size}"
            )
        if not (np.isfinite(matrix).all() and np.isfinite(offset).all()):
            raise InputError("the coupling has a number that is not finite")
        if not np.linalg.cond(matrix) < _WORST_CONDITION:
            raise InputError(
                "the coupling cannot be inverted: different joint values of the model would "
                "have the same values at the controller"
            )

    @property
    def is_identity(self) -> bool:
        """Whether the controller shows what the model has."""
        same = np.array_equal(self.matrix, np.eye(len(self.joint_names)))
        return same and not self.offset.any()

    def to_controller(self, q: Array) -> Array:
        """(N, n) controller values of configurations `q`, (N, n) [rad or m]."""
        return np.asarray(np.asarray(q) @ self.matrix.T + self.offset)

    def to_model(self, shown: Array) -> Array:
        """(N, n) configurations of controller values `shown`, (N, n) [rad or m]."""
        from_zero: Array = np.asarray(shown, dtype=np.float64) - self.offset
        return np.asarray(np.linalg.solve(self.matrix, from_zero.T).T, dtype=np.float64)


def shown_values(robot: Robot, table: Coupling) -> dict[str, str]:
    """What the controller shows for the joints for which it shows something else than the model.

    {"J3": "-J3 - J2 + 90°"}, where names stand for the joint values of the model.
    """
    found = {}
    for i, joint in enumerate(robot.joints):
        row, offset = table.matrix[i], float(table.offset[i])
        if np.array_equal(row, np.eye(len(row))[i]) and not offset:
            continue
        order = sorted(np.flatnonzero(row).tolist(), key=lambda j: j != i)
        terms = [(float(row[j]), _times(abs(float(row[j])), table.joint_names[j])) for j in order]
        if offset:
            terms.append((offset, described(abs(offset), joint.kind.unit)))
        first, *rest = (("- " if factor < 0.0 else "+ ") + term for factor, term in terms)
        found[joint.name] = " ".join([first.removeprefix("+ ").replace("- ", "-", 1), *rest])
    return found


def _times(size: float, name: str) -> str:
    return name if size == 1.0 else f"{size:.6g} · {name}"


def uncoupled(robot: Robot) -> Coupling:
    """The controller that shows what the model has."""
    n = len(robot.joints)
    return Coupling(robot.joint_names, np.eye(n), np.zeros(n))


def coupling(
    robot: Robot,
    *,
    signs: Mapping[str, float] | None = None,
    offsets: Mapping[str, float] | None = None,
    couple: Mapping[str, Mapping[str, float]] | None = None,
    preset: str | None = None,
) -> Coupling:
    """A coupling from what is different.

    Args:
        robot: Robot whose joints are meant.
        signs: 1 or -1 by joint: whether the controller counts the other way.
        offsets: What the controller shows where the model, after its sign, is at zero [rad or m].
        couple: {J3: {J2: 1}}: the controller shows J3 plus 1 times what it shows for J2.
        preset: Name in `PRESETS` to start from; what is given besides replaces its entries.

    Returns:
        (1 + K)(S q + o) with signs S, offsets o and coupling factors K.

    Raises:
        InputError: a joint is unknown, a sign is not 1 or -1, units differ, not invertible.

    Source: ours.
    """
    names = robot.joint_names
    start = _preset(robot, preset) if preset is not None else ({}, {})
    all_signs = {**start[0], **(signs or {})}
    factors = {**start[1], **(couple or {})}
    robot.index(
        [*all_signs, *(offsets or {}), *factors, *(j for row in factors.values() for j in row)]
    )
    for name, sign in all_signs.items():
        if sign not in (1, -1):
            raise InputError(f"sign of joint {name!r}: expected 1 or -1, found {sign:g}")
    diagonal = np.diag([float(all_signs.get(name, 1.0)) for name in names])
    mixing = np.eye(len(names))
    for name, row in factors.items():
        for other, factor in row.items():
            i, j = names.index(name), names.index(other)
            if i == j:
                raise InputError(f"joint {name!r} cannot be coupled to itself; use its sign")
            if robot.joints[i].prismatic != robot.joints[j].prismatic:
                raise InputError(
                    f"joints {name!r} and {other!r} cannot be coupled: one turns, the other slides"
                )
            mixing[i, j] += factor
    offset = np.array([(offsets or {}).get(name, 0.0) for name in names])
    return Coupling(names, mixing @ diagonal, mixing @ offset)


def has_forearm(robot: Robot) -> bool:
    """Whether the second and third turning joint have parallel axes, as upper arm and forearm."""
    turning = np.flatnonzero(~robot.prismatic)
    return len(turning) >= 3 and abs(_cosine(robot, *turning[1:3].tolist())) >= _PARALLEL


def _cosine(robot: Robot, first: int, second: int) -> float:
    """Of the angle between the axes of two joints, with all joints at zero."""
    axes = Posture(robot, np.zeros((1, len(robot.joints)))).axes[:, :, 0]
    return float(axes[:, first] @ axes[:, second])


def _preset(robot: Robot, name: str) -> tuple[dict[str, float], dict[str, Mapping[str, float]]]:
    if name not in PRESETS:
        raise InputError(f"no controller preset {name!r}; there are {', '.join(PRESETS)}")
    return PRESETS[name](robot)


def _fanuc(robot: Robot) -> tuple[dict[str, float], dict[str, Mapping[str, float]]]:
    """J3 is the elevation of the forearm: a turn of J2 alone leaves its value, not the pose.

    The second and third turning joints are meant, counted from the base, and J2 is taken to lean
    the arm forward. A positive J3 lifts the forearm, against the turn of J2: so it counts the
    other way if the two axes of the model are parallel.

    Source: ours; elevation = q3 - q2 with opposed axes, as anyone sees who jogs J2.
    """
    turning = np.flatnonzero(~robot.prismatic)
    if len(turning) < 3:
        raise InputError(
            f"controller preset 'fanuc' needs three turning joints, found {len(turning)}"
        )
    second, third = int(turning[1]), int(turning[2])
    cosine = _cosine(robot, second, third)
    if abs(cosine) < _PARALLEL:
        raise InputError(
            f"controller preset 'fanuc' needs parallel axes of {robot.joint_names[second]!r} and "
            f"{robot.joint_names[third]!r}; theirs are "
            f"{described(np.arccos(abs(cosine)), 'rad', 3)} apart"
        )
    names = robot.joint_names
    sign = {names[third]: -1.0} if cosine > 0.0 else {}
    return dict(sign), {names[third]: {names[second]: -1.0}}


PRESETS: dict[str, Callable[[Robot], tuple[dict[str, float], dict[str, Mapping[str, float]]]]] = {
    "fanuc": _fanuc
}
"""Couplings by the name of the maker."""
