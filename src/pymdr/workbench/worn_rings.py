"""Fretting wear side by side with rings that are solved again in every block of cycles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError
from pymdr.independent.wear import WornRings, wear_by_rings
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.quantities import QUANTITIES
from pymdr.solving.wear import Wear, wear
from pymdr.solving.wearing import one_cycle
from pymdr.units import FloatArray
from pymdr.workbench.comparison import Comparison

_EARLY, _LATE = 10, 48
"""Log-spaced blocks of cycles of the rings, from 1e-5 to 1e-2 and from there to 1 of all cycles."""
_BEYOND = 1.1
"""Radius of the outermost ring over that of contact and wear."""
_COMPARED_FROM = 0.01
"""Fraction of all cycles from which on rows are compared."""

COMPARED = ("worn_volume", "worn_depth", "indentation", "normal_force")


@dataclass(frozen=True, kw_only=True, eq=False)
class WearVerification(Comparison):
    """The same wear by the method and by rings."""

    data: xr.Dataset
    """Over ``step``: ``cycles``, and every compared quantity by both, as ``_mdr`` and ``_rings``, with its relative difference (``_difference``)."""
    surface: xr.Dataset
    """Depth of wear in the last row over ``r``, ``mdr`` and ``rings``, in m."""
    curves: xr.Dataset
    """All rows of the method: ``worn_volume`` over ``cycles``."""
    rings: int
    halved: float
    """Largest relative change of the worn volume of the rings with half of them and half of the blocks."""

    subject: ClassVar = "a verification"
    compared: ClassVar = COMPARED
    others: ClassVar = {"rings": "rings", "difference": "difference"}

    @property
    def largest_difference(self) -> float:
        """Largest relative difference of the worn volumes."""
        return float(np.max(np.abs(self.data["worn_volume_difference"].values)))

    def _along(self) -> tuple[str, ...]:
        return ("cycles",)

    def _remarks(self) -> list[str]:
        return [
            f"boundary elements on {self.rings} rings, solved again in each of at least {_EARLY + _LATE} blocks of cycles",
            f"largest difference of the worn volume: {100 * self.largest_difference:.2g} %; half the rings and blocks change it by "
            f"{100 * self.halved:.2g} %",
            "the rings have the shear modulus G* of the method: both take the mean of the slip around the axis",
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Worn volume over cycles and depth of wear in the last row, by both."""
        return plot.compared_wear(self.data, self.curves, self.surface)


def verify_wear(
    contact: Contact,
    path: LoadingPath,
    given: Mapping[str, Any],
    rings: int,
    steps: int,
    progress: Callable[[int, int], None] | None,
) -> WearVerification:
    """
    Follow fretting wear both by the method and by rings.

    Parameters
    ----------
    given : mapping
        Arguments of :func:`pymdr.wear`: ``coefficient``, ``cycles``, ``law``.
    steps : int
        Number of compared rows, spread over those from 1 % of the cycles on.
    """
    if isinstance(rings, bool) or not isinstance(rings, int) or not 20 <= rings <= 1000:
        raise ProblemError(f"elements = {rings!r}; a whole number of rings from 20 to 1000 is needed")
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise PathError(f"steps = {steps!r}; a whole number of at least 1 is needed")
    study = wear(contact, path, **given)
    cycles = study["cycles"].values
    late = np.flatnonzero(cycles >= _COMPARED_FROM * cycles[-1])
    rows = late[np.unique(np.linspace(late.size - 1, 0, min(steps, late.size)).round().astype(int))]
    counted = cycles[rows]
    options = [(rings // 2, _ends(counted, 2)), (rings, _ends(counted, 1))]
    total, done, volumes = sum(ends.size for _, ends in options), 0, []
    for number, ends in options:
        report = None if progress is None else partial(_report_progress, progress, done, total)
        fine = _by_rings(study, contact, path, number, ends, report)
        at, done = 1 + np.searchsorted(ends, counted), done + ends.size
        volumes.append(fine.volume[at])
    return WearVerification(
        contact=contact,
        data=_table(study, rows, fine, at),
        surface=_surface(study, fine),
        curves=study.data[["worn_volume"]],
        rings=rings,
        halved=float(np.max(np.abs(volumes[0] / volumes[1] - 1.0))),
    )


def _ends(rows: FloatArray, part: int) -> FloatArray:
    """Ends of blocks of cycles, those of the rows among them."""
    early = np.geomspace(1e-5, _COMPARED_FROM, _EARLY // part, endpoint=False)
    late = np.geomspace(_COMPARED_FROM, 1.0, _LATE // part + 1)
    return np.unique(np.concatenate([rows[-1] * np.concatenate([early, late[:-1]]), rows]))


def _report_progress(
    progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    progress(before + done, total)


def _by_rings(
    study: Wear,
    contact: Contact,
    path: LoadingPath,
    rings: int,
    ends: FloatArray,
    progress: Callable[[int, int], None] | None,
) -> WornRings:
    moduli, request, attrs = (
        effective_moduli(contact.body, contact.counterbody),
        one_cycle(path),
        study.data.attrs,
    )
    mu = float(attrs["friction_coefficient"])
    archard = float(attrs["coefficient"]) * (mu if attrs["law"] == "energy" else 1.0)
    widest = max(float(study[name].max()) for name in ("contact_radius", "worn_radius"))
    profile, stick = contact.profile, study["stick_radius"].values
    apex = float(profile.gap(0.0))
    return wear_by_rings(
        _edges(float(stick[0]), float(stick[-1]), min(_BEYOND * widest, profile.max_radius), rings),
        lambda r: profile.gap(r) - apex,
        (moduli.normal, moduli.tangential, mu),
        (request.indentation, request.normal_force),
        request.amplitude,
        archard,
        ends,
        progress,
    )


def _edges(first: float, last: float, end: float, rings: int) -> FloatArray:
    """Edges of rings, narrow about and between the first and last stick radius, where the pressure becomes infinite in the end."""
    if not first > 0.0:
        return np.linspace(0.0, end, rings + 1)
    moved = rings // 3 if last > first else 0
    inner = (rings - moved) // 2
    inside = first * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, inner + 1))
    between = np.linspace(first, last, moved + 1)
    outside = last + (end - last) * np.linspace(0.0, 1.0, rings - moved - inner + 1) ** 2
    return np.concatenate([inside[:-1], between[:-1], outside])


def _table(study: Wear, rows: np.ndarray, other: WornRings, at: np.ndarray) -> xr.Dataset:
    columns: dict[str, Any] = {"cycles": ("step", study["cycles"].values[rows], {"units": ""})}
    by_rings = {
        "worn_volume": other.volume,
        "worn_depth": other.worn.max(axis=1),
        "indentation": other.indentation,
        "normal_force": other.force,
    }
    for name in COMPARED:
        mdr, rings = study[name].values[rows], by_rings[name][at]
        unit = {"units": QUANTITIES[name].unit}
        columns |= {f"{name}_mdr": ("step", mdr, unit), f"{name}_rings": ("step", rings, unit)}
        columns[f"{name}_difference"] = ("step", rings / mdr - 1.0, {"units": ""})
    return xr.Dataset(columns)


def _surface(study: Wear, other: WornRings) -> xr.Dataset:
    """The depth of wear in the last row, at the middles of the rings."""
    r, depth = study.surface["r"].values[-1], study.surface["worn_depth"].values[-1]
    unit = {"units": "m"}
    return xr.Dataset(
        {
            "mdr": ("r", np.interp(other.radii, r, depth, left=depth[0]), unit),
            "rings": ("r", other.worn[-1], unit),
        },
        coords={"r": ("r", other.radii, unit)},
    )
