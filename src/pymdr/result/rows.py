"""Which rows of a result are read and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import QuantityError
from pymdr.interpretation.validity import BoolArray
from pymdr.units import shown


def row_indices(step: int | Sequence[int] | None, n: int) -> list[int]:
    """Indices from 0 of a row, of several, or of all n of them for None."""
    if step is None:
        return list(range(n))
    if isinstance(step, list | tuple | range) or (isinstance(step, np.ndarray) and step.ndim == 1):
        if len(step) == 0:
            raise QuantityError("step is empty: name at least one row")
        return [row_index(one, n) for one in step]
    return [row_index(step, n)]


def row_index(step: Any, n: int, name: str = "step", several: str = ", or a list of them") -> int:
    """Index from 0 of a row of n."""
    if isinstance(step, bool) or not isinstance(step, int | np.integer):
        raise QuantityError(
            f"{name} = {shown(step)}: a whole number from 0 to {n - 1} is needed, -1 for the last{several}"
        )
    if not -n <= step < n:
        raise QuantityError(f"{name} {step} does not exist: there are {n} {name}s, 0 to {n - 1}")
    return int(step) % n


def drawn_row(data: xr.Dataset, valid: BoolArray, step: int, is_viscoelastic: bool) -> int:
    """The row of figures, -1 if none is valid: by default the last in contact, with memory that of the largest load."""
    row = row_index(step, data.sizes["step"])
    if not valid[row]:
        known = np.flatnonzero(valid)
        row = int(known[-1]) if known.size else -1
    if step == -1 and row >= 0:
        # a contact as small as a point is not informative
        size = "contact_radius" if "contact_radius" in data else "semi_axis_x"
        radii = np.nan_to_num(data[size].values)
        shown = radii > 1e-6 * radii.max()
        if is_viscoelastic and "normal_force" in data:
            # rows under falling load are less informative
            force = np.where(shown & valid, data["normal_force"].values, -np.inf)
            shown &= force >= (1.0 - 1e-9) * force.max()
        touching = np.flatnonzero(shown)
        row = int(touching[-1]) if touching.size else row
    return row


def spread_rows(valid: BoolArray, count: int = 24) -> list[int]:
    """
    Some rows of those that are valid, spread evenly, the first and the last included.

    Examples
    --------
    >>> spread_rows(np.array([False, True, True, True]), 2)
    [1, 3]
    """
    known = np.flatnonzero(valid)
    if known.size == 0:
        return []
    at = np.linspace(0, known.size - 1, min(count, known.size)).round().astype(int)
    return [int(row) for row in known[at]]
