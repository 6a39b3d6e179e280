"""Six experiments are done already: plan six more that fit to them.

What is known enters as prior information. Planned without it, the new experiments would in part
repeat what the old ones have told.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import elastocal as ec

STUDY = Path(__file__).parent / "kr270" / "study.yaml"


def main() -> None:
    study = ec.read_study(STUDY)
    study = replace(study, experiments=replace(study.experiments, count=6, max_configurations=3))

    # The earlier campaign: six feasible configurations that nobody has planned.
    x = study.space.sample(6, np.random.default_rng(5))
    once = np.ones(6, dtype=int)
    before = ec.assess(study, study.space.load_cases(x), once)
    print(f"six experiments done, by feeling:             ρ0 = {1e6 * before.rho0:.3f} µm")

    alone = ec.plan(study, seed=0)
    later = replace(study, prior=before.information)
    forgetful = ec.assess(later, alone.load_cases, alone.repeats)
    print(f"and six more, planned as if there were none:  ρ0 = {1e6 * forgetful.rho0:.3f} µm")

    plan = ec.plan(later, seed=0)
    print(f"and six more, planned with that in mind:      ρ0 = {1e6 * plan.assessment.rho0:.3f} µm")
    bound = plan.certificate.lower_bound
    print(f"no six experiments can bring it below              {1e6 * bound:.3f} µm")


if __name__ == "__main__":
    main()
