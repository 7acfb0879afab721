"""Thermal drift from a hold at constant force, and records that are corrected for it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.presentation import plot
from pymdr.solving.fits.spectrum import NORMAL_95
from pymdr.solving.nanoindentation.records import (
    CorrectedRecords,
    Record,
    Records,
    attempted,
    labels_of,
    numbered,
    records_of,
    refusals,
)
from pymdr.solving.nanoindentation.unloading import errors_of, noise_of
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray, QuantityLike, shown, to_si

_FEWEST = 12
"""Rows of a hold to which a rate is fitted."""
_BAND, _NOISES = 0.005, 5.0
"""Half width of the forces of a hold, in parts of the largest force and in noises."""
_LEVELS = (0.02, 0.9)
"""Forces of a hold, in parts of the largest; holds at the peak show creep."""
_LONGER = 5.0
"""How much longer a hold lasts than the unloading takes for its band of forces."""
_LARGEST, _STEADY = 0.1, 3.0
_DRAWN = 6


class _Hold(NamedTuple):
    """The rate of one hold."""

    rows: slice
    """Of the record."""
    fitted: slice
    """Those to which the rate is fitted."""
    rate: float
    half: float
    """Half of the 95 % interval of the rate in m/s."""
    start: float
    """Depth in m of the fit at the first fitted row."""
    change: float
    """Change of the rate over the hold in m/s."""
    change_error: float
    """Standard deviation of the change in m/s."""


@dataclass(frozen=True, kw_only=True)
class ThermalDrift(Study, CorrectedRecords):
    """
    The rates of thermal drift over ``indent``, and the corrected records.

    ``rate`` with the ends of its 95 % interval, ``rate_low`` and ``rate_high``, ``rate_change`` over the hold (m/s), ``hold_start`` and
    ``hold_end`` (s), ``hold_force`` (N), and ``correction`` (m), the largest one of a depth.
    """

    holds: tuple[tuple[FloatArray, FloatArray, FloatArray], ...]
    """Times in s and depths in m of each hold, and the depths of the fit."""

    subject: ClassVar[str] = "a thermal drift"
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "indent": Column("indent", ""),
        "record": Column("record", ""),
        "rate": Column("rate", "m/s"),
        "rate_low": Column("low", "m/s"),
        "rate_high": Column("high", "m/s"),
        "rate_change": Column("change", "m/s"),
        "hold_force": Column("F", "N"),
        "hold_start": Column("from", "s"),
        "hold_end": Column("to", "s"),
        "correction": Column("correction", "m"),
    }

    def _figure(self) -> mpl.figure.Figure:
        """Depths in the holds with the fitted lines, and the rates."""
        return plot.drift_study(self.holds[:_DRAWN], self.data)


def thermal_drift(
    records: Records,
    *,
    hold: Sequence[QuantityLike] | None = None,
    settle: float = 0.2,
) -> ThermalDrift:
    """
    Rate of the thermal drift from a hold at constant force, and the records without it.

    The depth in the hold is h0 + r t + c (F - mean F); r is the rate. The corrected depth is h - r (t - t0), where t0 is the last time before the
    peak at which the depth is not above 0, or the first of the record.

    Parameters
    ----------
    records : MeasuredCurve, xarray.Dataset or mapping of str to array_like, or a sequence of them
        Indents with times, depths and forces. Depths count from the first contact.
    hold : sequence of two quantities, optional
        Start and end of the hold in s. By default the longest segment of constant force after the peak, at 2 to 90 % of the largest force.
    settle : float, optional
        Fraction of the hold, at its start, that is left out because the sample still recovers; 0.2 unless given.

    Returns
    -------
    ThermalDrift
        :func:`pymdr.oliver_pharr`, :func:`pymdr.calibrate_area` and :func:`pymdr.continuous_stiffness` take it in place of the records; the uncertainty of
        the rate then enters their intervals. Of several indents, those without a rate are nan, and a note gives the reason.

    Raises
    ------
    ProblemError
        If no record has times and a hold of at least 12 rows, or an argument is outside its limits.

    See Also
    --------
    oliver_pharr : hardness and modulus of the corrected records.

    Notes
    -----
    The procedure of Oliver and Pharr (1992): the rate in a hold at low force during the unloading is taken for that of the whole test. Creep and recovery
    of the sample cannot be distinguished from drift; `rate_change` shows them if they fade within the hold, and the interval then contains half of it.

    References
    ----------
    Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> part = np.concatenate([np.linspace(0, 1, 100), np.linspace(1, 0.1, 90), np.full(200, 0.1), np.linspace(0.1, 0, 10)])
    >>> time = 0.25 * np.arange(400)
    >>> depth = 150e-9 + 50e-9 * part ** 0.7 + 0.1e-9 * time
    >>> depth[:100] = 200e-9 * np.sqrt(part[:100]) + 0.1e-9 * time[:100]
    >>> drift = mdr.thermal_drift(mdr.MeasuredCurve(force=1e-3 * part, indentation=depth, time=time))
    >>> drift.to("rate", "nm/s").values.round(3).tolist()
    [0.1]
    """
    listed = records_of(records)
    given = None if hold is None else _given_hold(hold)
    if isinstance(settle, bool) or not isinstance(settle, int | float) or not 0.0 <= settle <= 0.9:
        raise ProblemError(f"settle = {shown(settle)}; a fraction of the hold from 0 to 0.9 is needed")
    errors: dict[int, ProblemError] = {}
    holds = attempted(listed, lambda _, record: _hold_of(record, given, settle), errors)
    return _study(listed, holds, errors)


def _given_hold(hold: Sequence[QuantityLike]) -> tuple[float, float]:
    try:
        start, end = hold
    except (TypeError, ValueError):
        raise ProblemError(
            f"hold = {shown(hold)}; start and end are needed, such as ('60 s', '90 s')"
        ) from None
    first, last = to_si(start, "s", name="hold[0]"), to_si(end, "s", name="hold[1]")
    if not first < last:
        raise ProblemError(f"hold = {shown(hold)}; the end must be after the start")
    return first, last


def _hold_of(record: Record, given: tuple[float, float] | None, settle: float) -> _Hold:
    time, force = record.time, record.force
    if time is None:
        raise ProblemError("the record has no times; a drift needs a column time [s]")
    if not float(np.max(force)) > 0.0:
        raise ProblemError("no force is above 0 N; compressive forces must be positive")
    rows = _longest_hold(time, force) if given is None else _between(time, given)
    settled = time[rows.start] + settle * (time[rows.stop - 1] - time[rows.start])
    fitted = slice(int(np.searchsorted(time, settled)), rows.stop)
    if fitted.stop - fitted.start < _FEWEST:
        raise ProblemError(
            f"{fitted.stop - fitted.start} rows of the hold after it settled; at least {_FEWEST} are needed"
        )
    return _fitted_hold(record, time, rows, fitted)


def _between(time: FloatArray, given: tuple[float, float]) -> slice:
    first = int(np.searchsorted(time, given[0], side="left"))
    last = int(np.searchsorted(time, given[1], side="right"))
    if last - first < _FEWEST:
        raise ProblemError(
            f"{last - first} rows are between {given[0]:g} s and {given[1]:g} s, the record is from {time[0]:g} s to {time[-1]:g} s; at "
            f"least {_FEWEST} are needed in the hold"
        )
    return slice(first, last)


def _longest_hold(time: FloatArray, force: FloatArray) -> slice:
    """The longest stretch of nearly constant force after the peak."""
    peak = float(np.max(force))
    band = max(_BAND * peak, _NOISES * noise_of(force))
    last = int(np.flatnonzero(force >= peak - band)[-1])
    after = force[last:]
    best, longest, start = slice(0, 0), 0.0, 0
    # two pointers with monotone queues of the smallest and the largest force
    small: list[int] = []
    large: list[int] = []
    heads = [0, 0]
    for i, value in enumerate(after):
        for queue, sign, k in ((small, 1.0, 0), (large, -1.0, 1)):
            while len(queue) > heads[k] and sign * after[queue[-1]] >= sign * value:
                queue.pop()
            queue.append(i)
        while after[large[heads[1]]] - after[small[heads[0]]] > 2.0 * band:
            start = min(small[heads[0]], large[heads[1]]) + 1
            for k, queue in ((0, small), (1, large)):
                while queue[heads[k]] < start:
                    heads[k] += 1
        level = float(after[(start + i) // 2])
        duration = float(time[last + i] - time[last + start])
        if duration > longest and _LEVELS[0] * peak <= level <= _LEVELS[1] * peak:
            best, longest = slice(last + start, last + i + 1), duration
    elsewhere = float(time[-1] - time[last]) - longest
    if best.stop - best.start < _FEWEST or not longest * peak > _LONGER * 2.0 * band * elsewhere:
        raise ProblemError(
            f"no hold at constant force is after the peak, at {_LEVELS[0]:g} to {_LEVELS[1]:g} of the largest force; give hold, such as 60 s to 90 s, or a "
            "record with such a hold"
        )
    return best


def _fitted_hold(record: Record, time: FloatArray, rows: slice, fitted: slice) -> _Hold:
    t, h, force = time[fitted], record.depth[fitted], record.force[fitted]
    middle, span = 0.5 * (t[0] + t[-1]), t[-1] - t[0]
    x = (t - middle) / span
    columns = [np.ones_like(x), x]
    varying = force - force.mean()
    if float(np.max(np.abs(varying))) > 1e-12 * float(np.max(np.abs(record.force))):
        columns.append(varying / np.max(np.abs(varying)))
    linear = _least_squares(np.stack(columns, axis=1), h)
    curved = _least_squares(np.stack([*columns, x * x - 1.0 / 12.0], axis=1), h)
    # the rate at the end less that at the start of h = q x^2 is 2 q per span
    change, change_error = 2.0 * curved[0][-1] / span, 2.0 * math.sqrt(curved[1][-1, -1]) / span
    rate, half = linear[0][1] / span, NORMAL_95 * math.sqrt(linear[1][1, 1]) / span
    if abs(change) > NORMAL_95 * change_error:
        half = math.hypot(half, 0.5 * change)
    start = float(linear[0][0] - 0.5 * linear[0][1])
    return _Hold(rows, fitted, float(rate), float(half), start, float(change), float(change_error))


def _least_squares(design: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parameters, and their covariance with correlated residuals."""
    parameters = np.asarray(np.linalg.lstsq(design, values, rcond=None)[0])
    return parameters, errors_of(values - design @ parameters, design).covariance


def _corrected(record: Record, hold: _Hold) -> Record:
    """The record without its hold, its depths without drift."""
    assert record.time is not None
    peak = int(np.argmax(record.force))
    before = np.flatnonzero(record.depth[: peak + 1] <= 0.0)
    elapsed = record.time - record.time[before[-1] if before.size else 0]
    whole = record._replace(
        depth=record.depth - hold.rate * elapsed, elapsed=elapsed, rate_error=hold.half / NORMAL_95
    )
    return whole.without(slice(hold.rows.start + 1, hold.rows.stop - 1))


def _study(
    listed: Sequence[Record], by_number: Mapping[int, _Hold], errors: Mapping[int, ProblemError]
) -> ThermalDrift:
    there = np.array([number in by_number for number in range(1, len(listed) + 1)])
    holds, known = list(by_number.values()), [listed[number - 1] for number in by_number]
    corrected = [_corrected(record, one) for record, one in zip(known, holds, strict=True)]
    times = [record.time for record in known if record.time is not None]
    rate, half = np.array([one.rate for one in holds]), np.array([one.half for one in holds])
    correction = np.array(
        [
            one.rate * float(record.elapsed[np.argmax(np.abs(record.elapsed))])
            for record, one in zip(corrected, holds, strict=True)
            if record.elapsed is not None
        ]
    )
    columns = {
        "rate": (rate, "m/s"),
        "rate_low": (rate - half, "m/s"),
        "rate_high": (rate + half, "m/s"),
        "rate_change": (np.array([one.change for one in holds]), "m/s"),
        "hold_force": (
            np.array([float(r.force[o.fitted].mean()) for r, o in zip(known, holds, strict=True)]),
            "N",
        ),
        "hold_start": (np.array([t[o.fitted.start] for t, o in zip(times, holds, strict=True)]), "s"),
        "hold_end": (np.array([t[o.fitted.stop - 1] for t, o in zip(times, holds, strict=True)]), "s"),
        "correction": (correction, "m"),
    }
    largest = np.array([float(np.max(record.depth)) for record in known])
    claim = Claim(
        Level.APPROXIMATE,
        "the rate in the hold is assumed for the complete test; creep and recovery of the sample cannot be distinguished from drift",
        SOURCES["oliver-pharr"],
        there,
    )
    unsteady = max(abs(one.change) / one.change_error if one.change_error > 0.0 else 0.0 for one in holds)
    return ThermalDrift(
        data=dataset(
            {
                name: ("indent", _over_all(values, there), {"units": unit})
                for name, (values, unit) in columns.items()
            },
            coords=numbered(listed),
        ),
        claims=dict.fromkeys(("rate", "rate_change", "correction"), claim),
        assumptions=(
            Assumption(
                "steady drift",
                "change of the rate over the hold, in standard deviations; above the limit the sample creeps or recovers, or the drift is not steady",
                float(unsteady),
                _STEADY,
            ),
            Assumption(
                "drift",
                "largest correction over the largest depth; its uncertainty grows with the time since contact",
                float(np.max(np.abs(correction) / largest)),
                _LARGEST,
            ),
        ),
        notes=tuple(refusals(errors)),
        references=("oliver-pharr",),
        corrected=_with_refusals(listed, dict(zip(by_number, corrected, strict=True)), errors),
        holds=tuple(
            (t[o.fitted], r.depth[o.fitted], o.start + o.rate * (t[o.fitted] - t[o.fitted.start]))
            for t, r, o in zip(times, known, holds, strict=True)
        ),
    )


def _over_all(values: FloatArray, there: BoolArray) -> FloatArray:
    """Numbers over all indents, nan where there is none."""
    column = np.full(there.size, math.nan)
    column[there] = values
    return column


def _with_refusals(
    listed: Sequence[Record], corrected: Mapping[int, Record], errors: Mapping[int, ProblemError]
) -> tuple[Record, ...]:
    """The corrected records, and those that could not be corrected with the reason."""
    return tuple(
        corrected[number]
        if number in corrected
        else record._replace(refusal=str(errors[number]).removeprefix(f"{label}: "))
        for number, (record, label) in enumerate(zip(listed, labels_of(listed), strict=True), 1)
    )
