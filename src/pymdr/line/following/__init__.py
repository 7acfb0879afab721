"""Follow a path on a curve of equilibrium states that folds: branches, jumps and their energies, for any law.

A curve s -> D(s) gives the control coordinate of every equilibrium. Rule (quasi-static, overdamped): the state
grows (s rises) while D > D(s) and shrinks while D < D(s). So rising parts of the curve are stable; at a fold the
state jumps, at constant D, to the next rising part in its direction, or loses contact at the start of the curve.
All folds are found first; then the branches are tabulated once and any number of paths is followed on them.
"""

from pymdr.line.following.audit import energy_residual
from pymdr.line.following.branches import turning_points
from pymdr.line.following.curves import (
    Curve,
    Equilibria,
    parameter_reaching,
    sampled_curve,
    under_control,
    under_machine,
)
from pymdr.line.following.hysteresis import Edge, EdgeHistory, follow_with_hysteresis
from pymdr.line.following.moved import Branches, HystereticTracks, RestingBranches, tabulated_track
from pymdr.line.following.paths import Balance, History, Jumps, Route, energy_balance, follow, pressed, pulled
from pymdr.line.following.tracks import Track, Transitions, settled, trace

__all__ = [
    "Balance",
    "Branches",
    "Curve",
    "Edge",
    "EdgeHistory",
    "Equilibria",
    "History",
    "HystereticTracks",
    "Jumps",
    "RestingBranches",
    "Route",
    "Track",
    "Transitions",
    "energy_balance",
    "energy_residual",
    "follow",
    "follow_with_hysteresis",
    "parameter_reaching",
    "pressed",
    "pulled",
    "sampled_curve",
    "settled",
    "tabulated_track",
    "trace",
    "turning_points",
    "under_control",
    "under_machine",
]
