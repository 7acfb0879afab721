"""Results of contacts that are known by their force curve only."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import ConvergenceError, PathError
from pymdr.interpretation.closure import OF_THE_CURVE, Slip, closure_claims, regrown
from pymdr.interpretation.traction import curves_down_to
from pymdr.interpretation.validity import Claim
from pymdr.line.friction import opposed_parts
from pymdr.mapping.closure import closure_of
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.profiles import ForceCurve
from pymdr.problem.schedule import planned
from pymdr.result import Reading, Result, Status
from pymdr.solving.mapped import map_to_springs
from pymdr.solving.walk import Task, prescribed_rows
from pymdr.units import FloatArray, metres

if TYPE_CHECKING:
    from xarray import DataArray


_TIMES = ("time", "jumped")
_FINE = 400


def solve_on_curve(history: Callable[[Task], Result], task: Task) -> Result:
    """Follow a law on the line of a force curve; keep the quantities that the curve determines, with claims."""
    curve = task.contact.profile
    assert isinstance(curve, ForceCurve)
    try:
        result = history(task)
    except ConvergenceError as error:
        deepest = closure_of(curve).deepest
        raise PathError(
            f"the force curve ends at an indentation of {metres(deepest)} and is not extrapolated, so the path cannot be followed: {error}"
        ) from error
    data = result.data
    again = (
        regrown(data["contact_radius"].values)
        if task.contact.is_viscoelastic and "contact_radius" in data
        else None
    )
    claims = closure_claims(
        result.claims,
        closure_of(curve),
        data["indentation"].values,
        again,
        sheared=result.contact.friction is not None,
        prescribed=prescribed_rows(task),
        balance=_balance(task, result),
        slip=_slip(result),
    )
    kept = data.drop_vars([name for name in data if not _is_determined(str(name), claims)])
    return replace(
        result,
        data=kept.map(lambda column: _where_determined(column, claims.get(str(column.name)))),
        claims=claims,
        status=Status.OF_A_CURVE if result.status is Status.COMPLETED else result.status,
        references=(*result.references, "closure"),
    )


def _balance(task: Task, result: Result) -> FloatArray | None:
    """
    The largest work mu F_N |du| of the rows so far and stored energy mu^2 (E*/G*) U, over the dissipated energy, shape (2, n).

    None without slip or with a memory, if a tangential force is prescribed, whose shift is not known exactly, or if not every row is kept.
    """
    friction, data = result.contact.friction, result.data
    if friction is None or not math.isfinite(friction.coefficient) or result.contact.is_viscoelastic:
        return None
    shifted = "shift" in data and all(leg.controls.tangential == "shift" for leg in planned(task.path))
    if not shifted or task.keep is not None:
        return None
    shift, load = data["shift"].values.reshape(data.sizes["step"], -1), data["normal_force"].values
    path = np.linalg.norm(np.diff(shift, axis=0, prepend=0.0), axis=1)
    moduli = effective_moduli(result.contact.body, result.contact.counterbody)
    mu, ratio = friction.coefficient, moduli.normal / moduli.tangential
    work = np.cumsum(mu * np.maximum(load, np.append(0.0, load[:-1])) * path)
    stored = mu**2 * ratio * data["elastic_energy"].values
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.array([work, stored]) / data["dissipated_energy"].values)


def _opposed(result: Result) -> dict[str, FloatArray]:
    """Magnitudes of all parts over those of their sums; empty where the stack of turning points along a line is not known."""
    friction, data = result.contact.friction, result.data
    if friction is None or not 0.0 < friction.coefficient < math.inf or result.contact.is_viscoelastic:
        return {}
    if "indentation" not in data or "shift" not in data or data["shift"].ndim != 1:
        return {}
    depth, shift = data["indentation"].values, data["shift"].values
    if not np.isfinite([depth, shift]).all():
        return {}
    moduli = effective_moduli(result.contact.body, result.contact.counterbody)
    curves = curves_down_to(map_to_springs(result.contact).line, float(depth.max(initial=0.0)))
    parts = opposed_parts(curves, depth, shift, friction.coefficient, moduli.tangential)
    return dict(zip(("tangential_force", "stored_tangential_energy"), parts, strict=True))


def _slip(result: Result) -> Slip | None:
    """What slips in the rows; None without friction."""
    if "stick_radius" not in result.data:
        return None
    line = equivalent_profile(result.contact.profile)
    radius = np.nan_to_num(result.data["stick_radius"].values)
    return Slip(line.g(np.minimum(radius, line.max_radius)), _opposed(result))


def _is_determined(name: str, claims: Mapping[str, Claim]) -> bool:
    """Whether a column is a time, or determined by the points of the curve."""
    return name in _TIMES or (name in OF_THE_CURVE and (name not in claims or claims[name].readable))


def _where_determined(column: DataArray, claim: Claim | None) -> DataArray:
    """A column, NaN in the rows that the points do not determine."""
    if claim is None or claim.where.all():
        return column
    return column.where(column["step"].copy(data=claim.where))


def reading_of(reading: Reading) -> Reading:
    """The reading of a result of a force curve, without fields on its line."""
    reason = "the line of a force curve does not show the shape of the contact; equivalent_profile(contact.profile).g(x) gives the line"
    return replace(
        reading,
        line_fields=(),
        plots=curve_plots,
        elsewhere={**reading.elsewhere, **dict.fromkeys(reading.line_fields, reason)},
    )


def curve_plots(result: Result, row: int) -> plot.Plots:
    """Figures: the points with their curve, the line, and the solution."""
    curve = result.contact.profile
    assert isinstance(curve, ForceCurve)
    viscoelastic = result.contact.is_viscoelastic
    # bodies with memory have no single modulus: the curve is drawn as given
    modulus = (
        curve.modulus
        if viscoelastic
        else effective_moduli(result.contact.body, result.contact.counterbody).normal
    )
    scale = modulus / curve.modulus
    known = closure_of(curve)
    depth = known.deepest * np.linspace(0.0, 1.0, _FINE) ** 2
    stiffness, force, _ = scale * known.stiffness.at(depth)
    line = equivalent_profile(curve)
    x = np.linspace(0.0, line.max_radius, _FINE)
    drawn = plot.CurveData(
        points=(curve.indentation - known.contact_point, scale * curve.force),
        depth=depth,
        force=force,
        stiffness=stiffness,
        line=(x, np.minimum(line.g(x), known.deepest)),
        modulus=modulus,
        is_viscoelastic=viscoelastic,
    )
    data = plot.FigureData(
        data=result.data, row=row, field=None, gap=curve.gap, bands={}, on_line=False, modulus=modulus
    )
    return plot.Plots(
        data, partial(plot.closure_overview, curve=drawn), partial(plot.closure_figures, curve=drawn)
    )
