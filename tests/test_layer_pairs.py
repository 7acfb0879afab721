"""Two elastic bodies, one or both of them layered: against rings, identities and limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.independent.stacks import pair_of
from pymdr.line.lines import line_of
from pymdr.mapping.layers import kernel_of
from pymdr.problem.codec import decode_case, encode_case

STEEL, ALUMINIUM = mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.33)
BALL = mdr.Sphere("5 mm")


def coat(young="400 GPa", poisson=0.2, thickness="20 um", base=STEEL, **others):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, poisson), thickness)], base=base, **others)


def quantities(contact, path=None):
    result = mdr.solve(contact, path or mdr.load("20 N", steps=2))
    return {
        name: result[name].values
        for name in ("indentation", "contact_radius", "normal_stiffness", "elastic_energy")
    }


def assert_alike(one, other, rel):
    for name, values in quantities(one).items():
        assert values == pytest.approx(quantities(other)[name], rel=rel), name


MODULI = st.floats(-1.0, 1.0).map(lambda x: 10.0**x)
POISSON = st.sampled_from([0.0, 0.3, 0.5])


@st.composite
def bodies(draw):
    layers = [
        mdr.Layer(mdr.Elastic(draw(MODULI), draw(POISSON)), 10.0 ** draw(st.floats(-0.5, 0.5)))
        for _ in range(draw(st.integers(1, 2)))
    ]
    base = draw(st.one_of(st.just(mdr.Rigid()), st.builds(mdr.Elastic, MODULI, POISSON)))
    return mdr.Layered(layers, base=base, bond=draw(st.sampled_from(["bonded", "frictionless"])))


others = st.one_of(st.builds(mdr.Elastic, MODULI, POISSON), bodies())


@given(bodies(), others, st.floats(0.03, 30.0))
@settings(max_examples=examples(20), deadline=None)
def test_compliances_of_two_surfaces_add(one, other, wave):
    pair, stack = kernel_of(one, other).compliance, pair_of(one, other)
    assert pair.modulus == pytest.approx(stack.modulus, rel=1e-14)
    # an independent solution of the plane waves, in wavenumbers of length
    total = stack.flat + sum(float(each.compliance([wave])[0]) / each.modulus for each in stack.stacks)
    assert float(pair.ratio(wave * pair.thickness).real) == pytest.approx(total * pair.modulus, rel=1e-10)
    short = float(pair.shortfall(wave * pair.thickness).real)
    assert short == pytest.approx(1.0 - total * pair.modulus, abs=1e-12 * max(1.0, total * pair.modulus))


def test_the_kernel_is_the_sum_of_those_of_both():
    one, other = coat(thickness="20 um"), coat("20 GPa", 0.4, "70 um", base=mdr.Rigid())
    pair, parts = kernel_of(one, other), (kernel_of(one), kernel_of(other))
    t = np.array([0.0, 0.3, 1.9, 2.1, 30.0])
    total = sum(
        pair.compliance.modulus / part.compliance.modulus * part(t * scale) * scale
        for part, scale in zip(parts, (1.0, 20.0 / 70.0), strict=True)
    )
    assert pair(t) == pytest.approx(total, rel=1e-11, abs=1e-12 * pair.size)


def test_two_equal_bodies_are_one_of_half_the_modulus():
    half = coat("200 GPa", 0.2, base=mdr.Elastic("105 GPa", 0.3))
    assert_alike(mdr.Contact(BALL, coat(), coat()), mdr.Contact(BALL, half), 1e-13)


def test_bodies_may_change_places():
    assert_alike(mdr.Contact(BALL, coat(), STEEL), mdr.Contact(BALL, STEEL, coat()), 1e-14)


@pytest.mark.parametrize(
    "other",
    [
        ALUMINIUM,
        mdr.TransverselyIsotropic(
            c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa"
        ),
    ],
)
def test_a_coat_like_its_base_is_a_half_space(other):
    same = coat("210 GPa", 0.3)
    assert_alike(mdr.Contact(BALL, same, other), mdr.Contact(BALL, STEEL, other), 1e-12)


def test_a_very_stiff_ball_is_rigid():
    stiff = mdr.Contact(BALL, coat(), mdr.Elastic(1e24, 0.3))
    assert_alike(stiff, mdr.Contact(BALL, coat()), 1e-11)


def test_a_steel_ball_differs_from_a_rigid_one():
    paths = mdr.load("20 N")
    steel, rigid = (
        mdr.solve(mdr.Contact(BALL, coat(thickness="2 um"), one), paths) for one in (STEEL, mdr.Rigid())
    )
    assert 0.55 < float(rigid["peak_pressure"][0] / steel["peak_pressure"][0]) - 1.0 < 0.62


@given(bodies(), others, st.floats(0.1, 2.0), st.floats(0.05, 0.3))
@settings(max_examples=2, deadline=None)
def test_line_and_rings_agree_on_any_pair(one, other, width, depth):
    a = width * one.layers[0].thickness
    contact = mdr.Contact(mdr.Paraboloid(a), one, other)
    result = mdr.verify(contact, mdr.indent(depth * a), elements=60, steps=1)
    assert result.largest_difference < 1e-4
    for name in ("contact_radius", "normal_stiffness", "elastic_energy"):
        assert abs(result.data[f"{name}_difference"].item()) < 1e-4
    assert result.data["pressure_difference"].item() < 1e-3


def test_adhesion_is_that_of_rings():
    gel = coat("1 MPa", 0.5, "100 um", base=mdr.Rigid())
    contact = mdr.Contact(mdr.Sphere("1 mm"), gel, mdr.Elastic("2 MPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    result = mdr.verify(contact, mdr.indent("10 um"), elements=80, steps=1)
    assert result.largest_difference < 1e-5


def test_a_pair_is_consistent():
    contact = mdr.Contact(mdr.Paraboloid("5 mm"), coat(), coat("3 GPa", 0.4, "50 um", base=mdr.Rigid()))
    line, a = line_of(contact), 30e-6
    step = 1e-4 * a
    rise = (line.force(a + step) - line.force(a - step)) / (line.depth(a + step) - line.depth(a - step))
    assert float(rise) == pytest.approx(float(line.stiffness(a)), rel=1e-7)
    growth = (line.stiffness(a + step) - line.stiffness(a - step)) / (2.0 * step)
    assert float(growth) == pytest.approx(float(line.stiffness_rate(a)), rel=1e-7)
    work = (line.energy(a + step) - line.energy(a - step)) / (line.depth(a + step) - line.depth(a - step))
    assert float(work) == pytest.approx(float(line.force(a)), rel=1e-7)


def test_claims_name_both_bodies():
    result = mdr.solve(mdr.Contact(BALL, coat(), STEEL), mdr.load("20 N"))
    claim = result.claims["pressure"]
    assert claim.level is mdr.Level.EXACT
    assert "bonded to an elastic half-space against an elastic half-space" in claim.reason
    loose = mdr.solve(
        mdr.Contact(BALL, coat(bond="frictionless"), coat(bond="frictionless")), mdr.load("20 N")
    )
    assert [one.name for one in loose.assumptions].count("contact of the base") == 1


def test_files_know_pairs(tmp_path):
    contact, path = mdr.Contact(BALL, coat(), STEEL), mdr.load("20 N", steps=2)
    assert decode_case(encode_case("", contact, path))[1] == contact
    mdr.solve(contact, path).save(tmp_path / "pair.nc")
    assert mdr.open_result(tmp_path / "pair.nc").contact == contact
