"""What an identification promises for a task, besides the covariance of its compliances.

In: an identification. Out: the covariance that a task feels, and how far off the model was where
it could be seen.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.case_errors import LOAD_GAIN
from elastocal.fitting.goodness import SURE, p_value_chi_square
from elastocal.identification.left_out_error import left_out_error
from elastocal.identification.result import Identification


def covariance_at_task(found: Identification) -> Array:
    """(c, c) covariance of all compliances as a task feels them.

    A load cell that reads all loads of the campaign too large makes all compliances too small. If
    it reads the process force too, nothing of that is left in the product; another cell errs by
    itself besides; a force that is exact meets the compliances as they are.

    Source: ours; of (1 + g) k where the cell is the same.
    """
    model, nuisance = found.model, found.nuisance
    if nuisance is None or nuisance.errors.common_gain == 0.0:
        return model.covariance
    errors, k = nuisance.errors, model.compliance
    if errors.process_force == "exact":
        return model.covariance
    if errors.process_force == "other":
        return np.asarray(model.covariance + errors.common_gain**2 * np.outer(k, k))
    gain = found.fitted.index(LOAD_GAIN)
    made = _made(found)
    whole = np.column_stack([made, errors.common_gain * k])
    index = [*range(made.shape[1]), gain]
    return np.asarray(whole @ found.unknown_covariance[np.ix_(index, index)] @ whole.T)


def _made(found: Identification) -> Array:
    """(c, s + u) compliances for one of each unknown that is a spring, or makes springs."""
    names, nuisance = found.model.names, found.nuisance
    assert nuisance is not None
    assert found.alone is not None
    own = found.alone.fitted
    made = np.zeros((len(names), len(own) + len(nuisance.names)))
    made[[names.index(n) for n in own], range(len(own))] = 1.0
    rows = [names.index(n) for n in nuisance.unknowns.springs.names]
    made[rows, len(own) :] = nuisance.unknowns.make
    return made


def model_error(found: Identification) -> float:
    """How far off left-out experiments were, root mean square [m], if the noise cannot explain it.

    The noise is what repeats show, else what is promised: one that was found in the residuals of
    the fit has the error of the model in it. Beside nuisance it is what is beyond its promise.

    Source: ours.
    """
    lack = found.lack_of_fit
    if found.nuisance is None and lack is not None and lack.fit_dof > 0:
        by_chance = not lack.beyond_chance
    else:
        by_chance = not p_value_chi_square(found.chi_square, found.dof) < SURE
    if by_chance or found.how.robust:
        return 0.0
    error = left_out_error(found)
    beyond = error.seen**2 - (error.promised**2 if found.nuisance is not None else 0.0)
    return float(np.sqrt(beyond)) if beyond > 0.0 else 0.0
