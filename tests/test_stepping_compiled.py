"""Steps in the compiled code of other programs: those of the stepper, endings, room."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import pymdr as mdr
from drawing import first_of

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
BEAD = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("20 mJ/m^2"))
DEEPEST = 2e-5
CASES = [
    (BEAD, None),
    (BALL, None),
    (replace(BALL, friction=None), None),
    (replace(BALL, friction=mdr.Coulomb(math.inf)), None),
    (replace(BEAD, adhesion=mdr.JKR("20 mJ/m^2", work_receding="60 mJ/m^2")), None),
    (mdr.Contact(mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa", wall_factor=True)), None),
    (BALL, 32),
    (replace(BALL, friction=mdr.Coulomb(math.inf)), 32),
]


def walks(contact, size, count):
    rng = np.random.default_rng(5)
    depth = np.abs(np.cumsum(rng.normal(0.0, 0.05 * DEEPEST, (size, count)), axis=0)) % DEEPEST
    depth[rng.random(depth.shape) < 0.02] = -3.0 * DEEPEST
    shift = np.cumsum(rng.normal(0.0, 0.02 * DEEPEST, (size, count)), axis=0)
    return (3.0 * depth - 2.0 * DEEPEST if contact.adhesion else depth), shift


@pytest.mark.parametrize("case", first_of(CASES, 2))
def test_compiled_steps_are_those_of_the_stepper(case):
    contact, springs = case
    many, others = (mdr.Stepper(contact, DEEPEST, count=3, springs=springs) for _ in range(2))
    step, body, states = many.compiled()
    for depth, shift in zip(*walks(contact, 300, 3), strict=True):
        given = (shift, 0.5 * shift) if springs else shift
        forces = others.advance(depth, given)
        for i in range(3):
            move = (shift[i], 0.5 * shift[i]) if springs else shift[i]
            ending, normal, tangential = step(body, states, i, depth[i], move)
            assert ending == 0
            assert normal == forces.normal[i]
            expected = (forces.x[i], forces.y[i]) if springs else forces.tangential[i]
            assert tangential == expected
    assert (many.dissipated_energy == others.dissipated_energy).all()
    many.undo()
    others.undo()
    assert (many.normal_force == others.normal_force).all()
    for wrong in (math.nan, math.inf, -math.inf, 1.1 * DEEPEST):
        assert step(body, states, 0, wrong, (0.0, 0.0) if springs else 0.0)[0] == 1
    assert (many.normal_force == others.normal_force).all()


SOLID = mdr.Viscoelastic(mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["0.1 s", "2 s"]), 0.5)
DAMPED = mdr.Viscoelastic(mdr.KelvinVoigt("1 MPa", "1e4 Pa*s"), 0.4)
LIQUID = mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), 0.3)


@pytest.mark.parametrize("body", first_of([SOLID, DAMPED, LIQUID]))
def test_compiled_steps_with_memory_are_those_of_the_stepper(body):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), body)
    many, others = (mdr.Stepper(contact, DEEPEST, count=3, springs=40) for _ in range(2))
    step, line, states = many.compiled()
    lasting = 10.0 ** np.random.default_rng(2).uniform(-3.0, 1.0, (100, 3))
    if body is not DAMPED:
        lasting[::7] = 0.0
    depths = walks(contact, 100, 3)[0]
    depths[50:60] = depths[50]
    for depth, duration in zip(depths, lasting, strict=True):
        forces = others.advance(depth, duration=duration)
        for i in range(3):
            assert step(line, states, i, depth[i], 0.0, duration[i]) == (0, forces.normal[i], 0.0)
    for name in ("dissipated_energy", "elastic_energy", "contact_radius", "indentation"):
        assert (getattr(many, name) == getattr(others, name)).all()
    others.undo()
    many.undo()
    wrong = [(DEEPEST, math.nan), (DEEPEST, -1.0), (DEEPEST, math.inf), (math.nan, 1.0), (1.1 * DEEPEST, 1.0)]
    for depth, duration in [*wrong, (DEEPEST, 0.0)] if body is DAMPED else wrong:
        assert step(line, states, 0, depth, 0.0, duration)[0] == 1
    assert step(line, states, 0, DEEPEST, 0.0)[0] == 1
    assert (
        many.advance(np.full(3, DEEPEST), duration=1.0).normal
        == others.advance(np.full(3, DEEPEST), duration=1.0).normal
    ).all()


def test_a_step_with_memory_in_two_threads():
    many, others = (
        mdr.Stepper(mdr.Contact(mdr.Paraboloid("10 mm"), SOLID), DEEPEST, count=2, springs=40)
        for _ in range(2)
    )
    step, body, states = many.compiled()
    depths = walks(many.contact, 400, 2)[0]

    def moved(i):
        for depth in depths[:, i].tolist():
            step(body, states, i, depth, 0.0, 0.05)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(moved, range(2)))
    for depth in depths:
        others.advance(depth, duration=0.05)
    assert (many.normal_force == others.normal_force).all()
    assert (many.dissipated_energy == others.dissipated_energy).all()


def test_a_loop_of_another_program():
    numba = pytest.importorskip("numba")
    stepper = mdr.Stepper(BEAD, DEEPEST)
    step, body, states = stepper.compiled()

    @numba.njit
    def work(step, body, states, steps):
        done = before = 0.0
        for j in range(steps):
            d = 1e-5 * math.sin(6.283185307179586 * j / (steps - 1))
            _, force, _ = step(body, states, 0, d, 0.0)
            done += 0.5 * (force + before) * (1e-5 * 6.283185307179586 / (steps - 1))
            before = force
        return done

    assert math.isfinite(work(step, body, states, 1000))
    assert stepper.dissipated_energy > 0.0


def test_a_stack_without_room_leaves_the_step_to_the_stepper():
    stepper = mdr.Stepper(BALL, DEEPEST)
    step, body, states = stepper.compiled(capacity=16)
    place, left = 1e-6, 0
    for _ in range(40):  # ever smaller turns: no turning point is forgotten
        ending, _, _ = step(body, states, 0, 1e-5, place)
        if ending == 2:
            stepper.advance(1e-5, place)
            step, body, states = stepper.compiled()
            left += 1
        place *= -0.9
    assert left == 1
    path = mdr.Path(indentation=np.full(40, 1e-5), shift=1e-6 * (-0.9) ** np.arange(40.0))
    solved = float(mdr.solve(BALL, path)["tangential_force"][-1])
    assert stepper.tangential_force == pytest.approx(solved, rel=1e-9, abs=1e-13)


@pytest.mark.parametrize(
    ("contact", "capacity", "words"),
    [
        (BALL, 7, "from 8 to 65536"),
        (
            mdr.Contact(
                mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa"), adhesion=mdr.JKR(1.0)
            ),
            64,
            "have no compiled step",
        ),
        (
            mdr.Contact(mdr.Paraboloid("10 mm"), SOLID, friction=mdr.Coulomb(0.3)),
            64,
            "with memory and friction",
        ),
    ],
)
def test_refusals(contact, capacity, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.Stepper(contact, "10 um").compiled(capacity=capacity)
