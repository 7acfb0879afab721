"""The elastic line as the friction kernels read it: a(d), F_N(d) and W(d) in closed form or as a table.

A table holds cubic pieces of a over s = sqrt(d / depth); F_N and W are their exact integrals, so that
dF_N/dd = 2 E* a and dW/dd = F_N hold to rounding and the energies of the stack close. Pieces are halved until
they fit; a piece is found in constant time, by one product and, where the curve bends sharply, some halvings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.mapping.equivalent import PowerLine
from pymdr.units import FloatArray, metres

IntArray: TypeAlias = NDArray[np.int64]

_FEWEST, _MOST = 256, 4096
"""Pieces from which the search starts: so many that few have to be halved, for every halving costs a step time."""
_MOST_PIECES = 200_000
_THINNEST = 1e-14  # of the depth: what a step in a(d) may be off by
_FIT = 0.5 - 0.5 * np.cos(np.pi * (np.arange(4) + 0.5) / 4)
_TEST = np.array([0.0, 0.1464466, 0.5, 0.8535534, 1.0])  # the ends, or a step beside them passes unseen


class ElasticCurves(NamedTuple):
    """
    Contact radius a(d), normal force F_N(d) and W(d) = int_0^d F_N of an elastic line, for depths d >= 0.

    Made by :func:`power_law_curves` or :func:`tabulated_curves`.
    """

    modulus: float
    """E* in Pa."""
    exponent: float
    """n of a = (d / coefficient)^(1/n); 0 for a table."""
    coefficient: float
    """kappa c of g = coefficient x^n, in m^(1-n)."""
    depth: float
    """Largest depth in m that the curves reach; infinite for a power law."""
    starts: int
    """Number of pieces of equal length in sqrt(d) from which the search starts; 0 for a power law."""
    child: IntArray
    """(m,) first half of a halved piece, -1 for a piece that fits; the first `starts` are those of the start."""
    pieces: FloatArray
    """(m, 18) coefficients over a piece: a (4, in m), F_N (6, in N), W (8, in J)."""


def power_law_curves(exponent: float, coefficient: float, modulus: float) -> ElasticCurves:
    """
    Curves of a power-law equivalent profile g(x) = coefficient x^n.

    a = (d / coefficient)^(1/n), F_N = 2 n / (n + 1) E* a d, W = n / (2 n + 1) F_N d.

    Parameters
    ----------
    exponent : float
        n > 0; 2 for a paraboloid, 1 for a cone.
    coefficient : float
        kappa(n) c > 0 in m^(1-n); 1/R for a paraboloid.
    modulus : float
        E* > 0 in Pa.

    Returns
    -------
    ElasticCurves

    Raises
    ------
    ProblemError
        If a value is not finite and above 0.

    Notes
    -----
    Popov and Hess (2015), chapter 3; mdr_math 2.5 and 3.2.

    Examples
    --------
    >>> power_law_curves(2.0, 1.0, 1.0).depth
    inf
    """
    for name, value in (("exponent", exponent), ("coefficient", coefficient), ("modulus", modulus)):
        if not 0.0 < value < math.inf:
            raise ProblemError(f"power_law_curves: {name} = {value!r} must be finite and above 0")
    return ElasticCurves(
        float(modulus),
        float(exponent),
        float(coefficient),
        math.inf,
        0,
        np.zeros(0, dtype=np.int64),
        np.zeros((0, 18)),
    )


def tabulated_curves(
    contact_radius: Callable[[FloatArray], FloatArray],
    depth: float,
    modulus: float,
    *,
    tolerance: float = 1e-12,
) -> ElasticCurves:
    """
    Curves of any elastic line, from its contact radius alone.

    F_N = 2 E* int_0^d a and W = int_0^d F_N are integrated exactly over the pieces of a. The pieces are
    halved until a is met within `tolerance` times a(depth) between the nodes; at a kink or a step of a(d) until
    a piece is thinner than 1e-14 of `depth`.

    Parameters
    ----------
    contact_radius : callable
        a(d) in m for an array of depths 0 < d <= `depth`; not decreasing. a(0+) > 0 is a flat tip.
    depth : float
        Largest depth in m that a history reaches.
    modulus : float
        E* in Pa.
    tolerance : float, optional
        Largest error of a relative to a(depth). The errors of F_N and W, relative to their values at `depth`,
        are smaller still.

    Returns
    -------
    ElasticCurves

    Raises
    ------
    ProblemError
        If `depth` or `modulus` is not finite and above 0, or if a(d) is not finite, negative or falls.
    ConvergenceError
        If more than 200 000 pieces are needed: a(d) is rougher than `tolerance`.

    Examples
    --------
    >>> curves = tabulated_curves(lambda d: np.sqrt(d), depth=1.0, modulus=1.0)
    >>> curves.depth, curves.pieces.shape[1]
    (1.0, 18)
    """
    for name, value in (("depth", depth), ("modulus", modulus)):
        if not 0.0 < value < math.inf:
            raise ProblemError(f"tabulated_curves: {name} = {value!r} must be finite and above 0")
    largest = float(contact_radius(np.array([depth]))[0])
    starts, child, start, width, radius = _halve(contact_radius, depth, tolerance * largest)
    leaves = np.flatnonzero(child < 0)
    leaves = leaves[np.argsort(start[leaves])]
    pieces = np.zeros((child.size, 18))
    pieces[leaves] = _integrate(radius[leaves], start[leaves], width[leaves], depth, modulus)
    return ElasticCurves(float(modulus), 0.0, 1.0, float(depth), starts, child, pieces)


def curves_of(line: ElasticLine, depth: float) -> ElasticCurves:
    """
    Curves of an elastic line, in closed form where it is a power law.

    Parameters
    ----------
    line : ElasticLine
        Its contact must be a disk at every depth.
    depth : float
        Largest depth in m that a history reaches.

    Returns
    -------
    ElasticCurves

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> curves_of(ElasticLine(equivalent_profile(Paraboloid(2.0)), 1.0), 1.0).coefficient
    0.5
    """
    equivalent = line.equivalent
    if isinstance(equivalent, PowerLine):
        return power_law_curves(equivalent.n, equivalent.scale / equivalent.unit**equivalent.n, line.modulus)
    return tabulated_curves(lambda d: states_at_depth(line, d).contact_radius, depth, line.modulus)


def _halve(
    contact_radius: Callable[[FloatArray], FloatArray], depth: float, allowed: float
) -> tuple[int, IntArray, FloatArray, FloatArray, FloatArray]:
    """Pieces of a over s, halved until they fit: number at the start, first half (or -1), start, width, cubic."""
    starts = _FEWEST
    start, width, cubic, misfit = _start_with(contact_radius, depth, allowed, starts)
    while starts < _MOST and np.mean(misfit > allowed) > 1.0 / 16.0:
        starts *= 2
        start, width, cubic, misfit = _start_with(contact_radius, depth, allowed, starts)
    found: list[list[Any]] = [[], [], [], []]
    count = starts
    while True:
        thin = width * (2.0 * start + width) <= _THINNEST
        split = (misfit > allowed) & ~thin
        child = np.full(start.size, -1, dtype=np.int64)
        child[split] = count + 2 * np.arange(np.count_nonzero(split))
        count += 2 * int(np.count_nonzero(split))
        if count > _MOST_PIECES:
            raise ConvergenceError(
                f"tabulated_curves: more than {_MOST_PIECES} pieces; the misfit of a(d) is still "
                f"{metres(misfit.max())} where {metres(allowed)} is allowed: give a smoother a(d) or a larger tolerance"
            )
        for store, values in zip(found, (child, start, width, cubic), strict=True):
            store.append(values)
        if not split.any():
            break
        half = 0.5 * width[split]
        start = np.column_stack([start[split], start[split] + half]).ravel()
        width = np.repeat(half, 2)
        cubic, misfit = _cubics(contact_radius, depth, allowed, start, width)
    childs, begins, widths, cubics = (np.concatenate(values) for values in found)
    return starts, childs, begins, widths, cubics


def _start_with(
    contact_radius: Callable[[FloatArray], FloatArray], depth: float, allowed: float, starts: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    start = np.arange(starts) / starts
    width = np.full(starts, 1.0 / starts)
    return start, width, *_cubics(contact_radius, depth, allowed, start, width)


def _cubics(
    contact_radius: Callable[[FloatArray], FloatArray],
    depth: float,
    allowed: float,
    start: FloatArray,
    width: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Cubic coefficients of a on pieces of s, and by how much they miss a between the nodes."""
    nodes = np.concatenate([_FIT, _TEST])
    order = np.argsort(nodes)
    d = depth * np.maximum(np.square(start[:, None] + width[:, None] * nodes), 1e-30)
    a = np.asarray(contact_radius(d.ravel()), dtype=float).reshape(d.shape)
    _check_radius(a[:, order], d[:, order], allowed)
    cubic = a[:, :4] @ np.linalg.inv(np.vander(_FIT, 4, increasing=True)).T
    return cubic, np.abs(cubic @ np.vander(_TEST, 4, increasing=True).T - a[:, 4:]).max(axis=1)


def _check_radius(a: FloatArray, d: FloatArray, allowed: float) -> None:
    bad = ~np.isfinite(a) | (a < 0.0)
    bad[:, 1:] |= np.diff(a, axis=1) < -allowed
    if bad.any():
        where = tuple(np.argwhere(bad)[0])
        raise ProblemError(
            f"tabulated_curves: a({metres(d[where])}) = {metres(a[where])}; it must be finite, not negative and not "
            "falling with the depth"
        )


def _integrate(
    radius: FloatArray, start: FloatArray, width: FloatArray, depth: float, modulus: float
) -> FloatArray:
    """Coefficients (m, 18) of a, F_N and W over t in [0, 1], s = start + width t, with dd = 2 depth s ds."""
    jacobian = 2.0 * depth * width[:, None] * np.column_stack([start, width])
    force = _antiderivative(2.0 * modulus * _times_line(radius, jacobian))
    work = _antiderivative(_times_line(force, jacobian))
    # the force at the start of a piece adds (d - d_start) F_start to W within it
    force[:, 0] = np.concatenate([[0.0], np.cumsum(force.sum(axis=1))[:-1]])
    work[:, 1] += force[:, 0] * jacobian[:, 0]
    work[:, 2] += force[:, 0] * 0.5 * jacobian[:, 1]
    work[:, 0] = np.concatenate([[0.0], np.cumsum(work.sum(axis=1))[:-1]])
    return np.concatenate([radius, force, work], axis=1)


def _times_line(polynomial: FloatArray, line: FloatArray) -> FloatArray:
    product = np.zeros((polynomial.shape[0], polynomial.shape[1] + 1))
    product[:, :-1] += polynomial * line[:, :1]
    product[:, 1:] += polynomial * line[:, 1:]
    return product


def _antiderivative(polynomial: FloatArray) -> FloatArray:
    powers = np.arange(1, polynomial.shape[1] + 1)
    return np.concatenate([np.zeros((polynomial.shape[0], 1)), polynomial / powers], axis=1)


def packed(curves: ElasticCurves) -> FloatArray:
    """The curves as the one array (1 + m, 19) that the kernels take: nine numbers, then child and coefficients.

    A child is given by its row, 0 for none.
    """
    n = curves.exponent
    line = np.zeros((1 + curves.child.size, 19))
    line[0, :9] = (
        curves.modulus,
        n,
        1.0 / n if n > 0.0 else 0.0,
        1.0 / curves.coefficient,
        2.0 * curves.modulus * n / (n + 1.0),
        n / (2.0 * n + 1.0),
        curves.depth,
        1.0 / curves.depth,
        curves.starts,
    )
    line[1:, 0] = curves.child + 1
    line[1:, 1:] = curves.pieces
    return line
