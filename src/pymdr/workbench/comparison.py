"""Two solutions of some steps of a path, side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import xr
from pymdr.quantities import quantity
from pymdr.solving.study import Study
from pymdr.units import written
from pymdr.workbench.subsurface import Subsurface


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison(Study):
    """Quantities by the method and by another solution, over ``step``."""

    data: xr.Dataset
    """Each quantity by the method (``_mdr``) and by the other solution, if both have it."""
    subsurface: Subsurface | None = None
    """The stress in the body, with a double integral of point loads; None where the stress is not compared."""

    compared: ClassVar[tuple[str, ...]]
    """The quantities."""
    others: ClassVar[Mapping[str, str]]
    """Suffixes of the columns of the other solution, and their headings."""

    @property
    def largest_difference(self) -> float:
        """The largest relative difference of the force, or of the indentation where forces are prescribed; nan without any."""
        names = [f"{name}_difference" for name in ("indentation", "normal_force")]
        difference = np.concatenate([np.abs(self.data[name].values) for name in names if name in self.data])
        return float(np.nanmax(difference)) if np.isfinite(difference).any() else math.nan

    def _along(self) -> tuple[str, ...]:
        """Names of the quantities that label the steps."""
        return ("indentation",)

    def _table(self) -> tuple[tuple[list[str], list[str]], list[list[str]]]:
        """A row for every quantity of every step."""
        rows: list[list[str]] = []
        for i in range(self.data.sizes["step"]):
            place = [self._cell(name, self.data[name].attrs["units"], i) for name in self._along()]
            for name in self.compared:
                if f"{name}_mdr" in self.data:
                    row = quantity(name)
                    cells = [self._cell(f"{name}_{end}", row.unit, i) for end in ("mdr", *self.others)]
                    rows.append([*place, row.long_name, *cells])
                    place = [""] * len(place)
        head = [*self._along(), "quantity", "MDR", *self.others.values()]
        return (head, [""] * len(head)), rows

    def _cell(self, name: str, unit: str, i: int) -> str:
        value = float(self.data[name].values[i])
        if not name.endswith(("_difference", "_error")):
            return written(value, unit)
        return "-" if math.isnan(value) else f"{value:.1e}"
