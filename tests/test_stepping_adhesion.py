"""Steps of contacts with adhesion: branches, jumps and energies of solve, closed forms, rest of an edge, and refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.drawing import examples

import pymdr as mdr
from pymdr.line.adhesion import jkr_force
from pymdr.units import to_si

YOUNG = 4e4


def waves(size):
    """Waves on a paraboloid, over which the edge jumps."""
    height, wave = 3e-4 * size, 150.0 / size
    return mdr.Function(
        lambda r: r**2 / (2.0 * size) + height * (1.0 - np.cos(wave * r)),
        derivative=lambda r: r / size + height * wave * np.sin(wave * r),
        max_radius=0.3 * size,
    )


PROFILES = [
    lambda r: mdr.Paraboloid(r),
    lambda r: mdr.Cone(slope=0.05),
    lambda r: mdr.FlatPunch(0.03 * r),
    lambda r: mdr.RoundedFlat(0.03 * r, r),
    waves,
]


def gel(profile, law, young=YOUNG):
    return mdr.Contact(profile, mdr.Elastic(young, 0.5), adhesion=law)


def random_depths(seed, size, deepest, off):
    """Steps of all sizes between a distance beyond pull-off and the largest depth."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(0.0, 0.1, size) * 10.0 ** rng.integers(-4, 1, size)
    folded = np.abs(np.mod(np.cumsum(steps) + 1.0, 4.0) - 2.0) - 1.0
    return np.where(folded > 0.0, folded * deepest, folded * off)


def compared(contact, deepest, depth):
    names = ("normal_force", "contact_radius", "elastic_energy", "surface_energy", "dissipated_energy")
    stepper, rows, jumped = mdr.Stepper(contact, deepest), [], []
    for d in depth.tolist():
        stepper.advance(d)
        jumped.append(stepper.jumped)
        rows.append([getattr(stepper, name) for name in names])
    result = mdr.solve(contact, mdr.Path(indentation=depth))
    assert np.array_equal(jumped, result["jumped"].values)
    for name, column in zip(names, np.transpose(rows), strict=True):
        exact = result[name].values
        assert column == pytest.approx(exact, abs=1e-13 * np.abs(exact).max()), name
    assert (stepper.contact_radius > 0.0) == (result.status is mdr.Status.ATTACHED)
    return result


@given(
    seed=st.integers(0, 1000),
    size=st.floats(-9.0, 0.0).map(lambda x: 10.0**x),
    make=st.sampled_from(PROFILES),
    stickiness=st.floats(-2.0, 0.3).map(lambda x: 10.0**x),
    hysteresis=st.sampled_from([1.0, 1.5, 40.0]),
)
@settings(max_examples=examples(18), deadline=None)
def test_steps_are_those_of_solve(seed, size, make, stickiness, hysteresis):
    deepest = 1e-3 * size
    work = stickiness * YOUNG * deepest**2 / (2.0 * math.pi * 0.03 * size)
    contact = gel(make(size), mdr.JKR(work, work_receding=hysteresis * work))
    off = 3.0 * math.sqrt(stickiness * hysteresis) * deepest
    compared(contact, deepest, random_depths(seed, 120, deepest, off))


@pytest.mark.parametrize(
    "law",
    [mdr.MaugisDugdale(0.05, 5e3), mdr.DMT(5e-4), mdr.Capillary(humidity=0.5)],
    ids=lambda law: type(law).__name__,
)
def test_other_laws(law):
    profile = mdr.Paraboloid("1 um") if isinstance(law, mdr.Capillary) else mdr.Paraboloid("1 mm")
    young, deepest = (1e9, 1e-8) if isinstance(law, mdr.Capillary) else (YOUNG, 2e-5)
    compared(gel(profile, law, young), deepest, random_depths(1, 200, deepest, 3.0 * deepest))


def test_layers():
    layer = mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.4), "0.5 mm")], mdr.Elastic("50 MPa", 0.3))
    contact = mdr.Contact(mdr.Paraboloid("5 mm"), layer, adhesion=mdr.JKR(0.1))
    compared(contact, 1e-5, random_depths(2, 200, 1e-5, 2e-5))


def test_the_branch_in_contact_is_the_closed_form():
    stepper = mdr.Stepper(gel(mdr.Paraboloid("1 mm"), mdr.JKR(0.05)), "20 um")
    modulus = YOUNG / 0.75
    scale = (math.pi * 0.05 * 1e-6 / (8.0 * modulus)) ** (2.0 / 3.0) / 1e-3
    assert stepper.advance(-1e-9).normal == 0.0
    depth = np.linspace(20e-6, -3.0 * scale * (1.0 - 1e-9), 200)
    force = [stepper.advance(d).normal for d in depth]
    assert force == pytest.approx(jkr_force(depth, 1e-3, modulus, 0.05), abs=1e-7 * max(force))
    assert force[:-1] == pytest.approx(jkr_force(depth[:-1], 1e-3, modulus, 0.05), abs=2e-13 * max(force))
    assert stepper.advance(-3.0 * scale * (1.0 + 1e-9)).normal == 0.0


def test_an_edge_rests_as_the_reference_says():
    """R = E* = 1, works 0.2 and 1: the loop in three parts, and the turn at the largest depth."""
    contact = mdr.Contact(
        mdr.Paraboloid(1.0), mdr.Elastic(0.75, 0.5), adhesion=mdr.JKR(0.2, work_receding=1.0)
    )
    stepper = mdr.Stepper(contact, 1.0)
    losses = []
    stepper.advance(0.0)
    losses.append(stepper.dissipated_energy)
    stepper.advance(1.0)
    radius = stepper.contact_radius
    assert radius == pytest.approx(1.54740521, abs=1e-8)
    # at rest the force is linear in the indentation
    assert stepper.advance(-0.7236509).normal == pytest.approx(-4.70969863, abs=1e-7)
    assert stepper.contact_radius == pytest.approx(radius, rel=1e-14)
    assert stepper.normal_stiffness == pytest.approx(2.0 * radius, rel=1e-12)
    stepper.advance(-5.0)
    losses.append(stepper.dissipated_energy - losses[0])
    assert losses == pytest.approx([0.4390065784, 0.6738808596 + 6.0179416057], rel=1e-9)


@pytest.mark.parametrize(
    "law", [mdr.JKR(0.01), mdr.JKR(0.01, work_receding=0.4)], ids=["plain", "hysteresis"]
)
def test_many_contacts_are_each_like_one(law):
    contact = gel(mdr.Paraboloid("1 mm"), law)
    depth = np.stack([random_depths(seed, 60, 2e-5, 6e-5) for seed in range(5)])
    many = mdr.Stepper(contact, "20 um", count=5)
    forces = np.array([many.advance(row).normal for row in depth.T])
    one = mdr.Stepper(contact, "20 um")
    fresh = one.state
    for i in range(5):
        one.restore(fresh)
        assert [one.advance(d).normal for d in depth[i].tolist()] == forces[:, i].tolist()
        assert many.dissipated_energy[i] == one.dissipated_energy
    many.undo()
    last = many.advance(depth[:, -1])
    assert last.normal.tolist() == forces[-1].tolist()
    assert not last.tangential.any()


@pytest.mark.parametrize("rows", [2, 2500])
def test_a_flat_that_nearly_parted_advances_without_a_jump(rows):
    flat, receding = 5e-4, 2e-3
    worn = mdr.TruncatedParaboloid(radius="1 mm", flat_radius=flat)
    contact = gel(worn, mdr.JKR(1e-3, work_receding=receding))
    parts = -math.sqrt(2.0 * math.pi * flat * receding / (YOUNG / 0.75))
    down = np.linspace(1e-5, parts * (1.0 - 1e-15), rows)
    depth = np.concatenate([[0.0], down, np.linspace(down[-1], 1e-5, rows)[1:]])
    stepper, jumps = mdr.Stepper(contact, "20 um"), 0
    for d in depth.tolist():
        stepper.advance(d)
        jumps += stepper.jumped
    result = mdr.solve(contact, mdr.Path(indentation=depth))
    assert stepper.contact_radius > flat
    assert (jumps, np.count_nonzero(result["jumped"].values)) == (1, 1)
    assert stepper.dissipated_energy == pytest.approx(float(result["dissipated_energy"][-1]), rel=1e-9)


def test_work_is_stored_or_lost():
    """The work of fine steps by the trapezoidal rule, without the jumps, in which the indentation rests."""
    stepper = mdr.Stepper(gel(mdr.Paraboloid("1 mm"), mdr.JKR(0.02, work_receding=0.06)), "20 um")
    depth = np.concatenate([np.linspace(-1e-6, 2e-5, 4001), np.linspace(2e-5, -8e-5, 20001)])
    force = np.array([stepper.advance(d).normal for d in depth])
    work = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(depth)))
    assert stepper.contact_radius == 0.0
    assert work == pytest.approx(stepper.dissipated_energy, rel=1e-4)


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (
            mdr.Contact(
                mdr.Paraboloid(1.0), mdr.Layered([mdr.Layer(mdr.Elastic(1.0, 0.3), 1.0)], mdr.Rigid())
            ),
            "layered bodies",
        ),
    ],
)
def test_refusals(contact, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.Stepper(contact, "1 um")


def test_a_state_beyond_the_limit_leaves_the_contact():
    stepper = mdr.Stepper(gel(mdr.Paraboloid("1 mm"), mdr.JKR(0.05)), "1 um")
    stepper.advance(1e-6)
    for depth, words in ((2e-6, "deeper than"), (math.nan, "finite"), (-math.inf, "finite")):
        with pytest.raises(mdr.PathError, match=words):
            stepper.advance(depth)
    assert stepper.indentation == 1e-6
    assert stepper.claims["normal_force"].level is mdr.Level.EXACT


def test_a_repeated_row_has_the_stiffness_of_the_row_before():
    """Also where the edge recedes: in the last row of a motion, to rounding, it would else be at rest."""
    contact = gel(mdr.Paraboloid("1 mm"), mdr.JKR(0.02, work_receding=0.06))
    depth = np.repeat([5e-6, 1e-5, -5e-6, -2e-5, -4e-6, 8e-6], 2)
    stepper, results = mdr.Stepper(contact, "20 um"), []
    for d in depth:
        stepper.advance(d)
        results.append(stepper.normal_stiffness)
    solved = mdr.solve(contact, mdr.Path(indentation=depth))["normal_stiffness"].values
    assert results == pytest.approx(solved, rel=1e-12)
    assert results[::2] == results[1::2]


@pytest.mark.parametrize("d", [0.0, 5e-324, -5e-324, -1e-300, 1e-310])
@pytest.mark.parametrize("law", [mdr.JKR(0.02), mdr.JKR(0.02, work_receding=0.06), mdr.DMT(0.02)])
def test_a_depth_that_is_0_in_a_path_touches(d, law):
    """The bodies stayed apart at depths below 0 that are rounded to it."""
    contact = gel(mdr.Paraboloid("1 mm"), law)
    result = mdr.solve(contact, mdr.Path(indentation=[-1e-6, d]))
    one, several, compiled = (mdr.Stepper(contact, "20 um", count=n) for n in (1, 2, 2))
    forces = one.advance(d).normal, *several.advance(d).normal
    step, body, states = compiled.compiled()
    forces = (*forces, step(body, states, 0, d, 0.0)[1])
    assert forces == pytest.approx([float(result["normal_force"][-1])] * 4, rel=1e-13)
    assert one.status is result.status is mdr.Status.ATTACHED
    assert one.branch == several.branch[0] == compiled.branch[0] == 0


def test_a_zone_that_has_not_grown_has_no_table():
    """The first states of a search are all at the edge of the table, whose width is then 0."""
    law = mdr.MaugisDugdale(0.006128911150823574, strength=369.6341367687448)
    contact = mdr.Contact(
        mdr.Paraboloid(0.005666071540462577), mdr.Elastic(63692.39500933277, 0.3), adhesion=law
    )
    assert mdr.Stepper(contact, 1.2936499679221672e-06).advance(1e-6).normal < 0.0


def test_energies_of_a_sharp_edge_belong_to_the_depth_itself():
    """E* a d^2 of a punch, which the parameter of a table missed by its own rounding."""
    contact = mdr.Contact(mdr.FlatPunch("259 um"), mdr.Elastic("1 GPa", 0.3), adhesion=mdr.JKR("1.2 mJ/m^2"))
    depths = 1e-6 * np.random.default_rng(4).uniform(-0.02, 1.0, 200)
    stepper = mdr.Stepper(contact, "1 um", count=200)
    stepper.advance(1e-9)
    stepper.advance(depths)
    stored = 1e9 / (1.0 - 0.3**2) * 259e-6 * depths**2
    attached = stepper.branch >= 0
    assert attached.sum() > 150
    assert np.abs(stepper.elastic_energy - stored)[attached].max() < 1e-13 * stored.max()


@pytest.mark.parametrize(
    "law",
    [
        mdr.JKR("1 mJ/m^2"),
        mdr.JKR("1 mJ/m^2", work_receding="2 mJ/m^2"),
        mdr.MaugisDugdale("1 mJ/m^2", range="1 nm"),
    ],
)
def test_energies_of_a_punch_far_shallower_than_its_radius_belong_to_the_depth_itself(law):
    """E* a d^2, by steps and by solve: the parameter beyond a sharp edge holds a depth to the rounding of the edge only."""
    contact = mdr.Contact(mdr.FlatPunch("1 m"), mdr.Elastic("1 GPa", 0.3), adhesion=law)
    depths = 1e-8 * np.random.default_rng(3).uniform(0.0, 1.0, 40)
    stored = 1e9 / (1.0 - 0.3**2) * 1.0 * depths**2
    stepper = mdr.Stepper(contact, 1e-8)
    stepped = [(stepper.advance(depth), float(stepper.elastic_energy))[1] for depth in depths.tolist()]
    np.testing.assert_allclose(stepped, stored, rtol=2e-15)
    result = mdr.solve(contact, mdr.Path(indentation=depths))
    np.testing.assert_allclose(result["elastic_energy"].values, stored, rtol=2e-15)


def test_the_energy_of_a_pull_on_a_punch_far_shallower_than_its_radius_belongs_to_the_depth_itself():
    """-pull d, where F + pull = 2 E* a d."""
    punch, body = mdr.FlatPunch("1 m"), mdr.Elastic("1 GPa", 0.3)
    contact = mdr.Contact(punch, body, adhesion=mdr.DMT("1 mJ/m^2", range="0.3 nm"))
    depths = 1e-8 * np.random.default_rng(3).uniform(0.0, 1.0, 40)
    result = mdr.solve(contact, mdr.Path(indentation=depths))
    elastic = 2e9 / (1.0 - 0.3**2) * depths
    pull = float(np.median(elastic - result["normal_force"].values))
    assert pull > 1e3 * elastic.max()
    np.testing.assert_allclose(result["surface_energy"].values, -pull * depths, rtol=1e-14)
    np.testing.assert_allclose(result["elastic_energy"].values, 0.5 * elastic * depths, rtol=2e-15)


@pytest.mark.parametrize("radius", ["1 nm", "898 nm", "4.6 mm"])
def test_a_rigid_touch_has_no_radius(radius):
    """Tables gave radii of 1e-29 m, where a stiffness, too, must be a number."""
    stepper = mdr.Stepper(gel(mdr.Sphere(radius), mdr.DMT("1 mJ/m^2")), 0.01 * to_si(radius, "m"))
    for depth in (0.003 * stepper.max_indentation, 0.0):
        stepper.advance(depth)
    assert (stepper.contact_radius, stepper.elastic_energy, stepper.normal_stiffness) == (0.0, 0.0, 0.0)
