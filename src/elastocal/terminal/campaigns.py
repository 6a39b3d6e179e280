"""Virtual campaigns as tables: predicted errors beside found ones."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.simulation.campaigns import MonteCarlo, RandomCampaigns
from elastocal.terminal.console import out, whole


def show_campaigns(found: MonteCarlo) -> None:
    """Errors after compensation, and how well the intervals hold."""
    whole(_errors(found))
    whole(_estimates(found))
    if found.random is not None:
        out.print(Text(_random(found.random)))
    if found.nuisance:
        out.print(
            "Each campaign was on a robot of its own, with the nuisance of the study, and fitted "
            "it; ρ0 is what the plan promises. Friction and discrepancy at the task come on top."
        )
    for one in found.plans:
        out.print(
            Text(
                f"{one.name}: with 95 % below {1e6 * one.limit:.4g} µm by the plan; "
                f"{100 * one.within:.1f} % of the campaigns were."
            )
        )
    if found.known:
        names = ", ".join(found.known)
        out.print(Text(f"{names}: not identified in this study; taken as known."))
    for one in found.plans:
        # Four standard deviations of a share of 95 % that is found in K campaigns.
        if one.coverage.min() < 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / found.number):
            worst = found.springs[int(one.coverage.argmin())]
            out.print(
                Text(
                    f"{one.name}: the 95 % interval of {worst} held the truth in only "
                    f"{100 * one.coverage.min():.1f} % of the campaigns; the fit leaves something "
                    "out that is in the simulation."
                )
            )


def _random(plans: RandomCampaigns) -> str:
    """What the random plans are."""
    middle = np.median(plans.rho0_each)
    said = (
        f"{plans.name}: random configurations that the study allows, {plans.total.shape[1]} "
        f"campaigns of each; ρ0 of a plan {1e6 * middle:.4g} µm in the median, "
        f"{1e6 * plans.rho0:.4g} in the RMS"
    )
    left_out = plans.drawn - len(plans.rho0_each)
    return said + (f"; {left_out} that identify nothing are left out" if left_out else "")


def _table(title: str) -> Table:
    return Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1))


def _errors(found: MonteCarlo) -> Table:
    truth = "linear" if found.linear else "nonlinear"
    table = _table(
        f"position error after compensation [µm]: {found.number} campaigns, {truth} truth, "
        f"{found.how.model} fit"
    )
    table.add_column("plan", no_wrap=True)
    for column in ("m", "ρ0", "RMS", "mean", "5 %", "median", "95 %"):
        table.add_column(column, justify="right", no_wrap=True)
    random = () if found.random is None else (found.random,)
    for one in (*found.plans, *random):
        low, median, high = np.quantile(one.total, [0.05, 0.5, 0.95])
        lengths = (one.rho0, one.rms, float(one.total.mean()), low, median, high)
        table.add_row(one.name, str(one.experiments), *(f"{1e6 * v:.4g}" for v in lengths))
    return table


def _estimates(found: MonteCarlo) -> Table:
    table = _table("estimates: bias in standard errors; spread over the predicted; 95 % intervals")
    table.add_column("plan", no_wrap=True)
    table.add_column("")
    for name in found.springs:
        table.add_column(name, justify="right", no_wrap=True)
    for one in found.plans:
        table.add_row(one.name, "bias", *(f"{v:+.2f}" for v in one.bias))
        table.add_row("", "spread", *(f"{v:.3f}" for v in one.spread))
        table.add_row("", "cover", *(f"{100 * v:.1f} %" for v in one.coverage))
    return table
