"""Problems as plain dictionaries and back: case files and saved results share this.

The pydantic models are derived from the problem dataclasses, so that a new profile or leg needs one entry in
the tables below and nothing else; a profile of one's own is entered by :func:`register_profile`.
"""

from __future__ import annotations

import difflib
import inspect
import re
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

import numpy as np

from pymdr.errors import CaseError, ProblemError, PymdrError
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT, JKR, Coulomb, MaugisDugdale
from pymdr.problem.layers import BONDS, Layer, Layered
from pymdr.problem.materials import Elastic, Graded, Material, Rigid, TransverselyIsotropic, Viscoelastic
from pymdr.problem.paths import CHANNELS, Cycle, History, Hold, LoadingPath, Path, Ramp, legs
from pymdr.problem.profiles import (
    ConcavePunch,
    Cone,
    CubicSpline,
    DomedPunch,
    Ellipsoid,
    EllipticParaboloid,
    FlatPunch,
    ForceCurve,
    Function,
    Function2D,
    Hyperboloid,
    Interpolated,
    Paraboloid,
    PowerLaw,
    Profile,
    Pyramid,
    RoundedCone,
    RoundedFlat,
    Sampled,
    Sampled2D,
    Shape,
    ShapePreserving,
    SmoothingSpline,
    Sphere,
    Sum,
    TruncatedCone,
    TruncatedParaboloid,
    TruncatedSphere,
    Waviness,
)
from pymdr.problem.profiles.shapes import MOST_SIDES
from pymdr.problem.rheology import KelvinVoigt, Maxwell, PowerLawRheology, Prony, StandardSolid
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import HeightsField
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, SidesField, SIField, Value
from pymdr.units import shown

if TYPE_CHECKING:
    from pydantic import BaseModel, TypeAdapter

PROFILES: dict[str, type] = {
    "sphere": Sphere,
    "paraboloid": Paraboloid,
    "cone": Cone,
    "power_law": PowerLaw,
    "flat_punch": FlatPunch,
    "ellipsoid": Ellipsoid,
    "hyperboloid": Hyperboloid,
    "rounded_cone": RoundedCone,
    "truncated_cone": TruncatedCone,
    "truncated_paraboloid": TruncatedParaboloid,
    "truncated_sphere": TruncatedSphere,
    "rounded_flat": RoundedFlat,
    "domed_punch": DomedPunch,
    "concave_punch": ConcavePunch,
    "waviness": Waviness,
    "sampled": Sampled,
    "force_curve": ForceCurve,
    "sum": Sum,
    "interpolated": Interpolated,
    "elliptic_paraboloid": EllipticParaboloid,
    "pyramid": Pyramid,
    "sampled_2d": Sampled2D,
}
MATERIALS: dict[str, type] = {
    "elastic": Elastic,
    "transversely_isotropic": TransverselyIsotropic,
    "graded": Graded,
    "viscoelastic": Viscoelastic,
    "layered": Layered,
    "rigid": Rigid,
}
SOLIDS: dict[str, type] = {"elastic": Elastic, "rigid": Rigid}
"""What layers and their base are made of."""
RHEOLOGIES: dict[str, type] = {
    "prony": Prony,
    "maxwell": Maxwell,
    "standard_solid": StandardSolid,
    "kelvin_voigt": KelvinVoigt,
    "power_law_rheology": PowerLawRheology,
}
ADHESION: dict[str, type] = {"jkr": JKR, "maugis_dugdale": MaugisDugdale, "dmt": DMT}
FRICTION: dict[str, type] = {"coulomb": Coulomb}
LEGS: dict[str, type] = {"ramp": Ramp, "cycle": Cycle, "hold": Hold, "path": Path}
ONE_CHANNEL_LEGS: dict[str, str] = {
    "indent": "indentation",
    "load": "normal_force",
    "travel": "travel",
    "shift": "shift",
    "drag": "tangential_force",
}
"""Kinds that are a ramp of one channel."""

INTERPOLATIONS: dict[str, type] = {
    "cubic_spline": CubicSpline,
    "shape_preserving": ShapePreserving,
    "smoothing_spline": SmoothingSpline,
}

_TABLES: dict[str, dict[str, type]] = {
    "profile": PROFILES,
    "material": MATERIALS,
    "solid": SOLIDS,
    "adhesion": ADHESION,
    "friction": FRICTION,
    "leg": LEGS,
    "interpolation": INTERPOLATIONS,
    "rheology": RHEOLOGIES,
}
_KIND_OF: dict[type, str] = {cls: kind for table in _TABLES.values() for kind, cls in table.items()}
_NOT_KINDS = ("case", "function", "rings", "solve")
"""Words that stand for something else in a case or its schema."""
_NOT_FIELDS = ("kind", "parts", "interpolation")
"""Keys of profiles that hold no quantity."""


def register_profile(kind: str, cls: type[Profile]) -> None:
    """
    Make a profile of one's own known to case files, their schema, and saved results.

    Parameters
    ----------
    kind : str
        The word for it in ``[profile] kind = "..."``: small letters, digits and underscores.
    cls : type
        A subclass of Profile, declared with ``@dataclass(frozen=True, eq=False)``, whose fields are all SIField,
        ArrayField or one of these that may be left out. A class of the same module and name takes the place of its
        predecessor, so that a cell of a notebook may run again.

    Raises
    ------
    ProblemError
        If the kind is taken or no such word, or the class is another one or known by another kind.

    Notes
    -----
    A file can be read where the module that registers its kind has been imported.

    Examples
    --------
    >>> register_profile("cone", Sphere)
    Traceback (most recent call last):
        ...
    pymdr.errors.ProblemError: register_profile: the kind 'cone' is that of Cone; choose another word
    """
    if not isinstance(kind, str) or not re.fullmatch("[a-z][a-z0-9_]*", kind):
        raise ProblemError(
            f"register_profile: kind = {shown(kind)}; a word of small letters, digits and underscores is needed, such as "
            "'quartic'"
        )
    _refuse_class(cls)
    taken = PROFILES.get(kind)
    again = taken is not None and (taken.__module__, taken.__qualname__) == (cls.__module__, cls.__qualname__)
    if kind in (*_kinds(), *_NOT_KINDS) and not again:
        owner = f"that of {taken.__name__}" if taken is not None else "the word for something else"
        raise ProblemError(f"register_profile: the kind {kind!r} is {owner}; choose another word")
    if _KIND_OF.get(cls, kind) != kind:
        raise ProblemError(f"register_profile: {cls.__name__} is registered as {_KIND_OF[cls]!r} already")
    if taken is not None:
        del _KIND_OF[taken]
    PROFILES[kind] = cls
    _KIND_OF[cls] = kind
    forget_models()


def forget_models() -> None:
    """Derive the models of cases anew, after a table has changed."""
    for derived in (_model, _layer_model, _union, case_adapter, rough_adapter):
        derived.cache_clear()


def _refuse_class(cls: Any) -> None:
    """Refuse what is no frozen dataclass of a profile whose fields are all quantities."""
    if not (isinstance(cls, type) and issubclass(cls, Profile)) or inspect.isabstract(cls):
        raise ProblemError(
            f"register_profile: {shown(cls)} is no class of profiles; write class Quartic(Profile) with gap and gap_slope"
        )
    declared = cls.__dict__.get("__dataclass_params__")
    if declared is None or not declared.frozen or declared.eq:
        raise ProblemError(
            f"register_profile: {cls.__name__} is compared by content and never changed; declare it with "
            "@dataclass(frozen=True, eq=False)"
        )
    for f in fields(cls):
        if f.name in _NOT_FIELDS:
            raise ProblemError(
                f"register_profile: {cls.__name__}.{f.name} is a key of files; name it otherwise"
            )
        if not isinstance(inspect.getattr_static(cls, f.name, None), SIField | OptionalArrayField):
            raise ProblemError(
                f"register_profile: {cls.__name__}.{f.name} is no quantity; declare it as "
                f"{f.name}: SIField = SIField('m', above=0)"
            )


def unknown_kinds(plain: Mapping[str, Any]) -> list[str]:
    """Kinds of a profile and of its parts, as plain dictionaries, that nobody has registered."""
    parts = plain.get("parts", []) if plain.get("kind") == "sum" else [plain]
    return [part["kind"] for part in parts if part["kind"] not in PROFILES]


def encode(value: Any) -> Any:
    """
    A problem value as plain dictionaries, lists, numbers and texts.

    Parameters
    ----------
    value : problem value

    Returns
    -------
    dict or list

    Raises
    ------
    ProblemError
        If the value holds a callable (a result replaces it by its interpolant before saving), or its class is none
        that files know.

    Examples
    --------
    >>> encode(Sphere("10 mm"))
    {'kind': 'sphere', 'radius': 0.01}
    """
    if isinstance(value, Contact):
        return {
            "profile": encode(value.profile),
            "body": encode(value.body),
            "counterbody": encode(value.counterbody),
            **({} if value.adhesion is None else {"adhesion": encode(value.adhesion)}),
            **({} if value.friction is None else {"friction": encode(value.friction)}),
        }
    if isinstance(value, History):
        return [encode(leg) for leg in value.legs]
    if isinstance(value, Function | Function2D):
        raise ProblemError(f"a {type(value).__name__} holds a callable, which cannot be written to a file")
    if type(value) in _KIND_OF:
        plain: dict[str, Any] = {"kind": _KIND_OF[type(value)]}
        for f in fields(value):
            entry = getattr(value, f.name)
            if entry is not None:
                plain[f.name] = encode(entry)
        return plain
    if isinstance(value, Layer):
        return {"material": encode(value.material), "thickness": value.thickness}
    if isinstance(value, Value):
        name = type(value).__name__
        remedy = f"; call pymdr.problem.codec.register_profile({name.lower()!r}, {name})"
        raise ProblemError(
            f"{name} is no class that files know{remedy if isinstance(value, Profile) else ''}"
        )
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [encode(entry) for entry in value]
    return value


def _field_type(cls: type, f: Any) -> tuple[Any, Any]:
    """The pydantic type and default of one dataclass field."""
    from pydantic import Field

    descriptor = inspect.getattr_static(cls, f.name, None)
    number = Union[int, float, str]  # noqa: UP007  (a runtime value)
    if isinstance(descriptor, SidesField):
        note = f"{descriptor.words}; texts with units or numbers in {descriptor.unit}"
        return number | list[number], Field(..., description=note)
    if isinstance(descriptor, HeightsField):
        note = f"{descriptor.words}; rows of numbers in {descriptor.unit}, those of one x after the other"
        return list[list[number]], Field(..., description=note)
    if isinstance(descriptor, ArrayField):
        note = f"{descriptor.words}; texts with units or numbers in {descriptor.unit}"
        return list[number], Field(..., description=note)
    if isinstance(descriptor, OptionalArrayField):
        note = f"{descriptor.words}; texts with units or numbers in {descriptor.unit}"
        return list[number] | None, Field(None, description=note)
    if isinstance(descriptor, SIField):
        unit = f"text with unit, or number in {descriptor.unit}" if descriptor.unit else "number"
        note = "; ".join(part for part in (descriptor.words, unit, descriptor.limits) if part)
        if isinstance(descriptor, OptionalSIField):
            return number | None, Field(None, description=note)
        return number, Field(... if descriptor.default is None else descriptor.default, description=note)
    if f.name == "parts":
        return list[_union("part")], Field(..., description="profiles to be added", min_length=1)  # type: ignore[misc]
    if f.name == "interpolation":
        words = "how a curve is run through; unless given, a smoothing spline if there is a scatter, else a cubic one"
        return _union("interpolation") | None, Field(None, description=words)
    if f.name == "layers":
        return list[_layer_model()], Field(..., description="from the surface downward", min_length=1)  # type: ignore[misc]
    if f.name == "material":
        return _union("solid"), Field(..., description="isotropic and elastic")
    if cls is Layered and f.name == "base":
        return _union("solid"), Field(
            {"kind": "rigid"}, description="what the layers lie on; rigid unless given"
        )
    if f.name == "bond":
        words = "between the lowest layer and the base; frictionless means that it slides and never lifts off"
        return Literal[BONDS], Field(f.default, description=words)
    if f.name == "shear":
        return _union("rheology"), Field(..., description="how it relaxes in shear")
    if f.name == "sides":
        return int, Field(..., description="number of faces", ge=3, le=MOST_SIDES, strict=True)
    if f.name == "seed":
        return int, Field(f.default, description="which surface of all", ge=0, strict=True)
    if f.name in ("steps", "cycles"):
        words = "number of rows" if f.name == "steps" else "number of cycles"
        kind = int if isinstance(f.default, int) else int | None
        return kind, Field(f.default, description=words, ge=1, strict=True)
    return Any, Field(... if f.default is MISSING else f.default)


@lru_cache(maxsize=64)
def _model(kind: str, cls: type, only: tuple[str, ...] | None = None) -> type[BaseModel]:
    from pydantic import ConfigDict, create_model

    columns: dict[str, Any] = {"kind": (Literal[kind], ...)}
    for f in fields(cls):
        if only is None or f.name in only:
            columns[f.name] = _field_type(cls, f)
    if only is not None:
        columns[only[0]] = (Union[int, float, str], ...)  # noqa: UP007
    doc = inspect.cleandoc(cls.__doc__ or "").split("\n\n")[0]
    if doc.startswith(f"{cls.__name__}("):  # what dataclass writes where there is none
        doc = ""
    return create_model(kind, __config__=ConfigDict(extra="forbid"), __doc__=doc, **columns)


@lru_cache(maxsize=1)
def _layer_model() -> Any:
    from pydantic import ConfigDict, create_model

    columns: dict[str, Any] = {f.name: _field_type(Layer, f) for f in fields(Layer)}
    doc = "One layer of a body."
    return create_model("layer", __config__=ConfigDict(extra="forbid"), __doc__=doc, **columns)


@lru_cache(maxsize=8)
def _union(table: str) -> Any:
    from pydantic import Field

    # a sum of sums is one sum, so that its parts are never sums themselves
    classes = (
        {k: c for k, c in PROFILES.items() if not issubclass(c, Sum | ForceCurve | Shape)}
        if table == "part"
        else _TABLES[table]
    )
    models = [_model(kind, cls) for kind, cls in classes.items()]
    if table == "leg":
        models += [
            _model(kind, Ramp, (c, "steps", "duration", "rate")) for kind, c in ONE_CHANNEL_LEGS.items()
        ]
    return Annotated[Union[tuple(models)], Field(discriminator="kind")]  # noqa: UP007


def _options_model() -> type[BaseModel]:
    from pydantic import ConfigDict, Field, create_model

    stiffness = Field(None, description="stiffness of what presses the bodies together, above 0 N/m")
    kept = Field(None, description="with friction: keep every k-th row", ge=1, strict=True)
    rings_only: Any = Literal["rings"]
    rings: Any = create_model(
        "rings",
        __config__=ConfigDict(extra="forbid"),
        __doc__="Boundary elements on rings instead of the method, annular contacts included.",
        kind=(rings_only, ...),
        n=(int, Field(400, description="number of rings in contact", ge=20, le=5000, strict=True)),
    )
    return create_model(
        "solve",
        __config__=ConfigDict(extra="forbid"),
        __doc__="How a case is solved.",
        machine_stiffness=(Union[int, float, str, None], stiffness),  # noqa: UP007
        keep=(int | None, kept),
        solver=(rings | None, Field(None, description="the method unless given")),
    )


@lru_cache(maxsize=1)
def case_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a whole case; its ``json_schema()`` serves editors."""
    from pydantic import ConfigDict, Field, TypeAdapter, create_model

    legs_type: Any = list[_union("leg")]  # type: ignore[misc]
    model = create_model(
        "case",
        __config__=ConfigDict(extra="forbid", title="pymdr case"),
        __doc__="One contact and its loading path.",
        title=(str, Field("", description="printed above the summary")),
        profile=(_union("profile"), ...),
        body=(_union("material"), ...),
        counterbody=(_union("material"), Field(None, description="rigid unless given")),
        adhesion=(_union("adhesion"), Field(None, description="none unless given")),
        friction=(_union("friction"), Field(None, description="frictionless unless given")),
        path=(legs_type, Field(..., description="legs, one after the other", min_length=1)),
        solve=(_options_model(), Field(None, description="how it is solved")),
    )
    return TypeAdapter(model)


@lru_cache(maxsize=1)
def rough_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a rough case."""
    from pydantic import ConfigDict, Field, TypeAdapter, create_model

    closed = ConfigDict(extra="forbid")
    columns: dict[str, Any] = {f.name: _field_type(RoughSurface, f) for f in fields(RoughSurface)}
    radius: Any = (int | float | str, Field(..., description="radius; text with unit, or number in m"))
    surface: Any = create_model("surface", __config__=closed, **columns)
    ball: Any = create_model("ball", __config__=closed, radius=radius)
    model = create_model(
        "rough_case",
        __config__=ConfigDict(extra="forbid", title="pymdr rough case"),
        __doc__="A randomly rough surface between two bodies.",
        title=(str, Field("", description="printed above the summary")),
        surface=(surface, ...),
        body=(_union("material"), ...),
        counterbody=(_union("material"), Field(None, description="rigid unless given")),
        ball=(ball | None, Field(None, description="what bears the roughness; nominally flat unless given")),
    )
    return TypeAdapter(model)


@dataclass(frozen=True)
class RoughCase:
    """What a rough case says."""

    title: str
    surface: RoughSurface
    body: Material
    counterbody: Material
    radius: float | str | None
    """Of the ball that bears the roughness; None for a nominally flat patch."""


def decode_rough(plain: Mapping[str, Any]) -> RoughCase:
    """
    A rough case from plain dictionaries.

    Parameters
    ----------
    plain : mapping
        With the tables ``surface``, ``body`` and optionally ``counterbody``, ``ball`` and ``title``.

    Returns
    -------
    RoughCase

    Raises
    ------
    CaseError
        With the table, the key, the value and the remedy.

    Examples
    --------
    >>> surface = {"hurst": 0.8, "rms": "1 um", "size": "1 mm", "shortest": "10 um", "sed": 1}
    >>> decode_rough({"surface": surface, "body": {"kind": "rigid"}})
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [surface] sed = 1: unknown key; did you mean 'seed'?
    """
    from pydantic import ValidationError

    if "surface" not in plain:
        raise CaseError(
            "table [surface] is missing; a rough case has hurst, rms, size and shortest there, and neither profile nor path"
        )
    try:
        rough_adapter().validate_python(plain)
    except RecursionError as error:
        raise CaseError("tables or lists are nested too deeply for a case") from error
    except ValidationError as error:
        raise CaseError(_in_words(error, plain)) from error
    return RoughCase(
        str(plain.get("title", "")),
        _build("surface", RoughSurface, plain["surface"]),
        _decode(plain["body"], "body"),
        _decode(plain.get("counterbody", {"kind": "rigid"}), "counterbody"),
        plain["ball"]["radius"] if "ball" in plain else None,
    )


MEASURED = ("file", "channel", "size", "unit", "missing", "detrend")
"""Keys of a measured surface: where it is, and what becomes of it."""


@lru_cache(maxsize=1)
def press_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a case whose surface is pressed by boundary elements."""
    from pydantic import ConfigDict, Field, StrictBool, TypeAdapter, create_model

    closed = ConfigDict(extra="forbid")
    columns: dict[str, Any] = {f.name: _field_type(RoughSurface, f) for f in fields(RoughSurface)}
    rough: Any = create_model("surface", __config__=closed, **columns)
    length: Any = int | float | str
    measured: Any = create_model(
        "measured",
        __config__=closed,
        file=(str, Field(..., description="of measured heights; paths count from the case file")),
        channel=(int | str | None, Field(None, description="number or name, where the file has several")),
        size=(length | list[length] | None, Field(None, description="sides, where the file has none")),
        unit=(str | None, Field(None, description="of the heights, where the file has none")),
        missing=(str | None, Field(None, description="interpolate or crop: what becomes of missing heights")),
        detrend=(str | None, Field(None, description="mean, plane, sphere or curvature: what is taken off")),
    )
    model = create_model(
        "press_case",
        __config__=ConfigDict(extra="forbid", title="pymdr press case"),
        __doc__="A surface that is pressed on a half-space.",
        title=(str, Field("", description="printed above the summary")),
        surface=(measured | rough, ...),
        punch=(StrictBool, Field(False, description="whether the body ends where the heights end")),
        body=(_union("material"), ...),
        counterbody=(_union("material"), Field(None, description="rigid unless given")),
    )
    return TypeAdapter(model)


@dataclass(frozen=True)
class PressCase:
    """What a case of a pressed surface says."""

    title: str
    surface: RoughSurface | Mapping[str, Any]
    """Random, or the keys of a file."""
    body: Material
    counterbody: Material
    punch: bool


def decode_press(plain: Mapping[str, Any]) -> PressCase:
    """
    A case of a pressed surface from plain dictionaries.

    Parameters
    ----------
    plain : mapping
        With the tables ``surface``, ``body`` and optionally ``counterbody``, ``punch`` and ``title``.

    Returns
    -------
    PressCase

    Raises
    ------
    CaseError
        With the table, the key, the value and the remedy.

    Examples
    --------
    >>> decode_press({"surface": {"file": "heights.txt", "fil": 1}, "body": {"kind": "rigid"}})
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [surface] fil = 1: unknown key; measured heights have file, channel, size, unit, missing, detrend
    """
    from pydantic import ValidationError

    surface = plain.get("surface")
    if not isinstance(surface, Mapping):
        raise CaseError(
            "table [surface] is missing; it has file, of measured heights, or hurst, rms, size and shortest of random ones"
        )
    measured = "file" in surface
    if measured:
        strange = [key for key in surface if key not in MEASURED]
        if strange:
            raise CaseError(
                f"[surface] {strange[0]} = {shown(surface[strange[0]])}: unknown key; measured heights have {', '.join(MEASURED)}"
            )
    elif "punch" in plain:
        raise CaseError("punch: a random surface is a punch as it is; leave it out")
    else:
        decode_rough(plain)
        if "ball" in plain:
            raise CaseError(
                "[ball]: boundary elements press the surface alone; add the heights of the ball to those of a file"
            )
    try:
        press_adapter().validate_python(plain)
    except RecursionError as error:
        raise CaseError("tables or lists are nested too deeply for a case") from error
    except ValidationError as error:
        raise CaseError(_in_words(error, plain)) from error
    return PressCase(
        str(plain.get("title", "")),
        dict(surface) if measured else _build("surface", RoughSurface, surface),
        _decode(plain["body"], "body"),
        _decode(plain.get("counterbody", {"kind": "rigid"}), "counterbody"),
        bool(plain.get("punch", False)),
    )


_FILE_KEYS = {
    "sampled": ("file",),
    "force_curve": ("file",),
    "prony": ("file",),
    "path": ("file", "channels"),
}
"""Keys of case files whose columns replace the arrays of a kind."""


_BESIDE_FILES = {"force_curve": ("modulus",)}
"""Keys that no such file holds."""


def case_schema() -> dict[str, Any]:
    """The JSON schema of case files, in which tables of samples may name a file instead."""
    plain: dict[str, Any] = case_adapter().json_schema()
    words = {
        "file": {"type": "string", "description": "CSV file beside the case, with units in its header"},
        "channels": {
            "type": "array",
            "items": {"enum": list(CHANNELS)},
            "description": "the columns of the file that are prescribed",
        },
    }
    for kind, keys in _FILE_KEYS.items():
        table = plain["$defs"][kind]
        table["properties"] |= {key: words[key] for key in keys}
        arrays = [key for key in table["required"] if key not in ("kind", *_BESIDE_FILES.get(kind, ()))]
        table["required"] = ["kind", *_BESIDE_FILES.get(kind, ())]
        if arrays:
            table["anyOf"] = [{"required": arrays}, {"required": ["file"]}]
    return plain


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

    Raises
    ------
    CaseError
        With the table, the key, the value and the remedy.

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
        ask = "pymdr press" if measured else "pymdr rough or pymdr press"
        raise CaseError(f"[surface]: a rough surface is no profile with a path; ask for it with {ask}")
    if isinstance(plain.get("path"), Mapping):
        plain = {**plain, "path": [plain["path"]]}
    contact = _contact(plain)
    pieces = [_decode(leg, f"path {i + 1}") for i, leg in enumerate(plain["path"])]
    path = pieces[0] if len(pieces) == 1 else History(tuple(pieces))
    return str(plain.get("title", "")), contact, path


def decode_contact(plain: Mapping[str, Any]) -> tuple[str, Contact]:
    """
    The title and the contact of a case from plain dictionaries, whose path may be missing.

    Parameters
    ----------
    plain : mapping
        As for :func:`decode_case`.

    Returns
    -------
    title : str
    contact : Contact

    Raises
    ------
    CaseError
        With the table, the key, the value and the remedy.

    Examples
    --------
    >>> case = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": {"kind": "elastic", "young": "1 GPa", "poisson": 0.3}}
    >>> decode_contact(case)[1].body.young
    1000000000.0
    """
    if "path" in plain or "surface" in plain:
        return decode_case(plain)[:2]
    return str(plain.get("title", "")), _contact({**plain, "path": [{"kind": "hold"}]})


def _contact(plain: Mapping[str, Any]) -> Contact:
    from pydantic import ValidationError

    try:
        case_adapter().validate_python(_without_arrays(plain))
    except RecursionError as error:
        raise CaseError("tables or lists are nested too deeply for a case") from error
    except ValidationError as error:
        raise CaseError(_in_words(error, plain)) from error
    contact: Contact = _build(
        "contact",
        Contact,
        {
            "profile": _decode(plain["profile"], "profile"),
            "body": _decode(plain["body"], "body"),
            "counterbody": _decode(plain.get("counterbody", {"kind": "rigid"}), "counterbody"),
            **{name: _decode(plain[name], name) for name in ("adhesion", "friction") if name in plain},
        },
    )
    return contact


def encode_case(title: str, contact: Contact, path: LoadingPath) -> dict[str, Any]:
    """The inverse of :func:`decode_case`."""
    case = {**encode(contact), "path": [encode(leg) for leg in legs(path)]}
    return {"title": title, **case} if title else case


def _decode(plain: Mapping[str, Any], table: str) -> Any:
    arguments = dict(plain)
    kind = arguments.pop("kind")
    cls = Ramp if kind in ONE_CHANNEL_LEGS else next(t[kind] for t in _TABLES.values() if kind in t)
    if "parts" in arguments:
        arguments["parts"] = tuple(_decode(part, f"{table}.parts") for part in arguments["parts"])
    if "interpolation" in arguments:
        arguments["interpolation"] = _decode(arguments["interpolation"], f"{table}.interpolation")
    if cls is Layered:
        arguments["layers"] = tuple(
            _build(
                f"{table}.layers {i}",
                Layer,
                {**one, "material": _decode(one["material"], f"{table}.layers {i}.material")},
            )
            for i, one in enumerate(arguments["layers"], 1)
        )
        if "base" in arguments:
            arguments["base"] = _decode(arguments["base"], f"{table}.base")
    if isinstance(arguments.get("shear"), Mapping):
        arguments["shear"] = _decode(arguments["shear"], f"{table}.shear")
    return _build(table, cls, arguments)


def _build(table: str, cls: type, arguments: Mapping[str, Any]) -> Any:
    try:
        return cls(**arguments)
    except PymdrError as error:
        raise CaseError(f"[{table}] {error}") from error


def _without_arrays(plain: Any) -> Any:
    """The same with one number for every array: columns of files were read as numbers already."""
    if isinstance(plain, Mapping):
        return {key: _without_arrays(entry) for key, entry in plain.items()}
    if isinstance(plain, list) and any(isinstance(entry, Mapping | list) for entry in plain):
        return [_without_arrays(entry) for entry in plain]
    return [0.0] if isinstance(plain, np.ndarray) else plain


_SHOWN = 4
"""Complaints that one message tells."""


def _in_words(error: Any, plain: Mapping[str, Any]) -> str:
    """The complaints of a validation, with table, key, value and remedy."""
    found: dict[str, None] = {}
    suggested: set[tuple[Any, ...]] = set()
    complaints = error.errors(include_url=False)
    for one in sorted(complaints, key=lambda e: e["type"] != "extra_forbidden"):
        full = [part for part in one["loc"] if not str(part).startswith("list[")]
        while len(full) > 1 and full[-1] in _ALTERNATIVES:
            full.pop()
        # pydantic names the kind of every tagged table; users know the table
        loc = [part for i, part in enumerate(full) if i in (0, len(full) - 1) or part not in _kinds()]
        if one["type"] == "missing" and tuple(loc) in suggested:
            continue
        if one["type"] == "extra_forbidden":
            suggested |= {(*loc[:-1], key) for key in _near(str(loc[-1]), _known_keys(loc[:-1], plain))}
        found[_complaint(one, loc, plain)] = None
    told = list(found)
    more = f"; and {len(told) - _SHOWN} more of this kind" if len(told) > _SHOWN else ""
    return "; ".join(told[:_SHOWN]) + more


_ALTERNATIVES = ("int", "float", "str")
"""What pydantic appends for every form that a number may have."""

_NEEDED = {
    "string_type": "a text is needed",
    "list_type": "a list is needed",
    "model_type": "a table is needed",
    "model_attributes_type": "a table is needed",
    "dict_type": "a table is needed",
    "literal_error": "another kind is needed",
}


def _complaint(one: Mapping[str, Any], loc: list[Any], plain: Mapping[str, Any]) -> str:
    path = [str(part + 1) if isinstance(part, int) else str(part) for part in loc]
    table, key = path[:-1], path[-1] if path else "the case"
    where = f"[{' '.join(table)}] " if table else ""
    match one["type"]:
        case "extra_forbidden":
            hint = _nearest(key, _known_keys(loc[:-1], plain))
            return f"{where}{key} = {shown(one['input'])}: unknown {'key' if table else 'table'}; {hint}"
        case "missing":
            return f"{where}{f'key {key!r} is missing' if table else f'table [{key}] is missing'}"
        case "union_tag_not_found":
            return f"[{' '.join(path)}] key 'kind' is missing; one of {_kinds_for(loc)} is needed"
        case "union_tag_invalid":
            tag = str(one["ctx"]["tag"])
            if tag == "sum" and "parts" in loc:
                return f"[{' '.join(path)}] kind = 'sum': a part is no sum itself; list its parts beside the others"
            if tag.lower() == "function" and loc and loc[0] == "profile":
                return (
                    f"[{' '.join(path)}] kind = {shown(tag)}: no text of a case is evaluated as a formula; give samples "
                    "of it (kind = 'sampled' with file = 'profile.csv'), or write a Python script with pymdr.Function"
                )
            return f"[{' '.join(path)}] kind = {shown(tag)}: unknown kind; {_nearest(tag, _kinds_for(loc))}"
        case "too_short":
            return f"{where}{key}: at least one entry is needed"
        case "greater_than_equal":
            return f"{where}{key} = {shown(one['input'])}: it must be at least {one['ctx']['ge']}"
        case "less_than_equal":
            return f"{where}{key} = {shown(one['input'])}: it must be at most {one['ctx']['le']}"
        case other:
            whole = key in ("steps", "cycles", "keep", "n", "seed", "sides")
            number = "a whole number is needed" if whole else "a number or a text with its unit is needed"
            needed = number if one["loc"][-1] in _ALTERNATIVES or whole else _NEEDED.get(other, number)
            return f"{where}{key} = {shown(one['input'])}: {needed}"


def _kinds() -> set[str]:
    return {kind for table in _TABLES.values() for kind in table} | set(ONE_CHANNEL_LEGS)


def _kinds_for(loc: list[Any]) -> list[str]:
    if "path" in loc:
        return [*LEGS, *ONE_CHANNEL_LEGS]
    if "interpolation" in loc:
        return list(INTERPOLATIONS)
    if "shear" in loc:
        return list(RHEOLOGIES)
    if "material" in loc or "base" in loc:
        return list(SOLIDS)
    if "parts" in loc:
        return [kind for kind in PROFILES if kind != "sum"]
    if loc and loc[0] in ("adhesion", "friction"):
        return list(_TABLES[loc[0]])
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
        return ["machine_stiffness", "keep", "solver"]
    if loc == ["solve", "solver"]:
        return ["kind", "n"]
    for part in loc:
        plain = plain[part]
    kind = plain.get("kind")
    if kind in ONE_CHANNEL_LEGS:
        return ["kind", ONE_CHANNEL_LEGS[kind], "steps", "duration"]
    cls = next((table[kind] for table in _TABLES.values() if kind in table), None)
    return ["kind", *(f.name for f in fields(cls)), *_FILE_KEYS.get(kind, ())] if cls else ["kind"]


def _near(word: str, known: list[str]) -> list[str]:
    """The nearest of the known words; those that differ in capitals or are written one within the other come first."""
    plain = word.lower()
    same = [name for name in known if name.lower() == plain]
    return same or difflib.get_close_matches(plain[:80], known, n=1, cutoff=0.5)


def _nearest(word: str, known: list[str]) -> str:
    near = _near(word, known)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
