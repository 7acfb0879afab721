"""Errors of taking a body of finite thickness as a half-space, compared with a layer bonded to a rigid base."""

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
from pymdr.problem.materials import Elastic, Material
from pymdr.units import FloatArray, metres

THICKNESS_LIMIT = 0.1
"""Largest relative error of a half-space in place of a layer."""
THICKNESS_SOURCE = "lebedev-ufliand"
_WIDEST = 32.0
"""Largest radius over thickness that is compared; beyond it a half-space is a poor approximation."""
_EDGED = 3.0
"""Bound of the error of the pressure within 0.8 of the edge, over that of the edge: 0.64/(1 - 0.64) for the radius of a
Hertzian contact, 2 for the amplitude of a punch with a parabolic line load."""
_ROW = "row"
"""The error of the force at equal indentation, which decides whether a row is valid."""
_ANY = "any"
"""The largest of all errors, for quantities without their own."""
_UNTOUCHED = ("force_lower_bound", "equivalent_profile", "jumped")
"""Quantities that stay valid on a layer; a lower bound does because a layer is stiffer."""
_OF_DEPTH = " (relative to the indentation)"
_PARTS = {
    "pressure": " (within 0.8 of the contact radius)",
    "normal_displacement": _OF_DEPTH,
    "gap": _OF_DEPTH,
}


def samples_of(contact: Contact) -> tuple[Elastic, ...]:
    """The bodies of a contact that have a thickness."""
    bodies = (contact.body, contact.counterbody)
    return tuple(one for one in bodies if isinstance(one, Elastic) and one.thickness is not None)


def thickness_assumption(contact: Contact, contact_radius: float) -> tuple[Assumption, ...]:
    """
    The assumption that bodies with a thickness behave as half-spaces.

    Parameters
    ----------
    contact_radius : float
        Largest contact radius in m.

    Returns
    -------
    tuple of Assumption
        One, with the measure nan if unknown; none if no body has a thickness.
    """
    if not samples_of(contact):
        return ()
    a = contact_radius
    text = "force on a bonded layer over that on a half-space, minus 1; at equal indentation, rigid base"
    try:
        sample = _measured(contact)
        if not isinstance(sample, str):
            return (Assumption("thickness", text, sample.stiffer(a), THICKNESS_LIMIT),) if a > 0.0 else ()
    except (ProblemError, ConvergenceError) as error:
        sample = str(error)
    return (Assumption("thickness", f"{text} (not measured: {sample})", math.nan, THICKNESS_LIMIT),)


def with_thickness(
    contact: Contact,
    columns: Mapping[str, FloatArray],
    claims: Mapping[str, Claim],
    prescribed: Mapping[str, BoolArray],
) -> dict[str, Claim]:
    """
    Claims with the error of taking bodies with a thickness as half-spaces.

    Returns
    -------
    dict of str to Claim
        Unchanged with friction and where the error is unknown; :func:`thickness_assumption` gives the reason.
    """
    if not samples_of(contact) or contact.friction is not None:
        return dict(claims)
    try:
        measured = _measured(contact)
        if isinstance(measured, str):
            return dict(claims)
        radii = np.nan_to_num(columns["contact_radius"])
        if contact.adhesion is None:
            errors, how = measured.pressed(radii, columns["indentation"], prescribed), ""
        else:
            errors, how = (
                measured.adhesive(radii),
                ", estimated from contacts of the same radius without adhesion",
            )
    except (ProblemError, ConvergenceError):
        return dict(claims)
    sample = f"a layer of {metres(measured.thickness)} bonded to a rigid base, taken as a half-space{how},"
    near = errors[_ROW] <= THICKNESS_LIMIT
    judged = {}
    for name, claim in claims.items():
        known = prescribed.get(name, np.zeros(near.shape, dtype=bool))
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
    """One profile on a half-space and on a layer of the same material."""

    thickness: float
    plain: Line
    layered: Line

    def stiffer(self, a: float) -> float:
        """Force on the layer over that on the half-space, minus 1, at the depth of a smooth contact of a radius in m."""
        if a > _WIDEST * self.thickness:
            return math.inf
        states = self._smooth(np.array([a]))
        error = math.nan
        if states.indentation[0] > 0.0 and a < self.plain.edge:
            error = float(self._at_depth(states)[_ROW][0])
        # for a flat end, and where the contact on the layer exceeds the known profile
        return error if math.isfinite(error) else float(self._punch(states.contact_radius)[0])

    def adhesive(self, radii: FloatArray) -> dict[str, FloatArray]:
        """Errors of adhesive contacts at radii in m, estimated from smooth contacts and punches."""

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
        self, radii: FloatArray, depth: FloatArray, prescribed: Mapping[str, BoolArray]
    ) -> dict[str, FloatArray]:
        """Errors of contacts without adhesion at some depths in m; prescribed quantities are equal on the layer."""
        near = self._near(radii)
        by_depth, by_force = prescribed["indentation"][near], prescribed["normal_force"][near]

        def errors(_: FloatArray) -> dict[str, FloatArray]:
            states = states_at_depth(self.plain, depth[near])
            at_depth = self._at_depth(states)
            if by_depth.all():
                return at_depth
            at_force = self._at_force(states)
            # a machine of any stiffness is between the two
            bounds = {
                name: np.maximum(
                    np.where(by_force, 0.0, at_depth[name]), np.where(by_depth, 0.0, at_force[name])
                )
                for name in at_depth
            }
            return {**bounds, _ROW: at_depth[_ROW]}

        return self._spread(radii, errors)

    def _near(self, radii: FloatArray) -> BoolArray:
        """Whether contacts are within the range of radii that is compared."""
        return (radii > 0.0) & (radii <= _WIDEST * self.thickness)

    def _spread(
        self, radii: FloatArray, errors: Callable[[FloatArray], dict[str, FloatArray]]
    ) -> dict[str, FloatArray]:
        """Errors over all rows: 0 without contact, at most 1, which also stands for unknown."""
        near = self._near(radii)
        spread = {}
        for name, values in errors(radii[near]).items():
            spread[name] = np.where(radii > 0.0, 1.0, 0.0)
            spread[name][near] = np.minimum(np.nan_to_num(values, nan=1.0, posinf=1.0), 1.0)
        return spread

    def _smooth(self, a: FloatArray) -> DiskStates:
        return DiskStates(self.plain.depth(a), as_place(a), np.zeros(a.shape))

    def _punch(self, a: FloatArray) -> FloatArray:
        return np.abs(self.layered.stiffness(a) / self.plain.stiffness(a) - 1.0)

    def _at_depth(self, states: DiskStates) -> dict[str, FloatArray]:
        return self._differences(states, states_at_depth(self.layered, states.indentation))

    def _at_force(self, states: DiskStates) -> dict[str, FloatArray]:
        return self._differences(states, states_at_force(self.layered, normal_force(self.plain, states)))

    def _differences(self, states: DiskStates, others: DiskStates) -> dict[str, FloatArray]:
        """Differences of a contact on the layer, relative to the half-space."""
        differences = {}
        here, there = _quantities(self.plain, states), _quantities(self.layered, others)
        for name, values in here.items():
            with np.errstate(divide="ignore", invalid="ignore"):
                change = np.abs(there[name] / values - 1.0)
            differences[name] = np.where(there[name] == values, 0.0, change)
        deeper = np.maximum(differences["indentation"], differences["normal_force"])
        differences |= dict.fromkeys(("travel", "normal_displacement", "gap"), deeper)
        edge = differences["contact_radius"] + differences["edge_amplitude"]
        differences["pressure"] = differences["mean_pressure"] + _EDGED * edge
        differences[_ROW] = differences["normal_force"]
        differences[_ANY] = np.max(list(differences.values()), axis=0)
        return differences


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
    """The sample for the comparison, or why there is none."""
    if contact.profile.no_radius:
        return contact.profile.no_radius
    plain, layered = (
        line_of(
            Contact(contact.profile, _sample_as(kind, contact.body), _sample_as(kind, contact.counterbody))
        )
        for kind in (Elastic, Layered)
    )
    thinnest = min(one.thickness for one in samples_of(contact) if one.thickness is not None)
    return _Sample(thinnest, plain, layered)


def _sample_as(kind: type[Material], body: Material) -> Material:
    """A body with a thickness as a half-space or as a layer on a rigid base; other bodies as they are."""
    if not isinstance(body, Elastic) or body.thickness is None:
        return body
    bulk = Elastic(body.young, body.poisson)
    return bulk if kind is Elastic else Layered([Layer(bulk, body.thickness)])


def _judged(claim: Claim, near: BoolArray, error: FloatArray, sample: str, part: str) -> Claim:
    """A claim with the relative error of a half-space in place of a layer."""
    where = claim.where & near
    largest, invalid = float(np.max(error[where], initial=0.0)), int(np.count_nonzero(claim.where & ~near))
    if claim.level is Level.NOT_VALID or (invalid == 0 and largest <= EXACT_WITHIN):
        return claim
    errs = [f"has a relative error up to {largest:.2g}{part}"] if largest > EXACT_WITHIN else []
    if invalid:
        errs.append(
            f"is not valid at {invalid} of {error.size} steps, where the relative error of the force is above {THICKNESS_LIMIT:g}: "
            "use Layered([Layer(Elastic(...), thickness)])"
        )
    remark = f"{sample} {', and '.join(errs)}"
    level = Level.APPROXIMATE if largest > EXACT_WITHIN else claim.level
    return replace(
        claim,
        level=level if where.any() else Level.NOT_VALID,
        reason=f"{claim.reason}; {remark}" if where.any() else remark,
        source=f"{claim.source}; {SOURCES[THICKNESS_SOURCE]}",
        where=where,
        error=error if claim.error is None else total_error(error, claim.error),
    )


def _of_conduction(claim: Claim, error: FloatArray) -> Claim:
    """The claim of a conductance, not valid where the thickness matters."""
    if claim.level is Level.NOT_VALID or np.max(error[claim.where], initial=0.0) <= EXACT_WITHIN:
        return claim
    why = "the body has a thickness, but the conductivity of its base is unknown: omit the thickness if the base is far away"
    return replace(claim, level=Level.NOT_VALID, reason=why, where=np.zeros(error.shape, dtype=bool))
