"""Columns of the fit of a map: in memory, or in a Zarr store from which an interrupted fit continues."""

from __future__ import annotations

import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import FileError, MissingExtraError, ProblemError, PymdrError
from pymdr.problem.codec import encode
from pymdr.solving.fits.records import Records, zarr
from pymdr.solving.fits.request import ENDINGS, NOT_YET, Columns, FitRequest, FittedStretch, empty_columns
from pymdr.units import FloatArray
from pymdr.version import __version__

_STARTED, _MARK, _REFUSALS = "pymdr_begun", "pymdr_work", "pymdr_refusals"
_LONG_NAMES = {
    "noise": "standard deviation of the residuals",
    "waves": "correlated part of the residuals relative to the noise between neighbours",
    "plateau": "samples at the largest force while the depth changes",
    "samples_in_contact": "samples beyond the contact point",
    "relative_residual": "standard deviation of the residuals over the range of the force",
    "baseline_rise": "rise of the force along the baseline over the range of the force",
    "of_limit": "largest ratio of a measure of the assumptions to its limit",
    "correlated": "number of samples equivalent to one independent sample",
    "indentation": "largest indentation",
    "ending": "how the fit ended",
}


class InMemory:
    """Columns in memory."""

    def __init__(self, request: FitRequest, total: int) -> None:
        self._columns = empty_columns(request, total)
        self._refusals: frozenset[str] = frozenset()

    def has(self, first: int, last: int) -> bool:
        """Whether a stretch is finished."""
        return False

    def keep(self, first: int, last: int, fitted: FittedStretch) -> None:
        """Store a finished stretch."""
        for name, values in fitted.columns.items():
            self._columns[name][first:last] = values
        self._refusals |= fitted.refusals

    def complete(self, name: str, values: FloatArray) -> None:
        """Store a whole column."""
        self._columns[name][:] = values

    def columns(self) -> Columns:
        """All columns."""
        return self._columns

    def refusals(self) -> frozenset[str]:
        """Messages of refused curves."""
        return self._refusals


def _is_filled(folder: str) -> bool:
    """Whether a folder is there and has something in it."""
    return Path(folder).is_dir() and any(Path(folder).iterdir())


def _has_group(package: Any, url: str) -> bool:
    """Whether a store has been begun at a URL."""
    try:
        package.open_group(url, mode="r")
    except FileNotFoundError:
        return False
    return True


class Kept:
    """Columns in a Zarr store, in which a stretch is finished when its endings are written."""

    def __init__(
        self, folder: str | os.PathLike[str], request: FitRequest, records: Records, chunk: int
    ) -> None:
        from pymdr.presentation.files import named_file

        package = zarr()
        self._shape = records.shape
        is_url = isinstance(folder, str) and "://" in folder
        place = str(folder if is_url else named_file(folder, "write"))
        mark = _mark(request, records, math.prod(records.shape), chunk)
        try:
            there = _has_group(package, place) if is_url else _is_filled(place)
            attributes = dict(package.open_group(place, mode="r").attrs) if there else {_STARTED: mark}
            # an unfinished store of an interrupted fit is created again
            unfinished = _MARK not in attributes and attributes.get(_STARTED) == mark
            if not unfinished and attributes.get(_MARK) != mark:
                raise FileError(
                    f"{place} belongs to another fit: its arguments, a curve, or the version of pymdr have changed; use another folder, or empty this one"
                )
            if unfinished:
                self._group = package.create_group(place, overwrite=True, attributes={_STARTED: mark})
                self._make(request, records, chunk)
                self._group.attrs[_MARK] = mark
            else:
                self._group = package.open_group(place, mode="a")
        except (OSError, ValueError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(f"cannot write into {place}: {error}; choose another folder") from error
        except ImportError as error:  # the protocol of a URL
            raise MissingExtraError(f"cannot write into {place}: {error}") from error
        self._names = (*request.units, "ending")

    def _make(self, request: FitRequest, records: Records, chunk: int) -> None:
        inner = records.shape[1:]
        chunks = (chunk // math.prod(inner), *inner)
        for name, unit in request.units.items():
            array = self._group.create_array(
                name,
                shape=records.shape,
                chunks=chunks,
                dtype="f8",
                fill_value=math.nan,
                dimension_names=records.dims,
            )
            array.attrs.update(attributes_of(name, unit))
        ending = self._group.create_array(
            "ending",
            shape=records.shape,
            chunks=chunks,
            dtype="i1",
            fill_value=NOT_YET,
            dimension_names=records.dims,
        )
        ending.attrs.update(attributes_of("ending", ""))
        # this also rewrites the attributes of the group
        xr.Dataset(coords=records.coords, attrs=dict(self._group.attrs)).to_zarr(
            self._group.store, mode="a", consolidated=False
        )

    def _rows(self, first: int, last: int) -> slice:
        inner = math.prod(self._shape[1:])
        return slice(first // inner, last // inner)

    def has(self, first: int, last: int) -> bool:
        """Whether a stretch is finished."""
        return bool(np.all(self._group["ending"][self._rows(first, last)] != NOT_YET))

    def keep(self, first: int, last: int, fitted: FittedStretch) -> None:
        """Write a finished stretch, its endings last."""
        if fitted.refusals - self.refusals():
            self._group.attrs[_REFUSALS] = sorted(fitted.refusals | self.refusals())
        rows = self._rows(first, last)
        for name in self._names:
            self._group[name][rows] = fitted.columns[name].reshape(-1, *self._shape[1:])

    def complete(self, name: str, values: FloatArray) -> None:
        """Write a whole column."""
        self._group[name][...] = values.reshape(self._shape)

    def keep_mask(self, good: xr.DataArray) -> None:
        """Write the mask of good curves, once all are fitted."""
        attributes = dict(self._group.attrs)
        good.drop_vars(good.coords).to_dataset().assign_attrs(attributes).to_zarr(
            self._group.store, mode="a", consolidated=False
        )

    def columns(self) -> Columns:
        """All columns."""
        return {name: np.asarray(self._group[name][...]).ravel() for name in self._names}

    def refusals(self) -> frozenset[str]:
        """Messages of refused curves."""
        return frozenset(self._group.attrs.get(_REFUSALS, ()))


def _mark(request: FitRequest, records: Records, total: int, chunk: int) -> str:
    """A hash of the request, the curves and the version."""
    try:
        contact = encode(request.contact)
    except PymdrError as error:
        raise ProblemError(
            f"folder= stores the contact, which cannot be written: {error}; leave folder out, or give the "
            "profile as Sampled"
        ) from error
    work = {
        "contact": contact,
        "free": [[u.name, u.low, u.high] for u in request.unknowns],
        "known": dict(request.known),
        "shape": list(records.shape),
        "columns": list(request.units),
        "limits": dict(request.limits),
        "uncertainty": {name: str(given) for name, given in request.uncertainty.items()},
        "version": __version__,
    }
    mark = hashlib.sha256(json.dumps(work, sort_keys=True).encode())
    for first in range(0, total, chunk):
        for array in records.read(first, min(first + chunk, total)):
            if array is not None:
                mark.update(np.ascontiguousarray(array).data)
    return mark.hexdigest()


def attributes_of(name: str, unit: str) -> dict[str, Any]:
    """Attributes of a column: unit, name, and the meaning of endings."""
    attributes: dict[str, Any] = {"units": unit} if unit else {"units": ""}
    if name in _LONG_NAMES:
        attributes["long_name"] = _LONG_NAMES[name]
    if name == "ending":
        attributes = {
            **attributes,
            "flag_values": list(range(len(ENDINGS))),
            "flag_meanings": "; ".join(ENDINGS),
        }
    return attributes
