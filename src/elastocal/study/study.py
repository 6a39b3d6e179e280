"""Study: everything that defines a calibration campaign, as one frozen value.

In: what a study file says. Out: the design space, the criterion and the test poses, in SI units.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.constraints import Clearance, Constraint, HeldJoint, JointLimit
from elastocal.elastic.allowed_loads import FixedVector, Load
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
from elastocal.errors import InputError
from elastocal.measuring.instrument import Instrument
from elastocal.motion.pace import Pace, for_robot
from elastocal.motion.rest import at_rest
from elastocal.motion.space import MotionSpace
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.controller_axes import Coupling, uncoupled
from elastocal.robot.payloads import Payload
from elastocal.robot.pose_check import KnownPose
from elastocal.study.before import CarriedOut, Done, Earlier
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.known import Known
from elastocal.study.robustness import Robustness
from elastocal.study.test_path import TestPath
from elastocal.wording.numbers import bounded, described


@dataclass(frozen=True)
class TestPose:
    """Where accuracy is judged: a load case of the real task with its tool, or its regressor.

    Attributes:
        name: What the user calls it.
        regressor: (r, p) A0: deflection [m] = A0 · compliance.
        weight: Relative weight; zero: judged, not planned for.
        tool: Tool, None if the regressor was given.
        case: The one load case, None if the regressor was given.

    Source: paper, definition D3.
    """

    __test__ = False  # not a test, whatever pytest may think

    name: str
    regressor: Array
    weight: float = 1.0
    tool: Tool | None = None
    case: LoadCases | None = None

    def __post_init__(self) -> None:
        freeze(self, "regressor")

    @property
    def regressors(self) -> Array:
        """(1, r, p) A0 of its one point, as those of a `TestPath`."""
        return self.regressor[None]

    @property
    def cases(self) -> LoadCases | None:
        """The same as `case`, as those of a `TestPath`."""
        return self.case


def test_pose(arm: ElasticArm, case: LoadCases, weight: float, name: str) -> TestPose:
    """Test pose of a load case: the deflection of the TCP under the process wrench."""
    rows = regressor(replace(arm, tool=arm.tool.at_tcp), case)[0]
    return TestPose(name, rows, weight, arm.tool, case)


test_pose.__test__ = False  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Experiments:
    """What is done in the calibration experiments.

    Attributes:
        tool: Tool with load point and markers.
        force: Which forces may act [N].
        count: Number of experiments m.
        max_configurations: Most distinct load cases, None for as many as experiments.
        moment: Which moments may act [N·m].
        robust: What a plan is to withstand; None: that is not asked for.
        weighs: Whether nothing is taken off the readings, so that weights are loads as well.
        payload: What hangs on the flange by its weight in every experiment; None for nothing.
    """

    tool: Tool
    force: Load
    count: int
    max_configurations: int | None = None
    moment: Load = field(default_factory=lambda: FixedVector(np.zeros(3)))
    robust: Robustness | None = None
    weighs: bool = False
    payload: Payload | None = None

    @property
    def distinct(self) -> int:
        """Most distinct load cases that a plan may have."""
        return min(self.count, self.max_configurations or self.count)

    def __post_init__(self) -> None:
        if not 1 <= self.count <= 1_000_000:
            raise InputError(
                f"the number of experiments must be from 1 to 1000000, found {self.count}"
            )
        if self.max_configurations is not None and self.max_configurations < 1:
            raise InputError(
                f"max_configurations must be at least 1, found {self.max_configurations}"
            )
        if not self.weighs and self.force.size == 0.0 and self.moment.size == 0.0:
            raise InputError(
                "the experiments have neither force nor torque: without load nothing deflects "
                "and nothing can be identified"
            )


@dataclass(frozen=True)
class Study:
    """A calibration campaign to be planned.

    Attributes:
        robot: The robot.
        springs: The p compliances to identify.
        test_poses: Where accuracy is judged: poses and paths.
        experiments: What is done.
        instrument: What measures the deflections, and whether the rotation of the flange too.
        constraints: Constraints on configurations besides the joint limits.
        limits: (2, n) lower and upper joint values allowed [rad or m]; the robot's if not given.
        criterion: Name of the criterion to plan for; see `criteria.CRITERIA`.
        prior: (f, f) information there is already [(N·m/rad)²]; none if not given.
        pace: How long things take at the cell; the usual if not given. Home, if not given, is at
            rest, or where the robot would touch something there, at round angles near it.
        gravity: (3,) acceleration that the masses of the links feel [m/s²]; zero: left out.
        controller: What the controller shows for the joint values of the model; the same if None.
        known_poses: Poses read off at the robot, to check the model with.
        name: What the user calls it.
        text: The study file as written, empty if there is none.
        done: What was measured before, if the plan is for the rest; `prior` counts it already.
        known: Springs that bend besides, as an earlier campaign found them; `prior` counts it
            already, and test poses see them: see `two_steps.with_known`.
        carried_out: A plan that was carried out before; `prior` counts it already.
        earlier: What an earlier campaign found of the springs; `prior` counts it already.
        nuisance: What moves readings and tools besides, that nobody asks for; `prior` counts its
            priors already, and test poses see it: see `two_steps.with_nuisance`.
        endless: (2, n) which limits nobody gave: the joint turns without end; found out if not
            given.
    """

    robot: Robot
    springs: VirtualJoints
    test_poses: tuple[TestPose | TestPath, ...]
    experiments: Experiments
    instrument: Instrument
    constraints: tuple[Constraint, ...] = ()
    limits: Array = field(default_factory=unset)
    criterion: str = "test-pose"
    prior: Array = field(default_factory=unset)
    pace: Pace = field(default_factory=Pace)
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    controller: Coupling | None = None
    known_poses: tuple[KnownPose, ...] = ()
    name: str = "study"
    text: str = ""
    done: Done | None = None
    known: Known | None = None
    carried_out: CarriedOut | None = None
    earlier: Earlier | None = None
    nuisance: Nuisance | None = None
    endless: BoolArray = field(default_factory=lambda: frozen([], np.bool_))

    def __post_init__(self) -> None:
        self._tell_tool_what_is_measured()
        limits = self.limits if self.limits.size else [self.robot.lower, self.robot.upper]
        endless = self.endless if self.endless.size else ~np.isfinite(limits)
        freeze(self, endless=endless, dtype=np.bool_)
        freeze(self, limits=_finite_limits(self.robot, np.array(limits)))
        unsaid = not self.pace.home.size
        object.__setattr__(self, "pace", for_robot(self.pace, self.robot, self.limits))
        if unsaid:
            object.__setattr__(self, "pace", at_rest(self.motion_space).pace)
        f = len(self.fitted)
        prior = self.prior if self.prior.size else np.zeros((f, f))
        freeze(self, prior=prior, gravity=np.reshape(self.gravity, 3))
        check_weights([pose.weight for pose in self.test_poses])

    @property
    def shares(self) -> Array:
        """(T,) weights of the test poses, of sum 1."""
        weights = np.array([pose.weight for pose in self.test_poses])
        return np.asarray(weights / weights.sum())

    @property
    def path_hashes(self) -> dict[str, str]:
        """Hashes of the files of the test paths, by the names the study has for them."""
        paths = (pose for pose in self.test_poses if isinstance(pose, TestPath))
        return {path.source: path.sha256 for path in paths if path.source}

    @property
    def prior_file(self) -> tuple[str, str]:
        """The file that the prior is from, as it is named, and its hash; empty if there is none."""
        for before in (self.carried_out, self.earlier):
            if before is not None:
                return before.source, before.sha256
        return "", ""

    @property
    def only_path(self) -> TestPath | None:
        """The path that is planned for, if it is the only thing."""
        pose = self.planned_for[0] if len(self.planned_for) == 1 else None
        return pose if isinstance(pose, TestPath) else None

    @property
    def planned_for(self) -> tuple[TestPose | TestPath, ...]:
        """The test poses that count in the criterion: those with a weight."""
        return tuple(pose for pose in self.test_poses if pose.weight > 0.0)

    def _tell_tool_what_is_measured(self) -> None:
        """The tool is asked for the rotation of the flange if, and only if, it is measured."""
        e, rotation = self.experiments, self.instrument.sigma_rotation is not None
        if e.tool.rotation != rotation:
            asked = replace(e, tool=replace(e.tool, rotation=rotation))
            object.__setattr__(self, "experiments", asked)

    @property
    def sigma(self) -> float:
        """Standard deviation of one measured coordinate [m], typical if it varies."""
        return self.instrument.sigma

    @cached_property
    def sought(self) -> VirtualJoints:
        """The springs that are each an unknown: those to identify, and those not known exactly."""
        return self.springs if self.known is None else merged(self.springs, self.known.uncertain)

    @cached_property
    def fitted(self) -> Unknowns:
        """The f unknowns that are fitted: the springs that are sought, then the nuisance."""
        each = each_spring(self.sought)
        return each if self.nuisance is None else joined(each, self.nuisance.unknowns)

    @property
    def wanted(self) -> list[int]:
        """(p,) positions of the springs to identify among the fitted ones."""
        return [self.fitted.names.index(name) for name in self.springs.names]

    @property
    def fitted_arm(self) -> ElasticArm:
        """The robot with all springs that what is fitted makes, and the calibration tool."""
        return self._arm(self.fitted.springs)

    def _arm(self, springs: VirtualJoints) -> ElasticArm:
        e = self.experiments
        return ElasticArm(self.robot, springs, e.tool, self.gravity, e.payload, e.weighs)

    @cached_property
    def arm(self) -> ElasticArm:
        """The robot with the springs to identify and the calibration tool."""
        return self._arm(self.springs)

    @property
    def coupling(self) -> Coupling:
        """What the controller shows for the joint values of the model."""
        return self.controller or uncoupled(self.robot)

    @property
    def space(self) -> LoadCaseSpace:
        """The load cases to choose from; their rows are of all that is fitted."""
        e, fitted = self.experiments, self.fitted
        return LoadCaseSpace(
            self.fitted_arm,
            e.force,
            e.moment,
            self.constraints,
            self.instrument,
            self.limits,
            None if fitted.plain else fitted,
        )

    @property
    def motion_space(self) -> MotionSpace:
        """Where the robot moves from load case to load case."""
        clearances = tuple(c for c in self.constraints if isinstance(c, Clearance))
        rest = (c for c in self.constraints if not isinstance(c, Clearance))
        holding = tuple(c for c in rest if not c.measuring)
        return MotionSpace(self.robot, self.limits, self.pace, clearances, holding)

    @property
    def bounds(self) -> Array:
        """(2, n) limits that must hold [rad or m]: infinite where a joint turns without end.

        Planning looks for such a joint within half a turn: see `limits`.
        """
        planned = self.endless & (np.abs(self.limits) == np.pi)
        return np.where(planned, [[-np.inf], [np.inf]], self.limits)

    @property
    def held(self) -> BoolArray:
        """(n,) joints that are held at a value: their limits are equal."""
        return np.asarray(self.limits[0] == self.limits[1])

    @property
    def joint_limits(self) -> tuple[Constraint, ...]:
        """The joint limits as constraints, two per joint that has any, one per joint held."""
        constraints: list[Constraint] = []
        for i, joint in enumerate(self.robot.joints):
            if self.held[i]:
                value, unit = self.limits[0, i], joint.kind.unit
                name = bounded(joint.name, "=", value, unit)
                constraints.append(HeldJoint(name, i, value, unit=unit))
                continue
            for bound, upper, sign in (
                (self.bounds[0, i], False, ">="),
                (self.bounds[1, i], True, "<="),
            ):
                if not np.isfinite(bound):
                    continue
                name = bounded(joint.name, sign, bound, joint.kind.unit)
                constraints.append(JointLimit(name, i, bound, upper=upper, unit=joint.kind.unit))
        return tuple(constraints)


def with_count(study: Study, count: int, configurations: int | None = None) -> Study:
    """The same study with another number of experiments, and of configurations (None: any)."""
    experiments = replace(study.experiments, count=count, max_configurations=configurations)
    return replace(study, experiments=experiments)


def with_load_cases(study: Study, repeats: IntArray) -> Study:
    """The same study for as many experiments as load cases are repeated, (S,), and room for all."""
    most = study.experiments.max_configurations
    return with_count(study, int(repeats.sum()), most and max(most, len(repeats)))


def springs_of(robot: Robot, names: list[str] | None) -> VirtualJoints:
    """Joint springs to identify, in chain order.

    Raises:
        InputError: none, unknown or repeated joints.
    """
    if names is not None and not names:
        raise InputError("identify lists no joints; name at least one")
    if names is not None and len(set(names)) != len(names):
        repeated = next(name for name in names if names.count(name) > 1)
        raise InputError(f"identify lists joint {repeated!r} twice")
    if names is not None:
        order = robot.index(names)
        names = [robot.joint_names[i] for i in sorted(order)]
    return joint_springs(robot, names)


def check_weights(weights: list[float]) -> None:
    """Refuse weights of test poses that leave nothing to plan for.

    Raises:
        InputError: one is negative or not finite, or all are zero.
    """
    if not all(0.0 <= weight < np.inf for weight in weights):
        raise InputError(f"weights of test poses must be 0 or more and finite, found {weights}")
    if weights and not any(weights):
        raise InputError(
            "every test pose has weight 0, so there is nothing to plan for; give at least one "
            "of them a weight above 0"
        )


def _finite_limits(robot: Robot, limits: Array) -> Array:
    """Limits for planning: a joint that turns without end is planned within half a turn."""
    for i, joint in enumerate(robot.joints):
        if joint.prismatic and not np.isfinite(limits[:, i]).all():
            raise InputError(
                f"joint {joint.name!r} slides and has no limits; give it some in "
                "constraints: joint_limits_mm"
            )
        if not joint.prismatic:
            limits[:, i] = np.where(np.isfinite(limits[:, i]), limits[:, i], [-np.pi, np.pi])
        if not limits[0, i] <= limits[1, i]:
            lower, upper = (described(bound, joint.kind.unit, 6) for bound in limits[:, i])
            raise InputError(
                f"joint {joint.name!r} has no room left: its lower limit with margin is "
                f"{lower}, the upper one {upper}"
            )
    return limits
