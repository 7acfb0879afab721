"""Legs of a loading path, and their concatenation with ``>>``.

Targets are absolute positions in the channel's unit. The initial state is not a row: a leg of n steps
gives n rows, the last at its target.
"""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass, field
from typing import Any, TypedDict, Unpack

import numpy as np

from pymdr.errors import PathError, UnitError
from pymdr.problem.options import with_options
from pymdr.problem.values import (
    OptionalArrayField,
    OptionalPlaneArrayField,
    OptionalPlaneField,
    OptionalSIField,
    Value,
    within_range,
)
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si

NORMAL_CHANNELS = ("indentation", "normal_force", "travel")
"""Channels of the normal direction; a leg prescribes at most one."""

TORSIONAL_CHANNELS = ("twist", "torque")
"""Channels of a rotation about the axis."""

TANGENTIAL_CHANNELS = ("shift", "tangential_force", *TORSIONAL_CHANNELS)
"""Channels of the tangential direction; a leg prescribes at most one."""

CHANNELS = (*NORMAL_CHANNELS, *TANGENTIAL_CHANNELS)


class LoadingPath(Value, ABC):
    """A history of prescribed channels; ``a >> b`` follows b after a."""

    def __rshift__(self, other: LoadingPath) -> History:
        if not isinstance(other, LoadingPath):
            return NotImplemented
        return History((*legs(self), *legs(other)))

    def __mul__(self, times: int) -> History:
        """
        The path, repeated: ``path * 2`` is ``path >> path``.

        Examples
        --------
        >>> import pymdr as mdr
        >>> tap = mdr.indent("1 um") >> mdr.indent("0 um")
        >>> tap * 2 == tap >> tap
        True
        """
        if isinstance(times, bool) or not isinstance(times, int | np.integer) or times < 1:
            raise PathError(f"path * {shown(times)}: a whole number of at least 1 is needed, as in path * 3")
        return History(legs(self) * int(times))


def legs(path: LoadingPath) -> tuple[Leg, ...]:
    """The legs of a path in order."""
    if isinstance(path, History):
        return path.legs
    assert isinstance(path, Leg)
    return (path,)


class Leg(LoadingPath):
    """One part of a path."""


def named_channels(leg: Leg) -> tuple[str, ...]:
    """The channels that a leg prescribes."""
    given = vars(leg)
    return tuple(name for name in CHANNELS if given.get(name) is not None)


def _check_channels(leg: Leg, example: str) -> None:
    named = named_channels(leg)
    if not named:
        raise PathError(f"no channel is prescribed; give for example {example}")
    for group in (NORMAL_CHANNELS, TANGENTIAL_CHANNELS):
        both = [name for name in named if name in group]
        if len(both) > 1:
            raise PathError(f"{' and '.join(both)} cannot both be prescribed; name one of them")


_MOST = 10**15
"""Largest number of rows: beyond any memory, exact as a float."""


def _check_steps(steps: Any) -> None:
    if isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 1:
        raise PathError(f"steps = {shown(steps)}: a whole number of at least 1 is needed")
    if steps > _MOST:
        raise PathError(
            f"steps = {float(min(steps, 10**300)):.3g}: at most {_MOST:.0e} rows are possible; use fewer steps"
        )


_UNITS = {"normal_force": "N", "tangential_force": "N", "twist": "rad", "torque": "N*m"}
"""SI units of the channels that are no lengths."""


def unit_of(channel: str) -> str:
    """SI unit of a channel."""
    return _UNITS.get(channel, "m")


class _RateField(OptionalSIField):
    """A rate of a channel in its SI unit per second."""

    def __set__(self, instance: object, value: QuantityLike | None) -> None:
        number, unit = None, None
        if value is not None:
            try:
                # a plain number fits every channel
                number, unit = self.read(value), None if isinstance(value, int | float) else "m/s"
            except UnitError:
                if not isinstance(value, str):
                    raise
                number, unit = self._other_rate(value)
                if not number > 0.0:
                    raise PathError(f"{self.name} = {shown(value)}: it must be above 0 {unit}") from None
        instance.__dict__[self.name] = number
        instance.__dict__["_rate_unit"] = unit

    def _other_rate(self, value: str) -> tuple[float, str]:
        for unit in ("N/s", "rad/s", "N*m/s"):
            try:
                return to_si(value, unit, name=self.name), unit
            except UnitError:
                continue
        raise UnitError(
            f"{self.name} = {shown(value)}: give a speed such as '1 um/s', a rate of force such as '1 N/s', of "
            "twist such as '1 mrad/s' or of torque such as '1 N*m/s'"
        )


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
    travel : quantity, optional
        Target of the drive of the machine, indentation + normal_force / machine_stiffness, in m.
    shift : quantity, optional
        Target of the tangential displacement in m: u_x, or a pair (u_x, u_y).
    tangential_force : quantity, optional
        Target of the tangential force in N: F_x, or a pair (F_x, F_y).
    twist : quantity, optional
        Target of the rotation about the axis in rad.
    torque : quantity, optional
        Target of the torque in N m.
    steps : int
        Number of rows, at least 1.
    duration : quantity, optional
        Duration of the leg in s, above 0.
    rate : quantity, optional
        Instead of a duration: speed in m/s, or rate of force in N/s, of the single moving channel, above 0. The
        duration is |target - start| / rate.

    Raises
    ------
    PathError
        If no channel is named, or two channels of one direction are both prescribed, or `steps` is not a
        whole number of at least 1, or a rate is given together with a duration, for two channels, or in the wrong unit.
    ProblemError
        If the duration or the rate is not above 0.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> Ramp(normal_force="50 N", steps=50).normal_force
    50.0
    """

    indentation: OptionalSIField = OptionalSIField("m", description="target of the indentation")
    normal_force: OptionalSIField = OptionalSIField("N", description="target of the normal force")
    travel: OptionalSIField = OptionalSIField("m", description="target of the travel of the machine")
    shift: OptionalPlaneField = OptionalPlaneField("m", description="target of the tangential displacement")
    tangential_force: OptionalPlaneField = OptionalPlaneField(
        "N", description="target of the tangential force"
    )
    twist: OptionalSIField = OptionalSIField("rad", description="target of the rotation about the axis")
    torque: OptionalSIField = OptionalSIField("N*m", description="target of the torque")
    steps: int = 1
    duration: OptionalSIField = OptionalSIField("s", above=0.0, description="duration of the leg")
    rate: OptionalSIField = _RateField(
        "m/s", above=0.0, description="speed of the channel; for a force its rate in N/s"
    )

    def __post_init__(self) -> None:
        _check_steps(self.steps)
        self._check_rate()
        object.__setattr__(self, "steps", int(self.steps))
        _check_channels(self, "a target such as indentation='1 um' or normal_force='50 N'")

    def _check_rate(self) -> None:
        known = self.__dict__.pop("_rate_unit", None)
        if self.rate is None:
            return
        moved = [name for name in CHANNELS if getattr(self, name) is not None]
        if self.duration is not None:
            raise PathError("Ramp: give either duration or rate, not both")
        if len(moved) > 1:
            raise PathError(
                f"Ramp: a rate needs a single moving channel, but {' and '.join(moved)} move; give a duration"
            )
        unit = f"{unit_of(moved[0])}/s" if moved else "m/s"
        if known is not None and known != unit:
            raise PathError(f"Ramp.rate is in {known}, but {moved[0]} moves in {unit}; give it in {unit}")


@dataclass(frozen=True, eq=False)
class Hold(Leg):
    """
    Hold every channel constant.

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

    duration: OptionalSIField = OptionalSIField("s", above=0.0, description="time to hold")
    steps: int = 1

    def __post_init__(self) -> None:
        _check_steps(self.steps)
        object.__setattr__(self, "steps", int(self.steps))


@dataclass(frozen=True, eq=False)
class Cycle(Leg):
    """
    Cycle channels about their present values: linearly to +amplitude, to -amplitude and back.

    Parameters
    ----------
    indentation, normal_force, travel, shift, tangential_force, twist, torque : quantity, optional
        Amplitudes in m, N, rad or N m; several channels move in phase. A pair of amplitudes of shift or tangential_force moves to and
        fro along their direction.
    cycles : int
        Number of cycles, at least 1.
    steps : int, optional
        Number of rows of the leg, a multiple of 4 per cycle so that turning points are rows; by default 40 per cycle.
    duration : quantity, optional
        Duration of the leg in s, above 0.

    Raises
    ------
    PathError
        If no channel is named, two channels of one direction are, or turning points are not rows.

    Examples
    --------
    >>> Cycle(shift="2 um", cycles=2, steps=200).steps
    200
    """

    indentation: OptionalSIField = OptionalSIField("m", description="amplitude of the indentation")
    normal_force: OptionalSIField = OptionalSIField("N", description="amplitude of the normal force")
    travel: OptionalSIField = OptionalSIField("m", description="amplitude of the travel of the machine")
    shift: OptionalPlaneField = OptionalPlaneField(
        "m", description="amplitude of the tangential displacement"
    )
    tangential_force: OptionalPlaneField = OptionalPlaneField(
        "N", description="amplitude of the tangential force"
    )
    twist: OptionalSIField = OptionalSIField("rad", description="amplitude of the rotation about the axis")
    torque: OptionalSIField = OptionalSIField("N*m", description="amplitude of the torque")
    cycles: int = 1
    steps: int | None = None
    duration: OptionalSIField = OptionalSIField("s", above=0.0, description="duration of the leg")

    def __post_init__(self) -> None:
        if isinstance(self.cycles, bool) or not isinstance(self.cycles, int | np.integer) or self.cycles < 1:
            raise PathError(f"Cycle.cycles = {shown(self.cycles)}: a whole number of at least 1 is needed")
        if self.cycles > _MOST:
            raise PathError(f"Cycle.cycles = {shown(self.cycles)}: it must be at most {_MOST:.0e}")
        steps = 40 * self.cycles if self.steps is None else self.steps
        _check_steps(steps)
        if steps % (4 * self.cycles):
            raise PathError(
                f"Cycle.steps = {steps}: it must be a multiple of {4 * self.cycles}, so that the "
                f"turning points of {self.cycles} cycles are rows"
            )
        object.__setattr__(self, "cycles", int(self.cycles))
        object.__setattr__(self, "steps", int(steps))
        _check_channels(self, "an amplitude such as shift='2 um'")

    @property
    def wave(self) -> FloatArray:
        """The rows of all cycles for unit amplitude, shape (steps,)."""
        assert self.steps is not None
        phase = np.arange(1, self.steps + 1) * (4.0 * self.cycles) / self.steps
        wave: FloatArray = 1.0 - np.abs((phase + 1.0) % 4.0 - 2.0)
        return wave


@dataclass(frozen=True, eq=False)
class Path(Leg):
    """
    A measured or computed history given as arrays, one row per sample.

    The first sample is reached linearly from the preceding state.

    Parameters
    ----------
    time : array_like, optional
        Times in s, strictly rising, from the start of the whole path.
    indentation : array_like, optional
        Approach d in m.
    normal_force : array_like, optional
        Normal force in N.
    travel : array_like, optional
        Travel of the machine in m.
    shift : array_like, optional
        Tangential displacement in m, shape (n,), or (n, 2) in the plane.
    tangential_force : array_like, optional
        Tangential force in N, shape (n,), or (n, 2) in the plane.
    twist : array_like, optional
        Rotation about the axis in rad.
    torque : array_like, optional
        Torque in N m.
    relative_time : bool
        Whether the times are those of a record with its own clock: they then count on from the preceding legs, and the
        first sample is one sampling interval after their end.

    Raises
    ------
    PathError
        If the arrays are empty or of different lengths, time does not rise, no channel is given or two of
        one direction are, or a relative time has fewer than two samples.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Path(indentation=["1 um", "2 um"]).indentation.tolist()
    [1e-06, 2e-06]
    """

    time: OptionalArrayField = OptionalArrayField("s", description="times")
    indentation: OptionalArrayField = OptionalArrayField("m", description="indentations")
    normal_force: OptionalArrayField = OptionalArrayField("N", description="normal forces")
    travel: OptionalArrayField = OptionalArrayField("m", description="travels of the machine")
    shift: OptionalPlaneArrayField = OptionalPlaneArrayField("m", description="tangential displacements")
    tangential_force: OptionalPlaneArrayField = OptionalPlaneArrayField("N", description="tangential forces")
    twist: OptionalArrayField = OptionalArrayField("rad", description="rotations about the axis")
    torque: OptionalArrayField = OptionalArrayField("N*m", description="torques")
    relative_time: bool = field(
        default=False,
        metadata={
            "description": "whether times count from the end of the preceding legs; true for a file unless given"
        },
    )

    def __post_init__(self) -> None:
        _check_channels(self, "Path(indentation=[1e-6, 2e-6])")
        named = named_channels(self)
        size = len(getattr(self, named[0]))
        if size == 0:
            raise PathError(f"{named[0]} is empty: at least one sample is needed")
        for name in named[1:]:
            if len(getattr(self, name)) != size:
                raise PathError(
                    f"{size} samples of {named[0]} and {len(getattr(self, name))} of {name}; give equal "
                    "numbers"
                )
        for name in named:
            values = within_range(getattr(self, name), type(self).__dict__[name].unit, name)
            object.__setattr__(self, name, values)
        time = self.time
        if time is None:
            return
        if time.size != size:
            raise PathError(f"{time.size} times for {size} samples of {named[0]}; give one time per sample")
        if np.any(np.diff(time) <= 0.0):
            i = int(np.argmax(np.diff(time) <= 0.0))
            raise PathError(
                f"time must rise strictly, but entries {i + 1} and {i + 2} are {time[i]:.12g} s and "
                f"{time[i + 1]:.12g} s; sort the rows and average those of equal time (numbers of this size differ by "
                f"{np.spacing(time[i + 1]):.1g} s)"
            )
        if self.relative_time and size < 2:
            raise PathError("relative_time: one sample has no sampling interval; give its time in the path")

    @property
    def steps(self) -> int:
        """Number of rows."""
        return len(getattr(self, named_channels(self)[0]))


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
        parts = tuple(self.legs)
        if not parts:
            raise PathError("the path is empty: give at least one leg, for example load('50 N')")
        for number, leg in enumerate(parts, 1):
            if not isinstance(leg, Leg):
                raise PathError(
                    f"leg {number} is {shown(leg)}; every entry must be a leg such as load('50 N')"
                )
        object.__setattr__(self, "legs", parts)


def indent(
    indentation: QuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Move the indentation to a target.

    Parameters
    ----------
    indentation : quantity
        Target of the approach d in m.
    steps, duration, rate
        As for :class:`Ramp`; the rate is a speed in m/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.indent("2 um", steps=4).indentation
    2e-06
    """
    return Ramp(indentation=indentation, steps=steps, duration=duration, rate=rate)


def load(
    normal_force: QuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Move the normal force to a target.

    Parameters
    ----------
    normal_force : quantity
        Target force in N.
    steps, duration, rate
        As for :class:`Ramp`; the rate is in N/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.load("50 N", steps=50).normal_force
    50.0
    """
    return Ramp(normal_force=normal_force, steps=steps, duration=duration, rate=rate)


def travel(
    travel: QuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Move the drive of the machine, indentation + normal force / machine stiffness, to a target.

    Parameters
    ----------
    travel : quantity
        Target in m.
    steps, duration, rate
        As for :class:`Ramp`; the rate is a speed in m/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.travel("2 um", steps=4).travel
    2e-06
    """
    return Ramp(travel=travel, steps=steps, duration=duration, rate=rate)


def shift(
    shift: QuantityLike | ArrayQuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Move the tangential displacement to a target.

    Parameters
    ----------
    shift : quantity
        Target in m; a pair (x, y) moves in the plane.
    steps, duration, rate
        As for :class:`Ramp`; the rate is a speed in m/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.shift("2 um", steps=4).shift
    2e-06
    >>> mdr.shift(("2 um", "1 um")).shift.tolist()
    [2e-06, 1e-06]
    """
    return Ramp(shift=shift, steps=steps, duration=duration, rate=rate)


def drag(
    tangential_force: QuantityLike | ArrayQuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Move the tangential force to a target.

    Parameters
    ----------
    tangential_force : quantity
        Target in N; a pair (x, y) pulls in the plane.
    steps, duration, rate
        As for :class:`Ramp`; the rate is in N/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.drag("5 N", steps=4).tangential_force
    5.0
    """
    return Ramp(tangential_force=tangential_force, steps=steps, duration=duration, rate=rate)


class ChannelValues(TypedDict, total=False):
    """Channels by name, each a quantity or None."""

    indentation: QuantityLike | None
    normal_force: QuantityLike | None
    travel: QuantityLike | None
    shift: QuantityLike | ArrayQuantityLike | None
    tangential_force: QuantityLike | ArrayQuantityLike | None
    twist: QuantityLike | None
    torque: QuantityLike | None


def twist(
    twist: QuantityLike,
    *,
    steps: int = 1,
    duration: QuantityLike | None = None,
    rate: QuantityLike | None = None,
) -> Ramp:
    """
    Turn the body about its axis to a target.

    Parameters
    ----------
    twist : quantity
        Target in rad.
    steps, duration, rate
        As for :class:`Ramp`; the rate is in rad/s.

    Returns
    -------
    Ramp
        A leg of `steps` rows; the target is the last row.

    Raises
    ------
    PathError, ProblemError, UnitError
        As :class:`Ramp`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.twist("2 mrad", steps=4).twist
    0.002
    """
    return Ramp(twist=twist, steps=steps, duration=duration, rate=rate)


@with_options(ChannelValues)
def cycle(
    *,
    cycles: int = 1,
    steps: int | None = None,
    duration: QuantityLike | None = None,
    **amplitudes: Unpack[ChannelValues],
) -> Cycle:
    """
    Cycle channels about their present values.

    Parameters
    ----------
    cycles : int
        Number of cycles.
    steps : int, optional
        Number of rows of the leg, a multiple of 4 per cycle.
    duration : quantity, optional
        Time in s.
    **amplitudes : quantity
        Amplitudes of indentation, travel or shift in m, normal_force or tangential_force in N, twist in rad, torque in N m.

    Returns
    -------
    Cycle
        A leg that begins and ends at the present values.

    Raises
    ------
    PathError
        If no channel is given, two of one direction are, or `cycles` or `steps` is not a whole number of at least 1.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.cycle(shift="2 um", steps=8).wave.tolist()
    [0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0]
    """
    return Cycle(cycles=cycles, steps=steps, duration=duration, **amplitudes)


def hold(duration: QuantityLike | None = None, *, steps: int = 1) -> Hold:
    """
    Hold every channel constant.

    Parameters
    ----------
    duration : quantity, optional
        Time in s.
    steps : int
        Number of rows.

    Returns
    -------
    Hold
        A leg of `steps` equal rows.

    Raises
    ------
    PathError
        If `steps` is not a whole number of at least 1.
    ProblemError
        If the duration is not above 0.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.hold("1 s", steps=10).steps
    10
    """
    return Hold(duration=duration, steps=steps)


@with_options(ChannelValues)
def ramp(*, steps: int = 1, duration: QuantityLike | None = None, **targets: Unpack[ChannelValues]) -> Ramp:
    """
    Move one or several channels to their targets together.

    Parameters
    ----------
    steps : int
        Number of rows.
    duration : quantity, optional
        Time in s.
    **targets : quantity
        Targets of indentation, travel or shift in m, normal_force or tangential_force in N, twist in rad, torque in N m.

    Returns
    -------
    Ramp
        A leg of `steps` rows, linear in every channel.

    Raises
    ------
    PathError
        If no channel is given, two of one direction are, or `steps` is not a whole number of at least 1.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.ramp(indentation="1 um", steps=100).steps
    100
    """
    return Ramp(steps=steps, duration=duration, **targets)
