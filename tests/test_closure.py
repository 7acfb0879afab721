"""Contacts that are known by their force curve: against the shapes of the curves, springs one by one, and boundary elements."""

import dataclasses
import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import pymdr as mdr
from common import STEEL
from drawing import examples
from pymdr.independent.sliding import HalfSpaceGrid, solve_sliding
from pymdr.independent.sliding.following import solve_pressure, solve_tractions
from pymdr.independent.sliding.surface import make_surface
from pymdr.interpretation.closure import OF_THE_CURVE, regrown
from pymdr.mapping.closure import closure_of
from pymdr.mapping.equivalent import PolygonLine
from pymdr.numerics.panels import Place

MODULUS = mdr.effective_moduli(STEEL, STEEL).normal
PLAIN = mdr.Elastic("210 GPa", 0.0)
"""On which Cattaneo and Mindlin are exact, so that errors are known."""
BALL = mdr.Paraboloid("10 mm")
DEEPEST = 2e-6


def hertz(depth):
    return 4.0 / 3.0 * MODULUS * math.sqrt(10e-3) * np.asarray(depth) ** 1.5


def curve_of_ball(n=200, noise=0.0, seed=0):
    d = np.linspace(0.0, DEEPEST, n + 1)[1:]
    force = hertz(d) + noise * hertz(DEEPEST) * np.random.default_rng(seed).standard_normal(n)
    return mdr.ForceCurve(d, force, modulus=MODULUS)


def stiffness(curve, depth):
    return closure_of(curve).stiffness.at(np.asarray(depth, dtype=float))[0]


def force(curve, depth):
    return closure_of(curve).stiffness.at(np.asarray(depth, dtype=float))[1]


# the line ----------------------------------------------------------------------------------------------------------


def polygons():
    steps = st.lists(
        st.tuples(st.floats(0.01, 1.0), st.one_of(st.just(0.0), st.floats(0.01, 1.0))), min_size=2, max_size=6
    )
    return steps.filter(lambda pairs: any(rise for _, rise in pairs))


@settings(max_examples=examples(40), deadline=None)
@given(polygons(), st.floats(0.01, 0.99), st.sampled_from([1e-9, 1.0, 1e3]))
def test_integrals_of_a_polygon_are_those_of_quadrature(steps, part, scale):
    x = scale * np.append(0.0, np.cumsum([width for width, _ in steps]))
    g = scale * np.append(0.0, np.cumsum([rise for _, rise in steps]))
    line = PolygonLine(x, g)
    top = part * line.max_radius
    inside = [b for b in x if 0.0 < b < top]
    depth = float(np.interp(top, x, g))
    assert float(line.g(top)) == pytest.approx(depth, rel=1e-12, abs=1e-12 * scale)

    def integral(f):
        return quad(f, 0.0, top, points=inside or None, epsabs=0.0, epsrel=1e-11)[0]

    moment = integral(lambda t: depth - np.interp(t, x, g))
    squared = integral(lambda t: (depth - np.interp(t, x, g)) ** 2)
    assert float(line.moment(top)) == pytest.approx(moment, rel=1e-9, abs=1e-12 * scale**2)
    assert float(line.squared(top)) == pytest.approx(squared, rel=1e-9, abs=1e-12 * scale**3)
    if depth > 0.0:
        first = float(line.inverse(depth))
        assert first <= top * (1.0 + 1e-12)
        assert float(line.g(first)) == pytest.approx(depth, rel=1e-12)
        own = float(line.moment(top))
        assert float(line.moment(line.inverse_moment(own))) == pytest.approx(own, rel=1e-9)


def test_places_keep_their_digits_on_a_steep_segment():
    line = PolygonLine(np.array([0.0, 1.0, 1.0 + 1e-10, 2.0]), np.array([0.0, 0.0, 1.0, 2.0]))
    depth = np.linspace(1e-6, 1.0 - 1e-6, 7)
    assert np.allclose(line.g(line.place(depth)), depth, rtol=1e-14)
    assert float(line.g(Place(np.array([1.0]), np.array([0.5e-10])))[0]) == pytest.approx(0.5, rel=1e-6)
    assert float(line.inverse(3.0)) == math.inf
    assert line.g(np.array([3.0]))[0] == math.inf
    assert line.inverse(-1.0) == 0.0


# exact curves ------------------------------------------------------------------------------------------------------


def test_a_curve_without_noise_comes_back_to_its_interpolation():
    t = np.geomspace(1e-3, 1.0, 500) * DEEPEST
    missed = []
    for n in (25, 50, 100, 200):
        curve = curve_of_ball(n)
        assert np.allclose(force(curve, curve.indentation), curve.force, rtol=1e-14, atol=0.0)
        missed.append(np.max(np.abs(force(curve, t) - hertz(t))) / hertz(DEEPEST))
    assert missed[-1] < 1e-6
    assert all(fine < coarse / 2.5 for coarse, fine in itertools.pairwise(missed))


@pytest.mark.parametrize("power", [1.0, 1.25, 2.0, 3.5])
def test_powers_come_back(power):
    d = np.linspace(0.0, 1.0, 101)
    curve = mdr.ForceCurve(d, d**power, modulus=1.0)
    t = np.linspace(0.02, 1.0, 400)
    assert np.allclose(force(curve, t), t**power, rtol=1e-3)
    assert np.max(np.abs(stiffness(curve, t) - power * t ** (power - 1.0))) < 1e-3 * power
    assert np.max(np.abs(force(curve, t) - t**power)) < 1e-6


def slip_of_springs(hinges, steps, modulus_ratio, friction, path):
    """Springs one by one: their tangential force after straight moves, by small parts."""
    depth = shift = 0.0
    pulled = np.zeros(hinges.size)
    forces = []
    for _ in path:
        for part in np.linspace(0.0, 1.0, 4001)[1:]:
            new_d, new_u = path_point(forces, path, part)
            pressed = np.maximum(new_d - hinges, 0.0)
            pulled += modulus_ratio * (new_u - shift)
            pulled = np.clip(pulled, -friction * pressed, friction * pressed)
            depth, shift = new_d, new_u
        forces.append(float(steps @ pulled))
    assert (depth, shift) == pytest.approx(path[-1])
    return np.array(forces)


def path_point(done, path, part):
    before = path[len(done) - 1] if done else (0.0, 0.0)
    after = path[len(done)]
    return tuple(a + (b - a) * part for a, b in zip(before, after, strict=True))


def test_piecewise_linear_data_are_springs_and_rub_as_springs_do():
    hinges, steps = np.array([0.0, 0.2, 0.55, 0.8]), np.array([1.0, 0.5, 2.0, 0.7])
    d = np.linspace(0.0, 1.2, 25)
    body = mdr.Elastic(2.0, 0.0)
    moduli = mdr.effective_moduli(body, body)
    load = np.maximum(d[:, None] - hinges, 0.0) @ steps
    curve = mdr.ForceCurve(d, load, modulus=moduli.normal)
    at = np.linspace(0.0, 1.2, 601)
    assert np.allclose(
        force(curve, at), np.maximum(at[:, None] - hinges, 0.0) @ steps, rtol=1e-13, atol=1e-15
    )
    assert np.allclose(stiffness(curve, [0.1, 0.3, 0.7, 1.0]), [1.0, 1.5, 3.5, 4.2], rtol=1e-13)
    path = [(1.0, 0.0), (1.0, 0.3), (1.0, -0.2), (1.1, 0.1), (0.7, 0.1), (0.9, 0.5)]
    rows = np.array(path)
    joint = mdr.Contact(curve, body, body, friction=mdr.Coulomb(0.4))
    solved = mdr.solve(joint, mdr.Path(indentation=rows[:, 0], shift=rows[:, 1]))
    own = slip_of_springs(hinges, steps, moduli.tangential / moduli.normal, 0.4, path)
    assert np.allclose(solved["tangential_force"], own, rtol=1e-11, atol=0.0)
    assert np.allclose(
        solved["normal_force"], np.maximum(rows[:, :1] - hinges, 0.0) @ steps, rtol=1e-11, atol=0.0
    )


@st.composite
def convex_curves(draw):
    """Convex points, of any size; (depths, forces, scales)."""
    n = draw(st.integers(5, 30))
    widths = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=n, max_size=n)))
    rises = np.array(draw(st.lists(st.one_of(st.just(0.0), st.floats(0.01, 1.0)), min_size=n, max_size=n)))
    rises[-1] = draw(st.floats(0.01, 1.0))
    length, size = (10.0 ** draw(st.integers(low, 2)) for low in (-10, -12))
    d = np.cumsum(widths)
    return d * length, np.cumsum(np.cumsum(rises) * widths) * size, length, size


@settings(max_examples=examples(60), deadline=None)
@given(convex_curves(), st.integers(0, 2**31))
def test_any_convex_points_are_met_by_a_rising_stiffness_and_dissipate(points, seed):
    d, load, length, _ = points
    body = mdr.Elastic("1 GPa", 0.0)
    curve = mdr.ForceCurve(d, load, modulus=mdr.effective_moduli(body, body).normal)
    line = closure_of(curve).stiffness
    assert np.all(np.diff(line.stiffness) >= 0.0)
    assert np.all(np.diff(line.depth) >= 0.0)
    assert np.allclose(force(curve, d), load, rtol=1e-12, atol=1e-14 * load[-1])
    rng = np.random.default_rng(seed)
    depth = d[-1] * rng.uniform(0.05, 1.0, 12)
    joint = mdr.Contact(curve, body, body, friction=mdr.Coulomb(0.3))
    solved = mdr.solve(joint, mdr.Path(indentation=depth, shift=length * rng.uniform(-1.0, 1.0, 12)))
    own = np.interp(depth, np.append(0.0, d), np.append(0.0, load))
    assert np.all(force(curve, depth) <= own + 1e-9 * load[-1])  # chords lie above

    def known_values(name):
        """NaN where the points do not tell it."""
        return solved.data[name].values if name in solved.data else np.full(12, np.nan)

    bears = np.isfinite(known_values("normal_force"))
    assert np.allclose(known_values("normal_force")[bears], force(curve, depth)[bears], rtol=1e-10)
    dissipated = known_values("dissipated_energy")
    dissipated = dissipated[np.isfinite(dissipated)]
    assert np.all(np.diff(dissipated, prepend=0.0) >= -1e-9 * np.max(dissipated, initial=1e-300))
    carried = (0.3 + 1e-9) * known_values("normal_force") + 1e-12 * load[-1]
    assert not np.any(np.abs(known_values("tangential_force")) > carried)


@settings(max_examples=examples(20), deadline=None)
@given(st.integers(-9, 2), st.integers(-9, 6), st.sampled_from([0.0, 2e-3]))
def test_units_of_length_and_force_change_nothing(lengths, forces, noise):
    length, size = 10.0**lengths, 10.0**forces
    d = np.linspace(-0.2, 1.0, 241)
    load = np.maximum(d - 0.05, 0.0) ** 1.5 + noise * np.random.default_rng(5).standard_normal(d.size)
    one, other = (
        closure_of(mdr.ForceCurve(d * a, load * b, modulus=1.0)) for a, b in ((1.0, 1.0), (length, size))
    )
    t = np.linspace(0.01, 0.9, 50)
    assert other.contact_point / length == pytest.approx(one.contact_point, rel=1e-5, abs=1e-6)
    assert np.allclose(other.stiffness.at(t * length)[1] / size, one.stiffness.at(t)[1], rtol=1e-4)


# noise -------------------------------------------------------------------------------------------------------------


def test_noise_of_a_hundredth_leaves_the_stiffness_within_a_few():
    """Raw differences err by 3.8 there, and isotonic regression of them by 0.16."""
    d = np.linspace(0.0, 1.0, 401)[1:]
    off, differences = [], []
    for seed in range(12):
        noise = 0.01 * np.random.default_rng(seed).standard_normal(d.size)
        curve = mdr.ForceCurve(d, d**1.5 + noise, modulus=1.0)
        off.append(np.sqrt(np.mean((stiffness(curve, d) / 1.5 - np.sqrt(d)) ** 2)))
        differences.append(np.sqrt(np.mean((force(curve, d) - d**1.5) ** 2)))
        assert closure_of(curve).noise == pytest.approx(0.01, rel=0.3)
    assert np.mean(off) < 0.02
    assert np.max(off) < 0.05
    assert np.mean(differences) < 2.5e-3


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 1e-2])
def test_claimed_errors_are_the_actual_errors(noise):
    results = []
    for seed in range(10):
        curve = curve_of_ball(400, noise, seed)
        depth = np.array([0.25, 0.5, 0.9]) * DEEPEST
        rows = mdr.solve(mdr.Contact(curve, STEEL, STEEL), mdr.Path(indentation=depth))
        claim = rows.claims["normal_force"]
        assert claim.level is mdr.Level.APPROXIMATE
        results.append(np.abs(rows["normal_force"].values / hertz(depth) - 1.0) / claim.error)
    assert np.median(results) < 1.0
    assert np.max(results) < 3.0


CURVE_REFUSED = re.compile(
    r"^(force decreases by|force: the largest is|\d+ points beyond the contact point|the points of the force curve do not fit)"
)


@settings(max_examples=examples(40), deadline=None)
@given(
    st.integers(5, 150),
    st.floats(1.0, 3.0),
    st.sampled_from([0.0, 1e-6, 1e-3, 1e-2, 0.1]),
    st.sampled_from([-0.3, 0.0]),
    st.integers(0, 2**31),
)
def test_points_with_any_noise_have_a_rising_stiffness_or_are_refused(n, power, noise, begin, seed):
    rng = np.random.default_rng(seed)
    d = np.unique(rng.uniform(begin, 1.0, n))
    load = np.maximum(d - 0.05, 0.0) ** power + noise * rng.standard_normal(d.size)
    try:
        curve = mdr.ForceCurve(d, load, modulus=1.0)
        result = closure_of(curve)
    except mdr.ProblemError as refusal:
        assert CURVE_REFUSED.search(str(refusal))  # noqa: PT017
        return
    assert np.all(np.diff(result.stiffness.stiffness) >= 0.0)
    assert result.misfit <= max(0.05 * load.max(), 2.0 * result.noise) * (1.0 + 1e-9)
    body = mdr.Elastic(2.0, 0.0)
    most = result.largest_force * (1.0 - 1e-9)
    rows = mdr.solve(mdr.Contact(curve, body, body), mdr.load(most, steps=3))
    claim = rows.claims["indentation"]
    if claim.readable:
        known = claim.where
        loads = most * np.arange(1, 4) / 3
        depths = rows["indentation"].values
        assert np.allclose(result.stiffness.at(depths[known])[1], loads[known], rtol=1e-10)
        assert np.isnan(depths[~known]).all()
    else:
        assert claim.level is mdr.Level.NOT_VALID


@pytest.mark.parametrize("noise", [1e-3, 1e-2])
def test_claimed_errors_of_the_slip_work_are_the_actual_errors(noise):
    path = mdr.indent("1 um")
    for shift in ("0.05 um", "0.2 um"):
        path >>= mdr.cycle(shift=shift, cycles=2, steps=80)
    true, *others = (
        mdr.solve(mdr.Contact(profile, PLAIN, PLAIN, friction=mdr.Coulomb(0.3)), path)
        for profile in (BALL, *(curve_of_ball(400, noise, seed) for seed in range(6)))
    )
    rows, results = [80, 160], []
    for other in others:
        dissipated, own = (result["dissipated_energy"].values[rows] for result in (other, true))
        results.append(np.abs(dissipated / own - 1.0) / other.claims["dissipated_energy"].error[rows])
    assert np.median(results) < 1.0
    assert np.max(results) < 3.0


@settings(max_examples=examples(60), deadline=None)
@given(
    st.sampled_from([10, 20, 50, 200, 1000]),
    st.floats(0.01, 0.3),
    st.floats(0.1, 0.9),
    st.sampled_from([0.0, 1e-3, 1e-2]),
    st.integers(0, 99),
)
def test_errors_hold_where_a_stiffness_bends_within_a_few_points(n, width, middle, noise, seed):
    def bend(x):
        return width * np.logaddexp(0.0, (x - middle) / width)

    def press(x):
        return 0.3 * x + bend(x) - bend(0.0)

    d = np.arange(1, n + 1) / n
    scatter = noise * press(1.0) * np.random.default_rng(seed).standard_normal(n)
    computed = closure_of(mdr.ForceCurve(d, press(d) + scatter, modulus=1.0))
    t = np.linspace(max(0.02, d[0]), 1.0, 300)
    own = computed.stiffness.at(t)
    truth = (0.3 + 1.0 / (1.0 + np.exp((middle - t) / width)), press(t))
    for value, exact, error in zip(own, truth, computed.error(t), strict=False):
        assert np.all((np.abs(value - exact) <= 10.0 * error * value + 1e-10 * value) | (error > 0.99))


@settings(max_examples=examples(40), deadline=None)
@given(st.sampled_from([10, 50, 200, 1000]), st.floats(1.0, 4.0), st.floats(0.0, 0.05), st.integers(0, 999))
def test_noise_is_no_fall_of_the_force(n, power, noise, seed):
    d = np.arange(1, n + 1) / n
    mdr.ForceCurve(d, d**power + noise * np.random.default_rng(seed).standard_normal(n), modulus=1.0)


def test_the_contact_point_is_located_if_the_data_begin_before_it():
    rng = np.random.default_rng(2)
    d = np.linspace(-0.5, 1.0, 601)
    for touch in (0.0, 0.13):
        load = np.maximum(d - touch, 0.0) ** 1.5 + 2e-3 * rng.standard_normal(d.size)
        curve = mdr.ForceCurve(d, load, modulus=1.0)
        result = closure_of(curve)
        assert result.contact_point == pytest.approx(touch, abs=0.02)
        assert any("estimated contact point" in note for note in result.notes)
        assert force(curve, [0.5]) == pytest.approx(0.5**1.5, rel=0.04)
        given = closure_of(dataclasses.replace(curve, contact_point=touch))
        assert given.contact_point == touch
        assert given.stiffness.at(np.array([0.5]))[1] == pytest.approx(0.5**1.5, rel=0.01)


def test_points_without_noise_determine_their_contact_point():
    d = np.linspace(-0.5, 1.0, 302)
    result = closure_of(mdr.ForceCurve(d, np.maximum(d - 0.1, 0.0) ** 2, modulus=1.0))
    assert result.contact_point == pytest.approx(0.1, abs=1e-6)


def test_what_six_points_determine(references):
    """Jaeger's force needs the curve only in its points; radii, in the mean between two of them."""
    entry = references["closure_table"]
    d, load, expected = np.array(entry["inputs"]["d"]), np.array(entry["inputs"]["F"]), entry["expected"]
    curve = mdr.ForceCurve(d, load, modulus=1.0)
    joint = mdr.Contact(curve, mdr.Elastic(1.0, 0.0), friction=mdr.Coulomb(1.0))
    pushed = mdr.solve(joint, mdr.indent(1.0) >> mdr.shift(0.3))["tangential_force"]
    assert float(pushed[-1]) == pytest.approx(expected["Fx"], rel=1e-12)
    stiffness = closure_of(curve).stiffness
    for i, radius in enumerate(expected["a_eff"]):
        nodes, weights = np.polynomial.legendre.leggauss(200)
        half = 0.5 * (d[i + 1] - d[i])
        mean = 0.5 * weights @ stiffness.at(d[i] + half * (1.0 + nodes))[0]
        assert 0.5 * mean == pytest.approx(radius, rel=1e-6)


def test_depths_that_begin_at_nothing_are_counted_from_there():
    d = np.linspace(0.0, 1.0, 101)
    result = closure_of(mdr.ForceCurve(d, np.maximum(d - 0.3, 0.0) ** 2, modulus=1.0))
    assert result.contact_point == 0.0
    assert np.allclose(result.stiffness.at(np.array([0.2, 0.8]))[1], [0.0, 0.25], rtol=1e-13, atol=1e-15)


def test_a_decreasing_stiffness_is_reported_with_its_place():
    rng = np.random.default_rng(4)
    d = np.linspace(0.0, 1.0, 401)
    load = d**1.5 + 0.03 * np.exp(-(((d - 0.6) / 0.05) ** 2)) + 2e-3 * rng.standard_normal(d.size)
    notes = closure_of(mdr.ForceCurve(d, load, modulus=1.0)).notes
    assert any("deviates from every curve of increasing" in note for note in notes)
    smooth = closure_of(mdr.ForceCurve(d, d**1.5 + 2e-3 * rng.standard_normal(d.size), modulus=1.0)).notes
    assert not any("deviates from every" in note for note in smooth)


# the laws ----------------------------------------------------------------------------------------------------------


def relative(one, other):
    return float(np.max(np.abs(one - other)) / np.max(np.abs(other)))


def test_friction_is_that_of_the_shape_and_converges_to_it():
    path = (
        mdr.indent("1 um", steps=5)
        >> mdr.cycle(shift="0.2 um", cycles=2, steps=40)
        >> mdr.ramp(indentation="1.5 um", shift="0.5 um", steps=20)
        >> mdr.load("1 N", steps=5)
        >> mdr.drag("-0.1 N", steps=3)
    )
    names = ("tangential_force", "dissipated_energy", "stored_tangential_energy", "shift", "normal_force")
    true = mdr.solve(mdr.Contact(BALL, STEEL, STEEL, friction=mdr.Coulomb(0.3)), path)
    missed = []
    for n in (20, 80, 320):
        joint = mdr.Contact(curve_of_ball(n), STEEL, STEEL, friction=mdr.Coulomb(0.3))
        solved = mdr.solve(joint, path)
        missed.append(max(relative(solved[name].values, true[name].values) for name in names))
    assert missed[0] < 3e-3
    assert missed[2] < 2e-5
    assert all(fine < coarse / 8.0 for coarse, fine in itertools.pairwise(missed))


@pytest.mark.parametrize("power", [1.2, 1.5, 2.0, 2.5])
@pytest.mark.parametrize("seed", range(3))
def test_the_tangential_stiffness_of_a_slipping_contact_errs_as_that_of_the_part_that_sticks(power, seed):
    random = np.random.default_rng(seed)
    points = np.linspace(0.0, DEEPEST, int(random.integers(10, 60)))[1:]
    curve = mdr.ForceCurve(points, 1e9 * points**power, modulus=MODULUS, error=0.0)
    joint = mdr.Contact(curve, PLAIN, PLAIN, friction=mdr.Coulomb(0.3))
    moduli = mdr.effective_moduli(PLAIN, PLAIN)
    d = random.uniform(0.5, 1.0) * DEEPEST
    part = np.sort(random.uniform(0.0, 0.95, 20))
    shifts = part * 0.3 * moduli.normal / moduli.tangential * d
    result = mdr.solve(joint, mdr.indent(d) >> mdr.Path(shift=shifts))
    true = moduli.tangential / MODULUS * power * 1e9 * ((1.0 - part) * d) ** (power - 1.0)
    off = np.abs(result["tangential_stiffness"].values[1:] / true - 1.0)
    assert np.all(off <= result.claims["tangential_stiffness"].error[1:] + 1e-12)


@pytest.mark.parametrize("seed", [101, 90, 153, 192, 115, 57])
def test_between_points_far_apart_curves_err_within_their_claims(seed):
    """Curves through every other point miss the error in a gap between two narrow ones: k was up to 6.8 times its claim off."""
    random = np.random.default_rng(seed)
    power = 1.0 + 1.0 / random.uniform(1.2, 4.0)
    points = np.append(np.sort(random.uniform(0.0, 1.0, int(random.integers(8, 60)))), 1.0)
    curve = mdr.ForceCurve(
        DEEPEST * points,
        points**power,
        modulus=mdr.effective_moduli(PLAIN, PLAIN).normal,
        error=0.0,
        contact_point=0.0,
    )
    part = np.linspace(0.02, 1.0, 800)
    result = mdr.solve(mdr.Contact(curve, PLAIN, PLAIN), mdr.Path(indentation=DEEPEST * part))
    true = {
        "normal_force": part**power,
        "normal_stiffness": power * part ** (power - 1.0) / DEEPEST,
        "elastic_energy": DEEPEST * part ** (power + 1.0) / (power + 1.0),
    }
    for name, exact in true.items():
        assert np.all(np.abs(result[name].values / exact - 1.0) <= result.claims[name].error + 1e-12)


@pytest.mark.parametrize("seed", [*range(10), 26, 45])
def test_small_tangential_forces_and_energies_err_within_their_claims(seed):
    """The errors of the turning points add up where their forces and energies cancel."""
    random = np.random.default_rng(seed)
    profile = mdr.PowerLaw(random.uniform(1.2, 4.0), "1 um", "100 um")
    points = DEEPEST * np.sort(random.uniform(0.0, 1.0, int(random.integers(8, 60))))
    law = mdr.Contact(profile, PLAIN, PLAIN)
    force = mdr.solve(law, mdr.Path(indentation=[*points, DEEPEST]))["normal_force"].values
    curve = mdr.ForceCurve(
        [*points, DEEPEST],
        force,
        modulus=mdr.effective_moduli(PLAIN, PLAIN).normal,
        error=0.0,
        contact_point=0.0,
    )
    bends = np.array([random.uniform(0.3, 1.0, 12), np.cumsum(random.normal(0.0, 0.1, 12))])
    parts = np.linspace(0.0, 1.0, 30)[1:, None, None]
    moves = bends.T[:-1] + parts * np.diff(bends.T, axis=0)
    rows = DEEPEST * np.concatenate([bends.T[:1], moves.transpose(1, 0, 2).reshape(-1, 2)])
    path = mdr.Path(indentation=rows[:, 0], shift=rows[:, 1])
    friction = mdr.Coulomb(random.uniform(0.1, 1.0))
    true, result = (
        mdr.solve(mdr.Contact(shape, PLAIN, PLAIN, friction=friction), path) for shape in (profile, curve)
    )
    for name in ("tangential_force", "stored_tangential_energy", "tangential_stiffness"):
        value, exact, claim = result[name].values, true[name].values, result.claims[name]
        known = claim.where & (claim.error < 1.0)
        assert known.mean() > 0.9
        off, allowed = np.abs(value - exact), claim.error * np.abs(value) + 1e-12 * np.abs(exact).max()
        assert np.all(off[known] <= allowed[known])


@pytest.mark.parametrize("stiffness", [1e6, 1e7])
def test_the_depth_to_which_a_machine_travels_errs_as_the_curve_does(stiffness):
    curve = curve_of_ball(40, noise=0.01)
    results, true = (
        mdr.solve(
            mdr.Contact(profile, STEEL, STEEL), mdr.travel("1.5 um", steps=5), machine_stiffness=stiffness
        )
        for profile in (curve, BALL)
    )
    claim = results.claims["indentation"]
    assert claim.level is mdr.Level.APPROXIMATE
    off = np.abs(results["indentation"].values / true["indentation"].values - 1.0)[claim.where]
    assert off.size >= 3
    assert np.all(off < 10.0 * claim.error[claim.where])


def test_a_noisy_curve_does_not_determine_a_machine_that_hardly_presses():
    soft = mdr.Contact(curve_of_ball(40, noise=0.01), STEEL, STEEL)
    result = mdr.solve(soft, mdr.travel("1.5 um", steps=5), machine_stiffness=1e5)
    with pytest.raises(mdr.NotValidError, match="press deeper"):
        result["indentation"]


def test_forces_follow_the_modulus_of_the_bodies():
    soft = mdr.Elastic("1 GPa", 0.4)
    of = {
        name: mdr.solve(mdr.Contact(profile, soft), mdr.indent("1 um"))["normal_force"].values[0]
        for name, profile in (("ball", BALL), ("curve", curve_of_ball()))
    }
    assert of["curve"] == pytest.approx(of["ball"], rel=1e-13)


def test_impacts_and_loops_are_those_of_the_shape():
    curve = curve_of_ball()
    ball, other = (mdr.Contact(profile, STEEL, STEEL) for profile in (BALL, curve))
    one, two = (mdr.impact(contact, mass="30 g", speed="30 mm/s") for contact in (ball, other))
    assert two.contact_time == pytest.approx(2.943275184324705 * two.largest_indentation / 0.03, rel=1e-8)
    assert two.contact_time == pytest.approx(one.contact_time, rel=1e-8)
    assert two.largest_force == pytest.approx(one.largest_force, rel=1e-8)
    assert math.isnan(two.largest_radius)
    assert math.isnan(two.largest_pressure)
    assert not two.claims["largest_radius"].readable
    assert two.claims["contact_time"].readable
    assert "contact_radius" not in two.data
    assert "contact radius" not in two.summary()
    two.plot()
    times = mdr.restitution(other, mass="30 g", speeds=[0.01, 0.03])
    assert times["contact_time"].values[1] == pytest.approx(two.contact_time, rel=1e-13)
    rubbed = [dataclasses.replace(contact, friction=mdr.Coulomb(0.3)) for contact in (ball, other)]
    oblique = [
        mdr.impact(c, mass="30 g", speed="30 mm/s", angle="30 deg", inertia="4e-7 kg*m^2", radius="10 mm")
        for c in rubbed
    ]
    assert oblique[1].spin == pytest.approx(oblique[0].spin, rel=1e-7)
    # what Cattaneo and Mindlin leave out is not known in numbers
    assert oblique[1].claims["spin"].error is None
    oblique[1].plot()
    loops = [mdr.friction_loop(c, ["0.1 um", "0.2 um"], normal_force="10 N") for c in rubbed]
    assert np.allclose(loops[1]["dissipated_per_cycle"], loops[0]["dissipated_per_cycle"], rtol=1e-6)
    with pytest.raises(mdr.NotValidError, match="not in its force curve"):
        loops[1]["stick_ratio"]
    assert "force curve" in loops[1].claim.reason


@pytest.mark.parametrize("power", [1.0, 1.5], ids=["level", "rising"])
@pytest.mark.parametrize("amplitude", [5e-8, 2e-6], ids=["partial slip", "sliding"])
def test_loops_and_histories_of_a_curve_claim_the_same(power, amplitude):
    """Of a level stiffness, as of a flat, the tangential force is known, and the dissipation where all slides."""
    depth, steel = np.linspace(0.0, 2e-6, 60), mdr.Elastic("210 GPa", 0.0)
    modulus = mdr.effective_moduli(steel, steel).normal
    force = 2.0 * modulus * 1e-4 * depth * (depth / 2e-6) ** (power - 1.0)
    curve = mdr.ForceCurve(depth, force, modulus=modulus, error=1e-4)
    contact = mdr.Contact(curve, steel, steel, friction=mdr.Coulomb(0.3))
    loop = mdr.friction_loop(contact, amplitude, indentation="1 um")
    history = mdr.solve(contact, mdr.indent("1 um") >> mdr.cycle(shift=amplitude, steps=8))
    largest = int(np.argmax(history["tangential_force"].values))
    for name, like, row in (
        ("force_amplitude", "tangential_force", largest),
        ("dissipated_per_cycle", "dissipated_energy", -1),
    ):
        one, other = loop.claims[name], history.claims[like]
        assert one.level == other.level
        assert (one.error is None) == (other.error is None)
        # a history that is known by its energy balance contains the first loading
        close = 1e-9 if power > 1.0 or like == "tangential_force" else 0.2
        assert one.error is None or one.error[0] == pytest.approx(other.error[row], rel=close)
    assert float(loop["force_amplitude"][0]) == pytest.approx(
        float(history["tangential_force"].max()), rel=1e-9
    )
    assert loop.claims["secant_stiffness"] is loop.claims["force_amplitude"]
    slides = amplitude > float(loop.data["sliding_shift"])
    assert loop.claims["dissipated_per_cycle"].readable is (power > 1.0 or slides)


@pytest.mark.parametrize(("excess", "by_force"), [(1.1, False), (20.0, True)])
def test_dissipation_of_a_level_stiffness_is_known_in_sliding(excess, by_force):
    """Of a flat all springs begin to slip at once, and then friction does the work mu F_N per length."""
    depth, steel, mu, off = np.linspace(0.0, 2e-6, 40), mdr.Elastic("210 GPa", 0.0), 0.3, 1e-3
    moduli = mdr.effective_moduli(steel, steel)
    load = 2.0 * moduli.normal * 1e-4 * 1e-6
    curve = mdr.ForceCurve(depth, load * depth / 1e-6 * (1.0 + off), modulus=moduli.normal, error=off)
    joint = mdr.Contact(curve, steel, steel, friction=mdr.Coulomb(mu))
    first = mu * moduli.normal / moduli.tangential * 1e-6
    at = {"normal_force": load} if by_force else {"indentation": 1e-6}
    loop = mdr.friction_loop(joint, [0.5 * first, excess * first], **at)
    history = mdr.solve(joint, mdr.ramp(**at) >> mdr.shift(excess * first) >> mdr.shift(-excess * first))
    assert loop.claim.where.tolist() == [False, True]
    slid = mu * load * first * (excess - 1.0)
    claim = history.claims["dissipated_energy"]
    for value, truth, error in (
        (loop["dissipated_per_cycle"][1], 4.0 * slid, loop.claim.error[1]),
        (history["dissipated_energy"][1], slid, claim.error[1]),
        (history["dissipated_energy"][2], 3.0 * slid, claim.error[2]),
    ):
        assert abs(float(value) / truth - 1.0) <= error < 1e-2 * max(1.0, 2.0 / (excess - 1.0))


RUBBER = mdr.Viscoelastic(mdr.StandardSolid(equilibrium="1 MPa", modulus="3 MPa", time="50 ms"), poisson=0.5)
THERE_AND_BACK = (
    mdr.indent("1.5 um", rate="20 um/s", steps=40)
    >> mdr.hold("0.1 s", steps=20)
    >> mdr.indent("0 mm", rate="20 um/s", steps=40)
)


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(1.0, 3.0), st.integers(10, 60), st.floats(0.1, 9.0), st.booleans())
def test_impacts_beyond_the_end_of_a_curve_are_refused_with_their_speed(power, n, decades, remembers):
    d = np.arange(1, n + 1) / n * DEEPEST
    curve = mdr.ForceCurve(d, (d / DEEPEST) ** power, modulus=MODULUS)
    rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "4 MPa", "10 ms"), 0.5)
    contact = mdr.Contact(curve, rubber) if remembers else mdr.Contact(curve, STEEL, STEEL)
    # more than the bodies can store up to the end
    mass = 2.0 * DEEPEST * 10.0**decades
    with pytest.raises(mdr.PathError, match="would not come to rest before the profile ends"):
        mdr.impact(contact, mass=mass, speed=1.0)


def test_memory_is_that_of_the_shape():
    again = THERE_AND_BACK >> mdr.indent("1 um", rate="20 um/s", steps=10)
    creep = mdr.load("1 mN", steps=10, duration="10 ms") >> mdr.hold("0.1 s", steps=20)
    curve = curve_of_ball()
    for path in (THERE_AND_BACK, again, creep):
        one, two = (mdr.solve(mdr.Contact(profile, RUBBER), path) for profile in (BALL, curve))
        for name in ("normal_force", "indentation", "elastic_energy", "dissipated_energy"):
            assert relative(two[name].values, one[name].values) < 1e-6
        assert not two.claims["contact_radius"].readable
        proven = "for contacts of any shape it is not proven" not in two.claims["normal_force"].reason
        assert proven == (path is not again)


def test_a_contact_grows_again():
    assert not regrown(np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])).any()
    assert regrown(np.array([0.0, 2.0, 1.0, 1.0, 1.5, 1.0])).tolist() == [False] * 4 + [True] * 2


# shapes that no disk knows -----------------------------------------------------------------------------------------


def caps(surface, seed):
    """Five caps anywhere on a square."""
    x, y = np.meshgrid(surface.x, surface.x, indexing="ij")
    rng = np.random.default_rng(seed)
    gap = np.full(x.shape, np.inf)
    for _ in range(5):
        x0, y0 = rng.uniform(-0.6e-3, 0.6e-3, 2)
        height, radius = rng.uniform(0.0, 1.5e-6), rng.uniform(0.05, 0.2)
        gap = np.minimum(gap, height + ((x - x0) ** 2 + (y - y0) ** 2) / (2.0 * radius))
    return gap - gap.min()


@pytest.mark.parametrize("seed", [3, 11])
def test_friction_of_a_rough_surface_is_that_of_boundary_elements(seed):
    body = mdr.Elastic("2 GPa", 0.0)
    surface = make_surface(1e-3, 20, body, body)
    gap, cell = caps(surface, seed), surface.side**2
    depth, loads, p = np.linspace(0.0, 3.2e-6, 161)[1:], [], np.zeros(gap.shape)
    for d in depth:
        p = solve_pressure(surface, gap, float(d), p)
        loads.append(cell * p.sum())
    modulus = mdr.effective_moduli(body, body).normal
    joint = mdr.Contact(mdr.ForceCurve(depth, loads, modulus=modulus), body, body, friction=mdr.Coulomb(0.4))
    d = 1e-6 * np.array([2.01, 2.01, 2.01, 2.01, 1.53, 1.53])
    u = 1e-6 * np.array([0.0, 0.3, -0.2, 0.1, 0.1, -0.3])
    solved = mdr.solve(joint, mdr.Path(indentation=d, shift=u))
    p, q, moved, before, own = (
        np.zeros(gap.shape),
        np.zeros((2, *gap.shape)),
        np.zeros((2, *gap.shape)),
        0.0,
        [],
    )
    for each, shift in zip(d, u, strict=True):
        p = solve_pressure(surface, gap, float(each), p)
        wanted = moved + np.array([shift - before, 0.0])[:, None, None]
        q = solve_tractions(surface, wanted, 0.4 * p, q)
        moved, before = surface.tangential_displacement(q), shift
        own.append((cell * p.sum(), cell * q[0].sum()))
    normal, tangential = np.array(own).T
    assert np.allclose(solved["normal_force"], normal, rtol=1e-4)
    assert relative(solved["tangential_force"].values, tangential) < 1e-3


def test_a_ring_by_boundary_elements_rubs_as_its_curve_does():
    body = mdr.Elastic("2 GPa", 0.0)
    hollow = mdr.Contact(mdr.ConcavePunch("1 mm", hollow_radius="0.5 m"), body, body)
    # the rim stands out by 1 um
    path = mdr.Path(indentation=np.linspace(-1.1e-6, 1.5e-6, 53))
    curve = mdr.solve(hollow, path, solver=mdr.Rings(60)).force_curve()
    joint = mdr.Contact(curve, body, body, friction=mdr.Coulomb(0.4))
    d, u = np.full(3, 0.2e-6), [0.0, 0.2e-6, -0.1e-6]
    solved = mdr.solve(joint, mdr.Path(indentation=d - closure_of(curve).contact_point, shift=u))
    grid = solve_sliding(hollow.profile, body, body, 0.4, d, u, HalfSpaceGrid(32))
    fraction = solved["tangential_force"].values / solved["normal_force"].values
    assert np.allclose(fraction, grid.tangential_force / grid.normal_force, rtol=0.05, atol=1e-3)
    assert mdr.equivalent_profile(curve).max_radius > 0.0


# claims, figures, files --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def fretted():
    joint = mdr.Contact(curve_of_ball(), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    return mdr.solve(joint, mdr.indent("1 um", steps=2) >> mdr.cycle(shift="0.2 um", steps=20))


def test_only_what_the_curve_determines_is_claimed(fretted):
    assert fretted.status is mdr.Status.OF_A_CURVE
    for name, claim in fretted.claims.items():
        assert claim.readable == (name in OF_THE_CURVE)
        assert "on a disk" not in claim.reason
    for name in ("contact_radius", "mean_pressure", "stick_radius", "peak_pressure"):
        with pytest.raises(mdr.NotValidError, match="force curve"):
            fretted[name]
    for name in ("pressure", "gap", "shear_traction", "slip"):
        with pytest.raises(mdr.NotValidError, match="force curve"):
            fretted.field(name)
    with pytest.raises(mdr.QuantityError, match="does not show the shape of the contact"):
        fretted.field("spring_force")
    assert [a.name for a in fretted.assumptions] == ["elastic similarity"]
    assert any("force curve through all" in note for note in fretted.notes)
    assert any("force curve" in source for source in fretted.cite())


def test_figures_and_summaries(fretted):
    figure = fretted.plot()
    assert "line from a curve" in figure.axes[2].get_title()
    assert set(fretted.figures()) == {"curve", "line", "history"}
    assert "OF_A_CURVE" in fretted.summary()
    fretted._repr_html_()
    frictionless = mdr.solve(mdr.Contact(curve_of_ball(), STEEL, STEEL), mdr.indent("1 um", steps=3))
    frictionless.plot()
    mdr.solve(mdr.Contact(curve_of_ball(), RUBBER), THERE_AND_BACK).plot()


def test_results_are_saved_and_read_back(fretted, tmp_path):
    fretted.save(tmp_path / "joint.nc")
    read = mdr.open_result(tmp_path / "joint.nc")
    assert read.contact == fretted.contact
    assert read.status is fretted.status
    assert read.data.equals(fretted.data)
    read.plot()


def test_an_assessment_has_the_same_claims(fretted):
    assessed = mdr.assess(fretted.contact, fretted.path)
    assert {name: claim.level for name, claim in assessed.claims.items()} == {
        name: claim.level for name, claim in fretted.claims.items()
    }


def test_the_curve_of_a_result():
    contact = mdr.Contact(BALL, STEEL, STEEL)
    curve = mdr.solve(contact, mdr.indent("1 um", steps=50) >> mdr.indent("0 um", steps=20)).force_curve()
    assert curve.modulus == MODULUS
    assert np.all(np.diff(curve.indentation) > 0.0)
    assert np.allclose(curve.force, hertz(curve.indentation), rtol=1e-14)
    gel = mdr.Contact(BALL, STEEL, adhesion=mdr.JKR("50 mJ/m^2"))
    for other, path in ((gel, mdr.indent("1 um")), (mdr.Contact(BALL, RUBBER), THERE_AND_BACK)):
        with pytest.raises(mdr.ProblemError, match="homogeneous elastic half-spaces without adhesion"):
            mdr.solve(other, path).force_curve()
    with pytest.raises(mdr.ProblemError, match="at least 5"):
        mdr.solve(contact, mdr.indent("1 um", steps=3)).force_curve()


def test_a_case_file_reads_its_curve(shell, tmp_path):
    table = "depth [nm],force [mN]\n" + "".join(f"{i * 10},{(i * 0.01) ** 1.5:.9g}\n" for i in range(1, 101))
    (tmp_path / "curve.csv").write_text(table)
    case = tmp_path / "case.toml"
    case.write_text(
        '[profile]\nkind = "force_curve"\nfile = "curve.csv"\nmodulus = "1 GPa"\n[body]\nkind = "elastic"\n'
        'young = "1 GPa"\npoisson = 0.0\n[[path]]\nkind = "indent"\nindentation = "500 nm"\n'
    )
    status, out, err = shell("run", case, "-o", tmp_path / "out")
    assert status == 0, err
    assert "353.6 \u00b5N" in out or "353.6 uN" in out
    assert (tmp_path / "out" / "curve.png").exists()
    read = mdr.read_force_curve(tmp_path / "curve.csv", modulus="1 GPa")
    assert read.indentation[-1] == pytest.approx(1e-6)
    (tmp_path / "curve.csv").write_text(table.replace(" [nm]", ""))
    with pytest.raises(mdr.CaseError, match="unit"):
        mdr.read_force_curve(tmp_path / "curve.csv", modulus="1 GPa")
    assert shell("check", case)[0] != 0
    (tmp_path / "curve.csv").write_text(table.replace("force [mN]", "force [nm]"))
    with pytest.raises(mdr.CaseError, match="unit of column 'force"):
        mdr.read_force_curve(tmp_path / "curve.csv", modulus="1 GPa")


# refusals ----------------------------------------------------------------------------------------------------------

DEPTHS = np.linspace(0.0, 1e-6, 41)
LOADS = DEPTHS**1.5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((DEPTHS[:4], LOADS[:4], 1.0), "at least 5"),
        ((DEPTHS, LOADS[:-1], 1.0), "one for each depth"),
        ((DEPTHS[::-1], LOADS, 1.0), "rise strictly"),
        ((np.append(DEPTHS, 1e-6), np.append(LOADS, LOADS[-1]), 1.0), "each depth once"),
        ((DEPTHS, -LOADS, 1.0), "above 0 N"),
        ((DEPTHS, LOADS[::-1], 1.0), "decreases by"),
        ((DEPTHS, LOADS, -1.0), "above 0 Pa"),
        ((DEPTHS, LOADS, "1 N"), "unit"),
        ((DEPTHS, np.append(LOADS[:-1], np.nan), 1.0), "finite"),
        ((DEPTHS, LOADS, 1.0, "0.99 um"), "beyond the contact point"),
    ],
)
def test_curves_that_are_none_are_refused(arguments, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.ForceCurve(*arguments)


def test_a_stiffness_that_falls_throughout_is_refused():
    with pytest.raises(mdr.ProblemError, match="do not fit an elastic contact"):
        mdr.solve(
            mdr.Contact(mdr.ForceCurve(DEPTHS, np.sqrt(DEPTHS), modulus=1.0), STEEL), mdr.indent("0.5 um")
        )


@pytest.mark.parametrize(
    ("quantity", "words"),
    [
        (lambda c: mdr.Contact(c, STEEL, adhesion=mdr.JKR("1 J/m^2")), "a ForceCurve cannot have adhesion"),
        (lambda c: mdr.Contact(c, mdr.Graded("1 GPa", "1 mm", 0.3, 0.3)), "homogeneous"),
        (
            lambda c: mdr.solve(mdr.Contact(c, STEEL, STEEL), mdr.indent("3 um")),
            "ends at an indentation of 2",
        ),
        (lambda c: mdr.solve(mdr.Contact(c, STEEL, STEEL), mdr.load("1 kN")), "ends at an indentation of 2"),
        (
            lambda c: mdr.solve(mdr.Contact(c, STEEL, STEEL, friction=mdr.Coulomb(0.3)), mdr.indent("3 um")),
            "ends at an indentation of 2",
        ),
        (
            lambda c: mdr.solve(mdr.Contact(c, RUBBER), mdr.indent("3 um", rate="1 um/s")),
            "ends at an indentation of 2",
        ),
        (
            lambda c: mdr.solve(mdr.Contact(c, RUBBER), mdr.load("3 N", duration="1 s")),
            "ends at an indentation of 2",
        ),
        (
            lambda c: mdr.solve(mdr.Contact(c, STEEL), mdr.indent("1 um"), solver=mdr.Rings()),
            "need its shape",
        ),
        (lambda c: mdr.verify(mdr.Contact(c, STEEL), mdr.indent("1 um")), "need its shape"),
        (
            lambda c: mdr.verify(mdr.Contact(c, STEEL, STEEL, friction=mdr.Coulomb(0.3)), mdr.indent("1 um")),
            "need its shape",
        ),
        (
            lambda c: mdr.rolling(
                mdr.Contact(c, STEEL, STEEL, friction=mdr.Coulomb(0.3)), 0.1, normal_force="1 N"
            ),
            "needs the contact area",
        ),
        (
            lambda c: mdr.sliding_friction(mdr.Contact(c, RUBBER), ["1 mm/s"], normal_force="1 uN"),
            "slope of its surface",
        ),
        (lambda c: mdr.pull_off(mdr.Contact(c, STEEL)), "no adhesion"),
        (lambda c: mdr.impact(mdr.Contact(c, STEEL, STEEL), mass=1.0, speed=1.0), "come to rest"),
        (lambda c: c + BALL, "cannot be added"),
        (lambda c: BALL + c, "cannot be added"),
        (lambda c: c.gap(1.0), "no gap"),
        (lambda c: mdr.equivalent_profile(c, 0.3), "homogeneous"),
    ],
)
def test_what_a_curve_does_not_know_is_refused(quantity, words):
    with pytest.raises(mdr.PymdrError, match=words):
        quantity(curve_of_ball(40))


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(-3.0, 0.0), st.integers(0, 2**32 - 1), st.booleans())
def test_rows_that_the_points_do_not_determine_are_left_out(decades, seed, by_force):
    d = np.linspace(0.0, 1.0, 40)
    force = d**1.5 + 10.0**decades * np.random.default_rng(seed).standard_normal(d.size)
    try:
        curve = mdr.ForceCurve(indentation=d, force=force, modulus=1.0)
        path = (
            mdr.Path(normal_force=[0.0, 1e-6, 0.1, 0.3])
            if by_force
            else mdr.Path(indentation=[0.0, 1e-6, 0.1, 0.4])
        )
        result = mdr.solve(mdr.Contact(curve, mdr.Elastic(1.0, 0.0)), path)
    except mdr.PymdrError:
        return
    prescribed = "normal_force" if by_force else "indentation"
    for name in ("indentation", "normal_force", "normal_stiffness", "elastic_energy"):
        claim = result.claims[name]
        if name == prescribed:
            assert claim.where.all()
            assert np.isfinite(result[name].values).all()
        elif claim.readable:
            known = np.isfinite(result[name].values)
            assert np.array_equal(known, claim.where)
            assert np.all(claim.error[known] < 1.0)
            assert np.all(claim.error[~known] >= 1.0)
        else:
            assert claim.level is mdr.Level.NOT_VALID
            with pytest.raises(mdr.NotValidError, match="press deeper, or measure more points"):
                result[name]


# errors of the points ----------------------------------------------------------------------------------------------


@settings(max_examples=examples(8), deadline=None)
@given(
    st.floats(1.2, 3.0),
    st.floats(0.0, 0.1),
    st.floats(-1.0, 1.0),
    st.sampled_from([-1.0, 1.0]),
    st.integers(-9, 0),
    st.integers(-9, 4),
)
def test_errors_of_points_are_in_all_that_follows(power, error, growth, sign, length, size):
    """Against the closed form of the curve without its error, e (d/D)^m."""
    scale, most = 10.0**length, 10.0**size
    d = scale * np.linspace(0.0, 1.0, 121)[1:] ** 1.5
    part = error * ((0.5 + d / scale) / 1.5) ** growth
    off = sign * part
    true = most * (d / scale) ** power
    body = mdr.Elastic(1.0, 0.0)
    points = mdr.ForceCurve(d, true * (1.0 + off), modulus=1.0, contact_point=0.0, error=part)
    at = scale * np.array([0.55, 0.7, 0.9])
    solved = mdr.solve(mdr.Contact(points, body), mdr.Path(indentation=at))
    stiffness = power * most / scale * (at / scale) ** (power - 1.0)
    exact = {"normal_force": stiffness * at / power}
    exact["normal_stiffness"] = stiffness
    exact["elastic_energy"] = stiffness * at**2 / power / (power + 1.0)
    for name, value in exact.items():
        missed = np.abs(solved[name].values / value - 1.0)
        assert np.all(missed <= solved.claims[name].error + 1e-12), name
    assert np.all(solved.claims["normal_force"].error < np.interp(at, d, part) + 0.12)


def test_what_is_not_known_of_points_stays_so(tmp_path):
    d = np.linspace(0.0, DEEPEST, 41)[1:]
    known, unknown, silent = (
        mdr.ForceCurve(d, hertz(d), modulus=MODULUS, error=error) for error in (0.2, math.nan, None)
    )
    body = mdr.Elastic("210 GPa", 0.0, thermal_conductivity="50 W/(m*K)")
    path = mdr.indent("1 um", steps=3) >> mdr.shift("0.1 um", steps=3)
    for curve, error in ((known, 0.2), (unknown, None), (silent, 1e-2)):
        curve = dataclasses.replace(curve, modulus=mdr.effective_moduli(body, body).normal)
        joint = mdr.Contact(curve, body, body, friction=mdr.Coulomb(0.3))
        solved = mdr.solve(joint, path)
        for name in ("normal_force", "tangential_force", "normal_stiffness", "thermal_conductance"):
            claimed = solved.claims[name].error
            if error is None:
                assert claimed is None
            elif curve.error is None:
                assert claimed[-1] < error
            else:
                assert error <= claimed[-1] < 3.0 * error
        blow = mdr.impact(mdr.Contact(curve, body, body), mass="30 g", speed="10 mm/s")
        assert (blow.claims["largest_force"].error is None) == (error is None)
        solved.save(tmp_path / "one.nc")
        again = mdr.open_result(tmp_path / "one.nc")
        assert again.contact == solved.contact
        frictionless = mdr.solve(dataclasses.replace(joint, friction=None), mdr.indent("1 um", steps=9))
        frictionless.to_csv(tmp_path / "one.csv", units={"indentation": "nm"})
        read, given = (
            mdr.read_force_curve(tmp_path / "one.csv", modulus=curve.modulus),
            frictionless.force_curve(),
        )
        assert np.allclose(read.error, given.error, rtol=1e-9, atol=0.0, equal_nan=True)
        assert np.isnan(given.error).all() == (error is None)
    for wrong in (-0.1, [0.1, 0.2], [[0.1]], "much"):
        with pytest.raises((mdr.ProblemError, mdr.UnitError), match="error"):
            mdr.ForceCurve(d, hertz(d), modulus=MODULUS, error=wrong)


@settings(max_examples=examples(15), deadline=None)
@given(
    st.floats(1.1, 3.0),
    st.floats(0.02, 0.3),
    st.floats(-9.0, 0.0),
    st.sampled_from([1e-4, 1e-3]),
    st.integers(0, 2**32 - 1),
)
def test_below_the_first_of_noisy_points_the_error_is_that_of_a_guess(power, first, decades, noise, seed):
    rng = np.random.default_rng(seed)
    d = np.sort(rng.uniform(first, 1.0, 60))
    d = np.append(0.0, d[np.append(True, np.diff(d) > 1e-6)])
    size = 10.0**decades
    measured = d**power + noise * rng.normal(size=d.size)
    modulus = mdr.effective_moduli(PLAIN, mdr.Rigid()).normal
    curve = mdr.ForceCurve(size * d, measured, modulus=modulus, contact_point=0.0)
    depth = size * d[1] * np.geomspace(0.05, 1.0, 12)
    result = mdr.solve(mdr.Contact(curve, PLAIN), mdr.Path(indentation=depth))
    x = depth / size
    truths = {"normal_force": x**power, "elastic_energy": size * x ** (power + 1.0) / (power + 1.0)}
    for name, truth in truths.items():
        claim = result.claims[name]
        if not claim.readable:
            continue
        off = np.abs(result[name].values - truth)[claim.where]
        assert np.all(
            off <= 4.0 * (claim.error * np.abs(result[name].values) + noise * truths[name][-1])[claim.where]
        )


def test_noisy_points_that_show_no_contact_yet():
    rng = np.random.default_rng(0)
    d = np.linspace(0.0, 1.0, 100)[1:]
    force = np.maximum(d - 0.4, 0.0) ** 1.5 + 1e-3 * rng.normal(size=d.size)
    modulus = mdr.effective_moduli(PLAIN, mdr.Rigid()).normal
    curve = mdr.ForceCurve(d, force, modulus=modulus, contact_point=0.0)
    claim = mdr.solve(mdr.Contact(curve, PLAIN), mdr.Path(indentation=[0.005, 0.3, 0.9])).claims[
        "normal_force"
    ]
    assert claim.where.tolist() == [False, False, True]


@settings(max_examples=examples(25), deadline=None)
@given(
    st.integers(20, 400),
    st.floats(1.2, 2.0),
    st.floats(0.002, 0.03),
    st.floats(3.0, 12.0),
    st.floats(0.0, 6.3),
    st.integers(-9, 0),
)
def test_points_off_every_rising_stiffness_err_by_no_less(n, power, height, wave, phase, decades):
    d = np.linspace(0.0, 1.0, n + 1)[1:]
    load = np.maximum.accumulate(d**power * (1.0 + height * np.sin(wave * d + phase)))
    result = closure_of(mdr.ForceCurve(d * 10.0**decades, load, modulus=1.0))
    own = result.stiffness.at(d * 10.0**decades)[1]
    assert np.all(np.abs(own / load - 1.0) <= result.error(d * 10.0**decades)[1] * (1.0 + 1e-6) + 1e-12)


def test_the_band_and_the_error_of_a_result_are_in_its_curve():
    """Of a measured profile with scatter, whose depth or force is prescribed."""
    r = np.linspace(0.0, 1e-4, 60)
    profile = mdr.Sampled(r, r**2 / 2e-2, scatter=1e-9 + 0.0 * r)
    contact = mdr.Contact(profile, PLAIN)
    for path in (mdr.indent("0.3 um", steps=9), mdr.load("1 N", steps=9)):
        solved = mdr.solve(contact, path)
        curve = solved.force_curve()
        name = "normal_force" if "normal_force" in solved.bands else "indentation"
        low, high = solved.bands[name]
        wide = np.abs(high - low) / 2.0 / np.abs(solved[name].values)
        assert np.all(curve.error >= wide * (1.0 - 1e-9)) or np.isnan(curve.error).all()


def test_the_error_of_a_curve_is_claimed_once():
    d = np.linspace(0.0, 1.0, 40)
    curve = mdr.ForceCurve(
        indentation=d, force=d**1.5 + 0.01 * np.random.default_rng(0).standard_normal(40), modulus=1.0
    )
    depths = np.array([0.3, 0.6, 0.9])
    result = mdr.solve(mdr.Contact(curve, mdr.Elastic(1.0, 0.0)), mdr.Path(indentation=depths))
    closure = closure_of(curve)
    stiffness, force, energy, _ = closure.error(depths) + closure.given_error(depths)
    for name, error in (("normal_stiffness", stiffness), ("normal_force", force), ("elastic_energy", energy)):
        assert result.claims[name].error == pytest.approx(np.minimum(error, 1.0), rel=1e-6)


@settings(max_examples=examples(12), deadline=None)
@given(st.integers(5, 60), st.floats(-3.0, -1.0), st.floats(-3.0, 0.0))
def test_depths_below_the_first_point_are_within_their_errors(points, flat, below):
    """A rounded flat punch: the exponent of its force falls to 1 where the points do not show it."""
    punch = mdr.Contact(mdr.RoundedFlat(10.0**flat * 1e-3, "1 mm"), PLAIN)
    curve = mdr.solve(punch, mdr.indent("0.1 um", steps=points)).force_curve()
    path = mdr.Path(indentation=[10.0**below * 1e-7 / points])
    true, closed = mdr.solve(punch, path), mdr.solve(mdr.Contact(curve, PLAIN), path)
    for name in ("normal_force", "normal_stiffness", "elastic_energy"):
        claim = closed.claims[name]
        if claim.level is not mdr.Level.NOT_VALID:
            value = float(closed[name][0])
            assert abs(float(true[name][0]) - value) <= claim.error[0] * abs(value)
