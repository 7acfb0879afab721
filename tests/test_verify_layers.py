"""Layered bodies by the line, whose springs act on one another, and by rings, which know of no line."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.errors import ProblemError

POISSON = st.sampled_from([-0.3, 0.0, 0.3, 0.45, 0.5])
PROFILES = {
    "paraboloid": lambda a: mdr.Paraboloid(a),
    "cone": lambda a: mdr.Cone(slope=0.5),
    "power": lambda a: mdr.PowerLaw(4, a / 2, a),
    "punch": lambda a: mdr.FlatPunch(a),
}


@st.composite
def contacts(draw, adhesion=None):
    moduli = st.floats(-1.5, 1.5).map(lambda x: 10.0**x)
    layers = [
        mdr.Layer(mdr.Elastic(draw(moduli), draw(POISSON)), 10.0 ** draw(st.floats(-0.5, 0.5)))
        for _ in range(draw(st.integers(1, 2)))
    ]
    base = draw(st.one_of(st.just(mdr.Rigid()), st.builds(mdr.Elastic, moduli, POISSON)))
    body = mdr.Layered(layers, base=base, bond=draw(st.sampled_from(["bonded", "frictionless"])))
    a = layers[0].thickness * 10.0 ** draw(st.floats(-1, 0.6))
    return mdr.Contact(PROFILES[draw(st.sampled_from(sorted(PROFILES)))](a), body, adhesion=adhesion), a


@given(contacts(), st.floats(0.05, 0.5))
@settings(max_examples=4, deadline=None)
def test_line_and_rings_agree_on_any_layers(drawn, depth):
    contact, a = drawn
    result = mdr.verify(contact, mdr.indent(depth * a), elements=60, steps=1)
    if math.isnan(result.largest_difference):  # only a contact that is no disk is refused
        by_rings = mdr.solve(contact, mdr.indent(depth * a), solver=mdr.Rings(60))
        holes = by_rings["inner_contact_radius"].values > 0.0
        area = by_rings["contact_area"].values / (math.pi * by_rings["contact_radius"].values ** 2)
        assert holes.all() or (area < 1.0 - 1e-9).all()
        return
    assert result.largest_difference < 1e-4
    assert abs(result.data["contact_radius_difference"].item()) < 1e-4
    assert abs(result.data["normal_stiffness_difference"].item()) < 1e-4
    assert abs(result.data["elastic_energy_difference"].item()) < 1e-4
    assert result.data["pressure_difference"].item() < 1e-3


@given(contacts(), st.floats(0.01, 1.0))
@settings(max_examples=3, deadline=None)
def test_line_and_rings_agree_on_adhesive_layers(drawn, strength):
    contact, a = drawn
    assume(not isinstance(contact.profile, mdr.FlatPunch))
    modulus = contact.layered.top.young / (1 - contact.layered.top.poisson**2)
    work = 0.1 * strength * a * modulus
    glued = mdr.Contact(contact.profile, contact.body, adhesion=mdr.JKR(work))
    result = mdr.verify(glued, mdr.indent(0.2 * a), elements=80, steps=1)
    assert abs(result.data["indentation_difference"].item()) < 1e-4
    assert abs(result.data["elastic_energy_difference"].item()) < 1e-4
    force, by_rings = (result.data[f"normal_force_{method}"].item() for method in ("mdr", "rings"))
    # the force is what is left of a push and of a pull
    parts = abs(force) + math.sqrt(8 * math.pi * work * modulus * a**3)
    assert force == pytest.approx(by_rings, abs=1e-4 * parts)


def test_rings_solve_under_a_force_and_read_fields():
    film = mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.5), "1 mm")])
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), film)
    path = mdr.load("2 N", steps=2)
    by_line, by_rings = mdr.solve(contact, path), mdr.solve(contact, path, solver=mdr.Rings(80))
    for name in ("indentation", "contact_radius", "normal_stiffness", "elastic_energy"):
        np.testing.assert_allclose(by_rings[name], by_line[name], rtol=1e-5)
    r = np.linspace(0.0, 2.5, 7) * 1e-3
    for name in ("pressure", "normal_displacement", "gap"):
        one, other = (result.field(name, r=r, step=-1).values for result in (by_line, by_rings))
        np.testing.assert_allclose(one, other, atol=2e-4 * np.max(np.abs(other)))


def test_annular_contact_on_a_stiff_coating_is_left_to_the_rings():
    coating = mdr.Layered([mdr.Layer(mdr.Elastic("200 GPa", 0.3), "1 mm")], base=mdr.Elastic("2 GPa", 0.3))
    punch = mdr.Contact(mdr.FlatPunch("3 mm"), coating)
    result = mdr.verify(punch, mdr.indent("1 um"), elements=60, steps=1)
    assert math.isnan(result.largest_difference)
    by_rings = mdr.solve(punch, mdr.indent("1 um"), solver=mdr.Rings(60))
    assert by_rings["inner_contact_radius"].item() > 1e-3


@pytest.mark.parametrize("bond", ["bonded", "frictionless"])
def test_corrections_for_thickness_are_those_of_rings(bond):
    result = mdr.thickness_correction(
        mdr.Cone(slope=0.2), 0.45, thickness="1 um", indentation="0.4 um", bond=bond
    )
    sample = mdr.Elastic("1 kPa", 0.45)
    film = mdr.Layered([mdr.Layer(sample, "1 um")], bond=bond)
    forces = [
        mdr.solve(mdr.Contact(mdr.Cone(slope=0.2), body), mdr.indent("0.4 um"), solver=mdr.Rings(80))
        for body in (film, sample)
    ]
    ratio = forces[0]["normal_force"].item() / forces[1]["normal_force"].item()
    assert result["force_factor"].item() == pytest.approx(ratio, rel=1e-4)


def test_rings_refuse_layers_they_cannot_resolve():
    film = mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.5), "1 nm")])
    with pytest.raises(ProblemError, match="thicker layer"):
        mdr.solve(mdr.Contact(mdr.FlatPunch("10 mm"), film), mdr.indent("1 pm"), solver=mdr.Rings(20))
