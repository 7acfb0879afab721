"""Named profiles: their images against quadrature in extended precision, limits, references, files."""

import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import struve

import pymdr as mdr
from common import STEEL, UNIT
from drawing import examples
from pymdr.line.adhesion.closed_forms import rigid_pull
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import Place
from pymdr.problem.codec import PROFILES, decode_case, encode_case
from pymdr.problem.profiles import Sum

FOLDER = Path(__file__).parent / "reference"
MODULUS = 1.0


def reference_module(name):
    known = f"pymdr_reference_{name}"
    if known not in sys.modules:
        spec = importlib.util.spec_from_file_location(known, FOLDER / f"{name}.py")
        sys.modules[known] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[known])
    return sys.modules[known]


quadrature, terms = reference_module("quadrature"), reference_module("random_profiles")
LONG = np.longdouble


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed, dtype=LONG) / np.asarray(exact, dtype=LONG) - 1)))


def of_size(kind, size, a, b):
    """
    A profile of a size, its terms in extended precision, a factor on them, its rim, and the radius up to which it is asked.

    a is a shape (a slope or a ratio of heights), b a ratio of lengths below 1.
    """
    flat, power, quotient = b * size, terms.Power, terms.Quotient
    radius = size / a
    tip = flat / a
    match kind:
        case "truncated_cone":
            return mdr.TruncatedCone(flat, slope=a), [power(a, 1.0, 1.0, flat)], 1.0, flat, size
        case "truncated_paraboloid":
            return mdr.TruncatedParaboloid(radius, flat), [terms.Cut(quotient(radius), flat)], 1.0, flat, size
        case "truncated_sphere":
            flat = 0.8 * flat
            return mdr.TruncatedSphere(size, flat), [terms.Cut(terms.Ball(size), flat)], 1.0, flat, 0.9 * size
        case "rounded_flat":
            return mdr.RoundedFlat(flat, radius), [quotient(radius, flat)], 1.0, flat, size
        case "rounded_cone":
            begins = a * tip
            curve = terms.linear_slopes([0.0, begins], [0.0, a])
            return mdr.RoundedCone(tip, slope=a), [curve], 1.0, begins, size
        case "hyperboloid":
            return mdr.Hyperboloid(tip, slope=a), [terms.Hyperboloid(a, a * tip)], 1.0, None, size
        case "ellipsoid":
            return mdr.Ellipsoid(size, a * size), [terms.Ball(size)], a * size / size, None, 0.8 * size
        case "domed_punch":
            return mdr.DomedPunch(size, radius), [quotient(radius)], 1.0, None, size
        case "concave_punch":
            return mdr.ConcavePunch(size, radius), [quotient(radius)], -1.0, None, size
        case "waviness":
            k = 2.0 * math.pi / (size * b)
            height = 3.0 * b / (k * k * radius)
            profile = mdr.Paraboloid(radius) + mdr.Waviness(height, size * b)
            return profile, [quotient(radius), terms.Wave(height, k)], 1.0, None, size
    raise AssertionError(kind)


KINDS = (
    "truncated_cone",
    "truncated_paraboloid",
    "truncated_sphere",
    "rounded_flat",
    "rounded_cone",
    "hyperboloid",
    "ellipsoid",
    "domed_punch",
    "concave_punch",
    "waviness",
)
ELSEWHERE = {
    "sphere", "sphere_on_sphere", "paraboloid", "cone", "power_law", "flat_punch", "sum", "area_function", "sampled",
    "interpolated", "force_curve", "worn", "elliptic_paraboloid", "pyramid", "sampled_2d",
}  # fmt: skip
"""Kinds that tests of equivalent profiles, curves and shapes compare."""
SIZES = st.floats(-12.0, 6.0).map(lambda decades: 10.0**decades)
SHAPES = st.floats(-5.0, 0.3).map(lambda decades: 10.0**decades)
RATIOS = st.floats(-6.0, math.log10(0.9)).map(lambda decades: 10.0**decades)


def test_every_profile_of_the_package_has_a_case():
    own = {kind for kind, cls in PROFILES.items() if cls.__module__.startswith("pymdr.")}
    assert own == {*KINDS, *ELSEWHERE}


def arguments(kind, rim, top, decades):
    """Places over twelve decades of the size, and of the distance from the rim where there is one."""
    fractions = 10.0 ** np.array(decades)
    if rim is None:
        return np.zeros(fractions.size), top * fractions
    base, offset = np.full(fractions.size, rim), (top - rim) * fractions
    if kind == "rounded_cone":
        base, offset = np.append(base, np.zeros(fractions.size)), np.append(offset, rim * fractions)
    return base, offset


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=8, deadline=None)
@given(SIZES, SHAPES, RATIOS, st.lists(st.floats(-12.0, 0.0), min_size=2, max_size=5))
@example(1e-12, 0.3, 0.5, [-12.0, -6.0, 0.0])
@example(1e6, 1e-5, 1e-6, [-12.0, -3.0, 0.0])
def test_images_against_quadrature(kind, size, a, b, decades):
    profile, parts, factor, rim, top = of_size(kind, size, a, b if kind != "waviness" else max(b, 1e-2))
    base, offset = arguments(kind, rim, top, decades)
    curve = terms.TermCurve(
        parts, 1.01 * top if kind not in ("truncated_sphere", "ellipsoid") else 0.95 * size
    )
    panel, rest = quadrature.place(curve, base, offset)
    exact, drop = quadrature.images(curve, panel, rest), quadrature.squared(curve, panel, rest)
    line, place = equivalent_profile(profile), Place(base, offset)
    assert worst(line.g(place), factor * exact.g) < 1e-12
    # over many waves g' is as good as the map claims, which knows what f' has lost when it is differentiated
    claimed = line.slope_error(base + offset) if kind == "waviness" else 0.0
    misses = abs(line.slope(place) / (factor * exact.slope) - 1)
    assert np.all(misses < 1e-12 + 10.0 * claimed)
    assert worst(line.moment(place), factor * exact.moment) < 1e-12
    assert worst(line.squared(place), factor**2 * drop) < 1e-12


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "concave_punch"])
@settings(max_examples=5, deadline=None)
@given(SIZES, SHAPES, RATIOS, st.lists(st.floats(-12.0, -0.01), min_size=2, max_size=4))
@example(1e-12, 0.3, 0.5, [-12.0, -6.0, -0.01])
def test_forces_and_energies_against_quadrature(kind, size, a, b, decades):
    profile, parts, factor, rim, top = of_size(kind, size, a, b if kind != "waviness" else max(b, 1e-2))
    base, offset = arguments(kind, rim, top, decades)
    curve = terms.TermCurve(
        parts, 1.01 * top if kind not in ("truncated_sphere", "ellipsoid") else 0.95 * size
    )
    # the depths are doubles, and the truth is that of them
    depth = np.asarray(
        factor * quadrature.images(curve, *quadrature.place(curve, base, offset)).g, dtype=float
    )
    panel, rest = quadrature.invert(curve, depth.astype(LONG) / LONG(factor))
    exact, drop = quadrature.images(curve, panel, rest), quadrature.squared(curve, panel, rest)
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.Path(indentation=depth))
    assert result.claims["normal_force"].level is mdr.Level.EXACT
    assert worst(result["contact_radius"], quadrature.radius(curve, panel, rest)) < 1e-12
    assert worst(result["normal_force"], 2 * MODULUS * factor * exact.moment) < 1e-12
    assert worst(result["elastic_energy"], MODULUS * factor**2 * drop) < 1e-12


# --- references and closed forms -------------------------------------------------------------------------

TAN, B = math.tan(0.7), 0.4
REFERENCED = {
    "trunc_cone": mdr.TruncatedCone(B, slope=TAN),
    "rounded_cylinder": mdr.RoundedFlat(B, 1.0),
    "wavy_paraboloid": mdr.Paraboloid(1.0) + mdr.Waviness(0.01, math.pi / 3.0),
}


@pytest.mark.parametrize("name", REFERENCED)
def test_the_references(references, name):
    profile = REFERENCED[name]
    expected, x = references[f"map_{name}"]["expected"], references[f"map_{name}"]["inputs"]["x"]
    line = equivalent_profile(profile)
    assert float(profile.gap(x)) == pytest.approx(expected["f"], rel=1e-12)
    assert float(line.g(x)) == pytest.approx(expected["g"], rel=1e-12)
    assert float(line.slope(x)) == pytest.approx(expected["gprime"], rel=1e-12)
    expected = references[f"normal_{name}"]["expected"]
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(expected["d"]))
    assert float(result["normal_force"][0]) == pytest.approx(expected["F_over_Estar"], rel=1e-10)
    assert float(result["elastic_energy"][0]) == pytest.approx(expected["U_over_Estar"], rel=1e-10)
    pressure = result.field("pressure", r=[0.2, 0.5]).values
    assert worst(pressure, [expected["p02_over_Estar"], expected["p05_over_Estar"]]) < 1e-10


def test_the_hollow_pressed_flat(references):
    expected = references["concave_punch_full"]["expected"]
    contact = mdr.Contact(mdr.ConcavePunch(1.0, 1.0), UNIT)
    flat = mdr.solve(contact, mdr.indent(expected["d"] * (1.0 + 1e-9)))
    assert flat.status is mdr.Status.COMPLETED
    assert float(flat["normal_force"][0]) == pytest.approx(expected["F_over_Estar"], rel=1e-8)
    ring = mdr.solve(contact, mdr.indent(0.9 * expected["d"]))
    with pytest.raises(mdr.NotValidError):
        ring["contact_radius"]


@settings(max_examples=examples(20), deadline=None)
@given(SIZES, st.floats(-6.0, -0.5), st.floats(0.01, 2.9))
def test_waves_against_struve(size, decades, steepness):
    wavelength, radius = size * 10.0**decades, size
    k = 2.0 * math.pi / wavelength
    height = steepness / (k * k * radius)
    line = equivalent_profile(mdr.Paraboloid(radius) + mdr.Waviness(height, wavelength))
    x = wavelength * np.geomspace(1e-3, 3.0, 9)
    assert worst(line.g(x), x * x / radius + 0.5 * math.pi * height * k * x * struve(0, k * x)) < 1e-12


@settings(max_examples=examples(20), deadline=None)
@given(SIZES, st.floats(-13.0, 0.0), st.floats(-2.0, 0.5))
@example(36399730135.84496, -9.358, 0.263)
def test_a_cosine_that_cancels_next_to_a_paraboloid(radius, decades, steepness):
    # 1 - cos(k r) is 0 in doubles where k r is below 1e-8, and f seems to be the paraboloid alone
    k = 2e-5 * 36399730135.84496 / radius
    height = 10.0**steepness / (k * k * radius)
    line = equivalent_profile(mdr.Function(lambda r: r**2 / (2 * radius) + height * (1 - np.cos(k * r))))
    x = 10.0**decades / k
    truth = x * x / radius + 0.5 * math.pi * height * k * x * struve(0, k * x)
    assert abs(float(line.g(x)) / truth - 1.0) <= 10.0 * float(line.error(x)[0]) + 1e-14
    assert float(line.error(x)[0]) < 1e-9


@settings(max_examples=examples(20), deadline=None)
@given(SIZES, st.floats(0.05, 0.6), st.floats(1.1, 3.0))
def test_the_closed_forces_of_worn_profiles(size, b, ratio):
    flat, a = b * size, min(b * ratio, 0.9) * size
    u, c = math.sqrt((a - flat) * (a + flat)), math.sqrt((size - flat) * (size + flat))
    cone = a * a * (math.atan2(u, flat) + flat * u / (a * a))
    paraboloid = 2.0 / (3.0 * size) * (2.0 * a * a + flat * flat) * u
    sphere = (size * size + a * a) * math.atanh(u / c) - u * c
    for profile, force in (
        (mdr.TruncatedCone(flat, slope=1.0), cone),
        (mdr.TruncatedParaboloid(size, flat), paraboloid),
        (mdr.TruncatedSphere(size, flat), sphere),
    ):
        assert 2.0 * float(equivalent_profile(profile).moment(a)) == pytest.approx(force, rel=1e-11)


# --- limits ----------------------------------------------------------------------------------------------


@settings(max_examples=examples(15), deadline=None)
@given(SIZES, SHAPES, st.floats(-12.0, -5.0))
def test_what_is_hardly_worn_or_rounded_is_what_it_was(size, a, decades):
    small = 10.0**decades
    x = size * np.geomspace(1e-2, 0.9, 7)
    # the difference is of second order in b / x for a rim without a step, of first for the cone
    pairs = [
        (mdr.TruncatedSphere(size, small * size), mdr.Sphere(size), (100.0 * small) ** 2),
        (mdr.TruncatedParaboloid(size, small * size), mdr.Paraboloid(size), (100.0 * small) ** 2),
        (mdr.TruncatedCone(small * size, slope=a), mdr.Cone(slope=a), 100.0 * small),
        (mdr.RoundedCone(small * size / a, slope=a), mdr.Cone(slope=a), 100.0 * small),
        (mdr.Hyperboloid(small * size / a, slope=a), mdr.Cone(slope=a), 100.0 * small),
        (mdr.RoundedFlat(small * size, size), mdr.Paraboloid(size), 2.0 * math.pi / 2.0 * 100.0 * small),
    ]
    for blunt, sharp, least in pairs:
        assert worst(equivalent_profile(blunt).g(x), equivalent_profile(sharp).g(x)) < least + 1e-13


def test_a_sharply_rounded_flat_is_the_flat():
    force = [
        float(mdr.solve(mdr.Contact(p, UNIT), mdr.indent(1e-3))["normal_force"][0])
        for p in (mdr.FlatPunch(1.0), mdr.RoundedFlat(1.0, 1e-8))
    ]
    assert force[0] == 2e-3
    assert 0.0 < force[1] / force[0] - 1.0 < 1e-3


def test_an_ellipsoid_with_equal_axes_is_a_sphere_and_a_domed_punch_a_sum():
    path = mdr.indent(0.3, steps=7)
    for one, other in (
        (mdr.Ellipsoid(1.0, 1.0), mdr.Sphere(1.0)),
        (mdr.DomedPunch(0.4, 2.0), mdr.FlatPunch(0.4) + mdr.Paraboloid(2.0)),
    ):
        results, known = (mdr.solve(mdr.Contact(p, UNIT), path) for p in (one, other))
        for name in ("normal_force", "contact_radius", "elastic_energy"):
            assert worst(results[name], known[name]) < 1e-14


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=examples(10), deadline=None)
@given(SIZES, SHAPES, RATIOS, st.floats(-9.0, 0.0))
def test_gaps_are_the_integrals_of_their_slopes(kind, size, a, b, decades):
    profile, _, _, rim, top = of_size(kind, size, a, b if kind != "waviness" else max(b, 1e-2))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    stop = top * 10.0**decades
    parts = [p for p in (rim,) if p is not None and p < stop]
    edges = np.unique(
        [0.0, *(np.array(parts)), *(stop * np.linspace(0, 1, 400)), *(stop * np.geomspace(1e-9, 1, 60))]
    )
    low, high = edges[:-1, None], edges[1:, None]
    r = low + (high - low) * (nodes + 1) / 2
    result = (((high - low) / 2 * weights) * profile.gap_slope(r)).sum()
    assert float(profile.gap(stop)) == pytest.approx(result, rel=1e-9)
    assert float(profile.gap(0.0)) == 0.0


# --- as values, in laws and in files ---------------------------------------------------------------------

NAMED = [of_size(kind, 1e-3, 0.01, 0.3)[0] for kind in KINDS]


def test_sum_adds_profiles():
    parts = [mdr.Paraboloid(1.0), mdr.Waviness(0.01, 1.0), mdr.FlatPunch(2.0)]
    assert sum(parts) == parts[0] + parts[1] + parts[2]
    assert sum(parts[:1]) is parts[0]
    with pytest.raises(TypeError):
        3 + parts[0]


@pytest.mark.parametrize("profile", NAMED, ids=KINDS)
def test_files_hold_named_profiles(profile, tmp_path):
    contact = mdr.Contact(profile, STEEL)
    assert decode_case(encode_case("", contact, mdr.indent("1 um")))[1] == contact
    result = mdr.solve(contact, mdr.indent("1 um", steps=2))
    result.save(tmp_path / "result.nc")
    again = mdr.open_result(tmp_path / "result.nc")
    assert again.contact == contact
    if result.status is mdr.Status.COMPLETED:
        r = [0.0, 1e-4]
        assert np.array_equal(again.field("pressure", r=r), result.field("pressure", r=r))
    assert all(figure.axes for figure in again.figures().values())


@pytest.mark.parametrize(
    ("kind", "cls"), [(k, c) for k, c in PROFILES.items() if k not in ("sum", "interpolated")]
)
def test_every_kind_is_public_and_in_the_pages(kind, cls):
    docs = Path(__file__).parent.parent / "docs"
    assert getattr(mdr, cls.__name__) is cls
    assert f"`{cls.__name__}(" in (docs / "profiles.md").read_text()
    for page in ("profiles.md", "case_files.md"):
        assert f"`{kind}`" in (docs / page).read_text()


@pytest.mark.parametrize("profile", NAMED, ids=KINDS)
def test_the_pull_of_dmt_needs_a_round_tip_or_a_range(profile):
    r = np.array([1e-9, 1e-8])
    curvature = 2.0 * profile.gap(r) / r**2
    is_paraboloid = curvature[0] > 0.0 and math.isclose(*curvature, rel_tol=1e-6)
    round_ = is_paraboloid and profile.edge == math.inf and not isinstance(profile, Sum)
    contact = mdr.Contact(profile, UNIT, adhesion=mdr.DMT("1 mJ/m^2"))
    if not round_:
        with pytest.raises(mdr.ProblemError, match=r"DMT|ring"):
            mdr.solve(contact, mdr.indent("1 nm"))
        return
    force = float(mdr.solve(contact, mdr.indent(0.0))["normal_force"][0])
    assert force == pytest.approx(-2.0 * math.pi / curvature[0] * 1e-3, rel=1e-6)
    assert force == pytest.approx(-2.0 * math.pi * profile.tip_radius * 1e-3, rel=1e-12)


def of_tip(radius):
    """Profiles with a tip of given radius of curvature."""
    return st.one_of(
        st.just(mdr.Sphere(radius)),
        st.just(mdr.Paraboloid(radius)),
        st.floats(0.1, 10.0).map(lambda q: mdr.Ellipsoid(q * radius, q * q * radius)),
        st.floats(0.1, 10.0).map(lambda slope: mdr.RoundedCone(slope=slope, tip_radius=radius)),
        st.floats(0.1, 10.0).map(lambda slope: mdr.Hyperboloid(slope=slope, tip_radius=radius)),
        st.floats(0.1, 10.0).map(lambda q: mdr.PowerLaw(2, 0.5 * q * q * radius, q * radius)),
    )


NOT_ROUND = (
    mdr.Cone(0.1), mdr.PowerLaw(2.1, 1.0, 1.0), mdr.PowerLaw(1.9, 1.0, 1.0), mdr.FlatPunch(1.0),
    mdr.DomedPunch(1.0, dome_radius=9.0), mdr.TruncatedSphere(1.0, 0.5), mdr.Function(lambda r: r**2),
)  # fmt: skip


@settings(max_examples=examples(40), deadline=None)
@given(st.lists(st.floats(-9.0, 3.0).flatmap(lambda e: of_tip(10.0**e)), min_size=1, max_size=3))
def test_a_round_tip_has_the_curvature_of_its_gap(parts):
    profile = sum(parts)
    r = 1e-6 * min(part.tip_radius for part in parts)
    assert profile.tip_radius == pytest.approx(r * r / (2.0 * float(profile.gap(r))), rel=1e-9)
    assert profile.tip_radius == pytest.approx(profile.curvature_radius, rel=1e-15)
    line = equivalent_profile(profile)
    assert profile.tip_radius == pytest.approx(r * (r / float(line.g(r))), rel=1e-9)
    for other in NOT_ROUND:
        assert other.tip_radius is None
        assert (profile + other).tip_radius is None


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "concave_punch"])
@settings(max_examples=examples(12), deadline=None)
@given(SIZES, st.floats(-4.0, 0.0), st.floats(-4.0, -0.1), st.floats(-6.0, -0.1))
@example(1e-2, -1.0, math.log10(0.3), -2.0)
def test_the_rigid_pull_of_a_range_ends_where_the_gap_is_the_range(kind, size, a, b, decades):
    profile, _, _, rim, top = of_size(kind, size, 10.0**a, 10.0 ** max(b, -1.5))
    reached = (rim or 0.0) + (top - (rim or 0.0)) * 10.0**decades
    height = float(profile.gap(reached))
    strength = 1.0
    pull = rigid_pull(equivalent_profile(profile), work=strength * height, strength=strength)
    radius = math.sqrt(pull / (math.pi * strength))
    # a radius beside the rim has no more digits than its float
    bend = 1.0 + radius * float(profile.gap_slope(reached)) / height
    assert float(profile.gap(radius)) == pytest.approx(height, rel=1e-13 * bend + 1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: mdr.TruncatedCone("1 um"),
            r"^slope = None, half_angle = None: give exactly one",
        ),
        (lambda: mdr.RoundedCone("1 um", slope=1.0, half_angle=1.0), r"^slope = 1.0.*exactly one"),
        (
            lambda: mdr.Hyperboloid("-1 nm", slope=1.0),
            r"^tip_radius = '-1 nm': it must be above 0 m",
        ),
        (lambda: mdr.TruncatedSphere("1 mm", "1 mm"), r"^flat_radius = 1 mm: .*below 0\.999"),
        (lambda: mdr.TruncatedParaboloid(1.0, 0.0), r"^flat_radius = 0.*above 0 m"),
        (lambda: mdr.RoundedFlat(1.0, math.nan), "^edge_radius: nan is not finite"),
        (lambda: mdr.Ellipsoid(1.0, "1 N"), r"^height"),
        (lambda: mdr.DomedPunch(1.0, 0.0), r"^dome_radius = 0"),
        (lambda: mdr.ConcavePunch(1.0, -1.0), r"^hollow_radius = -1"),
        (lambda: mdr.Waviness("1 nm", 0.0), r"^wavelength = 0"),
    ],
)
def test_limits(make, words):
    with pytest.raises(mdr.PymdrError, match=words):
        make()


def test_an_ellipsoid_is_not_pressed_in_by_its_height():
    with pytest.raises(mdr.PathError, match="an ellipsoid cannot be pressed in by its semi-axis, 100 mm"):
        mdr.solve(mdr.Contact(mdr.Ellipsoid(1.0, 0.1), UNIT), mdr.indent(0.1))


def test_a_formula_in_a_case_is_refused_with_the_remedy():
    case = {"profile": {"kind": "function", "f": "r**4"}, "body": {"kind": "rigid"}, "path": []}
    with pytest.raises(
        mdr.CaseError, match=r"kind = 'function': cases cannot contain formulas.*'sampled'.*Python script"
    ):
        decode_case(case)
