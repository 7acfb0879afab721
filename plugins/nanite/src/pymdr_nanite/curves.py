"""Forces over depth for any modulus and work of adhesion, from few solutions."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

import pymdr as mdr
from pymdr.solving.fits.forces import RememberedForces, bare_forces, rounded_up
from pymdr.solving.fits.touching import in_contact

_NODES = 513
"""Places of a table of forces."""
_RUNG = 0.1
"""Step of the logarithm of work over modulus between two solutions."""


def elastic_force(contact, young, depth):
    """
    Force of a contact without adhesion; the force is proportional to the modulus.

    Parameters
    ----------
    contact : pymdr.Contact
        With a body of the modulus 1 Pa.
    young : float
        In Pa.
    depth : ndarray
        In m; 0 at first touch.

    Returns
    -------
    ndarray
        In N, 0 at negative depths.
    """
    touching = depth > 0.0
    force = np.zeros(depth.shape)
    if touching.any():
        force[touching] = _unit_forces(contact, rounded_up(float(depth.max())))(depth[touching])
    return young * force


class Pulled(NamedTuple):
    """The branch of a contact with adhesion that is stable at prescribed depth."""

    force: np.ndarray
    """In N; that of the fold at depths before it."""
    fold: float
    """Depth in m at which contact is lost."""


def adhesive_branch(contact, young, work, depth):
    """
    Forces of a contact with adhesion.

    Parameters
    ----------
    contact : pymdr.Contact
        With a body of the modulus 1 Pa, and any work of adhesion.
    young, work : float
        In Pa and J/m^2.
    depth : ndarray
        In m.

    Returns
    -------
    Pulled

    Notes
    -----
    The forces for the modulus s E and the work s w are s times those for E and w, so that one number, w / E, is left. Solutions at
    even steps of its logarithm are interpolated by cubics, at equal roots of the depth from the fold.
    """
    deepest = rounded_up(max(float(depth.max()), 1e-6 * float(np.ptp(depth)) or 1e-12))
    number = math.log(work / young) / _RUNG
    rungs = math.floor(number) - 1 + np.arange(4)
    weights = [math.prod((number - q) / (p - q) for q in rungs if q != p) for p in rungs]
    members = [_rung(contact, int(rung), deepest) for rung in rungs]
    fold = sum(w * member.fold for w, member in zip(weights, members, strict=True))
    r = np.sqrt(np.maximum(depth - fold, 0.0) / (deepest - fold))
    force = sum(
        w * member.over_root(r, deepest - member.fold)[0] for w, member in zip(weights, members, strict=True)
    )
    return Pulled(young * force, fold)


def adhesive_residual(branch, depth, measured):
    """
    Measured less computed force, where between the jumps the record decides which samples are in contact.

    Parameters
    ----------
    branch : Pulled
    depth, measured : ndarray
        In m, and in N without the baseline.

    Returns
    -------
    ndarray
        In N; a misfit without jumps, so that searches do not stop at a sample that changes between contact and no contact.
    """
    touches = in_contact(depth, measured, branch.force, branch.fold)
    return measured - np.where(touches, branch.force, 0.0)


def force_with_memory(contact, interval, depth):
    """
    Force of an approach to a body with memory.

    Parameters
    ----------
    contact : pymdr.Contact
    interval : float
        Time in s between samples.
    depth : ndarray
        In m, in the order of measurement; steps back count as rest.

    Returns
    -------
    ndarray
        In N.
    """
    time = interval * np.arange(depth.size)
    return RememberedForces(contact, time, 0.0).at(np.maximum.accumulate(depth))[0]


@lru_cache(maxsize=32)
def _unit_forces(contact, deepest):
    """Force over depth; that on layers, whose roots are slow, as cubics over the root of the depth: to 1e-11 of that at the largest depth."""
    forces = bare_forces(contact, deepest)
    if not isinstance(contact.body, mdr.Layered):
        return lambda depth: forces.at(depth)[0]
    r = np.linspace(0.0, 1.0, _NODES)
    values, slopes = forces.over_root(r, deepest)
    cubics = CubicHermiteSpline(r, values, slopes)
    return lambda depth: cubics(np.sqrt(depth / deepest))


@lru_cache(maxsize=256)
def _rung(contact, rung, deepest):
    law = replace(contact.adhesion, work=math.exp(_RUNG * rung))
    return bare_forces(replace(contact, adhesion=law), deepest)


@lru_cache(maxsize=64)
def contact_of(profile, body, adhesion=None):
    """One contact for equal values, so that its solutions are kept."""
    return mdr.Contact(profile, body, adhesion=adhesion)
