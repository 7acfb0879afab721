"""Histories of several legs, and the state after any of their rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.histories import (
    follow_displacements,
    follow_forces,
    follow_indentation_with_force,
    follow_load_with_shift,
)
from pymdr.line.friction.state import FrictionHistory, FrictionState, virgin_state
from pymdr.units import FloatArray

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
