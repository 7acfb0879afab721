"""Compilation of kernels, cached on disk if possible, with a warning if it takes time. Loads numba."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

try:
    from numba import cfunc, config, njit, typeof, types
    from numba.core import event
    from numba.core.options import DefaultOptions
    from numba.extending import intrinsic
except ImportError:  # missing, blocked, or refused by a newer NumPy
    njit = event = DefaultOptions = None  # type: ignore[assignment,misc]

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
_NUMERICS = Path(__file__).with_name("numerics")
INNER = {"no_cpython_wrapper": True}
"""Options of kernels that only kernels call: compiled in four fifths of the time."""
UNCOUNTED = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}
"""Options of kernels that make no arrays, whose references are then not counted: faster to compile and to run."""


def stamp_of(*modules: str) -> Stamp:
    """A stamp of all files in the folders of some modules, given by their ``__file__``, and of the numerics that all kernels share."""
    folders = {Path(module).parent for module in modules}
    files = [file.stat() for folder in folders for file in folder.glob("*.py")]
    files += [file.stat() for file in _NUMERICS.rglob("*.py")]
    return max(file.st_mtime for file in files), sum(file.st_size for file in files)


def compiled(function: Function, stamp: Stamp | None = None, **options: Any) -> Function:
    """
    Compile with numba on the first call, cached on disk if a folder is writable.

    The cache is valid until the stamp changes, by default until a file in the folder of the outermost function does. Numba compiles
    again for read-only arrays and for constants passed between kernels, so callers pass copies and variables. Without numba the
    function is returned unchanged.
    """
    if INTERPRETED:
        _warn_interpreted()
        return function
    settings = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, **options}
    kernel = _kept(njit, function, settings)
    if stamp is None and not INNER.items() <= options.items():
        stamp = stamp_of(function.__code__.co_filename)
    if stamp is not None:
        _leave_out_older(kernel.stats.cache_path, stamp)
    return cast(Function, kernel)


def _kept(compiler: Callable[..., Any], function: Callable[..., Any], settings: dict[str, Any]) -> Any:
    """Apply a decorator of numba, with its cache if a folder is writable."""
    try:
        return compiler(cache=True, **settings)(function)
    except RuntimeError:  # neither __pycache__ nor a user cache is writable
        _unkept.set()
        return compiler(**settings)(function)


def uncounted(function: Function) -> Function:
    """Compile a function that makes no arrays."""
    return compiled(function, None, **UNCOUNTED)


def inner(function: Function) -> Function:
    """Compile a function that makes no arrays and that only kernels call, without slow wrappers for arguments from Python."""
    return compiled(function, None, **INNER, **UNCOUNTED)


class Addressed:
    """
    A function that kernels call by its address, compiled when that is first asked for; without options, one that makes no arrays.

    What kernels call by name is compiled into each of them and their callers, however large. By its address it is compiled once,
    but a call takes some 10 ns more, and the types of its arguments are not checked.
    """

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any] = UNCOUNTED) -> None:
        self.py_func, self._options = function, options
        self._compiled: Any = None

    def address(self, result: Any, *arguments: Any) -> Any:
        """The address, for a result and arguments of the types of these; the function itself where it is not compiled."""
        if INTERPRETED:
            return self.py_func
        if self._compiled is None:
            signature = typeof(result)(*map(typeof, arguments))
            settings = {"error_model": "numpy", **self._options}
            with event.trigger_event("numba:compile", {"dispatcher": self, "args": signature.args}):
                self._compiled = _kept(partial(cfunc, signature), self.py_func, settings)
        return self._compiled.address


def merged(function: Function) -> Function:
    """Compile a function as a part of its one caller: machine code is otherwise made again at every level of calls."""
    return compiled(function, None, inline="always", **INNER, **UNCOUNTED)


class Fused:
    """
    Decorators of kernels without arrays of their own, in which products and sums may be fused.

    Kernels of other files are compiled into them: the cache is valid until a file in the folders of `modules` changes.
    """

    def __init__(self, *modules: str) -> None:
        self._stamp = stamp_of(*modules)

    def compiled(self, function: Function, **options: Any) -> Function:
        """Compile on the first call."""
        return compiled(function, self._stamp, fastmath={"contract"}, **UNCOUNTED, **options)

    def inner(self, function: Function) -> Function:
        """Compile for other kernels only."""
        return self.compiled(function, **INNER)

    def inlined(self, function: Function) -> Function:
        """Compile into the callers, for short functions: a call with arrays takes longer than they do."""
        return self.compiled(function, forceinline=True, **INNER)

    def merged(self, function: Function) -> Function:
        """Compile as a part of the one caller, before it is optimized."""
        return self.compiled(function, inline="always", **INNER)


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


_SUBJECTS = {
    "interpretation.": "stress",
    "line.following.": "adhesion",
    "line.friction.": "friction",
    "line.memory.": "viscoelasticity",
    "line.motion.": "machines",
    "line.plane.": "friction in the plane",
    "line.plastic.": "bodies that yield",
    "line.programs.": "steps",
    "line.rebound.": "impacts on viscoelastic bodies",
    "line.rough_sliding.": "rough sliding",
    "line.soft.": "adhesion with memory",
    "mapping.": "equivalent profiles",
    "numerics.exponentials.": "viscoelasticity",
    "numerics.": "tables",
    "problem.profiles.": "smoothing splines",
    "problem.spectra.": "viscoelasticity",
    "solving.fits.": "fits",
    "solving.stepping.": "steps",
}
"""What kernels are for, by the beginnings of their names."""


def _described(name: str) -> str:
    """The description of a kernel for users."""
    subject = next((words for begin, words in _SUBJECTS.items() if name.startswith(begin)), None)
    return name if subject is None else f"numerical kernels of {subject}"


if INTERPRETED:

    def call(address: Any, result: Any, arguments: tuple[Any, ...]) -> Any:
        """Call what has an address; its result has the type of the one given."""
        return address(*arguments)

else:

    @intrinsic
    def call(context: Any, address: Any, result: Any, arguments: Any) -> Any:
        """Call what has an address; its result has the type of the one given."""
        signature = types.unliteral(result)(address, result, arguments)

        def lowered(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = [builder.extract_value(values[2], i) for i in range(len(arguments))]
            pointer = context.get_value_type(types.FunctionPrototype(signature.return_type, arguments.types))
            return builder.call(builder.inttoptr(values[0], pointer), given)

        return signature, lowered


class _CompileListener:
    """A listener of numba that says once that kernels of pymdr are being compiled, and how long that takes at most."""

    def __init__(self) -> None:
        self.depth = 0
        self.timer = threading.Timer(0.0, self.announce)
        self.announced = False

    def notify(self, event: Any) -> None:
        """Start or cancel the timer of the message; callees are compiled with their caller."""
        function = event.data["dispatcher"].py_func
        if not function.__module__.startswith("pymdr."):
            return
        self.depth += 1 if event.is_start else -1
        if event.is_start and self.depth == 1 and not self.announced:
            name = _described(f"{function.__module__.removeprefix('pymdr.')}.{function.__name__}")
            self.timer = threading.Timer(_PATIENCE, self.announce, (name,))
            self.timer.daemon = True
            self.timer.start()
        elif self.depth == 0:
            self.timer.cancel()

    def announce(self, name: str) -> None:
        """Warn that kernels are being compiled, for how long and how often."""
        self.announced = True
        kept = (
            "in every new process, because no cache folder is writable: set NUMBA_CACHE_DIR"
            if _unkept.is_set()
            else "once after an installation"
        )
        _log.warning("Compiling %s (up to 20 s in all, %s)", name, kept)


_listener = _CompileListener()
if event is not None:
    event.Listener.register(_CompileListener)
    event.register("numba:compile", _listener)
