"""A contact that other programs move, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.traction import curves_down_to
from pymdr.interpretation.validity import Claim
from pymdr.line.foundation import states_at_depth
from pymdr.line.friction import Ending, StackArrays, Stacks, virgin_state
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.paths import indent, ramp
from pymdr.problem.profiles import Shape
from pymdr.problem.values import within_range
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.reach import map_to_springs, refuse_unreachable
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_CLAIMED = (
    "normal_force",
    "tangential_force",
    "contact_radius",
    "stick_radius",
    "elastic_energy",
    "stored_tangential_energy",
    "dissipated_energy",
)


class Forces(NamedTuple):
    """Forces on the contact after a step, floats for one contact and arrays for several."""

    normal: Any
    """F_N in N, which presses the bodies together."""
    tangential: Any
    """F_x in N, which resists the shift."""


@dataclass(frozen=True, eq=False)
class StepperState:
    """All that the contacts of a :class:`Stepper` remember; it can be pickled."""

    contact: Contact
    max_indentation: float
    """In m."""
    arrays: StackArrays
    """Stacks of turning points, now and before the last step."""
    undoable: bool
    """Whether the last step can be taken back."""


class Stepper:
    """
    One contact, or many alike, whose motion another program gives step by step: with the same numbers as :func:`solve`.

    The indentation and the shift go straight to the values of a step. The memory of friction is the stack of its turning points,
    so that a step costs the same after any history. Values are floats in SI units, without units as texts.

    Parameters
    ----------
    contact : Contact
        Elastic half-spaces, homogeneous or transversely isotropic, without adhesion; with :class:`Coulomb` friction of any coefficient, also
        infinite, or without. The profile may be a :class:`ForceCurve`.
    max_indentation : quantity
        Largest indentation in m of all steps, above 0.
    count : int
        Number of contacts; by default one, whose values are floats. Values of several are arrays of the shape (count,).

    Raises
    ------
    ProblemError
        If a body is viscoelastic, layered, graded or yields, the contact has adhesion, or a value is outside its limits.
    RefusedError
        If the contact is not a disk at every indentation.

    See Also
    --------
    solve : histories that are known in advance.
    export_law : the normal force as a table for other programs.

    Notes
    -----
    The stack is exact for straight steps in indentation and shift (Jäger 1993; Aleshin et al. 2015); within the frame of Cattaneo and
    Mindlin for bodies of revolution.

    References
    ----------
    - Jäger (1993), Arch. Appl. Mech. 63, 534-540.
    - Aleshin, Bou Matar and Van Den Abeele (2015), Int. J. Solids Struct. 60-61, 62-72.

    Examples
    --------
    >>> import pymdr as mdr
    >>> steel = mdr.Elastic("210 GPa", 0.3)
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    >>> stepper = mdr.Stepper(ball, "10 um")
    >>> pressed = stepper.advance(5e-6)
    >>> moved = stepper.advance(5e-6, shift=1e-6)
    >>> path = mdr.indent("5 um") >> mdr.shift("1 um")
    >>> abs(moved.tangential / float(mdr.solve(ball, path)["tangential_force"][-1]) - 1) < 1e-14
    True
    """

    _stacks: Stacks
    _moduli: EffectiveModuli
    _undoable: bool
    _moves: float
    """1 with friction, 0 without."""

    def __init__(self, contact: Contact, max_indentation: QuantityLike, *, count: int = 1) -> None:
        deepest = to_si(max_indentation, "m", name="Stepper: max_indentation")
        if not deepest > 0.0:
            raise ProblemError(f"Stepper: max_indentation = {shown(max_indentation)}; it must be above 0 m")
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise ProblemError(f"Stepper: count = {shown(count)}; a whole number of at least 1 is needed")
        self._contact = _checked(contact)
        self._deepest = float(within_range(deepest, "m", "Stepper: max_indentation", size=True))
        self._stacks, self._moduli = _mapped(contact, self._deepest, count)
        self._moves = 0.0 if _friction_of(contact) == 0.0 else 1.0
        self._undoable = False

    @property
    def contact(self) -> Contact:
        """The contact."""
        return self._contact

    @property
    def max_indentation(self) -> float:
        """Largest indentation in m."""
        return self._deepest

    @property
    def count(self) -> int:
        """Number of contacts."""
        return self._stacks.count

    def advance(self, indentation: Any, shift: Any = 0.0) -> Forces:
        """
        Go straight to an indentation and a shift.

        Parameters
        ----------
        indentation : float or ndarray, shape (count,)
            In m; 0 or less is without contact.
        shift : float or ndarray, shape (count,)
            In m, of one body against the other. Without friction it has no effect.

        Returns
        -------
        Forces
            Normal and tangential force in N.

        Raises
        ------
        PathError
            If a value is not finite, or deeper than `max_indentation`; the contacts then keep the state before.
        """
        if self.count > 1:
            return self._advance_all(indentation, shift)
        d, u = float(indentation), float(shift) * self._moves
        if d > self._deepest:  # the curves of a power have no end
            raise _refused(Ending.TOO_DEEP, d, u, self._deepest)
        ending, normal, tangential = self._stacks.advance(d, u)
        if ending is not Ending.COMPLETE:
            raise _refused(ending, d, u, self._deepest)
        self._undoable = True
        return Forces(normal, tangential * self._moves)

    def _advance_all(self, indentation: Any, shift: Any) -> Forces:
        given = np.empty((2, self.count))
        given[0], given[1] = indentation, np.multiply(shift, self._moves)
        finite = np.asarray(np.isfinite(given).all(axis=0))
        taken = np.logical_and(finite, given[0] <= self._deepest)
        if not taken.all():
            i = int(np.argmin(taken))
            ending = Ending.TOO_DEEP if finite[i] else Ending.NOT_FINITE
            raise _refused(ending, float(given[0, i]), float(given[1, i]), self._deepest)
        normal, tangential = self._stacks.advance_all(given)
        self._undoable = True
        return Forces(normal, tangential * self._moves)

    def undo(self) -> None:
        """
        Take the last step back; one step can be taken back.

        Raises
        ------
        PathError
            If there was no step since the beginning or the last undo.
        """
        if not self._undoable:
            raise PathError("Stepper.undo: there is no step to take back; only the last one can be")
        self._stacks.undo()
        self._undoable = False

    def copy(self) -> Self:
        """A stepper in the same state, which moves on its own."""
        other = object.__new__(type(self))
        other.__dict__ |= self.__dict__ | {"_stacks": self._stacks.copy()}
        return other

    @property
    def state(self) -> StepperState:
        """All that the contacts remember, to be kept and restored."""
        return StepperState(self._contact, self._deepest, self._stacks.arrays.copied(), self._undoable)

    def restore(self, state: StepperState) -> None:
        """
        Continue from a state.

        Parameters
        ----------
        state : StepperState
            Of a stepper of the same contact, number of contacts and largest indentation.

        Raises
        ------
        ProblemError
            If it is the state of another stepper.
        """
        if not isinstance(state, StepperState):
            raise ProblemError(f"Stepper.restore: {shown(state)} is not a state; give Stepper.state")
        mine, other = (
            (self._contact, self._deepest, self.count),
            (state.contact, state.max_indentation, state.arrays.memory.shape[0]),
        )
        for name, own, given in zip(("contact", "max_indentation", "count"), mine, other, strict=True):
            if own != given:
                raise ProblemError(
                    f"Stepper.restore: the state is that of another {name}, {shown(given)}, not {shown(own)}; restore it in a "
                    "stepper of that one"
                )
        self._stacks.arrays, self._undoable = state.arrays.copied(), state.undoable

    @property
    def indentation(self) -> Any:
        """Indentation in m."""
        return self._one(self._stacks.indentation)

    @property
    def shift(self) -> Any:
        """Shift in m; 0 without friction."""
        return self._one(self._stacks.shift)

    @property
    def normal_force(self) -> Any:
        """Normal force in N."""
        return self._one(self._stacks.normal_force)

    @property
    def tangential_force(self) -> Any:
        """Tangential force in N, which resists the shift."""
        return self._one(self._moves * self._stacks.tangential_force)

    @property
    def contact_radius(self) -> Any:
        """Contact radius in m; of a force curve k/(2 E*)."""
        return self._one(self._stacks.contact_radius)

    @property
    def stick_radius(self) -> Any:
        """Radius in m of the part that sticks; 0 where the whole contact slides, and without friction."""
        return self._one(self._moves * self._stacks.stick_radius)

    @property
    def normal_stiffness(self) -> Any:
        """Tangent stiffness 2 E* a in N/m."""
        return self._one(2.0 * self._moduli.normal * self._stacks.contact_radius)

    @property
    def tangential_stiffness(self) -> Any:
        """Tangent stiffness 2 G* c in N/m, c the radius of the part that sticks, as the motion goes on; a reversal begins with 2 G* a."""
        return self._one(2.0 * self._moduli.tangential * self._moves * self._stacks.stick_radius)

    @property
    def elastic_energy(self) -> Any:
        """Energy in J stored by the indentation."""
        return self._one(self._stacks.normal_energy)

    @property
    def stored_tangential_energy(self) -> Any:
        """Energy in J stored by the shift."""
        return self._one(self._moves * self._stacks.tangential_energy)

    @property
    def dissipated_energy(self) -> Any:
        """Energy in J dissipated by slip so far."""
        return self._one(self._moves * self._stacks.slip_work)

    @property
    def claims(self) -> Mapping[str, Claim]:
        """What holds of the numbers, by the claims of :func:`solve` for the largest indentation and a shift in partial slip."""
        pressed, moved = indent(self._deepest), ramp(shift=0.1 * self._deepest)
        solved = solve(self._contact, pressed >> moved if self._moves else pressed).claims
        everywhere = np.ones(1, dtype=bool)
        return {
            name: replace(
                solved[name],
                where=everywhere,
                error=None if (error := solved[name].error) is None else np.array([error.max()]),
            )
            for name in _CLAIMED
            if name in solved
        }

    def __repr__(self) -> str:
        """The contact, and where it is."""
        several = f", {self.count} contacts" if self.count > 1 else f" at d = {metres(self.indentation)}"
        return f"<pymdr.Stepper up to {metres(self._deepest)}{several}>"

    def _one(self, values: FloatArray) -> Any:
        return values if self.count > 1 else float(values[0])


def _checked(contact: Contact) -> Contact:
    """Refuse contacts whose steps are not a stack of turning points."""
    require_contact(contact, "Stepper")
    for refused, why in (
        (contact.adhesion is not None, "adhesive contacts are not available; leave adhesion out"),
        (
            contact.is_viscoelastic,
            "bodies with memory are not available; use Elastic with the stiffness at one time",
        ),
        (contact.plastic is not None, "bodies that yield are not available; impact(...) integrates them"),
        (
            contact.layered is not None,
            "layered bodies are not available; give the force_curve() of solve(...) as the profile of half-spaces",
        ),
        (
            contact.body.grading != 0.0 or contact.counterbody.grading != 0.0,
            "graded bodies are not available; export_law(...) tabulates their force",
        ),
        (
            isinstance(contact.profile, Shape),
            "the contact is not a disk; give the force_curve() of solve(...) as its profile",
        ),
    ):
        if refused:
            raise ProblemError(f"Stepper: {why}")
    return contact


def _friction_of(contact: Contact) -> float:
    """The coefficient of friction; 0 without a law."""
    return 0.0 if contact.friction is None else contact.friction.coefficient


def _mapped(contact: Contact, deepest: float, count: int) -> tuple[Stacks, EffectiveModuli]:
    """Contacts down to an indentation in m at which each is a disk."""
    mapped = map_to_springs(contact)
    refuse_unreachable(mapped.line, contact.profile, states_at_depth(mapped.line, np.array([deepest])))
    disks_down_to(contact, mapped.line, deepest, "Stepper")
    # without friction the shift stays 0 and no spring slips
    start = virgin_state(_friction_of(contact) or 1.0, mapped.moduli.normal / mapped.moduli.tangential)
    return Stacks(curves_down_to(mapped.line, deepest), start, count), mapped.moduli


def _refused(ending: Ending, indentation: float, shift: float, deepest: float) -> PathError:
    """The error of a step that was not taken."""
    if ending is Ending.NOT_FINITE:
        return PathError(
            f"Stepper.advance: indentation = {indentation:g} m, shift = {shift:g} m; finite values are needed"
        )
    return PathError(
        f"Stepper.advance: indentation = {metres(indentation)} is deeper than max_indentation = {metres(deepest)}; make a stepper with "
        "a larger one"
    )
