"""Contacts that are moved step by step on the branches of a curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from pymdr.line.following import layout as at
from pymdr.line.following.branches import Columns, inverse_of
from pymdr.line.following.paths import follow
from pymdr.line.following.tracks import Index, Track
from pymdr.line.moved import NOW, BoolArray, IntArray, Moved, WithoutShift
from pymdr.units import FloatArray

_UP, _DOWN, _TOUCH = range(3)


class _DiskStates(Protocol):
    """States of disks."""

    @property
    def contact_radius(self) -> FloatArray:
        """In m."""


class Disks(Protocol):
    """Equilibria of disks under a law."""

    def states(self, s: FloatArray) -> _DiskStates:
        """Return the states at s."""

    def slopes(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds and dF/ds."""

    def energies(self, s: FloatArray, indentation: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the elastic and the surface energy in J of states at s with indentations in m."""


StatesOf = Callable[[FloatArray, FloatArray, Index], tuple[FloatArray, Disks]]
"""From parameters, indentations in m and directions of edges (0 at rest) to parameters on a curve with that states."""


def tabulated_track(track: Track, columns: Columns) -> FloatArray:
    """
    The branches of a curve as compiled steps read them.

    Parameters
    ----------
    track : Track
        The curve, traced.
    columns : callable
        Of s and D: the force, and for an edge that rests also its radius, its stiffness and D of its state on the other curve.

    Returns
    -------
    ndarray
        See :mod:`pymdr.line.following.layout`.
    """
    curve = track.curve
    inverse = inverse_of(curve.control, track.bottom, track.top, np.array(sorted(curve.knots)), columns)
    cells = inverse.table.packed
    branches = np.zeros((track.low.size + 1, 12))
    branches[:-1, at.LOW], branches[:-1, at.HIGH] = track.low, track.high
    branches[:-1, at.BOTTOM], branches[:-1, at.TOP] = track.bottom, track.top
    of_branch = inverse.keys.astype(int)
    each = np.arange(track.low.size)
    branches[:-1, at.FIRST] = np.searchsorted(of_branch, each)
    branches[:-1, at.LAST] = np.searchsorted(of_branch, each, side="right") - 1
    branches[-1, at.LOW], branches[-1, at.HIGH] = -math.inf, np.nextafter(track.touch, -math.inf)
    for which, kind, first in (
        (slice(-1), _DOWN, at.DOWN_TO),
        (slice(-1), _UP, at.UP_TO),
        (slice(-1, None), _TOUCH, at.UP_TO),
    ):
        out = track.jumps[kind]
        jumps = (out.before != out.after) | (out.loss != 0.0)
        branches[which, first : first + 3] = np.column_stack([out.to, out.loss, jumps])
    segments = np.column_stack([inverse.table.low, inverse.table.high])
    first_cell = 1 + branches.shape[0] + segments.shape[0]
    rows = np.zeros((first_cell + cells.shape[0], max(12, cells.shape[1])))
    rows[0, : at.TERMS + 1] = (
        branches.shape[0],
        first_cell,
        cells.shape[0],
        inverse.table.coefficients.shape[0],
    )
    at_row = 1
    for part in (branches, segments, cells):
        rows[at_row : at_row + part.shape[0], : part.shape[1]] = part
        at_row += part.shape[0]
    return rows


class Branches(WithoutShift, Moved):
    """
    Contacts of one body on the stable branches of a curve, with jumps at their ends.

    What they remember: (n, 2, 7) columns of :mod:`pymdr.line.following.layout`.

    Parameters
    ----------
    rows : ndarray
        The branches, from :func:`tabulated_track`.
    states_of : callable
        The curve at the states of contacts.
    count : int
        Number of contacts.
    """

    _step: Any
    _step_all: Any

    def __init__(self, rows: FloatArray, states_of: StatesOf, count: int) -> None:
        from pymdr.line.following import steps

        self.rows, self._states_of = rows, states_of
        self._step, self._step_all = steps.step, steps.step_all
        self.arrays = (_free(count, at.PLAIN),)

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m; F_N in N, and 0."""
        return float(self._step(self.rows, self.arrays[0][0], depth)), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        force = np.empty(depth.shape)
        self.threads.run(lambda some: self._step_all(self.rows, self.arrays[0], depth, force, some))
        return force, np.zeros(depth.shape)

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self._now(at.DEPTH)

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._now(at.NORMAL)

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 for a free body."""
        s, curve = self._states
        return self._attached(curve.states(s).contact_radius)

    def radii(self, s: FloatArray) -> FloatArray:
        """Contact radii in m at parameters of the curve."""
        unknown = np.full(s.size, math.nan)
        return self._states_of(s, unknown, np.zeros(s.size, dtype=np.intp))[1].states(s).contact_radius

    @property
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness dF/dd in N/m."""
        s, curve = self._states
        depth, force = curve.slopes(s)
        with np.errstate(divide="ignore", invalid="ignore"):
            # at a touch without area both rates are 0
            return self._attached(np.where(force == 0.0, 0.0, force / depth))

    @property
    def elastic_energy(self) -> FloatArray:
        """In J."""
        s, curve = self._states
        return self._attached(curve.energies(s, self.indentation)[0])

    @property
    def surface_energy(self) -> FloatArray:
        """In J, below 0 in contact."""
        s, curve = self._states
        return self._attached(curve.energies(s, self.indentation)[1])

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J lost in jumps and by hysteresis so far."""
        return self._now(at.DISSIPATED)

    @property
    def jumped(self) -> BoolArray:
        """Whether the last step jumped."""
        return self._now(at.JUMPED) > 0.0

    @property
    def branch(self) -> IntArray:
        """Number of the stable branch, -1 for a free body."""
        return self._now(at.STATE).astype(np.intp)

    @property
    def touched(self) -> BoolArray:
        """Whether the bodies have been in contact."""
        return self._now(at.TOUCHED) > 0.0

    @property
    def _states(self) -> tuple[FloatArray, Disks]:
        moves = np.zeros(self.count) if self.arrays[0].shape[2] == at.PLAIN else self._now(at.MOVES)
        return self._states_of(self._now(at.AT), self._now(at.DEPTH), moves.astype(np.intp))

    def _attached(self, values: FloatArray) -> FloatArray:
        return np.where(self._now(at.STATE) == at.NO_CONTACT, 0.0, values)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self.arrays[0][:, NOW, column])


class HystereticTracks(NamedTuple):
    """The curves of an edge that advances and of one that recedes."""

    advancing: Track
    receding: Track
    rim: float
    """Parameter of a sharp edge."""
    per_area: float
    """Energy in J/m^2 lost where the edge recedes, beyond that of the receding curve."""
    least: float
    """Radius in m at the pull-off."""


class RestingBranches(Branches):
    """
    Contacts whose edge advances on one curve, recedes on another and rests in between.

    Parameters
    ----------
    tracks : HystereticTracks
    rows : tuple of ndarray
        The branches of both curves.
    states_of : callable
    count : int
    """

    def __init__(
        self, tracks: HystereticTracks, rows: tuple[FloatArray, FloatArray], states_of: StatesOf, count: int
    ) -> None:
        from pymdr.line.following import steps

        super().__init__(rows[0], states_of, count)
        self._tracks, self.both = tracks, (*rows, np.array(tracks[2:]))
        self._step, self._step_all = steps.step_resting, steps.step_all_resting
        self.arrays = (_free(count, at.SPENT + 1),)

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m; F_N in N, and 0."""
        ending, force = self._step(*self.both, self.arrays[0][0], depth, at.NOWHERE, 0.0)
        return (force if ending == at.COMPLETE else self._from_unstable(0, depth)), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        force, parts = np.empty(depth.shape), self.threads.parts
        every = *self.both, self.arrays[0], depth, force
        while parts:
            ends = self.threads.run(lambda some: self._step_all(*every, some), parts)
            unstable = [(i, end) for i, (_, end) in zip(ends, parts, strict=True) if i < end]
            for i, _ in unstable:
                force[i] = self._from_unstable(i, float(depth[i]))
            parts = [(i + 1, end) for i, end in unstable]
        return force, np.zeros(depth.shape)

    def _from_unstable(self, i: int, depth: float) -> float:
        """A step of an edge that rested in an unstable state of its curve, from which it jumps."""
        now = self.arrays[0][i, NOW]
        track = self._tracks.advancing if depth > now[at.RESTS_TO] else self._tracks.receding
        history = follow(track, [depth], float(now[at.AT]))
        reached, dissipated = float(history.branch[-1]), float(history.dissipated.sum())
        return float(self._step(*self.both, self.arrays[0][i], depth, reached, dissipated)[1])


def _free(count: int, columns: int) -> FloatArray:
    """Bodies that have not touched."""
    memory = np.zeros((count, 2, columns))
    memory[:, :, at.STATE], memory[:, :, at.AT] = at.NO_CONTACT, math.nan
    return memory
