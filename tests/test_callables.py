"""What users' callables do: work in place, take scalars, fail, change; slopes, tips and kinks found from f alone."""

import math
import warnings

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.problem.profiles import call

RADII = np.array([0.0, 1e-3, 2e-3, 5e-3, 1e-2])


# --- calling ---------------------------------------------------------------------------------------------


def in_place(r):
    r /= 1e-2
    r *= r
    return r


def buffered():
    buffer = np.empty(1000)

    def f(r):
        out = buffer[: r.size]
        np.multiply(r, 1e4 * r, out=out)
        return out

    return f


UREG = pint.UnitRegistry()


@pytest.mark.parametrize(
    "function",
    [
        in_place,
        buffered(),
        lambda r: [1e4 * x * x for x in r],
        lambda r: pd.Series(1e4 * r**2),
        lambda r: xr.DataArray(1e4 * r**2),
        lambda r: np.ma.masked_array(1e4 * r**2, r > 1.0),
        lambda r: np.array([1e4 * float(x) ** 2 for x in r], dtype=object),
        lambda r: (1e4 * r**2).astype(np.longdouble),
        lambda r: (r * UREG.m) ** 2 / (0.1 * UREG.mm),
        np.vectorize(lambda r: 0 if r == 0.0 else 1e4 * r * r),
    ],
)
def test_callables_may_work_in_place_and_give_any_real_array(function):
    radii = RADII.copy()
    for _ in range(2):
        values = call(function, radii)
        assert np.array_equal(radii, RADII)
        assert type(values) is np.ndarray
        np.testing.assert_allclose(values, (100 * RADII) ** 2, rtol=1e-15)
    kept = values.copy()
    call(function, radii[::-1])
    assert np.array_equal(values, kept)
    np.testing.assert_allclose(call(function, radii.reshape(5, 1))[:, 0], kept, rtol=1e-15)
    assert float(call(function, np.array(1e-2))) == pytest.approx(1.0, rel=1e-15)
    assert call(function, np.empty((0, 3))).shape == (0, 3)


def test_a_view_of_the_argument_is_not_shared():
    kept = []

    def f(r):
        kept.append(r)
        return r

    values = call(f, RADII)
    for array in kept:
        array[:] = math.nan
    assert np.array_equal(values, RADII)


@pytest.mark.parametrize("constant", [0, 0.0, np.float32(0.0), [0.0], np.zeros(1)])
def test_constants_stand_for_all_radii(constant):
    assert call(lambda r: constant, RADII).tolist() == [0.0] * 5


def test_what_is_masked_is_not_defined():
    values = call(lambda r: np.ma.masked_array(r, r > 4e-3), RADII)
    assert np.isnan(values).tolist() == [False, False, False, True, True]


class OwnError(Exception):
    pass


def failing(error):
    def f(r):
        raise error

    return f


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda r: math.sqrt(r), r"Function.f does not take arrays .*numpy.vectorize"),
        (lambda r: max(r, 0.0), r"does not take arrays .*numpy.vectorize"),
        (lambda r: r if r > 1 else 0.0, r"does not take arrays .*numpy.vectorize"),
        (
            failing(ZeroDivisionError("by zero")),
            r"Function.f \(f\) fails for radii from 0 m to 10 mm .*by zero",
        ),
        (failing(IndexError("out")), "IndexError: out"),
        (failing(OwnError()), "fails .*Own"),
        (failing(mdr.UnitError("no")), "UnitError: no"),
        (lambda: 0.0, "TypeError"),
        (lambda r: None, "None: it must return"),
        (lambda r: np.array([None] * r.size), "NoneType"),
        (lambda r: r + 0j, "complex"),
        (lambda r: np.array([1j] * r.size, dtype=object), "complex"),
        (lambda r: "1e-3", "real numbers|<U"),
        (lambda r: np.array(["1"] * r.size, dtype=object), "str"),
        (lambda r: r > 1e-3, "bool"),
        (lambda r: (1e9 * r).astype(np.int32), "int32"),
        (lambda r: np.append(r, 0.0), "shape"),
        (lambda r: r[:, None], "shape"),
        (lambda r: r[:-1], "shape"),
        (lambda r: {"f": r}, "dict"),
        (lambda r: r * UREG.kg, "kilogram"),
        (lambda r: r / r.max(), "other radii"),
        (lambda r: np.cumsum(r), "other radii"),
        (lambda r: np.gradient(r**2), "other radii"),
        (lambda r: np.dot(r, r), "other radii"),
    ],
)
def test_what_is_no_profile_is_refused(function, words):
    with pytest.raises(mdr.ProblemError, match=words) as caught:
        call(function, RADII)
    assert caught.value.args[0].count("Function.f") == 1


@pytest.mark.parametrize("function", [math.sqrt, lambda r: max(r, 0.0)])
def test_scalar_callables_are_refused_at_a_single_radius_too(function):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(mdr.ProblemError, match=r"numpy\.vectorize"):
            call(function, np.array(0.5))


def test_errors_are_chained():
    with pytest.raises(mdr.ProblemError) as caught:
        call(failing(OwnError("mine")), RADII)
    assert isinstance(caught.value.__cause__, OwnError)


def test_a_type_taken_from_the_first_value_truncates_nothing():
    hand_made = np.vectorize(lambda r: 0 if r < 3e-3 else r - 3e-3)
    assert call(hand_made, RADII)[-1] == pytest.approx(7e-3)
    with pytest.raises(mdr.ProblemError, match="int64"):
        call(lambda r: hand_made(r), RADII)


def test_state_is_refused():
    calls = []

    def counting(r):
        calls.append(1)
        return r * len(calls)

    noise = np.random.default_rng(1)
    for f in (counting, lambda r: r + 1e-6 * noise.normal(size=r.shape)):
        for r in (RADII, np.array([0.3])):
            with pytest.raises(mdr.ProblemError, match="for the same radius"):
                call(f, r)


@given(st.floats(-12, 6), st.integers(1, 3000), st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_rounding_is_not_taken_for_state(scale, count, seed):
    R = 10.0**scale
    r = R * 10.0 ** np.random.default_rng(seed).uniform(-12, 1, count)
    for f in (
        lambda r: R * (np.cosh(r / R) - 1),
        lambda r: R * (1 - np.cos(r / R)),
        lambda r: np.sqrt(R * R + r * r) - R,
        lambda r: (R * (np.exp(r / R) - 1)).astype(np.float32),
        lambda r: R * (r / R) ** 1.3,
        lambda r: R * np.log1p(np.sin(r / R) ** 2),
    ):
        values = call(f, r)
        assert values.shape == r.shape


def test_nothing_is_asked_beyond_the_reach():
    asked = []

    def f(r):
        asked.append(r.max())
        return r * r

    profile = mdr.Function(f, derivative=lambda r: 2 * np.sqrt(r * r), reach=0.3)
    gap = profile.gap(np.array([0.1, 0.3, 0.3 * (1 + 1e-13), 0.4, 1e9]))
    np.testing.assert_allclose(gap[:3], [0.01, 0.09, 0.09], rtol=1e-15)
    assert np.all(np.isnan(gap[3:]))
    assert max(asked) <= 0.3
    assert np.isnan(profile.gap_slope(1.0))


def test_nan_inside_the_reach_is_refused():
    holed = mdr.Function(lambda r: np.where(r < 0.2, r, math.nan), reach=0.3)
    with pytest.raises(mdr.ProblemError, match="nan at r = 250 mm, inside its reach of 300 mm"):
        holed.gap([0.1, 0.25])
    with pytest.raises(mdr.ProblemError, match="nan at r = 0, where a profile must be defined"):
        mdr.Function(lambda r: r * r * np.log(r)).gap([0.1, 0.25])
