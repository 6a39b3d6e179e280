"""Cartesian compliance and stiffness: how the TCP gives way to a wrench there, in all directions.

In: elastic arm, compliance model, configurations. Out: values with intervals. The compliance
C = J k Jᵀ is linear in the compliances k of the springs, so its uncertainty needs no
approximation; the stiffness K_C is its inverse, if it has one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor, regressor
from elastocal.matrices import rank_of
from elastocal.robot.posture import Posture
from elastocal.squares import largest_likely, weights_of

_AXES = ("x", "y", "z")
_NOTHING = 1e-12  # share of the largest compliance that is rounding


class Interval(NamedTuple):
    """A value with its confidence interval."""

    value: float
    low: float
    high: float

    @property
    def inverse(self) -> Interval:
        """Of one over the value: what holds the value holds its inverse as often."""
        ends = [1.0 / end if end > 0.0 else np.inf for end in (self.value, self.high, self.low)]
        return Interval(*ends)


class Yielding(NamedTuple):
    """How the TCP gives way along a direction to a force along it, free to give way across."""

    name: str
    direction: Array
    """(3,) unit vector, base frame."""
    compliance: Interval
    """[m/N]; zero where nothing gives way."""

    @property
    def stiffness(self) -> Interval:
        """[N/m]; infinite where nothing gives way."""
        return self.compliance.inverse


@dataclass(frozen=True)
class CartesianCompliance:
    """How the TCP gives way in one configuration: base axes, first order, unloaded.

    Attributes:
        twists: (6, p) J: what a unit displacement of every spring does to the TCP: shift and turn.
        compliance: (p,) k [rad/(N·m) or m/N].
        covariance: (p, p) of k.
        width: Half width of the intervals, in standard errors.
        rigid: Joints without a spring.
    """

    twists: Array
    compliance: Array
    covariance: Array
    width: float
    rigid: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "twists", "compliance", "covariance")

    @property
    def matrix(self) -> Array:
        """(6, 6) C: shift and turn of the TCP per force and moment [m/N, rad/(N·m), rad/N].

        Source: paper eq. (1), inverted.
        """
        return np.asarray(self.twists * self.compliance @ self.twists.T)

    def along(self, name: str, direction: Array) -> Yielding:
        """How it gives way along a direction (3,)."""
        unit = direction / np.linalg.norm(direction)
        slope = (self.twists[:3].T @ unit) ** 2
        if slope @ np.abs(self.compliance) <= _NOTHING * np.trace(np.abs(self.matrix[:3, :3])):
            return Yielding(name, unit, Interval(0.0, 0.0, 0.0))
        value = float(slope @ self.compliance)
        half = self.width * float(np.sqrt(slope @ self.covariance @ slope))
        return Yielding(name, unit, Interval(value, value - half, value + half))

    @property
    def axes(self) -> tuple[Yielding, ...]:
        """Along x, y and z of the base."""
        return tuple(self.along(n, axis) for n, axis in zip(_AXES, np.eye(3), strict=True))

    @property
    def principal(self) -> tuple[Yielding, Yielding]:
        """Along the softest direction and the stiffest: a force there moves the TCP along it."""
        _, vectors = np.linalg.eigh(self.matrix[:3, :3])
        return self.along("softest", _upright(vectors[:, 2])), self.along(
            "stiffest", _upright(vectors[:, 0])
        )

    @cached_property
    def missing(self) -> int:
        """How many of the six ways to move the TCP no spring allows: there K_C is infinite."""
        return 6 - int(rank_of(self.matrix))

    @property
    def stiffness(self) -> Array | None:
        """(6, 6) K_C [N/m, N, N·m/rad]; None if it is infinite in some direction.

        Source: paper eq. (1).
        """
        return None if self.missing else np.asarray(np.linalg.inv(self.matrix))

    @property
    def held(self) -> tuple[Interval, ...]:
        """Diagonal of K_C: the force along x, y, z, then the moment about them, that moves the TCP
        that way and no other; none if K_C is infinite somewhere.

        Intervals to first order: dK_C = -K_C dC K_C.
        """
        stiffness = self.stiffness
        if stiffness is None:
            return ()
        slopes = (stiffness @ self.twists) ** 2
        half = self.width * np.sqrt(np.einsum("ip,pq,iq->i", slopes, self.covariance, slopes))
        values = zip(np.diagonal(stiffness).tolist(), half.tolist(), strict=True)
        return tuple(Interval(value, value - off, value + off) for value, off in values)


def _upright(direction: Array) -> Array:
    """The one of two opposite directions whose largest component is positive."""
    return direction * np.sign(direction[np.argmax(np.abs(direction))])


def cartesian_compliance(
    arm: ElasticArm, model: ComplianceModel, q: Array, width: float = 1.959964
) -> tuple[CartesianCompliance, ...]:
    """Cartesian compliance at the TCP of the tool of `arm`, in N configurations.

    Args:
        arm: Robot and tool; its springs are replaced by those of the model.
        model: Compliances with covariance; joints without one are rigid.
        q: (N, n) configurations [rad or m].
        width: Half width of the intervals, in standard errors; 95 % of a normal distribution.
    """
    bent = replace(arm, springs=model.springs, tool=arm.tool.at_tcp)
    rows = Regressor(bent, Posture(arm.robot, q), np.zeros((len(q), 6)))
    twists = np.concatenate([rows.velocities[rows.markers[0]], rows.turns])
    sprung = set(model.springs.joint.tolist())
    rigid = tuple(name for i, name in enumerate(arm.robot.joint_names) if i not in sprung)
    return tuple(
        CartesianCompliance(one, model.compliance, model.covariance, width, rigid)
        for one in twists.transpose(2, 0, 1)
    )


def error_left(arm: ElasticArm, model: ComplianceModel, cases: LoadCases) -> Array:
    """(N,) root mean square error of the TCP that the covariance of a model leaves [m].

    Source: paper eqs. (17), (20).
    """
    rows = regressor(replace(arm, springs=model.springs, tool=arm.tool.at_tcp), cases)
    return np.sqrt(np.einsum("nip,pq,niq->n", rows, model.at_task, rows))


def limit_left(arm: ElasticArm, model: ComplianceModel, cases: LoadCases) -> float:
    """What the root mean square of that error over N load cases stays below with 95 % [m].

    With σ estimated, by the degrees of freedom of the combination that errs most.

    Source: ours; see `squares`.
    """
    rows = regressor(replace(arm, springs=model.springs, tool=arm.tool.at_tcp), cases)
    form = np.einsum("nip,niq->pq", rows, rows) / len(cases)
    weight, most = weights_of(form, model.at_task)
    dof = float(model.freedom(most[None])[0]) if most.any() else np.inf
    return largest_likely(weight, dof=dof)
