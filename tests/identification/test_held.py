"""Compliances held at zero by the bound: said, shown, and never divided by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.compliance_model import merged_models
from elastocal.errors import InputError
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.report.sections.state import _identified
from elastocal.terminal.identifications import show_identification
from tests.campaigns import NAMES, TRUTH, arm, hung, measured

BOUNDED = Fit(nonnegative=True)


def test_swapped_loaded_and_unloaded_leave_nothing_but_zeros() -> None:
    readings = measured(arm(), hung(12), rng=np.random.default_rng(0))
    found = identify(arm(), replace(readings, deflection=-readings.deflection), BOUNDED)
    assert found.held == NAMES
    assert doubts(found)[0].code == "all-held-at-zero"
    assert not {"held-at-zero", "all-negative"} & {doubt.code for doubt in doubts(found)}
    assert (found.relative_error == 0.0).all()
    assert _identified(found).value == "none"
    show_identification(found)


def test_a_held_compliance_is_not_the_least_certain_one() -> None:
    truth = np.where(np.array(NAMES) == "A6", -0.2e-6, TRUTH)
    found = identify(arm(), measured(arm(), hung(12), truth, rng=np.random.default_rng(0)), BOUNDED)
    assert found.held == ("A6",)
    assert [doubt.about for doubt in doubts(found) if doubt.code == "held-at-zero"] == [("A6",)]
    expected = found.standard_error[:4] / found.compliance[:4]
    np.testing.assert_allclose(found.relative_error, [*expected, 0.0])
    assert 0.0 < expected.max() < 0.1
    assert NAMES[int(np.argmax(expected))] in _identified(found).meaning


def test_no_models_are_not_merged() -> None:
    with pytest.raises(InputError, match="no model to merge"):
        merged_models([])
