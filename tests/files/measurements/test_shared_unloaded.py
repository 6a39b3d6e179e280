"""An unloaded reading that is written down with several loads is one reading."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.study.study_file import read_study
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from tests.campaigns import FIRST_STEP

HEAD = "experiment,state,J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N],x [mm],y [mm],z [mm]\n"
FORCES = ((0, 0, -1000), (0, 300, -900), (300, 0, -900))


def campaign(path: Path, *, once: bool) -> Path:
    """Three configurations, three loads each; unloaded read `once` in each, or for every load."""
    rng = np.random.default_rng(0)
    lines = [HEAD]
    for c, q in enumerate(((0, 60, -45), (10, 30, -90), (-20, 80, -20))):
        idle = rng.normal(size=3)
        for f, force in enumerate(FORCES):
            idle = idle if once else rng.normal(size=3)
            for state, load in (("unloaded", (0, 0, 0)), ("loaded", force)):
                point = idle if state == "unloaded" else idle + rng.normal(size=3) - [0, 0, 5]
                numbers = ",".join(repr(float(v)) for v in (*q, *load, *point))
                lines.append(f"E{3 * c + f},{state},{numbers}\n")
    path.write_text("".join(lines), encoding="utf-8")
    return path


def test_it_is_one_for_all_loads_of_its_configuration(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(FIRST_STEP, encoding="utf-8")
    study = read_study(tmp_path / "study.yaml")
    shared = read_measurements(campaign(tmp_path / "once.csv", once=True), study)
    apart = read_measurements(campaign(tmp_path / "each.csv", once=False), study)
    assert [len(set(shared.unloaded[i : i + 3].tolist())) for i in (0, 3, 6)] == [1, 1, 1]
    assert len(set(shared.unloaded.tolist())) == 3
    assert len(set(apart.unloaded.tolist())) == 9
    assert not any("beam broken" in remark for remark in shared.remarks)
    found = identify(study.arm, shared, Fit("linear"))
    alone = identify(study.arm, apart, Fit("linear"))
    # Differences of loads know more, their mean less, than with readings of their own.
    assert (found.standard_error > alone.standard_error).any()


def test_a_loaded_row_that_comes_again_is_still_odd(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(FIRST_STEP, encoding="utf-8")
    study = read_study(tmp_path / "study.yaml")
    path = campaign(tmp_path / "once.csv", once=True)
    lines = path.read_text("utf-8").splitlines()
    lines[4] = ",".join([*lines[4].split(",")[:8], *lines[2].split(",")[8:]])
    path.write_text("\n".join(lines), encoding="utf-8")
    (remark,) = (r for r in read_measurements(path, study).remarks if "last digit" in r)
    assert remark.startswith("1 row repeat")
