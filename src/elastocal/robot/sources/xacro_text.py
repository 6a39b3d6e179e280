"""xacro files: expanded to URDF by the package xacro, in a process of its own.

xacro is a programming language. It runs apart, with limits on time and memory, and what
it includes must lie in the folders that were named.
"""

from __future__ import annotations

import difflib
import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from elastocal.errors import InputError
from elastocal.robot.sources.urdf_tree import first_few

_SECONDS = 30.0
_SCRIPT = """
import json, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
except ImportError:
    pass  # no such limits on Windows
import builtins, os, stat
import xacro
from xacro import substitution_args
opened = open
def ordinary(file, *rest, **options):
    if not isinstance(file, int) and not stat.S_ISREG(os.stat(file).st_mode):
        raise OSError(22, "is not an ordinary file", file)
    return opened(file, *rest, **options)
builtins.open = ordinary
out, sys.stdout = sys.stdout, sys.stderr
path, packages, given = json.loads(sys.argv[1])
class Arguments(dict):
    asked, missing = set(), ""
    def __contains__(self, name):
        self.asked.add(name)
        return super().__contains__(name)
    def __getitem__(self, name):
        self.asked.add(name)
        return super().__getitem__(name)
    def __missing__(self, name):
        self.missing = name
        raise KeyError(name)
arguments = Arguments(given)
unknown = []
def find(name):
    if name not in packages:
        unknown.append(name)
        raise LookupError(name)
    return packages[name]
substitution_args._eval_find = find
answer = {}
try:
    document = xacro.process_file(path, mappings=arguments).documentElement
    files = [path, *xacro.all_includes]
    xml = [xacro.parse(None, file) for file in files if not file.endswith((".yaml", ".yml"))]
    macros = [node.getAttribute("name") for tree in xml
              for node in tree.getElementsByTagName("xacro:macro")]
    answer = {"text": document.toxml(), "includes": xacro.all_includes, "macros": macros,
              "links": len(document.getElementsByTagName("link"))}
except Exception as error:
    answer = {"error": str(error) or repr(error), "file": (xacro.filestack or [path])[-1]}
answer |= {"asked": sorted(arguments.asked), "missing": arguments.missing,
           "package": unknown[0] if "error" in answer and unknown else ""}
print(json.dumps(answer), file=out)
"""


def expanded(
    path: Path, packages: Mapping[str, Path], arguments: Mapping[str, str] | None = None
) -> bytes:
    """The URDF of a xacro file; it is the same wherever file and packages are.

    Args:
        path: The file.
        packages: Folders of packages by name, for $(find name).
        arguments: Its arguments by name, for $(arg name).

    Raises:
        InputError: xacro is not installed, the file is wrong or takes too long, an argument is
            missing or unknown, it includes a file from elsewhere, or gives no links.
    """
    if find_spec("xacro") is None:
        raise InputError(
            f"{path}: xacro files are expanded with the package xacro, which is not "
            "installed; pip install 'elastocal[xacro]', or expand the file yourself"
        )
    given = dict(arguments or {})
    folders = {name: str(folder.resolve()) for name, folder in packages.items()}
    task = json.dumps([str(path.resolve()), folders, given])
    command = [sys.executable, "-c", _SCRIPT, task]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: expanding it takes more than {_SECONDS:g} s") from None
    if done.returncode != 0:
        raise InputError(f"{path}: xacro cannot expand it: {_last_line(done.stderr)}")
    answer = json.loads(done.stdout)
    if answer["package"]:
        raise InputError(
            f"{path}: no folder is named for package {answer['package']!r}; give it beside 'urdf' "
            f"as packages: {{{answer['package']}: folder}}"
        )
    if answer["missing"]:
        raise InputError(_missing(path, answer["missing"]))
    if "error" in answer:
        inner = Path(answer["file"])
        where = "" if inner == path.resolve() else f" (in {inner.name})"
        reason = _first_line(answer["error"]).replace(f"{path.parent.resolve()}{os.sep}", "")
        raise InputError(f"{path}: xacro cannot expand it: {reason}{where}")
    _refuse_unknown(path, given, answer["asked"])
    allowed = [path.parent.resolve(), *(folder.resolve() for folder in packages.values())]
    for include in answer["includes"]:
        if not any(Path(include).resolve().is_relative_to(folder) for folder in allowed):
            raise InputError(
                f"{path}: it includes {include}, which is outside its folder and the packages named"
            )
    if not answer["links"] and answer["macros"]:
        raise InputError(
            f"{path}: it only defines macros ({first_few(answer['macros'])}) and calls none that "
            "gives links; name the file that calls them"
        )
    return _portable(str(answer["text"]), folders).encode()


def _missing(path: Path, name: str) -> str:
    return (
        f"{path}: xacro argument {name!r} has no value; give it beside 'urdf' as "
        f"arguments: {{{name}: …}}, or expand the file yourself: "
        f"xacro {path.name} {name}:=… > {path.stem}.urdf"
    )


def _refuse_unknown(path: Path, given: Mapping[str, str], asked: Sequence[str]) -> None:
    """Refuse arguments that the file never asks for: they would be misspelt and do nothing."""
    unknown = next((name for name in given if name not in asked), None)
    if unknown is None:
        return
    near = difflib.get_close_matches(unknown, asked, 1)
    if near:
        hint = f"did you mean {near[0]!r}?"
    else:
        hint = f"it has {first_few(asked)}" if asked else "it has none"
    raise InputError(f"{path}: there is no xacro argument {unknown!r}; {hint}")


def _portable(text: str, folders: Mapping[str, str]) -> str:
    """The text with the folders of packages as package://name: so its hash goes along with it."""
    for name, folder in sorted(folders.items(), key=lambda item: -len(item[1])):
        text = re.sub(f"(file:/*)?{re.escape(folder)}(?=/)", f"package://{name}", text)
    return text


def _first_line(reason: str) -> str:
    """The first line of what xacro says: the cause; what was evaluated around it follows."""
    return _printable(next((line for line in reason.splitlines() if line.strip()), "no reason"))


def _last_line(stderr: bytes) -> str:
    """The last line that a failed process wrote."""
    lines = [line for line in stderr.decode("utf-8", "replace").splitlines() if line.strip()]
    return _printable(lines[-1] if lines else "no reason given")


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable()).strip()[:300]
