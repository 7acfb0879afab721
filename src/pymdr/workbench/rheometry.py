"""Measurements in shear, and the Prony series through them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.fitting import Measured
from pymdr.problem.rheology import Prony
from pymdr.units import FloatArray, shown, to_si_array, written
from pymdr.workbench.tables import read_rheometry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SWEEP = {"omega": "rad/s", "storage": "Pa", "loss": "Pa"}
_TEST = {"time": "s", "modulus": "Pa"}
_DRAWN = 400


@dataclass(frozen=True)
class PronyFit:
    """A Prony series and the rows that it was fitted to."""

    series: Prony
    data: dict[str, FloatArray]
    """``time`` (s) and ``modulus`` (Pa), or ``omega`` (rad/s), ``storage`` and ``loss`` (Pa)."""

    def _moduli(self, along: FloatArray) -> dict[str, FloatArray]:
        """The series at times or angular frequencies, under the names of quantities."""
        if "time" in self.data:
            return {"time": along, "relaxation_modulus": self.series.relaxation(along)}
        return {
            "angular_frequency": along,
            "storage_modulus": self.series.storage(along),
            "loss_modulus": self.series.loss(along),
        }

    @property
    def misfit(self) -> float:
        """Root mean square of what the series lies off the moduli, relative to them, as the fit counts it."""
        found = list(self._moduli(self._rows.inverse).values())[1:]
        return self._rows.misfit(np.concatenate(found))

    @property
    def _rows(self) -> Measured:
        along, *moduli = self.data.values()
        return Measured(along, tuple(moduli), "PronyFit")

    def summary(self) -> str:
        """A line per term, with units."""
        number = self.series.times.size
        lines = [
            f"{number} term{'s' if number != 1 else ''}, {100.0 * self.misfit:.3g} % off the rows (root mean square)",
            f"{'time':>12} {'modulus':>12}",
            f"{'equilibrium':>12} {written(self.series.equilibrium, 'Pa'):>12}",
        ]
        for time, modulus in zip(self.series.times, self.series.moduli, strict=True):
            lines.append(f"{written(float(time), 's'):>12} {written(float(modulus), 'Pa'):>12}")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()

    def plot(self) -> Figure:
        """The rows with the series through them, and its terms."""
        from pymdr.presentation.plot.rheology import fitted_moduli

        rows = self._rows
        fine = self._moduli(np.geomspace(rows.inverse[0], rows.inverse[-1], _DRAWN))
        measured = dict(zip(fine, self.data.values(), strict=True))
        terms = (self.series.times, self.series.moduli)
        return fitted_moduli(measured, fine, self.series.equilibrium, terms, rows.span, self.misfit)


def fit_prony(
    data: str | os.PathLike[str] | Mapping[str, Any], *, terms: int | None = None, noise: float | None = None
) -> PronyFit:
    """
    A Prony series through a relaxation test or a frequency sweep in shear.

    Parameters
    ----------
    data : path or mapping
        A CSV file with units in its header, ``time [s], modulus [kPa]``, or ``frequency [Hz], storage [kPa],
        loss [kPa]`` (or ``omega [rad/s]``); or arrays under the names ``time`` and ``modulus``, or ``omega`` (in
        rad/s), ``storage`` and ``loss``.
    terms : int, optional
        The largest number of terms. Unless given, they become fewer as long as the misfit is at most `noise`.
    noise : float, optional
        Relative noise of the rows; unless given, 1.1 of the misfit of the full fit.

    Returns
    -------
    PronyFit
        The series, its misfit and its figure.

    Raises
    ------
    FileError, CaseError
        If the file cannot be read or is not such a table.
    ProblemError, UnitError
        As :meth:`Prony.from_relaxation` and :meth:`Prony.from_dma`, which fit.

    Examples
    --------
    >>> t = np.geomspace(1e-3, 1e2, 50)
    >>> print(fit_prony({"time": t, "modulus": 1e5 + 3e5 * np.exp(-t / 0.2)}, noise=1e-3))
    1 term, ... % off the rows (root mean square)
            time      modulus
     equilibrium      100 kPa
          200 ms      300 kPa
    """
    if isinstance(data, str | os.PathLike):
        data = read_rheometry(data)
    if not isinstance(data, Mapping) or set(data) not in (set(_TEST), set(_SWEEP)):
        raise ProblemError(
            f"fit_prony: {shown(data)}; the name of a CSV file is needed, or arrays under the names {', '.join(_TEST)} or "
            f"{', '.join(_SWEEP)}"
        )
    units = _TEST if "time" in data else _SWEEP
    rows = {name: to_si_array(data[name], unit, name=name) for name, unit in units.items()}
    fit = Prony.from_relaxation if "time" in data else Prony.from_dma
    return PronyFit(fit(*rows.values(), terms=terms, noise=noise), rows)
