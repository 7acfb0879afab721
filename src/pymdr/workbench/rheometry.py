"""Measured moduli, and the Prony series in shear through them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.problem.fitting import Measured
from pymdr.problem.rheology import Prony
from pymdr.solving.study import Study
from pymdr.units import FloatArray, QuantityLike, shown, to_si, to_si_array, written
from pymdr.workbench.tables import read_rheometry

_SWEEP = {"omega": "rad/s", "storage": "Pa", "loss": "Pa"}
_TEST = {"time": "s", "modulus": "Pa"}
_YOUNG = {"young": "modulus", "young_storage": "storage", "young_loss": "loss"}
"""Names of Young's moduli, and of those in shear."""
_DRAWN = 400


@dataclass(frozen=True, kw_only=True)
class PronyFit(Study):
    """A Prony series in shear and the rows that it was fitted to."""

    data: xr.Dataset
    """In shear: ``modulus`` (Pa) over ``time`` (s), or ``storage`` and ``loss`` (Pa) over ``omega`` (rad/s)."""
    series: Prony

    subject: ClassVar = "a fit of moduli"

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
        """Root mean square relative misfit of the series, as the fit counts it."""
        fitted = list(self._moduli(self._rows.inverse).values())[1:]
        return self._rows.misfit(np.concatenate(fitted))

    @property
    def _rows(self) -> Measured:
        along, *moduli = self._measured
        return Measured(along, tuple(moduli), "PronyFit")

    @property
    def _measured(self) -> list[FloatArray]:
        return [self.data[name].values for name in (_TEST if "time" in self.data else _SWEEP)]

    def _remarks(self) -> list[str]:
        number = self.series.times.size
        return [
            f"{number} term{'s' if number != 1 else ''} in shear, root mean square misfit {100.0 * self.misfit:.3g} %"
        ]

    def _table(self) -> tuple[tuple[list[str], list[str]], list[list[str]]]:
        """The terms."""
        terms = zip(self.series.times.tolist(), self.series.moduli.tolist(), strict=True)
        rows = [[written(time, "s"), written(modulus, "Pa")] for time, modulus in terms]
        return (["time", "modulus"], ["", ""]), [
            ["equilibrium", written(self.series.equilibrium, "Pa")],
            *rows,
        ]

    def _figure(self) -> mpl.figure.Figure:
        """The rows with the series through them, and its terms."""
        from pymdr.presentation.plot.rheology import fitted_moduli

        rows = self._rows
        fine = self._moduli(np.geomspace(rows.inverse[0], rows.inverse[-1], _DRAWN))
        measured = dict(zip(fine, self._measured, strict=True))
        terms = (self.series.times, self.series.moduli)
        return fitted_moduli(measured, fine, self.series.equilibrium, terms, rows.span, self.misfit)


def fit_prony(
    data: str | os.PathLike[str] | Mapping[str, Any],
    *,
    poisson: QuantityLike | None = None,
    terms: int | None = None,
    noise: float | None = None,
) -> PronyFit:
    """
    A Prony series in shear through a relaxation test or a frequency sweep.

    Parameters
    ----------
    data : path or mapping
        A CSV file with units in its header, ``time [s], G [kPa]``, or ``frequency [Hz], G' [kPa], G'' [kPa]`` (or
        ``omega [rad/s]``), or the same with E, E' and E''; ``tan delta`` may stand for one of a pair. Or arrays in shear under the
        names ``time`` and ``modulus``, or ``omega`` (in rad/s), ``storage`` and ``loss``; and of Young's moduli ``time`` and
        ``young``, or ``omega``, ``young_storage`` and ``young_loss``.
    poisson : quantity, optional
        Poisson's ratio, the same at all times; needed for Young's moduli, which are 2 (1 + nu) times those in shear.
    terms : int, optional
        Largest number of terms; by default the smallest number whose misfit is at most `noise`.
    noise : float, optional
        Relative noise of the rows; unless given, 1.1 of the misfit of the full fit.

    Returns
    -------
    PronyFit
        The series in shear, its misfit and its figure.

    Raises
    ------
    FileError, CaseError
        If the file cannot be read or is not such a table.
    ProblemError, UnitError
        As :meth:`Prony.from_relaxation` and :meth:`Prony.from_dma`, which fit.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> t = np.geomspace(1e-3, 1e2, 50)
    >>> print(mdr.fit_prony({"time": t, "modulus": 1e5 + 3e5 * np.exp(-t / 0.2)}, noise=1e-3))
            time      modulus
     equilibrium      100 kPa
          200 ms      300 kPa
    1 term in shear, root mean square misfit ... %
    """
    if isinstance(data, str | os.PathLike):
        data = read_rheometry(data)
    if not isinstance(data, Mapping) or {_YOUNG.get(name, name) for name in data} not in (
        set(_TEST),
        set(_SWEEP),
    ):
        raise ProblemError(
            f"{shown(data)}; the name of a CSV file is needed, or arrays in shear under the names {', '.join(_TEST)} or "
            f"{', '.join(_SWEEP)} (of Young's moduli: {', '.join(_YOUNG)})"
        )
    units = _TEST if "time" in data else _SWEEP
    rows = {}
    for name, values in data.items():
        own = _YOUNG.get(name, name)
        rows[own] = to_si_array(values, units[own], name=name) / _stiffer(name, poisson)
    rows = {name: rows[name] for name in units}
    fit = Prony.from_relaxation if "time" in data else Prony.from_dma
    along, *others = ((name, (next(iter(units)), rows[name], {"units": units[name]})) for name in units)
    return PronyFit(
        data=xr.Dataset(dict(others), coords=dict([along])),
        series=fit(*rows.values(), terms=terms, noise=noise),
    )


def _stiffer(name: str, poisson: QuantityLike | None) -> float:
    """Ratio of a modulus to the shear modulus."""
    if name not in _YOUNG:
        return 1.0
    if poisson is None:
        raise ProblemError(
            f"{name} is Young's modulus, 2 (1 + nu) times that in shear: give poisson, such as 0.5 for a body that keeps "
            "its volume"
        )
    nu = to_si(poisson, "", name="poisson")
    if not -1.0 < nu <= 0.5:
        raise ProblemError(f"poisson = {nu:g}; it must be above -1 and at most 0.5")
    return 2.0 * (1.0 + nu)
