"""Stopping: long work asks now and then whether it should end, whoever called it.

Within `stoppable` the innermost loops call `stop_if_asked`, which ends all of it with `Stopped`.
What has no result without its end lets that pass; what keeps the best so far catches it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Stop = Callable[[], bool]
"""Whether to end what is going on."""

_STOP: ContextVar[Stop | None] = ContextVar("stop", default=None)


class Stopped(Exception):
    """The work was asked to end before it was done."""


@contextmanager
def stoppable(stop: Stop | None) -> Iterator[None]:
    """Within it work ends with `Stopped` soon after `stop` is true; None: nothing ends it."""
    before = _STOP.set(stop)
    try:
        yield
    finally:
        _STOP.reset(before)


def stop_if_asked() -> None:
    """End here if that was asked for.

    Raises:
        Stopped: it was.
    """
    stop = _STOP.get()
    if stop is not None and stop():
        raise Stopped
