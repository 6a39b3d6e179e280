"""Readings between two loads: the unloaded arm is never read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.cli.inputs import identified_cases
from elastocal.elastic.case_errors import CaseErrors, own_covariance
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError, MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.files.models.identification_file import write_identification
from elastocal.files.study.study_file import parse_study
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.validation import validate
from elastocal.measuring.measurements import Measurements, chosen
from elastocal.planning.as_measured import as_measured
from elastocal.planning.remaining import done
from elastocal.study.study import Study
from tests.campaigns import FREE_FORCES, NAMES, TRUTH, arm, hung

ALL = np.append(0.623e-6, TRUTH)
COUNT = 8


@pytest.fixture(scope="module")
def study() -> Study:
    return parse_study(FREE_FORCES, Path("study.yaml"))


def loads(seed: int) -> Array:
    """(N, 6) forces in any direction."""
    force = np.random.default_rng(seed).normal(size=(COUNT, 3))
    return np.hstack(
        [2000.0 * force / np.linalg.norm(force, axis=1)[:, None], np.zeros((COUNT, 3))]
    )


def written(study: Study, path: Path, first: str = "preloaded") -> tuple[LoadCases, Array]:
    """A file of positions under two loads, and where the arm was between them."""
    q, before, after = hung(COUNT).q, loads(1), loads(2)
    one, two = (loaded_deflection(study.arm, ALL, LoadCases(q, w)) for w in (before, after))
    rows = ["experiment,state," + ",".join(f"A{i} [deg]" for i in range(1, 7))
            + ",Fx [N],Fy [N],Fz [N],x [mm],y [mm],z [mm]"]  # fmt: skip
    for i in range(COUNT):
        for state, w, moved in ((first, before, one), ("loaded", after, two)):
            values = [*np.degrees(q[i]), *w[i, :3], *(1e3 * moved[i] + [1000.0, 200.0, 300.0])]
            rows.append(f"E{i},{state}," + ",".join(f"{v:.12g}" for v in values))
    path.write_text("\n".join(rows) + "\n")
    return LoadCases(q, after - before, before), two - one


def test_a_file_of_two_loads(study: Study, tmp_path: Path) -> None:
    cases, moved = written(study, tmp_path / "two.csv")
    data = read_measurements(tmp_path / "two.csv", study)
    np.testing.assert_allclose(data.cases.wrench, cases.wrench, atol=1e-8)
    np.testing.assert_allclose(data.cases.before, cases.before, atol=1e-8)
    np.testing.assert_allclose(data.deflection, moved, atol=1e-12)
    found = identify(study.arm, data)
    np.testing.assert_allclose(found.compliance, ALL, rtol=1e-6)
    # As if the first load were none, the equilibrium is another one.
    wrong = replace(data, cases=LoadCases(data.cases.q, data.cases.wrench))
    assert np.abs(identify(study.arm, wrong).compliance / ALL - 1.0).max() > 1e-3
    checked = validate(study.arm, found.model, data)
    assert np.abs(checked.after).max() < 1e-9
    linear = identify(study.arm, data, Fit("linear"))
    rows = regressor(study.arm, cases).reshape(-1, 6)
    k = np.linalg.lstsq(rows * 1e-6, moved.ravel(), rcond=None)[0] * 1e-6
    np.testing.assert_allclose(linear.compliance, k, rtol=1e-6)


def test_some_of_them_keep_their_first_load(study: Study, tmp_path: Path) -> None:
    cases, _ = written(study, tmp_path / "two.csv")
    data = read_measurements(tmp_path / "two.csv", study)
    keep = np.arange(COUNT) % 2 == 1
    np.testing.assert_allclose(chosen(data, keep).cases.before, cases.before[keep], atol=1e-8)
    twice = LoadCases(cases.q[[0, 0]], cases.wrench[[0, 0]], cases.before[[0, 1]])
    assert len(set(twice.distinct.tolist())) == 2
    with pytest.raises(InputError, match="between two loads are not written"):
        write_measurements(data, study.robot, tmp_path / "no.csv")


def test_a_load_on_unloaded_rows_is_refused_still(study: Study, tmp_path: Path) -> None:
    written(study, tmp_path / "two.csv", "unloaded")
    with pytest.raises(MeasurementFileError, match="an unloaded row has a force"):
        read_measurements(tmp_path / "two.csv", study)


def test_preloaded_and_unloaded_experiments_side_by_side(study: Study, tmp_path: Path) -> None:
    cases, _ = written(study, tmp_path / "two.csv")
    lines = (tmp_path / "two.csv").read_text().splitlines()
    cells = lines[1].split(",")
    cells[1], cells[8:11] = "unloaded", ["0", "0", "0"]
    (tmp_path / "both.csv").write_text("\n".join([lines[0], ",".join(cells), *lines[2:]]) + "\n")
    data = read_measurements(tmp_path / "both.csv", study)
    np.testing.assert_array_equal(data.cases.before[0], 0.0)
    np.testing.assert_allclose(data.cases.wrench[0], (cases.wrench + cases.before)[0], atol=1e-8)
    np.testing.assert_allclose(data.cases.before[1:], cases.before[1:], atol=1e-8)


def test_both_loads_err_by_themselves() -> None:
    cases = LoadCases(hung(COUNT).q, loads(2) - loads(1), loads(1))
    errors = CaseErrors(gain=0.02, tilt=0.01)
    parts = [
        own_covariance(errors, arm(NAMES), TRUTH, LoadCases(cases.q, w))
        for w in (loads(1), loads(2))
    ]
    np.testing.assert_allclose(own_covariance(errors, arm(NAMES), TRUTH, cases), sum(parts))


def test_a_first_load_for_every_case() -> None:
    with pytest.raises(InputError, match="as many wrenches before"):
        LoadCases(np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((1, 6)))


def test_fits_of_preloaded_arms_left_out(study: Study, tmp_path: Path) -> None:
    """Everything beside the estimate goes through the first load, too."""
    written(study, tmp_path / "two.csv")
    data: Measurements = read_measurements(tmp_path / "two.csv", study)
    whole = identify(study.arm, data)
    out = np.arange(COUNT) == 3
    others = identify(study.arm, chosen(data, ~out))
    shift = others.compliance - whole.compliance
    np.testing.assert_allclose(whole.influence.shift[3], shift, atol=1e-12)


def test_they_are_judged_and_known_later_with_their_first_load(
    study: Study, tmp_path: Path
) -> None:
    """As a plan, in the file of a model, and as what was done before a plan."""
    cases, _ = written(study, tmp_path / "two.csv")
    data = read_measurements(tmp_path / "two.csv", study)
    judged = as_measured(data, study.robot)
    np.testing.assert_allclose(judged.cases.before, cases.before, atol=1e-8)
    other = LoadCases(cases.q[[0, 0, 0]], cases.wrench[[0, 0, 0]], cases.before[[0, 1, 0]])
    apart = replace(
        data,
        cases=other,
        names=("a", "b", "c"),
        case=np.arange(3),
        **{key: getattr(data, key)[:3] for key in ("marker", "deflection", "covariance")},
        unloaded_of=np.arange(3),
    )
    assert as_measured(apart, study.robot).repeats.tolist() == [2, 1]
    before = done(study, apart)
    assert before.repeats.tolist() == [2, 1]
    np.testing.assert_allclose(before.cases.before, cases.before[:2], atol=1e-8)
    model = tmp_path / "model.json"
    write_identification(study, identify(study.arm, data), model)
    known = identified_cases(model, study.robot)
    assert known is not None
    order = np.lexsort(known.q.T)
    np.testing.assert_allclose(known.before[order], cases.before[np.lexsort(cases.q.T)], atol=1e-8)
