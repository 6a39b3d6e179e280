"""Posing: from a study and its numerical bound to the statement of a proof.

Whatever cannot be said in a statement is left out so that the bound stays true and is only weaker,
and is named; what would make it false is refused.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.constraints import BeamRange
from elastocal.design.continuous import ContinuousDesign
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, Load
from elastocal.elastic.arm import ElasticArm
from elastocal.errors import Doubt, InputError
from elastocal.measuring.instrument import Isotropic, LaserTracker, positions_of
from elastocal.planning.aim import Aim
from elastocal.planning.certificate import Bound
from elastocal.proof.asked import asked, refuse_criterion
from elastocal.proof.eased import eased_design
from elastocal.proof.reference import sensitivity
from elastocal.proof.statement import (
    AnyDirection,
    CarriedSprings,
    ChainJoints,
    InCone,
    ProofLoad,
    Statement,
    SteadyLoad,
)
from elastocal.proof.used import used
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.stopping import Stop
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_TRIED = 400  # load cases of the numerical search that scale V
_NOTHING = 1e-9  # size of a row of V, in units of what is known of its unknown, that is rounding


@dataclass(frozen=True)
class ToProve:
    """What is to be proved of a study.

    Attributes:
        statement: All of it but what the proof finds; searched are the joints' whole ranges.
        beyond: Square of the loss that comes on top and no plan makes smaller [m²].
        doubts: What is left out, so that the bound is weaker than it could be.
    """

    statement: Statement
    beyond: float
    doubts: tuple[Doubt, ...]


def posed(
    study: Study,
    bound: Bound,
    rng: np.random.Generator | None = None,
    stop: Stop | None = None,
) -> ToProve:
    """The statement for a study and the numerical bound on its plans.

    V is M⁻¹K at the continuous design of the bound, scaled so that the largest sensitivity that
    was found is 1.

    Args:
        study: The study.
        bound: The bound.
        rng: Source of a search for a design of what the statement keeps, where it leaves out what
            errs; None: that of the bound will do.
        stop: Asked during that search whether to end.

    Raises:
        InputError: there is no bound, or of the study no proof can be made.
        Stopped: the search was to end.
    """
    if bound.design is None:
        raise InputError("there is no bound to be proved: the search found none")
    aim, space = bound.aim, bound.aim.space
    refuse(study, space)
    robot = space.arm.robot
    at_zero = Posture(robot, np.zeros((1, len(robot.joints))))
    sigma, sigma_turn, about_noise = _noise(space, at_zero)
    T = np.eye(4)
    T[:3] = at_zero.bodies[-1][:, :, 0].T
    constraints, unused = used(space.constraints, T)
    doubts = list(about_noise)
    if unused:
        doubts.append(Doubt("proof-leaves-out", unused))
    turns = 0 if space.errors is None else space.errors.turns
    if space.errors is not None:
        doubts.append(Doubt("proof-without-errors"))
    design = bound.design
    if rng is not None and (about_noise or space.errors is not None):
        design = eased_design(aim, sigma, sigma_turn, rng, stop)
    K, V = _asked_of_springs(study, aim, design.total, turns)
    unknowns = (*space.unknowns.names, *(f"turn of all loads {i + 1}" for i in range(turns)))
    tool = space.arm.tool
    statement = Statement(
        name=study.name,
        criterion=study.criterion,
        study_sha256=hashlib.sha256(study.text.encode()).hexdigest(),
        version=__version__,
        joints=_joints(robot, at_zero, space.limits),
        springs=_springs(space.arm, at_zero),
        make=np.pad(space.unknowns.make, ((0, 0), (0, turns))),
        unknowns=unknowns,
        markers=np.array([at_zero.point(marker)[:, 0] for marker in tool.markers]),
        sigma=sigma,
        sigma_turn=sigma_turn,
        load=_load(space.force, space.moment, at_zero.point(tool.load_point)[:, 0]),
        constraints=constraints,
        V=V,
        K=K,
        B=aim.base,
        count=aim.count,
        left_out=_left_out(doubts),
    )
    return ToProve(_scaled(statement, design), aim.beyond, tuple(doubts))


def refuse(study: Study, space: LoadCaseSpace) -> None:
    """Refuse a study of which there is no proof, as far as one can tell before there is a bound.

    Args:
        study: The study.
        space: Its load cases, or those of what its plans promise.

    Raises:
        InputError: says what there is no proof of.
    """
    robot, springs = space.arm.robot, space.arm.springs
    if robot.follows:
        raise InputError(
            f"robot {robot.name!r} has joints that follow others; of such chains there is no proof"
        )
    if study.experiments.weighs or springs.stiff.any() or (springs.only >= 0).any():
        raise InputError(
            "nothing is taken off the readings of this study; of absolute readings there is no "
            "proof"
        )
    refuse_criterion(study.criterion)
    _load(space.force, space.moment, np.zeros(3))


def _asked_of_springs(study: Study, aim: Aim, total: Array, turns: int) -> tuple[Array, Array]:
    """K and V of the unknowns that make springs, at an information matrix of these at least.

    The `turns` unknowns behind them, which turn all loads, are taken as known: their rows of V
    are zero.
    """
    size = aim.space.parameters
    p = size - turns
    whole = np.eye(size)
    whole[:p, :p] = total[:p, :p]
    K, V = asked(study, aim, whole)
    V[p:] = 0.0
    rows = np.linalg.norm(V, axis=1) * np.sqrt(np.diagonal(whole))
    V = np.where((rows > _NOTHING * rows.max())[:, None], V, 0.0)
    return K, V


def _joints(robot: Robot, at_zero: Posture, limits: Array) -> ChainJoints:
    return ChainJoints(
        names=robot.joint_names,
        slides=robot.prismatic,
        axis=at_zero.axes[:, :, 0].T,
        point=at_zero.origins[:, :, 0].T,
        lower=limits[0],
        upper=limits[1],
    )


def _springs(arm: ElasticArm, at_zero: Posture) -> CarriedSprings:
    springs = arm.springs
    axis, point = np.zeros((2, len(springs), 3))
    for j, body in enumerate(springs.body.tolist()):
        own = int(springs.joint[j])
        if own >= 0:
            axis[j], point[j] = at_zero.axes[:, own, 0], at_zero.origins[:, own, 0]
        else:
            axis[j] = at_zero.direction(springs.axis[j], body)[:, 0]
            point[j] = at_zero.point(springs.origin[j], body)[:, 0]
    return CarriedSprings(springs.names, springs.prismatic, springs.body, axis, point)


def _load(force: Load, moment: Load, point: Array) -> ProofLoad:
    """The load of a statement.

    Raises:
        InputError: free moments, or a load that is there or not.
    """
    if not isinstance(moment, FixedVector) or (
        moment.value.any() and not isinstance(force, FixedVector)
    ):
        raise InputError(
            "of torques there is a proof only where force and torque are the same in all "
            "experiments"
        )
    if isinstance(force, FixedVector):
        return SteadyLoad(point, force.value, moment.value)
    if isinstance(force, InPlane):
        return AnyDirection(point, force.size, force.basis)
    if not isinstance(force, FreeDirection):
        raise InputError("of loads that are there or not there is no proof")
    if force.half_angle >= np.pi / 2.0:  # a force and its opposite tell the same
        return AnyDirection(point, force.size, np.eye(3))
    return InCone(point, force.size, force.axis, force.half_angle)


def _noise(space: LoadCaseSpace, at_zero: Posture) -> tuple[float, float | None, tuple[Doubt, ...]]:
    """σ of positions and of rotations, at most what they are, and what is left out for that."""
    instrument = space.instrument
    doubts: list[Doubt] = []
    if instrument.single is not instrument:
        doubts.append(Doubt("proof-without-shared-noise"))
    points = positions_of(instrument.single)
    if isinstance(points, LaserTracker):
        sigma = _best_of(points, space, at_zero)
        doubts.append(Doubt("proof-best-noise", numbers={"sigma": sigma}, unit="m"))
    elif isinstance(points, Isotropic):
        sigma = points.sigma
    else:
        raise InputError(f"of readings by a {type(points).__name__} there is no proof")
    if space.errors is not None:
        # What each reading errs besides, whatever the load case: σ² is larger by that much.
        sizes = space.errors.sizes
        back = sizes.repeatability if len(space.arm.tool.markers) == 1 else 0.0
        sigma = float(np.sqrt(sigma**2 + sizes.discrepancy_length**2 + back**2))
    return sigma, instrument.single.sigma_rotation, tuple(doubts)


def _best_of(tracker: LaserTracker, space: LoadCaseSpace, at_zero: Posture) -> float:
    """The least σ of one coordinate of a deflection that a tracker has of any marker [m]."""
    ranges = []
    for marker in space.arm.tool.markers:
        nearest = _nearest(space, at_zero, tracker.position, at_zero.point(marker)[:, 0])
        for c in space.constraints:
            same = isinstance(c, BeamRange) and np.array_equal(c.position, tracker.position)
            if same and c.sign > 0.0 and np.array_equal(c.point, marker):  # type: ignore[attr-defined]
                nearest = max(nearest, float(c.bound))  # type: ignore[attr-defined]
        ranges.append(nearest)
    return float(np.sqrt(2.0) * np.min(tracker.deviations(np.array(min(ranges)))))


def _nearest(space: LoadCaseSpace, at_zero: Posture, place: Array, marker: Array) -> float:
    """What a marker is away from a place at least [m]: that from the first axis less the reach."""
    turning = np.flatnonzero(~space.arm.robot.prismatic)
    slides = np.abs(space.limits[:, space.arm.robot.prismatic]).max(axis=0, initial=0.0).sum()
    way = np.array([*at_zero.origins[:, turning, 0].T, marker])
    reach = np.linalg.norm(np.diff(way, axis=0), axis=1).sum() + slides
    return max(0.0, float(np.linalg.norm(way[0] - place) - reach))


def _left_out(doubts: list[Doubt]) -> tuple[str, ...]:
    """Names of constraints, and what else a statement leaves out."""
    names = {
        "proof-best-noise": "noise of the tracker beyond its least",
        "proof-without-errors": "errors of load cases",
        "proof-without-shared-noise": "noise that readings of a pose share",
    }
    found: list[str] = []
    for doubt in doubts:
        found += doubt.about if doubt.code == "proof-leaves-out" else [names[doubt.code]]
    return tuple(found)


def _scaled(statement: Statement, design: ContinuousDesign) -> Statement:
    """The same with V so that the largest sensitivity among the load cases found is 1."""
    dual = design.certificate
    best = np.argsort(-dual.s_found)[:_TRIED]
    x = np.concatenate([dual.x_found[best], dual.x_largest[None], design.x])
    largest = sensitivity(statement, x[:, : len(statement.joints)]).max()
    return replace(statement, V=statement.V / np.sqrt(largest))
