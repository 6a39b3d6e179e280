"""What moves readings besides, as a study file says it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.typical import ERRORS
from elastocal.errors import StudyError
from elastocal.files.models.writing import write_model
from elastocal.files.study.study_file import named_files, parse_study
from elastocal.robot.sources import USUAL
from tests.files.campaign import STUDY_TEXT, study

LINE = STUDY_TEXT.count("\n") + 1
DH = STUDY_TEXT.replace(
    "robot: kuka-kr270\n",
    "robot: {name: arm, convention: modified, dh: [{joint: A1}, {joint: A2, alpha_deg: 90}, "
    "{joint: A3, a_mm: 900}, {joint: A4, alpha_deg: 90, d_mm: 900}, {joint: A5, alpha_deg: -90}, "
    "{joint: A6, alpha_deg: 90}]}\n",
)


def told(section: str, text: str = STUDY_TEXT) -> Nuisance:
    found = study(f"{text}nuisance: {section}\n").nuisance
    assert found is not None
    return found


def sizes(nuisance: Nuisance) -> dict[str, float]:
    return dict(zip(nuisance.names, nuisance.deviation.tolist(), strict=True))


@pytest.mark.parametrize(
    "section", ["none", "{}", "{preset: none, friction: 0}", "{tilt_nrad_per_Nm: {A3: 0}}"]
)
def test_none_is_a_study_as_it_always_was(section: str) -> None:
    plain, same = study(), study(f"{STUDY_TEXT}nuisance: {section}\n")
    assert same.nuisance is None
    np.testing.assert_array_equal(same.prior, plain.prior)
    assert same.fitted.plain


def test_the_preset_alone() -> None:
    found = told("typical")
    assert len(found.names) == 16
    assert found.errors == ERRORS
    np.testing.assert_array_equal(found.nominal, USUAL["kuka-kr270"])
    assert "joints of the usual order" in found.source[0]
    assert sizes(found)["tilt A4"] == pytest.approx(300.2e-9)


def test_what_is_said_stands_above_the_preset() -> None:
    found = told(
        "{preset: typical, tilt_nrad_per_Nm: {A3: 250, A4: 0}, tool_sliding_um_per_N: .05, "
        "foot_turning_nrad_per_Nm: 30, load: {relative: .01, common_tilt_deg: .2, "
        "process_force: other-cell}, discrepancy: {share: .05, mm: .01}, friction: 0, "
        "repeatability_mm: .014}"
    )
    size = sizes(found)
    assert size["tilt A3 x"] == pytest.approx(250e-9)
    assert size["tilt A3 xy"] == pytest.approx(250e-9 / np.sqrt(2.0))
    assert size["tool sliding z"] == pytest.approx(5e-8)
    assert size["foot sliding x"] == pytest.approx(30e-9 * 0.36)
    assert "tilt A4" not in size
    assert found.source[found.names.index("tilt A3 x")] == "given in the study"
    expected = CaseErrors(
        friction=0.0,
        discrepancy=0.05,
        discrepancy_length=1e-5,
        gain=0.01,
        tilt=ERRORS.tilt,
        repeatability=1.4e-5,
        common_gain=ERRORS.common_gain,
        common_tilt=float(np.radians(0.2)),
        process_force="other",
    )
    assert found.errors.process_force == expected.process_force
    given, wanted = (
        {k: v for k, v in vars(e).items() if v != "other"} for e in (found.errors, expected)
    )
    assert given == pytest.approx(wanted)


def test_a_section_without_preset_has_what_it_says() -> None:
    found = told("{foot_sliding_nm_per_N: 20, discrepancy: .03}")
    assert sizes(found) == pytest.approx({f"foot sliding {axis}": 2e-8 for axis in "xyz"})
    assert found.errors == CaseErrors(discrepancy=0.03)


def test_sizes_scale_with_what_is_known_of_the_joints(tmp_path: Path) -> None:
    """The study, then models, then rated torques; where nothing says anything, it is refused."""
    rated = "rated_torque_Nm: {A1: 4000, A2: 4000, A3: 2000, A4: 500, A5: 500, A6: 400}"
    found = told(f"{{preset: typical, {rated}}}", DH)
    np.testing.assert_allclose(found.nominal[:3], [2.5e-7, 2.5e-7, 5e-7])
    assert "rated torques" in found.source[0]
    found = told(f"{{preset: typical, {rated}, compliance_urad_per_Nm: {{A2: .3}}}}", DH)
    assert found.nominal[1] == pytest.approx(3e-7)
    assert "joints as given in the study, rated torques" in found.source[0]
    robot = study(DH).robot
    springs = ec.joint_springs(robot)
    model = ec.ComplianceModel(springs, np.arange(1, 7) * 1e-6, 1e-16 * np.eye(6))
    write_model(model, tmp_path / "before.json", robot)
    text = DH + "prior: {model: before.json}\nnuisance: typical\n"
    after = parse_study(text, tmp_path / "study.yaml")
    assert after.nuisance is not None
    np.testing.assert_allclose(after.nuisance.nominal, np.arange(1, 7) * 1e-6)
    np.testing.assert_allclose(np.diagonal(after.prior)[:5], 1e16, rtol=1e-9)
    assert after.prior_file[0] == "before.json"
    assert tmp_path / "before.json" in named_files(text, tmp_path / "study.yaml")


def test_masses_say_how_soft_joints_are() -> None:
    heavy = DH.replace("{joint: A2,", "{joint: A2, mass_kg: 1000,")
    found = told("typical", heavy)
    np.testing.assert_allclose(found.nominal, 3e-7 * np.array([1, 1, 1, 8, 8, 8]))
    assert "the mass of the robot" in found.source[0]


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("usual", "none.*typical.*usual"),
        ("{preset: heavy}", "preset.*none.*typical"),
        ("{tilt_nrad_per_Nm: {A9: 3}}", "no joint 'A9'"),
        ("{compliance_urad_per_Nm: {B1: 3}}", "no joint 'B1'"),
        ("{rated_torque_Nm: {A1: -1}}", "positive number"),
        ("{foot_turning_nrad_per_Nm: -3}", "0 or a positive number"),
        ("{tilt: {A3: 3}}", "tilt"),
        ("{load: {relative: 1 %}}", "expected a number"),
        ("{load: {process_force: mine}}", "same-cell"),
        ("{discrepancy: {share: -.1}}", "a share from 0 to 1"),
        ("{friction: 8}", "a share from 0 to 1, found 8"),
        ("{discrepancy: 8}", "a share from 0 to 1, found 8"),
        ("{load: {relative: 5}}", "a share from 0 to 1, found 5"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(section: str, words: str) -> None:
    with pytest.raises(StudyError, match=rf"study.yaml, line {LINE}.*{words}"):
        told(section)


def test_nothing_to_scale_with_is_refused() -> None:
    with pytest.raises(StudyError, match=r"nothing says those of A1.*compliance_urad_per_Nm"):
        told("typical", DH)
    with pytest.raises(StudyError, match=r"nothing says"):
        told("{friction: .1}", DH)


def test_a_prior_model_without_doubt_or_of_others_is_refused(tmp_path: Path) -> None:
    robot = study().robot
    springs = ec.joint_springs(robot, ["A1"])
    write_model(ec.ComplianceModel(springs, np.ones(1) * 1e-6), tmp_path / "a1.json", robot)
    springs = ec.joint_springs(robot, ["A2"])
    write_model(ec.ComplianceModel(springs, np.ones(1) * 1e-6), tmp_path / "a2.json", robot)
    for name, words in (("a1", "none of what is identified"), ("a2", "no standard error of A2")):
        with pytest.raises(StudyError, match=words):
            parse_study(f"{STUDY_TEXT}prior: {{model: {name}.json}}\n", tmp_path / "study.yaml")


def test_what_is_identified_is_no_nuisance() -> None:
    """A foot that is identified about both axes; tilts of a joint about all three of a tensor."""
    springs = """springs:
  fx: {carried_by: base, axis: [1, 0, 0]}
  fy: {carried_by: base, axis: [0, 1, 0]}
  a5: {carried_by: A5, axis: [1, 0, 0]}
"""
    text = STUDY_TEXT.replace("A5, A6]", "A5, A6, fx, fy, a5]") + springs
    names = told("typical", text).names
    assert not any("foot turning" in name for name in names)
    assert "tilt A5" in names
    assert "foot sliding x" in names


def test_what_is_positive_may_be_expected_above_zero() -> None:
    """The same root mean square, with the moments of a positive number."""
    zero = told("typical")
    positive = told("{preset: typical, mean: positive}")
    size = np.hypot(positive.mean, positive.deviation)
    np.testing.assert_allclose(size, zero.deviation, rtol=1e-12)
    share = positive.mean[~zero.signed] / size[~zero.signed]
    np.testing.assert_allclose(share, np.sqrt(2.0 / np.pi), rtol=1e-12)
    assert (positive.mean[zero.signed] == 0.0).all()
    assert zero.signed.any()


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("{tilt_nrad_per_Nm: {A3: 1e-12}}", "expected 0, or at least 1e-05"),
        ("{tool_sliding_um_per_N: 1e-12}", "expected 0, or at least 1e-08"),
        ("{load: {tilt_deg: 400}}", "at most 45"),
    ],
)
def test_sizes_that_cannot_be_meant_are_refused(section: str, words: str) -> None:
    with pytest.raises(StudyError, match=words):
        study(f"{STUDY_TEXT}nuisance: {section}\n")
