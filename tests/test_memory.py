"""Contacts that remember against closed forms, quadrature, limits and each other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.special import dawsn

import pymdr as mdr
from drawing import examples
from pymdr.errors import ConvergenceError, PathError
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import elastic_energy, normal_force, states_at_depth
from pymdr.line.memory import (
    MemoryState,
    approach_and_retreat,
    creep,
    dividing,
    follow_loads,
    follow_springs,
    follow_travels,
    histories,
    kernels,
    line_state,
    row_kernels,
    springs_to,
    tabulated,
    ting,
    virgin,
)
from pymdr.line.memory.modes import modes_of
from pymdr.line.memory.tabulated import followed
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.profiles import Cone, FlatPunch, Paraboloid, PowerLaw, Sampled


def line_of(profile):
    return ElasticLine(equivalent_profile(profile), 1.0)


PARABOLOID = line_of(Paraboloid(1.0))

STANDARD = Relaxation(1.2, np.array([4.0]), np.array([0.4]))


def solid(inputs):
    return Relaxation(4.0 * inputs["Ginf"], np.array([4.0 * inputs["G1"]]), np.array([inputs["tau"]]))


def triangle(t, top, speed):
    return speed * np.where(t <= top, t, 2.0 * top - t)


def test_standard_solid_of_the_references(references):
    entry = references["ting_sls_parab"]
    t = np.array([0.0, *entry["inputs"]["t"]])
    rows = ting(PARABOLOID, solid(entry["inputs"]), t, triangle(t, 1.0, 0.4))
    assert rows.force[1:] == pytest.approx(entry["expected"]["F"], rel=entry["rtol"], abs=1e-14)
    assert rows.contact_radius[1:] == pytest.approx(entry["expected"]["a"], rel=entry["rtol"], abs=1e-14)


def test_maxwell_of_the_references(references):
    entry = references["maxwell_constvel"]
    i = entry["inputs"]
    body = Relaxation(0.0, np.array([4.0 * i["G"]]), np.array([i["tau"]]))
    rows = ting(PARABOLOID, body, [0.0, i["t"]], [0.0, i["v"] * i["t"]])
    assert rows.force[1] == pytest.approx(entry["expected"]["F"], rel=entry["rtol"])
    end = references["maxwell_detach"]["expected"]["t_end"]
    t = np.array([0.0, 1.0, end * (1.0 - 1e-8), end * (1.0 + 1e-8)])
    for rows in (
        ting(PARABOLOID, body, t, triangle(t, 1.0, 0.4)),
        follow_springs(PARABOLOID, body, t, triangle(t, 1.0, 0.4), n=4000),
    ):
        assert rows.force[3] == 0.0 == rows.contact_radius[3]
    assert ting(PARABOLOID, body, t, triangle(t, 1.0, 0.4)).contact_radius[2] > 0.0


def test_creep_of_the_references(references):
    entry = references["sls_creep"]
    i = entry["inputs"]
    rows = creep(PARABOLOID, STANDARD, [0.0, i["t"]], [i["F0"], i["F0"]])
    assert rows.contact_radius[1] == pytest.approx(entry["expected"]["a"], rel=entry["rtol"])
    assert rows.indentation[1] == pytest.approx(entry["expected"]["d"], rel=entry["rtol"])


def test_kernels_are_compiled_once_for_arrays_that_can_be_written_and_for_others():
    t, d = np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.3, 0.1])
    kept = t.copy(), d.copy()
    for values in kept:
        values.flags.writeable = False
    for times in (t, kept[0]):
        for depths in (d, kept[1]):
            follow_springs(PARABOLOID, STANDARD, times, depths, n=20)
            follow_loads(PARABOLOID, STANDARD, times, depths, n=20)
            goal = dividing.Goal(times, depths, 0.0, 0.0)
            dividing.parts_of(PARABOLOID, STANDARD, goal, virgin(0.0, 0.0), tolerance=0.1)
    assert len(row_kernels.divide.signatures) == 1
    assert len(row_kernels.follow.signatures) == 1  # indentations or loads, watched or not


def orders(errors):
    return np.log2(np.array(errors)[:-1] / np.array(errors)[1:])


@pytest.mark.parametrize("profile", [Paraboloid(1.0), Cone(slope=0.3)])
def test_springs_converge_to_ting_at_second_order(profile):
    line = line_of(profile)
    body = Relaxation(1.0, np.array([2.0, 1.0]), np.array([0.3, 2.0]))
    t = np.linspace(0.0, 2.0, 101)
    d = triangle(t, 1.0, 0.1)
    exact = ting(line, body, t, d)
    force, radius = [], []
    for n in (100, 200, 400, 800):
        rows = follow_springs(line, body, t, d, n=n)
        assert rows.disk.all()
        force.append(abs(rows.force - exact.force).max() / exact.force.max())
        radius.append(
            abs(rows.contact_radius - exact.contact_radius)[t < 1.2].max() / exact.contact_radius.max()
        )
    assert (orders(force) > 1.8).all()
    assert force[-1] < 5e-6
    assert radius[-1] < 1e-4


@settings(max_examples=examples(30), deadline=None)
@given(
    st.lists(st.floats(-0.5, 0.0), max_size=6),
    st.lists(st.floats(-0.5, 0.0), max_size=6),
    st.floats(-0.5, 0.0),
    st.floats(0.0, 0.1),
)
def test_the_path_of_separated_bodies_does_not_matter(before, after, last, kept):
    d = np.array([*before, last, 0.04, 0.1, kept, *after])
    t = 0.3 * np.arange(1.0, d.size + 1.0)
    body = Relaxation(1.0, np.array([2.0, 1.0]), np.array([0.3, 2.0]))
    result = ting(PARABOLOID, body, t, d)
    springs = follow_springs(PARABOLOID, body, t, d, n=400)
    assert result.indentation.tolist() == d.tolist()
    assert result.force == pytest.approx(springs.force, rel=0.0, abs=3e-5 * springs.force.max())
    direct = ting(PARABOLOID, body, t[len(before) :], d[len(before) :])
    # the instants of the two are rounded apart, and a force that has nearly relaxed away is the rest of a large one
    assert result.force[len(before) :] == pytest.approx(
        direct.force, rel=1e-13, abs=1e-15 * result.force.max()
    )


@st.composite
def pressed_once(draw):
    """Times and depths of one approach and one retreat, apart at first and at last or not."""
    part = st.floats(0.01, 1.0)
    up = np.cumsum(draw(st.lists(part, min_size=1, max_size=8)))
    down = 0.1 - 0.04 * np.cumsum(draw(st.lists(part, max_size=8)))
    before = draw(st.lists(st.floats(-0.05, 0.0), max_size=2))
    d = np.array([*before, *(0.1 * up / up[-1]), *([0.1] * draw(st.integers(0, 2))), *down])
    return np.cumsum([10.0 ** draw(st.floats(-2.0, 0.0)) for _ in d]), d


@st.composite
def relaxing(draw):
    times = sorted(10.0**x for x in draw(st.lists(st.floats(-3.0, 2.0), min_size=1, max_size=3, unique=True)))
    moduli = [10.0 ** draw(st.floats(-1.0, 1.0)) for _ in times]
    equilibrium, viscosity = draw(st.sampled_from([0.0, 1.0])), draw(st.sampled_from([0.0, 0.1]))
    return Relaxation(equilibrium, np.array(moduli), np.array(times), viscosity)


TABLES = {
    shape: (line_of(shape), tabulated(line_of(shape), 0.12))
    for shape in (Paraboloid(1.0), Cone(slope=0.3), PowerLaw(3.3, 1.0, 1.0))
}


@settings(max_examples=examples(150), deadline=None)
@given(st.sampled_from(list(TABLES.values())), pressed_once(), relaxing())
def test_tables_follow_one_approach_and_one_retreat_as_the_curve_does(shape, path, body):
    line, table = shape
    computed = approach_and_retreat(table, body, *path)
    try:
        exact = ting(line, body, *path).force
    except PathError:
        assert computed is None
        return
    # the end of a retreat is found to 1e-12 of the largest load per length
    assert computed == pytest.approx(exact, rel=0.0, abs=2e-11 * exact.max())


@settings(max_examples=examples(20), deadline=None)
@given(st.sampled_from(list(TABLES.values())), pressed_once(), relaxing(), st.floats(-1.5, 1.5))
def test_tables_follow_travels_as_springs_do(shape, path, body, log_stiffness):
    line, table = shape
    assume(body.viscosity == 0.0 or path[1][0] <= 0.0)  # a sudden move
    size = body.equilibrium + body.moduli.sum()
    softness = 1.0 / (10.0**log_stiffness * size * float(line.stiffness(line.place(0.1)).max()))
    result = followed(table, body, *path, softness, 1)
    if result is not None:
        few, many = (follow_travels(line, body, *path, 1.0 / softness, n=n).force for n in (500, 1000))
        # few springs lie where a fast relaxation is not over yet, and err by more than 1 / n^2
        off = np.abs(few - many).max() + 2e-6 * many.max()
        assert result == pytest.approx(many, rel=0.0, abs=off)


@settings(max_examples=examples(100), deadline=None)
@given(
    st.sampled_from(list(TABLES.values())),
    st.sampled_from([3, 6, 40, 250]),
    st.floats(0.0, 0.99),
    st.sampled_from([0.0, 1.0]),
    st.floats(-3.0, 3.0),
    st.floats(-4.0, 4.0),
)
def test_machines_deflect_by_travel_minus_indentation(shape, rows, start, spring, log_drag, log_softness):
    """Also where a dashpot holds all but a billionth of the travel."""
    line, table = shape
    body = Relaxation(1.0, np.array([spring]), np.array([0.3]), 10.0**log_drag)
    softness = 10.0**log_softness * 0.1 / float(normal_force(line, states_at_depth(line, [0.1]))[0])
    time = np.linspace(0.0, 2.0, rows)
    travel = np.interp(time, [0.0, 1.0, 2.0], [-0.1 * start / (1.0 - start), 0.05, 0.1])
    computed = followed(table, body, time, travel, softness, 1)
    assert computed is not None
    assert (softness * computed <= np.maximum(travel, 0.0) * (1.0 + 1e-12)).all()
    depth = travel - softness * computed
    exact = ting(line, body, time, np.maximum.accumulate(depth)).force
    # what the bodies bear tells the travel where they are stiffer than the machine, and the depth where they are softer
    difference = np.abs(computed - exact) * np.clip(depth, 0.0, None) / np.maximum(travel, 1e-3)
    assert difference.max() < 1e-6 * computed.max()


@settings(max_examples=examples(60), deadline=None)
@given(
    st.sampled_from(list(TABLES.values())),
    st.sampled_from([20, 60, 200]),
    st.sampled_from([0.0, 0.05, 1.0]),
    st.floats(-2.0, 0.3),
    st.floats(-2.0, 1.0),
)
def test_the_few_rows_of_a_machine_bear_what_many_do(shape, rows, drag, log_time, log_softness):
    """The way between the rows is not straight for the bodies."""
    line, table = shape
    body = Relaxation(1.0, np.array([1.0]), np.array([10.0**log_time]), drag)
    softness = 10.0**log_softness * 0.05 / float(normal_force(line, states_at_depth(line, [0.1]))[0])
    time = np.linspace(0.0, 1.0, rows + 1)
    travel = np.interp(time, [0.0, 0.4, 0.6, 1.0], [-0.03, 0.1, 0.1, -0.03])
    result = approach_and_retreat(table, body, time, travel, softness)
    many = followed(table, body, time, travel, softness, 20_000 // rows)
    assert result is not None
    assert many is not None
    assert result == pytest.approx(many, rel=0.0, abs=(1e-6 if drag == 0.0 else 3e-3) * many.max())


def test_a_constant_travel_may_rise_again():
    _, table = TABLES[Paraboloid(1.0)]
    body = Relaxation(1.0, np.array([2.0]), np.array([0.01]))
    time = np.arange(60.0)
    travel = np.minimum.reduce([0.003 * (time // 10 + 1), 0.003 * (time + 1)])
    for softness in (0.1, 1.0, 10.0):
        assert approach_and_retreat(table, body, time, travel, softness) is not None


def test_tables_say_what_they_do_not_follow():
    _, table = TABLES[next(iter(TABLES))]
    body = Relaxation(1.0, np.array([2.0]), np.array([0.3]))
    t = np.arange(1.0, 6.0)
    twice = np.array([0.0, 0.1, 0.02, 0.09, 0.0])
    assert approach_and_retreat(table, body, t, twice) is None
    assert approach_and_retreat(table, body, t, 2.0 * triangle(t, 3.0, 0.1)) is None
    assert approach_and_retreat(table, Relaxation(1.0, viscosity=1.0), t, twice + 0.01) is None
    short = Sampled(np.linspace(0.0, 0.2, 30), 0.5 * np.linspace(0.0, 0.2, 30) ** 2)
    assert tabulated(line_of(short), 0.12).max_argument == pytest.approx(0.04, rel=1e-6)


def test_rows_are_exact_in_time():
    body = Relaxation(1.0, np.array([2.0, 1.0]), np.array([0.3, 2.0]))
    few = np.array([0.0, 1.0, 1.6, 2.5, 4.0])
    d = np.array([0.0, 0.1, 0.02, 0.09, -0.01])
    many = np.unique(np.concatenate([few, np.linspace(0.0, 4.0, 333)]))
    sparse = follow_springs(PARABOLOID, body, few, d, n=300)
    dense = follow_springs(PARABOLOID, body, many, np.interp(many, few, d), n=300)
    at = np.searchsorted(many, few)
    assert sparse.force == pytest.approx(dense.force[at], rel=1e-9, abs=1e-12)
    assert sparse.dissipated == pytest.approx(dense.dissipated[at], rel=1e-9, abs=1e-12)


def test_forces_converge_at_second_order_in_time():
    exact = creep(PARABOLOID, STANDARD, [0.0, 1.0], [0.0, 0.2]).indentation[-1]
    errors = []
    for rows in (5, 10, 20, 40):
        t = np.linspace(0.0, 1.0, rows + 1)
        errors.append(abs(follow_loads(PARABOLOID, STANDARD, t, 0.2 * t, n=8000).indentation[-1] - exact))
    assert (orders(errors) > 1.7).all()


@pytest.mark.parametrize("n", [100, 1000])
def test_nothing_relaxes(n):
    body = Relaxation(3.0, np.zeros(0), np.zeros(0))
    d = np.array([0.0, 0.1, 0.04, 0.2, -0.1, 0.05])
    rows = follow_springs(PARABOLOID, body, np.arange(6.0), d, n=n)
    states = states_at_depth(PARABOLOID, d)
    assert rows.contact_radius == pytest.approx(states.contact_radius, abs=1e-14)
    assert rows.force == pytest.approx(3.0 * normal_force(PARABOLOID, states), rel=20.0 / n**2, abs=1e-14)
    assert rows.stored == pytest.approx(3.0 * elastic_energy(PARABOLOID, states), rel=50.0 / n**2, abs=1e-14)
    assert rows.dissipated == pytest.approx(np.zeros(6), abs=1e-14)


def test_sudden_and_slow_moves():
    t, d = np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.1, 0.03])
    elastic = normal_force(PARABOLOID, states_at_depth(PARABOLOID, d))
    for factor, modulus in ((1e-9, STANDARD.glassy), (1e9, STANDARD.rubbery)):
        for rows in (
            follow_springs(PARABOLOID, STANDARD, factor * t, d),
            ting(PARABOLOID, STANDARD, factor * t, d),
        ):
            assert rows.force == pytest.approx(modulus * elastic, rel=2e-5, abs=1e-15)
    at_once = follow_springs(PARABOLOID, STANDARD, np.zeros(3), d)
    assert at_once.force == pytest.approx(STANDARD.glassy * elastic, rel=2e-5, abs=1e-15)


def test_closed_forms_of_approach():
    v, tau, modulus = 0.4, 0.4, 4.0
    t = np.linspace(0.0, 2.0, 7)
    body = Relaxation(0.0, np.array([modulus]), np.array([tau]))
    dawson = 2.0 * modulus * v**1.5 * tau * (np.sqrt(t) - math.sqrt(tau) * dawsn(np.sqrt(t / tau)))
    assert ting(PARABOLOID, body, t, v * t).force == pytest.approx(dawson, rel=1e-12, abs=1e-15)
    slope = 0.5
    cone = 4.0 / (math.pi * slope) * modulus * v**2 * tau * (t + tau * np.expm1(-t / tau))
    assert ting(line_of(Cone(slope=slope)), body, t, v * t).force == pytest.approx(cone, rel=1e-12, abs=1e-15)
    springs = follow_springs(PARABOLOID, body, t, v * t, n=2000)
    assert springs.force == pytest.approx(dawson, rel=5e-6, abs=1e-15)


def test_kelvin_and_voigt():
    shear, eta, v = 0.7, 0.3, 0.2
    body = Relaxation(4.0 * shear, np.zeros(0), np.zeros(0), 4.0 * eta)
    t = np.linspace(0.0, 1.0, 9)
    d = v * t
    a = np.sqrt(d)
    exact = 8.0 * (2.0 / 3.0 * shear * d * a + eta * v * a)
    assert ting(PARABOLOID, body, t, d).force == pytest.approx(exact, rel=1e-12)
    errors = [abs(follow_springs(PARABOLOID, body, t, d, n=n).force - exact).max() for n in (100, 200, 400)]
    assert (orders(errors) > 1.7).all()
    assert errors[-1] < 1e-4 * exact[-1]
    # the springs release at G w + eta w' = 0, then creep back as exp(-G t / eta)
    back = follow_springs(PARABOLOID, body, [0.0, 1.0, 1.0 + 1e-6, 2.0], [0.0, 0.2, 0.2 - 1e-3, -1.0], n=400)
    assert back.force[2] == 0.0
    x, w, q = line_state(back.state, body)
    inside = x < 0.4
    assert w[inside] == pytest.approx((0.2 - x[inside] ** 2) * math.exp(-shear / eta * 1.0), rel=1e-2)
    assert not q.any()


def test_flat_punch_relaxes_as_its_modulus():
    punch = line_of(FlatPunch(radius=0.5))
    rows = follow_springs(punch, STANDARD, [0.0, 0.0, 0.5, 3.0], [0.0, 0.1, 0.1, 0.1], n=50)
    assert rows.force[1:] == pytest.approx(2.0 * 0.5 * 0.1 * STANDARD([0.0, 0.5, 3.0]), rel=1e-12)
    assert rows.contact_radius[1:] == pytest.approx([0.5, 0.5, 0.5])
    assert ting(punch, STANDARD, [0.0, 0.0, 0.5, 3.0], [0.0, 0.1, 0.1, 0.1]).force == pytest.approx(
        rows.force
    )
    followed = follow_loads(punch, STANDARD, [0.0, 0.9], [0.2, 0.2], n=50)
    exact = creep(punch, STANDARD, [0.0, 0.9], [0.2, 0.2])
    assert followed.indentation[0] == pytest.approx(0.2 / STANDARD.glassy, rel=1e-9)
    assert exact.indentation == pytest.approx(
        [0.2 / 5.2, 0.2 * (1.0 / 1.2 - (1.0 / 1.2 - 1.0 / 5.2) * math.exp(-0.9 / (0.4 * 5.2 / 1.2)))]
    )


def test_a_liquid_sinks_and_a_body_without_load_creeps_back():
    liquid = Relaxation(0.0, np.array([4.0]), np.array([0.5]))
    t = np.linspace(0.0, 20.0, 401)
    sunk = follow_loads(PARABOLOID, liquid, t, np.full(t.size, 0.1), n=2000)
    # (4/3) a^3 = F J(t), J = (1 + t / tau) / E
    a = (0.75 * 0.1 * (1.0 + t / 0.5) / 4.0) ** (1.0 / 3.0)
    assert sunk.contact_radius == pytest.approx(a, rel=3e-3)
    assert sunk.force == pytest.approx(np.full(t.size, 0.1), rel=1e-11)
    let_go = follow_loads(PARABOLOID, STANDARD, [0.0, 1.0, 1.1, 2.0, 200.0], [0.0, 0.1, 0.0, 0.0, 0.0], n=300)
    assert (let_go.force[2:] == 0.0).all()
    assert (np.diff(let_go.indentation[1:]) < 0.0).all()
    assert let_go.indentation[-1] == pytest.approx(0.0, abs=1e-4)
    assert let_go.stored[-1] == pytest.approx(0.0, abs=1e-12)


def test_creep_compliance_ends_at_the_rubbery_one():
    body = Relaxation(0.5, np.array([1.0, 3.0, 10.0]), np.array([0.01, 1.0, 300.0]))
    modes = modes_of(body)
    assert 1.0 / body.glassy + (modes.participation**2).sum() == pytest.approx(1.0 / body.rubbery, rel=1e-12)


@st.composite
def bodies(draw):
    n = draw(st.integers(0, 4))
    moduli = [draw(st.floats(0.05, 5.0)) for _ in range(n)]
    times = [10.0 ** draw(st.floats(-2.0, 2.0)) for _ in range(n)]
    equilibrium = draw(st.sampled_from([0.0, 1.0, 0.1]))
    viscosity = draw(st.sampled_from([0.0, 0.0, 0.5]))
    if n == 0 and equilibrium == 0.0:
        equilibrium = 1.0
    return Relaxation(equilibrium, np.array(moduli), np.array(times), viscosity)


@st.composite
def paths(draw):
    m = draw(st.integers(2, 7))
    t = np.concatenate([[0.0], np.cumsum([10.0 ** draw(st.floats(-1.5, 1.5)) for _ in range(m)])])
    d = np.array([0.0, *(draw(st.floats(-0.3, 1.0)) for _ in range(m))])
    return t, d


@settings(deadline=None, max_examples=examples(60))
@given(bodies(), paths(), st.floats(1e-6, 1e6))
def test_energy_and_scales_of_random_histories(body, path, scale):
    t, d = path
    rows = follow_springs(PARABOLOID, body, t, d, n=60)
    size = max(rows.work.max(), rows.dissipated.max(), 1e-9)
    assert (np.diff(rows.dissipated) >= -1e-14 * size).all()
    assert (rows.stored >= -1e-14 * size).all()
    assert rows.work - rows.stored - rows.dissipated == pytest.approx(np.zeros(t.size), abs=1e-9 * size)
    assert (rows.force >= -1e-12).all()
    slower = Relaxation(body.equilibrium, body.moduli, scale * body.times, scale * body.viscosity)
    again = follow_springs(PARABOLOID, slower, scale * t, d, n=60)
    assert again.force == pytest.approx(rows.force, rel=1e-6, abs=1e-8)


@settings(deadline=None, max_examples=examples(60))
@given(bodies(), paths(), st.data())
def test_legs_and_rows_between_change_nothing(body, path, data):
    t, d = path
    whole = follow_springs(PARABOLOID, body, t, d, n=60)
    cut = data.draw(st.integers(1, t.size - 1))
    first = follow_springs(PARABOLOID, body, t[:cut], d[:cut], n=60)
    if first.state.springs is None or d[:cut].max() == d.max():  # else the springs are others
        second = follow_springs(PARABOLOID, body, t[cut:], d[cut:], first.state, n=60)
        assert second.force == pytest.approx(
            whole.force[cut:], rel=1e-6, abs=1e-7 * max(whole.force.max(), 1e-9)
        )
    between = np.unique(np.concatenate([t, np.linspace(t[0], t[-1], 50)]))
    dense = follow_springs(PARABOLOID, body, between, np.interp(between, t, d), n=60)
    at = np.searchsorted(between, t)
    assert dense.state.deflection == pytest.approx(whole.state.deflection, abs=1e-7)
    assert dense.dissipated[at] == pytest.approx(whole.dissipated, rel=1e-6, abs=1e-8)


BLOCK = 16
"""Springs so few that none moves as one with others."""


def alone(curve, springs, body, t, d):
    """Histories of springs that each move by themselves, in blocks of few, with their loads."""
    for low in range(0, springs.position.size, BLOCK):
        names = ("position", "height", "stiffness", "centre", "outer")
        block = replace(
            springs, **{name: getattr(springs, name)[low : low + BLOCK] for name in names}, limit=math.inf
        )
        size, passed = block.position.size, []
        state = MemoryState(
            float(t[0]), 0.0, block, np.zeros(size), np.zeros((size, body.moduli.size)), np.ones(size)
        )
        rows = follow_springs(
            curve, body, t, d, state, watch=lambda passage, kept=passed: kept.append(passage.load[1:].copy())
        )
        yield rows, np.concatenate(passed)


@settings(deadline=None, max_examples=examples(40))
@given(
    bodies(),
    st.lists(
        st.tuples(st.sampled_from([-1.5, -1.0, 0.0, 0.5, 1.0]), st.booleans(), st.floats(0.02, 1.0)),
        min_size=3,
        max_size=14,
    ),
    st.sampled_from([math.inf, 0.0, 0.3, 10.0]),
    st.floats(-9.0, 1.0),
)
def test_springs_that_move_as_one_bear_what_each_does(body, rows, machine, decades):
    """Rows of any duration, of none too, far from and near the edge; lengths from nanometres to metres."""
    size = 10.0**decades
    wait = np.array([0.0 if sudden else 10.0**decade for decade, sudden, _ in rows])
    t, depth = np.append(0.0, np.cumsum(wait)), size * np.array([0.0, *(fraction for *_, fraction in rows)])
    if body.viscosity > 0.0:  # a dashpot moves nowhere in no time, and takes any load then
        for row in np.flatnonzero(wait == 0.0):
            depth[row + 1] = depth[row]
    curve, passed = line_of(Paraboloid(size)), []

    def watch(passage):
        passed.append(passage.load[1:].copy())

    if machine == math.inf:
        result = follow_springs(curve, body, t, depth, n=150, watch=watch)
    elif machine == 0.0:
        result = follow_loads(curve, body, t, depth * size, n=150, watch=watch)
    else:
        result = follow_travels(curve, body, t, depth, machine * size, n=150, watch=watch)
    springs = result.state.springs
    if springs is None:
        return
    depths = result.indentation.copy()
    if body.viscosity > 0.0:  # a row of no duration is found to rounding
        for row in np.flatnonzero(wait == 0.0):
            assert depths[row + 1] == pytest.approx(depths[row], rel=1e-13)
            depths[row + 1] = depths[row]
    each = list(alone(curve, springs, body, t, depths))
    # springs that were added on the way are not in what was told before
    loads, bears = (
        np.zeros((t.size, springs.position.size)),
        np.concatenate([load for _, load in each], axis=1),
    )
    done = 0
    for part in passed:
        loads[done : done + part.shape[0], : part.shape[1]] = part
        done += part.shape[0]
    np.testing.assert_allclose(loads, bears, rtol=0.0, atol=1e-11 * np.abs(bears).max())
    whole = max(sum(one.work for one, _ in each).max(), result.dissipated.max(), 1e-300)
    for name in ("stored", "dissipated", "work"):
        own = sum(getattr(one, name) for one, _ in each)
        np.testing.assert_allclose(getattr(result, name), own, rtol=0.0, atol=1e-11 * whole)
    # a dashpot takes the load of a row of no duration; what the edge adds is told where it lies within a block
    count = (bears > 0.0).sum(axis=1)
    known = np.append(True, wait > 0.0) | (body.viscosity == 0.0)
    if machine < math.inf and body.viscosity == 0.0:
        force = bears @ springs.stiffness
    else:
        force = sum(one.force for one, _ in each)
        known &= (count == 0) | ((count % BLOCK > 2) & (count % BLOCK < BLOCK - 1))
    np.testing.assert_allclose(result.force[known], force[known], rtol=0.0, atol=1e-11 * result.force.max())


def stepped(body, heights, t, d, parts):
    """Springs by small steps: a trial in contact, given up where it pulls."""
    w = np.zeros(heights.size)
    h = np.zeros((heights.size, body.moduli.size))
    for t0, t1, d0, d1 in zip(t[:-1], t[1:], d[:-1], d[1:], strict=True):
        dt = (t1 - t0) / parts
        decay = np.exp(-dt / body.times)
        mean = body.moduli * (1.0 - decay) / (dt / body.times)
        stiff = body.equilibrium + mean.sum() + body.viscosity / dt
        for k in range(parts):
            depth = d0 + (d1 - d0) * (k + 1) / parts
            old = body.equilibrium * w + h @ decay
            dw = np.maximum(-old / stiff, depth - heights - w)
            h = h * decay + dw[:, None] * mean
            w = w + dw
    return w


@settings(deadline=None, max_examples=examples(25))
@given(bodies(), paths())
def test_against_small_steps(body, path):
    t, d = path
    rows = follow_springs(PARABOLOID, body, t, d, n=25)
    if rows.state.springs is None:
        return
    coarse, fine = (stepped(body, rows.state.springs.height, t, d, parts) for parts in (400, 1600))
    assert rows.state.deflection == pytest.approx(fine, abs=1e-6 + 4.0 * abs(coarse - fine).max())


def test_forces_and_machines_end_where_indentations_do():
    t = np.linspace(0.0, 3.0, 61)
    d = 0.05 * (1.2 - np.cos(4.0 * t)) - 0.01
    moved = follow_springs(PARABOLOID, STANDARD, t, d, n=500)
    assert moved.force.min() >= 0.0
    stiffness = 0.7
    machine = follow_travels(PARABOLOID, STANDARD, t, d + moved.force / stiffness, stiffness, n=500)
    assert machine.indentation == pytest.approx(d, abs=2e-6)
    assert machine.work - machine.stored - machine.dissipated == pytest.approx(np.zeros(61), abs=1e-13)
    loaded = np.maximum(moved.force, 1e-3)
    pressed = follow_loads(PARABOLOID, STANDARD, t, loaded, n=500)
    assert pressed.force == pytest.approx(loaded, rel=1e-11)
    assert pressed.work - pressed.stored - pressed.dissipated == pytest.approx(np.zeros(61), abs=1e-13)


@settings(deadline=None, max_examples=examples(30))
@given(
    body=bodies(),
    shape=st.sampled_from([Paraboloid(1.0), Cone(slope=0.3)]),
    decades=st.lists(st.floats(-6.0, 6.0), min_size=2, max_size=4),
)
def test_loads_over_many_decades(body, shape, decades):
    line = line_of(shape)
    loads = np.concatenate([10.0**decade * np.arange(1.0, 21.0) / 20.0 for decade in sorted(decades)])
    loads = np.maximum.accumulate(loads)
    time = np.arange(1.0, loads.size + 1.0)
    state = None
    depths = []
    for at, part in zip(np.split(time, len(decades)), np.split(loads, len(decades)), strict=True):
        computed = follow_loads(line, body, at, part, state or virgin(), n=200)
        state = computed.state
        depths.append(computed.indentation)
    exact = creep(line, body, np.append(0.0, time), np.append(0.0, loads)).indentation[1:]
    assert np.concatenate(depths) == pytest.approx(exact, rel=0.2)  # the rows are coarse
    doublings = math.log2(exact[-1] / exact[0])
    assert state.springs.position.size < 300 + 200 * doublings
    back = follow_loads(line, body, [time[-1] + 1.0, time[-1] + 2.0], [loads[0], loads[0]], state, n=200)
    work = back.work - back.stored - back.dissipated
    assert work == pytest.approx(np.zeros(2), abs=1e-12 * state.work)


@settings(deadline=None, max_examples=examples(30))
@given(
    body=bodies(),
    shape=st.sampled_from([Paraboloid(1.0), Cone(slope=0.3), FlatPunch(1.0)]),
    before=st.floats(-12.0, 1.0),
    load=st.floats(-6.0, 0.0),
)
def test_separated_bodies_touch_before_a_force_presses(body, shape, before, load):
    line, force, t = line_of(shape), 10.0**load * np.arange(1.0, 6.0), np.arange(1.0, 6.0)
    at_once = follow_loads(line, body, t, force, virgin(), n=200)
    away = follow_springs(line, body, [0.0, 1e-3], [0.0, -(10.0**before)]).state
    later = follow_loads(line, body, t + 1e-3, force, away, n=200)
    assert later.indentation == pytest.approx(at_once.indentation, rel=1e-9)
    assert later.dissipated == pytest.approx(at_once.dissipated, rel=1e-8, abs=1e-12 * at_once.work[-1])


def test_a_spike_of_force_leaves_the_known_profile_alone():
    r = np.linspace(0.0, 1.0, 200)
    line = line_of(Sampled(r, 0.5 * r**2))
    liquid = Relaxation(0.0, np.array([4.0]), np.array([1.0]))
    spike = follow_loads(line, liquid, [0.0, 1e-3, 2e-3, 1e4], [0.0, 0.5, 1e-9, 1e-9])
    assert np.isfinite(spike.indentation).all()
    free = follow_loads(PARABOLOID, liquid, [0.0, 1e-3, 2e-3, 1e4], [0.0, 0.5, 1e-9, 1e-9])
    assert spike.indentation == pytest.approx(free.indentation, rel=1e-5)
    deeper = follow_loads(line, liquid, [0.0, 1e-3, 2e-3], [0.0, 0.5, 2.5])
    assert 0.5 < deeper.indentation[-1] < 1.0
    with pytest.raises(ConvergenceError, match="no disk contact under 1 kN up to r = 1 m"):
        follow_loads(line, liquid, [0.0, 1.0], [0.0, 1e3])


def test_what_cannot_be_followed():
    with pytest.raises(PathError, match="must not decrease"):
        follow_springs(PARABOLOID, STANDARD, [0.0, 1.0, 0.5], [0.0, 0.1, 0.2])
    with pytest.raises(PathError, match="turns more than once"):
        ting(PARABOLOID, STANDARD, [0.0, 1.0, 2.0, 3.0], [0.0, 0.1, 0.05, 0.1])
    with pytest.raises(PathError, match="needs an infinite force"):
        follow_springs(PARABOLOID, Relaxation(1.0, [], [], 1.0), [0.0, 0.0], [0.0, 0.1])
    with pytest.raises(PathError, match="pulls"):
        follow_loads(PARABOLOID, STANDARD, [0.0, 1.0], [0.0, -0.1])


@st.composite
def wide_bodies(draw):
    n = draw(st.integers(1, 8))
    times = [10.0 ** draw(st.floats(-12.0, 4.0)) for _ in range(n)]
    if draw(st.booleans()):
        times.append(times[0])
    moduli = [10.0 ** draw(st.floats(-3.0, 3.0)) for _ in times]
    equilibrium = draw(st.sampled_from([0.0, 1e-6, 1.0]))
    viscosity = draw(st.sampled_from([0.0, 1e-9, 1e-3, 10.0]))
    return Relaxation(equilibrium, np.array(moduli), np.array(times), viscosity)


@settings(deadline=None, max_examples=examples(60))
@given(wide_bodies(), st.integers(0, 2**32 - 1))
def test_modes_keep_their_digits_over_many_decades(body, seed):
    modes = modes_of(body)
    q = modes.to_modes[:, :-1] * np.sqrt(body.moduli)  # of u = h/sqrt(E), and sqrt(E_inf) w beside a dashpot
    if body.viscosity > 0.0:
        if body.equilibrium > 0.0:
            q = np.column_stack([q, modes.to_modes[:, -1] / math.sqrt(body.equilibrium)])
        assert q @ q.T == pytest.approx(np.eye(q.shape[0]), abs=1e-12)
    assert (modes.rates > 0.0).all()
    # the creep of the modes is that of the springs and dashpots: 1/E* of a real s, whose terms have one sign
    s = 10.0 ** np.linspace(-16.0, 16.0, 33)[:, None]
    creep_of = (modes.participation**2 * (modes.rates / (s + modes.rates))).sum(axis=1)
    if body.viscosity == 0.0:
        creep_of += 1.0 / body.glassy
    if body.equilibrium == 0.0:
        creep_of += 1.0 / (s[:, 0] * ((body.moduli * body.times).sum() + body.viscosity))
    modulus = body.equilibrium + (body.moduli * (s * body.times / (1.0 + s * body.times))).sum(axis=1)
    assert creep_of * (modulus + body.viscosity * s[:, 0]) == pytest.approx(np.ones(33), abs=1e-10)
    # what the forces of a free spring are comes back from its modes, and their energy is that of its branches
    rng = np.random.default_rng(seed)
    h, w = rng.normal(size=body.moduli.size) * body.moduli, float(rng.normal())
    size, energy = np.abs(h).max(), float((h**2 / body.moduli).sum())
    if body.viscosity == 0.0 and body.equilibrium > 0.0:
        w = -float(h.sum()) / body.equilibrium
    elif body.viscosity == 0.0:
        h -= h.sum() * body.moduli / body.moduli.sum()
    amplitudes = modes.to_modes @ np.append(h, w)
    assert modes.to_branches @ amplitudes == pytest.approx(h, abs=1e-10 * size)
    stored = 0.5 * float((h**2 / body.moduli).sum() + body.equilibrium * w * w)
    assert 0.5 * float((amplitudes**2).sum()) == pytest.approx(stored, rel=1e-10, abs=1e-20 * energy)


def parts_of(body, t, d, n=20, line=PARABOLOID):
    """The most parts in which a spring was moved in a row, on average over the springs."""
    results = []
    follow = row_kernels.follow

    def counted(run, course, begin, states, rows, *others):
        followed = follow(run, course, begin, states, rows, *others)
        results.append(rows[:, kernels.PARTS].max() / len(states[0]))
        return followed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(row_kernels, "follow", counted)
        follow_springs(line, body, t, d, n=n)
    return max(results, default=0.0)


@settings(deadline=None, max_examples=examples(60))
@given(wide_bodies(), paths(), st.floats(-9.0, 3.0))
def test_the_work_of_a_step_is_bounded(body, path, unit):
    t, d = path
    assert parts_of(body, 10.0**unit * t, d) < 2000


def test_springs_that_part_as_slowly_as_they_creep_back_are_not_touched_again_by_rounding():
    # beside a dashpot a spring parts with the speed of the indentation, and the gap opens as the square of time
    body = Relaxation(
        0.1,
        np.array([5.0, 0.9782624123, 5.0, 0.0554431904]),
        np.array([10.3643138, 0.01, 0.1, 10.0]),
        0.5,
    )
    t = np.array([0.0, 0.54629793, 0.57792071, 16.54322035, 16.64322035, 16.67484312, 48.29761972])
    d = np.array([0.0, -0.05782241, 1.0, 1.0, 1.0, 1.0, 0.0])
    assert parts_of(body, t, d, 60) < 500
    times = np.logspace(np.log10(1.3138e-9), np.log10(1.047e-4), 22)
    moduli = times**-0.13
    fast = Relaxation(0.01, moduli / moduli.sum(), times, 33.258)
    for retreat in np.linspace(1.5e4, 3.5e4, 9):
        t = np.linspace(0.0, retreat, 131)
        assert parts_of(fast, t, 0.3 * np.sin(math.pi * t / retreat)) < 500


@settings(deadline=None, max_examples=examples(40))
@given(
    body=bodies(),
    loads=st.lists(st.sampled_from([0.0, 0.0, 0.3, 1.0]), min_size=2, max_size=6),
    unit=st.floats(-9.0, 3.0),
    data=st.data(),
)
def test_bodies_that_rest_on_each_other_are_loaded_again(body, loads, unit, data):
    waits = [10.0 ** (unit + data.draw(st.floats(-3.0, 1.0))) for _ in loads]
    time, force = np.cumsum([1e-3 * 10.0**unit, *waits]), 1e-3 * np.array([1.0, *loads])
    result = follow_loads(PARABOLOID, body, time, force, virgin(), n=40)
    assert result.force == pytest.approx(force, rel=1e-9, abs=1e-15)
    kept = result.stored + result.dissipated
    assert result.work == pytest.approx(kept, rel=1e-9, abs=1e-13 * np.max(kept))
    without = force[1:] == 0.0
    assert (np.diff(result.indentation)[without] <= 1e-15).all()
    assert (result.indentation >= 0.0).all()


SHAPES = [Paraboloid(1.0), Cone(slope=0.3), FlatPunch(0.3), PowerLaw(exponent=4, height=1.0, radius=1.0)]
ROWS = st.lists(
    st.tuples(st.one_of(st.none(), st.floats(-2.0, 1.0)), st.sampled_from([0.0, 0.02, 0.3, 0.5, 0.7, 1.0])),
    min_size=2,
    max_size=20,
)
"""Decades of the duration of a row in s, None in no time, and its load."""


def loaded(rows, unit):
    """Times and loads of rows."""
    wait = [0.0 if decade is None else 10.0 ** (unit + decade) for decade, _ in rows]
    return np.cumsum([10.0**unit, *wait]), np.array([0.5, *(load for _, load in rows)])


def random_body(numbers):
    """A body of up to five branches, with a dashpot or not."""
    n, equilibrium = int(numbers.integers(0, 5)), float(numbers.choice([0.0, 1.0]))
    moduli, times = numbers.uniform(0.1, 3.0, n), 10.0 ** numbers.uniform(-2.0, 2.0, n)
    return Relaxation(equilibrium if n else 1.0, moduli, times, float(numbers.choice([0.0, 0.3])))


@settings(deadline=None, max_examples=examples(60))
@given(ROWS, st.integers(0, 2**32 - 1), st.sampled_from(SHAPES), st.sampled_from([0.0, 0.3, 10.0]))
def test_energy_of_random_loads_also_in_no_time(rows, seed, shape, machine):
    """Loads that jump where springs just part; deeper ones than expected, for which springs are added on the way."""
    body, (t, load) = random_body(np.random.default_rng(seed)), loaded(rows, 0.0)
    if machine > 0.0:
        result = follow_travels(line_of(shape), body, t, load, machine, n=40)
    else:
        result = follow_loads(line_of(shape), body, t, load, n=40)
        assert result.force == pytest.approx(load, rel=1e-9, abs=1e-12)
    kept = result.stored + result.dissipated
    assert result.work == pytest.approx(kept, rel=1e-9, abs=1e-12 * np.max(np.abs(kept)))


def test_a_load_that_falls_in_no_time_leaves_springs_free_whatever_the_rounding_of_their_gap():
    numbers = np.random.default_rng(0)
    for _ in range(100):
        body = replace(random_body(numbers), viscosity=0.3)
        line = line_of(SHAPES[numbers.integers(4)])
        t = np.repeat(np.cumsum(10.0 ** numbers.uniform(-2.0, 1.0, 6)), 2)
        result = follow_loads(line, body, t, np.maximum(numbers.normal(0.3, 0.4, 12), 0.0), n=300)
        kept = result.stored + result.dissipated
        assert result.work == pytest.approx(kept, rel=1e-9, abs=1e-12 * np.max(kept))


@settings(deadline=None, max_examples=examples(20))
@given(ROWS, st.integers(0, 2**32 - 1), st.sampled_from(SHAPES), st.booleans())
def test_rows_without_force_are_not_divided_after_bodies_have_parted(rows, seed, shape, loads):
    """Held at zero force they creep back free of load; held at an indentation, springs would be touched again."""
    body, (t, load) = random_body(np.random.default_rng(seed)), loaded(rows, 0.0)
    goal = dividing.Goal(np.append(t, t[-1] + [1.0, 100.0]), np.append(load, [0.0, 0.0]), 0.0, 0.0)
    parts = dividing.parts_of(line_of(shape), body, goal, virgin(), tolerance=1e-3, loads=loads, n=40)
    counts = np.bincount(parts.row, minlength=goal.time.size)
    separated = (goal.target == 0.0) & (np.append(1.0, goal.target[:-1]) == 0.0)
    assert (counts[separated] == 1).all()
    assert counts.max() < 1000


def test_a_search_that_does_not_converge_ends():
    springs = springs_to(PARABOLOID, 0.1, 20)
    run, meet, start, first = histories.prepared_run(
        springs, STANDARD, modes_of(STANDARD), virgin(), 0.0, 0.0
    )
    run = run._replace(limit=math.inf)
    course, rows = np.array([[1.0], [math.nan], [0.0]]), np.zeros((1, kernels.COLUMNS))
    count = row_kernels.follow(
        run, course, start, (first, first.copy()), rows, np.zeros((3, 0, springs.position.size)), meet
    )
    assert (count, start[0]) == (row_kernels.STUCK, 1.0)


@settings(deadline=None, max_examples=examples(20))
@given(body=bodies(), size=st.floats(-9.0, 1.0), above=st.floats(0.0, 1.0))
def test_no_load_leaves_no_trace(body, size, above):
    radius = 10.0**size
    line, force = line_of(Paraboloid(radius)), 1e-3 * radius**2 * np.array([1.0, 0.5])
    rest = follow_loads(line, body, [0.5, 1.0], [0.0, 0.0], virgin(0.0, -above * radius), n=40)
    assert (rest.indentation == 0.0).all()
    result = follow_loads(line, body, [2.0, 3.0], force, rest.state, n=40)
    bare = follow_loads(line, body, [2.0, 3.0], force, virgin(1.0), n=40)
    assert result.indentation == pytest.approx(bare.indentation, rel=1e-12)


def test_large_errors_of_fields_under_few_rows_of_a_falling_force_say_what_reduces_them():
    soft = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
    contact = mdr.Contact(mdr.Paraboloid("1 mm"), soft)
    few, many = (
        mdr.solve(
            contact,
            mdr.load("0.3 mN", duration="1 s", steps=n) >> mdr.load("0.1 mN", duration="1 s", steps=n),
        ).claims["pressure"]
        for n in (1, 20)
    )
    assert few.error[-1] == 1.0
    assert "give more steps" in few.reason
    assert many.error[-1] < 0.01
    assert "give more steps" not in many.reason
