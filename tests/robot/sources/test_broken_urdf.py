"""Broken, odd and hostile robot files: each gets one sentence that names the place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, T_body_joint
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.sources import urdf
from elastocal.robot.sources.mesh_files import MeshFiles
from elastocal.robot.sources.urdf import LARGEST, from_urdf, parse_urdf

GOOD = """\
<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><mass value="3"/></inertial></link>
  <link name="lower">
    <visual><geometry><mesh filename="package://two/lower.stl"/></geometry></visual>
  </link>
  <link name="tip"/>
  <joint name="J1" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="J2" type="prismatic">
    <parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/>
    <axis xyz="0 0 -1"/>
    <limit lower="0" upper="0.2" effort="1" velocity="1"/>
  </joint>
  <joint name="end" type="fixed"><parent link="lower"/><child link="tip"/></joint>
</robot>
"""
J1_LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'
J2_LIMIT = '<limit lower="0" upper="0.2" effort="1" velocity="1"/>'
END = '<joint name="end" type="fixed"><parent link="lower"/><child link="tip"/></joint>'
LAUGHS = """<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;"><!ENTITY c "&b;&b;&b;">]>
<robot name="&c;"/>"""
OUTSIDE = '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r">&x;</robot>'

# what is edited: (old, new), or the whole text; what must be in the sentence
BROKEN: dict[str, tuple[str | tuple[str, str], list[str]]] = {
    "empty": ("", ["line 1", "not valid XML", "no element found"]),
    "not XML": ("hello", ["line 1, column 1", "not valid XML"]),
    "truncated": (GOOD[:400], ["not valid XML"]),
    "two roots": (GOOD + GOOD, ["line 22", "not valid XML"]),
    "entities in entities": (LAUGHS, ["line 1", "document type", "not accepted"]),
    "entity from outside": (OUTSIDE, ["line 1", "document type"]),
    "unknown entity": (('name="two"', 'name="&x;"'), ["line 1", "undefined entity"]),
    "unknown encoding": (
        '<?xml version="1.0" encoding="klingon"?>' + GOOD, ["line 1", "'klingon' is not known"]),
    "no encoding": (
        '<?xml version="1.0" encoding="idna"?>' + GOOD, ["line 1", "'idna' is not known"]),
    "no text": ('<?xml version="1.0" encoding="hex"?>' + GOOD, ["line 1", "'hex' is not known"]),
    "deep": ("<robot>" + "<a>" * 200, ["line 1", "nested more than 100 deep"]),
    "long": ("<robot>" + "<a/>" * 200_001, ["line 1", "more than 200000 elements"]),
    "not a robot": ("<sdf/>", ["line 1", "begins with <robot>", "<sdf>"]),
    "xacro inside": (("<link name=\"base\"/>", "<xacro:arm/>"), ["line 2", ".xacro"]),
    "xacro in a number": (('xyz="0.5 0 0"', 'xyz="${x} 0 0"'), ["line 16", "this is xacro"]),
    "no links": ('<robot name="r"/>', ["line 1", "no links"]),
    "no joints": ('<robot name="r"><link name="a"/></robot>', ["no joint moves", "'a'"]),
    "link without a name": (('<link name="tip"/>', "<link/>"), ["line 7", "<link> has no 'name'"]),
    "two links of one name": (
        ('<link name="tip"/>', '<link name="base"/>'), ["line 7", "two links", "'base'"]),
    "an axis twice": (('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><axis xyz="1 0 0"/>'),
        ["line 11", "a second <axis> in <joint>"]),
    "an origin twice": (('<origin xyz="0.5 0 0"/>', '<origin xyz="0.5 0 0"/><origin/>'),
        ["line 16", "a second <origin> in <joint>"]),
    "a limit twice": ((J1_LIMIT, 2 * J1_LIMIT), ["line 12", "a second <limit> in <joint>"]),
    "a mass twice": (("</inertial></link>", "</inertial><inertial/></link>"),
        ["line 3", "a second <inertial> in <link>"]),
    "two shapes at once": (('lower.stl"/>', 'lower.stl"/><sphere radius="1"/>'),
        ["line 5", "'lower' has more than one shape in <geometry>"]),
    "two joints of one name": (('name="J2"', 'name="J1"'), ["line 14", "two joints", "'J1'"]),
    "unknown type": (('type="prismatic"', 'type="spherical"'), ["line 14", "'spherical'"]),
    "no type": ((' type="prismatic"', ""), ["line 14", "type ''"]),
    "no parent": (('<parent link="base"/>', ""), ["line 8", "no <parent>"]),
    "two children": (
        ('<child link="upper"/>', '<child link="upper"/><child link="tip"/>'),
        ["line 8", "2 elements <child>"]),
    "unknown parent": (('<parent link="base"/>', '<parent link="bse"/>'), ["line 8", "'bse'"]),
    "two parents": (
        (END, END + END.replace("end", "more").replace("lower", "base")),
        ["line 20", "'tip'", "two joints", "'end'", "closed loops"]),
    "loop": (('<parent link="base"/>', '<parent link="tip"/>'), ["close a loop", "upper"]),
    "its own parent": (('<parent link="base"/>', '<parent link="upper"/>'), ["close a loop"]),
    "two bases": (('<parent link="base"/>', '<parent link="floor"/>'), ["line 8", "'floor'"]),
    "loose link": (('<link name="tip"/>', '<link name="tip"/><link name="x"/>'),
                   ["2 links have no parent (base, x)", "'base'"]),
    "several tips": (
        (END, END + '<link name="cam"/><joint name="c" type="fixed"><parent link="upper"/>'
         '<child link="cam"/></joint>'),
        ["2 ends", "cam", "tip", "'tip'"]),
    "no limits": ((J1_LIMIT, ""), ["line 8", "'J1'", "no lower and upper", "limits_deg"]),
    "half a limit": ((J1_LIMIT, '<limit lower="-2"/>'), ["line 8", "no lower and upper"]),
    "no limits of a slide": ((J2_LIMIT, ""), ["line 14", "'J2'", "limits_mm"]),
    "zero limits": ((J1_LIMIT, '<limit lower="0" upper="0"/>'), ["line 8", "no room"]),
    "limits turned round": ((J1_LIMIT, '<limit lower="2" upper="-2"/>'), ["line 8", "no room"]),
    "limits in degrees": ((J1_LIMIT, '<limit lower="-170" upper="170"/>'), ["line 8", "degrees"]),
    "limits in millimetres": ((J2_LIMIT, '<limit lower="0" upper="200"/>'), ["millimetres"]),
    "NaN in a limit": ((J1_LIMIT, '<limit lower="nan" upper="2"/>'), ["line 12", "'nan'"]),
    "infinite limit": ((J1_LIMIT, '<limit lower="-inf" upper="2"/>'), ["line 12", "'-inf'"]),
    "zero axis": (('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'), ["line 8", "'J1'", "0 0 0"]),
    "axis of two": (('<axis xyz="0 0 1"/>', '<axis xyz="0 1"/>'), ["line 11", "3 numbers"]),
    "commas": (('xyz="0 0 1" rpy', 'xyz="0,0,1" rpy'), ["line 10", "3 numbers"]),
    "decimal comma": (('xyz="0.5 0 0"', 'xyz="0,5 0 0"'), ["line 16", "decimal point"]),
    "NaN": (('xyz="0.5 0 0"', 'xyz="nan 0 0"'), ["line 16", "finite", "'nan'"]),
    "too large": (('xyz="0.5 0 0"', 'xyz="1e999 0 0"'), ["line 16", "finite"]),
    "millimetres": (('xyz="0.5 0 0"', 'xyz="500 0 0"'), ["reaches 500 m", "millimetres"]),
    "floating": (('type="revolute"', 'type="floating"'), ["line 8", "floating", "'upper'"]),
    "planar": (('type="revolute"', 'type="planar"'), ["line 8", "planar"]),
    "negative mass": (('value="3"', 'value="-3"'), ["line 3", "'upper'", "mass -3"]),
    "mass without a value": (('value="3"', ""), ["line 3", "<mass> has no 'value'"]),
    "no geometry": (
        ('<geometry><mesh filename="package://two/lower.stl"/></geometry>', ""),
        ["line 5", "no <geometry>"]),
}  # fmt: skip


def read(text: str | bytes, folder: Path | None = None, **names: str | dict[str, Path]) -> Robot:
    data = text.encode() if isinstance(text, str) else text
    return parse_urdf(data, "two.urdf", MeshFiles(folder or Path("/nowhere"), {}), **names)  # type: ignore[arg-type]


def edited(old: str, new: str) -> str:
    assert GOOD.count(old) == 1, old
    return GOOD.replace(old, new)


def test_the_good_one_is_read() -> None:
    robot = read(GOOD)
    assert robot.name == "two"
    assert robot.joint_names == ("J1", "J2")
    assert robot.joints[1].prismatic
    assert robot.lower == pytest.approx([-2, 0])
    assert [mass.body for mass in robot.masses] == [1]
    (shape,) = robot.visuals
    assert (shape.kind, shape.body, shape.mesh) == ("mesh", 2, None)
    assert shape.source == "package://two/lower.stl"
    assert robot.remarks == (
        "1 of 1 meshes were not found, such as package://two/lower.stl: "
        "no folder is named for package 'two' (packages: {two: folder})",
    )


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_gets_its_sentence(what: str) -> None:
    edit, expected = BROKEN[what]
    with pytest.raises(InputError) as caught:
        read(edit if isinstance(edit, str) else edited(*edit))
    message = str(caught.value)
    assert message.startswith("two.urdf")
    assert "\n" not in message
    assert len(message) < 300
    for words in expected:
        assert words in message


def test_of_many_ends_the_one_behind_most_joints_is_named_first() -> None:
    """Before frames that are fixed and rods that follow: those seldom carry a tool."""
    frames = "".join(
        f'<link name="frame{i}"/><joint name="f{i}" type="fixed"><parent link="base"/>'
        f'<child link="frame{i}"/></joint>'
        for i in range(7)
    )
    rods = "".join(
        f'<link name="{name}"/><joint name="{name}" type="continuous"><parent link="upper"/>'
        f'<child link="{name}"/><mimic joint="J2"/></joint>'
        for name in ("rod", "ram")
    )
    with pytest.raises(InputError) as caught:
        read(GOOD.replace('<link name="base"/>', '<link name="base"/>' + frames + rods))
    wanted = "10 ends (tip, rod, ram, frame0, frame1, frame2 and 4 more)"
    assert wanted in str(caught.value)


LATIN = '<?xml version="1.0" encoding="{}"?>\n' + GOOD.replace('"two"', '"{}"')
NAMES = {
    "ISO-8859-1": "Prüfstand",
    "windows-1252": "Prüfstand",
    "gb2312": "机器人",
    "Shift_JIS": "ロボット",
    "UTF-8": "Робот",
    "utf-16": "Робот",
    "utf-32": "机器人",
}


@pytest.mark.parametrize("encoding", NAMES)
def test_a_file_is_read_in_the_encoding_it_declares(encoding: str) -> None:
    text = LATIN.format(encoding, NAMES[encoding])
    assert read(text.encode(encoding)).name == NAMES[encoding]


@pytest.mark.parametrize(
    "data",
    [
        GOOD.encode("utf-8-sig"),
        LATIN.format("UTF-8", "two").encode("utf-8-sig"),
        LATIN.format("UTF-8", "two").encode("utf-16"),  # as editors save what was UTF-8
        LATIN.format("utf-16", "two").encode("utf-16-le"),
        GOOD.encode("utf-16-be"),
    ],
)
def test_byte_order_marks_go_before_what_is_declared(data: bytes) -> None:
    assert read(data).joint_names == ("J1", "J2")


def test_bytes_that_are_not_of_the_encoding_are_named_with_their_line() -> None:
    data = GOOD.replace('"upper"', '"über"').encode("latin-1")
    with pytest.raises(InputError, match=r"line 3: byte 0xFC is not UTF-8, .* taken to be; save"):
        read(data)
    with pytest.raises(InputError, match=r"line 2: byte 0xFF is not GB2312, .* said to be; mend"):
        read(b'<?xml version="1.0" encoding="gb2312"?>\n\xff' + GOOD.encode())


@pytest.mark.parametrize(
    "useless",
    [
        '<axis xzy="0 0 1"/>',
        '<axis xyz="0 1"/>',
        '<axis xyz="nan nan nan"/>',
        '<limit lower="a" upper=""/><dynamics damping="much"/>',
        "<mimic/>",
    ],
)
def test_what_means_nothing_for_a_fixed_joint_is_not_looked_at(useless: str) -> None:
    robot = read(edited(END, END.replace("<parent", f"{useless}<parent")))
    assert robot.joint_names == ("J1", "J2")
    assert forward_kinematics(robot, np.zeros((1, 2))) == pytest.approx(
        forward_kinematics(read(GOOD), np.zeros((1, 2)))
    )


def test_limits_of_an_endless_joint_mean_nothing() -> None:
    endless = edited('type="revolute"', 'type="continuous"').replace("-2", "none")
    assert np.isinf(read(endless).joints[0].upper)


def test_names_of_base_and_tip_that_are_not_there() -> None:
    with pytest.raises(InputError, match="no link 'bsae' for 'base'; did you mean 'base'"):
        read(GOOD, base="bsae")
    with pytest.raises(InputError, match="no link 'tool0' for 'tip'; the links are base, upper"):
        read(GOOD, tip="tool0")
    with pytest.raises(InputError, match="tip 'base' does not hang on base 'lower'"):
        read(GOOD, base="lower", tip="base")
    with pytest.raises(InputError, match="no joint moves between base 'lower' and tip 'tip'"):
        read(GOOD, base="lower")


def test_limits_from_outside_replace_those_of_the_file() -> None:
    text = edited(J1_LIMIT, "")
    assert read(text, limits={"J1": (-1.0, 0.5)}).upper == pytest.approx([0.5, 0.2])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no joint 'J7' to limit; the joints are J1, J2"):
        read(GOOD, limits={"J7": (0, 1)})  # type: ignore[arg-type]


def test_a_slide_without_end_may_be_left_behind() -> None:
    with pytest.raises(InputError, match="limits_mm beside it, or choose a 'base' behind it, such"):
        read(edited(J2_LIMIT, '<limit lower="-999999" upper="999999"/>'))


SOFT = '<safety_controller k_velocity="1" soft_lower_limit="{}" soft_upper_limit="{}"/>'


def test_limits_that_a_controller_keeps_within_the_others_are_said() -> None:
    text = edited(J1_LIMIT, J1_LIMIT + SOFT.format("-1.5", "1.57079632679"))
    text = text.replace(J2_LIMIT, J2_LIMIT + SOFT.format("0.01", "0.2"))
    robot = read(text)
    assert robot.upper == pytest.approx([2, 0.2])
    assert robot.remarks[0].startswith(
        "its safety_controller keeps J1 -85.9437 to 90°, J2 10 to 200 mm; planned with are the "
    )
    limited = read(text, limits={"J1": (-1.0, 0.5)})  # type: ignore[arg-type]
    assert limited.remarks[0].startswith("its safety_controller keeps J2 10 to 200 mm;")


@pytest.mark.parametrize(
    "soft", [SOFT.format("-2", "2"), SOFT.format("0", "0"), SOFT.format("-170", "170")]
)
def test_soft_limits_that_keep_nothing_back_are_not_said(soft: str) -> None:
    assert not any("safety" in said for said in read(edited(J1_LIMIT, J1_LIMIT + soft)).remarks)
    bare = '<safety_controller k_velocity="1"/>'
    assert read(edited(J1_LIMIT, J1_LIMIT + bare)).remarks == read(GOOD).remarks


@pytest.mark.parametrize(
    ("soft", "said"),
    [
        (SOFT.format(1, -1), "has soft_lower_limit 1 and soft_upper_limit -1, between which it"),
        (SOFT.format(1, 1), "has soft_lower_limit 1 and soft_upper_limit 1, between which it"),
        ('<safety_controller soft_lower_limit="1"/>', "has soft_lower_limit 1 and soft_upper"),
        (SOFT.format(2.5, 4), "keeps it from 2.5 to 4, outside its limits -2 to 2; these are not"),
    ],
)
def test_soft_limits_without_room_are_said(soft: str, said: str) -> None:
    text = edited(J1_LIMIT, J1_LIMIT + soft)
    robot = read(text)
    assert (robot.lower[0], robot.upper[0]) == (-2, 2)
    (remark,) = (remark for remark in robot.remarks if "safety_controller" in remark)
    assert f": joint 'J1': its safety_controller {said}" in remark
    limited = read(text, limits={"J1": (-1.0, 0.5)})  # type: ignore[arg-type]
    assert not any("safety" in remark for remark in limited.remarks)


def test_joints_without_end_have_no_limits() -> None:
    text = edited('type="revolute"', 'type="continuous"').replace(J1_LIMIT, "")
    assert np.isinf(read(text).joints[0].lower)
    huge = read(edited(J1_LIMIT, '<limit lower="-1e16" upper="1e16"/>'))
    assert np.isinf(huge.joints[0].upper)
    assert "taken as none" in huge.remarks[0]


def test_a_long_axis_is_said_and_used_by_its_direction() -> None:
    robot = read(edited('<axis xyz="0 0 -1"/>', '<axis xyz="0 0 -2"/>'))
    assert robot.joints[1].axis == pytest.approx([0, 0, -1])
    assert "axis has length 2" in robot.remarks[0]


def test_what_is_off_the_chain_is_carried_and_said() -> None:
    finger = (
        '<link name="finger"><inertial><origin xyz="0 0 0.1"/><mass value="0.5"/></inertial></link>'
        '<joint name="grip" type="prismatic"><parent link="tip"/><child link="finger"/>'
        '<origin xyz="0 0.2 0"/><axis xyz="0 0 0"/><mimic joint="end"/></joint>'
    )
    robot = read(edited(END, END + finger), tip="tip")
    grip = robot.masses[1]
    assert (grip.name, grip.body) == ("finger", 2)
    place = Posture(robot, np.array([[0.0, 0.1]])).point(grip.center, grip.body)
    assert place[:, 0] == pytest.approx([0.5, 0.2, 1.0])
    assert "grip: not between 'base' and 'tip', held at zero" in robot.remarks


def test_a_base_in_the_middle_carries_what_is_before_it() -> None:
    heavy = GOOD.replace('<link name="base"/>', GOOD.splitlines()[2].replace("upper", "base"))
    robot = read(heavy, base="upper")
    assert robot.joint_names == ("J2",)
    assert [(m.name, m.body) for m in robot.masses] == [("base", 0), ("upper", 0)]
    assert robot.masses[0].center == pytest.approx([0, 0, -1])
    assert "J1: not between 'upper' and 'tip', held at zero" in robot.remarks


def test_shapes_of_every_kind_are_kept_and_unknown_ones_said() -> None:
    mesh = '<geometry><mesh filename="package://two/lower.stl"/></geometry>'
    capsule = '<geometry><capsule radius="0.1" length="0.4"/></geometry><material name="red"/>'
    red = '<material name="red"><color rgba="1 0 0 1"/></material></robot>'
    (shape,) = read(edited(mesh, capsule).replace("</robot>", red)).visuals
    assert (shape.kind, shape.color) == ("capsule", (1.0, 0.0, 0.0, 1.0))
    assert shape.size == pytest.approx([0.1, 0.4])
    robot = read(edited(mesh, '<geometry><cone radius="1"/></geometry>'))
    assert robot.visuals == ()
    assert "line 5: <cone> of link 'lower' is left out: known are box" in robot.remarks[0]
    robot = read(edited(mesh, '<geometry><box size="1 0 1"/></geometry>'))
    assert "line 5: <box> of link 'lower' is left out: it has no size" in robot.remarks[0]
    robot = read(edited(mesh, '<geometry><box size="80 120 9"/></geometry>'))
    assert "line 5: <box> of link 'lower' measures 120 m; were millimetres" in robot.remarks[0]


@pytest.mark.parametrize(
    ("reference", "why"),
    [
        ("package://two/lower.stl", "no folder is named for package 'two'"),
        ("missing.stl", "there is no such file"),
        ("../secret.stl", "outside the folder"),
        ("/etc/passwd", "outside the folder"),
        ("file:///etc/passwd", "outside the folder"),
        ("package://arm/../../secret.stl", "outside the folder"),
        ("link.stl", "outside the folder"),
        ("https://example.org/lower.stl", "https:// is not looked up"),
        ("a" * 5000, "it is no name of a file"),
    ],
)
def test_meshes_are_looked_for_in_named_folders_only(
    tmp_path: Path, reference: str, why: str
) -> None:
    (tmp_path / "secret.stl").write_text("solid")
    inside = tmp_path / "robot"
    (inside / "arm").mkdir(parents=True)
    (inside / "link.stl").symlink_to(tmp_path / "secret.stl")
    meshes = MeshFiles(inside, {"arm": inside / "arm"})
    assert meshes.find(reference) is None
    assert why in meshes.remark()[0]


def test_meshes_are_found_beside_the_file_and_in_packages(tmp_path: Path) -> None:
    folder, package = tmp_path / "robot", tmp_path / "arm"
    for place in (folder, package / "meshes"):
        place.mkdir(parents=True)
        (place / "a.stl").write_text("solid")
    meshes = MeshFiles(folder, {"arm": package})
    assert meshes.find("a.stl") == folder / "a.stl"
    assert meshes.find("package://arm/meshes/a.stl") == package / "meshes" / "a.stl"
    assert meshes.find(f"file://{package}/meshes/a.stl") == package / "meshes" / "a.stl"
    assert meshes.remark() == []
    with pytest.raises(InputError, match=r"package 'leg': the folder .*nowhere does not exist"):
        MeshFiles(folder, {"leg": tmp_path / "nowhere"})


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.urdf: no such file"):
        from_urdf(tmp_path / "none.urdf")
    with pytest.raises(InputError, match="cannot be read"):
        from_urdf(tmp_path)
    huge = tmp_path / "huge.urdf"
    with huge.open("wb") as file:
        file.truncate(LARGEST + 1)
    with pytest.raises(InputError, match="more than the 10485760 that are read"):
        from_urdf(huge)


@pytest.mark.parametrize("form", ["wide", "deep"])
@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_many_links_are_placed_by_their_bodies(
    form: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is computed once for a body is not computed for each of its links."""
    count, calls = 2000, []
    above = ["lower", *(f"x{i}" for i in range(count))] if form == "deep" else ["lower"] * count
    more = "".join(
        f'<link name="x{i}"><inertial><mass value="1"/></inertial></link><joint name="f{i}" '
        f'type="{kind}"><parent link="{above[i]}"/><child link="x{i}"/></joint>'
        for i in range(count)
    )

    def counted(robot: Robot, body: int) -> Array:
        calls.append(body)
        return T_body_joint(robot, body)

    monkeypatch.setattr(urdf, "T_body_joint", counted)
    robot = read(edited(END, END + more), tip="tip")
    assert len(robot.masses) == count + 1
    assert calls == list(range(robot.bodies))


def test_more_joints_than_are_treated_are_refused() -> None:
    links = "".join(f'<link name="x{i}"/>' for i in range(1002))
    rows = "".join(
        f'<joint name="f{i}" type="continuous"><parent link="x{i}"/>'
        f'<child link="x{i + 1}"/></joint>'
        for i in range(1001)
    )
    with pytest.raises(InputError, match="1001 joints that move, more than the 1000"):
        read(f'<robot name="r">{links}{rows}</robot>')


def test_a_long_row_of_digits_is_refused_at_once() -> None:
    with pytest.raises(InputError, match="finite numbers, found '1111"):
        read(edited('xyz="0.5 0 0"', f'xyz="{"1" * 1_000_000}x 0 0"'))


def sound(robot: Robot) -> bool:
    """Whether the robot can be placed."""
    return bool(np.isfinite(forward_kinematics(robot, np.zeros((1, len(robot.joints))))).all())


@given(st.binary(max_size=300))
def test_any_bytes_give_a_robot_or_a_sentence(data: bytes) -> None:
    try:
        assert sound(read(data))
    except InputError as error:
        assert str(error).startswith("two.urdf")  # noqa: PT017


TOKENS = st.sampled_from(
    [*GOOD.replace("<", " <").split(), '"', "<", "/>", "nan", "-1e308", "\x00", "é", "&amp;", "]]>"]
)


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, len(GOOD)), st.integers(0, 40), st.lists(TOKENS, max_size=4))
def test_a_spoilt_file_gives_a_robot_or_a_sentence(
    start: int, length: int, words: list[str]
) -> None:
    spoilt = GOOD[:start] + " ".join(words) + GOOD[start + length :]
    try:
        assert sound(read(spoilt))
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
