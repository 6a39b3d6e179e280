"""Files side by side as one table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells
from elastocal.files.measurements.table import combined


def test_of_many_columns_in_two_files_the_first_by_name_is_named() -> None:
    """The same message in every run."""

    def cells(file: str, *own: str) -> Cells:
        keys = [*(f"n{i:02}" for i in range(20)), *own]
        numbers = {key: np.zeros(2) for key in keys}
        return Cells(Path(file), np.array([2, 3]), {k: f"{k} [mm]" for k in keys}, numbers, {})

    with pytest.raises(MeasurementFileError, match=r"^b\.csv: column 'n00 \[mm\]' is in a\.csv"):
        combined([cells("a.csv"), cells("b.csv", "x")])
