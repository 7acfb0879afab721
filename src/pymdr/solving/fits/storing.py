"""Where what was found in a map stands: in memory, or in a store of Zarr from which a killed fit goes on."""

from __future__ import annotations

import hashlib
import json
import math
import os
from importlib.metadata import version
from typing import Any

import numpy as np

from pymdr.errors import FileError, ProblemError, PymdrError
from pymdr.problem.codec import encode
from pymdr.solving.fits.asking import ENDINGS, NOT_YET, Asked, Columns, FittedStretch, empty_columns
from pymdr.solving.fits.records import Records, zarr
from pymdr.units import FloatArray

_BEGUN, _MARK, _REFUSALS = "pymdr_begun", "pymdr_work", "pymdr_refusals"
_WORDS = {
    "noise": "standard deviation of the residuals",
    "waves": "what of the residuals hangs together, in parts of the noise between neighbours",
    "plateau": "samples at the largest force while the depth changes",
    "of_limit": "largest measure of what the model assumes, in parts of its limit",
    "correlated": "samples that tell as much as an independent one",
    "indentation": "largest indentation",
    "ending": "how the fit ended",
}


class Held:
    """Columns in memory."""

    def __init__(self, asked: Asked, total: int) -> None:
        self._columns = empty_columns(asked, total)
        self._refusals: frozenset[str] = frozenset()

    def has(self, first: int, last: int) -> bool:
        """Whether a stretch is finished."""
        return False

    def keep(self, first: int, last: int, fitted: FittedStretch) -> None:
        """Put a finished stretch in its place."""
        for name, values in fitted.columns.items():
            self._columns[name][first:last] = values
        self._refusals |= fitted.refusals

    def complete(self, name: str, values: FloatArray) -> None:
        """Put a whole column in its place."""
        self._columns[name][:] = values

    def columns(self) -> Columns:
        """All of them."""
        return self._columns

    def refusals(self) -> frozenset[str]:
        """What curves that were refused were told."""
        return self._refusals


class Kept:
    """Columns in a Zarr store, in which a stretch is finished when its endings are written."""

    def __init__(self, folder: str | os.PathLike[str], asked: Asked, records: Records, chunk: int) -> None:
        from pymdr.presentation.files import named_file

        package = zarr()
        self._shape = records.shape
        place, total = named_file(folder, "write"), math.prod(records.shape)
        mark = _mark(asked, records, total, chunk)
        try:
            there = place.exists() and any(place.iterdir())
            held = dict(package.open_group(str(place), mode="r").attrs) if there else {_BEGUN: mark}
            # a store that was begun and not finished, when the work was killed, is made anew
            begun = _MARK not in held and held.get(_BEGUN) == mark
            if not begun and held.get(_MARK) != mark:
                raise FileError(
                    f"{place} holds another work: something that was asked, one of the curves, or the version of pymdr has changed since; take another folder, or empty "
                    "this one"
                )
            if begun:
                self._group = package.create_group(str(place), overwrite=True, attributes={_BEGUN: mark})
                self._make(asked, records, chunk)
                self._group.attrs[_MARK] = mark
            else:
                self._group = package.open_group(str(place), mode="a")
        except (OSError, ValueError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(f"cannot write into {place}: {error}; choose another folder") from error
        self._names = (*asked.units, "ending")

    def _make(self, asked: Asked, records: Records, chunk: int) -> None:
        import xarray as xr

        inner = records.shape[1:]
        chunks = (chunk // math.prod(inner), *inner)
        for name, unit in asked.units.items():
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
        # which writes the attributes of the group anew
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

    def columns(self) -> Columns:
        """All of them."""
        return {name: np.asarray(self._group[name][...]).ravel() for name in self._names}

    def refusals(self) -> frozenset[str]:
        """What curves that were refused were told."""
        return frozenset(self._group.attrs.get(_REFUSALS, ()))


def _mark(asked: Asked, records: Records, total: int, chunk: int) -> str:
    """What changes with what is asked, with any of the curves, and with the version."""
    try:
        contact = encode(asked.contact)
    except PymdrError as error:
        raise ProblemError(
            f"fit_map: folder= keeps the contact that is fitted, and no file holds this one: {error}; leave folder out, or give the "
            "profile as Sampled"
        ) from error
    work = {
        "contact": contact,
        "free": [[u.name, u.low, u.high] for u in asked.unknowns],
        "known": dict(asked.known),
        "shape": list(records.shape),
        "told": list(asked.units),
        "version": version("pymdr"),
    }
    mark = hashlib.sha256(json.dumps(work, sort_keys=True).encode())
    for first in range(0, total, chunk):
        for array in records.read(first, min(first + chunk, total)):
            if array is not None:
                mark.update(np.ascontiguousarray(array).data)
    return mark.hexdigest()


def attributes_of(name: str, unit: str) -> dict[str, Any]:
    """Unit and words of a column, and what the numbers of endings mean."""
    told: dict[str, Any] = {"units": unit} if unit else {"units": ""}
    if name in _WORDS:
        told["long_name"] = _WORDS[name]
    if name == "ending":
        told = {**told, "flag_values": list(range(len(ENDINGS))), "flag_meanings": "; ".join(ENDINGS)}
    return told
