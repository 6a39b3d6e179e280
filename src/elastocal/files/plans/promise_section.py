"""What a plan promises with nuisance, as a section of plan.json and of what `evaluate` says."""

from __future__ import annotations

from typing import Any

from elastocal.files.plans.load_case_entries import finite_at
from elastocal.planning.aim import is_for_promise
from elastocal.planning.promise import Promise
from elastocal.study.study import Study

_LENGTHS = ("rho0", "without", "uncompensated", "friction", "discrepancy", "repeatability")
_KEYS = {name: f"{name}_mm" for name in _LENGTHS} | {"limit": "limit_95_mm"}


def promise_section(study: Study, promise: Promise | None) -> dict[str, Any]:
    """The section `promise` by its key, millimetres; empty if the study knows no nuisance."""
    nuisance = study.nuisance
    if promise is None or nuisance is None:
        return {}
    springs = study.springs
    priors = zip(
        nuisance.names,
        nuisance.unknowns.kinds,
        nuisance.deviation.tolist(),
        nuisance.source,
        strict=True,
    )
    errors = zip(springs.names, springs.kinds, promise.standard_error.tolist(), strict=True)
    names = [pose.name for pose in study.test_poses]
    return {
        "promise": {
            **{key: 1e3 * getattr(promise, name) for name, key in _KEYS.items()},
            "rho0_each_mm": {
                name: 1e3 * rho for name, rho in zip(names, promise.rho0_each, strict=True)
            },
            "standard_error": {
                name: {"value": error, "unit": kind.compliance} for name, kind, error in errors
            },
            "optimised": "promise" if is_for_promise(study) else study.criterion,
            "nuisance": {
                name: {
                    "standard_uncertainty": size,
                    "unit": kind.compliance,
                    "source": source,
                }
                for name, kind, size, source in priors
            },
            "errors": dict(vars(nuisance.errors)),
        }
    }


def claimed_promise(section: Any, where: str) -> dict[str, float]:
    """Lengths that a plan claims of its promise [m]; what is infinite is left out."""
    if not isinstance(section, dict):
        return {}
    return {
        name: finite_at(section[key], f"{where}: {key}") / 1e3
        for name, key in _KEYS.items()
        if section.get(key) is not None
    }
