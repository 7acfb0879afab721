"""The reference in extended precision against closed forms, and random profiles against the reference."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
SIZES = [LONG("1e-12"), LONG(1), LONG("1e6")]
OFFSETS = np.array(
    [LONG("1e-20"), LONG("1e-18"), LONG("1e-9"), LONG("1e-3"), LONG("0.5"), LONG(3), LONG("1e5")]
)


@pytest.fixture(scope="module")
def accuracy():
    """The module of the study."""
    spec = importlib.util.spec_from_file_location("pymdr_accuracy", Path(__file__).parent / "accuracy.py")
    module = sys.modules["pymdr_accuracy"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def quadrature(accuracy):
    return accuracy.quadrature


@pytest.fixture(scope="module")
def drawn(accuracy):
    return accuracy.random_profiles


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact) - 1)))


def kappa(n):
    """sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2), by recurrence from where the series of the ratio is exact."""
    u, factor = (LONG(n) + 1) / 2, LONG(1)
    while u < 300:
        factor, u = factor * u / (u + LONG(0.5)), u + 1
    series = -1 / (8 * u) + 1 / (192 * u**3) - 1 / (640 * u**5) + 17 / (14336 * u**7)
    return np.sqrt(PI) * factor * np.sqrt(u) * np.exp(series)


@pytest.mark.parametrize("n", [1, 2, 7, 0.3, 1.7, 39.5])
def test_the_factor_of_powers(n):
    assert worst(kappa(n) * kappa(LONG(n) + 1), PI * (LONG(n) + 1) / 2) < 1e-17


# --- the quadrature --------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 12.3, 40.0, 38.4])
@pytest.mark.parametrize("size", SIZES)
def test_powers(quadrature, drawn, n, size):
    curve = drawn.TermCurve([drawn.Power(1.0, n)], size)
    x = size * np.array([LONG("1e-12"), LONG("3e-3"), LONG(1)])
    panel, offset = quadrature.place(curve, LONG(0), x)
    computed = quadrature.images(curve, panel, offset)
    n = LONG(n)
    g = kappa(n) * x**n
    assert worst(computed.g, g) < 1e-17
    assert worst(computed.slope, n * g / x) < 1e-17
    assert worst(computed.moment, n / (n + 1) * g * x) < 1e-17
    assert (
        worst(quadrature.squared(curve, panel, offset), g * g * x * 2 * n * n / ((n + 1) * (2 * n + 1)))
        < 1e-17
    )
    for of, target in (("g", computed.g), ("moment", computed.moment)):
        k, e = quadrature.invert(curve, target, of)
        assert worst(quadrature.radius(curve, k, e), x) < 1e-17


@pytest.mark.parametrize("b", SIZES)
def test_a_truncated_cone_from_its_kink_on(quadrature, drawn, b):
    curve = drawn.TermCurve([drawn.Power(0.25, 1.0, 1.0, float(b))], 1e6 * b)
    b = LONG(float(b))
    delta = b * OFFSETS
    panel, offset = quadrature.place(curve, b, delta)
    x, root = b + delta, np.sqrt(delta * (2 * b + delta))
    angle = np.arctan2(root, b)
    computed = quadrature.images(curve, panel, offset)
    assert worst(computed.g, x * angle / 4) < 1e-17
    assert worst(computed.slope, (angle + b / root) / 4) < 1e-17
    assert worst(computed.moment, (x * x * angle + b * root) / 8) < 1e-17
    k, e = quadrature.invert(curve, computed.g)
    assert worst((curve.edges[k] - b) + e, delta) < 1e-17
    # close above the kink g(x)^2 b is all there is
    near = delta < 1e-15 * b
    assert worst(quadrature.squared(curve, panel[near], offset[near]), computed.g[near] ** 2 * b) < 1e-9


@pytest.mark.parametrize("b", SIZES)
def test_a_rounded_flat_from_its_edge_on(quadrature, drawn, b):
    curve = drawn.TermCurve([drawn.Quotient(2.0 * float(b), float(b))], 1e6 * b)
    b = LONG(float(b))
    delta = b * OFFSETS
    panel, offset = quadrature.place(curve, b, delta)
    x, root = b + delta, np.sqrt(delta * (2 * b + delta))
    angle = np.arctan2(root, b)
    # tan - angle loses digits near the edge, where its series does not
    small = angle < LONG("1e-3")
    series = angle**3 / 3 + 2 * angle**5 / 15 + 17 * angle**7 / 315 + 62 * angle**9 / 2835
    rest = np.where(small, series, root / b - angle)
    computed = quadrature.images(curve, panel, offset)
    loss = np.where(small, 1, 1 + root / b / rest)
    assert worst(computed.g, x * rest / 2) < 1e-17 * float(np.max(loss))
    assert np.all(abs(computed.g / (x * rest / 2) - 1) < LONG("1e-17") * loss)
    k, e = quadrature.invert(curve, computed.g)
    assert worst((curve.edges[k] - b) + e, delta) < 1e-17


@pytest.mark.parametrize("c", SIZES)
def test_a_hyperboloid_over_decades(quadrature, drawn, c):
    curve = drawn.TermCurve([drawn.Hyperboloid(0.5, float(c))], 1e12 * c)
    c = LONG(float(c))
    x = c * LONG(10) ** np.arange(-12, 12)
    panel, offset = quadrature.place(curve, LONG(0), x)
    computed = quadrature.images(curve, panel, offset)
    assert worst(computed.g, x * np.arctan2(x, c) / 2) < 1e-17
    assert worst(computed.slope, (np.arctan2(x, c) + x * c / (c * c + x * x)) / 2) < 1e-17


def test_pressure_and_gap(quadrature, drawn):
    hertz = drawn.TermCurve([drawn.Quotient(1.0)], 4.0)
    cone = drawn.TermCurve([drawn.Power(1.0, 1.0)], 4.0)
    for r in (LONG("1e-9"), LONG("0.3"), LONG("0.99"), 1 - LONG("1e-12")):
        root = np.sqrt((1 - r) * (1 + r))
        value, size = quadrature.pressure_integral(hertz, (0, r), (0, 1))
        assert worst(value, 2 * root) < 1e-17
        assert value == size
        assert (
            worst(quadrature.pressure_integral(cone, (0, r), (0, 1))[0], PI / 2 * np.arcsinh(root / r))
            < 1e-17
        )
    # Johnson (1985), eq. 3.42
    r = LONG(2)
    u = (2 - r * r) * np.arcsin(1 / r) + np.sqrt((r - 1) * (r + 1))
    assert worst(quadrature.gap(hertz, (0, r), (0, 1))[0], r * r / 2 - 1 + u / PI) < 1e-17


def test_the_pressure_carries_the_force(quadrature, drawn):
    """Beside a kink, where the pressure is a logarithm: 2 pi int p r dr = F = 2 E* m(a)."""
    curve = drawn.TermCurve(
        [drawn.Power(0.3, 1.0), drawn.Power(0.1, 1.5, 1.0, 0.4), drawn.Power(0.2, 1.0, 1.0, 0.7)], 2.0
    )
    a_at = tuple(v[0] for v in quadrature.place(curve, np.array([LONG(1)])))
    force = 2 * quadrature.images(curve, *a_at).moment[0]
    rule, total, previous = quadrature.tanh_sinh(0), LONG(0), LONG(0)
    for stop in (LONG(0.4), LONG(0.7), LONG(1)):
        for u, v, w in zip(rule.u, rule.v, rule.weight, strict=True):
            if u > 1e-16 and v > (1e-10 if stop == 1 else 1e-16):
                base, offset = (previous, (stop - previous) * u)
                r_at = tuple(q[0] for q in quadrature.place(curve, np.array([base]), np.array([offset])))
                r = base + offset
                total += 2 * (stop - previous) * w * r * quadrature.pressure_integral(curve, r_at, a_at)[0]
        previous = stop
    assert worst(total, force) < 1e-13


# --- the profiles ----------------------------------------------------------------------------------------


def test_profiles_are_what_users_write(drawn):
    """f and f' as users write them, evaluated in extended precision, are the terms."""
    rng = np.random.default_rng(20)
    nodes, weights = np.polynomial.legendre.leggauss(160)
    for kind in drawn.KINDS:
        for _ in range(5 if kind != "samples" else 0):
            profile = drawn.random_profile(rng, kind)
            curve = profile.curve()
            r = (np.sort(rng.uniform(0.1, 1.0, 40)) * profile.top).astype(LONG)
            panel = np.searchsorted(curve.edges, r, side="right") - 1
            base, offset = curve.edges[panel], r - curve.edges[panel]
            exact, bend = curve.slope(base, offset), curve.bend(base, offset)
            size, step = np.max(abs(exact)), LONG("1e-12") * profile.top
            if "interp" in profile.words:  # numpy.interp takes doubles only
                given, single = profile.derivative(r.astype(float)), 1e-12
            else:  # factors are products of doubles
                given, single = profile.derivative(r), 1e-15
            assert np.all(abs(given - exact) <= single * (abs(exact) + 1e-2 * size)), profile.words
            ahead = (curve.slope(base, offset + step) - exact) / step
            assert np.all(abs(ahead - bend) <= 1e-3 * np.max(abs(bend)) + 1e-6 * size / profile.top), (
                profile.words
            )
            if profile.f is not None:
                top = np.minimum(1.05 * r, profile.top)
                clear = [not any(p < k < q for k in profile.sources) for p, q in zip(r, top, strict=True)]
                inside = r[:, None] + (top - r)[:, None] * (nodes + 1) / 2
                risen = (profile.derivative(inside) @ weights) * (top - r) / 2
                off = abs(risen - (profile.f(top) - profile.f(r)))
                assert np.all(off[clear] <= 1e-9 * (abs(risen) + 1e-2 * np.max(risen))[clear]), profile.words


# --- the study -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("seed", "count"), [(7, 25), pytest.param(7, 120, marks=pytest.mark.long)])
def test_no_result_lies_further_off_than_it_claims(accuracy, seed, count):
    result = accuracy.study(seed, count, effort=accuracy.Effort(rows=4, energies=1, pressures=1))
    assert not result.crashes, result.table()
    assert not result.violations, result.table()


@pytest.mark.long
def test_slip_narrower_than_the_cell_of_a_spring_is_resolved(accuracy):
    """A slip zone of 0.8 % of the radius: springs that missed it dissipated nothing, with a claim of no error."""
    result = accuracy.study(527898749, 2420, only=[2419], effort=accuracy.QUICK, kinds=accuracy.KINDS)
    assert not result.crashes, result.table()
    assert not result.violations, result.table()


@pytest.mark.parametrize("seed", [527898749, pytest.param(3, marks=pytest.mark.long)])
def test_pressures_far_inside_a_contact_with_a_hollow_tip(accuracy, monkeypatch, seed):
    """f alone is given, whose rounding beside the hollow limits the pressure at radii far below a; the first is off by 6e-13."""
    draw = accuracy.random_profiles.random_profile

    def hollow(rng):
        while True:
            profile = draw(rng, "bump")
            if (
                profile.gives == "f"
                and profile.terms[0].h < 0.0
                and profile.terms[0].w > profile.terms[0].m / 9.0
            ):
                return profile

    if seed == 527898749:
        result = accuracy.study(seed, 1, only=[4411], effort=accuracy.QUICK, kinds=accuracy.KINDS)
    else:
        monkeypatch.setattr(accuracy.random_profiles, "random_profile", hollow)
        result = accuracy.study(seed, 10, effort=accuracy.Effort(rows=4, energies=1, pressures=4))
    assert not result.crashes, result.table()
    assert not result.violations, result.table()
    pressures = [v for o in result.outcomes for v in o.values if v.quantity == "pressure"]
    assert any(v.miss > 2.5e-13 for v in pressures)
    assert all(v.miss < 1e-9 for v in pressures)


@pytest.mark.long
def test_shifts_in_the_plane_without_any_slip_are_compared_too(accuracy):
    result = accuracy.study(527898749, 968, only=[967], effort=accuracy.QUICK, kinds=accuracy.KINDS)
    assert not result.crashes, result.table()
    assert not result.violations, result.table()
    work = [v for v in result.outcomes[0].values if v.quantity == "dissipated_energy"]
    assert len(work) == 7
    assert all(v.value == 1.0 for v in work)


@pytest.mark.long
def test_profiles_that_go_on_from_a_slope_as_a_broken_power(accuracy, monkeypatch):
    """f' = c + (r - b)^p beside a breakpoint b, 0.2 < p < 3."""
    draw = accuracy.random_profiles.random_profile
    monkeypatch.setattr(accuracy.random_profiles, "random_profile", lambda rng: draw(rng, "corners"))
    result = accuracy.study(seed=11, count=15, effort=accuracy.Effort(rows=6, energies=2, pressures=1))
    assert not result.crashes, result.table()
    assert not result.violations, result.table()
    given = [v for o in result.outcomes for v in o.values if o.smooth and o.gives != "f"]
    assert max(v.claimed for v in given if v.quantity in ("contact_radius", "normal_stiffness")) < 1e-9
    # what is lost beside b is not felt beyond
    assert np.median([v.miss for v in given if v.quantity == "elastic_energy"]) < 1e-13
