"""Profiles given by a callable, and the polynomials that replace them in files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import SIField, with_named_callables, within_range, without_named
from pymdr.units import FloatArray, HasUnits, metres, to_si_array

ArrayFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


@dataclass(frozen=True, eq=False)
class Function(Profile):
    """
    Any profile given as a callable f(r), its derivative f'(r), or both.

    Parameters
    ----------
    f : callable, optional
        Gap in m as a function of arrays. An offset f(0) is removed when the profile is mapped.
    breakpoints : array_like or quantity
        Radii in m, above 0, at which f' jumps or is not smooth. A breakpoint within 1e-3 of a kink is moved to it; steps
        of f are refused, there and on the axis.
    derivative : callable, optional
        f'(r) as a function of arrays. With it the map is exact to 1e-13, with f alone to 1e-12.
    max_radius : quantity
        Largest radius in m at which the callables may be evaluated.

    Raises
    ------
    ProblemError
        If neither callable is given, or a breakpoint is not above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> bowl = mdr.Function(lambda r: r**4, derivative=lambda r: 4 * r**3)
    >>> float(bowl.gap_slope(0.5))
    0.5
    """

    f: ArrayFunction | None = None
    breakpoints: tuple[float, ...] = ()
    derivative: ArrayFunction | None = None
    max_radius: SIField = SIField("m", above=0.0, default=math.inf)

    def __post_init__(self) -> None:
        if self.f is None and self.derivative is None:
            raise ProblemError(
                "neither f nor derivative is given; give one or both, for example Function(lambda r: r**4)"
            )
        for name in ("f", "derivative"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise ProblemError(f"{name} = {given!r}: a callable of the radius is needed")
        radii = np.atleast_1d(to_si_array(self.breakpoints, "m", name="breakpoints"))
        if np.any(radii <= 0.0):
            raise ProblemError(f"breakpoints = {radii.tolist()}: every radius must be above 0 m")
        if radii.size:
            for radius in (radii.min(), radii.max()):
                within_range(radius, "m", "breakpoints", size=True)
        object.__setattr__(self, "breakpoints", tuple(np.unique(radii).tolist()))

    def __getstate__(self) -> dict[str, Any]:
        return with_named_callables(self, "f", "derivative")

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(without_named(state))

    @property
    def offset(self) -> float:
        """The offset f(0) in m that is removed."""
        if self.f is None:
            return 0.0
        offset = float(call(self.f, np.zeros(1), "f")[0])
        if not math.isfinite(offset):
            raise ProblemError(
                f"f returns {offset} at r = 0, where a profile must be finite; return its limit there, "
                "for example with numpy.where"
            )
        return offset

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) - f(0) in m; nan beyond `max_radius`."""
        if self.f is None:
            raise ProblemError("the gap needs f, but only the derivative was given; give f too")
        return np.asarray(self._within(self.f, r, "f") - self.offset)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r); nan beyond `max_radius`."""
        if self.derivative is None:
            raise ProblemError(
                "the slope of the gap needs derivative, but only f was given; give derivative too"
            )
        return self._within(self.derivative, r, "derivative")

    def _within(self, function: ArrayFunction, r: ArrayLike, name: str) -> FloatArray:
        r = np.asarray(r, dtype=float)
        if math.isinf(self.max_radius):
            return call(function, r, name)
        # a computed end may exceed max_radius by rounding
        inside = r <= self.max_radius * (1.0 + 1e-12)
        values = np.full(r.shape, math.nan)
        values[inside] = call(function, np.minimum(r[inside], self.max_radius), name)
        undefined = inside & (r > 0.0) & np.isnan(values)
        if undefined.any():
            raise ProblemError(
                f"{name}(r) returns nan at r = {metres(float(r[undefined].min()))}, inside its max_radius of "
                f"{metres(self.max_radius)}; give the max_radius up to which it is defined"
            )
        return values


def call(function: ArrayFunction, r: FloatArray, name: str = "f") -> FloatArray:
    """
    Evaluate a user's callable on an array of any shape.

    The callable gets a copy of the radii, at least two, and its values are copied, so that it may work in place and
    reuse buffers. Some radii are evaluated twice, in another array, to check that values depend on the radius only.

    Parameters
    ----------
    function : callable
        Function of one-dimensional arrays; it may return a single number for a constant.
    r : ndarray
        Radii in m.
    name : str
        "f" (in m) or "derivative", for messages and for values with a unit.

    Returns
    -------
    ndarray
        Values of the shape of `r`; nan where the callable is not defined.

    Raises
    ------
    ProblemError
        If the callable fails, does not accept arrays, does not return one real number for each radius, or returns
        other values when evaluated again.

    Examples
    --------
    >>> call(lambda r: 2 * r, np.ones((1, 2))).tolist()
    [[2.0, 2.0]]
    """
    flat = np.array(np.ravel(r), dtype=float)
    if flat.size == 0:
        return np.empty(np.shape(r))
    radii = flat if flat.size > 1 else np.repeat(flat, 2)
    values = _evaluated(function, radii, name)
    # at another place in an array of another length
    again = np.array([2 * radii.size // 3, radii.size // 3])
    if not np.array_equal(_evaluated(function, radii[again], name), values[again], equal_nan=True):
        _refuse_state(function, radii, values, again, name)
    return values[: flat.size].reshape(np.shape(r))


def precision(function: ArrayFunction, radius: float) -> float:
    """
    Relative rounding of the floats that a callable returns at a radius in m.

    Examples
    --------
    >>> bool(precision(lambda r: r.astype(np.float32), 1.0) == np.finfo(np.float32).eps)
    True
    """
    with np.errstate(all="ignore"):
        kind = getattr(function(np.full(2, radius)), "dtype", np.dtype(float))
    single = isinstance(kind, np.dtype) and kind.kind == "f" and kind.itemsize < np.dtype(float).itemsize
    return float(np.finfo(kind if single else float).eps)


def _evaluated(function: ArrayFunction, r: FloatArray, name: str) -> FloatArray:
    """Values of a callable at one-dimensional radii, as a new array of floats of the same shape."""
    where = f"{name}(r){_title(function)}"
    if type(function) is np.vectorize and function.otypes is None and function.signature is None:
        # without otypes the first value sets the type: an int 0 would truncate all others
        function = np.vectorize(
            function.pyfunc, otypes=[object], excluded=function.excluded, cache=function.cache
        )
    try:
        with np.errstate(all="ignore"):
            raw = function(r.copy())
    except Exception as error:
        if _takes_scalars(function, r):
            raise ProblemError(
                f"{where} does not accept arrays ({error_text(error)}); write it with NumPy functions, "
                "or wrap it in numpy.vectorize"
            ) from error
        raise ProblemError(
            f"{where} fails for radii {_span(r)} ({error_text(error)}); return nan where it is not defined, "
            "or give its range with Function(..., max_radius=...)"
        ) from error
    return real_values(raw, r, where, "m" if name == "f" else "")


def real_values(raw: Any, r: FloatArray, where: str, unit: str, points: str = "radii") -> FloatArray:
    """The values of a callable as floats of the shape of its argument; others are refused."""
    if raw is None:
        raise ProblemError(f"{where} returns None; it must return values")
    try:
        if hasattr(raw, "dimensionality") and isinstance(raw, HasUnits):
            raw = raw.to(unit or "dimensionless").magnitude
        masked = np.ma.getmaskarray(raw) if isinstance(raw, np.ma.MaskedArray) else None
        array = np.asarray(raw)
        if array.dtype.kind == "O":
            for entry in np.unique([type(entry).__name__ for entry in array.flat]):
                if entry in ("str", "bytes", "NoneType"):
                    raise ProblemError(f"{where} returns {entry} among its values; all must be real numbers")
            if any(isinstance(entry, complex | np.complexfloating) for entry in array.flat):
                raise ProblemError(f"{where} returns complex numbers; a profile is real")
        elif array.dtype.kind == "c":
            raise ProblemError(f"{where} returns complex numbers; a profile is real")
        elif array.dtype.kind not in "fiu" or (array.dtype.kind != "f" and array.size > 1):
            raise ProblemError(
                f"{where} returns an array of {array.dtype}, which rounds and overflows; return floats, "
                "0.0 instead of 0"
            )
        values = np.array(array, dtype=float)
    except ProblemError:
        raise
    except Exception as error:
        raise ProblemError(
            f"{where} returns {type(raw).__name__}, which is not an array of real numbers ({error_text(error)})"
        ) from error
    if masked is not None:
        values[masked] = math.nan
    if values.shape not in ((), (1,), r.shape):
        raise ProblemError(
            f"{where} returns an array of shape {values.shape} for {r.size} {points}; one value for each is needed"
        )
    return values if values.shape == r.shape else np.full(r.shape, values.item())


def _refuse_state(
    function: ArrayFunction, r: FloatArray, values: FloatArray, index: NDArray[np.intp], name: str
) -> None:
    """Refuse values that differ between calls by more than the rounding of arrays of other lengths."""
    where = f"{name}(r){_title(function)}"
    finite = np.abs(values[np.isfinite(values)])
    size = float(finite.max(initial=0.0))

    def differ(first: FloatArray, other: FloatArray, least: FloatArray | float) -> NDArray[np.bool_]:
        same_kind = np.isfinite(first) & np.isfinite(other)
        with np.errstate(invalid="ignore"):
            far = np.abs(first - other) > least
        return np.where(same_kind, far, ~((first == other) | (np.isnan(first) & np.isnan(other))))

    second = _evaluated(function, r, name)
    changed = np.flatnonzero(differ(values, second, 1e-9 * size))
    if changed.size:
        i = changed[0]
        raise ProblemError(
            f"{where} returns {values[i]:g} and then {second[i]:g} for the same radius, {metres(float(r[i]))}; a profile "
            "must not change between calls (remove random numbers and counters)"
        )
    alone = _evaluated(function, r[index], name)
    shifts = 1.0 + 1e-6 * np.linspace(-1.0, 1.0, 16)
    nearby = np.array([_evaluated(function, r[index] * shift, name) for shift in shifts])
    with np.errstate(invalid="ignore"):
        rounding = 16.0 * np.nan_to_num(np.ptp(nearby, axis=0))
    other = np.flatnonzero(differ(values[index], alone, np.maximum(1e-6 * np.abs(values[index]), rounding)))
    if other.size:
        i = int(index[other[0]])
        raise ProblemError(
            f"{where} returns {values[i]:g} at r = {metres(float(r[i]))} among {r.size} radii and {alone[other[0]]:g} among "
            "two; the value at a radius must not depend on the other radii (no sum, maximum or "
            "numpy.gradient over r)"
        )


def _takes_scalars(function: ArrayFunction, r: FloatArray) -> bool:
    """Whether a callable that fails on arrays works for single radii."""
    try:
        with np.errstate(all="ignore"):
            of_scalar: Any = function
            for radius in (r.min(), r.max(), r[-1]):
                float(of_scalar(float(radius)))
    except Exception:
        return False
    return True


def _title(function: ArrayFunction) -> str:
    title = getattr(function, "__name__", "")
    return f" ({title})" if title and title != "<lambda>" else ""


def error_text(error: Exception) -> str:
    """An exception as one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}".rstrip(": ")


def _span(r: FloatArray) -> str:
    low, high = metres(float(r.min())), metres(float(r.max()))
    return f"r = {low}" if low == high else f"from {low} to {high}"


@dataclass(frozen=True, eq=False)
class Interpolated(Profile):
    """
    A profile as polynomials, which replaces a :class:`Function` in saved results.

    On each panel f' = (t/high)^power sum_j c_j T_j(2 u - 1) with t = r - base and u = (t - low) / (high - low); below
    the first one f' = slope (r/radius)^exponent.

    Parameters
    ----------
    base, low, high : sequence of float
        Origin of every panel in m, and its ends as offsets from it.
    power : sequence of float
        Exponent on every panel.
    coefficients : sequence of sequences of float
        Chebyshev coefficients c_j of f' on every panel.
    tip : tuple of float
        radius in m, slope and exponent of f' below the first panel.
    kinks : sequence of float
        Radii in m at which f' is not smooth.

    Examples
    --------
    >>> cone = Interpolated((0.0,), (0.5,), (1.0,), (0.0,), ((2.0,),), (0.5, 2.0, 0.0))
    >>> round(float(cone.gap(0.75)), 14)
    1.5
    """

    base: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    power: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    tip: tuple[float, float, float]
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("base", "low", "high", "power", "tip", "kinks"):
            object.__setattr__(self, name, tuple(float(value) for value in getattr(self, name)))
        object.__setattr__(self, "coefficients", tuple(tuple(map(float, c)) for c in self.coefficients))
        sizes = {len(getattr(self, name)) for name in ("base", "low", "high", "power", "coefficients")}
        ends = np.add(self.base, self.high)
        if len(sizes) != 1 or len(self.tip) != 3 or not ends.size or np.any(np.diff(ends) <= 0.0):
            raise ProblemError("panels must rise, with base, low, high, power and coefficients for each")

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The kinks."""
        return self.kinks

    @property
    def max_radius(self) -> float:
        """The end of the last panel."""
        return self.base[-1] + self.high[-1]

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r); nan beyond `max_radius`."""
        r = np.asarray(r, dtype=float)
        answer = np.full(r.shape, math.nan)
        panel = self._panel_of(r)
        known = r <= self.max_radius
        below = known & (panel < 0)
        answer[below] = self._tip_slope(r[below])
        above = known & (panel >= 0)
        on = panel[above]
        answer[above] = self._panel_slope(r[above] - self._edges.base[on], on)
        return answer

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m by Gauss-Legendre on each panel; nan beyond `max_radius`."""
        r = np.asarray(r, dtype=float)
        radius, slope, exponent = self.tip
        inner = np.minimum(r, radius)
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            answer = np.asarray(slope * radius / (exponent + 1.0) * (inner / radius) ** (exponent + 1.0))
        panel = self._panel_of(r)
        above = panel >= 0
        on = panel[above]
        width = np.minimum(r[above] - self._edges.base[on], self._edges.high[on]) - self._edges.low[on]
        answer[above] += self._risen[on] + self._rise(on, width)
        return np.asarray(np.where(r <= self.max_radius, answer, math.nan))

    @cached_property
    def _edges(self) -> _Edges:
        return _Edges(np.array(self.base), np.array(self.low), np.array(self.high), np.array(self.power))

    @cached_property
    def _columns(self) -> FloatArray:
        """The coefficients of every panel in a column, shape (terms, panels)."""
        columns = np.zeros((max(map(len, self.coefficients)), len(self.coefficients)))
        for i, series in enumerate(self.coefficients):
            columns[: len(series), i] = series
        return columns

    @cached_property
    def _risen(self) -> FloatArray:
        """Rise of f from the first panel to the start of every panel."""
        rises = self._rise(np.arange(len(self.base)), self._edges.high - self._edges.low)
        return np.concatenate([[0.0], np.cumsum(rises)[:-1]])

    def _panel_of(self, r: FloatArray) -> NDArray[np.intp]:
        return np.asarray(np.searchsorted(self._edges.base + self._edges.low, r, side="right") - 1)

    def _rise(self, panel: NDArray[np.intp], width: FloatArray) -> FloatArray:
        """The integral of f' over widths from the beginning of panels."""
        nodes, weights = _rule()
        slopes = self._panel_slope(self._edges.low[panel, None] + width[:, None] * nodes, panel[:, None])
        return np.asarray(width * (slopes @ weights))

    def _tip_slope(self, r: FloatArray) -> FloatArray:
        radius, slope, exponent = self.tip
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            return np.asarray(slope * (r / radius) ** exponent)

    def _panel_slope(self, t: FloatArray, panel: NDArray[np.intp]) -> FloatArray:
        low, high, power = self._edges.low[panel], self._edges.high[panel], self._edges.power[panel]
        u = ((t - low) / (high - low)).clip(0.0, 1.0)
        values = np.polynomial.chebyshev.chebval(2.0 * u - 1.0, self._columns[:, panel], tensor=False)
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            return np.asarray(np.where(power == 0.0, values, values * (t / high) ** power))


class _Edges(NamedTuple):
    base: FloatArray
    low: FloatArray
    high: FloatArray
    power: FloatArray


@lru_cache(maxsize=1)
def _rule() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss and Legendre on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    return (nodes + 1.0) / 2.0, weights / 2.0
