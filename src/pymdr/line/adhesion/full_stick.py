"""Adhesion of short range under shear without slip: the shear of the contact takes a part of the work of adhesion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.adhesion.short_range import JKR
from pymdr.units import FloatArray

_FIRST = 1e-9
"""Relative distance of the first state from the smallest contact, within which slopes are lost to rounding; no state there is stable."""


@dataclass(frozen=True)
class ShearedJKR(JKR):
    """The curve of JKR states of a half-space whose contact is sheared without slip.

    k' Δl² + k_t' u² = 4π a γ with k' = 2E* and k_t' = 2G*: Δl = sqrt((2π a γ - G* u²) / E*), d = g(a) - Δl,
    F = F0 - 2E* a Δl.

    Parameters
    ----------
    line : Disk
        The contact without adhesion, of homogeneous half-spaces.
    work : float
        Work of adhesion γ [J/m²].
    shear : float or ndarray
        G* u² [N], of all states or of each one.

    Notes
    -----
    Savkoor and Briggs (1977) for a sphere; any profile by the rule of Hess (2011). The curve begins at the smallest contact
    that carries the shear, G* u² / (2π γ), whose edge is not stretched.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> sheared = ShearedJKR(ball, work=1.0, shear=np.pi)
    >>> round(sheared.start, 6), float(sheared.states(0.5).indentation), round(float(sheared.opening(1.0)**2 / np.pi), 12)
    (0.5, 0.25, 1.0)
    """

    shear: float | FloatArray = 0.0

    @property
    def start(self) -> float:
        """The parameter of the smallest contact that carries the shear [m]."""
        radius = np.array([(1.0 + _FIRST) * float(np.max(self.shear)) / (2.0 * math.pi * self.work)])
        return float(self._radii.parameter(radius)[0])

    def _stretch(self, a: FloatArray, stiffness_rate: FloatArray) -> FloatArray:
        rest = 4.0 * np.pi * self.work * a - 2.0 * self.shear
        return np.sqrt(np.maximum(rest, 0.0) / stiffness_rate)

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds = d0' - Δl' (dimensionless) and dF/ds = k d0' - (k Δl)' [N/m] at constant shift, with Δl' = 2π γ / (k' Δl)."""
        s, line = np.asarray(s, dtype=float), self.line
        position, per = self._positions_and_rates(s)
        stiffness, spread, _ = line.punch(position)
        opening = self._stretch(np.asarray(position, dtype=float), spread)
        with np.errstate(divide="ignore", invalid="ignore"):
            widening = 2.0 * np.pi * self.work / (spread * opening)
            rate = np.where(np.isinf(widening), -widening, line.depth_rate(position) - widening)
            force_rate = np.where(stiffness > 0.0, stiffness * rate - spread * opening, 0.0)
        stuck = s >= self._edge
        return np.where(stuck, 1.0, rate * per), np.where(stuck, stiffness, force_rate * per)
