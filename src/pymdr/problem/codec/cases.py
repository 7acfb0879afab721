"""Cases from plain dictionaries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pymdr.errors import CaseError, PymdrError
from pymdr.problem.codec.complaints import refuse_invalid
from pymdr.problem.codec.models import LOADS, case_adapter, press_adapter, rough_adapter
from pymdr.problem.codec.registering import import_kinds
from pymdr.problem.codec.tables import ONE_CHANNEL_LEGS, ORBIT_LEGS, TABLES
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layer, Layered
from pymdr.problem.materials import Material
from pymdr.problem.paths import History, Leg, LoadingPath, Ramp
from pymdr.problem.rough import RoughSurface
from pymdr.units import to_si_array


@dataclass(frozen=True)
class SurfaceCase:
    """What the cases of surfaces share."""

    title: str
    body: Material
    counterbody: Material
    normal_force: tuple[str, ...]
    """Loads, unless a command has others."""
    indentation: tuple[str, ...]


@dataclass(frozen=True)
class RoughCase(SurfaceCase):
    """The contents of a rough case."""

    surface: RoughSurface
    radius: float | str | None
    """Radius of the rough ball; None for a nominally flat patch."""


@dataclass(frozen=True)
class PressCase(SurfaceCase):
    """The contents of a case of a pressed surface."""

    surface: RoughSurface | Mapping[str, Any]
    """A random surface, or the keys of a measured one."""
    punch: bool


def decode_case(plain: Mapping[str, Any]) -> tuple[str, Contact, LoadingPath]:
    """
    A case from plain dictionaries.

    Parameters
    ----------
    plain : mapping
        With the tables ``profile``, ``body``, ``path`` and optionally ``counterbody`` and ``title``.

    Returns
    -------
    title : str
    contact : Contact
    path : LoadingPath

    Examples
    --------
    >>> case = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": {"kind": "elastc"}, "path": []}
    >>> decode_case(case)
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [body] kind = 'elastc': unknown kind; did you mean 'elastic'?; path: at least one entry is needed
    """
    if "surface" in plain:
        measured = isinstance(plain["surface"], Mapping) and "file" in plain["surface"]
        command = "pymdr press" if measured else "pymdr rough or pymdr press"
        raise CaseError(f"[surface]: a rough surface has neither profile nor path; use {command}")
    if "machine" in plain:
        raise CaseError("[machine]: the motion of a machine has no path; use pymdr move")
    if isinstance(plain.get("path"), Mapping):
        plain = {**plain, "path": [plain["path"]]}
    legs = {f"path {i}": leg for i, leg in enumerate(plain.get("path", ()), 1)}
    contact, parts = _decoded(plain, legs)
    path = parts[0] if len(parts) == 1 else History(tuple(parts))
    return str(plain.get("title", "")), contact, path


def decode_contact(plain: Mapping[str, Any]) -> tuple[str, Contact]:
    """
    The title and the contact of a case from plain dictionaries; the path is optional.

    Examples
    --------
    >>> case = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": {"kind": "elastic", "young": "1 GPa", "poisson": 0.3}}
    >>> decode_contact(case)[1].body.young
    1000000000.0
    """
    if "path" in plain or "surface" in plain:
        return decode_case(plain)[:2]
    return str(plain.get("title", "")), _decoded({**plain, "path": [{"kind": "hold"}]}, {})[0]


def decode_rough(plain: Mapping[str, Any]) -> RoughCase:
    """
    A rough case from plain dictionaries.

    Parameters
    ----------
    plain : mapping
        With the tables ``surface``, ``body`` and optionally ``counterbody``, ``ball``, ``title`` and loads.

    Examples
    --------
    >>> surface = {"hurst": 0.8, "rms": "1 um", "size": "1 mm", "shortest": "10 um", "sed": 1}
    >>> decode_rough({"surface": surface, "body": {"kind": "rigid"}})
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [surface] sed = 1: unknown key; did you mean 'seed'?
    """
    if "surface" not in plain:
        raise CaseError(
            "table [surface] is missing; a rough case needs it with hurst, rms, size and shortest, and has no profile and path"
        )
    _refuse_other_bodies(plain)
    import_kinds(plain)
    refuse_invalid(plain, rough_adapter())
    surface = _build("surface", RoughSurface, plain["surface"])
    radius = plain["ball"]["radius"] if "ball" in plain else None
    return RoughCase(surface=surface, radius=radius, **_shared(plain))


def decode_press(plain: Mapping[str, Any]) -> PressCase:
    """
    A case of a pressed surface from plain dictionaries.

    Parameters
    ----------
    plain : mapping
        With the tables ``surface``, ``body`` and optionally ``counterbody``, ``punch``, ``title`` and loads.

    Examples
    --------
    >>> decode_press({"surface": {"file": "heights.txt", "fil": 1}, "body": {"kind": "rigid"}})
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [surface] fil = 1: unknown key; did you mean 'file'?
    """
    surface = plain.get("surface")
    if not isinstance(surface, Mapping):
        raise CaseError(
            "table [surface] is missing; give file for measured heights, or hurst, rms, size and shortest for random ones"
        )
    measured = "file" in surface
    if not measured and "punch" in plain:
        raise CaseError("a random surface is always a punch; leave the key out")
    _refuse_other_bodies(plain)
    import_kinds(plain)
    ball = "not available with pymdr press; add the heights of the ball to those of a file"
    refuse_invalid(plain, press_adapter(), {("ball",): ball})
    heights = dict(surface) if measured else _build("surface", RoughSurface, surface)
    return PressCase(surface=heights, punch=bool(plain.get("punch", False)), **_shared(plain))


def _refuse_other_bodies(plain: Mapping[str, Any]) -> None:
    """Refuse bodies that rough contacts do not cover, before their keys and files are read."""
    for name in ("body", "counterbody"):
        table = plain.get(name)
        kind = table.get("kind") if isinstance(table, Mapping) else None
        if kind in ("viscoelastic", "graded", "layered"):
            memory = (
                "; its force_curve() in Python is a profile for viscoelastic bodies"
                if kind == "viscoelastic"
                else ""
            )
            raise CaseError(
                f"[{name}] kind = '{kind}': rough surfaces are pressed on homogeneous elastic half-spaces; give an elastic "
                f"or transversely_isotropic body{memory}"
            )


def _decoded(plain: Mapping[str, Any], legs: Mapping[str, Mapping[str, Any]]) -> tuple[Contact, list[Leg]]:
    """The contact and the legs of a case."""
    import_kinds(plain)
    refuse_invalid(plain, case_adapter())
    return build_contact(plain, legs)


def build_contact(
    plain: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]
) -> tuple[Contact, list[Any]]:
    """The contact of a valid case, and other parts of it by their places."""
    names = ("profile", "body", "counterbody", "adhesion", "friction")
    given = {name: plain[name] for name in names if name in plain}
    built = build_all({**given, **others})
    contact: Contact = _build(None, Contact, {name: built[name] for name in given})
    return contact, [built[name] for name in others]


def build_all(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """What valid tables describe, by their places; the mistakes of all are refused together."""
    built: dict[str, Any] = {}
    faults: list[str] = []
    for place, table in tables.items():
        try:
            built[place] = _decode(table, place)
        except CaseError as error:
            faults.append(str(error))
    if faults:
        raise CaseError("; ".join(faults))
    return built


def _shared(plain: Mapping[str, Any]) -> dict[str, Any]:
    """What the cases of surfaces share."""
    if all(name in plain for name in LOADS):
        raise CaseError("normal_force and indentation: give one of them")
    bodies = {"counterbody": {"kind": "rigid"}, **plain}
    return {
        "title": str(plain.get("title", "")),
        **{name: _decode(bodies[name], name) for name in ("body", "counterbody")},
        **{name: _loads(plain.get(name, []), name, unit) for name, unit in LOADS.items()},
    }


def _loads(given: Any, name: str, unit: str) -> tuple[str, ...]:
    values = to_si_array(given, unit, name=name).ravel().tolist()
    return tuple(f"{value!r} {unit}" for value in values)


def _decode(plain: Mapping[str, Any], table: str) -> Any:
    arguments = dict(plain)
    kind = arguments.pop("kind")
    if kind in ORBIT_LEGS:
        return _build(table, ORBIT_LEGS[kind], arguments)
    cls = Ramp if kind in ONE_CHANNEL_LEGS else next(t[kind] for t in TABLES.values() if kind in t)
    if "parts" in arguments:
        arguments["parts"] = tuple(_decode(part, f"{table}.parts") for part in arguments["parts"])
    if "original" in arguments:
        arguments["original"] = _decode(arguments["original"], f"{table}.original")
    if "interpolation" in arguments:
        arguments["interpolation"] = _decode(arguments["interpolation"], f"{table}.interpolation")
    if cls is Layered:
        arguments["layers"] = tuple(
            _build(
                f"{table}.layers {i}",
                Layer,
                {**layer, "material": _decode(layer["material"], f"{table}.layers {i}.material")},
            )
            for i, layer in enumerate(arguments["layers"], 1)
        )
        if "base" in arguments:
            arguments["base"] = _decode(arguments["base"], f"{table}.base")
    for name in ("shear", "young"):
        if isinstance(arguments.get(name), Mapping):
            arguments[name] = _decode(arguments[name], f"{table}.{name}")
    return _build(table, cls, arguments)


def _build(table: str | None, make: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    try:
        return make(**arguments)
    except PymdrError as error:
        raise CaseError(str(error) if table is None else f"[{table}] {error}") from error
