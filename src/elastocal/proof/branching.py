"""Branch and bound of a statement: how small a bound U of d can be proved, in steps, in so long.

The parts of the tree are dealt out to threads: compiled code does not hold the lock.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.proof.boxes import Boxes
from elastocal.proof.tree import Region, proved, settle, take, unproved

_SLICE = 1 << 17  # boxes of one search, so that it can be stopped
_TICK = 0.1  # seconds between two looks at the clock
_SAMPLE = 96  # parts that a prediction is made from
_FEW = 1 << 13  # boxes of one of them at most


@dataclass(frozen=True)
class BranchingState:
    """How far a search is.

    Attributes:
        threshold: What d is being proved to be at most.
        done: Share of its parts.
        boxes: Boxes looked at so far, all thresholds together.
    """

    threshold: float
    done: float
    boxes: int


Told = Callable[[BranchingState], None]


class Branching:
    """A search, from threshold to threshold.

    Attributes:
        boxes: The statement.
        root: The tree.
        evaluated: Boxes looked at.
        best: Largest d at a feasible point that it met; -1: none.
        at: (a,) where that was: the variables of the statement that move.
    """

    def __init__(self, boxes: Boxes, root: Region, threads: int) -> None:
        self.boxes, self.root, self._threads = boxes, root, threads
        self.evaluated, self.best = 0, -1.0
        self.at: Array = np.zeros(len(boxes.variables))
        self._lock = threading.Lock()

    @property
    def proved(self) -> float:
        """No feasible point has a larger d."""
        return proved(self.root)

    def predicted(self, thresholds: Sequence[float], seconds: float) -> list[float]:
        """Seconds that it takes to prove each of these, about, from some of the boxes.

        Args:
            thresholds: From the largest down.
            seconds: How long it may take to find out.
        """
        parts = list(unproved(self.root, thresholds[-1]))
        if not parts:
            return [0.0] * len(thresholds)
        # Every so manyth in the order of their first bounds, so that hard ones have their share.
        order = np.argsort(self.boxes.bounds(np.array([part.box for part in parts]), 0.0)[0])
        step = max(len(parts) / _SAMPLE, 1.0)
        sample = order[np.arange(step / 2.0, len(parts), step).astype(int)]
        sample = np.random.default_rng(len(parts)).permutation(sample)
        found = []
        for threshold in thresholds:
            begun = time.monotonic()
            took: list[float] = []
            for i in sample.tolist():
                if took and time.monotonic() - begun > seconds / len(thresholds):
                    break
                took.append(self._time_of(parts[i], threshold))
            found.append(float(np.mean(took)) * len(parts) / self._threads)
        return np.maximum.accumulate(found).tolist()

    def _time_of(self, part: Region, threshold: float) -> float:
        """Seconds that a part takes; if they are many, by the share that a few boxes are."""
        begun = time.monotonic()
        searched = self.boxes.search(part.box, threshold, _FEW)
        whole = _volume(part.box)
        done = whole - sum(map(_volume, searched.left))
        return (time.monotonic() - begun) * whole / max(done, 1e-6 * whole)

    def prove(self, threshold: float, ends: Callable[[], bool], told: Told | None = None) -> bool:
        """Search until d is below the threshold; False if it ended before, or boxes stay open.

        Args:
            threshold: What d is to be at most.
            ends: Asked now and then whether to end.
            told: Told how far it is.
        """
        todo = deque(unproved(self.root, threshold))
        left = total = sum(_volume(part.box) for part in todo)
        running, end = 0, threading.Event()
        wrong: list[BaseException] = []

        def work() -> None:
            nonlocal left, running
            try:
                while not end.is_set():
                    with self._lock:
                        if not todo:
                            if not running:
                                return
                            part = None
                        else:
                            part = todo.pop()
                            running += 1
                    if part is None:
                        time.sleep(0.001)
                        continue
                    found = self.boxes.search(part.box, threshold, _SLICE)
                    with self._lock:
                        todo.extend(reversed(take(part, found)))
                        running -= 1
                        left += sum(map(_volume, found.left)) - _volume(part.box)
                        self.evaluated += found.evaluated
                        if found.best > self.best:
                            self.best, self.at = found.best, found.at
            except BaseException as error:
                wrong.append(error)
                end.set()

        threads = [threading.Thread(target=work, daemon=True) for _ in range(self._threads)]
        for thread in threads:
            thread.start()
        try:
            while any(thread.is_alive() for thread in threads):
                threads[0].join(_TICK)
                if ends():
                    end.set()
                if told is not None:
                    told(BranchingState(threshold, 1.0 - left / (total or 1.0), self.evaluated))
        finally:
            end.set()
            for thread in threads:
                thread.join()
            settle(self.root)
        if wrong:
            raise wrong[0]
        return self.proved <= threshold


def _volume(box: Array) -> float:
    return float(np.prod(box[len(box) // 2 :]))
