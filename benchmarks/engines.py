"""Boundary elements of the packages that are installed, on Hertz's contact, against the default one; their errors are printed."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.timing import Ratio, median_times
from pymdr.errors import MissingExtraError
from pymdr.independent.engines import DEFAULT, engine_names, find_engine

PIXELS, RADIUS = 256, 0.3


def _rough() -> tuple[np.ndarray, float]:
    """A self-affine surface, H = 0.8, and a depth of some rms that 3 % of the pixels touch."""
    q = np.hypot(*np.meshgrid(*2 * (np.fft.fftfreq(PIXELS, 1 / PIXELS),)))
    fraction = np.where((q > 0) & (q <= PIXELS / 8), np.maximum(q, 4.0) ** -1.8, 0.0)
    noise = np.fft.fft2(np.random.default_rng(3).standard_normal(q.shape))
    heights = np.fft.ifft2(noise * fraction).real
    return PIXELS * heights / heights.std(), 2.0 * PIXELS


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
        computed = half_space.press(heights, force=force)
        off = float(np.max(np.abs(computed.pressure - exact)[inside])) / (2.0 / math.pi * RADIUS)
        depth = (computed.indentation - heights.max()) / (RADIUS**2 * PIXELS) - 1.0
        print(f"{name}: depth {depth:+.1e}, pressure {off:.1e}, {computed.iterations} iterations")
        solved[name] = half_space
    rough, depth = _rough()
    for name, half_space in solved.items():
        if name == DEFAULT or DEFAULT not in solved:
            continue
        load = float(solved[DEFAULT].press(rough, indentation=depth).pressure.sum())
        for what, surface, how in (
            ("Hertz under a force", heights, {"force": force}),
            ("a rough surface under a force", rough, {"force": load}),
            ("a rough surface at a depth", rough, {"indentation": depth}),
        ):
            ours, other = (partial(one.press, surface, **how) for one in (solved[DEFAULT], half_space))
            fast, slow = median_times(ours, other)
            words = f"{what}, {PIXELS} x {PIXELS} pixels by {DEFAULT}"
            yield Ratio(words, name, fast, slow, "aim no slower")
