"""Adhesion and friction through solve: landmarks, energies, fields, endings, files and refusals."""

import math
import pickle
from dataclasses import dataclass, replace

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import pymdr as mdr
from common import GEL, STEEL
from drawing import examples
from pymdr.interpretation.theories import THEORIES
from pymdr.interpretation.validity import EXACT_WITHIN
from pymdr.line.adhesion import power_law_pull_off
from pymdr.line.friction import cattaneo_mindlin, loop_energy
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.values import OptionalSIField, SIField
from pymdr.solving.fits.families import axes_of
from pymdr.solving.fits.unknowns import unknowns_of
from pymdr.solving.teaching import friction_foundation

TIP = mdr.Paraboloid("50 um")
WORK = 2e-3
JKR = mdr.JKR(WORK)
STICKY = mdr.Contact(TIP, GEL, adhesion=JKR)
JOINT = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))


def balance(result):
    return next(a for a in result.assumptions if a.name == "energy balance")


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-9, 0), st.floats(3, 11), st.floats(-4, 1))
def test_landmarks_of_the_paraboloid_at_any_size(log_radius, log_modulus, log_work):
    radius, modulus, work = 10.0**log_radius, 10.0**log_modulus, 10.0**log_work
    contact = mdr.Contact(mdr.Paraboloid(radius), mdr.Elastic(modulus, 0.0), adhesion=mdr.JKR(work))
    pull = math.pi * work * radius
    by_depth, dead = mdr.pull_off(contact), mdr.pull_off(contact, machine_stiffness=0.0)
    assert by_depth.normal_force / pull == pytest.approx(-5 / 6, rel=1e-11)
    assert dead.normal_force / pull == pytest.approx(-3 / 2, rel=1e-11)
    depth = (math.pi**2 * work**2 * radius / modulus**2) ** (1 / 3)
    unit = (work**5 * radius**4 / modulus**2) ** (1 / 3)
    loop = mdr.solve(contact, mdr.indent(depth, steps=3) >> mdr.indent(-2 * depth, steps=7))
    # 7.09 of Thornton and Ning (1998), Powder Technol. 99, 154: both jumps of the JKR sphere, with more digits
    assert float(loop["dissipated_energy"][-1]) / unit == pytest.approx(7.0921959718640, rel=1e-9)
    assert float(loop["external_work"][-1]) / unit == pytest.approx(7.0921959718640, rel=1e-9)
    assert balance(loop).measure < 1e-12
    assert loop.status is mdr.Status.PULLED_OFF


@pytest.mark.parametrize("exponent", [1.0, 1.3, 2.0, 4.0])
@pytest.mark.parametrize("stiffness", [0.0, 1e-3, 1.0, math.inf])
def test_pull_off_of_powers_under_any_machine(exponent, stiffness):
    # a cone is stable under a dead load only beyond 9/4 of its radius at d = 0
    coefficient = 0.5 * 1e-6 ** (1 - exponent)
    profile = mdr.PowerLaw(exponent, coefficient * 1e-6**exponent, "1 um")
    contact = mdr.Contact(profile, mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("2 mJ/m^2"))
    result = mdr.pull_off(contact, machine_stiffness=stiffness)
    exact = power_law_pull_off(exponent, coefficient, 4e4, 2e-3, stiffness)
    assert result.normal_force == pytest.approx(float(exact.normal_force), rel=1e-9)
    assert result.contact_radius == pytest.approx(float(exact.contact_radius), rel=1e-6)


@pytest.mark.parametrize(
    "law", [JKR, mdr.MaugisDugdale(WORK, range="100 nm"), mdr.DMT(WORK)], ids=["jkr", "maugis", "dmt"]
)
@pytest.mark.parametrize("stiffness", [None, "0.05 N/m", "5 N/m"])
def test_energy_balance_and_loss_at_any_number_of_steps(law, stiffness):
    contact = mdr.Contact(TIP, GEL, adhesion=law)
    forces = []
    for steps in (2, 300):
        leg = mdr.indent if stiffness is None else mdr.travel
        path = leg("3 um", steps=steps) >> leg("-25 um", steps=2 * steps)
        result = mdr.solve(contact, path, machine_stiffness=stiffness)
        assert balance(result).measure < 1e-11
        forces.append(float(result["dissipated_energy"][-1]))
        assert forces[-1] == pytest.approx(float(result["external_work"][-1]), rel=1e-9, abs=1e-24)
    assert forces[0] == pytest.approx(forces[1], rel=1e-9, abs=1e-24)


def test_a_wavy_tip_jumps_and_its_jumps_are_the_work():
    tip = mdr.Function(
        lambda r: r**2 / 2 + 0.002 * (1 - np.cos(40 * r)), derivative=lambda r: r + 0.08 * np.sin(40 * r)
    )
    contact = mdr.Contact(tip, mdr.Elastic(1.0, 0.0), adhesion=mdr.JKR(0.02))
    result = mdr.solve(contact, mdr.indent(0.3, steps=50) >> mdr.indent(-0.4, steps=90))
    # the waves of Guduru (2007), J. Mech. Phys. Solids 55, 445, followed on a table of d(a) that is good to 2e-6
    assert float(result["jump_dissipation"].sum()) == pytest.approx(0.0105338202, rel=1e-5)
    assert float(result["external_work"][-1]) == pytest.approx(
        float(result["dissipated_energy"][-1]), rel=1e-9
    )


def test_a_soft_machine_is_a_dead_load_and_a_hard_one_holds():
    for stiffness, exact in ((1e-9, 0.0), (1e9, math.inf)):
        result = mdr.pull_off(STICKY, machine_stiffness=stiffness)
        limit = mdr.pull_off(STICKY, machine_stiffness=exact)
        assert result.normal_force == pytest.approx(limit.normal_force, rel=1e-6)


def test_laws_meet_in_their_limits():
    modulus, scale = mdr.effective_moduli(GEL).normal, math.pi * WORK * 50e-6
    size = (16 * math.pi * WORK * modulus**2 / (9 * 50e-6)) ** (1 / 3) / 2
    pulls = {
        number: mdr.pull_off(
            mdr.Contact(TIP, GEL, adhesion=mdr.MaugisDugdale(WORK, strength=number * size)),
            machine_stiffness=0,
        ).normal_force
        / scale
        for number in (0.1, 0.5, 1.0, 3.0)
    }
    # the equations of Maugis (1992), J. Colloid Interface Sci. 150, 243, for the sphere
    expected = {0.1: -1.950594892, 0.5: -1.718245275, 1.0: -1.600734911, 3.0: -1.516763900}
    assert pulls == pytest.approx(expected, rel=2e-9)


def test_tension_adds_up_to_the_force():
    for law in (JKR, mdr.MaugisDugdale(WORK, range="100 nm")):
        result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=law), mdr.indent("0.5 um"))
        a = float(result["contact_radius"][0])
        c = float(result["cohesive_radius"][0]) if law is not JKR else a

        def around(r, result=result):
            return 2 * math.pi * r * float(result.field("pressure", r=[r])[0])

        inner = quad(
            lambda t, a=a, around=around: around(a * math.sin(t)) * a * math.cos(t), 0, math.pi / 2, epsabs=0
        )[0]
        outer = quad(around, a * (1 + 1e-12), c)[0] if c > a else 0.0
        assert inner + outer == pytest.approx(float(result["normal_force"][0]), rel=1e-7)
        if c > a:
            assert float(result.field("gap", r=[c])[0]) == pytest.approx(100e-9, rel=1e-9)
            assert float(result.field("pressure", r=[0.5 * (a + c)])[0]) == pytest.approx(-WORK / 100e-9)
        else:
            assert float(result["energy_release_rate"][0]) == pytest.approx(WORK, rel=1e-12)


def test_endings():
    assert mdr.solve(STICKY, mdr.indent("1 um")).status is mdr.Status.ATTACHED
    assert mdr.solve(STICKY, mdr.indent("-1 um")).status is mdr.Status.NOT_TOUCHED
    torn = mdr.solve(STICKY, mdr.load("0 N") >> mdr.load("-1 uN", steps=20))
    assert torn.status is mdr.Status.PULLED_OFF
    assert np.isnan(torn["normal_force"].values[-1])
    assert float(np.nanmin(torn["normal_force"])) >= -1.5 * math.pi * WORK * 50e-6
    free = mdr.solve(STICKY, mdr.indent("1 um") >> mdr.indent("-3 um"))
    assert float(free["normal_force"][-1]) == float(free["contact_radius"][-1]) == 0.0


def test_travel_without_adhesion():
    plain = mdr.Contact(TIP, GEL)
    result = mdr.solve(plain, mdr.travel("2 um", steps=5), machine_stiffness="0.5 N/m")
    d, force = (result[name].values for name in ("indentation", "normal_force"))
    np.testing.assert_allclose(d + force / 0.5, result["travel"].values, rtol=1e-13)
    np.testing.assert_allclose(force, 4 / 3 * 40e3 * np.sqrt(50e-6) * d**1.5, rtol=1e-12)


def test_cattaneo_mindlin_in_every_control():
    modulus = mdr.effective_moduli(STEEL, STEEL)
    d = 2e-6
    load = 4 / 3 * modulus.normal * math.sqrt(0.01) * d**1.5
    slide = 0.3 * modulus.normal / modulus.tangential * d
    u = 0.4 * slide
    force = 0.3 * load * (1 - 0.6**1.5)
    for press in (mdr.indent(d), mdr.load(load)):
        for pull in (mdr.shift(u), mdr.drag(force)):
            result = mdr.solve(JOINT, press >> pull)
            assert float(result["tangential_force"][-1]) == pytest.approx(force, rel=1e-12)
            assert float(result["shift"][-1]) == pytest.approx(u, rel=1e-12)
            assert float(result["stick_radius"][-1]) == pytest.approx(math.sqrt(0.6 * d * 0.01), rel=1e-12)


def test_a_cycle_loses_what_mindlin_and_deresiewicz_say():
    result = mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=2, steps=16))
    dissipated = result["dissipated_energy"].values
    modulus = mdr.effective_moduli(STEEL, STEEL)
    ratio = 0.5e-6 / (0.3 * modulus.normal / modulus.tangential * float(result["indentation"][-1]))
    size = 0.3 * 50 * 0.5e-6 / ratio
    fraction = 1 - (1 - ratio) ** 1.5
    exact = size * (8 * (ratio - 0.4 * (1 - (1 - ratio) ** 2.5)) - 4 * ratio * fraction)
    assert dissipated[-1] - dissipated[-9] == pytest.approx(exact, rel=1e-11)
    study = mdr.friction_loop(JOINT, [0.5e-6], normal_force="50 N")
    assert float(study["dissipated_per_cycle"][0]) == pytest.approx(exact, rel=1e-11)


def test_springs_converge_to_the_stack():
    d, u = [1e-6, 2e-6, 2e-6, 1.5e-6], [0.0, 2e-7, -1e-7, 1e-7]
    exact = mdr.solve(JOINT, mdr.Path(indentation=d, shift=u))["tangential_force"].values
    errors = [
        np.max(np.abs(friction_foundation(JOINT, d, u, n=n).tangential_force - exact)) for n in (400, 6400)
    ]
    # second order, but for where a kink falls between two springs: 16 times finer squared is 256
    assert errors[1] < errors[0] / 60


def test_traction_adds_up_and_stays_within_the_limit():
    result = mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift="0.6 um", steps=40))
    a = float(result["contact_radius"][20])
    r = a * np.sin(np.linspace(0, np.pi / 2, 200))
    tau, p = (result.field(name, r=r, step=20).values for name in ("shear_traction", "pressure"))
    assert np.all(np.abs(tau) <= 0.3 * p * (1 + 1e-12))
    b = float(result["stick_radius"][20])
    total = sum(
        quad(lambda s: 2 * np.pi * s * float(result.field("shear_traction", r=[s], step=20)[0]), *ends)[0]
        for ends in ((0, b), (b, a))
    )
    assert total == pytest.approx(float(result["tangential_force"][20]), rel=1e-6)


def test_kept_rows_are_those_of_the_whole_history():
    n = 5000
    path = mdr.Path(indentation=2e-6 + 1e-6 * np.sin(np.arange(n)), shift=3e-7 * np.sin(0.3 * np.arange(n)))
    whole, kept = mdr.solve(JOINT, path), mdr.solve(JOINT, path, keep=100)
    assert kept.data["row"].values.tolist() == list(range(99, n, 100))
    for name in kept.data:
        np.testing.assert_array_equal(kept.data[name].values, whole.data[name].values[99::100])
    r = np.linspace(0, 2e-4, 9)
    one, other = kept.field("shear_traction", r=r, step=7), whole.field("shear_traction", r=r, step=799)
    np.testing.assert_array_equal(one.values, other.values)


@pytest.mark.parametrize(
    "make",
    [
        lambda: mdr.solve(STICKY, mdr.indent("1 um", steps=3) >> mdr.indent("-3 um", steps=9)),
        lambda: mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift="0.6 um", steps=200)),
        lambda: mdr.solve(
            JOINT, mdr.Path(indentation=np.full(500, 2e-6), shift=1e-7 * np.arange(500) / 500), keep=50
        ),
    ],
    ids=["adhesion", "friction", "kept"],
)
def test_files_and_pickles_keep_everything(make, tmp_path):
    result = make()
    result.save(tmp_path / "r.nc")
    for again in (mdr.open_result(tmp_path / "r.nc"), pickle.loads(pickle.dumps(result))):
        assert (again.contact, again.path, again.status) == (result.contact, result.path, result.status)
        assert again.machine_stiffness == result.machine_stiffness
        assert again.data.equals(result.data)
        name = "pressure" if result.starts is None else "shear_traction"
        r = np.linspace(0, 1e-5, 5)
        np.testing.assert_array_equal(again.field(name, r=r, step=0), result.field(name, r=r, step=0))


def test_claims_of_friction():
    path = mdr.load("50 N") >> mdr.shift("0.1 um")
    plain = mdr.Elastic("210 GPa", 0.0)
    exact = mdr.solve(mdr.Contact(mdr.Sphere("10 mm"), plain, plain, friction=mdr.Coulomb(0.3)), path)
    assert exact.claims["tangential_force"].level is mdr.Level.EXACT
    assert mdr.solve(JOINT, path).claims["tangential_force"].level is mdr.Level.APPROXIMATE
    unlike = mdr.solve(mdr.Contact(TIP, STEEL, friction=mdr.Coulomb(0.3)), mdr.load("1 mN"))
    assert unlike.claims["normal_force"].level is mdr.Level.APPROXIMATE
    assert not next(a for a in unlike.assumptions if a.name == "elastic similarity").met


HOLLOW = mdr.Function(lambda r: r**2 / 1e-4 - 1e-6 * np.sin(r / 1e-6) ** 2)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.JKR("-1 mJ/m^2"), "above 0"),
        (lambda: mdr.MaugisDugdale(WORK, strength=0), "above 0"),
        (lambda: mdr.MaugisDugdale(WORK, strength=1e6, range=1e-9), "both of strength and range"),
        (lambda: mdr.MaugisDugdale(WORK), "neither of strength and range"),
        (
            lambda: mdr.Contact(TIP, GEL, adhesion=JKR, friction=mdr.Coulomb(0.3)),
            "adhesion with friction",
        ),
        (lambda: mdr.solve(STICKY, mdr.load("-1 nN")), "the limit is -471.239 nN"),
        (lambda: mdr.solve(STICKY, mdr.travel("1 um")), "machine_stiffness"),
        (lambda: mdr.solve(STICKY, mdr.travel("1 um"), machine_stiffness=0), "dead load"),
        (lambda: mdr.solve(STICKY, mdr.travel("1 um"), machine_stiffness="-1 N/m"), "at least 0 N/m"),
        (lambda: mdr.solve(STICKY, mdr.shift("1 um")), "adhesion is covered only without slip"),
        (lambda: mdr.solve(mdr.Contact(HOLLOW, GEL, adhesion=JKR), mdr.indent("1 um")), "would be a ring"),
        (
            lambda: mdr.solve(
                mdr.Contact(mdr.Cone(slope=0.1), GEL, adhesion=mdr.DMT(WORK)), mdr.indent(1e-6)
            ),
            "range",
        ),
        (
            lambda: mdr.solve(STICKY, mdr.load("0 N") >> mdr.load("-1 uN", steps=5) >> mdr.indent("1 um")),
            "has no start position",
        ),
        (lambda: mdr.pull_off(mdr.Contact(TIP, GEL)), "no adhesion"),
        (lambda: mdr.adhesion_regime(STICKY), "range='0.3 nm'"),
        (lambda: mdr.Coulomb(-0.1), "at least 0"),
        (lambda: mdr.solve(mdr.Contact(TIP, GEL), mdr.shift("1 um")), "no friction"),
        (lambda: mdr.solve(JOINT, mdr.load("50 N") >> mdr.drag("16 N")), "at most mu F_N = 15 N"),
        (lambda: mdr.solve(JOINT, mdr.indent("1 um"), keep=0), "1 <= k"),
        (lambda: mdr.solve(STICKY, mdr.indent("1 um"), keep=2), "with friction"),
        (lambda: mdr.cycle(shift="1 um", steps=10), "multiple of 4"),
        (lambda: mdr.friction_loop(JOINT, [1e-7]), "exactly one"),
    ],
)
def test_refusals_name_value_and_remedy(make, words):
    with pytest.raises(mdr.PymdrError, match=words):
        make()


# --- what users of both laws asked for -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "path",
    [
        mdr.indent(0.05) >> mdr.cycle(indentation=0.03),
        mdr.load(0.05) >> mdr.cycle(normal_force=0.03),
        mdr.load(0.0) >> mdr.load(0.0),
    ],
)
def test_a_cycle_without_a_jump_closes_its_energy_balance(path):
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), adhesion=mdr.JKR(0.01))
    balance = [a for a in mdr.solve(contact, path).assumptions if "energy" in a.name]
    assert balance
    assert all(a.met and a.measure < 1e-12 for a in balance)


@pytest.mark.parametrize("exponent", [0.75, 1.2, 1.5])
def test_maugis_dugdale_on_tips_between_a_cusp_and_a_ball(exponent):
    tip = mdr.PowerLaw(exponent=exponent, height=1.0, radius=1.0)
    laws = (mdr.JKR(0.01), *(mdr.MaugisDugdale(0.01, strength=strength) for strength in (16.0, 64.0)))
    results = [
        mdr.pull_off(mdr.Contact(tip, mdr.Elastic(1.0, 0.0), adhesion=law), machine_stiffness=0)
        for law in laws
    ]
    short, weak, strong = (x.normal_force for x in results)
    # JKR is the limit, to second order in 1 / strength
    assert (weak - short) / (strong - short) == pytest.approx(16.0, rel=0.02)
    assert all(x.largest_pull == pytest.approx(x.normal_force, rel=1e-14) for x in results)


@pytest.mark.parametrize(
    "values", [lambda r: r**2 / 2, lambda r: np.sqrt(1.0 + r * r) - 1.0, lambda r: np.cosh(r) - 1.0]
)
def test_a_callable_without_its_derivative_is_as_good_as_with(values):
    slopes = {1: lambda r: r, 2: lambda r: r / np.sqrt(1.0 + r * r), 3: np.sinh}
    number = 1 if values(1.0) == 0.5 else 2 if values(1.0) < 0.5 else 3
    laws = (mdr.JKR(0.01), mdr.MaugisDugdale(0.01, strength=0.1), mdr.DMT(0.01, range=0.02))
    for law in laws:
        plain, named = (
            mdr.pull_off(mdr.Contact(mdr.Function(values, **more), mdr.Elastic(1.0, 0.0), adhesion=law))
            for more in ({}, {"derivative": slopes[number]})
        )
        assert plain.normal_force == pytest.approx(named.normal_force, rel=1e-11)


def test_the_regime_of_a_round_callable_is_that_of_the_ball():
    ball, parabola = mdr.Paraboloid(1.0), mdr.Function(lambda r: r**2 / 2)
    a, b = (
        mdr.adhesion_regime(mdr.Contact(tip, mdr.Elastic(1.0, 0.0), adhesion=mdr.JKR(0.01)), range=0.1)
        for tip in (ball, parabola)
    )
    assert b.tabor == pytest.approx(a.tabor, rel=1e-9)
    assert b.regime == a.regime


def test_the_largest_pull_is_what_a_stiff_rig_reports():
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), adhesion=mdr.JKR(0.01))
    result = mdr.pull_off(contact)
    assert result.normal_force == pytest.approx(-5 / 6 * math.pi * 0.01, rel=1e-12)
    assert result.largest_pull == pytest.approx(-1.5 * math.pi * 0.01, rel=1e-12)


def test_slip_work_under_forces_has_a_limit_in_the_coefficient():
    steel = mdr.Elastic("210 GPa", 0.0)
    path = mdr.ramp(normal_force="50 N", tangential_force="1 N") >> mdr.load("10 N", steps=100)
    dissipated = {
        mu: float(
            mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(mu)), path)[
                "dissipated_energy"
            ][-1]
        )
        for mu in (1e2, 1e3, 1e6)
    }
    assert dissipated[1e3] == pytest.approx(dissipated[1e6], rel=2e-4)
    assert dissipated[1e2] == pytest.approx(dissipated[1e6], rel=2e-3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mdr.Coulomb(1e12), "Coulomb\\(math.inf\\)"),
        (lambda: mdr.pull_off(_gel(), pressed_to="-1 um"), "above 0 m"),
        (lambda: mdr.friction_loop(_joint(), "1 um", normal_force="0 N"), "above 0 N"),
        (lambda: mdr.solve(_gel(exponent=0.4), mdr.indent("1 um")), "exponent above 0.5"),
        (lambda: mdr.pull_off(_gel(work="1e9 J/m^2")), "known up to r"),
    ],
)
def test_what_cannot_be_is_refused_with_a_remedy(call, words):
    with pytest.raises(mdr.PymdrError, match=words):
        call()


def _gel(exponent=None, work="50 mJ/m^2"):
    tip = mdr.Sphere("50 um") if exponent is None else mdr.PowerLaw(exponent, "1 um", "1 um")
    return mdr.Contact(tip, mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR(work))


def _joint():
    return mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3))


def test_a_study_of_loops_prints_as_a_table():
    study = mdr.friction_loop(_joint(), ["0.1 um", "0.2 um"], normal_force="10 N")
    lines = str(study).splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["amplitude", "nm", "100", "200"]
    # steel on a rigid ball is not similar
    (unmet,) = [line for line in lines if "NOT MET" in line]
    assert "Dundurs" in unmet


@settings(max_examples=examples(40), deadline=None)
@given(
    exponent=st.floats(0.1, 20.0),
    friction=st.floats(0.01, 1.0),
    shares=st.lists(st.floats(0.01, 1.5), min_size=1, max_size=5, unique=True),
)
def test_loops_of_any_tip_are_those_of_masing(exponent, friction, shares):
    steel = mdr.Elastic("210 GPa", 0.0)
    joint = mdr.Contact(mdr.PowerLaw(exponent, "1 um", "1 mm"), steel, steel, friction=mdr.Coulomb(friction))
    moduli = mdr.effective_moduli(steel, steel)
    slides = friction * moduli.normal / moduli.tangential * 1e-6
    study = mdr.friction_loop(joint, slides * np.array(shares), indentation="1 um")
    scale = friction * study.data.attrs["normal_force"] * slides
    fraction = np.minimum(shares, 1.0)
    expected = loop_energy(fraction, exponent) + 4.0 * (np.array(shares) - fraction)
    # (g / d) ** (1 / n) turns roundings of g into 1 / n times as many, and 1e-13 is what the cancelling form has
    computed = study["dissipated_per_cycle"].values / scale
    assert computed == pytest.approx(expected, rel=3e-11 / min(exponent, 1.0), abs=1e-13)
    force, stick = cattaneo_mindlin(fraction, exponent)
    assert study["force_amplitude"].values * slides / scale == pytest.approx(
        force, rel=3e-12 / min(exponent, 1.0)
    )
    assert study["stick_ratio"].values == pytest.approx(stick, rel=1e-11 / exponent, abs=1e-11)
    assert study.claim.error is None or np.all(study.claim.error < 1e-9)
    assert any(entry.name == "small slope" for entry in study.assumptions)


def test_a_study_of_loops_has_bands_and_is_drawn_in_order():
    r = np.linspace(0.0, 1e-3, 60)
    steel = mdr.Elastic("210 GPa", 0.3)
    rough = mdr.Contact(
        mdr.Sampled(r, r**2 / 0.02, scatter=2e-5 * r), steel, steel, friction=mdr.Coulomb(0.3)
    )
    study = mdr.friction_loop(rough, ["0.3 um", "0.1 um", "0.2 um"], normal_force="50 N")
    for name in ("dissipated_per_cycle", "secant_stiffness"):
        low, value, high = (study[f"{name}{end}"].values for end in ("_low", "", "_high"))
        assert np.all((low <= value) & (value <= high))
        assert np.all(high - low > 1e-4 * value)
    assert study.claim.level is mdr.Level.APPROXIMATE
    for axes in study.plot().axes:
        (line,) = [x for x in axes.lines if len(x.get_xdata()) == 3]
        assert np.all(np.diff(line.get_xdata()) > 0.0)


@settings(max_examples=examples(25), deadline=None)
@given(
    st.sampled_from(
        [mdr.Paraboloid("10 mm"), mdr.Cone(slope=0.01), mdr.PowerLaw(exponent=4.0, height=1e-6, radius=1e-3)]
    ),
    st.lists(st.floats(-6.0, -0.01), min_size=1, max_size=3),
    st.floats(0.05, 2.0),
)
def test_loops_by_force_are_loops_by_shift(profile, shares, mu):
    steel = mdr.Elastic("210 GPa", 0.3)
    joint = mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(0.3))
    pulls = 10.0 ** np.array(shares) * mu * 50.0
    by_force = mdr.friction_loop(
        joint, force_amplitude=pulls, coefficient=[mu, 2.0 * mu], normal_force="50 N"
    )
    assert by_force.data.sizes == {"coefficient": 2, "force_amplitude": pulls.size}
    for coefficient, study in by_force.by_coefficient():
        contact = mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(coefficient))
        by_shift = mdr.friction_loop(contact, study["amplitude"].values, normal_force="50 N")
        assert by_shift["force_amplitude"].values == pytest.approx(pulls, rel=1e-9)
        for name in ("dissipated_per_cycle", "secant_stiffness", "stick_ratio"):
            assert by_shift[name].values == pytest.approx(study[name].values, rel=1e-9)
    assert by_force.summary().split()[0] == "mu"
    assert "mu" in by_force._repr_html_()


@settings(max_examples=examples(30), deadline=None)
@given(st.floats(-2.0, 5.99), st.floats(-9.5, -7.0), st.floats(-6.5, -5.0))
def test_a_loop_errs_by_no_more_than_it_claims_at_any_friction(mu, amplitude, depth):
    """A paraboloid, int_c^a t (u - t) dx as powers of c and a in 50 digits; d - g(x) cancels where little slips."""
    mu, u, d, R = 10.0**mu, 10.0**amplitude, 10.0**depth, 0.01
    steel = mdr.Elastic("210 GPa", 0.0)
    joint = mdr.Contact(mdr.Paraboloid(R), steel, steel, friction=mdr.Coulomb(mu))
    assume(u < mu * d)
    result = mdr.friction_loop(joint, [u], indentation=d)
    with mpmath.workdps(50):
        f, D, U, radius = (mpmath.mpf(x) for x in (mu, d, u, R))

        def whole(x):
            once = D * x - x**3 / (3 * radius)
            twice = D**2 * x - 2 * D * x**3 / (3 * radius) + x**5 / (5 * radius**2)
            return f * U * once - f**2 * twice

        a, c = mpmath.sqrt(D * radius), mpmath.sqrt((D - U / f) * radius)
        # E* = E/2 of equal bodies is G* at Poisson's ratio 0
        exact = 8 * mpmath.mpf(steel.young) / 2 * (whole(a) - whole(c))
        off = abs(float(mpmath.mpf(float(result["dissipated_per_cycle"].values.item())) / exact - 1))
    assert off <= max(EXACT_WITHIN, float(np.max(result.claim.error)))


@settings(max_examples=examples(10), deadline=None)
@given(st.lists(st.floats(-3.0, 1.0), min_size=1, max_size=1), st.randoms())
def test_several_coefficients_claim_no_more_than_each(powers, random):
    steel = mdr.Elastic("210 GPa", 0.0)
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    mus = [*(10.0**power for power in powers), 0.3, 1e6]
    random.shuffle(mus)
    amplitudes = ["1 nm", "0.1 um"]
    together = mdr.friction_loop(joint, amplitudes, coefficient=mus, normal_force="50 N").claim
    alone = [mdr.friction_loop(joint, amplitudes, coefficient=mu, normal_force="50 N").claim for mu in mus]
    exact = all(claim.level is mdr.Level.EXACT for claim in alone)
    assert (together.level is mdr.Level.EXACT) == exact
    errors = [claim.error for claim in alone if claim.error is not None]
    if errors:
        assert together.error.tolist() == np.max(errors, axis=0).tolist()


def test_questions_that_a_loop_cannot_answer():
    with pytest.raises(mdr.ProblemError, match="3 is not a Contact"):
        mdr.friction_loop(3, "1 um", coefficient=0.3, normal_force="1 N")
    for verb in (mdr.first_yield, mdr.shakedown):
        with pytest.raises(mdr.ProblemError, match="3 is not a Contact"):
            verb(3, strength="1 GPa")
    with pytest.raises(mdr.ProblemError, match="3 is not a Contact"):
        mdr.adhesion_regime(3)
    joint = _joint()
    study = mdr.friction_loop(joint, ["0.1 um"], normal_force="10 N")
    with pytest.raises(mdr.QuantityError, match=r"no quantity 'slip'; a friction loop has .*damping_ratio"):
        study["slip"]
    for question, words in (
        ({}, "exactly one of amplitude and force_amplitude"),
        ({"amplitude": 1e-7, "force_amplitude": 1.0}, "exactly one of amplitude and force_amplitude"),
        ({"force_amplitude": "10 N"}, "the whole contact slides at mu F_N = "),
        ({"force_amplitude": "-1 N"}, "forces above 0 N"),
        ({"amplitude": 1e-7, "coefficient": [0.0]}, "numbers above 0"),
    ):
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.friction_loop(joint, **question, normal_force="10 N")


@dataclass(frozen=True, eq=False)
class Edge(AdhesionLaw):
    work: SIField = SIField("J/m^2", above=0.0)


@dataclass(frozen=True, eq=False)
class Pull(AdhesionLaw):
    work: SIField = SIField("J/m^2", above=0.0)
    range: OptionalSIField = OptionalSIField("m", above=0.0)


@dataclass(frozen=True, eq=False)
class Ring(AdhesionLaw):
    work: SIField = SIField("J/m^2", above=0.0)
    strength: SIField = SIField("Pa", above=0.0)

    @property
    def cohesive_stress(self):
        return self.strength


BODIES = (
    mdr.Elastic("1 MPa", 0.5, resistivity="1 mohm*m", thermal_conductivity="1 W/m/K"),
    mdr.TransverselyIsotropic(c11="3 MPa", c33="2 MPa", c13="1 MPa", c44="1 MPa", c66="1 MPa"),
    mdr.Graded("1 MPa", "1 mm", 0.3, 0.3),
    mdr.Layered([mdr.Layer(mdr.Elastic("1 MPa", 0.45), "1 mm")], base=mdr.Rigid()),
)
FREE = ["body.young", "adhesion.work"]
QUESTIONS = {
    "solve": lambda contact, path: mdr.solve(contact, path),
    "assess": lambda contact, path: mdr.assess(contact, path),
    "pull off": lambda contact, path: mdr.pull_off(contact),
    "law": lambda contact, path: mdr.export_law(contact, to="3 um"),
    "impact": lambda contact, path: mdr.impact(contact, mass="1 g", speed="1 cm/s"),
    "regime": lambda contact, path: mdr.adhesion_regime(contact, range="1 nm").pull_off_force,
}


def claims_of(question, contact_of, law):
    """Everything that is answered, or the refusal, without the name of the law."""
    path = mdr.indent("3 um", steps=3) >> mdr.indent("-80 um", steps=7)
    try:
        result = QUESTIONS[question](contact_of(law), path)
    except mdr.PymdrError as refusal:
        return type(refusal), str(refusal).replace(type(law).__name__, "the law")
    claims = getattr(result, "claims", None) or {}
    summary = {name: (claim.level, claim.reason, claim.source) for name, claim in claims.items()}
    data = getattr(result, "data", None)
    columns = {} if data is None else {name: column.values.tolist() for name, column in data.items()}
    numbers = (
        repr(result) if not claims else [getattr(result, name, None) for name in ("status", "restitution")]
    )
    return repr(columns), summary, numbers


@settings(max_examples=examples(12), deadline=None)
@given(st.data())
def test_a_law_is_what_its_row_says(data):
    """A law that is not known by its class, with the row of one that is, is told and refused as that one."""
    work = data.draw(st.floats(1e-3, 1.0))
    one, other = data.draw(
        st.sampled_from(
            [
                (Edge(work), mdr.JKR(work)),
                (Pull(work, "1 nm"), mdr.DMT(work, "1 nm")),
                (Ring(work, "50 kPa"), mdr.MaugisDugdale(work, strength="50 kPa")),
            ]
        )
    )
    body = data.draw(st.sampled_from(BODIES))
    question = data.draw(st.sampled_from(list(QUESTIONS)))

    def contact_of(law):
        return mdr.Contact(mdr.Paraboloid("1 mm"), body, adhesion=law)

    THEORIES[type(one)] = THEORIES[type(other)]
    try:
        assert claims_of(question, contact_of, one) == claims_of(question, contact_of, other)
    finally:
        del THEORIES[type(one)]


@pytest.mark.parametrize(
    ("own", "known"),
    [
        (Edge("1 mJ/m^2"), mdr.JKR("1 mJ/m^2")),
        (Pull("1 mJ/m^2"), mdr.DMT("1 mJ/m^2")),
        (Pull("1 mJ/m^2", "1 um"), mdr.DMT("1 mJ/m^2", "1 um")),
    ],
)
def test_a_fit_reads_the_row_of_a_law(own, known, monkeypatch):
    gel, tip = mdr.Elastic("3 kPa", 0.5), mdr.Paraboloid("5 um")
    record = mdr.solve(
        mdr.Contact(tip, gel, adhesion=known), mdr.Path(indentation=np.linspace(1e-6, -5e-7, 60))
    )
    in_contact = record["normal_force"].values != 0.0
    force, depth = (record[name].values[in_contact] for name in ("normal_force", "indentation"))
    curve = mdr.MeasuredCurve(force=force, indentation=depth)
    monkeypatch.setitem(THEORIES, type(own), THEORIES[type(known)])

    def result(law, fit, free):
        try:
            answer = fit(mdr.Contact(tip, gel, adhesion=law), curve, free)
        except mdr.PymdrError as refusal:
            return str(refusal)
        return repr({name: column.values.tolist() for name, column in answer.data.items()}), answer.notes

    for free in (["body.young"], ["adhesion.work"]):
        assert result(own, mdr.fit, free) == result(known, mdr.fit, free)
    maps = [
        result(law, lambda contact, one, free: mdr.fit_map(contact, [one], free), FREE)
        for law in (own, known)
    ]
    assert maps[0] == maps[1]
    assert "tables of the forces" in str(maps[0])


def test_a_stress_that_does_not_grow_with_the_work_is_fitted_law_by_law(monkeypatch):
    monkeypatch.setitem(THEORIES, Ring, THEORIES[mdr.MaugisDugdale])
    for law, tabulated in (
        (Ring("1 mJ/m^2", "1 kPa"), False),
        (mdr.MaugisDugdale("1 mJ/m^2", strength="1 kPa"), False),
        (mdr.MaugisDugdale("1 mJ/m^2", range="1 um"), True),
    ):
        contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.5), adhesion=law)
        assert (axes_of(contact, unknowns_of(contact, FREE)) is not None) == tabulated


def test_laws_of_ones_own_are_refused_where_a_table_or_a_stress_is_not_known(monkeypatch):
    monkeypatch.setitem(THEORIES, Edge, replace(THEORIES[mdr.JKR], proportional=lambda law: False))
    contact = mdr.Contact(mdr.Paraboloid("1 mm"), BODIES[0], adhesion=Edge("10 mJ/m^2"))
    with pytest.raises(mdr.ProblemError, match="Edge is not tabulated; give JKR or DMT, or write"):
        mdr.export_law(contact, to="3 um")
    with pytest.raises(
        mdr.ProblemError, match="Edge has no cohesive stress, so the stress at its edge is not known; use"
    ):
        mdr.first_yield(contact, strength="1 MPa")
