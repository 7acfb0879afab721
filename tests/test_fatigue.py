"""Fatigue over a cycle: closed cases, planes and places by brute force, scaling, bad input."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.interpretation.cycles import dang_van, normal_stress, shear_amplitude, smallest_ball
from pymdr.interpretation.planes import PlaneMeasure, largest_on_planes

STEEL = mdr.Elastic("210 GPa", 0.3)
E, NU = 210e9, 0.3
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.5))
FINDLEY = PlaneMeasure(lambda shear, tension, strain: shear + 0.3 * tension, sheared=True)
SWT = PlaneMeasure(
    lambda shear, tension, strain: np.maximum(tension, 0.0) * strain, sheared=False, poisson=NU, young=E
)


def random_cycle(seed, rows=12, points=1):
    return np.cumsum(np.random.default_rng(seed).normal(size=(rows, 6, points)), axis=0)


@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 5), st.integers(2, 30), st.sampled_from([1e-12, 1.0, 1e9]))
def test_a_smallest_ball_encloses_all_and_its_centre_lies_among_its_carriers(seed, k, n, size):
    p = size * np.random.default_rng(seed).normal(size=(n, k, 3))
    centre, radius = smallest_ball(p)
    distance = np.sqrt(np.sum((p - centre) ** 2, axis=1))
    assert np.all(distance <= radius * (1.0 + 1e-9))
    for i in range(3):
        # no direction leads away from all points on the ball
        on_it = (p[distance[:, i] > radius[i] * (1.0 - 1e-7), :, i] - centre[:, i]) / radius[i]
        trial = np.random.default_rng(seed).normal(size=(k, 500))
        assert np.all((on_it @ trial).min(axis=0) <= 1e-6)


def test_smallest_balls_of_known_points():
    line = np.zeros((9, 5, 1))
    line[:, 2, 0] = np.linspace(-1.0, 3.0, 9)
    centre, radius = smallest_ball(line)
    assert centre[2, 0] == pytest.approx(1.0, abs=1e-15)
    assert radius[0] == pytest.approx(2.0, rel=1e-15)
    simplex = np.eye(6)[:, :, None]  # six corners, at sqrt(5/6) from their middle
    assert smallest_ball(simplex)[1][0] == pytest.approx(math.sqrt(5.0 / 6.0), rel=1e-13)
    assert smallest_ball(np.ones((4, 5, 2)))[1].tolist() == [0.0, 0.0]


def test_uniaxial_and_torsional_cycles():
    tension = np.zeros((5, 6, 1))
    tension[:, 0, 0] = [0.0, 100.0, 0.0, -100.0, 0.0]
    value, plane = largest_on_planes(FINDLEY, tension)
    # half the amplitude times k + sqrt(1 + k^2)
    assert value[0] == pytest.approx(50.0 * (0.3 + math.sqrt(1.09)), rel=1e-9)
    assert abs(plane[0, 0]) == pytest.approx(math.cos(0.5 * math.atan(1.0 / 0.3)), abs=1e-5)
    value, plane = largest_on_planes(SWT, tension)
    assert value[0] == pytest.approx(100.0**2 / E, rel=1e-9)
    assert abs(plane[0, 0]) == pytest.approx(1.0, abs=1e-7)
    assert dang_van(tension, 0.3)[0][0] == pytest.approx(50.0 + 0.3 * 100.0 / 3.0, rel=1e-13)
    torsion = np.zeros((3, 6, 1))
    torsion[:, 4, 0] = [0.0, 80.0, -80.0]
    assert dang_van(torsion, 0.3)[0][0] == pytest.approx(80.0, rel=1e-13)
    assert largest_on_planes(FINDLEY, torsion)[0][0] == pytest.approx(80.0 * math.sqrt(1.09), rel=1e-9)
    # of a pulsating one, a mean shear stress does not count
    assert dang_van(torsion + 30.0 * np.eye(6)[4][None, :, None], 0.3)[0][0] == pytest.approx(80.0, rel=1e-13)


def turned(cycle, rotation):
    xx, yy, zz, xz, xy, yz = np.moveaxis(cycle, 1, 0)
    whole = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    t = np.einsum("ia,jb,abnm->ijnm", rotation, rotation, whole)
    return np.moveaxis(np.array([t[0, 0], t[1, 1], t[2, 2], t[0, 2], t[0, 1], t[1, 2]]), 0, 1)


@pytest.mark.parametrize("seed", range(4))
def test_criteria_do_not_depend_on_the_axes(seed):
    cycle = random_cycle(seed, points=2)
    rotation = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    other = turned(cycle, rotation)
    np.testing.assert_allclose(dang_van(other, 0.3)[0], dang_van(cycle, 0.3)[0], rtol=1e-9)
    for measure in (FINDLEY, SWT):
        one, two = largest_on_planes(measure, cycle), largest_on_planes(measure, other)
        np.testing.assert_allclose(one[0], two[0], rtol=1e-8)


def cycle_of_kind(seed):
    """Random rows, a loop of one frequency, or a proportional cycle about a mean, of any size."""
    rng = np.random.default_rng(seed)
    rows, kind = int(rng.integers(2, 14)), int(rng.integers(3))
    if kind == 0:
        cycle = rng.normal(size=(rows, 6, 1))
    elif kind == 1:
        phase = (np.arange(rows) * 2.0 * math.pi / rows)[:, None, None]
        mean, along, across = rng.normal(size=(3, 6, 1))
        cycle = mean + np.cos(phase) * along + np.sin(phase) * across
    else:
        cycle = rng.normal(size=(1, 6, 1)) * rng.uniform(-1.0, 1.0, (rows, 1, 1)) + rng.normal(size=(1, 6, 1))
    return cycle * 10.0 ** rng.uniform(-2.0, 9.0)


@settings(max_examples=examples(24), deadline=None)
@given(st.integers(0, 2**32 - 1))
@example(173)  # several planes almost as bad as the worst
@example(359)
def test_no_plane_is_worse_than_the_worst(seed):
    cycle = cycle_of_kind(seed)
    size = float(np.max(np.abs(cycle)))
    fatemi_socie = PlaneMeasure(lambda s, n, e: s * (1.0 + 2.0 * np.maximum(n, 0.0) / size), sheared=True)
    n = np.arange(4000)
    z = (n + 0.5) / n.size
    turn, flat = n * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt(1.0 - z * z)
    planes = np.array([flat * np.cos(turn), flat * np.sin(turn), z])
    for measure in (FINDLEY, SWT, fatemi_socie):
        value, _ = largest_on_planes(measure, cycle)
        dense = measure.on(np.broadcast_to(cycle, (*cycle.shape[:2], n.size)), planes)
        near = planes[:, np.argsort(dense)[-4:]]
        polished, _ = measure.best(np.tile(cycle, (1, 1, 4)), near, 0.02)
        assert float(polished.max()) <= float(value[0]) * (1.0 + 1e-8)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("measure", [FINDLEY, SWT])
def test_the_worst_plane_is_that_of_a_dense_search(measure, seed):
    cycle = random_cycle(seed)
    value, plane = largest_on_planes(measure, cycle)
    n = np.arange(20000)
    z = (n + 0.5) / n.size
    turn, flat = n * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt(1.0 - z * z)
    planes = np.array([flat * np.cos(turn), flat * np.sin(turn), z])
    dense = measure.on(np.broadcast_to(cycle, (*cycle.shape[:2], n.size)), planes).max()
    assert value[0] * (1.0 - 1e-3) < dense < value[0] * (1.0 + 1e-12)
    assert measure.on(cycle, plane)[0] == pytest.approx(value[0], rel=1e-12)


def test_stresses_of_a_plane():
    cycle = random_cycle(3)
    normal = np.array([[1.0], [2.0], [2.0]]) / 3.0
    xx, yy, zz, xz, xy, yz = cycle[:, :, 0].T
    vectors = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).T @ normal[:, 0]
    across = vectors @ normal[:, 0]
    np.testing.assert_allclose(normal_stress(cycle, normal)[:, 0], across, rtol=1e-13)
    shear = vectors - across[:, None] * normal[:, 0]
    distance = np.linalg.norm(shear[:, None] - shear, axis=2)
    assert shear_amplitude(cycle, normal)[0] == pytest.approx(0.5 * distance.max(), rel=1e-13)


@pytest.fixture(scope="module")
def sliding():
    """A ball that slides to and fro."""
    return mdr.solve(BALL, mdr.load("100 N") >> mdr.cycle(shift="30 um", cycles=2, steps=16))


def test_full_slip_has_hamiltons_values_at_the_edge(sliding):
    p0, a = float(sliding["peak_pressure"][-1]), float(sliding["contact_radius"][-1])
    along, across = 0.5 * p0 * math.pi * (4.0 + NU) / 8.0, 0.5 * p0 * math.pi * 3.0 * NU / 8.0
    hertz = (1.0 - 2.0 * NU) * p0 / 3.0
    worst = mdr.fatigue(sliding, criterion=mdr.SmithWatsonTopper())
    assert worst.value == pytest.approx((along + hertz) * (along - NU * across) / E, rel=1e-8)
    assert (abs(worst.x), worst.y, worst.z) == pytest.approx((a, 0.0, 0.0), rel=1e-4, abs=1e-4 * a)
    assert abs(worst.plane[0]) == pytest.approx(1.0, abs=1e-6)
    # the mean normal stress of the pressure vanishes there: its radial and hoop stresses cancel
    worst = mdr.fatigue(sliding, criterion=mdr.DangVan(0.3, "100 MPa"))
    assert worst.value == pytest.approx(0.5 * along + 0.3 * (along + across) / 3.0, rel=1e-8)
    assert float(worst["fatigue_ratio"]) == worst.value / 100e6
    assert worst.rows == tuple(range(9, 17))


def test_the_place_is_that_of_a_dense_map(sliding):
    result = mdr.solve(
        BALL, mdr.load("100 N") >> mdr.cycle(normal_force="60 N", tangential_force="15 N", steps=16)
    )
    a = float(result["contact_radius"].max())
    for criterion in (mdr.DangVan(0.1), mdr.SmithWatsonTopper()):
        worst = mdr.fatigue(result, criterion=criterion)
        around = np.linspace(-0.3, 0.3, 9) * a
        x = np.append(np.linspace(-1.3, 1.3, 27) * a, worst.x + around)
        near = worst.field(
            x=x, y=[0.0, 0.3 * a, worst.y], z=np.append(np.linspace(0, 1.0, 11), worst.z / a) * a
        )
        assert worst.value * (1.0 - 1e-9) <= float(near.max()) <= worst.value * (1.0 + 1e-8)


def test_stress_does_not_depend_on_the_size():
    values = []
    for size in (1e-9, 10.0):
        ball = mdr.Contact(mdr.Paraboloid(size), STEEL, STEEL, friction=mdr.Coulomb(0.5))
        force = 1e6 * size**2
        path = mdr.load(force) >> mdr.cycle(tangential_force=0.3 * force, steps=8)
        worst = mdr.fatigue(mdr.solve(ball, path), criterion=mdr.FatemiSocie(1.0, "500 MPa"))
        values.append([worst.value, abs(worst.x) / size, worst.z / size])
    np.testing.assert_allclose(values[1], values[0], rtol=1e-7, atol=1e-9)


def test_a_bulk_stress_in_phase_alone(sliding):
    light = mdr.solve(BALL, mdr.load("1 mN") >> mdr.cycle(tangential_force="0.01 mN", steps=8))
    wave = light["tangential_force"] / 1e-5
    bulk = 2e9 * wave.values
    free = mdr.fatigue(light, criterion=mdr.SmithWatsonTopper(), superposed={"xx": bulk})
    assert free.value == pytest.approx(bulk.max() ** 2 / E, rel=0.1)
    assert free.value > bulk.max() ** 2 / E
    deep = free.field(x=[0.0], y=[0.0], z=["1 mm"])
    assert float(deep[0, 0, 0]) == pytest.approx(bulk.max() ** 2 / E, rel=1e-4)
    lowered = mdr.fatigue(sliding, criterion=mdr.SmithWatsonTopper(), superposed={"xx": "-500 MPa"})
    assert lowered.value < mdr.fatigue(sliding, criterion=mdr.SmithWatsonTopper()).value


def test_the_parameters_of_ruiz_by_brute_force():
    result = mdr.solve(BALL, mdr.load("100 N") >> mdr.cycle(tangential_force="35 N", cycles=2, steps=16))
    rows = list(range(9, 17))
    a = float(result["contact_radius"][-1])
    r = np.linspace(0.6, 1.0, 400, endpoint=False) * a
    traction, slip = (result.field(name, r, rows).values for name in ("shear_traction", "slip"))
    work = np.abs(traction).max(axis=0) * 0.5 * np.ptp(slip, axis=0)
    study = mdr.fatigue(result, criterion=mdr.RuizWork("50 N/m"))
    assert work.max() <= study.value * (1.0 + 1e-10)
    assert study.value == pytest.approx(work.max(), rel=1e-4)
    tension = np.array(
        [result.field("stress", x=-r, z=[0.0], step=i).sel(component="xx").values[0] for i in rows]
    )
    damage = work * tension.max(axis=0).clip(0.0)
    study = mdr.fatigue(result, criterion=mdr.RuizDamage())
    assert damage.max() <= study.value * (1.0 + 1e-9)
    assert study.value == pytest.approx(damage.max(), rel=1e-3)
    assert study.field(y=[0.0]).sizes["z"] == 1
    assert study.z == 0.0


def test_a_frictionless_cycle_of_load():
    ball = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL)
    result = mdr.solve(ball, mdr.load("50 N") >> mdr.cycle(normal_force="50 N", steps=8))
    worst = mdr.fatigue(result, criterion=mdr.Findley(0.0))
    largest = float(result["largest_shear"].max())
    assert worst.value == pytest.approx(0.5 * largest, rel=1e-8)
    assert worst.z / float(result["contact_radius"].max()) == pytest.approx(0.4809, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"criterion": "dang van"}, "criterion = 'dang van'"),
        ({"steps": [3]}, "at least 2 rows"),
        ({"steps": [0, 99]}, "from 0 to 16"),
        ({"superposed": {"xx": [1.0, 2.0]}}, "17 rows"),
        ({"superposed": {"rr": "1 MPa"}}, "components by name"),
        ({"side": "top"}, "'body' or 'counterbody'"),
    ],
)
def test_bad_input_is_refused_with_its_remedy(sliding, change, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.fatigue(sliding, **({"criterion": mdr.SmithWatsonTopper()} | change))


def test_what_is_not_known_is_refused():
    path = mdr.load("1 N") >> mdr.cycle(normal_force="0.5 N", steps=4)
    dry = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), STEEL), path)
    with pytest.raises(mdr.NotValidError, match="without friction"):
        mdr.fatigue(dry, criterion=mdr.RuizWork())
    punch = mdr.solve(mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), path)
    with pytest.raises(mdr.NotValidError, match="round the edge"):
        mdr.fatigue(punch, criterion=mdr.SmithWatsonTopper())
    coat = mdr.Layered([mdr.Layer(STEEL, "1 mm")], base=mdr.Elastic("70 GPa", 0.3))
    coated = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), coat), path)
    with pytest.raises(mdr.NotValidError, match="not in layers"):
        mdr.fatigue(coated, criterion=mdr.DangVan(0.3))
    with pytest.raises(mdr.PymdrError, match="yield_strength"):
        mdr.FatemiSocie(1.0, "0 MPa")


CASE = """
title = "fretting"
[profile]
kind = "sphere"
radius = "10 mm"
[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
[friction]
kind = "coulomb"
coefficient = 0.5
[[path]]
kind = "load"
normal_force = "100 N"
[[path]]
kind = "cycle"
tangential_force = "30 N"
steps = 8
"""


def test_fatigue_from_the_shell(tmp_path, shell):
    case = tmp_path / "joint.toml"
    case.write_text(CASE)
    options = (
        "--criterion",
        "dang-van",
        "--slope",
        "0.3",
        "--limit",
        "250 MPa",
        "--bulk-amplitude",
        "80 MPa",
    )
    status, out, _ = shell("fatigue", case, *options, "-o", tmp_path / "out")
    assert status == 0
    assert "Dang Van's stress" in out
    assert "over the endurance limit" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["fatigue.csv", "fatigue.png"]
    for wrong, words in (
        (("--criterion", "dang-van"), "give --slope"),
        (("--criterion", "ruiz-work", "--slope", "1"), "leave --slope out"),
        (("--criterion", "goodman"), "one of dang-van"),
        (("--criterion", "findley", "--slope", "0.3", "--limit", "1 mm"), "Pa"),
        (("--criterion", "findley", "--slope", "-1"), "at least 0"),
    ):
        status, _, error = shell("fatigue", case, *wrong)
        assert status != 0
        assert words in error
