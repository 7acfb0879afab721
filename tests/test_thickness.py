"""Half-spaces that say how thick they are, against the same contacts solved as layers."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import NotValidError, ProblemError, UnitError
from pymdr.interpretation.thickness import THICKNESS_LIMIT
from pymdr.interpretation.validity import Level
from pymdr.problem.codec import case_schema, decode_case, encode_case

QUANTITIES = (
    "indentation",
    "normal_force",
    "contact_radius",
    "normal_stiffness",
    "mean_pressure",
    "elastic_energy",
)
FIELDS = ("pressure", "normal_displacement", "gap")
POISSON = st.floats(-0.5, 0.5)
WIDTH = st.floats(-4.0, -0.7).map(lambda power: 10.0**power)
"""Of a contact, in thicknesses."""
SIZE = st.floats(-8.0, 0.0).map(lambda power: 10.0**power)
YOUNG = st.floats(2.0, 12.0).map(lambda power: 10.0**power)


def sample(young, poisson, thickness, **others):
    return mdr.Elastic(young, poisson, thickness=thickness, **others)


def layer(young, poisson, thickness):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, poisson), thickness)])


def shape(kind, a):
    """A gentle profile and the depth at which a half-space touches it out to a radius in m."""
    if kind == "sphere":
        return mdr.Paraboloid(20.0 * a), a / 20.0
    if kind == "cone":
        return mdr.Cone(slope=0.05), 0.025 * math.pi * a
    return mdr.FlatPunch(a), 0.02 * a


def thickness_of(result):
    (results,) = [one for one in result.assumptions if one.name == "thickness"]
    return results


@settings(max_examples=examples(12), deadline=None)
@given(
    st.sampled_from(["sphere", "cone", "punch"]),
    st.sampled_from(["indentation", "normal_force", "travel"]),
    POISSON,
    WIDTH,
    SIZE,
    YOUNG,
    st.floats(0.1, 10.0),
)
def test_errors_bound_what_the_layer_does_otherwise(kind, channel, poisson, width, a, young, stiffness):
    profile, depth = shape(kind, a)
    body, film = sample(young, poisson, a / width), layer(young, poisson, a / width)
    deep = mdr.solve(mdr.Contact(profile, mdr.Elastic(young, poisson)), mdr.indent(depth))
    machine = None
    path = mdr.indent(depth, steps=3)
    if channel == "normal_force":
        path = mdr.load(deep["normal_force"].item(), steps=3)
    if channel == "travel":
        machine = stiffness * deep["normal_stiffness"].item()
        path = mdr.travel(depth + deep["normal_force"].item() / machine, steps=3)
    claimed = mdr.solve(mdr.Contact(profile, body), path, machine_stiffness=machine)
    true = mdr.solve(mdr.Contact(profile, film), path, machine_stiffness=machine)
    plain = mdr.solve(mdr.Contact(profile, mdr.Elastic(young, poisson)), path, machine_stiffness=machine)
    for name in QUANTITIES:
        claim, values, others = claimed.claims[name], plain[name].values, true[name].values
        error = np.zeros(3) if claim.error is None else claim.error
        known = claim.where & (error < 1.0)
        off = np.abs(others - values)[known] / values[known]
        assert np.all(off <= error[known] * (1.0 + 1e-6) + 1e-9), name
        if name != channel and channel != "travel":
            # as far as numbers have digits it is the difference itself
            assert off == pytest.approx(error[known], rel=1e-6, abs=1e-9)
        assert claim.level is not Level.EXACT or np.all(error[claim.where] <= 1e-9)
        if claim.readable:
            assert claimed[name].values[claim.where] == pytest.approx(values[claim.where], rel=1e-15)
    near = claimed.claims["normal_stiffness"].where
    assert channel == "travel" or claimed.claims[channel].where.all()
    r = np.array([0.1, 0.4, 0.8]) * plain["contact_radius"].values[-1]
    outside = np.array([0.3, 0.9, 1.3, 2.0, 10.0]) * plain["contact_radius"].values[-1]
    if near[-1]:
        error = {
            name: 0.0 if claimed.claims[name].error is None else claimed.claims[name].error[-1]
            for name in FIELDS
        }
        p, q = (one.field("pressure", r).values for one in (plain, true))
        assert np.all(np.abs(q - p) <= error["pressure"] * p + 1e-9 * p)
        for name in ("normal_displacement", "gap"):
            u, v = (one.field(name, outside).values for one in (plain, true))
            if name == "gap" and kind == "punch":  # endless outside
                u, v = u[:2], v[:2]
            assert np.all(np.abs(u - v) <= (error[name] + 1e-9) * plain["indentation"].values[-1])


@settings(max_examples=6, deadline=None)
@given(POISSON, WIDTH, SIZE, YOUNG)
def test_the_assumption_is_the_force_at_equal_indentation(poisson, width, a, young):
    profile, depth = shape("sphere", a)
    result = mdr.solve(mdr.Contact(profile, sample(young, poisson, a / width)), mdr.indent(depth, steps=4))
    computed = thickness_of(result)
    factor = mdr.thickness_correction(profile, poisson, thickness=a / width, indentation=depth)
    assert computed.measure == pytest.approx(factor["force_factor"].item() - 1.0, rel=1e-6, abs=1e-12)
    assert computed.met == bool(result.claims["normal_force"].where.all())
    assert computed.limit == THICKNESS_LIMIT


def test_very_thick_bodies_stay_exact():
    ball = mdr.Paraboloid("10 um")
    thick = mdr.solve(mdr.Contact(ball, sample("1 MPa", 0.5, "1 km")), mdr.indent("1 nm", steps=3))
    plain = mdr.solve(mdr.Contact(ball, mdr.Elastic("1 MPa", 0.5)), mdr.indent("1 nm", steps=3))
    for name, claim in plain.claims.items():
        if name != "stress":
            assert (thick.claims[name].level, thick.claims[name].reason) == (claim.level, claim.reason)
    assert "thickness" in thick.claims["stress"].reason
    assert thickness_of(thick).met


@pytest.mark.parametrize("adhesion", [None, mdr.JKR("1 uJ/m^2"), mdr.DMT("1 uJ/m^2")])
def test_thin_bodies_are_not_valid_and_say_what_to_do(adhesion):
    contact = mdr.Contact(mdr.Paraboloid("10 um"), sample("1 MPa", 0.5, "2 um"), adhesion=adhesion)
    result = mdr.solve(contact, mdr.indent("1 um", steps=5))
    assert result.claims["normal_force"].level is Level.NOT_VALID
    with pytest.raises(NotValidError, match=r"2 µm.*Layered\(\[Layer\(Elastic\(\.\.\.\), thickness\)\]\)"):
        result["normal_force"]
    with pytest.raises(NotValidError, match="rigid base"):
        result.field("pressure", [0.0])
    assert result["indentation"].values[-1] == 1e-6
    assert not thickness_of(result).met
    assert re.search("thickness: .* NOT MET", result.summary())
    if adhesion is None:
        lower = result["force_lower_bound"].values
        film = mdr.Contact(contact.profile, layer("1 MPa", 0.5, "2 um"))
        assert np.all(lower < mdr.solve(film, result.path)["normal_force"].values)


def test_steps_are_judged_one_by_one():
    contact = mdr.Contact(mdr.Paraboloid("10 um"), sample("1 MPa", 0.5, "2 um"))
    path = mdr.indent("1 nm", steps=3) >> mdr.load("1 nN", steps=4)
    result = mdr.solve(contact, path)
    claim = result.claims["contact_radius"]
    assert claim.level is Level.APPROXIMATE
    assert claim.where.tolist() == [True] * 5 + [False] * 2
    assert np.isnan(result["contact_radius"].values).tolist() == (~claim.where).tolist()
    assert result.claims["indentation"].where.tolist() == claim.where.tolist()
    assert result.claims["normal_force"].where.all()
    assert "2 of 7 steps" in claim.reason


@settings(max_examples=3, deadline=None)
@given(POISSON, st.floats(0.001, 0.05), YOUNG, st.floats(0.01, 0.5))
def test_adhesive_contacts_are_estimated(poisson, width, young, stick):
    a = 1e-6
    profile, depth = shape("sphere", a)
    thickness = a / width
    modulus = mdr.effective_moduli(mdr.Elastic(young, poisson)).normal
    law = mdr.JKR(stick * modulus * a / 400.0)
    claimed, true, plain = (
        mdr.solve(mdr.Contact(profile, body, adhesion=law), mdr.indent(depth, steps=2))
        for body in (
            sample(young, poisson, thickness),
            layer(young, poisson, thickness),
            mdr.Elastic(young, poisson),
        )
    )
    claim = claimed.claims["contact_radius"]
    assert "estimated" in claim.reason or not claim.readable
    off = np.abs(true["contact_radius"].values / plain["contact_radius"].values - 1.0)
    assert np.all(off[claim.where] <= claim.error[claim.where])


def test_a_sticky_punch_errs_by_its_stiffness():
    law, width = mdr.JKR("1 uJ/m^2"), 0.05
    body, film = sample("1 MPa", 0.5, 1e-6 / width), layer("1 MPa", 0.5, 1e-6 / width)
    path = mdr.indent("10 nm", steps=2)
    given, true = (
        mdr.solve(mdr.Contact(mdr.FlatPunch(1e-6), one, adhesion=law), path) for one in (body, film)
    )
    off = true["normal_force"].values / given["normal_force"].values - 1.0
    assert given.claims["normal_force"].error == pytest.approx(off, rel=1e-9)


@pytest.mark.parametrize(
    ("contact", "why"),
    [
        (
            mdr.Contact(mdr.EllipticParaboloid("10 um", "20 um"), sample("1 MPa", 0.5, "2 um")),
            "the contact is not a disk",
        ),
    ],
)
def test_what_is_not_measured_is_stated(contact, why):
    result = mdr.solve(contact, mdr.indent("1 nm", steps=2))
    computed = thickness_of(result)
    assert math.isnan(computed.measure)
    assert not computed.met
    assert f"not measured: {why}" in computed.description
    assert result.claims["normal_force"].level is Level.EXACT


def test_a_sample_under_an_elastic_ball_is_measured_with_the_ball():
    ball = mdr.Elastic("1 MPa", 0.5)
    path = mdr.indent("1 nm", steps=2)
    taken, true = (
        mdr.solve(mdr.Contact(mdr.Paraboloid("10 um"), body, ball), path)
        for body in (sample("1 MPa", 0.5, "2 um"), layer("1 MPa", 0.5, "2 um"))
    )
    claim = taken.claims["normal_force"]
    assert claim.level is Level.APPROXIMATE
    assert thickness_of(taken).met
    expected = true["normal_force"].values / taken["normal_force"].values - 1.0
    assert claim.error == pytest.approx(expected, rel=1e-9)


def test_force_curves_and_friction_state_it_as_an_assumption():
    body = sample("1 MPa", 0.5, "2 um")
    ball = mdr.Contact(mdr.Paraboloid("10 um"), mdr.Elastic("1 MPa", 0.5))
    curve = mdr.solve(ball, mdr.indent("1 nm", steps=20)).force_curve()
    result = thickness_of(mdr.solve(mdr.Contact(curve, body), mdr.indent("0.5 nm", steps=2)))
    assert "force curve" in result.description
    rubbed = mdr.Contact(mdr.Paraboloid("10 um"), body, friction=mdr.Coulomb(0.3))
    path = mdr.indent("1 um", steps=2) >> mdr.shift("1 nm", steps=2)
    result = thickness_of(mdr.solve(rubbed, path))
    assert result.measure > 1.0
    assert not result.met


def test_what_the_base_conducts_is_not_known():
    plate = mdr.Rigid(thermal_conductivity=1.0)
    thin = mdr.Contact(
        mdr.Paraboloid("10 um"), sample("1 MPa", 0.5, "20 um", thermal_conductivity=1.0), plate
    )
    result = mdr.solve(thin, mdr.indent("1 nm"))
    assert result.claims["normal_force"].level is Level.APPROXIMATE
    with pytest.raises(NotValidError, match="conductivity of its base"):
        result["thermal_conductance"]


def test_rings_are_judged_as_well():
    contact = mdr.Contact(mdr.Paraboloid("10 um"), sample("1 MPa", 0.5, "2 um"))
    by_rings = mdr.solve(contact, mdr.load("0.1 nN"), solver=mdr.Rings(40)).claims["indentation"]
    by_line = mdr.solve(contact, mdr.load("0.1 nN")).claims["indentation"]
    assert by_rings.error == pytest.approx(by_line.error, rel=1e-2)


def test_figures_of_contacts_that_are_valid_in_part(tmp_path):
    import matplotlib.pyplot as plt

    ball, law = mdr.Paraboloid("10 um"), mdr.JKR("1 uJ/m^2")
    contact = mdr.Contact(ball, sample("1 MPa", 0.5, "2 um"), adhesion=law)
    path = mdr.indent("1 nm", steps=3) >> mdr.indent("9 nm", steps=3) >> mdr.indent("1 nm", steps=3)
    result = mdr.solve(contact, path)
    assert 0 < result.claims["contact_radius"].where.sum() < 9
    plt.close(result.plot())
    result.save(tmp_path / "thin.nc")
    again = mdr.open_result(tmp_path / "thin.nc")
    assert again.contact == contact
    assert thickness_of(again) == thickness_of(result)
    assert again.claims["normal_force"].error == pytest.approx(result.claims["normal_force"].error)


# -- what is asked ------------------------------------------------------------------------------------


def test_bodies_say_their_thickness_and_others_do_not():
    thin = mdr.Elastic("1 MPa", 0.5, thickness="2 um")
    assert thin.thickness == 2e-6
    assert repr(thin) == "Elastic(young=1000000.0, poisson=0.5, thickness=2e-06)"
    assert repr(mdr.Elastic("1 MPa", 0.5)) == "Elastic(young=1000000.0, poisson=0.5)"
    assert mdr.Elastic("1 MPa", 0.5).thickness is None
    assert thin != mdr.Elastic("1 MPa", 0.5)
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("10 um"), mdr.Elastic("1 MPa", 0.5)), mdr.indent("1 um"))
    assert not [one for one in result.assumptions if one.name == "thickness"]


def test_case_files_carry_it():
    contact = mdr.Contact(mdr.Paraboloid("10 um"), mdr.Elastic("1 MPa", 0.5, thickness="2 um"))
    case = encode_case("thin", contact, mdr.indent("1 nm"))
    assert case["body"] == {"kind": "elastic", "young": 1e6, "poisson": 0.5, "thickness": 2e-6}
    assert decode_case({**case, "body": {**case["body"], "thickness": "2 um"}})[1] == contact
    assert "thickness" in case_schema()["$defs"]["elastic"]["properties"]


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        (0.0, ProblemError, r"^thickness = 0\.0: it must be above 0 m"),
        ("-1 um", ProblemError, r"^thickness = '-1 um': it must be above 0 m"),
        (math.inf, UnitError, r"^thickness: inf is not finite"),
        ("1 Pa", UnitError, r"^thickness: 'Pa' does not fit"),
    ],
)
def test_bad_thicknesses(value, kind, words):
    with pytest.raises(kind, match=words):
        mdr.Elastic(1.0, 0.3, thickness=value)


def test_thickness_is_given_by_name_and_once():
    with pytest.raises(TypeError):
        mdr.Elastic(1.0, 0.3, 1.0)  # type: ignore[misc]
    thin = mdr.Elastic(1.0, 0.3, thickness=1.0)
    with pytest.raises(ProblemError, match=r"^material has a thickness of 1 m, the layer one of 2 m"):
        mdr.Layer(thin, 2.0)
    with pytest.raises(ProblemError, match=r"^base has a thickness of 1 m"):
        mdr.Layered([mdr.Layer(mdr.Elastic(1.0, 0.3), 1.0)], base=thin)
