"""Concatenation and selection of rows: arrays, or nested dicts, named tuples and dataclasses of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Rows = TypeVar("Rows")


def joined(parts: Sequence[Rows]) -> Rows:
    """
    Concatenate the rows of several parts.

    Parameters
    ----------
    parts : sequence
        At least one, all of one type, with rows along the first axis of their arrays.

    Examples
    --------
    >>> joined([np.array([1.0]), np.array([2.0, 3.0])]).tolist()
    [1.0, 2.0, 3.0]
    """
    together: Rows = parts[0] if len(parts) == 1 else _array_by_array(np.concatenate, parts)
    return together


def taken(rows: Rows, index: NDArray[Any] | slice | None) -> Rows:
    """
    Select rows; None selects all.

    Examples
    --------
    >>> taken(np.array([1.0, 2.0, 3.0]), np.array([0, 2])).tolist()
    [1.0, 3.0]
    """
    if index is None:
        return rows
    selected: Rows = _array_by_array(lambda arrays: arrays[0][index], [rows])
    return selected


def _array_by_array(make: Callable[[Sequence[NDArray[Any]]], NDArray[Any]], parts: Sequence[Any]) -> Any:
    first = parts[0]
    if isinstance(first, np.ndarray):
        return make(parts)
    if isinstance(first, dict):
        return {name: _array_by_array(make, [part[name] for part in parts]) for name in first}
    names = [field.name for field in fields(first)] if is_dataclass(first) else first._fields
    return type(first)(*(_array_by_array(make, [getattr(part, name) for part in parts]) for name in names))
