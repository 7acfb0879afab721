"""Closed forms of adhesion: characteristic numbers, the pull of a rigid body, pull-off of power laws.

A power-law profile is f = c rⁿ, with g = κ(n) c xⁿ; the paraboloid of radius R has n = 2 and κ c = 1/R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.line.adhesion.cohesive_zone import solve_width
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.equivalent.panels import PanelLine
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray, metres

_FARTHEST = 1e30


def power_law_factor(exponent: ArrayLike) -> FloatArray:
    """Return κ(n) = sqrt(π) Γ(n/2 + 1) / Γ((n + 1)/2), the factor from f = c rⁿ to g = κ c xⁿ.

    Parameters
    ----------
    exponent : array_like
        n > 0.

    Returns
    -------
    ndarray
        κ, dimensionless.

    Notes
    -----
    Popov & Hess (2015), ch. 3.

    Examples
    --------
    >>> round(float(power_law_factor(2.0)), 14)
    2.0
    """
    n = np.asarray(exponent, dtype=float)
    return np.asarray(
        np.sqrt(np.pi) * np.exp(scipy.special.gammaln(0.5 * n + 1.0) - scipy.special.gammaln(0.5 * (n + 1.0)))
    )


DMT_BELOW, JKR_ABOVE = 0.1, 5.0
"""Maugis' numbers below which DMT, and above which JKR are close (Johnson and Greenwood 1997)."""


def tabor_parameter(
    radius: ArrayLike, modulus: ArrayLike, work: ArrayLike, interaction_range: ArrayLike
) -> FloatArray:
    """Return Tabor's number μ = (R γ² / (E*² z0³))^(1/3).

    Parameters
    ----------
    radius, modulus, work, interaction_range : array_like
        Effective curvature radius R [m], E* [Pa], γ [J/m²] and the equilibrium distance z0 [m].

    Returns
    -------
    ndarray
        μ, dimensionless: above 5 JKR, below 0.1 DMT.

    Notes
    -----
    Tabor (1977); Johnson & Greenwood (1997).

    Examples
    --------
    >>> float(tabor_parameter(radius=8.0, modulus=1.0, work=1.0, interaction_range=1.0))
    2.0
    """
    given = radius, modulus, work, interaction_range
    size, stiffness, energy, distance = (np.asarray(x, dtype=float) for x in given)
    parameter: FloatArray = np.cbrt(size * (energy / stiffness) ** 2) / distance
    return parameter


def maugis_parameter(
    radius: ArrayLike, modulus: ArrayLike, work: ArrayLike, strength: ArrayLike
) -> FloatArray:
    """Return Maugis' number λ = 2 σ0 (9R / (16 π γ E*²))^(1/3).

    Parameters
    ----------
    radius, modulus, work, strength : array_like
        Effective curvature radius R [m], E* [Pa], γ [J/m²] and the cohesive stress σ0 [Pa].

    Returns
    -------
    ndarray
        λ, dimensionless; λ = 1.1272 μ with h0 = γ/σ0 in place of z0 in Tabor's number.

    Notes
    -----
    Maugis (1992), with K = 4E*/3.

    Examples
    --------
    >>> float(maugis_parameter(radius=16 * np.pi / 9, modulus=1.0, work=1.0, strength=0.5))
    1.0
    """
    size, energy, stiffness, stress = (np.asarray(x, dtype=float) for x in (radius, work, modulus, strength))
    parameter: FloatArray = 2.0 * stress * np.cbrt(9.0 * size / (16.0 * np.pi * energy * stiffness**2))
    return parameter


def dmt_pull(radius: ArrayLike, work: ArrayLike) -> FloatArray:
    """Return the adhesive pull of a paraboloid in the DMT limit, 2 π γ R.

    Parameters
    ----------
    radius, work : array_like
        R [m] and γ [J/m²].

    Returns
    -------
    ndarray
        The pull [N], positive.

    Notes
    -----
    Derjaguin, Muller & Toporov (1975); Bradley (1932).

    Examples
    --------
    >>> float(dmt_pull(1.0, 0.5) / np.pi)
    1.0
    """
    pull: FloatArray = 2.0 * np.pi * np.asarray(radius, dtype=float) * np.asarray(work, dtype=float)
    return pull


def rigid_pull(line: EquivalentProfile, work: float, strength: float) -> float:
    """Return the pull σ0 π c², f(c) = h0 = γ/σ0, of a rigid body of any profile that touches at its tip.

    Parameters
    ----------
    line : EquivalentProfile
        The equivalent profile, nondecreasing; f = (2/π) int_0^c g/sqrt(c² - x²) dx.
    work : float
        γ [J/m²].
    strength : float
        Cohesive stress σ0 [Pa].

    Returns
    -------
    float
        The pull [N], positive. A sharp edge bounds c.

    Raises
    ------
    ProblemError
        When the known profile ends before f reaches h0.
    ConvergenceError
        When f(c) = h0 is not met.

    Notes
    -----
    The limit E* -> infinity of Maugis-Dugdale. Unlike the paraboloid's 2πγR it depends on σ0.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> ball = SimpleNamespace(slope=lambda x: 2 * x, edge=np.inf, max_radius=np.inf, breakpoints=())
    >>> round(rigid_pull(ball, work=1.0, strength=7.0) / np.pi, 12)
    2.0
    """
    height = work / strength

    end = min(line.edge, line.max_radius)
    begin = line.rough_radius(lambda x, g: g >= height) if isinstance(line, PanelLine) else None
    # without elasticity the gap condition is f(c) = h0
    upper = np.full(1, end if np.isfinite(end) else _FARTHEST)
    c = float(solve_width(line, 0.0, 0.5 * np.pi * height, np.zeros(1), upper, outward=True, begin=begin)[0])
    if c >= end and line.edge > line.max_radius:
        raise ProblemError(
            f"the profile is known only to {metres(end)}, where it is below the range "
            f"of the cohesion, {metres(height)}; extend the profile or raise the strength"
        )
    return float(np.pi * c**2 * strength)


@dataclass(frozen=True)
class PullOff:
    """The last stable state before a contact is lost.

    Attributes
    ----------
    contact_radius, indentation, normal_force : ndarray
        a [m], d [m] and F [N], of one shape.
    """

    contact_radius: FloatArray
    indentation: FloatArray
    normal_force: FloatArray


def power_law_pull_off(
    exponent: ArrayLike,
    coefficient: ArrayLike,
    modulus: ArrayLike,
    work: ArrayLike,
    machine_stiffness: ArrayLike = np.inf,
) -> PullOff:
    """Return the pull-off of JKR contacts of power-law profiles f = c rⁿ.

    a = [2πγξ² / (E* n² κ² c²)]^(1/(2n-1)), F = 2E* a Δl (ξ/(n+1) - 1), d = Δl (ξ/n - 1),
    ξ = ½ (3 + k/2E*a) / (1 + k/2E*a): 1/2 under displacement control, 3/2 under force control.

    Parameters
    ----------
    exponent : array_like
        n > 1/2.
    coefficient : array_like
        c > 0 [m^(1-n)].
    modulus, work : array_like
        E* > 0 [Pa] and γ > 0 [J/m²].
    machine_stiffness : array_like
        k >= 0 [N/m]: ``inf`` (the default) is displacement control, 0 force control.

    Returns
    -------
    PullOff
        Arrays of the broadcast shape.

    Raises
    ------
    ProblemError
        When n <= 1/2, or when k is finite and positive and n < 0.768, where the extremum need not be the
        only one (follow the curve instead).
    ConvergenceError
        When the radius under a finite stiffness does not settle.

    Notes
    -----
    Hess (2011); Popov & Hess (2015), ch. 4. Uniqueness: d ln ξ/d ln a = 2σ/((1+σ)(3+σ)) <= 0.2680 with
    σ = k/2E*a, so n - 1/2 > 0.2680 leaves one root, which ξ = 1/2 and ξ = 3/2 enclose.

    Examples
    --------
    >>> ball = power_law_pull_off(2.0, 0.5, modulus=7.0, work=1.0, machine_stiffness=[0.0, np.inf])
    >>> np.allclose(ball.normal_force / np.pi, [-3 / 2, -5 / 6], rtol=1e-14)
    True
    """
    n, c, E, gamma, k = np.broadcast_arrays(
        *(np.asarray(x, dtype=float) for x in (exponent, coefficient, modulus, work, machine_stiffness))
    )
    if not np.all(n > 0.5):
        raise ProblemError(f"pull-off of a power law needs an exponent above 1/2, not {float(np.min(n))!r}")
    soft = (k > 0.0) & (k < np.inf)
    if np.any(soft & (n < 0.768)):
        worst = float(np.min(n[soft]))
        raise ProblemError(f"with a machine stiffness the exponent must be 0.768 or more, not {worst!r}")
    kappa = power_law_factor(n)
    base = 2.0 * np.pi * gamma / (E * (n * kappa * c) ** 2)
    power = 1.0 / (2.0 * n - 1.0)
    radius_low, radius_high = (base / 4.0) ** power, (9.0 * base / 4.0) ** power
    a = np.where(k == 0.0, radius_high, radius_low)
    if np.any(soft):
        a[soft] = _soft_radius(*(x[soft] for x in (base, power, k / (2.0 * E), radius_low, radius_high)))
    # ½ (3 + σ)/(1 + σ), σ = k/2E*a, written for σ = inf too
    xi = 0.5 + 1.0 / (1.0 + k / (2.0 * E * a))
    opening = np.sqrt(2.0 * np.pi * a * gamma / E)
    return PullOff(a, opening * (xi / n - 1.0), 2.0 * E * a * opening * (xi / (n + 1.0) - 1.0))


def _soft_radius(
    base: FloatArray, power: FloatArray, length: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the root a of a - [base ξ(a)²]^power; length = k/2E*."""

    def missed(a: FloatArray, base: FloatArray, power: FloatArray, length: FloatArray) -> FloatArray:
        return a - (base * (0.5 + 1.0 / (1.0 + length / a)) ** 2) ** power

    # the two ends are met to rounding by very soft and very stiff machines
    return roots_of(missed, (1.0 - 1e-9) * low, (1.0 + 1e-9) * high, base, power, length)
