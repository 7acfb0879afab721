"""A contact that other programs move, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from pymdr.errors import PathError, ProblemError, PymdrError, RefusedError
from pymdr.interpretation.validity import Claim, approximated
from pymdr.line.moved import CompiledStep, Moved, Threads
from pymdr.line.plane import PlaneContacts
from pymdr.problem.contact import Contact, is_curve, require_contact
from pymdr.problem.options import with_known_arguments
from pymdr.problem.paths import LoadingPath
from pymdr.problem.values import LARGEST, NOTHING, within_range
from pymdr.result import Status
from pymdr.solving.moving import moving_of
from pymdr.solving.springs_error import errors_of_springs
from pymdr.solving.step_values import has_unit, refuse_malformed, too_deep
from pymdr.solving.verb import solve
from pymdr.solving.viscoelastic import SPRINGS
from pymdr.solving.workers import checked_workers, is_cluster
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_CLAIMED = (
    "normal_force",
    "tangential_force",
    "contact_radius",
    "stick_radius",
    "elastic_energy",
    "surface_energy",
    "stored_tangential_energy",
    "dissipated_energy",
)


class Forces(NamedTuple):
    """Forces on the contact after a step, floats for one contact and arrays for several."""

    normal: Any
    """F_N in N, which presses the bodies together."""
    tangential: Any
    """F_x in N, which resists the shift."""


class PlaneForces(NamedTuple):
    """Forces on a contact that moves in the plane, floats for one contact and arrays for several."""

    normal: Any
    """F_N in N, which presses the bodies together."""
    x: Any
    """F_x in N, which resists the shift."""
    y: Any
    """F_y in N."""


@dataclass(frozen=True, eq=False)
class StepperState:
    """All that the contacts of a :class:`Stepper` remember; it can be pickled."""

    contact: Contact
    max_indentation: float
    """In m."""
    arrays: tuple[np.ndarray, ...]
    """What the contacts remember, now and before the last step."""
    springs: int | None
    """Number of springs, if it was given."""
    undoable: bool
    """Whether the last step can be taken back."""


class Stepper:
    """
    One contact, or many alike, whose motion another program gives step by step: with the same numbers as :func:`solve`.

    The indentation and the shift go straight to the values of a step. The memory of friction is the stack of its turning points,
    so that a step costs the same after any history. Values are floats in SI units, without units as texts.

    Bodies with memory are springs of Maxwell bodies, each followed exactly over a step. With adhesion the contact is on a stable branch of its curve of equilibria and jumps at the ends of branches, as `solve` finds them.

    Parameters
    ----------
    contact : Contact
        Without adhesion: elastic half-spaces, homogeneous or transversely isotropic, with :class:`Coulomb` friction of any coefficient, also
        infinite, or without; the profile may be a :class:`ForceCurve`. `Viscoelastic` half-spaces with friction or without; `ElasticPlastic` bodies
        without. With a law of adhesion: any elastic bodies, and `Viscoelastic` half-spaces under :class:`MaugisDugdale` or `JKR(work, range=)`, without friction.
    max_indentation : quantity
        Largest indentation in m of all steps, above 0.
    count : int
        Number of contacts; by default one, whose values are floats. Values of several are arrays of the shape (count,).
    springs : int, optional
        Number of springs up to the largest contact radius, 8 to 4096. For elastic bodies with friction it is given for shifts (x, y) in the
        plane; by default the shift is along one line, where the memory of friction is a stack. Bodies with memory have 1000, along one line.
    workers : int
        Threads among which several contacts are divided; those with memory of the bodies, and balls that yield with adhesion or grow, are moved in one.

    Raises
    ------
    ProblemError
        If a body has memory with a relaxation that is no sum of exponentials, is layered or graded without adhesion, or a value is outside its limits.
    RefusedError
        If the contact is not a disk at every indentation.

    See Also
    --------
    solve : histories that are known in advance.
    export_law : the normal force as a table for other programs.

    Notes
    -----
    The stack is exact for straight steps in indentation and shift (Jäger 1993; Aleshin et al. 2015); within the frame of Cattaneo and
    Mindlin for bodies of revolution. Branches of adhesion are tables to about 1e-13 of the largest force.

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

    _moved: Moved
    _path: LoadingPath
    _springs: int | None
    _forces: type[Forces] | type[PlaneForces]
    _undoable: bool
    _several: bool

    @with_known_arguments
    def __init__(
        self,
        contact: Contact,
        max_indentation: QuantityLike,
        *,
        count: int = 1,
        springs: int | None = None,
        workers: int = 1,
    ) -> None:
        deepest = to_si(max_indentation, "m", name="max_indentation")
        if not deepest > 0.0:
            raise ProblemError(f"max_indentation = {shown(max_indentation)}; it must be above 0 m")
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise ProblemError(f"count = {shown(count)}; a whole number of at least 1 is needed")
        check_springs(springs, "Stepper")
        if is_cluster(checked_workers(workers)):
            raise ProblemError(
                "a cluster cannot take steps, because workers are threads of this process; give their number"
            )
        require_contact(contact)
        self._contact = contact
        self._deepest = float(within_range(deepest, "m", "max_indentation", size=True))
        self._moved, self._path = moving_of(contact, self._deepest, count, springs)
        self._moved.threads = Threads(count, min(workers, count))
        self._several = count > 1
        self._springs, self._forces = springs, Forces if self._moved.shift.ndim == 1 else PlaneForces
        if (
            contact.adhesion is not None
            and not contact.is_viscoelastic
            and not (disk := solve(contact, self._path).claims["contact_radius"]).where.all()
        ):
            raise RefusedError(f"{disk.reason}")
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
        return self._moved.count

    def advance(self, indentation: Any, shift: Any = 0.0, duration: Any = None) -> Forces | PlaneForces:
        """
        Go straight to an indentation and a shift.

        Parameters
        ----------
        indentation : float or ndarray, shape (count,)
            In m; 0 or less is without contact.
        shift : float or ndarray, shape (count,), or a pair of these
            In m, of one body against the other; (x, y) in the plane. Without friction it has no effect.
        duration : float or ndarray, shape (count,)
            Of the step in s; needed for bodies with memory, and without effect for others. 0 is a sudden step.

        Returns
        -------
        Forces or PlaneForces
            Normal and tangential force in N; in the plane (normal, x, y).

        Raises
        ------
        PathError
            If a value is no number or not within 1e60, is deeper than `max_indentation`, or a body with memory has no duration; the contacts then keep the state before.
        """
        try:
            if self._several:
                return self._advance_all(indentation, shift, duration)
            d = float(indentation)
            if not -LARGEST <= d <= self._deepest:
                raise too_deep(d, self._deepest)
            if -NOTHING < d < NOTHING:  # as in the rows of a path
                d = 0.0
            # the constructor of a named tuple takes as long as the step
            forces = tuple.__new__(self._forces, self._moved.advance(d, shift, duration))
        except PymdrError:
            raise
        except Exception:  # only then, since a check takes longer than a step
            self._refuse_malformed(indentation, shift, duration)
            raise
        self._undoable = True
        return forces

    def _advance_all(self, indentation: Any, shift: Any, duration: Any) -> Forces | PlaneForces:
        shifts = shift if self._forces is PlaneForces and isinstance(shift, tuple | list) else (shift,)
        if indentation is None or any(map(has_unit, (indentation, duration, *shifts))):
            self._refuse_malformed(indentation, shift, duration)
        d = np.empty(self.count)
        d[:] = indentation
        taken = np.logical_and(d >= -LARGEST, d <= self._deepest)
        if not taken.all():
            raise too_deep(float(d[np.argmin(taken)]), self._deepest)
        d[np.abs(d) < NOTHING] = 0.0
        forces = self._forces(*self._moved.advance_all(d, shift, duration))
        self._undoable = True
        return forces

    def _refuse_malformed(self, indentation: Any, shift: Any, duration: Any) -> None:
        lasting = {} if duration is None else {"duration": (duration, "s")}
        refuse_malformed(self.count, {"indentation": (indentation, "m")} | lasting)
        # in the plane something else than a pair was refused before
        in_plane = self._forces is PlaneForces and not isinstance(shift, float)
        shifts = dict(zip(("shift x", "shift y"), shift, strict=True)) if in_plane else {"shift": shift}
        refuse_malformed(self.count, {name: (each, "m") for name, each in shifts.items()})

    @with_known_arguments
    def compiled(self, *, capacity: int = 64) -> CompiledStep:
        """
        The step as a function that numba compiles into other functions, such as the loop of an integrator.

        ``step(body, states, i, indentation, shift, duration)`` moves contact i and returns ``(ending, normal, tangential)``; in the plane
        `shift` and `tangential` are pairs. Bodies with memory need the duration in s, which other contacts may leave out. An ending of 0 is a
        step; 1 refuses a value that is not within 1e60 or too deep, and a duration that :meth:`advance` refuses; 2 leaves the step to
        :meth:`advance`, because a stack is full or an edge rests in an unstable state. The contact then keeps its state.

        Parameters
        ----------
        capacity : int
            Number of turning points that a stack of friction along a line can hold. Random walks fill 64 after some ten thousand steps; 256 lasted for
            200,000.

        Returns
        -------
        CompiledStep
            (step, body, states). `states` are the arrays of this stepper, whose properties show the new state; ask again after
            :meth:`advance`, :meth:`undo` and :meth:`restore`, which may replace them.

        Raises
        ------
        ProblemError
            If bodies have memory with friction or adhesion, or yield with adhesion or apparent_radius, or `capacity` is not from 8 to 65536.

        Examples
        --------
        >>> import pymdr as mdr
        >>> steel = mdr.Elastic("210 GPa", 0.3)
        >>> ball = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
        >>> stepper = mdr.Stepper(ball, "10 um", count=2)
        >>> step, body, states = stepper.compiled()
        >>> ending, normal, tangential = step(body, states, 1, 5e-6, 0.0)
        >>> ending, bool(normal == stepper.normal_force[1])
        (0, True)
        """
        from pymdr.line.programs import compiled_of

        if type(capacity) is not int or not 8 <= capacity <= 65536:
            raise ProblemError(f"capacity = {shown(capacity)}; a whole number from 8 to 65536 is needed")
        self._undoable = True
        return compiled_of(self._moved, self._deepest, capacity)

    @with_known_arguments
    def c_header(self, name: str = "contact") -> str:
        """
        The step as a C header, of contacts without a law of the depth alone: the type ``<name>_state`` and ``<name>_advance(&state, d)``.

        Parameters
        ----------
        name : str
            Prefix of the names in the header, a C identifier.

        Returns
        -------
        str
            C99 that is also C++, in SI units, linked with the mathematical functions only: the numbers of :meth:`advance` for a contact that has
            not touched. Energies other than those lost in jumps are not in it.

        Raises
        ------
        ProblemError
            If the contact has no adhesion of one work on elastic bodies and is no ball that yields without it, or the name is not an
            identifier.

        See Also
        --------
        export_law : friction, bodies with memory and two works of adhesion in C.

        Examples
        --------
        >>> import pymdr as mdr
        >>> ball = mdr.Contact(mdr.Sphere("1 mm"), mdr.ElasticPlastic("1 GPa", 0.3, "20 MPa"))
        >>> "int grain_advance(grain_state *s, double d)" in mdr.Stepper(ball, "20 um").c_header("grain")
        True
        """
        from pymdr.presentation.header import step_header
        from pymdr.presentation.tables import about_lines, about_rows
        from pymdr.solving.step_headers import step_in_c

        step = step_in_c(self._moved)
        result = solve(self._contact, self._path)
        about = about_rows(self._contact, self.claims, result.assumptions, (), result.cite(), {})
        return step_header(name, about_lines(about), self._deepest, step)

    @with_known_arguments
    def undo(self) -> None:
        """
        Take the last step back; one step can be taken back.

        Raises
        ------
        PathError
            If there was no step since the beginning or the last undo.
        """
        if not self._undoable:
            raise PathError("there is no step to undo; only the last step can be undone")
        self._moved.undo()
        self._undoable = False

    @with_known_arguments
    def rotate(self, angle: Any) -> None:
        """
        Turn shift, tangential force and springs, for contacts whose plane turns against the frame of the program.

        Parameters
        ----------
        angle : float or ndarray, shape (count,)
            From x to y, in rad. It counts as a step for :meth:`undo`.

        Raises
        ------
        ProblemError
            If the contact does not move in the plane: a stack of turning points belongs to its line.
        PathError
            If the angle is no number, or not finite.
        """
        try:
            self._moved.rotate(angle)
        except PymdrError:
            raise
        except Exception:
            refuse_malformed(self.count, {"angle": (angle, "rad")})
            raise
        self._undoable = True

    @with_known_arguments
    def copy(self) -> Self:
        """A stepper in the same state, which moves on its own."""
        other = object.__new__(type(self))
        other.__dict__ |= self.__dict__ | {"_moved": self._moved.copied()}
        return other

    @property
    def state(self) -> StepperState:
        """All that the contacts remember, to be kept and restored."""
        return StepperState(
            self._contact, self._deepest, self._moved.copied().arrays, self._springs, self._undoable
        )

    @with_known_arguments
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
            raise ProblemError(f"{shown(state)} is not a state; give Stepper.state")
        mine, other = (
            (self._contact, self._deepest, self.count, self._springs),
            (state.contact, state.max_indentation, state.arrays[0].shape[0], state.springs),
        )
        for name, own, given in zip(
            ("contact", "max_indentation", "count", "springs"), mine, other, strict=True
        ):
            if own != given:
                raise ProblemError(
                    f"the state is that of another {name}, {shown(given)}, not {shown(own)}; restore it in a "
                    "stepper of that one"
                )
        self._moved.arrays = tuple(array.copy() for array in state.arrays)
        self._undoable = state.undoable

    @property
    def indentation(self) -> Any:
        """Indentation in m."""
        return self._one(self._moved.indentation)

    @property
    def shift(self) -> Any:
        """Shift in m, in the plane (x, y); 0 without friction."""
        return self._one(self._moved.shift)

    @property
    def normal_force(self) -> Any:
        """Normal force in N."""
        return self._one(self._moved.normal_force)

    @property
    def tangential_force(self) -> Any:
        """Tangential force in N, in the plane (x, y), which resists the shift."""
        return self._one(self._moved.tangential_force)

    @property
    def contact_radius(self) -> Any:
        """Contact radius in m; of a force curve k/(2 E*)."""
        return self._one(self._moved.contact_radius)

    @property
    def stick_radius(self) -> Any:
        """Radius in m of the part that sticks; 0 where the whole contact slides, and without friction."""
        return self._one(self._moved.stick_radius)

    @property
    def normal_stiffness(self) -> Any:
        """Tangent stiffness dF_N/dd in N/m; without adhesion 2 E* a, with memory that of a sudden step."""
        return self._one(self._moved.normal_stiffness)

    @property
    def tangential_stiffness(self) -> Any:
        """
        Tangent stiffness 2 G* c in N/m, c the radius of the part that sticks, as the motion goes on; a reversal begins with 2 G* a.

        In the plane a matrix (2, 2): springs that slip still resist motion across their force.
        """
        return self._one(self._moved.tangential_stiffness)

    @property
    def elastic_energy(self) -> Any:
        """Energy in J stored by the indentation."""
        return self._one(self._moved.elastic_energy)

    @property
    def stored_tangential_energy(self) -> Any:
        """Energy in J stored by the shift."""
        return self._one(self._moved.stored_tangential_energy)

    @property
    def surface_energy(self) -> Any:
        """Energy in J of the surfaces in contact, below 0; 0 without adhesion."""
        return self._one(self._moved.surface_energy)

    @property
    def jumped(self) -> Any:
        """Whether the contact jumped in the last step; never without adhesion."""
        jumped = self._moved.jumped
        return jumped if self.count > 1 else bool(jumped[0])

    @property
    def branch(self) -> Any:
        """Number of the stable branch of equilibria on which the contact is, -1 without contact; always 0 in contact without adhesion."""
        branch = self._moved.branch
        return branch if self.count > 1 else int(branch[0])

    @property
    def status(self) -> Any:
        """The :class:`Status` that :func:`solve` gives to a path that ends here, an array for several contacts."""
        moved = self._moved
        each = zip(moved.branch >= 0, moved.touched, moved.yielded, strict=True)
        states = np.array([_status(self._contact, *state) for state in each])
        return states if self.count > 1 else states[0]

    @property
    def dissipated_energy(self) -> Any:
        """Energy in J dissipated so far by slip, in dashpots, or by jumps and hysteresis of adhesion."""
        return self._one(self._moved.dissipated_energy)

    @property
    def claims(self) -> Mapping[str, Claim]:
        """
        What holds of the numbers, by the claims of :func:`solve`.

        They are those of the largest indentation and a shift in partial slip; with adhesion of the way there and back to pull-off. On springs their errors
        include those of random motions, which take seconds with memory and friction.
        """
        return claims_of_steps(self._contact, self._path, self._deepest, self._springs)

    def __repr__(self) -> str:
        """The contact, and where it is."""
        several = f", {self.count} contacts" if self.count > 1 else f" at d = {metres(self.indentation)}"
        return f"<pymdr.Stepper up to {metres(self._deepest)}{several}>"

    def _one(self, values: FloatArray) -> Any:
        # copies: the arrays of the contacts change with the next step
        if self.count > 1:
            return values.copy()
        return values[0].copy() if values.ndim > 1 else float(values[0])


def _status(contact: Contact, attached: bool, touched: bool, yielded: bool) -> Status:
    if contact.plastic is not None:
        return Status.YIELDED if yielded else Status.ELASTIC
    if contact.adhesion is None:
        return Status.OF_A_CURVE if is_curve(contact) else Status.COMPLETED
    return Status.ATTACHED if attached else Status.PULLED_OFF if touched else Status.NOT_TOUCHED


def claims_of_steps(
    contact: Contact, path: LoadingPath, deepest: float, springs: int | None, own: Moved | None = None
) -> dict[str, Claim]:
    """
    Claims of quantities of steps.

    Parameters
    ----------
    contact : Contact
    path : LoadingPath
        Through the states of the contact.
    deepest : float
        The largest indentation in m.
    springs : int or None
        Their number, if it was given.
    own : Moved, optional
        A contact of that many springs which has not been moved, if it is there already.
    """
    solved = solve(contact, path)
    everywhere = np.ones(1, dtype=bool)
    claims = {
        name: replace(
            solved.claims[name],
            where=everywhere,
            error=None if (error := solved.claims[name].error) is None else np.array([error.max()]),
        )
        for name in _CLAIMED
        if name in solved.claims
    }
    springs = springs or (SPRINGS if contact.is_viscoelastic and contact.adhesion is None else 0)
    if not springs:
        return claims
    for name, missed in errors_of_springs(contact, deepest, springs, own).items():
        largest = "the largest contact radius" if name == "stick_radius" else "its largest value"
        remark = f"; with {springs} springs its error is up to {missed:.1e} of {largest} in motions that reach max_indentation"
        claims |= approximated({name: claims[name]}, remark, missed) if missed > 0.0 else {}
    return claims


def check_springs(springs: Any, where: str) -> None:
    """Refuse numbers of springs outside their limits."""
    if springs is not None and not (type(springs) is int and 8 <= springs <= 4096):
        raise ProblemError(
            f"{where}: springs = {shown(springs)}; a whole number from 8 to 4096 is needed, such as 32"
        )


def plane_body(contact: Contact, deepest: float, springs: int) -> tuple[FloatArray, FloatArray]:
    """
    Labels in m and scales of springs in the plane, as compiled steps read them.

    Parameters
    ----------
    contact : Contact
        With friction.
    deepest : float
        The largest indentation in m.
    springs : int
        Their number.

    Raises
    ------
    ProblemError
        If the contact or the number is outside its limits.
    """
    check_springs(springs, "export_law")
    moved = moving_of(contact, deepest, 1, springs).contacts
    assert isinstance(moved, PlaneContacts)
    return moved.body
