"""Speed of the kernel, of the certificate and of start-up, against other ways to do it.

    python benchmarks/kernel.py

One run interleaves all competitors on the same data, after checking that they agree: the regressor
of N load cases, and the regressor with its vector-Jacobian product. Ratios are times of the other
over elastocal's. Writes benchmarks/results/kernel.md.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
from casadi_arm import pose_function
from kr270 import BOUND, MICRO, RESULTS, machine, one_thread, study, write_results
from problems import EXAMPLES, HERE

from elastocal.arrays import Array
from elastocal.core.library import levels
from elastocal.design.continuous import continuous_design
from elastocal.design.lockstep import PENALTIES, Mover, _Search
from elastocal.design.oracle import _Descent
from elastocal.design.space import information
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.regressor import Regressor
from elastocal.files.study.study_file import read_study
from elastocal.matrices import square_root
from elastocal.robot.posture import Posture
from elastocal.study.compiled import CompiledSpace
from elastocal.study.criteria import mean_test_pose
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

Pair = tuple[Callable[[Array], Array], Callable[[Array, Array], Array]]
"""Regressor (N, 3, p) of q (N, n); gradient (N, n) in q for a cotangent (N, 3, p)."""


Call = Callable[[], Array]

CHUNK = 2048


def elastocal_pair(campaign: Study) -> Pair:
    """elastocal's regressor and `pull`, in chunks as `LoadCaseSpace` evaluates them."""
    wrench = np.append(_force(campaign), np.zeros(3))

    def regressor(q: Array) -> Regressor:
        loads = np.tile(wrench, (len(q), 1))
        return Regressor(campaign.arm, Posture(campaign.robot, q), loads)

    def value(q: Array) -> Array:
        parts = [regressor(q[i : i + CHUNK]).rows for i in range(0, len(q), CHUNK)]
        return np.concatenate(parts, axis=2).transpose(2, 0, 1)

    def gradient(q: Array, cotangent: Array) -> Array:
        parts = []
        for i in range(0, len(q), CHUNK):
            part = np.ascontiguousarray(cotangent[i : i + CHUNK].transpose(1, 2, 0))
            parts.append(regressor(q[i : i + CHUNK]).pull(part)[0])
        return np.concatenate(parts, axis=1).T

    return value, gradient


def casadi_pair(campaign: Study, count: int) -> Pair:
    """The same as CasADi expression graphs, mapped over N; the first joint stays at zero."""
    pose = pose_function(campaign)
    x, cotangent = ca.SX.sym("x", len(campaign.robot.joints) - 1), ca.SX.sym("c", 3, 5)
    rows = pose(x)[0]
    forward = ca.Function("rows", [x], [rows]).map(count)
    slope = ca.gradient(ca.dot(rows, cotangent), x)
    backward = ca.Function("pull", [x, cotangent], [rows, slope]).map(count)

    def value(q: Array) -> Array:
        return forward(q[:, 1:].T).full().reshape(3, len(q), -1).transpose(1, 0, 2)

    def gradient(q: Array, cotangent: Array) -> Array:
        side_by_side = cotangent.transpose(1, 0, 2).reshape(3, -1)
        return backward(q[:, 1:].T, side_by_side)[1].full().T

    return value, gradient


def pinocchio_pair(campaign: Study) -> Pair:
    """Pinocchio called once per configuration; gradient from its kinematic Hessian."""
    model, tip = pinocchio_model(campaign)
    data = model.createData()
    force = _force(campaign)
    assert campaign.springs.joint is not None
    chosen = np.array(campaign.springs.joint)
    full = np.zeros(model.nq)

    def jacobian(q: Array) -> Array:
        full[:-1] = q
        pin.computeJointJacobians(model, data, full)
        return pin.getJointJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)[:3]

    def value(q: Array) -> Array:
        rows = np.empty((len(q), 3, len(chosen)))
        for i, one in enumerate(q):
            columns = jacobian(one)[:, chosen]
            rows[i] = columns * (force @ columns)
        return rows

    def gradient(q: Array, cotangent: Array) -> Array:
        result = np.empty(q.shape)
        for i, one in enumerate(q):
            columns = jacobian(one)[:, chosen]
            pin.computeJointKinematicHessians(model, data, full)
            flat = pin.getJointKinematicHessian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)
            # the binding labels a column-major (6, nv, nv) tensor as row-major
            hessian = flat.ravel().reshape(model.nv, model.nv, 6).transpose(2, 1, 0)
            hessian = hessian[:3][:, chosen, :-1]  # d column / d joint
            y = force @ columns
            y_bar = (columns * cotangent[i]).sum(axis=0)
            velocity_bar = cotangent[i] * y + np.outer(force, y_bar)
            result[i] = np.tensordot(velocity_bar, hessian, axes=2)
        return result

    return value, gradient


def pinocchio_model(campaign: Study) -> tuple[pin.Model, int]:
    """The chain as a Pinocchio model with one more joint at the load point, to measure there."""
    model, parent = pin.Model(), 0
    for joint in campaign.robot.joints:
        kind = (
            pin.JointModelPrismaticUnaligned
            if joint.prismatic
            else (pin.JointModelRevoluteUnaligned)
        )
        placement = pin.SE3(np.array(joint.T_parent_joint))
        parent = model.addJoint(parent, kind(np.array(joint.axis)), placement, joint.name)
    link = np.array(campaign.robot.T_tip_flange)
    point = link[:3, :3] @ campaign.experiments.tool.load_point + link[:3, 3]
    last = pin.SE3(link[:3, :3], point)
    return model, model.addJoint(parent, pin.JointModelRX(), last, "load point")


def _force(campaign: Study) -> Array:
    force = campaign.experiments.force
    assert isinstance(force, FixedVector)
    return np.array(force.value)


def kernel_table(campaign: Study, sizes: list[int], rounds: int) -> list[str]:
    """Throughput and ratios as markdown."""
    rng = np.random.default_rng(0)
    lines = [
        "| N | what | elastocal [µs] | Mconf/s | Pinocchio loop / elastocal "
        "| CasADi map / elastocal | CasADi construction [s] |",
        "|--:|:--|--:|--:|--:|--:|--:|",
    ]
    for size in sizes:
        q = campaign.space.sample(size, rng)
        q[:, 0] = 0.0
        cotangent = rng.normal(size=(size, 3, len(campaign.springs)))
        begun = time.perf_counter()
        mapped = casadi_pair(campaign, size)
        construction = time.perf_counter() - begun
        pairs = [elastocal_pair(campaign), pinocchio_pair(campaign), mapped]
        _agree(pairs, q, cotangent)
        for what, calls in (
            ("regressor", [partial(value, q) for value, _ in pairs]),
            ("regressor and pull", [partial(slope, q, cotangent) for _, slope in pairs]),
        ):
            own, loop, graph = _best_times(calls, rounds)
            lines.append(
                f"| {size} | {what} | {1e6 * own:.0f} | {size / own / 1e6:.2f} "
                f"| {loop / own:.1f} | {graph / own:.2g} | {construction:.2f} |"
            )
            print(lines[-1], flush=True)
    return lines


def _agree(pairs: list[Pair], q: Array, cotangent: Array) -> None:
    """All competitors compute the same numbers."""
    own_value, own_gradient = pairs[0]
    rows, slope = own_value(q), own_gradient(q, cotangent)
    for value, gradient in pairs[1:]:
        assert np.abs(value(q) - rows).max() < 1e-9 * np.abs(rows).max()
        other = gradient(q, cotangent)[:, -len(q[0]) :]
        own = slope[:, slope.shape[1] - other.shape[1] :]
        assert np.abs(other - own).max() < 1e-9 * np.abs(slope).max()


def _best_times(calls: Sequence[Callable[[], Array]], rounds: int) -> list[float]:
    """Smallest processor time of each call over rounds in which all take turns [s]."""
    best = [np.inf] * len(calls)
    for _ in range(rounds):
        for i, call in enumerate(calls):
            repeats, elapsed = 0, 0.0
            while elapsed < 0.05:
                begun = time.process_time()
                call()
                seconds = time.process_time() - begun
                best[i] = min(best[i], seconds)
                repeats, elapsed = repeats + 1, elapsed + seconds
    return best


def core_table(rounds: int) -> list[str]:
    """The compiled core against NumPy, level by level: what a search asks, and one call of it."""
    base = read_study(EXAMPLES / "kr270" / "study.yaml")
    lines = [
        "| space | work | NumPy | " + " | ".join(f"{level}, ×" for level in levels()) + " |",
        "|:--|:--|--:|" + "--:|" * len(levels()),
    ]
    for name, campaign in (
        ("5 unknowns, no collision", study(12)),
        ("5 unknowns, itself and floor", base),
        ("18 unknowns, three markers", read_study(HERE / "eighteen.yaml")),
    ):
        space = campaign.space
        vars(space)["core"] = None  # NumPy, whatever there is
        cores = [CompiledSpace(library, space) for library in levels().values()]
        for size in (12, 12000):
            calls = _seam(space, cores, size)
            times = _best_times(calls, rounds)
            shown = " | ".join(f"{times[0] / own:.1f}" for own in times[1:])
            speed = f"{size / times[0]:.3g} / s"
            lines.append(f"| {name} | evaluate and pull, N = {size} | {speed} | {shown} |")
        times = _best_times(_climbs(campaign, space, cores), rounds)
        shown = " | ".join(f"{times[0] / own:.1f}" for own in times[1:])
        speed = f"{CLIMBS * STEPS / times[0]:.3g} / s"
        lines.append(f"| {name} | iterations of {CLIMBS} climbs | {speed} | {shown} |")
        print("\n".join(lines[-3:]), flush=True)
    return lines


CLIMBS, STEPS = 600, 30


def _seam(space: LoadCaseSpace, cores: list[CompiledSpace], size: int) -> list[Call]:
    """Rows, margins and both gradients of so many load cases: NumPy, then the cores."""
    rng = np.random.default_rng(0)
    x = space.sample(size, rng)
    first = space.evaluate(x)
    blocks_bar, margins_bar = rng.normal(size=first.blocks.shape), np.ones(first.margins.shape)

    def asked(place: LoadCaseSpace | CompiledSpace) -> Array:
        evaluation = place.evaluate(x)
        assert evaluation.blocks.size
        assert evaluation.margins.size
        return evaluation.pull(blocks_bar, margins_bar)

    expected = asked(space)
    for core in cores:
        assert np.abs(asked(core) - expected).max() < 1e-8 * np.abs(expected).max()
    return [partial(asked, place) for place in (space, *cores)]


def _climbs(campaign: Study, space: LoadCaseSpace, cores: list[CompiledSpace]) -> list[Call]:
    """Climbs from fresh starts, as those that try a bound: NumPy, then the cores."""
    x = space.sample(CLIMBS, np.random.default_rng(0))
    each = information(space.evaluate(x).blocks)
    total = campaign.prior / 12.0 + each.mean(axis=0)
    root = square_root(mean_test_pose(campaign).gradient(total[None])[0])
    level = float(((space.evaluate(x).blocks @ root) ** 2).sum(axis=(1, 2)).max())
    movers = [_Search(_Descent(space, root, level), space.lower, space.upper)]
    penalty = np.resize(np.array(PENALTIES), CLIMBS)

    def moved(mover: Mover) -> Array:
        batch = mover.begin(np.arange(CLIMBS), x, penalty)
        for _ in range(STEPS // 10):
            mover.advance(batch, 10, settle=True)
        return batch.x

    return [partial(moved, mover) for mover in (*movers, *(c.climbing(root, level) for c in cores))]


def certificate_lines(seeds: int) -> list[str]:
    """Whole time of the continuous design with its confirmed bound."""
    lines = [
        "| test pose | seconds: median (min – max) | rounds | bound over the true one: worst |",
        "|:--|--:|--:|--:|",
    ]
    for matrix, true in BOUND.items():
        campaign = study(12, matrix=matrix)
        times, rounds, excess = [], [], []
        for seed in range(seeds):
            gaps: list[float] = []
            begun = time.perf_counter()
            design = continuous_design(
                campaign.space,
                mean_test_pose(campaign),
                np.random.default_rng(seed),
                progress=lambda _, gap, gaps=gaps: gaps.append(gap),
            )
            times.append(time.perf_counter() - begun)
            rounds.append(len(gaps))
            excess.append(MICRO / design.certificate.upper**0.5 / true - 1.0)
        lines.append(
            f"| {matrix} | {_spread(times)} | {min(rounds)} – {max(rounds)} "
            f"| {max(excess, key=abs):+.1e} |"
        )
        print(lines[-1], flush=True)
    return lines


def startup_lines(rounds: int) -> list[str]:
    """Whole processes: bare Python, NumPy, elastocal, its help, planning code imported."""
    lines = ["| process | seconds: median (min – max) |", "|:--|--:|"]
    for name, arguments in (
        ("python -c pass", ["-c", "pass"]),
        ("import numpy", ["-c", "import numpy"]),
        ("import elastocal", ["-c", "import elastocal"]),
        ("import elastocal.planning.plan", ["-c", "import elastocal.planning.plan"]),
        ("elastocal --help", ["-m", "elastocal", "--help"]),
        ("elastocal plan --help", ["-m", "elastocal", "plan", "--help"]),
    ):
        times = []
        for _ in range(rounds + 1):
            begun = time.perf_counter()
            subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
            times.append(time.perf_counter() - begun)
        lines.append(f"| `{name}` | {_spread(times[1:])} |")
        print(lines[-1], flush=True)
    return lines


def _spread(values: list[float]) -> str:
    return f"{statistics.median(values):.3g} ({min(values):.3g} – {max(values):.3g})"


def main() -> None:
    """Run, print, write results/kernel.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two rounds, one seed")
    parser.add_argument("--seeds", type=int, default=5, help="seeds of the certificate")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of every timing")
    parser.add_argument("--out", type=Path, default=RESULTS / "kernel.md")
    arguments = parser.parse_args()
    one_thread()
    seeds, rounds = (1, 2) if arguments.quick else (arguments.seeds, arguments.rounds)
    about = machine("pin", "casadi")
    print(about, flush=True)
    parts = [
        "# Kernel, certificate, start-up",
        f"Made by `benchmarks/kernel.py`. {about}. One thread throughout.",
        "## Regressor and vector-Jacobian product, KR 270, 5 unknowns",
        "Smallest times over interleaved rounds; all three agree to 1e-9. elastocal is its NumPy "
        "code here, without the core. Pinocchio has no batch "
        "call in Python, so that its column is what a Python loop costs, not what its C++ costs. "
        "CasADi runs in its virtual machine, not compiled.",
        "\n".join(kernel_table(study(12), [12, 400, 12000], rounds)),
        "## The compiled core, and NumPy beside it",
        "Load cases, or iterations, of NumPy per processor second, and how many times as fast the "
        "levels are; smallest times over interleaved rounds. A climb's iteration is step, margins, "
        "sensitivity, gradient, curvature and new direction; the core does ten a call. All agree.",
        "\n".join(core_table(rounds)),
        "## Continuous design with confirmed bound",
        f"{seeds} seed(s), 300 fresh starts each.",
        "\n".join(certificate_lines(seeds)),
        "## Start-up",
        "\n".join(startup_lines(rounds)),
    ]
    write_results(arguments.out, *parts)


if __name__ == "__main__":
    main()
