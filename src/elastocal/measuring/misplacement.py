"""Why markers are not where joints and tool put them: the mistake that explains it best.

In: readings that do not fit to the arm, whatever their frame. Out: the mistake after which they
fit, if there is one. It is said, never mended.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from elastocal.errors import Doubt
from elastocal.measuring.misreadings import (
    Misreading,
    bumped,
    elsewhere,
    exchanged,
    left_of,
    signs,
    single,
    units,
    zeros,
)
from elastocal.measuring.placement import Placement, Unloaded, settled
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import Coupling

FITS = 5e-3
"""What real arms are off at most, root mean square [m]."""
_GOOD = 1e-3  # m; below it nothing but bumps is looked for
_GAIN = 3.0  # what a mistake explains makes the rest so many times smaller
_BY_FAR = 10.0
"""What a mistake explains by so many times counts whatever is left: soft arms sag."""
_SOFT = 1e-2  # m; what an arm that sags is off at most where a mistake is less plain than that
_GAIN_OF_A_BUMP = 1.5
"""Less is enough where one frame becomes two: errors of an arm do not know when they are read."""
_SAMPLE = 40  # experiments
_MANY = 5000  # readings; in more, no single poses are looked for
_TRIED = 8  # conventions with several signs that are looked at with free reflectors
_FEWEST = 6  # poses from which a reflector and a frame are found with some to spare
_TURN = np.radians(0.3)
"""Angle by which a frame may be off: as much the zeros and links of an arm may do."""


def misplaced(
    unloaded: Unloaded,
    found: Placement,
    names: Sequence[str],
    markers: Sequence[str],
    table: Coupling,
) -> tuple[Doubt, ...]:
    """What is wrong with readings of unloaded markers, if anything is.

    Args:
        unloaded: The readings, in the frame that they are believed to be in.
        found: How they fit.
        names: Names of the experiments.
        markers: Names of the markers.
        table: What the controller shows for the joint values of the model.
    """
    rms = {"rms": found.rms, "apart": found.apart}
    best, said = _explained(unloaded, found, names, markers, table), list[Doubt]()
    if best is not None:
        numbers = {**rms, "mended": best.rms, **best.numbers}
        said.append(Doubt("unlike-arm", best.about, (best.kind, *best.beside), numbers))
    elif found.rms > FITS:
        said.append(Doubt("unlike-arm", numbers=rms))
    if found.rms <= FITS and found.turn > max(_TURN, 4.0 * found.turn_error):
        turn = {"turn": found.turn, "turn_error": found.turn_error}
        said.append(Doubt("readings-turned", numbers={**rms, **turn}))
    return tuple(said)


def _explained(
    unloaded: Unloaded,
    found: Placement,
    names: Sequence[str],
    markers: Sequence[str],
    table: Coupling,
) -> Misreading | None:
    """The mistake that explains most, None if none does."""
    tried = list(bumped(unloaded, names))
    if found.rms > _GOOD:
        few = _sample(unloaded)
        tried += [*single(unloaded, names), *zeros(few), *exchanged(few, markers)]
        if found.rms > FITS:
            tried += [*units(few), *signs(few, table)]
        tried += elsewhere(few, markers, _GOOD)
    return _best(tried, found.rms)


def _best(tried: Iterable[Misreading], rms: float, most: float = FITS) -> Misreading | None:
    """Of mistakes that explain about as much the likeliest, None if none explains enough.

    `most` is what may be left, or a tenth of what was there before [m].
    """
    gain = {"bumped": _GAIN_OF_A_BUMP}
    most = max(most, rms / _BY_FAR)
    good = [
        t
        for t in tried
        # Readings that only shrink fit the closer to anything, by as much as they shrink.
        if t.rms < min(most, min(1.0, t.numbers.get("scale", 1.0)) * rms / gain.get(t.kind, _GAIN))
    ]
    if not good:
        return None
    least = min(t.rms for t in good)
    near = [t for t in good if t.rms < max(1.5 * least, 0.1 * _GOOD)]
    return min(near, key=lambda t: (*t.size, t.rms))


def beside_arm(found: Positions, robot: Robot, table: Coupling) -> tuple[float, tuple[Doubt, ...]]:
    """How far absolute readings are from the arm as drawn, and the mistake that explains it.

    Bases and reflectors are free: they are what fits best to some poses from all over.

    Args:
        found: The readings.
        robot: The arm as drawn.
        table: What the controller shows for the joint values of the model.

    Returns:
        Root mean square distance [m], NaN if there are too few readings; what is wrong.
    """
    place = ~found.rotations
    kinds = len(found.tool.markers)
    mounted = found.mounting[found.case] * kinds + found.marker
    used, marker = np.unique(mounted[place], return_inverse=True)
    readings = Unloaded(
        robot,
        found.tool.markers[used % kinds],
        found.cases.q,
        found.case[place],
        np.reshape(marker, -1),
        found.value[place],
        found.station[place],
    )
    few = _sample(readings, _SAMPLE * max(1, len(used) // kinds))
    poses = [len(np.unique(few.case[few.station == s])) for s in np.unique(few.station)]
    if min(poses, default=0) < _FEWEST or len(few) < len(used) + 2 * _FEWEST:
        return float("nan"), ()
    several = len(found.mountings) > 1
    markers = [
        f"{found.mountings[k // kinds]}/{name}" if several else name
        for k, name in ((int(k), found.tool.marker_names[int(k) % kinds]) for k in used)
    ]
    drawn = settled(few, markers=True)
    rms = left_of(drawn)
    whole = replace(readings, markers=drawn.markers)
    tried = list(bumped(whole, found.names))
    if rms > FITS:
        if len(readings) <= _MANY:
            tried += single(readings, found.names, markers=True)
        tried += zeros(few, markers=True)
        once = [*units(few), *exchanged(few, markers), *signs(few, table)]
        # Of joints that count the other way, each alone, and those that fit best to the drawing.
        several_signs = sorted((t for t in once if t.size[1] > 1), key=lambda t: t.rms)
        again = [t for t in once if t.size[1] <= 1 or t.kind == "exchanged"]
        for one in [*again, *several_signs[:_TRIED]]:
            other = settled(one.readings, markers=True)
            left = left_of(other)
            tried.append(replace(one, readings=other, rms=left))
    best = _best(tried, rms, _SOFT)  # the arm bends under its own weight, which is not drawn
    numbers = {"rms": rms}
    if best is not None:
        numbers |= {"mended": best.rms, **best.numbers}
        return rms, (Doubt("unlike-arm", best.about, (best.kind, *best.beside), numbers),)
    return rms, (Doubt("unlike-arm", numbers=numbers),) if rms > FITS else ()


def _sample(unloaded: Unloaded, count: int = _SAMPLE) -> Unloaded:
    """Readings of so many experiments from all over the campaign."""
    used = np.unique(unloaded.case)
    if len(used) <= count:
        return unloaded
    few = used[np.linspace(0, len(used) - 1, count).astype(int)]
    rows = np.flatnonzero(np.isin(unloaded.case, few))
    number = np.searchsorted(few, unloaded.case[rows])
    return replace(unloaded.chosen(rows), q=unloaded.q[few], case=number)
