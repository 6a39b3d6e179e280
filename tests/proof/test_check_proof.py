"""The checker of proofs: takes what is proved, refuses what is not, and each of its inequalities.

The inequalities are functions of the module, so that mutants of its text can be tried on them.
"""

from __future__ import annotations

import copy
import json
import subprocess
import sys
import types
import zipfile
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.core.library import library
from elastocal.planning.certificate import lower_bound
from elastocal.proof import check_proof
from elastocal.proof.check_proof import ProofVerdict, check
from elastocal.proof.prove import prove
from elastocal.proof.record import proof_bytes
from tests.paper.problems import three_link_study
from tests.proof import slow_proof
from tests.proof.slow_proof import Raw, write

SOURCE = Path(check_proof.__file__)


@pytest.fixture(scope="module")
def proofs() -> dict[str, tuple[Raw, bytes]]:
    kinds = (slow_proof.planar, slow_proof.gantry, slow_proof.tower)
    return {kind.__name__: slow_proof.prove(kind()) for kind in kinds}


@pytest.mark.parametrize("name", ["planar", "gantry", "tower"])
def test_what_is_proved_is_verified(
    name: str, proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path
) -> None:
    raw, tree = proofs[name]
    told: list[tuple[int, int]] = []
    verdict = check(
        write(tmp_path / "a.proof", raw, tree), progress=lambda *counts: told.append(counts)
    )
    leaves = tree.count(255)
    assert verdict == ProofVerdict(True, True, leaves, leaves, verdict.message)
    assert verdict.message.startswith("verified, complete")
    assert f"{raw['rho0']:.9g}" in verdict.message
    assert told[-1] == (leaves, leaves)


@pytest.mark.skipif(library() is None, reason="proofs need the compiled core")
def test_what_the_core_proves_is_verified(tmp_path: Path) -> None:
    """Three links: two symmetries, a base that is held, a sum coordinate, m ρ0² ≥ 1.48456 σ²."""
    study = three_link_study(4)
    found = prove(study, lower_bound(study, np.random.default_rng(0)), threads=1, gap=4e-5)
    path = tmp_path / "three.proof"
    path.write_bytes(proof_bytes(found.statement, found.tree))
    verdict = check(path)
    assert verdict.verified, verdict.message
    assert verdict.leaves > 10_000


def test_it_runs_alone(proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path) -> None:
    """Without the package: in a folder of its own, and with nothing of it loaded."""
    path = write(tmp_path / "a.proof", *proofs["planar"])
    alone = tmp_path / "check_proof.py"
    alone.write_text(SOURCE.read_text("utf-8"), encoding="utf-8")
    for options, code, said in (
        ([], 0, "verified, complete"),
        (["--sample", "20"], 1, "not verified, only sampled, without a fault"),
        (["--seconds", "1e-9"], 1, "not verified, only sampled, without a fault: 0 of"),
    ):
        command = [sys.executable, "-I", str(alone), str(path), *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (code, "")
        assert done.stdout.startswith(said)
        assert done.stdout.count("\n") == 1
    assert "elastocal" not in "".join(
        line for line in SOURCE.read_text("utf-8").splitlines() if "import" in line
    )


def test_a_sample_is_not_called_verified(
    proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path
) -> None:
    verdict = check(write(tmp_path / "a.proof", *proofs["planar"]), sample=30, seed=1)
    assert not verdict.verified
    assert not verdict.complete
    assert 0 < verdict.checked < verdict.leaves
    assert f"{verdict.checked} of {verdict.leaves}" in verdict.message


def _set(*keys: Any) -> Callable[[Raw], None]:
    """A change of one entry: keys, then the value."""

    def change(raw: Raw) -> None:
        at: Any = raw
        for key in keys[:-2]:
            at = at[key]
        at[keys[-2]] = keys[-1]

    return change


def _scaled(key: str, factor: float) -> Callable[[Raw], None]:
    def change(raw: Raw) -> None:
        raw[key] = (np.array(raw[key]) * factor).tolist()

    return change


def _foot(raw: Raw) -> None:
    foot = {"name": "foot", "kind": "turns", "axis": [0.0, 1.0, 0.0], "point": [0.0] * 3, "body": 0}
    raw["springs"].append(foot)
    raw["make"].append([0.3, 0.2, 0.1])


def _low_witness(raw: Raw) -> None:
    x = slow_proof.chance(raw, np.random.default_rng(1), 2000)
    W, g = slow_proof.rows(raw, x)
    d = np.where((g > 0.01).all(axis=1), slow_proof.largest(W), np.inf)
    raw["witnesses"] = [[*x[d.argmin()].tolist(), *raw["load"]["force"]]]
    raw["largest"] *= 0.88


WALL = {
    "name": "wall",
    "kind": "plane",
    "point": [2.0, 0.0, 0.5],
    "normal": [1, 0, 0],
    "offset": -9,
}
CHANGES: dict[str, tuple[str, Callable[[Raw], None], str]] = {
    "V": ("planar", _scaled("V", 1.5), "at a witness, above U"),
    "K": ("planar", _scaled("K", 0.99), "rho0, as only"),
    "B": ("planar", _scaled("B", 1.1), "rho0, as only"),
    "B no information": ("planar", _set("B", 0, 0, -0.1), "wrong: B"),
    "claim": ("planar", lambda raw: raw.update(rho0=raw["rho0"] * (1.0 + 1e-9)), "rho0, as only"),
    "count": ("planar", _set("count", 5), "rho0, as only"),
    "count below 1": ("planar", _set("count", -3), "not verified"),
    "threshold": ("planar", _scaled("largest", 0.7), "at a witness, above U"),
    "threshold, other witness": ("planar", _low_witness, "no bound of d by U in"),
    "no number": ("planar", _set("largest", float("nan")), "not verified"),
    "sigma": ("planar", _set("sigma", 0.4), "at a witness, above U"),
    "force": ("planar", _set("load", "force", [6.0, 0.0, -4.0]), "missing or infeasible"),
    "marker": ("planar", _set("markers", [[3.5, 0.0, 0.5]]), "above U"),
    "body": ("planar", _set("springs", 2, "body", -1), "wrong: bodies"),
    "constraint": ("planar", lambda raw: raw["constraints"].pop(2), "no bound of d by U in"),
    "direction": ("planar", _set("constraints", 1, "normal", [-1.0, 0.0, 0.0]), "witness"),
    "offset": ("planar", _set("constraints", 1, "offset", -0.9), "no bound of d by U in"),
    "no offset": ("planar", _set("constraints", 0, "offset", float("nan")), "witness"),
    "constraint of another kind": ("planar", _set("constraints", 0, "kind", "x"), "constraints"),
    "limit": ("planar", _set("joints", 1, "upper", 1.7), "does not cover J2"),
    "limit of a sum": ("planar", _set("joints", 2, "upper", 1.3), "does not cover J3"),
    "limits of a sum dropped": ("planar", _set("limited", [False] * 3), "no bound of d by U in"),
    "axis": ("planar", _set("joints", 0, "axis", [0.0, 1.1, 0.0]), "wrong: axes"),
    "mix": ("planar", _set("mix", 2, 1, -0.5), "wrong: mix"),
    "mix of scaled joints": ("planar", _set("mix", 2, 2, 2.0), "wrong: diagonal"),
    "mix of later joints": ("planar", _set("mix", 0, 1, 1.0), "wrong: mix"),
    "mix of unlike joints": ("gantry", _set("mix", 2, 1, 1.0), "wrong: mix"),
    "root": ("planar", _set("root", "upper", [1.0, 1.59, 2.8]), "does not cover J2"),
    "witness": ("planar", _set("witnesses", 0, 0, 1.2), "missing or infeasible"),
    "no witness": ("planar", _set("witnesses", []), "not verified"),
    "format": ("planar", _set("format", "elastocal-proof 2"), "wrong: format"),
    "not yet proved": ("planar", _set("largest", None), "not verified"),
    "cone": ("planar", _set("load", "kind", "cone"), "not verified"),
    "size": ("gantry", _set("load", "size", 2.6), "not verified"),
    "slide": ("gantry", _set("joints", 0, "upper", 0.6), "does not cover X"),
    "held as flat": ("gantry", lambda raw: _hold(raw, 0, "flat"), "variable 0 is not flat"),
    "held as base": ("gantry", lambda raw: _hold(raw, 2, "base"), "frees variable 2"),
    "no longer held": ("tower", _set("held", [{"variable": 0, "because": "base"}]), "cover A5"),
    "held for another reason": ("tower", _set("held", 0, "because", "flat"), "not verified"),
    "held otherwise": ("tower", lambda raw: _hold(raw, 1, "flat"), "variable 1 is not flat"),
    "spring of the foot": ("tower", _foot, "frees variable 0"),
    "slanted load": ("tower", _set("load", "force", [0.5, 0.0, -2.0]), "frees variable 0"),
    "moment": ("tower", _set("load", "moment", [0.5, 0.0, 0.0]), "frees variable 0"),
    "wall": ("tower", lambda raw: raw["constraints"].append(WALL), "frees variable 0"),
    "marker beside the plane": ("tower", _set("markers", 0, [1.5, 0.1, 0.8]), "not verified"),
    "marker beside the axis": ("tower", _set("markers", 0, [1.5, 0.0, 0.7]), "not verified"),
    "uneven limits": ("tower", _set("joints", 3, "lower", -2.9), "frees variable 3"),
    "signs": ("tower", _set("halved", 0, "signs", [1, 1, -1, -1, 1]), "frees variable 3"),
    "shifts": ("tower", _set("halved", 0, "shifts", [0, 0, 0, 3.1, 0]), "not verified"),
    "no half": ("tower", _set("halved", []), "does not cover A4"),
    "less than a half": ("tower", _set("root", "lower", [0.0, -0.9, -0.8, 0.1, 0.0]), "cover A4"),
}  # fmt: skip


def _hold(raw: Raw, i: int, why: str) -> None:
    raw["held"].append({"variable": i, "because": why})
    for end in ("lower", "upper"):
        raw["root"][end][i] = 0.1


@pytest.mark.parametrize("what", CHANGES)
def test_a_changed_statement_is_refused(
    what: str, proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path
) -> None:
    name, change, said = CHANGES[what]
    raw, tree = copy.deepcopy(proofs[name][0]), proofs[name][1]
    change(raw)
    verdict = check(write(tmp_path / "a.proof", raw, tree))
    assert not verdict.verified
    assert said in verdict.message
    assert verdict.message.isprintable()
    assert "Traceback" not in verdict.message


def test_tables_of_the_core_do_not_matter(
    proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path
) -> None:
    raw, tree = proofs["planar"]
    changed = raw | {"tables": {"points": [5, 6, 7]}, "left_out": ["a wall"]}
    assert check(write(tmp_path / "a.proof", changed, tree)).verified


def test_a_changed_tree_is_refused(proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path) -> None:
    raw, tree = proofs["tower"]
    leaf = tree.index(255)
    for changed, said in (
        (tree[:-1], "the tree ends, but 1 boxes are missing"),
        (tree[: len(tree) // 2], "are missing"),
        (tree + b"\xff", f"symbol {len(tree)} and what follows are left over"),
        (b"\xff" + tree[1:], "symbol 1 and what follows are left over"),
        (tree[:leaf] + b"\x01" + tree[leaf + 1 :], "boxes are missing"),
        (b"\x00" + tree[1:], "symbol 0 halves no variable"),  # held
        (b"\x05" + tree[1:], "symbol 0 halves no variable"),  # not there
        (tree[:leaf] + b"\xfe" + tree[leaf + 1 :], f"symbol {leaf} halves no variable"),
        (b"", "boxes are missing"),
    ):
        verdict = check(write(tmp_path / "a.proof", raw, changed))
        assert not verdict.verified
        assert said in verdict.message


def test_large_leaves_are_not_believed(
    proofs: dict[str, tuple[Raw, bytes]], tmp_path: Path
) -> None:
    """A tight U, and one leaf for all: the bound of the checker itself must fail."""
    raw, _ = proofs["planar"]
    tight = raw | {"largest": raw["largest"] / 1.1 * (1.0 + 1e-6)}
    verdict = check(write(tmp_path / "a.proof", tight, b"\xff"))
    assert not verdict.verified
    assert "symbol 0: no bound of d by U in" in verdict.message


def test_files_of_another_kind(tmp_path: Path) -> None:
    path = tmp_path / "a.proof"
    assert "FileNotFoundError" in check(path).message
    path.write_bytes(b"PK not at all")
    assert not check(path).verified
    statements = (b"[1, 2]", b"{", b"{}", b"1", b"\xff")
    kinds = [{"tree": b"\xff", "statement.json": statement} for statement in statements]
    for entries in ({}, {"tree": b"\xff"}, *kinds):
        with zipfile.ZipFile(path, "w") as file:
            for name, content in entries.items():
                file.writestr(name, content)
        verdict = check(path)
        assert not verdict.verified
        assert verdict.message.startswith("not verified: ")
        assert verdict.message.count("\n") == 0


@pytest.mark.parametrize("name", ["planar", "gantry", "tower"])
def test_functions_by_other_means(name: str) -> None:
    """Products of 4 x 4 matrices against cross products; expansions, and all that is held."""
    raw = getattr(slow_proof, name)()
    raw |= {"largest": 1.0, "rho0": 0.0, "witnesses": []}
    s = check_proof.read(json.dumps(raw).encode())
    x = slow_proof.chance(raw, np.random.default_rng(0), 50)
    W, g, *_ = check_proof.functions(s, x)
    other, margins = slow_proof.rows(raw, x)
    d = np.linalg.eigvalsh(np.einsum("nirf,nirg->nfg", W, W))[:, -1]
    assert d == pytest.approx(slow_proof.largest(other), rel=1e-12)
    count = len(raw["constraints"])
    assert g[:, 1 : count + 1] == pytest.approx(margins[:, :count], abs=1e-12)
    within = (margins[:, count:] >= 0.0).reshape(50, -1, 2).all(axis=2)
    assert ((g[:, count + 1 :] >= 0.0) == within).all()
    p = check_proof.pose(s)
    E = check_proof.expansions(p.axes, p.C, x[:, p.active])[:, 0]
    scaled = E[:, : p.v] / np.linalg.norm(E[:, : p.v], axis=1)[:, None]
    direct = W.reshape(50, -1) / np.linalg.norm(W.reshape(50, -1), axis=1)[:, None]
    assert np.abs(scaled - direct).max() < 1e-12


def test_leaves_fill_the_root(proofs: dict[str, tuple[Raw, bytes]]) -> None:
    """Volumes add up to that of the root exactly, and every point is in a leaf."""
    tree = proofs["planar"][1]
    blocks = list(check_proof.walk(tree, 3, [0, 1, 2]))
    paths = np.concatenate(blocks)[:, 1:]
    volumes = [Fraction(1, np.prod([1 << (int(p).bit_length() - 1) for p in row])) for row in paths]
    assert sum(volumes) == 1
    level = np.frexp(paths)[1] - 1
    low, width = np.ldexp(paths.astype(float), -level) - 1.0, np.ldexp(1.0, -level)
    for u in np.random.default_rng(0).random((500, 3)):
        assert ((low <= u) & (u <= low + width)).all(axis=1).any()


# Inequalities, each with its tightness, of the module or of a mutant of it.


def _posed(
    m: Any, rng: Any, n: int, v: int = 2, F: int = 1, K: int = 1, slides: bool = False
) -> SimpleNamespace:
    """Functions by chance, as bounds of boxes take them: W (v, F), and K constraints."""
    axes = [(not (slides and i == 0), 0.1, 0.9, 2) for i in range(n)]
    C = rng.normal(size=(*(5 if turns else 3 for turns, *_ in axes), v * F + K))
    words = {word: k for k, word in enumerate(m._words(n, 2))}
    pairs = [[words[min(i, j), max(i, j)] for j in range(n)] for i in range(n)]
    p = SimpleNamespace(axes=axes, C=C, v=v * F, F=F, active=list(range(n)), U=1.0)
    p.pairs, p.slack, p.third = np.array(pairs), np.zeros(1 + K), m.suprema(axes, C, v * F)
    p.mix, p.limits = np.zeros((0, n)), np.zeros((2, 0))
    return p


def _values(m: Any, p: SimpleNamespace, x: Array) -> tuple[Array, Array]:
    """(N, v, F) W and (N, K) constraints at x (N, n)."""
    E = m.expansions(p.axes, p.C, x)[:, 0]
    return E[:, : p.v].reshape(len(x), -1, p.F), E[:, p.v :]


def _d(W: Array) -> Array:
    return np.asarray(np.linalg.eigvalsh(np.swapaxes(W, 1, 2) @ W)[:, -1])


def _shares(n: int, count: int) -> Array:
    """(N, n) points of [-1, 1]^n, with the corners."""
    grid = np.meshgrid(*[np.linspace(-1.0, 1.0, count)] * n)
    return np.stack([part.ravel() for part in grid], axis=1)


def _forms(m: Any, p: SimpleNamespace, c: Array, r: Array) -> list[Array]:
    """T, c, b, rest, f, a, H of a box, as it is first bounded."""
    seen: list[Any] = []
    excess = m.excess
    m.excess = lambda *forms: (seen.append(forms), excess(*forms))[1]
    try:
        m.examine(p, c[None], r[None])
    finally:
        m.excess = excess
    return [np.asarray(part[0]) for part in seen[0]]


def _expanded(m: Any, p: SimpleNamespace, c: Array, r: Array, h: Array) -> Array:
    """(N, values) Taylor polynomial of order 2 at shares h (N, n) of half-widths."""
    E = m.expansions(p.axes, p.C, c[None])[0]
    words = m._words(len(c), 0, 1, 2)
    return np.asarray(sum(np.prod((r * h)[:, list(w)], axis=1)[:, None] * E[k]
                          for k, w in enumerate(words)))  # fmt: skip


def derivatives(m: Any) -> None:
    """Expansions against differences of values."""
    rng = np.random.default_rng(1)
    for slides in (False, True):
        p = _posed(m, rng, 3, slides=slides)
        x, step = rng.uniform(-0.5, 0.7, (20, 3)), 1e-3
        E, words = m.expansions(p.axes, p.C, x), m._words(3, 0, 1, 2)
        for i in range(3):
            shift = step * np.eye(3)[i]
            up, down = (m.expansions(p.axes, p.C, x + sign * shift) for sign in (1, -1))
            for j in (None, *range(i, 3)):
                before = 0 if j is None else words.index((j,))
                slope = (up[:, before] - down[:, before]) / (2.0 * step)
                scale = 2.0 if j == i else 1.0
                word = (i,) if j is None else (i, j)
                found = scale * E[:, words.index(word)]
                assert np.abs(found - slope).max() < 1e-4 * np.abs(E).max()


def tables(m: Any) -> None:
    """Suprema of third derivatives: peaks between the nodes, and polynomials by chance."""
    budget, m.BUDGET = m.BUDGET, 1.0
    try:
        for phase in np.linspace(0.0, 1.0, 7):
            C = np.zeros((5, 2))
            C[2], C[4] = np.cos(phase), np.sin(phase)
            third = m.suprema([(True, 0.0, 1.0, 2)], C, 1)
            assert (third >= 8.0 / 6.0 - 1e-12).all()
            assert (third < 4.0).all()
        # a cubic is what remains of a quintic that slides
        third = m.suprema([(False, 0.0, 2.0, 4)], np.array([0.0, 0.0, 0.0, 0.0, 1.0])[:, None], 1)
        assert 0.5 - 1e-12 <= third[0, 0] < 1.0
    finally:
        m.BUDGET = budget
    rng = np.random.default_rng(2)
    p = _posed(m, rng, 2, slides=True)
    p.third = m.suprema(p.axes, p.C, 2)
    x = np.stack([0.1 + 0.9 * _shares(2, 81)[:, 0], 3.2 * _shares(2, 81)[:, 1]], axis=1)
    for k, word in enumerate(m._words(2, 3)):
        B = [m._basis(axis, x[:, i], word.count(i)) for i, axis in enumerate(p.axes)]
        values = np.abs(np.einsum("ni,nj,ijv->nv", *B, p.C))
        peaks = np.array([np.linalg.norm(values[:, :2], axis=1).max(), values[:, 2].max()])
        assert (peaks <= p.third[k] * (1.0 + 1e-9)).all()
        assert (peaks >= 0.2 * p.third[k]).all()


def remainders(m: Any) -> None:
    """|W(c + h)| ≤ |P(h)| + R, and |P|² ≤ f + a·h + h'Hh/2, the second without room to spare."""
    rng = np.random.default_rng(3)
    ratio, gap = 0.0, 0.0
    for _ in range(60):
        n = int(rng.integers(1, 3))
        p = _posed(m, rng, n, v=1 if n == 1 else 2, slides=bool(rng.integers(2)) and n == 2)
        p.U, h = 1e8, _shares(n, 11)
        c, r = rng.uniform(-0.6, 0.8, n), rng.uniform(0.02, 1.0, n)
        T, _, _, _, f, a, H = _forms(m, p, c, r)
        W, _ = _values(m, p, c + r * h)
        P = _expanded(m, p, c, r, h)[:, : p.v]
        R = 1e4 - np.sqrt(T)
        over = np.linalg.norm(W[:, :, 0], axis=1) - np.linalg.norm(P, axis=1)
        assert (over <= R + 1e-9).all()
        ratio = max(ratio, over.max() / R)
        square, bound = (P**2).sum(axis=1), f + h @ a + np.einsum("ni,ij,nj->n", h, H, h) / 2.0
        assert (square <= bound * (1.0 + 1e-12)).all()
        if n == 1:  # |P|² and its bound meet at one of the ends
            assert square[[0, -1]] - bound[[0, -1]] == pytest.approx(0.0, abs=4.0 * f)
            gap = max(gap, float(np.abs(square - bound)[[0, -1]].min() / bound.max()))
    assert ratio > 0.2
    assert gap < 1e-12


def maxima(m: Any) -> None:
    """The separable bound of a quadratic function over a box, against a dense grid."""
    rng = np.random.default_rng(4)
    ratios = []
    for n in (1, 2, 3):
        h = _shares(n, (401, 21, 9)[n - 1])
        slope = rng.normal(size=(600, n)) * rng.choice([0.0, 0.1, 1.0, 4.0], (600, 1))
        bend = rng.normal(size=(600, n, n)) * rng.choice([0.1, 1.0, 5.0], (600, 1, 1))
        bend = bend + np.swapaxes(bend, 1, 2)
        bend[:200] *= np.eye(n)
        found = m.box_maximum(slope, bend)
        dense = (slope @ h.T + np.einsum("pi,nij,pj->np", h, bend, h) / 2.0).max(axis=1)
        size = np.abs(slope).sum(axis=1) + np.abs(bend).sum(axis=(1, 2))
        assert (found >= dense - 1e-12 * size).all()
        assert ((found - dense)[:200] <= 0.03 * size[:200]).all()
        ratios.append((found - dense) / size)
    assert np.mean(ratios) < 0.1


def feasible(m: Any) -> None:
    """No U below the largest d of the feasible points of a box is ever proved there."""
    rng = np.random.default_rng(5)
    proved = []
    for F, n, count in ((1, 1, 80), (1, 2, 30), (2, 1, 40), (3, 1, 20)):
        h = _shares(n, 401 if n == 1 else 41)
        for _ in range(count):
            p = _posed(m, rng, n, v=2 if F == 1 else 3, F=F)
            c, r = rng.uniform(-1.0, 1.0, n), rng.uniform(0.05, 0.9, n)
            x = c + r * h
            W, g = _values(m, p, x)
            # the border goes through the box: at some share of its values
            p.C[(0,) * n][-1] -= np.quantile(g[:, 0], rng.uniform(0.05, 1.0))
            W, g = _values(m, p, x)
            d = _d(W)[g[:, 0] >= 0.0].max()
            p.U = 0.9999 * d
            assert not m.examine(p, c[None], r[None])[0][0]
            p.U = 1.6 * d
            proved.append(bool(m.examine(p, c[None], 0.3 * r[None])[0][0]))
    assert np.mean(proved) > 0.5


def empties(m: Any) -> None:
    """A box is thrown out if nothing of it is feasible, never for a border that grazes it."""
    rng = np.random.default_rng(6)
    thrown = []
    for _ in range(60):
        n = int(rng.integers(1, 3))
        p, h = _posed(m, rng, n), _shares(n, 201 if n == 1 else 41)
        c, r = rng.uniform(-1.0, 1.0, n), rng.uniform(0.05, 0.9, n)
        p.U, top = 1e-12, _values(m, p, c + r * h)[1].max()
        p.C[(0,) * n][-1] -= top - 1e-6
        assert not m.examine(p, c[None], r[None])[0][0]
        p.C[(0,) * n][-1] -= 0.5
        thrown.append(bool(m.examine(p, c[None], 0.2 * r[None])[0][0]))
    assert np.mean(thrown) > 0.5


def directions(m: Any) -> None:
    """Of free forces: the first column is exact, the other ones and what mixes them are bounded."""
    rng = np.random.default_rng(7)
    tight = np.zeros(2)
    for F in (2, 3):
        for _ in range(60):
            n = int(rng.integers(1, 3))
            p, h = _posed(m, rng, n, v=4, F=F), _shares(n, 9)
            p.U = 1e8
            c, r = rng.uniform(-1.0, 1.0, n), rng.uniform(0.02, 0.3, n)
            _, largest, b, rest, *_ = _forms(m, p, c, r)
            P = _expanded(m, p, c, r, h)[:, : p.v].reshape(len(h), -1, F)
            _, Q = np.linalg.eigh(P[len(h) // 2].T @ P[len(h) // 2])
            P = P @ Q[:, ::-1]
            forms = np.swapaxes(P, 1, 2) @ P
            others = np.linalg.eigvalsh(forms[:, 1:, 1:])[:, -1]
            assert (others <= largest * (1.0 + 1e-12)).all()
            mixed = (forms[:, 0, 1:] ** 2).sum(axis=1) - ((h @ b.T) ** 2).sum(axis=1)
            assert (mixed <= rest + 1e-12).all()
            start = others[len(h) // 2]
            grown = (others.max() - start) / (largest - start)
            tight = np.maximum(tight, [grown, mixed.max() / rest])
    assert (tight > 0.2).all()


def borders(m: Any) -> None:
    """Multipliers know that a border may be beyond where its expansion has it.

    W is linear in what slides, so that only the constraint, a cubic, has a remainder.
    """
    rng = np.random.default_rng(10)
    h = _shares(1, 2001)
    for _ in range(40):
        C = np.zeros((4, 3))
        C[0, :2], C[1, :2] = rng.uniform(0.7, 1.0, 2), rng.uniform(0.01, 0.02, 2)
        C[:, 2] = rng.uniform(0.3, 0.4), -1.0, 0.0, rng.uniform(0.3, 0.6)
        p = _posed(m, rng, 1)
        p.axes, p.C = [(False, 0.0, 1.0, 3)], C
        p.third = m.suprema(p.axes, C, 2)
        W, g = _values(m, p, 0.5 * h)
        d = _d(W)[g[:, 0] >= 0.0].max()
        p.U = 0.9999 * d
        assert not m.examine(p, np.zeros((1, 1)), np.full((1, 1), 0.5))[0][0]
        p.U = 1.01 * d
        assert m.examine(p, np.zeros((1, 1)), np.full((1, 1), 0.5))[0][0]


def limits(m: Any) -> None:
    """A box is beyond the limits of a sum only if all of it is."""
    p = _posed(m, np.random.default_rng(11), 2)
    p.U, p.mix, p.limits = 1e-9, np.array([[-1.0, 1.0]]), np.array([[-0.5], [0.7]])
    p.C[..., -1] = 0.0
    r = np.array([[0.1, 0.2]])
    for inside, sum_ in ((True, 0.99), (False, 1.01), (True, -0.79), (False, -0.81)):
        assert m.examine(p, np.array([[0.0, sum_]]), r)[0][0] != inside


def coarse(m: Any) -> None:
    """Where the remainder alone is above √U nothing is proved."""
    rng = np.random.default_rng(8)
    for _ in range(20):
        p = _posed(m, rng, 2)
        p.C[...] *= 1e-3
        p.C[1, 1, 0] = p.C[2, 2, 0] = 3.0
        p.C[..., -1] = 0.0
        p.C[0, 0, -1] = 1.0
        p.third = m.suprema(p.axes, p.C, p.v)
        c, r = np.full(2, np.pi / 4), np.full(2, 3.0)
        p.U = 0.9 * _d(_values(m, p, c + r * _shares(2, 61))[0]).max()
        assert not m.examine(p, c[None], r[None])[0][0]


def margins(m: Any) -> None:
    """What rounding may have changed is taken off √U and added to constraints."""
    p = _posed(m, np.random.default_rng(9), 1)
    p.U, c, r = 1e4, np.zeros(1), np.full(1, 0.1)
    T = _forms(m, p, c, r)[0]
    p.slack = np.array([0.5, 0.0])
    assert np.sqrt(T) - np.sqrt(_forms(m, p, c, r)[0]) == pytest.approx(0.5)
    p.U, p.slack = 1e-9, np.array([0.0, 1e3])
    p.C[0, -1] -= 100.0
    assert not m.examine(p, c[None], r[None])[0][0]


def halving(m: Any) -> None:
    """Halves leave no gap: a narrow peak anywhere keeps a box open."""
    for peak in np.linspace(-3.0, 3.0, 25):
        C = np.zeros((41, 2))
        k = np.arange(1, 21)
        C[0, 0], C[1:21, 0], C[21:, 0] = 0.5, np.cos(k * peak), np.sin(k * peak)
        p = SimpleNamespace(axes=[(True, 0.0, 1.0, 20)], C=C, v=1, F=1, active=[0])
        p.pairs, p.slack, p.third = np.zeros((1, 1), int), np.zeros(2), m.suprema(p.axes, C, 1)
        p.mix, p.limits, p.U = np.zeros((0, 1)), np.zeros((2, 0)), (0.99 * 20.5) ** 2
        assert len(m.settle(p, np.zeros((1, 1)), np.full((1, 1), np.pi)))
        p.U = (1.05 * 20.5) ** 2
        assert not len(m.settle(p, np.full((1, 1), peak), np.full((1, 1), 0.05)))


INEQUALITIES = (
    derivatives, tables, remainders, maxima, feasible, empties, directions, borders, limits, coarse,
    margins, halving,
)  # fmt: skip


@pytest.mark.parametrize("inequality", INEQUALITIES, ids=lambda one: one.__name__)
def test_inequality(inequality: Callable[[Any], None]) -> None:
    inequality(check_proof)


MUTANTS: dict[str, tuple[Callable[[Any], None], str, str]] = {
    "sampling factor forgotten": (tables, " / math.prod(cosines)", ""),
    "remainder zero": (remainders, "_powers(h, 3) @ p.third", "_powers(h, 3) @ (0.0 * p.third)"),
    "cubic terms dropped": (remainders, "2.0 * abs(G[:, one, two]).sum(axis=both)", "0.0"),
    "quartic terms dropped": (remainders, " + abs(G[:, two, two]).sum(axis=both)", ""),
    "mixed terms dropped": (maxima, "own - abs(own) + abs(bend).sum(axis=-1)", "own"),
    "convex terms dropped": (maxima, "own * h**2", "np.minimum(own, 0.0) * h**2"),
    "ends of the box left out": (maxima, "size + 1e-300), 1.0)", "size + 1e-300), 0.5)"),
    "squares halved": (remainders, "two][:, p.pairs] * twice\n", "two][:, p.pairs]\n"),
    "multipliers of any sign": (feasible, "* a[on, k] < 0.0", "* a[on, k] != 0.0"),
    "remainder of borders dropped": (borders, "(g + rest)[on, k]", "g[on, k]"),
    "remainder of empties dropped": (empties, "box_maximum(a, H) + rest <", "box_maximum(a, H) <"),
    "limits without room": (limits, "(q - reach > p.limits[1])", "(q > p.limits[1])"),
    "mixing of directions dropped": (directions, "* size + size**2)", "* 0.0)"),
    "spread of others dropped": (directions, "others.sum(axis=(1, 3)) - others", "0.0 * others"),
    "first direction alone": (feasible, "H = H + 2.0 * np.einsum", "H = H + 0.0 * np.einsum"),
    "remainder above U": (coarse, "size * abs(size)", "size * size"),
    "gaps between halves": (halving, "np.tile(r[left] - shift,", "np.tile(r[left] - 1.2 * shift,"),
    "factorial forgotten": (derivatives, "k**order / math.factorial(order)", "k**order"),
    "rounding forgotten": (margins, "@ p.third + p.slack", "@ p.third + 0.0 * p.slack"),
}  # fmt: skip


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mutant_is_noticed(name: str) -> None:
    """Every term that is dropped or weakened breaks an inequality."""
    inequality, old, new = MUTANTS[name]
    source = SOURCE.read_text("utf-8")
    assert source.count(old) == 1
    mutant: Any = types.ModuleType("mutant")
    exec(compile(source.replace(old, new), "mutant", "exec", dont_inherit=True), mutant.__dict__)
    with pytest.raises(AssertionError):
        inequality(mutant)
