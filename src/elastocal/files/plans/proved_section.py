"""What is proved, in the certificate of a plan.json, and read back."""

from __future__ import annotations

import math
from typing import Any

from elastocal.errors import Doubt
from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.plans.load_case_entries import finite_at
from elastocal.planning.certificate import Certificate
from elastocal.planning.proved import Proved
from elastocal.wording import worded

_CODES = {
    code: code
    for code in (
        "proof-leaves-out",
        "proof-best-noise",
        "proof-without-errors",
        "proof-without-shared-noise",
    )
}


def proved_section(certificate: Certificate) -> dict[str, Any]:
    """The section `proved`; empty if nothing is."""
    proved = certificate.proved
    if proved is None:
        return {}
    is_length = certificate.position_bound is not None
    scale, end = (1e3, "_mm") if is_length else (1.0, "")
    section = {
        f"lower_bound{end}": scale * proved.loss,
        f"reachable{end}": scale * proved.reachable,
        "gap": max(certificate.gap, 0.0),
        **({} if math.isnan(proved.efficiency) else {"efficiency": proved.efficiency}),
        "largest": proved.largest,
        "boxes": proved.boxes,
        "seconds": proved.seconds,
        "ended": proved.ended,
        "left_out": [worded(doubt) for doubt in proved.left_out],
        "doubts": doubt_entries(proved.left_out),
        **({"record": proved.record, "sha256": proved.sha256} if proved.record else {}),
    }
    return {"proved": section}


def claimed_proof(section: dict[str, Any], where: str) -> Proved | None:
    """What the section `certificate` claims to be proved; None if it claims nothing.

    Its keys are of their kinds already; see `plan_schema.py`.

    Raises:
        PlanFileError: a number is none.
    """
    entry = section.get("proved")
    if entry is None:
        return None
    end, scale = ("_mm", 1e-3) if "lower_bound_mm" in entry else ("", 1.0)

    def value(key: str, scale: float = 1.0) -> float:
        return scale * finite_at(entry[key], f"{where}, proved: {key}")

    return Proved(
        loss=value(f"lower_bound{end}", scale),
        reachable=value(f"reachable{end}", scale),
        largest=value("largest") if "largest" in entry else math.nan,
        boxes=entry.get("boxes") or 0,
        seconds=value("seconds") if "seconds" in entry else math.nan,
        ended=entry.get("ended", "reached"),
        left_out=tuple(_doubt(doubt) for doubt in entry.get("doubts") or () if _said(doubt)),
        record=entry.get("record") or "",
        sha256=entry.get("sha256", ""),
        efficiency=value("efficiency") if "efficiency" in entry else math.nan,
    )


def _said(entry: dict[str, Any]) -> bool:
    """Whether a doubt is one of proofs, with the numbers of its sentence."""
    code = entry.get("code")
    return code in _CODES and (
        code != "proof-best-noise" or "sigma" in (entry.get("numbers") or {})
    )


def _doubt(entry: dict[str, Any]) -> Doubt:
    numbers = {name: float(value) for name, value in (entry.get("numbers") or {}).items()}
    about = tuple(entry.get("about") or ())
    return Doubt(entry["code"], about, numbers=numbers, unit=entry.get("unit", ""))
