"""What is known of compliances before they are measured, as rows with unit noise.

In: a model with covariance. Out: which of its springs are uncertain, and rows that say the rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import InputError

_TIED = 1e-12  # eigenvalue of a correlation matrix at which a combination counts as exact


def uncertain(model: ComplianceModel, names: Sequence[str]) -> tuple[str, ...]:
    """Those of `names` that the model knows, but not exactly."""
    deviation = dict(zip(model.names, model.standard_error, strict=True))
    return tuple(name for name in names if deviation.get(name, 0.0) > 0.0)


def rows_of(model: ComplianceModel, shared: Sequence[str], names: Sequence[str]) -> Array:
    """(E, p) rows over the springs `names` whose product with compliances has unit noise.

    Args:
        model: What is known; its covariance.
        shared: The E of its springs that count, none of them known exactly.
        names: The p springs that are fitted.

    Raises:
        InputError: the model knows a combination of its springs exactly.

    Source: the rows R have RᵀR the inverse covariance.
    """
    rows = np.zeros((len(shared), len(names)))
    if not shared:
        return rows
    index = [model.names.index(name) for name in shared]
    covariance = model.covariance[np.ix_(index, index)]
    scale = np.sqrt(np.diagonal(covariance))
    correlation = covariance / np.outer(scale, scale)
    if np.linalg.eigvalsh(correlation)[0] < _TIED:
        raise InputError(
            f"{model.source or 'the model'}: its covariance is singular, a combination of "
            f"{', '.join(shared)} has no uncertainty at all; give standard errors alone, or a "
            "covariance of full rank"
        )
    root = np.linalg.inv(np.linalg.cholesky(correlation)) / scale
    rows[:, [names.index(name) for name in shared]] = root
    return rows
