"""Problems as plain dictionaries."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.codec.tables import KIND_OF
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layer
from pymdr.problem.paths import History, LoadingPath, legs
from pymdr.problem.profiles import Function, Function2D
from pymdr.problem.values import Value


def encode(value: Any) -> Any:
    """
    A problem value as plain dictionaries, lists, numbers and texts.

    Examples
    --------
    >>> from pymdr.problem.profiles import Sphere
    >>> encode(Sphere("10 mm"))
    {'kind': 'sphere', 'radius': 0.01}
    """
    if isinstance(value, Contact):
        return {
            "profile": encode(value.profile),
            "body": encode(value.body),
            "counterbody": encode(value.counterbody),
            **({} if value.adhesion is None else {"adhesion": encode(value.adhesion)}),
            **({} if value.friction is None else {"friction": encode(value.friction)}),
        }
    if isinstance(value, History):
        return [encode(leg) for leg in value.legs]
    if isinstance(value, Function | Function2D):
        raise ProblemError(
            f"a {type(value).__name__} contains a callable, which cannot be written to a file; give samples instead"
        )
    if type(value) in KIND_OF:
        plain: dict[str, Any] = {"kind": KIND_OF[type(value)]}
        for f in fields(value):
            entry = getattr(value, f.name)
            if entry is not None:
                plain[f.name] = encode(entry)
        return plain
    if isinstance(value, Layer):
        return {"material": encode(value.material), "thickness": value.thickness}
    if isinstance(value, Value):
        name = type(value).__name__
        raise ProblemError(
            f"{name} is not registered for files; call pymdr.problem.codec.register({name.lower()!r}, {name})"
        )
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [encode(entry) for entry in value]
    return value


def encode_case(title: str, contact: Contact, path: LoadingPath) -> dict[str, Any]:
    """The inverse of :func:`~pymdr.problem.codec.decode_case`."""
    case = {**encode(contact), "path": [encode(leg) for leg in legs(path)]}
    return {"title": title, **case} if title else case
