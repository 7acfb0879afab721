"""Graded tables: a relative accuracy at every argument, exact integrals, the inverse, and one reading by NumPy and kernels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drawing import examples
from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.friction import power_law_curves, tabulated_curves
from pymdr.line.friction.driver import depths_at_force
from pymdr.numerics.graded import graded_table

few = settings(max_examples=examples(40), deadline=None)
lengths = st.sampled_from([1e-12, 3e-9, 1e-6, 1.0, 1e6])
profiles = st.one_of(st.floats(0.1, 100.0), st.sampled_from([0.5, 1.0, 2.0]))
"""Exponents n of profiles, whose radius is a power 1/n of the depth."""
powers = profiles.map(lambda n: 1.0 / n)
places = st.floats(-6.0, -0.01).map(lambda x: 10.0**x)
marks = st.lists(
    st.tuples(
        places,
        st.sampled_from([0.0, 0.0, 0.3]),
        st.floats(-3.0, 1.0).map(lambda x: 10.0**x),
        st.floats(0.3, 4.0),
    ),
    max_size=4,
    unique_by=lambda mark: mark[0],
)


def exact(x, length, p, breaks):
    """F, its integral and second integral in extended precision: L [s^p + sum of (step + c z^q) above the marks], s = x / L."""
    one = np.longdouble(1.0)
    s, p = np.asarray(x) * one / length, p * one
    total = [s**p, s ** (p + 1) / (p + 1), s ** (p + 2) / (p + 1) / (p + 2)]
    for mark, step, c, q in breaks:
        # the mark is the rounded product, as in the function
        z, q = np.maximum(np.asarray(x) * one - mark * length, 0.0) / length, q * one
        above = np.asarray(x) >= mark * length
        total[0] = total[0] + np.where(above, step + c * z**q, 0.0)
        total[1] = total[1] + step * z + c * z ** (q + 1) / (q + 1)
        total[2] = total[2] + step * z**2 / 2 + c * z ** (q + 2) / (q + 1) / (q + 2)
    return np.stack([length * total[0], length**2 * total[1], length**3 * total[2]])


def table_of(length, p, breaks, **options):
    def function(x):
        s = x / length
        f = s**p
        for mark, step, c, q in breaks:
            z = np.maximum(x - mark * length, 0.0) / length
            f = f + np.where(x >= mark * length, step + c * z**q, 0.0)
        return length * f

    return graded_table(function, length, marks=[length * mark for mark, *_ in breaks], **options)


def points(length, breaks):
    """Arguments over 25 decades, everywhere, and on both sides of the marks."""
    ends = 10.0 ** -np.linspace(0.5, 9.0, 30)
    x = np.concatenate(
        [
            10.0 ** -np.linspace(0.0, 25.0, 151),
            np.linspace(0.0, 1.0, 201)[1:],
            *(mark * (1.0 + np.concatenate([ends, -ends])) for mark, *_ in breaks),
        ]
    )
    return length * x[(x > 0.0) & (x <= 1.0)]


@few
@given(lengths, powers, marks)
@example(1.0, 0.1, [])
@example(1e-9, 10.0, [])
@example(1.0, 0.5, [(0.25, 0.0, 1.0, 0.3), (0.5, 0.3, 0.001, 1.0)])
def test_values_and_integrals_are_accurate_relative_to_themselves(length, p, breaks):
    table = table_of(length, p, breaks)
    x = points(length, breaks)
    true = exact(x, length, p, breaks)
    normal = true[2] > 1e-250
    read = table(x)
    for ours, value in zip(read, true, strict=True):
        np.testing.assert_allclose(ours[normal], value[normal].astype(float), rtol=1e-12, atol=0.0)
    assert table.error <= 1e-12
    np.testing.assert_allclose(table.inverse(read[1][normal]), x[normal], rtol=1e-14, atol=0.0)
    order = np.argsort(x[normal])
    for rising in read[:, normal][:, order]:
        assert np.all(np.diff(rising) >= -1e-12 * rising[1:])


@few
@given(powers, marks)
def test_kernels_and_numpy_read_the_same(p, breaks):
    table = table_of(1.0, p, breaks, factor=2.0)
    x = points(1.0, breaks)
    integral = table(x)[1]
    integral = integral[integral > 1e-250]
    curves = power_law_curves(2.0, 1.0, 1.0)._replace(exponent=0.0, rows=table.rows, depth=1.0)
    np.testing.assert_allclose(
        depths_at_force(curves, integral), table.inverse(integral), rtol=1e-14, atol=0.0
    )


@pytest.mark.parametrize("p", [0.5, 1.0])
def test_a_power_is_served_down_to_the_smallest_floats(p):
    """The second integral underflows first, at a relative argument of 1e-300 for a root of unit length."""
    table = graded_table(lambda x: x**p, 1.0)
    x = 10.0 ** -np.arange(0.0, 301.0, 20.0)
    f, integral, _ = table(x)
    np.testing.assert_allclose(f, x**p, rtol=1e-12)
    normal = x ** (p + 1.0) > 1e-300
    np.testing.assert_allclose(integral[normal], (x ** (p + 1.0) / (p + 1.0))[normal], rtol=1e-12)
    np.testing.assert_allclose(table.inverse(integral[normal]), x[normal], rtol=1e-13)


@few
@given(st.floats(0.2, 4.0), st.sampled_from([1e-9, 1.0, 1e3]), st.floats(-6.0, 6.0))
def test_scales_of_argument_and_value_change_nothing(p, length, log_size):
    size = 10.0**log_size
    unit = graded_table(lambda x: x**p * (1.0 + x), 1.0)
    scaled = graded_table(lambda x: size * (x / length) ** p * (1.0 + x / length), length, factor=3.0)
    x = 10.0 ** -np.linspace(0.0, 20.0, 60)
    factors = np.array([size, 3.0 * size * length, 3.0 * size * length**2])
    np.testing.assert_allclose(scaled(length * x), unit(x) * factors[:, None], rtol=2e-12)


def test_the_ends_of_the_domain():
    table = graded_table(lambda x: 0.3 + x, 2.0)
    f, integral, second = table([-1.0, 0.0, 2.0, 2.0 * (1.0 + 1e-15), 2.1, np.nan])
    assert f[:2].tolist() == integral[:2].tolist() == second[:2].tolist() == [0.0, 0.0]
    assert integral[2] == integral[3] == pytest.approx(2.6, rel=1e-14)
    assert np.isnan([f[4:], integral[4:], second[4:]]).all()
    back = table.inverse([-1.0, 0.0, 2.6, 2.7, np.nan, 1e-30])
    assert back[1:3].tolist() == [0.0, 2.0]
    assert np.isnan(back[[0, 3, 4]]).all()
    assert back[5] == pytest.approx(1e-30 / 0.3, rel=1e-14)
    assert table.max_argument == 2.0


def test_values_that_are_refused_are_named():
    with pytest.raises(ProblemError, match=r"f\(.*\) = .*finite, above 0 and not falling"):
        graded_table(lambda x: 1.0 - x, 1.0)
    with pytest.raises(ProblemError, match=r"a\(.*m\) = "):
        tabulated_curves(lambda d: 1.0 - d, 1.0, 1.0)
    with pytest.raises(ConvergenceError, match="larger tolerance"):
        graded_table(lambda x: x + 1e-6 * (np.sin(1e7 * x) + 1e7 * x), 1.0)
