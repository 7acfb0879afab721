"""Adhesion of bodies with memory: curves of load, dwell and retraction against the same rows without memory, a short range against a zone, and 100 speeds."""

from collections.abc import Iterator
from functools import partial
from math import pi

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times

RADIUS, WORK, RELAXED = 1e-3, 0.1, 1e6
"""Radius in m, work in J/m^2 and relaxed E* in Pa."""
SERIES = mdr.Prony("0.25 MPa", ["1 MPa", "0.75 MPa", "0.5 MPa"], ["0.05 s", "0.5 s", "5 s"])
RUBBER, SLOW = mdr.Viscoelastic(SERIES, poisson=0.5), mdr.Elastic(0.75 * RELAXED, poisson=0.5)
SPEEDS = np.geomspace(1e-7, 1e-3, 100)


def strength(parameter: float) -> float:
    """Strength in Pa of Maugis' parameter sigma0 (9 R/(2 pi w E*^2))^(1/3)."""
    return float(parameter / (9.0 * RADIUS / (2.0 * pi * WORK * RELAXED**2)) ** (1.0 / 3.0))


def ball(law: mdr.MaugisDugdale | mdr.JKR, body: mdr.Viscoelastic | mdr.Elastic = RUBBER) -> mdr.Contact:
    """A ball on a body."""
    return mdr.Contact(mdr.Sphere(RADIUS), body, adhesion=law)


def ratios() -> Iterator[Ratio]:
    """Curves of 500 rows, from long to short zones; then a pull-off at each of 100 speeds."""
    there = mdr.indent("20 um", steps=150, duration="1 s") >> mdr.hold("2 s", steps=100)
    path = there >> mdr.indent("-30 um", steps=250, duration="3 s")
    for tolerance, aim in ((1e-4, "aim 0.5 s"), (1e-5, "aim 2 s")):
        for parameter in (0.1, 0.3, 1.0, 3.0, 10.0, 20.0):
            contact, elastic = (
                ball(mdr.MaugisDugdale(WORK, strength=strength(parameter)), one) for one in (RUBBER, SLOW)
            )
            result = mdr.solve(contact, path, tolerance=tolerance)
            force, error = result["normal_force"].values, result.claims["normal_force"].error
            claimed = float(np.max(np.abs(error * force)[error < 1.0]) / np.abs(force).max())
            soft, other = median_times(
                lambda contact=contact, tolerance=tolerance: mdr.solve(contact, path, tolerance=tolerance),
                lambda elastic=elastic: mdr.solve(elastic, path),
            )
            yield Ratio(
                f"500 rows with three terms, Maugis' parameter {parameter:g}, tolerance {tolerance:g}",
                "elastic bodies along the same rows",
                soft,
                other,
                aim,
                f"{soft:.2f} s, claimed to {claimed:.0e} of the largest force",
            )
    zone = mdr.MaugisDugdale(WORK, strength=strength(5.0))
    short = mdr.JKR(WORK, range=WORK / strength(5.0))
    quick, slow = median_times(lambda: mdr.solve(ball(short), path), lambda: mdr.solve(ball(zone), path))
    yield Ratio("500 rows of short range", "the zone of that length", quick, slow, "aim 0.04 s")

    def swept(speeds: np.ndarray) -> object:
        paths = [there >> mdr.indent("-30 um", steps=250, rate=speed) for speed in speeds]
        return mdr.sweep(ball(zone), paths[0], {"path": paths}, workers=2)

    def pulled(speeds: np.ndarray) -> object:
        return mdr.pull_off_curve(
            ball(zone), speed=speeds, dwell="5 s", preload="2 mN", approach_speed="10 um/s", workers=2
        )

    for what, work in (("one sweep over 100 speeds", swept), ("pull-off at 100 speeds", pulled)):
        many, few = median_times(partial(work, SPEEDS), partial(work, SPEEDS[40:60:10]))
        yield Ratio(f"{what}, processor time of two cores", "two speeds", many, few, "aim 120 s")
