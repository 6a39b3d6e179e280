"""Bad studies: each gets one sentence that names the place, the right exit code, and no files."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from elastocal.cli import app

GOOD = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration: {load_point_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460]}}
test_poses:
  - {tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments:
  tool: calibration
  force_N: [0, 0, -2500]
  count: 12
instrument: {sigma_mm: 0.03}
constraints:
  workspace: {min_z_mm: 800, min_radius_mm: 600}
  elevation: {axis: z, max_deg: 30}
  collision: off
  floor: off
"""
POSE = "  - {tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}"
DH = "robot: {convention: modified, dh: [{joint: A1, type: prismatic, limits_deg: [0, 9]}]}"
TRACKER = "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500}}"
REST = GOOD[GOOD.index("load_point_mm") :]
REFLECTOR = "%s, " + REST.replace("{sigma_mm: 0.03}", TRACKER)
KEEP_PLAN = "max_configurations: 3\n  count: 12"

# what is edited: (old, new); what must be in the sentence; exit code
CASES: dict[str, tuple[str, str, list[str], int]] = {
    "unknown key": ("instrument:", "colour: red\ninstrument:", ["line 13", "'colour'"], 2),
    "alias of a word": (
        "identify: [A2,", "name: &a A3\nidentify: [*a,", ["line 4", "aliases"], 2),
    "misspelt key": ("identify:", "identfy:", ["line 3", "did you mean 'identify'"], 2),
    "misspelt inner key": ("count: 12", "cuont: 12", ["line 12", "did you mean 'count'"], 2),
    "key without unit": ("sigma_mm", "sigma", ["line 13", "no unit", "'sigma_mm'"], 2),
    "tool without unit": ("tcp_mm", "tcp", ["line 5", "no unit", "'tcp_mm'"], 2),
    "unit not accepted": ("min_z_mm: 800", "min_z_m: 0.8", ["line 15", "'min_z_mm'"], 2),
    "force without unit": ("  force_N: [0, 0, -2500]", "  force: [0, 0, -2500]", ["'force_N'"], 2),
    "unit in the value": ("sigma_mm: 0.03", "sigma_mm: 0.03 mm", ["bare number", "line 13"], 2),
    "decimal comma": ("sigma_mm: 0.03", "sigma_mm: '0,03'", ["decimal point"], 2),
    "missing section": ("instrument: {sigma_mm: 0.03}\n", "", ["'instrument' is missing"], 2),
    "missing count": ("  count: 12\n", "", ["'count' is missing", "experiments"], 2),
    "missing version": ("elastocal: 1\n", "", ["'elastocal' is missing"], 2),
    "other version": ("elastocal: 1", "elastocal: 7", ["line 1", "version 7"], 2),
    "unknown robot": ("kuka-kr270", "kuka-kr999", ["line 2", "kuka-kr270, three-link"], 2),
    "unknown joint": ("[A2, A3, A4, A5, A6]", "[A2, A9]", ["line 3", "'A9'", "A1, A2"], 2),
    "joint twice": ("[A2, A3, A4, A5, A6]", "[A2, A2]", ["line 3", "'A2' twice"], 2),
    "no joints": ("[A2, A3, A4, A5, A6]", "[]", ["line 3", "no joints"], 2),
    "too few angles": ("45.1, 76, 57.2]", "45.1, 76]", ["line 8", "6 angles", "found 5"], 2),
    "wrong joint name": (
        "q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]", "q_deg: {J1: 0}", ["'J1'", "A1, A2"], 2),
    "joint value missing": (
        "q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]", "q_deg: {A1: 0}", ["'A2' has no value"], 2),
    "NaN": ("-56.9", ".nan", ["line 8", "finite"], 2),
    "infinity": ("sigma_mm: 0.03", "sigma_mm: .inf", ["line 13", "finite"], 2),
    "text for a number": ("count: 12", "count: a dozen", ["line 12", "whole number"], 2),
    "fraction of experiments": ("count: 12", "count: 2.5", ["line 12", "whole number"], 2),
    "no experiments": ("count: 12", "count: 0", ["line 12", "from 1"], 2),
    "negative sigma": ("sigma_mm: 0.03", "sigma_mm: -0.03", ["positive", "-0.03"], 2),
    "sigma of no size": (
        "sigma_mm: 0.03", "sigma_mm: 1.0e-20", ["line 13", "from 1e-09 to 10000, found 1e-20"], 2),
    "sigma beyond the cell": ("sigma_mm: 0.03", "sigma_mm: 30000", ["found 30000"], 2),
    "zero sigma": ("sigma_mm: 0.03", "sigma_mm: 0", ["positive"], 2),
    "speed without unit": (
        "instrument:", "motion: {max_speed: 10}\ninstrument:", ["line 13", "'max_speed_deg_s'"], 2),
    "speed of no joint": (
        "instrument:", "motion: {max_speed_deg_s: {A9: 5}}\ninstrument:", ["line 13", "'A9'"], 2),
    "speed in the other unit": (
        "instrument:", "motion: {max_speed_mm_s: {A1: 5}}\ninstrument:",
        ["line 13", "'A1' belongs under max_speed_deg_s"], 2),
    "one speed is no number": (
        "instrument:", "motion: {max_speed_deg_s: {A1: fast}}\ninstrument:",
        ["line 13: motion.max_speed_deg_s.A1: expected a number, found 'fast'"], 2),
    "one angle is no number": (
        "q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]", "q_deg: {A1: zero}",
        ["line 8: test_poses.q_deg.A1: expected a number, found 'zero'"], 2),
    "speed zero": ("instrument:", "motion: {max_speed_deg_s: 0}\ninstrument:", ["positive"], 2),
    "home out of limits": (
        "instrument:", "motion: {home_deg: [0, 9, 0, 0, 0, 0]}\ninstrument:",
        ["line 13", "home has A2 at 9°", "-140 to 0"], 2),
    "home of five angles": (
        "instrument:", "motion: {home_deg: [0, 0, 0, 0, 0]}\ninstrument:",
        ["line 13", "home_deg needs 6 angles", "found 5"], 2),
    "settling in minutes": (
        "instrument:", "campaign: {settle_min: 1}\ninstrument:",
        ["line 13", "unit is not accepted", "'settle_s'"], 2),
    "negative time": (
        "instrument:", "campaign: {measure_min: -1}\ninstrument:",
        ["line 13", "measure_min must not be negative"], 2),
    "tracker and sigma": (
        "{sigma_mm: 0.03}", "{sigma_mm: 0.03, tracker: {position_mm: [3000, 0, 0], preset: x}}",
        ["line 13", "exactly one"], 2),
    "pose without its noise": (
        "{sigma_mm: 0.03}", "{measures: pose, sigma_mm: 0.03}",
        ["line 13", "needs sigma_mrad", "0.175 mrad"], 2),
    "noise of a rotation nobody measures": (
        "{sigma_mm: 0.03}", "{sigma_mm: 0.03, sigma_mrad: 0.05}",
        ["line 13", "positions alone are measured", "measures: pose"], 2),
    "measures something": (
        "{sigma_mm: 0.03}", "{measures: angles, sigma_mm: 0.03}",
        ["line 13", "'position' or 'pose'", "'angles'"], 2),
    "pose without positions": (
        "{sigma_mm: 0.03}", "{measures: pose, sigma_mrad: 0.05}", ["line 13", "exactly one"], 2),
    "rotation in degrees": (
        "{sigma_mm: 0.03}", "{measures: pose, sigma_mm: 0.03, sigma_deg: 0.01}",
        ["line 13", "not accepted", "'sigma_mrad'"], 2),
    "no noise of rotation": (
        "{sigma_mm: 0.03}", "{measures: pose, sigma_mm: 0.03, sigma_mrad: 0}",
        ["line 13", "sigma_mrad", "positive"], 2),
    "no such preset": (
        "{sigma_mm: 0.03}", "{tracker: {position_mm: [3000, 0, 0], preset: leica}}",
        ["line 13", "no preset 'leica'", "leica-at500"], 2),
    "preset and numbers": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 0], preset: leica-at500, along_um: 5}}",
        ["line 13", "either preset or along_um"], 2),
    "tracker without noise": (
        "{sigma_mm: 0.03}", "{tracker: {position_mm: [3000, 0, 0], along_um: 5}}",
        ["line 13", "'across_um' is missing", "preset"], 2),
    "tracker nowhere": (
        "{sigma_mm: 0.03}", "{tracker: {preset: leica-at500}}",
        ["line 13", "'position_mm' is missing"], 2),
    "range turned round": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, range_mm: [5000, 1000]}}",
        ["line 13", "range_mm", "must be below"], 2),
    "range below zero": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, range_mm: [-1, 1000]}}",
        ["line 13", "range_mm must not be negative"], 2),
    "range of one number": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, range_mm: 1000}}",
        ["line 13", "two numbers"], 2),
    "head looks over the zenith": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, elevation_deg: [-45, 120]}}",
        ["line 13", "must be from -90 to 90"], 2),
    "head turns twice": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, azimuth_deg: [-300, 300]}}",
        ["line 13", "more than a whole turn"], 2),
    "beam without radius": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, beam_radius_mm: 0}}",
        ["line 13", "positive"], 2),
    "beam without unit": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, beam_radius: 10}}",
        ["line 13", "no unit", "'beam_radius_mm'"], 2),
    "any marker will do": (
        "{sigma_mm: 0.03}",
        "{tracker: {position_mm: [3000, 0, 900], preset: leica-at500, view: any}}",
        ["line 13", "unknown key 'view'"], 2),
    "axis of no marker": (
        REST, REFLECTOR % "marker_axes: {M9: x}",
        ["line 6", "no marker 'M9'", "M1"], 2),
    "axis of zero length": (
        REST, REFLECTOR % "marker_axes: {M1: [0, 0, 0]}",
        ["line 6", "'M1' must not be zero"], 2),
    "cone without axis": (
        REST, REFLECTOR % "acceptance_deg: 30",
        ["line 6", "needs marker_axes"], 2),
    "cone beyond a half-space": (
        REST, REFLECTOR % "marker_axes: {M1: x}, acceptance_deg: 200",
        ["line 6", "from 1 to 180"], 2),
    "axis without tracker": (
        "load_point_mm", "marker_axes: {M1: x}, load_point_mm",
        ["line 6", "marker_axes needs a tracker"], 2),
    "zero load": ("[0, 0, -2500]", "[0, 0, 0]", ["nothing deflects", "line 9"], 2),
    "no load": ("  force_N: [0, 0, -2500]\n", "", ["nothing of the load"], 2),
    "two loads": ("  count: 12", "  max_force_N: 5\n  count: 12", ["line 12", "either"], 2),
    "bound without direction": (
        "  force_N: [0, 0, -2500]", "  max_force_N: 2500", ["needs direction"], 2),
    "zero normal of a plane": (
        "  force_N: [0, 0, -2500]", "  max_force_N: 2500\n  direction: {plane: [0, 0, 0]}",
        ["line 12", "normal", "zero"], 2),
    "plane and cone": (
        "  force_N: [0, 0, -2500]",
        "  max_force_N: 2500\n  direction: {plane: [1, 0, 0], half_angle_deg: 30}",
        ["line 12", "unknown key 'half_angle_deg'", "plane"], 2),
    "plane misspelt": (
        "  force_N: [0, 0, -2500]", "  max_force_N: 2500\n  direction: {plan: [1, 0, 0]}",
        ["line 12", "unknown key 'plan'; did you mean 'plane'?"], 2),
    "zero cone axis": (
        "  force_N: [0, 0, -2500]",
        "  max_force_N: 2500\n  direction: {axis: [0, 0, 0], half_angle_deg: 30}",
        ["axis", "zero"], 2),
    "zero test force": ("[0, 280, -180]", "[0, 0, 0]", ["line 8", "zero"], 2),
    "test pose out of limits": ("-56.9", "56.9", ["line 8", "A2", "-140 to 0"], 2),
    "no test pose": (POSE, "  []", ["test_poses is empty"], 2),
    "unknown tool": ("  tool: calibration", "  tool: gripper", ["line 10", "'gripper'"], 2),
    "tool without points": ("{tcp_mm: [986, 0, 0]}", "{}", ["line 5", "neither"], 2),
    "vector of two": ("[986, 0, 0]", "[986, 0]", ["line 5", "three numbers", "2 values"], 2),
    "limits turned round": (
        "constraints:", "constraints:\n  joint_limits_deg: {A3: [90, 10]}", ["'A3'", "below"], 2),
    "limits beyond the robot": (
        "constraints:", "constraints:\n  joint_limits_deg: {A3: [-200, 10]}",
        ["line 15", "beyond", "-119 to 155"], 2),
    "margin eats the range": (
        "constraints:", "constraints:\n  joint_margin_deg: 80", ["'A2'", "no room"], 2),
    "negative margin": (
        "constraints:", "constraints:\n  joint_margin_deg: -5", ["not be negative"], 2),
    "empty box": (
        "min_z_mm: 800", "box_mm: {min: [0, 0, 9], max: [1, 1, 1]}", ["min z 9"], 2),
    "elevation over 90": ("max_deg: 30", "max_deg: 130", ["at most 90"], 2),
    "bad axis name": ("axis: z", "axis: w", ["line 16", "'w'"], 2),
    "unknown criterion": ("robot:", "criterion: F\nrobot:", ["line 2", "test-pose, worst"], 2),
    "more configurations than experiments": (
        "count: 12", "max_configurations: 13\n  count: 12", ["13", "12 experiments"], 2),
    "tab": ("  tool: calibration", "\ttool: calibration", ["line 10", "not valid YAML"], 2),
    "broken YAML": ("[986, 0, 0]", "[986, 0, 0", ["not valid YAML", "line"], 2),
    "key twice": ("robot:", "robot: three-link\nrobot:", ["line 3", "'robot'", "twice"], 2),
    "alias": ("[986, 0, 0]", "&a [986, 0, 0], load_point_mm: *a", ["line 5", "alias"], 2),
    "list for a section": ("instrument: {sigma_mm: 0.03}", "instrument: [1]", ["line 13"], 2),
    "section for a number": ("count: 12", "count: {a: 1}", ["line 12", "whole number"], 2),
    "empty section": ("instrument: {sigma_mm: 0.03}", "instrument:", ["line 13", "nothing"], 2),
    "limits in the wrong unit": ("robot: kuka-kr270", DH, ["'A1' is prismatic", "limits_mm"], 2),
    "matrix of wrong size": (
        POSE, "  - {regressor_Nm2: [[1, 2], [3, 4]]}", ["line 8", "5 numbers"], 2),
    "matrix and pose": (
        POSE, "  - {regressor_Nm2: [[1, 2, 3, 4, 5]], tool: milling}", ["either"], 2),
    "zero matrix": (POSE, "  - {regressor_Nm2: [[0, 0, 0, 0, 0]]}", ["zero"], 2),
    "prior said twice": (
        "robot:", "prior: {plan: a.json, standard_error_rad_per_Nm: {A2: 1e-8}}\nrobot:",
        ["line 2", "exactly one"], 2),
    "prior of a stranger": (
        "robot:", "prior: {standard_error_rad_per_Nm: {A1: 1e-8}}\nrobot:", ["'A1'"], 2),
    "prior plan missing": ("robot:", "prior: {plan: a.json}\nrobot:", ["no such file"], 2),
    "impossible height": ("min_z_mm: 800", "min_z_mm: 9000", ["height of M1 >= 9000 mm"], 3),
    "impossible radius": ("min_radius_mm: 600", "min_radius_mm: 6000", ["radius of M1"], 3),
    "impossible pair": ("min_z_mm: 800", "min_z_mm: 800, max_z_mm: 700", ["height of M1"], 3),
    "vertical load and joint 1": ("[A2, A3, A4, A5, A6]", "[A1, A2, A3]", ["A1:", "identif"], 4),
    "marker on axis 6": (
        "{load_point_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460]}}",
        "{load_point_mm: [611.5, 0, 0]}", ["A6:"], 4),
    "too few experiments": ("count: 12", "count: 1", ["1 experiment ", "at least 2"], 4),
    "too few configurations": (
        "count: 12", "count: 12\n  max_configurations: 1", ["1 configuration ", "at least 2"], 4),
}  # fmt: skip


def run(*arguments: str | Path) -> tuple[int, str]:
    """Exit code and what was said on standard error."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stderr


@pytest.mark.parametrize("name", CASES)
def test_bad_study_gets_one_sentence_and_leaves_nothing(name: str, tmp_path: Path) -> None:
    old, new, expected, code = CASES[name]
    assert GOOD.count(old) >= 1, "the case edits nothing"
    study = tmp_path / "study.yaml"
    study.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    found, said = run("plan", study, "--out", tmp_path / "plan.json")
    assert found == code, said
    for words in expected:
        assert words in said, said
    assert said.startswith("error: ")
    assert said.count("\n") == 1, "more than one line"
    assert "Traceback" not in said
    assert [path.name for path in tmp_path.iterdir()] == ["study.yaml"]


def test_the_good_study_is_good(tmp_path: Path) -> None:
    """Negative control: what is edited above is accepted unedited."""
    study = tmp_path / "study.yaml"
    study.write_text(GOOD, encoding="utf-8")
    assert run("check", study) == (0, "")


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "empty"),
        (b"robot: \xb5m", "not UTF-8"),
        (b"\x00\x01", "line 1, column 1: character U+0000 is no text"),
        (b"just words", "expected keys"),
        (b"- 1\n- 2\n", "expected keys"),
        (b"[" * 3000, "nested too deeply"),
        (b"elastocal: !!python/object:os.system {}", "YAML tags"),
        (b"#" * 2_000_000, "bytes"),
        ("\ufeff".encode() + GOOD.replace("count: 12", "count: x").encode(), "line 12"),
        (GOOD.replace("\n", "\r\n").replace("count: 12", "count: x").encode(), "line 12"),
    ],
)
def test_bytes_that_are_no_study(content: bytes, expected: str, tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_bytes(content)
    code, said = run("plan", study, "--out", tmp_path / "plan.json")
    assert code == 2
    assert expected in said
    assert said.count("\n") == 1


def test_places_that_cannot_be_written_are_refused_before_the_work(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(GOOD, encoding="utf-8")
    code, said = run("plan", study, "--out", tmp_path / "missing" / "plan.json")
    assert (code, "does not exist" in said) == (2, True)
    code, said = run("plan", study, "--out", tmp_path)
    assert (code, "is a folder" in said) == (2, True)
    code, said = run("init", study)
    assert (code, "exists already" in said) == (2, True)
    assert study.read_text(encoding="utf-8") == GOOD


def test_missing_study() -> None:
    code, said = run("check", "nowhere.yaml")
    assert (code, said) == (2, "error: nowhere.yaml: no such file\n")
