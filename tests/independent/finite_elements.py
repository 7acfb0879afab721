"""Stress under a known pressure on a coated half-space by axisymmetric finite elements: no line, no waves, no potentials.

Quadratic quadrilaterals on a net of radii and depths that is graded toward the edge of the pressure. The region ends at a
distance L, where it moves like the base under a point load (Boussinesq), because a fixed end would err as a/L.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Solid(NamedTuple):
    """A material."""

    young: float
    poisson: float

    @property
    def shear(self):
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def lame(self):
        return 2.0 * self.shear * self.poisson / (1.0 - 2.0 * self.poisson)


class Solved(NamedTuple):
    """Stresses at the quadrature points of all elements, shape (elements, points)."""

    r: np.ndarray
    z: np.ndarray
    stress: np.ndarray
    """rr, tt, zz, rz, shape (4, elements, points)."""
    weight: np.ndarray
    """Volume of each point over 2 pi."""


def _toward(low, high, n, where):
    """Lines between two ends, each interval 1.5 times the one before from the end `where` on."""
    steps = 1.5 ** np.arange(n)
    steps = np.cumsum(steps if where == "low" else steps[::-1])
    return low + (high - low) * np.append(0.0, steps / steps[-1])


def net(thickness, far, n):
    """Radii and depths of the lines for a pressure on the radius 1; n intervals on each stretch."""
    outer = np.geomspace(2.0, far, round(0.7 * n * np.log2(far)))
    radii = np.concatenate([_toward(0.0, 1.0, n, "high"), _toward(1.0, 2.0, n, "low")[1:], outer[1:]])
    deep = thickness + np.append(
        0.0, np.geomspace(0.1, far - thickness, round(0.7 * n * np.log2(far / 0.1) / 2))
    )
    return radii, np.concatenate([_toward(0.0, thickness, n, "low"), deep[1:]])


def _halved(lines):
    return np.sort(np.concatenate([lines, 0.5 * (lines[1:] + lines[:-1])]))


def boussinesq(solid, force, r, z):
    """Displacements u_r and u_z of a half-space under a point load."""
    distance = np.hypot(r, z)
    size = force / (4.0 * np.pi * solid.shear)
    outward = r * z / distance**3 - (1.0 - 2.0 * solid.poisson) * r / (distance * (distance + z))
    return size * outward, size * (z * z / distance**3 + 2.0 * (1.0 - solid.poisson) / distance)


def coated(coat, base, thickness, pressure, force, *, far=40.0, n=6, halvings=0):
    """
    The stress under a pressure on the radius 1 of a coated half-space.

    Parameters
    ----------
    coat, base : Solid
    thickness : float
    pressure : callable
        Of an array of radii.
    force : float
        Its resultant.
    far : float
        Distance of the end of the region.
    n, halvings : int
        Intervals on a stretch of the net, and how often all are halved.
    """
    from skfem import (
        Basis,
        BilinearForm,
        ElementQuad2,
        ElementVector,
        FacetBasis,
        LinearForm,
        MeshQuad,
        condense,
        solve,
    )
    from skfem.helpers import ddot, div, sym_grad

    radii, depths = net(thickness, far, n)
    for _ in range(halvings):
        radii, depths = _halved(radii), _halved(depths)
    mesh = MeshQuad.init_tensor(radii, depths)
    element = ElementVector(ElementQuad2())
    basis = Basis(mesh, element, intorder=5)

    def of(name, z):
        return np.where(z < thickness, getattr(coat, name), getattr(base, name))

    @BilinearForm
    def stiffness(u, v, w):
        r, z = w.x
        strain, other = sym_grad(u), sym_grad(v)
        hoop, hoop_v = u[0] / r, v[0] / r
        shear = 2.0 * of("shear", z) * (ddot(strain, other) + hoop * hoop_v)
        return r * (shear + of("lame", z) * (div(u) + hoop) * (div(v) + hoop_v))

    @LinearForm
    def loading(v, w):
        return pressure(w.x[0]) * v[1] * w.x[0]

    loaded = mesh.facets_satisfying(lambda x: (x[1] == 0.0) & (x[0] < 1.0), boundaries_only=True)
    right = loading.assemble(FacetBasis(mesh, element, facets=loaded, intorder=12))
    places = basis.doflocs
    computed = np.zeros(basis.N)
    axis = basis.get_dofs(lambda x: x[0] == 0.0).all("u^1")
    end = basis.get_dofs(lambda x: (x[0] >= far * (1 - 1e-12)) | (x[1] >= far * (1 - 1e-12)))
    for i, name in enumerate(("u^1", "u^2")):
        some = end.all(name)
        computed[some] = boussinesq(base, force, *places[:, some])[i]
    computed[axis] = 0.0
    fixed = np.unique(np.concatenate([axis, end.all()]))
    computed = solve(*condense(stiffness.assemble(basis), right, x=computed, D=fixed))
    return _stress(basis, computed, coat, base, thickness)


def _stress(basis, result, coat, base, thickness):
    from skfem.helpers import sym_grad

    u = basis.interpolate(result)
    r, z = basis.global_coordinates()
    strain = sym_grad(u)
    hoop = np.asarray(u)[0] / r
    shear, lame = (
        np.where(z < thickness, getattr(coat, name), getattr(base, name)) for name in ("shear", "lame")
    )
    trace = lame * (strain[0, 0] + strain[1, 1] + hoop)
    stress = np.array(
        [
            trace + 2.0 * shear * strain[0, 0],
            trace + 2.0 * shear * hoop,
            trace + 2.0 * shear * strain[1, 1],
            2.0 * shear * strain[0, 1],
        ]
    )
    return Solved(r, z, stress, basis.dx * r)
