"""The unknowns of a fit: parameters of the contact, and origins of the record."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import Parameter, parameter_of, parameters_of, with_parameters
from pymdr.problem.values import SIField
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array

CONTACT_POINT, SHIFT_ORIGIN, BASELINE, TILT = "contact_point", "shift_origin", "baseline", "tilt"
ORIGINS = {CONTACT_POINT: "m", SHIFT_ORIGIN: "m", BASELINE: "N", TILT: "N/m"}
"""Units of the origins of depth, shift and force of a record, and of the tilt of its force."""
_OF_FORCE = ("Pa", "Pa*s", "J/m^2", "N/m", "N")
"""Units of parameters to which, taken together, all forces are proportional."""

FARTHEST = 100.0
"""Largest logarithm of the ratio of a size to its start."""

Free = Sequence[str] | Mapping[str, ArrayQuantityLike | None]


@dataclass(frozen=True)
class Unknown:
    """An unknown number."""

    name: str
    unit: str
    """The SI unit."""
    low: float
    high: float
    """Bounds in the unit."""
    start: float
    """The value of the contact, in the unit."""

    @property
    def is_size(self) -> bool:
        """Whether it is positive, with its logarithm as free number."""
        return self.low >= 0.0 and self.start > 0.0

    @property
    def is_of_force(self) -> bool:
        """Whether forces are proportional to parameters of its unit."""
        return self.unit in _OF_FORCE

    def to_free(self, value: float) -> float:
        """The free number of a value."""
        return math.log(value / self.start) if self.is_size else value - self.start

    def from_free(self, value: float) -> float:
        """The inverse of :meth:`to_free`."""
        return (
            self.start * math.exp(min(max(value, -FARTHEST), FARTHEST))
            if self.is_size
            else self.start + value
        )

    def rate(self, value: float) -> float:
        """The rate of the unknown over its free number."""
        return value if self.is_size else 1.0


WORKS = ("adhesion.work", "adhesion.work_receding")
"""Names of the works of an edge that advances and of one that recedes."""
EQUAL_WORKS = 1e-9
"""Smallest relative difference of both works in a search."""


def unknowns_of(contact: Contact, free: Free) -> tuple[Unknown, ...]:
    """
    The unknowns of a contact.

    Parameters
    ----------
    contact : Contact
    free : sequence of str, or mapping of str to pair of quantities or None
        Dotted names, with bounds if there are any.
    """
    if isinstance(free, str):
        free = [free]
    names = list(free)
    law = contact.adhesion
    if WORKS[1] in names and law is not None and not law.has_hysteresis:
        raise ProblemError(
            "adhesion.work_receding is fitted from a start above adhesion.work; give JKR(work=, work_receding=) with a larger work_receding"
        )
    if not names or len(set(names)) < len(names):
        raise ProblemError(f"free = {shown(free)}; list every unknown once, such as ['body.young']")
    bounds = free if isinstance(free, Mapping) else dict.fromkeys(names)
    return tuple(_unknown(contact, str(name), bounds[name]) for name in names)


def _unknown(contact: Contact, name: str, bounds: ArrayQuantityLike | None) -> Unknown:
    parameter = parameter_of(contact, name)
    low, high = _limits(contact, name)
    if bounds is not None:
        ends = to_si_array(bounds, parameter.unit, name=f"bounds of {name}")
        if ends.shape != (2,) or not ends[0] < ends[1]:
            raise ProblemError(f"bounds of {name} = {shown(bounds)}; an increasing pair is needed")
        low, high = max(low, float(ends[0])), min(high, float(ends[1]))
    start = float(np.clip(parameter.value, low, high))
    if not math.isfinite(start):
        raise ProblemError(
            f"{name} = {parameter.value} of the contact is the start of the search; give a finite number, or leave it out of free"
        )
    return Unknown(name, parameter.unit, low, high, start)


def _limits(contact: Contact, name: str) -> tuple[float, float]:
    """Bounds of the field of a parameter; entries of arrays are positive."""
    *path, last = name.split(".")
    if last.endswith("]"):
        return 0.0, math.inf
    owner: Any = contact
    for step in path:
        attribute, *indices = step.replace("]", "").split("[")
        owner = getattr(owner, attribute)
        for index in indices:
            owner = owner[int(index)]
    described = inspect.getattr_static(type(owner), last)
    assert isinstance(described, SIField)
    return max(described.above, described.at_least), min(described.below, described.at_most)


def without_tilt(free: Free) -> Free:
    """The unknowns of the contact, without the tilt."""
    if isinstance(free, Mapping):
        if free.get(TILT) is not None:
            raise ProblemError(f"bounds of {TILT} = {shown(free[TILT])}; it has none: write None")
        return {name: bounds for name, bounds in free.items() if name != TILT}
    return [name for name in ([free] if isinstance(free, str) else free) if name != TILT]


def origins(given: Mapping[str, QuantityLike | None], free: Free) -> dict[str, float]:
    """The known origins in SI units: the given ones, and a tilt of 0 unless it is unknown."""
    level = {} if TILT in ([free] if isinstance(free, str) else free) else {TILT: 0.0}
    return level | {
        name: to_si(value, ORIGINS[name], name=name) for name, value in given.items() if value is not None
    }


def scales_together(contact: Contact, unknowns: Sequence[Unknown]) -> bool:
    """Whether all parameters to which, taken together, forces are proportional are unknown."""
    free = {unknown.name for unknown in unknowns}
    of_force = [p.name for p in parameters_of(contact) if p.unit in _OF_FORCE]
    return bool(of_force) and set(of_force) <= free


def candidates(
    contact: Contact, unknowns: Sequence[Unknown], depth: float, span: float, most: int
) -> list[FloatArray]:
    """
    Values from which a search may start, one array per combination.

    Parameters
    ----------
    depth : float
        Depth in m to which the bodies are pressed.
    span : float
        Time in s that the record lasts; 0 without times.
    most : int
        Number of combinations.

    Returns
    -------
    list of ndarray, shape (unknowns,)
    """
    if not unknowns:
        return [np.zeros(0)]
    together = scales_together(contact, unknowns)
    moduli = [p for p in parameters_of(contact) if p.unit == "Pa"]
    scale = next((u.name for u in unknowns if u.is_of_force), None)
    grids = []
    for unknown in unknowns:
        fixed = together and unknown.name == scale
        grids.append(np.array([unknown.start]) if fixed else _grid(unknown, moduli, depth, span))
    while math.prod(grid.size for grid in grids) > most:
        largest = max(range(len(grids)), key=lambda i: grids[i].size)
        grids[largest] = grids[largest][::2]
    mesh = np.meshgrid(*grids, indexing="ij")
    return list(np.column_stack([part.ravel() for part in mesh]))


def _grid(unknown: Unknown, moduli: Sequence[Parameter], depth: float, span: float) -> FloatArray:
    """Values of one unknown from its bounds and from the sizes of the record."""
    if unknown.unit == "J/m^2" and moduli:
        grid = max(p.value for p in moduli) * depth * np.geomspace(1e-6, 3.0, 14)
    elif unknown.unit == "Pa*s" and moduli and span > 0.0:
        grid = max(p.value for p in moduli) * span * np.geomspace(1e-3, 3.0, 8)
    elif unknown.unit == "s" and span > 0.0:
        grid = span * np.geomspace(1e-3, 3.0, 8)
    elif unknown.is_size:
        grid = unknown.start * np.geomspace(
            1e-3 if unknown.is_of_force else 0.1, 1e3 if unknown.is_of_force else 10.0, 13
        )
    elif math.isfinite(unknown.high - unknown.low):
        grid = np.linspace(unknown.low, unknown.high, 7)[1:-1]
    else:
        grid = np.array([unknown.start])
    inside = grid[(grid > unknown.low) & (grid < unknown.high)]
    return np.unique(np.append(inside, unknown.start))


def put_into(contact: Contact, unknowns: Sequence[Unknown], values: FloatArray) -> Contact:
    """The contact with values of its unknowns; a work of receding below that of advancing, which no law has, is raised to it."""
    named = {u.name: float(v) for u, v in zip(unknowns, values, strict=True)}
    if contact.adhesion is not None and contact.adhesion.has_hysteresis:
        advancing, receding = (named.get(name, parameter_of(contact, name).value) for name in WORKS)
        if receding < advancing * (1.0 + EQUAL_WORKS):
            if WORKS[1] in named:
                named[WORKS[1]] = advancing * (1.0 + EQUAL_WORKS)
            else:
                named[WORKS[0]] = receding / (1.0 + EQUAL_WORKS)
    return with_parameters(contact, named)
