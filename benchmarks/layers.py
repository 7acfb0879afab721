"""Contacts on layers: single ones against the textbook's quadrature, and long paths against half-spaces."""

from collections.abc import Iterator

import numpy as np
from scipy.integrate import quad

import pymdr as mdr
from benchmarks.timing import Ratio, compare
from pymdr.line.layered.equation import Outline, numbers, solve_contact
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import kernel_of
from pymdr.mapping.series import as_place

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
            f"a contact of a/h = {a:g} (differ by {error:.0e})",
            lambda a=a: ours(a),
            f"{n} nodes, the kernel by quad",
            lambda a=a, n=n: textbook_stiffness(a, n),
            "aim 5 ms",
        )
    for a, aim in ((10.0, "aim 5 ms"), (100.0, "aim 50 ms")):
        yield compare(
            f"a contact of a/h = {a:g}", lambda a=a: ours(a), "one of a/h = 1", lambda: ours(1.0), aim
        )


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


def ratios() -> Iterator[Ratio]:
    yield from single()
    yield from paths()
