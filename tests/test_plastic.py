"""Balls that yield: against another program, closed forms, quadrature, limits, scaling and energy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.common import references

import pymdr as mdr
from drawing import first_of
from pymdr.line.plastic import Ball, Edge, Ellipse, GrowingBall, follow_edge, start_of_edge, with_growth
from pymdr.workbench.casefile import read_case

COPPER = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
BALL = mdr.Contact(mdr.Sphere("1 mm"), COPPER)
FEW = {"max_examples": 25, "deadline": None}


def reference(topic):
    (entry,) = references(topic)
    return entry["inputs"], entry["expected"]


def ball_of(strength=2e7, modulus=1e9, poisson=0.3, radius=1.0, walled=False):
    return Ball(
        radius, modulus / (1.0 - poisson**2), modulus / 2.0 / (1.0 + poisson), poisson, strength, walled
    )


balls = st.builds(
    ball_of,
    strength=st.floats(-3.0, -1.2).map(lambda x: 70e9 * 10**x),
    modulus=st.just(70e9),
    poisson=st.floats(-0.5, 0.5),
    radius=st.floats(-9.0, 0.0).map(lambda x: 10**x),
    walled=st.booleans(),
)


def test_ellipse_of_the_reference():
    given_, expected = reference("13 elastic-plastic")
    line = Ellipse(np.array(given_["A"]), np.array(given_["B"]), 1.0)
    d = np.array(given_["delta"])
    assert line.force(d) == pytest.approx(expected["F_over_Estar"], rel=1e-14)
    assert line.contact_radius(d) == pytest.approx(expected["a"], rel=1e-14)


def test_steps_of_a_particle_code():
    """Force and apparent radius of LAMMPS, loading and unloading."""
    given_, expected = reference("22 elastic-plastic")
    body = mdr.ElasticPlastic(
        given_["E"], given_["nu"], yield_strength=given_["Y"], apparent_radius=True, wall_factor=True
    )
    n, deepest = given_["steps"], given_["depth"]
    path = mdr.indent(deepest, steps=n) >> mdr.indent(0.0, steps=n)
    result = mdr.solve(mdr.Contact(mdr.Sphere(given_["R"]), body), path)
    rows = np.array(expected["rows"])
    d = result["indentation"].values
    turn = int(rows[:, 0].argmax())
    halves = np.where(np.arange(rows.shape[0]) <= turn, 0, n)
    which = [h + int(np.argmin(np.abs(d[h : h + n] - x))) for h, x in zip(halves, rows[:, 0], strict=True)]
    assert np.max(np.abs(d[which] - rows[:, 0])) < 1e-15
    assert result["normal_force"].values[which] == pytest.approx(rows[:, 1], rel=1e-12)
    assert result["apparent_radius"].values[which] == pytest.approx(rows[:, 2], rel=1e-14)


NODES = tuple(0.5 * (x + (k == 0)) for k, x in enumerate(np.polynomial.legendre.leggauss(80)))


def integral(force, start, stop):
    """By Gauss, with d = start + (stop - start) t^2, because a force begins like a power of 3/2."""
    t, weights = NODES
    return (stop - start) * float(2.0 * t * force(start + (stop - start) * t * t) @ weights)


@settings(**FEW)
@given(ball=balls, fraction=st.floats(0.0, 1.0), height=st.floats(0.01, 1.0))
def test_energies_are_integrals_of_the_force(ball, fraction, height):
    deepest = 10 ** (-5.0 + 4.9 * fraction) * 0.9 * ball.radius
    first = min(deepest, ball.yield_depth * (1.0 - 1e-15))
    work = integral(ball.loading_force, 0.0, first) + integral(ball.loading_force, first, deepest)
    assert float(ball.loading_work(np.array(deepest))) == pytest.approx(work, rel=1e-11)
    m = np.array(deepest)
    start = float(ball.residual(m))
    d = start + height * (deepest - start)
    stored = integral(lambda x: ball.force(x, m), start, d)
    assert float(ball.elastic_energy(np.array(d), m)) == pytest.approx(stored, rel=1e-9)


@settings(**FEW)
@given(ball=balls, depths=st.lists(st.floats(-5.0, 0.0), min_size=2, max_size=6, unique=True))
def test_yielding_dissipates(ball, depths):
    """
    Dissipation rises with the largest indentation, the residual indentation too, and both are below their bounds.

    Just above first yield the model lets the dissipated energy fall by up to 9 %.
    """
    largest = 0.9 * ball.radius * 10 ** np.sort(depths)
    dissipated, residual = ball.dissipation(largest), ball.residual(largest)
    work = ball.loading_work(largest)
    assert np.all(dissipated >= 0.0)
    assert np.all(dissipated <= work)
    beyond = largest > 1.2 * ball.yield_depth
    assert np.all(np.diff(dissipated[beyond]) >= -1e-13 * work[beyond][1:])
    assert np.all(np.diff(dissipated) >= -0.1 * dissipated[:-1])
    assert np.all((residual >= 0.0) & (residual <= largest))
    assert np.all(np.diff(residual) >= 0.0)
    assert np.all(np.diff(ball.loading_force(largest)) >= 0.0)


@settings(**FEW)
@given(scale=st.floats(-9.0, 3.0).map(lambda x: 10**x), stress=st.floats(-3.0, 3.0).map(lambda x: 10**x))
def test_scaling(scale, stress):
    path = mdr.indent(0.1, steps=5) >> mdr.indent(0.08, steps=5)
    whole = mdr.solve(mdr.Contact(mdr.Sphere(1.0), mdr.ElasticPlastic(1e9, 0.3, yield_strength=2e7)), path)
    small_path = mdr.indent(0.1 * scale, steps=5) >> mdr.indent(0.08 * scale, steps=5)
    body = mdr.ElasticPlastic(1e9 * stress, 0.3, yield_strength=2e7 * stress)
    small = mdr.solve(mdr.Contact(mdr.Sphere(scale), body), small_path)
    force, energy = stress * scale**2, stress * scale**3
    for name, factor in {
        "normal_force": force,
        "contact_radius": scale,
        "residual_indentation": scale,
        "dissipated_energy": energy,
        "elastic_energy": energy,
    }.items():
        expected = factor * whole[name].values
        assert np.max(np.abs(small[name].values - expected)) <= 1e-12 * np.max(expected)


def test_without_yield_it_is_the_elastic_ellipse_and_hertz():
    strong = mdr.Contact(mdr.Sphere(1.0), mdr.ElasticPlastic("1 GPa", 0.3, yield_strength="1 TPa"))
    result = mdr.solve(strong, mdr.indent(1e-4, steps=3) >> mdr.indent(0.5e-4))
    assert result.status.name == "ELASTIC"
    assert not result["residual_indentation"].values.any()
    assert not result["dissipated_energy"].values.any()
    hertz = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic("1 GPa", 0.3))
    exact = mdr.solve(hertz, mdr.indent(1e-4, steps=3) >> mdr.indent(0.5e-4))
    for name in ("normal_force", "contact_radius", "normal_stiffness", "elastic_energy"):
        # g = x^2/R (1 + x^2/(4 R^2)): corrections of the order of d/R
        error = np.abs(result[name].values / exact[name].values - 1.0)
        assert np.all(error < exact["indentation"].values)
        assert error.max() > 1e-7


def test_first_yield_is_where_the_mean_pressure_of_hertz_reaches_its_limit():
    ball = ball_of()
    t = ball.yield_depth / ball.radius
    pressure = 4.0 * ball.modulus * math.sqrt(t) / (3.0 * math.pi)
    assert pressure == pytest.approx(ball.strength * (1.0 + 1.75 * math.exp(-4.4 * t)), rel=1e-14)
    d = np.array(ball.yield_depth)
    # there the force is that of Hertz
    hertz = 4.0 / 3.0 * ball.modulus * math.sqrt(ball.radius) * ball.yield_depth**1.5
    assert float(ball.force(d, d)) == pytest.approx(hertz, rel=1e-13)


@settings(**FEW)
@given(
    forces=st.lists(st.floats(0.0, 80.0), min_size=1, max_size=6),
    control=st.sampled_from(["force", "travel"]),
)
def test_force_and_travel_follow_the_same_curves(forces, control):
    """The indentations found by force or travel give the same history when they are prescribed."""
    if control == "force":
        first, stiffness = mdr.solve(BALL, mdr.Path(normal_force=forces)), None
        assert np.array_equal(first["normal_force"].values, forces)
    else:
        stiffness = "5e6 N/m"
        travel = 0.5e-6 * np.array(forces) - 2e-6
        first = mdr.solve(BALL, mdr.Path(travel=travel), machine_stiffness=stiffness)
        assert first["travel"].values == pytest.approx(travel, rel=1e-12, abs=1e-18)
    again = mdr.solve(BALL, mdr.Path(indentation=first["indentation"].values))
    for name in ("normal_force", "contact_radius", "residual_indentation", "dissipated_energy"):
        scale = np.max(np.abs(again[name].values))
        # an unloading curve is steep: the force has the rounding of the indentation
        assert np.max(np.abs(first[name].values - again[name].values), initial=0.0) <= 1e-10 * scale


def test_rows_do_not_matter():
    path = mdr.indent("10 um") >> mdr.indent("9.5 um") >> mdr.indent("12 um") >> mdr.indent("11.5 um")
    fine = [mdr.indent(d, steps=37) for d in ("10 um", "9.5 um", "12 um", "11.5 um")]
    whole = mdr.solve(BALL, path)
    finer = mdr.solve(BALL, fine[0] >> fine[1] >> fine[2] >> fine[3])
    for name in whole.data:
        if name != "yielding":
            assert np.array_equal(whole[name].values, finer[name].values[36::37])


def test_reloading_follows_unloading():
    up_and_down = mdr.indent("10 um") >> mdr.indent("9.2 um", steps=10) >> mdr.indent("10 um", steps=10)
    result = mdr.solve(BALL, up_and_down)
    force = result["normal_force"].values
    assert force[11:20] == pytest.approx(force[1:10][::-1], rel=1e-9)
    assert not result["yielding"].values[1:].any()
    assert np.ptp(result["dissipated_energy"].values) == 0.0


def test_energy_balance_with_a_machine():
    result = mdr.solve(
        BALL, mdr.travel("20 um", steps=4000) >> mdr.travel(0.0, steps=4000), machine_stiffness="5e6 N/m"
    )
    travel, force = result["travel"].values, result["normal_force"].values
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(travel))])
    own = result["external_work"].values
    assert np.max(np.abs(own - own[0] - work)) < 1e-6 * own.max()
    balance = own - result["elastic_energy"] - result["dissipated_energy"] - force**2 / 1e7
    assert np.max(np.abs(balance)) < 1e-15 * own.max() * 10


def test_growth_of_the_apparent_radius_stiffens():
    """The rows matter, by 0.3 % here: yield begins in a row, and growth is averaged over ten."""
    grown = []
    for steps in (200, 400, 800):
        body = mdr.ElasticPlastic(1e9, 0.3, yield_strength=2e7, apparent_radius=True)
        result = mdr.solve(mdr.Contact(mdr.Sphere(1.0), body), mdr.load(2e7, steps=steps))
        assert result["normal_force"].values[-1] == 2e7
        grown.append(float(result["indentation"][-1]))
    assert np.ptp(grown) < 3e-3 * grown[-1]
    plain = mdr.Contact(mdr.Sphere(1.0), mdr.ElasticPlastic(1e9, 0.3, yield_strength=2e7))
    without = float(mdr.solve(plain, mdr.load(2e7))["indentation"][-1])
    assert 0.98 < grown[-1] / without < 1.0


@pytest.mark.parametrize("strength", [2e7, 6e7])
def test_growth_in_impacts_is_the_limit_of_many_steps(strength):
    """Steps of first order from first yield on, extrapolated; an impact against its motion by steps."""
    ball = ball_of(strength, walled=True)
    growing, ends, deepest = GrowingBall(ball), [], 0.3
    for n in (1000, 2000):
        state = growing.start
        first = ball.yield_depth * np.array([1.0 - 1e-9, 1.0 + 1e-9])
        for d in np.concatenate([first, np.linspace(ball.yield_depth, deepest, n + 1)[1:]]).tolist():
            row, state = growing.advance(state, d)
        ends.append([row.apparent_radius, row.force, row.residual])
    middle, fine = np.array(ends)
    at, grown = np.array(deepest), with_growth(ball)
    limit = [grown.grown(at), grown.force(at, at), grown.residual(at)]
    assert 2.0 * fine - middle == pytest.approx(np.array(limit), rel=1e-5)
    assert np.all(np.abs(fine - limit) < 0.6 * np.abs(middle - limit))
    assert float(ball.force(at, at)) < 0.96 * float(grown.force(at, at))


GROWING = mdr.Contact(
    mdr.Sphere("10 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa", apparent_radius=True, wall_factor=True)
)


def test_restitution_with_growth_is_that_of_impact():
    hit = mdr.impact(GROWING, mass="10 g", speed="8 m/s")
    assert hit.energy_lost == pytest.approx(0.32 * (1.0 - hit.restitution**2), rel=1e-12)
    many = mdr.restitution(GROWING, mass="10 g", speeds=[3.0, 8.0])
    assert float(many["restitution"][1]) == pytest.approx(hit.restitution, rel=1e-10)
    assert float(many["contact_time"][1]) == pytest.approx(hit.contact_time, rel=1e-9)
    assert many["restitution"][1] < many["restitution"][0] < 1.0


def test_an_impact_with_growth_is_the_motion_by_steps():
    hit = mdr.impact(GROWING, mass="10 g", speed="8 m/s")
    ends = []
    for dt in (4e-7, 2e-7):
        steps, v, d, force = mdr.Stepper(GROWING, 1.1 * hit.largest_indentation), 8.0, 0.0, 0.0
        while v > 0.0 or force > 0.0:
            v -= 0.5 * dt * force / 0.01
            d += dt * v
            force = steps.advance(d).normal
            v -= 0.5 * dt * force / 0.01
        ends.append(-v / 8.0)
    assert 2.0 * ends[1] - ends[0] == pytest.approx(hit.restitution, rel=1e-3)


def test_adhesion_on_unloading():
    """The edge at rest: a punch of constant radius; at separation the opening of the edge is least."""
    ball, work = ball_of(), 3e4
    d = np.concatenate([[0.12], np.linspace(0.12, 0.06, 4001)])
    largest = np.full(d.shape, 0.12)
    rows, (a, dissipated) = follow_edge(ball, work, d, largest, start_of_edge())
    assert a == 0.0
    assert dissipated == rows.dissipated[-1]
    # the energy that unloading takes is stored or dissipated
    done = np.concatenate([[0.0], np.cumsum(0.5 * (rows.force[1:] + rows.force[:-1]) * np.diff(d))])
    balance = done - (rows.elastic_energy - rows.elastic_energy[0]) - rows.dissipated
    # the jump to separation lies within one row
    assert np.max(np.abs(balance[rows.contact_radius > 0.0])) < 1e-6 * rows.elastic_energy[0]
    assert np.max(np.abs(balance)) < 1e-4 * rows.elastic_energy[0]
    at_rest = rows.contact_radius == ball.full_radius(np.array(0.12))
    slope = np.gradient(rows.force[at_rest][1:], d[at_rest][1:])
    expected = 2.0 * ball.modulus * rows.contact_radius[1] / float(ball.scale(np.array(0.12)))
    assert slope == pytest.approx(np.full(slope.shape, expected), rel=1e-8)
    line = ball.line(np.array(0.12))
    edge = Edge(Ellipse(line.height, line.width, line.modulus), work)
    last = int(np.flatnonzero(rows.contact_radius > 0.0)[-1])
    within = ball.line_depth(d, largest)
    assert within[last] >= edge.opening(edge.critical_radius) > within[last + 1]
    step = 1e-4 * edge.critical_radius
    least = edge.opening(edge.critical_radius)
    assert least < min(edge.opening(edge.critical_radius + step), edge.opening(edge.critical_radius - step))


def test_loads_with_adhesion_are_met_where_depths_have_these_forces():
    """First loading, an edge at rest, one that recedes, and loading again from it."""
    contact = mdr.Contact(
        mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa"), adhesion=mdr.JKR("200 J/m^2")
    )
    depth = 1e-6 * np.array([5.0, 60.0, 50.0, 48.0, 44.6, 44.5, 44.4, 44.7, 55.0, 80.0, 70.0])
    by_depth = mdr.solve(contact, mdr.Path(indentation=depth))
    force, radius = (by_depth[name].values for name in ("normal_force", "contact_radius"))
    assert force.min() > 0.0
    assert radius[6] < radius[4] < radius[3] == radius[1]
    by_load = mdr.solve(contact, mdr.Path(normal_force=force))
    for name in ("indentation", "contact_radius", "elastic_energy", "dissipated_energy"):
        assert by_load[name].values == pytest.approx(by_depth[name].values, rel=1e-12)
    assert by_load.claims["normal_force"].level is mdr.Level.EXACT
    # a load of 0 N lies on the way to tension, and separates nothing
    let_go = mdr.load("10 N") >> mdr.load("0 N")
    rest = float(mdr.solve(contact, let_go)["indentation"][-1])
    pulled = mdr.solve(contact, let_go >> mdr.indent(rest - 1e-6))
    assert pulled["normal_force"].values[1] == 0.0 > pulled["normal_force"].values[2]
    assert pulled["contact_radius"].values[1] >= pulled["contact_radius"].values[2] > 0.0


@pytest.mark.parametrize("stiffness", [1e4, 2e6, 1e10])
def test_travel_and_tension_are_followed_to_their_folds(stiffness):
    """The states of prescribed indentations up to the least travel or force among them, and none below."""
    contact = mdr.Contact(
        mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa"), adhesion=mdr.JKR("200 J/m^2")
    )
    depth = np.concatenate([[60e-6], np.linspace(60e-6, 28e-6, 2001)[1:]])
    known = mdr.solve(contact, mdr.Path(indentation=depth))
    force, radius = known["normal_force"].values, known["contact_radius"].values
    attached = radius > 0.0
    travel = depth + force / stiffness
    fold = int(np.where(attached, travel, math.inf).argmin())
    assert 0 < fold <= np.flatnonzero(attached)[-1]
    rows = np.append(travel[: fold + 1 : 50], [travel[fold] - 1e-3 * abs(travel[fold]), travel[0]])
    pulled = mdr.solve(contact, mdr.Path(travel=rows), machine_stiffness=stiffness)
    for name in ("indentation", "normal_force", "contact_radius", "dissipated_energy"):
        assert pulled[name].values[:-2] == pytest.approx(
            known[name].values[: fold + 1 : 50], rel=1e-9, abs=1e-9 * np.abs(known[name].values).max()
        )
    assert pulled["contact_radius"].values[-2] == 0.0 == pulled["normal_force"].values[-2]
    assert pulled["indentation"].values[-2] == rows[-2]
    assert pulled["normal_force"].values[-1] == pytest.approx(force[0], rel=1e-9)
    # the work of the travel up to the fold is stored and dissipated, and all is dissipated after it
    done = np.sum(0.5 * np.diff(travel[: fold + 1]) * (force[1 : fold + 1] + force[:fold]))
    taken = float(pulled["external_work"][-2] - pulled["external_work"][0])
    assert taken == pytest.approx(done, abs=2e-3 * float(pulled["external_work"][0]))
    assert float(pulled["elastic_energy"][-2]) == 0.0
    least = int(force.argmin())
    loaded = mdr.solve(
        contact, mdr.Path(normal_force=np.append(force[: least + 1 : 50], force[least] * 1.001))
    )
    assert loaded["indentation"].values[:-1] == pytest.approx(depth[: least + 1 : 50], rel=1e-9)
    assert np.isnan(loaded["indentation"].values[-1])
    assert loaded.status is mdr.Status.PULLED_OFF
    assert "does not hold the prescribed tension" in loaded.summary()
    assert loaded.claims["normal_force"].where.tolist() == [True] * (loaded.data.sizes["step"] - 1) + [False]
    assert float(loaded["dissipated_energy"][-1]) > float(loaded["dissipated_energy"][-2])
    with pytest.raises(mdr.NotValidError, match="does not hold a prescribed tension"):
        mdr.solve(contact, mdr.load("-1 N"))["normal_force"]
    assert np.isnan(loaded["mean_pressure"].values[-1])
    without_yield = loaded.plot().axes[0].lines[0]
    assert without_yield.get_label() == "without yield"
    assert np.isfinite(without_yield.get_xydata()).all()


STICKY = mdr.Contact(
    mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa"), adhesion=mdr.JKR("20 J/m^2")
)
"""Of 10 mg: it sticks below 0.18 m/s, and rebounds best at some 1 m/s."""


@pytest.mark.parametrize("speed", first_of([5.0, 0.3]))
def test_an_impact_against_adhesion_loses_what_steps_dissipate(speed):
    impact = mdr.impact(STICKY, mass="10 mg", speed=speed)
    deepest = float(impact.data["largest_indentation"])
    stepper = mdr.Stepper(STICKY, deepest)
    for d in (deepest, -deepest):
        stepper.advance(d)
    assert stepper.jumped
    energy = 0.5e-5 * speed**2
    e = math.sqrt(1.0 - stepper.dissipated_energy / energy)
    assert float(impact.data["restitution"]) == pytest.approx(e, rel=1e-10)
    assert impact.data["velocity"].values[-1] == pytest.approx(-e * speed, rel=1e-6)
    # the motion by the forces of steps, to second order
    moved, v, d, force, dt, steps = mdr.Stepper(STICKY, 1.1 * deepest), speed, 0.0, 0.0, 2e-8, 0
    while not moved.jumped:
        v -= 0.5 * dt * force / 1e-5
        d += dt * v
        force = moved.advance(d).normal
        v -= 0.5 * dt * force / 1e-5
        steps += 1
    assert -v == pytest.approx(e * speed, rel=2e-3)
    assert float(impact.data["contact_time"]) == pytest.approx(dt * steps, rel=2e-3)
    assert d == pytest.approx(float(impact.data["indentation"][-1]), abs=2.0 * speed * dt)
    together = mdr.restitution(STICKY, mass="10 mg", speeds=[speed])
    assert float(together.data["restitution"][0]) == pytest.approx(e, rel=1e-12)
    assert float(together.data["contact_time"][0]) == pytest.approx(
        float(impact.data["contact_time"]), rel=1e-9
    )


def test_slow_balls_stick():
    slowest = float(mdr.impact(STICKY, mass="10 mg", speed=1.0).data["sticking_speed"])
    rows = mdr.restitution(STICKY, mass="10 mg", speeds=slowest * np.array([0.5, 1.0 - 1e-6, 1.0 + 1e-6]))
    e = rows.data["restitution"].values
    assert e[:2].tolist() == [0.0, 0.0] < e[2:].tolist()
    assert np.isinf(rows.data["contact_time"].values).tolist() == [True, True, False]
    stuck = mdr.impact(STICKY, mass="10 mg", speed=0.5 * slowest)
    assert stuck.events[-1].name == "rest"
    # it rests under tension, with the energy that the stretched contact stores
    assert stuck.data["normal_force"].values[-1] < 0.0 == stuck.data["velocity"].values[-1]
    assert stuck.data["contact_radius"].values[-1] > 0.0


def test_adhesion_of_an_elastic_ball_is_jkr_on_unloading():
    """Where the edge recedes, the pull-off under prescribed indentation is that of JKR to the order of a/R."""
    radius, work = 1.0, 50.0
    body = mdr.ElasticPlastic("1 GPa", 0.3, yield_strength="1 TPa")
    contact = mdr.Contact(mdr.Paraboloid(radius), body, adhesion=mdr.JKR(work))
    result = mdr.solve(contact, mdr.indent(3e-4) >> mdr.indent(-1e-4, steps=4000))
    known = mdr.solve(
        mdr.Contact(mdr.Paraboloid(radius), mdr.Elastic("1 GPa", 0.3), adhesion=mdr.JKR(work)),
        mdr.indent(3e-4) >> mdr.indent(-1e-4, steps=4000),
    )
    low = -1.5 * math.pi * work * radius
    assert result["normal_force"].values.min() == pytest.approx(low, rel=1e-4)
    receded = result["normal_force"].values[2500:] < 0.0
    ours, jkr = result["normal_force"].values[2500:][receded], known["normal_force"].values[2500:][receded]
    assert np.max(np.abs(ours - jkr)) < 1e-4 * abs(low)


def test_the_flattened_ball_unloads_elastically():
    """The residual profile, mapped and solved as an elastic contact, has the radii and indentations of unloading."""
    path = mdr.load("40 N") >> mdr.Path(normal_force=[36.0, 20.0, 4.0, 0.4])
    result = mdr.solve(BALL, path)
    profile = mdr.residual_profile(result)
    elastic = mdr.solve(
        mdr.Contact(profile, mdr.Elastic("120 GPa", 0.34)), mdr.Path(normal_force=[36.0, 20.0, 4.0, 0.4])
    )
    ball, largest = ball_of(200e6, 120e9, 0.34, 1e-3), result["indentation"].values[0]
    assert profile.max_radius == pytest.approx(result["contact_radius"].values[0], rel=1e-12)
    assert elastic["contact_radius"].values == pytest.approx(result["contact_radius"].values[1:], rel=1e-8)
    depth = float(ball.residual(largest)) + float(ball.scale(largest)) * elastic["indentation"].values
    assert depth == pytest.approx(result["indentation"].values[1:], rel=1e-11)


def test_slow_impacts_are_those_of_hertz():
    """T v / d of Hertz's ball, and restitution 1 below first yield."""
    hit = mdr.impact(BALL, mass="37 mg", speed="1 mm/s")
    assert hit.restitution == 1.0
    assert hit.contact_time * 1e-3 / hit.largest_indentation == pytest.approx(2.943275184324705, rel=1e-6)


@settings(max_examples=8, deadline=None)
@given(speed=st.floats(-2.0, 1.5).map(lambda x: 10**x))
def test_impacts_that_yield(speed):
    """Momentum, energy, and the motion by an independent integration of m d'' = -F."""
    mass = 37e-6
    hit = mdr.impact(BALL, mass=mass, speed=speed)
    ball = ball_of(200e6, 120e9, 0.34, 1e-3)
    m = np.array(hit.largest_indentation)
    assert float(ball.loading_work(m)) == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    returned = float(ball.elastic_energy(m, m))
    assert hit.restitution**2 == pytest.approx(returned / (0.5 * mass * speed**2), rel=1e-9)
    t, force = hit.data["time"].values, hit.data["normal_force"].values
    impulse = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(t)))
    assert impulse == pytest.approx(mass * speed * (1.0 + hit.restitution), rel=1e-3)
    many = mdr.restitution(BALL, mass=mass, speeds=[speed])
    assert float(many["restitution"][0]) == pytest.approx(hit.restitution, rel=1e-12)
    assert float(many["contact_time"][0]) == pytest.approx(hit.contact_time, rel=1e-9)


def test_restitution_decreases_like_the_fourth_root_of_the_speed():
    """Johnson (1985), section 11.5: e ~ v^(-1/4) where the pressure is constant and the contact small."""
    soft = mdr.Contact(mdr.Sphere(1.0), mdr.ElasticPlastic("100 GPa", 0.3, yield_strength="1 MPa"))
    speeds = np.geomspace(1e-4, 50.0, 40)
    study = mdr.restitution(soft, mass=1e3, speeds=speeds)
    e, deepest = (study[name].values for name in ("restitution", "indentation"))
    assert np.all(np.diff(e) < 0.0)
    slope = np.diff(np.log(e)) / np.diff(np.log(speeds))
    shallow = (deepest[1:] < 1e-4) & (deepest[:-1] > 1e-7)
    assert shallow.sum() > 3
    assert np.max(np.abs(slope[shallow] + 0.25)) < 0.005


BAD = [
    (lambda: mdr.residual_profile(mdr.solve(BALL, mdr.indent("1 nm"))), "has not yielded"),
    (
        lambda: mdr.residual_profile(
            mdr.solve(mdr.Contact(mdr.Sphere(1.0), mdr.Elastic(1e9, 0.3)), mdr.indent(1e-3))
        ),
        "no body of the contact yields",
    ),
    (lambda: mdr.residual_profile(mdr.solve(BALL, mdr.indent("1 um")), step=7), "step 7 does not exist"),
    (lambda: mdr.impact(BALL, mass="37 mg", speed="1 km/s"), "largest normal speed is 154"),
    (lambda: mdr.ElasticPlastic("1 GPa", 0.3, yield_strength=0.0), "yield_strength = 0"),
    (lambda: mdr.ElasticPlastic("1 GPa", 0.7, yield_strength="1 MPa"), "poisson"),
    (lambda: mdr.ElasticPlastic("1 GPa", 0.3, yield_strength="1 MPa", wall_factor=1), "True or False"),
    (lambda: mdr.Contact(mdr.Cone(slope=0.1), COPPER), "fitted for balls"),
    (lambda: mdr.Contact(mdr.Sphere(1.0), COPPER, mdr.Elastic(1e9, 0.3)), "rigid flat"),
    (lambda: mdr.Contact(mdr.Sphere(1.0), COPPER, COPPER), "rigid flat"),
    (lambda: mdr.Contact(mdr.Sphere(1.0), COPPER, friction=mdr.Coulomb(0.3)), "friction"),
    (lambda: mdr.Contact(mdr.Sphere(1.0), COPPER, adhesion=mdr.DMT(0.1)), r"JKR\(work\)"),
    (
        lambda: mdr.Contact(mdr.Sphere(1.0), COPPER, mdr.Viscoelastic(mdr.Maxwell(1e6, 1.0), poisson=0.5)),
        "Viscoelastic",
    ),
    (lambda: mdr.solve(BALL, mdr.indent("0.95 mm")), "0.9 of the radius"),
    (lambda: mdr.solve(BALL, mdr.load("1 MN")), "0.9 of the radius"),
    (lambda: mdr.solve(BALL, mdr.load("-1 N")), "cannot be below 0 N"),
    (lambda: mdr.solve(BALL, mdr.shift("1 um")), "friction"),
    (lambda: mdr.solve(BALL, mdr.indent("1 um"), solver=mdr.Rings(50)), "ElasticPlastic"),
    (lambda: mdr.pull_off(BALL), "adhesion"),
    (lambda: mdr.verify(BALL, mdr.indent("1 um")), "no independent solver"),
    (lambda: mdr.effective_moduli(COPPER, mdr.Rigid()), "largest indentation"),
    (lambda: mdr.export_law(BALL, "1 um"), "largest indentation; use Stepper"),
    (
        lambda: mdr.solve(mdr.Contact(mdr.Sphere(1.0), COPPER, adhesion=mdr.JKR(1.0)), mdr.load("1 TN")),
        "0.9 of the radius",
    ),
]


@pytest.mark.parametrize(("action", "words"), BAD)
def test_bad_input(action, words):
    with pytest.raises(mdr.PymdrError, match=words):
        action()


def test_results_are_saved_and_drawn(tmp_path):
    result = mdr.solve(BALL, mdr.indent("10 um", steps=5) >> mdr.indent("9 um", steps=5))
    assert result.status.name == "YIELDED"
    result.save(tmp_path / "ball.nc")
    again = mdr.open_result(tmp_path / "ball.nc")
    assert np.array_equal(again["residual_indentation"].values, result["residual_indentation"].values)
    assert again.contact == BALL
    assert set(result.figures()) >= {"force", "curves", "history"}
    assert result.claims["normal_force"].level is mdr.Level.APPROXIMATE
    with pytest.raises(mdr.NotValidError, match="neither pressures nor displacements"):
        result.field("pressure")


def test_case_file(tmp_path):
    case = tmp_path / "ball.toml"
    case.write_text(
        "\n".join(
            (
                '[profile]\nkind = "sphere"\nradius = "1 mm"',
                '[body]\nkind = "elastic_plastic"\nyoung = "120 GPa"\npoisson = 0.34\nyield_strength = "200 MPa"',
                "wall_factor = true",
                '[[path]]\nkind = "indent"\nindentation = "10 um"',
            )
        )
    )
    body = read_case(case).contact.body
    assert body == mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa", wall_factor=True)


def test_sweep_over_the_yield_strength():
    study = mdr.sweep(BALL, mdr.indent("10 um"), {"body.yield_strength": ["200 MPa", "400 MPa", "800 MPa"]})
    force = np.ravel(study.data["normal_force"].values)
    assert np.all(np.diff(force) > 0.0)


@pytest.mark.parametrize(
    ("path", "prescribed"),
    [
        (mdr.load("40 N"), "normal_force"),
        (mdr.travel("10 um"), "travel"),
        (mdr.indent("5 um"), "indentation"),
    ],
)
def test_only_what_is_prescribed_is_exact(path, prescribed):
    ball = mdr.Contact(mdr.Sphere("1 mm"), mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa"))
    claims = mdr.solve(ball, path, machine_stiffness="10 MN/m").claims
    exact = {name for name, claim in claims.items() if claim.level is mdr.Level.EXACT}
    assert exact == {prescribed}
    assert "travel" in claims
