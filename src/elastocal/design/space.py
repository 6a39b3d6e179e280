"""What the optimal-design core asks of the experiments it plans.

The core knows no robot: a design space is a box of design variables with further constraints, in
which every point yields rows of a linear model whose noise has unit covariance. Its information
matrix is rowsᵀ rows.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.design.criterion import Criterion
from elastocal.design.lockstep import Mover


class DesignEvaluation(Protocol):
    """N design points, evaluated."""

    @property
    def blocks(self) -> Array:
        """(N, r, p) rows of the linear model, noise of unit covariance."""

    @property
    def margins(self) -> Array:
        """(N, c) constraint margins, feasible where >= 0."""

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        """(N, d) gradient of a scalar with the given gradients in `blocks` and `margins`."""


class Core(Protocol):
    """Compiled code that moves batches of problems in a design space."""

    def climbing(self, root: Array, level: float) -> Mover:
        """Climbs to where |rows V|² is large, V (p, k), in units of `level`."""

    def planning(self, counts: IntArray, base: Array, criterion: Criterion) -> Mover:
        """Plans with repeats (B, s), to be worth much by a criterion of `base` and theirs."""

    def restored(self, x: Array, iterations: int) -> Array | None:
        """What `oracle.restore` does; None where it cannot."""


class DesignSpace(Protocol):
    """Where experiments can be chosen from."""

    @property
    def core(self) -> Core | None:
        """Compiled code for the same; None where there is none."""

    @property
    def parameters(self) -> int:
        """Number p of unknowns."""

    @property
    def lower(self) -> Array:
        """(d,) lower bounds of the design variables."""

    @property
    def upper(self) -> Array:
        """(d,) upper bounds of the design variables."""

    def parts(self, count: int) -> int:
        """Into how many parts to divide `count` points for several cores; 1 where one is fast."""

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(count, d) distinct random feasible points, covering the whole feasible set.

        Fewer where no more are found.
        """

    def feasible(self, x: Array) -> BoolArray:
        """(N,) which design points (N, d) hold all constraints."""

    def evaluate(self, x: Array, repeats: Array | None = None) -> DesignEvaluation:
        """Rows, margins and their gradients at `x`, (N, d).

        Repeats may share errors: then the rows of one of (N,) repeats of a point tell the less, the
        more there are. If they are not given, the space has a number for all.
        """


def information(blocks: Array) -> Array:
    """(N, p, p) information matrices of `blocks`, (N, r, p)."""
    return blocks.transpose(0, 2, 1) @ blocks
