"""Tips of callables that are flat, steep, hollow or undefined, against closed forms and extended precision."""

import math

import mpmath as mp
import numpy as np
import pytest

import pymdr as mdr
from pymdr.errors import ProblemError

BODY = mdr.Elastic("1 MPa", 0.3)
MODULUS = 1e6 / (1.0 - 0.09)


def pressed(profile, depth):
    return mdr.solve(mdr.Contact(profile, BODY), mdr.Path(indentation=[depth]))


def power(n, height, length, given):
    def f(r):
        return height * (r / length) ** n

    def slope(r):
        return n * height / length * (r / length) ** (n - 1.0)

    return mdr.Function(f if "f" in given else None, derivative=slope if "d" in given else None)


def check_power(n, length, given):
    height = 1e-3 * length
    computed = pressed(power(n, height, length, given), 0.3 * height)
    exact = pressed(mdr.PowerLaw(exponent=n, height=height, radius=length), 0.3 * height)
    for name in ("normal_force", "contact_radius"):
        claim = computed.claims[name]
        allowed = 10.0 * float(np.max(claim.error)) + 1e-14 * (1.0 + 1.0 / n)
        assert abs(float(computed[name][0]) / float(exact[name][0]) - 1.0) <= allowed
        assert allowed < 1e-10


def test_steep_powers_are_those_of_the_closed_form():
    rng = np.random.default_rng(3)
    for given in ("fd", "d", "fd"):
        check_power(rng.uniform(20.0, 150.0), 10.0 ** rng.uniform(-9.0, 0.0), given)


@pytest.mark.long
def test_flat_powers_are_those_of_the_closed_form():
    rng = np.random.default_rng(4)
    for given in ("fd", "d") * 3:
        check_power(10.0 ** rng.uniform(-2.0, -1.3), 10.0 ** rng.uniform(-9.0, 0.0), given)


@pytest.mark.long
@mp.workdps(30)
def test_a_logarithmic_tip_is_mapped_from_f_and_refused_from_its_slope():
    length, height, depth = 1e-2, 1e-6, 1e-7

    def f(r):
        with np.errstate(divide="ignore"):
            return np.where(r > 0.0, height / np.log(length / r), 0.0)

    def slope(r):
        return height / (r * np.log(length / r) ** 2)

    def g(x):
        at = mp.log(length / x)
        rest = mp.quad(
            lambda y: height / (at - y) ** 2 * (1 / mp.sqrt(1 - mp.e ** (2 * y)) - 1),
            [-40, -10, -3, -1, -0.1, 0],
        )
        return height / at + rest

    a = mp.findroot(lambda x: g(x) - depth, (2.4e-7, 2.5e-7))
    at = mp.log(length / a)
    moment = mp.quad(
        lambda y: height / (at - y) ** 2 * mp.e ** (2 * y) / mp.sqrt(1 - mp.e ** (2 * y)),
        [-40, -10, -3, -1, -0.1, 0],
    )
    result = pressed(mdr.Function(f, derivative=slope, max_radius=5e-3), depth)
    assert math.isclose(float(result["normal_force"][0]), 2.0 * MODULUS * float(a * moment), rel_tol=1e-11)
    with pytest.raises(ProblemError, match=r"too flat: f ~ r\^n, n = 0\.0.*limit 1e-06"):
        pressed(mdr.Function(derivative=slope, max_radius=5e-3), depth)


def test_a_tip_that_underflows_is_served():
    rng = np.random.default_rng(5)
    length = 10.0 ** rng.uniform(-9.0, 0.0)
    height, depth = length * 10.0 ** rng.uniform([-4.0, -6.0], [-2.0, -5.0])

    def slope(r):
        return height * length / r**2 * np.exp(-length / r)

    result = pressed(mdr.Function(derivative=slope), depth)
    a = float(result["contact_radius"][0])

    def rate(t):
        r = a * mp.sin(t)
        return a * height * length / r**2 * mp.e ** (-length / r)

    g = mp.quad(rate, [0.01, 0.1, 0.3, 1, mp.pi / 2])
    assert math.isclose(float(g), depth, rel_tol=1e-11)


def test_a_faintly_hollow_cone_is_passed_over():
    rng = np.random.default_rng(6)
    radius = 10.0 ** rng.uniform(-8.0, 0.0)
    depth, fraction = radius * 10.0 ** rng.uniform(-4.0, -2.0), 10.0 ** rng.uniform(-19.0, -14.0)
    rise = depth / radius**2
    hollow = math.sqrt(4.0 * rise * depth * fraction)
    profile = mdr.Function(lambda r: rise * r**2 - hollow * r, derivative=lambda r: 2.0 * rise * r - hollow)
    computed = pressed(profile, depth)
    exact = pressed(mdr.Paraboloid(0.5 / rise), depth)
    difference = float(computed["normal_force"][0]) / float(exact["normal_force"][0]) - 1.0
    assert abs(difference) < 10.0 * math.sqrt(fraction) + 1e-13


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        (lambda: mdr.Function(np.square, breakpoints=[1e-300]), "breakpoints"),
        (lambda: mdr.Function(np.square, breakpoints=[1e-200]), "breakpoints"),
        (lambda: mdr.Function(lambda r: np.where(r > 0.0, np.nan, 0.0)), "is not finite"),
        (lambda: mdr.Function(lambda r: np.where(r > 0.0, np.inf, 0.0)), "is not finite"),
        (lambda: mdr.Function(derivative=lambda r: r * np.nan), "is not finite"),
        (
            lambda: mdr.Function(lambda r: np.where(r > 0.0, np.nan, 0.0), derivative=lambda r: r),
            "returns nan",
        ),
        (lambda: mdr.Function(derivative=lambda r: 1e-6 / r, max_radius=1e-3), "rises within"),
        (lambda: mdr.Function(lambda r: np.ma.masked_greater(r**2, -1.0)), "returns nan"),
    ],
)
def test_what_is_not_defined_is_refused_in_words(profile, words):
    with pytest.raises(ProblemError, match=words):
        pressed(profile(), 1e-7)


@pytest.mark.long
def test_a_million_even_samples_are_mapped_as_fewer():
    r = np.linspace(0.0, 1e-3, 1_000_000)
    computed = pressed(mdr.Sampled(r, r**2 / 2e-3), 1e-4)
    exact = pressed(mdr.Paraboloid(1e-3), 1e-4)
    error = 10.0 * float(np.max(computed.claims["normal_force"].error))
    assert abs(float(computed["normal_force"][0]) / float(exact["normal_force"][0]) - 1.0) <= error < 1e-8
