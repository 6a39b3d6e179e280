"""Rows of tables of arms, most numbers zero."""

from __future__ import annotations

from elastocal.robot.sources import DHRow


def row(
    name: str,
    *,
    a: float = 0.0,
    alpha: float = 0.0,
    d: float = 0.0,
    prismatic: bool = False,
) -> DHRow:
    """A joint without limits."""
    return DHRow(name, 0.0, d, a, alpha, prismatic)
