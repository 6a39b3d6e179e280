"""Whether a proof holds: reads a proof file and bounds every box of its tree again, by other means.

`statement.json` says: with these joints, springs, loads and constraints no load case x has d(x) =
|A(x) V|² / σ² above U, so no plan of m load cases has a loss below tr(V'K) / √(tr(V'BV) + m U).
`tree` says how the root box is halved until d can be bounded: depth first, byte k halves variable
k (lower half first), 255 ends. Motions are products of 4 x 4 matrices; W = A V / σ, of degree 2 in
sines and cosines of what turns and in what slides, is sampled for coefficients, which give all
derivatives. In a box |W(c + h)| ≤ |P(h)| + R, P of order 2, |h_i| ≤ r_i, R = Σ r^α S_α, |α| = 3,
S_α ≥ sup |∂^α W|/α! by maxima on N angles over Π cos(π degree / N) (Ehlich and Zeller 1964). |P|²
is exact to order 2, absolute beyond; constraints g ≥ 0 are added with multipliers ≥ 0; of free
forces a Schur complement bounds P'P. What is not bounded so is halved, six times at most.
"""

import argparse
import itertools
import json
import math
import sys
import time
import zipfile
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
Axis = tuple[bool, float, float, int]  # turns, middle, half width, degree
LEAF, BATCH, DEEPER, MOST, TURN = 255, 2048, 6, 3_000_000, 2.0 * math.pi
ROUNDING, NOISE = 1e-12, 1e-8  # shares of what may cancel: margin; harmonics dropped, but counted
CLOSE, BUDGET = 1e-11, 5e8  # a tenth of what boxes are enlarged by [rad or m]; numbers of tables


@dataclass(frozen=True)
class ProofVerdict:
    """What became of a proof file; verified only if all of it was found right."""

    verified: bool
    complete: bool
    leaves: int
    checked: int
    message: str


def _require(condition: Any, fault: str) -> None:
    if not condition:  # everywhere so written that what is not a number never passes
        raise ValueError(fault)


def read(text: bytes) -> SimpleNamespace:
    """What a statement says, as arrays; it makes sense, and its claim follows from U."""
    s = SimpleNamespace(**json.loads(text))
    for of in [*s.joints, *s.springs]:
        of["turns"] = {"turns": True, "slides": False}[of["kind"]]
    V, K, B, s.mix, make = (np.array(x, dtype=float) for x in (s.V, s.K, s.B, s.mix, s.make))
    s.box, s.n = np.array([s.root["lower"], s.root["upper"]], dtype=float), len(s.joints)
    s.limits = np.array([[j["lower"], j["upper"]] for j in s.joints], dtype=float).T
    s.turns, s.limited = np.array([j["turns"] for j in s.joints]), np.array(s.limited, dtype=bool)
    s.wide, s.back = s.turns & (np.ptp(s.limits, 0) >= TURN - 1e-9), np.linalg.inv(s.mix).round()
    held, steady = {h["variable"]: h["because"] for h in s.held}, s.load["kind"] == "fixed"
    s.held, s.base = np.array([[i in held, held.get(i) == "base"] for i in range(s.n)]).T
    moved = [s.load["force"]] if steady else np.transpose(s.load["basis"]) * s.load["size"]
    s.forces, s.moment = np.array(moved).T, np.array(s.load["moment"] if steady else np.zeros(3))
    s.V, s.F = np.linalg.qr((make @ V).T)[1].T, len(s.forces.T)  # |A V| stays
    above = math.fsum((V * K).ravel()) - 1e-15 * abs(V * K).sum()
    below = np.trace(V.T @ B @ V) + 1e-14 * np.trace(abs(V).T @ abs(B) @ abs(V))
    follows = above / math.sqrt(below + s.count * s.largest) * (1.0 + ROUNDING)
    rules = {
        "format": s.format == "elastocal-proof 1",
        "load, as cones are beyond this checker": s.load["kind"] in ("fixed", "free"),
        "constraints": {c["kind"] for c in s.constraints} <= {"plane", "direction", "distance"},
        "axes": all(abs(np.linalg.norm(j["axis"]) - 1.0) < ROUNDING for j in s.joints),
        "mix": (s.mix == np.tril(s.mix * (s.turns == s.turns[:, None])).round()).all(),
        "diagonal or limited": (np.diag(s.mix) == 1.0).all() and not (s.limited & s.wide).any(),
        "bodies": {spring["body"] for spring in s.springs} <= set(range(s.n + 1)),
        "V, K, count or largest": V.shape == K.shape and s.count >= 1 and s.largest > 0.0,
        "B": (B == B.T).all() and np.linalg.eigvalsh(B)[0] >= -ROUNDING * abs(B).max(),
        f"rho0, as only {follows:.9g} follows": s.rho0 <= follows,
    }
    for rule, holds in rules.items():
        _require(holds, f"the statement is wrong: {rule}")
    return s


def _basis(axis: Axis, x: Array, order: int) -> Array:
    """(N, size) derivatives over order! of 1, cos x, cos 2x, … sin x, …, or powers if it slides."""
    turns, middle, half, degree = axis
    k = np.arange(degree + 1)
    if turns:
        angles, scale = np.outer(x, k) + order * math.pi / 2.0, k**order / math.factorial(order)
        return np.hstack([scale * np.cos(angles), (scale * np.sin(angles))[:, 1:]])
    powers = ((x - middle) / half)[:, None] ** np.maximum(k - order, 0)
    return powers * [math.comb(j, order) for j in k.tolist()] / half**order


def _nodes(axis: Axis, count: int) -> Array:  # equidistant angles, or the nodes of Chebyshev
    angles = np.arange(count) * TURN / count
    return angles if axis[0] else axis[1] - axis[2] * np.cos((angles + np.pi / count) / 2.0)


def _words(n: int, *orders: int) -> list[tuple[int, ...]]:  # partial derivatives of n variables
    return [w for o in orders for w in itertools.combinations_with_replacement(range(n), o)]


def _powers(r: Array, *orders: int) -> Array:  # (N, words) r^α at r (N, n)
    return np.stack([r[:, list(w)].prod(axis=1) for w in _words(r.shape[1], *orders)], axis=1)


def expansions(axes: list[Axis], C: Array, x: Array) -> Array:
    """(N, words, values) Taylor coefficients up to order 2 at x (N, n), from coefficients C."""
    words, group, sums = _words(0, 0), np.zeros(len(x), dtype=np.int64), C[None, None]
    for j, axis in enumerate(axes):  # boxes share coordinates, so sums over leading ones are shared
        values, which = np.unique(x[:, j], return_inverse=True)
        keys, group = np.unique(group * len(values) + which, return_inverse=True)
        rows = np.stack([_basis(axis, values, o) for o in range(3)], axis=1)[keys % len(values)]
        old = np.moveaxis(sums, 2, 1).reshape(len(sums), rows.shape[2], -1)
        ends = np.searchsorted(keys, np.arange(len(old) + 1) * len(values)).tolist()
        parts = zip(old, itertools.pairwise(ends), strict=True)
        new = np.concatenate([rows[k:m].reshape(-1, len(one)) @ one for one, (k, m) in parts])
        grown = {w + (j,) * o: o * len(words) + k for o in range(3) for k, w in enumerate(words)}
        words, shape = _words(j + 1, 0, 1, 2), (len(keys), len(grown), *sums.shape[3:])
        sums = new.reshape(shape)[:, [grown[word] for word in words]]
    return sums[group]


def suprema(axes: list[Axis], C: Array, v: int) -> Array:
    """(words of order 3, …) sup |∂^α|/α!: of the norm of v values, of each other one."""
    found, words = [], _words(len(axes), 3)
    most = min(32, int((BUDGET / len(words) / C.shape[-1]) ** (1.0 / len(axes))))  # to be paid for
    counts = [max(most, 2 * degree + 2) if degree else 1 for *_, degree in axes]
    cosines = [math.cos(math.pi * a[3] / counts[i] / (2 - a[0])) for i, a in enumerate(axes)]
    for word in words:
        tables = [_basis(a, _nodes(a, counts[i]), word.count(i)) for i, a in enumerate(axes)]
        peak = np.zeros(1 + C.shape[-1] - v)
        for row in tables[0]:
            values = np.tensordot(row, C, (0, 0))
            for table in tables[1:]:
                values = np.tensordot(values, table, (0, 1))
            values = abs(values.reshape(C.shape[-1], -1))
            norm = np.sqrt((values[:v] ** 2).sum(axis=0).max())
            peak = np.maximum(peak, [norm, *values[v:].max(axis=1)])
        found.append(peak / math.prod(cosines))
    return np.array(found)


def _twist(of: dict[str, Any]) -> Array:  # (4, 4) velocities of points by a joint or spring
    turn = np.cross(of["axis"], np.eye(3)).T * of["turns"]
    side = -turn @ of["point"] if of["turns"] else of["axis"]
    return np.vstack([np.column_stack([turn, side]), np.zeros(4)])


def functions(s: SimpleNamespace, x: Array) -> tuple[Array, Array, Array, Array]:
    """(N, rows, r, F) W and (N, K) constraints at x (N, n), and what may cancel in them."""
    q, tip, frames = x @ s.mix.T, np.broadcast_to(np.eye(4), (len(x), 4, 4)), list[Array]()
    for joint, way in zip(s.joints, q.T[:, :, None, None], strict=True):
        X, speed = _twist(joint), np.sin(way) if joint["turns"] else way
        frames.append(tip)
        tip = tip @ (np.eye(4) + speed * X + (1.0 - np.cos(way)) * (X @ X))
    W, size = np.zeros(()), np.zeros(())
    for spring, V in zip(s.springs, s.V, strict=True):
        frame = [*frames, tip][spring["body"]]
        moved = frame @ _twist(spring) @ np.linalg.inv(frame)
        axis, lever = moved[:, [2, 0, 1], [1, 2, 0]], moved @ tip @ np.append(s.load["point"], 1.0)
        y = lever[:, :3] @ s.forces + (axis @ s.moment)[:, None]
        reads = [(moved @ tip @ np.append(p, 1.0))[:, :3] / s.sigma for p in s.markers]
        reads += [axis / s.sigma_turn] if s.sigma_turn is not None else []
        column = np.einsum("ni,r,nf->nirf", np.hstack(reads), V, y)
        W, size = W + column, size + abs(column)
    pairs = [(np.zeros(len(x)), np.ones(len(x)))]  # 0 ≥ 0 is always there
    for c in s.constraints:
        aims, far = c["kind"] == "direction", c["kind"] == "distance"
        place = (tip @ np.append(c["axis" if aims else "point"], 1.0 - aims))[:, :3]
        way = (place - c["center"]) ** 2 @ c["weights"] if far else place @ c["normal"]
        bound, sign = (c["bound"] ** 2, c["sign"]) if far else (c["offset"], 1.0)
        pairs.append((sign * (way - bound), abs(way) + abs(bound) + 1e-300))
    for i in np.flatnonzero(s.limited):
        way, half = q[:, i] - s.limits[:, i].mean(), np.ptp(s.limits[:, i]) / 2.0
        room = np.cos(way) - math.cos(half) if s.turns[i] else half**2 - way**2
        pairs.append((room, 1.0 + way**2))
    g, sizes = np.array(pairs).transpose(1, 2, 0)
    return W, g, size, sizes


def check_domain(s: SimpleNamespace, x: Array) -> float:
    """The root covers the limits; what is held as base or halved keeps |W u|, up to this share:
    both sides have the degrees of W, so what holds on the grid x of samples holds everywhere."""
    eye, lost, halves, span, whole = np.eye(s.n), 0.0, list[int](), list[Array](), list[Array]()
    moves = [(i, np.ones(s.n), eye[i]) for i in range(s.n) if s.base[i]]  # 1 rad: dense if repeated
    moves += [(h["variable"], np.array(h["signs"]), np.array(h["shifts"])) for h in s.halved]
    for i, joint in enumerate(s.joints):
        mine, around = s.box[:, i], 9 * int(s.turns[i] and not s.limited[i])  # any whole turn
        images = [signs[i] * mine + s.back[i] @ shifts for k, signs, shifts in moves if k == i]
        parts = [np.sort(a) + k * TURN for a in (mine, *images) for k in range(-around, around + 1)]
        ranges = []
        for of in (span, whole):  # with halves, and before anything was halved
            need = s.limits[:, i] + sum(np.sort(-s.mix[i, j] * of[j]) for j in range(i))
            ranges.append(mine[0] + [0.0, TURN] if around and np.ptp(need) > TURN else need)
        low, high = ranges[len(images) > 0]
        for start, end in sorted(map(tuple, parts)):
            low = max(low, end) if start <= low + CLOSE else low
        fits = mine[0] == mine[1] if s.held[i] else low >= high - CLOSE
        _require(fits, f"the root does not cover {joint['name']}, or does not hold it at one value")
        span.append(ranges[0] if s.held[i] and not s.base[i] else mine)
        whole.append(mine if s.base[i] else ranges[1])
    for i, signs, shifts in moves:
        L, t, base = s.back * signs @ s.mix, s.back @ shifts, bool(s.base[i])
        off = abs(np.sort(signs * s.limits + shifts, axis=0) - s.limits).max(axis=0)
        free = s.wide | s.base | (s.held & (abs(s.mix).sum(axis=0) == 1.0))  # of limits
        back = np.sin((np.sort(s.box @ L.T + t, axis=0) - s.box) / 2.0)
        still, all_ = abs(back).max(axis=0) < CLOSE, halves + [i] * (not base)
        kept = [free | (off < CLOSE), abs(signs) == 1, s.turns | (shifts == 0), s.turns[[i]]]
        kept += [abs(L[all_]) == eye[all_], still[halves]]
        kept += [still | ~s.base | ~s.back[all_].any(axis=0), (s.mix[i] == eye[i]) | (not base)]
        X, halves = _twist(s.joints[i])[:3, :3], all_
        R = np.eye(3) - math.sin(1.0) * X + (1.0 - math.cos(1.0)) * X @ X
        turns = [np.diag(mirror) for mirror in itertools.product((1.0, -1.0), repeat=s.F)]
        turns = [np.linalg.pinv(s.forces) @ R @ s.forces] if base else turns
        kept += [abs(turn.T @ turn - np.eye(s.F)) < ROUNDING for turn in turns]
        z, least = x if base else np.where(s.base, s.box[0], x), math.inf
        (W, g, _, sizes), (W2, g2, *_) = functions(s, z), functions(s, z @ L.T + t)
        other = abs(g2[:, :, None] - g[:, None]).max(axis=0) / sizes.max(axis=0)[:, None]
        b = np.moveaxis(W2, 1, 0).reshape(W.shape[1], -1)
        for a in (np.moveaxis(W @ turn, 1, 0).reshape(b.shape) for turn in turns):
            left, _, right = np.linalg.svd(b @ a.T)  # b = O a, O orthogonal, as near as can be
            least = min(least, abs(b - left @ right @ a).max() / (abs(b).max() + 1e-300))
        lost += max(least, other.min(axis=1).max())
        _require(lost < NOISE and all(map(np.all, kept)), f"no symmetry frees variable {i}")
    return lost


def pose(s: SimpleNamespace) -> SimpleNamespace:
    """What bounds need: coefficients, suprema, margins; checks what is held and what is halved."""
    width, degrees = np.ptp(s.box, axis=0), 2 * abs(s.mix).sum(axis=0).astype(int)
    columns = (s.turns, s.box.mean(axis=0), width / 2.0 + (width == 0.0), degrees)
    axes: list[Axis] = list(zip(*(column.tolist() for column in columns), strict=True))
    nodes = [_nodes(axis, axis[3] * (1 + axis[0]) + 1) for axis in axes]
    _require(math.prod(map(len, nodes)) <= MOST, "there are more variables than can be sampled")
    x = np.stack([part.ravel() for part in np.meshgrid(*nodes, indexing="ij")], axis=1)
    W, g, size, sizes = functions(s, x)
    scale, v = size.max() + 1e-300, W[0].size
    error = 100.0 * v * 3.0**s.n * check_domain(s, x)  # between samples, and by many turns of 1 rad
    C = np.hstack([W.reshape(len(x), -1) / scale, g / sizes.max(axis=0)])
    C, lost = C.reshape(*map(len, nodes), -1), np.full(C.shape[1], ROUNDING)
    for i, axis in enumerate(axes):
        C = np.tensordot(np.linalg.inv(_basis(axis, nodes[i], 0)), C, (1, i))
        k = np.r_[0 : axis[3] + 1, 1 : len(C) - axis[3]]
        rest = abs(C).reshape(len(C), -1, len(lost)).sum(axis=1)
        degree = int(k[~(rest.max(axis=1) <= NOISE)].max(initial=0))  # of harmonics that are there
        C, lost, axes[i] = C[k <= degree], lost + rest[k > degree].sum(axis=0), (*axis[:3], degree)
        if s.box[0, i] == s.box[1, i]:
            _require(s.base[i] or not s.held[i] or not degree, f"variable {i} is not flat")
            C = np.tensordot(_basis(axes[i], s.box[:1, i], 0), C, 1)
        C = np.moveaxis(C, 0, i)
    active = np.flatnonzero(s.box[0] < s.box[1]).tolist() or [0]
    p = SimpleNamespace(active=active, F=s.F, v=v, axes=[axes[i] for i in active])
    firm = s.limited & ~np.isin(np.arange(s.n), [h["variable"] for h in s.halved])  # no whole turns
    p.mix, p.limits = s.mix[firm], s.limits[:, firm]
    p.C = C.reshape(*(C.shape[i] for i in active), -1)
    p.slack = np.array([np.linalg.norm(lost[:v]), *(lost[v:] + error)])
    p.third, p.U, n = suprema(p.axes, p.C, v), s.largest / scale**2 - error, len(active)
    two = {word: k for k, word in enumerate(_words(n, 2))}
    p.pairs = np.array([[two[min(i, j), max(i, j)] for j in range(n)] for i in range(n)])
    return p


def box_maximum(slope: Array, bend: Array) -> Array:
    """(…) bound of slope·h + h'(bend)h/2 over |h_i| ≤ 1, from (…, n) and (…, n, n)."""
    own = np.einsum("...ii->...i", bend)
    own, size = own - abs(own) + abs(bend).sum(axis=-1), abs(slope)
    h = np.where(own < -size, size / np.maximum(-own, size + 1e-300), 1.0)
    return (size * h + own * h**2 / 2.0).sum(axis=-1)


def excess(t: Array, c: Array, b: Array, rest: Array, f: Array, a: Array, H: Array) -> Array:
    """(…) what f + a·h + h'Hh/2 + (Σ (b_g·h)² + rest)/(t - c) may be above t; proved if ≤ 0."""
    share = 1.0 / np.where(t > c, t - c, np.inf)
    H = H + 2.0 * np.einsum("...gi,...gj,...->...ij", b, b, share)
    return np.where(t > c, f + box_maximum(a, H) + rest * share - t, np.inf)


def examine(p: SimpleNamespace, x: Array, r: Array) -> tuple[Array, Array]:
    """Of boxes (N, n): which are proved; in which variable the others should be halved."""
    h, n, F, both = r[:, p.active], len(p.active), p.F, (1, 2)
    E = expansions(p.axes, p.C, x[:, p.active]) * _powers(h, 0, 1, 2)[:, :, None]
    (N, words), rest = E.shape[:2], _powers(h, 3) @ p.third + p.slack
    W: Array = E[:, :, : p.v].reshape(N, words, -1, F)
    top, Q = np.linalg.eigh(np.swapaxes(W[:, 0], 1, 2) @ W[:, 0])
    W = W @ Q[:, None, :, ::-1]  # columns that are orthogonal at the centre, the largest first
    W = np.swapaxes(W, 2, 3).reshape(N, words * F, -1)
    gram = (W @ np.swapaxes(W, 1, 2)).reshape(N, words, F, words, F)
    G, cross, others = gram[:, :, 0, :, 0], gram[:, :, 0, :, 1:], abs(gram[:, :, 1:, :, 1:])
    one, two, twice = slice(1, n + 1), slice(n + 1, None), 1.0 + np.eye(n)
    f = G[:, 0, 0] + 2.0 * abs(G[:, one, two]).sum(axis=both) + abs(G[:, two, two]).sum(axis=both)
    H = 2.0 * G[:, one, one] + 2.0 * G[:, 0, two][:, p.pairs] * twice
    b = cross[:, 0, one] + cross[:, one, 0]
    size = abs(cross).sum(axis=both) - abs(cross[:, 0, one]).sum(1) - abs(cross[:, one, 0]).sum(1)
    bent = (2.0 * abs(b).sum(axis=1) * size + size**2).sum(axis=1)
    spread = others.sum(axis=(1, 3)) - others[:, 0, :, 0] + top[:, -2::-1, None] * np.eye(F - 1)
    c = np.linalg.eigvalsh(spread)[:, -1] if F > 1 else np.full(N, -np.inf)
    size = math.sqrt(max(p.U, 0.0)) - rest[:, 0]  # what is left of √U for P
    forms = [size * abs(size), c, np.swapaxes(b, 1, 2), bent, f, 2.0 * G[:, 0, one], H]
    q, reach = x @ p.mix.T, r @ abs(p.mix).T + CLOSE  # of joints whose limits are used
    out = ((q - reach > p.limits[1]) | (q + reach < p.limits[0])).any(axis=1)
    above, halve = np.where(out, -1.0, excess(*forms)), abs(H).sum(axis=1)
    halve += others[:, 0][:, :, one].sum(axis=(1, 3))
    live = np.flatnonzero(above > 0.0)
    forms, rest, now = [part[live] for part in forms], rest[live, 1:], above[live]
    E = np.swapaxes(E[live, :, p.v :], 1, 2)
    g, a, H = E[:, :, 0], E[:, :, one], E[:, :, two][:, :, p.pairs] * twice
    cuts = g - box_maximum(-a, -H) < rest
    now[(g + box_maximum(a, H) + rest < 0.0).any(axis=1)] = -1.0  # nothing feasible there
    for k in [*range(g.shape[1])] * 2:
        on = np.flatnonzero(cuts[:, k] & (now > 0.0))
        *fixed, f, slopes, bends = (part[on, None] for part in forms)
        there = slopes[:, 0] * a[on, k] < 0.0  # multipliers with which a slope changes its sign
        m = np.where(there, -slopes[:, 0] / np.where(there, a[on, k], 1.0), 0.0)
        pairs = ((f, (g + rest)[on, k]), (slopes, a[on, k]), (bends, H[on, k]))
        tried = [old + np.einsum("nj,n...->nj...", m, more) for old, more in pairs]
        found = excess(*fixed, *tried)
        best = (np.arange(len(on)), found.argmin(axis=1))
        better = found[best] < now[on]
        for part, new in zip([*forms[4:], now], [*tried, found], strict=True):
            part[on[better]] = new[best][better]
    above[live] = now
    return above <= 0.0, np.array(p.active)[halve.argmax(axis=1)]


def settle(p: SimpleNamespace, x: Array, r: Array, depth: int = DEEPER) -> Array:
    """Which boxes stay open, halved where they have to be."""
    proved, i = examine(p, x, r)
    left = np.flatnonzero(~proved)
    if not depth or not len(left):
        return left
    shift = np.where(np.arange(r.shape[1]) == i[left, None], r[left] / 2.0, 0.0)
    both, h = np.vstack([x[left] - shift, x[left] + shift]), np.tile(r[left] - shift, (2, 1))
    return np.unique(left[settle(p, both, h, depth - 1) % len(left)])


def walk(tree: bytes, n: int, active: list[int]) -> Any:
    """Leaves in order, (N, 1 + n): symbol, then of each variable 1 and a bit for each halving."""
    stack, found = [(1,) * n], []
    for place, symbol in enumerate(tree):
        _require(stack, f"symbol {place} and what follows are left over: the tree ends before")
        box = stack.pop()
        if symbol == LEAF:
            found.append((place, *box))
        else:
            _require(symbol in active, f"symbol {place} halves no variable")
            stack += [(*box[:symbol], 2 * box[symbol] + k, *box[symbol + 1 :]) for k in (1, 0)]
        if len(found) == BATCH:
            yield np.array(found)
            found = []
    _require(not stack, f"the tree ends, but {len(stack)} boxes are missing")
    yield np.array(found).reshape(-1, 1 + n)


def check(
    path: Any, *, seconds: Any = None, sample: Any = None, seed: int = 0, progress: Any = None
) -> ProofVerdict:
    """Verdict, of all leaves, of those in so many seconds, or of a random sample; never raises."""
    end, checked, leaves, complete = time.monotonic() + (seconds or math.inf), 0, 0, False
    try:
        with zipfile.ZipFile(path) as file:
            s, tree = read(file.read("statement.json")), file.read("tree")
        p, leaves, rng = pose(s), tree.count(LEAF), np.random.default_rng(seed)
        x, force = np.hsplit(np.array(s.witnesses, dtype=float), [s.n])
        (W, g, _, sizes), u = functions(s, x), force @ np.linalg.pinv(s.forces).T
        fits = [abs(u @ s.forces.T - force) <= 1e-9 * abs(s.forces).max(), g >= -1e-7 * sizes]
        fits += [(u @ u.T).diagonal() <= 1.0 + 1e-9, (u > 1.0 - 1e-9) | (s.load["kind"] == "free")]
        fits += [abs(x - s.box.mean(axis=0)) <= np.ptp(s.box, axis=0) / 2.0 + 1e-9]
        _require(len(x) and all(map(np.all, fits)), "a witness is missing or infeasible")
        d = ((W @ u[:, None, :, None]) ** 2).sum(axis=(1, 2, 3)).max()
        _require(d <= s.largest * (1.0 + ROUNDING), f"d is {d:.9g} at a witness, above U")
        for block in walk(tree, s.n, p.active):
            block = block[rng.random(len(block)) < (1.0 if sample is None else sample / leaves)]
            if time.monotonic() > end:
                break
            level, width = np.frexp(block[:, 1:])[1] - 1, np.ptp(s.box, axis=0)
            x = s.box[0] + width * (np.ldexp(block[:, 1:] + 0.5, -level) - 1.0)
            r = width * np.ldexp(0.5, -level) + 10.0 * CLOSE
            for k in settle(p, x, r)[:1]:
                _require(False, f"symbol {block[k, 0]}: no bound of d by U in {x[k]} ± {r[k]}")
            checked += len(block)
            (progress or max)(checked, leaves)
        complete = checked == leaves
        said = "verified, complete" if complete else "not verified, only sampled, without a fault"
        said += f": {checked} of {leaves} leaves; no plan of {s.count} has a loss below {s.rho0:.9}"
    except Exception as error:
        said = " ".join(f"not verified: {error} ({type(error).__name__})".split())
    return ProofVerdict(complete, complete, leaves, checked, said)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Checks a proof file.")
    parser.add_argument("path", metavar="proof")
    parser.add_argument("--seconds", type=float, help="how long to look at leaves")
    parser.add_argument("--sample", type=int, help="how many leaves to look at, drawn at random")
    verdict = check(**vars(parser.parse_args()))
    sys.stdout.write(f"{verdict.message}\n")
    sys.exit(not verdict.verified)
