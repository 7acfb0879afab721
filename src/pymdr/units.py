"""The only door for units: text, pint quantities and plain numbers become SI floats here.

The number in a text is read by a strict grammar and only the unit by pint, so that
``"1,5 mm"`` is refused instead of becoming 15 mm and ``"9**9**9 m"`` cannot hang.
"""

from __future__ import annotations

import math
import re
import sys
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import UnitError

if TYPE_CHECKING:
    import pint

FloatArray: TypeAlias = NDArray[np.float64]


@runtime_checkable
class HasUnits(Protocol):
    """What pint quantities offer: a magnitude and a conversion."""

    @property
    def magnitude(self) -> Any:
        """The number without its unit."""

    def to(self, *units: Any) -> Any:
        """The same quantity in other units."""


QuantityLike: TypeAlias = float | str | HasUnits
ArrayQuantityLike: TypeAlias = ArrayLike | HasUnits

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_FACTOR = r"[A-Za-zµμΩΩ°Å%]+[0-9]?(?:(?:\^|\*\*)-?[0-9])?"
_UNIT = rf"{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*"
_TEXT = re.compile(rf"\s*({_NUMBER})\s*({_UNIT})?\s*")
_UNIT_TEXT = re.compile(rf"\s*{_UNIT}\s*")
_LONGEST_TEXT = 80

_EXAMPLES = {
    "m": "5 mm",
    "N": "50 N",
    "Pa": "210 GPa",
    "s": "10 ms",
    "rad": "70 deg",
    "J/m^2": "50 mJ/m^2",
    "N/m": "0.1 N/m",
    "1/m": "2 m^-1",
}


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    return pint.get_application_registry()  # type: ignore[no-any-return, no-untyped-call]


@lru_cache(maxsize=512)
def _factor(unit: str, si_unit: str) -> float:
    """The number that turns a value in ``unit`` into one in ``si_unit``, to 15 digits."""
    import pint

    if len(unit) > _LONGEST_TEXT or not _UNIT_TEXT.fullmatch(unit):
        raise UnitError(f"cannot read {unit!r} as a unit: write products and powers such as 'mJ/m^2'")
    registry = _registry()
    try:
        factor = registry.Quantity(1.0, registry.parse_units(unit.replace("·", "*"))).to(si_unit).magnitude
    except pint.UndefinedUnitError as error:
        raise UnitError(f"unknown unit {unit!r}: write a unit such as in {_example(si_unit)!r}") from error
    except pint.DimensionalityError as error:
        raise UnitError(
            f"{unit!r} does not fit: a unit of the kind of {si_unit or 'a plain number'!r} is needed, "
            f"for example {_example(si_unit)!r}"
        ) from error
    except (pint.PintError, ValueError, TypeError, AttributeError, OverflowError) as error:
        raise UnitError(f"cannot read {unit!r} as a unit: {error}") from error
    return float(f"{factor:.15g}")


def _example(si_unit: str) -> str:
    return _EXAMPLES.get(si_unit, f"1 {si_unit}".strip())


def _scaled(number: Any, factor: float) -> Any:
    """``number * factor``, dividing where that is the correctly rounded way (5 um is 5e-6)."""
    if factor < 1.0:
        return number / float(f"{1.0 / factor:.15g}")
    return number * factor


def to_si(value: QuantityLike, unit: str, *, name: str = "value") -> float:
    """
    Turn a text with a unit, a pint quantity or an SI number into an SI float.

    Parameters
    ----------
    value : float, str or pint.Quantity
        ``"5 mm"``, a pint quantity, or a plain number already in `unit`.
    unit : str
        The SI unit of the answer; ``""`` for a plain number.
    name : str
        What the value is, for error messages.

    Returns
    -------
    float
        The value in `unit`, finite.

    Raises
    ------
    UnitError
        If the text is not a number with a unit of the right kind, or the value is not finite.

    Examples
    --------
    >>> to_si("5 um", "m")
    5e-06
    >>> to_si("1,5 mm", "m", name="radius")
    Traceback (most recent call last):
        ...
    pymdr.errors.UnitError: radius: cannot read '1,5 mm': write a number with a decimal point and a unit, for example '5 mm'
    """
    if isinstance(value, str):
        number = _read_text(value, unit, name)
    elif _is_pint(value):
        number = _read_pint(value, unit, name)
    elif isinstance(value, bool) or not isinstance(value, int | float | np.number | np.ndarray):
        raise UnitError(
            f"{name}: {value!r} is not a quantity: give a number in {unit or 'no unit'} or a text "
            f"such as {_example(unit)!r}"
        )
    elif np.ndim(value) != 0 or np.iscomplexobj(value):
        raise UnitError(f"{name}: one real number is needed, not {value!r}")
    else:
        number = value
    if np.ndim(number) != 0:
        raise UnitError(f"{name}: one number is needed, not {value!r}")
    try:
        number = float(number)
    except (OverflowError, TypeError, ValueError) as error:
        raise UnitError(
            f"{name}: {str(value)[:40]} is not a number that a float can hold: {error}"
        ) from error
    if not math.isfinite(number):
        raise UnitError(f"{name}: {value!r} is not finite: a finite number is needed")
    return number


def _read_text(text: str, unit: str, name: str) -> float:
    match = _TEXT.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        raise UnitError(
            f"{name}: cannot read {text[:_LONGEST_TEXT]!r}: write a number with a decimal point and a unit, "
            f"for example {_example(unit)!r}"
        )
    number, given = match.groups()
    if given is None and unit:
        raise UnitError(
            f"{name}: {text!r} has no unit: write for example {_example(unit)!r}, or the plain number for {unit}"
        )
    try:
        return float(_scaled(float(number), _factor(given or "", unit) if given else 1.0))
    except UnitError as error:
        raise UnitError(f"{name}: {error} (in {text!r})") from error


def _is_pint(value: object) -> bool:
    return "pint" in sys.modules and isinstance(value, HasUnits) and hasattr(value, "dimensionality")


def _read_pint(value: Any, unit: str, name: str) -> Any:
    import pint

    try:
        return value.to(unit or "dimensionless").magnitude
    except pint.DimensionalityError as error:
        raise UnitError(f"{name}: {value} does not fit: give for example {_example(unit)!r}") from error


def to_si_array(values: ArrayQuantityLike, unit: str, *, name: str = "values") -> FloatArray:
    """
    Turn an array, a sequence of texts or numbers, or a pint array into SI floats.

    Parameters
    ----------
    values : array_like, sequence of str, or pint.Quantity
        Plain numbers are already in `unit`.
    unit : str
        The SI unit of the answer.
    name : str
        What the values are, for error messages.

    Returns
    -------
    ndarray of float
        A new read-only array of the shape of `values`.

    Raises
    ------
    UnitError
        If an entry is not a finite number of the right kind.

    Examples
    --------
    >>> to_si_array(["1 mm", 0.5], "m").tolist()
    [0.001, 0.5]
    """
    if isinstance(values, np.ma.MaskedArray) and bool(np.any(np.asarray(values.mask))):
        raise UnitError(f"{name}: some entries are masked: leave them out, or fill them")
    if _is_pint(values):
        array = np.array(_read_pint(values, unit, name), dtype=float)
    elif isinstance(values, str):
        array = np.array(to_si(values, unit, name=name))
    elif isinstance(values, np.ndarray) and values.dtype.kind in "fiu":
        array = values.astype(float)
    else:
        array = _from_sequence(values, unit, name)
    if not np.all(np.isfinite(array)):
        where = np.argwhere(~np.isfinite(np.atleast_1d(array)))[0].tolist()
        raise UnitError(f"{name}: entry {where} is not finite: every entry must be a finite number")
    array = np.asarray(array + 0.0)  # no negative zeros
    array.flags.writeable = False
    return array


def _from_sequence(values: Any, unit: str, name: str) -> FloatArray:
    try:
        entries = np.asarray(values, dtype=object)
        flat = [to_si(entry, unit, name=f"{name}[{i}]") for i, entry in enumerate(entries.ravel())]
    except ValueError as error:
        if isinstance(error, UnitError):
            raise
        raise UnitError(f"{name}: not an array of numbers: {error}") from error
    return np.array(flat, dtype=float).reshape(entries.shape)


def from_si(values: Any, si_unit: str, unit: str) -> Any:
    """
    Convert SI numbers or arrays to another unit.

    Parameters
    ----------
    values : float or array_like
        In `si_unit`.
    si_unit, unit : str
        The units before and after.

    Returns
    -------
    float or array_like
        In `unit`.

    Raises
    ------
    UnitError
        If the units are of different kinds.

    Examples
    --------
    >>> from_si(5e-6, "m", "um")
    5.0
    """
    if not unit and si_unit:
        raise UnitError(f"a unit of the kind of {si_unit!r} is needed, for example in {_example(si_unit)!r}")
    factor = _factor(unit, si_unit) if unit else 1.0
    numbers = np.asarray(values) if isinstance(values, list | tuple) else values
    if factor < 1.0:
        return numbers * float(f"{1.0 / factor:.15g}")
    return numbers / factor


_PREFIXES = ("f", "p", "n", "u", "m", "", "k", "M", "G")
_SCALED = ("m", "N", "Pa", "J", "s", "N/m")


def in_good_units(value: float, unit: str) -> tuple[float, str]:
    """
    A value with an SI prefix that makes it readable.

    Examples
    --------
    >>> in_good_units(2e-6, "m")
    (2.0, 'um')
    """
    if unit not in _SCALED or value == 0.0 or not math.isfinite(value):
        return value, unit
    exponent = math.floor(math.log10(abs(value)) / 3.0 + 1e-12)
    index = min(max(exponent + 5, 0), len(_PREFIXES) - 1)
    if unit in ("m", "s"):
        index = min(index, 5)
    prefixed = f"{_PREFIXES[index]}{unit}"
    return float(from_si(value, unit, prefixed)), prefixed


def written(value: float, unit: str, digits: int = 4) -> str:
    """
    A value in words, with the prefix that makes it readable.

    Examples
    --------
    >>> written(1.28e-6, "m")
    '1.28 um'
    """
    if math.isnan(value):
        return "-"
    number, prefixed = in_good_units(value, unit)
    return f"{number:.{digits}g} {prefixed}".strip()


def metres(value: float) -> str:
    """A length as messages give it, with six digits."""
    return written(value, "m", 6)


def newtons(value: float) -> str:
    """A force as messages give it, with six digits."""
    return written(value, "N", 6)
