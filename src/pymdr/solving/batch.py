"""Many contacts along one path, on several cores."""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from pymdr.errors import ProblemError, PymdrError
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Hold, LoadingPath
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.units import QuantityLike

_SHARES = 8
"""Shares of the work for every process."""


class _Parcel(NamedTuple):
    """Pickled answers, and where their arrays lie in which shared memory."""

    head: bytes
    memory: str
    ends: list[int]


def solve_batch(
    contacts: Sequence[Contact],
    path: LoadingPath,
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    workers: int = 1,
    throw: bool = True,
    progress: Progress | None = None,
) -> list[Result | PymdrError]:
    """
    Solve many contacts along one path.

    Parameters
    ----------
    contacts : sequence of Contact
    path : LoadingPath
    machine_stiffness, keep
        As for :func:`solve`.
    workers : int
        Number of processes; 1 solves in this one. All rows of long histories take about as long to bring back as
        to solve: ``keep`` makes them light.
    throw : bool
        Whether the first error ends the batch; otherwise errors take the place of results.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    list of Result (or PymdrError)
        In the order of `contacts`.

    Raises
    ------
    PymdrError
        The first error, if `throw`.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.paths import indent
    >>> from pymdr.problem.profiles import Paraboloid
    >>> balls = [Contact(Paraboloid(R), Elastic("1 MPa", 0.5)) for R in ("1 mm", "4 mm")]
    >>> forces = [float(r["normal_force"][-1]) for r in solve_batch(balls, indent("1 um"))]
    >>> round(forces[1] / forces[0], 12)
    2.0
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ProblemError(f"solve_batch: workers = {workers!r}; a whole number of at least 1 is needed")
    options = {"machine_stiffness": machine_stiffness, "keep": keep}
    pieces = list(contacts)
    answers: list[Result | PymdrError] = []
    found: Iterator[Result | PymdrError] = (_solve_quietly(contact, path, options) for contact in pieces)
    if workers > 1:
        found = _solve_apart(pieces, path, options, workers)
    for answer in found:
        if throw and isinstance(answer, PymdrError):
            raise answer
        answers.append(answer)
        if progress is not None:
            progress(len(answers), len(pieces))
    return answers


def _solve_apart(
    contacts: list[Contact], path: LoadingPath, options: dict[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """Solve in other processes, but for what cannot be sent to one, such as a lambda."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import resource_tracker

    away = [contact for contact in contacts if _can_travel(contact)] if _can_travel(path) else []
    size = max(1, math.ceil(len(away) / (_SHARES * workers)))
    # one tracker of shared memory for all processes, or each would clean up after itself too early
    resource_tracker.ensure_running()
    with ProcessPoolExecutor(workers) as pool:
        shares = [
            pool.submit(_solve_share, away[first : first + size], path, options)
            for first in range(0, len(away), size)
        ]
        ready = (answer for share in shares for answer in _received(share.result()))
        for contact in contacts:
            if not away or not _can_travel(contact):
                yield _solve_quietly(contact, path, options)
                continue
            answer = next(ready)
            yield replace(answer, contact=contact, path=path) if isinstance(answer, Result) else answer


def _can_travel(value: Contact | LoadingPath) -> bool:
    try:
        pickle.dumps(value)
    except (AttributeError, TypeError, pickle.PicklingError):
        return False
    return True


def _solve_share(contacts: list[Contact], path: LoadingPath, options: dict[str, Any]) -> _Parcel:
    """Solve some contacts; the path, which the caller has, does not go back."""
    answers = [_solve_quietly(contact, path, options) for contact in contacts]
    return _sent(
        [replace(answer, path=Hold()) if isinstance(answer, Result) else answer for answer in answers]
    )


def _sent(answers: list[Result | PymdrError]) -> _Parcel:
    """Answers with their arrays in shared memory: a pipe would take longer than to solve them again."""
    from multiprocessing.shared_memory import SharedMemory

    arrays: list[pickle.PickleBuffer] = []
    head = pickle.dumps(answers, protocol=5, buffer_callback=arrays.append)
    ends = [0, *accumulate(array.raw().nbytes for array in arrays)]
    memory = SharedMemory(create=True, size=max(ends[-1], 1))
    assert memory.buf is not None
    room = memoryview(memory.buf)
    for array, (start, end) in zip(arrays, pairwise(ends), strict=True):
        room[start:end] = array.raw()
    room.release()
    memory.close()
    return _Parcel(head, memory.name, ends)


def _received(parcel: _Parcel) -> list[Result | PymdrError]:
    """Unpack answers and give the shared memory back."""
    from multiprocessing.shared_memory import SharedMemory

    memory = SharedMemory(parcel.memory)
    assert memory.buf is not None
    everything = memoryview(bytearray(memory.buf))
    memory.close()
    memory.unlink()
    arrays = [everything[start:end] for start, end in pairwise(parcel.ends)]
    answers: list[Result | PymdrError] = pickle.loads(parcel.head, buffers=arrays)
    return answers


def _solve_quietly(contact: Contact, path: LoadingPath, options: dict[str, Any]) -> Result | PymdrError:
    try:
        return solve(contact, path, **options)
    except PymdrError as error:
        return error
