"""Fields and claims of a contact under torsion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pymdr.interpretation.on_normal import OnNormal
from pymdr.interpretation.stress import LineLoad, Loads, Punches
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, BoolArray, Claim, Level
from pymdr.line.torsion.limits import TwistedLine
from pymdr.line.torsion.moves import (
    Segment,
    TwistState,
    displacement_of,
    load_of,
    load_slope,
    steps_of,
    traction_of,
)
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

TORSIONAL_FIELDS = ("torsional_traction", "circumferential_displacement", "slip")
TORSIONAL_QUANTITIES = (
    "twist",
    "torque",
    "torsional_stiffness",
    "stick_radius",
    "stored_torsional_energy",
    "dissipated_energy",
)
_MEASURED_ERROR = (0.1, 0.3)
"""
Smallest and largest error of the torque over that of full slip where an inner ring slips; between them 0.3 times the excess of its traction. Twice what
boundary elements on rings gave at most in more than 1,000 rows of random histories: 0.05 up to an excess of 1, 0.17 beyond.
"""
_NOISE = 1e-13
"""Error of the slopes of the load, over the typical one."""
_HALF = np.array([0.5])


def torsional_modulus(contact: Contact) -> float:
    """G in Pa of both bodies, 1/G = sum 1/G_i, by their compliance across a wave: sqrt(c44 c66) where it depends on direction."""
    bodies = (contact.body, contact.counterbody)
    return 0.5 / sum(surface_compliances(body).transverse for body in bodies)


def torsional_claims(
    names: tuple[str, ...], everywhere: BoolArray, excess: FloatArray, error: FloatArray
) -> dict[str, Claim]:
    """
    Claims of a contact under torsion.

    Parameters
    ----------
    excess : ndarray
        Largest traction beyond friction so far, relative to mu p.
    error : ndarray
        Bound of the error of the torque where there is an excess, of its own value.
    """
    reason = "exact for elastic half-spaces in contact on a disk: torsion displaces neither along the axis nor along the radius"
    normal = Claim(Level.EXACT, reason, SOURCES["sneddon"], everywhere)
    reason = "exact for elastic half-spaces of any Poisson's ratio: what slips is an outer ring, and the traction inside is below mu p"
    if not np.any(excess > 0.0):
        turned = Claim(Level.EXACT, reason, SOURCES["lubkin"], everywhere)
    else:
        first = int(np.argmax(excess > 0.0))
        reason = (
            f"from step {first} on an inner ring would slip too (its traction exceeds mu p by up to {np.max(excess):.2g} of it), "
            "which the springs do not resolve. Compared with boundary elements on rings the error of the torque was at most 0.17 of the torque of "
            "full slip in more than 1,000 such rows; 0.3 times the excess is claimed, "
            f"from {_MEASURED_ERROR[0]:g} to {_MEASURED_ERROR[1]:g}"
        )
        turned = Claim(Level.APPROXIMATE, reason, SOURCES["lubkin"], everywhere, error)
    return {
        **{name: turned if name in TORSIONAL_QUANTITIES else normal for name in names},
        **dict.fromkeys(NORMAL_FIELDS, normal),
        **dict.fromkeys(TORSIONAL_FIELDS, turned),
    }


def measured_error(torque: FloatArray, largest: FloatArray, excess: FloatArray) -> FloatArray:
    """Bound of the relative error of the torque, at most 1; 0 where no inner ring slips."""
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.clip(_MEASURED_ERROR[1] * excess, *_MEASURED_ERROR)
        own = np.where(torque != 0.0, fraction * largest / np.abs(torque), 1.0)
    return np.where(excess > 0.0, np.fmin(own, 1.0), 0.0)


@dataclass(frozen=True)
class TorsionSurface(OnNormal[Surface]):
    """Normal and torsional fields of a contact, step by step."""

    line: TwistedLine
    replay: Callable[[], tuple[TwistState, ...]]
    """The state in every step, computed again on demand."""

    @cached_property
    def states(self) -> tuple[TwistState, ...]:
        """The state in every step."""
        return self.replay()

    @property
    def revolves(self) -> bool:
        """Nothing depends on the direction."""
        return True

    def loads(self, step: int) -> Loads:
        """The loads on the line; the torsional traction acts in the sense of the twist."""
        loads = self.normal.loads(step)
        return loads._replace(
            twist=twist_load(self.line, self.states[step].segments, loads.normal.edge_radius)
        )

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        if name not in TORSIONAL_FIELDS:
            return self.normal.field(name, position, step)
        state, r = self.states[step], np.abs(position)
        a = state.segments[-1].high if state.segments else 0.0
        values = np.zeros(r.shape)
        if name == "torsional_traction":
            inside = (r > 0.0) & (r < a)
            values[inside] = traction_of(self.line, state.segments, r[inside])
            values[(r == a) & (a > 0.0)] = self._at_edge(state)
            return values
        off_axis = r > 0.0
        values[off_axis] = displacement_of(self.line, state.segments, r[off_axis])
        if name == "circumferential_displacement":
            return values
        # rounding of the displacement of what sticks is no slip
        slip = np.where(r <= state.stick_radius, self._kept_slip(state, r, values), state.twist * r - values)
        return np.where((r <= a) & (a > 0.0), slip, math.nan)

    def _kept_slip(self, state: TwistState, r: FloatArray, displacement: FloatArray) -> FloatArray:
        """Slip of earlier moves where the surface sticks now; 0 within the rounding of its displacement."""
        slip = state.twist * r - displacement
        size = np.maximum(np.abs(state.twist * r), np.abs(displacement))
        return np.where(np.abs(slip) > 1e-12 * size, slip, 0.0)

    def _at_edge(self, state: TwistState) -> float:
        """The traction at the edge of the contact: 0, mu p, or infinite where the springs there carry a load."""
        outer = state.segments[-1]
        load = float(load_of(self.line, outer, np.array([outer.high]))[0])
        return math.copysign(math.inf, load) if load else 0.0


def twist_load(line: TwistedLine, segments: Sequence[Segment], radius: float) -> LineLoad:
    """
    The load of the torsional traction on the line as punches that turn.

    Parameters
    ----------
    radius : float
        Contact radius in m.

    Returns
    -------
    LineLoad
        Q in Pa, with its scale in Pa/m.
    """
    punches: list[Punches] = []
    size = 0.0
    for one in segments:
        ends = [one.low, *(x for x in line.kinks(one.high) if x > one.low), one.high]
        for low, high in itertools.pairwise(ends):
            last = float(np.nextafter(high, 0.0))

            def density(
                above: FloatArray, one: Segment = one, low: float = low, last: float = last
            ) -> FloatArray:
                return -load_slope(line, one, np.minimum(low + above, last))

            size = max(size, abs(float(load_of(line, one, low + _HALF * (high - low))[0])))
            if one.sign or one.rate:
                punches.append(Punches(low, high - low, density))
    if size == 0.0:
        return LineLoad((), radius, 0.0, radius, 0.0)
    return LineLoad(tuple(punches), radius, 0.0, radius, size / radius, steps_of(line, segments), _NOISE)
