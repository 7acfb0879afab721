"""Results from files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from pymdr import presentation
from pymdr.deferred import xr
from pymdr.errors import FileError, ProblemError
from pymdr.independent.rings import Rings
from pymdr.result import Result, Status
from pymdr.solving.laws import law_of

if TYPE_CHECKING:
    from pathlib import Path


RESULT_FILE = "result.nc"
"""Name of the result in the folder of a case."""


def result_from_dataset(dataset: xr.Dataset) -> Result:
    """The inverse of :meth:`~pymdr.result.Result.to_dataset`."""
    parts = presentation.files.unpack(dataset)
    rings = parts["rings"]
    try:
        parts |= {"status": Status[parts["status"]], "rings": None if rings is None else Rings(rings)}
    except (KeyError, ProblemError) as error:
        raise FileError(f"damaged pymdr result: {error}; use another copy, or solve again") from error
    return Result(**parts, reading=law_of(parts["contact"], parts["rings"], parts["path"]).reading)


def open_result(file: str | os.PathLike[str]) -> Result:
    """
    Read a result that :meth:`~pymdr.Result.save` wrote.

    Parameters
    ----------
    file : path
        Or the folder that ``pymdr run`` wrote; its ``result.nc`` is read.

    Returns
    -------
    Result
        With problem, claims and values equal to those saved; a callable profile comes back as its
        interpolant.

    Raises
    ------
    FileError
        If the file is missing, damaged or not a pymdr result, or the folder is that of a study; the message then says how to read it.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from tempfile import TemporaryDirectory
    >>> result = mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)), mdr.load("1 N"))
    >>> with TemporaryDirectory() as folder:
    ...     result.save(f"{folder}/ball.nc")
    ...     again = mdr.open_result(f"{folder}/ball.nc")
    >>> float(again["normal_force"][-1])
    1.0
    """
    source = presentation.files.named_file(file, "read")
    if source.is_dir():
        folder, source = source, source / RESULT_FILE
        if not source.exists():
            raise FileError(_folder_text(folder))
    return result_from_dataset(presentation.files.read_dataset(source))


def _folder_text(folder: Path) -> str:
    """Message on a folder without a result, with how to read what it has."""
    remedies = {
        "*.nc": "xarray.open_dataset({file}), or open_pressed_surface({file}) for one of press",
        "*.zarr": "xarray.open_zarr({file}, consolidated=False)",
        "*.csv": "pandas.read_csv({file})",
    }
    for pattern, remedy in remedies.items():
        if files := sorted(folder.glob(pattern)):
            file = repr(files[0].as_posix())
            return (
                f"cannot read {str(folder)!r} as a result: it has no {RESULT_FILE}, which pymdr run writes, but {files[0].name} of a study; "
                f"read it with {remedy.format(file=file)}"
            )
    return f"cannot read {str(folder)!r} as a result: it has no {RESULT_FILE}, which pymdr run writes"
