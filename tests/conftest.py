"""What holds for all tests: examples of hypothesis are the same in every run, Ctrl-C is heard.

A shell takes Ctrl-C from what runs in the background, and from what that starts: the programs
under test would not stop.
"""

from __future__ import annotations

import signal

from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None)
settings.load_profile("same")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
