"""Adhesion on the line: a law gives a curve of equilibrium states (a, c, d, F, energy) with one parameter.

`JKR`, `DMT` and `maugis_dugdale` make curves of any equivalent profile; `pymdr.line.following`
determines which of their states a loading path visits. Closed forms and fast kernels serve single quantities.
"""

from pymdr.line.adhesion.closed_forms import (
    DMT_BELOW,
    JKR_ABOVE,
    PullOff,
    dmt_pull,
    maugis_parameter,
    power_law_factor,
    power_law_pull_off,
    rigid_pull,
    tabor_parameter,
)
from pymdr.line.adhesion.equivalent_line import States
from pymdr.line.adhesion.full_stick import ShearedJKR
from pymdr.line.adhesion.hysteresis import EdgeJKR, Works, edge_states
from pymdr.line.adhesion.kernels import jkr_force, jkr_power_law_force
from pymdr.line.adhesion.maugis import MaugisDugdale, maugis_dugdale
from pymdr.line.adhesion.short_range import DMT, JKR, energy_release_rate, jkr_opening, stress_intensity

__all__ = [
    "DMT",
    "DMT_BELOW",
    "JKR",
    "JKR_ABOVE",
    "EdgeJKR",
    "MaugisDugdale",
    "PullOff",
    "ShearedJKR",
    "States",
    "Works",
    "dmt_pull",
    "edge_states",
    "energy_release_rate",
    "jkr_force",
    "jkr_opening",
    "jkr_power_law_force",
    "maugis_dugdale",
    "maugis_parameter",
    "power_law_factor",
    "power_law_pull_off",
    "rigid_pull",
    "stress_intensity",
    "tabor_parameter",
]
