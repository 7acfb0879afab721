"""Random contacts of every kind that a Stepper takes: its steps are the rows of solve."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pymdr as mdr
from drawing import first_of

KINDS = ("friction", "adhesion", "plastic", "memory", "hysteresis", "plane", "memory with friction")
CASES = [(KINDS[seed % len(KINDS)], seed) for seed in range(3 * len(KINDS))]
CLOSE = ("no slip", "cohesion", "growth")
CASES += [(kind, seed) for seed, kind in enumerate(CLOSE * 3, 7)]
ATTRACTED = ("pull", "graded", "sharp edge")
CASES = [
    (kind, seed) for seed, kind in enumerate(("sharp edge", "force curve", "pull", "graded") * 3, 17)
] + CASES
CASES += [("plane", 15), *(("hysteresis", seed) for seed in (105, 107, 109))]
_WITHIN = {"memory": 1e-10, "plane": 1e-13, "hysteresis": 1e-12} | dict.fromkeys(CLOSE, 1e-12)
_WITHIN |= dict.fromkeys((*ATTRACTED, "force curve"), 1e-13)
"""Bounds of kinds relative to the largest value; of memory the claims count too, since solve takes other steps."""
NAMES = (
    "normal_force",
    "tangential_force",
    "contact_radius",
    "stick_radius",
    "elastic_energy",
    "stored_tangential_energy",
    "surface_energy",
    "dissipated_energy",
    "normal_stiffness",
    "jumped",
)


def random_contact(kind, rng, radius, deepest):
    young, poisson = 10.0 ** rng.uniform(3.0, 11.5), rng.uniform(-0.3, 0.5)
    size = math.sqrt(radius * deepest)
    profiles = (
        mdr.Paraboloid(radius),
        mdr.Cone(slope=0.1),
        mdr.PowerLaw(3.0, deepest, size),
        mdr.FlatPunch(size),
        mdr.RoundedFlat(0.5 * size, radius),
    )
    smooth = kind in ("adhesion", "hysteresis", "plane", "memory with friction", "cohesion")
    profile = profiles[rng.integers(3 if smooth else len(profiles))]
    friction = mdr.Coulomb(float(rng.choice([0.01, 0.3, 1.0])))
    body = mdr.Elastic(young, poisson)
    if kind == "force curve":
        known = mdr.solve(mdr.Contact(profile, body), mdr.indent(1.5 * deepest, steps=40))
        return mdr.Contact(known.force_curve(), body, friction=friction)
    if kind in ("plastic", "growth"):
        grows = {"apparent_radius": True} if kind == "growth" else {}
        strength = young * 10.0 ** rng.uniform(-4.0, -1.5)
        return mdr.Contact(
            mdr.Sphere(radius), mdr.ElasticPlastic(young, abs(poisson), yield_strength=strength, **grows)
        )
    if kind in ("adhesion", "hysteresis", "cohesion", *ATTRACTED):
        work = young / (1.0 - poisson**2) * deepest**1.5 / math.sqrt(radius) * 10.0 ** rng.uniform(-3.0, -0.5)
        receding = {"work_receding": 2.0 * work} if kind == "hysteresis" else {}
        law = mdr.JKR(work, **receding)
        if kind == "cohesion":
            law = mdr.MaugisDugdale(work, range=deepest * 10.0 ** rng.uniform(-2.0, 0.0))
        elif kind == "pull":
            profile, law = mdr.Sphere(radius), mdr.DMT(work)
        elif kind == "graded":
            exponent = rng.uniform(0.05, 0.6)
            body = mdr.Graded(young, size, exponent, min(abs(poisson), 0.9 / (2.0 + exponent)))
        elif kind == "sharp edge":
            profile = mdr.FlatPunch(size)
        return mdr.Contact(profile, body, adhesion=law)
    if kind in ("friction", "plane", "no slip"):
        return mdr.Contact(profile, body, friction=mdr.Coulomb(math.inf) if kind == "no slip" else friction)
    soft = mdr.Viscoelastic(mdr.Prony(young, [young, 0.3 * young], [0.1, 2.0]), abs(poisson))
    return mdr.Contact(profile, soft, friction=friction if kind == "memory with friction" else None)


def random_path(kind, rng, deepest):
    """Arrays of a path: walks with stays and, without a plane of springs, moves off the surface."""
    size = 12 if kind == "plane" else 40
    low = {
        "plane": 0.05,
        "adhesion": -2.0,
        "hysteresis": -2.0,
        "cohesion": -2.0,
        **dict.fromkeys(ATTRACTED, -2.0),
    }.get(kind, -0.3) * deepest
    depth = rng.uniform(low, deepest, size)
    depth[rng.random(size) < 0.1] = deepest
    stays = np.flatnonzero(rng.random(size) < 0.1)
    depth[stays] = depth[stays - 1]
    if kind != "plane" and not kind.startswith("memory"):
        special = rng.random(size) < 0.15
        depth[special] = rng.choice([0.0, -0.0, 5e-324, -5e-324, 1e-310, -1e-300], special.sum())
    path = {"indentation": depth}
    if kind in ("friction", "plane", "memory with friction", "no slip", "force curve"):
        steps = rng.normal(0.0, 0.1 * deepest, (size, 2) if kind == "plane" else size)
        path["shift"] = np.cumsum(steps, axis=0)
    if kind.startswith("memory"):
        path["time"] = np.cumsum(rng.exponential(0.3, size))
    return path


def moved_elsewhere(stepper, rng, move):
    """The stepper in the state in which it was, after a step that is undone, as a copy, or restored."""
    choice = rng.integers(4)
    if choice == 0:
        stepper.advance(*move)
        stepper.undo()
    elif choice == 1:
        copied = stepper.copy()
        stepper.advance(*move)
        return copied
    elif choice == 2:
        state = stepper.state
        stepper.advance(*move)
        stepper.restore(state)
    return stepper


def springs_of(result):
    (note,) = (note for note in result.notes if "springs whose forces are vectors" in note)
    return int(note.split()[0])


@pytest.mark.parametrize("case", first_of(CASES, 7))
def test_steps_of_random_contacts_are_the_rows_of_solve(case):
    """To 1e-10 of the largest value or less, in the plane on as many springs; with memory to what solve claims."""
    kind, rng = case[0], np.random.default_rng(case[1])
    radius = 10.0 ** rng.uniform(-9.0, 0.0)
    deepest = radius * 10.0 ** rng.uniform(-6.0, -1.5)
    contact, path = random_contact(kind, rng, radius, deepest), random_path(kind, rng, deepest)
    result = mdr.solve(contact, mdr.Path(**path))
    if kind == "plane":
        stepper = mdr.Stepper(contact, path["indentation"].max(), springs=springs_of(result))
    else:
        stepper = mdr.Stepper(contact, deepest)
    shifts = path.get("shift", np.zeros(len(path["indentation"]))).tolist()
    lasting = np.diff(path["time"], prepend=0.0).tolist() if "time" in path else [None] * len(shifts)
    rows, elsewhere = [], float(path["indentation"].max())
    for depth, shift, duration in zip(path["indentation"].tolist(), shifts, lasting, strict=True):
        at = tuple(shift) if kind == "plane" else shift
        stepper = moved_elsewhere(stepper, rng, (elsewhere, at, duration))
        stepper.advance(depth, shift=at, duration=duration)
        rows.append([np.array(getattr(stepper, name), dtype=float) for name in NAMES])
    assert stepper.status is result.status
    work = max(
        float(np.nanmax(np.abs(result[n])))
        for n in ("elastic_energy", "dissipated_energy")
        if n in result.data
    )
    for name, steps in zip(NAMES, zip(*rows, strict=True), strict=True):
        if name not in result.data or not np.all(
            result.claims[name].where if name in result.claims else True
        ):
            continue
        solved = result.data[name].values.astype(float)
        known = np.isfinite(solved)
        largest = max(
            float(np.max(np.abs(solved), initial=0.0, where=known)), work if "energy" in name else 0.0
        )
        claimed = result.claims[name].error if name in result.claims else None
        within = _WITHIN.get(kind, 1e-10)
        if claimed is not None and kind == "memory":
            within = max(within, float(np.nanmax(claimed)))
        assert np.all(np.abs(np.array(steps) - solved)[known] <= within * largest), (kind, name)


@pytest.mark.parametrize("seed", first_of((15, 0, 14, 32)))
def test_stick_radii_in_the_plane_are_known_to_the_distance_of_two_springs(seed):
    """Ten times as many springs move it by less than solve states."""
    rng = np.random.default_rng(seed)
    radius = 10.0 ** rng.uniform(-9.0, 0.0)
    deepest = radius * 10.0 ** rng.uniform(-6.0, -1.5)
    contact, path = random_contact("plane", rng, radius, deepest), random_path("plane", rng, deepest)
    result = mdr.solve(contact, mdr.Path(**path))
    stepper, rows = mdr.Stepper(contact, deepest, springs=1000), []
    for depth, shift in zip(path["indentation"].tolist(), path["shift"].tolist(), strict=True):
        stepper.advance(depth, tuple(shift))
        rows.append(stepper.stick_radius)
    largest = float(result["contact_radius"].max())
    assert f"the stick radius by {1.0 / springs_of(result):.1e} of" in result.claims["stick_radius"].reason
    assert np.abs(rows - result["stick_radius"].values).max() < largest / springs_of(result)


@pytest.mark.parametrize(
    "kind", first_of(("friction", "plane", "hysteresis", "adhesion", "plastic", "no slip", "memory"))
)
def test_threads_share_contacts(kind):
    """Also more threads than contacts, stacks that grow and edges that jump; copies move on their own."""
    rng = np.random.default_rng(3)
    contact, deepest = random_contact(kind, rng, 1e-2, 1e-5), 1e-5
    given = {"count": 5, "springs": 16 if kind == "plane" else None}
    many, alone = (mdr.Stepper(contact, deepest, workers=n, **given) for n in (7, 1))
    for row in range(80):
        # the range falls, so that the turning points of some contacts stay in their stacks
        depth = 5e-6 + 5e-6 * rng.uniform(0.8, 1.0, 5) * (-1.0) ** row * (1.0 - row / 80.0)
        depth[:2] = rng.uniform(-2e-5, 1e-5, 2)
        shift = 1e-6 * (1.0 - row / 80.0) * (-1.0) ** row * rng.uniform(0.9, 1.0, (2, 5))
        move = (depth, tuple(shift) if kind == "plane" else shift[0], 0.1)
        rows = [stepper.advance(*move) for stepper in (many, alone)]
        assert all(np.array_equal(one, other) for one, other in zip(*rows, strict=True))
    for name in NAMES:
        assert np.array_equal(getattr(many, name), getattr(alone, name)), name
    copied = many.copy()
    copied.advance(1e-6, (0.0, 0.0) if kind == "plane" else 0.0, 0.1)
    assert np.array_equal(many.normal_force, alone.normal_force)
    with pytest.raises(mdr.ProblemError, match="workers = 0"):
        mdr.Stepper(contact, deepest, workers=0)
