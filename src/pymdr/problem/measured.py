"""Measured force curves: columns, and the steps of their preparation."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.facts import Facts
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, Value, within_range
from pymdr.units import FloatArray

_LEAST = 8
SEGMENTS = ("approach", "hold", "retreat", "")
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Step:
    """
    One step of the preparation of a curve.

    Parameters
    ----------
    name : str
        Such as ``"baseline"``.
    description : str
        Its description, with numbers and units.
    numbers : Facts
        Its numbers in SI units.
    """

    name: str
    description: str
    numbers: Facts = field(default_factory=Facts)

    def __str__(self) -> str:
        return f"{self.name}: {self.description}"


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredSamples(Value):
    """The columns of a force curve and the steps of their preparation, which :class:`pymdr.MeasuredCurve` offers."""

    force: ArrayField = ArrayField("N", description="normal force, compression positive")
    indentation: OptionalArrayField = OptionalArrayField("m", description="indentation, from any origin")
    travel: OptionalArrayField = OptionalArrayField("m", description="travel of the machine, from any origin")
    time: OptionalArrayField = OptionalArrayField("s", description="time")
    spring_constant: OptionalSIField = OptionalSIField(
        "N/m", description="spring constant of the machine", above=0.0
    )
    segment: str = ""
    metadata: Facts = field(default_factory=Facts, repr=False)
    outliers: BoolArray | None = field(default=None, repr=False)
    saturated: BoolArray | None = field(default=None, repr=False)
    step: Step | None = field(default=None, repr=False)
    before: Self | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if (self.indentation is None) == (self.travel is None):
            given = "none" if self.travel is None else "both"
            raise ProblemError(f"give exactly one of indentation and travel ({given} given)")
        if self.travel is not None and self.spring_constant is None:
            raise ProblemError(
                "travel = indentation + force / spring_constant needs the spring_constant, such as '0.1 N/m'"
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
                raise ProblemError(
                    f"{n} forces, but {column.size} entries of {name}; give one for each force"
                )
        if n < _LEAST:
            raise ProblemError(f"{n} sample{'s' * (n != 1)}; at least {_LEAST} are needed")
        for column, unit, name in ((self.force, "N", "force"), (self.position, "m", "position")):
            within_range(float(np.max(np.abs(column))), unit, f"the largest {name}", limited=True)
            if (spread := float(np.ptp(column))) > 0.0:
                within_range(spread, unit, f"the range of the {name}", size=True)
        if self.time is not None and not np.all(np.diff(self.time) > 0.0):
            i = int(np.argmin(np.diff(self.time)))
            raise ProblemError(
                f"time[{i + 1}] = {self.time[i + 1]:g} s is not above {self.time[i]:g} s: times must rise; sort the samples and average those of equal time"
            )
        if self.segment not in SEGMENTS:
            raise ProblemError(
                f"segment = {self.segment!r}: it must be {', '.join(SEGMENTS[:3])}, or empty for a complete record"
            )

    @property
    def depth(self) -> FloatArray:
        """Indentation in m from the origin of the record; forces must have no offset."""
        return np.asarray(self.position - self.compliance * self.force)

    @property
    def position(self) -> FloatArray:
        """The measured position in m: travel or indentation."""
        position = self.travel if self.indentation is None else self.indentation
        assert position is not None
        return position

    @property
    def compliance(self) -> float:
        """Compliance of the machine in m/N; 0 if the indentation was measured."""
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
        """All steps of the preparation in order."""
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
            If the curve has no step.
        """
        if self.before is None:
            raise ProblemError("this curve has no preparation step to undo")
        return self.before

    def _repr_html_(self) -> str:
        """The record and the steps of its preparation, for notebooks."""
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
