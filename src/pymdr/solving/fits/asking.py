"""What is looked for in many curves, and how the fit of each may end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.problem.contact import Contact
from pymdr.solving.fits.families import Family, Ladder, Ways, family_of, ways_of
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    ORIGINS,
    TILT,
    Free,
    Unknown,
    put_into,
    unknowns_of,
)
from pymdr.units import FloatArray

FOUND, UNSETTLED, NO_CONTACT, UNREAD, AT_END, REFUSED, UNTOLD = range(7)
ENDINGS = (
    "found",
    "the search did not settle",
    "no contact in the curve",
    "no curve, or too few samples that are numbers",
    "the curve does not show what is looked for, or only beyond its bounds",
    "refused",
    "the curve does not determine what is looked for: too few samples are in contact, or an error is larger than its number",
)
"""How the fit of a curve ended, by its number in ``ending``."""
NOT_YET = -1
_MANY = 64
"""Curves that take longer as they are than to compile what fits them."""
SEEN = 25.0
"""By how many variances of the noise the squares of the differences grow without what a curve is said to show."""
WAVES, OF_LIMIT, PLATEAU = "waves", "of_limit", "plateau"
_UNITS = {"noise": "N", WAVES: "", "correlated": "", "indentation": "m", OF_LIMIT: "", PLATEAU: ""}


@dataclass(frozen=True)
class Asked:
    """What is looked for in all curves."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    known: Mapping[str, float]
    bounded: Mapping[str, tuple[float, float]]
    """Ends that were given."""
    free: Free
    ladder: Ladder | None = None
    """Rungs of the family; all unless given."""
    many: bool = False
    """Whether there are so many curves that the search is compiled for them."""

    @property
    def origins(self) -> tuple[str, ...]:
        """Those that are looked for."""
        return tuple(name for name in (CONTACT_POINT, BASELINE, TILT) if name not in self.known)

    @property
    def names(self) -> tuple[str, ...]:
        """All that is looked for."""
        return (*(u.name for u in self.unknowns), *self.origins)

    @property
    def units(self) -> dict[str, str]:
        """SI units of all columns."""
        own = {u.name: u.unit for u in self.unknowns} | ORIGINS
        named = {name: own[name] for name in self.names}
        return {**named, **{f"{name}_error": unit for name, unit in named.items()}, **_UNITS}

    @cached_property
    def ways(self) -> Ways | None:
        """Where the fast search applies."""
        return ways_of(self.contact, self.unknowns)

    @cached_property
    def families(self) -> dict[float, Family]:
        """Tables by the largest depth that they reach."""
        return {}

    def family(self, deepest: float) -> Family:
        """The tables for curves of a depth."""
        assert self.ways is not None
        number = self.ways.number
        bounds = None if number is None or self.ways.work is not None else self.bounded.get(number.name)
        if deepest not in self.families:
            self.families[deepest] = family_of(self.contact, self.ways, deepest, bounds, self.ladder)
        return self.families[deepest]


Columns = dict[str, FloatArray]


class FittedStretch(NamedTuple):
    """What the fits of some curves give."""

    columns: Columns
    refusals: frozenset[str] = frozenset()
    """What those that were refused were told."""


def asked_of(contact: Contact, free: Free, known: dict[str, float], curves: int) -> Asked:
    """What a fit of many curves looks for, begun within its bounds."""
    unknowns = unknowns_of(contact, free)
    given = free if isinstance(free, Mapping) else {}
    bounded = {u.name: (u.low, u.high) for u in unknowns if given.get(u.name) is not None}
    # the numbers of the tables are those from which the unknowns are counted, which lie within the bounds
    begun = put_into(contact, unknowns, np.array([u.start for u in unknowns]))
    return Asked(begun, unknowns, known, bounded, free, many=curves >= _MANY)


def fewest_in_contact(unknowns: int, curves: int = 1) -> int:
    """Samples in contact, one more than the numbers that only they tell: those looked for, and where every contact begins."""
    return unknowns + curves + 1


def leave_untold_out(asked: Asked, columns: Columns) -> None:
    """End the fits of curves in which the error of a size is larger than itself as such, and take out what was found in all that are not found."""
    for unknown in asked.unknowns:
        if unknown.is_size:
            untold = columns[f"{unknown.name}_error"] > columns[unknown.name]
            columns["ending"][untold & (columns["ending"] == FOUND)] = UNTOLD
    for name in asked.units:
        columns[name][columns["ending"] != FOUND] = math.nan


def empty_columns(asked: Asked, count: int) -> Columns:
    """Columns of curves that are not fitted yet."""
    columns = {name: np.full(count, math.nan) for name in asked.units}
    columns["ending"] = np.full(count, NOT_YET, dtype=np.int8)
    return columns
