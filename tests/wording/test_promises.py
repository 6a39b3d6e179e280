"""What is said of a promise."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from elastocal.wording.promises import promise_sentences


def promised(**changed: Any) -> Any:
    lengths = {"rho0": 2e-4, "limit": 3e-4, "without": 5e-6, "uncompensated": 4e-4}
    floors = {"friction": 0.0, "discrepancy": 0.0, "repeatability": 0.0}
    return SimpleNamespace(**(lengths | floors | {"before": False} | changed))


def test_springs_are_named_where_there_are_any() -> None:
    springs = "counts the springs of the nuisance without these errors"
    assert springs in promise_sentences(1e-4, promised(), made_for_it=True)[0]
    loads = " ".join(promise_sentences(1e-4, promised(uncompensated=0.0), made_for_it=True))
    assert "springs" not in loads
    assert "ρ0 is without these errors" in loads
