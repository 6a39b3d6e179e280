"""Ctrl-C while a plan is searched: the first ends the search, the second ends the program."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic

from elastocal.planning.certificate import Progress


class SearchEnd:
    """Whether the search is to end: at Ctrl-C, or when its time is over.

    The planner asks from when it has a plan. Before that Ctrl-C ends the program, as ever.

    Attributes:
        answered: Whether the planner has asked, so that there is a plan.
        by_hand: Whether Ctrl-C ended the search.
    """

    def __init__(self, tell: Progress, seconds: float | None = None) -> None:
        """`tell` is told what goes on, `seconds` is how long to search."""
        self.answered = self.by_hand = False
        self._tell, self._end = tell, None if seconds is None else monotonic() + seconds
        self._now = ("", 0.0)

    def __call__(self) -> bool:
        """What the planner asks."""
        self.answered = True
        return self.by_hand or (self._end is not None and monotonic() >= self._end)

    def tell(self, what: str, share: float) -> None:
        """What goes on, as people are told it."""
        self._now = (what, share)
        self._tell(f"finishing, Ctrl-C again drops it: {what}" if self.by_hand else what, share)

    def interrupt(self, *_: object) -> None:
        """What Ctrl-C does.

        Raises:
            KeyboardInterrupt: there is no plan yet, or this is the second one.
        """
        if self.by_hand or not self.answered:
            raise KeyboardInterrupt
        self.by_hand = True
        self.tell(*self._now)


@contextmanager
def ended_by(end: SearchEnd) -> Iterator[None]:
    """Within it Ctrl-C asks for the end of the search first."""
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not usual or threading.current_thread() is not threading.main_thread():
        yield  # Ctrl-C is not ours to take, as in the background of a shell
        return
    before = signal.signal(signal.SIGINT, end.interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
