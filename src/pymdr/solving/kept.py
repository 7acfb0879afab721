"""Work in many parts that a folder keeps as they are finished, so that a killed run goes on where it was."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymdr.errors import FileError

if TYPE_CHECKING:
    import xarray as xr

_MARK = "pymdr_work"
_FIRST = "first_part"


class KeptParts:
    """
    A folder of the finished parts of one work, which are numbered from 0.

    Parameters
    ----------
    folder : path
        Made unless it is there.
    work : mapping
        What the work is, as it could stand in a JSON file: a folder of another work, or of another version of pymdr, is refused.

    Raises
    ------
    FileError
        If the folder cannot be made, or holds the parts of another work.
    """

    def __init__(self, folder: str | os.PathLike[str], work: Mapping[str, Any]) -> None:
        from pymdr.presentation.files import named_file

        self.folder = named_file(folder, "write")
        asked = {**work, "version": version("pymdr")}
        self.mark = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                f"cannot write into {self.folder}: {error.strerror or error}; choose another folder"
            ) from error

    def _files(self) -> list[Path]:
        return sorted(self.folder.glob("parts-*.nc"))

    def parts(self) -> Iterator[tuple[int, xr.Dataset]]:
        """The finished parts: the number of the first in a file, and the file's dataset over ``part``."""
        from pymdr.presentation.files import read_dataset

        for file in self._files():
            found = read_dataset(file)
            if found.attrs.get(_MARK) != self.mark:
                raise FileError(
                    f"{file} is a part of another work: something that was asked, or the version of pymdr, has changed since; take "
                    "another folder, or empty this one"
                )
            yield int(found.attrs[_FIRST]), found

    def keep(self, first: int, finished: xr.Dataset) -> None:
        """Write finished parts, whole or not at all."""
        from pymdr.presentation.files import write_dataset

        marked = finished.assign_attrs({_MARK: self.mark, _FIRST: first})
        write_dataset(marked, self.folder / f"parts-{first:09d}.nc")
