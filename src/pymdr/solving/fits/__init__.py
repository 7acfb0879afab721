"""Fits of contacts to measured force curves."""

from pymdr.solving.fits.fitting import FitResult, Fitted, fit

__all__ = ["FitResult", "Fitted", "fit"]
