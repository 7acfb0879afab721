"""Hysteresis of adhesion: an edge that advances and recedes at two works against closed forms, limits and rings."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import pymdr as mdr
from drawing import examples
from pymdr.errors import ProblemError
from pymdr.workbench.casefile import read_case

BALL = mdr.Paraboloid(1.0)
SOFT = mdr.Elastic(1.0, 0.0)
GRADED = mdr.Graded("30 kPa", "1 mm", 0.4, 0.3)
LAYER = mdr.Layered([mdr.Layer(mdr.Elastic("30 kPa", 0.45), "0.2 mm")], mdr.Rigid())


def contact(advancing=0.2, receding=1.0, profile=BALL, body=SOFT):
    return mdr.Contact(profile, body, adhesion=mdr.JKR(advancing, work_receding=receding))


def opening(radius, work):
    """The elongation of the edge on a half-space with E* = 1."""
    return math.sqrt(2.0 * math.pi * radius * work)


def test_the_loop_of_a_ball(references):
    entry = references["hysteresis_jkr"]
    given, expected = entry["inputs"], entry["expected"]
    body = contact(given["adv"], given["rec"])
    top, rest = given["d_max"], expected["d_unpin"]
    levels = [rest + 1e-6, rest - 1e-6]
    path = mdr.indent(top, steps=7) >> mdr.Path(indentation=levels) >> mdr.indent(-2.0)
    result = mdr.solve(body, path)
    a, force = result["contact_radius"].values, result["normal_force"].values
    assert a[6] == pytest.approx(expected["a_max"], rel=1e-8)
    assert a[7] == a[6] > a[8]
    assert force[7] == pytest.approx(expected["F_unpin"], rel=2e-6)
    assert result["external_work"].values[-1] == pytest.approx(expected["loop"], rel=1e-10)
    assert result["dissipated_energy"].values[-1] == result["external_work"].values[-1]
    spent = (given["rec"] - given["adv"]) * math.pi * a[6] ** 2
    assert result["adhesion_dissipation"].values[-1] == pytest.approx(spent, rel=1e-13)
    assert result.status is mdr.Status.PULLED_OFF


def test_the_edge_rests_like_a_punch_between_both_works():
    result = mdr.solve(
        contact(), mdr.indent(1.0, steps=5) >> mdr.indent(-0.7, steps=5) >> mdr.indent(0.9, steps=5)
    )
    a, d, force = (result[name].values[4:] for name in ("contact_radius", "indentation", "normal_force"))
    released = result["energy_release_rate"].values[4:]
    assert np.ptp(a) == 0.0
    assert np.diff(force) == pytest.approx(2.0 * a[0] * np.diff(d), rel=1e-12)
    assert released == pytest.approx((a**2 - d) ** 2 / (2.0 * math.pi * a), rel=1e-12)
    assert np.all((released >= 0.2 * (1.0 - 1e-12)) & (released <= 1.0))
    assert result["normal_stiffness"].values[5:] == pytest.approx(2.0 * a[1:], rel=1e-12)


@pytest.mark.parametrize("machine", [math.inf, 3.0])
def test_an_edge_that_returns_to_where_it_stopped_rests(machine):
    """In one leg and in several; rounding does not decide."""
    channel = "indentation" if math.isinf(machine) else "travel"
    for top in np.random.default_rng(4).uniform(0.3, 1.0, 8).tolist():
        levels = [top, 0.9 * top, top, top, 0.8 * top, top]
        legs = mdr.travel(top) >> mdr.travel(0.9 * top) >> mdr.travel(top, steps=2)
        for path in (mdr.Path(**{channel: levels}), legs):
            result = mdr.solve(contact(profile=mdr.Cone(slope=0.5)), path, machine_stiffness=machine)
            a, stiffness = (result[name].values for name in ("contact_radius", "normal_stiffness"))
            assert np.ptp(a) == 0.0
            assert abs(stiffness[0] / (2.0 * a[0]) - 1.0) > 0.1
            assert stiffness[1:] == pytest.approx(2.0 * a[1:], rel=1e-12)


def test_the_work_of_a_loop_is_the_area_of_its_curve():
    path = mdr.indent(1.0, steps=2000) >> mdr.indent(-1.2, steps=4000) >> mdr.indent(0.5, steps=3000)
    result = mdr.solve(contact(), path >> mdr.indent(-2.5, steps=5000))
    d, force = (result[name].values for name in ("indentation", "normal_force"))
    jumped = result["jumped"].values > 0.0
    area = 0.5 * (force[1:] + force[:-1]) * np.diff(d)
    # the row of a jump has both ends at other states: its area from the energies
    smooth = ~jumped[1:]
    work = np.diff(result["external_work"].values)
    assert np.sum(area[smooth]) == pytest.approx(np.sum(work[smooth]), rel=1e-6)
    assert jumped.sum() == 2


@pytest.mark.parametrize(
    ("body", "k"), [(SOFT, 0.0), (SOFT, 20.0), (GRADED, 0.0), (GRADED, math.inf), (LAYER, math.inf)]
)
def test_pull_off_after_a_deep_press_is_that_of_the_receding_work(body, k):
    ball, scale = mdr.Sphere("1 mm"), 1.0
    if body is SOFT:
        ball, body, scale = BALL, SOFT, 10.0
    made = contact("20 mJ/m^2", "100 mJ/m^2", ball, body)
    plain = mdr.Contact(ball, body, adhesion=mdr.JKR("100 mJ/m^2"))
    deep = 0.05 * scale if body is SOFT else "60 um"
    one, other = (mdr.pull_off(each, machine_stiffness=k, pressed_to=deep) for each in (made, plain))
    assert one.normal_force == pytest.approx(other.normal_force, rel=1e-10)
    assert one.contact_radius == pytest.approx(other.contact_radius, rel=1e-7)
    advancing = mdr.pull_off(mdr.Contact(ball, body, adhesion=mdr.JKR("20 mJ/m^2")), machine_stiffness=k)
    assert mdr.pull_off(made, machine_stiffness=k).jump_in_radius == pytest.approx(
        advancing.jump_in_radius, rel=1e-12
    )


def test_a_light_press_is_forgotten_where_the_edge_first_recedes():
    receding, advancing = 1.0, 0.1
    a0 = brentq(lambda a: 4.0 * a**3 / 3.0 - 2.0 * a * opening(a, advancing), 0.1, 5.0)
    force = 4.0 * a0**3 / 3.0 - 2.0 * a0 * opening(a0, receding)
    light = mdr.pull_off(contact(advancing, receding), machine_stiffness=0.0)
    assert light.normal_force == pytest.approx(force, rel=1e-12)
    assert light.normal_force > -1.5 * math.pi * receding
    path = mdr.load(0.0) >> mdr.Path(normal_force=[force * (1.0 - 1e-9), force * (1.0 + 1e-9)])
    result = mdr.solve(contact(advancing, receding), path)
    assert result["jumped"].values.tolist() == [1.0, 0.0, 1.0]


def test_a_flat_punch_stays_until_the_receding_work():
    flat = contact(0.2, 1.0, mdr.FlatPunch(1.0))
    limit = math.sqrt(8.0 * math.pi)
    result = mdr.solve(
        flat, mdr.indent(1.0, steps=3) >> mdr.load(-limit * (1.0 - 1e-9), steps=3) >> mdr.load(-limit * 1.001)
    )
    assert result["contact_radius"].values[:-1] == pytest.approx(1.0)
    assert result["normal_force"].values[:3] == pytest.approx([2 / 3, 4 / 3, 2.0], rel=1e-12)
    assert result["jumped"].values[-1] == 1.0
    assert result.status is mdr.Status.PULLED_OFF


def test_equal_works_are_the_reversible_law():
    path = (
        mdr.indent(1.0, steps=9)
        >> mdr.indent(-0.5, steps=9)
        >> mdr.indent(0.4, steps=5)
        >> mdr.indent(-3.0, steps=40)
    )
    plain = mdr.solve(mdr.Contact(BALL, SOFT, adhesion=mdr.JKR(1.0)), path)
    near = mdr.solve(contact(1.0, 1.0 + 1e-12), path)
    for name in ("normal_force", "contact_radius", "elastic_energy", "dissipated_energy"):
        assert near[name].values == pytest.approx(plain[name].values, rel=1e-9, abs=1e-10)
    assert mdr.JKR(1.0, work_receding=1.0).has_hysteresis is False


@settings(max_examples=examples(20), deadline=None)
@given(
    st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=6),
    st.floats(1.01, 30.0),
    st.sampled_from([0.0, 1e-9, 1.0]),
    st.floats(-8.0, 1.0),
)
def test_random_histories(turns, ratio, stiffness, size):
    """Energies, bounds, independence of the steps and similarity, from nanometres to metres."""
    R, modulus, work = 10.0**size, 1e6, 1e6 * 10.0**size * 1e-3
    unit = (work**2 * R / modulus**2) ** (1.0 / 3.0)
    body = mdr.Contact(
        mdr.Paraboloid(R), mdr.Elastic(modulus, 0.0), adhesion=mdr.JKR(work, work_receding=ratio * work)
    )
    machine = None if stiffness == 0.0 else (modulus * unit if stiffness == 1.0 else 1e9 * modulus * R)
    leg = mdr.indent if machine is None else mdr.travel
    targets = [5.0 * unit, *(4.0 * t * ratio * unit for t in turns)]
    many, few = (_joined([leg(t, steps=n) for t in targets], body, machine) for n in (7, 1))
    spent = many["dissipated_energy"].values
    assert np.all(np.diff(spent) >= -1e-12 * spent[-1])
    assert spent[0] >= 0.0
    released = many["energy_release_rate"].values[many["contact_radius"].values > 0.0]
    assert np.all((released >= work * (1.0 - 1e-7)) & (released <= ratio * work * (1.0 + 1e-7)))
    for name in (
        "normal_force",
        "contact_radius",
        "dissipated_energy",
        "adhesion_dissipation",
        "external_work",
    ):
        coarse, fine = few[name].values, many[name].values[6::7]
        assert coarse == pytest.approx(fine, rel=1e-8, abs=1e-9 * np.max(np.abs(fine)))
    scaled = mdr.Contact(BALL, mdr.Elastic(1.0, 0.0), adhesion=mdr.JKR(1e-3, work_receding=ratio * 1e-3))
    if machine is None:
        same = _joined([mdr.indent(t / R) for t in targets], scaled, None)
        assert few["normal_force"].values / (modulus * R**2) == pytest.approx(
            same["normal_force"].values, rel=1e-7, abs=1e-9 * np.max(np.abs(same["normal_force"].values))
        )


def _joined(legs, body, machine):
    path = legs[0]
    for leg in legs[1:]:
        path = path >> leg
    return mdr.solve(body, path, machine_stiffness=machine)


def test_pressure_and_gap_of_an_edge_at_rest():
    result = mdr.solve(contact(), mdr.indent(1.0) >> mdr.indent(0.2))
    a = float(result["contact_radius"][1])
    points, weights = np.polynomial.legendre.leggauss(96)
    angle = math.pi / 4 * (points + 1.0)
    pressure = result.field("pressure", a * np.sin(angle), step=1).values
    force = np.sum(weights * math.pi / 4 * pressure * 2 * math.pi * a**2 * np.sin(angle) * np.cos(angle))
    assert force == pytest.approx(float(result["normal_force"][1]), rel=1e-9)
    assert np.all(result.field("gap", np.linspace(1.001 * a, 3.0 * a, 50), step=1).values > 0.0)
    intensity = float(result["stress_intensity"][1])
    assert intensity**2 / 2.0 == pytest.approx(float(result["energy_release_rate"][1]), rel=1e-12)


def test_rings_agree_where_the_edge_moves_and_rests():
    path = mdr.indent(1.0, steps=20) >> mdr.indent(-1.5, steps=20)
    assert mdr.verify(contact(), path).largest_difference < 1e-6


def test_case_file_saving_and_figures(tmp_path):
    case = tmp_path / "sticky.toml"
    case.write_text(
        '[profile]\nkind = "sphere"\nradius = "1 mm"\n[body]\nkind = "elastic"\nyoung = "30 kPa"\npoisson = 0.5\n'
        '[adhesion]\nkind = "jkr"\nwork = "20 mJ/m^2"\nwork_receding = "100 mJ/m^2"\n'
        '[solve]\nmachine_stiffness = "20 N/m"\n'
        '[[path]]\nkind = "travel"\ntravel = "40 um"\nsteps = 10\n[[path]]\nkind = "travel"\ntravel = "-150 um"\nsteps = 40\n'
    )
    read = read_case(case)
    result = mdr.solve(read.contact, read.path, **read.options)
    assert result.status is mdr.Status.PULLED_OFF
    result.save(tmp_path / "sticky.nc")
    again = mdr.open_result(tmp_path / "sticky.nc")
    assert again.contact == result.contact
    drawn = again.figures()
    assert {"section", "loop", "radius", "fields"} <= set(drawn)
    loop = drawn["loop"].axes[0]
    assert len([line for line in loop.lines if line.get_label() == "jump"]) == 1
    assert "adhesion_dissipation" in result.summary() or "hysteresis" in result.summary()
    mdr.pull_off(result.contact).plot()


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: mdr.JKR(1.0, work_receding=0.5), "at least work"),
        (lambda: mdr.JKR(1.0, work_receding=-1.0), "above 0"),
        (lambda: mdr.JKR(1.0, work_receding="1 N"), "J/m"),
        (
            lambda: mdr.fit(
                contact(), mdr.MeasuredCurve(force=np.arange(9.0), indentation=np.arange(9.0)), ["body.young"]
            ),
            "begins in contact",
        ),
        (lambda: mdr.solve(contact(), mdr.load(-1.0)), "out of contact cannot be pulled"),
    ],
)
def test_refusals(made, words):
    with pytest.raises((ProblemError, mdr.UnitError, mdr.PathError), match=words):
        made()


def test_the_regime_is_that_of_the_receding_work():
    plain = mdr.Contact(BALL, SOFT, adhesion=mdr.JKR(1.0))
    one, other = (mdr.adhesion_regime(each, range=0.1) for each in (contact(), plain))
    assert one.maugis == other.maugis


@settings(max_examples=examples(25), deadline=None)
@given(
    rows=st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=8),
    ratio=st.floats(1.01, 20.0),
    stiffness=st.sampled_from([None, 0.5, 20.0]),
)
def test_rows_of_one_leg_are_those_of_a_leg_each(rows, ratio, stiffness):
    """A leg may begin with a turn: its first row advances, and the second recedes."""
    joint = contact(0.2, 0.2 * ratio)
    channel = "indentation" if stiffness is None else "travel"
    whole = mdr.solve(joint, mdr.Path(**{channel: rows}), machine_stiffness=stiffness)
    path = mdr.ramp(**{channel: rows[0]})
    for value in rows[1:]:
        path = path >> mdr.ramp(**{channel: value})
    cut = mdr.solve(joint, path, machine_stiffness=stiffness)
    for name in ("contact_radius", "normal_force", "adhesion_dissipation", "dissipated_energy"):
        last = cut[name].values[-len(rows) :]
        assert whole[name].values == pytest.approx(last, rel=1e-9, abs=1e-9)
