"""Layers: against published and independent values, other solutions of the same waves, and identities."""

from __future__ import annotations

import math
from functools import cache

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipk, j0

import pymdr as mdr
from common import REFERENCES
from drawing import examples
from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.layered import LayeredLine, equation
from pymdr.line.layered.equation import Outline, numbers, solve_contact
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import Compliance, Kernel, kernel_of
from pymdr.numerics.panels import Place, as_place
from pymdr.problem.codec import case_schema, decode_case, encode_case

REFERENCES = [entry for entry in REFERENCES if entry["topic"] == "12 layer"]


def film(poisson=0.5, *, young=1.0, thickness=1.0, **others):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, poisson), thickness)], **others)


def line_of(profile, body):
    return LayeredLine(equivalent_profile(profile), kernel_of(body))


def solved(profile, body, a):
    outline = Outline(equivalent_profile(profile), body.layers[0].thickness, as_place(np.array([float(a)])))
    result, error, _ = solve_contact(kernel_of(body), outline)
    return numbers(result, outline), error


# -- references ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("entry", REFERENCES, ids=lambda entry: entry["id"])
def test_reference_values(entry):
    poisson = entry["inputs"].get("nu", 0.5 if "0.5" in entry["id"] else 0.3)
    body = film(poisson, bond="frictionless" if "frictionless" in entry["id"] else "bonded")
    for i, a in enumerate(entry["inputs"]["a_over_h"]):
        computed, error = solved(mdr.Paraboloid(1.0), body, a)
        assert error.max() < 1e-9
        expected = entry["expected"]
        if "kappa" in expected:
            assert computed[0] == pytest.approx(expected["kappa"][i], rel=1e-9)
        else:
            assert computed[2] == pytest.approx(expected["dR_over_a2"][i], rel=1e-9)
            assert computed[3] == pytest.approx(expected["F_over_FHertz_a"][i], rel=1e-9)


def test_the_table_of_1972_is_reproduced_with_its_error():
    entry = next(entry for entry in REFERENCES if entry["id"] == "hayes_flat_nu0.5")
    published = dict(zip(entry["inputs"]["a_over_h"], entry["expected"]["hayes_table"], strict=True))
    low = {a: published[a] / solved(mdr.Paraboloid(1.0), film(), a)[0][0] - 1.0 for a in (1.0, 2.0, 4, 8)}
    assert [round(100 * error, 1) for error in low.values()] == [-0.3, -0.9, -2.5, -5.9]


# -- waves --------------------------------------------------------------------------------------------


def by_stress_functions(body, s):
    """L(s) from Airy's functions (A + B z) e^-kz + (C + D z) e^kz of all layers, as one linear system."""
    mp.mp.dps = 50 + int(2 * s * body.thickness / body.layers[0].thickness)
    h0 = mp.mpf(body.layers[0].thickness)
    k = mp.mpf(s) / h0

    def states(solid, z):
        """u_z, u_x, s_zz, s_xz (times parities) of the four functions; plane strain."""
        nu, shear = mp.mpf(solid.poisson), mp.mpf(solid.young) / (2 * (1 + mp.mpf(solid.poisson)))
        columns = []
        for sign, linear in ((-1, 0), (-1, 1), (1, 0), (1, 1)):
            e = mp.exp(sign * k * z)
            q = sign * k
            f = e * (z if linear else 1)
            d1 = e * ((1 + q * z) if linear else q)
            d2 = e * ((2 * q + q * q * z) if linear else q * q)
            d3 = e * ((3 * q * q + q**3 * z) if linear else q**3)
            zz, xz, xx = -k * k * f, k * d1, d2
            # 2G du_x/dx = (1 - nu) s_xx - nu s_zz, and 2G (du_x/dz + du_z/dx) = 2 s_xz
            ux = ((1 - nu) * xx - nu * zz) / (2 * shear * k)
            dux = ((1 - nu) * d3 + nu * k * k * d1) / (2 * shear * k)
            uz = -(xz / shear - dux) / k
            columns.append((uz, ux, zz, xz))
        return columns

    layers = body.layers
    count = 4 * len(layers)
    half_space = isinstance(body.base, mdr.Elastic)
    size = count + (2 if half_space else 0)
    matrix, right = mp.zeros(size, size), mp.zeros(size, 1)
    row, z = 0, mp.mpf(0)
    for column, state in enumerate(states(layers[0].material, mp.mpf(0))):
        matrix[0, column], matrix[1, column] = state[2], state[3]
    right[0] = -1
    row = 2
    for i, layer in enumerate(layers):
        z += mp.mpf(layer.thickness)
        above = states(layer.material, z)
        if i + 1 < len(layers):
            below = states(layers[i + 1].material, z)
            for part in range(4):
                for j in range(4):
                    matrix[row, 4 * i + j], matrix[row, 4 * i + 4 + j] = above[j][part], -below[j][part]
                row += 1
            continue
        under = states(body.base, z)[:2] if half_space else []
        rows = (0, 1, 2, 3) if body.bond == "bonded" else (0, 2)
        for part in rows if half_space else rows[: len(rows) // 2]:
            for j in range(4):
                matrix[row, 4 * i + j] = above[j][part]
            for j, state in enumerate(under):
                matrix[row, count + j] = -state[part]
            row += 1
        if body.bond == "frictionless":
            for j in range(4):
                matrix[row, 4 * i + j] = above[j][3]
            row += 1
            if half_space:
                for j, state in enumerate(under):
                    matrix[row, count + j] = state[3]
                row += 1
    result = mp.lu_solve(matrix, right)
    surface = sum(result[j] * state[0] for j, state in enumerate(states(layers[0].material, mp.mpf(0))))
    top = layers[0].material
    modulus = mp.mpf(top.young) / (1 - mp.mpf(top.poisson) ** 2)
    return surface * modulus * k / 2


ratio = st.floats(-4.0, 4.0).map(lambda x: 10.0**x)
poisson = st.one_of(st.just(0.5), st.floats(-0.9, 0.5))
solid = st.tuples(st.floats(-2.0, 2.0).map(lambda x: 10.0**x), poisson)


@st.composite
def bodies(draw):
    layers = [
        mdr.Layer(mdr.Elastic(young, nu), draw(st.floats(0.2, 5.0)))
        for young, nu in draw(st.lists(solid, min_size=1, max_size=3))
    ]
    base = draw(st.one_of(st.just(mdr.Rigid()), solid.map(lambda one: mdr.Elastic(*one))))
    return mdr.Layered(layers, base=base, bond=draw(st.sampled_from(["bonded", "frictionless"])))


@settings(max_examples=examples(25), deadline=None)
@given(bodies(), st.floats(-4.0, 1.2).map(lambda x: 10.0**x))
def test_the_compliance_is_that_of_stress_functions(body, s):
    expected = by_stress_functions(body, s)
    compliance = Compliance(body)
    assert float(compliance.ratio(s).real) == pytest.approx(float(expected), rel=1e-12)
    left = float(1 - expected)
    assert float(compliance.shortfall(s).real) == pytest.approx(
        left, rel=1e-11, abs=1e-13 * math.exp(-2.0 * s)
    )


@pytest.mark.parametrize("nu", [0.5, 0.499, 0.3, 0.0, -0.5])
def test_the_compliance_keeps_its_digits_at_both_ends(nu):
    mp.mp.dps = 60
    kappa = 3 - 4 * mp.mpf(nu)
    for s in (1e-8, 1e-4, 1e-2, 0.99, 1.01, 5.0, 20.0):
        z = mp.mpf(s)
        over = 2 * kappa * mp.cosh(2 * z) + 1 + kappa**2 + 4 * z**2
        exact = (2 * kappa * mp.sinh(2 * z) - 4 * z) / over
        assert float(Compliance(film(nu)).ratio(s).real) == pytest.approx(float(exact), rel=2e-15)
        assert float(Compliance(film(nu)).shortfall(s).real) == pytest.approx(float(1 - exact), rel=2e-15)


def test_waves_through_a_sliding_layer():
    s = np.array([1e-6, 0.1, 1.0, 5.0, 20.0])
    through = Compliance(film(0.3, bond="frictionless")).pressed_through(s)
    exact = 2.0 * (np.sinh(s) + s * np.cosh(s)) / (np.sinh(2.0 * s) + 2.0 * s)
    assert through == pytest.approx(exact, rel=1e-12)
    with pytest.raises(ProblemError, match="bonded"):
        Compliance(film(0.3)).pressed_through(s)


@pytest.mark.parametrize("t", [0.0, 0.7, 1.99, 2.01, 9.0])
def test_the_kernel_keeps_its_digits(t):
    mp.mp.dps = 25

    def shortfall(s):
        e = mp.exp(-2 * s)
        return 2 * e * (e + 1 + 2 * s * s + 2 * s) / (1 + e * e + (2 + 4 * s * s) * e)

    marks = [mp.mpf(x) for x in np.linspace(0.0, 28.0, 15)]
    exact = mp.quad(lambda s: shortfall(s) * mp.cos(s * t), marks)
    kernel = Kernel(Compliance(film()))
    assert float(kernel(np.array([t]))[0]) == pytest.approx(float(exact), rel=1e-12)


def test_the_tail_of_the_kernel_is_its_series():
    # L = (2/3) s^3 + ... of an incompressible layer: M = -int L cos(st) ds -> -(2/3) 3! / t^4
    t = np.array([2e3, 2e4])
    assert Kernel(Compliance(film()))(t) * t**4 == pytest.approx(-4.0, rel=1e-5)
    # and L = s (1 - 2 nu) (1 + nu) ... of a compressible one: M -> L'(0) / t^2
    soft = Compliance(film(0.3))
    first = float(soft.ratio(1e-9).real) / 1e-9
    assert Kernel(soft)(t) * t**2 == pytest.approx(first, rel=1e-5)


# -- limits -------------------------------------------------------------------------------------------


def test_alike_layers_are_one():
    one = film(0.4, thickness=4.0)
    many = mdr.Layered([mdr.Layer(mdr.Elastic(1.0, 0.4), h) for h in (1.0, 0.5, 2.5)])
    for a in (0.1, 1.0, 20.0):
        assert solved(mdr.Cone(slope=1.0), many, a)[0] == pytest.approx(
            solved(mdr.Cone(slope=1.0), one, a)[0], rel=1e-10
        )


def test_a_base_like_the_layer_is_a_half_space():
    body = film(0.3, base=mdr.Elastic(1.0, 0.3))
    for a in (1e-3, 1.0, 50.0):
        assert solved(mdr.Paraboloid(1.0), body, a)[0] == pytest.approx(np.ones(5), abs=1e-10)
    layered = mdr.solve(mdr.Contact(mdr.Sphere(3.0), body), mdr.load(0.1, steps=3))
    plain = mdr.solve(mdr.Contact(mdr.Sphere(3.0), mdr.Elastic(1.0, 0.3)), mdr.load(0.1, steps=3))
    for name in ("indentation", "contact_radius", "elastic_energy", "normal_stiffness"):
        assert layered[name].values == pytest.approx(plain[name].values, rel=1e-10)


def test_thin_layers():
    # a compressible one is Winkler's foundation, h (1 - 2 nu) / (2 G (1 - nu)) per pressure
    nu, a = 0.3, 200.0
    shear = 1.0 / (2.0 * (1.0 + nu))
    foundation = 2.0 * shear * (1.0 - nu) / (1.0 - 2.0 * nu)
    stiffness = solved(mdr.Paraboloid(1.0), film(nu), a)[0][0] * 2.0 * a / (1.0 - nu**2)
    assert stiffness == pytest.approx(math.pi * a**2 * foundation, rel=0.01)
    # an incompressible one resists by its flow
    thin = solved(mdr.Paraboloid(1.0), film(), 100.0)[0]
    assert thin[0] == pytest.approx(3.0 * math.pi / 64.0 * 101.459**4 / 100.0, rel=1e-5)
    # and a paraboloid sinks in by a^2 / 4R
    assert solved(mdr.Paraboloid(1.0), film(), 100.0)[0][2] == pytest.approx(0.25, rel=0.03)


@given(bodies())
@settings(max_examples=examples(15), deadline=None)
def test_small_contacts(body):
    kernel = kernel_of(body)
    a = 1e-3 / max(1.0, abs(kernel.at_zero))
    computed = solved(mdr.Paraboloid(1.0), body, a * body.layers[0].thickness)[0]
    assert 1.0 / computed[0] == pytest.approx(1.0 - 2.0 / math.pi * kernel.at_zero * a, abs=1e-7)
    assert computed[3] == pytest.approx(1.0, abs=1e-6)


def test_contacts_too_wide_or_not_resolved_are_refused(monkeypatch):
    with pytest.raises(ConvergenceError, match="300"):
        solved(mdr.Paraboloid(1.0), film(), 301.0)
    monkeypatch.setattr(equation, "ORDERS", (2, 3))
    for a in (2.0, 10.0, 100.0):
        with pytest.raises(ConvergenceError, match="not resolved"):
            solved(mdr.Paraboloid(1.0), film(), a)


# -- curves -------------------------------------------------------------------------------------------


PROFILES = [
    mdr.Paraboloid(1.0),
    mdr.Cone(slope=1.0),
    mdr.PowerLaw(0.4, 1.0, 1.0),
    mdr.PowerLaw(7, 1.0, 1.0),
    mdr.TruncatedCone(0.3, slope=1.0),
    mdr.TruncatedSphere(100.0, 0.4),
    mdr.RoundedCone(0.2, slope=0.5),
    mdr.Sphere(40.0),
]


@cache
def slopes_of_curves(line, start, stop):
    """The largest misfit of dF0 = k dd0, dU0 = F0 dd0 and dk = k' da, by Gauss on short steps."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    ends = np.geomspace(start, stop, 12)
    half = 0.5 * np.diff(ends)
    a = ends[:-1, None] + half[:, None] * (1.0 + nodes)

    def across(rate):
        return (half[:, None] * weights * rate).sum(axis=1)

    depth_rate = line.depth_rate(a)
    return {
        "force": across(line.stiffness(a) * depth_rate) / np.diff(line.force(ends)),
        "energy": across(line.force(a) * depth_rate) / np.diff(line.energy(ends)),
        "stiffness": across(line.stiffness_rate(a)) / np.diff(line.stiffness(ends)),
        "depth": across(depth_rate) / np.diff(line.depth(ends)),
        "edge": across(line.punch(a).power * line.stiffness_rate(a) / a) / np.diff(line.stiffness_rate(ends)),
    }


@settings(max_examples=examples(12), deadline=None)
@given(bodies(), st.sampled_from(PROFILES), st.floats(-1.0, 0.5))
def test_force_energy_and_stiffness_belong_together(body, profile, log_radius):
    line = line_of(profile, body)
    start = 10.0**log_radius
    if line.breakpoints and start < 1.5 * line.breakpoints[-1]:
        start = 1.5 * line.breakpoints[-1]
    for name, fraction in slopes_of_curves(line, start, 2.0 * start).items():
        assert fraction == pytest.approx(1.0, abs=1e-8), name


@settings(max_examples=examples(10), deadline=None)
@given(bodies(), st.sampled_from(PROFILES), st.lists(st.floats(-3.0, 0.6), min_size=3, max_size=6))
def test_tables_err_as_they_say(body, profile, log_radii):
    line = line_of(profile, body)
    for log in log_radii:
        a = 10.0**log
        exact, error = solved(profile, body, a)
        place = as_place(np.array([a]))
        computed = line.table.read(place, (0, 1, 2, 3, 4))[0]
        bound = line.table.error(place)[0] + error + 1e-13
        assert np.all(np.abs(computed / exact - 1.0) <= bound)
        assert np.max(bound) < 1e-8


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: type(profile).__name__)
def test_radii_are_recovered(profile):
    line = line_of(profile, film(0.45))
    b = max(line.breakpoints, default=0.0)
    a = np.sort(
        np.concatenate([b * (1.0 + np.geomspace(1e-9, 1.0, 9)) if b else [1e-7], np.geomspace(0.5, 4.0, 9)])
    )
    assert line.place(line.depth(a)).x == pytest.approx(a, rel=1e-9)
    assert line.place_of_force(line.force(a)).x == pytest.approx(a, rel=1e-9)
    assert line.place(0.0).x == 0.0


@settings(max_examples=5, deadline=None)
@given(st.floats(-9.0, 3.0).map(lambda x: 10.0**x), st.floats(-3.0, 6.0).map(lambda x: 10.0**x), poisson)
def test_scales_do_not_matter(length, modulus, nu):
    def forces(size, young):
        body = film(nu, young=young, thickness=size, base=mdr.Elastic(3.0 * young, 0.2))
        result = mdr.solve(mdr.Contact(mdr.Paraboloid(2.0 * size), body), mdr.indent(0.3 * size, steps=3))
        return result["normal_force"].values / (young * size**2), result["contact_radius"].values / size

    for here, unit in zip(forces(length, modulus), forces(1.0, 1.0), strict=True):
        assert here == pytest.approx(unit, rel=1e-10)


def test_layers_against_halfspaces_on_both_sides():
    soft, stiff = mdr.Elastic("1 MPa", 0.4), mdr.Elastic("100 MPa", 0.3)
    path = mdr.load("0.5 N", steps=20)
    ball = mdr.Sphere("5 mm")
    gel = mdr.solve(mdr.Contact(ball, mdr.Layered([mdr.Layer(soft, "1 mm")], base=stiff)), path)
    tool = mdr.solve(mdr.Contact(ball, mdr.Layered([mdr.Layer(stiff, "0.05 mm")], base=soft)), path)
    low, high = (mdr.solve(mdr.Contact(ball, one), path)["indentation"].values for one in (stiff, soft))
    for result in (gel, tool):
        assert np.all((result["indentation"].values > low) & (result["indentation"].values < high))


# -- paths --------------------------------------------------------------------------------------------


def test_controls_agree():
    contact = mdr.Contact(mdr.Sphere("5 mm"), film(0.49, young="1 MPa", thickness="1 mm"))
    pressed = mdr.solve(contact, mdr.load("2 N", steps=7))
    depth, force = pressed["indentation"].values, pressed["normal_force"].values
    back = mdr.solve(contact, mdr.Path(indentation=depth))
    assert back["normal_force"].values == pytest.approx(force, rel=1e-12)
    travelled = mdr.solve(contact, mdr.Path(travel=depth + force / 3e4), machine_stiffness="30 kN/m")
    assert travelled["normal_force"].values == pytest.approx(force, rel=1e-10)
    assert pressed.claims["indentation"].level is mdr.Level.EXACT
    assert "layer bonded to a rigid base" in pressed.claims["indentation"].reason
    assert any("Lebedev" in source for source in pressed.cite())


def test_a_sharp_punch_sticks_at_its_edge():
    result = mdr.solve(mdr.Contact(mdr.FlatPunch(1.5), film(0.5)), mdr.indent(0.1))
    kappa = solved(mdr.Paraboloid(1.0), film(0.5), 1.5)[0]
    assert float(result["normal_force"][0]) == pytest.approx(2.0 / 0.75 * 1.5 * kappa[0] * 0.1, rel=1e-11)
    assert float(result["elastic_energy"][0]) == pytest.approx(
        0.05 * float(result["normal_force"][0]), rel=1e-11
    )
    r = 1.5 - np.array([1e-6, 1e-8])
    amplitude = float(result["edge_amplitude"][0])
    assert result.field("pressure", r=r).values * np.sqrt(1.5 - r) == pytest.approx(amplitude, rel=1e-3)


def test_adhesion_is_the_rule_of_the_edge():
    nu, work = 0.45, 0.05
    body = film(nu, young=1.0 - nu**2)
    contact = mdr.Contact(mdr.Paraboloid(1.0), body, adhesion=mdr.JKR(work))
    result = mdr.solve(contact, mdr.indent(0.3, steps=9) >> mdr.indent(-0.3, steps=30))
    assert result.status is mdr.Status.PULLED_OFF
    kernel = kernel_of(body)
    for step in (0, 5, 14):
        a = float(result["contact_radius"][step])
        outline = Outline(equivalent_profile(mdr.Paraboloid(1.0)), 1.0, as_place(np.array([a])))
        computed, _, _ = solve_contact(kernel, outline)
        # q(a) = -sqrt(2 pi work E* a)
        excess = -math.sqrt(2.0 * math.pi * work * a) / computed.punch_edge
        assert float(result["indentation"][step]) == pytest.approx(a * a - computed.lift + excess, rel=1e-9)
        force = 2.0 * (2.0 / 3.0 * a**3 + computed.force + excess * computed.stiffness)
        assert float(result["normal_force"][step]) == pytest.approx(force, rel=1e-8, abs=1e-12)
        assert float(result["energy_release_rate"][step]) == pytest.approx(work, rel=1e-10)
    balance = next(one for one in result.assumptions if one.name == "energy balance")
    assert balance.measure < 1e-10


def test_pull_off_is_the_lowest_force():
    body = film(0.3, base=mdr.Elastic(20.0, 0.3))
    contact = mdr.Contact(mdr.Paraboloid(1.0), body, adhesion=mdr.JKR(0.02))
    pull_off = mdr.pull_off(contact, machine_stiffness=0.0)
    line = line_of(mdr.Paraboloid(1.0), body)
    a = np.linspace(0.8, 1.2, 4001) * pull_off.contact_radius
    force = line.force(a) - line.stiffness(a) * np.sqrt(4.0 * math.pi * 0.02 * a / line.stiffness_rate(a))
    assert pull_off.normal_force == pytest.approx(force.min(), rel=1e-7)


SAMPLES = np.linspace(0.0, 3.0, 40)


@pytest.mark.parametrize(
    "profile",
    [
        mdr.Sampled(SAMPLES, SAMPLES**2 / 20.0),
        mdr.Function(lambda r: r**2 / 20.0),
        mdr.Paraboloid(10.0) + mdr.PowerLaw(4, 1e-12, 1.0),
    ],
    ids=lambda profile: type(profile).__name__,
)
def test_one_shape_given_in_several_forms(profile):
    body = film(0.45, base=mdr.Elastic(10.0, 0.3))
    path = mdr.load(0.02, steps=3)
    given, plain = (mdr.solve(mdr.Contact(one, body), path) for one in (profile, mdr.Paraboloid(10.0)))
    for name in ("indentation", "contact_radius", "elastic_energy"):
        assert given[name].values == pytest.approx(plain[name].values, rel=1e-9)


def test_loads_beyond_the_samples_are_refused():
    contact = mdr.Contact(mdr.Sampled(SAMPLES, SAMPLES**2 / 20.0), film(0.45))
    for path in (mdr.load(1e3), mdr.indent(2.0)):
        with pytest.raises(mdr.PathError, match="would pass r = 3 m"):
            mdr.solve(contact, path)


def test_a_sticky_punch_peels_from_a_thin_layer():
    # the edge of a wide contact opens step by step: a / k' is least where it lets go
    contact = mdr.Contact(mdr.FlatPunch(2.0), mdr.Rigid(), film(), adhesion=mdr.JKR(0.05))
    pull_off = mdr.pull_off(contact)
    line = line_of(mdr.Paraboloid(1.0), film())
    a = np.linspace(0.2, 2.0, 20001)
    opening = np.sqrt(4.0 * math.pi * 0.05 * a / line.stiffness_rate(a))
    assert pull_off.contact_radius == pytest.approx(a[np.argmax(opening)], abs=1e-3)
    assert pull_off.indentation == pytest.approx(-opening.max(), rel=1e-7)
    result = mdr.solve(contact, mdr.indent(0.1) >> mdr.indent(-1.1 * opening.max(), steps=40))
    assert result.status is mdr.Status.PULLED_OFF
    assert np.unique(result["contact_radius"].values).size > 5


def test_a_punch_whose_middle_lifts_is_no_disk():
    coated = mdr.Layered([mdr.Layer(mdr.Elastic(100.0, 0.3), 1.0)], base=mdr.Elastic(1.0, 0.4))
    result = mdr.solve(mdr.Contact(mdr.FlatPunch(3.0), coated), mdr.indent(0.1))
    assert result.status is mdr.Status.REFUSED
    with pytest.raises(mdr.NotValidError, match="would need tension"):
        result["normal_force"]
    round_one = mdr.solve(mdr.Contact(mdr.Sphere(100.0), coated), mdr.load(0.1))
    assert round_one.status is mdr.Status.COMPLETED


# -- fields -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "a"),
    [
        (film(0.5), 0.5),
        (film(0.5), 3.0),
        (film(0.3, base=mdr.Elastic(0.02, 0.4)), 2.0),
        (film(0.4, bond="frictionless"), 1.0),
    ],
)
def test_fields_by_waves(body, a):
    line = line_of(mdr.Paraboloid(10.0), body)
    contact = mdr.Contact(mdr.Paraboloid(10.0), body)
    depth, force = float(line.depth(a)), float(line.force(a))
    result = mdr.solve(contact, mdr.indent(depth))
    # the pressure is the square root of a distance times a smooth function
    angle = 0.25 * math.pi * (1.0 + np.polynomial.legendre.leggauss(60)[0])
    weight = 0.25 * math.pi * np.polynomial.legendre.leggauss(60)[1]
    r = a * np.sin(angle)
    ring = 2.0 * math.pi * r * a * np.cos(angle) * weight * result.field("pressure", r=r).values
    assert ring.sum() == pytest.approx(force, rel=1e-9)
    # of a half-space by rings, less (2/E*) int (1 - L) P(k) J0(kr) dk, P(k) = int r p J0(kr) dr
    places = np.array([0.0, 1.1, 1.5, 3.0]) * a
    m = 4.0 * places[:, None] * r / (places[:, None] + r) ** 2
    springs = 2.0 / math.pi * ellipk(m) / (places[:, None] + r) @ ring / (math.pi * line.modulus)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    ends = np.append(0.0, np.geomspace(1e-3, 20.0, 12))
    half = 0.5 * np.diff(ends)
    k, fraction = (ends[:-1, None] + half[:, None] * (1.0 + nodes)).ravel(), (half[:, None] * weights).ravel()
    wave = (j0(np.outer(k, r)) @ ring) / (2.0 * math.pi) * Compliance(body).shortfall(k).real
    u = springs - 2.0 / line.modulus * (j0(np.outer(places, k)) @ (fraction * wave))
    computed = result.field("normal_displacement", r=places).values
    assert computed == pytest.approx(u, abs=1e-8 * depth)
    gap = result.field("gap", r=places).values
    assert gap == pytest.approx(
        np.where(places < a, 0.0, places**2 / 20.0 - depth + computed), abs=1e-11 * depth
    )
    x = np.linspace(0.0, a, 7)
    load = result.field("spring_force", r=x).values
    assert load[-1] == pytest.approx(0.0, abs=1e-9 * load[0])


def test_fields_of_an_adhesive_edge():
    contact = mdr.Contact(mdr.Paraboloid(1.0), film(0.5), adhesion=mdr.JKR(0.05))
    result = mdr.solve(contact, mdr.indent(0.2))
    a, d = float(result["contact_radius"][0]), float(result["indentation"][0])
    out = a * np.array([1.0001, 1.2, 2.0])
    gap, u = (result.field(name, r=out).values for name in ("gap", "normal_displacement"))
    assert np.all(gap > 0.0)
    assert gap == pytest.approx(out**2 / 2.0 - d + u, abs=1e-11)
    near = a * (1.0 - np.array([1e-6, 1e-8]))
    amplitude = float(result["edge_amplitude"][0])
    assert result.field("pressure", r=near).values * np.sqrt(a - near) == pytest.approx(amplitude, rel=2e-2)
    assert amplitude == pytest.approx(
        -math.sqrt(0.05 * line_of(mdr.Paraboloid(1.0), film(0.5)).modulus / math.pi), rel=1e-9
    )


# -- thickness ----------------------------------------------------------------------------------------


def test_the_correction_of_a_thin_sample():
    radius, thickness = 10e-6, 5e-6
    depth = np.array([1e-10, 1e-8, 1e-6])
    result = mdr.thickness_correction(mdr.Paraboloid(radius), 0.5, thickness=thickness, indentation=depth)
    # the first term of the series in sqrt(R d) / h, 2/pi int (1 - L) ds
    small = math.sqrt(radius * depth[0]) / thickness
    assert float(result["force_factor"][0]) == pytest.approx(
        1.0 + 2.0 / math.pi * 1.770217 * small, abs=3.0 * small**2
    )
    body = film(0.5, young="3 kPa", thickness=thickness)
    for ball in (mdr.Paraboloid(radius), mdr.Cone(slope=0.3)):
        factor = mdr.thickness_correction(ball, 0.5, thickness=thickness, indentation=depth)["force_factor"]
        on, deep = (
            mdr.solve(mdr.Contact(ball, one), mdr.Path(indentation=depth)) for one in (body, body.top)
        )
        fraction = on["normal_force"].values / deep["normal_force"].values
        assert factor.values == pytest.approx(fraction, rel=1e-9)
    assert result.claims["force_factor"].level is mdr.Level.EXACT
    assert "force factor" in result.summary()
    result.plot()
    loose = mdr.thickness_correction(
        mdr.Paraboloid(radius), 0.5, thickness=thickness, indentation=depth, bond="frictionless"
    )
    assert np.all(loose["force_factor"].values < result["force_factor"].values)
    with pytest.raises(ProblemError, match="above 0 m"):
        mdr.thickness_correction(mdr.Paraboloid(radius), 0.5, thickness=thickness, indentation=[0.0])


# -- what is said, and refused ------------------------------------------------------------------------


def test_a_frictionless_layer_says_that_it_may_lift():
    contact = mdr.Contact(mdr.Sphere(10.0), film(0.3, bond="frictionless"))
    result = mdr.solve(contact, mdr.load(1.0))
    assert "bilateral" in result.claims["normal_force"].reason + result.claims["indentation"].reason
    lifted = next(one for one in result.assumptions if one.name == "contact of the base")
    assert 0.0 < lifted.measure < 0.02
    bonded = mdr.solve(mdr.Contact(mdr.Sphere(10.0), film(0.3)), mdr.load(1.0))
    assert all(one.name != "contact of the base" for one in bonded.assumptions)


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(-8.0, 4.0), st.floats(-4.0, 6.0))
def test_whether_a_layer_lifts_does_not_depend_on_units(metre, pascal):
    metre, pascal = 10.0**metre, 10.0**pascal
    body = film(0.3, young=pascal, thickness=metre, bond="frictionless")
    result = mdr.solve(mdr.Contact(mdr.Sphere(10.0 * metre), body), mdr.load(pascal * metre**2))
    one = mdr.solve(mdr.Contact(mdr.Sphere(10.0), film(0.3, bond="frictionless")), mdr.load(1.0))
    here, there = (
        next(each.measure for each in computed.assumptions if each.name == "contact of the base")
        for computed in (result, one)
    )
    assert here == pytest.approx(there, rel=1e-6)


@pytest.mark.parametrize("load", [1.0, 3e4])
def test_the_lift_of_a_layer_is_detected_next_to_wide_contacts(load):
    """By the inverse Hankel transform at many radii around the edge, of springs of the line."""
    contact = mdr.Contact(mdr.Sphere(1e4), film(0.3, bond="frictionless"))
    result = mdr.solve(contact, mdr.load(load))
    lifted = next(one.measure for one in result.assumptions if one.name == "contact of the base")
    a = float(result["contact_radius"].values[-1])
    line = line_of(contact.profile, contact.body)
    x, loads = line.line_load(a, 0.0)
    h = contact.body.layers[0].thickness
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0.0, 40.0 / h, 10 + int(8.0 * a / h))
    k = (0.5 * (edges[1:] + edges[:-1])[:, None] + 0.5 * np.diff(edges)[:, None] * nodes).ravel()
    pressed = (
        k
        * line.kernel.compliance.stacks[0].pressed_through(k * h)
        * np.outer(0.5 * np.diff(edges), weights).ravel()
    )
    fraction = pressed * (np.cos(np.outer(k, x)) @ loads)
    at_edge = j0(np.outer(a + h * np.linspace(-3.0, 3.0, 241), k)) @ fraction
    middle = float(fraction.sum())
    assert lifted == pytest.approx(-at_edge.min() / max(middle, at_edge.max()), rel=2e-2)


def test_a_row_without_contact_has_radii_next_to_one_that_is_refused():
    tip = mdr.TruncatedParaboloid(70.0, flat_radius=1.4)
    on_a_soft_base = film(0.3, young=6.28, base=mdr.Elastic(1.0, 0.3))
    result = mdr.solve(mdr.Contact(tip, on_a_soft_base), mdr.Path(indentation=[0.0, 2.6e-4]))
    assert result.status is mdr.Status.PARTLY_REFUSED
    field = result.field("pressure", step=0)
    assert np.all(np.isfinite(field["r"].values))
    assert np.all(field.values == 0.0)


def test_the_line_of_layers_keeps_its_profile():
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(10.0), film(0.3)), mdr.load(1.0))
    x = np.array([0.0, 0.3, 2.0])
    assert result.field("equivalent_profile", x).values == pytest.approx(x**2 / 10.0, rel=1e-14)


def test_what_layers_have_no_right_to():
    ball, body = mdr.Sphere(1.0), film(0.4)
    with pytest.raises(ProblemError, match="layered body against a viscoelastic"):
        mdr.Contact(ball, body, mdr.Viscoelastic(mdr.StandardSolid(1.0, 3.0, 1.0), 0.5))
    with pytest.raises(ProblemError, match="different grading"):
        mdr.Contact(ball, body, mdr.Graded(1.0, 1.0, 0.2, 0.3))
    with pytest.raises(ProblemError, match="friction of a layered"):
        mdr.Contact(ball, body, friction=mdr.Coulomb(0.3))
    with pytest.raises(ProblemError, match="MaugisDugdale"):
        mdr.Contact(ball, body, adhesion=mdr.MaugisDugdale(0.05, range=0.1))
    contact = mdr.Contact(ball, body)
    assert mdr.Contact(ball, mdr.Rigid(), body).layered == body
    for ask in (
        lambda: mdr.foundation(contact, n=10),
        lambda: mdr.effective_moduli(body),
        lambda: mdr.impact(contact, mass=1.0, speed=1.0),
        lambda: mdr.restitution(contact, mass=1.0, speeds=[1.0]),
        lambda: mdr.solve(contact, mdr.shift(0.1)),
    ):
        with pytest.raises((ProblemError, mdr.PathError)):
            ask()
    wavy = mdr.Contact(mdr.Paraboloid(1.0) + mdr.Waviness("0.1 m", "0.5 m"), body)
    with pytest.raises(ProblemError, match="decreases at r"):
        mdr.solve(wavy, mdr.indent(0.3))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"layers": []}, "1 to 32"),
        ({"layers": mdr.Elastic(1.0, 0.3)}, "a list of layers"),
        ({"layers": [mdr.Elastic(1.0, 0.3)]}, "^layers contains Elastic"),
        ({"base": "steel"}, "^base"),
        ({"base": mdr.Graded(1.0, 1.0, 0.2, 0.3)}, "^base"),
        ({"bond": "glued"}, "^bond = 'glued'"),
        ({"base": mdr.Elastic(1e12, 0.3)}, "factor of"),
    ],
)
def test_bodies_that_are_none(arguments, words):
    with pytest.raises(ProblemError, match=words):
        mdr.Layered(**{"layers": [mdr.Layer(mdr.Elastic(1.0, 0.3), 1.0)], **arguments})
    with pytest.raises(ProblemError, match="isotropic"):
        mdr.Layer(mdr.Rigid(), 1.0)


def test_files_know_layers(tmp_path):
    body = mdr.Layered(
        [mdr.Layer(mdr.Elastic("1 MPa", 0.5), "1 mm"), mdr.Layer(mdr.Elastic("9 MPa", 0.3), "2 mm")],
        base=mdr.Elastic("1 GPa", 0.3),
        bond="frictionless",
    )
    contact, path = mdr.Contact(mdr.Sphere("5 mm"), body), mdr.load("0.2 N", steps=3)
    assert decode_case(encode_case("", contact, path))[1] == contact
    result = mdr.solve(contact, path)
    result.save(tmp_path / "film.nc")
    again = mdr.open_result(tmp_path / "film.nc")
    assert again.contact == contact
    assert again.field("pressure", r=[0.0]).values == pytest.approx(result.field("pressure", r=[0.0]).values)
    assert "layered" in case_schema()["$defs"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bond": "glued"}, "bond = 'glued'"),
        ({"layers": []}, "at least one entry"),
        ({"base": {"kind": "rigidd"}}, "did you mean 'rigid'"),
        (
            {"layers": [{"material": {"kind": "elastic", "young": 1.0, "poisson": 0.5}, "thicknes": 1.0}]},
            "thickness",
        ),
        ({"layers": [{"material": {"kind": "rigid"}, "thickness": 1.0}]}, "isotropic"),
    ],
)
def test_cases_that_are_none(change, words):
    case = encode_case("", mdr.Contact(mdr.Sphere(1.0), film(0.4)), mdr.load(0.1))
    case["body"] |= change
    with pytest.raises(mdr.CaseError, match=words):
        decode_case(case)


def test_figures_are_drawn():
    import matplotlib.pyplot as plt

    result = mdr.solve(
        mdr.Contact(mdr.Sphere("5 mm"), film(0.45, young="1 MPa", thickness="1 mm")), mdr.load("1 N", steps=5)
    )
    result.plot()
    plt.close("all")


def test_corners_keep_the_digits_of_their_distance():
    line = line_of(mdr.TruncatedSphere(30.0, 2.0), film(0.45, base=mdr.Elastic(100.0, 0.3)))
    nearby = Place(np.full(5, 2.0), np.geomspace(1e-14, 1e-6, 5))
    result = line.place(line.depth(nearby))
    assert result.offset == pytest.approx(nearby.offset, rel=1e-6)
