"""Local server: viser on this machine alone, for pages that it served itself.

viser is meant for networks: it listens on all interfaces, takes the next port if one is busy,
tells browsers nothing of who may connect, and lets any visitor open a tunnel to the outside. None
of that is wanted at a robot cell, so each is closed here, and nowhere else is viser started.
"""

from __future__ import annotations

import contextlib
import functools
import io
import socket
from collections.abc import Iterator
from typing import Any

from elastocal.errors import InputError

HOST = "127.0.0.1"


def viser_module() -> Any:
    """The module viser.

    Raises:
        InputError: it is not installed.
    """
    try:
        import viser
    except ImportError:
        raise InputError(
            "the live view needs the package viser: pip install 'elastocal[view]'"
        ) from None
    return viser


def check_port(port: int) -> None:
    """Refuse a port that cannot be had.

    Raises:
        InputError: something else listens there, or it is not ours to take.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        # As servers do: a port whose last connections are just closing is free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            raise InputError(
                f"port {port} cannot be used ({error.strerror}); choose another one with --port"
            ) from None


def local_server(port: int, label: str) -> Any:
    """A viser server on `HOST` and `port` that serves only this machine's own page.

    Raises:
        InputError: viser is missing or of an unknown make, or the port is busy.
    """
    viser = viser_module()
    check_port(port)

    class LocalServer(viser.ViserServer):  # type: ignore[misc, name-defined]
        """Without a way out: nothing is shared through a tunnel, whoever asks."""

        def request_share_url(self, verbose: bool = True) -> None:
            """Nothing is shared."""

    # viser prints a banner, and "stopped" when it ends; what users read is for the command.
    with _guarded(port) as used, contextlib.redirect_stdout(io.StringIO()):
        server = LocalServer(host=HOST, port=port, label=label, verbose=False)
    if not used or server.get_port() != port:
        stop(server)
        if used:
            raise InputError(f"port {port} was taken meanwhile; choose another one with --port")
        raise InputError(
            f"this version of viser ({viser.__version__}) cannot be kept to this machine; "
            "install 'elastocal[view]' anew"
        )
    return server


def stop(server: Any) -> None:
    """Stop a server quietly."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


@contextlib.contextmanager
def _guarded(port: int) -> Iterator[list[int]]:
    """While open, web sockets are served only to pages from here; the list tells that one was.

    Any page in the user's browser may knock at local ports. A browser says in the header Origin
    where a page comes from, and viser does not look; the library below it can.
    """
    from websockets.asyncio import server as sockets

    allowed = [f"http://{name}:{port}" for name in (HOST, "localhost")]
    used: list[int] = []
    original = sockets.serve

    @functools.wraps(original)
    def serve(*args: Any, **kwargs: Any) -> Any:
        used.append(port)
        return original(*args, **{**kwargs, "origins": allowed})

    sockets.serve = serve  # type: ignore[assignment, misc]
    try:
        yield used
    finally:
        sockets.serve = original  # type: ignore[misc]
