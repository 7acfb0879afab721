"""What can be claimed of a rough contact on the line, and of its power law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.problem.rough import RoughSurface

LINE_QUANTITIES = ("normal_force", "indentation", "normal_stiffness", "elastic_energy")
PUBLISHED, FITTED = 1.9412, 1.45
"""Constants of the power law: as Pohrt and Popov have it, and the middle of what boundary elements give."""
_MOST_OF_POWER_LAW = 0.55
_FITTED_BETWEEN = (0.12, 0.7)
"""Stiffnesses over E* L between which the power law was held against boundary elements."""
_BANDWIDTH = 128.0
"""Longer side over shortest wavelength up to which lines were held against boundary elements."""
_STEEPEST = 0.3

FITTED_SHARES = (0.03, 0.85)
"""Of the stiffness of full contact, between which lines are held against boundary elements."""

_MEASURED = (
    "springs of Geike's line, which do not know each other: against boundary elements of square self-affine patches (H = 0.2 to "
    "0.8) the stiffness at a given force is -11 to +22 % off where the size is 64 shortest wavelengths, and -2 to +44 % where "
    "it is 128, between 0.03 and 0.85 of the stiffness of full contact; more with more decades"
)
_DEPTH = (
    "; the indentation from the highest summit is -10 to +12 % off at a given force with 64, and -18 to 0 % with 128, the force at a "
    "given indentation -32 to +57 %"
)
_UNREPRESENTED = (
    "the length of contact on the line measures stiffness, the sum of the radii of all spots, and area is the sum of their "
    "squares: N spots of one stiffness have areas that fall as 1/N, and the line does not know how many there are"
)
_NOT_ON_THE_LINE: Mapping[str, str] = {
    "contact_area": _UNREPRESENTED,
    "contact_length": f"it is no quantity of the body: {_UNREPRESENTED}",
    "contact_radius": "a rough contact is no disk",
    "pressure": f"{_UNREPRESENTED}; so it does not know pressures",
    "mean_pressure": f"{_UNREPRESENTED}; so it does not know pressures",
    "gap": "springs that are not in contact do not follow the surface: the line does not know gaps, nor what leaks through them",
    "adhesive_force": f"adhesion acts on the edges of spots: {_UNREPRESENTED}; JKR, DMT and MaugisDugdale do not hold for it",
}


def rough_claims(
    surface: RoughSurface, prescribed: str, everywhere: BoolArray, ball: bool
) -> dict[str, Claim]:
    """
    Claims of the line of a rough surface.

    Parameters
    ----------
    surface : RoughSurface
    prescribed : str
        "normal_force" or "indentation".
    everywhere : ndarray of bool
        True for every row.
    ball : bool
        Whether a ball bears the roughness.

    Returns
    -------
    dict of str to Claim
    """
    remarks = []
    if surface.has_roll_off:
        remarks.append(
            "with a roll-off inside the patch no such comparison was made: many asperities share the load, and F/(k h) is one number "
            "(Persson 2007; Pastewka et al. 2013), while that of the line drifts from 0.3 to 0.5 between 0.02 and 0.2 of full contact"
        )
    if surface.size[0] != surface.size[1]:
        remarks.append("rectangles were not compared")
    if ball:
        remarks.append(
            "superposed with a ball (H = 0.7) they have 91 and 95 % of the stiffness of Hertz at 0.5 and 1 of the crossover load, and "
            "64 to 69 % at 0.05 to 0.08, boundary elements 95 to 100 % and 68 to 88 %"
        )
    reason = "; ".join([_MEASURED, *remarks])
    book = SOURCES["rough-line"]
    claims = {name: Claim(Level.APPROXIMATE, reason, book, everywhere) for name in LINE_QUANTITIES}
    if prescribed == "normal_force":
        claims["indentation"] = Claim(Level.APPROXIMATE, reason + _DEPTH, book, everywhere)
    else:
        claims["normal_force"] = Claim(Level.APPROXIMATE, reason + _DEPTH, book, everywhere)
    energy = f"{reason}; the energy is that of the force curve of the line, and was not compared"
    claims["elastic_energy"] = Claim(Level.APPROXIMATE, energy, book, everywhere)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    nowhere = np.zeros(everywhere.shape, dtype=bool)
    for name, why in _NOT_ON_THE_LINE.items():
        claims[name] = Claim(Level.NOT_VALID, why, book, nowhere)
    return claims


def power_law_claims(surface: RoughSurface, share: np.ndarray, ball: bool) -> dict[str, Claim]:
    """
    Claims of k = C/(H + 1) E* L (F/(L h E*))^(1/(1 + H)) with both constants.

    Parameters
    ----------
    surface : RoughSurface
    share : ndarray
        Stiffnesses of the line over E* L, per row.
    ball : bool
        Whether a ball bears the roughness.

    Returns
    -------
    dict of str to Claim
    """
    source = SOURCES["pohrt-popov"]
    why = None
    if ball:
        why = "the power law is that of a patch of a nominally flat surface, and a ball bears this one"
    elif surface.has_roll_off:
        why = (
            "the power law needs a spectrum without roll-off, of which one macroscopic cluster of contacts comes; with a "
            "roll-off inside the patch many asperities share the load and k grows in proportion to F (Persson 2007)"
        )
    elif surface.size[0] != surface.size[1]:
        why = "the power law is that of a square"
    if why is not None:
        claim = Claim(Level.NOT_VALID, why, source, np.zeros(share.shape, dtype=bool))
        return dict.fromkeys(("power_law_stiffness", "fitted_stiffness"), claim)
    low, high = _FITTED_BETWEEN
    published = (
        f"C = {PUBLISHED}: -20 to +25 % off boundary elements with 64 shortest wavelengths in the size and 0 to +70 % with 128 below "
        f"0.15 E* L, 0 to +65 % up to {_MOST_OF_POWER_LAW:g} E* L; beyond, next to full contact, it goes on where the stiffness no "
        "longer grows, and is refused"
    )
    fitted = (
        f"C = {FITTED}, what boundary elements give for H from 0.4 to 0.8 between {low:g} and {high:g} E* L (1.40 to 1.47), where it "
        "is -15 to +21 % off; refused outside"
    )
    told = {
        "power_law_stiffness": (published, share < _MOST_OF_POWER_LAW),
        "fitted_stiffness": (fitted, (share > low) & (share < high)),
    }
    return {
        name: Claim(Level.APPROXIMATE if where.any() else Level.NOT_VALID, reason, source, where)
        for name, (reason, where) in told.items()
    }


def calibration_claims(
    columns: Mapping[str, np.ndarray], inside: BoolArray, surfaces: int, coefficient: float, package: str
) -> dict[str, Claim]:
    """
    Claims of lines that were held against surfaces in three dimensions.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Stiffnesses, areas and shares over the loads.
    inside : ndarray of bool
        Loads in the range of the fit.
    surfaces : int
        How many were pressed.
    coefficient : float
        The fitted lambda.
    package : str
        Of the engine.

    Returns
    -------
    dict of str to Claim
    """
    everywhere = np.ones(inside.shape, dtype=bool)
    elements, book = SOURCES["boundary-elements"], SOURCES["rough-line"]

    def between(name: str, other: str = "stiffness") -> str:
        ratio = (columns[name] / columns[other])[inside]
        return f"{ratio.min():.2f} to {ratio.max():.2f} times"

    few, many = FITTED_SHARES
    span = f"from {few:g} to {many:g} of full contact"
    kinds = {
        "stiffness": (
            f"geometric mean of {surfaces} surfaces by boundary elements ({package}) at a given force; fewer than about 20 leave a scatter "
            "of a third where few asperities bear",
            elements,
        ),
        "line_stiffness": (
            f"Geike's line, lambda = pi: here {between('line_stiffness')} boundary elements {span}; measured before: 0.89 to 1.22 with 64 "
            "shortest waves in the side, 0.98 to 1.44 with 128",
            book,
        ),
        "fitted_stiffness": (
            f"the line with lambda = {coefficient:.3g}: here {between('fitted_stiffness')} {span}; lambda grows with H, differs with the surfaces, and "
            "holds for no other than these; measured before: 3.1 to 4.6 with 64 for H from 0.2 to 0.8, 4.1 to 6.3 with 128",
            book,
        ),
        "power_law": (
            f"C = {PUBLISHED}: here {between('power_law')} {span}, and beyond it does not saturate; measured before: 0.8 to 1.7 below 0.15 "
            "E* L, 1.0 to 1.65 up to 0.55, 1.4 to 3.4 above",
            SOURCES["pohrt-popov"],
        ),
        "area": (
            "by boundary elements, at the resolution of the pixels; finer roughness makes it smaller",
            elements,
        ),
    }
    claims = {name: Claim(Level.APPROXIMATE, *told, everywhere) for name, told in kinds.items()}
    for name in ("stiffness", "line_stiffness", "fitted_stiffness", "area"):
        claims |= {f"{name}_{end}": claims[name] for end in ("low", "high")}
    no_area = f"no area: it is {between('line_share', 'area')} the true one here; {_UNREPRESENTED}"
    claims["line_share"] = Claim(Level.NOT_VALID, no_area, book, ~everywhere)
    return claims


def rough_assumptions(surface: RoughSurface) -> tuple[Assumption, ...]:
    """What the model and its comparisons assume, measured."""
    slope = "root mean square of the slope of the surface"
    band = "size over shortest wavelength; lines are compared with boundary elements up to the limit"
    return (
        Assumption("small slope", slope, surface.rms_slope, _STEEPEST),
        Assumption("measured bandwidth", band, surface.longer_side / surface.shortest, _BANDWIDTH),
    )
