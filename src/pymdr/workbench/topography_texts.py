"""Heights in texts and arrays."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pymdr.errors import CaseError, errors_of_case
from pymdr.units import FloatArray, metres, shown, to_si, to_si_array
from pymdr.workbench.inputs import printable
from pymdr.workbench.tables import decimal_points, read_grid_columns

_COMMAS = re.compile(r"[+-]?[0-9]+(?:,[0-9]+)?(?:[eE][+-]?[0-9]+)?", re.ASCII)


_HEADER = re.compile(r"#\s*(?P<name>[A-Za-z][A-Za-z ]*?)\s*[:=]\s*(?P<value>.*\S)\s*")


_WITH_UNIT = re.compile(r"[\[(]\s*[^\s\[\]()]+\s*[\])]")


_UNEVEN = 1e-3
"""Largest difference of the steps of a grid, relative to a step."""


HOW = "give size= and unit=, or in a text write '# Width: 10 um', '# Height: 10 um' and '# Value units: nm' above the rows"


_OF_LINES = (
    "Of one bump write the gaps below its apex as 'r [um], f [um]' for read_profile; of a rough surface measure a map, or describe it "
    "by RoughSurface(hurst=, rms=, size=, shortest=)"
)


ARRAY_MAGIC = b"\x93NUMPY"


class ForeignError(CaseError):
    """A text that is no matrix of numbers below a header that is read here: perhaps one of a maker."""


class Read(NamedTuple):
    """Heights as a file holds them."""

    heights: FloatArray
    """(nx, ny), in the unit."""
    unit: str | None
    size: FloatArray | None
    """In m."""
    step: str


def height_factor(source: Path, own: str | None, given: str | None) -> float:
    """Metres in the unit of the heights, which the file or the caller names."""
    if own is not None and given is not None:
        raise CaseError(f"{source}: unit = {shown(given)}, but the file says {own!r}; leave it out")
    unit = own if given is None else given
    if unit is None:
        raise CaseError(f"{source}: no unit of the heights; {HOW}")
    if not isinstance(unit, str):
        raise CaseError(f"{source}: unit = {shown(unit)}; a text such as 'nm' is needed")
    with errors_of_case(f"{source}:"):
        return to_si(f"1 {unit}", "m", name="unit of the heights")


def of_array(source: Path, content: bytes) -> Read:
    """Heights of a NumPy file."""
    try:
        heights = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    except (ValueError, EOFError, OSError, MemoryError) as error:
        raise CaseError(f"{source}: not an array of NumPy ({error})") from error
    if not isinstance(heights, np.ndarray) or heights.dtype.kind not in "fiu":
        raise CaseError(f"{source}: an array of real numbers is needed")
    return Read(heights, None, None, f"read from {source.name}")


def of_text(source: Path, text: str) -> Read:
    """Heights of a text: a matrix, or a table of x, y and z."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbered = [i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    if not numbered:
        raise CaseError(f"{source}: no heights; write rows of numbers")
    if _WITH_UNIT.search(lines[numbered[0]]):
        return _of_table(source, lines[numbered[0]])
    late = [i for i, line in enumerate(lines) if i > numbered[0] and _HEADER.fullmatch(line.strip())]
    if late:
        raise ForeignError(
            f"{source}, line {late[0] + 1}: a second header; write every surface into a file of its own"
        )
    header = {
        match["name"].lower(): match["value"]
        for line in lines[: numbered[0]]
        if (match := _HEADER.fullmatch(line.strip()))
    }
    sides = None
    if "width" in header or "height" in header:
        with errors_of_case(f"{source}:"):
            sides = to_si_array(
                [
                    header.get("width", header.get("height", "")),
                    header.get("height", header.get("width", "")),
                ],
                "m",
                name="Width, Height",
            )
    try:
        rows = _matrix(source, lines, numbered)
    except CaseError as error:
        if sides is not None or "value units" in header:
            raise
        raise ForeignError(str(error)) from None
    if sides is None:
        _refuse_columns(source, rows)
    # rows of a text are those of a picture, along x
    return Read(rows.T, header.get("value units"), sides, f"read from {source.name}")


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
    raise CaseError(f"{source}: no matrix of numbers; write rows of numbers")


def _refuse_columns(source: Path, rows: FloatArray) -> None:
    """Refuse two columns, places and heights of a line, and three, places x, y and heights, unless a header declares a map."""
    count, width = rows.shape
    if width <= 2 < count:
        columns = "one column" if width == 1 else "two columns (x and z)"
        raise CaseError(refusal_of_line(source, f"{columns} of {count} rows: a line scan"))
    if width == 3 and count >= 4:
        across, along = (np.unique(rows[:, i]).size for i in (0, 1))
        places = np.unique(rows[:, :2], axis=0).shape[0]
        if min(across, along) > 1 and places == across * along == count:
            raise CaseError(
                f"{source}: three columns of {across} x {along} places x, y and heights z without units; write 'x [um], y [um], z [nm]' "
                "above them, with commas between all columns"
            )


def refusal_of_line(source: Path, what: str) -> str:
    """Message for a line where a surface is needed."""
    return f"{source}: {what}, not a surface. {_OF_LINES}"


def _of_table(source: Path, header: str) -> Read:
    titles = [_WITH_UNIT.sub("", title).strip(' "').lower() for title in re.split(r"[,;\t]", header)]
    if "y" not in titles and (len(titles) == 2 or {"r", "x"} & set(titles)):
        words = f"no column of y in the header {printable(header.strip()[:80])!r}: a line scan or a profile"
        raise CaseError(refusal_of_line(source, words))
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
    return Read(heights.reshape(nx, ny), "m", np.array([nx * wide, ny * tall]), f"read from {source.name}")


def _even(source: Path, name: str, values: FloatArray) -> tuple[np.ndarray, int, float]:
    """Numbers of places on an even grid, how many there are, and their step."""
    known = np.unique(values)
    gaps = np.diff(known)
    span = float(known[-1] - known[0])
    # places that differ by rounding only are one
    steps = gaps[gaps > 1e-6 * span]
    if not steps.size:
        raise CaseError(
            f"{source}: {name} is {metres(float(known[0]))} everywhere: one row is not a surface; give several rows"
        )
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
