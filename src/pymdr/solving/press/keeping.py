"""States at loads as datasets, for files."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

from pymdr.problem.topography import Topography
from pymdr.solving.press.states import MAPS, State

if TYPE_CHECKING:
    import xarray as xr


def as_dataset(state: State, surface: Topography) -> xr.Dataset:
    """Maps over x and y, and numbers, in SI units."""
    import xarray as xr

    maps = {name: (("x", "y"), getattr(state, name), {"units": unit}) for name, unit in MAPS.items()}
    numbers = {name: ((), getattr(state, name)) for name in State.numbers()}
    return xr.Dataset(maps | numbers, coords={"x": surface.x, "y": surface.y})


def from_dataset(dataset: xr.Dataset) -> State:
    """The inverse of :func:`as_dataset`."""
    numbers = {name: float(dataset[name]) for name in State.numbers()}
    return State(**numbers, pressure=dataset["pressure"].values, gap=dataset["gap"].values)


def fingerprint(surface: Topography) -> str:
    """A digest of the heights and the size of a surface."""
    digest = hashlib.sha256(repr(surface.heights.shape).encode())
    for array in (surface.heights, surface.size):
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
