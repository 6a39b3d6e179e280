"""The three-link arm with pencil and paper: eqs. (33) to (37) beside `assess` and `plan`.

q1 = 0, F = (0, cos α, sin α) F_max; (33), (34), (35) as docs/validation.md repairs them. Metres.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import elastocal as ec

FOLDER = Path(__file__).parent / "three-link"
L2, L3 = 1.25, 1.10


def coefficients(q: np.ndarray, force: np.ndarray) -> np.ndarray:
    """d1 to d4 of (37), for a test pose with its force over F_max."""
    (s1, s2, _), (c1, c2, c3), q23 = np.sin(q), np.cos(q), q[1] + q[2]
    ahead, aside = force[0] * c1 + force[1] * s1, force[0] * s1 - force[1] * c1
    reach, rise = L2 * c2 + L3 * np.cos(q23), L2 * s2 + L3 * np.sin(q23)
    second = ahead * rise - force[2] * reach
    third = L3 * (ahead * np.sin(q23) - force[2] * np.cos(q23))
    d1, d2 = reach**4 * aside**2, L3**2 * third**2
    d3, d4 = (L2**2 + L3**2 + 2 * L2 * L3 * c3) * second**2, L3 * (L3 + L2 * c3) * second * third
    return np.array([d1, d2, d3, d4])


def sums(x: np.ndarray) -> np.ndarray:
    """a11, a22, a33, a23 of (33), for m experiments x = (q2, q3, α)."""
    q2, q3, alpha = np.reshape(x, (-1, 3)).T
    reach, c23, z = L2 * np.cos(q2) + L3 * np.cos(q2 + q3), np.cos(q2 + q3), np.sin(alpha) ** 2
    a22 = reach**2 * (L2**2 + L3**2 + 2 * L2 * L3 * np.cos(q3)) * z
    a23 = L3**2 * reach * c23 * (L3 + L2 * np.cos(q3)) * z
    return np.sum([reach**4 * np.cos(alpha) ** 2, a22, L3**4 * c23**2 * z, a23], axis=1)


def covariance(x: np.ndarray) -> np.ndarray:
    """cov(k) of (34), over (σ / F_max)²."""
    a11, a22, a33, a23 = sums(x)
    rows = [[a22 * a33 - a23**2, 0, 0], [0, a33 * a11, -a23 * a11], [0, -a23 * a11, a22 * a11]]
    return np.array(rows) / (a11 * (a22 * a33 - a23**2))


def objective(x: np.ndarray, d: np.ndarray) -> float:
    """ρ0² over σ², as (35) reduces it."""
    a11, a22, a33, a23 = sums(x)
    return float(d[0] / a11 + (d[1] * a22 + d[2] * a33 - 2 * d[3] * a23) / (a22 * a33 - a23**2))


def main() -> None:
    study, rng = ec.read_study(FOLDER / "study.yaml"), np.random.default_rng(0)
    sigma, force, task = study.sigma, study.experiments.force.size, study.test_poses[0].case
    d = coefficients(task.q[0], task.wrench[0, :3] / force)
    opt2 = ec.read_proposal(FOLDER / "published" / "opt2.csv", study)
    q, wrench = opt2.load_cases.q, opt2.load_cases.wrench
    x = np.column_stack([q[:, 1:], np.arctan2(wrench[:, 2], wrench[:, 1])])
    worth = ec.assess(study, opt2.load_cases, opt2.repeats)
    print("d1 d2 d3 d4", d.round(4), "a11 a22 a33 a23", sums(x).round(4))
    errors, found = np.sqrt(np.diagonal(covariance(x))), worth.standard_error * force / sigma
    print("δk of Opt2 by (34)", errors.round(4), "by assess", found.round(4))
    print(f"ρ0²/σ² by (35) {objective(x, d):.6f}, by assess {(worth.rho0 / sigma) ** 2:.6f}")
    for m in (1, 2):
        starts = rng.uniform(-np.pi, np.pi, (30, 3 * m))
        least = min(minimize(objective, start, d).fun for start in starts)
        plan = ec.plan(replace(study, experiments=replace(study.experiments, count=m)))
        rho0 = (plan.assessment.rho0 / sigma) ** 2
        print(f"m = {m}: least (35) {least:.6f}, planned with q1 and F free {rho0:.6f}")


if __name__ == "__main__":
    main()
