"""The forces that fits tabulate and their rates over moduli and laws of adhesion, against contacts solved one by one."""

import numpy as np
import pytest
from scipy.optimize import brentq

import pymdr as mdr
from pymdr.problem.parameters import parameters_of, with_parameters
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.fits.families import Ladder, axes_of, effects_of, family_of
from pymdr.solving.fits.forces import forces_of
from pymdr.solving.fits.kernels import (
    AS_IT_IS,
    NUMBERS,
    SCALE,
    SHAPE,
    Batch,
    compiled,
    member_at,
    on_machine,
    read,
)
from pymdr.solving.fits.kernels.model import roots_at
from pymdr.solving.fits.quick import table_of
from pymdr.solving.fits.unknowns import unknowns_of

_WAVY_RADII = np.linspace(0.0, 5e-6, 60)
WAVY = mdr.Sampled(_WAVY_RADII, _WAVY_RADII**2 / 1e-5 + 2e-8 * np.sin(_WAVY_RADII / 4e-7) ** 2)
"""On this machine its contact jumps from wave to wave before it is lost."""
SPRING = 0.05
WORK, MODULUS, RADIUS = 8e-3, 1e7, 1e-6
BODIES = mdr.Elastic(MODULUS, 0.3), mdr.Elastic(3.0 * MODULUS, 0.4)


def tip():
    r = np.linspace(0.0, 2.0 * RADIUS, 60)
    height = r**2 / (2.0 * RADIUS) * (1.0 + 0.05 * np.sin(3.0 * r / RADIUS))
    return mdr.Sampled(radius=r, height=height, interpolation=mdr.CubicSpline(tip="round"))


def solved(contact, depth, compliance):
    """Forces in N at depths or travels of the last branch, whose parameters are bisected one by one."""
    states = AdhesiveLine(contact).equilibria.states

    def travel(s):
        return (rows := states(s)).indentation + compliance * rows.normal_force

    grid = np.linspace(0.0, 1.5 * RADIUS, 401)
    low = np.full(depth.shape, grid[np.argmin(travel(grid))])
    high = np.full(depth.shape, grid[-1])
    for _ in range(40):
        middle = 0.5 * (low + high)
        above = travel(middle) > depth
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return states(low).normal_force


@pytest.mark.parametrize(
    ("profile", "law", "compliance"),
    [
        (mdr.Paraboloid(RADIUS), mdr.JKR(WORK), 0.5),
        (mdr.Paraboloid(RADIUS), mdr.DMT(WORK), 0.0),
        (mdr.Paraboloid(RADIUS), mdr.MaugisDugdale(WORK, strength=4e5), 0.5),
        (mdr.Cone(slope=0.3), mdr.MaugisDugdale(WORK, range="5 nm"), 0.0),
        (tip(), mdr.JKR(WORK), 0.0),
    ],
)
def test_rates_over_parameters(profile, law, compliance):
    contact = mdr.Contact(profile, *BODIES, adhesion=law)
    forces = forces_of(contact, 1e-7, compliance, None)
    depth = forces.fold + (8e-8 - forces.fold) * np.linspace(0.02, 1.0, 8)
    effects = effects_of(contact, forces, depth)
    parameters = {p.name: p.value for p in parameters_of(contact)}
    assert {"body.young", "counterbody.young", "adhesion.work"} <= set(effects)
    for name in effects.keys() & parameters.keys():
        high, low = (
            solved(with_parameters(contact, {name: parameters[name] * np.exp(step)}), depth, compliance)
            for step in (1e-4, -1e-4)
        )
        differences = (high - low) / 2e-4
        scale = max(np.abs(differences).max(), 1e-3 * np.ptp(forces.at(depth)[0]))
        np.testing.assert_allclose(effects[name], differences, atol=1e-4 * scale, rtol=0.0, err_msg=name)


@pytest.mark.parametrize("compliance", [0.0, 0.05])
def test_forces_next_to_the_first_contact(compliance):
    """The curvature of the force is infinite where a cohesive zone begins to surround a contact."""
    contact = mdr.Contact(mdr.Paraboloid(RADIUS), BODIES[0], adhesion=mdr.MaugisDugdale(WORK, strength=4e5))
    forces = forces_of(contact, 1e-7, compliance, None)
    first = forces.depth[forces.touch]
    assert forces.contact_radius[forces.touch] == pytest.approx(0.0, abs=1e-3 * RADIUS)
    depth = first + 0.05 * abs(first) * np.linspace(-1.0, 1.0, 41)
    force = forces.at(depth)[0]
    np.testing.assert_allclose(
        force, solved(contact, depth, compliance), rtol=0.0, atol=1e-7 * np.ptp(forces.force)
    )


def force_at_loss(scale, work, softness):
    """Force in N at the smallest travel of a JKR contact, by its equations; modulus and work are multiplied by the scale."""
    modulus, work = scale * MODULUS / (1.0 - 0.3**2), scale * work

    def rate(a):  # of d + softness F over the contact radius
        stiffness = 2.0 * modulus * a
        smooth = 2.0 * a / RADIUS
        excess = np.sqrt(2.0 * np.pi * work * a / modulus)
        return (smooth - 0.5 * excess / a) + softness * (stiffness * (smooth - 1.5 * excess / a))

    a = brentq(rate, 1e-12, RADIUS, xtol=1e-18, rtol=1e-14)
    return 4.0 / 3.0 * modulus * a**3 / RADIUS - np.sqrt(8.0 * np.pi * work * modulus * a**3)


@pytest.mark.parametrize("engine", [AS_IT_IS, compiled.ENGINE], ids=["arrays", "compiled"])
@pytest.mark.parametrize("softness", [0.0, 0.5])
def test_rates_of_samples_beyond_the_loss_of_contact(engine, softness):
    """Samples that are taken for ones in contact have the force at the smallest travel, which moves with every number."""
    contact = mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic(MODULUS, 0.3), adhesion=mdr.JKR(WORK))
    unknowns = unknowns_of(contact, ["body.young", "adhesion.work"])
    table = table_of(family_of(contact, axes_of(contact, unknowns), 1e-7))
    theta = np.zeros((1, NUMBERS))
    theta[0, SCALE], theta[0, SHAPE] = 0.2, unknowns[1].to_free(WORK) + 0.1
    place = np.array([[-5e-8, 0.0, 5e-8, 0.0, -5e-8]])
    batch = Batch(place, np.zeros_like(place), np.array([softness]))
    inside, rates = np.ones(place.shape, dtype=bool), np.empty((1, 2, place.size))
    directions = np.eye(NUMBERS)[[SCALE, SHAPE]]
    engine.tangents_all(batch, directions, table, theta, inside, inside, rates)
    for row, step in zip(rates[0], 1e-4 * np.eye(2), strict=True):
        high, low = (
            force_at_loss(np.exp(0.2 + ahead[0]), WORK * np.exp(0.1 + ahead[1]), softness)
            for ahead in (step, -step)
        )
        np.testing.assert_allclose(row[[0, -1]], (high - low) / 2e-4, rtol=1e-5)


def wavy(law):
    return mdr.Contact(WAVY, mdr.Elastic("3 kPa", 0.5), adhesion=law)


def pulled(contact, travel):
    """Forces in N in retreat, followed by ``solve``."""
    path = mdr.Path(travel=np.append(0.0, travel))
    return mdr.solve(contact, path, machine_stiffness=SPRING)["normal_force"].values[1:]


@pytest.mark.parametrize("law", [mdr.JKR(1e-3), mdr.MaugisDugdale(1e-3, range="200 nm")])
def test_a_contact_that_jumps_before_its_loss(law):
    contact, travel = wavy(law), np.linspace(0.0, -1.4e-6, 701)
    force = pulled(contact, travel)
    inside = force != 0.0
    forces = forces_of(contact, 3e-6, 1.0 / SPRING, None)
    assert forces.deeper is not None
    assert travel[inside].min() > forces.fold > travel[inside].min() - 2e-9
    np.testing.assert_allclose(forces.at(travel)[0][inside], force[inside], atol=1e-5 * np.ptp(force), rtol=0)
    # of either branch, away from its fold
    depth = np.array([0.5 * (forces.fold + forces.deeper.fold), forces.deeper.fold + 1e-8, 0.0])
    effects = effects_of(contact, forces, depth)
    for name in ("body.young", "adhesion.work"):
        value = 3e3 if name == "body.young" else 1e-3
        high, low = (
            pulled(with_parameters(contact, {name: value * np.exp(step)}), depth[::-1])[::-1]
            for step in (1e-4, -1e-4)
        )
        np.testing.assert_allclose(
            effects[name], (high - low) / 2e-4, rtol=2e-4, atol=1e-4 * np.ptp(force), err_msg=name
        )


def test_maps_follow_a_contact_that_jumps_before_its_loss():
    contact, travel = wavy(mdr.JKR(1e-3)), np.linspace(0.0, -1.35e-6, 1351)
    axes = axes_of(contact, unknowns_of(contact, ["adhesion.work"]))
    number = axes.number.to_free(1e-3)
    family = family_of(contact, axes, 2e-6, None, Ladder(number - 4e-4, number + 4e-4, 9))
    member = member_at(table_of(family), number)
    machine = on_machine(member, 1.0 / SPRING)
    force = read(member.force, member.slope, roots_at(member, machine, 1.0 / SPRING, travel))[0]
    np.testing.assert_allclose(force, pulled(contact, travel), atol=1e-5 * np.ptp(force), rtol=0)


def test_fits_of_a_contact_that_jumps_before_its_loss():
    truth = np.append(np.linspace(-1e-6, 1e-6, 200), np.linspace(1e-6, -2e-6, 600))
    path = mdr.Path(travel=truth)
    force = mdr.solve(wavy(mdr.JKR(1e-3)), path, machine_stiffness=SPRING)["normal_force"].values
    force = force + 1e-3 * np.ptp(force) * np.random.default_rng(5).normal(size=force.size)
    curve = mdr.MeasuredCurve(force=force, travel=truth + 1e-7, spring_constant=SPRING)
    result = mdr.fit(wavy(mdr.JKR(5e-4)), curve, ["body.young", "adhesion.work"])
    for name, value in (("body.young", 3e3), ("adhesion.work", 1e-3), ("contact_point", 1e-7)):
        assert abs(result[name].value - value) < 3.0 * result[name].error, name
    assert max(result[name].error / result[name].value for name in ("body.young", "adhesion.work")) < 1.5e-3
