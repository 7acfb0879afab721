"""Results of fits."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import QuantityError
from pymdr.presentation import plot
from pymdr.problem.codec import encode
from pymdr.problem.contact import Contact
from pymdr.quantities import one_name, parameter_label
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.minimizing import profile_end
from pymdr.solving.fits.quality import Quality
from pymdr.solving.fits.searching import Search
from pymdr.solving.study import Answer, TextTable
from pymdr.units import FloatArray, shown, written

_DIGITS, _ALL_DIGITS = 4, 16
_STEP = 1e-6
_CORRELATED = 1.44
"""Number of samples equivalent to one from which on it is listed."""


class Fitted(NamedTuple):
    """A fitted number."""

    name: str
    value: float
    """Value in the unit."""
    error: float
    """Standard error in the unit; NaN if the value is at a bound."""
    low: float
    high: float
    """Ends of the 95 % interval in the unit; the bounds if the value is at one of them."""
    unit: str
    """The SI unit."""

    @property
    def is_at_bound(self) -> bool:
        """Whether the value is at a bound, so that no error is known."""
        return math.isnan(self.error)

    def plain(self) -> dict[str, Any]:
        """The fields by name, None for numbers that JSON cannot represent."""
        return {
            name: None if isinstance(part, float) and not math.isfinite(part) else part
            for name, part in self._asdict().items()
        }

    def __str__(self) -> str:
        value, low, high = (written(one, self.unit, self.digits) for one in (self.value, self.low, self.high))
        if self.is_at_bound:
            return f"{self.name} = {value}, at one of its bounds {low} and {high}"
        return f"{self.name} = {value}, 95 % between {low} and {high}"

    @property
    def interval(self) -> str:
        """The value and the ends of its interval, as text."""
        value, low, high = (written(one, self.unit, self.digits) for one in (self.value, self.low, self.high))
        return f"{value} ({low} to {high})"

    @property
    def digits(self) -> int:
        """Number of digits that distinguishes the ends of the interval."""
        width, largest = self.high - self.low, max(abs(self.low), abs(self.high))
        if not 0.0 < width < largest < math.inf:
            return _DIGITS
        return min(max(_DIGITS, 2 + math.ceil(math.log10(largest / width))), _ALL_DIGITS)


def force_of(contact: Contact) -> str:
    """Name of the force in records of a contact."""
    return "normal_force" if contact.friction is None else "tangential_force"


@dataclass(frozen=True, kw_only=True)
class FitResult(Answer):
    """The result of a fit."""

    contact: Contact
    """With the fitted values."""
    curves: tuple[MeasuredCurve, ...] | tuple[ShearRecord, ...]
    values: Mapping[str, Fitted]
    """Unknowns and origins by name."""
    data: xr.Dataset
    """Over ``step``, the samples of all curves: ``indentation`` (m) and ``normal_force`` (N), with friction ``shift`` (m) and
    ``tangential_force`` (N), from the fitted origins, and the load or indentation of the record; ``model`` and
    ``residual`` (N), ``in_contact``, ``used``, and ``curve``; of bodies with memory ``time`` (s); of force curves the measures of
    :attr:`quality` as single numbers. The claims are those of the model at the deepest sample."""
    noise: float
    """Standard deviation of the residuals in N."""
    waves: float
    """Correlated part of the residuals relative to the noise between neighbours; 0 for pure noise."""
    correlated: float
    """Number of samples equivalent to one independent sample: the largest ratio of the variance of an unknown to that under white
    noise, at least 1."""
    widened: Mapping[str, float]
    """Half widths of the 95 % intervals by name, relative to those of normal distributions under white noise."""
    aicc: float
    """Akaike's information criterion for small samples, with the independent samples."""
    calibration: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Standard errors of the fitted numbers, in their units, from the ``record`` and from each uncertainty that was given."""
    search: Search
    free: FloatArray
    """The free numbers at the end of the search: logarithms of sizes, and origins relative to the ranges of the record."""

    summary_claims: ClassVar = ("normal_force", "tangential_force")
    claims_of_rows: ClassVar = False

    @property
    def quality(self) -> Quality | None:
        """Samples in contact, residuals and rise of the baseline, of several curves the worst; None for records of friction."""
        if self.contact.friction is not None:
            return None
        return Quality(*(self.data[name].item() for name in Quality._fields))

    @property
    def force(self) -> str:
        """The fitted force: ``normal_force``, or with friction ``tangential_force``."""
        return force_of(self.contact)

    def __getitem__(self, name: str) -> Fitted:
        if one_name(name) not in self.values:
            raise QuantityError(
                f"{shown(name)} is not an unknown of this fit; the unknowns are {', '.join(self.values)}"
            )
        return self.values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.values)

    def profile_intervals(
        self, names: Sequence[str] | None = None, sigma: float = 1.96
    ) -> dict[str, tuple[float, float]]:
        """
        Intervals by profile likelihood, which need not be symmetric.

        Parameters
        ----------
        names : sequence of str, optional
            Names of values; all unknowns of the contact by default.
        sigma : float
            Half width in standard deviations of a normal distribution: 1.96 for 95 %.

        Returns
        -------
        dict of str to (float, float)
            Ends in SI units, widened by correlated residuals as the other intervals; the bounds for values at a bound.

        Raises
        ------
        QuantityError
            If a name is not an unknown of the fit.
        """
        names = [u.name for u in self.search.unknowns] if names is None else list(names)
        samples = self.search.residuals(self.free).size - self.free.size
        ends = {}
        for name in names:
            fitted = self[name]
            if fitted.is_at_bound:
                ends[name] = (fitted.low, fitted.high)
                continue
            i, values = self.search.names.index(name), []
            wide = sigma * self.widened.get(name, 1.0)
            moved = self.free.copy()
            moved[i] += _STEP
            step = sigma * fitted.error * _STEP / (self.search.named(moved)[name] - fitted.value)
            for one in (-step, step):
                moved[i] = profile_end(self.search, self.free, i, one, wide**2 / samples)
                values.append(self.search.named(moved)[name])
            ends[name] = (min(values), max(values))
        return ends

    def _table(self) -> TextTable:
        rows = [
            [one.name, *(written(x, one.unit, one.digits) for x in (one.value, one.error, one.low, one.high))]
            for one in self.values.values()
        ]
        header = ["parameter", "value", "standard error", "95 % from", "to"]
        return (header, [""] * len(header)), rows

    def _remarks(self) -> list[str]:
        used = int(self.data["used"].values.sum())
        line = f"noise {written(self.noise, 'N', 3)} in {used} of {self.data.sizes['step']} samples"
        if self.correlated > _CORRELATED:
            line += f", {self.correlated:.3g} of which are equivalent to one independent sample"
        return [line] if self.quality is None else [line, f"quality: {self.quality}"]

    def _columns(self) -> dict[str, np.ndarray]:
        """One row for each sample; the measures of quality are equal in all rows, so that tables of several fits can be joined."""
        columns = super()._columns()
        rows = next(iter(columns.values())).size
        measures = {} if self.quality is None else self.quality._asdict()
        return columns | {name: np.full(rows, value) for name, value in measures.items()}

    def _others(self) -> dict[str, str]:
        return {"values": "; ".join(map(str, self.values.values()))}

    def _stored(self) -> xr.Dataset:
        fitted = {
            "values": {name: one.plain() for name, one in self.values.items()},
            "noise": self.noise,
            "waves": self.waves,
            "correlated": self.correlated,
            "aicc": self.aicc,
            "calibration": {source: dict(part) for source, part in self.calibration.items()},
            "contact": encode(self.contact),
            "references": self.cite(),
        }
        return super()._stored().assign_attrs(pymdr_fit=json.dumps(fitted))

    def _figure(self) -> mpl.figure.Figure:
        """The curves with their model, and the residuals."""
        return plot.fitted_curves(
            self.data,
            [f"{parameter_label(name)}{str(one).removeprefix(name)}" for name, one in self.values.items()],
        )

    def __repr__(self) -> str:
        values = ", ".join(f"{one.name} = {written(one.value, one.unit, 4)}" for one in self.values.values())
        return f"<pymdr.FitResult {values}>"
