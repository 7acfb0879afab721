"""Rough surfaces on the line: against boundary elements, closed forms, brute force and limits; and what is refused."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import ellipk

import pymdr as mdr
from common import REFERENCES, STEEL, UNIT
from drawing import examples
from pymdr.line.rough import power_law_stiffness, sorted_springs
from pymdr.mapping.patch import full_contact_stiffness
from pymdr.mapping.rough import default_points, rough_heights
from pymdr.solving import rough as solving
from pymdr.solving import rough_lines

PRESSED = {entry["id"]: entry for entry in REFERENCES if entry["id"].startswith("rough_")}
FITTED = {
    entry["id"].replace("lambda", "rough"): entry for entry in REFERENCES if entry["id"].startswith("lambda_")
}
SURFACE = mdr.RoughSurface(hurst=0.7, rms="1 um", size="1 mm", shortest="20 um")


# --- full contact ----------------------------------------------------------------------------------------


def test_the_square_punch():
    assert full_contact_stiffness(1.0, 1.0) == pytest.approx(1.15230, abs=1e-5)
    # the capacity of the unit square, Read (1997)
    assert full_contact_stiffness(3e-9, 3e-9) == pytest.approx(math.pi * 0.36679 * 3e-9, rel=1e-5)


@pytest.mark.parametrize("aspect", [1.0, 1.5, 2.0, 3.0, 4.0])
def test_published_correlations_of_rectangles(aspect):
    computed = full_contact_stiffness(aspect, 1.0) / math.sqrt(aspect)
    # Schneider (1978), spreading resistance of isothermal rectangles: k sqrt(A) R = E* sqrt(A) / (2 k)
    schneider = math.sqrt(aspect) * (0.06588 - 0.00232 * aspect + 0.6786 / (aspect + 0.8145))
    assert 0.5 / computed == pytest.approx(schneider, rel=0.013)
    # Pais and Kausel (1988), rigid footings: K = G B / (1 - nu) (3.1 (L/B)^0.75 + 1.6) with the half width B
    pais_kausel = (3.1 * aspect**0.75 + 1.6) / (4.0 * math.sqrt(aspect))
    assert computed == pytest.approx(pais_kausel, rel=0.025)


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(0.0, 6.0))
def test_rectangles_lie_between_ellipses(octaves):
    """A plate holds more charge than the ellipse in it, and less than the one around it; more than the disk of its area."""
    aspect = math.exp(octaves)

    def ellipse(a, b):  # half axes, a >= b: pi times the capacity a / K
        return math.pi * a / ellipk(1.0 - (b / a) ** 2)

    result = full_contact_stiffness(aspect, 1.0)
    assert ellipse(0.5 * aspect, 0.5) < result < ellipse(aspect / math.sqrt(2), 1 / math.sqrt(2))
    assert result > 2.0 * math.sqrt(aspect / math.pi)
    assert full_contact_stiffness(1.0, aspect) == result
    assert full_contact_stiffness(1e-9 * aspect, 1e-9) == pytest.approx(1e-9 * result, rel=1e-12)


@pytest.mark.parametrize("aspect", [1e3, 1e4, 1e5])
def test_thin_strips(aspect):
    """Slender bodies whose equivalent radius is a quarter of the width of the strip, to the second order."""
    slender = math.log(8.0 * aspect) - 1.0
    limit = 0.5 * math.pi * aspect / slender * (1.0 + (1.0 - math.pi**2 / 12.0) / slender**2)
    assert full_contact_stiffness(aspect, 1.0) == pytest.approx(limit, rel=0.15 / slender**2)


@pytest.mark.parametrize(
    ("sides", "words"),
    [
        ((0.0, 1.0), "both must be above 0 m"),
        ((1.0, -1.0), "both must be above 0 m"),
        ((math.nan, 1.0), "not finite"),
        ((1.0, math.inf), "not finite"),
        (("1 N", 1.0), "does not fit"),
        ((1e-300, 1e300), "at most"),
    ],
)
def test_no_rectangle(sides, words):
    with pytest.raises(mdr.PymdrError, match=words):
        full_contact_stiffness(*sides)


# --- the surface -----------------------------------------------------------------------------------------

SURFACES = st.builds(
    lambda hurst, size, rms, waves, roll: mdr.RoughSurface(
        hurst, rms * size, size, size / waves, None if roll is None else size / waves**roll
    ),
    st.floats(0.01, 1.0),
    st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    st.floats(1e-6, 1e-2),
    st.floats(1.5, 1e4),
    st.none() | st.floats(0.05, 0.9),
)


@settings(max_examples=examples(60), deadline=None)
@given(SURFACES)
def test_moments_of_the_spectrum(surface):
    low, roll, high = (math.log(q) for q in surface.wave_numbers)

    def moment(power):
        def integrand(t):
            return 2.0 * math.pi * surface.spectrum_2d(math.exp(t)).item() * math.exp((power + 1) * t)

        return sum(quad(integrand, a, b, epsabs=0.0)[0] for a, b in ((low, roll), (roll, high)) if b > a)

    assert math.sqrt(moment(1)) == pytest.approx(surface.rms, rel=1e-7)
    assert math.sqrt(moment(3)) == pytest.approx(surface.rms_slope, rel=1e-7)
    q = np.geomspace(*surface.wave_numbers[::2], 20)
    assert surface.spectrum_1d(q) == pytest.approx(math.pi * q * surface.spectrum_2d(q))
    # of Geike's line the slope has the variance of the whole gradient: 2 int C1D q^2 dq
    line = 2.0 * sum(
        quad(lambda t: surface.spectrum_1d(math.exp(t)).item() * math.exp(3 * t), a, b, epsabs=0.0)[0]
        for a, b in ((low, roll), (roll, high))
        if b > a
    )
    assert math.sqrt(line) == pytest.approx(surface.rms_slope, rel=1e-7)


def test_a_surface_is_a_value():
    same = mdr.RoughSurface(0.7, 1e-6, [1e-3, 1e-3], 2e-5)
    assert same == SURFACE
    assert hash(same) == hash(SURFACE)
    assert pickle.loads(pickle.dumps(SURFACE)) == SURFACE
    assert mdr.RoughSurface(0.7, 1e-6, 1e-3, 2e-5, seed=1) != SURFACE
    assert not SURFACE.size.flags.writeable
    assert "RoughSurface" in SURFACE._repr_html_()
    assert not mdr.RoughSurface(0.7, 1e-6, 1e-3, 2e-5, longest=2e-3).has_roll_off
    assert mdr.RoughSurface(0.7, 1e-6, 1e-3, 2e-5, longest=1e-4).has_roll_off


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"hurst": 0.0}, "above 0 and at most 1"),
        ({"hurst": 1.01}, "above 0 and at most 1"),
        ({"hurst": -0.5}, "above 0 and at most 1"),
        ({"hurst": math.nan}, "hurst"),
        ({"rms": 0.0}, "above 0 m"),
        ({"size": 0.0}, "pair of sides"),
        ({"size": ["1 mm", "-1 mm"]}, "pair of sides"),
        ({"size": ["1 mm", "1 mm", "1 mm"]}, "pair of sides"),
        ({"size": "1 kg"}, "kg"),
        ({"size": 1e70}, "1e\\+60"),
        ({"shortest": "1 mm"}, "below the longest wavelength, 1 mm"),
        ({"shortest": "2 mm"}, "below the longest wavelength, 1 mm"),
        ({"size": ["1 mm", "10 um"]}, "below the shorter side, 10 µm"),
        ({"longest": "10 um"}, "below the longest wavelength, 10 µm"),
        ({"longest": 0.0}, "above 0 m"),
        ({"seed": -1}, "whole number of at least 0"),
        ({"seed": 1.5}, "whole number of at least 0"),
        ({"seed": True}, "whole number of at least 0"),
    ],
)
def test_no_surface(changed, words):
    arguments = {"hurst": 0.7, "rms": "1 um", "size": "1 mm", "shortest": "20 um"}
    with pytest.raises((mdr.ProblemError, mdr.UnitError), match=words):
        mdr.RoughSurface(**{**arguments, **changed})


# --- the line --------------------------------------------------------------------------------------------


@settings(max_examples=examples(30), deadline=None)
@given(SURFACES.filter(lambda s: s.size[0] / s.shortest < 500), st.integers(0, 99), st.floats(0.1, 30.0))
def test_heights_have_the_spectrum(surface, realisation, factor):
    n = default_points(surface)
    heights = rough_heights(surface, realisation, n, factor)
    assert np.sqrt(np.mean(heights**2)) == pytest.approx(surface.rms * math.sqrt(factor / math.pi), rel=1e-12)
    assert abs(heights.mean()) < 1e-12 * surface.rms
    power = np.abs(np.fft.rfft(heights)) ** 2
    waves = math.floor(surface.longer_side / surface.shortest * (1 + 1e-12))
    assert power[waves + 1 :].sum() < 1e-20 * power.sum()
    wanted = surface.spectrum_1d(2.0 * math.pi / surface.longer_side * np.arange(1, waves + 1))
    assert power[1 : waves + 1] / power.sum() == pytest.approx(wanted / wanted.sum(), rel=1e-6)
    # neither the number of points nor lambda changes the phases
    finer = rough_heights(surface, realisation, 3 * n)[::3] * math.sqrt(factor / math.pi)
    assert finer == pytest.approx(heights, abs=1e-10 * surface.rms)


def test_lines_differ_by_seed_and_realisation():
    lines = [
        rough_heights(mdr.RoughSurface(0.7, 1e-6, 1e-3, 2e-5, seed=seed), realisation)
        for seed in (0, 1)
        for realisation in (0, 1)
    ]
    for i, one in enumerate(lines):
        for other in lines[:i]:
            assert abs(np.corrcoef(one, other)[0, 1]) < 0.9


HEIGHTS = st.lists(st.integers(-1000, 1000), min_size=1, max_size=60).map(lambda z: np.array(z) / 16.0)


@settings(max_examples=examples(200), deadline=None)
@given(HEIGHTS, st.lists(st.integers(0, 4000), min_size=1, max_size=20))
def test_springs_by_brute_force(heights, depths):
    """Heights and depths of few binary digits: sums are exact, and must be equal."""
    springs = sorted_springs(heights, 0.5)
    d = np.array(depths) / 32.0
    pressed = np.maximum(d[:, None] - (heights.max() - heights), 0.0)
    assert springs.force(d).tolist() == (0.5 * pressed.sum(axis=1)).tolist()
    assert springs.energy(d).tolist() == (0.25 * (pressed**2).sum(axis=1)).tolist()
    met = (d[:, None] >= heights.max() - heights).sum(axis=1)
    assert springs.normal_stiffness(d).tolist() == (0.5 * met).tolist()
    assert springs.indentation(springs.force(d)) == pytest.approx(d, rel=1e-14)
    assert springs.force(-1.0) == springs.energy(-1.0) == springs.normal_stiffness(-1.0) == 0.0


@settings(max_examples=examples(50), deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 70_000),
    st.floats(-12.0, 12.0),
    st.sampled_from([0.0, 1.0, 1e6]),
)
def test_sums_do_not_cancel(seed, n, scale, decades):
    """One spring far above all others, beyond the length of a block: relative to what they carry, nothing is lost."""
    rng = np.random.default_rng(seed)
    depths = np.sort(rng.random(n))
    depths[0] = -decades
    depths = (depths - depths[0]) * 10.0**scale
    springs = sorted_springs(-depths, 1.0)
    at = depths[-1] + rng.random() * 10.0**scale
    exact = np.maximum(at - springs.depths, 0.0)
    assert springs.force(at) == pytest.approx(math.fsum(exact), rel=1e-11)
    assert springs.energy(at) == pytest.approx(0.5 * math.fsum(exact**2), rel=1e-11)
    assert springs.indentation(springs.force(at)) == pytest.approx(at, rel=1e-11)


def test_force_is_convex_and_straight_between_springs():
    springs = sorted_springs(rough_heights(SURFACE), 3.0)
    slope = np.diff(springs.forces) / np.diff(springs.depths)
    assert slope == pytest.approx(3.0 * np.arange(1, springs.depths.size), rel=1e-6)
    middle = 0.5 * (springs.depths[1:] + springs.depths[:-1])
    assert springs.force(middle) == pytest.approx(0.5 * (springs.forces[1:] + springs.forces[:-1]), rel=1e-10)


# --- against boundary elements ---------------------------------------------------------------------------


def patch_of(entry):
    cells = int(entry["id"][-3:])
    return mdr.RoughSurface(entry["inputs"]["H"], 1.0, 1.0, 4.0 / cells)


def in_range(stiffness):
    fraction = stiffness / full_contact_stiffness(1.0, 1.0)
    return (fraction > 0.03) & (fraction < 0.85)


@pytest.mark.parametrize("name", PRESSED)
def test_geikes_line_against_boundary_elements(name):
    """lambda = pi without any fit, within the ranges that the claim tells and the statistics of the references."""
    entry = PRESSED[name]
    force, stiffness = (np.array(entry["expected"][key]) for key in ("F", "k"))
    result = mdr.press_rough(patch_of(entry), UNIT, normal_force=force, realisations=300)
    ratio = (result["normal_stiffness"].values / stiffness)[in_range(stiffness)]
    low, high = (0.89, 1.22) if name.endswith("256") else (0.98, 1.44)
    slack = entry["rtol"]
    assert np.all((ratio > low * (1 - slack)) & (ratio < high * (1 + slack)))
    assert "-11 to +22 %" in result.claims["normal_stiffness"].reason
    assert "-2 to +44 %" in result.claims["normal_stiffness"].reason
    depth = result["indentation"].values / np.array(entry["inputs"]["D_over_h"])
    low, high = (0.90, 1.12) if name.endswith("256") else (0.82, 1.0)
    assert np.all((depth > low * (1 - slack)) & (depth < high * (1 + slack)))


@pytest.mark.parametrize("name", FITTED)
def test_the_height_that_reproduces_boundary_elements(name):
    """h1/h of the line whose k(F) is that of the patch: rms heights only rescale forces, k1(F) = k(F h/h1)."""
    entry, pressed = FITTED[name], PRESSED[name]["expected"]
    force, stiffness = np.array(pressed["F"]), np.array(pressed["k"])
    grid = np.geomspace(0.3 * force[0], 3.0 * force[-1], 120)
    result = mdr.press_rough(patch_of(PRESSED[name]), UNIT, normal_force=grid, realisations=300)
    known = in_range(stiffness)
    curve = np.log(result["normal_stiffness"].values)

    def misfit(log_height):
        line = np.interp(np.log(force) - log_height, np.log(grid), curve)
        return float(np.sqrt(np.mean((line - np.log(stiffness))[known] ** 2)))

    best = minimize_scalar(misfit, bounds=(-0.8, 0.8), method="bounded")
    assert math.exp(best.x) == pytest.approx(entry["expected"]["h1_over_h"], rel=entry["rtol"])
    assert best.fun == pytest.approx(entry["expected"]["rms_log_misfit"], abs=0.03)
    # lambda is the square of the height, times pi
    factor = math.pi * math.exp(2.0 * best.x)
    scaled = mdr.press_rough(
        patch_of(PRESSED[name]), UNIT, normal_force=force, realisations=300, coefficient=factor
    )
    ratio = np.log(scaled["normal_stiffness"].values / stiffness)[known]
    assert np.sqrt(np.mean(ratio**2)) == pytest.approx(best.fun, abs=0.01)


@pytest.mark.parametrize("name", PRESSED)
def test_the_power_law_against_boundary_elements(name):
    entry = PRESSED[name]
    force, stiffness = (np.array(entry["expected"][key]) for key in ("F", "k"))
    hurst = entry["inputs"]["H"]
    result = mdr.press_rough(patch_of(entry), UNIT, normal_force=force, realisations=100)
    published, fitted = (result[law].values for law in ("power_law_stiffness", "fitted_stiffness"))
    fraction = result["normal_stiffness"].values
    assert np.array_equal(np.isfinite(published), fraction < 0.55)
    assert np.array_equal(np.isfinite(fitted), (fraction > 0.12) & (fraction < 0.7))
    by_hand = 1.9412 / (hurst + 1.0) * force ** (1.0 / (1.0 + hurst))
    assert published[fraction < 0.55] == pytest.approx(by_hand[fraction < 0.55])
    low, high = (0.75, 1.25) if name.endswith("256") else (0.87, 1.7)
    few = (stiffness < 0.15) & (stiffness > 0.03)
    assert np.all((published / stiffness)[few] < high * 1.1)
    assert np.all((published / stiffness)[few] > low * 0.9)
    more = (stiffness > 0.15) & (fraction < 0.55)
    assert np.all((published / stiffness)[more] < 1.65 * 1.1)
    if hurst >= 0.4:
        ratio = (fitted / stiffness)[np.isfinite(fitted)]
        assert np.all((ratio > 0.84) & (ratio < 1.22))


@pytest.mark.parametrize("hurst", [0.3, 0.6, 0.9, 1.0])
def test_the_exponent_of_many_decades(hurst):
    surface = mdr.RoughSurface(hurst, 1.0, 1.0, 2.0**-13)
    full = full_contact_stiffness(1.0, 1.0)
    force = np.geomspace(1e-6, 0.2, 40)
    result = mdr.press_rough(surface, UNIT, normal_force=force, realisations=100, points=4 * 2**13)
    fraction = result["normal_stiffness"].values / full
    some = (fraction > 2e-3) & (fraction < 5e-2)
    slope = np.polyfit(np.log(force[some]), np.log(fraction[some]), 1)[0]
    assert slope == pytest.approx(1.0 / (1.0 + hurst), rel=0.05)


# --- the study -------------------------------------------------------------------------------------------


def test_full_contact():
    result = mdr.press_rough(SURFACE, STEEL, indentation="30 um", realisations=5)
    full = result.data.attrs["full_contact_stiffness"]
    modulus = mdr.effective_moduli(STEEL, mdr.Rigid()).normal
    assert full == pytest.approx(1.15230 * modulus * 1e-3, rel=1e-5)
    assert result["normal_stiffness"].item() == pytest.approx(full, rel=1e-12)
    # the plane is as deep as the mean height, and all springs bear it
    tops = [rough_heights(SURFACE, i).max() for i in range(5)]
    forces = [full * (30e-6 - top) for top in tops]
    assert result["normal_force"].item() == pytest.approx(math.exp(np.mean(np.log(forces))), rel=1e-12)


def test_both_loads_are_one_curve():
    by_depth = mdr.press_rough(SURFACE, STEEL, indentation=["0.2 um", "1 um", "3 um"], realisations=1)
    by_force = mdr.press_rough(SURFACE, STEEL, normal_force=by_depth["normal_force"].values, realisations=1)
    assert by_force["indentation"].values == pytest.approx(by_depth["indentation"].values, rel=1e-12)
    for name in ("normal_stiffness", "elastic_energy"):
        assert by_force[name].values == pytest.approx(by_depth[name].values, rel=1e-9)
    springs = by_depth.line.springs(0)
    assert by_depth["normal_force"].values == pytest.approx(springs.force([2e-7, 1e-6, 3e-6]))


def test_bands():
    result = mdr.press_rough(SURFACE, STEEL, normal_force=["0.1 N", "10 N"], realisations=60)
    stiffness = np.array(
        [
            result.line.springs(i).normal_stiffness(result.line.springs(i).indentation([0.1, 10.0]))
            for i in range(60)
        ]
    )
    assert result["normal_stiffness"].values == pytest.approx(np.exp(np.log(stiffness).mean(axis=0)))
    assert result["normal_stiffness_low"].values == pytest.approx(np.percentile(stiffness, 16, axis=0))
    assert result["normal_stiffness_high"].values == pytest.approx(np.percentile(stiffness, 84, axis=0))


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(-9.0, 0.0), st.floats(-3.0, 3.0), st.floats(0.05, 1.0))
def test_nanometres_and_metres_behave_alike(scale, stiffer, hurst):
    def pressed(length, modulus):
        surface = mdr.RoughSurface(hurst, 1e-3 * length, length, length / 40, seed=2)
        forces = modulus * length * 1e-3 * length * np.array([1e-3, 0.1, 1.0])
        result = mdr.press_rough(surface, mdr.Elastic(modulus, 0.0), normal_force=forces, realisations=3)
        return (
            result["normal_stiffness"].values / (modulus * length),
            result["indentation"].values / length,
            result["elastic_energy"].values / (modulus * length**3),
        )

    for one, other in zip(pressed(1.0, 1e9), pressed(10.0**scale, 1e9 * 10.0**stiffer), strict=True):
        assert one == pytest.approx(other, rel=1e-9)


@settings(max_examples=8, deadline=None)
@given(st.integers(1, 12), st.integers(2, 6), st.integers(0, 10**6))
def test_workers_do_not_change_numbers(realisations, workers, seed):
    surface = mdr.RoughSurface(0.6, 1e-6, 1e-3, 5e-5, seed=seed)
    one, many = (
        mdr.press_rough(surface, STEEL, normal_force=[0.1, 10.0], realisations=realisations, workers=n)
        for n in (1, workers)
    )
    assert one.data.identical(many.data)
    assert one.curves.identical(many.curves)


def test_a_smooth_ball_is_that_of_hertz():
    surface = mdr.RoughSurface(0.7, "1 pm", "1 mm", "20 um")
    result = mdr.press_rough(
        surface, STEEL, normal_force=["10 N", "50 N"], radius="10 mm", realisations=2, points=40_000
    )
    modulus = result.data.attrs["modulus"]
    a = np.cbrt(3.0 * np.array([10.0, 50.0]) * 0.01 / (4.0 * modulus))
    assert result["hertz_stiffness"].values == pytest.approx(2.0 * modulus * a)
    assert result["normal_stiffness"].values == pytest.approx(2.0 * modulus * a, rel=2e-3)
    assert result["indentation"].values == pytest.approx(a**2 / 0.01, rel=1e-3)


def test_a_rough_ball():
    """Softer than Hertz below the crossover, as he has it above; boundary elements: 95 to 100 %, 68 to 88 %."""
    surface = mdr.RoughSurface(0.7, 1e-6, 1e-3, 1e-3 / 64)
    crossover = 4.0 / 3.0 * 1e9 * math.sqrt(1e-2) * 1e-6**1.5
    loads = crossover * np.array([0.05, 0.08, 0.5, 1.0, 4.0])
    result = mdr.press_rough(
        surface, mdr.Elastic(1e9, 0.0), normal_force=loads, radius="10 mm", realisations=200
    )
    assert result.data.attrs["crossover_force"] == pytest.approx(crossover)
    fraction = (result["normal_stiffness"] / result["hertz_stiffness"]).values
    assert fraction == pytest.approx([0.64, 0.69, 0.91, 0.95, 0.97], abs=0.02)
    assert "64 to 69 %" in result.claims["normal_stiffness"].reason
    assert "crossover" in result.claims["normal_stiffness"].reason
    assert "softens the ball" in result.summary()
    with pytest.raises(mdr.NotValidError, match="not for a rough ball"):
        result["power_law_stiffness"]
    with pytest.raises(mdr.PathError, match="end of the line"):
        mdr.press_rough(surface, mdr.Elastic(1e9, 0.0), normal_force="1 kN", radius="10 mm", realisations=2)
    assert result.plot().axes


def test_what_is_not_on_the_line():
    result = mdr.press_rough(SURFACE, STEEL, normal_force="10 N", realisations=3)
    for name in (
        "contact_area",
        "contact_length",
        "contact_radius",
        "pressure",
        "mean_pressure",
        "gap",
        "adhesive_force",
    ):
        with pytest.raises(mdr.NotValidError, match=name):
            result[name]
        assert result.claims[name].level is mdr.Level.NOT_VALID
        assert name not in result.data
    assert "N spots" in result.claims["contact_area"].reason
    assert "JKR" in result.claims["adhesive_force"].reason
    assert result.claims["normal_force"].level is mdr.Level.EXACT
    for name in ("indentation", "normal_stiffness", "elastic_energy"):
        assert result.claims[name].level is mdr.Level.APPROXIMATE
    with pytest.raises(mdr.QuantityError, match="a rough contact has"):
        result["friction"]


@pytest.mark.parametrize(
    ("surface", "words"),
    [
        (mdr.RoughSurface(0.7, 1e-6, 1e-3, 1e-5, longest=2e-4), "roll-off"),
        (mdr.RoughSurface(0.7, 1e-6, [1e-3, 2e-3], 2e-5), "for a square"),
    ],
)
def test_where_there_is_no_power_law(surface, words):
    result = mdr.press_rough(surface, STEEL, normal_force=["1 N", "10 N"], realisations=3)
    for law in ("power_law_stiffness", "fitted_stiffness"):
        with pytest.raises(mdr.NotValidError, match=words):
            result[law]
        assert law not in result.data
    assert "NOT_VALID" in result.summary()
    assert result.plot().axes


def test_no_power_law_near_full_contact():
    result = mdr.press_rough(SURFACE, STEEL, normal_force="1 kN", realisations=3)
    with pytest.raises(mdr.NotValidError, match="not valid above"):
        result["power_law_stiffness"]


def test_the_power_law_integrates():
    """k = dF/dd: F/(L h E*) = [C H d/((H + 1)^2 h)]^((H + 1)/H)."""
    hurst, constant = 0.6, 1.9412
    d = np.linspace(0.5, 1.5, 20_001)
    force = (constant * hurst * d / (hurst + 1.0) ** 2) ** ((hurst + 1.0) / hurst)
    stiffness = power_law_stiffness(force, hurst, 1.0, 1.0, 1.0, constant)
    assert np.gradient(force, d)[1:-1] == pytest.approx(stiffness[1:-1], rel=1e-7)


def test_claims_say_what_was_not_compared():
    def reason(surface, **given):
        result = mdr.press_rough(surface, STEEL, normal_force="1 N", realisations=1, **given)
        return result.claims["normal_stiffness"].reason

    words = {
        "rectangle": "not compared for rectangles",
        "roll": "for a roll-off inside",
        "ball": "on a ball (H = 0.7)",
    }
    rectangle = mdr.RoughSurface(0.7, 1e-6, [1e-3, 2e-3], 2e-5)
    rolled = mdr.RoughSurface(0.7, 1e-6, 1e-3, 1e-5, longest=2e-4)
    for text, expected in (
        (reason(SURFACE), set()),
        (reason(rectangle), {"rectangle"}),
        (reason(rolled), {"roll"}),
        (reason(SURFACE, radius="10 mm"), {"ball"}),
    ):
        assert {key for key, some in words.items() if some in text} == expected
    by_depth = mdr.press_rough(SURFACE, STEEL, indentation="1 um", realisations=1)
    assert "-32 to +57 %" in by_depth.claims["normal_force"].reason
    assert by_depth.claims["indentation"].level is mdr.Level.EXACT


def test_a_rectangle_in_full_contact():
    surface = mdr.RoughSurface(0.7, 1e-6, ["1 mm", "2 mm"], 2e-5)
    result = mdr.press_rough(surface, STEEL, indentation="30 um", realisations=2)
    modulus = mdr.effective_moduli(STEEL, mdr.Rigid()).normal
    full = modulus * full_contact_stiffness(1e-3, 2e-3)
    assert result["normal_stiffness"].values == pytest.approx(full)
    # its longest wave is as long as its longer side
    assert surface.wave_numbers[0] == pytest.approx(2.0 * math.pi / 2e-3)


def test_with_a_roll_off_the_load_is_nearly_in_proportion():
    """F/(k h) of the line, which Persson's law has as one number, from 0.02 to 0.2 of full contact as the claim tells."""
    surface = mdr.RoughSurface(0.8, 1e-6, 1e-3, 1e-3 / 256, longest=1e-3 / 16)
    full = 1e9 * full_contact_stiffness(1e-3, 1e-3)
    force = np.geomspace(2e-3, 0.2, 15) * full * 1e-6
    result = mdr.press_rough(surface, mdr.Elastic(1e9, 0.0), normal_force=force, realisations=60)
    stiffness = result["normal_stiffness"].values
    between = (stiffness > 0.02 * full) & (stiffness < 0.2 * full)
    fraction = (force / (stiffness * 1e-6))[between]
    assert np.all((fraction > 0.25) & (fraction < 0.55))
    assert np.all(np.diff(fraction) > 0.0)
    assert "drifts from 0.3 to 0.5" in result.claims["normal_stiffness"].reason


def test_assumptions_are_measured():
    result = mdr.press_rough(SURFACE, STEEL, normal_force="10 N", realisations=2)
    measured = {one.name: one for one in result.assumptions}
    assert measured["small slope"].measure == SURFACE.rms_slope
    assert measured["small slope"].met
    assert measured["measured bandwidth"].measure == pytest.approx(50.0)
    wide = mdr.RoughSurface(0.7, "10 um", "1 mm", "1 um")
    answer = mdr.press_rough(wide, STEEL, normal_force="10 N", realisations=2)
    assert [one.met for one in answer.assumptions] == [False, False]
    assert "NOT MET" in answer.summary()


def test_reading(tmp_path):
    result = mdr.press_rough(SURFACE, STEEL, STEEL, normal_force=["1 N", "10 N"], realisations=4)
    assert "16th and 84th percentiles" in str(result)
    assert "<table" in result._repr_html_()
    result.to_csv(tmp_path / "rough.csv")
    assert (tmp_path / "rough.csv").read_text().startswith("normal_force [N],indentation [m]")
    figure = result.plot()
    assert len(figure.axes) == 3
    assert "full contact" in " ".join(figure.axes[0].get_legend_handles_labels()[1])
    zinc = mdr.TransverselyIsotropic(
        c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa"
    )
    assert mdr.press_rough(SURFACE, zinc, normal_force="1 N", realisations=1)["indentation"].item() > 0.0


def test_its_force_curve_carries_friction():
    result = mdr.press_rough(SURFACE, STEEL, STEEL, normal_force="10 N", realisations=2)
    curve = result.line.force_curve(1, indentation="3 um")
    path = mdr.indent("2.9 um", steps=30)
    solved = mdr.solve(mdr.Contact(curve, STEEL, STEEL), path)
    exact = result.line.springs(1).force(solved["indentation"].values)
    assert solved["normal_force"].values == pytest.approx(exact, rel=1e-3)
    joint = mdr.Contact(curve, STEEL, STEEL, friction=mdr.Coulomb(0.3))
    slid = mdr.solve(joint, mdr.load("10 N") >> mdr.shift("10 um", steps=5))
    assert slid["tangential_force"].values[-1] == pytest.approx(3.0, rel=1e-9)
    with pytest.raises(mdr.ProblemError, match="above 0 m"):
        result.line.force_curve(1, indentation=0.0)
    with pytest.raises(mdr.ProblemError, match="points = 0"):
        result.line.force_curve(1, indentation="1 um", points=0)
    ball = mdr.rough_line(SURFACE, STEEL, radius="10 mm")
    assert ball.force_curve(indentation="1 um").largest_force == pytest.approx(ball.springs().force(1e-6))
    with pytest.raises(mdr.PathError, match="end of the line"):
        ball.force_curve(indentation="1 mm")
    # the default is the first line
    assert np.array_equal(ball.springs().forces, ball.springs(0).forces)
    assert ball.heights(0) == pytest.approx(rough_heights(SURFACE, 0, ball.points) - ball.places**2 / 10e-3)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"surface": mdr.Sphere(1.0)}, "is not a RoughSurface"),
        ({"body": mdr.Rigid()}, "rigid"),
        ({"body": mdr.Graded(1e9, 0.3, 0.2, 1e-3)}, "a Graded body"),
        ({"body": mdr.Viscoelastic(mdr.Maxwell(1e6, 1.0), 0.5)}, "a Viscoelastic body"),
        ({"normal_force": None}, "exactly one"),
        ({"indentation": "1 um"}, "exactly one"),
        ({"normal_force": [1.0, 0.0]}, "above 0 N"),
        ({"normal_force": None, "indentation": -1.0}, "above 0 m"),
        ({"normal_force": [[1.0]]}, "one row"),
        ({"realisations": 0}, "realisations = 0"),
        ({"realisations": 2.0}, "realisations = 2.0"),
        ({"workers": 0}, "workers = 0"),
        ({"points": 10}, "needs at least 200 points"),
        ({"points": True}, "points = True"),
        ({"coefficient": 0.0}, "coefficient = 0"),
        ({"radius": "-1 mm"}, "radius"),
    ],
)
def test_bad_questions(changed, words):
    arguments = {"surface": SURFACE, "body": STEEL, "normal_force": "1 N", **changed}
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.press_rough(arguments.pop("surface"), arguments.pop("body"), **arguments)


@pytest.mark.filterwarnings("error")
@settings(max_examples=examples(30), deadline=None)
@given(st.sampled_from(["normal_force", "indentation"]), st.floats(-320.0, 300.0))
def test_any_load_gives_numbers_or_is_refused(name, exponent):
    surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="50 um")
    load = 10.0**exponent
    try:
        pressed = mdr.press_rough(surface, mdr.Elastic("210 GPa", 0.3), **{name: load}, realisations=3)
    except mdr.ProblemError as refusal:
        assert f"{name} = " in str(refusal)  # noqa: PT017
        assert not 1e-100 < load < 1e100
        return
    for response in ("normal_force", "indentation", "normal_stiffness", "elastic_energy"):
        assert np.all(np.isfinite(pressed[response].values) & (pressed[response].values > 0.0))


@pytest.mark.parametrize("realisation", [-1, 1.5, "a", True])
def test_realisations_are_numbered_from_nothing(realisation):
    line = mdr.rough_line(
        mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="50 um"), mdr.Elastic("210 GPa", 0.3)
    )
    with pytest.raises(mdr.ProblemError, match="a whole number of at least 0"):
        line.force_curve(realisation, indentation="1 um")


def test_memory_bounds_the_workers(monkeypatch):
    line = mdr.rough_line(SURFACE, STEEL)
    monkeypatch.setattr(solving.os, "cpu_count", lambda: 64)
    each = 7 * 8 * line.points
    for memory, workers in ((math.inf, 64), (20.5 * each, 10), (0.1 * each, 1)):
        monkeypatch.setattr(solving, "memory_of_machine", lambda memory=memory: memory)
        assert solving._most_workers(line) == workers


def test_more_springs_than_memory_are_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(rough_lines, "rough_heights", lambda *_: pytest.fail("work began"))
    huge = mdr.RoughSurface(0.7, "1 nm", "1 m", "1 pm")
    # seven arrays of sixteen numbers for each of 1e12 waves
    with pytest.raises(mdr.ProblemError, match=r"8\.96e\+05 GB \(limit .* GB, the memory of this machine"):
        mdr.press_rough(huge, STEEL, normal_force="1 N", realisations=3, workers=1)
