"""Rows of a loading path: prescribed channels, start and time of every leg."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymdr.errors import PathError, PymdrError
from pymdr.problem.paths import (
    NORMAL_CHANNELS,
    TANGENTIAL_CHANNELS,
    TORSIONAL_CHANNELS,
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
    planar: bool = False
    """Whether shifts and tangential forces of the path are pairs along x and y."""

    @property
    def size(self) -> int:
        """Number of rows."""
        return rows_of(self.leg)

    def time(self, begin: float, start: Any, target: Any) -> FloatArray | None:
        """Time of every row in s for a start time, start value and target; None if the leg has no time."""
        leg = self.leg
        if isinstance(leg, Path):
            if leg.time is None:
                return self._standstill(begin)
            if leg.relative_time and self.number > 1:
                return np.asarray(leg.time - (2.0 * leg.time[0] - leg.time[1]) + begin)
            if leg.time[0] <= begin and self.number > 1:
                raise PathError(
                    f"leg {self.number}: time begins at {leg.time[0]:g} s, but the preceding legs end at {begin:g} s; "
                    "times count from the start of the whole path"
                )
            return np.asarray(leg.time)
        duration = leg.duration
        if isinstance(leg, Ramp) and leg.rate is not None:
            duration = float(np.linalg.norm(target - start)) / leg.rate
            if duration == 0.0:
                channel = named_channels(leg)[0]
                value = " and ".join(written(float(v), unit_of(channel)) for v in np.atleast_1d(target))
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

    def stretch(self, here: Mapping[str, Any], begin: float = 0.0) -> Stretch:
        """
        The rows of the leg.

        Parameters
        ----------
        here : mapping
            Values of the channels at the start of the leg, in SI units, pairs in the plane; missing ones are 0.
        begin : float
            Start time in s.
        """
        channels = self.controls.normal, self.controls.tangential
        start = here.get(channels[0], 0.0), here.get(channels[1], np.zeros(2) if self.planar else 0.0)
        normal, tangential = (_rows(self.leg, *pair) for pair in zip(channels, start, strict=True))
        moved = 1 if any(name in TANGENTIAL_CHANNELS for name in named_channels(self.leg)) else 0
        time = self.time(begin, start[moved], (normal, tangential)[moved][-1])
        return Stretch(self, normal, tangential, start, time, begin)


@dataclass(frozen=True)
class Stretch:
    """The prescribed rows of a leg, once its start is known."""

    leg: Planned
    normal: FloatArray
    """The prescribed normal channel in every row."""
    tangential: FloatArray
    """The prescribed tangential channel in every row: (n,), or (n, 2) in the plane."""
    start: tuple[float, Any] = (0.0, 0.0)
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
        start = (float(self.normal[before]), self.tangential[before]) if span.start else self.start
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
    def end(self) -> dict[str, Any]:
        """Values of the prescribed channels after the last row."""
        last = self.tangential[-1]
        return {
            self.controls.normal: float(self.normal[-1]),
            self.controls.tangential: float(last) if last.ndim == 0 else last.copy(),
        }


def known_legs(path: LoadingPath) -> list[KnownLeg]:
    """The legs in order; a leg of an unknown kind is refused."""
    known: list[KnownLeg] = []
    for number, leg in enumerate(legs(path), 1):
        if not isinstance(leg, KnownLeg):
            raise PathError(
                f"leg {number} is a {type(leg).__name__}, which is unknown; use load(...), hold(...), cycle(...) or Path(...)"
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


def is_torsional(path: LoadingPath) -> bool:
    """Whether a path turns the body."""
    return any(uses(path, name) for name in TORSIONAL_CHANNELS)


PLANE_CHANNELS = ("shift", "tangential_force")
"""Channels that may have components along x and y."""


def is_planar(path: LoadingPath) -> bool:
    """Whether a path prescribes shifts or tangential forces in the plane, as pairs along x and y."""
    kinds = [
        (number, name, np.ndim(getattr(leg, name)) - isinstance(leg, Path) == 1)
        for number, leg in enumerate(known_legs(path), 1)
        for name in named_channels(leg)
        if name in PLANE_CHANNELS
    ]
    pairs = [kind for kind in kinds if kind[2]]
    if pairs and len(pairs) < len(kinds):
        single = next(kind for kind in kinds if not kind[2])
        raise PathError(
            f"leg {single[0]} gives {single[1]} as one number, leg {pairs[0][0]} gives {pairs[0][1]} as a pair (x, y); give pairs in all "
            "legs, such as ('1 um', 0)"
        )
    return bool(pairs)


def planned(path: LoadingPath) -> tuple[Planned, ...]:
    """The legs of a path in order, each with its number, its rows, its controls and its time."""
    legs = known_legs(path)
    controls, first = Controls(), 0
    timed, planar = any(map(_has_time, legs)), is_planar(path)
    plan: list[Planned] = []
    for number, leg in enumerate(legs, 1):
        named = named_channels(leg)
        controls = Controls(
            next((name for name in named if name in NORMAL_CHANNELS), controls.normal),
            next((name for name in named if name in TANGENTIAL_CHANNELS), controls.tangential),
        )
        plan.append(Planned(leg, number, len(legs), first, controls, timed, planar))
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
    ends = np.stack([rows.normal, *np.atleast_2d(rows.tangential.T)])
    moves = np.diff(ends, axis=1, prepend=np.hstack(rows.start)[:, None])
    count = np.where((moves[0] != 0.0) & (moves[1:] != 0.0).any(axis=0), between, 1)
    own = np.cumsum(count) - 1
    remaining = (np.repeat(own, count) - np.arange(own[-1] + 1)) / np.repeat(count, count)
    # at first and last contact the indentation is not smooth in the load: short parts there
    bare = np.repeat((ends[0] <= 0.0) | (ends[0] - moves[0] <= 0.0), count)
    remaining = np.where(bare, remaining**3 * (10.0 - remaining * (15.0 - 6.0 * remaining)), remaining)
    finer = np.repeat(ends, count, axis=1) - np.repeat(moves, count, axis=1) * remaining
    tangential = finer[1] if rows.tangential.ndim == 1 else finer[1:].T
    return Refined(replace(rows, normal=finer[0], tangential=tangential, time=None), own)


def _rows(leg: KnownLeg, channel: str, start: Any) -> FloatArray:
    target = getattr(leg, channel, None)
    if target is None:
        return np.repeat(np.asarray(start, dtype=float)[None], rows_of(leg), axis=0)
    if isinstance(leg, Path):
        return np.asarray(target)
    if isinstance(leg, Cycle):
        return np.asarray(start + np.multiply.outer(leg.wave, target))
    assert isinstance(leg, Ramp)
    moved = np.multiply.outer(np.arange(1.0, leg.steps + 1.0), target - start)
    rows: FloatArray = start + moved / leg.steps
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
            kept |= {*samples.argmin(axis=0).ravel().tolist(), *samples.argmax(axis=0).ravel().tolist()}
        chosen = np.array(sorted(kept))
        columns = {name: np.asarray(getattr(leg, name))[chosen] for name in named_channels(leg)}
        time = None if leg.time is None else leg.time[chosen]
        return Path(time=time, relative_time=leg.relative_time and chosen.size > 1, **columns)
    return replace(leg, steps=4 * leg.cycles if isinstance(leg, Cycle) else 1)
