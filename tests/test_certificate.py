"""The certificate of the disk against pressures and gaps by brute force, and against boundary elements on rings."""

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import UNIT
from drawing import examples, first_of
from pymdr.explore.seen import numbers
from pymdr.independent.rings import solve_indentation
from pymdr.interpretation.certificate import certify_disk, certify_history, noise_remark, valid_ranges
from pymdr.interpretation.disks import disk_depths, holes
from pymdr.line.foundation import ElasticLine, normal_force, states_at_depth
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import Place
from pymdr.solving.teaching import friction_foundation


def loaded(name):
    """A module of the references, which are no package."""
    known = f"pymdr_certificate_{name}"
    spec = importlib.util.spec_from_file_location(known, Path(__file__).parent / "reference" / f"{name}.py")
    module = sys.modules[known] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


quadrature, drawn = loaded("quadrature"), loaded("random_profiles")
Power, Wave, Bump, TermCurve = drawn.Power, drawn.Wave, drawn.Bump, drawn.TermCurve


def waves(rng, L):
    k = 2 * math.pi * rng.uniform(0.5, 12.0) / L
    R = L / 10 ** rng.uniform(-5, -0.5)
    h = rng.uniform(2.5, 8.0) / (k * k * R)
    f = lambda r: r * r / (2 * R) + 2 * h * np.sin(k * r / 2) ** 2  # noqa: E731
    return mdr.Function(f, derivative=lambda r: r / R + h * k * np.sin(k * r)), (
        Power(0.5 * L * L / R, 2.0, L),
        Wave(h, k),
    )


def bumps(rng, L):
    R = L / 10 ** rng.uniform(-5, -0.5)
    m = L * rng.uniform(0.2, 0.8)
    w = m * 10 ** rng.uniform(-2.0, -0.7)
    h = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 6.0) * 2 * w * w / R
    bell = lambda r: h * np.exp(-0.5 * ((r - m) / w) ** 2)  # noqa: E731
    f = lambda r: r * r / (2 * R) + bell(r)  # noqa: E731
    return mdr.Function(f, derivative=lambda r: r / R - (r - m) / w**2 * bell(r)), (
        Power(0.5 * L * L / R, 2.0, L),
        Bump(h, m, w),
    )


def plateaus(rng, L):
    """A paraboloid, a plateau behind a concave kink, and a cone: the slope falls, then rises."""
    R, b = L / 10 ** rng.uniform(-5, -0.5), L * rng.uniform(0.2, 0.6)
    c = b * rng.uniform(1.2, 1.6)
    down, up = rng.uniform(0.3, 1.0) * b / R, rng.uniform(0.5, 3.0) * b / R
    f = lambda r: r * r / (2 * R) - down * np.maximum(r - b, 0) + up * np.maximum(r - c, 0)  # noqa: E731
    slope = lambda r: r / R - np.where(r > b, down, 0.0) + np.where(r > c, up, 0.0)  # noqa: E731
    return mdr.Function(f, [b, c], slope), (
        Power(0.5 * L * L / R, 2.0, L),
        Power(-down * L, 1.0, L, b),
        Power(up * L, 1.0, L, c),
    )


def where(curve, x):
    """A radius as a pair for quadrature.py."""
    index, offset = quadrature.place(curve, np.longdouble(x))
    return int(index), offset[()]


def extremes(line, curve, d):
    """Least pressure over the mean one and least gap over d of the best disk, read on a fine grid, by quadrature."""
    state = states_at_depth(line, np.array([d]))
    a = float(state.contact_radius[0])
    top = line.equivalent.overlap_radius(d)
    mean = 2 * float(line.equivalent.moment(np.array([a]))[0]) / a**2
    r = a * (np.arange(1500) + 0.5) / 1500
    p = line.equivalent.pressure_integral(r, a)
    worst = [r[p.argmin()], *(r[p.argmin()] + a / 1500 * np.linspace(-1, 1, 9))]
    at = where(curve, a)
    pressures = [
        float(quadrature.pressure_integral(curve, where(curve, x), at)[0])
        for x in worst
        if 0 < x < a * (1 - 1e-9)
    ]
    gaps = [math.inf]
    if a < top:
        r = a + (top - a) * ((np.arange(1500) + 0.5) / 1500) ** 2
        h = line.equivalent.gap_integral(r, a)
        near = float(np.interp(h.argmin() + 0.5, np.arange(1500), r))
        gaps = [float(quadrature.gap(curve, where(curve, x), at)[0]) for x in (r[h.argmin()], near) if x > a]
    return min(pressures) / mean, min(gaps, default=math.inf) / d


@pytest.mark.parametrize("seed", first_of(range(6), 2))
@pytest.mark.parametrize("kind", [waves, bumps])
def test_disks_are_disks_and_others_are_not(kind, seed):
    rng = np.random.default_rng([seed, 11 if kind is waves else 12])
    L = 10 ** rng.uniform(-9, 3)
    profile, terms = kind(rng, L)
    line = ElasticLine(equivalent_profile(profile), 1.0)
    curve = TermCurve(terms, 4.0 * L)
    deepest = float(np.max(line.equivalent.g(np.linspace(0.05, 1.0, 9) * L)))
    result = disk_depths(line.equivalent, deepest)
    ends = [x for pair in result.strict for x in pair if 0 < x < 0.99 * deepest]
    depths = [*(deepest * rng.uniform(0.05, 1.0, 4)), *(x * s for x in ends for s in (0.999, 1.001))]
    for d in depths:
        certified = any(low <= d <= high for low, high in result.strict)
        p, h = extremes(line, curve, d)
        if certified:
            assert p >= -1e-8
            assert h >= -1e-8
        else:
            assert min(p, h) < -1e-9


@pytest.mark.parametrize("seed", first_of(range(6), 2))
def test_concave_kinks_are_passed_over_only_where_their_ring_is_narrow(seed):
    rng = np.random.default_rng([seed, 13])
    L = 10 ** rng.uniform(-9, 3)
    profile, _ = plateaus(rng, L)
    line = ElasticLine(equivalent_profile(profile), 1.0)
    equivalent = line.equivalent
    b = equivalent.corners(L)[0][0]
    deepest = float(equivalent.g(np.array([L]))[0])
    depths = deepest * np.linspace(0.02, 1.0, 40)
    states = states_at_depth(line, depths)
    certificate = certify_disk(line, states)
    strict = disk_depths(equivalent, deepest).strict
    assert all(high <= float(equivalent.g(np.array([b]))[0]) * (1 + 1e-12) for _, high in strict)
    for i, a in enumerate(states.contact_radius):
        if a <= b * 1.001:
            continue
        half = 0.5e-3 * a
        p = [float(equivalent.pressure_integral(np.array([b + s * half]), a)[0]) for s in (-1.0, 1.0)]
        if min(p) < 0:
            assert not certificate.disk[i]
        if certificate.disk[i]:
            assert certificate.remark
            grid = np.linspace(1e-3 * b, a, 4001)[:-1]
            grid = grid[np.abs(grid - b) > half]
            assert equivalent.pressure_integral(grid, a).min() >= 0


@pytest.mark.long
def test_the_ring_next_to_a_kink_and_its_fraction_of_the_load():
    profile = mdr.Paraboloid(1.0) + mdr.Function(
        lambda r: -0.2 * np.maximum(r - 0.3, 0), [0.3], lambda r: np.where(r > 0.3, -0.2, 0.0)
    )
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.6))
    claim = result.claims["pressure"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert "concave kink at r = 300 mm" in claim.reason
    line = ElasticLine(equivalent_profile(profile), 1.0)
    a = float(result["contact_radius"][0])
    delta = np.geomspace(1e-14, 1e-3, 20001)
    total, width = 0.0, 0.0
    for side in (-1.0, 1.0):
        p = line.equivalent.pressure_integral(Place(np.full(delta.size, 0.3), side * delta), a) / math.pi
        tension = np.where(p < 0, -p * 2 * math.pi * (0.3 + side * delta), 0.0)
        total += float(np.trapezoid(tension, delta))
        width += float(delta[p < 0].max())
    fraction = total / float(result["normal_force"][0])
    assert float(claim.error[0]) == pytest.approx(fraction, rel=2e-3)
    assert 0 < width < 1e-3 * a


@pytest.mark.parametrize("A", [3.5, 6.0])
def test_against_boundary_elements_on_rings(A):
    k = 10.0
    h = A / k**2
    profile = mdr.Function(
        lambda r: r * r / 2 + 2 * h * np.sin(k * r / 2) ** 2, derivative=lambda r: r + h * k * np.sin(k * r)
    )
    result = disk_depths(equivalent_profile(profile), 0.5)
    left = holes(result.strict, 0.5)
    assert left
    low, high = left[0]
    for d, is_disk in ((0.8 * low, True), (0.5 * (low + high), False), (min(1.05 * high, 0.5), True)):
        zones = solve_indentation(profile.gap, d, 1.0, max_radius=3.0, n=200).zones
        assert (len(zones) == 1 and zones[0][0] == 0.0) is is_disk


def bump(height, radius=1.5e-4, width=5e-6, R=1e-2):
    bell = lambda r: height * np.exp(-(((r - radius) / width) ** 2))  # noqa: E731
    return mdr.Function(
        lambda r: r * r / (2 * R) + bell(r),
        derivative=lambda r: r / R - 2 * (r - radius) / width**2 * bell(r),
    )


@pytest.mark.parametrize("height", [3e-8, -3e-8])
def test_a_ring_in_the_path_is_refused_under_friction(height):
    steel = mdr.Elastic("210 GPa", 0.3)
    contact = mdr.Contact(bump(height), steel, friction=mdr.Coulomb(0.3))
    with pytest.raises(
        mdr.ProblemError, match="friction needs a contact that is a disk at every depth up to 10 µm"
    ):
        mdr.solve(contact, mdr.indent("10 um") >> mdr.shift("1 um"))
    with pytest.raises(mdr.ProblemError, match="friction needs a contact that is a disk"):
        mdr.friction_loop(contact, ["0.1 um"], indentation="10 um")
    # without memory only the depth itself counts
    result = mdr.solve(mdr.Contact(bump(height), steel), mdr.indent("10 um"))
    assert result.claims["pressure"].level is mdr.Level.EXACT


def dented(jump, radius=0.3):
    return mdr.Function(
        lambda r: r**2 / 2 - jump * np.maximum(r - radius, 0.0),
        derivative=lambda r: r - jump * (r > radius),
        breakpoints=(radius,),
    )


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(st.floats(1e-4, 0.015), st.floats(0.1, 0.9), st.floats(1.1, 30.0), st.floats(0.05, 0.95))
def test_friction_passes_over_a_narrow_ring_as_without_it(jump, radius, beyond, fraction):
    """F_x = mu [F_N(d) - F_N(d - v)] of the frictionless contact, and the springs one by one."""
    tip = dented(jump * radius, radius)
    d, mu = beyond * radius**2, 0.4
    similar = mdr.Elastic(1.0, 0.0)
    joint = mdr.Contact(tip, similar, similar, friction=mdr.Coulomb(mu))
    bare = mdr.Contact(tip, similar, similar)
    v = fraction * d
    # E*/G* is 1 at Poisson's ratio 0
    result = mdr.solve(joint, mdr.indent(d) >> mdr.shift(mu * v))
    depths = np.array([d - v, d])
    alone = mdr.solve(bare, mdr.Path(indentation=depths))
    force = alone["normal_force"].values
    claim, known = result.claims["tangential_force"], alone.claims["normal_force"]
    # where slip ends at the kink, the table of the line is as accurate as the claim says
    at_kink = abs(float(alone["contact_radius"][0]) - radius) < 1e-6 * radius
    expected = pytest.approx(mu * (force[1] - force[0]), rel=float(claim.error[-1]) if at_kink else 1e-11)
    assert float(result["tangential_force"][-1]) == expected
    assert float(result["normal_force"][-1]) == pytest.approx(force[1], rel=1e-12)
    assert claim.level is mdr.Level.APPROXIMATE
    assert "next to the concave kink" in claim.reason
    assert float(claim.error[0]) >= float(known.error[-1]) > 0.0
    assert "next to the concave kink" in known.reason
    turns = np.array([0.0, 0.4, -0.3, 0.2]) * mu * d
    deep = np.array([0.9, 1.0, 1.0, 0.95]) * d
    history = mdr.solve(joint, mdr.Path(indentation=deep, shift=turns))["tangential_force"].values
    springs = friction_foundation(joint, deep, turns, n=4000).tangential_force
    assert np.max(np.abs(history - springs)) < 1e-4 * mu * force[1]


@pytest.mark.xfail(
    reason="where slip ends at the kink itself the force is 1.6e-11 off, within its claim of 3e-9",
    strict=True,
)
def test_friction_whose_slip_ends_at_a_kink_has_all_digits_of_the_frictionless_force():
    tip, similar = dented(0.00390625 * 0.5, 0.5), mdr.Elastic(1.0, 0.0)
    joint = mdr.Contact(tip, similar, similar, friction=mdr.Coulomb(0.4))
    computed = mdr.solve(joint, mdr.indent(0.5) >> mdr.shift(0.4 * 0.25))["tangential_force"].values[-1]
    force = mdr.solve(replace(joint, friction=None), mdr.Path(indentation=[0.25, 0.5]))["normal_force"].values
    assert computed == pytest.approx(0.4 * (force[1] - force[0]), rel=1e-11)


def test_friction_refuses_a_wide_ring_next_to_a_kink():
    joint = mdr.Contact(dented(0.1), UNIT, friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.ProblemError, match="next to the concave kink at 300 mm"):
        mdr.solve(joint, mdr.indent(0.3) >> mdr.shift(0.02))


@pytest.mark.parametrize("L", [1e-9, 1.0, 1e3])
def test_kinked_tips_are_disks(L):
    profile = mdr.Function(
        lambda r: r * r / (2 * L) + 0.1 * np.maximum(r - 0.3 * L, 0) + (r / L) ** 1.5 * L,
        [0.3 * L],
        lambda r: r / L + np.where(r > 0.3 * L, 0.1, 0.0) + 1.5 * np.sqrt(r / L),
    )
    line = ElasticLine(equivalent_profile(profile), 1.0)
    assert certify_disk(line, states_at_depth(line, L * np.linspace(0.0, 2.0, 81))).disk.all()
    assert certify_history(line, 2.0 * L).disk.all()


def test_scales_make_no_difference():
    ranges = []
    for size in (1e-9, 1.0, 1e3):
        profile = mdr.Function(
            lambda r, s=size: s * ((r / s) ** 2 / 2 + 0.12 * np.sin(5 * r / s) ** 2),
            derivative=lambda r, s=size: r / s + 0.6 * np.sin(10 * r / s),
        )
        line = ElasticLine(equivalent_profile(profile), 1.0)
        ranges.append(np.array(valid_ranges(line, 0.5 * size)) / size**2)
    assert ranges[0].shape[0] > 1
    for other in ranges[1:]:
        assert other == pytest.approx(ranges[0], rel=1e-9)


def test_ranges_of_load_end_where_disks_end():
    profile = bump(3e-8)
    line = ElasticLine(equivalent_profile(profile), 1.0)
    (_, end), (begin, _) = disk_depths(line.equivalent, 1e-5).strict
    forces = normal_force(line, states_at_depth(line, np.array([end, begin])))
    ranges = valid_ranges(line, 1e-5)
    assert [ranges[0][1], ranges[1][0]] == pytest.approx(forces.tolist(), rel=1e-12)


def test_noise_of_samples_is_named_with_its_remedy():
    rng = np.random.default_rng(3)
    r = np.linspace(0, 1e-6, 200)
    samples = mdr.Sampled(r, r * r / 2e-6 + 2e-11 * rng.standard_normal(r.size))
    line = equivalent_profile(samples)
    words = noise_remark(samples, line, 5e-8)
    assert "in Python with SmoothingSpline" in words
    assert "decreases by" in words
    assert noise_remark(bump(3e-8), equivalent_profile(bump(3e-8)), 1e-5) == ""
    contact = mdr.Contact(samples, UNIT, friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.ProblemError, match="in Python with SmoothingSpline"):
        mdr.solve(contact, mdr.indent(5e-8) >> mdr.shift(1e-9))


@given(st.integers(0, 2**32 - 1), st.sampled_from([60, 200]), st.floats(-9.0, 0.0))
@settings(max_examples=examples(9), deadline=None)
def test_falls_that_noise_makes_are_said_to_be_of_noise(seed, count, decades):
    size = 10.0**decades
    r = np.linspace(0.0, size, count)
    noise = 3e-5 * size * np.random.default_rng(seed).standard_normal(count)
    samples = mdr.Sampled(r, r * r / (2.0 * size) + noise, interpolation=mdr.CubicSpline())
    words = noise_remark(samples, equivalent_profile(samples), 0.1 * size)
    assert "decreases by" not in words or "can cause: smooth them" in words


def test_adhesive_disks_between_the_steps():
    profile = bump(-3e-8)
    gel = mdr.Contact(profile, mdr.Elastic("210 GPa", 0.3), adhesion=mdr.JKR(work="50 mJ/m^2"))
    claims = mdr.solve(gel, mdr.indent("4 um", steps=8)).claims["normal_force"]
    assert claims.where.all()


def test_an_assessment_has_the_claims_of_the_solution():
    contact = mdr.Contact(bump(-3e-8), mdr.Elastic("210 GPa", 0.3))
    path = mdr.indent("4 um", steps=8)
    study, result = mdr.assess(contact, path), mdr.solve(contact, path)
    assert study.claims.keys() == result.claims.keys()
    for name, claim in result.claims.items():
        assert (study.claims[name].level, study.claims[name].reason) == (claim.level, claim.reason)
        assert study.claims[name].where.tolist() == claim.where.tolist()


@settings(max_examples=examples(6), deadline=None)
@given(
    exponent=st.floats(-120.0, -3.0),
    depth=st.floats(-12.0, 3.0),
    with_derivative=st.booleans(),
)
def test_a_faintly_hollow_tip_is_exact_but_for_fields(exponent, depth, with_derivative):
    d = 10.0**depth
    size = math.sqrt(d)
    slope = 10.0**exponent * size
    profile = mdr.Function(
        lambda r: r * r / 2.0 - slope * r, derivative=(lambda r: r - slope) if with_derivative else None
    )
    result = mdr.solve(mdr.Contact(profile, mdr.Elastic(1.0, 0.0)), mdr.Path(indentation=[0.3 * d, d]))
    # g = x^2 - (pi/2) slope x
    half = math.pi / 4.0 * slope
    a = half + np.sqrt(half**2 + np.array([0.3 * d, d]))
    force = 4.0 * a**3 / 3.0 - 2.0 * half * a**2
    for name, truth in (("contact_radius", a), ("normal_force", force)):
        claim = result.claims[name]
        assert claim.level is mdr.Level.EXACT
        assert np.all(claim.error <= 1e-9)
        assert np.all(np.abs(result[name].values / truth - 1.0) <= 10.0 * claim.error + 1e-14)
    passes = "neglects a ring" in result.claims["contact_radius"].reason
    assert passes or exponent < -6.0
    assert result.claims["pressure"].level is (mdr.Level.APPROXIMATE if passes else mdr.Level.EXACT)
    assert result.claims["indentation"].error.max() == 0.0


def test_fields_keep_their_measured_error_outside_a_ring_that_is_too_narrow_to_count(tmp_path):
    """A hollow tip of which f is given: far inside the contact rounding of f limits the pressure, and the ring at the apex is narrower than an atom."""
    hollow = mdr.Function(lambda r: r**2 / 2.0 - 0.03 * np.exp(-0.5 * ((r - 1.0) / 0.325) ** 2))
    result = mdr.solve(mdr.Contact(hollow, mdr.Elastic(1.0, 0.0)), mdr.indent(0.3))
    claim, force = result.claims["pressure"], result.claims["normal_force"]
    assert "neglects a ring" in claim.reason
    assert claim.level is mdr.Level.APPROXIMATE
    assert force.level is mdr.Level.EXACT
    assert 0.0 < force.error[0] < claim.error[0] < 1e-9
    assert f"error up to {claim.error[0]:.2g} outside the rings next to concave kinks: " in repr(claim)
    assert force.excluded == ""
    words = f"{claim.error[0]:.1e} outside the rings next to concave kinks"
    assert words.replace(" outside", ", outside") in result.summary()
    assert words in result._repr_html_()
    result.to_csv(tmp_path / "hollow.csv", about=True)
    assert words in (tmp_path / "hollow.csv").read_text()
    result.save(tmp_path / "hollow.nc")
    again = mdr.open_result(tmp_path / "hollow.nc").claims["pressure"]
    assert repr(again) == repr(claim)
    assert np.array_equal(again.error, claim.error)
    assert words in {row[3] for row in numbers(result, -1)}
    swept = mdr.sweep(result.contact, mdr.indent(0.3), {"body.young": [1.0]}).claims["pressure"]
    assert swept.excluded == claim.excluded
    assert np.array_equal(swept.error, claim.error)


def test_rings_that_count_make_an_approximation_of_a_known_error():
    profile = mdr.Function(lambda r: r * r / 2.0 - 0.14 * r, derivative=lambda r: r - 0.14)
    result = mdr.solve(mdr.Contact(profile, mdr.Elastic(1.0, 0.0)), mdr.indent(1.0, steps=4))
    for name in ("contact_radius", "normal_force", "elastic_energy", "pressure"):
        claim = result.claims[name]
        assert claim.level is mdr.Level.APPROXIMATE
        assert 1e-9 < claim.error[-1] < claim.error[-2] < 1e-3
    assert result.claims["force_lower_bound"].level is mdr.Level.EXACT
    assert result.claims["indentation"].error.max() == 0.0
