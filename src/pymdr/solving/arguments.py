"""Common arguments of studies: rows of numbers, loads and speeds, read in SI units and checked."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.values import within_range
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array, written


class Loads(TypedDict, total=False):
    """Loads of a study, of which exactly one is given."""

    normal_force: ArrayQuantityLike | None
    indentation: ArrayQuantityLike | None


def one_row(given: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    """One row of numbers in SI units."""
    values = np.atleast_1d(to_si_array(given, unit, name=name))
    if values.ndim != 1 or values.size == 0:
        raise ProblemError(f"{name} = {shown(given)}; one row of numbers is needed")
    return values


def positive_row(given: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    """One row of numbers above 0 in SI units."""
    values = one_row(given, unit, name)
    if not np.all(values > 0.0):
        raise ProblemError(f"{name} = {written(float(values.min()), unit)}; it must be above 0 {unit}")
    return values


def positive_speeds(speed: ArrayQuantityLike) -> FloatArray:
    """One row of speeds in m/s, above 0."""
    v = positive_row(speed, "m/s", "speed")
    for extreme in (v.min(), v.max()):
        within_range(extreme, "m/s", "speed", size=True)
    return v


def one_load(normal_force: object, indentation: object) -> None:
    """Require exactly one of a load and an indentation."""
    if (normal_force is None) == (indentation is None):
        raise ProblemError("give exactly one of normal_force and indentation")


def positive_loads(load: Loads) -> tuple[str, FloatArray]:
    """The name of the given load, and one row of forces in N or depths in m, above 0."""
    force, depth = load.get("normal_force"), load.get("indentation")
    one_load(force, depth)
    name, unit, given = ("normal_force", "N", force) if force is not None else ("indentation", "m", depth)
    assert given is not None
    rows = positive_row(given, unit, name)
    for extreme in (rows.min(), rows.max()):
        within_range(extreme, unit, name, size=True)
    return name, rows


def positive_load(
    normal_force: QuantityLike | None, indentation: QuantityLike | None, deep: float = 0.0
) -> tuple[float | None, float | None]:
    """Force in N above 0, or depth in m above a limit."""
    one_load(normal_force, indentation)
    force = None if normal_force is None else to_si(normal_force, "N", name="normal_force")
    depth = None if indentation is None else to_si(indentation, "m", name="indentation")
    for value, given, unit, least in ((force, normal_force, "N", 0.0), (depth, indentation, "m", deep)):
        if value is not None and value <= least:
            raise ProblemError(f"the load {shown(given)} must be above 0 {unit}; press the bodies together")
        if value is not None:
            within_range(value, unit, "the load", size=deep == 0.0)
    return force, depth
