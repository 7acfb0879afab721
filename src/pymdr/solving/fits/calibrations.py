"""Uncertainties of what is known, such as spring constants and tip radii, in the intervals of fits."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NoReturn

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import parameter_of, with_parameters
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.estimating import Estimate, with_intervals
from pymdr.solving.fits.minimizing import minimize_from, refuse_unsettled
from pymdr.solving.fits.results import Fitted
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.spectrum import NORMAL_95
from pymdr.solving.fits.unknowns import BASELINE
from pymdr.units import FloatArray, QuantityLike, shown, to_si, written

RECORD = "record"
"""Name of what the noise of the record and the numerics of the model contribute."""
SPRING_CONSTANT, SENSITIVITY = "spring_constant", "sensitivity"
_PERCENT = re.compile(r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))\s*%\s*\Z", re.ASCII)
_LARGEST = 0.5
"""Largest relative uncertainty; errors are propagated by one step to either side."""
NO_DEFLECTION = (
    "uncertainty of sensitivity: the record has indentations and no spring constant, from which its deflection follows; "
    "give travel and spring_constant"
)


def relative_uncertainty(given: QuantityLike, value: float, unit: str, name: str) -> float:
    """
    A standard uncertainty relative to a value.

    Parameters
    ----------
    given : quantity
        In percent, such as "10 %", or in the unit of the value.
    value : float
        In the unit.
    unit : str
        The SI unit; "" for a value that has no unit.
    name : str
        For messages.

    Examples
    --------
    >>> relative_uncertainty("10 %", 0.05, "N/m", "spring_constant")
    0.1
    >>> round(relative_uncertainty("2 mN/m", 0.05, "N/m", "spring_constant"), 12)
    0.04
    """
    percent = _PERCENT.match(given) if isinstance(given, str) else None
    if percent is not None:
        relative = float(percent[1]) / 100.0
    else:
        relative = to_si(given, unit, name=f"uncertainty[{name!r}]") / abs(value) if value else math.inf
    if not relative > 0.0:
        raise ProblemError(
            f"uncertainty of {name}: {shown(given)}; a standard uncertainty must be above 0, such as '5 %'"
        )
    if not relative <= _LARGEST:
        raise ProblemError(
            f"uncertainty of {name}: {shown(given)} is {100.0 * relative:.3g} % of {written(value, unit, 4)} (limit: 50 %); "
            "fit it as an unknown, or measure it better"
        )
    return relative


def refuse_unnamed(uncertainty: object) -> None:
    """Refuse uncertainties that are not given by name."""
    if not isinstance(uncertainty, Mapping) or not uncertainty:
        raise ProblemError(
            f"uncertainty = {shown(uncertainty)}; give standard uncertainties by name, such as {{'spring_constant': '10 %'}}"
        )


def refuse_beyond_limits(name: str, given: QuantityLike) -> NoReturn:
    """Refuse an uncertainty on neither side of which a parameter is valid."""
    raise ProblemError(
        f"uncertainty of {name}: {shown(given)} exceeds the limits of {name} on both sides; give a smaller one"
    )


def half_width(error: FloatArray, width: FloatArray, squares: FloatArray) -> FloatArray:
    """Half widths of 95 % intervals of errors by noise, whose own half widths are `width` errors, and of squares of normal errors."""
    return np.asarray(np.sqrt((width * error) ** 2 + NORMAL_95**2 * squares))


def with_uncertainty(
    estimate: Estimate, uncertainty: Mapping[str, QuantityLike]
) -> tuple[dict[str, Fitted], dict[str, dict[str, float]]]:
    """
    Fitted numbers whose intervals contain the uncertainties of known numbers, and the standard errors that come from each.

    Parameters
    ----------
    estimate : Estimate
        With the errors by noise.
    uncertainty : mapping of str to quantity
        Standard uncertainties by name: ``spring_constant``, ``sensitivity``, or a known parameter of the contact.

    Notes
    -----
    The record or the contact is changed by one standard uncertainty to either side, and fitted again; half the difference is the
    standard error. Uncertainties are independent of one another and of the noise, so that squares add up (JCGM 100:2008, 5.1.2).
    """
    search, best = estimate.search, estimate.best
    refuse_unnamed(uncertainty)
    if search.shears:
        raise ProblemError("uncertainty= is for force curves; records of friction have none")
    rates = search.rates(best)
    own = rates * estimate.errors
    contributions = {RECORD: dict(zip(search.names, own.tolist(), strict=True))}
    squares = np.zeros(best.size)
    for name, given in uncertainty.items():
        ends = [_moved(search, best, name, given, side) for side in (1.0, -1.0)]
        here = np.array([search.named(best)[one] for one in search.names])
        known = [end - here for end in ends if end is not None]
        if not known:
            refuse_beyond_limits(name, given)
        # at a limit, such as Poisson's ratio 0.5, only one side exists
        moved = 0.5 * (known[0] - known[1]) if len(known) == 2 else known[0]
        contributions[name] = dict(zip(search.names, np.abs(moved).tolist(), strict=True))
        squares += (moved / rates) ** 2
    total = np.sqrt(estimate.errors**2 + squares)
    with np.errstate(invalid="ignore", divide="ignore"):  # a record without noise, and unknowns at a bound
        half = half_width(estimate.errors, estimate.width, squares)
        width = np.where(total > 0.0, half / total, estimate.width)
    return with_intervals(search, best, total, width), contributions


def _moved(
    search: Search, best: FloatArray, name: str, given: QuantityLike, side: float
) -> FloatArray | None:
    """The fitted numbers with a known number one standard uncertainty off; None if it would leave its limits."""
    changed = _changed(search, name, given, side)
    if changed is None:
        return None
    minimum = minimize_from(changed, best)
    refuse_unsettled(minimum)
    named = changed.named(minimum.free)
    return np.array([named[one] for one in search.names])


def _changed(search: Search, name: str, given: QuantityLike, side: float) -> Search | None:
    """The search with a known number that is one standard uncertainty off; None if it would leave its limits."""
    if name in (SPRING_CONSTANT, SENSITIVITY):
        constants = [curve.spring_constant for curve in search.measured]
        value, unit = (constants[0] or 1.0, "N/m") if name == SPRING_CONSTANT else (1.0, "")
        factor = 1.0 + side * relative_uncertainty(given, value, unit, name)
        known = {k: v * factor if k == BASELINE else v for k, v in search.known.items()}
        change = _recalibrated if name == SPRING_CONSTANT else _with_sensitivity
        return replace(search, curves=tuple(change(one, factor) for one in search.measured), known=known)
    contact = with_moved_parameter(search.contact, search.names, name, given, side)
    return None if contact is None else replace(search, contact=contact)


def with_moved_parameter(
    contact: Contact, fitted: Sequence[str], name: str, given: QuantityLike, side: float
) -> Contact | None:
    """The contact with a known parameter one standard uncertainty off; None if it would leave its limits."""
    if name in fitted:
        raise ProblemError(
            f"uncertainty of {name}: it is fitted, and the fit gives its interval; leave it out of uncertainty or of free"
        )
    try:
        parameter = parameter_of(contact, name)
    except ProblemError as error:
        raise ProblemError(
            f"uncertainty of {SPRING_CONSTANT}, {SENSITIVITY} or a parameter of the contact: {error}"
        ) from None
    relative = relative_uncertainty(given, parameter.value, parameter.unit, name)
    try:
        return with_parameters(contact, {name: parameter.value * (1.0 + side * relative)})
    except ProblemError:
        return None


def _recalibrated(curve: MeasuredCurve, factor: float) -> MeasuredCurve:
    """The record of a cantilever of another spring constant; its deflection is kept."""
    constant = curve.spring_constant
    return replace(
        curve, force=factor * curve.force, spring_constant=None if constant is None else factor * constant
    )


def _with_sensitivity(curve: MeasuredCurve, factor: float) -> MeasuredCurve:
    """The record of another sensitivity: deflection and force are multiplied, the travel is kept."""
    if curve.indentation is None:
        return replace(curve, force=factor * curve.force)
    if curve.spring_constant is None:
        raise ProblemError(NO_DEFLECTION)
    deflection = curve.force / curve.spring_constant
    return replace(
        curve, force=factor * curve.force, indentation=curve.indentation - (factor - 1.0) * deflection
    )
