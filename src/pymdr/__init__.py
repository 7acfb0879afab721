"""The Method of Dimensionality Reduction (MDR) in contact mechanics.

Public names stand in ``__init__.pyi`` and are imported when they are first used, so that importing pymdr does no work.
"""

from types import FunctionType as _Function
from typing import Any as _Any

import lazy_loader

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
_functions: dict[str, _Any] = {}


def __getattr__(name: str) -> _Any:
    """A public name; functions refuse unknown arguments, and pickle by this name."""
    value = _imported(name)
    if isinstance(value, _Function):
        from pymdr.problem.options import with_known_arguments

        known = with_known_arguments(value)
        known.__module__, known.__qualname__ = __name__, name
        # threads that import a name at once take the same function
        value = globals()[name] = _functions.setdefault(name, known)
    return value
