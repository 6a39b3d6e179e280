"""The page of a calibration: everything is on it, and nothing that a user named is HTML."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.calibration.by_joint import joint_shares
from elastocal.calibration.calibrate import calibrate, values_of
from elastocal.calibration.calibrated_robot import put_away
from elastocal.calibration.nested import ladder
from elastocal.calibration.parameters import TOOL, parameters_of
from elastocal.calibration.validate import check
from elastocal.report import calibration_html
from elastocal.report.sections.calibration import CalibrationContents
from tests.calibration.test_calibrate import WHOLE, campaign, fitted, model_of, truth_of


@pytest.fixture(scope="module")
def contents() -> CalibrationContents:
    rng = np.random.default_rng(2)
    truth = truth_of(rng, WHOLE)
    positions = campaign(rng, WHOLE, truth)
    found = fitted(WHOLE, positions)
    steps = [("base and tool", model_of((), ())), ("the rest <b>", WHOLE)]
    models = [(name, model, parameters_of(model, positions)) for name, model in steps]
    kept = check(put_away(found), campaign(rng, WHOLE, truth, 10))
    return CalibrationContents("<i>arm", found, ladder(models, positions), kept)


def test_everything_is_on_the_page(contents: CalibrationContents) -> None:
    page = calibration_html(contents)
    for anchor in ("calibrated", "growth", "where", "by-joint", "unknowns", "apart"):
        assert f'id="{anchor}"' in page
    for words in ("that were not used", "proposed", "do the same", "zero A1", "Reflectors in the"):
        assert words in page
    assert "<i>arm" not in page
    assert "the rest <b>" not in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_reflectors_have_intervals_or_the_word(contents: CalibrationContents) -> None:
    page, found = calibration_html(contents), contents.found
    places = [u for u, block in enumerate(found.parameters.block) if block == TOOL]
    told = [bool(found.redundancy.seen[u]) for u in places]
    assert page.count(", not told by itself</td>") == told.count(False) > 0
    assert all(f"{1e3 * values_of(found)[u]:.3f}".lstrip("-") in page for u in places)


def test_what_joints_do_adds_up_where_one_is_off() -> None:
    """One zero that is off by a milliradian moves the tool by its lever."""
    rng = np.random.default_rng(3)
    truth = truth_of(rng, WHOLE)
    geometry = np.zeros(len(WHOLE.errors))
    geometry[WHOLE.errors.names.index("zero A3")] = 1e-3
    soft = replace(truth, geometry=geometry, compliance=np.zeros(2))
    positions = campaign(rng, WHOLE, soft)
    found = calibrate(WHOLE, positions, parameters_of(WHOLE, positions))
    shares = {share.name: share for share in joint_shares(found)}
    assert shares["A3"].geometry == pytest.approx(1e-3, rel=0.3)  # about 1 m away
    assert all(share.geometry < 0.2e-3 for name, share in shares.items() if name != "A3")
    assert all(share.sag < 0.05e-3 for share in shares.values())
