"""Layers: the lower bound of the force, rows that cannot be solved, and systems in tiles."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import pymdr as mdr
from pymdr.independent.rings import solve_indentation
from pymdr.independent.stacks import stack_of
from pymdr.line.layered import LayeredLine, equation, lower_bound, tables
from pymdr.line.layered import line as bound_module
from pymdr.line.layered.equation import Outline, solve_contact
from pymdr.line.layered.tiles import product, solve_positive
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import kernel_of
from pymdr.numerics.panels import as_place


def film(poisson=0.45, thickness=1.0, young=1.0, **others):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, poisson), thickness)], **others)


def coating(ratio, poisson=(0.3, 0.3), size=1.0):
    return film(poisson[0], size, ratio, base=mdr.Elastic(1.0, poisson[1]))


def ring_force(profile, body, depth, max_radius):
    stack = stack_of(body)
    return solve_indentation(
        profile.gap, depth, stack.modulus, max_radius=max_radius, n=40, edge=profile.edge, surface=stack
    ).force


def line_of(profile, body):
    return LayeredLine(equivalent_profile(profile), kernel_of(body))


# -- the lower bound ----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [0, *(pytest.param(i, marks=pytest.mark.long) for i in range(1, 6))])
def test_the_lower_bound_is_below_the_force_of_rings(seed):
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-9, 1)
    body = coating(10.0 ** rng.uniform(1.5, 3), rng.uniform(0.0, 0.5, 2), size)
    a = size * 10.0 ** rng.uniform(0.0, 0.6)
    depth = 0.05 * a * 10.0 ** rng.uniform(-0.5, 0.3)
    for profile in (mdr.FlatPunch(a), mdr.PowerLaw(exponent=rng.uniform(3, 8), height=0.05 * a, radius=a)):
        result = mdr.solve(mdr.Contact(profile, body), mdr.indent(depth))
        refused = result.status is mdr.Status.REFUSED
        claim = result.claims["force_lower_bound"]
        assert claim.level is mdr.Level.EXACT
        assert claim.error[0] < 1e-9
        assert ("trial pressures" in claim.reason) is refused
        fraction = float(result["force_lower_bound"][0]) / ring_force(profile, body, depth, 3 * a)
        assert (0.75 if refused else 1.0 - 1e-5) < fraction <= 1.0 + 1e-5


def test_the_lower_bound_of_a_disk_is_its_force():
    for body, profile in ((film(), mdr.Paraboloid(1.0)), (coating(5.0), mdr.Cone(slope=0.1))):
        line = line_of(profile, body)
        a = np.array([0.05, 0.4, 3.0])
        depth, force = line.depth(a), line.force(a)
        bound, error = lower_bound(line, depth, a)
        assert bound == pytest.approx(force, rel=1e-9)
        # without the radii the best of the others is a little below
        unknown, _ = lower_bound(line, depth, np.full(3, math.nan))
        assert np.all(unknown <= force * (1.0 + 1e-9))
        assert np.all(unknown > 0.5 * force)
        assert np.all(error < 1e-9)


def test_the_lower_bound_of_layers_alike_is_that_of_a_half_space():
    solid = mdr.Elastic(1.0, 0.3)
    alike = mdr.Layered([mdr.Layer(solid, 1.0)], base=mdr.Elastic(1.0, 0.3 + 1e-9))
    line = line_of(mdr.FlatPunch(2.0), alike)
    bound, _ = lower_bound(line, np.array([0.1]), np.array([2.0]))
    assert bound == pytest.approx(2.0 * line.modulus * 2.0 * 0.1, rel=1e-7)


def test_a_machine_does_not_lift_the_lower_bound_above_the_force():
    profile, body, k = mdr.FlatPunch(3.0), coating(100.0), 5.0
    contact = mdr.Contact(profile, body)
    bound = float(mdr.solve(contact, mdr.travel(0.1), machine_stiffness=k)["force_lower_bound"][0])
    per_depth = ring_force(profile, body, 1.0, 9.0)  # a flat punch is a spring
    assert 0.8 < bound * (1.0 / k + 1.0 / per_depth) / 0.1 < 1.0


# -- rows that cannot be solved -----------------------------------------------------------------------


def humped(rng):
    """A paraboloid with a dip around a radius, and how deep bodies come until they touch there."""
    at, deep = rng.uniform(1.5, 3.0), rng.uniform(0.02, 0.05)

    def dip(r):
        return np.exp(-(((r - at) / 0.1) ** 2))

    profile = mdr.Function(
        lambda r: r * r / 20.0 - deep * dip(r),
        derivative=lambda r: r / 10.0 + 200.0 * deep * (r - at) * dip(r),
    )
    r = np.linspace(at - 0.5, at + 0.5, 20001)
    fallen = np.flatnonzero(np.diff(profile.gap(r)) < 0.0)
    return profile, float(np.min(profile.gap(r[fallen[0] :])))


@pytest.mark.parametrize("seed", range(2))
def test_rows_of_a_profile_that_decreases_outside_are_solved_up_to_there(seed):
    profile, touching = humped(np.random.default_rng(seed))
    contact = mdr.Contact(profile, film())
    depths = touching * np.array([0.3, 0.9, 1.02, 1.4])
    result = mdr.solve(contact, mdr.Path(indentation=[*depths, *depths[::-1]]))
    known = result.claims["normal_force"].where
    assert known.tolist() == [True, True, False, False, False, False, True, True]
    assert result.status is mdr.Status.PARTLY_REFUSED
    assert "decreases at r" in result.claims["normal_force"].reason
    force = result["normal_force"].values
    alone = mdr.solve(contact, mdr.Path(indentation=depths[:2]))["normal_force"].values
    assert force[:2] == pytest.approx(alone, rel=1e-12)
    assert force[-2:] == pytest.approx(alone[::-1], rel=1e-12)
    assert np.isnan(force[2:-2]).all()
    assert np.isfinite(result["indentation"].values).all()
    bound = result["force_lower_bound"].values
    assert np.all(np.diff(bound[:4]) > 0.0)
    assert bound[:2] == pytest.approx(alone, rel=1e-12)
    true = ring_force(profile, film(), depths[3], 10.0)
    assert 0.7 * true < bound[3] < true * (1.0 + 1e-4)


@pytest.fixture
def narrow(monkeypatch):
    """Contacts of at most 20 thicknesses, which take less time than those of 300."""
    for module in (equation, tables, bound_module):
        monkeypatch.setattr(module, "WIDEST", 20.0)


@pytest.mark.parametrize("channel", ["indentation", "normal_force", "travel"])
def test_contacts_too_wide_are_left_out_alone(channel, narrow):
    body, ball = film(0.3, 1e-6), mdr.Paraboloid(1.0)
    line = line_of(ball, body)
    a = np.array([4.0, 19.9, math.nan, 19.9]) * 1e-6
    depth, force = (np.append(f(a[:2]), [3.0 * f(a[1:2])[0], f(a[1:2])[0]]) for f in (line.depth, line.force))
    stiffness = float(force[1] / depth[1])
    values = {"indentation": depth, "normal_force": force, "travel": depth + force / stiffness}[channel]
    k = stiffness if channel == "travel" else None
    result = mdr.solve(mdr.Contact(ball, body), mdr.Path(**{channel: values}), machine_stiffness=k)
    claim = result.claims["contact_radius"]
    assert claim.where.tolist() == [True, True, False, True]
    assert "20 thicknesses" in claim.reason
    assert result["contact_radius"].values[[0, 1, 3]] == pytest.approx(a[[0, 1, 3]], rel=1e-9)
    assert math.isnan(result["contact_radius"].values[2])
    bound = result["force_lower_bound"].values
    assert bound[2] >= bound[1]
    assert bound[[0, 1, 3]] == pytest.approx(force[[0, 1, 3]], rel=1e-9)


LAWS = {"JKR": mdr.JKR, "DMT": mdr.DMT}


@pytest.mark.parametrize("channel", ["indentation", "normal_force", "travel"])
@pytest.mark.parametrize("law", LAWS)
def test_adhesive_rows_end_where_layers_do(law, channel, narrow):
    body, ball = film(0.3, 1e-6, 1e6), mdr.Paraboloid(1.0)
    # a contact under no load is then about ten thicknesses wide
    contact = mdr.Contact(ball, body, adhesion=LAWS[law](2e-9))
    widest = line_of(ball, body)
    k = float(widest.force([1.99e-5])[0] / widest.depth([1.99e-5])[0])
    top = {"indentation": 1.0, "normal_force": k, "travel": 2.0}[channel] * float(widest.depth([1.99e-5])[0])
    machine = k if channel == "travel" else None
    up = top * np.array([0.0, 0.05, 0.2, 0.4, 3.0])
    result = mdr.solve(contact, mdr.Path(**{channel: [*up, *up[::-1]]}), machine_stiffness=machine)
    alone = mdr.solve(contact, mdr.Path(**{channel: up[:4]}), machine_stiffness=machine)
    names = ("contact_radius", "elastic_energy", "dissipated_energy", "external_work")
    for name in names:
        size = np.max(np.abs(alone[name].values))
        claim = result.claims[name]
        assert claim.where.tolist() == [True] * 4 + [False] * 6
        assert "20 thicknesses" in claim.reason
        assert "omit it" in claim.reason
        assert result[name].values[:4] == pytest.approx(alone[name].values, rel=1e-9, abs=1e-15 * size)
        assert np.isnan(result[name].values[4:]).all()
    assert np.isfinite(result[channel].values[:4]).all()
    if channel != "travel":
        assert np.isfinite(result[channel].values).all()
    assert result.status is mdr.Status.ADHESION_PARTLY_REFUSED
    with pytest.raises(mdr.errors.ConvergenceError, match="20 thicknesses"):
        mdr.solve(contact, mdr.Path(**{channel: [3.0 * top, top]}), machine_stiffness=machine)


def test_an_adhesive_profile_that_decreases_outside_is_followed_up_to_there():
    profile, touching = humped(np.random.default_rng(0))
    contact = mdr.Contact(profile, film(), adhesion=mdr.JKR(1e-7))
    depths = touching * np.array([0.3, 0.9, 1.4, 0.3])
    result = mdr.solve(contact, mdr.Path(indentation=depths) >> mdr.indent(0.1 * touching))
    assert result.claims["normal_force"].where.tolist() == [True, True, False, False, False]
    assert "decreases at r" in result.claims["normal_force"].reason
    force = mdr.solve(contact, mdr.Path(indentation=depths[:2]))["normal_force"].values
    assert result["normal_force"].values[:2] == pytest.approx(force, rel=1e-12)


def test_where_no_row_can_be_solved_the_reason_is_raised(narrow):
    contact = mdr.Contact(mdr.Paraboloid(1.0), film(0.3, 1e-6))
    with pytest.raises(mdr.errors.ConvergenceError, match="20 thicknesses"):
        mdr.solve(contact, mdr.Path(indentation=[1e-3, 2e-3]))


def test_a_leg_after_rows_that_could_not_be_solved(narrow):
    contact = mdr.Contact(mdr.Paraboloid(1.0), film(0.3, 1e-6))
    path = mdr.indent(1e-11) >> mdr.indent(1e-4) >> mdr.indent(2e-11)
    result = mdr.solve(contact, path)
    assert result.claims["normal_force"].where.tolist() == [True, False, True]
    with pytest.raises(mdr.PathError, match="could not be solved"):
        mdr.solve(contact, mdr.load(1e-17) >> mdr.load(10.0) >> mdr.indent(1e-11))


# -- systems in tiles ---------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 47, 48, 49, 96, 150])
def test_tiles_solve_what_a_library_solves(n):
    rng = np.random.default_rng(n)
    half = rng.normal(size=(n, n))
    matrix, right = half @ half.T / n + 1e-2 * np.eye(n), rng.normal(size=(n, 2))
    computed, expected = solve_positive(matrix, right), np.linalg.solve(matrix, right)
    assert np.max(np.abs(computed - expected)) < 1e-11 * np.max(np.abs(expected)) * np.linalg.cond(matrix)
    assert product(matrix, right[:, 0]) == pytest.approx(matrix @ right[:, 0], rel=1e-12, abs=1e-12)
    with pytest.raises(np.linalg.LinAlgError):
        solve_positive(matrix - 2.0 * np.max(matrix) * np.eye(n), right)


def test_no_other_thread_works_on_a_contact():
    g, kernel = equivalent_profile(mdr.Paraboloid(1.0)), kernel_of(film(0.5))
    outline = Outline(g, 1.0, as_place(np.array([60.0])))
    solve_contact(kernel, outline)
    whole, own = time.process_time(), time.thread_time()
    solve_contact(kernel, outline)
    whole, own = time.process_time() - whole, time.thread_time() - own
    assert whole - own < 0.1 * own
