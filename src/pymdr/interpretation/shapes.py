"""Claims of bodies that are not axisymmetric."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import (
    EXACT_WITHIN,
    NORMAL_FIELDS,
    SOURCES,
    Assumption,
    BoolArray,
    Claim,
    Level,
)
from pymdr.line.ellipses import EllipseBounds
from pymdr.line.shapes import (
    LONGEST_OUTLINE,
    LONGEST_RATIO,
    MANY_SIDES_ERROR,
    PYRAMID_ERROR,
    PYRAMID_FORCES,
    ShapeStates,
)
from pymdr.problem.profiles import EllipticParaboloid, Pyramid, Sampled2D, Shape
from pymdr.units import FloatArray, metres

OF_SHAPES = (
    "indentation",
    "normal_force",
    "normal_stiffness",
    "elastic_energy",
    "semi_axis_x",
    "semi_axis_y",
    "contact_area",
    "mean_pressure",
    "peak_pressure",
    *NORMAL_FIELDS,
)
_MODEL = "for elastic half-spaces in frictionless contact without tilt"
_FORCES = ("indentation", "normal_force", "normal_stiffness", "elastic_energy")
_MEASURED = (
    "error +0.0001, +0.014, +0.32 and +1.5 % on elliptic paraboloids with ratios of radii of 1.2, 2, 4 and 10 (Hertz), and "
    "-3.9, -1.8, -0.6 and -0.25 % on pyramids of 3, 4, 6 and 8 sides (boundary elements)"
)
_ESTIMATE = f"an estimate, not a bound, by the functional of Shield, Barber and Fabrikant: {_MEASURED}"
_MEASURED_ON = "on 120 random bodies (smooth ones, and polygons of 3 to 24 faces), for contacts without holes whose outlines deviate from ellipses no more than theirs"
_UNKNOWN = (
    "no estimate: the outline extends beyond the known part of the body, or is more than "
    f"{LONGEST_OUTLINE:g} times as long as wide, where the error was not measured, or another part of the body may touch, or the "
    "estimate is below the lower bound; use boundary elements: press(...)"
)
_CUT_OFF = 0.02
_SMALL_SLOPE = 0.3


@dataclass(frozen=True)
class LowerBound:
    """Lower bound of the force over the rows."""

    force: FloatArray
    """F / E* in m^2."""
    error: FloatArray
    """Relative error of the means of the gap."""
    disk: FloatArray
    """Bound by disks about the apex."""
    ellipses: EllipseBounds | None
    """Better bounds by ellipses."""


def shape_claims(
    shape: Shape, states: ShapeStates, bound: LowerBound, prescribed: Mapping[str, BoolArray]
) -> dict[str, Claim]:
    """Claims of every quantity of a shape over the rows."""
    everywhere = np.ones(bound.force.shape, dtype=bool)
    theory = shape_theory(shape)
    claims = theory.claims(shape, states)
    claims |= _refused(claims, everywhere)
    none = np.zeros(everywhere.shape, dtype=bool)
    claims["contact_radius"] = Claim(Level.NOT_VALID, theory.no_radius, SOURCES["johnson"], none)
    claims["force_estimate"] = _estimate_claim(theory, states)
    claims["force_lower_bound"] = _bound_claim(theory, states, bound)
    for name, known in prescribed.items():
        claim = claims[name]
        if known.all():
            claims[name] = Claim(Level.EXACT, "prescribed", claim.source, everywhere)
        elif known.any():
            error = None if claim.error is None else np.where(known, 0.0, claim.error)
            claims[name] = replace(claim, where=claim.where | known, error=error)
    return claims


def _exact(shape: Shape, states: ShapeStates) -> dict[str, Claim]:
    everywhere = np.ones(states.force.shape, dtype=bool)
    reason = f"exact {_MODEL}, on an ellipse that is small compared with the radii of curvature"
    return {name: Claim(Level.EXACT, reason, SOURCES["hertz"], everywhere) for name in OF_SHAPES}


def _pyramid(shape: Pyramid, states: ShapeStates) -> dict[str, Claim]:
    everywhere, sides = np.ones(states.force.shape, dtype=bool), shape.sides
    reason = f"F = C E* d^2 / slope by self-similarity {_MODEL}; "
    if sides in PYRAMID_FORCES:
        reason += f"C = {PYRAMID_FORCES[sides]:g} by boundary elements, error {PYRAMID_ERROR:g}"
        size = PYRAMID_ERROR
    else:
        reason += f"C is {_ESTIMATE}; the error with {sides} sides is less than with 8"
        size = MANY_SIDES_ERROR
    if shape.gradient > _SMALL_SLOPE:
        reason += (
            f"; slope of the faces = {shape.gradient:.3g} (limit {_SMALL_SLOPE:g} of the model of small slopes; the error for steeper "
            "bodies is not included)"
        )
    source = f"{SOURCES['bilodeau']}; {SOURCES['popov-shapes']}"
    base = {name: Claim(Level.APPROXIMATE, reason, source, everywhere) for name in _FORCES}
    errors = {
        name: np.full(everywhere.shape, 0.5 * size if name == "indentation" else size) for name in _FORCES
    }
    return with_errors(base, errors)


def _estimate_error(
    theory: ShapeTheory, states: ShapeStates, known: BoolArray
) -> tuple[FloatArray | None, str]:
    """The errors of the estimate in the rows that have one, None if unknown; and their description."""
    error = np.where(known, states.error, 0.0)
    if theory.interpolated:
        return None, "; its error is unknown: it was not measured for interpolated heights"
    if np.isnan(error).any():
        return None, f"; its error is unknown here: it was measured {_MEASURED_ON}"
    return error, theory.measured


def _level(error: FloatArray | None) -> Level:
    """Level of the estimate, which is exact for axisymmetric bodies."""
    precise = error is not None and float(np.max(error, initial=0.0)) <= EXACT_WITHIN
    return Level.EXACT if precise else Level.APPROXIMATE


def _estimated(shape: Shape, states: ShapeStates) -> dict[str, Claim]:
    known = np.isfinite(states.force)
    error, measured = _estimate_error(shape_theory(shape), states, known)
    reason = f"{_ESTIMATE}; {_MODEL}{measured}" if known.any() else _UNKNOWN
    level = _level(error) if known.any() else Level.NOT_VALID
    claims = {name: Claim(level, reason, SOURCES["popov-shapes"], known, error) for name in _FORCES[:3]}
    if known.any() and not known.all():
        claims = {
            name: replace(
                claim,
                reason=f"{reason}; not valid at {int((~known).sum())} of {known.size} steps: {_UNKNOWN}",
            )
            for name, claim in claims.items()
        }
    stiff = claims["normal_stiffness"]
    if error is not None:
        # the error of the force may grow with the depth as fast as the force
        stiff = replace(stiff, error=2.0 * error + np.where(known & (states.clipped > 0.0), _CUT_OFF, 0.0))
    if np.any(states.clipped[known] > 0.0):
        high = f"; where the outline is cut off, the stiffness is up to {100.0 * _CUT_OFF:g} % too high"
        stiff = replace(stiff, reason=f"{stiff.reason}{high}")
    return {**claims, "normal_stiffness": stiff}


def _refused(given: Mapping[str, Claim], everywhere: BoolArray) -> dict[str, Claim]:
    none = np.zeros(everywhere.shape, dtype=bool)
    reasons = dict.fromkeys(
        OF_SHAPES,
        "the outline of the contact and its pressures are unknown; use boundary elements: press(...)",
    )
    reasons["elastic_energy"] = (
        "the estimate gives only force and stiffness; integrate normal_force over indentation"
    )
    reasons["semi_axis_x"] = reasons["semi_axis_y"] = "the contact is not an ellipse"
    source = SOURCES["popov-shapes"]
    return {
        name: Claim(Level.NOT_VALID, why, source, none) for name, why in reasons.items() if name not in given
    }


def _estimate_claim(theory: ShapeTheory, states: ShapeStates) -> Claim:
    known = np.isfinite(states.estimate)
    source = SOURCES["popov-shapes"]
    if not known.any():
        return Claim(Level.NOT_VALID, theory.no_estimate, source, known)
    cut = np.any(states.clipped[known] > 0.0)
    outline = "; the outline is cut off in some directions" if cut else ""
    error, measured = _estimate_error(theory, states, known)
    return Claim(_level(error), f"{_ESTIMATE}{outline}{measured}", source, known, error)


def _bound_claim(theory: ShapeTheory, states: ShapeStates, bound: LowerBound) -> Claim:
    everywhere = np.ones(bound.force.shape, dtype=bool)
    reason = "a rigorous lower bound of the force at this indentation, without tilt, from "
    if bound.ellipses is None:
        reason += "the azimuthal mean about the apex"
    else:
        reason += f"the best trial ellipse {_where(bound)}"
    pressed = np.isfinite(states.force) & (states.force > 0.0)
    if pressed.any():
        fraction = float(np.max(1.0 - bound.force[pressed] / states.force[pressed]))
        reason += f"; here up to {100.0 * max(fraction, 0.0):.2g} % below normal_force"
    level = Level.EXACT
    if theory.interpolated:
        level, reason = Level.APPROXIMATE, f"{reason}; for the interpolated heights"
        if bound.ellipses is None:
            reason += " and their mean between rings at a distance of one pixel"
    claim = Claim(level, reason, SOURCES["shield"], everywhere)
    return with_errors(
        {"bound": claim}, {"bound": bound.error}, "", "from the mean over finitely many points"
    )["bound"]


def _where(bound: LowerBound) -> str:
    """Description of the best ellipse in the row with the largest force."""
    best = bound.ellipses
    assert best is not None
    row = int(np.nanargmax(best.force))
    x, y, longer, shorter = (metres(float(one[row])) for one in (best.x, best.y, best.longer, best.shorter))
    gain = 100.0 * (bound.force[row] / bound.disk[row] - 1.0) if bound.disk[row] > 0.0 else math.inf
    return (
        f"(at the largest indentation: centre x = {x}, y = {y}, semi-axes {longer} and {shorter}, the longer one at "
        f"{math.degrees(float(best.angle[row])) % 180.0:.3g} degrees; {gain:.2g} % above the bound by the azimuthal mean)"
    )


@dataclass(frozen=True)
class ShapeTheory:
    """Claims and reasons of one kind of shape."""

    claims: Callable[[Any, ShapeStates], dict[str, Claim]] = _estimated
    """Claims of its quantities."""
    references: tuple[str, ...] = ("shield", "barber", "popov-shapes")
    no_radius: str = "the contact is not a disk and has no radius"
    no_estimate: str = _UNKNOWN
    """Why there is no estimate."""
    measured: str = f"; its error is measured by boundary elements {_MEASURED_ON}"
    """Source of the error of the estimate."""
    interpolated: bool = False
    """Whether it is known only at samples."""


SHAPES: dict[type[Shape], ShapeTheory] = {
    EllipticParaboloid: ShapeTheory(
        _exact,
        references=("hertz", "shield", "barber", "popov-shapes"),
        no_radius="the contact is an ellipse and has no radius; read semi_axis_x and semi_axis_y",
        no_estimate=f"its error was measured up to a ratio of radii of {LONGEST_RATIO:g}; normal_force is exact",
        measured="",
    ),
    Pyramid: ShapeTheory(_pyramid, references=("shield", "barber", "popov-shapes", "bilodeau"), measured=""),
    Sampled2D: ShapeTheory(interpolated=True),
}
"""One row for each kind; other kinds are estimated."""


def shape_theory(shape: Shape) -> ShapeTheory:
    """The row of a shape."""
    return next((SHAPES[kind] for kind in type(shape).__mro__ if kind in SHAPES), ShapeTheory())


def shape_assumptions(steepest: float, largest: float, dundurs_beta: float) -> tuple[Assumption, ...]:
    """
    Assumptions of the half-space model for a shape, measured over the history.

    Parameters
    ----------
    steepest : float
        Largest slope in the contact.
    largest : float
        Largest semi-axis over its radius of curvature; nan unless the shape is an elliptic paraboloid.
    """
    slope = Assumption("small slope", "largest slope of the body in the contact", steepest, _SMALL_SLOPE)
    ratio = Assumption("half-space", "semi-axis over radius of curvature a/R", largest, 0.3)
    similar = Assumption(
        "elastic similarity", "Dundurs' beta; affects the pressure only with friction", abs(dundurs_beta), 0.5
    )
    return (slope, similar) if math.isnan(largest) else (slope, ratio, similar)
