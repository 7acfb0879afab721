"""Parts of a work in order, in this process, on the cores of this machine or on a dask cluster, and a folder of the finished ones."""

from __future__ import annotations

import hashlib
import json
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

from pymdr import presentation
from pymdr.deferred import xr
from pymdr.errors import FileError, ProblemError, PymdrError
from pymdr.units import shown
from pymdr.version import __version__

Part = TypeVar("Part")
Answer = TypeVar("Answer")
Workers = Any
"""A number of cores, or a ``dask.distributed.Client``."""

_PENDING_HERE, _PENDING_THERE = 2, 4
"""Parts per core that are handed out at a time."""
ENDED_WORKERS = (
    "a worker process ended without an answer: it ran out of memory, or the script starts processes when it is imported; reduce workers, "
    'or call it below `if __name__ == "__main__":`'
)


def checked_workers(workers: Workers) -> Workers:
    """A number of cores, or the client of a cluster."""
    if is_cluster(workers) or (type(workers) is int and workers >= 1):
        return workers
    raise ProblemError(
        f"workers = {shown(workers)}: a whole number of at least 1 is needed, or a dask client"
    )


def is_cluster(workers: Workers) -> bool:
    """Whether the work is done on a cluster."""
    return hasattr(workers, "get_executor")


def cores_of(workers: Workers) -> int:
    """The number of cores that work."""
    return max(1, sum(workers.ncores().values())) if is_cluster(workers) else int(workers)


def in_order(
    work: Callable[[Part], Answer],
    parts: Iterable[Part],
    workers: Workers,
    pool: type[ProcessPoolExecutor] | type[ThreadPoolExecutor] = ProcessPoolExecutor,
) -> Iterator[Answer]:
    """
    Answers of parts in order, which are read as they are handed out, a few per core at a time.

    A part whose worker is lost is done again on another worker of a cluster.

    Raises
    ------
    ProblemError
        If processes of this machine, or a cluster, end before they have answered.
    """
    if is_cluster(workers):
        yield from _on_cluster(work, parts, workers)
    elif workers == 1:
        yield from map(work, parts)
    else:
        with pool(workers) as executor:
            yield from _handed_out(work, parts, executor, _PENDING_HERE * workers)


def counted(
    answers: Iterable[Answer], total: int, progress: Callable[[int, int], None] | None
) -> list[Answer]:
    """All answers, reported as they come."""
    results = []
    for one in answers:
        results.append(one)
        if progress is not None:
            progress(len(results), total)
    return results


def _on_cluster(work: Callable[[Part], Answer], parts: Iterable[Part], client: Any) -> Iterator[Answer]:
    try:
        yield from _handed_out(work, parts, client.get_executor(), _PENDING_THERE * cores_of(client))
    except Exception as error:
        if isinstance(error, PymdrError) or not type(error).__module__.startswith("distributed"):
            raise
        raise ProblemError(
            f"workers: the cluster abandoned a part of the work: {error}; give its workers more memory, or call again: finished parts in "
            "a folder are not repeated"
        ) from error


def _handed_out(
    work: Callable[[Part], Answer], parts: Iterable[Part], executor: Executor, most: int
) -> Iterator[Answer]:
    pending: deque[Future[Answer]] = deque()
    try:
        for part in parts:
            pending.append(executor.submit(work, part))
            if len(pending) >= most:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    except BrokenProcessPool as error:
        raise ProblemError(f"workers: {ENDED_WORKERS}") from error
    finally:
        for one in pending:
            one.cancel()


_MARK = "pymdr_work"
_FIRST = "first_part"


class KeptParts:
    """
    A folder of the finished parts of one computation, numbered from 0.

    Parameters
    ----------
    folder : path
        Created if it does not exist.
    work : mapping
        Identity of the computation, JSON-serialisable; a folder of another computation or version of pymdr is refused.
    """

    def __init__(self, folder: str | os.PathLike[str], work: Mapping[str, Any]) -> None:
        self.folder = presentation.files.named_file(folder, "write")
        identity = {**work, "version": __version__}
        self.mark = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                f"cannot write into {self.folder}: {error.strerror or error}; choose another folder"
            ) from error

    def _files(self) -> list[Path]:
        return sorted(self.folder.glob("parts-*.nc"))

    def parts(self) -> Iterator[tuple[int, xr.Dataset]]:
        """The finished parts: the number of the first in a file, and the file's dataset over ``part``."""
        for file in self._files():
            part = presentation.files.read_dataset(file)
            if part.attrs.get(_MARK) != self.mark:
                raise FileError(
                    f"{file} belongs to another computation: its arguments, or the version of pymdr, have changed; use "
                    "another folder, or empty this one"
                )
            yield int(part.attrs[_FIRST]), part

    def keep(self, first: int, finished: xr.Dataset) -> None:
        """Write finished parts, whole or not at all."""
        marked = finished.assign_attrs({_MARK: self.mark, _FIRST: first})
        presentation.files.write_dataset(marked, self.folder / f"parts-{first:09d}.nc")
