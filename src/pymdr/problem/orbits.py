"""Paths in the plane: circles and Lissajous figures of a shift or a tangential force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pymdr.errors import PathError
from pymdr.problem.paths import Path
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array, written

_CHANNELS = {"shift": "m", "tangential_force": "N"}


def circle(
    *,
    shift: QuantityLike | None = None,
    tangential_force: QuantityLike | None = None,
    turns: float = 1.0,
    steps: int | None = None,
    center: ArrayQuantityLike = (0.0, 0.0),
) -> Path:
    """
    Move the shift or the tangential force along a circle in the plane, counterclockwise.

    Parameters
    ----------
    shift, tangential_force : quantity
        Radius in m or N, above 0; exactly one of them.
    turns : float
        Number of turns; below 0 clockwise.
    steps : int, optional
        Rows along the circle, straight between rows; by default 64 per turn.
    center : pair of quantities
        Centre in m or N.

    Returns
    -------
    Path
        Of ``steps + 1`` rows. The first is center + (radius, 0), which is reached by a straight line.

    Raises
    ------
    PathError
        If not exactly one radius is given, or a value is outside its limits.

    Notes
    -----
    A polygon of n rows a turn changes the force by about 4 / n^2 of mu F_N.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.circle(shift="1 um", steps=4).shift[1:].round(9).tolist()[:2]
    [[0.0, 1e-06], [-1e-06, 0.0]]
    """
    name, radius = _one({"shift": shift, "tangential_force": tangential_force})
    size = to_si(radius, _CHANNELS[name], name=name)
    rows = _rows(steps, turns)
    return _orbit(name, np.array([size, size]), (1.0, 1.0), 0.5 * math.pi, (turns, rows), center)


def lissajous(
    *,
    shift: ArrayQuantityLike | None = None,
    tangential_force: ArrayQuantityLike | None = None,
    frequencies: Sequence[float] = (1.0, 2.0),
    phase: QuantityLike = 0.0,
    turns: float = 1.0,
    steps: int | None = None,
    center: ArrayQuantityLike = (0.0, 0.0),
) -> Path:
    """
    Move the shift or the tangential force along a Lissajous figure, (A sin(n t + phase), B sin(m t)).

    Parameters
    ----------
    shift, tangential_force : pair of quantities
        Amplitudes A and B in m or N, above 0; exactly one of them.
    frequencies : pair of float
        n and m, above 0.
    phase : quantity
        Phase of x in rad.
    turns : float
        Periods of t, 2 pi each.
    steps : int, optional
        Rows along the figure; by default 64 per turn.
    center : pair of quantities
        Centre in m or N.

    Returns
    -------
    Path
        Of ``steps + 1`` rows; the first, at t = 0, is reached by a straight line.

    Raises
    ------
    PathError
        If not exactly one pair is given, or a value is outside its limits.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.lissajous(shift=("1 um", "0.5 um"), frequencies=(1, 2), steps=8).shift[1].round(9).tolist()
    [7.07e-07, 5e-07]
    """
    name, pair = _one({"shift": shift, "tangential_force": tangential_force})
    sizes = to_si_array(pair, _CHANNELS[name], name=name)
    if sizes.shape != (2,):
        raise PathError(f"{name} = {shown(pair)}; give a pair of amplitudes along x and y")
    both = np.asarray(frequencies, dtype=float)
    if both.shape != (2,) or not np.all((both > 0.0) & np.isfinite(both)):
        raise PathError(f"frequencies = {shown(frequencies)}; give a pair of numbers above 0")
    at = to_si(phase, "rad", name="phase")
    rows = _rows(steps, turns)
    return _orbit(name, sizes, (float(both[0]), float(both[1])), at, (turns, rows), center)


def _one(given: dict[str, Any]) -> tuple[str, Any]:
    named = {name: value for name, value in given.items() if value is not None}
    if len(named) != 1:
        raise PathError("give either shift or tangential_force, for example shift='1 um'")
    return next(iter(named.items()))


def _rows(steps: int | None, turns: float) -> int:
    if not 0.0 < abs(turns) <= 1e9:
        raise PathError(f"turns = {shown(turns)}; give a number other than 0, at most 1e9")
    rows = math.ceil(64.0 * abs(turns)) if steps is None else steps
    if isinstance(rows, bool) or not isinstance(rows, int | np.integer) or rows < 1:
        raise PathError(f"steps = {shown(steps)}; a whole number of at least 1 is needed")
    return int(rows)


def _orbit(
    name: str,
    sizes: FloatArray,
    frequencies: tuple[float, float],
    phase: float,
    turns: tuple[float, int],
    center: ArrayQuantityLike,
) -> Path:
    unit = _CHANNELS[name]
    if not np.all(sizes > 0.0):
        raise PathError(f"{name} = {written(float(sizes.min()), unit)}; it must be above 0 {unit}")
    middle = to_si_array(center, unit, name="center")
    if middle.shape != (2,):
        raise PathError(f"center = {shown(center)}; give a pair (x, y)")
    angle = 2.0 * math.pi * turns[0] * np.arange(turns[1] + 1.0) / turns[1]
    x = np.sin(frequencies[0] * angle + phase)
    y = np.sin(frequencies[1] * angle)
    return Path(**{name: middle + sizes * np.stack([x, y], axis=1)})
