"""What all figures share: their data, style, colours, units and the thinning of long histories."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.jumps import Branches
from pymdr.interpretation.peaks import infinite_pressures
from pymdr.interpretation.validity import Assumption
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si, good_unit, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

IntArray = NDArray[np.int_]

BLUE, ORANGE, GREEN, GREY, LIGHT = "#0072B2", "#D55E00", "#009E73", "#666666", "#DDDDDD"
"""Okabe and Ito's colours, told apart by every eye."""
MOST = 20_000
"""Points drawn of one curve."""
MARKED_ROWS = 40
"""Up to so many rows are marked by points."""
_GRIDS = (2000, 1000, 500, 250)
"""Cells across a picture; the last are no larger than its pixels."""
_NAMED = 3
"""Kinks up to so many are named by their radii."""
_UNMET = 100
"""Characters of a line below a figure."""
_STYLE: Any = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9, "legend.frameon": False}


@dataclass(frozen=True)
class LayersDrawn:
    """What is drawn of a body of layers."""

    thickness: tuple[float, ...]
    """From the surface downward in m."""
    words: tuple[str, ...]
    """What each layer is made of."""
    base: str
    """What they lie on."""
    rigid: bool
    """Whether that does not give way."""
    half_spaces: Mapping[str, tuple[FloatArray, FloatArray]]
    """Indentations in m and forces in N on half-spaces of single materials, by words."""


@dataclass(frozen=True)
class FigureData:
    """What the figures are drawn from."""

    data: xr.Dataset
    """Quantities over ``step``."""
    row: int
    """The row that is drawn; -1 if none is valid."""
    field: Callable[[str, FloatArray | None], xr.DataArray] | None
    """A field of that row at radii; None where there is none."""
    gap: Callable[[FloatArray], FloatArray]
    """f(r)."""
    bands: Mapping[str, tuple[FloatArray, FloatArray]]
    """Ends of the bands of quantities, by name."""
    on_line: bool
    """Whether there is a line of springs to draw."""
    field_at: Callable[[str, FloatArray | None, int], xr.DataArray] | None = None
    """A field at radii in any row."""
    friction: float | None = None
    """Coefficient of friction; None without friction."""
    equilibria: Callable[[], Branches | None] | None = None
    """All equilibria of a contact with adhesion; None without adhesion. It gives None where nothing touches."""
    modulus: float | None = None
    """E* in Pa, which turns the force of a spring into its displacement."""
    deflection: Callable[[FloatArray], FloatArray] | None = None
    """How far in m springs at positions are pressed, which remember their contact; None of others."""
    kinks: Callable[[], FloatArray] | None = None
    """Radii in m at which the profile may have a kink; None where none is looked for."""
    loading: Callable[[FloatArray], Mapping[str, FloatArray]] | None = None
    """Quantities at indentations between the rows, where they depend on nothing else."""
    pull: float | None = None
    """Force in N of an attraction that has no place in the pressure; None without it."""
    refusal: str = ""
    """Why no row is valid."""
    layers: LayersDrawn | None = None
    """The layers of the body; None without."""
    extent: float | None = None
    """Radius in m up to which the profile of a refused contact is drawn."""


@dataclass(frozen=True)
class Plots:
    """The figures of a law, and what they are drawn from."""

    data: FigureData
    overview: Callable[[FigureData], Figure]
    """The contact in section above its springs, with its curve or loop and a field."""
    figures: Callable[[FigureData], dict[str, Figure]]
    """All figures by name."""


def styled() -> AbstractContextManager[None]:
    """The style of all figures."""
    import matplotlib as mpl

    return mpl.rc_context(_STYLE)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    from pymdr.presentation.plot.drawing import Drawing

    return Drawing(figsize=(width, height), layout="constrained")


def thinned(values: FloatArray, most: int = MOST) -> IntArray:
    """Indices of at most about `most` points, with the extremes of every stretch: for curves over step or time."""
    n = values.size
    if n <= most:
        return np.arange(n)
    size = -(-n // (most // 2))
    whole = n // size * size
    part = values[:whole].reshape(-1, size)
    first = np.arange(0, whole, size)
    low = first + np.argmin(np.where(np.isnan(part), np.inf, part), axis=1)
    high = first + np.argmax(np.where(np.isnan(part), -np.inf, part), axis=1)
    return np.unique(np.concatenate([low, high, np.arange(whole, n), [0, n - 1]]))


def as_seen(x: FloatArray, y: FloatArray, most: int = MOST) -> tuple[FloatArray, FloatArray]:
    """
    A long curve in a plane as it is seen: its course from cell to cell of a fine grid, each step once.

    Parameters
    ----------
    x, y : ndarray
        Points in order, with nan between parts that are not joined.
    most : int
        Number of points up to which a curve stays as it is; only curves that fill the picture keep more.

    Returns
    -------
    tuple of ndarray
        Some of the points, the extremes among them, with nan between those that are not joined.
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
    apart = np.flatnonzero((np.diff(rows) > 1) & (np.diff(cell[rows]) != 0)) + 1
    return np.insert(x[rows], apart, np.nan), np.insert(y[rows], apart, np.nan)


def _cells(values: FloatArray, known: NDArray[np.bool_], cells: int) -> IntArray:
    low, high = float(np.min(values[known])), float(np.max(values[known]))
    share = (np.where(known, values, low) - low) / ((high - low) or 1.0)
    return np.asarray(share * cells, dtype=int)


def mark_radii(
    axes: Axes, a: float, c: float, unit: str, *, both_sides: bool = False, named: bool = True
) -> None:
    """Dotted lines at the radius of contact and at that of a cohesive zone, with their names above the frame."""
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
    """Whether a pressure goes to infinity (1), to minus infinity (-1) or neither (0) at an edge."""
    amplitude = float(p["edge_amplitude"])
    if not np.isnan(amplitude):
        return float(np.sign(amplitude))
    inside = p.values[(p["r"].values < radius) & np.isfinite(p.values)]
    return float(np.sign(inside[-1])) if inside.size else 0.0


def infinite_within(data: FigureData, a: float) -> tuple[float, ...]:
    """Radii in m within a contact at which its pressure is infinite."""
    return infinite_pressures(data.gap, np.zeros(0) if data.kinks is None else data.kinks(), a)


def peak_notes(radii: Sequence[float]) -> list[str]:
    """Where within a contact a pressure is infinite, in words."""
    notes = ["sharp tip: $p(0) = \\infty$"] if 0.0 in radii else []
    kinks = [typeset(r, "m") for r in radii if r > 0.0]
    if kinks:
        at = f"$r$ = {', '.join(kinks)}" if len(kinks) <= _NAMED else f"{len(kinks)} radii"
        notes.append(f"kink: $p \\to \\infty$ at {at}, logarithmic")
    return notes


def note_peaks(axes: Axes, radii: Sequence[float]) -> None:
    """Write into a panel where within a contact the pressure that it shows is infinite."""
    if notes := peak_notes(radii):
        axes.text(0.02, 0.98, "\n".join(notes), va="top", transform=axes.transAxes, fontsize=7, color=ORANGE)


def singularities(amplitude: float, sign: float, peaks: Sequence[float]) -> str:
    """Where a pressure is infinite, in words: at its edge with its amplitude, at a sharp tip, or at kinks."""
    notes = []
    if sign != 0.0:
        words = f"$p \\to {'' if sign > 0.0 else '-'}\\infty$ at $r = a$"
        if not np.isnan(amplitude):
            size = typeset(amplitude, "Pa*m^0.5").replace("*m^0.5", " m$^{1/2}$")
            words += f":\n$p \\simeq K/\\sqrt{{a-r}}$\n$K$ = {size}"
        notes.append(words)
    return "\n".join([*notes, *peak_notes(peaks)])


def letter_panels(figure: Figure) -> None:
    """(a), (b), ... above the panels of a figure that has several; a second scale and a bar of colours are none."""
    panels: list[Axes] = []
    for axes in figure.axes:
        place = axes.get_subplotspec()
        if place is not None and place not in [other.get_subplotspec() for other in panels]:
            panels.append(axes)
    if len(panels) < 2:
        return
    for axes, letter in zip(panels, "abcdefgh", strict=False):
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


def legend_above(axes: Axes, size: float = 8.0) -> None:
    """A legend above the axes, where it covers nothing."""
    labels = axes.get_legend_handles_labels()[1]
    if labels:
        columns = 3 if len(labels) <= 3 and sum(map(len, labels)) < 40 else 2
        axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=columns, fontsize=size, borderaxespad=0.0
        )


def typeset(value: float, unit: str = "") -> str:
    """A value with unit, with a minus sign as on the axes."""
    return written(value, unit).replace("-", "\u2212", 1)


def scaled(values: FloatArray, name: str, unit: str) -> FloatArray:
    """Values of a quantity from its SI unit to another."""
    return np.asarray(from_si(np.asarray(values, dtype=float), QUANTITIES[name].unit, unit))


def lengths(values: FloatArray, unit: str) -> FloatArray:
    """Lengths in m to another unit."""
    return np.asarray(from_si(np.asarray(values, dtype=float), "m", unit))


def column(data: FigureData, name: str) -> tuple[FloatArray, str]:
    """A quantity over the rows in a unit that suits it, and that unit."""
    values = data.data[name].values
    unit = good_unit(values, QUANTITIES[name].unit)
    return scaled(values, name, unit), unit


def axis_label(name: str, unit: str) -> str:
    """Words, symbol and unit of a quantity."""
    row = QUANTITIES.get(name, RADIUS)
    return f"{row.label} ({unit})"


def along_history(data: FigureData) -> tuple[FloatArray, str]:
    """Time, or the number of the row, with its label."""
    if "time" in data.data:
        values, unit = column(data, "time")
        return values, axis_label("time", unit)
    if "row" in data.data.coords:
        return np.asarray(data.data["row"].values, dtype=float), "row of the path"
    return np.arange(float(data.data.sizes["step"])), "step"


def row_name(data: FigureData, row: int) -> str:
    """What a step of the result is called: the row of the path, where only some rows were kept, and its time."""
    name = f"row {int(data.data['row'].values[row])}" if "row" in data.data.coords else f"step {row}"
    if "time" not in data.data:
        return name
    return f"{name}, $t$ = {typeset(float(data.data['time'].values[row]), 's')}"


def without_peaks(p: FloatArray) -> FloatArray:
    """Finite values without those next to a singularity, of a pressure that may have one."""
    finite = p[np.isfinite(p)]
    pressed = finite[finite > 0.0]
    return np.minimum(finite, 4.0 * float(np.median(pressed))) if pressed.size else np.zeros(1)


def limit_peaks(axes: Axes, values: FloatArray) -> None:
    """Show values up to a little above the largest of some."""
    top = float(values.max())
    if top > 0.0:
        axes.set_ylim(min(0.0, float(values.min())), 1.12 * top)


def say(axes: Axes, words: str) -> None:
    """Words in place of a drawing."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, words, ha="center", va="center", transform=axes.transAxes)


def say_refused(axes: Axes, data: FigureData) -> None:
    """Say why there is nothing to draw, with the lower bound of the force if there is one."""
    words = "Not a disk contact:\nthe method does not give this."
    if "force_lower_bound" in data.data:
        bound = written(float(data.data["force_lower_bound"].values[-1]), "N")
        words += f"\nThe force is at least {bound}\n(rigorous lower bound)."
    say(axes, words)


def with_unmet(figure: Figure, assumptions: Iterable[Assumption]) -> Figure:
    """A figure below which the conditions of the model stand that are not met."""
    lines = [f"not met: {a.words} is {a.measure:.3g} (limit {a.limit:g})" for a in assumptions if not a.met]
    if lines:
        figure.supxlabel("\n".join(fill(line, _UNMET) for line in lines), fontsize=8, color=ORANGE)
    return figure


def draw_zero(axes: Axes) -> None:
    """A thin line where the values are 0."""
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
