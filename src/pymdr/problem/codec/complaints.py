"""Error messages about cases that name table, key, value and remedy."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import CaseError
from pymdr.problem.codec.models import FILE_KEYS
from pymdr.problem.codec.tables import LEGS, TABLES
from pymdr.problem.naming import nearest
from pymdr.units import example_of, shown

if TYPE_CHECKING:
    from pydantic import TypeAdapter

Place = tuple[str | int, ...]
"""Keys of a case from the outside inward, and numbers of entries from 0."""
Schemas = Sequence[Mapping[str, Any]]
"""JSON schemas of all that may stand at a place."""


def refuse_invalid(
    plain: Mapping[str, Any], adapter: TypeAdapter[Any], unread: Mapping[Place, str] | None = None
) -> None:
    """
    Refuse plain dictionaries that are not a valid case, with all their mistakes.

    Parameters
    ----------
    plain : mapping
        The case.
    adapter : TypeAdapter
        Of its kind of case.
    unread : mapping of tuple to str, optional
        Why keys of other cases are not read in this kind of case; places without numbers.
    """
    from pydantic import ValidationError

    try:
        adapter.validate_python(_without_arrays(plain))
    except RecursionError as error:
        raise CaseError("tables or lists are nested too deeply") from error
    except ValidationError as error:
        raise CaseError(_message(error, adapter.json_schema(), unread or {})) from error


_SHOWN = 20
"""Largest number of errors in one message."""

_NUMBERS = ("int", "float", "str")
"""Types that pydantic appends to the location of a number."""

_NEEDED = {
    "string_type": "a text is needed",
    "string_too_short": "a text of at least one character is needed",
    "list_type": "a list is needed",
    "model_type": "a table is needed",
    "model_attributes_type": "a table is needed",
    "dict_type": "a table is needed",
    "bool_type": "true or false is needed",
    "float_type": "a number is needed",
    "float_parsing": "a number is needed",
    "finite_number": "a finite number is needed",
}


def _message(error: Any, schema: Mapping[str, Any], unread: Mapping[Place, str]) -> str:
    """The errors of a validation, with table, key, value and remedy."""
    complaints: dict[Place, str] = {}
    suggested: set[Place] = set()
    for item in sorted(error.errors(include_url=False), key=lambda e: e["type"] != "extra_forbidden"):
        extra = item["loc"][-1:] if item["type"] == "extra_forbidden" else ()
        table, schemas = _walk(item["loc"][: len(item["loc"]) - len(extra)], schema)
        place = (*table, *extra)
        if extra:
            known = _keys_of(schemas)
            suggested |= {(*table, near) for near in nearest(str(extra[0]), known)}
            reason = unread.get(tuple(part for part in place if isinstance(part, str)))
            complaints[place] = _unknown_key(item["input"], place, known, reason)
        elif item["type"] != "missing" or place not in suggested:
            complaints.setdefault(place, _complaint(item, place, schemas))
    # of a value that is neither of two types, the complaint that goes deepest
    outer = {place[:n] for place in complaints for n in range(len(place))}
    listed = [complaint for place, complaint in complaints.items() if place not in outer]
    more = f"; and {len(listed) - _SHOWN} more" if len(listed) > _SHOWN else ""
    return "; ".join(listed[:_SHOWN]) + more


def _walk(location: Sequence[str | int], schema: Mapping[str, Any]) -> tuple[Place, Schemas]:
    """The place of a location, without the kinds and types that pydantic adds, and the schemas there."""
    place: Place = ()
    schemas: Schemas = [schema]
    is_chosen = True
    for part in location:
        chosen = [] if is_chosen else [one for one in schemas if one.get("title") == part and _keys_of([one])]
        inner = [below for one in schemas for below in _below(one, part)]
        if chosen:
            schemas, is_chosen = chosen, True
        elif inner:
            place, is_chosen = (*place, part), False
            schemas = [one for below in inner for one in _alternatives(below, schema)]
    return place, schemas


def _below(schema: Mapping[str, Any], part: str | int) -> Iterator[Mapping[str, Any]]:
    """The schema of an entry of a list or a table."""
    if isinstance(part, int):
        inner = schema.get("items")
    else:
        inner = schema.get("properties", {}).get(part) or schema.get("additionalProperties")
    if isinstance(inner, Mapping) and not str(part).endswith("]"):
        yield inner


def _alternatives(schema: Mapping[str, Any], whole: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """A schema or the schemas that it refers to."""
    referred = whole["$defs"][schema["$ref"].rpartition("/")[2]] if "$ref" in schema else {}
    several = schema.get("anyOf") or schema.get("oneOf") or ([referred] if referred else [])
    for one in several:
        yield from _alternatives(one, whole)
    if not several:
        yield schema


def _written(place: Place) -> str:
    """A place as its table is written in a case, with numbers from 1: ``body.layers 2.material``."""
    parts = (f" {part + 1}" if isinstance(part, int) else f".{part}" for part in place)
    return "".join(parts).removeprefix(".")


def _split(place: Place) -> tuple[str, str]:
    """The table of a place, in brackets, and its key."""
    keys = [i for i, part in enumerate(place) if isinstance(part, str)]
    table, key = (place[: keys[-1]], place[keys[-1] :]) if keys else ((), ("the case",))
    return f"[{_written(table)}] " if table else "", _written(key)


def _keys_of(schemas: Schemas) -> list[str]:
    """The keys of tables; a file may replace arrays."""
    keys = [
        key
        for one in schemas
        for key in (*one.get("properties", ()), *FILE_KEYS.get(one.get("title", ""), ()))
    ]
    return list(dict.fromkeys(keys))


def _kinds_of(schemas: Schemas) -> list[str]:
    """The kinds of tables."""
    return [one["properties"]["kind"]["const"] for one in schemas if "kind" in one.get("properties", ())]


def _missing_table(name: str) -> str:
    example = (
        "; add a leg, such as [[path]] with kind = 'load', normal_force = '50 N'" if name == "path" else ""
    )
    return f"table [{name}] is missing{example}"


def _missing_key(given: Mapping[str, Any], key: str) -> str:
    """The missing key of a table with an example in its unit, if it is a quantity."""
    kind = str(given.get("kind"))
    owner = next((table[kind] for table in TABLES.values() if kind in table), LEGS["ramp"])
    unit = getattr(inspect.getattr_static(owner, key, None), "unit", "")
    return f"key {key!r} is missing" + (f"; write for example {key} = {example_of(unit)!r}" if unit else "")


def _unknown_key(value: object, place: Place, known: Sequence[str], reason: str | None) -> str:
    where, key = _split(place)
    is_table = not where and isinstance(value, Mapping | list)
    if reason is not None:
        title = f"[[{key}]]" if is_table and isinstance(value, list) else f"[{key}]" if is_table else key
        return f"{where}{title}: {reason}"
    what = "table" if is_table else "key"
    return f"{where}{key} = {shown(value)}: unknown {what}; {_hint(key, known)}"


def _complaint(item: Mapping[str, Any], place: Place, schemas: Schemas) -> str:
    where, key = _split(place)
    is_equal = f"{where}{key} = {shown(item['input'])}"
    match item["type"]:
        case "missing":
            return where + (_missing_key(item["input"], key) if where else _missing_table(key))
        case "union_tag_not_found":
            return (
                f"[{_written(place)}] key 'kind' is missing; one of {', '.join(_kinds_of(schemas))} is needed"
            )
        case "union_tag_invalid":
            tag = str(item["ctx"]["tag"])
            return f"[{_written(place)}] kind = {shown(tag)}: {_unknown_kind(tag, place, _kinds_of(schemas))}"
        case "value_error":
            return f"{where}{item['ctx']['error']}"
        case "too_short":
            return f"{where}{key}: at least one entry is needed"
        case "list_type" if any({"$ref", "oneOf"} & set(one.get("items", ())) for one in schemas):
            return f"{is_equal}: give one [[{_written(place)}]] for each"
        case "greater_than_equal":
            return f"{is_equal}: it must be at least {item['ctx']['ge']:g}"
        case "less_than_equal":
            return f"{is_equal}: it must be at most {item['ctx']['le']:g}"
        case "less_than":
            return f"{is_equal}: it must be below {item['ctx']['lt']:g}"
        case "literal_error":
            known = item["ctx"]["expected"]
            if item["loc"][-1] == "[key]":
                return f"{where}unknown key {shown(item['input'])}; one of {known} is needed"
            return f"{is_equal}: {known} is needed"
        case other:
            whole = key in ("steps", "cycles", "keep", "n", "seed", "sides")
            number = "a whole number is needed" if whole else "a number or a text with its unit is needed"
            needed = number if item["loc"][-1] in _NUMBERS or whole else _NEEDED.get(other, number)
            return f"{is_equal}: {needed}"


def _unknown_kind(tag: str, place: Place, known: Sequence[str]) -> str:
    if tag == "sum" and "parts" in place:
        return "sums cannot be nested; list the parts in one sum"
    if tag.lower() == "function" and place[0] == "profile":
        return (
            "cases cannot contain formulas; give samples (kind = 'sampled' with file = 'profile.csv'), or write a Python script with "
            "pymdr.Function"
        )
    # users may have registered a kind elsewhere
    ends = ("profile", "body", "counterbody", "adhesion", "shear", "young")
    own = ", or import the file that registers your own kind: pymdr --plugin FILE.py"
    return f"unknown kind; {_hint(tag, known)}{own if place[-1] in ends and not nearest(tag, known) else ''}"


def _hint(word: str, known: Sequence[str]) -> str:
    near = nearest(word, known)
    return f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(known)}"


def _without_arrays(plain: Any) -> Any:
    """The same with one number for every array, since columns of files are numbers already."""
    if isinstance(plain, Mapping):
        return {key: _without_arrays(entry) for key, entry in plain.items()}
    if isinstance(plain, list) and any(isinstance(entry, Mapping | list) for entry in plain):
        return [_without_arrays(entry) for entry in plain]
    return [0.0] if isinstance(plain, np.ndarray) else plain
