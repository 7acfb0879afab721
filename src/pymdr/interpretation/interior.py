"""Fields inside a body on demand for all rows of a history, their largest values, and their claims."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias

import numpy as np

from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.searching import Largest, largest_on, polished
from pymdr.interpretation.solids import IsotropicSolid, Solid, solid_of, traction_at
from pymdr.interpretation.stress import LineLoad, Loads
from pymdr.interpretation.tensors import DERIVED, fixed_axes, principal_stresses
from pymdr.interpretation.validity import SOURCES, Claim, Level, total_error
from pymdr.numerics.panels import IndexArray
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT
from pymdr.problem.materials import Elastic, Material, Rigid, Viscoelastic
from pymdr.problem.plasticity import ElasticPlastic
from pymdr.problem.profiles import ForceCurve, Shape
from pymdr.units import FloatArray, shown

INTERIOR_FIELDS = (*DERIVED, "interior_displacement")
"""Fields over radius (or x and y) and depth."""
INTERIOR_COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "stress": ("rr", "tt", "zz", "rz"),
    "principal_stress": ("1", "2", "3"),
    "interior_displacement": ("r", "z"),
}
"""Of fields of revolution that are no single number at a point."""
TWISTED_COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "stress": ("rr", "tt", "zz", "rz", "rt", "tz"),
    "principal_stress": ("1", "2", "3"),
    "interior_displacement": ("r", "z", "t"),
}
"""The same under torsion."""
SPATIAL_COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "stress": ("xx", "yy", "zz", "xz", "xy", "yz"),
    "principal_stress": ("1", "2", "3"),
    "interior_displacement": ("x", "y", "z"),
}
"""Of fields over x, y and z."""
LARGEST = {
    "largest_mises": ("von_mises", 1.0),
    "largest_shear": ("tresca", 0.5),
    "largest_principal": ("principal_stress", 1.0),
}
"""Quantities that are the largest value of a field in a body, times a number."""
Background: TypeAlias = Callable[[FloatArray], FloatArray]
"""Superposed stress xx, yy, zz, xz, xy, yz in Pa at depths in m, shape (6, ...), which the contact does not cause."""

MEASURES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    **DERIVED,
    "principal_stress": lambda tensor: principal_stresses(tensor)[0],
}
"""Measures with a largest value, computed from the stress."""
_SEARCHED = 20
"""Number of steps of which one is searched completely."""
_ALIKE = 0.02
"""Distance of the places of two largest values, over the loaded radius, up to which those between them are near."""
_SHOWN_RINGS = 12
"""Radii of steps and slopes of the shear traction that the search for largest values resolves."""
_SINGULAR_EDGE = (
    "at the edge of the contact, {}, the stress grows without bound under any load; round the edge, or use a law of adhesion "
    "of finite strength"
)
_SINGULAR_TIP = (
    "at a corner or a sharp tip of the profile in the contact the stress grows without bound (logarithmically) under any load "
    "{}; round the profile"
)
_SINGULAR_SHEAR = "at the edge of the sticking contact the shear traction grows without bound under any load; give a finite coefficient of friction"


class Loaded(Protocol):
    """A surface that knows its loads on the line, step by step."""

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction."""

    def loads(self, step: int) -> Loads:
        """The loads on the body of one step; radii are nan where nothing is known."""

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field on the surface at radii in m."""

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m in the contact at which its pressure may have a kink or be unbounded."""


@dataclass(frozen=True)
class Interior:
    """One of the bodies of a contact, in the states of every step."""

    surface: Loaded
    solid: Solid
    sign: float = 1.0
    """Of the shear traction on this body: 1, or -1 on the counterbody."""
    turns: bool = False
    """Whether the traction acts around the axis (torsion)."""

    def load(self, step: int) -> LineLoad:
        """The normal load on the line in one step."""
        return self.surface.loads(step).normal

    @property
    def revolves(self) -> bool:
        """Whether the fields are of revolution."""
        return self.surface.revolves

    def field(self, name: str, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """Values of a field of revolution at points in m in one step, components first."""
        loads = self.surface.loads(step)
        if math.isnan(loads.normal.radius):
            count = len(self.components.get(name, ()))
            return np.full((count,) * bool(count) + r.shape, math.nan)
        if name == "interior_displacement":
            moved = self._known_displacement(self._displaced(loads.normal, r, z, step))
            return (
                moved if loads.twist is None else np.append(moved, [self._turned(loads.twist, r, z)], axis=0)
            )
        tensor = self._normal(loads.normal, r, z, step)
        if loads.twist is not None:
            tensor = np.append(tensor, self._twist(loads.twist, r, z, step), axis=0)
        return derived(name, tensor)

    @property
    def components(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the components of fields of revolution, by field."""
        return TWISTED_COMPONENTS if self.turns else INTERIOR_COMPONENTS

    def _twist(self, load: LineLoad, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """Components rt and tz under torsion, with the traction itself at the surface."""
        tensor = self.sign * self.solid.twist_stress(load, r, z)
        surface = z == 0.0
        if surface.any():
            tensor[1, surface] = -self.sign * self.surface.field("torsional_traction", r[surface], step)
        return tensor

    def _turned(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """u_t under torsion."""
        return self.sign * self.solid.twist_displacement(load, r, z)

    def depths(self, end: float) -> FloatArray:
        """Depths in m down to `end` at which fields are drawn."""
        return np.linspace(0.0, end, 101)

    def layers_at(self, z: FloatArray) -> IndexArray | None:
        """The layer at depths in m, from 0 at the surface; None of a half-space."""
        return None

    def _displaced(self, load: LineLoad, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """u_r and u_z under the pressure alone."""
        return self.solid.normal_displacement(load, r, z)

    def spatial(
        self,
        name: str,
        points: tuple[FloatArray, FloatArray, FloatArray],
        step: int,
        background: Background | None = None,
    ) -> FloatArray:
        """
        Values of a field at points x, y, z in m in one step, components first.

        Parameters
        ----------
        name : str
            One of :data:`INTERIOR_FIELDS`.
        points : tuple of ndarray
            x, y and z in m, of shapes that broadcast.
        """
        x, y, z = np.broadcast_arrays(*points)
        loads = self.surface.loads(step)
        if math.isnan(loads.normal.radius):
            count = len(SPATIAL_COMPONENTS.get(name, ()))
            return np.full((count,) * bool(count) + x.shape, math.nan)
        r = np.hypot(x, y)
        cosine = np.divide(x, r, out=np.ones(r.shape), where=r > 0.0)
        sine = np.divide(y, r, out=np.zeros(r.shape), where=r > 0.0)
        # points of one radius and depth share the closed forms
        pairs, where = np.unique(r + 1j * z, return_inverse=True)
        radius, depth = np.ascontiguousarray(pairs.real), np.ascontiguousarray(pairs.imag)
        where = where.reshape(x.shape)
        if name == "interior_displacement":
            return self._spatial_displacement(loads, (radius, depth), where, (cosine, sine))
        tensor = np.zeros((6, *x.shape))
        tensor[:4] = self._normal(loads.normal, radius, depth, step)[:, where]
        if loads.twist is not None:
            tensor[4:] = self._twist(loads.twist, radius, depth, step)[:, where]
        if loads.shear is not None:
            amplitudes = self.sign * self.solid.shear_stress(loads.shear, radius, depth)
            tensor += traction_at(amplitudes[:, where], cosine, sine)
        with np.errstate(invalid="ignore"):
            turned = fixed_axes(tensor, cosine, sine)
        surface = z == 0.0
        if loads.shear is not None and surface.any():
            # the tractions are known there
            turned[3, surface] = -self.sign * self.surface.field("shear_traction", r[surface], step)
            turned[5, surface] = 0.0
        if background is not None:
            turned = turned + background(z)
        return derived(name, turned)

    def _spatial_displacement(
        self,
        loads: Loads,
        points: tuple[FloatArray, FloatArray],
        where: np.ndarray,
        direction: tuple[FloatArray, FloatArray],
    ) -> FloatArray:
        cosine, sine = direction
        along, inward = self._known_displacement(self.solid.normal_displacement(loads.normal, *points))[
            :, where
        ]
        across = np.zeros(where.shape)
        if loads.shear is not None:
            moved = self.sign * self.solid.shear_displacement(loads.shear, *points)[:, where]
            along, across, inward = along + moved[0] * cosine, moved[1] * sine, inward + moved[2] * cosine
        if loads.twist is not None:
            across = across + self._turned(loads.twist, *points)[where]
        return np.array([along * cosine - across * sine, along * sine + across * cosine, inward])

    def _known_displacement(self, moved: FloatArray) -> FloatArray:
        if isinstance(self.solid, IsotropicSolid) and math.isnan(self.solid.shear):
            raise NotValidError(
                "interior_displacement is not valid here: in a body with memory it depends on the whole history of the load; read normal_displacement on the surface instead"
            )
        return moved

    def _normal(self, load: LineLoad, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """Components rr, tt, zz and rz of the pressure alone, with what is infinite at the surface."""
        tensor = self.solid.normal_stress(load, r, z)
        on_surface = np.flatnonzero(np.ravel(z) == 0.0)
        if on_surface.size:
            flat, radius = tensor.reshape(4, -1), np.ravel(r)[on_surface]
            flat[3, on_surface] = 0.0
            pressure = self.surface.field("pressure", radius, step)
            singular = np.isinf(pressure)
            at = on_surface[singular]
            flat[:, at] = self._unbounded(pressure[singular], radius[singular] == 0.0, flat[:, at])
        return tensor

    def _unbounded(self, pressure: FloatArray, on_axis: np.ndarray, near: FloatArray) -> FloatArray:
        """The stress where the pressure is infinite: under a sharp tip, or at an edge along which the strain is finite."""
        if isinstance(self.solid, IsotropicSolid):
            poisson = self.solid.poisson
            rr, tt = np.where(on_axis, 0.5 + poisson, 1.0), np.where(on_axis, 0.5 + poisson, 2.0 * poisson)
            with np.errstate(invalid="ignore"):
                stresses = [np.where(factor == 0.0, 0.0, -pressure * factor) for factor in (rr, tt)]
        else:
            stresses = [np.copysign(math.inf, near[0]), np.copysign(math.inf, near[1])]
        return np.array([*stresses, -pressure, np.zeros(pressure.shape)])

    def largest(self, name: str, step: int, background: Background | None = None) -> Largest:
        """
        The largest value of a measure of stress in one step; inf where the stress grows without bound.

        Parameters
        ----------
        name : str
            "von_mises", "tresca" or "principal_stress".
        background : callable, optional
            A stress that is added.

        Notes
        -----
        The field is searched on a net that is refined toward the surface, and around its largest values on ever smaller ones. A shear
        traction is the cosine and the sine of the angle, so the angle is searched at every radius and depth.
        """
        loads = self.surface.loads(step)
        normal, shear, measure = loads.normal, loads.shear, MEASURES[name]
        if math.isnan(normal.radius):
            return Largest(math.nan, math.nan, math.nan)
        if normal.radius == 0.0:
            return Largest(0.0, math.nan, math.nan)
        singular = self.singular_radius(step)
        if singular is not None:
            return Largest(math.inf, singular, 0.0)

        def revolving(r: FloatArray, z: FloatArray) -> FloatArray:
            return self._steady(loads, r, z)

        def amplitudes(r: FloatArray, z: FloatArray) -> FloatArray:
            assert shear is not None
            return self.sign * self.solid.shear_stress(shear, r, z)

        marks = self.marks(step)
        for load in (shear, loads.twist):
            if load is not None:
                rings = sorted(
                    {segment.anchor for segment in load.segments} | {ring for ring, _ in load.rings}
                )
                marks += rings[:: max(1, len(rings) // _SHOWN_RINGS)]
        return largest_on(
            measure, revolving, None if shear is None else amplitudes, background, marks, normal.radius
        )

    def _steady(self, loads: Loads, r: FloatArray, z: FloatArray) -> FloatArray:
        """Components that do not depend on the angle: rr, tt, zz, rz, and under torsion rt and tz."""
        tensor = self.solid.normal_stress(loads.normal, r, z)
        if loads.twist is None:
            return tensor
        return np.append(tensor, self.sign * self.solid.twist_stress(loads.twist, r, z), axis=0)

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures of stress with a largest value."""
        return tuple(field for field, _ in LARGEST.values())

    def largest_by_layer(self, name: str, step: int, background: Background | None = None) -> list[Largest]:
        """The largest value in every layer; a half-space is one."""
        return [self.largest(name, step, background)]

    def marks(self, step: int) -> list[float]:
        """Radii in m at which the stress at the surface may not be smooth in one step."""
        load = self.load(step)
        return [*self.surface.marks(step), min(load.edge_radius, load.radius)]

    def largest_of(
        self, name: str, steps: Sequence[int], background: Background | None = None
    ) -> list[Largest]:
        """
        The largest values of a measure of stress in several steps, as by :meth:`largest`.

        Notes
        -----
        Every 20th step is searched. Where its largest value lies at the same place inside the body, over the loaded radius, as that of
        the one before, the steps between them are searched around this place only.
        """
        peaks: list[Largest] = []
        before: Largest | None = None
        for first in range(0, len(steps), _SEARCHED):
            block = list(steps[first : first + _SEARCHED])
            last = self.largest(name, block[-1], background)
            between = block[:-1]
            alike = before is not None and background is None and self.revolves
            ends = [
                self._relative(place, step) for place, step in ((before, steps[first - 1]), (last, block[-1]))
            ]
            change = ends[1] - ends[0]
            distance = float(np.max(np.abs(change)))
            alike = alike and distance <= _ALIKE
            for nth, step in enumerate(between, 1):
                place = ends[0] + change * (nth / len(block))
                near = self._around(name, (step, block[-1]), place, distance) if alike else None
                peaks.append(self.largest(name, step, background) if near is None else near)
            peaks.append(last)
            before = last
        return peaks

    def _relative(self, place: Largest | None, step: int) -> FloatArray:
        """A place over the loaded radius, nan if it is not inside the body."""
        if place is None or not place.z > 0.0:
            return np.full(2, math.nan)
        return np.array([place.r, place.z]) / self.load(step).radius

    def _around(
        self, name: str, steps: tuple[int, int], place: FloatArray, distance: float
    ) -> Largest | None:
        """
        The largest value of a step within a distance of a place over the loaded radius; None if it is none there, or the stress has no bound.

        The second step is one whose stress is bounded.
        """
        step, bounded = steps
        loads, measure = self.surface.loads(step), MEASURES[name]
        load = loads.normal
        # the same kinks have pressures of one kind
        alike = self.surface.marks(step) == self.surface.marks(bounded)
        if (
            not load.radius > 0.0
            or (_singular_edge(loads) if alike else self.singular_radius(step)) is not None
        ):
            return None
        near = float(place[0] * load.radius), float(place[1] * load.radius)
        return polished(lambda r, z: measure(self._steady(loads, r, z)), near, load.radius, distance)

    def singular_radius(self, step: int) -> float | None:
        """The radius in m at which the stress has no bound in one step; None if it has one everywhere."""
        loads = self.surface.loads(step)
        edge = _singular_edge(loads)
        if edge is not None:
            return edge
        corners = np.array([0.0, *self.surface.marks(step)])
        infinite = np.isinf(self.surface.field("pressure", corners, step))
        balanced = isinstance(self.solid, IsotropicSolid) and self.solid.poisson == 0.5
        sheared = any(one is not None and one.segments for one in loads[1:])
        if infinite.any() and not (balanced and not sheared):
            return float(corners[infinite][0])
        return None

    def unbounded(self, step: int) -> str:
        """Why the stress has no bound in one step."""
        loads = self.surface.loads(step)
        if loads.normal.edge == 0.0:
            if any(one is not None and one.rings for one in loads[1:]):
                return _SINGULAR_SHEAR
            isotropic = isinstance(self.solid, IsotropicSolid) and loads.shear is loads.twist is None
            return _SINGULAR_TIP.format("where nu is below 1/2" if isotropic else "in this body")
        return _SINGULAR_EDGE.format(
            "which is sharp" if loads.normal.edge > 0.0 else "which adhesion pulls open"
        )


def _singular_edge(loads: Loads) -> float | None:
    """The radius in m of an edge at which the stress has no bound under some loads; None without."""
    if loads.normal.edge != 0.0:
        return loads.normal.edge_radius
    rings = next((one.rings for one in loads[1:] if one is not None and one.rings), None)
    return None if rings is None else rings[-1][0]


def derived(name: str, tensor: FloatArray) -> FloatArray:
    """A field that follows from the stress, inf where the stress is."""
    with np.errstate(invalid="ignore"):
        values = DERIVED[name](tensor)
    if name in ("von_mises", "tresca"):
        values[np.isinf(tensor).any(axis=0)] = math.inf
    return values


def stressed_body(contact: Contact, side: str | None) -> tuple[Material, float]:
    """The body of a side, and the sign of the shear traction on it; unless it is given, the first whose stress is known."""
    if side is None:
        side = "counterbody" if solid_of(contact.body) is None else "body"
    if side not in ("body", "counterbody"):
        raise ProblemError(f"side = {shown(side)}: 'body' or 'counterbody' is needed")
    body = contact.body if side == "body" else contact.counterbody
    if solid_of(body) is None:
        raise NotValidError(f"stress is not valid in the {side}: {_unknown_in(body)}")
    return body, 1.0 if side == "body" else -1.0


def known_sides(contact: Contact) -> list[str]:
    """The sides whose stress is known, the body first."""
    sides = {"body": contact.body, "counterbody": contact.counterbody}
    return [side for side, body in sides.items() if solid_of(body) is not None]


_UNKNOWN: dict[type[Material], str] = {
    Rigid: "the stress in a rigid body is not determined",
    ElasticPlastic: "the model of a body that yields gives the force and the radius of its contact, not the stress inside",
    Viscoelastic: "where nu changes in time the load on the line does not determine the stress; give poisson instead of bulk",
}
"""Why the stress in a body is not known."""


def _unknown_in(body: Material) -> str:
    """Why the stress in a body is not known."""
    graded = "the stress in graded bodies does not follow from the load on the line as in homogeneous ones"
    others = f"the stress in a {type(body).__name__} body is not computed; use Elastic with the same moduli"
    return _UNKNOWN.get(type(body), graded if body.grading != 0.0 else others)


def unknown_stress(contact: Contact) -> str:
    """Why the stress in both bodies of a contact is not known; empty if it is known in one of them."""
    bodies = (contact.body, contact.counterbody)
    if isinstance(contact.profile, ForceCurve):
        return "a force curve does not determine the pressure"
    if isinstance(contact.profile, Shape):
        return "the stress under bodies that are not of revolution is not computed"
    if contact.adhesion is not None and contact.is_viscoelastic:
        return "the stress under a cohesive zone on a body with memory is not computed"
    if isinstance(contact.adhesion, DMT):
        remedy = "MaugisDugdale" if contact.layered is None else "JKR"
        return f"DMT does not resolve the attraction around the contact, which also loads the bodies; use {remedy}"
    if any(isinstance(body, Elastic) and body.thickness is not None for body in bodies):
        return "the stress in a sample of finite thickness is not that of a half-space"
    if any(solid_of(body) is not None for body in bodies):
        return ""
    return _unknown_in(contact.counterbody if isinstance(contact.body, Rigid) else contact.body)


def stress_claim(
    contact: Contact, by_rings: bool, claims: Mapping[str, Claim], planar: bool = False
) -> Claim:
    """
    The claim of the stress in the bodies of a contact.

    Parameters
    ----------
    by_rings : bool
        Whether it was solved by boundary elements.
    claims : mapping of str to Claim
        Those of the pressure and, with friction, of the shear or torsional traction, from which the stress follows.
    planar : bool
        Whether shifts have components along x and y.
    """
    pressure = claims["pressure"]
    why = unknown_stress(contact) or by_rings * (
        "boundary elements do not give the stress in the bodies; leave solver=Rings() out"
    )
    if not why and contact.friction is not None and contact.adhesion is not None:
        why = "the stress under a sheared adhesive contact is not computed; leave friction out for the stress of JKR"
    if not why and planar:
        why = "the stress under shifts in the plane is not computed; give single numbers for shifts along one line"
    if why:
        return Claim(Level.NOT_VALID, why, SOURCES["stress"], np.zeros(pressure.where.shape, dtype=bool))
    traction = claims.get("shear_traction", claims.get("torsional_traction"))
    if traction is None or not (pressure.readable and traction.readable):
        readable = pressure if traction is None or not pressure.readable else traction
        source = SOURCES["stress" if contact.layered is None else "burmister"]
        return replace(readable, source=source) if readable.readable else readable
    weaker = pressure if traction.level is Level.EXACT else traction
    return replace(
        weaker,
        source=f"{SOURCES['stress']}; {SOURCES['shear-stress']}",
        where=pressure.where & traction.where,
        error=None if weaker.error is None else total_error(pressure.error, traction.error),
    )
