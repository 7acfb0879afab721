"""Many contacts along one path, on several cores."""

from __future__ import annotations

import math
import pickle
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate, chain, compress, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import ArrayLike

from pymdr.errors import ProblemError, PymdrError
from pymdr.machine import one_thread
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Hold, LoadingPath
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.solving.workers import (
    ENDED_WORKERS,
    Workers,
    checked_workers,
    cores_of,
    counted,
    in_order,
    is_cluster,
)
from pymdr.units import QuantityLike, shown

if TYPE_CHECKING:
    from multiprocessing.context import BaseContext

_BLOCKS = 8
"""Blocks of the work per process."""
_MANY = 4
"""Contacts per process from which on the first are solved in this process, to measure how long they take."""
_SHORT = 1.0
"""Work in s below which no process is started."""


class _Parcel(NamedTuple):
    """Pickled answers, and the ends of their arrays in a shared memory."""

    head: bytes
    memory: str
    ends: list[int]


class Request(NamedTuple):
    """A contact, its path, and the machine stiffness in N/m."""

    contact: Contact
    path: LoadingPath
    machine_stiffness: QuantityLike | None


def solve_batch(
    contacts: Sequence[Contact],
    path: LoadingPath | Sequence[LoadingPath],
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    tolerance: float | None = None,
    workers: Workers = 1,
    throw: bool = True,
    progress: Progress | None = None,
) -> list[Result | PymdrError]:
    """
    Solve many contacts, along one path or each along its own.

    Parameters
    ----------
    contacts : sequence of Contact
        Contacts to solve.
    path : LoadingPath or sequence of LoadingPath
        One for all, or as many as contacts.
    machine_stiffness, keep, tolerance
        As for :func:`solve`.
    workers : int or dask.distributed.Client
        The client of a cluster, or the number of processes including this one; work of less than a second stays in this one. Processes that cannot be forked
        (with other threads, on Windows and macOS, from Python 3.14 on) import the calling script, which then must call below
        ``if __name__ == "__main__":``. Long histories take time to transfer: reduce them with ``keep``. With `threadpoolctl`
        installed linear algebra uses one thread per process.
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
        If the numbers of paths and contacts differ, `workers` is neither a whole number above 0 nor a client, or another process ends before it
        has answered.
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
    for name, yielded in (("contacts", contacts), ("path", path)):
        if not isinstance(yielded, Iterable | LoadingPath):
            raise ProblemError(
                f"{name} = {shown(yielded)}; a list is needed, such as [Contact(profile, body)]"
            )
    bodies = list(contacts)
    paths = [path] * len(bodies) if isinstance(path, LoadingPath) else list(path)
    if len(paths) != len(bodies):
        raise ProblemError(
            f"{len(paths)} paths for {len(bodies)} contacts; give one path for all, or one for each"
        )
    requests = [Request(*both, machine_stiffness) for both in zip(bodies, paths, strict=True)]
    answers = solutions(requests, {"keep": keep, "tolerance": tolerance}, workers)
    return counted(_thrown(answers) if throw else answers, len(bodies), progress)


def _thrown(answers: Iterable[Result | PymdrError]) -> Iterator[Result | PymdrError]:
    """Results up to the first error, which is raised."""
    for answer in answers:
        if isinstance(answer, PymdrError):
            raise answer
        yield answer


def solutions(
    requests: Sequence[Request], options: Mapping[str, Any], workers: Workers
) -> Iterator[Result | PymdrError]:
    """Results of contacts along their paths, or why there is none, in order and one by one."""
    if is_cluster(checked_workers(workers)):
        return _solve_on_cluster(requests, options, workers)
    if workers == 1:
        return (_solve_quietly(one, options) for one in requests)
    return _solve_parallel(requests, options, workers)


def _solve_parallel(
    requests: Sequence[Request], options: Mapping[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """Solve in several processes, unless all of it is short."""
    workers = min(workers, len(requests))
    done = 0
    if workers < 2 or len(requests) >= _MANY * workers:
        # the first one is not timed: it loads and compiles
        for done, one in enumerate(requests, 1):
            start = time.perf_counter()
            answer = _solve_quietly(one, options)
            needed = (len(requests) - done) * (time.perf_counter() - start)
            yield answer
            if workers > 1 and done > 1 and needed > _SHORT:
                break
    if done < len(requests):
        yield from _solve_in_processes(requests[done:], options, workers)


def _solve_in_processes(
    requests: Sequence[Request], options: Mapping[str, Any], workers: int
) -> Iterator[Result | PymdrError]:
    """
    Solve in this process and in others, in order.

    This process solves what cannot be pickled, such as a lambda, and blocks of the rest.
    """
    from concurrent.futures import Future, ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import resource_tracker

    picklable = _picklable(requests)
    remote = [i for i, sendable in enumerate(picklable) if sendable]
    here = deque([i] for i, sendable in enumerate(picklable) if not sendable)
    size = max(1, math.ceil(len(requests) / (_BLOCKS * workers)))
    blocks = deque(remote[first : first + size] for first in range(0, len(remote), size))
    answers: dict[int, Result | PymdrError] = {}
    sent: deque[tuple[list[int], Future[_Parcel]]] = deque()
    yielded = 0
    # one tracker of shared memory for all processes, or each would clean up after itself too early
    resource_tracker.ensure_running()
    with (
        one_thread(),
        ProcessPoolExecutor(workers - 1, _start_context(), initializer=_stay_in_one_thread) as pool,
    ):
        while yielded < len(requests):
            while blocks and len(sent) < workers:
                block = blocks.popleft()
                sent.append((block, pool.submit(_solve_block, [requests[i] for i in block], options)))
            own = here or blocks
            waits = not own
            for i in own.popleft() if own else []:
                answers[i] = _solve_quietly(requests[i], options)
            while sent and (sent[0][1].done() or waits):
                block, parcel = sent.popleft()
                try:
                    received = _received(parcel.result())
                except BrokenProcessPool as error:
                    raise ProblemError(f"workers = {workers}: {ENDED_WORKERS}") from error
                for i, answer in zip(block, received, strict=True):
                    answers[i] = _with_its_own(answer, requests[i])
                waits = False
            while yielded in answers:
                yield answers.pop(yielded)
                yielded += 1


def _solve_on_cluster(
    requests: Sequence[Request], options: Mapping[str, Any], client: Workers
) -> Iterator[Result | PymdrError]:
    """Solve on a cluster, and here what cannot be pickled, in order."""
    picklable = _picklable(requests)
    remote = list(compress(requests, picklable))
    size = max(1, math.ceil(len(remote) / (_BLOCKS * cores_of(client))))
    blocks = (remote[first : first + size] for first in range(0, len(remote), size))
    answers = chain.from_iterable(in_order(partial(_solved, options), blocks, client))
    for one, goes in zip(requests, picklable, strict=True):
        yield _with_its_own(next(answers), one) if goes else _solve_quietly(one, options)


def _with_its_own(answer: Result | PymdrError, one: Request) -> Result | PymdrError:
    """An answer of another process with the contact and the path of the caller."""
    return replace(answer, contact=one.contact, path=one.path) if isinstance(answer, Result) else answer


def _start_context() -> BaseContext:
    """
    The method by which processes are started.

    A fork (where it is the default) has everything loaded. It is used only without other Python threads, whose locks would never
    be released in it; OpenBLAS restarts its threads in a fork, and compiled kernels use none.
    """
    import multiprocessing
    import threading

    if threading.active_count() == 1 or "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context()
    context = multiprocessing.get_context("forkserver")
    # loaded once for all processes of all batches
    context.set_forkserver_preload([__name__])
    return context


def _stay_in_one_thread() -> None:
    """Begin a process whose linear algebra takes one thread."""
    one_thread()


def _picklable(requests: Sequence[Request]) -> list[bool]:
    """Which requests other processes can be sent."""
    paths = {key: _is_picklable(path) for key, path in {id(one.path): one.path for one in requests}.items()}
    return [paths[id(one.path)] and _is_picklable(one.contact) for one in requests]


def _is_picklable(value: Contact | LoadingPath) -> bool:
    try:
        pickle.dumps(value)
    except (AttributeError, TypeError, pickle.PicklingError, ProblemError):
        return False
    return True


def _solve_block(requests: Sequence[Request], options: Mapping[str, Any]) -> _Parcel:
    """Solve some contacts for another process of this machine."""
    # shared memory is much faster than a pipe
    from multiprocessing.shared_memory import SharedMemory

    arrays: list[pickle.PickleBuffer] = []
    head = pickle.dumps(_solved(options, requests), protocol=5, buffer_callback=arrays.append)
    ends = [0, *accumulate(array.raw().nbytes for array in arrays)]
    memory = SharedMemory(create=True, size=max(ends[-1], 1))
    assert memory.buf is not None
    view = memoryview(memory.buf)
    for array, (start, end) in zip(arrays, pairwise(ends), strict=True):
        view[start:end] = array.raw()
    view.release()
    memory.close()
    return _Parcel(head, memory.name, ends)


def _solved(options: Mapping[str, Any], requests: Sequence[Request]) -> list[Result | PymdrError]:
    """Answers without the paths, which the caller has."""
    answers = (_solve_quietly(one, options) for one in requests)
    return [replace(answer, path=Hold()) if isinstance(answer, Result) else answer for answer in answers]


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


def _solve_quietly(request: Request, options: Mapping[str, Any]) -> Result | PymdrError:
    try:
        return solve(request.contact, request.path, machine_stiffness=request.machine_stiffness, **options)
    except PymdrError as error:
        return error
