"""Maps, states and fields of the normal contact against references, closed forms, limits and scalings."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import beta, struve

import pymdr as mdr
from common import UNIT
from drawing import examples
from pymdr.interpretation.fields import gap, normal_displacement, pressure
from pymdr.line.foundation import (
    ElasticLine,
    disk_states,
    elastic_energy,
    normal_force,
    spring_foundation,
    states_at_depth,
    states_at_force,
)
from pymdr.mapping import abel
from pymdr.mapping.equivalent import equivalent_profile, gap_function

TAN, B = math.tan(0.7), 0.4
PROFILES = {
    "cone": mdr.Cone(slope=TAN),
    "paraboloid": mdr.Paraboloid(1.0),
    "sphere": mdr.Sphere(1.0),
    "power_0.5": mdr.PowerLaw(0.5, 1.0, 1.0),
    "power_3": mdr.PowerLaw(3, 1.0, 1.0),
    "power_4": mdr.PowerLaw(4, 1.0, 1.0),
    "trunc_cone": mdr.Function(
        lambda r: TAN * np.maximum(r - B, 0.0), [B], lambda r: np.where(r > B, TAN, 0.0)
    ),
    "rounded_cylinder": mdr.Function(
        lambda r: np.maximum(r - B, 0.0) ** 2 / 2, [B], lambda r: np.maximum(r - B, 0.0)
    ),
    "wavy_paraboloid": mdr.Function(
        lambda r: r * r / 2 + 0.01 * (1 - np.cos(6 * r)), derivative=lambda r: r + 0.06 * np.sin(6 * r)
    ),
}


def line_of(profile, modulus=1.0):
    return ElasticLine(equivalent_profile(profile), modulus)


@pytest.mark.parametrize("name", PROFILES)
def test_maps_of_the_references(references, name):
    reference = references[f"map_{name}"]
    x = reference["inputs"]["x"]
    line = equivalent_profile(PROFILES[name])
    assert float(PROFILES[name].gap(x)) == pytest.approx(reference["expected"]["f"], rel=1e-12)
    assert float(line.g(x)) == pytest.approx(reference["expected"]["g"], rel=1e-12)
    assert float(line.slope(x)) == pytest.approx(reference["expected"]["gprime"], rel=1e-12)


# The reference's pressure of the truncated cone at r = 0.2 is good to 8e-12 only: the value here is the same
# integral by 80 Gauss nodes in extended precision.
TRUNCATED_CONE_PRESSURE = 0.336572470243903 * (1 + 7.4963680e-12)


@pytest.mark.parametrize(
    "name", ["cone", "paraboloid", "sphere", "trunc_cone", "rounded_cylinder", "wavy_paraboloid"]
)
def test_contacts_of_the_references(references, name):
    expected = references[f"normal_{name}"]["expected"]
    a, d = references[f"normal_{name}"]["inputs"]["a"], expected["d"]
    line = line_of(PROFILES[name])
    states = states_at_depth(line, np.array([d]))
    assert states.contact_radius[0] == pytest.approx(a, rel=1e-12)
    assert normal_force(line, states)[0] == pytest.approx(expected["F_over_Estar"], rel=1e-12)
    assert elastic_energy(line, states)[0] == pytest.approx(expected["U_over_Estar"], rel=1e-12)
    p = pressure(line, a, 0.0, [0.2, 0.5])
    inner = TRUNCATED_CONE_PRESSURE if name == "trunc_cone" else expected["p02_over_Estar"]
    assert p.tolist() == pytest.approx([inner, expected["p05_over_Estar"]], rel=1e-12)
    f = gap_function(PROFILES[name], line.equivalent)
    assert normal_displacement(line, f, d, a, 0.0, [0.8])[0] == pytest.approx(expected["u_r08"], rel=1e-12)
    back = states_at_force(line, normal_force(line, states))
    assert back.contact_radius[0] == pytest.approx(a, rel=1e-12)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 4.0])
def test_power_law_forces_of_the_references(references, n):
    reference = references[f"power_force_{n:g}"]
    result = mdr.solve(mdr.Contact(mdr.PowerLaw(n, 1.0, 1.0), UNIT), mdr.indent(reference["inputs"]["d"]))
    assert float(result["normal_force"][-1]) == pytest.approx(reference["expected"]["F"], rel=1e-12)
    assert float(result["contact_radius"][-1]) == pytest.approx(reference["expected"]["a"], rel=1e-12)


@pytest.mark.parametrize("n", [0.5, 1, 2, 3, 10])
def test_power_factor_of_the_references(references, n):
    line = equivalent_profile(mdr.PowerLaw(n, 1.0, 1.0))
    assert float(line.g(1.0)) == pytest.approx(references[f"kappa_{n}"]["expected"]["kappa"], rel=1e-12)


def test_moduli_of_the_reference(references):
    reference = references["moduli_steel_alu"]
    i, e = reference["inputs"], reference["expected"]
    moduli = mdr.effective_moduli(mdr.Elastic(i["E1"], i["nu1"]), mdr.Elastic(i["E2"], i["nu2"]))
    assert moduli.normal == pytest.approx(e["E_star"], rel=1e-12)
    assert moduli.tangential == pytest.approx(e["G_star"], rel=1e-12)
    assert moduli.dundurs_beta == pytest.approx(e["dundurs_beta"], rel=1e-12)


def test_similar_bodies():
    steel = mdr.Elastic("210 GPa", 0.3)
    assert mdr.effective_moduli(steel, steel).similar
    assert mdr.effective_moduli(mdr.Elastic("1 MPa", 0.5)).similar
    assert not mdr.effective_moduli(steel).similar


SMOOTH = {
    "sphere": (
        lambda r: r / np.sqrt((1 - r) * (1 + r)),
        lambda r: r * r / (1 + np.sqrt((1 - r) * (1 + r))),
        lambda x: x * np.arctanh(x),
    ),
    "hyperboloid": (
        lambda r: r / np.hypot(r, 0.3),
        lambda r: r * r / (np.hypot(r, 0.3) + 0.3),
        lambda x: x * np.arctan(x / 0.3),
    ),
    "wavy": (
        lambda r: r + 0.06 * np.sin(6 * r),
        lambda r: r * r / 2 + 0.02 * np.sin(3 * r) ** 2,
        lambda x: x * x + np.pi / 2 * 0.06 * x * struve(0, 6 * x),
    ),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_callables(name):
    slope, f, g = SMOOTH[name]
    x = np.geomspace(1e-6, 0.9, 300)
    with_slope = equivalent_profile(mdr.Function(derivative=slope)).g(x)
    assert np.max(np.abs(with_slope / g(x) - 1)) < 1e-13
    alone = equivalent_profile(mdr.Function(f)).g(x)
    assert np.max(np.abs(alone / g(x) - 1)) < 1e-12


@pytest.mark.parametrize("name", SMOOTH)
def test_inverse_map(name):
    _, f, g = SMOOTH[name]
    r = np.linspace(0.0, 0.8, 41)
    assert np.max(np.abs(abel.inverse(g, r) - f(r))) < 1e-13 * f(r[-1])


@pytest.mark.parametrize("k", [-0.5, -0.2, 0.3, 0.7])
def test_kernel_exponent(k):
    n, x = 2.5, np.geomspace(1e-9, 10.0, 40)
    factor = n / 2 * beta(n / 2, (1 + k) / 2)
    assert np.max(np.abs(abel.forward(lambda r: n * r ** (n - 1), x, k=k) / (factor * x**n) - 1)) < 2e-13
    assert np.max(np.abs(abel.inverse(lambda t: factor * t**n, x, k=k) / x**n - 1)) < 2e-13


@pytest.mark.parametrize("n", [0.3, 0.5, 1.3])
def test_tips_that_are_not_smooth(n):
    x = np.geomspace(1e-6, 1.0, 50)
    exact = equivalent_profile(mdr.PowerLaw(n, 1.0, 1.0)).g(x)
    mapped = equivalent_profile(mdr.Function(derivative=lambda r: n * r ** (n - 1))).g(x)
    assert np.max(np.abs(mapped / exact - 1)) < 1e-12


def test_sphere_from_tiny_to_almost_full_radius():
    t = np.concatenate([np.geomspace(1e-9, 0.5, 80), np.linspace(0.5, 0.99, 50)])
    line = ElasticLine(equivalent_profile(mdr.Sphere(2.0)), 3.0)
    d = line.equivalent.g(2.0 * t)
    states = states_at_depth(line, d)
    assert np.max(np.abs(states.contact_radius / (2 * t) - 1)) < 1e-12
    # F = 2 E* int x g' dx with an independent quadrature in extended precision
    nodes, weights = np.polynomial.legendre.leggauss(120)
    s = (nodes.astype(np.longdouble) + 1) / 2
    top = np.arctanh(t.astype(np.longdouble))[:, None]
    u = top * s
    z = np.tanh(u)  # x = R tanh u; dx = R (1 - z^2) du; g' = u + z / (1 - z^2)
    moment = (top * (weights / 2) * z * (u * (1 - z * z) + z)).sum(axis=1) * 4
    assert np.max(np.abs(normal_force(line, states) / (6 * moment) - 1)) < 1e-12
    assert np.max(np.abs(states_at_force(line, normal_force(line, states)).indentation / d - 1)) < 1e-12


def disk_integral(line, a, excess):
    """2 pi int p r dr with r^2 = a^2 - q^2, by Gauss, split where the profile is not smooth."""
    marks = sorted({0.0, a, *(math.sqrt(a * a - b * b) for b in line.equivalent.breakpoints if b < a)})
    # tanh-sinh: the pressure of sharp tips and corners grows like a logarithm at the ends
    t = np.linspace(-3.2, 3.2, 161)
    s = 1 / (1 + np.exp(-np.pi * np.sinh(t)))
    weights = (t[1] - t[0]) * np.pi * np.cosh(t) * s * (1 - s)
    total = 0.0
    for low, high in pairwise(marks):
        q = low + (high - low) * s
        r = np.sqrt((a - q) * (a + q))
        # the very corner of a truncated cone and the tip of a cone carry no weight
        inside = (r > 0.0) & (~np.isin(r, line.equivalent.breakpoints))
        assert weights[~inside].sum() < 1e-12
        regular = pressure(line, a, 0.0, r[inside])
        total += 2 * math.pi * ((high - low) * weights[inside] * q[inside] * regular).sum()
    # the singular part, w / sqrt(a^2 - r^2) E* / pi, integrates to 2 E* w a
    return total + 2 * line.modulus * excess * a


DISKS = {
    **{k: (p, 0.3) for k, p in PROFILES.items() if k != "power_0.5"},
    "flat_punch": (mdr.FlatPunch(0.7), 0.1),
    "dome_below": (mdr.FlatPunch(0.7) + mdr.Paraboloid(1.0), 0.2),
    "dome_above": (mdr.FlatPunch(0.7) + mdr.Paraboloid(1.0), 0.8),
    "sum": (mdr.Sphere(2.0) + mdr.Cone(slope=0.2) + mdr.PowerLaw(4, 0.1, 1.0), 0.3),
}


@pytest.mark.parametrize("name", DISKS)
def test_pressure_integrates_to_the_force(name):
    profile, d = DISKS[name]
    line = line_of(profile, 2.0)
    states = states_at_depth(line, np.array([d]))
    a, excess = float(states.contact_radius[0]), float(states.edge_excess[0])
    assert disk_integral(line, a, excess) == pytest.approx(normal_force(line, states)[0], rel=1e-10)


@pytest.mark.parametrize("name", DISKS)
def test_energy_and_stiffness_are_derivatives(name):
    profile, d = DISKS[name]
    line = line_of(profile, 2.0)
    depths = d * (1 + 1e-3 * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
    states = states_at_depth(line, depths)
    force, energy = normal_force(line, states), elastic_energy(line, states)
    slope = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12e-3 * d)
    assert energy @ slope == pytest.approx(force[2], rel=1e-8)
    if name not in ("trunc_cone",):
        assert force @ slope == pytest.approx(2 * 2.0 * states.contact_radius[2], rel=1e-7)


@pytest.mark.parametrize("name", DISKS)
def test_displacement_gap_and_profile_agree(name):
    profile, d = DISKS[name]
    line = line_of(profile)
    state = states_at_depth(line, np.array([d]))
    a, excess = float(state.contact_radius[0]), float(state.edge_excess[0])
    f = gap_function(profile, line.equivalent)
    r = np.linspace(0.0, 0.999, 21) * a
    assert np.max(np.abs(normal_displacement(line, f, d, a, excess, r) - (d - f(r)))) == 0.0
    outside = a * np.array([1.0001, 1.1, 1.3])
    u = normal_displacement(line, f, d, a, excess, outside)
    h = gap(line, f, d, a, excess, outside)
    assert np.all(np.diff(u) < 0)
    assert np.all(h > 0)
    finite = np.isfinite(h)
    assert h[finite] == pytest.approx(f(outside[finite]) - d + u[finite], rel=1e-9, abs=1e-12 * d)


def test_cone_pressure_is_logarithmic():
    line = line_of(mdr.Cone(slope=0.3))
    r = np.array([1e-9, 0.1, 0.5, 1 - 1e-9])
    exact = 0.3 / 2 * np.arccosh(1 / r)
    assert pressure(line, 1.0, 0.0, r)[:3] == pytest.approx(exact[:3], rel=1e-13)
    assert pressure(line, 1.0, 0.0, r)[3] == pytest.approx(0.15 * math.sqrt(2e-9), rel=1e-6)
    assert math.isinf(pressure(line, 1.0, 0.0, 0.0))


def test_flat_punch_edge():
    result = mdr.solve(mdr.Contact(mdr.FlatPunch(2.0), mdr.Elastic(3.0, 0.0)), mdr.load(12.0, steps=2))
    assert result["indentation"].values.tolist() == pytest.approx([0.5, 1.0], rel=1e-14)
    p = result.field("pressure", r=[0.0, 1.0, 2.0, 2.1])
    exact = 3.0 / (math.pi * np.sqrt(4.0 - np.array([0.0, 1.0]) ** 2))
    assert p.values[:2] == pytest.approx(exact, rel=1e-14)
    assert p.values[2:].tolist() == [math.inf, 0.0]
    assert float(p["edge_amplitude"]) == pytest.approx(3.0 / (2 * math.pi), rel=1e-14)
    u = result.field("normal_displacement", r=[3.0, 20.0]).values
    assert u == pytest.approx(2 / math.pi * np.arcsin(2.0 / np.array([3.0, 20.0])), rel=1e-13)


@pytest.mark.parametrize("radius", [1e-9, 1e-3, 1.0, 1e3])
def test_hertz_from_nanometre_to_kilometre(radius):
    d = 1e-3 * radius
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(radius), mdr.Elastic(1e9, 0.0)), mdr.indent(d, steps=3))
    assert float(result["contact_radius"][-1]) / radius == pytest.approx(math.sqrt(1e-3), rel=1e-13)
    force = 4 / 3 * 1e9 * radius**2 * 1e-3**1.5
    assert float(result["normal_force"][-1]) == pytest.approx(force, rel=1e-13)
    p0 = 2 / math.pi * 1e9 * math.sqrt(1e-3)
    assert float(result.field("pressure", r=0.0)[0]) == pytest.approx(p0, rel=1e-13)


@pytest.mark.parametrize("scale", [1e-9, 1e3])
@pytest.mark.parametrize("name", ["sphere", "trunc_cone", "wavy_paraboloid"])
def test_a_rescaled_contact_is_the_same(name, scale):
    def solved(factor):
        base = PROFILES[name]
        profile = (
            mdr.Sphere(factor)
            if name == "sphere"
            else mdr.Function(
                lambda r: factor * base.f(r / factor),
                np.array(base.breakpoints) * factor,
                lambda r: base.derivative(r / factor),
            )
        )
        result = mdr.solve(mdr.Contact(profile, mdr.Elastic(1e6, 0.2)), mdr.indent(0.3 * factor, steps=4))
        return result["contact_radius"].values / factor, result["normal_force"].values / factor**2

    for one, other in zip(solved(1.0), solved(scale), strict=True):
        assert np.max(np.abs(other / one - 1)) < 1e-13


def test_twelve_orders_of_load_in_one_path():
    forces = np.geomspace(1e-9, 1e3, 25)
    for profile in (
        mdr.Sphere(1.0),
        mdr.Cone(slope=0.1),
        mdr.Sphere(1.0) + mdr.Cone(slope=0.01),
        PROFILES["wavy_paraboloid"],
    ):
        contact = mdr.Contact(profile, mdr.Elastic(1e5, 0.5))
        result = mdr.solve(contact, mdr.Path(normal_force=forces))
        assert np.max(np.abs(result["normal_force"].values / forces - 1)) < 1e-12
        again = mdr.solve(contact, mdr.Path(indentation=result["indentation"].values))
        assert np.max(np.abs(again["normal_force"].values / forces - 1)) < 1e-11


def test_springs_converge_to_the_integrals():
    line = ElasticLine(equivalent_profile(mdr.Paraboloid(1.0)), 1.0)
    n = np.array([101, 201, 401, 801, 1601, 3201])
    # half lengths that never fall on a spring's edge
    error = [
        abs(spring_foundation(line, 1.0 / math.sqrt(2), k).normal_force(0.1) / (4 / 3 * 0.1**1.5) - 1)
        for k in n
    ]
    order = -np.polyfit(np.log(n), np.log(error), 1)[0]
    assert order > 1.5
    radius = [abs(spring_foundation(line, 0.7, k).contact_radius(0.1) / math.sqrt(0.1) - 1) for k in n]
    assert all(r < 1.5 * 2 * 0.7 / k / math.sqrt(0.1) for r, k in zip(radius, n, strict=True))


def test_foundation_of_a_contact():
    springs = mdr.foundation(mdr.Contact(mdr.Paraboloid(1.0), UNIT), 1000)
    assert springs.normal_force(0.02) == pytest.approx(4 / 3 * 0.02**1.5, rel=1e-4)
    with pytest.raises(mdr.ProblemError, match="whole number of at least 2"):
        mdr.foundation(mdr.Contact(mdr.Paraboloid(1.0), UNIT), 1)
    with pytest.raises(mdr.ProblemError, match="half_length"):
        mdr.foundation(mdr.Contact(mdr.Cone(slope=1.0), UNIT))


@st.composite
def rising_profiles(draw):
    """Sums of power laws, cones and spheres of very different sizes."""
    size = 10.0 ** draw(st.floats(-9, 1))
    parts = draw(
        st.lists(
            st.one_of(
                st.builds(
                    lambda n, c: mdr.PowerLaw(n, c * size, size), st.floats(0.7, 8), st.floats(0.05, 2)
                ),
                st.builds(lambda c: mdr.Cone(slope=c), st.floats(0.05, 2)),
                st.builds(lambda c: mdr.Sphere(c * size), st.floats(2, 9)),
            ),
            min_size=1,
            max_size=3,
        )
    )
    profile = parts[0]
    for part in parts[1:]:
        profile = profile + part
    return profile, size


@settings(max_examples=examples(40), deadline=None)
@given(rising_profiles(), st.floats(0.01, 0.4))
def test_random_profiles(case, depth):
    profile, size = case
    contact = mdr.Contact(profile, mdr.Elastic(1e6, 0.3))
    result = mdr.solve(contact, mdr.indent(depth * size, steps=8))
    d, a, force = (result[name].values for name in ("indentation", "contact_radius", "normal_force"))
    assert result.status is mdr.Status.COMPLETED
    assert np.all(np.diff(force) > 0)
    line = equivalent_profile(profile)
    assert np.max(np.abs(line.g(a) / d - 1)) < 1e-12
    modulus = mdr.effective_moduli(contact.body).normal
    # F = 2 E* (d a - int_0^a g), the integral by an independent rule on graded panels
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.concatenate([[0.0], 0.25 ** np.arange(24, -1, -1.0)]) * a[-1]
    integral = sum(
        ((high - low) / 2 * weights * line.g(low + (high - low) * (nodes + 1) / 2)).sum()
        for low, high in pairwise(edges)
    )
    assert force[-1] == pytest.approx(2 * modulus * (d[-1] * a[-1] - integral), rel=1e-11)
    back = mdr.solve(contact, mdr.Path(normal_force=force))
    assert np.max(np.abs(back["indentation"].values / d - 1)) < 1e-11
    as_function = mdr.Function(profile.gap, derivative=profile.gap_slope)
    mapped = mdr.solve(mdr.Contact(as_function, contact.body), mdr.indent(depth * size, steps=2))
    assert mapped["normal_force"].values[-1] == pytest.approx(force[-1], rel=1e-11)


def test_disk_states_recover_the_edge_excess():
    line = ElasticLine(equivalent_profile(mdr.FlatPunch(1.0) + mdr.Paraboloid(2.0)), 1.0)
    states = disk_states(line, np.array([0.4, 0.9]), np.array([math.sqrt(0.8), 1.0]))
    assert states.edge_excess.tolist() == pytest.approx([0.0, 0.4], abs=1e-15)
