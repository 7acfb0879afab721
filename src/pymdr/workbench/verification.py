"""The method held against boundary elements on rings, side by side."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.independent.rings import Rings
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid, TransverselyIsotropic
from pymdr.problem.paths import LoadingPath, Path
from pymdr.quantities import QUANTITIES
from pymdr.result import Result
from pymdr.solving import solve
from pymdr.solving.closure import refuse_curve
from pymdr.units import FloatArray

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

COMPARED = ("normal_force", "contact_radius", "normal_stiffness", "elastic_energy")


@dataclass(frozen=True, eq=False)
class Verification:
    """Both solutions of some steps of a path."""

    table: xr.Dataset
    """Over ``step``: each quantity by the method (``_mdr``) and by rings (``_rings``), its relative
    difference (``_difference``), and the largest ``pressure_difference`` over the largest pressure."""
    pressures: xr.Dataset
    """Over ``r``, at the last step: ``mdr`` and ``rings`` in Pa."""
    rings: int
    """Number of rings."""

    @property
    def largest_difference(self) -> float:
        """The largest relative difference of the force; nan if the method was refused everywhere."""
        difference = np.abs(self.table["normal_force_difference"].values)
        return float(np.nanmax(difference)) if np.isfinite(difference).any() else math.nan

    def summary(self) -> str:
        """Both solutions side by side, as a text."""
        from pymdr.units import written

        lines = [f"MDR and boundary elements on {self.rings} rings, side by side:"]
        head = f"  {'indentation':>12}  {'quantity':<18}{'MDR':>14}{'rings':>14}{'difference':>13}"
        lines.append(head)
        for i in range(self.table.sizes["step"]):
            d = written(float(self.table["indentation"].values[i]), "m")
            for name in COMPARED:
                row = QUANTITIES[name]
                mdr, rings, difference = (
                    float(self.table[f"{name}_{end}"].values[i]) for end in ("mdr", "rings", "difference")
                )
                lines.append(
                    f"  {d:>12}  {row.words:<18}{written(mdr, row.unit):>14}{written(rings, row.unit):>14}"
                    f"{'-' if math.isnan(difference) else f'{difference:.1e}':>13}"
                )
                d = ""
            p = float(self.table["pressure_difference"].values[i])
            lines.append(
                f"  {'':>12}  {'pressure, 0.05 a < r < 0.9 a, over its largest value':<46}"
                f"{'-' if math.isnan(p) else f'{p:.1e}':>13}"
            )
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """The summary, for notebooks."""
        from pymdr.presentation.html import text_html

        return text_html(self.summary())

    def plot(self) -> Figure:
        """Both pressures over the radius, and their difference."""
        from pymdr.presentation.plot import compared_pressures

        return compared_pressures(self.pressures)


def verify(
    contact: Contact,
    path: LoadingPath,
    *,
    rings: int = 400,
    steps: int = 5,
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """
    Solve some steps of a path both by the method and by boundary elements on rings.

    Parameters
    ----------
    contact : Contact
    path : LoadingPath
    rings : int
        Number of rings, 20 to 5000.
    steps : int
        How many steps, spread evenly over those of the path, are solved by rings.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    Verification
        Where the method is refused its values are NaN.

    Raises
    ------
    ProblemError, PathError, ConvergenceError
        As :func:`pymdr.solve`.

    Examples
    --------
    >>> from pymdr import Elastic, Paraboloid, indent
    >>> ball = Contact(Paraboloid("10 mm"), Elastic("1 MPa", 0.5))
    >>> verify(ball, indent("0.1 mm"), rings=100).largest_difference < 1e-5
    True
    """
    refuse_curve(contact, "verify", "boundary elements need its shape")
    if contact.adhesion is not None or contact.friction is not None:
        raise ProblemError(
            "verify: rings solve the frictionless contact without adhesion; friction is held against vector friction by "
            "verify_sliding(contact, path), adhesion has no independent solver here"
        )
    if not all(
        isinstance(one, Elastic | TransverselyIsotropic | Rigid)
        for one in (contact.body, contact.counterbody)
    ):
        raise ProblemError(
            "verify: the rings know homogeneous elastic half-spaces; graded bodies and bodies with memory have no independent "
            "solver here"
        )
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise PathError(f"verify: steps = {steps!r}; a whole number of at least 1 is needed")
    whole = solve(contact, path)
    depths = _depths(whole)
    if depths.size == 0:
        raise PathError("verify: the path makes no contact at any step")
    chosen = depths[np.unique(np.linspace(0, depths.size - 1, min(steps, depths.size)).round().astype(int))]
    route = Path(indentation=chosen)
    mdr = solve(contact, route)
    ring = solve(contact, route, solver=Rings(rings), progress=progress)
    columns: dict[str, FloatArray] = {}
    for name in COMPARED:
        a = mdr.data[name].values if name in mdr.data else np.full(chosen.size, math.nan)
        b = ring.data[name].values
        columns |= {f"{name}_mdr": a, f"{name}_rings": b, f"{name}_difference": a / b - 1.0}
    columns["pressure_difference"] = np.array(
        [_pressure_difference(mdr, ring, i) for i in range(chosen.size)]
    )
    return Verification(_table(chosen, columns), _pressures(mdr, ring), rings)


def _depths(result: Result) -> FloatArray:
    """Indentations of the steps in contact, rising."""
    if "indentation" not in result.data:
        raise PathError(
            "verify: the method gives no indentation for this load; prescribe indentations instead"
        )
    d = result.data["indentation"].values
    return np.unique(d[np.isfinite(d) & (result.data["force_lower_bound"].values > 0.0)])


def _table(depths: FloatArray, columns: dict[str, FloatArray]) -> xr.Dataset:
    import xarray as xr

    units = {name: QUANTITIES[name].unit for name in COMPARED}
    variables = {
        name: (
            "step",
            values,
            {"units": next((u for q, u in units.items() if name in (f"{q}_mdr", f"{q}_rings")), "")},
        )
        for name, values in columns.items()
    }
    return xr.Dataset({"indentation": ("step", depths, {"units": "m"}), **variables})


def _radii(ring: Result, step: int) -> FloatArray:
    a = float(ring.data["contact_radius"].values[step])
    return np.linspace(0.05, 0.9, 60) * a


def _pressure_difference(mdr: Result, ring: Result, step: int) -> float:
    if not mdr.claims["pressure"].where[step] or ring.data["contact_radius"].values[step] == 0.0:
        return math.nan
    r = _radii(ring, step)
    by_mdr, by_rings = (result.field("pressure", r=r, step=step).values for result in (mdr, ring))
    return float(np.max(np.abs(by_mdr - by_rings)) / np.max(np.abs(by_rings)))


def _pressures(mdr: Result, ring: Result) -> xr.Dataset:
    import xarray as xr

    valid = np.flatnonzero(mdr.claims["pressure"].where)
    step = int(valid[-1]) if valid.size else ring.data.sizes["step"] - 1
    r = ring.surface.default_radii(step)
    by_rings = ring.field("pressure", r=r, step=step).values
    by_mdr = mdr.field("pressure", r=r, step=step).values if valid.size else np.full(r.shape, math.nan)
    return xr.Dataset(
        {"mdr": ("r", by_mdr, {"units": "Pa"}), "rings": ("r", by_rings, {"units": "Pa"})},
        coords={"r": ("r", r, {"units": "m"})},
        attrs={"indentation": float(ring.data["indentation"].values[step])},
    )
