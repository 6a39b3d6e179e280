"""Replanning: what is left to do of a campaign that was broken off.

In: a study, the measurements there are. Out: the study of the rest: fewer experiments, what was
measured as prior information, configurations that were measured ruled out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.constraints import Distinct
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError
from elastocal.measuring.measurements import Measurements
from elastocal.measuring.whitening import noise_factors
from elastocal.planning.plain_values import simplify
from elastocal.study.before import Done
from elastocal.study.study import Study
from elastocal.wording.numbers import bounded

_APART = np.radians(1.0)  # distance from a measured configuration that makes another one


def done(study: Study, measurements: Measurements) -> Done:
    """What `measurements` tell already, as a plan must know it.

    Source: paper eq. (13): the information of the readings there are, with their own noise.
    """
    cases, tool = measurements.cases, measurements.tool
    rows = study.fitted.columns(regressor(replace(study.fitted_arm, tool=tool), cases))
    rows = rows.reshape(len(cases), len(tool.targets), 3, -1)
    _, whitener = noise_factors(measurements.covariance)
    seen = (whitener @ rows[measurements.case, measurements.marker]).reshape(-1, rows.shape[-1])
    _, first = np.unique(np.round(cases.q, 9), axis=0, return_index=True)
    kept = np.sort(first)
    return Done(
        source=measurements.source,
        sha256=measurements.sha256,
        experiments=len(cases),
        cases=LoadCases(cases.q[kept], cases.wrench[kept]),
        information=frozen(seen.T @ seen),
    )


def remaining(study: Study, before: Done) -> Study:
    """The study of the experiments that are left.

    Raises:
        InputError: all of them are measured.
    """
    e = study.experiments
    left = e.count - before.experiments
    if left < 1:
        raise InputError(
            f"{before.source}: has {before.experiments} experiments, and {e.count} are wanted in "
            f"all; ask for more than {before.experiments} with --count, which counts those that "
            "are measured, or raise `count` in the study"
        )
    configurations = None if e.max_configurations is None else min(left, e.max_configurations)
    experiments = replace(e, count=left, max_configurations=configurations)
    return knowing(replace(study, experiments=experiments), before)


def knowing(study: Study, before: Done) -> Study:
    """The same study with what is known, and without the configurations that were measured.

    Joints that change nothing, alone or with the load, do not make another configuration of one
    that was measured.
    """
    if before.information.shape != study.prior.shape:
        raise InputError(
            f"{before.source}: its information is on {len(before.information)} compliances, and "
            f"the study fits {', '.join(study.fitted.names)}"
        )
    plain = simplify(study.space, before.cases)
    same = (*plain.free, plain.turns_with_load)
    counts: Array = np.array([float(name not in same) for name in study.robot.joint_names])
    apart = tuple(
        Distinct(
            bounded(f"distance from measured configuration {i + 1}", ">=", _APART, "rad"),
            q,
            counts,
            _APART,
        )
        for i, q in enumerate(before.cases.q)
    )
    return replace(
        study,
        prior=study.prior + before.information,
        constraints=(*study.constraints, *apart),
        done=before,
    )
