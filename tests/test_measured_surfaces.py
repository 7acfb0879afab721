"""Measured surfaces: trends, gaps, tips, spectra of known surfaces, bumps against Hertz; and what is refused."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import GLASS
from drawing import examples
from pymdr.mapping.surfaces.spectrum import rings_of


def coordinates(nx, ny, spacing=1.0):
    return np.meshgrid(*((np.arange(n) + 0.5) * spacing for n in (nx, ny)), indexing="ij")


def random_surface(rng, n, hurst, roll_off=None, shortest=4.0):
    """Gaussian heights on n x n pixels of width 1 that repeat themselves; wavelengths in pixels."""
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(n), np.fft.fftfreq(n)))
    low = 0.0 if roll_off is None else 1.0 / roll_off
    with np.errstate(divide="ignore"):
        root = np.maximum(q, low) ** -(1.0 + hurst)
    root[(q == 0.0) | (q > 1.0 / shortest)] = 0.0
    return np.fft.ifft2(np.fft.fft2(rng.standard_normal((n, n))) * root).real


# --- trends ----------------------------------------------------------------------------------------------

COEFFICIENTS = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)


@settings(max_examples=examples(40), deadline=None)
@given(COEFFICIENTS, st.integers(3, 12), st.integers(3, 12), st.floats(-9.0, 0.0), st.floats(-3.0, 6.0))
def test_a_trend_is_gone_and_nothing_else(coefficients, nx, ny, log_size, log_offset):
    size = 10.0**log_size
    x, y = coordinates(nx, ny, 1.0 / max(nx, ny))
    c = coefficients
    parts = {
        "mean": c[0] + 0.0 * x,
        "plane": c[0] + c[1] * x + c[2] * y,
        "sphere": c[0] + c[1] * x + c[2] * y + c[3] * (x * x + y * y),
        "curvature": c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y,
    }
    rest = size * np.random.default_rng(0).standard_normal((nx, ny))
    gap = np.zeros((nx, ny), dtype=bool)
    gap[0, 0] = True
    # the size of a pixel, not that of the offset, says how close it must come
    noise = 1e-13 * 10.0**log_offset * size + 1e-11 * size
    for trend, part in parts.items():
        sides = [size * nx / max(nx, ny), size * ny / max(nx, ny)]
        bare, bent = (
            mdr.Topography(np.where(gap, np.nan, z), sides).detrend(trend).heights
            for z in (rest, rest + size * part + 10.0**log_offset * size)
        )
        assert bent == pytest.approx(bare, abs=noise, nan_ok=True)
        # what is left is orthogonal to what was taken
        assert abs(np.nanmean(bare)) < 1e-13 * size
        again = mdr.Topography(bare, sides).detrend(trend).heights
        assert again == pytest.approx(bare, abs=1e-12 * size, nan_ok=True)


def test_a_trend_is_reported():
    x, y = coordinates(20, 30, 1e-6)
    ball = mdr.Topography(0.01 * x - (x**2 + y**2) / 4e-3, ["20 um", "30 um"]).detrend("sphere")
    assert "a cap of radius 2 mm" in ball.steps[0]
    tube = mdr.Topography(x**2 / 4e-3, ["20 um", "30 um"]).detrend("curvature")
    assert "a bowl of radius 2 mm" in tube.steps[0]
    both = tube.detrend("plane").detrend("mean")
    assert len(both.steps) == 3
    assert pickle.loads(pickle.dumps(both)) == both


@pytest.mark.parametrize(
    ("heights", "trend", "words"),
    [
        (np.ones((4, 4)), "cubic", "one of mean, plane, sphere, curvature"),
        (np.where(np.arange(16).reshape(4, 4) < 1, 1.0, np.nan), "plane", "do not determine a"),
        (np.where(np.arange(16).reshape(4, 4) < 4, 1.0, np.nan), "plane", "do not determine a"),
        (np.ones((2, 2)), "curvature", "do not determine a"),
    ],
)
def test_trends_that_cannot_be_taken_off(heights, trend, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.Topography(heights, 1.0).detrend(trend)


# --- what is missing -------------------------------------------------------------------------------------

MASKS = st.tuples(st.integers(2, 9), st.integers(2, 9), st.floats(0.0, 0.45), st.integers(0, 999))


@settings(max_examples=examples(40), deadline=None)
@given(MASKS)
def test_gaps_are_continued(mask):
    nx, ny, fraction, seed = mask
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal((nx, ny))
    gap = rng.random((nx, ny)) < fraction
    gap[0, 0] = False
    if 2 * gap.sum() > gap.size:
        return
    surface = mdr.Topography(np.where(gap, np.nan, heights), [1.0, 2.0])
    filled = surface.fill_missing("interpolate")
    assert np.array_equal(filled.heights[~gap], heights[~gap])
    # the maximum principle
    low, high = heights[~gap].min(), heights[~gap].max()
    assert np.all((filled.heights >= low - 1e-9) & (filled.heights <= high + 1e-9))
    # every filled height is the mean of its neighbours, weighted by their distances
    weights = surface.spacing**-2.0
    for i, j in zip(*np.nonzero(gap), strict=True):
        near = [(i + a, j + b, weights[0 if a else 1]) for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        near = [(filled.heights[k, m], w) for k, m, w in near if 0 <= k < nx and 0 <= m < ny]
        mean = sum(z * w for z, w in near) / sum(w for _, w in near)
        assert filled.heights[i, j] == pytest.approx(mean, abs=1e-9)
    assert filled.fill_missing("interpolate") is filled


@settings(max_examples=examples(40), deadline=None)
@given(MASKS)
def test_the_largest_rectangle(mask):
    nx, ny, fraction, seed = mask
    rng = np.random.default_rng(seed)
    gap = rng.random((nx, ny)) < fraction
    gap[0, 0] = not gap.any() or gap[0, 0]
    heights = np.where(gap, np.nan, np.arange(nx * ny, dtype=float).reshape(nx, ny))
    sizes = [
        (b - a) * (d - c)
        for a in range(nx)
        for b in range(a + 1, nx + 1)
        for c in range(ny)
        for d in range(c + 1, ny + 1)
        if not gap[a:b, c:d].any()
    ]
    if gap.all():
        return
    surface = mdr.Topography(heights, [nx, ny])
    try:
        part = surface.fill_missing("crop")
    except mdr.ProblemError:
        with pytest.raises(mdr.ProblemError, match="no complete rectangle of 2 x 2"):
            surface.fill_missing("crop")
        return
    assert part.heights.size == max(sizes)
    assert part.size == pytest.approx(part.heights.shape, rel=1e-12)
    first = int(part.heights[0, 0])
    assert np.array_equal(
        part.heights,
        heights[first // ny :, first % ny :][: part.heights.shape[0], : part.heights.shape[1]],
    )


def test_gaps_are_refused_unless_something_is_said():
    heights = np.add.outer(np.arange(64.0), np.arange(64.0))
    heights[10:20, 10:20] = np.nan
    surface = mdr.Topography(heights, 1.0)
    for ask in (mdr.power_spectrum, mdr.azimuthal_profile, lambda one: one.tip_cutoff(1.0)):
        with pytest.raises(mdr.ProblemError, match="100 of 4096 heights are missing; fill them with"):
            ask(surface)
    with pytest.raises(mdr.ProblemError, match="one of interpolate, crop"):
        surface.fill_missing("guess")
    heights[:, :40] = np.nan
    with pytest.raises(mdr.ProblemError, match="more than half"):
        mdr.Topography(heights, 1.0).fill_missing("interpolate")
    assert mdr.Topography(heights, 1.0).fill_missing("crop").heights.shape == (64, 24)


# --- the tip ---------------------------------------------------------------------------------------------


def dilated(heights, radius, radius_in_pixels):
    """What a ball of a radius touches when it is led over a surface of pixels of width 1."""
    n = heights.shape[0]
    result = np.full_like(heights, -np.inf)
    for i in range(-radius_in_pixels, radius_in_pixels + 1):
        for j in range(-radius_in_pixels, radius_in_pixels + 1):
            drop = -(i * i + j * j) / (2.0 * radius)
            rolled = heights[max(i, 0) : n + min(i, 0), max(j, 0) : n + min(j, 0)] + drop
            into = result[max(-i, 0) : n + min(-i, 0), max(-j, 0) : n + min(-j, 0)]
            np.maximum(into, rolled, out=into)
    return result


def test_a_blunt_tip_is_noticed():
    surface = random_surface(np.random.default_rng(2), 96, 0.5, shortest=2.5)
    surface *= 2.0 / surface.std()
    seen = mdr.Topography(dilated(surface, 10.0, 12)[12:-12, 12:-12], 72.0)
    true = mdr.Topography(surface[12:-12, 12:-12], 72.0)
    # no summit of what it saw is sharper than it, and it is told by that
    assert 4.0 <= seen.tip_cutoff(10.0) < 30.0
    assert true.tip_cutoff(10.0) > seen.tip_cutoff(10.0)
    assert seen.tip_cutoff(0.001) == 2.0
    assert seen.tip_cutoff(5.0) <= seen.tip_cutoff(10.0)
    with pytest.raises(mdr.ProblemError, match="resolves no wave"):
        seen.tip_cutoff(1e6)
    with pytest.raises(mdr.ProblemError, match="above 0 m"):
        seen.tip_cutoff(0.0)
    spectrum = mdr.power_spectrum(seen, tip_radius=10.0)
    assert spectrum.data.attrs["shortest_resolved"] == max(4.0, seen.tip_cutoff(10.0))
    known = np.isfinite(spectrum["power_spectrum"].values)
    assert np.all(spectrum["wavelength"].values[known] >= spectrum.data.attrs["shortest_resolved"])


def test_the_tip_as_another_package_has_it():
    other = pytest.importorskip(
        "SurfaceTopography", reason="SurfaceTopography, of the extra topography, is not installed"
    )
    heights = random_surface(np.random.default_rng(5), 128, 0.6, shortest=3.0)
    heights[:, 1:] = heights[:, :1]  # along x alone, as it looks at
    heights /= heights.std()
    theirs = other.Topography(heights, (128.0, 128.0))
    for radius in (0.3, 1.0, 3.0, 10.0):
        result = theirs.scanning_probe_reliability_cutoff(radius)
        ours = mdr.Topography(heights, 128.0).tip_cutoff(radius)
        assert ours == pytest.approx(result or 2.0, abs=2.0 + 0.15 * (result or 2.0))


# --- the spectrum ----------------------------------------------------------------------------------------


@settings(max_examples=examples(30), deadline=None)
@given(
    st.integers(2, 14),
    st.integers(-14, 14),
    st.floats(-9.0, 3.0),
    st.floats(-12.0, 0.0),
    st.floats(-1e3, 1e3),
)
def test_one_wave_is_in_its_ring(i, j, log_size, log_height, offset):
    size, height = 10.0**log_size, 10.0**log_height
    x, y = coordinates(32, 32, 1.0 / 32)
    wave = height * (math.sqrt(2.0) * np.cos(2.0 * math.pi * (i * x + j * y) + 1.0) + offset)
    rings = rings_of(wave, np.array([size, size]), periodic=True)
    ring = round(math.hypot(i, j)) - 1
    if ring >= rings.log_q.size:
        return
    step = 2.0 * math.pi / size
    # h^2 = int C2D d^2q, two waves of the plane for each that is independent
    variance = rings.spectrum * 2.0 * rings.waves * step**2
    assert variance[ring] == pytest.approx(height**2, rel=1e-9)
    assert not np.delete(variance, ring).any()
    spectrum = mdr.power_spectrum(mdr.Topography(wave, size), periodic=True).data["power_spectrum"].values
    assert np.sum(spectrum > 0.0) <= 1


def test_heights_without_a_wave_in_the_range():
    x, y = coordinates(32, 32)
    assert mdr.power_spectrum(mdr.Topography(np.cos(math.pi * x / 16), 1.0), periodic=True).data.sizes
    for heights, words in (
        (np.cos(math.pi * x / 16), "or pass periodic=True"),
        (np.cos(math.pi * (x - 0.5)) * np.cos(math.pi * (y - 0.5)), "no waves from"),
    ):
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.power_spectrum(mdr.Topography(heights, 1.0))


def test_heights_of_rectangles_and_windows():
    rng = np.random.default_rng(3)
    white = rng.standard_normal((96, 64))
    sides = np.array([3e-6, 1e-6])
    expected = np.prod(sides / white.shape) / (4.0 * math.pi**2)  # white noise has one density
    for periodic in (True, False):
        rings = rings_of(white, sides, periodic)
        weight = rings.waves / rings.waves.sum()
        scatter = math.sqrt(weight @ (rings.alike / np.sqrt(np.outer(rings.waves, rings.waves))) @ weight)
        assert float(weight @ rings.spectrum) == pytest.approx(expected, rel=4.0 * scatter)
        # single rings scatter as so many waves do
        chi = np.sum(rings.waves * (rings.spectrum / expected - 1.0) ** 2) / rings.waves.size
        assert 0.5 < chi < 2.0


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("hurst", [0.2, 0.8, 1.0])
def test_exponents_without_bias(hurst, periodic):
    rng = np.random.default_rng(round(100 * hurst))
    fits = []
    for _ in range(10):
        heights = random_surface(rng, 128 if periodic else 384, hurst)[:128, :128]
        fits.append(mdr.power_spectrum(mdr.Topography(1e-9 * heights, "1 um"), periodic=periodic).fit)
    results, claimed = (np.array([getattr(fit, name) for fit in fits]) for name in ("hurst", "hurst_error"))
    # standardised errors: their mean is that of ten, their standard deviation 1
    off = (results - hurst) / claimed
    assert abs(off.mean()) < 3.0 / math.sqrt(10)
    assert 0.4 < np.sqrt(np.mean(off**2)) < 1.8
    assert claimed.mean() < 0.1


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(0.05, 1.0), st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([None, 20.0]))
def test_exponents_are_within_their_errors(hurst, seed, periodic, roll_off):
    rng = np.random.default_rng(seed)
    heights = random_surface(rng, 128 if periodic else 256, hurst, roll_off)[:128, :128]
    fit = mdr.power_spectrum(mdr.Topography(heights, 128.0), periodic=periodic).fit
    # of 400 such surfaces one in a hundred was more than 3 off, and none more than 4
    assert abs(fit.hurst - hurst) < 6.0 * fit.hurst_error
    assert fit.hurst_error < 0.2


def test_a_roll_off_and_the_rough_surface_of_a_fit():
    rng = np.random.default_rng(8)
    heights = random_surface(rng, 768, 0.7, roll_off=32.0)[:256, :256]
    spectrum = mdr.power_spectrum(mdr.Topography(heights, 256.0))
    fit = spectrum.fit
    assert abs(fit.hurst - 0.7) < 3.0 * fit.hurst_error
    assert abs(math.log(fit.roll_off / 32.0)) < 3.0 * fit.roll_off_error < 0.5
    assert fit.law_rms == pytest.approx(fit.rms, rel=0.15)
    surface = fit.rough_surface(seed=3)
    assert surface.rms == pytest.approx(heights.std(), rel=1e-12)
    assert (surface.hurst, surface.longest, surface.seed) == (fit.hurst, fit.roll_off, 3)
    assert surface.shortest == fit.shortest == pytest.approx(4.0, rel=0.05)
    # its spectrum is the one that was measured
    q, measured = spectrum["wave_number"].values, spectrum["power_spectrum"].values
    fitted = np.isfinite(spectrum["law"].values)
    ratio = measured[fitted] / surface.spectrum_2d(q[fitted])
    assert np.exp(np.mean(np.log(ratio))) == pytest.approx(1.0, rel=0.2)
    pressed = mdr.press_rough(fit.rough_surface(shortest="16 m"), GLASS, normal_force="1 kN", realisations=3)
    assert pressed["normal_stiffness"].values[0] > 0.0
    assert len(spectrum.plot().axes) == 3
    assert "roll-off at" in str(spectrum)
    assert spectrum.claims["law"].level is mdr.Level.APPROXIMATE
    assert all(one.met for one in spectrum.assumptions)
    whole = mdr.power_spectrum(mdr.Topography(random_surface(rng, 256, 0.7), 256.0), periodic=True).fit
    assert whole.roll_off is None


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(-9.0, 3.0), st.floats(-9.0, 0.0))
def test_a_fit_knows_no_scale(log_size, log_slope):
    heights = random_surface(np.random.default_rng(1), 64, 0.5)
    size = 10.0**log_size
    one, other = (
        mdr.power_spectrum(mdr.Topography(heights * a, side)).fit
        for a, side in ((1.0, 64.0), (10.0**log_slope * size, size))
    )
    assert other.hurst == pytest.approx(one.hurst, rel=1e-6)
    assert other.hurst_error == pytest.approx(one.hurst_error, rel=1e-4)
    assert other.shortest / size == pytest.approx(one.shortest / 64.0, rel=1e-6)


def test_what_is_no_self_affine_surface():
    x, y = coordinates(128, 128)
    grating = mdr.Topography(np.sign(np.sin(2 * math.pi * x / 16.0)) + 0.001 * np.sin(y), 128.0)
    spectrum = mdr.power_spectrum(grating)
    isotropy = spectrum.assumptions[0]
    assert not isotropy.met
    small = mdr.power_spectrum(mdr.Topography(random_surface(np.random.default_rng(0), 32, 0.5), 1.0))
    with pytest.raises(mdr.NotValidError, match="no range of 5 bins follows"):
        _ = small.fit
    assert "NOT_VALID" in str(small)
    assert len(small.plot().axes) == 3
    # a smooth bump falls faster than any power
    smooth = mdr.power_spectrum(
        mdr.Topography(np.exp(-((x - 64) ** 2 + (y - 64) ** 2) / 800.0), 128.0), periodic=True
    )
    with pytest.raises(mdr.NotValidError):
        smooth.fit.rough_surface()
    for surface, words in (
        (np.ones((64, 64)), "a smooth plane has no spectrum"),
        (x[:16, :16], "at least 32 x 32"),
    ):
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.power_spectrum(mdr.Topography(surface, 1.0))
    with pytest.raises(mdr.ProblemError, match="not a Topography"):
        mdr.power_spectrum(x)


def test_the_spectrum_as_another_package_has_it():
    other = pytest.importorskip(
        "SurfaceTopography", reason="SurfaceTopography, of the extra topography, is not installed"
    )
    heights = random_surface(np.random.default_rng(4), 128, 0.8)
    for periodic in (True, False):
        theirs = other.Topography(heights, (128.0, 128.0), periodic=periodic)
        _, c = theirs.power_spectrum_from_area(
            collocation=2.0 * math.pi / 128.0 * (np.arange(64) + 0.5), window=None if periodic else "hann"
        )
        rings = rings_of(heights, np.array([128.0, 128.0]), periodic)
        ratio = 4.0 * math.pi**2 * rings.spectrum[4:28] / np.asarray(c)[4:28]
        # their window is round
        assert np.max(np.abs(np.log(ratio))) < (1e-9 if periodic else 0.5)
        assert abs(np.mean(np.log(ratio))) < 0.1


# --- one bump --------------------------------------------------------------------------------------------


def ball(rng, radius=5e-6, centre=(1.1e-6, 0.93e-6), noise=0.0, tilt=0.0, ratio=1.0, n=128, size=2e-6):
    x, y = coordinates(n, n, size / n)
    u, v = x - centre[0], y - centre[1]
    heights = -(u**2 / ratio + v**2) / (2.0 * radius) + tilt * u
    return mdr.Topography(heights + noise * rng.standard_normal((n, n)), size)


@pytest.mark.parametrize(("noise", "within"), [(0.0, 1e-5), (1e-10, 5e-3), (1e-9, 0.03)])
def test_hertz_from_a_measured_ball(noise, within):
    bump = mdr.azimuthal_profile(ball(np.random.default_rng(1), noise=noise))
    assert bump.centre == pytest.approx((1.1e-6, 0.93e-6), abs=1e-12 + 3.0 * noise)
    assert bump.radii == pytest.approx((5e-6, 5e-6), rel=1e-9 + 2e7 * noise)
    scatter = bump.profile.scatter
    assert np.median(scatter) == pytest.approx(noise, rel=0.15, abs=4e-10)
    contact = mdr.Contact(bump.profile, GLASS)
    result = mdr.solve(contact, mdr.indent("20 nm"))
    hertz = 4.0 / 3.0 * mdr.effective_moduli(GLASS, mdr.Rigid()).normal * math.sqrt(5e-6) * 20e-9**1.5
    assert float(result["normal_force"][0]) == pytest.approx(hertz, rel=within)
    assert len(bump.plot().axes) == 3
    assert "one bump" in str(bump)
    assert "lower bound" in bump._repr_html_()


def test_a_tilt_moves_the_apex_and_an_oblong_bump_is_bounded():
    rng = np.random.default_rng(2)
    tilted = mdr.azimuthal_profile(ball(rng, tilt=0.05))
    assert tilted.centre == pytest.approx((1.35e-6, 0.93e-6), abs=1e-12)
    oblong = mdr.azimuthal_profile(ball(rng, ratio=2.0))
    assert oblong.radii == pytest.approx((5e-6, 10e-6), rel=1e-9)
    # the mean of 1/R over all directions
    assert oblong.profile.height[-1] == pytest.approx(oblong.profile.max_radius**2 * 0.75 / 10e-6, rel=0.02)
    given = mdr.azimuthal_profile(ball(rng), centre=("1.09 um", "0.94 um"), max_radius="0.5 um")
    assert given.centre == pytest.approx((1.09e-6, 0.94e-6), rel=1e-15)
    assert given.profile.max_radius == pytest.approx(0.5e-6, rel=0.03)


def test_a_sharp_tip_stays_sharp():
    x, y = coordinates(100, 100, 1e-8)
    cone = mdr.Topography(-0.1 * np.hypot(x - 503e-9, y - 496e-9), 1e-6)
    profile = mdr.azimuthal_profile(cone, centre=(503e-9, 496e-9)).profile
    # within a tenth of what it falls over a pixel: rings are placed as those of a round tip are
    assert profile.height[1:] == pytest.approx(0.1 * profile.radius[1:], abs=1e-10)
    result = mdr.azimuthal_profile(cone)
    assert result.centre == pytest.approx((503e-9, 496e-9), abs=1e-9)
    assert np.all(np.diff(result.profile.height) > 0.0)


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(0.35, 0.65), st.floats(0.35, 0.65), st.floats(-6.0, 3.0), st.floats(-4.0, -0.5))
def test_the_apex_of_any_size(x, y, log_size, log_slope):
    size = 10.0**log_size
    bump = mdr.azimuthal_profile(
        ball(np.random.default_rng(0), size * 10.0**-log_slope, (x * size, y * size), n=64, size=size)
    )
    assert bump.centre == pytest.approx((x * size, y * size), rel=1e-9)
    r, f = bump.profile.radius, bump.profile.height
    assert f[1:] == pytest.approx(r[1:] ** 2 / (2 * size * 10.0**-log_slope), rel=1e-9)


def peaks(*places):
    x, y = coordinates(128, 128)
    return sum(tall * np.exp(-((x - a) ** 2 + (y - b) ** 2) / 200.0) for a, b, tall in places)


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        (peaks((40, 64, 1.0), (90, 64, 0.9)), "there is another at"),
        (peaks((3, 64, 1.0)), "from the edge of the patch"),
        (-peaks((64, 64, 1.0)), "from the edge of the patch"),
        (np.random.default_rng(0).standard_normal((128, 128)), "not one bump"),
        (random_surface(np.random.default_rng(1), 128, 0.5), "not one bump"),
        (-((coordinates(128, 128)[0] - 64.0) ** 2), "not one bump"),
        (np.add.outer(np.arange(128.0), np.arange(128.0)), "from the edge of the patch"),
        (-((coordinates(128, 128)[0] - 64.0) ** 2) - (coordinates(128, 128)[1] - 64.0) ** 2 / 5.0, "oblong"),
    ],
)
def test_what_is_not_one_bump(heights, words):
    with pytest.raises(mdr.ProblemError, match="not one bump") as refusal:
        mdr.azimuthal_profile(mdr.Topography(1e-9 * heights, "1 um"))
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"centre": ("1 um", "9 um")}, "within the patch"),
        ({"centre": "1 um"}, "x and y"),
        ({"max_radius": "-1 um"}, "above 0 m"),
        ({"max_radius": "1.5 um"}, "smaller max_radius"),
    ],
)
def test_bad_questions_of_a_bump(arguments, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.azimuthal_profile(ball(np.random.default_rng(0)), **arguments)
    with pytest.raises(mdr.ProblemError, match="not a Topography"):
        mdr.azimuthal_profile(np.ones((64, 64)))


@pytest.mark.parametrize(("fraction", "fitted"), [(0.03, True), (0.27, False)])
def test_interpolated_pixels_are_said_or_refused(fraction, fitted):
    rng = np.random.default_rng(5)
    whole = mdr.Topography(1e-8 * random_surface(rng, 128, 0.6), "1 um")
    heights = whole.heights.copy()
    heights[heights < np.quantile(heights, fraction)] = np.nan
    filled = mdr.Topography(heights, "1 um").fill_missing("interpolate").detrend("mean")
    true, results = (mdr.power_spectrum(one, periodic=True) for one in (whole, filled))
    assert f"{100 * fraction:.2g} % of the pixels" in results.claims["power_spectrum"].reason
    q = 2.0 * np.pi * np.geomspace(3e6, 2e7, 20)
    low = np.divide(
        *(
            np.interp(np.log(q), np.log(one.data["wave_number"]), one["power_spectrum"])
            for one in (results, true)
        )
    )
    assert np.min(low) >= 1.0 - 5.0 * fraction
    assert results.claims["law"].readable == fitted
    if fitted:
        assert results.fit.hurst_error > true.fit.hurst_error
    else:
        with pytest.raises(mdr.NotValidError, match="interpolated"):
            _ = results.fit


@pytest.mark.parametrize("seed", range(3))
def test_the_bound_of_a_bump_counts_from_where_press_counts(seed):
    """Noise stands out of the mean, and depths are counted from its highest pixel."""
    pytest.importorskip("ContactMechanics")
    bumpy = ball(np.random.default_rng(seed), noise=2e-9, n=48)
    bump = mdr.azimuthal_profile(bumpy)
    body = mdr.Elastic("1 GPa", 0.0)
    assert bump.below_summit > 1e-9
    depth = bump.below_summit + np.array([5e-9, 2e-8])
    pressed = mdr.press(bumpy, body, indentation=depth)
    bound = mdr.solve(mdr.Contact(bump.profile, body), mdr.Path(indentation=depth - bump.below_summit))
    error = pressed.claims["normal_force"].error
    assert np.all(bound["normal_force"].values <= pressed["normal_force"].values * (1.0 + error))
    assert np.all(bound["normal_force"].values >= 0.5 * pressed["normal_force"].values)
