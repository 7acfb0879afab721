"""Rolling with creep: against closed forms, marches of springs, limits, Kalker's coefficients and refusals."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import gamma, struve

import pymdr as mdr
from common import REFERENCES, STEEL
from drawing import examples
from pymdr.interpretation.rolling import kalker_coefficient
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.line.rolling import line_load, march, rolled_path, rolling_line, steady_rolling

ROLLING = [entry for entry in REFERENCES if entry["topic"] == "6 rolling"]
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
ZINC = mdr.TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")


def pressed(profile, depth):
    line = ElasticLine(mdr.equivalent_profile(profile), 1.0)
    return rolling_line(line, states_at_depth(line, [depth]))


def marched(g, depth, radius, rise, n=50_001):
    """One spring on its way through the contact, over mu E*: the whole load and the length that slips."""
    t = np.linspace(0.0, 2.0 * radius, n)
    cap = np.maximum(depth - g(np.abs(radius - t)), 0.0)
    q, spring_length = 0.0, t[1]
    loads = [0.0]
    for limit in cap[1:].tolist():
        q = min(q + rise * spring_length, limit)
        loads.append(q)
    return np.trapezoid(loads, t), np.trapezoid(cap, t)


def _power_image(n, c):
    factor = c * math.sqrt(math.pi) * n / 2.0 * gamma(n / 2.0) / gamma((n + 1.0) / 2.0)
    return lambda x: factor * x**n


def _wavy(radius, height, k):
    return lambda x: x * x / radius + 0.5 * math.pi * height * k * x * struve(0, k * x)


WAVY = mdr.Function(
    lambda r: r**2 / 2 + 0.003 * (1 - np.cos(20 * r)), derivative=lambda r: r + 0.06 * np.sin(20 * r)
)
SHAPES = {
    "paraboloid": (mdr.Paraboloid(1.0), lambda x: x * x, 0.04),
    "sphere": (mdr.Sphere(1.0), lambda x: x * np.arctanh(x), 0.3),
    "cone": (mdr.Cone(slope=0.1), lambda x: 0.05 * math.pi * x, 0.02),
    "cusp": (mdr.PowerLaw(0.6, 0.02, 1.0), _power_image(0.6, 0.02), 0.01),
    "quartic": (mdr.PowerLaw(4.0, 0.1, 1.0), _power_image(4.0, 0.1), 0.02),
    "punch": (mdr.FlatPunch(0.5), lambda x: 0.0 * x, 0.01),
    # g' falls and rises: springs slip, stick and slip again
    "wavy": (WAVY, _wavy(1.0, 0.003, 20.0), 0.05),
}


@pytest.mark.parametrize("fraction", [1e-3, 0.2, 0.5, 0.8, 0.97])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_march_of_springs_through_any_profile(shape, fraction):
    profile, g, depth = SHAPES[shape]
    line = pressed(profile, depth)
    steepest = line.saturation if math.isfinite(line.saturation) else depth / line.radius
    result = steady_rolling(line, np.array([fraction * steepest]))
    load, whole = marched(g, depth, line.radius, fraction * steepest)
    assert line.whole == pytest.approx(whole, rel=1e-6)
    assert result.load[0] == pytest.approx(load, rel=1e-6)


def test_springs_stick_again_where_the_cap_rises_faster():
    line = pressed(WAVY, 0.05)
    # between the least and the largest slope of the front half
    slope = line.line.equivalent.slope(np.linspace(0.4, 1.0, 60)[:-1] * line.radius)
    rise = 0.5 * (slope.min() + slope.max())
    x = np.linspace(-line.radius, line.radius, 4001)[1:-1]
    slips = line_load(line, np.array([rise]), x)[0] >= line.cap(x) * (1.0 - 1e-12)
    assert np.count_nonzero(np.diff(slips.astype(int))) >= 3
    lengths = steady_rolling(line, np.array([rise])).slip_length[0]
    assert lengths == pytest.approx(2.0 * line.radius * slips.mean(), abs=4.0 * (x[1] - x[0]))


def test_springs_carry_the_load_along_the_line():
    line = pressed(mdr.Paraboloid(1.0), 0.25)
    x = np.linspace(-line.radius, line.radius, 100_001)
    q = line_load(line, np.array([0.6]), x)[0]
    assert q[-1] == 0.0
    assert np.all(q <= line.cap(x))
    load = float(steady_rolling(line, np.array([0.6])).load[0])
    assert np.trapezoid(q, x) == pytest.approx(load, rel=1e-9)
    assert load / line.whole == pytest.approx(1.0 - 0.4**3, rel=1e-13)


@settings(max_examples=examples(60), deadline=None)
@given(
    st.floats(-9, 3),
    st.floats(3, 12),
    st.floats(-0.9, 0.5),
    st.floats(0.01, 1.5),
    st.floats(-5, -1.5),
    st.lists(st.floats(-12, 0.5), min_size=1, max_size=5),
)
def test_the_paraboloid_is_the_cubic_at_any_size(log_radius, log_modulus, poisson, mu, log_fraction, log_xi):
    R, body = 10.0**log_radius, mdr.Elastic(10.0**log_modulus, poisson)
    contact = mdr.Contact(mdr.Paraboloid(R), body, body, friction=mdr.Coulomb(mu))
    moduli = mdr.effective_moduli(body, body)
    a = 10.0**log_fraction * R
    unit = 2.0 * a * mu * moduli.normal / (moduli.tangential * R)
    xi = 10.0 ** np.array(log_xi)
    result = mdr.rolling(contact, xi * unit, indentation=a * a / R)
    stuck = np.maximum(1.0 - xi, 0.0)
    expected = np.where(xi < 1.0, -np.expm1(3.0 * np.log1p(-np.minimum(xi, 1.0 - 1e-16))), 1.0)
    load = 4.0 / 3.0 * moduli.normal * a**3 / R
    assert result["creep_force"].values == pytest.approx(mu * load * expected, rel=1e-12)
    assert result["traction_coefficient"].values == pytest.approx(mu * expected, rel=1e-12)
    assert result["slip_length"].values / (2.0 * a) == pytest.approx(1.0 - stuck, abs=1e-12)
    assert float(result["saturation_creepage"]) == pytest.approx(unit, rel=1e-12)


_PROFILES = st.one_of(
    st.builds(lambda n: mdr.PowerLaw(n, 0.05, 1.0), st.floats(0.3, 8.0)),
    st.builds(lambda s: mdr.RoundedCone(slope=s, tip_radius=1.0), st.floats(0.02, 0.3)),
    st.builds(lambda s: mdr.Hyperboloid(slope=s, tip_radius=0.1), st.floats(0.02, 0.3)),
    st.builds(lambda n: mdr.PowerLaw(n, 0.01, 1.0) + mdr.Paraboloid(2.0), st.floats(0.4, 6.0)),
    st.builds(lambda b: mdr.TruncatedParaboloid(1.0, b), st.floats(0.02, 0.2)),
    st.just(mdr.Sphere(1.0)),
)


@settings(max_examples=examples(30), deadline=None)
@given(_PROFILES, st.floats(0.001, 0.1), st.lists(st.floats(1e-6, 0.3), min_size=2, max_size=5))
def test_any_profile_rolls_between_its_limits(profile, depth, creepages):
    body = mdr.Elastic(1e9, 0.3)
    contact = mdr.Contact(profile, body, body, friction=mdr.Coulomb(0.4))
    zeta = np.sort(np.concatenate([creepages, [1e-9, 2.0]]))
    both = mdr.rolling(contact, np.concatenate([-zeta[::-1], [0.0], zeta]), indentation=depth)
    force = both["creep_force"].values
    limit = 0.4 * both.data.attrs["normal_force"]
    assert np.array_equal(force, -force[::-1])
    assert np.all(np.diff(force) >= -1e-12 * limit)
    assert np.all(np.abs(force) <= limit * (1.0 + 1e-12))
    a = both.data.attrs["contact_radius"]
    stuck = 2.0 * mdr.effective_moduli(body, body).tangential * a * a
    # friction takes from it at most what slips
    slips = both["slip_length"].values[zeta.size + 1 :] / (2.0 * a)
    fraction = force[zeta.size + 1 :] / (stuck * zeta)
    assert np.all(fraction <= 1.0 + 1e-12)
    assert np.all(fraction >= (1.0 - slips) ** 2 - 1e-12)
    # the least of what lies before, from the map's own g
    line = pressed(profile, depth)
    t = np.linspace(0.0, 2.0 * a, 20_001)
    cap = line.cap(a - t)
    moduli = mdr.effective_moduli(body, body)
    for one, result in zip(zeta, force[zeta.size + 1 :], strict=True):
        rise = moduli.tangential * one / (0.4 * moduli.normal)
        q = np.minimum(np.minimum.accumulate(cap - rise * t), 0.0) + rise * t
        assert result == pytest.approx(0.4 * moduli.normal * np.trapezoid(q, t), rel=1e-4)
    saturation = float(both["saturation_creepage"])
    if saturation < 2.0:
        most = mdr.rolling(contact, saturation, indentation=depth)["creep_force"]
        assert float(most[0]) == pytest.approx(limit, rel=1e-12)


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-8, 3), st.sampled_from(sorted(SHAPES)), st.floats(1e-3, 0.99))
def test_the_size_of_a_contact_does_not_matter(log_size, shape, fraction):
    size = 10.0**log_size
    scaled = {
        "paraboloid": lambda s: mdr.Paraboloid(s),
        "sphere": lambda s: mdr.Sphere(s),
        "cone": lambda s: mdr.Cone(slope=0.1),
        "cusp": lambda s: mdr.PowerLaw(0.6, 0.02 * s, s),
        "quartic": lambda s: mdr.PowerLaw(4.0, 0.1 * s, s),
        "punch": lambda s: mdr.FlatPunch(0.5 * s),
        "wavy": lambda s: mdr.Function(
            lambda r: s * WAVY.f(r / s), derivative=lambda r: WAVY.derivative(r / s)
        ),
    }[shape]
    _, _, depth = SHAPES[shape]
    one, other = pressed(scaled(1.0), depth), pressed(scaled(size), depth * size)
    rise = np.array([fraction * (one.saturation if math.isfinite(one.saturation) else depth / one.radius)])
    here, there = steady_rolling(one, rise), steady_rolling(other, rise)
    assert there.load / size**2 == pytest.approx(here.load, rel=1e-10)
    assert there.slip_length / size == pytest.approx(here.slip_length, rel=1e-8, abs=1e-8 * one.radius)


def rolled_by_hand(g, depth, radius, legs, n=600, m=500):
    """Springs that end at n places, each followed back to where it was and carried along in m steps per leg."""
    t = np.linspace(0.0, 2.0 * radius, n + 1)
    total = sum(length for length, _ in legs)
    q, before = np.zeros(t.size), 0.0
    for length, rise in legs:
        step = length / m
        for i in range(m):
            place = t - total + before + (i + 1) * step
            fresh = np.clip(place, 0.0, step)
            cap = np.maximum(depth - g(np.abs(radius - np.clip(place, 0.0, 2.0 * radius))), 0.0)
            q = np.where(place > 0.0, np.clip(q + rise * fresh, -cap, cap), 0.0)
        before += length
    return np.trapezoid(q, t)


@pytest.mark.parametrize("shape", ["paraboloid", "sphere", "cone", "quartic"])
def test_a_path_of_creepages_against_springs_followed_one_by_one(shape):
    profile, g, depth = SHAPES[shape]
    line = pressed(profile, depth)
    a, unit = line.radius, 0.5 * depth / line.radius
    legs = [(0.3 * a, unit), (0.85 * a, -0.7 * unit), (0.5 * a, 1.8 * unit), (0.2 * a, 0.0)]
    lengths, rises = map(np.array, zip(*legs, strict=True))
    computed = rolled_path(line, np.cumsum(lengths), rises)
    assert computed.error <= 1e-6
    for i in (0, 1, 3):
        expected = rolled_by_hand(g, depth, a, legs[: i + 1])
        assert computed.load[i] / line.whole == pytest.approx(expected / line.whole, abs=3e-5)


def test_the_march_converges_with_the_square_of_the_spacing():
    line = pressed(mdr.Paraboloid(1.0), 0.25)
    rise = np.array([0.4, 0.4, 0.4, 0.4, 0.4])
    distance = 0.25 * np.arange(1.0, 6.0)
    exact = 0.784 * line.whole
    errors = [abs(march(line, distance, rise, n)[-1] - exact) for n in (128, 256, 512, 1024)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    # the place where slip begins lies anywhere between two springs
    assert np.log2(errors[0] / errors[-1]) / 3.0 == pytest.approx(2.0, abs=0.25)
    assert np.all(orders > 1.0)


@settings(max_examples=examples(15), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.01, 1.5), st.floats(-2.0, 2.0)), min_size=1, max_size=4),
    st.floats(0.05, 1.5),
)
def test_any_path_forgets_what_was_before(history, fraction):
    line = pressed(mdr.Paraboloid(1.0), 0.25)
    lengths = np.array([length for length, _ in history] + [0.4, 0.7])
    rises = np.array([rise for _, rise in history] + [fraction, fraction])
    result = rolled_path(line, np.cumsum(lengths), rises)
    steady = steady_rolling(line, np.array([fraction])).load[0]
    assert result.load[-1] / line.whole == pytest.approx(steady / line.whole, abs=2e-6)
    assert np.all(np.abs(result.load) <= line.whole * (1.0 + 1e-9))


def test_a_path_through_the_public_door():
    a = mdr.rolling(BALL, 0.0, normal_force="100 N").data.attrs["contact_radius"]
    along = mdr.rolling(BALL, [1e-3, 1e-3, -1e-3], normal_force="100 N", path=[a / 100, 3 * a, 9 * a])
    steady = float(mdr.rolling(BALL, 1e-3, normal_force="100 N")["creep_force"][0])
    force = along["creep_force"].values
    assert force[1:] == pytest.approx([steady, -steady], rel=1e-12)
    # a short way shears all springs alike
    G = mdr.effective_moduli(STEEL, STEEL).tangential
    assert force[0] == pytest.approx(2 * a * G * 1e-3 * a / 100, rel=0.02)
    assert along["creepage"].dims == ("distance",)
    assert "has an error of" in along.notes[-1]
    assert along.springs is None
    assert len(along.plot().axes) == 2
    with pytest.raises(mdr.QuantityError, match="no quantity"):
        along["slip_length"]


@pytest.mark.parametrize("entry", [e for e in ROLLING if "nu" in e["inputs"]], ids=lambda e: e["id"])
def test_kalkers_coefficients(entry):
    nu, expected = entry["inputs"]["nu"], entry["expected"]
    body = mdr.Elastic(1e9, nu)
    contact = mdr.Contact(mdr.Paraboloid(1.0), body, body, friction=mdr.Coulomb(0.3))
    slopes = {}
    for law in ("plain", "calibrated"):
        for direction in ("longitudinal", "lateral"):
            result = mdr.rolling(contact, 1e-12, indentation=1e-4, law=law, direction=direction)
            a = result.data.attrs["contact_radius"]
            slopes[law, direction] = float(result["creep_force"][0]) / (body.shear * a * a * 1e-12)
    assert slopes["plain", "longitudinal"] == pytest.approx(expected["C_MDR"], rel=1e-8)
    assert slopes["plain", "lateral"] == slopes["plain", "longitudinal"]
    for i, direction in enumerate(("longitudinal", "lateral")):
        c = slopes["calibrated", direction]
        assert c == pytest.approx(expected[("C11_num", "C22_num")[i]], rel=entry["rtol"])
        if expected["kalker_table"]:
            assert c == pytest.approx(expected["kalker_table"][i], rel=1e-8)
        reason = mdr.rolling(contact, 1e-3, indentation=1e-4, direction=direction).claims["creep_force"]
        assert f"{100 * (1 - slopes['plain', direction] / c):.0f} % here" in reason.reason
        assert 0.3299 < 1 - slopes["plain", direction] / c < 0.4901


def test_the_law_of_the_book():
    (entry,) = [e for e in ROLLING if "xi" in e["inputs"]]
    saturation = float(mdr.rolling(BALL, 0.0, indentation="1 um")["saturation_creepage"])
    result = mdr.rolling(BALL, entry["inputs"]["xi"] * saturation, indentation="1 um")
    a, load = (result.data.attrs[name] for name in ("contact_radius", "normal_force"))
    assert float(result["creep_force"][0]) / (0.3 * load) == pytest.approx(
        entry["expected"]["F_over_muF"], rel=1e-12
    )
    assert 1 - float(result["slip_length"][0]) / (2 * a) == pytest.approx(
        entry["expected"]["stick_fraction"], rel=1e-12
    )


@settings(max_examples=examples(40), deadline=None)
@given(st.floats(0.0, 0.5), st.floats(0.05, 1.0), st.floats(-4, 0.2), st.sampled_from([0, 1]))
def test_the_calibrated_law_is_that_of_shen_hedrick_and_elkins(nu, mu, log_xi, which):
    direction = ("longitudinal", "lateral")[which]
    body = mdr.Elastic("70 GPa", nu)
    contact = mdr.Contact(mdr.Paraboloid("20 mm"), body, body, friction=mdr.Coulomb(mu))
    load = 200.0
    a = (3 * load * 0.02 / (4 * mdr.effective_moduli(body, body).normal)) ** (1 / 3)
    # the table by Lagrange's polynomials
    table = ((3.40, 4.12, 5.20), (3.40, 3.67, 3.98))[which]
    c = (
        table[0] * (nu - 0.25) * (nu - 0.5) / 0.125
        - table[1] * nu * (nu - 0.5) / 0.0625
        + table[2] * nu * (nu - 0.25) / 0.125
    )
    assert kalker_coefficient(nu, direction) == pytest.approx(c, rel=1e-13)
    xi = 10.0**log_xi
    zeta = xi * 3 * mu * load / (c * body.shear * a * a)
    result = mdr.rolling(contact, zeta, normal_force=load, law="calibrated", direction=direction)
    expected = mu * load * (1 - max(1 - xi, 0.0) ** 3)
    assert float(result["creep_force"][0]) == pytest.approx(expected, rel=1e-9)


def test_pairs_as_kalker_defines_them():
    # 1/G = (1/G1 + 1/G2)/2; an incompressible body on a rigid one is as the pair of twice its shear modulus
    rubber = mdr.Elastic("3 MPa", 0.5)
    on_rigid = mdr.Contact(mdr.Paraboloid("10 mm"), rubber, friction=mdr.Coulomb(0.5))
    twice = mdr.Elastic("6 MPa", 0.5)
    pair = mdr.Contact(mdr.Paraboloid("10 mm"), twice, twice, friction=mdr.Coulomb(0.5))
    results = [
        mdr.rolling(contact, [1e-3, 1e-2], indentation="0.1 mm", law="calibrated")["creep_force"].values
        for contact in (on_rigid, pair)
    ]
    assert results[0] == pytest.approx(results[1], rel=1e-13)


def test_what_is_claimed():
    plain = mdr.rolling(BALL, [1e-3], normal_force="100 N")
    calibrated = mdr.rolling(BALL, [1e-3], normal_force="100 N", law="calibrated")
    assert {c.level for c in plain.claims.values()} == {mdr.Level.APPROXIMATE, mdr.Level.NOT_VALID}
    assert "33 to 49 % below" in plain.claims["creep_force"].reason
    assert "0.04 mu F_N" in calibrated.claims["creep_force"].reason
    lateral = mdr.rolling(BALL, [1e-3], normal_force="100 N", law="calibrated", direction="lateral")
    assert np.all(lateral.claims["creep_force"].error < plain.claims["creep_force"].error)
    for name in ("shear_traction", "slip"):
        with pytest.raises(mdr.NotValidError, match="along one line"):
            plain[name]
    cone = mdr.Contact(mdr.Cone(slope=0.1), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    assert "only for round tips" in mdr.rolling(cone, 1e-3, normal_force="1 N").claims["creep_force"].reason
    zinc = mdr.Contact(mdr.Paraboloid("10 mm"), ZINC, ZINC, friction=mdr.Coulomb(0.3))
    assert "is unknown" in mdr.rolling(zinc, 1e-3, normal_force="1 N").claims["creep_force"].reason
    foam = mdr.Elastic("1 MPa", -0.3)
    auxetic = mdr.Contact(mdr.Paraboloid("10 mm"), foam, foam, friction=mdr.Coulomb(0.3))
    assert "is unknown" in mdr.rolling(auxetic, 1e-3, normal_force="1 mN").claims["creep_force"].reason
    unlike = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, friction=mdr.Coulomb(0.3))
    result = mdr.rolling(unlike, 1e-3, normal_force="1 N")
    assert "Dundurs" in result.claims["creep_force"].reason
    assert "NOT MET" in str(result)


def test_how_it_reads():
    study = mdr.rolling(BALL, [-1e-3, 1e-3, 4e-3], normal_force="100 N")
    lines = str(study).splitlines()
    assert lines[0].split() == ["creepage", "force", "F_x/F_N", "slip"]
    assert "all springs slip from a creepage of 0.0136 on" in lines[5]
    assert "<table>" in study._repr_html_()
    assert study.curves["law"].values.tolist() == ["plain", "calibrated"]
    left, right = study.plot().axes
    assert len(left.lines) == 4
    assert len(right.lines) == 5
    again = pickle.loads(pickle.dumps(study))
    assert again.data.identical(study.data)
    sampled = mdr.Sampled(
        np.linspace(0, 1e-3, 40), np.linspace(0, 1e-3, 40) ** 2 / 0.02, scatter=np.full(40, 1e-9)
    )
    noted = mdr.rolling(
        mdr.Contact(sampled, STEEL, STEEL, friction=mdr.Coulomb(0.3)), 1e-3, normal_force="10 N"
    )
    assert "there are no bands" in noted.notes[-1]
    assert noted.curves["law"].values.tolist() == ["plain"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"creepage": []}, "one row"),
        ({"creepage": [[1e-3]]}, "one row"),
        ({"creepage": [math.nan]}, "finite"),
        ({"creepage": 3.0}, "limit 2"),
        ({"creepage": "1 mm"}, "creepage"),
        ({"indentation": "1 um"}, "exactly one"),
        ({"normal_force": None}, "exactly one"),
        ({"normal_force": "0 N"}, "above 0 N"),
        ({"direction": "spin"}, "have no spin"),
        ({"direction": "up"}, "'longitudinal' or 'lateral'"),
        ({"law": "carter"}, "'plain' or 'calibrated'"),
        ({"path": ["1 mm", "2 mm"]}, "one distance for every creepage"),
        ({"creepage": [1e-3, 2e-3], "path": ["2 mm", "1 mm"]}, "does not increase"),
        ({"path": "0 m"}, "does not increase"),
        ({"path": "1 mm", "law": "calibrated"}, "steady rolling"),
    ],
)
def test_bad_questions(arguments, message):
    question = {"creepage": 1e-3, "normal_force": "100 N"} | arguments
    with pytest.raises(mdr.PymdrError, match=message):
        mdr.rolling(BALL, **question)


@pytest.mark.parametrize(
    ("contact", "law", "message"),
    [
        (mdr.Contact(BALL.profile, STEEL, STEEL), "plain", "no friction"),
        (mdr.Contact(BALL.profile, STEEL, STEEL, adhesion=mdr.JKR("1 mJ/m^2")), "plain", "no friction"),
        (mdr.Contact(BALL.profile, STEEL, STEEL, friction=mdr.Coulomb(0.0)), "plain", "no creep force"),
        (mdr.Contact(BALL.profile, STEEL, STEEL, friction=mdr.Coulomb(math.inf)), "plain", "finite"),
        (mdr.Contact(BALL.profile, STEEL, friction=mdr.Coulomb(0.3)), "calibrated", "similar"),
        (
            mdr.Contact(mdr.Cone(slope=0.1), STEEL, STEEL, friction=mdr.Coulomb(0.3)),
            "calibrated",
            "round tip",
        ),
        (mdr.Contact(BALL.profile, ZINC, ZINC, friction=mdr.Coulomb(0.3)), "calibrated", "isotropic"),
        (
            mdr.Contact(
                BALL.profile,
                mdr.Elastic("1 MPa", -0.3),
                mdr.Elastic("1 MPa", -0.3),
                friction=mdr.Coulomb(0.3),
            ),
            "calibrated",
            "0 to 0.5",
        ),
        (3, "plain", "not a Contact"),
    ],
)
def test_contacts_that_do_not_roll(contact, law, message):
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.rolling(contact, 1e-3, normal_force="1 mN", law=law)


def test_a_ring_is_refused():
    rings = mdr.Function(lambda r: r**2 / 2 + 0.05 * (1 - np.cos(20 * r)))
    contact = mdr.Contact(rings, STEEL, STEEL, friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.ProblemError, match="disk"):
        mdr.rolling(contact, 1e-3, indentation=0.2)
