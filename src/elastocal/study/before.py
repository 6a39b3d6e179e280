"""What was done before a campaign: readings, a plan carried out, a model that was found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.study.experiment_space import LoadCaseSpace


@dataclass(frozen=True)
class Done:
    """What was measured before this plan.

    Attributes:
        source: File of the measurements.
        sha256: Its hash.
        experiments: How many experiments it has.
        cases: Their distinct configurations, each with a wrench.
        information: (p, p) information of their readings [(N·m/rad)²].
    """

    source: str
    sha256: str
    experiments: int
    cases: LoadCases
    information: Array


@dataclass(frozen=True)
class CarriedOut:
    """A plan that was carried out before, as prior information.

    Attributes:
        cases: Its load cases.
        repeats: (N,) how often each was measured.
        source: File it was read from, as it was named; empty if there is none.
        sha256: Hash of that file.
    """

    cases: LoadCases
    repeats: IntArray
    source: str = ""
    sha256: str = ""

    def information(self, space: LoadCaseSpace) -> Array:
        """(p, p) its information on the p unknowns of `space` [(N·m/rad)²]."""
        each = space.information(self.cases)
        return np.asarray(np.einsum("i,ijk->jk", self.repeats.astype(float), each))


@dataclass(frozen=True)
class Earlier:
    """What an earlier campaign found of the springs to identify, as prior information.

    Attributes:
        model: Their compliances, with the covariance that counts.
        source: File it was read from, as it was named; empty if there is none.
        sha256: Hash of that file.
    """

    model: ComplianceModel
    source: str = ""
    sha256: str = ""
