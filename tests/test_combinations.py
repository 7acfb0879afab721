"""Features where they meet: bodies, profiles, laws, paths and questions that were made apart."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import ProblemError, PymdrError
from pymdr.problem.parameters import parameter_of
from pymdr.solving.teaching import friction_foundation

X = (np.arange(12) + 0.5) / 12 - 0.5
HEIGHTS = -(X[:, None] ** 2 + 1.3 * X**2) * 1e-4
DEEP = "5 um"
TIPS = {
    "sphere": mdr.Sphere("10 mm"),
    "paraboloid": mdr.Paraboloid("10 mm"),
    "cone": mdr.Cone(slope=0.02),
    "power": mdr.PowerLaw(4, "1 um", "1 mm"),
    "flat": mdr.FlatPunch("1 mm"),
    "rounded": mdr.RoundedFlat("0.2 mm", "10 mm"),
    "truncated cone": mdr.TruncatedCone("0.1 mm", slope=0.02),
    "truncated paraboloid": mdr.TruncatedParaboloid("10 mm", "0.1 mm"),
    "truncated sphere": mdr.TruncatedSphere("10 mm", "0.1 mm"),
    "domed": mdr.DomedPunch("1 mm", "10 mm"),
}
PATHS = {
    "apart": mdr.indent("-1 um", steps=2),
    "touching": mdr.indent(0.0, steps=2),
    "pressed": mdr.indent(DEEP, steps=3),
    "loaded": mdr.load("2 mN", steps=2) >> mdr.load("0 N", steps=2),
    "parted": mdr.indent(DEEP, steps=2) >> mdr.indent("-1 um", steps=3),
}
LAWS = {
    "free": None,
    "jkr": mdr.JKR("10 mJ/m^2"),
    "dmt": mdr.DMT("10 mJ/m^2", range="10 nm"),
}


def stack(nu, ratio, *, bond="bonded", layers=1):
    top = mdr.Layer(mdr.Elastic("1 MPa", nu), "1 mm")
    return mdr.Layered([top] * layers, base=mdr.Elastic(1e6 * ratio, nu), bond=bond)


@settings(max_examples=8, deadline=None)
@given(
    tip=st.sampled_from(sorted(TIPS)),
    path=st.sampled_from(sorted(PATHS)),
    law=st.sampled_from(sorted(LAWS)),
    nu=st.sampled_from([0.0, 0.3, 0.5]),
    layers=st.integers(1, 2),
)
@example(tip="flat", path="apart", law="free", nu=0.5, layers=1)
@example(tip="domed", path="touching", law="free", nu=0.3, layers=1)
@example(tip="truncated cone", path="parted", law="jkr", nu=0.5, layers=1)
@example(tip="truncated sphere", path="pressed", law="dmt", nu=0.3, layers=2)
def test_layers_of_one_material_are_its_half_space(tip, path, law, nu, layers):
    layered = mdr.solve(
        mdr.Contact(TIPS[tip], stack(nu, 1.0, layers=layers), adhesion=LAWS[law]), PATHS[path]
    )
    plain = mdr.solve(mdr.Contact(TIPS[tip], mdr.Elastic("1 MPa", nu), adhesion=LAWS[law]), PATHS[path])
    for name in ("indentation", "normal_force", "contact_radius"):
        scale = float(np.nanmax(np.abs(plain.data[name].values), initial=1e-30))
        assert layered.data[name].values == pytest.approx(
            plain.data[name].values, rel=1e-9, abs=1e-10 * scale, nan_ok=True
        )


@settings(max_examples=examples(12), deadline=None)
@given(
    tip=st.sampled_from(["paraboloid", "cone", "flat"]),
    unlike=st.floats(-13.0, -2.0).map(lambda power: 10.0**power),
    nu=st.sampled_from([0.0, 0.3, 0.5]),
)
def test_a_base_that_is_a_little_stiffer_makes_a_body_a_little_stiffer(tip, unlike, nu):
    force = [
        float(mdr.solve(mdr.Contact(TIPS[tip], body), mdr.indent("20 um"))["normal_force"][-1])
        for body in (mdr.Elastic("1 MPa", nu), stack(nu, 1.0 + unlike))
    ]
    assert -1e-13 <= force[1] / force[0] - 1.0 <= unlike + 1e-13


@pytest.mark.parametrize("tip", ["flat", "truncated cone"])
@pytest.mark.parametrize("law", sorted(LAWS))
@pytest.mark.parametrize("path", ["apart", "touching", "parted"])
def test_sliding_layers_answer_wherever_they_are_pressed(tip, law, path):
    body = stack(0.4, 5.0, bond="frictionless")
    result = mdr.solve(mdr.Contact(TIPS[tip], body, adhesion=LAWS[law]), PATHS[path])
    for name, claim in result.claims.items():
        if claim.readable and name in result.data:
            assert np.isfinite(result.data[name].values[claim.where]).all()


@pytest.mark.parametrize("friction", [None, mdr.Coulomb(0.3)])
@pytest.mark.parametrize("tip", [TIPS["sphere"], TIPS["flat"], mdr.Ellipsoid("10 mm", "10 mm")])
def test_bodies_with_memory_that_were_never_touched_have_unloaded_springs(friction, tip):
    rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "4 MPa", "1 s"), poisson=0.5)
    away = mdr.solve(
        mdr.Contact(tip, rubber, friction=friction), mdr.indent("-1 um", steps=2, duration="1 s")
    )
    for name in away.reading.line_fields:
        values = away.field(name).values
        assert np.isfinite(values).all()
        assert name == "equivalent_profile" or not values.any()
    assert np.isfinite(away.field("gap")).all()


def test_every_height_of_a_grid_is_a_parameter():
    contact = mdr.Contact(mdr.Sampled2D(HEIGHTS, "1 mm"), mdr.Elastic("1 MPa", 0.5))
    for i in (0, 17, 143):
        name = f"profile.heights[{i}]"
        value = parameter_of(contact, name).value
        assert value == HEIGHTS.flat[i]
        assert mdr.with_parameters(contact, {name: value}) == contact
        lower = mdr.with_parameters(contact, {name: value - 1e-6}).profile.heights
        assert np.argwhere(lower.ravel() != HEIGHTS.ravel()).tolist() == [[i]]
    with pytest.raises(ProblemError, match="this contact has"):
        mdr.with_parameters(contact, {"profile.heights[144]": 0.0})


def test_layered_bodies_are_printed_as_others_are():
    body = stack(0.5, 2.0)
    assert repr(body).startswith("Layered(layers=(Layer(material=Elastic(young=1000000.0, poisson=0.5)")
    assert eval(repr(body), vars(mdr) | {n: getattr(mdr, n) for n in ("Layered", "Layer", "Elastic")}) == body
    assert "no values" in mdr.relaxation_of(mdr.Elastic("1 MPa", 0.5))._repr_html_()


BALL = mdr.Contact(TIPS["paraboloid"], mdr.Elastic("1 MPa", 0.5))
SURFACE = mdr.Topography(HEIGHTS, "1 mm")
DATA = mdr.solve(BALL, mdr.indent(DEEP)).data
BAD = {
    "no contact": lambda: mdr.parameters_of("ball"),
    "a result": lambda: mdr.parameters_of(mdr.solve(BALL, mdr.indent(DEEP))),
    "no contact to change": lambda: mdr.with_parameters(None, {"body.young": 1.0}),
    "no names": lambda: mdr.with_parameters(BALL, ["body.young"]),
    "one quantity": lambda: mdr.sweep(BALL, mdr.indent(DEEP), {"body.young": [1e6]}, quantities="force"),
    "a number": lambda: mdr.sweep(BALL, mdr.indent(DEEP), {"body.young": [1e6]}, quantities=3),
    "no machine": lambda: mdr.sweep(BALL, mdr.travel(DEEP), {"machine_stiffness": []}),
    "a dead load": lambda: mdr.sweep(BALL, mdr.travel(DEEP), {"machine_stiffness": [-1.0]}),
    "no surface of a body": lambda: mdr.Sampled2D.of(HEIGHTS),
    "no trend": lambda: SURFACE.detrend(["plane"]),
    "no remedy": lambda: SURFACE.fill_missing(HEIGHTS),
    "a word for a punch": lambda: mdr.press(SURFACE, mdr.Elastic("1 MPa", 0.5), indentation=1e-6, punch="no"),
    "no contact to verify": lambda: mdr.verify("ball", mdr.indent(DEEP)),
    "no contact of springs": lambda: mdr.foundation("ball"),
    "no contact of springs with friction": lambda: friction_foundation(None, [1e-6], [0.0]),
    "no list of contacts": lambda: mdr.solve_batch(BALL, mdr.indent(DEEP)),
    "no path": lambda: mdr.solve_batch([BALL], None),
    "rings for a pyramid": lambda: mdr.solve(
        mdr.Contact(mdr.Pyramid(4, slope=0.1), BALL.body), mdr.indent(DEEP), solver=mdr.Rings()
    ),
    "a body that replaces": lambda: mdr.with_parameters(BALL, {"body.young": 2.0, "body": BALL.body}),
    "a sweep that replaces": lambda: mdr.sweep(
        BALL, mdr.indent(DEEP), {"body.young": [1e6, 2e6], "body": [BALL.body, stack(0.3, 2.0)]}
    ),
    "data for a number": lambda: mdr.Sphere(DATA),
    "data for numbers": lambda: mdr.joule_heating(DATA, current="1 A", temperature="300 K"),
}


@pytest.mark.parametrize("ask", BAD.values(), ids=BAD)
def test_wrong_requests_are_refused(ask):
    with pytest.raises(PymdrError) as refusal:
        ask()
    assert len(str(refusal.value)) > 20


def test_machines_are_swept_as_they_are_solved():
    path = mdr.travel(DEEP, steps=2)
    result = mdr.sweep(BALL, path, {"machine_stiffness": ["10 N/m", math.inf]})
    for i, stiffness in enumerate(["10 N/m", math.inf]):
        alone = mdr.solve(BALL, path, machine_stiffness=stiffness)
        assert result["normal_force"][i].values.tolist() == alone["normal_force"].values.tolist()


def test_a_part_is_replaced_before_it_is_changed():
    steel = mdr.Elastic("210 GPa", 0.3)
    changed = mdr.with_parameters(BALL, {"body": steel, "body.young": "70 GPa"})
    assert changed.body == mdr.Elastic("70 GPa", 0.3)


def test_one_parameter_is_swept_once(tmp_path, shell):
    case = tmp_path / "case.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\nkind = "elastic"\nyoung = "1 MPa"\npoisson = 0.5\n'
        '[[path]]\nkind = "indent"\nindentation = "1 um"\n'
    )
    status, _, err = shell("sweep", case, "--over", "body.young = 1 MPa", "--over", "body.young = 2 MPa")
    assert status == 1
    assert "body.young is already given" in err


def test_separated_bodies_have_a_band_of_no_current():
    radius = np.linspace(0.0, 1e-3, 20)
    tip = mdr.Sampled(radius, radius**2 / 2e-2, scatter=1e-8 * np.arange(20.0))
    metal = mdr.Elastic("1 GPa", 0.3, resistivity=1e-7)
    result = mdr.solve(mdr.Contact(tip, metal, metal), mdr.indent("1 um", steps=2) >> mdr.indent("-1 um"))
    for name in ("electrical_resistance_low", "electrical_resistance", "electrical_resistance_high"):
        values = result.data[name].values
        assert np.isfinite(values[:2]).all()
        assert math.isinf(values[2])


def test_measured_surfaces_are_pressed():
    from pymdr.problem.codec import decode_case

    body = {"kind": "elastic", "young": 1e6, "poisson": 0.5}
    with pytest.raises(mdr.CaseError, match=r"use pymdr press$"):
        decode_case({"surface": {"file": "ground.csv"}, "body": body})
