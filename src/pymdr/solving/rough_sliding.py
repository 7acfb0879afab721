"""Sliding of a rough line over an elastomer."""

from __future__ import annotations

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.sliding import rough_sliding_claims
from pymdr.interpretation.validity import Assumption
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.mapping.self_affine import line_heights
from pymdr.problem.materials import Material, Viscoelastic
from pymdr.problem.rheology import PowerLawRheology
from pymdr.problem.self_affine import SelfAffineLine
from pymdr.solving.sliding import SlidingFriction, labelled_over_speed, positive_load, positive_speeds
from pymdr.units import ArrayQuantityLike, QuantityLike, shown

_WHO = "rough_sliding_friction"
_PER_WAVE = 64
"""Places per shortest wave."""
_STEEP = 0.3


def rough_sliding_friction(
    rough: SelfAffineLine,
    body: Material,
    speed: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> SlidingFriction:
    """
    Coefficient of friction of a rigid rough line that slides steadily over an elastomer, by independent springs.

    A spring that touches the line follows it, w = d + z(v t); a free one creeps back. F_N = L <q> and F_x = L <q z'> are means
    over the length L, which repeats itself.

    Parameters
    ----------
    rough : SelfAffineLine
    body : Viscoelastic
        With a modulus that is left in the end.
    speed : array_like or quantity
        Speeds v in m/s, above 0, one row.
    normal_force, indentation : quantity
        The constant load on the length in N, or the depth of the mean of the line below the surface in m, which may be
        below 0; exactly one.

    Returns
    -------
    SlidingFriction
        Without edges and limits.

    Raises
    ------
    ProblemError
        If the body is not Viscoelastic or relaxes to nothing, a speed is not above 0, both or none of the loads are given, or
        no spring is touched.

    Notes
    -----
    Popov and Hess (2015), chapters 10 and 11. A number for one line of random phases: take several seeds.

    Examples
    --------
    >>> from pymdr.problem.rheology import StandardSolid
    >>> rubber = Viscoelastic(StandardSolid("1 MPa", "9 MPa", "1 ms"), poisson=0.5)
    >>> road = SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="20 um")
    >>> slid = rough_sliding_friction(road, rubber, ["1 mm/s", "0.1 m/s"], normal_force="10 mN")
    >>> slid["friction_coefficient"].values.round(3).tolist()
    [0.014, 0.016]
    """
    relaxation = _relaxation(rough, body)
    force, depth = positive_load(_WHO, normal_force, indentation, deep=-np.inf)
    v = positive_speeds(_WHO, speed)
    n = _PER_WAVE * int(np.ceil(rough.length / rough.shortest))
    fine, coarse = (
        np.array([_state(rough, relaxation, float(one), force, depth, places) for one in v])
        for places in (n, n // 2)
    )
    if not np.all(fine[:, 0] > 0.0):
        raise ProblemError(
            f"{_WHO}: at the indentation {shown(indentation)} no spring is touched; press the line in deeper"
        )
    load, drag, where = fine.T
    columns = {
        "friction_coefficient": drag / load,
        "friction_force": drag,
        "normal_force": load,
        "indentation": where,
    }
    errors = np.max(np.abs(coarse[:, :2] / fine[:, :2] - 1.0), axis=1)
    claims = rough_sliding_claims(
        "indentation" if force is None else "normal_force", np.ones(v.shape, dtype=bool), errors
    )
    words = "root mean square of the slope of the line"
    return SlidingFriction(
        data=labelled_over_speed(v, columns),
        claims=claims,
        assumptions=(Assumption("small slope", words, rough.rms_slope, _STEEP),),
        notes=(),
    )


def _relaxation(rough: SelfAffineLine, body: Material) -> Relaxation:
    if not isinstance(rough, SelfAffineLine):
        raise ProblemError(
            f"{_WHO}: {rough!r} is not a SelfAffineLine; profiles of revolution are for sliding_friction"
        )
    if not isinstance(body, Viscoelastic):
        raise ProblemError(
            f"{_WHO}: {body!r} is not Viscoelastic: elastic bodies lose nothing below a line that passes"
        )
    relaxation = None if isinstance(body.shear, PowerLawRheology) else relaxation_of(body)
    if relaxation is None or relaxation.rubbery == 0.0:
        raise ProblemError(
            f"{_WHO}: the body relaxes to nothing, and a rough line sinks into it for ever; take a rheology with a modulus that "
            "is left in the end"
        )
    return relaxation


def _state(
    rough: SelfAffineLine,
    relaxation: Relaxation,
    speed: float,
    force: float | None,
    depth: float | None,
    n: int,
) -> tuple[float, float, float]:
    """F_N and F_x in N and the depth in m."""
    from scipy.optimize import brentq

    from pymdr.line.rough_sliding import stationary

    heights = line_heights(rough, n)
    if depth is None:
        assert force is not None
        pressure = force / rough.length
        highest = float(heights.max())
        # the mean of q is E*_inf times that of w, which is no less than the depth
        most = highest + pressure / relaxation.rubbery

        def missed(into: float) -> float:
            return (
                stationary(heights, rough.length, into - highest, relaxation, speed).pressure / pressure - 1.0
            )

        into = float(brentq(missed, 0.0, most * (1.0 + 1e-9), xtol=1e-14 * most, rtol=1e-13))
        depth = into - highest
    found = stationary(heights, rough.length, depth, relaxation, speed)
    return found.pressure * rough.length, found.drag * rough.length, depth
