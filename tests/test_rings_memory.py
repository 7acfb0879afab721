"""Contacts with memory by boundary elements on rings: closed forms, springs, orders, scales, forces, refusals."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import dawsn

import pymdr as mdr
from pymdr.errors import PathError, ProblemError
from pymdr.independent import memory_zone
from pymdr.independent.memory import Bodies, follow_rings
from pymdr.independent.memory_zone import Attraction, PulledSetting, follow_pulled
from pymdr.independent.rings import Rings, leading_inverses, ring_displacement, solve_indentation
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import creep, follow_springs
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation

STANDARD = Relaxation(1.2, np.array([2.0, 3.0]), np.array([0.05, 0.4]))
MAXWELL = Relaxation(0.0, np.array([4.0]), np.array([0.4]))
SOLID = mdr.Viscoelastic(mdr.StandardSolid(equilibrium=0.3, modulus=1.0, time=0.4), poisson=0.5)


def followed(profile, body, t, d, *, by_force=False, n=100, parts=60):
    leg = follow_rings(Bodies(profile), body, np.array(t), np.array(d), by_force, None, Rings(n), parts=parts)
    return {
        name: np.array([0.0 if one is None else getattr(one, name) for one in leg.solutions])
        for name in ("force", "contact_radius", "indentation", "energy")
    } | {"leg": leg}


def test_closed_forms_of_approach():
    v, tau, modulus = 0.4, 0.4, 4.0
    t = np.linspace(0.0, 2.0, 4)
    force = followed(mdr.Paraboloid(1.0), MAXWELL, t, v * t)["force"]
    exact = 2.0 * modulus * v**1.5 * tau * (np.sqrt(t) - math.sqrt(tau) * dawsn(np.sqrt(t / tau)))
    assert force == pytest.approx(exact[1:], abs=1e-4 * exact[-1])
    slope = 0.5
    force = followed(mdr.Cone(slope=slope), MAXWELL, t, v * t)["force"]
    exact = 4.0 / (math.pi * slope) * modulus * v**2 * tau * (t + tau * np.expm1(-t / tau))
    assert force == pytest.approx(exact[1:], abs=1e-4 * exact[-1])


def test_the_rebound_of_ting(references):
    entry = references["ting_sls_parab"]
    body = Relaxation(4.0 * entry["inputs"]["Ginf"], np.array([4.0 * entry["inputs"]["G1"]]), np.array([0.4]))
    t = np.array([0.0, *entry["inputs"]["t"]])
    t = np.unique(np.append(t, 1.0))
    own = np.isin(t, entry["inputs"]["t"])[1:]
    rows = followed(mdr.Paraboloid(1.0), body, t, 0.4 * np.where(t <= 1.0, t, 2.0 - t))
    force, radius = np.array(entry["expected"]["F"]), np.array(entry["expected"]["a"])
    assert rows["force"][own] == pytest.approx(force, abs=1e-4 * force.max())
    assert rows["contact_radius"][own] == pytest.approx(radius, abs=1.0 / 100)
    # a Maxwell body loses its contact at tau ln(2 exp(tm / tau) - 1), whatever the profile
    end = 0.4 * math.log(2.0 * math.exp(1.0 / 0.4) - 1.0)
    t = np.array([0.0, 1.0, end - 5e-3, end + 5e-3])
    for profile in (mdr.Paraboloid(1.0), mdr.Cone(slope=0.3)):
        force = followed(profile, MAXWELL, t, 0.1 * np.where(t <= 1.0, t, 2.0 - t), parts=200)["force"]
        assert force[1] > 0.0 == force[2]


def test_a_flat_punch_relaxes_as_its_modulus():
    t = np.array([0.0, 0.0, 0.5, 3.0])
    rows = followed(mdr.FlatPunch(radius=0.5), STANDARD, t, [0.0, 0.1, 0.1, 0.1], n=60)
    assert rows["force"] == pytest.approx(2.0 * 0.5 * 0.1 * STANDARD(t[1:] - 0.0), rel=2e-5)
    assert (rows["contact_radius"] == 0.5).all()
    last = rows["leg"].solutions[-1]
    # p sqrt(a - r) at a sharp edge: F / (2 pi a) / sqrt(2 a)
    exact = last.force / (2.0 * math.pi * 0.5) / math.sqrt(2.0 * 0.5)
    assert last.edge_amplitudes[-1][1] == pytest.approx(exact, rel=1e-3)


def test_without_memory_they_are_the_elastic_rings():
    rows = followed(mdr.Paraboloid(1.0), Relaxation(3.0), [0.0, 1.0, 2.0], [0.0, 0.1, 0.04], n=200)
    for d, force, energy in zip((0.1, 0.04), rows["force"], rows["energy"], strict=True):
        exact = solve_indentation(lambda r: r**2 / 2.0, d, 3.0, max_radius=1.0, n=100)
        assert force == pytest.approx(exact.force, rel=1e-4)
        assert energy == pytest.approx(exact.energy, rel=1e-4)


@st.composite
def bodies(draw):
    n = draw(st.integers(1, 3))
    moduli = np.array([draw(st.floats(0.1, 5.0)) for _ in range(n)])
    times = np.array([10.0 ** draw(st.floats(-1.5, 1.5)) for _ in range(n)])
    return Relaxation(draw(st.sampled_from([0.0, 0.1, 1.0])), moduli, times)


PROFILES = (mdr.Paraboloid(1.0), mdr.Cone(slope=0.3), mdr.PowerLaw(4.0, 0.2, 1.0))


@settings(deadline=None, max_examples=8)
@given(
    body=bodies(),
    profile=st.sampled_from(PROFILES),
    depths=st.lists(st.floats(-0.03, 0.1), min_size=1, max_size=3),
    waits=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
)
def test_against_springs_with_contact_again(body, profile, depths, waits):
    t = np.array([0.0, 1.0, *(1.0 + np.cumsum(10.0 ** np.array(waits[: len(depths)])))])
    d = np.array([0.0, 0.1, *depths])
    rows = followed(profile, body, t, d, n=80, parts=60 * len(d))
    springs = follow_springs(ElasticLine(equivalent_profile(profile), 1.0), body, t, d, n=2000)
    size = springs.force.max()
    assert rows["force"] == pytest.approx(springs.force[1:], abs=3e-4 * size)
    width = springs.contact_radius.max() / 80.0
    assert rows["contact_radius"] == pytest.approx(springs.contact_radius[1:], abs=2.5 * width)
    assert rows["energy"] == pytest.approx(springs.stored[1:], abs=5e-4 * springs.stored.max())


def test_forces_converge_with_the_square_of_step_and_ring():
    t, d = np.array([0.0, 1.0, 1.5, 2.2, 3.0, 3.4]), np.array([0.0, 0.1, 0.1, 0.02, 0.08, 0.0])
    line = ElasticLine(equivalent_profile(mdr.Cone(slope=0.3)), 1.0)
    exact = follow_springs(line, STANDARD, t, d, n=8000).force[1:]
    results = [followed(mdr.Cone(slope=0.3), STANDARD, t, d, n=n, parts=400)["force"] for n in (40, 80, 160)]
    errors = [np.sqrt(np.mean((force - exact) ** 2)) / exact.max() for force in results]
    assert math.log2(errors[0] / errors[2]) / 2.0 > 1.5
    assert errors[2] < 5e-6
    change = [followed(mdr.Cone(slope=0.3), STANDARD, t, d, parts=p)["leg"].change.max() for p in (50, 200)]
    assert math.log2(change[0] / change[1]) / 2.0 > 1.7
    assert abs(results[2] - exact).max() < 1e-5 * exact.max()


@settings(deadline=None, max_examples=6)
@given(c=st.floats(-6.0, 6.0), size=st.floats(-9.0, 0.0), modulus=st.floats(0.0, 12.0))
def test_units_change_nothing_else(c, size, modulus):
    c, size, modulus = 10.0**c, 10.0**size, 10.0**modulus
    t, d = np.array([0.0, 1.0, 1.5, 2.2]), np.array([0.0, 0.1, 0.04, 0.07])
    body = Relaxation(modulus * 1.2, modulus * np.array([2.0, 3.0]), c * np.array([0.05, 0.4]))
    one = followed(mdr.Paraboloid(1.0), STANDARD, t, d, n=40, parts=20)
    other = followed(mdr.Paraboloid(size), body, c * t, size * d, n=40, parts=20)
    assert other["force"] == pytest.approx(one["force"] * modulus * size**2, rel=1e-7)
    assert other["contact_radius"] == pytest.approx(one["contact_radius"] * size, rel=1e-6)


def test_forces_are_followed_by_the_rings_themselves():
    t = np.array([0.0, *np.linspace(0.0, 1.0, 5)])
    for profile in (mdr.Paraboloid(1.0), mdr.Cone(slope=0.3)):
        line = ElasticLine(equivalent_profile(profile), 1.0)
        for force in (0.01 * t, np.append(0.0, np.full(5, 0.01))):
            exact = creep(line, STANDARD, t, force).indentation[1:]
            rows = followed(profile, STANDARD, t, force, by_force=True)
            assert rows["force"] == pytest.approx(force[1:], rel=1e-9)
            assert rows["indentation"] == pytest.approx(exact, abs=1e-4 * exact.max())
    let_go = followed(
        mdr.Paraboloid(1.0), STANDARD, [0.0, 1.0, 1.1, 2.0], [0.0, 0.1, 0.0, 0.0], by_force=True
    )
    assert (let_go["force"][1:] == 0.0).all()
    assert let_go["indentation"][1] > let_go["indentation"][2] > 0.0


@pytest.mark.long
def test_a_deeper_leg_gets_more_rings():
    ball = mdr.Contact(mdr.Paraboloid(1.0), SOLID)
    path = mdr.indent(0.01, duration=0.3, steps=4) >> mdr.indent(0.1, duration=0.5, steps=4)
    result = mdr.verify(ball, path >> mdr.load(0.3, duration=1.0, steps=40), elements=100, steps=4)
    assert result.largest_difference < 1e-3
    assert float(np.nanmax(np.abs(result.data["normal_force_difference"]))) < 1e-4


def test_leading_blocks_of_the_inverses():
    edges = np.linspace(0.0, 1.0, 31)
    matrix = ring_displacement((edges[1:] + edges[:-1]) / 2.0, edges)
    lower, upper = leading_inverses(matrix)
    for m in (1, 7, 30):
        np.testing.assert_allclose(upper[:m, :m] @ lower[:m, :m] @ matrix[:m, :m], np.eye(m), atol=1e-11)


def test_side_by_side():
    ball = mdr.Contact(mdr.Sphere(1.0), SOLID)
    path = (
        mdr.indent(0.1, duration=1.0, steps=8)
        >> mdr.hold(0.5, steps=2)
        >> mdr.indent(-0.02, duration=1.0, steps=8)
        >> mdr.indent(0.08, duration=0.5, steps=8)
    )
    result = mdr.verify(ball, path, elements=100)
    assert result.largest_difference < 1e-4
    assert result.data.sizes["step"] == 5
    assert "indentation_mdr" not in result.data
    assert {"time", "row", "elastic_energy_rings"} <= set(result.data)
    assert float(result.data["pressure_difference"].max()) < 3e-3
    text = result.summary()
    assert "normal force" in text
    assert "time" in text
    assert result.history is not None
    assert result.history.sizes["row"] == 26
    assert len(result.plot().axes) == 6
    rings = mdr.solve(ball, path, solver=Rings(60))
    assert rings.status is mdr.Status.BY_RINGS
    assert rings.claims["pressure"].level is mdr.Level.APPROXIMATE
    gap = rings.field("gap", np.array([0.0, 2.0]) * float(rings["contact_radius"][9]), 9).values
    assert gap[0] == 0.0 < gap[1]
    rings.plot()


@settings(deadline=None, max_examples=4)
@given(decades=st.floats(-12.0, 0.0), equilibrium=st.sampled_from([0.0, 1e-3, 0.1]), steps=st.integers(1, 4))
def test_bodies_that_relax_within_a_step_err_as_claimed(decades, equilibrium, steps):
    gel = mdr.Viscoelastic(mdr.Prony(equilibrium, [1.0], [10.0**decades]), poisson=0.5)
    contact = mdr.Contact(mdr.Paraboloid(1.0), gel)
    path = mdr.indent(0.01, duration=1.0, steps=steps) >> mdr.hold(1.0) >> mdr.indent(0.015, duration=0.3)
    line, rings = mdr.solve(contact, path), mdr.solve(contact, path, solver=Rings(40))
    force, other = line["normal_force"].values, rings["normal_force"].values
    error = float(np.max(rings.claims["normal_force"].error))
    assert np.abs(force - other).max() < (2.0 * error + 2e-4) * force.max()
    assert error < 0.05


def test_what_is_refused():
    ball = mdr.Contact(mdr.Sphere(1.0), SOLID)
    timed = mdr.indent(0.1, duration=1.0)
    with pytest.raises(PathError, match="needs times"):
        mdr.verify(ball, mdr.indent(0.1))
    with pytest.raises(PathError, match="needs times"):
        mdr.solve(ball, mdr.indent(0.1), solver=Rings(50))
    for rings in (0, 10**6):
        with pytest.raises(ProblemError, match="20 to 5000"):
            mdr.verify(ball, timed, elements=rings)
    with pytest.raises(PathError, match="at least 1"):
        mdr.verify(ball, timed, steps=0)
    with pytest.raises(PathError, match="no contact"):
        mdr.verify(ball, mdr.indent(-0.1, duration=1.0))
    liquid = mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 0.1), poisson=0.5)
    with pytest.raises(ProblemError, match="dashpot"):
        mdr.verify(mdr.Contact(mdr.Sphere(1.0), liquid), timed)
    with pytest.raises(PathError):
        mdr.solve(ball, mdr.load(-1.0, duration=1.0), solver=Rings(50))
    elastic = mdr.Elastic(1.0, 0.3)
    for law in ({"adhesion": mdr.DMT(0.01)}, {"friction": mdr.Coulomb(0.3), "adhesion": mdr.JKR(0.01)}):
        with pytest.raises(ProblemError, match="adhesion"):
            mdr.verify(mdr.Contact(mdr.Sphere(1.0), elastic, **law), timed)
    with pytest.raises(ProblemError, match="machine"):
        mdr.solve(ball, mdr.travel(0.1, duration=1.0), solver=Rings(50), machine_stiffness=1.0)


@pytest.mark.parametrize("speed", [0.2, 1.0, 5.0])
def test_a_cohesive_zone_at_three_speeds(speed):
    gel = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid(1.0), gel, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    path = (
        mdr.indent(1.0, steps=10, duration=2.0)
        >> mdr.hold(2.0, steps=4)
        >> mdr.indent(-3.4, steps=88, duration=4.4 / speed)
    )
    result = mdr.verify(probe, path)
    assert result.largest_difference < 1e-3
    assert result.largest_in_history < 1e-3
    assert result.history is not None
    last_attached = [
        np.flatnonzero(result.history[f"normal_force_{method}"].values).max() for method in ("mdr", "rings")
    ]
    assert abs(last_attached[0] - last_attached[1]) <= 1


def test_rings_of_a_cohesive_zone_have_fields_and_their_error():
    gel = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid(1.0), gel, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    path = mdr.indent(0.2, steps=2, duration=1.0) >> mdr.indent(-0.2, steps=2, duration=1.0)
    rings, line = (mdr.solve(probe, path, solver=solver) for solver in (Rings(80), None))
    a, c = (float(rings[name][1]) for name in ("contact_radius", "cohesive_radius"))
    pressure = rings.field("pressure", np.array([0.0, 0.5 * (a + c), 1.01 * c]), 1).values
    np.testing.assert_array_equal(pressure[1:], [-2.0, 0.0])
    expected = float(line.field("pressure", np.zeros(1), 1)[0])
    assert pressure[0] == pytest.approx(expected, rel=5e-3)
    assert float(rings.field("gap", np.array([c]), 1)[0]) == pytest.approx(0.5, rel=2e-2)
    off = np.abs(rings["normal_force"].values - line["normal_force"].values).max()
    largest = np.abs(rings["normal_force"].values).max()
    assert off / largest < 2.0 * float(rings.claims["normal_force"].error.max()) < 0.02
    with pytest.raises(ProblemError, match="covers"):
        mdr.solve(probe, path, solver=Rings(20))


def test_dead_loads_on_a_cohesive_zone_are_followed_by_rings():
    gel = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid(1.0), gel, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    path = mdr.load(0.5, steps=2, duration=1.0) >> mdr.load(0.0, steps=2, duration=1.0)
    rings, line = (mdr.solve(probe, path, solver=one)["indentation"].values for one in (Rings(80), None))
    np.testing.assert_allclose(rings, line, atol=5e-3 * np.abs(line).max())


@pytest.mark.parametrize("rheology", [mdr.PowerLawRheology(1.0, 1.0, 0.2), mdr.Maxwell(1.0, 1.0)])
def test_a_cohesive_zone_on_a_body_that_flows_agrees_with_the_line(rheology):
    body = mdr.Viscoelastic(rheology, poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid(1.0), body, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    path = mdr.indent(0.2, steps=2, duration=1.0)
    rings, line = (mdr.solve(probe, path, solver=one)["normal_force"].values for one in (Rings(100), None))
    np.testing.assert_allclose(rings, line, atol=5e-3 * np.abs(line).max())


def test_a_cohesive_zone_on_a_body_that_is_rigid_at_once_is_refused():
    body = mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 1.0), poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid(1.0), body, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    for solver in (Rings(80), None):
        with pytest.raises(ProblemError, match="use StandardSolid"):
            mdr.solve(probe, mdr.indent(0.2, steps=2, duration=1.0), solver=solver)


def test_forces_of_a_cohesive_zone_converge_with_the_square_of_step_and_ring(monkeypatch):
    t = np.array([0.0, 1.5, 2.0, 2.25, 2.5, 2.75])
    d = np.array([-0.6, 0.2, 0.2, 0.0, -0.2, -0.4])
    body = Relaxation(1.0, np.array([9.0]), np.array([1.0]))

    def forces(step, n=60):
        """Rows of steps in which the end of the zone moves by a part of its width."""
        monkeypatch.setattr(memory_zone, "_MOVED", step * n)
        setting = PulledSetting(Bodies(mdr.Paraboloid(1.0)), body, Attraction(2.0, 0.5), False, Rings(n))
        return np.array([one.force for one in follow_pulled(setting, t, d, None).solutions])

    def order(rows):
        """By the differences of three resolutions, each the half of the last."""
        one, other = (np.sqrt(np.mean((a - b) ** 2)) for a, b in pairwise(rows))
        return math.log2(one / other)

    assert 1.6 < order([forces(step) for step in (0.1, 0.05, 0.025)]) < 2.6
    assert 1.5 < order([forces(0.013, n) for n in (40, 80, 160)]) < 2.6


def test_a_soft_adhesive_case_is_verified_from_the_shell(tmp_path, shell):
    case = tmp_path / "soft.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "standard_solid", equilibrium = "10 kPa", modulus = "30 kPa", time = "1 s" }\n'
        '[adhesion]\nkind = "maugis_dugdale"\nwork = "50 mJ/m^2"\nrange = "20 um"\n'
        '[[path]]\nkind = "indent"\nindentation = "20 um"\nduration = "2 s"\nsteps = 4\n'
        '[[path]]\nkind = "hold"\nduration = "2 s"\n'
        '[[path]]\nkind = "indent"\nindentation = "-30 um"\nduration = "3 s"\nsteps = 8\n'
    )
    status, out, _ = shell("verify", case, "-o", tmp_path / "v", "--rings", "200", "--json")
    assert status == 0
    assert 0.0 < json.loads(out)["verification"]["largest_difference"] < 1e-3
    assert (tmp_path / "v" / "verify.png").stat().st_size > 10_000
