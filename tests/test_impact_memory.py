"""Impacts of bodies with memory against closed forms, other equations of motion, springs, limits and conservation laws."""

import json
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import pymdr as mdr
from drawing import examples
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import follow_springs
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import relaxation_of

HERTZ = 2.943275184324705


def on(shear, profile=None, **bulk):
    """A profile on a body that keeps its volume, unless its bulk modulus is given; in units in which the rest is 1."""
    return mdr.Contact(
        mdr.Paraboloid(1.0) if profile is None else profile,
        mdr.Viscoelastic(shear, **(bulk or {"poisson": 0.5})),
    )


def hit_on(shear, profile=None, mass=1.0, speed=1.0, steps=8, **bulk):
    return mdr.impact(on(shear, profile, **bulk), mass=mass, speed=speed, steps=steps)


# --- closed forms -------------------------------------------------------------------------------------------

KELVIN_VOIGT = {0.01: 0.9671133808, 0.05: 0.8517007199, 0.1: 0.7362165934, 0.3: 0.4565759764}


@pytest.mark.parametrize("eta", KELVIN_VOIGT)
def test_kelvin_voigt(references, eta):
    hit = hit_on(mdr.KelvinVoigt(1.0, eta))
    assert hit.restitution == pytest.approx(KELVIN_VOIGT[eta], rel=2e-10)
    if f"kv_impact_eta{eta}" in references:
        expected = references[f"kv_impact_eta{eta}"]["expected"]
        assert hit.restitution == pytest.approx(expected["e"], rel=1e-10)
        assert hit.largest_indentation == pytest.approx(expected["d_max"], rel=1e-10)
        assert hit.contact_time == pytest.approx(expected["T"], rel=1e-9)
    assert hit.claims["restitution"].level is mdr.Level.EXACT
    assert hit.largest_pressure == math.inf  # a dashpot bears at the edge


def kelvin_voigt(eta):
    """The law of Willert, Kusche and Popov for m = R = G = v = 1: the edge is at d on the approach, at d + tau d' after it."""

    def approach(t, y):
        d, v = max(y[0], 0.0), y[1]
        a = math.sqrt(d)
        return [v, -8.0 * (2.0 / 3.0 * d * a + eta * v * a)]

    def retreat(t, y):
        d, v = y
        return [v, -16.0 / 3.0 * max(d + eta * v, 0.0) ** 1.5]

    def turned(t, y):
        return y[1]

    def parted(t, y):
        return y[0] + eta * y[1]

    turned.terminal = parted.terminal = True
    parted.direction = -1.0
    scale = {"method": "LSODA", "rtol": 1e-11}
    rise = solve_ivp(approach, (0.0, 100.0), [0.0, 1.0], events=turned, atol=1e-15, **scale)
    deep = rise.y[0, -1]
    fall = solve_ivp(retreat, (0.0, 1e3), [deep, 0.0], events=parted, atol=1e-16, **scale)
    return -fall.y[1, -1], rise.t[-1] + fall.t[-1], deep


@pytest.mark.parametrize("eta", [1e-4, 3e-3, 0.2, 1.0, 4.0, 20.0])
def test_kelvin_voigt_up_to_heavy_damping(eta):
    e, time, deep = kelvin_voigt(eta)
    hit = hit_on(mdr.KelvinVoigt(1.0, eta))
    assert hit.restitution == pytest.approx(e, rel=1e-7)
    assert hit.contact_time == pytest.approx(time, rel=1e-6)
    assert hit.largest_indentation == pytest.approx(deep, rel=1e-8)


def test_a_thousandth_comes_back():
    eta = brentq(lambda eta: math.log(kelvin_voigt(eta)[0] / 1e-3), 1.0, 100.0, rtol=1e-9)
    assert hit_on(mdr.KelvinVoigt(1.0, eta)).restitution == pytest.approx(1e-3, rel=1e-6)


def flat_bounce(equilibrium, moduli, times, stiffness, mass):
    """Restitution and contact time of a flat punch, whose force is linear: the matrix exponential of its motion."""
    n = len(moduli)
    matrix = np.zeros((n + 2, n + 2))
    matrix[0, 1] = 1.0
    matrix[1, 0] = -stiffness * equilibrium / mass
    matrix[1, 2:] = -stiffness / mass
    matrix[2:, 1] = moduli
    matrix[2:, 2:] = -np.diag(1.0 / np.array(times))
    begin = np.zeros(n + 2)
    begin[1] = 1.0

    def at(t):
        return expm(matrix * t) @ begin

    def force(t):
        return -(matrix @ at(t))[1]

    step = 0.01 * math.sqrt(mass / stiffness / (equilibrium + sum(moduli)))
    t = step
    while force(t + step) > 0.0:
        t += step
    time = brentq(force, t, t + step, xtol=1e-15)
    return -at(time)[1], time


@settings(deadline=None, max_examples=examples(25))
@given(
    equilibrium=st.floats(0.1, 2.0),
    moduli=st.lists(st.floats(0.1, 3.0), min_size=1, max_size=3),
    first=st.floats(-3.0, 1.0),
    mass=st.floats(0.1, 10.0),
)
def test_flat_punches_are_linear(equilibrium, moduli, first, mass):
    times = [10.0 ** (first + 0.7 * i) for i in range(len(moduli))]
    hit = hit_on(mdr.Prony(equilibrium, moduli, times), mdr.FlatPunch(0.5), mass=mass)
    e, time = flat_bounce(4 * equilibrium, [4 * m for m in moduli], times, 1.0, mass)
    assert hit.restitution == pytest.approx(e, rel=1e-9)
    assert hit.contact_time == pytest.approx(time, rel=1e-9)
    assert hit.largest_pressure == math.inf


@settings(deadline=None, max_examples=examples(15))
@given(slow=st.floats(1.0, 7.0), own=st.floats(0.1, 3.0))
def test_errors_hold_a_small_loss_of_energy(slow, own):
    tau = 10.0**slow
    hit = hit_on(mdr.Prony(1.0, [own], [tau]), mdr.FlatPunch(0.5))
    with mpmath.workdps(50):
        matrix = mpmath.matrix([[0, 1, 0], [-4, 0, -1], [0, 4 * mpmath.mpf(own), -1 / mpmath.mpf(tau)]])

        def at(t):
            return mpmath.expm(matrix * t) * mpmath.matrix([0, 1, 0])

        back = -at(mpmath.findroot(lambda t: (matrix * at(t))[1], hit.contact_time))[1]
        dissipated = float((1 - back**2) / 2)
    claim = hit.claims["energy_lost"]
    assert 1.0 - float(back) > 0.0
    assert abs(hit.energy_lost / dissipated - 1.0) <= 3.0 * claim.error.item()
    assert claim.level is mdr.Level.APPROXIMATE or claim.error.item() <= 1e-9


@pytest.mark.parametrize("b", [0.1, 0.3, 0.5, 0.8])
def test_a_flat_punch_on_a_power_of_time_is_a_fractional_oscillator(b):
    # m d'' = -k int (t - s)^-b dd(s) has the velocity E_(2-b)(-kappa t^(2-b)) of Mittag-Leffler
    hit = hit_on(mdr.PowerLawRheology(0.25, 1.0, b), mdr.FlatPunch(0.5))
    alpha, kappa = 2 - mpmath.mpf(b), mpmath.gamma(1 - mpmath.mpf(b))

    def velocity(t):
        z = kappa * t**alpha
        return mpmath.nsum(lambda k: (-z) ** int(k) / mpmath.gamma(alpha * k + 1), [0, mpmath.inf])

    time = mpmath.findroot(lambda t: mpmath.diff(velocity, t), hit.contact_time)
    assert hit.contact_time == pytest.approx(float(time), rel=1e-7)
    assert hit.restitution == pytest.approx(float(-velocity(time)), rel=1e-8)
    assert "exponentials" in hit.notes[-1]


def test_restitution_on_a_power_of_time_is_the_same_at_every_speed_and_size():
    # no length and no time to compare with, for profiles that are powers themselves
    many = mdr.restitution(
        on(mdr.PowerLawRheology("1 MPa", "1 ms", 0.3)), mass=2.0, speeds=np.geomspace(1e-9, 1e3, 60)
    )
    e = many["restitution"].values
    assert e == pytest.approx(np.full(e.size, e[0]), rel=2e-9)
    small = hit_on(mdr.PowerLawRheology("3 kPa", "1 s", 0.3), mdr.Paraboloid("20 nm"), mass=1e-18, speed=1e-3)
    assert small.restitution == pytest.approx(e[0], rel=2e-9)


def test_the_time_at_which_a_power_is_given_says_nothing():
    one = hit_on(mdr.PowerLawRheology("1 MPa", "1 ms", 0.4), mass=0.1)
    other = hit_on(mdr.PowerLawRheology(1e6 * 1e-12**0.4, 1e9, 0.4), mass=0.1)
    assert one.restitution == pytest.approx(other.restitution, rel=1e-9)
    assert one.contact_time == pytest.approx(other.contact_time, rel=1e-8)


# --- limits -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", [mdr.Paraboloid(1.0), mdr.Cone(slope=0.2), mdr.Sphere(1.0)], ids=str)
@pytest.mark.parametrize(("time", "modulus"), [(1e-11, 1.0), (1e11, 4.0)])
def test_glassy_and_rubbery_limits(profile, time, modulus):
    mass, speed = 0.01, 0.3
    hit = hit_on(mdr.StandardSolid(1.0, 3.0, time), profile, mass=mass, speed=speed, steps=40)
    bare = mdr.impact(mdr.Contact(profile, mdr.Elastic(3.0 * modulus, 0.5)), mass=mass, speed=speed, steps=40)
    assert 1.0 - 2e-9 <= hit.restitution <= 1.0
    assert hit.energy_lost >= 0.0
    assert hit.contact_time == pytest.approx(bare.contact_time, rel=1e-9)
    assert hit.largest_indentation == pytest.approx(bare.largest_indentation, rel=1e-9)
    assert hit.largest_force == pytest.approx(bare.largest_force, rel=1e-9)
    assert hit.largest_radius == pytest.approx(bare.largest_radius, rel=1e-9)
    assert hit.largest_pressure == pytest.approx(bare.largest_pressure, rel=5e-3)


def test_hertz():
    hit = hit_on(mdr.StandardSolid(1.0, 3.0, 1e-13))
    assert hit.contact_time / hit.largest_indentation == pytest.approx(HERTZ, rel=1e-10)


def test_one_dashpot_is_a_fast_branch():
    eta, tau = 0.1, 1e-7
    dashpot = hit_on(mdr.KelvinVoigt(1.0, eta))
    branch = hit_on(mdr.StandardSolid(1.0, eta / tau, tau))
    assert branch.restitution == pytest.approx(dashpot.restitution, rel=1e-4)
    assert branch.contact_time == pytest.approx(dashpot.contact_time, rel=1e-4)


def test_two_bodies_in_series():
    rubber = mdr.Viscoelastic(mdr.StandardSolid(1.0, 3.0, 0.3), poisson=0.5)
    alone = mdr.impact(mdr.Contact(mdr.Paraboloid(1.0), rubber), mass=1.0, speed=1.0, steps=8)
    stiff = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1e9, 0.3), rubber)
    assert mdr.impact(stiff, mass=1.0, speed=1.0, steps=8).restitution == pytest.approx(
        alone.restitution, rel=1e-6
    )
    twice = mdr.impact(mdr.Contact(mdr.Paraboloid(1.0), rubber, rubber), mass=0.5, speed=1.0, steps=8)
    assert twice.restitution == pytest.approx(alone.restitution, rel=1e-9)


def test_constant_bulk_modulus():
    shear = mdr.StandardSolid(1.0, 3.0, 0.3)
    assert hit_on(shear, bulk=1e9).restitution == pytest.approx(hit_on(shear).restitution, rel=1e-6)
    assert hit_on(shear, bulk=1.0).restitution > hit_on(shear).restitution


# --- liquids that keep what falls on them -------------------------------------------------------------------


def test_a_viscous_liquid_stops_what_it_does_not_throw_back():
    # m v is what a fluid of the viscosity eta takes: 4 eta F0 = m v
    tau, modulus = 1e-4, 3.0
    hit = hit_on(mdr.Maxwell(modulus, tau))
    deep = (0.75 / (4 * modulus * tau)) ** (2 / 3)
    assert (hit.restitution, hit.contact_time, hit.rebound_speed) == (0.0, math.inf, 0.0)
    assert hit.largest_indentation == pytest.approx(deep, rel=1e-8)
    assert hit.events[-1].name == "rest"
    assert hit.energy_lost == 0.5
    assert hit["dissipated_energy"].values[-1] == pytest.approx(0.5, rel=1e-3)
    assert "comes to rest" in hit.notes[-1]


@settings(deadline=None, max_examples=examples(15))
@given(fast=st.floats(-6.0, -2.0), n=st.floats(0.3, 10.0))
@example(fast=-3.0, n=0.3)
def test_a_liquid_takes_all_that_the_mass_had(fast, n):
    """Kinetic energy, that of the springs and that of the dashpots at any row, also where parts of steps outlast the memory."""
    tau = 10.0**fast
    hit = hit_on(mdr.Maxwell(1.0 / tau, tau), mdr.PowerLaw(n, 0.3, 1.0), steps=40)
    assert hit.restitution == 0.0
    whole = 0.5 * hit["velocity"].values ** 2 + hit["elastic_energy"].values + hit["dissipated_energy"].values
    assert np.max(np.abs(whole / 0.5 - 1.0)) < 1e-4


@pytest.mark.parametrize("fraction", [0.9, 0.99, 1.01])
def test_a_flat_punch_rests_on_maxwells_liquid_from_the_critical_mass_on(fraction):
    # the roots of m s^2 + m s / tau + k turn real where m = 4 k tau^2
    stiffness, tau = 4.0, 0.25
    mass = fraction * 4 * stiffness * tau**2
    hit = hit_on(mdr.Maxwell(1.0, tau), mdr.FlatPunch(0.5), mass=mass)
    assert next(a for a in hit.assumptions if a.name == "energy balance").met
    if fraction > 1.0:
        assert (hit.restitution, hit.contact_time) == (0.0, math.inf)
    else:
        e, time = flat_bounce(0.0, [stiffness], [tau], 1.0, mass)
        assert hit.contact_time == pytest.approx(time, rel=1e-6)
        assert hit.restitution == pytest.approx(e, rel=1e-6, abs=1e-12)


@settings(deadline=None, max_examples=examples(12))
@given(
    law=st.sampled_from([mdr.StandardSolid(1.0, 3.0, 0.3), mdr.KelvinVoigt(1.0, 0.2), mdr.Maxwell(1.0, 2.0)]),
    profile=st.sampled_from([mdr.FlatPunch(1.0), mdr.TruncatedCone(1.0, slope=1.0), mdr.Paraboloid(1.0)]),
    mass=st.floats(-3.0, 2.0),
)
def test_the_last_row_of_a_rebound_is_of_bodies_that_have_parted(law, profile, mass):
    """Rounding of the time at which they part left a flat end all of its radius, or none."""
    hit = hit_on(law, profile, mass=10.0**mass)
    radius, force = hit["contact_radius"].values, hit["normal_force"].values
    if hit.rebound_speed > 0.0:
        assert (radius[-1], force[-1]) == (0.0, 0.0)
        assert radius[-2] > 0.0
    else:
        assert radius[-1] > 0.0


# --- springs ------------------------------------------------------------------------------------------------


def bounced(relaxation, height, fraction, mass, speed, step):
    """Verlet with springs in numpy, whose branches are moved exactly, and which part and touch by their trial force."""
    w, h = np.zeros(height.size), np.zeros((height.size, relaxation.moduli.size))
    x = step / relaxation.times
    decay, mean = np.exp(-x), -np.expm1(-x) / x
    stiff = relaxation.equilibrium + mean @ relaxation.moduli
    d, v, force, t = 0.0, speed, 0.0, 0.0
    deepest = 0.0
    while True:
        before = d, v, force, t
        d += step * v - 0.5 * step**2 * force / mass
        free = w - (relaxation.equilibrium * w + h @ decay) / stiff
        there = np.maximum(d - height, free)
        h = h * decay + (there - w)[:, None] * (mean * relaxation.moduli)
        w = there
        new = float(fraction @ (relaxation.equilibrium * w + h.sum(axis=1)))
        v -= 0.5 * step * (force + new) / mass
        force, t = new, t + step
        deepest = max(deepest, d)
        if force <= 1e-12 and t > 10 * step:
            return -v / speed, before[3], deepest


SERIES = {
    "solid": mdr.StandardSolid(1.0, 3.0, 0.3),
    "fast": mdr.StandardSolid(1.0, 30.0, 0.01),
    "liquid": mdr.Maxwell(3.0, 0.5),
    "two": mdr.Prony(0.5, [1.0, 2.0], [0.05, 1.0]),
}
PROFILES = {
    "paraboloid": mdr.Paraboloid(1.0),
    "cone": mdr.Cone(slope=0.5),
    "quartic": mdr.PowerLaw(4, 0.5, 1.0),
    "truncated": mdr.TruncatedCone(slope=0.5, flat_radius=0.2),
    "sum": mdr.Paraboloid(2.0) + mdr.PowerLaw(4, 0.2, 1.0),
}


@pytest.mark.parametrize("shape", PROFILES)
@pytest.mark.parametrize("series", SERIES)
def test_against_springs(series, shape):
    contact = on(SERIES[series], PROFILES[shape])
    hit = mdr.impact(contact, mass=0.1, speed=0.3, steps=8)
    ends = hit.largest_radius * 1.001 * (np.arange(401) / 400) ** 1.5
    height = equivalent_profile(contact.profile).g(0.5 * (ends[1:] + ends[:-1]))
    relaxation = relaxation_of(contact.body)
    result = bounced(relaxation, height, 2.0 * np.diff(ends), 0.1, 0.3, hit.contact_time / 4000)
    assert hit.restitution == pytest.approx(result[0], rel=1e-3)
    assert hit.contact_time == pytest.approx(result[1], rel=3e-3)
    assert hit.largest_indentation == pytest.approx(result[2], rel=3e-4)


def test_springs_are_not_touched_again():
    hit = hit_on(mdr.Prony(0.5, [1.0, 4.0], [0.02, 1.0]), steps=400)
    time, depth = hit["time"].values, hit["indentation"].values
    later = time[-1] + np.geomspace(1e-3, 1e3, 400)
    flown = depth[-1] - hit.rebound_speed * (later - time[-1])
    line = ElasticLine(equivalent_profile(mdr.Paraboloid(1.0)), 1.0)
    both = np.concatenate([time[1:], later]), np.concatenate([depth[1:], flown])
    result = follow_springs(line, relaxation_of(hit.contact.body), *both, n=500)
    in_flight = result.force[time.size - 1 :]
    assert np.all(in_flight <= 2e-3 * hit.largest_force)
    assert np.all(in_flight[50:] == 0.0)


def test_histories_are_those_of_a_contact_that_is_moved_so():
    hit = hit_on(mdr.StandardSolid(1.0, 3.0, 0.3), steps=400)
    path = mdr.Path(time=hit["time"].values[1:], indentation=hit["indentation"].values[1:])
    moved = mdr.solve(hit.contact, path)
    assert moved["normal_force"].values == pytest.approx(
        hit["normal_force"].values[1:], abs=2e-4 * hit.largest_force
    )
    assert moved["contact_radius"].values[:-1] == pytest.approx(
        hit["contact_radius"].values[1:-1], abs=1e-2 * hit.largest_radius
    )
    for name in ("elastic_energy", "dissipated_energy"):
        assert moved[name].values == pytest.approx(hit[name].values[1:], abs=1e-3 * 0.5)


# --- what holds for all -------------------------------------------------------------------------------------

exponents = st.floats(0.5, 6.0)
terms = st.lists(st.tuples(st.floats(0.05, 20.0), st.floats(-6.0, 3.0)), min_size=1, max_size=4)


@st.composite
def rheologies(draw):
    kind = draw(st.sampled_from(["prony", "kelvin-voigt", "maxwell", "power"]))
    if kind == "kelvin-voigt":
        return mdr.KelvinVoigt(1.0, 10.0 ** draw(st.floats(-4.0, 1.5)))
    if kind == "maxwell":
        return mdr.Maxwell(1.0, 10.0 ** draw(st.floats(-0.3, 4.0)))
    if kind == "power":
        return mdr.PowerLawRheology(1.0, 1.0, draw(st.floats(0.02, 0.9)))
    result = draw(terms)
    times = [10.0 ** (t + 1e-3 * i) for i, (_, t) in enumerate(result)]
    return mdr.Prony(draw(st.floats(0.1, 2.0)), [m for m, _ in result], times)


@st.composite
def profiles(draw):
    kind = draw(st.sampled_from(["power", "cone", "truncated", "sum"]))
    if kind == "cone":
        return mdr.Cone(slope=draw(st.floats(0.05, 1.0)))
    if kind == "truncated":
        return mdr.TruncatedParaboloid(
            radius=draw(st.floats(0.5, 2.0)), flat_radius=draw(st.floats(0.05, 0.3))
        )
    if kind == "sum":
        return mdr.Paraboloid(draw(st.floats(0.5, 2.0))) + mdr.PowerLaw(4, draw(st.floats(0.05, 1.0)), 1.0)
    return mdr.PowerLaw(draw(exponents), draw(st.floats(0.1, 1.0)), 1.0)


@settings(deadline=None, max_examples=examples(40))
@given(shear=rheologies(), profile=profiles(), mass=st.floats(0.01, 1.0), speed=st.floats(0.05, 1.0))
def test_energy_and_momentum(shear, profile, mass, speed):
    hit = hit_on(shear, profile, mass, speed, steps=200)
    t, v, F, dissipated = (hit[n].values for n in ("time", "velocity", "normal_force", "dissipated_energy"))
    energy = 0.5 * mass * speed**2
    assert 0.0 <= hit.restitution < 1.0
    assert np.all(np.diff(t) > 0.0)
    assert np.all(F >= 0.0)
    assert np.all(np.diff(v) <= 1e-9 * speed)
    assert np.all(np.diff(dissipated) >= -1e-12 * energy)
    assert hit.energy_lost == pytest.approx(energy * (1.0 - hit.restitution**2), rel=1e-12)
    assert hit.energy_lost + 2e-3 * energy >= dissipated[-1] + hit["elastic_energy"].values[-1]
    (audit,) = [a for a in hit.assumptions if a.name == "energy balance"]
    assert audit.met
    assert hit.claims["restitution"].error[0] < 1e-7
    if hit.restitution > 0.0:
        assert v[-1] == pytest.approx(-hit.rebound_speed, rel=1e-12)
        assert F[-1] <= 1e-6 * hit.largest_force
        impulse = np.sum(0.5 * (F[1:] + F[:-1]) * np.diff(t))
        flat = isinstance(profile, mdr.TruncatedParaboloid)
        assert impulse == pytest.approx(mass * (speed + hit.rebound_speed), rel=0.05 if flat else 5e-3)


@settings(deadline=None, max_examples=examples(30))
@given(
    shear=st.tuples(st.floats(0.1, 3.0), st.floats(0.1, 30.0), st.floats(-3.0, 2.0)),
    n=exponents,
    length=st.floats(-9.0, 0.0),
    clock=st.floats(-9.0, 6.0),
    stress=st.floats(-3.0, 12.0),
)
@example(shear=(0.25, 9.5, -2.09375), n=0.5, length=-0.25, clock=0.0, stress=0.0)
def test_units_change_nothing(shear, n, length, clock, stress):
    length, clock, stress = (10.0**x for x in (length, clock, stress))
    one = hit_on(mdr.StandardSolid(shear[0], shear[1], 10.0 ** shear[2]), mdr.PowerLaw(n, 0.2, 1.0))
    solid = mdr.StandardSolid(shear[0] * stress, shear[1] * stress, 10.0 ** shear[2] * clock)
    other = hit_on(
        solid,
        mdr.PowerLaw(n, 0.2 * length, length),
        mass=stress * length * clock**2,
        speed=length / clock,
    )
    assert other.restitution == pytest.approx(one.restitution, rel=1e-9)
    assert other.contact_time == pytest.approx(one.contact_time * clock, rel=1e-9)
    assert other.largest_indentation == pytest.approx(one.largest_indentation * length, rel=1e-9)
    assert other.largest_force == pytest.approx(one.largest_force * stress * length**2, rel=1e-9)


@settings(deadline=None, max_examples=examples(15))
@given(
    kind=st.sampled_from(["kelvin-voigt", "maxwell", "solid", "power"]),
    modulus=st.floats(2.0, 11.0),
    time=st.floats(-15.0, 6.0),
    fraction=st.floats(0.01, 0.99),
    n=st.floats(0.3, 10.0),
    size=st.floats(-9.0, 0.0),
    speed=st.floats(-9.0, 3.0),
)
@example("power", 2.0, 0.0, 0.75, 0.5, 0.0, 0.0)
@example("maxwell", 2.0, 0.0, 0.5, 0.375, -3.0, -9.0)
def test_any_size_at_any_speed(kind, modulus, time, fraction, n, size, speed):
    modulus, time, size, speed = (10.0**x for x in (modulus, time, size, speed))
    shear = {
        "kelvin-voigt": lambda: mdr.KelvinVoigt(modulus, modulus * time),
        "maxwell": lambda: mdr.Maxwell(modulus, time),
        "solid": lambda: mdr.StandardSolid(modulus, modulus * 10.0 ** (8.0 * fraction - 4.0), time),
        "power": lambda: mdr.PowerLawRheology(modulus, time, fraction),
    }[kind]()
    hit = hit_on(shear, mdr.PowerLaw(n, fraction * size, size), mass=2e3 * size**3, speed=speed)
    assert 0.0 <= hit.restitution <= 1.0 + 1e-9
    assert hit.claims["restitution"].error[0] < 1e-8
    assert next(a for a in hit.assumptions if a.name == "energy balance").met


@settings(deadline=None, max_examples=examples(15))
@given(eta=st.floats(-5.0, 5.0), speed=st.floats(-9.0, 3.0), size=st.floats(-8.0, 0.0))
def test_dissipation_grows_with_the_viscosity(eta, speed, size):
    radius = 10.0**size
    arguments = {"mass": 1e3 * radius**3, "speed": 10.0**speed, "steps": 8}
    results = [
        mdr.impact(on(mdr.KelvinVoigt(1e6, 10.0**eta * k), mdr.Paraboloid(radius)), **arguments).restitution
        for k in (1.0, 3.0)
    ]
    assert results[1] <= results[0] * (1.0 + 1e-9) <= 1.0 + 2e-9
    assert results[1] > 0.0


# --- many speeds --------------------------------------------------------------------------------------------

RUBBER = mdr.StandardSolid("1 MPa", "3 MPa", "1 ms")


@pytest.mark.parametrize("shape", ["paraboloid", "truncated", "rounded", "sum"])
@pytest.mark.parametrize("shear", [RUBBER, mdr.KelvinVoigt("1 MPa", "300 Pa*s")], ids=["solid", "fluid"])
def test_many_speeds(shape, shear):
    profile = {
        "paraboloid": mdr.Paraboloid("5 mm"),
        "truncated": mdr.TruncatedCone(slope=0.1, flat_radius="0.1 mm"),
        "rounded": mdr.RoundedCone(slope=0.1, tip_radius="10 mm"),
        "sum": mdr.Paraboloid("10 mm") + mdr.PowerLaw(4, "1 mm", "5 mm"),
    }[shape]
    contact, speeds = on(shear, profile), np.geomspace(1e-6, 1.0, 2000)
    many = mdr.restitution(contact, mass="10 g", speeds=speeds)
    assert many.claims["restitution"].error.max() < 1e-8
    for i in np.random.default_rng(2).integers(0, speeds.size, 4):
        one = mdr.impact(contact, mass="10 g", speed=speeds[i], steps=8)
        for name, value in {
            "restitution": one.restitution,
            "contact_time": one.contact_time,
            "indentation": one.largest_indentation,
            "normal_force": one.largest_force,
            "contact_radius": one.largest_radius,
        }.items():
            assert float(many[name][i]) == pytest.approx(value, rel=5e-9)


def test_speeds_at_some_of_which_bodies_rest():
    contact = on(mdr.Maxwell("1 MPa", "1 ms"), mdr.Paraboloid("5 mm"))
    speeds = np.geomspace(1e-4, 1.0, 300)
    many = mdr.restitution(contact, mass="10 g", speeds=speeds)
    e, time = many["restitution"].values, many["contact_time"].values
    assert np.array_equal(e == 0.0, np.isinf(time))
    assert e[0] == 0.0 < e[-1]
    assert np.all(np.diff(e) >= 0.0)
    i = int(np.argmax(e > 1e-6))
    assert e[i] == pytest.approx(mdr.impact(contact, mass="10 g", speed=speeds[i]).restitution, rel=1e-8)


# --- what is refused, and what is shown ---------------------------------------------------------------------


def test_what_is_refused():
    rubber = mdr.Viscoelastic(RUBBER, poisson=0.5)
    with pytest.raises(mdr.ProblemError, match="no limit of short range"):
        mdr.Contact(mdr.Sphere("1 mm"), rubber, adhesion=mdr.JKR("50 mJ/m^2"))
    rough = mdr.Contact(mdr.Sphere("1 mm"), rubber, friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.ProblemError, match=r"friction \(mu = 0.3\) in impacts of bodies with memory"):
        mdr.impact(rough, mass="1 g", speed="1 m/s", angle="30 deg")
    with pytest.raises(mdr.PathError, match="speed = 100 m/s: the bodies would not come to rest"):
        mdr.impact(mdr.Contact(mdr.Sphere("1 mm"), rubber), mass="1 kg", speed="100 m/s")
    with pytest.raises(mdr.PathError, match="would not come to rest"):
        mdr.restitution(mdr.Contact(mdr.Sphere("1 mm"), rubber), mass="1 kg", speeds=[1e-6, 100.0])
    r = np.linspace(0.0, 1e-3, 60)
    ended = mdr.Contact(mdr.Sampled(r, r**2 / 20e-3), rubber)
    with pytest.raises(mdr.PathError, match="before the profile ends"):
        mdr.impact(ended, mass="1 g", speed="100 m/s")
    assert mdr.impact(ended, mass="1 g", speed="1 cm/s", steps=8).restitution < 1.0
    wavy = mdr.Paraboloid("1 mm") + mdr.Waviness("10 um", "0.1 mm")
    with pytest.raises(mdr.ProblemError, match="the equivalent profile decreases"):
        mdr.impact(mdr.Contact(wavy, rubber), mass="1 mg", speed="0.1 m/s")


@pytest.mark.long
@settings(deadline=None, max_examples=examples(15))
@given(viscosity=st.floats(-3.0, 12.0), mass=st.floats(-12.0, 0.0), size=st.floats(-5.0, -1.0))
@example(viscosity=11.38, mass=-2.88, size=-1.24)
def test_overdamped_impacts_on_edges_end_or_say_why_not(viscosity, mass, size):
    """The rates x of m x^2 - c x + k = 0, c = 8 a eta, k = 8 a G: of a flat punch, and of an edge that is hardly left."""
    a, modulus = 10.0**size, 1e6
    rubber = mdr.Viscoelastic(mdr.KelvinVoigt(modulus, 10.0**viscosity), poisson=0.5)
    slow = modulus / 10.0**viscosity
    fast = 8.0 * a * 10.0**viscosity / 10.0**mass
    assume(fast > 1e3 * slow)
    for profile in (mdr.FlatPunch(a), mdr.TruncatedCone(a, slope=0.3)):
        stuck = ""
        try:
            hit = mdr.impact(mdr.Contact(profile, rubber), mass=10.0**mass, speed=1e-3, steps=8)
        except mdr.errors.ConvergenceError as error:
            stuck = str(error)
        if stuck:
            assert slow < 1e-9 * fast
            assert "the bodies practically stick" in stuck
            continue
        assert 0.0 <= hit.restitution <= 2.0 * slow / fast + 1e-12


@settings(deadline=None, max_examples=examples(15))
@given(
    deep=st.floats(0.02, 0.06),
    at=st.floats(0.3, 0.7),
    time=st.floats(-9.0, 0.0),
    mass=st.floats(-9.0, 0.0),
    speed=st.floats(-3.0, 1.0),
)
def test_hollow_profiles_are_refused_with_the_reason(deep, at, time, mass, speed):
    x = np.linspace(0.0, 1.0, 40)
    hollow = mdr.Sampled(1e-3 * x, 1e-3 * (0.03 * x**2 - deep * np.exp(-(((x - at) / 0.1) ** 2))))
    liquid = mdr.Viscoelastic(mdr.Maxwell("1 MPa", time=10.0**time), poisson=0.5)
    with pytest.raises(mdr.ProblemError, match="below its middle and touches first"):
        mdr.impact(mdr.Contact(hollow, liquid), mass=10.0**mass, speed=10.0**speed)


def test_there_is_no_tangential_motion():
    hit = mdr.impact(
        on(RUBBER, mdr.Sphere("5 mm")), mass="1 g", speed="1 m/s", angle="60 deg", spin="10 rad/s"
    )
    assert hit.tangential_speed == pytest.approx(math.sqrt(0.75), rel=1e-15)
    assert hit.spin == 10.0
    assert hit.rebound_speed == pytest.approx(0.5 * hit.restitution, rel=1e-15)


def test_shown(tmp_path):
    hit = mdr.impact(on(RUBBER, mdr.Paraboloid("5 mm")), mass="10 g", speed="0.3 m/s")
    assert hit.data.sizes["step"] == 201
    text = hit.summary()
    assert "coefficient of restitution" in text
    assert "dissipated energy" in text
    assert "one approach and one retraction" in text
    assert [event.name for event in hit.events] == ["touch", "turning point", "separation"]
    assert hit.events[1].indentation == pytest.approx(float(hit["indentation"].max()), rel=1e-12)
    assert hit.events[-1].indentation > 0.0  # the surface has not come back yet
    assert "<table>" in hit._repr_html_()
    assert len(hit.plot().axes) == 3
    hit.to_csv(tmp_path / "hit.csv")
    assert "dissipated_energy [J]" in (tmp_path / "hit.csv").read_text()
    assert {a.name for a in hit.assumptions} == {"small slope", "half-space", "energy balance"}


def test_from_the_shell(shell):
    case = Path(__file__).parent.parent / "examples" / "rubber_indentation.toml"
    status, out, error = shell("impact", case, "--mass", "10 g", "--speed", "0.3 m/s")
    assert (status, error) == (0, "")
    assert "coefficient of restitution" in out
    status, out, _ = shell("impact", case, "--mass", "10 g", "--speed", "0.3 m/s", "--json")
    data = json.loads(out)
    rubber = on(mdr.StandardSolid("1 MPa", "3 MPa", "50 ms"), mdr.Paraboloid("5 mm"))
    hit = mdr.impact(rubber, mass="10 g", speed="0.3 m/s")
    assert data["impact"]["restitution"]["value"] == hit.restitution
    assert data["impact"]["dissipated_energy"]["unit"] == "J"
