"""The ring solver against closed forms, its measured orders of convergence, and contacts that are not disks."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipkm1, j0, struve

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.independent.rings import (
    Rings,
    displacement_at,
    pressure_at,
    ring_displacement,
    solve_adhesion,
    solve_force,
    solve_indentation,
)


def paraboloid(r):
    return r**2 / 2


def flat(r):
    return 0 * r


def concave(r):
    return -(r**2) / 2


def wavy(A):
    """f = r²/2 + A (1 - cos r), its g(x), and max over a of 2 ∫ (d - g): the load of the best disk."""

    def gap(r):
        return r**2 / 2 + 2 * A * np.sin(r / 2) ** 2

    def best_disk(d, nodes=8):
        x, w = np.polynomial.legendre.leggauss(nodes)
        cells = np.linspace(0, 20, 201)
        middle, half = (cells[1:] + cells[:-1]) / 2, (cells[1] - cells[0]) / 2
        at = middle[:, None] + half * x
        g = at**2 + np.pi / 2 * A * at * struve(0, at)
        cumulative = np.cumsum(half * (d - g) @ w)
        k = int(np.argmax(cumulative))
        fine = np.linspace(cells[max(k - 1, 0)], cells[min(k + 2, 200)], 1001)
        g_fine = fine**2 + np.pi / 2 * A * fine * struve(0, fine)
        start = cumulative[k - 2] if k > 1 else 0.0
        steps = (2 * d - g_fine[1:] - g_fine[:-1]) / 2 * np.diff(fine)
        return 2 * (start + np.concatenate(([0.0], np.cumsum(steps))).max())

    return gap, best_disk


def order(errors, numbers):
    return -np.polyfit(np.log(numbers), np.log(np.abs(errors)), 1)[0]


X = np.linspace(0.05, 0.9, 120)
NUMBERS = (50, 100, 200, 400)


@pytest.fixture(scope="module")
def hertz():
    return {n: solve_indentation(paraboloid, 1.0, 1.0, max_radius=2.0, n=n) for n in NUMBERS}


@pytest.fixture(scope="module")
def cone():
    return {n: solve_indentation(lambda r: r, 1.0, 1.0, max_radius=2.0, n=n) for n in NUMBERS}


@pytest.fixture(scope="module")
def punch():
    return {n: solve_indentation(flat, 1.0, 1.0, max_radius=1.0, edge=1.0, n=n) for n in NUMBERS}


@pytest.mark.parametrize("r", [0.0, 0.3, 0.999, 1.0000001, 1.5, 40.0])
@pytest.mark.parametrize(("inner", "outer"), [(0.0, 0.5), (0.4, 1.2), (1.0, 1.000001)])
def test_ring_displacement_is_the_integral_of_the_ring_kernel(r, inner, outer):
    def kernel(s):
        return 4 / np.pi * s / (r + s) * ellipkm1(((r - s) / (r + s)) ** 2)

    breaks = [inner, *([r] if inner < r < outer else []), outer]
    exact = sum(quad(kernel, a, b, epsabs=0, epsrel=1e-9)[0] for a, b in pairwise(breaks))
    rings = ring_displacement([r], [0.0, inner, outer] if inner else [inner, outer])
    # a difference of two disks: far from a thin ring it has the rounding of the disks
    assert rings[0, -1] == pytest.approx(exact, rel=1e-8, abs=1e-15 * max(r, outer))


def test_thin_rings_keep_their_digits():
    # Seen from the middle of a thin ring, K is ln(8 r / |r - s|): u = (2/π) w [ln(16 r/w) + 1].
    w = 1e-9
    u = ring_displacement([1.0], [1 - w / 2, 1 + w / 2])[0, 0]
    w = (1 + w / 2) - (1 - w / 2)
    assert u == pytest.approx(2 / np.pi * w * (math.log(16 / w) + 1), rel=1e-8)


def test_hertz_meets_the_gates(hertz):
    solution = hertz[400]
    assert solution.force == pytest.approx(4 / 3, rel=1e-8)
    assert solution.contact_radius == pytest.approx(1, rel=1e-7)
    assert solution.stiffness == pytest.approx(2, rel=1e-7)
    assert solution.energy == pytest.approx(8 / 15, rel=1e-7)
    assert solution.mean_pressure == pytest.approx(4 / (3 * np.pi), rel=1e-7)
    assert solution.contact_area == pytest.approx(np.pi, rel=1e-7)
    assert solution.is_disk
    assert solution.edge_amplitudes == ((0.0, 0.0),)
    p0 = 2 / np.pi
    np.testing.assert_allclose(pressure_at(solution, X), p0 * np.sqrt(1 - X**2), rtol=0, atol=5e-6 * p0)
    edge = np.linspace(0.9, 1.1, 300)
    exact = p0 * np.sqrt(np.maximum(1 - edge**2, 0))
    np.testing.assert_allclose(pressure_at(solution, edge), exact, rtol=0, atol=1e-4 * p0)


def test_cone_meets_the_gates(cone):
    solution, a = cone[400], 2 / np.pi
    assert solution.force == pytest.approx(2 / np.pi, rel=1e-7)
    assert solution.contact_radius == pytest.approx(a, rel=1e-7)
    np.testing.assert_allclose(pressure_at(solution, a * X), np.arccosh(1 / X) / 2, rtol=0, atol=5e-5)


def test_flat_punch_meets_the_gates(punch):
    solution = punch[400]
    assert solution.force == pytest.approx(2, rel=1e-7)
    assert solution.stiffness == pytest.approx(2, rel=1e-7)
    assert solution.contact_radius == 1
    assert solution.edge_amplitudes[0][1] == pytest.approx(1 / (np.pi * math.sqrt(2)), rel=1e-4)
    x = np.append(X, [0.99, 0.99999])
    np.testing.assert_allclose(pressure_at(solution, x), 1 / (np.pi * np.sqrt(1 - x**2)), rtol=1e-4)
    assert pressure_at(solution, 1.0) == math.inf
    r = np.array([1.1, 2.0, 50.0])
    np.testing.assert_allclose(displacement_at(solution, r), 2 / np.pi * np.arcsin(1 / r), rtol=1e-6)


def test_force_radius_and_energy_converge_with_the_third_order(hertz, cone, punch):
    # At n = 400 rounding does not matter yet, but the radius is held by the tolerance of its iteration.
    errors = {
        "hertz force": [hertz[n].force * 3 / 4 - 1 for n in NUMBERS],
        "hertz radius": [hertz[n].contact_radius - 1 for n in NUMBERS],
        "hertz energy": [hertz[n].energy * 15 / 8 - 1 for n in NUMBERS],
        "cone force": [cone[n].force * np.pi / 2 - 1 for n in NUMBERS],
        "flat force": [punch[n].force / 2 - 1 for n in NUMBERS],
    }
    orders = {name: order(error, NUMBERS) for name, error in errors.items()}
    assert all(2.8 < value < 3.3 for value in orders.values()), orders


def test_pressure_converges_with_the_second_order(hertz, cone, punch):
    a = 2 / np.pi
    errors = {
        "hertz": [np.abs(pressure_at(hertz[n], X) - a * np.sqrt(1 - X**2)).max() for n in NUMBERS],
        "cone": [np.abs(pressure_at(cone[n], a * X) - np.arccosh(1 / X) / 2).max() for n in NUMBERS],
        "flat": [np.abs(pressure_at(punch[n], X) - a / 2 / np.sqrt(1 - X**2)).max() for n in NUMBERS],
    }
    orders = {name: order(error, NUMBERS) for name, error in errors.items()}
    assert all(1.8 < value < 2.4 for value in orders.values()), orders


@pytest.mark.parametrize("max_radius", [1.2, 1e5])
def test_a_given_force_finds_the_depth_whatever_the_largest_radius(max_radius):
    solution = solve_force(paraboloid, 4 / 3, 1.0, max_radius=max_radius, n=100)
    assert solution.indentation == pytest.approx(1, rel=1e-7)
    assert solution.force == pytest.approx(4 / 3, rel=1e-13)


def test_sizes_and_moduli_do_not_matter():
    def relative(size, modulus):
        def gap(r):
            x = r / size
            return size * (x**2 / 2 + 30 * np.sin(x / 2) ** 2)

        s = solve_indentation(gap, 58.0 * size, modulus, max_radius=12 * size, n=60)
        t = solve_force(gap, s.force, modulus, max_radius=12 * size, n=60)
        return np.array(
            [
                s.force / (modulus * size**2),
                s.stiffness / (modulus * size),
                s.energy / (modulus * size**3),
                s.mean_pressure / modulus,
                pressure_at(s, 6.0 * size) / modulus,
                t.indentation / size,
                *(np.array(s.zones).ravel() / size),
            ]
        )

    reference = relative(1.0, 1.0)
    assert reference.size == 10  # two zones
    for size, modulus in [(1e-10, 1e12), (3e-7, 1.0), (1e3, 1e12), (7e2, 2.1e11)]:
        np.testing.assert_allclose(relative(size, modulus), reference, rtol=1e-12)


def test_concave_punch_in_full_contact():
    for d in (1.0, 1.5):
        solution = solve_indentation(concave, d, 1.0, max_radius=1.0, edge=1.0, n=200)
        assert solution.force == pytest.approx(2 * (d + 1 / 3), rel=1e-6)
    assert solution.is_disk
    assert solution.edge_amplitudes[0][1] == pytest.approx(2.5 / (np.pi * math.sqrt(2)), rel=1e-4)


def test_concave_punch_in_annular_contact_is_above_the_bound():
    force = 0.0
    for d in (-0.4, 0.0, 0.5, 0.9):
        solution = solve_indentation(concave, d, 1.0, max_radius=1.0, edge=1.0, n=60)
        ((inner, outer),) = solution.zones
        assert outer == 1
        assert inner > 0
        assert not solution.is_disk
        assert solution.force > max(force, 2 * (d + 1 / 3))
        force = solution.force
        back = solve_force(concave, force, 1.0, max_radius=1.0, edge=1.0, n=60)
        assert back.indentation == pytest.approx(d, abs=1e-11)


def test_wavy_paraboloid_with_disks_only_is_mdr():
    gap, best_disk = wavy(2.5)
    for d in (0.01, 1.0, 10.0, 58.0, 200.0):
        solution = solve_indentation(gap, d, 1.0, max_radius=20.0, n=100)
        assert solution.is_disk
        assert solution.force == pytest.approx(best_disk(d), rel=1e-5)


def test_wavy_paraboloid_with_rings_is_above_the_best_disk():
    gap, best_disk = wavy(15.0)
    counts = []
    for d in (10.0, 25.0, 58.0, 132.0, 200.0):
        solution = solve_indentation(gap, d, 1.0, max_radius=20.0, n=100)
        counts.append(len(solution.zones))
        above = solution.force / best_disk(d) - 1
        assert above > -1e-5
        assert solution.is_disk == (above < 1e-5)
    assert counts == [1, 2, 2, 3, 2]


@pytest.mark.parametrize("seed", range(6))
def test_random_profiles_obey_signorini_and_the_bound(seed):
    rng = np.random.default_rng(seed)
    k, phase = rng.uniform(1, 12, 4), rng.uniform(0, 2 * np.pi, 4)
    height = 3 * rng.normal(size=4) / k**1.5

    def gap(r):
        waves = height * (np.cos(k * r[..., None] + phase) - np.cos(phase))
        return r**2 / 2 + waves.sum(axis=-1)

    def g(x):
        kx = k * x[:, None]
        maps = -np.cos(phase) * struve(0, kx) - np.sin(phase) * j0(kx)
        return x**2 + np.pi / 2 * (height * kx * maps).sum(axis=1)

    r = np.linspace(0, 5, 1001)
    d = gap(r).min() + rng.choice([0.03, 0.3, 3.0])
    solution = solve_indentation(gap, d, 1.0, max_radius=5.0, n=100)
    assert solution.pressure.min() >= 0
    outside = ~np.any(
        [(r > a - 0.02 * (b - a)) & (r < b + 0.02 * (b - a)) for a, b in solution.zones], axis=0
    )
    assert np.all(displacement_at(solution, r[outside]) > d - gap(r[outside]))
    work = displacement_at(solution, solution.radii) - (d - gap(solution.radii))
    assert np.abs(work[solution.pressure > 0]).max() < 1e-10
    x = np.linspace(0, 5, 4001)
    middle = (x[1:] + x[:-1]) / 2
    bound = 2 * max(0.0, np.cumsum((d - g(middle)) * np.diff(x)).max())
    assert solution.force >= bound * (1 - 1e-4)
    back = solve_force(gap, solution.force, 1.0, max_radius=5.0, n=100)
    assert back.indentation == pytest.approx(d, abs=1e-7)


@pytest.mark.parametrize("rise", [1e-2, 1e-4, 1e-6])
def test_ring_indenter_touches_away_from_the_axis_and_tends_to_a_line_contact(rise):
    def gap(r):
        return (r - 1) ** 2 / 2 - 1 / 2

    solution = solve_indentation(gap, -0.5 + rise, 1.0, max_radius=2.0, n=100)
    ((inner, outer),) = solution.zones
    half = (outer - inner) / 2
    assert solution.force / (2 * np.pi) == pytest.approx(np.pi / 4 * half**2, rel=4 * half**2 + 1e-5)
    back = solve_force(gap, solution.force, 1.0, max_radius=3.0, n=100)
    assert back.indentation + 0.5 == pytest.approx(rise, rel=1e-6)


def test_flat_annulus_has_two_sharp_edges():
    # Collins 1963; Gubenko and Mossakovskii 1960: F = 2 E* b d (1 - 4 ε³/(3 π²) - ...) for a small hole.
    hole = 0.1
    solution = solve_indentation(
        lambda r: np.where(r < hole, np.nan, 0.0),
        1.0,
        1.0,
        max_radius=1.0,
        edge=1.0,
        breakpoints=[hole],
        n=200,
    )
    assert solution.zones == ((hole, 1.0),)
    assert min(solution.edge_amplitudes[0]) > 0
    assert 1 - solution.force / 2 == pytest.approx(4 * hole**3 / (3 * np.pi**2), rel=0.01)


def test_stepped_punch_has_a_sharp_and_a_free_edge():
    def gap(r):
        return np.where(r < 0.5, 0.0, 0.1)

    solution = solve_indentation(gap, 0.2, 1.0, max_radius=1.0, edge=1.0, breakpoints=[0.5], n=100)
    assert solution.zones[0] == (0.0, 0.5)
    assert solution.zones[1][1] == 1.0
    (_, first), (inner, outer) = solution.edge_amplitudes
    assert min(first, outer) > 0 == inner


def test_stiffness_and_energy_belong_to_the_force_in_ring_contact():
    gap, _ = wavy(15.0)
    low, middle, high = (solve_indentation(gap, d, 1.0, max_radius=20.0, n=100) for d in (57.9, 58.0, 58.1))
    assert (high.force - low.force) / 0.2 == pytest.approx(middle.stiffness, rel=1e-5)
    assert (high.energy - low.energy) / 0.2 == pytest.approx(middle.force, rel=1e-5)


def test_force_is_continuous_where_a_hole_closes():
    gap, _ = wavy(6.0)
    depth = 40.2617 + 1e-3 * np.linspace(-1, 1, 5)
    solutions = [solve_indentation(gap, d, 1.0, max_radius=20.0, n=100) for d in depth]
    force = np.array([s.force for s in solutions])
    rough = force - np.polyval(np.polyfit(depth - depth[2], force, 1), depth - depth[2])
    assert np.abs(rough).max() < 1e-6 * force[0]
    assert all(s.pressure.min() >= 0 for s in solutions)


@pytest.mark.parametrize(
    ("gap", "depth", "force", "energy"),
    [
        (paraboloid, lambda a: a**2, lambda a: 4 / 3 * a**3, lambda a: 8 / 15 * a**5),
        (
            lambda r: r,
            lambda a: np.pi / 2 * a,
            lambda a: np.pi / 2 * a**2,
            lambda a: np.pi**2 / 12 * a**3,
        ),
        (flat, lambda a: 0.0, lambda a: 0.0, lambda a: 0.0),
    ],
)
@pytest.mark.parametrize("work", [0.0, 0.05])
def test_adhesive_disk_is_that_of_johnson_kendall_and_roberts(gap, depth, force, energy, work):
    # d = d0 + w, F = F0 + 2 a w, U = U0 + F0 w + a w² with w = -√(2 π a γ), E* = 1
    a = 0.3
    w = -math.sqrt(2 * np.pi * a * work)
    computed = solve_adhesion(gap, a, work, 1.0, n=200)
    exact = depth(a) + w, force(a) + 2 * a * w, energy(a) + force(a) * w + a * w**2
    sizes = np.array([0.3, 0.1, 0.02])
    numbers = np.array([computed.indentation, computed.force, computed.energy])
    np.testing.assert_allclose(numbers / sizes, np.array(exact) / sizes, rtol=0, atol=1e-6)
    assert computed.stiffness == pytest.approx(2 * a, rel=1e-6)
    if work:
        assert computed.edge_amplitudes[0][1] == pytest.approx(-math.sqrt(work / np.pi), rel=1e-5)
        r = a * np.array([0.1, 0.5, 0.8])
        pull = w / np.pi / np.sqrt(a**2 - r**2)
        whole = solve_adhesion(gap, a, 0.0, 1.0, n=200)
        np.testing.assert_allclose(
            pressure_at(computed, r), pressure_at(whole, r) + pull, rtol=2e-4, atol=2e-5
        )
        assert pressure_at(computed, a) == -math.inf
        outside = displacement_at(computed, 2 * a) - displacement_at(whole, 2 * a)
        assert outside == pytest.approx(2 / np.pi * w * math.asin(0.5), rel=1e-5)


def test_adhesion_is_checked():
    with pytest.raises(ProblemError, match="work of adhesion"):
        solve_adhesion(paraboloid, 0.3, -1.0, 1.0)
    with pytest.raises(ProblemError, match="within the contact radius"):
        solve_adhesion(lambda r: np.where(r < 0.2, 0.0, np.nan), 0.3, 1.0, 1.0)


def test_no_contact():
    solution = solve_indentation(paraboloid, -1.0, 1.0, max_radius=1.0)
    assert solution.zones == ()
    assert solution.force == solution.contact_radius == solution.mean_pressure == solution.energy == 0
    assert not solution.is_disk
    assert pressure_at(solution, 0.5) == displacement_at(solution, 0.5) == 0


def test_solution_is_frozen(hertz):
    with pytest.raises(ValueError, match="read-only"):
        hertz[50].pressure[0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        hertz[50].force = 1.0


@pytest.mark.parametrize("n", [19, 5001, 30.0, True, "40"])
def test_number_of_rings_is_checked(n):
    with pytest.raises(ProblemError, match="20 to 5000"):
        Rings(n)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"modulus": 0.0}, "modulus"),
        ({"modulus": math.nan}, "modulus"),
        ({"max_radius": -1.0}, "max_radius"),
        ({"edge": 0.0}, "edge"),
        ({"indentation": math.inf}, "indentation"),
        ({"breakpoints": [-1.0]}, "not negative"),
        ({"gap": lambda r: 0.0}, "one height for each radius"),
        ({"gap": lambda r: -np.inf + r}, "-inf"),
        ({"max_radius": 0.5}, "larger max_radius"),
        ({"gap": lambda r: np.where(r < 0.5, r**2 / 2, np.nan)}, "end of the gap"),
    ],
)
def test_bad_input_is_named(changed, words):
    given = {"gap": paraboloid, "indentation": 1.0, "modulus": 1.0, "max_radius": 2.0, "n": 50} | changed
    with pytest.raises(ProblemError, match=words):
        solve_indentation(**given)


def test_force_must_be_carried():
    with pytest.raises(ProblemError, match="positive finite number of newtons"):
        solve_force(paraboloid, 0.0, 1.0, max_radius=1.0)
    with pytest.raises(ProblemError, match="no finite value"):
        solve_force(lambda r: r + np.inf, 1.0, 1.0, max_radius=1.0)
    with pytest.raises(ProblemError, match="larger max_radius"):
        solve_force(paraboloid, 10.0, 1.0, max_radius=1.0)


def test_radii_are_checked(hertz):
    for wrong in (-1.0, math.nan):
        with pytest.raises(ProblemError, match="Radii"):
            pressure_at(hertz[50], wrong)
    with pytest.raises(ProblemError, match="increasing edges"):
        ring_displacement([0.0], [1.0, 1.0])


def test_unsettled_zones_are_an_error_that_holds_the_last_iterate():
    with pytest.raises(ConvergenceError, match=r"0 m to 500 mm, 86.* at d = 200 mm.*breakpoints"):
        solve_indentation(lambda r: np.where(r < 0.5, 0.0, 0.1), 0.2, 1.0, max_radius=1.0, edge=1.0, n=60)
