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

    def __str__(self) -> str:
        faster = self.other / self.ours
        speed = f"{faster:.1f} times faster than" if faster >= 1 else f"{1 / faster:.2f} times as long as"
        return f"{self.what}: {self.ours * 1e3:.3g} ms, {speed} {self.against} ({self.other * 1e3:.3g} ms); {self.aim}"


def median_times(*works: tuple[Callable[[], object], int]) -> list[float]:
    """Median wall times in seconds of calls, each repeated as often as said, after one call to warm up.

    The calls take turns, so that what slows the machine for a while slows all of them.
    """
    times: list[list[float]] = [[] for _ in works]
    for work, _ in works:
        work()
    for turn in range(max(repeats for _, repeats in works)):
        for (work, repeats), own in zip(works, times, strict=True):
            if turn < repeats:
                start = time.perf_counter()
                work()
                own.append(time.perf_counter() - start)
    return [statistics.median(own) for own in times]


def median_time(work: Callable[[], object], repeats: int) -> float:
    """Median wall time of a call in seconds, after one call to warm up."""
    return median_times((work, repeats))[0]


def compare(
    what: str,
    ours: Callable[[], object],
    against: str,
    other: Callable[[], object],
    aim: str,
    *,
    repeats: int = 7,
    other_repeats: int = 3,
) -> Ratio:
    """Time two calls in turns."""
    return Ratio(what, against, *median_times((ours, repeats), (other, other_repeats)), aim)


def process(*arguments: str) -> Callable[[], object]:
    """A call that runs this interpreter with arguments as a whole process."""
    return lambda: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
