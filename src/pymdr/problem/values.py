"""The base of all problem values: quantity fields, equality and hashing by content."""

from __future__ import annotations

import inspect
import math
import pickle
import re
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from dataclasses import Field, fields
from functools import partial
from html import escape
from typing import Any, ClassVar, overload

import numpy as np

from pymdr.errors import ProblemError, UnitError
from pymdr.problem.options import Checked, refuse_missing, refuse_unknown
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array, written


class Named:
    """A callable field of a value while it is pickled; a function that cannot be pickled gives a clear error."""

    def __init__(self, function: Callable[..., Any], name: str) -> None:
        self.function = function
        self.name = name

    def __deepcopy__(self, memo: dict[int, Any]) -> Named:
        return self

    def __reduce__(self) -> tuple[type[Named], tuple[Callable[..., Any], str]]:
        try:
            pickle.dumps(self.function)
        except (AttributeError, TypeError, pickle.PicklingError) as error:
            raise ProblemError(
                f"{self.name} = {shown(self.function)} cannot be pickled: functions are pickled by their name in a module. Define it "
                "with def at the top of a module, or give samples instead; results, impacts, laws and sweeps of it are saved with "
                "polynomials"
            ) from error
        return Named, (self.function, self.name)


def with_named_callables(value: Value, *names: str) -> dict[str, Any]:
    """The pickled state of a value with callable fields."""
    state = dict(value.__dict__)
    for name in names:
        if state[name] is not None:
            state[name] = Named(state[name], name)
    return state


def without_named(state: Mapping[str, Any]) -> dict[str, Any]:
    """The inverse of :func:`with_named_callables`."""
    return {key: part.function if isinstance(part, Named) else part for key, part in state.items()}


class _Signature:
    """The signature of ``__init__``, which that of the call of a class would hide."""

    def __get__(self, instance: object, owner: type) -> inspect.Signature:
        signature = inspect.signature(owner.__init__)  # type: ignore[misc]
        return signature.replace(parameters=list(signature.parameters.values())[1:])


_PARAMETERS = re.compile(r"\nParameters\n-+\n.*?(\n(?=\n\S)|\Z)", re.S)
"""The section of the parameters in a docstring, with its last line break."""
_RAISES = """
Raises
------
ProblemError
    If a value is outside its limits.
UnitError
    If a text is not a quantity of the right kind.
"""


class _Constructor(ABCMeta):
    """Constructors name unknown and missing arguments, and what is meant."""

    def __call__(cls, *args: Any, **keywords: Any) -> Any:
        try:
            return type.__call__(cls, *args, **keywords)
        except TypeError:
            refuse_unknown(cls.__name__, keywords, list(inspect.signature(cls).parameters))
            refuse_missing(cls.__name__, cls, args, keywords, partial(_unit, cls))
            raise


class Value(Checked, metaclass=_Constructor):
    """Base of the frozen problem dataclasses: compared and hashed by content.

    Subclasses are declared with ``@dataclass(frozen=True, eq=False)``.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    __signature__ = _Signature()

    def __init_subclass__(cls) -> None:
        """Check arguments of methods; document what quantity fields raise, in the help of classes that do not describe other errors."""
        super().__init_subclass__()
        text = inspect.cleandoc(cls.__dict__.get("__doc__") or "")
        entries = [entry for base in cls.__mro__ for entry in vars(base).values()]
        if "\nRaises\n" not in text and any(isinstance(entry, SIField) for entry in entries):
            cls.__doc__ = _PARAMETERS.sub(lambda section: section[0] + _RAISES, text, count=1)

    def _key(self) -> tuple[Any, ...]:
        return tuple((f.name, _content(getattr(self, f.name))) for f in fields(self))

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))

    def _repr_html_(self) -> str:
        """The fields as a table, for notebooks."""
        rows = ((f.name, getattr(self, f.name), _unit(type(self), f.name)) for f in fields(self))
        return values_html(type(self).__name__, rows)


def values_html(title: str, rows: Iterable[tuple[str, Any, str]]) -> str:
    """A table of names and values with their units under a title, without values that are None."""
    body = "".join(
        f"<tr><td>{escape(name)}</td><td>{_html(value, unit)}</td></tr>"
        for name, value, unit in rows
        if value is not None
    )
    return f"<div><b>{escape(title)}</b><table>{body}</table></div>"


def _unit(owner: type, name: str) -> str:
    return str(getattr(inspect.getattr_static(owner, name, None), "unit", ""))


def _html(value: Any, unit: str) -> str:
    if isinstance(value, Value):
        return value._repr_html_()
    if isinstance(value, tuple) and value and all(isinstance(part, Value) for part in value):
        return "".join(part._repr_html_() for part in value)
    if isinstance(value, np.ndarray):
        if np.all(np.isnan(value)):
            return "no values"
        return escape(
            f"{value.size} values from {written(float(np.nanmin(value)), unit, 6)} to {written(float(np.nanmax(value)), unit, 6)}"
        )
    if isinstance(value, float):
        return escape(written(value, unit, 6))
    return escape(str(value))


def _content(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return (value.shape, value.tobytes())
    return value


def _describe_limits(above: float, below: float, at_most: float, at_least: float) -> str:
    parts = []
    if above > -math.inf:
        parts.append(f"above {above:g}")
    if at_least > -math.inf:
        parts.append(f"at least {at_least:g}")
    if below < math.inf:
        parts.append(f"below {below:g}")
    if at_most < math.inf:
        parts.append(f"at most {at_most:g}")
    return " and ".join(parts)


LARGEST, _SMALLEST, NOTHING = 1e60, 1e-60, 1e-290
"""Outside the first two, products of a few values leave the range of double precision; values of a path below the third are 0."""


def within_range(values: Any, unit: str, name: str, *, size: bool = False, limited: bool = False) -> Any:
    """Refuse numbers whose products overflow; values below 1e-290 become 0 unless limited."""
    if type(values) is float and _SMALLEST <= abs(values) <= LARGEST:
        return values
    magnitude = np.abs(values)
    largest = float(np.max(magnitude, initial=0.0))
    if largest > LARGEST or (size and largest < _SMALLEST):
        limit = f"at most {LARGEST:g}" if largest > LARGEST else f"at least {_SMALLEST:g}"
        remedy = "; check the unit" if unit else ""
        raise ProblemError(
            f"{name} = {largest:.3g} {unit}".rstrip() + f": it must be {limit} {unit}".rstrip() + remedy
        )
    small = (magnitude < NOTHING) & (magnitude > 0.0)
    if limited or not np.any(small):
        return values
    cleared = np.where(small, 0.0, values)
    cleared.flags.writeable = False
    return cleared


def read_stiffness(value: QuantityLike) -> float:
    """A machine stiffness in N/m: 0 is a dead load, inf a rigid machine."""
    if (isinstance(value, float) and value == math.inf) or (
        isinstance(value, str) and value.strip() == "inf"
    ):
        return math.inf
    stiffness = to_si(value, "N/m", name="machine_stiffness")
    if stiffness < 0.0:
        raise ProblemError(f"machine_stiffness = {shown(value)}: it must be at least 0 N/m")
    return float(within_range(stiffness, "N/m", "machine_stiffness"))


class SIField:
    """A dataclass field that accepts a quantity in any form and reads as an SI float.

    Declared as ``radius: SIField = SIField("m", above=0)``. Limits are in SI units.
    """

    def __init__(
        self,
        unit: str,
        *,
        description: str = "",
        above: float = -math.inf,
        at_least: float = -math.inf,
        below: float = math.inf,
        at_most: float = math.inf,
        default: float | None = None,
        hint: str = "",
    ) -> None:
        self.unit = unit
        self.description = description
        self.above, self.at_least, self.below, self.at_most = above, at_least, below, at_most
        self.default = default
        self.hint = hint
        """An alternative, added to the message about a wrong unit."""
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> SIField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> float: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        if instance is None:
            if self.default is None:
                raise AttributeError(self.name)
            return self.default
        return instance.__dict__[self.name]

    def __set__(self, instance: object, value: QuantityLike) -> None:
        instance.__dict__[self.name] = self.read(value)

    @property
    def limits(self) -> str:
        """The limits as text, for messages and schemas."""
        limits = _describe_limits(self.above, self.below, self.at_most, self.at_least)
        return f"{limits} {self.unit}".strip() if limits else ""

    def read(self, value: QuantityLike) -> float:
        """Convert to SI and check the limits; the default is not checked."""
        if self.default is not None and isinstance(value, float) and value == self.default:
            return value
        try:
            number = to_si(value, self.unit, name=self.name)
        except UnitError as error:
            if not self.hint:
                raise
            raise UnitError(f"{error}; {self.hint}") from error
        if not (self.above < number < self.below and self.at_least <= number <= self.at_most):
            raise ProblemError(f"{self.name} = {shown(value)}: it must be {self.limits}")
        limited = max(self.above, self.at_least) > -math.inf
        name = self.name
        return float(within_range(number, self.unit, name, size=self.above == 0.0, limited=limited))


class OptionalSIField(SIField):
    """An optional quantity field; None if not given."""

    @overload  # type: ignore[override]
    def __get__(self, instance: None, owner: type) -> OptionalSIField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> float | None: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        return None if instance is None else instance.__dict__[self.name]

    def __set__(self, instance: object, value: QuantityLike | None) -> None:
        instance.__dict__[self.name] = None if value is None else self.read(value)


class OptionalPlaneField(OptionalSIField):
    """An optional quantity along one line, or a pair of its components along x and y as a read-only array (2,)."""

    def __set__(self, instance: object, value: Any) -> None:
        instance.__dict__[self.name] = None if value is None else self.read(value)

    def read(self, value: Any) -> Any:
        """Convert one value, or a pair of components, to SI."""
        if not isinstance(value, list | tuple) and np.ndim(getattr(value, "magnitude", value)) == 0:
            return super().read(value)
        name = self.name
        pair = to_si_array(value, self.unit, name=name)
        if pair.shape != (2,):
            size = " x ".join(map(str, pair.shape))
            raise ProblemError(
                f"{name} has {size} component{'' if size == '1' else 's'}; give one value, or a pair (x, y): the normal direction has "
                "its own channels"
            )
        return within_range(pair, self.unit, name)


class OptionalArrayField:
    """An optional field of a one-dimensional read-only SI array."""

    def __init__(self, unit: str, *, description: str = "") -> None:
        self.unit = unit
        self.description = description
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> OptionalArrayField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> FloatArray | None: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        return None if instance is None else instance.__dict__[self.name]

    def __set__(self, instance: object, values: ArrayQuantityLike | None) -> None:
        instance.__dict__[self.name] = None if values is None else self.read(values)

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only SI array of one dimension."""
        array = to_si_array(values, self.unit, name=self.name)
        if array.ndim != 1:
            raise ProblemError(f"{self.name}: a one-dimensional array is needed, not shape {array.shape}")
        return array


class OptionalPlaneArrayField(OptionalArrayField):
    """An optional read-only SI array with one value per row, or a pair of components along x and y per row."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only SI array of shape (n,) or (n, 2)."""
        array = to_si_array(values, self.unit, name=self.name)
        if array.ndim != 1 and array.shape[1:] != (2,):
            raise ProblemError(
                f"{self.name} has the shape {array.shape}; give one value per row, or a pair (x, y) per row: the normal "
                "direction has its own channels"
            )
        return array


class ArrayField(OptionalArrayField):
    """A required field of a one-dimensional read-only SI array."""

    @overload
    def __get__(self, instance: None, owner: type) -> ArrayField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> FloatArray: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        if instance is None:
            raise AttributeError(self.name)
        return instance.__dict__[self.name]

    def __set__(self, instance: object, values: ArrayQuantityLike) -> None:  # type: ignore[override]
        instance.__dict__[self.name] = self.read(values)


class SidesField(ArrayField):
    """A field of the sides of a rectangle, given as a pair or as one length for a square."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a pair of SI lengths."""
        name = self.name
        sides = np.atleast_1d(to_si_array(values, self.unit, name=name))
        if sides.shape not in ((1,), (2,)) or not np.all(sides > 0.0):
            raise ProblemError(
                f"{name} = {shown(values)}: give the side of a square or a pair of sides, above 0 {self.unit}"
            )
        within_range(sides.min(), self.unit, name, size=True)
        within_range(sides.max(), self.unit, name, size=True)
        pair = np.array([sides[0], sides[-1]])
        pair.flags.writeable = False
        return pair
