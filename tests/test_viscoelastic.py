"""Contacts with memory, as they are solved: references, Ting against springs, energies, fields, limits."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.errors import PathError, ProblemError

REFERENCES = {
    entry["id"]: entry
    for entry in json.loads((Path(__file__).parent / "reference" / "refs.json").read_text())["refs"]
}
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
    found = pressed(mdr.Maxwell(1.0, time=0.4), mdr.indent(0.36, duration=0.9))
    assert float(found["normal_force"][-1]) == pytest.approx(maxwell["expected"]["F"], rel=1e-9)


def test_the_creep_under_a_load_that_is_there_at_once():
    expected = REFERENCES["sls_creep"]["expected"]
    result = pressed(SOLID, mdr.Path(time=[0.0, *np.linspace(0.01, 0.9, 90)], normal_force=np.full(91, 0.2)))
    for name, value in (("contact_radius", expected["a"]), ("indentation", expected["d"])):
        error = result.claims[name].error
        bound = float(np.max(error))
        assert float(result[name][-1]) == pytest.approx(value, rel=max(3.0 * bound, 1e-9))
        assert bound < 1e-4


@settings(max_examples=12, deadline=None)
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
def test_energy_is_stored_or_dissipated_on_any_way(terms, equilibrium, shape, depths):
    moduli, times = (10.0 ** np.array(column, dtype=float) for column in zip(*terms, strict=True))
    times **= 0.1
    path = mdr.indent(0.1, duration=1.0, steps=6)
    for d in depths:
        path = path >> mdr.indent(d, duration=0.7, steps=6)
    result = pressed(mdr.Prony(equilibrium, moduli, times), path, shape)
    work, stored, lost = (
        result.data[name].values for name in ("external_work", "elastic_energy", "dissipated_energy")
    )
    scale = np.abs(work).max() + stored.max()
    np.testing.assert_allclose(work, stored + lost, atol=1e-7 * scale)
    assert (np.diff(lost, prepend=0.0) >= -1e-9 * scale).all()
    assert (result["normal_force"].values >= -1e-9 * result["normal_force"].values.max()).all()


@settings(max_examples=10, deadline=None)
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


def test_bodies_that_stay_apart():
    result = pressed(SOLID, mdr.indent(-0.1, duration=1.0, steps=2))
    assert result["normal_force"].values.tolist() == [0.0, 0.0]
    assert result["contact_radius"].values.tolist() == [0.0, 0.0]


def test_what_is_refused():
    contact = mdr.Contact(mdr.Sphere(1.0), body(SOLID))
    with pytest.raises(PathError, match="duration or a rate"):
        mdr.solve(contact, mdr.indent(0.1))
    with pytest.raises(PathError, match="cannot be below 0 N"):
        mdr.solve(contact, mdr.load(-1.0, duration=1.0))
    with pytest.raises(ProblemError, match="adhesion"):
        mdr.Contact(mdr.Sphere(1.0), body(SOLID), adhesion=mdr.JKR(0.1))
    with pytest.raises(PathError, match="has no friction"):
        mdr.solve(contact, mdr.indent(0.1, duration=1.0) >> mdr.shift(0.1, duration=1.0))
    with pytest.raises(PathError, match="pressed in by its radius"):
        mdr.solve(contact, mdr.indent(1.5, duration=1.0))
    waves = mdr.Paraboloid(1.0) + mdr.Waviness(height=0.01, wavelength=0.1)
    with pytest.raises(ProblemError, match="falls somewhere"):
        mdr.solve(mdr.Contact(waves, body(SOLID)), mdr.indent(0.1, duration=1.0))
    for study in (
        lambda: mdr.pull_off(contact),
        lambda: mdr.solve(contact, mdr.indent(0.1, duration=1.0), solver=mdr.Rings(n=50)),
        lambda: mdr.foundation(contact),
        lambda: mdr.verify(contact, mdr.indent(0.1, duration=1.0)),
        lambda: mdr.impact(contact, mass=1.0, speed=1.0),
    ):
        with pytest.raises(ProblemError):
            study()
