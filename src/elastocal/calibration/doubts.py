"""What is weak in a calibration, or was not to be expected."""

from __future__ import annotations

import numpy as np

from elastocal.calibration.calibrate import Calibration
from elastocal.calibration.knocks import knocked, likeliest_knocks
from elastocal.calibration.lacking import lacking
from elastocal.calibration.nested import Ladder
from elastocal.calibration.parameters import COMPLIANCE, PAYLOAD, TOOL
from elastocal.errors import Doubt
from elastocal.robot.geometry import ANGLES, GROUPS

_BY_CHANCE = 0.01  # of a tracker that stands still, below which it seems to have been knocked
_FAR = 5.0  # priors that a geometric error is away, beyond which it is no small error
_MUCH = 2.0  # scatter of the model over that of the instrument that is worth a word
_FEW = 1.5  # readings' numbers over unknowns that are told, below which hardly any check is left


def doubts(found: Calibration, grown: Ladder | None = None) -> tuple[Doubt, ...]:
    """What a user must know of a calibration."""
    p, odd = found.parameters, []
    numbers = 3 * len(found.positions)
    if numbers < _FEW * found.redundancy.told:
        odd.append(
            Doubt("hardly-checked", (), (), {"numbers": numbers, "told": found.redundancy.told})
        )
    odd += [
        knocked(found.positions, knock)
        for knock in likeliest_knocks(found)
        if knock.p_value < _BY_CHANCE
    ]
    error = found.standard_error
    for u in p.of(COMPLIANCE):
        at = int(u) - p.arm - p.geometry
        value = float(found.state.compliance[at])
        if value < 0.0 and found.redundancy.seen[u]:
            far = abs(value) / max(float(error[u]), 1e-300)
            odd.append(
                Doubt(
                    "spring-below-zero",
                    (p.names[u],),
                    () if _has_geometry(found) else ("geometry",),
                    {"value": value, "error": float(error[u]), "far": far},
                    p.kinds[u].compliance,
                )
            )
    hidden = [p.names[u] for u in p.of(COMPLIANCE, PAYLOAD) if not found.redundancy.seen[u]]
    if hidden:
        odd.append(Doubt("not-told", tuple(hidden)))
    odd += _payload_exact(found)
    first = p.arm
    mine = p.of(*GROUPS)
    size = np.abs(found.state.geometry) * np.linalg.norm(p.rows[:, mine], axis=0)
    far_off = [i for i in np.flatnonzero(size > _FAR) if found.redundancy.seen[first + i]]
    for unit in ("rad", "m"):
        own = [i for i in far_off if p.kinds[first + i].unit == unit]
        if own:
            values = {p.names[first + i]: float(found.state.geometry[i]) for i in own}
            odd.append(Doubt("large-errors", tuple(values), (), values, unit))
    odd += _scatter(found)
    odd += _lacking(found)
    if grown is not None and grown.proposed < len(grown.rungs) - 1:
        last, small = grown.rungs[-1], grown.rungs[grown.proposed]
        if np.isfinite(last.left_out):
            odd.append(
                Doubt(
                    "smaller-will-do",
                    (small.name,),
                    tuple(rung.name for rung in grown.rungs[grown.proposed + 1 :]),
                    {"small": small.left_out, "large": last.left_out},
                    "m",
                )
            )
    return tuple(odd)


def _has_geometry(found: Calibration) -> bool:
    """Whether geometric errors were sought, angles among them."""
    return ANGLES in found.parameters.block


def _payload_exact(found: Calibration) -> list[Doubt]:
    """That reflectors are told by the sag under a payload that counts as known exactly."""
    p, positions = found.parameters, found.positions
    hung = sorted({*positions.payload.tolist()} - {-1} - {*p.hung})
    told = [p.names[u] for u in p.of(TOOL) if found.redundancy.seen[u] and not p.held[u]]
    sags = bool(found.state.compliance.any()) and len({*positions.payload.tolist()}) > 1
    if not (hung and told and sags):
        return []
    return [Doubt("payload-exact", tuple(positions.payloads[i] for i in hung), tuple(told))]


def _lacking(found: Calibration) -> list[Doubt]:
    """That one thing more explains what the fit leaves."""
    lack = lacking(found)
    if lack is None:
        return []
    numbers = {"value": lack.value, "error": lack.error, "chance": lack.chance}
    return [Doubt("calibration-lacks", (lack.name,), (lack.block, *lack.alike), numbers, lack.unit)]


def _scatter(found: Calibration) -> list[Doubt]:
    """That the model scatters more than the instrument."""
    noise, p = found.noise, found.positions
    points = ~p.rotations
    if not points.any():
        return []
    own = float(np.sqrt(np.einsum("rii->", p.covariance[points]) / (3.0 * points.sum())))
    model = float(np.sqrt(np.mean(noise.own**2 + noise.shared**2)))
    if model < _MUCH * own:
        return []
    return [Doubt("model-scatters", (), (), {"model": model, "instrument": own}, "m")]
