"""What is wrong with a plan: constraints it breaks, claims that do not hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import counted, experiments, listed
from elastocal.wording.numbers import described, length, more_minutes, number, short


def _load(doubt: Doubt, *keys: str) -> str:
    return "[" + ", ".join(f"{doubt.numbers[key]:.6g}" for key in keys) + f"] {doubt.unit}"


def _kind(doubt: Doubt) -> str:
    return "force" if doubt.unit == "N" else "torque"


def _at(doubt: Doubt) -> str:
    return f"load case {doubt.numbers['load_case']}"


def _claim(doubt: Doubt, what: str) -> str:
    return what.format(*doubt.about, **doubt.numbers)


def _lengths(doubt: Doubt, what: str) -> str:
    return what.format(**{name: 1e3 * value for name, value in doubt.numbers.items()})


def _criteria(doubt: Doubt) -> str:
    first, *more = doubt.about
    claimed, found = (described(doubt.numbers[n], doubt.unit, 6) for n in ("claimed", "found"))
    rest = f"; the same goes for {', '.join(more)}" if more else ""
    return f"it claims {claimed} for criterion {first} but has {found}{rest}"


def only_of(names: Sequence[str], doubts: Iterable[Doubt], order: Sequence[str]) -> str:
    """', of A2 to A6 only' behind an error that leaves joints out; empty if none bends.

    Args:
        names: Springs whose errors are in it.
        doubts: What is weak in the plan.
        order: All joints, in the order of the chain.
    """
    if not any(doubt.code == "rigid-at-test-pose" for doubt in doubts):
        return ""
    places = [order.index(name) for name in names if name in order]
    in_a_row = len(places) == len(names) and places == list(range(places[0], places[-1] + 1))
    shown = f"{names[0]} to {names[-1]}" if in_a_row and len(names) > 2 else listed(names)
    return f", of {shown} only"


def told(doubt: Doubt, sentence: str) -> str:
    """The sentence of a doubt about a study or a plan, with what it is: a weak point, or a note."""
    return f"{'Weak' if doubt.code in _WEAK else 'Note'}: {sentence}"


_WEAK: frozenset[Code] = frozenset(
    {
        "search-stopped",
        "loss-above",
        "blind-above",
        "rho0-above",
        "one-carries",
        "rests-on-one",
        "rigid-at-test-pose",
        "hardly-known",
    }
)


def _loss_above(doubt: Doubt) -> str:
    found = {name: doubt.numbers.get(name, 0.0) for name in ("times", "asked", "least")}
    left = f"leaves {number(found['times'], 3)} times the best there is"
    if not math.isfinite(found["times"]):
        left = "does not tell the compliances apart"
    said = (
        f"without one of its configurations the plan {left}, where no more than "
        f"{number(found['asked'], 3)} times the best are asked for"
    )
    distinct = counted(round(doubt.numbers["configurations"]), "configuration")
    if found["least"] > found["asked"]:
        return f"{said}; with {distinct} no plan leaves less than {number(found['least'], 3)} times"
    return f"{said}; more than {distinct} may help"


def _one_carries(doubt: Doubt) -> str:
    sizes = {name: length(size) for name, size in doubt.numbers.items()}
    longer = more_minutes(doubt.numbers["minutes"])
    left = f"{sizes['lost']} in place of {sizes['promised']} is left without it"
    if not math.isfinite(doubt.numbers["lost"]):
        left = "the rest does not tell the compliances apart"
    several = round(doubt.numbers["configurations"])
    by = counted(several, "configuration")
    if several > doubt.numbers["allowed"]:
        by = f"`max_configurations: {several}`"
    return (
        f"configuration {doubt.about[0]} carries the result: {left}; with `robust: "
        f"{doubt.numbers['asked']:g}` and {by} about {sizes['other_lost']} would be, by ρ0 of "
        f"{sizes['other_promised']}, {longer} at the cell"
    )


def _rests_on_one(doubt: Doubt) -> str:
    found, several = doubt.numbers, len(doubt.about) > 1
    larger = [number(min(found[name], _ALONE), 2) for name in doubt.about]
    errors = "their standard errors" if several else "its standard error"
    then = f"{number(found['more'], 2)} times" if found["more"] else "less than twice"
    rho0 = f"ρ0 is {length(found['more_rho0'])} in place of {length(found['rho0'])}"
    return (
        f"{listed(doubt.about)} {'rest' if several else 'rests'} on configuration "
        f"{found['configuration']:g}: without it {errors} would be {listed(larger)} times as "
        f"large; with one more experiment {then} at most, and {rho0}, "
        f"{more_minutes(found['minutes'])} at the cell"
    )


_ALONE = 1e4  # times as large; nothing else tells of it then


def _hardly_known(doubt: Doubt) -> str:
    unit = {"rad/(N·m)": "µrad/(N·m)", "m/N": "µm/N"}[doubt.unit]
    errors = ", ".join(short(1e6 * doubt.numbers[name]) for name in doubt.about)
    several = "standard errors" if len(doubt.about) > 1 else "a standard error"
    return (
        f"{listed(doubt.about)}: will not be known, with {several} of {errors} {unit}, "
        "more than the springs of most arms give; leave out of `identify` what no test pose needs, "
        "or plan other loads, tools or more experiments"
    )


def _half_known(doubt: Doubt) -> str:
    shares = ", ".join(f"{100 * doubt.numbers[name]:.0f} %" for name in doubt.about)
    return (
        f"{listed(doubt.about)}: will be known to {shares} of the usual compliance only; what the "
        "task needs of them is known better, together, so do not read them one by one"
    )


_STILL = 1e-12  # m that are rounding


def _hardly_needed(doubt: Doubt) -> str:
    most = max(doubt.numbers.values())
    one = len(doubt.about) == 1
    moved = f"{'it does' if one else 'they do'} not move the tool at the test poses"
    if most > _STILL:
        moved = (
            f"{'it moves' if one else 'they move'} the tool at the test poses by no more than "
            f"{length(most)}, less than 1 % of what is promised"
        )
    return (
        f"{listed(doubt.about)}: of usual compliance {moved}: how well "
        f"{'it is' if one else 'they are'} known hardly matters there"
    )


def searched(starts: int, attained: int, narrow: int, narrow_attained: int, rarest: int) -> str:
    """Sentences on the search for an experiment that refutes a bound, and its yield.

    Args:
        starts: Distinct fresh random starts.
        attained: How many of them reached the same maximum.
        narrow: Further starts in narrow parts of the cell.
        narrow_attained: How many of them reached it.
        rarest: How many starts found the load case of the design that fewest found.
    """
    said = f"{starts} distinct random starts searched for an experiment that refutes the bound"
    if attained > 1:
        said += f" and failed; {attained} of them reached the same maximum."
    elif attained == 1:
        said += " and failed; only one of them reached the same maximum, so trust it less."
    else:
        said += (
            " and failed; none of them reached the maximum itself, so trust it less; try another "
            "seed."
        )
    if narrow:
        said += (
            f" {narrow} more began in narrow or cut-off parts of the cell; "
            f"{narrow_attained or 'none'} of them reached it."
        )
    if attained and rarest < _RARE:
        said += " Not every load case behind the bound is easy to find: " + (
            f"one was found from {rarest} of all starts." if rarest else "no start found one."
        )
    return said


def missed(share: float) -> str:
    """What that search says of maxima it has not found; `share` as of `Certificate.missed`."""
    return (
        f"So, with 95 % confidence, no better maximum is reached from more than {100 * share:.2g} "
        "% of random starts; of maxima that are harder to find nothing is known."
    )


NOT_TRIED = "the search was stopped before its bound had been tried from fresh starts"
"""Why a plan that was stopped has no certificate."""


def loss_sentence(load_case: int, rho0: float, whole: float, *, promised: bool) -> str:
    """What is left of a plan without the configuration that is missed most.

    Args:
        load_case: Its number.
        rho0: ρ0 without it [m].
        whole: ρ0 with it [m].
        promised: Whether these are what the plan promises, errors of load cases included.
    """
    lost = f"If configuration {load_case} is lost, to a bump or a beam that broke unseen, "
    if not math.isfinite(rho0):
        return f"{lost}the rest does not tell the compliances apart."
    what = "the promise" if promised else "ρ0"
    return f"{lost}{what} is {length(rho0)}, {number(rho0 / whole, 2)} times as much."


def searches_sentence(searches: int, apart: float) -> str:
    """How far two or more independent searches for a plan agree, of which the best is taken."""
    share = f"{100 * max(apart, 1e-5):.2g}"
    said = f"{searches} independent searches for the plan agree to {share} % in experiments"
    if apart > _FAR_APART:
        said += "; other seeds may find a better one, within what the bound leaves"
    return f"{said}."


def floor_sentence(left_out: Sequence[Doubt]) -> str:
    """What a criterion leaves out, and what is done about it."""
    what = "; ".join(SENTENCES[doubt.code](doubt) for doubt in left_out)
    what = what or "the criterion leaves some compliances out"
    return f"{what[0].upper()}{what[1:]}. A small floor keeps all of them identifiable."


def _together(doubt: Doubt) -> str:
    both, seen = " and ".join(doubt.about), doubt.numbers["seen"]
    terms = [(doubt.numbers.get(f"of {name}"), name) for name in doubt.about]
    if seen > 1 or any(share is None for share, _ in terms):
        what = "one combination" if seen == 1 else f"{seen:g} combinations"
        return f"the criterion asks for {what} of {both} only"
    first, *more = (f"{abs(share):.2g} {name}" for share, name in terms if share is not None)
    signs = ["+" if share > 0.0 else "-" for share, _ in terms[1:] if share is not None]
    told = " ".join([first, *(f"{sign} {term}" for sign, term in zip(signs, more, strict=True))])
    return f"{both} are determined only together: {told}"


def freedom(free: Sequence[str], turns_with_load: str, load_range: float) -> list[str]:
    """Sentences on joints that may be set otherwise: alone, or together with the load.

    Args:
        free: Joints that change nothing.
        turns_with_load: Joint that changes nothing if the load turns along; empty if none.
        load_range: Over which angle about it the loads spread [rad].
    """
    said = []
    if free:
        said.append(f"{', '.join(free)}: free, set as the cell requires.")
    if turns_with_load:
        sides = "all loads come from one side"
        if load_range > _ONE_SIDE:
            sides = (
                "its limits do not let all loads come from one side, they spread over "
                f"{described(load_range, 'rad', 3)}"
            )
        said.append(
            f"{turns_with_load}: free together with the load, turned by the same angle; {sides}."
        )
    return said


_CLAIMS = "it claims {claimed:.6g} mm but has {found:.6g} mm"
_LIMITS = {
    "load-differs": "the load of the study",
    "load-too-large": "the bound of the load",
    "load-outside-cone": "the cone of the load",
    "load-outside-plane": "the plane of the load",
}
_FAR_APART = 1e-3  # share of φ by which searches differ that have not found the same
_RARE = 6  # starts that find a load case from which on it is not rare
_ONE_SIDE = 1e-6  # spread of loads from one side: rounding [rad]

SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "search-stopped": lambda doubt: (
        "the search was stopped before its end, after "
        f"{counted(round(doubt.numbers['generations']), 'generation')} of plans: a longer one may "
        "find a better plan, and the same seed need not lead to this one again"
    ),
    "loss-above": _loss_above,
    "blind-above": lambda doubt: (
        f"the largest blind error is {length(doubt.numbers['found'])}, the least that was found, "
        f"where no more than {length(doubt.numbers['asked'])} is asked for; loads of another "
        "direction, more markers or more experiments may help"
    ),
    "rho0-above": lambda doubt: (
        f"the plan has {number(doubt.numbers['times'], 4)} times the best there is, where no more "
        f"than {number(doubt.numbers['asked'], 4)} times is asked for; more configurations may help"
    ),
    "one-carries": _one_carries,
    "rests-on-one": _rests_on_one,
    "hardly-known": _hardly_known,
    "half-known": _half_known,
    "hardly-needed": _hardly_needed,
    "constraint-broken": lambda doubt: (
        f"{_at(doubt)} breaks {doubt.about[0]} by {described(doubt.numbers['by'], doubt.unit)}"
    ),
    "load-differs": lambda doubt: (
        f"{_at(doubt)} has {_kind(doubt)} {_load(doubt, *'xyz')} where the study has "
        f"{_load(doubt, 'wanted_x', 'wanted_y', 'wanted_z')}"
    ),
    "load-too-large": lambda doubt: (
        f"{_at(doubt)} has {_kind(doubt)} {_load(doubt, *'xyz')}, above the bound of "
        f"{doubt.numbers['bound']:.6g} {doubt.unit}"
    ),
    "load-outside-cone": lambda doubt: (
        f"{_at(doubt)} has a {_kind(doubt)} outside the cone by "
        f"{described(doubt.numbers['by'], 'rad')}"
    ),
    "load-outside-plane": lambda doubt: (
        f"{_at(doubt)} has a {_kind(doubt)} out of the plane by "
        f"{described(doubt.numbers['by'], 'rad')}"
    ),
    "outside-study": lambda doubt: (
        f"{experiments(doubt.about)}: outside {_LIMITS.get(doubt.because[0], doubt.because[0])} by "
        f"{described(doubt.numbers['by'], doubt.unit)}"
    ),
    "same-information": lambda doubt: (
        f"load cases {listed(doubt.about)} tell the same: any one of them, measured "
        f"{doubt.numbers['repeats']}×, is worth as much"
    ),
    "criterion-ignores": lambda doubt: f"the criterion does not ask for {doubt.about[0]}",
    "criterion-together": _together,
    "more-experiments": lambda doubt: (
        f"it has {doubt.numbers['count']} experiments in all, and the study asks for "
        f"{doubt.numbers['asked']}"
    ),
    "more-configurations": lambda doubt: (
        f"it has {doubt.numbers['count']} configurations, and the study asks for at most "
        f"{doubt.numbers['asked']}"
    ),
    "certificate-unknown": lambda doubt: (
        f"its certificate is of a kind that is not known here, {doubt.about[0]!r}; its bound was "
        "compared with one made anew, nothing else of it was checked"
    ),
    "claims-unchecked": lambda doubt: (
        f"not checked, and not used but where a note says so: {listed(doubt.about)}"
    ),
    "claims-other-criterion": lambda doubt: (
        f"its certificate speaks of criterion {doubt.about[0]}, and it was planned for "
        f"{doubt.about[1]}"
    ),
    "claims-no-bound": lambda doubt: (
        f"it claims an efficiency of {doubt.numbers['claimed']:.4f}, but no bound is known for "
        f"criterion {doubt.about[0]}"
    ),
    "claims-experiments": lambda doubt: _claim(
        doubt, "it claims {claimed:g} experiments but has {found}"
    ),
    "claims-rho0": lambda doubt: _lengths(
        doubt, "it claims ρ0 = {claimed:.6g} mm but has {found:.6g} mm"
    ),
    "claims-promise": lambda doubt: f"of its promise, {doubt.about[0]}: {_lengths(doubt, _CLAIMS)}",
    "claims-nuisance": lambda doubt: (
        f"its promise counts {doubt.about[0]} otherwise than the study"
        + (_claim(doubt, ": {claimed:.6g} in place of {found:.6g}") if doubt.numbers else "")
    ),
    "claims-rho0-at": lambda doubt: f"at {doubt.about[0]!r} {_lengths(doubt, _CLAIMS)}",
    "claims-worst-point": lambda doubt: (
        f"at the worst point of {doubt.about[0]!r} {_lengths(doubt, _CLAIMS)}"
    ),
    "claims-unknown-error": lambda doubt: _claim(
        doubt, "it claims a standard error for {}, which the study does not identify"
    ),
    "claims-error": lambda doubt: _claim(
        doubt, "it claims a standard error of {claimed:.4g} for {} but has {found:.4g}"
    ),
    "claims-criteria": _criteria,
    "claims-covariance": lambda doubt: (
        f"it claims a covariance of {' and '.join(doubt.about)} of "
        f"{doubt.numbers['claimed']:.4g} but has {doubt.numbers['found']:.4g}"
    ),
    "claims-bound": lambda doubt: _lengths(
        doubt,
        "it claims that no plan is better than {claimed:.6g} mm, but only {found:.6g} mm is "
        "confirmed",
    ),
    "claims-efficiency": lambda doubt: _claim(
        doubt, "it claims an efficiency of {claimed:.4f} but only {found:.4f} is confirmed"
    ),
}
