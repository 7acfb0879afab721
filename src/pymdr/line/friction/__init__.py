"""Coulomb friction along one direction: the memory stack, exact in space for arbitrary histories.

Spring y = g(x) of the line carries q = mu E* t(y) with t = v - b(y), v = G* u_x / (mu E*) the normalised shift and
b the spring's anchor. Coulomb's law |t| <= d - y says that the curve b lies in the backward cone of (d, v), so a
straight move cuts the curve at the new depth, replaces what lies outside the cone by its edge (slope 1 or -1) and
appends the new point: a short stack of vertices, amortised constant cost (Cattaneo 1938; Mindlin and Deresiewicz
1953; Jaeger 1993; Aleshin et al. 2015).

Exact within the Cattaneo-Mindlin frame: elastically similar bodies, tractions in one direction. Numba is loaded
by the first history followed, not by importing this module. Most arguments are not checked here. A row that cannot
be followed ends the run: later values are NaN, and the result states the row.
"""

from pymdr.line.friction.closed_forms import (
    SpringHistory,
    cattaneo_mindlin,
    loop_energy,
    shift_ratio_at,
    springs,
)
from pymdr.line.friction.collisions import TangentialMotion, follow_collision
from pymdr.line.friction.curves import ElasticCurves, curves_of, power_law_curves, tabulated_curves
from pymdr.line.friction.driver import depths_at_force, evaluate, opposed_parts
from pymdr.line.friction.histories import (
    FrictionLeg,
    Replay,
    follow_displacements,
    follow_forces,
    follow_indentation_with_force,
    follow_leg,
    follow_load_with_shift,
)
from pymdr.line.friction.stacks import Stacks
from pymdr.line.friction.state import (
    Ending,
    FrictionHistory,
    FrictionState,
    Superposition,
    spring_shifts,
    superposition,
    virgin_state,
)

__all__ = [
    "ElasticCurves",
    "Ending",
    "FrictionHistory",
    "FrictionLeg",
    "FrictionState",
    "Replay",
    "SpringHistory",
    "Stacks",
    "Superposition",
    "TangentialMotion",
    "cattaneo_mindlin",
    "curves_of",
    "depths_at_force",
    "evaluate",
    "follow_collision",
    "follow_displacements",
    "follow_forces",
    "follow_indentation_with_force",
    "follow_leg",
    "follow_load_with_shift",
    "loop_energy",
    "opposed_parts",
    "power_law_curves",
    "shift_ratio_at",
    "spring_shifts",
    "springs",
    "superposition",
    "tabulated_curves",
    "virgin_state",
]
