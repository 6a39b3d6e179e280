"""Covariances of a model file that were edited: refused by their key."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastocal.errors import ModelFileError
from elastocal.files.models.model_file import read_model
from elastocal.robot.sources import kuka_kr270

NAMES = ("A1", "A2", "A3", "A4")
SIZE = 1e-8 * np.array([1.0, 2.0, 3.0, 4.0])
K = 1e-6 * np.array([0.6, 0.3, 0.4, 3.0])
COVARIANCE = np.outer(SIZE, SIZE) * (0.5 * np.eye(4) + 0.5)


def document(**more: np.ndarray) -> dict[str, Any]:
    entries = {
        name: {"value": k, "unit": "rad/(N·m)", "standard_error": error}
        for name, k, error in zip(NAMES, K.tolist(), SIZE.tolist(), strict=True)
    }
    matrices = {"covariance": COVARIANCE, **more}
    sections = {
        key: {"order": list(NAMES), "matrix": matrix.tolist()} for key, matrix in matrices.items()
    }
    return {"compliance": entries, "dof": 5, **sections}


def read(tmp_path: Path, **more: np.ndarray) -> Any:
    (tmp_path / "model.json").write_text(json.dumps(document(**more)), "utf-8")
    return read_model(tmp_path / "model.json", kuka_kr270())


@pytest.mark.parametrize("key", ["covariance_by_noise", "covariance_at_task"])
def test_what_is_no_covariance_is_refused_by_its_key(key: str, tmp_path: Path) -> None:
    wrong = COVARIANCE * np.where(np.arange(16).reshape(4, 4) == 6, 2.0, 1.0)
    with pytest.raises(ModelFileError, match=f"{key}: the matrix is not symmetric"):
        read(tmp_path, **{key: wrong})
    with pytest.raises(ModelFileError, match=f"{key}: the matrix has a negative eigenvalue"):
        read(tmp_path, **{key: COVARIANCE - 1e-15 * np.eye(4)})
    with pytest.raises(ModelFileError, match=f"{key}: matrix must be 4 rows of 4 numbers"):
        read(tmp_path, **{key: COVARIANCE[:3]})


def test_a_part_is_no_larger_than_the_whole(tmp_path: Path) -> None:
    np.testing.assert_allclose(
        read(tmp_path, covariance_by_noise=0.5 * COVARIANCE).by_noise, 0.5 * COVARIANCE
    )
    with pytest.raises(ModelFileError, match="covariance_by_noise is a part of the covariance"):
        read(tmp_path, covariance_by_noise=1.1 * COVARIANCE)


def test_the_promise_for_a_task_is_that_of_some_gain_of_the_loads(tmp_path: Path) -> None:
    """Edited to be smaller, or larger, than any gain makes it, it is refused."""
    gain, together = 0.01, 1e-10 * np.array([1.0, -2.0, 0.5, 3.0])
    same = COVARIANCE + gain * (np.outer(K, together) + np.outer(together, K))
    same += gain**2 * np.outer(K, K)
    np.testing.assert_allclose(read(tmp_path, covariance_at_task=same).at_task, same)
    for wrong in (0.5 * COVARIANCE, np.zeros((4, 4)), np.diag(np.diagonal(COVARIANCE))):
        with pytest.raises(ModelFileError, match="covariance_at_task differs from the covariance"):
            read(tmp_path, covariance_at_task=wrong)
