"""Headers of bodies with memory: random histories against the stepper and solve, sizes from nm to m, restarts, refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.drawing import examples, first_of
from tests.test_law_history import InC, needs_c

import pymdr as mdr

CALLS = (
    "law_advance(&s, d[i], u[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.elastic_energy; out[4 * i + 2] = s.dissipated_energy; "
    "out[4 * i + 3] = law_contact_radius(&s);",
)
KINDS = {
    "solid": mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["0.1 s", "2 s"]),
    "liquid": mdr.Maxwell("1 MPa", "0.5 s"),
    "liquid of two times": mdr.Prony("0 MPa", ["2 MPa", "0.5 MPa"], ["0.1 s", "2 s"]),
    "dashpot": mdr.KelvinVoigt("1 MPa", "0.1 MPa s"),
    "decades": mdr.Prony(
        "1 kPa", [f"{4.0**-k!r} GPa" for k in range(8)], [10.0 ** (k - 5) for k in range(8)]
    ),
}
PROFILES = {
    "sphere": mdr.Sphere(1.0),
    "cone": mdr.Cone(slope=0.01),
    "flat": mdr.FlatPunch(0.1),
    "edge": mdr.DomedPunch(0.01, 1.0),
}


def moves(seed, size, deepest, dashpot=False):
    """Depths with losses of contact, and durations over decades, some of which are sudden."""
    rng = np.random.default_rng(seed)
    depth = np.abs(rng.normal(0.0, 0.3 * deepest, size)).clip(0.0, deepest)
    depth[size // 3], depth[::9], depth[5::11] = deepest, -0.2 * deepest, depth[4::11][: depth[5::11].size]
    lasting = rng.exponential(0.1, size) * 10.0 ** rng.integers(-3, 2, size)
    if not dashpot:
        lasting[::7] = 0.0
    return depth, lasting


def followed(contact, deepest, depth, lasting, springs):
    stepper = mdr.Stepper(contact, deepest, springs=springs)
    names, rows = ("normal_force", "elastic_energy", "dissipated_energy", "contact_radius"), []
    for d, t in zip(depth.tolist(), lasting.tolist(), strict=True):
        stepper.advance(d, duration=t)
        rows.append([getattr(stepper, name) for name in names])
    return np.array(rows)


def agrees(law, computed, expected):
    """To rounding; the radius is interpolated."""
    size = np.abs(expected).max(axis=0)
    error = np.abs(computed - expected).max(axis=0) / size
    assert error[:3].max() < 1e-12, error
    assert error[3] < law.errors["contact_radius"]


@needs_c
@pytest.mark.parametrize("kind", first_of(list(KINDS)))
@pytest.mark.parametrize("profile", first_of(list(PROFILES)))
@pytest.mark.parametrize("compiler", first_of(["cc", "c++"]))
def test_histories_in_c_are_those_of_the_stepper(kind, profile, compiler, tmp_path):
    contact, deepest = mdr.Contact(PROFILES[profile], mdr.Viscoelastic(KINDS[kind], 0.5)), 1e-3
    law = mdr.export_law(contact, deepest, springs=40)
    code = InC(law, tmp_path, CALLS, compiler)
    for seed in range(3):
        depth, lasting = moves(seed, 200, deepest, kind == "dashpot")
        code.bytes[:] = bytes(len(code.bytes))
        agrees(law, code.advance(depth, lasting), followed(contact, deepest, depth, lasting, 40))


@needs_c
@pytest.mark.long
@settings(max_examples=examples(12), deadline=None)
@given(
    kind=st.sampled_from(list(KINDS)), log_radius=st.floats(-9, 0), log_depth=st.floats(-4, -2),
    log_time=st.floats(-6, 6), seed=st.integers(0, 999),
)  # fmt: skip
def test_histories_of_any_size(kind, log_radius, log_depth, log_time, seed, tmp_path_factory):
    radius = 10.0**log_radius
    deepest = 10.0**log_depth * radius
    contact = mdr.Contact(mdr.Sphere(radius), mdr.Viscoelastic(KINDS[kind], 0.4))
    law = mdr.export_law(contact, deepest, springs=24)
    depth, lasting = moves(seed, 60, deepest, kind == "dashpot")
    lasting *= 10.0**log_time
    result = InC(law, tmp_path_factory.mktemp("law"), CALLS).advance(depth, lasting)
    agrees(law, result, followed(contact, deepest, depth, lasting, 24))


@needs_c
def test_the_claim_holds_against_solve(tmp_path):
    """At most two errors of the claim: of the springs at the largest force, and of fewer springs in a smaller contact."""
    contact, deepest = mdr.Contact(mdr.Sphere(1.0), mdr.Viscoelastic(KINDS["solid"], 0.5)), 1e-3
    law = mdr.export_law(contact, deepest)
    depth, lasting = moves(7, 40, deepest, dashpot=True)  # a path has no sudden rows
    computed = InC(law, tmp_path, CALLS).advance(depth, lasting)
    result = mdr.solve(contact, mdr.Path(time=np.cumsum(lasting), indentation=depth))
    for column, name in enumerate(("normal_force", "elastic_energy", "dissipated_energy")):
        exact = result[name].values
        error = float(law.claims[name].error.max())
        assert np.abs(computed[:, column] - exact).max() < error * np.abs(exact).max()
        assert error < 1e-3


@needs_c
def test_liquids_part_in_slow_retreats(tmp_path):
    contact = mdr.Contact(mdr.Sphere(1.0), mdr.Viscoelastic(KINDS["liquid"], 0.5))
    law = mdr.export_law(contact, 1e-3, springs=16)
    rows = InC(law, tmp_path, CALLS).advance(np.array([5e-4, 4.9e-4]), np.array([0.1, 1e16]))
    assert rows[0, 0] > 0.0 == rows[1, 0] == rows[1, 3]


@needs_c
def test_bytes_continue_and_refused_steps_leave_them(tmp_path):
    contact, deepest = mdr.Contact(mdr.Sphere(1.0), mdr.Viscoelastic(KINDS["dashpot"], 0.5)), 1e-3
    law = mdr.export_law(contact, deepest, springs=16)
    depth, lasting = moves(1, 60, deepest, dashpot=True)
    code = InC(law, tmp_path, CALLS)
    size = len(code.bytes)
    assert size == 8 * (6 + 18 * 4)
    expected = code.advance(depth, lasting)
    code.bytes[:] = bytes(size)
    first = code.advance(depth[:21], lasting[:21])
    kept = code.bytes.raw
    for move in ((2.0 * deepest, 1.0), (math.nan, 1.0), (0.0, -1.0), (0.0, math.inf), (0.5 * deepest, 0.0)):
        assert code.advance([move[0]], [move[1]]).size == 0
        assert code.bytes.raw == kept
    code.bytes[:] = bytes(size)
    code.bytes[:] = kept
    assert np.array_equal(np.concatenate([first, code.advance(depth[21:], lasting[21:])]), expected)


def test_the_table_is_the_sudden_indentation():
    contact, deepest = mdr.Contact(mdr.Sphere(1.0), mdr.Viscoelastic(KINDS["solid"], 0.3)), 1e-3
    law = mdr.export_law(contact, deepest)
    stepper = mdr.Stepper(contact, deepest)
    sudden = stepper.advance(0.7 * deepest, duration=0.0).normal
    assert law.force(0.7 * deepest) == pytest.approx(sudden, rel=1e-5)
    assert law.stiffness(0.7 * deepest) == pytest.approx(stepper.normal_stiffness, rel=1e-5)
    assert any("follows 102 springs with memory" in note for note in law.notes)
    assert "with 100 springs its error is up to" in law.claims["normal_force"].reason


@pytest.mark.parametrize(
    ("contact", "options", "words"),
    [
        ({}, {"springs": 4}, "from 8 to 4096"),
        ({"adhesion": mdr.MaugisDugdale(0.1, range="1 um")}, {}, "with adhesion is not in headers"),
        ({"body": mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", 0.2), 0.5)}, {}, "no fixed relaxation times"),
    ],
)  # fmt: skip
def test_refusals(contact, options, words):
    body = mdr.Viscoelastic(KINDS["solid"], 0.5)
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(mdr.Contact(mdr.Sphere(1.0), **{"body": body, **contact}), "1 mm", **options)


def test_layers_are_refused():
    layers = mdr.Layered([mdr.Layer(mdr.Viscoelastic(KINDS["solid"], 0.4), "1 mm")], mdr.Rigid())
    with pytest.raises(mdr.ProblemError, match="memory of layers"):
        mdr.export_law(mdr.Contact(mdr.Sphere(1.0), layers), "1 mm")
