"""Runs the compiled kernels: grows the stack, stops at checkpoints, keeps rows. Loads numba when it runs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import PathError
from pymdr.line.curves import touching_part
from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.layout import STACK_FULL, TOP
from pymdr.line.friction.state import Ending, FrictionHistory, FrictionState, frozen, virgin_state
from pymdr.numerics.graded import GradedTable
from pymdr.numerics.graded.layout import IntArray
from pymdr.units import FloatArray


class Control(Enum):
    """Channels that the rows of a run prescribe."""

    SHIFT = 0
    """(d, u_x)"""
    PULL = 1
    """(d, F_x)"""
    FORCE = 2
    """(F_N, F_x)"""


ENDINGS = (Ending.COMPLETE, Ending.NOT_FINITE, Ending.NOT_ATTAINABLE, Ending.TOO_DEEP)
_MOST_STORED = 4_000_000
"""Vertices that all checkpoints of a run may hold together."""


def evaluate(curves: ElasticCurves, depth: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Contact radius, normal force and its integral at given depths.

    Parameters
    ----------
    curves : ElasticCurves
    depth : array_like
        In m; 0 is returned below 0, NaN beyond a table.

    Returns
    -------
    contact_radius, normal_force, work : ndarray
        a in m, F_N in N, W = int_0^d F_N in J.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> [float(x[0]) for x in evaluate(power_law_curves(2.0, 1.0, 0.75), [1.0])]
    [1.0, 1.0, 0.4]
    """
    d = np.asarray(depth, dtype=float)
    n = curves.exponent
    if n <= 0.0:
        a, force, work = GradedTable(curves.rows, curves.misfit)(d)
        return a, force, work
    d = np.maximum(d, 0.0)
    a = curves.unit * np.asarray((d / curves.coefficient) ** (1.0 / n))
    force = 2.0 * n / (n + 1.0) * curves.modulus * a * d
    return a, force, n / (2.0 * n + 1.0) * force * d


def depths_at_force(curves: ElasticCurves, normal_force: ArrayLike) -> FloatArray:
    """
    Indentation from the normal force, F_N(d) = F.

    Parameters
    ----------
    curves : ElasticCurves
    normal_force : array_like
        In N.

    Returns
    -------
    ndarray
        d in m; NaN below 0 and beyond a table.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> depths_at_force(power_law_curves(2.0, 1.0, 0.75), [0.0, 1.0]).tolist()
    [0.0, 1.0]
    """
    from pymdr.line.friction.runs import invert_all

    force = frozen(normal_force)
    out = np.empty(force.size)
    invert_all(curves.rows, force.ravel(), out)
    return out.reshape(np.shape(normal_force))


def follow(
    control: Control,
    curves: ElasticCurves,
    given: tuple[FloatArray, FloatArray],
    friction: float,
    tangential_modulus: float,
    start: FrictionState | None,
    keep: int | ArrayLike | None,
    checkpoints: Iterable[int],
) -> FrictionHistory:
    """Follow rows of the channels of `control`; see :mod:`pymdr.line.friction.histories`."""
    ratio = curves.modulus / tangential_modulus
    state = virgin_state(friction, ratio) if start is None else start
    if (state.friction, state.modulus_ratio) != (friction, ratio):
        raise PathError(
            f"friction {friction:g} and E*/G* {ratio:g} differ from those of the initial state, "
            f"{state.friction:g} and {state.modulus_ratio:g}: a state can be continued with the same contact only"
        )
    if given[0].shape != given[1].shape or given[0].ndim != 1:
        raise PathError(f"two rows of equal length are needed, not {given[0].shape} and {given[1].shape}")
    count = given[0].size
    run = (_Frictionless if friction == 0.0 else _Stack)(control, curves, given, state, _kept(keep, count))
    states: dict[int, FrictionState] = {}
    stored = 0
    for row in sorted(set(checkpoints)):
        run.advance(row + 1)
        if run.row == row + 1 and stored + run.vertices <= _MOST_STORED:
            states[row] = run.state()
            stored += run.vertices
    run.advance(count)
    return run.history(states)


def opposed_parts(
    curves: ElasticCurves,
    indentation: ArrayLike,
    shift: ArrayLike,
    friction: float,
    tangential_modulus: float,
) -> FloatArray:
    """
    Magnitudes of all parts of the tangential force and of its stored energy over those of their sums.

    Parameters
    ----------
    curves, indentation, shift, friction, tangential_modulus
        As in :func:`~pymdr.line.friction.follow_displacements`, with friction above 0 and finite.

    Returns
    -------
    ndarray of shape (2, n)
        At least 1, inf where all parts cancel; NaN from a row on that cannot be followed.

    Notes
    -----
    F_x = mu sum s [F(y_i) - F(y_(i-1))] and U = mu^2 E*/G* sum int t s dF over the segments of the stack, with the normalised
    shift t = v - b of the springs. Errors of the curve add up by magnitudes, where the parts may cancel.

    Examples
    --------
    >>> from pymdr.line.friction import opposed_parts, power_law_curves
    >>> hertz = power_law_curves(2.0, 1.0, 1.0)
    >>> opposed_parts(hertz, [1.0, 1.0, 1.0], [0.0, 0.5, 0.2], 0.5, 1.0)[0].round(3).tolist()
    [1.0, 1.0, 5.837]
    """
    from pymdr.line.friction import runs

    state = virgin_state(friction, curves.modulus / tangential_modulus)
    run = _Stack(Control.SHIFT, curves, (frozen(indentation), frozen(shift)), state, None)
    run.kernel = runs.run_opposed
    run.advance(run.out.shape[1])
    run.out[:, run.row :] = math.nan
    return run.out[:2]


def _kept(keep: int | ArrayLike | None, count: int) -> IntArray | None:
    if keep is None:
        return None
    if isinstance(keep, int | np.integer):
        return np.arange(keep - 1, count, keep, dtype=np.int64)
    rows = np.unique(np.asarray(keep, dtype=np.int64))
    if rows.size and not (rows[0] >= 0 and rows[-1] < count):
        raise PathError(
            f"keep: rows {rows[0]} to {rows[-1]} are requested, but the history has rows 0 to {count - 1}; give rows within it"
        )
    return rows


class _Run(ABC):
    """A run in progress: rows [0, row) are done."""

    def __init__(
        self,
        control: Control,
        curves: ElasticCurves,
        given: tuple[FloatArray, FloatArray],
        start: FrictionState,
        rows: IntArray | None,
    ) -> None:
        self.control, self.curves, self.given, self.start = control, curves, given, start
        self.every = rows is None
        self.rows = np.zeros(0, dtype=np.int64) if rows is None else rows
        kept = given[0].size if rows is None else rows.size
        self.out = np.zeros((5 if control is Control.SHIFT else 7, kept))
        self.row = self.column = 0
        self.ending = Ending.COMPLETE

    @abstractmethod
    def advance(self, stop: int) -> None:
        """Follow rows up to `stop`."""

    @abstractmethod
    def state(self) -> FrictionState:
        """State after the last row followed."""

    @property
    def vertices(self) -> int:
        """Vertices of that state."""
        return 2

    def history(self, checkpoints: dict[int, FrictionState]) -> FrictionHistory:
        out = self.out
        out[:, self.column :] = math.nan
        kept = None if self.every else self.rows
        force: FloatArray = out[0]
        if self.control is Control.SHIFT:
            depth, shift = self.given if kept is None else (x[kept] for x in self.given)
        else:
            depth, shift = out[5], out[6]
            force = np.where(
                np.isnan(out[0]), math.nan, self.given[1] if kept is None else self.given[1][kept]
            )
        return FrictionHistory(
            kept=kept,
            indentation=depth,
            shift=shift,
            tangential_force=force,
            stick_radius=out[1],
            stored_energy=out[2],
            slip_work=out[3],
            slip_distance=out[4],
            state=self.state(),
            checkpoints=checkpoints,
            ending=self.ending,
            stopped=self.row,
            slip_work_before=self.start.slip_work,
        )


class _Stack(_Run):
    """A run of the memory stack, with slip or without."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        from pymdr.line.friction import kernels, noslip, runs

        start = self.start
        scales = runs.Scales(start.traction_scale, start.energy_scale, start.shift_scale)
        top = start.slope.size
        stack = np.zeros(max(64, 2 * top), dtype=kernels.VERTEX)
        memory = [
            start.indentation,
            start.b[-1],
            start.slip_work / scales.energy,
            0.0,
            start.slip_distance / scales.shift,
            top,
        ]
        self.progress = runs.Run(
            kernels.Anchors(self.curves.rows, stack, np.array(memory)),
            self.out,
            self.rows,
            self.every,
            scales,
        )
        vertices = (frozen(start.y), frozen(start.b))
        self.kernel: Callable[..., tuple[int, int, int]]
        self.option: tuple[Any, ...] = ()
        if not math.isfinite(start.friction):
            noslip.restore_stuck(self.progress.anchors, *vertices)
            self.kernel, self.option = noslip.run_stuck, (self.control.value,)
            return
        runs.restore(self.progress.anchors, *vertices, frozen(start.slope))
        self.kernel = runs.run_displacements
        if self.control is not Control.SHIFT:
            self.kernel, self.option = runs.run_forces, (self.control is Control.FORCE,)

    def advance(self, stop: int) -> None:
        while self.ending is Ending.COMPLETE and self.row < stop:
            span = (self.row, stop, self.column)
            code, self.row, self.column = self.kernel(self.progress, *self.given, span, *self.option)
            if code == STACK_FULL:
                stack = self.progress.anchors.stack
                larger = np.zeros(2 * stack.size, dtype=stack.dtype)
                larger[: stack.size] = stack
                self.progress = self.progress._replace(anchors=self.progress.anchors._replace(stack=larger))
            else:
                self.ending = ENDINGS[code]

    @property
    def vertices(self) -> int:
        return int(self.progress.anchors.memory[TOP]) + 1

    def state(self) -> FrictionState:
        depth, shift, work, _, slide, top = self.progress.anchors.memory.tolist()
        vertices = self.progress.anchors.stack[: int(top) + 1]
        start = self.start
        return FrictionState(
            frozen(vertices["y"].copy()),
            frozen(vertices["b"].copy()),
            frozen(vertices["slope"][1:].copy()),
            depth,
            shift * start.shift_scale,
            start.friction,
            start.modulus_ratio,
            work * self.progress.scales.energy,
            slide * start.shift_scale,
            start.rows + self.row,
        )


class _Frictionless(_Run):
    """A run without friction (mu = 0): no tangential force, and the whole contact slides with the body."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        depth, second = self.given
        finite = np.isfinite(depth) & np.isfinite(second)
        if self.control is Control.FORCE:
            force, depth = depth, depths_at_force(self.curves, depth)
        attainable = np.ones(depth.size, dtype=bool)
        shift = second
        if self.control is not Control.SHIFT:
            attainable = second == 0.0
            shift = np.full(depth.size, self.start.shift)
        if self.control is Control.FORCE:
            attainable &= ~(force < 0.0)
        fails = [
            (~finite, Ending.NOT_FINITE),
            (~attainable, Ending.NOT_ATTAINABLE),
            (~(depth <= self.curves.depth * (1.0 + 1e-14)), Ending.TOO_DEEP),
        ]
        bad = np.logical_or.reduce([mask for mask, _ in fails])
        self.end = int(np.argmax(bad)) if bad.any() else depth.size
        if bad.any():
            self.at_end = next(ending for mask, ending in fails if mask[self.end])
        self.depth, self.shift = depth[: self.end], shift[: self.end]
        before = np.concatenate([[self.start.indentation], self.depth[:-1]])[: self.end]
        moved = np.abs(np.diff(self.shift, prepend=self.start.shift))
        self.slid = self.start.slip_distance + np.cumsum(moved * touching_part(before, self.depth))

    def advance(self, stop: int) -> None:
        first, self.row = self.row, min(stop, self.end)
        if stop > self.end:
            self.ending = self.at_end
        rows = np.arange(first, self.row)
        if not self.every:
            rows = self.rows[(self.rows >= first) & (self.rows < self.row)]
        columns = slice(self.column, self.column + rows.size)
        self.column += rows.size
        self.out[:4, columns] = 0.0
        self.out[4, columns] = self.slid[rows]
        if self.control is not Control.SHIFT:
            self.out[5, columns] = self.depth[rows]
            self.out[6, columns] = self.shift[rows]

    def state(self) -> FrictionState:
        start = self.start
        if self.row == 0:
            return start
        depth, shift = float(self.depth[self.row - 1]), float(self.shift[self.row - 1])
        y = np.array([0.0, depth] if depth > 0.0 else [0.0])
        return FrictionState(
            frozen(y),
            frozen(np.zeros(y.size)),
            frozen(np.zeros(y.size - 1)),
            depth,
            shift,
            start.friction,
            start.modulus_ratio,
            0.0,
            float(self.slid[self.row - 1]),
            start.rows + self.row,
        )
