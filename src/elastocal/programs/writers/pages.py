"""Pages: a program that is too long for one file, as several that are run one after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from elastocal.programs.robot_program import Move, Step


def paged(
    steps: Sequence[Step],
    moves: int,
    lines: int = 0,
    lines_of: Callable[[Step], int] = lambda step: 0,
) -> list[list[Step]]:
    """The steps in order, in pages of at most so many motions and, unless 0, lines."""
    pages: list[list[Step]] = [[]]
    here, length = 0, 0
    for step in steps:
        more, longer = int(isinstance(step, Move)), lines_of(step)
        if pages[-1] and (here + more > moves or 0 < lines < length + longer):
            pages.append([])
            here, length = 0, 0
        pages[-1].append(step)
        here, length = here + more, length + longer
    return pages


def page_names(name: str, count: int) -> list[str]:
    """Names of `count` pages; that of the program itself if there is one only."""
    return [name] if count == 1 else [f"{name}_{number + 1:03d}" for number in range(count)]


def room(count: int) -> int:
    """How many characters a name needs for the numbers of `count` pages."""
    return 0 if count == 1 else len(page_names("", count)[-1])
