"""Plans for absolute readings: the unknowns of an absolute study as those of a study to plan.

Of errors that do the same all but one are left out, and the one that stays is known before as well
as all of them together: what a plan is worth at a test pose does not depend on which one it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.columns import told_apart, unknown_columns
from elastocal.calibration.parameters import TURNED
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, subset
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
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
        prior: (f, f) information there is before, on them and on the nuisance.
        nuisance: What moves readings besides, that nobody asks for.
    """

    columns: VirtualJoints
    prior: Array
    nuisance: Nuisance | None = None

    @cached_property
    def fitted(self) -> Unknowns:
        """All f unknowns: those that are asked for, then the nuisance."""
        each = each_spring(self.columns)
        return each if self.nuisance is None else joined(each, self.nuisance.unknowns)


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
    model = arm_model(replace(study, nuisance=None))
    rng, n = np.random.default_rng(0), limits.shape[1]
    finite = np.where(np.isfinite(limits), limits, [[-np.pi], [np.pi]])
    columns = unknown_columns(
        model, finite, base="base" in study.blocks, tool="tool" in study.blocks
    ).springs
    arm = ElasticArm(study.robot, columns, study.tool, study.gravity, payload, weighs=True)
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
    levered = np.array([share is not None for share in columns.by], dtype=bool)
    rank = np.where(~columns.stiff | levered, 0, np.where(geometry, 2, 1))
    kept, share = told_apart(rows, np.argsort(rank, kind="stable"))
    known = np.where(geometry, study.geometry_prior, np.where(columns.stiff, _OPEN, _SOFT))
    known[levered] = TURNED
    prior = np.linalg.inv((share * known**2) @ share.T)
    names = [columns.names[i] for i in kept]
    sought = subset(columns, names)
    if study.nuisance is None:
        return PlannedUnknowns(sought, (prior + prior.T) / 2.0)
    p, u = len(sought), len(study.nuisance.unknowns)
    both = np.zeros((p + u, p + u))
    both[:p, :p], both[p:, p:] = (prior + prior.T) / 2.0, study.nuisance.information
    return PlannedUnknowns(sought, both, study.nuisance)


def absolute_pose(
    study: AbsoluteStudy,
    unknowns: PlannedUnknowns,
    payload: Payload | None,
    case: LoadCases,
    *,
    name: str,
    weight: float,
) -> TestPose:
    """A test pose of an absolute study: where the tool is for the stations that read it.

    Its error is that of the arm, of base and reflectors: the TCP is off as the first reflector is.
    """
    springs, tool = unknowns.fitted.springs, study.tool.at_tcp
    arm = ElasticArm(study.robot, springs, tool, study.gravity, payload, weighs=True)
    rows = unknowns.fitted.columns(regressor(arm, case)[0])
    return TestPose(name, rows, weight, study.tool, case)


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
