"""Stress and displacement inside layered bodies: the half-space of the top layer in closed form, the rest as Hankel integrals.

The line load q gives the pressure in waves, P(k) = (1/pi) int_0^a q cos(kx) dx, and each wave has a known state at every depth
(`mapping/layer_waves.py`). A component is int k P(k) S(k, z) J(kr) dk. In the top layer S is counted without that of a half-space,
whose stress is closed (`interpretation/stress.py`), so that the integrand decays like exp(-k (2 h - z)), and below like exp(-k z).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.interior import (
    INTERIOR_COMPONENTS,
    MEASURES,
    SPATIAL_COMPONENTS,
    Background,
    Interior,
    Loaded,
    derived,
    stressed_body,
)
from pymdr.interpretation.searching import DEPTHS, Largest, largest_in_span, searched_radii
from pymdr.interpretation.solids import solid_of
from pymdr.interpretation.stress import LineLoad
from pymdr.interpretation.tensors import fixed_axes
from pymdr.line.layered.equation import gauss
from pymdr.mapping.layer_waves import StackWaves
from pymdr.numerics.panels import BoolArray, IndexArray
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic
from pymdr.units import FloatArray, metres

_END = 28.0
"""Thickness of the top layer times the largest wavenumber: waves beyond bear less than 1e-12."""
_ORDERS = (16, 12)
"""Gauss nodes of a panel: those that are used, and those that measure the error."""
_PHASE = 16.0
"""Largest phase of the Bessel functions and sines over a panel."""
_FIRST = 1e-4
"""End of the first panel of wavenumbers, relative to the inverse of the lengths of the contact."""
_TIP = 14
"""Panels of punches toward their anchor, each half of the next."""
_MOST = 400_000
"""Most wavenumbers."""
_BLOCK = 1 << 20
"""Largest number of values of sines and Bessel functions computed together."""
_FEW = 32
"""Largest number of points that are evaluated as a net although they do not form one."""
_CHECKED = 1.5
"""Largest radius over that of the load at which the error is measured."""
_WORST = 1e-9
"""Largest accepted error of the integrals, over the typical stress."""
_SAME = 1e-12
"""Relative distance from an interface at which a depth is on it."""
_SHARES = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, 9)))
"""Depths of the search in a layer, over its thickness."""
_DRAWN = 11
"""Smallest number of depths drawn in a layer."""
_J0, _J1, _RATIO = range(3)
"""J0(kr), J1(kr), and J1(kr)/(kr)."""


INTERFACE_TRACTIONS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    # rz and tz around the axis, xz and yz in fixed directions
    "interface_shear": lambda tensor: (
        np.hypot(tensor[3], tensor[5]) if len(tensor) > 4 else np.abs(tensor[3])
    ),
    "interface_tension": lambda tensor: tensor[2],
}
"""Tractions on the interfaces between layers, from the stress."""


class _Waves(NamedTuple):
    """The pressure in waves, and their amplitudes in the stack."""

    weight: FloatArray
    """P(k) dk in N."""
    stack: StackWaves


@dataclass(frozen=True)
class LayeredInterior(Interior):
    """A layered body of a contact, in the states of every step; `solid` is a half-space of its top layer."""

    layered: Layered = field(kw_only=True)

    @cached_property
    def _tops(self) -> tuple[float, ...]:
        return StackWaves(self.layered, np.ones(1)).tops

    @cached_property
    def _solids(self) -> tuple[Elastic, ...]:
        """The materials from the surface downward, with that of an elastic base."""
        base = (self.layered.base,) if isinstance(self.layered.base, Elastic) else ()
        return (*self.layered.solids, *base)

    @property
    def interfaces(self) -> tuple[float, ...]:
        """Depths in m of the interfaces, that with the base last."""
        return self._tops[1:]

    def depths(self, end: float) -> FloatArray:
        """Depths in m down to `end` at which fields are drawn, those of interfaces twice, for both sides."""
        both = [h for h in self.interfaces[: len(self._solids) - 1] if h < end]
        thin = (
            np.linspace(top, min(bottom, end), _DRAWN)
            for top, bottom in itertools.pairwise(self._tops)
            if top < end and bottom - top < 0.1 * end
        )
        plain = np.unique(np.concatenate([super().depths(end), *thin]))
        return np.sort(np.concatenate([plain[~self._on_interface(plain)], both, both]))

    def layers_at(self, z: FloatArray) -> IndexArray:
        """
        The layer at depths in m, from 0; the number of layers in the base.

        On an interface it is the layer above; in a row of points that repeats the depth of the row before, the layer below.
        """
        ends = np.array(self.interfaces)
        index = np.searchsorted(ends * (1.0 + _SAME), z, side="left")
        again = np.zeros(z.shape, dtype=bool)
        if z.ndim == 2:
            again[1:] = z[1:] == z[:-1]
        return np.asarray(index + (again & self._on_interface(z)))

    def _on_interface(self, z: FloatArray) -> BoolArray:
        return np.asarray(
            np.isclose(z[..., None], np.array(self.interfaces), rtol=_SAME, atol=0.0).any(axis=-1)
        )

    def spatial(
        self,
        name: str,
        points: tuple[FloatArray, FloatArray, FloatArray],
        step: int,
        background: Background | None = None,
    ) -> FloatArray:
        """
        Values of a field at points x, y, z in m in one step, components first; see :meth:`Interior.spatial`.

        Where the first axis repeats the depth of an interface, the layer above is read first, then that below.
        """
        x, y, z = np.broadcast_arrays(*points)
        r = np.hypot(x, y)
        c, s = (
            np.divide(one, r, out=np.full(r.shape, at), where=r > 0.0) for one, at in ((x, 1.0), (y, 0.0))
        )
        if math.isnan(self.load(step).radius):
            count = len(SPATIAL_COMPONENTS.get(name, ()))
            return np.full((count,) * bool(count) + x.shape, math.nan)
        of_revolution = name if name == "interior_displacement" else "stress"
        values = self.field(of_revolution, r.reshape(len(r), -1), z.reshape(len(z), -1), step)
        values = values.reshape(len(INTERIOR_COMPONENTS[of_revolution]), *x.shape)
        if name == "interior_displacement":
            return np.array([values[0] * c, values[0] * s, values[1]])
        with np.errstate(invalid="ignore"):
            turned = fixed_axes(np.concatenate([values, np.zeros((2, *x.shape))]), c, s)
        return derived(name, turned if background is None else turned + background(z))

    def _normal(self, load: LineLoad, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        return self._in_layers(r, z, 4, lambda layer, r, z: self._stress_in(layer, r, z, step))

    def _displaced(self, load: LineLoad, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        return self._in_layers(r, z, 2, lambda layer, r, z: self._displacement_in(layer, r, z, step))

    def _in_layers(
        self,
        r: FloatArray,
        z: FloatArray,
        components: int,
        value: Callable[[int, FloatArray, FloatArray], FloatArray],
    ) -> FloatArray:
        """Components at points, read in the layer of each; NaN in a rigid base."""
        layers = self.layers_at(z)
        values = np.full((components, *r.shape), math.nan)
        for layer in np.unique(layers[layers < len(self._solids)]).tolist():
            some = layers == layer
            values[:, some] = value(layer, r[some], z[some])
        return values

    def _stress_in(self, layer: int, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """The stress in Pa at points of one layer, shape (4, n)."""
        rest = self._rest_in(layer, r, z, step)
        if layer > 0:
            return rest
        with np.errstate(invalid="ignore"):
            return np.asarray(super()._normal(self.load(step), r, z, step) + rest)

    def _rest_in(self, layer: int, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """The same, in the top layer without that of a half-space."""
        poisson = self._solids[layer].poisson
        c = poisson / (1.0 - poisson)

        def amplitudes(state: FloatArray) -> tuple[FloatArray, ...]:
            _, along, pressure, shear = state
            hoop = c * (along - pressure)
            return hoop + along, hoop, along, -pressure, shear

        wanted = _Wanted(layer, r, z, amplitudes, (_J0, _J0, _RATIO, _J0, _J1))
        radial, hoop, along, axial, shear = self._hankel(wanted, step, lambda k: k)
        return np.array([radial - along, hoop + along, axial, shear])

    def _displacement_in(self, layer: int, r: FloatArray, z: FloatArray, step: int) -> FloatArray:
        """The displacement in m at points of one layer, shape (2, n)."""
        wanted = _Wanted(layer, r, z, lambda state: (state[1], state[0]), (_J1, _J0))
        rest = self._hankel(wanted, step, np.ones_like) / (2.0 * self._solids[layer].shear)
        return super()._displaced(self.load(step), r, z, step) + rest if layer == 0 else rest

    def _hankel(self, wanted: _Wanted, step: int, per_wave: Callable[[FloatArray], FloatArray]) -> FloatArray:
        load = self.load(step)
        if not load.radius > 0.0:
            return np.zeros((len(wanted.kinds), wanted.r.size))
        waves = self._waves(load, float(np.max(wanted.r, initial=0.0)), step)
        return _integrated(waves, wanted, per_wave(waves.stack.k))

    def load(self, step: int) -> LineLoad:
        """The load on the line in one step."""
        if step not in self._loads:
            self._loads[step] = super().load(step)
        return self._loads[step]

    @cached_property
    def _loads(self) -> dict[int, LineLoad]:
        return {}

    @cached_property
    def _known(self) -> dict[tuple[int, int], _Waves]:
        """Waves that were made, by the step and the logarithm of the radius to which they are resolved."""
        return {}

    def _waves(self, load: LineLoad, top: float, step: int) -> _Waves:
        octave = math.ceil(math.log2(max(top, _CHECKED * load.radius)))
        if (step, octave) not in self._known:
            waves, fewer = (_waves_of(load, self.layered, 2.0**octave, order) for order in _ORDERS)
            error = self._difference(load, waves, fewer) / load.scale
            if not error <= _WORST:
                raise ConvergenceError(
                    f"the stress in layers under a contact of radius {metres(load.edge_radius)} has an error of {error:.1g} of the "
                    f"typical stress (limit {_WORST:g}): the integrals over the wavenumber did not converge; use layers that differ less"
                )
            self._known[step, octave] = waves
        return self._known[step, octave]

    def _difference(self, load: LineLoad, waves: _Waves, fewer: _Waves) -> float:
        """The largest difference in Pa of the tractions on the interfaces by two quadratures."""
        r = load.radius * np.linspace(0.0, _CHECKED, 7)
        largest = 0.0
        for layer, depth in enumerate(self.interfaces):
            z = np.full(r.shape, depth)
            wanted = _Wanted(layer, r, z, lambda state: (state[1], state[2], state[3]), (_J0, _J0, _J1))
            one, other = (_integrated(each, wanted, each.stack.k) for each in (waves, fewer))
            largest = max(largest, float(np.max(np.abs(one - other))))
        return largest

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures of stress with a largest value."""
        return (*super().measures, *INTERFACE_TRACTIONS)

    def largest(self, name: str, step: int, background: Background | None = None) -> Largest:
        """
        The largest value of a measure of stress, or of a traction on interfaces, in one step, with its layer.

        Every layer is searched alone, because stresses jump at interfaces.
        """
        return max(self.largest_by_layer(name, step, background))

    def largest_of(
        self, name: str, steps: Sequence[int], background: Background | None = None
    ) -> list[Largest]:
        """The largest values in several steps, each searched everywhere."""
        return [self.largest(name, step, background) for step in steps]

    def largest_by_layer(self, name: str, step: int, background: Background | None = None) -> list[Largest]:
        """The largest value in every layer and in an elastic base, or at the foot of every layer."""
        load, count = self.load(step), len(self._solids)
        on_interfaces = name in INTERFACE_TRACTIONS
        parts = len(self.layered.layers) if on_interfaces else count
        if not load.radius > 0.0:
            nothing = math.nan if math.isnan(load.radius) else 0.0
            return [Largest(nothing, math.nan, math.nan, layer=layer) for layer in range(parts)]
        singular = None if on_interfaces else self.singular_radius(step)
        ends = [*self.interfaces, math.inf]
        peaks = []
        for layer in range(parts):
            if layer == 0 and singular is not None:
                peaks.append(Largest(math.inf, singular, 0.0))
                continue
            top, bottom = self._tops[layer], ends[layer]
            span = (bottom, bottom) if on_interfaces else (top, bottom)
            here = self._searched(name, (layer, *span), step, background)
            peaks.append(here._replace(layer=layer))
        return peaks

    def _searched(
        self, name: str, where: tuple[int, float, float], step: int, background: Background | None
    ) -> Largest:
        """The largest value in one layer between two depths in m."""
        load, (layer, top, bottom) = self.load(step), where
        measure = INTERFACE_TRACTIONS.get(name) or MEASURES[name]

        def revolving(r: FloatArray, z: FloatArray) -> FloatArray:
            tensor = self._rest_in(layer, np.ravel(r), np.ravel(z), step)
            if layer == 0:
                tensor += self.solid.normal_stress(load, np.ravel(r), np.ravel(z))
            return tensor.reshape(4, *r.shape)

        # stresses spread with the depth
        size = load.radius + top
        radii = searched_radii(self.marks(step), load.radius)
        if top > 0.0:
            radii = np.unique(np.concatenate([radii, size * np.linspace(0.0, 2.0, _SHARES.size)]))
        depths = np.unique(np.concatenate([top + size * DEPTHS, top + min(bottom - top, size) * _SHARES]))
        net, parts = (radii, depths[depths <= bottom]), (revolving, None, background)
        largest = largest_in_span(measure, parts, net, load.radius, (top, bottom))
        if name in INTERFACE_TRACTIONS and largest.value <= _WORST * load.scale:
            # an interface that is compressed everywhere has no tension but that which vanishes far away
            return Largest(0.0, math.nan, math.nan)
        return largest


class _Wanted(NamedTuple):
    """Integrals over waves at points of one layer."""

    layer: int
    r: FloatArray
    z: FloatArray
    amplitudes: Callable[[FloatArray], tuple[FloatArray, ...]]
    """From a state, shape (4, n), to what each integral has per wave."""
    kinds: tuple[int, ...]
    """The Bessel function of each."""


def _integrated(waves: _Waves, wanted: _Wanted, per_wave: FloatArray) -> FloatArray:
    """Integrals at points, shape (integrals, points)."""
    radii, at = np.unique(wanted.r, return_inverse=True)
    depths, which = np.unique(wanted.z, return_inverse=True)
    if radii.size * depths.size > 16 * max(wanted.r.size, _FEW):
        # scattered points, which make no net
        parts = (
            _integrated(waves, wanted._replace(r=wanted.r[some], z=wanted.z[some]), per_wave)
            for some in np.array_split(np.arange(wanted.r.size), math.ceil(wanted.r.size / _FEW))
        )
        return np.concatenate(list(parts), axis=1)
    # waves that do not reach the points are left out
    tops = waves.stack.tops
    path = depths[0] if wanted.layer > 0 else 2.0 * tops[1] - depths[-1]
    count = int(np.searchsorted(waves.stack.k, _END / path))
    k, weight = waves.stack.k[:count], (waves.weight * per_wave)[:count]
    total = np.zeros((len(wanted.kinds), radii.size, depths.size))
    block = max(1, _BLOCK // max(radii.size, 4 * depths.size))
    for start in range(0, count, block):
        part = slice(start, min(start + block, count))
        bessel = _bessel(np.outer(radii, k[part]), wanted.kinds)
        states = np.stack([waves.stack.states(wanted.layer, float(z), part) for z in depths], axis=-1)
        for i, (kind, amplitude) in enumerate(zip(wanted.kinds, wanted.amplitudes(states), strict=True)):
            total[i] += bessel[kind] @ (weight[part, None] * amplitude)
    return total[:, at, which]


def _bessel(x: FloatArray, kinds: tuple[int, ...]) -> dict[int, FloatArray]:
    from scipy.special import j0, j1

    values = {_J0: j0(x), _J1: j1(x)}
    if _RATIO in kinds:
        values[_RATIO] = np.where(x > 0.0, values[_J1] / np.where(x > 0.0, x, 1.0), 0.5)
    return values


def _waves_of(load: LineLoad, body: Layered, top: float, order: int) -> _Waves:
    """The pressure of a line load in waves, on panels on which neither it nor the Bessel functions up to a radius in m turn often."""
    unit, weights = gauss(order)
    end = _END / body.layers[0].thickness
    longest = _PHASE / (top + load.radius)
    marks = [0.0, _FIRST / (top + body.thickness)]
    if end / longest * order > _MOST:
        raise ProblemError(
            f"stress at radii up to {metres(top)} under a top layer of {metres(body.layers[0].thickness)} needs {end / longest * order:.2g} "
            f"wavenumbers (limit {_MOST}); give smaller radii"
        )
    while marks[-1] < end:
        marks.append(min(2.0 * marks[-1], marks[-1] + longest, end))
    low, width = np.array(marks[:-1])[:, None], np.diff(marks)[:, None]
    k = (low + 0.5 * width * (unit + 1.0)).ravel()
    weight = (0.5 * width * weights).ravel()
    s, punches = _punches(load, end, order)
    waves = load.edge * np.sin(k * load.edge_radius) + _sines(low.ravel(), width.ravel(), unit, s, punches)
    return _Waves(waves / (math.pi * k) * weight, StackWaves(body, k))


def _sines(
    low: FloatArray, width: FloatArray, unit: FloatArray, s: FloatArray, punches: FloatArray
) -> FloatArray:
    """The sums of punches sin(k s) at Gauss's nodes of panels of wavenumbers; panels of one width share all but a factor."""
    sums = np.empty((low.size, unit.size))
    widths, which = np.unique(np.round(width / width.max(), 9), return_inverse=True)
    for i in range(widths.size):
        some = np.flatnonzero(which == i)
        within = 0.5 * width[some[0]] * (unit + 1.0)
        block = max(1, _BLOCK // max(s.size, 1))
        for chosen in np.array_split(some, math.ceil(some.size / block)):
            parts = np.exp(1j * np.outer(low[chosen], s)) @ (
                np.exp(1j * np.outer(s, within)) * punches[:, None]
            )
            sums[chosen] = parts.imag
    return sums.ravel()


def _punches(load: LineLoad, end: float, order: int) -> tuple[FloatArray, FloatArray]:
    """Radii in m and weights in N/m of punches that stand for a line load in waves up to a wavenumber."""
    unit, rule_weights = gauss(order)
    radii, weights = [np.empty(0)], [np.empty(0)]
    for segment in load.segments:
        extent = abs(segment.extent)
        if segment.breaks is None:
            count = max(2, math.ceil(2.0 * extent * end / _PHASE))
            ends = np.arange(count + 1) / count
            ends = np.unique(np.concatenate([ends, 0.5 ** np.arange(_TIP, 0.0, -1.0) / count]))
        else:
            parts = np.maximum(np.ceil(np.diff(segment.breaks) * end / _PHASE), 1.0).astype(int)
            ends = _divided(segment.breaks / extent, parts)
        half = 0.5 * np.diff(ends)[:, None]
        part, rule = (ends[:-1, None] + half * (unit + 1.0)).ravel(), (half * rule_weights).ravel()
        if segment.breaks is None:
            # with the root of the distance the density at the anchor is bounded
            part, rule = part * part, 2.0 * part * rule
        distance = extent * part
        weights.append(segment.density(distance) * rule * extent)
        radii.append(segment.anchor + math.copysign(1.0, segment.extent) * distance)
    return np.concatenate(radii), np.concatenate(weights)


def _divided(ends: FloatArray, parts: IndexArray) -> FloatArray:
    """Ends of intervals that are divided into equal parts."""
    nth = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    inner = np.repeat(ends[:-1], parts) + np.repeat(np.diff(ends) / parts, parts) * nth
    return np.append(inner, ends[-1])


def interior_of(contact: Contact, surface: Loaded, side: str | None) -> Interior:
    """The body of a side under a surface; see :func:`pymdr.interpretation.interior.stressed_body`."""
    body, sign = stressed_body(contact, side)
    solid = solid_of(body)
    assert solid is not None
    if isinstance(body, Layered):
        return LayeredInterior(surface, solid, sign, layered=body)
    return Interior(surface, solid, sign)
