"""COLLADA meshes: unit, axis that is up, scene; read as trimesh reads them, or refused by line."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh

from elastocal.arrays import Array, IntArray
from elastocal.constraints.collision.collada import collada
from elastocal.constraints.collision.mesh import hulls, triangles
from elastocal.errors import InputError
from elastocal.robot.shapes import Shape
from elastocal.robot.sources.mesh_files import MeshFiles

ASSET = '<asset><unit name="u" meter="{}"/><up_axis>{}</up_axis></asset>'
CORNERS = "0 0 0  1 0 0  0 2 0  0 0 3"
TRIANGLES = '<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>{}</triangles>'
FACES = TRIANGLES.format("<p>0 2 1  0 1 3  1 2 3  0 3 2</p>")
NODE = '<node id="n">{}<instance_geometry url="#g"/></node>'
HEAD = '<?xml version="1.0"?>\n<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">\n'


def document(
    *, asset: str = ASSET.format(1, "Z_UP"), faces: str = FACES, scene: str = NODE.format(""),
    corners: str = CORNERS, nodes: str = "",
) -> bytes:  # fmt: skip
    numbers = len(corners.split())
    return (
        f'{HEAD}{asset}\n<library_geometries><geometry id="g"><mesh>\n<source id="s">'
        f'<float_array id="f" count="{numbers}">{corners}</float_array><technique_common>'
        f'<accessor source="#f" count="{numbers // 3}" stride="3"><param name="X"/>'
        '<param name="Y"/><param name="Z"/></accessor></technique_common></source>\n'
        '<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>\n'
        f"{faces}</mesh></geometry></library_geometries>\n<library_nodes>{nodes}</library_nodes>\n"
        f'<library_visual_scenes><visual_scene id="w">{scene}</visual_scene>'
        '</library_visual_scenes>\n<scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    ).encode()


def points(data: bytes) -> Array:
    vertices, faces = collada(data, "a.dae")
    return vertices[np.unique(faces)]


PLAIN = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3.0]])


@pytest.mark.parametrize(
    ("unit", "up", "expected"),
    [
        ("1", "Z_UP", PLAIN),
        ("0.01", "Z_UP", 0.01 * PLAIN),
        ("2.54e-2", "Z_UP", 0.0254 * PLAIN),
        ("1", "Y_UP", [[0, 0, 0], [1, 0, 0], [0, 0, 2], [0, -3, 0]]),
        ("0.001", "Y_UP", 1e-3 * np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2], [0, -3, 0]])),
        ("1", "X_UP", [[0, 0, 0], [0, 0, 1], [-2, 0, 0], [0, -3, 0]]),
    ],
)
def test_unit_and_axis_are_those_of_the_file(unit: str, up: str, expected: Array) -> None:
    assert points(document(asset=ASSET.format(unit, up))) == pytest.approx(np.array(expected))


def test_a_file_that_does_not_say_it_is_in_metres_and_z_up() -> None:
    assert points(document(asset="")) == pytest.approx(PLAIN)
    assert points(document(asset="<asset/>")) == pytest.approx(PLAIN)
    assert points(b"\n\n" + document()) == pytest.approx(PLAIN)  # a declaration behind blank lines


TURN = (
    "<translate>1 2 3</translate><rotate>0 0 2 90</rotate><scale>1 2 -1</scale>"
    "<matrix>1 0 0 .5  0 1 0 0  0 0 1 0  0 0 0 1</matrix>"
)


def test_transforms_of_the_scene_are_made_one_after_the_other() -> None:
    inner = NODE.format("<translate>0 0 1</translate>").replace('id="n"', 'id="m"')
    scene = f'<node id="n">{TURN}{inner}</node>'
    expected = [[1 - 2 * y, 2 + x + 0.5, 3 - (z + 1)] for x, y, z in PLAIN]
    assert points(document(scene=scene)) == pytest.approx(np.array(expected))


def test_a_mirrored_mesh_keeps_its_outside_outside() -> None:
    vertices, faces = collada(document(scene=NODE.format("<scale>1 1 -1</scale>")), "a.dae")
    a, b, c = vertices[faces].transpose(1, 0, 2)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(1.0)


def test_nodes_may_stand_in_a_library_and_twice() -> None:
    nodes = NODE.format("").replace('"n"', '"far"')
    scene = (
        '<node id="n"><instance_node url="#far"/></node>'
        '<node id="m"><translate>5 0 0</translate><instance_node url="#far"/></node>'
    )
    found = points(document(scene=scene, nodes=nodes))
    assert found == pytest.approx(np.vstack([PLAIN, PLAIN + np.array([5, 0, 0])]))


SQUARE = "0 0 0  1 0 0  1 1 0  0 1 0"
INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'


@pytest.mark.parametrize(
    "faces",
    [
        f"<polylist>{INPUT}<vcount>4</vcount><p>0 1 2 3</p></polylist>",
        f"<polylist>{INPUT}<vcount>3 3</vcount><p>0 1 2 0 2 3</p></polylist>",
        f"<polygons>{INPUT}<p>0 1 2 3</p></polygons>",
        f"<trifans>{INPUT}<p>0 1 2 3</p></trifans>",
        f"<tristrips>{INPUT}<p>0 1 3 2</p></tristrips>",
        f"<triangles>{INPUT}<p>0 1 2</p></triangles><triangles>{INPUT}<p>0 2 3</p></triangles>",
        f'<triangles>{INPUT}<input semantic="NORMAL" source="#no" offset="1"/>'
        "<p>0 7 1 7 2 7 0 7 2 7 3 7</p></triangles>",
        f"<lines>{INPUT}<p>0 1</p></lines><triangles>{INPUT}<p>0 1 2 0 2 3</p></triangles>",
    ],
)
def test_every_kind_of_face_makes_the_same_square(faces: str) -> None:
    vertices, found = collada(document(corners=SQUARE, faces=faces), "a.dae")
    a, b, c = vertices[found].transpose(1, 0, 2)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(1.0)


def test_what_trimesh_writes_is_read_back() -> None:
    """It writes that y is up, and reads it without turning."""
    pytest.importorskip("collada")
    ball = trimesh.creation.icosphere(2, 0.3)
    data = trimesh.exchange.dae.export_collada(ball)
    vertices, faces = collada(data, "ball.dae")
    back = trimesh.load(io.BytesIO(data), file_type="dae", force="mesh", process=False)
    x, y, z = back.vertices[back.faces].transpose(2, 0, 1)
    assert vertices[faces] == pytest.approx(np.stack([x, -z, y], axis=-1))


LAUGHS = b'<!DOCTYPE COLLADA [<!ENTITY a "1 1 1 1"><!ENTITY b "&a;&a;">]><COLLADA>&b;</COLLADA>'
LOOP = '<node id="n"><instance_node url="#n"/></node>'
WRONG: dict[str, tuple[bytes, str]] = {
    "not xml": (b"solid", "a.dae, line 1, column 1: not valid XML"),
    "entities": (LAUGHS, "line 1: a document type"),
    "another root": (b"<robot/>", "expected <COLLADA>, found <robot>"),
    "no unit": (document(asset=ASSET.format(0, "Z_UP")), "line 3: the unit must be a positive"),
    "words": (document(asset=ASSET.format("m", "Z_UP")), "line 3: <unit> must be numbers"),
    "no axis": (document(asset=ASSET.format(1, "up")), "line 3: <up_axis> 'up'; expected X_UP"),
    "too few": (document(faces=TRIANGLES.format("<p>0 1</p>")), "2 corners, which are no tri"),
    "no vertex": (document(faces=TRIANGLES.format("<p>0 1 4</p>")), "a vertex that is not there"),
    "below 0": (document(faces=TRIANGLES.format("<p>0 1 -1</p>")), "a vertex that is not there"),
    "letters": (document(faces=TRIANGLES.format("<p>0 1 x</p>")), "whole numbers, found '0 1 x'"),
    "huge": (document(faces=TRIANGLES.format(f"<p>0 1 {10**40}</p>")), "must be whole numbers"),
    "counts": (
        document(faces=f"<polylist>{INPUT}<vcount>4</vcount><p>0 1 2</p></polylist>"),
        "<vcount> counts 4 corners, <p> has 3"),
    "infinite": (document(corners="0 0 inf 1 0 0 0 1 0 0 0 1"), "is not finite"),
    "text": (document(corners="a 0 0 1 0 0 0 1 0 0 0 1"), "<float_array> must be numbers"),
    "short": (document().replace(b'count="4" stride', b'count="9" stride'), "wants 9 points"),
    "elsewhere": (document(scene='<node><instance_geometry url="http://x/y#g"/></node>'),
                  "there is no such <geometry> here"),
    "round": (document(scene=LOOP), "in a line"),
    "bones": (document(scene='<node><instance_controller url="#c"/></node>'), "with bones"),
    "skew": (document(scene=NODE.format("<skew>1 0 0 0 0 0 0</skew>")), "<skew> is not read"),
    "a matrix of 3": (document(scene=NODE.format("<matrix>1 2 3</matrix>")), "16 numbers, found 3"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_file_gets_its_sentence(what: str) -> None:
    data, expected = WRONG[what]
    with pytest.raises(InputError) as caught:
        collada(data, "a.dae")
    message = str(caught.value)
    assert message.startswith("a.dae, line")
    assert expected in message
    assert "\n" not in message


def test_scenes_that_multiply_are_stopped() -> None:
    level = "".join('<instance_node url="#n{}"/>' for _ in range(10))
    nodes = "".join(f'<node id="n{i}">{level.format(*[i + 1] * 10)}</node>' for i in range(9))
    nodes += NODE.format("").replace('"n"', '"n9"')
    with pytest.raises(InputError, match="more than 10000 nodes"):
        collada(document(scene='<node><instance_node url="#n0"/></node>', nodes=nodes), "a.dae")


def shape(path: Path) -> Shape:
    return Shape("mesh", np.ones(3), np.eye(4), 1, "link", mesh=path)


def test_hulls_and_pictures_take_them(tmp_path: Path) -> None:
    path = tmp_path / "link.DAE"
    path.write_bytes(document(asset=ASSET.format("0.1", "Y_UP")))
    (corners,) = hulls(shape(path))
    assert np.ptp(corners, axis=0) == pytest.approx([0.1, 0.3, 0.2])
    drawn: tuple[Array, IntArray] = triangles(shape(path))
    assert np.ptp(drawn[0], axis=0) == pytest.approx([0.1, 0.3, 0.2])


def test_formats_that_are_not_read_say_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "link.wrl"
    path.write_text("#VRML")
    with pytest.raises(InputError, match=r"'\.wrl' is not read; save it as one of \.stl, \.obj"):
        hulls(shape(path))
    (tmp_path / "link.stl").write_text("solid")
    with pytest.raises(InputError, match=r"name link\.stl instead, which lies"):
        hulls(shape(path))


def test_meshes_that_are_turned_are_said(tmp_path: Path) -> None:
    for name, up in {"a.dae": "Y_UP", "b.dae": "Z_UP", "c.dae": "X_UP"}.items():
        (tmp_path / name).write_bytes(document(asset=ASSET.format(1, up)))
    meshes = MeshFiles(tmp_path, {})
    for name in ("b.dae", "a.dae", "a.dae", "c.dae"):
        assert meshes.find(name) is not None
    (said,) = meshes.remark()
    assert "2 meshes such as a.dae say Y_UP and are turned z up" in said


def test_a_negative_scale_mirrors(tmp_path: Path) -> None:
    path = tmp_path / "link.dae"
    path.write_bytes(document())
    mirrored = Shape("mesh", np.array([1.0, -1.0, 1.0]), np.eye(4), 1, "link", mesh=path)
    (corners,) = hulls(mirrored)
    assert corners.min(axis=0) == pytest.approx([0, -2, 0])
    assert corners.max(axis=0) == pytest.approx([1, 0, 3])
