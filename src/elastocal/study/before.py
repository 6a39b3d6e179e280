"""What was done before a campaign: readings, a plan carried out, a model that was found."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.unknowns import Unknowns
from elastocal.study.experiment_space import LoadCaseSpace


@dataclass(frozen=True)
class EarlierReadings:
    """What was read before, as errors of load cases need to know it.

    Attributes:
        cases: E load cases; those read in another way stand here again.
        repeats: (E,) experiments of each.
        precision: (E, m, m) inverse covariance of what the instrument errs by in one experiment,
            over the m coordinates of the tool, zero where one was not read [1/m², 1/rad²].
    """

    cases: LoadCases
    repeats: IntArray
    precision: Array

    def information(self, arm: ElasticArm, unknowns: Unknowns) -> Array:
        """(p, p) on unknowns, of the arm with the springs that they make, by the instrument alone.

        Source: paper eq. (13).
        """
        rows = unknowns.columns(regressor(arm, self.cases))
        told = self.repeats.astype(float)[:, None, None] * self.precision
        return np.asarray((rows.transpose(0, 2, 1) @ told @ rows).sum(axis=0))

    def followed_by(self, others: EarlierReadings) -> EarlierReadings:
        """These, then others."""
        return EarlierReadings(
            self.cases.followed_by(others.cases),
            np.concatenate([self.repeats, others.repeats]),
            np.concatenate([self.precision, others.precision]),
        )


@dataclass(frozen=True)
class Done:
    """What was measured before this plan.

    Attributes:
        source: File of the measurements.
        sha256: Its hash.
        experiments: How many experiments it has.
        cases: Their load cases, see `EarlierReadings`; if `repeats` are not known, their distinct
            configurations, each with a wrench.
        information: (p, p) information of their readings, by their noise alone [(N·m/rad)²].
        repeats: (E,) experiments of each load case; empty if nobody says.
        precision: (E, m, m) as of `EarlierReadings`; empty if nobody says.
    """

    source: str
    sha256: str
    experiments: int
    cases: LoadCases
    information: Array
    repeats: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    precision: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        freeze(self, "information", "precision")
        freeze(self, "repeats", dtype=np.int64)

    @property
    def readings(self) -> EarlierReadings | None:
        """What was read; None if nobody says how often, and how well."""
        known = len(self.repeats) > 0
        return EarlierReadings(self.cases, self.repeats, self.precision) if known else None


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
