"""The frictional half-space on a grid, against quadrature, closed forms and the friction stack."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.independent.sliding import HalfSpaceGrid, following, influence, solve_sliding
from pymdr.line.friction import cattaneo_mindlin, follow_displacements, power_law_curves
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.profiles import Cone, FlatPunch, Function, Paraboloid, Sampled

BALL, DEPTH, MU = Paraboloid(1.0), 0.01, 0.4


def followed(poisson, shift, depth=1.0, n=24, parts=1, friction=MU):
    """Rows in units of the sliding shift and of DEPTH, each cut in parts; and F_N, F_x of the stack."""
    body = Elastic(1.0, poisson)
    moduli = effective_moduli(body)
    shift, depth = np.broadcast_arrays(np.asarray(shift, dtype=float), depth)
    at = np.arange((shift.size - 1) * parts + 1) / parts
    u, d = (np.interp(at, np.arange(shift.size), rows) for rows in (shift, depth))
    u, d = u * friction * moduli.normal / moduli.tangential * DEPTH, d * DEPTH
    grid = solve_sliding(BALL, body, Rigid(), friction, d, u, HalfSpaceGrid(n))
    curves = power_law_curves(2.0, 1.0, moduli.normal)
    stack = follow_displacements(curves, d, u, friction, moduli.tangential).tangential_force
    return grid, 4.0 / 3.0 * moduli.normal * d**1.5, stack


def excess(grid, load, exact, friction=MU):
    """F_x / (mu F_N) of the grid above the exact one."""
    return grid.tangential_force / (friction * grid.normal_force) - exact / (friction * load)


KERNELS = (
    lambda v, u: u * u / math.hypot(u, v) ** 3,
    lambda v, u: v * v / math.hypot(u, v) ** 3,
    lambda v, u: u * v / math.hypot(u, v) ** 3,
)


@pytest.mark.parametrize("at", [(1.0, 0.0), (1.3, 0.2), (-0.4, 0.9), (6.0, -4.0)])
def test_influence_outside_the_cell_against_quadrature(at):
    x, y = at
    exact = [dblquad(k, x - 0.5, x + 0.5, y - 0.5, y + 0.5, epsabs=1e-12)[0] for k in KERNELS]
    np.testing.assert_allclose(influence(x, y, 1.0), exact, rtol=1e-9, atol=1e-12)


def test_influence_of_a_cell_on_itself_against_quadrature():
    # s cancels in polar coordinates about a point of the cell
    def edge(t):
        return min(0.5 / abs(math.cos(t) or 1e-300), 0.5 / abs(math.sin(t) or 1e-300))

    nodes, weights = np.polynomial.legendre.leggauss(40)
    exact = np.zeros(3)
    for k in range(8):
        for t, w in zip(math.pi / 8 * (nodes + 2 * k + 1), math.pi / 8 * weights, strict=True):
            c, s = math.cos(t), math.sin(t)
            exact += w * edge(t) * np.array([c * c, s * s, c * s])
    np.testing.assert_allclose(influence(0.0, 0.0, 1.0), exact, atol=1e-13)


def test_influence_far_away_is_that_of_a_point():
    # measured 5.0e-5 and 1.25e-5
    errors = []
    for far in (1.0, 2.0):
        x, y = 30.0 * far, 40.0 * far
        point = np.array([x * x, y * y, x * y]) / math.hypot(x, y) ** 3
        errors.append(np.max(np.abs(influence(x, y, 1.0) / point - 1)))
    assert errors[0] < 6e-5
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.01)


def test_hertz_converges():
    # measured 8.2e-4, 1.1e-4; the staircase of the rim makes single grids better by accident
    errors = [
        abs(g.normal_force[0] / load[0] - 1) for g, load, _ in (followed(0.0, [0.0], n=n) for n in (24, 48))
    ]
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 4


def test_constant_load_without_poisson_effect_is_cattaneo_mindlin():
    # measured 3.2e-4, 5.1e-5
    shift = np.linspace(0.0, 1.0, 6)
    force, stick = cattaneo_mindlin(shift, 2.0)
    errors = []
    for n in (24, 48):
        grid, load, _ = followed(0.0, shift, n=n)
        errors.append(np.max(np.abs(excess(grid, load, force * MU * load))))
        assert np.max(np.abs(grid.transverse_force)) == grid.largest_slip_angle == 0.0
    assert errors[0] < 4e-4
    assert errors[1] < errors[0] / 4
    # measured 9.1e-3 a, a fifth of a cell
    np.testing.assert_allclose(grid.stick_radius / 0.1, stick, atol=1e-2)


def test_loop_without_poisson_effect_is_that_of_mindlin_and_deresiewicz():
    top = 0.6
    down, up = np.array([0.2, -0.2, -0.6]), np.array([-0.2, 0.2, 0.6])
    grid, load, _ = followed(0.0, [0.3, top, *down, *up], n=32)
    force = lambda ratio: cattaneo_mindlin(ratio, 2.0)[0]  # noqa: E731
    exact = [*force([0.3, top]), *(force(top) - 2 * force((top - down) / 2))]
    exact += [*(-force(top) + 2 * force((top + up) / 2))]
    # measured 3.6e-4
    assert np.max(np.abs(excess(grid, load, np.array(exact) * MU * load))) < 5e-4


@pytest.mark.parametrize(
    ("poisson", "least", "most", "angles"),
    [(0.3, -1e-5, 5e-4, (5.0, 6.0)), (0.5, -1e-5, 1.8e-3, (9.5, 11.0))],
)
def test_poisson_effect_at_constant_load(poisson, least, most, angles):
    # measured 0 to 3.8e-4 and 5.5 degrees at 0.3, 0 to 1.6e-3 and 10.6 degrees at 0.5; the grid's share is 1.3e-4
    grid, load, stack = followed(poisson, [0.0, 0.2, 0.4, 0.6, 0.8], n=36)
    above = excess(grid, load, stack)
    assert least < above.min()
    assert above.max() < most
    assert np.max(np.abs(grid.transverse_force)) < 1e-9 * load[0]
    assert angles[0] < followed(poisson, [0.0, 0.4, 0.6], n=36)[0].largest_slip_angle < angles[1]


def test_poisson_effect_is_larger_when_load_and_shift_turn_together():
    # measured 3.8e-4, 1.16e-3, 4.77e-3; on 54 cells 1.3e-4, 1.29e-3, 4.99e-3
    shift, depth = [0.0, 0.2, 0.4, 0.6, 0.8, 0.4, -0.4, 0.3], [1.0, 1.0, 1.0, 1.0, 0.8, 0.8, 0.8, 0.8]
    worst = [np.max(np.abs(excess(*followed(nu, shift, depth, n=36)))) for nu in (0.0, 0.3, 0.5)]
    assert worst[0] < 5e-4
    assert 1e-3 < worst[1] < 1.4e-3
    assert 4.3e-3 < worst[2] < 5.3e-3


def test_random_history_approaches_the_stack():
    # measured 1.76e-2, 8.9e-3, 3.9e-3: first order in the rows
    rng = np.random.default_rng(7)
    shift, depth = [0.0, *rng.uniform(-1.0, 1.0, 5)], [1.0, *rng.uniform(0.4, 1.0, 5)]
    errors = [np.max(np.abs(excess(*followed(0.0, shift, depth, n=16, parts=parts)))) for parts in (2, 4, 8)]
    assert errors[0] < 2e-2
    assert errors[1] < 0.55 * errors[0]
    assert errors[2] < 0.55 * errors[1]


def test_oblique_loading_below_the_limit_sticks():
    # measured 2.1e-2, 1.1e-2 in 16, 32 rows: first order; their extrapolation is off by 1.7e-3
    body, ratio = Elastic(1.0, 0.0), 0.5 * MU
    forces = []
    for rows in (16, 32):
        d = DEPTH * np.arange(1, rows + 1) / rows
        grid = solve_sliding(BALL, body, Rigid(), MU, d, ratio * d, HalfSpaceGrid(24))
        forces.append(grid.tangential_force[-1] / grid.normal_force[-1] / ratio)
    assert forces[1] == pytest.approx(1.0, abs=1.3e-2)
    assert 2 * forces[1] - forces[0] == pytest.approx(1.0, abs=2.5e-3)
    assert grid.stick_radius[-1] == grid.contact_radius[-1]


def displacements(grid, body):
    """Displacements of the cells (3, n, n) as a plain sum over the cells."""
    side = grid.x[1] - grid.x[0]
    X, Y = (g.ravel() for g in np.meshgrid(grid.x, grid.y, indexing="ij"))
    xx, yy, xy = influence(X[:, None] - X, Y[:, None] - Y, side)
    nu, scale = body.poisson, 1 / (2 * math.pi * body.shear)
    p, a, b = grid.pressure.ravel(), grid.q_x.ravel(), grid.q_y.ravel()
    plain = (1 - nu) * (xx + yy)
    along = (plain + nu * xx) @ a + nu * xy @ b
    across = nu * xy @ a + (plain + nu * yy) @ b
    return scale * np.array([plain @ p, along, across]).reshape(3, *grid.pressure.shape)


def test_contact_and_coulomb_conditions_hold_in_every_cell():
    body, d = Elastic(1.0, 0.3), [DEPTH, DEPTH, 0.9 * DEPTH]
    u, width = [0.0, 0.005, 0.003], 0.11
    before, grid = (
        solve_sliding(BALL, body, Rigid(), MU, d[:k], u[:k], HalfSpaceGrid(20, width)) for k in (2, 3)
    )
    normal, *moved = displacements(grid, body)
    q, limit = np.array([grid.q_x, grid.q_y]), MU * grid.pressure
    gap = BALL.gap(np.hypot(grid.x[:, None], grid.y)) - DEPTH * 0.9 + normal
    contact = grid.pressure > 0
    assert np.max(np.abs(gap[contact])) < 1e-9 * DEPTH  # measured 5.5e-10, the tolerance is 1e-9
    assert gap.min() > -1e-9 * DEPTH
    slip = np.array([u[2] - u[1], 0.0])[:, None, None] - (moved - displacements(before, body)[1:])
    size = np.hypot(*q)
    assert np.all(size <= limit * (1 + 1e-12))
    slipping = contact & (size >= (1 - 1e-6) * limit)
    stuck = contact & ~slipping
    assert np.count_nonzero(stuck) > 30
    assert np.count_nonzero(slipping) > 30
    # over u[1], measured: slip of stuck cells 5.4e-10, across the traction 2.5e-11, along it 0.02 to 0.07
    assert np.max(np.hypot(*slip)[stuck]) < 1e-9 * u[1]
    turned = (slip[0] * q[1] - slip[1] * q[0])[slipping] / size[slipping]
    assert np.max(np.abs(turned)) < 1e-10 * u[1]
    assert np.min((slip * q).sum(axis=0)[slipping] / size[slipping]) > 0.015 * u[1]


def test_two_like_bodies_are_half_as_stiff_as_one():
    body = Elastic(1.0, 0.3)
    one, two = (solve_sliding(BALL, body, other, MU, [DEPTH] * 2, [0.0, 0.003]) for other in (Rigid(), body))
    np.testing.assert_allclose(2 * two.tangential_force, one.tangential_force, rtol=1e-8)


@pytest.mark.parametrize("scale", [1e-8, 1e6])
def test_lengths_have_no_scale(scale):
    body = Elastic(1.0, 0.3)
    small, large = (
        solve_sliding(Paraboloid(k), body, Rigid(), MU, [DEPTH * k] * 2, [0.0, 0.003 * k], HalfSpaceGrid(16))
        for k in (scale, 1.0)
    )
    np.testing.assert_allclose(small.tangential_force / scale**2, large.tangential_force, rtol=1e-5)


def test_punch_cone_and_loss_of_contact():
    body = Elastic(1.0, 0.0)
    punch = solve_sliding(FlatPunch(0.1), body, Rigid(), MU, [DEPTH], [0.0])
    assert punch.normal_force[0] == pytest.approx(2 * 0.1 * DEPTH, rel=1e-2)  # measured 7.4e-3
    cone = solve_sliding(Cone(slope=0.1), body, Rigid(), MU, [DEPTH], [0.0])
    assert cone.normal_force[0] == pytest.approx(2 / math.pi * DEPTH**2 / 0.1, rel=5e-4)  # measured 3.0e-4
    solved = solve_sliding(
        BALL, body, Rigid(), MU, [DEPTH, -DEPTH, DEPTH], [0.001, 0.5, 0.501], HalfSpaceGrid(16)
    )
    assert solved.normal_force[1] == solved.tangential_force[1] == solved.contact_radius[1] == 0.0
    assert solved.tangential_force[2] == pytest.approx(solved.tangential_force[0], rel=1e-7)


def test_unreached_tolerance_is_an_error(monkeypatch):
    monkeypatch.setattr(following, "_ITERATIONS", 3)
    with pytest.raises(ConvergenceError, match="did not converge: relative residual"):
        solve_sliding(BALL, Elastic(1.0, 0.3), Rigid(), MU, [DEPTH], [0.0])


RADII = np.linspace(0.0, 0.12, 60)


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        ({"friction": 0.0}, ProblemError, "above 0"),
        ({"friction": math.inf}, ProblemError, "finite"),
        ({"grid": HalfSpaceGrid(half_width=0.05)}, ProblemError, "larger half_width"),
        ({"body": Rigid()}, ProblemError, "both bodies are rigid"),
        ({"shift": [0.0, 1.0]}, PathError, "equal numbers"),
        ({"indentation": [math.nan]}, PathError, "finite"),
        ({"indentation": [-DEPTH]}, PathError, "no row touches"),
        ({"profile": Sampled(RADII, RADII**2 / 2), "indentation": [0.0225]}, ProblemError, "the profile to"),
        ({"profile": Function(f=lambda r: 1e-3 * r / (1 + r))}, ProblemError, "never rises"),
    ],
)
def test_bad_input(change, kind, words):
    given = {"profile": BALL, "body": Elastic(1.0, 0.3), "counterbody": Rigid(), "friction": MU}
    given |= {"indentation": [DEPTH], "shift": [0.0]} | change
    with pytest.raises(kind, match=words):
        solve_sliding(**given)


@pytest.mark.parametrize("n", [7, 20.0, True, "32"])
def test_bad_grid(n):
    with pytest.raises(ProblemError, match="at least 8"):
        HalfSpaceGrid(n)


@pytest.mark.parametrize("width", [0.0, -1.0, math.inf, math.nan])
def test_bad_width_of_the_grid(width):
    with pytest.raises(ProblemError, match=f"half_width = {width}"):
        HalfSpaceGrid(half_width=width)
