"""What effects that a model lacks do to a fit, and to its test: leaks and visibilities.

In: a study, load cases with repeats. Out: for every column of an effect, what one of it leaves at
the task, and what any two add to the non-centrality of the test of fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.case_errors import common_columns, own_covariance, shared_covariance
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.matrices import rank_of, scaled_inverse
from elastocal.planning.blind_effects import EffectFamily, effect_columns, judged
from elastocal.planning.with_errors import WithErrors, noise_of
from elastocal.study.study import Study


@dataclass(frozen=True)
class BlindColumns:
    """What c columns of effects do.

    Attributes:
        families: To which effects they belong, in this order.
        left: (r, c) what one of each leaves at the test poses, weighed: its norm is the root mean
            square [m].
        seen: (c, c) Bᵀ Q B, B the columns of the readings, Q the precision of the residuals.
        moved: (R, c) what one of each leaves in the residuals, and then at the task over the error
            that the plan leaves there anyway.
        dof: Degrees of freedom of the test of fit, of the means of repeats.
        noise_dof: Those of the noise that repeats tell, as far as it is what the means err by.
    """

    families: tuple[EffectFamily, ...]
    left: Array
    seen: Array
    moved: Array
    dof: int
    noise_dof: float

    def __post_init__(self) -> None:
        freeze(self, "left", "seen", "moved")


def columns_of(study: Study, cases: LoadCases, repeats: IntArray) -> BlindColumns | None:
    """Leaks and visibilities of all effects.

    Returns:
        None if the load cases do not tell compliances apart, or no test pose has a load case.

    Source: ours; C Xᵀ V⁻¹ B is what B makes of the estimates.
    """
    done = repeats > 0
    if not judged(study):
        return None
    cases, repeats = cases.chosen(done), repeats[done]
    rows = white_rows(study, cases, repeats)
    prior, instrument = rows.prior, rows.instrument
    x, b = (part.reshape(-1, part.shape[2]) for part in (rows.fitted, rows.effects))
    total = prior + x.T @ x
    fitted = total[: len(study.fitted), : len(study.fitted)]
    if rank_of(fitted) < len(fitted):
        return None
    covariance = scaled_inverse(total[None])[0]
    found = covariance @ (x.T @ b)
    left, error = [], 0.0
    for blocks, there in rows.task:
        left.append((blocks @ found - there).reshape(-1, b.shape[1]))
        error += float(((blocks @ covariance) * blocks).sum())
    kept = np.eye(len(x)) - x @ covariance @ x.T
    dof = len(x) + (rank_of(prior) if prior.any() else 0) - len(total)
    return BlindColumns(
        families=rows.families,
        left=np.concatenate(left),
        seen=b.T @ kept @ b,
        moved=np.concatenate([b - x @ found, np.concatenate(left) / np.sqrt(error)]),
        dof=int(dof),
        noise_dof=_noise_dof(kept, rows.noise, instrument, int(dof), repeats),
    )


class WhiteRows(NamedTuple):
    """What f unknowns of a fit and c columns of effects move, readings in units of their noise."""

    families: tuple[EffectFamily, ...]
    fitted: Array  # (S, m, f)
    effects: Array  # (S, m, c)
    task: tuple[tuple[Array, Array], ...]  # (N, r, f) and (N, r, c) of each test pose, weighed
    prior: Array  # (f, f) what is known of the unknowns before
    noise: Array  # (S, m, m) of the means of repeats
    instrument: Array  # (S, m, m) what of it is the noise of the instrument


def white_rows(study: Study, cases: LoadCases, repeats: IntArray) -> WhiteRows:
    """Rows of S load cases, each the mean of (S,) `repeats`, and of the task.

    Weighed, the squares of all rows of the task add up to the mean square over the test poses.
    """
    count = repeats.astype(float)[:, None, None]
    instrument = noise_of(study, cases) / count
    noise, prior = instrument.copy(), study.prior
    rows = study.fitted.columns(regressor(study.fitted_arm, cases))
    told = None if study.nuisance is None else WithErrors(study, study.nuisance)
    if told is not None:
        errors, arm = told.nuisance.errors, replace(study.fitted_arm, springs=told.bending)
        noise += own_covariance(errors, arm, told.usual, cases) / count
        noise += shared_covariance(errors, arm, told.usual, cases)
        prior = told.base
        _, common = common_columns(errors, arm, told.usual, cases)
        # One of an unknown is one of its own sizes: what is known of it before is one.
        sizes = np.sqrt(np.diagonal(told.beside))[rows.shape[2] :]
        rows = np.concatenate([rows, common * sizes], axis=2)
    effects, poses = effect_columns(study, cases), judged(study)
    root = np.linalg.cholesky(noise)
    white = np.linalg.solve(root, np.concatenate([rows, effects.readings], axis=2))
    weights = np.array([pose.weight for pose in poses])
    task = []
    for pose, weight, there in zip(poses, weights / weights.sum(), effects.task, strict=True):
        share = float(np.sqrt(weight / len(there)))
        blocks = pose.regressors if told is None else told.blocks(pose)
        task.append((share * blocks, share * there))
    fitted, moved = np.split(white, [rows.shape[2]], axis=2)
    return WhiteRows(effects.families, fitted, moved, tuple(task), prior, noise, instrument)


def _noise_dof(kept: Array, noise: Array, instrument: Array, dof: int, repeats: IntArray) -> float:
    """Degrees of freedom of the noise that repeats tell, as what the means are held against.

    Source: ours; docs/math.md, 43a: what is of absolute size in the means is known.
    """
    readings, m = int((repeats - 1).sum()), noise.shape[1]
    root = np.linalg.cholesky(noise)
    part = np.linalg.solve(root, np.linalg.solve(root, instrument).transpose(0, 2, 1))
    share = sum(
        float((kept[m * i : m * i + m, m * i : m * i + m] * own).sum())
        for i, own in enumerate(part)
    )
    return m * readings * (dof / share) ** 2 if share > 0.0 else 0.0
