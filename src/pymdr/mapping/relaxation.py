"""How the modulus of the line relaxes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.units import FloatArray


@dataclass(frozen=True, eq=False)
class Relaxation:
    """
    The effective modulus after a step, E*(t) = equilibrium + sum moduli exp(-t / times) + viscosity delta(t).

    Parameters
    ----------
    equilibrium : float
        E* that stays, in Pa, at least 0.
    moduli : array_like, shape (n,)
        Strengths of the terms in Pa, at least 0; those that are 0 are left out.
    times : array_like, shape (n,)
        Relaxation times in s, above 0.
    viscosity : float
        A dashpot beside them in Pa s, at least 0: a body of Kelvin and Voigt has the equilibrium and this.

    Raises
    ------
    ProblemError
        If a value is outside its limits, or nothing of the body resists.

    Notes
    -----
    E* = 4 G(t) for one incompressible body under a rigid one (Lee and Radok, 1960).

    Examples
    --------
    >>> body = Relaxation(1.0, np.array([3.0]), np.array([0.5]))
    >>> body.glassy, round(float(body.at(0.5)), 6)
    (4.0, 2.103638)
    """

    equilibrium: float
    moduli: FloatArray
    times: FloatArray
    viscosity: float = 0.0

    def __post_init__(self) -> None:
        moduli, times = (np.array(v, dtype=float).reshape(-1) for v in (self.moduli, self.times))
        if moduli.size != times.size:
            raise ProblemError(f"{moduli.size} moduli and {times.size} times: every term needs both")
        for name, value in (("equilibrium", self.equilibrium), ("viscosity", self.viscosity)):
            if not (0.0 <= value < math.inf):
                raise ProblemError(f"{name} = {value:g}: it has to be finite and at least 0")
        for wrong in moduli[~((moduli >= 0.0) & (moduli < math.inf))]:
            raise ProblemError(f"moduli hold {wrong:g}: they have to be finite and at least 0")
        for wrong in times[~((times > 0.0) & (times < math.inf))]:
            raise ProblemError(
                f"times hold {wrong:g} s: they have to be finite and above 0; a term that does not relax "
                "belongs to the equilibrium"
            )
        kept = moduli > 0.0
        moduli, times = moduli[kept], times[kept]
        if self.equilibrium == 0.0 and self.viscosity == 0.0 and moduli.size == 0:
            raise ProblemError("the modulus is 0 at all times: give an equilibrium, a term or a viscosity")
        for values in (moduli, times):
            values.flags.writeable = False
        object.__setattr__(self, "moduli", moduli)
        object.__setattr__(self, "times", times)

    @property
    def glassy(self) -> float:
        """E*(0+) in Pa, which answers a sudden indentation; the viscosity is not in it."""
        return self.equilibrium + float(self.moduli.sum())

    @property
    def rubbery(self) -> float:
        """E*(inf) in Pa."""
        return self.equilibrium

    def at(self, time: ArrayLike) -> FloatArray:
        """E*(t) in Pa at times in s above 0."""
        t = np.asarray(time, dtype=float)
        return np.asarray(self.equilibrium + np.exp(-t[..., None] / self.times) @ self.moduli)
