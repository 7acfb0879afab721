"""Parts of the page: its style, and sliders with a box for a value and its unit, made of the browser's own inputs: by keyboard and screen reader as by hand."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

STYLE = """
:host, body { color-scheme: light dark }
table.numbers { border-collapse: collapse; width: 100%; font-size: .9em }
table.numbers caption { text-align: left; font-weight: 600; padding-bottom: .3em }
table.numbers th { text-align: left; font-weight: 500 }
table.numbers th, table.numbers td { padding: .1em .6em .1em 0; border-bottom: 1px solid #8884 }
pre { overflow-x: auto; font-size: .85em }
.error { color: #D55E00; font-weight: 600 }
"""
GRID = """
[id^=flex] { display: grid !important; grid-template-columns: repeat(auto-fit, minmax(min(100%, 340px), 1fr)); gap: 6px }
"""
"""Figures side by side as far as there is room."""
_SCRIPT = """
export function render({ model, el }) {
  const root = document.createElement('div')
  el.appendChild(root)
  let rows = []
  const build = () => {
    root.replaceChildren()
    let part = null
    rows = model.labels.map(([heading, label], i) => {
      if (heading !== part) {
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
      Object.assign(range, { type: 'range', min: 0, max: 1000, step: 1, id })
      const box = document.createElement('input')
      Object.assign(box, { type: 'text', id: id + '-text', autocomplete: 'off', spellcheck: false })
      box.setAttribute('aria-label', `${heading} ${label}, value with unit`)
      range.setAttribute('aria-label', `${heading} ${label}`)
      const fault = document.createElement('div')
      fault.className = 'fault'
      fault.setAttribute('role', 'alert')
      range.addEventListener('input', () => model.send_msg({ index: i, fraction: Number(range.value) / 1000 }))
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
      if (!range.matches(':active')) range.value = Math.round(1000 * fraction)
      range.setAttribute('aria-valuetext', text)
      if (fault === '') box.value = text
      box.setAttribute('aria-invalid', fault !== '')
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
    """What calls a function with a value in the thread of the page that is built."""
    document = pn.state.curdoc

    def call(function: Callable[[Any], None], value: Any) -> None:
        if document is None:
            function(value)
        else:
            document.add_next_tick_callback(partial(function, value))

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
