"""Measured surfaces from files: matrices with units by themselves, the formats of makers by SurfaceTopography."""

from __future__ import annotations

import io
import os
import re
import warnings
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pymdr.errors import CaseError, FileError, MissingExtraError, ProblemError, UnitError
from pymdr.presentation.files import named_file
from pymdr.problem.topography import Topography, preparing
from pymdr.units import ArrayQuantityLike, FloatArray, metres, shown, to_si, to_si_array
from pymdr.workbench.inputs import printable, read_bytes, text_of
from pymdr.workbench.tables import decimal_points, read_grid_columns

_LARGEST = 2**31
_LARGEST_TEXT = 200 * 2**20
_COMMAS = re.compile(r"[+-]?[0-9]+(?:,[0-9]+)?(?:[eE][+-]?[0-9]+)?", re.ASCII)
_HEADER = re.compile(r"#\s*(?P<name>[A-Za-z][A-Za-z ]*?)\s*[:=]\s*(?P<value>.*\S)\s*")
_WITH_UNIT = re.compile(r"[\[(]\s*[^\s\[\]()]+\s*[\])]")
_UNEVEN = 1e-3
"""Of a step, by which the steps of a grid may differ."""
_HOW = "give size= and unit=, or in a text write '# Width: 10 um', '# Height: 10 um' and '# Value units: nm' above the rows"
_OF_LINES = (
    "Of one bump write the gaps below its apex as 'r [um], f [um]' for read_profile; of a rough surface measure a map, or describe it "
    "by RoughSurface(hurst=, rms=, size=, shortest=)"
)
_ARRAY = b"\x93NUMPY"
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


class _ForeignError(CaseError):
    """A text that is no matrix of numbers below a header that is read here: perhaps one of a maker."""


class _Read(NamedTuple):
    heights: FloatArray
    """(nx, ny), in the unit."""
    unit: str | None
    size: FloatArray | None
    """In m."""
    step: str


def read_topography(
    file: str | os.PathLike[str],
    channel: int | str | None = None,
    *,
    size: ArrayQuantityLike | None = None,
    unit: str | None = None,
    missing: str | None = None,
    detrend: str | None = None,
) -> Topography:
    r"""
    Read a measured surface.

    Parameters
    ----------
    file : path
        Whatever its suffix: a text of heights, a row of numbers for every y and a column for every x, with commas, semicolons, tabs or
        blanks between them and above them, as Gwyddion writes it, ``# Width: 10 um``, ``# Height: 10 um``, ``# Value units: nm``; a table with the columns
        ``x [um], y [um], z [nm]`` of places on an even grid; an array (nx, ny) in a ``.npy`` file; or, with the extra
        ``topography``, any of the formats of SurfaceTopography. ``nan``, and places that a table leaves out, were not measured.
    channel : int or str, optional
        Number, from 0 on, or name of the channel, where a file has several; unless given, the one that the file names first.
    size : quantity or pair of quantities, optional
        Sides along x and y in m, where the file has none.
    unit : str, optional
        Unit of the heights, where the file has none, such as "nm".
    missing : {"interpolate", "crop", "keep"}, optional
        What becomes of heights that were not measured, as in :meth:`~pymdr.Topography.fill_missing`, or that they stay. Refused unless given.
    detrend : {"mean", "plane", "sphere", "curvature"}, optional
        What is taken off, as in :meth:`~pymdr.Topography.detrend`; nothing unless given.

    Returns
    -------
    Topography
        Its ``steps`` say what was read and done.

    Raises
    ------
    FileError
        If the file cannot be read, or not by SurfaceTopography.
    CaseError
        If it is no surface on an even grid but a line scan, scattered points or an archive, has no such channel or other quantities than heights in it, units or sides are missing or
        are given twice, or heights are missing and nothing was said of them.
    MissingExtraError
        If it needs SurfaceTopography, which is not installed.

    Notes
    -----
    Heights grow out of the body. Instruments filter, and a tip is blunt: see :meth:`~pymdr.Topography.tip_cutoff` for what it cannot have seen.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "step.csv"
    ...     _ = file.write_text("# Width: 3 um\n# Height: 2 um\n# Value units: nm\n1,1,4\n1,1,4\n")
    ...     step = mdr.read_topography(file, detrend="mean")
    >>> step.heights.shape, step.steps
    ((3, 2), ('read from step.csv', 'the mean subtracted, 2 nm'))
    """
    source = named_file(file, "read")
    if detrend is not None and detrend not in preparing.TRENDS:
        raise CaseError(
            f"detrend = {shown(detrend)}: one of {', '.join(preparing.TRENDS)}, or nothing, is needed"
        )
    if missing is not None and missing not in (*preparing.REMEDIES, "keep"):
        raise CaseError(
            f"missing = {shown(missing)}: one of {', '.join(preparing.REMEDIES)} and keep is needed"
        )
    found = _read(source, channel)
    try:
        surface = Topography(
            np.asarray(found.heights, dtype=float) * _factor(source, found.unit, unit),
            _sides(source, found.size, size),
            (found.step,),
        )
    except (ProblemError, UnitError) as error:
        raise CaseError(f"{source}: {error}") from error
    if surface.missing.any() and missing != "keep":
        count = int(surface.missing.sum())
        if missing is None:
            raise CaseError(
                f"{source}: {count} of {surface.heights.size} heights are missing; give missing='interpolate', 'crop' or 'keep'"
            )
        surface = surface.fill_missing(missing)
    return surface if detrend is None else surface.detrend(detrend)


def _factor(source: Path, own: str | None, given: str | None) -> float:
    if own is not None and given is not None:
        raise CaseError(f"{source}: unit = {shown(given)}, but the file says {own!r}; leave it out")
    unit = own if given is None else given
    if unit is None:
        raise CaseError(f"{source}: no unit of the heights; {_HOW}")
    if not isinstance(unit, str):
        raise CaseError(f"{source}: unit = {shown(unit)}; a text such as 'nm' is needed")
    try:
        return to_si(f"1 {unit}", "m", name="unit of the heights")
    except UnitError as error:
        raise CaseError(f"{source}: {error}") from error


def _sides(source: Path, own: FloatArray | None, given: ArrayQuantityLike | None) -> ArrayQuantityLike:
    if own is not None and given is not None:
        raise CaseError(
            f"{source}: size = {shown(given)}, but the file says {metres(own[0])} x {metres(own[1])}; leave it out"
        )
    sides = own if given is None else given
    if sides is None:
        raise CaseError(f"{source}: no sides of the patch; {_HOW}")
    return sides


def _read(source: Path, channel: int | str | None) -> _Read:
    content = read_bytes(source, _LARGEST, "file of heights")
    if source.suffix.lower() == ".npy" or content.startswith(_ARRAY):
        _refuse_channel(source, channel)
        return _of_array(source, content)
    if not content:
        raise CaseError(f"{source}: the file is empty and has no heights")
    text = text_of(content)
    if text is None:
        return _of_maker(source, content, channel)
    if len(content) > _LARGEST_TEXT:
        raise CaseError(
            f"{source}: larger than {_LARGEST_TEXT} bytes, the limit of a text of heights; save an array as .npy"
        )
    try:
        found = _of_text(source, text)
    except _ForeignError as error:
        try:
            return _of_maker(source, content, channel)
        except (FileError, MissingExtraError):
            raise CaseError(str(error)) from None
    if text.lstrip().startswith("#") and (found.unit is None or found.size is None):
        # a header in other words than those that are read here
        try:
            foreign = _of_maker(source, content, channel)
        except (FileError, MissingExtraError, CaseError):
            pass
        else:
            if foreign.unit is not None and foreign.size is not None:
                return foreign
    _refuse_channel(source, channel)
    return found


def _refuse_channel(source: Path, channel: int | str | None) -> None:
    if channel not in (None, 0):
        raise CaseError(
            f"{source}: channel {shown(channel)}, but the file has one surface only; leave it out"
        )


def _of_array(source: Path, content: bytes) -> _Read:
    try:
        heights = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    except (ValueError, EOFError, OSError, MemoryError) as error:
        raise CaseError(f"{source}: not an array of NumPy ({error})") from error
    if not isinstance(heights, np.ndarray) or heights.dtype.kind not in "fiu":
        raise CaseError(f"{source}: an array of real numbers is needed")
    return _Read(heights, None, None, f"read from {source.name}")


def _of_text(source: Path, text: str) -> _Read:
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbered = [i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    if not numbered:
        raise CaseError(f"{source}: no heights; write rows of numbers")
    if _WITH_UNIT.search(lines[numbered[0]]):
        return _of_table(source, lines[numbered[0]])
    late = [i for i, line in enumerate(lines) if i > numbered[0] and _HEADER.fullmatch(line.strip())]
    if late:
        raise _ForeignError(
            f"{source}, line {late[0] + 1}: a second header; write every surface into a file of its own"
        )
    told = {
        match["name"].lower(): match["value"]
        for line in lines[: numbered[0]]
        if (match := _HEADER.fullmatch(line.strip()))
    }
    sides = None
    if "width" in told or "height" in told:
        try:
            sides = to_si_array(
                [told.get("width", told.get("height", "")), told.get("height", told.get("width", ""))],
                "m",
                name="Width, Height",
            )
        except UnitError as error:
            raise CaseError(f"{source}: {error}") from error
    try:
        rows = _matrix(source, lines, numbered)
    except CaseError as error:
        if sides is not None or "value units" in told:
            raise
        raise _ForeignError(str(error)) from None
    if sides is None:
        _refuse_columns(source, rows)
    # rows of a text are those of a picture, along x
    return _Read(rows.T, told.get("value units"), sides, f"read from {source.name}")


def _matrix(source: Path, lines: list[str], numbered: list[int]) -> FloatArray:
    rows = [lines[i] for i in numbered]
    separator = next((mark for mark in ";\t," if mark in rows[0]), None)
    if separator == "," and len(rows[0].split()) > 1 and all(map(_COMMAS.fullmatch, rows[0].split())):
        separator = None
    rows = list(decimal_points(rows, separator))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return np.loadtxt(rows, delimiter=separator, comments=None, ndmin=2, dtype=float)
    except (ValueError, UserWarning):
        pass
    width = len(rows[0].split(separator))
    for i, row in zip(numbered, rows, strict=True):
        cells = row.split(separator)
        if len(cells) != width:
            raise CaseError(
                f"{source}, line {i + 1}: {len(cells)} heights for {width} in the first row; a matrix is needed"
            )
        for cell in cells:
            try:
                float(cell)
            except ValueError:
                raise CaseError(
                    f"{source}, line {i + 1}: {cell.strip()[:40]!r} is not a number; a text of heights has rows of numbers, with decimals "
                    "written with a point, nan for what is missing, and lines that begin with # above them"
                ) from None
    raise CaseError(f"{source}: no matrix of numbers")


def _refuse_columns(source: Path, rows: FloatArray) -> None:
    """Refuse two columns, places and heights of a line, and three, places x, y and heights, where no header says that they are a map."""
    count, width = rows.shape
    if width <= 2 < count:
        columns = "one column" if width == 1 else "two columns (x and z)"
        raise CaseError(_words_of_line(source, f"{columns} of {count} rows: a line scan"))
    if width == 3 and count >= 4:
        across, along = (np.unique(rows[:, i]).size for i in (0, 1))
        places = np.unique(rows[:, :2], axis=0).shape[0]
        if min(across, along) > 1 and places == across * along == count:
            raise CaseError(
                f"{source}: three columns of {across} x {along} places x, y and heights z without units; write 'x [um], y [um], z [nm]' "
                "above them, with commas between all columns"
            )


def _words_of_line(source: Path, what: str) -> str:
    return f"{source}: {what}, not a surface. {_OF_LINES}"


def _of_table(source: Path, header: str) -> _Read:
    titles = [_WITH_UNIT.sub("", title).strip(' "').lower() for title in re.split(r"[,;\t]", header)]
    if "y" not in titles and (len(titles) == 2 or {"r", "x"} & set(titles)):
        words = f"no column of y in the header {printable(header.strip()[:80])!r}: a line scan or a profile"
        raise CaseError(_words_of_line(source, words))
    columns = read_grid_columns(source)
    (x, nx, wide), (y, ny, tall) = (_even(source, name, columns[name]) for name in ("x", "y"))
    if nx * ny > 4 * x.size:
        raise CaseError(
            f"{source}: {x.size} places for a grid of {nx} x {ny}: they are scattered; interpolate the heights onto an even grid"
        )
    place = x * ny + y
    if np.unique(place).size < place.size:
        twice = int(np.flatnonzero(np.bincount(place) > 1)[0])
        raise CaseError(
            f"{source}: the place x = {metres(float(columns['x'][place == twice][0]))}, y = {metres(float(columns['y'][place == twice][0]))} has "
            "several heights; keep one"
        )
    heights = np.full(nx * ny, np.nan)
    heights[place] = columns["height"]
    return _Read(heights.reshape(nx, ny), "m", np.array([nx * wide, ny * tall]), f"read from {source.name}")


def _even(source: Path, name: str, values: FloatArray) -> tuple[np.ndarray, int, float]:
    """Numbers of places on an even grid, how many there are, and their step."""
    known = np.unique(values)
    apart = np.diff(known)
    span = float(known[-1] - known[0])
    # places that differ by rounding only are one
    steps = apart[apart > 1e-6 * span]
    if not steps.size:
        raise CaseError(f"{source}: {name} is {metres(float(known[0]))} everywhere: one row is not a surface")
    step = float(np.median(steps))
    number = (values - known[0]) / step
    whole = np.rint(number)
    count = int(whole.max()) + 1
    step = span / (count - 1)
    whole = np.rint((values - known[0]) / step)
    if (
        np.any(np.abs((values - known[0]) / step - whole) > _UNEVEN * max(1.0, 0.0))
        or steps.min() < 0.5 * step
    ):
        raise CaseError(
            f"{source}: {name} is not on an even grid: its steps are {metres(float(steps.min()))} to {metres(float(steps.max()))}; interpolate "
            "the heights onto one"
        )
    return whole.astype(int), count, step


def _opened(source: Path, content: bytes) -> Any:
    """The reader of the package that takes the content."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it says that there is no MPI
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
                # another format without a mark of its own, which only the suffix tells
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
        else "SurfaceTopography knows no such format, or the file is damaged"
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


def _of_maker(source: Path, content: bytes, channel: int | str | None) -> _Read:
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
        words = _words_of_line(
            source,
            f"channel {chosen.index} {chosen.name!r} is a line scan of {chosen.nb_grid_pts[0]} points",
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
        factor = _factor(source, str(lateral), None)
        sides = np.array([float(one) for one in chosen.physical_sizes]) * factor
    step = f"read from {source.name}, channel {chosen.index} {chosen.name!r}"
    return _Read(np.asarray(heights), None if unit is None else str(unit), sides, step)


def _names(channels: list[Any]) -> str:
    return ", ".join(f"{c.index} {c.name!r}" for c in channels)


def _chosen(source: Path, channels: list[Any], channel: int | str | None, reader: Any) -> Any:
    if channel is None:
        return reader.default_channel
    found = [c for c in channels if channel in (c.index, c.name)]
    if len(found) != 1:
        why = "no channel" if not found else f"{len(found)} channels"
        raise CaseError(
            f"{source}: {why} {shown(channel)}; the file has {_names(channels)}: name one by its number"
        )
    return found[0]


def described(surface: Topography) -> str:
    """
    What a surface is, in one line.

    Examples
    --------
    >>> described(Topography([[0.0, 1e-9], [2e-9, 3e-9]], "2 um"))
    '2 x 2 heights on 2 µm x 2 µm, pixels of 1 µm x 1 µm, from 0 m to 3 nm'
    """
    (nx, ny), (width, length) = surface.heights.shape, (metres(one) for one in surface.size)
    across, along = (metres(one) for one in surface.spacing)
    low, high = (metres(float(end(surface.heights))) for end in (np.nanmin, np.nanmax))
    return f"{nx} x {ny} heights on {width} x {length}, pixels of {across} x {along}, from {low} to {high}"
