"""The box that is searched, and how a configuration gets into it.

Sum coordinates of neighbouring parallel axes, ranges of at least a whole turn cut to one, variables
that are held, halves by symmetry: each has its place in one pass from the base to the flange.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import InputError
from elastocal.proof.statement import ChainJoints, HeldVariable, Statement

TURN = 2.0 * np.pi
_PARALLEL = 1e-12  # sine of an angle between axes that is rounding
_WHOLE = 1e-9  # what a whole turn may lack [rad]
_BORDER = 1e-12  # how far from it a point is on a border
_INSIDE = 1e-9  # how far outside of the root rounding may put a point

Interval = tuple[float, float]


def sums(joints: ChainJoints) -> Array:
    """(n, n) `mix` with q_i = x_i - s x_{i-1} where neighbouring joints turn about parallel axes.

    There x_i is the sum of all turns so far, and what is beyond does not depend on x_{i-1}.
    """
    mix = np.eye(len(joints))
    for i in range(1, len(joints)):
        before, axis = joints.axis[i - 1], joints.axis[i]
        fixed = (joints.lower == joints.upper)[[i - 1, i]].any()
        if fixed or joints.slides[[i - 1, i]].any():
            continue
        if np.linalg.norm(np.cross(before, axis)) <= _PARALLEL:
            mix[i, i - 1] = -np.sign(before @ axis)
    return mix


def whole_turns(joints: ChainJoints) -> BoolArray:
    """(n,) which joints turn by at least a whole turn, so that limits do not matter."""
    return np.asarray(~joints.slides & (joints.upper - joints.lower >= TURN - _WHOLE))


def with_root(
    statement: Statement,
    held: tuple[HeldVariable, ...] = (),
    halves: Mapping[int, Interval] | None = None,
) -> Statement:
    """The statement with the root that follows from its `mix`, what is held and what is halved.

    Args:
        statement: The statement.
        held: Variables that are held; at zero, or as near to it as they come.
        halves: Halves of the ranges of variables.
    """
    joints, mix, n = statement.joints, statement.mix, len(statement.joints)
    because = {one.variable: one.because for one in held}
    whole = whole_turns(joints)
    root, limited = np.zeros((2, n)), np.zeros(n, dtype=bool)
    spans: list[Interval] = []  # of each variable, as others see it
    for i in range(n):
        before = [j for j in range(i) if mix[i, j] != 0.0]
        ends = np.array([sorted(-mix[i, j] * e for e in spans[j]) for j in before]).reshape(-1, 2)
        low, high = np.array([joints.lower[i], joints.upper[i]]) + ends.sum(axis=0)
        if whole[i]:
            low, high = -np.pi, np.pi
        else:
            free = any(because.get(j) == "flat" for j in before)
            wide = any(root[1, j] > root[0, j] for j in before)
            limited[i] = wide and not free
            if not limited[i] and not joints.slides[i] and high - low > TURN:
                low, high = 0.5 * (low + high) - np.pi, 0.5 * (low + high) + np.pi
        low, high = (halves or {}).get(i, (low, high))
        spans.append((low, high))
        if i in because:
            low = high = float(np.clip(0.0, low, high))
            if because[i] == "base":
                spans[i] = (low, high)
        root[:, i] = low, high
    return replace(statement, root=root, limited=limited, held=held)


def circles(statement: Statement) -> BoolArray:
    """(n,) variables that have a whole turn of room, but for halves: only remainders count."""
    s = with_root(replace(statement, halved=()), statement.held)
    return np.asarray((s.root[1] - s.root[0] >= TURN - _WHOLE) & ~s.limited & ~s.joints.slides)


def into_root(statement: Statement, q: Array) -> Array:
    """(N, n) points x of the root that stand for configurations (N, n) within the joint limits.

    The largest sensitivity there is that of the configuration, and constraints hold there where
    they hold in it.

    Raises:
        InputError: a configuration is outside of the limits.
    """
    s = statement
    x = _coordinates(s, q)
    for half in s.halved:
        low, high = s.root[:, half.variable]
        value = x[:, half.variable]
        outside = (value > high + _BORDER) | (value < low - _BORDER)
        image = _coordinates(s, half.signs * (x @ s.mix.T) + half.shifts)
        x = np.where(outside[:, None], image, x)
    for i in np.flatnonzero(s.root[0] == s.root[1]):
        if s.joints.lower[i] != s.joints.upper[i]:
            x[:, i] = s.root[0, i]
    off = np.maximum(s.root[0] - x, x - s.root[1]).max()
    if off > _INSIDE:
        raise InputError(f"a configuration is outside of the box that is searched, by {off:.3g}")
    return np.clip(x, *s.root)


def _coordinates(s: Statement, q: Array) -> Array:
    """x of configurations, what has a whole turn of room brought into its turn.

    Joints held because they turn the whole arm are where the root has them.
    """
    x, round_ = np.zeros_like(q), circles(s)
    base = {one.variable for one in s.held if one.because == "base"}
    for i in range(q.shape[1]):
        x[:, i] = q[:, i] - x[:, :i] @ s.mix[i, :i]
        if i in base:
            x[:, i] = s.root[0, i]
        elif round_[i]:
            x[:, i] -= TURN * np.floor((x[:, i] - s.root[0, i] + _BORDER) / TURN)
    return x
