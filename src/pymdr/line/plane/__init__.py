"""Coulomb friction along paths in the plane: springs that carry vectors.

A spring advances exactly over a straight row, whatever its length, so that the number of springs is the only numerical error.
Numba is loaded by the first history that is followed.
"""

from pymdr.line.plane.moved import PlaneContacts
from pymdr.line.plane.springs import (
    PlaneEnding,
    PlaneLaw,
    PlaneRows,
    PlaneState,
    Springs,
    follow_plane,
    virgin_plane,
)

__all__ = [
    "PlaneContacts",
    "PlaneEnding",
    "PlaneLaw",
    "PlaneRows",
    "PlaneState",
    "Springs",
    "follow_plane",
    "virgin_plane",
]
