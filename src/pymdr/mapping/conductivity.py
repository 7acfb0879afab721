"""What a pair of bodies conducts: one number for the line, as E* is one for its springs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pymdr.problem.contact import Contact

Carrier = Literal["thermal_conductivity", "resistivity"]
"""The property of a body by which it conducts heat, or a current."""


@dataclass(frozen=True)
class Conductivity:
    """What a pair of bodies conducts."""

    value: float | None
    """Of the line, in W/(m K) or 1/(ohm m); None where it is not known."""
    why: str = ""
    """Why it is not, in words."""


def effective_conductivity(contact: Contact, carrier: Carrier) -> Conductivity:
    """
    Conductivity of the line, lambda_eff = 2 lambda_1 lambda_2/(lambda_1 + lambda_2) = 2/(rho_1 + rho_2).

    A disk of the radius a conducts 2 a lambda_eff.

    Parameters
    ----------
    contact : Contact
    carrier : str
        "thermal_conductivity" or "resistivity".

    Returns
    -------
    Conductivity
        In W/(m K), or in 1/(ohm m).

    Notes
    -----
    Holm (1967), Electric Contacts, section 3.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> copper = Elastic("120 GPa", 0.34, thermal_conductivity="390 W/(m K)")
    >>> effective_conductivity(Contact(Sphere("1 mm"), copper, copper), "thermal_conductivity").value
    390.0
    """
    bodies = {"body": contact.body, "counterbody": contact.counterbody}
    for name, body in bodies.items():
        if not body.homogeneous:
            return Conductivity(
                None,
                f"the {name} is not the same at every depth: how its conductivity changes with it is not known, and what "
                "conducts through a film has a kernel of its own",
            )
    for name, body in bodies.items():
        if getattr(body, carrier) is None:
            kind = type(body).__name__
            return Conductivity(
                None, f"the {name}, {kind}, has no {carrier}; give {kind}(..., {carrier}=...)"
            )
    one, other = (getattr(body, carrier) for body in bodies.values())
    resistances = (one, other) if carrier == "resistivity" else (1.0 / one, 1.0 / other)
    return Conductivity(2.0 / sum(resistances))


def is_carried(contact: Contact, carrier: Carrier) -> bool:
    """Whether one of the bodies says what it conducts."""
    return any(getattr(body, carrier) is not None for body in (contact.body, contact.counterbody))
