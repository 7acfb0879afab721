"""Values that can be dragged, with their ranges."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.explore.model.choice import Choice, Place, number, quantities, short_text, value_at, with_entry
from pymdr.problem.paths import CHANNELS
from pymdr.quantities import QUANTITIES
from pymdr.units import to_si

_DECADES = 1.0
"""How far a value can be dragged to either side."""

_LIMITS = {
    "poisson": (0.0, 0.5),
    "coefficient": (0.0, 1.5),
    "exponent": (0.05, 6.0),
    "humidity": (0.05, 0.99),
    "half_angle": (math.radians(10.0), math.radians(89.0)),
    "contact_angle": (0.0, math.radians(85.0)),
}
"""Ranges of values that are not scales, by key."""

_EXPONENTS = {"graded": (-0.9, 0.9), "power_law_rheology": (0.02, 0.95)}
"""Exponents of other kinds than profiles."""

_WORDS = {
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "work": "work of adhesion",
    "material": "",
    "layers": "layer",
}
"""Words of keys."""


@dataclass(frozen=True)
class Knob:
    """A value that can be dragged, with its range."""

    place: Place
    unit: str
    """SI unit."""
    low: float
    high: float
    logarithmic: bool

    @property
    def label(self) -> str:
        """What it is, and of what."""
        words = [
            str(part + 1 if isinstance(part, int) else _WORDS.get(part, part)) for part in self.place[1:]
        ]
        return " ".join(
            word for word in [*(["leg"] if self.place[0] == "path" else []), *words] if word
        ).replace("_", " ")


def knobs(choice: Choice) -> tuple[Knob, ...]:
    """
    The values of a choice that can be dragged, each a decade to either side of where it is, or within its limits.

    Examples
    --------
    >>> from pymdr.explore.model import start
    >>> [knob.label for knob in knobs(start("ball"))][:4]
    ['radius', "Young's modulus", "Poisson's ratio", "Young's modulus"]
    """
    knobs_of_choice = []
    for place, kind, unit in quantities(choice):
        value = number(choice, place)
        key = str(place[-1])
        limits = _EXPONENTS.get(kind) if key == "exponent" and kind in _EXPONENTS else _LIMITS.get(key)
        if limits is not None:
            low, high, logarithmic = min(limits[0], value), max(limits[1], value), False
        elif value > 0.0 and unit:
            low, high, logarithmic = value * 10.0**-_DECADES, value * 10.0**_DECADES, True
        else:
            size = 2.0 * abs(value) or _largest_target(choice, key)
            low, high, logarithmic = -size, size, False
        if math.isfinite(low) and math.isfinite(high) and low < high:
            knobs_of_choice.append(Knob(place, unit, low, high, logarithmic))
    return tuple(knobs_of_choice)


def _largest_target(choice: Choice, channel: str) -> float:
    """The largest target of a channel over all legs, in SI units."""
    targets = (
        leg[channel] for leg in choice.tables["path"] if isinstance(leg.get(channel), str | int | float)
    )
    return (
        max((abs(to_si(t, QUANTITIES[channel].unit)) for t in targets), default=0.0)
        if channel in CHANNELS
        else 0.0
    )


def text(choice: Choice, knob: Knob) -> str:
    """The quantity of a knob as it is shown: the text of the case, or the number with its unit."""
    value = value_at(knob.place, choice)
    return value if isinstance(value, str) else short_text(float(value), knob.unit, digits=6)


def fraction(choice: Choice, knob: Knob) -> float:
    """Where a knob stands in its range, from 0 to 1."""
    value = min(max(number(choice, knob.place), knob.low), knob.high)
    if knob.logarithmic:
        return math.log(value / knob.low) / math.log(knob.high / knob.low)
    return (value - knob.low) / (knob.high - knob.low)


def dragged(choice: Choice, knob: Knob, to: float) -> Choice:
    """
    The choice with a knob dragged to a fraction of its range.

    Examples
    --------
    >>> from pymdr.explore.model import start
    >>> ball = start("ball")
    >>> text(dragged(ball, knobs(ball)[0], 1.0), knobs(ball)[0])
    '100 mm'
    """
    to = min(max(to, 0.0), 1.0)
    if knob.logarithmic:
        value = knob.low * (knob.high / knob.low) ** to
    else:
        value = knob.low + to * (knob.high - knob.low)
        value = 0.0 if abs(value) < 1e-9 * max(abs(knob.low), abs(knob.high)) else value
    return with_entry(choice, knob.place, short_text(value, knob.unit))


def typed(choice: Choice, knob: Knob, entry: str) -> Choice:
    """The choice with a text as the value of a knob; nothing in it is evaluated."""
    to_si(entry, knob.unit, name=str(knob.place[-1]))
    return with_entry(choice, knob.place, entry.strip())
