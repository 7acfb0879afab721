"""The state at a load, also as a dataset: forces, stiffnesses and areas of a solution, and of one on a coarse grid."""

from __future__ import annotations

import hashlib
import math
from typing import NamedTuple

import numpy as np

from pymdr.deferred import xr
from pymdr.independent.engines import HalfSpace, Pressing
from pymdr.problem.topography import Topography
from pymdr.solving.study import dataset
from pymdr.units import FloatArray

MAPS = {"pressure": "Pa", "gap": "m"}
"""Maps of a load, and their SI units."""
TOLERANCE = 1e-6
"""Largest gap in the contact, and penetration, over the indentation."""
_NEVER = -4.0
"""Height in indentations of pixels out of contact with a punch."""
_OUTLINE = (math.pi - 1.0 + math.log(2.0)) / 24.0
"""Excess area of the pixels of a contact per pixel side of its outline (Yastrebov et al. 2017)."""


class State(NamedTuple):
    """The state at a load in SI units; ``coarse_`` with every second pixel along both sides."""

    normal_force: float
    indentation: float
    normal_stiffness: float
    contact_area: float
    elastic_energy: float
    pixels: float
    """In contact."""
    touches_border: float
    """1 where a pixel on the border is in contact."""
    rms_slope: float
    """In the contact."""
    coarse_normal_force: float
    coarse_indentation: float
    coarse_normal_stiffness: float
    coarse_contact_area: float
    pressure: FloatArray
    gap: FloatArray

    @classmethod
    def numbers(cls) -> tuple[str, ...]:
        """Fields that are not maps."""
        return cls._fields[:-2]


class Grid:
    """Heights above a half-space, in units in which a pixel has the area 1, and E* is 1."""

    def __init__(self, half_space: HalfSpace, heights: FloatArray, spacing: FloatArray) -> None:
        self.heights = heights
        self.width = math.sqrt(spacing[0] * spacing[1])
        self._half_space = half_space

    def press(
        self, scale: float, modulus: float, *, start: FloatArray | None, **load: float | None
    ) -> tuple[Pressing, dict[str, float]]:
        """
        The solution at an indentation in m or a force in N, and its numbers in SI units.

        Parameters
        ----------
        scale : float
            Unit length in m of the heights in the engine.
        modulus : float
            E* in Pa.
        start : ndarray or None
            Initial pressure over E*.
        **load : float
            ``indentation`` or ``force``.
        """
        unit = modulus * scale * self.width
        depth, force = load.get("indentation"), load.get("force")
        solution = self._half_space.press(
            self.heights / scale,
            indentation=None if depth is None else depth / scale,
            force=None if force is None else force / unit,
            start=None if start is None else start * (self.width / scale),
            tolerance=TOLERANCE,
        )
        touching = solution.pressure > 0.0
        total = float(solution.pressure.sum()) * unit
        below = (np.max(self.heights) - self.heights)[touching] / scale
        work = 0.5 * float(np.sum(solution.pressure[touching] * (solution.indentation - below)))
        numbers = {
            "normal_force": total if force is None else force,
            "indentation": solution.indentation * scale if depth is None else depth,
            "normal_stiffness": self._punch(touching) * modulus * self.width,
            "contact_area": self._area(solution.pressure) * self.width**2,
            "elastic_energy": work * unit * scale,
        }
        return solution, numbers

    def _punch(self, touching: np.ndarray) -> float:
        """Force of the rigid punch on the contact at an indentation of 1; its pressure is never below 0."""
        flat = np.where(touching, 0.0, _NEVER)
        solution = self._half_space.press(
            flat, indentation=1.0, start=np.where(touching, 1.0, 0.0), tolerance=TOLERANCE
        )
        return float(solution.pressure.sum())

    def _area(self, pressure: FloatArray) -> float:
        """Pixels in contact less the excess of those on the outline, at least the force over the largest pressure."""
        touching = pressure > 0.0
        framed = np.pad(touching, 1).astype(int)
        outline = sum(float(np.abs(np.diff(framed, axis=axis)).sum()) for axis in (0, 1))
        count = float(np.count_nonzero(touching))
        # the correction is an average, wrong for few pixels; a mean pressure cannot exceed the largest one
        return max(count - _OUTLINE * outline, float(pressure.sum() / pressure.max()), 0.5 * count)


def rms_slope(heights: FloatArray, spacing: FloatArray, touching: np.ndarray) -> float:
    """Root mean square of the gradient in the contact."""
    along_x, along_y = np.gradient(heights, *spacing)
    return float(np.sqrt(np.mean(np.asarray(along_x**2 + along_y**2)[touching])))


def summit_rise(heights: FloatArray) -> float:
    """
    Largest height of the summit above the highest pixel, the origin of depths.

    Along x and y it is twice the rise of a parabola through the pixel and its neighbours. If the curvature at the pixel exceeds that
    next to it, as for cones and pyramids, it is the height of the intersection of the lines of both flanks, at most half of the
    difference of the neighbours, which is the rise of a cone.
    """
    place = np.unravel_index(int(np.argmax(heights)), heights.shape)
    rise = 0.0
    for axis, at in enumerate(map(int, place)):
        line = heights[:, place[1]] if axis == 0 else heights[place[0]]
        if not 0 < at < line.size - 1:
            continue
        low, middle, high = line[at - 1 : at + 2].tolist()
        bend = (middle - low) + (middle - high)
        if not bend > 0.0:
            continue
        rounded = (high - low) ** 2 / (4.0 * bend)
        if 1 < at < line.size - 2:
            lower, higher = float(line[at - 2]), float(line[at + 2])
            adjacent = min(2.0 * low - lower - middle, 2.0 * high - middle - higher)
            smooth = min(max(adjacent / bend, 0.0), 1.0)
            up, down = low - lower, high - higher
            meet = (low * down + high * up + 2.0 * up * down) / (up + down) if up + down > 0.0 else middle
            sharp = min(max(meet - middle, 0.0), 0.5 * abs(high - low))
            rounded = smooth * rounded + (1.0 - smooth) * sharp
        rise += rounded
    return rise


def as_dataset(state: State, surface: Topography) -> xr.Dataset:
    """Maps over x and y, and numbers, in SI units."""
    maps = {name: (("x", "y"), getattr(state, name), {"units": unit}) for name, unit in MAPS.items()}
    numbers = {name: ((), getattr(state, name)) for name in State.numbers()}
    return dataset(maps | numbers, coords={"x": surface.x, "y": surface.y})


def from_dataset(stored: xr.Dataset) -> State:
    """The inverse of :func:`as_dataset`."""
    numbers = {name: float(stored[name]) for name in State.numbers()}
    return State(**numbers, pressure=stored["pressure"].values, gap=stored["gap"].values)


def fingerprint(surface: Topography) -> str:
    """A digest of the heights and the size of a surface."""
    digest = hashlib.sha256(repr(surface.heights.shape).encode())
    for array in (surface.heights, surface.size):
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
