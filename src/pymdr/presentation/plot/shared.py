"""Shared by all figures: data, style, colours, units and the thinning of long histories."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from string import ascii_lowercase
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.peaks import infinite_pressures
from pymdr.interpretation.validity import Assumption
from pymdr.presentation.text import assumption_text
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si, good_unit, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes as Axes
    from matplotlib.contour import ContourSet
    from matplotlib.figure import Figure as Figure

    from pymdr.interpretation.jumps import Branches

IntArray = NDArray[np.int_]

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"
SKY, AMBER, PURPLE = "#56B4E9", "#E69F00", "#CC79A7"
GREY, LIGHT = "#666666", "#DDDDDD"
CYCLE = (BLUE, ORANGE, SKY, AMBER, PURPLE, GREEN)
"""Okabe and Ito's colours, as in ``figures.mplstyle``."""
SMALL = 8.0
"""Font size in points of legends and of notes in panels."""
MOST = 20_000
"""Largest number of points drawn of one curve."""
MARKED_ROWS = 40
"""Largest number of rows that are marked by points."""
_GRIDS = (2000, 1000, 500, 250)
"""Cells across a picture; the finest are the size of its pixels."""
_NAMED = 3
"""Largest number of kinks that are labelled by their radii."""
_UNMET = 100
"""Characters per line below a figure."""
_ROUNDING = 1e-4
"""Relative range of values that is drawn as constant."""


@dataclass(frozen=True)
class LayersDrawn:
    """A layered body as it is drawn."""

    thickness: tuple[float, ...]
    """From the surface downward in m."""
    materials: tuple[str, ...]
    """Material of each layer."""
    base: str
    """Material below the layers."""
    rigid: bool
    """Whether the base is rigid."""
    half_spaces: Mapping[str, tuple[FloatArray, FloatArray]]
    """Indentations in m and forces in N on homogeneous half-spaces, by material."""
    both: bool = False
    """Whether the other body is deformed too."""


@dataclass(frozen=True)
class FigureData:
    """The data of the figures."""

    data: xr.Dataset
    """Quantities over ``step``."""
    row: int
    """The row that is drawn; -1 if none is valid."""
    field: Callable[[str, FloatArray | None], xr.DataArray] | None
    """A field of that row at radii; None if no row is valid."""
    gap: Callable[[FloatArray], FloatArray]
    """f(r)."""
    bands: Mapping[str, tuple[FloatArray, FloatArray]]
    """Lower and upper ends of the bands of quantities, by name."""
    on_line: bool
    """Whether there is a line of springs to draw."""
    field_at: Callable[[str, FloatArray | None, int], xr.DataArray] | None = None
    """A field at radii in any row."""
    friction: float | None = None
    """Coefficient of friction; None without friction."""
    equilibria: Callable[[], Branches | None] | None = None
    """All equilibria of an adhesive contact; None without adhesion. Returns None if the bodies never touch."""
    modulus: float | None = None
    """E* in Pa, which converts the force of a spring into its displacement."""
    deflection: Callable[[FloatArray], FloatArray] | None = None
    """Compression in m of springs with memory at positions; None without memory."""
    kinks: Callable[[], FloatArray] | None = None
    """Radii in m at which the profile may have a kink; None if kinks are not searched."""
    loading: Callable[[FloatArray], Mapping[str, FloatArray]] | None = None
    """Quantities at indentations between the rows; None if they depend on more than the indentation."""
    pull: float | None = None
    """Attractive force in N outside the contact that is not part of the pressure (DMT); None without it."""
    refusal: str = ""
    """Reason why no row is valid."""
    layers: LayersDrawn | None = None
    """The layers of the body; None without layers."""
    extent: float | None = None
    """Radius in m up to which the profile of a refused contact is drawn."""


@dataclass(frozen=True)
class Plots:
    """The figures of a law, and their data."""

    data: FigureData
    overview: Callable[[FigureData], Figure]
    """Section above its springs, curve or loop, and a field."""
    figures: Callable[[FigureData], dict[str, Figure]]
    """All figures by name."""


@contextmanager
def new_figure(width: float, height: float, *, letters: bool = True) -> Iterator[Figure]:
    """An empty figure of a size in inches, to be drawn in the style of all figures; letters for its panels come last."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from pymdr.presentation.plot.drawing import Drawing

    style = mpl.rc_params_from_file(str(files("pymdr") / "figures.mplstyle"), use_default_template=False)
    with mpl.rc_context(style):
        figure = Drawing(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)  # remembers what it measured of formulas
        yield figure
        _write_short_decades(figure)
        _show_whole_points(figure)
        if letters:
            letter_panels(figure)


def _write_short_decades(figure: Figure) -> None:
    """Plain numbers, such as 20, at logarithmic axes of less than two decades, which matplotlib writes as 2 times a power."""
    from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            if axis.get_scale() != "log" or not 1e-3 <= low < high < min(1e5, 100.0 * low):
                continue
            is_wide = high > 10.0 * low
            axis.set_major_locator(
                LogLocator(subs=(1.0, 2.0, 5.0)) if is_wide else MaxNLocator(4, steps=[1, 2, 5, 10])
            )
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())


def _show_whole_points(figure: Figure) -> None:
    """Points on the edge of their panel, such as those at 0, are drawn whole unless the panel enlarges a part of their curve."""
    for axes in figure.axes:
        box = axes.get_window_extent()
        for line in axes.lines:
            if line.get_marker() == "None":
                continue
            points = line.get_transform().transform(line.get_xydata())
            known = points[np.isfinite(points).all(axis=1)]
            if known.size and np.all(
                (known >= np.asarray(box.min) - 0.5) & (known <= np.asarray(box.max) + 0.5)
            ):
                line.set_clip_on(False)


def thinned(values: FloatArray, most: int = MOST) -> IntArray:
    """Indices of about `most` points at the most, with the extremes of every block: for curves over step or time."""
    n = values.size
    if n <= most:
        return np.arange(n)
    size = -(-n // (most // 2))
    end = n // size * size
    blocks = values[:end].reshape(-1, size)
    first = np.arange(0, end, size)
    low = first + np.argmin(np.where(np.isnan(blocks), np.inf, blocks), axis=1)
    high = first + np.argmax(np.where(np.isnan(blocks), -np.inf, blocks), axis=1)
    return np.unique(np.concatenate([low, high, np.arange(end, n), [0, n - 1]]))


def thinned_curve(x: FloatArray, y: FloatArray, most: int = MOST) -> tuple[FloatArray, FloatArray]:
    """
    A long curve in a plane, thinned to its steps from cell to cell of a fine grid, each step once.

    Parameters
    ----------
    x, y : ndarray
        Points in order, with nan between disconnected parts.
    most : int
        Number of points up to which a curve is unchanged; only curves that fill the picture keep more.

    Returns
    -------
    tuple of ndarray
        Some of the points with the extremes, and nan between disconnected parts.
    """
    known = np.isfinite(x) & np.isfinite(y)
    if x.size <= most or not known.any():
        return x, y
    extremes = [
        int(pick(np.where(known, v, np.nan))) for v in (x, y) for pick in (np.nanargmin, np.nanargmax)
    ]
    for cells in _GRIDS:
        cell = np.where(known, _cells(x, known, cells) * (cells + 1) + _cells(y, known, cells), -1)
        kept = np.zeros(x.size, dtype=bool)
        enters = np.flatnonzero(np.diff(cell)) + 1
        steps = cell[enters - 1] * (cells + 1) ** 2 + cell[enters]
        first = enters[np.unique(steps, return_index=True)[1]]
        kept[[*extremes, *np.flatnonzero(known)[:1]]] = True
        kept[first] = kept[first - 1] = True
        if np.count_nonzero(kept) <= most:
            break
    rows = np.flatnonzero(kept)
    gaps = np.flatnonzero((np.diff(rows) > 1) & (np.diff(cell[rows]) != 0)) + 1
    return np.insert(x[rows], gaps, np.nan), np.insert(y[rows], gaps, np.nan)


def _cells(values: FloatArray, known: NDArray[np.bool_], cells: int) -> IntArray:
    low, high = float(np.min(values[known])), float(np.max(values[known]))
    fraction = (np.where(known, values, low) - low) / ((high - low) or 1.0)
    return np.asarray(fraction * cells, dtype=int)


def mark_radii(
    axes: Axes, a: float, c: float, unit: str, *, both_sides: bool = False, named: bool = True
) -> None:
    """Dotted lines at the contact and cohesive radius, labelled above the frame."""
    for radius, name in ((a, "$a$"), (c, "$c$")):
        if radius == 0.0 or (name == "$c$" and not c > a):
            continue
        at = float(lengths(np.array(radius), unit))
        for x in (-at, at) if both_sides else (at,):
            axes.axvline(x, color=GREY, lw=0.8, ls=":")
        if named:
            side = "center" if not c > 1.0001 * a else "right" if name == "$a$" else "left"
            axes.annotate(
                name,
                (at, 1.0),
                (0, 2),
                xycoords=axes.get_xaxis_transform(),
                textcoords="offset points",
                ha=side,
                color=GREY,
            )


def edge_sign(p: xr.DataArray, radius: float) -> float:
    """1 if a pressure goes to infinity at an edge, -1 to minus infinity, 0 if finite."""
    amplitude = float(p["edge_amplitude"])
    if not np.isnan(amplitude):
        return float(np.sign(amplitude))
    inside = p.values[(p["r"].values < radius) & np.isfinite(p.values)]
    return float(np.sign(inside[-1])) if inside.size else 0.0


def infinite_within(data: FigureData, a: float) -> tuple[float, ...]:
    """Radii in m inside a contact at which its pressure is infinite."""
    return infinite_pressures(data.gap, np.zeros(0) if data.kinks is None else data.kinks(), a)


def peak_notes(radii: Sequence[float]) -> list[str]:
    """Labels of the places inside a contact where its pressure is infinite."""
    notes = ["sharp tip: $p(0) = \\infty$"] if 0.0 in radii else []
    kinks = [typeset(r, "m") for r in radii if r > 0.0]
    if kinks:
        at = f"$r$ = {', '.join(kinks)}" if len(kinks) <= _NAMED else f"{len(kinks)} radii"
        notes.append(f"kink: $p \\to \\infty$ at {at}, logarithmic")
    return notes


def note_peaks(axes: Axes, radii: Sequence[float]) -> None:
    """Label the places inside a contact where the pressure in a panel is infinite."""
    if notes := peak_notes(radii):
        axes.text(
            0.02, 0.98, "\n".join(notes), va="top", transform=axes.transAxes, fontsize=SMALL, color=ORANGE
        )


def singularities(amplitude: float, sign: float, peaks: Sequence[float]) -> str:
    """Label of the places where a pressure is infinite: its edge with the amplitude, a sharp tip, kinks."""
    notes = []
    if sign != 0.0:
        label = f"$p \\to {'' if sign > 0.0 else '-'}\\infty$ at $r = a$"
        if not np.isnan(amplitude):
            label += f":\n$p \\simeq K/\\sqrt{{a-r}}$\n$K$ = {typeset(amplitude, 'Pa*m^0.5')}"
        notes.append(label)
    return "\n".join([*notes, *peak_notes(peaks)])


def letter_panels(figure: Figure) -> None:
    """Label the panels of a figure that has several with (a), (b), ...; not second scales or colour bars."""
    panels: list[Axes] = []
    for axes in figure.axes:
        place = axes.get_subplotspec()
        if place is not None and place not in [other.get_subplotspec() for other in panels]:
            panels.append(axes)
    if len(panels) < 2:
        return
    for axes, letter in zip(panels, ascii_lowercase, strict=False):
        axes.annotate(
            f"({letter})",
            (0, 1),
            (-8, 5),
            xycoords="axes fraction",
            textcoords="offset points",
            ha="right",
            va="bottom",
            fontweight="bold",
        )


def legend_above(axes: Axes, title: str | None = None) -> None:
    """A legend above the axes, in as many columns as fit between their sides."""
    labels = axes.get_legend_handles_labels()[1]
    for columns in range(min(len(labels), 4), 0, -1):
        legend = axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.01), borderaxespad=0.0, ncols=columns, title=title
        )
        if legend.get_window_extent().width <= 0.9 * axes.bbox.width:
            return


def colour_bar(levels: ContourSet, axes: Axes, label: str, **shape: Any) -> None:
    """A bar of the colours between levels, with round numbers at it."""
    from matplotlib.ticker import MaxNLocator

    levels.axes.figure.colorbar(levels, ax=axes, label=label, ticks=MaxNLocator(6), **shape)


def typeset(value: float, unit: str = "", digits: int = 4) -> str:
    """A value with its unit and a typographic minus sign."""
    number, _, own = written(value, unit, digits).partition(" ")
    return f"{number} {typeset_unit(own)}".strip().replace("-", "\u2212", 1)


def typeset_unit(unit: str) -> str:
    """A unit with typographic powers and products."""
    powers = (
        unit.replace("*m^0.5", " m$^{1/2}$")
        .replace("^2", "²")
        .replace("^3", "³")
        .replace("^4", "⁴")
        .replace("m^-1", "1/m")
    )
    return powers.replace("*", " ").replace("ohm", "Ω")


def scaled(values: FloatArray, name: str, unit: str) -> FloatArray:
    """Values of a quantity converted from SI to another unit."""
    return np.asarray(from_si(np.asarray(values, dtype=float), QUANTITIES[name].unit, unit))


def lengths(values: FloatArray, unit: str) -> FloatArray:
    """Lengths in m converted to another unit."""
    return np.asarray(from_si(np.asarray(values, dtype=float), "m", unit))


def column(data: FigureData, name: str) -> tuple[FloatArray, str]:
    """A quantity over the rows in a readable unit, and that unit."""
    values = data.data[name].values
    unit = good_unit(values, QUANTITIES[name].unit)
    return scaled(values, name, unit), unit


def axis_label(name: str, unit: str) -> str:
    """Name, symbol and unit of a quantity."""
    return with_unit(QUANTITIES.get(name, RADIUS).label, unit)


def with_unit(label: str, unit: str) -> str:
    """A label of an axis with its unit, if it has one."""
    return f"{label} ({typeset_unit(unit)})" if unit else label


def along_history(data: FigureData) -> tuple[FloatArray, str]:
    """Time or row number, with its axis label."""
    if "time" in data.data:
        values, unit = column(data, "time")
        return values, axis_label("time", unit)
    if "row" in data.data.coords:
        return np.asarray(data.data["row"].values, dtype=float), "row of the path"
    return np.arange(float(data.data.sizes["step"])), "step"


def label_history(axes: Axes, label: str) -> None:
    """Label the axis of time or of numbered rows."""
    from matplotlib.ticker import MaxNLocator

    axes.set_xlabel(label)
    axes.ticklabel_format(axis="x", style="plain")
    if not label.startswith("time"):
        axes.xaxis.set_major_locator(MaxNLocator("auto", integer=True, steps=[1, 2, 5, 10], min_n_ticks=1))


def row_name(data: FigureData, row: int) -> str:
    """Label of a step: its number, or its row of the path if only some rows were kept, and its time."""
    name = f"row {int(data.data['row'].values[row])}" if "row" in data.data.coords else f"step {row}"
    if "time" not in data.data:
        return name
    return f"{name}, $t$ = {typeset(float(data.data['time'].values[row]), 's')}"


def without_peaks(p: FloatArray) -> FloatArray:
    """Finite values of a pressure, cut near a singularity."""
    finite = p[np.isfinite(p)]
    pressed = finite[finite > 0.0]
    return np.minimum(finite, 4.0 * float(np.median(pressed))) if pressed.size else np.zeros(1)


def limit_peaks(axes: Axes, values: FloatArray) -> None:
    """Set the limits of the axis to the given values, with a margin above."""
    top = float(values.max())
    if top > 0.0:
        axes.set_ylim(min(0.0, float(values.min())), 1.12 * top)


def begin_at_zero(axes: Axes) -> None:
    """Start the values at 0, with a margin above the largest."""
    top = float(axes.dataLim.y1)
    axes.set_ylim(0.0, 1.05 * top if 0.0 < top < np.inf else None)


def limit_rounding(axes: Axes, values: FloatArray) -> None:
    """Start at 0 if values hardly differ, so that their rounding is not enlarged; values that are all 0 have a tick there alone."""
    known = values[np.isfinite(values)]
    if not known.size or np.ptp(known) > _ROUNDING * np.max(np.abs(known)):
        return
    if known.any():
        axes.set_ylim(*sorted((0.0, 1.2 * float(known[0]))))
    else:
        axes.set(ylim=(-1.0, 1.0), yticks=[0.0])


def show_text(axes: Axes, text: str) -> None:
    """Text in place of a drawing."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes)


def show_refusal(axes: Axes, data: FigureData) -> None:
    """Show why there is nothing to draw, with the lower bound of the force if there is one."""
    text = "Not a disk contact:\nthe method does not give this quantity."
    if "force_lower_bound" in data.data:
        bound = written(float(data.data["force_lower_bound"].values[-1]), "N")
        text += f"\nThe force is at least {bound}\n(rigorous lower bound)."
    show_text(axes, text)


def with_unmet(figure: Figure, assumptions: Iterable[Assumption]) -> Figure:
    """A figure with the unmet assumptions of the model below it."""
    lines = [assumption_text(a) for a in assumptions if not a.met]
    if lines:
        figure.supxlabel("\n".join(fill(line, _UNMET) for line in lines), fontsize=SMALL, color=ORANGE)
    return figure


def draw_zero(axes: Axes) -> None:
    """A thin line at 0."""
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
