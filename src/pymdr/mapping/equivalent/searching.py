"""Search for the radius at which a curve on the line reaches a value, by approximate images of the slope."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.abel import Curve
from pymdr.mapping.kernels import fraction_below
from pymdr.units import FloatArray, metres

_FARTHEST = 1e100
"""Largest radius in m of the search."""
_INNERMOST = 1e-270
"""Smallest radius in m of the search downward."""
_LEAP = 1e4
"""Ratio of the target to a value above which radii are doubled."""
_BLOCK = 16
"""Steps of the search that are evaluated together."""
_FLAT, _FLATTEST = 0.3, 1e-3
"""Exponent of f below which most of its rise is close to the axis, and the smallest exponent."""
Reached: TypeAlias = Callable[[float, float, float], bool]
"""Predicate of a radius in m and the approximate g and moment there."""


@dataclass(frozen=True)
class Search:
    """
    The way outward over a slope that is not resolved yet.

    Parameters
    ----------
    slope : callable
        About f' at radii in m.
    end : float
        Radius in m beyond which there is nothing.
    exponent : float
        k of the grading.
    """

    slope: Curve
    end: float
    exponent: float

    def climb(self, start: float, reached: Reached) -> float:
        """Go down from a radius in m until a rough image is not there yet, and then up."""
        x = top = min(start, 2.0**-20 * self.end)
        finite = False
        while True:
            slope = float(self._slopes(np.array([x]))[0])
            if math.isfinite(slope):
                finite = True
                if not reached(x, 1e3 * slope * x, 1e3 * slope * x ** (2.0 + self.exponent)):
                    break
            x /= 16.0
            if x < _INNERMOST:
                raise _no_start(finite, top)
        return self.up(np.array([x / 8.0, x / 4.0, x / 2.0, x]), reached)

    def _slopes(self, r: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            return np.abs(self.slope(r))

    def up(self, radii: FloatArray, reached: Reached) -> float:
        """Go up from some radii in m while a rough image is not there yet: by quarter octaves where it may be soon."""
        r, f = radii, self._slopes(radii)
        x, (g, m) = float(r[-1]), (part[0] for part in self._images(r, f, 1))
        before = 0.0, 0.0
        while not (x >= self.end or reached(x, g, m)):
            if x > _FARTHEST:
                raise never_rises(x)
            step = _step(x, g, m, reached)
            # as far as the image would not be there if it rose like no profile does
            leap = _LEAP ** math.log2(step)
            safe = 1
            while safe < _BLOCK and not reached(x, leap ** (safe + 1) * g, leap ** (2 * safe + 2) * m):
                safe += 1
            block = np.minimum(x * step ** np.arange(1.0, safe + 1.0), self.end)
            slopes = self._slopes(block)
            r, f = np.append(r, block)[-200:], np.append(f, slopes)[-200:]
            images = self._images(r, f, safe)
            for k, (radius, slope, *image) in enumerate(zip(block, slopes, *images, strict=True), 1):
                if not math.isfinite(slope):
                    return x
                before, x, (g, m) = (g, m), float(radius), map(float, image)
                if x >= self.end or reached(x, g, m) or step != _step(x, g, m, reached):
                    r, f = r[: r.size - safe + k], f[: f.size - safe + k]
                    break
        return min(max(_between(float(r[-2]), x, before, (g, m), reached), float(radii[-1])), self.end)

    def _images(self, r: FloatArray, f: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
        """Approximate g and m at the last of some radii, from the slopes there."""
        k, x = self.exponent, r[-count:]
        with np.errstate(all="ignore"):
            s = np.minimum(r / x[:, None], 1.0)
            fractions = np.diff(np.arcsin(s) if k == 0.0 else fraction_below(s, k))
            parts = 0.5 * (f[:-1] + f[1:])
            # what is not defined farther out does not matter
            parts = np.where(fractions > 0.0, parts * fractions, 0.0)
            return x * parts.sum(axis=1) + _below(r, f), x**k * (parts @ (r[:-1] * r[1:]))


def _no_start(finite: bool, top: float) -> ProblemError:
    """The error for a profile that does not start at 0."""
    if not finite:
        return ProblemError(
            f"the slope of the profile is not finite at radii from {_INNERMOST:g} m to {metres(top)}; define its callables "
            "for all r > 0"
        )
    return ProblemError(
        f"the profile rises within {_INNERMOST:g} m of its tip too steeply to be resolved: f' grows about as 1 / r or faster, or f has a "
        "step; let f rise from f(0), or give FlatPunch for a flat end"
    )


def _below(r: FloatArray, f: FloatArray) -> float:
    """Approximate g in m of a flat tip below the first radius at which |f'| is known; 0 for other tips, where it is small."""
    n = 1.0 + math.log(f[1] / f[0]) / math.log(r[1] / r[0]) if f[0] > 0.0 and 0.0 < f[1] < math.inf else 1.0
    return float(f[0] * r[0] / max(n, _FLATTEST)) if n < _FLAT else 0.0


def _step(x: float, g: float, m: float, reached: Reached) -> float:
    return 2.0**0.25 if reached(x, _LEAP * g, _LEAP**2 * m) else 2.0


def _between(
    low: float, high: float, below: tuple[float, float], above: tuple[float, float], reached: Reached
) -> float:
    """Approximate last radius between two at which an image, a local power law, has not reached the value."""
    if not min(below) > 0.0 or not low < high:
        return low
    first, last = 0.0, 1.0
    rates = high / low, above[0] / below[0], above[1] / below[1]
    for _ in range(8):
        t = 0.5 * (first + last)
        x, g, m = (start * rate**t for start, rate in zip((low, *below), rates, strict=True))
        first, last = (first, t) if reached(x, g, m) else (t, last)
    return float(low * rates[0] ** first)


def never_rises(low: float) -> ProblemError:
    """The error for a contact without an end."""
    return ProblemError(
        f"the profile does not rise far enough up to r = {metres(low)}, where it ends or is no longer resolved, so the contact "
        "would have no edge; add FlatPunch(radius) for a cylinder with this end, or state the last radius of the "
        "profile by Function(..., max_radius=...)"
    )
