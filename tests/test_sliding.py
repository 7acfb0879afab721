"""Vector friction on the half-space, and the friction stack held against it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

import pymdr as mdr
from pymdr.errors import PathError, ProblemError
from pymdr.independent.sliding import HalfSpaceGrid, influence, solve_sliding
from pymdr.line.friction import follow_displacements, power_law_curves

BALL = mdr.Paraboloid(1.0)
DEPTH, MU = 0.01, 0.4


def both(poisson, shift, depth=DEPTH, n=24):
    body = mdr.Elastic(1.0, poisson)
    moduli = mdr.effective_moduli(body)
    sliding = MU * moduli.normal / moduli.tangential * DEPTH
    u = sliding * np.asarray(shift, dtype=float)
    d = np.broadcast_to(np.asarray(depth, dtype=float), u.shape).copy()
    grid = solve_sliding(BALL, body, mdr.Rigid(), MU, d, u, HalfSpaceGrid(n))
    stack = follow_displacements(power_law_curves(2.0, 1.0, moduli.normal), d, u, MU, moduli.tangential)
    load = 4.0 / 3.0 * moduli.normal * np.maximum(d, 0.0) ** 1.5
    return grid, stack, load


@pytest.mark.parametrize("at", [(0.0, 0.0), (1.3, 0.2), (-0.4, 0.9), (6.0, -4.0)])
def test_influence_against_quadrature(at):
    x, y = at
    found = influence(np.array([x]), np.array([y]), 1.0)
    # polar coordinates or a far point: the kernels are smooth away from the cell
    if max(abs(x), abs(y)) > 0.5:
        kernels = (
            lambda v, u: u * u / math.hypot(u, v) ** 3,
            lambda v, u: v * v / math.hypot(u, v) ** 3,
            lambda v, u: u * v / math.hypot(u, v) ** 3,
        )
        exact = [dblquad(k, x - 0.5, x + 0.5, y - 0.5, y + 0.5, epsabs=1e-12)[0] for k in kernels]
        np.testing.assert_allclose(np.ravel(found), exact, rtol=1e-9, atol=1e-12)
    else:
        # by symmetry both parts are half of the integral of 1/s, 4 asinh(1) for a unit square
        np.testing.assert_allclose(np.ravel(found), [2 * math.asinh(1), 2 * math.asinh(1), 0.0], atol=1e-14)


def test_influence_far_away_is_that_of_a_point():
    x, y = np.array([30.0]), np.array([40.0])
    found = np.ravel(influence(x, y, 1.0))
    np.testing.assert_allclose(found, np.array([900.0, 1600.0, 1200.0]) / 50.0**3, rtol=2e-3)


def test_hertz_on_the_grid():
    # measured 1.4e-3, 2.8e-4 at 16 and 32 cells
    errors = [abs(both(0.0, [0.0], n=n)[0].normal_force[0] / both(0.0, [0.0])[2][0] - 1) for n in (16, 32)]
    assert errors[0] < 2e-3
    assert errors[1] < 4e-4


def test_no_poisson_effect_is_one_direction():
    grid, stack, load = both(0.0, [0.0, 0.2, 0.4, 0.8, 0.4, 0.0, -0.4, 0.3])
    assert np.max(np.abs(grid.transverse_force)) < 1e-12 * load[0]
    assert np.max(grid.slip_angle) == 0.0
    # measured 1.0e-3 of mu F_N on 24 x 24 cells
    difference = grid.tangential_force / grid.normal_force - stack.tangential_force / load
    assert np.max(np.abs(difference)) < 1.5e-3 * MU


def test_force_error_halves_with_the_cells():
    coarse, fine = (
        np.max(np.abs(g.tangential_force / g.normal_force - s.tangential_force / f))
        for g, s, f in (both(0.0, [0.0, 0.3, 0.6, 0.1, -0.5], n=n) for n in (16, 32))
    )
    assert fine < 0.6 * coarse


@pytest.mark.parametrize(
    ("poisson", "lowest", "highest", "angle"), [(0.3, -1e-3, 2e-3, 6), (0.5, -1e-3, 4e-3, 11)]
)
def test_what_poisson_does(poisson, lowest, highest, angle):
    grid, stack, load = both(poisson, [0.0, 0.2, 0.4, 0.6, 0.8], n=32)
    above = grid.tangential_force / grid.normal_force / MU - stack.tangential_force / load / MU
    # measured -1e-4 to 4.4e-4 at 0.3 and 5e-5 to 1.4e-3 at 0.5, the error of the grid included
    assert lowest < above.min()
    assert above.max() < highest
    assert 1.0 < grid.slip_angle.max() < angle
    assert np.max(np.abs(grid.transverse_force)) < 1e-9 * load[0]


def test_rows_in_which_the_contact_grows_are_first_order():
    depth, shift = DEPTH * np.array([0.6, 1.0, 1.0, 0.7, 0.7, 1.0]), np.array([0.0, 0.1, 0.5, 0.4, -0.2, 0.1])
    errors = []
    for parts in (1, 4):
        at = np.arange(5 * parts + 1) / parts
        rows = (np.interp(at, np.arange(6), values) for values in (shift, depth))
        grid, stack, load = both(0.0, *rows)
        difference = grid.tangential_force / grid.normal_force - stack.tangential_force / load
        errors.append(np.max(np.abs(difference)) / MU)
    # cells that enter within a row count as in contact for all of it; measured 1.3e-2 and 3.5e-3
    assert errors[0] < 2e-2
    assert errors[1] < 0.4 * errors[0]


def test_limit_and_direction_hold_in_every_cell():
    grid, _, _ = both(0.3, [0.0, 0.3, 0.6, 0.2])
    size = np.hypot(*grid.traction)
    assert np.all(size <= MU * grid.pressure * (1 + 1e-9))
    slipping = size > MU * grid.pressure * (1 - 1e-6)
    assert 0 < np.count_nonzero(slipping & (grid.pressure > 0)) < np.count_nonzero(grid.pressure > 0)


def test_lost_contact_carries_nothing():
    grid, _, _ = both(0.0, [0.1, 0.2], np.array([DEPTH, -DEPTH]))
    assert grid.normal_force[1] == grid.tangential_force[1] == grid.contact_radius[1] == 0.0


def test_verify_sliding_thins_a_long_history():
    steel = mdr.Elastic("210 GPa", 0.3)
    joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    path = mdr.load("50 N") >> mdr.cycle(shift="0.6 um", steps=400)
    found = mdr.verify_sliding(joint, path, cells=20, steps=8)
    assert found.table.sizes["step"] <= 8
    assert found.largest_difference < 5e-3  # measured 2.2e-3
    assert "boundary elements" in found.summary()
    figure = found.plot()
    assert [axes.get_xlabel() for axes in figure.axes] == [
        "tangential displacement $u_x$ (nm)",
        "radius $r$ (um)",
    ]


def test_bad_input():
    body = mdr.Elastic(1.0, 0.3)
    for make, kind, words in (
        (lambda: HalfSpaceGrid(4), ProblemError, "8 to 80"),
        (lambda: HalfSpaceGrid(20.0), ProblemError, "whole number"),
        (lambda: solve_sliding(BALL, body, mdr.Rigid(), 0.0, [1e-3], [0.0]), ProblemError, "above 0"),
        (lambda: solve_sliding(BALL, body, mdr.Rigid(), math.inf, [1e-3], [0.0]), ProblemError, "finite"),
        (lambda: solve_sliding(BALL, body, mdr.Rigid(), 0.3, [1e-3, 1e-3], [0.0]), PathError, "as many"),
        (lambda: solve_sliding(BALL, body, mdr.Rigid(), 0.3, [-1e-3], [0.0]), PathError, "above 0 m"),
        (lambda: solve_sliding(BALL, body, mdr.Rigid(), 0.3, [math.nan], [0.0]), PathError, "finite"),
        (
            lambda: mdr.verify(mdr.Contact(BALL, body, friction=mdr.Coulomb(0.3)), mdr.indent(1e-3)),
            ProblemError,
            "verify_sliding",
        ),
        (
            lambda: mdr.verify_sliding(mdr.Contact(BALL, body), mdr.indent(1e-3)),
            ProblemError,
            "coefficient above 0",
        ),
    ):
        with pytest.raises(kind, match=words):
            make()
