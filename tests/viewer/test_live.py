"""The view on a real server, without a browser: what it shows, and who may look."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.errors import InputError
from elastocal.viewer.live import Live
from elastocal.viewer.local_server import HOST, check_port, local_server, stop
from tests.viewer.examples import kr270, tracked

pytest.importorskip("viser")
STUDY = Path(__file__).parents[2] / "examples" / "kr270" / "study.yaml"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def server() -> Iterator[Any]:
    made = local_server(free_port(), "elastocal")
    yield made
    stop(made)


def words(live: Live) -> str:
    """What the panel says."""
    return re.sub(r"<[^>]+>", " ", live._panel._readout.content)


def test_only_this_machine_can_connect(server: Any) -> None:
    port = server.get_port()
    with socket.create_connection((HOST, port), timeout=5):
        pass
    own = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None)}
    for address in own - {HOST, "::1"}:
        with pytest.raises(OSError):
            socket.create_connection((address, port), timeout=2)
    for table in ("tcp", "tcp6"):
        path = Path("/proc/net") / table
        if path.exists():
            lines = [line.split() for line in path.read_text().splitlines()[1:]]
            listening = [f[1] for f in lines if f[3] == "0A" and f[1].endswith(f":{port:04X}")]
            assert listening == (["0100007F:" + f"{port:04X}"] if table == "tcp" else [])


@pytest.mark.parametrize(
    ("origin", "welcome"),
    [
        ("http://127.0.0.1:{port}", True),
        ("http://localhost:{port}", True),
        ("http://127.0.0.1:1", False),
        ("https://example.org", False),
        ("null", False),
        (None, False),
    ],
)
def test_only_its_own_page_may_talk_to_it(server: Any, origin: str | None, welcome: bool) -> None:
    import viser
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    port = server.get_port()
    origin = origin.format(port=port) if origin else None

    def knock() -> None:
        connect(
            f"ws://{HOST}:{port}",
            origin=origin,  # type: ignore[arg-type]
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            open_timeout=5,
        ).close()

    if welcome:
        knock()
    else:
        with pytest.raises(InvalidStatus, match="403"):
            knock()


def test_a_visitor_cannot_open_a_tunnel(server: Any) -> None:
    assert server.request_share_url() is None


def test_a_busy_port_is_one_sentence() -> None:
    with socket.socket() as other:
        other.bind((HOST, 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} cannot be used .*--port"):
            check_port(port)
        result = CliRunner().invoke(app, ["view", str(STUDY), "--port", str(port)])
        assert result.exit_code == 2
        assert result.output.count("\n") == 1
        assert f"port {port}" in result.output


def test_a_missing_viser_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    result = CliRunner().invoke(app, ["view", str(STUDY)])
    assert result.exit_code == 2
    assert "pip install 'elastocal[view]'" in result.output
    assert result.output.count("\n") == 1


@pytest.mark.parametrize("option", ["--plan", "--model"])
def test_a_missing_file_is_one_sentence(option: str) -> None:
    port = str(free_port())
    result = CliRunner().invoke(app, ["view", str(STUDY), option, "no.json", "--port", port])
    assert result.exit_code == 2
    assert result.output == "error: no.json: no such file\n"


def test_an_unknown_make_of_server_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A viser that serves by other means cannot be kept to its own page: it does not run."""
    import viser
    from websockets.asyncio import server as sockets

    from elastocal.viewer import local_server as module

    class Other(viser.ViserServer):
        def __init__(self, **keys: Any) -> None:
            guarded, sockets.serve = sockets.serve, sockets.serve.__wrapped__  # type: ignore
            try:
                super().__init__(**keys)
            finally:
                sockets.serve = guarded  # type: ignore[misc]

    class Fake:
        ViserServer, __version__ = Other, "0"

    monkeypatch.setattr(module, "viser_module", lambda: Fake)
    with pytest.raises(InputError, match="this version of viser"):
        local_server(free_port(), "elastocal")


def test_stepping_goes_round_and_readouts_follow(server: Any) -> None:
    live = Live(server, kr270())
    first = words(live)
    assert "Deflection" in first
    for turn in range(1, 5):
        live.step(1)
        travel = live._travel
        assert travel is not None
        live.tick(travel.since + 0.5)
        between = words(live)
        live.tick(travel.ends)
        assert words(live) != between
        stop_ = kr270().stops[turn % 4]
        assert (live._shown.q == stop_.q).all()
        shown = np.array([slider.value for slider in live._panel._sliders])
        assert shown == pytest.approx(np.degrees(stop_.q), abs=0.006)
    assert words(live) == first
    live.step(-1)
    assert live._shown.stop == 3


def test_a_joint_set_by_hand_moves_only_that_joint(server: Any) -> None:
    live = Live(server, kr270())
    before, text = np.array(live._shown.q), words(live)
    live.step(1)
    live.set_joint(2, 1.0)
    assert "moved away from this pose" in words(live)
    assert live._travel is None, "what moves by the clock must stand still"
    assert live._shown.q[2] == 1.0
    assert np.delete(live._shown.q, 2) == pytest.approx(np.delete(before, 2))
    assert words(live) != text
    live.reset("middle")
    assert live._shown.q == pytest.approx(kr270().study.limits.mean(axis=0))
    live.reset("joints")
    assert (live._shown.q == kr270().stops[1].q).all()
    live.reset("load")
    assert "moved away" not in words(live)


def test_loads_and_magnification_change_what_is_said(server: Any) -> None:
    live = Live(server, kr270())
    live.set_load(np.array([0.0, 0.0, -100.0]), None)
    assert "100 N" in words(live)
    live.set_load(None, np.array([0.0, 5.0, 0.0]))
    assert "5 N·m" in words(live)
    live.magnify(7.0)
    assert "7×" in words(live)
    live.reset("load")
    assert "2500 N" in words(live)


def test_playing_waits_at_every_stop_and_stops_when_told(server: Any) -> None:
    live = Live(server, kr270())
    live.play()
    assert live._next is not None
    live.tick(live._next)
    travel = live._travel
    assert travel is not None
    live.tick(travel.ends)
    assert live._travel is None
    live.tick(travel.ends + 0.1)
    assert live._travel is None, "it waits"
    live.tick(live._next + 0.1)
    assert live._travel is not None
    live.play()
    assert live._next is None


def test_only_what_there_is_can_be_switched(server: Any) -> None:
    live = Live(server, tracked())
    assert set(live._scene.present) == {"loads", "tests", "limits", "cell", "tracker", "names"}
    for layer in live._scene.present:
        live.switch(layer, False)
        live.switch(layer, True)
    live.set_joint(0, np.radians(180.0))
    assert "acceptance of M1" in words(live)
    assert "broken" in words(live)


def test_running_ends_when_told(server: Any) -> None:
    live = Live(server, tracked())
    answers = iter([True, True, False])
    live.run(lambda: next(answers))


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C of POSIX")
def test_visitors_do_not_fill_the_terminal() -> None:
    """What they send is not understood, what they open they drop; the view goes on."""
    import viser
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    port = free_port()
    command = [sys.executable, "-m", "elastocal", "view", str(STUDY), "--no-browser"]
    process = subprocess.Popen(
        [*command, "--port", str(port)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("showing")
        page: dict[str, Any] = {
            "uri": f"ws://{HOST}:{port}",
            "origin": f"http://{HOST}:{port}",
            "subprotocols": [f"viser-v{viser.__version__}"],
        }
        for nonsense in ("text", b"\x93\x01nonsense", b""):
            with connect(**page) as visitor:
                visitor.send(nonsense)
                with suppress(ConnectionClosed, TimeoutError):
                    while True:
                        visitor.recv(timeout=5)
        for sent in (b"\x00\xff" * 50, b"GET / HTTP/1.1\r\n"):
            with socket.create_connection((HOST, port), timeout=5) as dropped:
                dropped.sendall(sent)
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    assert (process.returncode, errors) == (0, "")
    assert said.endswith("stopped\n")
