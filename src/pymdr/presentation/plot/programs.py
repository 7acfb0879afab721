"""Forces by the method and by another program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from pymdr.presentation.plot.shared import BLUE, ORANGE, SMALL, axis_label, draw_zero, new_figure, styled
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 4


class ForcePair(Protocol):
    """Forces of both programs along something."""

    @property
    def name(self) -> str:
        """Of the abscissa."""

    @property
    def unit(self) -> str:
        """Of the abscissa."""

    @property
    def along(self) -> FloatArray:
        """The abscissa, in its unit."""

    @property
    def force(self) -> str:
        """Name of the quantity."""

    @property
    def method(self) -> FloatArray:
        """In N."""

    @property
    def other(self) -> FloatArray:
        """In N."""


def pairs_of_programs(pairs: Mapping[str, ForcePair], program: str) -> Figure:
    """
    A panel for each case, with the force by the method and by another program.

    Parameters
    ----------
    pairs : mapping of str to ForcePair
        By the names of the cases.
    program : str
        Name of the other program.
    """
    rows = math.ceil(len(pairs) / _COLUMNS)
    with styled():
        figure = new_figure(2.7 * _COLUMNS, 2.1 * rows + 0.4)
        panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
        for axes, (case, pair) in zip(panels, pairs.items(), strict=False):
            along, force = good_unit(pair.along, pair.unit), good_unit(pair.method, "N")
            x = from_si(pair.along, pair.unit, along)
            axes.plot(x, from_si(pair.method, "N", force), color=BLUE, label="MDR")
            axes.plot(x, from_si(pair.other, "N", force), color=ORANGE, ls=(0, (4, 3)), label=program)
            draw_zero(axes)
            axes.set_title(case)
            axes.set_xlabel(axis_label(pair.name, along))
            axes.set_ylabel(axis_label(pair.force, force))
        for axes in panels[len(pairs) :]:
            axes.remove()
        lines, names = panels[0].get_legend_handles_labels()
        figure.legend(lines, names, loc="outside upper right", ncols=2, fontsize=SMALL)
    return figure
