"""Bodies that are not of revolution, along a path: exact ellipses, pyramids, bounds and estimates for others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.ellipses import EllipseSurface
from pymdr.interpretation.shapes import LowerBound, shape_assumptions, shape_claims, shape_theory
from pymdr.interpretation.thickness import thickness_assumption
from pymdr.interpretation.validity import Assumption, BoolArray, Claim
from pymdr.line.ellipses import ellipse_bounds
from pymdr.line.foundation import (
    ElasticLine,
    normal_force,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.line.shapes import ShapeLaw, ShapeStates, shape_law
from pymdr.mapping.azimuth import azimuthal_mean, mean_error
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import EllipticParaboloid, Profile, Shape
from pymdr.problem.schedule import Stretch
from pymdr.result import FieldReader, Result, Status
from pymdr.rows import taken
from pymdr.solving.mapped import refuse_unreachable
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.walk import (
    Channels,
    Interpretation,
    LegProgress,
    Task,
    Walked,
    channels_at,
    solution,
    walk,
    with_travel,
)
from pymdr.units import FloatArray, metres

if TYPE_CHECKING:
    pass

_STEPS = 200
_SETTLED = 1e-13
_FINE = 160
_ALIKE = 1e-6
"""Relative margin by which an ellipse must exceed a disk."""


@dataclass(frozen=True)
class Pressed:
    """Step 1: the shape as a law, and the line of its lower bound, both for the modulus of the bodies."""

    shape: Shape
    law: ShapeLaw
    mean: Profile
    bound: ElasticLine
    modulus: float
    """E* in Pa."""

    def at(self, depth: FloatArray) -> ShapeStates:
        """States over E*."""
        return self.law.at(depth, self.disks(depth))

    def disks(self, depth: FloatArray) -> FloatArray:
        """Radii in m of the disks of the lower bound, centred at the apex."""
        return states_at_depth(self.bound, depth).contact_radius

    def bounds(self, depth: FloatArray) -> LowerBound:
        """The lower bound of the force over E*: the best ellipse where the law is not known."""
        disks = states_at_depth(self.bound, depth)
        force = normal_force(self.bound, disks) / self.modulus
        error = np.full(force.shape, 2.0 * mean_error(self.shape))
        if self.law.known:
            return LowerBound(force, error, force, None)
        ellipses = ellipse_bounds(self.shape, depth, disks.contact_radius)
        better = ellipses.force * (1.0 - ellipses.error) > force * (1.0 + _ALIKE)
        return LowerBound(
            np.where(better, ellipses.force, force),
            np.where(better, ellipses.error, error),
            force,
            ellipses if better.any() else None,
        )


@dataclass(frozen=True)
class _Rows:
    indentation: FloatArray
    states: ShapeStates
    radius: FloatArray
    """Radius in m of the disk of the bound."""
    prescribed: FloatArray
    """The force where it is prescribed, else NaN."""
    moved: BoolArray
    """Whether the indentation is prescribed."""


def pressed(contact: Contact) -> Pressed:
    """Step 1 of a contact whose body is not of revolution."""
    shape = contact.profile
    assert isinstance(shape, Shape)
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    mean = azimuthal_mean(shape)
    return Pressed(shape, shape_law(shape), mean, ElasticLine(equivalent_profile(mean), modulus), modulus)


def solve_shape(task: Task) -> Result:
    """Map, walk and interpret."""
    if task.solver is not None:
        raise ProblemError(
            f"the rings of solver=Rings() are of revolution, and {type(task.contact.profile).__name__} is not; leave it out"
        )
    check_normal_path(task.path)
    pressed_shape = pressed(task.contact)
    walked = walk(task, None, partial(_step, task, pressed_shape))
    return solution(task, walked, _interpret(task, pressed_shape, walked))


def _step(
    task: Task,
    pressed_shape: Pressed,
    _: None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Rows, None, Channels]:
    targets, stiffness = stretch.normal, task.machine_stiffness
    moved = False
    if stretch.by_force:
        refuse_tension(stretch.leg, targets)
        start = states_at_force(pressed_shape.bound, targets)
        depth = _depths(pressed_shape, start.indentation, targets, None)
    elif stretch.controls.normal == "travel" and stiffness is not None and math.isfinite(stiffness):
        start = states_at_travel(pressed_shape.bound, targets, stiffness)
        depth = _depths(pressed_shape, start.indentation, targets, 1.0 / stiffness)
    else:
        moved, depth = True, targets
    disks = states_at_depth(pressed_shape.bound, depth)
    most = float(np.max(targets)) if stretch.by_force else None
    refuse_unreachable(pressed_shape.bound, pressed_shape.mean, disks, most)
    states = pressed_shape.at(depth)
    force = float(targets[-1]) if stretch.by_force else pressed_shape.modulus * float(states.force[-1])
    here = channels_at(float(depth[-1]), force, stiffness)
    if math.isnan(force):  # a leg that holds an unknown force cannot be followed
        here = {"indentation": float(depth[-1]), "normal_force": math.nan, "travel": math.nan}
    rows = _Rows(
        np.asarray(depth, dtype=float),
        states,
        disks.contact_radius,
        targets if stretch.by_force else np.full(targets.size, math.nan),
        np.full(targets.size, moved),
    )
    return taken(rows, kept), None, here


def _depths(
    pressed_shape: Pressed, start: FloatArray, targets: FloatArray, compliance: float | None
) -> FloatArray:
    """
    Depths at prescribed forces, or at prescribed travels of a machine with a compliance.

    The bound carries less than the body, so its depths are not smaller; the force is convex, so Newton's steps from there do not
    pass the root.
    """
    d = np.array(start, dtype=float)
    touching = (d > 0.0) & (targets > 0.0)
    d[~touching] = np.minimum(d[~touching], 0.0) if compliance is None else targets[~touching]
    if not touching.any():
        return d
    x, target = d[touching], targets[touching]
    for _ in range(_STEPS):
        states = pressed_shape.at(x)
        force, stiffness = pressed_shape.modulus * states.force, pressed_shape.modulus * states.stiffness
        if np.isnan(force).any():
            raise PathError(
                f"at an indentation of {metres(float(x[np.isnan(force)][0]))} there is no estimate of the force, and the lower bound alone gives no indentation for "
                "a prescribed force or travel; prescribe the indentation, or a smaller load"
            )
        if compliance is None:
            step = (force - target) / stiffness
        else:
            step = (x + compliance * force - target) / (1.0 + compliance * stiffness)
        new = np.clip(x - step, 0.1 * x, 2.0 * x)
        if np.all(np.abs(new - x) <= _SETTLED * x):
            d[touching] = new
            return d
        x = new
    raise ConvergenceError(
        f"the search for the indentation at the prescribed force or travel did not converge (last value {metres(float(x[-1]))}); prescribe the indentation"
    )


def _interpret(task: Task, pressed_shape: Pressed, walked: Walked[_Rows]) -> Interpretation:
    rows, shape, modulus = walked.rows, pressed_shape.shape, pressed_shape.modulus
    states, d = rows.states, rows.indentation
    by_force = np.isfinite(rows.prescribed)
    force = np.where(by_force, rows.prescribed, modulus * states.force)
    prescribed = {"indentation": rows.moved, "normal_force": by_force}
    bounds = pressed_shape.bounds(d)
    states = states.above(bounds.force)
    claims = shape_claims(shape, states, bounds, prescribed)
    columns: dict[str, FloatArray] = {
        "indentation": d,
        "normal_force": force,
        "normal_stiffness": modulus * states.stiffness,
        "elastic_energy": modulus * states.energy,
        "force_lower_bound": modulus * bounds.force,
        "force_estimate": modulus * states.estimate,
    }
    axes = pressed_shape.law.semi_axes(d)
    if axes is not None:
        columns |= _of_ellipse(*axes, force)
    if task.machine_stiffness is not None:
        claims["travel"] = claims["normal_force"]
    return Interpretation(
        columns=with_travel(task, columns),
        claims=claims,
        assumptions=(*_assumed(task.contact, pressed_shape, rows), *thickness_assumption(task.contact, 0.0)),
        status=_status(pressed_shape.law, claims),
        notes=(),
        references=shape_theory(shape).references,
        conducting=0.5 * states.stiffness,
    )


def _of_ellipse(a_x: FloatArray, a_y: FloatArray, force: FloatArray) -> dict[str, FloatArray]:
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(a_x > 0.0, force / (math.pi * a_x) / a_y, 0.0)
    return {
        "semi_axis_x": a_x,
        "semi_axis_y": a_y,
        "contact_area": math.pi * a_x * a_y,
        "mean_pressure": mean,
        "peak_pressure": 1.5 * mean,
    }


def _assumed(contact: Contact, pressed_shape: Pressed, rows: _Rows) -> tuple[Assumption, ...]:
    """Assumptions of the model, measured where the contact is largest."""
    beta = effective_moduli(contact.body, contact.counterbody).dundurs_beta
    longest = rows.states.longest
    size = float(np.nanmax(np.where(np.isnan(longest), rows.radius, longest), initial=0.0))
    if size == 0.0:
        return ()
    return shape_assumptions(*pressed_shape.law.slopes(rows.indentation, size), beta)


def _status(law: ShapeLaw, claims: dict[str, Claim]) -> Status:
    if law.known:
        return Status.NOT_ROUND
    known = claims["force_estimate"]
    return Status.ESTIMATED if known.readable and known.where.all() else Status.BOUNDED


def shape_surface(result: Result) -> FieldReader:
    """The surface from which fields are computed, for elliptic paraboloids only."""
    shape, data = result.contact.profile, result.data
    assert isinstance(shape, EllipticParaboloid)
    d, a_x, a_y, force = (
        data[name].values for name in ("indentation", "semi_axis_x", "semi_axis_y", "normal_force")
    )
    modulus = effective_moduli(result.contact.body, result.contact.counterbody).normal
    return EllipseSurface(shape, modulus, d, a_x, a_y, force)


def _trial(bound: LowerBound, disk: float) -> tuple[float, float, float, float, float]:
    """The ellipse or disk of the lower bound: centre, semi-axes and direction of the first."""
    best = bound.ellipses
    if best is None:
        return 0.0, 0.0, disk, disk, 0.0
    return (
        float(best.x[0]),
        float(best.y[0]),
        float(best.longer[0]),
        float(best.shorter[0]),
        float(best.angle[0]),
    )


def shape_plots(result: Result, row: int) -> plot.Plots:
    """Figures: force with its bound and its estimate, and the contact in plan."""
    pressed_shape = pressed(result.contact)
    shape, data = pressed_shape.shape, result.data
    deepest = float(np.nanmax(data["indentation"].values, initial=0.0))
    depth = deepest * np.linspace(0.0, 1.0, _FINE) ** 2
    bound = pressed_shape.bounds(depth).force
    states = pressed_shape.at(depth).above(bound)
    d = np.array([float(data["indentation"].values[row]) if row >= 0 else deepest])
    disk = float(pressed_shape.disks(d)[0])
    axes = pressed_shape.law.semi_axes(d)
    longest = float(np.nanmax(pressed_shape.at(d).longest, initial=disk))
    drawn = plot.ShapeData(
        depth=depth,
        force=pressed_shape.modulus * states.force,
        bound=pressed_shape.modulus * bound,
        estimate=pressed_shape.modulus * states.estimate,
        source=pressed_shape.law.source,
        gap=shape.gap_at,
        level=float(d[0]),
        trial=_trial(pressed_shape.bounds(d), disk),
        axes=None if axes is None else (float(axes[0][0]), float(axes[1][0])),
        extent=1.5 * max(longest, disk),
        across=(lambda r: result.field("pressure", r, row, angle="90 deg")) if row >= 0 else None,
    )
    shown = plot.FigureData(
        data=data,
        row=row,
        field=(lambda name, r: result.field(name, r, row)) if row >= 0 else None,
        gap=lambda r: shape.gap_at(r, 0.0 * r),
        bands={},
        on_line=False,
        modulus=pressed_shape.modulus,
    )
    return plot.Plots(
        shown, partial(plot.shape_overview, shape=drawn), partial(plot.shape_figures, shape=drawn)
    )
