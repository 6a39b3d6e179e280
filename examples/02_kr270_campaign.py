"""The whole way for the KUKA KR 270: read a study, plan, look at the proof, write the files.

python examples/02_kr270_campaign.py FOLDER     # without FOLDER to a temporary one
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import elastocal as ec

STUDY = Path(__file__).parent / "kr270" / "study.yaml"


def main(folder: Path) -> None:
    study = ec.read_study(STUDY)
    plan = ec.plan(study, seed=0)
    print(f"{plan.count} experiments in {len(plan.repeats)} configurations")
    for q, repeats in zip(plan.load_cases.q, plan.repeats, strict=True):
        print(f"  {repeats}×", " ".join(f"{angle:8.2f}°" for angle in np.degrees(q)))
    for joint, error in zip(study.springs.names, plan.assessment.standard_error, strict=True):
        print(f"  standard error of {joint}: {1e9 * error:5.2f}e-9 rad/(N·m)")

    proof = plan.certificate
    print(f"ρ0 = {1e6 * plan.assessment.rho0:.3f} µm; no plan is below", end=" ")
    print(f"{1e6 * proof.lower_bound:.3f} µm (efficiency {proof.efficiency:.4f};", end=" ")
    print(f"{proof.fresh_starts} fresh starts did not refute the bound)")

    random = ec.random_plans(study, 1000, seed=0)
    print(f"random plans have {1e6 * np.median(random):.3f} µm (median of {len(random)})")

    folder.mkdir(parents=True, exist_ok=True)
    ec.write_plan(plan, folder / "plan.json")
    ec.write_run_sheet(plan, folder / "plan.csv")
    page = ec.html(ec.Contents(plan, random=random))
    (folder / "report.html").write_text(page, encoding="utf-8")
    print("wrote", ", ".join(sorted(path.name for path in folder.iterdir())))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as place:
            main(Path(place))
