"""Cells of the line and rings of the surface of a contact that wears, in units of its first radius and depth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_GRADED, _ABOUT = 2.5, 2.0
"""Exponents of the cells beyond the stick radius, near which the springs change most, and about a kink."""
_NODES = 32
_JUMP = 1e-9
"""Jump of g over the indentation that is rounding."""

Curve = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Stuck:
    """Springs that have stopped slipping: the part of the line between the first stick radius and the present one."""

    x: FloatArray
    """Positions, rising from the first stick radius."""
    gap: FloatArray
    """G(x) of the worn profile there, frozen since."""
    worn: FloatArray
    """Depth of wear on the surface at r = x, frozen too."""
    volume: float = 0.0
    """Worn volume between the radii."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """
    Nodes of springs beyond the stick radius c, and between each two of them a ring on the surface.

    Between nodes the springs are linear in x^2, which is exact for a paraboloid that has not worn. At c they may jump.
    """

    nodes: FloatArray
    """Positions x of springs, from c to the end; the last spring has no force."""
    gap: Curve
    """g(x) of the profile before wear."""
    profile: Curve
    """f(r) of the profile before wear."""
    kinks: tuple[float, ...]
    """Where g' jumps."""
    stuck: Stuck

    @property
    def original(self) -> FloatArray:
        """Gap f(r) of the profile before wear on every ring."""
        return self.profile(self.rings)

    @cached_property
    def inner_gap(self) -> FloatArray:
        """Integral (2/pi) int_0^c g / sqrt(r^2 - x^2) dx on every ring."""
        first, whole = float(self.stuck.x[0]), np.zeros(self.rings.size)
        if first > 0.0:
            whole = inner_integral(self.rings, first, self.gap, self.kinks)
        if self.stuck.x.size > 1:
            rise, whole_cell = _displacements(self.stuck.x, self.rings[:, None])
            whole = whole + 2.0 / math.pi * (
                whole_cell @ self.stuck.gap[:-1] + rise @ np.diff(self.stuck.gap)
            )
        return whole

    @cached_property
    def inner_load(self) -> float:
        """Integral int_0^c g dx."""
        first = float(self.stuck.x[0])
        load = _load(first, self.gap, self.kinks) if first > 0.0 else 0.0
        rise, width = _loads(self.stuck.x)
        return load + float(np.sum(width * self.stuck.gap[:-1] + rise * np.diff(self.stuck.gap)))

    @cached_property
    def rings(self) -> FloatArray:
        """Radii r of the rings, in the middle of the cells."""
        return np.asarray(0.5 * (self.nodes[1:] + self.nodes[:-1]))

    @property
    def stick(self) -> float:
        """The radius c up to which nothing wears."""
        return float(self.nodes[0])

    @cached_property
    def areas(self) -> FloatArray:
        """Area of the rings."""
        return np.asarray(math.pi * np.diff(self.nodes**2))

    @cached_property
    def inner_angle(self) -> FloatArray:
        """(2/pi) arcsin(c/r): displacement of the rings by springs of unit length up to c."""
        return np.asarray(2.0 / math.pi * np.arcsin(self.stick / self.rings))

    @cached_property
    def pressing(self) -> FloatArray:
        """
        Mean pressure of the rings by unit springs, shape (rings, springs).

        The load beyond r is -2 int_r^a w' sqrt(x^2 - r^2) dx, so that the rings carry the load of the springs.
        """
        squares = self.nodes**2
        powers = np.maximum(squares - squares[:, None], 0.0) ** 1.5
        beyond = -4.0 / 3.0 * np.diff(powers, axis=1) / np.diff(squares)
        per_rise = -np.diff(beyond, axis=0) / self.areas[:, None]
        return _spread(per_rise, np.zeros_like(per_rise))

    @cached_property
    def moving(self) -> FloatArray:
        """Displacement (2/pi) int w / sqrt(r^2 - x^2) dx of unit springs beyond c, shape (rings, springs)."""
        rise, whole = _displacements(self.nodes, self.rings[:, None])
        return np.asarray(2.0 / math.pi * _spread(rise, whole))

    @cached_property
    def loading(self) -> FloatArray:
        """Integral int w dx of unit springs beyond c, shape (springs,)."""
        rise, width = _loads(self.nodes)
        return np.asarray(_spread(rise[None, :], width[None, :])[0])

    def volume(self, worn: FloatArray) -> float:
        """Worn volume of a depth of wear on the rings."""
        return self.stuck.volume + float(np.sum(self.areas * worn))

    def pressure_within(self, r: FloatArray, springs: FloatArray, depth: float) -> FloatArray:
        """
        Pressure at radii up to the stick radius c by the springs beyond the first stick radius, int g'/sqrt(x^2 - r^2) dx/pi.

        Where g jumps at c, the pressure is infinite there like 1/sqrt(c^2 - r^2).
        """
        gap = depth - np.append(springs, 0.0)
        total = _rises(self.stuck.x, self.stuck.gap, r) + _rises(self.nodes, gap, r)
        jump = float(gap[0] - self.stuck.gap[-1]) if self.stick > 0.0 else 0.0
        if jump > _JUMP * depth:
            with np.errstate(divide="ignore"):
                total += jump / np.sqrt((self.stick - r) * (self.stick + r))
        return total / math.pi

    def whole(self, worn: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radii from the first stick radius to the end and the depth of wear at them."""
        last = worn[:1] if self.stick == 0.0 else np.zeros(0)
        radii = np.concatenate([self.stuck.x, self.rings, self.nodes[-1:]])
        inner = last if last.size else self.stuck.worn
        return radii, np.concatenate([inner, worn, [0.0]])


def _rises(x: FloatArray, gap: FloatArray, r: FloatArray) -> FloatArray:
    """The integral of g'/sqrt(x^2 - r^2) over the cells at radii r, g linear in x^2 in each."""
    squares = x**2
    roots = np.sqrt(np.maximum(squares - r[:, None] ** 2, 0.0))
    return np.asarray(2.0 * np.sum(np.diff(gap) / np.diff(squares) * np.diff(roots, axis=1), axis=1))


def _displacements(x: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integrals over cells of (x^2 - low^2)/(high^2 - low^2)/sqrt(r^2 - x^2) and of 1/sqrt(r^2 - x^2), shape (rings, cells)."""
    inside = np.minimum(x, r)
    root = np.sqrt((r - inside) * (r + inside))
    angle = np.diff(np.arctan2(inside, root), axis=1)
    square = 0.5 * (r * r * angle - np.diff(inside * root, axis=1))
    return (square - x[:-1] ** 2 * angle) / np.diff(x**2), angle


def _loads(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integrals over cells of (x^2 - low^2)/(high^2 - low^2), without cancellation, and of 1."""
    width = np.diff(x)
    low, high = x[:-1], x[1:]
    total = np.where(high > 0.0, low + high, 1.0)
    return width * (high + 2.0 * low) / (3.0 * total), width


def _spread(rise: FloatArray, first: FloatArray) -> FloatArray:
    """Integrals over cells w_j first_j + (w_(j+1) - w_j) rise_j as weights of the springs; the last spring is 0."""
    weights = first - rise
    weights[:, 1:] += rise[:, :-1]
    return weights


def mesh_between(
    stick: float, end: float, cells: int, gap: Curve, profile: Curve, kinks: tuple[float, ...]
) -> Mesh:
    """
    A mesh from the stick radius to the end.

    Parameters
    ----------
    stick, end : float
        c and the outermost node.
    gap, profile : callable
        g(x) and f(r) of the profile before wear, for arrays.
    kinks : tuple of float
        Where g' jumps.
    """
    if stick > 0.0:
        nodes = graded(stick, end, cells)
    else:
        nodes = _graded_about(max((k for k in kinks if k < 1.0), default=0.0), end, cells)
    nodes[-1] = end
    inner = nodes[1:-1]
    inner[np.argmin(np.abs(inner - 1.0))] = 1.0  # the edge of contact before wear
    none = Stuck(np.array([stick]), np.zeros(1), np.zeros(1))
    if stick > 0.0:
        none = Stuck(np.array([stick]), gap(np.array([stick])), np.zeros(1))
    return Mesh(nodes, gap, profile, kinks, none)


def graded(stick: float, end: float, cells: int) -> FloatArray:
    """Nodes from a stick radius to the end, close together at the stick radius."""
    nodes = stick + (end - stick) * np.linspace(0.0, 1.0, cells + 1) ** _GRADED
    nodes[-1] = end
    return np.asarray(nodes)


def _graded_about(kink: float, end: float, cells: int) -> FloatArray:
    """
    Nodes from 0 to the end, close together next to a kink within 1, beyond which g grows like a root; the tip of a cone is one at 0.

    A third of the nodes beyond the kink, or more, lies within 1, the radius of the first contact.
    """
    inner = cells // 4 if kink > 0.0 else 0
    power = max(_ABOUT, math.log((end - kink) / (1.0 - kink)) / math.log(3.0))
    below = kink * (1.0 - np.linspace(1.0, 0.0, inner + 1) ** _ABOUT)
    above = kink + (end - kink) * np.linspace(0.0, 1.0, cells - inner + 1) ** power
    return np.concatenate([below[:-1], above])


def inner_integral(r: FloatArray, stick: float, gap: Curve, kinks: tuple[float, ...]) -> FloatArray:
    """
    The integral (2/pi) int_0^c g / sqrt(r^2 - x^2) dx at radii r >= c.

    Examples
    --------
    >>> import numpy as np
    >>> inside = inner_integral(np.array([0.4]), 0.3, lambda x: x**2, ())
    >>> exact = (0.08 * np.arcsin(0.75) - 0.15 * np.sqrt(0.07)) * 2.0 / np.pi
    >>> bool(abs(inside[0] - exact) < 1e-15)
    True
    """
    t, weight = gauss(_NODES)
    marks = np.array([0.0, *(k for k in kinks if 0.0 < k < stick), stick])
    angle = np.arcsin(np.minimum(marks / r[:, None], 1.0))
    width = np.diff(angle, axis=1)
    at = angle[:, :-1, None] + width[..., None] * t
    values = gap(np.minimum(r[:, None, None] * np.sin(at), stick).ravel()).reshape(at.shape)
    return np.asarray(2.0 / math.pi * np.sum(width[..., None] * weight * values, axis=(1, 2)))


def _load(stick: float, gap: Curve, kinks: tuple[float, ...]) -> float:
    """The integral int_0^c g dx."""
    t, weight = gauss(_NODES)
    marks = np.array([0.0, *(k for k in kinks if 0.0 < k < stick), stick])
    width = np.diff(marks)[:, None]
    values = gap((marks[:-1, None] + width * t).ravel()).reshape(width.size, -1)
    return float(np.sum(width * weight * values))
