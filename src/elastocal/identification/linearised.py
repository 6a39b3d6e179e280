"""A fit linearised at its estimate: rows, residuals and information in units of the noise.

In: an identification. Out: what is asked about changes of its model without another fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import deflection_and_gradient
from elastocal.elastic.load_cases import ranks_of_rows
from elastocal.elastic.regressor import regressor
from elastocal.identification.result import Identification
from elastocal.identification.shared_errors import SharedErrors, shared_errors
from elastocal.matrices import scaled_inverse
from elastocal.measuring.measurements import Measurements
from elastocal.measuring.whitening import noise_factors


@dataclass(frozen=True)
class Linearised:
    """A fit of f unknowns to R readings at its estimate, over the noise that it counts with.

    Attributes:
        names: Names of what was fitted and not held at a bound.
        rows: (R, 3, f) derivatives of the readings in what was fitted.
        residual: (R, 3) what the model leaves.
        information: (f, f) of the whole fit, a prior included.
        whitener: (R, 3, 3) what divides readings by their noise and counts outlying ones less.
        shared: What readings share, as an unloaded reading; their coordinates are turned then.
        group: (R,) number of the configuration of each reading, whatever its load.
        noise: (R, 3, 3) what turns residuals over the noise back to lengths and angles [m, rad].
        position: (R,) which readings are positions.
    """

    names: tuple[str, ...]
    rows: Array
    residual: Array
    information: Array
    whitener: Array
    shared: SharedErrors | None
    group: IntArray
    noise: Array
    position: BoolArray

    def white(self, columns: Array) -> Array:
        """(R, 3, k) columns of the readings over the noise, turned as rows and residual are."""
        return _white(columns, self.whitener, self.shared)

    @cached_property
    def covariance(self) -> Array:
        """(f, f) inverse of the information."""
        return np.asarray(scaled_inverse(self.information[None])[0])


def linearised(found: Identification) -> Linearised:
    """The fit of the springs that are sought, without nuisance, at its estimate."""
    found, data = found.alone or found, found.measurements
    noise, quiet = noise_factors(data.covariance)
    whitener = quiet * np.sqrt(found.weight / found.variance)[:, None, None]
    names = tuple(name for name in found.fitted if name not in found.held)
    own = [found.fitted.index(name) for name in names]
    moving = [found.model.names.index(name) for name in names]
    q = np.round(data.cases.q, 9)
    shared = shared_errors(data, quiet)
    return Linearised(
        names=names,
        rows=_white(model_rows(found, data)[:, :, moving], whitener, shared),
        residual=_white(found.residual[:, :, None], whitener, shared)[:, :, 0],
        information=found.information[np.ix_(own, own)],
        whitener=whitener,
        shared=shared,
        group=ranks_of_rows(q)[data.case],
        noise=noise * np.sqrt(found.variance),
        position=~data.rotations,
    )


def _white(columns: Array, whitener: Array, shared: SharedErrors | None) -> Array:
    over = whitener @ columns
    if shared is None:
        return over
    return shared.turned(over.reshape(3 * len(over), -1)).reshape(over.shape)


def model_rows(found: Identification, data: Measurements) -> Array:
    """(R, 3, c) derivatives of the readings in all compliances of the model."""
    arm = replace(found.arm, springs=found.model.springs, tool=data.tool)
    if found.how.linear:
        return linear_rows(arm, data)
    return _read(deflection_and_gradient(arm, found.model.compliance, data.cases)[1], data)


def linear_rows(arm: ElasticArm, data: Measurements) -> Array:
    """(R, 3, p) rows of the linear model for the readings."""
    return _read(regressor(arm, data.cases), data)


def _read(gradient: Array, data: Measurements) -> Array:
    """(R, 3, p) of what is (N, 3T, p): that of the targets read."""
    shape = (len(data.cases), len(data.tool.targets), 3, -1)
    return np.asarray(gradient.reshape(shape)[data.case, data.marker])
