"""Motion of masses on springs, dampers and contacts."""

from pymdr.line.motion.driver import Followed, Joints, System, follow_motion

__all__ = ["Followed", "Joints", "System", "follow_motion"]
