"""What users' callables do: work in place, take scalars, fail, change; slopes, tips and kinks found from f alone."""

import math
import warnings

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import PymdrError
from pymdr.mapping.callables import (
    check_consistency,
    find_kinks,
    rounding,
    search_points,
    slope_panel,
    tip_law,
    underflow_law,
)
from pymdr.mapping.equivalent import equivalent_profile
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


UREG = pint.LazyRegistry()


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
        (lambda r: math.sqrt(r), r"^f\(r\) does not accept arrays .*numpy.vectorize"),
        (lambda r: max(r, 0.0), r"does not accept arrays .*numpy.vectorize"),
        (lambda r: r if r > 1 else 0.0, r"does not accept arrays .*numpy.vectorize"),
        (
            failing(ZeroDivisionError("by zero")),
            r"^f\(r\) \(f\) fails for radii from 0 m to 10 mm .*by zero",
        ),
        (failing(IndexError("out")), "IndexError: out"),
        (failing(OwnError()), "fails .*Own"),
        (failing(mdr.UnitError("no")), "UnitError: no"),
        (lambda: 0.0, "TypeError"),
        (lambda r: None, "None; it must return"),
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
    assert caught.value.args[0].startswith("f(r)")


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
@settings(max_examples=examples(60), deadline=None)
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


def test_a_callable_is_not_evaluated_beyond_its_largest_radius():
    calls = []

    def f(r):
        calls.append(r.max())
        return r * r

    profile = mdr.Function(f, derivative=lambda r: 2 * np.sqrt(r * r), max_radius=0.3)
    gap = profile.gap(np.array([0.1, 0.3, 0.3 * (1 + 1e-13), 0.4, 1e9]))
    np.testing.assert_allclose(gap[:3], [0.01, 0.09, 0.09], rtol=1e-15)
    assert np.all(np.isnan(gap[3:]))
    assert max(calls) <= 0.3
    assert np.isnan(profile.gap_slope(1.0))


def test_nan_below_the_largest_radius_is_refused():
    holed = mdr.Function(lambda r: np.where(r < 0.2, r, math.nan), max_radius=0.3)
    with pytest.raises(mdr.ProblemError, match="nan at r = 250 mm, inside its max_radius of 300 mm"):
        holed.gap([0.1, 0.25])
    with pytest.raises(mdr.ProblemError, match="nan at r = 0, where a profile must be finite"):
        mdr.Function(lambda r: r * r * np.log(r)).gap([0.1, 0.25])


# --- rounding, slopes and tips of f alone ----------------------------------------------------------------


def test_rounding_is_measured():
    r = np.geomspace(1e-7, 0.5, 40)
    assert np.all(rounding(lambda r: r**2, r) <= 1e-15 * r * r)
    assert np.all(rounding(lambda r: r**2, r) >= 2e-16 * r * r)
    cancelled = rounding(lambda r: 1.0 - np.sqrt(1.0 - r * r), r)
    assert np.all((cancelled > 1e-17) & (cancelled < 4e-16))
    assert np.all(rounding(lambda r: 3.0 + r * r, r) > 2.2e-16)
    single = rounding(lambda r: (r * r).astype(np.float32).astype(float), r)
    assert np.all((single > 5e-8 * r * r) & (single < 3e-7 * r * r))
    noisy = rounding(lambda r: r * r + 1e-9 * np.sin(1e12 * r), r[r > 1e-4])
    assert np.all((noisy > 3e-10) & (noisy < 2e-9))
    assert rounding(lambda r: 0.0 * r, 1.0).shape == ()


def test_search_points_leave_no_gap():
    for low, high in ((1.0, 2.0), (3e-7, 3e-7 * (1 + 1e-9)), (1e-12, 1e-9)):
        r = search_points(low, high)
        assert np.all(np.diff(r) >= 0.0)
        assert r[0] >= low
        assert r[-1] <= high
        assert r.size >= 16
        other = search_points(low, high, seed=1.0)
        assert not np.array_equal(r, other)
    r = search_points(1.0, 2.0)
    # nowhere in step with a wave
    phases = np.abs([np.mean(np.exp(2j * np.pi * r * k)) for k in (512, 1024, 2048, 4096)])
    assert np.max(phases) < 0.2


SCALES = st.floats(-12, 6).map(lambda e: 10.0**e)
SLOPES = st.floats(-4, 0).map(lambda e: 10.0**e)
LONG = np.longdouble

CANCELLING = {
    "hyperboloid": (
        lambda r, R, c: c * (np.sqrt(R * R + r * r) - R),
        lambda r, R, c: c * r / np.sqrt(R * R + r * r),
        math.inf,
    ),
    "sphere": (lambda r, R, c: R - np.sqrt(R * R - r * r), lambda r, R, c: r / np.sqrt(R * R - r * r), 1.0),
    "cosh": (lambda r, R, c: c * R * (np.cosh(r / R) - 1), lambda r, R, c: c * np.sinh(r / R), math.inf),
    "cos": (lambda r, R, c: c * R * (1 - np.cos(r / R)), lambda r, R, c: c * np.sin(r / R), math.inf),
    "log": (
        lambda r, R, c: c * R * np.log(1 + (r / R) ** 2),
        lambda r, R, c: 2 * c * (r / R) / (1 + (r / R) ** 2),
        math.inf,
    ),
    "exp": (lambda r, R, c: c * R * (np.exp(r / R) - 1), lambda r, R, c: c * np.exp(r / R), math.inf),
    "lifted": (
        lambda r, R, c: R * (c / 7 + c * (r / R) ** 2 + 0.3 * (r / R) ** 3),
        lambda r, R, c: 2 * c * (r / R) + 3 * LONG(0.3) * (r / R) ** 2,
        math.inf,
    ),
    "lifted 1.5": (
        lambda r, R, c: R * c * (0.3 + (r / R) ** 1.5),
        lambda r, R, c: 1.5 * c * np.sqrt(r / R),
        math.inf,
    ),
    "lifted cone": (
        lambda r, R, c: R * (c / 3 + c * (r / R) + 0.3 * (r / R) ** 2),
        lambda r, R, c: c + 2 * LONG(0.3) * (r / R),
        math.inf,
    ),
    "wave": (
        lambda r, R, c: r * r / (2 * R) + c * R / 100 * (1 - np.cos(20 * r / R)),
        lambda r, R, c: r / R + c / 5 * np.sin(20 * r / R),
        math.inf,
    ),
}


@given(st.sampled_from(sorted(CANCELLING)), SCALES, SLOPES, st.floats(0.0, 4.0))
@settings(max_examples=examples(40), deadline=None)
def test_the_law_of_the_tip_continues_what_cancels(name, R, c, octaves):
    f, slope, top = CANCELLING[name]

    def given_(r):
        return f(r, R, c)

    with np.errstate(all="ignore"):
        law = tip_law(given_, top * R)
        r = law.radius * np.geomspace(1e-30, 1.0, 60)
        exact = slope(r.astype(LONG), LONG(R), LONG(c))
        assert law.error < 2e-10
        assert np.max(np.abs(law.slope(r) / exact - 1)) < law.error
        # above it f itself is enough
        low = law.radius * 2.0**octaves
        if 1.19 * low < min(top, 2.0) * R:
            coefficients, error = slope_panel(given_, low, 1.19 * low)
            x = np.linspace(low, 1.19 * low, 50)
            exact = slope(x.astype(LONG), LONG(R), LONG(c))
            computed = np.polynomial.chebyshev.chebval(2 * (x - low) / (1.19 * low - low) - 1, coefficients)
            assert np.max(np.abs(computed - exact)) < error
            assert error < 5e-9 * np.max(np.abs(exact))


@given(SCALES, SLOPES, st.floats(0.3, 12.0), st.floats(0.3, 3.0))
@settings(max_examples=examples(25), deadline=None)
def test_no_law_is_needed_where_f_has_its_digits(R, c, n, m):
    for f in (
        lambda r: c * R * (r / R) ** n,
        lambda r: c * R * (r / R) ** n + 0.1 * R * (r / R) ** m,
        lambda r: c * r * (r / R) / (1 + np.sqrt(1 + (r / R) ** 2)),
        lambda r: c * np.maximum(r - R, 0.0) ** 2 / R,
        lambda r: 0.0 * r,
        lambda r: 0.0 * r + R,
    ):
        with np.errstate(all="ignore"):
            assert tip_law(f) is None


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(2.0, 40.0) | st.integers(2, 40),
    st.floats(-12.0, 0.0),
    st.floats(-3.0, 0.0),
    st.lists(st.floats(0.0, 8.0), min_size=1, max_size=4),
    st.booleans(),
)
def test_powers_go_on_where_they_underflow(power, log_size, log_height, decades, alone):
    """f = h (r / R)^p written as c r^p, whose powers of a radius in nm are no numbers, or have no digits."""
    size, height = 10.0**log_size, 10.0**log_height
    factor = math.sqrt(math.pi) * math.exp(math.lgamma(power / 2 + 1) - math.lgamma((power + 1) / 2))
    radius = size * 10.0 ** -np.sort(decades)
    with np.errstate(under="ignore"):
        depth = factor * height * size * (radius / size) ** power
    radius, depth = radius[depth > 1e-250], depth[depth > 1e-250]
    if power * log_size < -285.0 or not radius.size:
        return
    c = height * size / size**power
    slope = None if alone else lambda r: c * power * r ** (power - 1)
    contact = mdr.Contact(mdr.Function(lambda r: c * r**power, derivative=slope), mdr.Elastic(1.0, 0.0))
    result = mdr.solve(contact, mdr.Path(indentation=depth))
    assert result["contact_radius"].values == pytest.approx(radius, rel=1e-11)
    force = 2 * radius * depth * power / (power + 1)
    off = np.abs(result["normal_force"].values / force - 1.0)
    assert np.all(off <= 10.0 * result.claims["normal_force"].error + 1e-13)
    assert result.claims["normal_force"].level is mdr.Level.EXACT


@given(
    SCALES, st.floats(-2.0, -0.3), st.floats(-3.3, -2.0), st.floats(1.5, 4.0), st.sampled_from([-1.0, 1.0])
)
@settings(max_examples=examples(25), deadline=None)
def test_a_narrow_bump_on_an_offset_is_no_part_of_a_law(R, place, width, roundings, sign):
    """It hid between the radii of the fits, and forces were 1e-9 off with claims of 3e-14."""
    with np.errstate(all="ignore"):
        law = tip_law(lambda r: r * r / (2.0 * R) + R, R)
        m = law.radius * 10.0**place
        w, h = m * 10.0**width, sign * 10.0**roundings * np.spacing(R)
        with pytest.raises(mdr.ProblemError, match="give derivative="):
            tip_law(lambda r: r * r / (2.0 * R) + h * np.exp(-0.5 * ((r - m) / w) ** 2) + R, R)


@pytest.mark.parametrize("power", [0.0, 1.0])
@pytest.mark.parametrize("faint", [1e-30, 1e-60, 1e-120])
def test_a_kink_with_nearly_nothing_before_it_is_no_underflow(power, faint):
    """The slope beyond the kink was continued to the tip: depths were 400 times too large, with claims of 8e-16."""
    b = 1.818149579941359e-05

    def slope(r):
        return np.where(r > b, (r / b) ** power, faint * np.maximum(r / b - 0.9, 0.0) ** 4)

    assert underflow_law(slope, 1e-4, of="slope") is None
    line = equivalent_profile(mdr.Function(derivative=slope))
    x = b * np.array([1.01, 1.3, 4.0])
    cone, paraboloid = x * np.arccos(b / x), x * np.sqrt(x**2 - b**2) / b
    assert line.g(x) == pytest.approx(paraboloid if power else cone, rel=1e-11)


def test_a_tip_of_noise_is_refused():
    with np.errstate(all="ignore"):
        for f, top in (
            (lambda r: 1e-3 + r * r * np.log(np.where(r > 0, r, 1.0)), math.inf),
            (lambda r: r * r + 1e-3 * np.sin(1e15 * r + 1e9), 1.0),
        ):
            with pytest.raises(mdr.ProblemError, match="give derivative="):
                tip_law(f, top)


def test_the_slope_of_single_precision_says_so():
    coefficients, error = slope_panel(lambda r: (r * r / 2).astype(np.float32).astype(float), 1.0, 1.19)
    computed = np.polynomial.chebyshev.chebval(np.linspace(-1, 1, 50), coefficients)
    actual = np.max(np.abs(computed - np.linspace(1.0, 1.19, 50)))
    assert actual < error < 1e-5
    assert error > 1e-8
    with pytest.raises(mdr.ProblemError, match="not defined at r = 1"):
        slope_panel(lambda r: np.where(r < 1.1, r, math.nan), 1.0, 1.19)


@pytest.mark.parametrize("inside", [True, False])
@pytest.mark.parametrize("gives", ["f", "derivative", "both"])
def test_single_precision_is_served_with_its_error(gives, inside):
    """A sphere computed in single precision, or rounded to it, whose powers underflow farther in."""
    single = np.float32
    for seed in range(1 if gives == "f" else 3):
        rng = np.random.default_rng([seed, inside, len(gives)])
        R = 10.0 ** rng.uniform(-8.5, 0.5)

        def rounded(curve, R=R):
            if inside:
                return lambda r: curve(r.astype(single), single(R))
            return lambda r: curve(r, R).astype(single)

        f = rounded(lambda r, R: r * r / (R + np.sqrt(R * R - r * r)))
        slope = rounded(lambda r, R: r / np.sqrt(R * R - r * r))
        profile = mdr.Function(
            f if gives != "derivative" else None,
            derivative=None if gives == "f" else slope,
            max_radius=0.9 * R,
        )
        line, x = equivalent_profile(profile), R * 10.0 ** rng.uniform(-3, -0.1, 4)
        error = line.error(x)[:, 0]
        assert np.all(np.abs(line.g(x) / (x * np.arctanh(x / R)) - 1) <= error)
        assert np.all((error > 3e-8) & (error < (3e-4 if gives == "f" else 3e-6)))
    cone = equivalent_profile(mdr.Function(derivative=lambda r: np.full(r.shape, 0.1, single)))
    assert 1e-8 < abs(float(cone.g(1.0)) / (0.05 * math.pi) - 1.0) < float(cone.error(1.0)[0])


# --- kinks that nobody named -----------------------------------------------------------------------------

BASES = {
    "power": (lambda r, R, n: R * (r / R) ** (n + 1) / (n + 1), lambda r, R, n: (r / R) ** n),
    "wave": (
        lambda r, R, n: R * ((r / R) ** 2 / 2 + 0.03 * (1 - np.cos(10 * n * r / R)) / n),
        lambda r, R, n: r / R + 0.3 * np.sin(10 * n * r / R),
    ),
    "hyperboloid": (lambda r, R, n: np.sqrt(R * R + r * r) - R, lambda r, R, n: r / np.sqrt(R * R + r * r)),
    "cone": (lambda r, R, n: r + 0.01 * R, lambda r, R, n: 0.0 * r + 1.0),
}


def separated(rng, low, high, count):
    marks = np.sort(rng.uniform(low, high, count))
    return marks[np.concatenate([[True], np.diff(marks) > 1e-3 * high])]


@given(
    st.sampled_from(sorted(BASES)),
    SCALES,
    SLOPES,
    st.integers(1, 4),
    st.floats(-6, 0),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=examples(30), deadline=None)
def test_jumps_of_the_slope_are_followed_to_the_last_float(name, R, c, count, jump, seed):
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.5, 1.0) * R
    high = low * 2**0.25
    marks, n = separated(rng, low, high, count), rng.uniform(0.5, 5.0)
    jumps = c * 10.0**jump * rng.choice([-1.0, 1.0], marks.size)
    slope = BASES[name][1]

    def curve(r):
        return c * slope(r, R, n) + (r[:, None] > marks) @ jumps

    assert find_kinks(curve, low, high) == marks.tolist()


@given(
    st.sampled_from(sorted(BASES)),
    SCALES,
    SLOPES,
    st.integers(1, 3),
    st.floats(-5, 0),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=examples(30), deadline=None)
@example("wave", 1.0, 1.0, 1, -1.0, 117)
@example("wave", 5.499206528076695, 0.00981407523189864, 3, -4.8120675031762055, 2125686768)
def test_kinks_of_f_alone_are_located(name, R, c, count, jump, seed):
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.5, 1.0) * R
    high = low * 2**0.25
    marks, n = separated(rng, low, high, count), rng.uniform(0.5, 5.0)
    jumps = c * 10.0**jump * rng.choice([-1.0, 1.0], marks.size)
    gap = BASES[name][0]

    def curve(r):
        return c * gap(r, R, n) + np.maximum(r[:, None] - marks, 0.0) @ jumps

    result = find_kinks(curve, low, high, of="value")
    assert len(result) == marks.size
    noise = np.max(rounding(curve, [low, high]))
    assert np.all(np.abs(result - marks) <= 20 * noise / np.abs(jumps) + 4e-16 * marks)


@pytest.mark.parametrize("order", [0.3, 0.5, 1.5, 1, 2, 2.2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("R", [1e-9, 1.0, 3e5])
def test_weak_singularities_are_located(order, sign, R):
    b = 0.31415926 * R
    result = find_kinks(lambda r: np.maximum(sign * (r - b) / R, 0.0) ** order + r / R, 0.28 * R, 0.34 * R)
    assert len(result) == 1
    assert abs(result[0] / b - 1) < (1e-12 if order < 2 else 2e-6)


@given(SCALES, st.floats(-3.0, 3.0), st.floats(-11.0, -2.0), st.sampled_from(["slope", "value"]))
@settings(max_examples=8, deadline=None)
def test_a_kink_close_beyond_the_beginning_stays_where_it_is(b, steeper, distance, of):
    """A truncated cone that bends as close as 1e-11 of its radius beyond its kink, and is nothing before it."""
    if of == "value":
        # the rounding of f tells no closer ones apart
        steeper, distance = abs(steeper), 0.5 * distance
    marks = np.array([b, b * (1.0 + 10.0**distance)])
    slopes = 1e-3 * np.array([1.0, 10.0**steeper])

    def curve(r):
        beyond = r[:, None] - marks
        return (beyond > 0.0) @ slopes if of == "slope" else np.maximum(beyond, 0.0) @ slopes

    result = find_kinks(curve, 0.9 * b, 1.2 * b, of=of)
    np.testing.assert_allclose(result, marks, rtol=0.0 if of == "slope" else 1e-12)


def test_kinks_close_together_are_resolved():
    b = np.pi / 10
    for distance in (1e-3, 1e-6, 1e-9, 1e-13):
        marks = [b, b * (1 + distance)]
        assert find_kinks(lambda r, m=marks: (r > m[0]) + 2.0 * (r > m[1]) + r, 0.28, 0.34) == marks
    for distance in (1e-3, 1e-6):
        marks = np.array([b, b * (1 + distance)])
        result = find_kinks(
            lambda r, m=marks: np.maximum(r[:, None] - m, 0.0).sum(1) + r, 0.28, 0.34, of="value"
        )
        np.testing.assert_allclose(result, marks, rtol=1e-10)
    many = np.sort(np.random.default_rng(1).uniform(0.28, 0.34, 32))
    assert find_kinks(lambda r: (r[:, None] > many).sum(1) + r, 0.28, 0.34) == many.tolist()


@pytest.mark.parametrize(
    "curve",
    [
        lambda r: np.tanh((r - 0.3) * 1e5),
        lambda r: r + np.exp(-(((r - 0.3) * 1e4) ** 2)),
        lambda r: np.sin(1000 * r),
        lambda r: np.sqrt(r - 0.28),
        lambda r: np.sqrt(0.34 - r),
        lambda r: 0.0 * r,
    ],
)
def test_what_is_only_steep_has_no_kinks(curve):
    assert find_kinks(curve, 0.28, 0.34) == []


def test_steps_and_thickets_are_refused():
    with pytest.raises(
        mdr.ProblemError, match="jumps by 1 m at r = 300 mm: a step is not a disk contact; use FlatPunch"
    ):
        find_kinks(lambda r: r + (r > 0.3), 0.28, 0.34, of="value")
    many = np.sort(np.random.default_rng(1).uniform(0.28, 0.34, 60))
    with pytest.raises(mdr.ProblemError, match=r"more than 32 radii.*breakpoints=\["):
        find_kinks(lambda r: (r[:, None] > many).sum(1) + r, 0.28, 0.34)
    with pytest.raises(mdr.ProblemError, match="breakpoints"):
        find_kinks(lambda r: r + 1e-8 * np.sin(1e13 * r), 0.28, 0.34, 1e-17)
    with pytest.raises(mdr.ProblemError, match="not defined at r = 3"):
        find_kinks(lambda r: np.where(r < 0.3, r, math.nan), 0.28, 0.34)


# --- f and derivative that belong together ---------------------------------------------------------------

PAIRS = {
    **{name: (f, slope, top) for name, (f, slope, top) in CANCELLING.items()},
    "steep": (lambda r, R, c: c * R * (r / R) ** 40, lambda r, R, c: 40 * c * (r / R) ** 39, math.inf),
    "root": (lambda r, R, c: c * R * (r / R) ** 0.3, lambda r, R, c: 0.3 * c * (r / R) ** -0.7, math.inf),
    "hundreds of waves": (
        lambda r, R, c: r * r / (2 * R) + 1e-4 * R * c * (1 - np.cos(3000 * r / R)),
        lambda r, R, c: r / R + 0.3 * c * np.sin(3000 * r / R),
        math.inf,
    ),
    "far above": (lambda r, R, c: 1e3 * R + c * r * r / R, lambda r, R, c: 2 * c * r / R, math.inf),
    "bump": (
        lambda r, R, c: r * r / (2 * R) + 1e-5 * R * np.exp(-(((r / R - 0.4) / 1e-4) ** 2)),
        lambda r, R, c: r / R - 0.2 * (r / R - 0.4) / 1e-4 * np.exp(-(((r / R - 0.4) / 1e-4) ** 2)),
        math.inf,
    ),
    "plateau": (lambda r, R, c: np.minimum(r, 0.3 * R), lambda r, R, c: 1.0 * (r < 0.3 * R), math.inf),
    "dead zone": (
        lambda r, R, c: c * R * np.maximum(r / R - 0.3, 0.0) ** 1.1,
        lambda r, R, c: 1.1 * c * np.maximum(r / R - 0.3, 0.0) ** 0.1,
        math.inf,
    ),
}


@given(
    st.sampled_from(sorted(PAIRS)),
    SCALES,
    SLOPES,
    st.lists(st.floats(-6, 0), max_size=12),
    st.floats(1, 12),
    st.booleans(),
)
@settings(max_examples=examples(60), deadline=None)
def test_f_and_its_derivative_are_taken(name, R, c, kinks, decades, named):
    f, slope, top = PAIRS[name]
    marks = R * 10.0 ** np.array(kinks)
    jumps = c * 100.0 ** -np.arange(1.0, marks.size + 1.0)

    def whole(r):
        return f(r, R, c) + np.maximum(r[:, None] - marks, 0.0) @ jumps

    def derivative(r):
        return slope(r, R, c) + (r[:, None] > marks) @ jumps

    high = min(2.0, top) * R
    with np.errstate(all="ignore"):
        check_consistency(whole, derivative, high / 10.0**decades, high, marks if named else ())


@given(st.sampled_from(sorted(PAIRS)), SCALES, SLOPES, st.floats(-5.5, 1), st.booleans())
@settings(max_examples=examples(60), deadline=None)
def test_a_derivative_of_something_else_is_refused(name, R, c, wrong, everywhere):
    f, slope, top = PAIRS[name]
    if name == "far above" and wrong < -3:
        wrong = -3.0
    high = min(2.0, top) * R

    def derivative(r):
        # a factor, or too much in a tenth of an octave
        x = r / (0.9 * high)
        return slope(r, R, c) * (1 + 10.0**wrong * (1.0 if everywhere else np.exp(-(((x - 1) / 0.02) ** 2))))

    with np.errstate(all="ignore"):
        if name == "plateau" and not everywhere:
            return
        with pytest.raises(mdr.ProblemError, match=r"contradict each other near r = .* the slope of f is"):
            check_consistency(lambda r: f(r, R, c), derivative, 1e-9 * high, high)


def test_the_mended_examples():
    with pytest.raises(mdr.ProblemError, match=r"slope of f is .*, derivative gives"):
        check_consistency(lambda r: r * r / 2, lambda r: 2 * r, 1e-6, 1.0)
    check_consistency(lambda r: r * r / 2 + np.maximum(r - 0.5, 0), lambda r: r + (r > 0.5), 1e-6, 1.0, [0.5])
    with pytest.raises(mdr.ProblemError, match="near r = 5"):
        check_consistency(
            lambda r: r * r / 2 + np.maximum(r - 0.5, 0), lambda r: r + (r > 0.52), 1e-6, 1.0, [0.5]
        )


@pytest.mark.long
def test_waves_down_to_the_tip_are_refused_in_words():
    """Waves in log r of one amplitude at every radius: some drawn ones ended in an error of linear algebra."""
    rng = np.random.default_rng(0)
    refusals = []
    for _ in range(6):
        radius, waves = 10.0 ** rng.uniform(-9.0, 0.0), 10.0 ** rng.uniform(-12.0, -5.0)
        power = rng.uniform(1.2, 4.0)
        wavy = mdr.Function(
            lambda r, R=radius, n=power, e=waves: (
                R * (r / R) ** n * (1 + e * np.sin(1e6 * np.log(r / R + 1e-300)))
            )
        )
        try:
            mdr.solve(mdr.Contact(wavy, mdr.Elastic("1 GPa", 0.3)), mdr.indent(1e-4 * radius))
        except PymdrError as refused:
            refusals.append(str(refused))
    assert all("r = " in words for words in refusals)
