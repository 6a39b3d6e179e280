"""The report in a real browser: it draws, no script fails, nothing is fetched."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastocal.drawing.check_picture import check_page
from elastocal.files.study.study_file import read_study
from elastocal.planning.plan import plan
from elastocal.planning.trade_off import TradeOff, random_plans
from elastocal.report import html
from elastocal.report.contents import Contents
from tests.report.examples import campaign_page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
STUDY = Path(__file__).parents[2] / "examples" / "kr270" / "study.yaml"
_COVERED = """() => {
    const covered = [];
    document.querySelectorAll("svg.chart").forEach((chart) => {
        const texts = [...chart.querySelectorAll("text")];
        const boxes = texts.map((text) => [text, text.getBoundingClientRect()]);
        const frame = chart.getBoundingClientRect();
        boxes.forEach(([a, p], i) => {
            if (p.width && (p.left < frame.left - 3 || p.right > frame.right + 3)) {
                covered.push(a.textContent + " is cut off");
            }
            boxes.slice(i + 1).forEach(([b, q]) => {
                const wide = Math.min(p.right, q.right) - Math.max(p.left, q.left);
                const high = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
                if (wide > 1.5 && high > 4 && !a.hasAttribute("transform")) {
                    covered.push(a.textContent + " / " + b.textContent);
                }
            });
        });
    });
    return covered;
}"""
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the KR 270 plan; the curves are made up, the page does not care."""
    study = read_study(STUDY)
    made = plan(study)
    rho0 = made.assessment.rho0
    counts = np.array([4, 8, 12])
    curve = rho0 * np.sqrt(12 / counts)
    curves = TradeOff(counts, curve, 0.99 * curve, np.array([2, 3]), np.array([1.07, 1.0]) * rho0)
    page = tmp_path_factory.mktemp("report") / "report.html"
    page.write_text(
        html(Contents(made, trade_off=curves, random=random_plans(study, 300), others={})),
        encoding="utf-8",
    )
    return page


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    quiet = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=[*quiet, "--enable-unsafe-swiftshader"]
        )
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a whole campaign."""
    page = tmp_path_factory.mktemp("campaign") / "report.html"
    page.write_text(campaign_page("kuka-kr270"), encoding="utf-8")
    return page


@pytest.mark.parametrize("which", ["report", "campaign"])
@pytest.mark.parametrize("size", [(1280, 900), (390, 844)], ids=["desktop", "phone"])
def test_report_draws_offline_without_script_errors(
    size: tuple[int, int], which: str, request: Any, browser: Any, tmp_path: Path
) -> None:
    report: Path = request.getfixturevalue(which)
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    errors: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    page.on("request", lambda request: asked.append(request.url))
    page.goto(report.as_uri())
    page.wait_for_selector(".js-plotly-plot canvas", state="attached")
    page.wait_for_timeout(500)

    assert errors == []
    fetched = [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]
    assert fetched == []
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0], "scrolls sideways"
    assert page.evaluate(_COVERED) == [], "labels cover each other"
    for i in range(page.locator(".js-plotly-plot").count()):
        picture = page.locator(".js-plotly-plot").nth(i).screenshot(path=tmp_path / "robot.png")
        assert _colours(page, picture) > 20, "the 3D view is blank"
    page.screenshot(path=tmp_path / "report.png", full_page=True)
    assert (tmp_path / "report.png").stat().st_size > 50_000
    page.close()


def _colours(page: Any, picture: bytes) -> int:
    """Number of different colours in a PNG, counted by the browser itself."""
    import base64

    source = "data:image/png;base64," + base64.b64encode(picture).decode()
    return int(
        page.evaluate(
            """async (source) => {
                const image = new Image();
                image.src = source;
                await image.decode();
                const canvas = document.createElement("canvas");
                canvas.width = image.width;
                canvas.height = image.height;
                const context = canvas.getContext("2d");
                context.drawImage(image, 0, 0);
                const data = context.getImageData(0, 0, image.width, image.height).data;
                const seen = new Set();
                for (let i = 0; i < data.length; i += 4) {
                    seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
                }
                return seen.size;
            }""",
            source,
        )
    )


def test_the_check_for_errors_would_notice_one(browser: Any, tmp_path: Path) -> None:
    """Negative control: a page with a script error and a foreign picture is caught."""
    bad = tmp_path / "bad.html"
    bad.write_text('<img src="http://127.0.0.1:9/x.png"><script>nothing()</script>')
    page = browser.new_page()
    errors: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(bad.as_uri())
    assert any("nothing" in error for error in errors)
    assert "http://127.0.0.1:9/x.png" in asked
    page.set_content(
        '<svg class="chart" width="200"><text x="5" y="20">one</text><text x="9" y="22">two</text>'
        '<text x="180" y="80">too long to fit</text></svg>'
    )
    assert page.evaluate(_COVERED) == ["one / two", "too long to fit is cut off"]
    page.close()


def test_nothing_else_runs_or_is_fetched(report: Path, browser: Any, tmp_path: Path) -> None:
    """What would slip into a page, past all escaping, still does nothing."""
    slipped = (
        '<script>window.slipped = "script"</script>'
        '<img src="x" onerror="window.slipped = 1"><img src="http://127.0.0.1:9/x.png">'
        '<svg onload="window.slipped = 2"></svg><iframe srcdoc="<b>x</b>"></iframe>'
        '<a id="js" href="javascript:window.slipped = 3">x</a><base href="http://127.0.0.1:9/">'
    )
    for name, text in (
        ("report", report.read_text(encoding="utf-8")),
        ("check", check_page(read_study(STUDY))),
    ):
        assert text.count("Content-Security-Policy") == 1
        bad = tmp_path / f"{name}.html"
        bad.write_text(text.replace("<body", f"<body>{slipped}<p", 1), encoding="utf-8")
        page = browser.new_page()
        asked: list[str] = []
        refused: list[str] = []
        page.on("request", lambda request, asked=asked: asked.append(request.url))
        page.on(
            "requestfailed",
            lambda request, refused=refused: refused.append(f"{request.url} {request.failure}"),
        )
        page.goto(bad.as_uri())
        page.evaluate("document.getElementById('js').click()")
        page.wait_for_timeout(300)
        assert page.evaluate("window.slipped") is None
        fetched = [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]
        assert all(f"{url} csp" in refused for url in fetched), refused
        page.close()
