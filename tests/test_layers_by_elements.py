"""Stress inside a coated half-space by finite elements under the pressure of a contact."""

import numpy as np
import pytest

import pymdr as mdr
from independent.finite_elements import Solid, coated
from pymdr.line.lines import line_of

pytest.importorskip("skfem", reason="scikit-fem of the group test is not installed")

COAT, BASE, THICKNESS = Solid(5.0, 0.25), Solid(1.0, 0.3), 0.8


@pytest.fixture(scope="module")
def contact():
    """A contact of the radius 1 m."""
    body = mdr.Layered([mdr.Layer(mdr.Elastic(*COAT), THICKNESS)], base=mdr.Elastic(*BASE))
    pressed = mdr.Contact(mdr.Paraboloid(10.0), body, mdr.Elastic(4.0, 0.3))
    result = mdr.solve(pressed, mdr.indent(float(line_of(pressed).depth(1.0))))
    assert float(result["contact_radius"][0]) == pytest.approx(1.0, rel=1e-12)
    return result


def differences(contact, halvings, **others):
    """Root mean square over the volume near the contact, relative to the largest pressure, of all components."""

    def pressure(r):
        return contact.field("pressure", r=r.ravel()).values.reshape(r.shape)

    force = float(contact["normal_force"][0])
    result = coated(COAT, BASE, THICKNESS, pressure, force, n=4, halvings=halvings, **others)
    near = (result.r < 2.0) & (result.z < 2.0)
    axes = [np.unique(np.round(one[near], 12), return_inverse=True) for one in (result.r, result.z)]
    (radii, at), (depths, which) = axes
    stress = contact.field("stress", r=radii, z=depths).values[:, which, at]
    weight = result.weight[near]
    mean = (result.stress[:, near] - stress) ** 2 @ weight / weight.sum()
    return np.sqrt(mean) / float(contact["peak_pressure"][0])


def test_finite_elements_converge_to_the_stress_in_a_coat_and_its_base(contact):
    coarse, fine = (differences(contact, halvings) for halvings in (0, 1))
    assert np.all(fine < 1e-3)
    # quadratic elements: stresses of the second order but beside the edge, where they have a root
    assert np.all(np.log2(coarse / fine) > 1.5)


@pytest.mark.long
def test_finer_elements_are_closer(contact):
    medium, fine = (differences(contact, halvings) for halvings in (1, 2))
    assert np.all(fine < 3e-4)
    assert np.all(np.log2(medium / fine) > 1.4)


@pytest.mark.long
def test_the_end_of_the_region_errs_with_the_third_power_of_its_distance_or_so(contact):
    # without the point load at the end it would be the first
    near, middle, far = (differences(contact, 2, far=end)[0] for end in (10.0, 20.0, 80.0))
    left = [np.sqrt(one**2 - far**2) for one in (near, middle)]
    assert np.log2(left[0] / left[1]) > 2.0
