"""Compiled least squares of one family of forces: thousands of curves, one after another. Loads numba."""

from pymdr.solving.fits.kernels.curves import fit_curves
from pymdr.solving.fits.kernels.model import ALL, BASE, POINT, SCALE, SHAPE, TILT
from pymdr.solving.fits.kernels.residuals import correlation_times, spans

__all__ = ["ALL", "BASE", "POINT", "SCALE", "SHAPE", "TILT", "correlation_times", "fit_curves", "spans"]
