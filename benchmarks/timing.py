"""Median times and ratios."""

import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Ratio:
    """One comparison."""

    what: str
    against: str
    ours: float
    other: float
    aim: str
    note: str = ""
    """What else was measured, such as errors and times of one step: no part of the name, by which versions are compared."""

    def __str__(self) -> str:
        faster = self.other / self.ours
        speed = f"{faster:.1f} times faster than" if faster >= 1 else f"{1 / faster:.2f} times as long as"
        return (
            f"{self.what}: {self.ours * 1e3:.3g} ms, {speed} {self.against} ({self.other * 1e3:.3g} ms); "
            + "; ".join(part for part in (self.aim, self.note) if part)
        )


REPEATS = 9
LONGEST = 20.0
"""Seconds after which a call is not repeated again."""


def median_times(*works: Callable[[], object]) -> list[float]:
    """Median wall times in seconds of calls, each repeated nine times, or until it has taken 20 s, after one call to warm up.

    The calls take turns, so that what slows the machine for a while slows all of them.
    """
    times: list[list[float]] = [[] for _ in works]
    for work in works:
        work()
    for _ in range(REPEATS):
        for work, own in zip(works, times, strict=True):
            if sum(own) < LONGEST:
                start = time.perf_counter()
                work()
                own.append(time.perf_counter() - start)
    return [statistics.median(own) for own in times]


def compare(
    what: str, ours: Callable[[], object], against: str, other: Callable[[], object], aim: str, note: str = ""
) -> Ratio:
    """Time two calls in turns."""
    return Ratio(what, against, *median_times(ours, other), aim, note)


def process(*arguments: str) -> Callable[[], object]:
    """A call that runs this interpreter with arguments as a whole process."""
    return lambda: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
