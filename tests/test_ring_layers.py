"""Layers under the rings against closed forms, waves in extended precision, published tables, and what must hold of any stack."""

import math
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import j0, j1

from common import REFERENCES
from drawing import examples
from pymdr.errors import ProblemError
from pymdr.independent.history import solve_steps
from pymdr.independent.rings import (
    Rings,
    displacement_at,
    ring_displacement,
    solve_adhesion,
    solve_force,
    solve_indentation,
)
from pymdr.independent.stacks import Stack
from pymdr.problem.profiles import Cone, Paraboloid

LAYERS = {entry["id"]: entry for entry in REFERENCES if entry["topic"] == "12 layer"}
POISSON = st.one_of(st.just(0.5), st.floats(-0.9, 0.5))


def single(thickness=1.0, poisson=0.5, bonded=True):
    return Stack((thickness,), (1.0, math.inf), (poisson, 0.3), (bonded,))


def of_reference(name):
    if "nu" in name:
        return single(poisson=float(name.split("nu")[1]))
    return single(poisson=0.3, bonded=False)


def flat(r):
    return 0 * r


def paraboloid(r):
    return r**2 / 2


@st.composite
def stacks(draw, most=3, moduli=4.0, thicknesses=2.0):
    n = draw(st.integers(1, most))
    decades = st.floats(-moduli, moduli)
    young = [10.0 ** draw(decades) for _ in range(n)]
    base = draw(st.one_of(st.just(math.inf), decades.map(lambda x: 10.0**x)))
    thickness = [1.0, *(10.0 ** draw(st.floats(-thicknesses, thicknesses)) for _ in range(n - 1))]
    return Stack(
        tuple(thickness),
        (*young, base),
        tuple(draw(POISSON) for _ in range(n + 1)),
        tuple(draw(st.booleans()) for _ in range(n)),
    )


def waves(z, kappa, shear):
    """Along, out, shear and normal traction of the four waves of a layer at z over 1/q: Muskhelishvili 1953, section 93."""
    results = []
    for sign in (1, -1):
        y, size = sign * z, mp.exp(sign * z)
        results.append((1, -sign, 2 * sign * shear, -2 * shear))
        results.append(
            (y, sign * (kappa - y), sign * shear * (1 - kappa + 2 * y), shear * (kappa + 1 - 2 * y))
        )
        results[-2:] = [[size * x for x in wave] for wave in results[-2:]]
    return results


def compliance_by_all_waves_at_once(stack, q):
    """L from one system of all waves, in so many digits that no growing one matters."""
    n, q = len(stack.thickness), mp.mpf(q)
    shear = [mp.mpf(e) / (2 * (1 + mp.mpf(v))) for e, v in zip(stack.young, stack.poisson, strict=True)]
    kappa = [3 - 4 * mp.mpf(v) for v in stack.poisson]
    tops = [waves(mp.mpf(0), k, mu) for k, mu in zip(kappa[:n], shear[:n], strict=True)]
    tops.append([] if mp.isinf(shear[n]) else waves(mp.mpf(0), kappa[n], shear[n])[:2])
    rows = [(0, None, 2), (0, None, 3)]
    bottoms = [waves(-q * mp.mpf(h), k, mu) for h, k, mu in zip(stack.thickness, kappa, shear, strict=False)]
    for i, bonded in enumerate(stack.bonded):
        rows += [(i, i, 1), (i, i, 0)] if bonded else [(i, i, 1), (None, i, 2)]
        if tops[i + 1]:
            rows += [(i, i, 2), (i, i, 3)] if bonded else [(i + 1, None, 2), (i, i, 3)]
    system = mp.zeros(4 * n + len(tops[n]))
    for row, (above, below, part) in enumerate(rows):
        if below is None:
            for j, wave in enumerate(tops[above]):
                system[row, 4 * above + j] = wave[part]
            continue
        for j, wave in enumerate(bottoms[below]):
            system[row, 4 * below + j] = wave[part]
        for j, wave in enumerate(tops[below + 1] if above is not None else []):
            system[row, 4 * below + 4 + j] = -wave[part]
    load = mp.zeros(system.rows, 1)
    load[1] = shear[0]
    x = mp.lu_solve(system, load)
    return 4 / (kappa[0] + 1) * sum(x[j] * wave[1] for j, wave in enumerate(tops[0]))


@given(st.floats(-6, 3), POISSON)
@settings(max_examples=examples(60), deadline=None)
def test_compliance_of_one_layer_is_the_closed_form(exponent, poisson):
    q = 10.0**exponent
    with mp.workdps(60):
        s, k = mp.mpf(q), 3 - 4 * mp.mpf(poisson)
        bonded = (2 * k * mp.sinh(2 * s) - 4 * s) / (2 * k * mp.cosh(2 * s) + 1 + k**2 + 4 * s**2)
        sliding = (mp.cosh(2 * s) - 1) / (mp.sinh(2 * s) + 2 * s)
    assert single(1.0, poisson).compliance(q)[0] == pytest.approx(float(bonded), rel=1e-13)
    assert single(1.0, poisson, bonded=False).compliance(q)[0] == pytest.approx(float(sliding), rel=1e-13)


@given(stacks(), st.floats(-6, 1.5))
@settings(max_examples=examples(25), deadline=None)
def test_compliance_of_a_stack_is_that_of_all_its_waves(stack, exponent):
    q = 10.0**exponent / max(stack.thickness)
    with mp.workdps(150):
        exact = float(compliance_by_all_waves_at_once(stack, q))
    assert stack.compliance(q)[0] == pytest.approx(exact, rel=1e-12)


@given(st.floats(-6, 3), POISSON, st.floats(0.01, 0.99), st.booleans())
@settings(max_examples=examples(40), deadline=None)
def test_what_is_cut_and_bonded_is_whole(exponent, poisson, fraction, bonded):
    q, half = 10.0**exponent, (fraction, 1.0 - fraction)
    whole = Stack((1.0,), (1.0, 7.0), (poisson, 0.2), (bonded,)).compliance(q)
    cut = Stack(half, (1.0, 1.0, 7.0), (poisson, poisson, 0.2), (True, bonded)).compliance(q)
    assert cut == pytest.approx(whole, rel=1e-12)
    same = Stack(half, (2.0,) * 3, (poisson,) * 3, (True, True)).compliance(q)
    assert same == pytest.approx(1.0, rel=1e-12)
    stiff = Stack((1.0,), (1.0, 1e14), (poisson, 0.2), (bonded,)).compliance(max(q, 0.1))
    assert stiff == pytest.approx(single(1.0, poisson, bonded).compliance(max(q, 0.1)), rel=1e-8)


@pytest.mark.parametrize("r", [0.0, 0.7, 3.0])
def test_displacement_is_the_hankel_integral(r):
    stack, edges = Stack((0.3,), (1.0, 0.02), (0.3, 0.45), (True,)), np.array([0.0, 0.4, 1.1])
    x, w = np.polynomial.legendre.leggauss(20)
    low = np.concatenate(([0.0], np.geomspace(1e-6, 1.0, 80), np.linspace(1.0, 100.0, 200)[1:]))
    q = (low[:-1, None] + np.diff(low)[:, None] * (x + 1) / 2).ravel()
    w = (np.diff(low)[:, None] * w / 2).ravel()
    disks = edges * j1(q[:, None] * edges)
    soft = (2 * w * (stack.compliance(q) - 1) * j0(q * r) / q) @ np.diff(disks, axis=1)
    assert stack.displacement([r], edges)[0] == pytest.approx(
        soft + ring_displacement([r], edges)[0], rel=1e-12
    )


@pytest.mark.parametrize("name", [name for name in LAYERS if "flat" in name])
def test_flat_punch_on_a_layer(name):
    for a, kappa in zip(LAYERS[name]["inputs"]["a_over_h"], LAYERS[name]["expected"]["kappa"], strict=True):
        if a <= 5:
            result = solve_indentation(flat, 1.0, 1.0, max_radius=a, edge=a, n=60, surface=of_reference(name))
            assert result.force / (2 * a) == pytest.approx(kappa, rel=2e-5)
            assert result.stiffness == pytest.approx(result.force, rel=1e-12)


def test_flat_punch_on_a_thin_incompressible_layer_gets_a_third_order_closer():
    exact = LAYERS["hayes_flat_nu0.5"]["expected"]["kappa"][-1]
    errors = [
        solve_indentation(flat, 1.0, 1.0, max_radius=8, edge=8, n=n, surface=single()).force / 16 / exact - 1
        for n in (60, 120, 240)
    ]
    assert abs(errors[-1]) < 1e-6
    assert all(2.7 < math.log2(a / b) < 3.5 for a, b in pairwise(errors))


@pytest.mark.parametrize("name", [name for name in LAYERS if "hayes" in name])
def test_published_table_is_below_by_what_is_known(name):
    # Hayes et al. 1972, table 1: its digits fall behind with a/h, by 0.3 % at 1, 0.9 % at 2 and 5.9 % at 8 if incompressible.
    entry = LAYERS[name]
    ratio, published = np.array(entry["inputs"]["a_over_h"]), np.array(entry["expected"]["hayes_table"])
    for a, printed in zip(ratio, published, strict=True):
        result = solve_indentation(flat, 1.0, 1.0, max_radius=a, edge=a, n=60, surface=of_reference(name))
        behind = 1 - printed / (result.force / (2 * a))
        most = next(
            error for end, error in ((0.4, 5e-4), (1, 3e-3), (2, 1e-2), (4, 0.03), (8, 0.06)) if a <= end
        )
        assert -5e-4 < behind < most


@pytest.mark.parametrize("name", [name for name in LAYERS if "parab" in name])
def test_paraboloid_on_a_layer(name):
    inputs, expected = LAYERS[name]["inputs"], LAYERS[name]["expected"]
    for a, d, f in list(
        zip(inputs["a_over_h"], expected["dR_over_a2"], expected["F_over_FHertz_a"], strict=True)
    )[1::2]:
        computed = solve_indentation(
            paraboloid, d * a**2, 1.0, max_radius=3 * a, n=60, surface=of_reference(name)
        )
        assert computed.force == pytest.approx(f * 4 / 3 * a**3, rel=2e-6)
        assert computed.contact_radius == pytest.approx(a, rel=2e-6)


def test_thin_layers_are_winklers_or_squeezed_films():
    a, poisson = 16.0, 0.5
    squeezed = solve_indentation(flat, 1.0, 1.0, max_radius=a, edge=a, n=240, surface=single()).force / (
        2 * a
    )
    assert squeezed == pytest.approx(3 * math.pi / 64 * (a + 1.459) ** 4 / a, rel=2e-3)
    a, poisson = 60.0, 0.25
    springs = (1 - poisson) ** 2 / (1 - 2 * poisson)  # 2 G (1 - ν)/((1 - 2 ν) h) over E*
    thin = solve_indentation(flat, 1.0, 1.0, max_radius=a, edge=a, n=240, surface=single(1.0, poisson))
    assert thin.force == pytest.approx(springs * math.pi * a**2, rel=1.5 / a)


@given(stacks(moduli=2.0, thicknesses=1.0), st.floats(-2, 1), st.floats(1.0, 5.0))
@settings(max_examples=8, deadline=None)
def test_contact_with_a_stack_obeys_signorini_and_virtual_work(stack, exponent, power):
    a = 10.0**exponent

    def gap(r):
        return a * (r / a) ** power

    depths = np.array([0.499, 0.5, 0.501]) * a
    low, middle, high = (
        solve_indentation(gap, d, 1.0, max_radius=6 * a, n=60, surface=stack) for d in depths
    )
    slope = (high.force - low.force) / (depths[2] - depths[0])
    assert slope == pytest.approx(middle.stiffness, rel=1e-4)
    assert (high.energy - low.energy) / (depths[2] - depths[0]) == pytest.approx(middle.force, rel=1e-4)
    assert middle.pressure.min() >= 0
    r = middle.contact_radius
    punch = solve_indentation(flat, 1.0, 1.0, max_radius=r, edge=r, n=60, surface=stack)
    if punch.is_disk and middle.is_disk:
        assert punch.force == pytest.approx(middle.stiffness, rel=1e-4)
    nearby = r * np.array([1.05, 1.2, 1.5, 2.0, 3.0])
    assert np.all(displacement_at(middle, nearby) > depths[1] - gap(nearby))
    back = solve_force(gap, middle.force, 1.0, max_radius=6 * a, n=60, surface=stack)
    assert back.indentation == pytest.approx(depths[1], rel=1e-6)


def test_incompressible_layers_bulge_into_contact():
    # Of an incompressible layer what sinks must rise: the radius tends to √(4 R d), where a half-space has √(R d).
    surface, depth = single(0.1), np.array([1.0])
    result = solve_indentation(paraboloid, 1.0, 1.0, max_radius=5.0, n=40, surface=surface)
    assert 1.85 < result.contact_radius < 2.0
    (by_depth,) = solve_steps(Paraboloid(1.0), 1.0, depth, False, Rings(40), surface)
    assert by_depth.force == pytest.approx(result.force, rel=1e-7)
    (by_force,) = solve_steps(Paraboloid(1.0), 1.0, depth * result.force, True, Rings(40), surface)
    assert by_force.indentation == pytest.approx(1.0, rel=1e-6)


def test_a_stiff_coating_lifts_off_the_middle_of_a_blunt_tip():
    # Like a plate it would have to be pulled into a cubic shape: contact is a ring, as under a flat punch.
    stack = Stack((1.0,), (1.0, 0.01), (0.5, 0.5), (False,))
    cubic = solve_indentation(lambda r: r**3 / 100, 5.0, 1.0, max_radius=20.0, n=60, surface=stack)
    assert cubic.zones[0][0] > 2.0
    round_tip = solve_indentation(lambda r: r**2 / 10, 5.0, 1.0, max_radius=20.0, n=60, surface=stack)
    assert round_tip.is_disk
    punch = solve_indentation(flat, 1.0, 1.0, max_radius=3.0, edge=3.0, n=60, surface=stack)
    assert punch.zones[0][0] > 0.0
    r = np.linspace(0.0, 0.98 * cubic.zones[0][0], 50)
    assert np.all(displacement_at(cubic, r) > 5.0 - r**3 / 100)


@given(stacks(moduli=2.0, thicknesses=1.0), st.floats(-1, 0.5), st.floats(0.01, 1.0))
@example(Stack((1.0, 1.0), (100.0, 1.0, 1.0), (0.5, 0.5, 0.5), (False, False)), -0.28125, 0.01953125)
@settings(max_examples=6, deadline=None)
def test_adhesion_on_a_stack_balances_the_energy_of_the_edge(stack, exponent, strength):
    # Along the curve of equilibria dU = F dd + 2 π a w da, whatever the body; Griffith 1921.
    a = 10.0**exponent
    work = strength * a
    states = [
        solve_adhesion(paraboloid, a * x, work, 1.0, n=100, surface=stack)
        for x in (0.98, 0.99, 1.0, 1.01, 1.02)
    ]
    # of fourth order: over a layer that hardly bears, energies bend much within a hundredth of the radius
    rates = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (0.12 * a)
    gained = rates @ [state.energy for state in states]
    pushed = states[2].force * (rates @ [state.indentation for state in states])
    opened = 2 * math.pi * a * work
    size = abs(gained) + abs(pushed) + opened
    assert gained - pushed - opened == pytest.approx(0.0, abs=1e-3 * size)


def test_coatings_at_both_ends_of_the_modulus_ratio():
    # Thick against the contact the layer is all there is, thin the base; the cone has no length of its own.
    for ratio, h, modulus, within in (
        (1e-4, 1e9, 1.0, 1e-5),
        (1e4, 1e9, 1.0, 1e-5),
        (0.5, 5e-3, 0.5, 2e-2),
        (2.0, 5e-3, 2.0, 2e-2),
    ):
        stack = Stack((h,), (1.0, ratio), (0.3, 0.3), (True,))
        (result,) = solve_steps(Cone(slope=1.0), 1.0, np.array([1.0]), False, Rings(40), stack)
        assert result.force == pytest.approx(modulus * 2 / math.pi, rel=within)


def test_sizes_do_not_matter():
    def relative(size):
        stack = Stack((0.4 * size, 0.3 * size), (1.0, 50.0, 3.0), (0.5, 0.3, 0.2), (True, False))
        result = solve_indentation(
            lambda r: r**2 / (2 * size), 0.5 * size, 1.0, max_radius=2 * size, n=40, surface=stack
        )
        return result.force / size**2, result.contact_radius / size, result.energy / size**3

    for size in (1e-9, 3e4):
        np.testing.assert_allclose(relative(size), relative(1.0), rtol=1e-9)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"thickness": ()}, "at least 1"),
        ({"bonded": (True, True)}, "2 interfaces"),
        ({"thickness": (0.0,)}, "positive"),
        ({"young": (math.inf, 1.0)}, "layers finite"),
        ({"young": (1.0, -1.0)}, "positive"),
        ({"poisson": (0.51, 0.3)}, "0.5"),
        ({"poisson": (math.nan, 0.3)}, "0.5"),
    ],
)
def test_bad_stacks_are_named(changed, words):
    given = {"thickness": (1.0,), "young": (1.0, 1.0), "poisson": (0.3, 0.3), "bonded": (True,)}
    with pytest.raises(ProblemError, match=words):
        Stack(**(given | changed))


def test_layers_too_thin_for_the_rings_are_refused():
    with pytest.raises(ProblemError, match="thicker layer"):
        single(1e-6).displacement([0.5], [0.0, 1.0])
