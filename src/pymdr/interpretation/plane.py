"""Fields and claims of a contact with friction that is moved in the plane."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pymdr.interpretation.friction import TANGENTIAL_QUANTITIES, frictional_claims
from pymdr.interpretation.on_normal import OnNormal
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.traction import tangential_field
from pymdr.interpretation.validity import TANGENTIAL_FIELDS, BoolArray, Claim, Level
from pymdr.line.foundation import ElasticLine
from pymdr.line.friction import FrictionState
from pymdr.line.plane import PlaneLaw, PlaneState, Springs
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

MODEL_ERROR = 0.2
"""Error of the tangential force over the largest mu F_N, for paths that leave a line: above all measured ones."""
_MEASURED = (
    "Compared with vector friction on the half-space along circles of 0.3, 0.6, 0.9, 0.95, 1.5 and 3 times the shift of first "
    "sliding, the error of the tangential force is 0.6, 3.7, 15, 16, 3 and 1.1 % of mu F_N, nearly equal for Poisson's ratios 0, 0.3 and "
    f"0.5; {MODEL_ERROR:g} is claimed"
)


def planar_claims(
    contact: Contact,
    moduli: EffectiveModuli,
    columns: Mapping[str, FloatArray],
    missed: Mapping[str, FloatArray],
    prescribed: str | None,
) -> dict[str, Claim]:
    """
    Claims of a contact that is moved in the plane.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Quantities of the result; vectors of shape (n, 2).
    missed : mapping of str to ndarray
        Numerical errors of force, shift, work and stick radius in SI units, from half the springs.
    prescribed : str or None
        The channel of the plane that all legs prescribe, if there is one.

    Returns
    -------
    dict of str to Claim
        Errors of vectors are relative to their length.
    """
    assert contact.friction is not None
    known: BoolArray = np.asarray(np.isfinite(columns["shift"]).all(axis=1))
    claims = frictional_claims(contact, moduli, tuple(columns), np.ones(known.shape, dtype=bool))
    mu = contact.friction.coefficient
    force = np.hypot(*columns["tangential_force"].T)
    carried = (mu if math.isfinite(mu) else 1.0) * np.maximum.accumulate(columns["normal_force"])
    slips = 0.0 if math.isinf(mu) or mu == 0.0 else MODEL_ERROR
    sizes = (
        ("the force", "tangential_force", carried, "mu F_N"),
        ("shifts", "shift", np.abs(columns["shift"]), "the largest"),
        ("the dissipated energy", "dissipated_energy", columns["dissipated_energy"], "the largest"),
        ("the stick radius", "stick_radius", columns["contact_radius"], "the largest contact radius"),
    )
    changes = [
        f"{what} by {_largest(missed[name]) / max(_largest(size), 1e-300):.1e} of {of}"
        for what, name, size, of in sizes
        if name != prescribed
    ]
    reason = f"springs whose forces are vectors replace tractions whose direction varies over the contact. {_MEASURED}; half as many springs change at most {', '.join(changes)}"
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.fmin((slips * carried + missed["tangential_force"]) / force, 1.0)
    error[force == 0.0] = 0.0
    for name in (*TANGENTIAL_QUANTITIES, *TANGENTIAL_FIELDS):
        if name in claims:
            own = error if name == "tangential_force" else None
            claims[name] = replace(
                claims[name], level=Level.APPROXIMATE, reason=reason, where=known, error=own
            )
    if prescribed is not None:
        claims[prescribed] = Claim(Level.EXACT, "prescribed", claims[prescribed].source, known)
    return claims


def _largest(values: FloatArray) -> float:
    return float(np.nanmax(values, initial=0.0))


def stacks_of(
    law: PlaneLaw, springs: Springs, state: PlaneState, friction: float
) -> tuple[FrictionState, FrictionState]:
    """
    The springs after a row as two stacks, along x and y, linear between springs: their traction and displacement follow.

    Parameters
    ----------
    friction : float
        Mu, infinite without slip.
    """
    touching = springs.label < state.indentation
    labels, firsts = np.unique(springs.label[touching], return_index=True)
    ratio = law.modulus / law.tangential_modulus
    stacks = []
    for vector, shift in zip(state.vector, state.shift.tolist(), strict=True):
        y = np.append(labels, max(state.indentation, 0.0)) if labels.size else np.zeros(1)
        b = np.append(shift - vector[touching][firsts], shift)
        # the middle of the line is not a spring of its own label at a flat tip
        y = y - min(y[0], 0.0)
        slope = np.diff(b) / np.diff(y)
        moved = shift * law.shift_scale if friction else shift
        stacks.append(FrictionState(y, b, slope, float(y[-1]), moved, friction, ratio))
    return stacks[0], stacks[1]


def along(state: FrictionState, direction: FloatArray) -> tuple[FrictionState, FrictionState]:
    """The components of a stack along a line."""
    x, y = (
        replace(state, b=part * state.b, slope=part * state.slope, shift=part * state.shift)
        for part in direction.tolist()
    )
    return x, y


@dataclass(frozen=True)
class PlaneSurface(OnNormal[Surface]):
    """Normal fields of a contact, and tangential fields with components along x and y."""

    states: Callable[[int], tuple[FrictionState, FrictionState]]
    """The stacks that carry the tractions of a step along x and y."""

    @property
    def line(self) -> ElasticLine:
        """The line of the contact."""
        return self.normal.springs

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step; (2, n) for tangential ones."""
        if name not in (*TANGENTIAL_FIELDS, "spring_shift"):
            return self.normal.field(name, position, step)
        return np.array(
            [tangential_field(self.normal, one, name, position, step) for one in self.states(step)]
        )
