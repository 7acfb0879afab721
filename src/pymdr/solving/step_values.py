"""Values of steps that cannot be taken, and their errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pymdr.errors import PathError
from pymdr.line.moved import beyond
from pymdr.problem.values import LARGEST
from pymdr.units import metres, shown


def too_deep(indentation: float, deepest: float) -> PathError:
    """The error of an indentation in m that is not finite, too far, or deeper than the largest."""
    if not abs(indentation) <= LARGEST:
        return beyond(f"indentation = {indentation:g} m")
    return PathError(
        f"indentation = {metres(indentation)} is deeper than max_indentation = {metres(deepest)}; make a stepper with "
        "a larger one"
    )


def has_unit(value: Any) -> bool:
    """Whether a value is a quantity of pint, which NumPy takes without its unit."""
    return hasattr(value, "magnitude")


def refuse_malformed(count: int, given: Mapping[str, tuple[Any, str]]) -> None:
    """
    Refuse values that are no numbers, or not as many as there are contacts.

    Parameters
    ----------
    given : mapping
        Values by their names, with their units.
    """
    several = f", or an array of shape ({count},)," if count > 1 else ""
    for name, (value, unit) in given.items():
        said, needed = f"{name} = {shown(value)}", f"a number in {unit}{several} is needed"
        try:
            # texts, None, and integers beyond all floats
            plain = not has_unit(value) and np.asarray(value).dtype.kind not in "UO"
            shape = np.asarray(value, dtype=float).shape if plain else None
        except (TypeError, ValueError):
            shape = None
        if shape is None:
            raise PathError(f"{said}; {needed}. Steps take SI floats, without units, for speed")
        if shape == () or (count > 1 and shape in ((1,), (count,))):
            continue
        line = (
            ". The contact moves along one line; elastic bodies with friction move in the plane with springs=, such as springs=32"
            if name == "shift" and shape[0] == 2
            else ""
        )
        raise PathError(f"{said} has the shape {shape}; {needed}{line}")
