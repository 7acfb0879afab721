"""Properties of a callable that its map needs: rounding, slope, tip and kinks."""

from __future__ import annotations

from pymdr.mapping.callables.consistency import check_consistency as check_consistency
from pymdr.mapping.callables.kinks import find_kinks as find_kinks
from pymdr.mapping.callables.kinks import polished as polished
from pymdr.mapping.callables.noise import rounding as rounding
from pymdr.mapping.callables.noise import scatter as scatter
from pymdr.mapping.callables.noise import search_points as search_points
from pymdr.mapping.callables.noise import slope_panel as slope_panel
from pymdr.mapping.callables.steps import Steps as Steps
from pymdr.mapping.callables.tip import TipLaw as TipLaw
from pymdr.mapping.callables.tip import tip_law as tip_law
from pymdr.mapping.callables.tip import underflow_law as underflow_law
