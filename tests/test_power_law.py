"""Contacts whose modulus is a power of time, against the exact kernel; sudden loads on bodies that answer no step at once."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from tests.reference.fractional import Power, approach_and_retreat, ramp_force, springs

import pymdr as mdr
from drawing import examples
from pymdr.errors import PathError
from pymdr.interpretation.validity import Level
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import follow_loads, follow_springs, follow_travels
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import largest_coupling
from pymdr.problem.spectra import Relaxation

EXACT = 1e-9


def ball_on(rheology, radius):
    return mdr.Contact(mdr.Paraboloid(radius), mdr.Viscoelastic(rheology, poisson=0.5))


def random_law(rng):
    modulus, time = 10.0 ** rng.uniform(2, 9), 10.0 ** rng.uniform(-6, 6)
    exponent = rng.uniform(0.05, 0.95)
    return mdr.PowerLawRheology(modulus, time, exponent), Power(modulus, time, exponent)


def is_exact(result, name):
    claim = result.claims[name]
    return claim.level is Level.EXACT and 0.0 <= np.max(claim.error) <= EXACT


@pytest.mark.parametrize("exponent", [0.05, 0.6, 0.95])
def test_one_speed_gives_the_closed_form_in_any_number_of_rows(exponent):
    ball = ball_on(mdr.PowerLawRheology("1 kPa", "1 s", exponent), 1e-3)
    for steps in (1, 7):
        result = mdr.solve(ball, mdr.indent("1 um", duration=10.0, steps=steps))
        time = result["time"].values
        truth = [ramp_force(Power(1e3, 1.0, exponent), 1e-3, 1e-7, t) for t in time]
        np.testing.assert_allclose(result["normal_force"].values, truth, rtol=1e-10)
        assert is_exact(result, "normal_force")
        assert np.max(result.claims["normal_force"].error) > 0.0


@pytest.mark.parametrize("seed", range(2))
def test_growing_contacts_over_twelve_decades(seed):
    rng = np.random.default_rng(seed)
    law, kernel = random_law(rng)
    radius, rows = 10.0 ** rng.uniform(-8, 0), 6
    time = np.cumsum(10.0 ** rng.uniform(-6, 6, rows))
    depth = np.cumsum(rng.uniform(0.0, 1.0, rows) * (rng.random(rows) < 0.8)) * 1e-3 * radius + 1e-5 * radius
    result = mdr.solve(ball_on(law, radius), mdr.Path(time=time, indentation=depth))
    with mpmath.workdps(40):
        t = [mpmath.mpf(0), *map(mpmath.mpf, time.tolist())]
        d = [mpmath.mpf(0), *map(mpmath.mpf, depth.tolist())]
        speed = [(d[i + 1] - d[i]) / (t[i + 1] - t[i]) for i in range(rows)]
        b, truth = 1 - mpmath.mpf(kernel.exponent), []
        for n in range(1, rows + 1):
            force = mpmath.mpf(0)
            for i in range(n):
                if speed[i] > 0:
                    zero = t[i] - d[i] / speed[i]
                    whole = t[n] - zero
                    fraction = mpmath.betainc(1.5, b, (t[i] - zero) / whole, (t[i + 1] - zero) / whole)
                    force += 2 * speed[i] ** 1.5 * whole ** (b + 0.5) * fraction
            truth.append(float(kernel.scale * mpmath.sqrt(radius) * force))
    np.testing.assert_allclose(result["normal_force"].values, truth, rtol=1e-6, atol=EXACT * max(truth))
    assert is_exact(result, "normal_force")


@pytest.mark.parametrize("seed", range(2))
def test_one_approach_and_one_retreat(seed):
    rng = np.random.default_rng(seed)
    law, kernel = random_law(rng)
    radius = 10.0 ** rng.uniform(-8, 0)
    up, down = np.cumsum(rng.uniform(0.1, 1.0, 3)), rng.uniform(0.2, 1.0, 1)
    depth = np.concatenate([up, up[-1:], up[-1] - up[-1] * down]) * 1e-3 * radius  # with a hold
    time = np.cumsum(rng.uniform(0.2, 1.0, depth.size)) * 10.0 ** rng.uniform(-6, 6)
    result = mdr.solve(ball_on(law, radius), mdr.Path(time=time, indentation=depth))
    force, contact = approach_and_retreat(kernel, radius, time, depth)
    np.testing.assert_allclose(result["normal_force"].values, force, rtol=0.0, atol=EXACT * force.max())
    np.testing.assert_allclose(result["contact_radius"].values, contact, rtol=0.0, atol=EXACT * contact.max())
    assert is_exact(result, "normal_force")


@pytest.mark.parametrize("seed", range(2))
def test_creep_under_a_sudden_load(seed):
    """F0(d) = F J(t) from the first row on, with J(t) = sin(pi b)/(pi b) (t/t1)^b / G1; nothing at the time of the load."""
    rng = np.random.default_rng(seed)
    law, _ = random_law(rng)
    radius = 10.0 ** rng.uniform(-8, 0)
    time = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-2, 2, 4))])
    force = law.modulus * (time[-1] / law.time) ** -law.exponent * radius**2 * 1e-3
    result = mdr.solve(ball_on(law, radius), mdr.Path(time=time, normal_force=np.full(5, force)))
    truth = (3.0 * force * law.creep(time) / (16.0 * math.sqrt(radius))) ** (2.0 / 3.0)
    # the row at 0 is where a term of 1e-24 of the shortest row has gone
    np.testing.assert_allclose(result["indentation"].values, truth, rtol=EXACT, atol=1e-10 * truth[1])
    assert is_exact(result, "indentation")


def test_the_error_of_a_series_is_that_of_its_modulus_its_impulse_and_its_creep():
    for exponent in (0.01, 0.05, 0.5, 0.95, 0.99):
        law = mdr.PowerLawRheology("1 kPa", "1 s", exponent)
        kernel = law.kernel((1e-3, 1e3))
        t = np.geomspace(1e-3, 1e3, 57)
        impulse = -np.expm1(-t[:, None] / kernel.times) @ (kernel.moduli * kernel.times)
        exact = 1e3 * t ** (1.0 - exponent) / (1.0 - exponent)
        np.testing.assert_allclose(impulse, exact, rtol=kernel.error)
        np.testing.assert_allclose(kernel(t), law.relaxation(t), rtol=kernel.error)
        np.testing.assert_allclose(kernel.retardation(t), law.creep(t), rtol=kernel.error)
        assert kernel.error <= EXACT


@pytest.mark.long
@pytest.mark.parametrize("forced", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_any_path_against_springs_with_the_exact_kernel(seed, forced):
    rng = np.random.default_rng(seed)
    law, kernel = random_law(rng)
    radius, rows = 10.0 ** rng.uniform(-8, 0), 6
    time = np.cumsum(rng.uniform(0.1, 1.0, rows)) * 10.0 ** rng.uniform(-6, 6)
    target = rng.uniform(0.1, 1.0, rows) * (rng.random(rows) < 0.8)  # with parting and re-contact
    target[0] += 0.1
    size = 1e-3 * radius
    channel, answer = ("normal_force", "indentation") if forced else ("indentation", "normal_force")
    target *= kernel(time[-1]) * size**1.5 * radius**0.5 if forced else size
    result = mdr.solve(ball_on(law, radius), mdr.Path(time=time, **{channel: target}))
    deepest = 1.1 * float(result["indentation"].max())
    coarse, fine = (
        springs(kernel, radius, time, target, forced=forced, deepest=deepest, n=n, parts=parts)[not forced]
        for n, parts in ((100, 12), (200, 24))
    )
    # the reference errs as the first power of its steps
    scale, own = np.max(np.abs(fine)), np.max(np.abs(fine - coarse))
    claimed = scale * float(np.max(result.claims[answer].error))
    np.testing.assert_allclose(result[answer].values, fine, rtol=0.0, atol=1.5 * own + claimed)
    assert own < 0.1 * scale


# --- sudden loads ----------------------------------------------------------------------------------------

DASHPOT = mdr.KelvinVoigt("1 kPa", "1 kPa*s")


def test_the_textbook_creep_of_a_dashpot():
    time = np.arange(4.0)
    result = mdr.solve(ball_on(DASHPOT, 1e-3), mdr.Path(time=time, normal_force=np.full(4, 1e-6)))
    truth = (3e-6 * DASHPOT.creep(time) / (16.0 * math.sqrt(1e-3))) ** (2.0 / 3.0)
    np.testing.assert_allclose(result["indentation"].values, truth, rtol=EXACT)
    assert result["indentation"].values[0] == 0.0
    assert is_exact(result, "indentation")


@pytest.mark.parametrize("channel", [{"normal_force": [1e-6]}, {"travel": [1e-6]}])
def test_a_sudden_load_alone_moves_no_dashpot(channel):
    machine = {"machine_stiffness": 0.1} if "travel" in channel else {}
    result = mdr.solve(ball_on(DASHPOT, 1e-3), mdr.Path(time=[0.0], **channel), **machine)
    assert result["indentation"].values[0] == result["contact_radius"].values[0] == 0.0
    assert result["normal_force"].values[0] == (0.1 * 1e-6 if machine else 1e-6)


def test_a_sudden_travel_relaxes_onto_the_spring():
    """At once all of it bends the machine; in the end spring and machine share it."""
    path = mdr.Path(time=[0.0, 1.0, 1e3], travel=[1e-6] * 3)
    result = mdr.solve(ball_on(DASHPOT, 1e-3), path, machine_stiffness=0.1)
    d, force = result["indentation"].values, result["normal_force"].values
    np.testing.assert_allclose(d + force / 0.1, 1e-6, rtol=1e-12)
    assert force[-1] == pytest.approx(16.0 / 3.0 * 1e3 * math.sqrt(1e-3) * d[-1] ** 1.5, rel=1e-5)


@pytest.mark.parametrize("law", [DASHPOT, mdr.PowerLawRheology("1 kPa", "1 s", 0.3)])
def test_a_sudden_indentation_would_need_an_infinite_force(law):
    with pytest.raises(PathError, match=r"row 0 moves the indentation from 0 m to 1 µm in zero time"):
        mdr.solve(ball_on(law, 1e-3), mdr.Path(time=[0.0, 1.0], indentation=[1e-6, 1e-6]))


@pytest.mark.parametrize("machine", [0.0, 0.1])
@pytest.mark.parametrize("branch", [[], [3.0]])
def test_sudden_rises_and_falls_are_the_limit_of_short_ones(branch, machine):
    line = ElasticLine(equivalent_profile(mdr.Paraboloid(1.0)), 1.0)
    body = Relaxation(4.0, np.array(branch), np.full(len(branch), 0.3), viscosity=2.0)
    time = np.array([0.0, 0.0, 0.5, 1.0, 1.0, 1.5, 2.0, 2.0, 3.0])
    force = 1e-3 * np.array([0.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0, 1.0])
    short = time + np.array([0.0, 1e-9, 0.0, 0.0, 1e-9, 0.0, 0.0, 1e-9, 0.0])

    def followed(at):
        if machine == 0.0:
            return follow_loads(line, body, at, force)
        return follow_travels(line, body, at, force / machine, machine)

    result, limit = followed(time), followed(short)
    for name, within in (
        ("indentation", 1e-5),
        ("force", 1e-4),
        ("contact_radius", 3e-3),
        ("dissipated", 1e-4),
    ):
        values, others = getattr(result, name), getattr(limit, name)
        np.testing.assert_allclose(values, others, rtol=0.0, atol=within * np.max(others))
    assert result.indentation[3] == result.indentation[4]


def test_coupling_is_that_of_the_times_of_the_path():
    def body(power):
        return mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", power), bulk="20 MPa")

    for power, span in ((0.2, (1e-3, 1.0)), (0.5, (1e-2, 10.0)), (0.8, (0.1, 1.0))):
        # Carson transform of G1 (t/t1)^-alpha: G1 Gamma(1 - alpha) (s t1)^alpha; the slowest rate is the softest
        shear = 1e6 * math.gamma(1.0 - power) * (0.1 / span[1]) ** power
        assert shear < 20e6
        ratio = shear / 20e6
        nu = (3.0 - 2.0 * ratio) / (6.0 + 2.0 * ratio)
        stiff = 1e6 * math.gamma(1.0 - power) * (10.0 / span[0]) ** power / 20e6
        fast = (3.0 - 2.0 * stiff) / (6.0 + 2.0 * stiff)
        expected = max(abs(1.0 - 2.0 * x) / (2.0 * (1.0 - x)) for x in (nu, fast))
        assert largest_coupling(body(power), mdr.Rigid(), span) == pytest.approx(expected, rel=1e-6)


def test_touching_springs_take_no_energy_that_was_not_supplied():
    # branches relax in 1e-30 s and are 1e28 times as stiff: touched by a rounding too late, they took up to 1 % of the work
    rng = np.random.default_rng(20)
    for shape in (mdr.Paraboloid(1.0), mdr.TruncatedSphere(1.0, 0.1), mdr.Cone(slope=0.1)) * 4:
        rheology, _ = random_law(rng)
        time = np.append(0.0, np.cumsum(10.0 ** rng.uniform(-6, 1, size=6))) * rheology.time
        depth = np.append(0.0, rng.uniform(0.1, 2.0, size=6)) * 1e-3
        body = mdr.Viscoelastic(rheology, poisson=0.5)
        series = mdr.relaxation_of(body, span=(np.diff(time).min(), time[-1]))
        line = ElasticLine(equivalent_profile(shape), 1.0)
        rows = follow_springs(line, series, time, depth, n=40)
        balance = rows.work - rows.stored - rows.dissipated
        assert balance == pytest.approx(np.zeros(7), abs=1e-12 * rows.dissipated.max()), rheology


@pytest.mark.parametrize("friction", [None, mdr.Coulomb(0.3)])
def test_a_leg_without_times_is_refused_as_for_other_bodies_with_memory(friction):
    power = mdr.PowerLawRheology(modulus="1 kPa", time="1 s", exponent=0.3)
    contact = mdr.Contact(mdr.Sphere("1 mm"), mdr.Viscoelastic(power, poisson=0.5), friction=friction)
    with pytest.raises(mdr.PathError, match="give every leg a duration or a rate"):
        mdr.solve(contact, mdr.indent("10 um", steps=10))


def test_no_effective_modulus_of_a_load_in_no_time():
    body = mdr.PowerLawRheology("1 kPa", "1 s", 0.3)
    result = mdr.solve(ball_on(body, 1.0), mdr.Path(time=[0.0, 1.0], normal_force=[1.0, 1.0]))
    assert result["indentation"].values[0] == result["contact_radius"].values[0] == 0.0
    for name in ("effective_modulus", "mean_pressure"):
        assert result.claims[name].where.tolist() == [False, True]
        assert "in zero time" in result.claims[name].reason


@pytest.mark.parametrize(
    ("machine", "rubbing"),
    [(None, False), *(pytest.param(*case, marks=pytest.mark.long) for case in [(None, True), (10.0, False)])],
)
@settings(max_examples=examples(2), deadline=None, phases=[Phase.explicit, Phase.generate])
@given(
    exponent=st.floats(0.03, 0.9),
    shape=st.sampled_from([mdr.Paraboloid(1.0), mdr.Cone(slope=0.1), mdr.FlatPunch(0.01)]),
    elastic=st.booleans(),
)
def test_a_sudden_load_on_a_power_of_time_is_borne_without_indentation(
    machine, rubbing, exponent, shape, elastic
):
    """Its modulus is infinite at once; where the series of exponentials ends was given as an effective modulus."""
    body = mdr.Viscoelastic(mdr.PowerLawRheology("1 kPa", "1 s", exponent), 0.5)
    other = mdr.Elastic("1 MPa", 0.5) if elastic else mdr.Rigid()
    friction = {"friction": mdr.Coulomb(0.3)} if rubbing else {}
    channel = {"normal_force": [1e-6] * 3} if machine is None else {"travel": [1e-6] * 3}
    path = mdr.Path(time=[0.0, 0.5, 2.0], **channel)
    result = mdr.solve(mdr.Contact(shape, body, other, **friction), path, machine_stiffness=machine)
    where = result.claims["effective_modulus"].where.tolist()
    if elastic:  # which answers the load at once
        assert where == [True] * 3
        assert result["indentation"].values[0] > 0.0
        return
    assert where == [False, True, True]
    assert "in zero time" in result.claims["effective_modulus"].reason
    assert np.isnan(result["effective_modulus"].values[0])
    for name in ("indentation", "elastic_energy", "dissipated_energy"):
        assert result[name].values[0] == 0.0
    flat = isinstance(shape, mdr.FlatPunch)
    assert result["contact_radius"].values[0] == (0.01 if flat else 0.0)
    assert result.claims["mean_pressure"].where.tolist() == [flat, True, True]
    if machine is not None:
        assert result["normal_force"].values[0] == pytest.approx(machine * 1e-6, rel=1e-9)
