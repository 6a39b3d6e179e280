"""Contents: everything a report may show, as one value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from elastocal.arrays import Array
from elastocal.compensation.compensate import Compensation
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.identification.result import Identification
from elastocal.identification.search import Searched
from elastocal.identification.validation import Validation
from elastocal.planning.assessment import Assessment
from elastocal.planning.plan import Plan
from elastocal.planning.trade_off import TradeOff
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.study.at_test_poses import AtTestPose


@dataclass(frozen=True)
class Contents:
    """What there is to report; every stage of a campaign may be missing.

    Attributes:
        plan: The plan with its study; certificate and run sheet come with it.
        trade_off: ρ0 over experiments and configurations; left out if None.
        random: (K,) ρ0 of random feasible plans with as many experiments [m].
        others: Other plans by name, to compare with.
        identification: The compliances found.
        searched: What else explains their readings.
        references: Compliances from elsewhere, by name, three at most: known before, or true.
        validation: The model against readings.
        compensation: A corrected path.
        judged: (N, 3) what remains of its error if the robot is as a true model says [m]; see
            `compensation.residual`.
        control: (N, 3) the same for a correction to the wrong side, which must be worse [m].
        monte_carlo: Virtual campaigns of plans side by side.
        at_test_poses: What the model says of the test poses: error left, stiffness.
    """

    plan: Plan | None = None
    trade_off: TradeOff | None = None
    random: Array | None = None
    others: Mapping[str, Assessment] = field(default_factory=dict)
    identification: Identification | None = None
    searched: Searched | None = None
    references: Mapping[str, ComplianceModel] = field(default_factory=dict)
    validation: Validation | None = None
    compensation: Compensation | None = None
    judged: Array | None = None
    control: Array | None = None
    monte_carlo: MonteCarlo | None = None
    at_test_poses: tuple[AtTestPose, ...] = ()
