"""Results of loads in a folder, each written whole, so that a run which was ended goes on where it was."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from pymdr.errors import FileError
from pymdr.presentation.files import named_file, write_whole
from pymdr.solving.press.states import State
from pymdr.units import FloatArray

_INPUT = "input.json"
_FORMAT = 1


class Keeper:
    """A folder for the results of one run."""

    def __init__(self, folder: object, asked: Mapping[str, Any]) -> None:
        self._folder = named_file(folder, "write into")
        plain = {"format": _FORMAT, **asked}
        file = self._folder / _INPUT
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            there = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
            strangers = there is None and any(self._folder.iterdir())
        except (OSError, ValueError) as error:
            raise FileError(
                f"keep = {self._folder}: it is no folder of a run of press: {error}; name another one"
            ) from error
        if strangers:
            raise FileError(
                f"keep = {self._folder}: the folder has other files in it; name a new one, or an empty one"
            )
        if there is None:
            write_whole(file, lambda beside: beside.write_text(json.dumps(plain, indent=1), encoding="utf-8"))
            return
        other = [key for key in plain if not isinstance(there, dict) or there.get(key) != plain[key]]
        if other:
            raise FileError(
                f"keep = {self._folder}: the results in it are of another run: {', '.join(other)} were others; name another folder, or "
                "delete this one"
            )

    def _file(self, row: int) -> Path:
        return self._folder / f"load-{row + 1:04d}.npz"

    def read(self, row: int) -> State | None:
        """What was found at a load; None if nothing yet."""
        file = self._file(row)
        if not file.exists():
            return None
        try:
            with file.open("rb") as opened, np.load(opened, allow_pickle=False) as arrays:
                numbers = {name: float(arrays[name]) for name in State.numbers()}
                return State(**numbers, pressure=arrays["pressure"], gap=arrays["gap"])
        except (OSError, ValueError, KeyError, BadZipFile) as error:
            raise FileError(f"{file} is damaged: {error}; delete it, and press again") from error

    def write(self, row: int, state: State) -> None:
        """Keep what was found at a load."""
        write_whole(self._file(row), lambda beside: np.savez_compressed(beside, **state._asdict()))


def fingerprint(*arrays: FloatArray) -> str:
    """A digest of the shapes and values of arrays."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
