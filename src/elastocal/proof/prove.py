"""Proof of a bound: no plan of a study has a smaller loss, as a theorem about its model.

In: a `Study` and its numerical `Bound`. Out: a `Proof`, with the tree of boxes that shows it.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from elastocal.arrays import Array
from elastocal.core.layout import OPEN
from elastocal.core.library import Library, library
from elastocal.errors import Doubt, ElastocalError, InputError
from elastocal.planning.certificate import Bound
from elastocal.proof.boxes import Boxes
from elastocal.proof.branching import Branching, BranchingState
from elastocal.proof.plain_data import as_data
from elastocal.proof.posing import posed
from elastocal.proof.reductions import reduced
from elastocal.proof.reference import best_force, margins, sensitivity, size_of_rows, within
from elastocal.proof.roots import into_root
from elastocal.proof.statement import Statement
from elastocal.proof.tree import Region, divided, leaf_at
from elastocal.proof.trigonometric import Thirds, third_derivatives
from elastocal.stopping import Stop
from elastocal.study.study import Study

GAPS = (0.2, 0.1, 0.05, 0.01, 1e-3, 1e-4)
"""Gaps between the numerical bound on the loss and the proved one, in turn."""
_SHORT = 5.0  # seconds within which a gap is proved at once
_SURELY = 4.0  # times as long as foretold, within which a gap is proved
_SOONER = 3.0  # times as long as what is proved before it
_LOOK = 0.05  # share of the time that a prediction may take
_LONGEST_LOOK = 3.0  # seconds
_EFFORT = 0.3  # seconds of the first tables
_SHARE = 0.04  # of the time that better tables may take
_MOST_EFFORT = 60.0
_GOOD = 1.25  # factor of tables that are good enough
_KEEP = 20.0  # seconds after which what there is is kept
_KEEP_STEP = 1.0  # ... where a gap is proved
_PARTS = 1024
_WITNESSES = 60
_AGREE = 1e-9
_EQUAL = 2e-11  # share of what rows are made of


class ProofError(ElastocalError):
    """A proof contradicts itself: nothing is claimed."""


@dataclass(frozen=True)
class Progress:
    """How far a proof is.

    Attributes:
        gap: What is being proved: relative gap on the loss.
        done: Share of it.
        loss: What is proved already; 0: nothing.
        boxes: Boxes looked at.
        seconds: Since it began.
        left: Seconds that this gap takes still, about; inf: not known.
    """

    gap: float
    done: float
    loss: float
    boxes: int
    seconds: float
    left: float


@dataclass(frozen=True)
class Proof:
    """What was proved.

    Attributes:
        statement: What of which arm, with U and the bound on the loss if anything is proved.
        loss: No plan has a smaller one: ρ0 [m] for test poses; 0 if nothing is proved.
        numerical: The bound that a search found, by the same V [m]; no proof of this V is above.
        doubts: What is left out, so that it is weaker than it could be.
        boxes: Boxes looked at.
        seconds: How long it took.
        predicted: Seconds that were predicted, by gap.
        ended: Why it ended: "reached", "time", "stopped"; "open": boxes as small as can be stay, or
            a feasible point was met where d is above what was to be proved.
        refuted: (K, n) feasible configurations, some with a larger d than the search found.
        tree: Its boxes.
    """

    statement: Statement
    loss: float
    numerical: float
    doubts: tuple[Doubt, ...]
    boxes: int
    seconds: float
    predicted: tuple[tuple[float, float], ...]
    ended: str
    refuted: Array
    tree: Region

    @property
    def gap(self) -> float:
        """How far the proved bound is below the numerical one; 1 if nothing is proved."""
        return 1.0 - self.loss / self.numerical


def loss_of(s: Statement, beyond: float, largest: float) -> float:
    """No plan of a statement has a smaller loss, if d is at most `largest`.

    Source: Cauchy's inequality; see `statement.py`.
    """
    asked, known = _traces(s)
    with np.errstate(divide="ignore"):
        square = np.float64(max(asked, 0.0) ** 2) / (known + s.count * largest)
    return float(np.sqrt(square + beyond))


def largest_for(s: Statement, beyond: float, loss: float) -> float:
    """How large d may be so that no plan has a smaller loss; infinite if that is sure anyway."""
    asked, known = _traces(s)
    if loss**2 <= beyond:
        return np.inf
    return (asked**2 / (loss**2 - beyond) - known) / s.count


def _traces(s: Statement) -> tuple[float, float]:
    """tr(VᵀK) and tr(VᵀBV)."""
    return float(np.einsum("pr,pr->", s.V, s.K)), float(np.einsum("pr,pq,qr->", s.V, s.B, s.V))


def prove(
    study: Study,
    bound: Bound,
    *,
    known: Array | None = None,
    seconds: float | None = None,
    gap: float = GAPS[-1],
    threads: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    predicted: Callable[[Sequence[tuple[float, float]]], None] | None = None,
    stop: Stop | None = None,
    resumed: tuple[Statement, Region] | None = None,
    proved: Callable[[float, float], None] | None = None,
    saved: Callable[[Statement, Region], None] | None = None,
    rng: np.random.Generator | None = None,
) -> Proof:
    """Prove as much of a numerical bound as the time allows.

    Args:
        study: The study.
        bound: What is to be proved of it.
        known: (K, d) feasible design points, as of a plan: a proof must not exclude them.
        seconds: How long it may take; None: as long as it does.
        gap: What is far enough: relative gap on the loss.
        threads: How many; as many as there are cores if not given.
        progress: Told how far it is.
        predicted: Told once how long the gaps will take, about [s].
        stop: Asked now and then whether to end.
        resumed: A proof of the same statement to go on with, as `read_proof` has it.
        proved: Told each gap that has been proved, and the bound on the loss.
        saved: Given what there is now and then, to be kept.
        rng: Source of feasible points to try the proof with.

    Raises:
        InputError: there is no compiled core, or of the study no proof can be made; or what is to
            be gone on with proves something else.
        ProofError: a known point contradicts what was found.
    """
    compiled = library()
    if compiled is None:
        raise InputError(
            "proofs need the compiled core, which is not here; `elastocal --version` says why. "
            "Proofs that there are can be checked without it"
        )
    begun = time.monotonic()
    rng = rng or np.random.default_rng(0)
    asked = posed(study, bound, rng)
    smaller = reduced(asked.statement)
    statement, beyond = smaller.statement, asked.beyond
    points = _points(study, bound, known, rng)
    x = into_root(statement, points[:, : len(statement.joints)])
    d = sensitivity(statement, x)
    numerical = loss_of(statement, beyond, float(d.max()))
    gaps = (*(g for g in GAPS if g > gap), gap)
    equal = _EQUAL * size_of_rows(statement)
    thresholds = [
        float((np.sqrt(largest_for(statement, beyond, numerical * (1.0 - g))) - equal) ** 2)
        for g in gaps
    ]
    threads = threads or os.cpu_count() or 1
    budget = np.inf if seconds is None else seconds

    def over() -> bool:
        return time.monotonic() - begun > budget or (stop is not None and stop())

    root = None if resumed is None else _gone_on_with(statement, *resumed)
    search, times, third = _begun(compiled, statement, thresholds, threads, budget, root)
    expected = tuple(zip(gaps, times, strict=True))
    if predicted is not None:
        predicted(expected)
    ended, kept = "reached", time.monotonic()

    def told(g: float, start: float, expected: float, loss: float, state: BranchingState) -> None:
        nonlocal kept
        now = time.monotonic()
        if saved is not None and now - kept > _KEEP:
            saved(_with(statement, third, search.proved, equal), search.root)
            kept = now
        if progress is not None:
            left = expected if state.done < 0.05 else (now - start) * (1.0 / state.done - 1.0)
            progress(Progress(g, state.done, loss, state.boxes, now - begun, left))

    for g, threshold, time_of in _ladder(expected, thresholds, budget):
        loss = loss_of(statement, beyond, _enlarged(search.proved, equal))

        def ends(threshold: float = threshold) -> bool:
            return over() or search.best > threshold

        if search.prove(threshold, ends, partial(told, g, time.monotonic(), time_of, loss)):
            if saved is not None and time.monotonic() - kept > _KEEP_STEP:
                saved(_with(statement, third, search.proved, equal), search.root)
                kept = time.monotonic()
            if proved is not None:
                proved(g, loss_of(statement, beyond, _enlarged(search.proved, equal)))
            continue
        late = time.monotonic() - begun > budget
        ended = "time" if late else "stopped" if over() else "open"
        break
    largest = _enlarged(search.proved, equal)
    _try(statement, search.boxes, search.root, x, d, largest)
    loss = loss_of(statement, beyond, largest)
    found = statement.root[:1].copy()
    if search.best > 0.0:
        found[:, search.boxes.variables] = search.at
    better = found[sensitivity(statement, found) > d.max() * (1.0 + _AGREE)]
    shown = x[np.argsort(-d)[:_WITNESSES]]
    witnesses = np.hstack([shown, best_force(statement, shown)])
    return Proof(
        statement=replace(_with(statement, third, search.proved, equal), witnesses=witnesses),
        loss=loss,
        numerical=numerical,
        doubts=(*asked.doubts, *smaller.doubts),
        boxes=search.evaluated,
        seconds=time.monotonic() - begun,
        predicted=expected,
        ended=ended,
        refuted=better @ statement.mix.T,
        tree=search.root,
    )


def _begun(
    compiled: Library,
    statement: Statement,
    thresholds: Sequence[float],
    threads: int,
    budget: float,
    root: Region | None,
) -> tuple[Branching, list[float], Thirds]:
    """A search with tables that are worth their time, and how long thresholds take about [s]."""
    effort, look = _EFFORT, min(_LOOK * budget, _LONGEST_LOOK)
    while True:
        begun = time.monotonic()
        third = third_derivatives(statement, effort)
        took = time.monotonic() - begun
        boxes = Boxes(compiled, statement, third)
        first = divided(boxes, thresholds[0], _PARTS) if root is None else root
        search = Branching(boxes, first, threads)
        times = search.predicted(thresholds, look)
        worth = min(_SHARE * min(times[-1], budget), _MOST_EFFORT)
        if worth < _SOONER * took or third.factor < _GOOD or root is not None:
            return search, times, third
        effort *= worth / took


def _with(s: Statement, third: Thirds, proved: float, equal: float) -> Statement:
    """The statement with what is proved so far, but for what comes on top: it speaks of no more."""
    largest = _enlarged(proved, equal)
    if not np.isfinite(largest):
        return replace(s, points=third.points)
    return replace(s, points=third.points, largest=largest, rho0=loss_of(s, 0.0, largest))


def _enlarged(largest: float, equal: float) -> float:
    """The largest d with what is taken as equal where variables are held and ranges halved.

    Source: ours; B agrees there to 1e-11 of what it is made of, half of `equal`.
    """
    return float((np.sqrt(largest) + equal) ** 2)


def _gone_on_with(statement: Statement, before: Statement, root: Region) -> Region:
    """The tree of an earlier proof of the same statement.

    Raises:
        InputError: it is of another one.
    """
    known = replace(before, points=statement.points, largest=None, rho0=None, witnesses=np.zeros(0))
    if as_data(known) != as_data(statement):
        raise InputError(
            "the proof file is of another study, or of another bound on its plans; give another "
            "name to this one"
        )
    return root


def _ladder(
    expected: Sequence[tuple[float, float]], thresholds: Sequence[float], budget: float
) -> list[tuple[float, float, float]]:
    """Gap, threshold and time of what is proved in turn.

    The last is always among them, others only where they come much sooner than what follows; the
    first one also where the time might be over before anything else is proved.
    """
    steps = [(g, t, s) for (g, s), t in zip(expected, thresholds, strict=True)]
    taken = steps[-1:]
    for step in reversed(steps[:-1]):
        if taken[0][2] > max(_SHORT, _SOONER * step[2]) or np.isinf(taken[0][2]):
            taken.insert(0, step)
    if taken[0] is not steps[0] and _SURELY * taken[0][2] > budget:
        taken.insert(0, steps[0])
    return taken


def _points(study: Study, bound: Bound, known: Array | None, rng: np.random.Generator) -> Array:
    """(K, d) feasible design points: those of the search, those known, and some by chance."""
    assert bound.design is not None
    dual, space = bound.design.certificate, bound.aim.space
    points = [dual.x_found, dual.x_largest[None], bound.design.x, space.sample(_WITNESSES, rng)]
    x = np.concatenate(points if known is None else [*points, known])
    return np.asarray(x[space.feasible(x)])


def _try(s: Statement, boxes: Boxes, root: Region, x: Array, d: Array, largest: float) -> None:
    """What is known to be feasible must be in leaves whose bound is not below it.

    Raises:
        ProofError: it is not, or nothing is known to be feasible.
    """
    held = (margins(s, x) >= 0.0).all(axis=1) & (within(s, x) >= 0.0).all(axis=1)
    if not held.any():
        raise ProofError("no load case is known to be feasible, so nothing is claimed")
    for point, value in zip(x[held], d[held], strict=True):
        found = leaf_at(boxes, root, boxes.in_root(point[None])[0])
        if found is None:
            continue  # the search ended before
        bounds, _, kinds = boxes.bounds(found[0][None], np.inf)
        if kinds[0] == OPEN or min(bounds[0], largest) < value * (1.0 - _AGREE):
            q = ", ".join(f"{v:.9g}" for v in s.mix @ point)
            raise ProofError(
                f"the proof contradicts itself at the configuration {q} [rad, m]: d is {value:.9g} "
                f"there, and its box was found to be "
                f"{'empty' if kinds[0] == OPEN else f'at most {min(bounds[0], largest):.9g}'}; "
                "nothing is claimed"
            )
