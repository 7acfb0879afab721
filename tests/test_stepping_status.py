"""Steps and the status, jumps and branches of solve along the same rows, for every kind of memory; force curves."""

import math

import numpy as np
import pytest

import pymdr as mdr
from pymdr.line.following import follow
from pymdr.solving.equilibria import AdhesiveLine

STEEL = mdr.Elastic("210 GPa", 0.3)
GEL = mdr.Elastic("30 kPa", 0.5)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.2 s"), 0.5)
COPPER = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
FRICTION = mdr.Coulomb(0.3)
BEAD, BALL = mdr.Sphere("1 mm"), mdr.Sphere("10 mm")


def force_curve(modulus=2e11):
    """Of a paraboloid of 10 mm."""
    d = 1.2e-5 * np.linspace(0.0, 1.0, 201)
    return mdr.ForceCurve(d, 4.0 / 3.0 * modulus * math.sqrt(0.01) * d**1.5, modulus=modulus)


CASES = {
    "friction": (mdr.Contact(BALL, STEEL, STEEL, friction=FRICTION), 1e-5),
    "in the plane": (mdr.Contact(BALL, STEEL, STEEL, friction=FRICTION), 1e-5),
    "force curve": (mdr.Contact(force_curve(), STEEL, friction=FRICTION), 1e-5),
    "JKR": (mdr.Contact(BEAD, GEL, adhesion=mdr.JKR(0.02)), 1e-5),
    "DMT": (mdr.Contact(BEAD, GEL, adhesion=mdr.DMT(1e-4)), 1e-5),
    "two works": (mdr.Contact(BEAD, GEL, adhesion=mdr.JKR(0.02, work_receding=0.06)), 1e-5),
    "memory": (mdr.Contact(BALL, RUBBER), 1e-5),
    "memory and friction": (mdr.Contact(BALL, RUBBER, friction=FRICTION), 1e-5),
    "cohesive zone with memory": (
        mdr.Contact(BALL, RUBBER, adhesion=mdr.MaugisDugdale(0.2, range="1 um")),
        1e-5,
    ),
    "yield": (mdr.Contact(BEAD, COPPER), 1e-5),
    "hard": (mdr.Contact(BEAD, mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="9 GPa")), 1e-6),
    "yield with adhesion": (mdr.Contact(BEAD, COPPER, adhesion=mdr.JKR(5.0)), 1e-6),
}
DEPTHS = np.array([-0.5, -0.2, 0.0, 0.3, 1.0, 0.4, -0.1, -20.0, -1.0, 0.2])
CHECKED = 1, 4, 7, 9
LASTING = 0.125


@pytest.mark.parametrize("kind", CASES)
def test_every_step_has_the_status_of_a_path_that_ends_there(kind):
    contact, deepest = CASES[kind]
    depth = deepest * DEPTHS
    shift = 0.2 * deepest * np.sin(np.arange(depth.size))
    springs = 32 if kind == "in the plane" else None
    stepper, jumped, attached = mdr.Stepper(contact, deepest, springs=springs), [], []
    channels = {"indentation": depth}
    if contact.friction is not None:
        channels["shift"] = np.stack([shift, shift], axis=1) if springs else shift
    if contact.is_viscoelastic:
        channels["time"] = LASTING * np.arange(1, depth.size + 1)
    for row, d in enumerate(depth.tolist()):
        stepper.advance(d, shift=channels.get("shift", shift)[row], duration=LASTING)
        jumped.append(stepper.jumped)
        attached.append(stepper.branch >= 0)
        if row in CHECKED:
            path = mdr.Path(**{name: values[: row + 1] for name, values in channels.items()})
            result = mdr.solve(contact, path)
            assert stepper.status is result.status
    if "jumped" in result.data:
        assert np.array_equal(jumped, result["jumped"].values)
    if contact.adhesion is not None and contact.plastic is None:
        assert np.array_equal(attached, result["normal_force"].values != 0.0)
    elif "contact_radius" in result.data:
        assert np.array_equal(attached, result["contact_radius"].values > 0.0)
    together = mdr.Stepper(contact, deepest, springs=springs, count=2)
    shifted = (shift[0], shift[0]) if springs else shift[0]
    together.advance(np.array([depth[0], depth[4]]), shift=shifted, duration=LASTING)
    assert (together.branch >= 0).tolist() == [False, True]
    assert together.status[1] is not mdr.Status.NOT_TOUCHED


def test_branches_are_those_that_solve_follows():
    """Over waves the edge jumps from branch to branch."""
    waves = mdr.Function(
        lambda r: r**2 / 2e-3 + 3e-7 * (1.0 - np.cos(1.5e5 * r)),
        derivative=lambda r: r / 1e-3 + 0.045 * np.sin(1.5e5 * r),
        max_radius=3e-4,
    )
    contact = mdr.Contact(waves, mdr.Elastic(4e4, 0.5), adhesion=mdr.JKR(1e-3))
    depth = 1e-6 * np.array([-1.0, 0.0, 2.0, 5.0, 9.0, 7.0, 4.0, 8.0, 0.0, -1.0, -3.0, 1.0])
    stepper, branches, jumped = mdr.Stepper(contact, "10 um"), [], []
    for d in depth.tolist():
        stepper.advance(d)
        branches.append(stepper.branch)
        jumped.append(stepper.jumped)
    # from a depth on at which the bodies are free
    history = follow(AdhesiveLine(contact).track(math.inf, 1e-5), depth.tolist(), None)
    assert len(set(branches)) > 3
    assert branches == history.branch.tolist()
    assert jumped == history.jumped.tolist()


@pytest.mark.parametrize("friction", [None, 0.3, math.inf])
def test_steps_on_a_force_curve_are_those_of_solve(friction):
    law = None if friction is None else mdr.Coulomb(friction)
    contact = mdr.Contact(force_curve(), STEEL, friction=law)
    rng = np.random.default_rng(1)
    depth = 1e-5 * np.abs(rng.normal(0.3, 0.3, 60)).clip(0.05, 1.0)
    depth[::11] = -1e-6
    shift = np.cumsum(rng.normal(0.0, 5e-7, 60))
    names = ["normal_force", "elastic_energy", "normal_stiffness"]
    channels = {"indentation": depth}
    if friction is not None:
        names += ["tangential_force", "tangential_stiffness", "stored_tangential_energy", "dissipated_energy"]
        channels["shift"] = shift
    stepper, rows = mdr.Stepper(contact, "10 um"), []
    for d, u in zip(depth.tolist(), shift.tolist(), strict=True):
        stepper.advance(d, u)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(contact, mdr.Path(**channels))
    for name, column in zip(names, np.transpose(rows), strict=True):
        if name not in result.data:
            continue
        exact = result[name].values
        known = np.isfinite(exact)
        # without slip the points tell only what was pressed once
        assert known.any() if friction == math.inf else known.sum() > 40
        assert column[known] == pytest.approx(exact[known], abs=1e-13 * np.abs(exact[known]).max()), name
    # the curve is that of a paraboloid of radius R: F and k per modulus are known at every depth
    hertz = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, friction=law), mdr.Path(**channels))
    force = np.transpose(rows)[0]
    assert force == pytest.approx(hertz["normal_force"].values, abs=1e-3 * force.max())


@pytest.mark.parametrize("friction", [None, FRICTION])
def test_steps_on_a_force_curve_with_memory_are_those_of_solve(friction):
    contact = mdr.Contact(force_curve(), RUBBER, friction=friction)
    depth = 1e-5 * np.array([0.3, 1.0, 0.6, 0.2, 0.8])
    time, shift = 0.125 * np.arange(1, 6), 1e-6 * np.array([0.0, 1.0, 3.0, 0.0, -2.0])
    channels = {"time": time, "indentation": depth} | ({} if friction is None else {"shift": shift})
    stepper, rows = mdr.Stepper(contact, "10 um"), []
    for d, u in zip(depth.tolist(), shift.tolist(), strict=True):
        rows.append(stepper.advance(d, u, duration=0.125))
    result = mdr.solve(contact, mdr.Path(**channels))
    assert stepper.status is result.status
    for name, column in zip(("normal_force", "tangential_force"), np.transpose(rows), strict=True):
        if name in result.data:
            exact = result[name].values
            assert column == pytest.approx(exact, abs=1e-13 * np.nanmax(np.abs(exact)), nan_ok=False)


@pytest.mark.parametrize("springs", [32])
def test_a_force_curve_in_the_plane_along_a_line_is_a_stack(springs):
    contact = mdr.Contact(force_curve(), STEEL, friction=FRICTION)
    plane, line = mdr.Stepper(contact, "10 um", springs=springs), mdr.Stepper(contact, "10 um")
    for d, u in ((5e-6, 0.0), (8e-6, 1e-6), (8e-6, 2e-5)):
        one, other = plane.advance(d, (0.6 * u, 0.8 * u)), line.advance(d, u)
    assert math.hypot(one.x, one.y) == pytest.approx(other.tangential, rel=2e-3)
    with pytest.raises(mdr.PathError, match="deeper than max_indentation"):
        plane.advance(1.1e-5, (0.0, 0.0))
