"""Fields inside a body of a whole history on demand, their largest values, and how far they can be trusted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.stress import (
    DERIVED,
    LineLoad,
    displacement,
    line_load,
    stress,
    sums,
)
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.line.curves import ElasticLine
from pymdr.line.layered import LayeredLine
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic, Material, Rigid, TransverselyIsotropic
from pymdr.problem.profiles import ForceCurve, Shape
from pymdr.units import FloatArray, shown

INTERIOR_FIELDS = (*DERIVED, "interior_displacement")
"""Fields over radius and depth."""
INTERIOR_COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "stress": ("rr", "tt", "zz", "rz"),
    "principal_stress": ("1", "2", "3"),
    "interior_displacement": ("r", "z"),
}
"""Of fields that are no single number at a point."""
LARGEST = {"largest_mises": ("von_mises", 1.0), "largest_shear": ("tresca", 0.5)}
"""Quantities that are the largest value of a field in a body, times a number."""

_STEPS = 9
"""Radii that are searched between two marks of the profile."""
DEPTHS = np.append(0.0, np.geomspace(1e-4, 2.0, 25))
"""Depths that are searched, of the loaded radius."""
_PLACE = 1e-6
"""Of the loaded radius: how closely a largest value is located."""
_RIVALS = 0.02
"""Of the largest value found: how far others may be below it from which the search begins too."""
_SINGULAR_EDGE = (
    "at the edge of the contact, {}, the stress grows without bound under any load; round the edge, or take a law of adhesion "
    "of finite strength"
)
_SINGULAR_TIP = (
    "at a corner or a sharp tip of the profile in the contact the stress grows without bound (logarithmically) under any load "
    "where nu is below 1/2; round the profile"
)


class Largest(NamedTuple):
    """A largest value and where it is."""

    value: float
    r: float
    """In m."""
    z: float
    """In m."""
    layer: int = 0
    """From 0, of a layered body."""


@dataclass(frozen=True)
class Interior:
    """One of the bodies of a contact, in the states of every step."""

    surface: Surface
    body: Elastic

    def load(self, step: int) -> LineLoad:
        """The load on the line in one step."""
        surface = self.surface
        states, zone, strength = surface.states, 0.0, 0.0
        if surface.cohesion is not None and states.contact_radius[step] < surface.line.equivalent.edge:
            zone, strength = float(surface.cohesion.radius[step]), surface.cohesion.strength
        excess = float(states.edge_excess[step])
        place, springs, a = states.place.take(step), surface.line, float(states.contact_radius[step])
        if isinstance(springs, LayeredLine):
            if not a > 0.0:
                return LineLoad((), a, 0.0, a, 0.0)
            springs, excess, _ = springs.carried(place, excess)
        assert isinstance(springs, ElasticLine)
        return line_load(springs, place, excess, zone=zone, strength=strength)

    def field(self, name: str, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """Values of a field at points in m in one step, components first."""
        if math.isnan(self.surface.states.contact_radius[step]):
            count = len(INTERIOR_COMPONENTS.get(name, ()))
            return np.full((count,) * bool(count) + r.shape, math.nan)
        if name == "interior_displacement":
            return self._displaced(r, z, step)
        tensor = self._tensor(r, z, step)
        with np.errstate(invalid="ignore"):
            values = DERIVED[name](tensor)
        if name in ("von_mises", "tresca"):
            values[np.isinf(tensor).any(axis=0)] = math.inf
        return values

    def depths(self, end: float) -> FloatArray:
        """Depths in m down to `end` at which fields are drawn."""
        return np.linspace(0.0, end, 101)

    def _displaced(self, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        return displacement(sums(self.load(step), r, z), r, z, self.body.poisson, self.body.shear)

    def _tensor(self, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        tensor = stress(sums(self.load(step), r, z), self.body.poisson)
        on_surface = np.flatnonzero(np.ravel(z) == 0.0)
        if on_surface.size:
            flat, radius = tensor.reshape(4, -1), np.ravel(r)[on_surface]
            flat[3, on_surface] = 0.0
            pressure = self.surface.field("pressure", radius, step)
            singular = np.isinf(pressure)
            flat[:, on_surface[singular]] = _unbounded(
                pressure[singular], radius[singular] == 0.0, self.body.poisson
            )
        return tensor

    def largest(self, name: str, step: int) -> Largest:
        """
        The largest value of an equivalent stress in one step; inf where the stress grows without bound.

        The field is searched on a net that is refined toward the surface, and around its largest values on ever smaller ones.
        """
        load = self.load(step)
        if math.isnan(load.radius):
            return Largest(math.nan, math.nan, math.nan)
        if load.radius == 0.0:
            return Largest(0.0, math.nan, math.nan)
        singular = self.singular_radius(step)
        if singular is not None:
            return Largest(math.inf, singular, 0.0)

        def value(r: FloatArray, z: FloatArray) -> FloatArray:
            return DERIVED[name](stress(sums(load, r, z), self.body.poisson))

        return searched(value, self.radii(step), load.radius * DEPTHS, load.radius)

    @property
    def measures(self) -> tuple[str, ...]:
        """What has a largest value."""
        return tuple(field for field, _ in LARGEST.values())

    def largest_by_layer(self, name: str, step: int) -> list[Largest]:
        """The largest value in every layer; a half-space is one."""
        return [self.largest(name, step)]

    def radii(self, step: int) -> FloatArray:
        """Radii in m that are searched for largest values."""
        load = self.load(step)
        inside = (m for m in self.surface.marks(step) if 0.0 < m < load.radius)
        marks = np.unique([0.0, *inside, min(load.edge_radius, load.radius), load.radius, 1.5 * load.radius])
        share = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, _STEPS)))
        return np.unique(marks[:-1, None] + np.diff(marks)[:, None] * share)

    def singular_radius(self, step: int) -> float | None:
        """The radius in m at which the stress has no bound in one step; None if it has one everywhere."""
        load = self.load(step)
        if load.edge != 0.0:
            return load.edge_radius
        corners = np.array([0.0, *self.surface.marks(step)])
        infinite = np.isinf(self.surface.field("pressure", corners, step))
        if self.body.poisson < 0.5 and infinite.any():
            return float(corners[infinite][0])
        return None

    def unbounded(self, step: int) -> str:
        """Why the stress has no bound in one step."""
        load = self.load(step)
        if load.edge == 0.0:
            return _SINGULAR_TIP
        return _SINGULAR_EDGE.format("which is sharp" if load.edge > 0.0 else "which adhesion pulls open")


def _unbounded(pressure: FloatArray, on_axis: np.ndarray, poisson: float) -> FloatArray:
    """The stress where the pressure is infinite: under a sharp tip, or at an edge along which the strain is finite."""
    rr, tt = np.where(on_axis, 0.5 + poisson, 1.0), np.where(on_axis, 0.5 + poisson, 2.0 * poisson)
    with np.errstate(invalid="ignore"):
        stresses = [np.where(factor == 0.0, 0.0, -pressure * factor) for factor in (rr, tt)]
    return np.array([*stresses, -pressure, np.zeros(pressure.shape)])


def searched(
    value: Callable[[FloatArray, FloatArray], FloatArray],
    radii: FloatArray,
    depths: FloatArray,
    size: float,
    span: tuple[float, float] = (0.0, math.inf),
) -> Largest:
    """
    The largest value of a field of radius and depth, from the peaks on a net.

    Parameters
    ----------
    value : callable
        Of arrays of radii and depths in m of one shape.
    radii, depths : ndarray
        The net in m, rising.
    size : float
        Length in m relative to which the place is precise.
    span : tuple of float, optional
        Smallest and largest depth in m.

    Returns
    -------
    Largest
    """
    values = value(*np.meshgrid(radii, depths, indexing="ij"))
    top = float(values.max())
    rivals = _is_peak(values) & (values >= top - _RIVALS * abs(top))
    return max(_refined(value, radii, depths, (i, k), _PLACE * size, span) for i, k in np.argwhere(rivals))


def _is_peak(values: FloatArray) -> np.ndarray:
    """Where a value on a net is at least as large as its neighbours."""
    wide = np.pad(values, 1, constant_values=-math.inf)
    rows, columns = values.shape
    around = [wide[i : i + rows, k : k + columns] for i in range(3) for k in range(3)]
    return np.asarray(values >= np.max(around, axis=0))


def _refined(
    value: Callable[[FloatArray, FloatArray], FloatArray],
    radii: FloatArray,
    depths: FloatArray,
    node: tuple[int, int],
    precision: float,
    span: tuple[float, float],
) -> Largest:
    """The largest value near a node of a net, on nets that shrink around it."""
    best = np.array([net[n] for net, n in zip((radii, depths), node, strict=True)])
    half = np.array(
        [
            np.max(np.abs(np.diff(net[max(n - 1, 0) : n + 2])), initial=0.0)
            for net, n in zip((radii, depths), node, strict=True)
        ]
    )
    # a value that rises forever outward has no peak
    top, widest = -math.inf, 2.0 * float(radii[-1])
    while half.max() > precision:
        r, z = (
            np.clip(centre + width * np.linspace(-1.0, 1.0, 5), *ends)
            for centre, width, ends in zip(best, half, ((0.0, widest), span), strict=True)
        )
        values = value(*np.meshgrid(r, z, indexing="ij"))
        row, column = np.unravel_index(np.argmax(values), values.shape)
        best, top = np.array([r[row], z[column]]), max(top, float(values[row, column]))
        # a net whose largest value lies at its rim is moved before it shrinks
        moved = row in (0, 4) and 0.0 < r[row] < widest, column in (0, 4) and span[0] < z[column] < span[1]
        half *= np.where(moved, 1.0, 0.5)
    return Largest(top, float(best[0]), float(best[1]))


def elastic_body(contact: Contact, side: str | None) -> Elastic | Layered:
    """
    The body of a side; unless it is given, the body if it is elastic or layered, else the counterbody.

    Raises
    ------
    ProblemError
        If there is no such side.
    NotValidError
        If the stress in that body is not known.
    """
    if side is None:
        side = "body" if isinstance(contact.body, Elastic | Layered) else "counterbody"
    if side not in ("body", "counterbody"):
        raise ProblemError(f"side = {shown(side)}: 'body' or 'counterbody' is needed")
    body = contact.body if side == "body" else contact.counterbody
    if not isinstance(body, Elastic | Layered):
        raise NotValidError(f"stress is not valid in the {side}: {_unknown_in(body)}")
    return body


def _unknown_in(body: Material) -> str:
    """Why the stress in a body that is not Elastic is not known."""
    if isinstance(body, Rigid):
        return "a rigid body has no stress that is determined"
    if isinstance(body, TransverselyIsotropic):
        return "the stress in transversely isotropic bodies is not computed"
    return "the stress in graded bodies does not follow from the load on the line as in homogeneous ones"


def unknown_stress(contact: Contact) -> str:
    """Why the stress in both bodies of a contact is not known; empty if it is known in one of them."""
    bodies = (contact.body, contact.counterbody)
    if isinstance(contact.profile, ForceCurve):
        return "a force curve does not determine the pressure"
    if isinstance(contact.profile, Shape):
        return "the stress under bodies that are not of revolution is not computed"
    if contact.friction is not None:
        return "the stress under shear tractions is not computed; solve the contact without friction"
    if contact.is_viscoelastic:
        return "the stress in bodies with memory is not computed: if Poisson's ratio changes in time, the load on the line does not determine it"
    if isinstance(contact.adhesion, DMT):
        remedy = "MaugisDugdale" if contact.layered is None else "JKR"
        return f"DMT does not resolve the attraction around the contact, which loads the bodies too; take {remedy}"
    if any(isinstance(body, Elastic) and body.thickness is not None for body in bodies):
        return "the stress in a sample of finite thickness is not that of a half-space"
    if any(isinstance(body, Elastic | Layered) for body in bodies):
        return ""
    return _unknown_in(contact.counterbody if isinstance(contact.body, Rigid) else contact.body)


def stress_claim(contact: Contact, by_rings: bool, pressure: Claim) -> Claim:
    """
    The claim of the stress in the bodies of a contact.

    Parameters
    ----------
    contact : Contact
    by_rings : bool
        Whether it was solved by boundary elements.
    pressure : Claim
        That of the pressure, from which the stress follows.

    Returns
    -------
    Claim
    """
    why = unknown_stress(contact) or by_rings * (
        "boundary elements do not give the stress in the bodies; leave solver=Rings() out"
    )
    if not why:
        source = SOURCES["stress" if contact.layered is None else "burmister"]
        return replace(pressure, source=source) if pressure.readable else pressure
    return Claim(Level.NOT_VALID, why, SOURCES["stress"], np.zeros(pressure.where.shape, dtype=bool))
