"""Which wrenches the experiments may use: fixed, or of bounded size in a planned direction.

The information of a load case is a convex quadratic of its wrench, so the best force has the
largest allowed size: a planned force is a direction, and its design variables are as many numbers
as the directions have room for, normalised (paper eq. 22, where "<" must read "<=").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError
from elastocal.robot.rotations import frame_about


@dataclass(frozen=True)
class FixedVector:
    """Always the same force [N] or moment [N·m]."""

    value: Array

    def __post_init__(self) -> None:
        freeze(self, value=np.reshape(self.value, 3))

    @property
    def variables(self) -> int:
        """Number of design variables."""
        return 0

    @property
    def size(self) -> float:
        """Largest norm [N or N·m]."""
        return float(np.linalg.norm(self.value))

    def decode(self, x: Array) -> Array:
        """(3, N) vectors of design variables (0, N)."""
        return np.tile(self.value[:, None], (1, x.shape[1]))

    def pull(self, x: Array, cotangent: Array) -> Array:
        """(0, N): there is nothing to choose."""
        return x

    def margin(self, vectors: Array) -> Array:
        """(N,) how far (N, 3) vectors are from what is allowed, as minus the distance."""
        return -np.linalg.norm(vectors - self.value, axis=1)

    def direction_room(self, vectors: Array) -> Array:
        """(N,) room of their directions [rad]: they have none of their own, so all."""
        return np.full(len(vectors), np.pi)

    def design(self, vectors: Array) -> Array:
        """(N, 0): there is nothing to choose."""
        return np.zeros((len(vectors), 0))

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(0, count): there is nothing to choose."""
        return np.zeros((0, count))


@dataclass(frozen=True)
class FreeDirection:
    """Norm at most `largest`, direction within `half_angle` of `axis` (π: anywhere).

    Attributes:
        largest: Largest norm [N or N·m].
        axis: (3,) axis of the cone in the base frame.
        half_angle: Opening of the cone [rad].
    """

    largest: float
    axis: Array
    half_angle: float = np.pi

    def __post_init__(self) -> None:
        _refuse_size(self.largest)
        freeze(self, axis=_unit(self.axis, "the axis of the cone of directions"))

    @property
    def variables(self) -> int:
        """Number of design variables."""
        return 3

    @property
    def size(self) -> float:
        """Largest norm [N or N·m]."""
        return self.largest

    @property
    def is_cone(self) -> bool:
        """Whether the direction is restricted at all."""
        return self.half_angle < np.pi

    def decode(self, x: Array) -> Array:
        """(3, N) vectors of the largest norm along the design variables (3, N)."""
        return self.largest * x / np.linalg.norm(x, axis=0)

    def pull(self, x: Array, cotangent: Array) -> Array:
        """(3, N) gradient in the design variables of a gradient in the vectors."""
        return _pull_size(x, cotangent, self.largest)

    def cone(self, x: Array) -> tuple[Array, Array]:
        """Margin (N,) to the cone [rad] and its gradient (3, N) in the design variables."""
        norm = np.linalg.norm(x, axis=0)
        unit = x / norm
        cosine = np.clip(self.axis @ unit, -1.0, 1.0)
        steepness = 1.0 / np.sqrt(np.maximum(1.0 - cosine**2, 1e-6))
        gradient = (self.axis[:, None] - unit * cosine) * steepness / norm
        return self.half_angle - np.arccos(cosine), gradient

    def design(self, vectors: Array) -> Array:
        """(N, 3) design variables of norm 1 of (N, 3) vectors."""
        return _units(vectors)

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(3, count) directions, uniform in the cone."""
        cosine = rng.uniform(np.cos(self.half_angle), 1.0, count)
        turn = rng.uniform(0.0, 2.0 * np.pi, count)
        sine = np.sqrt(1.0 - cosine**2)
        x, y, _ = -frame_about(self.axis).T
        return (
            np.outer(self.axis, cosine)
            + np.outer(x, sine * np.cos(turn))
            + np.outer(y, sine * np.sin(turn))
        )

    def margin(self, vectors: Array) -> Array:
        """(N,) slack of (N, 3) vectors in the bound on the norm [N or N·m]."""
        return self.largest - np.linalg.norm(vectors, axis=1)

    def direction_room(self, vectors: Array) -> Array:
        """(N,) angles left between the directions of (N, 3) vectors and the cone [rad].

        π where all directions are allowed, and for zero vectors.
        """
        if not self.is_cone:
            return np.full(len(vectors), np.pi)
        across = np.linalg.norm(np.cross(vectors, self.axis), axis=1)
        room = self.half_angle - np.arctan2(across, vectors @ self.axis)
        return np.asarray(np.where(vectors.any(axis=1), room, np.pi))


@dataclass(frozen=True)
class InPlane:
    """Norm at most `largest`, direction anywhere in the plane across `normal`.

    Attributes:
        largest: Largest norm [N or N·m].
        normal: (3,) normal of the plane in the base frame.

    Source: paper eq. (30), where the plane holds the arm.
    """

    largest: float
    normal: Array

    def __post_init__(self) -> None:
        _refuse_size(self.largest)
        freeze(self, normal=_unit(self.normal, "the normal of the plane of directions"))

    @property
    def variables(self) -> int:
        """Number of design variables."""
        return 2

    @property
    def size(self) -> float:
        """Largest norm [N or N·m]."""
        return self.largest

    @property
    def basis(self) -> Array:
        """(3, 2) two unit vectors across each other that span the plane."""
        return frame_about(self.normal)[:, :2]

    def decode(self, x: Array) -> Array:
        """(3, N) vectors of the largest norm along the design variables (2, N)."""
        return self.largest * (self.basis @ x) / np.linalg.norm(x, axis=0)

    def pull(self, x: Array, cotangent: Array) -> Array:
        """(2, N) gradient in the design variables of a gradient in the vectors."""
        return _pull_size(x, self.basis.T @ cotangent, self.largest)

    def design(self, vectors: Array) -> Array:
        """(N, 2) design variables of norm 1 of (N, 3) vectors, seen along the normal."""
        return _units(vectors @ self.basis)

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(2, count) design variables, directions uniform in the plane."""
        turn = rng.uniform(0.0, 2.0 * np.pi, count)
        return np.stack([np.cos(turn), np.sin(turn)])

    def margin(self, vectors: Array) -> Array:
        """(N,) slack of (N, 3) vectors in the bound on the norm [N or N·m]."""
        return self.largest - np.linalg.norm(vectors, axis=1)

    def direction_room(self, vectors: Array) -> Array:
        """(N,) minus the angles between (N, 3) vectors and the plane [rad]; π for zero vectors."""
        off = np.abs(vectors @ self.normal)
        angle = np.arctan2(off, np.linalg.norm(vectors @ self.basis, axis=1))
        return np.asarray(np.where(vectors.any(axis=1), -angle, np.pi))


@dataclass(frozen=True)
class ThereOrNot:
    """A given force [N] or moment [N·m], or none of it.

    The design variable says which: above one half it is there. No search moves it by a gradient;
    both are looked at. Nothing between would be better: the information of a load case is a convex
    quadratic of the share.
    """

    value: Array

    def __post_init__(self) -> None:
        freeze(self, value=np.reshape(self.value, 3))
        _refuse_size(self.size)

    @property
    def variables(self) -> int:
        """Number of design variables."""
        return 1

    @property
    def size(self) -> float:
        """Largest norm [N or N·m]."""
        return float(np.linalg.norm(self.value))

    def decode(self, x: Array) -> Array:
        """(3, N) vectors of design variables (1, N)."""
        return self.value[:, None] * (x > 0.5)

    def pull(self, x: Array, cotangent: Array) -> Array:
        """(1, N) zeros: the share is not moved."""
        return np.zeros_like(x)

    def margin(self, vectors: Array) -> Array:
        """(N,) how far (N, 3) vectors are from what is allowed, as minus the distance."""
        share = np.round(np.clip(self.design(vectors), 0.0, 1.0))
        return -np.linalg.norm(vectors - share * self.value, axis=1)

    def direction_room(self, vectors: Array) -> Array:
        """(N,) room of their directions [rad]: they have none of their own, so all."""
        return np.full(len(vectors), np.pi)

    def design(self, vectors: Array) -> Array:
        """(N, 1) share of (N, 3) vectors."""
        return (vectors @ self.value)[:, None] / self.size**2

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(1, count) nothing, or all."""
        return rng.integers(0, 2, (1, count)).astype(float)


Load = FixedVector | FreeDirection | InPlane | ThereOrNot


def _refuse_size(largest: float) -> None:
    if not (np.isfinite(largest) and largest > 0.0):
        raise InputError(f"the largest force or torque must be positive, found {largest}")


def _unit(vector: Array, what: str) -> Array:
    """(3,) a vector of norm 1; refused if it has no direction."""
    vector = np.array(vector, dtype=float)
    if not np.linalg.norm(vector) > 0.0:
        raise InputError(f"{what} must not be zero")
    return np.asarray(vector / np.linalg.norm(vector))


def _units(vectors: Array) -> Array:
    """(N, k) vectors of norm 1; some direction where there is none."""
    norm = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(norm > 0.0, vectors / np.where(norm > 0.0, norm, 1.0), 0.5)


def _pull_size(x: Array, cotangent: Array, size: float) -> Array:
    """(k, N) gradient in vectors (k, N) of a gradient in the same vectors brought to one size."""
    norm = np.linalg.norm(x, axis=0)
    unit = x / norm
    along = np.einsum("cn,cn->n", unit, cotangent)
    return np.asarray(size * (cotangent - unit * along) / norm)
