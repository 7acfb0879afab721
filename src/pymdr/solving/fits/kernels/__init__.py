"""Least squares over one family of forces, curves together; what is done at every sample is array formulas, and compiled for maps."""

from pymdr.solving.fits.kernels.curves import AS_IT_IS, Found, fit_curves
from pymdr.solving.fits.kernels.descent import Wanted
from pymdr.solving.fits.kernels.model import BASE, NUMBERS, POINT, SCALE, SHAPE, TILT, Batch, FamilyTable
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
    "Engine",
    "FamilyTable",
    "Found",
    "Wanted",
    "fit_curves",
]
