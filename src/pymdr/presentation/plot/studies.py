"""Figures of studies without a path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    CYCLE,
    GREEN,
    GREY,
    LIGHT,
    MARKED_ROWS,
    ORANGE,
    axis_label,
    draw_zero,
    label_history,
    legend_above,
    lengths,
    letter_panels,
    new_figure,
    scaled,
    styled,
    typeset,
    with_unit,
    without_peaks,
)
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pymdr.interpretation.validity import Assumption

_LINES: Mapping[str, Any] = {
    "MaugisDugdale": {"color": ORANGE, "lw": 3.0, "alpha": 0.6},
    "JKR": {"color": BLUE, "lw": 1.3},
    "DMT": {"color": GREEN, "lw": 1.3},
}
_LABELS = {"MaugisDugdale": "Maugis-Dugdale"}


def loop_study(studies: Sequence[tuple[float | None, xr.Dataset]]) -> Figure:
    """
    Dissipation, damping ratio and stiffness of steady loops against their amplitude.

    Parameters
    ----------
    studies : sequence of (coefficient, xarray.Dataset)
        For every coefficient of friction (None if there is only one) ``amplitude`` (m), ``dissipated_per_cycle``
        (J), ``damping_ratio`` and ``secant_stiffness`` (N/m) in one dimension, with ``sliding_shift`` (m).
    """
    with styled():
        figure = new_figure(10.4, 3.5)
        amplitudes = np.concatenate([study["amplitude"].values for _, study in studies])
        unit = good_unit(amplitudes, "m")
        columns = (
            ("dissipated_per_cycle", "energy dissipated per cycle", "J"),
            ("damping_ratio", "damping ratio", ""),
            ("secant_stiffness", "secant stiffness", "N/m"),
        )
        for axes, (name, y_label, si) in zip(figure.subplots(1, 3), columns, strict=True):
            values = np.concatenate([study[name].values for _, study in studies])
            shown = good_unit(values, si) if si else ""
            axes.set_xscale("log" if amplitudes.size > len(studies) else "linear")
            if name == "dissipated_per_cycle" and (values > 0.0).any():
                axes.set_yscale("log")
            for i, (mu, study) in enumerate(studies):
                order = np.argsort(study["amplitude"].values)
                u, sliding = study["amplitude"].values[order], float(study["sliding_shift"].values)
                x, limit = lengths(u, unit), lengths(np.array(sliding), unit)
                y = study[name].values[order]
                y = np.asarray(from_si(y, si, shown)) if si else y
                if mu is None and u.min() < sliding < u.max():
                    axes.axvline(float(limit), color=ORANGE, lw=1.0, ls=":", label="sliding begins")
                if mu is None and name == "dissipated_per_cycle" and (y > 0.0).any():
                    _draw_cubic(axes, x, y, limit)
                few = "o" if u.size <= MARKED_ROWS else None
                colour, label = (BLUE, None) if mu is None else (CYCLE[i % len(CYCLE)], f"$\\mu$ = {mu:g}")
                axes.plot(x, y, color=colour, lw=1.5, marker=few, ms=3, label=label)
                if f"{name}_low" in study:
                    ends = [study[f"{name}_{end}"].values[order] for end in ("low", "high")]
                    low, high = (np.asarray(from_si(v, si, shown)) if si else v for v in ends)
                    band = "band of the scatter" if mu is None else None
                    axes.fill_between(x, low, high, color=colour, alpha=0.2, lw=0, label=band)
            axes.set_xlabel(f"amplitude of the shift ({unit})")
            axes.set_ylabel(with_unit(y_label, shown))
            if name == "damping_ratio":
                axes.set_ylim(bottom=0.0)
            legend_above(axes)
        letter_panels(figure)
    return figure


def impact_figure(data: xr.Dataset, friction: float | None) -> Figure:
    """
    Force and contact radius of an impact against time, and the force against the indentation.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``step``: ``time``, ``indentation``, ``normal_force`` and ``contact_radius``; for oblique impacts
        with friction also ``tangential_force`` and ``stick_radius``. Radii are optional.
    friction : float or None
        Coefficient of friction.
    """
    with styled():
        names = [name for name in ("time", "indentation", "normal_force", "contact_radius") if name in data]
        oblique = "tangential_force" in data
        units = {name: good_unit(data[name].values, QUANTITIES[name].unit) for name in names}
        shown = {name: scaled(data[name].values, name, unit) for name, unit in units.items()}
        figure = new_figure(11.4 if oblique else 7.6, 3.4)
        panels = figure.subplots(1, 3 if oblique else 2)
        first, second = panels[0], panels[1]
        first.plot(shown["time"], shown["normal_force"], color=BLUE, lw=1.5)
        first.set_xlabel(axis_label("time", units["time"]))
        first.set_ylabel(axis_label("normal_force", units["normal_force"]), color=BLUE)
        draw_zero(first)
        if "contact_radius" in data:
            radius = first.twinx()
            radius.plot(shown["time"], shown["contact_radius"], color=ORANGE, lw=1.2, ls="--")
            radius.set_ylabel(axis_label("contact_radius", units["contact_radius"]), color=ORANGE)
            # both scales have 0 at the same height
            low, high = first.get_ylim()
            top = 1.05 * float(np.nanmax(shown["contact_radius"], initial=0.0)) or 1.0
            if low < 0.0 < high:
                radius.set_ylim(top * low / high, top)
            else:
                first.set_ylim(bottom=0.0)
                radius.set_ylim(0.0, top)
        second.plot(shown["indentation"], shown["normal_force"], color=BLUE, lw=1.5)
        second.set_xlabel(axis_label("indentation", units["indentation"]))
        second.set_ylabel(axis_label("normal_force", units["normal_force"]))
        draw_zero(second)
        if oblique:
            _draw_tangential(panels[2], data, shown["time"], units["time"], friction)
        letter_panels(figure)
    return figure


def restitution_study(data: xr.Dataset) -> Figure:
    """
    Coefficient of restitution and contact time against the speed.

    Parameters
    ----------
    data : xarray.Dataset
        ``restitution`` and ``contact_time`` (s; inf if the bodies stick) over ``speed`` (m/s).
    """
    with styled():
        figure = new_figure(8.4, 3.4)
        ordered = data.sortby("speed")
        v_unit = good_unit(ordered["speed"].values, "m/s")
        v = np.asarray(from_si(ordered["speed"].values, "m/s", v_unit))
        time = np.where(np.isfinite(ordered["contact_time"].values), ordered["contact_time"].values, np.nan)
        unit = good_unit(time, "s")
        few = "o" if v.size <= MARKED_ROWS else None
        shown = (
            (ordered["restitution"].values, "coefficient of restitution $e$"),
            (np.asarray(from_si(time, "s", unit)), f"contact time $T$ ({unit})"),
        )
        for axes, (values, label) in zip(figure.subplots(1, 2), shown, strict=True):
            axes.plot(v, values, color=BLUE, lw=1.5, marker=few, ms=3)
            axes.set_xscale("log" if v.size > 1 else "linear")
            axes.set_xlabel(f"speed $v$ ({v_unit})")
            axes.set_ylabel(label)
            axes.set_ylim(bottom=0.0)
        letter_panels(figure)
    return figure


def _draw_tangential(
    axes: Axes, data: xr.Dataset, time: FloatArray, time_unit: str, friction: float | None
) -> None:
    """The tangential force within the friction limits, shaded while part of the contact sticks."""
    unit = good_unit(data["tangential_force"].values, "N")
    force = scaled(data["tangential_force"].values, "tangential_force", unit)
    limit = (friction or 0.0) * scaled(data["normal_force"].values, "normal_force", unit)
    if "stick_radius" in data:
        sticking = data["stick_radius"].values > 0.0
        axes.fill_between(time, -limit, limit, where=sticking, color=LIGHT, lw=0, label="part sticks")
    for sign in (-1.0, 1.0):
        label = "$\\pm\\mu F_N$" if sign > 0.0 else None
        axes.plot(time, sign * limit, color=GREY, lw=0.8, ls=":", label=label)
    axes.plot(time, force, color=GREEN, lw=1.5)
    axes.set_xlabel(axis_label("time", time_unit))
    axes.set_ylabel(axis_label("tangential_force", unit))
    draw_zero(axes)
    legend_above(axes)


def pull_off_figure(curve: Mapping[str, FloatArray], data: xr.Dataset) -> Figure:
    """
    Force against indentation of all equilibria, with the pull-off and the state after the jump into contact.

    Parameters
    ----------
    curve : mapping of str to ndarray
        ``indentation`` (m) and ``normal_force`` (N) of all equilibria.
    data : xarray.Dataset
        Quantities of the pull-off.
    """
    with styled():
        figure = new_figure(5.4, 4.0)
        axes = figure.subplots()
        d_unit, unit = (
            good_unit(curve[name], QUANTITIES[name].unit) for name in ("indentation", "normal_force")
        )
        axes.plot(
            lengths(curve["indentation"], d_unit),
            scaled(curve["normal_force"], "normal_force", unit),
            color=BLUE,
            lw=1.3,
            label="equilibria",
        )
        for label, colour, names in (
            ("last stable state", ORANGE, ("indentation", "normal_force")),
            ("after the jump into contact", GREEN, ("jump_in_indentation", "jump_in_force")),
        ):
            d, force = (data[name].values for name in names)
            axes.plot(
                lengths(d, d_unit), scaled(force, "normal_force", unit), "o", ms=5, color=colour, label=label
            )
        axes.set_xlabel(axis_label("indentation", d_unit))
        axes.set_ylabel(axis_label("normal_force", unit))
        draw_zero(axes)
        legend_above(axes)
    return figure


def compared_laws(
    curves: Mapping[str, Mapping[str, FloatArray]],
    pull_off_force: Mapping[str, float],
    pressures: Mapping[str, xr.DataArray],
) -> Figure:
    """
    Force against indentation, and the pressure of the unloaded contact, under several laws of adhesion.

    Parameters
    ----------
    curves : mapping of str to mapping of str to ndarray
        ``indentation`` (m) and ``normal_force`` (N) of all equilibria by law.
    pull_off_force : mapping of str to float
        In N by law, below 0.
    pressures : mapping of str to xarray.DataArray
        Pressure in Pa over ``r`` by law.
    """
    with styled():
        figure = new_figure(9.6, 4.2)
        left, right = figure.subplots(1, 2)
        _draw_equilibria(left, curves, pull_off_force)
        _draw_pressures(right, pressures, -pull_off_force["DMT"] if "DMT" in pull_off_force else None)
        for axes in (left, right):
            draw_zero(axes)
            legend_above(axes)
        letter_panels(figure)
    return figure


def _draw_equilibria(
    axes: Axes, curves: Mapping[str, Mapping[str, FloatArray]], pull_off_force: Mapping[str, float]
) -> None:
    depths, forces = ([curve[name] for curve in curves.values()] for name in ("indentation", "normal_force"))
    x_unit = good_unit(np.concatenate(depths), "m")
    unit = good_unit(np.concatenate(forces), "N")
    for name, d, force in zip(curves, depths, forces, strict=True):
        label = f"{_LABELS.get(name, name)}, pull-off at {typeset(pull_off_force[name], 'N')}"
        x, y = lengths(d, x_unit), scaled(force, "normal_force", unit)
        axes.plot(x, y, label=label, **_LINES[name])
    axes.set_xlabel(axis_label("indentation", x_unit))
    axes.set_ylabel(axis_label("normal_force", unit))


def _draw_pressures(axes: Axes, pressures: Mapping[str, xr.DataArray], pull: float | None) -> None:
    """Pressures by law; the pull of DMT in N, outside the contact, is given in its label."""
    known = [p.values[np.isfinite(p.values)] for p in pressures.values()]
    bounded = [p.values for p in pressures.values() if float(p["edge_amplitude"]) == 0.0]
    high = max(float(without_peaks(p).max()) for p in known)
    deepest = min((float(p.min()) for p in bounded), default=-high)
    # an infinite or far larger edge is cut
    low = max(1.25 * deepest, -3.0 * high) or -high
    r_unit = good_unit(np.concatenate([p["r"].values for p in pressures.values()]), "m")
    unit = good_unit(np.array([low, high]), "Pa")
    for name, p in pressures.items():
        label = _LABELS.get(name, name)
        if float(p["edge_amplitude"]) != 0.0:
            label += ", singular at its edge"
        if name == "DMT" and pull is not None:
            label += f", and a pull of {typeset(pull, 'N')} outside"
        y = scaled(p.values, "pressure", unit)
        axes.plot(lengths(p["r"].values, r_unit), y, label=label, **_LINES[name])
    axes.set_ylim(*scaled(np.array([low, 1.2 * high]), "pressure", unit))
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f"{RADIUS.label} ({r_unit})")
    axes.set_ylabel(axis_label("pressure", unit))


def _draw_cubic(axes: Axes, x: FloatArray, y: FloatArray, sliding: FloatArray) -> None:
    """The cubic law of small loops, from the smallest dissipating one."""
    first = int(np.flatnonzero(y > 0.0)[np.argmin(x[y > 0.0])])
    end = max(min(float(x.max()), float(sliding)), x[first])
    if end > x[first]:
        ends = np.array([x[first], end])
        axes.plot(
            ends, y[first] * (ends / ends[0]) ** 3, color=GREY, lw=1.0, ls="--", label="cube of the amplitude"
        )


_CREEP_LAWS = {"plain": ("MDR springs", BLUE), "calibrated": ("with Kalker's slope", ORANGE)}
_MOST_LOADS = 5
_ROUNDING = 1e-4
"""Relative range of values that is drawn as constant."""


def rolling_study(data: xr.Dataset, curves: xr.Dataset, springs: xr.Dataset | None) -> Figure:
    """
    Creep force against creepage by several laws, with the line load below its limit, or the force along a path.

    Parameters
    ----------
    data : xarray.Dataset
        ``creep_force`` (N) over ``creepage``, or over ``distance`` (m).
    curves : xarray.Dataset
        ``creep_force`` (N) over ``law`` and ``creepage``, with the ``limit`` of friction in N.
    springs : xarray.Dataset or None
        ``line_load`` (N/m) over ``creepage`` and ``x`` (m), and ``cap``; None along a path.
    """
    with styled():
        figure = new_figure(9.6, 4.0)
        left, right = figure.subplots(1, 2)
        limit = float(curves.attrs["limit"])
        unit = good_unit(np.array([limit]), "N")
        forces = curves["creep_force"].values
        for law, force in zip(curves["law"].values, forces, strict=True):
            label, colour = _CREEP_LAWS[str(law)]
            left.plot(
                curves["creepage"].values,
                scaled(force, "tangential_force", unit),
                color=colour,
                lw=1.5,
                label=label,
            )
        left.axhline(
            float(scaled(np.array(limit), "tangential_force", unit)),
            color=GREY,
            lw=1.0,
            ls=":",
            label=r"$\mu F_N$",
        )
        left.set_xlabel(r"creepage $\zeta$")
        left.set_ylabel(f"creep force $F_x$ ({unit})")
        left.set_xlim(0.0, float(curves["creepage"][-1]))
        left.set_ylim(bottom=0.0)
        if springs is None:
            x = data["distance"].values
            x_unit = good_unit(x, "m")
            right.plot(
                lengths(x, x_unit),
                scaled(data["creep_force"].values, "tangential_force", unit),
                "o-",
                ms=3,
                color=BLUE,
            )
            right.set_xlabel(f"distance rolled ({x_unit})")
            right.set_ylabel(f"creep force $F_x$ ({unit})")
            draw_zero(right)
        else:
            zeta = data["creepage"].values
            few = "o" if zeta.size <= MARKED_ROWS else "."
            colour = _CREEP_LAWS[str(data.attrs["law"])][1]
            left.plot(
                np.abs(zeta),
                np.abs(scaled(data["creep_force"].values, "tangential_force", unit)),
                few,
                ms=4,
                color=colour,
            )
            _draw_springs(right, springs)
            legend_above(right)
        legend_above(left)
        letter_panels(figure)
    return figure


def _draw_springs(axes: Axes, springs: xr.Dataset) -> None:
    x, cap = springs["x"].values, springs["cap"].values
    x_unit, unit = good_unit(x, "m"), good_unit(cap, "N/m")
    place = lengths(x, x_unit)
    signs = [sign for sign in (1.0, -1.0) if np.any(sign * springs["line_load"].values > 0.0)] or [1.0]
    for sign, label in zip(signs, (r"$\mu E^* (d - g)$", None), strict=False):
        limit = sign * np.asarray(from_si(cap, "N/m", unit))
        axes.plot(place, limit, color=GREY, lw=1.0, ls="--", zorder=3, label=label)
    rows = np.unique(np.linspace(0, springs.sizes["creepage"] - 1, _MOST_LOADS).round().astype(int))
    for i, row in enumerate(rows):
        zeta, q = float(springs["creepage"][row]), springs["line_load"].values[row]
        axes.plot(
            place,
            from_si(q, "N/m", unit),
            color=CYCLE[i % len(CYCLE)],
            lw=1.5,
            label=rf"$\zeta$ = {zeta:.3g}",
        )
    axes.set_xlabel(f"position on the line $x$ ({x_unit}), rolling to the right")
    axes.set_ylabel(f"line load $q$ ({unit})")


def sliding_study(data: xr.Dataset) -> Figure:
    """
    Coefficient of friction against speed with its limits, and the leading and trailing edge of the contact.

    Parameters
    ----------
    data : xarray.Dataset
        ``friction_coefficient`` over ``speed`` (m/s), ``leading_edge`` and ``trailing_edge`` (m) or ``indentation`` (m), and
        optionally ``slow_limit`` and ``fast_limit``.
    """
    with styled():
        figure = new_figure(9.6, 4.0)
        left, right = figure.subplots(1, 2)
        ordered = data.sortby("speed")
        v_unit = good_unit(ordered["speed"].values, "m/s")
        v = np.asarray(from_si(ordered["speed"].values, "m/s", v_unit))
        few = "o" if v.size <= MARKED_ROWS else None
        friction = ordered["friction_coefficient"].values
        left.loglog(v, friction, color=BLUE, lw=1.5, marker=few, ms=3, label="MDR springs")
        for name, label, colour in (
            ("slow_limit_over_speed", "slow limit (half of MDR)", ORANGE),
            ("fast_limit_times_speed", "fast limit", GREEN),
        ):
            if name in data.attrs:
                speed = ordered["speed"].values
                along = data.attrs[name] * (speed if name.endswith("over_speed") else 1.0 / speed)
                left.loglog(v, along, color=colour, lw=1.2, ls="--", label=label)
        if "fast_limit" in ordered and "fast_limit_times_speed" not in data.attrs:
            left.loglog(v, ordered["fast_limit"].values, color=GREEN, lw=1.2, ls="--", label="fast limit")
        # outside its range a limit is far off
        left.set_ylim(0.3 * float(friction.min()), 4.0 * float(friction.max()))
        left.set_ylabel("coefficient of friction $F_x/F_N$")
        parts = {"leading_edge": ("leading", "-"), "trailing_edge": ("trailing", "--")}
        if "leading_edge" not in ordered:
            parts = {"indentation": ("indentation", "-")}
        unit = good_unit(np.concatenate([ordered[name].values for name in parts]), "m")
        for name, (label, style) in parts.items():
            shown = lengths(ordered[name].values, unit)
            right.semilogx(v, shown, style, color=BLUE, lw=1.5, marker=few, ms=3, label=label)
        right.set_ylabel(
            f"edges of the contact on the line ({unit})" if len(parts) == 2 else f"depth $d$ ({unit})"
        )
        draw_zero(right)
        for axes in (left, right):
            axes.set_xlabel(f"speed $v$ ({v_unit})")
            legend_above(axes)
        letter_panels(figure)
    return figure


def columns_study(data: xr.Dataset, labels: Mapping[str, str]) -> Figure:
    """
    Columns of a study over its rows, a panel each.

    Parameters
    ----------
    data : xarray.Dataset
        Over one dimension.
    labels : mapping of str to str
        Axis labels by column.
    """
    (along,) = data.dims
    names = [name for name in labels if name in data.data_vars]
    with styled():
        figure = new_figure(2.9 * max(len(names), 1), 2.9)
        for i, name in enumerate(names):
            axes = figure.add_subplot(1, len(names), i + 1)
            si = str(data[name].attrs.get("units", ""))
            unit = good_unit(data[name].values, si)
            values = np.asarray(from_si(data[name].values, si, unit))
            axes.plot(data[along].values, values, "o-", color=BLUE, ms=3.0, lw=1.0)
            label_history(axes, str(along))
            label = QUANTITIES[name].label if name in QUANTITIES else labels[name]
            axes.set_ylabel(with_unit(label, unit))
            _limit_rounding(axes, values)
        letter_panels(figure)
    return figure


def _limit_rounding(axes: Axes, values: FloatArray) -> None:
    """Start at 0 if values hardly differ, so that their rounding is not enlarged."""
    known = values[np.isfinite(values)]
    if known.size and np.ptp(known) <= _ROUNDING * np.max(np.abs(known)):
        axes.set_ylim(*sorted((0.0, 1.2 * float(known[0]) or 1.0)))


def conditions_study(assumptions: Sequence[Assumption]) -> Figure:
    """Assumptions of a model, each relative to its limit."""
    with styled():
        figure = new_figure(6.4, 1.2 + 0.35 * len(assumptions))
        axes = figure.add_subplot()
        colours = [BLUE if a.met else ORANGE for a in assumptions]
        measures, limits = (np.array([getattr(a, n) for a in assumptions]) for n in ("measure", "limit"))
        with np.errstate(divide="ignore", invalid="ignore"):
            axes.barh([a.name for a in assumptions], np.minimum(measures / limits, 3.0), color=colours)
        axes.axvline(1.0, color=GREY, lw=1.0)
        axes.invert_yaxis()
        axes.set_xlabel("measure / limit (cut at 3)")
    return figure
