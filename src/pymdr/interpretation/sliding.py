"""Claims of a profile that slides over an elastomer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level, total_error
from pymdr.problem.profiles import Cone, Paraboloid, PowerLaw, Profile, Sphere
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
"""Largest relative error of a limit that is given as the friction."""
_TWICE = 1.0
"""Relative error of the friction of the springs, at most twice that of the surface under a given force."""
_STIFFENS = 1e3
"""Largest ratio of instantaneous to relaxed modulus for which this error was measured."""
_EXPONENTS = (1.0, 4.0)
"""Range of the exponents n of profiles r^n for which it was measured."""


@dataclass(frozen=True)
class Limits:
    """The limits of slow and fast sliding, with the reason if a limit is unknown."""

    slow: str | None
    """Why there is no slow limit, or None."""
    fast: str | None
    """Why there is no fast limit, or None."""
    glassy: bool
    """Whether the bodies have an instantaneous response, so that the fast limit is that of two half-spaces."""
    slow_error: FloatArray | None = None
    """Relative error of the slow limit at every speed, an upper bound from the springs."""
    fast_error: FloatArray | None = None
    """Relative error of the fast limit, a/(v tau) with the shortest relaxation time."""


def friction_error(
    profile: Profile, prescribed: str, limits: Limits, stiffens: float, everywhere: BoolArray
) -> tuple[FloatArray | None, str]:
    """
    Relative error of the friction of the springs compared with that of the surface, and its source.

    Parameters
    ----------
    prescribed : str
        "normal_force" or "indentation".
    stiffens : float
        Instantaneous over relaxed modulus.

    Returns
    -------
    error : ndarray or None
        Relative to the friction of the surface; None if unknown.
    words : str

    Notes
    -----
    The ratio is exactly 2 for slow sliding. Compared with boundary elements on a half-space with up to 40 x 40 cells at 13 speeds,
    for r, r^2 and r^4 and ratios of moduli from 2 to 1000 under the same force, it decreases from 2 at slow to 1 at fast speeds.
    """
    if limits.slow_error is not None and np.max(limits.slow_error) <= _SLOWEST:
        return np.full(
            everywhere.shape, _TWICE
        ), "sliding is slow, so the friction of the springs is twice that of the surface"
    if prescribed != "normal_force":
        return (None, "the error at a given indentation is unknown: a ratio up to three was measured")
    exponent = 2.0 if isinstance(profile, Paraboloid | Sphere) else 1.0 if isinstance(profile, Cone) else None
    exponent = profile.exponent if isinstance(profile, PowerLaw) else exponent
    if exponent is None or not _EXPONENTS[0] <= exponent <= _EXPONENTS[1]:
        return (
            None,
            f"the error for a {type(profile).__name__} is unknown: it was measured for r, r^2 and r^4",
        )
    if not stiffens <= _STIFFENS:
        return None, (
            f"the error is unknown for bodies whose modulus relaxes by more than a factor of {_STIFFENS:g}, such as liquids and "
            "bodies with dashpots"
        )
    return np.full(everywhere.shape, _TWICE), (
        "it is between one and two times that of the surface by boundary elements at the same force, for r, r^2 and r^4 and solids "
        "with one relaxation time"
    )


def sliding_claims(
    prescribed: str,
    limits: Limits,
    model: tuple[FloatArray | None, str],
    everywhere: BoolArray,
    error: FloatArray,
    remark: str,
) -> dict[str, Claim]:
    """
    Claims of a sliding contact.

    Parameters
    ----------
    model : tuple
        Result of :func:`friction_error`.
    error : ndarray
        Relative errors of the numbers of the springs at every speed.
    """
    known = []
    if limits.slow is None:
        known.append("twice the exact value in slow sliding")
    if limits.glassy and limits.fast is None:
        known.append("exact in fast sliding")
    numerics = f"; numerical error of the springs at most {float(np.max(error)):.1g}{remark}"
    reason = (
        "springs along one line respond to the whole gradient of the profile, not to its component along the direction of "
        "sliding: "
        + (f"their friction is {' and '.join(known)}, and qualitative elsewhere" if known else "qualitative")
    )
    book = SOURCES["popov-hess"]
    off, remark_on_model = model
    friction = Claim(
        Level.APPROXIMATE, f"{reason}; {remark_on_model}{numerics}", book, everywhere, total_error(off, error)
    )
    whole = f"{reason}; the difference from the surface is unknown{numerics}"
    pressed = Claim(Level.APPROXIMATE, whole, book, everywhere)
    edges = Claim(
        Level.APPROXIMATE, f"for the springs, not for the surface: {reason}{numerics}", book, everywhere
    )
    claims = {name: edges if name.endswith("edge") else pressed for name in LINE_QUANTITIES}
    claims |= dict.fromkeys(("friction_coefficient", "friction_force"), friction)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    none = np.zeros(everywhere.shape, dtype=bool)
    for name, why in (
        ("slow_limit", limits.slow),
        ("fast_limit", limits.fast),
        (
            "pressure",
            "springs along one line do not determine the pressure distribution of a sliding contact",
        ),
        (
            "contact_radius",
            "a sliding contact is not a disk; leading_edge and trailing_edge are those of the springs",
        ),
    ):
        if why is not None:
            claims[name] = Claim(Level.NOT_VALID, why, book, none)
    if limits.slow is None:
        claims["slow_limit"] = _limit(
            "slow", "in the speed", "have twice this value", limits.slow_error, remark
        )
    if limits.fast is None and limits.glassy:
        claims["fast_limit"] = _limit(
            "fast", "in one over the speed", "have the same value", limits.fast_error, remark
        )
    elif limits.fast is None:
        limit = f"the limit of the springs, int_0^a g'^2 dx / d at the depth of every speed{remark}"
        claims["fast_limit"] = Claim(Level.APPROXIMATE, limit, book, everywhere)
    return claims


def _limit(kind: str, order: str, springs: str, error: FloatArray | None, remark: str) -> Claim:
    """Claim of a limit as the friction at the speeds that are slow or fast enough."""
    assert error is not None
    source = SOURCES["lee-radok"]
    near_limit = error <= _SLOWEST
    if not near_limit.any():
        why = f"no speed is {kind} enough: the error of the {kind} limit is at least {float(error.min()):.2g} (limit {_SLOWEST:g})"
        return Claim(Level.NOT_VALID, why, source, near_limit)
    reason = (
        f"exact to first order {order} for frictionless half-spaces with this E*(t) in contact on a disk with a smooth edge; the springs "
        f"{springs}; given where sliding is {kind}{remark}"
    )
    return Claim(Level.EXACT, reason, source, near_limit, error)


def rough_sliding_claims(prescribed: str, everywhere: BoolArray, error: FloatArray) -> dict[str, Claim]:
    """Claims of a rough line that slides."""
    book = SOURCES["popov-hess"]
    reason = (
        "qualitative: springs below a random line of one seed, which represents a rough surface by its spectrum; the contact and the "
        "loss of a surface differ from those of a line by an unknown amount; numerical error of the line at most "
        f"{float(np.max(error)):.1g}"
    )
    claim = Claim(Level.APPROXIMATE, reason, book, everywhere)
    claims = dict.fromkeys(("friction_coefficient", "friction_force", "normal_force", "indentation"), claim)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    none = np.zeros(everywhere.shape, dtype=bool)
    for name in ("slow_limit", "fast_limit"):
        claims[name] = Claim(Level.NOT_VALID, "the limits of a rough surface are unknown", book, none)
    area = "the contact of a line is not the contact of a surface"
    for name in ("contact_area", "pressure", "leading_edge", "trailing_edge"):
        claims[name] = Claim(Level.NOT_VALID, area, book, none)
    return claims
