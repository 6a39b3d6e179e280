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
from elastocal.matrices import freedom_of


@dataclass(frozen=True)
class ComplianceModel:
    """p compliances; every joint without one is rigid.

    Attributes:
        springs: The p springs, in chain order.
        compliance: (p,) [rad/(N·m), or m/N for linear springs].
        covariance: (p, p) of the estimates; zero if not given: known exactly.
        dof: Degrees of freedom behind the covariance; infinite if σ was known.
        source: Where the values come from.
        noise_part: (p, p) the part of the covariance that grows with the noise found; see
            `by_noise`.
        noise: Noise found in the readings over that promised, 1 if it was known.
        task_covariance: (p, p) covariance of what a task feels; see `at_task`.
        model_error: How far off predictions of left-out experiments were, if the noise does not
            explain it: root mean square of positions [m].
    """

    springs: VirtualJoints
    compliance: Array
    covariance: Array = field(default_factory=unset)
    dof: float = np.inf
    source: str = ""
    noise_part: Array = field(default_factory=unset)
    noise: float = 1.0
    task_covariance: Array = field(default_factory=unset)
    model_error: float = 0.0

    def __post_init__(self) -> None:
        p = len(self.springs)
        covariance = self.covariance if np.size(self.covariance) else np.zeros((p, p))
        freeze(self, "compliance", "noise_part", "task_covariance", covariance=covariance)
        for part in (self.noise_part, self.task_covariance):
            if part.size and part.shape != (p, p):
                raise InputError(
                    f"a model of {p} springs has covariances of {p} x {p}, found {part.shape}"
                )
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
    def by_noise(self) -> Array:
        """(p, p) the part of the covariance that grows with the noise found; the rest is a prior's.

        If nothing else is said, all of it where `dof` is finite, else nothing.
        """
        if self.noise_part.size:
            return self.noise_part
        return self.covariance if np.isfinite(self.dof) else np.zeros_like(self.covariance)

    @property
    def at_task(self) -> Array:
        """(p, p) covariance of what a task feels, whose force is measured as the campaign says.

        What all loads of a campaign share cancels where one cell measures them and the process
        force. If nothing else is said, it is the covariance.
        """
        return self.task_covariance if self.task_covariance.size else self.covariance

    @property
    def standard_error(self) -> Array:
        """(p,) standard errors, zero where a compliance is known exactly."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def uncertain(self) -> tuple[str, ...]:
        """Names of the springs that are not known exactly."""
        errors = self.standard_error
        return tuple(n for n, error in zip(self.names, errors, strict=True) if error > 0.0)

    def freedom(self, rows: Array) -> Array:
        """(K,) degrees of freedom of combinations (K, p) of the compliances."""
        return freedom_of(self.covariance, self.by_noise, self.dof, rows)

    def of(self, names: Sequence[str]) -> Array:
        """(len(names),) compliances of the springs called `names`; zero for rigid joints."""
        known = dict(zip(self.names, self.compliance, strict=True))
        return np.array([known.get(name, 0.0) for name in names])


_TIED = 1e-12  # eigenvalue of a correlation matrix at which a combination counts as exact
_NEARLY = 1e-4  # eigenvalue that it gets instead: 1 % of a standard error
_ELSEWHERE = 1e-6  # distance [m] and sine of an angle that make another spring


def unit_rows(covariance: Array) -> Array:
    """(p, p) rows over p unknowns that say with unit noise what has this covariance (p, p).

    Springs that are made of fewer unknowns, as two of a bearing that tilts alike in every
    direction, have combinations without uncertainty. Such a one counts as known to 1 % of the
    standard errors: enough to hold, and the rows stay finite.

    Source: RᵀR of the rows R is the inverse covariance.
    """
    scale = np.sqrt(np.diagonal(covariance))
    correlation = covariance / np.outer(scale, scale)
    size, axes = np.linalg.eigh(correlation)
    if size[0] < _TIED:
        return np.asarray((axes / np.sqrt(np.where(size < _TIED, _NEARLY, size))).T / scale)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(correlation)) / scale)


def rows_of(model: ComplianceModel, shared: Sequence[str], names: Sequence[str]) -> Array:
    """(E, p) rows over the springs `names`: what a model knows of them, with unit noise.

    Args:
        model: What is known; its covariance.
        shared: The E of its springs that count, none of them known exactly.
        names: The p springs that are fitted.

    Source: see `unit_rows`.
    """
    rows = np.zeros((len(shared), len(names)))
    if not shared:
        return rows
    index = [model.names.index(name) for name in shared]
    root = unit_rows(model.covariance[np.ix_(index, index)])
    rows[:, [names.index(name) for name in shared]] = root
    return rows


def refuse_other_springs(model: ComplianceModel, springs: VirtualJoints) -> None:
    """Refuse a model that has another spring under the name of one of `springs`.

    Raises:
        InputError: it sits elsewhere, or gives way along another axis.
    """
    for i, name in enumerate(springs.names):
        if name not in model.names:
            continue
        j, other = model.names.index(name), model.springs
        along, apart = springs.axis[i], other.origin[j] - springs.origin[i]
        same = springs.body[i] == other.body[j] and springs.prismatic[i] == other.prismatic[j]
        off = np.abs(np.cross(along, other.axis[j])).max()
        if not springs.prismatic[i]:  # where along its axis the origin lies makes no difference
            off = max(off, np.abs(np.cross(along, apart)).max())
        if not same or off > _ELSEWHERE:
            raise InputError(
                f"{model.source or 'the model'}: its spring {name!r} is another one than that of "
                "the study: body, type, axis and origin must be the same"
            )


def merged_models(models: Sequence[ComplianceModel]) -> ComplianceModel:
    """One model of the springs of several, identified independently of each other.

    Its degrees of freedom are the fewest of theirs, its noise the largest, on the safe side.

    Raises:
        InputError: none, or a spring in two of them.
    """
    if not models:
        raise InputError("no model to merge")
    result = models[0]
    for other in models[1:]:
        springs = merged(result.springs, other.springs)
        order = [(*result.names, *other.names).index(name) for name in springs.names]
        covariance, by_noise, at_task = (
            _side_by_side(getattr(result, name), getattr(other, name))
            for name in ("covariance", "by_noise", "at_task")
        )
        result = ComplianceModel(
            springs=springs,
            compliance=np.append(result.compliance, other.compliance)[order],
            covariance=covariance[np.ix_(order, order)],
            dof=min(result.dof, other.dof),
            source=", ".join(s for s in (result.source, other.source) if s),
            noise_part=by_noise[np.ix_(order, order)],
            noise=max(result.noise, other.noise),
            task_covariance=at_task[np.ix_(order, order)],
            model_error=float(np.hypot(result.model_error, other.model_error)),
        )
    return result


def _side_by_side(one: Array, other: Array) -> Array:
    """Both matrices on the diagonal of one, in that order."""
    p = len(one)
    both = np.zeros((p + len(other), p + len(other)))
    both[:p, :p], both[p:, p:] = one, other
    return both
