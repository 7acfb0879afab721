"""Effective moduli of a pair of bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.errors import ProblemError
from pymdr.problem.materials import Elastic, Material, Rigid


@dataclass(frozen=True)
class EffectiveModuli:
    """Moduli of the springs on the line, and how similar the two bodies are."""

    normal: float
    """E* in Pa: normal stiffness of the line per length."""
    tangential: float
    """G* in Pa: tangential stiffness of the line per length."""
    dundurs_beta: float
    """Dundurs' beta; 0 for elastically similar bodies."""

    @property
    def similar(self) -> bool:
        """Whether the bodies are elastically similar (beta = 0 to rounding)."""
        return abs(self.dundurs_beta) < 1e-12


def effective_moduli(body: Material, counterbody: Material | None = None) -> EffectiveModuli:
    """
    Effective moduli E*, G* and Dundurs' beta of two bodies.

    1/E* = sum (1 - nu_i^2)/E_i,  1/G* = sum (2 - nu_i)/(4 G_i),
    beta = [(1 - 2 nu_1)/G_1 - (1 - 2 nu_2)/G_2] / (2 [(1 - nu_1)/G_1 + (1 - nu_2)/G_2]).

    Parameters
    ----------
    body, counterbody : Elastic or Rigid
        The two bodies; the second is rigid unless given.

    Returns
    -------
    EffectiveModuli
        E* and G* in Pa, beta without unit.

    Raises
    ------
    ProblemError
        If both bodies are rigid.

    Notes
    -----
    Johnson (1985), Contact Mechanics, eqs. 4.6 and 5.3; Popov and Hess (2015), chapters 2 and 5. The
    constant called Dundurs' in Argatov's discussion of the method lacks the factor 1/2 and has
    (1 - 2 nu) for (1 - nu) in its denominator; both vanish together.

    Examples
    --------
    >>> round(effective_moduli(Elastic("210 GPa", 0.3), Elastic("70 GPa", 0.33)).dundurs_beta, 9)
    -0.11673597
    """
    bodies = (body, Rigid() if counterbody is None else counterbody)
    normal = tangential = compliance = 0.0
    mismatch = [0.0, 0.0]
    for i, material in enumerate(bodies):
        if isinstance(material, Elastic):
            nu, shear = material.poisson, material.shear
            normal += (1.0 - nu) / (2.0 * shear)
            tangential += (2.0 - nu) / (4.0 * shear)
            mismatch[i] = (1.0 - 2.0 * nu) / shear
            compliance += (1.0 - nu) / shear
    if compliance == 0.0:
        raise ProblemError("effective_moduli: both bodies are rigid; at least one must be Elastic")
    beta = 0.5 * (mismatch[0] - mismatch[1]) / compliance
    moduli = EffectiveModuli(1.0 / normal, 1.0 / tangential, beta)
    if not all(map(math.isfinite, (moduli.normal, moduli.tangential, beta))):
        raise ProblemError(f"effective_moduli: {body!r} and {counterbody!r} overflow; use moduli in Pa")
    return moduli
