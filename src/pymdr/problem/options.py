"""Arguments of public functions and constructors: errors name the nearest or the missing one; options are in the signatures."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from types import FunctionType
from typing import Any, TypeVar, cast

from pymdr.problem.naming import nearest

_Function = TypeVar("_Function", bound=Callable[..., Any])


def with_options(options: type, of: Callable[..., Any] | None = None) -> Callable[[_Function], _Function]:
    """
    Show the keys of a TypedDict in the signature of a function in place of its ``**keywords``, for help and completion.

    Their defaults are those of the function `of`, else None.
    """
    defaults = inspect.signature(of).parameters if of else {}

    def documented(function: _Function) -> _Function:
        own = inspect.signature(function)
        kept = [one for one in own.parameters.values() if one.kind is not one.VAR_KEYWORD]
        added = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=defaults[name].default if of else None,
                annotation=hint,
            )
            for name, hint in _hints(options).items()
        ]
        function.__signature__ = own.replace(parameters=[*kept, *added])  # type: ignore[attr-defined]
        return function

    return documented


def with_known_arguments(function: _Function) -> _Function:
    """
    The function, which refuses unknown and missing arguments with a TypeError that names them, the nearest one and all.

    All functions of the public face and all methods of :class:`Checked` are such.

    Examples
    --------
    >>> @with_known_arguments
    ... def draw(width=None): ...
    >>> draw(widht=1.0)
    Traceback (most recent call last):
    TypeError: draw() got an unexpected keyword argument 'widht'; write width= (arguments: width)
    """
    names = _names(function)
    if names is None:
        return function
    title = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]

    @wraps(function)
    def known(*args: Any, **keywords: Any) -> Any:
        if not keywords.keys() <= names.keys():
            refuse_unknown(title, keywords, [name for name in names if name not in ("self", "cls")])
        try:
            return function(*args, **keywords)
        except TypeError:
            # the examples of a constructor are those of its class
            is_constructor = function.__name__ == "__init__"
            described, given = (type(args[0]), args[1:]) if is_constructor else (function, args)
            refuse_missing(title, described, given, keywords)
            raise

    return cast(_Function, known)


def _names(function: Any) -> dict[str, None] | None:
    """The arguments of a function in order, without the time that a signature takes; None if it takes any keywords."""
    if hasattr(function, "__signature__"):
        return dict.fromkeys(function.__signature__.parameters)
    code = inspect.unwrap(function).__code__
    if code.co_flags & inspect.CO_VARKEYWORDS:
        return None
    return dict.fromkeys(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])


def refuse_unknown(title: str, keywords: Iterable[str], names: Sequence[str]) -> None:
    """Raise a TypeError for the first keyword that is no name of an argument, with the nearest one."""
    for name in keywords:
        if name not in names:
            near = nearest(name, names)
            words = f"; write {near[0]}=" if near else ""
            raise TypeError(
                f"{title}() got an unexpected keyword argument {name!r}{words} (arguments: {', '.join(names)})"
            ) from None


def refuse_missing(
    title: str,
    called: Callable[..., Any],
    args: Sequence[Any],
    keywords: Mapping[str, Any],
    unit_of: Callable[[str], str] = lambda name: "",
) -> None:
    """Raise a TypeError that names the missing arguments, if there are any, with their units and a call from the docstring."""
    parameters = inspect.signature(called).parameters
    missing = [
        f"{name} in {unit}" if (unit := unit_of(name)) else name
        for i, (name, one) in enumerate(parameters.items())
        if one.default is one.empty
        and (i >= len(args) or one.kind is one.KEYWORD_ONLY)
        and name not in keywords
        and one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)
    ]
    if missing:
        *others, last = missing
        words = f"{', '.join(others)} and {last}" if others else last
        names = ", ".join(name for name in parameters if name not in ("self", "cls"))
        call = _call(title, called.__doc__ or "")
        raise TypeError(
            f"{title}() needs {words} (arguments: {names})" + (f"; for example {call}" if call else "")
        ) from None


def _call(title: str, doc: str) -> str:
    """The first call of a function or method in its examples."""
    prompts = (line.strip()[4:] for line in doc.splitlines() if line.lstrip().startswith((">>> ", "... ")))
    code = "\n".join(prompts)
    start = re.search(rf"\w+(?:\.\w+)*\.{title}\(", code)
    first = start.start() if start else len(code)
    depth = 0
    for i in range(first, len(code)):
        depth += (code[i] == "(") - (code[i] == ")")
        if depth == 0 and code[i] == ")":
            line = re.sub(r"\s+", " ", code[first : i + 1])
            return line.replace("( ", "(").replace(", )", ")").replace(" )", ")")
    return ""


class Checked:
    """Base of classes whose public methods refuse unknown and missing arguments."""

    def __init_subclass__(cls) -> None:
        """Wrap the public methods that the class adds."""
        super().__init_subclass__()
        for name, entry in list(vars(cls).items()):
            if name.startswith("_"):
                continue
            if isinstance(entry, FunctionType):
                setattr(cls, name, with_known_arguments(entry))
            elif isinstance(entry, classmethod | staticmethod):
                setattr(cls, name, type(entry)(with_known_arguments(entry.__func__)))


def _hints(options: type) -> dict[str, str]:
    """The texts of the annotations of a TypedDict."""
    return {
        name: getattr(hint, "__forward_arg__", str(hint)) for name, hint in options.__annotations__.items()
    }
