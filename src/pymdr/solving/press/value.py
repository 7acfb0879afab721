"""The result of pressing a surface, also from files."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from pymdr import presentation
from pymdr.deferred import mpl, xr
from pymdr.errors import FileError, NotValidError, PathError, PymdrError, QuantityError
from pymdr.interpretation.closure import error_of_force, known_error
from pymdr.interpretation.conductance import CONDUCTIONS
from pymdr.interpretation.validity import Assumption, Claim, Level
from pymdr.presentation import plot
from pymdr.problem.profiles import ForceCurve
from pymdr.problem.profiles.forcecurve import FEWEST_POINTS
from pymdr.problem.topography import Topography
from pymdr.quantities import one_name
from pymdr.solving.press.states import MAPS
from pymdr.solving.study import Column, Study
from pymdr.units import FloatArray, shown, written

if TYPE_CHECKING:
    from pydantic import TypeAdapter

FORMAT = "pymdr pressed surface 1"
_FIELDS = {**MAPS, "contact": ""}


_WITH_ERRORS = (
    "normal_force",
    "indentation",
    "normal_stiffness",
    "contact_area",
    "thermal_conductance",
    "electrical_resistance",
)
"""Columns whose errors the summary prints."""


@dataclass(frozen=True, kw_only=True)
class PressedSurface(Study):
    """Force, indentation, stiffness and area of a pressed surface, with its pressures and gaps."""

    data: xr.Dataset
    """
    Over ``normal_force`` (N) or ``indentation`` (m) of the highest pixel: the other of the two, normal_stiffness (N/m),
    contact_area (m^2), mean_pressure and peak_pressure (Pa), elastic_energy (J); where the bodies say what they conduct
    thermal_conductance (W/K) and electrical_resistance (ohm), by the stiffness.
    """
    surface: Topography
    maps: tuple[tuple[FloatArray, FloatArray], ...]
    """Pressures in Pa and gaps in m of the loads, (nx, ny)."""

    subject: ClassVar = "a pressed surface"
    columns: ClassVar = {
        "normal_force": Column("F_N", "N"),
        "indentation": Column("depth", "m"),
        "normal_stiffness": Column("stiffness", "N/m"),
        "contact_area": Column("area", "m^2"),
        "mean_pressure": Column("p_m", "Pa"),
        "peak_pressure": Column("p_max", "Pa"),
        "elastic_energy": Column("energy", "J"),
        "thermal_conductance": Column("conductance", "W/K"),
        "electrical_resistance": Column("resistance", "ohm"),
    }
    summary_claims: ClassVar = ("normal_stiffness", "contact_area")

    def field(self, name: str, step: int = -1) -> xr.DataArray:
        """
        A map over the pixels.

        Parameters
        ----------
        name : str
            ``"pressure"`` in Pa, ``"gap"`` in m, or ``"contact"``, whether a pixel is in contact.
        step : int, optional
            Index of the load; the last one by default.

        Returns
        -------
        xarray.DataArray
            Over ``x`` and ``y`` in m.

        Raises
        ------
        QuantityError
            If there is no such map, or load.
        NotValidError
            If the contact reaches the border of the heights at this load.
        """
        if one_name(name) not in _FIELDS:
            raise QuantityError(f"no field {shown(name)}; {self.subject} has {', '.join(_FIELDS)}")
        self._refuse_step(step)
        claim = self.claims["normal_stiffness"]
        if not claim.where[step]:
            raise NotValidError(
                f"{name} is not valid at load {int(step) % len(self.maps) + 1}: {claim.reason} [{claim.source}]"
            )
        pressure, gap = self.maps[step]
        values = {"pressure": pressure, "gap": gap, "contact": pressure > 0.0}[name]
        axes = {axis: (axis, getattr(self.surface, axis), {"units": "m"}) for axis in ("x", "y")}
        return xr.DataArray(values, dims=("x", "y"), coords=axes, name=name, attrs={"units": _FIELDS[name]})

    def _refuse_step(self, step: int) -> None:
        count = len(self.maps)
        if isinstance(step, bool) or not isinstance(step, int | np.integer) or not -count <= step < count:
            raise QuantityError(f"step = {shown(step)}; there are {count} loads, counted from 0")

    def force_curve(self) -> ForceCurve:
        """
        F(d) as a profile, for friction, memory, impacts and conductance of the same surface.

        Returns
        -------
        ForceCurve
            For bodies of E* = ``data.attrs["modulus"]``; forces are proportional to E*. Its points have the errors of the claims.

        Raises
        ------
        NotValidError
            If the contact reaches the border of the heights at every load.
        PathError
            If there are fewer than 5 loads at which the contact ends within the heights.
        """
        depth, force = self["indentation"].values, self["normal_force"].values
        errors = [known_error(self.claims[name]) for name in ("indentation", "normal_force")]
        known = self.claims["normal_stiffness"].where
        depth, places = np.unique(depth[known], return_index=True)
        if depth.size < FEWEST_POINTS:
            raise PathError(
                f"only {depth.size} loads have a contact that ends within the heights; at least {FEWEST_POINTS} different ones "
                "are needed; press at more loads, denser toward the first touch"
            )
        force = force[known][places]
        error = error_of_force(depth, force, *(each[known][places] for each in errors))
        return ForceCurve(depth, force, self.data.attrs["modulus"], contact_point=0.0, error=error)

    def _stored(self) -> xr.Dataset:
        """The study with maps and heights; :func:`pymdr.open_pressed_surface` reads the file."""
        surface, (load,) = self.surface, self.data.sizes
        maps = {
            name: ((load, "x", "y"), np.stack(arrays), {"units": MAPS[name]})
            for name, arrays in zip(MAPS, zip(*self.maps, strict=True), strict=True)
        }
        heights = {"heights": (("x", "y"), surface.heights, {"units": "m"})}
        stored = super()._stored().assign(maps | heights).assign_coords(x=surface.x, y=surface.y)
        for name in MAPS:
            # most pixels are out of contact
            stored[name].encoding = {"zlib": True}
        as_json = json.loads(stored.attrs["pymdr_metadata"]) | {"steps": surface.steps}
        return stored.assign_attrs(pymdr_format=FORMAT, pymdr_metadata=json.dumps(as_json))

    def _remarks(self) -> list[str]:
        attrs = self.data.attrs
        nx, ny = attrs["points"]
        errors = [
            f"{self.columns[name].label} {' to '.join(dict.fromkeys(f'{100.0 * float(end(e)):.2g}' for end in (np.nanmin, np.nanmax)))} %"
            for name in _WITH_ERRORS
            if name in self.claims and (e := self.claims[name].error) is not None
        ]
        return [
            f"{attrs['engine']}, {nx} x {ny} pixels",
            *([f"errors of the grid: {', '.join(errors)}"] if errors else []),
        ]

    def plot(self, step: int = -1) -> mpl.figure.Figure:
        """
        Contact and pressures at a load, force against depth and stiffness against force.

        Parameters
        ----------
        step : int, optional
            Index of the load; the last one by default. If it is not valid, the largest valid one is drawn; the title names it.

        Raises
        ------
        QuantityError
            If there is no such load.
        """
        return plot.with_unmet(self._figure(step), self.assumptions)

    def _figure(self, step: int = -1) -> mpl.figure.Figure:
        self._refuse_step(step)
        claim, (over,) = self.claims["normal_stiffness"], self.data.dims
        loads = self.data[over].values
        if not claim.where.any():
            return plot.pressed_surface(
                self.data, self.surface.heights, None, f"not valid at any load: {claim.reason}"
            )
        row = int(step) % loads.size
        if not claim.where[row]:
            row = int(np.argmax(np.where(claim.where, loads, -np.inf)))
        load = written(float(loads[row]), self.columns[str(over)].unit)
        title = f"{over} {load}, load {row + 1} of {loads.size}".replace("_", " ")
        return plot.pressed_surface(self.data, self.surface.heights, self.field("pressure", row), title)


@lru_cache(maxsize=1)
def _schema() -> TypeAdapter[Any]:
    """The schema of the JSON text in the attributes."""
    from pydantic import TypeAdapter, create_model

    level: Any = Literal[tuple(level.name for level in Level)]
    claim: Any = create_model(
        "claim",
        level=(level, ...),
        reason=(str, ...),
        source=(str, ...),
        where=(list[bool], ...),
        error=(list[float] | None, ...),
    )
    assumption: Any = create_model(
        "assumption", name=(str, ...), description=(str, ...), measure=(float, ...), limit=(float, ...)
    )
    return TypeAdapter(
        create_model(
            "attributes",
            claims=(dict[str, claim], ...),
            assumptions=(list[assumption], ...),
            notes=(list[str], ...),
            steps=(list[str], ...),
        )
    )


def open_pressed_surface(file: str | os.PathLike[str]) -> PressedSurface:
    """
    Read a pressed surface that :meth:`~pymdr.solving.press.PressedSurface.save` wrote.

    Parameters
    ----------
    file : path
        NetCDF file.

    Returns
    -------
    PressedSurface
        With the numbers, maps, heights, claims and assumptions that were saved.

    Raises
    ------
    FileError
        If the file is missing, damaged or not a pressed surface.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.open_pressed_surface("missing.nc")
    Traceback (most recent call last):
    pymdr.errors.FileError: cannot read 'missing.nc': no such file
    """
    dataset = presentation.files.read_dataset(file)
    if dataset.attrs.get("pymdr_format") != FORMAT:
        raise FileError(
            f"{file} is not a pressed surface: its format is {dataset.attrs.get('pymdr_format')!r}, {FORMAT!r} is needed; "
            "write it with PressedSurface.save"
        )
    try:
        return _pressed(dataset)
    except (LookupError, ValueError, TypeError, RecursionError, PymdrError) as error:
        raise FileError(f"{file} is a damaged pressed surface: {error}") from error


def _pressed(dataset: xr.Dataset) -> PressedSurface:
    """The inverse of :meth:`~pymdr.solving.press.PressedSurface.save`."""
    attrs = dataset.attrs
    stored = _schema().validate_json(attrs["pymdr_metadata"]).model_dump()
    (load,) = (name for name in map(str, dataset.dims) if name not in ("x", "y"))
    count = dataset.sizes[load]
    surface = Topography(dataset["heights"].values, attrs["size"], tuple(stored["steps"]))
    pressures, gaps = (dataset[name].transpose(load, "x", "y").values for name in MAPS)
    data = dataset.drop_vars([*MAPS, "heights", "x", "y"]).assign_attrs(
        modulus=float(attrs["modulus"]),
        engine=str(attrs["engine"]),
        points=surface.heights.shape,
        size=tuple(surface.size.tolist()),
        tolerance=float(attrs["tolerance"]),
    )
    for name in ("pymdr_format", "pymdr_metadata", "pymdr_checksum"):
        data.attrs.pop(name, None)
    claims = {name: _claim(name, plain, count) for name, plain in stored["claims"].items()}
    conducted = {each.quantity for each in CONDUCTIONS}
    missing = [name for name in PressedSurface.columns if name not in claims and name not in conducted]
    missing += [name for name, claim in claims.items() if claim.readable and name not in data.variables]
    if missing:
        raise FileError(f"it has no claims or data of {', '.join(missing)}")
    return PressedSurface(
        data=data,
        surface=surface,
        maps=tuple(zip(pressures, gaps, strict=True)),
        claims=claims,
        assumptions=tuple(Assumption(**plain) for plain in stored["assumptions"]),
        notes=tuple(stored["notes"]),
    )


def _claim(name: str, plain: dict[str, Any], count: int) -> Claim:
    where = np.array(plain["where"], dtype=bool)
    error = None if plain["error"] is None else np.array(plain["error"], dtype=float)
    if where.shape != (count,) or (error is not None and error.shape != (count,)):
        raise FileError(f"the claim of {name} has the wrong number of loads")
    return Claim(Level[plain["level"]], plain["reason"], plain["source"], where, error)
