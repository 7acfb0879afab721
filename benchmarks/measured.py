"""Sampled profiles against the plain trapezoidal rule, and one solution against one by rings."""

from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, compare
from pymdr.mapping.equivalent import PanelLine
from pymdr.mapping.sources import source_of

POINTS = np.linspace(0.011, 0.99, 200)


def profile(r):
    return r**2 / 2 + 0.1 * r**4


def exact(x):
    return x**2 + 0.1 * 8 / 3 * x**4


def by_spline(n):
    r = np.linspace(0.0, 1.0, n)
    tip = mdr.Sampled(r, profile(r))
    # a map of its own: equivalent_profile gives equal samples the map that it has
    return PanelLine(source_of(tip)).g(POINTS)


def by_trapezoid(n):
    """g(x) = x int f' / sqrt(x^2 - r^2) dr on the samples below x, f' by differences: what scripts do."""
    r = np.linspace(0.0, 1.0, n)
    slope = np.gradient(profile(r), r)
    g = np.empty(POINTS.size)
    for i, x in enumerate(POINTS):
        below = r < x
        g[i] = x * np.trapezoid(slope[below] / np.sqrt(x * x - r[below] ** 2), r[below])
    return g


def error(g):
    return float(np.max(np.abs(g / exact(POINTS) - 1.0)))


def samples() -> Iterator[Ratio]:
    n = 100_000
    coarse, fine = error(by_trapezoid(n)), error(by_spline(n))
    equal = next(k for k in range(5, n) if error(by_spline(k)) <= coarse)
    plain = f"the trapezoidal rule on {n} samples"
    note = f"error {{:.0e}}, of the rule {coarse:.0e}".format
    yield compare(
        "map samples to 200 points, as accurate",
        lambda: by_spline(equal),
        plain,
        lambda: by_trapezoid(n),
        "equal accuracy",
        f"{equal} samples, {note(error(by_spline(equal)))}",
    )
    yield compare(
        f"map {n} samples to 200 points",
        lambda: by_spline(n),
        plain,
        lambda: by_trapezoid(n),
        "equal samples",
        note(fine),
    )


def rings() -> Iterator[Ratio]:
    contact = mdr.Contact(mdr.Paraboloid(1.0) + mdr.Cone(slope=0.1), mdr.Elastic(0.75, 0.5))
    path = mdr.indent(0.1)
    force = float(mdr.solve(contact, path)["normal_force"][0])
    n = next(
        n
        for n in (50, 100, 200, 400, 800)
        if abs(float(mdr.solve(contact, path, solver=mdr.Rings(n))["normal_force"][0]) / force - 1) < 1e-7
    )
    yield compare(
        "one solution by MDR",
        lambda: mdr.solve(contact, path),
        f"{n} rings, whose force agrees to 1e-7",
        lambda: mdr.solve(contact, path, solver=mdr.Rings(n)),
        "MDR itself errs by 1e-15",
    )


def ratios() -> Iterator[Ratio]:
    yield from samples()
    yield from rings()
