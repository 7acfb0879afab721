"""Measured profiles, their scatter, CSV files, and the rings beside the method."""

import math
import pickle
import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import UNIT
from drawing import examples
from legibility import faults
from pymdr.mapping import abel, abel_sums, images, sources
from pymdr.mapping.equivalent import PanelLine, equivalent_profile
from pymdr.numerics.panels import Place
from pymdr.problem.codec import decode_case, encode_case
from pymdr.problem.profiles import smoothing
from pymdr.units import metres
from pymdr.workbench.casefile import read_case

PARTICLE = Path(__file__).parent.parent.parent / "shared" / "data" / "profiles" / "afm_particle.csv"


def smooth(r):
    return r**2 / 2 + 0.1 * r**4


def smooth_g(x):
    return x**2 + 0.1 * 8 / 3 * x**4


def sampled(n, f=smooth, **options):
    r = np.linspace(0.0, 1.0, n)
    return mdr.Sampled(r, f(r), **options)


@pytest.mark.parametrize(
    "interpolation",
    [mdr.CubicSpline(), mdr.CubicSpline("sharp"), mdr.ShapePreserving(), mdr.SmoothingSpline()],
)
def test_the_map_is_the_quadrature(interpolation):
    tip = sampled(12, interpolation=interpolation)
    x = np.concatenate([np.geomspace(1e-9, 0.09, 9), [1 / 11, 0.5, 0.5000001, 0.99, 1.0]])
    line = equivalent_profile(tip)
    by_quadrature = abel.forward(tip.gap_slope, x, breakpoints=tip.breakpoints)
    assert np.max(np.abs(line.g(x) / by_quadrature - 1.0)) < 1e-13
    assert np.max(np.abs(line.inverse(by_quadrature)[:-1] / x[:-1] - 1.0)) < 1e-13
    assert np.isnan(line.g(1.0001))


@pytest.mark.parametrize(
    ("interpolation", "f", "g", "order"),
    [
        (mdr.CubicSpline(), smooth, smooth_g, 3.4),
        (
            mdr.CubicSpline("sharp"),
            lambda r: 0.3 * r + smooth(r),
            lambda x: 0.3 * np.pi / 2 * x + smooth_g(x),
            3.0,
        ),
        (mdr.ShapePreserving(), smooth, smooth_g, 1.8),
        (mdr.SmoothingSpline(), smooth, smooth_g, 3.4),
    ],
)
def test_orders_of_convergence(interpolation, f, g, order):
    x = np.linspace(0.05, 0.9, 60)
    counts = np.array([21, 41, 81, 161])
    error = [
        np.max(np.abs(equivalent_profile(sampled(n, f, interpolation=interpolation)).g(x) - g(x)))
        for n in counts
    ]
    measured = -np.polyfit(np.log(counts), np.log(error), 1)[0]
    assert measured > order


@pytest.mark.parametrize("scale", [1e-9, 1e3])
def test_samples_rescale(scale):
    r = np.linspace(0.0, 1.0, 31)
    forces = [
        mdr.solve(mdr.Contact(mdr.Sampled(r * s, smooth(r) * s), UNIT), mdr.indent(0.3 * s, steps=3))[
            "normal_force"
        ].values
        / s**2
        for s in (1.0, scale)
    ]
    assert np.max(np.abs(forces[1] / forces[0] - 1)) < 1e-11


def test_many_samples():
    tip = sampled(20001)
    line = equivalent_profile(tip)
    x = np.linspace(0.01, 1.0, 101)
    assert np.max(np.abs(line.g(x) / smooth_g(x) - 1.0)) < 1e-9
    result = mdr.solve(mdr.Contact(tip, UNIT), mdr.indent(0.2, steps=3))
    exact = mdr.solve(
        mdr.Contact(mdr.Paraboloid(1.0) + mdr.PowerLaw(4, 0.1, 1.0), UNIT), mdr.indent(0.2, steps=3)
    )
    assert result["normal_force"].values == pytest.approx(exact["normal_force"].values, rel=1e-9)


def test_shape_preserving_keeps_a_kink():
    def kinked(r):
        return 0.1 * r + np.maximum(r - 0.5, 0.0)

    tip = sampled(201, kinked, interpolation=mdr.ShapePreserving())
    r = np.linspace(0.0, 1.0, 777)
    assert np.max(np.abs(tip.gap(r) - kinked(r))) < 2e-3
    assert np.all(np.diff(tip.gap(r)) > 0)


def test_smoothing_halves_the_noise():
    rng = np.random.default_rng(3)
    r = np.linspace(0.0, 1.0, 400)
    noise = 1e-3 * rng.standard_normal(r.size)
    noise[0] = 0.0
    tip = mdr.Sampled(r, r**2 / 2 + noise, interpolation=mdr.SmoothingSpline())
    error = tip.gap(r) - r**2 / 2
    assert np.std(error - error.mean()) < 0.5e-3


# --- smoothing -------------------------------------------------------------------------------------------


scales = st.floats(-12.0, 6.0).map(lambda decades: 10.0**decades)
INTERPOLATIONS = [mdr.CubicSpline(), mdr.CubicSpline("sharp"), mdr.ShapePreserving(), mdr.SmoothingSpline()]


@st.composite
def spacings(draw, fewest=5, most=200, closest=6.0):
    """Radii from 0 to 1, at even, graded, geometric, random or nearly merged distances."""
    n = draw(st.integers(fewest, most))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["even", "graded", "geometric", "random", "merged"]))
    if kind == "geometric":
        r = np.concatenate([[0.0], np.geomspace(10.0 ** -draw(st.floats(0.5, 20.0)), 1.0, n - 1)])
    else:
        r = np.linspace(0.0, 1.0, n) ** (draw(st.floats(1.0, 4.0)) if kind == "graded" else 1.0)
    if kind == "random":
        r = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-closest, 0.0, n - 1))])
    if kind == "merged":
        i = rng.integers(1, n - 1)
        nearby = r[i + 1] * (1.0 - 10.0 ** -rng.uniform(2.0, min(2.0 + closest, 8.5)))
        r[i] = max(nearby, 0.5 * (r[i - 1] + r[i + 1]))
    return r / r[-1]


@settings(max_examples=examples(150), deadline=None)
@given(spacings(), scales, scales)
def test_a_paraboloid_is_smoothed_to_itself_at_any_radii(r, width, size):
    """From graded radii came 0.41 of the depth, from geometric ones an error of the solver."""
    tip = mdr.Sampled(r * width, r**2 * size, interpolation=mdr.SmoothingSpline())
    x = np.concatenate([r[1] * np.array([1e-6, 0.5]), 0.5 * (r[1:] + r[:-1]), r[1:]])
    assert np.max(np.abs(tip.gap(x * width)[:-1] / (size * x[:-1] ** 2) - 1.0)) < 1e-9
    assert np.max(np.abs(tip.gap_slope(x * width)[:-1] * width / (2.0 * size * x[:-1]) - 1.0)) < 1e-9
    assert tip.gap_slope(0.0) == 0.0


@settings(max_examples=examples(60), deadline=None)
@given(spacings(fewest=30), st.floats(0.5, 3.0), st.floats(-0.5, 0.5))
def test_smooth_samples_without_noise_are_met(r, k, b):
    f = r**2 + b * (1.0 - np.cos(k * r))
    tip = mdr.Sampled(r, f, interpolation=mdr.SmoothingSpline())
    assert np.max(np.abs(tip.gap(r) - f)) < 1e-8 * np.max(np.abs(f))


@settings(max_examples=examples(60), deadline=None)
@given(spacings(fewest=40), scales, scales, st.floats(-5.0, -1.0), st.integers(0, 2**32 - 1), st.booleans())
def test_noise_is_taken_away_alike_at_all_scales(r, width, size, decades, seed, misfit_given):
    noise = 10.0**decades
    error = noise * np.random.default_rng(seed).standard_normal(r.size)
    scatter = np.where(r > 0.0, noise, 0.0) if misfit_given else None
    kept = []
    for w, s in ((1.0, 1.0), (width, size)):
        tip = mdr.Sampled(
            r * w, (r**2 + error) * s, None if scatter is None else scatter * s, mdr.SmoothingSpline()
        )
        kept.append((tip.gap(tip.radius) + tip.offset) / s)
    assert np.sqrt(np.mean((kept[0] - r**2) ** 2)) < 1.1 * np.sqrt(np.mean(error**2))
    assert np.max(np.abs(kept[1] - kept[0])) < 1e-4 * noise


@settings(max_examples=examples(40), deadline=None)
@given(spacings(most=14, closest=1.5), st.floats(-2.0, 7.0), st.integers(0, 2**32 - 1))
def test_the_filter_solves_the_dense_equations(r, decades, seed):
    """Kernel of the noise of the third derivative; f0 + kappa r^2 / 2 by generalised least squares."""
    rng = np.random.default_rng(seed)
    y, drive = rng.standard_normal(r.size), 10.0 ** (decades / 2.0)
    weight = 10.0 ** rng.uniform(-1.0, 1.0, r.size)
    u, gauss = np.polynomial.legendre.leggauss(3)
    least = np.minimum(r[:, None], r)
    at = least[..., None] * (1.0 + u) / 2.0
    both = (r[:, None, None] - at) ** 2 * (r[:, None] - at) ** 2 / 4.0
    covariance = np.diag(weight) + drive**2 * (both @ gauss) * least / 2.0
    trend = np.stack([np.ones(r.size), r**2 / 2.0], axis=1)
    inverse = np.linalg.inv(covariance)
    beta = np.linalg.solve(trend.T @ inverse @ trend, trend.T @ inverse @ y)
    left = inverse @ (y - trend @ beta)
    determinant, misfit, level, bend = smoothing.likelihood(r, y, weight, drive)
    assert misfit == pytest.approx((y - trend @ beta) @ left, rel=1e-6)
    determinants = np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(trend.T @ inverse @ trend)[1]
    assert determinant == pytest.approx(determinants, rel=1e-6, abs=1e-6)
    values, _ = smoothing.smoothed(r, y - level, weight, drive, bend)
    assert values[:, 0] + level == pytest.approx(y - weight * left, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("n", [5, 6, 8, 12, 20])
def test_few_noisy_samples(n):
    r, rng = np.linspace(0.0, 1.0, n), np.random.default_rng(n)
    x = np.linspace(0.0, 1.0, 101)
    for scatter in (None, np.full(n, 1e-3)):
        for _ in range(20):
            height = r**2 / 2 + 1e-3 * rng.standard_normal(n)
            tip = mdr.Sampled(r, height, scatter, mdr.SmoothingSpline())
            assert np.max(np.abs(tip.gap_slope(x) - x)) < 0.05


@pytest.mark.long
def test_a_hundred_thousand_noisy_samples():
    r = np.linspace(0.0, 1.0, 100_001)
    rng = np.random.default_rng(5)
    for radius in (r, r**2):
        height = 0.36 * (np.hypot(radius, 0.13) - 0.13) + 1e-3 * rng.standard_normal(r.size)
        tip = mdr.Sampled(radius, height, interpolation=mdr.SmoothingSpline())
        true = 0.36 * (np.hypot(r, 0.13) - 0.13)
        assert np.max(np.abs(tip.gap(r) + tip.offset - true)) < 2e-4
        assert tip.noise == pytest.approx(1e-3, rel=0.03)


@pytest.mark.parametrize("where", [0, 7, 100, -1])
def test_an_outlier_affects_its_neighbourhood_only(where):
    rng = np.random.default_rng(2)
    r = np.linspace(0.0, 1.0, 200)
    height = r**2 / 2 + 1e-3 * rng.standard_normal(r.size)
    height[where] += 0.1
    tip = mdr.Sampled(r, height, interpolation=mdr.SmoothingSpline())
    error = np.abs(tip.gap(r) + tip.offset - r**2 / 2)
    assert np.max(error[np.abs(r - r[where]) > 0.1]) < 2e-3
    assert tip.noise == pytest.approx(1e-3, rel=0.2)
    if where != -1:  # at the end of the samples nothing holds the curve back
        assert np.max(error) < 5e-3


@settings(max_examples=examples(20), deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-9.0, 2.0), st.floats(-6.0, -2.0))
def test_claims_of_a_fitted_curve_say_so(seed, decades, noise):
    size = 10.0**decades
    rng = np.random.default_rng(seed)
    r = size * np.append(0.0, np.sort(rng.uniform(0.02, 1.0, 40)))
    height = r * (r / (2.0 * size)) + size * 10.0**noise * rng.normal(size=r.size)
    tip = mdr.Sampled(r, height, interpolation=mdr.SmoothingSpline())
    off = (height - tip.offset - tip.gap(r)) / size
    assert tip.misfit == pytest.approx(size * math.sqrt(np.mean(off**2)), rel=1e-6)
    words = re.escape(f"with a misfit of {metres(tip.misfit)} (root mean square)")
    assert re.search(words, tip.curve_description)
    for profile in (tip, tip + mdr.Paraboloid(9.0 * size)):
        assessed = mdr.assess(mdr.Contact(profile, UNIT), mdr.indent(1e-3 * size))
        claim = assessed.claims["force_lower_bound"]
        assert re.search(f"; of the fitted curve, {words}", claim.reason)
    through = mdr.Sampled(r, height, interpolation=mdr.CubicSpline())
    assert through.misfit == 0.0
    assert (
        "fitted"
        not in mdr.assess(mdr.Contact(through, UNIT), mdr.indent(1e-3 * size))
        .claims["force_lower_bound"]
        .reason
    )


def test_a_scatter_smooths_unless_another_curve_is_named():
    r = np.linspace(0.0, 1.0, 101)
    scatter = np.where(r > 0.0, 1e-3, 0.0)
    height = r**2 / 2 + 1e-3 * np.random.default_rng(4).standard_normal(r.size)
    tip = mdr.Sampled(r, height, scatter)
    assert tip == mdr.Sampled(r, height, scatter, mdr.SmoothingSpline())
    assert "by the scatter; the residuals are" in tip.curve_description
    residual = (tip.gap(r) + tip.offset - height)[1:] / scatter[1:]
    assert 0.8 < np.mean(residual**2) < 1.2
    assert np.all(tip.gap_slope(r[1:]) > 0.0)
    assert mdr.Sampled(r, height).interpolation == mdr.CubicSpline()
    assert mdr.Sampled(r, height, 0.0 * r).interpolation == mdr.CubicSpline()
    through = mdr.Sampled(r, height, scatter, mdr.CubicSpline("sharp"))
    assert through.curve_description == "a cubic spline with a sharp tip through every sample"
    assert np.array_equal(through.gap(r[:-1]), (height - height[0])[:-1])
    shape = mdr.Sampled(r, height, scatter, mdr.ShapePreserving())
    assert shape.curve_description.startswith("a shape-preserving cubic")
    assert mdr.solve(mdr.Contact(tip, UNIT), mdr.indent(0.2)).status is mdr.Status.COMPLETED


@pytest.mark.parametrize("times", [1e-9, 0.25, 1.0, 4.0, 1e9])
@pytest.mark.parametrize("n", [41, 400])
def test_a_scatter_that_the_samples_contradict_only_weighs_them(times, n):
    r = np.linspace(0.0, 1.0, n)
    f, slope = 0.36 * (np.hypot(r, 0.13) - 0.13), 0.36 * r / np.hypot(r, 0.13)
    for seed in range(5):
        noise = np.random.default_rng(seed).standard_normal(n) * 1e-3 * (1.0 + r)
        tip = mdr.Sampled(r, f + noise, times * 1e-3 * np.where(r > 0.0, 1.0 + r, 0.0))
        assert np.std(tip.gap_slope(r) - slope) < 0.03
        assert ("by the scatter;" in tip.curve_description) == (times == 1.0)


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.sampled_from([0.0, 1e-300, 1e-12, 1e-3, 1.0]), min_size=30, max_size=30), scales)
def test_no_scatter_breaks_the_curve(scatter, size):
    r = np.linspace(0.0, 1.0, 30)
    height = r**2 + 1e-3 * np.random.default_rng(1).standard_normal(30)
    tip = mdr.Sampled(r, size * height, size * np.array(scatter))
    assert np.isfinite(tip.spline.c).all()
    # samples told to be exact may leave the others to be extrapolated
    assert np.max(np.abs(tip.gap(r) - size * r**2)) < 0.5 * size
    assert tip.curve_description


@pytest.mark.parametrize(
    "interpolation", [None, mdr.CubicSpline("sharp"), mdr.ShapePreserving(), mdr.SmoothingSpline()]
)
@pytest.mark.parametrize("misfit_given", [False, True])
def test_scatter_and_curve_survive_files(tmp_path, interpolation, misfit_given):
    r = np.linspace(0.0, 1.0, 21)
    scatter = 1e-3 * r if misfit_given else None
    tip = mdr.Sampled(r, smooth(r), scatter, interpolation)
    contact, path = mdr.Contact(tip, UNIT), mdr.indent(0.1)
    assert decode_case(encode_case("", contact, path))[1] == contact
    case = encode_case("", contact, path)
    if interpolation is None:
        del case["profile"]["interpolation"]
        assert decode_case(case)[1] == contact
    mdr.solve(contact, path).save(tmp_path / "r.nc")
    assert mdr.open_result(tmp_path / "r.nc").contact == contact


def test_a_csv_file_with_a_scatter_is_smoothed(tmp_path):
    (tmp_path / "t.csv").write_text(GOOD)
    assert mdr.read_profile(tmp_path / "t.csv").interpolation == mdr.SmoothingSpline()
    (tmp_path / "u.csv").write_text(GOOD.replace("scatter", "other"))
    assert mdr.read_profile(tmp_path / "u.csv").interpolation == mdr.CubicSpline()


# --- curves through every sample -------------------------------------------------------------------------


@settings(max_examples=examples(150), deadline=None)
@given(spacings(), scales, st.sampled_from([0.0, 1e-9, 1e-3, 1.0]), st.integers(0, 2**32 - 1))
def test_curves_meet_their_samples(r, scale, noise, seed):
    height = scale * (0.3 + r**2 + noise * np.random.default_rng(seed).standard_normal(r.size))
    radius = scale * r
    for interpolation in INTERPOLATIONS:
        tip = mdr.Sampled(radius, height, interpolation=interpolation)
        spline = tip.spline
        assert np.array_equal(spline.x, radius)
        assert np.isfinite(spline.c).all()
        assert tip.gap(0.0) == 0.0
        if isinstance(interpolation, mdr.SmoothingSpline):
            continue
        raised = height - height[0]
        assert np.array_equal(tip.gap(radius[:-1]), raised[:-1])
        h = np.diff(radius)
        terms = spline.c * h ** np.arange(3.0, -1.0, -1.0)[:, None]
        allowed = 1e-14 * (np.abs(terms).sum(axis=0) + np.abs(raised[1:]))
        assert np.all(np.abs(terms.sum(axis=0) - raised[1:]) <= allowed)
        if isinstance(interpolation, mdr.ShapePreserving):
            continue
        if interpolation.tip == "round":
            assert tip.gap_slope(0.0) == 0.0
        slopes = spline.c[2] + h * (2.0 * spline.c[1] + 3.0 * h * spline.c[0])
        steepest = np.max(np.abs(spline.c[2])) + np.max(np.abs(np.diff(raised)) / h)
        assert np.max(np.abs(slopes[:-1] - spline.c[2, 1:])) <= 1e-12 * steepest


@settings(max_examples=examples(60), deadline=None)
@given(spacings(fewest=30, closest=1.0), scales)
def test_a_cubic_spline_meets_cubics(r, scale):
    """Round tips and ends without a knot leave a cubic alone, next to the tip to all its digits."""
    x = np.concatenate([r[1] * np.array([1e-6, 0.5]), 0.5 * (r[1:] + r[:-1])])
    for tip, first in (("round", 0.0), ("sharp", 1.0)):
        sampled = mdr.Sampled(
            scale * r, scale * (first * r + r**2 + r**3), interpolation=mdr.CubicSpline(tip)
        )
        assert np.max(np.abs(sampled.gap(scale * x) / (scale * (first * x + x**2 + x**3)) - 1.0)) < 1e-9
        assert np.max(np.abs(sampled.gap_slope(scale * x) / (first + 2 * x + 3 * x**2) - 1.0)) < 1e-6


def test_what_a_profile_keeps_is_its_own():
    r = np.linspace(0.0, 1.0, 21)
    height, scatter = smooth(r), 1e-3 * r
    tip = mdr.Sampled(r, height, scatter)
    before = float(tip.gap(0.5))
    for mine in (r, height, scatter):
        mine[:] = 7.0
    assert float(tip.gap(0.5)) == before
    for kept in (tip.radius, tip.height, tip.scatter, tip.spline.c, tip.spline.x):
        with pytest.raises(ValueError, match="read-only"):
            kept[...] = 0.0
    assert pickle.loads(pickle.dumps(tip)) == tip


# --- noise -----------------------------------------------------------------------------------------------


@settings(max_examples=examples(80), deadline=None)
@given(spacings(fewest=300, most=500), scales, scales, st.floats(-6.0, -3.0), st.integers(0, 2**32 - 1))
def test_the_noise_is_reported(r, width, size, decades, seed):
    noise = 10.0**decades * size
    error = noise * np.random.default_rng(seed).standard_normal(r.size)
    # at uneven distances one difference in three is new: a median of 100 sizes has a deviation of 0.12
    assert 0.5 < mdr.Sampled(width * r, size * r**2 + error).noise / noise < 1.6
    assert mdr.Sampled(width * r, size * r**2).noise < 1e-15 * size


def test_noise_is_neither_a_kink_nor_an_offset():
    r = np.linspace(0.0, 40e-9, 41)
    assert mdr.Sampled(r, 0.4 * np.maximum(r - 8e-9, 0.0)).noise < 1e-23
    assert mdr.Sampled(r, 0.0 * r + 3.0).noise == 0.0
    dip = np.where(np.arange(41) == 1, -0.3e-12, 0.0)
    noisy = r**2 / 60e-9 + dip + 1e-12 * np.random.default_rng(0).standard_normal(41)
    assert 0.3e-12 < mdr.Sampled(r, noisy).noise < 2e-12


def test_nothing_is_extrapolated():
    contact = mdr.Contact(sampled(31), UNIT)
    deepest = float(equivalent_profile(contact.profile).g(1.0))
    words = (
        r"the contact would pass r = 1 m, the last radius at which the profile is known \(it is not extrapolated\); "
        r"the largest indentation that it allows is 1\.26667 m \(normal force 1\.76 N\): reduce the indentation"
    )
    with pytest.raises(mdr.PathError, match=r"indentation = 1\.279\d* m: " + words):
        mdr.solve(contact, mdr.indent(1.01 * deepest))
    with pytest.raises(mdr.PathError, match=r"normal_force = 1 kN: " + words):
        mdr.solve(contact, mdr.load(1e3))
    with pytest.raises(
        mdr.PathError, match=r"normal_force = 1 GN: a sphere cannot be pressed in by its radius, 1 m"
    ):
        mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.load(1e9))
    just = mdr.solve(contact, mdr.indent(deepest * (1.0 - 1e-9)))
    assert float(just["contact_radius"][0]) == pytest.approx(1.0, rel=1e-8)
    assert np.isnan(sampled(31).gap([1.1])).all()


def test_scatter_becomes_a_band():
    r = np.linspace(0.0, 1.0, 41)
    scatter = 0.02 * r
    curve = mdr.CubicSpline()
    contact = mdr.Contact(mdr.Sampled(r, smooth(r), scatter, curve), UNIT)
    result = mdr.solve(contact, mdr.indent(0.2, steps=4))
    low, high = result.bands["normal_force"]
    assert np.all((low < result["normal_force"].values) & (result["normal_force"].values < high))
    for sign, end in ((1.0, low), (-1.0, high)):
        shifted = mdr.Contact(mdr.Sampled(r, smooth(r) + sign * scatter), UNIT)
        assert mdr.solve(shifted, mdr.indent(0.2, steps=4))["normal_force"].values == pytest.approx(
            end, rel=1e-13
        )
    assert "indentation" not in result.bands
    assert result.claims["normal_force"].level is mdr.Level.APPROXIMATE
    assert "lower bound" in result.claims["normal_force"].reason
    assert "sensitivity" in result.notes[-1]
    assert pickle.loads(pickle.dumps(result)).data.identical(result.data)
    assert result.plot().axes[0].axison


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.Sampled([0, 1, 2], [0, 1, 4]), "3 samples; at least 5"),
        (lambda: mdr.Sampled([0, 1, 2, 3, 4], [0, 1, 4]), "3 entries of height for 5 radii"),
        (lambda: mdr.Sampled([0, 1, 2, 2, 4], [0, 1, 2, 3, 4]), "repeats at entry 4"),
        (lambda: mdr.Sampled([0, 1, 3, 2, 4], [0, 1, 2, 3, 4]), "falls at entry 4"),
        (lambda: mdr.Sampled([1, 2, 3, 4, 5], [0, 1, 2, 3, 4]), "begins at 1 m"),
        (
            lambda: mdr.Sampled(np.geomspace(1e-9, 1e-6, 9), np.arange(9.0)),
            "begins at 1 nm: it must begin at 0 m",
        ),
        (
            lambda: mdr.Sampled([0, 1, 2, 2 * (1 + 1e-12), 4], [0, 1, 2, 3, 4]),
            r"entries 3 and 4 \(2\.0 m, then 2\.000000000002 m\) are at a distance of 2\.0\d* pm.*average them",
        ),
        (lambda: mdr.Sampled([0, 5e-324, 1, 2, 3], [0, 1, 2, 3, 4]), "entry 2 is 5e-324 m, less than 1e-30"),
        (lambda: mdr.Sampled(np.arange(5) * 5e-324, [0, 1, 2, 3, 4]).spline, "overflow"),
        (lambda: mdr.Sampled([0, 1, 2, 3, 4], [-1e308, 0, 1, 3, 1e308]).spline, "overflow"),
        (lambda: mdr.Sampled(np.ma.masked_equal([0, 1, 2, 3, 4], 3), [0, 1, 2, 3, 4]), "masked"),
        (lambda: mdr.Sampled([0, 1, 2, 3, 4], np.ma.masked_equal([0, 1, 2, 3, 4], 3)), "masked"),
        (lambda: mdr.Sampled([0, 1, 2, 3, np.nan], [0, 1, 2, 3, 4]), "not finite"),
        (lambda: mdr.Sampled([0, 1, 2, 3, 4], [0, 1, 2, 3, 4], [0, 0, -1, 0, 0]), "at least 0 m"),
        (lambda: mdr.Sampled([0, 1, 2, 3, 4], [0, 1, 2, 3, 4], interpolation="cubic"), "CubicSpline"),
        (lambda: mdr.CubicSpline("pointed"), "'round'"),
        (lambda: mdr.Sampled([[0, 1], [2, 3]], [0, 1]), "one-dimensional array"),
    ],
)
def test_bad_samples(make, words):
    with pytest.raises((mdr.ProblemError, mdr.UnitError), match=words):
        make()


GOOD = "# a comment\nr [nm],f [um],scatter [nm],points\n0,0,0,1\n1,0.001,.1,8\n2,0.004,.1,8\n3,0.009,.1,8\n4,0.016,.1,9\n"


def test_csv_files_carry_their_units(tmp_path):
    (tmp_path / "t.csv").write_text(GOOD)
    tip = mdr.read_profile(tmp_path / "t.csv")
    assert tip.radius.tolist() == [0.0, 1e-9, 2e-9, 3e-9, 4e-9]
    assert tip.height[-1] == pytest.approx(16e-9, rel=1e-14)
    assert tip.scatter[1] == pytest.approx(1e-10, rel=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("r [nm]", "r", "has no unit"),
        ("r [nm]", "r [kg]", "does not fit"),
        ("r [nm]", "r [furlong per]", "radius|unit"),
        ("r [nm]", "x [nm]", "no column of radius"),
        ("scatter [nm]", "f [nm]", "2 columns of height"),
        ("2,0.004,.1,8", "2,0.004,.1", "line 5: 3 entries for 4 columns"),
        ("2,0.004,.1,8", "2,oops,.1,8", r"line 5: f \[um\] = 'oops'"),
        ("2,0.004,.1,8", "2,nan,.1,8", r"line 5: f \[um\] = 'nan'"),
        ("3,0.009", "2,0.009", "repeats"),
        ("3,0.009", "1,0.009", "falls"),
        (GOOD, "", "the file is empty"),
        ("3,0.009,.1,8\n4,0.016,.1,9\n", "", "at least 5"),
    ],
)
def test_csv_files_that_lie(tmp_path, old, new, words):
    (tmp_path / "t.csv").write_text(GOOD.replace(old, new))
    with pytest.raises((mdr.CaseError, mdr.ProblemError), match=words):
        mdr.read_profile(tmp_path / "t.csv")


def test_a_case_names_a_csv_in_its_folder(tmp_path):
    (tmp_path / "t.csv").write_text(GOOD)
    case = """
        [profile]
        kind = "sampled"
        file = "t.csv"
        interpolation = {kind = "cubic_spline", tip = "sharp"}
        [body]
        kind = "elastic"
        young = "3 GPa"
        poisson = 0.3
        [[path]]
        kind = "indent"
        indentation = "1 nm"
        """
    (tmp_path / "c.toml").write_text(case)
    profile = read_case(tmp_path / "c.toml").contact.profile
    assert profile == mdr.read_profile(tmp_path / "t.csv", interpolation=mdr.CubicSpline("sharp"))
    (tmp_path / "d.toml").write_text(case.replace("t.csv", "none.csv"))
    with pytest.raises(mdr.PymdrError, match=r"none\.csv"):
        read_case(tmp_path / "d.toml")
    (tmp_path / "e.toml").write_text(case.replace("cubic_spline", "cubic_splin"))
    with pytest.raises(mdr.CaseError, match="did you mean 'cubic_spline'"):
        read_case(tmp_path / "e.toml")


@pytest.mark.skipif(not PARTICLE.exists(), reason="the measured particle is not beside the project")
def test_a_measured_particle():
    tip = mdr.read_profile(PARTICLE, interpolation=mdr.ShapePreserving())
    result = mdr.solve(mdr.Contact(tip, mdr.Elastic("3 GPa", 0.35)), mdr.indent("12 nm", steps=40))
    where = result.claims["contact_radius"].where
    a = result["contact_radius"].values
    assert where[:29].all()
    assert np.nanmax(a[:30]) == pytest.approx(16.4e-9, rel=0.02)
    assert not where[32]
    assert where[-1]
    assert 50e-9 < a[-1] < 55e-9
    shallow = mdr.solve(result.contact, mdr.indent("9 nm"))
    slope = next(x for x in shallow.assumptions if x.name == "small slope")
    assert 0.5097 <= slope.measure < 0.54  # the steepest pair of samples rises by 0.5097
    assert not slope.met


# --- rings -----------------------------------------------------------------------------------------------


def test_rings_give_a_result_of_the_same_kind(tmp_path):
    contact = mdr.Contact(mdr.Sphere(1.0), UNIT)
    path = mdr.indent(0.05, steps=2) >> mdr.load(0.005) >> mdr.indent(-0.1)
    ring, line = mdr.solve(contact, path, solver=mdr.Rings(100)), mdr.solve(contact, path)
    assert ring.status is mdr.Status.BY_RINGS
    for name in ("indentation", "normal_force", "contact_radius", "normal_stiffness", "elastic_energy"):
        assert ring[name].values == pytest.approx(line[name].values, rel=1e-5)
        assert ring.claims[name].level is mdr.Level.APPROXIMATE
    assert "without the method of dimensionality reduction" in ring.claims["pressure"].reason
    ring.save(tmp_path / "r.nc")
    again = mdr.open_result(tmp_path / "r.nc")
    r = np.linspace(0.0, 0.3, 7)
    for name in ("pressure", "normal_displacement", "gap"):
        mine, theirs = (result.field(name, r=r, step=1).values for result in (ring, line))
        assert mine == pytest.approx(theirs, abs=2e-4 * np.max(np.abs(theirs)))
        assert again.field(name, r=r, step=1).values == pytest.approx(mine, rel=1e-9, abs=1e-12)
    assert ring.plot().axes
    with pytest.raises(mdr.ProblemError, match="Rings"):
        mdr.solve(contact, path, solver="rings")


def test_ring_indenters():
    c, R = 1e-3, 5e-3
    ring = mdr.Function(lambda r: ((r - c) ** 2 - c * c) / (2 * R), derivative=lambda r: (r - c) / R)
    contact = mdr.Contact(ring, mdr.Elastic("1 MPa", 0.5))
    for path in (mdr.indent("10 um", steps=2), mdr.load("1 mN"), mdr.Path(indentation=[-9e-5, -5e-5])):
        refused = mdr.solve(contact, path)
        assert refused.status is mdr.Status.REFUSED
        solved = mdr.solve(contact, path, solver=mdr.Rings(80))
        assert np.all(solved["inner_contact_radius"].values > 0.5e-3)
        if "indentation" in refused.data:
            assert np.all(refused["force_lower_bound"].values <= solved["normal_force"].values)
    untouched = mdr.solve(contact, mdr.indent("-0.2 mm"))
    assert untouched["normal_force"].values.tolist() == [0.0]


def test_verify_holds_both_side_by_side():
    result = mdr.verify(
        mdr.Contact(mdr.Cone(slope=0.3), UNIT), mdr.indent(0.1, steps=10), elements=100, steps=2
    )
    assert result.largest_difference < 1e-5
    assert result.data.sizes["step"] == 2
    assert float(result.data["pressure_difference"].max()) < 1e-3
    assert "MDR" in str(result)
    assert not faults(result.plot())
    hollow = mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / 2)
    refused = mdr.verify(mdr.Contact(hollow, UNIT), mdr.indent(0.3), elements=60, steps=1)
    assert np.isnan(refused.data["normal_force_mdr"].values).all()
    assert np.isfinite(refused.data["normal_force_rings"].values).all()
    assert not faults(refused.plot())


@settings(max_examples=examples(12), deadline=None)
@given(
    st.lists(st.tuples(st.floats(2, 12), st.floats(-0.03, 0.03), st.floats(0, 6)), min_size=1, max_size=3),
    st.floats(0.02, 0.3),
)
def test_the_bound_holds_against_rings(waves, depth):
    def f(r):
        return r * r / 2 + sum(h * (np.cos(p) - np.cos(k * r + p)) for k, h, p in waves)

    def slope(r):
        return r + sum(h * k * np.sin(k * r + p) for k, h, p in waves)

    contact = mdr.Contact(mdr.Function(f, derivative=slope), UNIT)
    path = mdr.indent(depth)
    result = mdr.solve(contact, path)
    ring = mdr.solve(contact, path, solver=mdr.Rings(120))
    bound, force = float(result["force_lower_bound"][0]), float(ring["normal_force"][0])
    assert bound <= force * (1 + 2e-4)
    if result.status is mdr.Status.COMPLETED:
        assert bound == pytest.approx(force, rel=2e-4)


@pytest.mark.long
def test_many_shape_preserving_samples_are_averaged_over():
    rng = np.random.default_rng(11)
    radius = 10.0 ** rng.uniform(-9.0, 0.0)
    r = np.linspace(0.0, 0.1 * radius, 40_000)
    height = r**2 / (radius + np.sqrt((radius - r) * (radius + r)))
    line = equivalent_profile(mdr.Sampled(r, height, interpolation=mdr.ShapePreserving()))
    x = np.geomspace(0.04, 0.09, 9) * radius
    error = np.abs(line.g(x) / (x * np.arctanh(x / radius)) - 1.0)
    assert np.all(error <= line.error(x)[:, 0] + 1e-11)
    assert np.all(line.error(x)[:, 0] < 1e-9)
    # where knots are far smaller than panels, few of them are left
    assert line.map_to(0.09 * radius).panels.count < 0.3 * r.size


@pytest.mark.parametrize("seed", [*range(20), 80, 190, 279])
def test_hollow_samples_under_force_are_solved_at_any_scale(seed):
    rng = np.random.default_rng(seed)
    n, size = int(rng.integers(5, 9)), 10.0 ** rng.uniform(-8, 0)
    heights = np.concatenate([[0.0], np.cumsum(rng.normal(0.5, 2.0, n - 1))])
    heights[-2:] = heights[:-2].max() + np.array([10.0, 30.0])
    profile = mdr.Sampled(
        np.linspace(0.0, 5.0, n) * size, heights * size * 1e-3, interpolation=mdr.ShapePreserving()
    )
    force = 1e9 * size**2 * 10.0 ** rng.uniform(-6.0, -3.2)
    result = mdr.solve(mdr.Contact(profile, mdr.Elastic("1 GPa", 0.3)), mdr.load(force, steps=3))
    assert float(result["normal_force"][-1]) == force


# --- many samples, against closed forms piece by piece ----------------------------------------------------


def closed_forms(spline, x):
    """g(x) and m(x) of a piecewise cubic to 40 digits: powers of r over sqrt(x^2 - r^2) have integrals in closed form."""
    with mpmath.workdps(40):
        x = mpmath.mpf(float(x))
        g = m = mpmath.mpf(0)
        for i in range(int(np.searchsorted(spline.x, float(x)))):
            a = mpmath.mpf(float(spline.x[i]))
            ends = a, min(mpmath.mpf(float(spline.x[i + 1])), x)
            third, second, first = (mpmath.mpf(float(c)) for c in spline.c[:3, i])
            parabola = first - 2 * second * a + 3 * third * a * a, 2 * second - 6 * third * a, 3 * third
            roots = [mpmath.sqrt((x - r) * (x + r)) for r in ends]
            powers = [mpmath.asin(ends[1] / x) - mpmath.asin(ends[0] / x), roots[0] - roots[1]]
            for k in (2, 3, 4):
                rim = ends[1] ** (k - 1) * roots[1] - ends[0] ** (k - 1) * roots[0]
                powers.append(((k - 1) * x * x * powers[k - 2] - rim) / k)
            g += sum(c * powers[k] for k, c in enumerate(parabola))
            m += sum(c * powers[k + 2] for k, c in enumerate(parabola))
        return float(x * g), float(m)


def measured(rng, n, noise, spread, size):
    """Noisy samples of a sphere whose distances differ by up to a factor."""
    r = np.concatenate([[0.0], np.cumsum(rng.uniform(1.0, spread, n - 1) ** rng.choice([-1.0, 1.0]))])
    r /= r[-1]
    height = smooth(r) + noise * rng.standard_normal(n) * (r > 0.0)
    return r * size, height * size


@pytest.mark.parametrize("compiled", [False, True])
@settings(max_examples=examples(12), deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(50, 700),
    st.sampled_from([0.0, 1e-9, 1e-4]),
    st.sampled_from([1.0, 1e3]),
    scales,
    st.sampled_from([mdr.CubicSpline(), mdr.ShapePreserving()]),
)
def test_maps_of_samples_err_by_what_they_claim(compiled, seed, n, noise, spread, size, interpolation):
    rng = np.random.default_rng(seed)
    r, height = measured(rng, n, noise, spread, size)
    tip = mdr.Sampled(r, height, interpolation=interpolation)
    with pytest.MonkeyPatch.context() as patch:
        if compiled:
            patch.setattr(abel_sums, "_MANY", 0)
            patch.setattr(images, "_MANY", 0)
            patch.setattr(sources, "MANY_KNOTS", 10)
        line = PanelLine(sources.source_of(tip))
        x = size * rng.uniform(0.02, 0.98, 4)
        computed = np.transpose([line.g(x), line.moment(x)])
        claimed = line.error(x)[:, [0, 2]]
    exact = np.array([closed_forms(tip.spline, place) for place in x])
    assert np.all(np.abs(computed / exact - 1.0) <= claimed + 2e-14)
    assert np.all(claimed * np.abs(exact) <= 1e-9 * np.max(np.abs(exact), axis=0))


def test_many_noisy_samples_have_a_panel_each():
    rng = np.random.default_rng(4)
    r, height = measured(rng, 3000, 1e-6, 1e3, 1e-6)
    tip = mdr.Sampled(r, height, interpolation=mdr.ShapePreserving())
    line = equivalent_profile(tip)
    x = np.array([0.9e-6])
    exact = closed_forms(tip.spline, x[0])
    assert abs(line.g(x)[0] / exact[0] - 1.0) <= line.error(x)[0, 0] + 1e-13
    assert line.error(x)[0, 0] < 1e-10
    assert abs(line.moment(x)[0] / exact[1] - 1.0) <= line.error(x)[0, 2] + 1e-13
    # averages in vain, and fits of parabolas, would make more
    assert line._resolved.slopes.panels.count < 1.1 * r.size


@pytest.mark.parametrize("compiled", [False, True])
def test_samples_that_begin_flat_keep_their_digits_next_to_the_flat(compiled, monkeypatch):
    if compiled:
        monkeypatch.setattr(abel_sums, "_MANY", 0)
        monkeypatch.setattr(sources, "MANY_KNOTS", 10)
    r = np.linspace(0.0, 1.0, 101)
    tip = mdr.Sampled(r, np.maximum(r - 0.3, 0.0) ** 2, interpolation=mdr.ShapePreserving())
    line = PanelLine(sources.source_of(tip))
    start = tip.spline.x[np.flatnonzero(tip.spline.c[:3].any(axis=0))[0]]
    place = Place(np.full(3, start), np.array([1e-12, 1e-8, 1e-3]))
    third, second = tip.spline.c[:2, np.searchsorted(tip.spline.x, start)]
    with mpmath.workdps(40):
        exact = [
            float(
                (b + d)
                * mpmath.quad(
                    lambda v, b=b, d=d: (
                        2
                        * (2 * mpmath.mpf(second) * (d - v * v) + 3 * mpmath.mpf(third) * (d - v * v) ** 2)
                        / mpmath.sqrt(2 * b + 2 * d - v * v)
                    ),
                    [0, mpmath.sqrt(d)],
                )
            )
            for b, d in zip(
                map(mpmath.mpf, place.base.tolist()), map(mpmath.mpf, place.offset.tolist()), strict=True
            )
        ]
    assert np.max(np.abs(line.g(place) / exact - 1.0)) < 1e-12


@settings(max_examples=examples(6), deadline=None)
@given(st.integers(30, 200), st.floats(1e-3, 1e-2), st.integers(0, 2**31), st.floats(1e-9, 1e-3))
def test_adhesion_on_noisy_samples_names_the_remedy(samples, noise, seed, size):
    """Refused, not valid or noted, with the line that smooths."""
    r = np.linspace(0.0, size, samples)
    f = r**2 / (2.0 * size) + noise * 0.5 * size * np.random.default_rng(seed).standard_normal(samples)
    law = mdr.JKR(1e-4 * size * 1e9)
    remedy = r"noise of about .*: smooth them with interpolation = \{ kind = 'smoothing_spline' \}, in Python with SmoothingSpline"

    def contact(**keys):
        return mdr.Contact(mdr.Sampled(r, f, **keys), mdr.Elastic("1 GPa", 0.3), adhesion=law)

    try:
        result = mdr.solve(contact(), mdr.indent(0.02 * size))
        words = [*result.notes, *(claim.reason for claim in result.claims.values())]
    except mdr.ProblemError as refusal:
        words = [str(refusal)]
    assert any(re.search(remedy, text) for text in words)
    smoothed = mdr.Sampled(r, f, interpolation=mdr.SmoothingSpline())
    assert smoothed.unsmoothed == ""


@pytest.mark.parametrize("samples", [8, 12, 20, 50])
def test_smooth_samples_have_no_noise_to_remedy(samples):
    r = np.linspace(0.0, 1.0, samples)
    for f in (r**2, 2.0 - np.sqrt(4.0 - r**2), 0.5 * r, 1.0 - np.cos(3.0 * r), r**4):
        assert mdr.Sampled(r, f).unsmoothed == ""
