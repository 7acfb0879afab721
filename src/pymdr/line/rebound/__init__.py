"""A mass that meets springs with memory and leaves them again."""

from pymdr.line.rebound.motion import Motion, MotionRows, largest_force, motion_rows, rebound

__all__ = ["Motion", "MotionRows", "largest_force", "motion_rows", "rebound"]
