"""Model files: what is written comes back; what is wrong is named with line and key."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.errors import InputError, ModelFileError
from elastocal.files.models.model_file import ModelFile, model_of, model_sections, read_model
from elastocal.files.models.writing import model_document, write_model
from elastocal.files.study.springs import in_chain_order
from elastocal.robot.sources import load
from tests.arms import random_chain

KR270 = load("kuka-kr270")


def written(tmp_path: Path, text: str, name: str = "truth.json") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_an_identified_model_comes_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(5, 5)) * 1e-9
    model = ComplianceModel(
        joint_springs(KR270, ["A2", "A3", "A4", "A5", "A6"]),
        np.array([0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6,
        root @ root.T,
        31.0,
        "a campaign",
    )
    path = tmp_path / "model.json"
    extra = {"diagnostics": {"chi2": 3.5, "residuals": [[1.0, np.nan]]}}
    write_model(model, path, KR270, provenance={"study": {"sha256": "ab"}}, sections=extra)
    back = read_model(path, KR270)
    assert back.names == model.names
    np.testing.assert_array_equal(back.compliance, model.compliance)
    np.testing.assert_allclose(back.covariance, model.covariance, rtol=1e-14, atol=0.0)
    np.testing.assert_array_equal(back.springs.joint, model.springs.joint)
    assert back.dof == 31.0
    assert back.source == "a campaign"
    assert model_sections(path) == {
        "provenance": {"study": {"sha256": "ab"}},
        "identification": {},
        "diagnostics": {"chi2": 3.5, "residuals": [[1.0, None]]},
    }


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=5))
def test_springs_anywhere_come_back(seed: int, slides: list[bool]) -> None:
    """Axes and origins go through the frames of the file and back."""
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, slides)
    n = len(slides)
    body = np.sort(rng.integers(0, n + 1, 3))
    axis = rng.normal(size=(3, 3))
    extra = {
        f"s{i}": VirtualJoints(
            (f"s{i}",),
            body[i : i + 1],
            axis[i : i + 1] / np.linalg.norm(axis[i]),
            rng.normal(size=(1, 3)),
            rng.integers(0, 2, 1).astype(bool),
        )
        for i in range(3)
    }
    springs = in_chain_order(dict.fromkeys([*robot.joint_names, *extra]), extra, robot)
    model = ComplianceModel(springs, rng.uniform(1e-7, 1e-6, n + 3))
    document = json.loads(json.dumps(model_document(model, robot)))
    back = model_of(ModelFile.of(document), robot, "model.json")
    assert back.names == model.names
    np.testing.assert_array_equal(back.compliance, model.compliance)
    for field in ("body", "prismatic", "joint"):
        np.testing.assert_array_equal(getattr(back.springs, field), getattr(springs, field))
    np.testing.assert_allclose(back.springs.axis, springs.axis, atol=1e-14)
    np.testing.assert_allclose(back.springs.origin, springs.origin, atol=1e-14)


def test_a_file_written_by_hand(tmp_path: Path) -> None:
    text = "compliance: {A1: {value: 0.3e-6, unit: rad/(N.m)}, A3: {value: 4e-7, unit: rad/Nm}}\n"
    model = read_model(written(tmp_path, text), KR270)
    assert model.names == ("A1", "A3")
    np.testing.assert_allclose(model.compliance, [0.3e-6, 4e-7], rtol=1e-15)
    assert not model.covariance.any()
    assert np.isinf(model.dof)
    assert model.source == "truth.json"
    as_json = '{"compliance": {"A1": {"value": 0.3, "unit": "µrad/(N·m)"}}}'
    again = read_model(written(tmp_path, as_json), KR270)
    np.testing.assert_allclose(again.compliance, [0.3e-6], rtol=1e-15)


def test_stiffness_instead(tmp_path: Path) -> None:
    text = """
compliance:
  A2: {value: 0.302, unit: urad/(N.m), standard_error: 0.003}
stiffness:
  A1: {value: 2.0e+6, unit: N.m/rad, standard_error: 2.0e+4}
  A3: {value: 2.5, unit: kN·m/mrad}
"""
    with pytest.raises(ModelFileError, match=r"line 6.*'kN·m/mrad' is not known"):
        read_model(written(tmp_path, text), KR270)
    model = read_model(written(tmp_path, text.replace("kN·m/mrad", "MN·m/rad")), KR270)
    np.testing.assert_allclose(model.compliance, [0.5e-6, 0.302e-6, 0.4e-6], rtol=1e-14)
    np.testing.assert_allclose(model.standard_error, [0.5e-8, 0.3e-8, 0.0], rtol=1e-14)


def test_an_estimate_may_be_negative_an_exact_value_not(tmp_path: Path) -> None:
    text = "compliance: {A1: {value: -1.0e-8, unit: rad/(N.m), standard_error: 2.0e-8}}"
    assert read_model(written(tmp_path, text), KR270).compliance[0] == -1e-8


BAD = {
    "": "the file is empty",
    "[1, 2]": "expected sections",
    "{": "line 1, column 2: not valid JSON",
    '{"kind": "plan"}': "a plan file, expected a model",
    "kind: plan": "a plan file, expected a model",
    "elastocal: 2\ncompliance: {}": "format version 2",
    "elastocal: 1": "no compliances",
    "compliance: [1]": "line 1: compliance: expected a section of keys, found list",
    "compliances: {}": "line 1: unknown key 'compliances'; did you mean 'compliance'",
    "compliance:\n  A9: {value: 1, unit: rad/(N.m)}": "line 2: .*no joint or spring 'A9'",
    "compliance:\n  A1: 3.0e-7": r"line 2: compliance.A1: expected \{value",
    "compliance:\n  A1: {value: 3.0e-7}": "line 2: key 'unit' is missing in compliance.A1",
    "compliance:\n  A1:\n    value: 3.0e-7\n    unit: m/N": "line 4: .*compliance of a linear",
    "compliance:\n  A1:\n    value: 3.0e-7\n    unit: N.m/rad": "line 4: .*stiffness of an ang",
    "compliance:\n  A1:\n    value: 3.0e-7\n    unit: 1": "line 4: .*expected rad.*found 1",
    "compliance:\n  A1:\n    unit: rad/Nm\n    value: x": "line 4: .*expected a number, found 'x'",
    "compliance:\n  A1:\n    unit: rad/Nm\n    value: .nan": "line 4: .*a finite number, found nan",
    "compliance:\n  A1:\n    unit: rad/Nm\n    value: true": "expected a number, found true",
    "compliance:\n  A1:\n    unit: rad/Nm\n    value: -1.0e-7": "line 4: .*not be negative",
    "compliance:\n  A1: {value: 1, unit: rad/Nm, standard_error: -1}": "must not be negative",
    "compliance:\n  A1: {value: 1, unit: rad/Nm, error: 1}": "line 2: unknown key 'error'",
    "stiffness:\n  A1: {value: 0, unit: N.m/rad}": "line 2: .*expected a positive number",
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\nstiffness:\n  A1: {value: 1, unit: Nm/rad}": (
        "line 4: spring 'A1' has a compliance and a stiffness"
    ),
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\n  A1: {value: 1, unit: rad/Nm}": "appears twice",
    '{"compliance": {"A1": {"value": 1, "value": 2}}}': "key 'value' appears twice",
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\ndof: 0": "line 3: dof: expected a positive",
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\ncovariance: 3": "line 3: .*found 3",
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\ncovariance: {order: [A2], matrix: [[1]]}": (
        "order must name every spring once: A1"
    ),
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\ncovariance: {order: [A1], matrix: [[1, 2]]}": (
        "matrix must be 1 rows of 1 numbers"
    ),
    "compliance:\n  A1: {value: 1, unit: rad/Nm}\ncovariance: {order: [A1], matrix: [[-1]]}": (
        "negative eigenvalue"
    ),
    "compliance:\n  A1: {value: 1, unit: rad/Nm, standard_error: 2}\n"
    "covariance: {order: [A1], matrix: [[1]]}": "contradicts the standard errors",
    "springs: {A1: {carried_by: base, axis: [1, 0, 0]}}": "spring 'A1' has the name of a joint",
    "springs: {b: {axis: [1, 0, 0]}}": "key 'carried_by' is missing in springs.b",
    "springs:\n  b:\n    axis: [1, 0, 0]\n    carried_by: B": "line 4: .*no joint 'B'",
    "springs:\n  b:\n    axis: [0, 0, 0]\n    carried_by: A1": "line 3: axis of 'b': must not be",
    "springs:\n  b:\n    axis: [0, 0]\n    carried_by: A1": r"line 3: .*\[x, y, z\], found 2",
    "springs:\n  b:\n    carried_by: A1": "line 2: key 'axis' is missing in springs.b",
    "springs:\n  b: {carried_by: A1, type: bent, axis: [1, 0, 0]}": "line 2: .*found 'bent'",
    "springs:\n  b: {carried_by: A1, axis: [1, 0, 0]}\n"
    "compliance: {A1: {value: 1, unit: rad/Nm}}": ("line 2: spring 'b' has no compliance"),
    "stiffness:\n  A1: {value: 1.0e-200, unit: Nm/rad, standard_error: 1}": "line 2: .*beyond 1e30",
    f"kind: 0x{'f' * 4000}": "this is a 0xf+ file, expected a model",
    "compliance: {A1: {value: 1, unit: rad/Nm}, A2: {value: 1, unit: rad/Nm}}\n"
    "covariance: {order: [A1, A2], matrix: [[0, 1.0e+20], [1.0e+20, 0]]}": "negative eigenvalue",
    "compliance: {A1: &a {value: 1, unit: rad/Nm}, A2: *a}": "aliases are not supported",
}


@pytest.mark.parametrize("text", BAD, ids=[f"{i}" for i in range(len(BAD))])
def test_what_is_wrong_is_named(text: str, tmp_path: Path) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ModelFileError, match=BAD[text]) as caught:
        read_model(path, KR270)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_large_file_has_no_lines_and_a_message_no_more_than_fits(tmp_path: Path) -> None:
    entry = {"value": "x" * 1000, "unit": "rad/Nm"}
    text = json.dumps({"compliance": {"A1": entry}, "diagnostics": [0.123456789] * 100_000})
    with pytest.raises(ModelFileError, match=r"json: compliance\.A1\.value: ") as caught:
        read_model(written(tmp_path, text), KR270)
    assert len(str(caught.value)) < 400


def test_numbers_however_small_come_back(tmp_path: Path) -> None:
    """Products of sines of 180° in axes, tiny correlations in covariances."""
    rows = [[1e-18, 1e-40], [1e-40, 1e-18]]
    document = {
        "springs": {"b": {"carried_by": "base", "axis": [1.0, 0.0, 1.5e-32]}},
        "compliance": {name: {"value": 1e-6, "unit": "rad/Nm"} for name in ("A1", "b")},
        "covariance": {"order": ["b", "A1"], "matrix": rows},
    }
    model = read_model(written(tmp_path, json.dumps(document)), KR270)
    assert model.springs.axis[0].tolist() == [1.0, 0.0, 1.5e-32]
    assert model.covariance.tolist() == rows


def test_writing_starts_no_schema() -> None:
    schema = "elastocal.files.sections"
    code = f"import sys, elastocal; elastocal.write_model; print({schema!r} in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "False\n"


def test_a_missing_file_and_a_foreign_encoding(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_model(tmp_path / "none.json", KR270)
    path = tmp_path / "model.json"
    path.write_bytes(b"source: \xff")
    with pytest.raises(InputError, match="not UTF-8"):
        read_model(path, KR270)


@settings(max_examples=200)
@given(st.text(max_size=80) | st.sampled_from(sorted(BAD)).flatmap(st.permutations).map("".join))
def test_any_text_gives_a_model_or_a_clean_error(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with contextlib.suppress(InputError):
        read_model(path, KR270)


def test_the_truth_of_the_example_can_be_read() -> None:
    truth = read_model(Path(__file__).parents[3] / "examples/kr270/truth.json", KR270)
    assert truth.names == KR270.joint_names
    assert "demonstration" in truth.source
