"""Claims: where the contact is a disk, why not elsewhere, and the bound that survives."""

import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import struve

import pymdr as mdr
from common import STEEL, UNIT
from drawing import examples
from pymdr.interpretation.certificate import certify_disk
from pymdr.interpretation.fields import line_gap, pressure
from pymdr.interpretation.validity import Claim
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.units import written

STATES = (
    "indentation",
    "normal_force",
    "contact_radius",
    "normal_stiffness",
    "mean_pressure",
    "elastic_energy",
)
FIELDS = ("pressure", "normal_displacement", "gap")


def solved(profile, path):
    return mdr.solve(mdr.Contact(profile, UNIT), path)


def wavy(A, k=10.0, alone=False):
    """r^2/2 + h (1 - cos kr) with A = h k^2 (R = 1)."""
    h = A / k**2
    f = lambda r: r * r / 2 + 2 * h * np.sin(k * r / 2) ** 2  # noqa: E731
    return mdr.Function(f, derivative=None if alone else lambda r: r + h * k * np.sin(k * r))


def wavy_g(x, A, k=10.0):
    return x * x + math.pi / 2 * A / k * x * struve(0, k * x)


def hollow(R=1.0):
    return mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / (2 * R), derivative=lambda r: -r / R)


def stepped():
    """A paraboloid to r = 0.5, a plateau to 1, then steep: f rises everywhere."""
    return mdr.Function(
        lambda r: np.where(r < 0.5, r * r, 0.25) + 2 * np.maximum(r - 1, 0.0),
        [0.5, 1.0],
        lambda r: np.where(r < 0.5, 2 * r, 0.0) + np.where(r > 1, 2.0, 0.0),
    )


def signorini(result, step, radii):
    """Smallest pressure inside and smallest gap outside a disk, by the independent integrals of 2.6."""
    a = float(result["contact_radius"][step])
    p = result.field("pressure", r=radii[radii < a], step=step).values
    h = result.field("gap", r=radii[radii > a], step=step).values
    return p.min(), h.min()


# --- thresholds ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("A", "rises"), [(1.9, True), (2.5, True), (3.15, True), (3.22, False), (4.5, False), (6.0, False)]
)
def test_a_wavy_paraboloid_rises_on_the_line_up_to_3_186(A, rises):
    line = equivalent_profile(wavy(A))
    turning = line.turning_points(1.0)
    assert (not turning) is rises
    x = np.linspace(1e-4, 1.0, 20001)
    assert np.all(np.diff(wavy_g(x, A)) > 0) is np.bool_(rises)
    for point in turning:
        assert abs(float(line.slope(point))) < 1e-8


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("A", [1.0, 2.5, 3.1])
def test_mild_waves_are_exact_everywhere(A, alone):
    result = solved(wavy(A, alone=alone), mdr.indent(0.5, steps=30))
    assert result.status is mdr.Status.COMPLETED
    for name in (*STATES, *FIELDS):
        claim = result.claims[name]
        assert claim.level is mdr.Level.EXACT
        assert claim.where.all()
    assert np.max(np.abs(wavy_g(result["contact_radius"].values, A) - result["indentation"].values)) < 1e-12
    assert result["force_lower_bound"].values == pytest.approx(result["normal_force"].values, rel=1e-13)


@pytest.mark.parametrize("profile", [wavy(4.5), wavy(4.5, alone=True), stepped()])
def test_a_rising_profile_may_still_not_be_a_disk(profile):
    r = np.linspace(1e-6, 1.1, 20001)
    assert np.all(np.diff(profile.gap(r)) >= 0)
    result = solved(profile, mdr.indent(0.6, steps=10))
    assert result.status is mdr.Status.PARTLY_REFUSED
    claim = result.claims["normal_force"]
    assert claim.where.any()
    assert not claim.where.all()
    assert "not a disk" in claim.reason
    assert " N to " in claim.reason
    assert "Rings" in claim.reason
    for name in STATES[1:]:
        assert np.isnan(result[name].values).tolist() == (~claim.where).tolist()
    assert np.all(np.isfinite(result["force_lower_bound"].values))
    assert np.all(np.diff(result["force_lower_bound"].values) > 0)
    valid = np.flatnonzero(claim.where)
    radii = np.unique(np.concatenate([np.geomspace(1e-4, 1.05, 60), np.linspace(0.01, 1.05, 120)]))
    radii = radii[np.abs(radii - 0.5) > 1e-3]
    for step in valid[:: max(1, valid.size // 4)]:
        p, h = signorini(result, int(step), radii)
        assert p >= -1e-9
        assert h >= -1e-9


def test_where_the_claim_ends_the_disk_fails():
    result = solved(wavy(4.5), mdr.indent(0.6, steps=10))
    line = ElasticLine(equivalent_profile(wavy(4.5)), 1.0)
    r = np.linspace(1e-3, 1.1, 400)
    refused = np.flatnonzero(~result.claims["pressure"].where)
    for step in refused[:: max(1, refused.size // 3)]:
        d = float(result["indentation"][step])
        # every disk that touches with g(a) = d needs tension or overlaps
        x = np.linspace(1e-3, 1.1, 40001)
        crossings = x[:-1][np.diff(np.sign(wavy_g(x, 4.5) - d)) > 0]
        for a in crossings:
            inside, outside = r[r < a], r[r > a]
            p = pressure(line, float(a), 0.0, inside)
            h = line_gap(line.equivalent, float(a), 0.0, outside)
            assert p.min() < -1e-6 or h.min() < -1e-6


# --- the concave punch -----------------------------------------------------------------------------------


@pytest.mark.parametrize("R", [0.5, 1.0, 4.0])
def test_concave_punch_from_full_contact_on(R):
    full = 1 / R
    d = full * np.array([0.2, 0.9, 1 - 1e-6, 1 + 1e-6, 3.0])
    result = solved(hollow(R), mdr.Path(indentation=d))
    assert result.claims["pressure"].where.tolist() == [False, False, False, True, True]
    force = 2 * (d + 1 / (3 * R))
    assert result["normal_force"].values[3:] == pytest.approx(force[3:], rel=1e-12)
    assert result["contact_radius"].values[3:].tolist() == [1.0, 1.0]
    assert result["force_lower_bound"].values == pytest.approx(force, rel=1e-12)
    assert f"{written(8 / (3 * R), 'N')} and more" in result.claims["normal_force"].reason
    with pytest.raises(mdr.NotValidError, match="step 0"):
        result.field("pressure", step=0)
    p = result.field("pressure", r=[0.5], step=None).values[:, 0]
    assert np.isnan(p).tolist() == [True, True, True, False, False]


def test_concave_punch_at_its_least_full_contact(references):
    expected = references["concave_punch_full"]["expected"]
    result = solved(hollow(), mdr.indent(expected["d"]))
    assert result.status is mdr.Status.COMPLETED
    assert float(result["normal_force"][0]) == pytest.approx(expected["F_over_Estar"], rel=1e-12)
    assert abs(float(result.field("pressure", r=0.0)[0])) < 1e-12


def test_concave_punch_under_force_control():
    result = solved(hollow(), mdr.load(4.0, steps=8))
    where = result.claims["contact_radius"].where
    assert where.tolist() == [False] * 5 + [True] * 3
    # what is prescribed is known whatever the contact is
    assert result["normal_force"].values.tolist() == pytest.approx([0.5 * i for i in range(1, 9)], rel=1e-14)
    assert result.claims["normal_force"].where.all()
    assert result["indentation"].values[5:] == pytest.approx(
        [3 / 2 - 1 / 3, 3.5 / 2 - 1 / 3, 2 - 1 / 3], rel=1e-12
    )
    assert np.isnan(result["indentation"].values[:5]).all()
    assert result["force_lower_bound"].values == pytest.approx(result["normal_force"].values, rel=1e-12)


def test_a_rim_does_not_touch_before_it_does():
    # the rim stands out by 1/2
    result = solved(hollow(), mdr.Path(indentation=[-0.6, -0.5, -0.4, 0.0]))
    assert result.claims["normal_force"].where.tolist() == [True, True, False, False]
    assert result["normal_force"].values[:2].tolist() == [0.0, 0.0]
    # a disk of radius 1 under d - g = 0 + 2/3
    assert float(result["force_lower_bound"][3]) == pytest.approx(2 / 3, rel=1e-12)


def test_a_refused_contact_keeps_its_reason_and_bound():
    result = solved(hollow(), mdr.indent(0.5))
    assert result.status is mdr.Status.REFUSED
    for name in STATES[1:]:
        assert result.claims[name].level is mdr.Level.NOT_VALID
        assert name not in result.data
        with pytest.raises(mdr.NotValidError, match=rf"{name} is not valid here: .*not a disk") as caught:
            result[name]
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
        with pytest.raises(mdr.NotValidError):
            result.to(name, "1")
    for name in FIELDS:
        with pytest.raises(mdr.NotValidError):
            result.field(name)
    assert float(result["force_lower_bound"][0]) == pytest.approx(2 * (0.5 + 1 / 3), rel=1e-12)
    assert "lower bound" in result.summary()
    assert mdr.NotValidError.__mro__[2] is RuntimeError


# --- the bound -------------------------------------------------------------------------------------------


@settings(max_examples=4, deadline=None)
@given(st.floats(0.5, 8.0), st.floats(0.02, 0.4), st.floats(-9, 3))
def test_the_bound_is_above_every_disk(A, depth, log_size):
    size = 10.0**log_size
    h, k = A / 100, 10.0
    profile = mdr.Function(
        lambda r: size * ((r / size) ** 2 / 2 + 2 * h * np.sin(k * r / size / 2) ** 2),
        derivative=lambda r: r / size + h * k * np.sin(k * r / size),
    )
    bound = float(solved(profile, mdr.indent(depth * size))["force_lower_bound"][0]) / size**2
    nodes, weights = np.polynomial.legendre.leggauss(80)
    a = np.linspace(1e-3, 1.0, 400)
    x = a[:, None] * (nodes + 1) / 2
    trial = 2 * (a[:, None] * weights / 2 * (depth - wavy_g(x, A))).sum(axis=1)
    assert bound >= trial.max() * (1 - 1e-12)
    assert bound == pytest.approx(trial.max(), rel=1e-3)


# --- assumptions and claims as data ----------------------------------------------------------------------


def test_assumptions_are_measured_at_the_largest_contact():
    body = mdr.Elastic(1.0, 0.2)
    result = mdr.solve(mdr.Contact(mdr.Sphere(2.0), body), mdr.indent(0.08) >> mdr.indent(0.01))
    a = float(result["contact_radius"].max())
    results = {assumption.name: assumption for assumption in result.assumptions}
    assert results["half-space"].measure == pytest.approx(a / 2.0, rel=1e-12)
    assert results["small slope"].measure == pytest.approx(a / math.sqrt(4 - a * a), rel=1e-12)
    assert results["elastic similarity"].measure == pytest.approx(0.6 / 1.6, rel=1e-12)
    assert results["half-space"].met
    assert results["half-space"].limit == results["small slope"].limit == 0.3
    steep = {b.name: b for b in solved(mdr.Cone(slope=0.31), mdr.indent(1e-9)).assumptions}
    assert not steep["small slope"].met
    assert steep["small slope"].measure == pytest.approx(0.31, rel=1e-12)
    assert "half-space" not in steep


def test_every_claim_has_a_reason_and_a_source():
    result = solved(mdr.Sphere(1.0), mdr.indent(0.1, steps=3))
    assert set(result.claims) == {*STATES, *FIELDS, "force_lower_bound", "stress"}
    for claim in result.claims.values():
        assert claim.level is mdr.Level.EXACT
        assert claim.reason
        assert any(name in claim.source for name in ("Sneddon", "Barber"))
        assert claim.where.dtype == bool
        assert claim.where.shape == (3,)
    assert "edge_amplitude" in solved(mdr.FlatPunch(1.0), mdr.indent(0.1)).claims


def test_a_claim_prints_in_one_line():
    claim = Claim(
        mdr.Level.APPROXIMATE, "springs", "Popov", np.array([True, False, True]), np.array([1e-3, 5.0, 2e-3])
    )
    assert repr(claim) == "<Claim APPROXIMATE in 2 of 3 steps, error up to 0.002: springs [Popov]>"


def test_a_claim_that_holds_nowhere_cannot_be_read():
    nowhere = Claim(mdr.Level.EXACT, "why", "who", np.zeros(3, dtype=bool))
    assert not nowhere.readable
    with pytest.raises(mdr.NotValidError, match=r"force is not valid here: why \[who\]"):
        nowhere.require("force")
    assert Claim(mdr.Level.APPROXIMATE, "", "", np.array([False, True])).readable
    assert not Claim(mdr.Level.NOT_VALID, "", "", np.array([True])).readable


def test_the_certificate_of_closed_forms_is_immediate():
    line = ElasticLine(equivalent_profile(mdr.Sphere(1.0)), 1.0)
    certificate = certify_disk(line, states_at_depth(line, np.linspace(-0.1, 0.9, 5)))
    assert certificate.disk.all()
    assert certificate.reason == ""


def test_an_assessment_agrees_with_the_solution():
    contact = mdr.Contact(hollow(), UNIT)
    path = mdr.Path(indentation=[0.1, 1.6, 0.3]) >> mdr.hold(steps=9)
    study, result = mdr.assess(contact, path), mdr.solve(contact, path)
    assert study.largest["indentation"] == pytest.approx(1.6, rel=1e-12)
    assert study.largest["normal_force"] == pytest.approx(2 * (1.6 + 1 / 3), rel=1e-12)
    assert set(study.claims) == set(result.claims)
    for name, claim in result.claims.items():
        again = study.claims[name]
        assert (again.level, again.reason) == (claim.level, claim.reason)
        assert again.where.tolist() == claim.where.tolist()
    assert study.claims["pressure"].where.tolist() == [False, True] + [False] * 10
    assert "not a disk" in study.summary()


def test_an_assessment_of_a_ball():
    ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    path = mdr.load("50 N", steps=10_000) >> mdr.hold(steps=10_000) >> mdr.indent(0.0, steps=10_000)
    study, result = mdr.assess(ball, path), mdr.solve(ball, mdr.load("50 N"))
    for name in ("indentation", "normal_force", "contact_radius"):
        assert study.largest[name] == pytest.approx(float(result[name][0]), rel=1e-12)
    assert study.assumptions == result.assumptions
    assert all(claim.level is mdr.Level.EXACT for claim in study.claims.values())
    for bad in (3, "50 N", None):
        with pytest.raises(mdr.PathError):
            mdr.assess(ball, bad)
        with pytest.raises(mdr.ProblemError):
            mdr.assess(bad, path)


RADII = np.linspace(0.0, 2e-3, 25)
PROFILES = (
    mdr.Sphere("10 mm"),
    mdr.FlatPunch("1 mm"),
    mdr.Sampled(RADII, RADII**2 / 0.02),
    mdr.Sampled(RADII, RADII**2 / 0.02, scatter=np.full(25, 1e-9)),
)
LAWS = ({}, {"adhesion": mdr.JKR("50 mJ/m^2")}, {"friction": mdr.Coulomb(0.2)})


@settings(max_examples=examples(40), deadline=None)
@given(
    profile=st.sampled_from(PROFILES),
    law=st.sampled_from(LAWS),
    channel=st.sampled_from(["indentation", "normal_force", "travel"]),
    size=st.floats(0.1, 1.0),
    steps=st.integers(1, 5),
    keep=st.sampled_from([None, None, 1, 2, [0, -1], 9]),
    stiffness=st.sampled_from([None, "1e6 N/m", 0.0]),
)
def test_an_assessment_claims_and_refuses_what_solve_does(
    profile, law, channel, size, steps, keep, stiffness
):
    body = mdr.Contact(profile, STEEL, **law)
    path = mdr.ramp(steps=steps, **{channel: size * (10.0 if channel == "normal_force" else 1e-6)})
    try:
        solved = mdr.solve(body, path, keep=keep, machine_stiffness=stiffness)
    except mdr.PymdrError as error:
        kind, words = type(error), str(error)
        with pytest.raises(kind, match=f"^{re.escape(words)}$"):
            mdr.assess(body, path, keep=keep, machine_stiffness=stiffness)
        return
    assessed = mdr.assess(body, path, keep=keep, machine_stiffness=stiffness)
    assert assessed.claims.keys() == solved.claims.keys()
    for name, claim in solved.claims.items():
        computed = assessed.claims[name]
        assert (computed.level, computed.reason, computed.source) == (claim.level, claim.reason, claim.source)
        assert computed.where.tolist() == claim.where.tolist()
        if "adhesion" in law:
            assert "rigorous" not in claim.reason
    assert (assessed.rows, assessed.quantities) == (solved.data.sizes["step"], len(solved.data))


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(0.1, 10.0), st.floats(10.0, 40.0))
def test_only_a_stiff_machine_prescribes_the_indentation_of_what_is_no_disk(stiffness, amplitude):
    contact = mdr.Contact(wavy(amplitude), UNIT)
    soft = mdr.solve(contact, mdr.travel(1.5, steps=8), machine_stiffness=stiffness)
    disk = soft.claims["normal_force"].where
    assert not disk.all()
    assert np.array_equal(soft.claims["indentation"].where, disk)
    assert np.all(np.isnan(soft["indentation"].values[~disk]))
    assert np.all(np.isfinite(soft["force_lower_bound"].values))
    stiff = mdr.solve(contact, mdr.travel(1.5, steps=8), machine_stiffness=math.inf)
    assert stiff.claims["indentation"].where.all()
