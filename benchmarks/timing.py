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


def median_time(work: Callable[[], object], repeats: int) -> float:
    """Median wall time of a call in seconds, after one call to warm up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


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
    """Time two calls one after the other."""
    return Ratio(what, against, median_time(ours, repeats), median_time(other, other_repeats), aim)


def process(*arguments: str) -> Callable[[], object]:
    """A call that runs this interpreter with arguments as a whole process."""
    return lambda: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
