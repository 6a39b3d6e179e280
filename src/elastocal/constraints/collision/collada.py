"""COLLADA files (.dae), as far as a mesh goes: triangles where the scene has them, metres, z up.

In: the bytes of a file from anywhere. Out: vertices and triangles. Read by the same parser as robot
files: no document types, no entities, no other files. Colours, normals and animations are left out.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.sources.xml_tree import Node, parse_xml

_MOST_PLACED, _DEEPEST = 10_000, 100
_MOST_CORNERS = 30_000_000
_UP = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z_UP": np.eye(3),
}
"""From each system of the specification to z up: what was right, up and towards one stays so."""


def collada(data: bytes, where: str) -> tuple[Array, IntArray]:
    """Vertices (V, 3) [m] and triangles (F, 3) of a COLLADA file; `where` names it in messages.

    The unit of the file and its axis that is up are those that it says, else metres and z: of a
    file that does not say it the specification thinks y, but what robot files name is z up.

    Raises:
        InputError: it is no COLLADA file, or wrong; the message names the line.

    Source: COLLADA 1.4.1 specification (Khronos).
    """
    root = parse_xml(data, where, texts=True)
    if root.tag != "COLLADA":
        raise root.error(f"expected <COLLADA>, found <{root.tag}>")
    reader = _Reader(root)
    parts = list(reader.placed())
    to_metres = reader.unit * reader.up
    vertices = [corners @ to_metres.T for corners, _ in parts]
    first = np.cumsum([0, *(len(corners) for corners in vertices)])
    faces = [triangles + start for (_, triangles), start in zip(parts, first, strict=False)]
    if not parts:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    return np.concatenate(vertices), np.concatenate(faces)


class _Reader:
    """One document: its elements by their ids."""

    def __init__(self, root: Node) -> None:
        self.root = root
        self.by_id = {node.attributes["id"]: node for node in _all(root) if "id" in node.attributes}
        self.geometries: dict[str, tuple[Array, IntArray]] = {}
        self.count = self.corners = 0
        asset = next(iter(root.all("asset")), None)
        self.unit, self.up = 1.0, _UP["Z_UP"]
        if asset is None:
            return
        for unit in asset.all("unit"):
            self.unit = float(_numbers(unit, unit.attributes.get("meter", "1"), 1)[0])
            if not self.unit > 0.0:
                raise unit.error(f"the unit must be a positive number of metres, found {self.unit}")
        for up in asset.all("up_axis"):
            if up.text.strip() not in _UP:
                raise up.error(f"<up_axis> {up.text.strip()[:40]!r}; expected {', '.join(_UP)}")
            self.up = _UP[up.text.strip()]

    def placed(self) -> Iterator[tuple[Array, IntArray]]:
        """Every geometry where the scene has it; without a scene each as it is."""
        scenes = [
            self._named(instance, "visual_scene")
            for scene in self.root.all("scene")
            for instance in scene.all("instance_visual_scene")
        ]
        if not scenes:
            for library in self.root.all("library_geometries"):
                for geometry in library.all("geometry"):
                    yield self._geometry(geometry)
        for scene in scenes:
            for node in scene.all("node"):
                yield from self._node(node, np.eye(4), 0)

    def _node(self, node: Node, T: Array, depth: int) -> Iterator[tuple[Array, IntArray]]:
        """The geometries of a node and of those below it, seen through all their transforms."""
        self.count += 1
        if self.count > _MOST_PLACED or depth > _DEEPEST:
            raise node.error(f"more than {_MOST_PLACED} nodes, or more than {_DEEPEST} in a line")
        for child in node.children:
            if child.tag in _TRANSFORMS:
                T = T @ _transform(child)
        for child in node.children:
            if child.tag == "instance_geometry":
                corners, triangles = self._geometry(self._named(child, "geometry"))
                self.corners += len(corners)
                if self.corners > _MOST_CORNERS:
                    raise child.error(f"the scene has more than {_MOST_CORNERS} corners")
                if np.linalg.det(T[:3, :3]) < 0.0:
                    triangles = triangles[:, ::-1]
                yield corners @ T[:3, :3].T + T[:3, 3], triangles
            elif child.tag == "instance_controller":
                raise child.error("meshes with bones (<instance_controller>) are not read")
            elif child.tag == "instance_node":
                yield from self._node(self._named(child, "node"), T, depth + 1)
            elif child.tag == "node":
                yield from self._node(child, T, depth + 1)

    def _named(self, node: Node, tag: str, key: str = "url") -> Node:
        """The element that an attribute such as url="#shape" names."""
        reference = node.attributes.get(key, "")
        found = self.by_id.get(reference.removeprefix("#"))
        if not reference.startswith("#") or found is None or found.tag != tag:
            raise node.error(
                f"<{node.tag}> names {reference[:60]!r}; there is no such <{tag}> here"
            )
        return found

    def _geometry(self, geometry: Node) -> tuple[Array, IntArray]:
        name = geometry.attributes.get("id", geometry.place)
        if name not in self.geometries:
            meshes = geometry.all("mesh")
            parts = [
                self._faces(kind) for mesh in meshes for kind in mesh.children if kind.tag in _FACES
            ]
            corners = [part[0] for part in parts]
            first = np.cumsum([0, *(len(part) for part in corners)])
            triangles = [part[1] + start for part, start in zip(parts, first, strict=False)]
            self.geometries[name] = (
                np.concatenate([np.zeros((0, 3)), *corners]),
                np.concatenate([np.zeros((0, 3), dtype=np.int64), *triangles]),
            )
        return self.geometries[name]

    def _faces(self, node: Node) -> tuple[Array, IntArray]:
        """Positions and triangles of one primitive."""
        inputs = node.all("input")
        stride = 1 + max((_whole(i, "offset") for i in inputs), default=0)
        vertex = next((i for i in inputs if i.attributes.get("semantic") == "VERTEX"), None)
        if vertex is None:
            raise node.error(f"<{node.tag}> has no input of semantic VERTEX")
        positions = self._positions(self._named(vertex, "vertices", "source"))
        runs = [_integers(p) for p in _paths(node)]
        at = _whole(vertex, "offset")
        for run in runs:
            if len(run) % stride:
                raise node.error(f"<p> has {len(run)} numbers, which are not groups of {stride}")
        rows = [run[at::stride] for run in runs]
        triangles = _FACES[node.tag](node, rows)
        if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(positions):
            raise node.error(f"<{node.tag}> names a vertex that is not there")
        return positions, triangles

    def _positions(self, vertices: Node) -> Array:
        """(V, 3) positions of a <vertices> element."""
        entry = next(
            (i for i in vertices.all("input") if i.attributes.get("semantic") == "POSITION"), None
        )
        if entry is None:
            raise vertices.error("<vertices> has no input of semantic POSITION")
        source = self._named(entry, "source", "source")
        accessors = [a for common in source.all("technique_common") for a in common.all("accessor")]
        if len(accessors) != 1:
            raise source.error(f"<source> has {len(accessors)} accessors, expected one")
        accessor = accessors[0]
        array = self._named(accessor, "float_array", "source")
        count, start = _whole(accessor, "count"), _whole(accessor, "offset")
        stride = _whole(accessor, "stride", 1)
        names = [param.attributes.get("name", "") for param in accessor.all("param")]
        columns = [names.index(axis) for axis in "XYZ" if axis in names] if names else [0, 1, 2]
        numbers = _numbers(array, array.text)
        if len(columns) != 3 or max(columns) >= stride or start + count * stride > len(numbers):
            raise accessor.error(
                f"<accessor> wants {count} points of X, Y, Z with stride {stride} from "
                f"{len(numbers)} numbers"
            )
        return numbers[start : start + count * stride].reshape(count, stride)[:, columns]


def _paths(node: Node) -> list[Node]:
    """The <p> of a primitive, also those of polygons with holes, whose holes are left out."""
    return [*node.all("p"), *(p for hole in node.all("ph") for p in hole.all("p"))]


def _fans(polygons: list[IntArray]) -> IntArray:
    """Triangles of polygons, as fans about their first corners."""
    parts = [
        np.column_stack([np.full(len(p) - 2, p[0]), p[1:-1], p[2:]]) for p in polygons if len(p) > 2
    ]
    return np.concatenate([np.zeros((0, 3), dtype=np.int64), *parts])


def _triangles(node: Node, rows: list[IntArray]) -> IntArray:
    row = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
    if len(row) % 3:
        raise node.error(f"<triangles> has {len(row)} corners, which are no triangles")
    return row.reshape(-1, 3)


def _polylist(node: Node, rows: list[IntArray]) -> IntArray:
    row = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
    counts = np.concatenate([np.zeros(0, dtype=np.int64), *map(_integers, node.all("vcount"))])
    if (counts < 0).any() or counts.sum() != len(row):
        raise node.error(f"<vcount> counts {counts.sum()} corners, <p> has {len(row)}")
    if (counts == 3).all():
        return row.reshape(-1, 3)
    return _fans(np.split(row, np.cumsum(counts)[:-1]))


def _strips(node: Node, rows: list[IntArray]) -> IntArray:
    del node
    parts = [np.column_stack([row[:-2], row[1:-1], row[2:]]) for row in rows if len(row) > 2]
    return np.concatenate([np.zeros((0, 3), dtype=np.int64), *parts])


_FACES = {
    "triangles": _triangles,
    "polylist": _polylist,
    "polygons": lambda _, rows: _fans(rows),
    "trifans": lambda _, rows: _fans(rows),
    "tristrips": _strips,
}
_TRANSFORMS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "skew": 7, "lookat": 9}


def _transform(node: Node) -> Array:
    """(4, 4) what an element of a node does, lengths in the unit of the file."""
    if node.tag in ("skew", "lookat"):
        raise node.error(f"<{node.tag}> is not read; export the mesh with its transforms applied")
    values = _numbers(node, node.text, _TRANSFORMS[node.tag])
    if node.tag == "matrix":
        return values.reshape(4, 4)
    T = np.eye(4)
    if node.tag == "translate":
        T[:3, 3] = values
    elif node.tag == "scale":
        T[:3, :3] = np.diag(values)
    elif length := float(np.linalg.norm(values[:3])):
        T[:3, :3] = from_rotation_vectors((np.radians(values[3]) / length * values[:3])[None])[0]
    return T


def _numbers(node: Node, text: str, count: int | None = None) -> Array:
    """The finite numbers of a text, `count` of them if that is said."""
    try:
        found = np.array(text.split(), dtype=np.float64)
    except ValueError:
        raise node.error(f"<{node.tag}> must be numbers, found {text.strip()[:40]!r}") from None
    if count is not None and len(found) != count:
        raise node.error(f"<{node.tag}> must be {count} numbers, found {len(found)}")
    if not np.isfinite(found).all():
        raise node.error(f"<{node.tag}> has a number that is not finite")
    return found


def _integers(node: Node) -> IntArray:
    try:
        return np.array(node.text.split(), dtype=np.int64)
    except (ValueError, OverflowError):
        raise node.error(f"<{node.tag}> must be whole numbers, found {node.text[:40]!r}") from None


def _whole(node: Node, key: str, default: int = 0) -> int:
    written = node.attributes.get(key, str(default))
    if not (written.isascii() and written.isdigit() and len(written) < 10):
        raise node.error(f"{key!r} of <{node.tag}> must be a whole number, found {written[:40]!r}")
    return int(written)


def _all(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _all(child)
