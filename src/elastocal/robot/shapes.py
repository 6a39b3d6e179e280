"""What hangs on the bodies of a robot: masses, and solids to draw or to collide.

Both are data in the frame of a body, which is told by its number: 0 is the base, n the last body of
the chain, those of followers come behind, see `Robot`. `chain.T_body_joint` takes coordinates
from the frame of a joint, in which files are written, to the frame of its body.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError

DIMENSIONS = {
    "box": ("length x", "length y", "length z"),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
    "mesh": ("scale x", "scale y", "scale z"),
}
"""What the numbers in `size` mean, by the kind of a shape."""


@dataclass(frozen=True)
class BodyMass:
    """A mass that moves with a body.

    Attributes:
        body: Number of the body it moves with: 0 is the base, see `Robot`.
        mass: Mass [kg].
        center: (3,) centre of mass in the frame of that body [m].
        name: Name of the link it belongs to, for messages.
    """

    body: int
    mass: float
    center: Array
    name: str = ""

    def __post_init__(self) -> None:
        freeze(self, center=np.reshape(self.center, 3))
        if not (np.isfinite(self.mass) and self.mass >= 0.0):
            raise InputError(f"mass of {self.name!r}: expected kg from 0, found {self.mass:g}")
        if not np.all(np.isfinite(self.center)):
            raise InputError(f"centre of mass of {self.name!r}: expected three finite numbers")


@dataclass(frozen=True)
class Shape:
    """A solid that moves with a body.

    A box is centred in its frame; cylinder and capsule are, too, and lie along z.

    Attributes:
        kind: box, cylinder, sphere, capsule or mesh.
        size: Its numbers [m], see `DIMENSIONS`: lengths of the sides; radius and length, of a
            capsule without its caps; of a mesh the factors from the numbers in its file to metres.
        pose: (4, 4) T_body_shape [m].
        body: Number of the body it moves with: 0 is the base, see `Robot`.
        name: Name of the link it belongs to, for messages.
        mesh: File of a mesh; None for other kinds, and for a mesh whose file was not found.
        source: The mesh as its robot file names it, such as package://arm/meshes/link1.stl.
        color: (4,) red, green, blue, opacity, each in [0, 1]; empty if not given.
    """

    kind: str
    size: Array
    pose: Array
    body: int
    name: str = ""
    mesh: Path | None = None
    source: str = ""
    color: tuple[float, ...] = field(default=())

    def __post_init__(self) -> None:
        if self.kind not in DIMENSIONS:
            raise InputError(
                f"shape of {self.name!r}: kind {self.kind!r} is not known; "
                f"expected one of {', '.join(DIMENSIONS)}"
            )
        wanted = DIMENSIONS[self.kind]
        freeze(self, "pose", size=np.atleast_1d(self.size))
        size, pose = self.size, self.pose
        if size.shape != (len(wanted),) or not np.all(np.isfinite(size)):
            raise InputError(
                f"shape of {self.name!r}: a {self.kind} needs {len(wanted)} finite numbers "
                f"({', '.join(wanted)})"
            )
        if self.kind != "mesh" and not np.all(size > 0.0):
            raise InputError(
                f"shape of {self.name!r}: the numbers of a {self.kind} must be positive, found "
                f"{' '.join(f'{value:g}' for value in size)}"
            )
        if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
            raise InputError(f"shape of {self.name!r}: its pose must be a finite 4x4 matrix")
