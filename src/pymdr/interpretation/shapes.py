"""What can be claimed of bodies that are not of revolution."""

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
_MODEL = "for elastic half-spaces in frictionless contact, pressed by a body that does not tilt"
_FORCES = ("indentation", "normal_force", "normal_stiffness", "elastic_energy")
_MEASURED = (
    "off by +0.0001, +0.014, +0.32 and +1.5 % on elliptic paraboloids whose radii have the ratios 1.2, 2, 4 and 10 (Hertz), and by "
    "-3.9, -1.8, -0.6 and -0.25 % on pyramids of 3, 4, 6 and 8 sides (boundary elements)"
)
_ESTIMATE = f"an estimate and no bound, by the functional of Shield, Barber and Fabrikant: {_MEASURED}"
_MEASURED_ON = (
    "on 120 random bodies, smooth ones and polygons of 3 to 24 faces, for contacts without holes whose outline differs from an ellipse "
    "by no more than theirs"
)
_UNKNOWN = (
    "no estimate: in some direction the outline runs beyond what is known of the body, or it is more than "
    f"{LONGEST_OUTLINE:g} times as long as wide, where the error was not measured, or another part of the body may touch, or it is "
    "below the lower bound; press it by boundary elements"
)
_CUT_OFF = 0.02
_SMALL_SLOPE = 0.3


@dataclass(frozen=True)
class LowerBound:
    """The lower bound of the force over the rows."""

    force: FloatArray
    """F / E* in m^2."""
    error: FloatArray
    """Relative, of the means of the gap."""
    disk: FloatArray
    """That of disks about the apex."""
    ellipses: EllipseBounds | None
    """Those that are better."""


def shape_claims(
    shape: Shape, states: ShapeStates, bound: LowerBound, prescribed: Mapping[str, BoolArray]
) -> dict[str, Claim]:
    """
    Claims of every quantity of a shape over the rows.

    Parameters
    ----------
    shape : Shape
    states : ShapeStates
    bound : LowerBound
    prescribed : mapping of str to ndarray of bool
        Rows at which a quantity is prescribed.

    Returns
    -------
    dict of str to Claim
    """
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
    reason = f"exact {_MODEL}, on an ellipse that is small against the radii of curvature"
    return {name: Claim(Level.EXACT, reason, SOURCES["hertz"], everywhere) for name in OF_SHAPES}


def _pyramid(shape: Pyramid, states: ShapeStates) -> dict[str, Claim]:
    everywhere, sides = np.ones(states.force.shape, dtype=bool), shape.sides
    reason = f"F = C E* d^2 / slope by self-similarity {_MODEL}; "
    if sides in PYRAMID_FORCES:
        reason += f"C = {PYRAMID_FORCES[sides]:g} by boundary elements, error {PYRAMID_ERROR:g}"
        size = PYRAMID_ERROR
    else:
        reason += f"C is {_ESTIMATE}; with {sides} sides it errs by less than with 8"
        size = MANY_SIDES_ERROR
    if shape.gradient > _SMALL_SLOPE:
        reason += (
            f"; the faces have a slope of {shape.gradient:.3g}, above {_SMALL_SLOPE:g}, up to which the model of small slopes is "
            "taken as valid: what such a steep body does to a real material is not in the number"
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
    """The errors of the estimate in the rows in which there is one, None where they are not known; and what is said of them."""
    error = np.where(known, states.error, 0.0)
    if theory.interpolated:
        return None, "; its error is not known: of heights between the samples it was not measured"
    if np.isnan(error).any():
        return None, f"; its error is not known here: it was measured {_MEASURED_ON}"
    return error, theory.measured


def _level(error: FloatArray | None) -> Level:
    """Of the estimate: that of a body of revolution is its force."""
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
                claim, reason=f"{reason}; at {int((~known).sum())} of {known.size} steps none: {_UNKNOWN}"
            )
            for name, claim in claims.items()
        }
    stiff = claims["normal_stiffness"]
    if error is not None:
        # that of the force may grow with the depth as fast as the force does
        stiff = replace(stiff, error=2.0 * error + np.where(known & (states.clipped > 0.0), _CUT_OFF, 0.0))
    if np.any(states.clipped[known] > 0.0):
        high = f"; where the outline is cut off, the stiffness is up to {100.0 * _CUT_OFF:g} % high"
        stiff = replace(stiff, reason=f"{stiff.reason}{high}")
    return {**claims, "normal_stiffness": stiff}


def _refused(given: Mapping[str, Claim], everywhere: BoolArray) -> dict[str, Claim]:
    none = np.zeros(everywhere.shape, dtype=bool)
    reasons = dict.fromkeys(
        OF_SHAPES,
        "the outline of the contact and the pressures in it are not known; press the body by boundary elements",
    )
    reasons["elastic_energy"] = (
        "the estimate has a force and a stiffness; integrate normal_force over indentation"
    )
    reasons["semi_axis_x"] = reasons["semi_axis_y"] = "the contact is no ellipse"
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
    outline = "; in some directions it has no outline of its own, and none is offered" if cut else ""
    error, measured = _estimate_error(theory, states, known)
    return Claim(_level(error), f"{_ESTIMATE}{outline}{measured}", source, known, error)


def _bound_claim(theory: ShapeTheory, states: ShapeStates, bound: LowerBound) -> Claim:
    everywhere = np.ones(bound.force.shape, dtype=bool)
    reason = "a rigorous lower bound of the force at this indentation, for a body that does not tilt: "
    if bound.ellipses is None:
        reason += "that of the azimuthal mean about the apex"
    else:
        reason += f"that of an ellipse as trial area, the best that was found, {_where(bound)}"
    pressed = np.isfinite(states.force) & (states.force > 0.0)
    if pressed.any():
        share = float(np.max(1.0 - bound.force[pressed] / states.force[pressed]))
        reason += f"; here up to {100.0 * max(share, 0.0):.2g} % below normal_force"
    level = Level.EXACT
    if theory.interpolated:
        level, reason = Level.APPROXIMATE, f"{reason}; of the heights as they are interpolated"
        if bound.ellipses is None:
            reason += ", and their mean between rings a pixel apart"
    claim = Claim(level, reason, SOURCES["shield"], everywhere)
    return with_errors(
        {"bound": claim}, {"bound": bound.error}, "", "as the mean over finitely many points does"
    )["bound"]


def _where(bound: LowerBound) -> str:
    """Where the best ellipse lies at the row that bears most."""
    found = bound.ellipses
    assert found is not None
    row = int(np.nanargmax(found.force))
    x, y, longer, shorter = (
        metres(float(one[row])) for one in (found.x, found.y, found.longer, found.shorter)
    )
    gain = 100.0 * (bound.force[row] / bound.disk[row] - 1.0) if bound.disk[row] > 0.0 else math.inf
    return (
        f"at the largest indentation about x = {x}, y = {y}, with semi-axes of {longer} and {shorter}, the longer one at "
        f"{math.degrees(float(found.angle[row])) % 180.0:.3g} degrees, {gain:.2g} % above that of the azimuthal mean about the apex"
    )


@dataclass(frozen=True)
class ShapeTheory:
    """What a kind of shape brings to step 3."""

    claims: Callable[[Any, ShapeStates], dict[str, Claim]] = _estimated
    """Of the quantities that it has."""
    references: tuple[str, ...] = ("shield", "barber", "popov-shapes")
    no_radius: str = "the contact is no disk and has no radius"
    no_estimate: str = _UNKNOWN
    """Why there is no estimate, where there is none."""
    measured: str = f"; its error is that of bodies by boundary elements {_MEASURED_ON}"
    """What is said of the error of the estimate."""
    interpolated: bool = False
    """Whether it is known at samples only."""


SHAPES: dict[type[Shape], ShapeTheory] = {
    EllipticParaboloid: ShapeTheory(
        _exact,
        references=("hertz", "shield", "barber", "popov-shapes"),
        no_radius="the contact is an ellipse and has no radius; read semi_axis_x and semi_axis_y",
        no_estimate=f"its error was measured up to a ratio of {LONGEST_RATIO:g} of the radii; normal_force is exact",
        measured="",
    ),
    Pyramid: ShapeTheory(_pyramid, references=("shield", "barber", "popov-shapes", "bilodeau"), measured=""),
    Sampled2D: ShapeTheory(interpolated=True),
}
"""One row for each kind; others are estimated."""


def shape_theory(shape: Shape) -> ShapeTheory:
    """The row of a shape."""
    return next((SHAPES[kind] for kind in type(shape).__mro__ if kind in SHAPES), ShapeTheory())


def shape_assumptions(steepest: float, largest: float, dundurs_beta: float) -> tuple[Assumption, ...]:
    """
    What the half-space model assumes of a shape, measured over the history.

    Parameters
    ----------
    steepest : float
        Largest slope in the contact.
    largest : float
        Largest semi-axis over its radius of curvature; nan for others than elliptic paraboloids.
    dundurs_beta : float

    Returns
    -------
    tuple of Assumption
    """
    slope = Assumption("small slope", "largest slope of the body in the contact", steepest, _SMALL_SLOPE)
    ratio = Assumption("half-space", "semi-axis over radius of curvature a/R", largest, 0.3)
    similar = Assumption(
        "elastic similarity",
        "Dundurs' beta; affects the pressure only with friction",
        abs(dundurs_beta),
        0.5,
    )
    return (slope, similar) if math.isnan(largest) else (slope, ratio, similar)
