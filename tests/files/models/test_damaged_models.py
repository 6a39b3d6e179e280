"""Every node of a model replaced by something else: it is the same model, or named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import ModelFileError
from elastocal.files.models import model_file
from elastocal.files.models.identification_file import write_identification
from elastocal.files.models.model_file import model_sections, read_model
from tests.files.campaign import measurements, study
from tests.files.damage import damaged


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The model of a campaign of random deflections."""
    rng = np.random.default_rng(0)
    found = ec.identify(study().arm, measurements(6, rng), ec.Fit(sigma="estimated"))
    out = tmp_path_factory.mktemp("model") / "model.json"
    write_identification(study(), found, out)
    document = json.loads(out.read_text("utf-8"))
    del document["diagnostics"]["test_poses"][0]["compliance_matrix_SI"]
    return document


ODD = (None, "x", "2", 1, 1e29, True, [], {})
KR270 = ec.load_robot("kuka-kr270")


def what_is_said(path: Path) -> ComplianceModel | str:
    try:
        model_sections(path)
        return read_model(path, KR270)
    except ModelFileError as error:
        return str(error)


def same(one: ComplianceModel, other: ComplianceModel) -> bool:
    return (
        one.names == other.names
        and np.array_equal(one.compliance, other.compliance)
        and np.array_equal(one.covariance, other.covariance)
        and one.dof == other.dof
    )


def test_every_node_is_what_it_was_or_named(
    document: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model_file, "_SMALL_ENOUGH_TO_LOCATE", 0)  # lines take time
    path = tmp_path / "model.json"
    path.write_text(json.dumps(document), "utf-8")
    good, said = read_model(path, KR270), set()
    for place, what, changed in damaged(document, ODD):
        path.write_text(json.dumps(changed), "utf-8")
        found = what_is_said(path)
        told = f"{place} = {what!r}: {found}"
        if isinstance(found, ComplianceModel):
            assert same(found, good), told
            continue
        said.add(found)
        assert found.startswith(f"{path}"), told
        assert "\n" not in found, told
    assert len(said) > 200
