"""Motion of machines: masses, springs, drives and contacts."""

from pymdr.solving.moving.value import Motion
from pymdr.solving.moving.verb import move

__all__ = ["Motion", "move"]
