"""How far the line is needed: interpolants of numerical profiles on every radius that a path reaches."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.validity import Assumption, small_slope_assumptions
from pymdr.line.foundation import (
    DiskStates,
    ElasticLine,
    line_upto_force,
    normal_force,
    states_at_depth,
)
from pymdr.mapping.equivalent import NumericLine, equivalent_profile, gap_function, samples_of
from pymdr.mapping.equivalent.numeric import COARSE_RADII
from pymdr.mapping.moduli import EffectiveModuli, effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import FlatPunch, Function, Profile, Sampled, Sphere, Sum
from pymdr.units import FloatArray, metres, newtons


@dataclass(frozen=True)
class Mapped:
    """Step 1: the line, its moduli and what was said on the way."""

    line: ElasticLine
    moduli: EffectiveModuli
    notes: tuple[str, ...]


def map_to_line(contact: Contact) -> Mapped:
    """Step 1: effective moduli and equivalent profile."""
    moduli = effective_moduli(contact.body, contact.counterbody)
    return Mapped(
        ElasticLine(equivalent_profile(contact.profile), moduli.normal), moduli, _notes(contact.profile)
    )


def _notes(profile: Profile) -> tuple[str, ...]:
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return tuple(
        f"the offset f(0) = {metres(part.offset)} of the profile was removed"
        for part in parts
        if isinstance(part, Function | Sampled) and part.offset != 0.0
    )


def made_fast(contact: Contact, mapped: Mapped, depth: float, force: float) -> Mapped:
    """
    Interpolate a numerical profile on all radii that a contact without adhesion can reach.

    Parameters
    ----------
    contact : Contact
    mapped : Mapped
    depth : float
        Largest indentation in m; -inf if none is prescribed.
    force : float
        Largest normal force in N; 0 if none is prescribed.

    Returns
    -------
    Mapped
    """
    line = mapped.line
    if not isinstance(line.equivalent, NumericLine):
        return mapped
    equivalent = line.equivalent
    top = min(equivalent.edge, equivalent.reach if equivalent.fixed else math.inf)
    if equivalent.fixed:
        _refuse_beyond_data(line, depth, force)
    if not math.isfinite(top):
        if force > 0.0:
            reached = line_upto_force(line, force).equivalent
            depth = max(depth, float(reached.g(np.array([reached.reach]))[0]))
        top, dips = _last_radius_below(contact.profile, equivalent, depth)
        if dips:
            marked = equivalent_profile(_marked(contact.profile, dips))
            assert isinstance(marked, NumericLine)
            equivalent = marked
    return Mapped(ElasticLine(equivalent.upto(top), line.modulus), mapped.moduli, mapped.notes)


def _last_radius_below(
    profile: Profile, equivalent: NumericLine, depth: float
) -> tuple[float, tuple[float, ...]]:
    """
    The largest radius with f <= depth: contact, where u = d - f >= 0, lies inside it.

    Dips of f below `depth` farther out come back by their ends, which become breakpoints, so that no panel
    steps over them.
    """
    first = (
        equivalent.top_for(depth) if depth > 0.0 else _last_below(profile, equivalent, depth, COARSE_RADII)
    )
    if first is None:
        return equivalent.some_radius(), ()  # no contact
    limit = min(profile.reach, 1000.0 * first)
    if limit <= first:
        return first, ()
    r = np.geomspace(first, limit, 20_001)
    with np.errstate(all="ignore"):
        below = _gap_on(profile, equivalent, r) <= depth
    if not below.any():
        return first, ()
    last = _last_below(profile, equivalent, depth, r)
    changes = np.diff(below.astype(int))
    ends = np.flatnonzero(changes) if (changes > 0).any() else np.zeros(0, dtype=np.intp)
    return max(first, last or 0.0), tuple(float(x) for i in ends for x in (r[i], r[i + 1]))


def _marked(profile: Profile, radii: tuple[float, ...]) -> Profile:
    """The profile with more breakpoints on its callables."""
    if isinstance(profile, Sum):
        return Sum(tuple(_marked(part, radii) for part in profile.parts))
    if not isinstance(profile, Function):
        return profile
    return replace(profile, breakpoints=(*profile.breakpoints, *radii))


def _last_below(profile: Profile, equivalent: NumericLine, depth: float, radii: FloatArray) -> float | None:
    r = radii[radii <= profile.reach]
    with np.errstate(all="ignore"):
        below = np.flatnonzero(_gap_on(profile, equivalent, r) <= depth)
    if below.size == 0:
        return None
    if below[-1] == r.size - 1 and r[-1] < profile.reach:
        raise ProblemError(
            f"the profile is below {metres(depth)} again at r = {metres(r[-1])}, so the contact has no end; add "
            "FlatPunch(radius) for a cylinder of that end shape, or state the reach of the Function"
        )
    return float(r[min(below[-1] + 1, r.size - 1)])


def _gap_on(profile: Profile, equivalent: NumericLine, r: FloatArray) -> FloatArray:
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    if all(not isinstance(part, Function) or part.f is not None for part in parts):
        return profile.gap(r)
    slope = samples_of(profile, float(r[-1])).slope(r)
    steps = 0.5 * np.diff(r) * (slope[1:] + slope[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + gap_function(profile, equivalent)(r[:1])


def _refuse_beyond_data(line: ElasticLine, depth: float, force: float) -> None:
    """Samples are not extrapolated: beyond the largest load that they allow nothing can be said."""
    equivalent = line.equivalent
    assert isinstance(equivalent, NumericLine)
    if math.isfinite(equivalent.edge) and equivalent.edge <= equivalent.reach:
        return
    fast = ElasticLine(equivalent.upto(equivalent.reach), line.modulus)
    deepest = float(np.max(g_samples(fast)))
    hardest = float(normal_force(fast, states_at_depth(fast, np.array([deepest])))[0])
    if depth > deepest or force > hardest:
        asked = f"indentation = {metres(depth)}" if depth > deepest else f"normal_force = {newtons(force)}"
        raise PathError(
            f"{asked}: the samples end at r = {metres(equivalent.reach)} and are not extrapolated; the largest "
            f"indentation that they allow is {metres(deepest)} (normal force {newtons(hardest)})"
        )


def refuse_unreachable(profile: Profile, states: DiskStates) -> None:
    """Refuse a sphere pressed in by its radius, and a contact that would pass the end of the profile."""
    parts = [part for part in getattr(profile, "parts", (profile,)) if not isinstance(part, FlatPunch)]
    deepest = float(np.max(states.indentation))
    if profile.edge < profile.reach:
        return
    if len(parts) == 1 and isinstance(parts[0], Sphere) and not deepest < parts[0].radius:
        raise PathError(
            f"indentation = {metres(deepest)}: a sphere cannot be pressed in by its radius, {metres(parts[0].radius)}; "
            "reduce the indentation or the load"
        )
    if not np.max(states.contact_radius) < profile.reach:
        asked = "normal_force" if math.isnan(deepest) else f"indentation = {metres(deepest)}"
        raise PathError(
            f"{asked}: the contact would pass r = {metres(profile.reach)}, the last radius at which "
            "the profile is known; reduce the indentation or the load"
        )


def g_samples(line: ElasticLine) -> FloatArray:
    """Values of g in m over its whole extent."""
    return line.equivalent.g(np.linspace(0.0, min(line.equivalent.edge, line.equivalent.reach), 65))


def assumptions(contact: Contact, mapped: Mapped, radii: FloatArray) -> tuple[Assumption, ...]:
    """What the model assumes, measured on the largest of some contact radii in m."""
    a = float(np.nanmax(radii, initial=0.0))
    if a == 0.0:
        return ()
    slope = samples_of(contact.profile, a).slope
    return small_slope_assumptions(contact.profile, slope, a, mapped.moduli.dundurs_beta)
