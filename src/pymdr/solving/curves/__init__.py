"""From the record of a force curve to the curve that is fitted: marks, signs, baseline, contact point, lag."""

from pymdr.solving.curves.baselines import Baseline, baseline_of, subtract_baseline
from pymdr.solving.curves.contacts import ContactPoint, Estimate, contact_point_of, set_contact_point
from pymdr.solving.curves.marking import leave_out_marked, mark_outliers, mark_saturated
from pymdr.solving.curves.preparing import join_segments, orient, prepare, recalibrate, to_indentation, undo

__all__ = [
    "Baseline",
    "ContactPoint",
    "Estimate",
    "baseline_of",
    "contact_point_of",
    "join_segments",
    "leave_out_marked",
    "mark_outliers",
    "mark_saturated",
    "orient",
    "prepare",
    "recalibrate",
    "set_contact_point",
    "subtract_baseline",
    "to_indentation",
    "undo",
]
