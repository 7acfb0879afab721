"""Check, map, solve, interpret: the method as one verb, and what is asked around it."""

from pymdr.problem.schedule import Progress
from pymdr.solving.assessing import Assessment, assess
from pymdr.solving.batch import solve_batch
from pymdr.solving.impacts import Impact, Restitution, impact, restitution
from pymdr.solving.loops import FrictionLoop, friction_loop
from pymdr.solving.pulloff import AdhesionRegime, PullOff, adhesion_regime, pull_off
from pymdr.solving.teaching import foundation, friction_foundation
from pymdr.solving.verb import solve

__all__ = [
    "AdhesionRegime",
    "Assessment",
    "FrictionLoop",
    "Impact",
    "Progress",
    "PullOff",
    "Restitution",
    "adhesion_regime",
    "assess",
    "foundation",
    "friction_foundation",
    "friction_loop",
    "impact",
    "pull_off",
    "restitution",
    "solve",
    "solve_batch",
]
