"""What contacts remember in the headers of their laws: friction, adhesion, relaxation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import Claim, approximated
from pymdr.line.following import layout as at
from pymdr.line.memory import RelaxingContacts, ShearedContacts
from pymdr.line.memory.modes import modes_of
from pymdr.mapping.moduli import effective_moduli
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.panels import nodes, to_coefficients
from pymdr.numerics.table import FIRST_TERM, KEY, START, WIDTH
from pymdr.presentation.history_header import HistoryInC, SpringsInC, StackInC, TouchInC
from pymdr.presentation.memory_header import MemoryInC
from pymdr.presentation.resting_header import CurveInC, RestingInC
from pymdr.presentation.sheared_header import ShearedInC
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.materials import Elastic, Rigid
from pymdr.solving.exporting.sources import Fold, Form
from pymdr.solving.moving import moving_of, resting_of
from pymdr.solving.pulloff import PullOff
from pymdr.solving.springs_error import errors_of_parts
from pymdr.solving.stepping import check_springs, claims_of_steps, plane_body
from pymdr.units import FloatArray

SPRINGS = 100
"""Springs of bodies with memory, unless their number is given."""
PARTS = 16
"""Equal parts of a step with memory and friction, of which the first is divided further."""
_SHEARED = ("tangential_force", "stored_tangential_energy")
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
    """What a contact remembers up to an indentation in m, except the touch of adhesion."""
    if contact.is_viscoelastic:
        return _relaxing(contact, deepest, SPRINGS if springs is None else springs, tangential)
    if springs is not None and not tangential:
        raise ProblemError(
            "springs= is for bodies with memory and for friction in the plane; give tangential=True with it, or leave it out"
        )
    if contact.adhesion is not None and contact.adhesion.has_hysteresis and not tangential:
        return _resting(contact, deepest)
    history = _friction_of(contact, deepest, springs) if tangential else None
    return Remembered(replace(contact, friction=None), history, {})


def touch_of(form: Form, pull_off: PullOff | None) -> TouchInC | None:
    """Whether bodies with JKR touch, which their header remembers."""
    if pull_off is None or not isinstance(form, Fold):
        return None
    return TouchInC(form.jump_in_loss, pull_off.dissipated_energy)


def _coefficient(contact: Contact, in_springs: bool) -> float:
    """The coefficient of friction, above 0; finite except for elastic bodies along a line."""
    friction = None if contact.friction is None else contact.friction.coefficient
    if friction is None or not friction > 0.0:
        raise ProblemError(
            "tangential=True: a coefficient of friction above 0 is needed; give Contact(..., friction=Coulomb(0.3))"
        )
    if friction == math.inf and in_springs:
        raise ProblemError(
            "tangential=True: springs in the plane or with memory need a finite coefficient of friction in headers; give a large one, "
            "such as Coulomb(1e6), or leave springs out"
        )
    return friction


def _friction_of(contact: Contact, deepest: float, springs: int | None) -> StackInC | SpringsInC:
    """The constants of friction along a line, or in the plane."""
    friction = _coefficient(contact, springs is not None)
    moduli = effective_moduli(contact.body, contact.counterbody)
    if springs is not None:
        labels, (per_force, per_shift) = plane_body(contact, deepest, springs)
        return SpringsInC(tuple(labels[1:].tolist()), float(per_force), float(per_shift))
    return StackInC(friction, moduli.tangential / moduli.normal)


def _relaxing(contact: Contact, deepest: float, springs: int, tangential: bool) -> Remembered:
    """Springs with memory, and the contact of elastic bodies of the moduli that have not relaxed."""
    check_springs(springs, "export_law")
    alone = replace(contact, friction=None)
    friction = _coefficient(contact, True) if tangential else 0.0
    own = contact if tangential else alone
    moved, path = moving_of(own, deepest, 1, springs)
    normal = moved.normal if isinstance(moved, ShearedContacts) else moved
    assert isinstance(normal, RelaxingContacts)
    relaxation, rows = normal.relaxation, normal.springs
    glassy = relaxation.equilibrium + float(relaxation.moduli.sum())
    table = np.stack([rows.height, rows.stiffness, rows.centre, rows.outer])
    pressed = _springs_in_c(relaxation, table)
    history: HistoryInC = pressed
    names: tuple[str, ...] = _WITH_MEMORY
    claims = claims_of_steps(own, path, deepest, springs, moved)
    if isinstance(moved, ShearedContacts):
        if relaxation.viscosity > 0.0:
            raise ProblemError(
                "tangential=True: a parallel dashpot with friction is not in headers; give a rheology that has a sudden modulus, or "
                "use Stepper"
            )
        history = ShearedInC(pressed, _springs_in_c(moved.relaxation, table), friction, PARTS)
        names = (*names, *_SHEARED)
        missed = errors_of_parts(own, deepest, PARTS)
        for name in (*_SHEARED, "dissipated_energy"):
            remark = (
                f"; a step has {PARTS} parts, the first of them divided further down to the shortest relaxation time; in random motions the error "
                f"of these parts is at most {missed[name]:.1e} of the largest value, in other motions it may be larger"
            )
            claims |= approximated({name: claims[name]}, remark, missed[name])
    # E* = 2 G/(1 - nu) = E/(1 - nu^2)
    at_once = replace(alone, body=Elastic(0.75 * glassy, 0.5), counterbody=Rigid())
    return Remembered(
        at_once,
        history,
        {name: claims[name] for name in names if name in claims},
        f"the table is for a sudden indentation of bodies at rest (unrelaxed modulus E* = {glassy:.6g} Pa); the header "
        f"follows {rows.position.size} springs with memory",
    )


def _springs_in_c(relaxation: Relaxation, rows: FloatArray) -> MemoryInC:
    """Springs of one relaxation."""
    modes = modes_of(relaxation)
    return MemoryInC(
        relaxation.equilibrium,
        relaxation.viscosity,
        rows,
        np.stack([relaxation.moduli, relaxation.times]),
        np.stack([modes.rates, modes.participation]),
        modes.to_modes,
        modes.to_branches,
    )


def _resting(contact: Contact, deepest: float) -> Remembered:
    """The curves of an edge that advances and of one that recedes, and the contact of an edge that advances."""
    moved, path, lines = resting_of(contact, deepest, 1)
    ahead, back, edge = moved.both
    if ahead[0, at.BRANCHES] != 2 or back[0, at.BRANCHES] != 2:
        raise ProblemError(
            "the contact jumps while its edge moves, which headers of two works do not have; use Stepper, or a smoother profile"
        )
    works, receding = lines.works, lines.receding.equilibria
    rims = [
        float(line.equilibria.states(np.array([lines.rim])).indentation[0])
        if lines.rim < math.inf
        else math.inf
        for line in (lines.advancing, lines.receding)
    ]
    free, pull_off = ahead[2], receding.states(back[1, [at.BOTTOM]])
    last = float(back[1, at.LOW])
    stable = last
    if ahead[1, at.BOTTOM] < back[1, at.BOTTOM]:
        stable = float(lines.advancing.equilibria.states(back[1, [at.BOTTOM]]).indentation[0])

    def energy(s: FloatArray) -> FloatArray:
        return np.add(*receding.energies(np.minimum(s, lines.rim)))

    history = RestingInC(
        CurveInC(_cells_of(ahead, energy), 5, rims[0], float(free[at.UP_LOSS])),
        CurveInC(_cells_of(back), 4, rims[1], float(back[1, at.DOWN_LOSS])),
        touch=float(np.nextafter(free[at.HIGH], math.inf)),
        pull_off=(last, float(edge[at.LEAST]), float(pull_off.normal_force[0])),
        stable_from=stable,
        per_area=float(edge[at.PER_AREA]),
    )
    claims = claims_of_steps(contact, path, deepest, None)
    return Remembered(
        replace(contact, adhesion=JKR(works.advancing)),
        history,
        {"dissipated_energy": claims["dissipated_energy"]},
        f"the table follows an edge that advances, at {works.advancing:.6g} J/m^2; the header follows the edge, which recedes at "
        f"{works.receding:.6g} J/m^2 and rests in between",
    )


def _cells_of(rows: FloatArray, further: Callable[[FloatArray], FloatArray] | None = None) -> FloatArray:
    """The cells of a curve with one branch as a header reads them, with a further function of the parameter."""
    first, cells, terms = 3, rows[int(rows[0, at.CELLS]) :], int(rows[0, at.TERMS])
    segment = cells[:, KEY].astype(int)
    low, high = rows[first + segment, at.SEGMENT_LOW], rows[first + segment, at.SEGMENT_HIGH]
    v, width = cells[:, START], cells[:, WIDTH]
    begin = low + (high - low) * v**2 / (v**2 + (1.0 - v) ** 2)
    series = cells[:, FIRST_TERM : FIRST_TERM + (at.OTHER + 1) * terms].reshape(-1, at.OTHER + 1, terms)
    columns = [series[:, each] for each in (at.FORCE, at.RADIUS, at.STIFFNESS, at.OTHER)]
    if further is not None:
        parameters = np.polynomial.chebyshev.chebval(2.0 * nodes(terms) - 1.0, series[:, at.PARAMETER].T)
        values = further(np.asarray(parameters, dtype=float).ravel()).reshape(parameters.shape)
        columns.append(values @ to_coefficients(terms).T)
    return np.column_stack([begin, low, high, v, width, *columns])
