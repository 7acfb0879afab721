"""Adhesion through solve, pull_off and adhesion_regime against references, closed forms and independent tables."""

import math
import pickle
import sys
from functools import cache
from itertools import pairwise
from types import FrameType, SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import gamma

import pymdr as mdr
from common import UNIT
from drawing import examples, first_of
from pymdr.errors import ConvergenceError, PymdrError
from pymdr.interpretation.adhesion import _negative
from pymdr.line.adhesion import power_law_pull_off
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.solving import drawing

BALL = mdr.Paraboloid(1.0)
JKR = mdr.JKR(1.0)
LOOP = 7.0921959718640
MAUGIS = (9.0 / (16.0 * math.pi)) ** (-1.0 / 3.0) / 2.0
"""The cohesive stress for Maugis' parameter 1 where R = E* = work = 1."""


def contact(profile=BALL, law=JKR, modulus=1.0):
    return mdr.Contact(profile, mdr.Elastic(modulus, 0.0), adhesion=law)


def column(result, name):
    return result[name].values


def last(result, name):
    return float(result[name].values[-1])


def balance(result):
    return next(entry for entry in result.assumptions if entry.name == "energy balance")


def wavy(h, k):
    """A paraboloid R = 1 with ripples h (1 - cos k r)."""
    return mdr.Function(
        lambda r: r * r / 2 + 2 * h * np.sin(k * r / 2) ** 2, derivative=lambda r: r + h * k * np.sin(k * r)
    )


def there_and_back(top, bottom, steps):
    return mdr.indent(top, steps=steps) >> mdr.indent(bottom, steps=steps)


# --- references -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 3])
def test_references_of_power_laws(references, n):
    entry = references[f"jkr_power_{n}"]
    expected, km = entry["expected"], entry["inputs"]["km"]
    body = contact(mdr.PowerLaw(n, 1.0, 1.0))
    for name, channel, k in (("F", "normal_force", None), ("D", "indentation", None), ("km", "travel", km)):
        a, force, d = (expected[f"{key}_{name}"] for key in "aFd")
        pull_off = mdr.pull_off(body, machine_stiffness={"F": 0.0, "D": math.inf, "km": km}[name])
        assert [pull_off.contact_radius, pull_off.normal_force, pull_off.indentation] == pytest.approx(
            [a, force, d], rel=1e-12
        )
        # by a path: the contact is lost between two rows that are 2e-11 apart
        control = {"F": force, "D": d, "km": d + force / km}[name]
        near = [control + 1e-11 * abs(control), control - 1e-11 * abs(control)]
        result = mdr.solve(body, mdr.Path(**{channel: [9.0, *near]}), machine_stiffness=k)
        assert column(result, "jumped").tolist() == [1.0, 0.0, 1.0]
        assert result.status.name == "PULLED_OFF"
        row = [float(result[key].values[1]) for key in ("contact_radius", "normal_force", "indentation")]
        # next to a fold a state is known to the root of the distance: 1.1e-5 measured
        assert row == pytest.approx([a, force, d], rel=2e-5)
        assert last(result, channel) == near[1] if name != "F" else math.isnan(last(result, channel))


def test_references_of_a_paraboloid(references):
    expected = references["jkr_parab_landmarks"]["expected"]
    touch = mdr.solve(contact(), mdr.indent(0.0))
    assert column(touch, "jumped").tolist() == [1.0]
    assert last(touch, "contact_radius") == pytest.approx(expected["a_at_d0"], rel=1e-12)
    assert last(touch, "contact_radius") == pytest.approx((2 * math.pi) ** (1 / 3), rel=1e-12)
    assert last(touch, "normal_force") == pytest.approx(expected["F_at_d0"], rel=1e-12)
    assert last(touch, "jump_dissipation") == pytest.approx(expected["E_jump_in"], rel=1e-12)
    assert last(touch, "external_work") == pytest.approx(0.0, abs=1e-13)
    unloaded = mdr.solve(contact(), mdr.load(0.0))
    assert last(unloaded, "contact_radius") == pytest.approx(expected["a_at_F0"], rel=1e-12)
    assert last(unloaded, "contact_radius") == pytest.approx((4.5 * math.pi) ** (1 / 3), rel=1e-12)
    assert last(unloaded, "indentation") == pytest.approx(expected["d_at_F0"], rel=1e-12)
    dead, by_depth = (mdr.pull_off(contact(), machine_stiffness=k) for k in (0.0, math.inf))
    for pull_off, names in (
        (dead, ("a_forcecontrol", "F_pulloff", "d_at_pulloff")),
        (by_depth, ("a_dispcontrol", "F_at_snapoff", "d_snapoff")),
    ):
        computed = (pull_off.contact_radius, pull_off.normal_force, pull_off.indentation)
        assert computed == pytest.approx([expected[name] for name in names], rel=1e-12)
    # 2e-13 above and below the two folds
    for channel, fold in (("normal_force", "F_pulloff"), ("indentation", "d_snapoff")):
        near = [expected[fold] * (1 - 1e-13), expected[fold] * (1 + 1e-13)]
        result = mdr.solve(contact(), mdr.Path(**{channel: [1.0, *near]}))
        assert column(result, "jumped").tolist() == [1.0, 0.0, 1.0]


@pytest.mark.parametrize("steps", [1, 7, 400])
def test_the_loop_of_a_paraboloid(references, steps):
    expected = references["jkr_parab_landmarks"]["expected"]
    result = mdr.solve(contact(), there_and_back(1.0, -2.0, steps))
    jumps = column(result, "jump_dissipation")[column(result, "jumped") > 0]
    assert jumps == pytest.approx([expected["E_jump_in"], expected["E_jump_out"]], rel=1e-12)
    for name in ("dissipated_energy", "external_work"):
        assert last(result, name) == pytest.approx(LOOP, rel=2e-13)
    assert (
        last(result, "normal_force")
        == last(result, "contact_radius")
        == last(result, "elastic_energy")
        == 0.0
    )
    assert last(result, "indentation") == -2.0


@settings(max_examples=20, deadline=None)
@given(back=st.floats(-8.0, -1.0), steps=st.integers(1, 20))
def test_work_keeps_no_rounding_of_a_far_larger_load_before(back, steps):
    deep = 1e3
    path = mdr.indent(deep, steps=3) >> mdr.indent(deep * 10.0**back, steps=steps)
    result = mdr.solve(contact(), path)
    stored, surface, dissipated, work = (
        last(result, name)
        for name in ("elastic_energy", "surface_energy", "dissipated_energy", "external_work")
    )
    assert work == pytest.approx(stored + surface + dissipated, abs=1e-15 * (stored - surface + dissipated))


def test_references_of_a_maugis_state(references):
    expected = references["md_sphere_lam0.1"]["expected"]
    body = contact(law=mdr.MaugisDugdale(1.0, strength=expected["sigma0"]))
    for leg in (mdr.indent(expected["d"]), mdr.load(expected["F"])):
        result = mdr.solve(body, mdr.indent(2.0) >> leg)
        for quantity, key in (
            ("contact_radius", "a"),
            ("cohesive_radius", "c"),
            ("normal_force", "F"),
            ("indentation", "d"),
        ):
            assert last(result, quantity) == pytest.approx(expected[key], rel=5e-12)


def test_the_wavy_loop_of_the_theory():
    """The area of a loop over the waves of Guduru (2007) from a table of d(a), to its digits, and the sum of its jumps."""
    result = mdr.solve(contact(wavy(0.002, 40.0), mdr.JKR(0.02)), there_and_back(0.2, -0.2, 30))
    assert last(result, "external_work") == pytest.approx(0.0105338202, abs=6e-11)
    assert column(result, "jump_dissipation").sum() == pytest.approx(0.0105338202, abs=6e-11)
    assert result.claims["normal_force"].where.all()


# --- landmarks --------------------------------------------------------------------------------------------


def opening(a, modulus, work):
    return math.sqrt(2 * math.pi * a * work / modulus)


SLOPES = {  # profile, g(a), g'(a), int_0^a x g' dx
    "paraboloid": (mdr.Paraboloid(0.5), lambda a: 2 * a * a, lambda a: 4 * a, lambda a: 4 * a**3 / 3),
    "cone": (
        mdr.Cone(slope=0.3),
        lambda a: 0.15 * math.pi * a,
        lambda a: 0.15 * math.pi,
        lambda a: 0.075 * math.pi * a * a,
    ),
}


@pytest.mark.parametrize("stiffness", [0.0, 0.8, 30.0, math.inf])
@pytest.mark.parametrize("name", SLOPES)
def test_pull_off_of_round_and_sharp_bodies(name, stiffness):
    modulus, work = 3.0, 0.02
    profile, g, slope, moment = SLOPES[name]

    def unstable(a):
        s = stiffness / (2 * modulus * a)
        xi = 0.5 if math.isinf(s) else 0.5 * (3 + s) / (1 + s)
        return a * slope(a) - xi * opening(a, modulus, work)

    a = brentq(unstable, 1e-6, 10.0, xtol=1e-300, rtol=1e-14)
    d = g(a) - opening(a, modulus, work)
    force = 2 * modulus * (moment(a) - a * opening(a, modulus, work))
    if name == "cone" and stiffness == 0.0:
        assert force == pytest.approx(-54 * work**2 / (math.pi * modulus * 0.3**3), rel=1e-12)
        assert d > 0.0
    if name == "paraboloid" and stiffness in (0.0, math.inf):
        factor = 3 / 2 if stiffness == 0.0 else 5 / 6
        assert force == pytest.approx(-factor * math.pi * work * 0.5, rel=1e-12)
    channel, control, k = {0.0: ("normal_force", force, None), math.inf: ("indentation", d, None)}.get(
        stiffness, ("travel", d + force / stiffness if stiffness else 0.0, stiffness)
    )
    near = [control + 1e-11 * abs(control), control - 1e-11 * abs(control)]
    result = mdr.solve(
        contact(profile, mdr.JKR(work), modulus), mdr.Path(**{channel: [9.0, *near]}), machine_stiffness=k
    )
    assert column(result, "jumped").tolist() == [1.0, 0.0, 1.0]
    row = [float(result[key].values[1]) for key in ("contact_radius", "normal_force", "indentation")]
    assert row == pytest.approx([a, force, d], rel=3e-5)  # the root of 1e-11, times up to 8 for the cone


@pytest.mark.parametrize("name", SLOPES)
def test_jump_in_at_touch(name):
    modulus, work = 3.0, 0.02
    profile, g, _, _ = SLOPES[name]
    a = brentq(lambda a: g(a) - opening(a, modulus, work), 1e-3, 100.0, xtol=1e-300, rtol=1e-14)
    d = mdr.Path(indentation=[-0.1, -1e-9, 0.0])
    result = mdr.solve(contact(profile, mdr.JKR(work), modulus), d)
    assert column(result, "normal_force")[:2].tolist() == [0.0, 0.0]
    assert column(result, "jumped").tolist() == [0.0, 0.0, 1.0]
    assert last(result, "contact_radius") == pytest.approx(a, rel=1e-13)
    assert last(result, "jump_dissipation") == pytest.approx(
        quad(lambda a: abs(modulus * g(a) ** 2 - 2 * math.pi * a * work), 0, a, epsabs=0, epsrel=1e-12)[0],
        rel=1e-11,
    )
    assert last(result, "elastic_energy") + last(result, "surface_energy") == pytest.approx(
        -last(result, "dissipated_energy"), rel=1e-13
    )


@pytest.mark.parametrize("stiffness", [0.0, 0.7, math.inf])
def test_flat_punches_are_unstable_under_any_control(stiffness):
    b, work = 0.4, 0.3
    d = -opening(b, 1.0, work)
    force = -math.sqrt(8 * math.pi * work * b**3)
    channel, control, k = {0.0: ("normal_force", force, None), math.inf: ("indentation", d, None)}.get(
        stiffness, ("travel", d + force / 0.7, stiffness)
    )
    path = mdr.Path(**{channel: [0.2, 0.0, control * (1 - 1e-12), control * (1 + 1e-12)]})
    result = mdr.solve(contact(mdr.FlatPunch(b), mdr.JKR(work)), path, machine_stiffness=k)
    assert column(result, "jumped").tolist() == [1.0, 0.0, 0.0, 1.0]
    assert column(result, "contact_radius")[:3].tolist() == [b] * 3
    assert float(result["normal_force"][2]) == pytest.approx(force, rel=3e-12)
    assert float(result["energy_release_rate"][2]) == pytest.approx(work, rel=1e-11)


def without_units(law, radius, modulus, work):
    """Columns of a loop on a machine: lengths over (work^2 R / E*^2)^(1/3), forces over work R."""
    small = (work / (modulus * radius)) ** (1 / 3)
    depth, force = radius * small**2, work * radius
    made = mdr.MaugisDugdale(work, range=depth) if law is mdr.MaugisDugdale else law(work)
    path = mdr.Path(travel=depth * np.array([2.0, 0.3, -0.7, -3.5, -1.6, 0.1]))
    body = contact(mdr.Paraboloid(radius), made, modulus)
    result = mdr.solve(body, path, machine_stiffness=2.0 * force / depth)
    units = {"indentation": depth, "normal_force": force, "contact_radius": radius * small}
    units |= dict.fromkeys(["elastic_energy", "surface_energy", "external_work"], force * depth)
    return {name: column(result, name) / unit for name, unit in units.items()}


@pytest.mark.parametrize("law", [mdr.JKR, mdr.DMT, mdr.MaugisDugdale])
def test_sizes_do_not_matter(law):
    one, other = without_units(law, 1.0, 1.0, 1.0), without_units(law, 3e-9, 2e11, 0.07)
    for name, values in other.items():
        assert values == pytest.approx(one[name], rel=1e-11, abs=1e-11 * np.max(np.abs(one[name])))


# --- energy -----------------------------------------------------------------------------------------------

SWING = {  # channel, values, machine stiffness
    "held": ("indentation", (1.5, -4.0, 0.5), None),
    "soft": ("travel", (1.5, -15.0, 0.5), 0.5),
    "hard": ("travel", (1.5, -4.0, 0.5), 200.0),
    "dead": ("normal_force", (1.5, -2.0, 0.5), None),
}
COHESIVE = mdr.MaugisDugdale(1.0, strength=0.3)
LAWS = {"JKR": JKR, "MaugisDugdale": COHESIVE}


def swing(name, steps):
    """From afar (further than any range of cohesion) or from no load, up, down and up again."""
    channel, targets, k = SWING[name]
    path = mdr.Path(**{channel: [0.0 if name == "dead" else -4.0]})
    for target in targets:
        path = path >> mdr.ramp(**{channel: target}, steps=steps)
    return channel, path, k


def stored(result):
    energy = column(result, "elastic_energy") + column(result, "surface_energy")
    k = result.machine_stiffness
    return energy if k is None else energy + column(result, "normal_force") ** 2 / (2 * k)


def trapezoid(result, channel):
    """The work of the drive after the first row by the rule of trapezoids."""
    drive = column(result, "indentation" if channel == "normal_force" else channel)
    force = column(result, "normal_force")
    return np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(drive))])


@pytest.mark.parametrize(
    ("law", "control"),
    [*(("JKR", name) for name in SWING), ("MaugisDugdale", "soft")],
)
def test_energy_balance_at_any_number_of_steps(law, control):
    results = {}
    finest = 1000
    for steps in (3, finest):
        channel, path, k = swing(control, steps)
        result = results[steps] = mdr.solve(contact(law=LAWS[law]), path, machine_stiffness=k)
        assert balance(result).met
        assert balance(result).measure <= 2e-13
        work, spent = column(result, "external_work"), column(result, "dissipated_energy")
        scale = np.max(np.abs(work)) + spent[-1]
        assert work == pytest.approx(stored(result) + spent, abs=1e-13 * scale)
        assert np.all(column(result, "jump_dissipation") >= 0.0)
        assert spent == pytest.approx(np.cumsum(column(result, "jump_dissipation")), rel=1e-13)
    fine = results[finest]
    assert last(results[3], "dissipated_energy") == pytest.approx(
        last(fine, "dissipated_energy"), rel=1e-12, abs=1e-14
    )
    # a jump is somewhere in its step of the drive, so the rule of trapezoids is of first order
    work = column(fine, "external_work")
    miss = np.max(np.abs(trapezoid(fine, channel) - work)) / np.max(np.abs(work))
    assert miss < 3.0 / finest  # 2.1 measured


RIPPLES = {  # channel, largest and lowest value, machine stiffness
    "held": ("indentation", 0.1, -0.1, None),
    "soft": ("travel", 0.1, -0.25, 0.3),
    "dead": ("normal_force", 0.03, -0.025, None),
}


@pytest.mark.parametrize("control", RIPPLES)
def test_energy_of_many_jumps_at_any_number_of_steps(control):
    channel, top, bottom, k = RIPPLES[control]
    body, results = contact(wavy(0.002, 80.0), mdr.JKR(0.005)), []
    for steps in (1, 500):
        path = mdr.Path(**{channel: [0.0 if control == "dead" else -0.1]})
        for target in (top, bottom, 0.0):
            path = path >> mdr.ramp(**{channel: target}, steps=steps)
        result = mdr.solve(body, path, machine_stiffness=k)
        assert balance(result).met
        assert balance(result).measure < 1e-11  # 1.8e-12 measured, 1e-8 claimed
        results.append(result)
    coarse, fine = results
    assert column(fine, "jumped").sum() >= 5
    work = column(fine, "external_work")
    size = np.max(np.abs(work))
    for name in ("normal_force", "contact_radius", "external_work", "dissipated_energy"):
        rows = column(fine, name)[::500]
        assert column(coarse, name) == pytest.approx(rows, rel=1e-11, abs=1e-12 * np.max(np.abs(rows)))
    # by the rule of trapezoids, which knows nothing of jumps: each is somewhere in its step
    assert np.max(np.abs(trapezoid(fine, channel) - work)) < 2e-2 * size


def test_energy_of_mixed_control():
    n = 200
    path = (
        mdr.Path(indentation=[-4.0])
        >> mdr.indent(0.5, steps=n)
        >> mdr.load(3.0, steps=n)
        >> mdr.travel(-1.0, steps=n)
        >> mdr.load(0.5, steps=n)
        >> mdr.indent(-0.5, steps=n)
        >> mdr.travel(-5.0, steps=n)
        >> mdr.indent(0.2, steps=n)
    )
    result = mdr.solve(contact(), path, machine_stiffness=2.0)
    assert balance(result).measure < 2e-13
    work, spent = column(result, "external_work"), column(result, "dissipated_energy")
    assert work == pytest.approx(stored(result) + spent, abs=1e-13 * np.max(np.abs(work)))
    # the drive of the machine does the work, whatever is prescribed
    miss = np.max(np.abs(trapezoid(result, "travel") - work)) / np.max(np.abs(work))
    assert miss < 3.0 / n  # 1.1 measured
    drive = column(result, "travel")
    depth, force = column(result, "indentation"), column(result, "normal_force")
    assert drive == pytest.approx(depth + force / 2, abs=1e-13)
    assert (drive[3 * n], drive[6 * n]) == pytest.approx((-1.0, -5.0), abs=1e-13)


def test_an_unstable_state_under_a_new_control_jumps():
    """A state that is held by its indentation is lost when its force is held instead."""
    path = mdr.indent(1.0) >> mdr.indent(-1.5) >> mdr.load(-4.0)
    by_depth = mdr.solve(contact(), mdr.indent(1.0) >> mdr.indent(-1.5))
    assert last(by_depth, "normal_stiffness") < 0.0
    result = mdr.solve(contact(), path)
    assert column(result, "jumped").tolist() == [1.0, 0.0, 1.0]
    assert math.isnan(last(result, "indentation"))
    # pressed more, it grows to the stable state of that force
    grown = mdr.solve(contact(), mdr.indent(1.0) >> mdr.indent(-1.5) >> mdr.load(-3.0))
    direct = mdr.solve(contact(), mdr.load(0.0) >> mdr.load(-3.0))
    assert last(grown, "contact_radius") == pytest.approx(last(direct, "contact_radius"), rel=1e-12)
    assert column(grown, "jumped").tolist() == [1.0, 0.0, 1.0]
    work = column(grown, "external_work")
    before, after = stored(grown)[1], stored(grown)[2]
    assert work[2] - work[1] == pytest.approx(after - before + float(grown["jump_dissipation"][2]), rel=1e-12)
    assert float(grown["jump_dissipation"][2]) > 0.0
    # a held force does its work at once, then that of the smooth rest
    a, d, force = (column(grown, name) for name in ("contact_radius", "indentation", "normal_force"))
    at_jump = last(mdr.solve(contact(), mdr.load(0.0) >> mdr.load(force[1])), "contact_radius")

    def rate(x):
        pull = math.sqrt(2 * math.pi * x)
        return 2 * (2 * x**3 / 3 - x * pull) * (2 * x - pull / (2 * x))

    smooth = quad(rate, at_jump, a[2], epsabs=0, epsrel=1e-12)[0]
    jump = force[1] * (at_jump**2 - opening(at_jump, 1.0, 1.0) - d[1])
    assert work[2] - work[1] == pytest.approx(jump + smooth, rel=1e-11)


def test_a_cone_under_a_dead_load_is_only_stable_when_it_is_large():
    """At d = 0 its radius is 4/9 of the least stable one, where nothing round is unstable."""
    cone = contact(mdr.Cone(slope=1.0))
    result = mdr.solve(cone, mdr.indent(0.0) >> mdr.load(-16.0))
    assert result.status.name == "PULLED_OFF"
    assert float(result["contact_radius"][0]) == pytest.approx(8 / math.pi, rel=1e-12)
    weight = 54 / math.pi
    numeric = contact(mdr.Function(lambda r: r, derivative=np.ones_like))
    for body in (cone, numeric):
        assert mdr.pull_off(body, machine_stiffness=0.0).normal_force == pytest.approx(-weight, rel=1e-11)


powers = st.lists(st.tuples(st.floats(0.7, 4.0), st.floats(0.1, 2.0)), min_size=1, max_size=2)
controls = st.sampled_from([("indentation", None), ("travel", 0.7), ("travel", 40.0)])


@given(powers, st.floats(0.01, 1.0), controls, st.lists(st.floats(-3.0, 1.0), min_size=1, max_size=4))
@settings(max_examples=5, deadline=None, derandomize=True)
def test_any_path_on_any_monotone_profile(terms, work, control, values):
    channel, k = control
    body = contact(
        sum((mdr.PowerLaw(n, c, 1.0) for n, c in terms[1:]), mdr.PowerLaw(*terms[0], 1.0)), mdr.JKR(work)
    )
    results = []
    for steps in (1, 5):
        path = mdr.Path(**{channel: [-3.0]})
        for value in values:
            path = path >> mdr.ramp(**{channel: value}, steps=steps)
        results.append(mdr.solve(body, path, machine_stiffness=k))
    coarse, fine = results
    for name in ("normal_force", "contact_radius", "external_work", "dissipated_energy"):
        rows = column(fine, name)[::5]
        assert column(coarse, name) == pytest.approx(rows, rel=1e-11, abs=1e-12 * (1 + np.max(np.abs(rows))))
    assert np.all(column(fine, "jump_dissipation") >= 0.0)
    assert balance(fine).measure < 1e-10
    a = column(fine, "contact_radius")
    parts = [(n, math.sqrt(math.pi) / 2 * n * gamma(n / 2) / gamma((n + 1) / 2) * c * a**n) for n, c in terms]
    pulled = np.sqrt(2 * math.pi * a * work)
    # the springs at the edge are stretched by the opening, those inside are pressed by g(a) - g
    touching = a > 0.0
    depth = sum(g for _, g in parts) - pulled
    force = 2 * a * (sum(n / (n + 1) * g for n, g in parts) - pulled)
    size = 1 + np.max(np.abs(force))
    assert column(fine, "indentation")[touching] == pytest.approx(depth[touching], abs=1e-11 * size)
    assert column(fine, "normal_force") == pytest.approx(np.where(touching, force, 0.0), abs=1e-11 * size)


# --- limits -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", [BALL, mdr.Cone(slope=0.4)])
def test_without_work_the_bare_contact_is_left(profile):
    names = ["normal_force", "contact_radius"]
    bare = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.3))
    errors = []
    for work in (1e-6, 1e-8):
        sticky = mdr.solve(contact(profile, mdr.JKR(work)), mdr.indent(0.3))
        errors.append([abs(last(sticky, name) - last(bare, name)) for name in names])
    # 2 E* a Delta l of JKR is made good by the wider contact, which leaves an error of order work
    orders = -np.diff(np.log10(errors), axis=0)[0] / 2
    assert orders == pytest.approx([1.0, 0.5], abs=2e-3)


def test_the_regime_follows_the_numbers_of_tabor_and_maugis():
    def regime(distance, profile=BALL):
        return mdr.adhesion_regime(contact(profile, mdr.MaugisDugdale(1.0, range=distance)))

    for number, name, law in ((20.0, "JKR", mdr.JKR), (0.03, "DMT", mdr.DMT)):
        result = regime(1.0 / (MAUGIS * number))
        assert result.maugis == pytest.approx(number, rel=1e-13)
        assert result.maugis == pytest.approx(2 * (9 / (16 * math.pi)) ** (1 / 3) * result.tabor, rel=1e-13)
        assert result.regime == name
        assert type(result.recommended) is law
        assert result.pull_off_force["JKR"] == pytest.approx(-1.5 * math.pi, rel=1e-12)
        assert result.pull_off_force["DMT"] == pytest.approx(-2.0 * math.pi, rel=1e-12)
        between = result.pull_off_force["MaugisDugdale"]
        assert -2.0 * math.pi < between < -1.5 * math.pi
        assert result.error["JKR"] == pytest.approx(-1.5 * math.pi / between - 1.0, rel=1e-12)
    sharp = regime(0.01, mdr.Cone(slope=0.5))
    assert math.isnan(sharp.tabor)
    assert math.isnan(sharp.maugis)
    assert sharp.regime == "JKR"


# --- fields -----------------------------------------------------------------------------------------------


def carried(result, step, a):
    """2 pi int_0^a p r dr by Gauss in t, r = a sin t, which takes a root at the edge; graded to a sharp tip."""
    t, weight = np.polynomial.legendre.leggauss(40)
    edges = 0.5 * math.pi * np.array([0.0, 1e-6, 1e-4, 1e-2, 0.2, 0.8, 0.96, 1.0])
    angle = (edges[:-1, None] + 0.5 * np.diff(edges)[:, None] * (t + 1.0)).ravel()
    fraction = (0.5 * np.diff(edges)[:, None] * weight).ravel()
    p = result.field("pressure", a * np.sin(angle), step).values
    return 2 * math.pi * a * a * float(np.sum(fraction * p * np.sin(angle) * np.cos(angle)))


@pytest.mark.parametrize("profile", [BALL, mdr.Sphere(6.0), mdr.PowerLaw(4, 1.0, 1.0), wavy(0.002, 30.0)])
def test_pressure_of_jkr_carries_the_force(profile):
    work = 0.04
    result = mdr.solve(
        contact(profile, mdr.JKR(work)), mdr.indent(0.3) >> mdr.indent(0.0) >> mdr.indent(-0.05)
    )
    for step in range(3):
        a = float(result["contact_radius"][step])
        assert carried(result, step, a) == pytest.approx(float(result["normal_force"][step]), rel=1e-9)
        # next to the edge the pressure is the amplitude over the root of the distance
        near = result.field("pressure", [a * (1 - 1e-8), a, a * (1 + 1e-8)], step)
        amplitude = float(result["edge_amplitude"][step])
        assert float(near[0]) * math.sqrt(1e-8 * a) == pytest.approx(amplitude, rel=1e-3)
        assert near.values[1:].tolist() == [-math.inf, 0.0]
        assert float(near.coords["edge_amplitude"]) == pytest.approx(amplitude, rel=1e-13)
        assert amplitude == pytest.approx(-math.sqrt(work / math.pi), rel=1e-12)  # E* = 1
        assert float(result["stress_intensity"][step]) == pytest.approx(math.sqrt(2 * work), rel=1e-12)
        assert float(result["energy_release_rate"][step]) == pytest.approx(work, rel=1e-12)
        # outside: continuous, open, and growing like the root of the distance
        d = float(result["indentation"][step])
        r = a * np.array([1.0, 1 + 1e-12, 1.0001, 1.01, 1.3, 2.0])
        gap, u = (result.field(name, r, step).values for name in ("gap", "normal_displacement"))
        f = profile.gap(r)
        assert u[0] == pytest.approx(d - f[0], rel=1e-14)
        assert u[1] == pytest.approx(u[0], abs=1e-5 * opening(a, 1.0, work))
        assert gap[0] == 0.0
        assert np.all(np.diff(gap) > 0.0)
        assert gap == pytest.approx(f - d + u, abs=1e-12)
        assert gap[2] == pytest.approx(2 / math.pi * opening(a, 1.0, work) * math.sqrt(2e-4), rel=1e-2)


@pytest.mark.parametrize(
    ("profile", "strength"),
    [(BALL, 1.0), (mdr.Cone(slope=0.5), 0.1), (mdr.PowerLaw(4, 1.0, 1.0), 1.0)],
)
def test_fields_with_a_cohesive_zone(profile, strength):
    work = 0.1
    law = mdr.MaugisDugdale(work, strength=strength)
    d = mdr.Path(indentation=[0.8, 0.0, -0.3 * work / strength, -0.9 * work / strength])
    result = mdr.solve(contact(profile, law), d)
    for step in range(4):
        a, c, force, depth = (
            float(result[name][step])
            for name in ("contact_radius", "cohesive_radius", "normal_force", "indentation")
        )
        if c == 0.0:
            continue
        inner = carried(result, step, a) if a > 0.0 else 0.0
        assert inner - strength * math.pi * (c * c - a * a) == pytest.approx(force, rel=1e-10, abs=1e-12)
        zone = a + (c - a) * np.array([1e-5, 0.1, 0.5, 0.9, 1 - 1e-12])
        assert result.field("pressure", zone, step).values.tolist() == [-strength] * 5
        assert result.field("pressure", [c * (1 + 1e-12), 2 * c], step).values.tolist() == [0.0, 0.0]
        gap = result.field("gap", [*zone, c, c * (1 + 1e-9), 1.5 * c], step).values
        assert gap[5] == pytest.approx(work / strength, rel=1e-11)
        assert gap[4] == pytest.approx(gap[6], rel=1e-5)
        assert np.all(np.diff(gap) > 0.0)
        assert gap[0] >= 0.0
        u = result.field(
            "normal_displacement", step=step, r=[0.0, a, a + 1e-10 * c, c, c * (1 + 1e-10)]
        ).values
        if a > 0.0:
            assert result.field("pressure", [a * (1 - 1e-13)], step).values == pytest.approx(
                -strength, abs=1e-5 * strength + 1e-5
            )
            assert u[0] == depth
            assert u[1] == pytest.approx(depth - float(profile.gap(a)), rel=1e-13)
            assert u[2] == pytest.approx(u[1], abs=1e-8)
        # the displacement has a logarithm at the end of the zone
        assert u[4] == pytest.approx(u[3], abs=2e-9 * strength * c)


def test_fields_of_cohesion_at_a_distance():
    """Before the bodies touch: u = -(4 sigma0 c / pi E*) E(r/c) under a constant tension."""
    result = mdr.solve(contact(law=COHESIVE), mdr.Path(indentation=[-4.0, -2.0]))
    c = last(result, "cohesive_radius")
    assert last(result, "contact_radius") == 0.0
    assert last(result, "normal_force") == pytest.approx(-0.3 * math.pi * c * c, rel=1e-13)
    lift = 2 * 0.3 * c
    expected = {"normal_displacement": -lift, "gap": 2.0 - lift, "pressure": -0.3, "spring_force": -lift}
    for name, value in expected.items():
        assert result.field(name, [0.0, 1e-9], 1).values == pytest.approx(value, rel=1e-13), name
        free = 4.0 if name == "gap" else 0.0
        assert result.field(name, [0.0, 1e-9], 0).values == pytest.approx(free, rel=1e-15), name


@pytest.mark.parametrize("law", [JKR, COHESIVE])
def test_fields_of_a_punch_that_is_pressed_at_its_edge(law):
    result = mdr.solve(contact(mdr.FlatPunch(0.8), law), mdr.indent(0.5))
    r = np.array([0.0, 0.4, 0.79])
    boussinesq = 0.5 / (math.pi * np.sqrt(0.64 - r * r))
    assert result.field("pressure", r).values == pytest.approx(boussinesq, rel=1e-13)
    edge = result.field("pressure", [0.8])
    assert float(edge[0]) == math.inf
    assert float(edge.coords["edge_amplitude"]) == pytest.approx(0.5 / (math.pi * math.sqrt(1.6)), rel=1e-13)
    assert carried(result, 0, 0.8) == pytest.approx(last(result, "normal_force"), rel=1e-11)
    assert result.field("normal_displacement", [1.6]).values == pytest.approx(
        2 / math.pi * 0.5 * math.asin(0.5), rel=1e-13
    )
    if isinstance(law, mdr.JKR):
        assert last(result, "stress_intensity") == pytest.approx(-0.5 / math.sqrt(0.8 * math.pi), rel=1e-13)
        assert last(result, "energy_release_rate") == 0.0


@settings(max_examples=examples(12), deadline=None)
@given(
    radius=st.floats(-8.0, -5.0),
    modulus=st.floats(6.0, 11.0),
    work=st.floats(-3.0, -1.0),
    range_=st.floats(-9.6, -7.5),
    strain=st.floats(-5.0, -1.0),
)
def test_sharp_punches_of_any_size_under_a_load(radius, modulus, work, range_, strain):
    b, modulus, work, range_ = (10.0**x for x in (radius, modulus, work, range_))
    force = modulus * b * b * 10.0**strain
    for law in (mdr.JKR(work), mdr.MaugisDugdale(work, range=range_)):
        result = mdr.solve(contact(mdr.FlatPunch(b), law, modulus), mdr.load(0.0) >> mdr.load(force, steps=2))
        assert balance(result).met
        assert last(result, "contact_radius") == b
        assert last(result, "indentation") == pytest.approx(force / (2 * modulus * b), rel=1e-9)
        if isinstance(law, mdr.JKR):
            assert last(result, "energy_release_rate") == 0.0
            assert last(result, "stress_intensity") < 0.0


@settings(max_examples=examples(25), deadline=None)
@given(b=st.floats(0.01, 10.0), work=st.floats(1e-4, 1.0), fraction=st.floats(-0.999, 3.0))
@example(b=1.71875, work=1.0, fraction=2.220446049250313e-16)
def test_a_sharp_edge_releases_energy_only_where_it_is_open(b, work, fraction):
    d = fraction * opening(b, 1.0, work)
    result = mdr.solve(contact(mdr.FlatPunch(b), mdr.JKR(work)), mdr.indent(max(d, 0.0)) >> mdr.indent(d))
    released = work * max(-fraction, 0.0) ** 2
    assert last(result, "energy_release_rate") == pytest.approx(released, rel=1e-12, abs=1e-14 * work)


def test_claims_report_an_energy_balance_that_is_not_met(monkeypatch):
    monkeypatch.setattr("pymdr.solving.adhesive.energy_residual", lambda track, history: 1e-3)
    result = mdr.solve(contact(), mdr.indent(0.1))
    assert not balance(result).met
    for name in ("normal_force", "dissipated_energy", "contact_radius"):
        assert result.claims[name].level is mdr.Level.APPROXIMATE
        assert "relative residual of 0.001" in result.claims[name].reason
        assert np.all(result.claims[name].error >= 1e-3)


# --- status and refusals ----------------------------------------------------------------------------------


def test_rows_after_a_dead_load_has_won_are_not_a_number():
    result = mdr.solve(contact(), mdr.load(1.0, steps=4) >> mdr.load(-6.0, steps=7))
    force = 1.0 - np.arange(1, 8)
    stays = np.concatenate([np.full(4, True), force > -1.5 * math.pi])
    assert stays.tolist() == [True] * 9 + [False] * 2
    for name in map(str, result.data):
        known = name in ("jumped", "jump_dissipation", "dissipated_energy", "external_work")
        assert np.isfinite(column(result, name)).tolist() == (stays | known).tolist(), name
        assert result.claims[name].where.tolist() == (stays | known).tolist(), name
    assert column(result, "jumped").tolist() == [1.0] + [0.0] * 8 + [1.0, 0.0]
    assert any(note.startswith("pulled off at d = -773.4") for note in result.notes)
    with pytest.raises(mdr.NotValidError, match="2 of 11 steps: a dead load has separated the bodies"):
        result.field("pressure", [0.0, 1.0])
    for text in (result.summary(), result._repr_html_()):
        last = text.partition("Claims")[0]
        assert (
            last.count("not valid") == np.count_nonzero([not c.where[-1] for c in result.claims.values()]) - 4
        )
    path = mdr.load(0.0) >> mdr.load(-6.0)
    for leg in (mdr.indent(1.0), mdr.cycle(indentation=1.0)):
        with pytest.raises(mdr.PathError, match=r"lost under a prescribed force.* begin the leg with Path\("):
            mdr.solve(contact(), path >> leg)
    again = mdr.solve(contact(), path >> mdr.Path(indentation=[0.5, 1.0]))
    fresh = mdr.solve(contact(), mdr.Path(indentation=[0.5, 1.0]))
    for name in ("normal_force", "contact_radius", "indentation"):
        assert column(again, name)[2:].tolist() == column(fresh, name).tolist()
    spent = column(again, "dissipated_energy")
    assert spent[2:] == pytest.approx(spent[1] + column(fresh, "dissipated_energy"), rel=1e-12)


def test_loads_continue_after_loss_of_contact():
    pulled = mdr.load(0.0) >> mdr.load(-6.0)
    after = mdr.solve(contact(), pulled >> mdr.hold(steps=3))
    assert after.status is mdr.Status.PULLED_OFF
    assert np.isnan(column(after, "normal_force")[1:]).all()
    back = mdr.solve(contact(), pulled >> mdr.load(2.0, steps=8))
    fresh = mdr.solve(contact(), mdr.load(2.0, steps=2))
    rows = -6.0 + np.arange(1, 9)
    assert np.isfinite(column(back, "normal_force")[2:]).tolist() == (rows >= 0.0).tolist()
    for name in ("normal_force", "indentation", "contact_radius"):
        assert column(back, name)[-2:] == pytest.approx(column(fresh, name), rel=1e-12)
    assert column(back, "jumped").tolist() == [1.0, 1.0] + [0.0] * 5 + [1.0, 0.0, 0.0]
    shaken = mdr.solve(contact(), pulled >> mdr.cycle(normal_force=8.0, steps=8))
    assert np.isfinite(column(shaken, "normal_force")[2:]).tolist() == [False, True, True] + [False] * 5


@settings(max_examples=5, deadline=None)
@given(
    st.sampled_from([mdr.Paraboloid(1.0), mdr.Cone(slope=1.0), mdr.PowerLaw(4.0, 1.0, 1.0), mdr.Sphere(9.0)]),
    st.sampled_from([mdr.JKR(1.0), mdr.MaugisDugdale(1.0, range=0.5), mdr.MaugisDugdale(1.0, range=2.0)]),
    st.floats(0.5, 2.0),
)
def test_what_a_dead_load_loses_is_the_area_above_it(profile, law, young):
    """To where the bodies can last touch: the loss there, and what the load does more than the contact on the way."""
    body = mdr.Contact(profile, mdr.Elastic(young, 0.0), adhesion=law)
    fall, torn = mdr.pull_off(body, machine_stiffness=0.0), mdr.pull_off(body)
    far, near = torn.indentation, fall.indentation
    # dense where the force has a vertical tangent
    d = far + (near - far) * np.linspace(1.0, 1e-4, 4001) ** 2
    start = mdr.Path(indentation=[max(2.0 * abs(near), near + 1.0)])
    followed = mdr.solve(body, start >> mdr.Path(indentation=d))
    force = column(followed, "normal_force")[1:]
    area = float(np.trapezoid((force - fall.normal_force)[::-1], d[::-1]))
    assert fall.dissipated_energy == pytest.approx(torn.dissipated_energy + area, rel=1e-5)
    loads = mdr.load(0.0) >> mdr.load(2.0 * fall.normal_force, steps=3)
    torn_away = mdr.solve(body, loads)
    assert column(torn_away, "jump_dissipation").max() >= 0.0
    assert column(torn_away, "jump_dissipation")[1:].sum() == pytest.approx(fall.dissipated_energy, rel=1e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.DMT(0.0), r"^work = 0.*above 0 J/m\^2"),
        (lambda: mdr.MaugisDugdale(0.0, strength=1.0), r"^work = 0.*above 0"),
        (lambda: mdr.MaugisDugdale(1.0, range=-1.0), r"range = -1.*above 0 m"),
        (lambda: mdr.DMT(1.0, range=0.0), r"^range = 0.*above 0 m"),
        (lambda: mdr.Contact(BALL, UNIT, adhesion="JKR"), r"^adhesion = 'JKR'"),
    ],
)
def test_refused_laws(make, words):
    with pytest.raises(mdr.ProblemError, match=words):
        make()


HOLLOW = mdr.Function(
    lambda r: r * r / 2 - 0.1 * np.sin(4 * r) ** 2, derivative=lambda r: r - 0.4 * np.sin(8 * r)
)
SHORT = mdr.Sampled(np.linspace(0, 1, 12), np.linspace(0, 1, 12) ** 2 / 2)
REFUSED = {
    "pull on nothing": (
        contact(),
        mdr.load(-1.0),
        mdr.PathError,
        r"normal_force = -1 N.*cannot be pulled.*-4\.71239 N",
    ),
    "pull on what was lost": (
        contact(),
        mdr.indent(1.0) >> mdr.indent(-3.0) >> mdr.load(-0.5, steps=2),
        mdr.PathError,
        r"normal_force = -250 mN.*out of contact cannot be pulled",
    ),
    "below pull-off": (contact(), mdr.load(-9.0, steps=3), mdr.PathError, "out of contact cannot be pulled"),
    "falling cohesion": (
        contact(wavy(0.02, 20.0), mdr.MaugisDugdale(0.002, strength=1.0)),
        mdr.indent(0.1),
        mdr.ProblemError,
        "^the equivalent profile decreases somewhere.*JKR",
    ),
    "end of the data": (
        contact(SHORT, mdr.JKR(0.01)),
        mdr.indent(1.5),
        mdr.PathError,
        r"indentation or travel = 1\.5 m.*pass r = 1 m.*allows is 749\.337 mm",
    ),
    "data that end before the contact": (
        contact(SHORT, mdr.JKR(2.0)),
        mdr.indent(0.1),
        mdr.PathError,
        r"indentation or travel = 100 mm.*last radius at which the profile is known",
    ),
    "data that end before the zone": (
        contact(SHORT, mdr.MaugisDugdale(0.01, strength=0.001)),
        mdr.indent(0.1),
        mdr.ProblemError,
        "known only to 1 m, but cohesion of range 10 m extends beyond",
    ),
    "the whole sphere": (
        contact(mdr.Sphere(0.1), mdr.JKR(0.001)),
        mdr.indent(5.0),
        mdr.PathError,
        r"indentation or travel = 5 m: a sphere cannot be pressed in by its radius; .* allows is 100 mm",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_paths(name):
    body, path, error, words = REFUSED[name]
    with pytest.raises(error, match=words):
        mdr.solve(body, path)


def test_values_that_are_not_numbers_are_refused():
    with pytest.raises(mdr.UnitError, match=r"^indentation\[1\]: nan is not finite"):
        mdr.Path(indentation=[0.1, math.nan])
    with pytest.raises(
        mdr.ProblemError,
        match="rings solve frictionless contacts without machine, and without adhesion but that of a cohesive zone",
    ):
        mdr.solve(contact(), mdr.indent(0.1), solver=mdr.Rings(20))


@pytest.mark.parametrize("law", [mdr.JKR(0.3), mdr.DMT(0.3), mdr.MaugisDugdale(0.3, strength=1.0)])
def test_spheres_under_strong_adhesion(law):
    """The contact is nearly as wide as the sphere, whose g is infinite there."""
    result = mdr.solve(contact(mdr.Sphere(1.0), law), mdr.indent(0.2) >> mdr.indent(0.9))
    a, d = column(result, "contact_radius"), column(result, "indentation")
    g = a * np.arctanh(a)
    if isinstance(law, mdr.JKR):
        assert d == pytest.approx(g - np.sqrt(2 * math.pi * a * 0.3), rel=1e-11)
    elif isinstance(law, mdr.DMT):
        assert d == pytest.approx(g, rel=1e-12)
    else:
        c = column(result, "cohesive_radius")
        assert np.all(c < 1.0)
        assert d == pytest.approx(g - 2 * np.sqrt(c * c - a * a), rel=1e-11)
    assert balance(result).measure < 1e-12


def test_an_attraction_of_long_range_on_a_callable():
    """f(c) = range lies beyond every radius of contact: the profile is mapped as far as that."""
    bowl = mdr.Function(lambda r: r * r / 2, derivative=lambda r: r)
    law = mdr.DMT(0.01, range=2.0)
    numeric, closed = (mdr.solve(contact(p, law), mdr.indent(0.1)) for p in (bowl, BALL))
    assert last(numeric, "normal_force") == pytest.approx(last(closed, "normal_force"), rel=1e-11)


# --- files and rows ---------------------------------------------------------------------------------------

KEPT = {
    "dead load": (
        contact(),
        mdr.load(1.0, steps=2, duration=3.0) >> mdr.load(-6.0, steps=4, duration=2.0),
        None,
    ),
    "machine": (contact(mdr.Sphere(3.0)), mdr.travel(1.0, steps=3) >> mdr.travel(-7.0, steps=3), 0.7),
}


@pytest.mark.parametrize("name", KEPT)
def test_files_and_pickles_keep_everything(name, tmp_path):
    body, path, k = KEPT[name]
    result = mdr.solve(body, path, machine_stiffness=k)
    result.save(tmp_path / "r.nc")
    for other in (mdr.open_result(tmp_path / "r.nc"), pickle.loads(pickle.dumps(result))):
        assert other.contact == result.contact
        assert other.path == result.path
        assert other.data.identical(result.data)
        assert other.status is result.status
        assert other.assumptions == result.assumptions
        assert other.notes == result.notes
        assert other.references == result.references
        assert other.machine_stiffness == result.machine_stiffness == k
        assert other.cite() == result.cite()
        assert other.summary() == result.summary()
        assert other.claims.keys() == result.claims.keys()
        for key, claim in result.claims.items():
            kept = other.claims[key]
            assert (kept.level, kept.reason, kept.source) == (claim.level, claim.reason, claim.source)
            assert kept.where.tolist() == claim.where.tolist()
        r = np.linspace(0.0, 3.0, 13)
        for key in ("pressure", "normal_displacement", "gap", "spring_force", "equivalent_profile"):
            one, two = (each.field(key, r, step=None) for each in (result, other))
            assert one.identical(two), key


@pytest.mark.parametrize(("law", "control"), [("JKR", "dead"), ("JKR", "soft")])
def test_rows_do_not_depend_on_the_rows_between(law, control):
    few, many = 4, 40
    results = []
    for steps in (few, many):
        _, path, k = swing(control, steps)
        results.append(mdr.solve(contact(law=LAWS[law]), path, machine_stiffness=k))
    stride = many // few
    for name in map(str, results[0].data):
        if name in ("jumped", "jump_dissipation"):
            continue
        one, other = column(results[0], name)[1:], column(results[1], name)[stride::stride]
        size = np.nanmax(np.abs(other), initial=0.0)
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12 * size, nan_ok=True), name
    jumps = [column(result, "jump_dissipation") for result in results]
    assert jumps[0][0] == pytest.approx(jumps[1][0], rel=1e-12)
    summed = jumps[1][1:].reshape(-1, stride).sum(axis=1)
    assert jumps[0][1:] == pytest.approx(summed, rel=1e-12, abs=1e-13, nan_ok=True)


# --- independent simulation -------------------------------------------------------------------------------


def struve_zero(x):
    """H_0 = (2 / pi) int_0^(pi/2) sin(x cos t) dt for x < 100: that of scipy is nan near its zeros (scipy#5979)."""
    node, weight = np.polynomial.legendre.leggauss(100)
    return 0.5 * np.sin(np.multiply.outer(x, np.cos(0.25 * math.pi * (node + 1.0)))) @ weight


@cache
def tabulated(h, k, work, top=0.6):
    return Table(h, k, work, top)


class Table:
    """Equilibria of a rippled paraboloid R = E* = 1 in a dense table, followed by running extremes."""

    def __init__(self, h, k, work, top=0.6, n=60_001):
        self.a = a = np.linspace(0.0, top, n)
        self.g = g = a * a + 0.5 * math.pi * h * k * a * struve_zero(k * a)
        inside = np.concatenate([[0.0], np.cumsum(0.5 * (g[1:] + g[:-1]) * np.diff(a))])
        self.work = work
        self.d = g - np.sqrt(2 * math.pi * a * work)
        self.force = 2 * (a * self.d - inside)

    def follow(self, level, values):
        """Rows of the table: the contact grows while the control is above the curve, shrinks while below."""
        now, answer = 0, []  # row 0 is no contact
        for value in values:
            if value >= (level[now] if now else 0.0):
                beyond = now + 1 + np.flatnonzero(level[now + 1 :] >= value)
                now = int(beyond[0])
            else:
                below = np.flatnonzero(level[1 : now + 1] <= value)
                now = 1 + int(below[-1]) if below.size else 0
            answer.append(now)
        return np.array(answer)


@pytest.mark.parametrize("control", ["indentation", "normal_force", 0.3])
def test_a_wavy_profile_against_a_table(control):
    h, k, work = 0.002, 80.0, 0.005
    table = tabulated(h, k, work)
    level = {"indentation": table.d, "normal_force": table.force, 0.3: table.d + table.force / 0.3}[control]
    top, bottom = {"indentation": (0.1, -0.07), "normal_force": (0.03, -0.05), 0.3: (0.1, -0.25)}[control]
    up = np.linspace(0.0, top, 41)
    values = np.concatenate([up, np.linspace(top, bottom, 83)[1:], np.linspace(bottom, top, 60)[1:]])
    name = control if isinstance(control, str) else "travel"
    result = mdr.solve(
        contact(wavy(h, k), mdr.JKR(work)),
        mdr.Path(**{name: values}),
        machine_stiffness=None if isinstance(control, str) else control,
    )
    rows = table.follow(level, values)
    a, force = column(result, "contact_radius"), column(result, "normal_force")
    positive = rows > 0
    assert np.count_nonzero(np.abs(np.diff(rows)) > 2000) >= 4
    assert (np.nan_to_num(a) > 0.0).tolist() == positive.tolist()
    # a row of the table is 1e-5 wide, and the force changes by 1.6 times that: its size is 0.03
    assert a[positive] == pytest.approx(table.a[rows[positive]], abs=1.1e-5)
    assert force[positive] == pytest.approx(table.force[rows[positive]], abs=2e-5)
    # a body that a dead load has torn off is nowhere
    gone = ~positive if control == "normal_force" else np.zeros(positive.shape, dtype=bool)
    assert result.claims["normal_force"].where.tolist() == (~gone).tolist()


def falling(level, start):
    """Rows that a contact passes when its control falls from a row until it is lost: new minima on the way."""
    down = level[start:0:-1]
    return start - np.flatnonzero(down <= np.minimum.accumulate(down))


@settings(max_examples=6, deadline=None)
@given(
    height=st.floats(0.001, 0.006),
    wave=st.floats(20.0, 90.0),
    work=st.floats(0.004, 0.02),
    stiffness=st.sampled_from([0.0, 0.3, 3.0, math.inf]),
)
@example(height=0.00390625, wave=63.25, work=0.015625, stiffness=0.0)
def test_the_largest_pull_of_a_retraction_is_that_of_a_table(height, wave, work, stiffness):
    table = Table(height, wave, work, top=1.0, n=40_001)
    level = (
        table.force
        if stiffness == 0.0
        else table.d + (0.0 if math.isinf(stiffness) else table.force / stiffness)
    )
    unloaded = 1 + int(np.flatnonzero(table.force[1:] >= 0.0)[0])
    # pressed by the machine until the contact is as large as that of the unloaded body
    most = np.maximum.accumulate(np.maximum(level[1:], 0.0))
    grown = 1 + np.flatnonzero(np.concatenate([[True], level[2:] >= most[:-1]]) & (level[1:] >= 0.0))
    start = int(grown[grown >= unloaded][0])
    passed = falling(level, start)
    result = mdr.pull_off(contact(wavy(height, wave), mdr.JKR(work)), machine_stiffness=stiffness)
    # a row of the table is 2.5e-5 wide
    assert result.largest_pull == pytest.approx(table.force[passed].min(), abs=1e-4 * work)
    assert result.normal_force == pytest.approx(table.force[passed[-1]], abs=2e-2 * work)


@settings(max_examples=examples(30), deadline=None)
@given(
    exponent=st.floats(0.8, 5.0),
    height=st.floats(0.01, 10.0),
    work=st.floats(1e-4, 1.0),
    stiffness=st.sampled_from([1e-3, 1.0, 1e3, math.inf]),
)
def test_a_tip_pulls_most_where_a_dead_load_would_lose_it(exponent, height, work, stiffness):
    tip = contact(mdr.PowerLaw(exponent, height, 1.0), mdr.JKR(work))
    dead = float(power_law_pull_off(exponent, height, 1.0, work, 0.0).normal_force)
    result = mdr.pull_off(tip, machine_stiffness=stiffness)
    assert result.largest_pull == pytest.approx(dead, rel=1e-10)
    least_force = float(power_law_pull_off(exponent, height, 1.0, work, stiffness).normal_force)
    assert result.normal_force == pytest.approx(least_force, rel=1e-9)


@settings(max_examples=examples(20), deadline=None)
@given(fraction=st.floats(0.05, 2.0), exponent=st.floats(1.0, 3.0), stiffness=st.sampled_from([0.0, 1e6]))
def test_a_profile_that_ends_too_early_is_refused_as_by_solve(fraction, exponent, stiffness):
    law = mdr.JKR(0.01)
    unloaded = mdr.solve(contact(mdr.PowerLaw(exponent, 1.0, 1.0), law), mdr.load(0.0))
    r = np.linspace(0.0, fraction * last(unloaded, "contact_radius"), 60)
    known = contact(mdr.Sampled(r, r**exponent), law)
    if fraction > 1.01:
        assert mdr.pull_off(known, machine_stiffness=stiffness).jump_in_radius > 0.0
    elif fraction < 0.99:
        for call in (
            lambda: mdr.pull_off(known, machine_stiffness=stiffness),
            lambda: mdr.solve(known, mdr.load(0.0)),
        ):
            with pytest.raises(mdr.PathError, match="known"):
                call()


# --- certificate ------------------------------------------------------------------------------------------


def lowest_gap(table, a, d, top):
    """The least (2/pi) int_a^r (g - d) / sqrt(r^2 - x^2) dx outside a disk, by x = r sin t."""
    t, weight = np.polynomial.legendre.leggauss(120)
    r = np.linspace(a * 1.001, top, 150)[:, None]
    low = np.arcsin(a / r)
    span = 0.5 * (0.5 * math.pi - low)
    g = np.interp(r * np.sin(low + span * (t + 1)), table.a, table.g)
    return float(np.min(2 / math.pi * span[:, 0] * ((g - d) @ weight)))


def test_a_bump_that_touches_again_is_not_certified():
    h, k, work = 0.03, 20.0, 0.001
    result = mdr.solve(contact(wavy(h, k), mdr.JKR(work)), there_and_back(0.15, -0.1, 20))
    assert result.status.name == "ADHESION_PARTLY_REFUSED"
    claim = result.claims["normal_force"]
    assert 0 < np.count_nonzero(claim.where) < 20
    assert "the surfaces touch again outside a disk" in claim.reason
    for name in ("normal_force", "contact_radius", "indentation", "energy_release_rate"):
        assert np.isnan(column(result, name)).tolist() == (~result.claims[name].where).tolist()
    bad = int(np.flatnonzero(~claim.where)[0])
    with pytest.raises(mdr.NotValidError, match="touch again outside"):
        result.field("pressure", step=bad)
    # every state between the rows too, by a table of its own: nothing is claimed after the first that touches
    table = tabulated(h, k, work, 1.0)
    fine = 0.15 * np.arange(1, 201) / 200
    followed = table.follow(table.d, fine)
    gaps = np.array([lowest_gap(table, table.a[row], d, 0.9) for row, d in zip(followed, fine, strict=True)])
    first = fine[np.flatnonzero(gaps < -1e-8)[0]]
    assert claim.where.tolist() == [i < 20 and 0.15 * (i + 1) / 20 < first for i in range(40)]


@settings(max_examples=6, deadline=None)
@given(
    depth=st.floats(0.3, 20.0),
    wave=st.floats(15.0, 60.0),
    work=st.floats(1e-4, 0.01),
    top=st.floats(0.01, 0.12),
    control=st.sampled_from(["indentation", "normal_force"]),
)
def test_claims_do_not_depend_on_the_steps_and_no_jump_gains_energy(depth, wave, work, top, control):
    body = contact(wavy(depth / wave**2, wave), mdr.JKR(work))
    values = np.concatenate([top * np.arange(1, 25) / 24, top - 1.5 * top * np.arange(1, 25) / 24])
    whole, few = (mdr.solve(body, mdr.Path(**{control: values[i::n]})) for i, n in ((0, 1), (7, 8)))
    name = "jump_dissipation"
    assert few.claims[name].where.tolist() == whole.claims[name].where[7::8].tolist()
    for result in (whole, few):
        if result.claims[name].readable:
            dissipated = result.data[name].values
            assert np.nanmin(dissipated, initial=0.0) >= -1e-12 * work
            # nothing comes back after the first row that is refused
            assert np.all(np.diff(result.claims[name].where.astype(int)) <= 0)


def test_a_falling_profile_that_stays_open_is_certified():
    h, k, work = 0.02, 20.0, 0.003
    table = tabulated(h, k, work, 1.0)
    assert np.any(np.diff(table.g) < 0.0)
    result = mdr.solve(contact(wavy(h, k), mdr.JKR(work)), there_and_back(0.15, -0.1, 12))
    assert result.status.name == "PULLED_OFF"
    assert all(claim.where.all() for claim in result.claims.values())
    assert "has not opened inside" in result.claims["normal_force"].reason
    for a, d in zip(column(result, "contact_radius"), column(result, "indentation"), strict=True):
        assert a == 0.0 or lowest_gap(table, a, d, 0.9) > 0.0


def test_a_contact_that_is_never_a_disk_keeps_what_is_prescribed():
    result = mdr.solve(contact(wavy(15 / 1600, 40.0), mdr.JKR(1e-4)), mdr.indent(0.06))
    assert result.status is mdr.Status.ADHESION_REFUSED
    assert column(result, "indentation").tolist() == [0.06]
    assert not result.claims["normal_force"].readable
    assert "touch again outside" in str(result)
    assert result._repr_html_()


# --- tips that are flat, worn or measured -----------------------------------------------------------------------

FLAT = 1e-7
STIFF = mdr.Elastic("1 GPa", 0.3)
WORN = mdr.Function(
    lambda r: 0.3 * np.maximum(r - FLAT, 0.0), derivative=lambda r: 0.3 * (r > FLAT), breakpoints=(FLAT,)
)
BLUNT = mdr.Function(
    lambda r: 0.1 * r + 0.3 * np.maximum(r - FLAT, 0.0),
    derivative=lambda r: 0.1 + 0.3 * (r > FLAT),
    breakpoints=(FLAT,),
)


@pytest.mark.parametrize(
    ("profile", "law"),
    [
        (WORN, mdr.JKR("50 mJ/m^2")),
        (WORN, mdr.DMT("50 mJ/m^2", range="1 nm")),
        (WORN, mdr.MaugisDugdale("50 mJ/m^2", range="1 nm")),
        (BLUNT, mdr.JKR("50 mJ/m^2")),
        (BLUNT, mdr.DMT("50 mJ/m^2", range="1 nm")),
    ],
)
def test_cycles_of_tips_with_a_corner(profile, law):
    """Behind a corner g' grows like an inverse square root, and a flat end touches all at once."""
    result = mdr.solve(mdr.Contact(profile, STIFF, adhesion=law), mdr.indent("20 nm") >> mdr.indent("-20 nm"))
    balance = [a for a in result.assumptions if a.name == "energy balance"]
    assert [a.met for a in balance] == [True]
    assert balance[0].measure < 1e-10
    assert result.status.name == "PULLED_OFF"


@pytest.mark.long
@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-3.0, 0.5), st.floats(-1.5, -0.3), st.floats(-1.0, 1.0), st.sampled_from(["jkr", "maugis"]))
def test_unloading_to_a_corner_is_checked_as_loading_is(log_flat, log_slope, log_strength, law):
    """Energies are right to rounding on both ways, however small the flat beside the zone."""
    slope, work, young = 10.0**log_slope, 0.05, 1e9
    size = work / (young * slope**2)
    strength = 10.0**log_strength * young * slope
    adhesion = mdr.JKR(work) if law == "jkr" else mdr.MaugisDugdale(work, strength=strength)
    tip = mdr.TruncatedCone(10.0**log_flat * size, slope=slope)
    depth = 5.0 * slope * size
    result = mdr.solve(
        mdr.Contact(tip, STIFF, adhesion=adhesion), mdr.indent(depth) >> mdr.indent(-10.0 * depth)
    )
    assert [a.measure < 1e-11 for a in result.assumptions if a.name == "energy balance"] == [True]


@pytest.mark.parametrize("depth", [0.5e-9, 3e-9, 6e-9])
def test_a_measured_worn_tip_is_that_of_the_flat_and_its_flank(depth):
    r = np.linspace(0.0, 40e-9, 41)
    sampled = mdr.Sampled(r, 0.4 * np.maximum(r - 8e-9, 0.0), interpolation=mdr.ShapePreserving())
    spline = sampled.spline
    knots = spline.x[1:-1]

    def g(x):
        marks = [0.0, *knots[knots < x], x]
        return x * sum(
            quad(
                lambda phi: float(spline(x * math.sin(phi), 1)), *np.arcsin(np.array(pair) / x), epsrel=1e-12
            )[0]
            for pair in pairwise(marks)
        )

    a = brentq(lambda x: g(x) - depth, 8e-9, 39e-9, xtol=1e-22, rtol=1e-13)
    marks = [0.0, 8e-9, *knots[(knots > 8.5e-9) & (knots < a)], a]
    pressed = sum(quad(lambda x: depth - g(x), *pair, epsrel=1e-10)[0] for pair in pairwise(marks))
    result = mdr.solve(mdr.Contact(sampled, STIFF), mdr.indent(depth))
    modulus = 1e9 / (1.0 - 0.3**2)
    assert column(result, "contact_radius")[-1] == pytest.approx(a, rel=1e-10)
    assert column(result, "normal_force")[-1] == pytest.approx(2.0 * modulus * pressed, rel=1e-9)


def image_of(spline, x):
    """g of a piecewise polynomial, by Gauss in the angle piece by piece."""
    t, weight = np.polynomial.legendre.leggauss(24)
    angle = np.arcsin(np.minimum(np.append(spline.x, np.inf) / x[:, None], 1.0))
    middle, half = 0.5 * (angle[:, 1:] + angle[:, :-1]), 0.5 * np.diff(angle, axis=1)
    nodes = middle[..., None] + half[..., None] * t
    return x * np.einsum("ijk,k,ij->i", spline(x[:, None, None] * np.sin(nodes), 1), weight, half)


@pytest.mark.parametrize("seed", first_of(range(6), 2))
def test_noisy_samples_of_any_size_are_mapped(seed):
    rng = np.random.default_rng(seed)
    for n in (21, 41, 200):
        size = 10.0 ** rng.uniform(-9.0, 0.0)
        r = np.linspace(0.0, size, n)
        for h in (r * r / (2.0 * size), 0.4 * np.maximum(r - 0.3 * size, 0.0)):
            noisy = h + 10.0 ** rng.uniform(-5.0, -2.5) * size * rng.normal(size=n)
            for interpolation in (mdr.ShapePreserving(), mdr.CubicSpline()):
                sampled = mdr.Sampled(r, noisy - noisy[0], interpolation=interpolation)
                line = equivalent_profile(sampled)
                x = size * np.linspace(0.01, 0.89, 50)
                assert np.isfinite(line.slope(x)).all()
                rough = image_of(sampled.spline, x)
                assert np.max(np.abs(line.g(x) - rough)) <= 1e-11 * np.max(np.abs(rough))


def test_a_soft_machine_pulls_a_sampled_tip_by_maugis():
    """The bracket of a zone once swung to and fro."""
    r = np.linspace(0.0, 30e-9, 20)
    tip = mdr.Sampled(r, r * r / 60e-9, interpolation=mdr.ShapePreserving())
    results = [
        mdr.pull_off(
            mdr.Contact(tip, mdr.Elastic("2 GPa", 0.3), adhesion=mdr.MaugisDugdale(0.05, range="0.5 nm")),
            machine_stiffness=k,
        ).normal_force
        for k in (0.0, 2.0, math.inf)
    ]
    assert results[0] <= results[1] <= results[2] < 0.0


@pytest.mark.parametrize("law", [None, mdr.JKR("5 mJ/m^2"), mdr.DMT("5 mJ/m^2", range="1 nm")])
def test_an_indentation_by_the_height_of_a_corner(law):
    """f of the corner is the indentation itself, a round number: no sliver of a panel is left beside it."""
    at, nearby = (
        column(mdr.solve(mdr.Contact(BLUNT, STIFF, adhesion=law), mdr.indent(d)), "normal_force")[-1]
        for d in (1e-8, 1e-8 * (1.0 + 1e-7))
    )
    assert at == pytest.approx(nearby, rel=1e-6)


@pytest.mark.parametrize("short", [1e-3, 1e-6, 1e-12])
def test_the_stiffness_at_a_corner_is_that_of_a_punch(short):
    """Both rates over the radius grow without bound at the corner; their ratio is 2 E* b there."""
    b, modulus = 1e-8, 1e11 / (1.0 - 0.3**2)
    worn = mdr.Function(
        lambda r: 0.3 * np.maximum(r - b, 0.0), derivative=lambda r: 0.3 * (r > b), breakpoints=(b,)
    )
    tip = mdr.Contact(worn, mdr.Elastic("100 GPa", 0.3), adhesion=mdr.JKR("1 mJ/m^2"))
    lowest = mdr.pull_off(tip).indentation
    pulled = mdr.solve(tip, mdr.indent("1 nm") >> mdr.indent((1.0 - short) * lowest))
    assert column(pulled, "normal_stiffness")[-1] == pytest.approx(2.0 * modulus * b, rel=1e-6)


# --- flats with rounded edges -----------------------------------------------------------------------------------


def rounded_flat(b, radius, n, *, derivative=True):
    """f = R ((r - b)/R)^n beyond a flat end b."""
    return mdr.Function(
        lambda r: radius * (np.maximum(r - b, 0.0) / radius) ** n,
        derivative=(lambda r: n * np.where(r > b, (np.maximum(r - b, 0.0) / radius) ** (n - 1.0), 0.0))
        if derivative
        else None,
        breakpoints=(b,),
    )


@pytest.mark.parametrize("size", [1e-9, 1e-3])
@pytest.mark.parametrize("n", first_of([1.0, 2.37, 1.5, 2.0, 3.0], 2))
def test_flats_with_rounded_edges_under_every_law(n, size):
    work, range_ = 1e6 * size, 0.3 * size
    for law in (mdr.JKR(work), mdr.MaugisDugdale(work, range=range_), mdr.DMT(work, range=range_)):
        tip = mdr.Contact(rounded_flat(10 * size, 20 * size, n), STIFF, adhesion=law)
        result = mdr.solve(tip, mdr.indent(0.5 * size) >> mdr.indent(-10 * size, steps=3))
        assert balance(result).measure < 1e-8
        assert result.status.name == "PULLED_OFF"


@given(st.floats(0.05, 0.95), st.floats(1e-3, 0.02), st.floats(-9.0, 3.0), st.booleans())
def test_short_intervals_without_a_disk_are_seen_between_the_radii_that_are_read(
    middle, half, decades, without
):
    """And short ones in which it is one."""
    size, sign = 10.0**decades, 1.0 if without else -1.0
    computed = _negative(
        lambda a: sign * ((a / size - middle) ** 2 - half**2), 0.0, size, SimpleNamespace(decreasing=())
    )
    ends = [middle - half, middle + half]
    expected = [ends] if without else [[0.0, ends[0]], [ends[1], 1.0]]
    assert np.array(computed) / size == pytest.approx(np.array(expected), abs=1e-9)


@pytest.mark.parametrize("n", first_of([2.0, 1.0]))
def test_a_short_range_on_a_rounded_flat_is_that_of_jkr(n):
    tip = rounded_flat(1e-7, 1e-7, n)
    jkr = mdr.pull_off(mdr.Contact(tip, STIFF, adhesion=mdr.JKR(0.05))).normal_force
    off = [
        mdr.pull_off(mdr.Contact(tip, STIFF, adhesion=mdr.MaugisDugdale(0.05, range=h))).normal_force / jkr
        - 1.0
        for h in (1e-11, 1e-12)
    ]
    # of second order in the range: 1e-2 for a tenth of it
    assert abs(off[1]) < 1e-7
    assert off[0] / off[1] == pytest.approx(100.0, rel=0.05)


@pytest.mark.parametrize("short", [1e-6, 1e-9, 1e-12])
def test_states_next_to_the_pull_off_at_a_corner(short):
    """The flat comes off as a punch: the force is straight in the indentation there."""
    tip = mdr.Contact(rounded_flat(1e-7, 1e-7, 1.0), STIFF, adhesion=mdr.JKR(0.05))
    pull_off = mdr.pull_off(tip)
    near = mdr.solve(tip, mdr.indent("10 nm") >> mdr.indent((1.0 - short) * pull_off.indentation))
    stiffness = 2.0 * 1e9 / (1.0 - 0.3**2) * 1e-7
    assert last(near, "normal_stiffness") == pytest.approx(stiffness, rel=1e-8)
    expected = pull_off.normal_force + (last(near, "indentation") - pull_off.indentation) * stiffness
    # the root in the stretch behind the corner ends with rounding of the depth
    assert last(near, "normal_force") == pytest.approx(expected, rel=2e-14 + 1e-5 * short)


def test_adhesive_claims_carry_the_errors_of_the_map():
    function = mdr.Function(lambda r: np.sqrt(1e-12 + r * r) - 1e-6)
    path = mdr.indent("1 um", steps=3) >> mdr.load(0.0)
    result = mdr.solve(mdr.Contact(function, mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("5 mJ/m^2")), path)
    error = result.claims["normal_force"].error
    assert np.all((error[:3] > 0.0) & (error[:3] < 1e-9))
    assert error[3] == 0.0
    assert result.claims["indentation"].error[:3].tolist() == [0.0, 0.0, 0.0]
    assert "no other contact exists" in result.claims["normal_force"].reason


# --- figures ----------------------------------------------------------------------------------------------

UNKNOWN = "equilibria between the rows are not known"


def words_in(figure):
    return " ".join(text.get_text() for axes in figure.axes for text in axes.texts).replace("\n", " ")


@st.composite
def adhesive_contacts(draw):
    """Profiles and laws of any size, with a path of their size."""
    size = 10.0 ** draw(st.floats(-8, 0))
    modulus = 10.0 ** draw(st.floats(3, 12))
    profile = draw(
        st.sampled_from(
            [
                mdr.Sphere(size),
                mdr.Paraboloid(size),
                mdr.Cone(slope=0.2),
                mdr.PowerLaw(3.0, 0.1 * size, size),
                mdr.FlatPunch(size),
                mdr.DomedPunch(size, 20.0 * size),
                mdr.Ellipsoid(size, 0.5 * size),
            ]
        )
    )
    work = modulus * size * 10.0 ** draw(st.floats(-10, -2))
    strength = modulus * 10.0 ** draw(st.floats(-7, 0))
    law = draw(
        st.sampled_from([mdr.JKR(work), mdr.MaugisDugdale(work, strength), mdr.DMT(work, range=1e-4 * size)])
    )
    depth, load = size * 10.0 ** draw(st.floats(-8, -1)), modulus * size**2 * 10.0 ** draw(st.floats(-12, -2))
    path = draw(
        st.sampled_from(
            [
                mdr.indent(depth, steps=4),
                mdr.load(load, steps=4),
                mdr.indent(depth, steps=4) >> mdr.indent(-depth, steps=4),
                mdr.load(load, steps=4) >> mdr.indent(-depth, steps=4),
            ]
        )
    )
    return contact(profile, law, modulus), path


@pytest.mark.long
@settings(max_examples=examples(25), deadline=None)
@given(adhesive_contacts())
@example((contact(mdr.FlatPunch(1.0), mdr.JKR(0.1), 1e3), there_and_back(0.1, -0.1, 4)))
@example((contact(mdr.Sphere(1e-5), mdr.MaugisDugdale(1e-6, 1e2), 1e9), mdr.indent(1e-9, steps=4)))
@example((contact(mdr.Sphere(1e-2), mdr.MaugisDugdale(1e-2, range=1e-6), 1e10), mdr.load(1e-3, steps=4)))
@example(
    (
        contact(mdr.DomedPunch(0.0245, 2.29), mdr.MaugisDugdale(0.0362, 4810.0), 6716.0),
        mdr.load(3.07e-9, steps=4) >> mdr.indent(-6.78e-9, steps=4),
    )
)
def test_what_was_solved_is_drawn_with_all_its_equilibria(case):
    try:
        result = mdr.solve(*case)
    except PymdrError:
        return
    figure = result.plot()
    assert UNKNOWN not in words_in(figure)
    plt.close(figure)


def test_a_figure_without_equilibria_shows_the_rows_and_says_why(monkeypatch):
    result = mdr.solve(contact(), mdr.indent(1.0, steps=5))
    everything = result.plot()

    def fail(*_, **__):
        raise ConvergenceError("the curve did not settle at 3 m")

    monkeypatch.setattr(drawing, "branches_of", fail)
    figure = result.plot()
    assert f"{UNKNOWN}: the curve did not settle at 3 m" in words_in(figure)
    assert UNKNOWN not in words_in(everything)
    (rows,) = [
        line
        for axes in figure.axes
        for line in axes.lines
        if line.get_label() == "path" and line.get_marker() == "o"
    ]
    assert rows.get_xdata().size == 5
    plt.close("all")


# --- energies that are small differences ------------------------------------------------------------------


def rim(kind, slope, x_minus_b):
    """g beside the rim of a flat end of radius 1, without a difference, and g' times the root of the distance."""
    root = np.sqrt(x_minus_b * (2.0 + x_minus_b))
    x = 1.0 + x_minus_b
    if kind == "cone":
        return slope * x * np.arctan2(root, 1.0)
    return slope * x * root


@settings(max_examples=examples(20), deadline=None)
@given(
    st.sampled_from(["cone", "paraboloid"]),
    st.booleans(),
    st.floats(-3.0, 0.0),
    st.floats(-9.0, -1.0),
    st.lists(st.floats(-1.0, 3.0), min_size=1, max_size=4),
)
def test_a_small_energy_that_is_a_difference_of_large_ones_says_how_good_it_is(
    kind, written, decades, work_decades, depths
):
    slope, work = 10.0**decades, 10.0**work_decades
    profile = {
        "cone": mdr.TruncatedCone(1.0, slope=slope),
        "paraboloid": mdr.TruncatedParaboloid(1.0 / slope, 1.0),
    }[kind]
    if written:
        derivative = {
            "cone": lambda r: np.where(r > 1.0, slope, 0.0),
            "paraboloid": lambda r: np.where(r > 1.0, slope * r, 0.0),
        }
        profile = mdr.Function(derivative=derivative[kind], breakpoints=[1.0])

    def opening(e):
        return math.sqrt(2.0 * math.pi * (1.0 + e) * work)

    # the rim comes off where d = -opening(0)
    places = sorted(
        {0.0, *(work**0.5 * s * 10.0**k for k in depths for s in (0.1, -0.1) if s * 10.0**k > -0.5)}
    )[::-1]
    result = mdr.solve(contact(profile, mdr.JKR(work)), mdr.Path(indentation=places))
    node, weight = np.polynomial.legendre.leggauss(40)
    claim = result.claims["elastic_energy"]
    claimed = np.zeros(len(places)) if claim.error is None else claim.error
    for i, d in enumerate(places):
        if not column(result, "contact_radius")[i] > 1.0:
            continue
        edge = brentq(
            lambda e, d=d: rim(kind, slope, math.exp(e)) - opening(math.exp(e)) - d, -200.0, 20.0, xtol=1e-15
        )
        root = math.sqrt(math.exp(edge))
        y = 0.5 * root * (node + 1.0)
        beyond = float((d - rim(kind, slope, y * y)) ** 2 * y @ weight) * root
        exact = d * d + beyond
        off = abs(column(result, "elastic_energy")[i] / exact - 1.0)
        assert off <= 10.0 * claimed[i] + 1e-12
    if claim.level is mdr.Level.EXACT:
        assert np.max(claimed) <= 1e-9


def test_a_travel_of_600_rows_makes_few_calls_between_modules() -> None:
    gel = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    path = mdr.travel("20 um", steps=200) >> mdr.travel("-40 um", steps=400)
    mdr.solve(gel, path, machine_stiffness="0.1 N/m")
    calls = 0

    def count(frame: FrameType, event: str, _: object) -> None:
        nonlocal calls
        before = "" if frame.f_back is None else str(frame.f_back.f_globals.get("__name__"))
        here = str(frame.f_globals.get("__name__"))
        calls += (
            event == "call" and here.startswith("pymdr") and before.startswith("pymdr") and before != here
        )

    sys.setprofile(count)
    try:
        mdr.solve(gel, path, machine_stiffness="0.1 N/m")
    finally:
        sys.setprofile(None)
    assert 0 < calls < 1000
