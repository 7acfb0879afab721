"""Measured force curves: what was recorded while a contact was pressed and left."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.facts import Facts
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, Value
from pymdr.units import FloatArray

_LEAST = 8
SEGMENTS = ("approach", "hold", "retreat", "")
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Step:
    """
    What was done to a curve.

    Parameters
    ----------
    name : str
        Such as ``"baseline"``.
    words : str
        A sentence that says it, with its numbers and units.
    numbers : Facts
        The numbers in SI units.
    """

    name: str
    words: str
    numbers: Facts = field(default_factory=Facts)

    def __str__(self) -> str:
        return f"{self.name}: {self.words}"


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredSamples(Value):
    """The columns of a force curve, and what was done to them; :class:`pymdr.MeasuredCurve` has the steps that can be."""

    force: ArrayField = ArrayField("N", words="normal force, compression positive")
    indentation: OptionalArrayField = OptionalArrayField("m", words="indentation, from any origin")
    travel: OptionalArrayField = OptionalArrayField("m", words="travel of the machine, from any origin")
    time: OptionalArrayField = OptionalArrayField("s", words="time")
    spring_constant: OptionalSIField = OptionalSIField(
        "N/m", words="spring constant of the machine", above=0.0
    )
    segment: str = ""
    metadata: Facts = field(default_factory=Facts, repr=False)
    outliers: BoolArray | None = field(default=None, repr=False)
    saturated: BoolArray | None = field(default=None, repr=False)
    step: Step | None = field(default=None, repr=False)
    before: Self | None = field(default=None, repr=False)

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
        for name in ("outliers", "saturated"):
            if (given := getattr(self, name)) is not None:
                marks = np.array(given, dtype=bool)
                marks.flags.writeable = False
                object.__setattr__(self, name, marks)
        for name in ("indentation", "travel", "time", "outliers", "saturated"):
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
        if self.segment not in SEGMENTS:
            raise ProblemError(
                f"MeasuredCurve.segment = {self.segment!r}: it is one of {', '.join(SEGMENTS[:3])}, or empty for a whole record"
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

    @property
    def marked(self) -> BoolArray:
        """Samples that are marked as outliers or saturated."""
        marked = np.zeros(self.force.size, dtype=bool)
        for marks in (self.outliers, self.saturated):
            if marks is not None:
                marked |= marks
        return marked

    @property
    def steps(self) -> tuple[Step, ...]:
        """All that was done to the record, the first step first."""
        earlier = () if self.before is None else self.before.steps
        return earlier if self.step is None else (*earlier, self.step)

    @property
    def original(self) -> Self:
        """The curve as it was read."""
        return self if self.before is None else self.before.original

    def undo(self) -> Self:
        """
        The curve before its last step.

        Raises
        ------
        ProblemError
            If nothing was done to it since it was read.
        """
        if self.before is None:
            raise ProblemError("undo: nothing was done to this curve since it was read")
        return self.before

    def _repr_html_(self) -> str:
        """The record and what was done to it, for notebooks."""
        plain = type(self)(
            force=self.force,
            indentation=self.indentation,
            travel=self.travel,
            time=self.time,
            spring_constant=self.spring_constant,
        )
        steps = "".join(f"<li>{escape(str(step))}</li>" for step in self.steps)
        return super(MeasuredSamples, plain)._repr_html_() + (f"<ol>{steps}</ol>" if steps else "")


Samples = TypeVar("Samples", bound=MeasuredSamples)
