"""Contacts with memory, as they are solved: references, Ting against springs, energies, fields, limits."""

import math
from functools import reduce
from itertools import pairwise
from operator import rshift

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import pymdr as mdr
from common import REFERENCES
from drawing import examples
from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.memory import (
    LineState,
    MemoryCheck,
    MemorySurface,
    check_memory,
    displacement,
    memory_claims,
)
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import follow_springs, line_state
from pymdr.mapping.equivalent import equivalent_profile, gap_function
from pymdr.mapping.relaxation import Relaxation
from pymdr.solving.viscoelastic import SPRINGS, surface_with_memory

REFERENCES = {entry["id"]: entry for entry in REFERENCES}
SOLID = mdr.StandardSolid(equilibrium=0.3, modulus=1.0, time=0.4)
SHAPES = (mdr.Paraboloid(1.0), mdr.Cone(slope=0.3), mdr.PowerLaw(4.0, 0.2, 1.0))


def body(shear, poisson=0.5):
    return mdr.Viscoelastic(shear, poisson=poisson)


def pressed(shear, path, profile=SHAPES[0], **given_):
    return mdr.solve(mdr.Contact(profile, body(shear)), path, **given_)


def triangle(depth, steps, back=0.0):
    return mdr.indent(depth, duration=1.0, steps=steps) >> mdr.indent(back, duration=1.0, steps=steps)


def test_references_of_one_approach_and_one_retreat():
    entry = REFERENCES["ting_sls_parab"]
    result = pressed(SOLID, triangle(0.4, 10))
    rows = [round(10 * t) - 1 for t in entry["inputs"]["t"]]
    np.testing.assert_allclose(
        result["normal_force"].values[rows], entry["expected"]["F"], rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(
        result["contact_radius"].values[rows], entry["expected"]["a"], rtol=1e-9, atol=1e-12
    )
    assert result.claims["normal_force"].level is mdr.Level.EXACT
    assert any("Ting" in note for note in result.notes)
    maxwell = REFERENCES["maxwell_constvel"]
    computed = pressed(mdr.Maxwell(1.0, time=0.4), mdr.indent(0.36, duration=0.9))
    assert float(computed["normal_force"][-1]) == pytest.approx(maxwell["expected"]["F"], rel=1e-9)


def test_the_creep_under_a_load_that_is_there_at_once():
    expected = REFERENCES["sls_creep"]["expected"]
    result = pressed(SOLID, mdr.Path(time=[0.0, *np.linspace(0.01, 0.9, 90)], normal_force=np.full(91, 0.2)))
    for name, value in (("contact_radius", expected["a"]), ("indentation", expected["d"])):
        error = result.claims[name].error
        bound = float(np.max(error))
        assert float(result[name][-1]) == pytest.approx(value, rel=max(3.0 * bound, 1e-9))
        assert bound < 1e-4


@settings(max_examples=examples(12), deadline=None)
@given(
    terms=st.lists(
        st.tuples(st.floats(-2.0, 2.0), st.integers(-20, 10)),
        min_size=1,
        max_size=4,
        unique_by=lambda term: term[1],
    ),
    equilibrium=st.sampled_from([0.0, 0.01, 1.0, 10.0]),
    shape=st.sampled_from(SHAPES),
    depths=st.lists(st.floats(-0.05, 0.3), min_size=1, max_size=4),
)
def test_energy_is_stored_or_dissipated_on_any_path(terms, equilibrium, shape, depths):
    moduli, times = (10.0 ** np.array(column, dtype=float) for column in zip(*terms, strict=True))
    times **= 0.1
    path = mdr.indent(0.1, duration=1.0, steps=6)
    for d in depths:
        path = path >> mdr.indent(d, duration=0.7, steps=6)
    result = pressed(mdr.Prony(equilibrium, moduli, times), path, shape)
    work, stored, dissipated = (
        result.data[name].values for name in ("external_work", "elastic_energy", "dissipated_energy")
    )
    scale = np.abs(work).max() + stored.max()
    np.testing.assert_allclose(work, stored + dissipated, atol=1e-7 * scale)
    assert (np.diff(dissipated, prepend=0.0) >= -1e-9 * scale).all()
    assert (result["normal_force"].values >= -1e-9 * result["normal_force"].values.max()).all()


@settings(max_examples=examples(10), deadline=None)
@given(c=st.floats(-6.0, 6.0), size=st.floats(-9.0, 1.0), modulus=st.floats(-2.0, 12.0))
def test_units_of_time_length_and_modulus_change_nothing_else(c, size, modulus):
    c, size, modulus = 10.0**c, 10.0**size, 10.0**modulus
    path = mdr.indent(0.2, duration=1.0, steps=5) >> mdr.load(0.02, duration=0.5, steps=3)
    scaled = mdr.indent(0.2 * size, duration=c, steps=5) >> mdr.load(
        0.02 * modulus * size**2, duration=0.5 * c, steps=3
    )
    one = pressed(SOLID, path)
    shear = mdr.StandardSolid(equilibrium=0.3 * modulus, modulus=modulus, time=0.4 * c)
    other = pressed(shear, scaled, mdr.Paraboloid(size))
    for name, unit in (("normal_force", modulus * size**2), ("indentation", size), ("contact_radius", size)):
        np.testing.assert_allclose(other[name].values, one[name].values * unit, rtol=1e-7)


@pytest.mark.parametrize("shape", SHAPES)
def test_fast_is_glassy_and_slow_is_rubbery(shape):
    for duration, modulus in ((1e-9, 1.3), (1e9, 0.3)):
        path = mdr.indent(0.1, duration=duration, steps=4) >> mdr.indent(0.02, duration=duration, steps=4)
        result = pressed(SOLID, path, shape)
        elastic = mdr.solve(mdr.Contact(shape, mdr.Elastic(3.0 * modulus, 0.5)), path)
        np.testing.assert_allclose(result["normal_force"].values, elastic["normal_force"].values, rtol=1e-6)


def test_the_pressure_carries_the_force_and_the_gap_stays_open():
    result = pressed(SOLID, triangle(0.1, 20) >> mdr.indent(0.08, duration=0.3, steps=10))
    for row in (5, 19, 24, 45, 49):
        a = float(result["contact_radius"][row])
        t, w = np.polynomial.legendre.leggauss(200)
        angle = 0.25 * math.pi * (t + 1.0)
        r = a * np.sin(angle)
        p = result.field("pressure", r, row).values
        force = float(np.sum(0.25 * math.pi * w * a * np.cos(angle) * p * 2.0 * math.pi * r))
        assert force == pytest.approx(float(result["normal_force"][row]), rel=1e-4)
        assert p.min() > -1e-3 * p.max()
        outside = a * np.array([1.01, 1.2, 2.0, 4.0])
        gap = result.field("gap", outside, row).values
        assert (gap > -1e-4 * float(result["indentation"][row])).all()
        assert (np.diff(gap) > 0.0).all()


def test_kelvin_and_voigt():
    shear = mdr.KelvinVoigt(1.0, 0.1)
    result = pressed(
        shear, mdr.indent(0.1, duration=1.0, steps=20) >> mdr.indent(0.0, duration=1.0, steps=20)
    )
    d = result["indentation"].values[:20]
    exact = 8.0 * (2.0 / 3.0 * d + 0.1 * 0.1) * np.sqrt(d)
    np.testing.assert_allclose(result["normal_force"].values[:20], exact, rtol=1e-5)
    # the dashpot presses at the edge on the way in
    assert float(result.field("pressure", 0.9999 * math.sqrt(0.1), 19)[0]) > float(
        result.field("pressure", 0.99 * math.sqrt(0.1), 19)[0]
    )


def test_a_saved_result_follows_its_path_again(tmp_path):
    result = pressed(SOLID, triangle(0.1, 5))
    result.save(tmp_path / "rubber.nc")
    again = mdr.open_result(tmp_path / "rubber.nc")
    for name in ("pressure", "normal_displacement", "gap"):
        one, other = (each.field(name, [0.05, 0.4], 6).values for each in (result, again))
        np.testing.assert_array_equal(one, other)
    assert set(again.figures()) == {"section", "history", "loop", "fields"}
    again.plot()


def test_a_machine_and_two_bodies():
    rubber = body(SOLID)
    contact = mdr.Contact(mdr.Sphere(1.0), rubber, mdr.Elastic(50.0, 0.3))
    path = mdr.Path(time=[0.5, 1.0, 2.0], travel=[0.02, 0.05, 0.01])
    result = mdr.solve(contact, path, machine_stiffness=2.0)
    np.testing.assert_allclose(result["travel"].values, [0.02, 0.05, 0.01], rtol=1e-9)
    assert (result["indentation"].values <= result["travel"].values).all()


def test_bodies_that_never_touch():
    result = pressed(SOLID, mdr.indent(-0.1, duration=1.0, steps=2))
    assert result["normal_force"].values.tolist() == [0.0, 0.0]
    assert result["contact_radius"].values.tolist() == [0.0, 0.0]


@settings(max_examples=examples(10), deadline=None)
@given(st.lists(st.floats(-0.2, 0.0), min_size=1, max_size=8))
def test_a_record_that_begins_without_contact_is_one_approach(separated):
    d = np.array([*separated, 0.05, 0.1, 0.03, *separated])
    path = mdr.Path(time=np.arange(d.size, dtype=float), indentation=d)
    result = pressed(SOLID, path)
    assert any("Ting" in note for note in result.notes)
    n = len(separated)
    alone = pressed(SOLID, mdr.Path(time=np.arange(n + 3.0)[n - 1 :], indentation=d[n - 1 : n + 3]))
    np.testing.assert_allclose(
        result["normal_force"].values[n - 1 : n + 3], alone["normal_force"].values, rtol=1e-12
    )


@settings(max_examples=examples(10), deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(-7.0, -1.0), st.floats(0.01, 1.0), st.integers(1, 4)), min_size=2, max_size=5
    ),
)
@example([(-6.0, 1.0, 1), (-1.0, 1.0, 1)])
def test_legs_have_the_springs_of_the_deepest(legs):
    path = None
    for depth, duration, steps in legs:
        leg = mdr.indent(10.0**depth, duration=duration, steps=steps)
        path = leg if path is None else path >> leg
    parts = pressed(SOLID, path)
    rows = mdr.Path(time=parts["time"].values, indentation=parts["indentation"].values)
    whole = pressed(SOLID, rows)
    for name in ("normal_force", "contact_radius", "elastic_energy", "dissipated_energy"):
        scale = float(whole[name].max())
        np.testing.assert_allclose(parts[name].values, whole[name].values, rtol=0.0, atol=1e-11 * scale)
    depth = whole["indentation"].values
    relaxation = mdr.relaxation_of(body(SOLID))
    contact = mdr.Contact(SHAPES[0], body(SOLID))
    time, radius = (whole[name].values for name in ("time", "contact_radius"))
    surface = surface_with_memory(contact, relaxation, time, depth, radius)
    assert {state.position.size for state in surface.states(range(depth.size))} == {SPRINGS + 2}


@pytest.mark.parametrize("depth", [0.0, 5e-7])
def test_a_power_of_time_knows_how_long_a_leg_at_a_rate_takes(depth):
    law = mdr.PowerLawRheology("1 kPa", "1 s", 0.2)
    tip, press = mdr.Paraboloid("50 um"), mdr.load("1 uN", duration="10 ms", steps=20)
    slow = pressed(law, press >> mdr.indent(depth, rate="0.01 um/s", steps=40), tip)
    time = slow["time"].values
    split = pressed(law, press >> mdr.indent(depth, duration=time[-1] - time[19], steps=40), tip)
    for name in ("normal_force", "contact_radius", "indentation"):
        claimed = split.claims[name].error.max() * split[name].values.max()
        np.testing.assert_allclose(slow[name].values, split[name].values, rtol=0.0, atol=claimed)
    fields = [each.field("pressure", [1e-6, 5e-6], 25).values for each in (slow, split)]
    np.testing.assert_allclose(*fields, rtol=1e-4)


def test_what_is_refused():
    contact = mdr.Contact(mdr.Sphere(1.0), body(SOLID))
    with pytest.raises(PathError, match="duration or a rate"):
        mdr.solve(contact, mdr.indent(0.1))
    with pytest.raises(PathError, match="cannot be below 0 N"):
        mdr.solve(contact, mdr.load(-1.0, duration=1.0))
    with pytest.raises(
        PathError, match=r"-1 nN in row 2 of leg 1: .* in a measured record, begin at the contact point"
    ):
        mdr.solve(contact, mdr.Path(time=[1, 2], normal_force=[0.0, -1e-9]))
    with pytest.raises(PathError, match=r"^time begins at -0\.5 s, .* at 0 s: count times"):
        mdr.solve(contact, mdr.Path(time=[-0.5, 2], indentation=[0.0, 0.1]))
    with pytest.raises(ProblemError, match="no limit of short range"):
        mdr.Contact(mdr.Sphere(1.0), body(SOLID), adhesion=mdr.JKR(0.1))
    with pytest.raises(PathError, match="has no friction"):
        mdr.solve(contact, mdr.indent(0.1, duration=1.0) >> mdr.shift(0.1, duration=1.0))
    with pytest.raises(PathError, match="pressed in by its radius"):
        mdr.solve(contact, mdr.indent(1.5, duration=1.0))
    waves = mdr.Paraboloid(1.0) + mdr.Waviness(height=0.01, wavelength=0.1)
    with pytest.raises(ProblemError, match="decreases within the contact"):
        mdr.solve(mdr.Contact(waves, body(SOLID)), mdr.indent(0.1, duration=1.0))
    for study in (
        lambda: mdr.pull_off(contact),
        lambda: mdr.foundation(contact),
    ):
        with pytest.raises(ProblemError):
            study()


@st.composite
def memories(draw):
    n = draw(st.integers(1, 4))
    kernel = Relaxation(
        draw(st.sampled_from([0.0, 0.01, 1.0])),
        np.array([10.0 ** draw(st.floats(-2.0, 1.0)) for _ in range(n)]),
        np.array([10.0 ** draw(st.floats(-3.0, 3.0)) for _ in range(n)]),
    )
    turns = draw(st.integers(1, 7))
    waits = [10.0 ** draw(st.floats(-3.0, 3.0)) for _ in range(turns + 1)]
    depths = [draw(st.floats(-0.03, 0.1)) for _ in range(turns)]
    return kernel, np.append(0.0, np.cumsum(waits)), np.array([0.0, 0.1, *depths])


@settings(max_examples=examples(60), deadline=None)
@given(memory=memories(), shape=st.sampled_from((*SHAPES, mdr.PowerLaw(0.5, 0.2, 1.0))))
def test_a_rising_profile_is_a_disk_without_tension_or_overlap_whatever_its_past(memory, shape):
    kernel, time, depth = memory
    equivalent = equivalent_profile(shape)
    result = follow_springs(ElasticLine(equivalent, 1.0), kernel, time, depth, n=100)
    assert result.disk.all()
    x, w, q = line_state(result.state, kernel)
    assert (np.diff(w + equivalent.g(x)) >= -1e-8).all()
    assert (np.diff(q[q > 0.0]) <= 1e-8 * q.max()).all()


@settings(max_examples=8, deadline=None)
@given(depths=st.lists(st.integers(-100, 100), min_size=1, max_size=4), shape=st.sampled_from(SHAPES))
def test_what_is_claimed_is_a_number(depths, shape):
    body = mdr.Viscoelastic(mdr.Maxwell(1.0, time=1.0), poisson=0.5)
    path = mdr.Path(time=np.arange(1.0, len(depths) + 1.0), indentation=[1e-3 * d for d in depths])
    result = mdr.solve(mdr.Contact(shape, body), path)
    for name in result.claims.keys() & result.data.keys():
        assert np.isfinite(result.data[name].values[result.claims[name].where]).all()
    pressed = result.claims["effective_modulus"]
    assert pressed.where.tolist() == [depth > 0.0 for depth in depths]


@settings(max_examples=2, deadline=None)
@given(decades=st.floats(-3.0, 0.0), time=st.floats(-1.0, 3.0))
def test_where_a_path_ends_does_not_matter_to_how_it_begins(decades, time):
    body = mdr.Viscoelastic(mdr.Maxwell(1.0, time=10.0**time), poisson=0.5)
    contact, pressed = mdr.Contact(mdr.Paraboloid(1.0), body), mdr.load(1e-3, duration=1.0, steps=60)
    alone = mdr.solve(contact, pressed)["indentation"].values
    after = mdr.solve(contact, pressed >> mdr.indent(10.0**decades * alone[-1], duration=1.0))
    assert after["indentation"].values[:60] == pytest.approx(
        alone, rel=1e-5
    )  # springs lie a little elsewhere


@settings(max_examples=examples(30), deadline=None)
@given(size=st.floats(-320.0, 3.0), steep=st.floats(0.0, 1e3), unit=st.floats(-9.0, 3.0))
def test_an_almost_recovered_body_has_displacements(size, steep, unit):
    x = np.linspace(0.005, 0.995, 100)
    r = np.array([0.0, 0.3, 0.9, 1.2, 5.0])
    left = np.exp(-steep * x)
    one = displacement(LineState(x, left, np.zeros(100), 0.0), r)
    two = displacement(LineState(10.0**unit * x, 10.0**size * left, np.zeros(100), 0.0), 10.0**unit * r)
    assert two == pytest.approx(10.0**size * one, rel=1e-9, abs=1e-310)


@settings(max_examples=6, deadline=None)
@given(memory=memories(), shape=st.sampled_from(SHAPES))
def test_fields_err_as_their_claims_say(memory, shape):
    kernel, time, depth = memory
    rows = np.linspace(0.0, time.size - 1.0, 6 * time.size)[1:]
    time, depth = (np.interp(rows, np.arange(time.size), values) for values in (time, depth))
    equivalent = equivalent_profile(shape)
    line, gap = ElasticLine(equivalent, 1.0), gap_function(shape, equivalent)
    radius = follow_springs(line, kernel, np.append(0.0, time), np.append(0.0, depth), n=1000)
    few, many = (
        MemorySurface(equivalent, kernel, gap, time, depth, radius.contact_radius[1:], n)
        for n in (1000, 6000)
    )
    check = check_memory(few, None)
    assert check.violated is None
    for row in (5, int(np.argmax(depth))):
        a = float(few.contact_radius[row])
        for name, r in (
            ("pressure", a * np.linspace(0.05, 0.95, 30)),
            ("normal_displacement", a * np.linspace(1.0, 3.0, 30)),
        ):
            one, other = (surface.field(name, r, row) for surface in (few, many))
            error = np.max(np.abs(one - other)) / np.max(np.abs(other))
            assert error <= 3.0 * check.error(name, time.size)[row] + 1e-4


@settings(max_examples=6, deadline=None)
@given(
    shape=st.sampled_from(SHAPES[:3]),
    legs=st.lists(st.tuples(st.floats(-9.0, -1.0), st.floats(-6.0, 3.0)), min_size=2, max_size=4),
)
@example(SHAPES[0], [(-8.0, -4.0), (-6.0, -1.0), (-1.0, 0.0)])
def test_contacts_of_all_sizes_in_one_history_are_disks(shape, legs):
    path = None
    for depth, duration in legs:
        leg = mdr.indent(10.0**depth, duration=10.0**duration, steps=2)
        path = leg if path is None else path >> leg
    claim = pressed(SOLID, path, shape).claims["pressure"]
    assert claim.where.all()
    growing = np.maximum.accumulate(np.repeat([d for d, _ in legs], 2)) == np.repeat([d for d, _ in legs], 2)
    assert (claim.error[growing] < 0.02).all()


def test_nothing_is_claimed_after_a_finding():
    rows, size = np.array([2, 5, 8, 11]), 12
    none, all_rows = np.full(4, -1.0), np.ones(size, dtype=bool)
    errors = dict.fromkeys(("pressure",), np.array([1e-6, 1e-3, 1e-6, 1e-6]))
    names = ("normal_force", "contact_radius", "indentation")
    sure = np.zeros((4, 2))
    good = MemoryCheck(rows, none, none, errors, sure)
    assert memory_claims(names, all_rows, ~all_rows, all_rows, good, "")["contact_radius"].where.all()
    assert good.error("pressure", size)[[1, 3, 6, 9]].tolist() == [1e-6, 1e-3, 1e-3, 1e-6]
    pulls, overlaps = np.array([-1.0, -1.0, 0.1, 0.2]), np.array([0.01, -1.0, -1.0, -1.0])
    for tension, overlap, first, words in ((pulls, none, 6, "tension"), (none, overlaps, 2, "overlap")):
        check = MemoryCheck(rows, tension, overlap, errors, sure)
        claims = memory_claims(names, all_rows, ~all_rows, all_rows, check, "")
        assert claims["contact_radius"].where.tolist() == [True] * first + [False] * (size - first)
        assert words in claims["contact_radius"].reason
        assert claims["indentation"].where.all()
        checked = MemoryCheck(rows, tension, overlap, errors, sure + 0.1)
        assert checked.violated is None, "springs too few to tell"
    ring = all_rows.copy()
    ring[4] = False
    assert memory_claims(names, ring, ~all_rows, ~all_rows, good, "")["normal_force"].where.sum() == 4


def test_a_surface_that_was_left_sinks_on_its_axis_too():
    result = pressed(SOLID, mdr.indent(0.1, duration=0.1) >> mdr.indent(-0.1, duration=0.1, steps=4))
    u = result.field("normal_displacement", np.array([0.0, 1e-6]), -1).values
    assert u[0] == pytest.approx(u[1], rel=1e-4)
    assert u[0] > 0.0


@pytest.mark.parametrize(
    "shape",
    [
        mdr.TruncatedCone(slope=0.3, flat_radius=0.1),
        mdr.TruncatedParaboloid(flat_radius=0.1, radius=1.0),
        mdr.Cone(slope=0.3),
        mdr.PowerLaw(8.0, 0.2, 1.0),
    ],
)
def test_a_sudden_press_has_the_elastic_pressure(shape):
    path = mdr.Path(time=[0.0], indentation=[0.1])
    result = pressed(mdr.Maxwell(1.0, time=1.0), path, shape)
    elastic = mdr.solve(mdr.Contact(shape, mdr.Elastic(3.0, 0.5)), mdr.indent(0.1))
    r = float(elastic["contact_radius"][0]) * np.linspace(0.02, 0.97, 50)
    r = r[np.abs(r / 0.1 - 1.0) > 0.01]
    one, other = (each.field("pressure", r, -1).values for each in (result, elastic))
    bound = max(1e-5, 3.0 * float(result.claims["pressure"].error[0]))
    assert np.max(np.abs(one - other)) < min(bound, 3e-3) * np.max(other)


def test_the_surface_around_a_flat_punch_sinks_as_on_an_elastic_body():
    path = mdr.Path(time=[0.0], indentation=[0.1])
    result = pressed(mdr.Maxwell(1.0, time=1.0), path, mdr.FlatPunch(radius=0.3))
    r = 0.3 * np.array([1.001, 1.1, 2.0, 5.0])
    exact = 2.0 / math.pi * 0.1 * np.arcsin(0.3 / r)
    np.testing.assert_allclose(result.field("normal_displacement", r, -1).values, exact, rtol=1e-6)


@settings(max_examples=examples(15), deadline=None)
@given(
    steps=st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(-2.0, 2.0)), min_size=1, max_size=4),
    shear=st.sampled_from([SOLID, mdr.KelvinVoigt(0.5, 0.3), mdr.Maxwell(2.0, time=0.5)]),
)
def test_forces_that_do_not_fall_need_no_springs(steps, shear):
    """a^3 = (3 R/16) int J(t - s) dF(s) of an incompressible body under a paraboloid, by quadrature."""
    force = 0.01 + np.cumsum([rise for rise, _ in steps])
    waits = [10.0**wait for _, wait in steps]
    path = [mdr.load(f, duration=wait) for f, wait in zip(force, waits, strict=True)]
    result = pressed(shear, reduce(rshift, path))
    t = np.append(0.0, np.cumsum(waits))
    rate = np.diff(force, prepend=0.0) / waits
    grown = [
        sum(
            rate[k] * quad(lambda s, now=now: float(shear.creep(now - s)), t[k], t[k + 1])[0]
            for k in range(i + 1)
        )
        for i, now in enumerate(t[1:])
    ]
    radius = np.cbrt(3.0 / 16.0 * np.array(grown))
    assert result["contact_radius"].values == pytest.approx(radius, rel=1e-6)
    assert result["indentation"].values == pytest.approx(radius**2, rel=1e-6)


@st.composite
def forced(draw):
    """A body, and forces, some of them 0, of legs that may last far longer than the body takes to relax."""
    times = draw(st.lists(st.floats(-2.0, 1.0), min_size=1, max_size=3, unique_by=lambda x: round(x, 1)))
    moduli = draw(st.lists(st.floats(0.1, 5.0), min_size=len(times), max_size=len(times)))
    shear = mdr.Prony(draw(st.sampled_from([0.0, 0.05, 1.0])), moduli, [10.0**x for x in times])
    if draw(st.booleans()):
        shear = mdr.KelvinVoigt(draw(st.floats(0.05, 2.0)), draw(st.floats(0.01, 10.0)))
    force = st.one_of(st.just(0.0), st.floats(-3.0, -1.0).map(lambda x: 10.0**x))
    forces = [0.01, *draw(st.lists(force, max_size=3))]
    durations = [10.0 ** draw(st.floats(-1.0, 1.5)) for _ in forces]
    return shear, list(zip(forces, durations, strict=True))


@settings(max_examples=examples(12), deadline=None)
@given(
    forced(),
    st.sampled_from([mdr.Paraboloid(1.0), mdr.Cone(slope=0.3), mdr.PowerLaw(4, 1.0, 1.0)]),
    st.sampled_from([None, 0.1, 10.0]),
)
@example(
    # falls to 0 over 150 relaxation times
    (mdr.Prony(0.0466, [0.0744], [0.0165]), [(2.962269e-3, 0.738284), (0.0, 2.503456)]),
    mdr.Paraboloid(1.0),
    None,
)
def test_few_rows_of_forces_err_as_claimed(memory, shape, stiffness):
    shear, legs = memory

    def solved(steps):
        if stiffness is None:
            path = [mdr.load(force, duration=duration, steps=steps) for force, duration in legs]
            return pressed(shear, reduce(rshift, path), shape)
        path = [mdr.travel(2.0 * force, duration=duration, steps=steps) for force, duration in legs]
        return pressed(shear, reduce(rshift, path), shape, machine_stiffness=stiffness)

    few, many = solved(1), solved(48)
    for name in ("indentation", "contact_radius", "elastic_energy", "dissipated_energy", "external_work"):
        values, others = few.data[name].values, many.data[name].values[47::48]
        own, others_own = few.claims[name].error, many.claims[name].error[47::48]
        size = float(np.max(np.abs(values)))
        known = (own < 1.0) & (others_own < 1.0)
        claimed = own * np.abs(values)
        difference, rest = np.abs(values - others), others_own * np.abs(others)
        assert (difference <= claimed + rest + 1e-12 * size)[known & (values != 0.0)].all()
        assert claimed.max() <= 0.05 * size
        if name == "indentation":
            assert claimed.max() <= 1e3 * max(difference.max(), 1e-5 * size)


@settings(deadline=None, max_examples=examples(6))
@given(
    decades=st.lists(st.floats(-4.0, -0.5), min_size=2, max_size=5, unique_by=lambda x: round(x, 2)),
    waits=st.lists(st.floats(0.01, 1.0), min_size=8, max_size=8),
    time=st.floats(-2.0, 1.0),
    shape=st.sampled_from([mdr.Paraboloid(1.0), mdr.Cone(slope=0.3)]),
)
@example(decades=[-1.0, -2.0], waits=[1.0] * 8, time=-2.0, shape=mdr.Paraboloid(1.0))
def test_small_rows_of_a_deep_history_say_their_own_errors(decades, waits, time, shape):
    """The first rows are one approach, which Ting's form has without springs."""
    shear = mdr.Prony(0.2, [1.0], [10.0**time])
    first = 0.1 * 10.0 ** np.sort(decades)
    d = np.concatenate([first, [0.1, 0.04, 0.1]])
    t = np.cumsum(waits[: d.size])
    result = pressed(shear, mdr.Path(time=t, indentation=d), shape)
    alone = pressed(shear, mdr.Path(time=t[: first.size], indentation=first), shape)
    exact = alone["normal_force"].values
    assert alone.claims["normal_force"].level is mdr.Level.EXACT
    missed = np.abs(result["normal_force"].values[: first.size] / exact - 1.0)
    assert (missed <= result.claims["normal_force"].error[: first.size] + 1e-12).all()
    assert "relative to the value" in result.claims["normal_force"].reason


@settings(deadline=None, max_examples=examples(4))
@given(memory=memories(), shape=st.sampled_from(SHAPES[:2]))
def test_pressures_err_as_is_claimed_up_to_the_edge(memory, shape):
    kernel, time, depth = memory
    equivalent = equivalent_profile(shape)
    line, gap = ElasticLine(equivalent, 1.0), gap_function(shape, equivalent)
    radius = follow_springs(line, kernel, time, depth, n=1000).contact_radius
    few, many = (MemorySurface(equivalent, kernel, gap, time, depth, radius, n) for n in (1000, 6000))
    row = 1  # the deepest, reached by one approach
    r = radius[row] * (1.0 - np.geomspace(0.5, 1e-4, 40))
    one, other = (surface.field("pressure", r, row) for surface in (few, many))
    claimed = check_memory(few, None).error("pressure", time.size)[row]
    assert np.abs(one - other).max() <= (1.5 * claimed + 1e-9) * np.abs(other).max()


@pytest.mark.parametrize("viscosity", [0.05, 0.2, 2.0])
def test_a_dashpot_bears_without_bound_at_the_edge(viscosity):
    result = pressed(mdr.KelvinVoigt(1.0, viscosity), mdr.indent(0.01, duration=1.0, steps=4))
    a = float(result["contact_radius"][-1])
    near = a * (1.0 - np.array([1e-2, 1e-3, 1e-4, 0.0]))
    p = result.field("pressure", r=near)
    amplitude = float(p.coords["edge_amplitude"])
    assert (np.diff(p.values[:3]) > 0.0).all()
    assert np.isinf(p.values[3])
    assert p.values[2] * math.sqrt(1e-4 * a) == pytest.approx(amplitude, rel=0.05)


@pytest.mark.parametrize("decades", [-118, -60, 60])
def test_fields_of_contacts_whose_squares_have_no_number(decades):
    size = 10.0**decades
    gel = mdr.Viscoelastic(mdr.StandardSolid("1 kPa", "3 kPa", "1 s"), poisson=0.5)
    path = mdr.Path(time=[1.0, 2.0, 3.0], indentation=[0.01 * size, 0.02 * size, 0.012 * size])
    result = mdr.solve(mdr.Contact(mdr.Cone(slope=0.3), gel), path)
    unit = mdr.solve(
        mdr.Contact(mdr.Cone(slope=0.3), gel),
        mdr.Path(time=[1.0, 2.0, 3.0], indentation=[0.01, 0.02, 0.012]),
    )
    r = np.array([0.3, 0.9, 1.5]) * float(unit["contact_radius"][-1])
    for name, power in (("pressure", 0), ("gap", 1), ("normal_displacement", 1)):
        here, there = result.field(name, r * size).values, unit.field(name, r).values
        np.testing.assert_allclose(here / size**power, there, rtol=1e-9)


@pytest.mark.parametrize("seed", [79, 113, *range(4)])
def test_first_rows_of_histories_that_go_far_deeper_err_as_claimed(seed):
    """d^(3/2) of a growing contact is a convolution of its force with the creep compliance."""
    rng = np.random.default_rng([seed, 5])
    tau, branch = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-1, 2)
    rows = int(rng.integers(4, 12))
    time = np.cumsum(tau * 10.0 ** rng.uniform(-2, 1, rows))
    force = np.sort(10.0 ** rng.uniform(rng.uniform(-8, -1), 0, rows))
    last = int(rng.integers(2, rows))
    force[last:] *= np.where(rng.random(rows - last) < 0.4, rng.uniform(0.2, 0.9, rows - last), 1.0)
    if not np.any(np.diff(force) < 0.0):
        force[-1] = 0.9 * force[-2]
    body = mdr.Viscoelastic(mdr.StandardSolid(1.0, branch, tau), 0.5)
    path = mdr.Path(time=time, normal_force=1e-6 * force)
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), body), path)
    delay, moved = tau * (1.0 + branch), 0.0
    steps, moves = np.diff(time, prepend=0.0), np.diff(1e-6 * force, prepend=0.0)
    claim = result.claims["indentation"]
    for i in range(int(np.argmax(np.diff(force) < 0.0)) + 1):
        lag = -math.expm1(-steps[i] / delay)
        moved += (moves[i] * delay / steps[i] - moved) * lag
        creep = 1e-6 * force[i] - moved * branch / (1.0 + branch)
        truth = (0.1875 * creep) ** (2.0 / 3.0)
        assert abs(float(result["indentation"].values[i]) / truth - 1.0) <= claim.error[i] + 1e-9


@pytest.mark.parametrize(
    "profile",
    [
        mdr.FlatPunch("1 mm"),
        mdr.RoundedFlat("1 mm", "10 mm"),
        mdr.TruncatedCone("1 mm", slope=0.1),
        mdr.TruncatedParaboloid("1 mm", "10 mm"),
        mdr.Sphere("10 mm"),
    ],
)
@pytest.mark.parametrize("loads", [[1.0], [1.0, 2.0, 1.5]])
def test_a_load_in_no_time_on_a_dashpot_rests_on_the_flat_end(profile, loads):
    """Its radius is that of the flat; the pressure of such a row has no indentation, and is not claimed."""
    body = mdr.Viscoelastic(mdr.KelvinVoigt("1 MPa", "1 MPa s"), 0.5)
    path = mdr.Path(time=np.arange(len(loads)), normal_force=loads)
    result = mdr.solve(mdr.Contact(profile, body), path)
    flat = getattr(profile, "flat_radius", profile.radius if isinstance(profile, mdr.FlatPunch) else 0.0)
    assert result["indentation"].values[0] == 0.0
    assert result["contact_radius"].values[0] == pytest.approx(flat, rel=1e-12)
    assert not (flat and result.claims["pressure"].where[0])
    assert result.claims["pressure"].where[1:].all()


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(-9.0, 0.0),
    st.floats(0.05, 0.95),
    st.floats(0.02, 50.0),
    st.lists(st.floats(0.1, 1.0), min_size=1, max_size=3),
)
def test_a_sharp_edge_that_is_reached_within_a_row_is_a_kink_of_the_force(decades, rounded, tau, rises):
    b, depths = 10.0**decades, np.cumsum(rises)
    dome = 10.0 * b
    depths *= b * b / dome / (rounded * depths[-1])  # the edge is reached at a part of the largest depth
    solid = Relaxation(4.0 * 0.3, np.array([4.0]), np.array([tau]))
    times = np.arange(1.0, depths.size + 1.0)
    result = pressed(
        mdr.StandardSolid(0.3, 1.0, tau), mdr.Path(time=times, indentation=depths), mdr.DomedPunch(b, dome)
    )
    reached = float(np.interp(b * b / dome, np.append(0.0, depths), np.append(0.0, times)))

    def rate(s, t):
        row = min(int(s), depths.size - 1)
        d = float(np.interp(s, np.append(0.0, times), np.append(0.0, depths)))
        speed = float(np.diff(depths, prepend=0.0)[row])
        return float(solid(np.array([t - s]))[0]) * 2.0 * min(math.sqrt(dome * d), b) * speed

    for t, force in zip(times, result["normal_force"].values, strict=True):
        marks = np.unique(np.clip([0.0, *times, reached], 0.0, t))
        # a square root at first touch
        parts = [
            quad(
                lambda v, t=t, low=low: 2.0 * v * rate(low + v * v, t), 0.0, math.sqrt(high - low), epsabs=0.0
            )[0]
            for low, high in pairwise(marks)
        ]
        assert force == pytest.approx(sum(parts), rel=1e-10)
