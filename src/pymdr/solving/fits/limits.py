"""Starts of the search for a law of finite range from the fits of its limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import PymdrError
from pymdr.interpretation.theories import theory_of
from pymdr.line.adhesion import maugis_parameter
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import parameters_of, with_parameters
from pymdr.solving.fits.families import RANGES
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.starting import Start
from pymdr.solving.fits.unknowns import BASELINE, TILT
from pymdr.units import FloatArray

_LAMBDAS, _NEXT = np.geomspace(0.1, 6.4, 7), 2.0**0.5
"""Maugis' parameters of the first ranges, and factor of the ranges next to the best one: the valley of the least misfit may be a factor of 4 wide."""
_RATIOS = np.geomspace(1.0 / 16.0, 16.0, 9)
"""The first ranges relative to that of the start, where Maugis' parameter is not defined."""


class Limit(NamedTuple):
    """The end of a search with fewer unknowns."""

    misfit: float
    """In N^2."""
    values: dict[str, float]
    origins: list[dict[str, float]]
    search: Search
    free: FloatArray
    """The free numbers of its search."""
    side: float
    """Sign of the infinite logarithm of the range at this limit of the law; 0 at a fixed range."""


class Nearby(NamedTuple):
    """Starts from the fits of the limits of a law."""

    starts: list[list[Start]]
    """Those of each curve, the best first."""
    limits: list[Limit]


Ending = Callable[[Search], tuple[float, FloatArray]]
"""The smallest misfit of a search in N^2, and its free numbers."""


def starts_from_limits(search: Search, ending: Ending) -> Nearby | None:
    """
    Starts from the fits of the limits of a law, such as JKR and DMT of Maugis and Dugdale; None if there are none.

    An unknown range or strength is scanned with a fixed range, because the misfit has several minima over it.
    """
    law = search.contact.adhesion
    if law is None or search.shears or search.contact.has_edge_history:
        return None
    ends = [
        _limit(search, replace(search.contact, adhesion=one), ending, side)
        for one, side in zip(theory_of(law).limits(law), (-1.0, 1.0), strict=False)
    ]
    fitted = limits = [one for one in ends if one is not None]
    if fitted and any(u.name in RANGES for u in search.unknowns):
        fitted = _over_ranges(search, min(fitted, key=lambda one: one.misfit).values, ending) or fitted
    if not fitted:
        return None
    places = []
    for one in fitted:
        values = _with_range(search, one.values)
        left = search.residuals(search.to_free(values, one.origins))
        places.append((float((left**2).sum()), values, one.origins))
    places.sort(key=lambda place: place[0])
    starts = [
        [
            Start(misfit, np.array(values), own[i][search.place], own[i][BASELINE], own[i].get(TILT, 0.0))
            for misfit, values, own in places
        ]
        for i in range(len(search.curves))
    ]
    return Nearby(starts, limits)


def _limit(search: Search, contact: Contact, ending: Ending, side: float = 0.0) -> Limit | None:
    """The end of the search of another law without an unknown range; None if it cannot be fitted."""
    own = {p.name for p in parameters_of(contact)} - set(RANGES)
    unknowns = tuple(u for u in search.unknowns if u.name in own)
    bare = replace(search, contact=contact, unknowns=unknowns)
    try:
        misfit, free = ending(bare)
    except PymdrError:
        return None
    values, origins = bare.from_free(free)
    named = {u.name: float(v) for u, v in zip(unknowns, values, strict=True)}
    return Limit(misfit, named, origins, bare, free, side)


def _over_ranges(search: Search, near: dict[str, float], ending: Ending) -> list[Limit]:
    """The ends of searches with some fixed ranges, the first for values of a limit."""
    contact = with_parameters(search.contact, near)
    law, radius = contact.adhesion, contact.profile.tip_radius
    assert law is not None
    assert law.cohesive_stress is not None
    ranges = law.work / law.cohesive_stress * _RATIOS
    if radius is not None:
        modulus = effective_moduli(contact.body, contact.counterbody).normal
        ranges = law.work / (_LAMBDAS / maugis_parameter(radius, modulus, law.work, 1.0))
    ends: dict[float, Limit] = {}

    def try_out(length: float) -> None:
        fixed = replace(law, strength=None, range=length)
        one = _limit(search, replace(contact, adhesion=fixed), ending)
        if one is not None:
            ends[length] = one._replace(values={**one.values, "adhesion.range": length})

    for length in ranges.tolist():
        try_out(length)
    if ends:
        best = min(ends, key=lambda length: ends[length].misfit)
        try_out(best * _NEXT)
        try_out(best / _NEXT)
    return list(ends.values())


def _with_range(search: Search, named: dict[str, float]) -> list[float]:
    """Values of all unknowns, within their bounds, from those of a law with a fixed range."""
    values = []
    for unknown in search.unknowns:
        value = named.get(unknown.name, unknown.start)
        if unknown.name == "adhesion.strength" and "adhesion.range" in named:
            law = search.contact.adhesion
            assert law is not None
            value = named.get("adhesion.work", law.work) / named["adhesion.range"]
        values.append(float(np.clip(value, unknown.low, unknown.high)))
    return values
