"""The page: sections put together, in the order of the work.

In: contents. Out: HTML text. Everything a user named passes through escaping: jinja2's in HTML,
`svg.tag` in pictures, `scene` and `_script_json` in the 3D views.
"""

from __future__ import annotations

import json
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from elastocal.drawing.palette import COLOURS
from elastocal.drawing.policy import policy
from elastocal.errors import InputError
from elastocal.report.contents import Contents
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.sections.calibration import (
    CalibrationContents,
    calibration_chapter,
    calibration_top,
)
from elastocal.report.sections.compensation import compensation_chapter
from elastocal.report.sections.identification import identification_chapter
from elastocal.report.sections.monte_carlo import monte_carlo_chapter
from elastocal.report.sections.plan import plan_chapter
from elastocal.report.sections.provenance import provenance
from elastocal.report.sections.state import state_section, title
from elastocal.report.sections.stiffness import stiffness_chapter
from elastocal.report.sections.validation import validation_chapter
from elastocal.wording import worded
from elastocal.wording.numbers import words
from elastocal.writing import signature

_CHAPTERS = (
    identification_chapter,
    validation_chapter,
    stiffness_chapter,
    compensation_chapter,
    monte_carlo_chapter,
)


def render(contents: Contents) -> str:
    """HTML of everything in `contents`; see `elastocal.report.html`."""
    stages = [chapter for chapter in (make(contents) for make in _CHAPTERS) if chapter is not None]
    plan = plan_chapter(contents, alone=not stages)
    if stages:
        top = state_section(contents)
        chapters = [chapter for chapter in (plan, *stages) if chapter is not None]
    elif plan is not None:
        top, *rest = plan.sections
        chapters = [Chapter("", tuple(rest))]
    else:
        raise InputError("a report needs a plan, an identification or another result to show")
    chapters.append(Chapter("", (provenance(contents),)))
    return _page(title(contents), top, chapters)


def render_calibration(contents: CalibrationContents) -> str:
    """HTML of a calibration from absolute readings."""
    top, chapter = calibration_top(contents), calibration_chapter(contents)
    return _page(f"{contents.name}: calibration", top, [chapter])


def _page(name: str, top: PageSection, chapters: list[Chapter]) -> str:
    """HTML of sections: one on top, the others in their chapters."""
    environment = _environment()
    sections = [section for chapter in chapters for section in chapter.sections]
    scenes = {s.id: _script_json(s.scene) for s in sections if s.scene is not None}
    own = Markup(files("elastocal.report").joinpath("templates/scene.js").read_text("utf-8"))
    scripts = [_plotly(), own] if scenes else [own]
    return environment.get_template("page.html").render(
        title=name,
        signature=signature("report"),
        colours=COLOURS,
        top=_html(top, environment),
        navigation=_navigation(chapters),
        chapters=[
            {"name": chapter.name, "sections": [_html(s, environment) for s in chapter.sections]}
            for chapter in chapters
        ],
        scenes=scenes,
        scripts=scripts,
        policy=policy(scripts),
    )


def _navigation(chapters: list[Chapter]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Name of every stage, with anchors and names of its sections; unnamed ones in one line."""
    lines: list[tuple[str, list[tuple[str, str]]]] = []
    for chapter in chapters:
        links = [(s.id, s.name) for s in chapter.sections if s.name]
        if lines and not chapter.name and not lines[-1][0]:
            lines[-1][1].extend(links)
        else:
            lines.append((chapter.name or ("Sources" if lines else ""), links))
    return lines


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("elastocal.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"words": words, "worded": worded}
    return environment


def _html(section: PageSection, environment: Environment) -> Markup:
    return Markup(environment.get_template(section.template).render(**section.values))


def _script_json(value: Values) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _plotly() -> Markup:
    """plotly.js, once."""
    from plotly.offline import get_plotlyjs

    source: str = get_plotlyjs()
    # Line ends as a browser reads them: the policy of the page has the hash of what it reads.
    return Markup(
        source.replace("</script", "<\\/script").replace("\r\n", "\n").replace("\r", "\n")
    )
