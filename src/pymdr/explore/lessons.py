"""Three lessons: springs pressed by hand, an adhesive bead pulled by a machine, and the memory of friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pymdr.explore.model import case_of, start, with_kind
from pymdr.explore.seen import Chart, Trace
from pymdr.line.friction import follow_displacements, power_law_curves, spring_shifts
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.materials import Elastic
from pymdr.problem.paths import indent, travel
from pymdr.problem.profiles import Paraboloid
from pymdr.solving.tack import pull_off
from pymdr.solving.teaching import foundation
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, from_si, good_unit, written

SHAPES = ("paraboloid", "cone", "flat_punch", "truncated_paraboloid")
"""Profiles whose springs are pressed."""
_HALF_LENGTH = 3e-4
"""Half of the line in m; the profiles have the size of a ball of 10 mm."""
_PRESSED = 0.8
"""Largest part of the line that is pressed."""
_FLAT_DEPTH = 2e-6
"""Largest indentation of the flat punch in m."""
_BEAD = Paraboloid("50 um")
_GEL = Elastic("30 kPa", 0.5)
_ROWS = (60, 240)
STIFFNESSES = (1e-3, 10.0)
"""Softest and stiffest machine in N/m."""
_BALL = Paraboloid("10 mm")
_STEEL = Elastic("210 GPa", 0.3)
_FRICTION = 0.3
DEEPEST, FARTHEST = 4e-6, 1.2e-6
"""Largest indentation and shift of the lesson of friction in m."""


def _in(values: FloatArray, unit: str, to: str) -> FloatArray:
    return np.asarray(from_si(np.asarray(values, dtype=float), unit, to))


def pressed_springs(shape: str, count: int, pressed: float) -> tuple[tuple[Chart, Chart, Chart], str]:
    """
    The three steps of the method with springs that can be counted.

    Parameters
    ----------
    shape : str
        One of :data:`SHAPES`.
    pressed : float
        Fraction of the largest indentation, above 0 and at most 1.

    Returns
    -------
    charts : tuple of Chart
        The profile and its map; the springs and their forces; the pressure of the springs and the exact one. Spring
        i carries q_i up to its outer edge x_i: the pressure is the sum of flat punches (q_i - q_(i+1)) / (pi sqrt(x_i^2 - r^2)).
    words : str
        Force and contact radius of the springs, and the exact ones.

    Notes
    -----
    Popov and Hess (2015), chapter 3.
    """
    contact = case_of(with_kind("counterbody", "rigid", with_kind("profile", shape, start("ball")))).contact
    springs = foundation(contact, 2 * count, half_length=_HALF_LENGTH)
    x, g = springs.position[count:], springs.profile[count:]
    top = float(foundation(contact, 2, half_length=2.0 * _PRESSED * _HALF_LENGTH).profile[-1])
    top = top if math.isfinite(top) and top > 0.0 else _FLAT_DEPTH
    depth = pressed * top
    exact = solve(contact, indent(depth))
    radius = float(exact["contact_radius"][-1])

    r = np.linspace(0.0, _HALF_LENGTH, 301)
    with np.errstate(invalid="ignore", divide="ignore"):
        f = np.asarray(contact.profile.gap(r), dtype=float)
    height = np.where(f <= 1.5 * top, f, np.nan)
    mapped = np.where(g <= 1.5 * top, g, np.nan)
    unit = good_unit(np.array([top]), "m")
    first = Chart(
        "radius r, position x (µm)",
        f"height ({unit})",
        (
            Trace("profile f(r)", _in(r, "m", "µm"), _in(height, "m", unit)),
            Trace("mapped profile g(x)", _in(x, "m", "µm"), _in(mapped, "m", unit), dashed=True),
        ),
        text="step 1: the profile is mapped onto the line",
    )
    force = springs.spring_forces(depth)[count:] / springs.spacing
    edges = np.repeat(np.concatenate([x - 0.5 * springs.spacing, [x[-1] + 0.5 * springs.spacing]]), 2)[1:-1]
    second = Chart(
        "position x (µm)",
        "force of the springs per length (N/mm)",
        (Trace("springs", _in(edges, "m", "µm"), np.repeat(force, 2) * 1e-3),),
        text="step 2: every spring is pressed by the indentation minus g(x)",
    )
    ends = x + 0.5 * springs.spacing
    drops = np.diff(force, append=0.0) * -1.0
    at = x[x < radius]
    squares = ends[None, :] ** 2 - at[:, None] ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        pressure = np.sum(np.where(squares > 0.0, drops / (math.pi * np.sqrt(squares)), 0.0), axis=1)
    field = exact.field("pressure")
    p = np.where(np.isfinite(field.values), field.values, np.nan)
    third = Chart(
        "radius r (µm)",
        "pressure (MPa)",
        (
            Trace("of the springs", _in(at, "m", "µm"), pressure * 1e-6),
            Trace("exact", _in(field["r"].values, "m", "µm"), p * 1e-6, dashed=True),
        ),
        text="step 3: every step of the force of the springs is the pressure of a flat punch",
    )
    words = (
        f"Indentation {written(depth, 'm')}. {2 * count} springs: force {written(springs.normal_force(depth), 'N')}, contact radius "
        f"{written(springs.contact_radius(depth), 'm')}. Exact: force {written(float(exact['normal_force'][-1]), 'N')}, contact radius "
        f"{written(radius, 'm')}."
    )
    return (first, second, third), words


def pulled_bead(stiffness: float, work: float, along: float) -> tuple[Chart, str]:
    """
    A bead on a gel in a machine: all equilibria, the path with its jumps, and the line of the machine.

    Parameters
    ----------
    stiffness : float
        Of the machine in N/m.
    work : float
        Work of adhesion in J/m^2.
    along : float
        Fraction of the path of approach and retraction, 0 to 1.

    Returns
    -------
    chart : Chart
        Force against indentation; an equilibrium is on the line F = k (D - d) of the machine.
    words : str
        Pull-off, jumps and the energy that they dissipate.
    """
    contact = Contact(_BEAD, _GEL, adhesion=JKR(work))
    last = pull_off(contact, machine_stiffness=stiffness)
    pressed = 4.0 * abs(last.indentation)
    result = solve(
        contact,
        travel(pressed, steps=_ROWS[0]) >> travel(1.3 * last.travel, steps=_ROWS[1]),
        machine_stiffness=stiffness,
    )
    branches = result.reading.plots(result, -1).data.equilibria
    equilibria = None if branches is None else branches()
    row = round(along * (result.data.sizes["step"] - 1))
    names = ("indentation", "normal_force", "travel")
    d, force, moved = (result.data[name].values for name in names)
    traces = []
    if equilibria is not None:
        stable = equilibria.stable
        near = equilibria.curve["indentation"] <= pressed
        for name, keep in (("stable", stable & near), ("unstable", ~stable & near)):
            y = np.where(keep, equilibria.curve["normal_force"], np.nan)
            traces.append(
                Trace(
                    name, _in(equilibria.curve["indentation"], "m", "µm"), y * 1e9, dashed=name == "unstable"
                )
            )
        trail = equilibria.trail
        traces.append(Trace("path", _in(trail["indentation"], "m", "µm"), trail["normal_force"] * 1e9))
    at = np.array([np.nanmin(force), np.nanmax(force)])
    traces.append(Trace("machine", _in(moved[row] - at / stiffness, "m", "µm"), at * 1e9, dashed=True))
    jumps = int(np.count_nonzero(result.data["jumped"].values))
    words = (
        f"Machine at {written(float(moved[row]), 'm')}: indentation {written(float(d[row]), 'm')}, force "
        f"{written(float(force[row]), 'N')}. {jumps} jumps dissipate {written(float(result.data['dissipated_energy'].values[-1]), 'J')}. "
        f"Pull-off at {written(last.normal_force, 'N')}."
    )
    marks = (_in(d[row : row + 1], "m", "µm"), force[row : row + 1] * 1e9)
    return Chart("indentation (µm)", "normal force (nN)", tuple(traces), marks, words), words


def friction_memory(moves: Sequence[tuple[float, float]]) -> tuple[tuple[Chart, Chart, Chart], str]:
    """
    The memory of a joint with friction after moves by hand: the stack of its turning points.

    Parameters
    ----------
    moves : sequence of pair of float
        Indentation and shift in m after every move, the first from the unloaded contact.

    Returns
    -------
    charts : tuple of Chart
        The anchors b of the springs over their depth g(x) with the vertices of the stack; the shift of the springs along the
        line; tangential force against shift.
    words : str
        Both forces, stick radius, and the size of the stack.

    Notes
    -----
    Jäger (1993); Aleshin and others (2015). Springs of one depth are alike, and only vertices where the shift
    turned are remembered; a larger move wipes the smaller ones out.
    """
    moduli = effective_moduli(_STEEL, _STEEL)
    curves = power_law_curves(2.0, 1.0 / _BALL.radius, moduli.normal)
    d, u = (np.array(column) for column in zip(*moves, strict=True))
    run = follow_displacements(curves, d, u, _FRICTION, moduli.tangential)
    state = run.state
    anchors = Chart(
        "depth of the spring g(x) (µm)",
        "anchor of the spring (µm)",
        (Trace("anchors", state.y * 1e6, state.b * state.shift_scale * 1e6),),
        (state.y * 1e6, state.b * state.shift_scale * 1e6),
        f"{state.y.size} vertices of the stack",
    )
    radius = math.sqrt(_BALL.radius * max(state.indentation, 0.0))
    x = np.linspace(-radius, radius, 241)
    springs = spring_shifts(state, x**2 / _BALL.radius) if radius else np.zeros(x.shape)
    line = Chart("position x (µm)", "shift of the spring (µm)", (Trace("springs", x * 1e6, springs * 1e6),))
    forces = np.concatenate([[0.0], run.tangential_force])
    loop = Chart(
        "shift (µm)",
        "tangential force (N)",
        (Trace("history", np.concatenate([[0.0], u]) * 1e6, forces),),
        (u[-1:] * 1e6, forces[-1:]),
    )
    normal = 4.0 / 3.0 * moduli.normal * math.sqrt(_BALL.radius) * max(state.indentation, 0.0) ** 1.5
    words = (
        f"Normal force {written(normal, 'N')}, tangential force {written(float(forces[-1]), 'N')} (limit "
        f"{written(_FRICTION * normal, 'N')}), stick radius {written(float(run.stick_radius[-1]), 'm')} of {written(radius, 'm')}. "
        f"The contact remembers {state.y.size} vertices after {len(moves)} moves; slip has dissipated {written(state.slip_work, 'J')}."
    )
    return (anchors, replace(line, text=words), loop), words
