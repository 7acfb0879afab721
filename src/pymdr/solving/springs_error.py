"""Errors of contacts on a number of springs that other programs move, over random motions."""

from __future__ import annotations

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from pymdr.line.memory import RelaxingContacts, ShearedContacts
from pymdr.line.moved import Moved
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.solving.moving import moving_of
from pymdr.units import FloatArray

_STEPS = 40
_SIZES = 0.1, 0.3, 1.0
"""Shifts of motions, of that at which the whole contact slides."""
_PART_SIZES = 0.1, 1.0, 30.0
"""The same of motions with equal parts: what long slides dissipate depends on the load between the ends of a part."""
_SAFE = 3.0
"""Ratio of the error to the largest difference to half the springs, which is near the error or above, with a margin."""
_IN_PARTS = 24
"""Springs on which errors of equal parts are measured."""
_BEYOND = 1.5
"""Decades by which motions are faster than the shortest relaxation and slower than the longest."""
_FOLLOWED = 100
"""Springs with memory and friction beyond which the error is taken to fall as their number, as it does where it falls slowest."""
_NORMAL = "normal_force", "contact_radius", "elastic_energy"
_TANGENTIAL = "tangential_force", "stick_radius", "stored_tangential_energy"
_RADII = "contact_radius", "stick_radius"
_FORCES = "normal_force", "tangential_force"


class _Motion(NamedTuple):
    """Steps: indentations and shifts in m, durations in s."""

    depth: FloatArray
    shift: FloatArray
    duration: FloatArray


def errors_of_springs(
    contact: Contact, deepest: float, springs: int, own: Moved | None = None
) -> dict[str, float]:
    """
    Errors of the quantities that depend on the number of springs, relative to their largest value, of radii to that of the contact radius, in motions down to the deepest indentation.

    The error is three times the largest difference to half the springs over random motions: one without memory, one for each decade of time with it.
    That of a radius is at least the distance of two springs; with dashpots that of a force too, since it is finite at the edge.

    Parameters
    ----------
    contact : Contact
        With memory, or with friction in the plane.
    deepest : float
        The largest indentation in m.
    springs : int
        Their number.
    own : Moved, optional
        A contact of that many springs which has not been moved, if it is there already.
    """
    if contact.is_viscoelastic and contact.friction is not None and springs > _FOLLOWED:
        measured = errors_of_springs(contact, deepest, _FOLLOWED)
        return {name: error * _FOLLOWED / springs for name, error in measured.items()}
    own = own or moving_of(contact, deepest, 1, springs).contacts
    fewer = moving_of(contact, deepest, 1, springs // 2).contacts
    normal = own.normal if isinstance(own, ShearedContacts) else own
    between: tuple[str, ...]
    if isinstance(normal, RelaxingContacts):
        relaxation, place = normal.relaxation, normal.springs.position
        spacing = float(np.diff(place, prepend=0.0).max() / place[-1])
        names = (*_NORMAL, *(() if normal is own else _TANGENTIAL), "dissipated_energy")
        between = _RADII + _FORCES if relaxation.viscosity > 0.0 else _RADII
    else:
        relaxation, spacing = None, 1.0 / springs
        names, between = ("contact_radius", *_TANGENTIAL, "dissipated_energy"), ("stick_radius",)
    errors = np.where(np.isin(names, between), spacing, 0.0)
    random = np.random.default_rng(0)
    sliding = deepest * min(1.0 if contact.friction is None else contact.friction.coefficient, 1.0)
    for time, size in product(_times(relaxation), _SIZES):
        motion = _random_motion(random, deepest, size * sliding, own.shift.shape[1:], time)
        fine, coarse = (_followed(contacts.copied(), motion, names) for contacts in (own, fewer))
        largest = np.linalg.norm(fine, axis=-1).max(axis=0)
        largest[np.isin(names, _RADII)] = largest[names.index("contact_radius")]
        difference = np.linalg.norm(fine - coarse, axis=-1).max(axis=0)
        relative = np.divide(difference, largest, out=np.zeros_like(largest), where=largest > 0.0)
        errors = np.maximum(errors, _SAFE * relative)
    return dict(zip(names, errors.tolist(), strict=True))


def errors_of_parts(contact: Contact, deepest: float, parts: int) -> dict[str, float]:
    """
    Errors of steps with memory and friction that are divided into parts, relative to the largest values in motions down to an indentation in m.

    They are three times the largest difference to parts on which all loads are straight, over random motions on a few springs, whose durations are of one
    decade or of all. Other motions may miss more.

    Parameters
    ----------
    contact : Contact
        With memory and friction.
    deepest : float
        The largest indentation in m.
    parts : int
        Number of equal parts, of which the first is divided from the shortest relaxation time.
    """
    exact = moving_of(contact, deepest, 1, _IN_PARTS).contacts
    assert isinstance(exact, ShearedContacts)
    names = ("tangential_force", "stored_tangential_energy", "dissipated_energy")
    random, errors = np.random.default_rng(0), np.zeros(len(names))
    sliding = deepest * min(1.0 if contact.friction is None else contact.friction.coefficient, 1.0)
    times = _times(exact.relaxation)
    shortest = float(min(exact.relaxation.times.min(), exact.normal.relaxation.times.min()))
    for time, size in product(times, _PART_SIZES):
        motion = _random_motion(random, deepest, size * sliding, (), time)
        others = random.random(_STEPS) < 0.5
        motion.duration[others] = random.choice(times, others.sum())
        motion.duration[::7] = 0.0  # sudden steps
        divided = exact.copied()
        divided.division = math.inf, 1
        fine = _followed(exact.copied(), motion, names)
        coarse = _followed(divided, motion, names, parts, shortest)
        largest = np.abs(fine).max(axis=(0, 2))
        errors = np.maximum(errors, _SAFE * np.abs(coarse - fine).max(axis=(0, 2)) / largest)
    # slip may dissipate less than the dashpots of these motions
    errors[-1] = errors.max()
    return dict(zip(names, errors.tolist(), strict=True))


def _times(relaxation: Relaxation | None) -> FloatArray:
    """Times in s of a step, one for each decade in which bodies relax."""
    if relaxation is None:
        return np.ones(1)
    dashpot = relaxation.viscosity / (relaxation.equilibrium + relaxation.moduli.sum())
    times = np.log10(np.append(relaxation.times, dashpot or relaxation.times[:1]))
    return np.asarray(10.0 ** np.arange(times.min() - _BEYOND, times.max() + _BEYOND + 0.5))


def _random_motion(
    random: np.random.Generator, deepest: float, shift: float, axes: tuple[int, ...], time: float
) -> _Motion:
    """Indentations to the deepest, with losses of contact, and walks along the axes by steps about a shift."""
    depth = np.abs(random.normal(0.0, 0.4 * deepest, _STEPS)).clip(0.0, deepest)
    depth[_STEPS // 3], depth[::7] = deepest, -0.2 * deepest
    walk = shift * np.cumsum(random.normal(size=(_STEPS, *axes)), axis=0)
    return _Motion(depth, walk, time * 10.0 ** random.uniform(-1.0, 1.0, _STEPS))


def _ends_of_parts(ratio: float, parts: int) -> FloatArray:
    """Fractions of a step at which its equal parts end; the first is divided geometrically, for the ratio of its duration to the shortest relaxation."""
    first = max(math.ceil(2.0 * math.log10(1.0 + ratio)), 1)
    inner = np.expm1(math.log1p(ratio) * np.arange(1, first) / first) / ratio if first > 1 else np.empty(0)
    return np.concatenate([inner, np.arange(1.0, parts + 1.0)]) / parts


def _followed(
    contacts: Moved, motion: _Motion, names: tuple[str, ...], parts: int = 1, shortest: float = math.inf
) -> FloatArray:
    """Quantities after each step, shape (steps, names, 2); what has one component has 0 as the other. Each step is taken in parts."""
    here = np.zeros(2)
    values = np.zeros((_STEPS, len(names), 2))
    for row, (depth, shift, duration) in enumerate(zip(*motion, strict=True)):
        last = 0.0
        for end in _ends_of_parts(float(duration) / (parts * shortest), parts)[:-1].tolist():
            d, u = here + (np.array([depth, shift]) - here) * end
            contacts.advance(float(d), float(u), float(duration) * (end - last))
            last = end
        contacts.advance(float(depth), shift, float(duration) * (1.0 - last))
        here = np.array([depth, shift]) if parts > 1 else here
        for column, name in enumerate(names):
            value = getattr(contacts, name)[0]
            values[row, column, : np.size(value)] = value
    return values
