"""Motion of machines: masses, springs, drives and contacts."""

from pymdr.solving.machines.value import Motion
from pymdr.solving.machines.verb import move

__all__ = ["Motion", "move"]
