"""Plans for absolute readings: the unknowns of an absolute study as those of a study to plan.

Of errors that do the same all but one are left out, and the one that stays is known before as well
as all of them together: what a plan is worth at a test pose does not depend on which one it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.columns import told_apart, unknown_columns
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, subset
from elastocal.errors import InputError
from elastocal.robot.payloads import Payload
from elastocal.study.absolute import AbsoluteStudy, arm_model
from elastocal.study.study import TestPose

_DRAWN = 120  # random configurations, with and without the load
_OPEN = 10.0  # m, rad: what is known of a base or a reflector before
_SOFT = 1e-3  # rad/(N·m), m/N: what is known of a compliance before


@dataclass(frozen=True)
class PlannedUnknowns:
    """The unknowns of a plan for absolute readings.

    Attributes:
        columns: The p virtual joints that are told apart.
        prior: (p, p) information there is before.
    """

    columns: VirtualJoints
    prior: Array


def planned_unknowns(
    study: AbsoluteStudy, limits: Array, force: Array, payload: Payload | None
) -> PlannedUnknowns:
    """What experiments of an absolute study are to tell.

    Args:
        study: The study.
        limits: (2, n) joint values that are allowed [rad or m].
        force: (3,) a load that may act, beside none [N].
        payload: What always hangs on the flange.

    Raises:
        InputError: compliances are sought, and nothing loads the arm.
    """
    model = arm_model(study)
    if study.nuisance is not None:
        raise InputError("plans for absolute readings know no nuisance yet; leave it out")
    if study.compensators:
        raise InputError("plans for absolute readings know no compensators yet; leave them out")
    columns = unknown_columns(
        model, base="base" in study.blocks, tool="tool" in study.blocks
    ).springs
    arm = ElasticArm(study.robot, columns, study.tool, study.gravity, payload, weighs=True)
    rng, n = np.random.default_rng(0), limits.shape[1]
    finite = np.where(np.isfinite(limits), limits, [[-np.pi], [np.pi]])
    q = rng.uniform(finite[0], finite[1], (_DRAWN, n))
    wrench = np.zeros((_DRAWN, 6))
    wrench[::2, :3] = force
    rows = regressor(arm, LoadCases(q, wrench)).reshape(-1, len(columns))
    geometry = np.isin(columns.names, model.errors.names)
    unseen = [
        n for n, size in zip(columns.names, np.abs(rows).max(axis=0), strict=True) if not size
    ]
    if unseen and not columns.stiff[columns.names.index(unseen[0])]:
        raise InputError(
            f"{unseen[0]!r}: nothing bends it: give the robot masses and gravity, or a load"
        )
    rank = np.where(~columns.stiff, 0, np.where(geometry, 2, 1))
    kept, share = told_apart(rows, np.argsort(rank, kind="stable"))
    known = np.where(geometry, study.geometry_prior, np.where(columns.stiff, _OPEN, _SOFT))
    prior = np.linalg.inv((share * known**2) @ share.T)
    names = [columns.names[i] for i in kept]
    return PlannedUnknowns(subset(columns, names), (prior + prior.T) / 2.0)


def absolute_pose(
    study: AbsoluteStudy,
    columns: VirtualJoints,
    payload: Payload | None,
    case: LoadCases,
    *,
    name: str,
    weight: float,
) -> TestPose:
    """A test pose of an absolute study: where the tool is for the stations that read it.

    Its error is that of the arm, of base and reflectors: the TCP is off as the first reflector is.
    """
    arm = ElasticArm(study.robot, columns, study.tool.at_tcp, study.gravity, payload, weighs=True)
    return TestPose(name, regressor(arm, case)[0], weight, study.tool, case)


def payloads_of(study: AbsoluteStudy, names: Sequence[str]) -> tuple[Payload | None, Array]:
    """What always hangs on the flange, and the weight that may hang on it besides or not (3,).

    Args:
        study: The study.
        names: Of payloads between which experiments may choose; "none" among them.

    Raises:
        InputError: more than one payload may be chosen.
    """
    chosen = [p for p in study.payloads if p.name in names]
    if len(chosen) > 1:
        raise InputError(
            "a plan chooses between one payload and none; found "
            f"{', '.join(p.name for p in chosen)}"
        )
    if not chosen:
        return None, np.zeros(3)
    if "none" not in names:
        return chosen[0], np.zeros(3)
    return None, chosen[0].mass * study.gravity
