"""Stress in a half-space by the method and by a double integral of point loads over its surface, at a few points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pymdr.deferred import xr
from pymdr.independent.point_loads import stress_of_tractions
from pymdr.interpretation.interior import SPATIAL_COMPONENTS, Interior
from pymdr.interpretation.layered_stress import LayeredInterior
from pymdr.interpretation.solids import IsotropicSolid
from pymdr.interpretation.validity import Claim
from pymdr.result import Result
from pymdr.units import FloatArray

_ACROSS = 0.6, 0.3
"""Position x and y of the points over the loaded radius, where no component vanishes."""
_DEPTHS = 0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.5
"""Depths of the points over the loaded radius; the double integral needs many nodes near the surface."""
_CURVE = 121
"""Points of the drawn curve."""
_NODES = 24, 48, 96, 192
"""Nodes of the double integral between two radii, doubled until it agrees with itself."""
_AGREED = 1e-11
"""Relative change at which the double integral is taken."""
_MOST_POINT_LOADS = 400_000
_MOST_RINGS = 24
"""Rings of the shear traction at which the double integral is divided; a history of more is integrated across some of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Subsurface:
    """The stress on a line into the body by the method and by point loads, under the same pressure and shear traction."""

    data: xr.Dataset | None = None
    """``mdr`` and ``point_loads`` in Pa over ``component`` and ``z``, ``curve`` by the method over ``component`` and ``depth``; single
    values ``x`` and ``y`` in m, and ``step``. None if they are not compared."""
    claim: Claim
    """Of the stress."""
    integral_error: float = math.nan
    """Change of the double integral when its nodes were doubled, over the largest stress."""
    reason: str = ""
    """Why they are not compared."""

    @property
    def largest_difference(self) -> float:
        """The largest difference of a component over the largest of all; nan if they are not compared."""
        if self.data is None:
            return math.nan
        mdr, other = (self.data[name].values for name in ("mdr", "point_loads"))
        return float(np.max(np.abs(mdr - other)) / np.max(np.abs(other)))

    def remarks(self) -> list[str]:
        """Lines of a summary."""
        if self.data is None:
            return [f"stress in the body: not compared, {self.reason}"]
        error = self.claim.error
        claimed = "error not known" if error is None else f"error {error[int(self.data['step'])]:.1g}"
        return [
            f"stress in the body: six components at {self.data.sizes['z']} depths, by a double integral of point loads under the "
            "same surface tractions",
            f"largest difference of stresses over their largest value: {self.largest_difference:.1e} (claim {self.claim.level.name}, "
            f"{claimed}; change of the integral with twice the nodes {self.integral_error:.1e})",
        ]

    def as_json(self) -> dict[str, Any]:
        """Numbers for machines; nothing but the reason if they are not compared."""
        if self.data is None:
            return {"reason": self.reason}
        return {
            "largest_difference": self.largest_difference,
            "claim": self.claim.level.name,
            "integral_error": self.integral_error,
        }


def drawn_stress(subsurface: Subsurface | None) -> xr.Dataset | None:
    """What a figure shows of a comparison, if there is one."""
    return None if subsurface is None else subsurface.data


def compare_subsurface(result: Result, rows: Sequence[int] | np.ndarray) -> Subsurface:
    """
    Compare the stress in the body of a result with a double integral of point loads, at the last of some rows that has one.

    Notes
    -----
    The pressure and the shear traction are those of the result, so that the integral tests the way from the surface into the body;
    boundary elements test the tractions.
    """
    claim = result.claims["stress"]
    valid = [int(row) for row in rows if claim.where[row] and result.data["contact_radius"].values[row] > 0.0]
    if not claim.readable or not valid or result.reading.interior is None:
        reason = "the method gives none" if claim.readable else claim.reason
        return Subsurface(claim=claim, reason=reason)
    interior, step = result.reading.interior(result, None), valid[-1]
    if isinstance(interior, LayeredInterior):
        return Subsurface(claim=claim, reason="point loads act on half-spaces, and the body has layers")
    if not isinstance(interior.solid, IsotropicSolid):
        return Subsurface(claim=claim, reason="point loads act on isotropic bodies here")
    return _compared(result, interior, interior.solid.poisson, step, claim)


def _compared(result: Result, interior: Interior, poisson: float, step: int, claim: Claim) -> Subsurface:
    radius = interior.load(step).radius
    x, y = (place * radius for place in _ACROSS)
    depths = radius * np.array(_DEPTHS)
    other, error = _by_point_loads(
        result, interior, np.array([(x, y, depth) for depth in depths]), poisson, step
    )
    fine = np.linspace(0.0, 1.04 * depths[-1], _CURVE)

    def by_mdr(z: FloatArray) -> FloatArray:
        return result.field("stress", x=[x], y=[y], z=z, step=step).values.reshape(len(other), z.size)

    unit = {"units": "Pa"}
    data = xr.Dataset(
        {
            "mdr": (("component", "z"), by_mdr(depths), unit),
            "point_loads": (("component", "z"), other, unit),
            "curve": (("component", "depth"), by_mdr(fine), unit),
        },
        coords={
            "component": list(SPATIAL_COMPONENTS["stress"]),
            "z": ("z", depths, {"units": "m"}),
            "depth": ("depth", fine, {"units": "m"}),
            "x": ((), x, {"units": "m"}),
            "y": ((), y, {"units": "m"}),
            "step": step,
        },
    )
    return Subsurface(data=data, claim=claim, integral_error=error)


def _by_point_loads(
    result: Result, interior: Interior, points: FloatArray, poisson: float, step: int
) -> tuple[FloatArray, float]:
    """The stress in Pa at points in m, and its change with twice the nodes."""
    loads = interior.surface.loads(step)
    edge = max(loads.normal.radius, loads.normal.edge_radius)
    marks = {*interior.marks(step)}
    if loads.shear is not None:
        rings = sorted(
            {segment.anchor for segment in loads.shear.segments} | {ring for ring, _ in loads.shear.rings}
        )
        marks |= {*rings[:: math.ceil(len(rings) / _MOST_RINGS)]} if rings else set()
    # radii that rounding alone separates are one
    inner = sorted(mark for mark in marks if 1e-9 * edge < mark < (1.0 - 1e-9) * edge)
    radii = [mark for mark, before in zip(inner, [0.0, *inner], strict=False) if mark - before > 1e-9 * edge]

    def pressure(r: FloatArray) -> FloatArray:
        return result.field("pressure", r, step).values

    def traction(r: FloatArray) -> FloatArray:
        if loads.shear is None:
            return np.zeros(r.shape)
        return interior.sign * result.field("shear_traction", r, step).values

    stress, error = np.full((6, len(points)), math.nan), math.inf
    for n in _NODES:
        if math.isfinite(error) and 2 * n * n * (len(radii) + 1) > _MOST_POINT_LOADS:
            break
        before, stress = stress, stress_of_tractions([*radii, edge], pressure, traction, points, poisson, n=n)
        change = np.max(np.abs(stress - before)) / np.max(np.abs(stress))
        error = float(change) if np.isfinite(change) else math.inf
        if error < _AGREED:
            break
    return stress, error
