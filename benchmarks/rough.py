"""All forces, stiffnesses and energies of a line of ten million springs against sorting their heights."""

from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, median_times
from pymdr.line.rough import sorted_springs
from pymdr.mapping.rough import rough_heights
from pymdr.problem.rough import RoughSurface

SPRINGS = 10_000_000


def ratios() -> Iterator[Ratio]:
    """On the heights of a surface, and on such as know nothing of each other."""
    surface = RoughSurface(hurst=0.8, rms=1e-6, size=1e-3, shortest=1e-9)
    for name, heights in (
        ("a rough line", rough_heights(surface, points=SPRINGS)),
        ("random heights", np.random.default_rng(0).normal(size=SPRINGS)),
    ):

        def ours(heights: np.ndarray = heights) -> object:
            return sorted_springs(heights, 1.0)

        def other(heights: np.ndarray = heights) -> object:
            return np.sort(heights)

        fast, slow = median_times(ours, other)
        yield Ratio(f"{SPRINGS:.0e} springs of {name}", "np.sort", fast, slow, "aim within 3 times as long")
