"""Least squares over one family of forces, for many curves; work per sample is array formulas, compiled for maps."""

from pymdr.solving.fits.kernels.curves import AS_IT_IS, CurveFits, fit_curves
from pymdr.solving.fits.kernels.descent import Wanted
from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    Batch,
    FamilyTable,
    Member,
    member_at,
    on_machine,
    read,
)
from pymdr.solving.fits.kernels.pulls import point_across_samples, start_near
from pymdr.solving.fits.kernels.starts import Engine

__all__ = [
    "AS_IT_IS",
    "BASE",
    "NUMBERS",
    "POINT",
    "SCALE",
    "SHAPE",
    "TILT",
    "Batch",
    "CurveFits",
    "Engine",
    "FamilyTable",
    "Member",
    "Wanted",
    "fit_curves",
    "member_at",
    "on_machine",
    "point_across_samples",
    "read",
    "start_near",
]
