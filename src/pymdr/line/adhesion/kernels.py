"""Forces of JKR contacts over arrays of indentations and parameters, at millions of evaluations a second.

They hold the branch that is stable under displacement control; a path that jumps needs `line.following`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.adhesion.closed_forms import power_law_factor
from pymdr.units import FloatArray

_BLOCK = 8192
_Kernel = Callable[..., FloatArray]


def jkr_force(indentation: ArrayLike, radius: ArrayLike, modulus: ArrayLike, work: ArrayLike) -> FloatArray:
    """Return the force of JKR contacts of paraboloids at given indentations, in closed form.

    With L³ = πγR²/8E*, y = sqrt(a/L) solves y⁴ - 4y = dR/L², y >= 1, and F = πγR (y⁶/6 - y³).

    Parameters
    ----------
    indentation : array_like
        d [m].
    radius, modulus, work : array_like
        R > 0 [m], E* > 0 [Pa] and γ >= 0 [J/m²].

    Returns
    -------
    ndarray
        F [N] on the branch that is stable under displacement control; 0 where d is below the snap-off
        -3 L²/R and no contact exists.

    Notes
    -----
    Johnson, Kendall & Roberts (1971). Ferrari's resolvent m³ + δm - 2 = 0 is solved with every difference
    that vanishes at the fold written through t = δ + 3, so y - 1 keeps its digits there.

    Examples
    --------
    >>> snap = -3 / 4 * np.pi ** (2 / 3)
    >>> np.allclose(jkr_force([0.0, snap * (1 - 1e-15), -2.0], 1.0, 1.0, 1.0) / np.pi,
    ...             [-4 / 3, -5 / 6, 0.0], atol=1e-7)
    True
    """
    arrays = [np.asarray(x, dtype=float) for x in (indentation, radius, modulus, work)]
    return _blockwise(_jkr_block, arrays)


def _jkr_block(d: FloatArray, R: FloatArray, E: FloatArray, gamma: FloatArray) -> FloatArray:
    """Return the forces of one block; see `jkr_force`."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        scale = np.cbrt(np.pi * gamma * R * R / (8.0 * E))
        delta = d * R / (scale * scale)
        t = np.maximum(delta + 3.0, 0.0)
        third = delta * (1.0 / 3.0)
        # Cardano for the resolvent: 1 + (δ/3)³ = (t/3) (1 - δ/3 + δ²/9)
        A = np.cbrt(1.0 + np.sqrt(t * (1.0 / 3.0) * (1.0 + third * (third - 1.0))))
        B = third / A
        m = 2.0 / (A * A + third + B * B)
        q = np.sqrt(2.0 * m)
        # 8 - q³ = 8 (2 - m)(4 + 2m + m²)/(8 + q³), 2 - m = t m/(m + 1)²
        rest = 8.0 * t * m * (4.0 + m * (2.0 + m)) / ((1.0 + m) ** 2 * (8.0 + q**3) * q)
        y = 0.5 * (q + np.sqrt(rest))
        cube = y * y * y
        force = np.pi * gamma * R * (cube * (cube * (1.0 / 6.0) - 1.0))
        hertz = delta > 1e30
        if np.any(hertz | (gamma == 0.0)):
            bare = (4.0 / 3.0) * E * np.sqrt(R) * np.maximum(d, 0.0) ** 1.5
            force = np.where(hertz | (gamma == 0.0), bare, force)
        return np.where((delta >= -3.0) | (gamma == 0.0), force, 0.0)


def jkr_power_law_force(
    indentation: ArrayLike, exponent: float, coefficient: ArrayLike, modulus: ArrayLike, work: ArrayLike
) -> FloatArray:
    """Return the force of JKR contacts of power laws f = c rⁿ at given indentations.

    With the snap-off values a0 and Q = Δl(a0) of displacement control, y = sqrt(a/a0) solves
    y^(2n)/2n - y = d/Q, y >= 1, and F = 2E* a0 Q [y^(2n+2)/(2n+2) - y³].

    Parameters
    ----------
    indentation : array_like
        d [m].
    exponent : float
        n > 1/2, one for all.
    coefficient, modulus, work : array_like
        c > 0 [m^(1-n)], E* > 0 [Pa] and γ > 0 [J/m²].

    Returns
    -------
    ndarray
        F [N] on the branch that is stable under displacement control; 0 below the snap-off.

    Raises
    ------
    ProblemError
        When n <= 1/2.

    Notes
    -----
    Hess (2011). ln y is read from a table over ln(1 + sqrt(d/Q + 1 - 1/2n)), where the fold is smooth, and
    finished by Halley's step.

    Examples
    --------
    >>> depths = np.array([-1.0, 0.0, 2.0])
    >>> ball = jkr_power_law_force(depths, 2.0, 0.5, 1.0, 1.0)
    >>> np.allclose(ball, jkr_force(depths, 1.0, 1.0, 1.0), rtol=1e-13)
    True
    """
    n = float(exponent)
    if not n > 0.5:
        raise ProblemError(f"the JKR force of a power law needs an exponent above 1/2, not {n!r}")
    kappa = float(power_law_factor(n))
    table = _power_table(n)

    def block(d: FloatArray, c: FloatArray, E: FloatArray, gamma: FloatArray) -> FloatArray:
        ratio = 2.0 * np.pi * gamma / E
        a0 = (ratio / (4.0 * (n * kappa * c) ** 2)) ** (1.0 / (2.0 * n - 1.0))
        Q = np.sqrt(ratio * a0)
        t = d / Q + (1.0 - 0.5 / n)
        y, power = _power_root(np.maximum(t, 0.0), 2.0 * n, table)
        force = 2.0 * E * a0 * Q * y * y * (power / (2.0 * n + 2.0) - y)
        return np.where(t >= 0.0, force, 0.0)

    return _blockwise(block, [np.asarray(x, dtype=float) for x in (indentation, coefficient, modulus, work)])


_CELL, _TOP = 1.0 / 16.0, 48.0


@lru_cache(maxsize=32)
def _power_table(n: float) -> FloatArray:
    """Return cubic segments of w = ln y over u = ln(1 + sqrt t), where (e^(Nw) - 1)/N - (e^w - 1) = t, N = 2n."""
    N = 2.0 * n
    u = np.arange(0.0, _TOP + 0.5 * _CELL, _CELL)
    t = np.expm1(u) ** 2
    # the left side is convex and rising: Newton descends to the root from above, where it arrives after one
    # step from below; sqrt(2t/(N - 1)) is a bound of y - 1, from above for N >= 2, and 1 + N(t + y - 1) = y^N
    bound = np.sqrt(2.0 * t / (N - 1.0))
    if N >= 2.0:
        w = np.minimum(np.log1p(bound), np.log1p(N * (t + bound)) / N)
    else:
        w = np.maximum(np.log1p(bound), np.log1p(N * t) / N)
    for _ in range(200):
        excess = np.expm1(N * w) / N - np.expm1(w) - t
        rate = np.maximum(np.exp(N * w) - np.exp(w), np.finfo(float).tiny)
        new = np.maximum(w - excess / rate, 0.0)
        new[0] = 0.0
        settled = np.all(np.abs(new - w) <= 1e-9 * (1.0 + w))
        w = new
        if settled:
            break
    else:
        raise ConvergenceError(
            f"the JKR table of exponent {n!r} did not converge (last ln y = {float(w[-1])!r}); use a smaller exponent of the profile"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = 2.0 * np.expm1(u) * np.exp(u) / (np.exp(N * w) - np.exp(w)) * _CELL
    slope[0] = np.sqrt(2.0 / (N - 1.0)) * _CELL
    rise = np.diff(w)
    left, right = slope[:-1], slope[1:]
    table = np.stack([w[:-1], left, 3.0 * rise - 2.0 * left - right, left + right - 2.0 * rise])
    table.setflags(write=False)
    return table


def _power_root(t: FloatArray, N: float, table: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return y and y^N of (y^N - 1)/N - (y - 1) = t, y >= 1."""
    u = np.log1p(np.sqrt(t)) * (1.0 / _CELL)
    cell = np.minimum(u, table.shape[1] - 1).astype(np.intp)
    x = np.minimum(u - cell, 1.0)
    w = ((table[3][cell] * x + table[2][cell]) * x + table[1][cell]) * x + table[0][cell]
    if np.any(u > table.shape[1]):
        w = np.where(u > table.shape[1], np.log1p(N * t) / N, w)
    for _ in range(60):
        e = np.expm1(w)
        power = np.expm1(N * w)
        excess = power / N - e - t
        rate = np.maximum(power - e, 1e-150)
        newton = excess / rate
        step = -newton / np.maximum(1.0 - 0.5 * newton * ((N * power - e + (N - 1.0)) / rate), 0.5)
        if np.all(np.abs(step) <= 3e-6 * (1.0 + w)):
            # cubic convergence: this step is the last, and its exponential a short series
            e += (1.0 + e) * step * (1.0 + 0.5 * step)
            return 1.0 + e, 1.0 + N * (t + e)
        w = np.maximum(w + step, 0.0)
    raise ConvergenceError(
        f"the JKR root did not converge (last ln y = {float(w.flat[0])!r}); check the magnitudes of work, modulus and radius"
    )


def _blockwise(function: _Kernel, arrays: list[FloatArray]) -> FloatArray:
    """Return function(*arrays) over the broadcast shape, in blocks that stay in the cache."""
    shape = np.broadcast_shapes(*(x.shape for x in arrays))
    flat = [x.reshape(()) if x.size == 1 else np.broadcast_to(x, shape).ravel() for x in arrays]
    size = int(np.prod(shape))
    if size <= _BLOCK:
        return np.asarray(function(*flat), dtype=np.float64).reshape(shape)
    out = np.empty(size)
    for i in range(0, size, _BLOCK):
        part = slice(i, i + _BLOCK)
        out[part] = function(*(x[part] if x.ndim else x for x in flat))
    return out.reshape(shape)
