"""Parameters of a contact by dotted names, such as "body.young" or "profile.parts[0].radius"."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.values import OptionalArrayField, SIField, Value
from pymdr.units import shown, to_si

_STEP = re.compile(r"([A-Za-z_]\w*)((?:\[\d+\])*)\Z")
_SHOWN = 12
"""Largest number of parameters listed in a message."""


class Parameter(NamedTuple):
    """A number in a contact."""

    name: str
    value: float
    """In SI units."""
    unit: str
    """The SI unit."""


def parameters_of(contact: Contact) -> tuple[Parameter, ...]:
    """
    All numeric parameters of a contact.

    Parameters
    ----------
    contact : Contact
        The contact with the parameters.

    Returns
    -------
    tuple of Parameter
        In the order of the fields; entries of arrays are numbered from 0, row by row.

    Raises
    ------
    ProblemError
        If it is not a contact.

    Examples
    --------
    >>> import pymdr as mdr
    >>> [p.name for p in mdr.parameters_of(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)))]
    ['profile.radius', 'body.young', 'body.poisson']
    """
    return tuple(_numbers(require_contact(contact), ""))


def parameter_of(contact: Contact, name: str) -> Parameter:
    """
    One parameter of a contact.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> parameter_of(Contact(Sphere("1 mm"), Elastic("1 GPa", 0.3)), "body.young").value
    1000000000.0
    """
    parameters = {parameter.name: parameter for parameter in parameters_of(contact)}
    if name not in parameters:
        raise _unknown(contact, name)
    return parameters[name]


def with_parameters(contact: Contact, values: Mapping[str, Any]) -> Contact:
    """
    A contact with some parameters changed.

    Parameters
    ----------
    contact : Contact
        The contact with the parameters.
    values : mapping of str to quantity or value
        New values by dotted name: quantities for numbers, problem values such as a profile for parts.

    Returns
    -------
    Contact
        A new contact; the given one is not changed.

    Raises
    ------
    ProblemError
        If it is not a contact, a name is unknown, a part is given after a parameter in it, or a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3))
    >>> mdr.with_parameters(ball, {"profile.radius": "2 mm", "body.young": 2e9})
    Contact(profile=Sphere(radius=0.002), body=Elastic(young=2000000000.0, poisson=0.3), counterbody=Rigid(), adhesion=None, friction=None)
    """
    require_contact(contact)
    if not isinstance(values, Mapping):
        raise ProblemError(
            f"{shown(values)} is not a mapping of names to values such as {{'body.young': '2 MPa'}}"
        )
    _refuse_replaced([str(name) for name in values])
    changes = []
    for name, value in values.items():
        steps: list[str | int] = []
        for part in str(name).split("."):
            match = _STEP.match(part)
            if match is None:
                raise ProblemError(
                    f"parameter {shown(name)}: a dotted name such as 'body.young' or 'profile.parts[0].radius' is needed"
                )
            steps += [match[1], *(int(index) for index in re.findall(r"\d+", match[2]))]
        changes.append(_Change(steps, value, name))
    changed = _changed(contact, changes, contact)
    assert isinstance(changed, Contact)
    return changed


def _refuse_replaced(names: list[str]) -> None:
    """Refuse a part that is given after a parameter in it, whose change would be lost."""
    for i, whole in enumerate(names):
        for part in names[:i]:
            if part.startswith((f"{whole}.", f"{whole}[")):
                raise ProblemError(f"{whole!r} would discard the change of {part!r}; give {whole!r} first")


class _Change(NamedTuple):
    """A new value, with the steps that lead to its place."""

    steps: list[str | int]
    value: Any
    name: str


def _changed(part: Any, changes: Sequence[_Change], contact: Contact) -> Any:
    """A part with all its changes; each nested part is rebuilt once."""
    inner: dict[str | int, list[_Change]] = {}
    for steps, value, name in changes:
        if not steps:
            part = value
        else:
            inner.setdefault(steps[0], []).append(_Change(steps[1:], value, name))
    if not inner:
        return part
    for step, own in inner.items():
        _refuse_absent(part, step, contact, own[0].name)
    if isinstance(part, np.ndarray):
        entries = part.copy()
        for step, own in inner.items():
            for _, value, name in own:
                entries.flat[int(step)] = to_si(value, parameter_of(contact, name).unit, name=name)
        return entries
    if isinstance(part, tuple):
        return tuple(_changed(child, inner.get(i, ()), contact) for i, child in enumerate(part))
    return replace(
        part, **{str(step): _changed(getattr(part, str(step)), own, contact) for step, own in inner.items()}
    )


def _refuse_absent(part: Any, step: str | int, contact: Contact, name: str) -> None:
    if isinstance(step, str):
        exists = isinstance(part, Value) and step in {f.name for f in fields(part)}
    else:
        size = part.size if isinstance(part, np.ndarray) else len(part) if isinstance(part, tuple) else 0
        exists = step < size
    if not exists:
        raise _unknown(contact, name)


def _unknown(contact: Contact, name: str) -> ProblemError:
    parts = [f.name for f in fields(contact)]
    numbers = [parameter.name for parameter in parameters_of(contact)]
    more = f" and {len(numbers) - _SHOWN} more" if len(numbers) > _SHOWN else ""
    return ProblemError(
        f"parameter {shown(name)}: unknown; this contact has the parameters {', '.join(numbers[:_SHOWN])}{more}, and the parts "
        f"{', '.join(parts)}"
    )


def _numbers(value: Value, prefix: str) -> Iterator[Parameter]:
    for f in fields(value):
        name, entry = f"{prefix}{f.name}", getattr(value, f.name)
        unit = inspect.getattr_static(type(value), f.name, None)
        if isinstance(entry, Value):
            yield from _numbers(entry, f"{name}.")
        elif isinstance(entry, tuple):
            for i, part in enumerate(entry):
                if isinstance(part, Value):
                    yield from _numbers(part, f"{name}[{i}].")
        elif isinstance(unit, SIField) and entry is not None:
            yield Parameter(name, entry, unit.unit)
        elif isinstance(unit, OptionalArrayField) and entry is not None:
            for i, number in enumerate(entry.ravel()):
                yield Parameter(f"{name}[{i}]", float(number), unit.unit)
