"""Torsion: springs of any history of load and twist against closed forms, many springs, and rings that do not use the method."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, ellipkm1, gamma, j1

import pymdr as mdr
from drawing import examples, first_of
from pymdr.independent.point_loads import tangential_point_load
from pymdr.independent.torsion import follow_torsion
from pymdr.line.curves import ElasticLine
from pymdr.line.torsion.constant import tabulated_limit, turn_at_constant_depth, twist_at_torque
from pymdr.line.torsion.limits import TwistedLine
from pymdr.line.torsion.moves import Segment, TwistState, displacement_of, slip_work, traction_of, turn
from pymdr.mapping.moduli import effective_moduli

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
DEPTHS = np.linspace(0.0, 2e-6, 30)


def shear_of(contact):
    return 1.0 / sum(
        1.0 / body.shear for body in (contact.body, contact.counterbody) if isinstance(body, mdr.Elastic)
    )


def unit_twist(contact, depth):
    """mu p0 / G of a paraboloid."""
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    a = math.sqrt(contact.profile.radius * depth)
    return (
        contact.friction.coefficient
        * 2
        * modulus
        * a
        / (math.pi * contact.profile.radius)
        / shear_of(contact)
    )


@pytest.mark.parametrize("name", ["lubkin_c0.9", "lubkin_c0.2"])
def test_slip_under_a_sphere_is_that_of_lubkin(references, name):
    entry = references[name]
    depth = 1e-6
    twist = entry["expected"]["Gphi_over_mup0"] * unit_twist(BALL, depth)
    result = mdr.solve(BALL, mdr.indent(depth) >> mdr.twist(twist))
    force, a = (float(result[name][-1]) for name in ("normal_force", "contact_radius"))
    full = 3 * math.pi / 16 * 0.3 * force * a
    assert float(result["torque"][-1]) / full == pytest.approx(entry["expected"]["M_over_Mfull"], rel=1e-12)
    assert float(result["stick_radius"][-1]) / a == pytest.approx(entry["inputs"]["c_over_a"], rel=1e-12)
    # mu p where it slips, the twist of the body where it sticks
    c = entry["inputs"]["c_over_a"] * a
    outside = np.array([c + 0.1 * (a - c), 0.5 * (a + c), c + 0.9 * (a - c)])
    np.testing.assert_allclose(
        result.field("torsional_traction", r=outside), 0.3 * result.field("pressure", r=outside), rtol=1e-11
    )
    inside = np.array([0.1, 0.5, 0.99]) * c
    turned = result.field("circumferential_displacement", r=inside).values
    np.testing.assert_allclose(turned, twist * inside, rtol=1e-11)
    assert np.all(result.field("slip", r=inside).values == 0)
    assert np.all(result.field("slip", r=outside).values > 0)


def test_a_flat_punch_turns_as_one(references):
    entry = references["torsion_flat"]
    shear = entry["inputs"]["G"]
    body = mdr.Elastic(2 * shear * 1.3, 0.3)
    contact = mdr.Contact(mdr.FlatPunch(entry["inputs"]["a"]), body, friction=mdr.Coulomb(math.inf))
    result = mdr.solve(contact, mdr.indent(0.01) >> mdr.twist(entry["inputs"]["phi"]))
    assert float(result["torque"][-1]) == pytest.approx(entry["expected"]["M"], rel=1e-12)
    tau = result.field("torsional_traction", r=[0.5]).values[0]
    assert tau == pytest.approx(entry["expected"]["tau_05"], rel=1e-11)
    assert result.claims["torque"].level is mdr.Level.EXACT


def test_the_limit_of_a_sphere_is_closed():
    line = TwistedLine(ElasticLine(mdr.equivalent_profile(mdr.Paraboloid(1.0)), 2.0), 0.7, 0.3)
    d = 0.01
    a = 0.1
    p0 = 2 * 2.0 * a / math.pi
    x = np.array([1e-12, 1e-6, 1e-3, 0.2, 0.5, 0.9, 0.99]) * a
    k2 = 1 - (x / a) ** 2
    np.testing.assert_allclose(
        line.limit_at(d).load(x), 4 * 0.3 * p0 * (ellipkm1((x / a) ** 2) - ellipe(k2)), rtol=1e-12
    )
    force = 4 / 3 * 2.0 * d**1.5
    assert line.limit_at(d).torque(np.zeros(1))[0] == pytest.approx(
        3 * math.pi / 16 * 0.3 * force * a, rel=1e-12
    )
    # a flat punch: mu p = mu F / (2 pi a sqrt(a^2 - r^2)) gives 2 mu F K / (pi a^2)
    flat = TwistedLine(ElasticLine(mdr.equivalent_profile(mdr.FlatPunch(a)), 2.0), 0.7, 0.3)
    force = 2 * 2.0 * a * d
    np.testing.assert_allclose(
        flat.limit_at(d).load(x[3:]), 2 * 0.3 * force * ellipk(k2[3:]) / (math.pi * a**2), rtol=1e-12
    )
    assert flat.limit_at(d).torque(np.zeros(1))[0] == pytest.approx(math.pi / 4 * 0.3 * force * a, rel=1e-12)


def drawn_line(kind, size, slope):
    profile = {
        "paraboloid": lambda: mdr.Paraboloid(size),
        "cone": lambda: mdr.Cone(slope=slope),
        "quartic": lambda: mdr.PowerLaw(4.0, slope * size, size),
        "worn": lambda: mdr.TruncatedCone(0.02 * size, slope=slope),
        "rounded": lambda: mdr.RoundedCone(size, slope=slope),
    }[kind]()
    return TwistedLine(ElasticLine(mdr.equivalent_profile(profile), 2e9), 0.7e9, 0.4)


KINDS = ["paraboloid", "cone", "quartic", "worn", "rounded"]


def drawn_history(line, size, slope, moves):
    """Rows of depth and twist with both, one or the other moving."""
    deepest = 0.01 * slope * size
    a = line.limit_at(deepest).radius
    scale = float(line.limit_at(deepest).load(np.array([0.5 * a]))[0]) / (8 * line.shear)
    rows, d, phi = [], 0.0, 0.0
    for kind, depth, twist in moves:
        d = depth * deepest if kind != "twist" or not rows else d
        phi = twist * scale if kind != "load" and rows else phi
        rows.append((d, phi))
    return rows


MOVES = st.lists(
    st.tuples(st.sampled_from(["load", "twist", "both"]), st.floats(0.05, 1.0), st.floats(-2.0, 2.0)),
    min_size=2,
    max_size=12,
)


@settings(max_examples=examples(30), deadline=None)
@given(st.sampled_from(KINDS), st.floats(-9.0, 0.0), st.floats(0.01, 0.3), MOVES)
def test_segments_are_the_limit_of_many_springs(kind, power, slope, moves):
    size = 10.0**power
    line = drawn_line(kind, size, slope)
    rows = drawn_history(line, size, slope, moves)
    n = 2000
    top = line.limit_at(max(d for d, _ in rows)).radius
    x = (np.arange(n) + 0.5) * top / n
    g = line.line.equivalent.g(x)
    q, d0, phi0, state = np.zeros(n), 0.0, 0.0, TwistState()
    full = 2 * np.sum(x**2 * line.limit_at(max(d for d, _ in rows)).load(x)) * top / n
    for d, phi in rows:
        rise = d - d0
        part = np.where(g < d0, 1.0, np.clip((d - g) / rise, 0.0, 1.0) if rise > 0 else 0.0)
        most = line.limit_at(d).load(x)
        q = np.where(g < d, np.clip(q + 8 * line.shear * (phi - phi0) * part, -most, most), 0.0)
        d0, phi0 = d, phi
        before, state = state, turn(line, state, d, phi)
        work, _ = slip_work(line, before, state)
        assert state.torque == pytest.approx(2 * np.sum(x**2 * q) * top / n, rel=1e-4, abs=1e-5 * full)
        assert work >= 0.0


@settings(max_examples=examples(6), deadline=None)
@given(st.sampled_from(KINDS), st.floats(-9.0, 0.0), st.floats(0.01, 0.3), MOVES, st.integers(2, 7))
def test_rows_may_be_divided(kind, power, slope, moves, parts):
    """A row in parts ends in the same state, and what is put in is stored or lost."""
    size = 10.0**power
    line = drawn_line(kind, size, slope)
    whole = divided = TwistState()
    d0 = phi0 = 0.0
    largest = 0.0
    for d, phi in drawn_history(line, size, slope, moves):
        whole = turn(line, whole, d, phi)
        for k in range(1, parts + 1):
            at = (d, phi) if k == parts else (d0 + (d - d0) * k / parts, phi0 + (phi - phi0) * k / parts)
            divided = turn(line, divided, *at)
        d0, phi0 = d, phi
        largest = max(largest, abs(whole.torque))
        assert divided.torque == pytest.approx(whole.torque, rel=1e-9, abs=1e-11 * largest)
        assert divided.stick_radius == pytest.approx(whole.stick_radius, rel=1e-6)


@pytest.mark.parametrize("beyond", [1e-10, 1e-7, 1e-4, 1e-2])
def test_the_limit_next_to_the_flat_of_a_truncated_cone(beyond):
    """Where g' has an inverse square root, by a quadrature over the root of the distance from the flat."""
    slope, x = 0.05, np.array([0.01, 0.3, 0.9, 0.999])
    line = TwistedLine(
        ElasticLine(mdr.equivalent_profile(mdr.TruncatedCone(1.0, slope=slope)), 1.0), 1.0, 0.3
    )
    node, weight = np.polynomial.legendre.leggauss(100)
    e = beyond * ((node + 1.0) / 2.0) ** 2
    root = np.sqrt(e * (2.0 + e))
    terms = slope * (np.arctan(root) + 1.0 / root) * beyond * (node + 1.0) / 2.0 * weight
    s = 1.0 + e
    expected = [float(np.sum(terms * ellipkm1((one / s) ** 2) / s)) * 1.2 / math.pi for one in x]
    depth = slope * (1.0 + beyond) * math.atan(math.sqrt(beyond * (2.0 + beyond)))
    assert line.limit_at(depth).load(x) == pytest.approx(expected, rel=1e-12 + line.error_near_kink(depth))


def test_work_of_slip_is_that_of_many_springs():
    """Load and twist change together; 100 parts of a row by the middle of the force of every spring."""
    line = drawn_line("paraboloid", 1.0, 0.1)
    n, parts, deepest = 200, 100, 1e-3
    top = line.limit_at(deepest).radius
    unit = float(line.limit_at(deepest).load(np.array([0.5 * top]))[0]) / (8 * line.shear)
    x = (np.arange(n) + 0.5) * top / n
    g, q, state, total, known = line.line.equivalent.g(x), np.zeros(n), TwistState(), 0.0, 0.0
    for depth, twist in [(0.6, 1.0), (1.0, -0.4), (0.9, 0.9)]:
        end = turn(line, state, depth * deepest, twist * unit)
        work, error = slip_work(line, state, end)
        known += work
        assert error <= 2e-3 * known
        for k in range(1, parts + 1):
            d = state.indentation + k / parts * (end.indentation - state.indentation)
            before = state.indentation + (k - 1) / parts * (end.indentation - state.indentation)
            change = 8 * line.shear * (end.twist - state.twist) / parts
            most = line.limit_at(d).load(x)
            # a spring that enters is moved by the rest of the part
            fraction = 1.0 if d <= before else np.clip((d - g) / (d - before), 0.0, 1.0)
            moved = q + change * fraction
            new = np.where(g < d, np.clip(moved, -most, most), 0.0)
            total += np.sum(x**2 * np.abs(moved - new) * np.abs(q + new) / 2) / (8 * line.shear)
            q = new
        state = end
        assert 2 * total * top / n == pytest.approx(known, rel=5e-3)


def cone_with_a_flat(depth_over_flat):
    """The line of a truncated cone of radius 1, an indentation, and Q_max by a quadrature over the root of the distance from the flat."""
    slope = 0.05
    line = TwistedLine(
        ElasticLine(mdr.equivalent_profile(mdr.TruncatedCone(1.0, slope=slope)), 1.0), 1.0, 0.3
    )
    a = 1.0 + depth_over_flat
    node, weight = np.polynomial.legendre.leggauss(60)
    parts = np.concatenate([[0.0], 0.5 ** np.arange(40.0, -1.0, -1.0)])

    def most(x):
        first = np.sqrt(np.maximum(x - 1.0, 0.0))
        edges = first + (math.sqrt(depth_over_flat) - first) * parts
        e = edges[:-1, None] + np.diff(edges)[:, None] * (node + 1.0) / 2.0
        root = e * np.sqrt(2.0 + e * e)
        s = 1.0 + e * e
        terms = slope * (np.arctan(root) + 1.0 / root) * ellipkm1(np.minimum((x / s) ** 2, 1.0)) / s
        return float(np.sum(terms * 2.0 * e * weight / 2.0 * np.diff(edges)[:, None])) * 1.2 / math.pi

    return line, slope * a * math.atan(math.sqrt(depth_over_flat * (2.0 + depth_over_flat))), most


@pytest.mark.parametrize("beyond", [0.1, 1.5])
def test_a_limit_is_known_on_both_sides_of_a_kink(beyond):
    """Close to the flat, above which g' has an inverse square root; in full slip the torsional traction is mu p."""
    line, depth, most = cone_with_a_flat(beyond)
    limit = line.limit_at(depth)
    x = np.array([0.9, 1.0 - 1e-6, 1.0 - 1e-10, 1.0 + 1e-10, 1.0 + 1e-6, 1.0 + 1e-3, 1.0 + 0.5 * beyond])
    expected = [most(one) for one in x]
    np.testing.assert_allclose(limit.load(x), expected, rtol=1e-12)
    np.testing.assert_allclose(tabulated_limit(limit).at(x).load, expected, rtol=1e-11)
    slid = (Segment(0.0, limit.radius, 0.0, 1, limit),)
    r = np.array([0.5, 0.99, 1.0 - 1e-6, 1.0 - 1e-8, 1.0 + 1e-8, 1.0 + 1e-6, 1.001, 1.0 + 0.5 * beyond])
    np.testing.assert_allclose(traction_of(line, slid, r), limit.traction(r), rtol=1e-10)


class FlatsOfCones:
    """Q_max, energies and work of slip where g is a sum of those of truncated cones, by Gauss in the root of the distance from each flat."""

    NODE, WEIGHT = np.polynomial.legendre.leggauss(24)

    def __init__(self, flats, slopes):
        self.flats, self.slopes = flats, slopes
        heights = [lambda r, b=b, c=c: c * np.maximum(r - b, 0.0) for b, c in zip(flats, slopes, strict=True)]
        profile = (
            mdr.TruncatedCone(flats[0], slope=slopes[0])
            if len(flats) == 1
            else mdr.Function(lambda r: sum(one(r) for one in heights), breakpoints=flats)
        )
        self.line = TwistedLine(ElasticLine(mdr.equivalent_profile(profile), 1.0), 1.0, 0.3)

    def depth(self, a):
        return sum(
            slope * a * math.atan2(math.sqrt((a - b) * (a + b)), b)
            for b, slope in zip(self.flats, self.slopes, strict=True)
            if b < a
        )

    def nodes(self, low, high, flat=0.0):
        """Between two radii above a flat."""
        start, stop = math.sqrt(low - flat), math.sqrt(high - flat)
        parts = np.concatenate([[0.0], 0.25 ** np.arange(12.0, -1.0, -1.0)])
        edges = start + (stop - start) * parts
        v = (edges[:-1, None] + np.diff(edges)[:, None] * (self.NODE + 1.0) / 2.0).ravel()
        return v, (np.diff(edges)[:, None] * self.WEIGHT / 2.0).ravel() * 2.0 * v

    def load(self, x, a):
        """Q_max at one x, with 4 mu E*/pi = 1.2/pi."""
        total = 0.0
        for b, slope in zip(self.flats, self.slopes, strict=True):
            if max(b, x) < a:
                v, weight = self.nodes(max(b, x), a, b)
                s = b + v * v
                root = v * np.sqrt(s + b)
                rise = slope * (np.arctan(root / b) + b / root)
                total += float(np.sum(weight * rise * ellipkm1(np.minimum((x / s) ** 2, 1.0)) / s))
        return total * 1.2 / math.pi

    def integral(self, f, marks):
        """Of x^2 f(x) over radii between marks and flats."""
        marks = np.unique([*marks, *(b for b in self.flats if marks[0] < b < marks[-1])])
        total = 0.0
        for low, high in pairwise(marks.tolist()):
            flat = max((b for b in self.flats if b <= low), default=0.0)
            v, weight = self.nodes(low, high, flat)
            x = flat + v * v
            total += float(np.sum(weight * x**2 * [f(one) for one in x]))
        return total


@settings(max_examples=examples(20), deadline=None)
@given(
    st.sampled_from([((1.0,), (0.05,)), ((1.0, 1.001), (0.05, 0.1))]),
    st.sampled_from([1.2, 4.0]),
    st.floats(0.0, 8.0),
    st.sampled_from([-1.0, 1.0]),
    st.integers(1, 30),
)
@example(((1.0,), (0.05,)), 1.2, 4.5, 1.0, 1)
@example(((1.0, 1.001), (0.05, 0.1)), 1.2, 6.0, 1.0, 2)
def test_slip_that_ends_next_to_a_kink(cones, top, digits, side, rows):
    """Energies and work of slip with a border just above or below a flat: at constant load, less load, and a twist back."""
    exact = FlatsOfCones(*cones)
    line, flat = exact.line, cones[0][-1]
    stick = flat * (1.0 + side * 10.0**-digits)
    stick = min(max(stick, 0.3), 1.0 + 0.9 * (top - 1.0))
    depth, load = exact.depth(top), lambda x: exact.load(x, top)
    q = load(stick)
    table = tabulated_limit(line.limit_at(depth))
    state = read = turn(line, TwistState(), depth, 0.0)
    work = read_work = 0.0
    for twist in np.linspace(0.0, q / 8.0, rows + 1)[1:].tolist():
        before, state = state, turn(line, state, depth, twist)
        work += slip_work(line, before, state)[0]
        read, slip_loss = turn_at_constant_depth(table, read, twist)
        read_work += slip_loss
    stored = q**2 * stick**3 / 3.0 + exact.integral(lambda x: load(x) ** 2, [stick, top])
    slid = 2.0 * exact.integral(lambda x: load(x) * (q - load(x)), [stick, top])
    for computed, dissipated in ((state, work), (read, read_work)):
        assert 8.0 * computed.energy == pytest.approx(stored, rel=1e-11)
        assert 8.0 * dissipated == pytest.approx(slid, rel=1e-10)
    # a smaller load at the same twist: the border moves to where the new limit is q
    less = 1.0 + 0.9 * (top - 1.0)
    border = brentq(lambda x: exact.load(x, less) - q, 0.1, less, xtol=1e-15)
    state = turn(line, state, exact.depth(less), state.twist)
    kept = q**2 * border**3 / 3.0 + exact.integral(lambda x: exact.load(x, less) ** 2, [border, less])
    assert 8.0 * state.energy == pytest.approx(kept, rel=1e-10)

    # the first load again, and a twist back to the same border
    def anchored(x):
        return q if x < border else exact.load(x, less)

    back = anchored(stick) + load(stick)
    begin = turn(line, state, depth, state.twist)
    state = turn(line, begin, depth, begin.twist - back / 8.0)
    marks = sorted({stick, min(max(border, stick), top), less, top})
    inner = sorted({1e-6, min(border, stick), stick})
    stored = exact.integral(lambda x: (anchored(x) - back) ** 2, inner)
    stored += exact.integral(lambda x: load(x) ** 2, [stick, top])
    slid = 2.0 * exact.integral(lambda x: load(x) * (back - anchored(x) - load(x)), marks)
    assert 8.0 * state.energy == pytest.approx(stored, rel=1e-10)
    assert 8.0 * slip_work(line, begin, state)[0] == pytest.approx(slid, rel=1e-10)


@settings(max_examples=examples(8), deadline=None)
@given(st.sampled_from(KINDS), st.floats(-9.0, 0.0), st.floats(0.01, 0.3), st.floats(-2.0, 0.5), st.randoms())
def test_a_table_of_the_limit_turns_like_the_integrals(kind, power, slope, amplitude, random):
    """Torque, energy, stick radius and work along twists at constant depth, by integrals of the limit in every row."""
    line = drawn_line(kind, 10.0**power, slope)
    depth = 0.01 * slope * 10.0**power
    limit = line.limit_at(depth)
    unit = float(limit.load(np.array([0.5 * limit.radius]))[0]) / (8 * line.shear)
    table, twist = tabulated_limit(limit), 0.0
    assert table.resolved
    state = other = turn(line, TwistState(), depth, 0.0)
    largest = slip_loss = known = 0.0
    for _ in range(8):
        twist += unit * 10.0**amplitude * random.uniform(-1.0, 1.0)
        before, other = other, turn(line, other, depth, twist)
        result = turn(line, before, depth, twist_at_torque(table, state, other.torque))
        largest = max(largest, abs(other.torque))
        assert result.torque == pytest.approx(other.torque, abs=1e-12 * largest + 1e-15 * table.full_slip)
        state, work = turn_at_constant_depth(table, state, twist)
        slip_loss, known = slip_loss + work, known + slip_work(line, before, other)[0]
        assert state.torque == pytest.approx(other.torque, rel=1e-12, abs=1e-12 * largest)
        assert state.energy == pytest.approx(other.energy, rel=1e-10, abs=1e-11 * largest * abs(twist))
        assert state.stick_radius == pytest.approx(other.stick_radius, rel=1e-11, abs=2e-9 * limit.radius)
        assert slip_loss == pytest.approx(known, rel=1e-9, abs=1e-12 * largest * unit)


def test_energies_balance_over_a_loop():
    """What is put in is stored or lost: both are exact at constant load, where the trapezoid of the torque is of second order."""
    left = []
    for steps in (80, 160):
        result = mdr.solve(BALL, mdr.load("50 N") >> mdr.cycle(twist="2 mrad", cycles=2, steps=steps))
        twist, torque = (result[name].values for name in ("twist", "torque"))
        work = np.cumsum(np.diff(twist) * (torque[1:] + torque[:-1]) / 2)
        kept = (result["stored_torsional_energy"] + result["dissipated_energy"]).values[1:]
        left.append(np.max(np.abs(kept - work)) / work[-1])
    assert left[1] < 1e-3
    assert left[0] / left[1] == pytest.approx(4.0, rel=0.01)
    first, second = 20, 100  # both at the largest twist
    assert torque[second] == pytest.approx(torque[first], rel=1e-12)
    assert twist[second] == pytest.approx(twist[first], rel=1e-12)


def test_a_torque_finds_its_twist():
    turned = mdr.solve(
        BALL, mdr.load("50 N") >> mdr.twist("1 mrad", steps=3) >> mdr.twist("0.2 mrad", steps=2)
    )
    torques = turned["torque"].values[1:]
    path = mdr.load("50 N") >> mdr.Path(torque=torques)
    back = mdr.solve(BALL, path)
    np.testing.assert_allclose(back["twist"].values[1:], turned["twist"].values[1:], rtol=1e-9)
    full = 3 * math.pi / 16 * 0.3 * 50 * float(turned["contact_radius"][0])
    with pytest.raises(mdr.PathError, match="friction carries less than"):
        mdr.solve(BALL, mdr.load("50 N") >> mdr.Path(torque=[1.01 * full]))


def ring_limit(edges, modulus, radius, friction):
    """Mean of mu p over rings of a sphere, in closed form."""

    def limit(depth):
        a = math.sqrt(radius * depth)
        at = np.minimum(edges, a)
        load = -2 / 3 * 2 * modulus / radius * (a * a - at**2) ** 1.5
        return friction * np.diff(load) / (math.pi * np.diff(edges**2))

    return limit


def test_rings_agree_along_a_history():
    """Load, twist, reversal and unloading: 2 units of twist, without slip inside."""
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), friction=mdr.Coulomb(0.3))
    d = 1e-4
    unit = unit_twist(contact, d)
    rows = [(d, 0.0), (d, 0.9 * unit), (0.7 * d, 0.9 * unit), (d, 0.9 * unit), (d, 0.3 * unit)]
    depths, twists = zip(*rows, strict=True)
    result = mdr.solve(contact, mdr.Path(indentation=depths, twist=twists))
    edges = np.linspace(0.0, 1.0001e-2, 201)
    rings = follow_torsion(edges, ring_limit(edges, 1.0, 1.0, 0.3), 0.5, depths, twists, edges[:-1] ** 2)
    assert result.claims["torque"].level is mdr.Level.EXACT
    largest = np.max(np.abs(rings.torque))
    np.testing.assert_allclose(result["torque"].values, rings.torque, atol=3e-5 * largest)


def test_an_inner_ring_that_slips_is_no_longer_exact():
    """After a reversal and a strong fall of the load the claim says by how much rings differ."""
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), friction=mdr.Coulomb(0.3))
    d = 1e-4
    unit = unit_twist(contact, d)
    rows = [(d, 0.0), (d, 1.2 * unit), (d, 0.1 * unit), (0.3 * d, 0.1 * unit), (0.1 * d, 0.1 * unit)]
    depths, twists = zip(*rows, strict=True)
    result = mdr.solve(contact, mdr.Path(indentation=depths, twist=twists))
    claim = result.claims["torque"]
    assert claim.level is mdr.Level.APPROXIMATE
    edges = np.linspace(0.0, 1.0001e-2, 201)
    rings = follow_torsion(edges, ring_limit(edges, 1.0, 1.0, 0.3), 0.5, depths, twists, edges[:-1] ** 2)
    torque = result["torque"].values
    differs = np.abs(torque - rings.torque)[1:] / np.abs(torque[1:])
    assert differs[-1] > 1e-3
    assert np.all(differs <= claim.error[1:] + 1e-4)


def drawn_profile(seed, size, slope, rng):
    """A profile, its g and g', and the radius of its flat."""
    if seed % 5 == 0:
        return (
            mdr.Paraboloid(size / slope),
            lambda x: slope * x**2 / size,
            lambda x: 2 * slope * x / size,
            0.0,
        )
    if seed % 5 == 1:
        return (
            mdr.Cone(slope=slope),
            lambda x: math.pi / 2 * slope * x,
            lambda x: np.full(x.shape, math.pi / 2 * slope),
            0.0,
        )
    if seed % 5 == 2:
        n = rng.uniform(1.5, 6.0)
        k = math.sqrt(math.pi) / 2 * n * gamma(n / 2) / gamma((n + 1) / 2) * slope * size
        power = mdr.PowerLaw(n, slope * size, size)
        return power, lambda x: k * (x / size) ** n, lambda x: k * n / size * (x / size) ** (n - 1), 0.0
    b = (0.85 if rng is None else rng.uniform(0.2, 0.85)) * size

    def parts(x):
        x = np.maximum(x, b)
        return x, np.sqrt((x - b) * (x + b)), np.arccos(b / x)

    def rounded(x):
        x, root, angle = parts(x)
        return slope * x / size * (root - b * angle)

    def rounded_slope(x):
        _, root, angle = parts(x)
        return slope / size * (2 * root - b * angle)

    def truncated_slope(x):
        _, root, angle = parts(x)
        return slope * (angle + b / root)

    if seed % 5 == 3:
        return mdr.RoundedFlat(b, edge_radius=size / slope), rounded, rounded_slope, b
    return mdr.TruncatedCone(b, slope=slope), lambda x: slope * parts(x)[0] * parts(x)[2], truncated_slope, b


def drawn_ring_limit(edges, g_slope, flat, radius, scale):
    """Mean of mu p over rings: scale = mu E*, and 2 E* int g' sqrt(x^2 - r^2) dx is the load beyond r."""
    node, weight = np.polynomial.legendre.leggauss(40)
    v, w = (node + 1) / 2, weight / 2

    def limit(depth):
        a = radius(depth)
        r = np.minimum(edges, a)[:, None]
        low = np.maximum(r, min(flat, a))
        x = low + (a - low) * v**2
        load = (
            2 * (g_slope(x) * np.sqrt(np.maximum(x**2 - r**2, 0.0)) * 2 * v * (a - low) * w).sum(axis=1)
            if a > flat
            else 0 * edges
        )
        return scale * -np.diff(load) / (math.pi * np.diff(edges**2))

    return limit


def beyond_claim(contact, shape, depths, twists, counts=(15, 30)):
    """Difference of the torque to that of rings beyond the claim, and of two numbers of rings, over the limit of the largest load so far."""
    g, g_slope, flat = shape
    friction, body = contact.friction.coefficient, contact.body

    def radius(depth):
        if depth <= 0.0:
            return flat
        return brentq(lambda x: float(g(np.array([x]))[0]) - depth, flat, high, xtol=1e-15 * high)

    high = max(2.0 * flat, 1e-300)
    while float(g(np.array([high]))[0]) < np.max(depths):
        high *= 2.0
    top = radius(np.max(depths))
    followed = []
    for count in counts:
        inside = np.linspace(0.0, flat, count + 1) if flat else np.zeros(1)
        edges = np.append(inside, np.linspace(flat, 1.0001 * top, count + 1)[1:])
        scale = friction * effective_moduli(body, mdr.Rigid()).normal
        limit = drawn_ring_limit(edges, g_slope, flat, radius, scale)
        rings = follow_torsion(edges, limit, body.shear, depths, twists, g(edges[:-1]))
        followed.append(rings.torque)
    arms = 2 * math.pi / 3 * np.diff(edges**3)
    full = np.maximum.accumulate([float(limit(d) @ arms) for d in depths])
    result = mdr.solve(contact, mdr.Path(indentation=depths, twist=twists))
    torque, error = result["torque"].values, result.claims["torque"].error
    claimed = 0.0 if error is None else error
    own = np.maximum.accumulate(np.abs(followed[0] - followed[1]) / full)
    assert np.all(np.isfinite(result["dissipated_energy"].values))
    # what the claim of a row leaves to its rounding by rings
    allowed = 2.0 * own + np.where(np.greater(claimed, 1e-9), 1e-3, 0.0)
    return (np.abs(torque - followed[1]) - claimed * np.abs(torque)) / full, own, allowed


@pytest.mark.parametrize("seed", first_of([2, 6, 14, *(n for n in range(25) if n not in (2, 6, 14))], 3))
def test_random_histories_are_those_of_rings_within_the_claim(seed):
    """
    Load and twist together, from the first touch on too, or one at a time, from nm to m, on profiles with and without a flat.

    Half the rings show the error of the rings, over the limit of the largest load so far.
    """
    rng = np.random.default_rng(7100 + seed)
    size, slope = 10.0 ** rng.uniform(-8.0, 0.0), 10.0 ** rng.uniform(-4.0, -1.5)
    friction, young = 10.0 ** rng.uniform(-1.5, 0.2), 10.0 ** rng.uniform(5.0, 12.0)
    body = mdr.Elastic(young, rng.uniform(0.0, 0.5))
    profile, g, g_slope, flat = drawn_profile(seed, size, slope, rng)
    contact = mdr.Contact(profile, body, friction=mdr.Coulomb(friction))
    inner = max(flat, 0.3 * size)
    at = np.sort(rng.uniform(0.2, 1.0, 6)) if seed % 4 == 1 else rng.uniform(0.2, 1.0, 6)
    radii = inner + (size - inner) * at
    depths = g(radii)
    modulus = effective_moduli(body, mdr.Rigid()).normal
    unit = friction * modulus * float(g(np.array([size]))[0]) / size / body.shear
    twists = unit * 10.0 ** rng.uniform(-1.0, 0.4) * rng.uniform(-1.0, 1.0, 6)
    if seed % 4 == 2:
        depths[1::2], twists[2::2] = depths[:-1:2], twists[1:-1:2]
    rest, own, allowed = beyond_claim(contact, (g, g_slope, flat), depths, twists)
    assert np.all(rest <= allowed)
    assert np.max(own) < 0.05


def test_a_rounded_flat_unloaded_to_a_hundredth_after_a_reversal_is_within_its_claim():
    """The torque is 16 % of that of full slip off."""
    profile, g, g_slope, flat = drawn_profile(3, 1.0, 0.01, None)
    contact = mdr.Contact(profile, mdr.Elastic(1.0, 0.0), friction=mdr.Coulomb(0.3))
    depths = g(np.array([0.96, 0.99, 0.87]))
    unit = 0.3 * float(g(np.array([1.0]))[0]) / 0.5
    rest, own, _ = beyond_claim(
        contact, (g, g_slope, flat), depths, unit * np.array([0.844, -0.523, -0.272]), counts=(10, 20)
    )
    assert np.all(rest <= 2.0 * own)


def test_bodies_add_their_compliances():
    path = mdr.load("5 N") >> mdr.twist("10 urad")
    rigid, soft = (
        mdr.solve(mdr.Contact(mdr.FlatPunch("1 mm"), STEEL, other, friction=mdr.Coulomb(math.inf)), path)
        for other in (mdr.Rigid(), STEEL)
    )
    assert float(rigid["torque"][-1]) == pytest.approx(2 * float(soft["torque"][-1]), rel=1e-14)
    # a crystal whose stiffnesses are isotropic turns as the isotropic body
    nu, young = 0.3, 210e9
    shear = young / (2 * (1 + nu))
    c11 = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    c13 = c11 - 2 * shear
    crystal = mdr.TransverselyIsotropic(c11=c11, c33=c11, c13=c13, c44=shear, c66=shear)
    like = mdr.solve(mdr.Contact(mdr.FlatPunch("1 mm"), crystal, friction=mdr.Coulomb(math.inf)), path)
    assert float(like["torque"][-1]) == pytest.approx(float(rigid["torque"][-1]), rel=1e-13)


def test_saved_results_and_tables(tmp_path):
    result = mdr.solve(BALL, mdr.load("50 N") >> mdr.twist("0.5 mrad", steps=3))
    result.save(tmp_path / "ball.nc")
    again = mdr.open_result(tmp_path / "ball.nc")
    r = [1e-5, 1e-4]
    np.testing.assert_array_equal(
        again.field("torsional_traction", r=r), result.field("torsional_traction", r=r)
    )
    result.to_csv(tmp_path / "ball.csv")
    assert "torque [N*m]" in (tmp_path / "ball.csv").read_text()
    assert sorted(result.figures()) == ["energies", "loop", "section", "tractions"]


@pytest.mark.parametrize(
    ("contact", "path", "match"),
    [
        (mdr.Contact(mdr.Sphere("1 mm"), STEEL), mdr.indent("1 um") >> mdr.twist("1 mrad"), "no friction"),
        (BALL, mdr.indent("1 um") >> mdr.shift("1 um") >> mdr.twist("1 mrad"), "does not superpose"),
        (
            mdr.Contact(
                mdr.Sphere("1 mm"),
                mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), 0.5),
                friction=mdr.Coulomb(0.3),
            ),
            mdr.indent("1 um", duration="1 s") >> mdr.twist("1 mrad", duration="1 s"),
            "twist",
        ),
        (
            mdr.Contact(mdr.Sphere("1 mm"), STEEL, adhesion=mdr.JKR("1 J/m^2")),
            mdr.indent("1 um") >> mdr.twist("1 mrad"),
            "twist",
        ),
        (
            mdr.Contact(
                mdr.ForceCurve(indentation=DEPTHS, force=1e9 * DEPTHS**1.5, modulus="230 GPa"),
                STEEL,
                friction=mdr.Coulomb(0.3),
            ),
            mdr.indent("1 um") >> mdr.twist("1 mrad"),
            "the contact is known by its ForceCurve only, and its torque depends on the contact radius",
        ),
    ],
)
def test_what_does_not_turn_is_refused(contact, path, match):
    with pytest.raises((mdr.PathError, mdr.ProblemError), match=match):
        mdr.solve(contact, path)


def test_bad_channels_are_refused():
    with pytest.raises(mdr.PathError, match="shift and twist cannot both"):
        mdr.ramp(shift="1 um", twist="1 mrad")
    with pytest.raises(mdr.UnitError, match="twist"):
        mdr.twist("1 mm")
    with pytest.raises(mdr.PathError, match="rad/s"):
        mdr.twist("1 mrad", rate="1 um/s")
    assert mdr.twist("1 mrad", rate="1 mrad/s").rate == 1e-3


def test_kept_fields_of_a_segment_with_entering_springs():
    """Springs that entered while the body turned carry beta (d - g); without slip their traction is a scaled pressure."""
    line = drawn_line("paraboloid", 1.0, 0.1)
    strong = TwistedLine(line.line, line.shear, 1e6)
    d, phi = 1e-3, 1e-6
    state = turn(strong, TwistState(), d, phi)
    a = strong.limit_at(d).radius
    rate = 8 * line.shear * phi / d
    assert state.segments == (Segment(0.0, a, rate * d, rate=rate),)
    r = np.array([0.1, 0.6, 0.95]) * a
    # q = x beta (d - x^2/R): tau = (r beta / pi R) sqrt(a^2 - r^2) * 1
    np.testing.assert_allclose(
        traction_of(strong, state.segments, r), r * rate / math.pi * np.sqrt(a**2 - r**2), rtol=1e-11
    )
    u = displacement_of(strong, state.segments, r)
    w = lambda x: x * rate * (d - x**2) / (8 * line.shear)  # noqa: E731
    angle = (np.arange(2000) + 0.5) * math.pi / 4000
    x = r[:, None] * np.sin(angle)
    expected = 4 / (math.pi * r) * np.mean(x * w(x), axis=1) * math.pi / 2
    np.testing.assert_allclose(u, expected, rtol=1e-6)


def test_verify_follows_a_twist_by_rings():
    comparison = mdr.verify(BALL, mdr.load("50 N") >> mdr.cycle(twist="2 mrad", steps=4), elements=80)
    assert comparison.largest_difference < 2e-3
    assert comparison.plot().axes
    for bad in (10, 2000):
        with pytest.raises(mdr.ProblemError, match="from 20 to 1000"):
            mdr.verify(BALL, mdr.load("50 N") >> mdr.twist("1 mrad"), elements=bad)


@pytest.mark.parametrize(
    ("profile", "rings", "most"),
    [
        (mdr.Sphere("10 mm"), 200, 5e-5),
        pytest.param(mdr.Sphere("10 mm"), 700, 1e-5, marks=pytest.mark.long),
        pytest.param(mdr.Cone(slope=0.02), 700, 1e-5, marks=pytest.mark.long),
        pytest.param(mdr.TruncatedCone(slope=0.02, flat_radius="30 um"), 700, 1e-4, marks=pytest.mark.long),
    ],
)
def test_rings_approach_the_exact_rows(profile, rings, most):
    """The difference is the error of the rings, which falls unevenly: their borders do not follow the edges of slip."""
    joint = mdr.Contact(profile, STEEL, STEEL, friction=mdr.Coulomb(0.3))
    path = mdr.indent("1 um") >> mdr.cycle(
        twist="2 mrad" if isinstance(profile, mdr.Sphere) else "8 mrad", steps=4
    )
    coarse, fine = (mdr.verify(joint, path, elements=n).largest_difference for n in (50, rings))
    assert fine < most
    assert coarse > 8.0 * fine


def test_a_worn_cone_twisted_once_is_the_limit_of_many_springs():
    line = drawn_line("worn", 1.0, 0.25)
    state = TwistState()
    rows = drawn_history(line, 1.0, 0.25, [("load", 1.0, 0.0), ("twist", 1.0, 1.0)])
    for depth, twist in rows:
        state = turn(line, state, depth, twist)
    depth, twist = rows[-1]
    n = 16000
    top = line.limit_at(depth).radius
    x = (np.arange(n) + 0.5) * top / n
    most = line.limit_at(depth).load(x)
    q = np.where(line.line.equivalent.g(x) < depth, np.clip(8 * line.shear * twist, -most, most), 0.0)
    assert state.torque == pytest.approx(2 * np.sum(x**2 * q) * top / n, rel=1e-5)


def plane_torque(result, z, step=-1, **side):
    """The torque through a plane, int sigma_tz r dA."""
    a = float(result["contact_radius"][step])
    points, weights = np.polynomial.legendre.leggauss(120)
    t = (np.arange(4)[:, None] / 4 + (points + 1) / 8).ravel()
    r = max(a, z) * t / (1 - t)
    stress = result.field("stress", r=r, z=[z], step=step, **side).sel(component="tz").values[0]
    return np.sum(np.tile(weights, 4) / 8 * max(a, z) / (1 - t) ** 2 * 2 * math.pi * r**2 * stress)


def test_the_stress_under_full_slip_is_that_of_point_loads():
    result = mdr.solve(BALL, mdr.indent("1 um") >> mdr.twist(1.0))
    a, p0 = float(result["contact_radius"][-1]), float(result["peak_pressure"][-1])
    points, weights = np.polynomial.legendre.leggauss(160)
    half = math.pi / 4 * (points + 1)
    rings, angles = a * np.sin(half), 2 * math.pi * np.arange(160) / 160
    load = weights * math.pi / 4 * a * np.cos(half) * rings * 2 * math.pi / 160
    load = (load * 0.3 * result.field("pressure", r=rings).values)[:, None]
    s, angle = np.meshgrid(rings, angles, indexing="ij")
    r, z = np.array([0.3 * a, 1.3 * a]), 0.5 * a
    expected = np.empty((2, r.size))
    for i in range(r.size):
        x, y, depth = r[i] - s * np.cos(angle), -s * np.sin(angle), np.full(s.shape, z)
        along = tangential_point_load(x, y, depth, 0.3)[[4, 5]]
        across = tangential_point_load(y, -x, depth, 0.3)[[4, 3]] * np.array([-1.0, 1.0])[:, None, None]
        expected[:, i] = np.sum((across * np.cos(angle) - along * np.sin(angle)) * load, axis=(1, 2))
    for side, sign in (("body", 1.0), ("counterbody", -1.0)):
        stress = result.field("stress", r=r, z=[z], side=side).sel(component=["rt", "tz"])
        np.testing.assert_allclose(stress.values[:, 0], sign * expected, rtol=0, atol=1e-13 * p0)


def test_the_stress_under_a_turned_punch_is_that_of_reissner_and_sagoci():
    """u_t = phi r under the disk; below it the Hankel integrals of tau = (4 G phi / pi) r / sqrt(a^2 - r^2)."""
    body = mdr.Elastic("1 GPa", 0.25)
    contact = mdr.Contact(mdr.FlatPunch("1 mm"), body, friction=mdr.Coulomb(math.inf))
    result = mdr.solve(contact, mdr.indent("1 um") >> mdr.twist("1 mrad"))
    a, shear, phi = 1e-3, body.shear, 1e-3
    k = np.linspace(0.0, 60.0, 60001)[1:] / a
    # int r tau J1(kr) dr
    image = 4 * shear * phi / math.pi * (np.sin(k * a) / (k * a) - np.cos(k * a)) * a / k
    r, z = 0.7 * a, 0.9 * a
    displacement = simpson(image * np.exp(-k * z) * j1(k * r), x=k) / shear
    stress = -simpson(k * image * np.exp(-k * z) * j1(k * r), x=k)
    inside = result.field("interior_displacement", r=[r], z=[0.0, z]).sel(component="t").values[:, 0]
    np.testing.assert_allclose(inside, [phi * r, displacement], rtol=1e-9)
    tz = result.field("stress", r=[r], z=[z]).sel(component="tz").item()
    assert tz == pytest.approx(stress, rel=1e-9)
    with pytest.raises(mdr.NotValidError, match="sharp"):
        result.largest("von_mises", step=-1)


TURNING = mdr.TransverselyIsotropic(c11="160 GPa", c33="60 GPa", c13="40 GPa", c44="20 GPa", c66="50 GPa")


@given(st.data())
@settings(max_examples=examples(12), deadline=None)
def test_every_plane_carries_the_torque(data):
    size = 10.0 ** data.draw(st.floats(-9, 0))
    profile = data.draw(
        st.sampled_from(
            [
                mdr.Paraboloid(size),
                mdr.Cone(slope=0.02),
                mdr.TruncatedCone(slope=0.02, flat_radius=1e-3 * size),
            ]
        )
    )
    friction = data.draw(st.sampled_from([0.1, 0.5, math.inf]))
    body, other = data.draw(st.permutations([STEEL, mdr.Elastic("3 GPa", 0.4), TURNING]))[:2]
    path = mdr.indent(1e-4 * size)
    for _ in range(data.draw(st.integers(1, 3))):
        path = path >> mdr.twist(data.draw(st.floats(-0.02, 0.02)))
        path = path >> mdr.indent(data.draw(st.floats(5e-5, 2e-4)) * size)
    result = mdr.solve(mdr.Contact(profile, body, other, friction=mdr.Coulomb(friction)), path)
    largest = float(np.abs(result["torque"]).max())
    for side, sign in (("body", -1.0), ("counterbody", 1.0)):
        depth = data.draw(st.floats(0.02, 2.0)) * float(result["contact_radius"][-1])
        assert sign * plane_torque(result, depth, side=side) == pytest.approx(
            float(result["torque"][-1]), abs=2e-9 * largest
        )


def test_the_stress_under_torsion_is_in_equilibrium():
    """d rt/dr + d tz/dz + 2 rt/r = 0 by central differences, whose error is of second order."""
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), TURNING, STEEL, friction=mdr.Coulomb(0.3))
    result = mdr.solve(joint, mdr.indent("1 um") >> mdr.twist("3 mrad") >> mdr.twist("1 mrad"))
    a = float(result["contact_radius"][-1])
    for r, z in ((0.5 * a, 0.3 * a), (1.1 * a, 0.2 * a)):
        rests = []
        for h in (2e-3 * a, 1e-3 * a):
            field = result.field("stress", r=[r - h, r, r + h], z=[z - h, z, z + h])
            rt, tz = (field.sel(component=name).values for name in ("rt", "tz"))
            terms = (rt[1, 2] - rt[1, 0]) / (2 * h), (tz[2, 1] - tz[0, 1]) / (2 * h), 2 * rt[1, 1] / r
            rests.append(abs(sum(terms)) / max(map(abs, terms)))
        assert rests[1] < 3e-5
        assert rests[1] < 0.3 * rests[0]


def test_a_sticking_contact_that_grows_keeps_the_traction_of_its_first_disk():
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(math.inf))
    result = mdr.solve(joint, mdr.indent("1 um") >> mdr.twist("1 mrad") >> mdr.indent("2 um"))
    r = np.array([0.0, 0.5e-4, 0.9e-4, 1.1e-4])
    np.testing.assert_array_equal(
        result.field("torsional_traction", r=r, step=2), result.field("torsional_traction", r=r, step=1)
    )
    assert result.field("torsional_traction", r=[1e-4], step=2).item() == math.inf
    assert result.field("torsional_traction", r=[0.0]).item() == 0.0
    with pytest.raises(mdr.NotValidError, match="sticking contact"):
        result.largest("von_mises", step=-1)


def test_the_largest_stress_moves_to_the_surface_with_friction():
    for friction, depth in ((0.1, 0.4809), (1.0, 0.0)):
        joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(friction))
        result = mdr.solve(joint, mdr.indent("1 um") >> mdr.twist("10 mrad"))
        peak = result.largest("von_mises", step=-1)
        assert float(peak.z) / float(result["contact_radius"][-1]) == pytest.approx(depth, abs=1e-4)
        near = result.field("von_mises", r=[float(peak.r)], z=[float(peak.z)])
        assert near.item() == pytest.approx(float(peak), rel=1e-9)
    cycle = mdr.solve(joint, mdr.indent("1 um") >> mdr.cycle(twist="2 mrad", steps=4))
    ruiz = mdr.fatigue(cycle, criterion=mdr.RuizWork())
    r = float(np.hypot(ruiz.x, ruiz.y))
    traction, slip = (
        cycle.field(name, r=[r], step=[1, 2, 3, 4]).values for name in ("torsional_traction", "slip")
    )
    assert ruiz.value == pytest.approx(np.abs(traction).max() * np.ptp(slip) / 2, rel=1e-6)
    with pytest.raises(mdr.NotValidError, match="RuizWork"):
        mdr.fatigue(cycle, criterion=mdr.RuizDamage())
    assert mdr.fatigue(cycle, criterion=mdr.DangVan(hydrostatic_slope=0.3)).value > 0.0
