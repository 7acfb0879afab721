"""Errors of maps by uncertainties of known numbers that all curves share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pymdr.errors import ProblemError
from pymdr.solving.fits.calibrations import (
    NO_DEFLECTION,
    SENSITIVITY,
    SPRING_CONSTANT,
    half_width,
    refuse_beyond_limits,
    refuse_unnamed,
    relative_uncertainty,
    with_moved_parameter,
)
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.request import FITTED, HIGH, LOW, SYSTEMATIC, WIDTH, Columns, FitRequest
from pymdr.solving.fits.unknowns import BASELINE
from pymdr.units import FloatArray, QuantityLike

_SIDES = (1.0, -1.0)


def refuse_uncertainty(request: FitRequest, stretch: Stretch) -> None:
    """
    Refuse wrong uncertainties of a request before its curves are fitted.

    Raises
    ------
    ProblemError
    """
    refuse_unnamed(request.uncertainty)
    for name, given in request.uncertainty.items():
        if all(_changed(request, stretch, name, given, side) is None for side in _SIDES):
            refuse_beyond_limits(name, given)


def put_systematic(
    request: FitRequest,
    stretch: Stretch,
    columns: Columns,
    refit: Callable[[FitRequest, Stretch], Columns],
) -> None:
    """
    Write the standard errors by the uncertainties of a request, and the intervals that contain them.

    The curves are fitted again with each known number one standard uncertainty off to either side, as by
    :func:`pymdr.solving.fits.calibrations.with_uncertainty`.
    """
    squares = {name: np.zeros(len(stretch.place)) for name in request.names}
    for name, given in request.uncertainty.items():
        ends = [
            refit(*changed)
            for side in _SIDES
            if (changed := _changed(request, stretch, name, given, side)) is not None
        ]
        for one in request.names:
            squares[one] += _change([_fitted(end, one) for end in ends], columns[one]) ** 2
    sizes = {u.name for u in request.unknowns if u.is_size}
    for name, square in squares.items():
        value, half = (
            columns[name],
            half_width(columns[f"{name}_error"], columns.pop(f"{name}{WIDTH}"), square),
        )
        columns[f"{name}{SYSTEMATIC}"][:] = np.sqrt(square)
        if name not in sizes:
            low, high = value - half, value + half
        else:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # curves that are not fitted
                factor = np.exp(half / value)
                low, high = value / factor, value * factor
        columns[f"{name}{LOW}"][:], columns[f"{name}{HIGH}"][:] = low, high


def _fitted(columns: Columns, name: str) -> FloatArray:
    """Values of the curves that were fitted; NaN of others."""
    return np.where(columns["ending"] == FITTED, columns[name], np.nan)


def _change(ends: list[FloatArray], here: FloatArray) -> FloatArray:
    """Half the difference of two ends, or the difference of the only one from the middle."""
    if len(ends) == 1:
        return ends[0] - here
    up, down = (end - here for end in ends)
    return np.where(np.isnan(up), down, np.where(np.isnan(down), up, 0.5 * (up - down)))


def _changed(
    request: FitRequest, stretch: Stretch, name: str, given: QuantityLike, side: float
) -> tuple[FitRequest, Stretch] | None:
    """Request and curves with a known number that is one standard uncertainty off; None if it would leave its limits."""
    plain = replace(request, uncertainty={}, limits={})
    if name not in (SPRING_CONSTANT, SENSITIVITY):
        contact = with_moved_parameter(request.contact, request.names, name, given, side)
        return None if contact is None else (replace(plain, contact=contact), stretch)
    # as of one record, 1 where no spring constant is known
    constants = 1.0 / np.where(stretch.softness > 0.0, stretch.softness, 1.0)
    if name == SENSITIVITY and np.any(stretch.softness == 0.0):
        raise ProblemError(NO_DEFLECTION)
    factors = np.ones(constants.size)
    for constant in np.unique(constants):
        value, unit = (float(constant), "N/m") if name == SPRING_CONSTANT else (1.0, "")
        factors[constants == constant] += side * relative_uncertainty(given, value, unit, name)
    # the known baseline of a map is one for all curves: their forces are multiplied above it
    level = request.known.get(BASELINE, 0.0)
    softness = stretch.softness / factors if name == SPRING_CONSTANT else stretch.softness
    force = level + factors[:, None] * (stretch.force - level)
    return plain, stretch._replace(force=force, softness=softness)
