"""The tables of the friction kernels: right relative to their size at every depth, whatever a(d) is like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.friction import (
    Ending,
    depths_at_force,
    evaluate,
    follow_displacements,
    follow_forces,
    follow_indentation_with_force,
    follow_load_with_shift,
    power_law_curves,
    tabulated_curves,
)

few = settings(max_examples=60, deadline=None)


@dataclass(frozen=True)
class Radius:
    """a(d) = L [b + sum c x^p + sum over marks of (jump + c z^q) for d >= d_j], x = d / L, z = (d - d_j) / L.

    From the first mark on the sum of powers may rest.
    """

    length: float
    plateau: float
    powers: tuple[tuple[float, float], ...]
    marks: tuple[tuple[float, float, float, float], ...]
    """(d_j / L, jump, c, q)"""
    rests: bool = False

    @property
    def depths(self):
        return np.array([self.length * mark[0] for mark in self.marks])

    def exact(self, d):
        """a, F_N and W for E* = 1 in extended precision."""
        one = np.longdouble(1.0)
        d, length = np.asarray(d) * one, self.length * one
        stop = self.depths[0] if self.rests else np.inf
        x, after = np.minimum(d, stop) / length, np.maximum(d - stop, 0.0) / length if self.rests else 0.0 * d
        parts = [self.plateau * x**i / (1.0, 1.0, 2.0)[i] for i in range(3)]
        for c, p in self.powers:
            grown = c * x ** (p * one)
            parts = [parts[0] + grown, parts[1] + grown * x / (p + one), parts[2] + grown * x**2 / (p + one) / (p + 2 * one)]
        a, force, work = parts
        a, force, work = a, force + a * after, work + force * after + a * after**2 / 2
        for depth, (_, jump, c, q) in zip(self.depths, self.marks, strict=True):
            z = np.maximum(d - depth, 0.0) / length
            here = np.where(d >= depth, jump + c * z ** (q * one), 0.0)
            a = a + here
            force = force + jump * z + c * z ** (q * one) * z / (q + one)
            work = work + jump * z**2 / 2 + c * z ** (q * one) * z**2 / (q + one) / (q + 2 * one)
        return np.stack([length * a, 2 * length**2 * force, 2 * length**3 * work])

    def __call__(self, d):
        stop = self.depths[0] if self.rests else np.inf
        x = np.minimum(d, stop) / self.length
        a = np.full_like(x, self.plateau)
        for c, p in self.powers:
            a += c * x**p
        for depth, (_, jump, c, q) in zip(self.depths, self.marks, strict=True):
            a += np.where(d >= depth, jump + c * (np.maximum(d - depth, 0.0) / self.length) ** q, 0.0)
        return self.length * a

    def table(self, deepest, **options):
        return tabulated_curves(self, deepest * self.length, 1.0, marks=self.depths, **options)

    def points(self, deepest):
        """Depths over 25 decades, everywhere, and on both sides of the marks."""
        beside = np.concatenate([10.0 ** -np.linspace(0.5, 9.0, 30), -(10.0 ** -np.linspace(0.5, 15.0, 30))])
        ends = [depth * (1.0 + beside) for depth in self.depths]
        d = np.concatenate([10.0 ** -np.linspace(0.0, 25.0, 251), np.linspace(0.0, 1.0, 301)[1:]])
        d = np.concatenate([d * deepest * self.length, *ends])
        return d[(d > 0.0) & (d <= deepest * self.length)]


sizes = st.floats(-3.0, 1.0).map(lambda x: 10.0**x)
places = st.floats(-6.0, -0.01).map(lambda x: 10.0**x)
exponents = st.floats(0.3, 4.0)
profiles = st.floats(0.3, 40.0).map(lambda n: 1.0 / n)
lengths = st.sampled_from([1e-12, 3e-9, 1.0, 1e6])


@st.composite
def radii(draw):
    powers = draw(st.lists(st.tuples(sizes, st.one_of(profiles, st.sampled_from([0.5, 1.0]))), min_size=1, max_size=3))
    places_of = sorted(draw(st.lists(places, max_size=4, unique=True)))
    if places_of and draw(st.booleans()):
        places_of.append(places_of[-1] * (1.0 + draw(st.sampled_from([1e-3, 1e-6, 1e-9]))))
    marks = tuple((x, draw(st.sampled_from([0.0, 0.0, 0.3])), draw(sizes), draw(exponents)) for x in places_of)
    plateau = draw(st.sampled_from([0.0, 0.0, 1e-3, 1.0]))
    return Radius(draw(lengths), plateau, tuple(powers), marks, bool(marks) and draw(st.booleans()))


@few
@given(radii())
@example(Radius(1.0, 0.0, ((1.0, 0.5), (1e-6, 1.0 / 3.3)), ()))
@example(Radius(1e-9, 0.5, ((1.0, 2.0 / 3.0),), ()))
@example(Radius(1.0, 0.0, ((1.0, 0.5),), ((0.25, 0.0, 1.0, 0.3), (0.5, 1.0, 0.0, 1.0)), True))
def test_tables_are_right_at_every_depth(radius):
    curves = radius.table(1.0)
    d = radius.points(1.0)
    for exact, found in zip(radius.exact(d), evaluate(curves, d), strict=True):
        np.testing.assert_allclose(found, exact.astype(float), rtol=1e-12, atol=0.0)
    assert curves.misfit <= 1e-12
    force = evaluate(curves, d)[1]
    back = depths_at_force(curves, force)
    np.testing.assert_allclose(back, d, rtol=1e-14, atol=0.0)
