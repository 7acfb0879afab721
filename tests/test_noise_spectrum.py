"""Spectra of the noise of records: against dense matrices, under scaling and reversal, and how often intervals cover the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.special import stdtrit

import pymdr as mdr
from pymdr.solving.fits.bands import bands_of, orthonormal, restricted_likelihood
from pymdr.solving.fits.spectrum import WHITE_PRIOR, noise_spectra

GEL = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(0.75, 0.5))


def design(n):
    """Orthonormal tangents of a Hertzian contact at the truth, and the factors back to modulus, contact point and baseline."""
    depth = np.maximum(np.linspace(-1.0, 1.5, n), 0.0)
    basis, back = orthonormal(np.array([[depth**1.5, -1.5 * depth**0.5, np.ones(n)]]))
    return basis[0], back[0]


def autoregressive(rng, count, n, length):
    phi = math.exp(-1.0 / length)
    steps = rng.normal(size=(count, n)) * math.sqrt(1.0 - phi**2)
    steps[:, 0] /= math.sqrt(1.0 - phi**2)
    return lfilter([1.0], [1.0, -phi], steps, axis=1)


def anticorrelated(rng, count, n, part, lengths):
    steps = rng.normal(size=(count, n + 1))
    return steps[:, 1:] - part * steps[:, :-1] + 0.3 * autoregressive(rng, count, n, n / lengths)


def flicker(rng, count, n):
    frequency = np.arange(1, 4 * n + 1)
    waves = rng.normal(size=(count, frequency.size)) + 1j * rng.normal(size=(count, frequency.size))
    spectrum = np.concatenate([np.zeros((count, 1)), waves / np.sqrt(frequency)], axis=1)
    return np.fft.irfft(spectrum, 8 * n, axis=1)[:, :n]


def slow_covariance(n, slow, length):
    """Of the reflected autoregressive process: the inverse of a tridiagonal matrix."""
    phi = math.exp(-1.0 / length)
    laplacian = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    laplacian[0, 0] = laplacian[-1, -1] = 1.0
    return slow * (1.0 - phi) ** 2 * np.linalg.inv((1.0 - phi) ** 2 * np.eye(n) + phi * laplacian)


@pytest.mark.parametrize(("slow", "length"), [(0.0, 5.0), (3.0, 1.5), (200.0, 20.0), (1e4, 150.0)])
def test_the_likelihood_is_that_of_dense_matrices(slow, length):
    n, rng = 200, np.random.default_rng(4)
    basis, _ = design(n)
    values = autoregressive(rng, 1, n, 10.0)[0] + rng.normal(size=n)
    residuals = values - basis.T @ (basis @ values)
    bands = bands_of(residuals[None], basis[None], modes=n, ratio=1.0)

    def dense(matrix):
        inverse = np.linalg.inv(matrix)
        information = basis @ inverse @ basis.T
        projected = inverse - inverse @ basis.T @ np.linalg.solve(information, basis @ inverse)
        squares = values @ projected @ values
        determinants = np.linalg.slogdet(matrix)[1] + np.linalg.slogdet(information)[1]
        return -0.5 * (determinants + (n - 3) * math.log(squares)), squares / (n - 3)

    grid = [np.array([[one, 0.0]]) for one in (slow, length)]
    logarithm, white, density = restricted_likelihood(bands, grid[0], np.maximum(grid[1], 1.0))
    covariance = np.eye(n) + slow_covariance(n, slow, length)
    one, level = dense(covariance)
    assert logarithm[0, 0] - logarithm[0, 1] == pytest.approx(one - dense(np.eye(n))[0], abs=1e-8)
    assert white[0, 0] == pytest.approx(level, rel=1e-8)
    ours = np.einsum("b,bij->ij", density[0, 0], bands.tangents[0])
    assert ours == pytest.approx(basis @ covariance @ basis.T, rel=1e-8, abs=1e-8 * np.abs(ours).max())


@pytest.mark.parametrize(
    ("noise", "n", "low", "high"),
    [
        (lambda rng, m, n: rng.normal(size=(m, n)), 500, 0.93, 0.97),
        (lambda rng, m, n: autoregressive(rng, m, n, 3.0), 500, 0.93, 0.98),
        (lambda rng, m, n: autoregressive(rng, m, n, 10.0), 500, 0.93, 0.98),
        (lambda rng, m, n: anticorrelated(rng, m, n, 0.3, 50), 500, 0.92, 0.97),
        (lambda rng, m, n: anticorrelated(rng, m, n, 0.1, 50), 500, 0.92, 0.97),
        (lambda rng, m, n: anticorrelated(rng, m, n, 0.3, 10), 500, 0.85, 0.97),
        (flicker, 500, 0.85, 0.97),
        (lambda rng, m, n: autoregressive(rng, m, n, 40.0), 4000, 0.93, 0.98),
    ],
    ids=["white", "AR 3", "AR 10", "a 0.3", "a 0.1", "a 0.3, 10 lengths", "1/f", "AR 40 of 4000"],
)
def test_intervals_cover_the_truth(noise, n, low, high):
    count = 600 if n < 1000 else 300
    basis, back = design(n)
    values = noise(np.random.default_rng(12), count, n)
    off = values @ basis.T
    spectra = noise_spectra(values - off @ basis, np.broadcast_to(basis, (count, *basis.shape)))
    errors = np.sqrt(np.einsum("ij,mjk,ik->mi", back, spectra.covariance, back))
    covered = np.mean(np.abs(off @ back.T) < 1.96 * errors, axis=0)[:2]
    slack = 3.0 * math.sqrt(0.05 * 0.95 / count)  # three deviations of the count
    assert np.all(covered > low - slack)
    assert np.all(covered < high + slack)


@pytest.mark.parametrize("n", [60, 500, 16000])
def test_white_noise_hardly_widens(n):
    count = 200 if n < 1000 else 40
    basis, back = design(n)
    values = np.random.default_rng(5).normal(size=(count, n))
    left, tangents = values - values @ basis.T @ basis, np.broadcast_to(basis, (count, *basis.shape))
    spectra = noise_spectra(left, tangents, prior=0.5)
    errors = np.sqrt(np.einsum("ij,mjk,ik->mi", back, spectra.covariance, back))
    # the baseline lies in the lowest modes, which tell least of the noise
    ratio = np.median(errors / np.sqrt((back**2).sum(axis=1)), axis=0)[:2]
    assert np.all(ratio > 0.95)
    assert np.all(ratio < 1.12)
    assert np.mean(spectra.white > 0.5) > 0.9


def a_record(seed, length, size=300):
    basis, _ = design(size)
    rng = np.random.default_rng(seed)
    values = rng.normal(size=size) + autoregressive(rng, 1, size, length)[0]
    return values - basis.T @ (basis @ values), basis


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    length=st.floats(1.0, 300.0),
    scale=st.floats(-12.0, 12.0),
)
def test_scale_and_direction_do_not_matter(seed, length, scale):
    residuals, basis = a_record(seed, length)
    plain = noise_spectra(residuals[None], basis[None])
    scaled = noise_spectra(10.0**scale * residuals[None], basis[None])
    reversed_ = noise_spectra(residuals[None, ::-1], basis[None, :, ::-1])
    assert scaled.covariance == pytest.approx(10.0 ** (2.0 * scale) * plain.covariance, rel=1e-8)
    assert reversed_.covariance == pytest.approx(plain.covariance, rel=1e-8)
    assert scaled.length == pytest.approx(plain.length, rel=1e-8)
    assert reversed_.white == pytest.approx(plain.white, rel=1e-6, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.floats(1.0, 300.0))
def test_the_parameters_do_not_matter(seed, length):
    residuals, basis = a_record(seed, length)
    mix = np.random.default_rng(seed).normal(size=(3, 3)) + 3.0 * np.eye(3)
    again, back = orthonormal((mix @ basis)[None])
    one = noise_spectra(residuals[None], basis[None]).covariance[0]
    other = back[0] @ noise_spectra(residuals[None], again).covariance[0] @ back[0].T
    # the rates over x of the tangents mix B are B^-T over those of B
    assert mix.T @ other @ mix == pytest.approx(one, rel=1e-6, abs=1e-9 * np.abs(one).max())


def test_a_direction_that_others_contain_is_left_out():
    _, basis = a_record(1, 5.0)
    twice = np.concatenate([basis, basis[:1] + basis[1:2], np.zeros((1, basis.shape[1]))])
    again, _ = orthonormal(twice[None])
    norms = np.linalg.norm(again[0], axis=1)
    assert np.sum(np.isclose(norms, 1.0)) == 3
    assert np.sum(np.isclose(norms, 0.0)) == 2


def test_the_order_of_curves_does_not_matter():
    rng = np.random.default_rng(3)
    parts = [autoregressive(rng, 1, n, 8.0)[0] for n in (150, 270)]
    level = [np.full((1, 1, 420), 420**-0.5)] * 2
    one, other = (
        noise_spectra(np.concatenate(parts[::k])[None], tangent, [part.size for part in parts[::k]])
        for k, tangent in zip((1, -1), level, strict=True)
    )
    assert one.covariance == pytest.approx(other.covariance, rel=1e-8)
    assert one.length == pytest.approx(other.length, rel=1e-8)


def test_short_records_are_taken_for_white():
    rng = np.random.default_rng(2)
    values, basis = rng.normal(size=(1, 10)), np.full((1, 1, 10), 10**-0.5)
    residuals = values - values.mean()
    spectra = noise_spectra(residuals[:, :8], basis[:, :, :8] * math.sqrt(10 / 8), keep=True)
    assert spectra.white[0] == 1.0
    assert spectra.quantile(np.ones((1, 1, 1)))[0, 0] == pytest.approx(stdtrit(7.0, 0.975), rel=1e-9)
    assert noise_spectra(np.zeros((1, 50)), np.full((1, 1, 50), 50**-0.5)).covariance[0, 0, 0] < 1e-250


def test_noise_of_the_depths_is_no_spectrum():
    """Tangents that contain the noise explain the residuals at high frequencies, which must not look like a slow part."""
    n, rng = 182, np.random.default_rng(8)
    # 2500 without care
    noise = rng.normal(size=n)
    depth = np.linspace(0.0, 1.0, n) + 0.02 * noise
    rates = np.stack([np.ones(n), depth, depth**2, depth**3])
    basis, _ = orthonormal(rates[None])
    residuals = noise - basis[0].T @ (basis[0] @ noise)
    spectra = noise_spectra(residuals[None], basis, prior=0.5)
    assert np.diag(spectra.covariance[0]).max() < 10.0


def curves(count, n, length=None):
    """Forces of a Hertzian contact with white noise whose neighbours are anticorrelated, and a slow part."""
    depth = np.linspace(-1.0, 1.0, n)
    force = mdr.solve(GEL, mdr.Path(indentation=depth))["normal_force"].values
    rng = np.random.default_rng(6)
    steps = rng.normal(size=(count, n + 1))
    noise = steps[:, 1:] - 0.3 * steps[:, :-1]
    if length is not None:
        noise += 1.0 * autoregressive(rng, count, n, length)
    return [mdr.MeasuredCurve(force=force + 0.02 * one, indentation=depth) for one in noise]


def test_fits_note_correlated_residuals():
    """A record whose neighbours are anticorrelated, on which sums of correlations end at once, and a slow part."""
    (plain,), (wavy,) = curves(1, 500), curves(1, 500, 25.0)
    one, other = (mdr.fit(GEL, curve, ["body.young"]) for curve in (plain, wavy))
    assert not any("correlated" in note for note in one.notes)
    (note,) = (note for note in other.notes if "correlated over about" in note)
    assert "widened by a factor of" in note
    assert "correlation lengths" in note
    assert other.correlated > 9.0
    assert other.waves > 0.3
    assert other["body.young"].error > 2.5 * one["body.young"].error
    assert other["body.young"].low < 0.75 < other["body.young"].high
    # profiles of the likelihood are widened alike
    low, high = other.profile_intervals()["body.young"]
    computed = other["body.young"]
    assert high - low == pytest.approx(computed.high - computed.low, rel=0.15)


def test_maps_have_the_errors_of_fits():
    records = [*curves(2, 400), *curves(2, 400, 20.0)]
    table = mdr.fit_map(GEL, records, ["body.young"])
    assert any(note.startswith("2 of 4 curves have correlated residuals") for note in table.notes)
    # curves of a map share the probability of white noise; those of a map of one do not
    for record in records:
        table, one = mdr.fit_map(GEL, [record], ["body.young"]), mdr.fit(GEL, record, ["body.young"])
        assert table["correlated"].values[0] == pytest.approx(one.correlated, rel=1e-3)
        for name in ("body.young", "contact_point", "baseline"):
            assert table[f"{name}_error"].values[0] == pytest.approx(one[name].error, rel=1e-3)


def test_records_of_one_instrument_share_the_probability_of_white_noise():
    """A slow part that two of five records do not show: without the others the intervals are too narrow."""
    rng, count, n = np.random.default_rng(9), 1000, 500
    basis, back = design(n)
    tangents = np.tile(basis, (count, 1, 1))

    def fraction(noise, prior):
        errors, left = noise @ basis.T, noise - (noise @ basis.T) @ basis
        covariance = back @ noise_spectra(left, tangents, prior=prior).covariance @ back.T
        inside = np.abs(errors @ back.T) < 1.96 * np.sqrt(np.einsum("mii->mi", covariance))
        return inside.mean(axis=0)[:2]

    hidden, white = anticorrelated(rng, count, n, 0.1, 10), rng.normal(size=(count, n))
    assert np.all(fraction(hidden, None) > fraction(hidden, 0.5) + 0.02)
    for noise in (white, anticorrelated(rng, count, n, 0.1, 50)):
        assert np.all((fraction(noise, None) > 0.93) & (fraction(noise, None) < 0.97))
    left = hidden[:1] - (hidden[:1] @ basis.T) @ basis
    alone, single = (noise_spectra(left, basis[None], prior=one).covariance for one in (None, WHITE_PRIOR))
    np.testing.assert_allclose(alone, single, rtol=1e-12)
