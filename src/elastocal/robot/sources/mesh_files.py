"""Where the meshes of a robot file are: inside the folders that were named, or nowhere.

In: a reference such as package://arm/meshes/link1.stl. Out: a path, or why there is none. Meshes
are not opened here. A robot file may come from anywhere, so it does not get to point anywhere.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote

from elastocal.errors import InputError


class MeshFiles:
    """Looks for the meshes of one robot file.

    Attributes:
        missing: (reference, why) of those not found.
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
        self.count = 0

    def find(self, reference: str) -> Path | None:
        """The file that `reference` names, None if it is not there; then `missing` tells why."""
        self.count += 1
        found = self._find(reference)
        if isinstance(found, Path):
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
                return f"no folder is named for package {package!r}"
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
        """A sentence on those not found, none if there are none."""
        if not self.missing:
            return []
        reference, why = self.missing[0]
        return [
            f"{len(self.missing)} of {self.count} meshes were not found, such as "
            f"{reference[:120]}: {why}"
        ]
