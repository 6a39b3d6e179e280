"""Plans and their evaluations as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from elastocal.arrays import Array
from elastocal.constraints.watch import watch_of
from elastocal.motion.schedule import Schedule
from elastocal.planning.aim import is_for_promise
from elastocal.planning.along_paths import Shares
from elastocal.planning.certificate import Certificate
from elastocal.planning.evaluation import Evaluation
from elastocal.planning.plan import Plan
from elastocal.planning.to_validate import ToValidate
from elastocal.planning.visibility import Visibility
from elastocal.robot.chain import Robot
from elastocal.study.criteria import CRITERIA, RHO0
from elastocal.study.left_rigid import counted as counted_in
from elastocal.study.study import Study
from elastocal.terminal.blind import show_blind
from elastocal.terminal.certificates import certificate_sentences
from elastocal.terminal.console import micrometres, numbers, out, whole
from elastocal.terminal.mends import show_mends
from elastocal.terminal.studies import known_phrase
from elastocal.terminal.test_poses import show_test_poses, where_judged
from elastocal.wording import ended, worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import described, number, readable, shown_unit
from elastocal.wording.plans import (
    freedom,
    loss_sentence,
    only_of,
    searches_sentence,
    told,
)
from elastocal.wording.promises import WITHOUT, promise_sentences
from elastocal.wording.proofs import proof_sentences, proved_length
from elastocal.wording.robust import robust_sentences
from elastocal.wording.watch import watch

MEASURED = (
    "a measurement file, whose configurations and loads are judged as a plan, with the noise of "
    "the study."
)
_ERRORS = "Standard errors of the compliances"


def show_plan(plan: Plan) -> None:
    """The plan as a run sheet, its accuracy and its certificate."""
    worth = plan.assessment
    whole(_run_sheet(plan.study.robot, plan))
    out.print(Text(f"Nearest constraint of {_nearest(plan)}"))
    out.print(Text(watch(plan.watch.watched, plan.watch.unwatched, keys=True)))
    if plan.study.done is not None:
        done = plan.study.done
        out.print(
            Text(
                f"The rest of a campaign: {counted(done.experiments, 'experiment')} of "
                f"{done.source} count in every number, and their configurations are not asked for "
                "again."
            )
        )
    for sentence in freedom(plan.free_joints, plan.turns_with_load, plan.load_range):
        out.print(Text(sentence))
    show_view(plan.view)
    out.print(_errors(plan.study, worth.standard_error))
    if plan.study.known is not None:
        out.print(Text(f"{known_phrase(plan.study.known)}."))
    show_test_poses(plan.study, {"": worth}, {})
    out.print(
        f"ρ0 = [bold]{micrometres(worth.rho0)}[/bold]: root mean square position error "
        f"after compensation {where_judged(plan.study)}{escape(_only(plan))}"
    )
    for sentence in promise_sentences(
        worth.rho0, worth.promise, made_for_it=is_for_promise(plan.study)
    ):
        out.print(Text(sentence))
    if worth.loss is not None:
        sizes = worth.loss.load_case, worth.loss.rho0, worth.promised
        out.print(Text(loss_sentence(*sizes, promised=worth.promise is not None)))
    for sentence in robust_sentences(plan):
        out.print(Text(sentence))
    show_blind(plan.blind)
    show_mends(plan.mends)
    for doubt in plan.doubts:
        out.print(Text(told(doubt, ended(worded(doubt))), style="yellow"))
    if plan.criterion != RHO0.name:
        out.print(Text(_by_criterion(plan)))
    for sentence in certificate_sentences(plan.certificate, plan.count):
        out.print(Text(sentence))
    if plan.searches > 1:
        out.print(Text(searches_sentence(plan.searches, plan.apart)))
    out.print(Text(duration_sentence(plan.schedule)))


def _only(plan: Plan) -> str:
    """Of which springs ρ0 is, if others bend at the test poses."""
    return only_of(counted_in(plan.study), plan.doubts, plan.study.robot.joint_names)


def _by_criterion(plan: Plan) -> str:
    """What the plan is worth by the criterion it is made for."""
    criterion, value = CRITERIA[plan.criterion], plan.assessment.criteria[plan.criterion]
    factor, unit = shown_unit(criterion.unit(plan.study.springs), [value])
    better = "larger" if criterion.larger_is_better else "smaller"
    times = "×" if unit.startswith("10") else " "
    found = f"{number(factor * value, 4)}{times}{unit}".rstrip()
    return f"{criterion.name} = {found}: {criterion.meaning}; {better} is better"


def _run_sheet(robot: Robot, plan: Plan) -> Table:
    wrench = plan.load_cases.wrench
    title = f"{counted(plan.count, 'experiment')} in {counted(len(plan.repeats), 'configuration')}"
    common = len(np.unique(wrench, axis=0)) == 1
    if common:
        title += f", force [{numbers(wrench[0, :3])}] N"
        if wrench[0, 3:].any():
            title += f", torque [{numbers(wrench[0, 3:])}] N·m"
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("#", justify="right")
    for joint in robot.joints:
        table.add_column(f"{joint.name} {joint.kind.shown_unit}", justify="right")
    if not common:
        table.add_column("force N", justify="right")
    if not common and wrench[:, 3:].any():
        table.add_column("torque N·m", justify="right")
    table.add_column("repeat", justify="right")
    scale = robot.shown_scale
    blank = [""] * (0 if common else 1 + int(wrench[:, 3:].any()))
    for i in range(len(plan.load_cases) + 1):
        for passed in plan.via[i] if plan.via else ():
            table.add_row("via", *(f"{v:z.2f}" for v in scale * passed), *blank, "")
        if i == len(plan.load_cases):
            break
        q = plan.load_cases.q[i]
        cells = [str(i + 1), *(f"{v:z.2f}" for v in scale * q)]
        if not common:
            cells.append(numbers(wrench[i, :3]))
        if not common and wrench[:, 3:].any():
            cells.append(numbers(wrench[i, 3:]))
        table.add_row(*cells, f"{plan.repeats[i]}×")
    return table


def _nearest(plan: Plan) -> str:
    """Which constraint each configuration is nearest to, configurations of one kind together."""
    groups: dict[str, list[str]] = {}
    for i, near in enumerate(plan.assessment.nearest):
        room = f" ({described(near.margin, near.unit)})" if near.margin > 1e-6 else " (reached)"
        groups.setdefault(near.name + room, []).append(str(i + 1))
    return "; ".join(f"{', '.join(numbers)}: {name}" for name, numbers in groups.items())


def _errors(study: Study, standard_error: Array) -> Table:
    absolute = study.experiments.weighs
    title = "Standard errors of the unknowns, given what was known" if absolute else _ERRORS
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("unknown" if absolute else "joint")
    table.add_column("standard error", justify="right")
    table.add_column("unit")
    springs = study.springs
    for name, si, error in zip(springs.names, springs.units, standard_error, strict=True):
        factor, unit = readable(si, float(error)) if "/" in si else (1e3, f"m{si}")
        table.add_row(Text(name), number(factor * error), Text(unit))
    return table


def _errors_of_plans(study: Study, results: Mapping[str, Evaluation]) -> Table:
    """One row for each plan, so that many fit."""
    springs = study.springs
    scale = np.where(springs.stiff, 1e3, 1e9)
    units = " and ".join(f"1e-9 {u}" if "/" in u else f"m{u}" for u in dict.fromkeys(springs.units))
    table = Table(title=Text(f"{_ERRORS}, {units}"), title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("plan")
    for name in springs.names:
        table.add_column(Text(name), justify="right")
    for name, result in results.items():
        errors = result.assessment.standard_error
        shown = (f"{e:.3g}" if np.isfinite(e) else "∞" for e in scale * errors)
        table.add_row(Text(name), *shown)
    return table


def show_to_validate(robot: Robot, cases: ToValidate) -> None:
    """Load cases to validate with, and how far they are from what is fitted."""
    table = Table(
        title=Text("To validate with, never to be fitted"),
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("#")
    for joint in robot.joints:
        table.add_column(Text(f"{joint.name} {joint.kind.shown_unit}"), justify="right")
    wrench = cases.load_cases.wrench
    shown = [
        (name, part)
        for name, part in (("force N", wrench[:, :3]), ("torque N·m", wrench[:, 3:]))
        if len(np.unique(wrench, axis=0)) > 1 and part.any()
    ]
    for name, _ in shown:
        table.add_column(name, justify="right")
    table.add_column("apart °", justify="right")
    for i, q in enumerate(robot.shown_scale * cases.load_cases.q):
        loads = [numbers(part[i]) for _, part in shown]
        apart = f"{np.degrees(cases.apart[i]):.0f}"
        table.add_row(str(i + 1), *(f"{value:z.2f}" for value in q), *loads, apart)
    whole(table)
    out.print(
        Text(
            "Apart: the largest difference of a joint, or of the direction of the load, from the "
            f"nearest other. {number(60.0 * cases.schedule.hours, 2)} minutes in all."
        )
    )


def show_view(view: Visibility | None, plan: str = "") -> None:
    """Which marker the tracker sees in which configuration; nothing if there is no tracker."""
    if view is None:
        return
    title = "What the tracker sees" + (f" in {plan}" if plan else "")
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("#", "marker", "range m", "off its axis °", "seen"):
        table.add_column(column, justify="left" if column in ("marker", "seen") else "right")
    for i in range(view.seen.shape[1]):
        for k, marker in enumerate(view.markers):
            angle = np.degrees(view.incidence[k, i])
            table.add_row(
                str(i + 1),
                Text(marker),
                f"{view.range[k, i]:.3f}",
                f"{angle:.1f}" if np.isfinite(angle) else "–",
                "yes" if view.seen[k, i] else Text(f"no: {view.broken[k][i]}", "red"),
            )
    whole(table)


def duration_sentence(times: Schedule) -> str:
    """How long a plan takes, and with what."""
    parts = [f"{minutes:.3g} min {what}" for what, minutes in times.minutes.items()]
    return f"About {times.hours:.2g} h at the cell: {', '.join(parts)}."


def show_evaluations(
    study: Study,
    results: Mapping[str, Evaluation],
    random: Mapping[int, Array],
    better: Shares | None = None,
    baselines: Sequence[str] = (),
) -> None:
    """Plans side by side, by name.

    Args:
        study: The study.
        results: What they are worth.
        random: ρ0 of random plans for each number of experiments [m].
        better: How often each is better than another along paths; see `better_along`.
        baselines: Names of those that the others are compared with, if they measure as often.
    """
    table = Table(
        title=f"Plans under study {study.name!r}", title_justify="left", box=box.SIMPLE_HEAD
    )
    promised = study.nuisance is not None
    more = ("promised",) if promised else ()
    proved = any(result.certificate.proved is not None for result in results.values())
    bounds = ("proved", "bound") if proved else ("bound",)
    for column in ("plan", "m", "configs", "ρ0", *more, *bounds, "efficiency", "verdict"):
        table.add_column(column, justify="left" if column in ("plan", "verdict") else "right")
    for name, result in results.items():
        proof, worth = result.certificate, result.assessment
        known = proof.kind != "none"
        bound = "–" if proof.position_bound is None else micrometres(proof.position_bound)
        verdict = Text("measured" if result.measured else "holds", "green")
        if not result.accepted:
            verdict = Text("refused", "bold red")
        table.add_row(
            Text(name),
            str(result.count),
            str(len(result.repeats)),
            micrometres(result.assessment.rho0),
            *([micrometres(worth.promise.rho0)] if worth.promise else []),
            *([_proved(proof)] if proved else []),
            bound,
            f"{proof.efficiency:.4f}" if known else "–",
            verdict,
        )
    whole(table)
    show_test_poses(study, {name: r.assessment for name, r in results.items()}, better or {})
    whole(_errors_of_plans(study, results))
    if not promised:
        out.print(Text(WITHOUT))
    seen = watch_of(study.constraints)
    out.print(Text(watch(seen.watched, seen.unwatched)))
    for name, result in results.items():
        for sentence in promise_sentences(
            result.assessment.rho0, result.assessment.promise, made_for_it=is_for_promise(study)
        ):
            if promised:
                out.print(Text(f"{name}: {sentence}"))
        if result.measured:
            out.print(Text(f"{name}: {MEASURED}"))
        if said := proof_sentences(result.certificate, result.count):
            out.print(Text(f"{name}: {' '.join(said)}"))
        show_view(result.view, name)
        show_blind(result.blind, name)
        for doubt in (*result.objections, *result.unidentified):
            out.print(Text(f"{name}: {worded(doubt)}", "red"))
        for doubt in result.remarks:
            out.print(Text(f"{name}: {ended(worded(doubt))}"))
    for base in baselines:
        named = [name for name in results if name not in baselines]
        _show_baseline(base, results, named, before=bool(study.prior.any()))
    what = "promise" if promised else "ρ0"
    for m, rho0 in random.items():
        low, middle, high = np.quantile(rho0, (0.05, 0.5, 0.95), method="inverted_cdf")
        out.print(
            f"{len(rho0)} random feasible plans of {counted(m, 'experiment')}: {what} median "
            f"{micrometres(middle)}, 5 % below {micrometres(low)}, 95 % below {micrometres(high)}"
        )
        for name, result in results.items():
            if result.count == m and name not in baselines:
                beaten = float((rho0 < result.assessment.promised).mean())
                factor = middle / result.assessment.promised
                out.print(
                    Text(
                        f"{name}: {factor:.2f}× better than the random median, "
                        f"{100 * beaten:.3g} % of random plans are better"
                    )
                )


def _proved(certificate: Certificate) -> str:
    """The bound that is proved, if one is."""
    known = certificate.proved
    shown = known is not None and certificate.position_bound is not None
    return proved_length(known.loss) if known is not None and shown else "–"


def _show_baseline(
    base: str, results: Mapping[str, Evaluation], names: Sequence[str], *, before: bool
) -> None:
    """How much better plans are than measuring in the test poses as often."""
    known = results[base].assessment.promised
    for name in names:
        if results[name].count == results[base].count and np.isfinite(known):
            factor = known / results[name].assessment.promised
            # With what was known before, errors do not go down as one over the root of the count.
            worth = "" if before else f", worth {factor**2:.2f}× as many experiments there"
            out.print(Text(f"{name}: ρ0 {factor:.2f}× smaller than in the test poses{worth}"))
