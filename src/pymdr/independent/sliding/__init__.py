"""Frictional half-space by boundary elements on square cells: vector Coulomb law, no Abel map, no springs.

Tractions are constant on each cell; Love's and Cerruti's integrals over a cell give the displacements, applied by
zero-padded Fourier transforms. The normal problem is solved independently (elastic similarity). Every row of a history is
Kalker's convex problem for the tangential tractions, with the displacements of the preceding row as reference.
"""

from pymdr.independent.sliding.following import HalfSpaceGrid, SlidingSolution, solve_sliding
from pymdr.independent.sliding.surface import influence

__all__ = ["HalfSpaceGrid", "SlidingSolution", "influence", "solve_sliding"]
