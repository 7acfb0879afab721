"""Bands: the effect of the scatter of a sampled profile on every quantity."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ConvergenceError, PathError
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import Profile, Sampled, Sum
from pymdr.result import Result, labelled
from pymdr.units import FloatArray

BAND_NOTE = (
    "bands are the results for the profile lowered and raised by its scatter: a sensitivity, not a confidence "
    "interval; NaN where the contact of such a profile is not a disk or exceeds its known part"
)
OFFSET_NOTE = (
    "the scatter is the same at every sample, so it shifts the whole profile and the bands have zero width; give the scatter of "
    "the heights relative to the axis, which is 0 there"
)


def scatter_of(profile: Profile) -> bool:
    """Whether a profile has samples with a scatter."""
    return bool(_scatters(profile))


def band_note(profile: Profile) -> str:
    """The note that explains the bands of a profile with a scatter."""
    return BAND_NOTE if any(np.ptp(scatter) > 0.0 for scatter in _scatters(profile)) else OFFSET_NOTE


def no_bands(profile: Profile) -> tuple[str, ...]:
    """The note of a study that has no bands."""
    if not scatter_of(profile):
        return ()
    return ("the scatter of the samples only weights the smoothing: there are no bands here",)


def _scatters(profile: Profile) -> list[FloatArray]:
    """The scatter of the sampled parts of a profile."""
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return [part.scatter for part in parts if isinstance(part, Sampled) and part.scatter is not None]


def with_bands(result: Result, solve: Callable[[Contact], Result]) -> Result:
    """Add to every quantity the band between the solutions for f - scatter and f + scatter."""
    data = result.data
    names = [
        str(name)
        for name in data
        if name not in ("time", "jumped") and not np.all(np.isnan(data[name].values))
    ]
    ends = [_shifted_solution(result, sign, solve) for sign in (-1.0, 1.0)]
    columns: dict[str, FloatArray] = {}
    for name in names:
        values = np.array(
            [
                data[name].values,
                *(end[name].values if name in end else np.full(data.sizes["step"], math.nan) for end in ends),
            ]
        )
        if np.array_equal(values[0], values[1]) and np.array_equal(values[0], values[2]):
            continue
        known = ~np.isnan(values).any(axis=0)  # the resistance out of contact is infinite
        columns[f"{name}_low"] = np.where(known, values.min(axis=0), math.nan)
        columns[f"{name}_high"] = np.where(known, values.max(axis=0), math.nan)
    return replace(
        result,
        data=data.merge(labelled(columns)),
        claims=_mean_claims(result.claims, adhesive=result.contact.adhesion is not None),
        notes=(*result.notes, band_note(result.contact.profile)),
    )


def _shifted_solution(result: Result, sign: float, solve: Callable[[Contact], Result]) -> xr.Dataset:
    contact = replace(result.contact, profile=shifted(result.contact.profile, sign))
    try:
        return solve(contact).data
    except (PathError, ConvergenceError):
        return labelled({})


@lru_cache(maxsize=256)
def shifted(profile: Profile, sign: float) -> Profile:
    """The profile moved by its scatter; cached, so that its curve and its map are computed once."""
    if isinstance(profile, Sum):
        return Sum(tuple(shifted(part, sign) for part in profile.parts))
    if not isinstance(profile, Sampled) or profile.scatter is None:
        return profile
    # the scatter stays: it weights the samples of a smoothing spline
    return replace(profile, height=profile.height + sign * profile.scatter)


def _mean_claims(claims: Mapping[str, Claim], *, adhesive: bool) -> dict[str, Claim]:
    """Claims of a profile with scatter, the azimuthal mean of a body that is not quite axisymmetric."""
    reason = (
        "exact for the mean profile; for the measured body, whose azimuthal mean it is, the force at a given "
        "indentation, counted from the apex of the mean and not from the highest summit, is a rigorous lower bound, second-order "
        "accurate in the asymmetry"
    )
    if adhesive:
        reason = (
            "exact for the mean profile, the azimuthal mean of the measured body; the effect of its asymmetry on an "
            "adhesive contact is unknown"
        )
    bound = claims.get("force_lower_bound")
    if bound is not None:
        from_mean = replace(
            bound, reason=f"{bound.reason}; indentations are counted from the apex of the mean profile"
        )
        claims = {**claims, "force_lower_bound": from_mean}
    return {
        name: claim
        if claim.level is not Level.EXACT
        or name == "force_lower_bound"
        or claim.reason.startswith("prescribed")
        else replace(
            claim,
            level=Level.APPROXIMATE,
            reason=f"{reason}; {claim.reason}",
            source=claim.source if adhesive else SOURCES["shield"],
        )
        for name, claim in claims.items()
    }
