"""What is chosen: the tables of a case as plain values, read and changed at their places."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any

from pymdr.problem.codec import tables
from pymdr.problem.paths import Ramp
from pymdr.quantities import QUANTITIES
from pymdr.units import to_si, written

Place = tuple[str | int, ...]
"""Keys and numbers of entries from the tables of a case to a value."""

Plain = Mapping[str, Any]

PARTS = ("profile", "body", "counterbody", "adhesion", "friction", "path")
"""What is chosen by kind."""


@dataclass(frozen=True)
class Choice:
    """What is chosen: the tables of a case file as plain values."""

    tables: Plain
    length: float = 1e-3
    """Length in m of the last profile that has one: the size of the next."""


def chosen(plain: Plain) -> Choice:
    """A choice of the tables of a case."""
    legs = plain.get("path", [])
    as_list = {**plain, "path": [legs] if isinstance(legs, Mapping) else list(legs)}
    return with_length(Choice(MappingProxyType(as_list)))


def with_length(choice: Choice) -> Choice:
    """The choice whose length is the first of its profile."""
    lengths = (number(choice, at) for at, _, unit in quantities(choice) if at[0] == "profile" and unit == "m")
    return replace(choice, length=next((length for length in lengths if length), choice.length))


def with_table(choice: Choice, part: str, table: Plain) -> Choice:
    """The choice with another table of a part."""
    new = MappingProxyType(ordered({**choice.tables, part: dict(table)}))
    return with_length(replace(choice, tables=new))


def with_path(choice: Choice, legs: list[dict[str, Any]]) -> Choice:
    """The choice with another path; bodies with memory take a second for every leg without a duration."""
    new = {**choice.tables, "path": legs}
    if _relaxes(new):
        new["path"] = [leg if _is_timed(leg) else {**leg, "duration": "1 s"} for leg in legs]
    return replace(choice, tables=MappingProxyType(new))


def _relaxes(new: Plain) -> bool:
    return any(new.get(part, {}).get("kind") == "viscoelastic" for part in ("body", "counterbody"))


def _is_timed(leg: Plain) -> bool:
    return any(key in leg for key in ("duration", "rate", "time"))


def ordered(new: Plain) -> dict[str, Any]:
    """Tables in the order in which case files are written."""
    first = ("title", *PARTS[:-1])
    rest = [name for name in new if name not in (*first, "path")]
    return {name: new[name] for name in (*first, *rest, "path") if name in new}


def with_entry(choice: Choice, place: Place, value: Any) -> Choice:
    """The choice with another value at a place."""
    return with_length(replace(choice, tables=MappingProxyType(_replaced(choice.tables, place, value))))


def _replaced(entry: Any, place: Place, value: Any) -> Any:
    if not place:
        return value
    first, rest = place[0], place[1:]
    if isinstance(entry, Mapping):
        return {**entry, first: _replaced(entry[first], rest, value)}
    return [_replaced(part, rest, value) if i == first else part for i, part in enumerate(entry)]


def value_at(place: Place, choice: Choice) -> Any:
    """The plain value at a place."""
    entry: Any = choice.tables
    for part in place:
        entry = entry[part]
    return entry


def number(choice: Choice, place: Place) -> float:
    """The quantity at a place in SI units."""
    unit = next(unit for at, _, unit in quantities(choice) if at == place)
    return to_si(value_at(place, choice), unit, name=str(place[-1]))


def quantities(choice: Choice) -> Iterator[tuple[Place, str, str]]:
    """Place, kind of its table, and SI unit of every quantity that is one number."""
    for name in (*PARTS, "solve"):
        entry = choice.tables.get(name)
        if name == "solve":
            if isinstance(entry, Mapping) and isinstance(entry.get("machine_stiffness"), str | int | float):
                yield ("solve", "machine_stiffness"), name, "N/m"
        elif entry is not None:
            yield from _quantities_in(entry, (name,))


def _quantities_in(entry: Any, place: Place) -> Iterator[tuple[Place, str, str]]:
    if isinstance(entry, list | tuple):
        for i, part in enumerate(entry):
            if isinstance(part, Mapping):
                yield from _quantities_in(part, (*place, i))
        return
    kind = str(entry.get("kind", "layer"))
    for key, value in entry.items():
        if isinstance(value, Mapping) or (
            isinstance(value, list) and value and isinstance(value[0], Mapping)
        ):
            yield from _quantities_in(value, (*place, key))
        elif isinstance(value, str | int | float) and not isinstance(value, bool):
            unit = _unit(kind, key)
            if unit is not None:
                yield (*place, key), kind, unit


def _unit(kind: str, key: str) -> str | None:
    """The SI unit of a value, by its kind and key; None of what is no quantity."""
    if kind == "layer":
        return "m" if key == "thickness" else None
    owner: type | None = Ramp if kind in tables.ONE_CHANNEL_LEGS else None
    owner = owner or next((table[kind] for table in tables.TABLES.values() if kind in table), None)
    if owner is None or key not in {f.name for f in fields(owner)}:
        return None
    if key == "rate":
        return (
            f"{QUANTITIES[tables.ONE_CHANNEL_LEGS[kind]].unit}/s" if kind in tables.ONE_CHANNEL_LEGS else None
        )
    return getattr(inspect.getattr_static(owner, key, None), "unit", None)


_DIGITS = 3
"""Digits of a value that is set by dragging."""


def short_text(value: float, unit: str, digits: int = _DIGITS) -> str:
    """A quantity as a text of few digits with its unit."""
    if unit == "rad" and abs(value) > 0.05:
        return f"{math.degrees(value):.{digits}g} deg"
    return written(value, unit, digits)
