"""Steps of f on the axis and at breakpoints, where f is sampled on each side separately."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.callables.noise import Curve, rounding
from pymdr.units import FloatArray, metres

_TO_AXIS, _TO_BREAKPOINT = 2.0 ** -np.arange(0.0, 61.0), 2.0 ** -np.arange(3.0, 48.0)
"""Distances at which a step is searched, over the radius."""
_LEVEL, _LAST = 1e-3, 8
"""Relative change of a step over the last distances that is accepted: a power of the distance above 0.0002 changes by
more."""
_ROUNDINGS = 64.0
_MEANT = 1e-6
"""Step at a breakpoint, in parts of the profile, up to which it is a constant of few digits: its error, and no edge."""
_APEX = 1e-9
"""The same on the axis, where it is only an offset."""
_AFTER = 1.03
"""Radius, over the breakpoint, at which the rounding beyond it is measured without crossing it."""


def step_refused(radius: float, step: float) -> ProblemError:
    """The error for a jump of f by `step` at a radius, both in m."""
    return ProblemError(
        f"the profile jumps by {metres(step)} at r = {metres(radius)}: a step is not a disk contact; use FlatPunch for a "
        f"sharp edge there, Function(...) + FlatPunch({radius:.6g}), or take the step out of f"
    )


class Steps:
    """
    Steps of f on the axis and at breakpoints, each checked once, when a contact reaches it.

    Parameters
    ----------
    f : callable
        Taking and giving arrays, in m.
    """

    def __init__(self, f: Curve) -> None:
        self._f = f
        self._seen = -1.0
        self._slight: list[tuple[float, float]] = []

    def refuse(self, top: float, breakpoints: Sequence[float]) -> None:
        """
        Check the axis and those of some rising breakpoints in m that lie below `top` in m.

        Raises
        ------
        ProblemError
            With the size of a step, the radius and the remedy.
        """
        for b in (0.0, *breakpoints):
            if self._seen < b < top:
                with np.errstate(all="ignore"):
                    self._look(b, top)
        self._seen = max(self._seen, math.nextafter(top, 0.0))

    def _look(self, b: float, top: float) -> None:
        """Check f for a step at a radius; refuse one."""
        if b == 0.0:
            r = top * _TO_AXIS
            rise = self._f(np.append(r, 0.0))
            rise = rise[:-1] - rise[-1]
            step, size = _level(rise), float(np.max(np.abs(rise[:4])))
            # what cancels is no step: the rise is to stand out of the rounding all the way
            if abs(step) > _APEX * size and np.all(np.abs(rise) > _ROUNDINGS * rounding(self._f, r)):
                raise ProblemError(
                    f"f(r) jumps by {metres(step)} at r = 0, from f(0) to its values next to the axis; make f(0) its "
                    "limit there, for example with numpy.where"
                )
            return
        away = np.concatenate([b * (1.0 - _TO_BREAKPOINT), b * (1.0 + _TO_BREAKPOINT)])
        before, after = self._f(away).reshape(2, -1)
        difference = after - before
        nearby = np.array([away[_TO_BREAKPOINT.size - 1], _AFTER * b])
        noise = float(np.nanmax(rounding(self._f, nearby), initial=0.0))
        # without what slopes make of the distance
        step = _level(2.0 * difference[1:] - difference[:-1], noise)
        if not abs(step) > _ROUNDINGS * noise:
            return
        around = self._f(b * np.array([0.0, 0.5, 1.0, 1.2]))
        size = np.abs(around[1:] - around[0])
        if abs(step) > _MEANT * float(np.max(size[np.isfinite(size)], initial=0.0)):
            raise step_refused(b, step)
        self._slight.append((b, abs(step)))

    def errors(self, base: FloatArray, low: FloatArray, width: FloatArray) -> FloatArray:
        """Errors of f' on panels by small steps, on all panels that begin at them, shape (P,)."""
        total = np.zeros(base.shape)
        for b, step in self._slight:
            total += np.where((base == b) & (low == 0.0), step / width, 0.0)
        return total


def _level(values: FloatArray, noise: float = 0.0) -> float:
    """Limit of values at decreasing distances; 0 where they keep changing by more than noise."""
    last = values[-_LAST:]
    level = float(last[-1])
    steady = math.isfinite(level) and bool(np.all(np.abs(last - level) <= _LEVEL * abs(level) + 8.0 * noise))
    return level if steady else 0.0
