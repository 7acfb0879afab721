"""Work in the background: the latest request is answered, older ones are dropped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Generic, TypeVar

from pymdr.errors import PymdrError
from pymdr.explore.model import Choice, answer
from pymdr.explore.seen import (
    MEASURES,
    Chart,
    Picture,
    Row,
    curve,
    field,
    fields_of,
    numbers,
    quantities_of,
    refusal,
    row_of,
    section,
    stress,
)
from pymdr.problem.schedule import Progress
from pymdr.result import Result


@dataclass(frozen=True)
class View:
    """What is to be seen of a result."""

    x: str = "indentation"
    y: str = "normal_force"
    field: str = "pressure"
    measure: str = MEASURES[0]
    row: int = -1
    """-1 is the row of the largest contact."""


@dataclass(frozen=True)
class Request:
    """A choice, and what is to be seen of it."""

    choice: Choice
    view: View


@dataclass(frozen=True)
class Seen:
    """The answer to a request."""

    request: Request
    result: Result | None = None
    error: str = ""
    """Why there is no result."""
    seconds: float = 0.0
    row: int = 0
    quantities: tuple[str, ...] = ()
    fields: tuple[str, ...] = ()
    section: Chart | None = None
    curve: Chart | None = None
    field: Chart | None = None
    numbers: tuple[Row, ...] = ()


@dataclass(frozen=True)
class Inside:
    """The stress of a request, which comes after the rest."""

    request: Request
    picture: Picture | None
    reason: str = ""


FAILURES = (PymdrError, ArithmeticError, ValueError, TypeError, LookupError, MemoryError)
"""What ends a request and is shown, not the thread."""
Wanted = TypeVar("Wanted")


class _SupersededError(Exception):
    """A newer request has come."""


def look(request: Request, result: Result, began: float) -> Seen:
    """
    What a request sees of a result, without the stress.

    Parameters
    ----------
    began : float
        :func:`time.perf_counter` when the work began.
    """
    view = request.view
    quantities, fields = quantities_of(result), fields_of(result)
    x, y = (name if name in quantities else "" for name in (view.x, view.y))
    name = view.field if view.field in fields else next(iter(fields), "")
    charts = (
        section(result, view.row),
        curve(result, x or quantities[0], y or quantities[min(1, len(quantities) - 1)], view.row)
        if quantities
        else None,
        field(result, name, view.row) if name else None,
    )
    at, rows = row_of(result, view.row), numbers(result, view.row)
    seconds = time.perf_counter() - began
    return Seen(request, result, "", seconds, at, quantities, fields, *charts, rows)


class Runner(Generic[Wanted]):
    """
    A thread that answers the latest request.

    Parameters
    ----------
    work : callable
        Called in the thread with a request and a function ``report(done, total)``, which ends the work if a newer request waits.
    advance : callable
        Called in the thread with the fraction of the work that is done.
    """

    def __init__(self, work: Callable[[Wanted, Progress], None], advance: Callable[[float], None]) -> None:
        self._work, self._advance = work, advance
        self._changed = threading.Condition()
        self._next: Wanted | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="pymdr explore", daemon=True)
        self._thread.start()

    def ask(self, request: Wanted) -> None:
        """Replace the request that waits, and stop the one that runs at its next report."""
        with self._changed:
            self._next = request
            self._changed.notify()

    def close(self) -> None:
        """End the thread after what it does now."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._closed)
                request, self._next = self._next, None
            if self._closed or request is None:
                return
            with suppress(_SupersededError):
                self._work(request, self._report)

    def _report(self, done: int, total: int) -> None:
        if self._next is not None or self._closed:
            raise _SupersededError
        self._advance(done / max(total, 1))


class Looking:
    """
    The work of a case: its solution, which is kept while only the view changes, what is seen of it, and then the stress.

    Parameters
    ----------
    show : callable
        Called with every :class:`Seen` and :class:`Inside`.
    """

    def __init__(self, show: Callable[[Seen | Inside], None]) -> None:
        self._show = show
        self._last: tuple[Choice, Result] | None = None

    def __call__(self, request: Request, report: Progress) -> None:
        """Answer a request."""
        began = time.perf_counter()
        try:
            if self._last is None or self._last[0] is not request.choice:
                self._last = None
                self._last = (request.choice, answer(request.choice, report))
            result = self._last[1]
            seen = look(request, result, began)
        except FAILURES as error:
            self._show(Seen(request, error=refusal(error)))
            return
        self._show(seen)
        report(1, 1)
        try:
            picture = stress(result, request.view.measure, request.view.row)
            self._show(Inside(request, picture, "" if picture else "not valid in this row"))
        except FAILURES as error:
            self._show(Inside(request, None, refusal(error)))
