"""Small proofs by plain means, to be checked: three statements, and trees by first-order bounds.

Nothing is shared with the core or the checker: rows by cross products, derivatives by differences,
suprema by chance with room to spare.
"""

from __future__ import annotations

import itertools
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array

Raw = dict[str, Any]
STEP = 1e-4


def _joint(name: str, kind: str, axis: list[float], point: list[float], reach: float) -> Raw:
    return {
        "name": name, "kind": kind, "axis": axis, "point": point, "lower": -reach, "upper": reach,
    }  # fmt: skip


def _spring(joint: Raw, body: int) -> Raw:
    return {key: joint[key] for key in ("name", "kind", "axis", "point")} | {"body": body}


def _statement(joints: list[Raw], springs: list[Raw], seed: int, **rest: Any) -> Raw:
    rng, c, n = np.random.default_rng(seed), len(springs), len(joints)
    V = rng.normal(size=(c, 2))
    raw: Raw = {
        "format": "elastocal-proof 1",
        "name": "small",
        "criterion": "test-pose",
        "source": {"study_sha256": "0" * 64, "version": "0"},
        "joints": joints,
        "springs": springs,
        "make": np.eye(c).tolist(),
        "unknowns": [spring["name"] for spring in springs],
        "markers": [[2.0, 0.0, 0.5]],
        "sigma": 0.5,
        "sigma_turn": None,
        "constraints": [],
        "left_out": [],
        "mix": np.eye(n).tolist(),
        "root": {
            "lower": [joint["lower"] for joint in joints],
            "upper": [joint["upper"] for joint in joints],
        },
        "limited": [False] * n,
        "held": [],
        "halved": [],
        "V": V.tolist(),
        "K": (V + 0.1 * rng.normal(size=V.shape)).tolist(),
        "B": np.diag(rng.uniform(0.1, 1.0, c)).tolist(),
        "count": 4,
        "tables": {"points": []},
    }
    return raw | rest


def planar() -> Raw:
    """Three parallel axes, one sum coordinate; two of three constraints and a limit matter."""
    points = [[0.0, 0.0, 0.5], [0.8, 0.0, 0.5], [1.5, 0.0, 0.5]]
    reach = (1.0, 1.6, 1.2)
    joints = [_joint(f"J{i + 1}", "turns", [0.0, 1.0, 0.0], points[i], reach[i]) for i in range(3)]
    load = {"kind": "fixed", "point": [2.0, 0.0, 0.6], "force": [0.5, 0.0, -2.0]}
    return _statement(
        joints,
        [_spring(joint, i + 1) for i, joint in enumerate(joints)],
        4,
        load=load | {"moment": [0.0, 0.4, 0.0]},
        mix=[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 1.0]],
        root={"lower": [-1.0, -1.6, -2.8], "upper": [1.0, 1.6, 2.8]},
        limited=[False, False, True],
        constraints=[
            {
                "name": "height", "kind": "plane", "point": [2.0, 0.0, 0.5],
                "normal": [0.0, 0.0, 1.0], "offset": 0.2,
            },
            {
                "name": "tilt", "kind": "direction", "axis": [1.0, 0.0, 0.0],
                "normal": [1.0, 0.0, 0.0], "offset": -0.5,
            },
            {
                "name": "radius", "kind": "distance", "point": [2.0, 0.0, 0.5],
                "center": [0.0, 0.0, 0.0], "weights": [1.0, 1.0, 0.0], "sign": -1, "bound": 1.2,
            },
        ],
    )  # fmt: skip


def gantry() -> Raw:
    """Two slides and a wrist on a foot that tilts; a force of any direction in a plane."""
    joints = [
        _joint("X", "slides", [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.5),
        _joint("Z", "slides", [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 0.4),
        _joint("W", "turns", [0.0, 1.0, 0.0], [0.2, 0.0, 1.0], 1.0),
    ]
    foot = {"name": "foot", "kind": "turns", "axis": [0.0, 1.0, 0.0], "point": [0.0, 0.0, 0.0]}
    basis = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]
    return _statement(
        joints,
        [foot | {"body": 0}, _spring(joints[1], 2), _spring(joints[2], 3)],
        2,
        load={"kind": "free", "point": [0.6, 0.0, 0.9], "size": 2.0, "basis": basis},
        markers=[[0.6, 0.0, 0.9], [0.5, 0.1, 1.1]],
        sigma_turn=0.9,
    )


def tower() -> Raw:
    """A turret that turns all, a mirror plane, and a last joint on whose axis all points lie."""
    joints = [
        _joint("A1", "turns", [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 2.0),
        _joint("A2", "turns", [0.0, 1.0, 0.0], [0.1, 0.0, 0.5], 0.9),
        _joint("A3", "turns", [0.0, 1.0, 0.0], [0.8, 0.0, 0.5], 0.8),
        _joint("A4", "turns", [1.0, 0.0, 0.0], [1.0, 0.0, 0.5], 3.0),
        _joint("A5", "turns", [1.0, 0.0, 0.0], [1.2, 0.0, 0.8], 1.0),
    ]
    load = {"kind": "fixed", "point": [1.5, 0.0, 0.8], "force": [0.0, 0.0, -2.0]}
    return _statement(
        joints,
        [_spring(joints[i], i + 1) for i in (1, 2, 3)],
        3,
        load=load | {"moment": [0.0, 0.0, 0.0]},
        markers=[[1.5, 0.0, 0.8]],
        root={"lower": [0.0, -0.9, -0.8, 0.0, 0.0], "upper": [0.0, 0.9, 0.8, 3.0, 0.0]},
        held=[{"variable": 0, "because": "base"}, {"variable": 4, "because": "flat"}],
        halved=[{"variable": 3, "signs": [1, 1, 1, -1, 1], "shifts": [0, 0, 0, 0, 0]}],
        constraints=[
            {
                "name": "height", "kind": "plane", "point": [1.5, 0.0, 0.8],
                "normal": [0.0, 0.0, 1.0], "offset": 0.3,
            },
        ],
    )  # fmt: skip


def rows(raw: Raw, x: Array) -> tuple[Array, Array]:
    """(N, v, F) rows times V over sigma, and (N, K) constraints and limits, at x (N, n)."""
    q = x @ np.array(raw["mix"]).T
    R, t = np.broadcast_to(np.eye(3), (len(x), 3, 3)), np.zeros((len(x), 3))
    bodies = [(R, t)]
    for joint, way in zip(raw["joints"], q.T, strict=True):
        a, o = np.array(joint["axis"]), np.array(joint["point"])
        K = np.cross(a, np.eye(3)).T
        if joint["kind"] == "slides":
            t = t + np.einsum("nij,nj->ni", R, way[:, None] * a)
        else:
            sine, cosine = np.sin(way)[:, None, None], np.cos(way)[:, None, None]
            turn = np.eye(3) + sine * K + (1.0 - cosine) * K @ K
            t, R = t + np.einsum("nij,nj->ni", R, o - turn @ o), R @ turn
        bodies.append((R, t))
    R, t = bodies[-1]
    load, forces = raw["load"], np.eye(3)
    if load["kind"] == "fixed":
        forces = np.array([load["force"]]).T
    else:
        forces = load["size"] * np.array(load["basis"])
    moment, V = np.array(load.get("moment", np.zeros(3))), np.array(raw["make"]) @ raw["V"]
    total = 0.0
    for spring, values in zip(raw["springs"], V, strict=True):
        Q, s = bodies[spring["body"]]
        axis, origin = Q @ np.array(spring["axis"]), Q @ np.array(spring["point"]) + s

        def speed(point: Any, spring: Raw = spring, a: Array = axis, o: Array = origin) -> Array:
            return a if spring["kind"] == "slides" else np.cross(a, R @ np.array(point) + t - o)

        turns = float(spring["kind"] == "turns")
        y = speed(load["point"]) @ forces + turns * (axis @ moment)[:, None]
        read = [speed(marker) / raw["sigma"] for marker in raw["markers"]]
        if raw["sigma_turn"] is not None:
            read.append(turns * axis / raw["sigma_turn"])
        column = np.concatenate(read, axis=1)
        total = total + np.einsum("ni,r,nf->nirf", column, values, y)
    values = []
    for c in raw["constraints"]:
        if c["kind"] == "direction":
            values.append(R @ np.array(c["axis"]) @ c["normal"] - c["offset"])
            continue
        p = R @ np.array(c["point"]) + t
        if c["kind"] == "plane":
            values.append(p @ c["normal"] - c["offset"])
        else:
            away = (p - c["center"]) ** 2 @ c["weights"]
            values.append(c["sign"] * (away - c["bound"] ** 2))
    for i in np.flatnonzero(raw["limited"]):
        values += [q[:, i] - raw["joints"][i]["lower"], raw["joints"][i]["upper"] - q[:, i]]
    return (
        np.asarray(total).reshape(len(x), -1, forces.shape[1]),
        np.array(values).reshape(len(values), len(x)).T,
    )


def largest(W: Array) -> Array:
    """(N,) largest |W u|² over |u| ≤ 1."""
    return np.asarray(np.linalg.eigvalsh(np.swapaxes(W, 1, 2) @ W)[:, -1])


def chance(raw: Raw, rng: np.random.Generator, count: int) -> Array:
    """(count, n) points of the root."""
    low, high = np.array(raw["root"]["lower"]), np.array(raw["root"]["upper"])
    return np.asarray(low + (high - low) * rng.random((count, len(low))))


def _differences(raw: Raw, x: Array, active: list[int]) -> list[tuple[Array, Array]]:
    """Central differences of rows and constraints along the active variables."""
    found = []
    for i in active:
        step = STEP * np.eye(x.shape[1])[i]
        (a, b), (c, d) = rows(raw, x + step), rows(raw, x - step)
        found.append(((a - c) / (2.0 * STEP), (b - d) / (2.0 * STEP)))
    return found


def prove(raw: Raw, room: float = 0.1) -> tuple[Raw, bytes]:
    """The statement with U, claim and witnesses, and its tree.

    Args:
        raw: The statement.
        room: Share by which U is above the largest d that is met by chance.
    """
    rng, n = np.random.default_rng(0), len(raw["joints"])
    low, high = np.array(raw["root"]["lower"]), np.array(raw["root"]["upper"])
    active = np.flatnonzero(high > low).tolist()
    x = chance(raw, rng, 20000)
    W, g = rows(raw, x)
    feasible = (g >= 0.0).all(axis=1)
    d = np.where(feasible, largest(W), -1.0)
    V, K, B = (np.array(raw[name]) for name in ("V", "K", "B"))
    U = float((1.0 + room) * d.max())
    best = d.argsort()[-3:]
    _, vectors = np.linalg.eigh(np.swapaxes(W[best], 1, 2) @ W[best])
    load = raw["load"]
    if load["kind"] == "fixed":
        force = np.tile(np.array(load["force"]), (3, 1))
    else:
        force = load["size"] * vectors[:, :, -1] @ np.array(load["basis"]).T
    raw = raw | {
        "largest": U,
        "rho0": float((V * K).sum() / np.sqrt(np.trace(V.T @ B @ V) + raw["count"] * U)),
        "witnesses": np.hstack([x[best], force]).tolist(),
    }
    few = x[:1500]
    bent, bent_g = np.zeros((len(active),) * 2), np.zeros((len(active),) * 2 + g.shape[1:])
    for j, i in enumerate(active):
        step = STEP * np.eye(n)[i]
        both = [_differences(raw, at, active) for at in (few + step, few - step)]
        for k, ((a, b), (c, e)) in enumerate(zip(*both, strict=True)):
            bent[j, k] = 1.3 * np.sqrt(largest((a - c) / (2.0 * STEP)).max())
            bent_g[j, k] = 1.3 * np.abs((b - e) / (2.0 * STEP)).max(axis=0)
    centre, half = 0.5 * (low + high)[None], 0.5 * (high - low)[None]
    symbols, children, numbers = [255], [(-1, -1)], [0]
    while len(numbers):
        W, g = rows(raw, centre)
        r, slopes = half[:, active], _differences(raw, centre, active)
        size = np.zeros(len(r))
        for signs in itertools.product((1.0, -1.0), repeat=len(active)):
            ends = zip(signs, r.T, slopes, strict=True)
            corner = W + sum(s * a[:, None, None] * slope[0] for s, a, slope in ends)
            size = np.maximum(size, np.sqrt(largest(corner)))
        size += 0.5 * np.einsum("ni,ij,nj->n", r, bent, r)
        top = g + sum(a[:, None] * abs(slope[1]) for a, slope in zip(r.T, slopes, strict=True))
        top = top + 0.5 * np.einsum("ni,ijk,nj->nk", r, bent_g, r)
        left = np.flatnonzero((size**2 > U) & (top > 0.0).all(axis=1))
        widest = (r * bent.sum(axis=1))[left].argmax(axis=1)
        parts, following = [], []
        for row, j in zip(left.tolist(), widest.tolist(), strict=True):
            i, number = active[j], numbers[row]
            shift = 0.5 * half[row, i] * np.eye(n)[i]
            symbols[number], children[number] = i, (len(symbols), len(symbols) + 1)
            following += [len(symbols), len(symbols) + 1]
            symbols += [255, 255]
            children += [(-1, -1), (-1, -1)]
            parts += [(centre[row] - shift, half[row] - shift)]
            parts += [(centre[row] + shift, half[row] - shift)]
        numbers = following
        if parts:
            centre, half = (np.array(part) for part in zip(*parts, strict=True))
    tree, stack = bytearray(), [0]
    while stack:
        number = stack.pop()
        tree.append(symbols[number])
        if children[number][0] >= 0:
            stack += children[number][::-1]
    return raw, bytes(tree)


def write(path: Path, raw: Raw, tree: bytes) -> Path:
    """A proof file."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as file:
        file.writestr("statement.json", json.dumps(raw))
        file.writestr("tree", tree)
    return path
