"""Follow a path between two curves: the edge advances on one of them, recedes on the other, and rests between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import PathError
from pymdr.line.following.audit import energy_residual
from pymdr.line.following.paths import Exits, History, Jumps, follow
from pymdr.line.following.tracks import Index, Track
from pymdr.units import FloatArray

REST, ADVANCE, RECEDE = 0, 1, -1


class Edge(NamedTuple):
    """An edge between two paths."""

    parameter: float
    direction: int
    """In which it moved last."""
    control: float | None
    """D at which it stopped, to the last bit; None where its curve must tell."""

    def under(self, *, same: bool) -> Edge:
        """The edge at the start of a path of the same control, or of another."""
        return self if same else self._replace(control=None)

    def rest(self, advancing: Track, receding: Track, rim: float) -> tuple[float, float]:
        """Lowest and highest D at which it rests."""
        low, high = (float(t.curve.control(np.array([self.parameter]))[0]) for t in (receding, advancing))
        if self.control is not None:
            low, high = (low, self.control) if self.direction == ADVANCE else (self.control, high)
        return low, np.inf if self.parameter >= rim else high


@dataclass(frozen=True)
class Motion:
    """Rows in which the edge moves in one direction.

    Attributes
    ----------
    first : int
        Its first row.
    direction : int
        1 where the edge advances, -1 where it recedes.
    history : History
        Its states on the curve of that direction.
    """

    first: int
    direction: int
    history: History


@dataclass(frozen=True)
class EdgeHistory:
    """The states of a path between two curves, one entry per row.

    Attributes
    ----------
    control : ndarray
        D.
    parameter : ndarray
        s of the edge; NaN for a free body.
    direction : ndarray of int
        1 where the edge advanced to its state, -1 where it receded, 0 where it rests or the body is free.
    motions : tuple of Motion
        What was followed on the two curves.
    end : Edge or None
        The edge at the end; None for a free body.
    """

    control: FloatArray
    parameter: FloatArray
    direction: Index
    motions: tuple[Motion, ...]
    end: Edge | None

    @property
    def attached(self) -> NDArray[np.bool_]:
        """Whether the bodies are in contact."""
        return np.isfinite(self.parameter)

    @property
    def jumped(self) -> NDArray[np.bool_]:
        """Whether the state jumped inside the step."""
        return self._spread("jumped") > 0.0

    @property
    def dissipated(self) -> FloatArray:
        """Energy dissipated by jumps inside the step [J]."""
        return self._spread("dissipated")

    @property
    def receded(self) -> NDArray[np.bool_]:
        """Whether the edge receded inside the step, also out of contact."""
        receded = np.zeros(self.control.size, dtype=np.bool_)
        for m in self.motions:
            receded[m.first : m.first + m.history.control.size] = m.direction == RECEDE
        return receded

    def _spread(self, name: str) -> FloatArray:
        """Return a column of the motions over all rows, 0 at rest."""
        values = np.zeros(self.control.size)
        for m in self.motions:
            values[m.first : m.first + m.history.control.size] = getattr(m.history, name)
        return values

    @property
    def jumps(self) -> Jumps:
        """All jumps in their order."""
        parts = [
            (m.first + m.history.jumps.step, *(getattr(m.history.jumps, n) for n in _JUMP[1:]))
            for m in self.motions
        ]
        if not parts:
            return Jumps(np.zeros(0, dtype=np.intp), *(np.zeros(0) for _ in _JUMP[1:]))
        return Jumps(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def residual(self, advancing: Track, receding: Track) -> float:
        """Return the largest relative residual of the energy balance of its motions; rest is exact."""
        tracks = {ADVANCE: advancing, RECEDE: receding}
        return max((energy_residual(tracks[m.direction], m.history) for m in self.motions), default=0.0)


_JUMP = ("step", "control", "before", "after", "loss")


def follow_with_hysteresis(
    advancing: Track,
    receding: Track,
    control: ArrayLike,
    initial: Edge | None = None,
    rim: float = np.inf,
) -> EdgeHistory:
    """Follow a path of the control coordinate, straight between its values, with an edge that may rest.

    Parameters
    ----------
    advancing, receding : Track
        The curves D_adv(s) and D_rec(s) <= D_adv(s) of an edge that advances and recedes, traced.
    control : array_like
        D of every row.
    initial : Edge, optional
        The edge before the first row; without it the body is free.
    rim : float
        Parameter of a sharp edge, beyond which the edge of the contact cannot advance; there it rests.

    Returns
    -------
    EdgeHistory
        The edge rests while D_rec(s) <= D <= D_adv(s); the bound on the curve of its last motion is the D at which it stopped, so that a
        path that returns there leaves it at rest.

    Raises
    ------
    PathError
        When the path leads beyond the known curves, or is not finite.

    Examples
    --------
    >>> from pymdr.line.following import Curve, trace
    >>> def line(level):
    ...     return trace(Curve(lambda s: s + level, np.ones_like, lambda s: (s + level)**2 / 2, start=0.0, stop=9.0))
    >>> history = follow_with_hysteresis(line(0.0), line(-1.0), [2.0, 1.5, 0.5, 1.0, 3.0])
    >>> history.parameter, history.direction
    (array([2. , 2. , 1.5, 1.5, 3. ]), array([ 1,  0, -1,  0,  1]))
    """
    D = np.array(control, dtype=np.float64)
    if D.ndim != 1 or D.size == 0 or not np.all(np.isfinite(D)):
        raise PathError("a path must be a one-dimensional array of at least one value, all finite")
    parameter, direction = np.full(D.size, np.nan), np.zeros(D.size, dtype=np.intp)
    motions: list[Motion] = []
    exits, row, edge = Exits(D), 0, initial
    while row < D.size:
        low, high = -np.inf, float(np.nextafter(advancing.touch, -np.inf))
        if edge is not None:
            low, high = edge.rest(advancing, receding, rim)
        first = exits.after(row, low, high)
        parameter[row:first] = np.nan if edge is None else edge.parameter
        if first == D.size:
            break
        moves = ADVANCE if D[first] > high else RECEDE
        row = exits.turn(first, upward=moves == ADVANCE)
        start = None if edge is None else edge.parameter
        history = follow(advancing if moves == ADVANCE else receding, D[first:row], start)
        motions.append(Motion(first, moves, history))
        parameter[first:row] = np.minimum(history.parameter, rim)
        direction[first:row] = np.where(history.attached & (history.parameter < rim), moves, REST)
        edge = Edge(float(parameter[row - 1]), moves, float(D[row - 1])) if history.attached[-1] else None
    return EdgeHistory(D, parameter, direction, tuple(motions), edge)
