"""A cohesive zone on bodies with memory against converged references, elastic limits and its own balance."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import beta

import pymdr as mdr
from drawing import examples, first_of
from pymdr.errors import PathError, ProblemError
from pymdr.units import metres, newtons
from pymdr.workbench.casefile import read_case

BALL = mdr.Paraboloid(1.0)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
"""E* relaxes from 10 to 1 Pa in 1 s."""


def contact(strength, profile=BALL, body=RUBBER):
    return mdr.Contact(profile, body, adhesion=mdr.MaugisDugdale(1.0, strength=strength))


def approach(depth):
    """From beyond the range of the stress to a depth, and long at rest there."""
    steps = np.linspace(-1.0, depth, 11)
    return mdr.Path(time=np.linspace(0.0, 2.0, 11), indentation=steps) >> mdr.hold("1e4 s")


@pytest.mark.parametrize(
    ("name", "span", "tolerance"),
    [("s2_v0.1", 5.0, 2e-5), ("s2_v1", 1.5, 2e-4), ("s6_v10", 1.0, 1e-3)],
)
def test_retraction_at_a_speed(references, name, span, tolerance):
    entry = references[f"visco_md_{name}"]
    speed, expected = entry["inputs"]["v"], entry["expected"]
    path = approach(1.0) >> mdr.indent(1.0 - span, steps=250, duration=span / speed)
    result = mdr.solve(contact(entry["inputs"]["sigma0"]), path)
    force, depth = result["normal_force"].values, result["indentation"].values
    row = int(np.argmin(force))
    assert force[row] == pytest.approx(expected["F_min"], rel=tolerance)
    # the claim covers the error
    claimed = float(result.claims["normal_force"].error[row])
    assert abs(force[row] / expected["F_min"] - 1.0) < 2.0 * claimed + 1e-5
    attached = result["cohesive_radius"].values > 0.0
    last = depth[np.flatnonzero(attached)[-1]]
    assert last - 1.1 * span / 250 < expected["d_lost"] + 5e-4
    assert last > expected["d_lost"] - 5e-4
    assert result.status is mdr.Status.PULLED_OFF


def test_rest_is_the_relaxed_contact(references):
    """After long rest Maugis' elastic contact of the relaxed modulus; a, c, F by an independent solution."""
    result = mdr.solve(contact(2.0), approach(1.0))
    relaxed = mdr.solve(contact(2.0, body=mdr.Elastic(0.75, 0.5)), mdr.indent(1.0))
    for name, value in (
        ("contact_radius", 2.072530),
        ("cohesive_radius", 2.230269),
        ("normal_force", -2.487948),
    ):
        assert float(relaxed[name][0]) == pytest.approx(value, abs=1e-6)
        assert float(result[name][-1]) == pytest.approx(float(relaxed[name][0]), rel=2e-6)
    for name in ("elastic_energy", "surface_energy"):
        assert float(result[name][-1]) == pytest.approx(float(relaxed[name][0]), rel=1e-4)


def test_a_fast_path_is_that_of_the_instantaneous_modulus():
    fast = np.array([0.2, 0.6, 1.0])
    times = 1e-7 * np.array([0.0, 1.0, 2.0, 3.0])
    soft = mdr.solve(contact(6.0), mdr.Path(time=times, indentation=[-1.0, *fast]))
    stiff = mdr.solve(contact(6.0, body=mdr.Elastic(7.5, 0.5)), mdr.Path(indentation=fast))
    for name in ("normal_force", "contact_radius", "cohesive_radius"):
        assert soft[name].values[1:] == pytest.approx(stiff[name].values, rel=1e-5)


def test_spreading_without_load(references):
    entry = references["visco_md_spreading_s2"]
    times = np.array([1e-4, *entry["inputs"]["t"]])
    result = mdr.solve(contact(2.0), mdr.Path(time=times, normal_force=np.zeros(4)))
    a = result["contact_radius"].values
    assert a[0] == pytest.approx(0.9343032, rel=1e-3)
    assert a[1:] == pytest.approx(entry["expected"]["a"], rel=1e-3)


def test_energies_and_similarity():
    """Energy is dissipated, never gained; lengths, moduli and times scale."""
    path = approach(0.8) >> mdr.indent(-2.0, steps=60, duration=3.0)
    result = mdr.solve(contact(3.0), path)
    spent = result["dissipated_energy"].values
    assert np.all(np.diff(spent) > -1e-4 * spent[-1])
    separated = result["cohesive_radius"].values[-1] == 0.0
    assert separated
    size, modulus, slow = 1e-6, 1e6, 100.0
    small = mdr.Contact(
        mdr.Paraboloid(size),
        mdr.Viscoelastic(mdr.StandardSolid(0.25 * modulus, 2.25 * modulus, slow), poisson=0.5),
        adhesion=mdr.MaugisDugdale(modulus * size, strength=3.0 * modulus),
    )
    steps = np.linspace(-1.0, 0.8, 11)
    scaled = (
        mdr.Path(time=slow * np.linspace(0.0, 2.0, 11), indentation=size * steps)
        >> mdr.hold(1e4 * slow)
        >> mdr.indent(-2.0 * size, steps=60, duration=3.0 * slow)
    )
    same = mdr.solve(small, scaled)["normal_force"].values / (modulus * size**2)
    # the steps adapt, so that rounding changes them within their error
    assert same == pytest.approx(result["normal_force"].values, rel=2e-5, abs=1e-4)


def test_a_machine_pulls_between_both_controls():
    path = mdr.Path(time=[0.0, 1.0, 100.0], travel=[-1.0, 0.5, 0.5]) >> mdr.travel(
        -6.0, steps=100, duration=10.0
    )
    result = mdr.solve(contact(2.0), path, machine_stiffness=5.0)
    d, force, travel = (result[name].values for name in ("indentation", "normal_force", "travel"))
    assert travel == pytest.approx(d + force / 5.0, rel=1e-12)
    assert result.status is mdr.Status.PULLED_OFF
    assert force.min() < -1.5 * math.pi


def test_a_case_its_figures_and_what_is_refused(tmp_path):
    file = tmp_path / "soft.toml"
    file.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n'
        '[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "standard_solid", equilibrium = "10 kPa", modulus = "30 kPa", time = "1 s" }\n'
        '[adhesion]\nkind = "maugis_dugdale"\nwork = "50 mJ/m^2"\nrange = "5 um"\n'
        '[[path]]\nkind = "indent"\nindentation = "20 um"\nsteps = 10\nduration = "2 s"\n'
        '[[path]]\nkind = "indent"\nindentation = "-150 um"\nsteps = 60\nduration = "10 s"\n'
    )
    case = read_case(file)
    result = mdr.solve(case.contact, case.path)
    assert result.status is mdr.Status.PULLED_OFF
    drawn = result.figures()
    assert set(drawn) == {"section", "loop", "radius", "history", "fields"}
    (area,) = drawn["loop"].axes[0].patches
    assert f"work of the loop {1e9 * float(result['external_work'][-1]):.4g} nJ" in area.get_label()
    x, y = area.get_xy().T  # in um and uN, with rows 2 um apart
    enclosed = 1e-12 * 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    assert enclosed == pytest.approx(float(result["external_work"][-1]), rel=0.05)
    result.plot()
    result.save(tmp_path / "soft.nc")
    assert mdr.open_result(tmp_path / "soft.nc").contact == case.contact
    with pytest.raises(PathError, match="duration"):
        mdr.solve(contact(2.0), mdr.indent(1.0))
    with pytest.raises(ProblemError, match="no limit of short range"):
        mdr.Contact(BALL, RUBBER, adhesion=mdr.JKR(1.0))
    with pytest.raises(ProblemError, match="too short"):
        mdr.solve(contact(500.0), mdr.indent(1.0, duration=1.0))
    rigid = mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 1.0), poisson=0.5)
    with pytest.raises(ProblemError, match="needs an infinite force"):
        mdr.solve(contact(2.0, body=rigid), mdr.indent(1.0, duration=1.0))
    with pytest.raises(PathError, match="cannot be pulled"):
        mdr.solve(contact(2.0), mdr.load(-1.0, duration=1.0))
    record = mdr.MeasuredCurve(force=np.arange(9.0), indentation=np.arange(9.0), time=np.arange(9.0))
    with pytest.raises(ProblemError, match="begins in contact"):
        mdr.fit(contact(2.0), record, ["adhesion.work"])


def test_a_dead_load_tears_the_contact_off():
    path = (
        mdr.load(0.0, duration=1.0)
        >> mdr.load(5.0, steps=10, duration=2.0)
        >> mdr.load(-30.0, steps=60, duration=20.0)
    )
    result = mdr.solve(contact(2.0), path)
    force, spent = result["normal_force"].values, result["dissipated_energy"].values
    known = np.isfinite(force)
    assert not known[-1]
    assert result.claims["dissipated_energy"].where.tolist() == known.tolist()
    assert np.all(np.diff(spent[known]) > -1e-3 * np.nanmax(spent))
    assert -30.0 < np.nanmin(force) < -1.5 * math.pi


def test_loops_before_the_surface_has_recovered(references):
    """A cone by an independent solution, and cycles with repeated contact."""
    expected = references["visco_md_cone"]["expected"]
    cone = contact(2.0, mdr.Cone(slope=1.0))
    result = mdr.solve(cone, approach(0.5) >> mdr.indent(-4.5, steps=300, duration=50.0))
    assert result["normal_force"].values.min() == pytest.approx(expected["F_min"], rel=1e-4)
    assert float(result["normal_force"][11]) == pytest.approx(expected["F_start"], rel=1e-5)
    assert float(result["contact_radius"][11]) == pytest.approx(expected["a_start"], rel=1e-5)
    cycles = approach(1.0)
    for target, steps, seconds in ((-5.0, 100, 2.0), (0.2, 40, 1.0), (-5.0, 100, 20.0)):
        cycles = cycles >> mdr.indent(target, steps=steps, duration=seconds)
    again = mdr.solve(contact(2.0), cycles)
    spent = again["dissipated_energy"].values
    assert np.all(np.diff(spent) > -1e-4 * spent[-1])
    attached = again["cohesive_radius"].values > 0.0
    assert np.count_nonzero(attached[1:] & ~attached[:-1]) == 2


def test_a_slow_retraction_tends_to_the_relaxed_modulus():
    """The difference from Maugis' law of the equilibrium modulus is of the first order in the speed."""
    relaxed = mdr.solve(
        contact(2.0, body=mdr.Elastic(0.75, 0.5)), mdr.indent(1.0) >> mdr.indent(-0.6, steps=80)
    )
    for name in ("normal_force", "contact_radius", "cohesive_radius"):
        expected = relaxed[name].values[1:]
        off = []
        for seconds in (1e4, 1e5):
            path = approach(1.0) >> mdr.indent(-0.6, steps=80, duration=seconds)
            off.append(mdr.solve(contact(2.0), path)[name].values[12:] - expected)
        # a short time after the reversal the zone still adapts
        assert off[0][5:] / off[1][5:] == pytest.approx(10.0, rel=0.03)
        assert (10.0 * off[1] - off[0])[5:] / 9.0 == pytest.approx(0.0, abs=1e-4 * np.abs(expected).max())


def test_short_zones_and_long_series():
    """Maugis' parameter 22 with three relaxation times: the pull-off is between the slow limit and E_0/E_inf times it."""
    body = mdr.Viscoelastic(
        mdr.Prony(equilibrium=0.25, moduli=[0.75] * 3, times=[0.1, 1.0, 10.0]), poisson=0.5
    )
    soft = contact(20.0, body=body)
    path = (
        mdr.indent(1.0, steps=50, duration=2.0)
        >> mdr.hold("5 s", steps=10)
        >> mdr.indent(-8.0, steps=100, duration=90.0)
    )
    result = mdr.solve(soft, path)
    assert result.status is mdr.Status.PULLED_OFF
    row = int(np.argmin(result["normal_force"].values))
    pull = -float(result["normal_force"][row])
    assert float(result.claims["normal_force"].error[row]) < 5e-4
    slow = -mdr.pull_off(contact(20.0, body=mdr.Elastic(0.75, 0.5))).largest_pull
    fast = -mdr.pull_off(contact(20.0, body=mdr.Elastic(7.5, 0.5))).largest_pull
    assert slow < pull < 10.0 * max(slow, fast)  # E_0/E_inf = 10


def test_orders_of_convergence():
    """With halved nodes, cells and steps the force converges to the second order, in the mean over a retraction; singular instants reduce it."""
    from pymdr.line.soft.springs import FINE, ZoneLevel, ZoneSetting, ZoneSprings

    def profile(x):
        return x**2, x**3 / 3.0

    relaxation = mdr.relaxation_of(RUBBER)
    setting = ZoneSetting(relaxation, math.pi * relaxation.rubbery / 16.0, 2.0, 1.0, profile, 2.5)
    times = np.array([0.0, 2.0, 1e3, *(1e3 + np.linspace(2.0, 40.0, 20))])
    depths = np.array([-1.0, 1.0, 1.0, *(1.0 - 0.1 * np.linspace(2.0, 40.0, 20))])
    forces = []
    for scale in (4.0, 2.0, 1.0, 0.25):
        level = ZoneLevel(*(np.array(FINE[:4]) * [scale, 1.0 / scale, scale, scale]))
        forces.append(ZoneSprings(setting, level).follow(times, depths, math.inf)["normal_force"])
    errors = [np.sqrt(np.mean((force[2:] - forces[-1][2:]) ** 2)) for force in forces[:-1]]
    assert math.log2(errors[0] / errors[-1]) / 2.0 > 1.7
    assert errors[-1] < 1e-4 * np.abs(forces[-1]).max()


def to_and_fro(seed):
    """A random contact, its path on a random machine or by its depth, and the stiffness of the machine."""
    rng = np.random.default_rng([9, seed])
    moduli = 10.0 ** rng.uniform(-0.5, 1.0, rng.integers(1, 3))
    series = mdr.Prony(0.25, moduli, 10.0 ** rng.uniform(-1.0, 1.0, moduli.size))
    work = 10.0 ** rng.uniform(-1.0, 0.5)
    law = mdr.MaugisDugdale(work, range=0.5 * 10.0 ** rng.uniform(-0.5, 0.5) * work ** (2.0 / 3.0))
    profile = BALL
    if rng.random() < 0.3:
        profile = mdr.PowerLaw(exponent=rng.uniform(1.6, 4.0), height=0.5, radius=1.0)
    depth, speed = rng.uniform(0.2, 0.6), 10.0 ** rng.uniform(-1.0, 1.0)
    low = depth - rng.uniform(0.2, 1.5)
    stiffness = 10.0 ** rng.uniform(0.3, 1.5) if rng.random() < 0.5 else math.inf
    moved = "indentation" if math.isinf(stiffness) else "travel"
    path = mdr.Path(time=np.linspace(0.0, (depth + 1.0) / speed, 8), **{moved: np.linspace(-1.0, depth, 8)})
    for start, end, steps in ((depth, low, int(rng.integers(5, 30))), (low, depth, 8), (depth, -4.0, 30)):
        path = path >> mdr.ramp(**{moved: end}, steps=steps, duration=abs(end - start) / speed)
    return mdr.Contact(profile, mdr.Viscoelastic(series, poisson=0.5), adhesion=law), path, stiffness


@pytest.mark.parametrize("seed", first_of(range(20), 0))
def test_a_tolerance_is_met_by_the_claims_and_by_a_finer_solution(seed):
    """Or a note states that it is not; no row then differs by more than its claim."""
    adhesive, path, stiffness = to_and_fro(seed)
    finest = mdr.solve(adhesive, path, machine_stiffness=stiffness, tolerance=1e-5)
    for tolerance in (1e-2, 1e-3, 1e-4):
        solved = mdr.solve(adhesive, path, machine_stiffness=stiffness, tolerance=tolerance)
        for name in ("normal_force", "indentation"):
            value, true, error = solved[name].values, finest[name].values, solved.claims[name].error
            known, largest = error < 1.0, tolerance * np.abs(value).max()
            claimed = np.abs(value) * error
            missed = any("tolerance" in note for note in solved.notes)
            assert missed or np.all(claimed[known] <= 1.0001 * largest)
            assert np.all((np.abs(value - true) <= claimed + finest.claims[name].error * np.abs(true))[known])


@pytest.mark.parametrize(
    ("tolerance", "body", "words"),
    [
        (1e-9, RUBBER, "tolerance = 1e-09; it must be a number from 1e-6 to 1e-2"),
        ("1e-4", RUBBER, "it must be a number"),
        (
            1e-4,
            mdr.Elastic(0.75, 0.5),
            "tolerance = 0.0001; it is for MaugisDugdale or Capillary on bodies with memory",
        ),
    ],
)
def test_tolerances_that_are_refused(tolerance, body, words):
    with pytest.raises(ProblemError, match=re.escape(words)):
        mdr.solve(contact(2.0, body=body), mdr.indent(1.0, duration=1.0), tolerance=tolerance)


@pytest.mark.parametrize("seed", first_of(range(50), 2))
def test_claims_hold_beside_eight_times_shorter_steps(monkeypatch, seed):
    """Every column moves by less than its claim; external work near 0 by that of the largest energies so far."""
    from pymdr.line.soft.springs import ZoneLevel
    from pymdr.solving import soft

    adhesive, path, stiffness = to_and_fro(seed)
    solved = mdr.solve(adhesive, path, machine_stiffness=stiffness)
    monkeypatch.setattr(soft, "FINE", ZoneLevel(1.0 / 3.0, 72.0, 0.03 / 8.0, 0.002 / 8.0))
    finer = mdr.solve(adhesive, path, machine_stiffness=stiffness)
    energies = sum(np.abs(finer[n].values) for n in ("external_work", "elastic_energy", "surface_energy"))
    for name in (
        "normal_force",
        "indentation",
        "contact_radius",
        "cohesive_radius",
        "elastic_energy",
        "surface_energy",
        "external_work",
        "dissipated_energy",
        "jump_dissipation",
    ):
        value, true = solved[name].values, finer[name].values
        size = np.abs(value)
        if name in ("external_work", "jump_dissipation"):
            size = np.maximum.accumulate(energies)
        claimed = solved.claims[name].error
        assert np.all(np.abs(value - true) <= claimed * size + 1e-12 * size.max()), name


def test_a_cone_claims_the_error_to_which_its_steps_are_solved(monkeypatch):
    """Where all levels agree by chance, they share that error."""
    from pymdr.solving import soft

    series = mdr.Prony(25286.93, [11556.41, 57907.05], [0.1673097, 0.2699972])
    law = mdr.MaugisDugdale(1.970963e-05, range=5.957954e-08)
    cone = mdr.Contact(mdr.Cone(slope=0.4943502), mdr.Viscoelastic(series, poisson=0.06148619), adhesion=law)
    path = mdr.travel("23.11409 nm", steps=32, duration="1.599522 ms")
    solved = mdr.solve(cone, path, machine_stiffness=1.794244)
    monkeypatch.setattr(soft, "FINE", soft.zone_level(0.25))
    finer = mdr.solve(cone, path, machine_stiffness=1.794244)
    for name in ("normal_force", "indentation", "contact_radius", "cohesive_radius"):
        value, true = solved[name].values, finer[name].values
        assert np.all(np.abs(value - true) <= solved.claims[name].error * np.abs(value)), name


def drawn_retreat(seed):
    """A random contact, its range of attraction, and the depth and speed of its retreat."""
    rng = np.random.default_rng([31, seed])
    moduli = 10.0 ** rng.uniform(-0.5, 1.0, int(rng.integers(1, 3)))
    series = mdr.Prony(0.25, moduli, 10.0 ** rng.uniform(-1.0, 1.0, moduli.size))
    parameter, work = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-1.0, 0.5)
    extent = work / (parameter / (9.0 / (2.0 * math.pi * work)) ** (1.0 / 3.0))
    adhesive = mdr.Contact(
        BALL, mdr.Viscoelastic(series, poisson=0.5), adhesion=mdr.MaugisDugdale(work, range=extent)
    )
    return adhesive, extent, rng.uniform(0.2, 0.6), 10.0 ** rng.uniform(-1.0, 1.0)


@pytest.mark.parametrize("seed", first_of([3, *range(3), *range(4, 21)]))
def test_short_rows_beside_a_zone_that_vanishes_take_few_steps(seed):
    """On all levels: near its end a zone has few nodes."""
    from pymdr.line.soft.kernels import COUNT
    from pymdr.line.soft.springs import COARSE, FINE, ROUGH, ZoneSprings
    from pymdr.solving.zones import zone_relaxation, zone_setting

    adhesive, extent, depth, speed = drawn_retreat(seed)
    setting = zone_setting(adhesive, zone_relaxation(adhesive, None), {math.inf: depth})
    shares = np.concatenate([-np.logspace(0.0, -7.0, 15), [0.0], np.logspace(-7.0, -1.0, 13)])

    def followed(level, depths):
        springs = ZoneSprings(setting, level)
        control = np.concatenate([[-extent], depths])
        rows = springs.follow(np.append(0.0, np.cumsum(np.abs(np.diff(control)))) / speed, control, math.inf)
        return rows["cohesive_radius"] > 0.0, springs.state[0][COUNT]

    for level in (ROUGH, COARSE, FINE):
        high, low = depth, depth - 4.0 * extent - 20.0
        for _ in range(5):
            depths = np.linspace(high, low, 21)[1:]
            attached, _ = followed(level, np.append(depth, depths))
            row = int(np.argmin(attached[1:]))
            low, high = depths[row], depths[row - 1] if row else high
        attached, steps = followed(level, np.append(depth, low - (depth - low) * shares))
        assert attached[:15].any()
        assert not attached[-1]
        assert steps < 400.0 * shares.size


@pytest.mark.parametrize("seed", first_of([*range(2, 10), *range(11, 14)], 0))
def test_claims_hold_for_rows_beside_a_separation(monkeypatch, seed):
    """Rows from a tenth to 1e-7 of the path on both sides of it: an error of 1 is that of a row within the error of the instant."""
    from pymdr.line.soft.springs import ZoneLevel
    from pymdr.solving import soft

    adhesive, extent, depth, speed = drawn_retreat(seed)
    span = depth + 3.0 * extent + 2.0

    def retreat(depths):
        path = mdr.indent(-extent, duration=1e-9) >> mdr.indent(depth, rate=speed, steps=6)
        time = mdr.solve(adhesive, path)["time"].values[-1] + (depth - depths) / speed
        return mdr.solve(adhesive, path >> mdr.Path(time=time, indentation=depths))

    high, low = depth, depth - span
    for _ in range(4):
        depths = np.linspace(high, low, 21)[1:]
        attached = retreat(depths)["cohesive_radius"].values[7:] > 0.0
        row = int(np.argmin(attached))
        low, high = depths[row], depths[row - 1] if row else high
    beside = np.concatenate([np.logspace(-1.0, -7.0, 13), [0.0], -np.logspace(-7.0, -2.0, 6)])
    depths = low + span * beside
    depths = depths[depths < depth]
    solved = retreat(depths)
    monkeypatch.setattr(soft, "FINE", ZoneLevel(1.0 / 3.0, 72.0, 0.03 / 8.0, 0.002 / 8.0))
    finer = retreat(depths)
    known = solved.claims["normal_force"].error < 1.0
    assert known[(solved["indentation"].values - low) > 1e-3 * span].all()
    for name in ("normal_force", "contact_radius", "cohesive_radius", "elastic_energy", "surface_energy"):
        value, true = solved[name].values, finer[name].values
        claimed = solved.claims[name].error * np.abs(value) + 1e-12 * np.abs(value).max()
        assert np.all((np.abs(value - true) <= claimed)[known]), name


def test_a_wait_longer_than_any_dissipates_nothing():
    """The rounding of a contact at rest, squared and times 1e60 relaxation times, was 1e28 of its energy."""
    spent = []
    for wait in (1e6, 1e20, 1e60):
        stepper = mdr.Stepper(contact(2.0), 1.0)
        stepper.advance(1.0, duration=10.0)
        stepper.advance(1.0, duration=1e4)
        stepper.advance(1.0, duration=wait)
        spent.append(stepper.dissipated_energy)
    assert spent[1:] == pytest.approx([spent[0]] * 2, rel=1e-14)


@pytest.mark.parametrize("seed", first_of(range(30)))
def test_coarse_rows_on_soft_machines_are_those_of_fine_rows(seed):
    """Retreats of machines softer than the contact, which part at once or pass a state of rest, in 16 times as many rows."""
    rng = np.random.default_rng([4, seed])
    moduli = 10.0 ** rng.uniform(-0.5, 1.0, rng.integers(1, 3))
    series = mdr.Prony(0.25, moduli, 10.0 ** rng.uniform(-1.0, 1.0, moduli.size))
    work = 10.0 ** rng.uniform(-1.0, 0.5)
    extent = 0.5 * 10.0 ** rng.uniform(-0.7, 0.4) * work ** (2.0 / 3.0)
    law = mdr.MaugisDugdale(work, range=extent)
    adhesive = mdr.Contact(BALL, mdr.Viscoelastic(series, poisson=0.5), adhesion=law)
    stiffness, depth, speed = (
        10.0 ** rng.uniform(-1.5, 0.5),
        rng.uniform(0.3, 2.0),
        10.0 ** rng.uniform(-1.0, 1.5),
    )
    low, count, parts = -8.0 * work / stiffness - 4.0, int(rng.integers(6, 20)), 16
    press = mdr.Path(
        time=np.linspace(0.0, (depth + extent) / speed, 8), travel=np.linspace(-extent, depth, 8)
    )
    coarse, fine = (
        mdr.solve(
            adhesive,
            press >> mdr.travel(low, steps=steps, duration=(depth - low) / speed),
            machine_stiffness=stiffness,
        )
        for steps in (count, count * parts)
    )
    for name in ("normal_force", "indentation", "contact_radius", "cohesive_radius"):
        rows = np.append(np.arange(8), 7 + parts * np.arange(1, count + 1))
        one, other = coarse[name].values, fine[name].values[rows]
        claimed = coarse.claims[name].error * np.abs(one) + fine.claims[name].error[rows] * np.abs(other)
        assert np.all(np.abs(one - other) <= claimed + 1e-9 * np.abs(other).max()), name


@given(
    st.floats(0.2, 8.0), st.floats(0.02, 5.0), st.floats(0.1, 1.0), st.floats(-9.0, 3.0), st.floats(-3.0, 6.0)
)
@settings(max_examples=examples(18), deadline=None)
def test_any_retraction_dissipates_between_the_limits(strength, speed, depth, size, time):
    """Nothing is gained, the pull-off is between the limits, and lengths from nanometres to metres and times scale."""
    length, tau, modulus = 10.0**size, 10.0**time, 1e6
    solid = mdr.StandardSolid(0.25 * modulus, 2.25 * modulus, tau)
    soft = mdr.Contact(
        mdr.Paraboloid(length),
        mdr.Viscoelastic(solid, poisson=0.5),
        adhesion=mdr.MaugisDugdale(modulus * length, strength=strength * modulus),
    )
    extent = (8.0 + depth) * length
    path = (
        mdr.indent(depth * length, steps=5, duration=2.0 * tau)
        >> mdr.hold(tau)
        >> mdr.indent(depth * length - extent, steps=60, duration=extent / length / speed * tau)
    )
    result = mdr.solve(soft, path)
    spent = result["dissipated_energy"].values
    assert result.status is mdr.Status.PULLED_OFF
    assert np.all(np.diff(spent) > -3e-4 * spent[-1])
    pull = -result["normal_force"].values.min() / (modulus * length**2)
    slow = -mdr.pull_off(contact(strength, body=mdr.Elastic(0.75, 0.5))).largest_pull
    # no faster pull than that of a flat punch of the largest contact on the instantaneous modulus
    radius = result["contact_radius"].values.max() / length
    assert 0.9 * slow < pull < math.sqrt(8.0 * math.pi * 10.0 * radius**3)


@pytest.mark.parametrize(("time", "young"), [(1e-9, 0.75), (1e9, 7.5)])
def test_relaxation_at_once_or_never_is_elastic(time, young):
    """Loops by Maugis' elastic law with the equilibrium modulus or the instantaneous one."""
    body = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, time), poisson=0.5)
    path = (
        mdr.indent(-0.95, duration=1.0)
        >> mdr.indent(0.8, steps=18, duration=2.0)
        >> mdr.indent(-2.0, steps=28, duration=3.0)
    )
    soft = mdr.solve(contact(2.0, body=body), path)
    elastic = mdr.solve(
        contact(2.0, body=mdr.Elastic(young, 0.5)),
        mdr.indent(-0.95) >> mdr.indent(0.8, steps=18) >> mdr.indent(-2.0, steps=28),
    )
    for name in ("contact_radius", "cohesive_radius", "normal_force"):
        expected = elastic[name].values
        assert soft[name].values == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_the_zone_of_a_slow_cone_grows_from_nothing():
    """At the tip of a cone the attraction begins without a jump; a slow approach follows the relaxed modulus."""
    cone = mdr.Cone(slope=0.7)
    path = mdr.indent(-1.2, duration=1.0) >> mdr.indent(-0.1, steps=11, duration=1e6)
    result = mdr.solve(contact(1.2, cone), path)
    elastic = mdr.solve(
        contact(1.2, cone, mdr.Elastic(0.75, 0.5)), mdr.indent(-1.2) >> mdr.indent(-0.1, steps=11)
    )
    expected = elastic["normal_force"].values
    assert np.abs(expected).max() > 0.1
    assert result["normal_force"].values == pytest.approx(expected, abs=5e-4 * np.abs(expected).max())


def test_a_long_wait_leaves_its_digits_to_a_fast_pull():
    least = []
    for wait in (1e4, 1e8):
        path = (
            mdr.indent(1.0, steps=4, duration=2.0)
            >> mdr.hold(wait)
            >> mdr.indent(-3.0, steps=20, duration=2e-6)
        )
        least.append(float(mdr.solve(contact(2.0), path)["normal_force"].min()))
    assert least[1] == pytest.approx(least[0], rel=1e-6)


def test_a_move_that_numbers_do_not_resolve_is_refused():
    path = mdr.indent(1.0, steps=4, duration=2.0) >> mdr.hold(1e8) >> mdr.indent(0.5, duration=1e-9)
    with pytest.raises(PathError, match=r"row at t = 1e\+08 s moves in zero time.*above 1e-08 s"):
        mdr.solve(contact(2.0), path)
    with pytest.raises(PathError, match=r"entries 1 and 2.*differ by 1e-08 s"):
        mdr.Path(time=[1e8, 1e8 + 1e-9], indentation=[1.0, 0.5])


@pytest.mark.parametrize("law", [mdr.MaugisDugdale(1.0, strength=2.0), mdr.JKR(1.0, range=0.01)])
def test_a_path_that_only_places_a_free_body_within_the_attraction_is_refused(law):
    probe = mdr.Contact(BALL, RUBBER, adhesion=law)
    for target in ({"indentation": [1.0]}, {"normal_force": [1.0]}):
        with pytest.raises(PathError, match="row at t = 0 s moves in zero time"):
            mdr.solve(probe, mdr.Path(time=[0.0], **target))
    beyond = mdr.solve(probe, mdr.Path(time=[0.0], indentation=[-0.6]))
    assert beyond.status is mdr.Status.NOT_TOUCHED
    placed = mdr.solve(probe, mdr.Path(time=[0.0, 1.0], indentation=[1.0, 1.0]))
    assert placed["contact_radius"][1] > 1.0


def test_attraction_and_separation_are_located_between_rows():
    gel = mdr.Viscoelastic(mdr.StandardSolid("0.25 MPa", "2.25 MPa", "1 s"), poisson=0.5)
    probe = mdr.Contact(mdr.Sphere("1 mm"), gel, adhesion=mdr.MaugisDugdale("0.1 J/m^2", range="100 nm"))
    parted = []
    for rows in (15, 150):
        path = mdr.indent("-1 um", duration="1 s") >> mdr.indent("5 um", steps=10, duration="2 s")
        notes = mdr.solve(probe, path >> mdr.indent("-12 um", steps=rows, duration="4 s")).notes
        assert any(note.startswith("attracted before row 2, at d = -100 nm") for note in notes)
        (note,) = (note for note in notes if note.startswith("pulled off"))
        parted.append(float(re.search(r"off at d = ([\d.]+) µm", note)[1]))
    assert parted[0] == pytest.approx(parted[1], rel=1e-4)


def test_a_snap_on_a_machine_is_noted_by_the_row_before_it():
    probe = mdr.Contact(BALL, RUBBER, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    path = mdr.Path(
        time=np.linspace(0.0, 6.0, 61), travel=np.interp(np.linspace(0.0, 6.0, 61), [0, 1, 6], [0, 1, -9])
    )
    result = mdr.solve(probe, path, machine_stiffness=2.0)
    (note,) = (note for note in result.notes if note.startswith("pulled off after row"))
    row = int(note.split()[4].rstrip(","))
    assert f"d = {metres(float(result['indentation'][row]))}" in note
    assert f"F = {newtons(float(result['normal_force'][row]))}" in note


def test_a_power_of_time_without_work_is_that_without_adhesion():
    """The force of Lee and Radok in closed form in approach, and Ting's in retreat; a weak attraction adds its own order, 2 pi R work."""
    work, exponent = 1e-4, 0.4
    body = mdr.Viscoelastic(mdr.PowerLawRheology(0.25, 1.0, exponent), poisson=0.5)
    bare, weak = (
        mdr.Contact(BALL, body, adhesion=law) for law in (None, mdr.MaugisDugdale(work, range=0.05))
    )
    steps = np.linspace(0.0, 1.0, 9)
    path = mdr.Path(time=steps, indentation=steps) >> mdr.indent(0.6, steps=4, duration=0.4)
    result = mdr.solve(weak, path)
    force, without = result["normal_force"].values, mdr.solve(bare, path)["normal_force"].values
    exact = 2.0 * beta(1.5, 1.0 - exponent) * steps ** (1.5 - exponent)
    largest = 2.0 * math.pi * work
    assert ((force[1:9] < exact[1:]) & (force[1:9] > exact[1:] - 1.1 * largest)).all()
    assert np.max(np.abs(force[9:] - without[9:])) < 5.0 * largest
    assert 0.0 < float(result.claims["normal_force"].error[8]) < 1e-3
    assert any("Prony series" in note for note in result.notes)


@pytest.mark.parametrize(
    ("shear", "separates", "tolerance"),
    [(mdr.PowerLawRheology(0.5, 1.0, 0.3), False, 2e-3), (mdr.Maxwell(2.0, 1.0), True, 5e-4)],
)
def test_bodies_that_flow_agree_with_elements_on_rings(shear, separates, tolerance):
    body = mdr.Viscoelastic(shear, poisson=0.5)
    path = mdr.Path(time=np.linspace(0.0, 2.0, 21), indentation=np.linspace(-0.6, 1.0, 21))
    path = path >> mdr.hold("2 s", steps=5) >> mdr.indent(-1.0, steps=30, duration=1.0)
    line, rings = (mdr.solve(contact(2.0, body=body), path, solver=each) for each in (None, mdr.Rings(200)))
    force, other = line["normal_force"].values, rings["normal_force"].values
    assert np.max(np.abs(force - other)) < tolerance * np.max(np.abs(force))
    assert (line.status is mdr.Status.PULLED_OFF) == separates
    c = float(line["cohesive_radius"].values[40])
    pressure = line.field("pressure", np.linspace(0.0, c, 20001)[:-1], 40)
    r = pressure["r"].values
    total = np.trapezoid(2.0 * math.pi * r * pressure.values, r)
    assert total == pytest.approx(force[40], abs=1e-3 * np.max(np.abs(force)))
    assert next(one for one in line.assumptions if one.name == "energy balance").measure < 1e-3


def slow_test_of_a_liquid(extent, tolerance=None):
    """Over 175 s, by the range of the attraction."""
    body = mdr.Viscoelastic(mdr.Maxwell("10 kPa", "1 s"), poisson=0.5)
    liquid = mdr.Contact(mdr.Paraboloid("1 mm"), body, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range=extent))
    press = mdr.indent("20 um", steps=20, rate="1 um/s") >> mdr.hold("5 s")
    return mdr.solve(liquid, press >> mdr.indent("-150 um", steps=60, rate="1 um/s"), tolerance=tolerance)


def test_a_long_slow_test_of_a_liquid_has_nodes_for_its_own_zones():
    """Which are longer than that at rest at the end of the path, of a smaller contact."""
    solved, finer = slow_test_of_a_liquid("5 um"), slow_test_of_a_liquid("5 um", 1e-3)
    for name in ("normal_force", "contact_radius", "cohesive_radius"):
        value, true, error = solved[name].values, finer[name].values, solved.claims[name].error
        allowed = error * np.abs(value) + finer.claims[name].error * np.abs(true)
        assert np.all((np.abs(value - true) <= allowed)[error < 1.0]), name
        assert np.median(error * np.abs(value)) < 1e-3 * np.abs(value).max()


def test_a_range_too_short_for_a_liquid_is_refused_with_one_that_is_not():
    with pytest.raises(ProblemError, match="give a range of attraction of at least") as refused:
        slow_test_of_a_liquid("1 um")
    least = re.search(r"at least ([\d.]+ µm)", str(refused.value)).group(1)
    assert slow_test_of_a_liquid(least).status is mdr.Status.ATTACHED


def test_a_zone_on_a_power_of_time_vanishes_in_few_steps():
    """Springs that are stiff at once let go of a zone that shrinks to nothing, not of one that jumps."""
    body = mdr.Viscoelastic(mdr.PowerLawRheology(0.25, 1.0, 0.4), poisson=0.5)
    bodies = mdr.Contact(BALL, body, adhesion=mdr.MaugisDugdale(1e-2, range=0.1))
    path = mdr.indent(0.5, steps=4, duration=1.0) >> mdr.indent(-0.5, steps=40, duration=1.0)
    result = mdr.solve(bodies, path)
    assert result.status is mdr.Status.PULLED_OFF
    attached = result["cohesive_radius"].values > 0.0
    last = int(np.flatnonzero(attached)[-1])
    assert result["contact_radius"].values[last] == 0.0


@pytest.mark.parametrize("seed", first_of(range(20), 3))
def test_a_fast_row_far_beyond_separation_takes_the_work_of_its_force(seed):
    rng = np.random.default_rng(seed)
    size, speed = 10.0 ** rng.uniform(-6.0, 0.0), 10.0 ** rng.uniform(1.0, 4.0)
    body = mdr.Viscoelastic(mdr.StandardSolid(0.25 / size, 2.25 / size, 1.0), poisson=0.5)
    joint = contact(2.0 / size, mdr.Paraboloid(size), body)
    far, near = 10.0 ** rng.uniform(2.0, 4.0), 6.0
    pressed = mdr.Path(time=[1.0, 2.0], indentation=[-size, size]) >> mdr.hold("1 s")
    places = np.linspace(1.0, -near, 401)[1:]
    paths = [3.0 + (1.0 - places) / speed, size * places], [[3.0 + far / speed], [size * (1.0 - far)]]
    many, one = (mdr.solve(joint, pressed >> mdr.Path(time=t, indentation=d)) for t, d in paths)
    depth, force = (many[name].values[2:] for name in ("indentation", "normal_force"))
    work = np.trapezoid(force, depth)
    expected = float(one["external_work"][2]) + work
    # a jump anywhere within a row
    error = 0.5 * np.max(np.abs(np.diff(force) * np.diff(depth))) + 1e-3 * abs(work)
    assert float(one["external_work"][-1]) == pytest.approx(expected, abs=error)
    assert np.all(np.diff(one["dissipated_energy"]) > 0.0)
