"""What is named on the command line, as values: files, tools, configurations.

Imported by the commands when they run; each function loads the readers that it needs, for most
commands need few.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.cli.number_options import flaw
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.elastic.case_errors import CaseErrors
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.elastic.load_cases import LoadCases
    from elastocal.files.plans.proposal_file import Proposal
    from elastocal.files.study.known import KnownOf
    from elastocal.identification.fit import Fit
    from elastocal.robot.chain import Robot, Tool
    from elastocal.study.absolute import AbsoluteStudy
    from elastocal.study.study import Study


@dataclass(frozen=True)
class Files:
    """Files of a campaign, as far as there are any.

    Attributes:
        measurements: What was measured.
        model: The model that was made of it; it says how.
        mapping: What foreign headers mean.
        prior: Model from before, weighed by its covariance.
        known: Model of further joints, which bend and are fitted along.
        validation: What was measured and kept aside.
        path: Path of the task, as it is wanted.
        truth: True compliances, for virtual campaigns.
    """

    measurements: list[Path] = field(default_factory=list)
    model: Path | None = None
    mapping: Path | None = None
    prior: Path | None = None
    known: Path | None = None
    validation: list[Path] = field(default_factory=list)
    path: Path | None = None
    truth: Path | None = None

    @property
    def all(self) -> list[Path]:
        """Every file."""
        single = (self.model, self.mapping, self.prior, self.known, self.path, self.truth)
        return [*self.measurements, *self.validation, *(p for p in single if p is not None)]


def sources_of(study: Study | AbsoluteStudy, beside: Path, known: Path | None = None) -> list[Path]:
    """The files that a study names, which nothing is to be written over.

    Args:
        study: The study.
        beside: Its file; what it names stands in the same folder.
        known: What was named in place of its key `known`.
    """
    from elastocal.files.study.study_file import named_files

    return named_files(study.text, beside) + ([known] if known else [])


def plan_and_study(plan: Path, study: Path | None) -> tuple[Proposal, Study]:
    """A plan, and its study: the one in a file, or else the one embedded in the plan."""
    from elastocal.files.plans.plan_file import read_with_study
    from elastocal.files.study.study_file import read_study

    return read_with_study(plan, None if study is None else read_study(study))


def proposals(paths: list[Path], study: Study) -> dict[str, Proposal]:
    """Plans by the names of their files, by their whole paths where names are alike."""
    from elastocal.files.plans.proposal_file import read_proposal

    named: dict[str, Proposal] = {}
    for path in paths:
        named[path.name if path.name not in named else str(path)] = read_proposal(path, study)
    return named


def baselines(study: Study, proposed: dict[str, Proposal]) -> dict[str, Proposal]:
    """Measuring in the test poses, once for each number of experiments of the plans."""
    from elastocal.files.plans.proposal_file import Proposal
    from elastocal.planning.baseline import in_test_poses

    counts = sorted({proposal.count for proposal in proposed.values()})
    named = {}
    for m in counts:
        name = "in the test poses" + (f", m = {m}" if len(counts) > 1 else "")
        named[name] = Proposal(name, *in_test_poses(study, m))
    return named


def knowing_as(study: Study, proposals: dict[str, Proposal]) -> Study:
    """The study with what its plans knew of further springs, if it does not say itself.

    Raises:
        InputError: they knew different things.
    """
    from elastocal.study.two_steps import with_known

    known = {p.known.sha256: p.known for p in proposals.values() if p.known is not None}
    if study.known is not None or not known:
        return study
    if len(known) > 1:
        raise InputError(
            "the plans knew different things of further springs, "
            f"{' and '.join(k.source for k in known.values())}; name one as `known` in the study"
        )
    return with_known(study, next(iter(known.values())))


def only_proposal(paths: list[Path], study: Study) -> Proposal:
    """The plan of a single campaign."""
    from elastocal.files.plans.proposal_file import read_proposal

    if len(paths) != 1:
        raise InputError(f"one campaign needs one plan, found {len(paths)}; see --campaigns")
    return read_proposal(paths[0], study)


def model_at(path: Path | None, robot: Robot) -> ComplianceModel | None:
    """The model in a file, None if no file is named."""
    if path is None:
        return None
    from elastocal.files.models.model_file import read_model

    return read_model(path, robot)


def known_in(path: Path | None) -> KnownOf | None:
    """What a file named on the command line knows of further springs; None: as the study says."""
    if path is None:
        return None
    from elastocal.files.study.known import known_at
    from elastocal.files.study.study_file import parse_study

    return lambda robot: known_at(path, robot, parse_study)


def known_model(path: Path | None, study: Study) -> ComplianceModel | None:
    """The compliances of further springs, from a file or as the study knows them.

    Raises:
        InputError: the study has a plan only, which has no compliances yet.
    """
    if path is not None:
        from elastocal.files.models.model_file import read_model

        return read_model(path, study.robot)
    if study.known is None:
        return None
    if study.known.planned:
        raise InputError(
            f"{study.known.source}: a plan has no compliances of "
            f"{', '.join(study.known.model.names)}; name the model that was identified by it with "
            "--known"
        )
    return study.known.model


def models_at(paths: list[Path], robot: Robot) -> ComplianceModel:
    """Models of different joints as one."""
    from elastocal.elastic.compliance_model import merged_models
    from elastocal.files.models.model_file import read_model

    return merged_models([read_model(path, robot) for path in paths])


def fit_of(model: Path | None, confidence: float = 0.95) -> Fit:
    """How a model was fitted, as its file says; by default settings if it does not."""
    from elastocal.files.models.model_file import model_sections
    from elastocal.identification.fit import Fit

    how = {} if model is None else model_sections(model)["identification"]
    return Fit(
        how.get("model", "equilibrium"),
        how.get("sigma", "known"),
        how.get("loss", "squares"),
        bool(how.get("nonnegative", False)),
        confidence,
        how.get("fitted", "mixed"),
    )


def errors_of(study: Study) -> CaseErrors | None:
    """What errs from load case to load case, if the study says anything of it."""
    return None if study.nuisance is None else study.nuisance.errors


def identified_cases(model: Path | None, robot: Robot) -> LoadCases | None:
    """The load cases that a model was made from, as its file says; None if it does not."""
    from elastocal.files.models.model_file import model_sections
    from elastocal.files.plans.load_case_entries import read_load_cases

    entries = None if model is None else model_sections(model)["identification"].get("load_cases")
    where = f"{model}: identification.load_cases"
    return read_load_cases(entries, robot, where) if entries else None


def tool_called(study: Study, name: str | None) -> Tool:
    """The tool called `name`, else the one of all test poses."""
    posed = {pose.tool.name: pose.tool for pose in study.test_poses if pose.tool is not None}
    if name is None:
        if len(posed) != 1:
            raise InputError(
                f"the test poses have {', '.join(posed) or 'no tool'}; name one with --tool"
            )
        return next(iter(posed.values()))
    calibration = study.experiments.tool
    tools = study.robot.tools | {calibration.name: calibration} | posed
    if name not in tools:
        raise InputError(f"no tool {name!r}; there are {', '.join(tools)}")
    return tools[name]


def start_of(study: Study, tool: Tool, text: str | None = None) -> Array:
    """Configuration to start from: as named, else a test pose, with the same tool if possible."""
    if text is not None:
        return joint_values(text, study.robot, "start")
    poses = sorted(
        (pose for pose in study.test_poses if pose.case is not None and pose.tool is not None),
        key=lambda pose: pose.tool is None or pose.tool.name != tool.name,
    )
    if poses and poses[0].case is not None:
        return poses[0].case.q[0]
    return np.asarray(0.5 * (study.limits[0] + study.limits[1]))


Vector = tuple[float, float, float]


def load(force: Vector | None, torque: Vector | None) -> Array | None:
    """(6,) one load for all points of a path [N, N·m]; None if none is named."""
    if force is None and torque is None:
        return None
    return np.array([*(force or (0.0, 0.0, 0.0)), *(torque or (0.0, 0.0, 0.0))])


def with_path(
    study: Study, path: Path, tool: str | None, wrench: Array | None, start: str | None
) -> Study:
    """The study, judged along the path in a file besides; nothing is planned for it."""
    from elastocal.files.paths.path_file import read_path
    from elastocal.study.test_path import test_path

    used = tool_called(study, tool)
    task = read_path(path, study.robot, used, start_of(study, used, start), wrench)
    if not task.cases.wrench.any():
        print(
            f"note: {path} has no loads, so nothing is deflected along it and its error of 0 says "
            "nothing; give --force-n, or columns of loads",
            file=sys.stderr,
        )
    names = [pose.name for pose in study.test_poses]
    judged = test_path(replace(study.fitted_arm, tool=used), task.cases, 0.0, path.name)
    judged = replace(
        judged,
        regressors=study.fitted.columns(judged.regressors),
        name=path.name if path.name not in names else str(path),
        points=task.names,
        remarks=task.remarks,
    )
    return replace(study, test_poses=(*study.test_poses, judged))


def joint_values(text: str, robot: Robot, what: str) -> Array:
    """(n,) joint values of "A1=0deg A2=-90deg rail=500mm", every joint once [rad or m]."""

    values: dict[str, float] = {}
    for part in text.replace(",", " ").replace("°", "deg").split():
        found = re.fullmatch(r"([^=]+)=(.+?)(deg|mm)", part)
        if not found:
            raise InputError(f"{what}: expected name=value with deg or mm, found {part!r}")
        name, word, unit = found.groups()
        joint = robot.joints[robot.index([name])[0]]
        if unit != joint.kind.key:
            raise InputError(
                f"{what}: joint {name!r} is given in {unit}, expected {joint.kind.key}"
            )
        if name in values:
            raise InputError(f"{what}: joint {name!r} is given twice")
        if wrong := flaw(word):
            raise InputError(f"{what}: joint {name!r}: {wrong}")
        values[name] = joint.kind.si * float(word)
    missing = [name for name in robot.joint_names if name not in values]
    if missing:
        raise InputError(f"{what}: joint {missing[0]!r} is missing")
    return frozen([values[name] for name in robot.joint_names])
