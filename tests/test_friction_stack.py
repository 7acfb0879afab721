"""The memory stack: references, energy, invariance, limits and the springs of the teaching form."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from drawing import examples
from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.line.friction import (
    Ending,
    cattaneo_mindlin,
    depths_at_force,
    evaluate,
    follow_displacements,
    follow_forces,
    follow_indentation_with_force,
    follow_load_with_shift,
    loop_energy,
    power_law_curves,
    shift_ratio_at,
    spring_shifts,
    springs,
    superposition,
    tabulated_curves,
    virgin_state,
)

HERTZ = power_law_curves(2.0, 1.0, 1.0)
POWERS = {n: power_law_curves(n, 1.0, 1.0) for n in (1.0, 1.5, 2.0, 4.0)}
TABLES = {
    "mixed": tabulated_curves(lambda d: np.sqrt(d) / (1.0 + 0.3 * d) + 0.2 * d**2, 1.0, 1.0),
    "kink": tabulated_curves(lambda d: np.where(d < 0.3, np.sqrt(d), 0.3**0.5 + 0.2 * (d - 0.3)), 1.0, 1.0),
    "flat tip": tabulated_curves(lambda d: 0.3 + d, 1.0, 1.0),
    "marks": tabulated_curves(
        lambda d: np.sqrt(d) + np.cbrt(np.maximum(d - 0.3, 0.0)) ** 2 + np.maximum(d - 0.6, 0.0) ** 1.5,
        1.0,
        1.0,
        marks=(0.3, 0.6),
    ),
}
KINKS = {"kink": (0.3,), "marks": (0.3, 0.6)}
CURVES = {**POWERS, **TABLES}

# histories in the units of the largest depth; values that meet again (repeated, on the edge of the cone) included
depth = st.one_of(st.floats(0.01, 1.0), st.sampled_from([0.25, 0.5, 1.0]))
separated = st.floats(-0.3, -0.01)
shift = st.one_of(st.floats(1e-4, 1.5), st.floats(-1.5, -1e-4), st.sampled_from([-0.5, 0.0, 0.25, 0.5]))
rows = st.lists(st.tuples(depth, shift), min_size=1, max_size=12)
rows_with_loss = st.lists(st.tuples(st.one_of(depth, depth, separated), shift), min_size=1, max_size=12)
curve_names = st.sampled_from(list(CURVES))
frictions = st.sampled_from([0.3, 1.0, np.inf])
few = settings(max_examples=examples(40), deadline=None)


def columns(history):
    return np.array(history, dtype=float).T.copy()


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / exact - 1.0)))


def substeps(values, m):
    """Every straight step from the row before (at first from 0) in m equal parts."""
    before = np.concatenate([[0.0], values[:-1]])
    fine = before[:, None] + (values - before)[:, None] * np.arange(1, m + 1) / m
    fine[:, -1] = values
    return fine.ravel()


def close(a, b, tolerance, scale=None):
    scale = np.max(np.abs(a)) if scale is None else scale
    return np.all(np.abs(np.asarray(a) - b) <= tolerance * scale)


def sizes(curves, d, u, mu, tangential):
    """A force and an energy of the size of the history: its largest, but not below 1e-3 of what it could hold."""
    d = np.append(d, 0.01)
    a, force, _ = (float(x) for x in evaluate(curves, np.max(d)))
    u_max = max(np.max(np.abs(u)), 1e-9)
    if not np.isfinite(mu):
        return 2.0 * tangential * a * u_max, tangential * a * u_max**2
    u_max = max(u_max, 1e-3 * mu * curves.modulus / tangential * np.max(d))
    return mu * force, mu * force * u_max


# --- references -------------------------------------------------------------------------------------------------


def test_reference_history(references):
    entry, losses = references["tang_history_parab"], references["tang_dissipation"]
    run = follow_displacements(HERTZ, *columns(entry["inputs"]["history"]), 1.0, 1.0)
    np.testing.assert_allclose(run.tangential_force, entry["expected"]["Fx"], rtol=entry["rtol"])
    expected = losses["expected"]
    scale = max(expected["D_cum"])
    assert close(run.slip_work, expected["D_cum"], losses["rtol"], scale)
    np.testing.assert_allclose(run.stored_energy[-1], expected["U_t_end"], rtol=losses["rtol"])


@pytest.mark.parametrize(
    ("name", "exponent"), [("cm_parab_0.25", 2.0), ("cm_parab_0.5", 2.0), ("cm_power_1", 1.0)]
)
@pytest.mark.parametrize("mu", [0.3, 1.0])
def test_reference_partial_slip(references, name, exponent, mu):
    entry = references[name]
    ratio, expected = entry["inputs"]["lam"], entry["expected"]
    curves = power_law_curves(exponent, 0.7, 2.0)
    d, tangential = 0.3, 1.5
    u_s = mu * curves.modulus / tangential * d
    a, force, _ = (float(x) for x in evaluate(curves, d))
    u = ratio * u_s
    run = follow_displacements(curves, [d] * 6, [0.0, u, -u, u, -u, u], mu, tangential)
    assert run.tangential_force[1] / (mu * force) == pytest.approx(
        expected["Fx_over_muFN"], rel=entry["rtol"]
    )
    assert run.stick_radius[1] / a == pytest.approx(expected["c_over_a"], rel=entry["rtol"])
    loop = (run.slip_work[5] - run.slip_work[3]) / (mu * force * u_s)
    assert loop == pytest.approx(expected["loop_W_over_muFN_us"], rel=entry["rtol"])
    assert loop == pytest.approx(float(loop_energy(ratio, exponent)), rel=1e-12)


def test_mindlin_deresiewicz_loop():
    mu, tangential, d = 0.4, 0.8, 0.49
    a, force, _ = (float(x) for x in evaluate(HERTZ, d))
    for t in (0.1, 0.5, 0.9, 1.0):
        q = t * mu * force
        run = follow_forces(HERTZ, [force] * 4, [q, -q, q, -q], mu, tangential)
        bracket = 1.0 - (1.0 - t) ** (5 / 3) - 5 * t / 6 * (1.0 + (1.0 - t) ** (2 / 3))
        expected = 9 * mu**2 * force**2 / (10 * a) * 4 / tangential * bracket
        assert run.slip_work[3] - run.slip_work[1] == pytest.approx(expected, rel=1e-11)
        assert run.slip_distance[-1] == 0.0


def slid_on_a_power_law(exponent, fraction):
    """Slip work of the first partial slip, over mu F_N times the shift, by quadrature without a difference."""
    v, weights = np.polynomial.legendre.leggauss(40)
    v = 0.5 * (v + 1.0)
    # W = 2 mu E s^3 / kappa^2 int_0^1 v (1 - v) a'(d - s v / kappa) dv for a = d^(1/n)
    bend = (1.0 - fraction * v) ** (1.0 / exponent - 1.0)
    return fraction**2 * (1.0 + exponent) / exponent**2 * float(v * (1.0 - v) * bend @ (0.5 * weights))


@pytest.mark.parametrize("tabulated", [False, True])
@settings(max_examples=examples(60), deadline=None)
@given(st.floats(0.6, 5.0), st.floats(-10.0, -0.5), st.floats(0.05, 1.0), st.integers(0, 4), st.booleans())
def test_slip_far_smaller_than_the_depth(tabulated, n, decades, d, turns, by_force):
    mu, tangential, fraction = 0.4, 0.8, 10.0**decades
    curves = (
        tabulated_curves(lambda d: d ** (1.0 / n), 1.0, 1.0) if tabulated else power_law_curves(n, 1.0, 1.0)
    )
    _, force, _ = (float(x) for x in evaluate(curves, d))
    slides = mu * d / tangential
    # first pressed, then to and fro
    signs = np.append(0.0, np.cumprod(np.append(1.0, -np.ones(turns))))
    if by_force:
        # 1 - (1 - share)^m without the difference
        pull = -np.expm1((1.0 + 1.0 / n) * np.log1p(-fraction))
        run = follow_forces(curves, np.full(signs.size, force), mu * force * pull * signs, mu, tangential)
    else:
        run = follow_displacements(curves, np.full(signs.size, d), slides * fraction * signs, mu, tangential)
    once = slid_on_a_power_law(n, fraction) * mu * force * slides * fraction
    # every turn slips the same springs back, twice as far
    exact = once * (2.0 * np.arange(signs.size) - 1.0)
    assert np.all(np.diff(run.slip_work) >= 0.0)
    assert (
        worst(run.slip_work[1:], exact[1:]) < (1e-5 if tabulated and by_force else 2e-10) + 1e-14 / fraction
    )
    assert (
        worst(run.stored_energy[1], 0.5 * run.tangential_force[1] * slides * fraction)
        < fraction + 1e-14 / fraction
    )


@given(st.floats(0.01, 1.0), st.floats(0.5, 6.0))
def test_closed_forms(ratio, exponent):
    force, stick = (float(x) for x in cattaneo_mindlin(ratio, exponent))
    assert float(shift_ratio_at(force, exponent)) == pytest.approx(ratio, rel=1e-8)
    assert stick ** (exponent + 1.0) == pytest.approx(1.0 - force, abs=1e-14)
    m = (exponent + 1.0) / exponent
    terms = 8 * (ratio - (1 - (1 - ratio) ** (m + 1)) / (m + 1)), 4 * ratio * force
    assert float(loop_energy(ratio, exponent)) == pytest.approx(terms[0] - terms[1], abs=1e-14)
    small = 1e-5  # 8 int F du - 4 F u tends to (2/3) m (m - 1) l^3
    assert float(loop_energy(small, exponent)) == pytest.approx(2 / 3 * m * (m - 1) * small**3, rel=1e-4)
    tiny = 4.0 * slid_on_a_power_law(exponent, small) * small
    assert float(loop_energy(small, exponent)) == pytest.approx(tiny, rel=1e-13, abs=0.0)


@pytest.mark.parametrize("curves", CURVES.values(), ids=str)
def test_oblique_full_stick(curves):
    d = np.linspace(0.02, 0.9, 40)
    run = follow_displacements(curves, d, 0.35 * d, 0.5, 0.8)
    a, force, _ = evaluate(curves, d)
    np.testing.assert_allclose(run.tangential_force, 0.8 / curves.modulus * 0.35 * force, rtol=1e-12)
    # kernels fuse products and sums where NumPy rounds both
    np.testing.assert_allclose(run.stick_radius, a, rtol=2e-15, atol=0.0)
    assert np.all(run.slip_work == 0.0)
    assert run.state.y.size == 2


# --- energy -----------------------------------------------------------------------------------------------------

NODES, WEIGHTS = np.polynomial.legendre.leggauss(30)
NODES, WEIGHTS = 0.5 + 0.5 * NODES, 0.5 * WEIGHTS
CLUSTERED = NODES**4 * (35 - 84 * NODES + 70 * NODES**2 - 20 * NODES**3)
CLUSTERED_RATE = 140 * NODES**3 * (1.0 - NODES) ** 3


def kinks_of(state, dd, dv, kinks):
    """Times in [0, 1] of a step at which F_x(t) may bend: a border of slip or of contact meets a vertex."""
    y, b, slope = state.y, state.b, state.slope
    if y.size > 1:
        for kink in kinks:
            if kink < y[-1] and kink not in y:
                i = np.searchsorted(y, kink)
                b = np.insert(b, i, b[i - 1] + slope[i - 1] * (kink - y[i - 1]))
                slope = np.insert(slope, i, slope[i - 1])
                y = np.insert(y, i, kink)
    v, d = (state.b[-1], state.indentation)
    times = [np.array([0.0, 1.0])]
    for side in (1.0, -1.0):
        rate = side * dv - dd
        if rate != 0.0:
            times.append(((side * b - y) - (side * v - d)) / rate)
    if dd != 0.0:
        times.append((np.concatenate([y, kinks]) - d) / dd)
        lag = v + dv / dd * (y - d) - b
        for i in range(y.size - 1):
            if lag[i] * lag[i + 1] < 0.0:
                cross = y[i] + (y[i + 1] - y[i]) * lag[i] / (lag[i] - lag[i + 1])
                times.append(np.array([(cross - d) / dd]))
    times = np.unique(np.concatenate(times))
    return times[(times >= 0.0) & (times <= 1.0)]


def work_done(curves, run, kinks, tangential):
    """int F_x du by quadrature of the force alone, piece by smooth piece."""
    start = virgin_state(run.state.friction, run.state.modulus_ratio)
    total = []
    for row in run.rows:
        d, u = run.indentation[row], run.shift[row]
        dd, du = d - start.indentation, u - start.shift
        parts = np.array(list(pairwise(kinks_of(start, dd, du / start.shift_scale, kinks))))
        span = parts[:, 1:] - parts[:, :1]
        t = (parts[:, :1] + span * CLUSTERED).ravel()
        fine = follow_displacements(
            curves, start.indentation + dd * t, start.shift + du * t, start.friction, tangential, start=start
        )
        total.append(du * np.dot((span * WEIGHTS * CLUSTERED_RATE).ravel(), fine.tangential_force))
        start = run.checkpoints[row]
    return np.cumsum(total)


@settings(max_examples=examples(25), deadline=None)
@given(curve_names, rows, frictions)
def test_energy_balance_with_independent_slip_work(name, history, mu):
    curves, (d, u) = CURVES[name], columns(history)
    run = follow_displacements(curves, d, u, mu, 0.8, checkpoints=range(d.size))
    work = work_done(curves, run, np.array(KINKS.get(name, ())), 0.8)
    scale = max(np.abs(work).max(), run.stored_energy.max())
    assert close(run.stored_energy + run.slip_work, work, 1e-11, scale)
    assert np.all(np.diff(run.slip_work, prepend=0.0) >= -1e-13 * scale)
    assert np.all(run.stored_energy >= -1e-13 * scale)


def test_repeated_cycles_repeat():
    """Memory is wiped out at every return: the same states, and no vertex more, cycle after cycle."""
    amplitude = 0.3 * 0.1 * np.array([1.0, -1.0] * 50)
    for d, swing in ((np.full(100, 0.7), amplitude), (np.full(100, 0.7), 7.0 * amplitude)):
        run = follow_displacements(HERTZ, d, swing, 0.1, 0.8, checkpoints=range(100))
        assert run.state.y.size <= 4
        assert max(np.ptp(run.stick_radius[2::2]), np.ptp(run.stick_radius[3::2])) <= 1e-12
        forces = follow_forces(HERTZ, evaluate(HERTZ, d)[1], run.tangential_force, 0.1, 0.8)
        assert forces.state.y.size <= 4
        assert np.ptp(run.slip_work_steps[2:]) <= 1e-11 * run.slip_work[3]


def test_separating_springs_count():
    """Unloading at rest in shift: without the springs that part, the loss is too low: Popov and Hess (2015), chapter 5."""
    run = follow_displacements(HERTZ, [1.0, 1.0, 0.3], [0.0, 0.6, 0.6], 1.0, 1.0)
    x = (np.arange(200_000) + 0.5) / 200_000
    check = springs(x**2, 1 / 200_000, run.indentation, run.shift, 1.0, 1.0, 1.0)
    np.testing.assert_allclose(run.slip_work, check.slip_work, rtol=1e-8)


# --- invariance -------------------------------------------------------------------------------------------------


@few
@given(curve_names, rows_with_loss, frictions, st.integers(2, 37))
def test_substeps_of_displacements(name, history, mu, m):
    d, u = columns(history)
    coarse = follow_displacements(CURVES[name], d, u, mu, 0.8)
    fine = follow_displacements(CURVES[name], substeps(d, m), substeps(u, m), mu, 0.8, keep=m)
    force, energy = sizes(CURVES[name], d, u, mu, 0.8)
    assert close(coarse.tangential_force, fine.tangential_force, 1e-13, force)
    assert close(coarse.stored_energy, fine.stored_energy, 1e-13, energy)
    assert close(coarse.slip_work, fine.slip_work, 1e-13 * m, energy)
    assert close(coarse.slip_distance, fine.slip_distance, 1e-13, np.abs(u).max())


@few
@given(
    curve_names,
    st.lists(st.tuples(depth, st.floats(-0.99, 0.99)), min_size=1, max_size=12),
    st.integers(2, 37),
)
def test_substeps_of_forces(name, history, m):
    d, ratio = columns(history)
    normal = evaluate(CURVES[name], d)[1]
    pull = 0.4 * ratio * normal
    coarse = follow_forces(CURVES[name], normal, pull, 0.4, 0.8)
    fine = follow_forces(CURVES[name], substeps(normal, m), substeps(pull, m), 0.4, 0.8, keep=m)
    energy = 0.4 * normal.max() * 0.4 / 0.8 * d.max()
    assert coarse.ending is fine.ending is Ending.COMPLETE
    assert close(coarse.indentation, fine.indentation, 1e-13)
    assert close(coarse.shift, fine.shift, 1e-13, max(np.abs(coarse.shift).max(), 1e-3 * d.max()))
    assert close(coarse.stored_energy, fine.stored_energy, 1e-13, energy)
    assert close(coarse.slip_work, fine.slip_work, 1e-13 * m, energy)


@few
@given(
    st.sampled_from(list(POWERS)),
    rows,
    st.sampled_from([1e-9, 3e-7, 7.0, 1e3]),
    st.sampled_from([1e-3, 1e11]),
)
def test_rescaling(n, history, length, modulus):
    d, u = columns(history)
    curves = power_law_curves(n, length ** (1.0 - n), modulus)
    small = follow_displacements(POWERS[n], d, u, 0.3, 0.8)
    large = follow_displacements(curves, length * d, length * u, 0.3, 0.8 * modulus)
    force, energy = sizes(POWERS[n], d, u, 0.3, 0.8)
    by_force, by_energy = modulus * length**2, modulus * length**3
    assert close(small.tangential_force, large.tangential_force / by_force, 1e-13, force)
    assert close(small.stored_energy, large.stored_energy / by_energy, 1e-13, energy)
    assert close(small.slip_work, large.slip_work / by_energy, 1e-13, energy)


@few
@given(rows_with_loss, frictions, st.data())
def test_state_resumes(history, mu, data):
    d, u = columns(history)
    cut = data.draw(st.integers(0, d.size - 1))
    whole = follow_displacements(HERTZ, d, u, mu, 0.8, checkpoints=[cut])
    rest = follow_displacements(HERTZ, d[cut + 1 :], u[cut + 1 :], mu, 0.8, start=whole.checkpoints[cut])
    force, energy = sizes(HERTZ, d, u, mu, 0.8)
    for name, scale in (("tangential_force", force), ("stored_energy", energy), ("slip_work", energy)):
        assert close(getattr(whole, name)[cut + 1 :], getattr(rest, name), 1e-14, scale)
    assert rest.state.rows == d.size
    assert whole.slip_work_steps.sum() == pytest.approx(whole.slip_work[-1])


# --- control by forces ------------------------------------------------------------------------------------------


@few
@given(curve_names, rows, frictions)
def test_force_given_at_indentation(name, history, mu):
    d, u = columns(history)
    curves = CURVES[name]
    whole = follow_displacements(curves, d, u, mu, 0.8).tangential_force
    run = follow_indentation_with_force(curves, d, whole, mu, 0.8)
    assert run.ending is Ending.COMPLETE
    again = follow_displacements(curves, d, run.shift, mu, 0.8)
    assert close(whole, again.tangential_force, 1e-12)


def test_force_control_is_the_limit_of_fine_displacements():
    """Slip work of force control has a sum of its own; here the curved (d, u_x) path is followed in 400 parts."""
    rng = np.random.default_rng(3)
    normal = rng.uniform(0.1, 1.0, 12)
    pull = 0.5 * normal * rng.uniform(-0.98, 0.98, 12)
    for curves in (*POWERS.values(), TABLES["mixed"]):
        run = follow_forces(curves, normal, pull, 0.5, 0.8)
        errors = []
        for m in (100, 400):
            path = follow_forces(curves, substeps(normal, m), substeps(pull, m), 0.5, 0.8)
            fine = follow_displacements(curves, path.indentation, path.shift, 0.5, 0.8, keep=m)
            assert close(fine.tangential_force, pull, 1e-11)
            errors.append(np.max(np.abs(fine.slip_work - run.slip_work)) / run.slip_work[-1])
        assert errors[1] < 1e-4
        assert np.log(errors[0] / errors[1]) / np.log(4.0) > 0.9


def test_unattainable_rows_are_named():
    run = follow_forces(HERTZ, [1.0, 1.0, 1.0], [0.1, 0.31, 0.1], 0.3, 1.0)
    assert (run.ending, run.stopped) == (Ending.NOT_ATTAINABLE, 1)
    assert np.isnan([run.tangential_force[1:], run.stick_radius[1:], run.shift[1:], run.slip_work[1:]]).all()
    assert run.state.rows == 1
    assert follow_forces(HERTZ, [1.0, 1.0], [0.1, 0.3], 0.3, 1.0).ending is Ending.COMPLETE
    assert follow_forces(HERTZ, [1.0, 0.0], [0.1, 0.1], 0.3, 1.0).stopped == 1
    assert follow_forces(HERTZ, [1.0, -1.0], [0.1, 0.0], 0.3, 1.0).stopped == 1
    assert follow_indentation_with_force(HERTZ, [1.0, 0.5], [0.3, 0.3], 0.3, 1.0).stopped == 1
    assert follow_load_with_shift(HERTZ, [1.0, -0.5], [0.3, 0.3], 0.3, 1.0).ending is Ending.NOT_ATTAINABLE
    deep = follow_load_with_shift(TABLES["mixed"], [1e-3, 1e3], [0.0, 0.0], 0.3, 1.0)
    assert (deep.ending, deep.stopped) == (Ending.TOO_DEEP, 1)


@pytest.mark.parametrize("mu", [0.0, 0.3, np.inf])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_not_finite_rows_give_nothing(mu, bad):
    for d, u in (([0.5, bad, 0.5], [0.0, 0.1, 0.2]), ([0.5, 0.5, 0.5], [0.0, bad, 0.2])):
        run = follow_displacements(HERTZ, d, u, mu, 1.0)
        assert (run.ending, run.stopped) == (Ending.NOT_FINITE, 1)
        assert np.isfinite(run.stored_energy[0])
        for values in (
            run.tangential_force,
            run.stick_radius,
            run.stored_energy,
            run.slip_work,
            run.slip_distance,
        ):
            assert np.isnan(values[1:]).all()
        forces = follow_forces(HERTZ, d, np.array(u) * 0.0 if np.isfinite(u).all() else u, mu, 1.0)
        assert (forces.ending, forces.stopped) == (Ending.NOT_FINITE, 1)
    assert follow_displacements(TABLES["mixed"], [0.5, 1.1], [0.0, 0.0], mu, 1.0).ending is Ending.TOO_DEEP


def test_mixed_load_and_shift():
    """The same shift at three loads; the force is that of the depths which carry the loads."""
    force = np.array([0.4, 0.4, 0.8, 0.2])
    run = follow_load_with_shift(HERTZ, force, [0.0, 0.1, 0.15, 0.1], 0.3, 0.8)
    np.testing.assert_allclose(evaluate(HERTZ, run.indentation)[1], force, rtol=1e-14)
    same = follow_displacements(HERTZ, run.indentation, run.shift, 0.3, 0.8)
    np.testing.assert_array_equal(run.tangential_force, same.tangential_force)


# --- limits: no friction, no slip, no contact --------------------------------------------------------------------


def test_frictionless():
    run = follow_displacements(HERTZ, [0.5, 0.5, -0.5, 0.5], [0.1, 0.3, 0.5, -0.1], 0.0, 1.0, checkpoints=[1])
    for values in (run.tangential_force, run.stick_radius, run.stored_energy, run.slip_work):
        assert np.all(values == 0.0)
    np.testing.assert_allclose(run.slip_distance, [0.1, 0.3, 0.4, 0.7])
    assert run.checkpoints[1].y.tolist() == [0.0, 0.5]
    assert np.all(spring_shifts(run.state, [0.1]) == 0.0)
    assert follow_forces(HERTZ, [1.0, 1.0], [0.0, 0.1], 0.0, 1.0).stopped == 1


@few
@given(curve_names, rows_with_loss)
def test_no_slip_is_the_limit_of_large_friction(name, history):
    d, u = columns(history)
    curves = CURVES[name]
    stuck = follow_displacements(curves, d, u, np.inf, 0.8)
    energy = max((stuck.stored_energy + stuck.slip_work).max(), 1e-30)
    errors = []
    for mu in (1e5, 1e7):
        large = follow_displacements(curves, d, u, mu, 0.8)
        errors.append(
            np.max(np.abs(large.stored_energy + large.slip_work - stuck.stored_energy - stuck.slip_work))
        )
    assert errors[1] <= 1e-2 * energy


def test_no_slip_springs():
    """Springs part, lose their shift and come back stress-free; equal to a line of springs to its first order."""
    d, u = np.array(
        [[0.5, 0.1], [0.5, 0.45], [0.8, 0.3], [0.8, -0.2], [0.35, -0.1], [0.6, 0.05], [0.2, 0.45]]
    ).T
    stack = follow_displacements(HERTZ, d, u, np.inf, 0.8)
    for n in (1000, 10_000):
        x = (np.arange(n) + 0.5) / n
        line = springs(x**2, 1 / n, d, u, np.inf, 1.0, 0.8)
        assert close(stack.tangential_force, line.tangential_force, 2.0 / n)
        assert close(stack.stored_energy, line.stored_energy, 2.0 / n)
        assert close(stack.slip_work, line.slip_work, 2.0 / n)
    parted = follow_displacements(HERTZ, [0.5, 0.5, 0.2, 0.5], [0.0, 0.1, 0.1, 0.1], np.inf, 1.0)
    a = np.sqrt(0.2)  # the springs that stayed carry 0.1, those that came back nothing
    assert parted.tangential_force[2:] == pytest.approx([2 * a * 0.1] * 2, rel=1e-14)
    pulled = follow_indentation_with_force(HERTZ, d, stack.tangential_force, np.inf, 0.8)
    assert close(pulled.shift, u, 1e-13)


def test_no_slip_under_forces_releases_the_closed_integral():
    """Load to (F, S) and unload straight to (F1, S1): int lag^2 k'/2 da with the lag (S - S0 F/F0)/(2 a)."""
    first, drag, last, back = 1.0, 0.2, 0.01, 0.05

    def lag(a):
        force = 4.0 / 3.0 * a**3
        pull = drag + (back - drag) * (first - force) / (first - last)
        return (pull - drag / first * force) / (2.0 * a)

    ends = ((0.75 * np.array([last, first])) ** (2.0 / 3.0)) ** 0.5
    exact = quad(lambda a: lag(a) ** 2, *ends, epsabs=0.0, epsrel=1e-13)[0]
    for m in (1, 7, 400):
        run = follow_forces(
            HERTZ, substeps([first, last], m), substeps([drag, back], m), np.inf, 1.0, keep=2 * m
        )
        assert run.slip_work[-1] == pytest.approx(exact, rel=1e-13)


@few
@given(
    curve_names,
    st.lists(st.tuples(st.one_of(depth, st.just(0.0)), st.floats(-0.99, 0.99)), min_size=1, max_size=12),
    st.integers(2, 37),
)
def test_substeps_of_forces_without_slip(name, history, m):
    d, ratio = columns(history)
    normal = evaluate(CURVES[name], d)[1]
    pull = ratio * normal
    coarse = follow_forces(CURVES[name], normal, pull, np.inf, 0.8)
    fine = follow_forces(CURVES[name], substeps(normal, m), substeps(pull, m), np.inf, 0.8, keep=m)
    assert coarse.ending is fine.ending is Ending.COMPLETE
    size = max(np.abs(coarse.shift).max(), 1e-3 * d.max())
    energy = max(normal.max() * size, 1e-300)
    assert close(coarse.shift, fine.shift, 1e-13, size)
    assert close(coarse.stored_energy, fine.stored_energy, 1e-13, energy)
    assert close(coarse.slip_work, fine.slip_work, 1e-13 * m, energy)
    assert np.all(np.diff(coarse.slip_work) >= -1e-14 * energy)


@pytest.mark.parametrize("name", list(CURVES))
def test_without_slip_a_contact_that_is_unloaded_by_force_goes_back_to_where_it_touched(name):
    full = evaluate(CURVES[name], [0.5])[1][0]
    run = follow_forces(CURVES[name], [full, full, 0.0], [0.0, 0.2 * full, 0.0], np.inf, 0.8)
    assert run.shift[1] > 0.0
    assert run.shift[2] == pytest.approx(0.0, abs=1e-15)


@few
@given(
    curve_names,
    st.lists(st.tuples(st.floats(0.05, 0.5), shift), min_size=1, max_size=6),
    st.floats(0.01, 0.5),
    st.sampled_from([-1.0, 1.0]),
    st.sampled_from([0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4]),
    st.integers(2, 37),
)
def test_loading_along_the_limit_of_friction(name, history, rise, side, beyond, m):
    """What slips is as thin as rounding while the depth grows as fast as the shift: nothing may come of it."""
    d, u = columns(history)
    d = np.append(d, d[-1] + rise)
    u = np.append(u, u[-1] + side * (d[-1] - d[-2]) * (1.0 + beyond))
    coarse = follow_displacements(CURVES[name], d, u, 1.0, 1.0)
    fine = follow_displacements(CURVES[name], substeps(d, m), substeps(u, m), 1.0, 1.0, keep=m)
    force, energy = sizes(CURVES[name], d, u, 1.0, 1.0)
    assert close(coarse.tangential_force, fine.tangential_force, 1e-13, force)
    assert close(coarse.slip_work, fine.slip_work, 1e-13 * m, energy)
    assert np.diff(coarse.slip_work)[-1] >= -1e-14 * energy


wild = st.one_of(st.floats(-10.0, 10.0), st.sampled_from([1e-300, -1e-300, 1e-160, 1e-17, 1e150, 5e-324]))


@few
@given(curve_names, st.lists(st.tuples(wild, wild), min_size=1, max_size=10), frictions)
def test_finite_rows_give_finite_numbers(name, history, mu):
    d, u = columns(history)
    run = follow_displacements(CURVES[name], np.minimum(d, 1.0), u, mu, 0.8)
    assert run.ending is Ending.COMPLETE
    for values in (run.tangential_force, run.stick_radius, run.slip_distance):
        assert np.isfinite(values).all()
    if np.abs(u).max() < 1e100:
        assert np.isfinite(run.stored_energy + run.slip_work).all()


def test_loss_and_return_of_contact():
    run = follow_displacements(HERTZ, [0.5, 0.5, -0.5, -0.2, 0.2], [0.0, 0.3, 0.3, 0.7, 1.1], 1.0, 1.0)
    assert run.tangential_force[2] == run.stored_energy[2] == run.stick_radius[2] == 0.0
    fresh = follow_displacements(HERTZ, [0.2], [0.2], 1.0, 1.0)  # touched half way, at shift 0.9
    assert run.tangential_force[-1] == pytest.approx(fresh.tangential_force[-1], rel=1e-14)
    assert run.slip_work[-1] == pytest.approx(run.slip_work[2], rel=1e-14)


def test_flat_punch_slides_at_once():
    flat = tabulated_curves(lambda d: np.full_like(d, 0.7), 1.0, 2.0)
    run = follow_displacements(flat, [0.5] * 4, [0.0, 0.2, 0.4, 0.7], 0.5, 1.0)
    force = float(evaluate(flat, 0.5)[1])
    np.testing.assert_allclose(
        run.tangential_force, [0.0, 2 * 0.7 * 0.2, 2 * 0.7 * 0.4, 0.5 * force], rtol=1e-14
    )
    np.testing.assert_allclose(run.stick_radius, [0.7, 0.7, 0.7, 0.0], rtol=1e-14)
    assert run.slip_distance[-1] == pytest.approx(0.2, rel=1e-14)
    assert run.slip_work[-1] == pytest.approx(0.5 * force * 0.2, rel=1e-13)


# --- fields -----------------------------------------------------------------------------------------------------


@few
@given(curve_names, rows_with_loss, frictions)
def test_superposition_and_spring_shifts(name, history, mu):
    d, u = columns(history)
    curves = CURVES[name]
    run = follow_displacements(curves, d, u, mu, 0.8)
    depths, weight, edge, scale = superposition(run.state)
    a, force, _ = evaluate(curves, depths)
    total = scale * np.sum(weight * force + edge * 2.0 * curves.modulus * a)
    size = np.abs(run.tangential_force).max()
    assert abs(total - run.tangential_force[-1]) <= 1e-13 * max(size, np.sum(np.abs(weight * force)))
    y = np.linspace(0.0, 1.0, 21)
    t = spring_shifts(run.state, y)
    if np.isfinite(mu):
        assert np.all(np.abs(t) <= mu * curves.modulus / 0.8 * np.maximum(d[-1] - y, 0.0) + 1e-14)
    if d[-1] > 0.0 and name in POWERS:  # F_x = 2 G* int_0^a t dx, x = a s^k takes the tips
        a = float(evaluate(curves, d[-1])[0])
        borders = np.unique(np.concatenate([[0.0], (depths / d[-1]) ** (1 / name)]))
        s, w = np.polynomial.legendre.leggauss(40)
        x = np.concatenate([lo + (hi - lo) * (0.5 + 0.5 * s) for lo, hi in pairwise(borders)])
        w = np.concatenate([0.5 * (hi - lo) * w for lo, hi in pairwise(borders)])
        total = 2 * 0.8 * a * np.dot(w, spring_shifts(run.state, d[-1] * x**name))
        assert abs(total - run.tangential_force[-1]) <= 1e-8 * max(size, 1e-3)


# --- tables and inverse -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 4.0])
def test_tables(n):
    table = tabulated_curves(lambda d: d ** (1 / n), 1.0, 1.0)
    y = np.concatenate([np.linspace(0.0, 1.0, 5001)[1:], np.logspace(-12, 0, 200)])
    for exact, results in zip(evaluate(POWERS[n], y), evaluate(table, y), strict=True):
        np.testing.assert_allclose(results, exact, rtol=2e-13, atol=0.0)
    for curves in (POWERS[n], table):
        force = evaluate(curves, y)[1]
        np.testing.assert_allclose(depths_at_force(curves, force), y, rtol=4e-15, atol=0.0)
    d, u = columns([[0.5, 0.1], [0.5, 0.45], [0.8, 0.3], [0.8, -0.2], [0.35, -0.1], [0.6, 0.5], [0.2, 0.45]])
    exact, results = (follow_displacements(c, d, u, 0.7, 0.8) for c in (POWERS[n], table))
    for name in ("tangential_force", "stored_energy", "slip_work", "stick_radius"):
        assert close(getattr(exact, name), getattr(results, name), 1e-11)


def test_tables_refuse_what_they_cannot_hold():
    with pytest.raises(ConvergenceError, match="smoother"):
        tabulated_curves(lambda d: d + 1e-6 * (np.sin(1e7 * d) + 1e7 * d), 1.0, 1.0)
    with pytest.raises(ProblemError, match="falling"):
        tabulated_curves(lambda d: 1.0 - d, 1.0, 1.0)
    with pytest.raises(ProblemError, match="finite"):
        tabulated_curves(lambda d: np.where(d > 0.5, np.nan, d), 1.0, 1.0)
    with pytest.raises(ProblemError, match="above 0"):
        power_law_curves(2.0, 0.0, 1.0)
    step = tabulated_curves(lambda d: np.where(d < 0.3701, d, 2.0 + d), 1.0, 1.0)
    assert float(evaluate(step, 1.0)[1]) == pytest.approx(2 * (0.5 + 2.0 * (1.0 - 0.3701)), rel=1e-13)


def test_one_memory_belongs_to_one_contact():
    state = follow_displacements(HERTZ, [0.5], [0.1], 0.3, 1.0).state
    with pytest.raises(PathError, match="same contact"):
        follow_displacements(HERTZ, [0.5], [0.1], 0.4, 1.0, start=state)
    with pytest.raises(PathError, match="rows"):
        follow_displacements(HERTZ, [0.5], [0.1], 0.3, 1.0, keep=[1])


# --- cost -------------------------------------------------------------------------------------------------------


def test_monotone_approach_keeps_a_small_stack():
    count = 10_000_000
    d = np.linspace(1e-7, 1.0, count)
    u = 0.3 * d
    run = follow_displacements(HERTZ, d, u, 1.0, 1.0, keep=count)
    assert run.state.y.size <= 3
    assert run.tangential_force[0] == pytest.approx(0.3 * 4 / 3, rel=1e-14)
    forces = follow_forces(HERTZ, d[:100_000], 0.3 * d[:100_000], 1.0, 1.0)
    assert forces.state.y.size <= 3
    assert follow_displacements(HERTZ, d[::100], u[::100], np.inf, 1.0).state.y.size <= 3


def test_stack_grows_and_forgets():
    count = 20_000
    u = np.where(np.arange(count) % 2, 1.0, -1.0) * np.linspace(0.9, 0.0, count)
    rest = follow_displacements(HERTZ, [1.0], [0.0], 1.0, 1.0).state
    run = follow_displacements(HERTZ, np.ones(count), u, 1.0, 1.0, start=rest)
    assert run.state.y.size == count + 2
    after = follow_displacements(HERTZ, [1.0], [0.95], 1.0, 1.0, start=run.state)
    assert after.state.y.size == 3
    assert after.tangential_force[0] == pytest.approx(
        4 / 3 * float(cattaneo_mindlin(0.95, 2.0)[0]), rel=1e-14
    )


def test_kept_rows_and_checkpoints():
    rng = np.random.default_rng(1)
    d, u = rng.uniform(0.1, 1.0, 50), rng.normal(size=50)
    whole = follow_displacements(HERTZ, d, u, 1.0, 1.0, checkpoints=[3, 17])
    some = follow_displacements(HERTZ, d, u, 1.0, 1.0, keep=[40, 2, 17])
    assert some.rows.tolist() == [2, 17, 40]
    assert sorted(whole.checkpoints) == [3, 17]
    for name in ("indentation", "shift", "tangential_force", "stick_radius", "stored_energy", "slip_work"):
        np.testing.assert_array_equal(getattr(whole, name)[some.rows], getattr(some, name))
    assert follow_displacements(HERTZ, d, u, 1.0, 1.0, keep=7).rows.tolist() == [6, 13, 20, 27, 34, 41, 48]


@pytest.mark.parametrize("n", [1.0, 2.0])
def test_springs_converge(n):
    rng = np.random.default_rng(2)
    d, u = rng.uniform(0.05, 1.0, 30), 0.5 * rng.normal(size=30)
    stack = follow_displacements(POWERS[n], d, u, 0.6, 0.8)
    counts = np.array([250, 1000, 4000, 16000])
    errors = []
    for count in counts:
        x = (np.arange(count) + 0.5) / count
        line = springs(x**n, 1 / count, d, u, 0.6, 1.0, 0.8)
        errors.append(
            [
                np.max(np.abs(line.tangential_force - stack.tangential_force)),
                np.max(np.abs(line.slip_work - stack.slip_work)),
            ]
        )
    orders = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert np.all((orders > -2.3) & (orders < -1.7))
    assert close(stack.stick_radius, line.stick_radius, 2.0 / 16000, 1.0)


def test_import_does_not_load_numba():
    code = "import sys, pymdr.line.friction; sys.exit('numba' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
