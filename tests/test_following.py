"""Paths on folding curves: jumps, energies and hysteresis loops, with and without adhesion laws."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import struve

from common import DMT, JKR, Powers, Ripple, references
from drawing import examples
from pymdr.errors import ConvergenceError, PathError
from pymdr.line.adhesion import maugis_dugdale, power_law_pull_off
from pymdr.line.following import (
    Curve,
    energy_balance,
    follow,
    parameter_reaching,
    sampled_curve,
    trace,
    under_machine,
)
from pymdr.line.following.branches import turning_points

gauss = cache(np.polynomial.legendre.leggauss)


@dataclass(frozen=True)
class Wavy:
    """g of r²/2R + h (1 - cos kr), which has a Struve function in it."""

    R: float
    h: float
    k: float
    edge: float = np.inf
    max_radius: float = np.inf
    breakpoints: tuple[float, ...] = ()
    exponent: float = 0.0

    def g(self, x):
        return x**2 / self.R + 0.5 * np.pi * self.h * self.k * x * struve(0, self.k * x)

    def slope(self, x):
        z = self.k * x
        return 2.0 * x / self.R + 0.5 * np.pi * self.h * self.k * (
            struve(0, z) + z * (2.0 / np.pi - struve(1, z))
        )

    def moment(self, x):
        integral = x**3 / (3.0 * self.R) + 0.5 * np.pi * self.h * x * struve(1, self.k * x)
        return x * self.g(x) - integral

    def squared(self, x):
        x = np.asarray(x, dtype=float)
        t, w = gauss(80)
        y = 0.5 * x[..., None] * (t + 1.0)
        return 0.5 * x * ((self.g(x)[..., None] - self.g(y)) ** 2 @ w)


def paraboloid(R=1.0, **limits):
    return Powers(((2.0, 1.0 / R),), **limits)


def flat(b):
    return Powers(((1.0, 0.0),), edge=b)


def tracked(law, top, k=np.inf):
    """The track of a law up to a control value."""
    limit = getattr(law, "limit", np.inf)
    stop = parameter_reaching(under_machine(law, 1.0, k).control, top, limit=limit)
    return trace(under_machine(law, stop, k))


def there_and_back(bottom, top, steps):
    return np.concatenate([np.linspace(bottom, top, steps), np.linspace(top, bottom, steps)])


def smooth_work(law, k, low, high, knots=()):
    """int F dD (int -d dF under force control) between two states of one branch, by panels of Gauss points."""
    t, w = gauss(24)
    lo, hi = min(low, high), max(low, high)
    if lo == hi:
        return 0.0
    marks = np.unique([lo, *(x for x in knots if lo < x < hi), hi])
    panels = np.unique(np.concatenate([np.linspace(a, b, 33) for a, b in pairwise(marks)]))
    s = 0.5 * (panels[1:] + panels[:-1])[:, None] + 0.5 * np.diff(panels)[:, None] * t
    weight = 0.5 * np.diff(panels)[:, None] * w
    states, (depth, force) = law.states(s), law.slopes(s)
    by_force = k == 0.0
    rate = -states.indentation * force if by_force else states.normal_force * (depth + force / (k or 1.0))
    return float(np.sum(weight * rate)) * (1.0 if high >= low else -1.0)


def work_between_jumps(law, k, history):
    """The work of the control over a history, from its smooth stretches alone."""
    total, here = 0.0, law.start if np.isnan(history.initial) else history.initial
    for before, after in zip(history.jumps.before, history.jumps.after, strict=True):
        if not np.isnan(before):
            total += smooth_work(law, k, here, before, law.knots)
        # a body that is lost or touches smoothly does so at the start of the curve
        here = law.start if np.isnan(after) else after
    last = history.parameter[-1] if history.attached[-1] else law.start
    return total + smooth_work(law, k, here, last, law.knots)


def jump_by_quadrature(line, E, gamma, k, D, before, after):
    """int |G - γ| 2πa da of a JKR jump at constant D = d + F/k, along states that are not in equilibrium."""
    low, high = (0.0 if np.isnan(x) else x for x in (before, after))
    t, w = gauss(60)
    panels = np.linspace(np.sqrt(min(low, high)), np.sqrt(max(low, high)), 41)
    root = 0.5 * (panels[1:] + panels[:-1])[:, None] + 0.5 * np.diff(panels)[:, None] * t
    a = root**2
    integral = a * line.g(a) - line.moment(a)  # int_0^a g
    d = np.full_like(a, D) if np.isinf(k) else (D + 2 * E * integral / k) / (1 + 2 * E * a / k)
    release = E * (d - line.g(a)) ** 2 - 2 * np.pi * a * gamma
    return abs(float(np.sum(0.5 * np.diff(panels)[:, None] * w * release * 2 * root)))


# --- curves without a law ---------------------------------------------------------------------------------


def wave(stop=40.0):
    """The point of Prandtl and Tomlinson: T = (D - s)²/2 + 2 (1 - cos s)."""
    return Curve(
        lambda s: s + 2 * np.sin(s),
        lambda s: 1 + 2 * np.cos(s),
        lambda s: 2 * np.sin(s) ** 2 + 2 * (1 - np.cos(s)),
        start=0.0,
        stop=stop,
    )


def test_folds_and_branches():
    track = trace(wave())
    third = 2 * np.pi / 3
    folds = np.array([base + x for base in 2 * np.pi * np.arange(7) for x in (third, 2 * third)])
    assert np.allclose(track.turning[1:-1], folds[folds < 40], rtol=1e-15)
    assert track.low.size == track.high.size == 7
    assert np.all(track.low < track.high)


def test_a_path_is_where_a_small_step_says():
    """The rule itself: growth while D > D(s), shrinkage while D < D(s), in small steps."""
    track = trace(wave())
    rng = np.random.default_rng(0)
    D = rng.uniform(-1.0, 25.0, 40)
    history = follow(track, D)
    s, previous = 0.0, -1.0
    attached = False
    for row, value in enumerate(D):
        for level in np.linspace(previous, value, 400)[1:]:
            if not attached and level >= 0.0:
                attached, s = True, 0.0
            while attached and abs(level - (s + 2 * np.sin(s))) > 2e-3:
                s += 1e-3 * np.sign(level - (s + 2 * np.sin(s)))
                if s < 0.0:
                    attached = False
        previous = value
        assert history.attached[row] == attached
        if attached:
            assert history.parameter[row] == pytest.approx(s, abs=0.1)
            assert abs(history.parameter[row] + 2 * np.sin(history.parameter[row]) - value) < 1e-11


def test_hidden_folds_and_corners():
    """Two folds close together, and a fold in a corner of the curve."""
    gap = 1e-3
    curve = Curve(
        lambda s: (s - 1) ** 3 / 3 - gap**2 * (s - 1),
        lambda s: (s - 1) ** 2 - gap**2,
        np.zeros_like,
        0.0,
        3.0,
        touch=-1.0,
    )
    assert np.allclose(trace(curve).turning[1:-1], [1 - gap, 1 + gap], rtol=1e-12)
    corner = Curve(
        lambda s: np.abs(s - 0.7) - 0.7, lambda s: np.sign(s - 0.7), np.zeros_like, 0.0, 3.0, knots=(0.7,)
    )
    assert trace(corner).turning[1] == 0.7
    assert trace(corner).pull_off == 0.7


@given(st.floats(-1e3, 1e3), st.floats(0.5, 20.0), st.floats(-9.0, 3.0))
def test_places_of_folds_do_not_depend_on_the_start_of_the_path(start, turns, decades):
    size = 10.0**decades
    points, rising = turning_points(
        lambda s: np.cos(s / size - start), start * size, (start + turns) * size, ()
    )
    folds = np.arange(0.5 * np.pi, turns, np.pi)
    assert points / size - start == pytest.approx([0.0, *folds, turns], abs=1e-12 * (1.0 + abs(start)))
    assert rising == [i % 2 == 0 for i in range(folds.size + 1)]


@settings(max_examples=examples(60), deadline=None)
@given(st.floats(-9.0, 3.0), st.floats(0.02, 0.9), st.floats(0.05, 20.0), st.booleans())
def test_slopes_without_bound_at_a_corner(decade, power, strength, decreases):
    # the slope -strength delta^-power of a corner passes a slope of 1 at a known distance behind it
    corner = 1.7 * 10.0**decade

    def slope(s):
        with np.errstate(divide="ignore"):
            distance = np.where(s > corner, (s - corner) / corner, np.inf)
            return (1.0 - strength * distance**-power) * (1.0 if decreases else -1.0)

    fold = corner * (1.0 + strength ** (1.0 / power))
    if not 1e-6 * corner < fold - corner < 1e6 * corner:
        return
    points, rising = turning_points(slope, 0.0, 3.0 * fold, (corner,))
    assert np.allclose(points, [0.0, corner, fold, 3.0 * fold], rtol=1e-9, atol=0.0)
    assert rising == [decreases, not decreases, decreases]


def test_samples_are_a_curve_too():
    s = np.linspace(0.0, 20.0, 2001)
    smooth = wave(20.0)
    sampled = sampled_curve(s, smooth.control(s), smooth.energy(s))
    D = there_and_back(-0.5, 14.0, 300)
    one, other = follow(trace(smooth), D), follow(trace(sampled), D)
    assert np.array_equal(one.attached, other.attached)
    difference = np.abs(one.parameter - other.parameter)[one.attached & (one.branch == other.branch)]
    assert np.median(difference) < 1e-4
    assert np.sum(other.dissipated) == pytest.approx(np.sum(one.dissipated), rel=1e-3)


def test_an_unstable_start_jumps_where_the_first_step_leads():
    track = trace(wave())
    here = np.pi
    D = float(track.curve.control(np.array(here)))
    up, down = follow(track, [D + 0.1], initial=here), follow(track, [D - 0.1], initial=here)
    assert up.jumps.before[0] == down.jumps.before[0] == here
    assert down.parameter[0] < here < up.parameter[0]
    assert up.jumped[0]
    assert down.jumped[0]
    assert up.jumps.loss[0] > 0.0
    assert down.jumps.loss[0] > 0.0
    assert energy_balance(track, up).work[0] == pytest.approx(
        float(track.curve.energy(up.parameter)[0] - track.curve.energy(up.jumps.after)[0]), rel=1e-10
    )
    stay = follow(track, [float(track.curve.control(np.array(6.0)))], initial=6.0)
    assert stay.parameter[0] == pytest.approx(6.0, rel=1e-12)
    assert not stay.jumped[0]


@settings(max_examples=examples(60), deadline=None)
@given(st.floats(1.2, 6.0), st.floats(3.0, 8.0), st.floats(0.05, 0.95), st.floats(-0.5, 0.5))
def test_unstable_starts_among_many_waves_go_to_the_next_stable_state(height, pitch, place, move):
    """T = (D - s)^2/2 + V(s): it grows, or shrinks, to the first state at which D is that of the start."""
    stop = 60.0 / pitch
    curve = Curve(
        lambda s: s + height / pitch * np.sin(pitch * s),
        lambda s: 1.0 + height * np.cos(pitch * s),
        lambda s: (
            0.5 * (height / pitch * np.sin(pitch * s)) ** 2 + height / pitch**2 * (1.0 - np.cos(pitch * s))
        ),
        0.0,
        stop,
    )
    track = trace(curve)
    s = np.linspace(0.0, stop, 400_001)
    D = curve.control(s)
    unstable = np.flatnonzero((curve.slope(s) < -0.05 * height) & (D > 0.3) & (0.7 * stop > D))
    if unstable.size == 0:
        return
    i = int(unstable[int(place * unstable.size)])
    to = float(D[i]) + move * 0.01 / pitch
    run = follow(track, [to], initial=float(s[i]))
    if to >= D[i]:
        beyond = np.flatnonzero((D[i] <= D) & (np.arange(s.size) > i + 1) & (curve.slope(s) > 0.0))
        expected = s[beyond[0]]
    else:
        before = np.flatnonzero((D[i] >= D) & (np.arange(s.size) < i - 1) & (curve.slope(s) > 0.0))
        if before.size == 0:
            return
        expected = s[before[-1]]
    assert run.jumps.before[0] == s[i]
    assert run.jumps.after[0] == pytest.approx(expected, abs=3.0 * s[1])
    dissipated = float(curve.energy(s[i]) - curve.energy(run.jumps.after[0]))
    assert run.jumps.loss[0] == pytest.approx(dissipated, rel=1e-9, abs=1e-12)


def test_bad_paths_and_curves():
    track = trace(wave(9.0))
    with pytest.raises(PathError, match="beyond the end of the known curve"):
        follow(track, [1.0, 30.0])
    for path in ([], [np.nan], [[1.0, 2.0]]):
        with pytest.raises(PathError, match="a path must be"):
            follow(track, path)
    with pytest.raises(PathError, match="outside the curve"):
        follow(track, [1.0], initial=10.0)
    with pytest.raises(PathError, match="no part of the curve is stable"):
        trace(Curve(lambda s: -s, lambda s: -np.ones_like(s), np.zeros_like, 0.0, 1.0))
    rough = Curve(lambda s: s, lambda s: 2 + np.sin(1e12 * s), np.zeros_like, 0.0, 1.0)
    with pytest.raises(ConvergenceError, match="not smooth near"):
        trace(rough)
    with pytest.raises(PathError, match="increasing"):
        sampled_curve([0, 1, 1], [0, 1, 2], [0, 0, 0])
    with pytest.raises(PathError, match="stiffness"):
        under_machine(JKR(paraboloid(), 1.0, 1.0), 1.0, -1.0)
    with pytest.raises(PathError, match="never reaches"):
        parameter_reaching(np.tanh, 2.0)
    assert parameter_reaching(np.tanh, 2.0, limit=3.0) == 3.0


# --- JKR --------------------------------------------------------------------------------------------------


def test_the_loop_of_a_paraboloid():
    W, W_in, W_out = 7.0921959718640, 6.4183151123, 0.6738808596
    R, E, gamma = 0.7, 3.0, 0.4
    unit = (gamma**5 * R**4 / E**2) ** (1 / 3)
    law = JKR(paraboloid(R), E, gamma)
    track = tracked(law, 1.0)
    for steps in (3, 40, 1000):
        history = follow(track, there_and_back(-3.0, 1.0, steps))
        assert np.allclose(history.jumps.loss / unit, [W_in, W_out], rtol=1e-9)
        assert np.sum(history.dissipated) / unit == pytest.approx(W, rel=1e-12)
        assert history.jumped.sum() == 2
        balance = energy_balance(track, history)
        assert balance.work[-1] / unit == pytest.approx(W, rel=1e-12)
        assert work_between_jumps(law, np.inf, history) / unit == pytest.approx(W, rel=1e-11)
        assert not history.attached[0]
        assert not history.attached[-1]
        for D, before, after, loss in zip(
            history.jumps.control,
            history.jumps.before,
            history.jumps.after,
            history.jumps.loss,
            strict=True,
        ):
            independent = jump_by_quadrature(law.line.equivalent, E, gamma, np.inf, D, before, after)
            assert independent == pytest.approx(loss, rel=1e-12)
    for entry in references("4 JKR"):
        if entry["id"] == "jkr_parab_landmarks":
            expected = [entry["expected"][name] for name in ("E_jump_in", "E_jump_out")]
            assert np.allclose(history.jumps.loss / unit, expected, rtol=1e-12)


def test_the_loop_of_a_wavy_paraboloid():
    line, gamma = Wavy(1.0, 0.002, 40.0), 0.02
    law = JKR(line, 1.0, gamma)
    track = tracked(law, 0.2)
    history = follow(track, there_and_back(-0.2, 0.2, 60))
    assert np.sum(history.jumps.loss) == pytest.approx(0.0105338202, abs=1e-10)
    assert history.jumps.step.size == 3
    assert np.all(history.jumps.loss > 0.0)
    assert energy_balance(track, history).work[-1] == pytest.approx(np.sum(history.jumps.loss), rel=1e-12)
    assert work_between_jumps(law, np.inf, history) == pytest.approx(np.sum(history.jumps.loss), rel=1e-8)


@pytest.mark.parametrize("k", [np.inf, 3.0, 0.0])
@pytest.mark.parametrize("n", [1.0, 2.0, 3.0])
def test_pull_off_is_the_last_fold(n, k):
    expected = power_law_pull_off(n, 1.0, 1.0, 1.0, k)
    kappa = {1.0: np.pi / 2, 2.0: 2.0, 3.0: 3 * np.pi / 4}[n]
    law = JKR(Powers(((n, kappa),)), 1.0, 1.0)
    track = tracked(law, 3.0, k)
    assert track.pull_off == pytest.approx(float(expected.contact_radius), rel=1e-13)
    d, F = float(expected.indentation), float(expected.normal_force)
    control = F if k == 0.0 else d + F / k
    history = follow(track, [2.9, control * (1 - 1e-9), control * (1 + 1e-9)])
    assert history.attached.tolist() == [True, True, False]


@pytest.mark.parametrize(
    "entry",
    [entry for entry in references("4 Maugis-Dugdale") if "F_over_piRgamma" in entry["expected"]],
    ids=lambda entry: entry["id"],
)
def test_pull_off_of_maugis_dugdale(entry):
    strength = entry["inputs"]["lam"] / 2 / (9 / (16 * np.pi)) ** (1 / 3)
    law = maugis_dugdale(paraboloid(), 1.0, 1.0, strength)
    force = law.states(tracked(law, 1.0, 0.0).pull_off).normal_force
    assert force / np.pi == pytest.approx(entry["expected"]["F_over_piRgamma"], rel=entry["rtol"])


def test_force_control():
    law = JKR(paraboloid(), 1.0, 1.0)
    track = tracked(law, 3.0, 0.0)
    history = follow(track, [-1.0, 0.0, 2.0, -4.7, -4.8, -1.0, 1.0])
    assert history.attached.tolist() == [False, True, True, True, False, False, True]
    assert law.states(history.parameter[1]).contact_radius == pytest.approx((4.5 * np.pi) ** (1 / 3))
    assert np.isnan(history.dissipated[4])  # a dead load that falls has no end
    balance = energy_balance(track, follow(track, [1.0, 2.9]))
    work = smooth_work(law, 0.0, *follow(track, [1.0, 2.9]).parameter)
    assert np.diff(balance.work)[0] == pytest.approx(work, rel=1e-12)


@pytest.mark.parametrize("k", [0.5, 4.0])
def test_a_soft_machine_keeps_its_account(k):
    line, E, gamma = Ripple(1.0, 0.95, 30.0), 1.0, 0.02
    law = JKR(line, E, gamma)
    track = tracked(law, 1.0, k)
    history = follow(track, there_and_back(-2.0, 1.0, 37))
    assert not history.attached[-1]
    assert history.jumps.step.size >= 8
    for D, before, after, loss in zip(
        history.jumps.control, history.jumps.before, history.jumps.after, history.jumps.loss, strict=True
    ):
        assert jump_by_quadrature(line, E, gamma, k, D, before, after) == pytest.approx(loss, rel=1e-9)
    balance = energy_balance(track, history)
    assert np.allclose(balance.work, balance.energy + balance.dissipated, rtol=1e-14)
    assert work_between_jumps(law, k, history) == pytest.approx(balance.work[-1], rel=1e-8)


def test_punches_stick_at_their_edge():
    b, gamma = 0.8, 0.6
    law = JKR(flat(b), 1.0, gamma)
    for k in (np.inf, 0.0, 2.0):
        track = tracked(law, 0.5, k)
        state = law.states(track.pull_off)
        F = -np.sqrt(8 * np.pi * gamma * b**3)
        assert state.normal_force == pytest.approx(F, rel=1e-14)
        history = follow(track, [0.0, 0.4])
        assert np.allclose(law.states(history.parameter).contact_radius, b, rtol=1e-15)
    history = follow(tracked(law, 0.5), there_and_back(-2.0, 0.4, 30))
    assert np.sum(history.dissipated) == pytest.approx(2 * np.pi * b**2 * gamma, rel=1e-12)
    md = maugis_dugdale(flat(b), 1.0, gamma, 1.3)
    cycle = follow(tracked(md, 0.5), there_and_back(-4.0, 0.4, 30))
    assert not cycle.attached[-1]
    assert work_between_jumps(md, np.inf, cycle) == pytest.approx(np.sum(cycle.dissipated), abs=1e-8)


def test_without_adhesion_nothing_jumps():
    for line in (paraboloid(), Powers(((1.0, 0.7),)), Powers(((1.3, 0.7), (4.0, 0.2))), flat(1.0)):
        law = JKR(line, 1.0, 0.0)
        D = there_and_back(-0.3, 1.0, 101)
        track = tracked(law, 1.0)
        history = follow(track, D)
        # all of a punch touches at once; nothing else does, and nothing costs energy
        assert history.jumped.any() == np.isfinite(line.edge)
        assert np.all(history.dissipated == 0.0)
        assert np.array_equal(history.attached, D >= 0.0)
        on = history.attached
        states = law.states(history.parameter[on])
        assert np.max(np.abs(states.indentation - D[on])) < 1e-12
        small = follow(track, np.array([1e-4, 1e-3]))
        assert np.allclose(law.states(small.parameter).indentation, [1e-4, 1e-3], rtol=1e-10)
        assert energy_balance(track, history).work[-1] == pytest.approx(0.0, abs=1e-12)


def test_weak_adhesion_tends_to_none():
    bare = follow(tracked(JKR(paraboloid(), 1.0, 0.0), 1.0), [0.5]).parameter[0]
    works = 10.0 ** -np.arange(4.0, 12.0, 2.0)
    differences = [follow(tracked(JKR(paraboloid(), 1.0, w), 1.0), [0.5]).parameter[0] - bare for w in works]
    assert np.allclose(np.diff(np.log(differences)) / np.diff(np.log(works)), 0.5, atol=0.01)


def test_dmt_follows_the_bare_contact():
    law = DMT(paraboloid(), 1.0, 2 * np.pi * 0.1)
    D = there_and_back(-0.3, 1.0, 40)
    history = follow(tracked(law, 1.0), D)
    assert np.array_equal(history.attached, D >= 0.0)
    soft = follow(tracked(law, 1.0, 2.0), there_and_back(-1.0, 1.0, 40))
    lowest = np.nanmin(law.states(soft.parameter[soft.attached]).normal_force)
    assert lowest < -0.5
    assert soft.jumps.loss[0] > 0.0


# --- Maugis-Dugdale ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("strength", [0.5, 3.0])
@pytest.mark.parametrize("k", [np.inf, 1.0])
def test_the_loop_of_maugis_dugdale(strength, k):
    law = maugis_dugdale(paraboloid(), 1.0, 1.0, strength)
    track = tracked(law, 1.0, k)
    history = follow(track, there_and_back(-12.0, 1.0, 20))
    balance = energy_balance(track, history)
    assert not history.attached[-1]
    assert np.all(history.jumps.loss > 0.0)
    assert work_between_jumps(law, k, history) == pytest.approx(balance.work[-1], rel=1e-8, abs=1e-8)


def test_stiff_cones_attach_without_a_jump():
    law = maugis_dugdale(Powers(((1.0, 2.0),)), 1.0, 0.3, 0.1)
    track = tracked(law, 1.0)
    history = follow(track, there_and_back(-5.0, 1.0, 25))
    assert not history.jumped.any()
    assert history.attached.any()
    assert energy_balance(track, history).work[-1] == pytest.approx(0.0, abs=1e-12)


def test_the_loop_tends_to_jkr():
    exact = 7.092195971863959
    lams = np.array([8.0, 16.0, 32.0])
    gaps = []
    for lam in lams:
        strength = lam / 2 / (9 / (16 * np.pi)) ** (1 / 3)
        law = maugis_dugdale(paraboloid(), 1.0, 1.0, strength)
        history = follow(tracked(law, 1.0), there_and_back(-4.0, 1.0, 5))
        gaps.append(abs(np.sum(history.dissipated) - exact))
    orders = -np.diff(np.log(gaps)) / np.diff(np.log(lams))
    # the tip snaps on from a distance h0 ~ 1/λ: first order, where single states converge with order 2
    assert np.allclose(orders, 1.0, atol=0.15)


# --- many jumps, many steps -------------------------------------------------------------------------------


@cache
def rugged():
    law = JKR(Ripple(1.0, 0.97, 330.0), 1.0, 2e-3)
    return law, tracked(law, 1.0)


def test_fifty_instabilities():
    law, track = rugged()
    assert track.low.size > 50
    top = float(track.high[-1])
    totals = []
    for steps in (7, 1000):
        history = follow(track, there_and_back(-0.05, top, steps))
        assert history.jumps.step.size > 50
        assert np.all(history.jumps.loss > 0.0)
        totals.append(np.sum(history.dissipated))
        assert energy_balance(track, history).work[-1] == pytest.approx(totals[-1], rel=1e-8)
    assert totals[0] == pytest.approx(totals[1], rel=1e-13)
    assert work_between_jumps(law, np.inf, history) == pytest.approx(totals[0], rel=1e-8)
    on = history.attached
    result = law.states(history.parameter[on]).indentation
    assert np.max(np.abs(result - history.control[on])) < 1e-12
    assert np.all(law.slopes(history.parameter[on])[0] > -1e-9)


def test_branch_inversion_against_brentq():
    law, track = rugged()
    rng = np.random.default_rng(2)
    for _ in range(100):
        i = rng.integers(track.low.size)
        D = rng.uniform(track.low[i], track.high[i])
        exact = brentq(
            lambda s, D=D: float(law.states(s).indentation) - D, track.bottom[i], track.top[i], xtol=1e-16
        )
        assert track.inverse(np.array([i]), np.array([D]))[0] == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("metre", [1e-9, 2.3e-6, 7.0])
def test_nanometres_and_metres_jump_alike(metre):
    pascal = 3.1e9
    for k in (np.inf, 2.0, 0.0):
        one = JKR(Ripple(1.0, 0.9, 40.0), 1.0, 0.01)
        other = JKR(Ripple(1.0, 0.9, 40.0 / metre), pascal, 0.01 * pascal * metre)
        D = there_and_back(-0.4, 0.6, 23)
        unit = pascal * metre**2 if k == 0.0 else metre
        a = follow(tracked(one, 0.6, k), D)
        b = follow(tracked(other, 0.6 * unit, k * pascal * metre if np.isfinite(k) else k), D * unit)
        assert np.array_equal(a.branch, b.branch)
        on = a.attached
        assert np.allclose(b.parameter[on] / metre, a.parameter[on], rtol=1e-12, atol=0)
        loss = b.jumps.loss / (pascal * metre**3)
        assert np.allclose(loss, a.jumps.loss, rtol=1e-11, atol=1e-14, equal_nan=True)


# --- any profile ------------------------------------------------------------------------------------------

profiles = st.lists(st.tuples(st.floats(0.7, 5.0), st.floats(0.05, 2.0)), min_size=1, max_size=3).map(
    lambda terms: Powers(tuple(terms))
)
paths = st.lists(st.floats(-3.0, 1.0), min_size=1, max_size=12)


@settings(max_examples=examples(25), deadline=None)
@given(profiles, st.floats(1e-3, 2.0), st.sampled_from([np.inf, 0.7, 30.0]), paths)
def test_any_path_on_any_profile(line, gamma, k, path):
    law = JKR(line, 1.0, gamma)
    track = tracked(law, 1.0, k)
    history = follow(track, path)
    balance = energy_balance(track, history)
    assert np.all(history.jumps.loss >= -1e-12 * np.pi * gamma)
    on = history.attached
    size = max(1.0, np.max(np.abs(track.low)), np.max(np.abs(track.high)))
    difference = track.curve.control(history.parameter[on]) - history.control[on]
    assert np.all(np.abs(difference) < 1e-11 * size)
    work = work_between_jumps(law, k, history)
    scale = 1.0 + np.max(np.abs(balance.energy)) + balance.dissipated[-1]
    assert abs(work - balance.work[-1]) < 1e-8 * scale
    # more steps on the same straight lines change nothing
    fine = np.interp(np.linspace(0, len(path), 8 * len(path) + 1), range(len(path) + 1), [-4.0, *path])[1:]
    again = follow(track, fine)
    assert np.array_equal(again.branch[7::8], history.branch)
    assert np.allclose(again.jumps.loss, history.jumps.loss, rtol=0, atol=0)
