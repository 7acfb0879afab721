"""Claims of a rough contact on the line, and of its power law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.problem.rough import RoughSurface

LINE_QUANTITIES = ("normal_force", "indentation", "normal_stiffness", "elastic_energy")
PUBLISHED, FITTED = 1.9412, 1.45
"""Constants of the power law: by Pohrt and Popov, and the middle of the range by boundary elements."""
_MOST_OF_POWER_LAW = 0.55
_FITTED_BETWEEN = (0.12, 0.7)
"""Range of stiffness over E* L in which the power law was compared with boundary elements."""
_BANDWIDTH = 128.0
"""Largest ratio of longer side to shortest wavelength for which lines were compared with boundary elements."""
_STEEPEST = 0.3

FITTED_FRACTIONS = (0.03, 0.85)
"""Range of stiffness over that of full contact in which lines are compared with boundary elements."""

_MEASURED = (
    "independent springs of Geike's line: compared with boundary elements of square self-affine patches (H = 0.2 to 0.8), the error "
    "of the stiffness at a given force is -11 to +22 % for a size of 64 shortest wavelengths and -2 to +44 % for 128, between 0.03 and "
    "0.85 of the stiffness of full contact; larger for more decades"
)
_DEPTH = (
    "; the error of the indentation from the highest summit at a given force is -10 to +12 % with 64 and -18 to 0 % with 128, that of "
    "the force at a given indentation -32 to +57 %"
)
_UNREPRESENTED = (
    "the contact length on the line represents the stiffness, the sum of the radii of all spots, but the area is the sum of their "
    "squares: at a given stiffness the area of N spots decreases as 1/N, and the line does not determine N"
)
_NOT_ON_THE_LINE: Mapping[str, str] = {
    "contact_area": _UNREPRESENTED,
    "contact_length": f"it is not a quantity of the body: {_UNREPRESENTED}",
    "contact_radius": "a rough contact is not a disk",
    "pressure": f"{_UNREPRESENTED}, so it does not determine pressures",
    "mean_pressure": f"{_UNREPRESENTED}, so it does not determine pressures",
    "gap": "springs outside the contact do not follow the surface: the line does not determine gaps or leakage",
    "adhesive_force": f"adhesion acts on the edges of spots: {_UNREPRESENTED}; JKR, DMT and MaugisDugdale do not apply",
}


def rough_claims(
    surface: RoughSurface, prescribed: str, everywhere: BoolArray, ball: bool
) -> dict[str, Claim]:
    """
    Claims of the line of a rough surface.

    Parameters
    ----------
    prescribed : str
        "normal_force" or "indentation".
    """
    remarks = []
    if surface.has_roll_off:
        remarks.append(
            "not compared for a roll-off inside the patch, where many asperities carry the load and F/(k h) is constant (Persson 2007; "
            "Pastewka et al. 2013), while on the line it drifts from 0.3 to 0.5 between 0.02 and 0.2 of full contact"
        )
    if surface.size[0] != surface.size[1]:
        remarks.append("not compared for rectangles")
    if ball:
        remarks.append(
            "on a ball (H = 0.7) the stiffness is 91 and 95 % of Hertz at 0.5 and 1 of the crossover load (boundary elements 95 to 100 %), "
            "and 64 to 69 % at 0.05 to 0.08 (boundary elements 68 to 88 %)"
        )
    reason = "; ".join([_MEASURED, *remarks])
    book = SOURCES["rough-line"]
    claims = {name: Claim(Level.APPROXIMATE, reason, book, everywhere) for name in LINE_QUANTITIES}
    if prescribed == "normal_force":
        claims["indentation"] = Claim(Level.APPROXIMATE, reason + _DEPTH, book, everywhere)
    else:
        claims["normal_force"] = Claim(Level.APPROXIMATE, reason + _DEPTH, book, everywhere)
    energy = f"{reason}; the energy is that of the force curve of the line and was not compared"
    claims["elastic_energy"] = Claim(Level.APPROXIMATE, energy, book, everywhere)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    none = np.zeros(everywhere.shape, dtype=bool)
    for name, why in _NOT_ON_THE_LINE.items():
        claims[name] = Claim(Level.NOT_VALID, why, book, none)
    return claims


def power_law_claims(surface: RoughSurface, stiffness: np.ndarray, ball: bool) -> dict[str, Claim]:
    """
    Claims of k = C/(H + 1) E* L (F/(L h E*))^(1/(1 + H)) with both constants.

    Parameters
    ----------
    stiffness : ndarray
        Stiffnesses of the line over E* L, per row.
    """
    source = SOURCES["pohrt-popov"]
    why = None
    if ball:
        why = "the power law is for a patch of a nominally flat surface, not for a rough ball"
    elif surface.has_roll_off:
        why = (
            "the power law needs a spectrum without roll-off, which gives one macroscopic cluster of contacts; with a roll-off "
            "inside the patch many asperities carry the load and k is proportional to F (Persson 2007)"
        )
    elif surface.size[0] != surface.size[1]:
        why = "the power law is for a square patch"
    if why is not None:
        claim = Claim(Level.NOT_VALID, why, source, np.zeros(stiffness.shape, dtype=bool))
        return dict.fromkeys(("power_law_stiffness", "fitted_stiffness"), claim)
    low, high = _FITTED_BETWEEN
    published = (
        f"C = {PUBLISHED}: the error compared with boundary elements is -20 to +25 % for a size of 64 shortest wavelengths and 0 to "
        f"+70 % for 128 below 0.15 E* L, 0 to +65 % up to {_MOST_OF_POWER_LAW:g} E* L; not valid above, where the stiffness saturates"
    )
    fitted = (
        f"C = {FITTED}, from boundary elements for H from 0.4 to 0.8 between {low:g} and {high:g} E* L (1.40 to 1.47), with errors of "
        "-15 to +21 % in that range; not valid outside"
    )
    ranges = {
        "power_law_stiffness": (published, stiffness < _MOST_OF_POWER_LAW),
        "fitted_stiffness": (fitted, (stiffness > low) & (stiffness < high)),
    }
    return {
        name: Claim(Level.APPROXIMATE if where.any() else Level.NOT_VALID, reason, source, where)
        for name, (reason, where) in ranges.items()
    }


def calibration_claims(
    columns: Mapping[str, np.ndarray], inside: BoolArray, surfaces: int, coefficient: float, package: str
) -> dict[str, Claim]:
    """
    Claims of lines that were compared with surfaces in three dimensions.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Stiffnesses, areas and contact fractions over the loads.
    inside : ndarray of bool
        Loads in the range of the fit.
    surfaces : int
        Number of pressed surfaces.
    coefficient : float
        The fitted lambda.
    """
    everywhere = np.ones(inside.shape, dtype=bool)
    elements, book = SOURCES["boundary-elements"], SOURCES["rough-line"]

    def between(name: str, other: str = "stiffness") -> str:
        ratio = (columns[name] / columns[other])[inside]
        return f"{ratio.min():.2f} to {ratio.max():.2f} times"

    few, many = FITTED_FRACTIONS
    span = f"from {few:g} to {many:g} of full contact"
    kinds = {
        "stiffness": (
            f"geometric mean of {surfaces} surfaces by boundary elements ({package}) at a given force; with fewer than about 20 surfaces "
            "the scatter is a third at few asperities in contact",
            elements,
        ),
        "line_stiffness": (
            f"Geike's line, lambda = pi: here {between('line_stiffness')} boundary elements {span}; earlier comparisons: 0.89 to 1.22 for "
            "a side of 64 shortest wavelengths, 0.98 to 1.44 for 128",
            book,
        ),
        "fitted_stiffness": (
            f"the line with lambda = {coefficient:.3g}: here {between('fitted_stiffness')} boundary elements {span}; lambda grows with H and "
            "is valid only for these surfaces; earlier fits: 3.1 to 4.6 for 64 and H from 0.2 to 0.8, 4.1 to 6.3 for 128",
            book,
        ),
        "power_law": (
            f"C = {PUBLISHED}: here {between('power_law')} boundary elements {span}, without saturation above; earlier comparisons: 0.8 to "
            "1.7 below 0.15 E* L, 1.0 to 1.65 up to 0.55, 1.4 to 3.4 above",
            SOURCES["pohrt-popov"],
        ),
        "area": (
            "by boundary elements at the resolution of the pixels; finer roughness makes it smaller",
            elements,
        ),
    }
    claims = {
        name: Claim(Level.APPROXIMATE, *reason_and_source, everywhere)
        for name, reason_and_source in kinds.items()
    }
    for name in ("stiffness", "line_stiffness", "fitted_stiffness", "area"):
        claims |= {f"{name}_{end}": claims[name] for end in ("low", "high")}
    no_area = f"not an area: it is {between('line_fraction', 'area')} the true area here; {_UNREPRESENTED}"
    claims["line_fraction"] = Claim(Level.NOT_VALID, no_area, book, ~everywhere)
    return claims


def rough_assumptions(surface: RoughSurface) -> tuple[Assumption, ...]:
    """Assumptions of the model and its comparisons, measured."""
    slope = "root mean square of the slope of the surface"
    band = "size over shortest wavelength; compared with boundary elements up to the limit"
    return (
        Assumption("small slope", slope, surface.rms_slope, _STEEPEST),
        Assumption("measured bandwidth", band, surface.longer_side / surface.shortest, _BANDWIDTH),
    )
