"""States of an edge that rests between two works of adhesion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.line.adhesion.short_range import JKR, energy_release_rate
from pymdr.line.curves import Disk
from pymdr.units import FloatArray


class Works(NamedTuple):
    """Works of adhesion of an edge [J/m²]."""

    advancing: float
    receding: float


@dataclass(frozen=True)
class EdgeJKR(JKR):
    """States of a contact whose edge rests, advances or recedes: JKR with a work of adhesion of its own in every state.

    Parameters
    ----------
    line : Disk
        The contact without adhesion.
    work : ndarray
        Energy release rate G of every state [J/m²]: between the advancing and the receding work at rest, one of both in motion.
    resting : ndarray of bool
        Whether the edge rests in that state, where dd/dd = 1 and dF/dd = k(a).
    advancing : float
        Work gained where the edge advances [J/m²].

    Notes
    -----
    The edge rests while γ_adv < G < γ_rec, advances at G = γ_adv and recedes at G = γ_rec. The surface energy -π a² γ_adv
    counts what the advance has gained; a receding edge dissipates 2π a (γ_rec - γ_adv) per length.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> s, edge = edge_states(ball, np.ones(2), np.array([0.5, 0.75]), np.zeros(2, dtype=int), Works(0.02, 0.05))
    >>> edge.states(s).indentation.tolist(), edge.slopes(s)[1].tolist()
    ([0.5, 0.75], [2.0, 2.0])
    """

    work: FloatArray  # type: ignore[assignment]
    resting: NDArray[np.bool_]
    advancing: float

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds and dF/ds as `JKR`; at rest 1 and k(a), per indentation."""
        rates = super().slopes(s)
        stiffness = self._contacts(np.asarray(s, dtype=float))[2].stiffness
        return np.where(self.resting, 1.0, rates[0]), np.where(self.resting, stiffness, rates[1])

    def energies(self, s: ArrayLike, indentation: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the elastic energy and the surface energy -π a² γ_adv [J], as `JKR` does."""
        elastic, _ = super().energies(s, indentation)
        return elastic, -np.pi * self.states(s).contact_radius ** 2 * self.advancing


def edge_states(
    line: Disk,
    parameter: FloatArray,
    indentation: FloatArray,
    direction: NDArray[np.intp],
    works: Works,
) -> tuple[FloatArray, EdgeJKR]:
    """Return the states of an edge with their parameters [m].

    Parameters
    ----------
    line : Disk
        The contact without adhesion.
    parameter : ndarray
        Parameter of the edge, as in `JKR`, at most that of a sharp edge [m].
    indentation : ndarray
        Indentation where the edge rests [m].
    direction : ndarray of int
        1 where the edge advances, -1 where it recedes, 0 where it rests.
    works : Works
        Works of adhesion [J/m²].

    Returns
    -------
    ndarray, EdgeJKR
        The parameters, beyond a sharp edge where the edge is pressed, and the curve at them.
    """
    bare = JKR(line, 0.0).states(parameter)
    resting, touching = direction == 0, bare.contact_radius > 0.0
    opening = np.where(resting & touching, bare.indentation - indentation, 0.0)
    released = np.zeros(opening.shape)
    released[touching] = energy_release_rate(line, bare.contact_radius[touching], opening[touching])
    work = np.where(resting, released, np.where(direction > 0, works.advancing, works.receding))
    return parameter + np.maximum(-opening, 0.0), EdgeJKR(line, work, resting, works.advancing)
