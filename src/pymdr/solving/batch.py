"""Many contacts along one path, on several cores."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import replace

from pymdr.errors import ProblemError, PymdrError
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.verb import solve


def solve_batch(
    contacts: Sequence[Contact],
    path: LoadingPath,
    *,
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
    jobs = [(contact, path) for contact in contacts]
    answers: list[Result | PymdrError] = []
    if workers > 1:
        from concurrent.futures import ProcessPoolExecutor

        # what cannot be sent to another process, such as a lambda, is solved in this one
        travels = [_can_travel(job) for job in jobs]
        with ProcessPoolExecutor(workers) as pool:
            futures = [
                pool.submit(_solve_quietly, job) if away else None
                for job, away in zip(jobs, travels, strict=True)
            ]
            for job, future in zip(jobs, futures, strict=True):
                answer = _solve_quietly(job) if future is None else future.result()
                if isinstance(answer, Result):
                    answer = replace(answer, contact=job[0])
                _collect(answers, answer, throw, progress, len(jobs))
    else:
        for job in jobs:
            _collect(answers, _solve_quietly(job), throw, progress, len(jobs))
    return answers


def _can_travel(job: tuple[Contact, LoadingPath]) -> bool:
    try:
        pickle.dumps(job)
    except (AttributeError, TypeError, pickle.PicklingError):
        return False
    return True


def _solve_quietly(job: tuple[Contact, LoadingPath]) -> Result | PymdrError:
    try:
        return solve(*job)
    except PymdrError as error:
        return error


def _collect(
    answers: list[Result | PymdrError],
    answer: Result | PymdrError,
    throw: bool,
    progress: Progress | None,
    total: int,
) -> None:
    if throw and isinstance(answer, PymdrError):
        raise answer
    answers.append(answer)
    if progress is not None:
        progress(len(answers), total)
