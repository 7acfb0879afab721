"""The Abel transforms against pairs known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import beta, j0, struve

import pymdr as mdr
from drawing import examples
from pymdr.mapping import abel

TWELVE_ORDERS = np.geomspace(1e-9, 1e3, 49)


def worst(computed, exact):
    return np.max(np.abs(np.asarray(computed) / np.asarray(exact, dtype=float) - 1))


@pytest.mark.parametrize("n", [0.5, 1, 1.5, 2, 3, 4, 7.3, 10])
def test_powers(n, closed_forms):
    kappa = closed_forms.kappa(n)
    x = TWELVE_ORDERS if n < 7 else np.geomspace(1e-3, 1e3, 30)
    assert worst(abel.forward(lambda r: n * r ** (n - 1), x), kappa * x**n) < 1e-13
    assert worst(abel.inverse(lambda t: kappa * t**n, x), x**n) < 1e-13
    assert worst(abel.moment(lambda r: n * r ** (n - 1), x), n / (n + 1) * kappa * x ** (n + 1)) < 1e-13


@pytest.mark.parametrize("case", ["n1_k0.2", "n2_k0.2", "n2_k0.5"])
def test_graded_references(references, case):
    reference = references[f"kappa_graded_{case}"]
    n, k = reference["inputs"]["n"], reference["inputs"]["k"]
    computed = float(abel.forward(lambda r: n * r ** (n - 1), 1.0, k=k))
    assert computed == pytest.approx(reference["expected"]["kappa"], rel=1e-12)


@pytest.mark.parametrize("k", [-0.9, -0.5, -0.2, 0.0, 0.3, 0.7, 0.8, 0.95])
@pytest.mark.parametrize("n", [1, 2, 3.5])
def test_kernel_exponent(n, k):
    x = np.geomspace(1e-6, 1e3, 19)
    factor = n / 2 * beta(n / 2, (1 + k) / 2)
    assert worst(abel.forward(lambda r: n * r ** (n - 1), x, k=k), factor * x**n) < 3e-13
    assert worst(abel.inverse(lambda t: factor * t**n, x, k=k), x**n) < 3e-13


SMOOTH = {
    "hyperboloid": (
        lambda r: r / np.hypot(r, 0.3),
        lambda r: r * r / (np.hypot(r, 0.3) + 0.3),
        lambda x: x * np.arctan(x / 0.3),
    ),
    "struve": (
        lambda r: 5 * np.sin(5 * r),
        lambda r: 2 * np.sin(2.5 * r) ** 2,
        lambda x: np.pi / 2 * 5 * x * struve(0, 5 * x),
    ),
    "bessel": (
        lambda r: 3 * np.cos(3 * r),
        lambda r: np.sin(3 * r),
        lambda x: np.pi / 2 * 3 * x * j0(3 * x),
    ),
    "sphere": (
        lambda r: r / np.sqrt((2 - r) * (2 + r)),
        lambda r: r * r / (2 + np.sqrt((2 - r) * (2 + r))),
        lambda x: x * np.arctanh(x / 2),
    ),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_pairs(name):
    slope, f, g = SMOOTH[name]
    x = np.linspace(0.0, 1.9, 60)
    size = np.max(np.abs(g(x)))
    assert np.max(np.abs(abel.forward(slope, x) - g(x))) < 1e-13 * size
    assert np.max(np.abs(abel.inverse(g, x) - f(x))) < 1e-13 * np.max(np.abs(f(x)))
    near = np.geomspace(1e-8, 0.1, 30)
    assert worst(abel.forward(slope, near), g(near)) < 1e-13


def test_a_sphere_up_to_its_rim(closed_forms):
    t = 1 - np.geomspace(1e-3, 0.5, 30)

    def slope(r):
        return r / np.sqrt((1 - r) * (1 + r))

    assert worst(abel.forward(slope, t), closed_forms.sphere_g(t)) < 1e-12
    with pytest.raises(mdr.ConvergenceError):
        abel.forward(slope, 1 - 1e-6)


@pytest.mark.parametrize("b", [1e-9, 0.4, 1e3])
def test_kinks(b, closed_forms):
    x = b * np.concatenate([1 + np.geomspace(1e-9, 0.3, 12), np.linspace(1.4, 40, 12)])
    cone = abel.forward(lambda r: np.where(r > b, 0.3, 0.0), x, breakpoints=[b])
    exact = closed_forms.truncated_cone_g(x, 0.3, b)
    assert np.max(np.abs(cone - exact) / np.maximum(exact, 1e-3 * b)) < 1e-13
    paraboloid = abel.forward(lambda r: np.where(r > b, r / b, 0.0), x, breakpoints=[b])
    exact = closed_forms.truncated_paraboloid_g(x, b, b)
    assert np.max(np.abs(paraboloid - exact) / np.maximum(exact, 1e-3 * b)) < 1e-13
    tip = abel.forward(lambda r: np.minimum(r / b, 1.0), x, breakpoints=[b])
    assert worst(tip, closed_forms.rounded_tip_cone_g(x, 1.0, b)) < 1e-13
    moment = abel.moment(lambda r: np.where(r > b, 0.3, 0.0), x, breakpoints=[b])
    exact = closed_forms.truncated_cone_force(x, 0.3, b) / 2
    assert np.max(np.abs(moment - exact) / np.maximum(exact, 1e-3 * b * b)) < 1e-13


def test_inverse_with_kinks(closed_forms):
    b = 0.4
    r = np.linspace(0.0, 2.0, 41)

    def g(x):
        return closed_forms.truncated_cone_g(x, 0.3, b).astype(float)

    result = abel.inverse(g, r, breakpoints=[b])
    assert np.max(np.abs(result - 0.3 * np.maximum(r - b, 0.0))) < 1e-13


def test_nothing_at_the_axis_and_even_on_the_line():
    assert abel.forward(lambda r: r, 0.0) == 0.0
    assert abel.inverse(lambda x: x**2, 0.0) == 0.0
    assert abel.moment(lambda r: r, 0.0) == 0.0
    assert abel.forward(lambda r: r, -3.0) == abel.forward(lambda r: r, 3.0)


@pytest.mark.parametrize("shape", [(), (5,), (2, 3), (0,)])
def test_shapes_are_kept(shape):
    x = np.full(shape, 2.0)
    for transform in (abel.forward, abel.moment, abel.inverse):
        assert transform(lambda r: r, x).shape == shape
    assert abel.edge_average(lambda r: r, np.full(shape, 0.5), 1.0).shape == shape
    assert abel.line_average(lambda r: r, x, high=1.0).shape == shape


RADII = np.concatenate(
    [np.geomspace(1e-9, 0.1, 12), np.linspace(0.2, 0.9, 8), 1 - np.geomspace(1e-12, 0.05, 9)]
)


@pytest.mark.parametrize("a", [1e-9, 1.0, 1e6])
def test_edge_averages(a):
    r = a * RADII
    chord = np.sqrt((a - r) * (a + r))
    cases = [
        (lambda x: x, chord),
        (lambda x: x**3, chord * (r**2 + chord**2 / 3)),
        (np.ones_like, np.arcsinh(chord / r)),
        (lambda x: 1 / x, np.arctan2(chord, r) / r),
        (lambda x: x**2, (a * chord + r**2 * np.arcsinh(chord / r)) / 2),
    ]
    for curve, exact in cases:
        assert worst(abel.edge_average(curve, r, a), exact) < 1e-13


@pytest.mark.parametrize("k", [-0.6, 0.4])
def test_edge_averages_of_graded_bodies(k):
    r = np.linspace(0.05, 0.99, 20)
    exact = (1 - r * r) ** ((1 + k) / 2) / (1 + k)
    assert worst(abel.edge_average(lambda x: x, r, 1.0, k=k), exact) < 1e-13


def test_edge_average_at_the_axis_and_outside():
    assert abel.edge_average(lambda x: x, 0.0, 2.0) == pytest.approx(2.0, rel=1e-13)
    assert abel.edge_average(lambda x: x**2, 0.0, 2.0) == pytest.approx(2.0, rel=1e-13)
    assert math.isinf(abel.edge_average(np.ones_like, 0.0, 2.0))
    assert abel.edge_average(lambda x: x, [2.0, 3.0], 2.0).tolist() == [0.0, 0.0]


def test_pressure_leads_back_to_the_line_load():
    # q = 2 int r p / sqrt(r^2 - x^2) dr: with Hertz pressure it is E* (d - g) = a^2 - x^2 (E* = R = 1)
    x = np.linspace(0.05, 0.99, 20)
    q = abel.edge_average(lambda r: 2 * r * 2 / np.pi * np.sqrt(np.maximum(1 - r * r, 0.0)), x, 1.0 - 1e-15)
    assert np.max(np.abs(q - (1 - x * x))) < 1e-7  # the root at the upper end is not resolved further
    flat = abel.line_average(np.ones_like, np.array([0.5, 1.5, 9.0]), high=1.0)
    assert worst(flat, [1.0, 2 / np.pi * np.arcsin(1 / 1.5), 2 / np.pi * np.arcsin(1 / 9)]) < 1e-14


def test_gap_of_the_paraboloid(closed_forms):
    a, r = 1.0, 1 + np.geomspace(1e-6, 5.0, 20)
    exact = closed_forms.hertz_gap(r, a, 1.0)
    computed = abel.line_average(lambda x: (x - a) * (x + a), r, low=a, noise=1e-15)
    # the distance x - a is rounded
    assert np.all(np.abs(computed / exact - 1) < 1e-13 + 3e-16 * r / (r - a))
    assert abel.line_average(lambda x: x, 0.5, low=1.0) == 0.0


def test_a_hidden_kink_does_not_pass():
    with pytest.raises(mdr.ConvergenceError, match=r"g\(x\).*500 mm.*breakpoints"):
        abel.forward(lambda r: np.where(r > 0.3, 1.0, 0.0), 0.5)
    with pytest.raises(mdr.ConvergenceError):
        abel.inverse(lambda x: np.where(x > 0.3, 1.0, 0.0), 0.5)


def test_values_that_are_not_numbers_do_not_pass():
    with pytest.raises(mdr.ConvergenceError):
        abel.forward(lambda r: r * math.nan, 0.5)


@settings(max_examples=examples(30), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.5, 8), st.floats(0.1, 3)), min_size=1, max_size=4),
    st.floats(-9, 3),
    st.floats(-9, 3),
)
def test_the_map_is_linear_and_scales(terms, log_size, log_height):
    size, height = 10.0**log_size, 10.0**log_height

    def slope(r):
        return sum(c * n * r ** (n - 1) for n, c in terms)

    x = np.array([0.1, 0.5, 1.0])
    exact = sum(
        c * math.sqrt(math.pi) * math.gamma(n / 2 + 1) / math.gamma((n + 1) / 2) * x**n for n, c in terms
    )
    assert worst(abel.forward(slope, x), exact) < 2e-13
    scaled = abel.forward(lambda r: height / size * slope(r / size), size * x)
    assert worst(scaled / height, abel.forward(slope, x)) < 2e-13


@settings(max_examples=examples(60), deadline=None)
@given(
    st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(0.0, 6.0)), min_size=1, max_size=3),
    st.one_of(st.just(0.0), st.floats(-0.9, 0.9).filter(lambda k: abs(k) > 1e-3)),
    st.floats(-9.0, 3.0),
    st.floats(0.0, 0.9),
)
def test_the_centre_of_an_edge_average_is_that_of_powers(terms, k, decades, dead):
    """int_b^a sum c (x - b)^p x^(k-1) dx for b = 0, and for p = 1 beyond a dead zone b."""
    a = 10.0**decades
    terms = [(c, p) for c, p in terms if p + k > 0.05 and abs(c) > 1e-3]
    if terms:
        parts = [c * a**k / (p + k) for c, p in terms]
        computed = float(abel.edge_average(lambda x: sum(c * (x / a) ** p for c, p in terms), 0.0, a, k=k))
        assert abs(computed - sum(parts)) <= 1e-9 * sum(map(abs, parts))
    sharp = float(abel.edge_average(np.ones_like, 0.0, a, k=-abs(k)))
    assert sharp == math.inf
    b = 2.0 ** -math.ceil(1.0 + 8.0 * dead) * a
    exact = (
        a - b - b * math.log(a / b)
        if k == 0.0
        else (a ** (1 + k) - b ** (1 + k)) / (1 + k) - b * (a**k - b**k) / k
    )
    computed = float(abel.edge_average(lambda x: np.maximum(x - b, 0.0), 0.0, a, k=k))
    assert computed == pytest.approx(exact, rel=1e-6)
