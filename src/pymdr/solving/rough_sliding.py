"""Sliding of a rough line over an elastomer."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.sliding import rough_sliding_claims
from pymdr.interpretation.validity import Assumption
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.mapping.rough import modes_of, rough_waves
from pymdr.problem.fractional import PowerLawRheology
from pymdr.problem.materials import Material, Viscoelastic
from pymdr.problem.rough import RoughSurface
from pymdr.solving.arguments import positive_load, positive_speeds
from pymdr.solving.rough_lines import RoughLine, line_coefficient
from pymdr.solving.sliding import SlidingFriction
from pymdr.solving.study import over_rows
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, metres, shown

_PER_WAVE = 64
"""Points per shortest wave."""
_STEEP = 0.3
_MOST_WAVES = 4096
"""Largest number of waves of a line; every speed passes about ten times over 64 places per shortest wave."""


def rough_sliding_friction(
    surface: RoughSurface,
    body: Material,
    speed: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
    coefficient: float | None = None,
    realisation: int = 0,
) -> SlidingFriction:
    """
    Coefficient of friction of a rigid rough surface in steady sliding over an elastomer, by its line of independent springs.

    The line has the spectrum C1D = lambda q C2D, is periodic with the longer side of the surface and as stiff as the patch in full contact,
    L1 = k_c/E*. A spring in contact follows it, w = d + z(v t); a free one recovers. F_N = L1 <q> and
    F_x = L1 <q z'> are means over a passage.

    Parameters
    ----------
    surface : RoughSurface
        With at most 4096 shortest wavelengths along its longer side.
    body : Viscoelastic
        With an equilibrium modulus.
    speed : array_like or quantity
        Speeds v in m/s, above 0, one row.
    normal_force, indentation : quantity
        The constant load on the patch in N, or the depth of the mean of the line below the surface in m, which may be
        below 0; exactly one.
    coefficient : float, optional
        lambda; by default pi (Geike). It scales the heights of the line by sqrt(lambda/pi).
    realisation : int, optional
        Number of the line in the ensemble, from 0 on.

    Returns
    -------
    SlidingFriction
        Without edges and limits.

    Raises
    ------
    ProblemError
        If the surface is not a RoughSurface or has too many waves, the body is not Viscoelastic or relaxes completely, a speed is not
        above 0, both or none of the loads are given, or no spring is in contact.

    See Also
    --------
    sliding_friction : a smooth slider.
    press_rough : the same line without sliding.

    Notes
    -----
    Popov and Hess (2015), chapters 10 and 11. The result is for one line of random phases: average over several realisations.

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "9 MPa", "1 ms"), poisson=0.5)
    >>> road = mdr.RoughSurface(hurst=0.8, rms="5 um", size="1 mm", shortest="20 um")
    >>> slid = mdr.rough_sliding_friction(road, rubber, ["1 mm/s", "0.1 m/s"], normal_force="10 mN")
    >>> slid["friction_coefficient"].values.round(3).tolist()
    [0.013, 0.014]
    """
    relaxation = _relaxation(surface, body)
    factor = line_coefficient(coefficient)
    load_or_depth = positive_load(normal_force, indentation, deep=-np.inf)
    v = positive_speeds(speed)
    n = _PER_WAVE * modes_of(surface)
    lines = [RoughLine(surface, relaxation.equilibrium, factor, points, None) for points in (n, n // 2)]
    fine, coarse = (_states(line, realisation, relaxation, v, *load_or_depth) for line in lines)
    if not np.all(fine[:, 0] > 0.0):
        raise ProblemError(f"at the indentation {shown(indentation)} no spring is in contact; increase it")
    load, drag, where = fine.T
    columns = {
        "friction_coefficient": drag / load,
        "friction_force": drag,
        "normal_force": load,
        "indentation": where,
    }
    errors = np.max(np.abs(coarse[:, :2] / fine[:, :2] - 1.0), axis=1)
    prescribed = "indentation" if normal_force is None else "normal_force"
    claims = rough_sliding_claims(prescribed, np.ones(v.shape, dtype=bool), errors)
    q, amplitude = rough_waves(surface, factor)
    slope = math.sqrt(0.5 * float(np.sum((amplitude * q) ** 2)))
    return SlidingFriction(
        data=over_rows("speed", v, columns, SlidingFriction.columns).assign_attrs(
            numerical_error=tuple(errors.tolist())
        ),
        claims=claims,
        assumptions=(Assumption("small slope", "root mean square of the slope of the line", slope, _STEEP),),
        notes=(),
    )


def _relaxation(surface: RoughSurface, body: Material) -> Relaxation:
    if not isinstance(surface, RoughSurface):
        raise ProblemError(
            f"{surface!r} is not a RoughSurface; use sliding_friction for profiles of revolution"
        )
    if modes_of(surface) > _MOST_WAVES:
        raise ProblemError(
            f"the longer side, {metres(surface.longer_side)}, has {modes_of(surface)} of the shortest waves (limit "
            f"{_MOST_WAVES}); use a smaller patch, or longer waves"
        )
    if not isinstance(body, Viscoelastic):
        raise ProblemError(
            f"{body!r} is not viscoelastic, and elastic bodies dissipate nothing below a moving line; give a viscoelastic body"
        )
    relaxation = None if isinstance(body.shear, PowerLawRheology) else relaxation_of(body)
    if relaxation is None or relaxation.rubbery == 0.0:
        raise ProblemError(
            "the body relaxes completely, so a rough line sinks in without limit; use a rheology with an "
            "equilibrium modulus"
        )
    return relaxation


def _states(
    line: RoughLine,
    realisation: int,
    relaxation: Relaxation,
    speeds: FloatArray,
    force: float | None,
    depth: float | None,
) -> FloatArray:
    """F_N and F_x in N and the depth in m, a row for every speed."""
    from scipy.optimize import brentq

    from pymdr.line.rough_sliding import stationary

    # slopes and times are those of the patch, forces those of the line's length
    period, length = line.surface.longer_side, line.length
    heights = line.heights(realisation)
    highest = float(heights.max())

    def one(speed: float) -> tuple[float, float, float]:
        deep = depth
        if deep is None:
            assert force is not None
            pressure = force / length
            # the mean of q is E*_inf times that of w, which is at least the depth
            most = highest + pressure / relaxation.rubbery

            def missed(into: float) -> float:
                return (
                    stationary(heights, period, into - highest, relaxation, speed).pressure / pressure - 1.0
                )

            into = float(brentq(missed, 0.0, most * (1.0 + 1e-9), xtol=1e-14 * most, rtol=1e-13))
            deep = into - highest
        state = stationary(heights, period, deep, relaxation, speed)
        return state.pressure * length, state.drag * length, deep

    return np.array([one(float(speed)) for speed in speeds])
