"""Stable and unstable states along the whole curve of a law of adhesion."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pymdr.line.adhesion import DMT, JKR, MaugisDugdale
from pymdr.units import FloatArray

Equilibria = JKR | MaugisDugdale | DMT

_GRID = np.linspace(0.0, 1.0, 601)


def equilibrium_curve(
    equilibria: Equilibria, top: float, marks: Sequence[float] = (), machine_stiffness: float | None = None
) -> dict[str, FloatArray]:
    """
    Stable and unstable states along the whole curve of a law, denser for small contacts.

    Parameters
    ----------
    top : float
        Largest parameter in m.
    marks : sequence of float
        Parameters in m that are included, such as folds.
    machine_stiffness : float, optional
        In N/m, for the travel.

    Returns
    -------
    dict of str to ndarray
        ``parameter``, ``indentation``, ``normal_force``, ``contact_radius``, ``cohesive_radius`` and with a
        machine ``travel``, in SI units.
    """
    inner_ends = [p for p in getattr(equilibria, "ends", ()) if p < top]
    bounds = [equilibria.start, *inner_ends, top]
    grids = [low + (high - low) * _GRID**2 for low, high in pairwise(bounds)]
    inner = [s for s in (*equilibria.knots, *marks) if equilibria.start <= s <= top]
    s = np.unique(np.concatenate([*grids, np.linspace(equilibria.start, top, _GRID.size), inner]))
    return {"parameter": s, **state_columns(equilibria, s, machine_stiffness)}


def state_columns(
    equilibria: Equilibria, s: FloatArray, machine_stiffness: float | None = None
) -> dict[str, FloatArray]:
    """
    Quantities of the states with given parameters.

    Parameters
    ----------
    s : ndarray
        Parameters in m.

    Returns
    -------
    dict of str to ndarray
        The quantities of :func:`equilibrium_curve`, in SI units.
    """
    states = equilibria.states(s)
    columns = {
        "indentation": states.indentation,
        "normal_force": states.normal_force,
        "contact_radius": states.contact_radius,
        "cohesive_radius": states.cohesive_radius,
    }
    if machine_stiffness is not None:
        columns["travel"] = states.indentation + states.normal_force / machine_stiffness
    return columns
