"""How far the numbers of a solution are from those of its model: from the measured errors of the map to claims."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.interpretation.validity import Claim, Level
from pymdr.line.foundation import DiskStates, ElasticLine
from pymdr.units import FloatArray

EXACT_WITHIN = 1e-9
"""Largest relative error of a number that is called exact."""
_G, _SLOPE, _MOMENT, _SQUARED = range(4)


def normal_errors(line: ElasticLine, states: DiskStates, by_force: np.ndarray) -> dict[str, FloatArray]:
    """
    Relative errors of the quantities of a contact without adhesion, from those of g, g', m and s at its edge.

    Parameters
    ----------
    line : ElasticLine
    states : DiskStates
    by_force : ndarray of bool
        Rows whose force is prescribed, and not their indentation.

    Returns
    -------
    dict of str to ndarray
        For every quantity and field, over the rows; relative to the size of its parts.

    Notes
    -----
    With a prescribed depth d = g(a) the radius errs by da = e_g g / g', and the force 2 E* m(a) by e_m m + a g' da.
    """
    place = states.place
    a = states.contact_radius
    error = line.equivalent.error(place)
    if not error.any():
        return {}
    held = (a >= line.equivalent.edge) | ~(a > 0.0)
    equivalent = line.equivalent
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        g, slope = np.abs(equivalent.g(place)), np.abs(equivalent.slope(place))
        m, s = np.abs(equivalent.moment(place)), np.abs(equivalent.squared(place))
        shift = np.where(by_force, error[:, _MOMENT] * m / a, error[:, _G] * g)
        shift = np.where(held, 0.0, shift)
        radius = shift / (slope * a)
        force = np.where(by_force, 0.0, error[:, _MOMENT] + a * shift / m)
        depth = np.where(by_force, error[:, _G] + shift / g, 0.0)
        energy = error[:, _SQUARED] + 2.0 * m * shift / s
    found = {
        "contact_radius": radius,
        "normal_force": force,
        "force_lower_bound": force,
        "indentation": depth,
        "elastic_energy": energy,
        "normal_stiffness": radius,
        "mean_pressure": force + 2.0 * radius,
        "edge_amplitude": force + radius,
        "travel": depth + force,
        "pressure": line.equivalent.slope_error(place) + error[:, _SLOPE] + radius,
        "normal_displacement": depth + error[:, _G],
        "gap": error[:, _SLOPE] + depth,
        "equivalent_profile": error[:, _G],
        "spring_force": error[:, _G] + depth,
    }
    return {
        name: np.where(a > 0.0, np.nan_to_num(values, nan=0.0, posinf=1.0), 0.0)
        for name, values in found.items()
    }


def with_errors(
    claims: Mapping[str, Claim], errors: Mapping[str, FloatArray], remark: str = ""
) -> dict[str, Claim]:
    """
    Claims that carry the errors of their numbers: above 1e-9 nothing is exact.

    Parameters
    ----------
    claims : mapping of str to Claim
    errors : mapping of str to ndarray
        Relative errors over the rows.
    remark : str
        What else the numbers rest on, for the reasons.

    Returns
    -------
    dict of str to Claim
    """
    return {name: _with_error(claim, errors.get(name), remark) for name, claim in claims.items()}


def _with_error(claim: Claim, error: FloatArray | None, remark: str) -> Claim:
    if claim.level is Level.NOT_VALID:
        return claim
    if error is None:
        return replace(claim, reason=f"{claim.reason}{remark}") if remark else claim
    largest = float(np.max(error[claim.where], initial=0.0))
    reason = f"{claim.reason}{remark}"
    if largest <= EXACT_WITHIN or claim.level is not Level.EXACT:
        return replace(claim, error=error, reason=reason)
    reason = f"{claim.reason}; numbers err by more than {EXACT_WITHIN:g} of their size, as the map of the profile does{remark}"
    return replace(claim, level=Level.APPROXIMATE, error=error, reason=reason)
