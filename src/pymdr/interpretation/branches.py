"""From a law of adhesion to its curve of equilibrium states, stable and unstable alike."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.adhesion import DMT as RigidPull
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import MaugisDugdale as Cohesive
from pymdr.line.adhesion import dmt_pull, maugis_dugdale, rigid_pull
from pymdr.line.foundation import ElasticLine
from pymdr.problem.laws import DMT, JKR, AdhesionLaw, MaugisDugdale
from pymdr.problem.profiles import Profile, Sum
from pymdr.units import FloatArray

Equilibria = ShortRange | Cohesive | RigidPull

_GRID = np.linspace(0.0, 1.0, 601)


def equilibria_of(law: AdhesionLaw, profile: Profile, line: ElasticLine, top: float) -> Equilibria:
    """
    The curve of a law on a line.

    Parameters
    ----------
    law : AdhesionLaw
    profile : Profile
        For the radius of curvature, which the pull of DMT needs.
    line : ElasticLine
    top : float
        Radius in m up to which the curve will be followed.

    Returns
    -------
    JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`

    Raises
    ------
    ProblemError
        If the law does not cover the profile.
    """
    if isinstance(law, JKR):
        return ShortRange(line, law.work)
    if line.equivalent.turning_points(min(top, line.equivalent.edge, line.equivalent.reach)):
        raise ProblemError(
            f"{type(law).__name__}: the equivalent profile falls somewhere, and the theory of a cohesive zone needs "
            "one that rises; JKR(work) follows such profiles where their contact is a disk"
        )
    if isinstance(law, MaugisDugdale):
        return maugis_dugdale(line.equivalent, line.modulus, law.work, law.cohesive_stress)
    assert isinstance(law, DMT)
    return RigidPull(line, rigid_pull_of(law, profile, line))


def _named(profile: Profile) -> str:
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return " + ".join(type(part).__name__ for part in parts)


def rigid_pull_of(law: DMT, profile: Profile, line: ElasticLine) -> float:
    """The pull in N of DMT's attraction, which acts outside the contact whatever the load."""
    if law.range is not None:
        return rigid_pull(line.equivalent, law.work, law.work / law.range)
    if profile.tip_radius is None:
        raise ProblemError(
            f"DMT: {_named(profile)} is not round all over its tip: without a radius of curvature the pull depends on "
            "the range of the attraction; give DMT(work, range='0.3 nm')"
        )
    return float(dmt_pull(profile.tip_radius, law.work))


def equilibrium_curve(
    equilibria: Equilibria, top: float, marks: Sequence[float] = (), machine_stiffness: float | None = None
) -> dict[str, FloatArray]:
    """
    States along the whole curve of a law, stable and unstable, dense where the contact is small.

    Parameters
    ----------
    equilibria : JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`
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
    pieces = [p for p in getattr(equilibria, "ends", ()) if p < top]
    bounds = [equilibria.start, *pieces, top]
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
    equilibria : JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`
    s : ndarray
        Parameters in m.
    machine_stiffness : float, optional
        In N/m, for the travel.

    Returns
    -------
    dict of str to ndarray
        As :func:`equilibrium_curve` gives them, in SI units.
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
