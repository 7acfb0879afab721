"""The depths at which a contact without adhesion is a disk, as intervals.

A disk of radius a with g(a) = d is the contact if neither its pressure nor its gap is negative anywhere (the unilateral
conditions, whose solution is unique). Along an interval on which g rises,

    d/da int_r^a g' / sqrt(x^2 - r^2) dx = g'(a) / sqrt(a^2 - r^2)  >= 0   for every r inside,
    d/da int_a^r g' arccos(x / r) dx     = -g'(a) arccos(a / r)     <= 0   for every r outside,

so on such an interval the disks without tension are those above a radius, the disks without other contact those below a
radius, and both form one interval. Its ends are computed by alternating between the extreme radius r, refined between
those that resolve g', and the root in a for that r; no depth is sampled.
"""

from pymdr.interpretation.disks.extremes import RING, gap_ratios, least_gap, least_pressure
from pymdr.interpretation.disks.features import (
    TOLERANCE,
    DecreasingInterval,
    ProfileFeatures,
    apex_kink,
    profile_features,
    touching_range,
)
from pymdr.interpretation.disks.intervals import DiskDepths, disk_depths, holes

__all__ = [
    "RING",
    "TOLERANCE",
    "DecreasingInterval",
    "DiskDepths",
    "ProfileFeatures",
    "apex_kink",
    "disk_depths",
    "gap_ratios",
    "holes",
    "least_gap",
    "least_pressure",
    "profile_features",
    "touching_range",
]
