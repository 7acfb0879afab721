"""Common steps of solutions with memory: relaxation along a path, times, and assumptions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.accuracy import of_own_size
from pymdr.interpretation.layers import base_assumption
from pymdr.interpretation.thickness import thickness_assumption
from pymdr.interpretation.validity import Assumption, small_slope_assumptions
from pymdr.line.layered import LayeredLine
from pymdr.line.lines import unit_line_of
from pymdr.mapping.equivalent import slope_function
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.problem.contact import Contact
from pymdr.problem.fractional import PowerLawRheology
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Material, Viscoelastic
from pymdr.problem.paths import LoadingPath, Ramp
from pymdr.problem.schedule import Planned, Stretch, planned
from pymdr.units import FloatArray, metres

OWN_ERRORS = (
    "; the error of a value is its largest change up to that row with half as many springs and steps, relative to the value; "
    "that of a field is relative to the largest value of the field"
)
"""Text on the reference of relative errors."""
_PARTS = 100.0
"""Smallest number of equal parts of a path that determine the shortest relevant time."""
_LATER = 4
"""Number of later rows that contribute to the error of a row."""


def relaxation_along(contact: Contact, path: LoadingPath, time: FloatArray | None = None) -> Relaxation:
    """E*(t) of a contact, of layers that of the first; a power of time is represented over the times of the path, of which those known only from the rows are given."""
    return relaxation_of(*surfaces_of(contact), span=span_along(contact, path, time))


def surfaces_of(contact: Contact) -> tuple[Material, Material]:
    """The bodies of a contact; of a layered one the material of its first layer."""

    def surface(body: Material) -> Material:
        return body.layers[0].material if isinstance(body, Layered) else body

    return surface(contact.body), surface(contact.counterbody)


def tangential_relaxation_along(
    contact: Contact, path: LoadingPath, time: FloatArray | None = None
) -> Relaxation:
    """G*(t) of a contact, as `relaxation_along`."""
    return relaxation_of(
        contact.body, contact.counterbody, span=span_along(contact, path, time), tangential=True
    )


def span_along(
    contact: Contact, path: LoadingPath, time: FloatArray | None = None
) -> tuple[float, float] | None:
    """The shortest and the longest time of a path in s, if a power of time asks for them."""
    return times_along(path, time) if powers_of(contact) else None


def times_along(path: LoadingPath, time: FloatArray | None = None) -> tuple[float, float]:
    """The shortest and the longest time of a path in s, of which those known only from the rows are given."""
    if time is not None and has_times_of_rows(path):
        return _within([np.diff(time, prepend=0.0)], float(time[-1]))
    steps, now, here = [], 0.0, dict[str, float]()
    for before, leg in zip(*_neighbours(path), strict=True):
        if _led(before, leg):
            assert isinstance(leg.leg, Ramp)
            here |= {leg.controls.normal: getattr(leg.leg, leg.controls.normal)}
            continue
        with leg.named():
            stretch = leg.stretch(here, now)
            time = times_of(stretch)
        steps.append(np.diff(time, prepend=now))
        now, here = float(time[-1]), {**here, **stretch.end}
    return _within(steps, now)


def has_times_of_rows(path: LoadingPath) -> bool:
    """Whether times of a path are known only from the rows of a solution."""
    return any(map(_led, *_neighbours(path)))


def depends_on_rows(contact: Contact, path: LoadingPath) -> bool:
    """Whether the times that a power of time needs are known only from the rows of a solution."""
    return bool(powers_of(contact)) and has_times_of_rows(path)


def powers_of(contact: Contact) -> tuple[PowerLawRheology, ...]:
    """The powers of time by which bodies of a contact relax."""
    return tuple(
        one.shear
        for one in surfaces_of(contact)
        if isinstance(one, Viscoelastic) and isinstance(one.shear, PowerLawRheology)
    )


def _neighbours(path: LoadingPath) -> tuple[tuple[Planned | None, ...], tuple[Planned, ...]]:
    """The legs before the legs of a path, and these."""
    each = planned(path)
    return (None, *each[:-1]), each


def _led(before: Planned | None, leg: Planned) -> bool:
    """Whether the start of a leg at a rate, and therefore its duration, is known only from the history."""
    at_rate = isinstance(leg.leg, Ramp) and leg.leg.rate is not None
    return at_rate and before is not None and before.controls.normal != leg.controls.normal


def _within(steps: list[FloatArray], end: float) -> tuple[float, float]:
    """The span of a series for some times between rows in s: no longer than a part of the path, within which rows are divided."""
    waits = np.concatenate(steps)
    return min(float(np.min(waits[waits > 0.0], initial=math.inf)), end / _PARTS), end


def times_of(stretch: Stretch) -> FloatArray:
    """Time of every row of a leg in s; a leg without is refused."""
    if stretch.time is None:
        raise PathError(
            "a body with memory needs times: give every leg a duration or a rate, for example indent('1 um', rate='1 um/s')"
        )
    if stretch.time[0] < stretch.begin:
        raise PathError(
            f"time begins at {stretch.time[0]:g} s, but a history with memory begins at {stretch.begin:g} s: count times from "
            "first touch, or from an earlier instant"
        )
    return stretch.time


def refuse_sudden(stretch: Stretch, relaxation: Relaxation) -> None:
    """Refuse a sudden indentation of a body whose force would be infinite."""
    if stretch.controls.normal != "indentation" or not relaxation.instantly_rigid:
        return
    start, end = float(stretch.start[0]), float(stretch.normal[0])
    if times_of(stretch)[0] == stretch.begin and start != end and max(start, end) > 0.0:
        raise PathError(
            f"row 0 moves the indentation from {metres(start)} to {metres(end)} in zero time, for which this rheology needs an "
            "infinite force: give the row a duration"
        )


def refuse_rigid(relaxation: Relaxation) -> None:
    """Refuse bodies with a parallel dashpot, in the name of a verb."""
    if math.isinf(relaxation.glassy):
        raise ProblemError(
            "adhesion of a viscoelastic body needs an instantaneous modulus, but a sudden indentation of this body needs an infinite force; use StandardSolid, or Prony"
        )


def refuse_flow(relaxation: Relaxation) -> None:
    """Refuse bodies that are no solids with an instantaneous modulus."""
    refuse_rigid(relaxation)
    if relaxation.rubbery == 0.0:
        raise ProblemError(
            "the relaxed contact is needed, but the body flows at rest; use StandardSolid, or Prony with an equilibrium modulus. solve "
            "with MaugisDugdale follows bodies that flow"
        )


def assumptions_with_memory(
    contact: Contact, radius: FloatArray, deepest: float = 0.0
) -> tuple[Assumption, ...]:
    """Assumptions of the model, measured on the largest of some contact radii and on the largest indentation in m."""
    a = float(np.max(radius, initial=0.0))
    if a == 0.0:
        return ()
    listed = small_slope_assumptions(contact.profile, slope_function(contact.profile), a, 0.0)
    others = (one for one in listed if one.name != "elastic similarity")
    return (*others, *thickness_assumption(contact, a), *_on_base(contact, a, deepest))


def _on_base(contact: Contact, a: float, deepest: float) -> tuple[Assumption, ...]:
    """The assumption of layers that slide on their base, measured on the elastic contact of a radius in m; at a sharp edge of a depth."""
    line = unit_line_of(contact)
    if not isinstance(line, LayeredLine):
        return ()
    excess = 0.0 if a < line.edge else max(deepest - float(line.depth(np.array([a]))[0]), 0.0)
    return base_assumption(line, a, excess)


def error_of(values: FloatArray, half: FloatArray) -> FloatArray:
    """Relative errors of rows from half as many springs and steps; 1 where unknown."""
    values, half = np.nan_to_num(values), np.nan_to_num(half)
    so_far = np.maximum.accumulate(np.abs(values))
    largest = float(np.max(so_far, initial=0.0)) or 1.0
    return of_own_size(later_too(np.abs(values - half) / largest, so_far / largest), values)


def error_of_levels(values: FloatArray, half: FloatArray, quarter: FloatArray) -> FloatArray:
    """
    Relative errors of rows from half as many springs and steps, and half as many springs once more.

    The error at the edge of contact or slip depends on where it lies between springs, so that two levels may agree by chance: the
    difference of the next two counts too, scaled by the order 3/2 of an edge between springs.
    """
    return np.asarray(np.maximum(error_of(values, half), 2.0**-1.5 * error_of(half, quarter)))


def later_too(difference: FloatArray, size: FloatArray) -> FloatArray:
    """
    Twice the running maximum of the difference by half as many springs and steps, some later rows included.

    What is left to err is a third of the difference where it falls as the square of steps and springs, and all of it where a
    liquid follows forces faster than the steps are; in single rows the difference passes 0.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.nan_to_num(difference / size, posinf=0.0)
    later = np.max([np.append(part[k:], np.zeros(min(k, part.size))) for k in range(_LATER + 1)], axis=0)
    return np.asarray(2.0 * np.maximum(np.maximum.accumulate(difference), size * later))


def travelled(
    relaxation: Relaxation,
    law: Callable[[Relaxation, FloatArray, FloatArray], FloatArray],
    time: FloatArray,
    values: FloatArray,
) -> FloatArray:
    """Bound of the effect of the kernel's error: the response by a law, `relaxed` or `compliant`, to the summed magnitudes of all changes, times that error."""
    if relaxation.error == 0.0:
        return np.zeros(time.size)
    magnitudes = np.cumsum(np.abs(np.diff(values, prepend=0.0)))
    return relaxation.error * law(relaxation, np.append(0.0, time), np.append(0.0, magnitudes))[1:]


def relative_errors(errors: FloatArray, values: FloatArray) -> FloatArray:
    """Relative errors of rows, at most 1; 0 for a value of 0."""
    size = np.abs(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > 0.0, np.fmin(errors / size, 1.0), 0.0)
