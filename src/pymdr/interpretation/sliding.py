"""What can be claimed of a profile that slides over an elastomer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.units import FloatArray

LINE_QUANTITIES = (
    "friction_coefficient",
    "friction_force",
    "normal_force",
    "indentation",
    "leading_edge",
    "trailing_edge",
)
_SLOWEST = 0.05
"""By how much springs may part from their own slow limit for it to be taken for the friction."""


@dataclass(frozen=True)
class Limits:
    """What is known of the limits of slow and fast sliding; a reason stands for what is not."""

    slow: str | None
    """Why there is no slow limit, or None."""
    fast: str | None
    """Why there is no fast limit, or None."""
    glassy: bool
    """Whether the bodies answer a step at once, so that the fast limit is that of two half-spaces."""


def sliding_claims(
    prescribed: str, limits: Limits, everywhere: BoolArray, error: FloatArray, remark: str
) -> dict[str, Claim]:
    """
    Claims of a sliding contact.

    Parameters
    ----------
    prescribed : str
        "normal_force" or "indentation".
    limits : Limits
    everywhere : ndarray of bool
        True for every speed.
    error : ndarray
        Relative errors of the numbers at every speed.
    remark : str
        What else the numbers rest on.

    Returns
    -------
    dict of str to Claim
    """
    known = []
    if limits.slow is None:
        known.append("twice the exact value where sliding is slow")
    if limits.glassy and limits.fast is None:
        known.append("the exact value where it is fast")
    reason = (
        "springs along one line, which feel a whole gradient where the surface feels the part along the way: "
        + (f"their friction is {' and '.join(known)}, and qualitative elsewhere" if known else "qualitative")
        + remark
    )
    book = SOURCES["popov-hess"]
    force = Claim(Level.APPROXIMATE, reason, book, everywhere, error)
    edges = Claim(Level.APPROXIMATE, f"of the springs, not of the surface: {reason}", book, everywhere, error)
    claims = {name: edges if name.endswith("edge") else force for name in LINE_QUANTITIES}
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    nowhere = np.zeros(everywhere.shape, dtype=bool)
    for name, why in (
        ("slow_limit", limits.slow),
        ("fast_limit", limits.fast),
        ("pressure", "springs along one line do not know how the pressure of a sliding contact is spread"),
        (
            "contact_radius",
            "a sliding contact is no disk; leading_edge and trailing_edge are those of the springs",
        ),
    ):
        if why is not None:
            claims[name] = Claim(Level.NOT_VALID, why, book, nowhere)
    exact = (
        "exact to the first order {} for half-spaces with this E*(t), frictionless, on a disk whose edge is smooth; the springs "
        "{}{}"
    )
    source = SOURCES["lee-radok"]
    if limits.slow is None:
        told = exact.format("in the speed", "have twice of it", remark)
        claims["slow_limit"] = Claim(Level.EXACT, told, source, everywhere)
    if limits.fast is None and limits.glassy:
        told = exact.format("in one over the speed", "have the same", remark)
        claims["fast_limit"] = Claim(Level.EXACT, told, source, everywhere)
    elif limits.fast is None:
        told = f"the limit of the springs, int_0^a g'^2 dx / d at the depth of every speed{remark}"
        claims["fast_limit"] = Claim(Level.APPROXIMATE, told, book, everywhere)
    return claims


def rough_sliding_claims(prescribed: str, everywhere: BoolArray, error: FloatArray) -> dict[str, Claim]:
    """
    Claims of a rough line that slides.

    Parameters
    ----------
    prescribed : str
        "normal_force" or "indentation".
    everywhere : ndarray of bool
        True for every speed.
    error : ndarray
        Relative errors of the numbers at every speed.

    Returns
    -------
    dict of str to Claim
    """
    book = SOURCES["popov-hess"]
    reason = (
        "qualitative: springs below a random line of one seed, which stands for a rough surface by its spectrum; neither the contact "
        "nor the loss of a surface is that of a line, and by how much they differ has not been measured"
    )
    claim = Claim(Level.APPROXIMATE, reason, book, everywhere, error)
    claims = dict.fromkeys(("friction_coefficient", "friction_force", "normal_force", "indentation"), claim)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    nowhere = np.zeros(everywhere.shape, dtype=bool)
    for name in ("slow_limit", "fast_limit"):
        claims[name] = Claim(Level.NOT_VALID, "the limits of a rough surface are not known", book, nowhere)
    area = "the part of a line that is touched is not the contact of a surface"
    for name in ("contact_area", "pressure", "leading_edge", "trailing_edge"):
        claims[name] = Claim(Level.NOT_VALID, area, book, nowhere)
    return claims


def slowness(friction: FloatArray, slow_limit: FloatArray) -> Assumption:
    """
    Whether all speeds are slow, by the springs: their exact limit is known, twice that of the surface.

    Parameters
    ----------
    friction : ndarray
        Coefficients of friction of the springs.
    slow_limit : ndarray
        Those of the surface to the first order.

    Returns
    -------
    Assumption
    """
    parted = float(np.max(np.abs(friction / (2.0 * slow_limit) - 1.0)))
    words = "slow_limit is for slow sliding: the springs part from their own slow limit by a share of"
    return Assumption("slow sliding", words, parted, _SLOWEST)
