"""Calibration of lambda: the line of springs that is as stiff as a rough surface in three dimensions."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import scipy

from pymdr.errors import ProblemError
from pymdr.independent.engines import Engine
from pymdr.interpretation.rough import FITTED_FRACTIONS, PUBLISHED, calibration_claims, rough_assumptions
from pymdr.line.rough import power_law_stiffness
from pymdr.mapping.patch import full_contact_stiffness
from pymdr.problem.materials import Elastic
from pymdr.problem.rough import GEIKE, RoughSurface
from pymdr.solving.press import PressedSurface, press
from pymdr.solving.rough import press_rough
from pymdr.solving.study import Column, Study, over_rows
from pymdr.solving.workers import Workers, checked_workers, counted, in_order
from pymdr.units import FloatArray, shown

_UNIT = Elastic(1.0, 0.0)
_LINES = 100
_FRACTIONS = (0.015, 0.985)
"""Range of the stiffness of Geike's line at the loads, relative to full contact."""
_BEYOND = 1.6
"""Factor of the largest load, because surfaces approach full contact more slowly than lines."""
_LOADS, _FEWEST = 12, 3
_BAND = (16.0, 84.0)
_DENSE, _AROUND = 400, 4.0
_WIDEST = 3.0
"""Largest factor of the heights."""


@dataclass(frozen=True, kw_only=True)
class LineCalibration(Study):
    """
    Stiffness of a rough square in three dimensions, that of its lines and of the power law, over the load F/(E* L h).

    ``stiffness`` is k/(E* L), with ``_low`` and ``_high``, the 16th and 84th percentiles; ``line_stiffness`` is that of Geike's line,
    ``fitted_stiffness`` that of the line with the fitted lambda, ``power_law`` eq. (16). ``area`` is the true contact area over that
    of the square, ``line_fraction`` the fraction of springs in contact, which is not an area.
    """

    subject: ClassVar[str] = "a calibration"
    _drawn: ClassVar = ("calibration_study", "data")
    columns: ClassVar[Mapping[str, Column]] = {
        "load": Column("F/E*Lh", ""),
        "stiffness": Column("k/E*L", ""),
        "stiffness_low": Column("low", ""),
        "stiffness_high": Column("high", ""),
        "line_stiffness": Column("Geike", ""),
        "fitted_stiffness": Column("fitted", ""),
        "power_law": Column("power law", ""),
        "area": Column("area", ""),
        "line_fraction": Column("line fraction", ""),
    }
    summary_claims: ClassVar[tuple[str, ...]] = (
        "stiffness",
        "line_stiffness",
        "fitted_stiffness",
        "power_law",
        "line_fraction",
    )

    @property
    def coefficient(self) -> float:
        """The fitted lambda, for ``press_rough(..., coefficient=...)``."""
        return float(self.data.attrs["coefficient"])

    def _remarks(self) -> list[str]:
        attrs = self.data.attrs
        low, high = attrs["coefficients"]
        return [
            f"H = {attrs['hurst']:g}, {attrs['bandwidth']:.4g} shortest waves per side, {attrs['realisations']} surfaces of {attrs['pixels']} x "
            f"{attrs['pixels']} pixels ({attrs['engine']}), {_LINES} lines",
            f"lambda = {self.coefficient:.3g}; of single surfaces from {low:.3g} to {high:.3g}; rms misfit {100.0 * attrs['misfit']:.2g} %, largest "
            f"{100.0 * attrs['largest_misfit']:.2g} %",
        ]


def calibrate_coefficient(
    surface: RoughSurface,
    *,
    realisations: int = 6,
    points: int | None = None,
    engine: str | Engine | None = None,
    keep: str | os.PathLike[str] | None = None,
    workers: Workers = 1,
    progress: Callable[[int, int], None] | None = None,
) -> LineCalibration:
    """
    Fit the lambda with which lines of springs are as stiff as a rough square in three dimensions.

    Realisations of the surface are pressed on a half-space by boundary elements, without friction and adhesion, as punches.
    lambda scales the heights of a line by sqrt(lambda/pi), so that k(F; lambda) = k(F sqrt(pi/lambda); pi). The fit
    minimises the squared differences of the logarithms of mean stiffnesses, from 0.03 to 0.85 of full contact.

    Parameters
    ----------
    surface : RoughSurface
        A square; its height and size have no effect.
    realisations : int, optional
        Number of surfaces.
    points : int, optional
        Pixels along a side, at least 4 per shortest wavelength, which is the default.
    engine, keep : optional
        As for :func:`pymdr.press`; the folder is one that all workers reach.
    workers : int or dask.distributed.Client
        Number of processes, or the client of a cluster; each presses whole surfaces.
    progress : callable, optional
        Called as ``progress(done, total)`` with numbers of surfaces.

    Returns
    -------
    LineCalibration
        ``coefficient`` lambda with its error, and the stiffnesses over the load.

    Raises
    ------
    ProblemError
        If the surface is not a square, a number is not above 0, or too few loads are in the range.
    MissingExtraError
        If the package of the engine is not installed.
    FileError
        If the folder has results of other input.

    See Also
    --------
    press_rough : the line that uses the coefficient.

    Notes
    -----
    lambda increases with H and varies between surfaces by a factor of two; within that, no dependence on the bandwidth was found
    from 32 to 128 waves per side. Popov and Hess (2015), section 10.7.

    References
    ----------
    - Geike and Popov (2007), Phys. Rev. E 76, 036710, doi:10.1103/PhysRevE.76.036710.
    - Pohrt and Popov (2012), Phys. Rev. Lett. 108, 104301, doi:10.1103/PhysRevLett.108.104301.
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="125 um")
    >>> result = mdr.calibrate_coefficient(surface, realisations=1)
    >>> 2.0 < result.coefficient < 6.0
    True
    """
    _check(surface, realisations)
    side, unit = surface.longer_side, surface.longer_side * surface.rms
    full = full_contact_stiffness(side, side) / side
    forces = unit * _loads(surface, full)
    pixels = math.ceil(4.0 * side / surface.shortest * (1.0 - 1e-12)) if points is None else points
    work = partial(_pressed, surface, pixels, forces, engine, keep)
    pressed = counted(in_order(work, range(realisations), checked_workers(workers)), realisations, progress)
    package = pressed[-1].data.attrs["engine"]
    stiffness = np.array([one["normal_stiffness"].values / side for one in pressed])
    area = np.array([one["contact_area"].values / side**2 for one in pressed])
    mean, low, high = _summed(stiffness)
    inside = _fitted_loads(mean / full)
    coefficients, lines = _lines(surface, forces, inside, [mean, *stiffness])
    columns = _with_band("stiffness", (mean, low, high)) | lines | _with_band("area", _summed(area))
    law = power_law_stiffness(forces, surface.hurst, surface.rms, side, 1.0, PUBLISHED)
    columns |= {"power_law": law / side, "line_fraction": lines["line_stiffness"] / full}
    attributes = _misfit(np.log(lines["fitted_stiffness"] / mean)[inside], coefficients) | {
        "hurst": surface.hurst,
        "bandwidth": surface.longer_side / surface.shortest,
        "full_contact_stiffness": full,
        "realisations": realisations,
        "pixels": pixels,
        "engine": package,
    }
    return LineCalibration(
        data=over_rows("load", forces / unit, columns, LineCalibration.columns, attributes),
        claims=calibration_claims(columns, inside, realisations, coefficients[0], package),
        assumptions=rough_assumptions(surface),
    )


def _with_band(name: str, summed: tuple[FloatArray, ...]) -> dict[str, FloatArray]:
    """A column with its band, as :func:`_summed` gives them."""
    return dict(zip((name, f"{name}_low", f"{name}_high"), summed, strict=True))


def _misfit(off: FloatArray, coefficients: list[float]) -> dict[str, Any]:
    """The coefficient, those of single surfaces, and the misfit of the fitted line."""
    return {
        "coefficient": coefficients[0],
        "coefficients": tuple(np.percentile(coefficients[1:], _BAND).tolist()),
        "misfit": float(np.sqrt(np.mean(off**2))),
        "largest_misfit": float(np.abs(off).max()),
    }


def _check(surface: RoughSurface, realisations: int) -> None:
    if not isinstance(surface, RoughSurface):
        raise ProblemError(
            f"{shown(surface)} is not a RoughSurface; write RoughSurface(hurst=0.8, rms='1 um', size='1 mm', shortest='10 um')"
        )
    if surface.size[0] != surface.size[1]:
        raise ProblemError("the patch is a rectangle; lines are calibrated on a square")
    if isinstance(realisations, bool) or not isinstance(realisations, int) or realisations < 1:
        raise ProblemError(f"realisations = {shown(realisations)}; a whole number of at least 1 is needed")


def _fitted_loads(fractions: FloatArray) -> np.ndarray:
    """Which loads are fitted, by their fraction of the stiffness of full contact."""
    low, high = FITTED_FRACTIONS
    inside = np.asarray((fractions > low) & (fractions < high))
    if int(inside.sum()) < _FEWEST:
        raise ProblemError(
            f"{int(inside.sum())} of {inside.size} loads are between {low:g} and {high:g} of full contact (limit "
            f"{_FEWEST}); use a shorter shortest wavelength"
        )
    return inside


def _lines(
    surface: RoughSurface, forces: FloatArray, inside: np.ndarray, stiffness: Sequence[FloatArray]
) -> tuple[list[float], dict[str, FloatArray]]:
    """Lambda of every stiffness, and k/(E* L) of lines with that of Geike and with the first of these."""
    dense = np.geomspace(forces[0] / _AROUND, forces[-1] * _AROUND, _DENSE)
    geike = _line(surface, dense, GEIKE)["stiffness"]
    coefficients = [_fitted(forces[inside], one[inside], dense, geike) for one in stiffness]
    lines = {
        f"{kind}_{name}": values
        for kind, factor in (("line", GEIKE), ("fitted", coefficients[0]))
        for name, values in _line(surface, forces, factor).items()
    }
    return coefficients, lines


def _loads(surface: RoughSurface, full: float) -> FloatArray:
    """F/(E* L h) from few contacts to almost full contact of Geike's line."""
    dense = np.geomspace(1e-6, 1e3, 2 * _DENSE)
    stiffness = _line(surface, dense * surface.longer_side * surface.rms, GEIKE)["stiffness"]
    ends = np.interp([fraction * full for fraction in _FRACTIONS], stiffness, np.log(dense))
    loads = np.exp(np.linspace(ends[0], ends[1] + math.log(_BEYOND), _LOADS))
    # rounded, because the last bits depend on the number of threads and loads identify a folder
    return np.array([float(f"{load:.6g}") for load in loads])


def _line(surface: RoughSurface, forces: FloatArray, coefficient: float) -> dict[str, FloatArray]:
    """k/(E* L) of lines with its band."""
    result = press_rough(
        surface, _UNIT, normal_force=forces, realisations=_LINES, coefficient=coefficient, workers=1
    )
    return {
        f"stiffness{end}": result[f"normal_stiffness{end}"].values / surface.longer_side
        for end in ("", "_low", "_high")
    }


def _summed(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Geometric mean over the first axis, and the band."""
    low, high = np.percentile(values, _BAND, axis=0)
    return np.exp(np.log(values).mean(axis=0)), low, high


def _fitted(forces: FloatArray, stiffness: FloatArray, dense: FloatArray, geike: FloatArray) -> float:
    """Lambda of the least squares of logarithms, given Geike's line on a dense grid of forces."""
    at, line = np.log(dense), np.log(geike)

    def misfit(stretch: float) -> float:
        return float(np.mean((np.interp(np.log(forces) - stretch, at, line) - np.log(stiffness)) ** 2))

    most = math.log(_WIDEST)
    minimum = scipy.optimize.minimize_scalar(
        misfit, bounds=(-most, most), method="bounded", options={"xatol": 1e-6}
    )
    return GEIKE * math.exp(2.0 * float(minimum.x))


def _pressed(
    surface: RoughSurface,
    pixels: int,
    forces: FloatArray,
    engine: str | Engine | None,
    keep: str | os.PathLike[str] | None,
    i: int,
) -> PressedSurface:
    """A realisation of the surface, pressed as a punch."""
    folder = None if keep is None else Path(keep) / f"surface-{i:04d}"
    heights = surface.topography(i, points=pixels)
    return press(heights, _UNIT, normal_force=forces, punch=True, engine=engine, keep=folder)
