"""One walk along a path for every law of a contact, and the solution in which it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from pymdr.errors import PathError
from pymdr.independent.rings import Rings
from pymdr.interpretation.conductance import CONDUCTION_SOURCES, CONDUCTIONS, with_conduction
from pymdr.interpretation.interior import stress_claim
from pymdr.interpretation.thickness import THICKNESS_SOURCE, samples_of, with_thickness
from pymdr.interpretation.validity import BODY_SOURCES, Assumption, Claim
from pymdr.problem.contact import Contact
from pymdr.problem.paths import NORMAL_CHANNELS, LoadingPath, Path
from pymdr.problem.schedule import Progress, Stretch, is_planar, planned, total_rows
from pymdr.result import Reading, Result, Status, labelled
from pymdr.rows import joined, taken
from pymdr.units import FloatArray

State = TypeVar("State")
Rows = TypeVar("Rows")

Channels = Mapping[str, float]
"""Position of every channel in SI units: 0 for those left out, NaN where it is unknown."""

LegProgress = Callable[[int], None]
"""Called with the number of rows of a leg that are done, before its end."""

Step = Callable[[State, Stretch, np.ndarray | None, LegProgress | None], tuple[Rows, State, Channels]]
"""The step of a law along one leg; see :func:`walk`."""


@dataclass(frozen=True)
class Task:
    """A contact, its path and the options of `solve`."""

    contact: Contact
    path: LoadingPath
    reading: Reading
    """How fields and figures of the result are computed."""
    machine_stiffness: float | None = None
    """In N/m."""
    keep: np.ndarray | None = None
    """Rows of the path that are kept, ascending; None for all."""
    progress: Progress | None = None
    solver: Rings | None = None
    """Boundary elements, if they replace the method."""
    tolerance: float | None = None
    """Largest error of the force of a cohesive zone with memory; None for its usual resolution."""


@dataclass(frozen=True)
class Walked(Generic[Rows]):
    """The rows of a walk."""

    rows: Rows
    """Rows of all legs, concatenated."""
    starts: tuple[Channels, ...]
    """Positions of the channels at the start of each leg."""
    time: FloatArray | None
    """Time of every row of the path in s, if the path gives it."""


def walk(task: Task, start: State, step: Step[State, Rows]) -> Walked[Rows]:
    """
    Follow a path leg by leg.

    Parameters
    ----------
    start
        State of the law before the first leg.
    step : callable
        ``rows, state, channels = step(state, stretch, kept, progress)`` follows one leg from a state: `stretch` holds its
        controls, prescribed values and times, `kept` the requested rows (None for all), `progress` reports rows done within a long
        leg (may be None). `rows` are arrays over the requested rows, alone or in dicts, named tuples and frozen
        dataclasses; `state` and `channels` are those at its end.

    Raises
    ------
    PathError, ProblemError, ConvergenceError
        Errors of the steps, with the number of the leg if there are several.
    """
    state, here = start, dict[str, float]()
    rows: list[Rows] = []
    starts: list[Channels] = []
    times: list[FloatArray] = []
    now = 0.0
    total = total_rows(task.path)
    for leg in planned(task.path):
        starts.append(here)
        with leg.named():
            stretch = leg.stretch(here, now)
            _refuse_without_position(stretch)
            progress, kept = _leg_progress(task, leg.first, total), within(task.keep, leg.first, leg.size)
            leg_rows, state, channels = step(state, stretch, kept, progress)
        rows.append(leg_rows)
        if stretch.time is not None:
            times.append(stretch.time)
            now = float(stretch.time[-1])
        here = {**channels, **stretch.end}
        if task.progress is not None:
            task.progress(leg.first + leg.size, total)
    return Walked(joined(rows), tuple(starts), np.concatenate(times) if times else None)


def _refuse_without_position(stretch: Stretch) -> None:
    channel = stretch.controls.normal
    if not isinstance(stretch.leg.leg, Path) and math.isnan(stretch.start[0]):
        raise PathError(
            f"the contact was lost under a prescribed force, or could not be solved, so a leg of {channel} has no start position; "
            f"begin the leg with Path({channel}=[...]), or continue with load(...)"
        )


def within(keep: np.ndarray | None, first: int, size: int) -> np.ndarray | None:
    """The kept rows of a leg or of a part of it, counted from its start."""
    return None if keep is None else keep[(keep >= first) & (keep < first + size)] - first


def _leg_progress(task: Task, first: int, total: int) -> LegProgress | None:
    progress = task.progress
    return None if progress is None else lambda done: progress(first + done, total)


def channels_at(indentation: float, normal_force: float, machine_stiffness: float | None) -> dict[str, float]:
    """Positions of the normal channels, with the travel of the machine d + F / k."""
    travel = indentation + normal_force / (machine_stiffness or math.inf)
    return {"indentation": indentation, "normal_force": normal_force, "travel": travel}


def with_travel(task: Task, columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Columns, with the travel of the machine if there is one."""
    if task.machine_stiffness is None:
        return dict(columns)
    return {**columns, "travel": columns["indentation"] + columns["normal_force"] / task.machine_stiffness}


@dataclass(frozen=True, kw_only=True)
class Interpretation:
    """Step 3: columns, claims and status of the rows of a walk."""

    columns: Mapping[str, FloatArray]
    claims: Mapping[str, Claim]
    assumptions: tuple[Assumption, ...]
    status: Status
    references: tuple[str, ...]
    notes: tuple[str, ...] = ()
    starts: tuple[Channels, ...] | None = None
    """Positions of the channels at the start of each leg, if fields need them."""
    is_viscoelastic: bool = False
    """Whether the bodies have memory; if not, a note states that time has no effect."""
    conducting: FloatArray | None = None
    """Half the stiffness over E* in m, of contacts that are not disks."""


def solution(task: Task, walked: Walked[Any], interpretation: Interpretation) -> Result:
    """The result of a walk: the time of every kept row, and every quantity, NaN where its claim does not hold."""
    own, notes = interpretation, interpretation.notes
    columns, claims = with_conduction(task.contact, own.columns, own.claims, own.conducting)
    if samples_of(task.contact):
        claims = with_thickness(task.contact, columns, claims, prescribed_rows(task))
    claims = {
        **claims,
        "stress": stress_claim(task.contact, task.solver is not None, claims, is_planar(task.path)),
    }
    if walked.time is not None and not own.is_viscoelastic:
        notes = (*notes, "the bodies are elastic: the times of the path have no effect")
    valid = {
        name: values if (where := claims[name].where).all() else np.where(where, values.T, math.nan).T
        for name, values in columns.items()
        if claims[name].readable
    }
    if walked.time is not None:
        valid = {"time": taken(walked.time, task.keep), **valid}
    return Result(
        contact=task.contact,
        path=task.path,
        data=labelled(valid, rows=task.keep),
        claims=claims,
        assumptions=own.assumptions,
        status=own.status,
        notes=notes,
        references=(
            *own.references,
            *_body_sources(task.contact),
            *(CONDUCTION_SOURCES if any(each.quantity in valid for each in CONDUCTIONS) else ()),
        ),
        machine_stiffness=task.machine_stiffness,
        starts=own.starts,
        rings=task.solver,
        reading=task.reading,
    )


def prescribed_rows(task: Task) -> dict[str, np.ndarray]:
    """The kept rows in which every normal channel is prescribed."""
    legs = planned(task.path)
    channels = np.repeat([leg.controls.normal for leg in legs], [leg.size for leg in legs])
    rigid = task.machine_stiffness is None or math.isinf(task.machine_stiffness)
    channels = taken(np.where((channels == "travel") & rigid, "indentation", channels), task.keep)
    return {name: channels == name for name in NORMAL_CHANNELS}


def _body_sources(contact: Contact) -> tuple[str, ...]:
    keys = [key for body in (contact.body, contact.counterbody) for key in BODY_SOURCES.get(type(body), ())]
    if samples_of(contact):
        keys.append(THICKNESS_SOURCE)
    return tuple(dict.fromkeys(keys))
