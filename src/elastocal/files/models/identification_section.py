"""What an identification adds to a model file: how it was fitted, and what to make of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.plans.load_case_entries import load_case_entries
from elastocal.identification.doubts import doubts
from elastocal.identification.left_out_error import left_out_error
from elastocal.identification.nuisance_found import nuisance_found
from elastocal.identification.result import Identification
from elastocal.identification.search import Searched
from elastocal.identification.validation import Validation, summary
from elastocal.wording import worded


def identification_sections(
    found: Identification, beyond: Searched | None = None
) -> dict[str, Any]:
    """The sections `identification` and `diagnostics` of a model file."""
    how, lack, weak = found.how, found.lack_of_fit, doubts(found)
    weak = (*weak, *(() if beyond is None else beyond.doubts))
    return {
        "identification": {
            "identified": list(found.identified),
            "model": how.model,
            "sigma": how.sigma,
            "loss": how.loss,
            **({} if how.fitted == "mixed" else {"fitted": how.fitted}),
            "nonnegative": how.nonnegative,
            "confidence": how.confidence,
            "interval": _named(found, found.interval.tolist()),
            "linear_model": _named(found, found.linear.tolist()),
            "iterations": found.iterations,
            "experiments": len(found.measurements.cases),
            "readings": len(found.measurements),
            "load_cases": _load_cases(found),
            **nuisance_section(found),
        },
        "diagnostics": {
            "remarks": [worded(doubt) for doubt in weak],
            "doubts": doubt_entries(weak),
            "scale_of_noise": found.scale,
            **(
                {"scale_of_noise_by_kind": {n.kind.name: n.scale for n in found.noise_of_kinds}}
                if len(found.noise_of_kinds) > 1
                else {}
            ),
            "chi_square": found.chi_square,
            "degrees_of_freedom": found.dof,
            "lack_of_fit": None if lack is None else vars(lack),
            "correlation": found.correlation.tolist(),
            "singular_values": found.singular_values.tolist(),
            **{
                f"rms_residual_{_THOUSANDTH[kind.unit]}": 1e3
                * summary(found.residual[kind.readings]).rms
                for kind in found.measurements.quantities
            },
            "experiments": _experiments(found),
            "left_out": _left_out(found),
            **({} if beyond is None else _beyond(beyond)),
        },
    }


def _beyond(beyond: Searched) -> dict[str, Any]:
    """What was looked for: another convention of the joint values, and what the model lacks."""
    if beyond.convention is not None:
        return {"other_convention": doubt_entries([beyond.convention.doubt])[0]["numbers"]}
    assert beyond.lacks is not None
    missing = [one.candidate for one in beyond.lacks.missing]
    return {
        "candidates": [
            {
                **vars(one.candidate),
                "missing": one.candidate in missing,
                "p_value": one.p_value,
                "left_out_error_mm": 1e3 * one.left_out if np.isfinite(one.left_out) else None,
                "share_of_residual_variance": one.share,
                "size_SI": one.size.tolist(),
                "physical": one.physical,
                "changes": dict(zip(beyond.lacks.fitted, one.change.tolist(), strict=True)),
            }
            for one in beyond.lacks.tested
        ]
    }


def nuisance_section(found: Identification) -> dict[str, Any]:
    """What was fitted along, with its priors; and the springs that are sought without it."""
    if found.nuisance is None or found.alone is None:
        return {}
    alone = found.alone
    return {
        "nuisance": [
            {
                "name": one.name,
                "value": one.value,
                "standard_error": one.standard_error,
                "prior_mean": one.mean,
                "prior_uncertainty": one.deviation,
                "unit": one.unit,
                "held_at_zero": one.held,
                "source": one.source,
            }
            for one in nuisance_found(found)
        ],
        "joints_alone": {
            "compliance": _named(alone, alone.compliance.tolist()),
            "standard_error": _named(alone, alone.standard_error.tolist()),
            "left_out": _left_out(alone),
        },
    }


def _left_out(found: Identification) -> dict[str, Any]:
    """How far off what is left out in turn is predicted: load cases with all repeats, if it can."""
    error = left_out_error(found)
    return {
        "of": "load-cases" if error.load_cases else "experiments",
        "error_mm": 1e3 * error.seen if np.isfinite(error.seen) else None,
        "promised_mm": 1e3 * error.promised if np.isfinite(error.promised) else None,
    }


def _named(found: Identification, values: list[Any]) -> dict[str, Any]:
    return dict(zip(found.identified, values, strict=True))


def _load_cases(found: Identification) -> list[dict[str, Any]]:
    """The distinct load cases; none of a list that is too long to help."""
    cases = found.measurements.cases
    first = np.unique(found.configuration, return_index=True)[1]
    if len(first) > _MOST_CASES:
        return []
    return list(load_case_entries(found.arm.robot, cases.chosen(first)))


_MOST_CASES = 1000
_MOST = 10_000  # experiments listed one by one; a longer list helps nobody


def _experiments(found: Identification) -> list[dict[str, Any]]:
    """Leverage, Cook's distance and the worst reading of every experiment."""
    data = found.measurements
    if len(data.cases) > _MOST:
        return []
    kinds, size = data.quantities, np.linalg.norm(found.left_out, axis=1)
    worst = np.zeros((len(kinds), len(data.cases)))
    for own, kind in zip(worst, kinds, strict=True):
        np.maximum.at(own, data.case[kind.readings], size[kind.readings])
    weight = np.ones(len(data.cases))
    np.minimum.at(weight, data.case, found.weight)
    return [
        {
            "name": name,
            "leverage": float(found.influence.leverage[i]),
            "cook_distance": float(found.influence.cook[i]),
            **{
                f"left_out_error_{_THOUSANDTH[kind.unit]}": 1e3 * float(own[i])
                for own, kind in zip(worst, kinds, strict=True)
            },
            "weight": float(weight[i]),
        }
        for i, name in enumerate(data.names)
    ]


def validation_document(found: Validation) -> dict[str, Any]:
    """A validation for programs."""
    data = found.measurements
    each: list[dict[str, Any]] = [{"name": name} for name in data.names]
    sizes: dict[str, Any] = {}
    for kind in data.quantities:
        unit = _THOUSANDTH[kind.unit]
        for when, error in (("before", found.before), ("after", found.after)):
            sizes[f"{when}_{unit}"] = _thousandths(error[kind.readings])
            for entry, value in zip(each, found.by_experiment(error, kind), strict=True):
                entry[f"{when}_{unit}"] = 1e3 * float(value)
    return {
        "kept_aside": found.kept_aside,
        "repeated_load_cases": found.repeated,
        "experiments": len(data.cases),
        "readings": len(data),
        **sizes,
        "confidence": found.confidence,
        "coordinates": found.coordinates,
        "share_inside": found.inside,
        "chi_square": found.chi_square,
        "degrees_of_freedom": found.dof,
        "p_value": found.p_value if found.tested else None,
        "each": each[:_MOST],
    }


_THOUSANDTH = {"m": "mm", "rad": "mrad"}


def _thousandths(error: Any) -> dict[str, float]:
    return {name: 1e3 * value for name, value in vars(summary(error)).items()}
