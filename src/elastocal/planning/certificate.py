"""Certification: a bound on every plan of a study, and what it says of one plan.

In: a `Study`. Out: a `Bound`, computed before any plan is made; then a `Certificate` of load cases.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.design.continuous import (
    ContinuousDesign,
    continuous_design,
    taken_together,
)
from elastocal.design.criterion import Criterion, InformationFunction
from elastocal.design.dual_bound import ROUNDING, dual_bound_of
from elastocal.design.oracle import climb, sensitivity
from elastocal.design.power_mean import floored
from elastocal.design.space import information
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.matrices import confounded, square_root
from elastocal.planning.aim import Aim, aim_of
from elastocal.planning.assessment import Assessment
from elastocal.planning.plain_values import simplify
from elastocal.planning.proved import Proved
from elastocal.planning.shared_bound import largest_sum
from elastocal.stopping import Stop, Stopped, stoppable
from elastocal.study.criteria import CRITERIA, RHO0
from elastocal.study.study import Study

Progress = Callable[[str, float], None]
"""(what is going on, share done between 0 and 1) -> None."""

_FLOOR = 1e-4  # share of the loss that a floor adds
_ROUNDING = 1e-5  # share of what a criterion asks for that is rounding
_BEST = 100  # summits of one number of repeats that the search for another begins with
_SAME = 1e-9  # share by which a plan may be better than what is proved: rounding
_OPEN = 0.1  # gap between value and bound that only a singular optimum leaves


KINDS = ("rigorous", "numerical", "none")
"""What certificates there are: a bound that is proved, one that rests on a search, or no bound."""


@dataclass(frozen=True)
class Certificate:
    """How far any plan can be from the best of all plans with as many experiments.

    Attributes:
        criterion: Name of the criterion it speaks of.
        kind: "rigorous": a bound is proved, see `proved`; "numerical": the bound rests on a
            multistart search; "none": no bound is known.
        lower_bound: No plan has a smaller loss 1/√φ: ρ0 [m] for test-pose criteria. It rests on
            the search, whatever is proved beside it.
        efficiency: φ of the plan over the bound: 0.9 means that at best 10 % of the experiments
            could be saved, where nothing was known before: then φ grows as their number.
        fresh_starts: Distinct fresh random starts that failed to refute the bound.
        attained: How many of them reached the same maximum.
        support: Load cases of the continuous design behind the bound, those of nearly the same
            information taken together.
        weights: (S,) their weights.
        peak: The load case where the sensitivity is largest.
        peak_ratio: Sensitivity there over the mean over the support: 1 at an optimum.
        floored: Whether a floor kept the unknowns that the criterion ignores identifiable.
        left_out: What that criterion ignores: unknowns, and combinations of unknowns.
        narrow_starts: Further starts that failed, in narrow or cut-off parts of the cell.
        narrow_attained: How many of them reached the same maximum.
        rarest: How many of all these starts found that load case of the support which fewest found.
        stopped: Whether no bound is known because the search was stopped before there was one.
        promise: Whether it speaks of what plans promise, errors of load cases included.
        proved: What is proved; None if nothing is.
    """

    criterion: str
    kind: str
    lower_bound: float = 0.0
    efficiency: float = float("nan")
    fresh_starts: int = 0
    attained: int = 0
    support: LoadCases | None = None
    weights: Array | None = None
    peak: LoadCases | None = None
    peak_ratio: float = float("nan")
    floored: bool = False
    left_out: tuple[Doubt, ...] = ()
    narrow_starts: int = 0
    narrow_attained: int = 0
    rarest: int = 0
    stopped: bool = False
    promise: bool = False
    proved: Proved | None = None

    @property
    def gap(self) -> float:
        """By which share the proved bound is below the one of the search; 1 if nothing is."""
        return 1.0 if self.proved is None else 1.0 - self.proved.loss / self.lower_bound

    @property
    def missed(self) -> float:
        """Share of random starts that can lead to a better maximum and all miss it, by 95 %.

        Source: N starts all miss what a share s of them leads to with the chance (1 - s)^N.
        """
        return float(1.0 - 0.05 ** (1.0 / max(self.fresh_starts, 1)))

    @property
    def symbol(self) -> str:
        """What is bounded, as people call it: "ρ0", "a promise"; the name of other criteria."""
        return "a promise" if self.promise else CRITERIA[self.criterion].symbol or self.criterion

    @property
    def position_bound(self) -> float | None:
        """No plan has a smaller position error of this kind [m]; None if it speaks of another."""
        speaks = self.kind != "none" and CRITERIA[self.criterion].is_position_error
        return self.lower_bound if speaks else None

    @property
    def rho0_bound(self) -> float | None:
        """No plan has a smaller ρ0, or promise [m]; None if it does not speak of these."""
        return self.position_bound if self.criterion == RHO0.name else None


@dataclass(frozen=True)
class Bound:
    """What is known of the best plan before any plan is made.

    Attributes:
        aim: What plans are to be good for.
        target: What the search optimises: the criterion, with a floor if its optimum is singular,
            unless it was stopped before that was known.
        design: The continuous design; None for a criterion without certificate, or if stopped.
        stopped: Whether the search for it was stopped before all starts had tried it.
        uneven: By how much repeats that are dealt out unevenly to few load cases may add to the
            largest sensitivity, as a factor; 1 where repeats share no error.
    """

    aim: Aim
    target: Criterion
    design: ContinuousDesign | None
    stopped: bool = False
    uneven: float = 1.0

    def upper(self, count: int) -> float:
        """No plan of `count` experiments has a larger φ."""
        if self.design is None:
            return float("inf")
        dual = self.design.certificate
        return count * (dual.offset + self.uneven * dual.largest)

    def loss(self, count: int) -> float:
        """No plan of `count` experiments has a smaller loss: ρ0 [m] for test poses."""
        return 0.0 if self.design is None else self.aim.loss(self.upper(count))

    @property
    def floored(self) -> bool:
        """Whether the search has a floor under the unknowns the criterion ignores."""
        return self.target is not self.aim.criterion


def lower_bound(
    study: Study,
    rng: np.random.Generator,
    *,
    known: Array | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Bound:
    """Bound on every plan with as many experiments as the study has.

    A bound that is not yet tried from fresh starts bounds nothing: stopped before, there is none.

    Args:
        study: The study.
        rng: Source of candidates and fresh starts.
        known: (K, d) feasible design points to begin with.
        progress: Told the gap as it closes.
        stop: Asked now and then whether to end.
    """
    aim = aim_of(study)
    criterion, space, base = aim.criterion, aim.space, aim.base / aim.count
    if not isinstance(criterion, InformationFunction):
        return Bound(aim, criterion, None)
    gaps: list[float] = []

    def tell(what: str, gap: float) -> None:
        gaps.append(gap)
        if progress is not None:
            closed = -np.log10(max(min(gaps), 1e-6)) / 6.0
            shown = what if np.isinf(gap) else f"{what}, gap {gap:.0e}"
            progress(shown, 0.4 * float(np.clip(closed, 0.0, 1.0)))

    search = partial(
        continuous_design,
        space,
        rng=rng,
        base=base,
        known=known,
        tolerance=aim.tolerance,
        progress=tell,
    )
    try:
        with stoppable(stop):
            design = search(criterion)
            if design.gap < _OPEN and not design.singular:
                return Bound(aim, criterion, design, uneven=_uneven(aim, design, rng))
            target = with_floor(aim, criterion, space.sample(500, rng))
            design = search(target, certified=criterion)
            return Bound(aim, target, design, uneven=_uneven(aim, design, rng))
    except Stopped:
        return Bound(aim, criterion, None, stopped=True)


def with_floor(aim: Aim, criterion: InformationFunction, x: Array) -> InformationFunction:
    """The criterion with a floor under what it may ignore, by random feasible points x (N, d)."""
    usual = information(aim.space.evaluate(x).blocks).mean(axis=0)
    return floored(criterion, aim.base / aim.count + usual, _FLOOR)


def _uneven(aim: Aim, design: ContinuousDesign, rng: np.random.Generator) -> float:
    """Factor to the largest sensitivity of a design, so that it bounds all plans of few load cases.

    The design is of load cases that are all measured as often.
    """
    if aim.count == aim.distinct or not aim.shares:
        return 1.0
    dual = design.certificate

    def most(repeats: int) -> float:
        space = aim.space.measured_together(float(repeats))
        best = np.argsort(-dual.s_found)[:_BEST]
        bound = dual_bound_of(space, dual.gradient, dual.offset, dual.x_found[best], rng)
        return repeats * bound.largest

    return max(largest_sum(most, aim.count, aim.distinct) / (aim.count * dual.largest), 1.0)


def confirmed(
    study: Study,
    bound: Bound,
    x: Array,
    rng: np.random.Generator,
    *,
    attempts: int = 3,
    stop: Stop | None = None,
) -> Bound:
    """The bound, after climbing from the points `x` of a plan has failed to refute it.

    If it is refuted, a new one is computed that knows where the climb ended, `attempts` times. If
    that goes on, or if a point is more sensitive by less than the search can tell, the bound is
    raised to it: no plan of these points is beyond the bound. Stopped on the way there is none.
    """
    design, space = bound.design, bound.aim.space
    if design is None:
        return bound
    dual = design.certificate
    found, s, _ = climb(space, x, dual.gradient, ((150, len(x)),))
    found = np.concatenate([found, x])
    s = np.append(s, sensitivity(space, x, square_root(dual.gradient)))
    if s.max() > dual.largest * (1.0 + bound.aim.tolerance) and attempts:
        bound = lower_bound(study, rng, known=found[s > 0.0], stop=stop)
        return confirmed(study, bound, x, rng, attempts=attempts - 1, stop=stop)
    if s.max() <= dual.largest * (1.0 + ROUNDING):
        return bound
    best = int(s.argmax())
    raised = replace(dual, largest=float(s[best]), x_largest=found[best])
    return replace(bound, design=replace(design, certificate=raised))


def certificate(study: Study, bound: Bound, worth: Assessment, count: int) -> Certificate:
    """What `bound` says of a plan of `count` experiments that is worth `worth`."""
    aim = bound.aim
    if bound.design is None:
        return Certificate(study.criterion, "none", stopped=bound.stopped, promise=aim.promise)
    design, dual, space = bound.design, bound.design.certificate, aim.space
    value = worth_by(aim, worth)
    upper = max(bound.upper(count), value)  # but for rounding it is above anyway
    level = float(np.einsum("i,ijk,jk->", design.weights, design.informations, dual.gradient))
    points, weights = taken_together(design.informations, design.weights)
    support = simplify(space, space.load_cases(design.x[points])).cases
    peak = simplify(space, space.load_cases(dual.x_largest[None])).cases
    return Certificate(
        criterion=study.criterion,
        kind="numerical",
        lower_bound=aim.loss(upper),
        efficiency=value / upper,
        fresh_starts=dual.starts,
        attained=dual.attained,
        narrow_starts=dual.narrow_starts,
        narrow_attained=dual.narrow_attained,
        rarest=dual.rarest,
        support=support,
        weights=frozen(weights),
        peak=peak,
        peak_ratio=dual.largest / level,
        floored=bound.floored,
        left_out=left_out(study, design) if bound.floored else (),
        promise=aim.promise,
    )


def with_proof(
    certificate: Certificate, aim: Aim, proved: Proved, *, feasible: bool = True
) -> Certificate:
    """The certificate of a plan with what was proved of its bound.

    Args:
        certificate: A numerical one.
        aim: What the plan is to be good for.
        proved: What was proved; nothing, if its loss is 0.
        feasible: Whether the plan is; of others nothing is proved.

    Raises:
        InputError: the plan itself is better than what no plan is said to be: that proof is none.
    """
    if certificate.kind == "none" or proved.loss <= 0.0:
        return certificate
    value = certificate.efficiency * aim.value(certificate.lower_bound)
    if feasible and aim.loss(value) < proved.loss * (1.0 - _SAME):
        raise InputError(
            f"of the criterion {certificate.criterion} the plan has {aim.loss(value):.9g}, where "
            f"no plan is said to have less than {proved.loss:.9g}: such a proof is none"
        )
    share = min(value / aim.value(proved.loss), 1.0)
    return replace(
        certificate,
        kind="rigorous",
        # What is proved is known as well as anything that a search found.
        lower_bound=max(certificate.lower_bound, proved.loss),
        efficiency=max(certificate.efficiency, share),
        proved=replace(proved, efficiency=share),
    )


def worth_by(aim: Aim, worth: Assessment) -> float:
    """φ of a plan, by what plans are to be good for."""
    if aim.promise and worth.promise is not None:
        return aim.value(worth.promise.rho0)
    return float(aim.criterion.value(worth.information[None])[0])


def left_out(study: Study, design: ContinuousDesign) -> tuple[Doubt, ...]:
    """The unknowns that the criterion does not ask for, and those it asks for together only.

    Source: ours. For φ = 1 / tr(L M⁻¹) with gradient G the matrix M G M is L but for a factor; what
    is in its null space may be unknown, and nothing of φ is lost.
    """
    springs, scale = study.fitted, np.sqrt(np.diagonal(design.total))
    asked = design.total @ design.certificate.gradient @ design.total
    values, vectors = np.linalg.eigh(asked / np.outer(scale, scale))
    rows = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    rows = np.where(np.abs(rows) > _ROUNDING * np.abs(rows).max(), rows, 0.0)
    asked = (rows * scale).T @ (rows * scale)
    found = []
    for group in confounded(asked):
        names = tuple(springs.names[i] for i in group.members)
        if not group.seen:
            found.append(Doubt("criterion-ignores", names))
            continue
        numbers = {"seen": float(group.seen)}
        if group.seen == 1 and len({springs.kinds[i] for i in group.members}) == 1:
            own = asked[np.ix_(group.members, group.members)]
            seen = own[np.abs(np.diagonal(own)).argmax()]
            seen = seen / np.linalg.norm(seen) * np.sign(seen[0] or 1.0)
            numbers |= {f"of {name}": float(v) for name, v in zip(names, seen, strict=True)}
        found.append(Doubt("criterion-together", names, numbers=numbers))
    return tuple(found)
