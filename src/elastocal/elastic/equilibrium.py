"""Equilibrium: where an elastic arm comes to rest under load.

In: elastic arm, compliances, load cases. Out: spring displacements, exact for any size of
deflection, and where they lead, linearised.

With θ the displacements of the springs, k their compliances and y(q + θ) the generalised forces
that load and weight exert on them in the bent configuration, the arm rests where

    θ = k ∘ y(q + θ),        H = ∂y/∂θ
    Newton:  (I - diag(k) H) δθ = k ∘ y - θ,        ∂θ/∂k = (I - diag(k) H)⁻¹ diag(y)

The linear model (paper eq. 2) is the first Newton step from θ = 0 without H. The regressor is
not used here. Source: ours; the geometry of loaded equilibria is textbook.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import eliminated
from elastocal.robot.posture import Posture, cross, dot, flange_axes, velocities

_CHUNK = 2048  # load cases evaluated at once: what stays in the cache
_MOST_STEPS = 30
_SMALL = 1e-13  # Newton step over the size of the displacement at which the arm is at rest
_STIFF = 0.5  # sum of a row of diag(k) H up to which the arm is far from buckling
LOST = 1e3
"""Displacement of a spring beyond which no rest is looked for [rad or m]."""


@dataclass(frozen=True)
class Equilibrium:
    """Where N load cases come to rest.

    Attributes:
        displacement: (N, p) displacements of the springs [rad or m].
        converged: (N,) whether Newton's iteration came to rest.
        stability: (N,) smallest eigenvalue of the scaled stiffness under load: 1 without load,
            0 where the arm buckles, negative where the rest is not stable.
    """

    displacement: Array
    converged: BoolArray
    stability: Array

    @property
    def stable(self) -> BoolArray:
        """(N,) whether the arm stays where it came to rest."""
        return np.asarray(self.converged & (self.stability > 0.0))


class Linearisation(NamedTuple):
    """The equilibrium of N load cases, linearised at given displacements and compliances."""

    step: Array
    """(N, p) Newton step that leads towards the equilibrium [rad or m]."""
    slope: Array
    """(N, p, p) derivative of the equilibrium displacements in the compliances."""
    markers: Array
    """(N, 3K) marker positions at the displacements, base frame [m]."""
    velocity: Array
    """(N, 3K, p) their derivative in the displacements."""
    flange: Array
    """(N, 3, 3) axes of the flange at the displacements, as columns, base frame."""
    turning: Array
    """(N, 3, p) turn of the flange for unit displacements, base frame."""
    stiffening: Array
    """(N, p, p) H: what the springs lose, or gain, in stiffness because the load moves along."""


def linearise(
    arm: ElasticArm, compliance: Array, q: Array, wrench: Array, displacement: Array
) -> Linearisation:
    """Linearise the equilibrium at `displacement`, which need not be one.

    Args:
        arm: Elastic arm with p springs and K markers.
        compliance: (p,) compliances [rad/(N·m) or m/N], or (N, p): one arm for each load case.
        q: (N, n) configurations of the unloaded arm [rad or m].
        wrench: (N, 6) wrenches at the load point, base frame [N, N·m].
        displacement: (N, p) displacements of the springs [rad or m].
    """
    each = np.broadcast_to(compliance, displacement.shape)
    parts = [
        _linearise(arm, each[s], q[s], wrench[s], displacement[s])
        for s in (slice(i, i + _CHUNK) for i in range(0, max(len(q), 1), _CHUNK))
    ]
    if len(parts) == 1:
        return parts[0]
    return Linearisation(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def unbent(arm: ElasticArm, q: Array, wrench: Array) -> tuple[Array, Array]:
    """Marker positions (N, 3K) [m] of the unbent arm, and what loads exert on its springs there.

    The second, (N, p) [N·m or N], times the compliances is where the springs go to first order.
    """
    markers = np.empty((len(q), 3 * len(arm.tool.markers)))
    effort = np.empty((len(q), len(arm.springs)))
    for s in (slice(i, i + _CHUNK) for i in range(0, len(q), _CHUNK)):
        posture = Posture(arm.chain, arm.bent(q[s], np.zeros((len(q[s]), len(arm.springs)))))
        points = [posture.point(marker) for marker in arm.tool.markers]
        markers[s] = np.concatenate(points).T
        effort[s] = _effort(arm, posture, wrench[s]).T
    return markers, effort


def efforts(arm: ElasticArm, q: Array, wrench: Array, displacement: Array) -> Array:
    """(N, p) generalised forces of load and weight on the springs of the bent arm [N·m or N]."""
    found = np.empty(displacement.shape)
    for s in (slice(i, i + _CHUNK) for i in range(0, len(q), _CHUNK)):
        posture = Posture(arm.chain, arm.bent(q[s], displacement[s]))
        found[s] = _effort(arm, posture, wrench[s]).T
    return found


def equilibrium(arm: ElasticArm, compliance: Array, cases: LoadCases) -> Equilibrium:
    """Where the arm comes to rest under every load case.

    Args:
        arm: Elastic arm with p springs.
        compliance: (p,) compliances [rad/(N·m) or m/N], or (N, p): one arm for each load case.
        cases: N load cases; the weight of the links acts besides.

    Source: ours; paper ref. to nonlinear compensation [12].
    """
    count, p = len(cases), len(arm.springs)
    each = np.broadcast_to(compliance, (count, p))
    displacement, stiffening = np.zeros((count, p)), np.zeros((count, p, p))
    converged = np.zeros(count, dtype=bool)
    open_ = np.arange(count)
    for _ in range(_MOST_STEPS):
        if not len(open_):
            break
        state = linearise(
            arm, each[open_], cases.q[open_], cases.wrench[open_], displacement[open_]
        )
        displacement[open_] += state.step
        stiffening[open_] = state.stiffening
        size = np.abs(displacement[open_]).max(axis=1, initial=0.0)
        with np.errstate(invalid="ignore"):
            done = np.abs(state.step).max(axis=1, initial=0.0) <= _SMALL * size
        converged[open_[done]] = True
        open_ = open_[~done & (size < LOST)]  # no number is not below it either
    stability = _stability(each, stiffening)
    return Equilibrium(frozen(displacement), frozen(converged, np.bool_), frozen(stability))


def _linearise(
    arm: ElasticArm, compliance: Array, q: Array, wrench: Array, displacement: Array
) -> Linearisation:
    """One chunk of `linearise`, compliances (N, p)."""
    count, p = displacement.shape
    posture = Posture(arm.chain, arm.bent(q, displacement))
    joints, share = arm.bent_by  # springs, and followers of joints that bend
    axes, origins = posture.all_axes[:, joints], posture.all_origins[:, joints]
    slides = arm.chain.sliding[joints]
    turns = axes.copy()
    turns[:, slides] = 0.0

    effort = np.zeros((len(joints), count))
    slope = np.zeros((len(joints), len(joints), count))  # H
    for point, force, carries in _loads(arm, posture, wrench):
        v = velocities(axes, point[:, None] - origins, slides)
        v[:, ~carries] = 0.0
        effort += dot(v, force[:, None])
        turning = cross(v, force[:, None])
        for j in range(len(joints)):
            # Spring i <= j turns spring j and its arm: ∂y_i/∂θ_j = ∂y_j/∂θ_i = a_i · (v_j × F).
            row = dot(turns[:, : j + 1], turning[:, j, None])
            row[~carries[: j + 1]] = 0.0  # those on another branch
            slope[: j + 1, j] += row
            slope[j, :j] += row[:-1]
    tip = arm.chain.carries[arm.chain.last, joints]
    turns[:, ~tip] = 0.0  # from here on what turns the flange
    moment = wrench.T[3:, None]
    if moment.any():
        effort += dot(turns, moment)
        for j in range(len(joints)):
            # A moment that keeps its direction turns no axis but those beyond spring j.
            slope[j + 1 :, j] += dot(cross(turns[:, j, None], turns[:, j + 1 :]), moment)
    points = [posture.point(marker) for marker in arm.tool.markers]
    given = [velocities(axes, point[:, None] - origins, slides) for point in points]
    if len(joints) > p:
        effort, slope = share.T @ effort, np.einsum("si,stN,tj->ijN", share, slope, share)
        along = share * tip[:, None]
        turns, *given = (np.einsum("tp,ctN->cpN", along, each) for each in (turns, *given))
    k = compliance.T
    right = np.concatenate([(k * effort - displacement.T)[:, None], _diagonal(effort)], axis=1)
    solved = _solved(k[:, None] * slope, right)
    return Linearisation(
        step=solved[:, 0].T,
        slope=solved[:, 1:].transpose(2, 0, 1),
        markers=np.concatenate(points).T,
        velocity=np.concatenate(given).transpose(2, 0, 1),
        flange=flange_axes(posture),
        turning=turns.transpose(2, 0, 1),
        stiffening=slope.transpose(2, 0, 1),
    )


def _effort(arm: ElasticArm, posture: Posture, wrench: Array) -> Array:
    """(p, N) generalised forces of load and weight on the springs."""
    joints, share = arm.bent_by
    axes, origins = posture.all_axes[:, joints], posture.all_origins[:, joints]
    slides = arm.chain.sliding[joints]
    effort = np.zeros((len(joints), posture.count))
    for point, force, carries in _loads(arm, posture, wrench):
        pulled = dot(velocities(axes, point[:, None] - origins, slides), force[:, None])
        pulled[~carries] = 0.0
        effort += pulled
    turning = arm.chain.carries[arm.chain.last, joints] & ~slides
    effort[turning] += dot(axes[:, turning], wrench.T[3:, None])
    return np.asarray(share.T @ effort)


def _loads(
    arm: ElasticArm, posture: Posture, wrench: Array
) -> list[tuple[Array, Array, BoolArray]]:
    """Point (3, N), force (3, N or 1), and which (T,) springs and followers bear it, for each."""
    carries = arm.chain.carries[:, arm.bent_by[0]]
    tip = carries[arm.chain.last]
    loads = [(posture.point(arm.tool.load_point), wrench.T[:3], tip)]
    if arm.sags:
        for body in arm.chain.masses:
            weight = body.mass * arm.gravity[:, None]
            loads.append((posture.point(body.center, body.body), weight, carries[body.body]))
    return loads


def _solved(coupling: Array, right: Array) -> Array:
    """Solutions (p, m, N) of I - coupling, (p, p, N); NaN where a load just buckles the arm."""
    tangent = np.eye(len(coupling))[..., None] - coupling
    if (np.abs(coupling).sum(axis=1) < _STIFF).all():
        return eliminated(tangent, right)
    matrices, sides = tangent.transpose(2, 0, 1), right.transpose(2, 0, 1)
    try:
        solved = np.linalg.solve(matrices, sides)
    except np.linalg.LinAlgError:
        singular = np.linalg.det(matrices) == 0.0
        matrices = np.where(singular[:, None, None], np.nan, matrices)
        with np.errstate(invalid="ignore"):
            solved = np.linalg.solve(matrices, sides)
    return np.asarray(solved.transpose(1, 2, 0))


def _diagonal(effort: Array) -> Array:
    """(p, p, N) with the efforts (p, N) on the diagonal."""
    p, count = effort.shape
    matrix = np.zeros((p, p, count))
    matrix[np.arange(p), np.arange(p)] = effort
    return matrix


def _stability(compliance: Array, stiffening: Array) -> Array:
    """(N,) smallest eigenvalue of I - √k H √k, H symmetrised."""
    root = np.sqrt(np.maximum(compliance, 0.0))
    if not root.shape[-1]:
        return np.ones(len(stiffening))
    symmetric = 0.5 * (stiffening + stiffening.transpose(0, 2, 1))
    matrices = np.eye(root.shape[-1]) - root[..., :, None] * symmetric * root[..., None, :]
    bad = ~np.isfinite(matrices).all(axis=(1, 2))
    matrices[bad] = 0.0
    smallest = np.linalg.eigvalsh(matrices)[:, 0]
    return np.where(bad, -np.inf, smallest)
