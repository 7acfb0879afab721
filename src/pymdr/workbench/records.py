"""Loops of measured records: energy per cycle and equivalent damping."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import Claim
from pymdr.presentation import plot
from pymdr.problem.values import within_range
from pymdr.result import Result
from pymdr.solving.study import Column, Study
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si, written

_PAIRS = (("shift", "tangential_force"), ("indentation", "normal_force"), ("travel", "normal_force"))
"""Displacements and the forces that work on them."""
_OF_LOOPS = 5
"""Number of the columns that every loop has; the others need a contact."""
_CLOSED = 0.05
"""Distance between the ends of a cycle, relative to its first swing, up to which its loop counts as closed."""


@dataclass(frozen=True, kw_only=True)
class MeasuredLoops(Study):
    """Cycles of a record, one after the other."""

    data: xr.Dataset
    """Over ``cycle``, counted from 1: amplitude (m), force_amplitude (N), dissipated_per_cycle (J), damping_ratio,
    secant_stiffness (N/m), and the rows first_row and last_row, counted from 1. Of a result with friction also
    stick_radius (m), the smallest of the cycle, contact_radius (m), the largest, and peak_shear_traction (Pa), the
    largest at the turning points of the cycle: points between both radii slip in every cycle."""
    curve: xr.Dataset
    """A displacement and the force that works on it in all rows, in SI units."""

    subject: ClassVar = "measured loops"
    columns: ClassVar = {
        "cycle": Column("cycle", ""),
        "amplitude": Column("amplitude", "m"),
        "force_amplitude": Column("force", "N"),
        "dissipated_per_cycle": Column("dissipated", "J"),
        "damping_ratio": Column("damping", ""),
        "secant_stiffness": Column("stiffness", "N/m"),
        "stick_radius": Column("stick radius", "m"),
        "contact_radius": Column("contact radius", "m"),
        "peak_shear_traction": Column("peak shear", "Pa"),
    }

    def _figure(self) -> mpl.figure.Figure:
        labels = {name: column.label for name, column in self.columns.items()}
        return plot.columns_study(self.data, labels, self.curve)

    def _remarks(self) -> list[str]:
        displacement, force = self.curve
        lines = [f"{force} over {displacement}"]
        if self.data.sizes["cycle"] > 1:
            columns = [
                (column, self.data[name].values) for name, column in self.columns.items() if name in self.data
            ][1:]
            known = [(column, values[~np.isnan(values)]) for column, values in columns]
            means = [f"{c.label} {written(float(v.mean()), c.unit)}" for c, v in known if v.size]
            lines.append(f"means of the cycles: {', '.join(means[:_OF_LOOPS])}")
            lines += [f"means of the contact: {', '.join(means[_OF_LOOPS:])}"] * (len(means) > _OF_LOOPS)
        return lines


def measured_loops(record: xr.Dataset | Result, *, least: QuantityLike | None = None) -> MeasuredLoops:
    """
    Energy per cycle and equivalent damping of a record of force and displacement.

    A cycle goes from a turning point of the displacement to the next but one. It dissipates the area of its loop,
    W = ∮ F du by straight lines between the samples, closed by one from its last sample to its first; offsets of
    force and displacement do not matter. Turns by less than `least` are no turning points. Notes name the rows before the
    first and after the last whole cycle, and cycles that end at another displacement than they begin. A record with two
    turning points has one cycle that ends with the record; if it ends before the loop is closed, its energy is nan.

    Parameters
    ----------
    record : xarray.Dataset or Result
        From :func:`pymdr.read_record`, or :func:`pymdr.solve` for the slip of the contact too, with ``shift`` and ``tangential_force``, else
        ``indentation`` (or ``travel``) and ``normal_force``, in the units that their attributes ``units`` name, or in
        SI units.
    least : quantity, optional
        The smallest swing in m that is a turn and not noise; a tenth of the range of the displacement unless given.

    Returns
    -------
    MeasuredLoops
        Over ``cycle``: amplitude (m), force amplitude (N), dissipation (J), damping ratio and secant stiffness (N/m).

    Raises
    ------
    ProblemError
        If a force or its displacement is missing, 0 in all rows or beyond all sizes, a value is not finite, or the
        displacement has fewer than two turning points.
    UnitError
        If the units of a column are not those of a length or a force.

    See Also
    --------
    friction_loop : the same of a contact.
    read_record : a record from a file.

    Notes
    -----
    With amplitudes u = (u_max - u_min) / 2 and F = (F(u_max) - F(u_min)) / 2 the damping ratio is W / (4 pi U) with
    U = F u / 2, that of the viscous damper which dissipates as much in a cycle (Jacobsen 1930), and the stiffness is
    the secant F / u. Where the force does not rise with the displacement, there is no damping ratio: nan. These are measured numbers: noise of the force adds to W about its standard deviation times
    the step of the displacement times the root of the number of samples, with either sign.

    References
    ----------
    Jacobsen (1930), Trans. ASME 52, APM-52-15, 169-181.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> import xarray as xr
    >>> t = np.linspace(0.0, 7.2 * np.pi, 7201)
    >>> u, force = 1e-6 * np.sin(t), 2.0 * np.sin(t + 0.1)
    >>> record = xr.Dataset({"shift": ("step", u), "tangential_force": ("step", force)})
    >>> loops = mdr.measured_loops(record)
    >>> loops.data.sizes["cycle"], round(float(loops["damping_ratio"][0]), 4)
    (3, 0.0502)
    """
    data = record.data if isinstance(record, Result) else record
    if not isinstance(data, xr.Dataset):
        raise ProblemError(
            f"{type(record).__name__} is not a record; give what read_record or solve returns, or an "
            "xarray.Dataset"
        )
    displacement, force = _pair(data)
    _check_rows(data, [name for name in (displacement, force, "time") if name in data])
    u, pull = _finite(data, displacement, "m"), _finite(data, force, "N")
    swing = float(np.ptp(u))
    threshold = _threshold(least, swing, displacement)
    within_range(swing, "m", f"the swing of {displacement}", size=True)
    within_range(float(np.max(np.abs(pull))), "N", f"the largest {force}", size=True)
    turns, is_single = _turns_of_cycles(displacement, u, threshold)
    first, middle, last = turns[:-2:2], turns[1:-1:2], turns[2::2]
    quantities = _cycles(u, pull, first, middle, last)
    open_loops = _open_loops(displacement, u, first, middle, last)
    if is_single and open_loops:
        open_loops = [_clear_energy(quantities, displacement, float(u[-1]), float(u[first[0]]))]
    cycles = xr.Dataset(
        {name: ("cycle", values, {"units": unit}) for name, (values, unit) in quantities.items()},
        coords={"cycle": np.arange(1, first.size + 1)},
    )
    if "time" in data:
        time = _in_si(data, "time", "s")
        cycles["duration"] = ("cycle", time[last] - time[first], {"units": "s"})
    claims: dict[str, Claim] = {}
    if isinstance(record, Result) and "stick_radius" in record.data:
        claims = _add_slip(cycles, record, first, middle, last)
    notes = (
        *_rows_outside(displacement, first, last, u.size),
        *open_loops,
        *_small_swings(displacement, u, first, last, threshold),
        *backward_loops(displacement, force, quantities["dissipated_per_cycle"][0]),
    )
    both = xr.Dataset({displacement: ("row", u), force: ("row", pull)})
    return MeasuredLoops(data=cycles, curve=both, claims=claims, notes=notes)


def _turns_of_cycles(displacement: str, u: FloatArray, threshold: float) -> tuple[np.ndarray, bool]:
    """The rows at which cycles begin and turn, and whether the record has one that ends with it."""
    turns = turning_points(u, threshold)
    if turns.size < 2:
        reverses = "reverses once" if turns.size else "never reverses"
        raise ProblemError(
            f"{displacement} {reverses} by more than {metres(threshold)}, but a cycle needs "
            "two reversals; give a smaller least, or a longer record"
        )
    is_single = turns.size == 2
    return np.append(turns, u.size - 1) if is_single else turns, is_single


def _threshold(least: QuantityLike | None, swing: float, displacement: str) -> float:
    """The smallest swing of a cycle in m, above 0."""
    threshold = 0.1 * swing if least is None else to_si(least, "m", name="least")
    if not threshold > 0.0:
        raise ProblemError(
            f"{displacement} does not change; give a record with motion"
            if least is None
            else f"least = {shown(least)}; it must be above 0 m"
        )
    return threshold


def _rows_outside(displacement: str, first: np.ndarray, last: np.ndarray, rows: int) -> list[str]:
    """Which rows of a record are in no cycle, and why."""
    outside = [(1, int(first[0])), (int(last[-1]) + 2, rows)]
    spans = [f"{begin} to {end}" for begin, end in outside if begin <= end]
    if not spans:
        return []
    return [
        f"rows {' and '.join(spans)} of {rows} are in no cycle: a cycle begins and ends at a turning point of {displacement}"
    ]


def _open_loops(
    displacement: str, u: FloatArray, first: np.ndarray, middle: np.ndarray, last: np.ndarray
) -> list[str]:
    """Which cycles end at another displacement than they begin."""
    shifted = np.abs(u[last] - u[first])
    is_open = np.flatnonzero(shifted > _CLOSED * np.abs(u[first] - u[middle]))
    if is_open.size == 0:
        return []
    largest = int(is_open[np.argmax(shifted[is_open])])
    others = f" and {is_open.size - 1} more end" if is_open.size > 1 else " ends"
    return [
        f"cycle {largest + 1}{others} at another {displacement} than at the beginning (by {metres(float(shifted[largest]))}): "
        "the amplitude is that of the first half, and a straight line closes the loop"
    ]


def _clear_energy(
    quantities: dict[str, tuple[np.ndarray, str]], displacement: str, end: float, begin: float
) -> str:
    """Clear what a loop without its end does not determine; return the reason."""
    for name in ("dissipated_per_cycle", "damping_ratio"):
        quantities[name][0][:] = math.nan
    return (
        f"the record ends at {displacement} = {metres(end)} before its only cycle closes at {metres(begin)}: the "
        "cycle has no energy and no damping; give two cycles or a longer record"
    )


def _small_swings(
    displacement: str, u: FloatArray, first: np.ndarray, last: np.ndarray, threshold: float
) -> list[str]:
    """Which cycles contain swings that are hardly too small for cycles of their own."""
    finer = turning_points(u, 0.5 * threshold)
    inside = np.searchsorted(finer, last) - np.searchsorted(finer, first, side="right")
    several = np.flatnonzero(inside > 1)
    if several.size == 0:
        return []
    others = f" and {several.size - 1} more contain" if several.size > 1 else " contains"
    return [
        f"cycle {several[0] + 1}{others} turns of {displacement} by less than {metres(threshold)}, whose dissipation it includes; "
        f"if these are cycles and not noise, give a smaller least, such as {metres(0.5 * threshold)}"
    ]


def backward_loops(displacement: str, force: str, loss: np.ndarray) -> list[str]:
    """Which cycles give energy, as no contact does."""
    backward = int(np.count_nonzero(loss < 0.0))
    if backward <= loss.size // 2:
        return []
    return [
        f"{backward} of {loss.size} cycles give energy in place of dissipating it ({written(float(np.median(loss)), 'J')} per cycle): {displacement} and "
        f"{force} are interchanged, one of them has the opposite sign, or the rows run backward in time; exchange the columns, turn a sign or reverse the rows"
    ]


def _cycles(
    u: FloatArray, pull: FloatArray, first: np.ndarray, middle: np.ndarray, last: np.ndarray
) -> dict[str, tuple[np.ndarray, str]]:
    """Numbers of cycles between the rows at which they begin, turn and end, with their units."""
    amplitude = 0.5 * np.abs(u[first] - u[middle])
    stroke = 0.5 * (pull[first] - pull[middle]) * np.sign(u[first] - u[middle])
    loss = _areas(u, pull, first, last)
    with np.errstate(divide="ignore", invalid="ignore"):
        damping = np.where(stroke > 0.0, loss / (2.0 * math.pi * stroke * amplitude), math.nan)
    return {
        "amplitude": (amplitude, "m"),
        "force_amplitude": (stroke, "N"),
        "dissipated_per_cycle": (loss, "J"),
        "damping_ratio": (damping, ""),
        "secant_stiffness": (stroke / amplitude, "N/m"),
        "first_row": (first + 1, ""),
        "last_row": (last + 1, ""),
    }


def _check_rows(data: xr.Dataset, columns: list[str]) -> None:
    """Refuse columns that do not belong to the same rows, and fewer than two rows."""
    if data[columns[0]].ndim != 1 or len({data[name].dims for name in columns}) > 1:
        over = "; ".join(
            f"{name} over {', '.join(map(str, data[name].dims)) or 'nothing'}" for name in columns
        )
        raise ProblemError(f"{over}; all must be over the same one dimension, such as step")
    if data[columns[0]].size < 2:
        rows = "one row" if data[columns[0]].size else "no row"
        raise ProblemError(
            f"the record has {rows}, but a cycle needs two reversals of {columns[0]}; give a longer record"
        )


def _finite(data: xr.Dataset, name: str, unit: str) -> FloatArray:
    """A column in SI units that is known in all rows."""
    values = _in_si(data, name, unit)
    if not np.all(np.isfinite(values)):
        row = int(np.argmin(np.isfinite(values))) + 1
        raise ProblemError(f"{name} is missing in row {row}; leave such rows out")
    return values


def _add_slip(
    cycles: xr.Dataset, result: Result, first: FloatArray, middle: FloatArray, last: FloatArray
) -> dict[str, Claim]:
    """Add the stick and slip radii of the cycles, as far as they are valid; return the claims."""
    claims: dict[str, Claim] = {}
    spans = [slice(begin, end + 1) for begin, end in zip(first.tolist(), last.tolist(), strict=True)]
    for name, extreme in (("stick_radius", np.nanmin), ("contact_radius", np.nanmax)):
        if result.claims[name].readable:
            values = result[name].values
            claims[name] = _of_cycles(result.claims[name], len(spans))
            cycles[name] = ("cycle", [float(extreme(values[span])) for span in spans], {"units": "m"})
    if result.claims["shear_traction"].readable:
        peaks = {row: _peak_shear(result, row) for row in np.unique([first, middle, last]).tolist()}
        largest = [
            max(peaks[row] for row in turns) for turns in np.stack([first, middle, last], axis=1).tolist()
        ]
        claims["peak_shear_traction"] = _of_cycles(result.claims["shear_traction"], len(spans))
        cycles["peak_shear_traction"] = ("cycle", largest, {"units": "Pa"})
    return claims


def _of_cycles(claim: Claim, cycles: int) -> Claim:
    """The claim of the rows of a result as one of its cycles, with the largest error."""
    error = None if claim.error is None else np.full(cycles, np.nanmax(claim.error))
    return replace(claim, where=np.ones(cycles, dtype=bool), error=error)


def _peak_shear(result: Result, row: int) -> float:
    """The largest shear traction in Pa of a row, whose peak may be at the edge of stick."""
    grid = result.field("shear_traction", step=row)
    edge = result["stick_radius"].values[row] if result.claims["stick_radius"].readable else 0.0
    at_edge = result.field("shear_traction", r=[edge], step=row)
    return float(max(np.nanmax(np.abs(values)) for values in (grid.values, at_edge.values)))


def refuse_without_shift(data: xr.Dataset) -> None:
    """Refuse a tangential force without the displacement on which it works, which tables often call displacement."""
    if "tangential_force" in data and "shift" not in data:
        raise ProblemError(
            f"the record has a tangential force but no shift (it has {', '.join(map(str, data))}); name the column of the tangential "
            "displacement 'shift', for example 'shift [um]'; 'displacement' means the indentation"
        )


def _pair(data: xr.Dataset) -> tuple[str, str]:
    """The displacement of a record and the force that is conjugate to it."""
    refuse_without_shift(data)
    for displacement, force in _PAIRS:
        if displacement in data and force in data:
            return displacement, force
    wanted = " or ".join(f"{u} and {f}" for u, f in _PAIRS)
    raise ProblemError(f"{wanted} are needed; the record has {', '.join(map(str, data)) or 'none'}")


def _in_si(data: xr.Dataset, name: str, unit: str) -> FloatArray:
    """A column in SI units, converted from the unit in its attributes."""
    if data[name].dtype.kind not in "fiu":
        raise ProblemError(f"{name} is of {data[name].dtype}; it must be of real numbers")
    named = data[name].attrs.get("units", unit)
    factor = to_si(f"1 {named}", unit, name=f"unit of {name}")
    return factor * np.asarray(data[name].values, dtype=float)


def turning_points(values: FloatArray, least: float) -> FloatArray:
    """
    Indices of the extremes between which values swing by at least `least`, without those at both ends.

    Examples
    --------
    >>> turning_points(np.array([0.0, 1.0, 0.9, 1.1, 0.0, 0.1, -1.0, 0.0]), 0.5).tolist()
    [3, 6]
    """
    # only where the direction changes can there be an extreme
    steps = np.sign(np.diff(values))
    moving = np.flatnonzero(steps)
    inner = moving[1:][steps[moving[1:]] != steps[moving[:-1]]]
    candidates = np.concatenate([[0], inner, [values.size - 1]])
    heights = values[candidates].tolist()
    indices: list[int] = []
    low = high = 0
    rising: bool | None = None
    for i, height in enumerate(heights):
        if rising is not False and height >= heights[high]:
            high = i
        if rising is not True and height <= heights[low]:
            low = i
        if rising is not False and heights[high] - height >= least:
            indices.append(high)
            rising, low = False, i
        elif rising is not True and height - heights[low] >= least:
            indices.append(low)
            rising, high = True, i
    kept = [i for i in indices if 0 < candidates[i] < values.size - 1]
    return np.asarray(candidates[kept], dtype=int)


def _areas(u: FloatArray, force: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    """The areas of closed loops, about the middle of each, so that offsets cost no digits."""
    areas = np.empty(first.size)
    for i, (begin, end) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        x, y = u[begin : end + 1], force[begin : end + 1]
        x, y = x - x.mean(), y - y.mean()
        areas[i] = 0.5 * np.sum((y[1:] + y[:-1]) * np.diff(x)) + 0.5 * (y[0] + y[-1]) * (x[0] - x[-1])
    return areas
