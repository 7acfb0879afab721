"""Measured or computed force curves as profiles."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.profiles.curves import noise_of
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, SIField
from pymdr.units import ArrayQuantityLike, FloatArray, metres, newtons, shown, to_si_array, written

FEWEST_POINTS = 5
_LARGEST_DROP = 0.02
"""Decrease that is always accepted, relative to the largest force."""


class ErrorField(OptionalArrayField):
    """A field of relative errors, one for all points or one per point; nan where not known."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only array of one dimension."""
        name = self.name
        if isinstance(values, int | float | list | tuple):
            with suppress(ValueError, TypeError):
                values = np.asarray(values, dtype=float)
        errors = np.atleast_1d(to_si_array(values, "", name=name, missing=True))
        errors.flags.writeable = False
        if errors.ndim != 1:
            raise ProblemError(f"{name} = {shown(values)}: give one number, or a one-dimensional array")
        if np.any(errors < 0.0):
            raise ProblemError(
                f"{name}: {written(float(np.nanmin(errors)), '')} is below 0; give magnitudes of errors"
            )
        return errors


@dataclass(frozen=True, eq=False)
class ForceCurve(Profile):
    """
    The force curve F(d) of a contact of any shape, used as a profile.

    On elastic half-spaces without adhesion the curve determines friction, memory, machines and impacts: its stiffness
    k = dF/dd does not decrease, and the line with g(x) = d at x = k/(2 E*) has the same force. It does not determine
    the contact area and the pressures.

    Parameters
    ----------
    indentation : array_like or quantity
        Indentations d in m on approach, strictly rising; at least 5. Rows before contact are allowed.
    force : array_like or quantity
        Normal forces F in N at these indentations.
    modulus : quantity
        E* in Pa of the two bodies of the curve; ``effective_moduli(body, counterbody).normal``. Forces of other
        bodies scale with E*.
    contact_point : quantity, optional
        Depth in m of the first touch, where the indentation is 0. By default 0 if no depth is below 0, and estimated
        otherwise.
    error : float or array_like, optional
        Relative errors of the forces: one number, or one per point, nan where not known. They propagate to all results. By
        default only the scatter of the points is known. The ``force_curve()`` of a result includes them.

    Raises
    ------
    ProblemError
        If there are too few points, the lengths differ, the depths do not rise, no force is above 0, the force decreases by
        more than its noise, fewer than 5 points are beyond the contact point, or an error is below 0.
    UnitError
        If an entry is not a finite number.

    See Also
    --------
    read_force_curve : the same from a file.

    Notes
    -----
    Popov and Hess (2015), chapter 10, use the line of a force curve for rough surfaces. k does not decrease, because the
    contact grows with the depth (Barber 1974).

    References
    ----------
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.
    - Barber (1974), Int. J. Eng. Sci. 12, 813-819.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> d = np.linspace(0, 1e-6, 41)
    >>> curve = mdr.ForceCurve(d, 1e4 * d**1.5, modulus="1 GPa")
    >>> curve.contact_point is None
    True
    """

    whole: ClassVar[bool] = True
    no_radius: ClassVar[str] = "a force curve has no contact radius"

    indentation: ArrayField = ArrayField("m", description="depths on approach")
    force: ArrayField = ArrayField("N", description="normal force at the depths")
    modulus: SIField = SIField("Pa", description="E* of the bodies whose curve it is", above=0.0)
    contact_point: OptionalSIField = OptionalSIField("m", description="depth of the first touch")
    error: ErrorField = ErrorField("", description="relative errors of the forces; nan where not known")

    def __post_init__(self) -> None:
        d, force = self.indentation, self.force
        if d.size < FEWEST_POINTS:
            raise ProblemError(f"{d.size} points; at least {FEWEST_POINTS} are needed")
        if force.shape != d.shape:
            raise ProblemError(f"{force.size} forces for {d.size} depths; give one for each depth")
        if self.error is not None:
            if self.error.size not in (1, d.size):
                raise ProblemError(
                    f"{self.error.size} errors for {d.size} points; give one per point, or one for all"
                )
            object.__setattr__(self, "error", np.broadcast_to(self.error, d.shape))
        not_rising = np.flatnonzero(np.diff(d) <= 0.0)
        if not_rising.size:
            i = int(not_rising[0]) + 1
            raise ProblemError(
                f"indentation: point {i + 1}, {metres(d[i])}, is not above the preceding {metres(d[i - 1])}: "
                "depths must rise strictly; give only the approach, and each depth once"
            )
        if not np.max(force) > 0.0:
            raise ProblemError(
                f"force: the largest is {newtons(float(np.max(force)))}; compressive forces must be above 0 N"
            )
        touch = self.contact_point
        beyond = int(np.count_nonzero(d > (touch if touch is not None else max(float(d[0]), 0.0))))
        if beyond < FEWEST_POINTS - 1:
            raise ProblemError(
                f"{beyond} points beyond the contact point, {metres(touch or 0.0)}; at least "
                f"{FEWEST_POINTS - 1} are needed"
            )
        self._refuse_drop()

    def _refuse_drop(self) -> None:
        force = self.force
        drop = np.maximum.accumulate(force) - force
        i = int(np.argmax(drop))
        # range of normal noise exceeded by one in some hundred curves; few points estimate their noise less well
        noises = 2.0 * math.sqrt(2.0 * math.log(10.0 * force.size)) * (1.0 + 2.0 / math.sqrt(force.size))
        if drop[i] > max(noises * noise_of(self.indentation, force), _LARGEST_DROP * float(np.max(force))):
            raise ProblemError(
                f"force decreases by {newtons(float(drop[i]))} up to d = {metres(self.indentation[i])}, more than its "
                "noise: without adhesion and plasticity the force rises with the depth; give only the approach of an "
                "elastic contact"
            )

    def gap(self, r: ArrayLike) -> NoReturn:
        """Refused: a force curve has no shape."""
        raise ProblemError(
            "a ForceCurve has no gap f(r), because many shapes have the same curve; give the shape as a profile"
        )

    def gap_slope(self, r: ArrayLike) -> NoReturn:
        """Refused: a force curve has no shape."""
        self.gap(r)

    @property
    def largest_force(self) -> float:
        """The largest force in N."""
        return float(np.max(self.force))
