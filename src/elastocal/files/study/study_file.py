"""Study files: from YAML in degrees and millimetres to a `Study` in SI units."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints, merged
from elastocal.errors import ElastocalError, InputError, StudyError
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.files.schema import (
    ConeFile,
    ExperimentsFile,
    PriorFile,
    StudyFile,
    TestPoseFile,
    validate,
)
from elastocal.files.study.constraint_section import constraints_of, limits_of
from elastocal.files.study.instrument_section import instrument_of
from elastocal.files.study.joint_values import configuration
from elastocal.files.study.obstacle_section import clearances_of
from elastocal.files.study.pace_section import pace_of
from elastocal.files.study.robot_section import (
    coupling_of,
    find_tool,
    known_pose_of,
    robot_of,
    tool_of,
)
from elastocal.files.study.spring_section import extra_springs
from elastocal.files.study.view_section import view_of
from elastocal.files.texts import read_text
from elastocal.files.yaml_lines import Located, LocatedError, Path_, parse
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.pose_check import refuse_too_few
from elastocal.study.criteria import CRITERIA
from elastocal.study.study import Experiments, Study, TestPose, springs_of, test_pose

_LARGEST = 1_000_000  # bytes; a study file is a page of text


def read_study(path: str | Path) -> Study:
    """The study in a file.

    Raises:
        StudyError: the file is wrong; the message names line, key, what was found and expected.
    """
    return parse_study(read_text(Path(path), largest=_LARGEST), Path(path))


def parse_study(text: str, path: Path) -> Study:
    """The study in a text; `path` is for messages and for files named in the study."""
    document = parse(text, path)
    return _Reader(document, validate(document), text).study()


class _Reader:
    """Turns a validated file into values; every error gets its line here."""

    def __init__(self, document: Located, file: StudyFile, text: str) -> None:
        self.document, self.file, self.text = document, file, text

    def study(self) -> Study:
        file = self.file
        robot = self._at(("robot",), lambda: robot_of(file.robot, self.document.file))
        extra = self._at((), lambda: _extra_springs(robot, file))
        springs = self._at(("identify",), lambda: _springs(robot, file.identify, extra))
        tools = dict(robot.tools)
        for name, tool in file.tools.items():
            tools[name] = self._at(("tools", name), lambda n=name, t=tool: tool_of(n, t))
        if not file.test_poses:
            raise self._error(("test_poses",), "test_poses is empty; give at least one test pose")
        poses = tuple(
            self._at(("test_poses", i), lambda i=i, p=p: _test_pose(robot, springs, tools, p, i))
            for i, p in enumerate(file.test_poses)
        )
        names = [pose.name for pose in poses]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise self._error(("test_poses", i), f"two test poses are called {name!r}")
        experiments = self._at(("experiments",), lambda: _experiments(file.experiments, tools))
        limits = self._at(("constraints",), lambda: limits_of(robot, file.constraints))
        self._check_test_poses(robot, poses)
        if file.criterion not in CRITERIA:
            raise self._error(
                ("criterion",),
                f"criterion {file.criterion!r} is not known; expected one of {', '.join(CRITERIA)}",
            )
        self._check_involved(springs, poses)
        controller = self._at(("controller",), lambda: coupling_of(robot, file.controller))
        known = tuple(
            self._at(("check_poses", i), lambda i=i, p=p: known_pose_of(robot, tools, p, i))
            for i, p in enumerate(file.check_poses)
        )
        if known:
            self._at(("check_poses",), lambda: refuse_too_few(known))
        instrument = self._at(("instrument",), lambda: instrument_of(file.instrument))
        constraints = self._at(
            ("constraints",), lambda: constraints_of(file.constraints, experiments.tool)
        )
        folder = self.document.file.parent
        constraints += self._at(
            ("constraints",),
            lambda: clearances_of(file.constraints, robot, experiments.tool, limits, folder),
        )
        reflectors = file.tools.get(experiments.tool.name)
        tracker, others = file.instrument.tracker, constraints
        constraints += self._at(
            (),
            lambda: view_of(robot, experiments.tool, reflectors, tracker, others),
            ("instrument",),
        )
        pace = self._at((), lambda: pace_of(file.motion, file.campaign, robot, limits), ("motion",))
        study = self._at(
            ("constraints",),
            lambda: Study(
                robot=robot,
                springs=springs,
                test_poses=poses,
                experiments=experiments,
                instrument=instrument,
                pace=pace,
                gravity=np.array(file.gravity_m_s2 or [0.0, 0.0, 0.0]),
                constraints=constraints,
                limits=limits,
                controller=controller,
                known_poses=known,
                criterion=file.criterion,
                name=file.name or self.document.file.stem,
                text=self.text,
            ),
        )
        return self._with_prior(study)

    def _with_prior(self, study: Study) -> Study:
        if self.file.prior is None:
            return study
        prior = self.file.prior
        folder = self.document.file.parent
        matrix = self._at(("prior",), lambda: _prior(study, prior, folder))
        return replace(study, prior=matrix)

    def _check_test_poses(self, robot: Robot, poses: tuple[TestPose, ...]) -> None:
        for i, pose in enumerate(poses):
            if pose.case is None:
                continue
            for joint, value in zip(robot.joints, pose.case.q[0], strict=True):
                if not joint.lower - 1e-9 <= value <= joint.upper + 1e-9:
                    scale, unit = joint.kind.shown
                    raise self._error(
                        ("test_poses", i),
                        f"test pose {pose.name!r} has {joint.name} at {scale * value:.6g}{unit}, "
                        f"outside its limits {scale * joint.lower:.6g} to "
                        f"{scale * joint.upper:.6g}{unit}",
                    )

    def _check_involved(self, springs: VirtualJoints, poses: tuple[TestPose, ...]) -> None:
        if not any(np.any(pose.regressor) for pose in poses):
            raise self._error(
                ("test_poses",),
                "no test pose involves any of the compliances "
                f"{', '.join(springs.names)}: their deflections are zero there",
            )

    def _at(self, path: Path_, make: Any, usual: Path_ = ()) -> Any:
        """`make()`, with the line of `path` in front of an error that has none.

        An error that says where it is has the path below `path`; others are at `path` or `usual`.
        """
        try:
            return make()
        except StudyError:
            raise
        except LocatedError as error:
            raise self._error((*path, *error.path), str(error)) from None
        except InputError as error:
            raise self._error(path or usual, str(error)) from None

    def _error(self, path: Path_, message: str) -> StudyError:
        return StudyError(f"{self.document.where(path)}: {message}")


def _extra_springs(robot: Robot, file: StudyFile) -> dict[str, VirtualJoints]:
    """Springs of links and base, by name."""
    return extra_springs({n: s.model_dump() for n, s in (file.springs or {}).items()}, robot)


def _springs(
    robot: Robot, names: list[str] | None, extra: dict[str, VirtualJoints]
) -> VirtualJoints:
    """Springs to identify: those named, or all."""
    if names is None:
        names = [*robot.joint_names, *extra]
    in_joints = [name for name in names if name not in extra]
    found = springs_of(robot, in_joints) if in_joints or not names else None
    for name in dict.fromkeys(n for n in names if n in extra):
        found = extra[name] if found is None else merged(found, extra[name])
    if found is None:
        raise InputError("identify lists no springs; name at least one")
    return found


def _test_pose(
    robot: Robot, springs: VirtualJoints, tools: dict[str, Tool], entry: TestPoseFile, index: int
) -> TestPose:
    name = entry.name or f"test pose {index + 1}"
    if entry.regressor_Nm2 is not None:
        given = [
            k
            for k in ("tool", "q_deg", "q_mm", "force_N", "torque_Nm")
            if getattr(entry, k) is not None
        ]
        if given:
            raise LocatedError((given[0],), f"{name}: give either regressor_Nm2 or {given[0]}")
        rows = entry.regressor_Nm2
        if not rows or any(len(row) != len(springs) for row in rows):
            raise LocatedError(
                ("regressor_Nm2",),
                f"{name}: every row of regressor_Nm2 needs {len(springs)} numbers, one for each "
                f"of {', '.join(springs.names)}",
            )
        return TestPose(name, np.array(rows), entry.weight)
    if entry.tool is None:
        raise InputError(f"{name}: key 'tool' is missing")
    if entry.force_N is None and entry.torque_Nm is None:
        raise InputError(f"{name}: key 'force_N' is missing")
    wrench = np.append(entry.force_N or [0.0] * 3, entry.torque_Nm or [0.0] * 3)
    if not wrench.any():
        raise InputError(f"{name}: force and torque are zero, so nothing deflects there")
    q = configuration(robot, entry.q_deg, entry.q_mm)
    arm = ElasticArm(robot, springs, find_tool(tools, entry.tool))
    return test_pose(arm, LoadCases(q[None], wrench[None]), entry.weight, name)


def _experiments(entry: ExperimentsFile, tools: dict[str, Tool]) -> Experiments:
    force = _load(
        "force_N", entry.force_N, "max_force_N", entry.max_force_N, "direction", entry.direction
    )
    moment = _load(
        "torque_Nm",
        entry.torque_Nm,
        "max_torque_Nm",
        entry.max_torque_Nm,
        "torque_direction",
        entry.torque_direction,
    )
    if force is None and moment is None:
        raise InputError(
            "experiments say nothing of the load: give force_N, or max_force_N with direction"
        )
    none = FixedVector(np.zeros(3))
    if entry.max_configurations is not None and entry.max_configurations > entry.count:
        raise LocatedError(
            ("max_configurations",),
            f"max_configurations {entry.max_configurations} "
            f"is more than the {entry.count} experiments",
        )
    return Experiments(
        find_tool(tools, entry.tool),
        force or none,
        entry.count,
        entry.max_configurations,
        moment or none,
    )


def _load(
    fixed_key: str,
    fixed: list[float] | None,
    bound_key: str,
    bound: float | None,
    direction_key: str,
    direction: str | ConeFile | None,
) -> Load | None:
    """A fixed or free load from its keys; None if none is given."""
    if fixed is not None and (bound is not None or direction is not None):
        other = bound_key if bound is not None else direction_key
        raise LocatedError((other,), f"give either {fixed_key} or {bound_key} with {direction_key}")
    if fixed is not None:
        return FixedVector(np.array(fixed))
    if bound is None and direction is not None:
        raise LocatedError((direction_key,), f"{direction_key} needs {bound_key}")
    if bound is None:
        return None
    if direction is None:
        raise LocatedError(
            (bound_key,), f"{bound_key} needs {direction_key}: 'free', or axis and half_angle_deg"
        )
    if isinstance(direction, str):
        return FreeDirection(bound, np.array([0.0, 0.0, -1.0]))
    if not 0.1 <= direction.half_angle_deg <= 180.0:
        raise LocatedError(
            (direction_key,),
            f"half_angle_deg must be from 0.1 to 180, found {direction.half_angle_deg:g}; "
            "a narrower cone is a fixed direction",
        )
    try:
        return FreeDirection(
            bound, np.array(direction.axis), float(np.radians(direction.half_angle_deg))
        )
    except InputError as error:
        raise LocatedError((direction_key,), str(error)) from None


def _prior(study: Study, entry: PriorFile, folder: Path) -> Array:
    """(p, p) information [(N·m/rad)²] there is before the campaign."""
    names = study.springs.names
    given = [key for key in PriorFile.model_fields if getattr(entry, key) is not None]
    if len(given) != 1:
        raise InputError(
            f"prior needs exactly one of {', '.join(PriorFile.model_fields)}, found {len(given)}"
        )
    if entry.standard_error_rad_per_Nm is not None:
        known = np.zeros((len(names), len(names)))
        for name, error in entry.standard_error_rad_per_Nm.items():
            if name not in names:
                raise LocatedError(
                    (given[0], name),
                    f"{name!r} is not identified in this study; identified are {', '.join(names)}",
                )
            known[names.index(name), names.index(name)] = error**-2.0
        return known
    if entry.information_N2m2 is not None:
        rows = entry.information_N2m2
        if len(rows) != len(names) or any(len(row) != len(names) for row in rows):
            raise LocatedError(
                (given[0],),
                f"the information must be {len(names)} rows of "
                f"{len(names)} numbers, one for each of {', '.join(names)}",
            )
        information: Array = np.array(rows)
        if not np.allclose(information, information.T, rtol=1e-6):
            raise LocatedError((given[0],), "the information matrix is not symmetric")
        if np.linalg.eigvalsh(information)[0] < -1e-9 * np.abs(information).max():
            raise LocatedError((given[0],), "the information matrix has a negative eigenvalue")
        return information
    assert entry.plan is not None
    try:
        proposal = read_proposal(folder / entry.plan, study)
    except ElastocalError as error:
        raise LocatedError(("plan",), f"prior plan: {error}") from None
    each = study.space.information(proposal.load_cases)
    return np.asarray(np.einsum("i,ijk->jk", proposal.repeats.astype(float), each))
