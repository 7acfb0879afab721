"""What can be claimed of a profile that slides over an elastomer."""

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
"""By how much a limit may err for it to be taken for the friction."""
_TWICE = 1.0
"""The springs have at most twice the friction of the surface under a given force: error of twice the exact value."""
_STIFFENS = 1e3
"""Largest ratio of moduli at once and in the end up to which that was measured."""
_EXPONENTS = (1.0, 4.0)
"""Of profiles r^n for which it was."""


@dataclass(frozen=True)
class Limits:
    """What is known of the limits of slow and fast sliding; a reason stands for what is not."""

    slow: str | None
    """Why there is no slow limit, or None."""
    fast: str | None
    """Why there is no fast limit, or None."""
    glassy: bool
    """Whether the bodies answer a step at once, so that the fast limit is that of two half-spaces."""
    slow_error: FloatArray | None = None
    """Relative error of the slow limit at every speed, by the springs, which leave theirs sooner than surfaces do."""
    fast_error: FloatArray | None = None
    """That of the fast limit, a/(v tau) with the fastest relaxation."""


def friction_error(
    profile: Profile, prescribed: str, limits: Limits, stiffens: float, everywhere: BoolArray
) -> tuple[FloatArray | None, str]:
    """
    Relative error of the friction of the springs against that of the surface, and where it is known from.

    Parameters
    ----------
    profile : Profile
    prescribed : str
        "normal_force" or "indentation".
    limits : Limits
    stiffens : float
        Modulus at once over that in the end.
    everywhere : ndarray of bool
        True for every speed.

    Returns
    -------
    error : ndarray or None
        Over the friction of the surface; None where it is not known.
    words : str

    Notes
    -----
    Twice for slow sliding, exactly; boundary elements on a half-space with up to 40 x 40 cells at 13 speeds from slow to fast, for
    r, r^2 and r^4 and ratios of moduli from 2 to 1000, under the same force: from twice at slow speeds, falling, to once at fast ones.
    """
    if limits.slow_error is not None and np.max(limits.slow_error) <= _SLOWEST:
        return np.full(
            everywhere.shape, _TWICE
        ), "sliding is slow, and the springs have twice the friction of the surface"
    if prescribed != "normal_force":
        return (
            None,
            "how far it is off at a given indentation is not known: up to three times was measured there",
        )
    exponent = 2.0 if isinstance(profile, Paraboloid | Sphere) else 1.0 if isinstance(profile, Cone) else None
    exponent = profile.exponent if isinstance(profile, PowerLaw) else exponent
    if exponent is None or not _EXPONENTS[0] <= exponent <= _EXPONENTS[1]:
        return (
            None,
            f"how far it is off for a {type(profile).__name__} is not known: r, r^2 and r^4 were measured",
        )
    if not stiffens <= _STIFFENS:
        return None, (
            f"how far it is off is not known for bodies whose modulus falls by more than a factor {_STIFFENS:g}, as that of "
            "liquids and with dashpots"
        )
    return np.full(everywhere.shape, _TWICE), (
        "it is between once and twice that of the surface: boundary elements at the same force, for r, r^2 and r^4 over solids of "
        "one relaxation time"
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
    prescribed : str
        "normal_force" or "indentation".
    limits : Limits
    model : tuple
        What :func:`friction_error` gives.
    everywhere : ndarray of bool
        True for every speed.
    error : ndarray
        Relative errors of the numbers of the springs at every speed.
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
    numerics = f"; their own numbers err by at most {float(np.max(error)):.1g}{remark}"
    reason = (
        "springs along one line, which feel a whole gradient where the surface feels the part along the way: "
        + (f"their friction is {' and '.join(known)}, and qualitative elsewhere" if known else "qualitative")
    )
    book = SOURCES["popov-hess"]
    off, words = model
    friction = Claim(
        Level.APPROXIMATE, f"{reason}; {words}{numerics}", book, everywhere, total_error(off, error)
    )
    whole = f"{reason}; how far it is off from that of the surface is not known{numerics}"
    pressed = Claim(Level.APPROXIMATE, whole, book, everywhere)
    edges = Claim(
        Level.APPROXIMATE, f"of the springs, not of the surface: {reason}{numerics}", book, everywhere
    )
    claims = {name: edges if name.endswith("edge") else pressed for name in LINE_QUANTITIES}
    claims |= dict.fromkeys(("friction_coefficient", "friction_force"), friction)
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
    if limits.slow is None:
        claims["slow_limit"] = _limit("slow", "in the speed", "have twice of it", limits.slow_error, remark)
    if limits.fast is None and limits.glassy:
        claims["fast_limit"] = _limit(
            "fast", "in one over the speed", "have the same", limits.fast_error, remark
        )
    elif limits.fast is None:
        told = f"the limit of the springs, int_0^a g'^2 dx / d at the depth of every speed{remark}"
        claims["fast_limit"] = Claim(Level.APPROXIMATE, told, book, everywhere)
    return claims


def _limit(kind: str, order: str, springs: str, error: FloatArray | None, remark: str) -> Claim:
    """A limit as the friction at the speeds for which it is one."""
    assert error is not None
    source = SOURCES["lee-radok"]
    held = error <= _SLOWEST
    if not held.any():
        why = (
            f"no speed is {kind}: there the {kind} limit is off by {float(error.min()):.2g} or more, and it is taken for the friction "
            f"up to {_SLOWEST:g}"
        )
        return Claim(Level.NOT_VALID, why, source, held)
    reason = (
        f"exact to the first order {order} for half-spaces with this E*(t), frictionless, on a disk whose edge is smooth; the springs "
        f"{springs}; given where sliding is {kind}{remark}"
    )
    return Claim(Level.EXACT, reason, source, held, error)


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
        "nor the loss of a surface is that of a line, and by how much they differ has not been measured; the numbers of the line "
        f"err by at most {float(np.max(error)):.1g}"
    )
    claim = Claim(Level.APPROXIMATE, reason, book, everywhere)
    claims = dict.fromkeys(("friction_coefficient", "friction_force", "normal_force", "indentation"), claim)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", book, everywhere)
    nowhere = np.zeros(everywhere.shape, dtype=bool)
    for name in ("slow_limit", "fast_limit"):
        claims[name] = Claim(Level.NOT_VALID, "the limits of a rough surface are not known", book, nowhere)
    area = "the part of a line that is touched is not the contact of a surface"
    for name in ("contact_area", "pressure", "leading_edge", "trailing_edge"):
        claims[name] = Claim(Level.NOT_VALID, area, book, nowhere)
    return claims
