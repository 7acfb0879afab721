"""Fits of contacts to measured force curves."""

from pymdr.solving.fits.fitting import FitResult, Fitted, fit
from pymdr.solving.fits.maps import FittedMap, fit_map

__all__ = ["FitResult", "Fitted", "FittedMap", "fit", "fit_map"]
