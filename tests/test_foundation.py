"""Step 2: indentation, force, radius, stiffness and energy from one another, and the springs of the founding paper."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.line.foundation import (
    ElasticLine,
    _sure_load,
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    spring_foundation,
    states_at_depth,
    states_at_force,
    states_at_travel,
    touching_radius,
)
from pymdr.mapping.equivalent import equivalent_profile

CLOSED = {
    "sphere": mdr.Sphere(1.0),
    "paraboloid": mdr.Paraboloid(1.0),
    "cone": mdr.Cone(slope=0.3),
    "power_0.5": mdr.PowerLaw(0.5, 1.0, 1.0),
    "power_7": mdr.PowerLaw(7, 1.0, 1.0),
    "sum": mdr.Sphere(1.0) + mdr.Cone(slope=0.01) + mdr.PowerLaw(4, 0.1, 1.0),
    "flat": mdr.FlatPunch(0.7),
    "dome": mdr.FlatPunch(0.7) + mdr.Paraboloid(1.0),
}


def line_of(profile, modulus=1.0):
    return ElasticLine(equivalent_profile(profile), modulus)


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact, dtype=float) - 1)))


HOLLOW = {
    "concave": mdr.ConcavePunch(1.0, hollow_radius=50.0),
    "concave in a bowl": mdr.ConcavePunch(1.0, hollow_radius=20.0) + mdr.PowerLaw(4.0, 0.01, 1.0),
    "wavy": mdr.Paraboloid(1.0) + mdr.Waviness(1e-4, 0.1),
}


@settings(max_examples=examples(90), deadline=None)
@given(
    st.sampled_from([*CLOSED, *HOLLOW]),
    st.lists(st.floats(-0.05, 0.4).filter(lambda D: abs(D) > 1e-100), min_size=1, max_size=6),
    st.floats(-3.0, 3.0),
)
def test_depth_and_force_add_to_the_travel(name, travel, decade):
    line, k = line_of((CLOSED | HOLLOW)[name]), 10.0**decade
    travel = np.sort(travel)
    states = states_at_travel(line, travel, k)
    force = normal_force(line, states)
    d = states.indentation
    rounding = 4e-16 * normal_stiffness(line, states) * np.abs(d) / k
    assert np.all(np.abs(d + force / k - travel) <= 1e-14 * (np.abs(d) + force / k) + rounding)
    assert np.all(np.diff(d) >= -rounding[1:])
    assert np.all(force >= 0.0)


@pytest.mark.parametrize("name", CLOSED)
def test_round_trips_over_twelve_orders(name):
    line = line_of(CLOSED[name], 3.0)
    d = np.geomspace(1e-12, 0.9, 60)
    states = states_at_depth(line, d)
    force = normal_force(line, states)
    back = states_at_force(line, force)
    assert worst(back.indentation, d) < 1e-13
    assert worst(back.contact_radius, states.contact_radius) < 1e-13
    assert worst(normal_force(line, back), force) < 1e-13
    inside = states.edge_excess == 0.0
    if inside.any():
        assert worst(line.equivalent.g(states.contact_radius[inside]), d[inside]) < 1e-13
    assert worst(normal_stiffness(line, states), 2 * 3.0 * states.contact_radius) < 1e-15


def test_round_trips_of_a_callable():
    profile = mdr.Function(
        lambda r: r * r / 2 + 0.3 * r**4, derivative=lambda r: r + 1.2 * r**3
    )  # g = x^2 + 0.8 x^4
    line = line_of(profile)
    a = np.geomspace(1e-12, 0.8, 60)
    d = a**2 + 0.8 * a**4
    force = 2 * (2 / 3 * a**3 + 0.8 * 4 / 5 * a**5)
    states = states_at_depth(line, d)
    assert worst(states.contact_radius, a) < 1e-12
    assert worst(normal_force(line, states), force) < 1e-12
    assert worst(states_at_force(line_of(profile), force).indentation, d) < 1e-12


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 1e3])
def test_hertz_and_energy_of_any_size(size):
    line = line_of(mdr.Paraboloid(size), 7.0)
    d = size * np.geomspace(1e-12, 1.0, 13)
    states = states_at_depth(line, d)
    force = normal_force(line, states)
    assert worst(states.contact_radius, np.sqrt(size * d)) < 1e-13
    assert worst(force, 4 / 3 * 7.0 * np.sqrt(size) * d**1.5) < 1e-13
    assert worst(elastic_energy(line, states), 2 / 5 * force * d) < 1e-13
    assert worst(mean_pressure(force, states.contact_radius), 4 / 3 * 7.0 * np.sqrt(d / size) / np.pi) < 1e-13


@pytest.mark.parametrize("n", [0.5, 1.0, 2.0, 3.5])
def test_energy_of_power_laws(n):
    line = line_of(mdr.PowerLaw(n, 0.3, 2.0), 5.0)
    states = states_at_depth(line, np.array([1e-6, 0.1]))
    work = normal_force(line, states) * states.indentation * n / (2 * n + 1)
    assert worst(elastic_energy(line, states), work) < 1e-13


def test_sphere_up_to_almost_its_radius(closed_forms):
    R, t = 2.0, np.concatenate([np.geomspace(1e-9, 0.5, 50), np.linspace(0.51, 0.99, 30)])
    line = line_of(mdr.Sphere(R), 3.0)
    states = states_at_depth(line, R * closed_forms.sphere_g(t).astype(float))
    assert worst(states.contact_radius, R * t) < 1e-13
    assert worst(normal_force(line, states), 3.0 * R**2 * closed_forms.sphere_force(t)) < 1e-12
    assert worst(elastic_energy(line, states), 3.0 * R**3 * closed_forms.sphere_energy(t)) < 1e-12


def test_flat_punch():
    line = line_of(mdr.FlatPunch(0.7), 3.0)
    states = states_at_depth(line, np.array([1e-12, 0.1, 5.0]))
    d = states.indentation
    assert states.contact_radius.tolist() == [0.7] * 3
    assert states.edge_excess.tolist() == d.tolist()
    assert worst(normal_force(line, states), 2 * 3.0 * 0.7 * d) < 1e-15
    assert worst(elastic_energy(line, states), 3.0 * 0.7 * d**2) < 1e-15


def test_rounded_punch_below_and_above_full_contact():
    b, R, E = 0.7, 1.0, 3.0
    line = line_of(mdr.FlatPunch(b) + mdr.Paraboloid(R), E)
    full = b**2 / R
    below, above = full * np.array([1e-9, 0.5, 1 - 1e-9]), full * np.array([1.0, 1.5, 40.0])
    states = states_at_depth(line, below)
    assert worst(states.contact_radius, np.sqrt(R * below)) < 1e-13
    assert worst(normal_force(line, states), 4 / 3 * E * np.sqrt(R) * below**1.5) < 1e-13
    states = states_at_depth(line, above)
    assert states.contact_radius.tolist() == [b] * 3
    assert states.edge_excess == pytest.approx(above - full, rel=1e-13, abs=1e-16)
    assert worst(normal_force(line, states), 2 * E * (above * b - b**3 / (3 * R))) < 1e-13
    energy = E * (above**2 * b - 2 / 3 * above * b**3 / R + b**5 / (5 * R**2))
    assert worst(elastic_energy(line, states), energy) < 1e-13


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("shape", [(), (3,), (2, 2), (0,)])
def test_shapes_are_kept_and_no_contact_is_zero(name, shape):
    line = line_of(CLOSED[name])
    for value, solver in ((-0.1, states_at_depth), (0.0, states_at_depth), (0.0, states_at_force)):
        states = solver(line, np.full(shape, value))
        assert np.shape(states.contact_radius) == shape
        assert np.all(states.contact_radius == 0.0)
        assert np.all(normal_force(line, states) == 0.0)
        assert np.all(elastic_energy(line, states) == 0.0)
        assert np.all(mean_pressure(normal_force(line, states), states.contact_radius) == 0.0)
    states = states_at_depth(line, np.full(shape, 0.2))
    back = states_at_force(line, normal_force(line, states))
    assert back.indentation.shape == shape
    assert np.all(np.abs(back.indentation - 0.2) < 1e-13)


@pytest.mark.parametrize("shape", [(), (2, 2)])
def test_shapes_are_kept_where_g_falls(shape):
    profile = mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / 2, derivative=lambda r: -r)
    line = line_of(profile)
    states = states_at_depth(line, np.full(shape, 2.0))
    assert states.contact_radius.shape == shape
    assert np.all(np.abs(normal_force(line, states) - 2 * (2 + 1 / 3)) < 1e-12)
    assert np.all(np.abs(states_at_force(line, normal_force(line, states)).indentation - 2.0) < 1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=examples(15), deadline=None)
@example(0)
@example(10)
@example(41)
def test_every_force_is_carried_where_g_falls_in_many_places(seed):
    """Splines through noisy samples fall below their tip: there a force needs less than no depth."""
    rng = np.random.default_rng(seed)
    noise = 10.0 ** rng.uniform(-5.0, -1.5)
    r = np.sort(rng.uniform(0.02, 1.0, int(rng.integers(6, 25))))
    if rng.random() < 0.5:
        close = r[rng.integers(0, r.size, 2)]
        r = np.unique(np.concatenate([r, close * (1.0 + 10.0 ** rng.uniform(-6.0, -2.0))]))
    height = r**2 / 2.0 + noise * rng.normal(size=r.size)
    line = line_of(
        mdr.Sampled(np.append(0.0, r), np.append(0.0, height), interpolation=mdr.CubicSpline()), 0.7
    )
    moment = line.equivalent.moment(rng.uniform(0.05, 1.0, 4) * r[-1])
    force = 1.4 * moment[moment > 0.0]
    states = states_at_force(line, force)
    assert normal_force(line, states) == pytest.approx(force, rel=1e-9)
    for f, a, d in zip(force, states.contact_radius, states.indentation, strict=True):
        x = np.linspace(0.0, a, 20_001)
        whole = np.trapezoid(d - line.equivalent.g(x), x)
        assert whole == pytest.approx(f / 1.4, rel=1e-3, abs=1e-5 * a * np.ptp(line.equivalent.g(x)))


def best_of_all(equivalent, d, top):
    """The disk of largest load among those of every rising stretch and of a sharp edge, one after the other."""
    end = min(top, equivalent.edge)
    ends = np.array([0.0, *(t for t in equivalent.turning_points(top) if 0.0 < t < end), end])
    g = equivalent.g(ends)
    best = (0.0, 0.0)
    for i in np.flatnonzero((g[:-1] < d) & (d <= g[1:])):
        place = equivalent.between(np.array([d]), ends[i], ends[i + 1])
        best = max(best, (float((d * place.x - equivalent.integral(place))[0]), float(place.x[0])))
    if math.isfinite(equivalent.edge) and d >= g[-1]:
        best = max(best, (d * end - float(equivalent.integral(np.array([end]))[0]), end))
    return best


@settings(max_examples=examples(12), deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-9.0, 2.0), st.booleans())
def test_the_best_disk_is_the_best_of_all_stretches(seed, decades, edged):
    rng = np.random.default_rng(seed)
    size = 10.0**decades
    r = np.append(0.0, np.sort(rng.uniform(0.02, 1.0, int(rng.integers(8, 120)))))
    height = r**2 / 2.0 + 10.0 ** rng.uniform(-5.0, 0.0) * np.append(0.0, rng.normal(size=r.size - 1))
    profile = mdr.Sampled(size * r, size * height, interpolation=mdr.ShapePreserving())
    if edged:
        profile = profile + mdr.FlatPunch(size * rng.uniform(0.1, 0.9))
    line = line_of(profile)
    equivalent = line.equivalent
    top = min(profile.edge, profile.max_radius)
    depths = equivalent.g(np.array([0.0, *equivalent.turning_points(top), top]))
    d = np.append(rng.uniform(depths.min(), depths.max(), 20), size * 10.0 ** rng.uniform(-6.0, 0.5, 5))
    searched = touching_radius(equivalent, float(d.max()))
    radius = states_at_depth(line, d).contact_radius
    for depth, a in zip(d, radius, strict=True):
        load, best = best_of_all(equivalent, depth, searched)
        mine = depth * a - float(equivalent.integral(np.array([a]))[0])
        assert a == best or mine == pytest.approx(load, rel=1e-11)


@settings(max_examples=examples(25), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.6, 8), st.floats(0.05, 3)), min_size=1, max_size=3),
    st.floats(-9, 0),
    st.floats(1e-4, 0.9),
    st.booleans(),
)
def test_force_energy_and_stiffness_are_derivatives(terms, log_size, depth, round_tip):
    size = 10.0**log_size
    profile = mdr.PowerLaw(terms[0][0], terms[0][1] * size, size)
    for n, c in terms[1:]:
        profile = profile + mdr.PowerLaw(n, c * size, size)
    if round_tip:
        profile = profile + mdr.Sphere(4 * size)
    line = line_of(profile, 1e9)
    # Gauss in the depth: U = int F dd and F = int 2 E* a dd between 0.9 and 1.1 of the depth
    nodes, weights = np.polynomial.legendre.leggauss(16)
    low, high = 0.9 * depth * size, 1.1 * depth * size
    states = states_at_depth(line, low + (high - low) * (nodes + 1) / 2)
    weights = weights * (high - low) / 2
    ends = states_at_depth(line, np.array([low, high]))
    force, energy = normal_force(line, ends), elastic_energy(line, ends)
    assert float(weights @ normal_force(line, states)) == pytest.approx(energy[1] - energy[0], rel=1e-11)
    assert float(weights @ normal_stiffness(line, states)) == pytest.approx(force[1] - force[0], rel=1e-11)
    assert np.all(np.diff(normal_force(line, states)) > 0)
    # the same in other units of length and modulus
    scaled = mdr.PowerLaw(terms[0][0], terms[0][1], 1.0)
    for n, c in terms[1:]:
        scaled = scaled + mdr.PowerLaw(n, c, 1.0)
    if round_tip:
        scaled = scaled + mdr.Sphere(4.0)
    unit = line_of(scaled, 1.0)
    same = states_at_depth(unit, ends.indentation / size)
    assert worst(ends.contact_radius / size, same.contact_radius) < 1e-13
    assert worst(force / (1e9 * size**2), normal_force(unit, same)) < 1e-12
    assert worst(energy / (1e9 * size**3), elastic_energy(unit, same)) < 1e-12


# --- the springs of the founding paper -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "order"), [(mdr.Paraboloid(1.0), 1.9), (mdr.Cone(slope=0.5), 1.9), (mdr.Sphere(1.0), 1.9)]
)
def test_springs_converge_with_their_order(profile, order):
    line = line_of(profile, 2.0)
    state = states_at_depth(line, np.array([0.1]))
    exact, radius = float(normal_force(line, state)[0]), float(state.contact_radius[0])
    n = np.unique(np.geomspace(100, 30000, 60).astype(int))
    errors = np.array([abs(spring_foundation(line, 0.7, k).normal_force(0.1) / exact - 1) for k in n])
    # the position of the edge between two springs varies the constant: the envelope converges
    envelope = np.maximum.accumulate(errors[::-1])[::-1]
    assert -np.polyfit(np.log(n), np.log(envelope), 1)[0] > order
    assert errors[-1] < 1e-7
    for k in n:
        assert abs(spring_foundation(line, 0.7, int(k)).contact_radius(0.1) - radius) <= 0.7 / k * 1.0001 * 2


def test_springs_are_what_they_say():
    springs = spring_foundation(line_of(mdr.Paraboloid(1.0), 3.0), 2.0, 8)
    assert springs.spacing == 0.5
    assert springs.position.tolist() == [-1.75, -1.25, -0.75, -0.25, 0.25, 0.75, 1.25, 1.75]
    assert springs.profile == pytest.approx(springs.position**2, rel=1e-15)
    force = springs.spring_forces(1.0)
    assert force == pytest.approx(3.0 * 0.5 * np.maximum(1 - springs.position**2, 0), rel=1e-15)
    assert springs.normal_force(1.0) == pytest.approx(force.sum(), rel=1e-15)
    assert springs.contact_radius(1.0) == 1.0
    assert springs.normal_force(-1.0) == 0.0


def test_springs_of_a_punch_end_at_its_edge():
    springs = mdr.foundation(mdr.Contact(mdr.FlatPunch(1.0), mdr.Elastic(1.0, 0.0)), 1200)
    assert springs.position[-1] < 1.2
    assert springs.contact_radius(0.1) == pytest.approx(1.0, rel=1e-12)
    assert springs.normal_force(0.1) == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize(
    ("profile", "length"),
    [
        (mdr.FlatPunch(2.0), 2.4),
        (mdr.Paraboloid(3.0), 1.0),
        (mdr.PowerLaw(2, 0.5, 3.0), 3.0),
        (mdr.TruncatedCone(2.0, slope=0.1), 4.0),
        (mdr.TruncatedSphere(2.0, flat_radius=1.5), 0.999 * 2.0),
        (mdr.Sampled(np.linspace(0.0, 7.0, 9), np.linspace(0.0, 7.0, 9) ** 2), 7.0),
        (mdr.Function(lambda r: abs(r - 1.0) + r**2 - 1.0, breakpoints=[1.0]), 2.0),
    ],
)
def test_the_line_is_as_long_as_its_profile(profile, length):
    springs = mdr.foundation(mdr.Contact(profile, mdr.Elastic(1.0, 0.0)), n=40)
    assert springs.position[-1] + 0.5 * springs.spacing == pytest.approx(length, rel=1e-12)
    assert np.isfinite(springs.normal_force(1e-3))


@pytest.mark.parametrize("n", [0, 1, -3, 2.0, "4", True])
def test_bad_numbers_of_springs(n):
    with pytest.raises(mdr.ProblemError, match="at least 2"):
        mdr.foundation(mdr.Contact(mdr.Sphere(1.0), mdr.Elastic(1.0, 0.0)), n)


@pytest.mark.parametrize("length", [0.0, -1.0, "1 kg", math.nan])
def test_bad_lengths_of_the_line(length):
    with pytest.raises(mdr.PymdrError):
        mdr.foundation(mdr.Contact(mdr.Sphere(1.0), mdr.Elastic(1.0, 0.0)), half_length=length)


@settings(max_examples=examples(30), deadline=None)
@given(st.integers(0, 10**9), st.integers(2, 12))
def test_the_sure_load_is_the_largest_at_the_ends(seed, stretches):
    rng = np.random.default_rng(seed)
    for _ in range(30):
        # k g - F of any line rises by the mean of g times that of k on each stretch
        k = np.append(0.0, np.cumsum(rng.uniform(0.01, 1.0, stretches)))
        g = np.append(0.0, rng.uniform(-1.0, 1.0, stretches))
        unpressed = np.append(0.0, np.cumsum(0.5 * (g[1:] + g[:-1]) * np.diff(k)))
        depth = np.append(rng.uniform(-2.0, g[-1], 20), g[-1] + 0.1)
        load, _ = _sure_load(depth, k, g, unpressed)
        expected = np.max(depth[:, None] * k - unpressed, axis=1)
        np.testing.assert_allclose(load[:-1], expected[:-1], rtol=1e-13, atol=1e-14 * k[-1])
        assert load[-1] == 0.0
