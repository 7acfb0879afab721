"""Force curves from files: those of the makers of atomic force microscopes, and tables."""

from __future__ import annotations

import logging
import os
import stat
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import CaseError, FileError, MissingExtraError, ProblemError
from pymdr.presentation.files import named_file
from pymdr.problem.facts import Facts
from pymdr.problem.measured import Step
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import FloatArray, QuantityLike, shown, to_si
from pymdr.workbench.segments import Segment, segments_in
from pymdr.workbench.tables import curve_of_columns, read_force_columns

if TYPE_CHECKING:
    import xarray as xr

_BINARY = (".h5", ".ibw", ".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".zip")
"""What only afmformats reads."""
_TEXT = (".csv", ".tab", ".txt", ".tsv", ".dat")
"""A table with units, or one of a maker."""
_log = logging.getLogger("pymdr")
_PARTS = ("record", "approach", "retreat")
_HEIGHTS = ("height (measured)", "height (piezo)")


def read_curves(
    file: str | os.PathLike[str],
    *,
    spring_constant: QuantityLike | None = None,
    leave_out_missing: bool = False,
) -> tuple[MeasuredCurve, ...]:
    r"""
    Read the force curves of a file, a curve for each segment: approach, hold, retreat.

    Parameters
    ----------
    file : path
        Of any format that `afmformats` reads (JPK, Asylum, NT-MDT, AFM workshop, Optics11 Chiaro, HDF5; the extra ``afm``), or a table with units
        in its header, as for :func:`read_curve`.
    spring_constant : quantity, optional
        Of the cantilever or the machine in N/m. Where the file has another one, :meth:`~pymdr.MeasuredCurve.recalibrate` is a step of the curves.
    leave_out_missing : bool
        Whether samples without a number are left out, which the first step of the curve then tells; such files are refused otherwise.

    Returns
    -------
    tuple of MeasuredCurve
        In the order of the file; `segment` is determined from the change of the travel; `metadata` holds that of the file, with the pixels of a
        force map (see :func:`stack_curves`). Travel is minus the height of the cantilever, so that it grows toward the body.

    Raises
    ------
    FileError
        If the file cannot be read, is damaged or cut off.
    CaseError
        If it is a table without units, or samples are not numbers.
    ProblemError
        If it has no force, no height, or no spring constant.
    MissingExtraError
        If `afmformats` is needed and not installed.

    See Also
    --------
    read_record : loads and displacements of a table.
    MeasuredCurve.join : one record of its segments.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "curve.csv"
    ...     rows = [f"{i * i}, {10 * i}" for i in range(9)]
    ...     _ = file.write_text("\n".join(["load [nN], indentation [nm]", *rows]))
    ...     [curve] = mdr.read_curves(file)
    >>> curve.force.size, round(float(curve.force[-1]) * 1e9, 9)
    (9, 64.0)
    """
    source = named_file(file, "read")
    suffix = source.suffix.lower()
    if suffix in _BINARY:
        return tuple(_of_maker(source, spring_constant, leave_out_missing))
    if suffix not in _TEXT:
        known = ", ".join((*_TEXT, *_BINARY))
        raise FileError(
            f"cannot read {source}: no format of force curves ends in {suffix!r}; those that do: {known}"
        )
    try:
        columns = read_force_columns(source, missing=leave_out_missing)
    except CaseError:  # no table with units: it may be one of a maker
        try:
            return tuple(_of_maker(source, spring_constant, leave_out_missing))
        except (FileError, CaseError, MissingExtraError):
            pass
        raise
    size, missing = columns["normal_force"].size, 0
    if leave_out_missing:
        columns, missing = _known(str(source), columns, leave_out_missing)
    whole = curve_of_columns(source, columns, spring_constant, _step_of(missing, size))
    facts = Facts({"file": source.name, "record": 0.0})
    return tuple(_part(whole, segment, facts) for segment in segments_in(whole.position, whole.time, None))


def read_prepared_curves(
    file: str | os.PathLike[str], *, segment: str = "record", spring_constant: QuantityLike | None = None
) -> tuple[MeasuredCurve, ...]:
    r"""
    Read the force curves of a file ready for a fit: with the signs of pymdr, bad samples marked, and a straight baseline taken off.

    Parameters
    ----------
    file : path
        As for :func:`read_curves`.
    segment : {"record", "approach", "retreat"}
        Which part of each record.
    spring_constant : quantity, optional
        As for :func:`read_curves`.

    Returns
    -------
    tuple of MeasuredCurve
        One for each record that has an approach with a baseline; their `steps` say what was done.

    Raises
    ------
    ProblemError
        If `segment` is none of these, or no record has one with a baseline; with what the last one says.
    FileError, CaseError, MissingExtraError
        As :func:`read_curves`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "curve.csv"
    ...     depths = [max(i - 50, 0) for i in range(150)]
    ...     rows = [f"{0.01 * depth**1.5}, {i}" for i, depth in enumerate(depths)]
    ...     _ = file.write_text("\n".join(["load [nN], indentation [nm]", *rows]))
    ...     [curve] = mdr.read_prepared_curves(file)
    >>> curve.force.size
    150
    """
    if segment not in _PARTS:
        raise ProblemError(f"segment = {shown(segment)}; it is one of {', '.join(_PARTS)}")
    records: dict[float, list[MeasuredCurve]] = {}
    for curve in read_curves(file, spring_constant=spring_constant):
        records.setdefault(float(curve.metadata["record"]), []).append(curve)
    ready: list[MeasuredCurve] = []
    failure: ProblemError | None = None
    for parts in records.values():
        try:
            ready.append(_ready(parts, segment))
        except ProblemError as error:
            failure = error
    if not ready:
        raise ProblemError(f"{os.fspath(file)}: no record can be fitted: {failure}")
    if failure is not None:
        _log.warning(
            "%s: %d of %d records are left out; the last: %s",
            file,
            len(records) - len(ready),
            len(records),
            failure,
        )
    return tuple(ready)


def _ready(parts: Sequence[MeasuredCurve], segment: str) -> MeasuredCurve:
    """One record with its signs, marks and baseline, which is that of its approach."""
    whole = parts[0].join(*parts[1:]).mark_outliers()
    oriented = whole.orient()
    signs = oriented.step
    assert signs is not None
    approach = next((one for one in parts if one.segment == "approach"), None)
    if approach is None:
        raise ProblemError(
            "the record has no approach; its baseline is fitted to the free part of the approach"
        )
    baseline = approach.mark_outliers().orient(signs.numbers).baseline()
    if segment == "record":
        return oriented.mark_saturated().subtract_baseline(baseline)
    chosen = next((one for one in parts if one.segment == segment), None)
    if chosen is None:
        raise ProblemError(f"the record has no {segment}")
    return chosen.mark_outliers().orient(signs.numbers).mark_saturated().subtract_baseline(baseline)


def stack_curves(
    curves: Sequence[MeasuredCurve], numbers: Mapping[str, Sequence[float]] | None = None
) -> xr.Dataset:
    """
    Curves of a map, and numbers that belong to them, as one dataset, as :func:`fit_map` takes it and a Zarr store keeps it.

    Parameters
    ----------
    curves : sequence of MeasuredCurve
        One for each pixel, all with travel or all with indentation.
    numbers : mapping of str to sequence of float, optional
        Name -> one for each curve, such as contact points.

    Returns
    -------
    xarray.Dataset
        ``force`` (N) and ``travel`` or ``indentation`` (m), ``time`` (s) where all have it, over the pixels ``y`` and ``x`` with
        their places in m, or ``curve`` of a single one and where one has none, and ``sample``; shorter ones, samples that are marked and pixels without a
        curve are nan; ``spring_constant`` (N/m), and the numbers.

    Raises
    ------
    ProblemError
        If there is no curve, some have travel and others indentation, two lie in the same pixel, or there are other numbers of
        numbers than of curves.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(0.0, 1e-6, 50)
    >>> curves = [mdr.MeasuredCurve(force=k * depth**1.5, indentation=depth) for k in (1.0, 2.0)]
    >>> mdr.stack_curves(curves).sizes["sample"]
    50
    """
    import xarray as xr

    some = list(curves)
    channel = "travel" if some and some[0].travel is not None else "indentation"
    if not some or any((one.travel is None) != (channel == "indentation") for one in some):
        raise ProblemError("stack_curves: curves are needed, all with travel or all with indentation")
    width = max(one.force.size for one in some)
    columns = {
        "force": ("N", [np.where(one.marked, np.nan, one.force) for one in some]),
        channel: ("m", [one.position for one in some]),
    }
    if all(one.time is not None for one in some):
        columns["time"] = ("s", [one.time for one in some if one.time is not None])
    data = xr.Dataset()
    for name, (unit, values) in columns.items():
        rows = np.full((len(some), width), np.nan)
        for row, value in zip(rows, values, strict=True):
            row[: value.size] = value
        data[name] = ("curve", "sample"), rows, {"units": unit}
    if channel == "travel":
        data["spring_constant"] = "curve", np.array([one.spring_constant for one in some]), {"units": "N/m"}
    for name, each in (numbers or {}).items():
        if len(each) != len(some):
            raise ProblemError(
                f"stack_curves: {len(each)} numbers {shown(name)} for {len(some)} curves; give one for each"
            )
        data[name] = "curve", np.asarray(each, dtype=float)
    return _on_pixels(data, some)


def _on_pixels(data: xr.Dataset, curves: Sequence[MeasuredCurve]) -> xr.Dataset:
    """What is over curves, over the pixels that they have; the same of a single one, and where one has none."""
    import xarray as xr

    if len(curves) < 2 or any(f"grid index {axis}" not in one.metadata for one in curves for axis in "xy"):
        return data
    pixels = [tuple(int(float(curve.metadata[f"grid index {axis}"])) for axis in "yx") for curve in curves]
    if len(set(pixels)) < len(curves):
        raise ProblemError(
            "stack_curves: two curves lie in the same pixel; give one segment of each record, such as the approach"
        )
    shape = [
        int(_of_grid(curves, "shape", axis, max(where) + 1.0))
        for axis, where in zip("yx", zip(*pixels, strict=True), strict=True)
    ]
    there = np.full(shape, -1)
    there[tuple(np.array(pixels).T)] = np.arange(len(curves))
    at = xr.DataArray(there, dims=("y", "x"))
    on_grid = data.isel(curve=at).where(at >= 0)
    for name, array in data.items():
        on_grid[name].attrs.update(array.attrs)
    places = {
        axis: (
            axis,
            _of_grid(curves, "center", axis, 0.0)
            + (np.arange(n) - 0.5 * (n - 1)) * _of_grid(curves, "size", axis, float(n)) / n,
            {"units": "m"},
        )
        for axis, n in zip("yx", shape, strict=True)
    }
    return on_grid.assign_coords(places).transpose("y", "x", "sample")


def _of_grid(curves: Sequence[MeasuredCurve], what: str, axis: str, otherwise: float) -> float:
    return float(curves[0].metadata.get(f"grid {what} {axis}", otherwise))


def _afmformats(source: Path) -> Any:
    try:
        import afmformats
        import afmformats.errors
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} needs afmformats, which cannot be imported ({error}): pip install 'pymdr[afm]'; tables with units in their header "
            "(.csv, .tsv) are read without it"
        ) from error
    logger = logging.getLogger("afmformats")
    if not logger.handlers:  # what it cannot read is told by our errors
        logger.addHandler(logging.NullHandler())
    return afmformats


def _of_maker(
    source: Path, spring_constant: QuantityLike | None, leave_out_missing: bool
) -> Iterator[MeasuredCurve]:
    try:
        state = source.stat()
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or error
        raise FileError(f"cannot read {source}: {words}") from error
    if not stat.S_ISREG(state.st_mode):
        raise FileError(
            f"cannot read {source}: force curves are in a regular file, not a folder, pipe or device"
        )
    if state.st_size == 0:
        raise CaseError(f"{source}: the file is empty; copy it again from the instrument")
    afmformats = _afmformats(source)
    given = None if spring_constant is None else to_si(spring_constant, "N/m", name="spring_constant")
    from afmformats.meta import MetaDataMissingError

    broken = (
        Exception,
        afmformats.errors.AFMFileFormatError,
        afmformats.errors.MissingMetaDataError,
        MetaDataMissingError,
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            records = [_columns(one) for one in _loaded(afmformats, source, given)]
    except broken as error:
        raise FileError(
            f"cannot read {source}: afmformats knows no such format, or the file is damaged or cut off ({type(error).__name__}: "
            f"{str(error)[:200]}); copy it again from the instrument, or export it as a table with units in its header"
        ) from error
    if not records:
        raise CaseError(f"{source}: there is no force curve in it; export the record again")
    for number, (columns, metadata) in enumerate(records):
        yield from _segments(source, number, columns, metadata, given, leave_out_missing)


def _loaded(afmformats: Any, source: Path, spring_constant: float | None) -> Any:
    try:
        return afmformats.load_data(source)
    except afmformats.errors.MissingMetaDataError as error:
        if "spring constant" not in error.meta_keys or spring_constant is None:
            raise
        return afmformats.load_data(source, meta_override={"spring constant": spring_constant})


def _columns(record: Any) -> tuple[dict[str, FloatArray], dict[str, str | float]]:
    columns = {name: np.asarray(record[name], dtype=float) for name in record.columns}
    metadata = record.metadata
    facts: dict[str, str | float] = {}
    for name in sorted(metadata):
        value = metadata[name]
        if name == "path":
            facts["file"] = Path(value).name
        else:
            facts[name] = float(value) if isinstance(value, int | float | np.number) else str(value)
    facts["record"] = float(facts.pop("enum", 0.0))
    return columns, facts


def _segments(
    source: Path,
    number: int,
    columns: dict[str, FloatArray],
    metadata: dict[str, str | float],
    given: float | None,
    leave_out_missing: bool,
) -> Iterator[MeasuredCurve]:
    where = f"{source}, record {number}"
    if "force" not in columns:
        raise ProblemError(
            f"{where}: no force (it has {', '.join(columns)}); calibrate the deflection with sensitivity and spring constant before export"
        )
    name = next((name for name in (*_HEIGHTS, "tip position") if name in columns), None)
    if name is None:
        raise ProblemError(
            f"{where}: no height of the cantilever (it has {', '.join(columns)}); export the height that was measured too"
        )
    used = {key: columns[key] for key in ("force", name, "time", "segment") if key in columns}
    sizes = {key: values.size for key, values in used.items()}
    if len(set(sizes.values())) > 1:
        lengths = ", ".join(f"{size} of {key}" for key, size in sizes.items())
        raise FileError(f"cannot read {where}: its columns differ in length ({lengths}): the file is cut off")
    expected = metadata.get("point count")
    if isinstance(expected, float) and expected > sizes["force"]:
        raise FileError(
            f"cannot read {where}: {sizes['force']} of {expected:g} samples are there: the file is cut off; copy it again from the instrument"
        )
    used, missing = _known(where, used, leave_out_missing)
    own = metadata.get("spring constant")
    constant = float(own) if own is not None else given
    position = -used[name]
    if name != "tip position" and constant is None:
        raise ProblemError(
            f"{where}: the file has no spring constant; give spring_constant, such as '0.1 N/m'"
        )
    step = _step_of(missing, missing + position.size)
    whole = MeasuredCurve(
        force=used["force"],
        indentation=position if name == "tip position" else None,
        travel=None if name == "tip position" else position,
        time=used.get("time"),
        spring_constant=constant,
        step=step,
    )
    facts = Facts({**metadata, "file": source.name, "position": f"minus {name}"})
    for segment in segments_in(position, used.get("time"), used.get("segment")):
        part = _part(whole, segment, facts)
        yield part.recalibrate(given) if given is not None and constant != given else part


def _known(where: str, columns: dict[str, FloatArray], leave_out: bool) -> tuple[dict[str, FloatArray], int]:
    """The columns, all numbers, and how many samples were left out for it."""
    for key, values in columns.items():
        lost = ~np.isfinite(values)
        if lost.any() and not leave_out:
            first = int(np.argmax(lost))
            raise CaseError(
                f"{where}: {key}[{first}] = {values[first]:g}, one of {np.count_nonzero(lost)} of {values.size} samples that are not numbers; every "
                "sample must be finite: read_curves(..., leave_out_missing=True) leaves them out and says so"
            )
    kept = np.all([np.isfinite(values) for values in columns.values()], axis=0)
    if np.count_nonzero(kept) < 8:
        raise CaseError(
            f"{where}: {np.count_nonzero(kept)} of {kept.size} samples are numbers; at least 8 are needed: measure again"
        )
    return {key: values[kept] for key, values in columns.items()}, int(np.count_nonzero(~kept))


def _step_of(missing: int, size: int) -> Step | None:
    """That samples were left out, if any were."""
    if not missing:
        return None
    words = f"{missing} of {size} samples were no numbers, left out"
    return Step("missing", words, Facts({"count": float(missing)}))


def _part(whole: MeasuredCurve, segment: Segment, facts: Facts) -> MeasuredCurve:
    def part(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else values[segment.first : segment.end]

    return replace(
        whole,
        force=whole.force[segment.first : segment.end],
        indentation=part(whole.indentation),
        travel=part(whole.travel),
        time=part(whole.time),
        segment=segment.name,
        metadata=facts,
    )
