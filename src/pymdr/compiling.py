"""Compilation of kernels, cached on disk if possible, with a warning if it takes time. Loads numba."""

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
"""Time in s before a warning; reading cached code is faster."""
_reported = threading.Event()
_unkept = threading.Event()
_checked: set[tuple[str, Stamp]] = set()


Stamp = tuple[float, int]
INNER = {"no_cpython_wrapper": True}
"""Options of kernels that only kernels call: compiled in four fifths of the time."""


def stamp_of(*modules: str) -> Stamp:
    """A stamp of all files in the folders of some modules, given by their ``__file__``."""
    files = [file.stat() for module in modules for file in Path(module).parent.glob("*.py")]
    return max(file.st_mtime for file in files), sum(file.st_size for file in files)


def compiled(function: Function, stamp: Stamp | None = None, **options: Any) -> Function:
    """
    Compile with numba on the first call, cached on disk if a folder is writable.

    The cache is valid until the file of the outermost function changes, or with a stamp until the stamp changes. Numba compiles
    again for read-only arrays and for constants passed between kernels, so callers pass copies and variables. Without numba the
    function is returned unchanged.
    """
    if INTERPRETED:
        _warn_interpreted()
        return function
    settings = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, **options}
    try:
        kernel = njit(cache=True, **settings)(function)
    except RuntimeError:  # neither __pycache__ nor a user cache is writable
        _unkept.set()
        kernel = njit(**settings)(function)
    if stamp is not None:
        _leave_out_older(kernel.stats.cache_path, stamp)
    return cast(Function, kernel)


def inner(function: Function) -> Function:
    """Compile a function that only kernels call, without the slow wrappers for arguments from Python."""
    return compiled(function, None, **INNER)


def _leave_out_older(folder: str | None, stamp: Stamp) -> None:
    """Remove cache files older than a file that is compiled into kernels of other files."""
    if folder is None or (folder, stamp) in _checked:
        return
    _checked.add((folder, stamp))
    for index in Path(folder).glob("*.nbi"):
        with contextlib.suppress(OSError):
            if index.stat().st_mtime < stamp[0]:
                index.unlink()


def _warn_interpreted() -> None:
    if not _reported.is_set():
        _reported.set()
        _log.warning(
            "Numerical kernels run as plain Python, about a hundred times slower: numba is missing or disabled"
        )


class _CompileListener:
    """A listener of numba that warns once if compiling a pymdr kernel takes long."""

    def __init__(self) -> None:
        self.timers: list[threading.Timer] = []

    def notify(self, event: Any) -> None:
        """Start or cancel the timer of the warning."""
        if not event.data["dispatcher"].py_func.__module__.startswith("pymdr."):
            return
        if event.is_start:
            timer = threading.Timer(_PATIENCE, _warn_compiling)
            timer.daemon = True
            timer.start()
            self.timers.append(timer)
        elif self.timers:
            self.timers.pop().cancel()


def _warn_compiling() -> None:
    if _reported.is_set():
        return
    _reported.set()
    kept = (
        "in every new process, because no cache folder is writable: set NUMBA_CACHE_DIR"
        if _unkept.is_set()
        else "once after an installation"
    )
    _log.warning("Compiling numerical kernels (about 10 s, %s)", kept)


def _listen() -> None:
    try:
        from numba.core import event
    except ImportError:  # no numba, or one without events
        return
    event.Listener.register(_CompileListener)
    event.register("numba:compile", _CompileListener())


_listen()
