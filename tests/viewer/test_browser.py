"""The live view in a real browser: the command serves it, it draws, it answers, it stops."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from elastocal.design.exact import Effort
from elastocal.files.plans.plan_file import write_plan
from elastocal.files.study.study_file import read_study
from elastocal.planning.plan import plan as planned
from tests.viewer.examples import ROBOTS
from tests.viewer.test_live import free_port

pytest.importorskip("viser")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
KR270 = ROBOTS.parent / "kr270"
PATIENCE = 60_000  # [ms] drawn without a graphics card
_COLOURS = """async (source) => {
    const image = new Image();
    image.src = source;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const data = context.getImageData(0, 0, image.width, image.height).data;
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) {
        seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    }
    return seen.size;
}"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    quiet = ["--no-sandbox", "--disable-background-networking", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=[*quiet, "--use-gl=angle", "--use-angle=swiftshader"]
        )
        yield chromium
        chromium.close()


@contextmanager
def served(*arguments: str | Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """`elastocal view` in a process of its own, and its address."""
    port = str(free_port())
    command = [sys.executable, "-W", "error", "-m", "elastocal", "view", *map(str, arguments)]
    with subprocess.Popen(
        [*command, "--port", port, "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert f"http://127.0.0.1:{port}/ (this machine only)" in line
            yield f"http://127.0.0.1:{port}/", process
        finally:
            if process.poll() is None:
                process.kill()


class Visit:
    """A page of the view with what went wrong on it."""

    def __init__(self, browser: Any, address: str) -> None:
        self.page = browser.new_page(viewport={"width": 900, "height": 640})
        self.errors: list[str] = []
        self.asked: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._line)
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(address)
        self.page.wait_for_selector("[data-readout=margins]", state="attached", timeout=PATIENCE)

    def _line(self, line: Any) -> None:
        if line.type == "error":
            self.errors.append(line.text)

    def says(self, key: str) -> str:
        """What a readout says."""
        return str(self.page.locator(f"[data-readout={key}]").first.inner_text())

    def wait_until_not(self, key: str, old: str) -> str:
        """What a readout says once it says something else."""
        end = time.monotonic() + PATIENCE / 1e3
        while self.says(key) == old:
            assert time.monotonic() < end, f"{key} stays {old}"
            self.page.wait_for_timeout(100)
        return self.says(key)

    def colours(self, path: Path) -> int:
        """How many colours a picture of the page has; kept for people in `path`."""
        import base64

        data = self.page.screenshot(path=path, timeout=PATIENCE)
        source = "data:image/png;base64," + base64.b64encode(data).decode()
        return int(self.page.evaluate(_COLOURS, source))

    def drawn(self, path: Path) -> None:
        """Wait until the scene is more than the panel on an empty ground."""
        end = time.monotonic() + PATIENCE / 1e3
        while self.colours(path) < 1500:
            assert time.monotonic() < end, "the scene is blank"
            self.page.wait_for_timeout(300)


def test_plan_is_stepped_through_and_moved_by_hand(browser: Any, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    study, model = KR270 / "study.yaml", KR270 / "truth.json"
    write_plan(planned(read_study(study), effort=Effort(batch=24, generations=2)), plan)
    with served(study, "--plan", plan, "--model", model) as (address, process):
        visit = Visit(browser, address)
        assert "mm" in visit.says("deflection")
        assert "place" in visit.says("worth") or "anywhere" in visit.says("worth")
        position, deflection = visit.says("position"), visit.says("deflection")
        visit.page.get_by_role("button", name="next").click()
        visit.wait_until_not("position", position)
        fields = visit.page.locator("input").evaluate_all("all => all.map((one) => one.value)")
        assert any(field.startswith("pose 2 of 3") for field in fields)
        visit.page.wait_for_selector("[data-readout=shown]", state="detached")  # it is there
        position, deflection = visit.says("position"), visit.says("deflection")
        visit.page.get_by_role("slider").nth(1).press("Home")  # A2 to its lower limit
        assert visit.wait_until_not("position", position) != position
        assert visit.says("deflection") != deflection
        visit.drawn(tmp_path / "by hand.png")
        assert visit.errors == []
        foreign = [url for url in visit.asked if not url.startswith((address, "data:", "blob:"))]
        assert foreign == []
        visit.page.close()
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=20)
        assert process.returncode == 0
        assert said.strip() == "stopped"


def test_robot_from_a_file_without_plan_and_model(browser: Any) -> None:
    with served(ROBOTS / "scara-700" / "study.yaml") as (address, process):
        visit = Visit(browser, address)
        assert visit.page.locator("[data-readout=deflection]").count() == 0
        assert visit.page.locator("[data-readout=worth]").count() == 0
        assert "J3 [mm]" in visit.page.inner_text("body")
        assert "J1 [deg]" in visit.page.inner_text("body")
        assert visit.errors == []
        visit.page.close()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
        assert process.returncode == 0
