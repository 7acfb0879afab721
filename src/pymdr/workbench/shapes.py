"""Comparison of bodies that are not of revolution with boundary elements."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Path
from pymdr.problem.profiles import EllipticParaboloid, Shape
from pymdr.problem.topography import Topography
from pymdr.quantities import QUANTITIES
from pymdr.solving.press import PressedSurface, press
from pymdr.solving.shapes import pressed
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, shown, written
from pymdr.workbench.comparison import Comparison

COMPARED = (
    "normal_force",
    "force_lower_bound",
    "force_estimate",
    "normal_stiffness",
    "elastic_energy",
    "contact_area",
    "semi_axis_x",
    "semi_axis_y",
)
_OF_ENGINE = {"force_lower_bound": "normal_force", "force_estimate": "normal_force"}
"""The boundary-element quantity compared with each quantity, where their names differ."""
_FEWEST, _MOST = 33, 1025
_SPARE = 3
"""Pixels on every side between the border and the possible contact."""
_RAYS, _RADII = 256, 400
_NEAREST, _FARTHEST = 1.0 / 64.0, 4096.0
"""Radius of the search for the level of the plane, over that of the disk of the lower bound."""
_LARGER, _TRIES = 1.5, 5
_BLOCKS = 32
"""Blocks of pixels along a side; their forces displace the surface outside the grid."""
_SLACK = 1e-4
"""Penetration outside the grid that is accepted, over the depth."""
_MARGIN, _FINER = 1.1, 4
"""Margin of a grid around a place that penetrates the surface, and the largest growth of its number of pixels."""
_DEEP = 8.0
"""Depth, in indentations below the apex, of a body where it is unknown."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ShapeVerification(Comparison):
    """The method's results for a body that is not of revolution, compared with boundary elements at some indentations."""

    data: xr.Dataset
    """Over ``step``: ``indentation``; each quantity that the method has (``_mdr``) and by boundary elements (``_engine``), the
    difference relative to the latter (``_difference``), and the engine's own estimate of its relative error (``_error``). The lower
    bound and the estimate of the force are compared with its force. NaN where either is missing."""
    deepest: PressedSurface
    """What was pressed at the last step, with pressures and gaps on the grid."""
    apex: tuple[float, float]
    """Where on that grid the apex is, in m."""
    contact: Contact

    subject: ClassVar = "a verification"
    compared: ClassVar = COMPARED
    others: ClassVar = {"engine": "engine", "difference": "difference", "error": "its error"}

    def _remarks(self) -> list[str]:
        nx, ny = self.data.attrs["points"]
        lines = [f"boundary elements ({self.data.attrs['engine']}, {nx} x {ny} pixels)"]
        unknown = int(np.isnan(self.data["normal_force_engine"].values).sum())
        if unknown:
            lines.append(
                f"at {unknown} of {self.data.sizes['step']} steps the contact reaches the unknown part of the body"
            )
        return lines

    def _figure(self) -> mpl.figure.Figure:
        """Pressures by boundary elements at the last step, those along both axes, and the force over the indentation."""
        known = bool(np.isfinite(self.data["normal_force_engine"].values[-1]))
        where = {"apex_x": self.apex[0], "apex_y": self.apex[1]}
        pressures = self.deepest.field("pressure").assign_attrs(where) if known else None
        shape, hertz, axes = self.contact.profile, {}, None
        if isinstance(shape, EllipticParaboloid):
            path = Path(indentation=self.data["indentation"].values[-1:])
            result = solve(self.contact, path)
            hertz = {
                direction: result.field("pressure", angle=angle)
                for direction, angle in (("x", 0.0), ("y", math.pi / 2))
            }
            axes = float(result["semi_axis_x"][-1]), float(result["semi_axis_y"][-1])
        return plot.compared_shape(self.data, pressures, hertz, axes)


def hold_shape(
    contact: Contact,
    depths: FloatArray,
    pixels: int,
    engine: str | None,
    progress: Callable[[int, int], None] | None,
) -> ShapeVerification:
    """
    Press a shape at some indentations by the method and by boundary elements.

    A point of the body that is in contact lies no higher than the plane, for the surface is nowhere lifted above its level: f < d. The
    grid covers where that is, about the apex, and is made larger if the contact comes to its border all the same, or if another part of
    the body would penetrate the displaced surface outside the grid.

    Parameters
    ----------
    contact : Contact
        With a Shape.
    depths : ndarray
        In m, rising.
    pixels : int
        Along either side of the grid, 33 to 1025; made odd.
    engine : str or None
        As of :func:`pymdr.press`.
    """
    if isinstance(pixels, bool) or not isinstance(pixels, int) or not _FEWEST <= pixels <= _MOST:
        raise ProblemError(f"pixels = {shown(pixels)}; a whole number from {_FEWEST} to {_MOST} is needed")
    shape = contact.profile
    assert isinstance(shape, Shape)
    mdr = solve(contact, Path(indentation=depths))
    disks = pressed(contact).disks(depths)
    surfaces: list[tuple[PressedSurface, bool]] = []
    for done, (depth, radius) in enumerate(zip(depths.tolist(), disks.tolist(), strict=True)):
        surfaces.append(_pressed_at(contact, shape, depth, radius, _odd(pixels), engine))
        if progress is not None:
            progress(done + 1, depths.size)
    names = [name for name in COMPARED if name in mdr.data or name in ("normal_force", "normal_stiffness")]
    columns: dict[str, Any] = {"indentation": ("step", depths, {"units": "m"})}
    for name in names:
        mine = mdr.data[name].values if name in mdr.data else np.full(depths.size, math.nan)
        other, error = np.array([_by_engine(one, known, name) for one, known in surfaces]).T
        unit = {"units": QUANTITIES[name].unit}
        columns |= {f"{name}_mdr": ("step", mine, unit), f"{name}_engine": ("step", other, unit)}
        columns |= {f"{name}_difference": ("step", mine / other - 1.0), f"{name}_error": ("step", error)}
    last = surfaces[-1][0]
    attributes = {"engine": last.data.attrs["engine"], "points": last.data.attrs["points"]}
    i, j = np.unravel_index(int(np.argmax(last.surface.heights)), last.surface.heights.shape)
    apex = float(last.surface.x[i]), float(last.surface.y[j])
    return ShapeVerification(
        data=xr.Dataset(columns, attrs=attributes), deepest=last, apex=apex, contact=contact
    )


def _odd(count: int) -> int:
    return count + (count + 1) % 2


def _rays(radius: float) -> tuple[FloatArray, FloatArray]:
    """Places around the apex, shape (rays, radii)."""
    phi = 2.0 * math.pi * np.arange(_RAYS)[:, None] / _RAYS
    r = radius * np.geomspace(_NEAREST, _FARTHEST, _RADII)
    return r * np.cos(phi), r * np.sin(phi)


def _box(shape: Shape, depth: float, radius: float) -> FloatArray:
    """How far from the apex toward -x, +x, -y and +y the body is below the plane, or known."""
    x, y = _rays(radius)
    beyond = ~(shape.gap_at(x, y) < depth)
    first = np.where(beyond.any(axis=1), np.argmax(beyond, axis=1), _RADII - 1)
    rays = np.arange(_RAYS)
    box = _around(x[rays, first], y[rays, first])
    return np.asarray(np.maximum(box, 1e-3 * box.max()))


def _around(x: FloatArray, y: FloatArray) -> FloatArray:
    """Distances of places from the apex toward -x, +x, -y and +y."""
    return np.array([-x.min(), x.max(), -y.min(), y.max()])


def _block_forces(surface: PressedSurface) -> FloatArray:
    """Forces in N of blocks of pixels, which are forces from afar, and their places from the apex in m; shape (blocks, 3)."""
    pressure, heights, spacing = surface.maps[0][0], surface.surface.heights, surface.surface.spacing
    apex = np.unravel_index(int(np.argmax(heights)), heights.shape)
    x, y = ((np.arange(n) - at) * h for n, at, h in zip(pressure.shape, apex, spacing, strict=True))
    step = max(1, max(pressure.shape) // _BLOCKS)

    def summed(values: FloatArray) -> FloatArray:
        rows = np.add.reduceat(values, np.arange(0, values.shape[0], step), axis=0)
        return np.asarray(np.add.reduceat(rows, np.arange(0, values.shape[1], step), axis=1))

    total = summed(pressure)
    loaded = total > 0.0
    places = (summed(pressure * along)[loaded] / total[loaded] for along in (x[:, None], y[None, :]))
    return np.stack([total[loaded] * float(np.prod(spacing)), *places], axis=1)


def _box_of_entering_parts(
    surface: PressedSurface, shape: Shape, modulus: float, depth: float, box: FloatArray, radius: float
) -> FloatArray | None:
    """The box that includes other parts of the body that would penetrate the surface; None without any."""
    x, y = _rays(radius)
    low_x, high_x, low_y, high_y = box
    outside = (x < -low_x) | (x > high_x) | (y < -low_y) | (y > high_y)
    gap = shape.gap_at(x, y)
    below = outside & (gap < depth)
    if not below.any():
        return None
    x, y, gap = x[below], y[below], gap[below]
    sunk = np.zeros(x.shape)
    for force, place_x, place_y in _block_forces(surface):
        sunk += force / (math.pi * modulus * np.hypot(x - place_x, y - place_y))
    entering = gap < depth - sunk - _SLACK * depth
    if not entering.any():
        return None
    return np.asarray(np.maximum(box, _MARGIN * _around(x[entering], y[entering])))


def _pressed_at(
    contact: Contact, shape: Shape, depth: float, radius: float, pixels: int, engine: str | None
) -> tuple[PressedSurface, bool]:
    """The body pressed at one depth, and whether the contact ends within what is known of it."""
    box, count = _box(shape, depth, radius), pixels
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    for _ in range(_TRIES):
        surface, unknown = _heights(shape, depth, box, count)
        solution = press(
            surface, contact.body, contact.counterbody, indentation=depth, punch=True, engine=engine
        )
        touching = solution.maps[0][0] > 0.0
        if np.any(touching & _widened(unknown)):
            return solution, False
        if touching[:2].any() or touching[-2:].any() or touching[:, :2].any() or touching[:, -2:].any():
            box = _LARGER * box
            continue
        wider = _box_of_entering_parts(solution, shape, modulus, depth, box, radius)
        if wider is None:
            return solution, True
        # more pixels, as far as they go, so that they do not become coarser
        larger = float(np.max((wider[::2] + wider[1::2]) / (box[::2] + box[1::2])))
        count = min(_odd(math.ceil(larger * count)), _odd(_FINER * pixels), _MOST)
        box = wider
    raise PathError(
        f"at an indentation of {written(depth, 'm')} the contact is larger than the largest grid, {written(float(surface.size.max()), 'm')} wide; prescribe a smaller indentation"
    )


def _heights(shape: Shape, depth: float, box: FloatArray, count: int) -> tuple[Topography, np.ndarray]:
    """Heights with a pixel on the apex, which every second pixel has too; and where the body is not known."""
    places, spacings = [], []
    for low, high in (box[:2], box[2:]):
        spacing = (low + high) / (count - 1 - 2 * _SPARE)
        before = 2 * math.floor(0.5 * (low / spacing + _SPARE) + 0.5)
        places.append(spacing * (np.arange(count) - before))
        spacings.append(spacing)
    gap = shape.gap_at(places[0][:, None], places[1][None, :])
    unknown = np.isnan(gap)
    heights = np.where(unknown, -_DEEP * depth, -gap)
    return Topography(heights, np.array(spacings) * count), unknown


def _widened(where: np.ndarray) -> np.ndarray:
    """With the pixels next to them."""
    framed = np.pad(where, 1)
    adjacent = framed[:-2, 1:-1] | framed[2:, 1:-1] | framed[1:-1, :-2] | framed[1:-1, 2:]
    return np.asarray(where | adjacent)


def _by_engine(solution: PressedSurface, known: bool, name: str) -> tuple[float, float]:
    """A quantity by boundary elements, and the relative error that is claimed of it."""
    if not known:
        return math.nan, math.nan
    of = _OF_ENGINE.get(name, name)
    if of not in ("semi_axis_x", "semi_axis_y"):
        claim = solution.claims[of]
        return float(solution[of][0]), math.nan if claim.error is None else float(claim.error[0])
    # of an ellipse the mean of x^2 is a_x^2 / 4; its pixels have too much of area, along both axes alike
    touching = solution.maps[0][0] > 0.0
    surface, at = solution.surface, int(of == "semi_axis_y")
    places = np.arange(touching.shape[at]) * float(surface.spacing[at])
    count = touching.sum(axis=1 - at) / touching.sum()
    spread = float(count @ (places - count @ places) ** 2)
    area, error = _by_engine(solution, known, "contact_area")
    pixels = float(touching.sum()) * float(np.prod(surface.spacing))
    return 2.0 * math.sqrt(spread * area / pixels), error
