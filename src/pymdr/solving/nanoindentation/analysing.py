"""Hardness and moduli of one indent, with intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.profiles import AreaFunction
from pymdr.solving.fits.spectrum import NORMAL_95, white_priors
from pymdr.solving.nanoindentation.records import Record
from pymdr.solving.nanoindentation.unloading import (
    Peak,
    Shape,
    Unloading,
    fitted_power,
    fitted_shape,
    peak_of,
    refitted,
    unloading_of,
)
from pymdr.units import FloatArray, metres, pascals

UNITS = {
    "stiffness": "N/m",
    "epsilon": "",
    "max_depth": "m",
    "residual_depth": "m",
    "contact_depth": "m",
    "exponent": "",
    "contact_area": "m^2",
    "hardness": "Pa",
    "reduced_modulus": "Pa",
    "plane_strain_modulus": "Pa",
    "young_modulus": "Pa",
}
"""SI units of the evaluated quantities, which have intervals."""
_LINEAR = ("max_depth", "residual_depth", "contact_depth", "exponent")
"""Quantities with symmetric intervals; those of the others are symmetric in logarithms."""
STEP = 1e-2
"""Step of numerical differences, in standard deviations."""
PROCEDURES = ("power_law", "effective_shape")


@dataclass(frozen=True)
class Settings:
    """Known data of tip, frame and area function."""

    area: AreaFunction
    frame: float
    """Compliance in m/N."""
    covariance: FloatArray | None
    """Of the compliance of the frame and the coefficients of the area, if they were calibrated."""
    tip: float
    """1/E* of the tip in 1/Pa."""
    poisson: float | None
    beta: float
    epsilon: float | None
    limits: tuple[float, float]


class Evaluated(NamedTuple):
    """One indent by one procedure."""

    values: Mapping[str, float]
    low: Mapping[str, float]
    high: Mapping[str, float]
    shape: Shape
    peak: Peak


class Indent(NamedTuple):
    """One indent by both procedures."""

    rows: Unloading
    by: Mapping[str, Evaluated]


def common_priors(white: Sequence[float]) -> list[float]:
    """Prior probability of white noise in each unloading, from that by each alone: all come from the same instrument."""
    return white_priors(np.array(white), 0.5).tolist() if len(white) > 1 else [0.5]


def whiteness(record: Record, frame: float, limits: tuple[float, float]) -> float:
    """Probability that the noise of an unloading is white, by its own rows."""
    return fitted_power(unloading_of(record, frame, limits)).errors.white


def evaluated(record: Record, settings: Settings, prior: float = 0.5) -> Indent:
    """
    Evaluate one indent by the power law of Oliver and Pharr, and by the effective shape of its unloading.

    Parameters
    ----------
    record : Record
        With measured depths, the deflection of the frame included.
    """
    rows = unloading_of(record, settings.frame, settings.limits)
    exact = replace(settings, beta=1.0, epsilon=None)
    return Indent(
        rows,
        {
            "power_law": _with_interval(rows, fitted_power(rows, prior), settings),
            "effective_shape": _with_interval(rows, fitted_shape(rows, prior), exact),
        },
    )


def quantities(peak: Peak, settings: Settings, further: float = 0.0) -> dict[str, float]:
    """Hardness and moduli at the peak of an indent, whose frame is more compliant by `further` m/N than its rows were corrected for."""
    if not further * peak.stiffness < 1.0:
        raise ProblemError("the stiffness is not above 0 N/m without the frame; check the frame compliance")
    stiffness = 1.0 / (1.0 / peak.stiffness - further)
    depth = peak.depth - further * peak.force
    contact_depth = depth - peak.epsilon * peak.force / stiffness
    area = float(settings.area.area_at(contact_depth)) if contact_depth > 0.0 else math.nan
    if not area > 0.0:
        raise ProblemError(
            f"the contact depth is {metres(contact_depth)}, where the area function has no area; the depth must count from the "
            "first contact and lie within the range of the area function"
        )
    reduced = math.sqrt(math.pi / area) * stiffness / (2.0 * settings.beta)
    if not reduced * settings.tip < 1.0:
        raise ProblemError(
            f"the reduced modulus, {pascals(reduced)}, is not below that of the tip alone, {pascals(1.0 / settings.tip)}; check "
            "the units, the area function and the frame compliance"
        )
    plane = 1.0 / (1.0 / reduced - settings.tip)
    result = {
        "stiffness": stiffness,
        "epsilon": peak.epsilon,
        "max_depth": depth,
        "residual_depth": peak.residual_depth,
        "contact_depth": contact_depth,
        "exponent": peak.exponent,
        "contact_area": area,
        "hardness": peak.force / area,
        "reduced_modulus": reduced,
        "plane_strain_modulus": plane,
    }
    return (
        result
        if settings.poisson is None
        else {**result, "young_modulus": plane * (1.0 - settings.poisson**2)}
    )


def peak_with_covariance(
    rows: Unloading, shape: Shape, epsilon: float | None, read: Callable[[Peak], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Values at the peak, and their covariance from the noise of the rows and the uncertainty of a drift."""
    centre = np.append(shape.parameters, rows.peak_force)
    covariance = np.zeros((centre.size, centre.size))
    covariance[:-1, :-1] = shape.errors.covariance
    covariance[-1, -1] = rows.peak_error**2

    def at(values: FloatArray) -> FloatArray:
        return read(peak_of(shape.anchor, values[:-1], float(values[-1]), epsilon))

    slopes = differences(at, centre, covariance)
    covariance = slopes @ covariance @ slopes.T
    if rows.elapsed is not None and rows.rate_error > 0.0:
        less, more = (
            at(np.append(refitted(rows, shape, sign * STEP * rows.rate_error), rows.peak_force))
            for sign in (-1.0, 1.0)
        )
        # a deviation of the rate by one standard deviation
        deviation = (more - less) / (2.0 * STEP)
        covariance = covariance + np.outer(deviation, deviation)
    return at(centre), covariance


def differences(
    function: Callable[[FloatArray], FloatArray], centre: FloatArray, covariance: FloatArray
) -> FloatArray:
    """Derivatives by numbers of a covariance, by differences over parts of their standard deviations."""
    columns = []
    for i, deviation in enumerate(np.sqrt(np.diag(covariance))):
        step = np.zeros(centre.size)
        step[i] = max(STEP * float(deviation), 1e-9 * abs(float(centre[i])))
        if not step[i]:
            columns.append(np.zeros_like(function(centre)))
            continue
        columns.append((function(centre + step) - function(centre - step)) / (2.0 * step[i]))
    return np.stack(columns, axis=1)


def _with_interval(rows: Unloading, shape: Shape, settings: Settings) -> Evaluated:
    """One procedure with 95 % intervals."""
    peak = peak_of(shape.anchor, shape.parameters, rows.peak_force, settings.epsilon)
    values = quantities(peak, settings)

    def scaled(result: Mapping[str, float]) -> FloatArray:
        return np.array([result[name] if name in _LINEAR else math.log(result[name]) for name in values])

    def read(result: Peak) -> FloatArray:
        return scaled(quantities(result, settings))

    centre, covariance = peak_with_covariance(rows, shape, settings.epsilon, read)
    if settings.covariance is not None:
        coefficients = settings.area.coefficients
        assert coefficients is not None

        def calibrated(numbers: FloatArray) -> FloatArray:
            area = replace(settings.area, coefficients=numbers[1:])
            return scaled(quantities(peak, replace(settings, area=area), float(numbers[0])))

        slopes = differences(calibrated, np.append(0.0, coefficients), settings.covariance)
        covariance = covariance + slopes @ settings.covariance @ slopes.T
    half = NORMAL_95 * np.sqrt(np.diag(covariance))
    ends = (centre - half, centre + half)
    low, high = (
        {name: float(x if name in _LINEAR else np.exp(x)) for name, x in zip(values, end, strict=True)}
        for end in ends
    )
    return Evaluated(values, low, high, shape, peak)
