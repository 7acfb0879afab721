"""Steps exported as C headers: random histories at all scales against the stepper, jumps, restarts, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.drawing import first_of
from tests.test_law_history import InC, needs_c

import pymdr as mdr

JUMPING = (
    "law_advance(&s, d[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.contact_radius; out[4 * i + 2] = s.dissipated_energy; out[4 * i + 3] = s.jumps;",
)
YIELDING = (
    "law_advance(&s, d[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.contact_radius; out[4 * i + 2] = s.largest_indentation;",
)
DEEPEST = 2e-5
GEL = mdr.Contact(
    mdr.Sphere("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.MaugisDugdale("20 mJ/m^2", range="1 um")
)
TIP = mdr.Contact(
    mdr.Paraboloid("20 nm"),
    mdr.Elastic("2 GPa", 0.4),
    adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="0.4 nm"),
)
STICKY = [
    (GEL, DEEPEST),
    (TIP, 5e-9),
    (replace(GEL, adhesion=mdr.JKR("20 mJ/m^2")), DEEPEST),
    (replace(GEL, adhesion=mdr.DMT("2 mJ/m^2")), DEEPEST),
    (replace(GEL, profile=mdr.Cone(slope=0.1)), DEEPEST),
]
COPPER = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
BALLS = [
    (COPPER, 1e-3),
    (replace(COPPER, wall_factor=True), 2.0),
    (mdr.ElasticPlastic("70 GPa", 0.3, yield_strength="60 GPa"), 1e-8),
]


def walk(deepest, low, size, seed):
    rng = np.random.default_rng(seed)
    depth = deepest - np.abs(
        np.cumsum(rng.normal(0.0, 0.2 * deepest, size)) % (2.0 * (deepest - low)) - (deepest - low)
    )
    depth[rng.random(size) < 0.05] = deepest
    return depth


@needs_c
@pytest.mark.parametrize("case", first_of(STICKY))
@pytest.mark.parametrize("compiler", first_of(["cc", "c++"]))
def test_jumps_in_c_are_those_of_the_stepper(case, compiler, tmp_path):
    contact, deepest = case
    stepper = mdr.Stepper(contact, deepest)
    depth = walk(deepest, -4.0 * deepest, 2000, 1)
    code = InC(stepper, tmp_path, JUMPING, compiler)
    computed, jumps, expected = code.advance(depth, depth), 0, []
    for d in depth.tolist():
        force = stepper.advance(d).normal
        jumps += stepper.jumped
        expected.append((force, stepper.contact_radius, stepper.dissipated_energy, jumps))
    expected = np.array(expected)
    assert np.count_nonzero(np.diff(expected[:, 1] > 0.0)) > 20
    assert jumps > 20 or isinstance(contact.adhesion, mdr.DMT)
    for ours, row, within in zip(computed.T, expected.T, (1e-13, 1e-11, 1e-13, 0.0), strict=True):
        assert ours == pytest.approx(row, rel=0.0, abs=within * np.abs(row).max())
    assert len(code.bytes) == 48
    kept = code.bytes.raw
    for wrong in (1.1 * deepest, math.nan, -math.inf):
        assert code.advance([wrong], [0.0]).size == 0
        assert code.bytes.raw == kept


@needs_c
@pytest.mark.parametrize("case", first_of(BALLS))
@pytest.mark.parametrize("compiler", first_of(["cc", "c++"]))
def test_balls_that_yield_in_c_are_those_of_the_stepper(case, compiler, tmp_path):
    body, radius = case
    deepest = 0.1 * radius
    stepper = mdr.Stepper(mdr.Contact(mdr.Sphere(radius), body), deepest)
    depth = walk(deepest, -0.5 * deepest, 500, 2) * np.linspace(0.01, 1.0, 500)
    code = InC(stepper, tmp_path, YIELDING, compiler)
    computed = code.advance(depth, depth)
    expected = np.array([(stepper.advance(d).normal, stepper.contact_radius) for d in depth.tolist()])
    for ours, row in zip(computed.T[:2], expected.T, strict=True):
        assert ours == pytest.approx(row, rel=1e-12, abs=1e-14 * row.max())
    assert len(code.bytes) == 32


@pytest.mark.parametrize(
    "contact",
    [
        mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3), friction=mdr.Coulomb(0.3)),
        mdr.Contact(mdr.Sphere("1 mm"), COPPER, adhesion=mdr.JKR(0.1)),
        replace(GEL, adhesion=mdr.JKR("20 mJ/m^2", work_receding="60 mJ/m^2")),
    ],
)
def test_steps_that_are_not_in_headers(contact):
    with pytest.raises(mdr.ProblemError, match="no header has this step"):
        mdr.Stepper(contact, DEEPEST).c_header()
    with pytest.raises(mdr.ProblemError, match="not usable as a C identifier"):
        mdr.Stepper(GEL, DEEPEST).c_header("float")
