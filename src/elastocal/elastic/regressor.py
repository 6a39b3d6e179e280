"""Elastostatics of a serial arm with springs on virtual joints.

In: elastic arm, load cases. Out: regressor, deflection, Cartesian stiffness.
A virtual joint is a unit twist carried by one body of the chain. With v_j the velocity that a
unit speed of virtual joint j gives to a point, and y_j the generalised force that the wrench
w = (F, T) exerts on it,

    y_j = v_j(load point)·F + a_j·T          (JᵀW, paper eq. 2)
    Δp  = Σ_j v_j(marker) y_j k_j = A k      (paper eqs. 3, 4, 7)

The gradient is one suffix sum and one prefix sum along the chain (`Regressor.pull`): turning
joint k by dθ moves everything beyond it as a rigid body. Cost O(n + p), no Hessian. Ours.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.matrices import rank_of
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture, cross, dot, jacobian, velocities


def regressor(arm: ElasticArm, cases: LoadCases, *, rotation: bool = False) -> Array:
    """Regressor A of the linear model: deflection = A · compliance.

    Args:
        arm: Elastic arm with p springs and K markers; the weight of its links does not count.
        cases: N load cases.
        rotation: Append the three rotation rows of the flange, whether the tool asks for them
            or not.

    Returns:
        (N, 3K or 3K + 3, p): position rows of each marker [N·m² for angular springs], then
        rotation rows [N·m].

    Source: paper eqs. (4), (7), (8); several markers are ours.
    """
    posture = Posture(arm.robot, cases.q)
    rows = Regressor(arm, posture, cases.wrench, rotation=rotation).rows
    return np.ascontiguousarray(rows.transpose(2, 0, 1))


def deflection(arm: ElasticArm, compliance: Array, cases: LoadCases) -> Array:
    """(N, 3K + 3) displacement of K markers [m] and rotation of the flange [rad] under load.

    `compliance` is (p,) [rad/(N·m), or m/N for linear springs].

    Source: paper eq. (2).
    """
    return np.asarray(regressor(arm, cases, rotation=True) @ compliance)


def cartesian_stiffness(robot: Robot, compliance: Array, q: Array, point: Array) -> Array:
    """(N, 6, 6) Cartesian stiffness K_C = J⁻ᵀ K_θ J⁻¹ at a point of the flange.

    Computed as the inverse of the Cartesian compliance J k_θ Jᵀ, so that any number of joints
    will do.

    Args:
        robot: Robot with n joints.
        compliance: (n,) compliance of every joint, all positive [rad/(N·m) or m/N].
        q: (N, n) configurations [rad or m].
        point: (3,) point in the flange frame [m].

    Raises:
        InputError: the compliance is singular, as at a singular configuration or with n < 6.

    Source: paper eq. (1), where K stands for K_θ and K_E for K_C.
    """
    columns = jacobian(robot, q, point)
    compliances = columns * compliance @ columns.transpose(0, 2, 1)
    singular = np.flatnonzero(rank_of(compliances) < 6)
    if len(singular):
        raise InputError(
            f"the Cartesian stiffness is infinite in some direction in configuration "
            f"{singular[0] + 1}: the joints cannot move the tool in all six directions there"
        )
    return np.asarray(np.linalg.inv(compliances), dtype=float)


class Regressor:
    """Regressor of N load cases, with what its gradient needs.

    Attributes:
        rows: (3K or 3K + 3, p, N): three position rows [N·m² for angular springs] of each of
            K markers and, if asked for here or by the tool, three rotation rows [N·m]; batch
            axis last. The rest is kept for `pull`:
        points: Distinct points of the tool in the flange frame, the load point first [m].
        markers: Which of them each marker is.
        at: Where each of them is, (3, 1, N) [m].
        arms: From the axes to each of them, (3, T, N) [m].
        velocities: What a unit speed of every virtual joint gives each of them, (3, p, N).
        axes: (3, T, N) axes of the twists that springs displace, mostly one each.
        origins: (3, T, N) points on them [m].
        joint: (T,) which of the joints of the robot has the axis, -1 if none has.
        turns: (3, p, N) how the springs turn the flange, zero for those that slide.
        sliding: (T,) which twists slide; None if none does, so that nothing is masked.
        force: (3, 1, N) force [N].
        moment: (3, 1, N) moment [N·m], left out of the sums if `has_moment` is false.
        levers: Shares of levers in place of y, by number of the spring, where compensators turn it.
        generalised_force: (p, N) y of eq. 2, what the wrench exerts on every virtual joint.
    """

    def __init__(
        self, arm: ElasticArm, posture: Posture, wrench: Array, *, rotation: bool = False
    ) -> None:
        """Evaluate the regressor.

        Args:
            arm: Elastic arm with p springs and K markers.
            posture: Its robot in N configurations.
            wrench: (N, 6) wrench at the load point, base frame [N, N·m].
            rotation: Append the three rotation rows of the flange body (paper eq. 8), whether
                the tool asks for them or not.
        """
        self.posture = posture
        self.springs, self.joint, self._share = arm.twists
        self.rotation = rotation = rotation or arm.tool.rotation
        self.force, self.moment = wrench.T[:3, None], wrench.T[3:, None]
        self.points, self.markers = _distinct_points(arm.tool)
        self.sliding = self.springs.prismatic if self.springs.prismatic.any() else None
        self.has_moment = bool(np.any(self.moment))
        self.axes, self.origins = self._twists()
        self.turns = self.combined(self._turning(self.axes))
        self.at = [posture.point(local)[:, None] for local in self.points]
        self.arms = [at - self.origins for at in self.at]
        slides = self.springs.prismatic
        self.velocities = [self.combined(velocities(self.axes, arm, slides)) for arm in self.arms]
        y = dot(self.velocities[_LOAD], self.force)
        if self.has_moment:
            y += dot(self.turns, self.moment)
        self.stiff = arm.springs.stiff if arm.springs.stiff.any() else None
        self.weights = WeightsOnSprings(arm, self) if arm.weights else None
        if self.weights is not None:
            y += self.weights.exerted
        if self.stiff is not None:
            y[self.stiff] = 1.0
        self.levers = {s: share for s, share in enumerate(arm.springs.by) if share is not None}
        for s, share in self.levers.items():
            y[s] = share.at(posture.q)
        self.generalised_force = y
        only = arm.springs.only
        self.moved = [
            None if (only < 0).all() else ((only < 0) | (only == m)).astype(float)[:, None]
            for m in range(len(self.markers))
        ]
        rows = [
            self.velocities[point] * (y if moved is None else y * moved)
            for point, moved in zip(self.markers, self.moved, strict=True)
        ]
        if rotation:
            rows.append(self.turns * y)
        self.rows = rows[0] if len(rows) == 1 else np.concatenate(rows)

    def pull(self, cotangent: Array) -> tuple[Array, Array]:
        """Gradients of a scalar whose gradient in `rows` is `cotangent`, (rows, p, N).

        Returns:
            (n, N) gradient in q and (6, N) gradient in the wrench.

        Source: reverse mode through eq. (4); the rigid-body sums are ours.
        """
        y = self.generalised_force
        blocks = [
            cotangent[3 * m : 3 * m + 3] if moved is None else cotangent[3 * m : 3 * m + 3] * moved
            for m, moved in enumerate(self.moved)
        ]
        y_bar = np.asarray(
            sum(
                dot(self.velocities[point], block)
                for point, block in zip(self.markers, blocks, strict=True)
            )
        )
        axis_bar = None
        if self.rotation:
            y_bar = y_bar + dot(self.turns, cotangent[-3:])
            axis_bar = self._turning(self._spread(cotangent[-3:] * y))
        if self.stiff is not None:
            levered = {s: y_bar[s] for s in self.levers}
            y_bar = np.where(self.stiff[:, None], 0.0, y_bar)
        if self.has_moment:
            moment = self._turning(self._spread(y_bar * self.moment))
            axis_bar = moment if axis_bar is None else axis_bar + moment
        velocity_bars: list[Array | None] = [None] * len(self.points)
        velocity_bars[_LOAD] = y_bar * self.force
        for point, block in zip(self.markers, blocks, strict=True):
            known = velocity_bars[point]
            velocity_bars[point] = block * y if known is None else known + block * y
        wrench_bar = np.concatenate(
            [(self.velocities[_LOAD] * y_bar).sum(axis=1), (self.turns * y_bar).sum(axis=1)]
        )
        spread = [None if bar is None else self._spread(bar) for bar in velocity_bars]
        q_bar = self._pull_points(spread, axis_bar)
        if self.weights is not None:
            q_bar = q_bar + self.weights.pull(self._spread(y_bar[None])[0])
        for s, share in self.levers.items():
            q_bar[share.compensator.joint] += levered[s] * share.slope(self.posture.q)
        return q_bar, wrench_bar

    def _pull_points(self, velocity_bars: list[Array | None], axis_bar: Array | None) -> Array:
        """Gradient in q from gradients in the velocities of the points and in the axes.

        Joint k turns every twist it carries, and moves the point as seen from every twist that
        it does not carry: a sum over the twists beyond it and a sum over those before it.
        """
        posture, m = self.posture, self.posture.robot.last
        axes, origins = posture.all_axes[:, :m], posture.all_origins[:, :m]
        slides = posture.robot.sliding[:m]
        carried = np.searchsorted(self.springs.body, np.arange(1, len(slides) + 1))
        turned: Array | None = None
        pulled: Array | None = None
        for at, arm, velocity_bar in zip(self.at, self.arms, velocity_bars, strict=True):
            if velocity_bar is None:
                continue
            arm_bar = self._turning(cross(velocity_bar, self.axes))
            bar = self._turning(cross(arm, velocity_bar))
            if self.sliding is not None:
                bar[:, self.sliding] = velocity_bar[:, self.sliding]
            axis_bar = bar if axis_bar is None else axis_bar + bar
            turn = cross(arm, arm_bar)
            turned = turn if turned is None else turned + turn
            force = _sums_before(arm_bar)[:, carried]
            pull = cross(at - origins, force)
            if slides.any():
                pull[:, slides] = force[:, slides]
            pulled = pull if pulled is None else pulled + pull
        assert turned is not None
        assert pulled is not None
        assert axis_bar is not None
        turned += cross(self.axes, axis_bar)
        before = _sums_before(turned)
        beyond = before[:, -1:] - before[:, carried]
        if slides.any():
            beyond[:, slides] = 0.0
        pulled += beyond
        pulled_along = dot(axes, pulled)
        if posture.robot.follows:
            return np.asarray(posture.robot.mixing[:m].T @ pulled_along)
        return pulled_along

    def combined(self, vectors: Array) -> Array:
        """(3, p, N) for the springs of what is (3, T, N) for the twists they displace."""
        if self._share is None:
            return vectors
        return np.einsum("tp,ctN->cpN", self._share, vectors)

    def _spread(self, vectors: Array) -> Array:
        """(3, T, N) gradients for the twists of what is (3, p, N) for the springs."""
        if self._share is None:
            return vectors
        return np.asarray(np.einsum("tp,cpN->ctN", self._share, vectors))

    def _twists(self) -> tuple[Array, Array]:
        """Axes and origins of the virtual joints in the base frame, (3, p, N) each."""
        springs, count = self.springs, self.posture.count
        if (self.joint >= 0).all():
            posture = self.posture
            return posture.all_axes[:, self.joint], posture.all_origins[:, self.joint]
        axes = np.empty((3, len(springs), count))
        origins = np.empty((3, len(springs), count))
        for j, body in enumerate(springs.body):
            axes[:, j] = self.posture.direction(springs.axis[j], body)
            origins[:, j] = self.posture.point(springs.origin[j], body)
        return axes, origins

    def _turning(self, vectors: Array) -> Array:
        """`vectors` (3, p, N) of the turning twists, zero for the sliding ones."""
        if self.sliding is None:
            return vectors
        vectors = vectors.copy()
        vectors[:, self.sliding] = 0.0
        return vectors


class WeightsOnSprings:
    """What weights exert on the springs of N configurations.

    Attributes:
        exerted: (p, N) generalised forces [N·m or N].
    """

    def __init__(self, arm: ElasticArm, of: Regressor) -> None:
        self._of, self._posture = of, of.posture
        self._weights = [
            (body, of.posture.point(center, body), force[:, None, None])
            for body, center, force in arm.weights
        ]
        slides = of.springs.prismatic
        exerted = np.zeros(of.axes.shape[1:])
        for body, at, force in self._weights:
            mine = of.springs.body < body
            velocity = velocities(of.axes[:, mine], at[:, None] - of.origins[:, mine], slides[mine])
            exerted[mine] += dot(velocity, np.broadcast_to(force, velocity.shape))
        self.exerted = of.combined(exerted[None])[0]

    def pull(self, bar: Array) -> Array:
        """(n, N) gradient in q of a scalar with gradient `bar` (T, N) in the twists' forces.

        Source: reverse mode; every body is pushed at its centre, every twist at its axis.
        """
        of, posture = self._of, self._posture
        robot, slides = posture.robot, of.springs.prismatic
        force = np.zeros((3, robot.bodies, posture.count))
        moment = np.zeros_like(force)
        for number, at, pulls in self._weights:
            body = robot.last if number == robot.bodies else number
            for t in np.flatnonzero(of.springs.body < number).tolist():
                joint = int(of.joint[t])
                own = joint + 1 if joint >= 0 else int(of.springs.body[t])
                axis, origin, given = of.axes[:, t], of.origins[:, t], pulls[:, 0] * bar[t]
                axis_bar = given
                if not slides[t]:
                    arm_bar = cross(given, axis)
                    force[:, body] += arm_bar
                    moment[:, body] += cross(at, arm_bar)
                    force[:, own] -= arm_bar
                    moment[:, own] -= cross(origin, arm_bar)
                    axis_bar = cross(at - origin, given)
                moment[:, own] += cross(axis, axis_bar)
        carries = robot.carries.astype(float)
        force = np.einsum("bk,cbN->ckN", carries, force)
        moment = np.einsum("bk,cbN->ckN", carries, moment)
        along = dot(posture.all_axes, moment - cross(posture.all_origins, force))
        sliding = robot.sliding
        if sliding.any():
            along[sliding] = dot(posture.all_axes[:, sliding], force[:, sliding])
        return np.asarray(robot.mixing.T @ along if robot.followers else along)


_LOAD = 0  # index of the load point among the distinct points


def _sums_before(vectors: Array) -> Array:
    """(3, p + 1, N) whose entry j is the sum of `vectors` (3, p, N) before j."""
    sums = np.zeros((3, vectors.shape[1] + 1, vectors.shape[2]))
    for j in range(vectors.shape[1]):  # faster than np.cumsum over a middle axis
        np.add(sums[:, j], vectors[:, j], out=sums[:, j + 1])
    return sums


def _distinct_points(tool: Tool) -> tuple[list[Array], list[int]]:
    """Distinct points of a tool, load point first, and the index of each marker among them."""
    points = [tool.load_point]
    indices = []
    for marker in tool.markers:
        same = [i for i, point in enumerate(points) if np.array_equal(point, marker)]
        if not same:
            points.append(marker)
        indices.append(same[0] if same else len(points) - 1)
    return points, indices
