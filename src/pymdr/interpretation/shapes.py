"""What can be claimed of bodies that are not of revolution, and the fields of the elliptic contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import elliprd, elliprf

from pymdr.errors import QuantityError
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
from pymdr.mapping.abel import Curve
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
    if isinstance(shape, EllipticParaboloid):
        claims = _exact(everywhere)
    else:
        claims = _pyramid(shape, everywhere) if isinstance(shape, Pyramid) else _estimated(shape, states)
        claims |= _refused(claims, everywhere)
    none = np.zeros(everywhere.shape, dtype=bool)
    claims["contact_radius"] = Claim(Level.NOT_VALID, _no_radius(shape), SOURCES["johnson"], none)
    claims["force_estimate"] = _estimate_claim(shape, states)
    claims["force_lower_bound"] = _bound_claim(shape, states, bound)
    for name, known in prescribed.items():
        claim = claims[name]
        if known.all():
            claims[name] = Claim(Level.EXACT, "prescribed", claim.source, everywhere)
        elif known.any():
            error = None if claim.error is None else np.where(known, 0.0, claim.error)
            claims[name] = replace(claim, where=claim.where | known, error=error)
    return claims


def _exact(everywhere: BoolArray) -> dict[str, Claim]:
    reason = f"exact {_MODEL}, on an ellipse that is small against the radii of curvature"
    return {name: Claim(Level.EXACT, reason, SOURCES["hertz"], everywhere) for name in OF_SHAPES}


def _pyramid(shape: Pyramid, everywhere: BoolArray) -> dict[str, Claim]:
    sides = shape.sides
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


def _estimate_error(shape: Shape, states: ShapeStates, known: BoolArray) -> tuple[FloatArray | None, str]:
    """The errors of the estimate in the rows in which there is one, None where they are not known; and what is said of them."""
    error = np.where(known, states.error, 0.0)
    if isinstance(shape, Sampled2D):
        return None, "; its error is not known: of heights between the samples it was not measured"
    if np.isnan(error).any():
        return None, f"; its error is not known here: it was measured {_MEASURED_ON}"
    if isinstance(shape, EllipticParaboloid | Pyramid):
        return error, ""
    return error, f"; its error is that of bodies by boundary elements {_MEASURED_ON}"


def _level(error: FloatArray | None) -> Level:
    """Of the estimate: that of a body of revolution is its force."""
    precise = error is not None and float(np.max(error, initial=0.0)) <= EXACT_WITHIN
    return Level.EXACT if precise else Level.APPROXIMATE


def _estimated(shape: Shape, states: ShapeStates) -> dict[str, Claim]:
    known = np.isfinite(states.force)
    error, measured = _estimate_error(shape, states, known)
    reason = f"{_ESTIMATE}; {_MODEL}{measured}" if known.any() else _unknown()
    level = _level(error) if known.any() else Level.NOT_VALID
    claims = {name: Claim(level, reason, SOURCES["popov-shapes"], known, error) for name in _FORCES[:3]}
    if known.any() and not known.all():
        claims = {
            name: replace(
                claim, reason=f"{reason}; at {int((~known).sum())} of {known.size} steps none: {_unknown()}"
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


def _unknown() -> str:
    return (
        "no estimate: in some direction the outline runs beyond what is known of the body, or it is more than "
        f"{LONGEST_OUTLINE:g} times as long as wide, where the error was not measured, or another part of the body may touch, or it is "
        "below the lower bound; press it by boundary elements"
    )


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


def _no_radius(shape: Shape) -> str:
    if isinstance(shape, EllipticParaboloid):
        return "the contact is an ellipse and has no radius; read semi_axis_x and semi_axis_y"
    return "the contact is no disk and has no radius"


def _estimate_claim(shape: Shape, states: ShapeStates) -> Claim:
    known = np.isfinite(states.estimate)
    source = SOURCES["popov-shapes"]
    if not known.any():
        why = _unknown()
        if isinstance(shape, EllipticParaboloid):
            why = f"its error was measured up to a ratio of {LONGEST_RATIO:g} of the radii; normal_force is exact"
        return Claim(Level.NOT_VALID, why, source, known)
    cut = np.any(states.clipped[known] > 0.0)
    outline = "; in some directions it has no outline of its own, and none is offered" if cut else ""
    error, measured = _estimate_error(shape, states, known)
    return Claim(_level(error), f"{_ESTIMATE}{outline}{measured}", source, known, error)


def _bound_claim(shape: Shape, states: ShapeStates, bound: LowerBound) -> Claim:
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
    if isinstance(shape, Sampled2D):
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


def shape_assumptions(
    shape: Shape, steepest: float, largest: float, dundurs_beta: float
) -> tuple[Assumption, ...]:
    """
    What the half-space model assumes of a shape, measured over the history.

    Parameters
    ----------
    shape : Shape
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
    return (slope, ratio, similar) if isinstance(shape, EllipticParaboloid) else (slope, similar)


@dataclass(frozen=True)
class EllipseSurface:
    """The surface of an elliptic contact, row by row."""

    shape: EllipticParaboloid
    modulus: float
    """E* in Pa."""
    indentation: FloatArray
    semi_axis_x: FloatArray
    semi_axis_y: FloatArray
    force: FloatArray
    angle: float = 0.0
    """Direction of the radii in rad."""

    @property
    def gap_function(self) -> Curve:
        """The gap along the radii."""
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        return lambda r: self.shape.gap_at(r * cos, r * sin)

    def towards(self, angle: float) -> EllipseSurface:
        """The same in another direction."""
        return replace(self, angle=angle)

    def default_radii(self, step: int) -> FloatArray:
        """To twice the longer semi-axis, graded to the edge."""
        a, b = float(self.semi_axis_x[step]), float(self.semi_axis_y[step])
        longer = max(a, b) or float(np.nanmax(np.maximum(self.semi_axis_x, self.semi_axis_y))) or 1.0
        # along the angle the edge lies at 1 / hypot(cos / a, sin / b)
        edge = longer
        if min(a, b) > 0.0:
            edge = 1.0 / math.hypot(math.cos(self.angle) / a, math.sin(self.angle) / b)
        inner = edge * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        return np.unique(np.append(inner, np.linspace(edge, 2.0 * longer, 61)))

    def marks(self, step: int) -> tuple[float, ...]:
        """None: the pressure is smooth."""
        return ()

    def edge_amplitude(self, step: int) -> float:
        """nan: the pressure has no singularity."""
        return math.nan

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii in m in one step."""
        x, y = position * math.cos(self.angle), position * math.sin(self.angle)
        axes = float(self.semi_axis_x[step]), float(self.semi_axis_y[step])
        d = float(self.indentation[step])
        if name == "pressure":
            return ellipse_pressure(*axes, float(self.force[step]), x, y)
        if name not in NORMAL_FIELDS:
            raise QuantityError(f"no field {name!r}; fields are {', '.join(NORMAL_FIELDS)}")
        f = self.shape.gap_at(x, y)
        u, inside = np.zeros(x.shape), np.zeros(x.shape, dtype=bool)
        if min(axes) > 0.0:
            inside = (x / axes[0]) ** 2 + (y / axes[1]) ** 2 <= 1.0
            u = ellipse_displacement(*axes, float(self.force[step]) / self.modulus, x, y)
            u = np.where(inside, d - f, u)
        return u if name == "normal_displacement" else np.where(inside, 0.0, f - d + u)


def ellipse_pressure(
    semi_axis_x: float, semi_axis_y: float, force: float, x: FloatArray, y: FloatArray
) -> FloatArray:
    """
    Pressure p = 3 F / (2 pi a_x a_y) sqrt(1 - x^2 / a_x^2 - y^2 / a_y^2) of the elliptic contact.

    Parameters
    ----------
    semi_axis_x, semi_axis_y : float
        In m; 0 without contact.
    force : float
        F in N.
    x, y : ndarray
        Positions in m.

    Returns
    -------
    ndarray
        In Pa; 0 outside.

    Notes
    -----
    Hertz (1882); Johnson (1985), eq. (4.24).
    """
    if not min(semi_axis_x, semi_axis_y) > 0.0:
        return np.zeros(np.shape(x))
    rho = np.hypot(x / semi_axis_x, y / semi_axis_y)
    peak = 1.5 * force / (math.pi * semi_axis_x) / semi_axis_y
    return np.asarray(peak * np.sqrt(np.maximum((1.0 - rho) * (1.0 + rho), 0.0)))


def ellipse_displacement(
    semi_axis_x: float, semi_axis_y: float, force: float, x: FloatArray, y: FloatArray
) -> FloatArray:
    """
    Displacement u_z of the surface around and under an elliptic contact, the potential of its pressure.

    With the largest root l of x^2 / (a^2 + l) + y^2 / (b^2 + l) = 1, 0 in the contact, it is 3 F / (2 pi E*) times R_F(a^2 + l,
    b^2 + l, l) - x^2 / 3 R_D(b^2 + l, l, a^2 + l) - y^2 / 3 R_D(a^2 + l, l, b^2 + l).

    Parameters
    ----------
    semi_axis_x, semi_axis_y : float
        a and b in m, above 0.
    force : float
        F / E* in m^2.
    x, y : ndarray
        Positions in m.

    Returns
    -------
    ndarray
        In m.

    Notes
    -----
    Johnson (1985), eq. (3.65); the integrals are Carlson's (DLMF 19.16).
    """
    size = max(semi_axis_x, semi_axis_y)
    a2, b2 = (semi_axis_x / size) ** 2, (semi_axis_y / size) ** 2
    x2, y2 = (np.asarray(x) / size) ** 2, (np.asarray(y) / size) ** 2
    half = 0.5 * (x2 + y2 - a2 - b2)
    product = np.maximum(x2 * b2 + y2 * a2 - a2 * b2, 0.0)
    root = np.hypot(half, np.sqrt(product))
    with np.errstate(divide="ignore", invalid="ignore"):
        beyond = np.where(half > 0.0, half + root, product / (root - half))
    beyond = np.where(product > 0.0, beyond, 0.0)
    far_a, far_b = a2 + beyond, b2 + beyond
    bent = x2 * elliprd(far_b, beyond, far_a) + y2 * elliprd(far_a, beyond, far_b)
    potential = elliprf(far_a, far_b, beyond) - bent / 3.0
    return np.asarray(1.5 * force / (math.pi * size) * potential)
