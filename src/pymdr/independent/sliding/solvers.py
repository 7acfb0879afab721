"""Pressure and tangential tractions of one row."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.independent.sliding.surface import Surface
from pymdr.units import FloatArray, metres

_TOLERANCE = 1e-9
_ITERATIONS = 5000


def solve_pressure(surface: Surface, gap: FloatArray, depth: float, start: FloatArray) -> FloatArray:
    """
    Pressure p >= 0 with zero gap f - d + u in the contact and no overlap elsewhere.

    Parameters
    ----------
    gap : ndarray (n, n), m
        f, inf outside the body.
    depth : float, m
        d.
    start : ndarray (n, n), Pa
        First iterate.

    Raises
    ------
    ConvergenceError
        If gap or overlap exceeds 1e-9 of the largest undeformed overlap.

    Notes
    -----
    Conjugate gradients on the cells in contact: Polonsky and Keer (1999), Wear 231, 206.
    """
    free = gap < depth
    overlap = np.where(free, depth - np.where(free, gap, 0.0), 0.0)
    if not free.any():
        return np.zeros_like(gap)
    size = float(overlap.max())
    p = np.where(free, start, 0.0)
    if not p.any():
        p = np.where(free, size / float(surface.normal.real.max()), 0.0)
    direction, last, error = np.zeros_like(p), math.inf, math.inf
    for _ in range(_ITERATIONS):
        contact = p > 0
        rest = surface.normal_displacement(p) - overlap
        error = max(float(np.abs(rest[contact]).max(initial=0.0)), -float(rest[free].min()))
        if error <= _TOLERANCE * size:
            return p
        norm = float(np.sum(rest[contact] ** 2))
        direction = np.where(contact, rest + (norm / last if last else 0.0) * direction, 0.0)
        pull = surface.normal_displacement(direction)
        step = (
            float(np.sum((rest * direction)[contact]) / np.sum((pull * direction)[contact])) if norm else 0.0
        )
        p = np.maximum(p - step * direction, 0.0)
        touching = free & (p == 0) & (rest < 0)
        last = norm
        if touching.any():
            p = np.where(touching, p - (step or 1 / float(surface.normal.real.max())) * rest, p)
            last = math.inf
    raise ConvergenceError(
        f"solve_sliding: the pressure at {metres(depth)} did not converge: relative residual {error / size:.1e} (limit {_TOLERANCE:g}); use a coarser grid"
    )


def solve_tractions(
    surface: Surface, reference: FloatArray, limit: FloatArray, start: FloatArray
) -> FloatArray:
    """
    Tractions that minimise q C q / 2 - w q under |q| <= limit.

    Parameters
    ----------
    reference : ndarray (2, n, n), m
        w: displacement of a cell without slip.
    limit : ndarray (n, n), Pa
        mu p.
    start : ndarray (2, n, n), Pa
        First iterate.

    Raises
    ------
    ConvergenceError
        If a projected gradient step of 1 / (largest eigenvalue of C) exceeds 1e-9 of the largest w.

    Notes
    -----
    Projected gradients with momentum (Beck and Teboulle 2009) and restarts (O'Donoghue and Candes 2015).
    """
    q = ahead = _capped(start, limit)
    size = float(np.abs(reference[:, limit > 0]).max(initial=0.0))
    momentum, error = 1.0, 0.0
    for _ in range(_ITERATIONS):
        slip = reference - surface.tangential_displacement(ahead)
        new = _capped(ahead + slip / surface.stiffest, limit)
        error = surface.stiffest * float(np.abs(new - ahead).max())
        if error <= _TOLERANCE * size:
            return new
        if np.sum((ahead - new) * (new - q)) > 0:
            momentum = 1.0
        following = (1 + math.sqrt(1 + 4 * momentum**2)) / 2
        ahead, q, momentum = new + (momentum - 1) / following * (new - q), new, following
    raise ConvergenceError(
        f"solve_sliding: the tractions did not converge: relative residual of slip {error / size:.1e} (limit {_TOLERANCE:g}); use more rows or a coarser grid"
    )


def _capped(q: FloatArray, limit: FloatArray) -> FloatArray:
    """Tractions reduced to their limit, in unchanged directions."""
    size = np.hypot(*q)
    return np.asarray(q * np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0))
