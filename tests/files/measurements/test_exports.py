"""Exports of metrology programs go in by short mappings and give the right compliances."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.measurements.positions_file import read_positions
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from tests.files.absolute_campaign import study
from tests.files.exports import (
    INSPECTOR,
    MASS,
    PLANNED,
    TRUTH,
    WORKS,
    Exported,
    exported,
    inspector,
    plan,
    works,
)
from tests.files.measurements.test_positions import probe_file
from tests.test_examples import ROOT


def read(
    files: dict[str, str],
    mapping: str,
    folder: Path,
    found: Exported,
    encoding: str = "utf-8",
) -> Measurements:
    for name, text in files.items():
        (folder / name).write_bytes(text.encode(encoding))
    (folder / "mapping.yaml").write_text(mapping, "utf-8")
    paths = [folder / name for name in files]
    return read_measurements(paths, found.study, folder / "mapping.yaml")


@pytest.fixture(scope="module")
def campaign() -> Exported:
    return exported(noise=1e-5)


@pytest.mark.parametrize(
    ("write", "mapping", "encoding"),
    [(inspector, INSPECTOR, "utf-8"), (works, WORKS, "cp1252")],
    ids=["inspector", "works"],
)
def test_an_export_by_ten_lines(
    write: Callable[[Exported], dict[str, str]],
    mapping: str,
    encoding: str,
    tmp_path: Path,
    campaign: Exported,
) -> None:
    assert len(mapping.splitlines()) <= 12
    data = read(write(campaign), mapping, tmp_path, campaign, encoding)
    assert (len(data), len(data.cases)) == (36, 12)
    np.testing.assert_allclose(data.cases.q, campaign.q, atol=1e-6)
    np.testing.assert_allclose(data.cases.wrench[:, 2], -MASS * 9.80665, rtol=1e-5)
    errors = data.deflection - campaign.deflection.reshape(-1, 3)
    assert np.sqrt(np.mean(errors**2)) < 2.0 * 1e-5
    fit = identify(campaign.study.arm, data)
    np.testing.assert_allclose(fit.model.compliance, TRUTH, rtol=0.05)


def test_joints_and_loads_of_the_plan(tmp_path: Path, campaign: Exported) -> None:
    points = {"points.txt": inspector(campaign)["points.txt"]}
    (tmp_path / "plan.csv").write_text(plan(campaign))
    by_key = read(points, f"{PLANNED}plan: plan.csv\n", tmp_path, campaign)
    np.testing.assert_allclose(by_key.cases.q, campaign.q, atol=1e-7)
    np.testing.assert_array_equal(by_key.cases.wrench, [[0, 0, -1500, 0, 0, 0]] * 12)
    errors = by_key.deflection - campaign.deflection.reshape(-1, 3)
    assert np.sqrt(np.mean(errors**2)) < 2.0 * 1e-5
    (tmp_path / "mapping.yaml").write_text(PLANNED)
    files = tmp_path / "points.txt", campaign.study, tmp_path / "mapping.yaml"
    named = read_measurements(*files, tmp_path / "plan.csv")
    np.testing.assert_array_equal(named.deflection, by_key.deflection)
    assert named.source.endswith("plan.csv")
    before = named.sha256
    (tmp_path / "plan.csv").write_text(plan(campaign).replace("-1500", "-1400"))
    assert read_measurements(*files, tmp_path / "plan.csv").sha256 != before


def test_a_plan_counts_repeats_and_leaves_joints_alone(tmp_path: Path, campaign: Exported) -> None:
    points = {"points.txt": inspector(campaign)["points.txt"]}
    lines = plan(campaign).splitlines()
    del lines[4]
    lines[3] = f"{lines[3][:-1]}2"  # the third configuration, twice
    (tmp_path / "plan.csv").write_text("\n".join(lines) + "\n")
    data = read(points, f"{PLANNED}plan: plan.csv\n", tmp_path, campaign)
    np.testing.assert_allclose(data.cases.q[3], campaign.q[2], atol=1e-7)
    np.testing.assert_allclose(data.cases.q[4], campaign.q[4], atol=1e-7)
    text = f"{PLANNED}plan: plan.csv\n"
    for old, new, expected in (
        ("Pose(?P", "(?P<series>Pose)(?P", None),
        ("plan.csv", "absent.csv", "absent.csv: no such file"),
        ("(?P<experiment>", "(?P<series>", "no column or pattern gives 'experiment'"),
        ("marker: 3", 'marker: 3, "A1 [deg]": 5', "the joints are those of the plan, but"),
        ("plan.csv", "points.txt", "points.txt"),
    ):
        mapping = text.replace(old, new, 1)
        if expected is None:
            assert len(read(points, mapping, tmp_path, campaign)) == 36
            continue
        with pytest.raises(MeasurementFileError, match=re.escape(expected)):
            read(points, mapping, tmp_path, campaign)
    (tmp_path / "plan.csv").write_text("\n".join(lines[:-2]) + "\n")
    wrong = "line 63, column '2': expected the number of an experiment of plan.csv, 1 to 10"
    with pytest.raises(MeasurementFileError, match=wrong):
        read(points, text, tmp_path, campaign)


def test_joints_of_one_pose_too_few(tmp_path: Path, campaign: Exported) -> None:
    files = inspector(campaign)
    files["joints.csv"] = "".join(files["joints.csv"].splitlines(keepends=True)[:-1])
    with pytest.raises(
        Exception, match=r"points.txt, line 69, column '2': there is no experiment '12'"
    ):
        read(files, INSPECTOR, tmp_path, campaign)


def test_the_examples_of_the_documents(tmp_path: Path, campaign: Exported) -> None:
    """Copied as they stand."""
    section = (
        (ROOT / "docs" / "file-formats.md").read_text("utf-8").split("\n## Mapping files\n")[1]
    )
    examples = [part.split("```")[0] for part in section.split("```yaml\n")[1:]]
    data = read(inspector(campaign), examples[1], tmp_path, campaign)
    assert (len(data), len(data.cases)) == (36, 12)
    head, *lines = probe_file().splitlines()
    for theirs, ours in (("meas_", "tracker_"), *((f"j{i}", f"joint_{i}") for i in range(1, 7))):
        head = head.replace(theirs, ours)
    (tmp_path / "probe.csv").write_text("\n".join([head, *lines]) + "\n")
    (tmp_path / "use.csv").write_text("file line,use\n2,fit\n3,check\n5,fit\n")
    (tmp_path / "mapping.yaml").write_text(examples[2])
    paths = [tmp_path / "probe.csv", tmp_path / "use.csv"]
    found = read_positions(paths, study(probe=True, markers=1), tmp_path / "mapping.yaml")
    assert (found.names, len(found)) == (("1", "2"), 4)
