"""What is a free direction of the force worth? A hung weight, a cone, any direction.

The same 2500 N on the KUKA KR 270. Printed is ρ0 √m: the bound, which holds for every number m of
experiments, and what a plan of twelve in three configurations reaches.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import elastocal as ec

STUDY = Path(__file__).parent / "kr270" / "study.yaml"
DOWN = np.array([0.0, 0.0, -1.0])


def main() -> None:
    study = ec.read_study(STUDY)
    forces = {
        "hung weight": study.experiments.force,
        "within 30° of the vertical": ec.FreeDirection(2500.0, DOWN, np.radians(30.0)),
        "any direction": ec.FreeDirection(2500.0, DOWN),
    }
    print("force                         bound    12 experiments   [µm, times √m]")
    for name, force in forces.items():
        variant = replace(study, experiments=replace(study.experiments, force=force))
        plan = ec.plan(variant, seed=0)
        scale = 1e6 * np.sqrt(plan.count)
        bound, found = scale * plan.certificate.lower_bound, scale * plan.assessment.rho0
        print(f"{name:27s} {bound:7.4f} {found:17.4f}")


if __name__ == "__main__":
    main()
