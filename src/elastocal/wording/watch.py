"""What is watched for collisions, in the same words on every screen and in every program."""

from __future__ import annotations

from collections.abc import Sequence

_NAMES = {"itself": "the robot against itself"}
_KEYS = {"itself": "collision: {}", "floor": "floor: {z_mm: …}"}


def watch(watched: Sequence[str], unwatched: Sequence[str], *, keys: bool = False) -> str:
    """A sentence or two.

    Args:
        watched: What robot and tool keep clear of: "itself", "floor", names of obstacles.
        unwatched: What of "itself" and "floor" they do not.
        keys: Whether to say how a study watches the rest.
    """
    said = [f"Watched for collisions: {_listed(watched)}."] if watched else []
    if unwatched:
        mend = ", ".join(_KEYS[name] for name in unwatched)
        hint = f" (to watch it: constraints: {{{mend}}})" if keys else ""
        said.append(f"Not watched: {_listed(unwatched)}{hint}.")
    return " ".join(said)


def _listed(names: Sequence[str]) -> str:
    return "; ".join(_NAMES.get(name, name) for name in names)
