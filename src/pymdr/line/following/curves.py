"""Curves of equilibrium states under a control, independent of the law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import PathError
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

_Function = Callable[[FloatArray], FloatArray]


class _States(Protocol):
    """States of a curve."""

    @property
    def indentation(self) -> FloatArray:
        """The indentation in m."""

    @property
    def normal_force(self) -> FloatArray:
        """The normal force in N."""


class Equilibria(Protocol):
    """A curve of equilibrium states of a law with parameter s."""

    @property
    def start(self) -> float:
        """Parameter of the first touch."""

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters where the curve is not smooth."""

    @property
    def touch(self) -> float:
        """Indentation of the first touch in m."""

    def states(self, s: FloatArray) -> _States:
        """Return the states at s."""

    def slopes(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds and dF/ds."""

    def energies(self, s: FloatArray, indentation: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the elastic and the surface energy in J, at indentations in m where these are known better than by s."""


_STEP = 2.0**0.25
"""Ratio of trial parameters, small enough not to exceed the needed radius by much."""
_HALVINGS = 2, 8, *[32] * 62
"""Numbers of halved parameters that are compared at once."""


def _nothing(control: float) -> float:
    return 0.0


def _unloaded(control: float) -> float:
    return 0.0 if control == 0.0 else np.nan


@dataclass(frozen=True)
class Curve:
    """A folding curve under one control.

    Attributes
    ----------
    control, slope, energy : callable
        D(s), D'(s) and the potential T(s) of the state with its machine or load; functions of arrays.
    start, stop : float
        Range of s: the state of first touch and the end of the known curve.
    knots : tuple of float
        Values of s where D is not smooth.
    touch : float or None
        D at which a free body touches, not below D(start); default D(start).
    free_energy : callable
        The potential of the free body as a function of D.
    conjugate : callable, optional
        Y(s) with dT = Y dD along the curve, for the audit of the energy.

    Examples
    --------
    >>> s = np.linspace(0, 1, 5)
    >>> Curve(np.sin, np.cos, np.zeros_like, start=0.0, stop=1.0).touch is None
    True
    """

    control: _Function
    slope: _Function
    energy: _Function
    start: float
    stop: float
    knots: tuple[float, ...] = ()
    touch: float | None = None
    free_energy: Callable[[float], float] = _nothing
    conjugate: _Function | None = None


def under_control(machine_stiffness: float, depth: FloatArray, force: FloatArray) -> FloatArray:
    """Return D = d + F/k of states, or D' of their rates; d under k = ``inf``, F under k = 0.

    Parameters
    ----------
    machine_stiffness : float
        k [N/m].
    depth, force : ndarray
        d [m] and F [N], or their rates.

    Examples
    --------
    >>> [float(under_control(k, np.array(2.0), np.array(3.0))) for k in (0.0, 1.5, np.inf)]
    [3.0, 4.0, 2.0]
    """
    if np.isinf(machine_stiffness):
        return depth
    return force if machine_stiffness == 0.0 else depth + force / machine_stiffness


def under_machine(equilibria: Equilibria, stop: float, machine_stiffness: float = np.inf) -> Curve:
    """Return the curve of a law under a machine: D = d + F/k, T = U + F²/2k.

    Parameters
    ----------
    equilibria : Equilibria
        The states, from a law.
    stop : float
        Largest parameter followed; see `parameter_reaching`.
    machine_stiffness : float
        k [N/m]; ``inf`` is displacement control (D = d, T = U), 0 is force control (D = F, T = U - F d).

    Returns
    -------
    Curve
        D is a travel [m], or a force [N] under force control.

    Raises
    ------
    PathError
        For a negative or undefined stiffness.

    Notes
    -----
    Along equilibria dT = F dD (under force control dT = -d dF). Under force control a contact that is lost
    under tension falls without end: the potential of the free body, and so the energy of that jump, is NaN.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> spring = SimpleNamespace(start=0.0, knots=(), touch=0.0,
    ...     states=lambda s: SimpleNamespace(indentation=s, normal_force=2 * s),
    ...     slopes=lambda s: (np.ones_like(s), 2 + 0 * s), energies=lambda s: (s**2, 0 * s))
    >>> soft = under_machine(spring, 1.0, machine_stiffness=4.0)
    >>> float(soft.control(np.array(1.0))), float(soft.energy(np.array(1.0)))
    (1.5, 1.5)
    """
    k = float(machine_stiffness)
    if not k >= 0.0:
        raise PathError(f"machine stiffness must be 0 (force control) or more, not {machine_stiffness!r} N/m")
    by_force = k == 0.0

    def control(s: FloatArray) -> FloatArray:
        states = equilibria.states(s)
        return under_control(k, states.indentation, states.normal_force)

    def slope(s: FloatArray) -> FloatArray:
        return under_control(k, *equilibria.slopes(s))

    def energy(s: FloatArray) -> FloatArray:
        elastic, surface = equilibria.energies(s)
        states = equilibria.states(s)
        force = states.normal_force
        return elastic + surface + (-force * states.indentation if by_force else 0.5 * force * (force / k))

    def conjugate(s: FloatArray) -> FloatArray:
        states = equilibria.states(s)
        return -states.indentation if by_force else states.normal_force

    return Curve(
        control,
        slope,
        energy,
        equilibria.start,
        float(stop),
        equilibria.knots,
        0.0 if by_force else equilibria.touch,
        _unloaded if by_force else _nothing,
        conjugate,
    )


def sampled_curve(s: ArrayLike, control: ArrayLike, energy: ArrayLike, touch: float | None = None) -> Curve:
    """Return the piecewise linear curve through samples.

    Parameters
    ----------
    s, control, energy : array_like
        Rising parameters, D and T, of one length of at least 2.
    touch : float, optional
        As in `Curve`.

    Returns
    -------
    Curve
        Its folds are the samples where D turns.

    Raises
    ------
    PathError
        When the samples do not rise in s or are not finite.

    Examples
    --------
    >>> saw = sampled_curve([0, 1, 2, 3], [0, 2, 1, 4], [0, 1, 2, 3])
    >>> saw.control(np.array([0.5, 1.5])), saw.slope(np.array([0.5, 1.5]))
    (array([1. , 1.5]), array([ 2., -1.]))
    """
    x, D, T = (np.array(v, dtype=np.float64) for v in (s, control, energy))
    if x.ndim != 1 or x.size < 2 or not (x.shape == D.shape == T.shape) or not np.all(np.diff(x) > 0.0):
        raise PathError(
            "a curve needs at least 2 samples, the same number of every quantity, and an increasing parameter"
        )
    if not (np.all(np.isfinite(D)) and np.all(np.isfinite(T))):
        raise PathError("samples of a curve must be finite")
    rates = np.diff(D) / np.diff(x)

    def slope(at: FloatArray) -> FloatArray:
        return rates[np.clip(np.searchsorted(x, at, side="right") - 1, 0, rates.size - 1)]

    return Curve(
        lambda at: np.interp(at, x, D),
        slope,
        lambda at: np.interp(at, x, T),
        float(x[0]),
        float(x[-1]),
        tuple(x[1:-1].tolist()),
        touch,
    )


def parameter_reaching(
    control: _Function, top: float, *, at_least: float = 0.0, begin: float = 1.0, limit: float = np.inf
) -> float:
    """Return a small parameter s with D(s) >= top, by upward steps and bisection.

    Parameters
    ----------
    control : callable
        D(s), rising in the end.
    top : float
        The largest D of the path, above the touch.
    at_least : float
        A state of the path already known; the answer is not below it.
    begin : float
        Where the search begins without such a state.
    limit : float
        Largest parameter known; returned when D stays below `top`.

    Returns
    -------
    float
        s in the units of the curve.

    Raises
    ------
    PathError
        When D never comes above, or (without `at_least`) never falls below `top`.

    Examples
    --------
    >>> round(parameter_reaching(lambda s: s**2, 9.0), 12)
    3.0
    """

    def above(s: float) -> bool:
        return bool(control(np.array([s]))[0] >= top)

    high = at_least if at_least > 0.0 else min(limit, begin)
    for _ in range(2000):
        if above(high):
            break
        if high >= limit:
            return limit
        high = min(_STEP * high, limit)
    else:
        raise PathError(f"the curve never reaches the control value {top!r}; shorten the path")
    if high == at_least:
        return at_least
    low = max(high / _STEP, at_least)
    if at_least == 0.0:
        for count in _HALVINGS:
            lower = low * 0.5 ** np.arange(count, dtype=np.float64)
            below = np.flatnonzero(~(control(lower) >= top))
            if below.size:
                at = int(below[0])
                low, high = float(lower[at]), float(lower[at - 1]) if at else high
                break
            low, high = 0.5 * float(lower[-1]), float(lower[-1])
        else:
            raise PathError(f"the path ends at {top!r}, before the bodies touch; extend it")
    root = float(roots_of(lambda s: control(s) - top, np.array([low]), np.array([high]))[0])
    # the value may round differently in an array
    beyond = 1e-14
    while not above(root * (1.0 + beyond)):
        beyond *= 4.0
    return min(root * (1.0 + beyond), limit)
