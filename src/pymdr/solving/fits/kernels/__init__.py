"""Least squares over one family of forces, curve by curve: array formulas that NumPy evaluates and, for maps, numba compiles."""

from pymdr.solving.fits.kernels.curves import Curves, FitCurve, Found, fit_curve, fit_curves
from pymdr.solving.fits.kernels.descent import Wanted
from pymdr.solving.fits.kernels.model import BASE, NUMBERS, POINT, SCALE, SHAPE, TILT, FamilyTable

__all__ = [
    "BASE",
    "NUMBERS",
    "POINT",
    "SCALE",
    "SHAPE",
    "TILT",
    "Curves",
    "FamilyTable",
    "FitCurve",
    "Found",
    "Wanted",
    "fit_curve",
    "fit_curves",
]
