"""Figures: the contact above its line of springs, curves and loops, and fields.

Everything is drawn on :class:`matplotlib.figure.Figure` objects, without pyplot and its global state; the axes can
be restyled afterwards.
"""

from pymdr.presentation.plot.compared import compared_pressures, compared_tractions
from pymdr.presentation.plot.shared import FigureData
from pymdr.presentation.plot.studies import compared_laws, loop_study
from pymdr.presentation.plot.whole import all_figures, overview

__all__ = [
    "FigureData",
    "all_figures",
    "compared_laws",
    "compared_pressures",
    "compared_tractions",
    "loop_study",
    "overview",
]
