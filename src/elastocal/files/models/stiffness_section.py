"""What a model says of the test poses, for programs: µm/N and N/µm, matrices in SI."""

from __future__ import annotations

from typing import Any

from elastocal.elastic.cartesian import Interval
from elastocal.study.at_test_poses import AtTestPose


def pose_entries(found: tuple[AtTestPose, ...]) -> list[dict[str, Any]]:
    """One entry for each test pose."""
    return [_entry(one) for one in found]


def _entry(one: AtTestPose) -> dict[str, Any]:
    stiff, held = one.cartesian, one.cartesian.held
    lines = (*stiff.axes, *stiff.principal)
    matrix = stiff.stiffness
    return {
        "name": one.name,
        "tool": one.tool,
        "point": one.place.removeprefix("point "),
        "rho0_mm": 1e3 * one.rho0,
        "limit_95_mm": 1e3 * one.limit,
        "directions": {line.name: line.direction.tolist() for line in lines},
        "compliance_um_per_N": {line.name: _interval(line.compliance, 1e6) for line in lines},
        "stiffness_N_per_um": {line.name: _interval(line.stiffness, 1e-6) for line in lines},
        "compliance_matrix_SI": stiff.matrix.tolist(),
        "stiffness_matrix_SI": None if matrix is None else matrix.tolist(),
        "held_N_per_um": {a: _interval(i, 1e-6) for a, i in zip("xyz", held[:3], strict=False)},
        "held_Nm_per_rad": {a: _interval(i, 1.0) for a, i in zip("xyz", held[3:], strict=False)},
        "directions_without_compliance": stiff.missing,
        "rigid_joints": list(stiff.rigid),
    }


def _interval(interval: Interval, factor: float) -> dict[str, float]:
    value, low, high = interval
    return {"value": factor * value, "low": factor * low, "high": factor * high}
