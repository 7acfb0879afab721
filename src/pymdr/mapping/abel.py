"""The Abel transforms between a profile f(r) and its equivalent g(x), and between springs and fields.

All integrals are taken by Gauss-Jacobi rules on panels split at breakpoints. Every integral is computed
with two rules; where they differ, the nodes are doubled, then the panels are graded toward r = 0, and a
:class:`~pymdr.errors.ConvergenceError` is raised if that does not help.

The kernels contain the exponent k of a power-law graded half-space, E(z) ~ z^k; k = 0 is the homogeneous one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.numerics.quadrature import LEVELS, TOLERANCE, Rule, integrate
from pymdr.units import FloatArray, metres

Curve: TypeAlias = Callable[[FloatArray], FloatArray]

_CENTRE_TOLERANCE = 1e-12
_STEEP_TOLERANCE = 1e-7
"""Rule for averages of curves that are steep at the edge."""
_TIP_POWER = 16
"""A tip that is not smooth is mapped by t = s^16, which makes powers of r down to r^0.1 smooth in s."""
_GRADING = 0.25 ** np.arange(24, 0, -1.0)


def _require(values: FloatArray, columns: FloatArray, what: str) -> FloatArray:
    """The values, if all of them converged."""
    bad = np.isnan(values)
    if bad.any():
        raise ConvergenceError(
            f"{what}: the quadrature did not converge at {metres(columns[bad][0])}; name the radii "
            "where the profile is not smooth as breakpoints, and stay inside the radii where it is defined"
        )
    return values


def _marks(breakpoints: Sequence[float], low: FloatArray, high: FloatArray) -> FloatArray:
    """Rising radii low <= b_1 <= ... <= high for each column; breakpoints outside collapse onto the ends."""
    inner = [np.clip(b, low, high) for b in breakpoints]
    return np.array([low, *inner, high])


def _angular(
    integrand: Callable[[FloatArray, FloatArray], FloatArray],
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
    breakpoints: Sequence[float],
    what: str,
    rule: Rule,
) -> FloatArray:
    """
    Integrate sin(phi)^exponent integrand(r, x) dphi over r = x cos(phi) between low and high.

    Where that does not converge it is split at r = x / sqrt(2), and the inner part is taken in
    theta = pi/2 - phi, which resolves a tip.
    """
    exponent = rule.exponent

    def outer(phi: FloatArray, x: FloatArray) -> FloatArray:
        values = integrand(x * np.cos(phi), x)
        return values if exponent == 0.0 else values * np.sinc(phi / np.pi) ** exponent

    def inner(theta: FloatArray, x: FloatArray) -> FloatArray:
        values = integrand(x * np.sin(theta), x)
        return values if exponent == 0.0 else values * np.cos(theta) ** exponent

    def edges(x: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        # by the form that keeps all digits next to r = x
        r = _marks(breakpoints, low, high)[::-1]
        phi = np.arctan2(np.sqrt((x - r) * (x + r)), r)
        return phi if exponent == 0.0 else np.insert(phi, 1, phi[:2].mean(axis=0), axis=0)

    answer = integrate(outer, edges(x, low, high), x, replace(rule, levels=LEVELS[:4]))
    hard = np.isnan(answer)
    if hard.any():
        radius, start, stop = x[hard], low[hard], high[hard]
        middle = np.clip(radius / math.sqrt(2.0), start, stop)
        theta = np.arcsin(_marks(breakpoints, start, middle) / radius)
        graded = theta[0] + np.multiply.outer(_GRADING, theta[1] - theta[0])
        theta = np.concatenate([theta[:1], graded, theta[1:]])
        tip = Rule(power=abs(rule.power), tip_power=_TIP_POWER, noise=rule.noise)
        answer[hard] = integrate(outer, edges(radius, middle, stop), radius, rule) + integrate(
            inner, theta, radius, tip
        )
    return _require(answer, x, what)


def _columns(x: ArrayLike) -> tuple[FloatArray, FloatArray]:
    x = np.asarray(x, dtype=float)
    flat = np.abs(np.ravel(x))
    return x, flat


def forward(
    slope: Curve, x: ArrayLike, *, breakpoints: Sequence[float] = (), k: float = 0.0, noise: float = 0.0
) -> FloatArray:
    """
    Equivalent profile g(x) = x^(1-k) int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr.

    Parameters
    ----------
    slope : callable
        f'(r) on arrays.
    x : array_like
        Positions on the line in m.
    breakpoints : sequence of float
        Rising radii in m at which f' is not smooth.
    k : float
        Exponent of the grading, -1 < k < 1; 0 for a homogeneous half-space.
    noise : float
        Rounding noise of the slope; convergence is not required below it.

    Returns
    -------
    ndarray
        g in m, of the shape of `x`.

    Raises
    ------
    ConvergenceError
        If 1e-13 is not reached.

    Notes
    -----
    Galin (1946), Sneddon (1965); Hess (2016) for k. With r = x cos(phi) it reads
    x int_0^(pi/2) f'(x cos(phi)) sin(phi)^k dphi.

    Examples
    --------
    >>> bool(abs(forward(lambda r: r, 3.0) - 9.0) < 1e-14)
    True
    """
    x, flat = _columns(x)
    values = flat * _slope_moment(slope, flat, breakpoints, None, k, noise, "g(x)")
    return np.asarray(values.reshape(x.shape))


def moment(
    slope: Curve, x: ArrayLike, *, breakpoints: Sequence[float] = (), k: float = 0.0, noise: float = 0.0
) -> FloatArray:
    """
    First moment int_0^x t^(1+k) g'(t) dt = int_0^x f'(r) r^2 (x^2 - r^2)^((k-1)/2) dr of the equivalent profile.

    Parameters
    ----------
    slope, x, breakpoints, k, noise
        As for :func:`forward`.

    Returns
    -------
    ndarray
        In m^(2+k); for k = 0 the normal force is 2 E* times this (Sneddon 1965), else 2 c / (1 + k) times this.

    Examples
    --------
    >>> bool(abs(moment(lambda r: r, 3.0) - 18.0) < 1e-13)
    True
    >>> bool(abs(moment(lambda r: r, 3.0, k=0.5) - 3.0**3.5 / 2.625) < 1e-12)
    True
    """
    x, flat = _columns(x)
    values = flat ** (2.0 + k) * _slope_moment(slope, flat, breakpoints, np.square, k, noise, "force")
    return np.asarray(values.reshape(x.shape))


def _slope_moment(
    slope: Curve,
    x: FloatArray,
    breakpoints: Sequence[float],
    weight: Curve | None,
    k: float,
    noise: float,
    what: str,
) -> FloatArray:
    """Integral of f'(x cos phi) weight(cos phi) sin(phi)^k over 0..pi/2; zero at x = 0."""
    answer = np.zeros(x.shape)
    positive = x > 0.0
    top = x[positive]
    answer[positive] = _angular(
        lambda r, x: slope(r) * weight(r / x) if weight else slope(r),
        top,
        np.zeros_like(top),
        top,
        breakpoints,
        what,
        Rule(k, noise=noise),
    )
    return answer


def inverse(
    equivalent: Curve, r: ArrayLike, *, breakpoints: Sequence[float] = (), k: float = 0.0
) -> FloatArray:
    """
    Profile f(r) = (2/pi) cos(k pi/2) int_0^r x^k g(x) (r^2 - x^2)^(-(1+k)/2) dx.

    Parameters
    ----------
    equivalent : callable
        g(x) on arrays.
    r : array_like
        Radii in m.
    breakpoints : sequence of float
        Rising positions in m to whose right g is not smooth.
    k : float
        Exponent of the grading, -1 < k < 1.

    Returns
    -------
    ndarray
        f in m, of the shape of `r`.

    Raises
    ------
    ConvergenceError
        If 1e-13 is not reached.

    Examples
    --------
    >>> bool(abs(inverse(lambda x: x**2, 3.0) - 4.5) < 1e-13)
    True
    """
    return math.cos(k * math.pi / 2.0) * line_average(equivalent, r, breakpoints=breakpoints, k=k)


def line_average(
    curve: Curve,
    r: ArrayLike,
    low: float = 0.0,
    high: float = math.inf,
    *,
    breakpoints: Sequence[float] = (),
    k: float = 0.0,
    noise: float = 0.0,
) -> FloatArray:
    """
    The transform (2/pi) int x^k w(x) (r^2 - x^2)^(-(1+k)/2) dx from the line to the surface.

    With w = d - g between 0 and min(r, a) it is the surface displacement; with g - d between a and r it
    is the gap.

    Parameters
    ----------
    curve : callable
        w(x) on arrays.
    r : array_like
        Radii in m.
    low, high : float
        Limits in m; the upper one is cut at r.
    breakpoints : sequence of float
        Rising positions in m to whose right w is not smooth.
    k : float
        Exponent of the grading.
    noise : float
        Rounding noise of w; convergence is not required below it.

    Returns
    -------
    ndarray
        Of the unit of w and the shape of `r`; zero where r <= low.

    Raises
    ------
    ConvergenceError
        If 1e-13 is not reached.

    Notes
    -----
    Popov and Hess (2015), chapter 3. With x = r cos(phi) the panels are mapped quadratically at their
    upper end, which removes the square-root behaviour that g has to the right of a kink of f.

    Examples
    --------
    >>> bool(abs(line_average(np.ones_like, 2.0, high=1.0) - 2 / np.pi * np.arcsin(0.5)) < 1e-15)
    True
    """
    r, flat = _columns(r)

    answer = np.zeros(flat.shape)
    reached = flat > low
    radius = flat[reached]
    answer[reached] = _angular(
        lambda x, r: curve(x) * (x / r) ** k if k else curve(x),
        radius,
        np.full(radius.shape, low),
        np.minimum(radius, high),
        breakpoints,
        "line average",
        Rule(-k, power=-2, noise=noise),
    )
    return np.asarray(2.0 / math.pi * answer.reshape(r.shape))


def edge_average(curve: Curve, r: ArrayLike, a: float, *, k: float = 0.0) -> FloatArray:
    """
    The transform int_r^a v(x) (x^2 - r^2)^((k-1)/2) dx from the line to the pressure.

    With v = g' and the factor E*/pi it is the regular part of the pressure; with v = 2 pi p x / E* it
    leads back to the line load.

    Parameters
    ----------
    curve : callable
        v(x) on arrays.
    r, k
        As for :func:`line_average`.
    a : float
        Upper limit in m.

    Returns
    -------
    ndarray
        Of the shape of `r`; zero for r >= a, inf at r = 0 where v(0) is not 0.

    Raises
    ------
    ConvergenceError
        If 1e-13 is not reached.

    Notes
    -----
    Sneddon (1965). With x = r cosh(s) it is int (r sinh(s))^k v(r cosh(s)) ds, on panels that halve x from
    a down to r; limits are written with asinh, which keeps all digits as r goes to a.

    Examples
    --------
    >>> bool(abs(edge_average(lambda x: 2 * x, 0.6, 1.0) - 2 * 0.8) < 1e-14)
    True
    """
    r, flat = _columns(r)
    answer = np.zeros(flat.shape)
    centre = (flat < a * 1e-150) & (a > 0.0)
    inside = (flat < a) & ~centre
    if centre.any():
        answer[centre] = _centre_value(curve, a, k)
    if not inside.any():
        return answer.reshape(r.shape)
    halvings = min(40, math.ceil(math.log2(a / flat[inside].min())))
    halves = a * 0.5 ** np.arange(1.0, halvings)
    rising = np.append(halves[::-1], a)

    def edges(radius: FloatArray) -> FloatArray:
        x = np.maximum(np.concatenate([[0.0], rising])[:, None], radius)
        return np.asarray(np.arcsinh(np.sqrt((x - radius) * (x + radius)) / radius))

    def fine_edges(radius: FloatArray) -> FloatArray:
        s = edges(radius)
        return np.array([s[0], *(lo + (hi - lo) * q for lo, hi in pairwise(s) for q in (*_GRADING, 1.0))])

    def integrand(s: FloatArray, radius: FloatArray) -> FloatArray:
        values = curve(radius * np.cosh(s))
        return values if k == 0.0 else values * (radius * np.sinh(s) / s) ** k

    radius = flat[inside]
    values = integrate(integrand, edges(radius), radius, Rule(k, power=2, levels=LEVELS[:4]))
    hard = np.isnan(values)
    if hard.any():
        steep = Rule(k, power=2, tolerance=_STEEP_TOLERANCE)
        values[hard] = integrate(integrand, fine_edges(radius[hard]), radius[hard], steep)
    answer[inside] = _require(values, radius, "pressure")
    return answer.reshape(r.shape)


def _centre_value(curve: Curve, a: float, k: float) -> float:
    """The integral of v x^(k-1) from 0 to a, on panels graded to 0 and a power law below them."""
    x = a * 0.5 ** np.arange(59.0, -1.0, -1.0)
    tip = curve(x[:2])
    if not np.any(tip > 0.0) and not np.any(tip < 0.0):
        below = 0.0
    else:
        exponent = k + float(np.log(tip[1] / tip[0]) / np.log(x[1] / x[0]))
        below = math.inf if exponent < 1e-6 else float(tip[0]) * x[0] ** k / exponent
    panels = np.array([x[:-1], x[1:]])
    middle = np.sqrt(x[:-1] * x[1:])
    size = float(np.sum(np.abs(curve(middle)) * middle ** (k - 1.0) * np.diff(x)))
    rule = Rule(power=2, tolerance=_CENTRE_TOLERANCE, noise=TOLERANCE * size)
    body = integrate(lambda t, *_: curve(t) * t ** (k - 1.0), panels, x[1:], rule)
    return below + float(_require(body, x[1:], "pressure").sum())
