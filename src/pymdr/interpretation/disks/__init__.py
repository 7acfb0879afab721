"""The depths at which a contact without adhesion is a disk, as intervals.

A disk of radius a with g(a) = d is the contact where its pressure is nowhere negative and its gap is nowhere negative
(together they are the unilateral conditions, whose solution is unique). Along a stretch on which g rises,

    d/da int_r^a g' / sqrt(x^2 - r^2) dx = g'(a) / sqrt(a^2 - r^2)  >= 0   for every r inside,
    d/da int_a^r g' arccos(x / r) dx     = -g'(a) arccos(a / r)     <= 0   for every r outside,

so the disks of a stretch without tension are those beyond a radius, the disks without another touch are those before
a radius, and what is both is one interval. Its ends are found by the extreme radius r, refined between those that
resolve g', and the root in a for that r, in turn; no depth is sampled.
"""

from pymdr.interpretation.disks.extremes import RING, gap_ratios, least_gap, least_pressure
from pymdr.interpretation.disks.intervals import DiskDepths, disk_depths, holes
from pymdr.interpretation.disks.landscape import (
    TOLERANCE,
    Fall,
    Landscape,
    apex_kink,
    landscape_of,
    seen_upto,
)

__all__ = [
    "RING",
    "TOLERANCE",
    "DiskDepths",
    "Fall",
    "Landscape",
    "apex_kink",
    "disk_depths",
    "gap_ratios",
    "holes",
    "landscape_of",
    "least_gap",
    "least_pressure",
    "seen_upto",
]
