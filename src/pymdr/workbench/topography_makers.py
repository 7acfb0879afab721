"""Heights in the files of instruments."""

from __future__ import annotations

import io
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from pymdr.errors import CaseError, FileError, MissingExtraError
from pymdr.units import FloatArray, shown
from pymdr.workbench.inputs import printable
from pymdr.workbench.topography_texts import Read, height_factor, refusal_of_line

_PACKED = {
    b"\x1f\x8b": "gzip",
    b"BZh": "bzip2",
    b"\xfd7zXZ": "xz",
    b"7z\xbc\xaf\x27\x1c": "7-Zip",
    b"Rar!": "RAR",
    b"\x28\xb5\x2f\xfd": "zstd",
}
_PICTURES = {
    b"\x89PNG": "PNG",
    b"\xff\xd8\xff": "JPEG",
    b"GIF8": "GIF",
    b"BM": "BMP",
    b"II*\0": "TIFF",
    b"MM\0*": "TIFF",
    b"%PDF": "PDF",
}
_LISTED = 5


def _opened(source: Path, content: bytes) -> Any:
    """The reader of the package that takes the content."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its warning that MPI is missing does not matter here
            import SurfaceTopography
            from SurfaceTopography.IO import MagicMatch, readers
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} needs SurfaceTopography, which cannot be imported ({error}): pip install 'pymdr[topography]'; texts of heights "
            "(.csv, .txt) and arrays (.npy) are read without it"
        ) from error
    # a reader of other people's formats may fail in any way
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            opened = SurfaceTopography.open_topography
            reader = opened(io.BytesIO(content))
            if not list(reader.channels):
                # a format without a signature is recognised by its suffix
                suffix = source.suffix.lower().lstrip(".")
                named = [kind.format() for kind in readers if suffix in (kind.file_extensions() or ())]
                reader = next((opened(io.BytesIO(content), format=kind) for kind in named), reader)
            channels = list(reader.channels)
    except Exception as error:
        failure = error
    else:
        if channels:
            return reader
        raise CaseError(
            f"{source}: SurfaceTopography finds no channels in the file; export the heights as text from the program of the maker"
        )
    known = [kind.name() for kind in readers if kind.can_read(content[:512]) is MagicMatch.YES]
    why = (
        f"it begins as a file of {' or '.join(known)}, but is damaged, cut off or of a variant that is not read"
        if known
        else "SurfaceTopography has no such format, or the file is damaged"
    )
    raise FileError(
        f"cannot read {source}: {why} ({type(failure).__name__}); export the heights as text from the program of the maker"
    ) from failure


def _refuse_container(source: Path, content: bytes) -> None:
    """Refuse archives and pictures, in which no format of heights was recognised."""
    for magic, name in _PACKED.items():
        if content.startswith(magic):
            raise CaseError(f"{source}: compressed by {name}; unpack it and read the file inside")
    for magic, name in _PICTURES.items():
        if content.startswith(magic):
            raise CaseError(
                f"{source}: a picture ({name}); colours are not heights: export the heights as text or in the format of the instrument"
            )
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            inside = [name for name in archive.namelist() if not name.endswith("/")]
    except (zipfile.BadZipFile, ValueError, OSError, NotImplementedError):
        return
    if any(name.startswith(("segments/", "data/0/segments/")) for name in inside):
        raise CaseError(f"{source}: force curves of JPK, not a surface; read them with read_curves")
    if inside:
        names = ", ".join(printable(name)[:60].replace("\n", " ") for name in inside[:_LISTED])
        more = f" and {len(inside) - _LISTED} more" if len(inside) > _LISTED else ""
        raise CaseError(
            f"{source}: an archive (zip) of {len(inside)} files: {names}{more}; unpack it and read one of them"
        )


def of_maker(source: Path, content: bytes, channel: int | str | None) -> Read:
    """Heights of a channel in a file of an instrument."""
    try:
        reader = _opened(source, content)
    except (FileError, MissingExtraError):
        _refuse_container(source, content)
        raise
    channels = list(reader.channels)
    chosen = _chosen(source, channels, channel, reader)
    own = chosen.unit
    unit = own[1] if isinstance(own, tuple) else own
    kind = getattr(chosen.data_kind, "name", "HEIGHT")
    if kind != "HEIGHT" or (isinstance(own, tuple) and unit is None):
        others = _names(
            [
                c
                for c in channels
                if getattr(c.data_kind, "name", "HEIGHT") == "HEIGHT" and not isinstance(c.unit, tuple)
            ]
        )
        raise CaseError(
            f"{source}: channel {chosen.index} {chosen.name!r} holds no heights; channels with heights are {others or 'none'}"
        )
    if chosen.dim != 2:
        maps = _names([c for c in channels if c.dim == 2])
        words = refusal_of_line(
            source, f"channel {chosen.index} {chosen.name!r} is a line scan of {chosen.nb_grid_pts[0]} points"
        )
        raise CaseError(f"{words}{f'. Channels with maps are {maps}' if maps else ''}")
    lateral = own[0] if isinstance(own, tuple) else own
    known = (
        chosen.physical_sizes is not None
        and all(one is not None for one in chosen.physical_sizes)
        and lateral is not None
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            surface = chosen.topography(
                physical_sizes=None if chosen.physical_sizes is not None else (1.0, 1.0)
            )
            heights: FloatArray = np.ma.filled(np.ma.asarray(surface.heights(), dtype=float), np.nan)
    except Exception as error:
        raise FileError(
            f"cannot read channel {chosen.index} {chosen.name!r} of {source}: SurfaceTopography finds it damaged ({type(error).__name__})"
        ) from error
    sides = None
    if known:
        factor = height_factor(source, str(lateral), None)
        sides = np.array([float(one) for one in chosen.physical_sizes]) * factor
    step = f"read from {source.name}, channel {chosen.index} {chosen.name!r}"
    return Read(np.asarray(heights), None if unit is None else str(unit), sides, step)


def _names(channels: list[Any]) -> str:
    return ", ".join(f"{c.index} {c.name!r}" for c in channels)


def _chosen(source: Path, channels: list[Any], channel: int | str | None, reader: Any) -> Any:
    if channel is None:
        return reader.default_channel
    matching = [c for c in channels if channel in (c.index, c.name)]
    if len(matching) != 1:
        why = "no channel" if not matching else f"{len(matching)} channels"
        raise CaseError(
            f"{source}: {why} {shown(channel)}; the file has {_names(channels)}: name one by its number"
        )
    return matching[0]
