"""What was known of further springs when a plan was made, as a section of plan.json."""

from __future__ import annotations

from typing import Any

from elastocal.errors import InputError, PlanFileError
from elastocal.files.models.model_file import ModelFile, model_of
from elastocal.files.models.writing import model_document
from elastocal.files.sections import SectionError
from elastocal.robot.chain import Robot
from elastocal.study.known import Known

_SAME = ("compliance", "springs", "covariance", "dof")  # keys as in a model file


def known_section(robot: Robot, known: Known) -> dict[str, Any]:
    """The section `known`."""
    model = model_document(known.model, robot)
    return {
        "file": known.source,
        "sha256": known.sha256,
        "planned": known.planned,
        **{key: model[key] for key in _SAME if key in model},
    }


def read_known(entry: Any, robot: Robot, where: str) -> Known:
    """The section `known`, as it was written.

    Raises:
        PlanFileError: it is wrong; names the key.
    """
    if not isinstance(entry, dict):
        raise PlanFileError(f"{where}: expected a section of keys")
    source = str(entry.get("file", ""))
    try:
        file = ModelFile.of({key: entry[key] for key in _SAME if key in entry})
        model = model_of(file, robot, source)
    except SectionError as error:
        first = error.problems[0]
        key = " of ".join(map(str, first.place))
        raise PlanFileError(f"{where}: {key}: {first.said or f'is {first.kind}'}") from None
    except InputError as error:
        raise PlanFileError(f"{where}: {error}") from None
    return Known(model, bool(entry.get("planned")), source, str(entry.get("sha256", "")))
