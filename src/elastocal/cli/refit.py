"""The fit behind a model file, once more: whether the file says what its measurements give.

Imported by the commands when they run.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.cli.inputs import model_at
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import InputError
from elastocal.files.models.model_file import read_model
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.impossible import refuse_impossible_fit
from elastocal.identification.parallel import refuse_parallel
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study

_SAME = 1e-6  # difference in standard errors up to which a model is that of the measurements
_SAME_SPREAD = 1e-4  # the same of a covariance, as a correlation


def refit(
    study: Study,
    data: Measurements,
    how: Fit,
    model: Path | None,
    prior: Path | None,
    known: ComplianceModel | None,
) -> Identification:
    """The compliances once more from their measurements.

    Args:
        study: The study.
        data: The measurements.
        how: How the model was fitted.
        model: Its file, None if there is none.
        prior: Model from before, weighed by its covariance.
        known: Compliances of further springs.

    Raises:
        InputError: the fit is nonsense, or the file says anything else; names the first
            difference.
    """
    given = None if model is None else read_model(model, study.robot, believed=False)
    found = fitted(study, data, how, prior, known)
    if given is not None and (difference := _difference(given, found)):
        raise InputError(
            f"{model}: is not the model that {data.source} gives; {difference}; name the "
            "measurements, --prior and --known it was made from"
        )
    return found


def fitted(
    study: Study,
    data: Measurements,
    how: Fit,
    prior: Path | None,
    known: ComplianceModel | None,
) -> Identification:
    """The compliances from measurements.

    Raises:
        InputError: there is no fit, or it is nonsense; names the true reason where it shows.
    """
    before = model_at(prior, study.robot)
    try:
        found = identify(study.arm, data, how, prior=before, known=known, nuisance=study.nuisance)
    except InputError:
        if not how.linear:
            refuse_parallel(study.arm, data)
        raise
    refuse_impossible_fit(found, study.coupling)
    return found


def _difference(given: ComplianceModel, found: Identification) -> str:
    """What a model says otherwise than a fit; nothing if it is the one found."""
    if missing := [name for name in found.identified if name not in given.names]:
        return f"it has no compliance of {', '.join(missing)}, which the study identifies"
    fitted = found.model
    names = [*found.identified, *(n for n in fitted.names if n not in found.identified)]
    there, here = given.of(names), fitted.of(names)
    index = [fitted.names.index(name) for name in names]
    error = fitted.standard_error[index]
    off = np.abs(there - here)
    if (off > _SAME * np.maximum(error, 1e-6 * np.abs(here))).any():
        i = int(np.argmax(off / np.maximum(np.abs(here), 1e-300)))
        return f"{names[i]} is {there[i]:.6g} there and {here[i]:.6g} from these measurements"
    if more := [name for name in given.names if name not in names]:
        return f"it has a compliance of {more[0]} besides"
    own = [given.names.index(name) for name in names]
    spread, right = given.covariance[np.ix_(own, own)], fitted.covariance[np.ix_(index, index)]
    apart = np.abs(spread - right) > _SAME_SPREAD * np.outer(error, error)
    if (wrong := np.flatnonzero(np.diagonal(apart))).size:
        i, claimed = int(wrong[0]), given.standard_error[own]
        return (
            f"the standard error of {names[i]} is {claimed[i]:.6g} there and {error[i]:.6g} from "
            "these measurements"
        )
    if apart.any():
        i, j = divmod(int(np.argmax(apart)), len(names))
        return f"the covariance of {names[i]} and {names[j]} is another one"
    if given.dof != fitted.dof:
        return f"it claims {given.dof:g} degrees of freedom, there are {fitted.dof:g}"
    return ""
