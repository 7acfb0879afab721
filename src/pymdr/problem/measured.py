"""Measured force curves: what was recorded while a contact was pressed and left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, Value
from pymdr.units import FloatArray

_LEAST = 8


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredCurve(Value):
    """
    Force against indentation, or against the travel of a machine, in the order in which it was measured.

    Parameters
    ----------
    force : array_like of quantity
        Normal force in N, compression positive, with or without an offset.
    indentation : array_like of quantity, optional
        In m, positive into the body, from any origin; or, in its place,
    travel : array_like of quantity, optional
        of the machine (a piezo, a crosshead) in m, positive toward the body, from any origin: indentation + force /
        spring constant.
    time : array_like of quantity, optional
        In s, rising; bodies with memory need it.
    spring_constant : quantity, optional
        Of the machine (a cantilever, a load frame) in N/m; needed with travel.

    Raises
    ------
    ProblemError
        If both or none of indentation and travel are given, travel without a spring constant, columns of different lengths or
        of fewer than 8 samples, or times that do not rise.
    UnitError
        If a text is not a quantity of the right kind, or a number is not finite.

    Examples
    --------
    >>> curve = MeasuredCurve(force=np.linspace(0, 1e-6, 9), travel=np.linspace(0, 2e-6, 9), spring_constant="1 N/m")
    >>> float(curve.depth[-1])
    1e-06
    """

    force: ArrayField = ArrayField("N", words="normal force, compression positive")
    indentation: OptionalArrayField = OptionalArrayField("m", words="indentation, from any origin")
    travel: OptionalArrayField = OptionalArrayField("m", words="travel of the machine, from any origin")
    time: OptionalArrayField = OptionalArrayField("s", words="time")
    spring_constant: OptionalSIField = OptionalSIField(
        "N/m", words="spring constant of the machine", above=0.0
    )

    def __post_init__(self) -> None:
        if (self.indentation is None) == (self.travel is None):
            which = "none" if self.travel is None else "both"
            raise ProblemError(
                f"MeasuredCurve: indentation or travel is needed, exactly one; {which} of them is given"
            )
        if self.travel is not None and self.spring_constant is None:
            raise ProblemError(
                "MeasuredCurve: travel is indentation + force / spring_constant; give the spring_constant, such as '0.1 N/m'"
            )
        n = self.force.size
        for name in ("indentation", "travel", "time"):
            column = getattr(self, name)
            if column is not None and column.size != n:
                raise ProblemError(f"MeasuredCurve: {n} forces, but {column.size} entries of {name}")
        if n < _LEAST:
            raise ProblemError(f"MeasuredCurve: {n} samples; at least {_LEAST} are needed")
        if self.time is not None and not np.all(np.diff(self.time) > 0.0):
            i = int(np.argmin(np.diff(self.time)))
            raise ProblemError(
                f"MeasuredCurve.time[{i + 1}] = {self.time[i + 1]:g} s does not come after {self.time[i]:g} s: times rise"
            )

    @property
    def depth(self) -> FloatArray:
        """Indentation in m from the origin of the record, of forces without offset."""
        return np.asarray(self.position - self.compliance * self.force)

    @property
    def position(self) -> FloatArray:
        """What was measured in m: the travel, or the indentation itself."""
        position = self.travel if self.indentation is None else self.indentation
        assert position is not None
        return position

    @property
    def compliance(self) -> float:
        """Of the machine in m/N; 0 where the indentation itself was measured."""
        if self.travel is None or self.spring_constant is None:
            return 0.0
        return 1.0 / self.spring_constant
