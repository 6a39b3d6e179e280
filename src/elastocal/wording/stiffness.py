"""Compliance and stiffness of the TCP as people read them: µm/N and N/µm."""

from __future__ import annotations

import numpy as np

from elastocal.wording.numbers import number

COMPLIANCE, STIFFNESS = (1e6, "µm/N"), (1e-6, "N/µm")


def ranged(interval: tuple[float, float, float], factor: float) -> str:
    """A value [SI] times a factor, with the ends of its interval if it has any width."""
    value, low, high = (factor * end for end in interval)
    if not (high > low and np.isfinite(value)):
        return number(value, 4)
    digits = _digits(value, high - low)
    return f"{number(value, digits)} ({number(low, digits)} … {number(high, digits)})"


def plus_minus(interval: tuple[float, float, float], factor: float) -> str:
    """A value [SI] times a factor, with half the width of its interval, where room is short."""
    value, low, high = (factor * end for end in interval)
    half = 0.5 * (high - low)
    if not (np.isfinite(value) and half > 0.0):
        return number(value, 4)
    return f"{number(value, _digits(value, 2.0 * half))} ± {number(half, 2)}"


def _digits(value: float, width: float) -> int:
    """So many that an interval of this width has two of its own, four at least."""
    if not (np.isfinite(width) and value):
        return 4
    return int(np.clip(2 + np.floor(np.log10(abs(value) / width)), 3, 6)) + 1


def left_out(missing: int, rigid: tuple[str, ...]) -> list[str]:
    """What a stiffness does not have: joints that are taken as rigid, an inverse."""
    said = []
    if rigid:
        are = "is" if len(rigid) == 1 else "are"
        said.append(
            f"{', '.join(rigid)} {are} taken as rigid by this model: the robot is softer than that"
        )
    if missing:
        ways = "one" if missing == 1 else str(missing)
        said.append(
            f"K_C is infinite: the springs of the model leave {ways} of the six ways to move the "
            "TCP rigid"
        )
    return said
