"""Steps of a contact that another program moves: the numbers of solve, energies, undo, states, and refusals."""

import pickle

import numpy as np
import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr

STEEL = mdr.Elastic("210 GPa", 0.3)


BALL = mdr.Sphere("10 mm")


def ball(friction=0.3, profile=BALL, body=STEEL):
    law = None if friction is None else mdr.Coulomb(friction)
    return mdr.Contact(profile, body, mdr.Elastic(body.young, 0.3), friction=law)


def random_moves(seed, size, deepest):
    rng = np.random.default_rng(seed)
    depth = deepest * np.abs(rng.normal(0.0, 0.4, size)).clip(0.0, 1.0)
    depth[rng.random(size) < 0.1] = -0.1 * deepest
    return depth, np.cumsum(rng.normal(0.0, 0.05 * deepest, size))


PROFILES = [
    lambda r: mdr.Sphere(r),
    lambda r: mdr.Cone(slope=0.05),
    lambda r: mdr.FlatPunch(0.05 * r),
    lambda r: mdr.RoundedFlat(0.05 * r, r),
    lambda r: mdr.Paraboloid(r) + mdr.Paraboloid(3.0 * r) + mdr.Cone(slope=0.01),
]


@given(
    seed=st.integers(0, 1000),
    size=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    make=st.sampled_from(PROFILES),
    friction=st.sampled_from([None, 0.01, 0.3, 2.0, np.inf]),
)
@settings(max_examples=25, deadline=None)
def test_steps_are_those_of_solve(seed, size, make, friction):
    contact, deepest = ball(friction, make(size)), 1e-3 * size
    depth, shift = random_moves(seed, 60, deepest)
    channels, names = {"indentation": depth}, ["normal_force", "contact_radius", "elastic_energy"]
    if friction is not None:
        channels["shift"] = shift
        names += ["tangential_force", "stick_radius", "stored_tangential_energy", "dissipated_energy"]
    stepper, rows = mdr.Stepper(contact, deepest), []
    for move in zip(depth.tolist(), shift.tolist(), strict=True):
        forces = stepper.advance(*move)
        assert forces == (stepper.normal_force, stepper.tangential_force)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(contact, mdr.Path(**channels))
    for name, column in zip(names, np.transpose(rows), strict=True):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max()), name
    assert friction is not None or not forces.tangential


def test_many_contacts_are_each_like_one():
    depth, shift = (
        np.stack(each) for each in zip(*(random_moves(seed, 80, 1e-5) for seed in range(7)), strict=True)
    )
    many = mdr.Stepper(ball(), "10 um", count=7)
    forces = [many.advance(depth[:, row], shift[:, row]) for row in range(80)]
    for i in range(7):
        one = mdr.Stepper(ball(), "10 um")
        for row in range(80):
            assert one.advance(depth[i, row], shift[i, row]) == (
                forces[row].normal[i],
                forces[row].tangential[i],
            )
        assert many.dissipated_energy[i] == one.dissipated_energy


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("friction", [0.3, np.inf])
def test_long_histories_need_more_room(count, friction):
    """Ever smaller swings add two vertices each."""
    stepper = mdr.Stepper(ball(friction), "10 um", count=count)
    swing = 1e-6 * 0.97 ** np.arange(300) * np.where(np.arange(300) % 2, 1.0, -1.0)
    forces = [stepper.advance(5e-6, u) for u in [0.0, *swing.tolist()]]
    result = mdr.solve(
        ball(friction), mdr.indent("5 um") >> mdr.Path(indentation=np.full(300, 5e-6), shift=swing)
    )
    last = np.ravel(forces[-1].tangential)[-1]
    largest = float(np.abs(result["tangential_force"]).max())
    assert last == pytest.approx(float(result["tangential_force"][-1]), abs=1e-13 * largest)


@pytest.mark.parametrize("friction", [0.3, np.inf])
def test_steps_are_taken_back_to_the_whole_stack(friction):
    """Only what a step changed is kept; the way to the surface reads every turning point."""
    stepper, rng = mdr.Stepper(ball(friction), "10 um"), np.random.default_rng(4)
    swing = 0.9 ** np.arange(40) * np.where(np.arange(40) % 2, 1.0, -1.0)
    for d, u in zip(5e-6 + 4e-6 * swing, 1e-6 * swing * rng.uniform(0.5, 1.0, 40), strict=True):
        stepper.advance(d, u)
        before = stepper.copy()
        stepper.advance(1e-5 * rng.uniform(-0.1, 1.0), 1e-6 * rng.normal())
        stepper.undo()
        again = stepper.copy()
        for part in (0.9, 0.5, 0.1):
            assert again.advance(part * d, u) == before.advance(part * d, u)


@pytest.mark.parametrize("springs", [None, 32])
@pytest.mark.parametrize("far", [1e-2, 1e2, 1e6])
def test_far_shifts_err_by_their_rounding(far, springs):
    """By up to four times the stiffness times half a unit in the last place of the shift, here 1e3 to 1e11 indentations."""
    stiffness = 2.0 * mdr.effective_moduli(STEEL, STEEL).tangential * np.sqrt(0.01 * 1e-5)
    rows, (depth, shift) = [], random_moves(6, 100, 1e-5)
    for start in (0.0, far):
        contact = mdr.Stepper(ball(), "10 um", springs=springs)
        moves = zip([-1e-5, *depth], [start, *(start + shift)], strict=True)
        rows.append([contact.advance(d, (u, 0.0) if springs else u)[1] for d, u in moves])
    assert np.abs(np.subtract(*rows)).max() < 4.0 * stiffness * 2.0**-53 * far


def test_a_step_is_taken_back():
    stepper = mdr.Stepper(ball(), "10 um")
    depth, shift = random_moves(3, 50, 1e-5)
    for move in zip(depth, shift, strict=True):
        stepper.advance(*move)
        before = stepper.copy()
        stepper.advance(8e-6, 0.0)
        stepper.advance(0.0, 0.0) if move[0] < 0 else None
        if move[0] >= 0:
            stepper.undo()
            assert stepper.advance(2e-6, 1e-6) == before.advance(2e-6, 1e-6)
    stepper.undo()
    with pytest.raises(mdr.PathError, match="no step to undo"):
        stepper.undo()


def test_states_continue_where_they_were(tmp_path):
    stepper = mdr.Stepper(ball(), "10 um")
    for move in zip(*random_moves(5, 30, 1e-5), strict=True):
        stepper.advance(*move)
    other = mdr.Stepper(ball(), "10 um")
    other.restore(pickle.loads(pickle.dumps(stepper.state)))
    assert other.advance(3e-6, 2e-6) == stepper.advance(3e-6, 2e-6)
    assert other.claims["tangential_force"].error is not None


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_work_is_stored_or_dissipated(seed):
    """The work of fine straight steps, by the trapezoidal rule, which errs as the square of a step."""
    rng = np.random.default_rng(seed)
    stepper, here, work = mdr.Stepper(ball(), "10 um"), np.zeros(2), np.zeros(2)
    corners = np.stack([rng.uniform(2e-6, 1e-5, 6), rng.uniform(-3e-6, 3e-6, 6)], axis=1)
    for corner in corners:
        for t in np.linspace(0.0, 1.0, 401)[1:]:
            was = np.array([stepper.normal_force, stepper.tangential_force])
            step = here + t * (corner - here) - np.array([stepper.indentation, stepper.shift])
            now = np.array(stepper.advance(*(here + t * (corner - here))))
            work += 0.5 * (was + now) * step
        here = corner
    normal, tangential = work
    assert normal == pytest.approx(stepper.elastic_energy, rel=1e-4)
    kept = stepper.stored_tangential_energy + stepper.dissipated_energy
    assert tangential == pytest.approx(kept, abs=2e-3 * abs(kept) + 1e-4 * abs(normal))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.Stepper(ball(), "0 m"), "above 0 m"),
        (lambda: mdr.Stepper(ball(), "1 N"), "max_indentation"),
        (lambda: mdr.Stepper(ball(), "1 um", count=0), "at least 1"),
        (lambda: mdr.Stepper(3, "1 um"), "not a Contact"),
        (lambda: mdr.Stepper(mdr.Contact(mdr.EllipticParaboloid(1.0, 2.0), STEEL), "1 um"), "not a disk"),
        (lambda: mdr.Stepper(ball(), "1 um").restore(3), "is not a state"),
        (
            lambda: mdr.Stepper(ball(), "1 um").restore(mdr.Stepper(ball(0.2), "1 um").state),
            "another contact",
        ),
        (
            lambda: mdr.Stepper(ball(), "1 um").restore(mdr.Stepper(ball(), "1 um", count=2).state),
            "another count",
        ),
    ],
)
def test_refusals(make, words):
    with pytest.raises(mdr.PymdrError, match=words):
        make()


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("profile", [BALL, mdr.Paraboloid("10 mm")], ids=["table", "power"])
def test_steps_that_cannot_be_taken_leave_the_state(count, profile):
    stepper = mdr.Stepper(ball(profile=profile), "1 um", count=count)
    stepper.advance(1e-6, 1e-7)
    before = np.array(stepper.tangential_force)
    for move, words in (((2e-6, 0.0), "deeper than"), ((np.nan, 0.0), "finite"), ((0.0, np.inf), "finite")):
        with pytest.raises(mdr.PathError, match=words):
            stepper.advance(*move)
    assert np.array_equal(stepper.tangential_force, before)


RUBBER = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.2 s"), 0.5)
GRIPPED = mdr.Contact(BALL, RUBBER, friction=mdr.Coulomb(0.3))
"""A ball on a body with memory, with friction."""


@pytest.mark.parametrize(
    ("contact", "options", "step", "words"),
    [
        (ball(), {}, (1e-6, (1e-6, 0.0)), r"shape \(2,\).* one line; elastic bodies .* springs=32"),
        (ball(), {"count": 3}, (1e-6, (1e-6, 0.0)), r"shape \(2,\).*of shape \(3,\)"),
        (GRIPPED, {"springs": 32}, (1e-6, (1e-6, 0.0), 0.1), r"shape \(2,\).* one line"),
        (ball(), {}, ("5 um",), "indentation = '5 um'; a number in m .* SI floats"),
        (ball(), {"count": 3}, ("5 um",), "indentation = '5 um'; a number in m, or an array"),
        (ball(), {}, (1e-6, "1 um"), "shift = '1 um'; a number in m"),
        (ball(), {"count": 3}, (1e-6, "1e-6"), "shift = '1e-6'; a number in m"),
        (ball(), {"springs": 32}, (1e-6, ("1 um", 0.0)), "shift x = '1 um'; a number in m"),
        (GRIPPED, {"springs": 32}, (1e-6, 0.0, "1 s"), "duration = '1 s'; a number in s"),
        (GRIPPED, {"springs": 32}, (1e-6, 0.0, -1.0), "duration = -1.0; .* at least 0"),
        (ball(), {}, (None,), "indentation = None; a number in m"),
        (ball(), {}, (10**400,), "a number in m"),
        (ball(), {"count": 3}, (None,), "indentation = None; a number in m"),
        (ball(), {"count": 3}, (1e-6, [None] * 3), "shift = .*a number in m"),
        (ball(), {}, (np.full(2, 1e-6),), r"shape \(2,\); a number in m is needed"),
        (ball(), {}, (1e-6, np.full(2, 1e-6)), r"shift = .* shape \(2,\)"),
        (ball(), {"count": 3}, (np.full(4, 1e-6),), r"indentation = .* shape \(4,\).*of shape \(3,\)"),
        (ball(), {"springs": 32}, "x", "angle = 'x'; a number in rad"),
    ],
)
def test_values_that_are_no_numbers_leave_the_state(contact, options, step, words):
    stepper = mdr.Stepper(contact, "10 um", **options)
    with pytest.raises(mdr.PathError, match=words):
        stepper.rotate(step) if isinstance(step, str) else stepper.advance(*step)
    assert not np.any(stepper.indentation)
    assert not np.any(stepper.shift)


@pytest.mark.parametrize("options", [{}, {"count": 3}, {"springs": 32}, {"springs": 32, "count": 3}])
def test_units_are_not_lost(options):
    """NumPy takes 10 nm for 10."""
    short = pint.application_registry.Quantity(10.0, "nm")
    steps = mdr.Stepper(ball(), "2 um", **options)
    for shift in (short, 1e-8):
        moved = (shift, 0.0) if "springs" in options else shift
        depth = 1e-6 if shift is short else short
        with pytest.raises(mdr.PathError, match=r"a number in m.*without units"):
            steps.advance(depth, moved)
