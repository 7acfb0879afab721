"""Tangential fields on the surface from the state of the friction stack."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.interpretation.disk_sums import pressure_integrals, stretches_of
from pymdr.interpretation.fields import pressure
from pymdr.interpretation.on_normal import OnNormal
from pymdr.interpretation.shear_load import shear_load, steps_of
from pymdr.interpretation.stress import Loads
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.validity import TANGENTIAL_FIELDS, TANGENTIAL_LINE_FIELDS
from pymdr.line.foundation import (
    ElasticLine,
    passed_rings,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.line.friction import (
    ElasticCurves,
    FrictionLeg,
    FrictionState,
    Replay,
    curves_of,
    power_law_curves,
    spring_shifts,
    superposition,
    tabulated_curves,
)
from pymdr.mapping.abel import line_average
from pymdr.mapping.moduli import effective_moduli
from pymdr.numerics.panels import Place
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import Refined, Stretch, planned, refined
from pymdr.units import FloatArray

PARTS = "parts"
"""Key among the channels at the start of a leg: the number of substeps of its two-channel moves."""
_OFFSET = 1e-9
"""Relative distance at which the finite traction of a sticking sharp tip (over the smallest disk) or kink is evaluated."""
_BALANCED = 1e-12
"""Sum of weights up to which singularities cancel."""
_MANY = 64
"""Number of disks above which the sum of their pressures is computed as one integral along the line."""


def shear_traction(line: ElasticLine, state: FrictionState, r: ArrayLike) -> FloatArray:
    """
    Shear traction tau = mu sum sigma_i [p(r; y_i) - p(r; y_(i-1))], a sum of frictionless pressures.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    state : FrictionState
        The memory of the contact.
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        tau in Pa, in the direction of the shift; 0 outside the contact, inf at a sticking fixed edge.

    Notes
    -----
    Jaeger (1995); Ciavarella (1998).
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    tau = np.zeros(radius.shape)
    depth, weight, edge, scale = superposition(state)
    disks = states_at_depth(line, depth)
    a = disks.contact_radius
    # at a sharp tip or a kink the pressures of all larger disks have the same singularity, so only the sum of their weights counts
    if a.size == 0:
        return tau
    singular = np.isinf(pressure(line, float(a[-1]), 0.0, radius))
    above = np.array([weight[a > ring].sum() for ring in radius[singular]])
    tip = _OFFSET * np.min(a[a > 0.0], initial=math.inf)
    near = radius.copy()
    near[singular] = np.where(radius[singular] == 0.0, tip, (1.0 - _OFFSET) * radius[singular])
    summed = _summed(line, disks.place, a, weight, near) if a.size > _MANY else None
    if summed is None:
        summed = np.zeros(radius.shape)
        for i in np.flatnonzero((weight != 0.0) & (a > 0.0)):
            summed += weight[i] * pressure(line, disks.place.take(i), 0.0, near)
    tau += scale * summed
    rings, total = steps_of(disks, weight, edge)
    for low, high in stretches_of(rings):
        ring = rings[low:high, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            punch = line.modulus / (math.pi * np.sqrt((ring - radius) * (ring + radius)))
            tau += scale * np.where(radius <= ring, total[low:high, None] * punch, 0.0).sum(axis=0)
    tau[singular] = np.where(np.abs(above) < _BALANCED, tau[singular], np.copysign(math.inf, above))
    return tau


def _summed(
    line: ElasticLine, places: Place, a: FloatArray, weight: FloatArray, radius: FloatArray
) -> FloatArray | None:
    """The weighted sum of the regular pressures of many disks; None where their integrals cannot be resolved."""
    total = np.zeros(radius.shape)
    real = np.flatnonzero(a > 0.0)
    if real.size == 0:
        return total
    a, weight, first = a[real], weight[real], int(real[0])
    # the slope of the anchor curve between the edges of two disks
    outside = np.cumsum(weight[::-1])[::-1]
    innermost = pressure(line, places.take(first), 0.0, radius)
    for i, r in enumerate(radius):
        begin = int(np.searchsorted(a, r, side="right"))
        if begin == a.size:
            continue
        base, start = (outside[0] * innermost[i], float(a[0])) if begin == 0 else (0.0, float(r))
        beyond = np.flatnonzero(a > start)
        if beyond.size:
            integrals = pressure_integrals(line, float(r), start, a[beyond])
            if integrals is None:
                return None
            base += line.modulus / math.pi * float(outside[beyond] @ np.diff(integrals, prepend=0.0))
        total[i] = base
    return total


def tangential_displacement(line: ElasticLine, state: FrictionState, r: ArrayLike) -> FloatArray:
    """
    Tangential displacement of the surface, (2/pi) int_0^min(r, a) w / sqrt(r^2 - x^2) dx.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    state : FrictionState
        The memory of the contact; w is the shift of its springs.
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        u_x(r) in m of both bodies together, averaged over the azimuth (Popov and Hess 2015, chapter 5).
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    disks = states_at_depth(line, state.y)
    a = float(disks.contact_radius[-1])
    u = np.zeros(radius.shape)
    if state.slope.size == 0 or a == 0.0:
        return u
    equivalent = line.equivalent
    edge = equivalent.edge

    def shift(x: FloatArray) -> FloatArray:
        inside = np.minimum(x, min(a, edge))
        return spring_shifts(state, np.minimum(equivalent.g(inside), np.nextafter(state.y[-1], 0.0)))

    centre = radius == 0.0
    u[centre] = shift(np.zeros(1))
    knots = sorted({*(float(x) for x in disks.contact_radius[:-1] if 0.0 < x < a), *equivalent.kinks(a)})
    size = state.shift_scale * float(np.max(np.abs(state.b[-1] - state.b)))
    u[~centre] = line_average(shift, radius[~centre], high=a, breakpoints=knots, noise=1e-12 * size)
    return u


def tangential_field(
    normal: Surface, state: FrictionState, name: str, position: FloatArray, step: int
) -> FloatArray:
    """Values of a tangential field of one axis, or of the shift of its springs, at radii (or positions on the line) in one step."""
    line = normal.springs
    if name == "shear_traction":
        return shear_traction(line, state, position)
    if name == "spring_shift":
        g = normal.field("equivalent_profile", position, step)
        return np.where(np.isfinite(g), spring_shifts(state, np.where(np.isfinite(g), g, 0.0)), 0.0)
    u = tangential_displacement(line, state, position)
    if name == "tangential_displacement":
        return u
    a = normal.states.contact_radius[step]
    return np.where((np.abs(position) <= a) & (a > 0.0), state.shift - u, math.nan)


@dataclass(frozen=True)
class FrictionSurface(OnNormal[Surface]):
    """Normal and tangential fields of a contact with friction, step by step."""

    replay: Replay
    rows: np.ndarray
    """Row of the replay for each step of the result."""

    @property
    def line(self) -> ElasticLine:
        """The line of the contact."""
        return self.normal.springs

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction: without friction."""
        return self.replay.friction == 0.0

    def loads(self, step: int) -> Loads:
        """The loads on the line; the shear traction acts in the direction of the shift."""
        normal = self.normal.loads(step)
        if self.revolves:
            return normal
        return normal._replace(shear=shear_load(self.line, self.replay.state(int(self.rows[step]))))

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        if name not in (*TANGENTIAL_FIELDS, *TANGENTIAL_LINE_FIELDS):
            return self.normal.field(name, position, step)
        return tangential_field(self.normal, self.replay.state(int(self.rows[step])), name, position, step)


def friction_surface(
    contact: Contact,
    path: LoadingPath,
    starts: Sequence[Mapping[str, float]],
    machine_stiffness: float | None,
    normal: Surface,
    rows: np.ndarray,
) -> FrictionSurface:
    """
    The fields of a contact with friction, whose states are computed again on demand.

    Parameters
    ----------
    contact : Contact
        With a law of friction.
    starts : sequence of mapping
        Value of every channel at the start of each leg, in SI units.
    machine_stiffness : float or None
        In N/m, for legs that prescribe travel.
    normal : Surface
        The normal contact.
    rows : ndarray of int
        Row of the path for each step of the result.
    """
    assert contact.friction is not None
    requested: list[Refined] = []
    own: list[np.ndarray] = []
    done = 0
    for leg, here in zip(planned(path), starts, strict=True):
        requested.append(refined(leg.stretch(here), int(here.get(PARTS, 1))))
        own.append(requested[-1].own + done)
        done += requested[-1].rows.normal.size
    line = normal.springs
    legs = tuple(friction_leg(line, part.rows, machine_stiffness) for part in requested)
    curves = curves_down_to(line, deepest_of(line, legs))
    moduli = effective_moduli(contact.body, contact.counterbody)
    replay = Replay(curves, legs, contact.friction.coefficient, moduli.tangential)
    return FrictionSurface(normal, replay, np.concatenate(own)[rows])


def deepest_of(line: ElasticLine, legs: Sequence[FrictionLeg]) -> float:
    """Largest indentation in m of some legs; -inf if there are none."""
    by_force = [float(np.max(leg.normal)) for leg in legs if leg.by_normal_force]
    depths = [float(np.max(leg.normal)) for leg in legs if not leg.by_normal_force]
    if by_force:
        depths.append(float(states_at_force(line, np.array([max(by_force)])).indentation[0]))
    return max(depths, default=-math.inf)


def curves_down_to(line: ElasticLine, depth: float) -> ElasticCurves:
    """The curves of a line up to a depth in m; arbitrary without contact."""
    if depth <= 0.0:
        return power_law_curves(1.0, 1.0, line.modulus)
    deepest = depth * (1.0 + 1e-12)
    if line.max_radius < line.edge and not math.isfinite(float(line.place(deepest).x)):
        # not beyond the known profile
        deepest = depth
    rings = passed_rings(line, deepest)
    if not rings:
        return curves_of(line, deepest)

    def contact_radius(d: FloatArray) -> FloatArray:
        a = states_at_depth(line, d).contact_radius
        # near the step both disks carry the same force to rounding
        for ring in rings:
            for part, early in ((ring.inner, a > ring.inner[1]), (ring.outer, a < ring.outer[0])):
                wrong = early & ((d > ring.depth) == (part == ring.outer))
                a[wrong] = line.equivalent.between(d[wrong], *part).x
        return a

    return tabulated_curves(contact_radius, deepest, line.modulus, marks=[ring.depth for ring in rings])


def friction_leg(line: ElasticLine, requested: Stretch, machine_stiffness: float | None) -> FrictionLeg:
    """
    The input of the friction stack for a leg; travels of a machine are converted to indentations.

    Parameters
    ----------
    stretch : Stretch
        The rows of the leg.
    machine_stiffness : float or None
        In N/m.
    """
    depth = requested.normal
    if (
        requested.controls.normal == "travel"
        and machine_stiffness is not None
        and math.isfinite(machine_stiffness)
    ):
        depth = states_at_travel(line, depth, machine_stiffness).indentation
    by_tangential_force = requested.controls.tangential == "tangential_force"
    return FrictionLeg(requested.by_force, by_tangential_force, depth, requested.tangential)
