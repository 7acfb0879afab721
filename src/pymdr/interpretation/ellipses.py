"""The surface of an elliptic contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy

from pymdr.errors import QuantityError
from pymdr.interpretation.validity import NORMAL_FIELDS
from pymdr.mapping.abel import Curve
from pymdr.problem.profiles import EllipticParaboloid
from pymdr.units import FloatArray


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
        """The same surface with radii in another direction."""
        return replace(self, angle=angle)

    def default_radii(self, step: int) -> FloatArray:
        """A grid to twice the longer semi-axis, graded to the edge."""
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
        if name not in ("normal_displacement", "gap"):
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
    bent = x2 * scipy.special.elliprd(far_b, beyond, far_a) + y2 * scipy.special.elliprd(far_a, beyond, far_b)
    potential = scipy.special.elliprf(far_a, far_b, beyond) - bent / 3.0
    return np.asarray(1.5 * force / (math.pi * size) * potential)
