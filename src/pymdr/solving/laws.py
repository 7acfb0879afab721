"""The laws of contact, one row each: how `solve`, results and figures treat them. A row imports its law when it applies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pymdr.interpretation.conductance import CONDUCTIONS, DiskFlux
from pymdr.interpretation.surface import LINE_FIELDS, SURFACE_FIELDS, Surface, surface_of
from pymdr.interpretation.validity import TANGENTIAL_FIELDS, TANGENTIAL_LINE_FIELDS
from pymdr.mapping.moduli import Carrier, conductivity_of, is_carried
from pymdr.problem.contact import Contact, is_curve, refuse_curve
from pymdr.problem.paths import LoadingPath
from pymdr.problem.profiles import Shape
from pymdr.problem.schedule import is_planar, is_torsional
from pymdr.result import Reading, Result
from pymdr.result.readers import FieldReader
from pymdr.solving.walk import Task

if TYPE_CHECKING:
    from pymdr.independent.history import RingHistory
    from pymdr.independent.rings import Rings
    from pymdr.interpretation.interior import Interior
    from pymdr.interpretation.memory import MemorySurface
    from pymdr.interpretation.memory_friction import ShearedSurface
    from pymdr.interpretation.plane import PlaneSurface
    from pymdr.interpretation.torsion import TorsionSurface
    from pymdr.interpretation.traction import FrictionSurface
    from pymdr.line.friction import FrictionState
    from pymdr.presentation.plot import Plots

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
_IN_PLANE = {
    "tangential_stiffness": "in the plane the stiffness depends on the direction of the next move; take the difference of two paths"
}


@dataclass(frozen=True)
class Law:
    """One kind of contact: its solution, and the reading of its results."""

    history: Callable[[Task], Result]
    """Map, walk and interpret: statuses, claims and references."""
    reading: Reading


@dataclass(frozen=True)
class Row:
    """Which contacts a law covers, and the law."""

    covers: Callable[[Contact, Rings | None, LoadingPath], bool]
    law: Callable[[], Law]


def _surface(result: Result) -> Surface:
    data = result.data
    nan = np.full(data.sizes["step"], np.nan)
    d, a = (data[name].values if name in data else nan for name in ("indentation", "contact_radius"))
    c = data["cohesive_radius"].values if "cohesive_radius" in data else None
    return surface_of(result.contact, np.where(np.isnan(a), np.nan, d), a, c)


def _interior(result: Result, side: str | None) -> Interior:
    from pymdr.interpretation.layered_stress import interior_of
    from pymdr.interpretation.memory import MemorySurface
    from pymdr.interpretation.memory_friction import ShearedSurface
    from pymdr.interpretation.torsion import TorsionSurface
    from pymdr.interpretation.traction import FrictionSurface

    surface = result.surface
    assert isinstance(surface, Surface | FrictionSurface | TorsionSurface | MemorySurface | ShearedSurface)
    return replace(interior_of(result.contact, surface, side), turns=isinstance(surface, TorsionSurface))


def _friction_surface(result: Result) -> FrictionSurface:
    from pymdr.interpretation.traction import friction_surface

    assert result.starts is not None
    rows = np.arange(result.data.sizes["step"])
    if "row" in result.data.coords:
        rows = result.data["row"].values
    return friction_surface(
        result.contact, result.path, result.starts, result.machine_stiffness, _surface(result), rows
    )


def _plane_surface(result: Result) -> PlaneSurface:
    from pymdr.interpretation.plane import PlaneSurface, along, stacks_of
    from pymdr.interpretation.traction import friction_surface
    from pymdr.solving.planar import line_of_path, on_line, replay_of

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
    from pymdr.interpretation.torsion import TorsionSurface
    from pymdr.solving.torsional import replayed, torsion_law

    kept = result.data["row"].values if "row" in result.data.coords else None
    task = Task(result.contact, result.path, result.reading, result.machine_stiffness, kept)
    line = torsion_law(result.contact, result.machine_stiffness).line
    return TorsionSurface(_surface(result), line, partial(replayed, task))


def _rings(result: Result) -> RingHistory:
    from pymdr.independent.history import RingHistory
    from pymdr.solving.ringed import ring_solutions

    contact, depths = result.contact, result.data["indentation"].values
    assert result.rings is not None
    solutions = ring_solutions(contact, depths, False, result.rings)
    return RingHistory(contact.profile, tuple(solutions), depths)


def _rings_with_memory(result: Result) -> RingHistory:
    from pymdr.solving.ringed import ring_history_with_memory

    kept = result.data["row"].values if "row" in result.data.coords else None
    return ring_history_with_memory(
        Task(result.contact, result.path, result.reading, keep=kept, solver=result.rings)
    )


def _surface_with_memory(result: Result) -> MemorySurface:
    from pymdr.solving.memory import relaxation_along
    from pymdr.solving.viscoelastic import surface_with_memory

    data = result.data
    time, depth, radius = (data[name].values for name in ("time", "indentation", "contact_radius"))
    relaxation = relaxation_along(result.contact, result.path, result["time"].values)
    return surface_with_memory(result.contact, relaxation, time, depth, radius)


def _sheared_surface(result: Result) -> ShearedSurface:
    from pymdr.interpretation.memory_friction import ShearedSurface
    from pymdr.solving.memory import tangential_relaxation_along

    contact = result.contact
    assert contact.friction is not None
    return ShearedSurface(
        _surface_with_memory(result),
        tangential_relaxation_along(contact, result.path, result["time"].values),
        contact.friction.coefficient,
        result.data["shift"].values,
    )


def _plastic() -> Law:
    from pymdr.solving.plastic import WITHOUT_FIELDS, plastic_plots, solve_plastic, unknown_surface

    return Law(solve_plastic, Reading((), (), unknown_surface, plastic_plots, WITHOUT_FIELDS))


def _sheared() -> Law:
    from pymdr.solving.drawing import sheared_plots
    from pymdr.solving.sheared import sheared_traction, solve_sheared

    carried = {"shear_traction": sheared_traction}
    return Law(
        solve_sheared,
        Reading(SURFACE_FIELDS, LINE_FIELDS, _surface, sheared_plots, _UNDER_FULL_STICK, carried=carried),
    )


def _planar() -> Law:
    from pymdr.solving.drawing import planar_plots
    from pymdr.solving.planar import solve_planar

    surface, line = (*SURFACE_FIELDS, *TANGENTIAL_FIELDS), (*LINE_FIELDS, *TANGENTIAL_LINE_FIELDS)
    return Law(solve_planar, Reading(surface, line, _plane_surface, planar_plots, _IN_PLANE))


def _shape() -> Law:
    from pymdr.solving.shapes import shape_plots, shape_surface, solve_shape

    return Law(solve_shape, Reading(SURFACE_FIELDS, (), shape_surface, shape_plots, _WITHOUT_FRICTION))


def _memory_by_rings() -> Law:
    from pymdr.solving.drawing import memory_plots
    from pymdr.solving.ringed import solve_memory_by_rings

    reading = Reading(SURFACE_FIELDS, (), _rings_with_memory, memory_plots, _WITHOUT_FRICTION)
    return Law(solve_memory_by_rings, reading)


def _by_rings() -> Law:
    from pymdr.solving.drawing import normal_plots
    from pymdr.solving.ringed import solve_by_rings

    return Law(solve_by_rings, Reading(SURFACE_FIELDS, (), _rings, normal_plots, _WITHOUT_FRICTION))


def _soft() -> Law:
    from pymdr.solving.drawing import zone_plots
    from pymdr.solving.soft import solve_soft, zone_surface

    return Law(solve_soft, Reading(SURFACE_FIELDS, LINE_FIELDS, zone_surface, zone_plots, _WITHOUT_FRICTION))


def _small_zone() -> Law:
    from pymdr.solving.drawing import short_plots
    from pymdr.solving.small_zone import WITHOUT_FIELDS, no_fields, solve_small_zone

    elsewhere = dict.fromkeys((*SURFACE_FIELDS, *LINE_FIELDS), WITHOUT_FIELDS)
    return Law(solve_small_zone, Reading((), (), no_fields, short_plots, elsewhere))


def _frictional_memory() -> Law:
    from pymdr.interpretation.memory_friction import SHEARED_LINE_FIELDS
    from pymdr.solving.drawing import frictional_memory_plots
    from pymdr.solving.frictional_memory import solve_frictional_memory

    surface, line = (*SURFACE_FIELDS, *TANGENTIAL_FIELDS), (*LINE_FIELDS, *SHEARED_LINE_FIELDS)
    reading = Reading(surface, line, _sheared_surface, frictional_memory_plots, interior=_interior)
    return Law(solve_frictional_memory, reading)


def _memory() -> Law:
    from pymdr.solving.drawing import memory_plots
    from pymdr.solving.viscoelastic import solve_viscoelastic

    return Law(solve_viscoelastic, _pressed(_surface_with_memory, memory_plots))


def _hysteretic() -> Law:
    from pymdr.solving.adhesive import solve_hysteretic
    from pymdr.solving.drawing import hysteretic_plots

    return Law(solve_hysteretic, _pressed(_surface, hysteretic_plots))


def _adhesive() -> Law:
    from pymdr.solving.adhesive import solve_adhesive
    from pymdr.solving.drawing import adhesive_plots

    return Law(solve_adhesive, _pressed(_surface, adhesive_plots))


def _torsional() -> Law:
    from pymdr.interpretation.torsion import TORSIONAL_FIELDS
    from pymdr.solving.drawing import frictional_plots
    from pymdr.solving.torsional import solve_torsional

    fields = (*SURFACE_FIELDS, *TORSIONAL_FIELDS)
    return Law(
        solve_torsional,
        Reading(fields, LINE_FIELDS, _torsion_surface, frictional_plots, _WITHOUT_SHIFT, interior=_interior),
    )


def _frictional() -> Law:
    from pymdr.solving.drawing import frictional_plots
    from pymdr.solving.frictional import solve_frictional

    surface, line = (*SURFACE_FIELDS, *TANGENTIAL_FIELDS), (*LINE_FIELDS, *TANGENTIAL_LINE_FIELDS)
    return Law(
        solve_frictional, Reading(surface, line, _friction_surface, frictional_plots, interior=_interior)
    )


def _normal() -> Law:
    from pymdr.solving.drawing import normal_plots
    from pymdr.solving.normal import solve_normal

    return Law(solve_normal, _pressed(_surface, normal_plots))


def _pressed(reader: Callable[[Result], FieldReader], plots: Callable[[Result, int], Plots]) -> Reading:
    """The reading of a contact that is only pressed or pulled, with the stress inside its bodies."""
    return Reading(SURFACE_FIELDS, LINE_FIELDS, reader, plots, _WITHOUT_FRICTION, interior=_interior)


def _is_in_plane(contact: Contact, solver: Rings | None, path: LoadingPath) -> bool:
    """Whether a path moves a contact in the plane; contacts that cannot be are refused."""
    if not is_planar(path):
        return False
    from pymdr.solving.planar import check_planar

    check_planar(contact, path, solver is not None)
    return True


LAWS = (
    Row(lambda contact, solver, path: contact.plastic is not None, _plastic),
    Row(
        lambda contact, solver, path: (
            solver is None and contact.adhesion is not None and contact.friction is not None
        ),
        _sheared,
    ),
    Row(_is_in_plane, _planar),
    Row(lambda contact, solver, path: isinstance(contact.profile, Shape), _shape),
    Row(lambda contact, solver, path: solver is not None and contact.is_viscoelastic, _memory_by_rings),
    Row(lambda contact, solver, path: solver is not None, _by_rings),
    Row(
        lambda contact, solver, path: (
            contact.is_viscoelastic
            and contact.adhesion is not None
            and contact.adhesion.cohesive_stress is None
        ),
        _small_zone,
    ),
    Row(lambda contact, solver, path: contact.is_viscoelastic and contact.adhesion is not None, _soft),
    Row(
        lambda contact, solver, path: contact.is_viscoelastic and contact.friction is not None,
        _frictional_memory,
    ),
    Row(lambda contact, solver, path: contact.is_viscoelastic, _memory),
    Row(
        lambda contact, solver, path: contact.adhesion is not None and contact.adhesion.has_hysteresis,
        _hysteretic,
    ),
    Row(lambda contact, solver, path: contact.adhesion is not None, _adhesive),
    Row(lambda contact, solver, path: contact.friction is not None and is_torsional(path), _torsional),
    Row(lambda contact, solver, path: contact.friction is not None, _frictional),
    Row(lambda contact, solver, path: True, _normal),
)
"""In order: the first that covers a contact and a solver applies."""


def law_of(contact: Contact, solver: Rings | None, path: LoadingPath) -> Law:
    """The law of a contact on a path; for a force curve, restricted to what the curve determines."""
    law = next(row for row in LAWS if row.covers(contact, solver, path)).law()
    if is_curve(contact):
        if solver is not None:
            refuse_curve(contact, "boundary elements need its shape")
        from pymdr.solving.closure import reading_of, solve_on_curve

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
        elif isinstance(contact.profile, Shape):
            elsewhere[each.field] = (
                "the contact is not a disk; only the total flux is available, not its distribution"
            )
        else:
            carried[each.field] = partial(_flux, each.carrier)
    if not any(is_carried(contact.body, contact.counterbody, each.carrier) for each in CONDUCTIONS):
        return replace(reading, elsewhere=elsewhere)
    from pymdr.solving.drawing import plots_with_conduction

    return replace(
        reading, elsewhere=elsewhere, carried=carried, plots=partial(plots_with_conduction, reading.plots)
    )


def _flux(carrier: Carrier, result: Result) -> DiskFlux:
    pair = conductivity_of(result.contact.body, result.contact.counterbody, carrier)
    assert not isinstance(pair, str)
    return DiskFlux(pair.line, result.data["contact_radius"].values)
