"""Faults put into the bounds of boxes: the tests must fail with each of them.

Every mutant is a copy of the package with one text replaced, its core compiled anew for one level.
`make test-full` tries them all; one by one:

    ELASTOCAL_FULL=1 python -m pytest tests/proof/test_mutants.py -k cone
"""

from __future__ import annotations

import atexit
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest

import hatch_build

ROOT = Path(__file__).resolve().parents[2]
BOUNDS, FREE, EXPANSION, TREES = (
    f"core/source/{name}.h" for name in ("box_bounds", "free_loads", "expansion", "subtrees")
)


@dataclass(frozen=True)
class Mutant:
    """One fault: what stands in a file instead of what, and the test that fails with it."""

    name: str
    file: str
    before: str
    after: str
    test: str
    tests: str = "test_box_bounds"
    also: tuple[str, str] = ("", "")


FORMULA = "formula_says"
MUTANTS = (
    # The eleven that obvious tests let pass.
    Mutant(
        "third order zero",
        BOUNDS,
        "lanes third = third_order(n, s->third, r, cubic);",
        "lanes third = 0.0 * third_order(n, s->third, r, cubic);",
        "third_order",
    ),
    Mutant(
        "third order x .3",
        BOUNDS,
        "lanes third = third_order(n, s->third, r, cubic);",
        "lanes third = 0.3 * third_order(n, s->third, r, cubic);",
        "third_order",
    ),
    Mutant(
        "third order x .67",
        BOUNDS,
        "lanes third = third_order(n, s->third, r, cubic);",
        "lanes third = 0.67 * third_order(n, s->third, r, cubic);",
        "third_order",
    ),
    Mutant(
        "2 b1 b2 dropped",
        BOUNDS,
        "lanes over = 2.0 * b1 * b2 + b2 * b2;",
        "lanes over = b2 * b2;",
        "second_order_alone",
    ),
    Mutant(
        "b2² dropped",
        BOUNDS,
        "lanes over = 2.0 * b1 * b2 + b2 * b2;",
        "lanes over = 2.0 * b1 * b2;",
        "second_order_alone",
    ),
    Mutant(
        "no rest in multipliers",
        BOUNDS,
        "tried.level = o->level + m * (g->at + rest[c]);",
        "tried.level = o->level + m * g->at;",
        "take_the_rest_along",
    ),
    Mutant(
        "no rest of what is empty",
        BOUNDS,
        "largest_of_scalar(n, g, rest[c], r, inverse) < 0.0;",
        "largest_of_scalar(n, g, every(0.0), r, inverse) < 0.0;",
        "keeps_boxes_from_being",
    ),
    Mutant(
        "vertex outside",
        BOUNDS,
        "(bend < 0.0) & (size < -bend * r);",
        "bend < 0.0;",
        "largest_of_a_quadratic",
    ),
    Mutant(
        "mixed terms halved",
        BOUNDS,
        "pair_of(i, j) : pair_of(j, i)]) * r[j];",
        "pair_of(i, j) : pair_of(j, i)]) * (0.5 * r[j]);",
        "largest_of_a_quadratic",
    ),
    Mutant(
        "sums, second derivative",
        EXPANSION,
        "to[k] += a * b * from[k];",
        "to[k] -= a * b * from[k];",
        FORMULA,
    ),
    Mutant(
        "multiplier negative",
        BOUNDS,
        "usable &= m > 0.0;",
        "usable &= m != 0.0;",
        "multipliers_of",
        also=("if (!any(m > 0.0)) continue;", ""),
    ),
    # Tables.
    Mutant(
        "no factor of sampling",
        "proof/trigonometric.py",
        "return float(1.0 / np.cos(np.pi * degree / count))",
        "return 1.0",
        "factor_is_needed or sharpest",
        "test_trigonometric",
    ),
    Mutant(
        "no factor of Chebyshev",
        "proof/trigonometric.py",
        "return float(1.0 / np.cos(np.pi * max(degree - order, 0) / (2.0 * count)))",
        "return 1.0",
        "what_slides",
        "test_trigonometric",
    ),
    Mutant(
        "third order, i < j < k",
        BOUNDS,
        "(i == j ? 0.5 : 1.0) * row[k] * r[k]",
        "0.5 * row[k] * r[k]",
        FORMULA,
    ),
    Mutant(
        "third order, i < j = k",
        BOUNDS,
        "lanes inner = (i == j ? 1.0 / 6.0 : 0.5)",
        "lanes inner = (1.0 / 6.0)",
        FORMULA,
    ),
    Mutant(
        "tables of held variables",
        "proof/boxes.py",
        "return table[np.ix_(arm.variables, arm.variables, arm.variables)]",
        "return table[: len(arm.variables), : len(arm.variables), : len(arm.variables)]",
        "held",
    ),
    # Constraints.
    Mutant(
        "no third order of constraints",
        BOUNDS,
        "rest[count] = third_order(n, c->third, r, 0) + sizes;",
        "rest[count] = sizes;",
        "empty_is_what",
    ),
    Mutant(
        "empty from inside",
        BOUNDS,
        "found->empty |= largest_of_scalar",
        "found->empty |= ~(g->at >= 0.0) | largest_of_scalar",
        "empty_is_what",
    ),
    Mutant(
        "distance, bent",
        EXPANSION,
        "dot(normal, m.second[pair_of(i, j)]) + dot(bent, m.first[i]);",
        "dot(normal, m.second[pair_of(i, j)]);",
        "empty_is_what",
    ),
    Mutant(
        "limits of sums, sign",
        BOUNDS,
        "g->first[i - 1] = every(-sign * s->links[i]);",
        "g->first[i - 1] = every(sign * s->links[i]);",
        "multipliers_of_limits",
    ),
    Mutant(
        "upper limit for lower",
        BOUNDS,
        "const double sign = side ? -1.0 : 1.0;",
        "const double sign = 1.0;",
        "limits_of_sums",
    ),
    Mutant(
        "direction as point",
        "proof/boxes.py",
        "kind, point = 1, arm.turned(constraint.axis)",
        "kind, point = 0, arm.placed(constraint.axis)",
        "empty_is_what",
    ),
    Mutant(
        "room for constraints",
        "core/layout.py",
        "MOST_JOINTS, MOST_CONDITIONS = 12, 64",
        "MOST_JOINTS, MOST_CONDITIONS = 12, 99",
        "as_many",
    ),
    # Steady loads.
    Mutant(
        "b2, mixed",
        BOUNDS,
        "lanes part = root(product_of(both, both, width)) * r[i] * r[j] * (i == j ? 0.5 : 1.0);",
        "lanes part = root(product_of(both, both, width)) * r[i] * r[j] * 0.5;",
        "second_order_alone",
    ),
    Mutant(
        "slope halved",
        BOUNDS,
        "o->slope[j] = 2.0 * product_of(rows, by_j, width);",
        "o->slope[j] = product_of(rows, by_j, width);",
        FORMULA,
    ),
    Mutant(
        "no products of slopes",
        BOUNDS,
        "o->bend[pair_of(i, j)] = 2.0 * (across + product_of(rows, both, width));",
        "o->bend[pair_of(i, j)] = 2.0 * product_of(rows, both, width);",
        FORMULA,
    ),
    Mutant(
        "not a number is zero",
        BOUNDS,
        "root(larger(every(0.0), most + over));",
        "root(larger(most + over, every(0.0)));",
        "not_a_number",
    ),
    # Derivatives.
    Mutant(
        "sums, first derivative",
        EXPANSION,
        "first[i * width + k] -= s->links[i + 1]",
        "first[i * width + k] += s->links[i + 1]",
        FORMULA,
    ),
    Mutant(
        "later joint outermost",
        EXPANSION,
        "*to = s->slides[i] ? none() : cross(arm->axis[i], way->first[j]);",
        "*to = s->slides[j] ? none() : cross(arm->axis[j], way->first[i]);",
        FORMULA,
    ),
    Mutant(
        "later joint outermost, points",
        EXPANSION,
        "                                   : cross(arm->axis[j], minus(m->at, arm->origin[j]));"
        "\n        for (int64_t i = 0; i <= j; i++)\n            m->second[pair_of(i, j)] = "
        "s->slides[i] ? none() : cross(arm->axis[i], m->first[j]);",
        "                                   : cross(arm->axis[j], minus(m->at, arm->origin[j]));"
        "\n        for (int64_t i = 0; i <= j; i++)\n            m->second[pair_of(i, j)] = "
        "s->slides[j] ? none() : cross(arm->axis[j], m->first[i]);",
        FORMULA,
    ),
    Mutant(
        "slides turn",
        EXPANSION,
        "way->first[j] = s->slides[j] ? none() : cross(arm->axis[j], way->at);",
        "way->first[j] = cross(arm->axis[j], way->at);",
        FORMULA,
    ),
    Mutant("springs one body early", EXPANSION, "if (j < body)\n", "if (j <= body)\n", FORMULA),
    Mutant(
        "springs one body late, twice",
        EXPANSION,
        "            if (i < body)\n",
        "            if (i < body - 1)\n",
        FORMULA,
    ),
    Mutant(
        "product rule",
        EXPANSION,
        "plus(times(y->at[1 + j][f], v->first[i]),\n                                             "
        "   times(y->at[1 + i][f], v->first[j])));",
        "plus(times(y->at[1 + j][f], v->first[i]),\n                                             "
        "   times(y->at[1 + j][f], v->first[i])));",
        FORMULA,
    ),
    Mutant(
        "turning rows not weighed",
        EXPANSION,
        "const double weight = m < s->markers ? 1.0 : s->turning;",
        "const double weight = 1.0;",
        "values_at_centres",
    ),
    Mutant(
        "linear springs turn",
        EXPANSION,
        "axis_moved(s, arm, body, slides ? none() : axes[k], way);",
        "axis_moved(s, arm, body, axes[k], way);",
        "values_at_centres",
    ),
    Mutant(
        "moments dropped",
        EXPANSION,
        "if (!s->twisting || slides) continue;",
        "continue;",
        "values_at_centres",
    ),
    Mutant(
        "moments bend no spring",
        EXPANSION,
        "exerted[k].at[t][f] += dot(moment, *term_of(&along, n, t));",
        "exerted[k].at[t][f] += t ? every(0.0) : dot(moment, *term_of(&along, n, t));",
        FORMULA,
    ),
    Mutant(
        "load where the first marker is",
        EXPANSION,
        "if (m || m != s->loaded)",
        "if (m && m != s->loaded)",
        "values_at_centres",
    ),
    Mutant(
        "another marker's ways",
        EXPANSION,
        "if (m || m != s->loaded)",
        "if (m != s->loaded)",
        "values_at_centres",
    ),
    Mutant(
        "held joints at zero",
        "proof/folded.py",
        "value = float(s.mix[i] @ s.root[0])",
        "value = 0.0",
        "values_at_centres",
    ),
    Mutant(
        "noise",
        "proof/boxes.py",
        "memory.reals(arm.values / s.sigma)",
        "memory.reals(arm.values)",
        "values_at_centres",
    ),
    # Free loads.
    Mutant(
        "free: no third order",
        FREE,
        "lanes length = root(every(aim)) - third;",
        "lanes length = root(every(aim));",
        "third_order",
    ),
    Mutant(
        "free: 2 b1 b2 dropped",
        FREE,
        "const lanes over = 2.0 * b1 * b2 + b2 * b2;",
        "const lanes over = b2 * b2;",
        "second_order_alone",
    ),
    Mutant(
        "free: b2² dropped",
        FREE,
        "const lanes over = 2.0 * b1 * b2 + b2 * b2;",
        "const lanes over = 2.0 * b1 * b2;",
        "second_order_alone",
    ),
    Mutant(
        "free: mean for largest",
        FREE,
        "    return root(root(sum));",
        "    return root(root(sum / (double)k));",
        "second_order_alone",
    ),
    Mutant(
        "free: b2, mixed",
        FREE,
        "lanes part = root(at_least_largest(k, &own)) * r[i] * r[j] * (i == j ? 0.5 : 1.0);",
        "lanes part = root(at_least_largest(k, &own)) * r[i] * r[j] * 0.5;",
        "second_order_alone",
    ),
    Mutant("free: beyond dropped", FREE, "    o.level += beyond;\n", "", "inequality_of_schur"),
    Mutant(
        "free: beyond, product",
        FREE,
        "weight * (2.0 * aside1 * aside2 + aside2 * aside2);",
        "weight * (aside2 * aside2);",
        "inequality_of_schur",
    ),
    Mutant(
        "free: beyond, square",
        FREE,
        "weight * (2.0 * aside1 * aside2 + aside2 * aside2);",
        "weight * (2.0 * aside1 * aside2);",
        "inequality_of_schur",
    ),
    Mutant(
        "free: rest of the form, slope",
        FREE,
        "across += size_of(slope[i].at[at]) * r[i];",
        "across += 0.0 * r[i];",
        "inequality_of_schur",
    ),
    Mutant(
        "free: rest of the form, bend",
        FREE,
        "across += size_of(bend[pair_of(i, j)].at[at]) * r[i] * r[j] * (i == j ? 0.5 : 1.0);",
        "across += 0.0 * r[i];",
        "rest_of_the_form",
    ),
    Mutant(
        "free: rest of the form at the centre",
        FREE,
        "lanes own = zero.at[at] + largest_of_quadratic(n, g, h, r, inverse, 0);",
        "lanes own = zero.at[at];",
        "inequality_of_schur",
    ),
    Mutant(
        "free: b leans",
        FREE,
        "2.0 * weight * (slope[i].at[at] * slope[j].at[at] +",
        "2.0 * weight * (0.0 * slope[j].at[at] +",
        "inequality_of_schur",
    ),
    Mutant(
        "free: no products of slopes",
        FREE,
        "bend[at].at[c] += across.at[c];",
        "bend[at].at[c] += 0.0 * across.at[c];",
        "free_loads_to_second",
    ),
    Mutant(
        "free: once what is twice",
        FREE,
        "across.at[c] *= 2.0;",
        "across.at[c] *= 1.0;",
        "free_loads_to_second",
    ),
    Mutant(
        "free: T for Schur's other side",
        FREE,
        "possible & (most <= level)",
        "possible",
        "free_loads_are_bounded",
    ),
    Mutant(
        "cone: multiplier negative",
        FREE,
        "mask outside = cosine * cosine < edge;\n    if (!any(outside)) return low;\n    high = "
        "pick(outside, trace_of(3, a) / (1.0 - edge), every(0.0));",
        "mask outside = cosine * cosine >= 0.0;\n    high = trace_of(3, a) / (1.0 - edge);\n    "
        "low = pick(cosine * cosine < edge, low, -trace_of(3, a));",
        "cones_by_a_grid",
    ),
    Mutant(
        "cone: cosine not squared",
        FREE,
        "(i == j ? s->cone_cosine * s->cone_cosine : 0.0);",
        "(i == j ? s->cone_cosine : 0.0);",
        "cones_by_a_grid",
    ),
    Mutant(
        "cone: wide",
        "proof/boxes.py",
        "load if isinstance(load, InCone) and load.half_angle < np.pi / 2.0 else None",
        "load if isinstance(load, InCone) else None",
        "right_angle",
    ),
    # Searches.
    Mutant(
        "leaf without a bound",
        TREES,
        "if (found.bound[l] <= threshold) {",
        "if (found.value[l] <= threshold) {",
        "smallest_boxes",
    ),
    Mutant(
        "smallest boxes done",
        TREES,
        "tree.symbol[node[l]] = OPEN;",
        "tree.symbol[node[l]] = LEAF;",
        "smallest_boxes",
    ),
    Mutant(
        "smallest boxes not told",
        TREES,
        "if (!(found.bound[l] <= outcome->largest)) outcome->largest = found.bound[l];",
        "",
        "smallest_boxes",
    ),
    Mutant(
        "upper half forgotten",
        TREES,
        "to[k] += side ? box[n + k] : -box[n + k];",
        "to[k] -= box[n + k];",
        "trees_cover or smallest_boxes",
    ),
    Mutant(
        "boxes half as wide", TREES, "range * half[i] * WIDER", "range * half[i] * 0.5", FORMULA
    ),
    Mutant(
        "largest of the last leaf",
        TREES,
        "if (found.bound[l] > outcome->largest) outcome->largest = found.bound[l];",
        "outcome->largest = found.bound[l];",
        "smallest_boxes",
    ),
    Mutant(
        "lanes mixed up",
        TREES,
        "const double *box = own + (l < now ? l : now - 1) * wide;",
        "const double *box = own;",
        "trees_cover or smallest_boxes",
    ),
    Mutant(
        "pending boxes in another order",
        TREES,
        "stack + place[node] * wide,",
        "stack + left * wide,",
        "end_early",
    ),
    Mutant(
        "point in the other half",
        TREES,
        "if (point[k] <= center[k]) {",
        "if (point[k] >= center[k]) {",
        "trees_cover",
    ),
    Mutant(
        "all is empty",
        BOUNDS,
        "    found->inside = ~found->empty;\n",
        "    found->inside = ~found->empty;\n    found->empty = ~found->empty;\n",
        "trees_cover or values_at_centres",
    ),
    Mutant(
        "witnesses above the bound",
        "proof/prove.py",
        "if kinds[0] == OPEN or min(bounds[0], largest) < value * (1.0 - _AGREE):",
        "if kinds[0] == OPEN:",
        "witness",
    ),
    Mutant(
        "no witness",
        "proof/prove.py",
        "    if not held.any():\n",
        "    if False:\n",
        "witness",
    ),
    Mutant(
        "parts not counted",
        "proof/tree.py",
        "return max([tree.largest, *(proved(part) for part in tree.parts)])",
        "return tree.largest",
        "parts_that_are_not_proved",
    ),
    Mutant(
        "parts not searched",
        "proof/branching.py",
        "todo.extend(reversed(take(part, found)))",
        "take(part, found)",
        "parts_that_are_not_proved",
    ),
    Mutant(
        "what was known forgotten",
        "proof/tree.py",
        "_of(part.current) <= _of(part.settled)",
        "True",
        "parts_that_are_not_proved",
    ),
)
HARMLESS = {
    "kinds[0] == OPEN of witnesses": "the bound of an empty box alone is zero, so below any d",
    "slope of b times b": "b is zero at the centre, but for rounding, in the frame of eigenvectors",
    "is_finite(own)": "where one entry of the form is no number all bounds made of it are none",
    "WIDER": "boxes that overlap by 1e-12 only guard the rounding of halves, which are exact",
}

COMPILES = any(map(shutil.which, ("cc", "gcc", "clang"))) or "CC" in os.environ
full = pytest.mark.skipif(
    not os.environ.get("ELASTOCAL_FULL")
    or os.environ.get("ELASTOCAL_CORE") == "numpy"
    or not COMPILES,
    reason="ELASTOCAL_FULL is not set, or there is no compiler",
)


def test_what_mutants_replace_is_there() -> None:
    for mutant in MUTANTS:
        text = (ROOT / "src" / "elastocal" / mutant.file).read_text("utf-8")
        assert text.count(mutant.before) == 1, mutant.name
        assert mutant.also[0] in text, mutant.name
    tests = (Path(__file__).parent / "test_box_bounds.py").read_text("utf-8")
    names = " ".join(re.findall(r"def (test_\w+)", tests))
    for mutant in MUTANTS:
        if mutant.tests == "test_box_bounds":
            assert any(name in names for name in mutant.test.split(" or ")), mutant.name


@cache
def folder() -> Path:
    """What does not change: the objects of the baseline level but those of boxes.c."""
    made = Path(mkdtemp(prefix="mutants"))
    atexit.register(shutil.rmtree, made)
    compiler = [*hatch_build.found_compiler(), *hatch_build.FLAGS]
    source = ROOT / "src" / "elastocal" / "core" / "source"
    for unit in ("core", "machine"):
        hatch_build.run(
            [*compiler, "-O0", *hatch_build.BASELINE, "-c", str(source / f"{unit}.c"), "-o",
             str(made / f"{unit}.o")]
        )  # fmt: skip
    return made


def judged(mutant: Mutant, place: Path) -> subprocess.CompletedProcess[str]:
    """The tests, run with a mutant."""
    package = place / "elastocal"
    shutil.copytree(
        ROOT / "src" / "elastocal",
        package,
        ignore=shutil.ignore_patterns("libcore*", "__pycache__"),
    )
    file = package / mutant.file
    text = file.read_text("utf-8").replace(mutant.before, mutant.after)
    file.write_text(text.replace(*mutant.also) if mutant.also[0] else text, "utf-8")
    compiler = [*hatch_build.found_compiler(), *hatch_build.FLAGS]
    objects = [str(folder() / "core.o"), str(folder() / "machine.o"), str(place / "boxes.o")]
    source = package / "core" / "source" / "boxes.c"
    hatch_build.run([*compiler, "-O0", *hatch_build.BASELINE, "-c", str(source), "-o", objects[-1]])
    hatch_build.run(
        [*compiler, "-shared", *objects, "-lm", "-o", str(package / "core" / "libcore.so")]
    )
    environment = os.environ | {"PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    for name in ("ELASTOCAL_FULL", "ELASTOCAL_CORE", "PYTEST_XDIST_WORKER"):
        environment.pop(name, None)
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-k", mutant.test,
         f"tests/proof/{mutant.tests}.py"],
        cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip


@full
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_mutants_are_found(mutant: Mutant, tmp_path: Path) -> None:
    done = judged(mutant, tmp_path)
    shutil.rmtree(tmp_path)
    assert done.returncode == 1, done.stdout


@full
def test_without_a_mutant_the_tests_pass(tmp_path: Path) -> None:
    done = judged(Mutant("none", BOUNDS, "", "", "level or not level"), tmp_path)
    assert done.returncode == 0, done.stdout
