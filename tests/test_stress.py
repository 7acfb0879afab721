"""Stress and displacement inside the bodies, and their largest values."""

import itertools
import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import BALL_CASE, references
from drawing import examples, first_of
from pymdr.interpretation.stress import displacement, line_load, stress, sums
from pymdr.interpretation.tensors import principal_stresses, von_mises
from pymdr.line.curves import ElasticLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import Place

STEEL = mdr.Elastic("210 GPa", 0.3)
HERTZ = mdr.Paraboloid(2.0 / math.pi)
"""A contact of radius 1 m under a peak pressure of 1 Pa, where E* = 1 Pa."""
DEPTHS = np.array([1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 1.0, 3.0, 100.0])


def place(a):
    return Place(np.float64(0.0), np.float64(a))


def load_of(profile, a=1.0, excess=0.0, modulus=1.0, **zone):
    return line_load(ElasticLine(equivalent_profile(profile), modulus), place(a), excess, **zone)


def tensor(load, r, z, nu=0.3):
    r, z = np.broadcast_arrays(np.asarray(r, dtype=float), np.asarray(z, dtype=float))
    return stress(sums(load, r, z), nu)


@pytest.mark.parametrize("entry", references("3 subsurface"), ids=lambda entry: entry["id"])
def test_references(entry):
    inputs, expected = entry["inputs"], entry["expected"]
    if "tau_over_p0" in expected:
        computed = tensor(load_of(HERTZ), 0.0, expected["z_over_a"], inputs["nu"])
        assert 0.5 * (computed[0] - computed[2]) == pytest.approx(expected["tau_over_p0"], rel=1e-12)
        return
    profile = HERTZ if entry["id"].startswith("hertz") else mdr.Cone(slope=1.0)
    computed = tensor(load_of(profile), inputs["r"], inputs["z"], inputs["nu"])
    assert computed == pytest.approx([expected[name] for name in ("srr", "stt", "szz", "srz")], rel=1e-9)


@pytest.mark.parametrize("a", [1e-9, 1.0, 1e3])
def test_hertz_on_the_axis(a):
    # Huber (1904)
    load = load_of(mdr.Paraboloid(2.0 * a / math.pi), a)
    result, nu = tensor(load, 0.0, a * DEPTHS), 0.3
    axial = -1.0 / (1.0 + DEPTHS**2)
    radial = -(1.0 + nu) * (1.0 - DEPTHS * np.arctan(1.0 / DEPTHS)) - 0.5 * axial
    near = DEPTHS < 10.0
    assert result[2] == pytest.approx(axial, rel=1e-13)
    assert result[:2, near] == pytest.approx(np.array([radial, radial])[:, near], rel=1e-13, abs=1e-14)
    assert result[3].tolist() == [0.0] * DEPTHS.size


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-18.0, 0.0), st.floats(-18.0, -3.0))
def test_next_to_the_axis_the_stress_is_that_on_it(depth, fraction):
    z = 10.0**depth
    for load in (load_of(HERTZ), load_of(mdr.Cone(slope=1.0)), load_of(HERTZ, zone=1.25, strength=0.4)):
        off_axis, on_axis = tensor(load, z * 10.0**fraction, z), tensor(load, 0.0, z)
        assert off_axis[:3] == pytest.approx(on_axis[:3], rel=10.0 * 10.0**fraction, abs=1e-12)


def test_hertz_at_the_surface():
    # Johnson (1985), eq. 3.42
    r = np.concatenate([np.linspace(0.05, 0.95, 19), 1.0 - np.geomspace(1e-9, 1e-2, 5), [1.0, 1.2, 3.0]])
    p, nu = np.sqrt(np.maximum((1.0 - r) * (1.0 + r), 0.0)), 0.3
    carried = (1.0 - p**3) / (3.0 * r * r)
    exact = np.array(
        [(1.0 - 2.0 * nu) * carried - p, -(1.0 - 2.0 * nu) * carried - 2.0 * nu * p, -p, np.zeros(r.size)]
    )
    assert tensor(load_of(HERTZ), r, 0.0) == pytest.approx(exact, abs=3e-13)


def test_flat_punch_inside():
    # Sneddon (1946): integrals of e^(-kz) sin(k) and Bessel functions over k
    r, z, nu = np.array([0.1, 0.5, 0.99, 1.5, 2.0]), np.array([0.3, 1e-3, 0.02, 1e-2, 2.0]), 0.3
    result = tensor(load_of(mdr.FlatPunch(1.0), excess=1.0), r, z, nu)
    R, phi = np.sqrt(np.hypot(r**2 + z**2 - 1.0, 2.0 * z)), 0.5 * np.arctan2(2.0 * z, r**2 + z**2 - 1.0)
    theta, s = np.arctan2(1.0, z), np.hypot(1.0, z)
    j0, kj0, kj1 = np.sin(phi) / R, s / R**3 * np.sin(3.0 * phi - theta), r / R**3 * np.sin(3.0 * phi)
    assert result[2] == pytest.approx(-(j0 + z * kj0) / math.pi, rel=1e-12)
    assert result[3] == pytest.approx(-z * kj1 / math.pi, rel=1e-12)
    assert result[:3].sum(axis=0) == pytest.approx(-2.0 * (1.0 + nu) * j0 / math.pi, rel=1e-12)


def direct(q, ends, r, z, nu):
    """The stress by complex point sources q, without sums by parts, in 40 digits."""
    r, z = mp.mpf(r), mp.mpf(z)
    near = [r + sign * z * mp.mpf(20) ** (k - 1) for k in range(14) for sign in (1, -1)] + [r]

    def whole(kernel):
        def integrand(s):
            zeta = z + 1j * s
            return q(s) * kernel(mp.sqrt(r * r + zeta * zeta), zeta)

        return 2 * sum(
            mp.re(mp.quad(integrand, sorted({low, high, *(x for x in near if low < x < high)})))
            for low, high in itertools.pairwise(ends)
        )

    v_z, v_r = (-whole(kernel) for kernel in (lambda R, c: c / R**3, lambda R, c: 1 / R**3))
    v_zz = whole(lambda R, c: 3 * c * c / R**5 - 1 / R**3)
    v_rz = 3 * r * whole(lambda R, c: c / R**5)
    mean = whole(lambda R, c: 1 / (R * (R + c)))
    terms = (
        2 * nu * v_z + (1 - 2 * nu) * (v_z + mean) + z * (v_zz + v_r),
        2 * nu * v_z - (1 - 2 * nu) * mean - z * v_r,
        v_z - z * v_zz,
        -z * v_rz,
    )
    return np.array([float(term / (2 * mp.pi)) for term in terms])


C = 1.25
DIRECT = {
    "hertz": (load_of(HERTZ), lambda s: mp.pi / 2 * (1 - s * s), (0, 1)),
    "jkr": (load_of(HERTZ, excess=-0.5), lambda s: mp.pi / 2 * (1 - s * s) - 0.5, (0, 1)),
    "cone": (load_of(mdr.Cone(slope=1.0)), lambda s: mp.pi / 2 * (1 - s), (0, 1)),
    "maugis": (
        load_of(HERTZ, zone=C, strength=0.4),
        lambda s: (
            -mp.mpf(0.8) * mp.sqrt(C**2 - s * s) if s > 1 else mp.pi / 2 * (1 - s * s) - mp.mpf(0.8) * 0.75
        ),
        (0, 1, C),
    ),
}


@pytest.mark.parametrize("point", first_of([(0.3, 1e-3), (0.999999, 1e-6), (1.0000001, 1e-9), (1.0, 1e-12)]))
@pytest.mark.parametrize("case", DIRECT)
def test_stress_is_that_of_point_sources(case, point):
    load, q, ends = DIRECT[case]
    with mp.workdps(40):
        exact = direct(q, [mp.mpf(end) for end in ends], *point, mp.mpf(3) / 10)
    assert tensor(load, *point) == pytest.approx(exact, abs=1e-14 * max(1.0, np.max(np.abs(exact))))


LENGTH = st.sampled_from([1e-9, 1e-3, 1e3])
TIPS = st.one_of(
    st.builds(lambda n: mdr.PowerLaw(n, 0.1, 1.0), st.floats(1.0, 6.0)),
    st.builds(lambda b, R: mdr.RoundedFlat(b, R), st.floats(0.1, 0.9), st.floats(1.0, 5.0)),
    st.builds(lambda b: mdr.TruncatedParaboloid(b, 3.0), st.floats(0.1, 0.9)),
    st.builds(lambda b: mdr.RoundedCone(b, slope=0.1), st.floats(0.1, 3.0)),
    st.builds(lambda R: mdr.Sphere(R), st.floats(1.1, 10.0)),
    st.just(mdr.Paraboloid(2.0) + mdr.Cone(slope=0.1)),
)
POISSON = st.floats(-0.9, 0.5)


@settings(max_examples=examples(40), deadline=None)
@given(TIPS, POISSON, st.floats(0.05, 3.0), st.floats(0.05, 3.0), st.floats(-0.3, 0.3))
def test_equilibrium_and_hooke(profile, nu, r, z, excess):
    load = load_of(profile, excess=excess)
    h, k = 2e-3 * min(r, z), np.arange(-2, 3)
    weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * h)
    across, down = tensor(load, r + h * k, z, nu), tensor(load, r, z + h * k, nu)
    centre = across[:, 2]
    size = np.max(np.abs(centre)) / min(r, z)
    by_r, by_z = across @ weights, down @ weights
    assert abs(by_r[0] + by_z[3] + (centre[0] - centre[1]) / r) < 1e-8 * size
    assert abs(by_r[3] + by_z[2] + centre[3] / r) < 1e-8 * size

    def moved(r, z):
        r, z = np.broadcast_arrays(r, z)
        return displacement(sums(load, r, z), r, z, nu, shear=0.5)

    u_r, u_z = moved(r, np.array([z]))[:, 0]
    slope_r, slope_z = moved(r + h * k, z) @ weights, moved(r, z + h * k) @ weights
    strain = np.array([slope_r[0], u_r / r, slope_z[1], 0.5 * (slope_r[1] + slope_z[0])])
    trace = centre[:3].sum()
    exact = (1.0 + nu) * centre - nu * trace * np.array([1.0, 1.0, 1.0, 0.0])
    # with 2 G = 1 Young's modulus is 1 + nu
    assert (1.0 + nu) * strain == pytest.approx(exact, abs=1e-7 * (size * min(r, z) + abs(u_z)))


@settings(max_examples=examples(30), deadline=None)
@given(TIPS, POISSON, st.floats(0.02, 0.99) | st.floats(1.01, 1.4), st.sampled_from([0.0, 1e-12]))
def test_surface_tractions(profile, nu, fraction, depth):
    contact = mdr.Contact(profile, mdr.Elastic(1.0, nu))
    result = mdr.solve(contact, mdr.indent(0.05))
    a = float(result["contact_radius"][-1])
    r = fraction * a
    p = float(result.field("pressure", [r])[0])
    computed = result.field("stress", [r], z=[depth * a]).values[:, 0, 0]
    peak = float(result["mean_pressure"][-1])
    assert computed[2] == pytest.approx(-p, abs=1e-11 * peak + 10.0 * math.sqrt(depth) * peak)
    assert abs(computed[3]) <= 10.0 * math.sqrt(depth) * peak


@settings(max_examples=examples(20), deadline=None)
@given(TIPS, POISSON, st.floats(0.0, 1.5), st.floats(0.3, 4.0), st.floats(-0.2, 0.2))
def test_planes_carry_the_load_and_far_away_it_is_a_point(profile, nu, angle, depth, excess):
    line = ElasticLine(equivalent_profile(profile), 1.0)
    force = float(line.force(place(1.0)) + excess * line.stiffness(place(1.0)))
    assume(abs(force) > 1e-3)
    load = load_of(profile, excess=excess)
    t, w = np.polynomial.legendre.leggauss(200)
    phi = 0.25 * math.pi * (t + 1.0)
    r = np.tan(phi) * max(depth, 1.0)
    carried = tensor(load, r, depth, nu)[2] * 2.0 * math.pi * r * max(depth, 1.0) / np.cos(phi) ** 2
    assert 0.25 * math.pi * carried @ w == pytest.approx(-force, rel=1e-9, abs=1e-9)
    # Boussinesq; the next term is smaller by the square of the distance
    R = 1e5
    r, z = R * math.sin(angle), R * math.cos(angle)
    computed = tensor(load, r, z, nu) * R * R / force
    c, s = math.cos(angle), math.sin(angle)
    k = (1.0 - 2.0 * nu) / (1.0 + c)
    exact = np.array(
        [k - 3.0 * s * s * c, -(1.0 - 2.0 * nu) * (1.0 / (1.0 + c) - c), -3.0 * c**3, -3.0 * s * c * c]
    )
    assert computed == pytest.approx(exact / (2.0 * math.pi), abs=1e-6)


@settings(max_examples=examples(20), deadline=None)
@given(LENGTH, st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(1.2, 4.0))
def test_stress_does_not_depend_on_the_unit(scale, r, z, n):
    results = [tensor(load_of(mdr.PowerLaw(n, 0.1 * L, L), L), r * L, z * L) for L in (1.0, scale)]
    assert results[1] == pytest.approx(results[0], rel=1e-12, abs=1e-13)


def test_fields_are_labelled_and_derived():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, mdr.Elastic("70 GPa", 0.22))
    result = mdr.solve(contact, mdr.load("50 N", steps=2))
    whole = result.field("stress", r=["0 um", "50 um"], z=["0 um", "20 um", "1 mm"], step=None)
    assert whole.dims == ("step", "component", "z", "r")
    assert whole.component.values.tolist() == ["rr", "tt", "zz", "rz"]
    assert whole.attrs["units"] == "Pa"
    one = result.field("stress", r=["0 um", "50 um"], z=["0 um", "20 um", "1 mm"])
    assert np.array_equal(one.values, whole.values[1])
    rows = {"r": ["0 um", "50 um"], "z": ["0 um", "20 um", "1 mm"]}
    assert np.array_equal(result.field("von_mises", **rows).values, von_mises(one.values))
    principal = principal_stresses(one.values)
    assert np.array_equal(result.field("principal_stress", **rows).values, principal)
    assert result.field("tresca", **rows).values == pytest.approx(principal[0] - principal[2])
    assert result.field("hydrostatic", **rows).values == pytest.approx(principal.mean(axis=0))
    assert result.field("von_mises").shape == (101, 101)
    assert result.claims["stress"].level is mdr.Level.EXACT
    other = result.field("stress", side="counterbody", **rows)
    assert other.sel(component="zz").values == pytest.approx(one.sel(component="zz").values)
    assert not np.allclose(other.sel(component="rr"), one.sel(component="rr"))


def test_both_surfaces_move_by_the_displacement_of_the_contact():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, mdr.Elastic("70 GPa", 0.22))
    result = mdr.solve(contact, mdr.load("50 N"))
    r = np.array([0.0, 0.3, 0.9, 1.5, 5.0]) * float(result["contact_radius"][0])
    moved = sum(
        result.field("interior_displacement", r, z=[0.0], side=side).sel(component="z")[0]
        for side in ("body", "counterbody")
    )
    assert moved.values == pytest.approx(result.field("normal_displacement", r).values, rel=1e-12)


@pytest.mark.parametrize("side", ["body", "counterbody"])
def test_largest_stress_of_hertz(side):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, mdr.Elastic("70 GPa", 0.25))
    result = mdr.solve(contact, mdr.load("50 N"))
    expected = next(
        entry["expected"]
        for entry in references("3 subsurface")
        if entry["inputs"]["nu"] == getattr(contact, side).poisson and "tau_over_p0" in entry["expected"]
    )
    computed = result.largest("tresca", step=-1, side=side)
    p, a = (float(result[name][-1]) for name in ("peak_pressure", "contact_radius"))
    assert float(computed) == pytest.approx(2.0 * expected["tau_over_p0"] * p, rel=1e-8)
    assert float(computed.z) == pytest.approx(expected["z_over_a"] * a, abs=1e-4 * a)
    assert float(computed.r) == pytest.approx(0.0, abs=1e-4 * a)


@settings(max_examples=examples(8), deadline=None)
@given(TIPS, st.floats(-0.5, 0.5), st.floats(0.01, 0.1))
def test_nothing_exceeds_the_largest_stress(profile, nu, depth):
    result = mdr.solve(mdr.Contact(profile, mdr.Elastic(1.0, nu)), mdr.indent(depth))
    if math.isinf(float(result["peak_pressure"][-1])):
        if nu < 0.5:
            with pytest.raises(mdr.NotValidError, match="without bound"):
                result["largest_mises"]
        return
    a = float(result["contact_radius"][-1])
    rng = np.random.default_rng(0)
    r, z = a * np.sort(1.2 * rng.random(60)), a * np.sort(rng.random(60) ** 2)
    for field, name, factor in (("von_mises", "largest_mises", 1.0), ("tresca", "largest_shear", 0.5)):
        largest = result[name]
        everywhere = result.field(field, r, z=z).values
        assert factor * everywhere.max() <= float(largest[-1]) * (1.0 + 1e-9)
        at = result.field(field, [float(largest.r[-1])], z=[float(largest.z[-1])])
        assert factor * float(at[0, 0]) == pytest.approx(float(largest[-1]), rel=1e-9)


def test_maugis_is_between_hertz_and_a_pulled_edge():
    law = mdr.MaugisDugdale("1 J/m^2", "1 GPa")
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), STEEL, adhesion=law), mdr.load("0.1 N"))
    a, c = (float(result[name][-1]) for name in ("contact_radius", "cohesive_radius"))
    r = np.array([0.5 * a, 0.999 * a, 0.5 * (a + c), 1.01 * c])
    surface = result.field("stress", r, z=[0.0]).sel(component="zz").values[0]
    assert surface == pytest.approx(-result.field("pressure", r).values, rel=1e-11, abs=1e-3)
    assert np.isfinite(result["largest_mises"].values).all()


def test_cohesion_without_contact_pulls_on_its_disk():
    law = mdr.MaugisDugdale("1 J/m^2", "1 MPa")
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), STEEL, adhesion=law), mdr.indent("-0.5 um"))
    c = float(result["cohesive_radius"][-1])
    assert float(result["contact_radius"][-1]) == 0.0 < c
    computed = result.field("stress", [0.0, 0.9 * c, 1.1 * c], z=[0.0])
    assert computed.sel(component="zz").values[0] == pytest.approx([1e6, 1e6, 0.0], rel=1e-12, abs=1e-6)
    # under a uniform load in a disk, Johnson (1985), eq. 3.33
    z = np.array([1e-6, 0.3, 1.0, 4.0])
    axial = result.field("stress", [0.0], z=z * c).sel(component="zz").values[:, 0]
    assert axial == pytest.approx(1e6 * (1.0 - z**3 / (1.0 + z * z) ** 1.5), rel=1e-11)


def test_stress_of_a_saved_result(tmp_path):
    law = mdr.MaugisDugdale("1 J/m^2", "1 GPa")
    for profile, adhesion in ((mdr.RoundedFlat("1 mm", "10 mm"), None), (mdr.Paraboloid("1 mm"), law)):
        result = mdr.solve(mdr.Contact(profile, STEEL, adhesion=adhesion), mdr.indent("1 um", steps=2))
        result.save(tmp_path / "stress.nc")
        again = mdr.open_result(tmp_path / "stress.nc")
        assert again.claims["stress"].level is result.claims["stress"].level
        rows = {"r": ["0 um", "100 um"], "z": ["0 um", "10 um"], "step": None}
        assert again.field("stress", **rows).values == pytest.approx(result.field("stress", **rows).values)
        result.to_csv(tmp_path / "stress.csv", quantities=["largest_mises"], units={"largest_mises": "MPa"})
        assert (tmp_path / "stress.csv").read_text().splitlines()[0] == "step,largest_mises [MPa]"


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), "edge of the contact, which is sharp"),
        (mdr.Contact(mdr.Paraboloid("1 mm"), STEEL, adhesion=mdr.JKR("1 J/m^2")), "adhesion pulls open"),
        (mdr.Contact(mdr.Cone(slope=0.1), STEEL), "sharp tip"),
    ],
)
def test_largest_stress_is_refused_where_it_has_no_bound(contact, words):
    result = mdr.solve(contact, mdr.indent("1 um"))
    with pytest.raises(mdr.NotValidError, match=words):
        result["largest_mises"]
    assert np.isfinite(result.field("von_mises", [1e-5], z=[1e-5])).all()


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (mdr.Contact(mdr.Sphere("1 mm"), mdr.Graded("1 GPa", "1 mm", 0.2, 0.3)), "graded"),
        (
            mdr.Contact(mdr.Sphere("1 mm"), mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), bulk="1 GPa")),
            "nu changes",
        ),
        (mdr.Contact(mdr.Sphere("1 mm"), STEEL, adhesion=mdr.DMT("1 J/m^2")), "DMT"),
        (mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3, thickness="1 mm")), "thickness"),
    ],
)
def test_stress_that_is_not_known_is_not_valid(contact, words):
    result = mdr.solve(contact, mdr.indent("1 um", duration="1 s"))
    assert result.claims["stress"].level is mdr.Level.NOT_VALID
    for read in (lambda: result.field("stress"), lambda: result["largest_mises"]):
        with pytest.raises(mdr.NotValidError, match=words):
            read()


def test_bad_requests_name_what_is_wrong():
    result = mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), STEEL), mdr.indent("1 um"))
    for arguments, error, words in (
        ({"z": [-1e-6]}, mdr.QuantityError, "at least 0 m"),
        ({"z": [[0.0]]}, mdr.QuantityError, "one row"),
        ({"side": "left"}, mdr.ProblemError, "'body' or 'counterbody'"),
        ({"side": "counterbody"}, mdr.NotValidError, "rigid"),
        ({"angle": 0.0}, mdr.QuantityError, "angle="),
    ):
        with pytest.raises(error, match=words):
            result.field("stress", **arguments)
    with pytest.raises(mdr.QuantityError, match="inside a body"):
        result.field("pressure", z=[0.0])
    with pytest.raises(mdr.QuantityError, match="von_mises, tresca"):
        result.largest("pressure")


@settings(max_examples=examples(8), deadline=None)
@given(st.floats(-0.2, 0.5), LENGTH, st.floats(1.2, 4.0))
def test_first_yield_is_where_the_largest_stress_is_the_strength(nu, radius, n):
    contact = mdr.Contact(mdr.PowerLaw(n, 1e-2 * radius, radius), mdr.Elastic(1.0, nu))
    study = mdr.first_yield(contact, strength=1e-3)
    for i, (name, factor) in enumerate((("largest_mises", 1.0), ("largest_shear", 2.0))):
        result = mdr.solve(contact, mdr.load(float(study["normal_force"][i])))
        assert factor * float(result[name][0]) == pytest.approx(1e-3, rel=1e-7)


def test_first_yield_of_hertz():
    # p = Y / (2 * 0.31002), F = pi^3 R^2 p^3 / (6 E*^2)
    result = mdr.first_yield(mdr.Contact(mdr.Paraboloid("10 mm"), STEEL), strength="1 GPa")
    pressure, modulus = 1e9 / (2.0 * 0.3100205019545214), 210e9 / 0.91
    exact = math.pi**3 * 1e-4 * pressure**3 / (6.0 * modulus**2)
    assert result["normal_force"].values == pytest.approx([exact] * 2, rel=1e-7)
    depth = 0.4808644852928954 * float(result["contact_radius"][0])
    assert result["yield_depth"].values == pytest.approx([depth] * 2, rel=2e-4)
    assert result.plot().axes


def test_first_yield_at_a_corner_that_comes_into_contact():
    # the edge of the dome is reached at d = g(b) = b^2 / R
    result = mdr.first_yield(mdr.Contact(mdr.DomedPunch("0.1 mm", "100 mm"), STEEL), strength="1 GPa")
    assert result["indentation"].values == pytest.approx([1e-7] * 2, rel=1e-6)
    assert result["yield_radius"].values == pytest.approx([1e-4] * 2, rel=1e-6)
    assert "corner" in result.notes[-1]


@pytest.mark.parametrize(
    ("contact", "error", "words"),
    [
        (mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), mdr.NotValidError, "sharp"),
        (mdr.Contact(mdr.Cone(slope=0.1), STEEL), mdr.NotValidError, "sharp tip"),
        (mdr.Contact(mdr.Cone(slope=0.1), mdr.Elastic("1 GPa", 0.5)), mdr.NotValidError, "under a cone"),
        (mdr.Contact(mdr.TruncatedParaboloid("10 mm", "1 mm"), STEEL), mdr.NotValidError, "corner"),
        (
            mdr.Contact(mdr.Sphere("1 mm"), STEEL, friction=mdr.Coulomb(math.inf)),
            mdr.ProblemError,
            "force_ratio",
        ),
        (
            mdr.Contact(mdr.Sphere("1 mm"), STEEL, adhesion=mdr.JKR("1 J/m^2")),
            mdr.ProblemError,
            "edge yields",
        ),
    ],
)
def test_first_yield_is_refused_with_its_reason(contact, error, words):
    with pytest.raises(error, match=words):
        mdr.first_yield(contact, strength="1 GPa")
    with pytest.raises(mdr.ProblemError, match="above 0 Pa"):
        mdr.first_yield(contact, strength=0.0)


def test_the_figure_of_a_singular_edge_resolves_the_rest():
    result = mdr.solve(mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), mdr.indent("1 um"))
    figure = result.plot_stress()
    assert figure.axes[1].get_ylim()[1] < 1e4
    assert np.isinf(result.field("tresca", ["1 mm"], z=[0.0])).all()


def test_first_yield_from_the_shell(tmp_path, shell):
    case = tmp_path / "ball.toml"
    case.write_text(BALL_CASE)
    status, out, _ = shell("yield", case, "--strength", "1 GPa", "-o", tmp_path / "out")
    assert status == 0
    assert "von Mises" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["yield.csv", "yield.png"]
    assert shell("yield", case, "--strength", "1 GPa", "--side", "counterbody")[0] != 0
    assert shell("yield", case, "--strength", "1 mm")[0] != 0


def test_an_elastic_body_on_one_that_is_not_isotropic():
    zinc = mdr.TransverselyIsotropic(
        c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa"
    )
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), zinc, STEEL), mdr.load("50 N"))
    # the pressure is Hertz's
    peak = float(result["peak_pressure"][0])
    steel = result.largest("tresca", 0, side="counterbody")
    assert float(steel) == pytest.approx(2.0 * 0.3100205019545214 * peak, rel=1e-8)
    below = float(result.field("stress", [0.0], z=[1e-4], side="body").sel(component="zz")[0, 0])
    assert -peak < below < 0.0
