"""From a law of adhesion to its curve of equilibrium states, stable and unstable alike."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.adhesion import DMT as RigidPull
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import MaugisDugdale as Cohesive
from pymdr.line.adhesion import dmt_pull, maugis_dugdale, rigid_pull
from pymdr.line.foundation import ElasticLine
from pymdr.problem.laws import DMT, JKR, AdhesionLaw, MaugisDugdale
from pymdr.problem.profiles import Paraboloid, Profile, Sphere, Sum
from pymdr.units import FloatArray

Equilibria = ShortRange | Cohesive | RigidPull


def equilibria_of(law: AdhesionLaw, profile: Profile, line: ElasticLine) -> Equilibria:
    """
    The curve of a law on a line.

    Parameters
    ----------
    law : AdhesionLaw
    profile : Profile
        For the radius of curvature, which the pull of DMT needs.
    line : ElasticLine
        Fast on the radii that are asked for.

    Returns
    -------
    JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`

    Raises
    ------
    ProblemError
        If the law does not cover the profile.
    """
    if isinstance(law, JKR):
        return ShortRange(line.equivalent, line.modulus, law.work)
    if not line.equivalent.rises:
        raise ProblemError(
            f"{type(law).__name__}: the equivalent profile falls somewhere, and the theory of a cohesive zone needs "
            "one that rises; JKR(work) follows such profiles where their contact is a disk"
        )
    if isinstance(law, MaugisDugdale):
        return maugis_dugdale(line.equivalent, line.modulus, law.work, law.cohesive_stress)
    assert isinstance(law, DMT)
    return RigidPull(line.equivalent, line.modulus, _pull(law, profile, line))


def round_radius(profile: Profile) -> float | None:
    """Radius of curvature in m of a tip that is nothing but round; None for others."""
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return profile.curvature_radius if all(isinstance(p, Sphere | Paraboloid) for p in parts) else None


def _pull(law: DMT, profile: Profile, line: ElasticLine) -> float:
    if law.range is not None:
        return rigid_pull(line.equivalent, law.work, law.work / law.range)
    radius = round_radius(profile)
    if radius is None:
        raise ProblemError(
            "DMT: without a radius of curvature the pull depends on the range of the attraction; give "
            "DMT(work, range='0.3 nm')"
        )
    return float(dmt_pull(radius, law.work))


def equilibrium_branch(
    equilibria: Equilibria, largest_radius: float, deepest: float, machine_stiffness: float | None
) -> dict[str, FloatArray]:
    """
    The whole curve of equilibria for figures.

    Parameters
    ----------
    equilibria : JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`
    largest_radius : float
        Contact radius in m up to which it is given.
    deepest : float
        Indentation in m up to which it is given above a sharp edge.
    machine_stiffness : float or None
        In N/m, for the travel.

    Returns
    -------
    dict of str to ndarray
        Quantities by name, in SI units.
    """
    offset = equilibria.ends[1] if isinstance(equilibria, Cohesive) else 0.0
    s = offset + largest_radius * np.linspace(0.0, 1.0, 801) ** 2
    if offset:
        s = np.concatenate([offset * np.linspace(0.0, 1.0, 201)[:-1], s])
    if math.isfinite(equilibria.line.edge):
        s = np.concatenate([s, s[-1] + max(deepest, 0.0) * np.linspace(0.0, 1.0, 101)[1:]])
    states = equilibria.states(s[s <= equilibria.limit])
    columns = {
        "indentation": states.indentation,
        "normal_force": states.normal_force,
        "contact_radius": states.contact_radius,
        "cohesive_radius": states.cohesive_radius,
    }
    if machine_stiffness is not None:
        columns["travel"] = states.indentation + states.normal_force / machine_stiffness
    return columns
