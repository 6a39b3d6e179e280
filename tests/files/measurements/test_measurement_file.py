"""Measurement files: what is written is read back; whatever the columns, units and encoding."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.names import flaw
from tests.files.campaign import measurements, study

WHAT = study()


@pytest.mark.parametrize("own", [0, 1, 3, 6])
def test_what_is_written_is_read_back(tmp_path: Path, own: int) -> None:
    made = measurements(20, np.random.default_rng(own), own=own)
    what = study()
    path = tmp_path / "m.csv"
    write_measurements(made, what.robot, path)
    back = read_measurements(path, what)
    assert back.names == made.names
    assert back.own_uncertainty == (own > 0)
    np.testing.assert_array_equal(back.case, made.case)
    np.testing.assert_array_equal(back.marker, made.marker)
    np.testing.assert_allclose(back.cases.q, made.cases.q, rtol=1e-11, atol=0.0)
    np.testing.assert_array_equal(back.cases.wrench, made.cases.wrench)
    np.testing.assert_allclose(back.deflection, made.deflection, rtol=1e-9, atol=0.0)
    np.testing.assert_allclose(back.covariance, made.covariance, rtol=1e-8, atol=1e-18)
    again = tmp_path / "again.csv"
    write_measurements(back, what.robot, again)
    assert again.read_text() == path.read_text()


NAMES = (
    st.text(
        st.characters(exclude_categories=["Cc", "Cf", "Cs", "Zl", "Zp", "Zs"]),
        min_size=1,
        max_size=12,
    )
    .filter(lambda name: not flaw(name))
    .filter(lambda name: not name.startswith("'"))
)


@given(
    names=st.lists(NAMES, min_size=1, max_size=6, unique=True),
    seed=st.integers(0, 2**32 - 1),
    own=st.sampled_from([0, 1, 3, 6]),
)
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_campaign_comes_back(tmp_path: Path, names: list[str], seed: int, own: int) -> None:
    """Whatever the experiments are called: commas, quotes, # and all."""
    made = replace(
        measurements(len(names), np.random.default_rng(seed), own=own), names=tuple(names)
    )
    path = tmp_path / "m.csv"
    write_measurements(made, WHAT.robot, path)
    back = read_measurements(path, WHAT)
    assert back.names == made.names
    np.testing.assert_allclose(back.deflection, made.deflection, rtol=1e-9, atol=0.0)
    np.testing.assert_allclose(back.covariance, made.covariance, rtol=1e-8, atol=1e-18)
