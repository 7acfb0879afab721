"""Relaxation of the springs of a pair of bodies."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.moduli import effective_moduli, surface_compliances
from pymdr.problem.materials import Elastic, Material, Rigid, Viscoelastic, common_exponent
from pymdr.problem.spectra import Relaxation, in_series
from pymdr.units import QuantityLike, to_si

__all__ = ["Relaxation", "largest_coupling", "relaxation_of"]

Span = tuple[float, float]
Quantities = tuple[QuantityLike, QuantityLike]


def relaxation_of(
    body: Material,
    counterbody: Material | None = None,
    *,
    span: Quantities | None = None,
    tangential: bool = False,
) -> Relaxation:
    """
    E*(t) of two bodies, by which the springs of the line relax, or G*(t), by which they relax tangentially.

    A spring of the length dx that is shortened by w(t) bears q(t) dx = dx int E*(t - s) dw(s). The compliances of the
    bodies add as operators. In Carson transforms: E* = 2 G/(1 - nu) of a body with constant nu,
    E* = 4 G (3 K + G)/(3 K + 4 G) = G + 1/(1/(3 G) + 4/(9 K)) of one with constant K; tangentially
    G* = 4 G/(2 - nu) and G* = 8 G (3 K + G)/(9 K + 6 G) = (4/3) G + 1/(3/(4 G) + 1/(2 K)).

    Parameters
    ----------
    body, counterbody : Viscoelastic, Elastic, TransverselyIsotropic, Graded or Rigid
        The two bodies; the second is rigid unless given. Graded ones with the exponent 0.
    span : tuple of quantity, optional
        The shortest and the longest time in s that matter; needed for a PowerLawRheology. Faster relaxation is
        taken as instantaneous; in series with another body this changes E* at a hundred times the shortest time by about 1e-5.
    tangential : bool
        Whether it is G*(t).

    Returns
    -------
    Relaxation
        E*(t) or G*(t) in Pa as a sum of exponentials with moduli above 0, exact to 1e-10 but for a PowerLawRheology, whose
        measured error it holds.

    Raises
    ------
    ProblemError
        If both bodies are rigid, one is graded, or the span is missing or empty.

    See Also
    --------
    Viscoelastic : the body.
    sliding_friction : friction by relaxation.

    Notes
    -----
    Lee and Radok (1960); Popov and Hess (2015), chapters 5 and 7; Johnson (1985), section 7.2. Normal contact without friction needs
    no more than E*(t), whether Poisson's ratio changes in time or not.

    References
    ----------
    - Lee and Radok (1960), J. Appl. Mech. 27, 438-444.
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.
    - Johnson (1985), Contact Mechanics, Cambridge University Press, doi:10.1017/CBO9781139171731.

    Examples
    --------
    >>> import pymdr as mdr
    >>> rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "10 ms"), poisson=0.5)
    >>> kernel = mdr.relaxation_of(rubber)
    >>> kernel.rubbery, kernel.glassy
    (4000000.0, 16000000.0)
    >>> round(mdr.relaxation_of(rubber, tangential=True).rubbery, 6)
    2666666.666667
    """
    counterbody = Rigid() if counterbody is None else counterbody
    if (exponent := common_exponent(body, counterbody)) != 0.0:
        raise ProblemError(
            f"bodies graded with the exponent {exponent:g} are elastic and do not relax; use effective_moduli"
        )
    times = None if span is None else (to_si(span[0], "s", name="span"), to_si(span[1], "s", name="span"))
    return in_series([*_links(body, times, tangential), *_links(counterbody, times, tangential)])


def largest_coupling(body: Material, counterbody: Material, span: Span | None = None) -> float:
    """
    The largest |Dundurs' beta| of two bodies, from the fastest to the slowest move.

    It is that of elastic bodies with the Carson transforms of the moduli, at rates from a thousandth of the slowest to a
    thousand times the fastest rate of relaxation; where a span of times in s is given, as powers of time need, from a tenth of
    that of the longest to ten times that of the shortest.

    Examples
    --------
    >>> from pymdr.problem.rheology import StandardSolid
    >>> solid = StandardSolid("3 MPa", "6 MPa", "10 ms")
    >>> largest_coupling(Viscoelastic(solid, poisson=0.5), Rigid())
    0.0
    """
    if span is not None:
        slowest, fastest = 0.1 / span[1], 10.0 / span[0]
    else:
        shears = [one.shear.kernel() for one in (body, counterbody) if isinstance(one, Viscoelastic)]
        times = np.concatenate([np.append(one.times, _lag(one)) for one in shears])
        times = times[times > 0.0]
        slowest, fastest = 1e-3 / times.max(), 1e3 / times.min()
    rates = np.geomspace(slowest, fastest, 61)
    pairs = ((_at_rate(body, rate, span), _at_rate(counterbody, rate, span)) for rate in rates)
    return max(abs(effective_moduli(*pair).dundurs_beta) for pair in pairs)


def _lag(kernel: Relaxation) -> float:
    """The time in s of a dashpot parallel to a spring."""
    return kernel.viscosity / kernel.equilibrium if kernel.equilibrium > 0.0 else 0.0


def _at_rate(body: Material, rate: float, span: Span | None) -> Material:
    """The elastic body with the Carson transform of the moduli at a rate in 1/s."""
    if not isinstance(body, Viscoelastic):
        return body
    kernel = body.shear.kernel(span)
    x = rate * kernel.times
    shear = float(kernel.equilibrium + kernel.moduli @ (x / (1.0 + x)) + kernel.viscosity * rate)
    nu = body.poisson
    if nu is None:
        assert body.bulk is not None
        ratio = shear / body.bulk
        nu = (3.0 - 2.0 * ratio) / (6.0 + 2.0 * ratio)
    return Elastic(2.0 * shear * (1.0 + nu), nu)


@singledispatch
def _links(body: Material, span: Span | None, tangential: bool) -> list[Relaxation]:
    """Springs and dashpots in series that stand for the surface of one body, in the normal or in the tangential direction."""
    compliances = surface_compliances(body)
    return [Relaxation(1.0 / (compliances.tangential if tangential else compliances.normal))]


@_links.register
def _(body: Rigid, span: Span | None, tangential: bool) -> list[Relaxation]:
    return []


@_links.register
def _(body: Viscoelastic, span: Span | None, tangential: bool) -> list[Relaxation]:
    shear = body.shear.kernel(span)
    if body.bulk is None:
        assert body.poisson is not None
        return [shear.scaled(4.0 / (2.0 - body.poisson) if tangential else 2.0 / (1.0 - body.poisson))]
    if tangential:
        part = shear.scaled(4.0 / 3.0)
        return [part.in_parallel(in_series([part, Relaxation(2.0 * body.bulk)]))]
    # 4 G (3 K + G)/(3 K + 4 G) without a difference: terms of 1/(4 G) + (3/4)/(3 K + G) all but cancel where K is large
    volume = in_series([shear.scaled(3.0), Relaxation(2.25 * body.bulk)])
    return [shear.in_parallel(volume)]
