"""Data of the figures of a result, law by law."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import ProblemError, PymdrError
from pymdr.interpretation.conductance import CONDUCTIONS
from pymdr.interpretation.on_normal import OnNormal
from pymdr.interpretation.peaks import infinite_pressures
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.theories import theory_of
from pymdr.line.curves import Line
from pymdr.line.foundation import normal_force, normal_stiffness, rises_to, states_at_depth, states_at_force
from pymdr.line.lines import line_of
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.paths import legs
from pymdr.result import DeflectedReader, Result
from pymdr.units import FloatArray, written

if TYPE_CHECKING:
    from pymdr.interpretation.jumps import Branches
    from pymdr.presentation.plot import FigureData, Plots


def normal_plots(result: Result, row: int) -> plot.Plots:
    """Figures of a contact without memory, friction and adhesion."""
    line = _line_of(result)
    data = _figure_data(result, row, loading=None if line is None else _loading(result, line))
    return plot.Plots(data, plot.normal_overview, plot.normal_figures)


def _simple(kind: str, result: Result, row: int) -> Plots:
    """Figures of one kind of contact that need no more than its result."""
    from pymdr.presentation import plot

    data = _figure_data(result, row, equilibria=(lambda: None) if kind in ("zone", "sheared") else None)
    return plot.Plots(data, getattr(plot, f"{kind}_overview"), getattr(plot, f"{kind}_figures"))


memory_plots = partial(_simple, "memory")
zone_plots = partial(_simple, "zone")
sheared_plots = partial(_simple, "sheared")
frictional_plots = partial(_simple, "frictional")
planar_plots = partial(_simple, "planar")


def adhesive_plots(result: Result, row: int) -> plot.Plots:
    """Figures of a contact on its curve of equilibria."""
    law, line = result.contact.adhesion, _line_of(result)
    assert law is not None
    assert line is not None
    pull = theory_of(law).pull(law, result.contact.profile, line)
    data = _figure_data(result, row, equilibria=lambda: _branches(result, line), pull=pull)
    return plot.Plots(data, plot.adhesive_overview, plot.adhesive_figures)


def hysteretic_plots(result: Result, row: int) -> plot.Plots:
    """Figures of a contact between the curves of two works of adhesion."""
    line = _line_of(result)
    assert line is not None
    data = _figure_data(result, row, equilibria=lambda: _branches_of_edge(result, line))
    return plot.Plots(data, plot.adhesive_overview, plot.adhesive_figures)


def short_plots(result: Result, row: int) -> plot.Plots:
    """Figures of bodies with memory under adhesion of short range, whose fields are not computed."""
    data = plot.FigureData(
        data=result.data, row=row, field=None, gap=result.contact.profile.gap, bands={}, on_line=False
    )
    return plot.Plots(data, plot.short_overview, plot.soft_figures)


def frictional_memory_plots(result: Result, row: int) -> plot.Plots:
    """Figures of a contact with memory, stick and slip."""
    data = _figure_data(result, row)

    def both(data: FigureData) -> dict[str, mpl.figure.Figure]:
        history = plot.memory_figures(data)["history"]
        return {**plot.frictional_figures(data), "history": history}

    return plot.Plots(data, plot.frictional_overview, both)


def plots_with_conduction(plots: Callable[[Result, int], Plots], result: Result, row: int) -> Plots:
    """The figures of a law, and one of heat and current flow."""
    drawn = plots(result, row)

    def drawn_too(data: FigureData) -> dict[str, mpl.figure.Figure]:
        levels = {
            each.quantity: result.claims[each.quantity].level.value
            for each in CONDUCTIONS
            if each.quantity in result.data
        }
        fluxes = {
            name: result.field(name, step=row)
            for name in result.reading.carried
            if row >= 0 and result.claims[name].where[row] and result.data["contact_radius"].values[row] > 0.0
        }
        figures = drawn.figures(data)
        return figures | {"conductance": plot.conduction_figure(data, levels, fluxes)} if levels else figures

    return replace(drawn, figures=drawn_too)


def _figure_data(
    result: Result,
    row: int,
    *,
    equilibria: Callable[[], Branches | None] | None = None,
    loading: Callable[[FloatArray], Mapping[str, FloatArray]] | None = None,
    pull: float | None = None,
) -> plot.FigureData:
    refused = row < 0 and "pressure" in result.claims
    line, surface, normal = _line_of(result), result.surface, _normal_surface(result)
    return plot.FigureData(
        data=result.data,
        row=row,
        field=(lambda name, r: result.field(name, r, row)) if row >= 0 else None,
        gap=result.surface.gap_function,
        bands=result.bands,
        # coupled springs are not drawn as independent ones
        on_line=bool(result.reading.line_fields) and result.contact.layered is None,
        layers=_layers(result),
        field_at=result.field,
        friction=None if result.contact.friction is None else result.contact.friction.coefficient,
        equilibria=equilibria,
        modulus=None if line is None else line.modulus,
        deflection=partial(normal.deflection, row) if isinstance(normal, DeflectedReader) else None,
        kinks=lambda: np.array([*result.contact.profile.breakpoints, *surface.marks(row)]),
        loading=loading,
        pull=pull,
        refusal=result.claims["pressure"].reason if refused else "",
        extent=_extent(result, line) if refused and line is not None else None,
    )


def infinite_in(result: Result, step: int) -> tuple[float, ...]:
    """Radii in m inside the contact at which the pressure of a step is infinite; empty if it is not a disk."""
    if not result.claims["contact_radius"].where[step]:
        return ()
    kinks = np.array([*result.contact.profile.breakpoints, *result.surface.marks(step)])
    a = float(result.data["contact_radius"].values[step])
    return infinite_pressures(result.surface.gap_function, kinks, a)


def _layers(result: Result) -> plot.LayersDrawn | None:
    """The layers of a body, and the forces of half-spaces of its top layer and of its base."""
    body = result.contact.layered
    if body is None:
        return None
    known = result.data["indentation"].values if "indentation" in result.data else np.zeros(1)
    deepest = float(np.nanmax(known, initial=0.0))
    depth = deepest * np.linspace(0.0, 1.0, 101) ** 2
    half_spaces = {}
    for label, solid in (("half-space of the top layer", body.top), ("half-space of the base", body.base)):
        if deepest > 0.0 and not isinstance(solid, Rigid):
            one, other = (
                solid if each is body else each for each in (result.contact.body, result.contact.counterbody)
            )
            line = line_of(Contact(result.contact.profile, one, other))
            half_spaces[label] = (depth, normal_force(line, states_at_depth(line, depth)))
    return plot.LayersDrawn(
        thickness=tuple(layer.thickness for layer in body.layers),
        materials=tuple(
            f"{written(solid.young, 'Pa')}, {written(layer.thickness, 'm')}"
            for layer, solid in zip(body.layers, body.solids, strict=True)
        ),
        base=f"base, {written(body.base.young, 'Pa')}" if isinstance(body.base, Elastic) else "rigid base",
        rigid=isinstance(body.base, Rigid),
        half_spaces=half_spaces,
        both=not any(isinstance(one, Rigid) for one in (result.contact.body, result.contact.counterbody)),
    )


def _normal_surface(result: Result) -> object:
    """The surface of the contact without its tangential loads."""
    return result.surface.normal if isinstance(result.surface, OnNormal) else result.surface


def _line_of(result: Result) -> Line | None:
    normal = _normal_surface(result)
    return normal.line if isinstance(normal, Surface) else None


def _extent(result: Result, line: Line) -> float | None:
    """Radius up to which a refused profile is drawn: twice that of the disk at the largest target of the path."""
    targets = {
        name: max(
            (float(np.max(v)) for leg in legs(result.path) if (v := getattr(leg, name, None)) is not None),
            default=0.0,
        )
        for name in ("indentation", "travel", "normal_force")
    }
    depth = max(targets["indentation"], targets["travel"])
    try:
        states = (
            states_at_depth(line, depth) if depth > 0.0 else states_at_force(line, targets["normal_force"])
        )
    except PymdrError:
        return None
    radius = float(np.asarray(states.contact_radius))
    return min(2.0 * radius, result.contact.profile.max_radius) if radius > 0.0 else None


def _loading(result: Result, line: Line) -> Callable[[FloatArray], Mapping[str, FloatArray]] | None:
    """Quantities at any indentation up to the largest, if the profile increases."""
    known = np.zeros(1)
    if {"indentation", "contact_radius"} <= set(result.data):
        solved = np.isfinite(result.data["contact_radius"].values)
        known = result.data["indentation"].values[solved]
    if not rises_to(line, float(np.nanmax(known, initial=0.0))):
        return None

    def at(depth: FloatArray) -> dict[str, FloatArray]:
        states = states_at_depth(line, depth)
        return {
            "normal_force": normal_force(line, states),
            "contact_radius": states.contact_radius,
            "normal_stiffness": normal_stiffness(line, states),
        }

    return at


def _branches_of_edge(result: Result, line: Line) -> Branches | None:
    """The curves of both works with the jumps of the path; None without contact."""
    from pymdr.interpretation.jumps import branches_of_edge
    from pymdr.line.adhesion import JKR as ShortRange
    from pymdr.solving.equilibria import finite

    law, rows = result.contact.adhesion, _path_rows(result)
    assert law is not None
    if rows is None:
        return None
    if not result.claims["contact_radius"].where.all():
        raise ProblemError("some rows have no solution; give a path whose contact is a disk in every row")
    line = line.under(finite(line.equivalent))
    curves = ShortRange(line, law.works[0]), ShortRange(line, law.works[1])
    rim = line.edge if line.edge <= line.max_radius else math.inf
    return branches_of_edge(curves, result.path, rows, result.machine_stiffness, rim)


def _path_rows(result: Result) -> dict[str, FloatArray] | None:
    """Quantities of the rows of a path that made contact."""
    names = ("indentation", "normal_force", "contact_radius", "cohesive_radius", "travel")
    rows = {name: result.data[name].values for name in names if name in result.data}
    radii = [rows[name] for name in ("contact_radius", "cohesive_radius") if name in rows]
    touched = any(np.nanmax(a, initial=0.0) > 0.0 for a in radii)
    return rows if touched and {"indentation", "normal_force"} <= rows.keys() else None


def _branches(result: Result, line: Line) -> Branches | None:
    """All equilibria with the jumps of the path, for figures; None without contact."""
    from pymdr.interpretation.jumps import branches_of
    from pymdr.solving.equilibria import finite

    rows = _path_rows(result)
    if rows is None:
        return None
    complete = bool(result.claims["contact_radius"].where.all())
    # on the same line as in the solution
    line = line.under(finite(line.equivalent))
    return branches_of(result.contact, line, result.path, rows, result.machine_stiffness, complete=complete)
