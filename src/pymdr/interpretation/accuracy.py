"""Numerical errors of a solution, from the measured errors of the map to those of the claims."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.validity import EXACT_WITHIN, Claim, Level, with_known
from pymdr.line.curves import Line
from pymdr.line.foundation import DiskStates, states_at_depth
from pymdr.units import FloatArray

_STRAIGHT, _STEEP = 0.01, 0.1
"""Errors of a curve and of its slope up to which its inverse is linearised."""
G, SLOPE, MOMENT, SQUARED = range(4)
"""Columns of the errors of a line: g, g', m and s."""


def normal_errors(line: Line, states: DiskStates, by_force: NDArray[np.bool_]) -> dict[str, FloatArray]:
    """
    Relative errors of a contact without adhesion, from those of g, g', m and s at its edge.

    Parameters
    ----------
    by_force : ndarray of bool
        Rows whose force is prescribed instead of their indentation.

    Returns
    -------
    dict of str to ndarray
        For every quantity and field, over the rows; relative to the size of its terms.

    Notes
    -----
    With a prescribed depth d = g(a) the error of the radius is da = e_g g / g' or, for large e_g or an uncertain g', the
    distance over which g may equal d; that of the force F0(a) is e_m F0 + k g' da.
    """
    place = states.place
    a = states.contact_radius
    error = line.error(place)
    if not error.any():
        return {}
    at_fixed_edge = (a >= line.equivalent.edge) | ~(a > 0.0)
    equivalent = line.equivalent
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        g, slope = np.abs(line.depth(place)), np.abs(line.depth_rate(place))
        smooth, stored, stiffness = (
            np.abs(line.force(place)),
            np.abs(line.energy(place)),
            line.stiffness(place),
        )
        edge_error = np.where(at_fixed_edge, 0.0, np.where(by_force, error[:, MOMENT], error[:, G]))
        depth_error = edge_error * np.where(by_force, smooth / stiffness, g)
        radius_error = depth_error / slope
        uncertain = np.flatnonzero(
            (edge_error > _STRAIGHT) | ((error[:, SLOPE] > _STEEP) & (edge_error > 0.0))
        )
        if uncertain.size:
            radius_error[uncertain] = np.fmax(
                radius_error[uncertain], equivalent.place_error(place.take(uncertain), by_force[uncertain])
            )
            # an uncertain g' leaves the error of the depth as it is
            wide = edge_error > _STRAIGHT
            depth_error = np.where(wide, np.fmax(depth_error, slope * radius_error), depth_error)
        radius = radius_error / a
        force = np.where(by_force, 0.0, error[:, MOMENT] + stiffness * depth_error / smooth)
        depth = np.where(by_force, error[:, G] + depth_error / g, 0.0)
        energy = error[:, SQUARED] + smooth * depth_error / stored
    errors = {
        "contact_radius": radius,
        "normal_force": force,
        "force_lower_bound": force,
        "indentation": depth,
        "elastic_energy": energy,
        "normal_stiffness": (1.0 + line.exponent) * radius,
        "mean_pressure": force + 2.0 * radius,
        "edge_amplitude": force + radius,
        "travel": depth + force,
        "pressure": line.equivalent.slope_error(place) + error[:, SLOPE] + radius,
        "normal_displacement": depth + error[:, G],
        "gap": error[:, SLOPE] + depth,
        "equivalent_profile": error[:, G],
        "spring_force": error[:, G] + depth,
    }
    return bounded(errors, a > 0.0)


def bounded(errors: Mapping[str, FloatArray], touching: NDArray[np.bool_]) -> dict[str, FloatArray]:
    """Errors in contact, limited to 1, which also stands for unknown; 0 without contact."""
    return {
        name: np.where(touching, np.minimum(np.nan_to_num(values, nan=0.0, posinf=1.0), 1.0), 0.0)
        for name, values in errors.items()
    }


def frictional_errors(
    line: Line,
    friction: float,
    ratio: float,
    columns: Mapping[str, FloatArray],
    forced: NDArray[np.bool_],
    dragged: NDArray[np.bool_],
) -> dict[str, FloatArray]:
    """
    Relative errors of a contact with friction, from those of the map of its profile.

    Parameters
    ----------
    friction, ratio : float
        mu, and E*/G*.
    columns : mapping of str to ndarray
        Quantities over the rows.
    forced, dragged : ndarray of bool
        Rows whose normal or tangential force is prescribed instead of the indentation or the shift.

    Returns
    -------
    dict of str to ndarray
        For quantities relative to their value, for fields relative to the largest value of the field.

    Notes
    -----
    F_x is a sum of terms mu (F(d) - F(d*)) and u of terms mu E*/G* (d - d*), in which the errors of F and d at the deepest
    contact so far count at most twice. Without slip the errors are proportional to those of the radii.
    """
    states = states_at_depth(line, columns["indentation"])
    errors = normal_errors(line, states, forced)
    if not errors:
        return {}
    whole = normal_errors(line, states, np.zeros_like(forced))
    force, depth, radius = (
        np.maximum.accumulate(whole[name])
        for name in ("normal_force", "equivalent_profile", "contact_radius")
    )
    deepest = np.maximum.accumulate(np.abs(columns["indentation"]))
    pulled = np.abs(columns["tangential_force"])
    drawn = np.maximum.accumulate(np.abs(columns["shift"]))
    largest = np.maximum.accumulate(pulled)
    if friction < math.inf:
        missed = 2.0 * friction * force * np.maximum.accumulate(np.abs(columns["normal_force"]))
        strayed = 2.0 * friction * ratio * depth * deepest
        stick = columns["stick_radius"]
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = 2.0 * depth * deepest / (stick * line.depth_rate(stick))
        radius = radius + np.where(stick > 0.0, np.nan_to_num(moved, nan=0.0, posinf=1.0), 0.0)
    else:
        missed, strayed = 2.0 * radius * largest, 2.0 * radius * drawn
    energy = missed * drawn + strayed * largest
    path_length = np.cumsum(np.abs(np.diff(columns["shift"], prepend=0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        own = {
            "tangential_force": np.where(dragged, 0.0, missed / pulled),
            "shift": np.where(dragged, (strayed + missed * drawn / largest) / np.abs(columns["shift"]), 0.0),
            "slip_distance": strayed / np.abs(columns["slip_distance"]),
            "stored_tangential_energy": energy / np.abs(columns["stored_tangential_energy"]),
            "dissipated_energy": (energy + missed * path_length) / np.abs(columns["dissipated_energy"]),
        }
    tangential = own | {
        "stick_radius": radius,
        "tangential_stiffness": radius,
        "shear_traction": whole["pressure"],
        "tangential_displacement": radius + 2.0 * depth,
        "slip": radius + 2.0 * depth,
    }
    # a value of 0 has no relative error
    return errors | {
        name: np.fmin(np.nan_to_num(e, nan=0.0, posinf=0.0), 1.0) for name, e in tangential.items()
    }


def of_own_size(errors: FloatArray, values: FloatArray) -> FloatArray:
    """
    Relative errors of rows from those of the largest value of a path.

    Parameters
    ----------
    errors : ndarray
        Of the largest value.
    values : ndarray
        Of every row.

    Returns
    -------
    ndarray
        At most 1, which also stands for unknown; 0 for a value of 0.

    Examples
    --------
    >>> of_own_size(np.array([1e-4, 1e-4, 1e-4, 0.0]), np.array([-2.0, 0.1, 1e-9, 0.0])).round(6).tolist()
    [0.0001, 0.002, 1.0, 0.0]
    """
    size = np.abs(np.nan_to_num(values))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        own = errors * (np.max(size, initial=0.0) / size)
    return np.asarray(np.where((errors > 0.0) & (size > 0.0), np.fmin(own, 1.0), 0.0))


def with_errors(
    claims: Mapping[str, Claim],
    errors: Mapping[str, FloatArray],
    remark: str = "",
    cause: str = "from the map of the profile",
) -> dict[str, Claim]:
    """
    Claims with the errors of the numerics added; no claim with a relative error above 1e-9 is exact.

    Parameters
    ----------
    claims : mapping of str to Claim
        Claims of the model. Where its error is unknown, that of the numerics is the total known error.
    errors : mapping of str to ndarray
        Relative errors over the rows; a missing name has no error.
    remark : str
        Further condition of the numbers, added to the reasons.
    cause : str
        Cause of the errors.
    """
    return {name: _with_error(claim, errors.get(name), remark, cause) for name, claim in claims.items()}


def _with_error(claim: Claim, error: FloatArray | None, remark: str, cause: str) -> Claim:
    if claim.level is Level.NOT_VALID:
        return claim
    reason = f"{claim.reason}{remark}"
    if error is None:
        return replace(claim, reason=reason)
    largest = float(np.max(error, initial=0.0, where=claim.where))
    total = with_known(claim, error)
    if largest <= EXACT_WITHIN or claim.level is not Level.EXACT:
        return replace(claim, error=total, reason=reason)
    reason = f"{claim.reason}; relative numerical error above {EXACT_WITHIN:g}, {cause}{remark}"
    return replace(claim, level=Level.APPROXIMATE, error=total, reason=reason)
