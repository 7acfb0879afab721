"""Claims of contacts on viscoelastic layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pymdr.interpretation.certificate import certify_disk
from pymdr.interpretation.memory import NOT_CHECKED, memory_claims
from pymdr.interpretation.validity import NORMAL_FIELDS, BoolArray, Claim, Level, bodies_of
from pymdr.line.curves import Line
from pymdr.line.foundation import states_at_depth
from pymdr.units import FloatArray

LAYERED_FIELDS = (
    "the fields of viscoelastic layers are not computed: their force follows from independent springs, their pressure does not; "
    "solve the elastic layers with the modulus at one time"
)
"""Reason for missing fields."""


def layered_memory_claims(
    names: Sequence[str], line: Line, depth: FloatArray, disk: BoolArray, given: tuple[BoolArray, BoolArray]
) -> dict[str, Claim]:
    """
    Claims of layers of one relaxation function, valid up to the first row whose elastic contact is not a disk.

    Parameters
    ----------
    names : sequence of str
        Quantities.
    line : Line
        The line of the layers.
    depth : ndarray
        Indentation of every row in m.
    disk : ndarray of bool
        Rows whose springs in contact are those of a disk.
    given : tuple of ndarray of bool
        Rows whose force is prescribed, and rows whose indentation is.

    Notes
    -----
    A growing contact of bodies of one relaxation function has the pressure int phi(t - s) dp(s) of elastic contacts, which is not below 0
    where those are disks (Lee and Radok 1960). On a retreat the springs of stiffness dk at the height d0 carry any history, if
    contacts stay disks.
    """
    elastic = certify_disk(line, states_at_depth(line, np.maximum.accumulate(depth)))
    claims = memory_claims(names, disk & elastic.disk, *given, NOT_CHECKED, "")
    bodies, source = bodies_of(line)
    exact = (
        f"exact for {bodies} with one relaxation function in frictionless contact on a disk under any "
        "history; elastic contacts are disks up to the largest indentation; the pressure of retreats is not checked"
    )
    if not elastic.disk.all():
        exact += f"; later rows are not valid: {elastic.reason}"
    unknown = Claim(Level.NOT_VALID, LAYERED_FIELDS, source, np.zeros(depth.size, dtype=bool))
    sound = {
        name: replace(claim, reason=exact, source=source) if claim.where.any() else claim
        for name, claim in claims.items()
    }
    return sound | dict.fromkeys(NORMAL_FIELDS, unknown)
