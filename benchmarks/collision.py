"""What collision costs: the same study planned with and without it, in one run.

    python benchmarks/collision.py [--rounds 3]

First what a study watches that says nothing, the robot itself and the floor, over switched off.
Then a KR 270 before a tracker that must see it, with a cone of loads, among a table, a wall and a
round column, a mesh and links of meshes, over the same without clearances and line of sight. Then
cells around the KR 270 alone: capsules along its chain among boxes; the same with a cylinder and a
mesh; links that are meshes. Then a UR5 with the meshes of its description, close over its table.
Processor time, so that other work on the machine matters less.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.constraints import Clearance, HalfSpace, LineOfSight
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.cores import several_cores, usable_cores
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.files.study.study_file import read_study
from elastocal.measuring.instrument import Isotropic
from elastocal.planning.plan import plan
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.shapes import Shape
from elastocal.study.study import Experiments, Study, test_pose

ROOT = Path(__file__).parents[1]


def boxes() -> list[Shape]:
    """A table and a wall."""
    return [
        Shape("box", np.array([1.2, 1.6, 0.7]), transform(None, (1.7, 0.0, 0.35)), 0, "table"),
        Shape("box", np.array([5.0, 0.1, 3.0]), transform(None, (0.0, 1.5, 1.5)), 0, "wall"),
    ]


def round_things(folder: Path) -> list[Shape]:
    """A post, and a tank as a mesh of 642 corners."""
    import trimesh

    trimesh.creation.icosphere(3, 600.0).export(folder / "tank.stl")
    post = Shape("cylinder", np.array([0.2, 3.0]), transform(None, (-1.4, 0.6, 1.5)), 0, "post")
    tank = transform(None, (1.2, -1.8, 0.9))
    return [post, Shape("mesh", np.full(3, 1e-3), tank, 0, "tank", folder / "tank.stl")]


def with_meshes(robot: Robot, folder: Path) -> Robot:
    """The robot with a mesh of some 200 corners around every link of its chain."""
    import trimesh

    shapes = []
    for body in (1, 2, 4):
        end = np.array(robot.links[body][:3, 3])
        length = float(np.linalg.norm(end))
        mesh = trimesh.creation.capsule(height=length, radius=0.16, count=[16, 16])
        mesh.apply_translation([0.0, 0.0, length / 2.0 - mesh.bounds.mean(axis=0)[2]])
        mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], end / length))
        mesh.export(folder / f"link{body}.stl")
        shapes.append(
            Shape("mesh", np.ones(3), np.eye(4), body, f"link {body}", folder / f"link{body}.stl")
        )
    return replace(robot, collisions=tuple(shapes))


def ur5() -> Study:
    """A UR5 with its meshes, weights of 5 kg."""
    from importlib.metadata import files

    from elastocal.robot.sources.urdf import from_urdf

    names = {str(f): Path(str(f.locate())) for f in files("example-robot-data") or ()}
    urdf = next(
        path for name, path in names.items() if name.endswith("ur5_joint_limited_robot.urdf")
    )
    robot = from_urdf(urdf, tip="tool0", packages={"example-robot-data": urdf.parents[3]})
    springs = joint_springs(robot, list(robot.joint_names[1:]))
    bracket = Tool("bracket", np.array([0.09, 0, 0.12]), np.array([[0.09, 0, 0.12]]), ("M1",))
    home = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
    wrench = np.array([[0.0, 0.0, -50.0, 0.0, 0.0, 0.0]])
    task = np.radians([20.0, -75.0, 100.0, -115.0, -90.0, 10.0])
    pose = test_pose(
        ElasticArm(robot, springs, bracket), LoadCases(task[None], wrench), 1.0, "task"
    )
    experiments = Experiments(bracket, FixedVector(wrench[0, :3]), 12, 6)
    low = HalfSpace("height of M1 >= 100 mm", bracket.load_point, [0.0, 0.0, 1.0], 0.1)
    study = Study(robot, springs, (pose,), experiments, Isotropic(3e-5), (low,))
    return replace(study, pace=replace(study.pace, home=home))


def before_a_tracker(folder: Path) -> dict[str, Study]:
    """A study without its cell, with it, with a tank, and with links that are meshes, too."""
    text = (ROOT / "benchmarks" / "cells" / "column.yaml").read_text(encoding="utf-8")
    _, tank = round_things(folder)
    centre = (1e3 * tank.pose[:3, 3]).tolist()
    name = f"    - {{name: tank, mesh: tank.stl, mesh_unit: mm, center_mm: {centre}}}\n"
    found = {}
    for what, cell in (
        ("cell", text),
        ("... and tank", text.replace("\nmotion", name + "\nmotion")),
    ):
        (folder / "study.yaml").write_text(cell, encoding="utf-8")
        found[what] = read_study(folder / "study.yaml")
    study = found["cell"]
    unseen = [c for c in study.constraints if not isinstance(c, Clearance | LineOfSight)]
    plain = replace(study, constraints=tuple(unseen))
    seen = [c for c in study.constraints if isinstance(c, LineOfSight)]
    meshes = with_cell(plain, with_meshes(study.robot, folder), [*boxes(), *round_things(folder)])
    meshes = replace(meshes, constraints=(*meshes.constraints, *seen))
    return {"tracker and cone, without": plain, **found, "... and links as meshes": meshes}


def with_cell(study: Study, robot: Robot, obstacles: Sequence[Shape]) -> Study:
    """The study with clearances."""
    tool = study.experiments.tool
    found = clearances(robot, tool, study.limits, obstacles, CollisionRules())
    return replace(study, constraints=(*study.constraints, *found))


def seconds(study: Study, rounds: int) -> tuple[float, float]:
    """Median processor time to plan [s], and ρ0 [m] of the last plan."""
    times = []
    for seed in range(rounds):
        start = time.process_time()
        made = plan(study, seed=seed)
        times.append(time.process_time() - start)
    return float(np.median(times)), made.assessment.rho0


def by_the_clock(study: Study, workers: int) -> tuple[float, float]:
    """Time to plan by the clock with so many processes [s], and ρ0 [m]."""
    with several_cores(workers):
        start = time.perf_counter()
        made = plan(study)
        return time.perf_counter() - start, made.assessment.rho0


def main() -> None:
    """Print one line for every cell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    watched = read_study(ROOT / "examples" / "kr270" / "study.yaml")
    plain = tuple(c for c in watched.constraints if not isinstance(c, Clearance))
    study = replace(watched, constraints=plain)
    with tempfile.TemporaryDirectory() as name:
        cells = before_a_tracker(Path(name))
        base = 0.0
        for what, cell in cells.items():
            found, rho0 = seconds(cell, rounds)
            base = base or found
            print(f"{what:34} {found:6.2f} s  {found / base:5.2f}×  ρ0 {1e6 * rho0:.3f} µm")
    base, rho0 = seconds(study, rounds)
    print(f"{'without':34} {base:6.2f} s          ρ0 {1e6 * rho0:.3f} µm")
    found, rho0 = seconds(watched, rounds)
    print(f"{'by default':34} {found:6.2f} s  {found / base:5.2f}×  ρ0 {1e6 * rho0:.3f} µm")
    home = np.radians([0.0, -120.0, 120.0, 0.0, 0.0, 0.0])
    study = replace(study, pace=replace(study.pace, home=home))
    base, rho0 = seconds(study, rounds)
    print(f"{'without, from another home':34} {base:6.2f} s          ρ0 {1e6 * rho0:.3f} µm")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, robot, obstacles in (
            ("capsules, itself only", study.robot, []),
            ("capsules, table, wall", study.robot, boxes()),
            ("... and post and tank", study.robot, [*boxes(), *round_things(folder)]),
            ("links as meshes, table, wall", with_meshes(study.robot, folder), boxes()),
        ):
            found, rho0 = seconds(with_cell(study, robot, obstacles), rounds)
            print(f"{what:34} {found:6.2f} s  {found / base:5.2f}×  ρ0 {1e6 * rho0:.3f} µm")
    cobot = ur5()
    base, rho0 = seconds(cobot, rounds)
    print(f"{'UR5 without':34} {base:6.2f} s          ρ0 {1e6 * rho0:.3f} µm")
    table = Shape("box", np.array([1.6, 1.6, 0.05]), transform(None, (0, 0, -0.03)), 0, "table")
    crowded = with_cell(cobot, cobot.robot, [table])
    found, rho0 = seconds(crowded, rounds)
    print(f"{'UR5, meshes, table':34} {found:6.2f} s  {found / base:5.2f}×  ρ0 {1e6 * rho0:.3f} µm")
    all_cores = usable_cores()
    (alone, one), (together, other) = (by_the_clock(crowded, n) for n in (1, all_cores))
    same = "the same plan" if one == other else "ANOTHER PLAN"
    print(f"{f'... by the clock, {all_cores} cores':34} {together / alone:5.2f}× of one, {same}")


if __name__ == "__main__":
    main()
