"""Stress inside layers: against half-spaces, balances, other solutions of the surface, and the conditions at interfaces."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.interpretation.layered_stress import LayeredInterior
from pymdr.interpretation.solids import solid_of
from pymdr.interpretation.stress import line_load, stress, sums
from pymdr.line.curves import ElasticLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layer_waves import StackWaves
from pymdr.mapping.layers import Compliance
from pymdr.numerics.panels import Place

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Paraboloid("5 mm")
COAT_CASE = """
[profile]
kind = "paraboloid"
radius = "5 mm"

[body]
kind = "layered"
base = { kind = "elastic", young = "210 GPa", poisson = 0.3 }

[[body.layers]]
material = { kind = "elastic", young = "400 GPa", poisson = 0.2 }
thickness = "100 um"

[counterbody]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
"""


def coat(young="400 GPa", poisson=0.2, thickness="20 um", base=STEEL, **others):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, poisson), thickness)], base=base, **others)


def pressed(profile, *bodies, **others):
    return mdr.solve(mdr.Contact(profile, *bodies, **others), mdr.load("20 N"))


MODULI = st.floats(-1.0, 1.0).map(lambda x: 10.0**x)
POISSON = st.sampled_from([-0.3, 0.0, 0.3, 0.5])


@st.composite
def stacks(draw):
    layers = [
        mdr.Layer(mdr.Elastic(draw(MODULI), draw(POISSON)), 10.0 ** draw(st.floats(-0.5, 0.5)))
        for _ in range(draw(st.integers(1, 3)))
    ]
    base = draw(st.one_of(st.just(mdr.Rigid()), st.builds(mdr.Elastic, MODULI, POISSON)))
    return mdr.Layered(layers, base=base, bond=draw(st.sampled_from(["bonded", "frictionless"])))


class UnderHertz(LayeredInterior):
    """A stack under Hertz's pressure of the radius 1 m and the peak 1 Pa."""

    def load(self, step):
        line = ElasticLine(equivalent_profile(mdr.Paraboloid(2.0 / math.pi)), 1.0)
        return line_load(line, Place(np.float64(0.0), np.float64(1.0)), 0.0)

    def tensor(self, layer, r, z):
        r, z = (np.ravel(one) for one in np.broadcast_arrays(r, z))
        total = self._rest_in(layer, r, z, 0)
        return total + stress(sums(self.load(0), r, z), self.solid.poisson) if layer == 0 else total

    def moved(self, layer, r, z):
        r, z = (np.ravel(one) for one in np.broadcast_arrays(np.asarray(r, float), np.asarray(z, float)))
        return self._displacement_in(layer, r, z, 0)


def under_hertz(body):
    return UnderHertz(None, solid_of(body), layered=body)


# -- waves -------------------------------------------------------------------------------------------


@given(stacks())
@settings(max_examples=examples(20), deadline=None)
def test_waves_move_the_surface_as_its_compliance_says(body):
    compliance, s = Compliance(body), np.geomspace(1e-3, 60.0, 15)
    computed = StackWaves(body, s / compliance.thickness).surface_ratio()
    exact = compliance.ratio(s).real
    assert np.all(np.abs(computed - exact) <= 1e-12 * np.maximum(1.0, 100.0 * exact))


# -- fields ------------------------------------------------------------------------------------------


def test_the_jump_at_the_interface_of_a_coat():
    # shear moduli of 5 and 1, nu of 0.25 and 0.3
    body = mdr.Layered([mdr.Layer(mdr.Elastic(12.5, 0.25), 0.8)], base=mdr.Elastic(2.6, 0.3))
    inside = under_hertz(body)
    above, below = (inside.tensor(layer, 0.7, 0.8)[:, 0] for layer in (0, 1))
    assert above[0] == pytest.approx(0.2621, abs=5e-5)
    assert below[0] == pytest.approx(-0.0424, abs=5e-5)
    assert above[2:] == pytest.approx(below[2:], abs=1e-11)


@pytest.mark.parametrize(
    ("name", "layer"),
    [("coat_stress_0.0_0.8", 0), ("coat_stress_0.7_0.8_below", 1), ("coat_stress_1.2_0.3", 0)],
)
def test_a_coat_under_the_pressure_of_hertz(references, name, layer):
    entry = references[name]
    body = mdr.Layered([mdr.Layer(mdr.Elastic(12.5, 0.25), 0.8)], base=mdr.Elastic(2.6, 0.3))
    computed = under_hertz(body).tensor(layer, entry["inputs"]["r"], entry["inputs"]["z"])[:, 0]
    expected = [entry["expected"][part] for part in ("srr", "stt", "szz", "srz")]
    assert computed == pytest.approx(expected, rel=entry["rtol"], abs=1e-11)


@pytest.mark.parametrize("profile", [BALL, mdr.Cone(slope=0.02), mdr.FlatPunch("60 um")])
def test_layers_of_one_material_are_a_half_space(profile):
    same = mdr.Layered([mdr.Layer(STEEL, "20 um"), mdr.Layer(STEEL, "30 um")], base=STEEL)
    stack, plain = (pressed(profile, body) for body in (same, STEEL))
    r = np.linspace(0.0, 150e-6, 9)
    z = np.array([0.0, 5e-9, 1e-6, 10e-6, 20e-6, 20e-6, 35e-6, 50e-6, 50e-6, 80e-6, 300e-6])
    for name, size in (("stress", "mean_pressure"), ("interior_displacement", "indentation")):
        one, other = (result.field(name, r=r, z=z).values for result in (stack, plain))
        finite = np.isfinite(other)
        assert one[finite] == pytest.approx(other[finite], abs=1e-11 * float(plain[size][0]))
        assert np.array_equal(np.isinf(one), np.isinf(other))


@given(
    kind=st.sampled_from(["flat", "cone", "tip"]),
    size=st.floats(-8.0, 0.0).map(lambda x: 10.0**x),
    thickness=st.floats(-1.7, 0.5).map(lambda x: 10.0**x),
    fraction=st.floats(0.05, 0.5),
)
@settings(max_examples=5, deadline=None)
def test_profiles_with_kinks_on_layers_of_one_material(kind, size, thickness, fraction):
    """The load on the line has a root behind a kink, which the waves have to resolve: they erred by up to all of the stress."""
    if kind == "tip":
        r = np.linspace(0.0, 0.5, 11)
        profile = mdr.Sampled(size * r, size * (0.5 * r**2 + 0.05 * r**3))
    else:
        profile = {
            "flat": mdr.RoundedFlat(fraction * size, size),
            "cone": mdr.RoundedCone(0.2 * fraction * size, half_angle="75 deg"),
        }[kind]
    solid = mdr.Elastic("70 GPa", 0.3)
    layered = mdr.Layered([mdr.Layer(solid, thickness * size)], base=solid)
    path = mdr.indent(2e-3 * size)
    on_layers, plain = (mdr.solve(mdr.Contact(profile, body), path) for body in (layered, solid))
    a = float(plain["contact_radius"][-1])
    where = {
        "r": a * np.array([0.0, 0.5, 0.97, 1.4]),
        "z": np.array([0.3, 0.9, 1.1, 2.0]) * min(thickness * size, a),
    }
    expected = plain.field("stress", **where).values
    assert on_layers.field("stress", **where).values == pytest.approx(
        expected, abs=1e-8 * np.abs(expected).max()
    )


def test_an_adhesive_edge_on_layers_of_one_material():
    same, bulk = coat("1 MPa", 0.45, "50 um", mdr.Elastic("1 MPa", 0.45)), mdr.Elastic("1 MPa", 0.45)
    results = [
        mdr.solve(
            mdr.Contact(mdr.Paraboloid("1 mm"), body, adhesion=mdr.JKR("50 mJ/m^2")), mdr.indent("1 um")
        )
        for body in (same, bulk)
    ]
    r, z = np.linspace(0.0, 150e-6, 7), np.array([1e-6, 30e-6, 50e-6, 90e-6])
    one, other = (result.field("stress", r=r, z=z).values for result in results)
    assert one == pytest.approx(other, abs=1e-11 * np.abs(other).max())


@given(stacks(), st.floats(0.0, 2.0))
@settings(max_examples=examples(6), deadline=None)
def test_interfaces_pass_tractions_and_displacements(body, r):
    inside = under_hertz(body)
    for layer, depth in enumerate(inside.interfaces):
        last = layer + 1 == len(body.layers)
        sliding = last and body.bond == "frictionless"
        above = inside.tensor(layer, r, depth)[:, 0]
        moved = inside.moved(layer, r, depth)[:, 0]
        softness = 1.0 / min(one.material.shear for one in body.layers)
        if sliding:
            assert above[3] == pytest.approx(0.0, abs=1e-9)
        if last and not isinstance(body.base, mdr.Elastic):
            cut = moved[1:] if sliding else moved
            assert cut == pytest.approx(0.0, abs=1e-9 * softness)
            continue
        below, under = (one(layer + 1, r, depth)[:, 0] for one in (inside.tensor, inside.moved))
        assert above[2:] == pytest.approx(below[2:], abs=1e-9)
        softness += 1.0 / body.base.shear if last else 0.0
        compared = slice(1, 2) if sliding else slice(0, 2)
        assert moved[compared] == pytest.approx(under[compared], abs=1e-9 * softness)


@given(stacks(), st.floats(0.1, 2.0), st.floats(0.05, 0.95), st.integers(0, 3))
@settings(max_examples=examples(8), deadline=None)
def test_equilibrium_and_hooke_inside_layers(body, r, fraction, which):
    inside = under_hertz(body)
    solids = [layer.material for layer in body.layers] + [body.base] * isinstance(body.base, mdr.Elastic)
    layer = min(which, len(solids) - 1)
    top = (0.0, *inside.interfaces)[layer]
    z = top + fraction * (body.layers[layer].thickness if layer < len(body.layers) else 1.0)
    step = 1e-3
    shifts = step * np.array([-2.0, -1.0, 1.0, 2.0])
    slope = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    along_r, along_z = (
        inside.tensor(layer, r + shifts, z) @ slope,
        inside.tensor(layer, r, z + shifts) @ slope,
    )
    rr, tt, zz, rz = inside.tensor(layer, r, z)[:, 0]
    assert along_r[0] + along_z[3] + (rr - tt) / r == pytest.approx(0.0, abs=1e-7)
    assert along_r[3] + along_z[2] + rz / r == pytest.approx(0.0, abs=1e-7)
    u = inside.moved(layer, r, z)[0, 0]
    by_r, by_z = inside.moved(layer, r + shifts, z) @ slope, inside.moved(layer, r, z + shifts) @ slope
    solid = solids[layer]
    strains = np.array([by_r[0], u / r, by_z[1], 0.5 * (by_z[0] + by_r[1])])
    trace = rr + tt + zz
    expected = np.array([(1.0 + solid.poisson) * s - solid.poisson * trace for s in (rr, tt, zz)])
    expected = np.append(expected, (1.0 + solid.poisson) * rz) / solid.young
    assert strains == pytest.approx(expected, abs=1e-7 / solid.young * max(1.0, np.abs([rr, tt, zz]).max()))


@given(stacks(), st.floats(1.1, 3.0), st.floats(0.1, 1.0))
@settings(max_examples=examples(6), deadline=None)
def test_cylinders_around_the_load_are_in_balance(body, radius, fraction):
    inside = under_hertz(body)
    nodes, weights = np.polynomial.legendre.leggauss(32)
    tops = [0.0, *inside.interfaces]
    elastic = isinstance(body.base, mdr.Elastic)
    ends = [*tops, tops[-1] + fraction] if elastic else tops
    force = 0.0
    for layer, (top, bottom) in enumerate(itertools.pairwise(ends)):
        z = top + 0.5 * (bottom - top) * (nodes + 1.0)
        force += inside.tensor(layer, radius, z)[3] @ (math.pi * radius * (bottom - top) * weights)
    # at the foot split at the edge, for layers that are thin there
    for low, high in ((0.0, 0.5), (0.5, 1.0), (1.0, radius)):
        r = low + 0.5 * (high - low) * (nodes + 1.0)
        axial = inside.tensor(len(ends) - 2, r, ends[-1])[2]
        force += axial @ (math.pi * r * (high - low) * weights)
    assert -force == pytest.approx(2.0 * math.pi / 3.0, rel=1e-8)


def test_surfaces_of_both_bodies_move_by_their_contact():
    other = coat("3 GPa", 0.4, "50 um", base=mdr.Elastic("70 GPa", 0.33), bond="frictionless")
    result = pressed(BALL, coat(), other)
    r = np.linspace(0.0, 1e-4, 9)
    whole = result.field("normal_displacement", r=r).values
    each = [
        result.field("interior_displacement", r=r, z=[0.0], side=side).sel(component="z").values[0]
        for side in ("body", "counterbody")
    ]
    assert sum(each) == pytest.approx(whole, rel=1e-9)
    plain = pressed(BALL, coat(), STEEL)
    each = [
        plain.field("interior_displacement", r=r, z=[0.0], side=side).sel(component="z").values[0]
        for side in ("body", "counterbody")
    ]
    assert sum(each) == pytest.approx(plain.field("normal_displacement", r=r).values, rel=1e-9)


def test_a_thin_coat_leaves_the_base_as_it_is_but_for_its_thickness():
    z, base, h = np.array([0.2, 0.5, 1.0]), mdr.Elastic(1.0, 0.3), 1e-2
    results = [
        under_hertz(coat(5.0, 0.25, thickness, base=base)).tensor(1, 0.5, z + thickness)
        for thickness in (h, 2.0 * h, 4.0 * h)
    ]
    load = under_hertz(coat()).load(0)
    exact = stress(sums(load, np.full(3, 0.5), z), base.poisson)
    errors = [float(np.max(np.abs(one - exact))) for one in results]
    assert 0.4 * errors[2] < errors[1] < 0.7 * errors[2]
    limit = (8.0 * results[0] - 6.0 * results[1] + results[2]) / 3.0
    assert np.max(np.abs(limit - exact)) < 0.2 * errors[0]


@given(st.floats(-1.0, 3.0), st.floats(-3.0, 3.0), st.floats(-9.0, 0.0), st.integers(0, 3), st.booleans())
@settings(max_examples=examples(3), deadline=None)
def test_tractions_of_thin_thick_soft_and_stiff_coats(thickness, contrast, metre, kind, elastic_ball):
    a = 10.0**metre
    h = a * 10.0**thickness
    profile, depth = (
        (mdr.Paraboloid(30.0 * a), a / 30.0),
        (mdr.Cone(slope=0.1), 0.1 * a),
        (mdr.TruncatedCone(slope=0.1, flat_radius=0.6 * a), 0.05 * a),
        (mdr.FlatPunch(a), 0.01 * a),
    )[kind]
    body = coat(1e6 * 10.0**contrast, 0.3, h, base=mdr.Elastic(1e6, 0.4))
    others = [mdr.Elastic(1e7, 0.2)] if elastic_ball else []
    result = mdr.solve(mdr.Contact(profile, body, *others), mdr.indent(depth))
    r = float(result["contact_radius"][-1]) * np.array([0.2, 0.7, 1.2, 5.0])
    field = result.field("stress", r=r, z=[0.0, 0.5 * h, h, h, 2.0 * h])
    pressure = result.field("pressure", r=r).values
    axial, shear = (field.sel(component=name).values for name in ("zz", "rz"))
    size = 1e-8 * pressure.max()
    assert np.all(np.isfinite(field.values))
    assert axial[0] == pytest.approx(-pressure, abs=size)
    assert shear[0] == pytest.approx(0.0, abs=size)
    for traction in (axial, shear):
        assert traction[2] == pytest.approx(traction[3], abs=size)


@settings(max_examples=examples(3), deadline=None)
@given(st.floats(-8.0, 3.0), st.floats(-9.0, 9.0))
def test_units_do_not_matter(metre, pascal):
    length, size = 10.0**metre, 10.0**pascal
    body = coat(5.0 * size, 0.25, 0.8 * length, base=mdr.Elastic(size, 0.4))
    one = mdr.solve(mdr.Contact(mdr.Paraboloid(5.0 * length), body), mdr.indent(0.1 * length))
    unit = mdr.solve(
        mdr.Contact(mdr.Paraboloid(5.0), coat(5.0, 0.25, 0.8, base=mdr.Elastic(1.0, 0.4))), mdr.indent(0.1)
    )
    r, z = np.array([0.0, 0.4, 1.1]), np.array([0.0, 0.3, 0.8, 2.0])
    computed = one.field("stress", r=r * length, z=z * length).values
    expected = unit.field("stress", r=r, z=z).values
    assert computed / size == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


# -- reading -----------------------------------------------------------------------------------------


def test_both_sides_of_an_interface_are_read():
    result = pressed(BALL, coat())
    field = result.field("stress", r=["0 um", "30 um"], z=["0 um", "20 um", "20 um", "40 um"])
    assert field["layer"].values.tolist() == [0, 0, 1, 1]
    rr, zz = field.sel(component="rr").values, field.sel(component="zz").values
    assert np.all(np.abs(rr[1] - rr[2]) > 1e7)
    assert zz[1] == pytest.approx(zz[2], rel=1e-9)
    drawn = result.field("von_mises")
    assert np.count_nonzero(np.diff(drawn["z"].values) == 0.0) == 1
    assert np.isfinite(drawn.values).all()


def test_rigid_bases_have_no_stress():
    film = pressed(BALL, coat("3 GPa", 0.5, base=mdr.Rigid()))
    field = film.field("von_mises", r=[0.0], z=["10 um", "20 um", "20.1 um"])
    assert np.isnan(field.values[:, 0]).tolist() == [False, False, True]
    assert film.largest("von_mises", step=-1)["layer"] == 0.0


@pytest.mark.parametrize("thickness", ["5 um", "30 um", "1 mm"])
def test_nothing_exceeds_the_largest_stress(thickness):
    result = pressed(BALL, coat(thickness=thickness), STEEL)
    largest = result.largest("von_mises", step=-1)
    a = float(result["contact_radius"][0])
    field = result.field("von_mises", r=a * np.linspace(0.0, 2.0, 81))
    assert float(field.max()) <= float(largest) * (1.0 + 1e-9)
    at = result.field("von_mises", r=[float(largest["r"])], z=[float(largest["z"])] * 2)
    assert float(np.max(at.values)) == pytest.approx(float(largest), rel=1e-8)


def test_first_yield_with_a_strength_for_every_layer():
    contact = mdr.Contact(BALL, coat(), STEEL)
    soft_base = mdr.first_yield(contact, strength=["20 GPa", "1 GPa"])
    assert soft_base["yield_layer"].values.tolist() == [1.0, 1.0]
    force = float(soft_base["normal_force"][0])
    interior = mdr.solve(contact, mdr.load(force))
    z = float(soft_base["yield_depth"][0])
    r = float(soft_base["yield_radius"][0])
    mises = interior.field("von_mises", r=[r], z=[z, z])
    assert mises.values[-1, 0] == pytest.approx(1e9, rel=1e-6)
    assert mdr.first_yield(contact, strength="1 GPa")["normal_force"][0] <= force
    with pytest.raises(mdr.ProblemError, match="3 values of strength for 2 elastic parts"):
        mdr.first_yield(contact, strength=["1 GPa"] * 3)


def test_largest_stress_at_edges_of_layers_is_refused():
    film = mdr.solve(mdr.Contact(mdr.FlatPunch("30 um"), coat("3 GPa", 0.4)), mdr.indent("10 nm"))
    with pytest.raises(mdr.NotValidError, match="sharp"):
        film["largest_mises"]
    assert film.plot_stress().axes


@pytest.mark.parametrize("base", [STEEL, mdr.Rigid()], ids=["elastic", "rigid"])
def test_the_largest_tractions_on_interfaces(base):
    layers = [mdr.Layer(mdr.Elastic("400 GPa", 0.2), "20 um"), mdr.Layer(mdr.Elastic("90 GPa", 0.4), "50 um")]
    result = pressed(BALL, mdr.Layered(layers, base=base), STEEL)
    r = np.linspace(0.0, 3e-4, 601)
    stress = result.field("stress", r=r, z=["20 um", "70 um"])
    shear, tension = np.abs(stress.sel(component="rz").values), stress.sel(component="zz").values
    computed = result.largest("interface_shear", step=-1)
    assert float(computed) >= shear.max()
    assert float(computed) == pytest.approx(shear.max(), rel=1e-3)
    assert float(computed["z"]) == pytest.approx((20e-6, 70e-6)[int(np.argmax(shear.max(axis=1)))])
    computed = result.largest("interface_tension", step=-1)
    if tension.max() > 1e-9 * np.abs(tension).max():
        assert float(computed) >= tension.max()
        assert float(computed) == pytest.approx(tension.max(), rel=1e-3)
    else:
        assert float(computed) == 0.0
    with pytest.raises(mdr.QuantityError, match=r"von_mises, tresca, principal_stress$"):
        result.largest("interface_shear", side="counterbody")


def test_an_edge_that_is_singular_shears_the_interface_to_a_bound():
    film = mdr.solve(mdr.Contact(mdr.FlatPunch("30 um"), coat("3 GPa", 0.4)), mdr.indent("10 nm"))
    assert 0.0 < float(film.largest("interface_shear", step=-1)) < math.inf


def test_layers_without_contact_bear_no_stress():
    contact = mdr.Contact(BALL, coat(), adhesion=mdr.JKR("50 mJ/m^2"))
    result = mdr.solve(contact, mdr.indent("0.1 um") >> mdr.indent("-10 um"))
    field = result.field("von_mises", r=[0.0], z=["0 um", "20 um", "20 um"], step=None)
    assert (field.values[0] > 0.0).all()
    assert (field.values[1] == 0.0).all()


def test_stress_in_layers_is_claimed():
    claim = pressed(BALL, coat()).claims["stress"]
    assert claim.level is mdr.Level.EXACT
    assert "Burmister" in claim.source


def test_first_yield_of_layers_from_the_shell(tmp_path, shell):
    case = tmp_path / "coat.toml"
    case.write_text(COAT_CASE)
    status, out, _ = shell("yield", case, "--strength", "20 GPa", "--strength", "1 GPa")
    assert status == 0
    assert "layer" in out
    status, _, err = shell("yield", case, *["--strength", "1 GPa"] * 3)
    assert status != 0
    assert "3 values of strength for 2 elastic parts" in err
