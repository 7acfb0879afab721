"""The elastic line as the friction kernels read it: a(d), F_N(d) and W(d) in closed form or as a table."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.line.friction.layout import MODULUS, WORK_FACTOR
from pymdr.mapping.equivalent import PolygonLine, PowerLine
from pymdr.numerics.graded import graded_table
from pymdr.numerics.graded.layout import COLUMNS, MAX
from pymdr.units import FloatArray, metres


class ElasticCurves(NamedTuple):
    """
    Contact radius a(d), normal force F_N(d) and W(d) = int_0^d F_N of an elastic line, for depths d >= 0.

    Made by :func:`power_law_curves` or :func:`tabulated_curves`.
    """

    modulus: float
    """E* in Pa."""
    exponent: float
    """n of a = unit (d / coefficient)^(1/n); 0 for a table."""
    coefficient: float
    """kappa c of g = coefficient (x / unit)^n, in m if `unit` is a length in m."""
    unit: float
    """Length in m, or 1."""
    depth: float
    """Largest depth in m that the curves reach; infinite for a power law."""
    rows: FloatArray
    """What the kernels read, see :mod:`pymdr.line.friction.layout`; one row for a power law."""
    misfit: float = 0.0
    """Largest error of a that was found between the nodes of a table, relative to a."""


def power_law_curves(
    exponent: float, coefficient: float, modulus: float, *, unit: float = 1.0
) -> ElasticCurves:
    """
    Curves of a power-law equivalent profile g(x) = coefficient (x / unit)^n.

    a = unit (d / coefficient)^(1/n), F_N = 2 n / (n + 1) E* a d, W = n / (2 n + 1) F_N d.

    Parameters
    ----------
    exponent : float
        n > 0; 2 for a paraboloid, 1 for a cone.
    coefficient : float
        kappa(n) c > 0 in m^(1-n); 1/R for a paraboloid.
    modulus : float
        E* > 0 in Pa.
    unit : float, optional
        Length in m in which x is counted: m^(1-n) of a small tip and a large n leaves the range of floats.

    Raises
    ------
    ProblemError
        If a value is not finite and above 0.

    Notes
    -----
    Popov and Hess (2015), chapter 3.

    Examples
    --------
    >>> power_law_curves(2.0, 1.0, 1.0).depth
    inf
    """
    for name, value in {
        "exponent": exponent,
        "coefficient": coefficient,
        "modulus": modulus,
        "unit": unit,
    }.items():
        if not 0.0 < value < math.inf:
            raise ProblemError(f"{name} = {value!r} must be finite and above 0")
    rows = np.zeros((1, COLUMNS))
    rows[0, MAX] = math.inf
    rows[0, MODULUS : WORK_FACTOR + 1] = (
        modulus,
        exponent,
        1.0 / exponent,
        1.0 / coefficient,
        unit,
        2.0 * modulus * exponent / (exponent + 1.0),
        exponent / (2.0 * exponent + 1.0),
    )
    return ElasticCurves(float(modulus), float(exponent), float(coefficient), float(unit), math.inf, rows)


def tabulated_curves(
    contact_radius: Callable[[FloatArray], FloatArray],
    depth: float,
    modulus: float,
    *,
    marks: ArrayLike = (),
    tolerance: float = 1e-13,
) -> ElasticCurves:
    """
    Curves of any elastic line, from its contact radius alone, with errors relative to their size at every depth.

    F_N = 2 E* int_0^d a and W = int_0^d F_N are integrated exactly over polynomial segments of a. Toward d = 0 and
    toward each mark from below the surface the segments shrink in proportion to the distance, down to 1e-51 of
    `depth` or until a(d) is b + c (d - d_j)^q to rounding, by which it is closed. Pieces are cut until a is met
    between the nodes, or until cutting gains nothing: a(d) has noise.

    Parameters
    ----------
    contact_radius : callable
        a(d) > 0 in m for an array of depths 0 < d <= `depth`, right relative to its size; not decreasing.
        a(0+) > 0 is a flat tip.
    depth : float
        Largest depth in m that a history reaches.
    modulus : float
        E* in Pa.
    marks : array_like, optional
        Depths d_j in m, in any order, at which a(d) is not smooth: to the right of d_j it may behave like
        b + c (d - d_j)^q, or step up. Without its mark a kink is found too, by more segments; slope without bound is
        not resolved.
    tolerance : float, optional
        Largest error of a relative to a.

    Raises
    ------
    ProblemError
        If `depth` or `modulus` is not finite and above 0, if a mark is not finite, or if a(d) is not finite, not
        above 0 or falls.
    ConvergenceError
        If more than 200 000 segments are needed: a(d) is rougher than `tolerance`.

    Examples
    --------
    >>> curves = tabulated_curves(lambda d: np.sqrt(d) + d, depth=1.0, modulus=1.0)
    >>> curves.depth, curves.misfit < 1e-13
    (1.0, True)
    """
    for name, value in (("depth", depth), ("modulus", modulus)):
        if not 0.0 < value < math.inf:
            raise ProblemError(f"{name} = {value!r} must be finite and above 0")
    if not np.isfinite(marks).all():
        raise ProblemError(f"marks = {marks!r} must be finite depths")
    table = graded_table(
        contact_radius,
        depth,
        marks=marks,
        tolerance=tolerance,
        factor=2.0 * modulus,
        describe=lambda d, a: f"a({metres(d)}) = {metres(a)}",
    )
    table.rows[0, MODULUS] = modulus
    return ElasticCurves(float(modulus), 0.0, 1.0, 1.0, float(depth), table.rows, table.error)


def curves_of(line: ElasticLine, depth: float, *, marks: ArrayLike = ()) -> ElasticCurves:
    """
    Curves of an elastic line, in closed form where it is a power law.

    Parameters
    ----------
    line : ElasticLine
        Its contact must be a disk at every depth.
    depth : float
        Largest depth in m that a history reaches.
    marks : array_like, optional
        Depths in m at which a(d) is not smooth, as in :func:`tabulated_curves`.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> curves_of(ElasticLine(equivalent_profile(Paraboloid(2.0)), 1.0), 1.0).exponent
    2.0
    """
    equivalent = line.equivalent
    if isinstance(equivalent, PowerLine):
        return power_law_curves(equivalent.n, equivalent.scale, line.modulus, unit=equivalent.unit)
    if isinstance(equivalent, PolygonLine):
        marks = np.append(marks, equivalent.depth[equivalent.depth < depth])
    return tabulated_curves(
        lambda d: states_at_depth(line, d).contact_radius, depth, line.modulus, marks=marks
    )
