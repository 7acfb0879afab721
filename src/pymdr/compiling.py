"""How kernels are compiled: kept on disk where there is a place for them, and told when it takes time. Loads numba."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import config, njit, types

Function = TypeVar("Function", bound=Callable[..., Any])

INTERPRETED = bool(getattr(config, "DISABLE_JIT", False))
"""Whether NUMBA_DISABLE_JIT asks for kernels that are not compiled."""

_log = logging.getLogger("pymdr")
_PATIENCE = 1.0
"""Seconds; code that is read from disk is there sooner."""
_told = threading.Event()
_unkept = threading.Event()


Stamp = tuple[float, int]


def stamp_of(*modules: str) -> Stamp:
    """What changes with any file beside some modules, given by their ``__file__``."""
    files = [file.stat() for module in modules for file in Path(module).parent.glob("*.py")]
    return max(file.st_mtime for file in files), sum(file.st_size for file in files)


def compiled(function: Function, stamp: Stamp | None = None, **options: Any) -> Function:
    """
    Compile with numba when first called; kept on disk, unless no folder for it can be written.

    Numba keeps compiled code until the file of the outermost function changes; with a stamp, until that does. It compiles
    once more for arrays that cannot be written: callers give copies.
    """
    settings = {"nogil": True, "error_model": "numpy", **options}
    try:
        kernel = njit(cache=True, **settings)(function)
    except RuntimeError:  # numba finds neither __pycache__ nor a cache of the user that takes files
        _unkept.set()
        kernel = njit(**settings)(function)
    index: Any = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if stamp is not None and index is not None and hasattr(index, "_source_stamp"):
        index._source_stamp = stamp
    _compile_constants_as_numbers(kernel)
    return cast(Function, kernel)


def inner(function: Function) -> Function:
    """Compile a function that only kernels call: without the wrappers that take arguments from Python, which take longer than it."""
    return compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def _compile_constants_as_numbers(kernel: Any) -> None:
    """Numba compiles a kernel anew for every constant that another kernel gives it; once for its type is enough."""
    template = getattr(kernel, "get_call_template", None)
    if template is not None:
        kernel.get_call_template = lambda args, kws: template(
            [types.unliteral(a) for a in args], {name: types.unliteral(a) for name, a in kws.items()}
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
    _log.warning("compiling what this needs, up to a minute, %s", kept)


def _listen() -> None:
    try:
        from numba.core import event
    except ImportError:  # a numba that does not tell
        return
    event.Listener.register(_Waiting)
    event.register("numba:compile", _Waiting())


_listen()
