"""Displacements of two elastic half-spaces under tractions that are constant on square cells."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from pymdr.errors import ProblemError
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.materials import Material, common_exponent
from pymdr.units import FloatArray


def influence(x: ArrayLike, y: ArrayLike, side: float) -> FloatArray:
    """
    Integrals of x^2/s^3, y^2/s^3 and xy/s^3 over a square cell about the origin, s the distance to (x, y).

    Parameters
    ----------
    x, y : array_like, m
    side : float, m

    Returns
    -------
    ndarray, m
        Shape (3, ...); the first two add up to the integral of 1/s.

    Notes
    -----
    Love (1929), Phil. Trans. R. Soc. A 228, 377; Johnson (1985), eqs. 3.25 and 3.75. Corner sums of
    v asinh(u/|v|), u asinh(v/|u|) and -s.

    Examples
    --------
    >>> influence(0.0, 0.0, 1.0).round(9).tolist()
    [1.762747174, 1.762747174, 0.0]
    """
    half = side / 2
    total: FloatArray = np.zeros((3, *np.broadcast(x, y).shape))
    for i in (-1, 1):
        for j in (-1, 1):
            u, v = np.broadcast_arrays(np.asarray(x) + i * half, np.asarray(y) + j * half)
            total += i * j * np.array([_term(v, u), _term(u, v), -np.hypot(u, v)])
    return total


def _term(u: FloatArray, v: FloatArray) -> FloatArray:
    size = np.abs(u)
    return np.where(size > 0, u * np.arcsinh(v / np.where(size > 0, size, 1.0)), 0.0)


class Surface(NamedTuple):
    """Two elastic half-spaces under the cells of a square."""

    x: FloatArray
    side: float
    normal: NDArray[np.complex128]
    tangential: NDArray[np.complex128]
    stiffest: float
    """Upper bound of the eigenvalues of the tangential compliance."""

    def normal_displacement(self, p: FloatArray) -> FloatArray:
        """Sum over both bodies."""
        n = p.shape[-1]
        return np.asarray(fft.irfft2(self.normal * fft.rfft2(p, (2 * n, 2 * n)), (2 * n, 2 * n))[:n, :n])

    def tangential_displacement(self, q: FloatArray) -> FloatArray:
        """Sum over both bodies; tractions and displacements (2, n, n)."""
        n = q.shape[-1]
        transformed = np.einsum("abij,bij->aij", self.tangential, fft.rfft2(q, (2 * n, 2 * n)))
        return np.asarray(fft.irfft2(transformed, (2 * n, 2 * n))[:, :n, :n])


def make_surface(half_width: float, n: int, body: Material, counterbody: Material) -> Surface:
    """
    Compliances of two bodies on n x n cells of a square.

    Per body and traction q_x, u_x = (1/pi) int q_x [L/s + (T - L) x^2/s^3] and u_y = (1/pi) int q_x (T - L) x y/s^3, and
    u_z = (1/pi) int p N/s, with the normal, longitudinal and transverse compliances N, L and T of its surface, which are
    (1 - nu)/(2G), the same, and 1/(2G) of an isotropic one; the bodies add up.

    Parameters
    ----------
    half_width : float, m

    Notes
    -----
    Johnson (1985), eqs. 3.17 and 3.75; general compliances by superposition of traction waves of all directions.
    """
    side = 2 * half_width / n
    lags = side * np.concatenate([np.arange(n), [0.0], np.arange(1 - n, 0)])
    xx, yy, xy = influence(lags[:, None], lags, side)
    for kernel in (xx, yy, xy):
        kernel[n], kernel[:, n] = 0.0, 0.0
    exponent = common_exponent(body, counterbody)
    if exponent != 0.0:
        raise ProblemError(
            f"a body is graded (exponent {exponent:g}), but the kernels are for homogeneous half-spaces; use homogeneous bodies"
        )
    surfaces = [surface_compliances(material) for material in (body, counterbody)]
    normal = sum(s.normal for s in surfaces) / math.pi
    direct = sum(s.longitudinal for s in surfaces) / math.pi
    lateral = sum(s.transverse - s.longitudinal for s in surfaces) / math.pi
    plain, cross = xx + yy, lateral * xy
    along = direct * plain
    symbol = fft.rfft2(np.array([[along + lateral * xx, cross], [cross, along + lateral * yy]]))
    trace, difference = symbol[0, 0].real + symbol[1, 1].real, symbol[0, 0].real - symbol[1, 1].real
    stiffest = float(np.max(trace + np.hypot(difference, 2 * np.abs(symbol[0, 1]))) / 2)
    x = side * (np.arange(n) + 0.5) - half_width
    return Surface(np.asarray(x, dtype=np.float64), side, fft.rfft2(normal * plain), symbol, stiffest)
