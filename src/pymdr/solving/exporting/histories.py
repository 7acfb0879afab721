"""What contacts remember in the headers of their laws: friction, adhesion, relaxation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import Claim
from pymdr.line.memory import RelaxingContacts
from pymdr.line.memory.modes import modes_of
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation.history_header import HistoryInC, SpringsInC, StackInC, TouchInC
from pymdr.presentation.memory_header import MemoryInC
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.solving.exporting.sources import Fold, Form
from pymdr.solving.moving import moving_of
from pymdr.solving.pulloff import PullOff
from pymdr.solving.stepping import Stepper, check_springs, plane_body

SPRINGS = 100
"""Springs of bodies with memory, unless their number is given."""
_WITH_MEMORY = ("normal_force", "contact_radius", "elastic_energy", "dissipated_energy")


@dataclass(frozen=True)
class Remembered:
    """A contact without what its header remembers, which a table describes, and the history."""

    table: Contact
    history: HistoryInC | None
    claims: dict[str, Claim]
    """Of quantities that the history gives, at the largest indentation."""
    note: str = ""


def remembered(contact: Contact, deepest: float, tangential: bool, springs: int | None) -> Remembered:
    """
    What a contact remembers up to an indentation in m, except the touch of adhesion.

    Parameters
    ----------
    tangential : bool
        Whether the header has friction.
    springs : int or None
        Number of springs in the plane, or with memory.

    Raises
    ------
    ProblemError
        If the contact has no memory of this kind.
    """
    if contact.is_viscoelastic:
        if tangential:
            raise ProblemError(
                "export_law: tangential=True: friction of bodies with memory is not in headers; leave it out for the normal force, or use "
                "Stepper"
            )
        return _relaxing(contact, deepest, SPRINGS if springs is None else springs)
    if springs is not None and not tangential:
        raise ProblemError(
            "export_law: springs are those of bodies with memory or of friction in the plane; give tangential=True too"
        )
    history = _friction_of(contact, deepest, springs) if tangential else None
    return Remembered(replace(contact, friction=None), history, {})


def touch_of(form: Form, pull_off: PullOff | None) -> TouchInC | None:
    """Whether bodies with JKR touch, which their header remembers."""
    if pull_off is None or not isinstance(form, Fold):
        return None
    return TouchInC(form.jump_in_loss, pull_off.dissipated_energy)


def _friction_of(contact: Contact, deepest: float, springs: int | None) -> StackInC | SpringsInC:
    """The constants of friction along a line, or in the plane."""
    friction = None if contact.friction is None else contact.friction.coefficient
    if friction is None or not 0.0 < friction < math.inf:
        raise ProblemError(
            "export_law: tangential=True: a finite coefficient of friction above 0 is needed; give Contact(..., friction=Coulomb(0.3))"
        )
    moduli = effective_moduli(contact.body, contact.counterbody)
    if springs is not None:
        labels, (per_force, per_shift) = plane_body(contact, deepest, springs)
        return SpringsInC(tuple(labels[1:].tolist()), float(per_force), float(per_shift))
    return StackInC(friction, moduli.tangential / moduli.normal)


def _relaxing(contact: Contact, deepest: float, springs: int) -> Remembered:
    """Springs with memory, and the contact of elastic bodies of the moduli that have not relaxed."""
    check_springs(springs, "export_law")
    alone = replace(contact, friction=None)
    moved = moving_of(alone, deepest, 1, springs).contacts
    assert isinstance(moved, RelaxingContacts)
    relaxation = moved.relaxation
    glassy = relaxation.equilibrium + float(relaxation.moduli.sum())
    modes, rows = modes_of(relaxation), moved.springs
    history = MemoryInC(
        relaxation.equilibrium,
        relaxation.viscosity,
        np.stack([rows.height, rows.stiffness, rows.centre, rows.outer]),
        np.stack([relaxation.moduli, relaxation.times]),
        np.stack([modes.rates, modes.reach]),
        modes.to_modes,
        modes.to_branches,
    )
    claims = Stepper(alone, deepest, springs=springs).claims
    # E* = 2 G/(1 - nu) = E/(1 - nu^2)
    at_once = replace(alone, body=Elastic(0.75 * glassy, 0.5), counterbody=Rigid())
    return Remembered(
        at_once,
        history,
        {name: claims[name] for name in _WITH_MEMORY if name in claims},
        f"the table is a sudden indentation of bodies at rest, of the modulus E* = {glassy:.6g} Pa that has not relaxed; the header "
        f"follows {rows.position.size} springs with memory",
    )
