"""Conductance, Joule heat and frictional heat: against potentials, boundary elements, conduction on bars, and refusals."""

import json
import math
import pickle
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import solve_banded
from scipy.special import ellipe, ellipk, ellipkm1, i0e

import pymdr as mdr
from common import REFERENCES
from drawing import examples
from pymdr.line.heating import LORENZ
from pymdr.problem.codec import decode_case, encode

REFERENCES = {entry["id"]: entry for entry in REFERENCES}
COPPER = {"thermal_conductivity": 390.0, "resistivity": 17e-9}
SINK = mdr.Rigid(thermal_conductivity=200.0, resistivity=26e-9)
GEL = mdr.Elastic("30 kPa", 0.5, thermal_conductivity=0.6)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "10 ms"), poisson=0.5, thermal_conductivity=0.2)
PIN = mdr.Rigid(thermal_conductivity=20.0)
DISK = mdr.Elastic(1e9, 0.5, thermal_conductivity=45.0, thermal_diffusivity=12e-6)

sizes = st.floats(-9.0, 0.0).map(lambda x: 10.0**x)
moduli = st.floats(3.0, 12.0).map(lambda x: 10.0**x)
conductivities = st.floats(-9.0, 9.0).map(lambda x: 10.0**x)


@st.composite
def shapes(draw):
    """A profile of any size, and an indentation that presses it in a little."""
    size, steep = draw(sizes), draw(st.floats(0.01, 0.2))
    profile = draw(
        st.sampled_from(
            (
                mdr.Paraboloid(size),
                mdr.Sphere(size),
                mdr.Cone(slope=steep),
                mdr.PowerLaw(draw(st.floats(0.5, 6.0)), steep * size, size),
                mdr.FlatPunch(0.1 * size),
                mdr.TruncatedCone(slope=steep, flat_radius=0.05 * size),
                mdr.FlatPunch(0.1 * size) + mdr.Paraboloid(size),
            )
        )
    )
    return profile, draw(st.floats(1e-5, 1e-3)) * size


NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
TOWARD = 0.2 ** np.arange(11.0)


def potential(flux, radius, r, kinks=()):
    """Rise of a half-space of conductivity 1 at a radius in a disk of some flux, ring by ring, graded to where it is singular."""
    ends = sorted({0.0, *(math.asin(x / radius) for x in (r, *kinks) if x < radius), 0.5 * math.pi})
    marks = np.array(ends)
    for low, high in pairwise(ends):
        marks = np.append(marks, low + 0.5 * (high - low) * TOWARD)
        if high < ends[-1]:
            marks = np.append(marks, high - 0.5 * (high - low) * TOWARD)
    marks = np.unique(marks)
    half = 0.5 * np.diff(marks)[:, None]
    angle = (marks[:-1, None] + half * (1.0 + NODES)).ravel()
    weight = (half * WEIGHTS).ravel()
    s = radius * np.sin(angle)
    # a ring of q dA / (2 pi R): K(m) / (r + s), m = 4 r s / (r + s)^2
    distance = ((r - s) / (r + s)) ** 2
    ring = 2.0 / math.pi * ellipkm1(np.maximum(distance, 1e-300)) / (r + s)
    return float(np.sum(weight * flux(s) * s * radius * np.cos(angle) * ring))


def test_references():
    holm, hertz, rub = (REFERENCES[name] for name in ("holm", "barber_hertz", "fric_temp"))
    given = holm["inputs"]
    punch = mdr.Contact(
        mdr.FlatPunch(given["a"]),
        mdr.Elastic(1.0, 0.0, resistivity=given["rho1"]),
        mdr.Rigid(resistivity=given["rho2"]),
    )
    assert mdr.solve(punch, mdr.indent(0.01))["electrical_resistance"].item() == pytest.approx(
        holm["expected"]["Rc"], rel=1e-15
    )
    half = hertz["inputs"]["lambda_eff"]
    body = mdr.Elastic(1.0, 0.0, thermal_conductivity=half)
    ball = mdr.Contact(mdr.Paraboloid(1.0), body, mdr.Rigid(thermal_conductivity=half))
    result = mdr.solve(ball, mdr.load(1.0))
    assert result["thermal_conductance"].item() == pytest.approx(hertz["expected"]["Lambda"], rel=1e-14)
    # all the heat goes into one half-space of lambda = 40: the other conducts next to nothing
    rubbed = mdr.Contact(
        mdr.Paraboloid(1.0),
        mdr.Elastic(1e6, 0.0, thermal_conductivity=40.0, thermal_diffusivity=1.0),
        mdr.Rigid(thermal_conductivity=1e-30),
        friction=mdr.Coulomb(0.3),
    )
    rise = mdr.frictional_heat(rubbed, 2.0, indentation=1e-4)["largest_temperature_rise"]
    assert rise.item() == pytest.approx(rub["expected"]["T0"], rel=1e-14)


@settings(max_examples=examples(15), deadline=None)
@given(shapes(), moduli, conductivities, conductivities)
def test_conductance_is_that_of_the_disk_at_any_size(shape, young, one, other):
    profile, depth = shape
    contact = mdr.Contact(
        profile,
        mdr.Elastic(young, 0.3, thermal_conductivity=one, resistivity=1.0 / one),
        mdr.Rigid(thermal_conductivity=other, resistivity=1.0 / other),
    )
    result = mdr.solve(contact, mdr.indent(depth, steps=3))
    line = 2.0 * one * other / (one + other)
    exact = 2.0 * result["contact_radius"].values * line
    assert result["thermal_conductance"].values == pytest.approx(exact, rel=1e-14)
    assert result["electrical_resistance"].values == pytest.approx(1.0 / exact, rel=1e-14)
    # Barber (2003)
    modulus = mdr.effective_moduli(contact.body).normal
    by_stiffness = line / modulus * result["normal_stiffness"].values
    assert result["thermal_conductance"].values == pytest.approx(by_stiffness, rel=1e-12)
    assert result.claims["thermal_conductance"].level is result.claims["contact_radius"].level


@settings(max_examples=6, deadline=None)
@given(shapes(), conductivities, conductivities, st.floats(0.01, 0.99))
def test_the_flux_makes_the_disk_isothermal(shape, one, other, fraction):
    profile, depth = shape
    contact = mdr.Contact(
        profile,
        mdr.Elastic(1e9, 0.3, thermal_conductivity=one),
        mdr.Rigid(thermal_conductivity=other),
    )
    result = mdr.solve(contact, mdr.indent(depth))
    a = result["contact_radius"].item()

    def flux(s):
        return result.field("heat_flux", s).values

    # the drop 1 is divided between the bodies as their resistances
    rise = potential(flux, a, fraction * a)
    assert rise / one + rise / other == pytest.approx(1.0, rel=1e-9)
    t = 0.5 * math.pi * (0.5 + 0.5 * NODES)
    whole = np.sum(WEIGHTS * flux(a * np.sin(t)) * np.sin(t) * np.cos(t)) * 0.5 * (math.pi * a) ** 2
    assert whole == pytest.approx(result["thermal_conductance"].item(), rel=1e-9)
    near = a * (1.0 - 1e-8)
    amplitude = float(result.field("heat_flux", near)["edge_amplitude"])
    assert flux(near)[0] * math.sqrt(a - near) == pytest.approx(amplitude, rel=1e-7)
    assert flux([a, 1.01 * a]).tolist() == [math.inf, 0.0]


def ring_conductance(zones, n):
    """Conductance 2 lambda_eff = 1 of rings by brute force: constant fluxes over n rings, graded to all edges."""
    fraction = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, n + 1)))
    low, high = np.concatenate(
        [
            np.stack(
                [(inner + (outer - inner) * fraction)[:-1], (inner + (outer - inner) * fraction)[1:]], axis=1
            )
            for inner, outer in zones
        ]
    ).T
    r = 0.5 * (low + high)

    def disk(radius, at):
        """Rise at radii of a half-space of conductivity 1 under a unit flux over a disk."""
        radius, at = np.broadcast_arrays(radius, at)
        inside = np.minimum(at, radius) / np.where(radius > 0.0, radius, 1.0)
        out = np.where(at > 0.0, np.minimum(radius, at) / at, 0.0)
        near = 2.0 * radius / math.pi * ellipe(inside**2)
        far = 2.0 * at / math.pi * (ellipe(out**2) - (1.0 - out**2) * ellipk(np.minimum(out**2, 1 - 1e-16)))
        return np.where(at <= radius, near, far)

    rises = disk(high[None, :], r[:, None]) - disk(low[None, :], r[:, None])
    flux = np.linalg.solve(rises, np.ones(r.size))
    # one half-space: 4 a lambda for a disk, and so twice lambda_eff = lambda / 2 of two
    return float(np.sum(flux * math.pi * (high**2 - low**2))) / 4.0 * 2.0


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-9.0, 0.0), st.floats(-3.0, 3.0), st.floats(-9.0, 3.0), st.integers(-4, -1))
def test_the_flux_of_a_drop_is_that_of_what_it_lets_through(radius, conductivity, amount, step):
    body = mdr.Elastic("1 GPa", 0.3, thermal_conductivity=10.0**conductivity, resistivity=10.0**-conductivity)
    ball = mdr.Contact(mdr.Paraboloid(10.0**radius), body, body)
    result = mdr.solve(ball, mdr.indent(1e-3 * 10.0**radius, steps=4))
    across = 10.0**amount
    r = result["contact_radius"].values[step] * np.array([0.0, 0.4, 0.99])
    for name, through in (
        ("heat_flux", across * result["thermal_conductance"].values[step]),
        ("current_density", across / result["electrical_resistance"].values[step]),
    ):
        unit = result.field(name, r, step)
        by_drop, by_flow = (
            result.field(name, r, step, **given) for given in ({"drop": across}, {"flow": through})
        )
        np.testing.assert_allclose(by_drop, across * unit.values, rtol=1e-14)
        np.testing.assert_allclose(by_flow, by_drop, rtol=1e-13)
        assert float(by_flow.edge_amplitude) == pytest.approx(across * float(unit.edge_amplitude), rel=1e-13)
        # an isothermal disk: j = I / (2 pi a sqrt(a^2 - r^2))
        a = result["contact_radius"].values[step]
        np.testing.assert_allclose(by_drop, through / (2.0 * math.pi * a * np.sqrt(a * a - r * r)), rtol=1e-9)
        assert by_drop.attrs["units"] in ("W/m^2", "A/m^2")
        several = result.field(name, r, [0, step], drop=across)
        np.testing.assert_allclose(several.values[1], by_drop, rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "given_", "words"),
    [
        ("heat_flux", {"drop": "20 degC"}, "difference in K"),
        ("heat_flux", {"drop": "1 K", "flow": "1 W"}, "give one of them"),
        ("pressure", {"flow": "1 A"}, "leave them out for pressure"),
    ],
)
def test_drops_that_are_none(name, given_, words):
    body = mdr.Elastic("1 GPa", 0.3, thermal_conductivity=1.0)
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), body, body), mdr.indent(1e-3))
    with pytest.raises(mdr.QuantityError, match=words):
        result.field(name, [0.0], **given_)


def test_a_disk_by_brute_force():
    """The rings converge to Holm's conductance at first order of their width at the edge, and Richardson leaves 1e-5."""
    coarse, fine = ring_conductance([(0.0, 1.0)], 60), ring_conductance([(0.0, 1.0)], 120)
    contact = mdr.Contact(
        mdr.FlatPunch(1.0),
        mdr.Elastic(1.0, 0.0, thermal_conductivity=1.0),
        mdr.Rigid(thermal_conductivity=1.0),
    )
    exact = mdr.solve(contact, mdr.indent(0.01))["thermal_conductance"].item()
    errors = [exact - coarse, exact - fine]
    assert 0.0 < errors[1] < 0.3 * errors[0]
    assert fine + (fine - coarse) / 3.0 == pytest.approx(exact, rel=1e-5)


def test_rings_in_contact_conduct_as_their_stiffness():
    """Where the contact is a ring, the method gives nothing, boundary elements the stiffness, and brute force the same."""
    hollow = mdr.FlatPunch("1 mm") + mdr.Function(lambda r: -(r**2), derivative=lambda r: -2 * r)
    contact = mdr.Contact(
        hollow, mdr.Elastic("3 MPa", 0.5, thermal_conductivity=1.0), mdr.Rigid(thermal_conductivity=1.0)
    )
    path = mdr.indent("0.8 um", steps=2)
    refused = mdr.solve(contact, path)
    with pytest.raises(mdr.NotValidError, match=r"thermal_conductance .*disk"):
        refused["thermal_conductance"]
    by_rings = mdr.solve(contact, path, solver=mdr.Rings(n=200))
    claim = by_rings.claims["thermal_conductance"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert "contacts of any shape" in claim.reason
    zone = (by_rings["inner_contact_radius"].values[-1], by_rings["contact_radius"].values[-1])
    assert zone[0] > 0.1e-3
    values = [ring_conductance([zone], n) for n in (60, 120)]
    brute = values[1] + (values[1] - values[0]) / 3.0
    assert by_rings["thermal_conductance"].values[-1] == pytest.approx(brute, rel=1e-4)
    with pytest.raises(mdr.QuantityError, match="boundary elements do not solve for the flux"):
        by_rings.field("heat_flux")


def test_a_force_curve_conducts_as_its_slope():
    """The curve of a joint gives the conductance of the surfaces whose curve it is."""
    rings = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("3 MPa", 0.5))
    depth = np.linspace(0.0, 4e-6, 81)
    force = 4.0 / 3.0 * 4e6 * math.sqrt(1e-3) * depth**1.5
    curve = mdr.ForceCurve(depth, force, modulus=4e6, contact_point=0.0)
    bodies = (mdr.Elastic(1e9, 0.5, **COPPER), SINK)
    result = mdr.solve(mdr.Contact(curve, *bodies), mdr.indent("3 um", steps=4))
    whole = mdr.solve(replace(rings, body=bodies[0], counterbody=SINK), mdr.indent("3 um", steps=4))
    for name in ("thermal_conductance", "electrical_resistance"):
        claim = result.claims[name]
        difference = np.abs(result[name].values / whole[name].values - 1.0)
        assert np.all(difference <= np.maximum(claim.error, 1e-9))
        assert "Barber (2003)" in claim.source
    with pytest.raises(mdr.NotValidError, match="not determined by a force curve"):
        result.field("heat_flux")


def test_rough_surfaces_conduct_as_their_stiffness():
    surface = mdr.RoughSurface(hurst=0.7, rms="1 um", size="1 mm", shortest="100 um")
    body = mdr.Elastic("120 GPa", 0.34, **COPPER)
    pressed = mdr.press_rough(surface, body, SINK, normal_force=["1 N", "10 N"], realisations=5)
    modulus = mdr.effective_moduli(body).normal
    line = 2.0 / (1.0 / 390.0 + 1.0 / 200.0)
    for end in ("", "_low", "_high"):
        exact = line / modulus * pressed[f"normal_stiffness{end}"].values
        assert pressed[f"thermal_conductance{end}"].values == pytest.approx(exact, rel=1e-14)
    low, mean, high = (pressed[f"electrical_resistance{end}"].values for end in ("_low", "", "_high"))
    assert np.all(low < mean)
    assert np.all(mean < high)
    assert mean == pytest.approx(
        (17e-9 + 26e-9) / 2 * modulus / pressed["normal_stiffness"].values, rel=1e-14
    )
    assert "Barber (2003)" in pressed.claims["thermal_conductance"].source
    alone = mdr.press_rough(surface, body, normal_force="1 N", realisations=5)
    with pytest.raises(mdr.NotValidError, match="Rigid, has no resistivity"):
        alone["electrical_resistance"]
    plain = mdr.press_rough(surface, mdr.Elastic("120 GPa", 0.34), normal_force="1 N", realisations=5)
    assert "thermal_conductance" not in plain.claims


def test_jkr_conducts_by_its_radius():
    gel, work, radius = GEL, 10e-3, 1e-3
    ball = mdr.Contact(mdr.Paraboloid(radius), gel, SINK, adhesion=mdr.JKR(work))
    result = mdr.solve(ball, mdr.load("0 N") >> mdr.load("-40 uN"))
    modulus = mdr.effective_moduli(gel).normal
    # F = 0: a^3 = 9 pi R^2 gamma / (2 E*)
    a = (9.0 * math.pi * radius**2 * work / (2.0 * modulus)) ** (1.0 / 3.0)
    line = 2.0 / (1.0 / 0.6 + 1.0 / 200.0)
    assert result["thermal_conductance"].values[0] == pytest.approx(2.0 * a * line, rel=1e-9)
    assert result.claims["thermal_conductance"].level is mdr.Level.EXACT
    stiff = line / modulus * result["normal_stiffness"].values
    assert not np.allclose(stiff, result["thermal_conductance"].values, rtol=0.1)
    gone = mdr.solve(ball, mdr.indent("5 um") >> mdr.indent("-30 um"))
    assert gone["thermal_conductance"].values[-1] == 0.0
    assert gone.claims["electrical_resistance"].level is mdr.Level.NOT_VALID


def test_a_cohesive_ring_bounds_the_conductance():
    contact = mdr.Contact(
        mdr.Paraboloid("1 mm"), GEL, SINK, adhesion=mdr.MaugisDugdale("10 mJ/m^2", range="5 um")
    )
    result = mdr.solve(contact, mdr.indent("5 um", steps=3))
    claim = result.claims["thermal_conductance"]
    a, c = result["contact_radius"].values, result["cohesive_radius"].values
    assert claim.level is mdr.Level.APPROXIMATE
    assert claim.error == pytest.approx(np.minimum(c / a - 1.0, 1.0), rel=1e-9)
    assert np.all(claim.error > 0.1)
    dmt = mdr.solve(replace(contact, adhesion=mdr.DMT("10 mJ/m^2")), mdr.indent("5 um"))
    assert "without contact" in dmt.claims["thermal_conductance"].reason
    assert dmt.claims["thermal_conductance"].level is mdr.Level.APPROXIMATE


@pytest.mark.parametrize("adhesion", [None, mdr.JKR("10 mJ/m^2")])
def test_bodies_that_never_touch_are_drawn(adhesion):
    contact = mdr.Contact(
        mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5, **COPPER), SINK, adhesion=adhesion
    )
    result = mdr.solve(contact, mdr.indent("-1 um", steps=3))
    assert result["thermal_conductance"].values.tolist() == [0.0] * 3
    assert result["electrical_resistance"].values.tolist() == [math.inf] * 3
    assert "inf ohm" in result.summary()
    assert result.figures()["conductance"].axes


def test_rows_that_are_no_disk_have_no_flux():
    hollow = mdr.FlatPunch("1 mm") + mdr.Function(lambda r: -(r**2), derivative=lambda r: -2 * r)
    contact = mdr.Contact(hollow, mdr.Elastic("3 MPa", 0.5, thermal_conductivity=1.0), SINK)
    result = mdr.solve(contact, mdr.indent("4 um", steps=2) >> mdr.indent("0.5 um"))
    flux = result.field("heat_flux", step=None)
    known = np.array([True, True, False])
    assert (~np.isnan(flux.values)).all(axis=1).tolist() == known.tolist()
    assert (~np.isnan(flux.edge_amplitude.values)).tolist() == known.tolist()
    assert np.isfinite(flux.r.values).all()
    assert (~np.isnan(result["thermal_conductance"].values)).tolist() == known.tolist()


def test_friction_and_memory_conduct_by_their_radius():
    ball = mdr.Paraboloid("10 mm")
    rows = (
        (mdr.Contact(ball, mdr.Elastic(1e9, 0.3, **COPPER), SINK, friction=mdr.Coulomb(0.3)), 390.0),
        (mdr.Contact(ball, RUBBER, SINK), 0.2),
        (mdr.Contact(ball, RUBBER, SINK, friction=mdr.Coulomb(0.3)), 0.2),
    )
    for contact, conductivity in rows:
        path = mdr.load("1 N", steps=2, duration="1 s") >> mdr.hold("1 s", steps=2)
        if contact.friction is not None:
            path >>= mdr.shift("10 nm", duration="1 s")
        result = mdr.solve(contact, path)
        exact = 2.0 * result["contact_radius"].values * 2.0 / (1.0 / conductivity + 1.0 / 200.0)
        assert result["thermal_conductance"].values == pytest.approx(exact, rel=1e-13)
        assert (
            result.claims["thermal_conductance"].where.tolist()
            == result.claims["contact_radius"].where.tolist()
        )


@pytest.mark.parametrize(
    ("body", "counterbody", "words"),
    [
        (GEL, mdr.Rigid(), r"counterbody, Rigid, has no thermal_conductivity"),
        (mdr.Elastic(1e9, 0.3), SINK, r"body, Elastic, has no thermal_conductivity"),
        (
            mdr.Graded(1e9, 1e-3, 0.2, 0.3, thermal_conductivity=1.0),
            SINK,
            "conductivity over its depth is unknown",
        ),
    ],
)
def test_what_is_not_known_is_not_given(body, counterbody, words):
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), body, counterbody), mdr.indent("1 um"))
    assert result.claims["thermal_conductance"].level is mdr.Level.NOT_VALID
    for read in (lambda: result["thermal_conductance"], lambda: result.field("heat_flux")):
        with pytest.raises(mdr.NotValidError, match=words):
            read()
    assert "thermal_conductance" not in result.data
    assert "conductance" not in result.figures()


def test_bodies_that_say_nothing_leave_the_result_as_it_was():
    result = mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)), mdr.indent("1 um"))
    assert "thermal_conductance" not in result.claims
    for read in (lambda: result["electrical_resistance"], lambda: result.field("current_density")):
        with pytest.raises(mdr.QuantityError, match=r"give both resistivity"):
            read()


def test_a_homogeneous_graded_body_conducts():
    bodies = (mdr.Graded(1e9, 1e-3, 0.0, 0.3, thermal_conductivity=1.0), SINK)
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), *bodies), mdr.indent("1 um"))
    assert result.claims["thermal_conductance"].level is mdr.Level.EXACT


def test_bodies_carry_what_they_conduct_everywhere(tmp_path):
    body = mdr.Elastic(
        "120 GPa",
        0.34,
        thermal_conductivity="3.9 W/(cm K)",
        resistivity="1.7 uohm cm",
        thermal_diffusivity="110 mm^2/s",
    )
    assert body == mdr.Elastic(
        120e9, 0.34, thermal_conductivity=390.0, resistivity=1.7e-8, thermal_diffusivity=1.1e-4
    )
    assert body != mdr.Elastic(120e9, 0.34)
    assert hash(body) != hash(mdr.Elastic(120e9, 0.34))
    assert repr(mdr.Elastic(120e9, 0.34)) == "Elastic(young=120000000000.0, poisson=0.34)"
    assert eval(repr(body), {"Elastic": mdr.Elastic}) == body
    assert pickle.loads(pickle.dumps(body)) == body
    assert "thermal_diffusivity" in body._repr_html_()
    contact = mdr.Contact(mdr.Sphere("1 mm"), body, SINK)
    title, back, _ = decode_case({**encode(contact), "path": [encode(mdr.indent("1 um"))]})
    assert back == contact
    assert title == ""
    result = mdr.solve(contact, mdr.load("1 N", steps=3))
    result.save(tmp_path / "switch.nc")
    again = mdr.open_result(tmp_path / "switch.nc")
    assert again.contact == contact
    assert again.data.identical(result.data)
    assert again.field("current_density").identical(result.field("current_density"))
    assert result.to("electrical_resistance", "mohm").values == pytest.approx(
        1e3 * result["electrical_resistance"].values
    )
    assert "Holm (1967)" in " ".join(again.cite())
    figure = again.figures()["conductance"]
    assert len(figure.axes) == 4
    assert "thermal conductance" in result.summary()


@pytest.mark.parametrize("name", ["thermal_conductivity", "resistivity", "thermal_diffusivity"])
@pytest.mark.parametrize("value", [-1.0, 0.0, "5 mm", math.nan, 1e70, "five"])
def test_bad_properties_are_refused(name, value):
    for kind in (mdr.Rigid, lambda **given: mdr.Elastic(1e9, 0.3, **given)):
        with pytest.raises(mdr.PymdrError, match=rf"^{name}( =|:) "):
            kind(**{name: value})


def test_bands_of_a_scatter_propagate_to_the_conductance():
    r = np.linspace(0.0, 1e-4, 41)
    tip = mdr.Sampled(r, r**2 / 2e-3, scatter=0.01 * r**2 / 2e-3 + 1e-10)
    contact = mdr.Contact(tip, mdr.Elastic(1e9, 0.3, **COPPER), SINK)
    result = mdr.solve(contact, mdr.indent("0.5 um", steps=2))
    low, high = result.bands["thermal_conductance"]
    assert np.all(low < result["thermal_conductance"].values)
    assert np.all(result["thermal_conductance"].values < high)


# Joule heat


def bar(areas, conductivity, t0, voltage=None, current=None):
    """Temperature of a bar of many cells whose rho lambda = L T, by finite volumes: largest T, voltage, current, cold R."""
    n = areas.size
    resistance = 1.0 / (conductivity * areas)  # thermal, of every cell of length 1
    cold = float(np.sum(LORENZ * t0 * resistance))

    def temperature(amperes):
        # d/dx (lambda A dT/dx) + I^2 L T / (lambda A) = 0 between nodes, heat of half a cell to either side
        between = 1.0 / resistance
        heat = 0.5 * amperes**2 * LORENZ * (resistance[:-1] + resistance[1:])
        bands = np.zeros((3, n - 1))
        bands[0, 1:] = -between[1:-1]
        bands[2, :-1] = -between[1:-1]
        bands[1] = between[:-1] + between[1:] - heat
        right = np.zeros(n - 1)
        right[0] += between[0] * t0
        right[-1] += between[-1] * t0
        inside = solve_banded((1, 1), bands, right)
        whole = np.concatenate([[t0], inside, [t0]])
        volts = amperes * float(np.sum(LORENZ * 0.5 * (whole[1:] + whole[:-1]) * resistance))
        return float(whole.max()), volts

    return (*temperature(current), cold)


@settings(max_examples=examples(15), deadline=None)
@given(
    st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=8),
    st.floats(1.0, 3.0),
    st.floats(0.02, 0.9),
    st.floats(-2.0, 2.0),
)
def test_joule_heat_of_bars_of_any_shape(logs, t0, fraction, other):
    """Any necks in a row; where both ends are of two metals, the law of the voltage holds, that of the current too."""
    n, t0 = 4000, 10.0**t0
    areas = np.exp(np.interp(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, len(logs)), logs))
    conductivity = np.where(np.arange(n) < n // 3, 1.0, 10.0**other)
    cold = float(np.sum(LORENZ * t0 / (conductivity * areas)))
    amperes = fraction * math.pi * t0 * math.sqrt(LORENZ) / cold
    hottest, volts, cold = bar(areas, conductivity, t0, current=amperes)
    heated = mdr.joule_heating(cold, current=amperes, temperature=t0)
    assert heated["largest_temperature"].item() == pytest.approx(hottest, rel=3e-4)
    assert heated["voltage"].item() == pytest.approx(volts, rel=3e-4)
    assert heated["hot_resistance"].item() == pytest.approx(volts / amperes, rel=3e-4)
    by_volts = mdr.joule_heating(cold, voltage=volts, temperature=t0)
    assert by_volts["largest_temperature"].item() == pytest.approx(hottest, rel=3e-4)
    assert by_volts["current"].item() == pytest.approx(amperes, rel=3e-4)


@settings(max_examples=examples(50), deadline=None)
@given(st.floats(-6.0, 4.0), st.floats(-3.0, 4.0), st.floats(-12.0, 6.0))
def test_voltage_and_current_are_inverse(volts, t0, ohms):
    volts, t0, ohms = 10.0**volts, 10.0**t0, 10.0**ohms
    rise = mdr.joule_heating(ohms, voltage=volts, temperature=t0)
    height = volts / (2.0 * math.sqrt(LORENZ))
    assert rise["temperature_rise"].item() == pytest.approx(
        height**2 / (math.hypot(height, t0) + t0), rel=1e-14
    )
    amperes = rise["current"].item()
    if height < 1e4 * t0:  # beyond, the current says next to nothing of the voltage
        back = mdr.joule_heating(ohms, current=amperes, temperature=t0)
        assert back["voltage"].item() == pytest.approx(volts, rel=1e-6)
        law = 2.0 * t0 * math.sqrt(LORENZ) * math.acos(t0 / back["largest_temperature"].item())
        if height > 1e-3 * t0:
            assert amperes * ohms == pytest.approx(law, rel=1e-6)


def switch(steps=4):
    copper = mdr.Elastic("120 GPa", 0.34, **COPPER)
    return mdr.solve(mdr.Contact(mdr.Sphere("5 mm"), copper, copper), mdr.load("1 N", steps=steps))


def test_the_current_through_a_result(tmp_path):
    result = switch()
    heated = mdr.joule_heating(result, current="100 A", temperature="20 degC")
    assert heated["cold_resistance"].values.tolist() == result["electrical_resistance"].values.tolist()
    assert heated["temperature"].values.tolist() == [293.15] * 4
    (law,) = heated.assumptions
    assert law.measure == pytest.approx(abs(390.0 * 17e-9 / (LORENZ * 293.15) - 1.0), rel=1e-12)
    assert law.met
    assert heated.claims["largest_temperature"].level is mdr.Level.APPROXIMATE
    assert "independent of temperature" in heated.claims["voltage"].reason
    rows = mdr.joule_heating(result["electrical_resistance"], voltage="50 mV", temperature=293.15)
    assert rows.claims["largest_temperature"].level is mdr.Level.EXACT
    assert "not checked" in rows.notes[0]
    assert len(rows["current"]) == 4
    heated.to_csv(tmp_path / "heated.csv", units={"voltage": "mV"})
    assert "voltage [mV]" in (tmp_path / "heated.csv").read_text()
    assert "hottest" in heated.summary()
    assert all(study.plot().axes for study in (heated, rows))
    assert mdr.joule_heating(voltage="0.1 V", temperature="20 degC").plot().axes
    with pytest.raises(mdr.QuantityError, match="Joule heating has"):
        mdr.joule_heating(voltage="0.1 V", temperature=300.0)["current"]
    graphite = mdr.Elastic("10 GPa", 0.2, thermal_conductivity=100.0, resistivity=1e-5)
    carbon = mdr.solve(mdr.Contact(mdr.Sphere("5 mm"), graphite, graphite), mdr.load("1 N"))
    assert not mdr.joule_heating(carbon, voltage="0.1 V", temperature=300.0).assumptions[0].met


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"resistance": 1e-3, "current": 200.0, "temperature": 293.15}, r"reduce the current below 143\.9 A"),
        ({"voltage": 0.1, "temperature": 0.0}, "above 0 K"),
        ({"voltage": 0.1, "temperature": "-280 degC"}, "above 0 K"),
        ({"voltage": "0.1 A", "temperature": 300.0}, "does not fit"),
        ({"voltage": -0.1, "temperature": 300.0}, "at least 0 V"),
        ({"temperature": 300.0}, "exactly one of voltage and current"),
        ({"voltage": 0.1, "current": 1.0, "temperature": 300.0}, "exactly one of voltage and current"),
        ({"current": 1.0, "temperature": 300.0}, "depends on the resistance"),
        ({"resistance": 0.0, "current": 1.0, "temperature": 300.0}, "above 0 ohm"),
        (
            {"resistance": [1.0, 2.0], "current": [0.01] * 3, "temperature": 300.0},
            "2 numbers, another argument 3",
        ),
        ({"voltage": math.nan, "temperature": 300.0}, "not finite"),
    ],
)
def test_bad_currents_are_refused(arguments, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.joule_heating(**arguments)


def test_an_open_contact_carries_nothing():
    copper = mdr.Elastic("120 GPa", 0.34, **COPPER)
    contact = mdr.Contact(mdr.Sphere("5 mm"), copper, copper)
    result = mdr.solve(contact, mdr.load("1 N") >> mdr.indent("-1 um"))
    assert result["electrical_resistance"].values[1] == math.inf
    with pytest.raises(mdr.ProblemError, match="are not in contact in row 1"):
        mdr.joule_heating(result, current=1.0, temperature=300.0)
    with pytest.raises(mdr.NotValidError, match="has no resistivity"):
        mdr.joule_heating(
            mdr.solve(replace(contact, counterbody=mdr.Rigid()), mdr.load(1.0)),
            current=1.0,
            temperature=300.0,
        )


# frictional heat


@settings(max_examples=6, deadline=None)
@given(shapes(), conductivities, conductivities, st.floats(0.05, 0.95))
def test_frictional_heat_is_the_potential_of_what_rubs(shape, one, other, fraction):
    """The rise at any radius by direct summation of mu v p over the contact."""
    profile, depth = shape
    contact = mdr.Contact(
        profile,
        mdr.Elastic(1e9, 0.5, thermal_conductivity=one, thermal_diffusivity=1.0),
        mdr.Rigid(thermal_conductivity=other),
        friction=mdr.Coulomb(0.3),
    )
    rubbed = mdr.frictional_heat(contact, 2e-9, indentation=depth)
    pressed = mdr.solve(replace(contact, friction=None), mdr.indent(depth))
    a = rubbed.data.attrs["contact_radius"]
    surface = rubbed.surface["temperature_rise"].isel(speed=0)
    row = int(fraction * 80)
    r, u = surface["r"].values, surface.values

    def heat(s):
        # the logarithm of a kink is infinite at the kink itself, where a node may fall by rounding
        nearby = np.where(np.isin(s, profile.breakpoints), s * (1.0 - 1e-15), s)
        return 0.3 * 2e-9 * pressed.field("pressure", nearby).values

    assert u[row] == pytest.approx(potential(heat, a, r[row], profile.breakpoints) / (one + other), rel=1e-7)
    mean = 0.0
    for low, high in pairwise((0.0, *(x for x in profile.breakpoints if x < a), a)):
        t, w = 0.5 + 0.5 * NODES, WEIGHTS * (high - low)
        s = low + (high - low) * t**2
        mean += np.sum(w * t * (depth - profile.gap(s)) * 2.0 * s) / (depth * a**2)
    ratio = rubbed["mean_temperature_rise"] / rubbed["largest_temperature_rise"]
    assert ratio.item() == pytest.approx(mean, rel=1e-7)
    assert rubbed["largest_temperature_rise"].item() == pytest.approx(u.max(), rel=1e-12)
    assert rubbed["heat"].item() == pytest.approx(0.3 * 2e-9 * pressed["normal_force"].item(), rel=1e-12)


@pytest.mark.parametrize(
    ("profile", "fraction"),
    [
        (mdr.FlatPunch(1e-3), 1.0),
        (mdr.Paraboloid(1e-2), 3.0 / 4.0),
        # d = (pi/2) tan a; mean of r over the disk 2a/3
        (mdr.Cone(slope=0.05), 1.0 - 4.0 / (3.0 * math.pi)),
        (mdr.PowerLaw(0.5, 1e-5, 1e-3), None),
        (mdr.PowerLaw(4.0, 1e-5, 1e-3), 1.0 - (1.0 / 3.0) / (8.0 / 3.0)),
    ],
)
def test_mean_rise_of_closed_profiles(profile, fraction):
    contact = mdr.Contact(profile, DISK, PIN, friction=mdr.Coulomb(0.2))
    rubbed = mdr.frictional_heat(contact, 1e-3, indentation=1e-6)
    if fraction is None:
        a = rubbed.data.attrs["contact_radius"]
        fraction = 1.0 - 2.0 / 2.5 * 1e-5 * math.sqrt(a / 1e-3) / 1e-6
    ratio = rubbed["mean_temperature_rise"] / rubbed["largest_temperature_rise"]
    assert ratio.item() == pytest.approx(fraction, rel=1e-12)


def test_moving_takes_heat_away_as_it_says():
    """A half-space that moves below a source has the kernel exp(-v (R + x)/(2 kappa))/R: around the centre it is known."""
    contact = mdr.Contact(
        mdr.Paraboloid("10 mm"), DISK, mdr.Rigid(thermal_conductivity=1e-20), friction=mdr.Coulomb(0.3)
    )
    for peclet, tolerance in ((1e-4, 1e-3), (0.05, 0.05)):
        slow = mdr.frictional_heat(contact, 1.0, normal_force="1 N")
        speed = peclet / slow["peclet_number"].item()
        rubbed = mdr.frictional_heat(contact, speed, normal_force="1 N")
        a, d = (rubbed.data.attrs[name] for name in ("contact_radius", "indentation"))
        assert rubbed["peclet_number"].item() == pytest.approx(speed * a / (2.0 * 12e-6), rel=1e-12)
        modulus = mdr.effective_moduli(DISK).normal
        largest = 2.0 * modulus * d / (math.pi * a)

        def lacks(s, a=a, largest=largest, speed=speed):
            heat = 0.3 * speed * largest * math.sqrt(1.0 - (s / a) ** 2)
            return heat * (1.0 - i0e(speed * s / (2.0 * 12e-6))) / 45.0

        fraction = quad(lacks, 0.0, a, epsabs=0.0)[0] / rubbed["largest_temperature_rise"].item()
        quoted = re.search(
            r"removes the fraction ([0-9.e+-]+) of", rubbed.claims["largest_temperature_rise"].reason
        )
        assert float(quoted[1]) == pytest.approx(fraction, rel=max(tolerance, 0.02))
    (slow,) = (one for one in rubbed.assumptions if one.name == "slow sliding")
    assert slow.met
    fast = mdr.frictional_heat(contact, [1e-3, 10.0], normal_force="1 N")
    assert not next(one for one in fast.assumptions if one.name == "slow sliding").met


def test_frictional_heat_of_a_rough_callable_says_what_its_numbers_err_by():
    """A callable whose offset hides its digits, against the closed form that it rounds."""
    rounded = mdr.Function(lambda r: 10.0 + r**2 / 0.02)
    contact = mdr.Contact(rounded, DISK, PIN, friction=mdr.Coulomb(0.3))
    exact = replace(contact, profile=mdr.Paraboloid(0.01))
    results, true = (mdr.frictional_heat(one, 1e-3, normal_force=1.0) for one in (contact, exact))
    for name in ("largest_temperature_rise", "mean_temperature_rise", "heat"):
        claim = results.claims[name]
        claimed = 0.0 if claim.error is None else claim.error[0]
        assert abs(results[name].item() / true[name].item() - 1.0) <= max(claimed, 1e-9)
    assert results.claims["mean_temperature_rise"].error[0] > 0.0


def test_frictional_heat_of_a_curve_and_its_words(tmp_path):
    depth = np.linspace(0.0, 1e-6, 41)
    curve = mdr.ForceCurve(depth, 4 / 3 * 1e9 * 0.1 * depth**1.5, modulus=1e9)
    joint = mdr.Contact(curve, DISK, PIN, friction=mdr.Coulomb(0.3))
    rubbed = mdr.frictional_heat(joint, ["1 mm/s", "2 mm/s"], indentation="0.5 um")
    whole = mdr.frictional_heat(replace(joint, profile=mdr.Paraboloid(0.01)), 1e-3, indentation="0.5 um")
    assert rubbed["largest_temperature_rise"].values == pytest.approx(
        whole["largest_temperature_rise"].item() * np.array([1.0, 2.0]), rel=1e-12
    )
    with pytest.raises(mdr.NotValidError, match="area of a contact is not in its force curve"):
        rubbed["mean_temperature_rise"]
    assert "does not move relative to the contact" in whole.notes[-1]
    assert whole.claims["mean_temperature_rise"].level is mdr.Level.APPROXIMATE
    rubbed.to_csv(tmp_path / "rubbed.csv")
    assert (tmp_path / "rubbed.csv").read_text().startswith("speed [m/s],largest_temperature_rise [K]")
    assert all(study.plot().axes for study in (rubbed, whole))
    unlike = mdr.frictional_heat(
        mdr.Contact(mdr.Paraboloid(0.01), replace(DISK, poisson=0.3), PIN, friction=mdr.Coulomb(0.3)),
        1e-3,
        indentation="0.5 um",
    )
    assert unlike.claims["largest_temperature_rise"].level is mdr.Level.APPROXIMATE


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        ({"friction": None}, {}, "no friction"),
        ({"friction": mdr.Coulomb(0.0)}, {}, "has no heat"),
        ({"counterbody": mdr.Rigid()}, {}, "counterbody, Rigid, has no thermal_conductivity"),
        ({"body": mdr.Elastic(1e9, 0.5, thermal_conductivity=1.0)}, {}, "no body has a thermal_diffusivity"),
        ({}, {"speed": -1.0}, "above 0 m/s"),
        ({}, {"speed": "1 mm"}, "does not fit"),
        ({}, {"normal_force": "1 N"}, "exactly one"),
        ({}, {"indentation": "-1 um"}, "above 0"),
        ({"body": RUBBER}, {}, "depends on the history"),
    ],
)
def test_bad_sliding_is_refused(change, arguments, words):
    contact = mdr.Contact(mdr.Paraboloid(0.01), DISK, PIN, friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.frictional_heat(replace(contact, **change), **{"speed": 1e-3, "indentation": "1 um"} | arguments)


CASE = """
title = "A switch"
[profile]
kind = "sphere"
radius = "5 mm"
[body]
kind = "elastic"
young = "120 GPa"
poisson = 0.5
thermal_conductivity = "390 W/(m K)"
resistivity = "17 nohm m"
thermal_diffusivity = "110 mm^2/s"
[counterbody]
kind = "rigid"
thermal_conductivity = 390
resistivity = "17 nohm m"
[friction]
kind = "coulomb"
coefficient = 0.3
[[path]]
kind = "load"
normal_force = "1 N"
steps = 3
"""


def test_heat_from_the_shell(tmp_path, shell):
    case = tmp_path / "switch.toml"
    case.write_text(CASE)
    status, out, error = shell(
        "joule", case, "--current", "100 A", "--temperature", "20 degC", "-o", tmp_path / "out"
    )
    assert (status, error) == (0, "")
    assert "hottest" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["joule.csv", "joule.png"]
    status, out, _ = shell("joule", case, "--voltage", "0.1 V", "--temperature", "293.15 K", "--json")
    hottest = math.sqrt(293.15**2 + 0.01 / (4.0 * LORENZ))
    assert json.loads(out)["study"]["largest_temperature"]["values"] == pytest.approx([hottest] * 3)
    status, out, error = shell(
        "heat",
        case,
        "--speed",
        "1 mm/s",
        "--speed",
        "1 cm/s",
        "--normal-force",
        "1 N",
        "-o",
        tmp_path / "rub",
    )
    assert (status, error) == (0, "")
    assert "Peclet number" in out
    assert sorted(file.name for file in (tmp_path / "rub").iterdir()) == ["heat.csv", "heat.png"]
    status, _, error = shell("joule", case, "--current", "1 MA", "--temperature", "20 degC")
    assert (status, "reduce the current below" in error) == (1, True)
    case.write_text(CASE.replace("resistivity", "resistivty"))
    status, _, error = shell("check", case)
    assert (status, "did you mean 'resistivity'" in error) == (1, True)
    case.write_text(CASE.replace('"390 W/(m K)"', "-3"))
    status, _, error = shell("check", case)
    assert (status, "thermal_conductivity = -3: it must be above 0" in error) == (1, True)
