"""Layout: what several sections do with pictures."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.resources import files

from markupsafe import Markup

from elastocal.drawing.palette import COLOURS
from elastocal.writing import signature

WIDE, NARROW = 860.0, 350.0


def two_widths(draw: Callable[[float], Markup]) -> Markup:
    """A picture for wide screens and paper, and one for phones: letters must not shrink."""
    return Markup('<div class="wide">{}</div><div class="narrow">{}</div>').format(
        draw(WIDE), draw(NARROW)
    )


def alone(picture: Markup) -> str:
    """A picture as the text of an SVG file, with the style and the paper that a page would have."""
    rules = files("elastocal.report").joinpath("templates/picture.css").read_text("utf-8")
    own = [rule for rule in rules.splitlines() if rule.startswith((".chart", ".picture"))]
    style = "\n".join(["text { font-family: system-ui, sans-serif; }", *own])
    style = re.sub(r"var\(--([a-z-]+)\)", lambda found: COLOURS[found[1]], style)
    paper = f'<rect x="-10" y="-10" width="100%" height="100%" fill="{COLOURS["paper"]}"/>'
    begun = re.sub(r"<svg.*?>", _with_margins, str(picture), count=1)
    whole = begun.replace("</title>", f"</title>\n<style>\n{style}\n</style>\n{paper}\n", 1)
    return f"{whole}\n<!-- {signature('picture')} -->\n"


def _with_margins(found: re.Match[str]) -> str:
    """The first tag of a picture, with its namespace and ten pixels around it."""
    sides = re.findall(r'(?:width|height)="(.*?)"', found[0])
    width, height = (float(side) + 20.0 for side in sides)
    size = f'viewBox="-10 -10 {width:g} {height:g}" width="{width:g}" height="{height:g}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" class="picture chart">'
