"""The whole page: a contact, a second one beside it, and lessons."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from typing import Any

import panel as pn

from pymdr.explore.model import Choice
from pymdr.explore.pane import CasePane
from pymdr.explore.teaching import FrictionLesson, MachineLesson, SpringLesson
from pymdr.explore.widgets import STYLE, Scheme, grid

_TABS = ".bk-tab.bk-active { color: inherit !important; font-weight: 600; background: transparent }"


class Page:
    """The whole page of a session."""

    def __init__(self, choices: dict[str, Choice]) -> None:
        self._choices = choices
        self._panes = [CasePane("a", choices, self._compare)]
        self._lessons: list[Any] = []
        self._both = pn.widgets.Toggle(name="compare with a second case", width=240)
        self._views = pn.FlexBox(self._panes[0].view(), sizing_mode="stretch_width", stylesheets=[grid(620)])
        self._table = pn.pane.HTML("", sizing_mode="stretch_width", stylesheets=[STYLE])
        self._both.param.watch(self._open_second, "value")
        if pn.state.curdoc is not None:
            pn.state.on_session_destroyed(self._close)

    def _close(self, context: Any) -> None:
        for part in (*self._panes, *self._lessons):
            part.close()

    def view(self) -> Any:
        """The page."""
        contact = pn.Column(self._both, self._table, self._views, sizing_mode="stretch_width")
        lessons = {"Springs by hand": SpringLesson, "Adhesion": MachineLesson, "Friction": FrictionLesson}
        shown = {name: self._lesson(lesson) for name, lesson in lessons.items()}
        tabs = pn.Tabs(("Contact", contact), *shown.items(), sizing_mode="stretch_width", stylesheets=[_TABS])
        return pn.Column(Scheme(dark=pn.config.theme == "dark"), tabs, sizing_mode="stretch_width")

    def _lesson(self, lesson: Any) -> Any:
        opened = lesson()
        self._lessons.append(opened)
        return opened.view()

    def _open_second(self, event: Any) -> None:
        if event.new and len(self._panes) == 1:
            second = CasePane("b", self._choices, self._compare)
            second.choose(replace(self._panes[0].choice))
            self._panes.append(second)
            self._views.append(second.view())
        elif not event.new and len(self._panes) == 2:
            self._panes.pop().close()
            self._views.pop(-1)
            self._table.object = ""

    def _compare(self) -> None:
        """The quantities of both cases side by side."""
        seen = [pane.seen for pane in self._panes]
        if len(seen) < 2 or any(one is None or one.result is None for one in seen):
            return
        first, second = ({row[0]: row for row in one.numbers if row[1]} for one in seen if one is not None)
        body = "".join(
            f"<tr><th scope='row'>{escape(name)}</th><td>{escape(first[name][1])}</td><td>{escape(second[name][1])}</td></tr>"
            for name in first
            if name in second
        )
        self._table.object = (
            "<table class='numbers'><caption>both cases</caption><thead><tr><th scope='col'>quantity</th>"
            f"<th scope='col'>first</th><th scope='col'>second</th></tr></thead><tbody>{body}</tbody></table>"
        )
