"""The equivalent profile g(x), its slope, integrals and inverses."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import struve

import pymdr as mdr
from pymdr.mapping.equivalent import equivalent_profile, gap_function, power_factor, without_callables

TAN, B = math.tan(0.7), 0.4
PROFILES = {
    "cone": mdr.Cone(slope=TAN),
    "paraboloid": mdr.Paraboloid(1.0),
    "sphere": mdr.Sphere(1.0),
    "power_0.5": mdr.PowerLaw(0.5, 1.0, 1.0),
    "power_3": mdr.PowerLaw(3, 1.0, 1.0),
    "power_4": mdr.PowerLaw(4, 1.0, 1.0),
    "trunc_cone": mdr.Function(
        lambda r: TAN * np.maximum(r - B, 0.0), [B], lambda r: np.where(r > B, TAN, 0.0)
    ),
    "rounded_cylinder": mdr.Function(
        lambda r: np.maximum(r - B, 0.0) ** 2 / 2, [B], lambda r: np.maximum(r - B, 0.0)
    ),
    "wavy_paraboloid": mdr.Function(
        lambda r: r * r / 2 + 0.02 * np.sin(3 * r) ** 2, derivative=lambda r: r + 0.06 * np.sin(6 * r)
    ),
}


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact, dtype=float) - 1)))


def graded_gauss(function, top, n=24):
    """An independent integral over [0, top] for curves that are smooth but at 0."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    edges = np.concatenate([[0.0], 0.25 ** np.arange(26, -1, -1.0)]) * top
    return sum(
        (high - low) / 2 * (weights * function(low + (high - low) * (nodes + 1) / 2)).sum()
        for low, high in pairwise(edges)
    )


@pytest.mark.parametrize("n", [0.5, 1, 2, 3, 10])
def test_power_factors_of_the_references(references, n):
    assert power_factor(n) == pytest.approx(references[f"kappa_{n}"]["expected"]["kappa"], rel=1e-12)


@pytest.mark.parametrize("name", ["trunc_cone", "rounded_cylinder", "wavy_paraboloid"])
def test_a_function_alone_reaches_the_references(references, name):
    reference = references[f"map_{name}"]
    profile = mdr.Function(PROFILES[name].f, PROFILES[name].breakpoints)
    line = equivalent_profile(profile)
    assert float(line.g(reference["inputs"]["x"])) == pytest.approx(reference["expected"]["g"], rel=1e-12)


# --- closed forms ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("n", [0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 12.0])
def test_power_laws(n, size, closed_forms):
    height = 0.3 * size
    line = equivalent_profile(mdr.PowerLaw(n, height, size))
    t = np.geomspace(1e-6, 10.0, 33)
    x, kappa = size * t, closed_forms.kappa(n)
    assert worst(line.g(x), kappa * height * t**n) < 1e-13
    assert worst(line.slope(x), n * kappa * height / size * t ** (n - 1)) < 1e-13
    assert worst(line.moment(x), n / (n + 1) * kappa * height * size * t ** (n + 1)) < 1e-13
    assert worst(line.integral(x), kappa * height * size * t ** (n + 1) / (n + 1)) < 1e-12
    # int (g(x) - g(t))^2 dt = g^2 x (1 - 2/(n+1) + 1/(2n+1))
    rest = 1 - 2 / (n + 1) + 1 / (2 * n + 1)
    assert worst(line.squared(x), rest * x * line.g(x) ** 2) < 1e-12
    assert worst(line.inverse(line.g(x)), x) < 1e-13
    assert worst(line.inverse_moment(line.moment(x)), x) < 1e-13


def test_sphere_over_nine_orders(closed_forms):
    R = 3e-3
    t = np.concatenate([np.geomspace(1e-9, 0.5, 60), np.linspace(0.501, 0.99, 40)])
    line = equivalent_profile(mdr.Sphere(R))
    assert worst(line.g(R * t), R * closed_forms.sphere_g(t)) < 1e-13
    assert worst(line.slope(R * t), closed_forms.sphere_slope(t)) < 1e-13
    assert worst(line.moment(R * t), R**2 / 2 * closed_forms.sphere_force(t)) < 1e-13
    assert worst(line.squared(R * t), R**3 * closed_forms.sphere_energy(t)) < 1e-13
    assert worst(line.inverse(line.g(R * t)), R * t) < 1e-13
    assert worst(line.inverse_moment(line.moment(R * t)), R * t) < 1e-13


def test_the_sphere_ends():
    line = equivalent_profile(mdr.Sphere(2.0))
    assert line.max_radius == 2.0
    assert math.isinf(line.g(2.0))
    assert math.isnan(line.g(2.1))


def test_a_sphere_is_a_paraboloid_at_its_apex():
    sphere, paraboloid = (equivalent_profile(p) for p in (mdr.Sphere(1.0), mdr.Paraboloid(1.0)))
    x = np.array([1e-6, 1e-4])
    assert worst(sphere.g(x), paraboloid.g(x) * (1 + x**2 / 3)) < 1e-14
    assert worst(sphere.moment(x), paraboloid.moment(x) * (1 + 2 * x**2 / 5)) < 1e-14


def test_sums_add_on_the_line():
    parts = [mdr.Sphere(2.0), mdr.Cone(slope=0.3), mdr.PowerLaw(4, 0.2, 1.0), mdr.Paraboloid(0.7)]
    total = parts[0] + parts[1] + parts[2] + parts[3]
    line, lines = equivalent_profile(total), [equivalent_profile(p) for p in parts]
    x = np.geomspace(1e-9, 1.5, 60)
    for name in ("g", "slope", "moment", "integral"):
        assert worst(getattr(line, name)(x), sum(getattr(one, name)(x) for one in lines)) < 1e-13
    top = 1.2
    exact = graded_gauss(lambda t: (line.g(top) - line.g(t)) ** 2, top)
    assert float(line.squared(top)) == pytest.approx(exact, rel=1e-12)
    assert worst(line.inverse(line.g(x)), x) < 1e-13
    assert worst(line.inverse_moment(line.moment(x)), x) < 1e-13


def test_a_sum_with_a_function_adds_on_the_line():
    function = mdr.Function(lambda r: r**4, derivative=lambda r: 4 * r**3)
    line = equivalent_profile(mdr.Sphere(2.0) + function)
    closed = equivalent_profile(mdr.Sphere(2.0) + mdr.PowerLaw(4, 1.0, 1.0))
    x = np.geomspace(1e-6, 1.0, 40)
    for name in ("g", "moment", "squared"):
        assert worst(getattr(line, name)(x), getattr(closed, name)(x)) < 1e-12
    assert worst(line.slope(x), closed.slope(x)) < 1e-12


def test_flat_ends():
    line = equivalent_profile(mdr.FlatPunch(2.0))
    assert line.edge == 2.0
    assert np.all(line.g([0.0, 1.0, 2.0]) == 0.0)
    dome = equivalent_profile(mdr.FlatPunch(2.0) + mdr.Paraboloid(5.0))
    assert dome.edge == 2.0
    assert worst(dome.g([0.5, 2.0]), [0.05, 0.8]) < 1e-15
    assert equivalent_profile(mdr.FlatPunch(3.0) + mdr.FlatPunch(2.0)).edge == 2.0


# --- callables -------------------------------------------------------------------------------------------

SMOOTH = {
    "sphere": (
        lambda r: r / np.sqrt((1 - r) * (1 + r)),
        lambda r: r * r / (1 + np.sqrt((1 - r) * (1 + r))),
        lambda x: x * np.arctanh(x),
    ),
    "hyperboloid": (
        lambda r: r / np.hypot(r, 0.3),
        lambda r: r * r / (np.hypot(r, 0.3) + 0.3),
        lambda x: x * np.arctan(x / 0.3),
    ),
    "wavy": (
        lambda r: r + 0.06 * np.sin(6 * r),
        lambda r: r * r / 2 + 0.02 * np.sin(3 * r) ** 2,
        lambda x: x * x + np.pi / 2 * 0.06 * x * struve(0, 6 * x),
    ),
    "sixth": (lambda r: 6 * r**5, lambda r: r**6, lambda x: 3.2 * x**6),
}


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e3])
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_callables_of_any_size(name, size):
    slope, f, g = SMOOTH[name]
    x = np.geomspace(1e-6, 0.9, 80)
    with_slope = equivalent_profile(mdr.Function(derivative=lambda r: slope(r / size)))
    assert worst(with_slope.g(size * x), size * g(x)) < 1e-13
    alone = equivalent_profile(mdr.Function(lambda r: size * f(r / size)))
    assert worst(alone.g(size * x), size * g(x)) < 1e-12


@pytest.mark.parametrize("name", SMOOTH)
def test_inverse_map_round_trip(name):
    slope, f, _ = SMOOTH[name]
    profile = mdr.Function(derivative=slope)
    line = equivalent_profile(profile)
    r = np.geomspace(1e-6, 0.9, 61)
    back = gap_function(profile, line)
    assert worst(back(r), f(r)) < 1e-13
    assert back(np.zeros(1)).tolist() == [0.0]


def test_shapes_with_kinks_against_closed_forms(closed_forms):
    x = np.concatenate([np.linspace(0.01, 0.39, 8), 0.4 + np.geomspace(1e-7, 2.0, 30)])
    cases = {
        "trunc_cone": (
            lambda r: np.where(r > B, TAN, 0.0),
            closed_forms.truncated_cone_g(x, TAN, B),
            closed_forms.truncated_cone_force(np.maximum(x, B), TAN, B) / 2,
        ),
        "trunc_paraboloid": (
            lambda r: np.where(r > B, r, 0.0),
            closed_forms.truncated_paraboloid_g(x, 1.0, B),
            closed_forms.truncated_paraboloid_force(np.maximum(x, B), 1.0, B) / 2,
        ),
    }
    for slope, g, moment in cases.values():
        line = equivalent_profile(mdr.Function(derivative=slope, breakpoints=[B]))
        assert np.all(line.g(x[:8]) == 0.0)
        assert np.all(line.moment(x[:8]) == 0.0)
        # the rounding of x is felt through the distance from the corner
        allowed = 1e-13 + 2e-16 * x[8:] / (x[8:] - B)
        assert np.all(np.abs(line.g(x[8:]) / g[8:] - 1) < allowed)
        assert np.all(np.abs(line.moment(x[8:]) / moment[8:] - 1) < allowed)
        assert line.kinks(2.5) == line.breakpoints == (B,)
    tip = equivalent_profile(mdr.Function(derivative=lambda r: np.minimum(r / B, 1.0), breakpoints=[B]))
    assert worst(tip.g(x), closed_forms.rounded_tip_cone_g(x, 1.0, B)) < 1e-13


def test_integrals_of_callables_against_quadrature():
    line = equivalent_profile(PROFILES["wavy_paraboloid"])
    for top in (0.2, 0.62, 0.9):
        integral = graded_gauss(line.g, top)
        squared = graded_gauss(lambda t, top=top: (line.g(top) - line.g(t)) ** 2, top)
        assert float(line.integral(top)) == pytest.approx(integral, rel=1e-12)
        assert float(line.moment(top)) == pytest.approx(top * float(line.g(top)) - integral, rel=1e-12)
        assert float(line.squared(top)) == pytest.approx(squared, rel=1e-12)


@pytest.mark.parametrize("name", PROFILES)
def test_slopes_are_derivatives(name):
    line = equivalent_profile(PROFILES[name])
    h = 1e-3
    for x in (0.25, 0.55, 0.8):
        stencil = np.array([1, -8, 0, 8, -1]) / (12 * h)
        computed = line.g(x + h * np.arange(-2, 3)) @ stencil
        assert computed == pytest.approx(float(line.slope(x)), rel=1e-7, abs=1e-12)


def test_outside_the_known_radii_it_is_nan():
    given_ = PROFILES["wavy_paraboloid"]
    line = equivalent_profile(mdr.Function(given_.f, derivative=given_.derivative, max_radius=0.5))
    assert line.max_radius == 0.5
    for curve in (line.g, line.slope, line.moment, line.squared):
        assert np.isfinite(curve(np.array([0.0, 0.25, 0.5]))).all()
        assert np.isnan(curve(np.array([0.5000001, 0.6, 1e9]))).all()
    assert np.isfinite(line.integral(0.5))
    assert np.isnan(line.integral(0.6))
    deepest = float(line.g(0.5))
    assert line.inverse([0.5 * deepest, 1.01 * deepest])[1] == math.inf
    assert line.inverse_moment(1.01 * float(line.moment(0.5))) == math.inf


def test_a_gap_beyond_a_sharp_edge_is_infinite():
    profile = mdr.FlatPunch(1.0) + mdr.Function(derivative=lambda r: r)
    line = equivalent_profile(profile)
    assert gap_function(profile, line)(np.array([0.5, 1.0, 1.1])).tolist() == pytest.approx(
        [0.125, 0.5, math.inf], rel=1e-13
    )


@pytest.mark.parametrize("name", ["trunc_cone", "rounded_cylinder", "wavy_paraboloid"])
@pytest.mark.parametrize("with_derivative", [True, False])
def test_interpolants_stand_for_callables(name, with_derivative):
    given_ = PROFILES[name]
    profile = given_ if with_derivative else mdr.Function(given_.f, given_.breakpoints)
    kept = without_callables(profile, 1.0)
    r = np.concatenate([np.geomspace(1e-6, 0.3999, 60), np.linspace(0.4001, 1.0, 60)])
    exact = given_.gap(r)
    touching = exact == 0.0
    assert np.all(kept.gap(r)[touching] == 0.0)
    assert worst(kept.gap(r)[~touching], exact[~touching]) < 1e-12
    one, other = (equivalent_profile(p) for p in (given_, kept))
    g = one.g(r)
    assert np.all(other.g(r)[touching] == 0.0)
    assert worst(other.g(r)[~touching], g[~touching]) < 1e-12
    assert kept.breakpoints == given_.breakpoints
    assert 1.0 <= kept.max_radius <= 1.2
    assert np.isfinite(kept.gap(kept.max_radius))
    assert np.isnan(kept.gap(kept.max_radius * 1.001))


def test_unknown_profiles_are_refused():
    class Mine(mdr.Sphere):
        pass

    from pymdr.problem.profiles import Profile

    class Alien(Profile):
        def gap(self, r):
            return r

        def gap_slope(self, r):
            return r

    assert float(equivalent_profile(Mine(1.0)).g(0.5)) == pytest.approx(0.5 * math.atanh(0.5), rel=1e-15)
    with pytest.raises(mdr.ProblemError, match="no map for Alien"):
        equivalent_profile(Alien())


# powers far apart: the smaller one rules at the tip
@example([(6.0, 1.0), (7.5, 1.0)], 0.0)
@example([(1.0, 0.01), (5.5, 2.0)], 0.0)
@settings(max_examples=6, deadline=None)
@given(st.lists(st.tuples(st.floats(1, 8), st.floats(0.01, 3)), min_size=1, max_size=3), st.floats(-9, 3))
def test_any_callable_of_any_size(terms, log_size):
    size = 10.0**log_size
    profile = mdr.Function(
        lambda r: size * sum(c * (r / size) ** n for n, c in terms),
        derivative=lambda r: sum(c * n * (r / size) ** (n - 1) for n, c in terms),
    )
    closed = equivalent_profile(
        sum(
            (mdr.PowerLaw(n, c * size, size) for n, c in terms[1:]),
            mdr.PowerLaw(terms[0][0], terms[0][1] * size, size),
        )
    )
    line = equivalent_profile(profile)
    x = size * np.geomspace(1e-6, 1.0, 40)
    # powers that are not whole are not smooth at the tip
    assert worst(line.g(x), closed.g(x)) < 1e-12
    assert worst(line.moment(x), closed.moment(x)) < 1e-12
    assert worst(line.slope(x), closed.slope(x)) < 1e-12
    assert worst(line.squared(x), closed.squared(x)) < 1e-12
    assert worst(line.inverse(line.g(x)), x) < 1e-12
