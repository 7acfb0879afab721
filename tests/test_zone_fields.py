"""Fields and dissipation of a cohesive zone on bodies with memory: the elastic law, the force, creep, and the balance of energies."""

import math

import numpy as np
import pytest
import scipy

import pymdr as mdr
from pymdr.numerics.quadrature import gauss

BALL = mdr.Paraboloid(1.0)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
"""E* relaxes from 10 to 1 Pa in 1 s."""


def contact(strength, profile=BALL, body=RUBBER):
    return mdr.Contact(profile, body, adhesion=mdr.MaugisDugdale(1.0, strength=strength))


PRESS = mdr.Path(time=np.linspace(0.0, 2.0, 11), indentation=np.linspace(-1.0, 1.0, 11)) >> mdr.hold("1e4 s")


@pytest.fixture(scope="module")
def retraction():
    """Ten times the equilibrium modulus at once; the contact of rows 20 ... 60 is far from both limits."""
    return mdr.solve(contact(2.0), PRESS >> mdr.indent(-3.0, steps=100, duration=8.0))


def radii(result, row):
    return (float(result[name][row]) for name in ("contact_radius", "cohesive_radius"))


def test_at_rest_the_fields_are_those_of_the_relaxed_modulus(retraction):
    relaxed = mdr.solve(contact(2.0, body=mdr.Elastic(0.75, 0.5)), mdr.indent(1.0))
    a, c = radii(relaxed, 0)
    r = np.concatenate(
        [a * np.linspace(0.0, 0.999, 40), np.linspace(a, c, 20)[1:-1], c * np.linspace(1.001, 2.0, 20)]
    )
    for name in ("pressure", "normal_displacement", "gap", "spring_force"):
        soft, elastic = (
            result.field(name, r, row).values for result, row in ((retraction, 11), (relaxed, 0))
        )
        assert soft == pytest.approx(elastic, abs=2e-6 * np.abs(elastic).max())
    with pytest.raises(mdr.NotValidError, match="not computed"):
        retraction.field("von_mises", [0.0], 11, z=[a])


def test_without_relaxation_the_fields_are_those_of_the_instantaneous_modulus():
    body = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1e9), poisson=0.5)
    path = mdr.indent(-0.95, duration=1.0) >> mdr.indent(0.8, steps=8, duration=2.0)
    soft = mdr.solve(contact(2.0, body=body), path)
    stiff = mdr.solve(contact(2.0, body=mdr.Elastic(7.5, 0.5)), mdr.indent(0.8))
    a, c = radii(stiff, 0)
    # the pressure has the slope of a root at a
    r = np.concatenate([a * np.linspace(0.0, 0.99, 40), a + (c - a) * np.linspace(0.02, 0.98, 20)])
    for name in ("pressure", "normal_displacement", "gap"):
        elastic = stiff.field(name, r, 0).values
        assert soft.field(name, r).values == pytest.approx(elastic, abs=5e-6 * np.abs(elastic).max())


@pytest.mark.parametrize("row", [3, 8, 20, 40, 55])
def test_the_pressure_carries_the_force_and_the_gap_at_the_rim_is_the_range(retraction, row):
    a, c = radii(retraction, row)
    force = -math.pi * 2.0 * (c - a) * (c + a)
    if a > 0.0:
        # many, since the pressure has a logarithm where the contact began by a jump
        angle = 0.5 * math.pi * (np.arange(1500) + 0.5) / 1500
        p = retraction.field("pressure", a * np.sin(angle), row).values
        force += math.pi**2 * a * a * np.mean(p * np.sin(angle) * np.cos(angle))
    largest = np.abs(retraction["normal_force"].values).max()
    assert force == pytest.approx(float(retraction["normal_force"][row]), abs=1e-6 * largest)
    zone = a + (c - a) * np.array([1e-6, 1e-3, 0.1, 0.5, 0.9, 1.0])
    gap = retraction.field("gap", zone, row).values
    assert np.all(gap > -1e-9)
    assert gap[-1] == pytest.approx(0.5, rel=1e-3)
    u = retraction.field("normal_displacement", zone, row).values
    d = float(retraction["indentation"][row])
    assert BALL.gap(zone) - d + u == pytest.approx(gap, abs=1e-6)
    if a > 0.0:
        edge = retraction.field("pressure", a * np.array([1.0 - 1e-12, 1.0]), row).values
        assert edge == pytest.approx(-2.0, abs=1e-4)


def test_the_displacement_is_the_creep_under_the_history_of_pressure():
    """Boltzmann's integral over the pressures of all rows, by the kernel of the half-space in space, beyond the widest zone."""
    times = np.array([1e-4, *np.linspace(0.1, 4.0, 40)])
    depths = np.interp(times, [0.0, 2.0, 4.0], [-0.4, 0.6, -0.3])
    result = mdr.solve(contact(2.0), mdr.Path(time=times, indentation=depths))
    radius = 1.3 * float(result["cohesive_radius"].max())
    t, weights = gauss(40)
    elastic = []
    for row in range(times.size):
        a, c = radii(result, row)
        assert c > 0.0
        total = 0.0
        for low, high in ((0.0, a), (a, c)):
            # points gather at the edge of the contact, where the pressure is a root
            s = low + (high - low) * np.sin(0.5 * math.pi * t) if low == 0.0 else low + (high - low) * t
            jacobian = (high - low) * (0.5 * math.pi * np.cos(0.5 * math.pi * t) if low == 0.0 else 1.0)
            kernel = s / (radius + s) * scipy.special.ellipk(4.0 * radius * s / (radius + s) ** 2)
            total += np.sum(weights * jacobian * result.field("pressure", s, row).values * kernel)
        elastic.append(4.0 / math.pi * total)
    curve = scipy.interpolate.PchipInterpolator(times, elastic)
    for row in (10, 25, 40):
        s = np.linspace(times[0], times[row], 4001)
        compliance = 1.0 - 0.9 * np.exp(-(times[row] - s) / 10.0)
        creep_indentation = elastic[0] * compliance[0] + np.trapezoid(compliance * curve.derivative()(s), s)
        u = float(result.field("normal_displacement", [radius], row)[0])
        assert u == pytest.approx(creep_indentation, rel=2e-3)


def test_fields_of_saved_results_and_of_shorter_paths_are_the_same(retraction, tmp_path):
    retraction.save(tmp_path / "soft.nc")
    kept = mdr.open_result(tmp_path / "soft.nc")
    r = np.linspace(0.0, 3.0, 30)
    shorter = mdr.solve(contact(2.0), PRESS >> mdr.indent(-1.0, steps=50, duration=4.0))
    for name in ("pressure", "gap"):
        values = retraction.field(name, r, 61).values
        assert np.array_equal(kept.field(name, r, 61).values, values)
        assert shorter.field(name, r, -1).values == pytest.approx(values, rel=1e-4, abs=1e-5)
    claim = retraction.claims["pressure"]
    assert claim.where.all()
    assert claim.error[40] < 2e-3
    assert set(retraction.figures(step=40)) == {"section", "loop", "radius", "history", "fields"}


@pytest.mark.parametrize(
    ("profile", "strength", "limit"),
    [(BALL, 2.0, 2e-4), (mdr.Cone(slope=1.0), 20.0, 1e-4), (mdr.Cone(slope=1.0), 3.0, 2e-4)],
)
def test_the_balance_of_energies_closes(profile, strength, limit):
    """The dissipation in the body is a sum of squares; work, stored energy and jumps have integrals of their own."""
    path = (
        mdr.indent(0.8, steps=20, duration=2.0)
        >> mdr.hold("5 s", steps=5)
        >> mdr.indent(-4.0, steps=60, duration=10.0)
    )
    result = mdr.solve(contact(strength, profile), path)
    spent, stored, surface, work, jumps = (
        result[name].values
        for name in (
            "dissipated_energy",
            "elastic_energy",
            "surface_energy",
            "external_work",
            "jump_dissipation",
        )
    )
    assert np.all(np.diff(spent) - jumps[1:] >= 0.0)
    off = work - stored - surface - spent
    assert np.abs(off).max() < limit * np.abs(work).max()
    claim = result.claims["dissipated_energy"]
    assert np.all(np.abs(off) <= claim.error * np.abs(spent) + 1e-15)
    # also before the retraction, where little has been dissipated
    assert np.all(claim.error[2:25] < 5e-3)
    (balance,) = (one for one in result.assumptions if one.name == "energy balance")
    assert balance.met
    assert balance.measure < limit


def test_a_torn_contact_has_no_fields_and_a_force_curve_none():
    path = mdr.load(0.0, duration=1.0) >> mdr.load(-30.0, steps=30, duration=20.0)
    torn = mdr.solve(contact(2.0), path)
    with pytest.raises(mdr.NotValidError, match="not valid"):
        torn.field("gap", step=-1)
    assert float(torn.field("pressure", [0.0], 1)[0]) > 0.0
    with pytest.raises(mdr.QuantityError, match="friction"):
        torn.field("shear_traction")
