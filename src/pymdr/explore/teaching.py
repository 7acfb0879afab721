"""The lessons of the page, which are moved by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import panel as pn

from pymdr.explore.lessons import (
    DEEPEST,
    FARTHEST,
    SHAPES,
    STIFFNESSES,
    friction_memory,
    pressed_springs,
    pulled_bead,
)
from pymdr.explore.running import FAILURES, Runner
from pymdr.explore.seen import Chart, refusal
from pymdr.explore.views import new_plot, show_chart
from pymdr.explore.widgets import GRID, STYLE, Range, Ranges, cell, soon
from pymdr.units import written


class Lesson:
    """
    Sliders, an explanation, and charts that follow the sliders.

    Parameters
    ----------
    make : callable
        Charts and words of the values of the sliders; called in the background.
    words : str
        What is to be seen.
    titles : sequence of str
        Of the charts.
    """

    def __init__(
        self, make: Callable[[Any], tuple[Sequence[Chart], str]], words: str, titles: Sequence[str]
    ) -> None:
        self._make = make
        self._soon = soon()
        self._plots = [new_plot(title, legend=True) for title in titles]
        self._intro = pn.pane.HTML(
            f"<p>{escape(words)}</p>", sizing_mode="stretch_width", stylesheets=[STYLE]
        )
        self._words = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._runner: Runner[Any] = Runner(self._work, lambda done: None)

    def close(self) -> None:
        """End the work in the background."""
        self._runner.close()

    def _work(self, values: Any, report: Any) -> None:
        try:
            charts, words = self._make(values)
        except FAILURES as error:
            self._soon(self._say, refusal(error))
            return
        self._soon(self._show, (charts, words))

    def _say(self, words: str) -> None:
        self._words.object = f"<p role='status'>{escape(words)}</p>"

    def _show(self, made: tuple[Sequence[Chart], str]) -> None:
        for plot, chart in zip(self._plots, made[0], strict=True):
            show_chart(plot, chart)
        self._say(made[1])

    def _laid(self, *controls: Any) -> Any:
        return pn.Column(
            self._intro,
            pn.FlexBox(*controls),
            self._words,
            pn.FlexBox(
                *(cell(plot.figure) for plot in self._plots), sizing_mode="stretch_width", stylesheets=[GRID]
            ),
            sizing_mode="stretch_width",
        )


class SpringLesson(Lesson):
    """The three steps of the method, with springs pressed by hand."""

    def __init__(self) -> None:
        super().__init__(
            lambda values: pressed_springs(*values),
            "The method maps the profile f(r) onto a line of independent springs (step 1), presses every spring by the indentation "
            "minus g(x) (step 2), and maps the forces of the springs back to the pressure (step 3). More springs come closer to the "
            "exact "
            "solution.",
            ("step 1: map", "step 2: press", "step 3: map back"),
        )
        shapes = {name.replace("_", " "): name for name in SHAPES}
        self._shape = pn.widgets.Select(name="profile of the springs", options=shapes, width=200)
        self._shape.param.watch(self._ask, "value")
        numbers = (
            Range("springs on a side", 3, 100, whole=True),
            Range("indentation over the largest", 0.02, 1.0),
        )
        self._numbers = Ranges("lesson", numbers, (12.0, 0.6), self._ask)
        self._ask()

    def view(self) -> Any:
        """Everything of the lesson."""
        return self._laid(self._shape, self._numbers.view)

    def _ask(self, *_: Any) -> None:
        count, pressed = self._numbers.values
        self._runner.ask((self._shape.value, int(count), pressed))


class MachineLesson(Lesson):
    """An adhesive bead in a machine of any stiffness."""

    def __init__(self) -> None:
        super().__init__(
            _in_machine,
            "A bead of 50 µm sticks to a gel (JKR). A machine of stiffness k moves by D; its force is k (D - d). Equilibria are where this line "
            "meets the curve. Where the line touches the curve, the contact jumps: a soft machine loses it at the largest pull, a stiff one later.",
            ("force and equilibria",),
        )
        numbers = (
            Range("stiffness of the machine", *STIFFNESSES, "N/m", logarithmic=True),
            Range("work of adhesion", 0.5e-3, 1e-2, "J/m^2"),
            Range("travel of the machine: approach, then retraction", 0.0, 1.0),
        )
        self._numbers = Ranges("lesson", numbers, (0.1, 2e-3, 0.6), self._ask)
        self._ask()

    def view(self) -> Any:
        """Everything of the lesson."""
        return self._laid(self._numbers.view)

    def _ask(self) -> None:
        self._runner.ask(tuple(self._numbers.values))


def _in_machine(values: tuple[float, float, float]) -> tuple[Sequence[Chart], str]:
    chart, words = pulled_bead(*values)
    return (chart,), f"k = {written(values[0], 'N/m')}. {words}"


class FrictionLesson(Lesson):
    """The memory of friction, moved by hand."""

    def __init__(self) -> None:
        super().__init__(
            friction_memory,
            "A steel ball of 10 mm on steel, coefficient of friction 0.3. Move the shift to and fro: every reversal adds a vertex to the stack, and a "
            "larger move wipes the smaller ones out. Springs of one depth g(x) are alike, so the stack is all that the contact remembers.",
            ("stack: anchors of the springs", "shift of the springs", "loop"),
        )
        numbers = (Range("indentation", 0.0, DEEPEST, "m"), Range("shift", -FARTHEST, FARTHEST, "m"))
        self._numbers = Ranges("lesson", numbers, (0.5 * DEEPEST, 0.0), self._move)
        self._again = pn.widgets.Button(name="start again", width=140)
        self._again.on_click(self._start)
        self._moves: list[tuple[float, float]] = []
        self._move()

    def view(self) -> Any:
        """Everything of the lesson."""
        return self._laid(self._numbers.view, self._again)

    def _start(self, *_: Any) -> None:
        self._moves = []
        self._move()

    def _move(self) -> None:
        depth, shift = self._numbers.values
        self._moves.append((depth, shift))
        del self._moves[:-_MOST]
        self._runner.ask(tuple(self._moves))


_MOST = 2000
"""Moves that are followed; older ones are forgotten."""
