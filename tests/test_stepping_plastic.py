"""Steps of balls that yield: the numbers of solve, energies, undo, many at once, refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples

QUANTITIES = ("normal_force", "contact_radius", "normal_stiffness", "elastic_energy", "dissipated_energy")


def ball(radius, adhesive=False, **options):
    work = mdr.JKR(1e6 * radius) if adhesive else None
    body = mdr.ElasticPlastic("1 GPa", 0.3, yield_strength="20 MPa", **options)
    return mdr.Contact(mdr.Sphere(radius), body, adhesion=work)


def depths(seed, size, radius):
    rng = np.random.default_rng(seed)
    d = 0.2 * radius * np.abs(np.mod(np.cumsum(rng.normal(0.0, 0.1, size)), 2.0) - 1.0)
    d[rng.random(size) < 0.05] = -0.01 * radius
    return d


KINDS = [
    {},
    {"wall_factor": True},
    {"adhesive": True},
    {"apparent_radius": True},
    {"apparent_radius": True, "wall_factor": True},
]


@given(
    seed=st.integers(0, 1000), size=st.floats(-9.0, 0.0).map(lambda x: 10.0**x), kind=st.sampled_from(KINDS)
)
@settings(max_examples=examples(30), deadline=None)
def test_steps_are_those_of_solve(seed, size, kind):
    contact, d = ball(size, **kind), depths(seed, 60, size)
    stepper, rows = mdr.Stepper(contact, 0.2 * size), []
    for depth in d.tolist():
        stepper.advance(depth)
        rows.append([getattr(stepper, name) for name in QUANTITIES])
    result = mdr.solve(contact, mdr.Path(indentation=d))
    for name, computed in zip(QUANTITIES, np.array(rows).T, strict=True):
        expected = result[name].values
        assert computed == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("kind", KINDS)
def test_many_are_one_each_and_the_last_step_is_taken_back(kind):
    moves = np.stack([depths(seed, 30, 1e-3) for seed in range(4)])
    many = mdr.Stepper(ball(1e-3, **kind), 0.2e-3, count=4)
    for row in moves.T:
        forces = many.advance(row)
    many.advance(1e-4)
    many.undo()
    assert many.normal_force == pytest.approx(forces.normal, rel=1e-14)
    for i, row in enumerate(moves):
        single = mdr.Stepper(ball(1e-3, **kind), 0.2e-3)
        for depth in row.tolist():
            single.advance(depth)
        assert single.normal_force == pytest.approx(forces.normal[i], rel=1e-13)
        assert single.dissipated_energy == pytest.approx(many.dissipated_energy[i], rel=1e-13)
        assert single.jumped == bool(many.jumped[i])


@pytest.mark.parametrize("away", [1e-3, 1.0])
def test_a_way_apart_does_not_make_a_growing_ball_grow(away):
    """The next touch counted the gap among the displaced volume, and the way over it as work."""
    near, far = (mdr.Stepper(ball(1e-3, apparent_radius=True), 0.2e-3) for _ in range(2))
    for contact, between in ((near, 0.0), (far, -away)):
        for d in (1e-4, between, 1e-4, 1.5e-4):
            contact.advance(d)
    for name in QUANTITIES:
        assert getattr(far, name) == getattr(near, name), name


def test_adhesive_balls_part_with_a_jump():
    stepper = mdr.Stepper(ball(1e-6, adhesive=True), 0.2e-6)
    stepper.advance(0.1e-6)
    jumps = []
    for depth in np.linspace(0.1e-6, -0.05e-6, 200):
        stepper.advance(depth)
        jumps.append(stepper.jumped)
    assert sum(jumps) == 1
    assert stepper.contact_radius == 0.0
    assert stepper.dissipated_energy > 0.0
    assert stepper.claims["normal_force"].level is mdr.Level.APPROXIMATE


def test_a_ball_ends_where_its_model_ends():
    with pytest.raises(mdr.PathError, match="the model of a body that yields ends at 900 mm"):
        mdr.Stepper(ball(1.0), 0.95)
    with pytest.raises(mdr.ProblemError, match="springs= is for"):
        mdr.Stepper(ball(1.0), 0.1, springs=32)
    assert math.isfinite(mdr.Stepper(ball(1.0), 0.9).advance(0.9).normal)


def test_jumps_of_a_result_are_those_of_the_stepper():
    """Also where the legs of a path meet; a ball without adhesion does not jump."""
    contact, d = ball(1e-3, adhesive=True), depths(3, 60, 1e-3)
    result = mdr.solve(contact, mdr.Path(indentation=d[:31]) >> mdr.Path(indentation=d[31:]))
    stepper, jumped = mdr.Stepper(contact, 0.5e-3), []
    for depth in d.tolist():
        stepper.advance(depth)
        jumped.append(stepper.jumped)
    assert sum(jumped) >= 3
    assert np.array_equal(result["jumped"].values > 0.0, jumped)
    assert result.claims["jumped"].where.all()
    plain = mdr.solve(ball(1e-3), mdr.Path(indentation=d))
    assert "jumped" not in plain.data
    dissipated, work = plain["dissipated_energy"].values, plain["external_work"].values
    assert "decreases by up to 9 % (0.7 % of the work)" in plain.claims["dissipated_energy"].reason
    assert np.all(np.diff(dissipated) >= -0.0071 * np.maximum(work[1:], 0.0) - 1e-12 * work.max())
