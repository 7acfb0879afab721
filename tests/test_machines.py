"""Motion of machines with contacts: closed forms, limits, conservation, other solvers."""

import csv
import json
import math
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import pymdr as mdr
from drawing import examples
from legibility import faults
from pymdr.line.motion import follow_motion
from pymdr.problem.codec import decode_machine, forget_models, machine_adapter
from pymdr.solving.machines.assembling import map_contact, system_of
from pymdr.solving.machines.value import ENERGIES
from pymdr.solving.machines.verb import residual_of

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL)
RUBBING = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
MODULUS = mdr.effective_moduli(STEEL).normal
PAIR = mdr.effective_moduli(STEEL, STEEL)


def falling(speed=1.0, mass=0.033):
    return mdr.Machine([mdr.Mass("ball", mass, velocity=speed)], [mdr.Joint(BALL, "ball")])


def contact_time(speed=1.0, mass=0.033):
    """2 sqrt(pi) Gamma(7/5) / Gamma(9/10) d_m / v for F = k d^(3/2)."""
    k = 4 / 3 * MODULUS * math.sqrt(0.01)
    gammas = 2 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
    return gammas * (1.25 * mass * speed**2 / k) ** 0.4 / speed


def followed(machine, span, steps):
    """The motion in a given number of steps, without control of its error."""
    mapped = {joint.contact: map_contact(joint.contact) for joint in machine.joints}
    return follow_motion(system_of(machine, mapped, dict.fromkeys(mapped, math.inf)), span / steps, 1, steps)


def residual(followed):
    return residual_of({name: followed.energies[:, i] for i, name in enumerate(ENERGIES)})


def test_a_mass_bounces_on_a_hertz_contact_in_the_known_time():
    assert contact_time() == pytest.approx(3.218 * (0.033**2 / (4 / 3 * MODULUS * 0.1) ** 2) ** 0.2, rel=1e-4)
    span = 1.2 * contact_time()
    motion = mdr.move(falling(), span, steps=50, accuracy=1e-8)
    flown = -float(motion["position"][-1, 0])
    assert span - flown == pytest.approx(contact_time(), rel=1e-7)
    assert float(motion["velocity"][-1, 0]) == pytest.approx(-1.0, rel=1e-12)
    assert motion.claims["position"].error[-1] < 1e-7


def test_errors_are_of_second_order():
    span = 0.5 * contact_time()
    ends = [followed(falling(), span, n).position[-1, 0] for n in (50, 100, 200, 400)]
    exact = mdr.impact(BALL, mass=0.033, speed=1.0).largest_indentation
    errors = np.abs(np.array(ends) - exact)
    # at the turning point the error of the time does not count, so that the steps are compared with the finest
    distances = [followed(falling(), 0.7 * span, n).position[-1, 0] for n in (50, 100, 200, 400)]
    orders = np.log2(np.abs(np.diff(distances))[:-1] / np.abs(np.diff(distances))[1:])
    assert np.all(np.abs(orders - 2.0) < 0.05)
    assert errors[-1] < 1e-4 * exact


def bouncing():
    """A mass that gravity presses on a contact, and a second one on a spring."""
    return mdr.Machine(
        [mdr.Mass("ball", 0.03, position="-1 um"), mdr.Mass("rider", 0.01, velocity=1e-3)],
        [mdr.Joint(BALL, "ball"), mdr.Spring(("ball", "rider"), 1e6), mdr.Force("ball", 5.0)],
    )


def test_energy_drifts_below_1e_10_in_1e5_steps():
    assert residual(followed(bouncing(), 0.5, 100_000)) < 1e-10


def test_a_frictionless_motion_runs_back():
    there = followed(bouncing(), 2e-3, 4000)
    machine = bouncing()
    bodies = [
        replace(body, position=float(x), velocity=-float(v))
        for body, x, v in zip(machine.bodies, there.position[-1], there.velocity[-1], strict=True)
    ]
    back = followed(mdr.Machine(bodies, machine.links), 2e-3, 4000)
    extent = np.ptp(np.stack([there.position[-1], back.position[-1]]))
    assert np.allclose(back.position[-1], [-1e-6, 0.0], rtol=0, atol=1e-9 * extent)
    assert np.allclose(back.velocity[-1], [0.0, -1e-3], rtol=0, atol=1e-9)


def pulled(speed, stiffness, mass=1.0, depth=1e-6):
    return mdr.Machine(
        [mdr.Mass("slider", mass), mdr.Drive("stage", velocity=speed)],
        [mdr.Spring(("stage", "slider"), stiffness), mdr.Joint(RUBBING, (), "slider", indentation=depth)],
    )


@pytest.mark.parametrize(("speed", "stiffness"), [(2e-3, 2e3), (8e-3, 2e3), (2e-3, 8e3)])
def test_amplitude_of_stick_and_slip(speed, stiffness):
    """After the first slip the slider moves by v t - (v / omega) sin(omega t): the spring force swings by v sqrt(k m)."""
    load = 4 / 3 * PAIR.normal * 0.1 * 1e-6**1.5
    start, period = 0.3 * load / (stiffness * speed), 2 * math.pi / math.sqrt(stiffness)
    motion = mdr.move(pulled(speed, stiffness), start + 3 * period, steps=2000)
    late = motion["time"].values > start + 0.1 * period
    stretch = speed * motion["time"].values - motion["position"].values[:, 0]
    swing = 0.5 * stiffness * np.ptp(stretch[late])
    assert swing == pytest.approx(speed * math.sqrt(stiffness), rel=0.02)
    assert float(motion["tangential_force"].max()) <= 0.3 * load * (1 + 1e-12)


def test_normal_oscillation_lowers_friction_between_its_limits():
    """Slow: mu F_N at the least indentation; fast: mu times the mean of F_N."""
    depth, swing = 1e-6, 0.5e-6

    def mean_friction(speed, duration):
        bodies = [mdr.Mass("slider", 1e12, velocity=speed), mdr.Drive("shaker", 0, 0, swing, "20 kHz")]
        shaken = mdr.Machine(bodies, [mdr.Joint(RUBBING, "shaker", "slider", indentation=depth)])
        motion = mdr.move(shaken, duration, steps=8000)
        return motion["tangential_force"].values[-2000:, 0].mean(), motion["normal_force"].values[-2000:, 0]

    slow, _ = mean_friction(1e-5, "50 ms")
    fast, load = mean_friction(5.0, "1 ms")
    assert slow == pytest.approx(0.3 * 4 / 3 * PAIR.normal * 0.1 * (depth - swing) ** 1.5, rel=5e-3)
    assert fast == pytest.approx(0.3 * load.mean(), rel=1e-6)


@pytest.mark.parametrize("ratio", [0.02, 0.5, 2.0])
def test_tangential_oscillation_lowers_friction(ratio):
    """With ways far beyond the elastic shift the mean is mu F_N (2 / pi) arcsin(v / v_max), and mu F_N above v_max."""
    depth, amplitude, frequency = 1e-9, 1e-4, 1e3
    largest = 2 * math.pi * frequency * amplitude
    bodies = [
        mdr.Mass("slider", 1e12, velocity=ratio * largest),
        mdr.Drive("shaker", 0, 0, amplitude, frequency),
    ]
    joint = mdr.Joint(RUBBING, (), {"slider": 1, "shaker": 1}, indentation=depth)
    motion = mdr.move(mdr.Machine(bodies, [joint]), 4 / frequency, steps=4000)
    mean = motion["tangential_force"].values[1001:, 0].mean()
    limit = 0.3 * float(motion["normal_force"][0, 0])
    assert mean / limit == pytest.approx(2 / math.pi * math.asin(min(ratio, 1.0)), abs=2e-3)


def test_a_vibrating_joint_loses_the_energy_of_its_loop():
    depth = 2e-6
    load = 4 / 3 * PAIR.normal * 0.1 * depth**1.5
    stiffness = 2 * PAIR.tangential * math.sqrt(0.01 * depth)
    period = 2 * math.pi / math.sqrt(stiffness)
    machine = mdr.Machine(
        [mdr.Mass("block", 1.0, velocity=0.1 * load / math.sqrt(stiffness))],
        [mdr.Joint(RUBBING, (), "block", indentation=depth)],
    )
    motion = mdr.move(machine, 12 * period, steps=6000, accuracy=1e-3)
    x, v = motion["position"].values[:, 0], motion["velocity"].values[:, 0]
    turns = np.flatnonzero((v[:-1] > 0) & (v[1:] <= 0))[-2:]
    dissipated = np.diff(motion["dissipated_energy"].values[turns])[0]
    opposite = np.flatnonzero((v[:-1] < 0) & (v[1:] >= 0))
    between = opposite[(opposite > turns[0]) & (opposite < turns[1])][0]
    amplitude = 0.5 * (0.5 * (x[turns[0]] + x[turns[1]]) - x[between])
    loop = mdr.solve(RUBBING, mdr.indent(depth) >> mdr.cycle(shift=amplitude, cycles=2, steps=8))
    closed = loop["dissipated_energy"].values
    assert dissipated == pytest.approx(closed[-1] - closed[-5], rel=5e-3)


def test_a_solitary_wave_runs_along_a_chain_of_spheres():
    """Nesterenko (1983): V = (16/25)^(1/5) c^(4/5) v_m^(1/5), c^2 = k a^(5/2) / m; in chains 0.8 % slower."""
    count, mass, radius = 24, 1e-3, 5e-3
    pair = mdr.Contact(mdr.Paraboloid(0.5 * radius), STEEL, STEEL)
    bodies = [mdr.Mass(f"b{i}", mass, velocity=0.0 if i else 1.0) for i in range(count)]
    links = [mdr.Joint(pair, (f"b{i}", f"b{i + 1}"), name=f"c{i}") for i in range(count - 1)]
    k = 4 / 3 * PAIR.normal * math.sqrt(0.5 * radius)
    motion = mdr.move(mdr.Machine(bodies, links), 1.8e-4, steps=1200, accuracy=1e-3)
    speeds, time = motion["velocity"].values, motion["time"].values

    def peak(i):
        j = int(np.argmax(speeds[:, i]))
        a, b, c = np.polyfit([-1.0, 0.0, 1.0], speeds[j - 1 : j + 2, i], 2)
        return time[j] - b / (2 * a) * time[1], c - b * b / (4 * a)

    (first, height), (last, _) = peak(12), peak(18)
    c = math.sqrt(k * (2 * radius) ** 2.5 / mass)
    formula = (16 / 25) ** 0.2 * c**0.8 * height**0.2
    assert 6 * 2 * radius / (last - first) == pytest.approx(formula, rel=0.01)


@pytest.mark.parametrize(("angle", "spin"), [("60 deg", 20.0), ("30 deg", 0.0), ("80 deg", -50.0)])
def test_oblique_impacts_are_those_of_impact(angle, spin):
    mass, radius, speed = 0.033, 0.01, 1.0
    tilt = math.radians(float(angle.split()[0]))
    known = mdr.impact(RUBBING, mass=mass, speed=speed, angle=angle, spin=spin)
    bodies = [
        mdr.Mass("z", mass, velocity=speed * math.cos(tilt)),
        mdr.Mass("x", mass, velocity=speed * math.sin(tilt)),
        mdr.Rotor("ball", 0.4 * mass * radius**2, radius, spin=spin),
    ]
    machine = mdr.Machine(bodies, [mdr.Joint(RUBBING, "z", {"x": 1, "ball": 1})])
    motion = mdr.move(machine, 1.1 * known.contact_time, steps=50, accuracy=1e-7)
    z, x, rim = motion["velocity"].values[-1]
    assert z == pytest.approx(-known.rebound_speed, rel=1e-9)
    assert x == pytest.approx(known.tangential_speed, abs=1e-6)
    assert rim / radius == pytest.approx(known.spin, abs=1e-6 / radius)
    assert float(motion["dissipated_energy"][-1]) == pytest.approx(known.energy_lost, rel=1e-5)


def after_impact(normal, along, spin):
    """Velocities after `impact`, which counts the angle from 0 on."""
    sign = math.copysign(1.0, along)
    speed, angle = math.hypot(normal, along), math.atan2(abs(along), normal)
    hit = mdr.impact(RUBBING, mass=0.033, speed=speed, angle=angle, spin=sign * spin)
    return hit.rebound_speed, sign * hit.tangential_speed, sign * hit.spin


def test_a_ball_bounces_between_two_plates_with_partial_slip():
    """Every bounce is that of `impact` (Garwin's ball under a table, 1969); under the upper plate the spin acts the other way."""
    gap, spin = 2e-5, 40.0
    bodies = [
        mdr.Mass("z", 0.033, velocity=1.0),
        mdr.Mass("x", 0.033, velocity=0.6),
        mdr.Rotor("ball", 0.4 * 0.033 * 0.01**2, 0.01, spin=spin),
    ]
    links = [
        mdr.Joint(RUBBING, "z", {"x": 1, "ball": 1}, name="floor"),
        mdr.Joint(RUBBING, {"z": -1}, {"x": 1, "ball": -1}, indentation=-gap, name="ceiling"),
    ]
    lasts = contact_time() * (MODULUS / PAIR.normal) ** 0.4
    motion = mdr.move(mdr.Machine(bodies, links), 2.0 * lasts + 1.5 * gap, steps=100, accuracy=1e-7)
    normal, along, spin = after_impact(1.0, 0.6, spin)
    normal, along, back = after_impact(normal, along, -spin)
    z, x, rim = motion["velocity"].values[-1]
    assert z == pytest.approx(normal, rel=1e-9)
    assert [x, rim / 0.01] == pytest.approx([along, -back], abs=1e-5)
    assert float(motion["normal_force"][-1].max()) == 0.0


def on_a_track(amplitude, frequency, load=50.0, mass=0.033, start=0.0):
    depth = (load / (4 / 3 * MODULUS * 0.1)) ** (2 / 3)
    bodies = [mdr.Mass("ball", mass, depth, start), mdr.Drive("track", 0, 0, amplitude, frequency)]
    return mdr.Machine(bodies, [mdr.Joint(BALL, {"ball": 1, "track": 1}), mdr.Force("ball", load)])


def test_a_wavy_track_excites_the_normal_force():
    """Small waves: |F| = w k m omega^2 / |k - m omega^2|; high ones part the bodies."""
    depth = (50.0 / (4 / 3 * MODULUS * 0.1)) ** (2 / 3)
    stiffness, frequency, wave = 2 * MODULUS * math.sqrt(0.01 * depth), 2000.0, 1e-10
    omega = 2 * math.pi * frequency
    inertia = 0.033 * omega**2
    start = -wave * omega * stiffness / (stiffness - inertia)
    gentle = mdr.move(on_a_track(wave, frequency, start=start), "20 ms", steps=4000)
    spectrum = gentle.spectrum("normal_force", "contact")
    expected = wave * stiffness * inertia / abs(stiffness - inertia)
    assert float(spectrum.sel(frequency=frequency)) == pytest.approx(expected, rel=1e-3)
    rough = mdr.move(on_a_track(4e-6, frequency), "5 ms", steps=2000, accuracy=0.02)
    force = rough["normal_force"].values
    assert force.min() == 0.0
    assert np.count_nonzero(np.diff((force[:, 0] > 0).astype(int)) == -1) > 3
    harmonics = rough.spectrum("normal_force", "contact")
    assert float(harmonics.sel(frequency=2 * frequency, method="nearest")) > 1e-3 * force.max()


SCALES = st.floats(-9.0, 0.0).map(lambda e: 10.0**e)
PARTS = st.floats(0.1, 3.0)


@settings(max_examples=examples(40), deadline=None)
@given(
    length=SCALES,
    young=st.sampled_from([1e3, 1e6, 2e11]),
    parts=st.tuples(*[PARTS] * 7),
    slides=st.booleans(),
)
def test_energy_in_is_energy_stored_and_dissipated(length, young, parts, slides):
    """Random machines from nm to m: the balance closes at any step."""
    spring, damping, mass, load, speed, swing, mu = parts
    body = mdr.Elastic(young, 0.3)
    contact = mdr.Contact(mdr.Paraboloid(length), body, friction=mdr.Coulomb(mu) if slides else None)
    depth = 1e-3 * length
    k = 2 * mdr.effective_moduli(body).normal * math.sqrt(length * depth)
    m = 1e3 * mass * length**3
    period = math.sqrt(m / k)
    bodies = [
        mdr.Mass("z", m, 0.3 * depth, -depth / period),
        mdr.Mass("x", m, 0, speed * depth / period),
        mdr.Rotor("r", m * length**2, length),
        mdr.Drive("d", 0, 0.1 * depth / period, swing * depth, 0.2 / period),
    ]
    links = [
        mdr.Joint(contact, "z", {"x": 1, "r": -0.5}, indentation=0.5 * depth),
        mdr.Spring(("x", "d"), spring * k, 0.1 * damping * m / period),
        mdr.Force({"z": 1, "r": 0.2}, load * k * depth, 0.5 * k * depth, 0.3 / period),
    ]
    run = followed(mdr.Machine(bodies, links), 30 * period, 600)
    assert residual(run) < 1e-10
    dissipated = run.energies[:, 4]
    assert np.all(np.diff(dissipated) >= 0.0) if slides else not dissipated.any()


def test_a_contact_that_slips_and_parts_within_a_step_takes_its_energy():
    """Neither end of the step has a force: the work of slip between them brakes the slider."""
    bodies = [mdr.Mass("z", 1e-3, 1e-9, -1e-2), mdr.Mass("x", 1e-3, 0, -1e-2)]
    parting = mdr.Machine(bodies, [mdr.Joint(RUBBING, "z", "x")])
    run = followed(parting, 1e-6, 1)
    assert run.energies[-1, 4] > 0.0
    assert residual(run) < 1e-14


def test_strong_dampers_between_several_bodies_keep_the_balance():
    """A spring of three bodies, whose damper stops their sum far within a step: sum a^2 / m = 3 / kg, rate 3e5 / s."""
    bodies = [mdr.Mass(name, 1.0, velocity=speed) for name, speed in (("a", 1.0), ("b", 0.2), ("c", 0.5))]
    run = followed(mdr.Machine(bodies, [mdr.Spring({"a": 1, "b": 1, "c": 1}, 1.0, 1e5)]), 1.0, 300)
    assert run.outcome.name == "COMPLETE"
    assert residual(run) < 1e-12
    differences = np.diff(run.velocity, axis=1)
    assert np.allclose(differences, [-0.8, 0.3], rtol=0, atol=1e-12)


def test_a_machine_without_contacts():
    """x = sin(omega t) / omega, with a damper at a tenth of the critical one."""
    damped = mdr.Machine([mdr.Mass("bob", 1.0, velocity=1.0)], [mdr.Spring("bob", 1.0, 0.2)])
    motion = mdr.move(damped, 3.0, steps=30, accuracy=1e-7)
    omega = math.sqrt(0.99)
    exact = np.exp(-0.1 * motion["time"]) * np.sin(omega * motion["time"]) / omega
    assert np.allclose(motion["position"].values[:, 0], exact, rtol=0, atol=1e-7)
    assert "normal_force" not in motion.data
    assert motion.plot().axes


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mdr.Mass("a", "0 kg"), "above 0 kg"),
        (lambda: mdr.Mass(" ", 1.0), "a text is needed"),
        (lambda: mdr.Machine([mdr.Mass("a", 1), mdr.Mass("a", 1)]), "^the name .a. occurs twice in bodies"),
        (lambda: mdr.Machine([mdr.Mass("slider", 1)], [mdr.Spring("slder", 1)]), "did you mean 'slider'"),
        (lambda: mdr.Machine([mdr.Drive("d")]), "no body is free"),
        (lambda: mdr.Machine([mdr.Mass("a", 1), mdr.Drive("d")], [mdr.Force("d", 1)]), "is a Drive"),
        (lambda: mdr.Drive("s", amplitude="1 um"), "one of each"),
        (lambda: mdr.Drive("s", 0, 0, 1e-6, 0.0), "above 0 Hz"),
        (lambda: mdr.Spring({"a": 0}, 1), "the factor 0"),
        (lambda: mdr.Spring("a"), "stiffness and damping are both 0; give"),
        (lambda: mdr.Joint(BALL), "neither normal nor tangential"),
        (lambda: mdr.Machine(None), "None is not a Mass"),
        (lambda: mdr.move(falling(), "-1 s"), "above 0 s"),
        (lambda: mdr.move(falling(), "1 s", steps=1), "from 2 to"),
        (lambda: mdr.move(falling(), "1 s", accuracy=0.0), "at least 1e-12"),
        (lambda: mdr.move("ball", "1 s"), "is not a machine"),
    ],
)
def test_what_is_refused(make, message):
    with pytest.raises(mdr.ProblemError, match=message):
        make()


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        (mdr.Contact(mdr.Sphere("1 mm"), STEEL, adhesion=mdr.JKR("1 J/m^2")), "^adhesive contacts are not"),
        (mdr.Contact(mdr.Sphere("1 mm"), STEEL, friction=mdr.Coulomb(math.inf)), "^mu = inf; .* finite"),
        (
            mdr.Contact(mdr.Sphere("1 mm"), mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), 0.5)),
            "^bodies with memory",
        ),
    ],
)
def test_contacts_that_a_machine_does_not_take(contact, message):
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.move(mdr.Machine([mdr.Mass("a", 1)], [mdr.Joint(contact, "a")]), "1 s")


@pytest.mark.parametrize("joint", [mdr.Joint(BALL, "a"), mdr.Joint(BALL, (), "a", indentation=1e-6)])
def test_a_body_that_nothing_holds_flies_on(joint):
    """Without stiffness there is no period, whether the contact never touches or has no friction."""
    motion = mdr.move(mdr.Machine([mdr.Mass("a", 1.0, velocity=-1.0)], [joint]), 1.0, steps=2)
    assert motion["position"].values[:, 0] == pytest.approx([0.0, -0.5, -1.0])


def test_a_body_that_is_pulled_away_without_end_is_an_error():
    tip = mdr.Contact(mdr.Sphere("1 mm"), STEEL)
    pushed = mdr.Machine([mdr.Mass("a", 1.0)], [mdr.Joint(tip, "a"), mdr.Force("a", "1 GN")])
    with pytest.raises(mdr.PathError):
        mdr.move(pushed, "10 ms", steps=10)


def test_a_sphere_beyond_the_paraboloid_bounces_as_in_impact():
    """Curves of a sphere are a table, which is made deeper until the motion stays inside."""
    ball = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    known = mdr.impact(ball, mass=0.033, speed=1.0)
    machine = mdr.Machine([mdr.Mass("ball", 0.033, velocity=1.0)], [mdr.Joint(ball, "ball")])
    motion = mdr.move(machine, known.contact_time, steps=100, accuracy=1e-6)
    assert float(motion["indentation"].max()) == pytest.approx(known.largest_indentation, rel=1e-3)
    assert float(motion["velocity"][-1, 0]) == pytest.approx(-1.0, rel=1e-4)


def test_tables_files_and_figures(tmp_path):
    motion = mdr.move(pulled(2e-3, 2e3), 0.1, steps=50)
    motion.to_csv(tmp_path / "m.csv")
    header = (tmp_path / "m.csv").read_text().splitlines()[0]
    assert "position of slider [m]" in header
    assert "normal_force of contact [N]" in header
    motion.save(tmp_path / "m.nc")
    figure = motion.plot()
    assert len(figure.axes) == 4
    assert not faults(figure)
    assert "work of drives" in motion.summary()
    with pytest.raises(mdr.QuantityError, match="it has contact"):
        motion.spectrum("normal_force", "pad")


def test_a_case_file_is_the_machine(tmp_path):
    case = {
        "profile": {"kind": "paraboloid", "radius": "10 mm"},
        "body": {"kind": "elastic", "young": "210 GPa", "poisson": 0.3},
        "machine": {
            "duration": "100 us",
            "bodies": [{"kind": "mass", "name": "ball", "mass": "33 g", "velocity": "1 m/s"}],
            "links": [{"kind": "joint", "normal": {"ball": 1}}],
        },
    }
    read = decode_machine(case)
    assert read.machine == falling()
    for key, value, message in (
        ("bodes", 1, "unknown key"),
        ("bodies", [{"kind": "mas"}], "did you mean 'mass'"),
        ("bodies", [{"kind": "mass", "name": "b", "mas": 1}], "mas = 1: unknown key; did you mean 'mass'"),
        (
            "links",
            [{"kind": "joint", "qqq": 1}],
            r"qqq = 1: unknown key; use one of kind, normal, tangential",
        ),
        ("bodies", [{"kind": "mass", "name": "b"}], "key 'mass' is missing"),
        ("links", [{"kind": "joint", "contact": 1}], "all joints"),
        ("links", {"kind": "joint"}, "give one"),
    ):
        with pytest.raises(mdr.CaseError, match=message):
            decode_machine({**case, "machine": {**case["machine"], key: value}})
    for key, value in (("path", [{"kind": "indent", "indentation": "1 um"}]), ("solve", {}), ("stress", {})):
        with pytest.raises(mdr.CaseError, match=rf"\[{key}\].* beside \[machine\] it is not read.*pymdr run"):
            decode_machine({**case, key: value})
    with pytest.raises(mdr.CaseError, match=r"\[machine\] is missing"):
        decode_machine({key: value for key, value in case.items() if key != "machine"})


def test_all_wrong_values_of_a_case_are_told_at_once():
    case = {
        "profile": {"kind": "paraboloid", "radius": "-10 mm"},
        "body": {"kind": "elastic", "young": "210 GPa", "poisson": 0.7},
        "machine": {
            "duration": "0 s",
            "steps": 1,
            "bodies": [{"kind": "mass", "name": "ball", "mass": "1 N"}, {"kind": "drive", "name": ""}],
            "links": [{"kind": "joint", "normal": {"ball": 0}}, {"kind": "spring", "between": 3}],
        },
    }
    with pytest.raises(mdr.CaseError) as refused:
        decode_machine(case)
    for words in (
        r"\[profile\] \S*radius = '-10 mm': it must be above 0 m",
        r"\[body\] \S*poisson = 0.7: it must be above -1 and at most 0.5",
        r"\[machine\] \S*duration = '0 s': it must be above 0 s",
        r"\[machine\] steps = 1: it must be at least 2",
        r"\[machine.bodies 1\] \S*mass: 'N' does not fit",
        r"\[machine.bodies 2\] name = '': a text of at least one character is needed",
        r"\[machine.links 1\] \S*normal: 'ball' has the factor 0",
        r"\[machine.links 2\] \S*between = 3: give a body, a pair",
    ):
        assert re.search(words, str(refused.value)), words
    assert len(str(refused.value).split("; [")) == 8
    # a registered kind clears the models of all cases
    forget_models()
    assert machine_adapter() is machine_adapter()


def test_a_new_case_is_valid_and_as_the_schema_has_it(tmp_path, shell):
    status, text, _ = shell("new", "machine")
    assert status == 0
    (tmp_path / "m.toml").write_text(text)
    assert shell("check", str(tmp_path / "m.toml"))[0] == 0
    assert shell("move", tmp_path / "m.toml", "-o", tmp_path / "out")[0] == 0
    with (tmp_path / "out" / "move.csv").open() as rows:
        last = {
            name.split(" [")[0]: float(value or "nan") for name, value in [*csv.DictReader(rows)][-1].items()
        }
    # the slider slides by millimetres: friction dissipates its limit times the way
    friction = 0.3 * last["normal_force of pad"]
    assert last["position of slider"] > 1e-3
    assert last["dissipated_energy"] == pytest.approx(friction * last["position of slider"], rel=2e-3)
    machine_adapter().validate_python(tomllib.loads(text))
    status, plain, _ = shell("schema", "--machine")
    assert status == 0
    assert {"mass", "rotor", "drive", "spring", "joint", "force"} <= set(json.loads(plain)["$defs"])
    for wrong in ("stps = 1000", "steps = 1.5"):
        with pytest.raises(ValueError, match="validation error"):
            machine_adapter().validate_python(tomllib.loads(text.replace("steps = 1000", wrong)))


def test_the_springs_of_a_joint_in_motion(tmp_path):
    motion = mdr.move(pulled(2e-3, 2e3), 0.1, steps=50)
    motion.animate(tmp_path / "pad.gif", rows=[0, 25, -1])
    with Image.open(tmp_path / "pad.gif") as animation:
        assert animation.n_frames == 3
    with pytest.raises(mdr.FileError, match="is a GIF"):
        motion.animate(tmp_path / "pad.png")
    with pytest.raises(mdr.QuantityError, match="the joints are contact"):
        motion.animate(tmp_path / "pad.gif", joint="pad")
    with pytest.raises(mdr.QuantityError):
        motion.animate(tmp_path / "pad.gif", rows=[51])
    with pytest.raises(mdr.QuantityError, match="whole number"):
        motion.animate(tmp_path / "pad.gif", rows=[0.5])


CASE = """
[profile]
kind = "paraboloid"
radius = "10 mm"
[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
[machine]
duration = "100 us"
steps = 20
[[machine.bodies]]
kind = "mass"
name = "ball"
mass = "33 g"
velocity = "1 m/s"
[[machine.links]]
kind = "joint"
normal = "ball"
"""


def test_the_shell_moves_a_case(tmp_path, shell, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(CASE)
    status, out, _ = shell("move", "ball.toml", "-o", "out")
    assert status == 0
    assert "largest at contact" in out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["move.csv", "move.png"]
    assert shell("move", "ball.toml", "--animate")[0] == 2
    status, out, _ = shell("check", "ball.toml")
    assert status == 0
    assert "1 body and 1 link" in out
    for right, wrong, message in (
        ('"100 us"', '"-1 s"', "above 0 s"),
        ('"100 us"', '"soon"', "cannot read 'soon'"),
        ("steps = 20", "steps = 1", "it must be at least 2"),
        (
            "steps = 20",
            "accuracy = 2",
            "wrong.toml: [machine] accuracy = 2: it must be below 1",
        ),
        ("steps = 20", "accuracy = nan", "wrong.toml: [machine] accuracy = nan"),
        ('"33 g"', '"0 g"', "above 0 kg"),
    ):
        (tmp_path / "wrong.toml").write_text(CASE.replace(right, wrong))
        for command in ("check", "move"):
            status, _, error = shell(command, "wrong.toml")
            assert status == 1
            assert message in error
    status, _, error = shell("run", "ball.toml")
    assert status != 0
    assert "use pymdr move" in error


def test_the_shell_animates_a_motion(tmp_path, shell, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(CASE)
    status, out, _ = shell("move", "ball.toml", "-o", "out", "--animate")
    assert status == 0
    assert "move.gif" in out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["move.csv", "move.gif", "move.png"]
    assert (tmp_path / "out" / "move.gif").read_bytes()[:4] == b"GIF8"


def random_machine(rng):
    """A slider, three linked coordinates or a chain, from nm to m, with springs, drives and friction."""
    length, young = 10.0 ** rng.uniform(-9, 0), 10.0 ** rng.uniform(3, 11)
    body, shape = mdr.Elastic(young, 0.5), rng.choice([0, 1])
    profile = mdr.Paraboloid(length) if shape else mdr.Cone(slope=0.1)
    mu = rng.choice([0.0, 10.0 ** rng.uniform(-1.5, 0.5)])
    contact = mdr.Contact(profile, body, friction=mdr.Coulomb(mu) if mu else None)
    depth, m = 1e-3 * length, 1e3 * length**3
    k = 2 * mdr.effective_moduli(body).normal * math.sqrt(length * depth)
    period, (a, b, c, d) = math.sqrt(m / k), rng.uniform(0.2, 2, 4)
    if rng.random() < 0.5:
        bodies = [
            mdr.Mass("z", m, 0.1 * a * depth, -b * depth / period),
            mdr.Mass("x", m, 0, c * depth / period),
            mdr.Drive("d", 0, 0.1 * depth / period, d * depth, 0.2 / period),
        ]
        links = [
            mdr.Joint(contact, "z", "x", indentation=0.5 * depth),
            mdr.Spring(("x", "d"), a * k, 0.1 * b * m / period),
            mdr.Force("z", c * k * depth, 0.5 * k * depth, 0.3 / period),
        ]
    else:
        speeds = rng.uniform(-1, 1, 3) * depth / period
        bodies = [mdr.Mass(f"b{i}", m * b, velocity=v) for i, v in enumerate(speeds)]
        links = [
            mdr.Joint(contact, (f"b{i}", f"b{i + 1}"), name=f"c{i}", indentation=(c - i) * depth)
            for i in (0, 1)
        ]
        links.append(mdr.Spring("b0", a * k))
    return mdr.Machine(bodies, links), rng.uniform(3, 20) * period


def covers(seed):
    """Whether the stated errors cover the distances from the motion in steps an eighth as long, in all rows."""
    rng = np.random.default_rng(seed)
    machine, span = random_machine(rng)
    motion = mdr.move(machine, span, steps=40, accuracy=10.0 ** rng.uniform(-5, -2))
    mapped = {joint.contact: map_contact(joint.contact) for joint in machine.joints}
    system = system_of(machine, mapped, dict.fromkeys(mapped, math.inf))
    true = follow_motion(system, span / motion.data.attrs["steps"] / 8, 40, motion.data.attrs["steps"] // 5)
    columns = {"position": true.position, "indentation": true.joints[:, :, 0]}
    columns |= {"normal_force": true.joints[:, :, 2], "contact_radius": true.joints[:, :, 4]}
    columns |= {name: true.energies[:, i] for i, name in enumerate(ENERGIES)}
    if "shift" in motion.data:
        columns["tangential_force"] = true.joints[:, :, 3]
        assert motion.claims["stick_radius"].error is None
        assert "jumps where slip reverses" in motion.claims["stick_radius"].reason
    for name in columns.keys() & motion.data.keys():
        ours = motion.data[name].values.reshape(41, -1)
        size = np.abs(ours).max(axis=0)
        off = np.abs(ours - columns[name].reshape(41, -1)) / np.where(size > 0.0, size, 1.0)
        stated = motion.claims[name].error
        if stated is not None:
            assert np.all(off.max(axis=1) <= stated + 1e-11), (seed, name)


@pytest.mark.parametrize("seed", range(6))
def test_stated_errors_cover_the_true_ones(seed):
    covers(seed)


def test_stated_errors_cover_the_true_ones_of_many_machines():
    for seed in range(100, 220):
        covers(seed)
