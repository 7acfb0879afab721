"""Histories of one contact under displacement, force and mixed control, of several legs, and the state after any of their rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.driver import Control, depths_at_force, follow
from pymdr.line.friction.state import Ending, FrictionHistory, FrictionState, frozen, virgin_state
from pymdr.units import FloatArray


def follow_displacements(
    curves: ElasticCurves,
    indentation: ArrayLike,
    shift: ArrayLike,
    friction: float,
    tangential_modulus: float,
    *,
    start: FrictionState | None = None,
    keep: int | ArrayLike | None = None,
    checkpoints: Iterable[int] = (),
) -> FrictionHistory:
    """
    Follow rows of (indentation, shift), linear between rows.

    F_x = mu sum sigma_i [F_N(y_i) - F_N(y_(i-1))] with the slopes sigma_i of the anchor curve. At d <= 0 the
    contact is lost and the memory with it; it returns stress-free at the shift of first touch.

    Parameters
    ----------
    curves : ElasticCurves
        The elastic line.
    indentation, shift : array_like, shape (n,)
        d and u_x in m. The first row is reached from (0, 0) or from `start`.
    friction : float
        mu >= 0. At 0 nothing is carried; infinite means no slip: springs stick from their touch until they part.
    tangential_modulus : float
        G* in Pa.
    start : FrictionState, optional
        State to go on from, of the same friction and moduli.
    keep : int or array_like of int, optional
        Keep every k-th row (k - 1, 2 k - 1, ...) or the given rows; all by default.
    checkpoints : iterable of int, optional
        Rows after which the state is kept, as long as all of them hold at most 4e6 vertices.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> hertz = power_law_curves(2.0, 1.0, 1.0)
    >>> run = follow_displacements(hertz, [0.5, 0.5], [0.0, 0.25], friction=1.0, tangential_modulus=1.0)
    >>> [round(float(x), 6) for x in (run.tangential_force[-1], run.stick_radius[-1])]
    [0.304738, 0.5]
    """
    given = (frozen(indentation), frozen(shift))
    return follow(Control.SHIFT, curves, given, friction, tangential_modulus, start, keep, checkpoints)


def follow_forces(
    curves: ElasticCurves,
    normal_force: ArrayLike,
    tangential_force: ArrayLike,
    friction: float,
    tangential_modulus: float,
    *,
    start: FrictionState | None = None,
    keep: int | ArrayLike | None = None,
    checkpoints: Iterable[int] = (),
) -> FrictionHistory:
    """
    Follow rows of (F_N, F_x), straight between rows: the same stack in (F_N, F_x / mu).

    F_N is inverted only for d and u_x. A row with |F_x| > mu F_N (by more than 1e-12) ends the run. At the limit
    the contact slides by the least distance that reaches the force: not at all. Without slip such a
    path is straight in (d, u_x) too while F_N rises; while it falls, what parting springs release is integrated
    along the forces.

    Parameters
    ----------
    curves : ElasticCurves
        The elastic line.
    normal_force, tangential_force : array_like, shape (n,)
        F_N >= 0 and F_x in N. With F_N the shift goes to the anchor of the innermost spring.
    friction, tangential_modulus, start, keep, checkpoints
        As in :func:`follow_displacements`.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> hertz = power_law_curves(2.0, 1.0, 1.0)
    >>> run = follow_forces(hertz, [4 / 3, 4 / 3, 4 / 3], [0.0, 0.2, 0.5], 0.3, 1.0)
    >>> round(float(run.stick_radius[1]), 6), run.stopped, run.ending.name
    (0.793701, 2, 'NOT_ATTAINABLE')
    """
    given = (frozen(normal_force), frozen(tangential_force))
    return follow(Control.FORCE, curves, given, friction, tangential_modulus, start, keep, checkpoints)


def follow_load_with_shift(
    curves: ElasticCurves,
    normal_force: ArrayLike,
    shift: ArrayLike,
    friction: float,
    tangential_modulus: float,
    *,
    start: FrictionState | None = None,
    keep: int | ArrayLike | None = None,
    checkpoints: Iterable[int] = (),
) -> FrictionHistory:
    """
    Follow rows of (F_N, u_x), straight in (d, u_x) between rows.

    Parameters
    ----------
    curves : ElasticCurves
        The elastic line.
    normal_force : array_like, shape (n,)
        F_N >= 0 in N.
    shift : array_like, shape (n,)
        u_x in m.
    friction, tangential_modulus, start, keep, checkpoints
        As in :func:`follow_displacements`.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> hertz = power_law_curves(2.0, 1.0, 1.0)
    >>> run = follow_load_with_shift(hertz, [4 / 3, 4 / 3], [0.0, 0.5], 0.3, 1.0)
    >>> [round(float(x), 9) for x in (run.indentation[1], run.tangential_force[1])]
    [1.0, 0.4]
    """
    force = frozen(normal_force)
    given = (frozen(depths_at_force(curves, force)), frozen(shift))
    run = follow(Control.SHIFT, curves, given, friction, tangential_modulus, start, keep, checkpoints)
    if run.ending is Ending.NOT_FINITE and np.isfinite([force[run.stopped], given[1][run.stopped]]).all():
        ending = Ending.NOT_ATTAINABLE if force[run.stopped] < 0.0 else Ending.TOO_DEEP
        return replace(run, ending=ending)
    return run


def follow_indentation_with_force(
    curves: ElasticCurves,
    indentation: ArrayLike,
    tangential_force: ArrayLike,
    friction: float,
    tangential_modulus: float,
    *,
    start: FrictionState | None = None,
    keep: int | ArrayLike | None = None,
    checkpoints: Iterable[int] = (),
) -> FrictionHistory:
    """
    Follow rows of (d, F_x), straight in (d, u_x) between rows.

    The shift at the end of a row is read off the stack: the force rises with it, and the segment on which the
    border of slip comes to rest is found by descending the vertices, then in closed form.

    Parameters
    ----------
    curves : ElasticCurves
        The elastic line.
    indentation : array_like, shape (n,)
        d in m; without contact the shift stays where it is.
    tangential_force : array_like, shape (n,)
        F_x in N, |F_x| <= mu F_N(d).
    friction, tangential_modulus, start, keep, checkpoints
        As in :func:`follow_displacements`.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> hertz = power_law_curves(2.0, 1.0, 1.0)
    >>> run = follow_indentation_with_force(hertz, [1.0, 1.0], [0.0, 0.2], 0.3, 1.0)
    >>> round(float(run.shift[1]), 9)
    0.111011843
    """
    given = (frozen(indentation), frozen(tangential_force))
    return follow(Control.PULL, curves, given, friction, tangential_modulus, start, keep, checkpoints)


_CHECKPOINTS = 64
"""Number of states stored along a leg."""


@dataclass(frozen=True, eq=False)
class FrictionLeg:
    """Rows that are prescribed in two channels."""

    by_normal_force: bool
    """Whether `normal` is a force in N, not an indentation in m."""
    by_tangential_force: bool
    """Whether `tangential` is a force in N, not a shift in m."""
    normal: FloatArray
    tangential: FloatArray


def follow_leg(
    curves: ElasticCurves,
    leg: FrictionLeg,
    friction: float,
    tangential_modulus: float,
    start: FrictionState,
    keep: ArrayLike | None = None,
    checkpoints: Iterable[int] = (),
) -> FrictionHistory:
    """
    Follow one leg by the stack of its control.

    Parameters
    ----------
    friction, tangential_modulus, start, keep, checkpoints
        As in :func:`~pymdr.line.friction.follow_displacements`.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> leg = FrictionLeg(True, False, np.array([4 / 3]), np.array([0.0]))
    >>> float(follow_leg(power_law_curves(2.0, 1.0, 1.0), leg, 0.3, 1.0, virgin_state(0.3, 1.0)).indentation[0])
    1.0
    """
    follow = {
        (False, False): follow_displacements,
        (True, False): follow_load_with_shift,
        (False, True): follow_indentation_with_force,
        (True, True): follow_forces,
    }[leg.by_normal_force, leg.by_tangential_force]
    return follow(
        curves,
        leg.normal,
        leg.tangential,
        friction,
        tangential_modulus,
        start=start,
        keep=keep,
        checkpoints=checkpoints,
    )


@dataclass
class Replay:
    """
    The state after any row of a history, recomputed from the nearest stored state.

    Parameters
    ----------
    curves : ElasticCurves
        Deep enough for every leg.
    friction, tangential_modulus : float
        mu and G* in Pa.
    """

    curves: ElasticCurves
    legs: tuple[FrictionLeg, ...]
    friction: float
    tangential_modulus: float
    _remembered: dict[tuple[int, int], FrictionState] = field(default_factory=dict)

    def state(self, row: int) -> FrictionState:
        """
        The state after a row, counted over all legs.

        Parameters
        ----------
        row : int
            0 to the number of rows less 1.
        """
        which = 0
        while row >= self.legs[which].normal.size:
            row -= self.legs[which].normal.size
            which += 1
        for i in range(which):
            if (i, self.legs[i].normal.size) not in self._remembered:
                self._run(i, self.legs[i].normal.size)
        return self._run(which, row + 1)

    def _run(self, which: int, stop: int) -> FrictionState:
        """Follow leg `which` up to its row `stop`, from the nearest stored state."""
        if which == 0:
            first = virgin_state(self.friction, self.curves.modulus / self.tangential_modulus)
        else:
            first = self._remembered[which - 1, self.legs[which - 1].normal.size]
        known = [n for (i, n) in self._remembered if i == which and n <= stop]
        begin = max(known, default=0)
        start = self._remembered[which, begin] if known else first
        if begin == stop:
            return start
        leg = self.legs[which]
        part = FrictionLeg(
            leg.by_normal_force, leg.by_tangential_force, leg.normal[begin:stop], leg.tangential[begin:stop]
        )
        stride = max(1, (stop - begin) // _CHECKPOINTS)
        marks = range(stride - 1, stop - begin, stride) if stop == leg.normal.size else ()
        run = follow_leg(
            self.curves, part, self.friction, self.tangential_modulus, start, np.zeros(0, dtype=int), marks
        )
        self._remembered |= {(which, begin + n + 1): state for n, state in run.checkpoints.items()}
        self._remembered[which, stop] = run.state
        return run.state
