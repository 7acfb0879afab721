"""How a free spring creeps back: the modes of Maxwell branches, a spring and a dashpot beside each other."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray

_SLOWEST = 1e-18
"""Of the fastest rate: no mode is slower."""


class Modes(NamedTuple):
    """
    Amplitudes m with m' = -rates m, w = rest + reach . m, energy |m|^2 / 2.

    rest is 0 with an equilibrium modulus and stays what it is without one.
    """

    rates: FloatArray
    """(k,) in 1/s, above 0."""
    reach: FloatArray
    """(k,) deflection of a unit amplitude."""
    to_modes: FloatArray
    """(k, n + 1) from the forces of the branches and w to m."""
    to_branches: FloatArray
    """(n, k) back to the forces of the branches."""


@lru_cache(maxsize=32)
def modes_of(body: Relaxation) -> Modes:
    """
    Modes of a body at zero force.

    With u = h / sqrt(E_j), b = sqrt(E_j), D = 1/tau: without a dashpot u' = -(1 - b b^T / E_g) D u, which D^(1/2) makes
    symmetric; with one, and u_0 = sqrt(E_inf) w beside the others, u' = -(D + b b^T / eta) u.
    """
    n = body.moduli.size
    roots, decay = np.sqrt(body.moduli), 1.0 / body.times
    if body.viscosity > 0.0:
        b, d = roots, decay
        if body.equilibrium > 0.0:
            b, d = np.append(roots, np.sqrt(body.equilibrium)), np.append(decay, 0.0)
        rates, q = np.linalg.eigh(np.diag(d) + np.outer(b, b) / body.viscosity)
        to_modes = np.zeros((rates.size, n + 1))
        to_modes[:, :n] = q[:n].T / roots
        if body.equilibrium > 0.0:
            to_modes[:, n] = q[n] * b[n]
            reach = q[n] / b[n]
        else:
            reach = (b @ q) / (body.viscosity * rates)
        return Modes(rates, reach, to_modes, roots[:, None] * q[:n])
    half = np.sqrt(decay)
    matrix = np.diag(decay) - np.outer(half * roots, half * roots) / body.glassy
    rates, q = np.linalg.eigh(matrix)
    if body.equilibrium == 0.0:  # the first one is the flow, which no free spring has
        rates, q = rates[1:], q[:, 1:]
    # the flow of a body that is nearly a liquid is slower than rounding tells
    rates = np.maximum(rates, _SLOWEST * rates[-1]) if rates.size else rates
    scale = np.sqrt(rates)
    to_modes = np.zeros((rates.size, n + 1))
    to_modes[:, :n] = (q / scale).T * (half / roots)
    return Modes(
        rates,
        -((roots * half) @ q) / (scale * body.glassy),
        to_modes,
        (roots / half)[:, None] * q * scale,
    )


def unpacked(
    deflection: FloatArray,
    branches: FloatArray,
    loose: FloatArray,
    size: int,
    relaxation: Relaxation,
    modes: Modes,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Arrays of the kernels: w; branches of springs in contact, modes of free ones; whether free, and w less its modes.

    From w, forces of the branches and 1 where a spring is loose, of the first of `size` springs; nothing has touched the rest.
    """
    n, known = relaxation.moduli.size, deflection.size
    w, z, free = np.zeros(size), np.zeros((size, max(n, modes.rates.size))), np.zeros((2, size))
    free[0] = 1.0
    w[:known] = deflection
    free[0, :known] = loose
    h = np.zeros((size, n))
    if known:
        h[:known] = branches
    apart = free[0] != 0.0
    z[~apart, :n] = h[~apart]
    amplitudes = np.column_stack([h[apart], w[apart]]) @ modes.to_modes.T
    z[apart, : modes.rates.size] = amplitudes
    if relaxation.equilibrium == 0.0:
        free[1, apart] = w[apart] - amplitudes @ modes.reach
    return w, z, free


def packed(
    w: FloatArray, z: FloatArray, free: FloatArray, relaxation: Relaxation, modes: Modes
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Back: w, forces of the branches, and 1 where a spring is loose."""
    n, loose = relaxation.moduli.size, free[0] != 0.0
    h = z[:, :n].copy()
    h[loose] = z[loose, : modes.rates.size] @ modes.to_branches.T
    return w, h, free[0].copy()


def longer(values: FloatArray, size: int) -> FloatArray:
    """Values of the kernel with those of springs that nothing has touched."""
    if values.ndim == 2 and values.shape[0] == 2 and size != 2:
        more = np.zeros((2, size))
        more[0] = 1.0
        more[:, : values.shape[1]] = values
        return more
    longer = np.zeros((size, *values.shape[1:]))
    longer[: values.shape[0]] = values
    return longer
