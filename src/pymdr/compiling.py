"""How kernels are compiled: kept on disk where there is a place for them, and reported when it takes time. Loads numba."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

try:
    from numba import config, njit
except ImportError:  # missing, blocked, or refused by a newer NumPy
    njit = None  # type: ignore[assignment]

Function = TypeVar("Function", bound=Callable[..., Any])

INTERPRETED = njit is None or bool(getattr(config, "DISABLE_JIT", False))
"""Whether kernels run as plain Python: numba is missing, or NUMBA_DISABLE_JIT forbids it to compile."""

_log = logging.getLogger("pymdr")
_PATIENCE = 1.0
"""Seconds; code that is read from disk is there sooner."""
_told = threading.Event()
_unkept = threading.Event()
_checked: set[tuple[str, Stamp]] = set()


Stamp = tuple[float, int]
INNER = {"no_cpython_wrapper": True}
"""Options of kernels that only kernels call: compiled in four fifths of the time."""


def stamp_of(*modules: str) -> Stamp:
    """What changes with any file beside some modules, given by their ``__file__``."""
    files = [file.stat() for module in modules for file in Path(module).parent.glob("*.py")]
    return max(file.st_mtime for file in files), sum(file.st_size for file in files)


def compiled(function: Function, stamp: Stamp | None = None, **options: Any) -> Function:
    """
    Compile with numba when first called; kept on disk, unless no folder for it can be written.

    Numba keeps compiled code until the file of the outermost function changes; with a stamp, until that does. It compiles
    once more for arrays that cannot be written and for constants that one kernel gives another: callers give copies
    and variables. Without numba the function stays as it is.
    """
    if INTERPRETED:
        _tell_interpreted()
        return function
    settings = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, **options}
    try:
        kernel = njit(cache=True, **settings)(function)
    except RuntimeError:  # numba finds neither __pycache__ nor a cache of the user that takes files
        _unkept.set()
        kernel = njit(**settings)(function)
    if stamp is not None:
        _leave_out_older(kernel.stats.cache_path, stamp)
    return cast(Function, kernel)


def inner(function: Function) -> Function:
    """Compile a function that only kernels call: without the wrappers that take arguments from Python, which take longer than it."""
    return compiled(function, None, **INNER)


def _leave_out_older(folder: str | None, stamp: Stamp) -> None:
    """Remove what numba kept before a file changed that is compiled into other files' kernels."""
    if folder is None or (folder, stamp) in _checked:
        return
    _checked.add((folder, stamp))
    for index in Path(folder).glob("*.nbi"):
        with contextlib.suppress(OSError):
            if index.stat().st_mtime < stamp[0]:
                index.unlink()


def _tell_interpreted() -> None:
    if not _told.is_set():
        _told.set()
        _log.warning(
            "Numerical kernels run as plain Python, about a hundred times slower: numba is missing or told not to compile"
        )


class _Waiting:
    """Told by numba when it compiles, says so once if a kernel of ours takes long."""

    def __init__(self) -> None:
        self.timers: list[threading.Timer] = []

    def notify(self, event: Any) -> None:
        """Begin to wait, or stop."""
        if not event.data["dispatcher"].py_func.__module__.startswith("pymdr."):
            return
        if event.is_start:
            timer = threading.Timer(_PATIENCE, _tell)
            timer.daemon = True
            timer.start()
            self.timers.append(timer)
        elif self.timers:
            self.timers.pop().cancel()


def _tell() -> None:
    if _told.is_set():
        return
    _told.set()
    kept = (
        "in every new process, since no folder for the result can be written: set NUMBA_CACHE_DIR to one"
        if _unkept.is_set()
        else "once after an installation"
    )
    _log.warning("Compiling numerical kernels (about 10 s, %s)", kept)


def _listen() -> None:
    try:
        from numba.core import event
    except ImportError:  # no numba, or one that does not tell
        return
    event.Listener.register(_Waiting)
    event.register("numba:compile", _Waiting())


_listen()
