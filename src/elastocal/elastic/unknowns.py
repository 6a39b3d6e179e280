"""Unknowns of an arm: numbers to be found, each of which makes the compliance of some springs.

Mostly one unknown is one spring. A bearing that tilts alike in every direction is one unknown and
two springs; one that does not is a symmetric tensor: three unknowns, and springs about three axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.elastic.springs import VirtualJoints, merged
from elastocal.errors import InputError
from elastocal.robot.joint_kinds import JointKind, kind_of


@dataclass(frozen=True)
class Unknowns:
    """p unknowns.

    Attributes:
        names: Their p names.
        springs: The c springs that they make, in chain order.
        make: (c, p) compliances of the springs for one of each unknown.
    """

    names: tuple[str, ...]
    springs: VirtualJoints
    make: Array

    def __post_init__(self) -> None:
        freeze(self, "make")
        if self.make.shape != (len(self.springs), len(self.names)):
            raise InputError(
                f"{len(self.names)} unknowns of {len(self.springs)} springs need a matrix of "
                f"{len(self.springs)} x {len(self.names)}, found {self.make.shape}"
            )

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def plain(self) -> bool:
        """Whether each unknown is one spring, in the order of the springs."""
        return self.make.shape[0] == self.make.shape[1] and bool(
            (self.make == np.eye(len(self))).all()
        )

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """What goes with each unknown: that of the springs it makes."""
        first = [int(np.flatnonzero(column)[0]) for column in self.make.T]
        return tuple(kind_of(bool(self.springs.prismatic[i])) for i in first)

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each unknown: that of the springs it makes."""
        first = [int(np.flatnonzero(column)[0]) for column in self.make.T]
        return tuple(self.springs.units[i] for i in first)

    def columns(self, rows: Array) -> Array:
        """(..., p) columns of the unknowns, of those of the springs (..., c)."""
        return rows if self.plain else np.asarray(rows @ self.make)

    def cotangents(self, bars: Array) -> Array:
        """(..., c) gradients in the columns of the springs, of those of the unknowns (..., p)."""
        return bars if self.plain else np.asarray(bars @ self.make.T)


def each_spring(springs: VirtualJoints) -> Unknowns:
    """One unknown a spring."""
    return Unknowns(springs.names, springs, np.eye(len(springs)))


def left_alone(springs: VirtualJoints) -> Unknowns:
    """No unknown at all: springs that nothing which is fitted makes."""
    return Unknowns((), springs, np.zeros((len(springs), 0)))


def joined(first: Unknowns, second: Unknowns) -> Unknowns:
    """The unknowns of both, those of the first before those of the second.

    Raises:
        InputError: a spring, or an unknown, has the name of another one.
    """
    if not len(second.springs):
        return first
    twice = sorted(set(first.names) & set(second.names))
    if twice:
        raise InputError(f"unknown {twice[0]!r} is given twice")
    springs = merged(first.springs, second.springs)
    place = {name: i for i, name in enumerate(springs.names)}
    make = np.zeros((len(springs), len(first) + len(second)))
    make[[place[n] for n in first.springs.names], : len(first)] = first.make
    make[[place[n] for n in second.springs.names], len(first) :] = second.make
    return Unknowns((*first.names, *second.names), springs, make)
