"""The tables of the friction kernels: right relative to their size at every depth, whatever a(d) is like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drawing import examples
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

few = settings(max_examples=examples(60), deadline=None)


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
            parts = [
                parts[0] + grown,
                parts[1] + grown * x / (p + one),
                parts[2] + grown * x**2 / (p + one) / (p + 2 * one),
            ]
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
        nearby = np.concatenate([10.0 ** -np.linspace(0.5, 9.0, 30), -(10.0 ** -np.linspace(0.5, 15.0, 30))])
        ends = [depth * (1.0 + nearby) for depth in self.depths]
        d = np.concatenate([10.0 ** -np.linspace(0.0, 25.0, 251), np.linspace(0.0, 1.0, 301)[1:]])
        d = np.concatenate([d * deepest * self.length, *ends])
        return d[(d > 0.0) & (d <= deepest * self.length)]


sizes = st.floats(-3.0, 1.0).map(lambda x: 10.0**x)
places = st.floats(-6.0, -0.01).map(lambda x: 10.0**x)
exponents = st.floats(0.3, 4.0)
profiles = st.one_of(st.floats(0.3, 40.0), st.floats(0.3, 40.0).map(lambda n: 1.0 / n))
lengths = st.sampled_from([1e-12, 3e-9, 1.0, 1e6])


@st.composite
def radii(draw):
    powers = draw(
        st.lists(st.tuples(sizes, st.one_of(profiles, st.sampled_from([0.5, 1.0]))), min_size=1, max_size=3)
    )
    places_of = sorted(draw(st.lists(places, max_size=4, unique=True)))
    if places_of and draw(st.booleans()):
        places_of.append(places_of[-1] * (1.0 + draw(st.sampled_from([1e-3, 1e-6, 1e-9]))))
    marks = tuple(
        (x, draw(st.sampled_from([0.0, 0.0, 0.3])), draw(sizes), draw(exponents)) for x in places_of
    )
    plateau = draw(st.sampled_from([0.0, 0.0, 1e-3, 1.0]))
    return Radius(draw(lengths), plateau, tuple(powers), marks, bool(marks) and draw(st.booleans()))


@few
@given(radii())
@example(Radius(1.0, 0.0, ((1.0, 0.5), (1e-6, 1.0 / 3.3)), ()))
@example(Radius(1e-9, 0.5, ((1.0, 2.0 / 3.0),), ()))
@example(Radius(1e-12, 0.0, ((1.0, 16.0), (1.0, 17.0)), ()))
@example(Radius(1e6, 0.0, ((0.24, 7.3), (2.2, 18.3)), ((7.5e-6, 0.0, 9.3e-3, 2.53),)))
@example(Radius(1.0, 0.0, ((1.0, 0.5),), ((0.25, 0.0, 1.0, 0.3), (0.5, 1.0, 0.0, 1.0)), True))
def test_tables_are_right_at_every_depth(radius):
    curves = radius.table(1.0)
    d = radius.points(1.0)
    d = d[radius.exact(d)[2] > 1e-250]
    for exact, computed in zip(radius.exact(d), evaluate(curves, d), strict=True):
        np.testing.assert_allclose(computed, exact.astype(float), rtol=1e-12, atol=0.0)
    assert curves.misfit <= 1e-12
    force = evaluate(curves, d)[1]
    back = depths_at_force(curves, force)
    np.testing.assert_allclose(back, d, rtol=1e-14, atol=0.0)


# --- the whole stack: deep, and back to next to nothing -----------------------------------------------------------

levels = st.sampled_from([1.0, 1.0, 1e-2, 1e-8, 1e-12, 1e-20])
heights = st.lists(st.tuples(levels, st.floats(0.3, 1.0), st.floats(-1.2, 1.2)), min_size=2, max_size=12)
follows = st.sampled_from(["level", "deep", "walk"])


def history(rows, how, length, slide):
    """Depths that go down and come back, shifts in the size of the depth, of the deepest, or added up."""
    level, part, ratio = np.array(rows).T
    level[0] = 1.0
    d = length * level * part
    u = ratio * slide * (d if how != "deep" else length)
    return d, np.cumsum(u) if how == "walk" else u


def sizes_at(curves, d, mu, tangential):
    """mu F_N and an energy of its size, row by row."""
    limit = mu * evaluate(curves, d)[1]
    return limit, limit * mu * curves.modulus / tangential * d


@few
@given(
    heights, follows, st.sampled_from([0.3, 0.5, 1.0, 2.0, 4.0, 40.0]), lengths, st.sampled_from([1e-3, 2e11])
)
def test_a_history_that_goes_deep_and_comes_back_is_that_of_the_closed_form(rows, how, n, length, modulus):
    mu, tangential = 0.3, 0.8 * modulus
    closed = power_law_curves(n, length, modulus, unit=length)
    table = tabulated_curves(lambda d: length * (d / length) ** (1.0 / n), length, modulus)
    d, u = history(rows, how, length, mu / 0.8)
    limit, energy = sizes_at(closed, d, mu, tangential)
    exact, results = (follow_displacements(curves, d, u, mu, tangential) for curves in (closed, table))
    assert np.all(np.abs(results.tangential_force) <= mu * evaluate(table, d)[1] * (1.0 + 1e-12))
    assert np.all(np.abs(results.tangential_force - exact.tangential_force) <= 1e-11 * limit)
    assert np.all(np.abs(results.stored_energy - exact.stored_energy) <= 1e-11 * energy)
    assert np.all(np.abs(results.slip_work - exact.slip_work) <= 1e-11 * np.maximum.accumulate(energy))
    assert np.all(results.stored_energy >= 0.0)
    assert np.all(np.diff(results.slip_work, prepend=0.0) >= -1e-14 * np.maximum.accumulate(energy))
    np.testing.assert_allclose(
        results.stick_radius, exact.stick_radius, rtol=1e-11, atol=1e-12 * exact.stick_radius.max()
    )


@few
@given(heights, st.sampled_from([0.3, 0.5, 1.0, 2.0, 4.0, 40.0]), lengths)
def test_forces_that_come_back_to_next_to_nothing_are_those_of_the_closed_form(rows, n, length):
    mu, modulus, tangential = 0.3, 2.0, 1.6
    closed = power_law_curves(n, length, modulus, unit=length)
    table = tabulated_curves(lambda d: length * (d / length) ** (1.0 / n), length, modulus)
    d = history(rows, "level", length, 0.0)[0]
    limit, energy = sizes_at(closed, d, mu, tangential)
    pull = limit * np.array(rows)[:, 2] / 1.3
    # where a force is given with a depth or a shift, what is as small as the rounding of the deepest is not known
    deepest = np.maximum.accumulate(d)
    coarse = 1e-14 * limit * deepest
    for follow, normal, rounding in (
        (follow_forces, limit / mu, 0.0),
        (follow_indentation_with_force, d, coarse),
    ):
        exact, results = (follow(curves, normal, pull, mu, tangential) for curves in (closed, table))
        assert results.ending is Ending.COMPLETE
        np.testing.assert_allclose(results.indentation, exact.indentation, rtol=1e-13)
        assert np.all(np.abs(results.shift - exact.shift) <= 1e-11 * deepest)
        assert np.all(np.abs(results.stored_energy - exact.stored_energy) <= 1e-11 * energy + rounding)
        assert np.all(np.abs(results.slip_work - exact.slip_work) <= 1e-11 * np.maximum.accumulate(energy))
    shift = mu / 0.8 * d * np.array(rows)[:, 2]
    exact, results = (
        follow_load_with_shift(curves, limit / mu, shift, mu, tangential) for curves in (closed, table)
    )
    coarse = 1e-14 * 2.0 * tangential * evaluate(closed, d)[0] * deepest
    assert np.all(np.abs(results.tangential_force - exact.tangential_force) <= 1e-11 * limit + coarse)


@few
@given(radii(), heights, follows)
def test_friction_stays_below_its_limit_on_any_table(radius, rows, how):
    table = radius.table(1.0)
    d, u = history(rows, how, radius.length, 0.3 / 0.8)
    run = follow_displacements(table, d, u, 0.3, 0.8)
    limit, energy = sizes_at(table, d, 0.3, 0.8)
    assert run.ending is Ending.COMPLETE
    assert np.all(np.abs(run.tangential_force) <= limit * (1.0 + 1e-12))
    assert np.all(run.stored_energy >= 0.0)
    assert np.all(np.diff(run.slip_work, prepend=0.0) >= -1e-13 * np.maximum.accumulate(energy))


# --- what they are made of ------------------------------------------------------------------------------------------


class Counted:
    """A contact radius that counts how often it is asked."""

    def __init__(self, radius):
        self.radius, self.count = radius, 0

    def __call__(self, d):
        self.count += d.size
        return self.radius(d)


@pytest.mark.parametrize(
    "radius", [np.sqrt, lambda d: np.sqrt(d * (2.0 - d)), lambda d: np.sqrt(d) + d, lambda d: 0.2 + d]
)
def test_smooth_profiles_need_few_radii(radius):
    counted = Counted(radius)
    curves = tabulated_curves(counted, 0.9, 1.0)
    assert counted.count < 15_000
    assert curves.misfit < 5e-14


def test_hundreds_of_marks():
    """A measured tip: knots at which a(d) is hardly rough, or rough."""
    rng = np.random.default_rng(1)
    depths = np.sort(rng.uniform(1e-4, 1.0, 300))
    for scale, most in ((1e-5, 600_000), (1e-1, 1_500_000)):
        marks = tuple(
            (x, 0.0, c, q)
            for x, c, q in zip(
                depths, scale * rng.uniform(size=300), rng.choice([1.5, 2.5, 3.0], 300), strict=True
            )
        )
        counted = Counted(Radius(1.0, 0.0, ((1.0, 0.5),), marks))
        curves = tabulated_curves(counted, 1.0, 1.0, marks=depths)
        assert counted.count < most
        d = np.concatenate(
            [rng.uniform(0.0, 1.0, 1000), depths[::10] * (1.0 + 1e-9), 10.0 ** -np.linspace(0, 25, 100)]
        )
        for exact, computed in zip(counted.radius.exact(d), evaluate(curves, d), strict=True):
            np.testing.assert_allclose(computed, exact.astype(float), rtol=1e-12, atol=0.0)


def test_marks_equal_in_floats_count_once():
    marks = [0.5, np.nextafter(0.5, 1.0), 0.0, -1.0, 2.0, 1.0, np.nextafter(1.0, 0.0), 1e-300]
    curves = tabulated_curves(lambda d: np.sqrt(d) + np.maximum(d - 0.5, 0.0), 1.0, 1.0, marks=marks)
    d = np.array([0.3, 0.5, 0.7, 1.0])
    np.testing.assert_allclose(evaluate(curves, d)[0], np.sqrt(d) + np.maximum(d - 0.5, 0.0), rtol=1e-13)


def test_slope_of_force_and_work_are_radius_and_force():
    curves = Radius(1.0, 0.0, ((1.0, 0.5),), ((0.3, 0.2, 1.0, 0.5),)).table(1.0)
    for d in (1e-12, 0.2, 0.3, 0.3 * (1 + 1e-6), 0.9):
        ahead = d * (1.0 + 1e-3)
        nodes, weights = np.polynomial.legendre.leggauss(12)
        s = 0.5 * (1.0 + nodes)
        y = d + (ahead - d) * s**4  # the mark is at the lower end or outside
        fraction = (ahead - d) * 0.5 * weights * 4.0 * s**3
        (_, f0, w0), (_, f1, w1) = (np.array(evaluate(curves, x)).ravel() for x in (d, ahead))
        a, force, _ = evaluate(curves, y)
        assert f1 - f0 == pytest.approx(2.0 * np.dot(fraction, a), rel=1e-11 if d < 0.3 or d > 0.31 else 1e-7)
        assert w1 - w0 == pytest.approx(np.dot(fraction, force), rel=1e-11)


def test_noise_is_kept_and_reported():
    """Where cutting gains nothing the radius has noise; what F_N makes of it is smaller."""

    def noisy(d):
        return np.sqrt(d) * (1.0 + 1e-11 * np.sin(1e15 * d))

    curves = tabulated_curves(noisy, 1.0, 1.0)
    assert 1e-12 < curves.misfit < 1e-10
    assert curves.rows.shape[0] < 5000
    d = 10.0 ** -np.linspace(0.0, 20.0, 50)
    np.testing.assert_allclose(evaluate(curves, d)[1], 4.0 / 3.0 * d**1.5, rtol=1e-10)


def test_kinks_without_marks_are_located():
    curves = tabulated_curves(lambda d: np.where(d < 0.3, np.sqrt(d), 0.3**0.5 + 0.2 * (d - 0.3)), 1.0, 1.0)
    d = np.concatenate([0.3 * (1.0 + np.array([-1e-3, -1e-9, 1e-9, 1e-3])), [0.1, 0.9]])
    np.testing.assert_allclose(
        evaluate(curves, d)[0], np.where(d < 0.3, np.sqrt(d), 0.3**0.5 + 0.2 * (d - 0.3)), rtol=2e-13
    )


def test_what_is_no_contact_radius_is_refused():
    for radius in (
        lambda d: np.maximum(d - 0.1, 0.0),
        lambda d: np.where(d < 1e-9, np.nan, d),
        lambda d: d - 0.5 * np.sin(3.0 * d),
        lambda d: 0.0 * d,
        lambda d: -d,
    ):
        with pytest.raises(ProblemError, match="finite, above 0 and not falling"):
            tabulated_curves(radius, 1.0, 1.0)
    with pytest.raises(ProblemError, match="marks"):
        tabulated_curves(np.sqrt, 1.0, 1.0, marks=[0.5, np.nan])
    with pytest.raises(ConvergenceError, match="marks"):
        tabulated_curves(lambda d: d + 1e-6 * (np.sin(1e7 * d) + 1e7 * d), 1.0, 1.0)
