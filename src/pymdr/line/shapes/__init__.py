"""Normal force over depth of bodies that are not of revolution: exact, computed or estimated."""

from __future__ import annotations

from functools import singledispatch

from pymdr.line.shapes.base import ShapeLaw, ShapeStates
from pymdr.line.shapes.closed import (
    LONGEST_RATIO,
    MANY_SIDES_ERROR,
    PYRAMID_ERROR,
    PYRAMID_FORCES,
    EllipseLaw,
    PyramidLaw,
    ellipse_factor,
    homogeneous_estimate,
    pyramid_factor,
)
from pymdr.line.shapes.rays import LONGEST_OUTLINE, RayLaw, model_error
from pymdr.problem.profiles import EllipticParaboloid, Pyramid, Shape

__all__ = [
    "LONGEST_OUTLINE",
    "LONGEST_RATIO",
    "MANY_SIDES_ERROR",
    "PYRAMID_ERROR",
    "PYRAMID_FORCES",
    "EllipseLaw",
    "PyramidLaw",
    "RayLaw",
    "ShapeLaw",
    "ShapeStates",
    "ellipse_factor",
    "homogeneous_estimate",
    "model_error",
    "pyramid_factor",
    "shape_law",
]


@singledispatch
def shape_law(shape: Shape) -> ShapeLaw:
    """The law of a shape."""
    return RayLaw(shape)


shape_law.register(EllipticParaboloid, EllipseLaw)
shape_law.register(Pyramid, PyramidLaw)
