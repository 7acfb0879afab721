"""Legs of a loading path, and their concatenation with ``>>``.

Targets are absolute positions in the channel's unit. The virgin state is never a row: a leg of n steps
gives n rows, the last of them at its target.
"""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from typing import Any

import numpy as np

from pymdr.errors import PathError
from pymdr.problem.values import OptionalArrayField, OptionalSIField, Value
from pymdr.units import QuantityLike

NORMAL_CHANNELS = ("indentation", "normal_force")


class LoadingPath(Value, ABC):
    """A history of prescribed channels; ``a >> b`` follows b after a."""

    def __rshift__(self, other: LoadingPath) -> History:
        if not isinstance(other, LoadingPath):
            return NotImplemented
        return History((*legs(self), *legs(other)))


def legs(path: LoadingPath) -> tuple[Leg, ...]:
    """The legs of a path in order."""
    if isinstance(path, History):
        return path.legs
    assert isinstance(path, Leg)
    return (path,)


class Leg(LoadingPath):
    """One piece of a path."""


def _check_steps(owner: str, steps: Any) -> None:
    if isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 1:
        raise PathError(f"{owner}.steps = {steps!r}: a whole number of at least 1 is needed")


@dataclass(frozen=True, eq=False)
class Ramp(Leg):
    """
    Move one or several channels to their targets in equal steps.

    Parameters
    ----------
    indentation : quantity, optional
        Target of the approach d in m.
    normal_force : quantity, optional
        Target of the normal force in N.
    steps : int
        Number of rows, at least 1.
    duration : quantity, optional
        Time in s that the leg takes, above 0.

    Raises
    ------
    PathError
        If no channel is named, or indentation and force are both prescribed, or `steps` is not a
        whole number of at least 1.

    Examples
    --------
    >>> Ramp(normal_force="50 N", steps=50).normal_force
    50.0
    """

    indentation: OptionalSIField = OptionalSIField("m", words="target of the indentation")
    normal_force: OptionalSIField = OptionalSIField("N", words="target of the normal force")
    steps: int = 1
    duration: OptionalSIField = OptionalSIField("s", above=0.0, words="time that the leg takes")

    def __post_init__(self) -> None:
        _check_steps("Ramp", self.steps)
        object.__setattr__(self, "steps", int(self.steps))
        named = [name for name in NORMAL_CHANNELS if getattr(self, name) is not None]
        if not named:
            raise PathError(
                "Ramp: no channel is named; give a target such as indentation='1 um' or normal_force='50 N'"
            )
        if len(named) > 1:
            raise PathError("Ramp: indentation and normal_force cannot both be prescribed; name one of them")


@dataclass(frozen=True, eq=False)
class Hold(Leg):
    """
    Hold every channel where it is.

    Parameters
    ----------
    duration : quantity, optional
        Time in s, above 0.
    steps : int
        Number of rows, at least 1.

    Examples
    --------
    >>> Hold("10 s", steps=5).duration
    10.0
    """

    duration: OptionalSIField = OptionalSIField("s", above=0.0, words="time to hold")
    steps: int = 1

    def __post_init__(self) -> None:
        _check_steps("Hold", self.steps)
        object.__setattr__(self, "steps", int(self.steps))


@dataclass(frozen=True, eq=False)
class Path(Leg):
    """
    A measured or computed history given as arrays, one row per sample.

    The first sample is reached by a straight line from the state before.

    Parameters
    ----------
    time : array_like, optional
        Times in s, strictly rising.
    indentation : array_like, optional
        Approach d in m.
    normal_force : array_like, optional
        Normal force in N.

    Raises
    ------
    PathError
        If the arrays are empty or of different lengths, time does not rise, or both or neither of
        indentation and force are given.

    Examples
    --------
    >>> Path(indentation=["1 um", "2 um"]).indentation.tolist()
    [1e-06, 2e-06]
    """

    time: OptionalArrayField = OptionalArrayField("s", words="times")
    indentation: OptionalArrayField = OptionalArrayField("m", words="indentations")
    normal_force: OptionalArrayField = OptionalArrayField("N", words="normal forces")

    def __post_init__(self) -> None:
        named = [name for name in NORMAL_CHANNELS if getattr(self, name) is not None]
        if len(named) != 1:
            raise PathError(
                f"Path: exactly one of indentation and normal_force is needed, not {named or 'none'}; "
                "for example Path(indentation=[1e-6, 2e-6])"
            )
        samples = getattr(self, named[0])
        if samples.size == 0:
            raise PathError(f"Path.{named[0]} is empty: at least one sample is needed")
        time = self.time
        if time is None:
            return
        if time.shape != samples.shape:
            raise PathError(
                f"Path: {time.size} times for {samples.size} samples of {named[0]}; give one time per sample"
            )
        if np.any(np.diff(time) <= 0.0):
            raise PathError(f"Path.time must rise strictly; it does not after entry {_first_fall(time)}")


def _first_fall(time: Any) -> int:
    return int(np.argmax(np.diff(time) <= 0.0))


@dataclass(frozen=True, eq=False)
class History(LoadingPath):
    """
    Legs one after the other, written ``a >> b``.

    Parameters
    ----------
    legs : tuple of Leg
        At least one.

    Examples
    --------
    >>> len((indent("1 um") >> indent("0 um")).legs)
    2
    """

    legs: tuple[Leg, ...]

    def __post_init__(self) -> None:
        pieces = tuple(self.legs)
        if not pieces:
            raise PathError("the path is empty: give at least one leg, for example load('50 N')")
        if not all(isinstance(leg, Leg) for leg in pieces):
            raise PathError(f"History.legs = {self.legs!r}: every entry must be a leg such as load('50 N')")
        object.__setattr__(self, "legs", pieces)


def indent(indentation: QuantityLike, *, steps: int = 1, duration: QuantityLike | None = None) -> Ramp:
    """
    Move the indentation to a target.

    Parameters
    ----------
    indentation : quantity
        Target of the approach d in m.
    steps : int
        Number of rows.
    duration : quantity, optional
        Time in s.

    Returns
    -------
    Ramp

    Examples
    --------
    >>> indent("2 um", steps=4).indentation
    2e-06
    """
    return Ramp(indentation=indentation, steps=steps, duration=duration)


def load(normal_force: QuantityLike, *, steps: int = 1, duration: QuantityLike | None = None) -> Ramp:
    """
    Move the normal force to a target.

    Parameters
    ----------
    normal_force : quantity
        Target force in N.
    steps : int
        Number of rows.
    duration : quantity, optional
        Time in s.

    Returns
    -------
    Ramp

    Examples
    --------
    >>> load("50 N", steps=50).normal_force
    50.0
    """
    return Ramp(normal_force=normal_force, steps=steps, duration=duration)


def hold(duration: QuantityLike | None = None, *, steps: int = 1) -> Hold:
    """
    Hold every channel where it is.

    Parameters
    ----------
    duration : quantity, optional
        Time in s.
    steps : int
        Number of rows.

    Returns
    -------
    Hold

    Examples
    --------
    >>> hold("1 s", steps=10).steps
    10
    """
    return Hold(duration=duration, steps=steps)


def ramp(
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
    normal_force: QuantityLike | None = None,
) -> Ramp:
    """
    Move one or several channels to their targets together.

    Parameters
    ----------
    steps : int
        Number of rows.
    duration : quantity, optional
        Time in s.
    indentation, normal_force : quantity, optional
        Targets in m and N.

    Returns
    -------
    Ramp

    Examples
    --------
    >>> ramp(indentation="1 um", steps=100).steps
    100
    """
    return Ramp(
        indentation=indentation,
        normal_force=normal_force,
        steps=steps,
        duration=duration,
    )
