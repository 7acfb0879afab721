"""One case of the page: what is chosen at the left, what is seen at the right."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import panel as pn

from pymdr.errors import PymdrError
from pymdr.explore.files import Files
from pymdr.explore.model import (
    OWN,
    PARTS,
    Choice,
    Knob,
    dragged,
    fraction,
    kind_of,
    kinds,
    knobs,
    python_lines,
    text,
    toml,
    typed,
    with_kind,
)
from pymdr.explore.running import Inside, Looking, Request, Runner, Seen, View
from pymdr.explore.seen import MEASURES, refusal
from pymdr.explore.views import new_image, new_plot, numbers_html, show_chart, show_picture
from pymdr.explore.widgets import GRID, STYLE, Knobs, Range, Ranges, cell, soon
from pymdr.quantities import QUANTITIES

_CONTROLS, _RESULTS = 330, 640
"""Widths in pixels at which controls and results stand side by side."""


def _words(names: Mapping[str, str] | tuple[str, ...]) -> dict[str, str]:
    """Names by their words, for lists to choose from."""
    return {QUANTITIES[n].long_name if n in QUANTITIES else n.replace("_", " "): n for n in names}


class CasePane:
    """
    One case: its choices, its sliders and what is seen of it.

    Parameters
    ----------
    key : str
        Beginning of the identifiers in the page.
    changed : callable
        Called after every answer.
    """

    def __init__(self, key: str, choices: dict[str, Choice], changed: Callable[[], None]) -> None:
        self._key, self._choices, self._changed = key, choices, changed
        self.choice = next(iter(choices.values()))
        self.seen: Seen | None = None
        self._knobs: tuple[Knob, ...] = ()
        self._faults: dict[int, str] = {}
        self._updating = self._timed = False
        self._request: Request | None = None
        self._document = pn.state.curdoc
        self._soon = soon()
        looking = Looking(partial(self._soon, self._show))
        self._runner: Runner[Request] = Runner(looking, partial(self._soon, self._advance))
        self._build()
        self.choose(self.choice)

    def close(self) -> None:
        """End the work in the background."""
        self._runner.close()
        self._files.close()

    def _build(self) -> None:
        self._start = pn.widgets.Select(
            name="start from", options=list(self._choices), sizing_mode="stretch_width"
        )
        self._kinds = {part: pn.widgets.Select(name=part, width=150) for part in PARTS}
        self._sliders = Knobs(self._drag, self._enter, key=self._key)
        self._files = Files(lambda: self.choice, self.choose)
        self._bar = pn.indicators.Progress(
            name="work", value=0, max=100, sizing_mode="stretch_width", visible=False
        )
        self._message = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._row = Ranges("", [Range("row of the path", 0, 1, whole=True)], [1.0], self._look)
        names = ("x", "y", "field", "measure")
        self._view = {
            name: pn.widgets.Select(name=w, width=190) for name, w in zip(names, _SEEN, strict=True)
        }
        self._view["measure"].param.update(options=_words(MEASURES), value=MEASURES[0])
        self._plots = {
            "section": new_plot("section", legend=True),
            "curve": new_plot("over the path"),
            "field": new_plot("on the surface"),
        }
        self._stress = new_image("stress inside the body")
        self._alternative = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._numbers = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._code = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._start.param.watch(lambda event: self.choose(self._choices[event.new]), "value")
        for part, select in self._kinds.items():
            select.param.watch(partial(self._of_kind, part), "value")
        for select in self._view.values():
            select.param.watch(self._look, "value")

    def view(self) -> Any:
        """Everything of the case."""
        chosen = pn.Column(
            self._start,
            pn.FlexBox(*self._kinds.values()),
            self._sliders,
            self._files.view(),
            min_width=280,
            max_width=_CONTROLS,
            sizing_mode="stretch_width",
        )
        figures = [*(plot.figure for plot in self._plots.values()), self._stress.figure]
        grid = pn.FlexBox(*map(cell, figures), sizing_mode="stretch_width", stylesheets=[GRID])
        seen = pn.Column(
            self._bar,
            self._message,
            grid,
            self._alternative,
            self._row.view,
            pn.FlexBox(*self._view.values()),
            self._numbers,
            self._outputs(),
            self._code,
            min_width=280,
            sizing_mode="stretch_width",
            styles={"flex": f"1 1 {_RESULTS // 2}px"},
        )
        return pn.FlexBox(chosen, seen, align_items="flex-start", sizing_mode="stretch_width")

    def choose(self, choice: Choice) -> None:
        """Replace the case by another."""
        self.choice = choice
        self._faults = {}
        self._updating = True
        for part, select in self._kinds.items():
            select.options = {name.replace("_", " "): name for name in kinds(part, choice)}
            select.value = kind_of(part, choice)
        self._updating = False
        self._knobs = knobs(choice)
        labels = [[_heading(knob), knob.label] for knob in self._knobs]
        if labels != self._sliders.labels:
            self._sliders.param.update(labels=labels, values=self._values())
        self._ask()

    def _values(self) -> list[list[Any]]:
        return [
            [fraction(self.choice, knob), text(self.choice, knob), self._faults.get(i, "")]
            for i, knob in enumerate(self._knobs)
        ]

    def _of_kind(self, part: str, event: Any) -> None:
        if self._updating or event.new == OWN:
            return
        largest = {}
        if self.seen is not None and self.seen.result is not None:
            data = self.seen.result.data
            largest = {n: float(data[n].max()) for n in ("indentation", "normal_force") if n in data}
        try:
            self.choose(with_kind(part, event.new, self.choice, largest))
        except PymdrError as error:
            self._show_message(refusal(error))

    def _drag(self, index: int, to: float) -> None:
        self._faults.pop(index, None)
        self.choice = dragged(self.choice, self._knobs[index], to)
        self._ask()

    def _enter(self, index: int, entry: str) -> None:
        try:
            self.choice = typed(self.choice, self._knobs[index], entry)
        except PymdrError as error:
            self._faults[index] = refusal(error)
            self._sliders.values = self._values()
            return
        self._faults.pop(index, None)
        self._ask()

    def _look(self, *_: Any) -> None:
        if not self._updating:
            self._ask()

    def _ask(self) -> None:
        self._sliders.values = self._values()
        self._code.object = f"<details><summary>Python lines</summary><pre>{escape(python_lines(self.choice))}</pre></details>"
        chosen = {name: select.value or getattr(View, name) for name, select in self._view.items()}
        self._request = Request(self.choice, View(**chosen, row=self._row_of_view()))
        self._runner.ask(self._request)
        if self._document is not None and not self._timed:
            self._timed = True
            self._document.add_timeout_callback(self._show_bar, _PATIENCE)

    def _show_bar(self) -> None:
        """Show that there is work, if the answer takes long; its progress follows where it is known."""
        self._timed = False
        if self._request is not None:
            self._bar.param.update(value=-1, visible=True)

    def _row_of_view(self) -> int:
        """The row of the slider; the largest contact while the slider stands at its end."""
        row, end = self._row.values[0], self._row.ranges[0].high
        return -1 if self.seen is None or row >= end else int(row)

    def _advance(self, done: float) -> None:
        if self._request is not None:
            self._bar.value = int(100 * done)

    def _show_message(self, message: str) -> None:
        self._message.object = (
            f"<div role='status' class='case error'>{escape(message)}</div>" if message else ""
        )

    def _show(self, answer: Seen | Inside) -> None:
        if isinstance(answer, Inside):
            words = answer.request.view.measure.replace("_", " ")
            show_picture(self._stress, answer.picture, f"stress inside: {words}", answer.reason)
            return
        if answer.request is self._request:
            self._request = None
            self._bar.visible = False
        self.seen = answer
        if answer.result is None:
            self._show_message(answer.error)
            self._changed()
            return
        status = answer.result.status
        self._message.object = (
            f"<div role='status' class='case'>{escape(status.name.replace('_', ' ').lower())}: {escape(status.value)}; "
            f"{1e3 * answer.seconds:.0f} ms</div>"
        )
        self._show_choices(answer)
        charts = {name: getattr(answer, name) for name in self._plots}
        for name, chart in charts.items():
            if chart is not None:
                show_chart(self._plots[name], chart)
        words = " ".join(f"{name}: {chart.text}." for name, chart in charts.items() if chart is not None)
        self._alternative.object = f"<p style='font-size:.85em'>{escape(words)}</p>"
        self._numbers.object = numbers_html(f"row {answer.row} of the path", answer.numbers)
        self._changed()

    def _show_choices(self, answer: Seen) -> None:
        """Quantities, fields and rows that this result has."""
        assert answer.result is not None
        self._updating = True
        options = {"x": answer.quantities, "y": answer.quantities, "field": answer.fields}
        view = answer.request.view
        for name, known in options.items():
            wanted = getattr(view, name)
            listed = _words(known)
            self._view[name].param.update(
                options=listed, value=wanted if wanted in known else next(iter(known), None)
            )
        rows = int(answer.result.data.sizes["step"])
        end = max(rows - 1, 1)
        self._row.ranges[0] = replace(self._row.ranges[0], high=end)
        self._row.values[0] = float(end if view.row < 0 else min(view.row, end))
        self._row.show()
        self._updating = False

    def _outputs(self) -> Any:
        def button(label: str, name: str, write: Callable[[], io.BytesIO | None]) -> Any:
            return pn.widgets.FileDownload(
                callback=write, filename=name, label=label, auto=True, embed=False, width=150
            )

        return pn.FlexBox(
            button("case file", "case.toml", lambda: io.BytesIO(toml(self.choice).encode())),
            button("Python lines", "case.py", lambda: io.BytesIO(python_lines(self.choice).encode())),
            button("figure", "figure.png", lambda: self._written("figure.png")),
            button("table", "table.csv", lambda: self._written("table.csv")),
        )

    def _written(self, name: str) -> io.BytesIO | None:
        """A file of the result that is seen."""
        if self.seen is None or self.seen.result is None:
            self._show_message("there is no result to write; correct the case first")
            return None
        result = self.seen.result
        with TemporaryDirectory() as folder:
            file = Path(folder) / name
            if file.suffix == ".csv":
                result.to_csv(file, about=True)
            else:
                result.plot(step=self.seen.row).savefig(file, dpi=150)
            return io.BytesIO(file.read_bytes())


_PATIENCE = 300
"""Milliseconds after which the bar is shown."""
_SEEN = ("horizontal axis", "vertical axis", "field on the surface", "measure of the stress")


def _heading(knob: Knob) -> str:
    return {"solve": "machine"}.get(str(knob.place[0]), str(knob.place[0]))
