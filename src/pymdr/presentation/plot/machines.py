"""Figures of motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_STORED = ("kinetic_energy", "spring_energy", "elastic_energy", "stored_tangential_energy")
_DISSIPATED = ("dissipated_energy", "damping_energy")
_DONE = ("work_of_drives", "work_of_forces")
_DECADES = 1e-6
"""Smallest amplitude of a spectrum that is shown, over the largest."""


def motion_figure(data: xr.Dataset, spectrum: xr.DataArray | None) -> draw.Figure:
    """
    Phase plane of the first body, the flow of energy, and with contacts the forces of the first joint and a spectrum.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``step`` with ``time``: ``position`` and ``velocity`` over ``body``, energies, and with contacts ``normal_force`` and perhaps
        ``tangential_force`` over ``joint``.
    spectrum : xarray.DataArray or None
        Amplitudes of a force in N over ``frequency`` in Hz.
    """
    touches = spectrum is not None
    with draw.new_figure(8.4, 6.4 if touches else 3.4) as figure:
        panels = figure.subplots(2 if touches else 1, 2).ravel()
        time_unit = good_unit(data["time"].values, "s")
        time = draw.scaled(data["time"].values, "time", time_unit)
        _draw_phase_plane(panels[0], data)
        if spectrum is not None:
            _draw_forces(panels[1], data, time, time_unit)
            _draw_spectrum(panels[2], spectrum)
        _draw_energies(panels[-1], data, time, time_unit)
    return figure


def _draw_phase_plane(axes: draw.Axes, data: xr.Dataset) -> None:
    """Velocity against position of the first body, from the dot on."""
    shown = []
    for name in ("position", "velocity"):
        values = data[name].values[:, 0]
        unit = good_unit(values, "m") + ("/s" if name == "velocity" else "")
        shown.append(draw.scaled(values, name, unit))
        # the quantity "velocity" of results is that of an approach
        label = (
            f"{'position $x$' if name == 'position' else 'velocity $v$'} of {data['body'].values[0]} ({unit})"
        )
        (axes.set_xlabel if name == "position" else axes.set_ylabel)(label)
    axes.plot(*shown, color=draw.BLUE, lw=0.8)
    axes.plot(shown[0][0], shown[1][0], "o", color=draw.BLUE, ms=4)
    draw.draw_zero(axes)


def _draw_forces(axes: draw.Axes, data: xr.Dataset, time: FloatArray, time_unit: str) -> None:
    """The forces of the first joint against time."""
    names = [name for name in ("normal_force", "tangential_force") if name in data]
    unit = good_unit(data["normal_force"].values[:, 0], "N")
    for name, color in zip(names, (draw.BLUE, draw.GREEN), strict=False):
        label = f"{QUANTITIES[name].long_name} ${QUANTITIES[name].symbol}$"
        axes.plot(time, draw.scaled(data[name].values[:, 0], name, unit), color=color, lw=1.0, label=label)
    axes.set(xlabel=draw.axis_label("time", time_unit), ylabel=f"force at {data['joint'].values[0]} ({unit})")
    draw.draw_zero(axes)
    draw.legend_above(axes)


def _draw_spectrum(axes: draw.Axes, spectrum: xr.DataArray) -> None:
    """Amplitudes of a force against frequency."""
    largest = float(spectrum.max())
    unit = good_unit(np.array([largest]), "N")
    hertz = good_unit(spectrum["frequency"].values, "Hz")
    shown = np.maximum(spectrum.values, _DECADES * largest)
    frequency = draw.scaled(spectrum["frequency"].values, "frequency", hertz)
    axes.plot(frequency, draw.scaled(shown, str(spectrum.name), unit), color=draw.BLUE, lw=0.8)
    if largest > 0.0:
        axes.set_yscale("log")
    axes.set_xlabel(f"frequency $f$ ({hertz})")
    axes.set_ylabel(f"amplitude of ${QUANTITIES[str(spectrum.name)].symbol}$ ({unit})")


def _draw_energies(axes: draw.Axes, data: xr.Dataset, time: FloatArray, time_unit: str) -> None:
    """Energy stored, dissipated, and brought in since the start."""

    def total(names: tuple[str, ...]) -> FloatArray:
        return np.asarray(sum((data[name].values for name in names if name in data), np.zeros(time.size)))

    kinetic, stored = total(_STORED[:1]), total(_STORED)
    dissipated, done = total(_DISSIPATED), total(_DONE)
    unit = good_unit(np.concatenate([stored + dissipated, done]), "J")
    layers = (
        (np.zeros(time.size), kinetic, draw.ORANGE, "kinetic"),
        (kinetic, stored, draw.BLUE, "elastic"),
        (stored, stored + dissipated, draw.GREY, "dissipated"),
    )
    for low, high, color, label in layers:
        bottom, top = draw.scaled(low, "kinetic_energy", unit), draw.scaled(high, "kinetic_energy", unit)
        axes.fill_between(time, bottom, top, color=color, alpha=0.6, lw=0, label=label)
    brought = draw.scaled(stored[0] + done, "kinetic_energy", unit)
    axes.plot(time, brought, color="black", lw=0.8, ls="--", label="at the start, and work")
    axes.set(xlabel=draw.axis_label("time", time_unit), ylabel=f"energy ({unit})")
    draw.legend_above(axes)


class LineInMotion(NamedTuple):
    """The springs of one joint in motion."""

    data: xr.Dataset
    """Over ``step`` with ``time``: ``indentation``, ``contact_radius``, forces, and perhaps ``stick_radius``."""
    position: FloatArray
    """x >= 0 of the springs in m."""
    profile: FloatArray
    """g(x) in m."""
    slips: bool
    """Whether there is friction."""


def write_motion_animation(line: LineInMotion, rows: FloatArray, file: Path) -> None:
    """
    The line of springs under its profile beside the forces against time, row by row, as a GIF.

    Parameters
    ----------
    rows : ndarray of int
        The row of every frame.
    file : path
        Ends with ``.gif``.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    data = line.data.expand_dims("joint", axis=1)
    time_unit = good_unit(line.data["time"].values, "s")
    time = draw.scaled(line.data["time"].values, "time", time_unit)
    with draw.new_figure(9.0, 3.6, letters=False) as figure:
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2)
        _draw_forces(right, data, time, time_unit)
        moment = right.axvline(time[rows[0]], color=draw.ORANGE, lw=1.2)
        writer = PillowWriter(fps=12)
        with writer.saving(figure, str(file), dpi=90):
            for row in rows:
                left.clear()
                _draw_springs(left, line, row)
                moment.set_xdata([time[row], time[row]])
                writer.grab_frame()


def _draw_springs(axes: draw.Axes, line: LineInMotion, row: int) -> None:
    """The springs of one row: those in contact are pressed by the profile, and with friction stick or slip."""
    depth = line.data["indentation"].values
    deepest = float(np.max(np.abs(depth))) or 1.0
    x_unit, z_unit = good_unit(line.position, "m"), good_unit(np.array([deepest]), "m")
    x = np.concatenate([-line.position[:0:-1], line.position])
    g = np.concatenate([line.profile[:0:-1], line.profile])
    body, across = (
        draw.scaled(g - depth[row], "indentation", z_unit),
        draw.scaled(x, "contact_radius", x_unit),
    )
    touches = np.abs(x) < float(line.data["contact_radius"][row])
    sticks = touches
    if line.slips:
        sticks = np.abs(x) < float(line.data["stick_radius"][row])
    top = np.where(touches, np.minimum(body, 0.0), 0.0)
    base = -1.5 * float(draw.scaled(np.array([deepest]), "indentation", z_unit)[0])
    for chosen, color, label in (
        (~touches, draw.LIGHT, "free"),
        (sticks, draw.BLUE, "sticks" if line.slips else "pressed"),
        *(((touches & ~sticks, draw.ORANGE, "slips"),) if line.slips else ()),
    ):
        axes.vlines(across[chosen], base, top[chosen], color=color, lw=2.0, label=label)
    axes.plot(across, body, color="black", lw=1.2)
    axes.set_ylim(base, -base)
    axes.set(xlabel=f"position on the line $x$ ({x_unit})", ylabel=f"height $z$ ({z_unit})")
    draw.legend_above(axes)
