"""Springs with memory against passes over an array of as many numbers, and Ting's form against these springs."""

from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import follow_springs, ting
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation

ROWS, SINGLE, PASSES, SPRINGS = 100_000, 10_000, 50, 1000
DEEPEST = 1e-4
SERIES = mdr.Prony("1 MPa", ["1 MPa", "2 MPa", "0.5 MPa", "3 MPa"], ["1 ms", "10 ms", "0.1 s", "1 s"])
LINE = ElasticLine(equivalent_profile(mdr.Paraboloid("5 mm")), 1.0)


def forced(kernel: Relaxation) -> Iterator[Ratio]:
    """
    Forces and shifts, with their claims, against the springs of their rows alone.

    Indentations with their claims take ten times as long as these, so less is out of reach: loads are met by a search in parts of the
    rows, errors need half and a quarter of the springs, and the check of the disk follows the rows once more.
    """
    body = mdr.Viscoelastic(SERIES, poisson=0.5)
    rows = np.arange(1.0, SINGLE + 1.0)
    time, beating = 1e-3 * rows, 0.01 * (1.0 + 0.5 * np.sin(0.1 * rows))
    ball, joint = (
        mdr.Contact(mdr.Paraboloid("5 mm"), body, friction=law) for law in (None, mdr.Coulomb(0.3))
    )
    pressed = mdr.Path(time=time, normal_force=beating)
    sheared = mdr.Path(time=time, normal_force=np.full(SINGLE, 0.01), shift=0.5e-6 * np.sin(0.05 * rows))
    depth = mdr.solve(ball, pressed)["indentation"].values
    alone, first, second = median_times(
        lambda: follow_springs(LINE, kernel, time, depth, n=SPRINGS),
        lambda: mdr.solve(ball, pressed),
        lambda: mdr.solve(joint, sheared),
    )
    against = f"{SPRINGS} springs under the indentations of these rows"
    yield Ratio(f"{SINGLE:.0e} rows of an oscillating force", against, first, alone, "aim 30 times as long")
    yield Ratio(
        f"{SINGLE:.0e} rows of a shift under a constant force", against, second, alone, "aim 60 times as long"
    )


def ratios() -> Iterator[Ratio]:
    """A long history of many approaches and retreats; one approach and one retreat."""
    kernel = mdr.relaxation_of(mdr.Viscoelastic(SERIES, poisson=0.5))
    time = np.linspace(0.0, 10.0, ROWS + 1)[1:]
    depth = DEEPEST * (0.6 - 0.4 * np.cos(40.0 * time) * np.exp(-0.05 * time))
    numbers, other = np.random.default_rng(0).random((2, SPRINGS))

    def passes() -> None:
        for _ in range(ROWS // 100 * PASSES):
            np.multiply(numbers, 0.999, out=other)

    few = follow_springs(LINE, kernel, time[:1000], depth[:1000], n=SPRINGS).force
    many = follow_springs(LINE, kernel, time[:1000], depth[:1000], n=8 * SPRINGS).force
    reached = float(np.max(np.abs(few - many)) / np.max(many))
    ours, hundredth = median_times(lambda: follow_springs(LINE, kernel, time, depth, n=SPRINGS), passes)
    yield Ratio(
        f"{ROWS:.0e} rows of {SPRINGS} springs",
        f"{PASSES} passes of NumPy over {SPRINGS} numbers a row",
        ours,
        100.0 * hundredth,
        "aim no slower",
        f"err by {reached:.1g} of the force",
    )
    yield from forced(kernel)
    once = np.linspace(0.0, 1.0, SINGLE)
    pressed = DEEPEST * np.minimum(2.0 * once, 2.0 - 2.0 * once)
    fast, slow = median_times(
        lambda: ting(LINE, kernel, once, pressed),
        lambda: follow_springs(LINE, kernel, once, pressed, n=SPRINGS),
    )
    yield Ratio(f"{SINGLE:.0e} rows by Ting's form", f"{SPRINGS} springs", fast, slow, "aim within 1 s")
    yield from adhesive()


def adhesive() -> Iterator[Ratio]:
    """Load, dwell and retraction in 500 rows under a cohesive zone, against the same path of Maugis' elastic law."""
    body = mdr.Viscoelastic(mdr.Prony(0.25, [0.75] * 3, [0.1, 1.0, 10.0]), poisson=0.5)
    path = (
        mdr.indent(1.0, steps=200, duration=2.0)
        >> mdr.hold(5.0, steps=50)
        >> mdr.indent(-8.0, steps=250, duration=90.0)
    )
    still = mdr.indent(1.0, steps=200) >> mdr.hold(steps=50) >> mdr.indent(-8.0, steps=250)
    for strength in (0.3, 2.0, 6.0, 20.0):
        law = mdr.MaugisDugdale(1.0, strength=strength)
        soft, elastic = (
            mdr.Contact(mdr.Paraboloid(1.0), one, adhesion=law) for one in (body, mdr.Elastic(0.75, 0.5))
        )
        result = mdr.solve(soft, path)
        error = np.abs(result.claims["normal_force"].error * result["normal_force"].values)
        largest = np.abs(result["normal_force"].values).max()
        ours, other = median_times(lambda c=soft: mdr.solve(c, path), lambda c=elastic: mdr.solve(c, still))
        yield Ratio(
            f"500 rows, three relaxation times, strength {strength:g}",
            "Maugis' elastic law over these rows",
            ours,
            other,
            "aim 0.5 s",
            f"median error {np.median(error) / largest:.0e} of the largest force",
        )
