"""Randomly rough surfaces pressed together: ensembles of lines, with bands."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Unpack

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.conductance import conduction_of_stiffness
from pymdr.interpretation.rough import FITTED, PUBLISHED, power_law_claims, rough_assumptions, rough_claims
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.line.rough import power_law_stiffness
from pymdr.machine import memory_of_machine
from pymdr.mapping.rough import refuse_coarse
from pymdr.presentation import plot
from pymdr.problem.materials import Material, Rigid
from pymdr.problem.options import with_options
from pymdr.problem.rough import RoughSurface
from pymdr.solving.arguments import Loads, positive_loads
from pymdr.solving.rough_lines import RoughLine, States, rough_line, whole_number
from pymdr.solving.study import Column, Study, dataset, over_rows
from pymdr.solving.workers import Workers, checked_workers, in_order, is_cluster
from pymdr.units import FloatArray, QuantityLike, newtons, written

_BAND = (16.0, 84.0)
"""Percentiles of the realisations: plus and minus one standard deviation of a log-normal distribution."""
_COPIES = 7
"""Arrays of the length of a line that one realisation needs at a time."""
_CURVE, _DECADES_BELOW, _DECADES_ABOVE = 61, 3.0, 1.0
_DRAWN = 2000
_RESPONSES = ("indentation", "normal_force", "normal_stiffness", "elastic_energy")


@dataclass(frozen=True, kw_only=True)
class RoughContact(Study):
    """Force, indentation and stiffness of a rough contact, as geometric means over realisations with bands."""

    data: xr.Dataset
    """
    Over ``normal_force`` (N), or over ``indentation`` (m) below the highest summit: the other of the two, normal_stiffness
    (N/m) and elastic_energy (J), each a geometric mean over the realisations, with ``_low`` and ``_high``, their 16th and
    84th percentiles; power_law_stiffness and fitted_stiffness (N/m) of the closed form; for a ball hertz_stiffness (N/m); for
    bodies with conductivities thermal_conductance (W/K) and electrical_resistance (ohm), from the stiffness.
    """
    curves: xr.Dataset
    """normal_stiffness (N/m) with its band over ``normal_force`` (N), from few contacts to many, for the figure."""
    springs: xr.Dataset
    """
    The first realisation, over ``x`` (m): height (m) of its springs, thinned, with the indentation (m) of the middle row. It is an
    intermediate step, not a section of the surface.
    """
    line: RoughLine
    """The lines by realisation; their ``force_curve`` is a profile."""

    subject: ClassVar = "a rough contact"
    columns: ClassVar = {
        "normal_force": Column("F_N", "N"),
        "indentation": Column("depth", "m"),
        "normal_stiffness": Column("stiffness", "N/m"),
        "normal_stiffness_low": Column("low", "N/m"),
        "normal_stiffness_high": Column("high", "N/m"),
        "power_law_stiffness": Column("power law", "N/m"),
        "fitted_stiffness": Column("fitted", "N/m"),
        "hertz_stiffness": Column("Hertz", "N/m"),
        "elastic_energy": Column("energy", "J"),
        "thermal_conductance": Column("conductance", "W/K"),
        "electrical_resistance": Column("resistance", "ohm"),
    }
    summary_claims: ClassVar = ("normal_stiffness", "power_law_stiffness", "fitted_stiffness")

    def _remarks(self) -> list[str]:
        attrs = self.data.attrs
        lines = [
            f"geometric means of {attrs['realisations']} lines of {attrs['points']} springs; low and high are the 16th and 84th percentiles"
        ]
        if "crossover_force" in attrs:
            return [*lines, f"below {newtons(attrs['crossover_force'])} roughness softens the ball"]
        return [*lines, f"the stiffness of full contact is {written(attrs['full_contact_stiffness'], 'N/m')}"]

    def _figure(self) -> mpl.figure.Figure:
        """Stiffness against force with its band, the closed form and full contact; springs in contact; the spectrum."""
        low, _, high = self.line.surface.wave_numbers
        q = np.geomspace(low, high, 200)
        spectrum = (q, self.line.surface.spectrum_2d(q))
        return plot.rough_study(self.data, self.curves, self.springs, spectrum)


@with_options(Loads)
def press_rough(
    surface: RoughSurface,
    body: Material,
    counterbody: Material | None = None,
    *,
    realisations: int = 100,
    coefficient: float | None = None,
    points: int | None = None,
    radius: QuantityLike | None = None,
    workers: Workers | None = None,
    **load: Unpack[Loads],
) -> RoughContact:
    """
    Force, indentation and stiffness of a randomly rough patch that is pressed on a plane, or of a rough ball.

    The surface is replaced by lines of springs whose heights have the spectrum C1D = lambda q C2D and random phases. The
    stiffness of all springs is that of full contact, k_c = 1.15230 E* L for a square: F = (k_c/n) sum (d - s_i), and k is k_c
    times the fraction of springs in contact. Results are geometric means over the realisations at the given load.

    Parameters
    ----------
    surface : RoughSurface
        Spectrum of the patch.
    body : Elastic or TransverselyIsotropic
        Half-space.
    counterbody : Elastic, TransverselyIsotropic or Rigid, optional
        Rigid by default.
    normal_force, indentation : array_like or quantity
        Forces in N, or depths in m below the highest summit of each line; exactly one, one row, above 0.
    realisations : int, optional
        Number of lines of the ensemble.
    coefficient : float, optional
        lambda, pi by default (Geike); it scales the heights of the line by sqrt(lambda/pi).
    points : int, optional
        Springs of a line; by default 16 per shortest wavelength.
    radius : quantity, optional
        Radius of a ball in m: x^2/R is added to the line, which is then as long as the surface and bears E* per length.
    workers : int or dask.distributed.Client, optional
        Threads, by default one per core within half of the memory, or the client of a cluster. The numbers do not depend on it.

    Returns
    -------
    RoughContact
        Over the loads: force (N) or indentation (m), stiffness (N/m) and energy (J), with bands of the realisations.

    Raises
    ------
    ProblemError
        If not one load is given, it is not above 0, a body is graded or viscoelastic, or points or memory are too few.
    PathError
        If the contact of a ball reaches the end of its line.

    See Also
    --------
    press : the same by boundary elements.
    calibrate_coefficient : the coefficient of the line.

    Notes
    -----
    Geike and Popov (2007); Pohrt and Popov (2012), whose closed form
    k = C/(H + 1) E* L (F/(L h E*))^(1/(1 + H)) is included with C = 1.9412 as published and with 1.45, where each has been compared
    with boundary elements. Contact area, pressures, gaps and adhesion are not given by the line.

    References
    ----------
    - Geike and Popov (2007), Phys. Rev. E 76, 036710, doi:10.1103/PhysRevE.76.036710.
    - Pohrt and Popov (2012), Phys. Rev. Lett. 108, 104301, doi:10.1103/PhysRevLett.108.104301.

    Examples
    --------
    >>> import pymdr as mdr
    >>> surface = mdr.RoughSurface(hurst=0.7, rms="1 um", size="1 mm", shortest="20 um")
    >>> pressed = mdr.press_rough(surface, mdr.Elastic("210 GPa", 0.3), normal_force=["1 N", "10 N", "1 kN"], realisations=50)
    >>> (pressed["normal_stiffness"] / pressed.data.attrs["full_contact_stiffness"]).values.round(2).tolist()
    [0.04, 0.13, 1.0]
    """
    line = rough_line(surface, body, counterbody, coefficient=coefficient, points=points, radius=radius)
    name, rows = positive_loads(load)
    count = whole_number("realisations", realisations)
    threads = _threads(line, count, workers, rows.size)
    grid = _grid(line, rows if name == "normal_force" else None)
    states, drawn = _pressed(line, name, rows, grid, (count, threads))
    bands = _summed(states)
    columns = _responses(bands, name)
    claims = rough_claims(surface, name, np.ones(rows.shape, dtype=bool), line.radius is not None)
    force = columns.get("normal_force", rows)
    laws, closed = _closed_forms(line, force, columns["normal_stiffness"])
    lengths = {end: columns[f"normal_stiffness{end}"] / (2.0 * line.modulus) for end in bands}
    conducted = conduction_of_stiffness(body, counterbody or Rigid(), lengths, claims["normal_stiffness"])
    columns, claims = columns | conducted[0], claims | conducted[1]
    curves = _curves(line, grid, drawn)
    written_with = RoughContact.columns, _attributes(line, count)
    return RoughContact(
        data=over_rows(name, rows, columns | closed, *written_with),
        curves=over_rows("normal_force", grid, curves, *written_with),
        springs=_springs(line, float(np.median(states[0, 0]))),
        line=line,
        claims=claims | laws,
        assumptions=rough_assumptions(surface),
    )


def _responses(bands: dict[str, FloatArray], given: str) -> dict[str, FloatArray]:
    """The responses with their bands, without the given load."""
    return {
        f"{response}{end}": values[i]
        for i, response in enumerate(_RESPONSES)
        if response != given
        for end, values in bands.items()
    }


def _states(line: RoughLine, rows: FloatArray, by_force: bool, grid: FloatArray, realisation: int) -> States:
    """Responses of one realisation."""
    # numbers that are not finite are refused where all realisations are known
    with np.errstate(over="ignore", under="ignore"):
        return line.states(realisation, rows, by_force, grid)


def _pressed(
    line: RoughLine, name: str, rows: FloatArray, grid: FloatArray, count_workers: tuple[int, Workers]
) -> tuple[FloatArray, FloatArray]:
    """Responses and drawn stiffnesses of all realisations."""
    count, workers = count_workers
    work = partial(_states, line, rows, name == "normal_force", grid)
    answers = in_order(work, range(count), workers, ThreadPoolExecutor)
    states, drawn = (np.array(part) for part in zip(*answers, strict=True))
    invalid = ~np.all(np.isfinite(states) & (states > 0.0), axis=(0, 1))
    if invalid.any():
        worst = written(float(rows[np.argmax(invalid)]), RoughContact.columns[name].unit)
        raise ProblemError(
            f"{name} = {worst} has an energy outside the range of floating-point numbers; "
            f"use forces of the order of {newtons(line.scale)}"
        )
    return states, drawn


def _attributes(line: RoughLine, realisations: int) -> dict[str, float | int]:
    """Numbers of the lines, for the attributes of the data."""
    known: dict[str, float | int] = {
        "modulus": line.modulus,
        "points": line.points,
        "realisations": realisations,
        "coefficient": line.coefficient,
        "line_length": line.length,
    }
    if line.radius is None:
        return known | {"full_contact_stiffness": line.modulus * line.length}
    return known | {"radius": line.radius, "crossover_force": line.scale}


def _most_workers(line: RoughLine) -> int:
    """The number of cores, limited by the memory."""
    lines = memory_of_machine() / (8.0 * _COPIES * line.points)
    return max(1, math.floor(min(os.cpu_count() or 1, 0.5 * lines)))


def _threads(line: RoughLine, count: int, workers: Workers | None, rows: int) -> Workers:
    """A cluster, or threads, by default the cores within half of the memory; refuse lines that are too coarse or too large."""
    refuse_coarse(line.surface, line.points)
    if is_cluster(workers):
        return workers
    threads = min(count, _most_workers(line) if workers is None else checked_workers(workers))
    needed = 8.0 * (_COPIES * line.points * threads + 8.0 * count * (rows + _CURVE))
    if needed > memory_of_machine():
        raise ProblemError(
            f"{count} lines of {line.points:.3g} springs, {threads} at a time, need about {needed / 1e9:.3g} GB (limit "
            f"{memory_of_machine() / 1e9:.3g} GB, the memory of this machine); use fewer workers or points, or a longer shortest wavelength"
        )
    return threads


def _summed(values: FloatArray) -> dict[str, FloatArray]:
    """Geometric means and the band over the first axis, by the suffix of their names."""
    low, high = np.percentile(values, _BAND, axis=0)
    return {"": np.exp(np.log(values).mean(axis=0)), "_low": low, "_high": high}


def _grid(line: RoughLine, rows: FloatArray | None) -> FloatArray:
    """Forces from few contacts to many, including the requested ones."""
    low, high = line.scale * 10.0**-_DECADES_BELOW, line.scale * 10.0**_DECADES_ABOVE
    if rows is not None:
        low, high = min(low, float(rows.min())), max(high, float(rows.max()))
    return np.geomspace(low, high, _CURVE)


def _closed_forms(
    line: RoughLine, force: FloatArray, stiffness: FloatArray
) -> tuple[dict[str, Claim], dict[str, FloatArray]]:
    """The power law with both constants in their ranges of validity; for a ball also that of Hertz."""
    surface, modulus = line.surface, line.modulus
    ball = line.radius is not None
    claims = power_law_claims(surface, stiffness / (modulus * surface.longer_side), ball)
    columns = {}
    for name, constant in (("power_law_stiffness", PUBLISHED), ("fitted_stiffness", FITTED)):
        if claims[name].where.any():
            law = power_law_stiffness(
                force, surface.hurst, surface.rms, surface.longer_side, modulus, constant
            )
            columns[name] = np.where(claims[name].where, law, np.nan)
    if line.radius is not None:
        columns["hertz_stiffness"] = np.cbrt(6.0 * modulus**2 * line.radius * force)
        exact = Claim(
            Level.EXACT, "for the smooth ball, 2 E* a", SOURCES["hertz"], np.ones(force.shape, dtype=bool)
        )
        claims["hertz_stiffness"] = exact
    return claims, columns


def _curves(line: RoughLine, grid: FloatArray, drawn: FloatArray) -> dict[str, FloatArray]:
    """Stiffnesses over the forces of a grid, and the closed forms."""
    curves = {f"normal_stiffness{end}": values for end, values in _summed(drawn).items()}
    return curves | _closed_forms(line, grid, curves["normal_stiffness"])[1]


def _springs(line: RoughLine, depth: float) -> xr.Dataset:
    """The springs of the first line, thinned to the highest of each group, and the height of the plane."""
    heights = line.heights(0)
    every = -(-heights.size // _DRAWN)
    size = heights.size // every * every
    highest = heights[:size].reshape(-1, every).argmax(axis=1) + np.arange(0, size, every)
    return dataset(
        {"height": ("x", heights[highest], {"units": "m"})},
        coords={"x": ("x", line.places[highest], {"units": "m"})},
        attrs={"plane": float(heights.max()) - depth}
        | ({} if line.radius is None else {"radius": line.radius}),
    )
