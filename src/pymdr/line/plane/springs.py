"""Springs in the plane: their places on a line, their state, and the rows of a leg."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from pymdr.line.curves import Curve, touching_part
from pymdr.units import FloatArray


class PlaneEnding(Enum):
    """How a run ended."""

    COMPLETE = "all rows were followed"
    NOT_ATTAINABLE = (
        "a row prescribes a tangential force of mu F_N or more; reduce it, or prescribe the shift"
    )
    NOT_CONVERGED = "the shift at a tangential force was not found; use more rows, or prescribe the shift"


@dataclass(frozen=True, eq=False)
class Springs:
    """
    Springs of equal stiffness along one half of a line.

    Attributes
    ----------
    label : ndarray, shape (n + 1,), m
        Indentation at which each touches; the first is the middle of the line, which carries nothing.
    place : ndarray, shape (n + 1,), m
        Distance from the middle: the first at 0, the others in the middles of n equal cells.
    """

    label: FloatArray
    place: FloatArray

    @property
    def spacing(self) -> float:
        """Length in m of the cell of a spring."""
        return float(2.0 * self.place[1])

    @classmethod
    def along(cls, line: Curve, radius: float, n: int) -> Springs:
        """
        `n` springs up to a contact radius in m.

        Parameters
        ----------
        line : Curve
            Its d0(a) gives the labels.
        radius : float
            The largest contact radius of the history.
        n : int
            At least 2.
        """
        place = radius / n * np.concatenate([[0.0], np.arange(n) + 0.5])
        label = np.asarray(line.depth(place), dtype=float)
        label[0] = min(label[0], label[1])
        return cls(np.maximum.accumulate(label), place)


@dataclass(frozen=True, eq=False)
class PlaneState:
    """
    The springs after a row.

    Attributes
    ----------
    vector : ndarray, shape (2, n + 1), m
        q / (mu E*) of every spring along x and y; q / E* without slip.
    indentation : float, m
    shift : ndarray, shape (2,), m
        Normalised shift G* u / (mu E*).
    slip_work, slip_distance : float
        So far, in the units of the kernel.
    """

    vector: FloatArray
    indentation: float
    shift: FloatArray
    slip_work: float = 0.0
    slip_distance: float = 0.0


def virgin_plane(springs: Springs) -> PlaneState:
    """The state before the first row: no contact, no shift."""
    return PlaneState(np.zeros((2, springs.label.size)), 0.0, np.zeros(2))


@dataclass(frozen=True, eq=False)
class PlaneRows:
    """
    The rows of a leg, in SI units; those that were not followed are NaN.

    Attributes
    ----------
    shift, force : ndarray, shape (m, 2), m and N
    stored, slip_work : ndarray, shape (m,), J
        Energy of the springs, and work of friction since the beginning by its own sum.
    stick_radius, slip_distance : ndarray, shape (m,), m
    """

    shift: FloatArray
    force: FloatArray
    stored: FloatArray
    slip_work: FloatArray
    stick_radius: FloatArray
    slip_distance: FloatArray


@dataclass(frozen=True)
class PlaneLaw:
    """Constants of the springs: mu (infinite without slip), E* and G* in Pa."""

    friction: float
    modulus: float
    tangential_modulus: float

    @property
    def scale(self) -> float:
        """Mu, or 1 without slip: traction per pressure of the springs' vectors."""
        return self.friction if math.isfinite(self.friction) else 1.0

    @property
    def shift_scale(self) -> float:
        """Shift u per normalised shift, mu E* / G*; E* / G* for mu = 0, where no spring carries any."""
        return (self.scale or 1.0) * self.modulus / self.tangential_modulus


def follow_plane(
    law: PlaneLaw,
    springs: Springs,
    depth: FloatArray,
    radius: FloatArray,
    target: FloatArray,
    state: PlaneState,
    load: FloatArray | None = None,
) -> tuple[PlaneRows, PlaneState, PlaneEnding]:
    """
    Follow the rows of a leg with springs of vectors q, straight in (d, u) between rows.

    dq = G* du while |q| < mu E* (d - y), else the spring slips along q. Every spring advances exactly over a row.

    Parameters
    ----------
    depth, radius : ndarray, shape (m,), m
        Indentation and contact radius of every row.
    target : ndarray, shape (m, 2)
        Shift u in m, or with `load` the tangential force in N, along x and y.
    state : PlaneState
        Before the first row.
    load : ndarray, shape (m,), N, optional
        Normal force of every row, if forces are prescribed: these are possible below mu F_N.

    Returns
    -------
    PlaneRows, PlaneState, PlaneEnding
        The state after the last row that was followed.

    Notes
    -----
    Popov and Hess (2015), chapter 5, for the springs; the advance over a straight row is a closed form.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> springs = Springs.along(ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0), 1.0, 400)
    >>> law, d, a = PlaneLaw(0.3, 1.0, 1.0), np.array([1.0, 1.0]), np.array([1.0, 1.0])
    >>> rows, _, _ = follow_plane(law, springs, d, a, np.array([[0.0, 0.0], [0.3, 0.4]]), virgin_plane(springs))
    >>> (rows.force[1] / 0.4).round(4).tolist()
    [0.6, 0.8]
    """
    from pymdr.line.plane import kernels as k

    if law.friction == 0.0:
        return _frictionless(depth, target, state, load is not None)
    per_shift = law.shift_scale
    per_force = 2.0 * law.scale * law.modulus * springs.spacing
    line = np.stack([springs.label, springs.place])
    slips, rows = math.isfinite(law.friction), np.full((depth.size, 8), math.nan)
    ratio, ending = np.ones((depth.size, 1)), PlaneEnding.COMPLETE
    if load is None:
        state = _moved(line, depth, radius, target / per_shift, state, (rows, slips))
    else:
        if slips:  # the springs carry mu F_N but for their number
            ratio = _shares(springs, depth, load / (2.0 * law.modulus * springs.spacing))[:, None]
        state, ending = _pulled(line, depth, radius, ratio * target / per_force, state, (rows, slips))
    per_energy = per_force * per_shift
    return (
        PlaneRows(
            shift=per_shift * rows[:, [k.SHIFT_X, k.SHIFT_Y]],
            force=per_force * rows[:, [k.FORCE_X, k.FORCE_Y]] / ratio,
            stored=per_energy * rows[:, k.STORED],
            slip_work=per_energy * rows[:, k.WORK],
            stick_radius=rows[:, k.STICK],
            slip_distance=per_shift * rows[:, k.SLID],
        ),
        state,
        ending,
    )


def _frictionless(
    depth: FloatArray, target: FloatArray, state: PlaneState, pulled: bool
) -> tuple[PlaneRows, PlaneState, PlaneEnding]:
    """Rows without friction (mu = 0), as far as no force is prescribed: the whole contact slides with the body, in m."""
    shift = np.tile(state.shift, (depth.size, 1)) if pulled else target
    moved = np.hypot(*np.diff(shift, axis=0, prepend=state.shift[None]).T)
    slid = state.slip_distance + np.cumsum(
        moved * touching_part(np.append(state.indentation, depth[:-1]), depth)
    )
    none = np.zeros(depth.size)
    columns = np.column_stack([shift, np.zeros(shift.shape), none, none, none, slid])
    carried = np.logical_and.accumulate(~(target.any(axis=1) & pulled))
    columns[~carried] = math.nan
    rows = PlaneRows(columns[:, :2], columns[:, 2:4], *columns[:, 4:].T)
    ending = PlaneEnding.COMPLETE if carried.all() else PlaneEnding.NOT_ATTAINABLE
    last = PlaneState(state.vector, float(depth[-1]), shift[-1], 0.0, float(slid[-1]))
    return rows, last, ending


Filled = tuple[FloatArray, bool]
"""Columns of the kernel, to be filled, and whether springs slip."""


def _moved(
    line: FloatArray,
    depth: FloatArray,
    radius: FloatArray,
    shift: FloatArray,
    state: PlaneState,
    filled: Filled,
) -> PlaneState:
    """The state after rows of shifts."""
    from pymdr.line.plane import kernels as k

    rows, slips = filled
    vectors = state.vector.copy()
    so_far = (state.slip_work, state.slip_distance)
    begin = np.array([state.indentation, *state.shift, *so_far])
    ahead = np.empty((3, line.shape[1]))
    k.run(line, vectors, np.stack([depth, radius]), np.array(shift), begin, rows, ahead, slips)
    last = rows[-1]
    return PlaneState(
        vectors,
        float(depth[-1]),
        last[[k.SHIFT_X, k.SHIFT_Y]],
        *last[[k.WORK, k.SLID]].tolist(),
    )


def _pulled(
    line: FloatArray,
    depth: FloatArray,
    radius: FloatArray,
    force: FloatArray,
    state: PlaneState,
    filled: Filled,
) -> tuple[PlaneState, PlaneEnding]:
    """The state after rows of forces, as far as they were followed."""
    from pymdr.line.plane import kernels as k

    rows, slips = filled
    labels, wanted = line[0].copy(), np.array(force)
    for i, after in enumerate(depth.tolist()):
        x, y, ending = k.moved_to(labels, state.vector, state.indentation, after, wanted[i], slips)
        if ending != k.COMPLETE:
            return state, list(PlaneEnding)[ending]
        one = slice(i, i + 1)
        shift = state.shift + np.array([[x, y]])
        state = _moved(line, depth[one], radius[one], shift, state, (rows[one], slips))
    return state, PlaneEnding.COMPLETE


def _shares(springs: Springs, depth: FloatArray, load: FloatArray) -> FloatArray:
    """What the springs carry at every depth over a load in their units; 1 without load."""
    labels = springs.label[1:]
    touching = np.searchsorted(labels, depth)
    carried = touching * depth - np.concatenate([[0.0], np.cumsum(labels)])[touching]
    loaded = (load > 0.0) & (carried > 0.0)
    return np.where(loaded, carried, 1.0) / np.where(loaded, load, 1.0)
