"""Machines from plain dictionaries."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pymdr.errors import CaseError, PymdrError, errors_of_case
from pymdr.problem.codec.cases import decode_contact
from pymdr.problem.codec.outputs import OUTPUTS
from pymdr.problem.codec.tables import MACHINE_BODIES, MACHINE_LINKS
from pymdr.problem.contact import Contact
from pymdr.problem.machines import Machine
from pymdr.problem.naming import nearest
from pymdr.units import shown

_KEYS = ("duration", "steps", "accuracy", "bodies", "links")
_WITHOUT = ("path", "surface", "solve", *OUTPUTS)
"""Tables of other cases, which a motion would leave unread."""


@dataclass(frozen=True)
class MachineCase:
    """The contents of a case of a machine."""

    title: str
    machine: Machine
    options: Mapping[str, Any]
    """Duration, and as far as they are given steps and accuracy."""


def decode_machine(plain: Mapping[str, Any]) -> MachineCase:
    """
    A machine from plain dictionaries, all joints of which are the contact of the case.

    Parameters
    ----------
    plain : mapping
        With the table ``machine`` and the tables of a contact.

    Examples
    --------
    >>> contact = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": {"kind": "elastic", "young": "1 GPa", "poisson": 0.3}}
    >>> machine = {"duration": "1 s", "bodies": [{"kind": "mas", "name": "a"}]}
    >>> decode_machine({**contact, "machine": machine})
    Traceback (most recent call last):
        ...
    pymdr.errors.CaseError: [machine.bodies 1] kind = 'mas': unknown kind; did you mean 'mass'?
    """
    table = plain.get("machine")
    if not isinstance(table, Mapping):
        raise CaseError("table [machine] is missing; give duration, bodies and links")
    unread = next((key for key in _WITHOUT if key in plain), None)
    if unread is not None:
        written = "[[path]]" if unread == "path" else f"[{unread}]"
        raise CaseError(
            f"{written}: beside [machine] it is not read, because bodies, springs and forces move the contact; leave it out, or leave "
            "[machine] out and use pymdr run"
        )
    unknown = next((key for key in table if key not in _KEYS), None)
    if unknown is not None:
        raise CaseError(
            f"[machine] {unknown} = {shown(table[unknown])}: unknown key; known are {', '.join(_KEYS)}"
        )
    if "duration" not in table:
        raise CaseError("[machine] duration is missing; give a time, such as '1 s'")
    title, contact = decode_contact({key: value for key, value in plain.items() if key != "machine"})
    bodies = _entries(table, "bodies", MACHINE_BODIES)
    links = _entries(table, "links", MACHINE_LINKS, contact)
    with errors_of_case("[machine]"):
        machine = Machine(bodies, links)
    options = {key: table[key] for key in ("duration", "steps", "accuracy") if key in table}
    return MachineCase(title, machine, options)


def _entries(
    table: Mapping[str, Any], key: str, kinds: Mapping[str, type], contact: Contact | None = None
) -> list[Any]:
    """Bodies or links of a machine."""
    entries = table.get(key, [])
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise CaseError(f"[machine] {key} = {shown(entries)}: give one [[machine.{key}]] for each")
    return [_entry(f"machine.{key} {i}", entry, kinds, contact) for i, entry in enumerate(entries, 1)]


def _entry(where: str, entry: Mapping[str, Any], kinds: Mapping[str, type], contact: Contact | None) -> Any:
    kind = entry.get("kind")
    if not isinstance(kind, str) or kind not in kinds:
        raise CaseError(f"[{where}] kind = {shown(kind)}: unknown kind; {_known(kind, list(kinds))}")
    arguments = {key: value for key, value in entry.items() if key != "kind"}
    if kind == "joint":
        if "contact" in arguments:
            raise CaseError(f"[{where}] contact: unknown key; all joints are the contact of the case")
        arguments["contact"] = contact
    known = inspect.signature(kinds[kind]).parameters
    for key in arguments:
        if key not in known:
            words = _known(key, [name for name in known if name != "contact"])
            raise CaseError(f"[{where}] {key} = {shown(entry[key])}: unknown key; {words}")
    for name, value in known.items():
        if value.default is value.empty and name not in arguments:
            raise CaseError(f"[{where}] key {name!r} is missing")
    try:
        return kinds[kind](**arguments)
    except (PymdrError, TypeError) as error:
        raise CaseError(f"[{where}] {error}") from error


def _known(name: object, known: list[str]) -> str:
    near = nearest(name, known) if isinstance(name, str) else []
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
