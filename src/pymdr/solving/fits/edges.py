"""The force of adhesive contacts whose edge has a history: bodies with memory, and hysteresis of adhesion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.soft.springs import FINE, ZoneLevel
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Path
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.soft import zone_force
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, newtons

_FIRST, _FEWEST = 0.05, 5
"""Part of a record out of contact, and the smallest number of its samples."""
_FELT, _ROUNDED = 6.0, 1e-3
"""Smallest force of a contact, relative to the noise, and relative to the range of the force."""
_MARGIN, _LEAST_MARGIN = 0.01, 1
"""Samples next to a jump that the first search leaves out, relative to all, and their smallest number."""


@dataclass(frozen=True)
class EdgeForces:
    """Forces of an adhesive contact along the whole record, from the free bodies on."""

    contact: Contact
    time: FloatArray | None
    """In s; None without memory."""
    compliance: float
    """Of the machine in m/N; 0 for indentations."""
    zone: ZoneLevel = FINE
    """Resolution of cohesive zones with memory."""
    fold: float = math.inf

    def at(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N at the indentations or travels of the record in m, and NaN for the stiffness, which is not defined."""
        unknown = np.full(position.shape, math.nan)
        if self.contact.is_cohesive:
            assert self.time is not None
            stiffness = 1.0 / self.compliance if self.compliance > 0.0 else math.inf
            return zone_force(self.contact, self.time, position, stiffness, self.zone), unknown
        force = solve_edge(self.contact, self.time, position, self.compliance).data["normal_force"].values
        return np.nan_to_num(force), unknown


def solve_edge(contact: Contact, time: FloatArray | None, position: FloatArray, compliance: float) -> Result:
    """
    The contact solved along a record.

    Parameters
    ----------
    contact : Contact
    time : ndarray or None
        In s.
    position : ndarray
        Indentations in m, or travels of a machine of a compliance in m/N above 0.
    """
    start = None if time is None else time - time[0]
    if compliance > 0.0:
        return solve(contact, Path(time=start, travel=position), machine_stiffness=1.0 / compliance)
    return solve(contact, Path(time=start, indentation=position))


def onset(contact: Contact, curve: MeasuredCurve) -> tuple[float, float]:
    """Approximate contact point in m and baseline in N of a record, from its first force."""
    level, felt = _felt(curve, curve.force)
    first = int(np.argmax(felt))
    if first < _FEWEST:
        raise ProblemError(
            f"the record begins in contact, or its baseline is tilted: sample {first + 1} differs by {newtons(float(curve.force[first]) - level)} from the level "
            f"of the first samples, and {_FEWEST} samples out of contact are needed, because the adhesive force depends on what was before; give the "
            "approach too, or level the record by prepare()"
        )
    law = contact.adhesion
    assert law is not None
    range_ = law.work / law.cohesive_stress if law.cohesive_stress else 0.0
    return float(curve.position[first]) + range_, level


def _felt(curve: MeasuredCurve, force: FloatArray) -> tuple[float, BoolArray]:
    """Level in N of the first forces in N, and the samples that differ from it, two of them in a row."""
    count = max(_FEWEST, int(_FIRST * force.size))
    level = float(np.median(force[:count]))
    # second differences, in which slopes cancel, are sqrt(6) times as large as white noise
    noise = 1.4826 * float(np.median(np.abs(np.diff(force, 2)))) / math.sqrt(6.0)
    felt = np.abs(force - level) > max(_FELT * noise, _ROUNDED * float(np.ptp(force)))
    pairs = felt[:-1] & felt[1:]
    felt = np.append(pairs, False) | np.insert(pairs, 0, False)
    if not felt.any():
        felt[int(np.argmax(curve.position))] = True
    return level, felt


def off_jumps(curve: MeasuredCurve, force: FloatArray, touches: BoolArray | None = None) -> BoolArray:
    """
    Samples away from the jumps of a record into contact and out of it, where a model would have to jump between the same samples.

    With the samples in contact of a model only those between a jump of the model and that of the record, and next to either, are left out.

    Parameters
    ----------
    curve : MeasuredCurve
    force : ndarray
        Its force in N, level out of contact: a tilt would look like contact.
    touches : ndarray of bool, optional
        Samples in contact of a model.
    """
    _, felt = _felt(curve, force)
    margin = max(_LEAST_MARGIN, int(_MARGIN * felt.size)) if touches is None else 1
    own = felt if touches is None or not touches.any() else touches
    keep = np.ones(felt.size, dtype=bool)
    for one, other in zip(_jumps(felt), _jumps(own), strict=True):
        keep[max(min(one, other) - margin, 0) : max(one, other) + margin] = False
    return keep


def _jumps(touches: BoolArray) -> tuple[int, int]:
    """The first sample in contact, and the first sample out of it again."""
    inside = np.flatnonzero(touches)
    return int(inside[0]), int(inside[-1]) + 1
