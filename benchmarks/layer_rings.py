"""Contacts of a layer on its line against boundary elements on rings, at equal accuracy."""

import math
from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_time
from pymdr.independent.rings import solve_indentation
from pymdr.independent.stacks import stack_of
from pymdr.line.lines import _layered, line_of

FILM = mdr.Layered([mdr.Layer(mdr.Elastic(0.75, 0.5), 1.0)])
BALL = mdr.Paraboloid(1.0)
CONTACT = mdr.Contact(BALL, FILM)
ACCURACY = 1e-6


def by_rings(depth: float, radius: float, n: int) -> float:
    found = solve_indentation(BALL.gap, depth, 1.0, reach=2.0 * radius, n=n, surface=stack_of(FILM))
    return found.force


def rings_needed(depth: float, radius: float, force: float) -> int:
    """Rings whose force is as close as asked, by their order, which is three."""
    error = abs(by_rings(depth, radius, 100) / force - 1.0)
    return min(max(20, math.ceil(100 * (error / ACCURACY) ** (1 / 3))), 5000)


def states() -> Iterator[Ratio]:
    """One contact of a bonded incompressible layer, from nothing and with its line known."""
    line = line_of(CONTACT)
    for radius in (1.0, 4.0, 10.0):
        depth, force = (float(f(np.array([radius]))[0]) for f in (line.depth, line.force))
        n = rings_needed(depth, radius, force)
        path = mdr.indent(depth)

        def known(path=path):
            return mdr.solve(CONTACT, path)

        def anew(path=path):
            _layered.cache_clear()
            return mdr.solve(CONTACT, path)

        def rings(depth=depth, radius=radius, n=n):
            return by_rings(depth, radius, n)

        error = abs(rings() / force - 1.0)
        against = f"{n} rings, whose force is {error:.0e} off"
        slow = median_time(rings, 1)
        yield Ratio(
            f"one contact of a/h = {radius:g}, line and table anew",
            against,
            median_time(anew, 3),
            slow,
            "no aim",
        )
        yield Ratio(
            f"one contact of a/h = {radius:g}, the line known", against, median_time(known, 5), slow, "no aim"
        )


def ratios() -> Iterator[Ratio]:
    yield from states()
