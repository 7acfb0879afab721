"""The curves of the adhesion laws against their literature, each other and independent quadrature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import struve

from common import DMT, JKR, Powers, Ripple, references
from drawing import examples
from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import (
    cohesive_zone,
    dmt_pull,
    energy_release_rate,
    jkr_force,
    jkr_power_law_force,
    maugis_dugdale,
    maugis_parameter,
    power_law_factor,
    power_law_pull_off,
    rigid_pull,
    stress_intensity,
    tabor_parameter,
)
from pymdr.line.adhesion.cohesive_zone import zone_integrals
from pymdr.line.curves import ElasticLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.problem.profiles import (
    FlatPunch,
    Function,
    Paraboloid,
    PowerLaw,
    Sampled,
    Sphere,
    TruncatedParaboloid,
)

LONG = np.longdouble
gauss = cache(np.polynomial.legendre.leggauss)
LONG_PI = LONG("3.14159265358979323846264338327950288")


@dataclass(frozen=True)
class Wavy:
    """g of r²/2R + h (1 - cos kr), which has a Struve function in it."""

    R: float
    h: float
    k: float
    edge: float = np.inf
    max_radius: float = np.inf
    breakpoints: tuple[float, ...] = ()
    exponent: float = 0.0

    def g(self, x):
        return x**2 / self.R + 0.5 * np.pi * self.h * self.k * x * struve(0, self.k * x)

    def slope(self, x):
        z = self.k * x
        return 2.0 * x / self.R + 0.5 * np.pi * self.h * self.k * (
            struve(0, z) + z * (2.0 / np.pi - struve(1, z))
        )

    def moment(self, x):
        integral = x**3 / (3.0 * self.R) + 0.5 * np.pi * self.h * x * struve(1, self.k * x)
        return x * self.g(x) - integral

    def squared(self, x):
        x = np.asarray(x, dtype=float)
        t, w = gauss(80)
        y = 0.5 * x[..., None] * (t + 1.0)
        return 0.5 * x * ((self.g(x)[..., None] - self.g(y)) ** 2 @ w)


@dataclass(frozen=True)
class Truncated:
    """g of a paraboloid cut flat at radius b: g' is infinite at b."""

    R: float
    b: float
    edge: float = np.inf
    max_radius: float = np.inf
    exponent: float = 0.0

    @property
    def breakpoints(self):
        return (self.b,)

    def _root(self, x):
        return np.sqrt(np.maximum((x - self.b) * (x + self.b), 0.0))

    def g(self, x):
        return x / self.R * self._root(x)

    def slope(self, x):
        with np.errstate(all="ignore"):
            return np.where(x >= self.b, (self._root(x) + x * x / self._root(x)) / self.R, 0.0)

    def moment(self, x):
        return x * self.g(x) - self._root(x) ** 3 / (3.0 * self.R)

    def squared(self, x):
        x = np.asarray(x, dtype=float)
        t, w = gauss(60)
        flat = np.minimum(self.b, x)
        t = 0.5 * (t + 1.0)
        y = flat[..., None] + (x - flat)[..., None] * t**2
        outer = (self.g(x)[..., None] - self.g(y)) ** 2 @ (w * t)
        return self.g(x) ** 2 * flat + (x - flat) * outer


def paraboloid(R=1.0, **limits):
    return Powers(((2.0, 1.0 / R),), **limits)


def power_law(n, c):
    return Powers(((n, float(power_law_factor(n)) * c),))


def flat(b):
    return Powers(((1.0, 0.0),), edge=b)


LINES = {
    "paraboloid": paraboloid(),
    "cone": Powers(((1.0, 1.2),)),
    "blunt": Powers(((4.0, 1.0),)),
    "needle": Powers(((0.7, 0.7),)),
    "mixed": Powers(((1.3, 0.4), (3.0, 0.6))),
    "ripple": Ripple(1.0, 0.9, 9.0),
    "truncated": Truncated(1.0, 0.5),
    "capped cylinder": Powers(((2.0, 0.5),), edge=1.0),
    "flat punch": flat(1.0),
}


def smooth_intervals(law, top):
    """Smooth stretches of a curve, without their very beginning, where odd powers of a tip disturb Gauss."""
    marks = [law.start, *(k for k in law.knots if k < top), top]
    return [(lo + 1e-3 * (hi - lo), hi) for lo, hi in pairwise(marks) if hi - lo > 1e-12 * top]


def work_by_quadrature(law, low, high, nodes=160):
    """int F dd over a smooth interval; s = low + (high - low) sin²(θ/2) for half-integer powers at its ends."""
    t, w = gauss(nodes)
    theta = 0.5 * np.pi * (t + 1.0)
    s = low + (high - low) * np.sin(0.5 * theta) ** 2
    rate = law.states(s).normal_force * law.slopes(s)[0] * np.sin(theta)
    return float(0.25 * np.pi * (high - low) * np.sum(w * rate))


def total_energy(law, s):
    return sum(law.energies(np.asarray(s)))


# --- JKR --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("entry", references("4 JKR"), ids=lambda entry: entry["id"])
def test_references_of_jkr(entry):
    rtol, given_, expected = entry["rtol"], entry["inputs"], entry["expected"]

    def agree(value, name):
        assert value == pytest.approx(expected[name], rel=rtol), name

    if "n" in given_:
        n, c, E, gamma = (given_[key] for key in ("n", "c", "Estar", "gamma"))
        law = JKR(power_law(n, c), E, gamma)
        for name, k in (("F", 0.0), ("D", np.inf), ("km", given_["km"])):
            pull_off = power_law_pull_off(n, c, E, gamma, k)
            agree(float(pull_off.contact_radius), f"a_{name}")
            agree(float(pull_off.normal_force), f"F_{name}")
            agree(float(pull_off.indentation), f"d_{name}")
            state = law.states(pull_off.contact_radius)
            agree(float(state.normal_force), f"F_{name}")
            agree(float(state.indentation), f"d_{name}")
    elif "a" in given_:
        state = JKR(flat(given_["a"]), 1.0, 1.0).states(given_["a"])
        agree(float(state.normal_force), "F")
        agree(float(state.indentation), "d")
    else:
        law = JKR(paraboloid(given_["R"]), given_["Estar"], given_["gamma"])
        for a, d, F in (
            ("a_at_d0", None, "F_at_d0"),
            ("a_at_F0", "d_at_F0", None),
            ("a_forcecontrol", "d_at_pulloff", "F_pulloff"),
            ("a_dispcontrol", "d_snapoff", "F_at_snapoff"),
        ):
            state = law.states(expected[a])
            if d:
                agree(float(state.indentation), d)
            if F:
                agree(float(state.normal_force), F)
        assert float(law.states(expected["a_at_d0"]).indentation) == pytest.approx(0.0, abs=1e-14)
        assert float(law.states(expected["a_at_F0"]).normal_force) == pytest.approx(0.0, abs=1e-13)
        agree(-float(total_energy(law, expected["a_at_d0"])), "E_jump_in")
        agree(float(total_energy(law, expected["a_dispcontrol"])), "E_jump_out")


@pytest.mark.parametrize("name", LINES)
def test_the_work_of_jkr_is_its_energy(name):
    law = JKR(LINES[name], 1.3, 0.4)
    for low, high in smooth_intervals(law, 2.2):
        gain = total_energy(law, high) - total_energy(law, low)
        assert work_by_quadrature(law, low, high) == pytest.approx(gain, rel=1e-11, abs=1e-11)


def test_energy_is_stationary_at_constant_indentation():
    line, E, gamma, a = paraboloid(), 1.3, 0.4, 0.9
    d = float(JKR(line, E, gamma).states(a).indentation)

    def energy(radius):
        return E * quad(lambda x: (d - x**2) ** 2, 0.0, radius, epsabs=0)[0] - np.pi * radius**2 * gamma

    assert energy(a) == pytest.approx(float(total_energy(JKR(line, E, gamma), a)), rel=1e-13)
    step = 1e-5
    assert (energy(a + step) - energy(a - step)) / (2 * step) == pytest.approx(0.0, abs=1e-9)
    opening = a**2 - d
    assert energy_release_rate(ElasticLine(line, E), a, opening) == pytest.approx(gamma, rel=1e-14)
    assert stress_intensity(a, opening, E) ** 2 / (2 * E) == pytest.approx(gamma, rel=1e-14)


def test_slopes_of_jkr_vanish_at_the_closed_extrema():
    for n in (0.8, 1.0, 1.7, 2.0, 5.0):
        law = JKR(power_law(n, 0.6), 2.0, 0.3)
        by_depth = law.slopes(power_law_pull_off(n, 0.6, 2.0, 0.3).contact_radius)[0]
        by_force = law.slopes(power_law_pull_off(n, 0.6, 2.0, 0.3, 0.0).contact_radius)[1]
        a = power_law_pull_off(n, 0.6, 2.0, 0.3, 1.1).contact_radius
        depth, force = law.slopes(a)
        assert by_depth == pytest.approx(0.0, abs=1e-13)
        assert by_force == pytest.approx(0.0, abs=1e-13)
        assert depth + force / 1.1 == pytest.approx(0.0, abs=1e-13)


def test_a_sharp_edge_holds_the_contact():
    law = JKR(LINES["capped cylinder"], 2.0, 0.1)
    at_edge, above = law.states(np.array([1.0, 1.7])).contact_radius
    assert (at_edge, above) == (1.0, 1.0)
    states = law.states(np.array([1.0, 1.7]))
    assert np.diff(states.indentation)[0] == pytest.approx(0.7, rel=1e-14)
    assert np.diff(states.normal_force)[0] == pytest.approx(2 * 2.0 * 1.0 * 0.7, rel=1e-14)
    assert law.knots == (1.0,)
    assert np.isinf(law.limit)
    assert JKR(paraboloid(edge=2.0, max_radius=1.5), 1.0, 1.0).limit == 1.5


def test_without_work_jkr_and_dmt_are_the_bare_contact():
    a = np.array([0.0, 0.3, 1.0])
    bare = JKR(paraboloid(), 1.0, 0.0)
    assert np.array_equal(bare.states(a).indentation, a**2)
    assert np.allclose(bare.states(a).normal_force, 4 * a**3 / 3, rtol=1e-15)
    assert np.array_equal(bare.slopes(a)[0], 2 * a)
    assert np.array_equal(DMT(paraboloid(), 1.0, 0.0).states(a).normal_force, bare.states(a).normal_force)
    works = 10.0 ** -np.arange(2.0, 9.0)
    gaps = [
        float(bare.states(1.0).normal_force - JKR(paraboloid(), 1.0, w).states(1.0).normal_force)
        for w in works
    ]
    orders = np.diff(np.log(gaps)) / np.diff(np.log(works))
    assert np.allclose(orders, 0.5, atol=1e-6)


def test_the_real_equivalent_profiles_fit_the_protocol():
    a = np.linspace(0.1, 1.9, 7)
    ball = JKR(equivalent_profile(Paraboloid(1.0)), 1.0, 1.0)
    assert np.allclose(ball.states(a).normal_force, JKR(paraboloid(), 1.0, 1.0).states(a).normal_force)
    punch = maugis_dugdale(equivalent_profile(FlatPunch(1.0)), 1.0, 1.0, 2.0)
    own = maugis_dugdale(flat(1.0), 1.0, 1.0, 2.0)
    assert np.allclose(punch.states(a).normal_force, own.states(a).normal_force, rtol=1e-13)
    wavy = equivalent_profile(Function(lambda r: r**2 / 2 + 0.01 * (1 - np.cos(12 * r))))
    for make in (lambda line: JKR(line, 1.0, 0.5), lambda line: maugis_dugdale(line, 1.0, 0.5, 1.5)):
        ours, theirs = make(Wavy(1.0, 0.01, 12.0)).states(a), make(wavy).states(a)
        assert np.allclose(ours.normal_force, theirs.normal_force, rtol=0, atol=1e-11)
        assert np.allclose(ours.indentation, theirs.indentation, rtol=0, atol=1e-11)


# --- Maugis-Dugdale ---------------------------------------------------------------------------------------


def maugis_1992(lam, A):
    """m, P/(πγR) and δ/(π²γ²R/K²)^(1/3) of Maugis (1992) in extended precision, in textbook form."""
    lam, A = (np.asarray(x).astype(LONG) for x in np.broadcast_arrays(lam, A))

    def excess(m):
        root = np.sqrt(m * m - 1)
        angle = np.arctan(root)
        return lam * A**2 / 2 * (root + (m * m - 2) * angle) + 4 * lam**2 * A / 3 * (root * angle - m + 1) - 1

    low, high = np.ones_like(A), np.full_like(A, 1e6)
    for _ in range(160):
        middle = 1 + np.sqrt(np.maximum(low - 1, LONG(1e-30)) * (high - 1))
        above = excess(middle) > 0
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    m = 0.5 * (low + high)
    root = np.sqrt(m * m - 1)
    force = A**3 - lam * A**2 * (root + m * m * np.arctan(root))
    return m, force, A**2 - LONG(4) / 3 * A * lam * root


def sphere_case(lam, R=1.0, E=1.0, gamma=1.0):
    """Strength, and the units of radius, force and indentation of Maugis (1992)."""
    K = 4 * E / 3
    strength = lam / (2.0 * (R / (np.pi * gamma * K**2)) ** (1 / 3))
    return (
        strength,
        (np.pi * gamma * R**2 / K) ** (1 / 3),
        np.pi * gamma * R,
        (np.pi**2 * gamma**2 * R / K**2) ** (1 / 3),
    )


@pytest.mark.skipif(np.finfo(LONG).eps > 1e-18, reason="no extended precision to hold it against")
@pytest.mark.parametrize("lam", [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 50.0])
def test_the_sphere_of_maugis_1992(lam):
    A = np.array([1e-3, 0.03, 0.3, 0.7, 1.0, 1.6, 2.5, 5.0])
    m, force, depth = maugis_1992(lam, A)
    strength, radius, newton, metre = sphere_case(lam)
    assert maugis_parameter(1.0, 1.0, 1.0, strength) == pytest.approx(lam, rel=1e-14)
    law = maugis_dugdale(paraboloid(), 1.0, 1.0, strength)
    states = law.states(law.ends[1] + A * radius)
    # the parameter s counts from the end of the cohesive piece: take the radii as they came out
    m, force, depth = maugis_1992(lam, states.contact_radius / radius)
    # errors of A are excluded, those of F are scaled by the larger of πRγ and the bare force
    scale = np.maximum(1.0, A**3)
    assert np.max(np.abs(states.normal_force / newton - force) / scale) < 1e-12
    assert np.max(np.abs(states.indentation / metre - depth) / np.maximum(1.0, A**2)) < 1e-12
    assert np.max(np.abs(states.cohesive_radius / states.contact_radius / m - 1)) < 1e-12


@pytest.mark.parametrize("entry", references("4 Maugis-Dugdale"), ids=lambda entry: entry["id"])
def test_references_of_maugis_dugdale(entry):
    expected, lam = entry["expected"], entry["inputs"]["lam"]
    strength, _, newton, _ = sphere_case(lam)
    law = maugis_dugdale(paraboloid(), 1.0, 1.0, strength)
    if "a" in expected:
        state = law.states(law.ends[1] + expected["a"])
        for name, value in (
            ("c", state.cohesive_radius),
            ("F", state.normal_force),
            ("d", state.indentation),
        ):
            assert float(value) == pytest.approx(expected[name], rel=entry["rtol"])
        assert strength == pytest.approx(expected["sigma0"], rel=entry["rtol"])
        return
    low, high = law.ends[1] + 1e-6, law.ends[1] + 3.0
    s = brentq(lambda s: float(law.slopes(s)[1]), low, high, xtol=1e-12)
    force = float(law.states(s).normal_force) / newton
    assert force == pytest.approx(expected["F_over_piRgamma"], rel=entry["rtol"])


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("strength", [0.3, 2.0, 12.0])
def test_the_work_of_maugis_dugdale_is_its_energy(name, strength):
    law = maugis_dugdale(LINES[name], 1.3, 0.4, strength)
    finite = [end for end in law.ends if np.isfinite(end)]
    top = finite[-1] + 1.0
    assert float(law.states(0.0).indentation) == pytest.approx(law.touch, rel=1e-14)
    assert float(law.states(0.0).normal_force) == pytest.approx(0.0, abs=1e-290)
    for low, high in smooth_intervals(law, top):
        gain = total_energy(law, high) - total_energy(law, low)
        scale = np.pi * 0.4 * high**2
        assert abs(work_by_quadrature(law, low, high) - gain) < 1e-11 * max(scale, abs(gain))
    for knot in law.knots:
        before, after = (law.states(knot * (1 + x)) for x in (-1e-13, 1e-13))
        for field in ("indentation", "normal_force", "contact_radius", "cohesive_radius"):
            x, y = float(getattr(before, field)), float(getattr(after, field))
            assert x == pytest.approx(y, rel=1e-5, abs=2e-6 * (1.0 + strength)), (knot, field)


@pytest.mark.parametrize("name", ["cone", "blunt", "mixed", "truncated"])
def test_the_gap_at_the_end_of_the_zone(name):
    """The gap condition in its first form, with g(x) - d, by adaptive quadrature."""
    line, E, gamma, strength = LINES[name], 1.3, 0.4, 0.9
    law = maugis_dugdale(line, E, gamma, strength)
    for s in law.ends[1] + np.array([0.2, 0.45, 1.1]):
        state = law.states(s)
        a, c, d = (float(x) for x in (state.contact_radius, state.cohesive_radius, state.indentation))
        kinks = [np.arccos(b / c) for b in line.breakpoints if a < b < c]
        opened = quad(
            lambda psi, c=c, d=d: float(line.g(np.array(c * np.cos(psi)))) - d,
            0.0,
            np.arccos(a / c),
            points=kinks or None,
            epsabs=0,
            epsrel=1e-12,
        )[0]
        gap = 2 / np.pi * (opened - 2 * strength / E * (c - a))
        assert gap == pytest.approx(gamma / strength, rel=1e-9)


def test_cohesion_without_contact_meets_the_contact():
    law = maugis_dugdale(Powers(((1.0, 1.2),)), 1.0, 1.0, 0.5)
    s = np.array([0.3, 1.0]) * law.ends[0]
    state = law.states(s)
    f = 2 / np.pi * 1.2 * s
    assert np.array_equal(state.contact_radius, [0.0, 0.0])
    assert np.allclose(state.normal_force, -np.pi * 0.5 * s**2, rtol=1e-13)
    assert np.allclose(state.indentation, f - 4 * 0.5 * s / np.pi - 2.0, rtol=1e-13)
    # at the join the gap in the centre, -d - 2 σ0 c / E*, is closed
    assert -state.indentation[1] - 2 * 0.5 * s[1] == pytest.approx(0.0, abs=1e-12)


def test_a_punch_smaller_than_the_zone():
    """Weak cohesion pulls all of a small punch at once: no zone condition, first a lift, then contact grows."""
    b, strength = 0.2, 0.5
    law = maugis_dugdale(flat(b), 1.0, 1.0, strength)
    assert law.ends[0] == b
    assert law.ends[1] > b
    assert law.ends[2] == law.ends[1]
    states = law.states(0.5 * (law.ends[0] + law.ends[1]))
    assert float(states.normal_force) == pytest.approx(-np.pi * strength * b**2, rel=1e-14)
    full = law.states(law.ends[3] + 0.1)
    assert float(full.normal_force) == pytest.approx(2 * b * 0.1, rel=1e-12)
    assert float(full.contact_radius) == b


def test_jkr_is_the_limit_of_high_strength():
    errors = []
    lams = np.array([10.0, 20.0, 40.0, 80.0])
    a = 1.3
    exact = JKR(paraboloid(), 1.0, 1.0).states(a)
    for lam in lams:
        law = maugis_dugdale(paraboloid(), 1.0, 1.0, sphere_case(lam)[0])
        state = law.states(law.ends[1] + a)
        errors.append(
            [
                abs(float(state.normal_force - exact.normal_force)),
                abs(float(state.indentation - exact.indentation)),
            ]
        )
    orders = -np.diff(np.log(errors), axis=0) / np.diff(np.log(lams))[:, None]
    assert np.allclose(orders[-1], 2.0, atol=0.02)


def test_dmt_is_the_limit_of_low_strength():
    """The pull of Maugis-Dugdale tends to 2πγR for the paraboloid and to the rigid pull for any profile."""
    for name in ("paraboloid", "cone", "mixed"):
        gaps = []
        lams = np.array([1e-2, 1e-3])
        for lam in lams:
            strength = sphere_case(lam)[0] if name == "paraboloid" else lam
            # the same rigid range at any stiffness: the modulus goes up instead
            law = maugis_dugdale(LINES[name], 1.0 / lam, 1.0, 1.0 if name != "paraboloid" else strength)
            pull = rigid_pull(LINES[name], 1.0, law.strength)
            gaps.append(abs(float(law.states(law.ends[0]).normal_force) / -pull - 1.0))
        order = np.diff(np.log(gaps))[0] / np.diff(np.log(lams))[0]
        assert order > 0.8
        assert gaps[-1] < 2e-2
    assert rigid_pull(paraboloid(3.0), 0.7, 5.0) == pytest.approx(float(dmt_pull(3.0, 0.7)), rel=1e-12)
    assert rigid_pull(flat(0.5), 1.0, 4.0) == pytest.approx(np.pi * 0.25 * 4.0)


def test_characteristic_numbers():
    R, E, gamma, h0 = 2e-6, 3e6, 0.05, 4e-10
    ratio = maugis_parameter(R, E, gamma, gamma / h0) / tabor_parameter(R, E, gamma, h0)
    assert ratio == pytest.approx(2 * (9 / (16 * np.pi)) ** (1 / 3), rel=1e-14)


# --- integrals with error control -------------------------------------------------------------------------


@settings(max_examples=examples(40), deadline=None)
@given(
    st.floats(0.55, 1.0),
    st.floats(-6.0, 3.0),
    st.lists(st.floats(-14.0, 0.0), min_size=1, max_size=3),
)
def test_widths_of_zones_around_small_contacts_of_sharp_tips(exponent, decade, shares):
    # a power of the radius is similar to itself at every size
    size = 10.0**decade
    line = equivalent_profile(PowerLaw(exponent, 0.01 * size, size))
    curve = maugis_dugdale(line, modulus=1.0, work=1e-3 * size, strength=0.37)
    radius = np.sort(size * 10.0 ** np.array(shares))
    for a, width in zip(radius, curve._width(radius), strict=True):
        c = a + width
        angle, root = math.acos(a / c), math.sqrt((c - a) * (c + a))

        def rise(t, a=a, c=c):
            # x = a exp(t), so that the power is smooth from a on, and near c the root is mild
            x = a * math.exp(t)
            return float(line.slope(np.array([x]))[0]) * math.acos(min(x / c, 1.0)) * x

        gap = quad(rise, 0.0, math.log(c / a), epsabs=0.0, epsrel=1e-9, limit=400)[0]
        gap += 2.0 * 0.37 * (root * angle - width)
        assert gap == pytest.approx(0.5 * math.pi * 1e-3 * size / 0.37, rel=1e-7)


def test_zone_integrals_of_singular_profiles():
    for name in ("needle", "truncated", "mixed", "ripple"):
        line = LINES[name]
        for a, c in ((0.0, 0.8), (1e-9, 0.8), (0.3, 0.7), (0.5, 0.500001), (0.49, 1.4)):
            values = zone_integrals(line, np.array([a]), np.array([c - a]), third=True)

            def outside(f, a=a, c=c, line=line):
                marks = [a, *(b for b in line.breakpoints if a < b < c), c]
                return sum(
                    quad(lambda u, lo=lo, hi=hi: f(lo, hi, u), 0, 1, epsabs=0, epsrel=1e-11)[0]
                    for lo, hi in pairwise(np.arccos(np.array(marks) / c)[::-1])
                )

            def first(lo, hi, u, a=a, c=c, line=line):
                psi = hi - (hi - lo) * u * u
                x = np.array(max(c * np.cos(psi), a))
                return float(line.g(x) - line.g(np.array(a))) * 2 * u * (hi - lo)

            def third(lo, hi, u, a=a, c=c, first=first):
                return first(lo, hi, u) * (c * np.sin(hi - (hi - lo) * u * u)) ** 2

            tolerance = 1e-9 if c - a > 1e-3 else 1e-5
            assert float(values[1][0]) == pytest.approx(outside(first), rel=tolerance)
            assert float(values[2][0]) == pytest.approx(outside(third), rel=tolerance)


def test_zone_integrals_do_not_depend_on_their_neighbours():
    r = np.linspace(0.0, 2.0, 21)
    line = equivalent_profile(Sampled(r, 0.5 * r**2 * (1.0 + 0.05 * np.sin(3.0 * r))))
    a = np.linspace(0.0, 1.5, 40)
    width = 0.01 + 0.3 * np.random.default_rng(2).random(40)
    together = zone_integrals(line, a, width, third=True)
    alone = [zone_integrals(line, a[i : i + 1], width[i : i + 1], third=True) for i in range(a.size)]
    np.testing.assert_allclose(together, np.array(alone)[:, :, 0].T, rtol=1e-14)


def test_a_profile_that_is_not_smooth_is_refused():
    noisy = Powers(((2.0, 1.0),))
    object.__setattr__(noisy, "slope", lambda x: 2 * x * (1 + 0.01 * np.sin(1e9 * x)))
    with pytest.raises(ConvergenceError, match="from 100 mm to 600 mm did not converge; declare the kinks"):
        zone_integrals(noisy, np.array([0.1]), np.array([0.5]))


@pytest.mark.parametrize(
    "change", [{"work": 0.0}, {"strength": -1.0}, {"modulus": np.nan}, {"strength": np.inf}]
)
def test_maugis_dugdale_refuses(change):
    values = {"modulus": 1.0, "work": 1.0, "strength": 1.0} | change
    with pytest.raises(ProblemError, match=next(iter(change))):
        maugis_dugdale(paraboloid(), **values)


def test_a_short_profile_is_refused():
    with pytest.raises(ProblemError, match="extend the profile"):
        maugis_dugdale(paraboloid(max_radius=0.1), 1.0, 1.0, 0.5)
    with pytest.raises(ProblemError, match="extend the profile"):
        rigid_pull(paraboloid(max_radius=0.1), 1.0, 0.5)
    law = maugis_dugdale(paraboloid(max_radius=2.0), 1.0, 1.0, 2.0)
    assert float(law.states(law.limit).cohesive_radius) == pytest.approx(2.0, rel=1e-12)


# --- many parameter sets ----------------------------------------------------------------------------------


def test_pull_off_of_many_power_laws():
    rng = np.random.default_rng(3)
    N = 100_000
    n, c, E, gamma = (rng.uniform(*span, N) for span in ((0.8, 6), (0.3, 3), (0.5, 5), (0.1, 2)))
    k = 10.0 ** rng.uniform(-3, 3, N)
    pull_off = power_law_pull_off(n, c, E, gamma, k)
    a = pull_off.contact_radius
    kappa = power_law_factor(n)
    opening = np.sqrt(2 * np.pi * a * gamma / E)
    s = k / (2 * E * a)
    residual = n * kappa * c * a**n / (0.5 * (3 + s) / (1 + s) * opening) - 1
    assert np.max(np.abs(residual)) < 1e-13
    assert np.allclose(pull_off.indentation, kappa * c * a**n - opening, rtol=1e-12, atol=1e-12)
    with pytest.raises(ProblemError, match="above 1/2"):
        power_law_pull_off([2.0, 0.5], 1.0, 1.0, 1.0)
    with pytest.raises(ProblemError, match=r"0\.768"):
        power_law_pull_off(0.6, 1.0, 1.0, 1.0, 2.0)


def jkr_force_long(d, R, E, gamma):
    d, R, E, gamma = (np.asarray(x).astype(LONG) for x in (d, R, E, gamma))
    L = (LONG_PI * gamma * R * R / (8 * E)) ** (LONG(1) / 3)
    delta = d * R / L**2
    y = 1 + np.sqrt(np.maximum(delta + 3, 0))
    for _ in range(100):
        y = y - (y**4 - 4 * y - delta) / np.maximum(4 * y**3 - 4, LONG(1e-60))
    return LONG_PI * gamma * R * (y**6 / 6 - y**3), delta + 3


@pytest.mark.skipif(np.finfo(LONG).eps > 1e-18, reason="no extended precision to hold it against")
@pytest.mark.parametrize("metre", [1.0, 1e-9, 1e3])
def test_jkr_forces_in_closed_form(metre):
    rng = np.random.default_rng(4)
    N = 5000
    R, E, gamma = rng.uniform(0.3, 3, N) * metre, rng.uniform(0.3, 3, N), rng.uniform(0.3, 3, N) * metre
    lowest = -0.75 * (np.pi**2 * gamma**2 * R / E**2) ** (1 / 3)
    d = np.abs(lowest) * np.concatenate(
        [-1 + 10.0 ** rng.uniform(-9, 0, N // 2), rng.uniform(-1, 50, N - N // 2)]
    )
    exact, over = jkr_force_long(d, R, E, gamma)
    error = np.abs(jkr_force(d, R, E, gamma) - exact) / np.maximum(np.abs(exact), np.pi * R * gamma)
    # at the fold F depends on the square root of d: rounding of d comes out as its root
    assert np.max(error * np.minimum(1.0, np.sqrt(over))) < 1e-14
    assert np.max(error[over > 1e-5]) < 1e-12
    assert np.all(jkr_force(lowest * (1 + 1e-12), R, E, gamma) == 0.0)


@pytest.mark.parametrize("n", [0.55, 0.8, 1.0, 1.5, 2.0, 3.0, 10.0, 60.0])
def test_jkr_forces_of_power_laws(n):
    E, gamma, c = 2.0, 0.3, 0.6
    law = JKR(power_law(n, c), E, gamma)
    pull_off = power_law_pull_off(n, c, E, gamma)
    a = pull_off.contact_radius * np.array([1 + 1e-4, 1.001, 1.03, 1.4, 3.0, 1e2 if n < 20 else 4.0])
    states = law.states(a)
    force = jkr_power_law_force(states.indentation, n, c, E, gamma)
    scale = np.maximum(np.abs(states.normal_force), np.abs(pull_off.normal_force))
    fold = np.minimum(1.0, a / pull_off.contact_radius - 1)
    assert np.max(np.abs(force - states.normal_force) / scale * fold) < 1e-12
    below = pull_off.indentation - 1e-6 * abs(pull_off.indentation)
    assert jkr_power_law_force(below, n, c, E, gamma) == 0.0
    if n == 2.0:
        d = np.linspace(float(pull_off.indentation) * 0.999, 9.0, 400)
        ball = jkr_force(d, 1.0 / (2 * c), E, gamma)
        assert np.allclose(jkr_power_law_force(d, 2.0, c, E, gamma), ball, rtol=1e-12, atol=1e-12)


def test_jkr_forces_far_from_adhesion():
    d = np.array([-1.0, 0.0, 1.0, 1e200])
    bare = 4 / 3 * np.array([0.0, 0.0, 1.0, 1e300])
    assert np.allclose(jkr_force(d, 1.0, 1.0, 0.0), bare, rtol=1e-14)
    assert np.allclose(jkr_force(d[2:], 1.0, 1.0, 1e-40), bare[2:], rtol=1e-14)
    assert jkr_force(np.ones((2, 3)), 1.0, np.ones(3), 1.0).shape == (2, 3)
    with pytest.raises(ProblemError, match="above 1/2"):
        jkr_power_law_force(1.0, 0.5, 1.0, 1.0, 1.0)


# --- any profile, any scale -------------------------------------------------------------------------------

profiles = st.lists(st.tuples(st.floats(0.7, 5.0), st.floats(0.05, 2.0)), min_size=1, max_size=3).map(
    lambda terms: Powers(tuple(terms))
)


@settings(max_examples=examples(20), deadline=None)
@given(profiles, st.floats(0.05, 2.0), st.floats(0.1, 20.0))
def test_any_profile(line, gamma, strength):
    law = maugis_dugdale(line, 1.0, gamma, strength)
    s = law.ends[1] + np.array([0.1, 0.5, 1.5])
    states = law.states(s)
    assert np.all(states.cohesive_radius > states.contact_radius)
    gain = np.diff(total_energy(law, s))
    work = [work_by_quadrature(law, lo, hi) for lo, hi in pairwise(s)]
    scale = np.pi * gamma * states.cohesive_radius[1:] ** 2 + np.abs(gain)
    assert np.all(np.abs(gain - work) < 1e-10 * scale)
    jkr = JKR(line, 1.0, gamma)
    gain = np.diff(total_energy(jkr, s))
    work = [work_by_quadrature(jkr, lo, hi) for lo, hi in pairwise(s)]
    assert np.allclose(gain, work, rtol=1e-10, atol=1e-10)


@settings(max_examples=examples(15), deadline=None)
@given(profiles, st.floats(0.05, 2.0), st.sampled_from([1e-9, 3.7e-4, 1.2e3]), st.floats(1e3, 1e12))
def test_any_scale(line, gamma, metre, pascal):
    """Lengths times `metre` and moduli times `pascal` change nothing but the units."""
    scaled = Powers(tuple((n, k * metre ** (1.0 - n)) for n, k in line.terms))
    for make in (
        JKR,
        lambda line, E, work: maugis_dugdale(line, E, work, 1.7 * E),
    ):
        one, other = make(line, 1.0, gamma), make(scaled, pascal, gamma * pascal * metre)
        s = np.array([0.01, 0.4, 1.3])
        a, b = one.states(s), other.states(s * metre)
        for field, unit in (
            ("contact_radius", metre),
            ("cohesive_radius", metre),
            ("indentation", metre),
            ("normal_force", pascal * metre**2),
        ):
            x, y = getattr(a, field), getattr(b, field) / unit
            assert np.max(np.abs(x - y)) < 1e-12 * max(1.0, float(np.max(np.abs(x)))), field
        x, y = total_energy(one, s), total_energy(other, s * metre) / (pascal * metre**3)
        assert np.max(np.abs(x - y)) < 1e-12 * max(1.0, float(np.max(np.abs(x))))


@settings(max_examples=examples(30), deadline=None)
@given(st.floats(1.0, 5.0), st.floats(-9.0, 1.0), st.lists(st.floats(0.01, 0.9), min_size=2, max_size=6))
def test_reading_zones_again_makes_no_calls_of_the_profile(power, decade, shares):
    size, count = 10.0**decade, 0

    def gap(r):
        nonlocal count
        count += 1
        return 0.1 * size * (r / size) ** power

    line = equivalent_profile(Function(gap))
    a = size * np.array([0.0, *shares])
    width = np.full(a.size, 0.1 * size)
    first = zone_integrals(line, a, width, third=True)
    before = count
    np.testing.assert_array_equal(zone_integrals(line, a, width, third=True), first)
    for i in range(1, a.size):
        zone_integrals(line, a[i:], width[i:])
    assert count == before


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_zone_integrals_of_cones_and_paraboloids(power):
    """Closed forms and their series against the quadrature of the same slope."""
    rng = np.random.default_rng(3)
    line = equivalent_profile(PowerLaw(power, 0.1, 1.0))
    quadrature = SimpleNamespace(slope=line.slope, edge=np.inf, max_radius=np.inf, breakpoints=())
    a = np.concatenate([np.zeros(4), 10.0 ** rng.uniform(-9.0, 0.0, 60)])
    width = 10.0 ** rng.uniform(-9.0, 0.0, 64)
    ours, other = (zone_integrals(one, a, width, third=True) for one in (line, quadrature))
    np.testing.assert_allclose(ours, other, rtol=3e-13)


def test_zone_integrals_on_panels():
    """Against the adaptive quadrature of closed forms: a hyperboloid, and powers to the very tip."""
    rng = np.random.default_rng(1)
    for size in (1e-9, 1.0, 1e6):
        a = np.concatenate([np.zeros(4), size * 10.0 ** rng.uniform(-9.0, 0.0, 40)])
        width = size * 10.0 ** rng.uniform(-9.0, 0.0, 44)
        round_tip = Function(
            lambda r, R=size: r * r / (R + np.hypot(R, r)), derivative=lambda r, R=size: r / np.hypot(R, r)
        )
        closed = SimpleNamespace(
            slope=lambda x, R=size: np.arctan(x / R) + x / R / (1.0 + (x / R) ** 2),
            edge=np.inf,
            max_radius=np.inf,
            breakpoints=(),
        )
        sharp = Function(
            lambda r, R=size: r * (r / R) ** 0.5, derivative=lambda r, R=size: 1.5 * (r / R) ** 0.5
        )
        power = SimpleNamespace(
            slope=lambda x, R=size: 1.5 * power_law_factor(1.5) * (x / R) ** 0.5,
            edge=np.inf,
            max_radius=np.inf,
            breakpoints=(),
        )
        for profile, exact in ((round_tip, closed), (sharp, power)):
            ours = zone_integrals(equivalent_profile(profile), a, width, third=True)
            np.testing.assert_allclose(ours, zone_integrals(exact, a, width, third=True), rtol=1e-12)


@settings(max_examples=8, deadline=None)
@given(
    exponent=st.floats(0.8, 6.0),
    flat=st.sampled_from([0.0, 0.3]),
    edge=st.sampled_from([np.inf, 1.0]),
    decades=st.floats(0.01, 1.0),
    seed=st.integers(0, 2**31),
)
def test_many_cohesive_states_are_those_of_few(exponent, flat, edge, decades, seed):
    """Tables, which serve many parameters, against parameters that are asked for in small groups."""
    tip = PowerLaw(exponent, 1.0, 1.0)
    if flat:
        tip = Function(
            lambda r: np.maximum(r - flat, 0.0), derivative=lambda r: 1.0 * (r > flat), breakpoints=(flat,)
        )
    elif edge == 1.0:
        tip = tip + FlatPunch(1.0)
    curve, fresh = (maugis_dugdale(equivalent_profile(tip), 1.0, 0.05, 0.05 / decades) for _ in range(2))
    rng = np.random.default_rng(seed)
    most = min(1.2 * max(curve.ends[3], 3.0) if np.isfinite(curve.ends[3]) else 3.0, curve.limit)
    knots = np.array([k for k in curve.knots if k < most])
    nearby = np.concatenate(
        [knots, (knots[:, None] * (1.0 + 10.0 ** -rng.uniform(1, 12, (knots.size, 4)))).ravel()]
    )
    s = np.sort(
        np.concatenate([rng.uniform(0.0, most, 7000), most * 10.0 ** -rng.uniform(0, 8, 2000), nearby])
    )
    s = s[s < most]
    chosen = np.unique(np.concatenate([np.arange(0, s.size, 97), np.searchsorted(s, nearby[nearby < most])]))
    for name in ("states", "slopes", "energies"):
        many, few = getattr(curve, name)(s), getattr(fresh, name)(s[chosen])
        if name == "states":
            many, few = (tuple(vars(x).values()) for x in (many, few))
        for all_of_them, some in zip(many, few, strict=True):
            # rates have two sides at a knot
            off = ~np.isin(s[chosen], knots)
            size = np.max(np.abs(some[off]))
            assert all_of_them[chosen][off] == pytest.approx(some[off], rel=1e-8, abs=1e-12 * size)
    assert curve._tables
    assert not fresh._tables


def test_a_zone_below_one_rounding_of_the_radius_is_that_of_jkr():
    rng = np.random.default_rng(7)
    flat = 1e-3
    for kind in (Paraboloid, Sphere, lambda radius: TruncatedParaboloid(radius, flat * radius)) * 4:
        radius, modulus, work = 10.0 ** rng.uniform([-9.0, 3.0, -13.0], [0.0, 11.0, -9.0])
        work *= modulus * radius
        size = (work * radius**2 / modulus) ** (1.0 / 3.0)
        strength = 10.0 ** rng.uniform(6.0, 12.0) * (work * modulus**2 / radius) ** (1.0 / 3.0)
        line = equivalent_profile(kind(radius))
        beyond = flat * radius if kind not in (Paraboloid, Sphere) else 0.0
        narrow = maugis_dugdale(line, modulus, work, strength)
        sharp = ShortRange(ElasticLine(line, modulus), work)
        distance = size * np.geomspace(1.2, 3.0, 5)
        a = beyond + distance
        result = narrow.states(narrow.ends[1] + narrow._radii.parameter(a))
        limit = sharp.states(sharp._radii.parameter(a) if beyond else a)
        # the zone of Dugdale (1960) before a square root, K^2 = 2 E* work
        fraction = np.pi * modulus * work / (4.0 * strength**2) / distance
        opening = np.sqrt(2.0 * np.pi * a * work / modulus)
        depth, force = line.g(a) + opening, limit.normal_force + 4.0 * modulus * a * opening
        assert np.all(np.abs(result.indentation - limit.indentation) <= (8.0 * fraction + 1e-13) * depth)
        assert np.all(np.abs(result.normal_force - limit.normal_force) <= (8.0 * fraction + 1e-13) * force)
        if beyond == 0.0:
            rates = zip(narrow.slopes(narrow.ends[1] + a), sharp.slopes(a), strict=True)
            assert all(np.allclose(mine, theirs, rtol=1e-5, atol=0.0) for mine, theirs in rates)


def test_zones_under_samples_take_few_evaluations(monkeypatch):
    # widths that were found were left again for the middle of their bracket: 20 evaluations in place of 6
    calls, whole = [], cohesive_zone.panel_integrals

    def counted(*args, **options):
        calls.append(1)
        return whole(*args, **options)

    r = np.linspace(0.0, 2.0, 401)
    line = equivalent_profile(Sampled(r, 0.5 * r**2 + 1e-3 * np.sin(20.0 * r) ** 2))
    curve = maugis_dugdale(line, 1.0, work=0.05, strength=0.2)
    monkeypatch.setattr(cohesive_zone, "panel_integrals", counted)
    curve.states(curve.contact + np.linspace(0.05, 0.6, 65))
    assert len(calls) <= 10
