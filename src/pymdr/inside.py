"""Fields inside a body as labelled arrays, and their largest values; the requests of users in their units."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict

import numpy as np

from pymdr import presentation
from pymdr.deferred import mpl, xr
from pymdr.errors import NotValidError, ProblemError, QuantityError
from pymdr.interpretation.interior import (
    SPATIAL_COMPONENTS,
    Background,
    Interior,
)
from pymdr.interpretation.searching import Largest
from pymdr.quantities import ACROSS, ALONG, DEPTH, RADIUS, Quantity, one_name, quantity
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array

if TYPE_CHECKING:
    from pathlib import Path as FilePath


_POINTS = 101
"""Points of an axis that is not given."""
_TENSOR = SPATIAL_COMPONENTS["stress"]

Superposed: TypeAlias = Mapping[str, QuantityLike | Callable[[FloatArray], Any]]
"""Components of a stress by name, each a quantity or a function of the depths in m that gives Pa."""


class Inside(TypedDict, total=False):
    """Places at which a field inside a body is read."""

    x: ArrayQuantityLike | None
    """Positions in m in the direction of the shift."""
    y: ArrayQuantityLike | None
    """Positions in m across it."""
    z: ArrayQuantityLike | None
    """Depths in m, at least 0."""
    side: str | None
    """"body" or "counterbody"."""
    superposed: Superposed | None
    """A stress that the contact does not cause."""


def checked(inside: Inside, name: str, *, within: bool) -> Inside:
    """The given places; refuse places for a field that is not inside a body."""
    given: Inside = {}
    for key, value in inside.items():
        if value is not None:
            given[key] = value  # type: ignore[literal-required]
    if given and not within:
        raise QuantityError(
            f"{', '.join(f'{key}=' for key in given)} {'is' if len(given) == 1 else 'are'} for fields inside a body; "
            f"{shown(name)} is not one"
        )
    return given


def background_of(superposed: Superposed | None) -> Background | None:
    """
    A superposed stress as a function of depth.

    Parameters
    ----------
    superposed : mapping or None
        Components xx, yy, zz, xz, xy, yz by name: each a quantity in Pa, or a function of an array of depths in m that
        gives Pa. Components that are not named are 0.
    """
    if superposed is None:
        return None
    if not isinstance(superposed, Mapping) or not superposed or not set(superposed) <= set(_TENSOR):
        raise ProblemError(
            f"superposed = {shown(superposed)}: components by name are needed ({', '.join(_TENSOR)}), such as "
            '{"xx": "100 MPa"}'
        )
    parts = {
        name: value if callable(value) else to_si(value, "Pa", name=f"superposed[{name!r}]")
        for name, value in superposed.items()
    }

    def added(z: FloatArray) -> FloatArray:
        tensor = np.zeros((len(_TENSOR), *z.shape))
        for name, value in parts.items():
            values = np.asarray(value(z) if callable(value) else value, dtype=float)
            if values.shape not in ((), z.shape) or not np.isfinite(values).all():
                raise ProblemError(
                    f"superposed[{name!r}]: one finite stress in Pa is needed for each of {z.size} depths, or one for all; the "
                    f"function gives the shape {values.shape}"
                )
            tensor[_TENSOR.index(name)] = values
        return tensor

    return added


def interior_field(
    interior: Interior,
    name: str,
    r: ArrayQuantityLike | None,
    inside: Inside,
    rows: tuple[list[int], bool],
) -> xr.DataArray:
    """
    A field inside a body.

    Parameters
    ----------
    r : array_like, quantity or None
        Radii in m, for fields of revolution.
    rows : list of int, bool
        Steps, and whether they become a dimension.

    Returns
    -------
    xarray.DataArray
        Over ``z`` and ``r``, or over ``z``, ``y`` if it is given, and ``x``.
    """
    (chosen, several), row = rows, quantity(name)
    background = background_of(inside.get("superposed"))
    if background is not None and name == "interior_displacement":
        raise QuantityError(
            "superposed= is a stress; leave it out, or read stress instead of interior_displacement"
        )
    planar = "x" in inside or "y" in inside
    if r is not None and (planar or background is not None or not interior.revolves):
        reason = (
            "r= and x=, y= are given; give one of them"
            if planar
            else "with friction or a superposed stress the field is not of revolution; give x= (and y=) instead of r="
        )
        raise QuantityError(str(reason))
    flat = interior.revolves and not planar and background is None
    end = 2.0 * interior.load(chosen[-1]).radius or 1.0
    depth = _axis(inside.get("z"), DEPTH, interior.depths(end))
    if not np.all(depth >= 0.0):
        raise QuantityError(
            f"z = {shown(inside['z'])}; it must be at least 0 m (depths count into each body)"
        )
    scalars: dict[str, Any] = {}
    if flat:
        radius = _axis(r, RADIUS, np.linspace(0.0, end, _POINTS))
        axes = {"z": depth, "r": radius}
        grid = np.meshgrid(depth, np.abs(radius), indexing="ij")
        values = np.array([interior.field(name, grid[1], grid[0], i) for i in chosen])
        components = interior.components
    else:
        x = _axis(inside.get("x"), ALONG, np.linspace(-end, end, 2 * _POINTS - 1))
        y = _axis(inside.get("y"), ACROSS, np.zeros(1))
        z, across, along = np.meshgrid(depth, y, x, indexing="ij")
        axes = {"z": depth, "y": y, "x": x}
        values = np.array([interior.spatial(name, (along, across, z), i, background) for i in chosen])
        if "y" not in inside:
            values, scalars = (
                values[..., 0, :],
                {"y": ((), 0.0, {"units": "m", "long_name": ACROSS.long_name})},
            )
            del axes["y"]
        components = SPATIAL_COMPONENTS
    labels = {axis.name: axis.long_name for axis in (DEPTH, RADIUS, ALONG, ACROSS)}
    coords: dict[str, Any] = {
        axis: (axis, at, {"units": "m", "long_name": labels[axis]}) for axis, at in axes.items()
    }
    coords |= scalars
    layers = interior.layers_at(depth[:, None])
    if layers is not None:
        coords["layer"] = ("z", layers[:, 0], {"long_name": "layer, from 0 at the surface"})
    coords["step"] = ("step", np.array(chosen)) if several else chosen[0]
    dims: tuple[str, ...] = ("step",) * several
    if name in components:
        coords["component"] = ("component", list(components[name]))
        dims = (*dims, "component")
    return xr.DataArray(
        values if several else values[0],
        dims=(*dims, *axes),
        coords=coords,
        name=name,
        attrs={"units": row.unit, "long_name": row.long_name, "symbol": row.symbol},
    )


def _axis(given: ArrayQuantityLike | None, axis: Quantity, otherwise: FloatArray) -> FloatArray:
    values = otherwise if given is None else np.atleast_1d(to_si_array(given, "m", name=axis.name))
    if values.ndim != 1:
        raise QuantityError(f"{axis.name} has the shape {values.shape}; one row is needed")
    return values


def largest_in(
    interior: Interior,
    name: str,
    superposed: Superposed | None,
    rows: tuple[list[int], bool],
    valid: np.ndarray,
) -> xr.DataArray:
    """
    The largest value of a measure of stress in rows, with its place.

    Parameters
    ----------
    name : str
        One of :attr:`Interior.measures <pymdr.interpretation.interior.Interior.measures>`.
    rows : list of int, bool
        Steps, and whether they become a dimension.
    """
    if one_name(name) not in interior.measures:
        raise QuantityError(f"no measure {shown(name)}; give one of {', '.join(interior.measures)}")
    (chosen, several), background = rows, background_of(superposed)
    peaks = np.full((len(chosen), len(Largest._fields)), np.nan)
    known = [k for k, i in enumerate(chosen) if valid[i]]
    if known:
        peaks[known] = interior.largest_of(name, [chosen[k] for k in known], background)
    unbounded = np.isinf(peaks[:, 0])
    touching = (peaks[:, 0] != 0.0) & ~np.isnan(peaks[:, 0])
    if touching.any() and unbounded[touching].all():
        why = interior.unbounded(chosen[int(np.flatnonzero(touching)[-1])])
        raise NotValidError(f"the largest {quantity(name).long_name} is not valid here: {why}")
    dims = ("step",) * several
    values, r, z, angle, layer = peaks.T if several else peaks[0]
    places = {"r": (r, "radius"), "z": (z, "depth")}
    if background is not None or not interior.revolves:
        # the sine of pi is not exactly 0
        across = np.where(np.abs(angle) == np.pi, 0.0, r * np.sin(angle))
        places = {"x": (r * np.cos(angle), "x"), "y": (across, "y"), "z": (z, "depth")}
    coords: dict[str, Any] = {
        axis: (dims, at, {"units": "m", "long_name": f"{words} of the largest value"})
        for axis, (at, words) in places.items()
    }
    if interior.layers_at(np.zeros(1)) is not None:
        coords["layer"] = (dims, layer, {"long_name": "layer of the largest value, from 0 at the surface"})
    return xr.DataArray(
        values,
        dims=dims,
        coords={"step": (dims, np.array(chosen) if several else chosen[0]), **coords},
        name=name,
        attrs={"units": "Pa", "long_name": f"largest {quantity(name).long_name}"},
    )


def point_columns(fields: Sequence[xr.DataArray]) -> dict[str, np.ndarray]:
    """
    Fields at the same points as columns of a table, one row per point.

    Returns
    -------
    dict of str to ndarray
        By title with its unit: the axes, then every component of every field.
    """
    axes = [str(dim) for dim in fields[0].dims if dim != "component"]
    grids = np.meshgrid(*(fields[0][axis].values for axis in axes), indexing="ij")
    columns = {f"{axis} [m]": grid.ravel() for axis, grid in zip(axes, grids, strict=True)}
    for field in fields:
        own = [(field, str(field.name))]
        if "component" in field.dims:
            own = [(field.sel(component=c), f"{field.name}_{c}") for c in field["component"].values.tolist()]
        columns |= {f"{name} [{one.attrs['units']}]": one.values.ravel() for one, name in own}
    return columns


DRAWN = ("von_mises", "tresca", "principal_stress", "hydrostatic")
"""Measures that figures show."""
_SURFACE_POINTS = 241
"""Points of a line along the surface; those at the edges are added."""


def drawn_section(
    interior: Interior, name: str, row: int, superposed: Superposed | None = None
) -> mpl.figure.Figure:
    """
    A measure of stress in section along the shift, with the contact and the place of its largest value.

    Parameters
    ----------
    name : str
        One of :data:`DRAWN`.
    """
    load = interior.load(row)
    bodies = [_drawn_body("body", interior, name, row, superposed, 2.0 * load.radius or 1.0)]
    return presentation.plot.stress_section(bodies, load.edge_radius, load.radius)


def drawn_stress(
    interiors: Mapping[str, Interior], name: str, row: int, superposed: Superposed | None = None
) -> mpl.figure.Figure:
    """
    A measure of stress in section in one body or both, with the components on the axis and at the surface.

    Parameters
    ----------
    name : str
        One of :data:`DRAWN`.
    """
    _check_drawn(name)
    load = next(iter(interiors.values())).load(row)
    end, bodies = 2.0 * load.radius or 1.0, []
    for side, interior in interiors.items():
        body = _drawn_body(side, interior, name, row, superposed, end)
        axis, surface = _lines(interior, row, superposed, end)
        bodies.append(replace(body, axis=axis, surface=surface))
    return presentation.plot.stress_figure(bodies, load.edge_radius, load.radius)


def _check_drawn(name: str) -> None:
    if name not in DRAWN:
        raise QuantityError(f"no figure {shown(name)}; stress is drawn as {', '.join(DRAWN)}")


def _drawn_body(
    side: str, interior: Interior, name: str, row: int, superposed: Superposed | None, end: float
) -> presentation.plot.StressedBody:
    """A body as figures show it: a section down to `end`, and the largest value."""
    places = Inside(z=interior.depths(end)) | ({} if superposed is None else Inside(superposed=superposed))
    flat = interior.revolves and superposed is None
    if flat:
        radii = np.linspace(0.0, end, _POINTS)
    else:
        radii, places = None, places | Inside(x=np.linspace(-end, end, 2 * _POINTS - 1))
    rows = [row], False
    field = interior_field(interior, name, radii, places, rows)
    if name == "principal_stress":
        field = field.sel(component="1")
    largest, unbounded = None, ""
    if interior.load(row).radius > 0.0 and interior.singular_radius(row) is not None:
        unbounded = "at the edge" if interior.singular_radius(row) else "under the tip"
    elif name in interior.measures and interior.load(row).radius > 0.0:
        largest = largest_in(interior, name, superposed, rows, np.ones(row + 1, dtype=bool))
    return presentation.plot.StressedBody(side, field, largest, unbounded)


def _lines(
    interior: Interior, row: int, superposed: Superposed | None, end: float
) -> tuple[xr.DataArray, xr.DataArray]:
    """Components on the axis, and at the surface through both edges."""
    added = Inside() if superposed is None else Inside(superposed=superposed)
    flat = interior.revolves and superposed is None
    edges = np.array(sorted({m for m in interior.marks(row) if 0.0 < m <= end}))
    across = np.unique(np.concatenate([np.linspace(0.0, end, _SURFACE_POINTS), edges]))
    if not flat:
        across = np.concatenate([-across[:0:-1], across])
    values = []
    for at, depths in ((np.zeros(1), interior.depths(end)), (across, np.zeros(1))):
        places = Inside(z=depths) | added | (Inside() if flat else Inside(x=at))
        values.append(interior_field(interior, "stress", at if flat else None, places, ([row], False)))
    along = "r" if flat else "x"
    return values[0].isel({along: 0}), values[1].isel(z=0)


def animated_stress(
    interiors: Mapping[str, Interior],
    measure: tuple[str, Superposed | None],
    rows: Sequence[int],
    history: tuple[xr.DataArray, xr.DataArray],
    file: FilePath,
) -> None:
    """
    Write a measure of stress in section over rows as a GIF.

    Parameters
    ----------
    measure : tuple
        One of :data:`DRAWN`, and a stress that is added or None.
    rows : sequence of int
        In contact.
    history : tuple of xarray.DataArray
        Abscissa and ordinate of the curve next to the section, over all rows.
    file : path
        Ends with ``.gif``.
    """
    name, superposed = measure
    _check_drawn(name)
    loads = {row: next(iter(interiors.values())).load(row) for row in rows}
    end = 2.0 * max(load.radius for load in loads.values())
    frames = [
        presentation.plot.StressFrame(
            [_drawn_body(side, interior, name, row, superposed, end) for side, interior in interiors.items()],
            (loads[row].edge_radius, loads[row].radius),
        )
        for row in rows
    ]
    presentation.plot.write_stress_animation(frames, history, np.array(rows), file)
