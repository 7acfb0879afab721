"""Check, map, solve, interpret: the method as one verb, and what is asked around it."""

from pymdr.problem.schedule import Progress
from pymdr.solving.assessing import Assessment, assess
from pymdr.solving.batch import solve_batch
from pymdr.solving.teaching import foundation
from pymdr.solving.verb import solve

__all__ = ["Assessment", "Progress", "assess", "foundation", "solve", "solve_batch"]
