"""Forces of layered bodies in fits: one table for all thicknesses and moduli of the same ratios."""

from __future__ import annotations

import numpy as np
import pytest

import pymdr as mdr
from pymdr.solving.fits.forces import bare_forces

TIPS = (mdr.Paraboloid("5 um"), mdr.Cone(slope=0.2), mdr.PowerLaw(3.3, "1 um", "5 um"))


@pytest.mark.parametrize("seed", range(4))
def test_forces_on_layers_are_those_of_solve(seed):
    rng = np.random.default_rng(seed)
    young, thickness = 10.0 ** rng.uniform(3.0, 9.0), 10.0 ** rng.uniform(-7.0, -3.0)
    layers = [mdr.Layer(mdr.Elastic(young, rng.uniform(0.0, 0.5)), thickness)]
    if seed % 2:
        layers.append(mdr.Layer(mdr.Elastic(3.0 * young, 0.3), 2.0 * thickness))
    base = mdr.Elastic(10.0 * young, 0.2) if seed % 2 else mdr.Rigid()
    tip = [*TIPS, TIPS[0] + TIPS[1]][seed]
    other = mdr.Elastic(5.0 * young, 0.4) if seed == 3 else mdr.Rigid()
    contact = mdr.Contact(tip, mdr.Layered(layers, base), other)
    depth = np.array([0.03, 0.1, 0.2]) * thickness
    solved = mdr.solve(contact, mdr.Path(indentation=depth))
    forces = bare_forces(contact, float(depth[-1]))
    force, stiffness = forces.at(depth)
    assert force == pytest.approx(solved["normal_force"].values, rel=1e-9)
    assert stiffness == pytest.approx(solved["normal_stiffness"].values, rel=1e-9)
    assert forces.radius(depth) == pytest.approx(solved["contact_radius"].values, rel=1e-9)
