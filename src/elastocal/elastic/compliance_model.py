"""Compliance model: the compliances of an arm with their uncertainty, as one frozen value.

It is what identification gives, what compensation takes, and, without uncertainty, the truth that
a simulation starts from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, freeze, unset
from elastocal.elastic.springs import VirtualJoints, merged
from elastocal.errors import InputError


@dataclass(frozen=True)
class ComplianceModel:
    """p compliances; every joint without one is rigid.

    Attributes:
        springs: The p springs, in chain order.
        compliance: (p,) [rad/(N·m), or m/N for linear springs].
        covariance: (p, p) of the estimates; zero if not given: known exactly.
        dof: Degrees of freedom behind the covariance; infinite if σ was known.
        source: Where the values come from.
    """

    springs: VirtualJoints
    compliance: Array
    covariance: Array = field(default_factory=unset)
    dof: float = np.inf
    source: str = ""

    def __post_init__(self) -> None:
        p = len(self.springs)
        covariance = self.covariance if np.size(self.covariance) else np.zeros((p, p))
        freeze(self, "compliance", covariance=covariance)
        compliance, covariance = self.compliance, self.covariance
        if compliance.shape != (p,) or covariance.shape != (p, p):
            raise InputError(
                f"a model of {p} springs needs {p} compliances and a {p} x {p} covariance; found "
                f"{compliance.shape} and {covariance.shape}"
            )
        if not (np.isfinite(compliance).all() and np.isfinite(covariance).all()):
            raise InputError("compliances and their covariance must be finite numbers")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the p springs."""
        return self.springs.names

    @property
    def standard_error(self) -> Array:
        """(p,) standard errors, zero where a compliance is known exactly."""
        return np.sqrt(np.diagonal(self.covariance))

    def of(self, names: Sequence[str]) -> Array:
        """(len(names),) compliances of the springs called `names`; zero for rigid joints."""
        known = dict(zip(self.names, self.compliance, strict=True))
        return np.array([known.get(name, 0.0) for name in names])


def merged_models(models: Sequence[ComplianceModel]) -> ComplianceModel:
    """One model of the springs of several, identified independently of each other.

    Its degrees of freedom are the fewest of theirs, on the safe side.

    Raises:
        InputError: none, or a spring in two of them.
    """
    if not models:
        raise InputError("no model to merge")
    result = models[0]
    for other in models[1:]:
        springs = merged(result.springs, other.springs)
        order = [(*result.names, *other.names).index(name) for name in springs.names]
        p, both = len(result.springs), len(springs)
        covariance = np.zeros((both, both))
        covariance[:p, :p], covariance[p:, p:] = result.covariance, other.covariance
        result = ComplianceModel(
            springs=springs,
            compliance=np.append(result.compliance, other.compliance)[order],
            covariance=covariance[np.ix_(order, order)],
            dof=min(result.dof, other.dof),
            source=", ".join(s for s in (result.source, other.source) if s),
        )
    return result
