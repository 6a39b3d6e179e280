"""Errors that readings share, beside the instrument's own noise.

In: readings, covariances of absolute size of load cases and experiments. Out: the coordinates of
the readings, turned so that the instrument's noise is of unit size and independent, and so is the
absolute error beside it. After that every fit is one with weights.

    cov = s² V + U,   V = L Lᵀ,   L⁻¹ U L⁻ᵀ = O diag(u) Oᵀ,   turned by Oᵀ L⁻¹: s² 1 + diag(u)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors, own_covariance, shared_covariance
from elastocal.measuring.measurements import Measurements


@dataclass(frozen=True)
class Turn:
    """Groups of readings that are as many each.

    Attributes:
        place: (G, m) positions of their coordinates among the 3R of all readings.
        matrix: (G, m, m) what turns them.
    """

    place: IntArray
    matrix: Array


@dataclass(frozen=True)
class SharedErrors:
    """What R readings share.

    Attributes:
        group: (R,) number of the group of each reading, from 0: readings of two groups share
            nothing.
        turns: How the coordinates are turned, group by group.
        absolute: (3R,) variance of the turned coordinates besides, over that of the noise.
        own: (R, 3, 3) covariance of absolute size of each reading [m², rad²].
        of_experiments: Whether experiments have errors of their own besides the noise.
    """

    group: IntArray
    turns: tuple[Turn, ...]
    absolute: Array
    own: Array
    of_experiments: bool

    def turned(self, columns: Array) -> Array:
        """(3R, k) columns over the noise, turned."""
        found = np.empty_like(columns)
        for turn in self.turns:
            found[turn.place] = turn.matrix @ columns[turn.place]
        return found

    def repeats_show_noise(self, data: Measurements) -> bool:
        """Whether repeats of a load case differ by the instrument's noise alone, and all of it."""
        alone = len(np.unique(data.unloaded)) == len(data) and not data.common.size
        return alone and not self.of_experiments


def errors_in(
    data: Measurements,
    whitener: Array,
    errors: CaseErrors | None,
    arm: ElasticArm,
    compliance: Array,
) -> SharedErrors | None:
    """What readings share by errors of load cases, at compliances (c,) of `arm`; None if nothing.

    The others as in `shared_errors`.
    """
    of_case = of_one = None
    if errors is not None and errors.any_shared:
        of_case = shared_covariance(errors, arm, compliance, data.cases)
    if errors is not None and errors.any_own:
        of_one = own_covariance(errors, arm, compliance, data.cases)
    return shared_errors(data, whitener, of_case, of_one)


def shared_errors(
    data: Measurements,
    whitener: Array,
    of_case: Array | None = None,
    of_experiment: Array | None = None,
) -> SharedErrors | None:
    """What readings share; None if nothing.

    Args:
        data: The R readings.
        whitener: (R, 3, 3) inverse factors of their covariances.
        of_case: (N, m, m) covariance that all repeats of the load case of an experiment share, over
            all targets of the tool; None if there is none.
        of_experiment: The same that each experiment has of its own.
    """
    alone = len(np.unique(data.unloaded)) == len(data) and not data.common.size
    if alone and of_case is None and of_experiment is None:
        return None
    keys = [data.unloaded, data.case]  # an experiment is left out as a whole
    keys += [] if of_case is None else [data.cases.distinct[data.case]]
    group = connected(keys)
    turns = []
    absolute, own = np.zeros(3 * len(data)), np.zeros((len(data), 3, 3))
    for readings in _of_equal_size(group):
        place = (3 * readings[..., None] + np.arange(3)).reshape(len(readings), -1)
        besides = _besides(data, readings, of_case, of_experiment)
        k = readings.shape[1]
        blocks = besides.reshape(len(readings), k, 3, k, 3)
        own[readings] = np.einsum("gkikj->gkij", blocks)
        noise = _noise(data, whitener, readings)
        white = whitener[readings]
        over = np.einsum("gkia,gkalb,gljb->gkilj", white, blocks, white).reshape(besides.shape)
        root = np.linalg.inv(np.linalg.cholesky(noise))
        size, axes = np.linalg.eigh(root @ over @ root.transpose(0, 2, 1))
        absolute[place] = np.where(size > _NOTHING, size, 0.0)
        turns.append(Turn(place, np.asarray(axes.transpose(0, 2, 1) @ root)))
    apart = of_experiment is not None
    return SharedErrors(group, tuple(turns), frozen(absolute), frozen(own), apart)


_NOTHING = 1e-9  # variance over that of the noise that is rounding


def connected(keys: Sequence[IntArray]) -> IntArray:
    """(R,) numbers from 0, the same for readings that any of the `keys`, (R,), has alike."""
    label = np.arange(len(keys[0]))
    while True:
        before = label
        for key in keys:
            _, place = np.unique(key, return_inverse=True)
            least = np.full(int(place.max(initial=-1)) + 1, len(label))
            np.minimum.at(least, place, label)
            label = least[place]
        if (label == before).all():
            return np.asarray(np.unique(label, return_inverse=True)[1], dtype=np.int64)


def _of_equal_size(group: IntArray) -> Iterator[IntArray]:
    """(G, k) readings of all groups that have k."""
    order = np.argsort(group, kind="stable")
    size = np.bincount(group)
    start = np.cumsum(size) - size
    for k in np.unique(size).tolist():
        these = np.flatnonzero(size == k)
        yield order[start[these][:, None] + np.arange(k)]


def _besides(
    data: Measurements, readings: IntArray, of_case: Array | None, of_experiment: Array | None
) -> Array:
    """(G, 3k, 3k) covariance of absolute size of groups (G, k)."""
    row = (3 * data.marker[readings][..., None] + np.arange(3)).reshape(len(readings), -1)
    case = np.repeat(data.case[readings], 3, axis=1)
    total = np.zeros((*row.shape, row.shape[1]))
    both = row[:, :, None], row[:, None, :]
    if of_case is not None:
        load = data.cases.distinct[case]
        alike = load[:, :, None] == load[:, None, :]
        total += alike * of_case[case[:, :, None], *both]
    if of_experiment is not None:
        alike = case[:, :, None] == case[:, None, :]
        total += alike * of_experiment[case[:, :, None], *both]
    return 0.5 * (total + total.transpose(0, 2, 1))


def _noise(data: Measurements, whitener: Array, readings: IntArray) -> Array:
    """(G, 3k, 3k) covariance of the instrument's noise over that of single readings.

    A deflection is a difference of two readings of equal noise: those that share one of the two
    share half of their variance. So do the errors that readings of one pose have in common.
    """
    groups, k = readings.shape
    unloaded = data.unloaded[readings]
    alike = (unloaded[:, :, None] == unloaded[:, None, :]) & ~np.eye(k, dtype=bool)
    blocks = np.zeros((groups, k, 3, k, 3))
    if alike.any():
        own = data.covariance[readings]
        half = 0.25 * (own[:, :, None] + own[:, None, :])  # (G, k, k, 3, 3)
        white = whitener[readings]
        found = white[:, :, None] @ half @ white[:, None].transpose(0, 1, 2, 4, 3)
        blocks = (alike[..., None, None] * found).transpose(0, 1, 3, 2, 4)
    whole = blocks.reshape(groups, 3 * k, 3 * k) + np.eye(3 * k)
    if not data.common.size:
        return np.asarray(whole)
    case, pose = data.case[readings], _unloaded_pose(data)[readings]
    together = 0.5 * (case[:, :, None] == case[:, None, :])
    together += 0.5 * (pose[:, :, None] == pose[:, None, :])
    together *= ~alike & ~np.eye(k, dtype=bool)  # of one marker: in the halves already
    moved = (whitener @ data.common)[readings].reshape(groups, 3 * k, -1)
    share = np.repeat(np.repeat(together, 3, axis=1), 3, axis=2)
    return np.asarray(whole + share * (moved @ moved.transpose(0, 2, 1)))


def _unloaded_pose(data: Measurements) -> IntArray:
    """(R,) number of the unloaded pose behind each reading: experiments share it as a whole."""
    return connected([data.unloaded, data.case])
