"""Claims of bodies that yield."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.problem.plasticity import ElasticPlastic

PLASTIC_QUANTITIES = (
    "indentation",
    "normal_force",
    "contact_radius",
    "residual_indentation",
    "apparent_radius",
    "normal_stiffness",
    "mean_pressure",
    "elastic_energy",
    "dissipated_energy",
    "external_work",
    "yielding",
    "jumped",
    "travel",
)
_FALL = (
    "within 1.2 times the indentation of first yield it decreases by up to 9 % (0.7 % of the work) before it grows, because the line "
    "changes abruptly"
)
NO_FIELDS = (
    "the model of a body that yields gives the force and the radius of its contact; its line is not that of the deformed body, so it "
    "gives neither pressures nor displacements"
)
_LIMIT = 0.5
"""Largest indentation over the radius: above it opposite contacts stiffen the ball by more than 1 %."""


def plastic_claims(
    body: ElasticPlastic, adhesive: bool, prescribed: Mapping[str, BoolArray], rows: int
) -> dict[str, Claim]:
    """Claims of a ball that yields."""
    reason = (
        "the model of an elastic, ideally plastic ball on a rigid flat, whose pressure at yield is fitted to finite elements; its error "
        "and the range of d/R and Y/E of the fit are not known; the manual of LAMMPS, which offers the model for large deformation, "
        "requires only 0 <= nu <= 0.5"
    )
    if body.apparent_radius:
        reason += "; the growth of the apparent radius is averaged over ten rows, so the result depends on the number of rows; impacts take the limit of many"
    elif not body.wall_factor:
        reason += "; without growth of the apparent radius and without the wall factor the force at d = 0.12 R is 2 to 3 % below that with both"
    if adhesive:
        reason += "; attraction acts on unloading only (rule of Hess), and the edge does not advance by it"
    everywhere = np.ones(rows, dtype=bool)
    claim = Claim(Level.APPROXIMATE, reason, SOURCES["zunker-kamrin"], everywhere)
    claims = dict.fromkeys(PLASTIC_QUANTITIES, claim)
    if body.apparent_radius:
        work = replace(claim, reason=f"{reason}; the work is a trapezoidal sum over the rows")
        claims |= dict.fromkeys(("dissipated_energy", "external_work"), work)
    else:
        claims["dissipated_energy"] = replace(claim, reason=f"{reason}; {_FALL}")
    for name, where in prescribed.items():
        if name in claims and where.all():
            claims[name] = Claim(Level.EXACT, "prescribed", claim.source, everywhere)
    nothing = Claim(Level.NOT_VALID, NO_FIELDS, claim.source, ~everywhere)
    return claims | dict.fromkeys(NORMAL_FIELDS, nothing)


def plastic_assumptions(largest: float, radius: float) -> tuple[Assumption, ...]:
    """The assumption of the model, for a largest indentation in m of a ball of a radius in m."""
    text = "largest indentation over the radius of the ball; above it the whole ball stiffens the contact"
    return (Assumption("local yield", text, largest / radius, _LIMIT),)
