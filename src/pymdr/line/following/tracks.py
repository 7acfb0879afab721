"""The branches of a curve with what happens at their ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import PathError
from pymdr.line.following.branches import Inverse, inverse_of, turning_points
from pymdr.line.following.curves import Curve
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

Index = NDArray[np.intp]
FREE, END = -1, -2
_ROUNDING = 1e-12
"""Largest distance of the start of a branch above its touch, over the range of D."""
_SHORT = 2000
"""Largest number of states computed without tables, which cost as much as a few thousand states."""


@dataclass(frozen=True)
class Transitions:
    """Jumps out of the branches in one direction, one entry per branch.

    Attributes
    ----------
    to : ndarray of int
        Branch reached; -1 for a free body, -2 where the known curve ends.
    control : ndarray
        D of the jump.
    before, after : ndarray
        The parameter before and after; for a free body the start of the curve.
    loss : ndarray
        Energy dissipated [J].
    """

    to: Index
    control: FloatArray
    before: FloatArray
    after: FloatArray
    loss: FloatArray


@dataclass(frozen=True)
class Track:
    """A curve with all its branches and jumps, by `trace`.

    Attributes
    ----------
    curve : Curve
        The curve.
    turning : ndarray
        Parameters of its start, folds and stop.
    bottom, top : ndarray
        Ends of the stable branches in s.
    low, high : ndarray
        Ends of the stable branches in D.
    touch : float
        D at which a free body touches.
    jumps : tuple of Transitions
        Upward, downward, and (one entry) at the touch.
    """

    curve: Curve
    turning: FloatArray
    bottom: FloatArray
    top: FloatArray
    low: FloatArray
    high: FloatArray
    touch: float
    jumps: tuple[Transitions, Transitions, Transitions]

    @cached_property
    def inverse(self) -> Inverse:
        """Tables of s from branch and D, for long paths."""
        return inverse_of(self.curve.control, self.bottom, self.top, np.array(sorted(self.curve.knots)))

    def parameters(self, branch: Index, control: FloatArray) -> FloatArray:
        """Return s of the states with the given D on the given branches; few states are computed without tables."""
        bottom, top = self.bottom[branch], self.top[branch]
        if control.size > _SHORT or "inverse" in self.__dict__:
            # rounding must not take a state off its branch
            return np.clip(self.inverse(branch, control), bottom, top)
        levels = np.clip(control, self.low[branch], self.high[branch])

        def above(s: FloatArray, D: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
            value = self.curve.control(s) - D
            # rounding at the ends of a branch must not hide its change of sign
            return np.where(
                s <= first, np.minimum(value, 0.0), np.where(s >= last, np.maximum(value, 0.0), value)
            )

        return roots_of(above, bottom, top, levels, bottom, top)

    @property
    def pull_off(self) -> float:
        """Parameter of the last stable state as D decreases: the pull-off."""
        lowest = np.flatnonzero(self.low == self.low.min())
        return float(self.bottom[lowest[-1]])


def trace(curve: Curve) -> Track:
    """Find all folds, stable branches and jumps of a curve.

    Parameters
    ----------
    curve : Curve
        The curve.

    Returns
    -------
    Track
        Input of `follow` for any number of paths.

    Raises
    ------
    PathError
        When no part of the curve is stable.
    ConvergenceError
        When the curve is not piecewise smooth.

    Notes
    -----
    Popov & Hess (2015), ch. 4, for the rule that a contact grows while D > D(s) and shrinks while D < D(s).

    Examples
    --------
    >>> wave = Curve(lambda s: s + 2 * np.sin(s), lambda s: 1 + 2 * np.cos(s),
    ...              lambda s: 2 * np.sin(s)**2 + 2 - 2 * np.cos(s), start=0.0, stop=12.0)
    >>> np.allclose(trace(wave).turning[1:3], [2 * np.pi / 3, 4 * np.pi / 3], rtol=1e-15)
    True
    """
    turning, rising = turning_points(curve.slope, curve.start, curve.stop, curve.knots)
    stable = np.flatnonzero(rising)
    bottom, top = turning[stable], turning[stable + 1]
    level = curve.control(turning)
    proper = level[stable] < level[stable + 1]
    bottom, top, stable = bottom[proper], top[proper], stable[proper]
    low, high = level[stable], level[stable + 1]
    if stable.size == 0:
        raise PathError(
            "no part of the curve is stable under this control; extend the curve or control another quantity"
        )
    touch = float(level[0]) if curve.touch is None else max(float(curve.touch), float(level[0]))

    # beyond the last branch there is no stable state
    up, down = _first(high, upward=True), _first(low, upward=False)
    # the first branch of a flat end begins at its touch, up to rounding
    onto = np.flatnonzero((high >= touch) & (low <= touch + _ROUNDING * np.ptp(level)))[:1]
    onto = onto if onto.size else np.array([END])

    sizes = np.cumsum([up.size, down.size])
    to = np.concatenate([up, down, onto])
    at = np.concatenate([high, low, [touch]])
    before = np.concatenate([top, bottom, [curve.start]])
    after = np.full(to.size, curve.start)
    real = np.flatnonzero(to >= 0)
    goal = to[real]
    reached = np.clip(at[real], low[goal], high[goal])
    after[real] = roots_of(lambda s, D: curve.control(s) - D, bottom[goal], top[goal], reached)
    energies = curve.energy(np.concatenate([top, bottom]))
    loss = np.append(energies, curve.free_energy(touch)) - jump_energies(curve, to, at, after)
    columns = (np.split(column, sizes) for column in (to, at, before, after, loss))
    upward, downward, at_touch = (Transitions(*parts) for parts in zip(*columns, strict=True))
    return Track(curve, turning, bottom, top, low, high, touch, (upward, downward, at_touch))


def _first(limit: FloatArray, *, upward: bool) -> Index:
    """Return, for each branch, the next one whose limit is beyond its own (a stack, in one pass)."""
    n = limit.size
    to = np.full(n, END if upward else FREE)
    order = range(n - 1, -1, -1) if upward else range(n)
    stack: list[int] = []
    for i in order:
        while stack and (limit[stack[-1]] <= limit[i] if upward else limit[stack[-1]] >= limit[i]):
            stack.pop()
        if stack:
            to[i] = stack[-1]
        stack.append(i)
    return to


def jump_energies(curve: Curve, to: Index, control: FloatArray, after: FloatArray) -> FloatArray:
    """Return the potential of the states reached [J]: of the free body, or NaN where the curve ends."""
    energy = curve.energy(after)
    for i in np.flatnonzero(to < 0):
        energy[i] = curve.free_energy(float(control[i])) if to[i] == FREE else np.nan
    return energy


def settled(track: Track, parameter: float, control: float) -> tuple[float, bool]:
    """Return the stable state that an edge reaches from any parameter at a constant control, and whether it jumps.

    The contact grows while D > D(s) and shrinks while D < D(s), up to the first stable state.

    Parameters
    ----------
    track : Track
        The curve, traced.
    parameter : float
        Parameter of the edge; below the start of the curve no state supports it, and it shrinks.
    control : float
        D.

    Returns
    -------
    float, bool
        The parameter, NaN for a free body; and whether the edge has passed unstable states.

    Raises
    ------
    PathError
        When the contact grows beyond the end of the known curve.

    Examples
    --------
    >>> wave = Curve(lambda s: s + 2 * np.sin(s), lambda s: 1 + 2 * np.cos(s),
    ...              lambda s: 2 * np.sin(s)**2 + 2 - 2 * np.cos(s), start=0.0, stop=12.0)
    >>> s, jumped = settled(trace(wave), 3.5, 3.0)
    >>> round(s, 3), jumped, settled(trace(wave), 3.0, -1.0)
    (4.946, True, (nan, True))
    """
    curve = track.curve
    if parameter < curve.start:
        return np.nan, True
    if curve.control(np.array([parameter]))[0] > control:
        reached = np.flatnonzero((track.bottom < parameter) & (track.low <= control))[-1:]
        if reached.size == 0:
            return np.nan, True
    else:
        reached = np.flatnonzero((track.top >= parameter) & (track.high >= control))[:1]
        if reached.size == 0:
            raise PathError(
                f"the contact grows beyond the end of the known curve, {track.high.max()!r}; extend the profile or shorten the path"
            )
    jumped = not track.bottom[reached[0]] <= parameter <= track.top[reached[0]]
    return float(track.parameters(reached, np.array([control]))[0]), bool(jumped)
