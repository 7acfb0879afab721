"""Callables that step, kink beside their breakpoints or are splines, and the gap of those that were saved."""

import itertools
import math
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import roots_jacobi

import pymdr as mdr
from drawing import examples
from pymdr.mapping.callables.steps import Steps
from pymdr.mapping.equivalent import equivalent_profile

RADII = st.floats(-9, 1).map(lambda e: 10.0**e)
COUNT = 2 if settings().derandomize else 20
"""Random examples of a test: two in the run that everybody waits for."""
GIVES = st.sampled_from(["f", "derivative", "both"])


def of(f, derivative, gives, breakpoints=()):
    """A Function of f, its derivative, or both."""
    return mdr.Function(
        None if gives == "derivative" else f, breakpoints, None if gives == "f" else derivative
    )


# --- steps -----------------------------------------------------------------------------------------------


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-5.5, 3), st.sampled_from([-1.0, 1.0]), st.sampled_from(["f", "both"]))
def test_a_step_at_a_breakpoint_is_refused_with_its_size(b, size, sign, gives):
    step = sign * b * 10.0**size
    profile = of(lambda r: r * r / (2 * b) + np.where(r > b, step, 0.0), lambda r: r / b, gives, [b])
    with pytest.raises(mdr.ProblemError, match=r"the profile jumps by .* FlatPunch") as refused:
        equivalent_profile(profile).g(1.5 * b)
    assert mdr.units.metres(step).split()[0] in str(refused.value)
    # a contact that ends at the step does not cross it
    line = equivalent_profile(profile + mdr.FlatPunch(b))
    assert float(line.g(b)) == pytest.approx(b, rel=1e-12)


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-13, -6.5), st.sampled_from([-1.0, 1.0]), st.sampled_from(["f", "both"]))
def test_constants_of_few_digits_at_a_breakpoint_are_errors(b, size, sign, gives):
    step = sign * b * 10.0**size
    line = equivalent_profile(
        of(lambda r: r * r / (2 * b) + np.where(r > b, step, 0.0), lambda r: r / b, gives, [b])
    )
    x = b * np.array([1.3, 2.0])
    # of a step at b: g rises by step x / sqrt(x^2 - b^2)
    off = abs(step) / np.sqrt(1 - (b / x) ** 2) / line.g(x)
    claimed = line.error(x)[:, 0]
    assert np.all(off < 10.0 * claimed + 1e-14)
    assert np.all(claimed < 30.0 * off + 1e-13)


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-8, 3), st.floats(0.3, 4), st.floats(-6, 6), st.sampled_from(["f", "both"]))
def test_a_step_on_the_axis_is_refused(R, size, n, offset, gives):
    step, level = R * 10.0**size, R * 10.0 ** min(offset, size + 4)
    profile = of(
        lambda r: R * (r / R) ** n + np.where(r > 0.0, step, 0.0) + level,
        lambda r: n * (r / R) ** (n - 1),
        gives,
    )
    with pytest.raises(mdr.ProblemError, match=r"jumps by .* at r = 0"):
        equivalent_profile(profile).g(R)


@pytest.mark.parametrize(
    "f",
    [
        lambda r: r**0.05,
        lambda r: 1e6 + r * r,
        lambda r: np.where(r > 0.0, (1.0 - np.cos(r)) / np.where(r > 0.0, r, 1.0) ** 2, 0.5),
        lambda r: np.sqrt(1.0 + r * r) - 1.0,
        lambda r: np.maximum(r - 0.3, 0.0) ** 0.1,
        lambda r: np.tanh((r - 0.3) / 1e-9),
        lambda r: 0.1 * np.minimum(r, 0.3) + np.maximum(r - 0.3, 0.0),
    ],
)
def test_what_is_only_steep_or_cancels_does_not_step(f):
    Steps(f).refuse(1.0, (0.3,))


# --- kinks beside breakpoints ----------------------------------------------------------------------------


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-14, -3.3), st.sampled_from([-1.0, 1.0]), st.floats(-3, 0), GIVES, st.booleans())
def test_a_breakpoint_next_to_the_kink_is_moved_to_it(b, off, sign, log_jump, gives, alone):
    jump, named = 10.0**log_jump, b * (1 + sign * 10.0**off)
    profile = of(
        lambda r: r * r / (2 * b) + jump * np.maximum(r - b, 0.0),
        lambda r: r / b + jump * (r > b),
        gives,
        [named],
    )
    line = equivalent_profile(profile if alone else profile + mdr.Paraboloid(b))
    x = b * np.array([1.01, 1.2, 5.0])
    truth = (1 if alone else 2) * x * x / b + jump * x * np.arccos(b / x)
    assert np.all(np.abs(line.g(x) / truth - 1) <= 10.0 * line.error(x)[:, 0] + 1e-14)
    assert np.max(line.error(x)[:, 0]) < 1e-12


@pytest.mark.long
def test_a_kink_close_beyond_another_is_claimed():
    # 9e-12 m beyond the first, felt as 2e-4 of the slope
    marks, jumps = (0.005312026729862694, 0.005312026739010206), (0.02864380751426051, 5.738799126182169e-06)
    line = equivalent_profile(
        mdr.Function(
            lambda r: (
                1e-6 + 2e-6 * r + sum(j * np.maximum(r - b, 0.0) for b, j in zip(marks, jumps, strict=True))
            )
        )
    )
    x = marks[0] + np.array([2e-11, 5.8e-11, 1e-9, 1e-6])
    wide = x.astype(np.longdouble)
    truth = wide * (np.longdouble(2e-6) * np.arccos(np.longdouble(0)))
    for b, jump in zip(marks, jumps, strict=True):
        truth += wide * np.longdouble(jump) * np.arccos(np.longdouble(b) / wide)
    off = np.abs(line.g(x) / truth - 1).astype(float)
    assert np.all(off <= 10.0 * line.error(x)[:, 0] + 1e-14)


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-6, -0.3), st.floats(-12, -1), st.sampled_from([-1.0, 1.0]))
def test_a_kink_as_sharp_as_the_rounding_of_f_is_claimed(b, jump, away, side):
    # a cone whose slope rises by a little at b, near which the place of the kink matters
    jump, x = 0.1 * 10.0**jump, b * (1.0 + side * 10.0**away)
    line = equivalent_profile(mdr.Function(lambda r: 0.1 * r + jump * np.maximum(r - b, 0.0)))
    line.map_to(2.0 * b)
    wide = np.longdouble(x)
    truth = wide * np.longdouble(0.1) * np.arccos(np.longdouble(0))
    truth += wide * np.longdouble(jump) * np.arccos(np.minimum(np.longdouble(b) / wide, 1))
    off = abs(float(line.g(np.array([x]))[0] / truth - 1))
    claimed = float(line.error(np.array([x]))[0, 0])
    assert off <= 10.0 * claimed + 1e-14
    if away > -6:
        assert claimed < 1e-11


def test_kinks_that_an_offset_hides_are_claimed_in_the_energy():
    # two kinks at once, over which f' rises by 2600 times its value, below an offset whose rounding is 1e-6 of the rise before
    terms = ((1.65e-6, 0.0), (3.48e-3, 1.6337612367349963), (8.11e-4, 1.6337613966318407), (9.1e-6, 520.0))
    line = equivalent_profile(
        mdr.Function(lambda r: 8658.529072773103 + sum(s * np.maximum(r - b, 0.0) for s, b in terms))
    )
    x = np.array([3.555343286188964])
    assert np.isfinite(line.overlap_radius(0.0167))

    def image(t):
        return sum(s * t * np.arccos(np.minimum(b / t, 1.0)) for s, b in terms)

    t, w = np.polynomial.legendre.leggauss(200)
    squared = 0.0
    for low, high in itertools.pairwise([0.0, *(b for _, b in terms[1:3]), float(x[0])]):
        # the root of g at a kink is taken out by a square
        at = 0.5 * (1.0 + t)
        where = low + (high - low) * at**2
        squared += float(
            np.sum(w * at * (high - low) * (image(x[0]) - image(np.maximum(where, 1e-300))) ** 2)
        )
    for name, k, truth in (("g", 0, image(x[0])), ("squared", 3, squared)):
        off = abs(float(getattr(line, name)(x)[0]) / truth - 1.0)
        assert off <= 10.0 * line.error(x)[0, k] + 1e-14


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(-5, -1))
def test_worn_and_rounded_flats_without_their_breakpoints(R, ratio):
    b = R * 10.0**ratio
    x = b * np.array([1.05, 1.5, 4.0])
    away = np.sqrt((x - b) * (x + b))
    for f, truth in (
        (lambda r: np.maximum(r * r - b * b, 0.0) / (2 * R), x / R * away),
        (lambda r: np.maximum(r - b, 0.0) ** 2 / (2 * R), x / R * (away - b * np.arctan2(away, b))),
    ):
        line = equivalent_profile(mdr.Function(f))
        assert np.all(np.abs(line.g(x) / truth - 1) <= 10.0 * line.error(x)[:, 0] + 1e-12)
        assert np.max(line.error(x)[:, 0]) < 1e-11


def image_of_kink(b, order, x):
    """Of (r - b)^order beyond b, by the rule of Gauss and Jacobi for both powers in (r - b) / (x - b)."""
    away = np.longdouble(x) - np.longdouble(b)
    z, w = roots_jacobi(40, -0.5, order - 1.0)
    rest = np.sum(w / np.sqrt(b + x + away * (z + 1) / 2)) / 2 ** (order - 0.5)
    return float(x * order * away ** (np.longdouble(order) - 0.5) * rest)


@pytest.mark.parametrize("order", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("offset", [1e-3, 0.5])
def test_rounded_flats_under_an_offset_claim_about_what_they_err(order, offset):
    rng = np.random.default_rng([int(2 * order), int(1 / offset)])
    S = 10.0 ** rng.uniform(-9, 0)
    b, c = S * rng.uniform(0.2, 0.8), 10.0 ** rng.uniform(-2, 0)
    line = equivalent_profile(
        mdr.Function(lambda r: S * (offset + c * np.maximum((r - b) / S, 0.0) ** order))
    )
    x = b * np.array([1.02, 1.3, 2.0])
    truth = [c * S ** (1 - order) * image_of_kink(b, order, v) for v in x]
    miss, error = np.abs(line.g(x) / truth - 1), line.error(x)
    assert np.all(miss <= 10.0 * error[:, 0] + 1e-14)
    # the roundings of f in its rise; f' on narrow panels beside the flat knows less of it
    hidden = 2e-16 * offset / (c * ((x - b) / S) ** order)
    assert np.all(error[:, [0, 2]] <= 5e3 * hidden[:, None] + 1e-11)


def error_next_to_a_kink(S, cone, kink, order, b, beyond):
    """Error of the contact radius just beyond a named kink of f alone, over what is claimed."""
    f = mdr.Function(lambda r: cone * (r / S) + kink * np.maximum((r - b) / S, 0.0) ** order, [b])
    a = np.longdouble(b) * (1 + np.longdouble(beyond))
    depth = float(cone / S * np.pi / 2 * a + kink / S**order * image_of_kink(b, order, a))
    result = mdr.solve(mdr.Contact(f, mdr.Elastic("1 GPa", 0.3)), mdr.indent(depth))
    error = float(np.max(result.claims["contact_radius"].error or 0.0))
    return float(abs(float(result["contact_radius"][0]) / a - 1)) / (10.0 * error + 1e-13)


def test_rounding_next_to_a_named_kink_is_no_further_kink():
    # f has the place of a kink of fractional order to 2e-14, and its slope between two such places is noise
    S, b = 7.1618437444431906e-06, 1.1893580436091455e-10
    heights = 1.2587737102802619e-08, 6.456114146643692e-08
    assert error_next_to_a_kink(S, *heights, 4 / 3, b, 1.3165e-10) <= 1.0


@pytest.mark.long
@settings(max_examples=examples(30), deadline=None)
@given(
    RADII, st.floats(-5, 0), st.floats(-2, 2), st.sampled_from([1.2, 4 / 3, 1.5, 1.75]), st.floats(-5, 0),
    st.floats(-13, -1),
)  # fmt: skip
def test_contacts_next_to_a_named_kink_of_fractional_order_err_as_claimed(S, steep, more, order, at, beyond):
    cone = S * 10.0**steep
    assert error_next_to_a_kink(S, cone, cone * 10.0**more, order, S * 10.0**at, 10.0**beyond) <= 1.0


@pytest.mark.parametrize("gives", ["f", "derivative"])
@pytest.mark.parametrize("order", [1.5, 2.0, 3.0])
def test_a_breakpoint_next_to_a_kink_of_higher_order_is_no_error(order, gives):
    rng = np.random.default_rng([int(2 * order), len(gives)])
    for off in 10.0 ** rng.uniform(-11, -4, 3):
        S = 10.0 ** rng.uniform(-9, 0)
        b = S * rng.uniform(0.2, 0.8)
        named = b * (1 + rng.choice([-1, 1]) * off)
        profile = of(
            lambda r, b=b, S=S: 0.01 * r + 0.04 * S * np.maximum((r - b) / S, 0.0) ** order,
            lambda r, b=b, S=S: 0.01 + 0.04 * order * np.maximum((r - b) / S, 0.0) ** (order - 1),
            gives,
            [named],
        )
        line, x = equivalent_profile(profile), b * np.array([1 + 3e-6, 1.0001, 1.01, 1.3])
        truth = [0.005 * math.pi * v + 0.04 * S ** (1 - order) * image_of_kink(b, order, v) for v in x]
        assert np.all(np.abs(line.g(x) / truth - 1) <= 10.0 * line.error(x)[:, 0] + 2e-13)


# --- splines -------------------------------------------------------------------------------------------


def image_of(spline, x):
    """Of a piecewise polynomial f, with x = r sin t piece by piece in extended precision."""
    z, w = (np.asarray(v, dtype=np.longdouble) for v in np.polynomial.legendre.leggauss(40))
    x, slope = np.longdouble(x), spline.derivative()
    marks = [0.0, *(k for k in spline.x if 0.0 < k < x), x]
    total = np.longdouble(0)
    for low, high in itertools.pairwise(marks):
        first, last = np.arcsin(np.longdouble(low) / x), np.arcsin(np.longdouble(high) / x)
        i = int(np.clip(np.searchsorted(spline.x, float(low + high) / 2) - 1, 0, spline.x.size - 2))
        away = x * np.sin((first + last) / 2 + (last - first) / 2 * z) - np.longdouble(spline.x[i])
        total += (last - first) / 2 * np.sum(w * np.polyval(slope.c[:, i].astype(np.longdouble), away))
    return float(x * total)


SPLINES = [(kind, seed) for seed in range(9) for kind in ("quadratic", "pchip", "akima", "cubic")]


def spline_of(kind, seed):
    """A random spline and its end."""
    from scipy import interpolate

    rng = np.random.default_rng([seed, len(kind)])
    count, R = int(rng.integers(6, 9 if seed == 0 else 30)), 10.0 ** rng.uniform(-9, 0)
    r = np.concatenate([[0.0], np.cumsum(1 + rng.uniform(0, 0.6) * rng.uniform(-1, 1, count))])
    r *= R / r[-1]
    h = 0.1 * R * (r / R) ** rng.uniform(1.2, 3) * (1 + 0.05 * rng.uniform(-1, 1) * np.sin(5 * r / R))
    if kind == "quadratic":
        whole = interpolate.PPoly.from_spline(interpolate.make_interp_spline(r, h, k=2))
        kept = np.flatnonzero(np.diff(whole.x) > 0.0)
        return interpolate.PPoly(whole.c[:, kept], np.append(whole.x[kept], whole.x[-1])), R
    if kind == "cubic":
        return interpolate.CubicSpline(r, h, bc_type=((1, 0.0), "not-a-knot")), R
    return {"pchip": interpolate.PchipInterpolator, "akima": interpolate.Akima1DInterpolator}[kind](r, h), R


@pytest.mark.long
@pytest.mark.parametrize("case", SPLINES)
def test_splines_given_as_f_alone_claim_what_they_err(case):
    spline, R = spline_of(*case)
    line = equivalent_profile(mdr.Function(lambda x: spline(x), max_radius=R))
    x = R * np.array([0.3, 0.6, 0.95])
    miss = np.abs(line.g(x) / [image_of(spline, float(v)) for v in x] - 1)
    error = line.error(x)
    assert np.all(miss <= 10.0 * error[:, 0] + 1e-14)
    assert np.max(error[:, 0]) < 1e-11
    steep = mdr.Function(
        lambda x: spline(x), derivative=spline.derivative(), breakpoints=tuple(spline.x[1:-1]), max_radius=R
    )
    missed = np.abs(line.slope(x) / equivalent_profile(steep).slope(x) - 1)
    assert np.all(missed <= 10.0 * error[:, 1] + 1e-12)


@pytest.mark.long
@pytest.mark.parametrize("case", SPLINES)
def test_slopes_of_splines_given_as_f_alone_have_nine_digits(case):
    spline, R = spline_of(*case)
    line = equivalent_profile(mdr.Function(lambda x: spline(x), max_radius=R))
    assert np.max(line.error(R * np.array([0.3, 0.6, 0.95]))[:, 1]) < 1e-9


# --- how far maps go -------------------------------------------------------------------------------------


@pytest.mark.parametrize("gives", ["f", "derivative"])
def test_a_falling_part_does_not_shorten_the_steps_outward(gives, monkeypatch):
    from pymdr.mapping.equivalent.panels import PanelLine

    counted, extend = SimpleNamespace(n=0), PanelLine._extend

    def counting(*arguments):
        counted.n += 1
        return extend(*arguments)

    monkeypatch.setattr(PanelLine, "_extend", counting)
    line = equivalent_profile(mdr.Paraboloid(1e-3) + of(lambda r: -480 * r * r, lambda r: -960 * r, gives))
    # f = 20 r^2, g = 40 x^2
    x = float(line.inverse(1e-6))
    assert x == pytest.approx((1e-6 / 40) ** 0.5, rel=1e-11)
    assert counted.n < 8


def test_a_part_that_nearly_cancels_is_mapped_only_where_it_matters():
    # f = r^2 of 500 r^2 - 499 r^2
    line = equivalent_profile(mdr.Paraboloid(1e-3) + mdr.Function(lambda r: -499 * r * r))
    assert float(line.inverse(1e-6)) == pytest.approx((1e-6 / 2) ** 0.5, rel=1e-11)
    assert line._resolved.slopes.panels.count < 500


@settings(max_examples=COUNT, deadline=None)
@given(RADII, st.floats(20, 60), st.floats(-2.5, -1.5), st.lists(st.floats(-1, 0.5), min_size=1, max_size=4))
def test_lines_do_not_depend_on_what_was_computed_before(R, waves, height, before):
    def line():
        return equivalent_profile(
            mdr.Function(
                lambda r: r * r / (2 * R) + 10.0**height * R / waves * (1 - np.cos(waves * r / R)),
                derivative=lambda r: r / R + 10.0**height * np.sin(waves * r / R),
            )
        )

    used, top, depth = line(), 0.3 * R, 0.01 * R
    for factor in before:
        used.overlap_radius(depth * 10.0**factor)
        used.turning_points(top * 2.0 ** min(factor, 0.0))
    used.map_to(top)
    assert used.overlap_radius(depth) == pytest.approx(line().overlap_radius(depth), rel=1e-12)
    assert used.turning_points(top) == pytest.approx(line().turning_points(top), rel=1e-9)


@pytest.mark.long
def test_what_was_saved_of_a_callable_refuses_radii_beyond_it(tmp_path):
    def kinked(r):
        return r * r / 2e-3 + 0.05 * np.maximum(r - 1e-5, 0.0)

    result = mdr.solve(
        mdr.Contact(mdr.Function(kinked), mdr.Elastic("1 GPa", 0.3)), mdr.indent("1 um", steps=2)
    )
    a = result["contact_radius"].values[-1]
    copy = pickle.loads(pickle.dumps(result))
    result.save(tmp_path / "saved.nc")
    for known in (copy, mdr.open_result(tmp_path / "saved.nc")):
        assert known.field("gap", r=[1.5 * a, 1.99 * a]).values == pytest.approx(
            result.field("gap", r=[1.5 * a, 1.99 * a]).values, rel=1e-9
        )
        assert np.isfinite(known.field("gap").values).all()
        with pytest.raises(mdr.ProblemError, match=r"gap at r = .* callable; a saved .* up to r = "):
            known.field("gap", r=9.0 * a)
    # what is still callable goes on
    assert np.isfinite(result.field("gap", r=9.0 * a).values).all()


@settings(max_examples=examples(24), deadline=None)
@given(st.floats(-9.0, 0.0), st.floats(-12.0, -1.0), st.floats(-3.0, 0.0), st.floats(-16.0, -1.0))
def test_contacts_just_beyond_a_kink_under_an_offset_err_as_claimed(scale, beyond, steep, offset):
    b, slope = 10.0**scale, 10.0**steep
    lift = 10.0**offset * b
    wheel = mdr.Function(lambda r: slope * np.maximum(np.asarray(r) - b, 0.0) + lift, max_radius=100.0 * b)
    depth = slope * b * 10.0**beyond
    result = mdr.solve(mdr.Contact(wheel, mdr.Elastic("1 GPa", 0.3)), mdr.indent(depth))
    # g = slope x arccos(b / x)
    angle = brentq(lambda t: t - 10.0**beyond * math.cos(t), 0.0, 1.0, xtol=1e-300, rtol=1e-15)
    truth = b / math.cos(angle)
    computed, claim = float(result["contact_radius"][0]), result.claims["contact_radius"]
    allowed = 10.0 * (0.0 if claim.error is None else float(claim.error[0])) + 1e-13
    assert abs(computed / truth - 1.0) <= allowed
