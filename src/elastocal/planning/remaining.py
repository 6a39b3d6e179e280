"""Replanning: what is left to do of a campaign that was broken off.

In: a study, the measurements there are. Out: the study of the rest: fewer experiments, what was
measured as prior information, configurations that were measured ruled out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Distinct
from elastocal.elastic.load_cases import ranks_of_rows
from elastocal.errors import InputError
from elastocal.measuring.measurements import Measurements
from elastocal.planning.plain_values import simplify
from elastocal.study.before import Done, EarlierReadings
from elastocal.study.study import Study
from elastocal.wording.numbers import bounded

_APART = np.radians(1.0)  # distance from a measured configuration that makes another one


def done(study: Study, measurements: Measurements) -> Done:
    """What `measurements` tell already, as a plan must know it.

    Deflections with one unloaded reading count as independent, as those that are planned do.

    Source: paper eq. (13): the information of the readings there are, with their own noise.
    """
    cases, precision = measurements.cases, _precisions(measurements)
    keys = np.column_stack([cases.distinct, precision.reshape(len(cases), -1)])
    _, first, repeats = np.unique(ranks_of_rows(keys), return_index=True, return_counts=True)
    order = np.argsort(first)
    kept = first[order]
    readings = EarlierReadings(cases.chosen(kept), repeats[order], precision[kept])
    arm = replace(study.fitted_arm, tool=measurements.tool)
    return Done(
        source=measurements.source,
        sha256=measurements.sha256,
        experiments=len(cases),
        cases=readings.cases,
        information=readings.information(arm, study.fitted),
        repeats=readings.repeats,
        precision=readings.precision,
    )


def _precisions(data: Measurements) -> Array:
    """(N, 3T, 3T) inverse covariance of the noise of each experiment; zero what was not read."""
    targets = len(data.tool.targets)
    size, rows = 3 * targets, 3 * data.marker[:, None] + np.arange(3)
    told = np.zeros((len(data.cases), size, size))
    if not data.common.size:
        own = np.linalg.inv(data.covariance)
        np.add.at(told, (data.case[:, None, None], rows[:, :, None], rows[:, None, :]), own)
        return told
    for i in range(len(data.cases)):
        mine = np.flatnonzero(data.case == i)
        moved = data.common[mine].reshape(3 * len(mine), -1)
        noise = (moved @ moved.T).reshape(len(mine), 3, len(mine), 3)
        one = np.arange(len(mine))
        noise[one, :, one] = data.covariance[mine]
        place = np.eye(size)[rows[mine].ravel()]
        told[i] = place.T @ np.linalg.solve(noise.reshape(2 * (3 * len(mine),)), place)
    return told


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
    errors = None if study.nuisance is None else study.nuisance.errors
    if errors is not None and errors.any and before.readings is None:
        raise InputError(
            f"{before.source}: the plan does not say how often its load cases were read before and "
            "how well, which counts where load cases have errors; make it again with --after"
        )
    coordinates = 3 * len(study.experiments.tool.targets)
    if before.readings is not None and before.precision.shape[1] != coordinates:
        raise InputError(
            f"{before.source}: {before.precision.shape[1]} coordinates of each load case were "
            f"read, and the tool {study.experiments.tool.name!r} has {coordinates}"
        )
    _, first = np.unique(np.round(before.cases.q, 9), axis=0, return_index=True)
    measured = before.cases.chosen(np.sort(first))
    plain = simplify(study.space, measured)
    same = (*plain.free, plain.turns_with_load)
    counts: Array = np.array([float(name not in same) for name in study.robot.joint_names])
    apart = tuple(
        Distinct(
            bounded(f"distance from measured configuration {i + 1}", ">=", _APART, "rad"),
            q,
            counts,
            _APART,
        )
        for i, q in enumerate(measured.q)
    )
    return replace(
        study,
        prior=study.prior + before.information,
        constraints=(*study.constraints, *apart),
        done=before,
    )
