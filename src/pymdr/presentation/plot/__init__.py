"""Figures: the contact above its line of springs, curves and loops, and fields.

Everything is drawn on :class:`matplotlib.figure.Figure` objects, without pyplot and its global state; the axes can
be restyled afterwards.
"""

from pymdr.presentation.plot.adhesion import adhesive_figures, adhesive_overview
from pymdr.presentation.plot.attraction import compared_laws, pull_off_figure
from pymdr.presentation.plot.closure import CurveData, closure_figures, closure_overview
from pymdr.presentation.plot.compared import compared_pressures, compared_shape, compared_tractions
from pymdr.presentation.plot.conductance import conduction_figure
from pymdr.presentation.plot.exported import law_study
from pymdr.presentation.plot.fatigue import fatigue_study
from pymdr.presentation.plot.fits import (
    fitted_curves,
    fitted_groups,
    fitted_map,
    growing_ranges,
    sheet_of_records,
    weighed_laws,
)
from pymdr.presentation.plot.friction import frictional_figures, frictional_overview
from pymdr.presentation.plot.heating import frictional_heat_study, joule_study
from pymdr.presentation.plot.impacts import impact_figure, restitution_study
from pymdr.presentation.plot.interior import (
    StressedBody,
    StressFrame,
    stress_figure,
    stress_section,
    write_stress_animation,
)
from pymdr.presentation.plot.layers import thickness_study
from pymdr.presentation.plot.measured import measured_curves
from pymdr.presentation.plot.memory import memory_figures, memory_overview
from pymdr.presentation.plot.nanoindentation import (
    area_study,
    drift_study,
    film_study,
    indent_study,
    pop_in_study,
    profile_study,
)
from pymdr.presentation.plot.plane import compared_plane, planar_figures, planar_overview
from pymdr.presentation.plot.plastic import PlasticData, plastic_figures, plastic_overview
from pymdr.presentation.plot.press import pressed_surface
from pymdr.presentation.plot.rolling import rolling_study, sliding_study
from pymdr.presentation.plot.rough import calibration_study, rough_study
from pymdr.presentation.plot.shakedown import shakedown_map
from pymdr.presentation.plot.shapes import ShapeData, shape_figures, shape_overview
from pymdr.presentation.plot.shared import FigureData, LayersDrawn, Plots, with_unmet
from pymdr.presentation.plot.soft import soft_figures, soft_overview
from pymdr.presentation.plot.studies import columns_study, conditions_study, loop_study
from pymdr.presentation.plot.sweeps import sweep_curves
from pymdr.presentation.plot.topography import bump_study, spectrum_study
from pymdr.presentation.plot.wear import compared_wear, fretting_log, running_conditions_map, wear_study
from pymdr.presentation.plot.whole import normal_figures, normal_overview

__all__ = [
    "CurveData",
    "FigureData",
    "LayersDrawn",
    "PlasticData",
    "Plots",
    "ShapeData",
    "StressFrame",
    "StressedBody",
    "adhesive_figures",
    "adhesive_overview",
    "area_study",
    "bump_study",
    "calibration_study",
    "closure_figures",
    "closure_overview",
    "columns_study",
    "compared_laws",
    "compared_plane",
    "compared_pressures",
    "compared_shape",
    "compared_tractions",
    "compared_wear",
    "conditions_study",
    "conduction_figure",
    "drift_study",
    "fatigue_study",
    "film_study",
    "fitted_curves",
    "fitted_groups",
    "fitted_map",
    "fretting_log",
    "frictional_figures",
    "frictional_heat_study",
    "frictional_overview",
    "growing_ranges",
    "impact_figure",
    "indent_study",
    "joule_study",
    "law_study",
    "loop_study",
    "measured_curves",
    "memory_figures",
    "memory_overview",
    "normal_figures",
    "normal_overview",
    "planar_figures",
    "planar_overview",
    "plastic_figures",
    "plastic_overview",
    "pop_in_study",
    "pressed_surface",
    "profile_study",
    "pull_off_figure",
    "restitution_study",
    "rolling_study",
    "rough_study",
    "running_conditions_map",
    "shakedown_map",
    "shape_figures",
    "shape_overview",
    "sheet_of_records",
    "sliding_study",
    "soft_figures",
    "soft_overview",
    "spectrum_study",
    "stress_figure",
    "stress_section",
    "sweep_curves",
    "thickness_study",
    "wear_study",
    "weighed_laws",
    "with_unmet",
    "write_stress_animation",
]
