"""Heights of rough lines."""

from __future__ import annotations

import math

import numpy as np

from pymdr.problem.self_affine import SelfAffineLine
from pymdr.units import FloatArray


def waves(rough: SelfAffineLine) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Wavenumbers, amplitudes and phases of a rough line, z = sum A cos(q x + phi).

    Parameters
    ----------
    rough : SelfAffineLine

    Returns
    -------
    q, A, phi : ndarray
        In 1/m, m and rad; A^2 ~ q^-(2H + 1), so that sum A^2 q^2 / 2 is the squared rms slope.
    """
    first = max(math.ceil(rough.length / rough.longest_wave - 1e-9), 1)
    last = max(math.floor(rough.length / rough.shortest + 1e-9), first)
    q = 2.0 * math.pi / rough.length * np.arange(first, last + 1.0)
    amplitude = (q / q[0]) ** -(rough.hurst + 0.5)
    amplitude *= rough.rms_slope / math.sqrt(0.5 * float(np.sum((amplitude * q) ** 2)))
    # one phase after the other, so that more waves leave those before as they are
    phase = 2.0 * math.pi * np.random.default_rng(rough.seed).random(last)[first - 1 :]
    return q, amplitude, phase


def line_heights(rough: SelfAffineLine, n: int) -> FloatArray:
    """
    Heights of a rough line at n even places of its length, whose mean is 0.

    Parameters
    ----------
    rough : SelfAffineLine
    n : int

    Returns
    -------
    ndarray
        z in m, above 0 toward the other body.

    Examples
    --------
    >>> line = SelfAffineLine(length=1.0, rms_slope=0.1, hurst=0.8, shortest=0.02)
    >>> z = line_heights(line, 4096)
    >>> round(float(np.sqrt(np.mean(np.diff(z) ** 2)) * 4096), 3)
    0.1
    """
    q, amplitude, phase = waves(rough)
    spectrum = np.zeros(n // 2 + 1, dtype=complex)
    number = np.rint(q * rough.length / (2.0 * math.pi)).astype(int)
    spectrum[number] = 0.5 * n * amplitude * np.exp(1j * phase)
    return np.asarray(np.fft.irfft(spectrum, n))
