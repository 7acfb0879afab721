"""Results and studies as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pymdr.deferred import xr
from pymdr.interpretation.validity import EXACT_WITHIN, Assumption, Claim, Level
from pymdr.quantities import BAND_ENDS, QUANTITIES, of_whole
from pymdr.quantities import quantity as quantity_of
from pymdr.units import without_rounding, written


def summary(
    data: xr.Dataset,
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    status: str,
    meaning: str,
    notes: Sequence[str],
) -> str:
    """The last step of a result with its claims, assumptions and notes."""
    n = data.sizes["step"]
    lines = [f"{status}: {meaning}", f"{n} step{'s' if n != 1 else ''}; the last one:"]
    for name in map(str, data):
        if name.rpartition("_")[2] in BAND_ENDS:
            continue
        quantity, claimed = quantity_of(name), of_whole(name)
        value = last_value(data, name)
        if quantity.name == "edge_amplitude" and value == 0.0:
            continue
        level = f"  {last_level(claims[claimed]).value}" if claimed in claims else ""
        band = ""
        if f"{name}_low" in data:
            ends = (written(float(data[f"{name}_{end}"].values[-1]), quantity.unit) for end in BAND_ENDS)
            band = f"  between {' and '.join(ends)}"
        error = f"  {last_error(claims[claimed])}".rstrip() if claimed in claims else ""
        lines.append(f"  {quantity.long_name:<36}{written(value, quantity.unit):>16}{level}{error}{band}")
    return "\n".join([*lines, *_claims(claims), *_assumptions(assumptions), *_notes(notes)])


_MUCH_SMALLER = 1e-3
"""Fraction of the largest contact radius of a path, below which small values are not treated as rounding."""


def last_value(data: xr.Dataset, name: str) -> float:
    """The last value of a quantity; 0 if it is only rounding of the largest value."""
    values = data[name].values
    if "contact_radius" in data:
        radius = data["contact_radius"].values
        if 0.0 < radius[-1] < _MUCH_SMALLER * np.nanmax(radius):
            return float(values[-1])
    return without_rounding(float(values[-1]), values, quantity_of(name).unit)


Numbers = Mapping[str, Mapping[str, float]]
"""Single numbers in SI units, by heading and name of quantity."""
Table = tuple[tuple[Sequence[str], Sequence[str]], Sequence[Sequence[str]]]
"""Titles and units of columns, and rows of cells."""


def number_lines(groups: Numbers) -> list[tuple[str, list[tuple[str, str]]]]:
    """Headings, each with the names and formatted values of its numbers."""
    kinds: dict[str, list[float]] = {}
    for values in groups.values():
        for name, value in values.items():
            # the travel of a soft machine is of another size than the lengths of the contact
            if name != "travel":
                kinds.setdefault(QUANTITIES[name].unit, []).append(value)

    def row(name: str, value: float) -> tuple[str, str]:
        quantity = QUANTITIES[name]
        return quantity.long_name, written(
            without_rounding(value, kinds.get(quantity.unit, [value]), quantity.unit), quantity.unit
        )

    return [(heading, [row(*pair) for pair in values.items()]) for heading, values in groups.items()]


StudyText = tuple[Numbers, Table, Sequence[str], Mapping[str, Claim], Sequence[Assumption], Sequence[str]]
"""Single numbers, table, remarks, claims, assumptions and notes of a study."""


def study_summary(
    groups: Numbers,
    table: Table,
    remarks: Sequence[str],
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    notes: Sequence[str],
) -> str:
    """Single numbers under headings, the table, and claims, assumptions and notes."""
    lines = []
    for heading, rows in number_lines(groups):
        lines += [f"{heading}:", *(f"  {name:<36}{value:>16}" for name, value in rows)]
    (titles, units), cells = table
    if titles:
        table_rows = (titles, units, *cells) if any(units) else (titles, *cells)
        widths = [max(12, *map(len, column)) for column in zip(*table_rows, strict=True)]
        lines += [" ".join(f"{cell:>{n}}" for cell, n in zip(row, widths, strict=True)) for row in table_rows]
    return "\n".join([*lines, *remarks, *_claims(claims), *_assumptions(assumptions), *_notes(notes)])


def largest_error(claim: Claim) -> float | None:
    """
    The largest relative error of a quantity over the steps at which its claim holds; None if not known.

    Examples
    --------
    >>> where = np.array([True, False])
    >>> largest_error(Claim(Level.EXACT, "", "", where, np.array([1e-12, 1e-3])))
    1e-12
    >>> largest_error(Claim(Level.APPROXIMATE, "", "", where)) is None
    True
    """
    if claim.error is None:
        return None
    valid = np.asarray(claim.error)[claim.where]
    return float(np.max(valid, initial=0.0, where=~np.isnan(valid)))


def error_text(claim: Claim) -> str:
    """
    The largest relative error of a quantity, and what part of a field it does not cover; empty if it may not be read.

    Examples
    --------
    >>> error_text(Claim(Level.APPROXIMATE, "", "", np.array([True]), np.array([0.1]), "the edge"))
    '1.0e-01 outside the edge'
    """
    if not claim.readable:
        return ""
    error = largest_error(claim)
    if error is None:
        return "not known"
    size = f"{error:.1e}" if error else "rounding"
    return f"{size} outside {claim.excluded}" if claim.excluded else size


def last_level(claim: Claim) -> Level:
    """The level of a claim at the last step."""
    return claim.level if claim.where[-1:].all() else Level.NOT_VALID


def last_error(claim: Claim) -> str:
    """The relative error of a quantity at the last step as text; empty if it is rounding or not valid."""
    if not (claim.readable and claim.where[-1]):
        return ""
    if claim.error is None:
        return "error not known"
    return f"error {claim.error[-1]:.1e}" if claim.error[-1] > EXACT_WITHIN else ""


def bytes_text(count: int) -> str:
    """A number of bytes as text."""
    size, unit = next(
        (count / 1000**n, u) for n, u in ((3, "GB"), (2, "MB"), (1, "kB")) if count >= 1000**n or n == 1
    )
    return f"{size:.3g} {unit}"


def _claims(claims: Mapping[str, Claim]) -> list[str]:
    lines = ["Claims:"] if claims else []
    by_claim: dict[tuple[Level, str, str, str], list[str]] = {}
    for name, claim in claims.items():
        by_claim.setdefault((claim.level, claim.reason, claim.source, claim.excluded), []).append(name)
    for (level, reason, source, excluded), names in by_claim.items():
        lines += [f"  {level.name}: {', '.join(names)}", f"    {reason}", f"    [{source}]"]
        errors = {name: largest_error(claims[name]) for name in names if claims[name].readable}
        least = -1.0 if excluded else EXACT_WITHIN
        known = [
            f"{name} {error:.1e}" for name, error in errors.items() if error is not None and error > least
        ]
        unknown = [name for name, error in errors.items() if error is None]
        if known:
            lines.append(
                f"    relative errors of up to: {', '.join(known)}{f', outside {excluded}' if excluded else ''}"
            )
        if unknown:
            lines.append(f"    relative errors not known: {', '.join(unknown)}")
    return lines


def _assumptions(assumptions: Sequence[Assumption]) -> list[str]:
    if not assumptions:
        return []
    return ["Assumptions of the model:", *(f"  {a.name}: {assumption_text(a)}" for a in assumptions)]


def assumption_text(assumption: Assumption) -> str:
    """
    The measure of an assumption, its limit, and whether it is met; a remark after a semicolon follows the limit.

    Examples
    --------
    >>> assumption_text(Assumption("similarity", "Dundurs' beta; affects the pressure only with friction", 0.203, 0.5))
    "Dundurs' beta = 0.203 (limit 0.5; affects the pressure only with friction): met"
    """
    measure, separator, remark = assumption.description.partition("; ")
    verdict = "met" if assumption.met else "NOT MET"
    return f"{measure} = {assumption.measure:.3g} (limit {assumption.limit:g}{separator}{remark}): {verdict}"


def _notes(notes: Sequence[str]) -> list[str]:
    return [f"Note: {note}" for note in notes]
