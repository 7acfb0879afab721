"""Results in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.interpretation.validity import EXACT_WITHIN, Assumption, Claim, Level
from pymdr.quantities import BAND_ENDS, QUANTITIES
from pymdr.units import without_rounding, written

if TYPE_CHECKING:
    import xarray as xr


def summary(
    data: xr.Dataset,
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    status: str,
    meaning: str,
    notes: Sequence[str],
) -> str:
    """The last step of a result with what can be said of it."""
    n = data.sizes["step"]
    lines = [f"{status}: {meaning}", f"{n} step{'s' if n != 1 else ''}; the last one:"]
    for name in map(str, data):
        if name.rpartition("_")[2] in BAND_ENDS:
            continue
        quantity = QUANTITIES[name]
        value = last_value(data, name)
        if quantity.name == "edge_amplitude" and value == 0.0:
            continue
        level = f"  {last_level(claims[name]).value}" if name in claims else ""
        band = ""
        if f"{name}_low" in data:
            ends = (written(float(data[f"{name}_{end}"].values[-1]), quantity.unit) for end in BAND_ENDS)
            band = f"  between {' and '.join(ends)}"
        error = f"  {last_error(claims[name])}".rstrip() if name in claims else ""
        lines.append(f"  {quantity.words:<36}{written(value, quantity.unit):>16}{level}{error}{band}")
    return "\n".join([*lines, *_claims(claims), *_assumptions(assumptions), *_notes(notes)])


_MUCH_SMALLER = 1e-3
"""Of the largest contact of a path: what is left of a smaller one is not the rounding of what was."""


def last_value(data: xr.Dataset, name: str) -> float:
    """The last value of a quantity, 0 where it is the rounding of its largest one."""
    values = data[name].values
    if "contact_radius" in data:
        radius = data["contact_radius"].values
        if 0.0 < radius[-1] < _MUCH_SMALLER * np.nanmax(radius):
            return float(values[-1])
    return without_rounding(float(values[-1]), values, QUANTITIES[name].unit)


Numbers = Mapping[str, Mapping[str, float]]
"""Single numbers in SI units under headings, by the names of their quantities."""
Table = tuple[tuple[Sequence[str], Sequence[str]], Sequence[Sequence[str]]]
"""Words and units of columns, and rows of cells."""


def number_lines(groups: Numbers) -> list[tuple[str, list[tuple[str, str]]]]:
    """Headings, each with the words and the values of its numbers."""
    kinds: dict[str, list[float]] = {}
    for values in groups.values():
        for name, value in values.items():
            kinds.setdefault(QUANTITIES[name].unit, []).append(value)

    def row(name: str, value: float) -> tuple[str, str]:
        quantity = QUANTITIES[name]
        return quantity.words, written(
            without_rounding(value, kinds[quantity.unit], quantity.unit), quantity.unit
        )

    return [(heading, [row(*pair) for pair in values.items()]) for heading, values in groups.items()]


Said = tuple[Numbers, Table, Sequence[str], Mapping[str, Claim], Sequence[Assumption], Sequence[str]]
"""Single numbers, table, remarks, claims, assumptions and notes of a study."""


def study_summary(
    groups: Numbers,
    table: Table,
    remarks: Sequence[str],
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    notes: Sequence[str],
) -> str:
    """Single numbers under headings, the table of the others, and what can be said of them."""
    lines = []
    for heading, rows in number_lines(groups):
        lines += [f"{heading}:", *(f"  {words:<36}{value:>16}" for words, value in rows)]
    (words, units), cells = table
    if words:
        table_rows = (words, units, *cells) if any(units) else (words, *cells)
        widths = [max(12, *map(len, column)) for column in zip(*table_rows, strict=True)]
        lines += [" ".join(f"{cell:>{n}}" for cell, n in zip(row, widths, strict=True)) for row in table_rows]
    return "\n".join([*lines, *remarks, *_claims(claims), *_assumptions(assumptions), *_notes(notes)])


def largest_error(claim: Claim) -> float | None:
    """
    The largest relative error of a quantity over the steps at which its claim holds; None where it is not known.

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
    held = np.asarray(claim.error)[claim.where]
    return float(np.max(held, initial=0.0, where=~np.isnan(held)))


def last_level(claim: Claim) -> Level:
    """What can be said of a quantity at the last step."""
    return claim.level if claim.where[-1:].all() else Level.NOT_VALID


def last_error(claim: Claim) -> str:
    """The relative error of a quantity at the last step, in words; empty where it is rounding or nothing is claimed."""
    if not (claim.readable and claim.where[-1]):
        return ""
    if claim.error is None:
        return "error not known"
    return f"error {claim.error[-1]:.1e}" if claim.error[-1] > EXACT_WITHIN else ""


def in_bytes(count: int) -> str:
    """A number of bytes in words."""
    size, unit = next(
        (count / 1000**n, u) for n, u in ((3, "GB"), (2, "MB"), (1, "kB")) if count >= 1000**n or n == 1
    )
    return f"{size:.3g} {unit}"


def _claims(claims: Mapping[str, Claim]) -> list[str]:
    lines = ["Claims:"] if claims else []
    by_words: dict[tuple[Level, str, str], list[str]] = {}
    for name, claim in claims.items():
        by_words.setdefault((claim.level, claim.reason, claim.source), []).append(name)
    for (level, reason, source), names in by_words.items():
        lines += [f"  {level.name}: {', '.join(names)}", f"    {reason}", f"    [{source}]"]
        errors = {name: largest_error(claims[name]) for name in names if claims[name].readable}
        known = [f"{name} {error:.1e}" for name, error in errors.items() if error and error > EXACT_WITHIN]
        unknown = [name for name, error in errors.items() if error is None]
        if known:
            lines.append(f"    relative errors of up to: {', '.join(known)}")
        if unknown:
            lines.append(f"    relative errors not known: {', '.join(unknown)}")
    return lines


def _assumptions(assumptions: Sequence[Assumption]) -> list[str]:
    if not assumptions:
        return []
    rows = [
        f"  {'met    ' if a.met else 'NOT MET'} {a.name}: {a.words} is {a.measure:.3g} (limit {a.limit:g})"
        for a in assumptions
    ]
    return ["Assumptions of the model:", *rows]


def _notes(notes: Sequence[str]) -> list[str]:
    return [f"Note: {note}" for note in notes]
