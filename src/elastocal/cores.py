"""Several cores: parts of a piece of work dealt out to processes or threads.

How the work is divided is for the caller to say, and does not depend on how many cores there are:
so nor does what comes out. Only how long it takes does.
"""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache, partial
from typing import TYPE_CHECKING, TypeVar

from elastocal.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

Part = TypeVar("Part")
Result = TypeVar("Result")

_WORKERS: ContextVar[int] = ContextVar("workers", default=1)
_IDLE = 60  # seconds after which processes without work end


@contextmanager
def several_cores(workers: int) -> Iterator[None]:
    """Within it, what is slow enough to be worth it is done by that many processes.

    Args:
        workers: Processes; 1 for none besides this one.

    Raises:
        InputError: fewer than 1; more than 1 without the package joblib.
    """
    if workers < 1:
        raise InputError(f"the number of workers must be at least 1, found {workers}")
    if workers > 1 and not _has_joblib():
        raise InputError("more than one worker needs joblib: install elastocal[parallel]")
    before = _WORKERS.set(workers)
    try:
        yield
    finally:
        _WORKERS.reset(before)


def usable_cores() -> int:
    """How many processes are worth starting here: 1 without the package joblib."""
    if not _has_joblib():
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def dealt(work: Callable[[Part], Result], parts: Sequence[Part]) -> Iterator[Result]:
    """The results of all parts, in their order; `work` and parts can be pickled."""
    if len(parts) < 2:
        return map(work, parts)
    workers = _WORKERS.get()
    return map(partial(_as_there, work), parts) if workers == 1 else _sent(work, parts, workers)


def side_by_side(work: Callable[[int, int], None], count: int, least: int) -> None:
    """Call `work` with the ends of parts of a range, in threads if several cores are wanted.

    For compiled code, which lets go of the interpreter: the parts share memory.

    Args:
        work: Does what is from the first number to before the second.
        count: Length of the range.
        least: What is shorter is not worth a thread.
    """
    parts = min(_WORKERS.get(), count // least)
    if parts < 2:
        work(0, count)
        return
    ends = [count * part // parts for part in range(parts + 1)]
    list(_threads(parts).map(work, ends[:-1], ends[1:]))


@lru_cache(maxsize=1)
def _threads(count: int) -> ThreadPoolExecutor:
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(count)


def _as_there(work: Callable[[Part], Result], part: Part) -> Result:
    """The result of a part that goes there and back as to another process.

    So its arrays lie in memory in the same way, and sums are rounded alike.
    """
    there, sent = pickle.loads(pickle.dumps((work, part)))
    back: Result = pickle.loads(pickle.dumps(there(sent)))
    return back


def _sent(work: Callable[[Part], Result], parts: Sequence[Part], workers: int) -> Iterator[Result]:
    from joblib.externals.loky import get_reusable_executor

    # One thread each: the parts are what the cores share.
    alone = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}
    crew = get_reusable_executor(
        max_workers=workers, timeout=_IDLE, env=alone, initializer=_deaf_to_interrupts
    )
    try:
        yield from crew.map(work, parts)
    except KeyboardInterrupt:
        crew.shutdown(kill_workers=True)
        raise


def _deaf_to_interrupts() -> None:
    """Ctrl-C reaches every process of a terminal; the one that deals out the work answers it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _has_joblib() -> bool:
    from importlib.util import find_spec

    return find_spec("joblib") is not None
