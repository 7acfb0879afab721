"""Many contacts along one path, on several cores."""

from __future__ import annotations

import math
import pickle
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import ArrayLike

from pymdr.errors import ProblemError, PymdrError
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Hold, LoadingPath
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.units import QuantityLike, shown

if TYPE_CHECKING:
    from multiprocessing.context import BaseContext

_SHARES = 8
"""Shares of the work for every process."""
_MANY = 4
"""Contacts for every process from which on some are solved in this one first, to see how long they take."""
_SHORT = 1.0
"""Work in s that starting a process does not pay for."""


class _Parcel(NamedTuple):
    """Pickled answers, and where their arrays lie in which shared memory."""

    head: bytes
    memory: str
    ends: list[int]


class Asked(NamedTuple):
    """A contact, its path, and the machine in N/m."""

    contact: Contact
    path: LoadingPath
    machine_stiffness: QuantityLike | None


def solve_batch(
    contacts: Sequence[Contact],
    path: LoadingPath | Sequence[LoadingPath],
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    workers: int = 1,
    throw: bool = True,
    progress: Progress | None = None,
) -> list[Result | PymdrError]:
    """
    Solve many contacts, along one path or each along its own.

    Parameters
    ----------
    contacts : sequence of Contact
    path : LoadingPath or sequence of LoadingPath
        One for all, or as many as contacts.
    machine_stiffness, keep
        As for :func:`solve`.
    workers : int
        Number of processes, this one among them; work of less than a second stays in this one. Where the others are no
        copies of this one (beside other threads, on Windows and macOS, from Python 3.14 on) they import the script that calls,
        which then does so below ``if __name__ == "__main__":``. All rows of long histories take time to bring back: ``keep``
        makes them light. With `threadpoolctl` installed linear algebra takes one thread in each.
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
    ProblemError
        If there are other numbers of paths than of contacts, `workers` is no whole number above 0, or another process ends
        before it has answered.
    PymdrError
        The first error, if `throw`.

    Examples
    --------
    >>> import pymdr as mdr
    >>> balls = [mdr.Contact(mdr.Paraboloid(R), mdr.Elastic("1 MPa", 0.5)) for R in ("1 mm", "4 mm")]
    >>> forces = [float(r["normal_force"][-1]) for r in mdr.solve_batch(balls, mdr.indent("1 um"))]
    >>> round(forces[1] / forces[0], 12)
    2.0
    """
    for name, given in (("contacts", contacts), ("path", path)):
        if not isinstance(given, Iterable | LoadingPath):
            raise ProblemError(
                f"solve_batch: {name} = {shown(given)}; a list is needed, such as [Contact(profile, body)]"
            )
    pieces = list(contacts)
    paths = [path] * len(pieces) if isinstance(path, LoadingPath) else list(path)
    if len(paths) != len(pieces):
        raise ProblemError(
            f"solve_batch: {len(paths)} paths for {len(pieces)} contacts; give one path for all, or one for each"
        )
    asked = [Asked(*both, machine_stiffness) for both in zip(pieces, paths, strict=True)]
    answers: list[Result | PymdrError] = []
    for answer in solutions(asked, {"keep": keep}, workers):
        if throw and isinstance(answer, PymdrError):
            raise answer
        answers.append(answer)
        if progress is not None:
            progress(len(answers), len(pieces))
    return answers


def solutions(
    asked: Sequence[Asked], options: Mapping[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """
    Results of contacts along their paths, or why there is none, in order and one by one.

    Raises
    ------
    ProblemError
        If `workers` is no whole number above 0.
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ProblemError(f"workers = {workers!r}: a whole number of at least 1 is needed")
    if workers == 1:
        return (_solve_quietly(one, options) for one in asked)
    return _solve_apart(asked, options, workers)


def _solve_apart(
    asked: Sequence[Asked], options: Mapping[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """Solve in several processes, unless all of it is short."""
    workers = min(workers, len(asked))
    done = 0
    if workers < 2 or len(asked) >= _MANY * workers:
        # the first one is not timed: it loads what the others find ready
        for done, one in enumerate(asked, 1):
            start = time.perf_counter()
            answer = _solve_quietly(one, options)
            needed = (len(asked) - done) * (time.perf_counter() - start)
            yield answer
            if workers > 1 and done > 1 and needed > _SHORT:
                break
    if done < len(asked):
        yield from _solve_shared(asked[done:], options, workers)


def _solve_shared(
    asked: Sequence[Asked], options: Mapping[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """
    Solve in this process and in others, in order.

    This one solves what cannot be sent, such as a lambda, and shares of the rest, which neither wait for a process to start
    nor are sent back.
    """
    from concurrent.futures import Future, ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import resource_tracker

    travels = {key: _can_travel(path) for key, path in {id(one.path): one.path for one in asked}.items()}
    goes = [travels[id(one.path)] and _can_travel(one.contact) for one in asked]
    away = [i for i, can in enumerate(goes) if can]
    here = deque([i] for i, can in enumerate(goes) if not can)
    size = max(1, math.ceil(len(asked) / (_SHARES * workers)))
    shares = deque(away[first : first + size] for first in range(0, len(away), size))
    answers: dict[int, Result | PymdrError] = {}
    sent: deque[tuple[list[int], Future[_Parcel]]] = deque()
    given = 0
    # one tracker of shared memory for all processes, or each would clean up after itself too early
    resource_tracker.ensure_running()
    with (
        _one_thread(),
        ProcessPoolExecutor(workers - 1, _start_context(), initializer=_stay_in_one_thread) as pool,
    ):
        while given < len(asked):
            while shares and len(sent) < workers:
                share = shares.popleft()
                sent.append((share, pool.submit(_solve_share, [asked[i] for i in share], options)))
            own = here or shares
            waits = not own
            for i in own.popleft() if own else []:
                answers[i] = _solve_quietly(asked[i], options)
            while sent and (sent[0][1].done() or waits):
                share, parcel = sent.popleft()
                try:
                    received = _received(parcel.result())
                except BrokenProcessPool as error:
                    raise ProblemError(
                        f"workers = {workers}: a process ended before it had answered, for want of memory or because the script "
                        'starts it while it is imported; call it below `if __name__ == "__main__":`, or with workers=1'
                    ) from error
                for i, answer in zip(share, received, strict=True):
                    answers[i] = _with_its_own(answer, asked[i])
                waits = False
            while given in answers:
                yield answers.pop(given)
                given += 1


def _with_its_own(answer: Result | PymdrError, one: Asked) -> Result | PymdrError:
    """An answer of another process with the contact and the path of the caller."""
    return replace(answer, contact=one.contact, path=one.path) if isinstance(answer, Result) else answer


def _start_context() -> BaseContext:
    """
    How processes are started.

    A copy of this one (a fork, where Python does so by itself) has all loaded at once. It is made only where no other thread of
    Python may hold a lock that the copy never sees released; the threads of OpenBLAS are begun anew in a copy, and compiled
    kernels use none.
    """
    import multiprocessing
    import threading

    if threading.active_count() == 1 or "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context()
    context = multiprocessing.get_context("forkserver")
    # loaded once for all processes of all batches
    context.set_forkserver_preload([__name__])
    return context


def _one_thread() -> AbstractContextManager[object]:
    """Linear algebra in one thread: threads of several processes wait for each other on the same cores."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(1)
    return limits


def _stay_in_one_thread() -> None:
    """Begin a process whose linear algebra takes one thread."""
    _one_thread()


def _can_travel(value: Contact | LoadingPath) -> bool:
    try:
        pickle.dumps(value)
    except (AttributeError, TypeError, pickle.PicklingError, ProblemError):
        return False
    return True


def _solve_share(asked: Sequence[Asked], options: Mapping[str, Any]) -> _Parcel:
    """Solve some contacts; the paths, which the caller has, do not go back."""
    answers = [_solve_quietly(one, options) for one in asked]
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


def _solve_quietly(asked: Asked, options: Mapping[str, Any]) -> Result | PymdrError:
    try:
        return solve(asked.contact, asked.path, machine_stiffness=asked.machine_stiffness, **options)
    except PymdrError as error:
        return error
