"""Rows of several legs in one, whatever they hold: arrays, or dicts, named tuples and dataclasses of them, nested."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Rows = TypeVar("Rows")


def joined(parts: Sequence[Rows]) -> Rows:
    """
    Rows of several parts, one after the other.

    Parameters
    ----------
    parts : sequence
        At least one; all of one type, of arrays over rows, along their first axis.

    Returns
    -------
    The type of the parts.

    Examples
    --------
    >>> joined([np.array([1.0]), np.array([2.0, 3.0])]).tolist()
    [1.0, 2.0, 3.0]
    """
    whole: Rows = parts[0] if len(parts) == 1 else _array_by_array(np.concatenate, parts)
    return whole


def taken(rows: Rows, index: NDArray[Any] | slice | None) -> Rows:
    """
    Some of the rows, or all for None.

    Examples
    --------
    >>> taken(np.array([1.0, 2.0, 3.0]), np.array([0, 2])).tolist()
    [1.0, 3.0]
    """
    if index is None:
        return rows
    some: Rows = _array_by_array(lambda arrays: arrays[0][index], [rows])
    return some


def _array_by_array(make: Callable[[Sequence[NDArray[Any]]], NDArray[Any]], parts: Sequence[Any]) -> Any:
    first = parts[0]
    if isinstance(first, np.ndarray):
        return make(parts)
    if isinstance(first, dict):
        return {name: _array_by_array(make, [part[name] for part in parts]) for name in first}
    names = [field.name for field in fields(first)] if is_dataclass(first) else first._fields
    return type(first)(*(_array_by_array(make, [getattr(part, name) for part in parts]) for name in names))
