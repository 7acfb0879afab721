"""One walk along a path for every law of a contact, and the solution in which it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from pymdr.errors import PathError
from pymdr.independent.rings import Rings
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath, Path
from pymdr.problem.schedule import Progress, Stretch, planned, times, total_rows
from pymdr.result import Reading, Result, Status, labelled
from pymdr.rows import joined, taken
from pymdr.units import FloatArray

State = TypeVar("State")
Rows = TypeVar("Rows")
Rows_co = TypeVar("Rows_co", covariant=True)

Told = Callable[[int], None]
"""Called with the number of rows of a leg that are done, before its end."""


@dataclass(frozen=True)
class Task:
    """What is asked of a law."""

    contact: Contact
    path: LoadingPath
    reading: Reading
    """How the result will be read."""
    machine_stiffness: float | None = None
    """In N/m."""
    keep: np.ndarray | None = None
    """Rows of the path that are kept, rising; None for all."""
    progress: Progress | None = None
    solver: Rings | None = None
    """What solves the contact instead of the method."""


class Law(Protocol[State, Rows_co]):
    """What a walk has to know of the physics."""

    def start(self) -> State:
        """The state before the first leg."""
        ...

    def where(self, state: State) -> Mapping[str, float]:
        """Where every channel is in a state, in SI units; 0 for those left out, NaN where nobody knows."""
        ...

    def step(
        self, state: State, asked: Stretch, kept: np.ndarray | None, told: Told | None
    ) -> tuple[Rows_co, State]:
        """
        Follow one leg.

        Parameters
        ----------
        state
            At its start.
        asked : Stretch
            Controls, prescribed values and times of its rows.
        kept : ndarray of int or None
            The rows of the leg that are wanted, None for all.
        told : callable or None
            What to call between parts of a long leg; None if nobody watches.

        Returns
        -------
        rows
            An array over the wanted rows, or named tuples and frozen dataclasses of arrays.
        state
            At the end of the leg.

        Raises
        ------
        PathError, ProblemError
            If the leg cannot be followed; the walk adds its number. `asked.leg.row(i)` names a row.
        """
        ...


@dataclass(frozen=True)
class Walked(Generic[Rows]):
    """Where a walk came through."""

    rows: Rows
    """Those of all legs, one after the other."""
    starts: tuple[Mapping[str, float], ...]
    """Where every channel was at the start of each leg."""


def walk(task: Task, law: Law[State, Rows]) -> Walked[Rows]:
    """
    Follow a path leg by leg.

    Parameters
    ----------
    task : Task
    law : Law

    Returns
    -------
    Walked

    Raises
    ------
    PathError, ProblemError, ConvergenceError
        What the steps of the law raise, with the number of the leg if there are several.
    """
    state = law.start()
    here = law.where(state)
    rows: list[Rows] = []
    starts: list[Mapping[str, float]] = []
    total = total_rows(task.path)
    for leg in planned(task.path):
        starts.append(here)
        with leg.named():
            asked = leg.stretch(here)
            _refuse_from_nowhere(asked)
            found, state = law.step(
                state, asked, within(task.keep, leg.first, leg.size), _told(task, leg.first, total)
            )
        rows.append(found)
        here = {**law.where(state), **asked.end}
        if task.progress is not None:
            task.progress(leg.first + leg.size, total)
    return Walked(joined(rows), tuple(starts))


def _refuse_from_nowhere(asked: Stretch) -> None:
    channel = asked.controls.normal
    if not isinstance(asked.leg.leg, Path) and math.isnan(asked.start[0]):
        raise PathError(
            "the contact was lost under a prescribed force and the body has no position from which a leg of "
            f"{channel} could start; begin it with Path({channel}=[...]), or go on with load(...)"
        )


def within(keep: np.ndarray | None, first: int, size: int) -> np.ndarray | None:
    """The rows of a leg that are kept, counted from its start."""
    return None if keep is None else keep[(keep >= first) & (keep < first + size)] - first


def _told(task: Task, first: int, total: int) -> Told | None:
    progress = task.progress
    return None if progress is None else lambda done: progress(first + done, total)


def with_travel(task: Task, columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Columns, with the travel of the machine if there is one: d + F / k."""
    if task.machine_stiffness is None:
        return dict(columns)
    return {**columns, "travel": columns["indentation"] + columns["normal_force"] / task.machine_stiffness}


def solution(
    task: Task,
    columns: Mapping[str, FloatArray],
    claims: Mapping[str, Claim],
    *,
    assumptions: tuple[Assumption, ...],
    status: Status,
    notes: tuple[str, ...],
    references: tuple[str, ...],
    starts: tuple[Mapping[str, float], ...] | None = None,
) -> Result:
    """
    The result of a walk: time, and every column as far as its claim holds.

    Parameters
    ----------
    task : Task
    columns : mapping of str to ndarray
        Quantities over the kept rows.
    claims : mapping of str to Claim
        One for every column at least.
    assumptions, status, notes, references, starts
        As in :class:`~pymdr.result.Result`.

    Returns
    -------
    Result
    """
    valid = {
        name: values if claims[name].where.all() else np.where(claims[name].where, values, math.nan)
        for name, values in columns.items()
        if claims[name].readable
    }
    time = times(task.path)
    if time is not None:
        valid = {"time": taken(time, task.keep), **valid}
    return Result(
        contact=task.contact,
        path=task.path,
        data=labelled(valid, rows=task.keep),
        claims=claims,
        assumptions=assumptions,
        status=status,
        notes=notes,
        references=references,
        machine_stiffness=task.machine_stiffness,
        starts=starts,
        rings=task.solver,
        reading=task.reading,
    )
