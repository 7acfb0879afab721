"""Contacts on layers: single ones against the textbook's quadrature and against rings, and long paths against half-spaces."""

import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
from scipy.integrate import quad
from scipy.linalg import cho_factor, cho_solve

import pymdr as mdr
from benchmarks.timing import REPEATS, Ratio, compare, median_times
from pymdr.independent.rings import solve_indentation
from pymdr.independent.stacks import stack_of
from pymdr.line.layered.equation import Outline, numbers, solve_contact
from pymdr.line.layered.tiles import solve_positive
from pymdr.line.lines import _layered, line_of
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import kernel_of
from pymdr.numerics.panels import as_place

FILM = mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.5), 1.0)])


def textbook_stiffness(a, n):
    """k / (2 E* a) by n Gauss nodes on [0, a] and an adaptive quadrature for every value of the kernel."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    x, w = 0.5 * a * (nodes + 1.0), 0.5 * a * weights

    def shortfall(s):
        e = np.exp(-2.0 * s)
        return 2.0 * e * (e + 1.0 + 2.0 * s * s + 2.0 * s) / (1.0 + e * e + (2.0 + 4.0 * s * s) * e)

    def kernel(t):
        return quad(shortfall, 0.0, 25.0, weight="cos", wvar=t)[0]

    pairs = np.array([[kernel(abs(p - q)) + kernel(p + q) for q in x] for p in x]) / np.pi
    return float(w @ np.linalg.solve(np.eye(n) - pairs * w, np.ones(n))) / a


def single() -> Iterator[Ratio]:
    g, kernel = equivalent_profile(mdr.Paraboloid(1.0)), kernel_of(FILM)

    def ours(a):
        outline = Outline(g, 1.0, as_place(np.array([a])))
        return numbers(solve_contact(kernel, outline)[0], outline)

    for a, n in ((1.0, 8), (4.0, 16)):
        error = abs(ours(a)[0] / textbook_stiffness(a, n) - 1.0)
        yield compare(
            f"a contact of a/h = {a:g}",
            lambda a=a: ours(a),
            f"{n} nodes, the kernel by quad",
            lambda a=a, n=n: textbook_stiffness(a, n),
            "aim 5 ms",
            f"differ by {error:.0e}",
        )
    for a, aim in ((10.0, "aim 5 ms"), (100.0, "aim 50 ms")):
        yield compare(
            f"a contact of a/h = {a:g}", lambda a=a: ours(a), "one of a/h = 1", lambda: ours(1.0), aim
        )


def cpu_time(work: Callable[[], object]) -> float:
    """Median CPU time of a call in seconds, of all threads together."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def with_other_work() -> Iterator[Ratio]:
    """CPU time of a wide contact while other processes keep all cores busy: threads that wait for one another would spin."""
    g, kernel = equivalent_profile(mdr.Paraboloid(1.0)), kernel_of(FILM)
    outline = Outline(g, 1.0, as_place(np.array([100.0])))
    half = np.random.default_rng(0).normal(size=(700, 700))
    matrix, right = half @ half.T / 700 + np.eye(700), np.ones((700, 2))

    def contact():
        return solve_contact(kernel, outline)

    def tiles():
        return solve_positive(matrix, right)

    def library():
        return cho_solve(cho_factor(matrix), right)

    works = (contact, tiles, library)
    for work in works:
        work()
    alone = [cpu_time(work) for work in works]
    others = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)
    ]
    try:
        busy = [cpu_time(work) for work in works]
    finally:
        for other in others:
            other.kill()
            other.wait()
    aim = "CPU time, aim at most 1.5 times as long"
    yield Ratio("a contact of a/h = 100 beside other work", "alone", busy[0], alone[0], aim)
    against = "by a linear algebra library with threads"
    yield Ratio("700 unknowns in tiles beside other work", against, busy[1], busy[2], "CPU time, no aim")


def against_rings() -> Iterator[Ratio]:
    """A contact by solve() with all its claims, and by so many rings that the force is as close as asked."""
    accuracy, tip, stack = 1e-6, mdr.Paraboloid(1.0), stack_of(FILM)
    contact = mdr.Contact(tip, FILM)
    line = line_of(contact)
    for a in (1.0, 4.0, 10.0):
        depth, force = (float(f(np.array([a]))[0]) for f in (line.depth, line.force))

        def rings(n, a=a, depth=depth):
            return solve_indentation(
                tip.gap, depth, line.modulus, max_radius=2.0 * a, n=n, surface=stack
            ).force

        # the error falls with the third power of their number
        n = max(20, math.ceil(100 * (abs(rings(100) / force - 1.0) / accuracy) ** (1 / 3)))
        against = f"so many rings that the force is {accuracy:.0e} off"
        note = f"{n} rings, force {abs(rings(n) / force - 1.0):.0e} off"

        def known(depth=depth):
            return mdr.solve(contact, mdr.indent(depth))

        def anew(depth=depth):
            _layered.cache_clear()
            return mdr.solve(contact, mdr.indent(depth))

        first, again, other = median_times(anew, known, lambda n=n, rings=rings: rings(n))
        yield Ratio(f"solve() of a/h = {a:g}, its line made anew", against, first, other, "no aim", note)
        yield Ratio(f"solve() of a/h = {a:g}, its line known", against, again, other, "no aim", note)


def paths() -> Iterator[Ratio]:
    ball, path = mdr.Sphere("10 mm"), mdr.load("1 N", steps=10_000)
    film = mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.45), "1 mm")])
    layered, plain = (mdr.Contact(ball, one) for one in (film, mdr.Elastic("1 MPa", 0.45)))
    yield compare(
        "10 000 rows on a layer, after the first solution",
        lambda: mdr.solve(layered, path),
        "on a half-space",
        lambda: mdr.solve(plain, path),
        "aim at most 20 times as long",
    )


def maps() -> Iterator[Ratio]:
    """Stress on 256 x 256 points in a coat and its base, beside a half-space."""
    steel = mdr.Elastic("210 GPa", 0.3)
    for thickness in ("50 um", "2 um"):
        coat = mdr.Layered([mdr.Layer(mdr.Elastic("400 GPa", 0.2), thickness)], base=steel)
        layered, plain = (
            mdr.solve(mdr.Contact(mdr.Sphere("5 mm"), body, steel), mdr.load("20 N"))
            for body in (coat, steel)
        )
        a = float(layered["contact_radius"][-1])
        points = a * np.linspace(0.0, 2.0, 256)
        yield compare(
            f"a map of stress in a coat, a/h = {a / layered.contact.body.thickness:.1f}",
            lambda result=layered, points=points: result.field("stress", r=points, z=points),
            "in a half-space",
            lambda result=plain, points=points: result.field("stress", r=points, z=points),
            "no aim",
        )


def ratios() -> Iterator[Ratio]:
    yield from single()
    yield from with_other_work()
    yield from against_rings()
    yield from paths()
    yield from maps()
