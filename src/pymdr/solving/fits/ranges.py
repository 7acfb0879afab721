"""The part of a record that is fitted, by indentation and force."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.facts import Facts
from pymdr.problem.measured import Step
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.estimating import Estimate, estimated
from pymdr.solving.fits.families import FamilyAxes
from pymdr.solving.fits.kernels import Member, member_at, on_machine, read
from pymdr.solving.fits.quick import depth_ranges, table_of
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.request import Columns, FitRequest, fewest_in_contact
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray, in_contact_by_law
from pymdr.solving.fits.unknowns import CONTACT_POINT
from pymdr.units import FloatArray, QuantityLike, shown, to_si, written

INDENTATION, FORCE = "indentation", "force"
_UNITS = {INDENTATION: "m", FORCE: "N"}
ROUNDS = 20
_FEWEST = 8


class FewSamplesError(ProblemError):
    """Too few samples of a record are within a fit range."""


def limits_of(fit_range: Mapping[str, QuantityLike]) -> dict[str, float]:
    """The largest indentation in m and force in N of a fit range."""
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
            raise ProblemError(
                f"fit_range[{name!r}] = {written(limit, _UNITS[name])}: it must be above 0 {_UNITS[name]}"
            )
    return limits


def refuse_history(contact: Contact) -> None:
    """Refuse a fit range for forces that depend on the whole record."""
    if contact.friction is not None or contact.is_viscoelastic:
        raise ProblemError(
            "only force curves of elastic bodies are cut at a fit_range, because memory and friction depend on the whole record; cut "
            "the record at a time instead"
        )


def range_text(limits: Mapping[str, float]) -> str:
    """Text of a fit range."""
    parts = (f"{name} up to {written(limit, _UNITS[name], 4)}" for name, limit in limits.items())
    return f"fit range: {' and '.join(parts)}"


def next_samples(seen: Sequence[BoolArray], within: BoolArray) -> BoolArray | None:
    """
    The samples of the next round of a fit range.

    Range and contact point depend on each other; they are found in turn. Where the same samples enter and leave again, those within the
    limits in each of these rounds are fitted.

    Parameters
    ----------
    seen : sequence of ndarray
        Samples of the rounds so far.
    within : ndarray
        Samples within the limits by the model of the last round.

    Returns
    -------
    ndarray or None
        None if the last round is the end.
    """
    for i, one in enumerate(seen):
        if np.array_equal(one, within):
            within = np.logical_and.reduce(seen[i:])
            break
    return None if np.array_equal(within, seen[-1]) else within


def few_text(limits: Mapping[str, float], within: BoolArray, touches: BoolArray, fewest: int) -> str:
    """Text on a fit range with fewer than 8 samples, or too few in contact; empty if there are enough."""
    text, size = range_text(limits), within.size
    count, pressed = np.count_nonzero(within), np.count_nonzero(within & touches)
    remedy = "give a larger range, or a record with more samples there"
    if count < _FEWEST:
        return f"{text}: {count} of {size} samples are within it (limit {_FEWEST}); {remedy}"
    if pressed < fewest:
        return f"{text}: {pressed} of {size} samples are within it and in contact (limit {fewest}); {remedy}"
    return ""


def estimated_within(search: Search, limits: Mapping[str, float]) -> tuple[Estimate, str]:
    """
    The estimate from the samples within limits, and a note on them.

    A sample belongs to the range if indentation and force of the model there, which have no noise, are within the limits.

    Raises
    ------
    ProblemError
        If the body has a memory, or too few samples in contact are within the limits.
    ConvergenceError
        If samples keep entering and leaving the range.
    """
    refuse_history(search.contact)
    ends = np.cumsum([curve.force.size for curve in search.measured])
    seen = [np.ones(int(ends[-1]), dtype=bool)]
    end = estimated(search)
    for _ in range(ROUNDS):
        new = next_samples(seen, np.concatenate(_within(search, end, limits)))
        if new is None:
            return end, f"{range_text(limits)}, {np.count_nonzero(seen[-1])} of {ends[-1]} samples"
        moved = int(np.count_nonzero(new != seen[-1]))
        seen.append(new)
        pairs = zip(search.measured, np.split(new, ends[:-1]), strict=True)
        end = estimated(replace(search, curves=tuple(_cut(*pair) for pair in pairs), used=()))
    raise ConvergenceError(
        f"after {ROUNDS} rounds {moved} samples still enter or leave the fit range; give contact_point, or another range"
    )


def _within(search: Search, end: Estimate, limits: Mapping[str, float]) -> list[BoolArray]:
    """Samples of the whole records within the limits, by the model at an end of the search; refuse too few."""
    kept = []
    values, origins = end.search.from_free(end.best)
    models = search.models(search.to_free(values.tolist(), origins))
    fewest = fewest_in_contact(len(search.unknowns), int(CONTACT_POINT not in search.known))
    for model in models:
        inside = np.ones(model.depth.size, dtype=bool)
        for name, quantity in ((INDENTATION, model.depth), (FORCE, model.model)):
            if name in limits:
                inside &= quantity <= limits[name]
        if text := few_text(limits, inside, model.touches, fewest):
            raise FewSamplesError(text)
        kept.append(inside)
    return kept


def samples_within(
    request: FitRequest, axes: FamilyAxes, stretch: Stretch, columns: Columns
) -> tuple[BoolArray, BoolArray]:
    """Samples within the limits of a request, and those in contact, of fitted curves of a family."""
    values = np.column_stack([columns[u.name] for u in request.unknowns])
    points = columns.get(CONTACT_POINT, np.full(len(stretch.place), request.known.get(CONTACT_POINT, 0.0)))
    deepest, ends = depth_ranges(stretch), np.empty((len(stretch.place), 2))
    rows = zip(deepest, np.exp(axes.log_scales(values)), axes.numbers(values), stretch.softness, strict=True)
    for own, (depth, scale, number, softness) in zip(ends, rows, strict=True):
        member = member_at(table_of(request.family(float(depth))), float(number))
        own[:] = (
            on_machine(member, softness * scale).travel,
            _largest_travel(member, scale, float(softness), request.limits),
        )
    travel = np.where(np.isfinite(stretch.force), stretch.place - points[:, None], -math.inf)
    return travel <= ends[:, 1:], in_contact_by_law(travel, 0.0, ends[:, :1])


def _largest_travel(member: Member, scale: float, softness: float, limits: Mapping[str, float]) -> float:
    """The travel in m from the contact point at which a member of a scale, on a machine of a compliance in m/N, reaches a limit."""
    span, rising = member.deepest - member.fold, np.maximum.accumulate(scale * member.force)
    roots = np.linspace(0.0, 1.0, rising.size)
    depth, most = limits.get(INDENTATION, math.inf), limits.get(FORCE, math.inf)
    root = min(
        math.sqrt((depth - member.fold) / span),
        float(np.interp(most, rising, roots)) if most < rising[-1] else math.inf,
    )
    if root >= 1.0:
        return math.inf
    # near the fold of an adhesive contact the force decreases first
    force = scale * float(read(member.force, member.slope, np.array(root))[0])
    return member.fold + span * root**2 + softness * force


def _cut(curve: MeasuredCurve, kept: BoolArray) -> MeasuredCurve:
    """The samples of a record in the fit range."""
    count = int(np.count_nonzero(kept))

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
