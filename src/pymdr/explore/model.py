"""What is chosen on the page: the tables of a case, their kinds and their adjustable values."""

from __future__ import annotations

import inspect
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pymdr.errors import CaseError, PymdrError
from pymdr.problem.codec import tables
from pymdr.problem.paths import CHANNELS, Ramp
from pymdr.problem.schedule import Progress
from pymdr.quantities import QUANTITIES
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.units import to_si, written
from pymdr.workbench.casefile import Case, case_of_tables, case_text, read_tables
from pymdr.workbench.templates import template

Place = tuple[str | int, ...]
"""Keys and numbers of entries from the tables of a case to a value."""
Plain = Mapping[str, Any]

PARTS = ("profile", "body", "counterbody", "adhesion", "friction", "path")
"""What is chosen by kind."""
NONE = "none"
"""The kind of an optional part that is left out."""
STARTS = {
    "ball": "steel ball on glass",
    "cone": "cone into quartz",
    "worn": "worn ball",
    "punch": "punch with a dome",
    "tip": "measured tip",
    "gel": "adhesive ball on a gel",
    "joint": "shaken joint",
    "cycle": "load cycle",
    "rubber": "ball on rubber",
    "creep": "creeping plastic",
    "layers": "coated body",
    "switch": "switch of silver",
}
"""Cases to start from, by the names of :func:`pymdr.workbench.templates.template`."""
_DIGITS = 3
"""Digits of a value that is set by dragging."""
_DECADES = 1.0
"""How far a value can be dragged to either side."""
_LIMITS = {
    "poisson": (0.0, 0.5),
    "coefficient": (0.0, 1.5),
    "exponent": (0.05, 6.0),
    "humidity": (0.05, 0.99),
    "half_angle": (math.radians(10.0), math.radians(89.0)),
    "contact_angle": (0.0, math.radians(85.0)),
}
"""Ranges of values that are not scales, by key."""
_EXPONENTS = {"graded": (-0.9, 0.9), "power_law_rheology": (0.02, 0.95)}
"""Exponents of other kinds than profiles."""

_SHAPES: dict[str, dict[str, float | str]] = {
    "sphere": {"radius": 1.0},
    "paraboloid": {"radius": 1.0},
    "sphere_on_sphere": {"radius": 1.0, "sample_radius": 2.0},
    "cone": {"half_angle": "70.3 deg"},
    "rounded_cone": {"tip_radius": 0.1, "half_angle": "70.3 deg"},
    "truncated_cone": {"flat_radius": 0.01, "half_angle": "70.3 deg"},
    "hyperboloid": {"tip_radius": 0.1, "half_angle": "70.3 deg"},
    "power_law": {"exponent": "4", "height": 0.5, "radius": 0.2},
    "flat_punch": {"radius": 0.02},
    "rounded_flat": {"flat_radius": 0.01, "edge_radius": 1.0},
    "domed_punch": {"radius": 0.02, "dome_radius": 2.0},
    "concave_punch": {"radius": 0.02, "hollow_radius": 20.0},
    "truncated_sphere": {"radius": 1.0, "flat_radius": 0.02},
    "truncated_paraboloid": {"radius": 1.0, "flat_radius": 0.02},
    "ellipsoid": {"radius": 1.0, "height": 0.5},
    "elliptic_paraboloid": {"radius_x": 1.0, "radius_y": 0.5},
}
"""Profiles with their lengths as fractions of the length of the profile before."""
_ZINC = {"c11": "161 GPa", "c33": "61 GPa", "c13": "50.1 GPa", "c44": "38.3 GPa", "c66": "63.4 GPa"}
_ADHESION: dict[str, dict[str, Any]] = {
    "jkr": {"work": "50 mJ/m^2"},
    "maugis_dugdale": {"work": "50 mJ/m^2", "range": "1 nm"},
    "dmt": {"work": "50 mJ/m^2"},
    "capillary": {"humidity": "0.5"},
}
_BODIES = ("elastic", "layered", "viscoelastic", "graded", "transversely_isotropic", "elastic_plastic")
PATHS = {
    "load": ("load",),
    "load and unload": ("load", "load"),
    "indent": ("indent",),
    "approach and retract": ("travel", "travel"),
    "shift under load": ("load", "shift"),
    "cycle under load": ("load", "cycle"),
    "twist under load": ("load", "twist"),
}
"""Paths by name, with the kinds of their legs."""
OWN = "of the case"
"""The name of any other path."""


_WORDS = {
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "work": "work of adhesion",
    "material": "",
    "layers": "layer",
}
"""Words of keys."""


@dataclass(frozen=True)
class Choice:
    """What is chosen: the tables of a case file as plain values."""

    tables: Plain
    length: float = 1e-3
    """Length in m of the last profile that has one: the size of the next."""


@dataclass(frozen=True)
class Knob:
    """A value that can be dragged, with its range."""

    place: Place
    unit: str
    """SI unit."""
    low: float
    high: float
    logarithmic: bool

    @property
    def label(self) -> str:
        """What it is, and of what."""
        words = [
            str(part + 1 if isinstance(part, int) else _WORDS.get(part, part)) for part in self.place[1:]
        ]
        return " ".join(
            word for word in [*(["leg"] if self.place[0] == "path" else []), *words] if word
        ).replace("_", " ")


def start(kind: str) -> Choice:
    """
    One of the cases of :data:`STARTS`.

    Examples
    --------
    >>> start("ball").tables["profile"]["radius"]
    '10 mm'
    """
    return chosen(tomllib.loads(template(kind)))


def of_file(file: Path) -> Choice:
    """
    The choice of a case file.

    Raises
    ------
    FileError, CaseError
        If it cannot be read or is not a valid case.
    """
    read = read_tables(file)
    try:
        case_of_tables(read)
    except PymdrError as error:
        raise CaseError(f"{file}: {error}") from error
    return chosen(read)


def chosen(plain: Plain) -> Choice:
    """A choice of the tables of a case."""
    legs = plain.get("path", [])
    as_list = {**plain, "path": [legs] if isinstance(legs, Mapping) else list(legs)}
    return _with_length(Choice(MappingProxyType(as_list)))


def _with_length(choice: Choice) -> Choice:
    lengths = [k for k in knobs(choice) if k.place[0] == "profile" and k.unit == "m"]
    return replace(choice, length=number(choice, lengths[0].place)) if lengths else choice


def case_of(choice: Choice) -> Case:
    """
    Contact, path and options of a choice.

    Raises
    ------
    CaseError
        If they do not fit together; the message names table, key, value and remedy.
    """
    return case_of_tables(choice.tables)


def answer(choice: Choice, progress: Progress | None = None) -> Result:
    """
    The result of a choice, by :func:`pymdr.solve`.

    Raises
    ------
    PymdrError
        If the case is not valid, or cannot be solved.
    """
    case = case_of(choice)
    return solve(case.contact, case.path, progress=progress, **case.options)


def toml(choice: Choice) -> str:
    """The case file of a choice."""
    return "# Solve it with: pymdr run CASE.toml\n" + case_text(choice.tables)


def kinds(part: str, choice: Choice) -> tuple[str, ...]:
    """The kinds of a part, that of the choice among them."""
    now = kind_of(part, choice)
    known = {
        "profile": tuple(_SHAPES),
        "body": _BODIES,
        "counterbody": ("rigid", "elastic", "viscoelastic", "graded", "transversely_isotropic"),
        "adhesion": (NONE, *_ADHESION),
        "friction": (NONE, "coulomb"),
        "path": tuple(PATHS),
    }[part]
    return known if now in known else (now, *known)


def kind_of(part: str, choice: Choice) -> str:
    """The kind of a part of a choice."""
    if part == "path":
        legs = tuple(leg["kind"] for leg in choice.tables["path"])
        return next((name for name, kinds_of_legs in PATHS.items() if kinds_of_legs == legs), OWN)
    left_out = "rigid" if part == "counterbody" else NONE
    return str(choice.tables.get(part, {}).get("kind", left_out))


def with_kind(part: str, kind: str, choice: Choice, largest: Mapping[str, float] | None = None) -> Choice:
    """
    The choice with another kind of a part, whose values are of the size of those before.

    Parameters
    ----------
    part : str
        One of :data:`PARTS`.
    kind : str
        One of :func:`kinds`.
    choice : Choice
    largest : mapping of str to float, optional
        Largest quantities of the last result, from which the targets of a path are taken.

    Examples
    --------
    >>> dict(with_kind("profile", "truncated_sphere", start("ball")).tables["profile"])
    {'kind': 'truncated_sphere', 'radius': '10 mm', 'flat_radius': '200 µm'}
    """
    if kind in (kind_of(part, choice), OWN):
        return choice
    new = dict(choice.tables)
    if kind == NONE or (part == "counterbody" and kind == "rigid"):
        new.pop(part, None)
    elif part == "path":
        new["path"] = _legs(kind, choice, largest or {})
    else:
        new[part] = {"kind": kind, **_default(part, kind, choice)}
    if any(leg["kind"] == "travel" for leg in new["path"]) and "machine_stiffness" not in new.get(
        "solve", {}
    ):
        sizes = _sizes(choice, largest or {})
        stiffness = abs(sizes["normal_force"] / sizes["indentation"])
        new["solve"] = {**new.get("solve", {}), "machine_stiffness": _text(stiffness, "N/m")}
    timed = with_path(replace(choice, tables=_ordered(new)), new["path"])
    return _with_length(timed)


def with_table(choice: Choice, part: str, table: Plain) -> Choice:
    """The choice with another table of a part."""
    new = MappingProxyType(_ordered({**choice.tables, part: dict(table)}))
    return _with_length(replace(choice, tables=new))


def with_path(choice: Choice, legs: list[dict[str, Any]]) -> Choice:
    """The choice with another path; bodies with memory take a second for every leg without a duration."""
    new = {**choice.tables, "path": legs}
    if _relaxes(new):
        new["path"] = [leg if _is_timed(leg) else {**leg, "duration": "1 s"} for leg in legs]
    return replace(choice, tables=MappingProxyType(new))


def fitted_to(choice: Choice, values: Mapping[str, tuple[float, str]]) -> Choice:
    """
    The choice with the values of parameters by their dotted names, each with its SI unit.

    Examples
    --------
    >>> fitted_to(start("gel"), {"body.young": (9567.1, "Pa")}).tables["body"]["young"]
    '9.5671 kPa'
    """
    for name, (value, unit) in values.items():
        parts = (part for part in re.split(r"[.\[\]]+", name) if part)
        place = tuple(int(part) if part.isdigit() else part for part in parts)
        choice = _with_entry(choice, place, _text(value, unit, digits=6))
    return choice


def _ordered(new: Plain) -> dict[str, Any]:
    """Tables in the order in which case files are written."""
    first = ("title", *PARTS[:-1])
    rest = [name for name in new if name not in (*first, "path")]
    return {name: new[name] for name in (*first, *rest, "path") if name in new}


def _default(part: str, kind: str, choice: Choice) -> dict[str, Any]:
    if part == "profile":
        return {
            key: value if isinstance(value, str) else _text(value * choice.length, "m")
            for key, value in _SHAPES[kind].items()
        }
    if part == "adhesion":
        return dict(_ADHESION[kind])
    if part == "friction":
        return {"coefficient": "0.3"}
    before = choice.tables.get(part, {})
    young, poisson = before.get("young", "1 GPa"), before.get("poisson", "0.3")
    stiffness = to_si(young, "Pa") if not isinstance(young, Mapping) else 1e9
    solid = {"young": young if not isinstance(young, Mapping) else "1 GPa", "poisson": poisson}
    defaults: dict[str, dict[str, Any]] = {
        "elastic": solid,
        "graded": {**solid, "depth": _text(0.1 * choice.length, "m"), "exponent": "0.3"},
        "elastic_plastic": {**solid, "yield_strength": _text(2e-3 * stiffness, "Pa")},
        "transversely_isotropic": dict(_ZINC),
        "viscoelastic": {
            "poisson": poisson,
            "shear": {
                "kind": "standard_solid",
                "equilibrium": _text(0.1 * stiffness, "Pa"),
                "modulus": _text(0.3 * stiffness, "Pa"),
                "time": "1 s",
            },
        },
        "layered": {
            "bond": "bonded",
            "base": {"kind": "elastic", **solid},
            "layers": [
                {
                    "material": {
                        "kind": "elastic",
                        "young": _text(3.0 * stiffness, "Pa"),
                        "poisson": poisson,
                    },
                    "thickness": _text(0.01 * choice.length, "m"),
                }
            ],
        },
    }
    return defaults[kind]


def _sizes(choice: Choice, largest: Mapping[str, float]) -> dict[str, float]:
    """Sizes of the targets of a path: of the last result, else of the path before."""
    known = {name: abs(value) for name, value in largest.items() if math.isfinite(value) and value}
    for leg in choice.tables["path"]:
        for channel in ("normal_force", "indentation", "travel"):
            if isinstance(leg.get(channel), str | int | float):
                size = abs(to_si(leg[channel], QUANTITIES[channel].unit))
                known.setdefault(channel, size) if size else None
    known.setdefault("indentation", known.get("travel", 1e-3 * choice.length))
    known.setdefault("normal_force", 1.0)
    return known


def _legs(name: str, choice: Choice, largest: Mapping[str, float]) -> list[dict[str, Any]]:
    sizes = _sizes(choice, largest)
    depth = _text(sizes["indentation"], "m")
    load = {"kind": "load", "normal_force": _text(sizes["normal_force"], "N"), "steps": 40}
    moved = _text(0.3 * sizes["indentation"], "m")
    twisted = _text(1e-3, "rad")
    paths: dict[str, list[dict[str, Any]]] = {
        "load": [load],
        "load and unload": [load, {**load, "normal_force": "0 N"}],
        "indent": [{"kind": "indent", "indentation": depth, "steps": 40}],
        "approach and retract": [
            {"kind": "travel", "travel": _text(2.0 * sizes["indentation"], "m"), "steps": 60},
            {"kind": "travel", "travel": _text(-6.0 * sizes["indentation"], "m"), "steps": 200},
        ],
        "shift under load": [load, {"kind": "shift", "shift": moved, "steps": 60}],
        "cycle under load": [load, {"kind": "cycle", "shift": moved, "cycles": 1, "steps": 120}],
        "twist under load": [load, {"kind": "twist", "twist": twisted, "steps": 40}],
    }
    return paths[name]


def _relaxes(new: Plain) -> bool:
    return any(new.get(part, {}).get("kind") == "viscoelastic" for part in ("body", "counterbody"))


def _is_timed(leg: Plain) -> bool:
    return any(key in leg for key in ("duration", "rate", "time"))


def knobs(choice: Choice) -> tuple[Knob, ...]:
    """
    The values of a choice that can be dragged, each a decade to either side of where it is, or within its limits.

    Examples
    --------
    >>> [knob.label for knob in knobs(start("ball"))][:4]
    ['radius', "Young's modulus", "Poisson's ratio", "Young's modulus"]
    """
    found = []
    for place, kind, unit in _quantities(choice):
        value = number(choice, place)
        key = str(place[-1])
        limits = _EXPONENTS.get(kind) if key == "exponent" and kind in _EXPONENTS else _LIMITS.get(key)
        if limits is not None:
            low, high, logarithmic = min(limits[0], value), max(limits[1], value), False
        elif value > 0.0 and unit:
            low, high, logarithmic = value * 10.0**-_DECADES, value * 10.0**_DECADES, True
        else:
            size = 2.0 * abs(value) or _largest_target(choice, key)
            low, high, logarithmic = -size, size, False
        if math.isfinite(low) and math.isfinite(high) and low < high:
            found.append(Knob(place, unit, low, high, logarithmic))
    return tuple(found)


def _largest_target(choice: Choice, channel: str) -> float:
    """The largest target of a channel over all legs, in SI units."""
    targets = (
        leg[channel] for leg in choice.tables["path"] if isinstance(leg.get(channel), str | int | float)
    )
    return (
        max((abs(to_si(t, QUANTITIES[channel].unit)) for t in targets), default=0.0)
        if channel in CHANNELS
        else 0.0
    )


def _quantities(choice: Choice) -> Iterator[tuple[Place, str, str]]:
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


def value_at(place: Place, choice: Choice) -> Any:
    """The plain value at a place."""
    entry: Any = choice.tables
    for part in place:
        entry = entry[part]
    return entry


def number(choice: Choice, place: Place) -> float:
    """The quantity at a place in SI units."""
    unit = next(unit for at, _, unit in _quantities(choice) if at == place)
    return to_si(value_at(place, choice), unit, name=str(place[-1]))


def text(choice: Choice, knob: Knob) -> str:
    """The quantity of a knob as it is shown: the text of the case, or the number with its unit."""
    value = value_at(knob.place, choice)
    return value if isinstance(value, str) else _text(float(value), knob.unit, digits=6)


def fraction(choice: Choice, knob: Knob) -> float:
    """Where a knob stands in its range, from 0 to 1."""
    value = min(max(number(choice, knob.place), knob.low), knob.high)
    if knob.logarithmic:
        return math.log(value / knob.low) / math.log(knob.high / knob.low)
    return (value - knob.low) / (knob.high - knob.low)


def dragged(choice: Choice, knob: Knob, to: float) -> Choice:
    """
    The choice with a knob dragged to a fraction of its range.

    Examples
    --------
    >>> ball = start("ball")
    >>> text(dragged(ball, knobs(ball)[0], 1.0), knobs(ball)[0])
    '100 mm'
    """
    to = min(max(to, 0.0), 1.0)
    if knob.logarithmic:
        value = knob.low * (knob.high / knob.low) ** to
    else:
        value = knob.low + to * (knob.high - knob.low)
        value = 0.0 if abs(value) < 1e-9 * max(abs(knob.low), abs(knob.high)) else value
    return _with_entry(choice, knob.place, _text(value, knob.unit))


def typed(choice: Choice, knob: Knob, entry: str) -> Choice:
    """
    The choice with a text as the value of a knob; nothing in it is evaluated.

    Raises
    ------
    UnitError
        If the text is no quantity of this unit.
    """
    to_si(entry, knob.unit, name=str(knob.place[-1]))
    return _with_entry(choice, knob.place, entry.strip())


def _with_entry(choice: Choice, place: Place, value: Any) -> Choice:
    return _with_length(replace(choice, tables=MappingProxyType(_replaced(choice.tables, place, value))))


def _replaced(entry: Any, place: Place, value: Any) -> Any:
    if not place:
        return value
    first, rest = place[0], place[1:]
    if isinstance(entry, Mapping):
        return {**entry, first: _replaced(entry[first], rest, value)}
    return [_replaced(part, rest, value) if i == first else part for i, part in enumerate(entry)]


def _text(value: float, unit: str, digits: int = _DIGITS) -> str:
    """A quantity as a text of few digits with its unit."""
    if unit == "rad" and abs(value) > 0.05:
        return f"{math.degrees(value):.{digits}g} deg"
    return written(value, unit, digits)


def python_lines(choice: Choice) -> str:
    """
    The choice as lines of Python.

    Examples
    --------
    >>> print(python_lines(start("cone")))
    import pymdr as mdr
    <BLANKLINE>
    contact = mdr.Contact(
        profile=mdr.Cone(half_angle='70.3 deg'),
        body=mdr.Elastic(young='210 GPa', poisson=0.3),
        counterbody=mdr.Elastic(young='70 GPa', poisson=0.22),
    )
    path = mdr.indent(indentation='100 nm', steps=40)
    result = mdr.solve(contact, path)
    print(result.summary())
    """
    parts = [f"    {name}={_call(choice.tables[name])},\n" for name in PARTS[:-1] if name in choice.tables]
    legs = " >> ".join(_call(leg) for leg in choice.tables["path"])
    given = {key: value for key, value in choice.tables.get("solve", {}).items() if key != "solver"}
    options = "".join(f", {key}={_source(value)}" for key, value in given.items())
    options += _rings(choice.tables.get("solve", {}))
    return (
        f"import pymdr as mdr\n\ncontact = mdr.Contact(\n{''.join(parts)})\npath = {legs}\n"
        f"result = mdr.solve(contact, path{options})\nprint(result.summary())"
    )


def _rings(options: Plain) -> str:
    return f", solver=mdr.Rings(n={options['solver'].get('n', 400)})" if "solver" in options else ""


def _call(entry: Plain) -> str:
    kind = entry["kind"]
    if kind == "sum":
        return " + ".join(_call(part) for part in entry["parts"])
    arguments = ", ".join(f"{key}={_source(value)}" for key, value in entry.items() if key != "kind")
    if kind in (*tables.ONE_CHANNEL_LEGS, *tables.ORBIT_LEGS, "cycle", "hold"):
        return f"mdr.{kind}({arguments})"
    owner = next(table[kind] for table in tables.TABLES.values() if kind in table)
    return f"mdr.{owner.__name__}({arguments})"


def _source(value: Any) -> str:
    if isinstance(value, Mapping):
        if "kind" in value:
            return _call(value)
        return f"mdr.Layer({', '.join(f'{key}={_source(entry)}' for key, entry in value.items())})"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(_source(entry) for entry in value)}]"
    return repr(value.item() if isinstance(value, np.generic) else value)
