"""The image of a profile for a power-law graded half-space against quadrature and closed forms that share no code."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import beta, betainc

import pymdr as mdr
from drawing import examples, first_of
from pymdr.errors import ProblemError
from pymdr.interpretation.punch import punch_gap
from pymdr.mapping import abel
from pymdr.mapping.equivalent import (
    PowerLine,
    equivalent_profile,
    gap_function,
    power_factor,
    without_callables,
)
from pymdr.mapping.kernels import arc_above, arc_below, fraction_above, fraction_below
from pymdr.numerics.panels import Place

K = st.floats(-0.9, 0.9).filter(lambda k: k != 0.0)
SIZES = st.floats(-9.0, 3.0).map(lambda decades: 10.0**decades)
EXPONENTS = [-0.85, -0.4, -0.05, 0.05, 0.3, 0.62, 0.85]
B = 0.4


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact, dtype=float) - 1)))


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-0.9, 0.9), st.floats(1e-3, 1.0))
def test_arcs_and_shares_are_their_integrals(k, s):
    """In variables v = t^(1+k), in which what is integrated is smooth."""
    p = 1.0 + k

    def integral(smooth, top):
        return float(mpmath.quad(lambda v: smooth(v ** (1 / p)) / p, [0, top**p]))

    at, rest = np.array([s]), np.array([1.0 - s * s])
    assert fraction_above(at, k) == pytest.approx(
        [integral(lambda u: mpmath.sinc(u) ** k, math.acos(1.0 - s))], rel=1e-13
    )
    if s < 0.9:  # beyond that 1 - t^2 is not smooth in v
        arc = math.cos(k * math.pi / 2) * integral(lambda t: (1 - t * t) ** (-p / 2), s)
        assert arc_below(at, rest, k) == pytest.approx([arc], rel=1e-12)
        assert arc_above(at, rest, k) == pytest.approx([math.pi / 2 - arc], rel=1e-12)
        fraction = float(mpmath.quad(lambda angle: mpmath.cos(angle) ** k, [0, math.asin(s)]))
        assert fraction_below(at, k) == pytest.approx([fraction], rel=1e-13)


# --- quadrature that shares no code ----------------------------------------------------------------------

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(14)
_EDGES = np.concatenate([[0.0], 0.25 ** np.arange(20.0, -1.0, -1.0)])


def graded(points):
    """Nodes and weights between some points, graded toward all of them; shape (..., points) gives (..., nodes)."""
    points = np.asarray(points, dtype=float)
    half = (np.diff(_EDGES)[:, None] * (_NODES + 1) / 2 + _EDGES[:-1, None]).ravel()
    fraction = (np.diff(_EDGES)[:, None] * _WEIGHTS / 2).ravel()
    low, high = points[..., :-1, None], points[..., 1:, None]
    width = (high - low) / 2
    nodes = np.stack([low + width * half, high - width * half], axis=-2)
    weights = np.broadcast_to((width * fraction)[..., None, :], nodes.shape)
    return tuple(x.reshape(*points.shape[:-1], -1) for x in (nodes, weights))


def kernel_integral(h, x, k, knots=()):
    """int_0^(pi/2) h(x sin t) cos(t)^k dt, in the power of pi/2 - t that makes the weight 1."""
    # as many knots at once lie below all radii of a group
    x = np.asarray(x, dtype=float)
    below = (np.asarray(knots) < x[..., None]).sum(axis=-1)
    answer = np.empty(x.shape)
    for count in np.unique(below):
        own = np.flatnonzero(below == count)
        for some in np.array_split(own, own.size // 64 + 1):
            answer.flat[some] = _kernel_integral(h, x.flat[some], k, sorted(knots)[:count])
    return answer


def _kernel_integral(h, x, k, knots):
    p = 1.0 + k
    # without knots the nodes are those of all radii
    inner = [np.arccos(b / x) ** p for b in knots[::-1]]
    ends = np.zeros(x.size if inner else 1)
    v, w = graded(np.column_stack([ends, *inner, ends + (math.pi / 2) ** p]))
    angle = v ** (1 / p)
    return (w * h(x[:, None] * np.cos(angle)) * np.sinc(angle / np.pi) ** k).sum(axis=1) / p


class Reference:
    """The definitions, from f', (r f')' and the jumps of f' at breakpoints."""

    def __init__(self, slope, flux, k, jumps=None, knots=()):
        self.slope_of, self.flux, self.k, self.jumps = slope, flux, k, jumps or {}
        self.knots = tuple(knots) or tuple(self.jumps)

    def g(self, x):
        return x * kernel_integral(self.slope_of, x, self.k, self.knots)

    def moment(self, x):
        return x**self.k * kernel_integral(lambda r: self.slope_of(r) * r**2, x, self.k, self.knots)

    def slope(self, x):
        smooth = kernel_integral(self.flux, x, self.k, self.knots)
        return smooth + sum(
            j * b * x**-self.k * ((x - b) * (x + b)) ** ((self.k - 1) / 2)
            for b, j in self.jumps.items()
            if b < x
        )

    def squared(self, x):
        p = 1 + self.k
        t, w = graded([0.0, *(b**p for b in self.knots if b < x), x**p])
        depth, at = self.g(x), t ** (1 / p)
        return float(w @ (depth - self.g(at)) ** 2 / p)

    def pressure(self, r, a):
        p = (1 + self.k) / 2
        v, w = graded(
            [0.0, *(((b - r) * (b + r)) ** p for b in self.knots if r < b < a), (a * a - r * r) ** p]
        )
        x = np.sqrt(r * r + v ** (1 / p))
        total = (w * kernel_integral(self.flux, x, self.k, self.knots) / x).sum()
        for b, jump in self.jumps.items():
            # from the nearer of the two singularities of x^-k (x^2 - b^2)^(p-1) (x^2 - r^2)^(p-1)
            inner, outer = sorted((b, r))
            v, w = graded([0.0, (a * a - outer * outer) ** p])
            square = v ** (1 / p)
            x = np.sqrt(outer * outer + square)
            rest = square + (outer - inner) * (outer + inner)
            total += (w * jump * b * x ** (-self.k - 1) * rest ** (p - 1)).sum()
        return float(total) / (2 * p)

    def gap(self, r, a):
        q = (1 - self.k) / 2
        marks = [((r - b) * (r + b)) ** q for b in self.knots if a < b < r]
        y, w = graded([0.0, *sorted(marks), (r * r - a * a) ** q])
        x = np.sqrt(np.maximum(r * r - y ** (1 / q), a * a))
        start = self.g(a)
        total = w @ (x ** (self.k - 1) * (self.g(x) - start))
        return math.cos(self.k * math.pi / 2) * float(total) / (2 * q)

    def displacement(self, r, a):
        p = 1 + self.k
        t, w = graded([0.0, *(b**p for b in self.knots if b < a), a**p])
        x, top = t ** (1 / p), self.g(a)
        total = w @ ((top - self.g(x)) * ((r - x) * (r + x)) ** (-p / 2))
        return math.cos(self.k * math.pi / 2) * float(total) / p


SPLINE_R = np.linspace(0.0, 1.0, 9)
SPLINE = mdr.Sampled(SPLINE_R, SPLINE_R**2 / 2 + 0.1 * SPLINE_R**4, interpolation=mdr.CubicSpline())


def _spline_flux(r):
    return SPLINE.spline(r, 1) + r * SPLINE.spline(r, 2)


def cases(k):
    """Profiles of unit size with their references."""
    yield (
        "sphere",
        mdr.Sphere(1.0),
        Reference(lambda r: r / np.sqrt(1 - r * r), lambda r: r * (2 - r * r) / (1 - r * r) ** 1.5, k),
    )
    yield (
        "truncated cone",
        mdr.TruncatedCone(flat_radius=B, slope=0.3),
        Reference(lambda r: 0.3 * (r > B), lambda r: 0.3 * (r > B), k, {B: 0.3}),
    )
    yield (
        "rounded cone",
        mdr.RoundedCone(slope=0.5, tip_radius=0.5),
        _of_rounded_cone(k),
    )
    yield (
        "kinked",
        mdr.Function(derivative=lambda r: np.where(r > B, 1.0 + r, r), breakpoints=[B]),
        Reference(lambda r: r + (r > B), lambda r: 2 * r + (r > B), k, {B: 1.0}),
    )
    yield (
        "bent",
        mdr.Function(lambda r: r**2 / 2 + np.maximum(r - B, 0.0) ** 2, [B]),
        Reference(
            lambda r: r + 2 * np.maximum(r - B, 0.0),
            lambda r: 2 * r + np.where(r > B, 4 * r - 2 * B, 0.0),
            k,
            knots=[B],
        ),
    )
    yield (
        "sampled",
        SPLINE,
        Reference(lambda r: SPLINE.spline(r, 1), _spline_flux, k, knots=SPLINE.spline.x[1:-1].tolist()),
    )


def _of_rounded_cone(k):
    profile = mdr.RoundedCone(slope=0.5, tip_radius=0.5)
    (b,) = profile.breakpoints
    return Reference(
        profile.gap_slope, lambda r: np.where(r < b, 2 * r / 0.5, profile.gap_slope(r)), k, knots=[b]
    )


@pytest.mark.parametrize("k", EXPONENTS)
def test_curves_are_their_definitions(k):
    for name, profile, reference in cases(k):
        line = equivalent_profile(profile, k)
        assert line.exponent == k
        x = np.array([0.401, 0.45, 0.7, 0.93])
        for what, tolerance in (("g", 1e-12), ("moment", 1e-12), ("slope", 1e-11)):
            exact = [getattr(reference, what)(xi) for xi in x]
            assert worst(getattr(line, what)(x), exact) < tolerance, (name, what)
        whole = (x ** (1 + k) * line.g(x) - line.moment(x)) / (1 + k)
        assert worst(line.integral(x), whole) < 1e-13, name
        assert worst(line.inverse(line.g(x)), x) < 1e-12, name
        assert worst(line.inverse_moment(line.moment(x)), x) < 1e-12, name
        assert np.max(line.error(x)[:, [0, 2]]) < 1e-11, name


@pytest.mark.parametrize("k", [-0.7, 0.45])
def test_square_integrals_are_their_definition(k):
    for name, profile, reference in cases(k):
        line = equivalent_profile(profile, k)
        assert float(line.squared(0.8)) == pytest.approx(reference.squared(0.8), rel=1e-11), name


@pytest.mark.parametrize("k", first_of([0.45, -0.7]))
def test_fields_from_the_line_follow_their_definitions(k):
    for name, profile, reference in cases(k):
        line = equivalent_profile(profile, k)
        for r in (0.0, 0.2, 0.41, 0.7):
            computed, exact = float(line.pressure_integral(r, 0.8)), reference.pressure(r, 0.8)
            assert computed == pytest.approx(exact, rel=1e-9 if name == "sphere" else 1e-10), (name, r)
        for r in (0.801, 0.95):
            exact = reference.gap(r, 0.8)
            assert float(line.gap_integral(r, 0.8)) == pytest.approx(exact, rel=1e-10), (name, r)
        for r in (0.85, 2.0):
            exact = reference.displacement(r, 0.8)
            assert float(line.displacement_integral(r, 0.8)) == pytest.approx(exact, rel=1e-10), (name, r)


# --- closed forms ----------------------------------------------------------------------------------------


class Kinked:
    """Powers c r^n and a kink j (r - b)_+, at offsets from the breakpoint that keep their digits."""

    def __init__(self, k, powers, b=1.0, jump=0.0, size=1.0):
        self.k, self.powers, self.b, self.jump, self.size = k, powers, b, jump, size

    def profile(self):
        size, b = self.size, self.b * self.size
        powers, jump = self.powers, self.jump

        def derivative(r):
            smooth = sum(c * n * (r / size) ** (n - 1) for n, c in powers)
            return smooth + np.where(r > b, jump, 0.0)

        return mdr.Function(derivative=derivative, breakpoints=[b] if jump else ())

    def curves(self, offset):
        """g, g', m at x = size (b + offset)."""
        k, b, p = self.k, self.b, (1 + self.k) / 2
        x = b + offset
        beyond = np.maximum(offset, 0.0)
        rest = beyond * (2 * b + beyond) / x**2
        kappa = [(n, c * n / 2 * beta(n / 2, p)) for n, c in self.powers]
        bent = self.jump * beta(p, 0.5) * betainc(p, 0.5, rest) / 2
        with np.errstate(divide="ignore"):
            steep = np.where(offset > 0, self.jump * b / x * np.where(offset > 0, rest, 1.0) ** (p - 1), 0.0)
        g = sum(c * x**n for n, c in kappa) + x * bent
        slope = sum(n * c * x ** (n - 1) for n, c in kappa) + bent + steep
        moment = sum(c * n / (n + 1 + k) * x ** (n + 1 + k) for n, c in kappa)
        moment = moment + x ** (2 + k) * self.jump * beta(p, 1.5) * betainc(p, 1.5, rest) / 2
        return self.size * g, slope, self.size ** (2 + k) * moment


POWERS = st.lists(st.tuples(st.floats(0.3, 8.0), st.floats(0.01, 1.0)), min_size=1, max_size=3)


@given(K, POWERS, st.floats(0.05, 0.9), st.floats(0.05, 2.0), SIZES)
@settings(max_examples=examples(20), deadline=None)
@example(0.999e-3, [(1.0, 1.0)], 0.4, 1.0, 1.0)
@example(-0.9, [(2.0, 1.0)], 0.4, 1.0, 1e-9)
@example(0.9, [(0.3, 1.0)], 0.4, 1.0, 1e3)
@example(0.95, [(2.0, 1.0)], 0.4, 1.0, 1.0)
@example(-0.95, [(2.0, 1.0)], 0.4, 1.0, 1.0)
def test_kinked_powers_are_their_closed_forms(k, powers, b, jump, size):
    exact = Kinked(k, powers, b, jump, size)
    line = equivalent_profile(exact.profile(), k)
    offset = np.array([-0.5 * b, -1e-3 * b, 1e-12, 1e-8, 1e-4, 0.03, 0.1, 1.0 - b])
    at = Place(np.full(offset.shape, b * size), offset * size)
    g, slope, moment = exact.curves(offset)
    assert worst(line.g(at), g) < 1e-11
    assert worst(line.slope(at), slope) < 1e-10
    assert worst(line.moment(at), moment) < 1e-11
    top = np.array([0.3 * b, 0.7 * b + 0.3, 1.0]) * size
    assert worst(line.inverse(line.g(top)), top) < 1e-11
    assert worst(line.inverse_moment(line.moment(top)), top) < 1e-11
    # the errors that are told are no smaller than those that are made, but for a few roundings
    made = np.abs(np.stack([line.g(at) / g, line.slope(at) / slope, line.moment(at) / moment], axis=1) - 1)
    assert np.all(made <= 4 * line.error(at)[:, :3] + 1e-12)


@given(K, POWERS, SIZES)
@settings(max_examples=examples(20), deadline=None)
def test_sums_of_powers_are_closed_forms_and_panels_find_them(k, powers, size):
    profile = sum(
        (mdr.PowerLaw(n, c * size, size) for n, c in powers[1:]),
        mdr.PowerLaw(powers[0][0], powers[0][1] * size, size),
    )
    closed = equivalent_profile(profile, k)
    exact = Kinked(k, powers, b=0.0, size=size)
    x = np.geomspace(1e-4, 3.0, 12)
    g, slope, moment = exact.curves(x)
    assert worst(closed.g(size * x), g) < 1e-12
    assert worst(closed.slope(size * x), slope) < 1e-12
    assert worst(closed.moment(size * x), moment) < 1e-12
    assert worst(closed.inverse(g), size * x) < 1e-12
    assert worst(closed.inverse_moment(moment), size * x) < 1e-12
    whole = (x ** (1 + k) * g * size ** (1 + k) - moment) / (1 + k)
    assert worst(closed.integral(size * x), whole) < 1e-11
    panels = equivalent_profile(exact.profile(), k)
    for what in ("g", "slope", "moment", "squared"):
        assert worst(getattr(panels, what)(size * x), getattr(closed, what)(size * x)) < 1e-11


@given(K, POWERS)
@settings(max_examples=examples(20), deadline=None)
def test_square_integrals_of_sums_are_their_definition(k, powers):
    line = equivalent_profile(
        sum((mdr.PowerLaw(n, c, 1.0) for n, c in powers[1:]), mdr.PowerLaw(*powers[0], 1.0)), k
    )
    p = 1 + k
    t, w = graded([0.0, 1.2**p])
    exact = (w * (line.g(1.2) - line.g(t ** (1 / p))) ** 2).sum() / p
    assert float(line.squared(1.2)) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("key", [(1, 0.2), (2, 0.2), (2, 0.5)])
def test_power_factors_of_the_references(references, key):
    n, k = key
    kappa = references[f"kappa_graded_n{n}_k{k}"]["expected"]["kappa"]
    assert power_factor(n, k) == pytest.approx(kappa, rel=1e-14)
    line = equivalent_profile(mdr.PowerLaw(n, 1.0, 1.0), k)
    assert isinstance(line, PowerLine)
    assert float(line.g(1.0)) == pytest.approx(kappa, rel=1e-14)
    assert float(abel.forward(lambda r: n * r ** (n - 1), 1.0, k=k)) == pytest.approx(kappa, rel=1e-12)


@given(K, st.floats(0.5, 5.0))
@settings(max_examples=examples(20), deadline=None)
def test_named_profiles_are_powers(k, x):
    kappa = 2 / (1 + k)
    assert float(equivalent_profile(mdr.Paraboloid(3.0), k).g(x)) == pytest.approx(
        kappa * x * x / 6, rel=1e-13
    )
    cone = equivalent_profile(mdr.Cone(slope=0.3), k)
    assert float(cone.g(x)) == pytest.approx(0.3 * power_factor(1.0, k) * x, rel=1e-13)
    dome = equivalent_profile(mdr.DomedPunch(6.0, dome_radius=3.0), k)
    assert float(dome.g(x)) == pytest.approx(kappa * x * x / 6, rel=1e-13)
    assert dome.edge == 6.0
    flat = equivalent_profile(mdr.FlatPunch(6.0), k)
    assert float(flat.g(x)) == 0.0
    assert flat.exponent == dome.exponent == cone.exponent == k
    r = np.array([0.0, 0.3, 0.9]) * x
    pressure = kappa / 3 * (x * x - r * r) ** ((1 + k) / 2) / (1 + k)
    for line in (equivalent_profile(mdr.Paraboloid(3.0), k), dome):
        assert worst(line.pressure_integral(r, x), pressure) < 1e-12


# --- identities ------------------------------------------------------------------------------------------


@given(K, POWERS, st.floats(0.05, 0.9), st.floats(0.05, 2.0), SIZES)
@settings(max_examples=examples(12), deadline=None)
def test_profiles_come_back(k, powers, b, jump, size):
    exact = Kinked(k, powers, b, jump, size)
    line = equivalent_profile(exact.profile(), k)
    r = np.array([0.1 * b, 0.99 * b, b * (1 + 1e-3), 0.5 * b + 0.5, 1.0])
    f = size * (sum(c * r**n for n, c in powers) + jump * np.maximum(r - b, 0.0))
    assert worst(2 / math.pi * line.gap_integral(size * r, 0.0), f) < 1e-11
    assert worst(gap_function(exact.profile(), line)(size * r), f) < 1e-11
    # u and the gap are what is left of f and d
    a = (0.3 * b + 0.4) * size
    out = a * np.array([1.0, 1 + 1e-9, 1.01, 1.5, 3.0])
    difference = line.gap_integral(out, a) - line.displacement_integral(out, a)
    f = size * (sum(c * (out / size) ** n for n, c in powers) + jump * np.maximum(out / size - b, 0.0))
    whole = math.pi / 2 * (f + line.g(a))
    assert np.max(np.abs(difference - math.pi / 2 * (f - line.g(a))) / whole) < 1e-11


@given(K, POWERS)
@settings(max_examples=examples(10), deadline=None)
def test_the_pressure_carries_the_force(k, powers):
    exact = Kinked(k, powers, b=0.0)
    for line in (
        equivalent_profile(exact.profile(), k),
        equivalent_profile(mdr.PowerLaw(powers[0][0], powers[0][1], 1.0), k),
    ):
        # p goes like a power of r, of which r = s^4 makes a mild one
        s, w = graded([0.0, 0.9**0.25])
        force = (w * 4 * s**7 * line.pressure_integral(s**4, 0.9)).sum() * (1 + k)
        assert force == pytest.approx(float(line.moment(0.9)), rel=1e-9)


@given(K, POWERS)
@example(-0.9, [(0.375, 1.0)])
@settings(max_examples=examples(20), deadline=None)
def test_closed_forms_and_panels_give_the_same_fields(k, powers):
    closed = equivalent_profile(
        sum((mdr.PowerLaw(n, c, 1.0) for n, c in powers[1:]), mdr.PowerLaw(*powers[0], 1.0)), k
    )
    panels = equivalent_profile(Kinked(k, powers, b=0.0).profile(), k)
    r, out = np.array([0.01, 0.3, 0.79]), np.array([0.81, 0.9, 3.0])
    f = sum(c * r**n for n, c in powers)
    for line in (closed, panels):
        assert worst(2 / math.pi * line.gap_integral(r, 0.0), f) < 1e-11
    for what, at in (("pressure_integral", r), ("gap_integral", out), ("displacement_integral", out)):
        assert worst(getattr(panels, what)(at, 0.8), getattr(closed, what)(at, 0.8)) < 1e-10, what


@pytest.mark.parametrize("k", EXPONENTS)
def test_a_flat_punch_outside(k):
    for r in (1.0 + 1e-6, 1.3, 4.0):
        q = (1 - k) / 2
        y, w = graded([0.0, ((r - 1) * (r + 1)) ** q])
        x = np.sqrt(r * r - y ** (1 / q))
        exact = math.cos(k * math.pi / 2) * (w * x ** (k - 1)).sum() / (2 * q)
        assert float(punch_gap(k, 1.0, np.array([r]))[0]) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("k", [1e-14, -1e-14])
def test_a_vanishing_exponent_is_none(k):
    for name, profile, _ in cases(0.0):
        graded_line, line = equivalent_profile(profile, k), equivalent_profile(profile)
        x = np.array([1e-3, 0.2, 0.39, 0.4 + 1e-6, 0.45, 0.7, 0.93])
        if name == "truncated cone":
            x = x[3:]
        for what in ("g", "slope", "moment", "squared"):
            assert worst(getattr(graded_line, what)(x), getattr(line, what)(x)) < 1e-12, (name, what)
        r, out = np.array([0.01, 0.3, 0.45, 0.7]), np.array([0.81, 0.95])
        for what, at in (("pressure_integral", r), ("gap_integral", out), ("displacement_integral", out)):
            computed, exact = getattr(graded_line, what)(at, 0.8), getattr(line, what)(at, 0.8)
            assert worst(computed, exact) < 1e-12, (name, what)


@pytest.mark.long
@given(K, SIZES)
@settings(max_examples=6, deadline=None)
def test_size_is_only_a_scale(k, size):
    for make in (
        lambda s: mdr.Sphere(s),
        lambda s: mdr.Ellipsoid(s, 0.5 * s),
        lambda s: mdr.TruncatedCone(flat_radius=B * s, slope=0.3),
        lambda s: mdr.Sampled(SPLINE_R * s, (SPLINE_R**2 / 2 + 0.1 * SPLINE_R**4) * s),
        lambda s: mdr.Sphere(s) + mdr.Cone(slope=0.1),
    ):
        unit, line = equivalent_profile(make(1.0), k), equivalent_profile(make(size), k)
        x = np.array([0.45, 0.7, 0.9])
        for what, power in (("g", 1.0), ("slope", 0.0), ("moment", 2 + k), ("squared", 3 + k)):
            assert worst(getattr(line, what)(size * x) / size**power, getattr(unit, what)(x)) < 1e-11
        assert worst(line.inverse(size * unit.g(x)), size * x) < 1e-11
        assert worst(line.inverse_moment(size ** (2 + k) * unit.moment(x)), size * x) < 1e-11


# --- the rest --------------------------------------------------------------------------------------------


def test_every_profile_has_one_map_for_every_exponent():
    profile = mdr.TruncatedCone(flat_radius=B, slope=0.3)
    assert equivalent_profile(profile, 0.3) is equivalent_profile(profile, 0.3)
    assert equivalent_profile(profile, 0.3) is not equivalent_profile(profile)
    assert equivalent_profile(profile, 0.0) is equivalent_profile(profile)
    assert equivalent_profile(profile, 0.3).exponent == 0.3
    assert equivalent_profile(profile).exponent == 0.0


@pytest.mark.parametrize("k", [1.0, -1.0, 2.5, math.nan])
@pytest.mark.parametrize("profile", [mdr.Sphere(1.0), mdr.Cone(slope=0.1), mdr.FlatPunch(1.0)])
def test_other_exponents_are_refused(profile, k):
    with pytest.raises(ProblemError, match="between -1 and 1"):
        equivalent_profile(profile, k)


@pytest.mark.parametrize("k", [-0.97, 0.97])
def test_panels_have_their_limit(k):
    assert float(equivalent_profile(mdr.Paraboloid(1.0), k).g(1.0)) == pytest.approx(1 / (1 + k), rel=1e-13)
    with pytest.raises(ProblemError, match=r"from -0\.95 to 0\.95"):
        equivalent_profile(mdr.Sphere(1.0), k)


def test_a_saved_callable_is_mapped_alike():
    profile = mdr.Function(derivative=lambda r: np.where(r > B, 1.0 + r, r), breakpoints=[B])
    saved = without_callables(profile, 1.0)
    x = np.array([0.1, 0.41, 0.9])
    for k in (-0.6, 0.35):
        assert worst(equivalent_profile(saved, k).g(x), equivalent_profile(profile, k).g(x)) < 1e-12


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.5])
def test_beyond_its_end_a_profile_is_unknown(k):
    line = equivalent_profile(mdr.Function(derivative=lambda r: np.where(r <= 0.7, r, math.nan)), k)
    g = line.g([0.5, 0.9])
    assert g[0] == pytest.approx(0.25 / (1 + k), rel=1e-13)
    assert math.isnan(g[1])


@pytest.mark.parametrize("k", [-0.5, 0.5])
def test_overlap_and_searches_know_the_exponent(k):
    line = equivalent_profile(mdr.Hyperboloid(tip_radius=1e-6, slope=0.2), k)
    a = float(line.inverse(1e-7))
    assert line.overlap_radius(1e-7) >= a
    assert line.rough_radius(lambda x, g: g > 1e-7) == pytest.approx(a, rel=0.3)
    assert float(line.inverse_moment(line.moment(a))) == pytest.approx(a, rel=1e-12)
