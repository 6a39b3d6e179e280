"""What makes a promise better: aslant loads, reflectors, other configurations, a second step.

    python benchmarks/how_to_choose.py

Twelve readings of the KR 270 at the milling pose of the paper, with the nuisance that is typical;
every plan is made by `elastocal.plan` for what its row says, seed 0. Then what design over unknown
compliances could gain, by the exact gradients of the equilibrium at compliances that are drawn
within a factor of two. Writes benchmarks/results/how_to_choose.md, the numbers of
docs/how-to-choose.md.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

import elastocal as ec
from elastocal.arrays import Array, IntArray
from elastocal.elastic.deflections import deflection_and_gradient
from elastocal.planning.promise import Promise, promise
from elastocal.planning.with_errors import WithErrors

EXAMPLE = Path(__file__).parent.parent / "examples" / "kr270"
Plan = tuple[ec.LoadCases, IntArray]
_DRAWS, _NEAR, _STEP = 8, 300, np.radians(2.0)
_POOL = 400


def hung(folder: Path, configurations: int, *, everything: bool = False) -> ec.Study:
    """A hung weight, with so many configurations; all joints are sought where `everything` is."""
    text = (EXAMPLE / "study.yaml").read_text("utf-8") + "nuisance: typical\n"
    text = text.replace("max_configurations: 3 ", f"max_configurations: {configurations} ")
    if everything:
        text = text.replace(
            "identify: [A2, A3, A4, A5, A6] ", "identify: [A1, A2, A3, A4, A5, A6] "
        )
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    return ec.read_study(path)


def aslant(markers: int, configurations: int) -> ec.Study:
    """A cable aslant, with so many reflectors and configurations."""
    study = ec.read_study(EXAMPLE / "study_aslant.yaml")
    tool = study.experiments.tool
    fewer = replace(tool, markers=tool.markers[:markers], marker_names=tool.marker_names[:markers])
    experiments = replace(study.experiments, tool=fewer, max_configurations=configurations)
    pose = replace(study.test_poses[0], weight=1.0)
    return replace(study, test_poses=(pose,), experiments=experiments)


def planned(study: ec.Study) -> Plan:
    """The plan that `elastocal plan` makes."""
    made = ec.plan(study, seed=0)
    return made.load_cases, made.repeats


def told(study: ec.Study, plan: Plan) -> Promise:
    """What it promises."""
    found = promise(study, *plan)
    assert found is not None
    return found


def with_second_step(study: ec.Study, plan: Plan, count: int = 4) -> Plan:
    """A plan and a few experiments with a rope that pulls sideways, the best of a pool in turn."""
    rope = ec.read_study(EXAMPLE / "study_a1.yaml").space
    pool = rope.load_cases(rope.sample(_POOL, np.random.default_rng(0)))
    assert study.nuisance is not None
    errors = WithErrors(study, study.nuisance)
    once = np.ones(_POOL, dtype=np.int64)
    known = errors.base + errors.informations(*plan).sum(axis=0)
    each = errors.informations(pool, once)
    blocks = errors.blocks(study.test_poses[0])[0]
    chosen: list[int] = []
    for _ in range(count):
        left = np.linalg.inv(known + each)
        loss = np.einsum("ri,nij,rj->n", blocks, left, blocks)
        loss[chosen] = np.inf
        chosen.append(int(np.argmin(loss)))
        known = known + each[chosen[-1]]
    q, wrench = (
        np.vstack([plan[0].q, pool.q[chosen]]),
        np.vstack([plan[0].wrench, pool.wrench[chosen]]),
    )
    return ec.LoadCases(q, wrench), np.append(plan[1], once[:count])


def over_compliances(folder: Path) -> tuple[float, float]:
    """What the best of many plans beside that of the linear model gains for drawn compliances.

    Returns the gain in the mean loss, and how far the exact ρ0 of one plan varies, as shares.
    """
    text = (EXAMPLE / "study.yaml").read_text("utf-8")
    path = folder / "plain.yaml"
    path.write_text(text, encoding="utf-8")
    study = ec.read_study(path)
    cases, repeats = planned(study)
    truth = ec.read_model(EXAMPLE / "truth.json", study.robot).of(study.springs.names)
    rng = np.random.default_rng(0)
    drawn = truth * 2.0 ** rng.uniform(-1.0, 1.0, (_DRAWS, len(truth)))
    rows = study.test_poses[0].regressor

    def losses(plan: ec.LoadCases) -> Array:
        found = []
        for compliance in drawn:
            _, slopes = deflection_and_gradient(study.arm, compliance, plan)
            information = np.einsum("n,nri,nrj->ij", repeats.astype(float), slopes, slopes)
            found.append(study.sigma**2 * np.trace(rows @ np.linalg.solve(information, rows.T)))
        return np.array(found)

    own = losses(cases)
    best = own.mean()
    for _ in range(_NEAR):
        q = cases.q + _STEP * rng.standard_normal(cases.q.shape) * rng.random()
        if _allowed(study, q):
            best = min(best, losses(ec.LoadCases(q, cases.wrench)).mean())
    return float(1.0 - np.sqrt(best / own.mean())), float(
        np.ptp(np.sqrt(own)) / np.sqrt(own).mean()
    )


def _allowed(study: ec.Study, q: Array) -> bool:
    """Whether nothing forbids these configurations."""
    wrench = np.tile([0.0, 0.0, -2500.0, 0.0, 0.0, 0.0], (len(q), 1))
    return not ec.assess(study, ec.LoadCases(q, wrench), np.ones(len(q), dtype=int)).violations


def main() -> None:
    """Write the page."""
    one_thread()
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--out", type=Path, default=RESULTS / "how_to_choose.md")
    given = words.parse_args()
    begun = machine()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found: list[tuple[str, Promise]] = []

        def say(what: str, study: ec.Study, plan: Plan) -> Plan:
            found.append((what, told(study, plan)))
            print(what, found[-1][1].rho0, flush=True)
            return plan

        three = hung(folder, 3)
        bare = planned(ec.with_nuisance(three, None))
        say("hung, 3 configurations, planned without nuisance", three, bare)
        say("hung, 3 configurations, planned for it", three, planned(three))
        twelve = hung(folder, 12)
        many = say("hung, 12 configurations", twelve, planned(twelve))
        both = hung(folder, 12, everything=True)
        say(
            "hung, 12 configurations, and 4 sideways as a second step",
            both,
            with_second_step(both, many),
        )
        say("aslant, 1 reflector, 12 configurations", aslant(1, 12), planned(aslant(1, 12)))
        say("aslant, 3 reflectors, 3 configurations", aslant(3, 3), planned(aslant(3, 3)))
        say("aslant, 3 reflectors, 12 configurations", aslant(3, 12), planned(aslant(3, 12)))
        gain, varies = over_compliances(folder)
    write_results(
        given.out,
        "# How to choose: what makes a promise better",
        f"Made by `benchmarks/how_to_choose.py`. {begun}.",
        "\n".join(
            [
                "| 12 readings | claimed without nuisance µm | promised µm | with 95 % below µm |",
                "|:--|--:|--:|--:|",
                *(
                    f"| {what} | {1e6 * one.without:.2f} | {1e6 * one.rho0:.0f} | "
                    f"{1e6 * one.limit:.0f} |"
                    for what, one in found
                ),
            ]
        ),
        f"On top at the milling pose: friction {1e6 * found[0][1].friction:.0f} µm, discrepancy "
        f"{1e6 * found[0][1].discrepancy:.0f} µm.",
        f"Compliances within a factor of two, {_DRAWS} drawn: the exact ρ0 of the plan of the "
        f"linear model varies by {100 * varies:.2f} %; the best of {_NEAR} plans beside it has "
        f"{100 * gain:.2f} % less on average.",
    )


if __name__ == "__main__":
    main()
