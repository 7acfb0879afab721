"""Steps in the plane: the rows of springs, the stack along a line, small increments, work, tangent stiffness, turned frames."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from tests.drawing import examples

import pymdr as mdr
from pymdr.line.foundation import states_at_depth
from pymdr.line.plane import PlaneLaw, Springs, follow_plane, virgin_plane
from pymdr.solving.mapped import map_to_springs

STEEL, GLASS = mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.2)


def ball(friction=0.3, size=1e-2):
    return mdr.Contact(mdr.Paraboloid(size), STEEL, GLASS, friction=mdr.Coulomb(friction))


def random_moves(seed, size, deepest):
    rng = np.random.default_rng(seed)
    depth = deepest * np.abs(rng.normal(0.5, 0.2, size)).clip(0.0, 1.0)
    depth[rng.random(size) < 0.1] = -0.1 * deepest
    return depth, np.cumsum(rng.normal(0.0, 0.05 * deepest, (size, 2)), axis=0)


def moved(stepper, depth, shift):
    return np.array([stepper.advance(*move) for move in zip(depth.tolist(), shift.tolist(), strict=True)])


@given(
    seed=st.integers(0, 1000),
    size=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    friction=st.sampled_from([0.01, 0.3, 2.0, math.inf]),
)
@settings(max_examples=examples(12), deadline=None)
def test_steps_are_the_rows_of_springs(seed, size, friction):
    contact, deepest = ball(friction, size), 1e-3 * size
    depth, shift = random_moves(seed, 40, deepest)
    stepper = mdr.Stepper(contact, deepest, springs=32)
    forces = moved(stepper, depth, shift)
    mapped = map_to_springs(contact)
    law = PlaneLaw(friction, mapped.moduli.normal, mapped.moduli.tangential)
    radius = states_at_depth(mapped.line, np.append(depth, deepest)).contact_radius
    springs = Springs.along(mapped.line, radius[-1], 32)
    rows, _, _ = follow_plane(law, springs, depth, radius[:-1], shift, virgin_plane(springs))
    assert forces[:, 1:] == pytest.approx(rows.force, abs=1e-13 * np.abs(rows.force).max())
    energy = max(rows.stored.max(), rows.slip_work[-1])
    assert stepper.stored_tangential_energy == pytest.approx(rows.stored[-1], abs=1e-13 * energy)
    assert stepper.dissipated_energy == pytest.approx(rows.slip_work[-1], abs=1e-13 * energy)
    assert stepper.stick_radius == pytest.approx(rows.stick_radius[-1], rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_along_a_line_many_springs_are_the_stack(angle):
    """The error falls about as the square of the number of springs."""
    depth, along = random_moves(4, 60, 1e-5)
    depth, along = np.maximum(depth, 1e-6), along[:, 0]
    stack = mdr.Stepper(ball(), "10 um")
    exact = moved(stack, depth, along)
    direction = np.array([math.cos(angle), math.sin(angle)])
    errors = []
    for springs in (32, 512):
        forces = moved(mdr.Stepper(ball(), "10 um", springs=springs), depth, np.outer(along, direction))
        assert forces[:, 0] == pytest.approx(exact[:, 0], rel=1e-14)
        along_it, across = forces[:, 1:] @ direction, forces[:, 1:] @ [-direction[1], direction[0]]
        assert np.abs(across).max() < 1e-11 * np.abs(along_it).max()
        errors.append(np.abs(along_it - exact[:, 1]).max() / np.abs(exact[:, 1]).max())
    assert errors[1] < 1e-5
    assert errors[1] < errors[0] / 64.0


def test_small_increments_with_radial_return():
    """Springs in small increments that are cut at their limit, an independent way, of first order in the increment."""
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), friction=mdr.Coulomb(0.4))
    moduli = mdr.effective_moduli(mdr.Elastic(1.0, 0.0), mdr.Rigid())
    n, corners = 24, np.array([[0.8, 0.0, 0.0], [0.8, 0.1, 0.02], [1.0, 0.15, 0.3], [0.6, -0.1, 0.25]])
    stepper = mdr.Stepper(contact, 1.0, springs=n)
    x = (np.arange(n) + 0.5) / n
    scale, errors = 2.0 * moduli.tangential / n, []
    for parts in (500, 2000):
        q, here, forces = np.zeros((2, n)), np.zeros(3), []
        for corner in corners:
            step = (corner - here) / parts
            for depth in here[0] + step[0] * np.arange(1, parts + 1):
                q += step[1:, None]
                limit = 0.4 * moduli.normal / moduli.tangential * np.maximum(depth - x * x, 0.0)
                length = np.maximum(np.hypot(*q), 1e-300)
                q *= np.minimum(1.0, limit / length)
            here = corner
            forces.append(scale * q.sum(axis=1))
        fresh = stepper.copy()
        ours = np.array([fresh.advance(c[0], (c[1], c[2]))[1:] for c in corners])
        errors.append(np.abs(ours - forces).max() / np.abs(forces).max())
    assert errors[1] < 1e-3
    assert errors[1] < errors[0] / 2.5


def test_work_is_stored_or_dissipated():
    """The work of fine straight steps by the trapezoidal rule; a load that falls takes work from the normal motion."""
    stepper, work, here = mdr.Stepper(ball(), "10 um", springs=32), 0.0, np.zeros(2)
    stepper.advance(8e-6)
    for corner in (np.array([1e-6, 0.0]), np.array([1.5e-6, 2e-6]), np.array([-1e-6, 1e-6])):
        for t in np.linspace(0.0, 1.0, 401)[1:]:
            was, place = stepper.tangential_force.copy(), stepper.shift.copy()
            stepper.advance(8e-6, here + t * (corner - here))
            work += 0.5 * (was + stepper.tangential_force) @ (stepper.shift - place)
        here = corner
    kept = stepper.stored_tangential_energy + stepper.dissipated_energy
    assert work == pytest.approx(kept, rel=2e-5)
    assert stepper.dissipated_energy > 0.1 * kept


@pytest.mark.parametrize("friction", [0.3, math.inf])
def test_the_tangent_stiffness_is_that_of_a_small_step(friction):
    stepper = mdr.Stepper(ball(friction), "10 um", springs=64)
    for depth, shift in ((4e-6, (1e-6, 0.0)), (5e-6, (1.5e-6, 0.5e-6))):
        stepper.advance(depth, shift)
    step = 1e-12 * np.array([0.8, 0.6])
    before, stiffness = stepper.tangential_force.copy(), stepper.tangential_stiffness
    stepper.advance(5e-6, stepper.shift + step)
    assert stepper.tangential_force - before == pytest.approx(stiffness @ step, rel=1e-4)
    assert stiffness == pytest.approx(stiffness.T)


def test_turned_contacts_move_as_in_a_turned_frame():
    depth, shift = random_moves(7, 40, 1e-5)
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    plain, turned = (mdr.Stepper(ball(), "10 um", springs=16) for _ in range(2))
    expected = moved(plain, depth, shift)
    moved(turned, depth[:20], shift[:20])
    turned.rotate(0.5 * math.pi)
    assert turned.tangential_force == pytest.approx(turn @ expected[19, 1:], abs=1e-12)
    forces = moved(turned, depth[20:], shift[20:] @ turn.T)
    largest = np.abs(expected).max()
    assert forces[:, 1:] == pytest.approx(expected[20:, 1:] @ turn.T, abs=1e-12 * largest)
    turned.rotate(1.0)
    turned.undo()
    assert turned.tangential_force == pytest.approx(forces[-1, 1:], rel=1e-14)


def test_many_contacts_are_each_like_one():
    moves = [random_moves(seed, 30, 1e-5) for seed in range(4)]
    depth, shift = (np.stack(each) for each in zip(*moves, strict=True))
    many = mdr.Stepper(ball(), "10 um", count=4, springs=16)
    forces = np.array([many.advance(depth[:, row], shift[:, row].T) for row in range(30)])
    kept, last = many.state, many.copy()
    for i in range(4):
        one = mdr.Stepper(ball(), "10 um", springs=16)
        assert moved(one, depth[i], shift[i]).tolist() == forces[:, :, i].tolist()
        assert many.tangential_stiffness[i].tolist() == one.tangential_stiffness.tolist()
    many.undo()
    assert np.array(many.advance(depth[:, -1], shift[:, -1].T)).tolist() == forces[-1].tolist()
    many.advance(1e-6, (0.0, 0.0))
    many.restore(kept)
    assert many.tangential_force.tolist() == last.tangential_force.tolist()


def test_claims_state_the_error_of_the_springs():
    claim = mdr.Stepper(ball(), "10 um", springs=16).claims["tangential_force"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert "with 16 springs its error is up to" in claim.reason


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.Stepper(ball(), "1 um", springs=4), "from 8 to 4096"),
        (lambda: mdr.Stepper(ball(), "1 um", springs=True), "from 8 to 4096"),
        (
            lambda: mdr.Stepper(mdr.Contact(mdr.Sphere(1.0), STEEL), "1 um", springs=16),
            "friction in the plane",
        ),
        (lambda: mdr.Stepper(ball(), "1 um", springs=16).advance(1e-7, 1e-7), "a pair"),
        (lambda: mdr.Stepper(ball(), "1 um", springs=16).advance(1e-7, (1e-7, math.nan)), "finite"),
        (lambda: mdr.Stepper(ball(), "1 um", springs=16, count=2).advance(1e-7, (1e-7, math.inf)), "finite"),
        (lambda: mdr.Stepper(ball(), "1 um", springs=16).rotate(math.nan), "finite"),
        (lambda: mdr.Stepper(ball(), "1 um").rotate(1.0), "cannot turn"),
        (
            lambda: mdr.Stepper(ball(), "1 um", springs=16).restore(mdr.Stepper(ball(), "1 um").state),
            "another springs",
        ),
    ],
)
def test_refusals(make, words):
    with pytest.raises(mdr.PymdrError, match=words):
        make()


def test_values_do_not_change_with_later_steps():
    stepper = mdr.Stepper(
        mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3)),
        "10 um",
        springs=8,
        count=2,
    )
    stepper.advance(5e-6, (1e-6, 0.0))
    force, depth = stepper.tangential_force, stepper.indentation
    kept = force.copy()
    stepper.advance(2e-6, (0.0, 1e-6))
    assert (force == kept).all()
    assert (depth == 5e-6).all()


@pytest.mark.parametrize("seed", range(3))
def test_without_friction_nothing_is_carried_in_any_plane(seed):
    depth, shift = random_moves(seed, 20, 1e-5)
    plane, line = (mdr.Stepper(ball(0.0), 1e-5, **given) for given in ({"springs": 16}, {}))
    carried = "tangential_force", "stick_radius", "stored_tangential_energy", "dissipated_energy"
    for d, u in zip(depth.tolist(), shift.tolist(), strict=True):
        assert plane.advance(d, tuple(u)) == (line.advance(d, u[0]).normal, 0.0, 0.0)
        for name in (*carried, "tangential_stiffness"):
            assert not np.any(getattr(plane, name)), name
            assert getattr(line, name) == 0.0, name
        assert plane.shift.tolist() == u


@pytest.mark.parametrize(
    ("load", "angle"),
    [
        (0.999, 0.03),
        (0.3, 1.2),
        (1e-4, 1.5),
        (-1e-3, 0.03),
        (-1e-3, 1.5),
        (-1.0, 3.1),
        (-30.0, 0.5),
        (-30.0, 3.1),
    ],
)
def test_long_slip_of_a_turning_spring_under_a_changing_load(load, angle):
    """All springs of a flat punch are one: m dtheta = -sin(theta) ds, and the slip work by quadrature."""
    punch = mdr.Contact(mdr.FlatPunch("1 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    moduli, depth = mdr.effective_moduli(STEEL, STEEL), 1e-6
    extent = 0.3 * moduli.normal / moduli.tangential * depth
    stepper = mdr.Stepper(punch, 1e3 * depth, springs=8)
    stepper.advance(depth)
    stepper.advance(depth, (1e3 * extent * math.cos(angle), 1e3 * extent * math.sin(angle)))
    before, (x, y) = stepper.dissipated_energy, stepper.shift
    length = 0.9 / abs(load) if load < 0.0 else 50.0
    stepper.advance(depth * (1.0 + load * length), (x + length * extent, y))

    # v = log(tan(theta / 2)) falls by ds / m; slip cos(theta) ds - dm of the limit m, cos(theta) = -tanh(v)
    start = math.log(math.tan(0.5 * angle))
    fall = math.log1p(load * length) / load
    places = [start - fall, *(p for p in (-10.0, 0.0) if start - fall < p < start), start]
    work = sum(
        quad(
            lambda v: (-math.tanh(v) - load) * math.exp(2.0 * load * (start - v)),
            *ends,
            epsabs=0.0,
            epsrel=1e-12,
        )[0]
        for ends in pairwise(places)
    )
    expected = 2e-3 * 0.3 * moduli.normal * depth * extent * work
    assert stepper.dissipated_energy - before == pytest.approx(expected, rel=1e-10)
