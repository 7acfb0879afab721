"""Parts of the page: its style, and sliders with a box for a value and its unit, made of the browser's own inputs: by keyboard and screen reader as by hand."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

from pymdr.units import written

STYLE = """
:host, body { color-scheme: light dark }
table.numbers { border-collapse: collapse; width: 100%; font-size: .9em }
table.numbers caption { text-align: left; font-weight: 600; padding-bottom: .3em }
table.numbers th { text-align: left; font-weight: 500 }
table.numbers th, table.numbers td { padding: .1em .6em .1em 0; border-bottom: 1px solid #8884 }
pre { overflow-x: auto; font-size: .85em }
.error { color: #D55E00; font-weight: 600 }
"""


def grid(least: int) -> str:
    """A style sheet of a box whose parts stand side by side, as far as each has a width in pixels."""
    columns = f"repeat(auto-fit, minmax(min(100%, {least}px), 1fr))"
    return f"[id^=flex] {{ display: grid !important; grid-template-columns: {columns}; gap: 6px; align-items: start }}"


GRID = grid(400)
"""Figures side by side."""
_SCRIPT = """
const STEPS = 400  // one changes the third digit of a value
export function render({ model, el }) {
  const root = document.createElement('div')
  el.appendChild(root)
  let rows = []
  const build = () => {
    root.replaceChildren()
    let part = null
    rows = model.labels.map(([heading, label], i) => {
      if (heading !== part && model.boxes) {
        const title = document.createElement('h3')
        title.textContent = part = heading
        root.appendChild(title)
      }
      const row = document.createElement('div')
      row.className = 'knob'
      const name = document.createElement('label')
      const id = `${model.key}-knob-${i}`
      name.htmlFor = id
      name.textContent = label
      const range = document.createElement('input')
      Object.assign(range, { type: 'range', min: 0, max: STEPS, step: 1, id })
      const full = [heading, label].filter(Boolean).join(' ')
      const box = document.createElement(model.boxes ? 'input' : 'output')
      box.id = id + '-text'
      if (model.boxes) {
        Object.assign(box, { type: 'text', autocomplete: 'off', spellcheck: false })
        box.setAttribute('aria-label', `${full}, value with unit`)
      }
      range.setAttribute('aria-label', full)
      const fault = document.createElement('div')
      fault.className = 'fault'
      fault.setAttribute('role', 'alert')
      range.addEventListener('input', () => model.send_msg({ index: i, fraction: Number(range.value) / STEPS }))
      box.addEventListener('change', () => model.send_msg({ index: i, text: box.value }))
      row.append(name, range, box, fault)
      root.appendChild(row)
      return { range, box, fault }
    })
    show()
  }
  const show = () => {
    model.values.forEach(([fraction, text, fault], i) => {
      if (i >= rows.length) return
      const { range, box, fault: place } = rows[i]
      if (!range.matches(':active')) range.value = Math.round(STEPS * fraction)
      range.setAttribute('aria-valuetext', text)
      if (fault === '') box.value = text
      if (model.boxes) box.setAttribute('aria-invalid', fault !== '')
      if (place.textContent !== fault) place.textContent = fault
    })
  }
  model.on('labels', build)
  model.on('values', show)
  build()
}
"""

_SWITCH = """
export function render({ model, el }) {
  document.documentElement.lang = 'en'
  if (!document.head.querySelector('meta[name=viewport]')) {
    const width = document.createElement('meta')
    Object.assign(width, { name: 'viewport', content: 'width=device-width, initial-scale=1' })
    document.head.appendChild(width)
  }
  const go = (theme) => {
    const address = new URL(location.href)
    address.searchParams.set('theme', theme)
    location.replace(address)
  }
  const chosen = new URL(location.href).searchParams.has('theme')
  if (!chosen && matchMedia('(prefers-color-scheme: dark)').matches) go('dark')
  const button = document.createElement('button')
  button.textContent = model.dark ? 'light page' : 'dark page'
  button.style.font = 'inherit'
  button.addEventListener('click', () => go(model.dark ? 'light' : 'dark'))
  el.appendChild(button)
}
"""

_KNOBS = """
:host { padding: 0 .6em; box-sizing: border-box }
.knob { display: grid; grid-template-columns: minmax(7em, 1fr) 2fr 7.5em; gap: .4em; align-items: center; margin: .15em 0 }
.knob input { font: inherit; color: inherit; background: transparent; min-width: 0 }
.knob input[type=range] { width: 100%; min-height: 1.6em; accent-color: #0072B2 }
.knob input[type=text] { border: 1px solid #888; border-radius: 3px; padding: .15em .3em }
.knob input:focus-visible { outline: 3px solid #E69F00 }
.knob .fault { grid-column: 1 / -1; color: #D55E00 }
.knob .fault:empty { display: none }
h3 { margin: .5em 0 .1em; font-size: 1em }
"""


def soon() -> Callable[[Callable[[Any], None], Any], None]:
    """What calls a function with a value in the thread of the page that is built, unless the page has been closed."""
    document = pn.state.curdoc
    if document is None:
        return lambda function, value: function(value)
    loop = asyncio.get_running_loop()

    def add(function: Callable[[], None]) -> None:
        context = document.session_context
        if context is not None and not context.destroyed:
            document.add_next_tick_callback(function)

    def call(function: Callable[[Any], None], value: Any) -> None:
        # documents are destroyed in the thread of the loop too, never between the question and the answer
        loop.call_soon_threadsafe(add, partial(function, value))

    return call


def cell(plot: Any) -> Any:
    """A figure as wide as its cell of the grid."""
    theme = "dark_minimal" if pn.config.theme == "dark" else None
    return pn.pane.Bokeh(plot, sizing_mode="stretch_width", min_width=280, theme=theme)


class Scheme(JSComponent):
    """A button between light and dark; a page that is opened without a choice follows the system."""

    dark = param.Boolean(doc="Whether the page is dark.")

    _esm = _SWITCH

    def __init__(self, **params: Any) -> None:
        super().__init__(**params)


class Knobs(JSComponent):
    """
    Rows of a label, a slider and a box.

    Parameters
    ----------
    moved : callable
        Called with the number of the row and the fraction to which it was dragged.
    entered : callable
        Called with the number of the row and the text that was entered.
    """

    labels = param.List(doc="Heading and label of every row.")
    values = param.List(doc="Fraction, text and fault of every row.")
    boxes = param.Boolean(default=True, doc="Whether values can be entered as texts.")
    key = param.String(doc="Beginning of the identifiers in the page.")

    _esm = _SCRIPT
    _stylesheets = [_KNOBS]  # noqa: RUF012  (read by panel from the class)

    def __init__(
        self, moved: Callable[[int, float], None], entered: Callable[[int, str], None], **params: Any
    ) -> None:
        self._moved, self._entered = moved, entered
        super().__init__(sizing_mode="stretch_width", **params)

    def _handle_msg(self, msg: Any) -> None:
        """A message of the browser: a number of a row, and a fraction or a text."""
        index = msg.get("index")
        if not isinstance(index, int) or not 0 <= index < len(self.labels):
            return
        if isinstance(msg.get("fraction"), int | float):
            self._moved(index, float(msg["fraction"]))
        elif isinstance(msg.get("text"), str):
            self._entered(index, msg["text"][:200])


@dataclass(frozen=True)
class Range:
    """A number that is moved between two ends."""

    label: str
    low: float
    high: float
    unit: str = ""
    """SI unit."""
    logarithmic: bool = False
    whole: bool = False

    def at(self, fraction: float) -> float:
        """The number at a fraction of the range."""
        fraction = min(max(fraction, 0.0), 1.0)
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** fraction)
        value = self.low + fraction * (self.high - self.low)
        return float(round(value)) if self.whole else value

    def fraction(self, value: float) -> float:
        """The fraction of the range at a number."""
        if self.high == self.low:
            return 0.0
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


class Ranges:
    """
    Numbers that are moved by sliders, without boxes.

    Parameters
    ----------
    name : str
        What they belong to, for screen readers and the identifiers in the page.
    values : sequence of float
        At first.
    changed : callable
        Called after every move.
    """

    def __init__(
        self, name: str, ranges: Sequence[Range], values: Sequence[float], changed: Callable[[], None]
    ) -> None:
        self.ranges, self.values = list(ranges), list(values)
        self._changed = changed
        labels = [[name, one.label] for one in ranges]
        key = "-".join([name or "view", *ranges[0].label.split()])
        self.view = Knobs(self._move, lambda index, text: None, key=key, boxes=False, labels=labels)
        self.show()

    def show(self) -> None:
        """Show the numbers, after they or their ranges have changed."""
        self.view.values = [
            [one.fraction(value), written(value, one.unit, 3), ""]
            for one, value in zip(self.ranges, self.values, strict=True)
        ]

    def _move(self, index: int, fraction: float) -> None:
        self.values[index] = self.ranges[index].at(fraction)
        self.show()
        self._changed()
