"""Friction of bodies with memory against closed forms, the elastic stack, small steps of its own, limits and balances."""

import math
from dataclasses import replace
from functools import reduce
from operator import rshift

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples, first_of
from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.memory import displacement, surface_load
from pymdr.interpretation.memory_friction import _states, sheared_claims
from pymdr.interpretation.validity import TANGENTIAL_FIELDS
from pymdr.line.curves import ElasticLine
from pymdr.line.friction import FrictionLeg, curves_of, follow_leg, virgin_state
from pymdr.line.memory import follow_springs, shear_springs, unsheared
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation, largest_coupling
from pymdr.solving import frictional_memory, viscoelastic
from pymdr.solving.laws import _sheared_surface
from pymdr.solving.teaching import friction_foundation

SOLID = mdr.StandardSolid(equilibrium=0.3, modulus=1.0, time=0.4)
SHAPES = (mdr.Paraboloid(1.0), mdr.Cone(slope=0.3), mdr.PowerLaw(4.0, 0.2, 1.0), mdr.FlatPunch(0.3))
TANGENTIAL = ("shift", "tangential_force", "stick_radius", "slip_distance")
ENERGIES = ("stored_tangential_energy", "slip_work", "dissipated_energy", "external_work")


def rubber(shear=SOLID, **volume):
    return mdr.Viscoelastic(shear, **(volume or {"poisson": 0.5}))


def joint(body, mu, profile=SHAPES[0], counterbody=None):
    return mdr.Contact(profile, body, counterbody or mdr.Rigid(), friction=mdr.Coulomb(mu))


def rows(t, d, u):
    return mdr.Path(time=t, indentation=d, shift=u)


def line_of(profile):
    return ElasticLine(equivalent_profile(profile), 1.0)


def sheared(line, normal, tangential, mu, t, d, u, n, forced=False):
    """Rows of springs, passage by passage."""
    results, state = [], unsheared()

    def watch(passage):
        nonlocal state
        done = sum(part.shift.size for part in results)
        target = np.asarray(u[done : done + passage.force.size], dtype=float)
        results.append(shear_springs(line, passage, (normal, tangential), mu, target, forced, state))
        state = results[-1].state

    history = follow_springs(line, normal, t, d, n=n, watch=watch)
    names = [name for name in results[0]._fields if name != "state"]
    return history, {name: np.concatenate([getattr(part, name) for part in results]) for name in names}


# springs that do not relax are those of the elastic contact


@pytest.mark.parametrize("mu", [0.4, 0.0, math.inf])
def test_what_does_not_relax_is_the_elastic_stack(mu):
    rng = np.random.default_rng(1)
    d, u = np.append(0.0, rng.uniform(-0.02, 0.3, 40)), np.append(0.0, rng.uniform(-0.1, 0.1, 40))
    elastic = ElasticLine(equivalent_profile(SHAPES[0]), 1.3)
    leg = FrictionLeg(False, False, d[1:], u[1:])
    exact = follow_leg(curves_of(elastic, 1.0), leg, mu, 0.9, virgin_state(mu, 1.3 / 0.9))
    errors = []
    for n in (250, 500, 1000, 2000):
        _, computed = sheared(
            line_of(SHAPES[0]), Relaxation(1.3), Relaxation(0.9), mu, np.arange(41.0), d, u, n
        )
        pairs = (
            (computed["force"], exact.tangential_force),
            (np.cumsum(computed["slip_work"]), exact.slip_work),
            (computed["stored"], exact.stored_energy),
            (computed["stick_radius"], exact.stick_radius),
            (np.cumsum(computed["slid"]), exact.slip_distance),
        )
        errors.append([abs(one[1:] - two).max() / (two.max() or 1.0) for one, two in pairs])
    errors = np.array(errors)
    if math.isinf(mu):  # what is left behind at an edge that retreats ends within a spring
        assert (errors.max(axis=1) * [250, 500, 1000, 2000] < 2.0).all()
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.log2(errors[0] / errors[-1]) / 3.0
    assert ((slope > 1.9) | (errors[-1] < 1e-9)).all()
    assert errors[-1].max() < 2e-6


@pytest.mark.parametrize("profile", SHAPES[:3])
@pytest.mark.parametrize(("time", "modulus"), [(1e9, 1.3), (1e-9, 0.3)])
def test_fast_is_glassy_and_slow_is_rubbery(profile, time, modulus):
    body = rubber(mdr.StandardSolid(0.3, 1.0, time=time))
    elastic = mdr.Elastic(3.0 * modulus, 0.5)
    path = (
        mdr.indent(0.1, duration=1.0, steps=4)
        >> mdr.shift(0.05, duration=1.0, steps=6)
        >> mdr.ramp(duration=1.0, steps=6, indentation=0.07, shift=-0.06)
        >> mdr.shift(0.01, duration=1.0, steps=6)
    )
    one, two = (mdr.solve(joint(material, 0.4, profile), path) for material in (body, elastic))
    for name in ("tangential_force", "stick_radius", "stored_tangential_energy", "slip_distance"):
        bound = (
            1e-4 if name == "slip_distance" else 2e-5
        )  # that of the innermost spring, which is beside the tip
        assert one[name].values == pytest.approx(two[name].values, abs=bound * abs(two[name].values).max())
    slip, expected = one["slip_work"].values, two["dissipated_energy"].values
    assert slip == pytest.approx(expected, abs=2e-5 * expected.max())


# closed forms


def test_no_slip_of_a_contact_that_stays():
    """F_x = int G*(t - s) 2 a du(s)."""
    a, rate = 0.3, 0.02
    result = mdr.solve(
        joint(rubber(), math.inf, mdr.FlatPunch(a)),
        mdr.indent(0.1, duration=1.0, steps=3)
        >> mdr.shift(rate, duration=1.0, steps=5)
        >> mdr.hold("2 s", steps=4),
    )
    t = result["time"].values[3:] - 1.0
    moved, since = np.minimum(t, 1.0), np.maximum(t - 1.0, 0.0)
    branch = 0.4 * rate * (np.exp(-since / 0.4) - np.exp(-t / 0.4))
    force = 2.0 * a * 8.0 / 3.0 * (0.3 * rate * moved + 1.0 * branch)
    assert result["tangential_force"].values[3:] == pytest.approx(force, rel=1e-12)
    assert result.claims["tangential_force"].level is mdr.Level.EXACT
    assert result["slip_work"].values == pytest.approx(0.0, abs=1e-18)


def test_a_shear_that_stays_relaxes():
    t = np.array([1.0, 1.0 + 1e-10, *np.linspace(1.1, 4.0, 12)])
    u = np.array([0.0, *np.full(13, 0.01)])
    result = mdr.solve(joint(rubber(), math.inf), rows(t, np.full(14, 0.09), u))
    relaxed = 2.0 * 0.3 * 8.0 / 3.0 * (0.3 + np.exp(-(t[1:] - 1.0) / 0.4)) * 0.01
    assert result["tangential_force"].values[1:] == pytest.approx(relaxed, rel=1e-8)


def test_a_drag_that_stays_creeps():
    """u = F J(t) / (2 a) without slip, J the creep that belongs to G*."""
    t = np.array([1.0, 1.0 + 1e-10, *np.linspace(1.01, 4.0, 80)])
    force = np.array([0.0, *np.full(81, 0.01)])
    result = mdr.solve(
        joint(rubber(), math.inf), mdr.Path(time=t, indentation=np.full(82, 0.09), tangential_force=force)
    )
    creep = mdr.relaxation_of(rubber(), tangential=True).retardation(t[1:] - 1.0)
    assert result["shift"].values[1:] == pytest.approx(0.01 * creep / 0.6, rel=1e-5)


@pytest.mark.parametrize("shear", [SOLID, mdr.Maxwell(1.0, time=0.4), mdr.KelvinVoigt(1.0, 0.4)])
def test_all_slips(shear):
    path = mdr.indent(0.1, duration=1.0, steps=5) >> mdr.shift(1.0, duration=1.0, steps=10)
    result = mdr.solve(joint(rubber(shear), 0.3), path)
    force = result["tangential_force"].values[-5:]
    assert force == pytest.approx(0.3 * result["normal_force"].values[-5:], rel=2e-6)
    assert (result["stick_radius"].values[-5:] == 0.0).all()
    slid = np.diff(result["slip_distance"].values)[-4:]
    assert (slid > 0.0).all()


def test_like_bodies_without_slip_share_the_shear():
    """Two equal bodies give way twice as much as one: Poisson's ratio may be any."""
    body, path = rubber(poisson=0.3), mdr.indent(0.1, duration=1.0) >> mdr.shift(0.01, duration=1.0)
    one, two = (
        mdr.solve(joint(body, math.inf), path),
        mdr.solve(joint(body, math.inf, counterbody=body), path),
    )
    assert float(one["tangential_force"][-1]) == pytest.approx(
        2.0 * float(two["tangential_force"][-1]), rel=1e-12
    )
    assert two.claims["tangential_force"].reason.startswith("exact without slip")
    assert one.claims["tangential_force"].reason.startswith("in the frame")


# G*(t)

RHEOLOGIES = (
    SOLID,
    mdr.Maxwell(1.0, time=0.4),
    mdr.KelvinVoigt(1.0, 0.4),
    mdr.Prony(0.2, [1.0, 3.0], [0.1, 7.0]),
)


def carson(kernel, s):
    return (
        kernel.equilibrium
        + kernel.moduli @ (s * kernel.times / (1.0 + s * kernel.times))
        + kernel.viscosity * s
    )


@settings(max_examples=examples(40), deadline=None)
@given(
    shear=st.sampled_from(RHEOLOGIES),
    nu=st.floats(-0.9, 0.5),
    bulk=st.floats(0.01, 1e6),
    s=st.floats(1e-3, 1e3),
)
def test_the_tangential_kernel_is_that_of_the_elastic_modulus(shear, nu, bulk, s):
    g = carson(shear.kernel(None), s)
    for body, poisson in (
        (rubber(shear, poisson=nu), nu),
        (rubber(shear, bulk=bulk), (3.0 * bulk - 2.0 * g) / (6.0 * bulk + 2.0 * g)),
    ):
        result = carson(mdr.relaxation_of(body, tangential=True), s)
        assert result == pytest.approx(4.0 * g / (2.0 - poisson), rel=1e-9)
        other = mdr.Elastic(5.0, 0.2)
        pair = carson(mdr.relaxation_of(body, other, tangential=True), s)
        compliance = (2.0 - poisson) / (4.0 * g) + (2.0 - 0.2) / (4.0 * other.shear)
        assert pair == pytest.approx(1.0 / compliance, rel=1e-9)


def test_coupling():
    assert largest_coupling(rubber(poisson=0.3), mdr.Rigid()) == pytest.approx(0.4 / 1.4, rel=1e-12)
    assert largest_coupling(rubber(poisson=0.3), rubber(poisson=0.3)) == 0.0
    # all but a liquid in the end, which keeps its volume
    assert largest_coupling(rubber(mdr.Maxwell(1.0, time=1.0), bulk=1.0), mdr.Rigid()) == pytest.approx(
        mdr.effective_moduli(mdr.Elastic(9.0 / 4.0, 1.0 / 8.0)).dundurs_beta, rel=2e-3
    )


# against springs that are stepped in small steps by other rules


def brute(profile, shear, poisson, mu, t, d, u, springs=300, between=300):
    """F_N, F_x and the slip work on even springs, by backward differences."""
    kernel = shear.kernel(None)
    parts = 2.0 / (1.0 - poisson), 4.0 / (2.0 - poisson)
    top = equivalent_profile(profile)
    radius = 1.02 * float(top.a(np.array([d.max()]))[0]) if hasattr(top, "a") else 0.6
    dx = radius / springs
    x = (np.arange(springs) + 0.5) * dx
    g = top.g(x)
    w, v = np.zeros(springs), np.zeros(springs)
    h = np.zeros((2, kernel.times.size, springs))
    touching = np.zeros(springs, dtype=bool)
    forces, slip_work = [(0.0, 0.0, 0.0)], 0.0
    here = u[0]
    for k in range(1, t.size):
        for j in range(1, between + 1):
            fraction = j / between
            depth = d[k - 1] + fraction * (d[k] - d[k - 1])
            shift = u[k - 1] + fraction * (u[k] - u[k - 1])
            dt = (t[k] - t[k - 1]) / between
            fade = 1.0 / (1.0 + dt / kernel.times)
            stiff = kernel.equilibrium + float(kernel.moduli @ fade)
            old = (kernel.equilibrium * w, kernel.equilibrium * v)
            left = [a + (fade[:, None] * b).sum(axis=0) for a, b in zip(old, h, strict=True)]
            pressed = left[0] + stiff * (depth - g - w)
            load = np.maximum(pressed, 0.0)
            dw = (load - left[0]) / stiff
            trial = left[1] + stiff * (shift - here)
            limit = mu * parts[0] * load / parts[1]
            bears = np.clip(np.where(touching | (load > 0.0), trial, 0.0), -limit, limit)
            dv = (bears - left[1]) / stiff
            slip_work += 2.0 * dx * parts[1] * float((bears * (shift - here - dv)).sum())
            for i, moved in enumerate((dw, dv)):
                h[i] = fade[:, None] * (h[i] + kernel.moduli[:, None] * moved)
            w, v, touching, here = w + dw, v + dv, load > 0.0, shift
        q = 2.0 * dx * np.array([parts[0] * load.sum(), parts[1] * bears.sum()])
        forces.append((*q, slip_work))
    return np.array(forces).T


@pytest.mark.parametrize("shear", [SOLID, mdr.Maxwell(1.0, time=0.4), mdr.Prony(0.2, [1.0, 3.0], [0.1, 7.0])])
@pytest.mark.parametrize("poisson", first_of([0.2, 0.5]))
def test_against_small_steps(shear, poisson):
    rng = np.random.default_rng(7)
    t = 0.5 * np.arange(13.0)
    d, u = np.append(0.0, rng.uniform(0.02, 0.2, 12)), np.append(0.0, rng.uniform(-0.05, 0.05, 12))
    pressed, pulled, slip = brute(SHAPES[0], shear, poisson, 0.35, t, d, u)
    fine = np.linspace(0.0, 6.0, 12 * 16 + 1)[1:]
    path = rows(fine, np.interp(fine, t, d), np.interp(fine, t, u))
    result = mdr.solve(joint(rubber(shear, poisson=poisson), 0.35), path)
    at = np.arange(15, 192, 16)
    assert result["normal_force"].values[at] == pytest.approx(pressed[1:], abs=6e-3 * pressed.max())
    assert result["tangential_force"].values[at] == pytest.approx(pulled[1:], abs=6e-3 * abs(pulled).max())
    assert result["slip_work"].values[at] == pytest.approx(slip[1:], abs=1e-2 * slip.max())


# what holds on any way


@st.composite
def bodies(draw):
    kind = draw(st.sampled_from(["prony", "dashpot", "liquid"]))
    volume = draw(st.sampled_from([{"poisson": 0.5}, {"poisson": 0.1}, {"bulk": 2.0}]))
    if kind == "dashpot":
        return rubber(mdr.KelvinVoigt(1.0, draw(st.floats(0.01, 10.0))), **volume)
    times = draw(st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=3, unique_by=lambda x: round(x, 1)))
    moduli = draw(st.lists(st.floats(0.1, 5.0), min_size=len(times), max_size=len(times)))
    equilibrium = 0.0 if kind == "liquid" else draw(st.floats(0.01, 2.0))
    return rubber(mdr.Prony(equilibrium, moduli, [10.0**x for x in times]), **volume)


@st.composite
def histories(draw):
    size = draw(st.integers(2, 5))
    d = [i / 1000 for i in draw(st.lists(st.integers(-50, 200), min_size=size, max_size=size))]
    u = [i / 1000 for i in draw(st.lists(st.integers(-100, 100), min_size=size, max_size=size))]
    waits = draw(st.lists(st.floats(0.02, 3.0), min_size=size, max_size=size))
    assume(max(d) > 0.01)
    t, every = np.append(0.0, np.cumsum(waits)), np.linspace(0.0, size, 3 * size + 1)[1:]
    rise = np.arange(size + 1.0)
    return tuple(np.interp(every, rise, values) for values in (t, np.append(0.0, d), np.append(0.0, u)))


COEFFICIENTS = st.sampled_from([0.0, 0.05, 0.3, 1.0, 5.0, 1e6, math.inf])


@settings(max_examples=examples(15), deadline=None)
@given(body=bodies(), history=histories(), mu=COEFFICIENTS, shape=st.sampled_from(SHAPES[:3]))
def test_work_is_stored_or_dissipated_on_any_path(body, history, mu, shape):
    t, d, u = history
    result = mdr.solve(joint(body, mu, shape), rows(t, d, u))
    data = {name: np.append(0.0, result.data[name].values) for name in result.data}
    scale = max(np.abs(np.diff(data["external_work"])).sum(), 1e-30)
    balance = (
        data["external_work"]
        - data["elastic_energy"]
        - data["stored_tangential_energy"]
        - data["dissipated_energy"]
    )
    assert abs(balance).max() <= 1e-9 * scale
    assert np.diff(data["slip_work"]).min() >= -1e-12 * scale
    assert np.diff(data["dissipated_energy"] - data["slip_work"]).min() >= -1e-9 * scale
    assert data["stored_tangential_energy"].min() >= 0.0
    if math.isfinite(mu):
        most = mu * data["normal_force"]
        assert (abs(data["tangential_force"]) <= most * (1.0 + 1e-12) + 1e-300).all()
    assert (abs(data["tangential_force"])[data["contact_radius"] == 0.0] == 0.0).all()
    stick = data["stick_radius"][np.isfinite(data["stick_radius"])]
    assert (stick >= 0.0).all()
    assert np.nanmax(data["stick_radius"] - data["contact_radius"]) <= 0.0


@settings(max_examples=8, deadline=None)
@given(
    body=bodies(),
    history=histories(),
    mu=COEFFICIENTS,
    size=st.sampled_from([1e-9, 1e-3, 1.0]),
    slower=st.sampled_from([1e-6, 1e3]),
    stiffer=st.sampled_from([1e-3, 1e9]),
)
def test_units_and_the_sign_of_the_shift_change_nothing_else(body, history, mu, size, slower, stiffer):
    t, d, u = history
    shear = body.shear
    if isinstance(shear, mdr.KelvinVoigt):
        scaled = mdr.KelvinVoigt(stiffer * shear.modulus, stiffer * slower * shear.viscosity)
    else:
        scaled = mdr.Prony(stiffer * shear.equilibrium, stiffer * shear.moduli, slower * shear.times)
    volume = {"poisson": body.poisson} if body.bulk is None else {"bulk": stiffer * body.bulk}
    one = mdr.solve(joint(body, mu), rows(t, d, u))
    two = mdr.solve(
        joint(rubber(scaled, **volume), mu, mdr.Paraboloid(size)), rows(slower * t, size * d, -size * u)
    )
    units = {
        "shift": -size,
        "tangential_force": -stiffer * size**2,
        "slip_work": stiffer * size**3,
        "slip_distance": size,
    }
    for name, unit in units.items():
        first, second = one.data[name].values, two.data[name].values / unit
        assert second == pytest.approx(first, abs=1e-7 * abs(first).max() + 1e-15)


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(body=bodies(), history=histories(), mu=COEFFICIENTS, data=st.data())
def test_legs_change_nothing(body, history, mu, data):
    t, d, u = history
    top = int(np.argmax(d)) + 1  # the springs are laid for the first leg
    assume(top < t.size)
    cut = data.draw(st.integers(top, t.size - 1))
    whole = mdr.solve(joint(body, mu), rows(t, d, u))
    parts = mdr.solve(joint(body, mu), rows(t[:cut], d[:cut], u[:cut]) >> rows(t[cut:], d[cut:], u[cut:]))
    for name in ("tangential_force", "slip_work", "stored_tangential_energy", "stick_radius"):
        first, second = whole.data[name].values, parts.data[name].values
        assert second == pytest.approx(first, abs=1e-9 * np.nanmax(abs(first)) + 1e-15, nan_ok=True)


@pytest.mark.long
@settings(max_examples=6, deadline=None)
@given(body=bodies(), history=histories(), mu=st.sampled_from([0.05, 0.3, 1.0]))
def test_errors_are_the_differences_to_finer_rows(body, history, mu):
    t, d, u = history
    fine = np.interp(np.arange(1, 16 * t.size + 1) / 16.0, np.arange(t.size + 1.0), np.append(0.0, t))
    between = [np.interp(fine, np.append(0.0, t), np.append(0.0, values)) for values in (d, u)]
    one, two = mdr.solve(joint(body, mu), rows(t, d, u)), mdr.solve(joint(body, mu), rows(fine, *between))
    for name in ("tangential_force", "slip_work", "stored_tangential_energy"):
        first, second = one.data[name].values, two.data[name].values[15::16]
        error = one.claims[name].error
        bound = 1e-9 if error is None else float(np.max(error))
        assert abs(first - second).max() <= (4.0 * bound + 1e-6) * max(abs(second).max(), 1e-30)


@settings(max_examples=examples(9), deadline=None)
@given(
    body=bodies(),
    legs=st.lists(
        st.tuples(st.integers(0, 20), st.integers(-20, 20), st.floats(-1.0, 1.5)), min_size=1, max_size=3
    ),
    mu=st.sampled_from([0.1, 0.3, 1.0]),
    forced=st.booleans(),
)
def test_few_rows_err_as_claimed(body, legs, mu, forced):
    channel = "normal_force" if forced else "indentation"

    def solved(steps):
        path = [
            mdr.ramp(
                steps=steps, duration=10.0**wait, shift=1e-3 * mu * shift, **{channel: 1e-3 * (2.0 + pressed)}
            )
            for pressed, shift, wait in legs
        ]
        return mdr.solve(joint(body, mu), reduce(rshift, path))

    few, many = solved(1), solved(32)
    for name in (
        "tangential_force",
        "stored_tangential_energy",
        "slip_work",
        "slip_distance",
        "dissipated_energy",
    ):
        difference = np.abs(few.data[name].values - many.data[name].values[31::32])
        errors = [0.0 if one.claims[name].error is None else one.claims[name].error for one in (few, many)]
        claimed = sum(float(np.max(error)) for error in errors)
        assert (
            difference.max() <= (1.5 * claimed + 1e-5) * float(np.max(np.abs(few.data[name].values))) + 1e-15
        )


@settings(max_examples=examples(20), deadline=None)
@given(body=bodies(), history=histories(), mu=st.sampled_from([0.3, 1.0, math.inf]))
def test_forces_lead_to_the_shifts_that_gave_them(body, history, mu):
    t, d, u = history
    d = 0.05 + np.abs(d)
    u = 0.02 * u  # a part sticks, so that the force tells the shift
    kernels = mdr.relaxation_of(body), mdr.relaxation_of(body, tangential=True)
    t, d, u = np.append(0.0, t), np.append(0.0, d), np.append(0.0, u)
    normal, first = sheared(line_of(SHAPES[0]), *kernels, mu, t, d, u, 200)
    assume((normal.force[1:] > 0.0).all())  # bodies that have parted are not told where to go
    assume((abs(first["force"]) <= 0.95 * min(mu, 1e9) * normal.force).all())
    _, second = sheared(line_of(SHAPES[0]), *kernels, mu, t, d, first["force"], 200, forced=True)
    assert second["force"] == pytest.approx(first["force"], rel=1e-10, abs=1e-13)
    assert second["shift"] == pytest.approx(u, abs=1e-7 * abs(u).max() + 1e-14)
    assert np.cumsum(second["slip_work"]) == pytest.approx(
        np.cumsum(first["slip_work"]), abs=1e-6 * first["work"].sum() + 1e-15
    )


# what people see


def fretting(mu=0.5, **options):
    path = mdr.indent(0.1, duration=1.0, steps=10) >> mdr.cycle(shift=0.06, cycles=1, steps=40, duration=2.0)
    return mdr.solve(joint(rubber(), mu), path, **options)


@pytest.mark.parametrize("mu", [0.4, math.inf])
def test_the_traction_carries_the_force(mu):
    result = fretting(mu)
    for step in (15, 25, -1):
        a = float(result["contact_radius"][step])
        s = (np.arange(4000) + 0.5) / 4000
        r = a * np.sqrt(1.0 - s * s)  # dA = 2 pi a^2 s ds
        tau = result.field("shear_traction", r=r, step=step).values
        force = 2.0 * math.pi * a * a * float((tau * s).mean())
        assert force == pytest.approx(float(result["tangential_force"][step]), rel=2e-3)
        if math.isfinite(mu):
            p = result.field("pressure", r=r, step=step).values
            assert (abs(tau) <= mu * p * 1.01 + 2e-2 * abs(tau).max()).all()
        slip = result.field("slip", r=[0.0, 0.5 * a, 1.5 * a], step=step).values
        assert np.isnan(slip[2])
        if math.isinf(mu):
            assert slip[:2] == pytest.approx(0.0, abs=1e-12)


def test_fields_of_what_does_not_relax_are_those_of_the_stack():
    frozen, elastic = rubber(mdr.StandardSolid(0.3, 1.0, time=1e9)), mdr.Elastic(3.9, 0.5)
    path = mdr.indent(0.1, duration=1.0, steps=4) >> mdr.shift(0.03, duration=1.0, steps=6)
    one, two = (mdr.solve(joint(material, 0.4), path) for material in (frozen, elastic))
    a, c = (float(two[name][-1]) for name in ("contact_radius", "stick_radius"))
    r = np.linspace(0.0, 0.999 * a, 200)
    for name, bound in (("shear_traction", 3e-2), ("tangential_displacement", 1e-3), ("slip", 1e-3)):
        first, second = (result.field(name, r=r, step=-1).values for result in (one, two))
        assert first == pytest.approx(second, abs=bound * abs(second).max())
        away = abs(r - c) > 0.02 * a
        assert first[away] == pytest.approx(second[away], abs=2e-3 * abs(second).max())
    x = np.linspace(0.0, 0.99 * a, 50)
    first, second = (result.field("spring_shift", r=x, step=-1).values for result in (one, two))
    assert first == pytest.approx(second, abs=1e-3 * abs(second).max())
    q = one.field("tangential_spring_force", r=x, step=-1).values
    assert q == pytest.approx(mdr.effective_moduli(elastic).tangential * second, abs=2e-3 * abs(q).max())


@settings(max_examples=8, deadline=None)
@given(
    body=bodies(),
    history=histories(),
    mu=st.sampled_from([0.05, 0.4, math.inf]),
    shape=st.sampled_from(SHAPES),
)
@example(  # a spring lies all but at the edge, where its load jumps
    body=rubber(mdr.KelvinVoigt(1.0, 0.125), poisson=0.5),
    history=(
        np.arange(10.0, 16.0) / 3.0,
        np.array([0.007, 0.014, 0.021, 0.213, 0.405, 0.597]) / 3.0,
        np.array([0.0, 0.0, 0.0, 0.001, 0.002, 0.003]) / 3.0,
    ),
    mu=0.05,
    shape=SHAPES[2],
)
def test_fields_err_as_claimed(body, history, mu, shape):
    t, d, u = history
    result = mdr.solve(joint(body, mu, shape), rows(t, d, u))
    surface = _sheared_surface(result)
    finer = replace(surface, normal=replace(surface.normal, n=4000))
    difference, size, claimed = (dict.fromkeys(TANGENTIAL_FIELDS, 0.0) for _ in range(3))
    steps = list(range(t.size))
    for step, state in zip(steps, _states(finer, steps, 16), strict=True):
        if state.radius == 0.0:
            continue
        r = state.radius * np.linspace(0.01, 0.98, 97)
        moved = displacement(state, r)
        values = (surface_load(state, r), moved, u[step] - moved)
        for name, expected in zip(TANGENTIAL_FIELDS, values, strict=True):
            computed = result.field(name, r=r, step=step).values
            difference[name] = max(difference[name], float(np.max(np.abs(computed - expected))))
            size[name] = max(size[name], float(np.max(np.abs(expected))))
            error = result.claims[name].error  # None: numerics to rounding, in a frame of unknown error
            claimed[name] = max(claimed[name], 0.0 if error is None else float(error[step]))
    for name in TANGENTIAL_FIELDS:
        assert difference[name] <= (3.0 * claimed[name] + 1e-6) * size[name]


def test_a_saved_result_and_its_figures(tmp_path):
    result = fretting()
    assert set(result.figures()) == {"section", "loop", "tractions", "energies", "history"}
    result.plot()
    result.save(tmp_path / "joint.nc")
    again = mdr.open_result(tmp_path / "joint.nc")
    r = [0.0, 0.1, 0.2]
    assert again.field("shear_traction", r=r).values == pytest.approx(
        result.field("shear_traction", r=r).values, rel=1e-12
    )
    assert "Cattaneo" in result.claims["tangential_force"].source


def test_claims_say_what_is_neglected():
    result = fretting()
    assert result.claims["normal_force"].level is mdr.Level.EXACT
    assert result.claims["tangential_force"].level is mdr.Level.APPROXIMATE
    assert result.claims["shift"].level is mdr.Level.EXACT
    path = mdr.indent(0.1, duration=1.0, steps=4) >> mdr.shift(0.01, duration=1.0)
    coupled = mdr.solve(joint(rubber(poisson=0.3), 0.5), path)
    assert coupled.claims["normal_force"].level is mdr.Level.APPROXIMATE
    assert "0.286" in coupled.claims["normal_force"].reason
    assert not coupled.assumptions[-1].met
    smooth = mdr.solve(joint(rubber(poisson=0.3), 0.0), path)
    assert smooth.claims["normal_force"].level is mdr.Level.EXACT
    assert smooth.claims["tangential_force"].level is mdr.Level.EXACT
    assert (smooth["tangential_force"].values == 0.0).all()


def test_where_what_sticks_is_no_disk():
    where, disk = np.array([True, True, False]), np.array([True, False, True])
    names = ("tangential_force", "stick_radius")
    claims = sheared_claims(joint(rubber(), math.inf), 0.0, names, where, disk)
    assert claims["stick_radius"].where.tolist() == [True, False, False]
    assert claims["tangential_force"].where.tolist() == where.tolist()
    assert claims["tangential_force"].level is mdr.Level.APPROXIMATE
    assert "1 of 3 rows" in claims["tangential_force"].reason
    none = sheared_claims(joint(rubber(), 0.3), 0.0, names, where, ~where)
    assert none["stick_radius"].level is mdr.Level.NOT_VALID


@pytest.mark.parametrize("mu", [0.0, 0.4, math.inf])
def test_normal_contact_does_not_know_of_friction(mu):
    path = (
        mdr.load(0.05, duration=1.0, steps=5)
        >> mdr.hold("1 s", steps=4)
        >> mdr.load(0.01, duration=0.5, steps=4)
    )
    plain = mdr.solve(mdr.Contact(SHAPES[0], rubber()), path)
    pulled = mdr.solve(joint(rubber(), mu), path)
    for name in ("indentation", "contact_radius", "elastic_energy"):
        assert pulled[name].values == pytest.approx(plain[name].values, rel=1e-9)


def test_a_machine_and_a_power_of_time():
    cell = rubber(mdr.PowerLawRheology(1.0, 1.0, 0.2))
    path = mdr.travel(0.2, duration=1.0, steps=5) >> mdr.shift(0.02, duration=1.0, steps=5)
    result = mdr.solve(joint(cell, 0.5), path, machine_stiffness=1.0)
    force = result["normal_force"].values
    assert result["travel"].values == pytest.approx(result["indentation"].values + force, rel=1e-12)
    assert float(result["tangential_force"][-1]) > 0.0


def test_bodies_that_never_touch():
    path = mdr.indent(-0.1, duration=1.0, steps=2) >> mdr.shift(0.1, duration=1.0, steps=2)
    result = mdr.solve(joint(rubber(), 0.5), path)
    assert (result["tangential_force"].values == 0.0).all()
    assert float(result["shift"][-1]) == 0.1
    again = mdr.solve(joint(rubber(), 0.5), path >> mdr.indent(0.1, duration=1.0, steps=4))
    assert again["tangential_force"].values == pytest.approx(0.0, abs=1e-15)


def test_what_is_refused():
    contact = joint(rubber(), 0.3)
    pressed = mdr.indent(0.1, duration=1.0, steps=4)
    with pytest.raises(PathError, match="friction carries"):
        mdr.solve(contact, pressed >> mdr.drag(1.0, duration=1.0, steps=5))
    with pytest.raises(PathError, match="friction carries"):
        mdr.solve(contact, mdr.indent(-0.1, duration=1.0) >> mdr.drag(1.0, duration=1.0))
    with pytest.raises(PathError, match="duration or a rate"):
        mdr.solve(contact, mdr.shift(0.1))
    with pytest.raises(ProblemError, match="keep="):
        mdr.solve(contact, pressed, keep=2)
    for study in (
        lambda: mdr.friction_loop(contact, [0.01], indentation=0.1),
        lambda: friction_foundation(contact, [0.1], [0.1]),
        lambda: mdr.verify(contact, pressed),
        lambda: mdr.impact(contact, mass=1.0, speed=1.0),
        lambda: mdr.restitution(contact, mass=1.0, speeds=[1.0]),
    ):
        with pytest.raises(ProblemError):
            study()


@settings(max_examples=examples(12), deadline=None)
@given(
    branches=st.lists(st.tuples(st.floats(-9.0, 2.0), st.floats(0.1, 5.0)), min_size=1, max_size=3),
    equilibrium=st.floats(0.05, 2.0),
    moves=st.lists(st.tuples(st.floats(0.01, 1.0), st.floats(1e-4, 1.0)), min_size=1, max_size=6),
    slope=st.floats(-0.5, 0.5).filter(lambda x: abs(x) > 1e-3),
    shape=st.sampled_from(SHAPES[:3]),
    size=st.sampled_from([1e-9, 1.0]),
)
def test_oblique_first_loading_without_slip_carries_as_it_presses(
    branches, equilibrium, moves, slope, shape, size
):
    """F_x = G*/E* (u/d) F_N, 2/3 of it where Poisson's ratio is 1/2, however fast a branch relaxes."""
    body = rubber(mdr.Prony(equilibrium, [m for _, m in branches], [10.0**x for x, _ in branches]))
    d, t = (size * 0.1 * np.cumsum([x for x, _ in moves]) / 6.0, np.cumsum([x for _, x in moves]))
    profile = mdr.Paraboloid(size) if shape is SHAPES[0] else shape
    result = mdr.solve(joint(body, math.inf, profile), rows(t, d, slope * d))
    expected = 2.0 / 3.0 * slope * result["normal_force"].values
    missed = np.abs(result["tangential_force"].values / expected - 1.0)
    assert (missed <= result.claims["tangential_force"].error + 1e-9).all()
    assert missed[-1] < 1e-5


@pytest.mark.parametrize("case", first_of([(0.3, 0.3, -5.0), (0.7, 0.1, -3.5)]))
def test_a_sudden_shift_of_what_relaxes_by_a_power_claims_no_more_than_slip_lets_it(case):
    exponent, friction, move = case
    power = mdr.PowerLawRheology(modulus="1 MPa", time="1 s", exponent=exponent)
    contact = mdr.Contact(
        mdr.Paraboloid("10 mm"), mdr.Viscoelastic(power, poisson=0.5), friction=mdr.Coulomb(friction)
    )
    shift = 10.0**move * np.array([1.0, 1.0, 2.0, 1.0, -2.0])
    result = mdr.solve(
        contact, mdr.Path(time=np.arange(5.0), normal_force=[0.3, 0.5, 1.0, 1.0, 1.0], shift=shift)
    )
    for claim in result.claims.values():
        assert claim.error is None or np.max(claim.error, initial=0.0) <= 1.0
    # all springs slip at once and bear mu F_N whatever the kernel is, whose error alone would be 1;
    # a difference of 1 between grids of a half and a quarter of the springs claims 2^-1.5
    force, claim = result["tangential_force"].values, result.claims["tangential_force"]
    assert abs(force[0] / (0.3 * friction) - 1.0) <= claim.error[0] <= 2.0**-1.5
    assert result.claims["slip_work"].error[0] < 0.7


def random_history(seed):
    """Indentation and shift of a solid that relaxes, in a few long rows at any scale."""
    rng = np.random.default_rng(seed)
    radius, shear, time = 10.0 ** rng.uniform(-6, 0), 10.0 ** rng.uniform(3, 9), 10.0 ** rng.uniform(-3, 2)
    profile = [mdr.Paraboloid(radius), mdr.Cone(slope=10.0 ** rng.uniform(-3, -1))][rng.integers(2)]
    solid = mdr.StandardSolid(shear, shear * 10.0 ** rng.uniform(-1, 1.5), time)
    friction = mdr.Coulomb(10.0 ** rng.uniform(-1.5, 0.2))
    contact = mdr.Contact(profile, mdr.Viscoelastic(solid, poisson=0.5), friction=friction)
    depth, duration = radius * 10.0 ** rng.uniform(-5, -2), time * 10.0 ** rng.uniform(-1, 1)
    path = mdr.indent(depth, duration=duration, steps=int(rng.integers(1, 5)))
    for _ in range(rng.integers(1, 4)):
        path = path >> mdr.ramp(
            steps=int(rng.integers(1, 8)),
            duration=duration * 10.0 ** rng.uniform(-1, 1),
            indentation=depth * rng.uniform(0.3, 1.3),
            shift=depth * rng.uniform(-1, 1),
        )
    return contact, path


@pytest.mark.parametrize("seed", [56, 138, 191, *range(200, 206)])
def test_slip_between_springs_errs_no_more_than_is_claimed(seed, monkeypatch):
    contact, path = random_history(seed)
    result = mdr.solve(contact, path)
    levels = tuple((parts, 4 * n) for parts, n in viscoelastic.LEVELS)
    for module in (viscoelastic, frictional_memory):
        monkeypatch.setattr(module, "LEVELS", levels)
    finer = mdr.solve(contact, path)
    for name in ("tangential_force", "slip_work", "dissipated_energy", "slip_distance"):
        values, expected = result[name].values, finer[name].values
        allowed = result.claims[name].error * np.abs(values) + 1e-12 * np.abs(expected).max()
        assert (np.abs(values - expected) <= allowed).all(), name


def test_a_force_curve_whose_points_leave_no_place_between_them_shears_as_its_profile_does():
    radius = np.append(0.0, np.geomspace(1e-5, 1e-3, 700))  # neighbours within 1 %
    depth = radius**2 / 1e-2
    solid = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "1 ms"), poisson=0.5)
    force = 4.0 / 3.0 * 16e6 / 9.0 * 0.1 * depth**1.5
    curve = mdr.ForceCurve(indentation=depth, force=force, modulus=16e6 / 9.0)
    path = mdr.indent("50 um", steps=6, duration="1 ms") >> mdr.shift("2 um", steps=6, duration="1 ms")
    both = [
        mdr.solve(mdr.Contact(shape, solid, friction=mdr.Coulomb(0.3)), path)
        for shape in (curve, mdr.Paraboloid("10 mm"))
    ]
    for name in ("normal_force", "tangential_force"):
        values, expected = (result[name].values for result in both)
        claimed = sum(result.claims[name].error * np.abs(result[name].values) for result in both)
        assert np.isfinite(values).all()
        assert (np.abs(values - expected) <= claimed + 1e-12 * expected.max()).all()
