"""Meshes for collision: the convex hulls of their connected parts.

A mesh file comes from anywhere. It is read with a limit on its size, in four formats, from the
one path that was named; what it holds is checked before anything is computed from it.
"""

from __future__ import annotations

import io
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.errors import InputError
from elastocal.reading import bytes_of
from elastocal.robot.shapes import Shape
from elastocal.wording.numbers import described

FORMATS = (".stl", ".obj", ".ply", ".dae")
LARGEST = 32 * 1024 * 1024
"""Bytes of a mesh file that are read at most."""
LARGEST_SIZE = 100.0
"""A mesh larger than this [m] is taken for one in millimetres read as metres."""
SMALLEST_SIZE = 1e-3
"""A mesh smaller than this [m] is taken for one in metres read as millimetres."""
_PARTS = 200
_NO_VERTEX = "{}: a triangle of the mesh names a vertex that is not there"


class MeshSizeError(InputError):
    """A mesh of a size that no part of a cell has: `size` [m]."""

    def __init__(self, message: str, size: float) -> None:
        super().__init__(message)
        self.size = size


def hulls(shape: Shape) -> list[Array]:
    """(V, 3) corners [m] of the hull of every connected part of a mesh, in the mesh's frame.

    Raises:
        InputError: no file, too large, not a mesh, not finite, or of a size that no part of a cell
            has.
    """
    if shape.mesh is None:
        package = shape.source.removeprefix("package://").partition("/")[0]
        mend = (
            f"name the folder of its package beside 'urdf': packages: {{{package}: folder}}"
            if shape.source.startswith("package://")
            else "put it where the robot file says"
        )
        raise InputError(
            f"the mesh {shape.source or shape.name!r} of {shape.name!r} was not found; collision "
            f"needs it: {mend}"
        )
    return list(_hulls(shape.mesh, tuple(float(factor) for factor in shape.size), _now(shape.mesh)))


def triangles(shape: Shape) -> tuple[Array, IntArray]:
    """Vertices (V, 3) [m] in the mesh's frame, and triangles (F, 3), to draw a mesh with.

    Raises:
        InputError: no file, too large, not a mesh, or not finite.
    """
    if shape.mesh is None:
        raise InputError(f"the mesh {shape.source or shape.name!r} of {shape.name!r} was not found")
    vertices, faces = _read(shape.mesh)
    return np.asarray(vertices * shape.size), faces


def _now(path: Path) -> tuple[int, ...]:
    """What tells whether a file is still as it was when it was read; nothing if it is not there."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return ()
    return (found.st_mtime_ns, found.st_size, found.st_ino)


@lru_cache(maxsize=256)
def _hulls(path: Path, scale: tuple[float, ...], _: tuple[int, ...]) -> tuple[Array, ...]:
    vertices, faces = _read(path)
    vertices = vertices * np.array(scale)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if size > LARGEST_SIZE:
        raise MeshSizeError(
            f"{path}: the mesh is {size:.4g} m across; is it in millimetres, and its unit or scale "
            "not said?",
            size,
        )
    if size < SMALLEST_SIZE:
        raise MeshSizeError(
            f"{path}: the mesh is {described(size, 'm')} across; is it in metres, and its unit or "
            "scale wrong?",
            size,
        )
    parts = _connected(vertices, faces)
    if len(parts) > _PARTS:
        raise InputError(
            f"{path}: the mesh has {len(parts)} separate parts, more than {_PARTS}; simplify it"
        )
    return tuple(frozen(corners) for corners in _outermost([convex_hull(part) for part in parts]))


def _read(path: Path) -> tuple[Array, IntArray]:
    """Vertices (V, 3) and triangles (F, 3) as they are in the file."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"{path}: mesh format {path.suffix or 'without ending'!r} is not read; {_instead(path)}"
        )
    data = bytes_of(path, LARGEST)
    if path.suffix.lower() == ".dae":
        from elastocal.constraints.collision.collada import collada

        vertices, faces = collada(data, str(path))
    else:
        vertices, faces = _by_trimesh(path, data)
    if not len(faces) or not len(vertices):
        raise InputError(f"{path}: the mesh has no triangles")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(_NO_VERTEX.format(path))
    if not np.isfinite(vertices).all():
        raise InputError(f"{path}: the mesh has vertices that are not finite numbers")
    return vertices, faces


def _instead(path: Path) -> str:
    """What to do about a format that is not read."""
    beside = next(
        (
            file.name
            for file in (path.with_suffix(end) for end in FORMATS)
            if path.suffix and file.is_file()
        ),
        None,
    )
    if beside:
        return f"name {beside} instead, which lies beside it"
    return f"save it as one of {', '.join(FORMATS)} and name that"


def _by_trimesh(path: Path, data: bytes) -> tuple[Array, IntArray]:
    try:
        import trimesh
    except ImportError:
        raise InputError(
            "meshes need the package trimesh: pip install 'elastocal[collision]'"
        ) from None
    try:
        # No resolver: the file cannot make the reader open others, such as materials.
        mesh: Any = trimesh.load(
            io.BytesIO(data), file_type=path.suffix[1:].lower(), process=False, force="mesh"
        )
        vertices: Array = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        faces: IntArray = np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
    except Exception as error:  # whatever a hostile file makes of a parser
        if isinstance(error, IndexError):
            raise InputError(_NO_VERTEX.format(path)) from None
        raise InputError(
            f"{path}: not a readable {path.suffix[1:].lower()} mesh; save it again from the "
            "program it comes from"
        ) from None
    return vertices, faces


def _connected(vertices: Array, faces: IntArray) -> list[Array]:
    """Vertices of every connected part; vertices at the same place are one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    unit = 1e-6 * max(float(np.ptp(vertices, axis=0).max()), 1e-12)
    places, index = np.unique(np.round(vertices / unit), axis=0, return_inverse=True)
    faces = np.reshape(index, -1)[faces]
    points = np.zeros((len(places), 3))
    points[np.reshape(index, -1)] = vertices
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_matrix((np.ones(len(edges)), edges.T), (len(points), len(points)))
    _, label = connected_components(graph, directed=False)
    used = np.unique(faces)
    order = used[np.argsort(label[used], kind="stable")]
    cuts = np.flatnonzero(np.diff(label[order])) + 1
    return np.split(points[order], cuts)


def convex_hull(points: Array) -> Array:
    """(K, 3) corners of the hull of points (V, 3); of a flat part those of a box around it."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        low, high = points.min(axis=0) - _THIN, points.max(axis=0) + _THIN
        corners = np.indices((2, 2, 2)).reshape(3, 8).T
        return np.where(corners == 1, high, low)


def _outermost(parts: list[Array]) -> list[Array]:
    """The parts that are not inside the hull of a larger one, as screws and fillings are."""
    from scipy.spatial import ConvexHull

    solids = sorted((ConvexHull(part) for part in parts), key=lambda hull: -hull.volume)
    kept: list[ConvexHull] = []
    for solid in solids:
        corners = solid.points[solid.vertices]
        if not any((_over(hull, corners) < _FLUSH).all() for hull in kept):
            kept.append(solid)
    return [hull.points[hull.vertices] for hull in kept]


def _over(hull: Any, points: Array) -> Array:
    """(V,) how far points lie over the planes of a hull [m]; none inside."""
    return np.asarray((points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1))


_FLUSH = 1e-3  # what stands out less than this [m] does not count as a part of its own
_THIN = 5e-4  # half the thickness [m] that a sheet without any is given
