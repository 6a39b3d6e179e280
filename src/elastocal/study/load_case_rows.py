"""Rows of load cases on what is fitted, in units of all that errs, and their gradients.

In: an arm, an instrument, unknowns, errors of load cases. Out: blocks for the design core.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.absorbed import Absorbed, ErrorColumns, KnownErrors
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor
from elastocal.elastic.unknowns import Unknowns
from elastocal.measuring.instrument import Instrument
from elastocal.robot.posture import Posture


class LoadCaseRows:
    """Rows of N load cases.

    Attributes:
        blocks: (N, R, p) in units of what errs.
    """

    def __init__(
        self,
        arm: ElasticArm,
        instrument: Instrument,
        unknowns: Unknowns,
        errors: KnownErrors | None,
        cases: LoadCases,
        repeats: Array | None = None,
    ) -> None:
        """Rows on the unknowns of load cases that are measured (N,) times."""
        self.posture, self._unknowns = Posture(arm.robot, cases.q), unknowns
        self._regressor = Regressor(arm, self.posture, cases.wrench)
        self._markers = [self.posture.point(marker) for marker in arm.tool.markers]
        rows, self._erring, c = self._regressor.rows, None, len(arm.springs)
        if errors is not None:
            count = np.full(len(cases), errors.together) if repeats is None else repeats
            self._erring = ErrorColumns(errors, arm, self._regressor, count)
            rows = np.concatenate([rows, self._erring.unknown, self._erring.columns], axis=1)
        white, self._unwhiten = instrument.whiten(rows, self._markers)
        white = white.transpose(2, 0, 1)
        blocks = unknowns.columns(white[:, :, :c])
        if self._erring is not None:
            turned, columns = np.split(white[:, :, c:], [self._erring.unknown.shape[1]], axis=2)
            self._absorbed = Absorbed(np.concatenate([blocks, turned], axis=2), columns)
            blocks = self._absorbed.blocks
        self.blocks = np.ascontiguousarray(blocks)

    def pull(self, cotangent: Array) -> tuple[Array, Array]:
        """(n, N) gradient in q and (6, N) in the wrench, of that in `blocks`."""
        if not cotangent.any():  # restoring asks for margins alone
            return np.zeros_like(self.posture.q), np.zeros((6, self.posture.count))
        unknowns, erring = self._unknowns, self._erring
        if erring is None:
            bars = unknowns.cotangents(cotangent)
        else:
            rows_bar, columns_bar = self._absorbed.pull(cotangent)
            made, turned = np.split(rows_bar, [len(unknowns)], axis=2)
            bars = np.concatenate([unknowns.cotangents(made), turned, columns_bar], axis=2)
        white_bar = np.ascontiguousarray(bars.transpose(1, 2, 0))
        plain, points_bar = self._unwhiten(white_bar)
        if erring is None:
            q_bar, wrench_bar = self._regressor.pull(plain)
        else:
            c, e = len(unknowns.springs), erring.unknown.shape[1]
            springs, turned, columns = np.split(plain, [c, c + e], axis=1)
            more, q_bar, wrench_bar = erring.pull(turned, columns)
            pulled = self._regressor.pull(springs + more)
            q_bar, wrench_bar = q_bar + pulled[0], wrench_bar + pulled[1]
        moved = zip(self._markers, points_bar, strict=True) if points_bar else ()
        for point, bar in moved:
            q_bar += self.posture.pull_point(point, bar)
        return q_bar, wrench_bar
