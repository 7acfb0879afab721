"""Median times and ratios."""

import resource
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


def processor_time() -> float:
    """Processor time in seconds of this process and of those that it started and that have ended."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime


def median_times(*works: Callable[[], object], clock: Callable[[], float] = processor_time) -> list[float]:
    """Median times in seconds of calls, each repeated nine times, or until it has taken 20 s, after one call to warm up.

    The calls take turns, so that what slows the machine for a while slows all of them. Other programs interrupt long calls only: their wall time
    is not in proportion to that of short ones. Calls on several cores need ``clock=time.perf_counter`` and a machine without other work.
    """
    times: list[list[float]] = [[] for _ in works]
    spent = [0.0] * len(times)
    for work in works:
        work()
    for _ in range(REPEATS):
        for i, work in enumerate(works):
            if spent[i] < LONGEST:
                begin, start = time.perf_counter(), clock()
                work()
                times[i].append(clock() - start)
                spent[i] += time.perf_counter() - begin
    return [statistics.median(own) for own in times]


def compare(
    what: str, ours: Callable[[], object], against: str, other: Callable[[], object], aim: str, note: str = ""
) -> Ratio:
    """Time two calls in turns."""
    return Ratio(what, against, *median_times(ours, other), aim, note)


def process(*arguments: str) -> Callable[[], object]:
    """A call that runs this interpreter with arguments as a whole process."""
    return lambda: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
