"""Parameters of a contact by their dotted names, such as "body.young" or "profile.parts[0].radius"."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.values import OptionalArrayField, SIField, Value
from pymdr.units import shown, to_si

_STEP = re.compile(r"([A-Za-z_]\w*)((?:\[\d+\])*)\Z")
_SHOWN = 12
"""Entries of an array or a tuple that are named in a message."""


class Parameter(NamedTuple):
    """A number in a contact."""

    name: str
    value: float
    """In the unit."""
    unit: str
    """The SI unit."""


def parameters_of(contact: Contact) -> tuple[Parameter, ...]:
    """
    Every number that a contact is made of.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    tuple of Parameter
        In the order of its fields; entries of arrays are numbered from 0, row after row.

    Raises
    ------
    ProblemError
        If it is no contact.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> [p.name for p in parameters_of(Contact(Sphere("1 mm"), Elastic("1 GPa", 0.3)))]
    ['profile.radius', 'body.young', 'body.poisson']
    """
    return tuple(_numbers(_as_contact(contact), ""))


def parameter_of(contact: Contact, name: str) -> Parameter:
    """
    One number of a contact.

    Parameters
    ----------
    contact : Contact
    name : str
        Its dotted name.

    Returns
    -------
    Parameter

    Raises
    ------
    ProblemError
        If the contact has no number of that name.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> parameter_of(Contact(Sphere("1 mm"), Elastic("1 GPa", 0.3)), "body.young").value
    1000000000.0
    """
    found = {parameter.name: parameter for parameter in parameters_of(contact)}
    if name not in found:
        raise _unknown(contact, name)
    return found[name]


def with_parameters(contact: Contact, values: Mapping[str, Any]) -> Contact:
    """
    A contact with other values of some of its parameters.

    Parameters
    ----------
    contact : Contact
    values : mapping of str to quantity or value
        New values by dotted names: quantities for numbers, and problem values, such as a profile, for whole parts.

    Returns
    -------
    Contact

    Raises
    ------
    ProblemError
        If it is no contact, or has no part of a name, a whole part is given after something in it, or a value is beyond its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> ball = Contact(Sphere("1 mm"), Elastic("1 GPa", 0.3))
    >>> with_parameters(ball, {"profile.radius": "2 mm", "body.young": 2e9})
    Contact(profile=Sphere(radius=0.002), body=Elastic(young=2000000000.0, poisson=0.3), counterbody=Rigid(), adhesion=None, friction=None)
    """
    _as_contact(contact)
    if not isinstance(values, Mapping):
        raise ProblemError(
            f"parameters: {shown(values)}; names with values are needed, such as {{'body.young': '2 MPa'}}"
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


def _as_contact(contact: Any) -> Contact:
    if not isinstance(contact, Contact):
        raise ProblemError(f"parameters: {shown(contact)} is not a Contact; write Contact(profile, body)")
    return contact


def _refuse_replaced(names: list[str]) -> None:
    """Refuse a whole part that is given after something in it, which would be lost."""
    for i, whole in enumerate(names):
        for part in names[:i]:
            if part.startswith((f"{whole}.", f"{whole}[")):
                raise ProblemError(
                    f"parameters: {whole!r} takes the place of what {part!r} has changed; give {whole!r} before it"
                )


class _Change(NamedTuple):
    """A part that is to have another value, by the steps that lead to it."""

    steps: list[str | int]
    value: Any
    name: str


def _changed(part: Any, changes: Sequence[_Change], contact: Contact) -> Any:
    """A part with all its changes at once: each part that holds some is made, and looked at, once."""
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
        return tuple(_changed(one, inner.get(i, ()), contact) for i, one in enumerate(part))
    return replace(
        part, **{str(step): _changed(getattr(part, str(step)), own, contact) for step, own in inner.items()}
    )


def _refuse_absent(part: Any, step: str | int, contact: Contact, name: str) -> None:
    if isinstance(step, str):
        there = isinstance(part, Value) and step in {f.name for f in fields(part)}
    else:
        size = part.size if isinstance(part, np.ndarray) else len(part) if isinstance(part, tuple) else 0
        there = step < size
    if not there:
        raise _unknown(contact, name)


def _unknown(contact: Contact, name: str) -> ProblemError:
    parts = [f.name for f in fields(contact)]
    numbers = [parameter.name for parameter in parameters_of(contact)]
    more = f" and {len(numbers) - _SHOWN} more" if len(numbers) > _SHOWN else ""
    return ProblemError(
        f"parameter {shown(name)}: this contact has the numbers {', '.join(numbers[:_SHOWN])}{more}, and the parts "
        f"{', '.join(parts)}"
    )


def _numbers(value: Value, prefix: str) -> Iterator[Parameter]:
    for f in fields(value):
        name, held = f"{prefix}{f.name}", getattr(value, f.name)
        unit = inspect.getattr_static(type(value), f.name, None)
        if isinstance(held, Value):
            yield from _numbers(held, f"{name}.")
        elif isinstance(held, tuple):
            for i, part in enumerate(held):
                if isinstance(part, Value):
                    yield from _numbers(part, f"{name}[{i}].")
        elif isinstance(unit, SIField) and held is not None:
            yield Parameter(name, held, unit.unit)
        elif isinstance(unit, OptionalArrayField) and held is not None:
            for i, entry in enumerate(held.ravel()):
                yield Parameter(f"{name}[{i}]", float(entry), unit.unit)
