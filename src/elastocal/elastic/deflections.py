"""Deflections under load: what is read of an arm that comes to rest, exact for any size.

In: elastic arm, compliances, load cases. Out: how far the markers move and, if the tool asks for
it, how the flange turns, with their gradients in the compliances. No regressor is used here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import Linearisation, equilibrium, linearise
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import EquilibriumError
from elastocal.robot.posture import Posture, flange_axes
from elastocal.robot.rotations import rotation_vectors, turned_slope


def loaded_deflection(arm: ElasticArm, compliance: Array, cases: LoadCases) -> Array:
    """(N, 3K or 3K + 3) deflection of the markers, loaded minus unloaded, exact for any size [m].

    If the tool asks for it, the rotation of the flange from unloaded to loaded is appended: axis
    times angle, base frame [rad]. Unloaded is the arm under the weight of its links alone, if that
    is known, and what acts before the load.

    Raises:
        EquilibriumError: a load case has no stable equilibrium; the message names it.
    """
    loaded = _at_rest(arm, compliance, LoadCases(cases.q, cases.second))
    idle = np.zeros_like(loaded)
    if arm.sags or cases.preloaded:
        idle = _at_rest(arm, compliance, LoadCases(cases.q, cases.first))
    moved = markers_at(arm, cases.q, loaded) - markers_at(arm, cases.q, idle)
    if not arm.tool.rotation:
        return moved
    turned = rotation_between(flange_at(arm, cases.q, loaded), flange_at(arm, cases.q, idle))
    return np.hstack([moved, turned])


def deflection_and_gradient(
    arm: ElasticArm, compliance: Array, cases: LoadCases
) -> tuple[Array, Array]:
    """Deflections as `loaded_deflection`, and their derivatives in the compliances.

    Returns:
        (N, 3K or 3K + 3) deflections [m, rad] and their derivatives, with an axis p.

    Raises:
        EquilibriumError: a load case has no stable equilibrium; the message names it.
    """
    two = arm.sags or cases.preloaded
    wrenches = [cases.second, cases.first] if two else [cases.wrench]
    found, states = [], []
    for wrench in wrenches:
        rest = _at_rest(arm, compliance, LoadCases(cases.q, wrench))
        here = linearise(arm, compliance, cases.q, wrench, rest)
        states.append(here)
        found.append((here.markers, here.velocity @ here.slope))
    loaded, slope = found[0]
    if two:
        moved, slope = loaded - found[1][0], slope - found[1][1]
    else:
        flat = np.zeros((len(cases), len(arm.springs)))
        moved = loaded - markers_at(arm, cases.q, flat)
    if not arm.tool.rotation:
        return moved, slope
    turned, each = rotations(arm, cases.q, states)
    turn = sum(rows @ state.slope for rows, state in zip(each, states, strict=True))
    return np.hstack([moved, turned]), np.concatenate([slope, turn], axis=1)


def markers_at(arm: ElasticArm, q: Array, displacement: Array) -> Array:
    """(N, 3K) marker positions [m] of configurations (N, n) with springs bent by (N, p)."""
    posture = Posture(arm.chain, arm.bent(q, displacement))
    points = [posture.point(marker) for marker in arm.tool.markers]
    return np.concatenate(points).T


def flange_at(arm: ElasticArm, q: Array, displacement: Array) -> Array:
    """(N, 3, 3) axes of the flange, as columns, of configurations with springs bent by (N, p)."""
    return flange_axes(Posture(arm.chain, arm.bent(q, displacement)))


def rotation_between(loaded: Array, idle: Array) -> Array:
    """(N, 3) rotation vector from `idle` to `loaded` axes, (N, 3, 3) each, base frame [rad]."""
    return rotation_vectors(loaded @ idle.transpose(0, 2, 1))


def rotations(
    arm: ElasticArm, q: Array, states: Sequence[Linearisation]
) -> tuple[Array, list[Array]]:
    """Rotation of the flange between two states, and its derivatives in the displacements of each.

    Args:
        arm: Elastic arm with p springs.
        q: (N, n) configurations [rad or m].
        states: The loaded state, and the unloaded one if the arm sags.

    Returns:
        (N, 3) rotation vectors [rad], and for each state (N, 3, p).

    Source: ours; R_l R_iᵀ turned from the left by the loaded flange, from the right by the idle.
    """
    loaded = states[0]
    if len(states) > 1:
        idle = states[1].flange
    else:
        idle = flange_at(arm, q, np.zeros((len(q), len(arm.springs))))
    vectors = rotation_between(loaded.flange, idle)
    slope = turned_slope(vectors)
    each = [slope @ loaded.turning]
    if len(states) > 1:
        each.append(-slope.transpose(0, 2, 1) @ states[1].turning)
    return vectors, each


def _at_rest(arm: ElasticArm, compliance: Array, cases: LoadCases) -> Array:
    """(N, p) displacements at a stable equilibrium."""
    rest = equilibrium(arm, compliance, cases)
    wrong = np.flatnonzero(~rest.stable)
    if len(wrong):
        raise EquilibriumError(
            f"load case {wrong[0] + 1} has no stable equilibrium with these compliances: the "
            "arm gives way under the load; check the units of compliances and loads"
        )
    return rest.displacement
