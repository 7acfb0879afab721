"""Results, studies and claims as HTML for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from pymdr.deferred import xr
from pymdr.interpretation.validity import Assumption, Claim, Level
from pymdr.presentation.text import (
    Numbers,
    Table,
    error_text,
    last_error,
    last_level,
    last_value,
    number_lines,
)
from pymdr.quantities import BAND_ENDS, QUANTITIES, of_whole
from pymdr.quantities import quantity as quantity_of
from pymdr.units import written

_COLOURS = {Level.EXACT: "#009E73", Level.APPROXIMATE: "#B07D00", Level.NOT_VALID: "#D55E00"}


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are HTML."""
    top = "".join(f"<th style='text-align:left'>{cell}</th>" for cell in header)
    body = "".join(
        "<tr>" + "".join(f"<td style='text-align:left'>{c}</td>" for c in row) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def badge(level: Level) -> str:
    """The level of a claim in its colour."""
    return f"<b style='color:{_COLOURS[level]}'>{escape(level.value)}</b>"


def claims_html(claims: Mapping[str, Claim]) -> str:
    """Claims by quantity, with their largest relative errors."""
    return table(
        ("quantity", "claim", "error", "reason", "source"),
        (
            [escape(name), badge(c.level), escape(error_text(c)), escape(c.reason), escape(c.source)]
            for name, c in claims.items()
        ),
    )


def assumptions_html(assumptions: Sequence[Assumption]) -> str:
    """Assumptions with measure and limit."""
    return table(
        ("assumption", "measure", "limit", ""),
        (
            [escape(a.description), f"{a.measure:.3g}", f"{a.limit:g}", "met" if a.met else "<b>not met</b>"]
            for a in assumptions
        ),
    )


def result_html(
    data: xr.Dataset,
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    status: str,
    meaning: str,
    notes: Sequence[str],
) -> str:
    """The last step of a result, its claims and assumptions."""
    rows = []
    for name in map(str, data):
        if name.rpartition("_")[2] in BAND_ENDS and name not in QUANTITIES:
            continue
        quantity = quantity_of(name)
        value = escape(written(last_value(data, name), quantity.unit))
        claim = claims.get(of_whole(name))
        level = badge(last_level(claim)) if claim is not None else ""
        error = last_error(claim) if claim is not None else ""
        remark = f" <small>{error}</small>" if error else ""
        ends = [data[f"{name}_{end}"].values[-1] for end in BAND_ENDS if f"{name}_{end}" in data]
        if ends:
            low, high = (escape(written(float(end), quantity.unit)) for end in ends)
            value += f" <small>between {low} and {high}</small>"
        rows.append([escape(quantity.long_name), value, level + remark])
    steps = data.sizes["step"]
    return (
        f"<div><b>{escape(status)}</b>: {escape(meaning)}"
        f"{table(('quantity', f'last of {steps} steps', 'claim'), rows)}"
        f"{_validity(claims, assumptions, notes)}</div>"
    )


def _validity(claims: Mapping[str, Claim], assumptions: Sequence[Assumption], notes: Sequence[str]) -> str:
    return (
        f"<details><summary>Claims</summary>{claims_html(claims)}</details>"
        f"<details><summary>Assumptions</summary>{assumptions_html(assumptions)}</details>"
        + "".join(f"<p>Note: {escape(note)}</p>" for note in notes)
    )


def study_html(
    groups: Numbers,
    columns: Table,
    remarks: Sequence[str],
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    notes: Sequence[str],
) -> str:
    """The numbers of a study, its claims and assumptions."""
    return (
        f"<div>{numbers_html(groups, columns)}"
        + "".join(f"<p>{escape(line)}</p>" for line in remarks)
        + (f"<details><summary>Claims</summary>{claims_html(claims)}</details>" if claims else "")
        + (
            f"<details{'' if all(a.met for a in assumptions) else ' open'}><summary>Assumptions</summary>"
            f"{assumptions_html(assumptions)}</details>"
            if assumptions
            else ""
        )
        + "".join(f"<p>Note: {escape(note)}</p>" for note in notes)
        + "</div>"
    )


def numbers_html(groups: Numbers, columns: Table) -> str:
    """Single numbers under headings, and a table."""
    single = []
    for heading, lines in number_lines(groups):
        single += [[f"<b>{escape(heading)}</b>", ""]]
        single += [[escape(name), escape(value)] for name, value in lines]
    (titles, units), rows = columns
    header = [
        escape(f"{title} ({unit})" if unit else title) for title, unit in zip(titles, units, strict=True)
    ]
    first = table(("quantity", ""), single) if single else ""
    return first + (table(header, ([escape(cell) for cell in row] for row in rows)) if header else "")
