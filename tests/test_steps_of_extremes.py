"""Random steps of extreme sizes: headers in C and steppers agree, stay finite and within Coulomb's limit, and refuse what overflows."""

import math

import numpy as np
import pytest
from tests.drawing import first_of
from tests.test_law_history import ALONG, IN_PLANE, STEEL, InC, needs_c
from tests.test_law_sheared import CALLS as SHEARED
from tests.test_law_sheared import in_c

import pymdr as mdr

DEEPEST, MU = 1e-6, 0.3
SOFT = mdr.Viscoelastic(mdr.Prony("2 MPa", ["3 MPa", "1 MPa"], ["0.1 s", "2 s"]), 0.4)


def extremes(rng, size, deepest):
    """Depths of all sizes down to the least float, with stays, neighbours and losses of the contact."""
    depth = rng.uniform(-0.3, 1.0, size) * deepest
    kind = rng.integers(0, 8, size)
    depth[kind == 1] = deepest * 10.0 ** rng.uniform(-300.0, 0.0, np.count_nonzero(kind == 1))
    depth[kind == 2] = rng.choice([0.0, -0.0, 5e-324, -1e59, deepest], np.count_nonzero(kind == 2))
    for i in np.flatnonzero(kind == 3):
        depth[i] = depth[i - 1]
    for i in np.flatnonzero(kind == 4):
        depth[i] = min(np.nextafter(depth[i - 1], rng.choice([-1.0, 1.0])), deepest)
    return depth


def wandering(rng, size, step):
    """Shifts with steps of all sizes, and stays."""
    steps = rng.normal(0.0, step, size) * 10.0 ** rng.uniform(-12.0, 3.0, size)
    return np.cumsum(np.where(rng.random(size) < 0.3, 0.0, steps))


@needs_c
@pytest.mark.parametrize("seed", first_of(range(12)))
@pytest.mark.parametrize("profile", [mdr.FlatPunch("0.1 mm"), mdr.RoundedFlat("0.1 mm", "10 mm")])
def test_friction_of_extreme_steps(profile, seed, tmp_path):
    rng, contact = np.random.default_rng(seed), mdr.Contact(profile, STEEL, friction=mdr.Coulomb(MU))
    plane = mdr.export_law(contact, DEEPEST, tangential=True, springs=12)
    code = InC(plane, tmp_path, IN_PLANE)
    for _ in range(6):
        depth, x, y = extremes(rng, 150, DEEPEST), *(wandering(rng, 150, 1e-7) for _ in range(2))
        computed = np.zeros((150, 4))
        code.bytes[:] = bytes(len(code.bytes))
        assert code.run(code.bytes, depth, np.column_stack([x, y]).ravel(), computed, 150) == 150
        stepper = mdr.Stepper(contact, DEEPEST, springs=12)
        moves = zip(depth.tolist(), x.tolist(), y.tolist(), strict=True)
        expected = np.array([stepper.advance(d, (u, v)) for d, u, v in moves])
        assert np.isfinite(expected).all()
        assert np.isfinite(computed).all()
        size = np.abs(expected).max()
        assert np.abs(computed[:, :3] - expected).max() < (1e-6 + 1e-13 * np.abs([x, y]).max() / 1e-7) * size
        if isinstance(profile, mdr.FlatPunch):  # whose springs share the load evenly
            for rows in (expected, computed[:, :3]):
                assert np.all(np.hypot(rows[:, 1], rows[:, 2]) <= 1.00001 * MU * rows[:, 0] + 1e-140)


@needs_c
def test_a_load_that_nearly_vanishes_leaves_no_force(tmp_path):
    """A flat is unloaded to 1e-29 of its load at a constant shift: its force falls to mu F_N and keeps its direction."""
    contact = mdr.Contact(mdr.FlatPunch("0.1 mm"), STEEL, friction=mdr.Coulomb(MU))
    law = mdr.export_law(contact, DEEPEST, tangential=True, springs=8)
    depth = np.array([0.3, 0.4, 0.7, 0.9])[:, None] * DEEPEST * np.array([1.0, 1e-29, 0.5])
    for row in depth:
        computed, stepper = np.zeros((3, 4)), mdr.Stepper(contact, DEEPEST, springs=8)
        code = InC(law, tmp_path, IN_PLANE)
        assert code.run(code.bytes, row, np.tile([0.0, 1e-9], 3), computed, 3) == 3
        steps = np.array([stepper.advance(d, (0.0, 1e-9)) for d in row.tolist()])
        for rows in (steps, computed[:, :3]):
            assert np.abs(rows[1:, 1:]).max() <= 1.0001 * MU * rows[1, 0]
            assert rows[1, 2] == pytest.approx(MU * rows[1, 0], rel=1e-6)


@needs_c
def test_a_long_slip_leaves_springs_where_their_force_is(tmp_path):
    """After a slip over 1e18 depths, pressing on at rest changes no tangential force of a solid that does not relax further."""
    contact = mdr.Contact(mdr.FlatPunch("0.1 mm"), SOFT, friction=mdr.Coulomb(MU))
    law = mdr.export_law(contact, DEEPEST, tangential=True, springs=8)
    depth, shift = np.array([0.4, 0.4, 1.0, 1.0]) * DEEPEST, np.array([0.0, 1e12, 1e12, 1e12])
    lasting = np.array([1e4, 1e4, 1.0, 1e4])
    stepper = mdr.Stepper(contact, DEEPEST, springs=8)
    steps = [stepper.advance(d, u, t) for d, u, t in zip(depth, shift, lasting, strict=True)]
    computed = in_c(InC(law, tmp_path, SHEARED), depth, shift, lasting)
    for rows in (np.array(steps), computed[:, :2]):
        assert rows[1:, 1] == pytest.approx(MU * rows[0, 0], rel=1e-3)


@needs_c
@pytest.mark.parametrize("value", [1e61, -1e300, math.inf, math.nan])
def test_values_whose_products_overflow_are_refused(value, tmp_path):
    contact = mdr.Contact(mdr.Sphere("10 mm"), STEEL, friction=mdr.Coulomb(MU))
    stepper = mdr.Stepper(contact, DEEPEST)
    step, body, states = mdr.Stepper(contact, DEEPEST).compiled()
    code = InC(mdr.export_law(contact, DEEPEST, tangential=True), tmp_path, ALONG)
    for depth, shift in ((1e-7, value), (-abs(value), 0.0)):
        with pytest.raises(mdr.PathError, match="within 1e\\+60 m is needed"):
            stepper.advance(depth, shift)
        assert step(body, states, 0, depth, shift)[0] == 1
        assert code.advance([depth], [shift]).size == 0
    soft = mdr.Stepper(mdr.Contact(mdr.Sphere("10 mm"), SOFT), DEEPEST)
    with pytest.raises(mdr.PathError, match="at most 1e\\+60"):
        soft.advance(1e-7, duration=abs(value))
