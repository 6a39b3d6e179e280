"""Section: what one card of the page needs, before it is HTML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Values = Mapping[str, object]
"""What a template or a script shows, by the names it has there."""


@dataclass(frozen=True)
class PageSection:
    """One template with its values.

    Attributes:
        id: Anchor of the section; its template is `<id>.html` with underscores.
        name: What the navigation calls it.
        values: What the template shows.
        scene: Traces and layout of its 3D view, if it has one.
    """

    id: str
    name: str
    values: Values
    scene: Values | None = field(default=None, repr=False)

    @property
    def template(self) -> str:
        """Name of the template."""
        return self.id.replace("-", "_") + ".html"


@dataclass(frozen=True)
class Chapter:
    """The sections of one stage of a campaign.

    Attributes:
        name: Name of the stage.
        sections: Its sections in order.
    """

    name: str
    sections: tuple[PageSection, ...]
