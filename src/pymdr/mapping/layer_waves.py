"""Plane waves inside a stack of layers: the states at any depth under a pressure wave on the surface.

In the layer i a wave of the wavenumber k has the state (u_z, u_x, pressure, shear), the displacements in units of p / (2 G_i k)
and the tractions -s_zz and s_xz in units of the pressure p on the surface. In the top layer a state is counted without that of a
half-space of its material, so that it decays like exp(-k (2 h - z)); below like exp(-k z).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pymdr.mapping.layers import generator
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic
from pymdr.units import FloatArray

_THIN = 1.0
"""Wavenumber times thickness below which a layer is solved by its state at mid-depth, above by waves from its two faces."""
_BLOCK = 1 << 21
"""Largest number of matrix entries of systems solved together."""
_UZ, _UX, _PRESSURE, _SHEAR = range(4)


@dataclass(frozen=True)
class _Medium:
    """The waves of one material, in its own units."""

    poisson: float

    @cached_property
    def growth(self) -> FloatArray:
        """A, with which a state grows upward as exp(A k y)."""
        return generator(1.0, self.poisson)

    @cached_property
    def upward(self) -> FloatArray:
        """States that grow upward as e^(k y), shape (4, 2)."""
        return _null_space(self.growth - np.eye(4))

    @cached_property
    def downward(self) -> FloatArray:
        """States that grow downward."""
        return _null_space(self.growth + np.eye(4))

    def below_top(self, t: FloatArray) -> FloatArray:
        """The states growing upward at a distance t = k y below the place where they are given, shape (n, 4, 2)."""
        rate = self.upward - self.growth @ self.upward
        return np.asarray(np.exp(-t)[:, None, None] * (self.upward + t[:, None, None] * rate))

    def above_bottom(self, t: FloatArray) -> FloatArray:
        """The states growing downward at a distance t above the place where they are given."""
        rate = self.downward + self.growth @ self.downward
        return np.asarray(np.exp(-t)[:, None, None] * (self.downward + t[:, None, None] * rate))

    def across(self, t: FloatArray) -> FloatArray:
        """exp(A t), shape (n, 4, 4)."""
        cosh, sinh = np.cosh(t), np.sinh(t)
        third = 0.5 * (t * cosh - sinh)
        parts = np.stack([cosh - 0.5 * t * sinh, sinh - third, 0.5 * t * sinh, third])
        powers = np.stack([np.linalg.matrix_power(self.growth, n) for n in range(4)])
        return np.asarray(np.einsum("kn,kij->nij", parts, powers))

    def states(self, k: FloatArray, thickness: float, height: float) -> FloatArray:
        """Four independent states of a layer at a height above its lower face, shape (n, 4, 4)."""
        thin = k * thickness < _THIN
        near = np.where(thin, k, 0.0)
        waves = (self.below_top(k * (thickness - height)), self.above_bottom(k * height))
        return np.where(
            thin[:, None, None],
            self.across(near * (height - 0.5 * thickness)),
            np.concatenate(waves, axis=2),
        )

    def faces(
        self, t: FloatArray, coefficients: FloatArray
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """The waves from both faces of a layer of the thickness t = k h, from the coefficients of its :meth:`states`."""
        both = np.concatenate([self.upward, self.downward], axis=1)
        thin = t < _THIN
        parts = np.where(thin, np.linalg.solve(both, coefficients.T), coefficients.T)
        half = np.where(thin, 0.5 * t, 0.0)
        amplitudes = []
        for sign, waves in ((1.0, self.upward @ parts[:2]), (-1.0, self.downward @ parts[2:])):
            rate = waves - sign * (self.growth @ waves)
            # states at mid-depth, seen from the face at which the wave is largest
            size = np.exp(half)
            amplitudes.append((size * (waves - half * rate), size * rate))
        return amplitudes[0], amplitudes[1]


def _null_space(shifted: FloatArray) -> FloatArray:
    """States that the square of a matrix makes 0, orthonormal, shape (4, 2)."""
    return np.asarray(np.linalg.svd(shifted @ shifted)[2][2:].T)


@dataclass(frozen=True)
class StackWaves:
    """
    The states of a layered body under waves of the pressure 1 on its surface.

    Parameters
    ----------
    k : ndarray
        Wavenumbers in 1/m, above 0, shape (n,).

    Notes
    -----
    Every layer has four independent states and an elastic base two. Their coefficients satisfy the conditions at the surface, at
    the interfaces and at the base; waves are measured from the face at which they are largest, so no exponential overflows.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer
    >>> film = StackWaves(Layered([Layer(Elastic(1.0, 0.5), 1.0)]), np.array([1.0]))
    >>> film.surface_ratio().round(9).tolist()
    [0.240581681]
    """

    body: Layered
    k: FloatArray

    @cached_property
    def _media(self) -> tuple[_Medium, ...]:
        return tuple(_Medium(solid.poisson) for solid in self.body.solids)

    @cached_property
    def _base(self) -> _Medium | None:
        return _Medium(self.body.base.poisson) if isinstance(self.body.base, Elastic) else None

    @cached_property
    def tops(self) -> tuple[float, ...]:
        """Depths in m of the upper faces of the layers and of the base."""
        thicknesses = [layer.thickness for layer in self.body.layers]
        return tuple(math.fsum(thicknesses[:i]) for i in range(len(thicknesses) + 1))

    def half_space(self, depth: float) -> FloatArray:
        """The state of a half-space of the top layer, shape (4, n)."""
        top = self._media[0]
        loaded = top.upward @ np.linalg.solve(top.upward[_PRESSURE:], [1.0, 0.0])
        t = self.k * depth
        rate = loaded - top.growth @ loaded
        return np.asarray(np.exp(-t) * (loaded[:, None] + rate[:, None] * t))

    def states(self, layer: int, depth: float, part: slice = slice(None)) -> FloatArray:
        """
        The states at a depth, in the top layer without those of the half-space.

        Parameters
        ----------
        layer : int
            From 0; the number of layers for the base.
        depth : float
            In m, in that layer.
        part : slice, optional
            Of the wavenumbers; all unless given.

        Returns
        -------
        ndarray
            Shape (4, n).
        """
        k, below = self.k[part], depth - self.tops[layer]
        falling, rising = self._faces[layer]
        t = k * below
        state = np.exp(-t) * (falling[0][:, part] + t * falling[1][:, part])
        if rising is not None:
            t = k * (self.body.layers[layer].thickness - below)
            state += np.exp(-t) * (rising[0][:, part] + t * rising[1][:, part])
        return np.asarray(state)

    @cached_property
    def _faces(self) -> list[tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray] | None]]:
        """Of every layer the waves that decay from its upper face, e^(-t) (u + t v), and from its lower one; u and v of shape (4, n)."""
        faces: list[tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray] | None]] = []
        for i, (layer, medium) in enumerate(zip(self.body.layers, self._media, strict=True)):
            faces.append(medium.faces(self.k * layer.thickness, self._coefficients[:, 4 * i : 4 * i + 4]))
        if self._base is not None:
            waves = self._base.upward @ self._coefficients[:, -2:].T
            faces.append(((waves, waves - self._base.growth @ waves), None))
        return faces

    def surface_ratio(self) -> FloatArray:
        """The displacement of the surface over that of a half-space of the top layer, L(k h)."""
        half = self.half_space(0.0)[_UZ]
        return np.asarray((self.states(0, 0.0)[_UZ] + half) / half)

    @cached_property
    def _coefficients(self) -> FloatArray:
        """Those of the independent states, layer by layer, shape (n, unknowns)."""
        unknowns = 4 * len(self._media) + (0 if self._base is None else 2)
        block = max(1, _BLOCK // unknowns**2)
        parts = [self._solved(self.k[i : i + block], unknowns) for i in range(0, self.k.size, block)]
        return np.concatenate(parts)

    def _solved(self, k: FloatArray, unknowns: int) -> FloatArray:
        layers, media = self.body.layers, self._media
        matrix, right = np.zeros((k.size, unknowns, unknowns)), np.zeros((k.size, unknowns, 1))
        top = media[0].states(k, layers[0].thickness, layers[0].thickness)
        matrix[:, :2, :4] = top[:, _PRESSURE:]
        pressing = StackWaves(self.body, k).half_space(layers[0].thickness).T
        row = 2
        for i, (layer, medium) in enumerate(zip(layers, media, strict=True)):
            above = medium.states(k, layer.thickness, 0.0)
            last = i + 1 == len(layers)
            if last and self._base is None:
                kept = (_UZ, _UX) if self.body.bond == "bonded" else (_UZ, _SHEAR)
                matrix[:, row : row + 2, 4 * i : 4 * i + 4] = above[:, kept]
                if i == 0:
                    right[:, row : row + 2, 0] = -pressing[:, kept]
                return np.asarray(np.linalg.solve(matrix, right)[:, :, 0])
            other: FloatArray
            if last:
                assert self._base is not None
                assert isinstance(self.body.base, Elastic)
                other, shear = self._base.below_top(np.zeros(k.size)), self.body.base.shear
            else:
                other = media[i + 1].states(k, layers[i + 1].thickness, layers[i + 1].thickness)
                shear = self.body.solids[i + 1].shear
            # displacements in units of the softer of the two, for entries of one size
            own = self.body.solids[i].shear
            softer = min(own, shear)
            sizes = [np.array([softer / one] * 2 + [1.0, 1.0])[:, None] for one in (own, shear)]
            rows = slice(row, row + 4)
            matrix[:, rows, 4 * i : 4 * i + 4] = sizes[0] * above
            matrix[:, rows, 4 * i + 4 : 4 * i + 4 + other.shape[2]] = -sizes[1] * other
            if i == 0:
                right[:, rows, 0] = -pressing * sizes[0][:, 0]
            if last and self.body.bond == "frictionless":
                # the displacement along the interface jumps, and neither side bears shear
                matrix[:, row + _UX] = 0.0
                matrix[:, row + _UX, 4 * i : 4 * i + 4] = above[:, _SHEAR]
                right[:, row + _UX, 0] = -pressing[:, _SHEAR] if i == 0 else 0.0
                matrix[:, row + _SHEAR, 4 * i : 4 * i + 4] = 0.0
                right[:, row + _SHEAR, 0] = 0.0
            row += 4
        return np.asarray(np.linalg.solve(matrix, right)[:, :, 0])
