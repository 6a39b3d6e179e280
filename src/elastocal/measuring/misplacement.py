"""Why unloaded markers are not where joints and tool put them: the mistake that explains it best.

In: readings that do not fit to the arm, whatever their frame. Out: the mistake after which they
fit: a unit, joints that count the other way, a zero elsewhere, markers exchanged or elsewhere,
single experiments, a tracker that was bumped. It is said, never mended.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt
from elastocal.measuring.best_fit import best_fits
from elastocal.measuring.placement import Placement, Unloaded, left_over, residuals
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.conventions import Convention, conventions
from elastocal.robot.posture import Posture

FITS = 5e-3
"""What real arms are off at most, root mean square [m]."""
_GOOD = 1e-3  # m; below it nothing but bumps is looked for
_GAIN = 3.0  # what a mistake explains makes the rest so many times smaller
_GAIN_OF_A_BUMP = 1.5
"""Less is enough where one frame becomes two: errors of an arm do not know when they are read."""
_SAMPLE = 40  # experiments
_FEWEST = 4  # experiments before and after a bump
_SCALES = (1e3, 1e-3, 25.4, 1.0 / 25.4, 10.0, 0.1)
_TURN = np.radians(0.3)
"""Angle by which a frame may be off: as much the zeros and links of an arm may do."""


@dataclass(frozen=True)
class _Try:
    """A mistake, and what is left if it is mended [m]."""

    kind: str
    about: tuple[str, ...]
    rms: float
    numbers: dict[str, float]
    beside: tuple[str, ...] = ()


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
) -> _Try | None:
    """The mistake that explains most, None if none does."""
    tries = list(_bumped(unloaded, names))
    if found.rms > _GOOD:
        few = _sample(unloaded)
        tries += [*_single(unloaded, names), *_zeros(few), *_exchanged(few, markers)]
        if found.rms > FITS:
            tries += [*_units(few), *_signs(few, table)]
        tries += _elsewhere(few, markers)
    gain = {"bumped": _GAIN_OF_A_BUMP}
    good = [t for t in tries if t.rms < min(FITS, found.rms / gain.get(t.kind, _GAIN))]
    if not good:
        return None
    least = min(t.rms for t in good)
    # Of those that explain about as much the one that is the fewest mistakes.
    near = [t for t in good if t.rms < max(1.5 * least, 0.1 * _GOOD)]
    return min(near, key=lambda t: (_ORDER.index(t.kind), len(t.about) + len(t.beside), t.rms))


_ORDER = (
    *("scale", "joint-unit", "exchanged", "sign", "quarter", "controller"),
    *("experiments", "bumped", "zero", "markers"),
)


def _sample(unloaded: Unloaded) -> Unloaded:
    """Readings of experiments from all over the campaign."""
    used = np.unique(unloaded.case)
    if len(used) <= _SAMPLE:
        return unloaded
    few = used[np.linspace(0, len(used) - 1, _SAMPLE).astype(int)]
    rows = np.flatnonzero(np.isin(unloaded.case, few))
    number = np.searchsorted(few, unloaded.case[rows])
    return replace(unloaded.chosen(rows), q=unloaded.q[few], case=number)


def _units(few: Unloaded) -> Iterator[_Try]:
    """Readings in another unit; joint values in the other unit of angles."""
    nominal = few.nominal()
    for scale in _SCALES:
        rms = float(left_over(few, nominal, scale * few.position)[0])
        yield _Try("scale", (), rms, {"scale": scale})
    turning = ~few.robot.prismatic
    for factor in (180.0 / np.pi, np.pi / 180.0):
        q = np.where(turning, factor * few.q, few.q)
        rms = float(left_over(few, few.nominal(q[None]))[0])
        yield _Try("joint-unit", (), rms, {"factor": factor})


def _signs(few: Unloaded, table: Coupling) -> Iterator[_Try]:
    """Joints that count the other way or with another; zeros a quarter of a turn elsewhere."""
    shown, assumed = table.to_controller(few.q), Convention.of(table)
    tried = list(conventions(few.robot, assumed, range(len(assumed.names))))[1:]
    q = [convention.to_model(shown) for convention in tried]
    found = [_convention(convention.mistakes(assumed)) for convention in tried]
    for i, joint in enumerate(few.robot.joints):
        for by in () if joint.prismatic else (0.5 * np.pi, -0.5 * np.pi, np.pi):
            q.append(few.q + by * np.eye(few.q.shape[1])[i])
            found.append(_Try("quarter", (joint.name,), 0.0, {"by": by}))
    if not table.is_identity:
        q += [table.to_model(few.q), shown]
        found += [_Try("controller", (whose,), 0.0, {}) for whose in ("controller", "model")]
    rms = left_over(few, few.nominal(np.array(q)))
    return (replace(one, rms=value) for one, value in zip(found, rms.tolist(), strict=True))


def _convention(mistakes: Sequence[Doubt]) -> _Try:
    """Which joints count the other way, and which pairs are coupled otherwise."""
    turned = tuple(m.about[0] for m in mistakes if m.code == "counts-other-way")
    pairs = [m for m in mistakes if m.code == "coupled"]
    factors = {"/".join(m.about): m.numbers["factor"] for m in pairs}
    return _Try("sign", turned, 0.0, factors, tuple(name for m in pairs for name in m.about))


def _exchanged(few: Unloaded, markers: Sequence[str]) -> Iterator[_Try]:
    """Markers that have each other's names."""
    count = len(markers)
    orders = list(permutations(range(count))) if count <= 4 else []
    for i, j in combinations(range(count), 2) if count > 4 else ():
        orders.append(tuple(j if k == i else i if k == j else k for k in range(count)))
    for order in orders:
        about = tuple(markers[i] for i in range(count) if order[i] != i)
        if about:
            other = replace(few, marker=np.array(order)[few.marker])
            yield _Try("exchanged", about, float(left_over(few, other.nominal())[0]), {})


def _zeros(few: Unloaded) -> Iterator[_Try]:
    """The zero of one joint elsewhere, by as much as fits best."""
    for j, joint in enumerate(few.robot.joints):
        q, total = np.array(few.q), 0.0
        for _ in range(6):
            posture = Posture(few.robot, q)
            nominal = few.nominal(q[None])[0]
            column = _moved_by(posture, few, j)
            step = _amount(few, nominal, column)
            if not abs(step) < np.pi:
                break
            q[:, j] += step
            total += step
            if abs(step) < 1e-9:
                break
        rms = float(left_over(few, few.nominal(q[None]))[0])
        yield _Try("zero", (joint.name,), rms, {"by": total, "sliding": float(joint.prismatic)})


def _moved_by(posture: Posture, few: Unloaded, joint: int) -> Array:
    """(R, 3) how each marker moves with a joint."""
    columns = [posture.point_jacobian(posture.point(m))[:, joint].T for m in few.markers]
    return np.array(columns)[few.marker, few.case]


def _amount(few: Unloaded, nominal: Array, column: Array) -> float:
    """How much of a column (R, 3) makes the residuals of the best fits smallest."""
    open_ = residuals(few, nominal)
    free: list[Array] = []
    wanted: list[Array] = []
    for number in np.unique(few.station):
        mine = few.station == number
        frame = _frame(nominal[mine])
        for found, value in ((free, column[mine]), (wanted, open_[mine])):
            flat = value.reshape(-1)
            found.append(flat - frame @ (frame.T @ flat))
    a, b = np.concatenate(free), np.concatenate(wanted)
    size = float(a @ a)
    # What a shift and a turn of the frame does as well cannot be told.
    if size < 1e-6 * float(np.sum(column**2)):
        return 0.0
    return -float(a @ b) / size


def _frame(points: Array) -> Array:
    """(3R, 6) orthonormal columns of small shifts and turns of points (R, 3)."""
    arm = points - points.mean(axis=0)
    columns = np.zeros((len(points), 3, 6))
    for k, axis in enumerate(np.eye(3)):
        columns[:, k, k] = 1.0
        columns[:, :, 3 + k] = np.cross(axis, arm)
    return np.linalg.qr(columns.reshape(-1, 6))[0]


def _elsewhere(few: Unloaded, markers: Sequence[str]) -> Iterator[_Try]:
    """Markers that are elsewhere in the flange frame."""
    count = len(few.markers)
    if len(few) < 3 * count + 6 or len(np.unique(few.case)) < 4:
        return
    turned = Posture(few.robot, few.q).bodies[-1][:3].transpose(2, 1, 0)[few.case]  # (R, 3, 3)
    where = np.array(few.markers)
    for _ in range(8):
        now = replace(few, markers=where)
        nominal = now.nominal()[0]
        columns = np.zeros((len(few), 3, 3 * count))
        for k in range(count):
            mine = few.marker == k
            columns[mine, :, 3 * k : 3 * k + 3] = turned[mine]
        flat, open_ = columns.reshape(-1, 3 * count), residuals(now, nominal).reshape(-1)
        row = np.repeat(few.station, 3)
        for number in np.unique(few.station):
            frame = _frame(nominal[few.station == number])
            own = row == number
            flat[own] -= frame @ (frame.T @ flat[own])
            open_[own] -= frame @ (frame.T @ open_[own])
        step = -np.linalg.lstsq(flat, open_, rcond=1e-4)[0]
        where = where + step.reshape(-1, 3)
        if np.abs(step).max() < 1e-9:
            break
    rms = float(left_over(few, replace(few, markers=where).nominal())[0])
    apart = np.linalg.norm(where - few.markers, axis=1)
    moved = tuple(m for m, by in zip(markers, apart.tolist(), strict=True) if by > _GOOD)
    if moved:
        yield _Try("markers", moved, rms, {"by": float(apart.max())})


def _single(unloaded: Unloaded, names: Sequence[str]) -> Iterator[_Try]:
    """Single experiments that fit to no other."""
    used = np.unique(unloaded.case)
    nominal = unloaded.nominal()[0]
    keep = np.ones(len(unloaded), dtype=bool)
    out: list[int] = []
    for _ in range(min(5, len(used) // 4)):
        rows = np.flatnonzero(keep)
        part = unloaded.chosen(rows)
        square = np.sum(residuals(part, nominal[rows]) ** 2, axis=1)
        size = np.bincount(part.case, square) / np.maximum(np.bincount(part.case), 1)
        worst = int(size.argmax())
        if size[worst] < 16.0 * np.median(size[np.unique(part.case)]):
            break
        out.append(worst)
        keep &= unloaded.case != worst
    if out:
        rows = np.flatnonzero(keep)
        part = unloaded.chosen(rows)
        rms = float(left_over(part, nominal[None, rows])[0])
        yield _Try("experiments", tuple(names[i] for i in sorted(out)), rms, {})


def _bumped(unloaded: Unloaded, names: Sequence[str]) -> Iterator[_Try]:
    """One station that stood elsewhere from some experiment on."""
    nominal = unloaded.nominal()[0]
    cases = np.array(list(dict.fromkeys(unloaded.case.tolist())))
    if len(np.unique(unloaded.station)) > 1 or len(cases) < 2 * _FEWEST:
        return
    place = np.empty(int(cases.max()) + 1, dtype=np.int64)
    place[cases] = np.arange(len(cases))
    when = place[unloaded.case]
    left = _two_frames(unloaded.position, nominal, when)
    best = _FEWEST + int(left[_FEWEST - 1 : len(cases) - _FEWEST].argmin())
    sides = (when < best, when >= best)
    frames = [best_fits(unloaded.position[side], nominal[None, side]) for side in sides]
    moved = [unloaded.position @ turn[0].T + shift[0] for turn, shift, _ in frames]
    by = float(np.sqrt(np.mean(np.sum((moved[1] - moved[0]) ** 2, axis=1))))
    rms = float(left[best - 1])
    if by > rms:
        yield _Try("bumped", (names[int(cases[best])],), rms, {"by": by})


def _two_frames(points: Array, nominal: Array, when: IntArray) -> Array:
    """(N - 1,) root mean square distances [m] with one best fit before, and one from each on.

    From sums over the experiments before, so that all of them take no longer than a few.

    Args:
        points: (R, 3) as read.
        nominal: (R, 3) as they should be.
        when: (R,) which of N experiments each belongs to, in their order.
    """
    a, b = points - points.mean(axis=0), nominal - nominal.mean(axis=0)
    pairs = (b[:, :, None] * a[:, None, :]).reshape(-1, 9)
    squares = np.sum(a**2 + b**2, axis=1, keepdims=True)
    each = np.hstack([np.ones((len(a), 1)), a, b, pairs, squares])
    count = int(when.max()) + 1
    sums = np.stack([np.bincount(when, column, count) for column in each.T], axis=1)
    before: Array = np.cumsum(sums, axis=0).astype(float)
    left = _left(before[:-1]) + _left(before[-1] - before[:-1])
    return np.asarray(np.sqrt(np.maximum(left, 0.0) / len(a)))


def _left(sums: Array) -> Array:
    """(S,) sums of squares that the best fit leaves, of sums (S, 17) as in `_two_frames`.

    Source: Kabsch 1976: |a|² + |b|² less twice the singular values, the last by its sign.
    """
    count, a, b = sums[:, :1], sums[:, 1:4], sums[:, 4:7]
    pairs = sums[:, 7:16].reshape(-1, 3, 3) - b[:, :, None] * a[:, None, :] / count[:, :, None]
    square = sums[:, 16] - np.sum(a**2 + b**2, axis=1) / count[:, 0]
    values = np.linalg.svd(pairs, compute_uv=False)
    values[:, 2] *= np.sign(np.linalg.det(pairs))
    return np.asarray(square - 2.0 * values.sum(axis=1))
