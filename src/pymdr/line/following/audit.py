"""The work along a history by quadrature, for comparison with the energies."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.following.curves import Curve
from pymdr.line.following.paths import History
from pymdr.line.following.tracks import Track
from pymdr.units import FloatArray, metres

_NODES, _LEVELS, _TOLERANCE = 20, 40, 1e-13
_RULES = leggauss(_NODES // 2), leggauss(_NODES)
_NEIGHBOURS = 8.0 * float(np.finfo(float).eps)


def energy_residual(track: Track, history: History) -> float:
    """
    Largest |work - (T - T_initial) - dissipation| over the largest energy of the history.

    The work int Y dD is integrated over every smooth segment between two jumps, independent of T, so that the balance
    tests energies, jumps and forces at any number of steps.

    Parameters
    ----------
    track : Track
        Of a curve with its conjugate.
    history : History
        What was followed on it.

    Returns
    -------
    float
        Dimensionless; 0 for a history without contact. What follows the loss of a contact under a dead
        load, which has no end, is left out.

    Raises
    ------
    ConvergenceError
        If a stretch is not integrated to rounding.
    """
    curve, jumps = track.curve, history.jumps
    last = float(history.parameter[-1])
    begin = np.append(history.initial, jumps.after)
    end = np.append(jumps.before, last)
    # a contact forms or ends without a jump at the start of the curve
    bound = np.isfinite(begin) | np.isfinite(end)
    low, high = (np.where(np.isfinite(x), x, curve.start) for x in (begin, end))
    stretches, back = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True)
    work = _integrals(curve, stretches[:, 0], stretches[:, 1])[back.reshape(-1)]
    # the rows may reverse between two jumps, so the extreme states determine the exchanged energy
    visited = history.parameter[history.attached]
    widest = np.array([visited.min(), visited.max()]) if visited.size else np.empty(0)
    energies = curve.energy(np.concatenate([low[bound], high[bound], widest]))
    change = np.zeros(low.size)
    change[bound] = np.diff(energies[: 2 * int(bound.sum())].reshape(2, -1), axis=0)[0]
    done = np.cumsum(work)
    # between two jumps T changes by the stretch, and over a jump by its loss
    missing = np.cumsum(work - change)
    largest = float(np.max(np.abs(energies), initial=0.0))
    scale = max(float(np.max(np.abs(done))), float(np.nansum(jumps.loss)), largest)
    return float(np.max(np.abs(missing)) / scale) if scale > 0.0 else 0.0


def _integrals(curve: Curve, low: FloatArray, high: FloatArray) -> FloatArray:
    """The integrals of Y dD/ds ds from low to high, by bisection of panels in sqrt(s - knot)."""
    if curve.conjugate is None:
        raise ProblemError("the curve has no conjugate quantity, so its work cannot be integrated")
    total = np.zeros(low.size)
    marks = np.array([curve.start, *(k for k in curve.knots if k > curve.start), np.inf])
    owner, origin, left, right = _split(low, high, marks)
    if owner.size == 0:
        return total
    size = np.zeros(low.size)
    for _ in range(_LEVELS):
        coarse, fine = _by_panels(curve, origin, left, right)
        np.maximum.at(size, owner, np.abs(fine))
        settled = np.abs(fine - coarse) <= _TOLERANCE * np.maximum(size[owner], np.max(size) * 1e-3)
        # between neighbouring floats there is nothing to resolve
        outer = np.maximum(left, right) ** 2
        rounding = _NEIGHBOURS * (origin + outer)
        settled |= np.abs(right**2 - left**2) <= rounding
        # next to a knot the floats are so coarse that the integrand scatters
        settled |= np.abs(fine - coarse) * outer <= rounding * np.abs(fine)
        np.add.at(total, owner[settled], fine[settled])
        owner, origin, left, right = (x[~settled] for x in (owner, origin, left, right))
        if owner.size == 0:
            return total
        middle = 0.5 * (left + right)
        owner, origin = np.tile(owner, 2), np.tile(origin, 2)
        left, right = np.append(left, middle), np.append(middle, right)
    raise ConvergenceError(
        f"the work along the curve did not converge near s = {metres(float(origin[0] + left[0] ** 2))}; declare the kinks of the profile as breakpoints"
    )


def _split(
    low: FloatArray, high: FloatArray, marks: FloatArray
) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
    """Panels between marks: their owners, the mark below them, and their ends in sqrt(s - mark)."""
    owners, origins, lefts, rights = [], [], [], []
    for bottom, top in pairwise(marks):
        left, right = (np.clip(x, bottom, top) for x in (low, high))
        real = np.flatnonzero(left != right)
        owners.append(real)
        origins.append(np.full(real.size, bottom))
        lefts.append(np.sqrt(left[real] - bottom))
        rights.append(np.sqrt(right[real] - bottom))
    return np.concatenate(owners), np.concatenate(origins), np.concatenate(lefts), np.concatenate(rights)


def _by_panels(curve: Curve, origin: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """The integrals over panels by half of the nodes and by all, shape (2, n)."""
    assert curve.conjugate is not None
    half = 0.5 * (right - left)
    u = left[:, None] + half[:, None] * (1.0 + np.concatenate([rule[0] for rule in _RULES]))
    # correct the rounding of s next to a knot for a slope that grows like 1 / sqrt(s - knot)
    s = np.maximum(origin[:, None] + u * u, np.nextafter(origin, np.inf)[:, None])
    per_u = 2.0 * np.sqrt(s - origin[:, None])
    flat = s.ravel()
    integrand = (curve.conjugate(flat) * curve.slope(flat)).reshape(u.shape) * per_u
    parts = np.split(integrand, [_NODES // 2], axis=1)
    return half * np.stack([part @ rule[1] for part, rule in zip(parts, _RULES, strict=True)])
