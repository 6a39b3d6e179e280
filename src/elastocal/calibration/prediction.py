"""What absolute readings should be, and how they change with everything they depend on.

A point x of the flange is read at p = T_station_base x(q + θ; g), where the springs have come to
rest at θ = k ∘ y(q + θ; g, payload). With v_j the velocity that a unit of geometric error or spring
j gives to the point,

    ∂x/∂g = v_g + v_θ (I - diag(k) H)⁻¹ diag(k) ∂y/∂g,        ∂x/∂k = v_θ (I - diag(k) H)⁻¹ diag(y)

Of two twists the one nearer to the base turns the other's lever: ∂y_s/∂g = a_up · Σ (v_down × F),
summed over what both carry. Source: ours; the geometry of loaded equilibria is textbook.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.calibration.arm_model import ArmModel, State, calibrated_robot, loaded_arm
from elastocal.calibration.parameters import Parameters
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import EquilibriumError
from elastocal.matrices import eliminated
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.robot.geometry import GeometricErrors, error_axes, turning
from elastocal.robot.posture import Posture, cross, dot, velocities
from elastocal.robot.rotations import (
    cross_matrices,
    from_rotation_vectors,
    rotation_vectors,
    turned_slope,
)

_CHUNK = 1024  # poses evaluated at once: what stays in the cache


@dataclass(frozen=True)
class Predicted:
    """What R readings should be.

    Attributes:
        error: (R, 3) reading minus prediction [m], of rotations the turn that is open [rad];
            frames of the stations.
        rows: (R, 3, U) what a unit of each unknown moves.
    """

    error: Array
    rows: Array


def predicted(
    model: ArmModel, positions: Positions, parameters: Parameters, state: State
) -> Predicted:
    """Errors of a state, and their rows.

    Raises:
        EquilibriumError: a pose has no stable rest with these compliances.
    """
    count = len(positions)
    found = Predicted(np.empty((count, 3)), np.zeros((count, 3, len(parameters))))
    robot = calibrated_robot(model, state)
    by_pose = np.argsort(positions.case, kind="stable")
    first = np.searchsorted(positions.case[by_pose], np.arange(len(positions.cases) + 1))
    pairs = np.stack([positions.mounting, positions.payload], axis=1)
    for mounting, payload in np.unique(pairs, axis=0).tolist():
        poses = np.flatnonzero((pairs == (mounting, payload)).all(axis=1))
        places = _Places(loaded_arm(model, state, robot, payload), model.errors, state.geometry)
        hung = payload in parameters.hung
        inside = parameters.inside(payload)
        for start in range(0, len(poses), _CHUNK):
            some = poses[start : start + _CHUNK]
            flange = _Flange(model, state, places, positions, some, hung)
            mine = np.concatenate([by_pose[first[i] : first[i + 1]] for i in some])
            where = np.repeat(np.arange(len(some)), np.diff(first)[some])
            _read(positions, parameters, state, flange, mounting, inside, (mine, where), found)
    return found


class _Places:
    """Where geometric errors act on the chain of a bent arm."""

    def __init__(self, arm: ElasticArm, errors: GeometricErrors, values: Array) -> None:
        robot, chain = arm.robot, arm.chain
        self.arm, self.turns = arm, turning(errors).astype(bool)
        axes, points = error_axes(errors, values, robot.last)
        rest = Posture(chain, np.zeros((1, len(chain.joints))))
        numbers = arm.numbers
        self.body = np.zeros(len(errors), dtype=np.int64)
        self.axis, self.point = np.zeros_like(axes), np.zeros_like(points)
        for g, body in enumerate(errors.body.tolist()):
            own = int(numbers[body])
            carrier = int(numbers[body + 1]) - 1 if body < robot.last else chain.last
            along = chain.shifts[own - 1] - errors.shifts[body]
            point = points[g] - [0.0, 0.0, along]
            R, origin = rest.bodies[own][:3, :, 0].T, rest.bodies[own][3, :, 0]
            R_carrier, at = rest.bodies[carrier][:3, :, 0].T, rest.bodies[carrier][3, :, 0]
            self.body[g] = carrier
            self.axis[g] = R_carrier.T @ (R @ axes[g])
            self.point[g] = R_carrier.T @ (R @ point + origin - at)
        self.turned = arm.actuated[[one.joint for one, _ in arm.compensators]]

    def on(self, posture: Posture) -> tuple[Array, Array]:
        """(3, G, N) axes and points [m], base frame."""
        axes = np.empty((3, len(self.body), posture.count))
        points = np.empty_like(axes)
        for body in np.unique(self.body).tolist():
            mine, frame = self.body == body, posture.bodies[body]
            axes[:, mine] = np.einsum("gi,icN->cgN", self.axis[mine], frame[:3])
            points[:, mine] = np.einsum("gi,icN->cgN", self.point[mine], frame[:3])
            points[:, mine] += frame[3][:, None]
        return axes, points


class _Flange:
    """The flange of N bent arms, and what moves it.

    Attributes:
        posture: Where everything is.
        axes, origins, slides: Twists that move the flange: geometric errors, joints that
            compensators turn, then the T joints of the chain that springs displace.
        levers: (C, N) of the compensators [m²].
        way: (T, W, N) how far those T joints go for a unit of each unknown: geometric errors,
            compliances, mass and moment of the payload.
    """

    def __init__(
        self,
        model: ArmModel,
        state: State,
        places: _Places,
        positions: Positions,
        some: IntArray,
        hung: bool,
    ) -> None:
        """`hung`: whether what hangs on the flange is an unknown."""
        arm = places.arm
        cases = positions.cases.chosen(some)
        springs = model.compliances.make @ state.compliance
        rest = equilibrium(arm, springs, cases)
        wrong = np.flatnonzero(~rest.stable)
        if len(wrong):
            raise EquilibriumError(
                f"pose {positions.names[some[wrong[0]]]!r} has no stable equilibrium with these "
                "compliances: the arm gives way under its weight; check masses and their units"
            )
        self.posture = Posture(arm.chain, arm.bent(cases.q, rest.displacement))
        axes, points = places.on(self.posture)
        joints, _ = arm.bent_by
        moving = np.append(places.turned, joints)
        self.levers = np.array(
            [one.lever(cases.q[:, one.joint]) for one in model.compensators]
        ).reshape(len(model.compensators), len(some))
        self.axes = np.concatenate([axes, self.posture.all_axes[:, moving]], axis=1)
        self.origins = np.concatenate([points, self.posture.all_origins[:, moving]], axis=1)
        self.slides = np.append(~places.turns, arm.chain.sliding[moving])
        self.tip = np.append(
            np.ones(len(places.body), dtype=bool), arm.chain.carries[arm.chain.last, moving]
        )
        self.turns = self.axes.copy()
        self.turns[:, self.slides] = 0.0
        self.first = len(places.body) + model.compliances.make.shape[1]  # of the compensators
        self.way = self._ways(model, places, cases, springs, hung)

    def _ways(
        self,
        model: ArmModel,
        places: _Places,
        cases: LoadCases,
        springs: Array,
        hung: bool,
    ) -> Array:
        """(T, W, N) see `way`."""
        arm, e, p = places.arm, len(places.body), model.compliances.make.shape[1]
        joints, share = arm.bent_by
        c = len(places.turned)
        g = e + c  # twists that no load makes
        count, wide = self.posture.count, g + p + 4 * hung
        if not len(joints):
            return np.zeros((0, wide, count))
        moving = np.append(places.turned, joints)
        mine, moves, own = slice(g, None), *self._moves(arm.chain, places.body, moving)
        pulled, levers = self._loads(arm, cases, moves)
        # Of two twists the one that carries the other turns its lever; itself counts once.
        above = np.array(moves[own[mine]])
        below = moves[own][:, mine].T.copy()
        below[:, e:] &= joints[:, None] != moving
        turns_s = self.turns[:, mine]
        slope = np.einsum("ctN,csN->stN", self.turns, levers[:, mine]) * above[..., None]
        slope += np.einsum("csN,ctN->stN", turns_s, levers) * below[..., None]
        moment = cases.wrench.T[3:]
        if moment.any():
            turned = cross(self.turns[:, None], turns_s[:, :, None])
            ahead = above & self.tip & self.tip[mine, None]
            slope += np.einsum("cstN,cN->stN", turned, moment) * ahead[..., None]
        effort, k = share.T @ pulled[mine], springs[:, None, None]
        right = np.empty((len(springs), wide, count))
        stiff = k * np.einsum("sp,sgN->pgN", share, slope[:, :g])
        right[:, :e], right[:, e + p : g + p] = stiff[:, :e], stiff[:, e:] * self.levers
        right[:, e : e + p] = effort[:, None] * model.compliances.make[..., None]
        if hung:
            right[:, g + p :] = k * np.einsum("sp,siN->piN", share, self._hung(arm, mine))
        inside = np.einsum("sp,stN,tq->pqN", share, slope[:, mine], share)
        tangent = np.eye(len(springs))[..., None] - k * inside
        return np.einsum("sp,pwN->swN", share, eliminated(tangent, right))

    def _moves(self, chain: Robot, body: IntArray, joints: IntArray) -> tuple[BoolArray, IntArray]:
        """(bodies, G + T) what each twist moves, and (G + T,) the body it sits on or moves.

        A geometric error behind a body moves what the next joint of the chain moves.
        """
        beyond = np.zeros((chain.bodies, len(body)), dtype=bool)
        inner = body < chain.last
        beyond[:, inner] = chain.carries[:, body[inner]]
        return np.hstack([beyond, chain.carries[:, joints]]), np.append(body, joints + 1)

    def _loads(self, arm: ElasticArm, cases: LoadCases, moves: BoolArray) -> tuple[Array, Array]:
        """(G + T, N) forces on all twists, and (3, G + T, N) sums of v × F over what each moves."""
        posture, masses = self.posture, arm.chain.masses
        shape = self.axes.shape
        velocity = np.zeros(shape)
        if arm.sags:
            mass = np.array([body.mass for body in masses])
            moment = np.stack(
                [body.mass * posture.point(body.center, body.body) for body in masses]
            )
            bears = moves[[body.body for body in masses]].T.astype(float)
            if arm.payload is not None:  # it hangs behind the last of the geometric errors
                bears[:, -1] = self.tip
            held = np.einsum("tl,lcN->ctN", bears, moment)
            total = (bears @ mass)[:, None]
            velocity = velocities(self.axes, held - total * self.origins, self.slides)
            velocity[:, self.slides] *= total[self.slides]
        gravity = np.broadcast_to(arm.gravity[:, None, None], shape)
        pulled, levers = dot(velocity, gravity), cross(velocity, gravity)
        if cases.wrench.any():
            tip = posture.point(arm.tool.load_point)
            force = np.broadcast_to(cases.wrench.T[:3, None], shape)
            ahead = self.at(tip)
            pulled += dot(ahead, force)
            pulled += dot(self.turned, np.broadcast_to(cases.wrench.T[3:, None], shape))
            levers += cross(ahead, force)
        return pulled, levers

    def _hung(self, arm: ElasticArm, mine: slice) -> Array:
        """(T, 4, N) force on the joints that bend for a unit of the payload's mass and moment."""
        posture, gravity = self.posture, arm.gravity[:, None, None]
        axes, origins, slides = self.axes[:, mine], self.origins[:, mine], self.slides[mine]
        frame = posture.bodies[-1]
        found = np.zeros((axes.shape[1], 4, posture.count))
        found[:, 0] = dot(
            velocities(axes, frame[3][:, None] - origins, slides),
            np.broadcast_to(gravity, axes.shape),
        )
        turns = self.turns[:, mine]
        for i in range(3):
            lever = cross(frame[i], np.broadcast_to(arm.gravity[:, None], frame[i].shape))
            found[:, 1 + i] = dot(turns, np.broadcast_to(lever[:, None], turns.shape))
        found[~self.tip[mine]] = 0.0
        return found

    def columns(self, velocity: Array) -> Array:
        """(3, W, N) of all unknowns, of what twists do, (3, G + T, N)."""
        g = velocity.shape[1] - len(self.way)
        columns = np.einsum("csN,swN->cwN", velocity[:, g:], self.way)
        c = len(self.levers)
        e = g - c
        columns[:, :e] += velocity[:, :e]
        if c:
            first = self.first
            columns[:, first : first + c] += velocity[:, e:g] * self.levers
        return columns

    def at(self, point: Array) -> Array:
        """(3, G + T, N) velocity that twists give to a flange point (3, N)."""
        velocity = velocities(self.axes, point[:, None] - self.origins, self.slides)
        velocity[:, ~self.tip] = 0.0
        return velocity

    @property
    def turned(self) -> Array:
        """(3, G + T, N) turn that twists give to the flange."""
        return np.where(self.tip[None, :, None], self.turns, 0.0)


def _read(
    positions: Positions,
    parameters: Parameters,
    state: State,
    flange: _Flange,
    mounting: int,
    inside: IntArray,
    mine: tuple[IntArray, IntArray],
    found: Predicted,
) -> None:
    """Fill in errors and rows of readings, made in given poses of a flange."""
    frame = flange.posture.bodies[-1]
    targets = positions.marker[mine[0]]
    for target in np.unique(targets).tolist():
        r, at = (part[targets == target] for part in mine)
        station = positions.station[r]
        turn = state.base[station, :3, :3]
        axes = turn @ frame[:3][..., at].transpose(2, 1, 0)  # of the flange, frame of the station
        if target < len(positions.tool.markers):
            point = flange.posture.point(state.markers[mounting, target])
            told = np.einsum("rij,jr->ri", turn, point[:, at])
            found.error[r] = positions.value[r] - told - state.base[station, :3, 3]
            columns = turn @ flange.columns(flange.at(point))[..., at].transpose(2, 0, 1)
            own, where = axes, parameters.marker(mounting, target)
            found.rows[r[:, None], :, parameters.base(station)[:, :3]] = np.eye(3)
            arms = -cross_matrices(told)
        else:
            told = axes @ state.probe[mounting]
            seen = from_rotation_vectors(positions.value[r])
            found.error[r] = rotation_vectors(seen @ told.transpose(0, 2, 1))
            arms = turned_slope(found.error[r]).transpose(0, 2, 1)
            columns = arms @ (turn @ flange.columns(flange.turned)[..., at].transpose(2, 0, 1))
            own, where = arms @ told, parameters.probe(mounting)
        found.rows[np.ix_(r, np.arange(3), where)] = own
        found.rows[r[:, None], :, parameters.base(station)[:, 3:]] = arms.transpose(0, 2, 1)
        found.rows[np.ix_(r, np.arange(3), inside)] = columns
