"""Pressed surfaces from files."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymdr.errors import FileError, PymdrError
from pymdr.interpretation.conductance import CONDUCTIONS
from pymdr.interpretation.validity import Assumption, Claim, Level
from pymdr.problem.topography import Topography
from pymdr.solving.press.states import MAPS
from pymdr.solving.press.value import FORMAT, PressedSurface

if TYPE_CHECKING:
    import os

    import xarray as xr
    from pydantic import TypeAdapter


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
    from pymdr.presentation.files import read_dataset

    dataset = read_dataset(file)
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
        raise FileError(f"the claim of {name} has another number of loads")
    return Claim(Level[plain["level"]], plain["reason"], plain["source"], where, error)
