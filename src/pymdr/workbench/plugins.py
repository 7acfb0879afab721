"""Python files that users name on the command line to register kinds of their own."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from pymdr.errors import FileError, ProblemError, PymdrError
from pymdr.presentation.files import named_file


def import_file(file: str | os.PathLike[str]) -> None:
    """
    Import a Python file that registers profiles, bodies, rheologies or laws of adhesion.

    Its folder is added to the end of ``sys.path``, so that processes for many contacts import the same module.

    Parameters
    ----------
    file : path
        Its name without ``.py`` is the name of the module.

    Examples
    --------
    >>> import_file("tip.toml")
    Traceback (most recent call last):
    pymdr.errors.FileError: --plugin tip.toml: a Python file is needed, such as quartic.py
    """
    source = Path(named_file(file, "read"))
    name = source.stem
    if source.suffix != ".py":
        raise FileError(f"--plugin {source}: a Python file is needed, such as quartic.py")
    if not name.isidentifier():
        raise FileError(
            f"--plugin {source}: {name!r} cannot be the name of a module; rename the file, for example to "
            f"{''.join(c if c.isalnum() else '_' for c in name).lstrip('0123456789') or 'plugin'}.py"
        )
    if not source.is_file():
        raise FileError(f"--plugin {source}: there is no such file; check the name")
    folder = str(source.resolve().parent)
    if folder not in sys.path:
        sys.path.append(folder)
    existing = find_spec(name)
    origin = existing.origin if existing is not None else None
    if origin is None or not Path(origin).exists() or not Path(origin).samefile(source):
        raise FileError(f"--plugin {source}: another module has the name {name!r}; rename the file")
    try:
        import_module(name)
    except Exception as error:  # whatever the user's file raises
        reason = str(error) if isinstance(error, PymdrError) else f"{type(error).__name__}: {error}"
        raise ProblemError(f"--plugin {source}{_line_of(error, origin)}: {reason}") from error


def _line_of(error: Exception, origin: str) -> str:
    """The last line of a file in the traceback of an error."""
    if isinstance(error, SyntaxError):
        return ""
    trace, line = error.__traceback__, None
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == origin:
            line = trace.tb_lineno
        trace = trace.tb_next
    return "" if line is None else f", line {line}"
