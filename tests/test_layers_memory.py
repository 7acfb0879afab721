"""Viscoelastic layers on a rigid base: rings with memory, elastic limits, similarity, and refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.problem.codec import decode_case, encode_case

SOLID = mdr.StandardSolid("1 MPa", "3 MPa", "10 ms")
UP_AND_DOWN = (
    mdr.indent("0.1 mm", duration="10 ms", steps=10)
    >> mdr.indent("0.05 mm", duration="20 ms", steps=10)
    >> mdr.indent("0.12 mm", duration="20 ms", steps=10)
)


def layer(poisson=0.5, shear=SOLID, thickness="1 mm"):
    return mdr.Layer(mdr.Viscoelastic(shear, poisson=poisson), thickness)


BALL = mdr.Paraboloid("10 mm")


def ball(body, profile=BALL):
    return mdr.Contact(profile, body)


def elastic(body, factor=1.0):
    """The same layers at one time, with G = factor times that of the rheology at rest."""
    layers = []
    for one in body.layers:
        nu, shear = one.material.poisson, one.material.shear.equilibrium
        layers.append(mdr.Layer(mdr.Elastic(2.0 * (1.0 + nu) * factor * shear, nu), one.thickness))
    return mdr.Layered(layers, bond=body.bond)


@pytest.mark.parametrize(
    "body",
    [
        mdr.Layered([layer()]),
        mdr.Layered([layer(), layer(0.3, SOLID.scaled(2.0), "0.5 mm")], bond="frictionless"),
    ],
    ids=["one", "two"],
)
def test_springs_agree_with_rings(body):
    by_springs = mdr.solve(ball(body), UP_AND_DOWN)["normal_force"].values
    errors = [
        np.max(
            np.abs(
                mdr.solve(ball(body), UP_AND_DOWN, solver=mdr.Rings(n))["normal_force"].values - by_springs
            )
        )
        for n in (40, 80)
    ]
    assert errors[1] < 1.5e-4 * by_springs.max()
    assert errors[1] < 0.6 * errors[0]


def test_a_step_relaxes_by_the_function_of_the_material():
    body = mdr.Layered([layer(0.4)])
    path = mdr.indent("0.1 mm", duration="1 fs", steps=1) >> mdr.hold("50 ms", steps=25)
    force = mdr.solve(ball(body), path)["normal_force"].values
    rest = float(mdr.solve(ball(elastic(body)), mdr.indent("0.1 mm"))["normal_force"][-1])
    time = np.append(0.0, np.linspace(0.002, 0.05, 25))
    assert force == pytest.approx(rest * SOLID.relaxation(time) / 1e6, rel=1e-9)


@given(
    scale=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    pressing=st.floats(0.01, 3.0),
    poisson=st.floats(0.0, 0.5),
    slow=st.booleans(),
)
@settings(max_examples=6, deadline=None)
def test_fast_and_slow_indentations_are_elastic(scale, pressing, poisson, slow):
    body = mdr.Layered([layer(poisson, thickness=scale)])
    contact = ball(body, mdr.Paraboloid(30.0 * scale))
    depth = pressing * scale / 60.0
    duration = 1e8 if slow else 1e-12
    path = mdr.indent(depth, duration=duration, steps=3)
    result = mdr.solve(contact, path)
    same = mdr.solve(ball(elastic(body, 1.0 if slow else 4.0), contact.profile), mdr.indent(depth, steps=3))
    assert result["normal_force"].values == pytest.approx(same["normal_force"].values, rel=1e-8)
    assert result["contact_radius"].values == pytest.approx(same["contact_radius"].values, rel=1e-8)


@given(
    scale=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    pressing=st.floats(0.05, 3.0),
    poisson=st.floats(0.0, 0.5),
    bond=st.sampled_from(["bonded", "frictionless"]),
    shape=st.sampled_from(
        [
            lambda h: mdr.Paraboloid(30.0 * h),
            lambda h: mdr.Cone(slope=0.1),
            lambda h: mdr.TruncatedCone(slope=0.1, flat_radius=0.3 * h),
        ]
    ),
)
@settings(max_examples=examples(10), deadline=None)
def test_fields_of_a_fast_indentation_are_elastic(scale, pressing, poisson, bond, shape):
    body = mdr.Layered([layer(poisson, thickness=scale)], bond=bond)
    depth = pressing * scale / 60.0
    profile = shape(scale)
    result = mdr.solve(ball(body, profile), mdr.indent(depth, duration=1e-12))
    same = mdr.solve(ball(elastic(body, 4.0), profile), mdr.indent(depth))
    a = float(same["contact_radius"][-1])
    error = result.claims["pressure"].error[-1]
    r = np.array([0.15, 0.6, 0.85]) * a
    pressure, expected = (one.field("pressure", r=r).values for one in (result, same))
    np.testing.assert_allclose(pressure, expected, rtol=0, atol=(error + 1e-9) * expected.max())
    beyond = np.array([1.1, 1.5, 3.0]) * a
    # the difference of all and half the springs may miss that of a corner between two springs
    most = 3e-4 if profile.breakpoints else 1e-7
    for name in ("normal_displacement", "gap"):
        moved, known = (one.field(name, r=beyond).values for one in (result, same))
        np.testing.assert_allclose(moved, known, rtol=0, atol=(result.claims[name].error[-1] + most) * depth)
    stress, known = (
        one.field("stress", r=[0.2 * a, 1.3 * a], z=[0.3 * a, scale]).values for one in (result, same)
    )
    np.testing.assert_allclose(stress, known, rtol=0, atol=1e-5 * expected.max())


@given(
    scale=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    pressing=st.floats(0.1, 2.0),
    poisson=st.sampled_from([0.0, 0.3, 0.5]),
    slow=st.booleans(),
)
@settings(max_examples=examples(4), deadline=None)
def test_largest_stresses_of_fast_and_slow_indentations_are_elastic(scale, pressing, poisson, slow):
    body = mdr.Layered([layer(poisson, thickness=scale)])
    profile, depth = mdr.Paraboloid(30.0 * scale), pressing * scale / 60.0
    result = mdr.solve(ball(body, profile), mdr.indent(depth, duration=1e8 if slow else 1e-12))
    same = mdr.solve(ball(elastic(body, 1.0 if slow else 4.0), profile), mdr.indent(depth))
    size = float(same["peak_pressure"][-1])
    for name in ("von_mises", "tresca", "interface_shear"):
        results, known = (one.largest(name, step=-1) for one in (result, same))
        assert float(results) == pytest.approx(float(known), abs=1e-5 * size)
    assert float(result["largest_mises"][-1]) == pytest.approx(float(result.largest("von_mises", step=-1)))
    with pytest.raises(mdr.NotValidError, match="in a body with memory it depends on the whole history"):
        result.field("interior_displacement", r=[0.0], z=[scale / 2.0])


def test_yield_of_layers_with_memory_is_refused():
    for verb in (mdr.first_yield, mdr.shakedown):
        with pytest.raises(mdr.NotValidError, match="in bodies with memory it depends on the history"):
            verb(ball(mdr.Layered([layer()])), strength="1 MPa")


def test_fields_of_a_history_are_those_of_rings():
    body = mdr.Layered([layer(), layer(0.3, SOLID.scaled(2.0), "0.5 mm")], bond="frictionless")
    by_springs = mdr.solve(ball(body), UP_AND_DOWN)
    by_rings = mdr.solve(ball(body), UP_AND_DOWN, solver=mdr.Rings(80))
    (base,) = [one for one in by_springs.assumptions if one.name == "contact of the base"]
    alike = mdr.solve(ball(elastic(body)), mdr.indent("0.12 mm")).assumptions
    assert base.measure == pytest.approx(
        next(one.measure for one in alike if one.name == base.name), rel=1e-6
    )
    for row in (9, 14, 29):
        a = float(by_springs["contact_radius"][row])
        r = np.array([0.1, 0.5, 0.8, 1.2, 2.0]) * a
        for name, most in (("pressure", 1e-4), ("normal_displacement", 1e-4)):
            springs, rings = (one.field(name, r=r, step=row).values for one in (by_springs, by_rings))
            np.testing.assert_allclose(springs, rings, rtol=0, atol=most * np.abs(rings).max())


def test_work_is_stored_or_dissipated():
    result = mdr.solve(ball(mdr.Layered([layer()])), UP_AND_DOWN)
    work, stored, dissipated = (
        result[name].values for name in ("external_work", "elastic_energy", "dissipated_energy")
    )
    assert work == pytest.approx(stored + dissipated, rel=1e-9)
    assert np.all(np.diff(dissipated) > 0.0)


def test_creep_passes_the_depths_that_are_resolved_beyond_its_own():
    # a search of twice the depth would end at radii that the layers do not resolve
    path = mdr.load("5 N", duration="10 ms", steps=20) >> mdr.hold("1 s", steps=20)
    result = mdr.solve(ball(mdr.Layered([layer(0.45)]), mdr.Sphere("10 mm")), path)
    rest = mdr.solve(ball(elastic(mdr.Layered([layer(0.45)])), mdr.Sphere("10 mm")), mdr.load("5 N"))
    assert float(result["indentation"][-1]) == pytest.approx(float(rest["indentation"][-1]), rel=1e-6)
    a = float(rest["contact_radius"][-1])
    pressure, resting = (one.field("pressure", r=[0.0, 0.5 * a]).values for one in (result, rest))
    np.testing.assert_allclose(pressure, resting, rtol=1e-4)


def test_cases_files_and_figures(tmp_path):
    contact = ball(mdr.Layered([layer()]))
    path = mdr.indent("0.1 mm", duration="10 ms", steps=5)
    assert decode_case(encode_case("", contact, path))[1] == contact
    result = mdr.solve(contact, path)
    result.save(tmp_path / "layer.nc")
    again = mdr.open_result(tmp_path / "layer.nc")
    assert again.contact == contact
    assert set(again.figures()) == {"section", "loop", "history", "fields"}
    assert again.plot("stress").axes
    radii = [0.0, 5e-4]
    np.testing.assert_array_equal(again.field("pressure", r=radii), result.field("pressure", r=radii))


GLASS = mdr.Elastic("70 GPa", 0.2)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.Layered([layer()], base=GLASS), "viscoelastic layers on an elastic base"),
        (
            lambda: mdr.Layered([layer(), mdr.Layer(GLASS, "1 mm")]),
            "elastic and viscoelastic layers are mixed",
        ),
        (
            lambda: mdr.Layered([layer(), layer(shear=mdr.StandardSolid("1 MPa", "3 MPa", "11 ms"))]),
            "layer 2 relaxes differently from the first",
        ),
        (
            lambda: mdr.Layer(mdr.Viscoelastic(SOLID, bulk="1 GPa"), "1 mm"),
            "give poisson instead of bulk",
        ),
        (
            lambda: mdr.Contact(mdr.Cone(slope=0.1), mdr.Layered([layer()]), GLASS),
            "need a rigid other body, not Elastic",
        ),
        (
            lambda: mdr.Contact(mdr.Cone(slope=0.1), mdr.Layered([layer()]), adhesion=mdr.JKR("50 mJ/m^2")),
            "JKR of viscoelastic layers is not available",
        ),
        (
            lambda: mdr.Contact(mdr.Cone(slope=0.1), mdr.Layered([layer()]), friction=mdr.Coulomb(0.3)),
            "friction of a layered body",
        ),
    ],
)
def test_refusals(make, words):
    with pytest.raises(mdr.ProblemError, match=words):
        make()
