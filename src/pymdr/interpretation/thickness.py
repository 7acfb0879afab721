"""What the thickness that a half-space really has does to its contacts, against a layer bonded to a rigid base."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.conductance import CONDUCTIONS
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.validity import (
    EXACT_WITHIN,
    SOURCES,
    Assumption,
    BoolArray,
    Claim,
    Level,
    total_error,
)
from pymdr.line.curves import Line
from pymdr.line.foundation import (
    DiskStates,
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    states_at_depth,
    states_at_force,
)
from pymdr.line.lines import line_of
from pymdr.numerics.panels import as_place
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layer, Layered
from pymdr.problem.materials import Elastic, Rigid
from pymdr.units import FloatArray, metres

THICKNESS_LIMIT = 0.1
"""Error of a half-space up to which it stands for a layer."""
THICKNESS_SOURCE = "lebedev-ufliand"
_WIDEST = 32.0
"""Radius in thicknesses beyond which nothing is measured: a half-space is far off there."""
_EDGED = 3.0
"""Errors of the edge in the pressure within 0.8 of it, and some: 0.64/(1 - 0.64) of the radius of a Hertzian one, 2 of the
amplitude of a punch whose line load bends by a square."""
_ROW = "row"
"""The error of the force at equal indentation, by which a row is judged."""
_ANY = "any"
"""The largest error of all, for quantities that have none of their own."""
_UNTOUCHED = ("force_lower_bound", "equivalent_profile", "jumped")
"""What a layer does not change, or, as it is stiffer, leaves a lower bound."""
_OF_DEPTH = " (as a part of the indentation)"
_PARTS = {
    "pressure": " (within 0.8 of the contact radius)",
    "normal_displacement": _OF_DEPTH,
    "gap": _OF_DEPTH,
}


def samples_of(contact: Contact) -> tuple[Elastic, ...]:
    """The bodies of a contact that say how thick they are."""
    bodies = (contact.body, contact.counterbody)
    return tuple(one for one in bodies if isinstance(one, Elastic) and one.thickness is not None)


def thickness_assumption(contact: Contact, contact_radius: float) -> tuple[Assumption, ...]:
    """
    Whether the bodies that say how thick they are do as half-spaces.

    Parameters
    ----------
    contact : Contact
    contact_radius : float
        The largest in m.

    Returns
    -------
    tuple of Assumption
        One, with the measure nan where nothing is known, or none where no body has a thickness.
    """
    if not samples_of(contact):
        return ()
    a = contact_radius
    words = "force on a bonded layer over that on a half-space, minus 1; at equal indentation, rigid base"
    try:
        found = _measured(contact)
        if not isinstance(found, str):
            return (Assumption("thickness", words, found.stiffer(a), THICKNESS_LIMIT),) if a > 0.0 else ()
    except (ProblemError, ConvergenceError) as error:
        found = str(error)
    return (Assumption("thickness", f"{words} (not measured: {found})", math.nan, THICKNESS_LIMIT),)


def with_thickness(
    contact: Contact,
    columns: Mapping[str, FloatArray],
    claims: Mapping[str, Claim],
    held: Mapping[str, BoolArray],
) -> dict[str, Claim]:
    """
    Claims of half-spaces that say how thick they are, with the error of taking them as half-spaces.

    Parameters
    ----------
    contact : Contact
    columns : mapping of str to ndarray
    claims : mapping of str to Claim
    held : mapping of str to ndarray of bool
        Rows in which a quantity is prescribed.

    Returns
    -------
    dict of str to Claim
        With friction, and where nothing is measured, those that were given: :func:`thickness_assumption` tells.
    """
    if not samples_of(contact) or contact.friction is not None:
        return dict(claims)
    try:
        found = _measured(contact)
        if isinstance(found, str):
            return dict(claims)
        radii = np.nan_to_num(columns["contact_radius"])
        if contact.adhesion is None:
            errors, how = found.pressed(radii, columns["indentation"], held), ""
        else:
            errors, how = (
                found.adhesive(radii),
                ", estimated from contacts of the same radius without adhesion",
            )
    except (ProblemError, ConvergenceError):
        return dict(claims)
    sample = f"a layer of {metres(found.thickness)} bonded to a rigid base, taken as a half-space{how},"
    near = errors[_ROW] <= THICKNESS_LIMIT
    judged = {}
    for name, claim in claims.items():
        known = held.get(name, np.zeros(near.shape, dtype=bool))
        error = np.where(known, 0.0, errors.get(name, errors[_ANY]))
        if any(name in (each.quantity, each.field) for each in CONDUCTIONS):
            judged[name] = _of_conduction(claim, error)
        elif name not in _UNTOUCHED:
            judged[name] = _judged(claim, near | known, error, sample, _PARTS.get(name, ""))
        else:
            judged[name] = claim
    return judged


@dataclass(frozen=True)
class _Sample:
    """One profile on a half-space, and on a layer of it."""

    thickness: float
    plain: Line
    layered: Line

    def stiffer(self, a: float) -> float:
        """The force of the layer over that of the half-space, less 1, at the depth of a smooth contact of a radius in m."""
        if a > _WIDEST * self.thickness:
            return math.inf
        states = self._smooth(np.array([a]))
        error = math.nan
        if states.indentation[0] > 0.0 and a < self.plain.edge:
            error = float(self._at_depth(states)[_ROW][0])
        # of a flat end, and where the layer is touched beyond the end of what is known
        return error if math.isfinite(error) else float(self._punch(states.contact_radius)[0])

    def adhesive(self, radii: FloatArray) -> dict[str, FloatArray]:
        """Errors of contacts of some radii in m, of which the smooth ones and the punches are known."""

        def errors(a: FloatArray) -> dict[str, FloatArray]:
            states, punch = self._smooth(a), self._punch(a)
            flat = states.indentation == 0.0  # a punch without a smooth contact
            depth, force = self._at_depth(states), self._at_force(states)
            return {
                name: np.where(flat, punch, np.maximum(punch, np.maximum(depth[name], force[name])))
                for name in depth
            }

        return self._spread(radii, errors)

    def pressed(
        self, radii: FloatArray, depth: FloatArray, held: Mapping[str, BoolArray]
    ) -> dict[str, FloatArray]:
        """Errors of contacts without adhesion at some depths in m; what is held is the same on the layer."""
        near = self._near(radii)
        by_depth, by_force = held["indentation"][near], held["normal_force"][near]

        def errors(_: FloatArray) -> dict[str, FloatArray]:
            states = states_at_depth(self.plain, depth[near])
            at_depth = self._at_depth(states)
            if by_depth.all():
                return at_depth
            at_force = self._at_force(states)
            # a machine of any stiffness ends between the two
            found = {
                name: np.maximum(
                    np.where(by_force, 0.0, at_depth[name]), np.where(by_depth, 0.0, at_force[name])
                )
                for name in at_depth
            }
            return {**found, _ROW: at_depth[_ROW]}

        return self._spread(radii, errors)

    def _near(self, radii: FloatArray) -> BoolArray:
        return (radii > 0.0) & (radii <= _WIDEST * self.thickness)

    def _spread(
        self, radii: FloatArray, errors: Callable[[FloatArray], dict[str, FloatArray]]
    ) -> dict[str, FloatArray]:
        """Errors over all rows: 0 without contact, and at most 1, where nothing is known."""
        near = self._near(radii)
        found = {}
        for name, values in errors(radii[near]).items():
            found[name] = np.where(radii > 0.0, 1.0, 0.0)
            found[name][near] = np.minimum(np.nan_to_num(values, nan=1.0, posinf=1.0), 1.0)
        return found

    def _smooth(self, a: FloatArray) -> DiskStates:
        return DiskStates(self.plain.depth(a), as_place(a), np.zeros(a.shape))

    def _punch(self, a: FloatArray) -> FloatArray:
        return np.abs(self.layered.stiffness(a) / self.plain.stiffness(a) - 1.0)

    def _at_depth(self, states: DiskStates) -> dict[str, FloatArray]:
        return self._apart(states, states_at_depth(self.layered, states.indentation))

    def _at_force(self, states: DiskStates) -> dict[str, FloatArray]:
        return self._apart(states, states_at_force(self.layered, normal_force(self.plain, states)))

    def _apart(self, states: DiskStates, others: DiskStates) -> dict[str, FloatArray]:
        """Relative differences of a contact on the layer, as parts of that on the half-space."""
        found = {}
        here, there = _quantities(self.plain, states), _quantities(self.layered, others)
        for name, values in here.items():
            with np.errstate(divide="ignore", invalid="ignore"):
                change = np.abs(there[name] / values - 1.0)
            found[name] = np.where(there[name] == values, 0.0, change)
        deeper = np.maximum(found["indentation"], found["normal_force"])
        found |= dict.fromkeys(("travel", "normal_displacement", "gap"), deeper)
        edge = found["contact_radius"] + found["edge_amplitude"]
        found["pressure"] = found["mean_pressure"] + _EDGED * edge
        found[_ROW] = found["normal_force"]
        found[_ANY] = np.max(list(found.values()), axis=0)
        return found


def _quantities(line: Line, states: DiskStates) -> dict[str, FloatArray]:
    force, a = normal_force(line, states), states.contact_radius
    return {
        "indentation": states.indentation,
        "normal_force": force,
        "contact_radius": a,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(force, a),
        "elastic_energy": elastic_energy(line, states),
        "edge_amplitude": edge_amplitude(line, a, states.edge_excess),
    }


def _measured(contact: Contact) -> _Sample | str:
    """What a thickness is measured with, or why it is not."""
    if contact.profile.no_radius:
        return contact.profile.no_radius
    (sample, *_) = samples_of(contact)
    other = contact.counterbody if contact.body is sample else contact.body
    if not isinstance(other, Rigid):
        return "both bodies deform"
    bulk = Elastic(sample.young, sample.poisson)
    assert sample.thickness is not None
    layer = Layered([Layer(bulk, sample.thickness)])
    plain, layered = (line_of(Contact(contact.profile, body)) for body in (bulk, layer))
    return _Sample(sample.thickness, plain, layered)


def _judged(claim: Claim, near: BoolArray, error: FloatArray, sample: str, part: str) -> Claim:
    where = claim.where & near
    largest, lost = float(np.max(error[where], initial=0.0)), int(np.count_nonzero(claim.where & ~near))
    if claim.level is Level.NOT_VALID or (lost == 0 and largest <= EXACT_WITHIN):
        return claim
    errs = [f"errs by up to {largest:.2g}{part}"] if largest > EXACT_WITHIN else []
    if lost:
        errs.append(
            f"has a force that errs by more than {THICKNESS_LIMIT:g} at {lost} of {error.size} steps, which are not valid: solve "
            "it as Layered([Layer(Elastic(...), thickness)])"
        )
    words = f"{sample} {', and '.join(errs)}"
    level = Level.APPROXIMATE if largest > EXACT_WITHIN else claim.level
    return replace(
        claim,
        level=level if where.any() else Level.NOT_VALID,
        reason=f"{claim.reason}; {words}" if where.any() else words,
        source=f"{claim.source}; {SOURCES[THICKNESS_SOURCE]}",
        where=where,
        error=error if claim.error is None else total_error(error, claim.error),
    )


def _of_conduction(claim: Claim, error: FloatArray) -> Claim:
    if claim.level is Level.NOT_VALID or np.max(error[claim.where], initial=0.0) <= EXACT_WITHIN:
        return claim
    why = "the body has a thickness, and what its base conducts is not known: leave the thickness out where the base is far away"
    return replace(claim, level=Level.NOT_VALID, reason=why, where=np.zeros(error.shape, dtype=bool))
