"""Parts of meshes: what shares a place is one, however badly its triangles meet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.constraints.collision.mesh import hulls, triangles
from elastocal.errors import InputError
from elastocal.robot.shapes import Shape

PLACES = {
    "a T-junction": ("0 0 0, 1 0 0, 1 1 0, 0 1 0, 1 .5 0, 2 0 0, 2 1 .2", "123 134 265 567 573"),
    "an edge of three faces": ("0 0 0, 0 0 1, 1 0 0, -1 1 0, -1 -1 0", "123 124 125"),
    "a vertex alone": ("0 0 0, 1 0 0, 0 1 0, -1 0 1, 0 -1 1", "123 145"),
}


def mesh(folder: Path, vertices: str, faces: str) -> Shape:
    path = folder / "part.obj"
    lines = [f"v {vertex.strip()}" for vertex in vertices.split(",")]
    path.write_text("\n".join([*lines, *(f"f {' '.join(face)}" for face in faces.split())]))
    return Shape("mesh", np.ones(3), np.eye(4), 0, "part", path, path.name)


@pytest.mark.parametrize("name", PLACES)
def test_triangles_that_share_a_place_are_one_part(name: str, tmp_path: Path) -> None:
    (corners,) = hulls(mesh(tmp_path, *PLACES[name]))
    given = np.array([vertex.split() for vertex in PLACES[name][0].split(",")], dtype=float)
    np.testing.assert_allclose(np.ptp(corners, axis=0), np.ptp(given, axis=0))


def test_parts_apart_are_two_and_a_flat_one_gets_a_millimetre(tmp_path: Path) -> None:
    solids = hulls(mesh(tmp_path, "0 0 0, 1 0 0, 0 1 0, 5 0 0, 6 0 0, 5 1 0, 5 0 1", "123 456 457"))
    assert len(solids) == 2
    flat = min(solids, key=lambda corners: np.ptp(corners[:, 2]))
    np.testing.assert_allclose(np.ptp(flat, axis=0), [1.001, 1.001, 0.001])


def test_a_triangle_of_a_vertex_that_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "odd.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError, match="names a vertex that is not there"):
        hulls(Shape("mesh", np.ones(3), np.eye(4), 0, "part", path, path.name))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999\n", "that is not there"),
        ("far.ply", "ply\nformat ascii 1.0\nelement vertex 1\nend_header\n", ""),
        ("none.stl", "solid x\nfacet normal a b c\n", ""),
        ("bytes.stl", "x" * 100, ""),
    ],
)
def test_what_is_wrong_is_said_in_our_words(
    name: str, text: str, said: str, tmp_path: Path
) -> None:
    pytest.importorskip("trimesh")
    (tmp_path / name).write_text(text, encoding="utf-8")
    shape = Shape("mesh", np.ones(3), np.eye(4), 0, "part", tmp_path / name, name)
    with pytest.raises(InputError) as raised:
        triangles(shape)
    sentence = str(raised.value)
    assert said in sentence
    for word in ("axis", "index", "array", "Error", "numpy", "could not", "buffer"):
        assert word not in sentence.removeprefix(str(tmp_path))


def test_a_mesh_that_was_saved_anew_is_read_anew(tmp_path: Path) -> None:
    vertices = "0 0 0, 1 0 0, 0 1 0, 0 0 1"
    faces = "123 124 134 234"
    (before,) = hulls(mesh(tmp_path, vertices, faces))
    (after,) = hulls(mesh(tmp_path, vertices.replace("1 0 0", "2.5 0 0"), faces))
    np.testing.assert_allclose([np.ptp(before[:, 0]), np.ptp(after[:, 0])], [1.0, 2.5])
