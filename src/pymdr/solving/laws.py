"""The laws of contact, one row each: how `solve`, results and figures treat them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import NotValidError
from pymdr.independent.history import RingHistory
from pymdr.independent.rings import Rings
from pymdr.interpretation.conductance import CONDUCTIONS, DiskFlux
from pymdr.interpretation.interior import Interior
from pymdr.interpretation.layered_memory import LAYERED_FIELDS
from pymdr.interpretation.layered_stress import interior_of
from pymdr.interpretation.memory import MemorySurface
from pymdr.interpretation.memory_friction import SHEARED_LINE_FIELDS, ShearedSurface
from pymdr.interpretation.plane import PlaneSurface, along, stacks_of
from pymdr.interpretation.surface import LINE_FIELDS, SURFACE_FIELDS, Surface, surface_of
from pymdr.interpretation.torsion import TORSIONAL_FIELDS, TorsionSurface
from pymdr.interpretation.traction import (
    TANGENTIAL_FIELDS,
    TANGENTIAL_LINE_FIELDS,
    FrictionSurface,
    friction_surface,
)
from pymdr.line.friction import FrictionState
from pymdr.mapping.conductivity import Carrier, conductivity_of, is_carried
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.result import Reading, Result
from pymdr.result.readers import FieldReader
from pymdr.solving.adhesive import solve_adhesive
from pymdr.solving.closure import is_curve, reading_of, refuse_curve, solve_on_curve
from pymdr.solving.drawing import (
    adhesive_plots,
    frictional_memory_plots,
    frictional_plots,
    hysteretic_plots,
    memory_plots,
    normal_plots,
    planar_plots,
    plots_with_conduction,
    sheared_plots,
    soft_plots,
    zone_plots,
)
from pymdr.solving.frictional import solve_frictional
from pymdr.solving.frictional_memory import solve_frictional_memory
from pymdr.solving.hysteretic import solve_hysteretic
from pymdr.solving.memory import relaxation_along, tangential_relaxation_along
from pymdr.solving.normal import solve_normal
from pymdr.solving.planar import is_frictional_plane, line_of_path, on_line, replay_of, solve_planar
from pymdr.solving.plastic import WITHOUT_FIELDS, is_plastic, plastic_plots, solve_plastic, unknown_surface
from pymdr.solving.ringed import (
    ring_history_with_memory,
    ring_solutions,
    solve_by_rings,
    solve_memory_by_rings,
)
from pymdr.solving.shapes import is_shape, shape_plots, shape_surface, solve_shape
from pymdr.solving.sheared import sheared_traction, solve_sheared
from pymdr.solving.soft import solve_soft, zone_surface
from pymdr.solving.torsional import is_torsional, replayed, solve_torsional, torsion_law
from pymdr.solving.viscoelastic import solve_viscoelastic, surface_with_memory
from pymdr.solving.walk import Task

_WITHOUT_FRICTION = dict.fromkeys(
    (*TANGENTIAL_FIELDS, *TANGENTIAL_LINE_FIELDS),
    "the contact has no friction; solve it with friction=Coulomb(0.3)",
)
_WITHOUT_SHIFT = dict.fromkeys(
    ("shear_traction", "tangential_displacement", *TANGENTIAL_LINE_FIELDS),
    "the path turns the body; its fields are torsional_traction and circumferential_displacement",
)
_UNDER_FULL_STICK = dict.fromkeys(
    ("tangential_displacement", "slip", *TANGENTIAL_LINE_FIELDS),
    "the contact is sheared without slip; its field is shear_traction",
)

_UNDER_LAYERS = dict.fromkeys((*SURFACE_FIELDS, *LINE_FIELDS), LAYERED_FIELDS)
_IN_PLANE = {
    "tangential_stiffness": "in the plane the stiffness depends on the direction of the next move; take the difference of two paths"
}


@dataclass(frozen=True)
class Law:
    """One kind of contact: its solution, and the reading of its results."""

    covers: Callable[[Contact, Rings | None, LoadingPath], bool]
    history: Callable[[Task], Result]
    """Map, walk and interpret: statuses, claims and references."""
    reading: Reading


def _surface(result: Result) -> Surface:
    data = result.data
    nan = np.full(data.sizes["step"], np.nan)
    d, a = (data[name].values if name in data else nan for name in ("indentation", "contact_radius"))
    c = data["cohesive_radius"].values if "cohesive_radius" in data else None
    return surface_of(result.contact, np.where(np.isnan(a), np.nan, d), a, c)


def _interior(result: Result, side: str | None) -> Interior:
    surface = result.surface
    assert isinstance(surface, Surface | FrictionSurface | TorsionSurface | MemorySurface | ShearedSurface)
    return replace(interior_of(result.contact, surface, side), turns=isinstance(surface, TorsionSurface))


def _friction_surface(result: Result) -> FrictionSurface:
    assert result.starts is not None
    rows = np.arange(result.data.sizes["step"])
    if "row" in result.data.coords:
        rows = result.data["row"].values
    return friction_surface(
        result.contact, result.path, result.starts, result.machine_stiffness, _surface(result), rows
    )


def _plane_surface(result: Result) -> PlaneSurface:
    rows = np.arange(result.data.sizes["step"])
    if "row" in result.data.coords:
        rows = result.data["row"].values
    normal, contact, direction = _surface(result), result.contact, line_of_path(result.path)
    assert contact.friction is not None
    mu = contact.friction.coefficient
    if direction is not None:
        assert result.starts is not None
        single = friction_surface(
            contact, on_line(result.path, direction), result.starts, result.machine_stiffness, normal, rows
        )
        return PlaneSurface(
            normal, lambda step: along(single.replay.state(int(single.rows[step])), direction)
        )
    springs_at = replay_of(Task(contact, result.path, result.reading, result.machine_stiffness))

    def states(step: int) -> tuple[FrictionState, FrictionState]:
        law, state = springs_at(int(rows[step]))
        return stacks_of(law.law, law.springs, state, mu)

    return PlaneSurface(normal, states)


def _torsion_surface(result: Result) -> TorsionSurface:
    kept = result.data["row"].values if "row" in result.data.coords else None
    task = Task(result.contact, result.path, result.reading, result.machine_stiffness, kept)
    line = torsion_law(result.contact, result.machine_stiffness).line
    return TorsionSurface(_surface(result), line, partial(replayed, task))


def _rings(result: Result) -> RingHistory:
    contact, depths = result.contact, result.data["indentation"].values
    assert result.rings is not None
    solutions = ring_solutions(contact, depths, False, result.rings)
    return RingHistory(contact.profile, tuple(solutions), depths)


def _rings_with_memory(result: Result) -> RingHistory:
    kept = result.data["row"].values if "row" in result.data.coords else None
    return ring_history_with_memory(
        Task(result.contact, result.path, result.reading, keep=kept, solver=result.rings)
    )


def _no_surface(result: Result) -> FieldReader:
    raise NotValidError(LAYERED_FIELDS)


def _surface_with_memory(result: Result) -> MemorySurface:
    data = result.data
    time, depth, radius = (data[name].values for name in ("time", "indentation", "contact_radius"))
    relaxation = relaxation_along(result.contact, result.path, result["time"].values)
    return surface_with_memory(result.contact, relaxation, time, depth, radius)


def _sheared_surface(result: Result) -> ShearedSurface:
    contact = result.contact
    assert contact.friction is not None
    return ShearedSurface(
        _surface_with_memory(result),
        tangential_relaxation_along(contact, result.path, result["time"].values),
        contact.friction.coefficient,
        result.data["shift"].values,
    )


LAWS = (
    Law(
        lambda contact, solver, path: is_plastic(contact),
        solve_plastic,
        Reading((), (), unknown_surface, plastic_plots, WITHOUT_FIELDS),
    ),
    Law(
        lambda contact, solver, path: (
            solver is None and contact.adhesion is not None and contact.friction is not None
        ),
        solve_sheared,
        Reading(
            SURFACE_FIELDS,
            LINE_FIELDS,
            _surface,
            sheared_plots,
            _UNDER_FULL_STICK,
            carried={"shear_traction": sheared_traction},
        ),
    ),
    Law(
        lambda contact, solver, path: is_frictional_plane(contact, path, solver is not None),
        solve_planar,
        Reading(
            (*SURFACE_FIELDS, *TANGENTIAL_FIELDS),
            (*LINE_FIELDS, *TANGENTIAL_LINE_FIELDS),
            _plane_surface,
            planar_plots,
            _IN_PLANE,
        ),
    ),
    Law(
        lambda contact, solver, path: is_shape(contact),
        solve_shape,
        Reading(SURFACE_FIELDS, (), shape_surface, shape_plots, _WITHOUT_FRICTION),
    ),
    Law(
        lambda contact, solver, path: solver is not None and contact.is_viscoelastic,
        solve_memory_by_rings,
        Reading(SURFACE_FIELDS, (), _rings_with_memory, memory_plots, _WITHOUT_FRICTION),
    ),
    Law(
        lambda contact, solver, path: solver is not None,
        solve_by_rings,
        Reading(SURFACE_FIELDS, (), _rings, normal_plots, _WITHOUT_FRICTION),
    ),
    Law(
        lambda contact, solver, path: contact.is_viscoelastic and contact.adhesion is not None,
        solve_soft,
        Reading(SURFACE_FIELDS, LINE_FIELDS, zone_surface, zone_plots, _WITHOUT_FRICTION),
    ),
    Law(
        lambda contact, solver, path: contact.is_viscoelastic and contact.friction is not None,
        solve_frictional_memory,
        Reading(
            (*SURFACE_FIELDS, *TANGENTIAL_FIELDS),
            (*LINE_FIELDS, *SHEARED_LINE_FIELDS),
            _sheared_surface,
            frictional_memory_plots,
            interior=_interior,
        ),
    ),
    Law(
        lambda contact, solver, path: contact.is_viscoelastic and contact.layered is not None,
        solve_viscoelastic,
        Reading((), (), _no_surface, soft_plots, _UNDER_LAYERS),
    ),
    Law(
        lambda contact, solver, path: contact.is_viscoelastic,
        solve_viscoelastic,
        Reading(
            SURFACE_FIELDS,
            LINE_FIELDS,
            _surface_with_memory,
            memory_plots,
            _WITHOUT_FRICTION,
            interior=_interior,
        ),
    ),
    Law(
        lambda contact, solver, path: contact.adhesion is not None and contact.adhesion.has_hysteresis,
        solve_hysteretic,
        Reading(
            SURFACE_FIELDS, LINE_FIELDS, _surface, hysteretic_plots, _WITHOUT_FRICTION, interior=_interior
        ),
    ),
    Law(
        lambda contact, solver, path: contact.adhesion is not None,
        solve_adhesive,
        Reading(SURFACE_FIELDS, LINE_FIELDS, _surface, adhesive_plots, _WITHOUT_FRICTION, interior=_interior),
    ),
    Law(
        lambda contact, solver, path: is_torsional(contact, path),
        solve_torsional,
        Reading(
            (*SURFACE_FIELDS, *TORSIONAL_FIELDS),
            LINE_FIELDS,
            _torsion_surface,
            frictional_plots,
            _WITHOUT_SHIFT,
            interior=_interior,
        ),
    ),
    Law(
        lambda contact, solver, path: contact.friction is not None,
        solve_frictional,
        Reading(
            (*SURFACE_FIELDS, *TANGENTIAL_FIELDS),
            (*LINE_FIELDS, *TANGENTIAL_LINE_FIELDS),
            _friction_surface,
            frictional_plots,
            interior=_interior,
        ),
    ),
    Law(
        lambda contact, solver, path: True,
        solve_normal,
        Reading(SURFACE_FIELDS, LINE_FIELDS, _surface, normal_plots, _WITHOUT_FRICTION, interior=_interior),
    ),
)
"""In order: the first that covers a contact and a solver applies."""


def law_of(contact: Contact, solver: Rings | None, path: LoadingPath) -> Law:
    """The law of a contact on a path; for a force curve, restricted to what the curve determines."""
    law = next(law for law in LAWS if law.covers(contact, solver, path))
    if is_curve(contact):
        if solver is not None:
            refuse_curve(contact, "solve: solver=Rings()", "boundary elements need its shape")
        law = replace(law, history=partial(solve_on_curve, law.history), reading=reading_of(law.reading))
    return replace(law, reading=_with_fluxes(law.reading, contact, solver))


def _with_fluxes(reading: Reading, contact: Contact, solver: Rings | None) -> Reading:
    """A reading with the fields of heat and current flow, or with the reason why there are none."""
    elsewhere, carried = dict(reading.elsewhere), dict(reading.carried)
    for each in CONDUCTIONS:
        if not is_carried(contact.body, contact.counterbody, each.carrier):
            reason = f"the bodies have no conductivity; give both {each.carrier}, as in Elastic('210 GPa', 0.3, {each.carrier}=...)"
            elsewhere |= dict.fromkeys((each.quantity, each.field), reason)
        elif solver is not None:
            elsewhere[each.field] = "boundary elements do not solve for the flux; leave solver=Rings() out"
        elif is_shape(contact):
            elsewhere[each.field] = (
                "the contact is not a disk; only the total flux is available, not its distribution"
            )
        else:
            carried[each.field] = partial(_flux, each.carrier)
    if not any(is_carried(contact.body, contact.counterbody, each.carrier) for each in CONDUCTIONS):
        return replace(reading, elsewhere=elsewhere)
    return replace(
        reading, elsewhere=elsewhere, carried=carried, plots=partial(plots_with_conduction, reading.plots)
    )


def _flux(carrier: Carrier, result: Result) -> DiskFlux:
    pair = conductivity_of(result.contact.body, result.contact.counterbody, carrier)
    assert not isinstance(pair, str)
    return DiskFlux(pair.line, result.data["contact_radius"].values)
