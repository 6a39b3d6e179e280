"""What virtual campaigns know before they begin, as a study with an earlier campaign says it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel, rows_of
from elastocal.study.study import Study

_SCALE = 1e-6  # usual size of a compliance


def as_known(study: Study, truth: ComplianceModel) -> ComplianceModel:
    """The truth with the covariance that the study has of it: exact where the study knows none."""
    covariance = np.zeros((len(truth.names), len(truth.names)))
    if study.known is not None:
        names, model = study.known.uncertain.names, study.known.model
        to = [truth.names.index(name) for name in names]
        of = [model.names.index(name) for name in names]
        covariance[np.ix_(to, to)] = model.covariance[np.ix_(of, of)]
    return replace(truth, covariance=covariance)


def rows_known(study: Study) -> Array:
    """(E, f) rows with unit noise of what a campaign knows of the springs that it fits."""
    if study.known is None:
        return np.zeros((0, len(study.sought)))
    return rows_of(study.known.model, study.known.uncertain.names, study.sought.names)


def drawn(true: Array, rows: Array, number: int, rng: np.random.Generator) -> Array | None:
    """(C, f) compliances as `number` campaigns know them: off the true ones (f,) by chance.

    `rows`, (E, f), say how well; None without any. Only compliances they speak of are off.
    """
    if not len(rows):
        return None
    noise = rng.standard_normal((len(rows), number))
    off = np.linalg.lstsq(_SCALE * rows, noise, rcond=None)[0]
    return np.asarray(true + _SCALE * off.T, dtype=np.float64)
