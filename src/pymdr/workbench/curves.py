"""Force curves from files: those of the makers of instruments, and tables."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.presentation.files import named_file
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import QuantityLike, shown
from pymdr.workbench.readers import calibration_of, curves_of, is_user_table, records_of
from pymdr.workbench.segments import segments_in

_log = logging.getLogger("pymdr")
_PARTS = ("record", "approach", "retreat")
_PULL = 0.2
"""Pull over the largest force above which the force alone does not determine the direction of a one-way record."""


def read_curves(
    file: str | os.PathLike[str],
    *,
    spring_constant: QuantityLike | None = None,
    sensitivity: QuantityLike | None = None,
    leave_out_missing: bool = False,
    keep_signs: bool | None = None,
) -> tuple[MeasuredCurve, ...]:
    r"""
    Read the force curves of a file, a curve for each segment: approach, hold, retreat.

    Parameters
    ----------
    file : path
        Of Bruker NanoScope or Optics11; of Nanosurf (the extra ``nanosurf``); of any format that `afmformats` reads (JPK, Asylum, NT-MDT, AFM
        workshop, HDF5; the extra ``afm``); of a format that another package registers; or a table with units in its header, as text or
        spreadsheet: load, or deflection as a length or in V, over travel, height or indentation. An archive .zip holds such files.
    spring_constant : quantity, optional
        Of the cantilever or the machine in N/m. Where the file has another one, :meth:`~pymdr.MeasuredCurve.recalibrate` is a step of the curves.
    sensitivity : quantity, optional
        Deflection per signal of the photodiode, such as ``"50 nm/V"``, for deflections in V. Where the file has another one, all forces are
        scaled, which is a step of the curves.
    leave_out_missing : bool
        Whether samples without a number are omitted, as the first step of the curve then states. If not, such files are refused.
    keep_signs : bool, optional
        Whether the signs of a table are kept even if its force falls where the body is pressed, or its position falls toward the body. Curves of
        instruments have the signs of the file; :meth:`~pymdr.MeasuredCurve.orient` turns them.

    Returns
    -------
    tuple of MeasuredCurve
        In the order of the file; `segment` is determined from the change of the travel; `metadata` holds that of the file, with the pixels of a
        force map (see :func:`stack_curves`). Travel is minus the height of the cantilever, so that it grows toward the body. A table
        whose position falls toward the body, or whose force is negative in compression, is turned, which is a step of its curves.

    Raises
    ------
    FileError
        If the file cannot be read, is damaged or cut off.
    CaseError
        If it is a table without units, or samples are not numbers.
    ProblemError
        If it has no force, no height, no spring constant, or no sensitivity of a signal in V.
    MissingExtraError
        If a package is needed and not installed; it names the extra.

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
    calibration = calibration_of(spring_constant, sensitivity)
    records, of_user = records_of(source, calibration, leave_out_missing)
    return tuple(
        curve
        for number, record in enumerate(records)
        for curve in curves_of(
            source,
            number,
            record,
            calibration,
            leave_out_missing=leave_out_missing,
            turn=_turned if of_user and not keep_signs else lambda curve: curve,
        )
    )


def _turned(curve: MeasuredCurve) -> MeasuredCurve:
    """The record of a table with the signs of pymdr, if its force falls in contact, or its position falls toward the body by force and motion alike."""
    try:
        signs = curve.mark_outliers().orient().step
    except ProblemError:  # the force does not determine the direction
        return curve
    assert signs is not None
    name = "travel" if curve.indentation is None else "indentation"
    if signs.numbers[name] == 1.0:
        turned = signs.numbers["force"] == -1.0 and _decreases_in_contact(curve.mark_outliers())
        return curve.orient(signs.numbers) if turned else curve
    moving = [one.name for one in segments_in(curve.position, curve.time, None) if one.name != "hold"]
    if not moving or moving[0] != "retreat":
        return curve
    if "approach" not in moving:  # one way only: a retreat that ends in a pull looks alike
        deep = np.argsort(curve.position)[-max(curve.force.size // 20, 1) :]
        above = float(signs.numbers["force"]) * (curve.force - np.median(curve.force[deep]))
        if -float(above.min()) > _PULL * float(np.max(np.abs(above))):
            return curve
    return curve.orient(signs.numbers)


def _decreases_in_contact(curve: MeasuredCurve) -> bool:
    """Whether the force decreases over the deepest third: a body in tension only has a negative force as well, but one that increases."""
    deep = ~curve.marked & (curve.position >= curve.position.max() - np.ptp(curve.position) / 3.0)
    return float(np.polyfit(curve.position[deep] - curve.position.max(), curve.force[deep], 1)[0]) < 0.0


def read_prepared_curves(
    file: str | os.PathLike[str],
    *,
    segment: str = "record",
    spring_constant: QuantityLike | None = None,
    sensitivity: QuantityLike | None = None,
    leave_out_missing: bool = False,
    keep_signs: bool | None = None,
) -> tuple[MeasuredCurve, ...]:
    r"""
    Read the force curves of a file, ready for a fit: signs of pymdr, bad samples marked, baseline subtracted.

    Parameters
    ----------
    file : path
        As for :func:`read_curves`.
    segment : {"record", "approach", "retreat"}
        Which part of each record.
    spring_constant, sensitivity, leave_out_missing
        As for :func:`read_curves`.
    keep_signs : bool, optional
        Whether the signs of the file are kept; by default where the maker has defined them (JPK), and otherwise each record decides, as for
        :meth:`~pymdr.MeasuredCurve.orient`. A warning says so if the forces of some records of the file are turned and of others not.

    Returns
    -------
    tuple of MeasuredCurve
        One for each record that has an approach with a baseline; their `steps` list what was done.

    Raises
    ------
    ProblemError
        If `segment` is none of these, or no record has one with a baseline; the message contains the reason of the last record.
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
        raise ProblemError(f"segment = {shown(segment)}; it must be one of {', '.join(_PARTS)}")
    records: dict[float, list[MeasuredCurve]] = {}
    for curve in read_curves(
        file,
        spring_constant=spring_constant,
        sensitivity=sensitivity,
        leave_out_missing=leave_out_missing,
        keep_signs=keep_signs,
    ):
        records.setdefault(float(curve.metadata["record"]), []).append(curve)
    ready: list[MeasuredCurve] = []
    failure: ProblemError | None = None
    for parts in records.values():
        try:
            ready.append(_ready(parts, segment, keep_signs))
        except ProblemError as error:
            failure = error
    if not ready:
        raise ProblemError(f"{os.fspath(file)}: no record can be fitted: {failure}")
    turned = sum(
        any(step.name == "signs" and step.numbers.get("force") == -1.0 for step in one.steps) for one in ready
    )
    if 0 < turned < len(ready):
        _log.warning(
            "%s: the forces of %d of %d records changed sign and the others did not, so some records may show no contact; "
            "keep_signs=True (--keep-signs) keeps all signs",
            file,
            turned,
            len(ready),
        )
    if failure is not None:
        _log.warning(
            "%s: %d of %d records are left out; the last: %s",
            file,
            len(records) - len(ready),
            len(records),
            failure,
        )
    return tuple(ready)


def is_table(file: str | os.PathLike[str]) -> bool:
    """Whether a file is a table of a user, as text or spreadsheet, not a file of an instrument."""
    return is_user_table(named_file(file, "read"))


def read_fittable_curves(
    file: str | os.PathLike[str],
    segment: str | None = None,
    *,
    whole: bool = False,
    keep_signs: bool | None = None,
    **options: Any,
) -> tuple[MeasuredCurve, ...]:
    """
    The curves of a file as they are fitted: a table by :func:`read_segment`, a file of an instrument by :func:`read_prepared_curves`.

    Parameters
    ----------
    segment : {"record", "approach", "retreat"}, optional
        By default the record of a table, and the approach of a file of an instrument.
    whole : bool
        Whether the default is the record of any file.
    keep_signs : bool, optional
        As for :func:`read_prepared_curves`, or for :func:`read_curves` if it is a table.
    """
    if not is_table(file):
        part = segment or ("record" if whole else "approach")
        return read_prepared_curves(file, segment=part, keep_signs=keep_signs, **options)
    curve = read_segment(file, segment or "record", keep_signs=keep_signs, **options)
    if options.get("spring_constant") is not None and curve.spring_constant is None:
        raise ProblemError(
            f"--spring-constant: not used for {file}, which has indentations and forces; it needs a column of travel"
        )
    return (curve,)


def read_segment(file: str | os.PathLike[str], segment: str = "record", **options: Any) -> MeasuredCurve:
    """One part of the only record of a file, as it was measured, but with the signs of pymdr."""
    if segment not in _PARTS:
        raise ProblemError(f"segment = {shown(segment)}; it must be one of {', '.join(_PARTS)}")
    parts = read_curves(file, **options)
    if len({one.metadata["record"] for one in parts}) > 1:
        raise ProblemError(
            f"{os.fspath(file)}: the file holds several records; read them with read_prepared_curves"
        )
    if segment == "record":
        return parts[0].join(*parts[1:])
    chosen = next((one for one in parts if one.segment == segment), None)
    if chosen is None:
        there = ", ".join(one.segment for one in parts)
        raise ProblemError(
            f"{os.fspath(file)}: the record has no {segment} (it has {there}); choose another segment"
        )
    return chosen


def _ready(parts: Sequence[MeasuredCurve], segment: str, keep_signs: bool | None) -> MeasuredCurve:
    """One record with its signs, marks and baseline, which is that of its approach."""
    whole = parts[0].join(*parts[1:]).mark_outliers()
    oriented = whole.orient(keep_signs=keep_signs)
    signs = oriented.step
    assert signs is not None
    # segments are named by the travel of the probe, once its sign is known
    turned = [one.mark_outliers().orient(signs.numbers) for one in parts]
    approach = next((one for one in turned if one.segment == "approach"), None)
    if approach is None:
        raise ProblemError(
            "the record has no approach; its baseline is fitted to the free part of the approach"
        )
    baseline = approach.baseline()
    if segment == "record":
        return oriented.mark_saturated().subtract_baseline(baseline)
    chosen = next((one for one in turned if one.segment == segment), None)
    if chosen is None:
        raise ProblemError(f"the record has no {segment}; choose another segment")
    return chosen.mark_saturated().subtract_baseline(baseline)


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
        One value for each curve by name, such as contact points.

    Returns
    -------
    xarray.Dataset
        ``force`` (N) and ``travel`` or ``indentation`` (m), ``time`` (s) where all have it, over the pixels ``y`` and ``x`` with
        their places in m, or ``curve`` of a single one and where one has none, and ``sample``; shorter ones, samples that are marked and pixels without a
        curve are nan; ``spring_constant`` (N/m), and the numbers.

    Raises
    ------
    ProblemError
        If there is no curve, some have travel and others indentation, two lie in the same pixel, or `numbers` has not one value for
        each curve.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(0.0, 1e-6, 50)
    >>> curves = [mdr.MeasuredCurve(force=k * depth**1.5, indentation=depth) for k in (1.0, 2.0)]
    >>> mdr.stack_curves(curves).sizes["sample"]
    50
    """
    some = list(curves)
    channel = "travel" if some and some[0].travel is not None else "indentation"
    if not some or any((one.travel is None) != (channel == "indentation") for one in some):
        raise ProblemError("curves are needed, all with travel or all with indentation")
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
            raise ProblemError(f"{len(each)} numbers {shown(name)} for {len(some)} curves; give one for each")
        data[name] = "curve", np.asarray(each, dtype=float)
    return _on_pixels(data, some)


def _on_pixels(data: xr.Dataset, curves: Sequence[MeasuredCurve]) -> xr.Dataset:
    """Variables over curves, rearranged over the pixels of the curves; pixels without a curve are missing."""
    if len(curves) < 2 or any(f"grid index {axis}" not in one.metadata for one in curves for axis in "xy"):
        return data
    pixels = [tuple(int(float(curve.metadata[f"grid index {axis}"])) for axis in "yx") for curve in curves]
    if len(set(pixels)) < len(curves):
        raise ProblemError(
            "two curves lie in the same pixel; give one segment of each record, such as the approach"
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
    """A number of the grid from the metadata of the first curve."""
    return float(curves[0].metadata.get(f"grid {what} {axis}", otherwise))
