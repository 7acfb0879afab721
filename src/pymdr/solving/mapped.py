"""Step 1 of every solution, and refusals of loads beyond the known part of a profile."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import PathError
from pymdr.interpretation.layers import base_assumption
from pymdr.interpretation.thickness import thickness_assumption
from pymdr.interpretation.validity import Assumption, small_slope_assumptions
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.foundation import DiskStates, normal_force, states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.line.lines import line_of, springs_of
from pymdr.mapping.closure import closure_of
from pymdr.mapping.equivalent import slope_function
from pymdr.mapping.moduli import EffectiveModuli, effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layered
from pymdr.problem.profiles import Ellipsoid, FlatPunch, ForceCurve, Function, Profile, Sampled, Sphere, Sum
from pymdr.units import FloatArray, metres, newtons


@dataclass(frozen=True)
class Mapped:
    """Step 1: the line, the moduli of the surfaces and notes."""

    line: Line
    moduli: EffectiveModuli
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Springs(Mapped):
    """Step 1 with independent springs."""

    line: ElasticLine


def map_to_springs(contact: Contact) -> Springs:
    """
    Step 1 for laws that need independent springs.

    Raises
    ------
    ProblemError
        If a body is layered.
    """
    moduli = effective_moduli(contact.body, contact.counterbody)
    return Springs(springs_of(contact), moduli, notes_of(contact.profile))


def map_to_line(contact: Contact) -> Mapped:
    """Step 1: the line of any bodies, with the moduli of the top layers where there are layers."""
    if contact.layered is None:
        return map_to_springs(contact)
    surfaces = (
        body.top if isinstance(body, Layered) else body for body in (contact.body, contact.counterbody)
    )
    return Mapped(line_of(contact), effective_moduli(*surfaces), notes_of(contact.profile))


def notes_of(profile: Profile) -> tuple[str, ...]:
    """Notes on the preparation of a profile before it was mapped."""
    if isinstance(profile, ForceCurve):
        return closure_of(profile).notes
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    curves = tuple(f"the profile is {part.curve_description}" for part in parts if isinstance(part, Sampled))
    offsets = tuple(
        f"the offset f(0) = {metres(part.offset)} of the profile was removed"
        for part in parts
        if isinstance(part, Function | Sampled) and part.offset != 0.0
    )
    return curves + offsets


def refuse_unreachable(line: Line, profile: Profile, states: DiskStates, force: float | None = None) -> None:
    """
    Refuse a sphere pressed in by its radius, and a contact that would pass the end of the profile.

    Messages name the largest indentation, or the force in N where one is prescribed.
    """
    parts = [part for part in getattr(profile, "parts", (profile,)) if not isinstance(part, FlatPunch)]
    deepest = float(np.max(states.indentation))
    target = f"indentation = {metres(deepest)}" if force is None else f"normal_force = {newtons(force)}"
    equivalent = line.equivalent
    if profile.edge < equivalent.max_radius or (
        profile.edge == equivalent.max_radius and np.isfinite(deepest)
    ):
        return
    whole = parts[0] if len(parts) == 1 else None
    if isinstance(whole, Sphere) and not deepest < whole.radius:
        raise PathError(
            f"{target}: a sphere cannot be pressed in by its radius, {metres(whole.radius)}; "
            "reduce the indentation or the load"
        )
    if isinstance(whole, Ellipsoid) and not deepest < whole.height:
        raise PathError(
            f"{target}: an ellipsoid cannot be pressed in by its semi-axis, {metres(whole.height)}; "
            "reduce the indentation or the load"
        )
    if np.max(states.contact_radius) < equivalent.max_radius and np.isfinite(deepest):
        return
    if isinstance(profile, ForceCurve):
        known = closure_of(profile)
        most = known.largest_force * line.modulus / profile.modulus
        raise PathError(
            f"{target}: the force curve ends at an indentation of {metres(known.deepest)} (normal force {newtons(most)} of these "
            "bodies) and is not extrapolated; reduce the indentation or the load"
        )
    largest = _largest_allowed(line)
    raise PathError(
        f"{target}: the contact would pass r = {metres(equivalent.max_radius)}, the last radius at which the profile is known "
        f"(it is not extrapolated); {largest}reduce the indentation or the load"
    )


def _largest_allowed(line: Line) -> str:
    """Text with the largest indentation and force that the known profile allows."""
    equivalent = line.equivalent
    if isinstance(equivalent.rises, bool) and equivalent.rises:
        return ""
    ends = np.array([*equivalent.turning_points(equivalent.max_radius), equivalent.max_radius])
    deepest = float(np.max(line.depth(ends)))
    force = float(normal_force(line, states_at_depth(line, np.array([deepest])))[0])
    return f"the largest indentation that it allows is {metres(deepest)} (normal force {newtons(force)}): "


def map_remark(line: Line, states: DiskStates) -> str:
    """Remark on the assumptions of a mapped profile, empty for closed forms."""
    equivalent = line.equivalent
    deepest = float(np.max(states.indentation, initial=0.0))
    remarks = equivalent.rests_on()
    searched = equivalent.searched_to(deepest) if deepest > 0.0 else 0.0
    if np.isfinite(searched) and searched > float(np.max(states.contact_radius)):
        remarks = (*remarks, f"no other contact exists up to r = {metres(searched)}")
    return "".join(f"; {each}" for each in remarks)


def g_samples(line: Line) -> FloatArray:
    """Values of g in m over its whole domain."""
    return line.equivalent.g(np.linspace(0.0, min(line.equivalent.edge, line.equivalent.max_radius), 65))


def half_space_assumptions(contact: Contact, mapped: Mapped, radii: FloatArray) -> tuple[Assumption, ...]:
    """Assumptions of the half-space model, measured on the largest of some contact radii in m."""
    a = float(np.nanmax(radii, initial=0.0))
    if a == 0.0:
        return ()
    return (
        *small_slope_assumptions(
            contact.profile, slope_function(contact.profile), a, mapped.moduli.dundurs_beta
        ),
        *thickness_assumption(contact, a),
    )


def assumptions(
    contact: Contact, mapped: Mapped, radii: FloatArray, excess: FloatArray | None = None
) -> tuple[Assumption, ...]:
    """Assumptions of the model, measured on the largest of some contact radii in m, with the excess of its edge in m."""
    listed = half_space_assumptions(contact, mapped, radii)
    if listed and isinstance(mapped.line, LayeredLine):
        # at a sharp edge the radius is constant and the excess grows
        widest = np.where(radii == np.nanmax(radii), 0.0 if excess is None else excess, -math.inf)
        at = int(np.nanargmax(widest))
        listed += base_assumption(mapped.line, float(radii[at]), float(widest[at]))
    return listed
