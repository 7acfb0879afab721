"""Step 3: pressure, displacement and gap."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import UNIT
from drawing import examples
from pymdr.interpretation.fields import edge_amplitude, gap, normal_displacement, pressure
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.line.friction import superposition
from pymdr.mapping.equivalent import equivalent_profile, gap_function

TAN = math.tan(0.7)


def line_of(profile, modulus=1.0):
    return ElasticLine(equivalent_profile(profile), modulus)


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact, dtype=float) - 1)))


RADII = np.concatenate(
    [np.geomspace(1e-9, 0.1, 10), np.linspace(0.2, 0.9, 6), 1 - np.geomspace(1e-12, 0.05, 8)]
)


@pytest.mark.parametrize("a", [1e-9, 1.0, 1e3])
def test_hertz_pressure(a):
    r = a * RADII
    exact = 2 / math.pi * np.sqrt((a - r) * (a + r)) / 5e-3
    assert worst(pressure(line_of(mdr.Paraboloid(5e-3)), a, 0.0, r), exact) < 1e-13


@pytest.mark.parametrize("a", [1e-9, 1.0, 1e3])
def test_cone_pressure(a):
    r = a * RADII
    exact = 0.15 * np.arcsinh(np.sqrt((a - r) * (a + r)) / r)
    assert worst(pressure(line_of(mdr.Cone(slope=0.3)), a, 0.0, r), exact) < 1e-13


def test_fourth_order_pressure():
    # g = 8/3 x^4: (1/pi) int g'/sqrt = (32/3 pi) (r^2 c + c^3/3)
    c = np.sqrt((1 - RADII) * (1 + RADII))
    exact = 32 / (3 * math.pi) * c * (RADII**2 + c**2 / 3)
    assert worst(pressure(line_of(mdr.PowerLaw(4, 1.0, 1.0)), 1.0, 0.0, RADII), exact) < 1e-13


@pytest.mark.parametrize("t", [1e-9, 1e-3, 0.3, 0.9, 0.99])
def test_sphere_pressure(t, closed_forms):
    rho = np.array([1e-6, 0.1, 0.5, 0.9, 0.999, 1 - 1e-9])
    exact = [float(closed_forms.sphere_pressure(t, t * r)) for r in rho]
    assert worst(pressure(line_of(mdr.Sphere(1.0)), t, 0.0, t * rho), exact) < 1e-12


def test_pressure_ends_at_the_contact():
    for profile, excess in ((mdr.Paraboloid(1.0), 0.0), (mdr.FlatPunch(1.0), 0.3)):
        assert pressure(line_of(profile), 1.0, excess, [1.0 + 1e-12, 2.0, 1e9]).tolist() == [0.0] * 3
    assert pressure(line_of(mdr.Paraboloid(1.0)), 1.0, 0.0, 1.0) == 0.0
    assert pressure(line_of(mdr.Paraboloid(1.0)), 0.0, 0.0, [0.0, 1.0]).tolist() == [0.0, 0.0]


def test_flat_punch_pressure_and_amplitude():
    line = line_of(mdr.FlatPunch(2.0), 3.0)
    r = 2.0 * np.append(0.0, RADII)
    exact = 3.0 * 0.1 / math.pi / np.sqrt((2.0 - r) * (2.0 + r))
    assert worst(pressure(line, 2.0, 0.1, r), exact) < 1e-14
    assert math.isinf(pressure(line, 2.0, 0.1, 2.0))
    K = float(edge_amplitude(line, 2.0, 0.1))
    near = 2.0 * 1e-8
    assert float(pressure(line, 2.0, 0.1, 2.0 - near)) == pytest.approx(K / math.sqrt(near), rel=1e-8)
    assert edge_amplitude(line, [0.0, 1.0], [0.0, 0.0]).tolist() == [0.0, 0.0]


# --- through a result ------------------------------------------------------------------------------------

SHAPES = {
    "sphere": (mdr.Sphere(1.0), 0.3, ()),
    "deep_sphere": (mdr.Sphere(1.0), 0.99, ()),
    "paraboloid": (mdr.Paraboloid(1.0), 0.3, ()),
    "cone": (mdr.Cone(slope=TAN), 0.3, ()),
    "power_1.5": (mdr.PowerLaw(1.5, 1.0, 1.0), 0.3, ()),
    "power_4": (mdr.PowerLaw(4, 1.0, 1.0), 0.3, ()),
    "flat": (mdr.FlatPunch(0.7), 0.3, ()),
    "dome_below": (mdr.FlatPunch(0.7) + mdr.Paraboloid(1.0), 0.3, ()),
    "dome_above": (mdr.FlatPunch(0.7) + mdr.Paraboloid(1.0), 0.8, ()),
    "conical_punch": (mdr.FlatPunch(0.5) + mdr.Cone(slope=0.2), 0.8, ()),
    "concave": (mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / 2, derivative=lambda r: -r), 1.5, ()),
    "trunc_cone": (
        mdr.Function(derivative=lambda r: np.where(r > 0.4, TAN, 0.0), breakpoints=[0.4]),
        0.5,
        (0.4,),
    ),
    "rounded_cylinder": (
        mdr.Function(derivative=lambda r: np.maximum(r - 0.4, 0.0), breakpoints=[0.4]),
        0.2,
        (0.4,),
    ),
    "rounded_tip": (
        mdr.Function(derivative=lambda r: np.minimum(r / 0.4, 1.0), breakpoints=[0.4]),
        0.9,
        (0.4,),
    ),
    "wavy": (mdr.Function(derivative=lambda r: r + 0.06 * np.sin(6 * r)), 0.4, ()),
    "sum": (mdr.Sphere(2.0) + mdr.Cone(slope=0.2) + mdr.PowerLaw(4, 0.1, 1.0), 0.3, ()),
}


@pytest.fixture(scope="module")
def solved():
    return {
        name: mdr.solve(mdr.Contact(profile, mdr.Elastic(2.0, 0.0)), mdr.indent(d))
        for name, (profile, d, _) in SHAPES.items()
    }


def panel_nodes(low, high):
    """Gauss-Legendre on panels graded to both ends, for logarithms and roots there."""
    nodes, weights = np.polynomial.legendre.leggauss(14)
    left = np.concatenate([[0.0], 0.2 ** np.arange(16, -1, -1.0)]) / 2
    edges = low + (high - low) * np.concatenate([left, 1 - left[-2::-1]])
    widths = np.diff(edges)
    q = (edges[:-1, None] + widths[:, None] * (nodes + 1) / 2).ravel()
    return q, (widths[:, None] * weights / 2).ravel()


def pressure_near_corners(result, r, corners):
    """The pressure; closer than 1e-8 to a corner it is continued in the logarithm of the distance."""
    p = np.empty(r.shape)
    away = np.ones(r.shape, dtype=bool)
    for b in corners:
        for sign in (-1.0, 1.0):
            close = (np.abs(r - b) < 1e-8 * b) & ((r - b) * sign >= 0.0)
            if close.any():
                near, far = result.field("pressure", r=b * (1 + sign * np.array([1e-8, 1e-7]))).values
                decades = -8 - np.log10(np.maximum(np.abs(r[close] / b - 1), 1e-17))
                p[close] = near + (near - far) * decades
                away &= ~close
    p[away] = result.field("pressure", r=r[away]).values
    return p


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("distance", [1e-6, 1e-8, 1e-9, 3e-10, 1.2e-10, 8e-11, 4e-11])
def test_the_pressure_next_to_a_corner_is_logarithmic(side, distance, solved):
    # next to a jump of f' the pressure is linear in the logarithm of the distance
    r = 0.4 * (1 + side * np.array([1e-5, 1e-4]))
    near, far = solved["trunc_cone"].field("pressure", r=r).values
    expected = near + (near - far) * (-5 - math.log10(distance))
    computed = float(solved["trunc_cone"].field("pressure", r=0.4 * (1 + side * distance))[0])
    assert computed == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("name", SHAPES)
def test_pressure_over_the_disk_is_the_force(name, solved):
    result = solved[name]
    a, force = (float(result[q][0]) for q in ("contact_radius", "normal_force"))
    marks = [0.0, *sorted(math.sqrt(a * a - b * b) for b in SHAPES[name][2] if b < a), a]
    total, K = 0.0, 0.0
    for low, high in itertools.pairwise(marks):
        q, w = panel_nodes(low, high)
        r = np.sqrt((a - q) * (a + q))
        keep = (r > 0.0) & (r < a)
        q, w, r = q[keep], w[keep], r[keep]
        K = float(result.field("pressure", r=r[0])["edge_amplitude"])
        singular = K * math.sqrt(2 * a) / np.sqrt((a - r) * (a + r))
        total += 2 * math.pi * (w * q * (pressure_near_corners(result, r, SHAPES[name][2]) - singular)).sum()
    total += 2 * math.pi * a * K * math.sqrt(2 * a)
    assert total == pytest.approx(force, rel=1e-10)


@pytest.mark.parametrize(
    "name", [n for n in SHAPES if n not in ("flat", "dome_above", "conical_punch", "concave", "trunc_cone")]
)
def test_pressure_leads_back_to_the_line_load(name, solved):
    # q(x) = 2 int_x^a r p(r) / sqrt(r^2 - x^2) dr with r^2 = x^2 + s^2, an independent rule
    result = solved[name]
    a = float(result["contact_radius"][0])
    x = a * np.array([0.1, 0.35, 0.8])
    q = result.field("spring_force", r=x).values
    for position, exact in zip(x, q, strict=True):
        top = math.sqrt((a - position) * (a + position))
        marks = [
            0.0,
            *sorted(math.sqrt(b * b - position**2) for b in SHAPES[name][2] if position < b < a),
            top,
        ]
        total = 0.0
        for low, high in itertools.pairwise(marks):
            s, w = panel_nodes(low, high)
            total += 2 * (w * result.field("pressure", r=np.hypot(position, s)).values).sum()
        assert total == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("name", SHAPES)
def test_far_away_the_contact_is_a_point_load(name, solved):
    # u -> F / (pi E* r) (1 + m2 / (2 r^2)), the next term is below 1e-7 here
    result = solved[name]
    a, force = (float(result[q][0]) for q in ("contact_radius", "normal_force"))
    r = 1e4 * a
    u = float(result.field("normal_displacement", r=r)[0])
    assert u == pytest.approx(force / (math.pi * 2.0 * r), rel=1e-7)


@pytest.mark.parametrize("name", SHAPES)
def test_inside_the_surfaces_touch(name, solved):
    result = solved[name]
    a, d = (float(result[q][0]) for q in ("contact_radius", "indentation"))
    r = a * np.array([0.0, 0.3, 0.99, 1.0])
    assert result.field("gap", r=r).values.tolist() == [0.0] * 4
    f = result.surface.gap_function(r)
    assert result.field("normal_displacement", r=r).values == pytest.approx(d - f, rel=1e-12)


@pytest.mark.parametrize("a", [1e-9, 1.0, 1e3])
def test_displacement_and_gap_outside_hertz_and_cone(a, closed_forms):
    r = a * (1 + np.geomspace(1e-6, 100.0, 25))
    R = 7.0 * a
    line = line_of(mdr.Paraboloid(R))
    f, d = gap_function(mdr.Paraboloid(R), line.equivalent), a * a / R
    assert worst(normal_displacement(line, f, d, a, 0.0, r), closed_forms.hertz_displacement(r, a, R)) < 2e-13
    exact = closed_forms.hertz_gap(r, a, R)
    assert np.all(np.abs(gap(line, f, d, a, 0.0, r) / exact - 1) < 1e-12 + 1e-14 * r / (r - a))
    line = line_of(mdr.Cone(slope=0.3))
    f, d = gap_function(mdr.Cone(slope=0.3), line.equivalent), math.pi / 2 * 0.3 * a
    near = r[r < 10 * a]  # further out the closed form loses its digits
    assert (
        worst(normal_displacement(line, f, d, a, 0.0, near), closed_forms.cone_displacement(near, a, 0.3))
        < 1e-12
    )


def test_displacement_reference(references):
    for name, profile in (
        ("cone", mdr.Cone(slope=TAN)),
        ("paraboloid", mdr.Paraboloid(1.0)),
        ("sphere", mdr.Sphere(1.0)),
    ):
        expected = references[f"normal_{name}"]["expected"]
        result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(expected["d"]))
        assert float(result.field("normal_displacement", r=0.8)[0]) == pytest.approx(
            expected["u_r08"], rel=1e-12
        )
        assert result.field("pressure", r=[0.2, 0.5]).values == pytest.approx(
            [expected["p02_over_Estar"], expected["p05_over_Estar"]], rel=1e-12
        )
        assert float(result["elastic_energy"][0]) == pytest.approx(expected["U_over_Estar"], rel=1e-12)


def test_gap_before_contact_is_the_profile():
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), UNIT), mdr.indent(-0.5))
    assert result.field("gap", r=[0.0, 1.0]).values.tolist() == [0.5, 1.0]
    assert result.field("normal_displacement", r=[0.0, 1.0]).values.tolist() == [0.0, 0.0]
    assert result.field("pressure", r=[0.0, 1.0]).values.tolist() == [0.0, 0.0]


def test_beyond_a_sharp_edge_the_gap_is_infinite():
    result = mdr.solve(mdr.Contact(mdr.FlatPunch(1.0), UNIT), mdr.indent(0.5))
    assert result.field("gap", r=[0.5, 1.0, 1.5]).values.tolist() == [0.0, 0.0, math.inf]
    u = result.field("normal_displacement", r=[1.5, 7.0]).values
    assert worst(u, 1 / math.pi * np.arcsin(1 / np.array([1.5, 7.0]))) < 1e-13


def test_fields_on_the_line():
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(2.0), mdr.Elastic(3.0, 0.0)), mdr.indent(0.5))
    x = [0.0, 0.5, 1.0, 1.5]
    g = result.field("equivalent_profile", r=x)
    q = result.field("spring_force", r=x)
    assert g.dims == q.dims == ("x",)
    assert g.values == pytest.approx([0.0, 0.125, 0.5, 1.125], rel=1e-14)
    assert q.values == pytest.approx([1.5, 1.125, 0.0, 0.0], rel=1e-14, abs=1e-15)
    assert (g.attrs["units"], q.attrs["units"]) == ("m", "N/m")
    edge = mdr.solve(mdr.Contact(mdr.FlatPunch(1.0), mdr.Elastic(3.0, 0.0)), mdr.indent(0.5))
    assert edge.field("equivalent_profile", r=[0.5, 1.5]).values.tolist() == [0.0, math.inf]
    assert edge.field("spring_force", r=[0.5, 1.0, 1.5]).values.tolist() == [1.5, 1.5, 0.0]


def test_the_field_kernels_take_any_shape():
    line = line_of(mdr.Paraboloid(1.0))
    f = gap_function(mdr.Paraboloid(1.0), line.equivalent)
    for shape in ((), (2, 3), (0,)):
        for r in (0.5, 1.5):
            radii = np.full(shape, r)
            assert pressure(line, 1.0, 0.0, radii).shape == shape
            assert normal_displacement(line, f, 1.0, 1.0, 0.0, radii).shape == shape
            assert gap(line, f, 1.0, 1.0, 0.0, radii).shape == shape


@pytest.mark.parametrize("scale", [1e-9, 1e3])
def test_fields_of_rescaled_contacts(scale):
    r = np.array([0.05, 0.2, 0.35, 0.6, 0.9])

    def fields(s):
        profile = mdr.Sphere(2 * s) + mdr.Cone(slope=0.2) + mdr.PowerLaw(4, 0.1 * s, s)
        result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.3 * s))
        return [
            result.field(n, r=r * s).values / (1 if n == "pressure" else s)
            for n in ("pressure", "normal_displacement", "gap")
        ]

    for one, other in zip(fields(1.0), fields(scale), strict=True):
        assert np.max(np.abs(one - other)) < 1e-13 * np.max(np.abs(one))


@settings(max_examples=examples(12), deadline=None)
@given(
    profile=st.sampled_from(
        [
            mdr.Paraboloid("10 mm"),
            mdr.Sphere("10 mm"),
            mdr.Cone(slope=0.01),
            mdr.PowerLaw(1.5, "1 um", "0.2 mm"),
            mdr.FlatPunch("60 um") + mdr.Paraboloid("10 mm"),
            mdr.Function(
                lambda r: 0.01 * np.maximum(r - 5e-5, 0.0),
                derivative=lambda r: 0.01 * (r > 5e-5),
                breakpoints=(5e-5,),
            ),
        ]
    ),
    friction=st.sampled_from([0.3, math.inf]),
    turns=st.integers(70, 120),
    decay=st.floats(0.001, 0.5),
)
def test_tractions_of_many_disks_are_the_sum_of_their_pressures(profile, friction, turns, decay):
    steel = mdr.Elastic("210 GPa", 0.3)
    body = mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(friction))
    depth = 2e-6 * np.linspace(0.2, 1.0, turns)
    moved = 0.3e-6 * np.linspace(1.0, decay, turns) * (-1.0) ** np.arange(turns)
    result = mdr.solve(body, mdr.Path(indentation=depth, shift=moved))
    state = result.surface.replay.state(turns - 1)
    line = result.surface.line
    parts = superposition(state)
    disks = states_at_depth(line, parts.depth)
    r = float(disks.contact_radius[-1]) * np.array([1e-3, 0.2, 0.5, 0.8, 0.97])
    expected, size = np.zeros(r.size), np.zeros(r.size)
    for i in np.flatnonzero(disks.contact_radius > 0.0):
        a = float(disks.contact_radius[i])
        edge = parts.weight[i] * float(disks.edge_excess[i]) + parts.edge[i]
        inside = r < a
        own = np.zeros(r.size)
        own[inside] = parts.weight[i] * pressure(line, disks.place.take(i), 0.0, r[inside])
        own[inside] += line.modulus / math.pi * edge / np.sqrt((a - r[inside]) * (a + r[inside]))
        expected += parts.scale * own
        size += np.abs(parts.scale * own)
    computed = result.field("shear_traction", r).values
    assert np.all(np.abs(computed - expected) <= 1e-11 * size)


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(-8, 0),
    st.floats(1e-3, 0.5),
    st.sampled_from([{}, {"adhesion": mdr.JKR(1e-6)}, {"adhesion": mdr.MaugisDugdale(1e-6, range=1e-9)}]),
)
def test_unloaded_springs_bear_nothing_whatever_the_profile_outside(size, fraction, law):
    """A profile whose waves are many where nobody has touched would take long to be mapped there."""
    radius = 10.0**size
    calls = []

    def wavy(r):
        calls.append(float(np.max(r)))
        return r**2 / (2 * radius) + 1e-4 * radius * (1 - np.cos(r / (fraction * radius)))

    contact = mdr.Contact(mdr.Function(wavy), mdr.Elastic(1e9, 0.3), **law)
    separated = mdr.solve(contact, mdr.indent(-1e-2 * radius, steps=3))
    calls.clear()
    assert not separated.field("spring_force").values.any()
    # where the bodies might touch is read from a few arrays of heights; nothing is mapped out there
    assert len(calls) <= 4
