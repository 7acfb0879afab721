"""Curves by the method and by another program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from textwrap import fill
from typing import Protocol

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si, good_unit

_COLUMNS = 4
_LETTERS = 34
"""Of a line of a label."""


class CurvePair(Protocol):
    """A quantity of both programs along something."""

    @property
    def along_name(self) -> str:
        """A quantity, or a label."""

    @property
    def unit(self) -> str:
        """Of the abscissa."""

    @property
    def along(self) -> FloatArray:
        """The abscissa, in its unit."""

    @property
    def name(self) -> str:
        """Name of the quantity."""

    @property
    def method(self) -> FloatArray:
        """In its SI unit."""

    @property
    def other(self) -> FloatArray:
        """In the same."""


def pairs_of_programs(pairs: Mapping[str, CurvePair], program: str) -> draw.Figure:
    """
    A panel for each case, with the curve by the method and by another program.

    Parameters
    ----------
    pairs : mapping of str to CurvePair
        By the names of the cases.
    program : str
        Name of the other program.
    """
    rows = math.ceil(len(pairs) / _COLUMNS)
    with draw.new_figure(2.7 * _COLUMNS, 2.1 * rows + 0.4, letters=False) as figure:
        panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
        for axes, (case, pair) in zip(panels, pairs.items(), strict=False):
            own, few = QUANTITIES[pair.name].unit, "o" if pair.along.size <= draw.MARKED_ROWS else None
            along, unit = good_unit(pair.along, pair.unit), good_unit(pair.method, own)
            x = from_si(pair.along, pair.unit, along)
            for values, color, dashes, label in (
                (pair.method, draw.BLUE, "-", "MDR"),
                (pair.other, draw.ORANGE, (0, (4, 3)), program),
            ):
                y = from_si(values, own, unit)
                axes.plot(x, y, color=color, ls=dashes, marker=few, ms=3, label=label)
            draw.draw_zero(axes)
            axes.set_title(case)
            label = QUANTITIES[pair.along_name].label if pair.along_name in QUANTITIES else pair.along_name
            axes.set_xlabel(draw.with_unit(label, along))
            axes.set_ylabel(fill(draw.axis_label(pair.name, unit), _LETTERS))
        for axes in panels[len(pairs) :]:
            axes.remove()
        lines, names = panels[0].get_legend_handles_labels()
        figure.legend(lines, names, loc="outside upper right", ncols=2, fontsize=draw.SMALL)
    return figure
