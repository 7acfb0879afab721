"""Pull-off of bodies with memory at a speed after a dwell: limits, time scaling, a machine, the shell and what is refused."""

import json
import math

import numpy as np
import pytest

import pymdr as mdr
from pymdr.errors import ProblemError
from pymdr.workbench.case_studies import contact_studies, pull_off_of
from pymdr.workbench.casefile import read_case

BALL = mdr.Paraboloid(1.0)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
"""E* relaxes from 10 to 1 Pa in 1 s."""
TACKY = mdr.Contact(BALL, RUBBER, adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
CASE = """
[profile]
kind = "paraboloid"
radius = "1 mm"
[body]
kind = "viscoelastic"
poisson = 0.5
shear = { kind = "standard_solid", equilibrium = "10 kPa", modulus = "30 kPa", time = "1 s" }
[adhesion]
kind = "maugis_dugdale"
work = "50 mJ/m^2"
range = "8 um"
"""


@pytest.mark.parametrize("name", ["s2_v0.1", "s2_v1"])
def test_after_a_long_dwell_the_pull_is_that_of_an_independent_solution(references, name):
    entry = references[f"visco_md_{name}"]
    speed, expected = entry["inputs"]["v"], entry["expected"]
    test = mdr.pull_off(TACKY, pressed_to=1.0, dwell="1e4 s", speed=speed, approach_speed=1.0)
    claim = test.claims["largest_pull"]
    assert test.largest_pull == pytest.approx(expected["F_min"], rel=2e-4)
    assert abs(test.largest_pull / expected["F_min"] - 1.0) < 2.0 * float(claim.error[0]) + 1e-5
    assert test.indentation == pytest.approx(expected["d_lost"], abs=1e-3)
    # the reference knows the depth of the flat minimum to 2e-3
    bound = float(test.claims["largest_pull_indentation"].error[0]) * abs(test.largest_pull_indentation)
    assert abs(test.largest_pull_indentation - expected["d_at_F_min"]) < bound + 2e-3
    assert 0.0 < bound < 0.1
    rows = test.result
    lowest = int(np.argmin(rows["normal_force"].values))
    assert test.largest_pull_radius == float(rows["contact_radius"][lowest])
    assert test.external_work == float(rows["external_work"][-1])


def test_a_slow_test_of_little_memory_is_elastic_and_needs_the_work_of_adhesion():
    """One relaxation time to 0: the relaxed body, whose effective work is the work."""
    faint = mdr.Viscoelastic(mdr.StandardSolid(0.25, 0.05, 1e-7), poisson=0.5)
    law = mdr.MaugisDugdale(1.0, strength=2.0)
    test = mdr.pull_off(mdr.Contact(BALL, faint, adhesion=law), pressed_to=1.0, speed=0.1)
    elastic = mdr.pull_off(mdr.Contact(BALL, mdr.Elastic(0.75, 0.5), adhesion=law), pressed_to=1.0)
    assert test.largest_pull == pytest.approx(elastic.largest_pull, rel=2e-4)
    assert test.indentation == pytest.approx(elastic.indentation, rel=2e-3)
    assert test.effective_work == pytest.approx(1.0, rel=4e-4)


def test_the_preload_is_reached_and_time_scales():
    given = {"preload": 2.0, "dwell": 0.5, "speed": 0.3, "machine_stiffness": 3.0}
    test = mdr.pull_off(TACKY, **given)
    assert test.preload == pytest.approx(2.0, rel=1e-5)
    assert test.travel == pytest.approx(test.indentation + test.normal_force / 3.0, rel=1e-9)
    slower = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1e3), poisson=0.5)
    alike = mdr.Contact(BALL, slower, adhesion=TACKY.adhesion)
    scaled = mdr.pull_off(alike, **(given | {"dwell": 500.0, "speed": 0.3e-3}))
    for name in ("largest_pull", "effective_work", "external_work", "indentation"):
        # rounded times change the choice of steps
        assert getattr(scaled, name) == pytest.approx(getattr(test, name), rel=5e-6)


def test_a_curve_lies_between_its_limits():
    speeds = [0.1, 100.0]
    curve = mdr.pull_off_curve(TACKY, speed=speeds, dwell=[0.0, 20.0], pressed_to=1.0, approach_speed=1.0)
    pull = -curve["largest_pull"].values
    slow, fast = -float(curve["slow_limit"]), -curve["fast_limit"].values
    # after a long dwell the pull rises with the speed up to the fast limit
    assert slow < pull[0, 1] < pull[1, 1] < fast[1] * (1.0 + 1e-3)
    assert pull[1, 1] == pytest.approx(fast[1], rel=0.03)
    assert (pull[:, 1] >= pull[:, 0] * (1.0 - 1e-3)).all()
    assert fast[1] > fast[0]
    work = curve["effective_work"].values
    assert ((work > 1.0) & (work < 10.0)).all()
    one = mdr.pull_off(TACKY, speed=0.1, dwell=20.0, pressed_to=1.0, approach_speed=1.0)
    assert one.largest_pull == pytest.approx(float(curve["largest_pull"][0, 1]), rel=1e-9)
    loops = curve.plot().axes[0].get_lines()
    # after the last dwell, one for every speed
    lowest = [float(line.get_ydata().min()) for line in loops[: len(speeds)]]
    assert lowest == pytest.approx(curve["largest_pull"].values[:, 1].tolist(), rel=1e-12)
    assert len(curve.results) == 4
    assert "effective work" in curve.summary()


def test_the_work_of_the_edge_is_that_of_a_short_zone_where_the_zone_is_short_and_steady():
    """The formula of a short zone does not know the springs of the full law."""
    body = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
    probe = mdr.Contact(mdr.Paraboloid("1 mm"), body, adhesion=mdr.MaugisDugdale(0.05, range="2 um"))
    test = mdr.pull_off(probe, pressed_to="10 um", dwell="60 s", speed="1 um/s", approach_speed="10 um/s")
    edge = test.edge
    V, G, formula, receded = (
        edge[name].values for name in ("edge_speed", "energy_release_rate", "short_zone_work", "receded")
    )
    fraction = (edge["zone_length"] / edge["contact_radius"]).values
    steady = (receded > 2.0) & (fraction < 0.04)
    assert steady.sum() > 20
    assert np.abs(formula / G - 1.0)[steady].max() < 0.04
    assert V[steady].max() > 2.0 * V[steady].min()
    assert G[steady].max() > 1.2 * G[steady].min()
    # the whole range of work that memory allows
    assert (G[edge["holds"].values] < 1.2 * float(edge["fast_limit"])).all()
    assert float(edge["fast_limit"]) == pytest.approx(0.2, rel=1e-12)
    assert 0.0 < float(edge["lowest_speed"]) < float(edge["highest_speed"])
    assert "after the edge has receded by a length of its zone" in edge.summary()
    edge.plot()


def test_bodies_without_memory_take_a_preload():
    gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    pulled = mdr.pull_off(gel, preload="1 mN", machine_stiffness=0)
    assert pulled.normal_force == pytest.approx(-1.5 * math.pi * 5e-5, rel=1e-12)
    sticky = mdr.JKR("0.2 mJ/m^2", work_receding="2 mJ/m^2")
    rests = mdr.Contact(mdr.Paraboloid("50 um"), mdr.Elastic("30 kPa", 0.5), adhesion=sticky)
    depth = "1 um"
    force = float(mdr.solve(rests, mdr.indent(depth))["normal_force"][0])
    by_force, by_depth = mdr.pull_off(rests, preload=force), mdr.pull_off(rests, pressed_to=depth)
    assert by_force.largest_pull == pytest.approx(by_depth.largest_pull, rel=1e-9)
    assert by_force.indentation == pytest.approx(by_depth.indentation, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"pressed_to": 1.0}, ProblemError, "give speed="),
        ({"speed": 1.0}, ProblemError, "give preload="),
        ({"speed": 0.0, "preload": 1.0}, ProblemError, "above 0 m/s"),
        ({"speed": 1.0, "preload": -1.0}, ProblemError, "at least 0 N"),
        ({"speed": 1.0, "preload": 1.0, "pressed_to": 1.0}, ProblemError, "one of them"),
        ({"speed": 1.0, "preload": 1.0, "dwell": -1.0}, ProblemError, "at least 0 s"),
        ({"speed": 1.0, "preload": 1.0, "machine_stiffness": 0.0}, ProblemError, "dead load has no speed"),
        ({"speed": "1 s", "preload": 1.0}, mdr.UnitError, "m/s"),
        ({"speed": ["1 m/s", "2 m/s"], "preload": 1.0}, ProblemError, "call pull_off_curve for several"),
        (
            {"speed": 1.0, "dwell": [0.0, 1.0], "preload": 1.0},
            ProblemError,
            "call pull_off_curve for several",
        ),
        (
            {"speed": 1.0, "preload": 1e8},
            ProblemError,
            r"preload = 100 MN: .* would be \d+ \(limit 10; .* give a smaller preload",
        ),
        (
            {"speed": 1.0, "pressed_to": 200.0},
            ProblemError,
            "pressed_to = 200 m: .* give a smaller pressed_to",
        ),
    ],
)
def test_what_a_test_with_memory_refuses(given, error, words):
    with pytest.raises(error, match=words):
        mdr.pull_off(TACKY, **given)


def test_what_bodies_without_memory_refuse():
    gel = mdr.Contact(BALL, mdr.Elastic(1.0, 0.5), adhesion=mdr.MaugisDugdale(1.0, strength=2.0))
    for name, value in (("speed", 1.0), ("dwell", 1.0), ("approach_speed", 1.0)):
        with pytest.raises(ProblemError, match=f"{name} = 1.0, but the bodies have no memory"):
            mdr.pull_off(gel, **{name: value})
    with pytest.raises(ProblemError, match="does not depend on its speed"):
        pull_off_of(gel, edge=True)
    with pytest.raises(ProblemError, match="'gel' is not a Contact"):
        mdr.pull_off("gel")
    with pytest.raises(ProblemError, match="the contact has no adhesion"):
        mdr.pull_off(mdr.Contact(BALL, mdr.Elastic(1.0, 0.5)))
    with pytest.raises(ProblemError, match="call pull_off"):
        mdr.pull_off_curve(gel, speed=[1.0], preload=1.0)


def flowing(shear):
    return mdr.Contact(BALL, mdr.Viscoelastic(shear, poisson=0.5), adhesion=TACKY.adhesion)


def test_a_slow_liquid_is_the_elastic_body_of_its_instantaneous_modulus():
    test = mdr.pull_off(flowing(mdr.Maxwell(0.25, 1e7)), pressed_to=1.0, speed=1.0)
    elastic = mdr.Contact(BALL, mdr.Elastic(0.75, 0.5), adhesion=TACKY.adhesion)
    limit = mdr.pull_off(elastic, pressed_to=1.0)
    assert test.largest_pull == pytest.approx(limit.largest_pull, rel=1e-5)
    assert test.indentation == pytest.approx(limit.indentation, rel=1e-4)
    assert not test.claims["effective_work"].readable
    with pytest.raises(ProblemError, match="the relaxed contact is needed, but the body flows"):
        test.edge.summary()


def test_the_pull_of_a_liquid_is_that_of_rings():
    """Rings of the surface share no springs with the method."""
    liquid, top, speed, dwell = flowing(mdr.Maxwell(2.5, 1.0)), 0.3, 3.0, 0.2
    test = mdr.pull_off(liquid, pressed_to=top, speed=speed, dwell=dwell)
    end, away = (top + 0.5) / speed, np.linspace(0.0, 1.0, 101)[1:]
    press = mdr.Path(time=np.linspace(0.0, end, 40), indentation=np.linspace(-0.5, top, 40))
    path = press >> mdr.hold(dwell) >> mdr.Path(time=end + dwell + away / speed, indentation=top - away)
    force = mdr.solve(liquid, path, solver=mdr.Rings(100))["normal_force"]
    assert test.largest_pull == pytest.approx(float(force.min()), rel=1e-3)


def test_a_curve_of_a_liquid_has_a_fast_limit_only():
    given = {"speed": [1.0, 30.0], "pressed_to": 0.3, "approach_speed": 3.0}
    liquid = mdr.pull_off_curve(flowing(mdr.Maxwell(2.5, 1.0)), **given)
    assert liquid["largest_pull"].values[1, 0] == pytest.approx(float(liquid["fast_limit"][0]), rel=0.02)
    assert not liquid.claims["slow_limit"].readable
    assert len(liquid.plot().axes) == 2


def test_a_curve_of_a_power_of_time_has_no_limits():
    given = {"speed": [1.0, 30.0], "preload": 1.0, "approach_speed": 3.0}
    power = mdr.pull_off_curve(flowing(mdr.PowerLawRheology(1.0, 1.0, 0.2)), **given)
    assert not power.claims["fast_limit"].readable
    rows = power.results[0].data
    path = mdr.Path(time=rows["time"].values[::4], indentation=rows["indentation"].values[::4])
    rings = mdr.solve(power.contact, path, solver=mdr.Rings(160))["normal_force"]
    assert power["largest_pull"].values[0, 0] == pytest.approx(float(rings.min()), rel=3e-3)
    assert "slow limit" not in {text.get_text() for text in power.plot().axes[1].get_legend().get_texts()}


def test_the_command_and_the_table(tmp_path, shell):
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    contact = read_case_contact(case)
    options = ("--preload", "0.2 mN", "--dwell", "1 s", "--approach-speed", "20 um/s")
    code, out, _ = shell("pull-off", case, *options, "--speed", "10 um/s", "--json")
    assert code == 0
    given = {"preload": "0.2 mN", "dwell": "1 s", "approach_speed": "20 um/s"}
    one = mdr.pull_off(contact, speed="10 um/s", **given)
    assert json.loads(out)["study"]["largest_pull"]["values"] == [pytest.approx(one.largest_pull)]
    code, out, _ = shell("pull-off", case, *options, "--speed", "10 um/s", "--edge", "--json")
    assert code == 0
    edge = json.loads(out)["study"]["energy_release_rate"]["values"]
    assert edge == pytest.approx(one.edge["energy_release_rate"].values.tolist())
    folder = tmp_path / "curve"
    code, out, _ = shell("pull-off", case, *options, "--speed", "10 um/s, 100 um/s", "-o", folder)
    assert code == 0
    assert {file.name for file in folder.iterdir()} >= {"pull_off.csv", "pull_off.png"}
    table = '[pull_off]\npreload = "0.2 mN"\nspeed = ["10 um/s", "100 um/s"]\ndwell = "1 s"\n'
    leg = '[[path]]\nkind = "indent"\nindentation = "5 um"\nduration = "1 s"\n'
    case.write_text(CASE + table.replace(', "100 um/s"', "") + 'approach_speed = "20 um/s"\n' + leg)
    code, out, _ = shell("run", case, "--json", "--no-figures")
    assert code == 0
    pulls = json.loads(out)["studies"]["pull_off"]["largest_pull"]["values"]
    assert pulls[0] == pytest.approx(one.largest_pull, rel=1e-9)
    for arguments, words in (
        (("--preload", "0.2 mN"), "give speed="),
        ((*options, "--speed", "5"), "unit is missing"),
        ((*options, "--speed", "-1 um/s"), "above 0 m/s"),
        (("--speed", "1 um/s"), "give preload="),
        ((*options, "--pressed-to", "1 um", "--speed", "1 um/s"), "one of them"),
    ):
        code, _, err = shell("pull-off", case, *arguments)
        assert code != 0
        assert words in err


def read_case_contact(case):
    text = case.read_text()
    case.write_text(text + '[[path]]\nkind = "indent"\nindentation = "5 um"\nduration = "1 s"\n')
    try:
        return read_case(case).contact
    finally:
        case.write_text(text)


def test_a_tolerance_is_passed_on_to_the_solution_of_a_test(tmp_path):
    """In Python, in a sweep and a batch, and from a case file, which `pymdr check` takes too."""
    start = {"pressed_to": 0.5, "speed": 0.5}
    test = mdr.pull_off(TACKY, **start, tolerance=1e-3)
    path = test.result.path
    same = mdr.solve(TACKY, path, tolerance=1e-3)
    assert np.array_equal(test.result["normal_force"], same["normal_force"])
    assert not np.array_equal(test.result["normal_force"], mdr.solve(TACKY, path)["normal_force"])
    swept = mdr.sweep(TACKY, path, over={"adhesion.work": [1.0]}, tolerance=1e-3)
    assert np.array_equal(swept.data["normal_force"].values[0], same["normal_force"])
    (batch,) = mdr.solve_batch([TACKY], path, tolerance=1e-3)
    assert np.array_equal(batch["normal_force"], same["normal_force"])
    pulls = []
    file = tmp_path / "case.toml"
    for options in ("[solve]\ntolerance = 1e-3\n", ""):
        leg = '\n[[path]]\nkind = "indent"\nindentation = "1 um"\nduration = "1 s"\n'
        file.write_text(CASE + options + '[pull_off]\npressed_to = "0.1 mm"\nspeed = "50 um/s"\n' + leg)
        case = read_case(file)
        pulls.append(contact_studies(case)["pull_off"].normal_force)
        assert mdr.assess(case.contact, case.path, **case.options).claims
    direct = mdr.pull_off(case.contact, pressed_to="0.1 mm", speed="50 um/s", tolerance=1e-3)
    assert pulls[0] == direct.normal_force != pulls[1]


@pytest.mark.parametrize("tolerance", [1.0, math.nan, True, "1e-4"])
def test_a_tolerance_out_of_its_limits_is_refused_by_every_verb(tolerance, tmp_path):
    path, over = mdr.indent(0.5, duration=1.0), {"adhesion.work": [1.0, 2.0]}
    for verb in (
        lambda: mdr.pull_off(TACKY, pressed_to=0.5, speed=0.5, tolerance=tolerance),
        lambda: mdr.pull_off_curve(TACKY, pressed_to=0.5, speed=[0.5, 1.0], tolerance=tolerance),
        lambda: mdr.sweep(TACKY, path, over=over, tolerance=tolerance, folder=tmp_path / "kept"),
        lambda: mdr.solve_batch([TACKY], path, tolerance=tolerance),
        lambda: mdr.assess(TACKY, path, tolerance=tolerance),
    ):
        with pytest.raises(ProblemError, match="it must be a number from 1e-6 to 1e-2"):
            verb()
    assert not (tmp_path / "kept").exists(), "a refused value must not take a folder"


@pytest.mark.parametrize("seed", range(4))
def test_a_test_takes_what_solve_takes(seed):
    """Ranges short enough for many nodes: at any speed the zones are measured along the path, as `solve` does."""
    rng = np.random.default_rng(seed)
    size, time, ratio = (
        10.0 ** rng.uniform(-5.0, -3.0),
        10.0 ** rng.uniform(-1.0, 1.0),
        rng.uniform(20.0, 400.0),
    )
    body = mdr.Viscoelastic(mdr.StandardSolid(1e4, 1e4 * ratio, time), poisson=0.5)
    height = (0.05**2 * size / 4e4**2) ** (1.0 / 3.0)
    law = mdr.MaugisDugdale(0.05, range=height * 10.0 ** rng.uniform(-2.0, -1.5))
    contact = mdr.Contact(mdr.Paraboloid(size), body, adhesion=law)
    top, speed = height * rng.uniform(0.5, 3.0), height / time * 10.0 ** rng.uniform(-1.0, 1.0)
    begin = law.attraction_range
    test = mdr.pull_off(contact, pressed_to=top, speed=speed, dwell=time)
    # rows close to the largest pull, which is sharp, and behind the loss of contact
    pull, end = top - test.largest_pull_indentation, (top + begin) / speed
    away = np.append(pull * np.linspace(0.0, 1.02, 501)[1:], 4.0 * pull)
    press = np.linspace(-begin, top, 100)
    path = mdr.Path(time=(press + begin) / speed, indentation=press) >> mdr.hold(time)
    solved = mdr.solve(contact, path >> mdr.Path(time=end + time + away / speed, indentation=top - away))
    assert solved.status is mdr.Status.PULLED_OFF
    assert test.largest_pull == pytest.approx(float(solved["normal_force"].min()), rel=2e-3)


SILICONE = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
PROBE = mdr.Contact(mdr.Paraboloid("1 mm"), SILICONE, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="5 um"))


@pytest.mark.parametrize("machine", [1e-3, 1e-6])
def test_separation_from_a_soft_machine_spends_nothing_in_the_body(machine):
    pull = mdr.pull_off(PROBE, preload="0.1 mN", speed="1 um/s", machine_stiffness=machine)
    (balance,) = (one for one in pull.assumptions if one.name == "energy balance")
    assert balance.measure < 1e-6
    rows = pull.result.data
    # all of the work is dissipated after a long time, most of it the energy of the machine
    assert float(rows["dissipated_energy"][-1]) == pytest.approx(pull.external_work, rel=1e-5)
    assert pull.dissipated_energy == pytest.approx(0.5 * pull.normal_force**2 / machine, rel=1e-3)


def test_lengths_beside_the_travel_of_a_soft_machine_are_shown_and_a_softer_one_is_refused():
    elastic = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    soft, dead = (mdr.pull_off(elastic, machine_stiffness=k) for k in (1e-30, 0.0))
    assert soft.indentation == pytest.approx(dead.indentation, rel=1e-6)
    texts = [next(line for line in str(one).splitlines() if "contact radius" in line) for one in (soft, dead)]
    assert texts[0] == texts[1]


SHORT = mdr.Contact(mdr.Paraboloid("1 mm"), SILICONE, adhesion=mdr.JKR("50 mJ/m^2", range="0.1 um"))


@pytest.mark.parametrize("start", [{"preload": "0.1 mN"}, {"pressed_to": "10 um"}], ids=["preload", "depth"])
@pytest.mark.parametrize("probe", [PROBE, SHORT], ids=["zone", "short"])
def test_a_machine_too_soft_for_numbers_is_refused_with_a_stiffness_that_serves(probe, start):
    test = {"speed": "1 um/s", **start}
    with pytest.raises(
        ProblemError, match=r"machine_stiffness = .*limit 1e\+10.*give a stiffness of at least"
    ) as refused:
        mdr.pull_off(probe, **test, machine_stiffness=1e-30)
    least = str(refused.value).partition("give a stiffness of at least ")[2].partition(",")[0]
    pull = mdr.pull_off(probe, **test, machine_stiffness=least)
    # so slow a test pulls as the relaxed body does
    assert pull.largest_pull == pytest.approx(-1.5 * math.pi * 50e-3 * 1e-3, rel=0.03)


@pytest.mark.parametrize("machine", [1e-3, 1.0, math.inf])
def test_errors_of_a_pull_off_are_known_beside_its_jump_and_contain_those_of_a_finer_solution(machine):
    test = {"preload": "0.1 mN", "speed": "1 um/s", "machine_stiffness": machine}
    pull, fine = mdr.pull_off(PROBE, **test), mdr.pull_off(PROBE, **test, tolerance=1e-5)
    small = {"normal_force", "largest_pull", "dissipated_energy", "external_work", "effective_work"}
    for name, claim in pull.claims.items():
        if claim.error is None:
            continue
        value, best = (float(one.data[name]) for one in (pull, fine))
        assert abs(value - best) <= float(claim.error[0]) * abs(value)
        assert name not in small or float(claim.error[0]) < (0.15 if math.isinf(machine) else 0.02)


def test_a_depth_that_the_jump_into_contact_passes_is_refused():
    with pytest.raises(ProblemError, match=r"passed at first touch.*give a larger value"):
        mdr.pull_off(PROBE, pressed_to="1 um", speed="1 um/s", machine_stiffness=1e-3)
    mdr.pull_off(PROBE, pressed_to="20 um", speed="1 um/s", machine_stiffness=1e-3)
