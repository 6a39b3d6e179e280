"""What is to be fitted, and where a fit came to rest: the values that a fit goes between."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.fitting.bounds import Bounds
from elastocal.fitting.least_squares import LinearFit, one_of
from elastocal.identification.shared_errors import SharedErrors
from elastocal.measuring.whitening import noise_factors


@dataclass(frozen=True)
class Problem:
    """What is to be fitted: C campaigns that differ in what was read.

    Attributes:
        arm: Robot with all c springs that bend, identified or not, and the tool with T targets.
        free: (p,) positions of the fitted ones.
        start: (c,) compliances of all springs; those of the free ones do not count.
        make: (c, p) compliances of the springs for one of each unknown, where an unknown is not
            one spring: then `free` says nothing. Not given: the unknowns are the free springs.
        columns: (R, 3, e) deflections for one of each of e further unknowns, which are common to
            all experiments and no springs [m, rad]; they come after the p others.
        shared: What readings share besides; None for nothing.
        cases: N load cases.
        marker: (R,) target of each reading among the N · T of all load cases.
        deflection: (C, R, 3) deflections read [m, rad].
        covariance: (R, 3, 3) of each [m², rad²].
        extra_rows: (E, u) further rows over all u = p + e unknowns, such as a prior's.
        extra_values: (C or 1, E) their values.
        bounds: Bounds of the unknowns; None for none.
        known_noise: Whether the covariances are true and not only right up to a factor.
        variance: That factor, as far as it is found yet: what the further rows are weighed against.
        source: Where the readings come from, empty if nobody said.
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    cases: LoadCases
    marker: IntArray
    deflection: Array
    covariance: Array
    extra_rows: Array
    extra_values: Array
    bounds: Bounds | None = None
    make: Array = field(default_factory=unset)
    columns: Array = field(default_factory=unset)
    shared: SharedErrors | None = None
    known_noise: bool = True
    variance: float = 1.0
    source: str = ""

    @property
    def dof(self) -> int:
        """Coordinates read and rows of a prior, less unknowns."""
        return 3 * len(self.marker) + len(self.extra_rows) - self.unknowns

    @property
    def unknowns(self) -> int:
        """Number u of unknowns."""
        made = self.make.shape[1] if self.make.size else len(self.free)
        return made + (self.columns.shape[2] if self.columns.size else 0)

    @property
    def absolute(self) -> bool:
        """Whether anything in it is known in absolute size, whatever the noise is."""
        return len(self.extra_rows) > 0 or self.shared is not None

    def of_unknowns(self, rows: Array) -> Array:
        """(..., p) columns of the unknowns that are springs, of those of all springs (..., c)."""
        if self.make.size:
            return np.asarray(rows @ self.make)
        return rows if len(self.free) == rows.shape[-1] else rows[..., self.free]

    @cached_property
    def white_columns(self) -> Array:
        """(R, 3, e) the further columns over the noise."""
        return np.asarray(self.noise[1] @ self.columns)

    @cached_property
    def noise(self) -> tuple[Array, Array]:
        """Lower triangular factors of the covariances [m], and their inverses, (R, 3, 3) each."""
        try:
            return noise_factors(self.covariance)
        except np.linalg.LinAlgError:
            raise InputError(
                f"{self.source or 'the measurements'}: the covariance of a reading is not positive "
                "definite; its uncertainties are too small, or do not fit together"
            ) from None

    @cached_property
    def shrink(self) -> float | None:
        """One over the noise, if it is the same number for all coordinates: the usual case."""
        whitener = self.noise[1]
        one = whitener[0]
        same = whitener.strides[0] == 0 and (one == one[0, 0] * np.eye(3)).all()
        return float(one[0, 0]) if same else None


@dataclass(frozen=True)
class Solution:
    """Where the iteration came to rest.

    Attributes:
        compliance: (C, u) unknowns: free compliances, or what makes them.
        fit: The last linear fits; their triangles are those of the whole problem.
        rows: (B, R, 3, c) rows of all springs over the noise, B = 1 if all campaigns share them.
        residual: (C, R, 3) residuals over the noise.
        weight: (C, R) robust weights.
        iterations: Steps taken.
    """

    compliance: Array
    fit: LinearFit
    rows: Array
    residual: Array
    weight: Array
    iterations: int

    def of(self, i: int) -> Solution:
        """The i-th campaign alone, its arrays without the first axis."""
        return Solution(
            self.compliance[i],
            self.fit.of(i),
            one_of(self.rows, i),
            self.residual[i],
            self.weight[i],
            self.iterations,
        )


def free_rows(problem: Problem, found: Solution) -> Array:
    """(R, 3, u) rows of the unknowns over the noise."""
    return rows_of_unknowns(problem, found.rows)


def rows_of_unknowns(problem: Problem, rows: Array) -> Array:
    """(..., R, 3, u) rows of the unknowns, of those of all springs (..., R, 3, c)."""
    own = problem.of_unknowns(rows)
    if not problem.columns.size:
        return own
    more = np.broadcast_to(problem.white_columns, (*own.shape[:-1], problem.columns.shape[2]))
    return np.concatenate([own, more], axis=-1)


def compliances(problem: Problem, unknown: Array) -> Array:
    """(C, c) compliances of all springs for unknowns (C, u)."""
    compliance = np.tile(problem.start, (len(unknown), 1))
    if problem.make.size:
        return np.asarray(compliance + unknown[:, : problem.make.shape[1]] @ problem.make.T)
    compliance[:, problem.free] = unknown[:, : len(problem.free)]
    return compliance
