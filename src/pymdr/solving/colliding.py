"""The normal motion of an impact: a mass on the curve of a contact, from the first touch to the last."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.line.following import Track
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.line.impact import (
    Along,
    Passage,
    Potential,
    depths_of_energy,
    elastic_potential,
    move,
    parameter_of_energy,
    passing_times,
    stop,
    stopping_times,
)
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import Ellipsoid, Profile, Sphere
from pymdr.rows import joined, taken
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.mapped import Springs
from pymdr.units import FloatArray, metres, written

_LEVELS = 400
"""Samples of a stretch for the search of a rest."""
_GROWTH, _TRIES = 1.5, 200
_SHALLOW = 1e-6
"""Depth of a first touch relative to that of an impact."""


@dataclass(frozen=True)
class Course:
    """The normal motion, one entry per row."""

    time: FloatArray
    """In s since the first touch."""
    depth: FloatArray
    """In m."""
    velocity: FloatArray
    """In m/s, above 0 while the bodies approach."""
    force: FloatArray
    """In N."""
    radius: FloatArray
    """In m."""
    sticks: bool = False
    """Whether the bodies do not separate."""
    jump_loss: float = 0.0
    """Energy in J dissipated by jumps up to separation, even if the bodies stick."""
    deepest: int = 0
    """Row of the turning point."""
    branches: int = 1
    """Number of branches of the traced curve under a prescribed indentation."""
    jumps_in: bool = False
    """Whether the contact begins with a jump that dissipates energy."""


def bounce(contact: Contact, mapped: Springs, mass: float, speed: float, rows: int) -> Course:
    """
    The impact of elastic bodies without adhesion.

    Parameters
    ----------
    mass, speed : float
        In kg and m/s.
    rows : int
        Moves of the history, a multiple of 4.

    Raises
    ------
    PathError
        If the profile ends before the bodies come to rest.
    ProblemError
        If the contact is not a disk at every depth on the way.
    """
    line = mapped.line
    potential, half, deepest = stopping_depths(contact, line, mass, np.array([speed]))
    time, depth, velocity = motion(potential, mass, speed, (float(half[0]), float(deepest[0])), rows)
    radius = np.where(depth > 0.0, states_at_depth(line, depth).contact_radius, 0.0)
    force = np.where(depth > 0.0, potential.along(depth).force, 0.0)
    return Course(time, depth, velocity, force, radius, deepest=rows // 2)


def motion(
    potential: Potential, mass: float, speed: float, depths: tuple[float, float], rows: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Time in s, depth in m and velocity in m/s of an elastic impact.

    Parameters
    ----------
    potential : Potential
        Over the depth.
    depths : tuple of float
        Depths in m at which half of the energy and all of it is stored.
    rows : int
        Moves, a multiple of 4.
    """
    energy, fractions = 0.5 * mass * speed * speed, np.linspace(0.0, 1.0, rows // 4 + 1)
    into = move(potential, mass, energy, 0.0, depths[0], fractions)
    rest = stop(potential, mass, energy, *depths, fractions)
    time = np.append(into.time, into.time[-1] + rest.time[1:])
    depth = np.append(into.parameter, rest.parameter[1:])
    velocity = np.append(into.speed, rest.speed[1:])
    return (
        np.append(time, 2.0 * time[-1] - time[-2::-1]),
        np.append(depth, depth[-2::-1]),
        np.append(velocity, -velocity[-2::-1]),
    )


def stopping_depths(
    contact: Contact, line: ElasticLine, mass: float, speed: FloatArray
) -> tuple[Potential, FloatArray, FloatArray]:
    """The potential, and the depths in m at which half of the energy and all of it is stored."""
    energy = 0.5 * mass * speed * speed
    potential = elastic_potential(line, math.inf)
    try:
        high, stored = depth_storing(potential, line, contact.profile, float(np.max(energy)))
        if stored < np.max(energy):
            known = math.sqrt(2.0 * stored / mass)
            raise PathError(
                f"speed = {written(float(np.max(speed)), 'm/s', 6)}: the bodies would not come to rest before the profile ends "
                f"at d = {metres(high)}; the largest normal speed that it allows is {written(known, 'm/s', 6)}"
            )
        deepest = depths_of_energy(potential, energy, high)
    except (ProblemError, ConvergenceError):
        # without a disk from the first touch on there is no potential
        disks_down_to(contact, line, _SHALLOW * first_depth(line, float(np.max(energy))), "an impact")
        raise
    largest = float(np.max(deepest))
    disks_down_to(contact, line, largest, "an impact")
    potential = elastic_potential(line, largest)
    return potential, depths_of_energy(potential, 0.5 * energy, largest), deepest


def contact_times(potential: Potential, mass: float, half: FloatArray, deepest: FloatArray) -> FloatArray:
    """Contact times in s of elastic impacts, one per pair of depths in m at which half of the energy and all of it is stored."""
    knots = np.array(potential.knots)
    energy = potential.along(deepest).energy
    columns = [np.zeros(half.size), *(np.minimum(knot, half) for knot in knots), half]
    into = passing_times(potential, mass, energy, np.stack(columns, axis=1))
    kinetic = energy - potential.along(half).energy
    fraction = (potential.along(knots).energy - potential.along(half).energy[:, None]) / kinetic[:, None]
    angles = np.arcsin(np.sqrt(np.clip(fraction, 0.0, 1.0)))
    ends = (np.zeros((half.size, 1)), np.full((half.size, 1), 0.5 * math.pi))
    rest = stopping_times(
        potential, mass, kinetic, half, deepest, np.concatenate([ends[0], angles, ends[1]], axis=1)
    )
    return np.asarray(2.0 * (into.sum(axis=1) + rest.sum(axis=1)))


def first_depth(line: ElasticLine, energy: float) -> float:
    """A start in m for the search of a depth that stores an energy in J."""
    a = min(line.rough_radius(lambda a, _: line.energy(a) >= energy), line.edge, 0.5 * line.max_radius)
    d = float(line.depth(np.array([a]))[0])
    return d if 0.0 < d < math.inf else a


def depth_storing(
    potential: Potential, line: ElasticLine, profile: Profile, energy: float
) -> tuple[float, float]:
    """A depth in m that stores an energy in J, or the largest known one, and the energy stored there."""
    top = math.inf
    if isinstance(profile, Sphere | Ellipsoid):
        height = profile.radius if isinstance(profile, Sphere) else profile.height
        top = (1.0 - 1e-12) * height
    depth = min(first_depth(line, energy), top)
    for _ in range(_TRIES):
        at = np.array([depth])
        # check the end of a profile only if it is reached
        if line.edge > line.max_radius and not states_at_depth(line, at).contact_radius[0] < line.max_radius:
            end = (1.0 - 1e-12) * line.max_radius
            turns = () if line.rises else line.turning_points(end)
            depth = top = min(top, float(np.max(line.depth(np.array([*turns, end])))))
            at = np.array([depth])
        stored = float(potential.along(at).energy[0])
        if stored >= energy or depth >= top:
            return depth, stored
        depth = min(2.0 * depth, top)
    raise ProblemError(
        "the search for the depth of rest did not converge; check the magnitudes of mass and speed"
    )


class _Rows(NamedTuple):
    """A part of a course."""

    time: FloatArray
    depth: FloatArray
    velocity: FloatArray
    force: FloatArray
    radius: FloatArray


_UP, _DOWN, _TOUCH = range(3)
_FREE, _UNKNOWN = -1, -2


@dataclass(frozen=True)
class _Stretch:
    """A part of a branch with constant total energy."""

    begin: float
    end: float
    total: float
    """C in J."""
    rests: bool
    """Whether the body comes to rest at its end."""


class _EndError(Exception):
    """The known curve ends before the body comes to rest."""


def collide(line: AdhesiveLine, mass: float, speed: float, rows: int) -> Course:
    """
    An impact with adhesion, with jumps at the folds of the curve under a prescribed indentation.

    Parameters
    ----------
    mass, speed : float
        In kg and m/s.
    rows : int
        Approximate number of moves of the history.

    Raises
    ------
    PathError
        If the profile ends before the bodies come to rest.
    """
    track, stretches, turn, jump_loss, free = walked(line, 0.5 * mass * speed * speed)
    potential = _potential(track)
    fractions = np.linspace(0.0, 1.0, max(2, rows // (4 if len(stretches) < 3 else 2 * len(stretches))) + 1)
    parts = [_Rows(*np.array([[0.0], [track.touch], [speed], [0.0], [0.0]]))]
    now, deepest = 0.0, 0
    for i, each in enumerate(stretches):
        rested = i > 0 and stretches[i - 1].rests
        for j, (passage, back) in enumerate(_passages(potential, mass, each, rested, fractions)):
            order = slice(None, None, -1 if back else 1)
            s = passage.parameter[order]
            time = passage.time[-1] - passage.time[::-1] if back else passage.time
            here = potential.along(s)
            sign = -1.0 if i > turn else 1.0
            radius = line.equilibria.states(s).contact_radius
            rows_of_passage = _Rows(now + time, here.depth, sign * passage.speed[order], here.force, radius)
            # only a jump has two rows at one time
            parts.append(taken(rows_of_passage, slice(1 if rested or j else 0, None)))
            now += float(time[-1])
        if i == turn:
            deepest = sum(part.time.size for part in parts) - 1
    if free is not None:
        separation_velocity = -math.sqrt(2.0 * free / mass)
        parts.append(
            _Rows(*np.array([[now], [float(parts[-1].depth[-1])], [separation_velocity], [0.0], [0.0]]))
        )
    rows_joined = joined(parts)
    return Course(
        rows_joined.time,
        rows_joined.depth,
        rows_joined.velocity,
        rows_joined.force,
        rows_joined.radius,
        sticks=free is None,
        jump_loss=jump_loss,
        deepest=deepest,
        branches=track.low.size,
        jumps_in=float(track.jumps[_TOUCH].loss[0]) > 0.0,
    )


def walked(line: AdhesiveLine, kinetic: float) -> tuple[Track, list[_Stretch], int, float, float | None]:
    """
    The stretches of an impact with adhesion.

    Returns
    -------
    Track
        Under a prescribed indentation.
    list of _Stretch
        For bodies that stick the last one ends at rest.
    int
        The stretch that ends at the largest indentation.
    float
        Energy in J dissipated by jumps up to separation.
    float or None
        Kinetic energy in J after separation; None if they stick.
    """
    bare = _bare_depth(line, kinetic)
    first = float(line.equilibria.states(np.array([line.natural_radius])).indentation[0])
    top, last = bare + max(first, 0.0) + 1e-3 * bare, 0.0
    bound = math.inf
    for _ in range(_TRIES):
        try:
            return _walked(line.track(math.inf, top), kinetic)
        except _EndError:
            last, top = top, min(_GROWTH * top, 0.5 * (top + bound))
        except PathError as error:
            if top - last <= 1e-4 * top:
                raise PathError(f"the bodies would not come to rest before the end: {error}") from error
            bound, top = top, 0.5 * (last + top)
    raise ProblemError(
        "the search for the depth of rest did not converge; check the magnitudes of mass and speed"
    )


def _bare_depth(line: AdhesiveLine, kinetic: float) -> float:
    """Approximate depth in m without adhesion."""
    bare = line.line
    assert isinstance(bare, ElasticLine)
    potential = elastic_potential(bare, 0.0)
    high, stored = depth_storing(potential, bare, line.contact.profile, kinetic)
    return high if stored < kinetic else float(depths_of_energy(potential, np.array([kinetic]), high)[0])


def _potential(track: Track) -> Potential:
    curve = track.curve
    force = curve.conjugate
    assert force is not None
    return Potential(
        lambda s: Along(curve.control(s), curve.slope(s), force(s), curve.energy(s)), tuple(curve.knots)
    )


def _walked(track: Track, kinetic: float) -> tuple[Track, list[_Stretch], int, float, float | None]:
    potential = _potential(track)
    jump = track.jumps[_TOUCH]
    branch, s = int(jump.to[0]), float(jump.after[0])
    jump_loss = float(jump.loss[0])
    total = kinetic + track.curve.free_energy(track.touch) - jump_loss
    stretches: list[_Stretch] = []
    while True:
        if branch == _UNKNOWN:
            raise _EndError
        top = float(track.top[branch])
        rest = _rest(potential, s, top, total)
        stretches.append(_Stretch(s, top if rest is None else rest, total, rest is not None))
        if rest is not None:
            break
        up = track.jumps[_UP]
        if up.to[branch] == _UNKNOWN:
            raise _EndError
        jump_loss += float(up.loss[branch])
        total -= float(up.loss[branch])
        branch, s = int(up.to[branch]), float(up.after[branch])
    turn = len(stretches) - 1
    s, stuck = stretches[-1].end, False
    while branch != _FREE:
        bottom = float(track.bottom[branch])
        rest = None if stuck else _rest(potential, s, bottom, total, leaving=stretches[-1].rests)
        if not stuck:
            stretches.append(_Stretch(s, bottom if rest is None else rest, total, rest is not None))
            stuck = rest is not None
        down = track.jumps[_DOWN]
        jump_loss += float(down.loss[branch])
        total -= float(down.loss[branch])
        branch, s = int(down.to[branch]), float(down.after[branch])
    return track, stretches, turn, jump_loss, None if stuck or total < 0.0 else total


def _rest(
    potential: Potential, begin: float, end: float, total: float, leaving: bool = False
) -> float | None:
    """The first parameter on the way to another at which all energy is stored; None if there is none."""
    s = begin + (end - begin) * np.linspace(0.0, 1.0, _LEVELS + 1)
    energy = potential.along(s).energy
    over = energy >= total
    if leaving:
        # at rest at its start, to rounding
        over[: 1 + int(np.argmin(over[1:]))] = False
    if not over.any():
        return None
    i = int(np.argmax(over))
    if i == 0:
        return begin
    return parameter_of_energy(potential, total, float(s[i - 1]), float(s[i]))


def _passages(
    potential: Potential, mass: float, stretch: _Stretch, leaves_rest: bool, fractions: FloatArray
) -> list[tuple[Passage, bool]]:
    """The passages of a stretch, and whether each is followed from its end."""
    begin, end, total = stretch.begin, stretch.end, stretch.total
    middle = [begin, end]
    passages: list[tuple[Passage, bool]] = []
    if leaves_rest:
        middle[0] = _half_energy_parameter(potential, end, begin, total)
        passages.append((stop(potential, mass, total, middle[0], begin, fractions), True))
    if stretch.rests:
        middle[1] = _half_energy_parameter(potential, begin, end, total)
    passages.append((move(potential, mass, total, middle[0], middle[1], fractions), False))
    if stretch.rests:
        passages.append((stop(potential, mass, total, middle[1], end, fractions), False))
    return passages


def _half_energy_parameter(potential: Potential, begin: float, rest: float, total: float) -> float:
    """A parameter from which on the force decelerates a body to rest, with half of the kinetic energy."""
    s = begin + (rest - begin) * np.linspace(0.0, 1.0, _LEVELS + 1)[:-1]
    here = potential.along(s)
    inward = math.copysign(1.0, rest - begin) * np.sign(here.rate)
    pushed = np.flatnonzero(here.force * inward <= 0.0)
    first = min(int(pushed[-1]) + 1, s.size - 1) if pushed.size else 0
    level = total - 0.5 * (total - float(here.energy[first]))
    return parameter_of_energy(potential, level, float(s[first]), rest)
