"""A folder of finished parts of a long computation, so that an interrupted run can be continued."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymdr.errors import FileError
from pymdr.version import __version__

if TYPE_CHECKING:
    import xarray as xr

_MARK = "pymdr_work"
_FIRST = "first_part"


class KeptParts:
    """
    A folder of the finished parts of one computation, numbered from 0.

    Parameters
    ----------
    folder : path
        Created if it does not exist.
    work : mapping
        Identity of the computation, JSON-serialisable; a folder of another computation or version of pymdr is refused.

    Raises
    ------
    FileError
        If the folder cannot be created, or contains parts of another computation.
    """

    def __init__(self, folder: str | os.PathLike[str], work: Mapping[str, Any]) -> None:
        from pymdr.presentation.files import named_file

        self.folder = named_file(folder, "write")
        identity = {**work, "version": __version__}
        self.mark = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
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
            part = read_dataset(file)
            if part.attrs.get(_MARK) != self.mark:
                raise FileError(
                    f"{file} belongs to another computation: its arguments, or the version of pymdr, have changed; use "
                    "another folder, or empty this one"
                )
            yield int(part.attrs[_FIRST]), part

    def keep(self, first: int, finished: xr.Dataset) -> None:
        """Write finished parts, whole or not at all."""
        from pymdr.presentation.files import write_dataset

        marked = finished.assign_attrs({_MARK: self.mark, _FIRST: first})
        write_dataset(marked, self.folder / f"parts-{first:09d}.nc")
