"""xacro files: expanded to URDF by the package xacro, in a process of its own.

xacro is a programming language. It runs apart, with limits on time and memory, and what
it includes must lie in the folders that were named.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from elastocal.errors import InputError

_SECONDS = 30.0
_SCRIPT = """
import json, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
except ImportError:
    pass  # no such limits on Windows
import xacro
from xacro import substitution_args
path, packages = sys.argv[1], json.loads(sys.argv[2])
def find(name):
    if name not in packages:
        raise LookupError(f"no folder is named for package {name!r}")
    return packages[name]
substitution_args._eval_find = find
document = xacro.process_file(path)
text = document.toxml()
print(json.dumps({"text": text, "includes": xacro.all_includes}))
"""


def expanded(path: Path, packages: Mapping[str, Path]) -> bytes:
    """The URDF of a xacro file.

    Args:
        path: The file.
        packages: Folders of packages by name, for $(find name).

    Raises:
        InputError: xacro is not installed, the file is wrong or takes too long, or it includes a
            file from elsewhere.
    """
    if find_spec("xacro") is None:
        raise InputError(
            f"{path}: xacro files are expanded with the package xacro, which is not "
            "installed; pip install 'elastocal[xacro]', or expand the file yourself"
        )
    folders = {name: str(folder.resolve()) for name, folder in packages.items()}
    command = [sys.executable, "-c", _SCRIPT, str(path.resolve()), json.dumps(folders)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: expanding it takes more than {_SECONDS:g} s") from None
    if done.returncode != 0:
        raise InputError(f"{path}: xacro cannot expand it: {_reason(done.stderr)}")
    answer = json.loads(done.stdout)
    allowed = [path.parent.resolve(), *(folder.resolve() for folder in packages.values())]
    for include in answer["includes"]:
        if not any(Path(include).resolve().is_relative_to(folder) for folder in allowed):
            raise InputError(
                f"{path}: it includes {include}, which is outside its folder and the packages named"
            )
    return str(answer["text"]).encode()


def _reason(stderr: bytes) -> str:
    """The last line that a failed process wrote, without control characters."""
    lines = [line for line in stderr.decode("utf-8", "replace").splitlines() if line.strip()]
    last = lines[-1] if lines else "no reason given"
    return "".join(c for c in last if c.isprintable())[:300]
