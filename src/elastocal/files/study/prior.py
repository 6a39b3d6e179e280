"""What is known of the compliances before a campaign, as its information."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import refuse_other_springs, rows_of
from elastocal.errors import ElastocalError, InputError
from elastocal.files.sections import Section, fields_of
from elastocal.files.texts import file_hash
from elastocal.files.values import FileName, Name, Number, Positive
from elastocal.files.yaml_lines import LocatedError
from elastocal.matrices import is_information, is_symmetric
from elastocal.study.before import CarriedOut, Earlier
from elastocal.study.study import Study


class PriorFile(Section):
    """What is known before: one of four ways to say it."""

    plan: FileName | None = None
    model: FileName | None = None
    standard_error_rad_per_Nm: dict[Name, Positive] | None = None
    information_N2m2: list[list[Number]] | None = None


def with_prior(study: Study, entry: PriorFile, folder: Path) -> Study:
    """The study with what is known of its compliances before the campaign."""
    if _given(entry) == ["model"]:
        return _after_model(study, str(entry.model), folder)
    if entry.plan is None or _given(entry) != ["plan"]:
        return replace(study, prior=_information(study, entry))
    from elastocal.files.plans.proposal_file import read_proposal

    try:
        proposal = read_proposal(folder / entry.plan, study)
    except ElastocalError as error:
        raise LocatedError(("plan",), f"prior plan: {error}") from None
    if proposal.edited:
        raise LocatedError(
            ("plan",),
            f"prior plan: {folder / entry.plan}: has other load cases than it was written with; "
            "load cases that are changed by hand are a run sheet (CSV)",
        )
    digest = file_hash(folder / entry.plan)
    carried_out = CarriedOut(proposal.load_cases, proposal.repeats, entry.plan, digest)
    return replace(study, prior=carried_out.information(study.space), carried_out=carried_out)


def _after_model(study: Study, name: str, folder: Path) -> Study:
    """The study after a campaign that found springs which it identifies again."""
    from elastocal.files.models.model_file import read_model

    names = study.springs.names
    try:
        model = read_model(folder / name, study.robot)
        shared = [spring for spring in names if spring in model.names]
        exact = [spring for spring in shared if spring not in model.uncertain]
        if not shared:
            raise InputError(
                f"{name}: knows {', '.join(model.names)}, and none of what is identified here, "
                f"{', '.join(names)}"
            )
        if exact:
            raise InputError(
                f"{name}: gives no standard error of {exact[0]}, which is identified here; without "
                "one nothing is left to identify"
            )
        refuse_other_springs(model, study.springs)
        rows = rows_of(model, shared, names)
    except ElastocalError as error:
        raise LocatedError(("model",), f"prior model: {error}") from None
    earlier = Earlier(model, name, file_hash(folder / name))
    return replace(study, prior=rows.T @ rows, earlier=earlier)


def _given(entry: PriorFile) -> list[str]:
    return [key for key in fields_of(PriorFile) if getattr(entry, key) is not None]


def _information(study: Study, entry: PriorFile) -> Array:
    """(p, p) information [(N·m/rad)²] as the file has it."""
    names = study.springs.names
    given = _given(entry)
    if len(given) != 1:
        raise InputError(
            f"prior needs exactly one of {', '.join(fields_of(PriorFile))}, found {len(given)}"
        )
    if entry.standard_error_rad_per_Nm is not None:
        known = np.zeros((len(names), len(names)))
        for name, error in entry.standard_error_rad_per_Nm.items():
            if name not in names:
                raise LocatedError(
                    (given[0], name),
                    f"{name!r} is not identified in this study; identified are {', '.join(names)}",
                )
            known[names.index(name), names.index(name)] = error**-2.0
        return known
    assert entry.information_N2m2 is not None
    rows = entry.information_N2m2
    if len(rows) != len(names) or any(len(row) != len(names) for row in rows):
        raise LocatedError(
            (given[0],),
            f"the information must be {len(names)} rows of "
            f"{len(names)} numbers, one for each of {', '.join(names)}",
        )
    information: Array = np.array(rows)
    if not is_symmetric(information):
        raise LocatedError((given[0],), "the information matrix is not symmetric")
    if not is_information(information):
        raise LocatedError((given[0],), "the information matrix has a negative eigenvalue")
    return information
