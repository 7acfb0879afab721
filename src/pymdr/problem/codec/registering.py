"""Registration of user-defined profiles, bodies, rheologies and adhesion laws."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from pymdr.errors import ProblemError, PymdrError
from pymdr.problem.codec.models import forget_models
from pymdr.problem.codec.tables import KIND_OF, TABLES, kinds, unknown_kinds
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.materials import Material
from pymdr.problem.profiles import Profile
from pymdr.problem.rheology import Rheology
from pymdr.problem.values import OptionalArrayField, SIField
from pymdr.units import shown

PLUGINS = "pymdr.plugins"
"""Group of entry points: modules of installed packages that register kinds when they are imported."""

_NOT_KINDS = ("case", "function", "rings", "solve")
"""Reserved words of cases and their schema."""

_NOT_FIELDS = ("kind", "parts", "original", "interpolation")
"""Reserved keys of profiles."""

_FAMILIES: dict[type, str] = {
    Profile: "profile",
    Material: "material",
    Rheology: "rheology",
    AdhesionLaw: "adhesion",
}
"""Base classes that can be registered, and the tables of their kinds."""


def register(kind: str, cls: type) -> None:
    """
    Register a user-defined profile, body, rheology or adhesion law for case files, their schema and saved results.

    Parameters
    ----------
    kind : str
        Its name, as in ``[profile] kind = "..."``: lower-case letters, digits and underscores.
    cls : type
        A subclass of Profile, Material, Rheology or AdhesionLaw, declared with ``@dataclass(frozen=True, eq=False)``, whose
        fields are all SIField, ArrayField or their optional forms. A class of the same module and name replaces the earlier
        one, so that a notebook cell can be run again.

    Raises
    ------
    ProblemError
        If the kind is taken or not a valid name, or the class is unsuitable or registered as another kind.

    Notes
    -----
    To read a file, first import the module that registers its kind. Modules of installed packages that are entry points of
    the group ``pymdr.plugins`` are imported when a file has an unknown kind; ``pymdr --plugin FILE.py`` imports one file.

    Examples
    --------
    >>> from pymdr.problem.profiles import Sphere
    >>> register("cone", Sphere)
    Traceback (most recent call last):
        ...
    pymdr.errors.ProblemError: the kind 'cone' belongs to Cone; choose another name
    """
    if not isinstance(kind, str) or not re.fullmatch("[a-z][a-z0-9_]*", kind):
        raise ProblemError(
            f"kind = {shown(kind)}; use lower-case letters, digits and underscores, such as 'quartic'"
        )
    table = TABLES[_family(cls)]
    _refuse_class(cls)
    taken = table.get(kind)
    again = taken is not None and (taken.__module__, taken.__qualname__) == (cls.__module__, cls.__qualname__)
    if kind in (*kinds(), *_NOT_KINDS) and not again:
        state = f"belongs to {taken.__name__}" if taken is not None else "is reserved"
        raise ProblemError(f"the kind {kind!r} {state}; choose another name")
    if KIND_OF.get(cls, kind) != kind:
        raise ProblemError(
            f"{cls.__name__} is already registered as {KIND_OF[cls]!r}; register every class once"
        )
    if taken is not None:
        del KIND_OF[taken]
    table[kind] = cls
    KIND_OF[cls] = kind
    forget_models()


_FAILED: dict[str, str] = {}
"""Reasons why the modules of entry points could not be imported; each is tried once."""

_TRIED: set[str] = set()


def import_plugins() -> None:
    """
    Import all modules of the entry points ``pymdr.plugins`` once.

    Raises
    ------
    ProblemError
        If a module cannot be imported; the others are imported all the same.
    """
    from importlib.metadata import entry_points

    for point in sorted(entry_points(group=PLUGINS)):
        name = f"{point.name} = {point.value}"
        if name in _TRIED:
            continue
        _TRIED.add(name)
        try:
            point.load()
        except PymdrError as error:
            _FAILED[name] = str(error)
        except Exception as error:  # whatever code of another package raises
            _FAILED[name] = f"{type(error).__name__}: {error}"
    if _FAILED:
        raise ProblemError(
            f"cannot import the plugin {'; nor '.join(f'{name!r} ({why})' for name, why in _FAILED.items())}; correct the module or "
            "uninstall its package"
        )


def import_kinds(case: Mapping[str, Any]) -> list[str]:
    """
    Import the plugins of installed packages if a case has a kind that is not registered.

    Parameters
    ----------
    case : mapping
        Plain dictionaries, which may be invalid.

    Returns
    -------
    list of str
        The kinds that are still unknown.

    Raises
    ------
    ProblemError
        If a kind stays unknown and a plugin cannot be imported.

    Examples
    --------
    >>> import_kinds({"profile": {"kind": "sphere", "radius": "1 mm"}})
    []
    """
    if not unknown_kinds(case):
        return []
    try:
        import_plugins()
    except ProblemError:
        if unknown_kinds(case):
            raise
    return unknown_kinds(case)


def _family(cls: Any) -> str:
    """The table for a class."""
    if isinstance(cls, type) and not inspect.isabstract(cls):
        for base, table in _FAMILIES.items():
            if issubclass(cls, base):
                return table
    raise ProblemError(
        f"{shown(cls)} is not a class of profiles, bodies, rheologies or adhesion laws; write class Quartic(Profile) "
        "with gap and gap_slope, class Own(Material), class Own(Rheology) or class Own(AdhesionLaw)"
    )


def _refuse_class(cls: Any) -> None:
    """Refuse classes that are not frozen dataclasses of quantities."""
    declared = cls.__dict__.get("__dataclass_params__")
    if declared is None or not declared.frozen or declared.eq:
        raise ProblemError(
            f"{cls.__name__} must be frozen and compared by content; declare it with "
            "@dataclass(frozen=True, eq=False)"
        )
    for f in fields(cls):
        if f.name in _NOT_FIELDS:
            raise ProblemError(
                f"the field {f.name} of {cls.__name__} is a reserved key of files; choose another name"
            )
        if not isinstance(inspect.getattr_static(cls, f.name, None), SIField | OptionalArrayField):
            raise ProblemError(
                f"the field {f.name} of {cls.__name__} is not a quantity; declare it as "
                f"{f.name}: SIField = SIField('m', above=0)"
            )
