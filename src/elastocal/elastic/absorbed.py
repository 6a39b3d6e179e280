"""Absorbed: rows of load cases whose readings err by more than the noise of the instrument.

Friction, discrepancy, load and repeatability have covariances that depend on the load case, and
repeats share some of them. Rows are turned until all that errs is independent and of size one, so
that whoever asks for their information, or climbs it, need not know.

In: a regressor, sizes of errors, repeats. Out: columns of the errors, and their gradients.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.regressor import Regressor


@dataclass(frozen=True)
class KnownErrors:
    """What is known of the errors of load cases before they are measured.

    Attributes:
        sizes: Their standard uncertainties.
        compliance: (c,) compliances of the springs of the arm [rad/(N·m) or m/N].
        joints: (c,) which of them are joints, where there is friction.
        unit: Size of one of the unknowns that turn all loads together.
        together: Repeats that share a load case, where nobody says how many; any number above 0.
    """

    sizes: CaseErrors
    compliance: Array
    joints: BoolArray
    unit: float
    together: float = 1.0

    def __post_init__(self) -> None:
        freeze(self, "compliance")
        freeze(self, "joints", dtype=np.bool_)

    @property
    def rubbing(self) -> Array:
        """(c,) what friction leaves for a unit of generalised force [rad/(N·m) or m/N]."""
        return np.asarray(self.sizes.friction * self.compliance * self.joints)

    @property
    def turns(self) -> int:
        """Number of unknowns that turn all loads together."""
        return 3 if self.sizes.common_tilt > 0.0 else 0

    def of(self, together: float) -> KnownErrors:
        """The same with another number of repeats that share a load case."""
        return self if together == self.together else replace(self, together=together)


class ErrorColumns:
    """What errs in N load cases, as columns beside those of the springs.

    Attributes:
        unknown: (R, e, N) columns of the unknowns that turn all loads together.
        columns: (R, h, N) one for each independent error, for one standard uncertainty [m, rad].
    """

    def __init__(
        self, known: KnownErrors, arm: ElasticArm, regressor: Regressor, repeats: Array
    ) -> None:
        """Columns of the errors of load cases measured (N,) `repeats` times, seen by reading."""
        sizes, k = known.sizes, known.compliance
        self._known, self._regressor, self._repeats = known, regressor, repeats
        rows = regressor.rows
        size, _, count = rows.shape
        self._total = np.einsum("rcn,c->rn", rows, k)
        self._kinds = [slice(0, 3 * len(arm.tool.markers))]
        if size > self._kinds[0].stop:
            self._kinds.append(slice(self._kinds[0].stop, size))
        self._turned = []
        if max(sizes.tilt, sizes.common_tilt) > 0.0:
            wrench = np.concatenate([regressor.force[:, 0], regressor.moment[:, 0]])
            for axis in np.eye(3):
                parts = [np.cross(axis, part, axisb=0).T for part in np.split(wrench, 2)]
                self._turned.append(
                    Regressor(
                        arm,
                        regressor.posture,
                        np.concatenate(parts).T,
                        rotation=regressor.rotation,
                    )
                )
        turned = [np.einsum("rcn,c->rn", other.rows, k) for other in self._turned]
        unknown = [sizes.common_tilt / known.unit * column for column in turned[: known.turns]]
        self.unknown = np.stack(unknown, axis=1) if unknown else np.zeros((size, 0, count))
        self._rubbing = np.flatnonzero(known.rubbing)
        rubbing = known.rubbing[self._rubbing, None] * np.sqrt(repeats)
        parts = [rows[:, self._rubbing] * rubbing]
        self._unexplained = self._unexplained_sizes()
        wide = np.zeros((size, size, count))
        for kind, (root, _) in zip(self._kinds, self._unexplained, strict=True):
            wide[range(kind.start, kind.stop), range(kind.start, kind.stop)] = root
        own = [sizes.gain * self._total] + [sizes.tilt * column for column in turned]
        back = np.zeros((size, 3, count))
        positions = self._kinds[0].stop
        back[:positions] = sizes.repeatability * np.tile(np.eye(3), (positions // 3, 1))[..., None]
        self.columns = np.concatenate([*parts, wide, np.stack(own, axis=1), back], axis=1)

    def _unexplained_sizes(self) -> list[tuple[Array, Array]]:
        """Of each kind of rows: the root (N,) of what is unexplained, and its slope in |d|²."""
        sizes, found = self._known.sizes, []
        for i, kind in enumerate(self._kinds):
            square = 3.0 * np.mean(self._total[kind] ** 2, axis=0)  # |d|², mean of the markers
            length = sizes.discrepancy_length if i == 0 else 0.0
            root = np.sqrt(self._repeats * (sizes.discrepancy**2 * square + length**2))
            slope = 0.5 * self._repeats * sizes.discrepancy**2
            with np.errstate(divide="ignore", invalid="ignore"):
                slope = np.where(root > 0.0, slope / root, 0.0)
            found.append((root, slope))
        return found

    def pull(self, unknown_bar: Array, column_bar: Array) -> tuple[Array, Array, Array]:
        """Gradients in the rows of the springs (R, c, N), in q (n, N) and in the wrench (6, N).

        Of a scalar with these gradients in `unknown`, (R, e, N), and in `columns`, (R, h, N).
        """
        sizes, k = self._known.sizes, self._known.compliance
        rows_bar = np.zeros_like(self._regressor.rows)
        size, rubbing = len(rows_bar), self._rubbing
        rubbed, wide, own = np.split(column_bar, [len(rubbing), len(rubbing) + size], axis=1)
        each = self._known.rubbing[rubbing, None] * np.sqrt(self._repeats)
        rows_bar[:, rubbing] = rubbed * each
        total_bar = sizes.gain * own[:, 0]
        diagonal = wide[range(size), range(size)]
        for kind, (_, slope) in zip(self._kinds, self._unexplained, strict=True):
            square_bar = diagonal[kind].sum(axis=0) * slope
            total_bar[kind] += 6.0 / (kind.stop - kind.start) * square_bar * self._total[kind]
        rows_bar += total_bar[:, None] * k[:, None]
        q_bar = np.zeros_like(self._regressor.posture.q)
        wrench_bar = np.zeros((6, len(self._repeats)))
        for i, (axis, turned) in enumerate(zip(np.eye(3), self._turned, strict=False)):
            bar = sizes.tilt * own[:, 1 + i]
            if i < self._known.turns:
                bar = bar + sizes.common_tilt / self._known.unit * unknown_bar[:, i]
            pulled, turned_bar = turned.pull(bar[:, None] * k[:, None])
            q_bar += pulled
            for part in (slice(0, 3), slice(3, 6)):
                wrench_bar[part] += np.cross(turned_bar[part], axis, axisa=0).T
        return rows_bar, q_bar, wrench_bar


class Absorbed:
    """Rows in units of all that errs.

    Attributes:
        blocks: (N, R, p) L⁻¹ A, with L Lᵀ the covariance I + Σ b bᵀ.
    """

    def __init__(self, rows: Array, columns: Array) -> None:
        """Of rows (N, R, p) and columns (N, R, h), both in units of the noise.

        Source: ours.
        """
        self._columns = columns
        covariance = np.eye(rows.shape[1]) + columns @ columns.transpose(0, 2, 1)
        self._root = np.linalg.cholesky(covariance)
        self.blocks = np.ascontiguousarray(np.linalg.solve(self._root, rows))

    def pull(self, cotangent: Array) -> tuple[Array, Array]:
        """Gradients in rows (N, R, p) and columns (N, R, h), of that in `blocks`.

        The scalar must be one of the information blocksᵀ blocks: what turns all rows alike changes
        nothing.
        """
        back = self._root.transpose(0, 2, 1)
        rows_bar = np.linalg.solve(back, cotangent)
        white = np.linalg.solve(back, self.blocks)
        return rows_bar, -rows_bar @ (white.transpose(0, 2, 1) @ self._columns)
