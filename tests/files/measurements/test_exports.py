"""Exports of metrology programs go in by short mappings and give the right compliances."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.measurements.positions_file import read_positions
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from tests.files.absolute_campaign import study
from tests.files.exports import (
    INSPECTOR,
    MASS,
    TRUTH,
    WORKS,
    Exported,
    exported,
    inspector,
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
