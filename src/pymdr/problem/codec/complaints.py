"""Error messages about cases that name table, key, value and remedy."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import CaseError
from pymdr.problem.codec.models import FILE_KEYS, case_adapter, rough_adapter
from pymdr.problem.codec.outputs import OUTPUTS
from pymdr.problem.codec.tables import (
    INTERPOLATIONS,
    LEGS,
    MATERIALS,
    ONE_CHANNEL_LEGS,
    ORBIT_LEGS,
    PROFILES,
    RHEOLOGIES,
    SOLIDS,
    TABLES,
    kinds,
)
from pymdr.problem.layers import Layer
from pymdr.problem.naming import nearest
from pymdr.problem.rough import RoughSurface
from pymdr.units import example_of, shown

if TYPE_CHECKING:
    from pydantic import TypeAdapter


def refuse_invalid(plain: Mapping[str, Any], adapter: TypeAdapter[Any]) -> None:
    """Refuse plain dictionaries that are not a valid case."""
    from pydantic import ValidationError

    try:
        adapter.validate_python(_without_arrays(plain))
    except RecursionError as error:
        raise CaseError("tables or lists are nested too deeply") from error
    except ValidationError as error:
        raise CaseError(_message(error, plain)) from error


_SHOWN = 20
"""Largest number of errors in one message."""

_ALTERNATIVES = ("int", "float", "str")
"""Types that pydantic appends to the location of a number."""

_NEEDED = {
    "string_type": "a text is needed",
    "list_type": "a list is needed",
    "model_type": "a table is needed",
    "model_attributes_type": "a table is needed",
    "dict_type": "a table is needed",
    "bool_type": "true or false is needed",
    "float_type": "a number is needed",
    "float_parsing": "a number is needed",
    "finite_number": "a finite number is needed",
}


def _message(error: Any, plain: Mapping[str, Any]) -> str:
    """The errors of a validation, with table, key, value and remedy."""
    messages: dict[str, None] = {}
    suggested: set[tuple[Any, ...]] = set()
    complaints = error.errors(include_url=False)
    for item in sorted(complaints, key=lambda e: e["type"] != "extra_forbidden"):
        full = [part for part in item["loc"] if not str(part).startswith("list[")]
        while len(full) > 1 and full[-1] in _ALTERNATIVES:
            full.pop()
        # pydantic names the kind of every tagged table; users see only the table
        loc = [part for i, part in enumerate(full) if i in (0, len(full) - 1) or part not in kinds()]
        if item["type"] == "missing" and tuple(loc) in suggested:
            continue
        if item["type"] == "extra_forbidden":
            suggested |= {(*loc[:-1], key) for key in nearest(str(loc[-1]), _known_keys(loc[:-1], plain))}
        messages[_complaint(item, loc, plain)] = None
    listed = list(messages)
    more = f"; and {len(listed) - _SHOWN} more" if len(listed) > _SHOWN else ""
    return "; ".join(listed[:_SHOWN]) + more


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


def _complaint(item: Mapping[str, Any], loc: list[Any], plain: Mapping[str, Any]) -> str:
    path = [str(part + 1) if isinstance(part, int) else str(part) for part in loc]
    table, key = path[:-1], path[-1] if path else "the case"
    where = f"[{' '.join(table)}] " if table else ""
    match item["type"]:
        case "extra_forbidden":
            hint = _hint(key, _known_keys(loc[:-1], plain))
            what = "table" if not table and isinstance(item["input"], Mapping | list) else "key"
            return f"{where}{key} = {shown(item['input'])}: unknown {what}; {hint}"
        case "missing":
            return where + (_missing_key(item["input"], key) if table else _missing_table(key))
        case "union_tag_not_found":
            return f"[{' '.join(path)}] key 'kind' is missing; one of {', '.join(_kinds_for(loc))} is needed"
        case "union_tag_invalid":
            tag = str(item["ctx"]["tag"])
            if tag == "sum" and "parts" in loc:
                return f"[{' '.join(path)}] kind = 'sum': sums cannot be nested; list the parts in one sum"
            if tag.lower() == "function" and loc and loc[0] == "profile":
                return (
                    f"[{' '.join(path)}] kind = {shown(tag)}: cases cannot contain formulas; give samples "
                    "(kind = 'sampled' with file = 'profile.csv'), or write a Python script with pymdr.Function"
                )
            return f"[{' '.join(path)}] kind = {shown(tag)}: unknown kind; {_hint(tag, _kinds_for(loc))}{_own_kind(tag, loc)}"
        case "value_error":
            return f"{where}{item['ctx']['error']}"
        case "too_short":
            return f"{where}{key}: at least one entry is needed"
        case "greater_than_equal":
            return f"{where}{key} = {shown(item['input'])}: it must be at least {item['ctx']['ge']}"
        case "less_than_equal":
            return f"{where}{key} = {shown(item['input'])}: it must be at most {item['ctx']['le']}"
        case "literal_error":
            known = item["ctx"]["expected"]
            if key == "[key]":
                return f"[{' '.join(path[:-2])}] unknown key {shown(item['input'])}; one of {known} is needed"
            return f"{where}{key} = {shown(item['input'])}: {known} is needed"
        case other:
            whole = key in ("steps", "cycles", "keep", "n", "seed", "sides")
            number = "a whole number is needed" if whole else "a number or a text with its unit is needed"
            needed = number if item["loc"][-1] in _ALTERNATIVES or whole else _NEEDED.get(other, number)
            return f"{where}{key} = {shown(item['input'])}: {needed}"


def _kinds_for(loc: list[Any]) -> list[str]:
    if "path" in loc:
        return [*LEGS, *ONE_CHANNEL_LEGS, *ORBIT_LEGS]
    if "interpolation" in loc:
        return list(INTERPOLATIONS)
    if "shear" in loc or "young" in loc:
        return list(RHEOLOGIES)
    if "material" in loc or "base" in loc:
        return list(SOLIDS)
    if "parts" in loc:
        return [kind for kind in PROFILES if kind != "sum"]
    if loc and loc[0] in ("adhesion", "friction"):
        return list(TABLES[loc[0]])
    return list(MATERIALS if loc and loc[0] in ("body", "counterbody") else PROFILES)


def _known_keys(loc: list[Any], plain: Any) -> list[str]:
    if not loc:
        adapter = rough_adapter() if "surface" in plain else case_adapter()
        return list(adapter.json_schema()["properties"])
    if loc == ["surface"]:
        return [f.name for f in fields(RoughSurface)]
    if loc == ["ball"]:
        return ["radius"]
    if loc[-2:-1] == ["layers"]:
        return [f.name for f in fields(Layer)]
    if loc == ["solve"]:
        return ["machine_stiffness", "keep", "solver", "tolerance"]
    if len(loc) == 1 and loc[0] in OUTPUTS:
        return list(OUTPUTS[loc[0]][1])
    if loc == ["solve", "solver"]:
        return ["kind", "n"]
    for part in loc:
        plain = plain[part]
    kind = plain.get("kind")
    if kind in ONE_CHANNEL_LEGS:
        return ["kind", ONE_CHANNEL_LEGS[kind], "steps", "duration"]
    if kind in ORBIT_LEGS:
        return ["kind", *inspect.signature(ORBIT_LEGS[kind]).parameters]
    cls = next((table[kind] for table in TABLES.values() if kind in table), None)
    return ["kind", *(f.name for f in fields(cls)), *FILE_KEYS.get(kind, ())] if cls else ["kind"]


def _hint(word: str, known: list[str]) -> str:
    near = nearest(word, known)
    return f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(known)}"


def _own_kind(tag: str, loc: list[Any]) -> str:
    """The remedy for a kind that users may have registered elsewhere."""
    ends = ("profile", "body", "counterbody", "adhesion", "shear", "young")
    own = bool(loc) and loc[-1] in ends and not nearest(tag, _kinds_for(loc))
    return ", or import the file that registers your own kind: pymdr --plugin FILE.py" if own else ""


def _without_arrays(plain: Any) -> Any:
    """The same with one number for every array, since columns of files are numbers already."""
    if isinstance(plain, Mapping):
        return {key: _without_arrays(entry) for key, entry in plain.items()}
    if isinstance(plain, list) and any(isinstance(entry, Mapping | list) for entry in plain):
        return [_without_arrays(entry) for entry in plain]
    return [0.0] if isinstance(plain, np.ndarray) else plain
