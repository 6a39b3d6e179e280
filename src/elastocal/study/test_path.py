"""A path of the task as a place where accuracy is judged: many load cases with one tool.

In: load cases of the tool along the path. Out: their regressors, and what criteria need of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, freeze, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.robot.chain import Tool


@dataclass(frozen=True)
class TestPath:
    """Where accuracy is judged: the N points of a path, each counting as much as any other.

    Attributes:
        name: What the user calls it.
        tool: Tool of the task.
        cases: The N load cases, wrench in the base frame.
        regressors: (N, 3, p) A0 of every point: deflection [m] = A0 · compliance.
        weight: Relative weight of the whole path; zero: judged, not planned for.
        points: N names of the points.
        source: File it was read from, as the study names it; empty if there is none.
        sha256: Hash of that file.
        remarks: Sentences on what is odd in it.

    Source: paper, section 7, names it as future work; ours.
    """

    __test__ = False  # not a test, whatever pytest may think

    name: str
    tool: Tool
    cases: LoadCases
    regressors: Array
    weight: float = 1.0
    points: tuple[str, ...] = ()
    source: str = ""
    sha256: str = ""
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "regressors")
        names = self.points or tuple(str(i + 1) for i in range(len(self.cases)))
        object.__setattr__(self, "points", names)

    @cached_property
    def regressor(self) -> Array:
        """(r, p) rows R, r <= p, with RᵀR the mean of A0ᵀA0: ρ0² = tr(R M⁻¹ Rᵀ), as of a pose."""
        return mean_rows(self.regressors)

    @property
    def case(self) -> LoadCases:
        """The first load case: where the robot is drawn."""
        return LoadCases(self.cases.q[:1], self.cases.wrench[:1])


def errors_along(path: TestPath, covariance: Array) -> Array:
    """(N,) ρ0 at every point [m], of a covariance (p, p) of the compliances."""
    blocks = path.regressors
    return np.asarray(np.sqrt(((blocks @ covariance) * blocks).sum(axis=(1, 2))))


def mean_rows(blocks: Array) -> Array:
    """(r, p) rows R, r <= p, with RᵀR the mean of BᵀB over blocks B (N, rows, p)."""
    rows = blocks.reshape(-1, blocks.shape[-1]) / np.sqrt(len(blocks))
    return frozen(np.linalg.qr(rows, mode="r"))


def test_path(arm: ElasticArm, cases: LoadCases, weight: float, name: str) -> TestPath:
    """Test path of load cases: the deflections of the TCP under the process wrenches."""
    rows = regressor(replace(arm, tool=arm.tool.at_tcp), cases)
    return TestPath(name, arm.tool, cases, rows, weight)


test_path.__test__ = False  # type: ignore[attr-defined]
