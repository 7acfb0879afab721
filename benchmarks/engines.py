"""Boundary elements of the packages that are installed, on Hertz's contact, against the default one; their errors are printed."""

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, median_times
from pymdr.errors import MissingExtraError
from pymdr.independent.engines import DEFAULT, engine_names, find_engine

PIXELS, RADIUS = 256, 0.3


def ratios() -> Iterator[Ratio]:
    """A paraboloid of R = 1 on a side of 1 at a = 0.3 under its force, E* = 1."""
    x = (np.arange(PIXELS) + 0.5) / PIXELS - 0.5
    square = x[:, None] ** 2 + x**2
    heights = -0.5 * square * PIXELS
    force = 4.0 / 3.0 * RADIUS**3 * PIXELS**2
    inside = square < (0.9 * RADIUS) ** 2
    exact = 2.0 / math.pi * np.sqrt(np.maximum(RADIUS**2 - square, 0.0))
    solved = {}
    for name in engine_names():
        try:
            half_space = find_engine(name).half_space((PIXELS, PIXELS), (1.0, 1.0))
        except MissingExtraError as missing:
            print(missing)
            continue
        found = half_space.press(heights, force=force)
        off = float(np.max(np.abs(found.pressure - exact)[inside])) / (2.0 / math.pi * RADIUS)
        depth = (found.indentation - heights.max()) / (RADIUS**2 * PIXELS) - 1.0
        print(f"{name}: depth {depth:+.1e}, pressure {off:.1e}, {found.iterations} iterations")
        solved[name] = half_space
    for name, half_space in solved.items():
        if name == DEFAULT or DEFAULT not in solved:
            continue

        def ours() -> object:
            return solved[DEFAULT].press(heights, force=force)

        def other(half_space: object = half_space) -> object:
            return half_space.press(heights, force=force)  # type: ignore[attr-defined]

        fast, slow = median_times((ours, 3), (other, 3))
        yield Ratio(f"{PIXELS} x {PIXELS} pixels by {DEFAULT}", name, fast, slow, "no aim")
