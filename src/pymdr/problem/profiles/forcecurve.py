"""A measured or computed force curve in the place of a profile."""

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
_FALLS_BY = 0.02
"""Of the largest force, what it may always fall by."""


class ErrorField(OptionalArrayField):
    """A field of relative errors, one number for all points or one for each; nan where an error is not known."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only array of one dimension."""
        name = f"{self.owner}.{self.name}"
        if isinstance(values, int | float | list | tuple):
            with suppress(ValueError, TypeError):
                values = np.asarray(values, dtype=float)
        errors = np.atleast_1d(to_si_array(values, "", name=name, missing=True))
        errors.flags.writeable = False
        if errors.ndim != 1:
            raise ProblemError(f"{name} = {shown(values)}: one number is needed, or one row of them")
        if np.any(errors < 0.0):
            raise ProblemError(
                f"{name}: {written(float(np.nanmin(errors)), '')} is below 0; give sizes of errors"
            )
        return errors


@dataclass(frozen=True, eq=False)
class ForceCurve(Profile):
    """
    The force curve F(d) of a contact of any shape, in the place of a profile.

    On elastic half-spaces without adhesion the curve holds all that friction, memory, machines and impacts ask of a
    topography: its stiffness k = dF/dd does not fall, and the line with g(x) = d at x = k/(2 E*) has the same force. What
    is no integral over the contact, above all its area and its pressures, is not in the curve.

    Parameters
    ----------
    indentation : array_like or quantity
        Depths d in m on approach, rising strictly; at least 5. Rows before the contact may be among them.
    force : array_like or quantity
        Normal forces F in N at those depths.
    modulus : quantity
        E* in Pa of the two bodies whose curve it is; ``effective_moduli(body, counterbody).normal``. Forces of other
        bodies follow as E*.
    contact_point : quantity, optional
        Depth in m at which the bodies first touch, from which indentations are counted. Unless given, it is 0 where no
        depth is below 0, and is found otherwise.
    error : float or array_like, optional
        Relative errors of the forces at their depths, of the measurement or the solution that gave them: one number, or one for
        each point, nan where it is not known. All that follows from the curve carries them. Unless given, only the scatter of
        the points is known. The ``force_curve()`` of results gives them.

    Raises
    ------
    ProblemError
        If there are too few points, the lengths differ, the depths do not rise, no force is above 0, the force falls by
        more than its noise, fewer than 5 points are beyond the contact point, or an error is below 0.
    UnitError
        If an entry is not a finite number.

    Notes
    -----
    Popov and Hess (2015), chapter 10, use the line of a force curve for rough surfaces. That k does not fall: the contact
    grows with the depth (Barber 1974).

    Examples
    --------
    >>> d = np.linspace(0, 1e-6, 41)
    >>> curve = ForceCurve(d, 1e4 * d**1.5, modulus="1 GPa")
    >>> curve.contact_point is None
    True
    """

    whole: ClassVar[bool] = True
    no_radius: ClassVar[str] = "a force curve does not know how wide its contacts are"

    indentation: ArrayField = ArrayField("m", words="depths on approach")
    force: ArrayField = ArrayField("N", words="normal force at the depths")
    modulus: SIField = SIField("Pa", words="E* of the bodies whose curve it is", above=0.0)
    contact_point: OptionalSIField = OptionalSIField("m", words="depth of the first touch")
    error: ErrorField = ErrorField("", words="relative errors of the forces; nan where not known")

    def __post_init__(self) -> None:
        d, force = self.indentation, self.force
        if d.size < FEWEST_POINTS:
            raise ProblemError(f"ForceCurve: {d.size} points; at least {FEWEST_POINTS} are needed")
        if force.shape != d.shape:
            raise ProblemError(
                f"ForceCurve: {force.size} forces for {d.size} depths; give one for each depth"
            )
        if self.error is not None:
            if self.error.size not in (1, d.size):
                raise ProblemError(
                    f"ForceCurve: {self.error.size} errors for {d.size} points; give one for each point, or one for all"
                )
            object.__setattr__(self, "error", np.broadcast_to(self.error, d.shape))
        stays = np.flatnonzero(np.diff(d) <= 0.0)
        if stays.size:
            i = int(stays[0]) + 1
            raise ProblemError(
                f"ForceCurve.indentation: point {i + 1}, {metres(d[i])}, is not above the one before it, {metres(d[i - 1])}: "
                "depths must rise strictly; give the approach alone, and each depth once"
            )
        if not np.max(force) > 0.0:
            raise ProblemError(
                f"ForceCurve.force: the largest is {newtons(float(np.max(force)))}; forces that press are above 0 N"
            )
        touch = self.contact_point
        beyond = int(np.count_nonzero(d > (touch if touch is not None else max(float(d[0]), 0.0))))
        if beyond < FEWEST_POINTS - 1:
            raise ProblemError(
                f"ForceCurve: {beyond} points beyond {metres(touch or 0.0)}, where contact begins; at least "
                f"{FEWEST_POINTS - 1} are needed"
            )
        self._refuse_fall()

    def _refuse_fall(self) -> None:
        force = self.force
        drop = np.maximum.accumulate(force) - force
        i = int(np.argmax(drop))
        # the range of as many normal numbers, which one in some hundred curves goes beyond; few points know their noise less well
        noises = 2.0 * math.sqrt(2.0 * math.log(10.0 * force.size)) * (1.0 + 2.0 / math.sqrt(force.size))
        if drop[i] > max(noises * noise_of(self.indentation, force), _FALLS_BY * float(np.max(force))):
            raise ProblemError(
                f"ForceCurve.force falls by {newtons(float(drop[i]))} up to d = {metres(self.indentation[i])}, more than its "
                "noise: without adhesion and plasticity the force rises with the depth; give the approach alone, of an "
                "elastic contact"
            )

    def gap(self, r: ArrayLike) -> NoReturn:
        """Refused: a force curve has no shape."""
        raise ProblemError(
            "a ForceCurve has no gap f(r): many shapes have the same curve; give the shape itself as a profile where it "
            "matters"
        )

    def gap_slope(self, r: ArrayLike) -> NoReturn:
        """Refused: a force curve has no shape."""
        self.gap(r)

    @property
    def largest_force(self) -> float:
        """In N."""
        return float(np.max(self.force))
