"""What `simulate` does with studies of absolute readings.

Imported by the command when it runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.cli.common import print_json, replaceable, writable
from elastocal.cli.inputs import only_proposal
from elastocal.errors import InputError
from elastocal.files.measurements.positions_writing import write_positions
from elastocal.files.models.model_file import read_model
from elastocal.files.models.true_arm import (
    TRUE_COMPENSATORS,
    true_compensators_in,
    true_frames_in,
)
from elastocal.files.models.true_frames import true_frames_section
from elastocal.files.models.writing import write_model
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.files.study.study_file import read_study
from elastocal.measuring.instrument import tracker_of
from elastocal.measuring.positions import Positions
from elastocal.measuring.single_readings import reading_covariance, turn_covariance
from elastocal.robot.chain import transform
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements
from elastocal.simulation.true_compensators import drawn_stiffness
from elastocal.simulation.virtual_campaign import Outliers
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.study import Study
from elastocal.wording.lists import counted

_OFF = 3e-4  # m, rad: frames from where they are drawn, what calibrations of industrial arms find
_MOUNTED = 1e-3  # m: reflectors from where they are thought to be
_AWAY = 3.0  # m: a tracker whose place nobody says


def simulate_positions(
    study_file: Path,
    plans: list[Path],
    truth: Path,
    out: Path,
    truth_out: Path | None,
    outliers: Outliers,
    seed: int,
    refused: Mapping[str, object],
    *,
    force: bool,
    as_json: bool,
) -> None:
    """Read a plan on an arm whose frames are off, and write positions.csv."""
    for option, value in refused.items():
        if value:
            raise InputError(f"{option} does not go with absolute readings")
    study, to_plan = read_absolute_study(study_file), read_study(study_file)
    writable(out, study_file, truth, *plans, suffix=".csv")
    replaceable(out, "positions", force=force)
    model, robot = read_model(truth, study.robot), study.robot
    frames = true_frames_in(truth, robot)
    kept = None
    if frames is None:
        frames = drawn_displacements(robot, _OFF, _OFF, np.random.default_rng([seed, 1]))
        kept = truth_out or out.with_name(f"{out.stem}_truth.json")
        writable(kept, study_file, truth, *plans, out, suffix=".json")
        replaceable(kept, "model", force=force)
    elif truth_out is not None:
        raise InputError(f"{truth_out}: nothing is drawn, {truth} says all of the robot")
    plan = only_proposal(plans, to_plan)
    which = np.repeat(np.arange(len(plan.load_cases)), plan.repeats)
    cases = plan.load_cases.chosen(which)
    carried, wrench = _carried(study, to_plan, cases.wrench)
    held = true_compensators_in(truth, [one.name for one in study.compensators])
    if held is None:
        if kept is None and study.compensators:
            raise InputError(
                f"{truth}: says how frames stand, but not {TRUE_COMPENSATORS}, the stiffness of "
                f"{', '.join(one.name for one in study.compensators)}"
            )
        held = drawn_stiffness(study, np.random.default_rng([seed, 2]))
    arm = TrueArm(
        robot,
        frames,
        model.springs,
        model.compliance,
        study.gravity,
        study.payloads,
        tuple((one, held[one.name]) for one in study.compensators),
    )
    rng = np.random.default_rng(seed)
    turned = float(np.sqrt(turn_covariance(study.instrument)[0, 0])) if study.tool.rotation else 0.0
    made = simulated_positions(
        AbsoluteTruth(arm, _mounted(study, rng), (TrueStation(_standing(study, rng)),)),
        study.tool,
        Visits(cases.q, wrench, carried),
        rng,
        covariance=partial(reading_covariance, study.instrument),
        turned=turned,
        outliers=outliers,
    )
    write_positions(made, robot, out)
    if kept is not None:
        sections: dict[str, Any] = {"true_frames": true_frames_section(frames, robot)}
        if held:
            sections[TRUE_COMPENSATORS] = {name: k / 1e3 for name, k in held.items()}
        write_model(model, kept, robot, sections=sections)
    _say(made, out, kept, as_json=as_json)


def _carried(study: AbsoluteStudy, to_plan: Study, wrench: Array) -> tuple[IntArray, Array]:
    """(N,) what hangs on the flange in each case, and (N, 6) what acts besides."""
    names = [load.name for load in study.payloads]
    always = to_plan.experiments.payload
    carried = np.full(len(wrench), -1 if always is None else names.index(always.name))
    rest = np.array(wrench)
    for i, load in enumerate(study.payloads):
        weight = np.append(load.mass * study.gravity, np.zeros(3))
        mine = np.abs(wrench - weight).max(axis=1) < 1e-6 * max(1.0, float(np.abs(weight).max()))
        if always is None and weight.any():
            carried[mine], rest[mine] = i, 0.0
    if rest.any():
        force = ", ".join(f"{value:.6g}" for value in rest[rest.any(axis=1)][0, :3])
        raise InputError(
            f"the plan has a force of ({force}) N, which no payload of the study makes; expected "
            "nothing or the weight of one"
        )
    return carried, rest


def _mounted(study: AbsoluteStudy, rng: np.random.Generator) -> Array:
    """(1, K, 3) reflectors about where they are thought to be; there, if nobody asks for them."""
    markers = np.array(study.tool.markers)[None]
    return markers + _MOUNTED * rng.normal(size=markers.shape) * ("tool" in study.blocks)


def _standing(study: AbsoluteStudy, rng: np.random.Generator) -> Array:
    """(4, 4) the base in the frame of a tracker, turned anyhow about the vertical; or known."""
    if "base" not in study.blocks:
        return np.eye(4)
    tracker = tracker_of(study.instrument)
    azimuth, turn = rng.uniform(-np.pi, np.pi, 2)
    away = np.array([_AWAY * np.cos(azimuth), _AWAY * np.sin(azimuth), 0.5])
    head = away if tracker is None else np.array(tracker.position)
    level = 1e-2 * rng.normal(size=2)
    rotation = from_rotation_vectors(np.array([[*level, turn]]))[0]
    return transform(rotation, -rotation @ head)


def _say(made: Positions, out: Path, kept: Path | None, *, as_json: bool) -> None:
    """What the campaign came to."""
    if as_json:
        said = {"experiments": len(made.cases), "readings": len(made), "source": made.source}
        print_json(said if kept is None else {**said, "truth": str(kept)})
        return
    print(f"wrote {out}: {counted(len(made.cases), 'pose')}, {counted(len(made), 'reading')}")
    if kept is not None:
        print(f"wrote {kept}: the arm that was measured, its frames by chance")
