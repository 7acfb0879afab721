"""Rows of a loading path: prescribed channels, start and time of every leg."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import PathError, PymdrError
from pymdr.problem.paths import (
    NORMAL_CHANNELS,
    TANGENTIAL_CHANNELS,
    Cycle,
    Hold,
    LoadingPath,
    Path,
    Ramp,
    legs,
    named_channels,
    unit_of,
)
from pymdr.units import FloatArray, written

KnownLeg = Ramp | Cycle | Hold | Path

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and their total."""


@dataclass(frozen=True)
class Controls:
    """The channel that is prescribed in each direction."""

    normal: str = "indentation"
    tangential: str = "shift"


@dataclass(frozen=True)
class Planned:
    """One leg in its path, before its start is known."""

    leg: KnownLeg
    number: int
    """Counted from 1."""
    of: int
    """Number of legs of the path."""
    first: int
    """Rows of the path before the leg."""
    controls: Controls
    """Channels that the leg does not name keep the control of the preceding legs."""
    timed: bool
    """Whether the path has times; a leg without one then takes none."""

    @property
    def size(self) -> int:
        """Number of rows."""
        return rows_of(self.leg)

    def time(self, begin: float, start: float, target: float) -> FloatArray | None:
        """Time of every row in s for a start time, start value and target; None if the leg has no time."""
        leg = self.leg
        if isinstance(leg, Path):
            if leg.time is None:
                return self._standstill(begin)
            if leg.relative_time and self.number > 1:
                return np.asarray(leg.time - (2.0 * leg.time[0] - leg.time[1]) + begin)
            if leg.time[0] <= begin and self.number > 1:
                raise PathError(
                    f"leg {self.number}: Path.time begins at {leg.time[0]:g} s, but the preceding legs end at {begin:g} s; "
                    "times count from the start of the whole path"
                )
            return np.asarray(leg.time)
        duration = leg.duration
        if isinstance(leg, Ramp) and leg.rate is not None:
            duration = abs(target - start) / leg.rate
            if duration == 0.0:
                channel = named_channels(leg)[0]
                value = written(target, unit_of(channel))
                raise PathError(
                    f"leg {self.number}: the start equals the target, {channel} = {value}, so a rate gives no duration; use hold(...) with "
                    "a duration"
                )
        if duration is None:
            return self._standstill(begin)
        return np.asarray(begin + duration * np.arange(1.0, self.size + 1.0) / self.size)

    def _standstill(self, begin: float) -> FloatArray | None:
        """Times of the rows of a leg that takes none."""
        return np.full(self.size, begin) if self.timed else None

    def row(self, index: int) -> str:
        """Label of a row of the leg."""
        return f"row {index + 1} of leg {self.number}"

    @contextmanager
    def named(self) -> Iterator[None]:
        """Add the number of the leg to errors, unless it is there or the path has one leg."""
        try:
            yield
        except PymdrError as error:
            text, label = str(error), f"leg {self.number}"
            if self.of > 1 and label not in text:
                error.args = (f"{label}: {text}",)
            raise

    def stretch(self, here: Mapping[str, float], begin: float = 0.0) -> Stretch:
        """
        The rows of the leg.

        Parameters
        ----------
        here : mapping of str to float
            Values of the channels at the start of the leg, in SI units; missing ones are 0.
        begin : float
            Start time in s.
        """
        channels = self.controls.normal, self.controls.tangential
        start = here.get(channels[0], 0.0), here.get(channels[1], 0.0)
        normal, tangential = (_rows(self.leg, *pair) for pair in zip(channels, start, strict=True))
        moved = 1 if any(name in TANGENTIAL_CHANNELS for name in named_channels(self.leg)) else 0
        time = self.time(begin, start[moved], float((normal, tangential)[moved][-1]))
        return Stretch(self, normal, tangential, start, time, begin)


@dataclass(frozen=True)
class Stretch:
    """The prescribed rows of a leg, once its start is known."""

    leg: Planned
    normal: FloatArray
    """The prescribed normal channel in every row."""
    tangential: FloatArray
    """The prescribed tangential channel in every row."""
    start: tuple[float, float] = (0.0, 0.0)
    """Values of both channels before the first row."""
    time: FloatArray | None = None
    """Time of every row in s, if the path states it."""
    begin: float = 0.0
    """Time in s before the first row."""
    first: int = 0
    """The first row, counted from the start of the leg."""

    def row(self, index: int) -> str:
        """Label of a row."""
        return self.leg.row(self.first + index)

    def taken(self, span: slice) -> Stretch:
        """Consecutive rows, without their times."""
        before = span.start - 1
        start = (float(self.normal[before]), float(self.tangential[before])) if span.start else self.start
        return Stretch(
            self.leg, self.normal[span], self.tangential[span], start, first=self.first + span.start
        )

    @property
    def controls(self) -> Controls:
        """The prescribed channels."""
        return self.leg.controls

    @property
    def by_force(self) -> bool:
        """Whether the normal force is prescribed."""
        return self.controls.normal == "normal_force"

    @property
    def durations(self) -> FloatArray | None:
        """Time in s from the row before to every row."""
        return None if self.time is None else np.diff(self.time, prepend=self.begin)

    @property
    def end(self) -> dict[str, float]:
        """Values of the prescribed channels after the last row."""
        return {
            self.controls.normal: float(self.normal[-1]),
            self.controls.tangential: float(self.tangential[-1]),
        }


def known_legs(path: LoadingPath) -> list[KnownLeg]:
    """The legs in order; a leg of an unknown kind is refused."""
    known: list[KnownLeg] = []
    for number, leg in enumerate(legs(path), 1):
        if not isinstance(leg, KnownLeg):
            raise PathError(
                f"solve: leg {number} is a {type(leg).__name__}, which is unknown; use load(...), hold(...), cycle(...) or Path(...)"
            )
        known.append(leg)
    return known


def rows_of(leg: KnownLeg) -> int:
    """Number of rows of a leg."""
    steps = leg.steps
    assert steps is not None
    return steps


def total_rows(path: LoadingPath) -> int:
    """Number of rows of a path."""
    return sum(rows_of(leg) for leg in known_legs(path))


def uses(path: LoadingPath, name: str) -> bool:
    """Whether any leg prescribes a channel."""
    return any(name in named_channels(leg) for leg in known_legs(path))


def planned(path: LoadingPath) -> tuple[Planned, ...]:
    """
    The legs of a path in order, each with its number, its rows, its controls and its time.

    Raises
    ------
    PathError
        If a leg is of an unknown kind.
    """
    legs = known_legs(path)
    controls, first = Controls(), 0
    timed = any(map(_has_time, legs))
    plan: list[Planned] = []
    for number, leg in enumerate(legs, 1):
        named = named_channels(leg)
        controls = Controls(
            next((name for name in named if name in NORMAL_CHANNELS), controls.normal),
            next((name for name in named if name in TANGENTIAL_CHANNELS), controls.tangential),
        )
        plan.append(Planned(leg, number, len(legs), first, controls, timed))
        first += rows_of(leg)
    return tuple(plan)


@dataclass(frozen=True)
class Refined:
    """A leg with intermediate rows, linear in both prescribed channels."""

    rows: Stretch
    own: np.ndarray
    """Indices of the original rows."""


def refined(rows: Stretch, between: int) -> Refined:
    """
    A leg with intermediate rows wherever both channels move.

    Parameters
    ----------
    between : int
        Number of parts of every such step.
    """
    ends = np.stack([rows.normal, rows.tangential])
    moves = np.diff(ends, axis=1, prepend=np.array(rows.start)[:, None])
    count = np.where((moves != 0.0).all(axis=0), between, 1)
    own = np.cumsum(count) - 1
    remaining = (np.repeat(own, count) - np.arange(own[-1] + 1)) / np.repeat(count, count)
    # at first and last contact the indentation is not smooth in the load: short parts there
    bare = np.repeat((ends[0] <= 0.0) | (ends[0] - moves[0] <= 0.0), count)
    remaining = np.where(bare, remaining**3 * (10.0 - remaining * (15.0 - 6.0 * remaining)), remaining)
    normal, tangential = np.repeat(ends, count, axis=1) - np.repeat(moves, count, axis=1) * remaining
    return Refined(replace(rows, normal=normal, tangential=tangential, time=None), own)


def _rows(leg: KnownLeg, channel: str, start: float) -> FloatArray:
    target = getattr(leg, channel, None)
    if target is None:
        return np.full(rows_of(leg), start)
    if isinstance(leg, Path):
        return np.asarray(target)
    if isinstance(leg, Cycle):
        return np.asarray(start + target * leg.wave)
    assert isinstance(leg, Ramp)
    rows: FloatArray = start + (target - start) * np.arange(1.0, leg.steps + 1.0) / leg.steps
    rows[-1] = target
    return rows


def _has_time(leg: KnownLeg) -> bool:
    if isinstance(leg, Path):
        return leg.time is not None
    return leg.duration is not None or getattr(leg, "rate", None) is not None


def check_times(path: LoadingPath, *, needed: bool) -> None:
    """Refuse a path with durations for some legs only; what precedes a record of relative times needs none unless `needed`."""
    all_legs = known_legs(path)
    timed = [_has_time(leg) for leg in all_legs]
    first = timed.index(True) if any(timed) else 0
    preloaded = not needed and getattr(all_legs[first], "relative_time", False)
    if any(timed) and not all(timed[first if preloaded else 0 :]):
        known, unknown = (
            [i for i, has_time in enumerate(timed, 1) if has_time is kind] for kind in (True, False)
        )
        raise PathError(
            f"{numbered_legs(unknown)} no time, but {numbered_legs(known)}: give every leg a duration or a rate (a Path its time), or none"
        )


def numbered_legs(numbers: Sequence[int]) -> str:
    """
    Legs by number, with the verb to have.

    Examples
    --------
    >>> numbered_legs([2]), numbered_legs([1, 3]), numbered_legs(range(1, 9))
    ('leg 2 has', 'legs 1 and 3 have', 'legs 1, 2, 3, 4 and 4 more have')
    """
    if len(numbers) == 1:
        return f"leg {numbers[0]} has"
    shown = [str(number) for number in numbers]
    if len(shown) > 5:
        shown = [*shown[:4], f"{len(shown) - 4} more"]
    return f"legs {', '.join(shown[:-1])} and {shown[-1]} have"


def ends_only(leg: KnownLeg) -> LoadingPath:
    """A leg reduced to its extremes."""
    if isinstance(leg, Path):
        kept = {0, leg.steps - 1}
        for name in named_channels(leg):
            samples = np.asarray(getattr(leg, name))
            kept |= {int(samples.argmin()), int(samples.argmax())}
        chosen = np.array(sorted(kept))
        columns = {name: np.asarray(getattr(leg, name))[chosen] for name in named_channels(leg)}
        time = None if leg.time is None else leg.time[chosen]
        return Path(time=time, relative_time=leg.relative_time and chosen.size > 1, **columns)
    return replace(leg, steps=4 * leg.cycles if isinstance(leg, Cycle) else 1)
