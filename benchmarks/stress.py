"""Maps of the stress under normal and tangential load against a direct double integral, and largest stresses of long paths."""

from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, compare
from pymdr.independent.point_loads import stress_of_tractions

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
SIDE = 256
DIRECT = 40
"""Nodes of the direct integral between two radii; points at less than half the contact radius need more."""


def maps() -> Iterator[Ratio]:
    """A map in section through a contact in partial slip."""
    result = mdr.solve(BALL, mdr.load("50 N") >> mdr.shift("0.5 um"))
    a, c = (float(result[name][-1]) for name in ("contact_radius", "stick_radius"))
    x, z = a * np.linspace(-2.0, 2.0, SIDE), a * np.linspace(0.5, 2.0, SIDE)
    sample = np.random.default_rng(0).choice(SIDE * SIDE, 64, replace=False)
    points = np.array([(x[i % SIDE], 0.0, z[i // SIDE]) for i in sample])

    def direct() -> np.ndarray:
        return stress_of_tractions(
            [c, a],
            lambda r: result.field("pressure", r).values,
            lambda r: result.field("shear_traction", r).values,
            points,
            0.3,
            n=DIRECT,
        )

    found = result.field("stress", x=x, z=z).values.reshape(6, -1)[:, sample]
    error = np.max(np.abs(found - direct())) / float(result["peak_pressure"][-1])
    ratio = compare(
        f"stress at {SIDE} x {SIDE} points in partial slip",
        lambda: result.field("stress", x=x, z=z),
        f"a direct double integral at {sample.size} of them, times {SIDE * SIDE // sample.size}",
        direct,
        f"largest difference {error:.1e} of the peak pressure; aim 0.15 s on one core",
    )
    yield Ratio(ratio.what, ratio.against, ratio.ours, ratio.other * SIDE * SIDE / sample.size, ratio.aim)


def largest() -> Iterator[Ratio]:
    """The largest von Mises stress of a thousand rows."""
    contact = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    path = mdr.load("50 N", steps=1000)

    def rows() -> object:
        return mdr.solve(contact, path).largest("von_mises")

    result = mdr.solve(contact, path)
    a = float(result["contact_radius"][-1])
    grid = {"r": np.linspace(0.0, 1.5 * a, 100), "z": np.linspace(0.0, 1.5 * a, 100)}
    yield compare(
        "the largest von Mises stress of 1000 rows, to 1e-8",
        rows,
        "that on a grid of 100 x 100 points, to about 1e-4, in 10 rows",
        lambda: [result.field("von_mises", step=i, **grid).max() for i in range(99, 1000, 100)],
        "aim 1 s",
        repeats=3,
    )


def ratios() -> Iterator[Ratio]:
    yield from maps()
    yield from largest()
