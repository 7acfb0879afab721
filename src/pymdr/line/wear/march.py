"""
Wear over blocks of cycles: implicit, L-stable and of second order, with blocks chosen by their error.

Lengths along the line are in units of the first contact radius a, heights in those of the first depth d, pressures in E* d/a.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.line.wear.mesh import Curve, Mesh, Stuck, graded, mesh_between
from pymdr.numerics.panels import BoolArray
from pymdr.units import FloatArray

_STAGE = 1.0 - math.sqrt(0.5)
"""Diagonal of the two-stage method, which makes it L-stable."""
_ITERATIONS, _SETTLED = 60, 1e-11
_FAST = 0.1
"""Residual after a step over that before, up to which the next step takes the same factors."""
_SHRINK, _GROW, _SAFE = 0.2, 4.0, 0.8
_SHORTEST = 1e-12
"""Fraction of all cycles below which a block counts as failure."""
_SLIVER = 0.3
"""Fraction of a cell below which its remainder beyond the stick radius joins the next cell."""
_COARSE = 2.0
"""Width of the cells beyond a stick radius that has moved, over that of a new mesh, from which on the mesh is made anew."""
_MOVES = 0.1
"""Weight of the relative error of the stick radius in a block against that of the volume."""
_WEIGHED = 8.0
"""Largest error of the guess for a ring that still counts as in contact, over the wear in a block."""
_MOST_BLOCKS = 4000
_CUTS = 6
"""How often a given block may be halved."""


@dataclass(frozen=True, eq=False)
class Wearing:
    """A contact under wear, in dimensionless form."""

    gap: Curve
    """G of the profile before wear."""
    profile: Curve
    """F of the profile before wear."""
    kinks: tuple[float, ...]
    stick: float
    """C before wear; 0 in gross slip."""
    amplitude: float
    """G* U0/(mu E* d), where 1 is the limit of gross slip."""
    rate: float
    """Growth of the depth in a cycle for unit pressure and unit slip, 4 k mu E*^2 d/(G* a)."""
    force: float | None
    """int w dx, half the constant load over E* d a; None at constant depth."""
    end: float
    """A radius that the contact never exceeds; inf where it has none."""
    cells: int = 80


class State(NamedTuple):
    """A solution after a block."""

    springs: FloatArray
    depth: float
    """Indentation d."""
    worn: FloatArray
    """Depth of wear on the rings."""
    pressure: FloatArray
    slip: FloatArray
    """Amplitude of the slip, U0 - u_x."""


@dataclass(eq=False)
class History:
    """States over cycles."""

    cycles: list[float] = field(default_factory=list)
    states: list[tuple[Mesh, State]] = field(default_factory=list)
    blocks: list[float] = field(default_factory=list)
    """Ends of the blocks."""
    missed: list[float] = field(default_factory=list)
    """Estimated error of the worn volume by the blocks, over it."""


def march(
    wearing: Wearing,
    rows: FloatArray,
    tolerance: float,
    progress: Callable[[int, int], None] | None = None,
    blocks: FloatArray | None = None,
) -> History:
    """
    Follow wear to given numbers of cycles.

    Parameters
    ----------
    rows : ndarray
        Numbers of cycles, rising, at least 0.
    tolerance : float
        Largest error of a block over the largest depth of wear.
    progress : callable, optional
        Called with the number of finished rows and all of them.
    blocks : ndarray, optional
        Ends of blocks to use, instead of those that the error chooses.

    Notes
    -----
    Every block solves f(w) - f_old = N k s(w) p(w) for the springs w by SDIRK2 (Alexander 1977), slip implicit too; each block is
    compared with its two halves, which are kept. Explicit rounds f -> g -> p -> f diverge (Li, Forsbach and Benad 2019).
    """
    mesh = mesh_between(
        wearing.stick, wearing.end, wearing.cells, wearing.gap, wearing.profile, wearing.kinks
    )
    state = _start(wearing, mesh)
    history = History()
    now, size, missed = 0.0, float(rows[rows > 0.0].min(initial=math.inf)), 0.0
    given = None if blocks is None else iter(blocks)
    for number, target in enumerate(rows):
        while now < target:
            stop = target if given is None else next(given)
            if given is None:
                # two nearly equal blocks instead of a full one and a sliver
                left = target - now
                size = min(
                    size,
                    left if left <= size * 1.0001 else max(0.5 * left, 0.0) if left < 2.0 * size else size,
                )
                stop = target if left <= size * 1.0001 else now + size
                halves, error, part = _halved(wearing, mesh, state, stop - now)
                if error > tolerance and halves is not None and stop - now > _SHORTEST * rows[-1]:
                    size = (stop - now) * max(_SHRINK, _SAFE * (tolerance / error) ** (1.0 / 3.0))
                    continue
                if halves is None:
                    size = (stop - now) * _SHRINK
                    if size < _SHORTEST * rows[-1]:
                        raise ConvergenceError(
                            f"no solution after {now:.6g} cycles; the springs do not converge in blocks of {size:.3g} cycles; give fewer cycles, or smooth the profile"
                        )
                    continue
                missed += part
                history.blocks += [0.5 * (now + stop), stop]
                size = (stop - now) * min(_GROW, _SAFE * (tolerance / max(error, 1e-300)) ** (1.0 / 3.0))
                mesh, state = halves
            else:
                step = _cut(wearing, mesh, state, stop - now)
                if step is None:
                    raise ConvergenceError(
                        f"no solution after {now:.6g} cycles; give fewer cycles, or smooth the profile"
                    )
                mesh, state = step
            now = stop
            if len(history.blocks) > _MOST_BLOCKS:
                raise ConvergenceError(
                    f"{_MOST_BLOCKS} blocks of cycles (the limit) end at {now:.6g} cycles; use fewer cycles"
                )
        if state.pressure.size != mesh.rings.size:
            solved = _solve(wearing, mesh, state.worn, 0.0, state)
            if solved is None:
                raise ConvergenceError(
                    f"the springs do not converge after {now:.6g} cycles; give fewer cycles, or smooth the profile"
                )
            state = solved
        history.cycles.append(float(target))
        history.states.append((mesh, state))
        volume = mesh.volume(state.worn)
        history.missed.append(abs(missed) / volume if volume > 0.0 else 0.0)
        if progress is not None:
            progress(number + 1, rows.size)
    return history


def _start(wearing: Wearing, mesh: Mesh) -> State:
    springs = np.maximum(1.0 - wearing.gap(mesh.nodes[:-1]), 0.0)
    state = State(springs, 1.0, np.zeros(mesh.rings.size), np.zeros(0), np.zeros(0))
    solved = _solve(wearing, mesh, state.worn, 0.0, state)
    if solved is None:
        raise ConvergenceError(
            "the springs of the contact before wear do not converge; name the radii where the profile is not smooth as breakpoints"
        )
    return solved


def _halved(
    wearing: Wearing, mesh: Mesh, state: State, block: float
) -> tuple[tuple[Mesh, State] | None, float, float]:
    """Mesh and state after two halves of a block, its error, and that of the worn volume."""
    whole = _block(wearing, mesh, state, block)
    half = _block(wearing, mesh, state, 0.5 * block)
    halves = None if half is None else _block(wearing, *half, 0.5 * block)
    if whole is None or halves is None:
        return None, math.inf, 0.0
    volume = halves[0].volume(halves[1].worn)
    change = whole[0].volume(whole[1].worn) - volume
    error = abs(change) / 3.0
    if whole[0] is halves[0]:
        error = float(np.sum(mesh.areas * np.abs(whole[1].worn - halves[1].worn))) / 3.0
    error /= max(volume, 1e-300)
    error += _MOVES * abs(whole[0].stick - halves[0].stick) / (wearing.stick or 1.0)
    return halves, error, change / 3.0


def _block(wearing: Wearing, mesh: Mesh, state: State, block: float) -> tuple[Mesh, State] | None:
    """One block by SDIRK2, and then the springs that stopped slipping; None if a stage has no solution."""
    first = _solve(wearing, mesh, state.worn, _STAGE * wearing.rate * block, state)
    if first is None:
        return None
    grown = np.maximum(first.worn - state.worn, 0.0) * ((1.0 - _STAGE) / _STAGE)
    second = _solve(wearing, mesh, state.worn + grown, _STAGE * wearing.rate * block, first)
    return None if second is None else _with_more_stick(wearing, mesh, second)


def _cut(
    wearing: Wearing, mesh: Mesh, state: State, block: float, cuts: int = _CUTS
) -> tuple[Mesh, State] | None:
    """A given block, in halves where it has no solution."""
    step = _block(wearing, mesh, state, block)
    if step is not None or cuts == 0:
        return step
    half = _cut(wearing, mesh, state, 0.5 * block, cuts - 1)
    return None if half is None else _cut(wearing, *half, 0.5 * block, cuts - 1)


def _solve(wearing: Wearing, mesh: Mesh, worn: FloatArray, weight: float, guess: State) -> State | None:
    """
    Springs w with f_old + N k s p = d - u(w) on rings in contact and p = 0 on others, at given depth or load.

    Semi-smooth Newton with halved steps; None if it does not settle.
    """
    from scipy.linalg.lapack import dgetrf, dgetrs

    n, amplitude = mesh.rings.size, wearing.amplitude
    pressing, moving, loading = mesh.pressing, mesh.moving, mesh.loading
    depth, springs = guess.depth, guess.springs.copy()
    by_force = wearing.force is not None
    scale = 1.0 + _WEIGHED * weight * amplitude
    left_to_shift = amplitude * (1.0 - mesh.inner_angle)
    free = mesh.original + worn - mesh.inner_gap

    def residual(springs: FloatArray, depth: float) -> tuple[FloatArray, BoolArray, FloatArray, FloatArray]:
        p, surface = pressing @ springs, moving @ springs
        sheared = moving @ np.minimum(springs, amplitude) if springs.max() > amplitude else surface
        slip = np.maximum(left_to_shift - sheared, 0.0)
        gap = free + weight * slip * p + surface - depth * (1.0 - mesh.inner_angle)
        # of a guess the gap is as large as the wear of the block
        touching = scale * p > gap
        values = np.zeros(n + 1)
        values[:n] = np.where(touching, gap, p)
        if wearing.force is not None:
            values[n] = depth * mesh.stick - mesh.inner_load + float(loading @ springs) - wearing.force
        return values, touching, p, slip

    values, touching, p, slip = residual(springs, depth)
    size, factors = float(np.abs(values).max()), None
    for _ in range(_ITERATIONS):
        if size < _SETTLED:
            break
        if factors is None:
            matrix = np.zeros((n + 1, n + 1), order="F")
            pressed = np.where(touching, weight * p, 0.0)[:, None]
            matrix[:n, :n] = moving * (touching[:, None] - pressed)
            matrix[:n, :n] += pressing * np.where(touching, weight * slip, 1.0)[:, None]
            whole = np.flatnonzero(springs >= amplitude)  # these springs do not shift further
            if whole.size:
                matrix[:n, whole] += pressed * moving[:, whole]
            matrix[n, n] = 1.0
            if by_force:
                matrix[:n, n] = np.where(touching, mesh.inner_angle - 1.0, 0.0)
                matrix[n, :n], matrix[n, n] = loading, mesh.stick
            *factors, singular = dgetrf(matrix, overwrite_a=True)
            if singular:
                return None
        step = dgetrs(*factors, values)[0]
        part = 1.0
        while True:
            new, new_depth = springs - part * step[:n], depth - part * (step[n] if by_force else 0.0)
            tried = residual(new, new_depth)
            reached = float(np.abs(tried[0]).max())
            if reached < size or part < 0.02 or (part == 1.0 and not np.array_equal(tried[1], touching)):
                break
            part *= 0.5
        if reached > _FAST * size or not np.array_equal(tried[1], touching):
            factors = None
        springs, depth = new, float(new_depth)
        values, touching, p, slip = tried
        size = reached
    else:
        return None
    if not math.isfinite(size):
        return None
    pressure = np.where(touching, np.maximum(p, 0.0), 0.0)
    return State(springs, depth, worn + weight * slip * pressure, pressure, slip)


def _with_more_stick(wearing: Wearing, mesh: Mesh, state: State) -> tuple[Mesh, State]:
    """
    The state with the springs frozen that have become as long as the amplitude; its springs on a new mesh are not solved yet.

    Under constant load the depth grows with wear, and with it the springs that slip little.
    """
    longer = state.springs > wearing.amplitude * (1.0 + _SETTLED)
    if wearing.force is None or not longer[0]:
        return mesh, state
    k = int(np.argmin(longer)) - 1 if not longer.all() else longer.size - 1
    springs = np.append(state.springs, 0.0)
    part = (springs[k] - wearing.amplitude) / (springs[k] - springs[k + 1])
    squares = mesh.nodes**2
    c = math.sqrt(squares[k] + part * (squares[k + 1] - squares[k]))
    if not c > mesh.stick:
        return mesh, state
    left = mesh.nodes[k + 1 :]
    fine = graded(c, float(left[-1]), wearing.cells)
    if left.size > 2 and left[1] - left[0] > _COARSE * (fine[2] - fine[1]):
        left = fine[1:]
    elif left.size > 2 and left[0] - c < _SLIVER * (left[1] - left[0]):
        left = left[1:]
    nodes = np.append(c, left)
    rings, frozen = spread_again(mesh, state.worn, nodes)
    before = mesh.stuck
    if mesh.stick == 0.0:
        # the middle of gross slip stops slipping
        before = Stuck(mesh.nodes[:1], state.depth - springs[:1], state.worn[:1])
    new_x = np.append(mesh.nodes[1 : k + 1], c)
    new_gap = np.append(state.depth - springs[1 : k + 1], state.depth - wearing.amplitude)
    # a spring is as exact as its block, but g of the stuck part rises
    gap = np.minimum(np.maximum.accumulate(np.append(before.gap, new_gap)), state.depth - wearing.amplitude)
    stuck = Stuck(
        np.append(before.x, new_x),
        gap,
        np.append(before.worn, np.interp(new_x, *mesh.whole(state.worn))),
        before.volume + frozen,
    )
    moved_springs = np.append(wearing.amplitude, np.interp(left[:-1], mesh.nodes, springs))
    unsolved = np.zeros(0)
    moved = replace(mesh, nodes=nodes, stuck=stuck)
    return moved, State(moved_springs, state.depth, rings, unsolved, unsolved)


def spread_again(mesh: Mesh, worn: FloatArray, nodes: FloatArray) -> tuple[FloatArray, float]:
    """
    Depths of wear between new nodes, without loss of volume, and the volume within the first of them.

    The depth is linear in r^2 in every old cell, with the smaller of the slopes to both sides (minmod, van Leer 1979).
    """
    squares = mesh.nodes**2
    width = np.diff(squares)
    rise = np.diff(worn) / (0.5 * (width[1:] + width[:-1]))
    steepest = 2.0 * worn / width  # no depth is negative
    right = np.append(rise, 0.0)
    left = np.append(np.copysign(steepest[0], right[0]), rise)
    slope = np.where(left * right > 0.0, np.sign(left) * np.minimum(np.abs(left), np.abs(right)), 0.0)
    cell = np.clip(np.searchsorted(squares, nodes**2, side="right") - 1, 0, worn.size - 1)
    part = nodes**2 - squares[cell]
    below = np.append(0.0, np.cumsum(mesh.areas * worn))
    start = worn[cell] - 0.5 * slope[cell] * width[cell]
    within = below[cell] + math.pi * (start + 0.5 * slope[cell] * part) * part
    return np.diff(within) / (math.pi * np.diff(nodes**2)), float(within[0])


def contact_edge(mesh: Mesh, state: State) -> float:
    """The contact radius: where the square of the pressure ends, which falls linearly to the edge."""
    pressed = np.flatnonzero(state.pressure > 0.0)
    if not pressed.size:
        return mesh.stick
    last = int(pressed[-1])
    r, p = mesh.rings, state.pressure**2
    outer = float(r[last + 1]) if last + 1 < r.size else float(mesh.nodes[-1])
    if last == 0 or not p[last - 1] > p[last]:
        return outer
    edge = r[last] + (r[last] - r[last - 1]) * p[last] / (p[last - 1] - p[last])
    return float(min(edge, outer))


def touched(mesh: Mesh, state: State) -> float:
    """The radius up to which cells are or have been in contact: at the end of wear at constant load the contact shrinks to its stick radius."""
    used = np.flatnonzero((state.pressure > 0.0) | (state.worn > 0.0))
    return float(mesh.nodes[used[-1] + 1]) if used.size else mesh.stick
