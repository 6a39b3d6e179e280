"""What a report shows after the plan: recomputed from the files, never read out of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.arrays import IntArray
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.elastic.load_cases import LoadCases
    from elastocal.identification.result import Identification
    from elastocal.identification.validation import Validation
    from elastocal.planning.plan import Plan
    from elastocal.simulation.monte_carlo import MonteCarlo
    from elastocal.study.study import Study

_SAME = 1e-6  # difference in standard errors up to which a model is that of the measurements


@dataclass(frozen=True)
class Files:
    """Files of a campaign, as far as there are any.

    Attributes:
        measurements: What was measured.
        model: The model that was made of it; it says how.
        mapping: What foreign headers mean.
        prior: Model from before, weighed by its covariance.
        known: Model of further joints, taken as it is.
        validation: What was measured and kept aside.
        path: Path of the task, as it is wanted.
        truth: True compliances, for virtual campaigns.
    """

    measurements: list[Path] = field(default_factory=list)
    model: Path | None = None
    mapping: Path | None = None
    prior: Path | None = None
    known: Path | None = None
    validation: list[Path] = field(default_factory=list)
    path: Path | None = None
    truth: Path | None = None

    @property
    def all(self) -> list[Path]:
        """Every file."""
        single = (self.model, self.mapping, self.prior, self.known, self.path, self.truth)
        return [*self.measurements, *self.validation, *(p for p in single if p is not None)]


def stages(study: Study, files: Files, tool: str | None, confidence: float) -> dict[str, Any]:
    """Identification, validation and compensation, as keyword arguments of `report.html`."""
    from elastocal.cli.identify import model_at

    truth, model = model_at(files.truth, study), model_at(files.model, study)
    found = _identified(study, files, model, confidence)
    model = found.model if found is not None else _with(model, model_at(files.known, study))
    shown: dict[str, Any] = {"identification": found, "references": _references(study, files)}
    shown["validation"] = _validated(study, files, model, found, confidence)
    if files.path is not None:
        if model is None:
            raise InputError(f"{files.path}: a path needs --measurements or --model to correct it")
        shown |= compensated(study, files.path, model, truth, tool)
    return shown


def _with(model: ComplianceModel | None, known: ComplianceModel | None) -> ComplianceModel | None:
    """A model with that of further joints, unless it has them already."""
    from elastocal.elastic.compliance_model import merged_models

    if model is None or known is None or set(known.names) <= set(model.names):
        return model
    return merged_models([model, known])


def virtual_campaigns(
    plan: Plan, others: dict[str, tuple[LoadCases, IntArray]], truth: ComplianceModel, number: int
) -> MonteCarlo:
    """Many virtual campaigns of the plan and of others: load cases with repeats, by name."""
    from elastocal.cli.common import progress
    from elastocal.simulation.monte_carlo import campaigns

    named = {"this plan": (plan.load_cases, plan.repeats)} | others
    with progress("campaigns") as tell:
        return campaigns(plan.study, truth, named, number, seed=plan.seed, progress=tell)


def _identified(
    study: Study, files: Files, model: ComplianceModel | None, confidence: float
) -> Identification | None:
    """The fit, once more; refused if it does not give the model that is named with it."""
    import numpy as np

    from elastocal.cli.identify import fitted_again, model_at, readings
    from elastocal.files.models.model_file import model_sections

    if not files.measurements:
        return None
    data = readings(study, files.measurements, files.mapping)
    sections = model_sections(files.model) if files.model is not None else {}
    prior, known = model_at(files.prior, study), model_at(files.known, study)
    found = fitted_again(study, data, sections, prior, known, confidence)
    if model is None or files.model is None:
        return found
    there = [name for name in found.identified if name in model.names]
    if len(there) < len(found.identified):
        missing = ", ".join(name for name in found.identified if name not in there)
        raise InputError(
            f"{files.model}: has no compliance of {missing}, which the study identifies"
        )
    off = np.abs(model.of(there) - found.compliance)
    if (off > _SAME * np.maximum(found.standard_error, 1e-6 * np.abs(found.compliance))).any():
        worst = int(np.argmax(off / np.maximum(np.abs(found.compliance), 1e-300)))
        raise InputError(
            f"{files.model}: is not the model that {data.source} gives; {there[worst]} is "
            f"{model.of(there)[worst]:.6g} there and {found.compliance[worst]:.6g} from these "
            "measurements; name the measurements, --prior and --known it was made from"
        )
    return found


def _references(study: Study, files: Files) -> dict[str, ComplianceModel]:
    """What is known from elsewhere, by name."""
    from elastocal.cli.identify import model_at

    named = {"prior": files.prior, "known": files.known, "truth": files.truth}
    found = {name: model_at(path, study) for name, path in named.items()}
    identified = set(study.springs.names)
    return {n: m for n, m in found.items() if m is not None and identified & set(m.names)}


def _validated(
    study: Study,
    files: Files,
    model: ComplianceModel | None,
    found: Identification | None,
    confidence: float,
) -> Validation | None:
    """On what was kept aside, else each experiment left out in turn."""
    from elastocal.cli.identify import readings
    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.identification.validation import leave_one_out, validate

    if not files.validation:
        return None if found is None else leave_one_out(found, confidence=confidence)
    if model is None:
        raise InputError(
            f"{files.validation[0]}: validation needs --measurements or --model, to have something "
            "to validate"
        )
    kept = kept_aside(readings(study, files.validation, files.mapping), study)
    if found is not None and kept.sha256 and kept.sha256 == found.measurements.sha256:
        raise InputError(
            f"{files.validation[0]}: these are the measurements the model was made from; leave "
            "--validation out, then every experiment is left out in turn"
        )
    return validate(study.arm, model, kept, confidence=confidence)


def compensated(
    study: Study,
    path: Path,
    model: ComplianceModel,
    truth: ComplianceModel | None,
    tool: str | None,
) -> dict[str, Any]:
    """The corrected path, judged by the truth if that is known."""
    from elastocal.cli.compensate import start_of, task_tool
    from elastocal.compensation.compensate import compensate, residual
    from elastocal.files.paths.path_file import read_path

    used = task_tool(study, tool)
    task = read_path(path, study.robot, used, start_of(study, used, None))
    arm = replace(study.arm, springs=model.springs, tool=used)
    done = compensate(arm, model, task.cases)
    if truth is None:
        return {"compensation": done}
    true_arm = replace(arm, springs=truth.springs)
    # Negative control: the same correction to the wrong side.
    mirrored = replace(done, q=2.0 * task.cases.q - done.q)
    return {
        "compensation": done,
        "judged": residual(true_arm, truth, done),
        "control": residual(true_arm, truth, mirrored),
    }
