"""False promises: what a plan claims of its promise, and of the nuisance behind it, by the study.

In: a study, the promise of load cases, claims. Out: those that do not hold.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from elastocal.errors import Code, Doubt
from elastocal.planning.promise import Promise
from elastocal.study.study import Study

AGREE = 1e-4
"""Claims may differ by this share: a run sheet rounds its angles."""


def false_promise(study: Study, promise: Promise, claims: dict[str, Any]) -> Iterator[Doubt]:
    """Claims of a promise that do not hold.

    Args:
        study: A study that knows nuisance.
        promise: What the load cases promise by it.
        claims: What is claimed, in SI: promise by name, promise_each by test pose, promise_error by
            joint, nuisance (standard uncertainties) and errors (of load cases) by name.
    """
    for name, size in claims.get("promise", {}).items():
        if differ(size, found := getattr(promise, name), AGREE):
            yield claim_of("claims-promise", size, found, name)
            break
    poses = [pose.name for pose in study.test_poses]
    each = dict(zip(poses, promise.rho0_each, strict=True))
    for name, size in claims.get("promise_each", {}).items():
        if name in each and differ(size, each[name], AGREE):
            yield claim_of("claims-rho0-at", size, each[name], name)
    errors = dict(zip(study.springs.names, promise.standard_error.tolist(), strict=True))
    for name, size in claims.get("promise_error", {}).items():
        if name not in errors:
            yield Doubt("claims-unknown-error", (name,))
        elif differ(size, errors[name], AGREE):
            yield claim_of("claims-error", size, errors[name], name)
    nuisance = study.nuisance
    if nuisance is None:
        return
    sizes = dict(zip(nuisance.names, nuisance.deviation.tolist(), strict=True))
    for known, what in ((sizes, "nuisance"), (dict(vars(nuisance.errors)), "errors")):
        for name, size in claims.get(what, {}).items():
            yield from _unlike(name, size, known.get(name))


def _unlike(name: str, size: Any, known: Any) -> Iterator[Doubt]:
    """That nuisance counts otherwise than in the study, or is not known there."""
    numbers = {}
    if isinstance(known, float) and isinstance(size, int | float) and not isinstance(size, bool):
        if not differ(size, known, AGREE):
            return
        numbers = {"claimed": float(size), "found": known}
    elif size == known:
        return
    yield Doubt("claims-nuisance", (name,), numbers=numbers)


def claim_of(code: Code, claimed: float, found: float, *about: str) -> Doubt:
    """That something is claimed, and something else is found."""
    return Doubt(code, about, numbers={"claimed": claimed, "found": found})


def differ(claimed: float, found: float, share: float) -> bool:
    """Whether a claim is off by more than a share of what is found, or that is infinite."""
    if not np.isfinite(found):
        return True
    return bool(abs(claimed - found) > share * abs(found))
