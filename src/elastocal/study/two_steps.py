"""What a study fits besides what it asks for: springs of an earlier campaign, and nuisance.

In: a study, what is known, or nuisance. Out: the same study with these in its design space, their
information as prior, and test poses that see their errors.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel, refuse_other_springs, rows_of
from elastocal.elastic.effects import without
from elastocal.elastic.known_together import known_together
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import merged, subset
from elastocal.elastic.unknowns import Unknowns
from elastocal.errors import InputError
from elastocal.study.known import Known
from elastocal.study.study import Study, TestPose, test_pose
from elastocal.study.test_path import TestPath, test_path


def with_known(study: Study, known: Known | None) -> Study:
    """The study that knows what an earlier campaign found, in place of what it knew of others.

    Springs that the study itself identifies are not taken from it; what of its nuisance is known
    is no nuisance any more.

    Raises:
        InputError: nothing is known but what the study identifies; a test pose is a matrix, which
            has no columns for the known springs; the plan that is known is also the prior.

    Source: ours; the information of wanted and known springs adds up over load cases.
    """
    if known is None and study.known is None:
        return study
    if known is not None:
        refuse_other_springs(known.model, study.springs)
        others = _others(study, known)
        left_out = tuple(n for n in known.model.names if n not in others) or known.left_out
        known = replace(known, model=_part(known.model, others), left_out=left_out)
        _refuse_twice(study, known)
    nuisance = study.nuisance
    if known is not None and nuisance is not None:
        nuisance = without(study.robot, nuisance, merged(study.springs, known.model.springs))
    return _beside(study, known, nuisance)


def with_nuisance(study: Study, nuisance: Nuisance | None) -> Study:
    """The study that knows what moves readings and tools besides; None: nothing does.

    Raises:
        InputError: a nuisance parameter has the name of a spring of the study; a test pose is a
            matrix, which has no columns for it.
    """
    return study if nuisance is study.nuisance else _beside(study, study.known, nuisance)


def _beside(study: Study, known: Known | None, nuisance: Nuisance | None) -> Study:
    """The study with other things beside what it asks for."""
    own_names = {*study.springs.names, *(() if known is None else known.model.names)}
    if nuisance is not None:
        for name in (*nuisance.names, *nuisance.unknowns.springs.names):
            if name in own_names:
                raise InputError(
                    f"{name!r} is the name of something that is nuisance; give the spring of the "
                    "study another name"
                )
    own = (study.prior - _of_earlier(study)[0])[np.ix_(study.wanted, study.wanted)]
    bare = replace(study, known=known, nuisance=nuisance, prior=unset(), test_poses=())
    prior = np.array(bare.prior)
    if study.done is not None and study.done.readings is not None:
        again = study.done.readings.information(bare.fitted_arm, bare.fitted)
        bare = replace(bare, done=replace(study.done, information=again))
        prior += again
    if study.carried_out is not None:  # its experiments bent the known springs, too
        prior += study.carried_out.information(bare.space)
    prior[np.ix_(bare.wanted, bare.wanted)] = own
    found, told = _of_earlier(bare)
    prior += found
    given = [] if known is None else [(known.uncertain.names, known.information)]
    if nuisance is not None:
        information = np.diag(np.where(told, 0.0, nuisance.deviation**-2.0))
        given.append((nuisance.names, information))
    for names, information in given:
        index = [bare.fitted.names.index(name) for name in names]
        prior[np.ix_(index, index)] += information
    poses = tuple(_over(study, pose, bare.fitted) for pose in study.test_poses)
    return replace(bare, prior=prior, test_poses=poses)


def _of_earlier(study: Study) -> tuple[Array, BoolArray]:
    """(f, f) what the model of an earlier campaign knows, and which nuisance parameters it counts.

    The same that a fit to the readings will count.
    """
    names = study.fitted.names
    information, nuisance = np.zeros((len(names), len(names))), study.nuisance
    told = np.zeros(0 if nuisance is None else len(nuisance.names), dtype=bool)
    if study.earlier is None:
        return information, told
    model, own = study.earlier.model, study.springs.names
    both = None if nuisance is None else known_together(model, own, nuisance.unknowns)
    if both is None or nuisance is None:
        shared = [name for name in own if name in model.uncertain]
        rows = rows_of(model, shared, names)
        return rows.T @ rows, told
    told[both.told] = True
    index = [names.index(n) for n in (*both.springs, *(nuisance.names[u] for u in both.told))]
    information[np.ix_(index, index)] = both.rows.T @ both.rows
    return information, told


def _others(study: Study, known: Known) -> tuple[str, ...]:
    """The springs that are known and not identified."""
    names = known.model.names
    others = tuple(name for name in names if name not in study.springs.names)
    if not others:
        raise InputError(
            f"{known.source or 'what is known'}: has no springs but {', '.join(names)}, which the "
            "study identifies; what is known of these is a prior"
        )
    return others


def _refuse_twice(study: Study, known: Known) -> None:
    """Refuse one campaign as what is known and as prior: its readings would count twice."""
    before = study.carried_out
    if before is not None and known.sha256 and known.sha256 == before.sha256:
        raise InputError(
            f"{known.source}: is the plan of the prior, too, so its experiments would count twice; "
            "keep one"
        )


def _part(model: ComplianceModel, names: tuple[str, ...]) -> ComplianceModel:
    """The model of some of its springs."""
    index = [model.names.index(name) for name in names]
    own = np.ix_(index, index)
    return replace(
        model,
        springs=subset(model.springs, names),
        compliance=model.compliance[index],
        covariance=model.covariance[own],
        noise_part=model.by_noise[own],
        task_covariance=model.at_task[own],
    )


def _over(study: Study, pose: TestPose | TestPath, fitted: Unknowns) -> TestPose | TestPath:
    """The test pose, or path, with a column for each of other unknowns."""
    if isinstance(pose, TestPath):
        arm = ElasticArm(study.robot, fitted.springs, pose.tool, study.gravity)
        made = test_path(arm, pose.cases, pose.weight, pose.name)
        return replace(pose, regressors=fitted.columns(made.regressors))
    if pose.case is None or pose.tool is None:
        if pose.regressor.shape[1] == len(fitted):
            return pose
        raise InputError(
            f"test pose {pose.name!r} is a matrix of {pose.regressor.shape[1]} columns; with what "
            f"is known it needs {len(fitted)}, one for each of {', '.join(fitted.names)}"
        )
    arm = ElasticArm(study.robot, fitted.springs, pose.tool, study.gravity)
    seen = test_pose(arm, pose.case, pose.weight, pose.name)
    return replace(seen, regressor=fitted.columns(seen.regressor))
