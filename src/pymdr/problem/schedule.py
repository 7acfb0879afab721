"""Rows of a loading path: what every leg prescribes, and from where it starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import PathError
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
)
from pymdr.units import FloatArray

KnownLeg = Ramp | Cycle | Hold | Path

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and their total."""


@dataclass(frozen=True)
class Controls:
    """The channel that is prescribed in each direction."""

    normal: str = "indentation"
    tangential: str = "shift"


@dataclass(frozen=True)
class Stretch:
    """One leg: its controls, and the values of both prescribed channels in its rows."""

    controls: Controls
    normal: FloatArray
    tangential: FloatArray

    @property
    def by_force(self) -> bool:
        """Whether the normal force is prescribed."""
        return self.controls.normal == "normal_force"


def known_legs(path: LoadingPath) -> list[KnownLeg]:
    """The legs in order; a leg of an unknown kind is refused."""
    found: list[KnownLeg] = []
    for leg in legs(path):
        if not isinstance(leg, KnownLeg):
            raise PathError(f"solve: legs of the kind {type(leg).__name__} are not known")
        found.append(leg)
    return found


def rows_of(leg: KnownLeg) -> int:
    """Number of rows of a leg."""
    steps = leg.steps
    assert steps is not None
    return steps


def total_rows(path: LoadingPath) -> int:
    """Number of rows of a path."""
    return sum(rows_of(leg) for leg in known_legs(path))


def channel_values(path: LoadingPath, name: str) -> list[FloatArray]:
    """The numbers that the legs of a path give for a channel."""
    return [np.asarray(v) for leg in known_legs(path) if (v := getattr(leg, name, None)) is not None]


def uses(path: LoadingPath, name: str) -> bool:
    """Whether any leg prescribes a channel."""
    return any(name in named_channels(leg) for leg in known_legs(path))


def stretch(leg: KnownLeg, before: Controls, here: Mapping[str, float]) -> Stretch:
    """
    The rows of a leg.

    Parameters
    ----------
    leg : Leg
    before : Controls
        What the leg before prescribed; channels that this one does not name stay under that control.
    here : mapping of str to float
        Where every channel is at the start of the leg, in SI units.

    Returns
    -------
    Stretch
    """
    named = named_channels(leg)
    normal = next((name for name in named if name in NORMAL_CHANNELS), before.normal)
    tangential = next((name for name in named if name in TANGENTIAL_CHANNELS), before.tangential)
    return Stretch(
        Controls(normal, tangential),
        _rows(leg, normal, here.get(normal, 0.0)),
        _rows(leg, tangential, here.get(tangential, 0.0)),
    )


@dataclass(frozen=True)
class Refined:
    """A leg with rows between its own, straight in both prescribed channels."""

    rows: Stretch
    own: np.ndarray
    """Where the rows of the leg are among them."""


def refined(rows: Stretch, here: Mapping[str, float], between: int) -> Refined:
    """
    A leg whose moves of both channels at once are divided.

    Parameters
    ----------
    rows : Stretch
    here : mapping of str to float
        Where every channel is at the start of the leg, in SI units.
    between : int
        Number of parts of every such move.

    Returns
    -------
    Refined
    """
    ends = np.stack([rows.normal, rows.tangential])
    start = [here.get(name, 0.0) for name in (rows.controls.normal, rows.controls.tangential)]
    moves = np.diff(ends, axis=1, prepend=np.array(start)[:, None])
    count = np.where((moves != 0.0).all(axis=0), between, 1)
    own = np.cumsum(count) - 1
    left = (np.repeat(own, count) - np.arange(own[-1] + 1)) / np.repeat(count, count)
    # where a load comes or goes its depth is no smooth function of it: parts are short there
    bare = np.repeat((ends[0] <= 0.0) | (ends[0] - moves[0] <= 0.0), count)
    left = np.where(bare, left**3 * (10.0 - left * (15.0 - 6.0 * left)), left)
    normal, tangential = np.repeat(ends, count, axis=1) - np.repeat(moves, count, axis=1) * left
    return Refined(replace(rows, normal=normal, tangential=tangential), own)


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


def check_times(path: LoadingPath) -> None:
    """Refuse a path of which some legs have a duration and others none."""
    timed = [
        leg.time is not None if isinstance(leg, Path) else leg.duration is not None
        for leg in known_legs(path)
    ]
    if any(timed) and not all(timed):
        raise PathError(
            "some legs of the path have a duration and others none: give one to every leg, or to none"
        )


def times(path: LoadingPath) -> FloatArray | None:
    """Time of every row in s, if the legs state it."""
    now = 0.0
    columns: list[FloatArray] = []
    for leg in known_legs(path):
        if isinstance(leg, Path):
            if leg.time is None:
                return None
            if leg.time[0] <= now and columns:
                raise PathError(
                    f"Path.time begins at {leg.time[0]:g} s, but the legs before it end at {now:g} s; "
                    "times count from the start of the whole history"
                )
            columns.append(np.asarray(leg.time))
        else:
            if leg.duration is None:
                return None
            n = rows_of(leg)
            columns.append(now + leg.duration * np.arange(1.0, n + 1.0) / n)
        now = float(columns[-1][-1])
    return np.concatenate(columns)


def ends_only(leg: KnownLeg) -> LoadingPath:
    """A leg that visits just the extremes of another."""
    if isinstance(leg, Path):
        kept = {0, leg.steps - 1}
        for name in named_channels(leg):
            samples = np.asarray(getattr(leg, name))
            kept |= {int(samples.argmin()), int(samples.argmax())}
        chosen = np.array(sorted(kept))
        columns = {name: np.asarray(getattr(leg, name))[chosen] for name in named_channels(leg)}
        return Path(time=None if leg.time is None else leg.time[chosen], **columns)
    return replace(leg, steps=4 * leg.cycles if isinstance(leg, Cycle) else 1)
