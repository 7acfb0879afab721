"""Machines from plain dictionaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymdr.errors import CaseError, PymdrError
from pymdr.problem.codec.cases import build_all, build_contact
from pymdr.problem.codec.complaints import Place, refuse_invalid
from pymdr.problem.codec.models import machine_adapter
from pymdr.problem.codec.outputs import OUTPUTS
from pymdr.problem.codec.registering import import_kinds
from pymdr.problem.machines import Body, Link, Machine

_MOVED = "beside [machine] it is not read, because bodies, springs and forces move the contact; leave it out, or leave [machine] out and use pymdr run"
_UNREAD: dict[Place, str] = {
    **{(name,): _MOVED for name in ("path", "surface", "solve", *OUTPUTS)},
    ("adhesion",): "beside [machine] adhesive contacts are not available; leave it out",
    ("machine", "links", "contact"): "all joints are the contact of the case; leave it out",
}
"""Keys that other cases or a machine in Python have, and why a case of a machine has not."""


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
    if "machine" not in plain:
        raise CaseError("table [machine] is missing; give duration, bodies and links")
    import_kinds(plain)
    refuse_invalid(plain, machine_adapter(), _UNREAD)
    table = plain["machine"]
    contact, bodies = build_contact(plain, _numbered("bodies", table["bodies"]))
    # all joints are the contact of the case
    links = [
        {**link, "contact": contact} if link["kind"] == "joint" else link for link in table.get("links", ())
    ]
    built = build_all(_numbered("links", links))
    _machine("machine", bodies)
    for place, link in built.items():
        _machine(place, bodies, [link])
    machine = _machine("machine", bodies, list(built.values()))
    options = {key: table[key] for key in ("duration", "steps", "accuracy") if key in table}
    return MachineCase(str(plain.get("title", "")), machine, options)


def _numbered(key: str, entries: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Bodies or links by their places."""
    return {f"machine.{key} {i}": entry for i, entry in enumerate(entries, 1)}


def _machine(place: str, bodies: Sequence[Body], links: Sequence[Link] = ()) -> Machine:
    """A machine whose errors belong to a place of the case."""
    try:
        return Machine(bodies, links)
    except PymdrError as error:
        raise CaseError(f"[{place}] {error}") from error
