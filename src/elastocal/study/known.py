"""What an earlier campaign found: springs that bend in this one, but are not wanted here."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel, rows_of
from elastocal.elastic.springs import VirtualJoints, subset


@dataclass(frozen=True)
class Known:
    """Compliances of springs that bend in the experiments and are not identified by them.

    Attributes:
        model: The compliances with their covariance; they are zero if `planned`.
        planned: Whether a plan says how well they will be known, and nobody yet what they are.
        source: File it was read from, as it was named; empty if there is none.
        sha256: Hash of that file.
        left_out: Springs of the file that the study identifies itself, which are not taken from it.
        readings: Hashes of the files with readings that it counts, as far as it says.
    """

    model: ComplianceModel
    planned: bool = False
    source: str = ""
    sha256: str = ""
    readings: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    @cached_property
    def uncertain(self) -> VirtualJoints:
        """The u springs that are not known exactly."""
        return subset(self.model.springs, self.model.uncertain)

    @cached_property
    def information(self) -> Array:
        """(u, u) inverse of their covariance [(N·m/rad)²]."""
        names = self.uncertain.names
        rows = rows_of(self.model, names, names)
        return np.asarray(rows.T @ rows)
