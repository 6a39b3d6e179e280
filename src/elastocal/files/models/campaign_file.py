"""Campaign files: campaigns.json, what many virtual campaigns of plans came to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.elastic.springs import VirtualJoints
from elastocal.files.texts import json_text
from elastocal.simulation.campaigns import Campaigns, MonteCarlo, RandomCampaigns
from elastocal.writing import write_text

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


def write_campaigns(found: MonteCarlo, springs: VirtualJoints, path: str | Path) -> None:
    """Write campaigns.json; `springs` are those that the study fits."""
    write_text(Path(path), json_text(campaigns_document(found, springs)))


def campaigns_document(found: MonteCarlo, springs: VirtualJoints) -> dict[str, Any]:
    """The content of campaigns.json: millimetres; compliances in SI with their unit."""
    return {
        "elastocal": 1,
        "kind": "campaigns",
        "made_by": f"elastocal {__version__}",
        "campaigns": found.number,
        "seed": found.seed,
        "fit": {"model": found.how.model, "sigma": found.how.sigma},
        "linear_truth": found.linear,
        "nuisance": found.nuisance,
        "taken_as_known": list(found.known),
        "test_poses": list(found.test_poses),
        "plans": {one.name: _plan(found, one, springs) for one in found.plans},
        **({} if found.random is None else {"random": _random(found.random)}),
    }


def _random(plans: RandomCampaigns) -> dict[str, Any]:
    return {
        "experiments": plans.experiments,
        "drawn": plans.drawn,
        "rho0_mm": 1e3 * plans.rho0,
        **_sizes(plans),
        "rho0_each_mm": _rounded(1e3 * plans.rho0_each),
        "errors_mm": [_rounded(errors) for errors in 1e3 * plans.total],
    }


def _sizes(one: Campaigns | RandomCampaigns) -> dict[str, Any]:
    """What was found, over all campaigns."""
    quantiles = np.quantile(one.total, QUANTILES)
    return {
        "rms_mm": 1e3 * one.rms,
        "mean_mm": 1e3 * float(one.total.mean()),
        "quantiles_mm": {
            f"{q:g}": 1e3 * float(v) for q, v in zip(QUANTILES, quantiles, strict=True)
        },
    }


def _plan(found: MonteCarlo, one: Campaigns, springs: VirtualJoints) -> dict[str, Any]:
    statistic, chance = one.likelihood_ratio()
    each = zip(one.rho0_each, np.sqrt(np.mean(one.error**2, axis=0)), strict=True)
    return {
        "experiments": one.experiments,
        "rho0_mm": 1e3 * one.rho0,
        **_sizes(one),
        "limit_95_mm": 1e3 * one.limit,
        "share_within": one.within,
        "each_test_pose_mm": {
            name: {"rho0": 1e3 * float(rho), "rms": 1e3 * float(rms)}
            for name, (rho, rms) in zip(found.test_poses, each, strict=True)
        },
        "compliance": {
            name: {
                "unit": springs.kinds[i].compliance,
                "truth": float(one.truth[i]),
                "mean": float(one.estimate[:, i].mean()),
                "standard_error": float(one.predicted_error[i]),
                "standard_deviation": float(one.estimate[:, i].std(ddof=1)),
                "bias_over_standard_error": float(one.bias[i]),
                "coverage_95": float(one.coverage[i]),
            }
            for i, name in enumerate(found.springs)
        },
        "covariance_test": {"statistic": statistic, "p_value": chance},
        "errors_mm": _rounded(1e3 * one.total),
    }


def _rounded(values: Array) -> list[float]:
    """Six digits: enough for a histogram."""
    return [float(f"{v:.6g}") for v in values]
