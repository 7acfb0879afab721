"""Units: text, pint quantities and plain numbers become SI floats here and nowhere else.

The number in a text is read by a strict grammar and only the unit by pint, so that ``"1,5 mm"`` is refused
instead of becoming 15 mm, and ``"9**9**9 m"`` cannot hang.
"""

from __future__ import annotations

import math
import re
import sys
import threading
from collections.abc import Sequence
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
    """The protocol of pint quantities: a magnitude and a conversion."""

    @property
    def magnitude(self) -> Any:
        """The number without its unit."""

    def to(self, *units: Any) -> Any:
        """The same quantity in other units."""


QuantityLike: TypeAlias = float | str | HasUnits
ArrayQuantityLike: TypeAlias = ArrayLike | HasUnits

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_FACTOR = r"[A-Za-zµμΩΩ°Å%]+(?:[0-9]?(?:(?:\^|\*\*)-?[0-9](?:\.5)?)?|⁻?[¹²³⁴])"
_PRODUCT = rf"{_FACTOR}(?:\s*[*·]\s*{_FACTOR}|\s+{_FACTOR})*"
_UNIT = rf"{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s*/\s*\({_PRODUCT}\)|\s+{_FACTOR})*"
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
    "K": "293 K",
    "W/(m*K)": "50 W/(m K)",
    "ohm*m": "1.7e-8 ohm m",
    "m^2/s": "12 mm^2/s",
}


_POWERS = {
    "a": -18, "f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9,
}  # fmt: skip
_PREFIXABLE = {
    "m": 1, "m^2": 2, "N": 1, "Pa": 1, "J": 1, "s": 1, "N/m": 1, "J/m^2": 1, "Pa*m^0.5": 1, "m/s": 1,
    "W/K": 1, "ohm": 1, "V": 1, "A": 1, "W": 1,
}  # fmt: skip
"""The commonest units, and the power to which a prefix is raised in them."""

_COMMON = {
    (prefix + si_unit, si_unit): float(f"1e{exponent * power}")
    for si_unit, exponent in _PREFIXABLE.items()
    for prefix, power in _POWERS.items()
} | {("kg", "kg"): 1.0, ("g", "kg"): 1e-3, ("mg", "kg"): 1e-6}
"""Factors of these units, so that reading and writing them needs no registry of pint, which takes 0.3 s to build."""


_PINT_LOCK = threading.RLock()
"""pint builds its registry, and units with prefixes, at first use, and has no lock of its own."""


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    return pint.get_application_registry()  # type: ignore[no-any-return]


@lru_cache(maxsize=512)
def _factor(unit: str, si_unit: str) -> float:
    """Conversion factor from ``unit`` to ``si_unit``, to 15 digits."""
    if (unit, si_unit) in _COMMON:
        return _COMMON[unit, si_unit]
    if len(unit) > _LONGEST_TEXT or not _UNIT_TEXT.fullmatch(unit):
        raise UnitError(f"cannot read {unit!r} as a unit; write products and powers such as 'mJ/m^2'")
    with _PINT_LOCK:
        return _factor_of(unit, si_unit)


def _factor_of(unit: str, si_unit: str) -> float:
    import pint

    registry = _registry()
    try:
        parsed = registry.parse_units(unit.replace("·", "*"))
        factor = registry.Quantity(1.0, parsed).to(si_unit).magnitude
        if si_unit == "K":
            factor -= registry.Quantity(0.0, parsed).to(si_unit).magnitude
    except pint.UndefinedUnitError as error:
        raise UnitError(f"unknown unit {unit!r}; write a unit such as in {example_of(si_unit)!r}") from error
    except pint.DimensionalityError as error:
        raise UnitError(
            f"{unit!r} does not fit: a unit compatible with {si_unit or 'a plain number'!r} is needed, "
            f"for example {example_of(si_unit)!r}"
        ) from error
    except (pint.PintError, ValueError, TypeError, AttributeError, OverflowError) as error:
        raise UnitError(f"cannot read {unit!r} as a unit: {error}") from error
    if _angles(registry, unit) != _angles(registry, si_unit):
        raise UnitError(
            f"{unit!r} does not fit: "
            + (
                "an angle is needed"
                if _angles(registry, si_unit)
                else "it is an angle, which is not a plain number"
            )
            + f", for example {example_of(si_unit)!r}"
        )
    return float(f"{factor:.15g}")


@lru_cache(maxsize=32)
def _zero(unit: str, si_unit: str) -> float:
    """The zero of a unit in SI: 273.15 K for degC."""
    if si_unit != "K":
        return 0.0
    with _PINT_LOCK:
        registry = _registry()
        parsed = registry.parse_units(unit.replace("·", "*"))
        return float(f"{registry.Quantity(0.0, parsed).to(si_unit).magnitude:.15g}")


def _angles(registry: Any, unit: Any) -> float:
    """The exponent of the radian in a unit, which pint treats as dimensionless."""
    if isinstance(unit, str):
        unit = registry.parse_units(unit.replace("·", "*"))
    roots = registry.get_root_units(unit)[1]
    return float(dict(roots._units).get("radian", 0.0))


def shown(value: object) -> str:
    """A value for messages: on one line, cut after 80 characters."""
    try:
        plain = value.item() if isinstance(value, np.number) else value
        text = " ".join(repr(plain).split())
    except ValueError:  # an integer with more digits than Python prints
        return f"a {type(value).__name__} of thousands of digits"
    return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}..."


def example_of(si_unit: str) -> str:
    """A quantity as text with a usual unit, for messages."""
    return _EXAMPLES.get(si_unit, f"1 {si_unit}".strip())


def _scaled(number: Any, factor: float) -> Any:
    """``number * factor``, by division by a whole number if that is correctly rounded (5 um is 5e-6)."""
    whole = _inverse(factor)
    return number / whole if whole else number * factor


def _inverse(factor: float) -> float:
    """The whole number of which a factor is the inverse, such as 1e6 for micrometres; 0 if there is none."""
    whole = round(1.0 / factor) if 0.0 < factor < 1.0 else 0
    return float(whole) if abs(whole * factor - 1.0) < 4e-16 else 0.0


def to_si(value: QuantityLike, unit: str, *, name: str = "value") -> float:
    """
    Convert a text with a unit, a pint quantity or an SI number to an SI float.

    Parameters
    ----------
    value : float, str or pint.Quantity
        ``"5 mm"``, a pint quantity, or a plain number already in `unit`.
    unit : str
        The SI unit of the result; ``""`` for a plain number.
    name : str
        Name of the value, for messages.

    Returns
    -------
    float
        The value in `unit`, finite.

    Raises
    ------
    UnitError
        If the text is not a number with a compatible unit, or the value is not finite.

    Examples
    --------
    >>> to_si("5 um", "m")
    5e-06
    >>> to_si("1,5 mm", "m", name="radius")
    Traceback (most recent call last):
        ...
    pymdr.errors.UnitError: radius: cannot read '1,5 mm'; write a number with a decimal point and a unit, for example '5 mm'
    """
    if isinstance(value, float) and type(value) in (float, np.float64) and math.isfinite(value):
        return float(value)
    plain = _bare(value)
    foreign = _unit_of(plain, name)
    number: Any
    if isinstance(plain, str):
        number = _read_text(plain, unit, name)
    elif _is_pint(plain):
        number = _read_pint(plain, unit, name)
    else:
        number = _as_array(plain, name) if foreign is not None else plain
        if isinstance(number, bool) or not isinstance(number, int | float | np.number | np.ndarray):
            raise UnitError(
                f"{name}: {shown(value)} is not a quantity; give a number in {unit or 'no unit'} or a text "
                f"such as {example_of(unit)!r}"
            )
        if np.ndim(number) != 0 or np.asarray(number).dtype.kind not in "fiuO":
            raise UnitError(f"{name}: one real number is needed, not {shown(value)}")
    if np.ndim(number) != 0:
        raise UnitError(f"{name}: one number is needed, not {shown(value)}")
    if np.ma.is_masked(number):
        raise UnitError(f"{name}: the number is masked; give a known one")
    try:
        number = float(number)
    except (OverflowError, TypeError, ValueError) as error:
        raise UnitError(f"{name}: {shown(value)[:40]} is outside the range of floats: {error}") from error
    if foreign:
        number = _converted(number, foreign, unit, name)
    if not math.isfinite(number):
        raise UnitError(f"{name}: {shown(value)} is not finite; a finite number is needed")
    return float(number)


def _bare(value: Any) -> Any:
    """The content of a value without shape, which NumPy and xarray wrap in arrays."""
    data = getattr(value, "data", None) if type(value).__module__.startswith("xarray.") else None
    if data is not None and _is_pint(data):
        return data
    if type(value) is np.ndarray and value.ndim == 0 and value.dtype.kind in "USObmM":
        return value.item()
    if isinstance(value, np.timedelta64 | np.datetime64):
        return value.item()
    return value


_IN_NAME = re.compile(r".*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*")


def _unit_of(values: Any, name: str) -> str | None:
    """
    The unit of an array of another package: "" for dimensionless, None if not given.

    xarray and pandas keep it in ``attrs``, pandas also in brackets after the name of a column; astropy and unyt have
    attributes. Pint columns of pandas are read elsewhere.
    """
    if _is_pint(values) or isinstance(values, str | bytes | int | float | list | tuple | dict):
        return None
    attrs = getattr(values, "attrs", None)
    if isinstance(attrs, dict):
        given = attrs.get("units", attrs.get("unit"))
        label = getattr(values, "name", None)
        if given is None and isinstance(label, str) and (match := _IN_NAME.fullmatch(label)):
            given = match[1]
        return "" if given is None else _as_text(given, name)
    if isinstance(values, np.ndarray) and type(values) is not np.ndarray:
        given = getattr(values, "unit", getattr(values, "units", None))
        return None if given is None else _as_text(given, name)
    return None


def _as_text(unit: object, name: str) -> str:
    text = str(unit).strip()
    return "" if text in ("", "1", "dimensionless") else text


def _converted(values: Any, given: str, unit: str, name: str) -> Any:
    """Numbers with a unit of their own, in SI."""
    try:
        return _scaled(values, _factor(given, unit)) + _zero(given, unit)
    except UnitError as error:
        raise UnitError(f"{name}: {error} (the unit of the array)") from error


def _read_text(text: str, unit: str, name: str) -> float:
    match = _TEXT.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        raise UnitError(
            f"{name}: cannot read {text[:_LONGEST_TEXT]!r}; write a number with a decimal point and a unit, "
            f"for example {example_of(unit)!r}"
        )
    number, given = match.groups()
    if given is None and unit:
        raise UnitError(
            f"{name}: {text!r} has no unit; write for example {example_of(unit)!r}, or in Python and case files a number without quotes, in {unit}"
        )
    try:
        return float(_scaled(float(number), _factor(given, unit)) + _zero(given, unit) if given else number)
    except UnitError as error:
        raise UnitError(f"{name}: {error} (in {text!r})") from error


def _is_pint(value: object) -> bool:
    return hasattr(value, "dimensionality") and "pint" in sys.modules and isinstance(value, HasUnits)


def _read_pint(value: Any, unit: str, name: str) -> Any:
    import pint

    with _PINT_LOCK:
        try:
            if _angles(value._REGISTRY, value.units) != _angles(value._REGISTRY, unit):
                raise UnitError(
                    f"{name}: {shown(value)} does not fit; give for example {example_of(unit)!r}"
                    + (" (an angle is not a plain number)" if not unit else "")
                )
            return value.to(unit or "dimensionless").magnitude
        except pint.DimensionalityError as error:
            raise UnitError(f"{name}: {value} does not fit; give for example {example_of(unit)!r}") from error


def to_si_array(
    values: ArrayQuantityLike, unit: str, *, name: str = "values", missing: bool = False
) -> FloatArray:
    """
    Convert an array, a sequence of texts or numbers, or a pint array to SI floats.

    Parameters
    ----------
    values : array_like, sequence of str, or pint.Quantity
        Plain numbers are already in `unit`.
    unit : str
        The SI unit of the result.
    name : str
        Name of the values, for messages.
    missing : bool
        Whether entries may be missing (nan or masked), returned as nan.

    Returns
    -------
    ndarray of float
        A new read-only array of the shape of `values`.

    Raises
    ------
    UnitError
        If an entry is not a finite number with a compatible unit.

    Examples
    --------
    >>> to_si_array(["1 mm", 0.5], "m").tolist()
    [0.001, 0.5]
    """
    plain = _bare(values)
    plain = getattr(getattr(plain, "array", None), "quantity", plain)  # a column of pint in pandas
    foreign = _unit_of(plain, name)
    if _is_pint(plain):
        plain = _read_pint(plain, unit, name)
    if isinstance(plain, np.ma.MaskedArray) and missing:
        plain = np.ma.filled(plain.astype(float), np.nan)
    elif isinstance(plain, np.ma.MaskedArray) and bool(np.any(np.ma.getmaskarray(plain))):
        raise UnitError(f"{name}: some entries are masked; leave them out or fill them")
    if foreign is not None or (plain is not values and not isinstance(plain, str)):
        plain = _as_array(plain, name)
    if isinstance(plain, str):
        array = np.array(to_si(plain, unit, name=name))
    elif isinstance(plain, np.ndarray) and plain.dtype.kind in "fiu":
        array = np.array(plain, dtype=float)
    elif isinstance(plain, list | tuple) and plain and set(map(type, plain)) <= {int, float}:
        array = _of_numbers(plain, name)
    else:
        array = _from_sequence(plain, unit, name)
    if foreign:
        array = np.asarray(_converted(array, foreign, unit, name))
    allowed = np.isfinite(array) | (missing & np.isnan(array))
    if not np.all(allowed):
        where = ", ".join(map(str, np.argwhere(~np.atleast_1d(allowed))[0].tolist()))
        raise UnitError(f"{name}[{where}] is not finite; every entry must be a finite number")
    array = np.asarray(array + 0.0)  # no negative zeros
    array.flags.writeable = False
    return array


def _as_array(values: Any, name: str) -> np.ndarray:
    try:
        return np.asarray(values)
    except (TypeError, ValueError) as error:  # an xarray dataset is not an array
        raise UnitError(
            f"{name}: a {type(values).__name__} is not an array of numbers; give one of its columns"
        ) from error


def _of_numbers(values: Sequence[float], name: str) -> FloatArray:
    try:
        array = np.array(values, dtype=float)
    except OverflowError as error:
        raise UnitError(f"{name}: an entry is outside the range of floats; check its unit") from error
    if not np.all(np.isfinite(array)):
        i = int(np.argmin(np.isfinite(array)))
        raise UnitError(f"{name}[{i}]: {values[i]} is not finite; a finite number is needed")
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
        The given and the requested unit.

    Returns
    -------
    float or array_like
        In `unit`.

    Raises
    ------
    UnitError
        If the units are incompatible.

    Examples
    --------
    >>> from_si(5e-6, "m", "um")
    5.0
    """
    if not unit and si_unit:
        raise UnitError(
            f"a unit compatible with {si_unit!r} is needed, for example in {example_of(si_unit)!r}"
        )
    factor = _factor(unit, si_unit) if unit else 1.0
    if unit and _zero(unit, si_unit):
        raise UnitError(
            f"{unit!r} does not start at 0 K, so temperature differences would be ambiguous; use 'K'"
        )
    numbers = np.asarray(values) if isinstance(values, list | tuple) else values
    whole = _inverse(factor)
    return numbers * whole if whole else numbers / factor


_PREFIXES = ("a", "f", "p", "n", "µ", "m", "", "k", "M", "G")
_UNITY = _PREFIXES.index("")
_SCALED: dict[str, tuple[int, str, str]] = {
    "m": (1, "f", "k"),
    "m^2": (2, "n", ""),
    "m^3": (3, "n", ""),
    "N": (1, "a", "G"),
    "Pa": (1, "µ", "G"),
    "J": (1, "a", "G"),
    "s": (1, "f", ""),
    "m/s": (1, "n", ""),
    "N/m": (1, "f", "G"),
    "J/m^2": (1, "n", "M"),
    "Pa*m^0.5": (1, "µ", "G"),
    "W/K": (1, "f", "G"),
    "ohm": (1, "f", "G"),
    "V": (1, "n", "k"),
    "A": (1, "f", "k"),
    "W": (1, "f", "G"),
    "rad": (1, "n", ""),
    "N*m": (1, "a", "G"),
    "N*m/rad": (1, "a", "G"),
}
"""Units with prefixes: their power in the prefixed unit, and the smallest and largest usual prefix."""


def in_good_units(value: float, unit: str) -> tuple[float, str]:
    """
    A value with a readable SI prefix; other units are unchanged.

    Examples
    --------
    >>> in_good_units(2e-6, "m")
    (2.0, 'µm')
    >>> in_good_units(2e-8, "m^2")
    (0.02, 'mm^2')
    """
    if unit not in _SCALED or value == 0.0 or not math.isfinite(value):
        return value, unit
    power, smallest, largest = _SCALED[unit]
    index = _UNITY + math.floor(math.log10(abs(value)) / (3.0 * power) + _offset(power))
    index = min(max(index, _PREFIXES.index(smallest)), _PREFIXES.index(largest))
    prefixed = f"{_PREFIXES[index]}{unit}"
    return float(from_si(value, unit, prefixed)), prefixed


def good_unit(values: FloatArray, unit: str) -> str:
    """
    The prefixed unit for the largest finite value.

    Examples
    --------
    >>> good_unit(np.array([2e-7, 5e-6]), "m")
    'µm'
    """
    finite = np.abs(values[np.isfinite(values)])
    return in_good_units(float(finite.max()) if finite.size else 0.0, unit)[1]


def _offset(power: int) -> float:
    """Added to the order of magnitude: rounding and, for areas, the two decades written as 0.01 mm^2."""
    return 1e-12 if power == 1 else 1.0 / 3.0 + 1e-12


def written(value: float, unit: str, digits: int = 4) -> str:
    """
    A value as text with a readable prefix.

    Examples
    --------
    >>> written(1.28e-6, "m")
    '1.28 µm'
    >>> written(0.99999e-3, "m")
    '1 mm'
    """
    if math.isnan(value):
        return "-"
    rounded = float(f"{value:.{digits}g}") + 0.0  # removes -0
    number, prefixed = in_good_units(rounded, unit)
    return f"{number:.{digits}g} {prefixed}".strip()


_ROUNDING = 4e-15
_NOTHING = 1e-6
"""Smallest value shown, in the unit with its smallest prefix."""


def without_rounding(value: float, values: ArrayLike, unit: str) -> float:
    """
    A value, or 0 if it is only rounding of the largest of `values` or below the smallest readable unit.

    Examples
    --------
    >>> without_rounding(2e-22, [1e-6, 2e-22], "m")
    0.0
    >>> without_rounding(2e-20, [1e-6, 2e-20], "m")
    2e-20
    >>> without_rounding(2e-22, [2e-22], "m")
    0.0
    """
    largest = float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
    least = 0.0
    if unit in _SCALED:
        power, smallest, _ = _SCALED[unit]
        least = _NOTHING * 1000.0 ** (power * (_PREFIXES.index(smallest) - _UNITY))
    return 0.0 if abs(value) <= max(_ROUNDING * largest, least) else value


def metres(value: float) -> str:
    """A length for messages, with six digits."""
    return written(value, "m", 6)


def pascals(value: float) -> str:
    """A modulus for messages, with six digits."""
    return written(value, "Pa", 6)


def newtons(value: float) -> str:
    """A force for messages, with six digits."""
    return written(value, "N", 6)
