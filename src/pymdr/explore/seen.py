"""What is seen of a result: plain arrays and texts in readable units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.errors import PymdrError
from pymdr.interpretation.validity import Level
from pymdr.presentation.text import error_text
from pymdr.quantities import BAND_ENDS, QUANTITIES, RADIUS, quantity
from pymdr.result import Result
from pymdr.units import FloatArray, from_si, good_unit, written

MEASURES = ("von_mises", "tresca", "principal_stress", "hydrostatic")
_FIELDS = (
    "pressure",
    "normal_displacement",
    "gap",
    "shear_traction",
    "tangential_displacement",
    "slip",
    "heat_flux",
    "current_density",
)
_POINTS = 121
_CELLS = 41
"""Points of the stress along radius and depth."""
_WIDTH = 2.0
"""Radius up to which fields are shown, in contact radii."""
_MOST = 2000
"""Largest number of points of a curve."""


@dataclass(frozen=True)
class Trace:
    """One line of a chart."""

    name: str
    x: FloatArray
    y: FloatArray
    dashed: bool = False


@dataclass(frozen=True)
class Chart:
    """Lines over one axis, with units in the labels."""

    x_label: str
    y_label: str
    traces: tuple[Trace, ...]
    marks: tuple[FloatArray, FloatArray] = (np.zeros(0), np.zeros(0))
    """Points that are marked."""
    text: str = ""
    """What the chart shows, in words."""


@dataclass(frozen=True)
class Picture:
    """A stress inside the body in section."""

    values: FloatArray
    """Over depth and radius, in `unit`."""
    half_width: float
    depth: float
    length_unit: str
    unit: str
    text: str


Row = tuple[str, str, str, str, str]
"""Quantity, value, claim, relative error and reason."""


def quantities_of(result: Result) -> tuple[str, ...]:
    """Quantities over the rows that are valid somewhere, in the order of the result."""
    names = (str(name) for name in result.data if result.data[name].ndim == 1)
    return tuple(
        name
        for name in names
        if name.rpartition("_")[2] not in BAND_ENDS
        and not (name in result.claims and not result.claims[name].readable)
    )


def fields_of(result: Result) -> tuple[str, ...]:
    """Fields on the surface that are valid somewhere."""
    return tuple(name for name in _FIELDS if name in result.claims and result.claims[name].readable)


def row_of(result: Result, row: int) -> int:
    """The row nearest to a requested one, -1 being the one of the largest contact radius."""
    rows = int(result.data.sizes["step"])
    if row >= 0:
        return min(row, rows - 1)
    if "contact_radius" in result.data:
        radius = result.data["contact_radius"].values
        if np.isfinite(radius).any():
            return int(rows - 1 - np.argmax(np.where(np.isfinite(radius), radius, -1.0)[::-1]))
    return rows - 1


def _label(name: str, unit: str) -> str:
    words = QUANTITIES[name].long_name
    return f"{words} ({unit})" if unit else words


def curve(result: Result, x: str, y: str, row: int) -> Chart:
    """
    A quantity against another over the path, with the row marked.

    Examples
    --------
    >>> from pymdr.explore.model import answer, start
    >>> chart = curve(answer(start("ball")), "indentation", "normal_force", -1)
    >>> chart.y_label, float(chart.traces[0].y[-1])
    ('normal force (N)', 50.0)
    """
    columns, labels, units = [], [], []
    for name in (x, y):
        values = np.asarray(result.data[name].values, dtype=float)
        unit = good_unit(values, QUANTITIES[name].unit)
        columns.append(np.asarray(from_si(values, QUANTITIES[name].unit, unit)))
        labels.append(_label(name, unit))
        units.append(unit)
    at = row_of(result, row)
    keep = np.unique(np.linspace(0, columns[0].size - 1, min(columns[0].size, _MOST)).astype(int))
    marked = (columns[0][at : at + 1], columns[1][at : at + 1])
    trace = Trace(QUANTITIES[y].long_name, columns[0][keep], columns[1][keep])
    return Chart(labels[0], labels[1], (trace,), marked, _in_words(labels, columns))


def _in_words(labels: Sequence[str], columns: Sequence[FloatArray]) -> str:
    """The ranges of two columns in words."""
    if not all(np.isfinite(c).any() for c in columns):
        return f"{labels[1]} against {labels[0]}: no valid values"
    ranges = [f"from {np.nanmin(c):.4g} to {np.nanmax(c):.4g}" for c in columns]
    return f"{labels[1]} {ranges[1]} against {labels[0]} {ranges[0]}"


def _radius(result: Result, row: int) -> float:
    names = [name for name in ("cohesive_radius", "contact_radius") if name in result.data]
    known = [float(result.data[name].values[row]) for name in names]
    known = [value for value in known if np.isfinite(value) and value > 0.0]
    return max(known, default=0.0)


def field(result: Result, name: str, row: int) -> Chart:
    """
    A field on the surface over the radius, at a row; empty where there is no contact.

    Examples
    --------
    >>> from pymdr.explore.model import answer, start
    >>> field(answer(start("ball")), "pressure", -1).y_label
    'pressure (MPa)'
    """
    at = row_of(result, row)
    words = QUANTITIES[name].long_name
    if _radius(result, at) == 0.0:
        return Chart(RADIUS.long_name, words, (), text=f"{words}: no contact in this row")
    given = {"drop": "1 V"} if name == "current_density" else {"drop": "1 K"} if name == "heat_flux" else {}
    array = result.field(name, None, at, **given)  # type: ignore[arg-type]
    si_unit, r = str(array.attrs["units"]), array["r"].values
    values = np.where(np.isfinite(array.values), array.values, np.nan)
    inside = np.abs(values[np.isfinite(values)])
    unit = good_unit(inside if inside.size else np.zeros(1), si_unit)
    x_unit = good_unit(r, "m")
    x, y = np.asarray(from_si(r, "m", x_unit)), np.asarray(from_si(values, si_unit, unit))
    both = (np.concatenate([-x[:0:-1], x]), np.concatenate([y[:0:-1], y]))
    labels = (f"radius ({x_unit})", f"{words} ({unit})" if unit else words)
    return Chart(*labels, (Trace(words, *both),), text=_in_words(labels, (x, y)))


def section(result: Result, row: int) -> Chart:
    """
    The surfaces of both bodies in section, and the mapped profile with its line of springs.

    The surfaces are those of one rigid and one deformed body with the displacement of both.
    """
    at = row_of(result, row)
    end = 1.8 * _radius(result, at)
    needed = ("gap", "normal_displacement")
    if end == 0.0 or not all(name in result.claims and result.claims[name].readable for name in needed):
        return Chart("radius", "height", (), text="no contact in this row")
    r = np.linspace(0.0, end, _POINTS)
    gap, sunk = (result.field(name, r, at).values for name in needed)
    surface = -sunk
    z = {"upper body": surface + gap, "lower body": surface}
    if "equivalent_profile" in result.claims or "equivalent_profile" in result.reading.line_fields:
        depth = float(result.data["indentation"].values[at])
        z["mapped profile"] = result.field("equivalent_profile", r, at).values - depth
    x_unit = good_unit(r, "m")
    finite = np.concatenate([v[np.isfinite(v)] for v in (z["upper body"], z["lower body"])])
    z_unit = good_unit(finite if finite.size else np.zeros(1), "m")
    x = np.asarray(from_si(r, "m", x_unit))
    traces = []
    for name, values in z.items():
        height = np.asarray(from_si(np.where(np.isfinite(values), values, np.nan), "m", z_unit))
        line = (np.concatenate([-x[:0:-1], x]), np.concatenate([height[:0:-1], height]))
        traces.append(Trace(name, *line, dashed=name == "mapped profile"))
    radius = written(_radius(result, at), "m")
    return Chart(
        f"radius, position on the line ({x_unit})",
        f"height ({z_unit})",
        tuple(traces),
        text=f"both bodies in section; radius of the contact {radius}",
    )


def stress(result: Result, measure: str, row: int) -> Picture | None:
    """A measure of the stress inside the body, to twice the contact radius; None where it is not valid."""
    at = row_of(result, row)
    a = _radius(result, at)
    if a == 0.0 or "stress" not in result.claims or not result.claims["stress"].where[at]:
        return None
    z = np.linspace(0.0, _WIDTH * a, _CELLS)
    moved = result.contact.friction is not None and "shift" in result.data
    across = np.concatenate([-z[:0:-1], z]) if moved else z
    places = {"x": across} if moved else {"r": across}
    values = result.field(measure, step=at, z=z, **places).values  # type: ignore[arg-type]
    if not moved:
        values = np.concatenate([values[:, :0:-1], values], axis=1)
    finite = np.where(np.isfinite(values), values, np.nan)
    unit = good_unit(finite[np.isfinite(finite)], "Pa")
    length_unit = good_unit(z, "m")
    end = float(from_si(z[-1], "m", length_unit))
    words = f"{quantity(measure).long_name}: largest shown {written(float(np.nanmax(np.abs(finite))), 'Pa')}"
    return Picture(np.asarray(from_si(finite, "Pa", unit)), end, end, length_unit, unit, words)


def numbers(result: Result, row: int) -> tuple[Row, ...]:
    """
    The quantities of a row with their claims; of a claim that is not valid the reason alone.

    Examples
    --------
    >>> from pymdr.explore.model import answer, start
    >>> numbers(answer(start("ball")), -1)[1][:3]
    ('normal force', '50 N', 'exact')
    """
    at = row_of(result, row)
    rows = []
    for name, claim in result.claims.items():
        words = QUANTITIES[name].long_name if name in QUANTITIES else name.replace("_", " ")
        value = ""
        if name in result.data and result.data[name].ndim == 1 and claim.level is not Level.NOT_VALID:
            value = written(float(result.data[name].values[at]), QUANTITIES[name].unit)
        rows.append((words, value, claim.level.value, error_text(claim), claim.reason))
    return tuple(rows)


def refusal(error: BaseException) -> str:
    """The message of an error on one line; of an error that is not of this package with its kind, as a failure."""
    message = " ".join(str(error).split())
    return message if isinstance(error, PymdrError) else f"failed: {type(error).__name__}: {message}"
