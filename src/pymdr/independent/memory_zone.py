"""Viscoelastic contact under a cohesive zone by boundary elements on rings: no Abel map, no g(x), no springs.

The tension s0 acts on the disk r < c, of which the displacement is a closed form, and the contact presses against it: with
p = q - s0, q >= 0, a step with known c is Signorini's problem of q for the gap of the history and of the disk (see
`memory`). In a step, c is the root of one equation: the gap at c is the range. The ring that contains c bears its fraction.
Where the root ends, the contact jumps to the next one at the same strains. Errors of forces are of second order in the ring width over
the zone and in the step.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.independent.history import gap_of
from pymdr.independent.memory import Bodies, Strained, corners_of, extended, padded, solution_at, step_of
from pymdr.independent.rings import (
    Array,
    RingMesh,
    RingProblem,
    Rings,
    RingSolution,
    RingState,
    Zones,
    active_set,
    product,
)
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres

_MOVED = 3.2
"""Largest move of c in a step, and difference from its linear prediction, over the width of the zone and the number of rings."""
_SOLVED = 1e-7
"""Residual of the gap at c over the range."""
_FEWEST = 6
"""Fewest rings in a zone."""
_COARSE = 80
"""Rings of the mesh that determines the largest radius."""
_SHORTEST = 1e-5
"""Step below which the contact jumps, over the shortest of a row and the relaxation times."""
_TRIALS, _STEPS = 40, 20_000
_FREE = 50
"""Steps of a row before the contact begins."""
_UNBOUND = 10.0
"""Excess where no contact bears the force."""


class Attraction(NamedTuple):
    """A constant tension up to a gap."""

    stress: float
    """In Pa."""
    range: float
    """In m."""


class Pulled(NamedTuple):
    """A viscoelastic surface under a cohesive zone, on its mesh."""

    mesh: RingMesh
    surface: Strained
    """Its pressure is q, its zones are those of the contact."""
    time: float
    outer: float
    """Radius c of the end of the zone in m; 0 where the surfaces are separated."""
    rate: float
    """Rate of c in m/s, by the last step."""
    step: float
    """Length of the next step in s."""


class PulledLeg(NamedTuple):
    """The rows of a leg, and its final state."""

    solutions: list[RingSolution | None]
    """None where the surfaces are separated."""
    state: Pulled


class PulledSetting(NamedTuple):
    """A contact, and the control of its legs."""

    bodies: Bodies
    relaxation: Relaxation
    attraction: Attraction
    by_force: bool
    rings: Rings
    longest: float = math.inf
    """Duration of the path in s, by which a body that flows is sized."""


class _Trial(NamedTuple):
    """A step of a given length."""

    setting: PulledSetting
    mesh: RingMesh
    free: Array
    """Strains without pressure."""
    gap: Array
    """Gaps without pressure at the centres in m, for d = 0."""
    stiff: float
    target: float
    zones: Zones


class _Settled(NamedTuple):
    """A contact with a given c."""

    outer: float
    contact: RingState | None
    """Pressures q for E* = 1; None where no contact bears the force."""
    excess: float
    """Gap at c over the range, less 1."""


def follow_pulled(
    setting: PulledSetting, time: FloatArray, target: FloatArray, state: Pulled | None
) -> PulledLeg:
    """
    Follow indentations or forces that are linear in time between the rows.

    Parameters
    ----------
    time : ndarray, shape (m + 1,)
        Non-decreasing times in s at the start of the leg and at every row.
    target : ndarray, shape (m + 1,)
        Indentations in m or forces in N at these times.
    state : Pulled or None
        State to continue from; None before the first contact.

    Notes
    -----
    Lee and Radok (1960), J. Appl. Mech. 27, 438, for the surface; Maugis (1992), J. Colloid Interface Sci. 150, 243, for the zone.

    Examples
    --------
    >>> from pymdr.problem.profiles import Paraboloid
    >>> elastic = Relaxation(1.0, np.zeros(0), np.zeros(0))
    >>> setting = PulledSetting(Bodies(Paraboloid(1.0)), elastic, Attraction(2.0, 0.5), False, Rings(100))
    >>> leg = follow_pulled(setting, np.array([0.0, 1.0]), np.array([-0.6, 0.5]), None)
    >>> round(leg.solutions[0].force, 2)
    -3.49
    """
    state = _with_rings(setting, state, float(target.max()))
    solutions: list[RingSolution | None] = []
    for i in range(target.size - 1):
        state = _row(setting, state, time[i : i + 2].tolist(), target[i : i + 2].tolist())
        solutions.append(_solution(setting, state) if state.outer > 0.0 else None)
    return PulledLeg(solutions, state)


def _with_rings(setting: PulledSetting, state: Pulled | None, target: float) -> Pulled:
    """A state, by default a free surface, with rings up to the zone of the softest body at a target."""
    before = None if state is None else state.mesh
    mesh = extended(setting.bodies, before, 1.02 * _largest_radius(setting, target), setting.rings.n)
    assert mesh is not None
    n, k = mesh.centres.size, setting.relaxation.moduli.size
    if state is None:
        none = Strained(np.zeros(0), np.zeros((k, 0)), np.zeros(0), math.nan, (), 0.0)
        state = Pulled(mesh, none, math.nan, 0.0, 0.0, 0.0)
    return state._replace(mesh=mesh, surface=padded(state.surface, n))


def _largest_radius(setting: PulledSetting, target: float) -> float:
    """Radius c of the softest body at a target."""
    bodies, relaxation, attraction, by_force, _, longest = setting
    gap, radius, stiff = gap_of(bodies.profile), 1.0, relaxation.softest(longest)
    depth = attraction.range + (0.0 if by_force else max(target, 0.0))
    while float(gap(np.array([radius]))[0]) < depth:
        radius *= 2.0
    while float(gap(np.array([0.5 * radius]))[0]) > depth:
        radius *= 0.5
    while True:
        mesh = extended(bodies, None, radius, _COARSE)
        assert mesh is not None
        trial = _Trial(setting, mesh, np.zeros(mesh.centres.size), mesh.gap, stiff, target, ())
        settled = _next(trial, 0.0)
        if settled is not None or _settled(trial, radius).excess > 0.0:
            return radius if settled is None else settled.outer
        radius *= 1.4


def _row(setting: PulledSetting, state: Pulled, time: list[float], target: list[float]) -> Pulled:
    """Follow one row by steps of their own length."""
    (start, stop), span = time, time[1] - time[0]
    fastest = min([*setting.relaxation.times.tolist(), span])
    first, most = 0.02 * fastest, _MOVED / setting.rings.n
    state = state._replace(time=start, step=max(state.step, first))
    for _ in range(_STEPS):
        left = stop - state.time
        length = left if state.step >= left else min(state.step, 0.5 * left)
        if state.outer == 0.0:
            length = min(left, span / _FREE)
        fraction = (state.time + length - start) / span if span > 0.0 else 1.0
        trial = _trial(setting, state, length, target[0] + (target[1] - target[0]) * fraction)
        if state.outer == 0.0 or length <= _SHORTEST * fastest:
            settled = _next(trial, state.outer)
            state = (
                _separated(trial, state, length) if settled is None else _taken(trial, state, settled, length)
            )
            state = state._replace(rate=0.0, step=first)
        else:
            width = state.outer - _contact_radius(state.surface)
            settled = _near(trial, state, length, 2.0 * most * width)
            missed = (
                0.0 if settled is None else abs(settled.outer - state.outer - state.rate * length) / width
            )
            if settled is None or (missed > most and length > 0.01 * fastest):
                state = state._replace(step=0.5 * length)
                continue
            moved = max(abs(settled.outer - state.outer) / width, 0.5 * most)
            state = _taken(trial, state, settled, length)._replace(step=length * min(most / moved, 1.5))
        if stop - state.time <= 1e-12 * span:
            return state
    raise ConvergenceError(f"the row up to {stop:.6g} s needs more than {_STEPS} steps; give shorter rows")


def _trial(setting: PulledSetting, state: Pulled, length: float, target: float) -> _Trial:
    _, stiff, _, free = step_of(setting.relaxation, state.surface, length)
    gap = state.mesh.gap + product(state.mesh.matrix, free)
    return _Trial(setting, state.mesh, free, gap, stiff, target, state.surface.zones)


def _settled(trial: _Trial, c: float) -> _Settled:
    """The contact with the end of the zone at c."""
    bodies, _, attraction, by_force, rings, _ = trial.setting
    mesh, pull = trial.mesh, attraction.stress / trial.stiff
    depth, force = (
        (None, trial.target / trial.stiff + math.pi * c * c * pull) if by_force else (trial.target, None)
    )
    if force is not None and force <= 0.0:
        return _Settled(c, None, _UNBOUND)
    disk = bodies.surface.displacement(np.append(mesh.centres, c), np.array([0.0, c]))[:, 0]
    problem = RingProblem(np.zeros_like, depth, force, corners_of(bodies.profile), rings.n, 1.0)
    gap = trial.gap - pull * disk[:-1]
    contact = active_set(problem, mesh._replace(gap=gap), trial.zones)
    row = bodies.surface.displacement(np.array([c]), mesh.edges)[0]
    height = float(np.asarray(gap_of(bodies.profile)(np.array([c])))[0])
    opened = height - contact.depth + float(row @ (trial.free + contact.pressure)) - pull * float(disk[-1])
    return _Settled(c, contact, opened / attraction.range - 1.0)


def _covered(mesh: RingMesh, c: float) -> Array:
    """Fractions of the rings in the disk of radius c."""
    inner, outer = mesh.edges[:-1] ** 2, mesh.edges[1:] ** 2
    return np.asarray(np.clip((c * c - inner) / (outer - inner), 0.0, 1.0))


def _near(trial: _Trial, state: Pulled, length: float, bound: float) -> _Settled | None:
    """The root within a bound of the state at which the excess rises with c; None if there is none."""
    c0, width = state.outer, state.outer - _contact_radius(state.surface)
    low: _Settled | None = None
    high: _Settled | None = None
    last: _Settled | None = None
    c, slope = c0 + float(np.clip(state.rate * length, -0.5 * bound, 0.5 * bound)), 1.0 / width
    for _ in range(_TRIALS):
        settled = _settled(trial, c)
        if abs(settled.excess) < _SOLVED:
            return settled
        if last is not None and (rise := (settled.excess - last.excess) / (c - last.outer)) > 0.0:
            slope = rise
        low, high = (settled, high) if settled.excess < 0.0 else (low, settled)
        last = settled
        if low is not None and high is not None:
            if low.outer >= high.outer:
                return None
            if high.outer - low.outer < 1e-9 * width:
                return settled
            c = _between(low, high, c - settled.excess / slope)
        else:
            c = float(np.clip(c - settled.excess / slope, c0 - bound, c0 + bound))
            if c == last.outer:
                return None
    return None


def _between(low: _Settled, high: _Settled, guess: float) -> float:
    """A guess between two ends, else their middle."""
    span = high.outer - low.outer
    inside = low.outer + 0.01 * span < guess < high.outer - 0.01 * span
    return guess if inside else low.outer + 0.5 * span


def _next(trial: _Trial, c0: float) -> _Settled | None:
    """The next stable state from c0 at the same strains, outwards or inwards; None if the surfaces separate."""
    border = float(trial.mesh.edges[-1])
    stride = max(border / trial.mesh.centres.size, 0.01 * c0)
    if c0 == 0.0:
        opened = trial.gap[0] - trial.target if not trial.setting.by_force else -1.0
        if opened > trial.setting.attraction.range:
            return None
    before = _settled(trial, max(c0, 0.5 * stride))
    outwards = c0 == 0.0 or before.excess < 0.0
    while True:
        c = before.outer + (stride if outwards else -stride)
        if not 0.0 < c < border:
            return None
        after = _settled(trial, c)
        if (after.excess > 0.0) == outwards:
            break
        before = after
    low, high = (before, after) if outwards else (after, before)
    for _ in range(_TRIALS):
        middle = _settled(trial, 0.5 * (low.outer + high.outer))
        low, high = (middle, high) if middle.excess < 0.0 else (low, middle)
    return high if high.contact is not None else None


def _contact_radius(surface: Strained) -> float:
    return surface.zones[-1][1] if surface.zones else 0.0


def _taken(trial: _Trial, state: Pulled, settled: _Settled, length: float) -> Pulled:
    """The state after a step."""
    assert settled.contact is not None
    mesh, c, relaxation = state.mesh, settled.outer, trial.setting.relaxation
    strain = settled.contact.pressure - trial.setting.attraction.stress / trial.stiff * _covered(mesh, c)
    moduli, _, branches, _ = step_of(relaxation, state.surface, length)
    whole = trial.free + strain
    surface = Strained(
        whole,
        branches + moduli[:, None] * (whole - state.surface.strain),
        trial.stiff * settled.contact.pressure,
        settled.contact.depth,
        settled.contact.zones,
        settled.contact.stiffness,
    )
    rate = (c - state.outer) / length if length > 0.0 else 0.0
    return Pulled(mesh, surface, state.time + length, c, rate, 0.0)


def _separated(trial: _Trial, state: Pulled, length: float) -> Pulled:
    """The free surface after a step."""
    moduli, _, branches, free = step_of(trial.setting.relaxation, state.surface, length)
    surface = Strained(
        free,
        branches + moduli[:, None] * (free - state.surface.strain),
        np.zeros(free.size),
        math.nan if trial.setting.by_force else trial.target,
        (),
        0.0,
    )
    return Pulled(state.mesh, surface, state.time + length, 0.0, 0.0, 0.0)


def _solution(setting: PulledSetting, state: Pulled) -> RingSolution:
    bodies, relaxation, attraction, _, _, _ = setting
    mesh, c, stress = state.mesh, state.outer, attraction.stress
    inner = _contact_radius(state.surface)
    count = int(np.sum((mesh.centres > inner) & (mesh.centres < c)))
    if count < _FEWEST:
        raise ProblemError(
            f"the zone of {metres(c - inner)} covers {count} rings and needs {_FEWEST}; use more rings or a longer range"
        )
    solved = solution_at(relaxation, mesh, corners_of(bodies.profile), state.surface)
    force = solved.force - math.pi * stress * c * c
    return replace(
        solved,
        surface=bodies.surface,
        force=force,
        mean_pressure=force / solved.contact_area if solved.zones else 0.0,
        tension=stress,
        cohesive_radius=c,
    )
