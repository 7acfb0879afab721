"""Many contacts along one path, on several cores."""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

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
        Number of processes; 1 solves in this one.
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

    away = [contact for contact in contacts if _can_travel(contact)] if _can_travel(path) else []
    size = max(1, math.ceil(len(away) / (_SHARES * workers)))
    with ProcessPoolExecutor(workers) as pool:
        shares = [
            pool.submit(_solve_share, away[first : first + size], path, options)
            for first in range(0, len(away), size)
        ]
        ready = (answer for share in shares for answer in share.result())
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


def _solve_share(
    contacts: list[Contact], path: LoadingPath, options: dict[str, Any]
) -> list[Result | PymdrError]:
    """Solve some contacts; the path, which the caller has, does not go back."""
    answers = [_solve_quietly(contact, path, options) for contact in contacts]
    return [replace(answer, path=Hold()) if isinstance(answer, Result) else answer for answer in answers]


def _solve_quietly(contact: Contact, path: LoadingPath, options: dict[str, Any]) -> Result | PymdrError:
    try:
        return solve(contact, path, **options)
    except PymdrError as error:
        return error
