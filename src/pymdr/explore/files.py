"""Where files are dropped, and a dropped force curve is fitted."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import panel as pn

from pymdr.explore.dropping import LARGEST, Dropped, Fitted, dropped, first_free, fitted, free_parameters
from pymdr.explore.model import Choice
from pymdr.explore.running import FAILURES, Runner
from pymdr.explore.seen import refusal
from pymdr.explore.views import new_plot, show_chart
from pymdr.explore.widgets import STYLE, cell, soon


class Files:
    """
    A place for dropped files.

    Parameters
    ----------
    choice : callable
        What is chosen now.
    choose : callable
        Called with what a file or a fit changes it to.
    """

    def __init__(self, choice: Callable[[], Choice], choose: Callable[[Choice], None]) -> None:
        self._choice, self._choose = choice, choose
        self._soon = soon()
        self._dropped: Dropped | None = None
        self._runner: Runner[Any] = Runner(lambda work, report: work(), lambda done: None)
        self._place = pn.widgets.FileDropper(
            name="drop a tip, a force curve, a surface or a case",
            multiple=False,
            max_file_size=f"{LARGEST // 2**20}MB",
            sizing_mode="stretch_width",
            height=90,
        )
        self._message = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._free = pn.widgets.CheckBoxGroup(name="free parameters")
        self._fit = pn.widgets.Button(name="fit", width=120)
        self._plot = new_plot("measured and fitted", legend=True)
        self._summary = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._fitting = pn.Column(
            pn.pane.HTML("<b>free parameters</b>"),
            self._free,
            self._fit,
            cell(self._plot.figure),
            self._summary,
            visible=False,
            sizing_mode="stretch_width",
        )
        self._place.param.watch(self._read, "value")
        self._fit.on_click(self._start_fit)

    def view(self) -> Any:
        """The place with what follows from a file."""
        return pn.Column(self._place, self._message, self._fitting, sizing_mode="stretch_width")

    def close(self) -> None:
        """End the work in the background."""
        self._runner.close()

    def _say(self, words: str, fault: bool = False) -> None:
        role = "class='error' role='alert'" if fault else "role='status'"
        self._message.object = f"<div {role}>{escape(words)}</div>" if words else ""

    def _read(self, event: Any) -> None:
        if not event.new:
            return
        # the browser takes back a file that is replaced only after its upload was shown: what was read goes here
        name, content = event.new.popitem()
        event.new.clear()
        choice = self._choice()
        data = content if isinstance(content, bytes) else str(content).encode()

        def work() -> None:
            try:
                self._soon(self._use, dropped(str(name), data, choice))
            except FAILURES as error:
                self._soon(self._refuse, refusal(error))

        self._say(f"reading {name}")
        self._runner.ask(work)

    def _refuse(self, words: str) -> None:
        self._fit.disabled = False
        self._say(words, fault=True)

    def _use(self, result: Dropped) -> None:
        self._dropped = result
        self._say(result.words)
        if result.choice is not self._choice():
            self._choose(result.choice)
        self._fitting.visible = result.curve is not None
        if result.curve is not None:
            self._free.options = list(free_parameters(self._choice()))
            self._free.value = list(first_free(self._choice()))

    def _start_fit(self, event: Any) -> None:
        curve = None if self._dropped is None else self._dropped.curve
        if curve is None:
            return
        choice, free = self._choice(), [n for n in self._free.value if n in free_parameters(self._choice())]
        if not free:
            self._refuse("no parameter of this contact is free; choose at least one")
            return

        def work() -> None:
            try:
                self._soon(self._show, fitted(choice, curve, free))
            except FAILURES as error:
                self._soon(self._refuse, refusal(error))

        self._fit.disabled = True
        self._say("fitting")
        self._runner.ask(work)

    def _show(self, result: Fitted) -> None:
        self._fit.disabled = False
        self._say("fitted; the case has the fitted values")
        show_chart(self._plot, result.chart)
        self._summary.object = f"<pre>{escape(result.summary)}</pre>"
        self._choose(result.choice)
