"""A law of contact as a table, with its stated errors, for programs that are not pymdr."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import xarray as xr

from pymdr import presentation
from pymdr.deferred import mpl
from pymdr.errors import FileError
from pymdr.presentation import plot
from pymdr.presentation.header import HeaderData, c_header
from pymdr.presentation.history_header import HistoryInC
from pymdr.problem.contact import Contact
from pymdr.quantities import quantity
from pymdr.solving.exporting.knots import Knots
from pymdr.solving.exporting.sources import Form
from pymdr.solving.pulloff import PullOff
from pymdr.solving.study import Column, Study, TextTable
from pymdr.units import ArrayQuantityLike, FloatArray, metres, to_si_array

LAW_QUANTITIES = ("normal_force", "normal_stiffness", "contact_radius")
SAFETY = 1.02
"""Ratio of the bounds of errors to the largest measured ones."""
_DRAWN, _DECADES_DRAWN = 1001, 1e-6
_NARROW = 1e-6
"""Largest width of an interval at a kink, relative to its coordinate and their range."""
_HEADERS = (".h", ".hh", ".hpp", ".hxx")
_SHOWN = 9
"""Rows of the summary."""


def _rounded_up(error: float) -> str:
    """Text of two digits of a bound, not below it."""
    step = 10.0 ** (math.floor(math.log10(error)) - 1)
    return f"{math.ceil(error / step * (1.0 - 1e-12)) * step:.1e}"


@dataclass(frozen=True)
class Table:
    """Knots of a law in a form, with its extrapolation."""

    form: Form
    knots: Knots
    last: float
    """The largest depth in m, which its coordinate represents to rounding."""

    @property
    def first(self) -> float:
        """The first depth of the table in m."""
        return float(self.form.depth(self.knots.u[0]))

    def at(self, indentation: FloatArray) -> FloatArray:
        """Force (N), stiffness (N/m) and radius (m) at depths in m."""
        d = np.atleast_1d(indentation)
        answers = np.full((3, *d.shape), np.nan)
        before, inside = d < self.first, (d >= self.first) & (d <= self.last)
        answers[:, before] = self.form.before(d[before], self.knots)
        if inside.any():
            u = np.clip(self.form.coordinate(d[inside]), self.form.least(self.knots), self.knots.u[-1])
            answers[:, inside] = self.form.physical(self.knots.at(u))[1:4]
        return answers.reshape(3, *np.shape(indentation))

    def kinks(self, tolerance: float) -> np.ndarray:
        """Whether intervals between knots are narrow and hold a kink with JKR, where the stiffness changes by more than a tolerance; without a fold it is continuous."""
        u, slope = self.knots.u, self.knots.y_slope
        if self.form.tip is not None:
            return np.zeros(u.size - 1, dtype=bool)
        narrow = np.diff(u) <= _NARROW * (np.abs(u[1:]) + u[-1] - u[0])
        return np.asarray(narrow & (np.abs(np.diff(slope)) > tolerance * np.abs(slope[1:])))

    def kink_error(self, tolerance: float) -> float:
        """Bound of the relative error of the stiffness at kinks: its change, and a quarter by which the slope of a cubic may exceed those of its ends."""
        kinks = self.kinks(tolerance)
        stiffness = self.form.physical(self.knots)[2]
        least = np.minimum(np.abs(stiffness[:-1]), np.abs(stiffness[1:])) + self.form.added[1]
        return float(np.max(1.25 * np.abs(np.diff(stiffness)[kinks]) / least[kinks], initial=0.0))

    def data(self) -> xr.Dataset:
        """The knots over ``knot``, in SI units."""
        d, force, stiffness, radius, rate = self.form.physical(self.knots)
        if np.isnan(stiffness[0]):  # 0 over 0, at a corner of the law
            stiffness[0], rate[0] = self.at(np.array([self.first]))[1, 0], 0.0
        # the exact ends, without rounding of their logarithms
        d[0], d[-1] = self.first, self.last
        values = {
            "indentation": d,
            "normal_force": force,
            "normal_stiffness": stiffness,
            "contact_radius": radius,
        }
        columns = {name: ("knot", column, {"units": quantity(name).unit}) for name, column in values.items()}
        return xr.Dataset(columns | {"contact_radius_rate": ("knot", rate, {"units": ""})})


@dataclass(frozen=True, kw_only=True)
class ContactLaw(Study):
    """
    Normal force, stiffness and contact radius of a contact as functions of the indentation d, by cubic Hermite interpolation.

    Without adhesion ln F and ln a are interpolated over ln d, so that errors are relative at every depth; below the first
    knot both are powers of d. With JKR F and a are interpolated over sqrt(d - d_off), where d_off is the indentation at the
    loss of contact, and hold in contact. The stiffness is the derivative of the interpolated force. Outside: no contact (0)
    below d = 0 or d_off, NaN above the last knot.
    """

    contact: Contact
    tolerance: float
    """Limit of the errors."""
    errors: Mapping[str, float]
    """Bounds of the errors against :func:`pymdr.solve`, by quantity: 2 % above the largest measured ones; see `relative_to`."""
    kink_error: float
    """Bound of the relative error of the stiffness between the knots on both sides of kinks, at most 1e-6 of the range of the coordinate apart, with JKR; 0 if there are none."""
    relative_to: Mapping[str, str]
    """Text on the reference of each relative error."""
    table: Table
    """The interpolants."""
    checks: xr.Dataset
    """Measured errors between the knots and below them, over ``check``."""
    history: HistoryInC | None
    """What contacts remember in the header: the stack of friction along a line, springs in the plane or with memory, or with JKR whether they
    touch and, with two works, where the edge rests."""
    pull_off: PullOff | None
    """With adhesion: loss of contact under displacement control, and the state after the jump into contact."""

    subject: ClassVar[str] = "the law"
    columns: ClassVar[Mapping[str, Column]] = {
        "indentation": Column("indentation", "m"),
        "normal_force": Column("force", "N"),
        "normal_stiffness": Column("stiffness", "N/m"),
        "contact_radius": Column("radius", "m"),
    }
    summary_claims: ClassVar[tuple[str, ...]] = ("normal_force",)
    """Force, stiffness and radius have the same claim."""

    @property
    def range(self) -> tuple[float, float]:
        """The first and the last indentation of the table in m."""
        return self.table.first, self.table.last

    def force(self, indentation: ArrayQuantityLike) -> FloatArray:
        """
        The normal force in N.

        Parameters
        ----------
        indentation : array_like or quantity
            In m; the force is 0 without contact, NaN beyond the table.

        Returns
        -------
        ndarray
            With the shape of `indentation`.
        """
        return np.asarray(self._at(indentation)[0])

    def stiffness(self, indentation: ArrayQuantityLike) -> FloatArray:
        """The normal stiffness dF/dd in N/m, the derivative of :meth:`force`."""
        return np.asarray(self._at(indentation)[1])

    def radius(self, indentation: ArrayQuantityLike) -> FloatArray:
        """The contact radius in m."""
        return np.asarray(self._at(indentation)[2])

    def _at(self, indentation: ArrayQuantityLike) -> FloatArray:
        return self.table.at(to_si_array(indentation, "m", name="indentation"))

    def remarks(self) -> tuple[str, ...]:
        """Lines on the law, its range, errors, claims and sources."""
        return tuple(presentation.tables.about_lines(self._about()))

    def _others(self) -> dict[str, str]:
        first, last = self.range
        rows = {
            "law": f"force, stiffness and radius over d, {self.table.knots.u.size} knots from d = {first!r} m to {last!r} m",
            "course": self.table.form.outside(first, self.pull_off),
        }
        for name in LAW_QUANTITIES:
            rows[f"error of {name}"] = (
                f"below {_rounded_up(self.errors[name])} relative to {self.relative_to[name]}: {SAFETY - 1.0:.0%} above the largest of "
                f"{self.checks.sizes['check']} differences from pymdr.solve"
            )
        if self.kink_error:
            kinks = self.table.kinks(self.tolerance)
            count = int(np.count_nonzero(kinks & ~np.append(False, kinks[:-1])))  # several intervals at one
            rows["error of normal_stiffness"] += (
                f"; below {_rounded_up(self.kink_error)} between the knots at {count} kinks, closer than {_NARROW:g} of the table"
            )
        return rows

    def _remarks(self) -> list[str]:
        first, last = self.range
        errors = ", ".join(
            f"{self.columns[name].label} {_rounded_up(self.errors[name])}" for name in LAW_QUANTITIES
        )
        return [
            f"{self.table.knots.u.size} knots from d = {metres(first)} to {metres(last)}; errors below: {errors}",
            self.table.form.remark(self.pull_off),
        ]

    def _table(self) -> TextTable:
        """Evenly spaced knots."""
        rows = np.unique(np.linspace(0, self.table.knots.u.size - 1, _SHOWN).round().astype(int))
        return Study._table(replace(self, data=self.data.isel(knot=rows)))

    def c_header(self, name: str = "contact") -> str:
        """
        The law as a C header: ``<name>_force(d)``, ``<name>_stiffness(d)``, ``<name>_radius(d)`` and ``<name>_law(d, &F, &k, &a)``.

        With friction (``tangential=True``), with JKR and of bodies with memory, also the type ``<name>_state`` and ``<name>_advance``.

        Parameters
        ----------
        name : str
            Prefix of the names in the header, a C identifier.

        Returns
        -------
        str
            C99 that is also C++, in SI units, linked with the mathematical functions only.

        Raises
        ------
        ProblemError
            If the name is not an identifier.
        """
        knots, form, off = self.table.knots, self.table.form, self.pull_off
        constants = {
            "LARGEST_INDENTATION": (self.range[1], "m"),
            "SMALLEST_INDENTATION": (self.range[0], "m"),
        }
        if off is not None:
            constants |= {
                "JUMP_IN_INDENTATION": (0.0, "m"),
                "JUMP_IN_FORCE": (off.jump_in_force, "N"),
                "JUMP_IN_RADIUS": (off.jump_in_radius, "m"),
                "PULL_OFF_INDENTATION": (off.indentation, "m"),
                "PULL_OFF_FORCE": (off.normal_force, "N"),
                "PULL_OFF_RADIUS": (off.contact_radius, "m"),
                "LARGEST_PULL": (-off.largest_pull, "N"),
            }
        constants |= {f"ERROR_OF_{q.split('_')[-1].upper()}": (self.errors[q], "") for q in LAW_QUANTITIES}
        return c_header(
            HeaderData(
                name=name,
                remarks=self.remarks(),
                constants=constants,
                columns={
                    "u": knots.u,
                    "y": knots.y,
                    "y_slope": knots.y_slope,
                    "z": knots.z,
                    "z_slope": knots.z_slope,
                },
                tip=form.tip,
                least=form.least(knots),
                history=self.history,
            )
        )

    def to_csv(
        self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None, about: bool = True
    ) -> None:
        """
        Write the knots to a CSV file, with errors, extrapolation, claims and sources above its header.

        Parameters
        ----------
        file : path
            For example "ball.csv"; :func:`pymdr.read_record` reads it back.
        units : mapping of str to str, optional
            Name of a quantity -> unit; SI units by default.
        about : bool
            Whether to write the lines above the header, which begin with ``#``.
        """
        super().to_csv(file, units=units, about=about)

    def to_c(self, file: str | os.PathLike[str], *, name: str | None = None) -> None:
        """
        Write the C header, whole or not at all.

        Parameters
        ----------
        file : path
            For example "ball.h".
        name : str, optional
            As for :meth:`c_header`; that of the file by default.

        Raises
        ------
        FileError
            If the file cannot be written, or its name is not that of a header.
        """
        target = presentation.files.named_file(file, "write")
        if target.suffix.lower() not in _HEADERS:
            raise FileError(
                f"cannot write {str(file)!r}: a C header has a name that ends with '.h', such as 'ball.h'; tables are written by to_csv"
            )
        text = self.c_header(target.stem if name is None else name)
        presentation.files.write_atomically(
            file, lambda temporary: temporary.write_text(text, encoding="ascii")
        )

    def _figure(self) -> mpl.figure.Figure:
        """The law, and its errors against :func:`pymdr.solve` at depths between the knots."""
        form, last = self.table.form, self.table.last
        least = float(form.coordinate(np.array(min(self.table.first, _DECADES_DRAWN * last))))
        d = np.minimum(form.depth(np.linspace(least, self.table.knots.u[-1], _DRAWN)), last)
        knots = self.data.isel(knot=self.data["indentation"].values >= d[0])
        return plot.law_study(
            knots,
            (d, self.table.at(d)[0]),
            self.checks,
            self.tolerance,
            None if form.tip else self.table.first,
        )
