"""What readings tell of the unknowns together, and what they cannot tell apart.

Many geometric errors do the same: the zero of the first joint and a turn of the base, offsets
along parallel axes. Such a combination keeps what its prior has, so that every number is one; it
is said to be open, and no number that rests on it is shown as if it had been measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.calibration.parameters import TOOL, Parameters

_NOTHING = 1e-5  # singular value, of columns of unit length, at which nothing is told
_RESTS = 0.25  # share of a variance from what was known before, up to which readings speak
_NAMED = 0.05  # part of a combination that is named
_TOLD = 0.1  # standard error over that before, up to which they do whatever the share is


@dataclass(frozen=True)
class Redundancy:
    """What is told and what is not.

    Attributes:
        told: Number of combinations of the unknowns that move readings: the rank of the rows.
        well: How many of them the readings tell better than was known before.
        open: (r, U) combinations that nothing tells, each with as few unknowns as may be, the
            largest part 1 [rad or m of each].
        seen: (U,) unknowns whose variance is from the readings, at most a quarter of it from what
            was known before; or a hundredth of what it was.
    """

    told: int
    well: int
    open: Array
    seen: BoolArray

    def __post_init__(self) -> None:
        freeze(self, "open")
        freeze(self, "seen", dtype=np.bool_)


def redundancy_of(parameters: Parameters, rows: Array) -> Redundancy:
    """What whitened rows (3R, U) tell of the unknowns.

    Source: ours; the rank of the whitened Jacobian with columns of unit length.
    """
    rows = rows[:, ~parameters.held]
    size = np.linalg.norm(rows, axis=0)
    scale = 1.0 / np.where(size > 0.0, size, 1.0)
    triangle = np.linalg.qr(rows * scale, mode="r")
    values, vectors = np.linalg.svd(triangle)[1:]
    values = np.append(values, np.zeros(len(vectors) - len(values)))
    told = int((values > _NOTHING * values[0]).sum())
    free = ~parameters.held
    information = (parameters.rows.T @ parameters.rows)[np.ix_(free, free)]
    prior = np.diagonal(information)
    blocks = np.array(parameters.block)[free]
    known = (prior > 0.0) & (blocks != TOOL)
    whole = rows.T @ rows + information
    own = 1.0 / np.sqrt(np.diagonal(whole))
    covariance = np.linalg.inv(whole * np.outer(own, own)) * np.outer(own, own)
    # C = C JᵀJ C + C P C: what comes from readings, and what from the prior. A combination that
    # nothing tells rests on the prior whole, however many unknowns share it, and whether they have
    # one of their own or not.
    rests = np.einsum("ij,jk,ik->i", covariance, information, covariance)
    rests /= np.diagonal(covariance)
    before = np.where(known, 1.0 / np.sqrt(np.where(known, prior, 1.0)), np.nan)
    shrunk = known & (np.sqrt(np.diagonal(covariance)) < _TOLD * before)
    open_ = _sparse(vectors[told:] * scale, blocks)
    held = covariance @ information  # of 1 where a combination rests on its prior
    well = len(own) - int((np.linalg.eigvals(held).real > 0.5).sum())
    seen, whole_open = np.zeros(len(free), dtype=bool), np.zeros((len(open_), len(free)))
    seen[free], whole_open[:, free] = (rests <= _RESTS) | shrunk, open_
    return Redundancy(told, well, whole_open, seen)


def together(open_: Array, names: Sequence[str]) -> list[list[str]]:
    """Names of the unknowns in each combination (r, U), the largest part first; small ones not."""
    said = []
    for row in np.abs(open_):
        involved = np.flatnonzero(row > _NAMED)
        said.append([names[i] for i in involved[np.argsort(-row[involved])]])
    return said


def _sparse(basis: Array, blocks: Array) -> Array:
    """(r, U) the same space as `basis`, with few unknowns in each row: reduced to steps.

    Geometric errors are the pivots: what bases and tools do together is said of them.
    """
    rows = np.array(basis)
    weight = np.where(np.isin(blocks, ("base", "tool", "probe")), 0.1, 1.0)
    for i in range(len(rows)):
        rest = np.abs(rows[i:]) * weight
        at, pivot = divmod(int(rest.argmax()), rest.shape[1])
        rows[[i, i + at]] = rows[[i + at, i]]
        rows[i] /= rows[i, pivot]
        others = np.arange(len(rows)) != i
        rows[others] -= rows[others, pivot][:, None] * rows[i]
    largest = np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
    rows /= np.where(largest > 0.0, largest, 1.0)
    rows[np.abs(rows) < 1e-3] = 0.0
    return rows
