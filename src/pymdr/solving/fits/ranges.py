"""The part of a record that is fitted, by indentation and force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.facts import Facts
from pymdr.problem.measured import Step
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.estimating import Estimate, estimated
from pymdr.solving.fits.families import FamilyAxes
from pymdr.solving.fits.kernels import Member, member_at
from pymdr.solving.fits.quick import depth_ranges, table_of
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.request import FITTED, Columns, FitRequest
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import CONTACT_POINT
from pymdr.units import FloatArray, QuantityLike, shown, to_si, written

INDENTATION, FORCE = "indentation", "force"
_UNITS = {INDENTATION: "m", FORCE: "N"}
ROUNDS = 20
_FEWEST = 8
NEARLY = 1
"""Number of samples that may still enter or leave the range."""


def limits_of(fit_range: Mapping[str, QuantityLike]) -> dict[str, float]:
    """
    The largest indentation in m and force in N of a fit range.

    Raises
    ------
    ProblemError
        If a key is unknown, or a limit is not above 0.
    """
    if not isinstance(fit_range, Mapping) or not fit_range or set(fit_range) - set(_UNITS):
        raise ProblemError(
            f"fit_range = {shown(fit_range)}; give the largest indentation, the largest force or both, such as "
            "{'indentation': '500 nm'}"
        )
    limits = {
        name: to_si(value, _UNITS[name], name=f"fit_range[{name!r}]") for name, value in fit_range.items()
    }
    for name, limit in limits.items():
        if not limit > 0.0:
            raise ProblemError(f"fit_range: {name} = {written(limit, _UNITS[name])} (limit: above 0)")
    return limits


def refuse_history(contact: Contact) -> None:
    """Refuse a fit range for forces that depend on the whole record."""
    if contact.friction is not None or contact.is_viscoelastic:
        raise ProblemError(
            "fit_range: only force curves of elastic bodies are cut, because memory and friction depend on the whole record; cut "
            "the record at a time instead"
        )


def range_text(limits: Mapping[str, float]) -> str:
    """Text of a fit range."""
    parts = (f"{name} up to {written(limit, _UNITS[name], 4)}" for name, limit in limits.items())
    return f"fit range: {' and '.join(parts)}"


def estimated_within(search: Search, limits: Mapping[str, float]) -> tuple[Estimate, str]:
    """
    The estimate from the samples within limits, and a note on them.

    A sample belongs to the range if indentation and force of the model there, which have no noise, are within the limits. Range and
    contact point depend on each other; they are found in turn.

    Raises
    ------
    ProblemError
        If the body has a memory, or fewer than 8 samples of a record are within the limits.
    ConvergenceError
        If samples keep entering and leaving the range.
    """
    refuse_history(search.contact)
    kept = [np.ones(curve.force.size, dtype=bool) for curve in search.measured]
    end = estimated(search)
    for _ in range(ROUNDS):
        new = _within(search, end, limits)
        moved = sum(int(np.count_nonzero(one != other)) for one, other in zip(new, kept, strict=True))
        if moved <= NEARLY:
            count = sum(int(np.count_nonzero(one)) for one in kept)
            return end, f"{range_text(limits)}, {count} of {sum(one.size for one in kept)} samples"
        kept = new
        curves = tuple(_cut(curve, one) for curve, one in zip(search.measured, kept, strict=True))
        end = estimated(replace(search, curves=curves, used=()))
    raise ConvergenceError(
        f"fit: after {ROUNDS} rounds {moved} samples still enter or leave the fit range; give contact_point, or another range"
    )


def _within(search: Search, end: Estimate, limits: Mapping[str, float]) -> list[BoolArray]:
    """Samples of the whole records within the limits, by the model at an end of the search."""
    kept = []
    values, origins = end.search.from_free(end.best)
    for model in search.models(search.to_free(values.tolist(), origins)):
        inside = np.ones(model.depth.size, dtype=bool)
        for name, quantity in ((INDENTATION, model.depth), (FORCE, model.model)):
            if name in limits:
                inside &= quantity <= limits[name]
        kept.append(inside)
    return kept


def largest_places(request: FitRequest, axes: FamilyAxes, stretch: Stretch, columns: Columns) -> FloatArray:
    """Largest travels or indentations in m within the limits of a request, of fitted curves of a family; inf of others."""
    places = np.full(len(stretch.place), math.inf)
    fitted = np.flatnonzero(columns["ending"] == FITTED)
    values = np.column_stack([columns[u.name][fitted] for u in request.unknowns])
    points = columns.get(CONTACT_POINT, np.full(len(places), request.known.get(CONTACT_POINT, 0.0)))
    deepest = depth_ranges(stretch)
    for i, scale, number in zip(fitted, np.exp(axes.log_scales(values)), axes.numbers(values), strict=True):
        member = member_at(table_of(request.family(float(deepest[i]))), float(number))
        places[i] = points[i] + _largest_travel(member, scale, float(stretch.softness[i]), request.limits)
    return places


def _largest_travel(member: Member, scale: float, softness: float, limits: Mapping[str, float]) -> float:
    """The travel in m from the contact point at which a member of a scale, on a machine of a compliance in m/N, reaches a limit."""
    span, force = member.deepest - member.fold, np.maximum.accumulate(scale * member.force)
    roots = np.linspace(0.0, 1.0, force.size)
    depth, most = limits.get(INDENTATION, math.inf), limits.get(FORCE, math.inf)
    root = min(
        math.sqrt((depth - member.fold) / span),
        float(np.interp(most, force, roots)) if most < force[-1] else math.inf,
    )
    if root >= 1.0:
        return math.inf
    return member.fold + span * root**2 + softness * float(np.interp(root, roots, force))


def _cut(curve: MeasuredCurve, kept: BoolArray) -> MeasuredCurve:
    """The samples of a record in the fit range."""
    count = int(np.count_nonzero(kept))
    if count < _FEWEST:
        raise ProblemError(
            f"fit_range: {count} samples of {kept.size} are within it (limit {_FEWEST}); give a larger range"
        )

    def part(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else values[kept]

    return replace(
        curve,
        force=curve.force[kept],
        indentation=part(curve.indentation),
        travel=part(curve.travel),
        time=part(curve.time),
        outliers=None,
        saturated=None,
        step=Step("fit range", f"{count} of {kept.size} samples kept", Facts({"count": float(count)})),
        before=curve,
    )
