"""Fits of contacts to measured force curves."""

from pymdr.solving.fits.comparing import LawComparison, compare_laws
from pymdr.solving.fits.each import FittedCurves, fit_each
from pymdr.solving.fits.fitting import fit
from pymdr.solving.fits.growing import RangeStudy, fit_over_indentation
from pymdr.solving.fits.maps import FittedMap, fit_map
from pymdr.solving.fits.results import FitResult, Fitted

__all__ = [
    "FitResult",
    "Fitted",
    "FittedCurves",
    "FittedMap",
    "LawComparison",
    "RangeStudy",
    "compare_laws",
    "fit",
    "fit_each",
    "fit_map",
    "fit_over_indentation",
]
