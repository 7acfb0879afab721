"""Pydantic models of cases, derived from the problem dataclasses, and their JSON schema."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, fields
from functools import cache, lru_cache
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pymdr.errors import PymdrError
from pymdr.problem.codec.outputs import CLOSED, output_tables
from pymdr.problem.codec.tables import (
    ONE_CHANNEL_LEGS,
    ORBIT_LEGS,
    PROFILES,
    TABLES,
)
from pymdr.problem.layers import BONDS, Layer, Layered
from pymdr.problem.machines import CoordinateField, Machine, WavesField
from pymdr.problem.paths import CHANNELS, Ramp
from pymdr.problem.profiles import ForceCurve, Shape, Sum, Worn
from pymdr.problem.profiles.shapes import MOST_SIDES
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import HeightsField
from pymdr.problem.values import (
    ArrayField,
    OptionalArrayField,
    OptionalPlaneArrayField,
    OptionalPlaneField,
    OptionalSIField,
    SidesField,
    SIField,
    read_stiffness,
)

if TYPE_CHECKING:
    from pydantic import BaseModel, TypeAdapter


LOADS = {"normal_force": "N", "indentation": "m"}
"""Loads of a surface, and their units."""

FILE_KEYS = {"sampled": ("file",), "force_curve": ("file",), "prony": ("file",), "path": ("file", "channels")}
"""Keys of case files that replace the arrays of a kind by columns of a file."""

_NOT_IN_FILES = {"force_curve": ("modulus",)}
"""Required keys that these files cannot hold."""


def case_schema() -> dict[str, Any]:
    """The JSON schema of case files, where a file may replace arrays."""
    plain: dict[str, Any] = case_adapter().json_schema()
    keys_of_files = {
        "file": {
            "type": "string",
            "description": "CSV file with units in its header; relative to the case file",
        },
        "channels": {
            "anyOf": [
                {"type": "array", "items": {"enum": list(CHANNELS)}},
                {
                    "type": "object",
                    "propertyNames": {"enum": ["time", *CHANNELS]},
                    "additionalProperties": {"type": "string"},
                },
            ],
            "description": "columns of the file to prescribe, or a table of channels and the titles of their columns",
        },
    }
    for kind, keys in FILE_KEYS.items():
        table = plain["$defs"][kind]
        table["properties"] |= {key: keys_of_files[key] for key in keys}
        arrays = [key for key in table["required"] if key not in ("kind", *_NOT_IN_FILES.get(kind, ()))]
        table["required"] = ["kind", *_NOT_IN_FILES.get(kind, ())]
        if arrays:
            table["anyOf"] = [{"required": arrays}, {"required": ["file"]}]
    return plain


@lru_cache(maxsize=1)
def case_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a complete case."""
    from pydantic import ConfigDict, Field, TypeAdapter, create_model

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
        path=(_list_of(_union("leg")), Field(..., description="legs in order", min_length=1)),
        solve=(_options_model(), Field(None, description="solver options")),
        **output_tables(),
    )
    return TypeAdapter(model)


@lru_cache(maxsize=1)
def rough_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a rough case."""
    from pydantic import ConfigDict, Field, TypeAdapter, create_model

    radius: Any = (int | float | str, Field(..., description="radius; text with unit, or number in m"))
    ball: Any = create_model("ball", __config__=CLOSED, radius=radius)
    model = create_model(
        "rough_case",
        __config__=ConfigDict(extra="forbid", title="pymdr rough case"),
        __doc__="A randomly rough surface between two bodies.",
        surface=(_without_kind("surface", RoughSurface), ...),
        **_of_surfaces(),
        ball=(ball | None, Field(None, description="rough ball; nominally flat unless given")),
    )
    return TypeAdapter(model)


@lru_cache(maxsize=1)
def press_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a case whose surface is pressed by boundary elements."""
    from pydantic import ConfigDict, Discriminator, Field, StrictBool, Tag, TypeAdapter, create_model

    rough = _without_kind("surface", RoughSurface)
    length: Any = int | float | str
    measured: Any = create_model(
        "measured",
        __config__=CLOSED,
        file=(str, Field(..., description="file of measured heights; relative to the case file")),
        channel=(int | str | None, Field(None, description="number or name, if the file has several")),
        size=(length | list[length] | None, Field(None, description="sides, if not in the file")),
        unit=(str | None, Field(None, description="unit of the heights, if not in the file")),
        missing=(str | None, Field(None, description="interpolate or crop: treatment of missing heights")),
        detrend=(str | None, Field(None, description="mean, plane, sphere or curvature: trend to subtract")),
    )
    kinds: Any = Annotated[
        Annotated[measured, Tag("measured")] | Annotated[rough, Tag("surface")],
        Discriminator(lambda table: "measured" if "file" in table else "surface"),
    ]
    model = create_model(
        "press_case",
        __config__=ConfigDict(extra="forbid", title="pymdr press case"),
        __doc__="A surface pressed on a half-space.",
        surface=(kinds, ...),
        punch=(StrictBool, Field(False, description="whether the body ends at the edge of the heights")),
        **_of_surfaces(),
    )
    return TypeAdapter(model)


def _of_surfaces() -> dict[str, Any]:
    """What the cases of surfaces share."""
    from pydantic import Field

    value: Any = int | float | str
    load = Field(None, description="one or several; unless given, an option of the command")
    loads: dict[str, Any] = {}
    for name, unit in LOADS.items():
        values = WavesField(unit)
        values.__set_name__(RoughSurface, name)
        loads[name] = (_checked(value | list[value] | None, values), load)
    return {
        "title": (str, Field("", description="printed above the summary")),
        "body": (_union("material"), ...),
        "counterbody": (_union("material"), Field(None, description="rigid unless given")),
        **loads,
    }


@lru_cache(maxsize=1)
def machine_adapter() -> TypeAdapter[Any]:
    """The pydantic adapter of a case of a machine."""
    from pydantic import ConfigDict, Field, TypeAdapter, create_model

    span = SIField("s", above=0.0)
    span.__set_name__(Machine, "duration")
    duration: Any = _checked(int | float | str, span)
    accuracy: Any = Annotated[float, Field(strict=True, ge=1e-12, lt=1.0, allow_inf_nan=False)]
    table: Any = create_model(
        "machine",
        __config__=CLOSED,
        __doc__="Masses, rotors and drives, and what acts between them.",
        duration=(duration, Field(..., description="of the motion; text with unit, or number in s")),
        steps=(int, Field(1000, description="rows after the first", ge=2, strict=True)),
        accuracy=(accuracy, Field(1e-3, description="largest change by the last halving of the steps")),
        bodies=(_list_of(_union("machine_body")), Field(..., min_length=1)),
        links=(_list_of(_union("machine_link")), Field([])),
    )
    model = create_model(
        "machine_case",
        __config__=ConfigDict(extra="forbid", title="pymdr case of a machine"),
        __doc__="A machine whose joints are one contact.",
        title=(str, Field("", description="printed above the summary")),
        profile=(_union("profile"), ...),
        body=(_union("material"), ...),
        counterbody=(_union("material"), Field(None, description="rigid unless given")),
        friction=(_union("friction"), Field(None, description="frictionless unless given")),
        machine=(table, ...),
    )
    return TypeAdapter(model)


def forget_models() -> None:
    """Clear the derived models after a table has changed."""
    adapters = (case_adapter, rough_adapter, press_adapter, machine_adapter)
    for derived in (_model, _union, *adapters):
        derived.cache_clear()


def _options_model() -> type[BaseModel]:
    from pydantic import AfterValidator, Field, create_model

    def checked(value: Any) -> Any:
        if value is not None:
            read_stiffness(value)
        return value

    number: Any = Annotated[Union[int, float, str, None], AfterValidator(checked)]  # noqa: UP007
    stiffness = Field(None, description="stiffness of the loading machine, above 0 N/m; 0 is a dead load")
    kept = Field(None, description="with friction: keep every k-th row", ge=1, strict=True)
    text = "cohesive zone with memory: relative error of the force"
    tolerance: Any = Annotated[float, Field(strict=True, ge=1e-6, le=1e-2, allow_inf_nan=False)]
    rings_only: Any = Literal["rings"]
    rings: Any = create_model(
        "rings",
        __config__=CLOSED,
        __doc__="Boundary elements on rings instead of the method, annular contacts included.",
        kind=(rings_only, ...),
        n=(int, Field(400, description="number of rings in contact", ge=20, le=5000, strict=True)),
    )
    return create_model(
        "solve",
        __config__=CLOSED,
        __doc__="How a case is solved.",
        machine_stiffness=(number, stiffness),
        keep=(int | None, kept),
        solver=(rings | None, Field(None, description="by default the method of dimensionality reduction")),
        tolerance=(tolerance | None, Field(None, description=text)),
    )


def _list_of(kind: Any) -> Any:
    """A list type of a model made at run time."""
    return GenericAlias(list, (kind,))


_INSIDE = {"part": (Sum, ForceCurve, Shape, Worn), "original": (ForceCurve, Shape, Worn)}
"""Profiles that others do not contain: sums and worn ones are not nested."""


@cache
def _union(table: str) -> Any:
    from pydantic import Field

    inside = _INSIDE.get(table)
    classes = PROFILES if inside else TABLES[table]
    models = [_model(kind, c) for kind, c in classes.items() if not inside or not issubclass(c, inside)]
    if table == "leg":
        models += [
            _model(kind, Ramp, (c, "steps", "duration", "rate")) for kind, c in ONE_CHANNEL_LEGS.items()
        ]
        models += [_orbit_model(kind) for kind in ORBIT_LEGS]
    return Annotated[Union[tuple(models)], Field(discriminator="kind")]  # noqa: UP007


@lru_cache(maxsize=64)
def _model(kind: str, cls: type, only: tuple[str, ...] | None = None) -> type[BaseModel]:
    from pydantic import Field, create_model

    columns: dict[str, Any] = {"kind": (Literal[kind], ...)}
    for f in fields(cls):
        # all joints of a case are its contact
        if (only is None or f.name in only) and f.name != "contact":
            columns[f.name] = _field_type(cls, f)
    if "shear" in columns:
        text = "relaxation in tension, instead of shear; needs poisson"
        columns["young"] = (_union("rheology") | None, Field(None, description=text))
    if only is not None:
        columns[only[0]] = (columns[only[0]][0], ...)
    doc = inspect.cleandoc(cls.__doc__ or "").split("\n\n")[0]
    if doc.startswith(f"{cls.__name__}("):  # the default of dataclasses
        doc = ""
    return create_model(kind, __config__=CLOSED, __doc__=doc, **columns)


def _orbit_model(kind: str) -> type[BaseModel]:
    """The model of a circle or a Lissajous figure."""
    from pydantic import Field, create_model

    number: Any = int | float | str
    size = number if kind == "circle" else list[number]
    text = "radius" if kind == "circle" else "pair of amplitudes along x and y"
    center = "centre, a pair (x, y) in the unit of the channel; [0, 0] unless given"
    columns: dict[str, Any] = {
        "kind": (Literal[kind], ...),
        "shift": (size | None, Field(None, description=f"{text}; text with unit, or number in m")),
        "tangential_force": (size | None, Field(None, description=f"{text}; text with unit, or number in N")),
        "turns": (int | float, Field(1.0, description="number of turns; below 0 clockwise")),
        "steps": (
            int | None,
            Field(None, description="number of rows; 64 per turn unless given", ge=1, strict=True),
        ),
        "center": (list[number], Field([0.0, 0.0], description=center)),
    }
    if kind == "lissajous":
        columns["frequencies"] = (
            list[int | float],
            Field([1.0, 2.0], description="pair of frequencies, above 0"),
        )
        columns["phase"] = (number, Field(0.0, description="phase of x; text with unit, or number in rad"))
    doc = inspect.cleandoc(ORBIT_LEGS[kind].__doc__ or "").split("\n\n")[0]
    return create_model(kind, __config__=CLOSED, __doc__=doc, **columns)


def _without_kind(name: str, cls: type, doc: str | None = None) -> Any:
    """The model of a table whose class has no kind."""
    from pydantic import create_model

    columns: dict[str, Any] = {f.name: _field_type(cls, f) for f in fields(cls)}
    return create_model(name, __config__=CLOSED, __doc__=doc, **columns)


def _checked(kind: Any, descriptor: SIField | OptionalArrayField | CoordinateField) -> Any:
    """A type whose values the field of a problem can read: one validation then lists all wrong values of a case."""
    from pydantic import AfterValidator, BeforeValidator

    def check(value: Any) -> Any:
        if value is not None:
            try:
                descriptor.read(value)
            except PymdrError as error:
                raise ValueError(str(error)) from error
        return value

    # of tables, lists and texts only the field says which are wrong
    validator = BeforeValidator if isinstance(descriptor, CoordinateField) else AfterValidator
    return Annotated[kind, validator(check)]


def _field_type(cls: type, f: Any) -> tuple[Any, Any]:
    """The pydantic type and default of one dataclass field."""
    from pydantic import Field

    descriptor = inspect.getattr_static(cls, f.name, None)
    number = Union[int, float, str]  # noqa: UP007  (a runtime value)
    if isinstance(descriptor, SidesField):
        note = f"{descriptor.description}; texts with units or numbers in {descriptor.unit}"
        return _checked(number | list[number], descriptor), Field(..., description=note)
    if isinstance(descriptor, HeightsField):
        note = f"{descriptor.description}; rows of numbers in {descriptor.unit}, one row per x"
        return list[list[number]], Field(..., description=note)
    if isinstance(descriptor, ArrayField):
        note = f"{descriptor.description}; texts with units or numbers in {descriptor.unit}"
        return _checked(list[number], descriptor), Field(..., description=note)
    if isinstance(descriptor, OptionalPlaneArrayField):
        note = f"{descriptor.description}; texts with units or numbers in {descriptor.unit}, or pairs (x, y) of them"
        return _checked(list[number] | list[list[number]] | None, descriptor), Field(None, description=note)
    if isinstance(descriptor, WavesField):
        note = (
            f"{descriptor.description}; one for each wave, texts with units or numbers in {descriptor.unit}"
        )
        return _checked(number | list[number], descriptor), Field([], description=note)
    if isinstance(descriptor, CoordinateField):
        kinds: Any = _checked(str | list[str] | dict[str, float], descriptor)
        text = f"{descriptor.description}: a body, a pair (first minus second), or a table of factors"
        return kinds, Field(... if descriptor.needed else [], description=text)
    if isinstance(descriptor, OptionalArrayField):
        note = f"{descriptor.description}; texts with units or numbers in {descriptor.unit}"
        return _checked(list[number] | None, descriptor), Field(None, description=note)
    if isinstance(descriptor, OptionalPlaneField):
        note = f"{descriptor.description}; text with unit, or number in {descriptor.unit}, or a pair (x, y) of them"
        return _checked(number | list[number] | None, descriptor), Field(None, description=note)
    if isinstance(descriptor, SIField):
        unit = f"text with unit, or number in {descriptor.unit}" if descriptor.unit else "number"
        note = "; ".join(part for part in (descriptor.description, unit, descriptor.limits) if part)
        if isinstance(descriptor, OptionalSIField):
            return _checked(number | None, descriptor), Field(None, description=note)
        return _checked(number, descriptor), Field(
            ... if descriptor.default is None else descriptor.default, description=note
        )
    if f.name == "name":
        return str, Field(
            ... if f.default is MISSING else f.default, description="of this part", min_length=1
        )
    if f.name == "parts":
        return _list_of(_union("part")), Field(..., description="profiles to be added", min_length=1)
    if cls is Worn and f.name == "original":
        return _union("original"), Field(..., description="profile before wear")
    if f.name == "interpolation":
        text = "interpolation; by default a smoothing spline if there is a scatter, else a cubic spline"
        return _union("interpolation") | None, Field(None, description=text)
    if f.name == "layers":
        return _list_of(_without_kind("layer", Layer, "One layer of a body.")), Field(
            ..., description="from the surface downward", min_length=1
        )
    if f.name == "material":
        return _union("solid"), Field(..., description="isotropic, elastic or viscoelastic")
    if cls is Layered and f.name == "base":
        return _union("solid"), Field({"kind": "rigid"}, description="base of the layers; rigid unless given")
    if f.name == "bond":
        text = "between the lowest layer and the base; a frictionless layer slides without lifting off"
        return Literal[BONDS], Field(f.default, description=text)
    if f.name == "shear":
        return _union("rheology") | None, Field(None, description="relaxation in shear; or give young")
    if f.name == "sides":
        return int, Field(..., description="number of faces", ge=3, le=MOST_SIDES, strict=True)
    if f.name == "seed":
        return int, Field(f.default, description="seed of the random phases", ge=0, strict=True)
    if isinstance(f.default, bool) and "description" in f.metadata:
        return bool, Field(f.default, description=f.metadata["description"], strict=True)
    if f.name in ("steps", "cycles"):
        text = "number of rows" if f.name == "steps" else "number of cycles"
        kind = int if isinstance(f.default, int) else int | None
        return kind, Field(f.default, description=text, ge=1, strict=True)
    return Any, Field(... if f.default is MISSING else f.default)
