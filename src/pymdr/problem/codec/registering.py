"""Profiles, bodies, rheologies and laws of adhesion of one's own."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from typing import Any

from pymdr.errors import ProblemError
from pymdr.problem.codec.models import forget_models
from pymdr.problem.codec.tables import KIND_OF, TABLES, kinds
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.materials import Material
from pymdr.problem.profiles import Profile
from pymdr.problem.rheology import Rheology
from pymdr.problem.values import OptionalArrayField, SIField
from pymdr.units import shown

_NOT_KINDS = ("case", "function", "rings", "solve")
"""Words that stand for something else in a case or its schema."""

_NOT_FIELDS = ("kind", "parts", "interpolation")
"""Keys of profiles that hold no quantity."""

_FAMILIES: dict[type, str] = {
    Profile: "profile",
    Material: "material",
    Rheology: "rheology",
    AdhesionLaw: "adhesion",
}
"""Base classes of what can be registered, and the tables that hold their kinds."""


def register(kind: str, cls: type) -> None:
    """
    Make a profile, body, rheology or law of adhesion of one's own known to case files, their schema, and saved results.

    Parameters
    ----------
    kind : str
        The word for it, as in ``[profile] kind = "..."``: small letters, digits and underscores.
    cls : type
        A subclass of Profile, Material, Rheology or AdhesionLaw, declared with ``@dataclass(frozen=True, eq=False)``, whose
        fields are all SIField, ArrayField or one of these that may be left out. A class of the same module and name takes the
        place of its predecessor, so that a cell of a notebook may run again.

    Raises
    ------
    ProblemError
        If the kind is taken or no such word, or the class is another one or known by another kind.

    Notes
    -----
    A file can be read where the module that registers its kind has been imported.

    Examples
    --------
    >>> from pymdr.problem.profiles import Sphere
    >>> register("cone", Sphere)
    Traceback (most recent call last):
        ...
    pymdr.errors.ProblemError: register: the kind 'cone' is that of Cone; choose another word
    """
    if not isinstance(kind, str) or not re.fullmatch("[a-z][a-z0-9_]*", kind):
        raise ProblemError(
            f"register: kind = {shown(kind)}; a word of small letters, digits and underscores is needed, such as 'quartic'"
        )
    table = TABLES[_family(cls)]
    _refuse_class(cls)
    taken = table.get(kind)
    again = taken is not None and (taken.__module__, taken.__qualname__) == (cls.__module__, cls.__qualname__)
    if kind in (*kinds(), *_NOT_KINDS) and not again:
        owner = f"that of {taken.__name__}" if taken is not None else "the word for something else"
        raise ProblemError(f"register: the kind {kind!r} is {owner}; choose another word")
    if KIND_OF.get(cls, kind) != kind:
        raise ProblemError(f"register: {cls.__name__} is registered as {KIND_OF[cls]!r} already")
    if taken is not None:
        del KIND_OF[taken]
    table[kind] = cls
    KIND_OF[cls] = kind
    forget_models()


def _family(cls: Any) -> str:
    """The table for a class."""
    if isinstance(cls, type) and not inspect.isabstract(cls):
        for base, table in _FAMILIES.items():
            if issubclass(cls, base):
                return table
    raise ProblemError(
        f"register: {shown(cls)} is no class of profiles, bodies, rheologies or laws of adhesion; write class Quartic(Profile) "
        "with gap and gap_slope, class Own(Material), class Own(Rheology) or class Own(AdhesionLaw)"
    )


def _refuse_class(cls: Any) -> None:
    """Refuse what is no frozen dataclass whose fields are all quantities."""
    declared = cls.__dict__.get("__dataclass_params__")
    if declared is None or not declared.frozen or declared.eq:
        raise ProblemError(
            f"register: {cls.__name__} is compared by content and never changed; declare it with "
            "@dataclass(frozen=True, eq=False)"
        )
    for f in fields(cls):
        if f.name in _NOT_FIELDS:
            raise ProblemError(f"register: {cls.__name__}.{f.name} is a key of files; name it otherwise")
        if not isinstance(inspect.getattr_static(cls, f.name, None), SIField | OptionalArrayField):
            raise ProblemError(
                f"register: {cls.__name__}.{f.name} is no quantity; declare it as "
                f"{f.name}: SIField = SIField('m', above=0)"
            )
