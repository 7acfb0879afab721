"""From the record of a force curve to the curve that is fitted: marks, signs, baseline, contact point, lag."""

from pymdr.solving.curves.baselines import Baseline
from pymdr.solving.curves.contacts import ContactPoint, Estimate
from pymdr.solving.curves.measured import MeasuredCurve

__all__ = ["Baseline", "ContactPoint", "Estimate", "MeasuredCurve"]
