"""What a plan.json says, by the kind of every key; the readers of its sections look at the values.

Keys of other programs may stand beside these.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from elastocal.errors import PlanFileError
from elastocal.files.problems import first_problem
from elastocal.files.sections import OpenSection, SectionError
from elastocal.files.values import AtLeastZero, Finite, Flag, Name, Natural, Share
from elastocal.files.yaml_lines import Located


class StudyOriginFile(OpenSection):
    """The study that a plan was made from."""

    name: str = ""
    sha256: str = ""
    text: str = ""
    robot_sha256: str = ""
    prior_sha256: str = ""
    paths_sha256: dict[str, str] | None = None


class NearestFile(OpenSection):
    """The constraint with the least room."""

    name: str = ""
    margin: Finite | None = None
    unit: str = ""


class PlannedCaseFile(OpenSection):
    """A load case, besides what is measured there."""

    done_after_min: AtLeastZero | None = None
    nearest_constraint: NearestFile | None = None


class WorstPointFile(OpenSection):
    """The worst point along a path."""

    points: Natural | None = None
    worst_mm: AtLeastZero | None = None
    worst_point: str = ""


class StandardErrorFile(OpenSection):
    """The standard error of one compliance; null where it is infinite."""

    value: AtLeastZero | None = None
    unit: str = ""


class WeighedCaseFile(OpenSection):
    """A load case of the continuous design."""

    weight: AtLeastZero


class PeakFile(OpenSection):
    """The load case of the largest sensitivity."""

    ratio: AtLeastZero | None = None


class ProvedDoubtFile(OpenSection):
    """What a proof leaves out."""

    code: str = ""
    about: list[str] | None = None
    numbers: dict[str, Finite] | None = None
    unit: str = ""


class ProvedFile(OpenSection):
    """What is proved of the bound."""

    lower_bound_mm: AtLeastZero | None = None
    lower_bound: AtLeastZero | None = None
    reachable_mm: AtLeastZero | None = None
    reachable: AtLeastZero | None = None
    gap: Share | None = None
    efficiency: Share | None = None
    largest: AtLeastZero | None = None
    boxes: Natural | None = None
    seconds: AtLeastZero | None = None
    ended: Literal["reached", "time", "stopped", "open"] = "reached"
    doubts: list[ProvedDoubtFile] | None = None
    record: Name | None = None
    sha256: str = ""

    def contradiction(self) -> str:
        """What is proved must be said, and be within reach."""
        for bound, reach in (
            (self.lower_bound_mm, self.reachable_mm),
            (self.lower_bound, self.reachable),
        ):
            if bound is not None and reach is not None:
                more = bound > reach * (1.0 + 1e-6)
                return f"lower_bound {bound:g} is above reachable {reach:g}" * more
        return "expected lower_bound_mm and reachable_mm, or lower_bound and reachable"


class CertificateFile(OpenSection):
    """How far a plan can be from the best."""

    kind: str = ""
    criterion: str = ""
    why: str = ""
    efficiency: Share | None = None
    fresh_starts: Natural | None = None
    attained: Natural | None = None
    narrow_starts: Natural | None = None
    narrow_attained: Natural | None = None
    rarest: Natural | None = None
    missed: Share | None = None
    floored: Flag = False
    left_out: list[str] | None = None
    peak: PeakFile | None = None
    continuous_design: list[WeighedCaseFile] | None = None
    proved: ProvedFile | None = None

    def contradiction(self) -> str:
        """What starts reached, of as many starts as there were."""
        searched = (self.fresh_starts, self.narrow_starts)
        for key, starts in (
            ("attained", searched[:1]),
            ("narrow_attained", searched[1:]),
            ("rarest", searched),
        ):
            some, among = getattr(self, key), [n for n in starts if n is not None]
            if some is not None and len(among) == len(starts) and some > sum(among):
                return f"{key} is {some}, of only {sum(among)} starts"
        if (self.kind == "rigorous") != (self.proved is not None):
            return "a certificate is of kind 'rigorous' if, and only if, it has a section 'proved'"
        for key, bound in self.others.items():
            if key.endswith("_lower_bound_mm") and isinstance(bound, (int, float)) and bound < 0.0:
                return f"{key}: expected 0 or a positive number, found {bound:g}"
        return ""


class SearchesFile(OpenSection):
    """Independent searches for the plan, and how far they are apart."""

    count: Natural | None = None
    stopped_after: Natural | None = None
    apart: AtLeastZero | None = None


class AfterFile(OpenSection):
    """What was measured before."""

    measurements: str = ""
    sha256: str = ""
    experiments: Natural | None = None


class KnownFile(OpenSection):
    """What was known of further springs."""

    file: str = ""
    sha256: str = ""
    planned: Flag = False


class NuisanceSizeFile(OpenSection):
    """What counts besides, with its standard uncertainty."""

    standard_uncertainty: AtLeastZero | None = None
    unit: str = ""
    source: str = ""


class PromiseFile(OpenSection):
    """What a plan promises with nuisance."""

    rho0_each_mm: dict[str, AtLeastZero | None] | None = None
    standard_error: dict[str, StandardErrorFile] | None = None
    optimised: str = ""
    nuisance: dict[str, NuisanceSizeFile] | None = None
    errors: dict[str, Any] | None = None


class PlanFile(OpenSection):
    """A whole plan file."""

    made_by: str = ""
    study: StudyOriginFile | None = None
    criterion: Name | None = None
    seed: Natural | None = None
    experiments: Natural | None = None
    searches: SearchesFile | None = None
    load_cases_sha256: str = ""
    free_joints: list[str] | None = None
    schedule: dict[str, AtLeastZero] | None = None
    after: AfterFile | None = None
    known: KnownFile | None = None
    rho0_mm: AtLeastZero | None = None
    rho0_each_mm: dict[str, AtLeastZero | None] | None = None
    paths: dict[str, WorstPointFile] | None = None
    standard_error: dict[str, StandardErrorFile] | None = None
    covariance: dict[str, Any] | None = None
    remarks: list[str] | None = None
    doubts: list[dict[str, Any]] | None = None
    criteria: dict[str, Any] | None = None
    certificate: CertificateFile | None = None
    promise: PromiseFile | None = None
    robust: dict[str, Any] | None = None
    blind: dict[str, Any] | None = None
    mends: list[dict[str, Any]] | None = None


class PlannedCasesFile(OpenSection):
    """The load cases of a plan, besides what is measured there."""

    load_cases: list[PlannedCaseFile]


def check_kinds(document: dict[str, Any], path: Path, model: type[OpenSection] = PlanFile) -> None:
    """Refuse a plan with a key of another kind than it should be.

    Raises:
        PlanFileError: names the first such key.
    """
    try:
        model.of(document)
    except SectionError as error:
        raise PlanFileError(first_problem(Located(document, {}, path), error, model)) from None
