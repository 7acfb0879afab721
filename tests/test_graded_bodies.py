"""Graded half-spaces: the line with springs c |x|^k against point loads on their surface, energies and limits."""

import itertools
import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import REFERENCES
from drawing import examples
from pymdr.errors import ProblemError

EXPONENTS = st.floats(-0.8, 0.8).filter(lambda k: abs(k) > 1e-3)
SIZES = st.floats(-8.0, 1.0).map(lambda e: 10.0**e)
KINDS = (
    "paraboloid",
    "cone",
    "fourth power",
    "sphere",
    "flat",
    "rounded cone",
    "truncated cone",
    "sum",
    "callable",
)


def profile_of(kind, R):
    return {
        "paraboloid": lambda: mdr.Paraboloid(R),
        "cone": lambda: mdr.Cone(slope=0.2),
        "fourth power": lambda: mdr.PowerLaw(4.0, 0.1 * R, R),
        "sphere": lambda: mdr.Sphere(R),
        "flat": lambda: mdr.FlatPunch(0.3 * R),
        "rounded cone": lambda: mdr.RoundedCone(slope=0.2, tip_radius=0.1 * R),
        "truncated cone": lambda: mdr.TruncatedCone(slope=0.2, flat_radius=0.1 * R),
        "sum": lambda: mdr.Paraboloid(R) + mdr.Cone(slope=0.1),
        "callable": lambda: mdr.Function(lambda r: r * r / (2.0 * R) + 0.1 * R * (r / R) ** 3),
    }[kind]()


def tip_of(kind, R):
    """Radii inside the contact at which the pressure has kinks."""
    return {"rounded cone": (0.02 * R,), "truncated cone": (0.1 * R,)}.get(kind, ())


def body_of(k, R, modulus=1e9):
    return mdr.Graded(young=modulus, depth=R, exponent=k, poisson=0.3)


def gauss(n, low, high):
    t, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (low + high) + 0.5 * (high - low) * t, 0.5 * (high - low) * w


NEAR = 1e-8
"""How near to an infinite pressure it is integrated by nodes, whose radii are rounded, in parts of the stretch."""


def over_disk(result, row, weight, powers=None):
    """int_0^a p(r) weight(r) dr; beside radii in `powers` p is C |r - b|^q + C_0, and its last part is integrated so."""
    a, powers = float(result["contact_radius"][row]), powers or {}
    total = 0.0
    ends = [0.0, *sorted(m for m in powers if 0.0 < m < a), a]

    def pressure(r):
        return result.field("pressure", r, row).values

    for low, high in itertools.pairwise(ends):
        # r = low + (high - low) y is flat at both ends, and so is what is integrated
        x, w = gauss(160, 0.0, 1.0)
        y = x**10 / (x**10 + (1.0 - x) ** 10)
        rate = 10.0 * x**9 * (1.0 - x) ** 9 / (x**10 + (1.0 - x) ** 10) ** 2
        near = NEAR * (high - low)
        first, last = low + near * (low in powers), high - near * (high in powers)
        r = first + (last - first) * y
        inside = (r > first) & (r < last)
        p = pressure(r[inside])
        total += float(np.sum(w[inside] * rate[inside] * (last - first) * p * weight(r[inside])))
        for end, away in ((low, near), (high, -near)):
            if end in powers:
                q = powers[end]
                at = end + away * np.array([1.0, 2.0])
                distance = np.abs(at - end)
                parts = np.linalg.solve(np.column_stack([(distance / near) ** q, np.ones(2)]), pressure(at))
                total += near * float(parts @ [1.0 / (1.0 + q), 1.0]) * float(weight(at[:1])[0])
    return total


@settings(max_examples=examples(30), deadline=None)
@given(kind=st.sampled_from(KINDS), k=EXPONENTS, R=SIZES, fraction=st.floats(0.01, 0.15))
def test_point_loads_make_the_displacement_of_the_axis(kind, k, R, fraction):
    """u(0) = cos(k pi/2) / (pi c) int p / s^(1 + k) dS, without the line; and the pressure carries the load."""
    body = body_of(k, R)
    result = mdr.solve(mdr.Contact(profile_of(kind, R), body), mdr.indent(fraction * R))
    c = mdr.effective_moduli(body).normal
    edge = float(result["contact_radius"][0])
    marks = {edge: 0.5 * (k - 1.0)} if kind == "flat" else dict.fromkeys(tip_of(kind, R), k)
    # the radii asked for are rounded, and tell nothing of a ring too narrow beside a rim with infinite pressure
    assume(all(edge - rim > 1e-2 * rim for rim in tip_of(kind, R)))
    load = over_disk(result, 0, lambda r: 2.0 * math.pi * r, marks)
    assert load == pytest.approx(float(result["normal_force"][0]), rel=1e-8)
    u = over_disk(result, 0, lambda r: 2.0 * np.cos(0.5 * math.pi * k) / c * r**-k, marks)
    assert u == pytest.approx(fraction * R, rel=1e-7)


@pytest.mark.parametrize(("kind", "k"), [("paraboloid", -0.5), ("paraboloid", 0.3), ("flat", 0.3)])
def test_point_loads_make_the_displacement_anywhere(kind, k):
    body = body_of(k, 1.0)
    result = mdr.solve(mdr.Contact(profile_of(kind, 1.0), body), mdr.indent(0.02))
    c, a = mdr.effective_moduli(body).normal, float(result["contact_radius"][0])
    for r in (0.4 * a, 1.7 * a):
        angles, weights = gauss(60, 0.0, math.pi)
        if r > a:
            # the rays that meet the disk, from where they enter it
            half = math.asin(a / r)
            angles, weights = gauss(60, math.pi - half, math.pi)
        x, w = gauss(60, 0.0, 1.0)
        total = 0.0
        for angle, weight in zip(angles, weights, strict=True):
            root = math.sqrt(max(a * a - (r * math.sin(angle)) ** 2, 0.0))
            first, last = max(-r * math.cos(angle) - root, 0.0), -r * math.cos(angle) + root
            y = x**4 / (x**4 + (1.0 - x) ** 4)
            rate = 4.0 * x**3 * (1.0 - x) ** 3 / (x**4 + (1.0 - x) ** 4) ** 2
            rho = first + (last - first) * y
            radius = np.minimum(np.sqrt(r * r + rho * rho + 2.0 * r * rho * math.cos(angle)), a * (1 - 1e-15))
            p = result.field("pressure", radius).values
            total += 2.0 * weight * float(np.sum(w * rate * (last - first) * p * rho**-k))
        u = math.cos(0.5 * math.pi * k) / (math.pi * c) * total
        assert u == pytest.approx(float(result.field("normal_displacement", r)[0]), rel=1e-4)


@settings(max_examples=examples(40), deadline=None)
@given(kind=st.sampled_from(KINDS), k=EXPONENTS, R=SIZES, fraction=st.floats(0.01, 0.15))
def test_energy_force_and_stiffness_are_derivatives(kind, k, R, fraction):
    d = fraction * R * np.array([1.0 - 2e-4, 1.0 - 1e-4, 1.0, 1.0 + 1e-4, 1.0 + 2e-4])
    result = mdr.solve(mdr.Contact(profile_of(kind, R), body_of(k, R)), mdr.Path(indentation=d))
    rates = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0 / (1e-4 * fraction * R)
    energy, force = result["elastic_energy"].values, result["normal_force"].values
    assert float(rates @ energy) == pytest.approx(force[2], rel=1e-9)
    assert float(rates @ force) == pytest.approx(float(result["normal_stiffness"][2]), rel=1e-9)
    by_force = mdr.solve(mdr.Contact(profile_of(kind, R), body_of(k, R)), mdr.load(force[2]))
    assert float(by_force["indentation"][0]) == pytest.approx(d[2], rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("k", [1e-14, -1e-14])
def test_without_grading_it_is_an_elastic_body(kind, k):
    path = mdr.indent(0.05, steps=3)
    one = mdr.solve(mdr.Contact(profile_of(kind, 1.0), body_of(k, 1.0)), path)
    other = mdr.solve(mdr.Contact(profile_of(kind, 1.0), mdr.Elastic(1e9, 0.3)), path)
    for name in ("normal_force", "contact_radius", "normal_stiffness", "elastic_energy"):
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=1e-12)
    r = float(other["contact_radius"][-1]) * np.array([0.1, 0.5, 0.9, 1.2, 3.0])
    for name in ("pressure", "normal_displacement", "gap"):
        results, expected = (each.field(name, r).values for each in (one, other))
        np.testing.assert_allclose(
            results, expected, rtol=1e-11, atol=1e-12 * np.nanmax(expected[np.isfinite(expected)])
        )


def test_references_of_graded_contact():
    for entry in REFERENCES:
        if entry["topic"] == "3 graded normal":
            k, expected = entry["inputs"]["k"], entry["expected"]
            modulus = mdr.effective_moduli(body_of(k, 1.0)).normal
            body = body_of(k, 1.0, 1e9 / modulus)
            result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), body), mdr.indent(expected["d"]))
            assert float(result["contact_radius"][0]) == pytest.approx(1.0, rel=1e-12)
            assert float(result["normal_force"][0]) == pytest.approx(expected["F"], rel=1e-12)
            assert float(result.field("pressure", 0.3)[0]) == pytest.approx(expected["p03"], rel=1e-12)
        if entry["topic"] == "4 JKR graded" and entry["inputs"]["k"] != 0.0:
            given_, expected = entry["inputs"], entry["expected"]
            k = given_["k"]
            modulus = mdr.effective_moduli(body_of(k, 1.0)).normal
            body = body_of(k, 1.0, 1e9 * given_["cN"] / modulus)
            contact = mdr.Contact(mdr.Paraboloid(given_["R"]), body, adhesion=mdr.JKR(given_["gamma"]))
            pull_off = mdr.pull_off(contact, machine_stiffness=0.0)
            assert pull_off.normal_force == pytest.approx(expected["F"], rel=1e-12)
            assert pull_off.contact_radius == pytest.approx(expected["a"], rel=1e-12)
            assert pull_off.indentation == pytest.approx(expected["d"], rel=1e-12)


@settings(max_examples=examples(30), deadline=None)
@given(k=EXPONENTS, R=SIZES, n=st.floats(1.0, 4.0), soft=st.floats(-3.0, 3.0), work=st.floats(-3.0, 1.0))
def test_pull_off_of_powers(k, R, n, soft, work):
    """Where a g' is (3+k)/2 (load) or (1-k)/2 (depth) openings; for a paraboloid -(3+k)/2 pi R work in any body."""
    assume(n > 0.5 * (1.0 - k) + 0.3)
    body, work = body_of(k, R, 1e6 * 10.0**soft), 10.0**work * 1e-3 * R / 1e-6
    c = mdr.effective_moduli(body).normal
    contact = mdr.Contact(mdr.PowerLaw(n, 0.1 * R, R), body, adhesion=mdr.JKR(work))
    for machine, fraction in ((0.0, 0.5 * (3.0 + k)), (math.inf, 0.5 * (1.0 - k))):
        pull_off = mdr.pull_off(contact, machine_stiffness=machine)
        a = pull_off.contact_radius
        opening = math.sqrt(2.0 * math.pi * work * a ** (1.0 - k) / c)
        g = pull_off.indentation + opening
        assert n * g == pytest.approx(fraction * opening, rel=1e-9)
        assert pull_off.normal_force == pytest.approx(
            2.0 * c * a ** (1.0 + k) * (n * g / (n + 1.0 + k) / (1.0 + k) - opening / (1.0 + k)), rel=1e-9
        )
    ball = mdr.Contact(mdr.Paraboloid(R), body, adhesion=mdr.JKR(work))
    exact = -0.5 * (3.0 + k) * math.pi * R * work
    assert mdr.pull_off(ball, machine_stiffness=0.0).normal_force == pytest.approx(exact, rel=1e-11)


@settings(max_examples=examples(15), deadline=None)
@given(
    kind=st.sampled_from([k for k in KINDS if k != "flat"]),
    k=EXPONENTS,
    R=SIZES,
    machine=st.floats(-2.0, 2.0),
)
def test_cycles_of_sticky_bodies_keep_their_energy(kind, k, R, machine):
    body, work = body_of(k, R, 1e6), 1e-3 * R / 1e-6
    contact = mdr.Contact(profile_of(kind, R), body, adhesion=mdr.JKR(work))
    pull_off = mdr.pull_off(contact)
    range_ = 4.0 * abs(pull_off.indentation) + 1e-4 * R
    stiffness = 10.0**machine * abs(pull_off.normal_force) / range_
    for path, given_ in (
        (mdr.indent(range_, steps=7) >> mdr.indent(-4.0 * range_, steps=9), None),
        (
            mdr.Path(travel=range_ * np.array([0.5, 1.0, 0.0, -40.0, -400.0 * (1.0 + 10.0**-machine)])),
            stiffness,
        ),
    ):
        result = mdr.solve(contact, path, machine_stiffness=given_)
        balance = next(a for a in result.assumptions if a.name == "energy balance")
        assert balance.measure < 1e-9
        attached = (result["contact_radius"].values > 0.0) & np.isfinite(result["contact_radius"].values)
        released = result["energy_release_rate"].values[attached]
        np.testing.assert_allclose(released, work, rtol=1e-9)
        assert result["dissipated_energy"].values[-1] > 0.0
        assert (
            np.diff(result["dissipated_energy"].values) >= -1e-12 * result["dissipated_energy"].values[-1]
        ).all()


def test_the_regime_goes_over_into_that_of_homogeneous_bodies():
    law = mdr.JKR("50 mJ/m^2")
    graded = mdr.Contact(mdr.Paraboloid("1 um"), body_of(1e-10, 1e-6), adhesion=law)
    elastic = mdr.Contact(mdr.Paraboloid("1 um"), mdr.Elastic(1e9, 0.3), adhesion=law)
    one, other = (mdr.adhesion_regime(contact, range="0.3 nm") for contact in (graded, elastic))
    assert one.tabor == pytest.approx(other.tabor, rel=1e-8)
    assert one.maugis == pytest.approx(other.maugis, rel=1e-8)
    assert set(one.pull_off_force) == {"JKR", "DMT"}


def test_what_graded_bodies_refuse():
    body = body_of(0.3, 1e-3)
    ball = mdr.Sphere("1 mm")
    with pytest.raises(ProblemError, match="friction"):
        mdr.Contact(ball, body, friction=mdr.Coulomb(0.3))
    with pytest.raises(ProblemError, match="MaugisDugdale"):
        mdr.Contact(ball, body, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="0.5 nm"))
    with pytest.raises(ProblemError, match="exponent"):
        mdr.Contact(ball, body, mdr.Elastic("1 GPa", 0.3))
    with pytest.raises(ProblemError, match="rings"):
        mdr.solve(mdr.Contact(ball, body), mdr.indent("1 um"), solver=mdr.Rings(n=50))
    with pytest.raises(ProblemError, match=r"exponent above 0\.35"):
        mdr.pull_off(mdr.Contact(mdr.PowerLaw(0.3, "1 um", "1 mm"), body, adhesion=mdr.JKR("50 mJ/m^2")))


def near_the_rim(k, R, c, work, machine, travel, radius):
    """Depth, force and opening of a sticky truncated cone (slope 0.2, b = R/10) at a travel, in extended precision.

    g = 0.2 a int_0^T sin^k, T = arccos(b/a), and int_b^a x^k g dx by parts; found by the q = ((a^2 - b^2)/b^2)^((1+k)/2)
    in which g is straight beside the rim.
    """
    with mpmath.workdps(40):
        k, b, c, work, machine, travel, radius = map(
            mpmath.mpf, (k, 0.1 * R, c, work, machine, travel, radius)
        )
        slope, half = mpmath.mpf(0.2), (1 + k) / 2

        def state(q):
            z = q ** (1 / half)
            a, square = b * mpmath.sqrt(1 + z), z / (1 + z)
            angle = square**half / (1 + k) * mpmath.hyp2f1(0.5, half, half + 1, square)
            opening = mpmath.sqrt(2 * mpmath.pi * work * a ** (1 - k) / c)
            d = slope * a * angle - opening
            moment = slope * (a ** (k + 2) * angle - b ** (k + 2) * z**half / (1 + k)) / (k + 2)
            return d, 2 * c * (d * a ** (1 + k) / (1 + k) - moment), opening

        z, opening = (radius / b) ** 2 - 1, state(mpmath.mpf(0))[2]
        q = z**half if z > 1e-3 else (1 + k) * opening / (slope * b)

        def missing(q):
            d, force, _ = state(q)
            return (d + force / machine - travel) / opening

        result = mpmath.findroot(missing, (q, 1.001 * q), tol=1e-50, maxsteps=60)
        return tuple(float(value) for value in state(result))


@settings(max_examples=examples(25), deadline=None)
@given(
    k=st.floats(-0.95, 0.9),
    R=SIZES,
    soft=st.floats(-4.0, 1.0),
    sticky=st.floats(-9.0, -5.0),
    depth=st.floats(-3.5, -2.0),
)
@example(k=-0.9375, R=1.0, soft=-4.0, sticky=-5.0, depth=-3.0)
def test_a_machine_moves_an_adhesive_punch_with_a_rim_to_its_targets(k, R, soft, sticky, depth):
    """Beside a rim g rises like (a - b)^((1 + k)/2), for k near -1 almost at once; nothing may be lost there."""
    body = body_of(k, R)
    size = mdr.effective_moduli(body).normal * R ** (1.0 + k)
    machine, top = size * 10.0**soft, R * 10.0**depth
    contact = mdr.Contact(profile_of("truncated cone", R), body, adhesion=mdr.JKR(size * 10.0**sticky))
    path = mdr.travel(top, steps=6) >> mdr.travel(-3.0 * top, steps=8)
    result = mdr.solve(contact, path, machine_stiffness=machine)
    indentation = np.concatenate([np.linspace(0.0, top, 7)[1:], np.linspace(top, -3.0 * top, 9)[1:]])
    force, closed = result["normal_force"].values, result["contact_radius"].values > 0.0
    travel = result["indentation"].values + force / machine
    scale = np.abs(indentation) + np.abs(force) / machine + top
    assert np.all(np.abs(travel - indentation)[closed] <= 1e-8 * scale[closed])
    energies = np.abs(result["elastic_energy"].values) + np.abs(result["surface_energy"].values)
    assert np.all(result["jump_dissipation"].values >= -1e-10 * np.max(energies))
    rows = np.flatnonzero(closed)
    for row in rows[[0, -1]] if rows.size else rows:
        c, work = size / R ** (1.0 + k), contact.adhesion.work
        at = indentation[row], float(result["contact_radius"][row])
        d, F, opening = near_the_rim(k, R, c, work, machine, *at)
        # a difference of g and the opening, and its force: to rounding of those
        rounding, stiffness = 64 * np.finfo(float).eps, float(result["normal_stiffness"][row])
        assert result["indentation"].values[row] == pytest.approx(
            d, rel=0.0, abs=rounding * (opening + abs(d))
        )
        assert force[row] == pytest.approx(F, rel=0.0, abs=rounding * (stiffness * opening + abs(F)))


@pytest.mark.parametrize("k", [-0.9, -0.3])
def test_springs_in_the_middle_bear_nothing_where_they_are_not_pressed(k):
    flat = mdr.solve(mdr.Contact(mdr.FlatPunch(1.0), body_of(k, 1.0)), mdr.Path(indentation=[0.0, 0.1]))
    assert float(flat.field("spring_force", 0.0, 0).values[0]) == 0.0
    assert float(flat.field("spring_force", 0.0, 1).values[0]) == math.inf


@pytest.mark.parametrize("leg", [mdr.indent, mdr.load])
def test_a_rate_that_is_none_says_which_units_are(leg):
    with pytest.raises(mdr.UnitError, match=r"'1 um': give a speed such as '1 um/s'.* '1 N/s'"):
        leg(1e-6, rate="1 um")


@settings(max_examples=examples(25), deadline=None)
@given(k=st.floats(-0.99, -0.8), slope=st.floats(-2.0, 0.0), work=st.floats(-9.0, 2.0))
@example(k=-0.96, slope=-0.3, work=-2.0)
@example(k=-0.97, slope=-0.3, work=-2.0)
def test_cones_on_bodies_that_are_the_stiffer_the_smaller_a_contact_is(k, slope, work):
    """a^((1 + k)/2) = (1 - k)/2 sqrt(2 pi work / c) / (kappa t): a pull as faint as any, or no number at all."""
    slope, work, body = 10.0**slope, 10.0**work, body_of(k, 1.0, 1e6)
    c = mdr.effective_moduli(body).normal
    kappa = 0.5 * math.exp(math.lgamma(0.5) + math.lgamma(0.5 * (1.0 + k)) - math.lgamma(1.0 + 0.5 * k))
    fraction = 0.5 * (1.0 - k) * math.sqrt(2.0 * math.pi * work / c) / (kappa * slope)
    decades = math.log10(fraction) * 2.0 / (1.0 + k)
    contact = mdr.Contact(mdr.Cone(slope=slope), body, adhesion=mdr.JKR(work))
    if decades < -142.0:
        with pytest.raises(mdr.PymdrError, match="gives contact radii below 1e-140 m"):
            mdr.pull_off(contact)
    elif -138.0 < decades < 100.0:
        assert math.log10(mdr.pull_off(contact).contact_radius) == pytest.approx(decades, abs=1e-8)
