"""Contacts without callables, for files and other processes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.azimuth import azimuthal_mean
from pymdr.mapping.equivalent import equivalent_profile, has_callables, without_callables
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import Function2D, Interpolated, Profile, Sum
from pymdr.units import FloatArray, metres


def portable(contact: Contact, radius: float, depth: float = 0.0) -> Contact:
    """
    A contact whose callable profile is replaced by its interpolant, for files and other processes.

    Parameters
    ----------
    radius : float
        The largest contact radius in m; 0 if unknown.
    depth : float, optional
        The largest indentation in m, which bounds the contact of a Function2D.

    Returns
    -------
    Contact
        The same, if nothing in it is callable.
    """
    if not has_callables(contact.profile):
        return contact
    if isinstance(contact.profile, Function2D):
        return replace(contact, profile=without_callables(contact.profile, _touched(contact.profile, depth)))
    if radius > 0.0:
        return replace(contact, profile=without_callables(contact.profile, 2.0 * radius))
    # without contact the radius that matters is unknown: interpolate as far as the profile can be mapped
    end = min(1.0, contact.profile.max_radius)
    for decades in range(12):
        try:
            profile = without_callables(contact.profile, end * 10.0**-decades)
        except (ProblemError, ConvergenceError):
            continue
        return replace(contact, profile=profile)
    return replace(contact, profile=without_callables(contact.profile, end))


def require_known(profile: Profile, radii: FloatArray, name: str) -> None:
    """
    Refuse a field beyond what was saved of a callable.

    Parameters
    ----------
    radii : ndarray
        In m.
    """
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    end = min((part.max_radius for part in parts if isinstance(part, Interpolated)), default=math.inf)
    farthest = float(np.max(np.abs(radii), initial=0.0))
    if farthest > end * (1.0 + 1e-9):
        raise ProblemError(
            f"{name} at r = {metres(farthest)}: the profile was a callable; a saved or pickled result contains f up to "
            f"r = {metres(end)}; read the field before saving, or solve again with the callable"
        )


def _touched(shape: Function2D, depth: float) -> float:
    """Upper bound in m of the contact radius of a shape, from the disk of its lower bound."""
    line = equivalent_profile(azimuthal_mean(shape))
    radius = float(line.inverse(np.array([depth]))[0]) if depth > 0.0 else 0.0
    return 4.0 * radius if 0.0 < radius < math.inf else min(shape.max_radius, 1.0)
