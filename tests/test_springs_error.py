"""Errors stated for few springs against many springs, in random motions of other kinds than those by which they are measured."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.drawing import examples
from tests.test_law_memory import KINDS, PROFILES

import pymdr as mdr
from pymdr.solving.springs_error import errors_of_springs

NORMAL = "normal_force", "contact_radius", "elastic_energy", "dissipated_energy"
PLANE = "contact_radius", "tangential_force", "stick_radius", "stored_tangential_energy", "dissipated_energy"


def followed(contact, deepest, springs, names, motion):
    stepper = mdr.Stepper(contact, deepest, springs=springs)
    rows = []
    for depth, shift, duration in zip(*motion, strict=True):
        stepper.advance(depth, shift, duration)
        rows.append([np.resize(getattr(stepper, name), 2) for name in names])
    return np.array(rows)


def holds(contact, deepest, springs, many, names, motion):
    results, expected = (followed(contact, deepest, n, names, motion) for n in (springs, many))
    stated = errors_of_springs(contact, deepest, springs)
    for column, name in enumerate(names):
        error = np.linalg.norm(results[:, column] - expected[:, column], axis=-1).max()
        of = names.index("contact_radius") if name == "stick_radius" else column
        largest = np.linalg.norm(expected[:, of], axis=-1).max()
        assert error <= (stated[name] + 1e-12) * largest, (
            f"{name}: {error / largest:g} is not {stated[name]:g}"
        )


def motion_of(seed, deepest, shifts=()):
    rng = np.random.default_rng(seed)
    rows = int(rng.integers(5, 60))
    waves = np.abs(np.sin(np.cumsum(rng.normal(0.0, 0.5, rows))))
    depth = deepest * (rng.uniform(-0.3, 1.0, rows) if rng.random() < 0.5 else waves)
    depth[rng.integers(rows)] = deepest
    shift = 10.0 ** rng.uniform(-1.0, 0.3) * np.cumsum(rng.normal(size=(rows, *shifts)), axis=0)
    return depth, shift, 10.0 ** (rng.uniform(-4.0, 2.0) + rng.uniform(-1.0, 1.0, rows))


@settings(max_examples=examples(20), deadline=None)
@given(
    st.sampled_from(sorted(KINDS)),
    st.sampled_from(sorted(PROFILES)),
    st.integers(8, 120),
    st.floats(-1.0, 0.0),
    st.integers(0, 2**32),
)
def test_with_memory(kind, profile, springs, depth, seed):
    contact, deepest = mdr.Contact(PROFILES[profile], mdr.Viscoelastic(KINDS[kind], 0.4)), 1e-3 * 10.0**depth
    holds(contact, deepest, springs, 1500, NORMAL, motion_of(seed, deepest))


@settings(max_examples=examples(20), deadline=None)
@given(
    st.sampled_from(["cone", "flat", "sphere"]),
    st.floats(-1.5, 0.5),
    st.integers(8, 120),
    st.floats(-9.0, 0.0),
    st.integers(0, 2**32),
)
def test_with_friction_in_the_plane(profile, friction, springs, size, seed):
    scale, mu = 10.0**size, 10.0**friction
    shape = {"sphere": mdr.Sphere(scale), "cone": mdr.Cone(slope=0.01), "flat": mdr.FlatPunch(scale)}[profile]
    deepest = 1e-3 * scale
    contact = mdr.Contact(shape, mdr.Elastic("1 GPa", 0.3), friction=mdr.Coulomb(mu))
    depth, shift, duration = motion_of(seed, deepest, (2,))
    holds(contact, deepest, springs, 1500, PLANE, (depth, mu * deepest * shift, duration))


@pytest.mark.long
@settings(max_examples=examples(10), deadline=None)
@given(
    st.sampled_from(sorted(KINDS)),
    st.sampled_from(sorted(PROFILES)),
    st.floats(-1.5, 0.5),
    st.integers(8, 80),
    st.integers(0, 2**32),
)
def test_with_memory_and_friction(kind, profile, friction, springs, seed):
    mu = 10.0**friction
    contact = mdr.Contact(PROFILES[profile], mdr.Viscoelastic(KINDS[kind], 0.4), friction=mdr.Coulomb(mu))
    depth, shift, duration = motion_of(seed, 1e-3)
    holds(
        contact,
        1e-3,
        springs,
        400,
        tuple(dict.fromkeys(NORMAL + PLANE)),
        (depth, mu * 1e-3 * shift, duration),
    )
