"""Steps of bodies with memory: the rows of solve, Lee and Radok, relaxation, energies, and refusals."""

import math

import numpy as np
import pytest
from tests.drawing import first_of

import pymdr as mdr

RUBBER = mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["0.1 s", "2 s"])
KINDS = [
    RUBBER,
    mdr.Maxwell("1 MPa", "0.5 s"),
    mdr.KelvinVoigt("1 MPa", "0.1 MPa s"),
]


def ball(shear=RUBBER, profile=None):
    return mdr.Contact(mdr.Sphere("10 mm") if profile is None else profile, mdr.Viscoelastic(shear, 0.5))


def random_moves(seed, size, deepest):
    rng = np.random.default_rng(seed)
    depth = np.abs(rng.normal(0.0, 0.3 * deepest, size)).clip(0.0, deepest)
    depth[size // 3], depth[::9] = deepest, -0.2 * deepest
    return depth, rng.exponential(0.1, size)


@pytest.mark.parametrize("shear", first_of(KINDS))
def test_steps_are_those_of_solve(shear):
    contact = ball(shear)
    depth, lasting = random_moves(1, 60, 1e-4)
    stepper, rows = mdr.Stepper(contact, "100 um"), []
    names = ("normal_force", "contact_radius", "elastic_energy", "dissipated_energy")
    for move in zip(depth.tolist(), lasting.tolist(), strict=True):
        force = stepper.advance(move[0], duration=move[1]).normal
        rows.append((force, *(getattr(stepper, name) for name in names[1:])))
    result = mdr.solve(contact, mdr.Path(time=np.cumsum(lasting), indentation=depth))
    for name, column in zip(names, np.transpose(rows), strict=True):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max())


@pytest.mark.parametrize("friction", first_of([0.3, math.inf]))
@pytest.mark.parametrize("shear", first_of(KINDS))
def test_steps_with_friction_are_those_of_solve(shear, friction):
    contact = mdr.Contact(mdr.Sphere("10 mm"), mdr.Viscoelastic(shear, 0.5), friction=mdr.Coulomb(friction))
    depth, lasting = random_moves(1, 20, 1e-4)
    shift = np.cumsum(np.random.default_rng(2).normal(0.0, 1e-5, 20))
    stepper, rows = mdr.Stepper(contact, "100 um"), []
    names = ("normal_force", "tangential_force", "contact_radius", "stick_radius")
    names += ("elastic_energy", "stored_tangential_energy", "dissipated_energy")
    for d, u, t in zip(depth.tolist(), shift.tolist(), lasting.tolist(), strict=True):
        stepper.advance(0.5 * d, shift=2.0 * u, duration=t)
        stepper.undo()
        stepper = stepper.copy()
        stepper.advance(d, shift=u, duration=t)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(contact, mdr.Path(time=np.cumsum(lasting), indentation=depth, shift=shift))
    for name, column in zip(names, np.transpose(rows), strict=True):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max())


def test_steps_of_a_flat_punch_with_friction_are_those_of_solve():
    """Its springs have no height: a step divided by that had 65536 parts."""
    contact = mdr.Contact(mdr.FlatPunch("1 mm"), mdr.Viscoelastic(KINDS[0], 0.5), friction=mdr.Coulomb(0.3))
    stepper, rows = mdr.Stepper(contact, "1 um"), []
    path = {
        "time": [1.0, 1.1, 2.0, 2.2],
        "indentation": [5e-7, 1e-6, 1e-6, 4e-7],
        "shift": [0.0, 2e-7, 3e-6, 2e-6],
    }
    for d, u, t in zip(path["indentation"], path["shift"], np.diff(path["time"], prepend=0.0), strict=True):
        forces = stepper.advance(d, shift=u, duration=float(t))
        rows.append((*forces, stepper.dissipated_energy))
    result = mdr.solve(contact, mdr.Path(**path))
    for name, column in zip(
        ("normal_force", "tangential_force", "dissipated_energy"), np.transpose(rows), strict=True
    ):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max())


def test_a_sudden_shift_has_the_stiffness_of_what_sticks():
    contact = mdr.Contact(mdr.Sphere("10 mm"), mdr.Viscoelastic(RUBBER, 0.5), friction=mdr.Coulomb(0.5))
    stepper = mdr.Stepper(contact, "100 um", count=2, springs=200)
    stepper.advance(np.array([5e-5, 2e-5]), duration=0.1)
    stiffness = stepper.tangential_stiffness
    moved = stepper.advance(stepper.indentation, shift=1e-12, duration=0.0)
    assert moved.tangential == pytest.approx(stiffness * 1e-12, rel=1e-4)
    with pytest.raises(mdr.PathError, match="shift = nan"):
        stepper.advance(stepper.indentation, shift=math.nan, duration=0.0)
    assert stepper.shift.tolist() == [1e-12, 1e-12]


def test_refused_steps_move_no_contact():
    stepper = mdr.Stepper(ball(KINDS[2]), "100 um", count=2, springs=100)
    stepper.advance(np.array([1e-5, 1e-5]), duration=0.1)
    with pytest.raises(mdr.PathError, match="zero time"):
        stepper.advance(np.array([2e-5, 2e-5]), duration=np.array([0.1, 0.0]))
    assert stepper.indentation.tolist() == [1e-5, 1e-5]


STICKY = mdr.Contact(
    mdr.Sphere("10 mm"),
    mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.2 s"), 0.5),
    adhesion=mdr.MaugisDugdale("0.2 J/m^2", range="1 um"),
)
"""Pulled from 30 um within 1/8 s to -10 um it separates."""


def test_steps_under_a_cohesive_zone_are_those_of_solve():
    depth = 1e-5 * np.array([-1.0, 0.0, 1.0, 2.0, 3.0, 2.0, 2.0, 0.0, -1.0, -2.0, 0.5, 1.0])
    lasting = np.full(depth.size, 0.125)
    depth[4], lasting[4], lasting[6] = 3e-5, 0.0625, 4.0
    stepper, rows = mdr.Stepper(STICKY, "30 um"), []
    names = ("normal_force", "contact_radius", "elastic_energy", "surface_energy", "dissipated_energy")
    names += ("jumped",)
    for d, t in zip(depth.tolist(), lasting.tolist(), strict=True):
        stepper.advance(min(d + 3e-6, 3e-5), duration=2.0 * t)
        stepper.undo()
        stepper = stepper.copy()
        stepper.advance(d, duration=t)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(STICKY, mdr.Path(time=np.cumsum(lasting), indentation=depth))
    for name, column in zip(names, np.transpose(rows), strict=True):
        assert column.tolist() == result[name].values.tolist()
    assert np.sum(np.transpose(rows)[-1]) == 3.0


def test_steps_under_a_short_range_are_those_of_solve():
    law = mdr.JKR("0.2 J/m^2", range="50 nm")
    contact = mdr.Contact(mdr.Sphere("10 mm"), STICKY.body, adhesion=law)
    depth = 1e-5 * np.array([-1.0, 0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 2.0, 1.0, 0.9, -8.0, -20.0])
    lasting = np.array([0.5, 1.0, 2.0, 2.0, 1.0, 4.0, 0.5, 2.0, 1.0, 0.5, 0.25, 0.25])
    stepper, rows = mdr.Stepper(contact, "40 um"), []
    names = ("normal_force", "contact_radius", "elastic_energy", "surface_energy", "dissipated_energy")
    names += ("jumped",)
    for d, t in zip(depth.tolist(), lasting.tolist(), strict=True):
        stepper.advance(d + 3e-6, duration=2.0 * t)
        stepper.undo()
        stepper = stepper.copy()
        stepper.advance(d, duration=t)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(contact, mdr.Path(time=np.cumsum(lasting), indentation=depth))
    for name, column in zip(names, np.transpose(rows), strict=True):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max())
    assert stepper.status is result.status is mdr.Status.PULLED_OFF
    state = stepper.state
    with pytest.raises(mdr.PathError, match=r"^the bodies touch again"):
        stepper.advance(1e-5, duration=1.0)
    again = mdr.Stepper(contact, "40 um")
    again.restore(state)
    assert again.normal_force == stepper.normal_force == 0.0
    assert again.dissipated_energy == rows[-1][4] > 0.0


def test_the_stiffness_of_a_short_range_is_that_of_a_sudden_step():
    contact = mdr.Contact(mdr.Sphere("10 mm"), STICKY.body, adhesion=mdr.JKR(0.2, range="50 nm"))
    stepper = mdr.Stepper(contact, "30 um", count=2)
    force = stepper.advance(np.array([2e-5, -1e-5]), duration=5.0).normal
    glassy = 2.0 * mdr.relaxation_of(STICKY.body).glassy * stepper.contact_radius
    assert stepper.normal_stiffness == pytest.approx(glassy, rel=1e-3)
    assert force[0] != 0.0 == force[1]


def test_contacts_under_a_cohesive_zone_take_steps_together_or_not_at_all():
    stepper = mdr.Stepper(STICKY, "30 um", count=2)
    stepper.advance(np.array([1e-5, -1e-5]), duration=0.125)
    force = stepper.normal_force
    assert force[0] != 0.0 == force[1]
    with pytest.raises(mdr.PathError, match="zero time"):
        stepper.advance(np.array([2e-5, -2e-5]), duration=0.0)
    with pytest.raises(mdr.PathError, match="needs the duration"):
        stepper.advance(2e-5)
    assert stepper.normal_force.tolist() == force.tolist()
    again = mdr.Stepper(STICKY, "30 um", count=2)
    again.restore(stepper.state)
    moved = [each.advance(2e-5, duration=0.25).normal.tolist() for each in (again, stepper)]
    assert moved[0] == moved[1]
    # within the time of a sudden step no spring creeps
    stiffness, nudge = stepper.normal_stiffness, 1e-9
    assert stepper.normal_force.tolist() == moved[1]
    sudden = stepper.advance(2e-5 + nudge, duration=1e-7).normal
    assert (sudden - moved[1]) / nudge == pytest.approx(stiffness, rel=1e-2)
    assert stepper.claims["normal_force"].error < 1e-4
    with pytest.raises(mdr.ProblemError, match="leave springs out"):
        mdr.Stepper(STICKY, "30 um", springs=100)


def test_a_growing_contact_is_lee_and_radok():
    """F = (8/3) sqrt(R) int 2 G(t - s) d(d^1.5)/ds ds / (2 (1 - nu)) of a paraboloid at a constant rate, by quadrature."""
    contact, rate = ball(mdr.Maxwell("1 MPa", "0.5 s"), mdr.Paraboloid("10 mm")), 1e-4
    stepper = mdr.Stepper(contact, "100 um", springs=500)
    for k in range(1, 11):
        force = stepper.advance(rate * 0.1 * k, duration=0.1).normal
    x, w = np.polynomial.legendre.leggauss(64)
    s = 0.5 * (x + 1.0)
    modulus = 2.0 * 1e6 * np.exp(-(1.0 - s) / 0.5) / (1.0 - 0.5)
    exact = 4.0 / 3.0 * 0.1 * np.sum(0.5 * w * modulus * 1.5 * rate**1.5 * np.sqrt(s))
    assert force == pytest.approx(exact, rel=2e-5)
    assert stepper.contact_radius == pytest.approx(math.sqrt(1e-2 * 1e-4), rel=1e-5)


def test_a_held_contact_relaxes():
    stepper = mdr.Stepper(ball(), "100 um")
    sudden = stepper.advance(5e-5, duration=0.0).normal
    kernel = RUBBER.relaxation(np.array([0.0, 0.3]))
    relaxed = stepper.advance(5e-5, duration=0.3).normal
    assert relaxed / sudden == pytest.approx(kernel[1] / kernel[0], rel=1e-12)
    work = stepper.elastic_energy + stepper.dissipated_energy
    stepper.undo()
    assert stepper.normal_force == sudden
    # nothing is done while the indentation rests
    assert stepper.elastic_energy == pytest.approx(work, rel=1e-12)
    assert stepper.normal_stiffness == pytest.approx(
        (stepper.copy().advance(5.0001e-5, duration=0.0).normal - sudden) / 1e-9, rel=1e-4
    )


@pytest.mark.parametrize("lasting", first_of([1e13, 1e16, 1e30]))
def test_liquids_part_in_retreats_of_any_slowness(lasting):
    """Their pull on the indenter is below the rounding of the force that has relaxed: springs stayed in contact."""
    contact = ball(KINDS[1])
    stepper = mdr.Stepper(contact, "100 um", springs=50)
    assert stepper.advance(5e-5, duration=0.1).normal > 0.0
    assert stepper.advance(4.9e-5, duration=lasting).normal == stepper.contact_radius == 0.0
    assert stepper.advance(6e-5, duration=0.1).normal > 0.0
    result = mdr.solve(contact, mdr.Path(time=[0.1, 0.1 + lasting], indentation=[5e-5, 4.9e-5]))
    assert float(result["contact_radius"][-1]) == float(result["normal_force"][-1]) == 0.0


def test_many_contacts_are_each_like_one():
    depth, lasting = (
        np.stack(each) for each in zip(*(random_moves(seed, 12, 1e-4) for seed in range(3)), strict=True)
    )
    many = mdr.Stepper(ball(), "100 um", count=3, springs=200)
    forces = [many.advance(depth[:, row], duration=lasting[:, row]).normal for row in range(12)]
    for i in range(3):
        one = mdr.Stepper(ball(), "100 um", springs=200)
        mine = [one.advance(depth[i, row], duration=lasting[i, row]).normal for row in range(12)]
        assert mine == [force[i] for force in forces]
        assert many.dissipated_energy[i] == one.dissipated_energy
    again = mdr.Stepper(ball(), "100 um", count=3, springs=200)
    again.restore(many.state)
    assert (
        again.advance(1e-5, duration=0.1).normal.tolist() == many.advance(1e-5, duration=0.1).normal.tolist()
    )


def test_claims_state_the_error_of_the_springs():
    few, many = (mdr.Stepper(ball(), "100 um", springs=n).claims["normal_force"] for n in (50, 1000))
    assert many.error < few.error < 3e-2
    assert "with 50 springs its error is up to" in few.reason


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (
            mdr.Contact(mdr.Sphere(1e-6), mdr.Viscoelastic(RUBBER, 0.5), adhesion=mdr.JKR(0.1, range="1 um")),
            "^adhesion range = 1 µm: the cohesive zone at rest",
        ),
        (
            mdr.Contact(
                mdr.FlatPunch(1.0),
                mdr.Viscoelastic(RUBBER, 0.5),
                adhesion=mdr.MaugisDugdale(0.1, range="1 um"),
            ),
            "^the zone would reach the sharp edge",
        ),
        (
            mdr.Contact(mdr.Sphere(1.0), mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", 0.2), 0.5)),
            "no fixed relaxation times",
        ),
    ],
)
def test_refusals(contact, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.Stepper(contact, "1 um")


@pytest.mark.parametrize(
    ("shear", "duration", "words"),
    [
        (RUBBER, None, "needs the duration of every step in s, finite and at least 0"),
        (RUBBER, -1.0, "needs the duration of every step in s, finite and at least 0"),
        (RUBBER, math.nan, "needs the duration of every step in s, finite and at least 0"),
        (KINDS[2], 0.0, "zero time"),
    ],
)
def test_steps_that_cannot_be_taken_leave_the_state(shear, duration, words):
    stepper = mdr.Stepper(ball(shear), "100 um", springs=100)
    stepper.advance(1e-5, duration=0.1)
    with pytest.raises(mdr.PathError, match=words):
        stepper.advance(2e-5, duration=duration)
    assert stepper.indentation == 1e-5


@pytest.mark.parametrize("duration", first_of([1.0, 1e-3]))
def test_the_work_of_gliding_is_that_of_friction(duration):
    """A flat punch whose normal force has relaxed: mu F_N times the distance is dissipated, or stored as the springs creep on."""
    contact = mdr.Contact(mdr.FlatPunch("1 mm"), mdr.Viscoelastic(RUBBER, 0.5), friction=mdr.Coulomb(0.3))
    stepper = mdr.Stepper(contact, "1 um")
    stepper.advance(1e-6, duration=1.0)
    stepper.advance(1e-6, duration=1e4)
    stepper.advance(1e-6, shift=1e-5, duration=duration)
    before = stepper.dissipated_energy + stepper.stored_tangential_energy
    forces = stepper.advance(1e-6, shift=3e-5, duration=duration)
    assert forces.tangential == pytest.approx(0.3 * forces.normal, rel=1e-14)
    work = stepper.dissipated_energy + stepper.stored_tangential_energy - before
    assert work == pytest.approx(0.3 * forces.normal * 2e-5, rel=1e-12)
