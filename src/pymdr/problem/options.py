"""Options of functions that take many keywords: in their signatures; unknown ones are refused."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from pymdr.problem.naming import nearest

_Function = TypeVar("_Function", bound=Callable[..., Any])


def with_options(options: type | None = None) -> Callable[[_Function], _Function]:
    """
    Refuse unknown keywords of a function; the keys of a TypedDict, if one is given, are the options of its ``**keywords``.

    ``help`` and completion show them; any other keyword raises a TypeError that names the function, the nearest argument
    and all arguments.

    Examples
    --------
    >>> from typing import TypedDict
    >>> class Sizes(TypedDict, total=False):
    ...     width: float | None
    >>> @with_options(Sizes)
    ... def draw(**sizes): ...
    >>> draw(widht=1.0)
    Traceback (most recent call last):
    TypeError: draw() got an unexpected keyword argument 'widht'; write width= (arguments: width)
    """

    def decorated(function: _Function) -> _Function:
        own = inspect.signature(function)
        kept = [one for one in own.parameters.values() if one.kind is not one.VAR_KEYWORD]
        added = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=None if "None" in str(hint) else ...,
                annotation=hint,
            )
            for name, hint in ({} if options is None else _hints(options)).items()
        ]
        signature = own.replace(parameters=[*kept, *added])
        names = [name for name in signature.parameters if name != "self"]

        @wraps(function)
        def checked(*args: Any, **keywords: Any) -> Any:
            for name in keywords:
                if name not in signature.parameters:
                    near = nearest(name, names)
                    words = f"; write {near[0]}=" if near else ""
                    raise TypeError(
                        f"{function.__name__}() got an unexpected keyword argument {name!r}{words} (arguments: {', '.join(names)})"
                    )
            return function(*args, **keywords)

        checked.__signature__ = signature  # type: ignore[attr-defined]
        return cast(_Function, checked)

    return decorated


def _hints(options: type) -> dict[str, str]:
    """The texts of the annotations of a TypedDict."""
    return {
        name: getattr(hint, "__forward_arg__", str(hint)) for name, hint in options.__annotations__.items()
    }
