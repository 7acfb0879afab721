"""How far the numbers of a solution are from those of its model: from the measured errors of the map to claims."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.branches import Equilibria as Adhesive
from pymdr.interpretation.validity import Claim, Level
from pymdr.line.curves import Line
from pymdr.line.foundation import DiskStates
from pymdr.units import FloatArray

EXACT_WITHIN = 1e-9
"""Largest relative error of a number that is called exact."""
_STRAIGHT = 0.01
"""Error of a curve up to which it is taken as straight where it is inverted."""
_G, _SLOPE, _MOMENT, _SQUARED = range(4)


def normal_errors(line: Line, states: DiskStates, by_force: NDArray[np.bool_]) -> dict[str, FloatArray]:
    """
    Relative errors of the quantities of a contact without adhesion, from those of g, g', m and s at its edge.

    Parameters
    ----------
    line : Line
    states : DiskStates
    by_force : ndarray of bool
        Rows whose force is prescribed, and not their indentation.

    Returns
    -------
    dict of str to ndarray
        For every quantity and field, over the rows; relative to the size of its parts.

    Notes
    -----
    With a prescribed depth d = g(a) the radius errs by da = e_g g / g' or, where e_g is no small number, as far as g may
    be d; and the force F0(a) by e_m F0 + k g' da.
    """
    place = states.place
    a = states.contact_radius
    error = line.error(place)
    if not error.any():
        return {}
    held = (a >= line.equivalent.edge) | ~(a > 0.0)
    equivalent = line.equivalent
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        g, slope = np.abs(line.depth(place)), np.abs(line.depth_rate(place))
        smooth, stored, stiffness = (
            np.abs(line.force(place)),
            np.abs(line.energy(place)),
            line.stiffness(place),
        )
        unsure = np.where(held, 0.0, np.where(by_force, error[:, _MOMENT], error[:, _G]))
        shift = unsure * np.where(by_force, smooth / stiffness, g)
        away = shift / slope
        rough = np.flatnonzero(unsure > _STRAIGHT)
        if rough.size:
            away[rough] = np.fmax(away[rough], equivalent.place_error(place.take(rough), by_force[rough]))
            shift[rough] = np.fmax(shift[rough], slope[rough] * away[rough])
        radius = away / a
        force = np.where(by_force, 0.0, error[:, _MOMENT] + stiffness * shift / smooth)
        depth = np.where(by_force, error[:, _G] + shift / g, 0.0)
        energy = error[:, _SQUARED] + smooth * shift / stored
    found = {
        "contact_radius": radius,
        "normal_force": force,
        "force_lower_bound": force,
        "indentation": depth,
        "elastic_energy": energy,
        "normal_stiffness": (1.0 + line.exponent) * radius,
        "mean_pressure": force + 2.0 * radius,
        "edge_amplitude": force + radius,
        "travel": depth + force,
        "pressure": line.equivalent.slope_error(place) + error[:, _SLOPE] + radius,
        "normal_displacement": depth + error[:, _G],
        "gap": error[:, _SLOPE] + depth,
        "equivalent_profile": error[:, _G],
        "spring_force": error[:, _G] + depth,
    }
    return _bounded(found, a > 0.0)


def adhesive_errors(
    line: Line, equilibria: Adhesive, s: FloatArray, machine_stiffness: FloatArray
) -> dict[str, FloatArray]:
    """
    Relative errors of the quantities of a contact with adhesion, from those of g, g', m and s at its edges.

    Parameters
    ----------
    line : Line
    equilibria : JKR, MaugisDugdale or DMT of :mod:`pymdr.line.adhesion`
    s : ndarray
        Parameters of the states in m.
    machine_stiffness : ndarray
        Stiffness k in N/m of the machine that stands for the control: inf for an indentation, 0 for a force.

    Returns
    -------
    dict of str to ndarray
        For every quantity and field, over the rows; relative to the size of its parts: |F0| + |k w| for the force,
        |d0| + |w| for the depth.

    Notes
    -----
    At a given radius d errs by e_g g and F by e_m F0, both by e_g' of the part that cohesion of finite range adds,
    whose zone ends where g' says. With a prescribed D = d + F/k the parameter then errs by dD / (dD/ds).
    """
    states = equilibria.states(s)
    a = states.contact_radius
    error = line.error(a)
    outer = np.maximum(error[:, _SLOPE], line.error(states.cohesive_radius)[:, _SLOPE])
    if not error.any() and not outer.any():
        return {}
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        g, smooth = np.abs(line.depth(a)), np.abs(line.force(a))
        opened, pull = np.abs(line.depth(a) - states.indentation), np.abs(smooth - states.normal_force)
        ranged = outer if equilibria.ranged else 0.0
        depth = error[:, _G] * g + ranged * opened
        force = error[:, _MOMENT] * smooth + ranged * pull
        by_force = machine_stiffness == 0.0
        depth_rate, force_rate = (np.abs(x) for x in equilibria.slopes(s))
        soft = np.where(by_force, 1.0, machine_stiffness)
        rates = equilibria.slopes(s)
        control = np.where(by_force, force, depth + force / soft)
        steep = np.abs(np.where(by_force, rates[1], rates[0] + rates[1] / soft))
        moved = control / steep
        depth = np.where(np.isinf(machine_stiffness), 0.0, depth + depth_rate * moved)
        force = np.where(by_force, 0.0, force + force_rate * moved)
        radius = moved / a
        depth, force = depth / (g + opened), force / (smooth + pull)
        slope = error[:, _SLOPE] + radius
        energy = error[:, _SQUARED] + error[:, _MOMENT] + 3.0 * radius
    found = {
        "contact_radius": radius,
        "cohesive_radius": radius + outer,
        "normal_force": force,
        "indentation": depth,
        "travel": depth + force,
        "elastic_energy": energy,
        "surface_energy": 2.0 * radius,
        "external_work": energy,
        "jump_dissipation": energy,
        "dissipated_energy": energy,
        "normal_stiffness": slope,
        "mean_pressure": force + 2.0 * radius,
        "edge_amplitude": radius,
        "pressure": slope,
        "normal_displacement": depth + error[:, _G],
        "gap": slope + depth,
        "equivalent_profile": error[:, _G],
        "spring_force": error[:, _G] + depth,
    }
    return _bounded(found, (a > 0.0) | (states.cohesive_radius > 0.0))


def _bounded(errors: Mapping[str, FloatArray], touching: NDArray[np.bool_]) -> dict[str, FloatArray]:
    """Errors where there is contact; 1 where nothing is known of a number."""
    return {
        name: np.where(touching, np.minimum(np.nan_to_num(values, nan=0.0, posinf=1.0), 1.0), 0.0)
        for name, values in errors.items()
    }


def with_errors(
    claims: Mapping[str, Claim],
    errors: Mapping[str, FloatArray],
    remark: str = "",
    cause: str = "as the map of the profile does",
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
    cause : str
        Why numbers err, in words.

    Returns
    -------
    dict of str to Claim
    """
    return {name: _with_error(claim, errors.get(name), remark, cause) for name, claim in claims.items()}


def _with_error(claim: Claim, error: FloatArray | None, remark: str, cause: str) -> Claim:
    if claim.level is Level.NOT_VALID:
        return claim
    if error is None:
        return replace(claim, reason=f"{claim.reason}{remark}") if remark else claim
    largest = float(np.max(error[claim.where], initial=0.0))
    reason = f"{claim.reason}{remark}"
    if largest <= EXACT_WITHIN or claim.level is not Level.EXACT:
        return replace(claim, error=error, reason=reason)
    reason = f"{claim.reason}; numbers err by more than {EXACT_WITHIN:g} of their size, {cause}{remark}"
    return replace(claim, level=Level.APPROXIMATE, error=error, reason=reason)
