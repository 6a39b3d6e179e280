"""What a criterion asks for, as one matrix: its squared loss is at least tr(Kᵀ M⁻¹ K).

For a mean over test poses they are equal. A largest value of several is at least their mean with
any weights; those of the gradient that bounds it are taken.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.part import information_on
from elastocal.errors import InputError
from elastocal.matrices import scaled_inverse
from elastocal.planning.aim import Aim
from elastocal.study.criteria import RHO0
from elastocal.study.study import Study

_SHARP = 299.0  # one less than the sharpness of the means that stand in for a largest value
_LITTLE = 1e-5  # share of the squared loss that columns of K, together, have to be left out
_NOISE = 1e-8  # share of the weights that members of a largest loss have to be left out

CRITERIA_PROVED = (RHO0.name, "worst", "coordinate", "G", "A", "E")
"""Criteria for which there are proofs."""


def refuse_criterion(name: str) -> None:
    """Refuse a criterion for which there is no proof.

    Raises:
        InputError: it is one.
    """
    if name not in CRITERIA_PROVED:
        raise InputError(
            f"there are proofs of bounds for the criteria {', '.join(CRITERIA_PROVED)}; the study "
            f"plans for {name}"
        )


def asked(study: Study, aim: Aim, total: Array) -> tuple[Array, Array]:
    """K and M⁻¹K, (p, r) each, at an information matrix M of p unknowns.

    Columns that belong together: Kᵀ M⁻¹ K is diagonal. What adds next to nothing to its trace is
    left out, which can only lower the bound.

    Raises:
        InputError: a criterion for which there is no proof.
    """
    rows = _rows(study, aim, total)
    if len(rows) > len(total):
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    inverse = scaled_inverse(total[None])[0]
    loss = rows @ inverse @ rows.T
    values, turn = np.linalg.eigh((loss + loss.T) / 2.0)
    turn = turn[:, np.maximum(values, 0.0).cumsum() > _LITTLE * values.sum()][:, ::-1]
    asked_for = rows.T @ turn
    return asked_for, inverse @ asked_for


def _rows(study: Study, aim: Aim, total: Array) -> Array:
    """(R, p) rows a with squared loss ≥ Σ a M⁻¹ aᵀ."""
    name, wanted = study.criterion, study.wanted
    if name == RHO0.name:
        return _of_test_poses(study, aim)
    refuse_criterion(name)
    if name == "A":
        return np.eye(len(total))[wanted] / np.sqrt(len(wanted))
    if name == "E":
        values, vectors = np.linalg.eigh(information_on(wanted, total[None])[0])
        members = np.zeros((len(values), 1, len(total)))
        members[:, 0, wanted] = vectors.T
    elif name == "G":
        members = np.eye(len(total))[wanted][:, None]
    else:
        members = _stacked([pose.regressors for pose in study.planned_for])
        if name == "coordinate":
            members = members.reshape(-1, 1, len(total))
    inverse = scaled_inverse(total[None])[0]
    losses = np.einsum("kri,ij,krj->k", members, inverse, members)
    weights = (losses / losses.max()) ** _SHARP
    kept = weights > _NOISE * weights.sum()
    weights = weights[kept] / weights[kept].sum()
    return np.asarray((np.sqrt(weights)[:, None, None] * members[kept]).reshape(-1, len(total)))


def _of_test_poses(study: Study, aim: Aim) -> Array:
    """Rows of the weighted mean over test poses; of paths the mean of their points."""
    found = []
    for share, pose in zip(study.shares, study.test_poses, strict=True):
        blocks = pose.regressors if aim.told is None else aim.told.blocks(pose)
        if share > 0.0:
            found.append(np.sqrt(share / len(blocks)) * blocks.reshape(-1, blocks.shape[2]))
    return np.concatenate(found)


def _stacked(blocks: list[Array]) -> Array:
    """Blocks (N, r, p) of different r, one below the other; rows of zeros add nothing."""
    most = max(block.shape[1] for block in blocks)
    return np.concatenate(
        [np.pad(block, ((0, 0), (0, most - block.shape[1]), (0, 0))) for block in blocks]
    )
