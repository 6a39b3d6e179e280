"""Where the meshes of a robot file are: inside the folders that were named, or nowhere.

In: a reference such as package://arm/meshes/link1.stl. Out: a path, or why there is none. Of meshes
no more than the beginning is read here. A robot file may come from anywhere, so it does not get to
point anywhere.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote

from elastocal.errors import InputError

_UP_AXIS = re.compile(rb"<up_axis>\s*([XY]_UP)\s*</up_axis>")
_BEGINNING = 65_536  # bytes in which a COLLADA file says which axis is up


class MeshFiles:
    """Looks for the meshes of one robot file.

    Attributes:
        missing: (reference, why) of those not found.
        turned: Which axis is up in COLLADA files where that is not z.
        count: How many were looked for.
    """

    def __init__(self, folder: Path, packages: Mapping[str, Path]) -> None:
        """Allow the folder of the robot file, and the folders of packages by name."""
        for name, place in packages.items():
            if not os.path.isdir(place):  # it takes names that no folder can have
                raise InputError(f"package {name!r}: the folder {place} does not exist")
        self._folder, self._packages = folder, dict(packages)
        self._allowed = [place.resolve() for place in (folder, *packages.values())]
        self.missing: list[tuple[str, str]] = []
        self.turned: dict[Path, str] = {}
        self.count = 0

    def find(self, reference: str) -> Path | None:
        """The file that `reference` names, None if it is not there; then `missing` tells why."""
        self.count += 1
        found = self._find(reference)
        if isinstance(found, Path):
            if found.suffix.lower() == ".dae" and (up := _up_axis(found)):
                self.turned[found] = up
            return found
        self.missing.append((reference, found))
        return None

    def _find(self, reference: str) -> Path | str:
        scheme, separator, rest = reference.partition("://")
        if not separator:
            return self._inside(self._folder / reference)
        if scheme == "package":
            package, _, inner = rest.partition("/")
            if package not in self._packages:
                return (
                    f"no folder is named for package {package!r} (packages: {{{package}: folder}})"
                )
            return self._inside(self._packages[package] / inner)
        if scheme == "file":
            return self._inside(Path(unquote(rest)))
        return f"{scheme}:// is not looked up"

    def _inside(self, path: Path) -> Path | str:
        try:
            real = path.resolve()
            if not any(real.is_relative_to(place) for place in self._allowed):
                return "it is outside the folder of the robot file and the packages named"
            return real if real.is_file() else "there is no such file"
        except (OSError, ValueError, RuntimeError):
            return "it is no name of a file"

    def remark(self) -> list[str]:
        """Sentences on those not found, and on those that are turned; none if there are none."""
        said = []
        if self.missing:
            reference, why = self.missing[0]
            said.append(
                f"{len(self.missing)} of {self.count} meshes were not found, such as "
                f"{reference[:120]}: {why}"
            )
        if self.turned:
            file, up = next(iter(self.turned.items()))
            said.append(
                f"{len(self.turned)} meshes such as {file.name} say {up} and are turned z up, as "
                "COLLADA has it; RViz and MoveIt leave them as they are: look at the robot with "
                "'elastocal view', and mend <up_axis> if it lies on its side"
            )
        return said


def _up_axis(file: Path) -> str:
    """Which axis a COLLADA file says is up, if it is not z; empty if it is, or does not say."""
    try:
        with file.open("rb") as opened:
            found = _UP_AXIS.search(opened.read(_BEGINNING))
    except OSError:
        return ""
    return found[1].decode() if found else ""
