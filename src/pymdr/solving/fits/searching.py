"""The search of a fit: its free numbers, residuals and their rates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.errors import PymdrError
from pymdr.interpretation.theories import theory_of
from pymdr.line.soft.springs import FINE, ZoneLevel
from pymdr.numerics.panels import IndexArray
from pymdr.problem.contact import Contact
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.families import RANGES, effects_of
from pymdr.solving.fits.forces import AdhesiveForces, Forces, forces_of, modelled
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    SHIFT_ORIGIN,
    TILT,
    Unknown,
    put_into,
    scales_together,
)
from pymdr.units import FloatArray

_STEP = 1e-4
"""Step of the free numbers of central differences."""
_LONG_STEP, _LONG_SHIFT, _LONGEST_STEP = 0.03, 1e-3, 0.3
"""
Least steps of unknowns and origins for rates of an edge with memory, whose steps in time change with them: the force of slow retreats scatters by up
to 1e-3. The largest step.
"""
_POOR = 10.0
"""Residual relative to the range of the force where the model cannot be solved."""


class Modelled(NamedTuple):
    """The model at the samples of one curve."""

    depth: FloatArray
    """Indentation from the contact point, or the shift from its origin."""
    force: FloatArray
    """As measured, without offset."""
    model: FloatArray
    touches: BoolArray
    rate: FloatArray
    """Of the model over the position in N/m; NaN where it is not known."""
    forces: Forces | None = None
    """Those of the model over the position; None of friction."""


@dataclass(frozen=True)
class Search:
    """Unknowns of a contact, and the records of the fit."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    curves: tuple[MeasuredCurve, ...] | tuple[ShearRecord, ...]
    known: dict[str, float]
    """The known origins."""
    used: tuple[BoolArray, ...] = field(default=())
    touches: tuple[BoolArray, ...] = field(default=())
    """Samples in contact of every curve, if they are prescribed."""
    zone: ZoneLevel = FINE
    """Resolution of cohesive zones with memory."""

    @property
    def shears(self) -> bool:
        """Whether the records are of tangential forces."""
        return not self.measured

    @property
    def measured(self) -> tuple[MeasuredCurve, ...]:
        """The records of normal forces."""
        return tuple(one for one in self.curves if isinstance(one, MeasuredCurve))

    @property
    def place(self) -> str:
        """Name of the origin of the positions."""
        return SHIFT_ORIGIN if self.shears else CONTACT_POINT

    @property
    def _origins(self) -> tuple[str, ...]:
        return (self.place, BASELINE) if self.shears else (self.place, BASELINE, TILT)

    @property
    def _free_origins(self) -> list[str]:
        return [name for name in self._origins if name not in self.known]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all free numbers: unknowns, then the origins of every curve."""
        several = len(self.curves) > 1
        return (
            *(u.name for u in self.unknowns),
            *(
                f"{name}[{i}]" if several else name
                for i in range(len(self.curves))
                for name in self._free_origins
            ),
        )

    @cached_property
    def origin_scales(self) -> FloatArray:
        """Sizes of the free origins, in the order of their names."""
        sizes = [
            {
                self.place: float(np.ptp(curve.depth)),
                BASELINE: float(np.ptp(curve.force)),
                TILT: float(np.ptp(curve.force) / np.ptp(curve.position)),
            }
            for curve in self.curves
        ]
        return np.array([size[name] for size in sizes for name in self._free_origins])

    def to_free(self, values: Sequence[float], origins: Sequence[dict[str, float]]) -> FloatArray:
        """The numbers that the search changes."""
        own = [u.to_free(v) for u, v in zip(self.unknowns, values, strict=True)]
        shifts = [one[name] for one in origins for name in self._free_origins]
        return np.array([*own, *(np.array(shifts) / self.origin_scales)])

    def from_free(self, free: FloatArray) -> tuple[FloatArray, list[dict[str, float]]]:
        """Values of the unknowns, and the origins of every curve."""
        n = len(self.unknowns)
        values = np.array([u.from_free(x) for u, x in zip(self.unknowns, free[:n], strict=True)])
        shifts = iter(free[n:] * self.origin_scales)
        origins = [
            {name: self.known[name] if name in self.known else float(next(shifts)) for name in self._origins}
            for _ in self.curves
        ]
        return values, origins

    def models(self, free: FloatArray) -> list[Modelled]:
        """The model at all samples of all curves."""
        values, origins = self.from_free(free)
        contact = put_into(self.contact, self.unknowns, values)
        return [
            _modelled(contact, self.curves[i], one, self.touches[i] if self.touches else None, self.zone)
            for i, one in enumerate(origins)
        ]

    def residuals(self, free: FloatArray) -> FloatArray:
        """Residuals in N of all used samples; large ones if the model cannot be solved."""
        try:
            models = self.models(free)
        except PymdrError:
            size = sum(one.force.size for one in self.curves)
            size = sum(int(one.sum()) for one in self.used) if self.used else size
            return np.full(size, _POOR * max(float(np.ptp(one.force)) for one in self.curves))
        return self._residuals_of(models)

    def _residuals_of(self, models: Sequence[Modelled]) -> FloatArray:
        return self._used_samples([one.force - one.model for one in models])

    def _used_samples(self, columns: Sequence[FloatArray]) -> FloatArray:
        """The used samples of a column of every curve."""
        if self.used:
            columns = [one[part] for one, part in zip(columns, self.used, strict=True)]
        return columns[0] if len(columns) == 1 else np.concatenate(columns)

    @cached_property
    def jumps(self) -> bool:
        """Whether the force of the model jumps at the contact point, by a pull that does not deform the bodies."""
        law = self.contact.adhesion
        return law is not None and not self.shears and theory_of(law).pulls_beyond

    def slopes(
        self,
        free: FloatArray,
        steps: FloatArray | None = None,
        moving: IndexArray | None = None,
        *,
        central: bool = True,
    ) -> FloatArray:
        """
        Rates of the residuals, one column per free number, or per one of some.

        Those over the origins and over a common factor of all forces are known where the model has a stiffness, those over moduli and laws of
        adhesion too, those over a range or strength to the accuracy of a search; others are differences. The samples in contact stay the same: with
        adhesion the force jumps where one gets in or out of contact.
        """
        steps = self.steps(_STEP, 1e-2 * _STEP) if steps is None else steps
        numbers = list(range(free.size)) if moving is None else moving.tolist()
        try:
            models = self.models(free)
        except PymdrError:
            return np.zeros((self.residuals(free).size, len(numbers)))
        own = self
        if self.contact.adhesion is not None and not self.shears and not self.touches:
            own = replace(self, touches=tuple(one.touches for one in models))
        here = own._residuals_of(models)

        def difference(i: int) -> FloatArray:
            step = np.zeros(free.size)
            step[i] = steps[i]
            moved, chosen, part = own, list(range(free.size)), slice(None)
            if i >= len(self.unknowns):
                moved, chosen, part = own._alone(i)
            low, high = (free - step)[chosen], (free + step)[chosen]
            (before, left_before), width = (
                (moved._ends(low), 2.0 * steps[i]) if central else ((here[part], False), steps[i])
            )
            after, left = moved._ends(high)
            column = np.zeros(here.size)
            column[part] = np.where(left_before | left, 0.0, (after - before) / width)
            return column

        known = own._slopes_over_origins(models)
        # where a range has no effect, the difference of large effects is rounding
        unclear = RANGES if central else ()
        known |= {i: x for i, x in own._slopes_over_law(free, models).items() if self.names[i] not in unclear}
        scaled, missing = self.scaled_together, [i for i in self.scaled_together if i not in known]
        total = own._slope_over_scale(models) if missing and set(scaled) <= set(numbers) else None
        if total is not None:
            known |= {i: difference(i) for i in missing[1:]}
            known[missing[0]] = total - sum(known[i] for i in scaled if i != missing[0])
        return np.column_stack([known[i] if i in known else difference(i) for i in numbers])

    def _ends(self, free: FloatArray) -> tuple[FloatArray, BoolArray | bool]:
        """Residuals at the end of a difference, and the samples that the edge with memory has left there, where its force jumps."""
        if not self.scatters:
            return self.residuals(free), False
        try:
            models = self.models(free)
        except PymdrError:
            return self.residuals(free), True
        left = self._used_samples([np.where(one.touches & (one.model == 0.0), 1.0, 0.0) for one in models])
        return self._residuals_of(models), left > 0.0

    def _alone(self, i: int) -> tuple[Search, list[int], slice]:
        """The search over the only record that an origin moves, its free numbers, and its part of the residuals."""
        n, size = len(self.unknowns), len(self._free_origins)
        j = (i - n) // size
        one = slice(j, j + 1)
        counts = [int(part.sum()) for part in self.used] or [curve.force.size for curve in self.curves]
        alone = replace(self, curves=self.curves[one], used=self.used[one], touches=self.touches[one])
        numbers = [*range(n), *range(n + j * size, n + (j + 1) * size)]
        return alone, numbers, slice(sum(counts[:j]), sum(counts[: j + 1]))

    def _slopes_over_origins(self, models: Sequence[Modelled]) -> dict[int, FloatArray]:
        """The known columns of :meth:`slopes` over the origins, by their free numbers."""
        slopes, i = {}, len(self.unknowns)
        for j, one in enumerate(models):
            for name in self._free_origins:
                column = {
                    self.place: one.rate,
                    BASELINE: -np.ones(one.force.size),
                    TILT: -_from_middle(self.curves[j].position),
                }[name]
                if np.isfinite(column).all():
                    columns = [
                        column if k == j else np.zeros(other.force.size) for k, other in enumerate(models)
                    ]
                    slopes[i] = self.origin_scales[i - len(self.unknowns)] * self._used_samples(columns)
                i += 1
        return slopes

    def _slopes_over_law(self, free: FloatArray, models: Sequence[Modelled]) -> dict[int, FloatArray]:
        """The columns of :meth:`slopes` over moduli and numbers of a law of adhesion, by their free numbers, where they are known."""
        if self.contact.adhesion is None or self.shears:
            return {}
        contact = put_into(self.contact, self.unknowns, self.from_free(free)[0])
        columns: dict[int, list[FloatArray]] = {}
        for curve, one in zip(self.measured, models, strict=True):
            if not isinstance(one.forces, AdhesiveForces):
                return {}
            effects = effects_of(contact, one.forces, one.depth + curve.compliance * one.model)
            for i, unknown in enumerate(self.unknowns):
                if unknown.is_size and unknown.name in effects:
                    columns.setdefault(i, []).append(np.where(one.touches, -effects[unknown.name], 0.0))
        return {i: self._used_samples(own) for i, own in columns.items()}

    @property
    def scaled_together(self) -> tuple[int, ...]:
        """The free numbers of sizes to which, taken together, all forces at given depths are proportional; none if one of them is known."""
        law = self.contact.adhesion
        if self.shears or self.contact.has_edge_history or not scales_together(self.contact, self.unknowns):
            return ()
        if law is not None and not theory_of(law).proportional(law):
            return ()
        chosen = [(i, u) for i, u in enumerate(self.unknowns) if u.is_of_force]
        return tuple(i for i, _ in chosen) if all(u.is_size for _, u in chosen) else ()

    def _slope_over_scale(self, models: Sequence[Modelled]) -> FloatArray | None:
        """The rate of the residuals over the logarithm of the common factor of all forces; None if it is not known."""
        columns = []
        for curve, one in zip(self.measured, models, strict=True):
            # the force scales at a depth: at a travel the machine deflects more
            column = -one.model
            if curve.compliance != 0.0:
                # before the fold the force is that of the fold, which moves
                if np.any(one.touches & (one.rate == 0.0)) or not np.isfinite(one.rate).all():
                    return None
                column = column * (1.0 - curve.compliance * one.rate)
            columns.append(column)
        return self._used_samples(columns)

    @property
    def scatters(self) -> bool:
        """Whether the force of an edge with memory scatters, because its steps in time change with the unknowns."""
        return self.contact.has_edge_history and self.contact.is_viscoelastic

    def steps(self, unknown: float, origin: float) -> FloatArray:
        """Steps of the free numbers by which rates are computed: those given, or longer ones where the force scatters."""
        if self.scatters:
            unknown, origin = _LONG_STEP, _LONG_SHIFT
        return np.where(np.arange(len(self.names)) < len(self.unknowns), unknown, origin)

    def steps_of_errors(self, errors: FloatArray) -> FloatArray:
        """Steps of one standard error of the free numbers, not shorter than those by which the scatter is small."""
        least = self.steps(_STEP, 1e-2 * _STEP)
        return np.clip(errors, least, np.where(least < _LONG_STEP, 10.0 * least, _LONGEST_STEP))

    def rates(self, free: FloatArray) -> FloatArray:
        """Rates of the unknowns and origins over the free numbers."""
        own = [u.rate(float(v)) for u, v in zip(self.unknowns, self.from_free(free)[0], strict=True)]
        return np.array([*own, *self.origin_scales])

    def named(self, free: FloatArray) -> dict[str, float]:
        """Unknowns and origins by name, in SI units."""
        values, places = self.from_free(free)
        named = {u.name: float(v) for u, v in zip(self.unknowns, values, strict=True)}
        for i, place in enumerate(places):
            for name, value in place.items():
                named[f"{name}[{i}]" if len(places) > 1 else name] = value
        return named

    def bounds(self) -> list[tuple[float, float]]:
        """Bounds of the free numbers."""
        inner = []
        for u in self.unknowns:
            low = (
                -math.inf
                if u.is_size and u.low == 0.0
                else u.to_free(u.low)
                if math.isfinite(u.low)
                else -math.inf
            )
            high = u.to_free(u.high) if math.isfinite(u.high) else math.inf
            inner.append((low, high))
        return [*inner, *[(-math.inf, math.inf)] * self.origin_scales.size]


def _modelled(
    contact: Contact,
    curve: MeasuredCurve | ShearRecord,
    origins: Mapping[str, float],
    touches: BoolArray | None,
    zone: ZoneLevel,
) -> Modelled:
    origin = origins[SHIFT_ORIGIN if isinstance(curve, ShearRecord) else CONTACT_POINT]
    baseline, tilt = origins[BASELINE], origins.get(TILT, 0.0)
    force, position = curve.force - baseline - tilt * _from_middle(curve.position), curve.position - origin
    if isinstance(curve, ShearRecord):
        unknown, all_samples = np.full(force.size, math.nan), np.ones(force.size, dtype=bool)
        return Modelled(position, force, curve.forces(contact, origin), all_samples, unknown)
    deepest = max(float(np.ptp(curve.depth)), float(position.max() - curve.compliance * force.max()))
    forces = forces_of(contact, deepest, curve.compliance, curve.time, zone)
    model, touches, rate = modelled(forces, position, force, touches)
    return Modelled(position - curve.compliance * model, force, model, touches, rate, forces)


def _from_middle(position: FloatArray) -> FloatArray:
    """Positions in m from the middle of their range."""
    return position - 0.5 * float(position.min() + position.max())
