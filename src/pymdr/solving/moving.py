"""Contacts that other programs move, by what they remember."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.traction import curves_down_to
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import Works, edge_states
from pymdr.line.following import Branches, HystereticTracks, RestingBranches, Track, tabulated_track
from pymdr.line.following.branches import Columns
from pymdr.line.foundation import rises_to, states_at_depth
from pymdr.line.friction import Stacks, virgin_state
from pymdr.line.lines import unit_line_of
from pymdr.line.memory import RelaxingContacts, ShearedContacts
from pymdr.line.moved import Moved
from pymdr.line.plane import PlaneContacts, PlaneLaw, Springs
from pymdr.line.plastic import DEEPEST, GrowingBall, GrowingContacts, YieldingContacts
from pymdr.line.soft.moved import ZoneContacts
from pymdr.line.soft.small_zone import ShortSprings
from pymdr.line.soft.springs import FINE, ZoneSprings
from pymdr.mapping.relaxation import relaxation_of
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath, Path, indent, ramp
from pymdr.problem.profiles import Shape
from pymdr.solving.adhesive import HystereticLine
from pymdr.solving.adhesive_rows import between_parameters, parameter_step
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.mapped import map_to_springs, refuse_unreachable
from pymdr.solving.memory import powers_of, surfaces_of
from pymdr.solving.plastic import ball_of
from pymdr.solving.viscoelastic import LEVELS, SPRINGS, STRAIGHT
from pymdr.solving.zones import short_springs, zone_setting
from pymdr.units import FloatArray, metres

_ROWS = 65
"""Rows of the path by which a contact with adhesion is pressed in, and of that by which it is pulled off."""


class Moving(NamedTuple):
    """Contacts to be moved, and a path that passes their states."""

    contacts: Moved
    path: LoadingPath


class Resting(NamedTuple):
    """Contacts whose edge may rest, and a path that passes their states."""

    contacts: RestingBranches
    path: LoadingPath
    lines: HystereticLine
    """Their curves."""


def moving_of(contact: Contact, deepest: float, count: int, springs: int | None = None) -> Moving:
    """
    Contacts that have not touched, whose curves reach down to an indentation in m; of a number of springs, if it is given.

    Raises
    ------
    ProblemError
        If the contact has no memory of a known kind.
    RefusedError
        If it is not a disk at every depth.
    """
    _refuse_unknown(contact)
    if contact.is_viscoelastic and contact.adhesion is not None:
        return _in_zone(contact, deepest, count, springs)
    if contact.is_viscoelastic:
        return _relaxing(contact, deepest, count, SPRINGS if springs is None else springs)
    if contact.plastic is not None and springs is None:
        return _yielding(contact, deepest, count)
    if springs is not None:
        return _in_plane(contact, deepest, count, springs)
    if contact.adhesion is None:
        return _stacks(contact, deepest, count)
    if contact.adhesion.has_hysteresis:
        return Moving(*resting_of(contact, deepest, count)[:2])
    return _branches(contact, deepest, count)


def _refuse_unknown(contact: Contact) -> None:
    """Refuse contacts whose memory is of no known kind."""
    graded = contact.body.grading != 0.0 or contact.counterbody.grading != 0.0
    for refused, why in (
        (
            bool(powers_of(contact)),
            "PowerLawRheology has no fixed relaxation times; give a Prony series fitted over the times of the motion",
        ),
        (
            contact.layered is not None and contact.adhesion is None and not contact.is_viscoelastic,
            "layered bodies are not available without adhesion; give the force_curve() of solve(...) as the profile of half-spaces",
        ),
        (
            graded and contact.adhesion is None,
            "graded bodies are not available without adhesion; export_law(...) tabulates their force",
        ),
        (
            isinstance(contact.profile, Shape),
            "the contact is not a disk; give the force_curve() of solve(...) as its profile",
        ),
    ):
        if refused:
            raise ProblemError(why)


def _stacks(contact: Contact, deepest: float, count: int) -> Moving:
    mapped = map_to_springs(contact)
    refuse_unreachable(mapped.line, contact.profile, states_at_depth(mapped.line, np.array([deepest])))
    disks_down_to(contact, mapped.line, deepest, "Stepper")
    friction = 0.0 if contact.friction is None else contact.friction.coefficient
    start = virgin_state(friction or 1.0, mapped.moduli.normal / mapped.moduli.tangential)
    stacks = Stacks(curves_down_to(mapped.line, deepest), start, friction != 0.0, count)
    pressed = indent(deepest)
    return Moving(stacks, pressed >> ramp(shift=0.1 * deepest) if friction else pressed)


def _in_plane(contact: Contact, deepest: float, count: int, springs: int) -> Moving:
    if contact.friction is None or contact.adhesion is not None:
        raise ProblemError(
            "springs= is for friction in the plane and for bodies with memory; leave it out, or give "
            "Contact(..., friction=Coulomb(0.3))"
        )
    normal, mapped = (
        _stacks(replace(contact, friction=None), deepest, count).contacts,
        map_to_springs(contact),
    )
    law = PlaneLaw(contact.friction.coefficient, mapped.moduli.normal, mapped.moduli.tangential)
    radius = float(states_at_depth(mapped.line, np.array([deepest])).contact_radius[0])
    part = 0.1 * deepest
    path = indent(deepest) >> ramp(shift=(part, 0.0)) >> ramp(shift=(part, part))
    return Moving(PlaneContacts(law, Springs.along(mapped.line, radius, springs), normal), path)


def _yielding(contact: Contact, deepest: float, count: int) -> Moving:
    ball, body, adhesion = ball_of(contact), contact.plastic, contact.adhesion
    assert body is not None
    if deepest > DEEPEST * ball.radius:
        raise PathError(
            f"max_indentation = {metres(deepest)}; the model of a body that yields ends at {metres(DEEPEST * ball.radius)}, "
            f"{DEEPEST:g} of the radius of the ball"
        )
    there_and_back = indent(deepest, steps=_ROWS) >> indent(0.0, steps=_ROWS)
    if body.apparent_radius:
        return Moving(GrowingContacts(GrowingBall(ball), count), there_and_back)
    work = 0.0 if adhesion is None else adhesion.work
    return Moving(YieldingContacts(ball, work, count), there_and_back)


def _relaxing(contact: Contact, deepest: float, count: int, springs: int) -> Moving:
    line, relaxation = unit_line_of(contact), relaxation_of(*surfaces_of(contact))
    states = states_at_depth(line, np.array([deepest]))
    refuse_unreachable(line, contact.profile, states)
    if not rises_to(line, deepest):
        raise ProblemError(
            "the equivalent profile decreases within the contact, which is not covered with memory; use an increasing profile"
        )
    slowest = float(np.max(relaxation.times, initial=0.0)) or 1.0
    path = indent(deepest, duration=slowest) >> indent(0.5 * deepest, duration=slowest)
    contacts = RelaxingContacts(line, relaxation, deepest, springs, count)
    path = path >> indent(0.9 * deepest, duration=slowest)
    if contact.friction is None:
        return Moving(contacts, path)
    shear_relaxation = relaxation_of(contact.body, contact.counterbody, tangential=True)
    division = STRAIGHT, 2 * LEVELS[0][0]
    return Moving(
        ShearedContacts(contacts, shear_relaxation, contact.friction.coefficient, division),
        path >> ramp(shift=0.1 * deepest, duration=slowest),
    )


def _in_zone(contact: Contact, deepest: float, count: int, springs: int | None) -> Moving:
    if springs is not None:
        raise ProblemError(
            f"springs = {springs}; with adhesion and memory their number follows from the cohesive zone; leave springs out"
        )
    relaxation = relaxation_of(*surfaces_of(contact))
    assert contact.adhesion is not None
    if contact.adhesion.cohesive_stress is None:
        springs_with_zone: ShortSprings | ZoneSprings = short_springs(contact, relaxation)
    else:
        setting = zone_setting(contact, relaxation, {math.inf: deepest})
        springs_with_zone = ZoneSprings(setting, FINE)
    slowest = float(relaxation.times.max())
    pulled = indent(-deepest, duration=slowest)
    return Moving(ZoneContacts(springs_with_zone, count), indent(deepest, duration=slowest) >> pulled)


def _branches(contact: Contact, deepest: float, count: int) -> Moving:
    line = AdhesiveLine(contact)
    track, curve = line.track(math.inf, deepest), line.equilibria
    branches = Branches(
        tabulated_track(track, _forces_of(line)),
        lambda s, depth, moves: (_refined(track, _known(s, curve.start), depth), curve),
        count,
    )
    return Moving(branches, _in_and_out(track, deepest))


def _in_and_out(track: Track, deepest: float) -> LoadingPath:
    """A path down to an indentation in m and back to pull-off."""
    last = float(track.low.min())
    return indent(deepest, steps=_ROWS) >> Path(indentation=np.linspace(deepest, last - abs(last), _ROWS))


def resting_of(contact: Contact, deepest: float, count: int) -> Resting:
    """As :func:`moving_of`, of contacts with two works of adhesion."""
    lines = HystereticLine(contact)
    advancing = lines.advancing.track(math.inf, deepest)
    receding = lines.receding.track(math.inf, -math.inf, advancing.curve.stop)
    line = lines.advancing.line
    works: Works = lines.works

    def columns(own: AdhesiveLine, other: Track) -> Columns:
        force = _forces_of(own)

        def of(s: FloatArray, depth: FloatArray) -> FloatArray:
            inside = np.minimum(s, lines.rim)
            a = ShortRange(line, 0.0).states(inside).contact_radius
            rest = np.stack([a, line.stiffness(a), other.curve.control(inside)])
            return np.concatenate([force(s, depth), rest])

        return of

    per_area = math.pi * (works.receding - works.advancing)
    least = float(ShortRange(line, 0.0).states(np.minimum(receding.bottom[:1], lines.rim)).contact_radius[0])
    tracks = HystereticTracks(advancing, receding, lines.rim, per_area, least)
    rows = (
        tabulated_track(advancing, columns(lines.advancing, receding)),
        tabulated_track(receding, columns(lines.receding, advancing)),
    )
    branches = RestingBranches(
        tracks,
        rows,
        lambda s, depth, moves: edge_states(line, _known(s, 0.0), depth, moves, works),
        count,
    )
    return Resting(branches, _in_and_out(receding, deepest), lines)


def _known(s: FloatArray, start: float) -> FloatArray:
    """Parameters, that of the first touch for free bodies."""
    return np.where(np.isnan(s), start, s)


def _refined(track: Track, s: FloatArray, depth: FloatArray) -> FloatArray:
    """Parameters of a table moved to their indentations in m, within its error; energies would show it, and radii at the ends of branches."""
    branch = np.searchsorted(0.5 * (track.top[:-1] + track.bottom[1:]), s)
    bottom, top = track.bottom[branch], track.top[branch]
    refined = np.clip(
        s + parameter_step(depth - track.curve.control(s), track.curve.slope(s), s), bottom, top
    )
    return np.where(depth == track.low[branch], bottom, np.where(depth == track.high[branch], top, refined))


def _forces_of(line: AdhesiveLine) -> Columns:
    """The force in N at parameters and indentations in m."""
    curve = line.equilibria

    def force(s: FloatArray, depth: FloatArray) -> FloatArray:
        states = curve.states(s)
        at = states.indentation, states.normal_force
        return between_parameters(math.inf, depth, s, at, curve.slopes(s))[1][None]

    return force
