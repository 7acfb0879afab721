"""The impact of a mass on springs with memory."""

from pymdr.line.rebound.energies import Energies, energies
from pymdr.line.rebound.motion import Motion, MotionRows, branches, largest_force, motion_rows, rebound

__all__ = [
    "Energies",
    "Motion",
    "MotionRows",
    "branches",
    "energies",
    "largest_force",
    "motion_rows",
    "rebound",
]
