"""Tensors: springs at one place whose axes are no basis, so that only their sum has a sign.

What bends in between two long links is a symmetric tensor across an axis, made of springs about
three axes of one plane. It cannot be below zero; each of the three can.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.springs import VirtualJoints

_ROUNDING = 1e-9  # share of the largest eigenvalue of a tensor


def of_tensors(springs: VirtualJoints) -> BoolArray:
    """(p,) which springs share their place with others of dependent axes: these may be negative."""
    found = np.zeros(len(springs), dtype=bool)
    for own in _places(springs):
        if np.linalg.matrix_rank(springs.axis[own]) < len(own):
            found[own] = True
    return found


def tensors_of(springs: VirtualJoints, make: Array) -> Array:
    """(G, 3, 3, u) the G tensors there are, for one of each unknown.

    Args:
        springs: c springs.
        make: (c, u) compliances of the springs for one of each unknown.

    A tensor of which parts are elsewhere, as one that is known already, or not told apart from
    another spring, is none: nothing is known of the sign of what is left of it.

    Source: Σ k a aᵀ over the springs of one place, of axes a.
    """
    found = [np.zeros((0, 3, 3, make.shape[1]))]
    for own in _places(springs):
        axes, rows = springs.axis[own], make[own]
        whole = (rows.max(axis=1, initial=0.0) > 0.0).all()
        if whole and np.linalg.matrix_rank(axes) < len(own):
            found.append(np.einsum("sa,sb,su->abu", axes, axes, rows)[None])
    return np.concatenate(found)


def against_the_load(springs: VirtualJoints, compliance: Array) -> tuple[str, ...]:
    """Names of the negative springs at each place where the arm would move against the load.

    Args:
        springs: p springs.
        compliance: (p,) compliances [rad/(N·m) or m/N].

    Source: Σ k a aᵀ over the springs of one place, of axes a, has no negative eigenvalue.
    """
    names: list[str] = []
    for own in _places(springs):
        axes = springs.axis[own]
        size = np.linalg.eigvalsh((axes.T * compliance[own]) @ axes)
        if size[0] < -_ROUNDING * max(size[-1], 0.0):
            names += [springs.names[i] for i in own.tolist() if compliance[i] < 0.0]
    return tuple(names)


def _places(springs: VirtualJoints) -> Iterator[IntArray]:
    """(s,) springs that turn about, or slide along, axes through one point of one body.

    Slides have no point: all those of one body are together. The spring of a joint is alone.
    """
    point = np.where(springs.prismatic[:, None], 0.0, np.round(springs.origin, 9)) + 0.0
    key = np.column_stack([springs.body, springs.prismatic, springs.joint, point])
    _, group = np.unique(key, axis=0, return_inverse=True)
    for g in range(int(group.max(initial=-1)) + 1):
        yield np.flatnonzero(group.ravel() == g)
