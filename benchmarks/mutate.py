"""Mutation: of so many small faults in the core, how many would the tests notice?

    python benchmarks/mutate.py                              200 mutants of the core, seed 0
    python benchmarks/mutate.py --seed 7 --count 60 design elastic/equilibrium.py
    python benchmarks/mutate.py --only 3,17 --tests tests/design

1. The tests run once under coverage with a context for each of them: which lines does each run,
   and how long does it take? That is kept in the folder of results and made again if absent.
2. Mutants are drawn with a seed, as many from every file, evenly over kinds, at most two on a line.
   No messages, no annotations, no docstrings.
3. Each is written into a copy of the package. A process forked from this one, which has imported
   all that is heavy but not the package, runs the tests that run its line until one fails: those
   of the mirror file first, then the cheapest, until the budget is spent.

What survives is in `survivors.txt` with its source: a hole in the tests, or an equivalent mutant.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "elastocal"
CORE = (
    "robot/chain.py", "robot/controller_axes.py", "robot/damped_steps.py",
    "robot/inverse_kinematics.py", "robot/pose_check.py", "robot/posture.py", "robot/rotations.py",
    "elastic", "measuring", "fitting", "identification", "compensation", "simulation",
    "design", "planning", "study", "constraints", "motion", "programs",
    "files/measurements", "matrices.py",
)  # fmt: skip
HEAVY = ("numpy", "scipy.optimize", "scipy.stats", "scipy.special", "hypothesis", "pinocchio",
         "yaml", "typer.testing", "rich.table", "jinja2")  # fmt: skip
SKIPPED = ("tests/report", "tests/viewer", "tests/test_docs.py", "tests/test_architecture.py",
           "tests/cli/test_interrupts.py", "tests/drawing", "tests/test_examples.py")  # fmt: skip

OPERATORS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.Mod: ast.Mult,
    ast.FloorDiv: ast.Mult,
}  # fmt: skip
NEGATED: dict[type, type] = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
SHIFTED: dict[type, type] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_ALIKE = "min max", "argmin argmax", "minimum maximum", "any all", "floor ceil", "lower upper"
PAIRS = {a: b for pair in _ALIKE for a, b in (pair.split(), pair.split()[::-1])}
DROPPED = {"abs", "sqrt", "clip", "sorted", "round", "square", "maximum", "minimum", "cumsum",
           "unique", "transpose", "ascontiguousarray"}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One small fault: the `index`-th change of a file, in source order."""

    number: int
    file: str
    line: int
    kind: str
    index: int
    before: str
    after: str


Change = tuple[str, ast.AST, Callable[[], None]]


def changes(tree: ast.AST) -> Iterator[Change]:
    """(kind, node, what makes the change in the tree) of every mutant of a module."""
    for parent in ast.walk(tree):
        for name, value in ast.iter_fields(parent):
            if _silent(parent, name):
                continue
            for at, node in enumerate(value) if isinstance(value, list) else [(-1, value)]:
                if isinstance(node, ast.AST) and hasattr(node, "lineno"):
                    put = _putter(parent, name, at)
                    for kind, made in _variants(node, parent):
                        yield kind, node, lambda put=put, made=made: put(made())


def _silent(parent: ast.AST, name: str) -> bool:
    """Annotations, decorators, messages and what is imported are left alone."""
    return (
        name in ("annotation", "returns", "decorator_list", "exc", "cause", "msg", "names", "bases")
        or isinstance(parent, ast.JoinedStr | ast.FormattedValue | ast.Import | ast.ImportFrom)
        or (isinstance(parent, ast.Call) and isinstance(parent.func, ast.Name)
            and parent.func.id.endswith(("Error", "Doubt")))
    )  # fmt: skip


def _putter(parent: ast.AST, name: str, at: int) -> Callable[[ast.AST], None]:
    def put(new: ast.AST) -> None:
        if at < 0:
            setattr(parent, name, new)
        else:
            getattr(parent, name)[at] = new

    return put


Variants = Iterator[tuple[str, Callable[[], ast.AST]]]


def _variants(node: ast.AST, parent: ast.AST) -> Variants:
    """Kinds of change of one node, and what makes the new node."""
    yield from _of_operations(node)
    yield from _of_values(node, parent)
    yield from _of_calls_and_statements(node)


def _of_operations(node: ast.AST) -> Variants:
    match node:
        case ast.BinOp(left=left, op=op, right=right):
            if type(op) in OPERATORS:
                yield "operator", lambda: ast.BinOp(left, OPERATORS[type(op)](), right)
            if isinstance(op, ast.Add | ast.Sub | ast.Mult | ast.Div):
                yield "dropped term", lambda: left
            if isinstance(op, ast.BitAnd | ast.BitOr):
                yield "dropped condition", lambda: left
            if isinstance(op, ast.Add | ast.Mult | ast.BitAnd):
                yield "dropped term", lambda: right
        case ast.UnaryOp(op=ast.USub() | ast.Not() | ast.Invert(), operand=operand):
            yield "sign", lambda: operand
        case ast.BoolOp(op=op, values=values):
            for k in range(len(values)):
                yield "dropped condition", lambda k=k: ast.BoolOp(op, values[:k] + values[k + 1 :])
            other = ast.Or() if isinstance(op, ast.And) else ast.And()
            yield "operator", lambda: ast.BoolOp(other, values)
        case ast.Compare(left=left, ops=[op, *rest], comparators=others):
            yield "comparison", lambda: ast.Compare(left, [NEGATED[type(op)](), *rest], others)
            whole = isinstance(others[0], ast.Constant) and isinstance(others[0].value, int)
            if whole and type(op) in SHIFTED:
                yield "comparison", lambda: ast.Compare(left, [SHIFTED[type(op)](), *rest], others)


def _of_values(node: ast.AST, parent: ast.AST) -> Variants:
    match node:
        case ast.Constant(value=bool() as value):
            yield "constant", lambda: ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            if isinstance(parent, ast.Subscript | ast.Slice | ast.Tuple) and value == int(value):
                yield "index", lambda: ast.Constant(int(value) + 1)
            elif isinstance(parent, ast.keyword) and parent.arg == "axis":
                yield "axis", lambda: ast.Constant(int(value) - 1 if value else 1)
            else:
                yield "constant", lambda: ast.Constant(2 * value if value else type(value)(1))
        case ast.Attribute(attr="T", value=value):
            yield "transpose", lambda: value
        case ast.Attribute(attr=name, value=value) if name in PAIRS:
            yield "min and max", lambda: ast.Attribute(value, PAIRS[name], ast.Load())
        case ast.Name(id=name) if name in PAIRS and isinstance(parent, ast.Call):
            yield "min and max", lambda: ast.Name(PAIRS[name], ast.Load())


def _of_calls_and_statements(node: ast.AST) -> Variants:
    match node:
        case ast.Call(func=func, args=args, keywords=keywords):
            name = getattr(func, "attr", getattr(func, "id", ""))
            if name in DROPPED and args:
                yield "dropped call", lambda: args[0]
            if len(args) == 2 and name not in PAIRS:
                yield "arguments", lambda: ast.Call(func, args[::-1], keywords)
            for k, keyword in enumerate(keywords):
                if keyword.arg not in (None, "strict", "dtype"):
                    left_over = keywords[:k] + keywords[k + 1 :]
                    yield "dropped keyword", lambda m=left_over: ast.Call(func, args, m)
        case ast.IfExp(test=test, body=body, orelse=orelse):
            yield "swapped branches", lambda: ast.IfExp(test, orelse, body)
        case ast.If(test=test, body=body, orelse=orelse) if "TYPE_CHECKING" not in ast.dump(test):
            if orelse:
                yield "swapped branches", lambda: ast.If(test, orelse, body)
            yield "forced condition", lambda: ast.If(ast.Constant(True), body, orelse)
            yield "forced condition", lambda: ast.If(ast.Constant(False), body, orelse)
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Break():
            yield "removed statement", ast.Pass
        case ast.Assign(targets=[ast.Subscript()]) | ast.Continue():
            yield "removed statement", ast.Pass


def mutated(text: str, index: int) -> str:
    """The module with its `index`-th change made."""
    tree = ast.parse(text)
    list(changes(tree))[index][2]()
    return ast.unparse(ast.fix_missing_locations(tree))


def drawn(files: list[Path], count: int, seed: int) -> list[Mutant]:
    """Mutants, as many from every file, evenly over kinds, at most two on a line."""
    rng = random.Random(seed)
    texts = {file: file.read_text("utf-8") for file in files}
    plain = {file: ast.unparse(ast.parse(text)).split("\n") for file, text in texts.items()}
    queues = {file: _queue(texts[file], rng) for file in files}
    chosen: list[Mutant] = []
    while len(chosen) < count and any(queues.values()):
        for file in rng.sample(files, len(files)):
            if not queues[file] or len(chosen) == count:
                continue
            index, kind, node = queues[file].pop()
            after = mutated(texts[file], index).split("\n")
            lines = zip(plain[file], after, strict=False)
            old, new = next(((a.strip(), b.strip()) for a, b in lines if a != b), ("", ""))
            if old != new:  # as they are where the same argument is given twice
                name = str(file.relative_to(PACKAGE))
                chosen.append(Mutant(len(chosen), name, node.lineno, kind, index, old, new))
    return chosen


def _queue(text: str, rng: random.Random) -> list[tuple[int, str, ast.AST]]:
    """Changes of a file, last first: kinds in turn, at most two on a line."""
    by_kind = defaultdict(list)
    for index, (kind, node, _) in enumerate(changes(ast.parse(text))):
        by_kind[kind].append((index, kind, node))
    for kind in by_kind.values():
        rng.shuffle(kind)
    order, lines = [], defaultdict(int)
    while any(by_kind.values()):
        for kind in rng.sample(sorted(by_kind), len(by_kind)):
            if by_kind[kind]:
                change = by_kind[kind].pop()
                lines[change[2].lineno] += 1
                if lines[change[2].lineno] <= 2:
                    order.append(change)
    return order[::-1]


class Map:
    """Which tests run a line, and how long each takes [s]."""

    def __init__(self, folder: Path) -> None:
        from coverage import CoverageData

        self.seconds = json.loads((folder / "seconds.json").read_text("utf-8"))
        self.data = CoverageData(str(folder / "coverage"))
        self.data.read()

    def tests(self, mutant: Mutant, budget: float) -> list[str]:
        """Tests that run its line, or its file where it runs on import, within the budget."""
        lines = self.data.contexts_by_lineno(str(PACKAGE / mutant.file))
        names = {c.split("|")[0] for c in lines.get(mutant.line, ())} - {""}
        if not names and "" in lines.get(mutant.line, ()):
            names = {c.split("|")[0] for contexts in lines.values() for c in contexts} - {""}
        mirror = f"tests/{Path(mutant.file).parent}/test_{Path(mutant.file).name}"

        def cost(name: str) -> tuple[float, str]:
            return self.seconds.get(name, 0.01) * (0.1 if name.startswith(mirror) else 1.0), name

        kept, spent = [], 0.0
        for name in sorted(names, key=cost):
            spent += self.seconds.get(name, 0.01)
            if kept and spent > budget:
                break
            kept.append(name)
        return kept


def measure(folder: Path, tests: list[str]) -> None:
    """One run of all tests under coverage."""
    command = [sys.executable, "-m", "pytest", *tests, "-q", "-m", "not slow and not full",
               "--cov=elastocal", "--cov-context=test", "--cov-report=", "--durations=0", "-vv",
               "--numprocesses=auto",
               *(f"--ignore={name}" for name in SKIPPED)]  # fmt: skip
    environment = os.environ | {"COVERAGE_FILE": str(folder / "coverage")}
    run = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    (folder / "measure.txt").write_text(run.stdout, "utf-8")
    seconds: dict[str, float] = defaultdict(float)
    for line in run.stdout.splitlines():
        if found := re.match(r"([\d.]+)s (?:call|setup) +(tests/.*?) *$", line):
            seconds[found[2]] += float(found[1])
    (folder / "seconds.json").write_text(json.dumps(seconds), "utf-8")


def verdict(mutant: Mutant, copy: Path, tests: list[str], limit: float, log: Path) -> str:
    """What the tests say of a mutant: killed, survived, time or no test."""
    if not tests:
        return "no test"
    target = copy / "elastocal" / mutant.file
    sound = target.read_text("utf-8")
    target.write_text(mutated(sound, mutant.index), "utf-8")
    child = os.fork()
    if not child:
        _tried(copy, tests, log)
    until = time.monotonic() + limit
    done, status = 0, 0
    while not done and time.monotonic() < until:
        time.sleep(0.02)
        done, status = os.waitpid(child, os.WNOHANG)
    if not done:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
    target.write_text(sound, "utf-8")
    return "time" if not done else "survived" if status == 0 else "killed"


def _tried(copy: Path, tests: list[str], log: Path) -> None:
    """Run tests in this process, which ends with their exit code."""
    import pytest

    os.setpgid(0, 0)
    stream = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    os.environ["PYTHONPATH"] = str(copy)
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(copy))
    os.chdir(ROOT)
    code = 1
    try:
        quiet = ["-q", "--tb=short", "-p", "no:cacheprovider"]
        early = ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # imported before the fork
        code = int(pytest.main([*tests, "-x", *quiet, *early]))
    finally:
        os._exit(code)


def main() -> None:
    """Draw, try, count."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("modules", nargs="*", default=CORE, help="folders or files of the package")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--budget", type=float, default=8.0, help="seconds of tests for each")
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "mutation")
    parser.add_argument("--only", help="numbers of mutants of this draw")
    parser.add_argument("--tests", nargs="*", help="run these and not those that run the line")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if not options.tests and not (options.out / "seconds.json").exists():
        print("running all tests under coverage", flush=True)
        measure(options.out, ["tests"])
    files = sorted(
        file
        for name in options.modules
        for file in (
            (PACKAGE / name).rglob("*.py") if (PACKAGE / name).is_dir() else [PACKAGE / name]
        )
        if file.name != "__init__.py"
    )
    mutants = drawn(files, options.count, options.seed)
    if options.only:
        wanted = {int(number) for number in options.only.split(",")}
        mutants = [mutant for mutant in mutants if mutant.number in wanted]
    for name in HEAVY:
        importlib.import_module(name)
    run(mutants, options)


def run(mutants: list[Mutant], options: argparse.Namespace) -> None:
    """Try every mutant; results as they come, survivors and a table by room at the end."""
    places = None if options.tests else Map(options.out)
    score: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        shutil.copytree(PACKAGE, copy / "elastocal", ignore=shutil.ignore_patterns("__pycache__"))
        with (options.out / f"seed{options.seed}.jsonl").open("a", encoding="utf-8") as results:
            for mutant in mutants:
                tests = options.tests or places.tests(mutant, options.budget)
                log = options.out / f"seed{options.seed}-{mutant.number}.log"
                start = time.monotonic()
                said = verdict(mutant, copy, tests, 30.0 + 8.0 * options.budget, log)
                taken = round(time.monotonic() - start, 1)
                entry = asdict(mutant) | {"verdict": said, "tests": len(tests), "seconds": taken}
                results.write(json.dumps(entry, ensure_ascii=False) + "\n")
                results.flush()
                alive = said in ("survived", "no test")
                room = score[mutant.file.split("/")[0]]
                room[0], room[1] = room[0] + (not alive), room[1] + 1
                if alive:
                    print(f"{mutant.number:4} {mutant.file}:{mutant.line} {mutant.kind} ({said})"
                          f"\n     {mutant.before}\n     {mutant.after}", flush=True)  # fmt: skip
    for name, (killed, tried) in sorted(score.items()):
        print(f"{name:20} {killed:4} of {tried:4} killed")
    killed, tried = (sum(part) for part in zip(*score.values(), strict=True))
    print(f"{'together':20} {killed:4} of {tried:4} killed, {100.0 * killed / tried:.0f} %")


if __name__ == "__main__":
    main()
