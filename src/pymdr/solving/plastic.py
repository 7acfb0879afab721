"""The contact of a ball that yields along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import scipy

from pymdr.errors import NotValidError, PathError, ProblemError
from pymdr.interpretation.plastic import NO_FIELDS, plastic_assumptions, plastic_claims
from pymdr.interpretation.validity import NORMAL_FIELDS, Claim
from pymdr.line.foundation import mean_pressure
from pymdr.line.plastic import (
    DEEPEST,
    Ball,
    Ellipse,
    GrowingBall,
    Growth,
    follow_edge,
    start_of_edge,
)
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import Sampled
from pymdr.problem.schedule import Stretch
from pymdr.result import FieldReader, Result, Status
from pymdr.result.rows import row_indices
from pymdr.solving.normal import check_normal_path, refuse_tangential, refuse_tension
from pymdr.solving.walk import (
    Channels,
    Interpretation,
    LegProgress,
    Task,
    Walked,
    channels_at,
    prescribed_rows,
    solution,
    walk,
    with_travel,
)
from pymdr.units import FloatArray, metres, newtons

if TYPE_CHECKING:
    pass

WITHOUT_FIELDS = dict.fromkeys(NORMAL_FIELDS, NO_FIELDS)
"""Why there are no fields."""
_FINE, _SAMPLES = 200, 600


@dataclass(frozen=True)
class _Rows:
    indentation: FloatArray
    largest: FloatArray
    """Largest indentation up to the row in m, of the apparent ball if its radius grows."""
    normal_force: FloatArray
    contact_radius: FloatArray
    apparent_radius: FloatArray
    residual_indentation: FloatArray
    normal_stiffness: FloatArray
    elastic_energy: FloatArray
    external_work: FloatArray
    """Work in J done on the contact."""
    yielding: FloatArray


@dataclass(frozen=True)
class _State:
    largest: float = 0.0
    edge: tuple[float, float] = start_of_edge()
    """With adhesion: contact radius in m, and energy in J dissipated by the edge."""


def ball_of(contact: Contact) -> Ball:
    """Step 1: the ball that yields."""
    body, radius = contact.plastic, contact.profile.curvature_radius
    assert body is not None
    assert radius is not None
    return Ball(
        radius, body.effective_modulus, body.shear, body.poisson, body.yield_strength, body.wall_factor
    )


def solve_plastic(task: Task) -> Result:
    """Map, walk and interpret."""
    body = task.contact.plastic
    assert body is not None
    if task.solver is not None:
        raise ProblemError(
            "solver=Rings() solves elastic bodies, but a body is ElasticPlastic; leave solver out"
        )
    if task.contact.adhesion is None:
        check_normal_path(task.path)
    else:
        refuse_tangential(task.path, "friction of a body that yields is not available; leave the channel out")
    ball = ball_of(task.contact)
    if body.apparent_radius:
        growing = GrowingBall(ball)
        return solution(
            task, *_with_claims(task, ball, walk(task, growing.start, partial(_grow, task, growing)))
        )
    return solution(task, *_with_claims(task, ball, walk(task, _State(), partial(_step, task, ball))))


def _compliance(task: Task, stretch: Stretch) -> float | None:
    """Compliance in m/N of the machine; None for prescribed forces."""
    if stretch.by_force:
        if task.contact.adhesion is None:
            refuse_tension(stretch.leg, stretch.normal)
        return None
    machine = task.machine_stiffness
    return 0.0 if stretch.controls.normal != "travel" or machine is None else 1.0 / machine


def _step(
    task: Task,
    ball: Ball,
    state: _State,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Rows, _State, Channels]:
    """Step 2: a row follows from its channel and the largest indentation before; with adhesion also from its edge."""
    targets, compliance = stretch.normal, _compliance(task, stretch)
    adhesion = task.contact.adhesion
    if compliance == 0.0:
        d, largest = targets, np.maximum(np.maximum.accumulate(targets), state.largest)
    else:
        d, largest = ball.follow(
            np.maximum(targets, 0.0) if stretch.by_force else targets, compliance, state.largest
        )
    if np.max(largest) > DEEPEST * ball.radius:
        _refuse_too_deep(ball, stretch, targets)
    edge, dissipated = state.edge, np.zeros(d.shape)
    if adhesion is None:
        force, radius = ball.force(d, largest), ball.contact_radius(d, largest)
        energy, stiffness = ball.elastic_energy(d, largest), ball.stiffness(d, largest)
    else:
        followed, edge = follow_edge(ball, adhesion.work, d, largest, state.edge, targets, compliance)
        d, radius, force, energy, dissipated = followed
        stiffness = 2.0 * ball.modulus * radius / ball.scale(largest)
    if stretch.by_force:
        force = np.where(np.isnan(d), math.nan, targets)
    before = np.append(state.largest, largest[:-1])
    here = channels_at(float(d[-1]), float(force[-1]), task.machine_stiffness)
    result = _Rows(
        d,
        largest,
        force,
        radius,
        np.full(d.shape, ball.radius),
        ball.residual(largest),
        stiffness,
        energy,
        np.where(np.isnan(d), 0.0, energy) + ball.dissipation(largest) + dissipated,
        ball.yielded(largest) * (largest > before),
    )
    return result, _State(float(largest[-1]), edge), here


def _grow(
    task: Task,
    growing: GrowingBall,
    state: Growth,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Rows, Growth, Channels]:
    """Step 2 with a growing radius: every row is a step of a particle code."""
    compliance, top = _compliance(task, stretch), DEEPEST * growing.ball.radius
    rows, states = [], []
    by_force, machine = compliance is None, compliance or 0.0
    for target in stretch.normal.tolist():
        if compliance == 0.0:
            step = growing.advance(state, target) if target <= top else None
        elif by_force:
            step = growing.advance_to(state, target, lambda row: row.force, 0.0)
        else:
            step = growing.advance_to(
                state, target, lambda row: row.indentation + machine * row.force, min(target, 0.0)
            )
        if step is None:
            _refuse_too_deep(growing.ball, stretch, stretch.normal)
        row, state = step
        rows.append(row)
        states.append((state.largest, state.work))
    d, force, radius, height, width, within, scale, residual, yielding = np.array(rows, dtype=float).T
    largest, work = np.array(states).T
    ball, line = growing.ball, Ellipse(height, width, growing.ball.modulus)
    wall, a = ball.wall(d), line.contact_radius(within)
    stiffness = 2.0 * ball.modulus * a / scale * wall + ball.wall_rate(d) * force
    here = channels_at(float(d[-1]), float(force[-1]), task.machine_stiffness)
    force = stretch.normal if by_force else force
    energy = scale * wall * line.energy(within)
    result = _Rows(d, largest, force, a, radius, residual, stiffness, energy, work, yielding)
    return result, state, here


def _refuse_too_deep(ball: Ball, stretch: Stretch, targets: FloatArray) -> NoReturn:
    deepest, most = DEEPEST * ball.radius, float(np.max(targets))
    force = float(ball.loading_force(np.array(deepest)))
    name = stretch.controls.normal
    given = newtons(most) if stretch.by_force else metres(most)
    raise PathError(
        f"{name} = {given}: the model of a body that yields ends at an indentation of {metres(deepest)}, {DEEPEST:g} of the radius of the "
        f"ball (normal force about {newtons(force)}); reduce the {name.replace('normal_', '')}"
    )


def _where_known(claim: Claim, column: FloatArray) -> Claim:
    """A claim without the rows after a pull-off under a prescribed tension."""
    known = ~np.isnan(column)
    if known.all():
        return claim
    reason = f"{claim.reason}; the contact does not hold a prescribed tension after its pull-off"
    return replace(claim, reason=reason, where=claim.where & known)


def _with_claims(task: Task, ball: Ball, walked: Walked[_Rows]) -> tuple[Walked[_Rows], Interpretation]:
    """Step 3: quantities, claims and assumptions of every row."""
    contact, rows = task.contact, walked.rows
    body = contact.plastic
    assert body is not None
    machine = task.machine_stiffness or math.inf
    work = rows.external_work + (
        0.0 if math.isinf(machine) else np.nan_to_num(rows.normal_force) ** 2 / (2.0 * machine)
    )
    columns = with_travel(
        task,
        {
            "indentation": rows.indentation,
            "normal_force": rows.normal_force,
            "contact_radius": rows.contact_radius,
            "residual_indentation": rows.residual_indentation,
            "apparent_radius": rows.apparent_radius,
            "normal_stiffness": rows.normal_stiffness,
            "mean_pressure": mean_pressure(rows.normal_force, rows.contact_radius),
            "elastic_energy": rows.elastic_energy,
            "dissipated_energy": rows.external_work - np.nan_to_num(rows.elastic_energy),
            "external_work": work,
            "yielding": rows.yielding,
        },
    )
    if not body.apparent_radius:
        del columns["apparent_radius"]
    if contact.adhesion is not None:
        touches = rows.contact_radius > 0.0
        columns["jumped"] = (np.append(False, touches[:-1]) & ~touches).astype(float)
    claims = plastic_claims(body, contact.adhesion is not None, prescribed_rows(task), rows.indentation.size)
    claims = {
        name: _where_known(claim, columns[name]) if name in columns else claim
        for name, claim in claims.items()
        if name in columns or not claim.readable
    }
    yielded = bool(np.any(rows.residual_indentation > 0.0))
    status = Status.YIELDED if yielded else Status.ELASTIC
    notes: tuple[str, ...] = ()
    if not yielded:
        first = "the ball does not yield at any indentation of the model"
        if math.isfinite(ball.yield_depth):
            first = f"the ball yields from an indentation of {metres(ball.yield_depth)} on"
        notes = (first,)
    if (released := np.isnan(rows.indentation)).any():
        row, status = int(released.argmax()), Status.PULLED_OFF
        notes += (f"pulled off at row {row}: the contact does not hold the prescribed tension",)
    return walked, Interpretation(
        columns=columns,
        claims=claims,
        assumptions=plastic_assumptions(float(np.max(rows.largest, initial=0.0)), ball.radius),
        status=status,
        notes=notes,
        references=("zunker-kamrin", *(() if contact.adhesion is None else ("hess",))),
    )


def unknown_surface(result: Result) -> FieldReader:
    """Refuse fields: the model has none."""
    raise NotValidError(NO_FIELDS)


def plastic_plots(result: Result, row: int) -> plot.Plots:
    """Figures: the path between the curves of first loading and of unloading."""
    ball, data = ball_of(result.contact), result.data
    d = data["indentation"].values
    body = result.contact.plastic
    assert body is not None
    deepest = float(np.nanmax(d, initial=0.0))
    depth = deepest * np.linspace(0.0, 1.0, _FINE)
    largest = np.array(deepest)
    back = float(ball.residual(largest)) + (deepest - float(ball.residual(largest))) * np.linspace(
        0.0, 1.0, _FINE
    )
    elastic = Ellipse(np.array(4.0 * ball.radius), np.array(2.0 * ball.radius), ball.modulus)
    drawn = plot.PlasticData(
        loading=(depth, ball.loading_force(depth)),
        unloading=(back, ball.force(back, largest)),
        elastic=(depth, elastic.force(depth) * ball.wall(depth)),
        yield_depth=ball.yield_depth,
        own_curves=not body.apparent_radius and result.contact.adhesion is None,
    )
    shown = plot.FigureData(
        data=data,
        row=-1,
        field=None,
        gap=result.contact.profile.gap,
        bands={},
        on_line=False,
        modulus=ball.modulus,
    )
    return plot.Plots(
        shown, partial(plot.plastic_overview, drawn=drawn), partial(plot.plastic_figures, drawn=drawn)
    )


def residual_profile(result: Result, step: int = -1) -> Sampled:
    """
    Compute the profile of a ball that has yielded, after unloading.

    f(r) = (A/2) (1 - (2/pi) E(r/a_M)), r <= a_M, the gap whose line is the ellipse of unloading, with the complete elliptic
    integral E of the second kind.

    Parameters
    ----------
    result : Result
        Of an :class:`ElasticPlastic` body without apparent_radius and wall_factor.
    step : int
        Row whose largest indentation counts; default the last.

    Returns
    -------
    Sampled
        Up to the largest contact radius a_M in m. With ``Elastic(young, poisson)`` it has the force and the contact radius of the
        unloading; its indentation d_e is that of the line, (d - residual_indentation) / (1 + 2 d_R / A).

    Raises
    ------
    ProblemError
        If no body yields, it has not yielded up to the row, or the model does not follow this line.
    QuantityError
        If the row does not exist.

    Notes
    -----
    Zunker and Kamrin (2024) give the line; the profile is its inverse Abel transform. Outside a_M the shape is not known.

    References
    ----------
    - Zunker and Kamrin (2024), J. Mech. Phys. Solids 183, 105492, doi:10.1016/j.jmps.2023.105492.

    Examples
    --------
    >>> import pymdr as mdr
    >>> copper = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
    >>> ball = mdr.Contact(mdr.Sphere("1 mm"), copper)
    >>> flattened = mdr.residual_profile(mdr.solve(ball, mdr.load("40 N") >> mdr.load("0 N")))
    >>> contact = mdr.Contact(flattened, mdr.Elastic("120 GPa", 0.34))
    >>> round(float(mdr.solve(contact, mdr.load("20 N")).to("contact_radius", "um")[-1]), 1)
    141.5
    """
    body = result.contact.plastic
    if body is None:
        raise ProblemError("no body of the contact yields; give a result with an ElasticPlastic body")
    if body.apparent_radius or body.wall_factor:
        raise ProblemError(
            "with apparent_radius or wall_factor the force is not that of one line of springs; leave both out"
        )
    ball, row = ball_of(result.contact), row_indices(step, result.data.sizes["step"])[0]
    largest = float(np.max(result.data["indentation"].values[: row + 1]))
    if largest < ball.yield_depth:
        raise ProblemError(
            f"the ball has not yielded up to row {row} (largest indentation {metres(largest)}, first yield at "
            f"{metres(ball.yield_depth)}); its profile is unchanged"
        )
    line = ball.line(np.array(largest))
    # samples are denser toward the edge, where the slope of the gap grows without bound
    fraction = 1.0 - (1.0 - np.linspace(0.0, 1.0, _SAMPLES)) ** 2
    height = line.height / math.pi * (scipy.special.ellipe(0.0) - scipy.special.ellipe(fraction * fraction))
    return Sampled(0.5 * line.width * fraction, height)
