"""xacro files: expanded apart, within named folders and a limit on time."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastocal.errors import InputError
from elastocal.robot.sources import xacro_text
from elastocal.robot.sources.urdf import from_urdf

HEAD = '<robot name="{}" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MACRO = HEAD.format("parts") + (
    '<xacro:macro name="turn" params="n below above z">'
    '<link name="${above}"/><joint name="J${n}" type="revolute">'
    '<parent link="${below}"/><child link="${above}"/><origin xyz="0 0 ${z / 1000}"/>'
    '<axis xyz="0 0 1"/><limit lower="${-pi}" upper="${pi}" effort="1" velocity="1"/></joint>'
    "</xacro:macro></robot>"
)
ARM = HEAD.format("arm") + (
    '<xacro:include filename="{}"/><link name="base"/>'
    '<xacro:turn n="1" below="base" above="a" z="500"/>'
    '<xacro:turn n="2" below="a" above="b" z="250"/></robot>'
)


def arm(folder: Path, include: str) -> Path:
    (folder / "robot").mkdir(exist_ok=True)
    path = folder / "robot" / "arm.xacro"
    path.write_text(ARM.replace("{}", include))
    return path


def test_macros_are_expanded(tmp_path: Path) -> None:
    path = arm(tmp_path, "parts.xacro")
    (tmp_path / "robot" / "parts.xacro").write_text(MACRO)
    robot = from_urdf(path)
    assert (robot.name, robot.joint_names) == ("arm", ("J1", "J2"))
    assert robot.joints[0].T_parent_joint[2, 3] == pytest.approx(0.5)


def test_packages_are_found_where_they_are_named(tmp_path: Path) -> None:
    path = arm(tmp_path, "$(find parts)/parts.xacro")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "parts.xacro").write_text(MACRO)
    assert from_urdf(path, packages={"parts": tmp_path / "parts"}).joint_names == ("J1", "J2")
    with pytest.raises(
        InputError, match=r"arm\.xacro: no folder is named for package 'parts'; give"
    ):
        from_urdf(path)


def test_nothing_is_included_from_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "parts.xacro").write_text(MACRO)
    with pytest.raises(InputError, match=r"includes .*parts\.xacro, which is outside its folder"):
        from_urdf(arm(tmp_path, "../parts.xacro"))


def test_what_cannot_be_expanded_is_refused_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "bad.xacro"
    path.write_text(HEAD.format("bad") + '<link name="${nothing}"/></robot>')
    with pytest.raises(
        InputError, match=r"bad\.xacro: xacro cannot expand it: .*nothing"
    ) as caught:
        from_urdf(path)
    assert "\n" not in str(caught.value)


def test_what_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "slow.xacro"
    path.write_text(HEAD.format("slow") + "${[0 for i in range(10**10)]}</robot>")
    monkeypatch.setattr(xacro_text, "_SECONDS", 0.5)
    with pytest.raises(InputError, match=r"slow\.xacro: expanding it takes more than 0\.5 s"):
        from_urdf(path)


def test_without_the_package_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xacro_text, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'elastocal\[xacro\]'"):
        from_urdf(arm(tmp_path, "parts.xacro"))


ARGUED = HEAD.format("$(arg name)") + (
    '<xacro:arg name="name" default="arm"/><xacro:arg name="prefix" default=""/>'
    '<xacro:include filename="parts.xacro"/><link name="base"/>'
    '<xacro:turn n="1" below="base" above="$(arg prefix)a" z="${1000 * $(arg reach_m)}"/></robot>'
)


def argued(folder: Path) -> Path:
    path = folder / "argued.xacro"
    path.write_text(ARGUED)
    (folder / "parts.xacro").write_text(MACRO)
    return path


def test_arguments_are_handed_on(tmp_path: Path) -> None:
    given = {"name": "long", "prefix": "left_", "reach_m": "0.6"}
    robot = from_urdf(argued(tmp_path), arguments=given)
    assert robot.name == "long"
    assert robot.joints[0].T_parent_joint[2, 3] == pytest.approx(0.6)
    assert "expanded with arguments name: long, prefix: left_, reach_m: 0.6" in robot.remarks
    other = from_urdf(argued(tmp_path), arguments=given | {"reach_m": "0.7"})
    assert other.sha256 != robot.sha256


def test_an_argument_that_is_missing_is_named_with_the_ways_out(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"argument 'reach_m' has no value; .*reach_m: ….*or") as e:
        from_urdf(argued(tmp_path), arguments={"name": "arm"})
    assert "xacro argued.xacro reach_m:=… > argued.urdf" in str(e.value)


def test_an_argument_that_nothing_asks_for_is_refused(tmp_path: Path) -> None:
    given = {"name": "arm", "reach_m": "1"}
    with pytest.raises(InputError, match=r"no xacro argument 'prefx'; did you mean 'prefix'"):
        from_urdf(argued(tmp_path), arguments=given | {"prefx": "a"})
    with pytest.raises(InputError, match=r"argument 'zzz'; it has name, prefix, reach_m"):
        from_urdf(argued(tmp_path), arguments=given | {"zzz": "a"})
    path = tmp_path / "plain.xacro"
    path.write_text(HEAD.format("plain") + '<link name="a"/></robot>')
    with pytest.raises(InputError, match=r"argument 'zzz'; it has none"):
        from_urdf(path, arguments={"zzz": "a"})
    urdf = tmp_path / "plain.urdf"
    urdf.write_text('<robot name="plain"/>')
    with pytest.raises(InputError, match=r"arguments are for xacro files"):
        from_urdf(urdf, arguments={"zzz": "a"})


def test_the_cause_is_said_and_not_what_was_evaluated_around_it(tmp_path: Path) -> None:
    path = tmp_path / "bad.xacro"
    path.write_text(
        HEAD.format("bad")
        + '<xacro:property name="speeds" value="${xacro.load_yaml(\'speeds.yaml\')}"/>'
        + "<link name=\"${radians(speeds['j1'])}\"/></robot>"
    )
    with pytest.raises(InputError, match=r"No such file or directory: 'speeds\.yaml'") as caught:
        from_urdf(path)
    assert "radians" not in str(caught.value)


def test_a_file_of_macros_is_named_as_such(tmp_path: Path) -> None:
    path = tmp_path / "parts.xacro"
    path.write_text(MACRO)
    with pytest.raises(InputError, match=r"only defines macros \(turn\) .* file that calls them"):
        from_urdf(path)


@pytest.mark.parametrize("prefix", ["", "file://", "file:///"])
def test_the_hash_does_not_depend_on_where_the_files_are(tmp_path: Path, prefix: str) -> None:
    file = f"{prefix}$(find parts)/a.stl"
    mesh = f'<visual><geometry><mesh filename="{file}"/></geometry></visual>'
    found = []
    for place in ("here", "there"):
        folder = tmp_path / place
        (folder / "parts").mkdir(parents=True)
        (folder / "parts" / "parts.xacro").write_text(MACRO)
        (folder / "parts" / "a.stl").write_text("solid")
        path = arm(folder, "$(find parts)/parts.xacro")
        path.write_text(path.read_text().replace('"base"/>', f'"base">{mesh}</link>', 1))
        found.append(from_urdf(path, packages={"parts": folder / "parts"}))
        assert found[-1].visuals[0].mesh == folder / "parts" / "a.stl"
    assert found[0].sha256 == found[1].sha256


def test_a_comment_names_no_package(tmp_path: Path) -> None:
    path = arm(tmp_path, "parts.xacro")
    (tmp_path / "robot" / "parts.xacro").write_text(MACRO)
    path.write_text(path.read_text().replace("</robot>", "<!-- $(find nowhere) --></robot>"))
    assert from_urdf(path).joint_names == ("J1", "J2")


def test_xacro_in_an_argument_is_told_as_that(tmp_path: Path) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text(
        HEAD.format("arm")
        + '<xacro:arg name="x" default="0"/><link name="a"/><link name="b"/>'
        + '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        + '<origin xyz="$(arg x) 0 0"/><axis xyz="0 0 1"/>'
        + '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    assert from_urdf(path, arguments={"x": "0.5"}).joints[0].T_parent_joint[0, 3] == 0.5
    with pytest.raises(InputError, match=r"this is xacro, expanded in files .* not in arguments"):
        from_urdf(path, arguments={"x": "${0.5}"})
