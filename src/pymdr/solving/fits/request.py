"""The unknowns of fits of many curves, and the ways in which the fit of a curve may end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.problem.contact import Contact
from pymdr.solving.fits.families import Family, FamilyAxes, Ladder, axes_of, family_of
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
from pymdr.units import FloatArray, QuantityLike

FITTED, UNSETTLED, NO_CONTACT, UNREAD, AT_END, REFUSED, UNDETERMINED, TOO_FEW = range(8)
ENDINGS = (
    "fitted",
    "the search did not converge",
    "no contact in the curve",
    "no curve, or too few samples that are numbers",
    "the curve does not show an unknown within its bounds",
    "refused",
    "the curve does not determine an unknown: too few samples are in contact, or its error is larger than itself",
    "too few samples are within the fit range",
)
"""Meaning of the numbers in ``ending``."""
NOT_YET = -1
_MANY = 64
"""Number of curves from which on compiling the search pays."""
SEEN = 25.0
"""Increase of the sum of squares without an effect, in variances of the noise, from which on the effect is significant."""
WAVES, OF_LIMIT, PLATEAU = "waves", "of_limit", "plateau"
SYSTEMATIC, LOW, HIGH = "_systematic", "_low", "_high"
"""Ends of the names of columns: standard errors that all curves share, and 95 % intervals that contain them."""
WIDTH = "_width"
"""End of the names of columns that last until the intervals are known: half widths of those by noise, in errors."""
IN_CONTACT, RESIDUAL, DRIFT = "samples_in_contact", "relative_residual", "baseline_rise"
_UNITS = {"noise": "N", WAVES: "", "correlated": "", "indentation": "m", OF_LIMIT: "", PLATEAU: ""}
_UNITS |= {IN_CONTACT: "", RESIDUAL: "", DRIFT: ""}


@dataclass(frozen=True)
class FitRequest:
    """The unknowns of all curves, and what is known."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    known: Mapping[str, float]
    bounded: Mapping[str, tuple[float, float]]
    """Bounds that were given."""
    free: Free
    ladder: Ladder | None = None
    """Rungs of the family; all by default."""
    many: bool = False
    """Whether the search is compiled, because there are many curves."""
    limits: Mapping[str, float] = field(default_factory=dict)
    """The largest indentation in m and force in N of the fit range."""
    uncertainty: Mapping[str, QuantityLike] = field(default_factory=dict)
    """Standard uncertainties of numbers that all curves share."""
    families: dict[float, Family] = field(default_factory=dict, init=False, compare=False)
    """Tables by their largest depth."""

    @property
    def origins(self) -> tuple[str, ...]:
        """Unknown origins."""
        return tuple(name for name in (CONTACT_POINT, BASELINE, TILT) if name not in self.known)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns."""
        return (*(u.name for u in self.unknowns), *self.origins)

    @property
    def units(self) -> dict[str, str]:
        """SI units of all columns."""
        own = {u.name: u.unit for u in self.unknowns} | ORIGINS
        named = {name: own[name] for name in self.names}
        ends = ("_error", SYSTEMATIC, LOW, HIGH) if self.uncertainty else ("_error",)
        return {**named, **{f"{name}{end}": unit for end in ends for name, unit in named.items()}, **_UNITS}

    @cached_property
    def axes(self) -> FamilyAxes | None:
        """Axes of the family of forces if the fast search applies, else None."""
        return axes_of(self.contact, self.unknowns)

    def family(self, deepest: float) -> Family:
        """The tables for curves of a depth in m."""
        assert self.axes is not None
        number = self.axes.number
        bounds = None if number is None or self.axes.work is not None else self.bounded.get(number.name)
        if deepest not in self.families:
            self.families[deepest] = family_of(self.contact, self.axes, deepest, bounds, self.ladder)
        return self.families[deepest]


Columns = dict[str, FloatArray]


class FittedStretch(NamedTuple):
    """Results of the fits of some curves."""

    columns: Columns
    refusals: frozenset[str] = frozenset()
    """Messages of refused curves."""


def request_of(
    contact: Contact,
    free: Free,
    known: dict[str, float],
    curves: int,
    limits: Mapping[str, float],
    uncertainty: Mapping[str, QuantityLike],
) -> FitRequest:
    """The request of a fit of many curves, with a start within the bounds."""
    unknowns = unknowns_of(contact, free)
    given = free if isinstance(free, Mapping) else {}
    bounded = {u.name: (u.low, u.high) for u in unknowns if given.get(u.name) is not None}
    # the tables are relative to the start, which is within the bounds
    at_start = put_into(contact, unknowns, np.array([u.start for u in unknowns]))
    many = curves >= _MANY
    return FitRequest(
        at_start, unknowns, known, bounded, free, many=many, limits=limits, uncertainty=uncertainty
    )


def fewest_in_contact(unknowns: int, curves: int = 1) -> int:
    """Smallest number of samples in contact: one more than the unknowns and contact points that they determine."""
    return unknowns + curves + 1


def mark_undetermined(request: FitRequest, columns: Columns) -> None:
    """Mark curves in which the error of a size exceeds the size."""
    for unknown in request.unknowns:
        if unknown.is_size:
            undetermined = columns[f"{unknown.name}_error"] > columns[unknown.name]
            columns["ending"][undetermined & (columns["ending"] == FITTED)] = UNDETERMINED


def empty_columns(request: FitRequest, count: int) -> Columns:
    """Columns of curves before the fit."""
    columns = {name: np.full(count, math.nan) for name in request.units}
    columns["ending"] = np.full(count, NOT_YET, dtype=np.int8)
    return columns
