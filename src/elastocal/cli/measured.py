"""Measurement files on the command line: read, refused where they cannot count, told from plans.

Imported by the commands when they run.
"""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastocal.errors import InputError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.measurements.recognised import has_readings
from elastocal.files.models.model_file import readings_in
from elastocal.identification.impossible import refuse_impossible_readings
from elastocal.measuring.measurements import Measurements
from elastocal.study.known import Known
from elastocal.study.study import Study

if TYPE_CHECKING:  # of plans, which most commands do not read
    from elastocal.files.plans.proposal_file import Proposal
    from elastocal.planning.as_measured import Measured
    from elastocal.study.before import Done


def readings(
    study: Study, paths: list[Path], mapping: Path | None = None, plan: Path | None = None
) -> Measurements:
    """The readings in one file, or in several that belong together.

    Raises:
        InputError: they cannot be read, or cannot be.
    """
    data = read_measurements(paths[0] if len(paths) == 1 else paths, study, mapping, plan)
    refuse_impossible_readings(data, study.robot)
    return data


def refuse_twice(data: Measurements, *before: Path | Known | None) -> None:
    """Refuse models of before that count these readings, however far back: they would twice.

    Raises:
        InputError: a model was fitted to them, or with the help of one that was.
    """
    read = {*data.readings, data.sha256} - {""}
    for model in before:
        if model is not None:
            name = model.source if isinstance(model, Known) else str(model)
            counted = model.readings if isinstance(model, Known) else readings_in(model)
            if read & {*counted}:
                raise InputError(
                    f"{name}: has the readings of {data.source} in it already, so they would count "
                    "twice; name a model from before them"
                )


def measured_among(paths: list[Path], mapping: Path | None) -> list[Path]:
    """Those of the files that have readings, and are no plans.

    Raises:
        InputError: none has, and there is a mapping for it.
    """
    read = [path for path in paths if has_readings(path, foreign=mapping is not None)]
    if mapping is not None and not read:
        raise InputError(f"{mapping}: a mapping is for measurements, and these files are plans")
    return read


def as_proposal(paths: list[Path], done: Measured, taken: Container[str]) -> Proposal:
    """A campaign that was measured as a plan that claims nothing, by the names of its files."""
    from elastocal.files.plans.proposal_file import Proposal

    name = ", ".join(path.name for path in paths)
    name = ", ".join(map(str, paths)) if name in taken else name
    return Proposal(name, done.cases, done.repeats)


_SAME = 1e-6  # difference of information that is rounding, as a correlation


def recomputed(before: Done, study: Study, plan: Path) -> bool:
    """Whether what a plan says of the experiments before it was worked out again, and is so.

    Args:
        before: What the plan says.
        study: Its study, without what was measured.
        plan: Its file; the measurements are where it was made, or beside it.

    Returns:
        Whether their files are there, as they were.

    Raises:
        InputError: they are, and tell something else.
    """
    from elastocal.planning.remaining import done

    names, _, mapping = before.source.partition(" through ")
    for folder in (Path(), plan.parent):
        files = [folder / name for name in names.split(", ")]
        foreign = folder / mapping if mapping else None
        if not all(file.is_file() for file in [*files, *([foreign] if foreign else [])]):
            continue
        data = read_measurements(files[0] if len(files) == 1 else files, study, foreign)
        if data.sha256 != before.sha256:
            continue
        true = done(study, data)
        if true.information.shape != before.information.shape:
            continue
        scale = np.sqrt(np.diagonal(true.information))
        apart = np.abs(before.information - true.information) > _SAME * np.outer(scale, scale)
        if before.experiments != len(data.cases) or apart.any():
            raise InputError(
                f"{plan}: after: information_N2m2 is not what {before.source} tells; make the plan "
                "again with --after"
            )
        if before.readings is not None and not _same_readings(before, true):
            raise InputError(
                f"{plan}: after: configurations, their repeats or precisions_per_m2 are not what "
                f"{before.source} has; make the plan again with --after"
            )
        return True
    return False


def _same_readings(before: Done, true: Done) -> bool:
    """Whether load cases, repeats and precisions are the same."""
    for one, other, near in (
        (before.repeats, true.repeats, 0.0),
        (before.cases.q, true.cases.q, _SAME),
        (before.cases.second, true.cases.second, _SAME),
        (before.cases.first, true.cases.first, _SAME),
        (before.precision, true.precision, _SAME * np.abs(true.precision).max()),
    ):
        if one.shape != other.shape or (np.abs(one - other) > near).any():
            return False
    return True
