"""Friction through solve: references, closed forms, controls, energies, legs, fields, claims, refusals, files."""

import math
import pickle
import re
import tracemalloc
from itertools import pairwise, product

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.solving import frictional
from pymdr.solving.teaching import friction_foundation

MU = 0.3
BODY = mdr.Elastic(2.0, 0.0)  # two of them: E* = G* = 1
SOFT = mdr.Elastic("3 MPa", 0.3)
BALL = mdr.Paraboloid(1.0)
WAVY = mdr.Function(
    lambda r: r * r / 2 + 0.02 * np.sin(3 * r) ** 2, derivative=lambda r: r + 0.06 * np.sin(6 * r)
)
KNOTS = np.linspace(0.0, 1.2, 13)
SAMPLED = mdr.Sampled(KNOTS, KNOTS**2 / 2 + 0.1 * KNOTS**4)
DOME = mdr.FlatPunch(0.3) + BALL
PROFILES = {
    "paraboloid": BALL,
    "cone": mdr.Cone(slope=0.5),
    "sum": mdr.Sphere(2.0) + mdr.Cone(slope=0.2),
    "function": WAVY,
    "sampled": SAMPLED,
    "edge": DOME,
}
NORMAL = (
    "indentation",
    "normal_force",
    "contact_radius",
    "normal_stiffness",
    "mean_pressure",
    "elastic_energy",
)
TANGENTIAL = ("shift", "tangential_force", "tangential_stiffness", "stick_radius", "slip_distance")
ENERGIES = ("stored_tangential_energy", "dissipated_energy")


def contact(profile=BALL, mu=MU, body=BODY, counterbody=None):
    return mdr.Contact(profile, body, counterbody or body, friction=mdr.Coulomb(mu))


def column(result, name):
    return result[name].values


def last(result, name):
    return float(result[name].values[-1])


def same(one, other, tolerance, rows=slice(None)):
    """Both results agree in every column, relative to its largest value; energies relative to both energies."""
    energy = max(np.max(column(one, name)) for name in ENERGIES)
    for name in one.data:
        a, b = column(one, name), column(other, name)[rows]
        scale = energy if name in ENERGIES else np.max(np.abs(a))
        assert np.max(np.abs(a - b)) <= tolerance * scale, name


# --- closed forms ---------------------------------------------------------------------------------------------

POWERS = {
    1.0: mdr.Cone(slope=0.1),
    1.5: mdr.PowerLaw(1.5, "2 um", "50 um"),
    2.0: mdr.Paraboloid("10 mm"),
    4.0: mdr.PowerLaw(4.0, "2 um", "50 um"),
}
HEIGHT = {1.0: (0.1, 1.0), 1.5: (2e-6, 5e-5), 2.0: (5e-3, 1e-2), 4.0: (2e-6, 5e-5)}
"""h and R of f = h (r / R)^n."""
DEPTH, MACHINE = 2e-6, 40.0


class CattaneoMindlin:
    """Partial slip under a constant load for f = h (r/R)^n, first loading (Cattaneo, Mindlin, Jaeger)."""

    def __init__(self, n, kappa, body=SOFT, mu=MU, depth=DEPTH):
        moduli = mdr.effective_moduli(body, body)
        height, radius = HEIGHT[n]
        self.n, self.stiffness = n, moduli.tangential
        self.a = radius * (depth / (kappa * height)) ** (1.0 / n)
        self.load = 2.0 * n / (n + 1.0) * moduli.normal * self.a * depth
        self.carried = mu * self.load
        self.limit = mu * moduli.normal / moduli.tangential * depth

    def force(self, ratio):
        return self.carried * (1.0 - (1.0 - ratio) ** ((self.n + 1.0) / self.n))

    def stick(self, ratio):
        return self.a * (1.0 - ratio) ** (1.0 / self.n)

    def stored(self, ratio):
        """G* int_0^a w^2 dx with w = u_s min(ratio, 1 - (x/a)^n)."""
        n, s = self.n, (1.0 - ratio) ** (1.0 / self.n)
        outer = (1.0 - s) - 2.0 * (1.0 - s ** (n + 1.0)) / (n + 1.0)
        outer += (1.0 - s ** (2.0 * n + 1.0)) / (2.0 * n + 1.0)
        return self.stiffness * self.limit**2 * self.a * (ratio**2 * s + outer)

    def work(self, ratio):
        m = (self.n + 1.0) / self.n
        return self.carried * self.limit * (ratio - (1.0 - (1.0 - ratio) ** (m + 1.0)) / (m + 1.0))


@pytest.fixture(params=POWERS)
def partial_slip(request, closed_forms):
    return CattaneoMindlin(request.param, closed_forms.kappa(request.param))


@pytest.mark.parametrize("tangential", ["shift", "tangential_force"])
@pytest.mark.parametrize("normal", ["indent", "load", "travel"])
def test_partial_slip_under_every_control(partial_slip, normal, tangential):
    exact = partial_slip
    ratio = np.linspace(0.05, 0.95, 19)
    press = {
        "indent": mdr.indent(DEPTH),
        "load": mdr.load(exact.load, steps=3),
        "travel": mdr.travel(DEPTH + exact.load / MACHINE, steps=2),
    }[normal]
    expected = {
        "indentation": np.full(19, DEPTH),
        "travel": np.full(19, DEPTH + exact.load / MACHINE),
        "normal_force": np.full(19, exact.load),
        "contact_radius": np.full(19, exact.a),
        "shift": ratio * exact.limit,
        "tangential_force": exact.force(ratio),
        "stick_radius": exact.stick(ratio),
        "tangential_stiffness": 2.0 * exact.stiffness * exact.stick(ratio),
        "stored_tangential_energy": exact.stored(ratio),
        "slip_distance": np.zeros(19),
    }
    path = press >> mdr.Path(**{tangential: expected[tangential]})
    result = mdr.solve(contact(POWERS[exact.n], body=SOFT), path, machine_stiffness=MACHINE)
    for name, values in expected.items():
        np.testing.assert_allclose(column(result, name)[-19:], values, rtol=1e-12, err_msg=name)
    # the difference of work and stored energy loses digits where little slips
    dissipated = exact.work(ratio) - exact.stored(ratio)
    assert np.max(np.abs(column(result, "dissipated_energy")[-19:] - dissipated)) < 1e-13 * exact.work(0.95)


@settings(max_examples=examples(40), deadline=None)
@given(
    log_depth=st.floats(-9.0, -1.0),
    log_slip=st.floats(-13.0, -0.1),
    turns=st.integers(0, 2),
    steps=st.integers(1, 10),
)
def test_slip_work_of_any_size_errs_no_more_than_its_claim(log_depth, log_slip, turns, steps):
    """Springs at the depth y below d slip by s - y and bear mu E* y: W = 2 mu E* int y (s - y) a'(d - y) dy, and twice that per turn."""
    depth = 10.0**log_depth
    shift = MU * depth * 10.0**log_slip
    path = mdr.indent(depth)
    for turn in range(turns + 1):
        path = path >> mdr.shift(shift * (-1.0) ** turn, steps=steps)
    result = mdr.solve(contact(), path)
    down = shift / MU  # E* = G*
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # y = s (1 - t^2), smooth at full slip too
    t = 0.5 * (nodes + 1.0)
    rate = 0.5 / np.sqrt(depth - down + down * t**2)
    first = MU**2 * down**3 * float(weights @ ((1.0 - t**2) * t**2 * rate * 2.0 * t))
    claim = result.claims["dissipated_energy"]
    error = 0.0 if claim.error is None else float(claim.error[-1])
    assert last(result, "dissipated_energy") == pytest.approx((1 + 2 * turns) * first, rel=1e-10 + error)
    assert error <= 1e-14 / 10.0**log_slip


def test_full_sliding(partial_slip):
    """Past u_s the force stays at mu F_N, the contact slides, and all work is lost to friction."""
    exact = partial_slip
    path = mdr.indent(DEPTH) >> mdr.Path(shift=exact.limit * np.array([1.0, 1.5, 3.0, 2.0, 1.0, 0.5]))
    result = mdr.solve(contact(POWERS[exact.n], body=SOFT), path)
    force = column(result, "tangential_force")[1:] / exact.carried
    # from 3 u_s back by two u_s the contact slides the other way
    turned = 1.0 - 2.0 * exact.force(0.5) / exact.carried
    np.testing.assert_allclose(force, [1.0, 1.0, 1.0, turned, -1.0, -1.0], rtol=1e-12)
    assert column(result, "stick_radius")[[2, 3, 6]].tolist() == [0.0, 0.0, 0.0]
    assert column(result, "tangential_stiffness")[[2, 3, 6]].tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(
        column(result, "slip_distance")[1:] / exact.limit,
        [0.0, 0.5, 2.0, 2.0, 2.0, 2.5],
        rtol=1e-12,
        atol=1e-15,
    )
    dissipated = np.diff(column(result, "dissipated_energy"))[[1, 2, 5]]
    np.testing.assert_allclose(
        dissipated, exact.carried * exact.limit * np.array([0.5, 1.5, 0.5]), rtol=1e-11
    )


def test_masing_branches(partial_slip):
    """Unloading from u_a: F(u_a) - 2 F_1((u_a - u) / 2), and the loop of every control by the closed form."""
    exact, ratio = partial_slip, 0.7
    case, n = contact(POWERS[exact.n], body=SOFT), partial_slip.n
    sweep = mdr.indent(DEPTH) >> mdr.cycle(shift=ratio * exact.limit, cycles=2, steps=80)
    result = mdr.solve(case, sweep)
    u, force = (column(result, name)[11:31] for name in ("shift", "tangential_force"))
    turned = exact.force(ratio) - 2.0 * exact.force(0.5 * (ratio - u / exact.limit))
    assert np.max(np.abs(force - turned)) < 1e-12 * exact.carried
    dissipated = column(result, "dissipated_energy")
    m = (n + 1.0) / n
    loop = 8.0 * exact.work(ratio) - 4.0 * ratio * exact.limit * exact.force(ratio)
    assert dissipated[50] - dissipated[10] == pytest.approx(loop, rel=1e-11)
    assert 0.0 < loop < 4.0 * ratio * exact.carried * exact.limit * m
    # a loop between two forces has its turning points at the same shifts
    by_force = mdr.load(exact.load) >> mdr.cycle(tangential_force=exact.force(ratio), cycles=2, steps=8)
    forced = mdr.solve(case, by_force)
    np.testing.assert_allclose(
        column(forced, "shift")[[1, 3, 5]] / exact.limit, [ratio, -ratio, ratio], rtol=1e-12
    )
    assert np.diff(column(forced, "dissipated_energy")[[1, 5]])[0] == pytest.approx(loop, rel=1e-11)


CONTROLS = tuple(product(("indentation", "normal_force", "travel"), ("shift", "tangential_force")))


@pytest.mark.parametrize("name", PROFILES)
def test_oblique_full_stick(name):
    """Straight oblique loading below friction: F_x = (G*/E*) (du_x/dd) F_N without slip (5.6), and back."""
    case, slope = contact(PROFILES[name], body=SOFT), 0.2
    d = np.concatenate([np.linspace(0.02, 0.3, 15), np.linspace(0.28, 0.02, 14)])
    moduli = mdr.effective_moduli(SOFT, SOFT)
    known = mdr.solve(case, mdr.Path(indentation=d))
    force = column(known, "normal_force")
    pulled = moduli.tangential / moduli.normal * slope * force
    given = {
        "indentation": d,
        "normal_force": force,
        "travel": d + force / 1e6,
        "shift": slope * d,
        "tangential_force": pulled,
    }
    chosen = CONTROLS if name in ("paraboloid", "cone", "edge") else CONTROLS[:4]
    for normal, tangential in chosen:
        if tangential == "shift" and normal != "indentation":
            continue  # straight in these channels: another path
        path = mdr.Path(**{normal: given[normal], tangential: given[tangential]})
        result = mdr.solve(case, path, machine_stiffness=1e6)
        # tables of a(d) and the inverse from a force are good to 1e-12 of their largest values
        assert np.max(np.abs(column(result, "tangential_force") - pulled)) < 3e-12 * pulled.max()
        assert np.max(np.abs(column(result, "shift") - slope * d)) < 3e-12
        a = column(result, "contact_radius")
        assert np.max(np.abs(column(result, "stick_radius") - a)) < 3e-12 * a.max()
        stored = slope**2 * moduli.tangential / moduli.normal * column(result, "elastic_energy")
        assert np.max(np.abs(column(result, "stored_tangential_energy") - stored)) < 3e-12 * stored.max()
        assert np.max(np.abs(column(result, "dissipated_energy"))) < 3e-12 * stored.max()
        assert last(result, "slip_distance") == 0.0


def test_oblique_loading_beyond_friction():
    """du_x/dd above mu E*/G*: the whole contact slides from the first touch, by what exceeds it."""
    d = np.linspace(0.01, 0.1, 10)
    result = mdr.solve(contact(), mdr.Path(indentation=d, shift=0.5 * d))
    np.testing.assert_allclose(
        column(result, "tangential_force"), MU * column(result, "normal_force"), rtol=1e-13
    )
    assert np.all(column(result, "stick_radius") == 0.0)
    np.testing.assert_allclose(column(result, "slip_distance"), (0.5 - MU) * d, rtol=1e-13)
    # slip of ever more springs: int mu F_N (0.5 - mu) dd
    dissipated = MU * (0.5 - MU) * 8 / 15 * d**2.5
    np.testing.assert_allclose(column(result, "dissipated_energy"), dissipated, rtol=1e-12)


@pytest.mark.parametrize("name", PROFILES)
def test_tangential_forces_under_an_indentation_are_straight_in_the_displacements(name):
    """The forces of a displacement history, given back row by row in either direction, lead through it again."""
    rng = np.random.default_rng(5)
    case = contact(PROFILES[name], body=SOFT)
    ratio = mdr.effective_moduli(SOFT, SOFT).normal / mdr.effective_moduli(SOFT, SOFT).tangential
    # |G* u_x| < mu E* d at all times: a contact that slides as a whole has no shift that belongs to its force
    d, u = rng.uniform(0.15, 0.3, 14), MU * ratio * rng.uniform(-0.14, 0.14, 14)
    whole = mdr.solve(case, mdr.Path(indentation=d, shift=u), machine_stiffness=1e7)
    assert last(whole, "slip_distance") == 0.0
    for normal, tangential in CONTROLS[1:]:
        if normal == "normal_force" or tangential == "shift":
            continue  # straight in these channels: another path
        given = {channel: column(whole, channel) for channel in (normal, tangential)}
        again = mdr.solve(case, mdr.Path(**given), machine_stiffness=1e7)
        same(whole, again, 2e-12)


def test_stiffness_is_twice_the_stick_radius():
    rng = np.random.default_rng(7)
    path = mdr.Path(indentation=rng.uniform(-0.1, 0.3, 60), shift=rng.uniform(-0.1, 0.1, 60))
    for profile in (BALL, WAVY, DOME):
        result = mdr.solve(contact(profile, body=SOFT), path)
        modulus = mdr.effective_moduli(SOFT, SOFT).tangential
        assert np.array_equal(
            column(result, "tangential_stiffness"), 2 * modulus * column(result, "stick_radius")
        )
        assert np.all(column(result, "stick_radius") <= column(result, "contact_radius"))


def test_normal_columns_are_those_without_friction():
    rng = np.random.default_rng(8)
    d = rng.uniform(-0.05, 0.3, 30)
    for profile in PROFILES.values():
        rubbed = mdr.solve(contact(profile), mdr.Path(indentation=d, shift=rng.uniform(-0.1, 0.1, 30)))
        plain = mdr.solve(mdr.Contact(profile, BODY, BODY), mdr.Path(indentation=d))
        for name in NORMAL:
            np.testing.assert_allclose(column(rubbed, name), column(plain, name), rtol=1e-13, atol=1e-30)


# --- energy, invariance and an independent memory -------------------------------------------------------------


@pytest.mark.parametrize("name", PROFILES)
def test_springs_of_the_founding_paper_converge(name):
    """Forces and energies of n springs tend to those of the stack as n^-2."""
    rng = np.random.default_rng(2)
    case = contact(PROFILES[name], body=SOFT)
    d, u = rng.uniform(0.1, 0.3, 24), rng.uniform(-0.1, 0.1, 24)
    exact = mdr.solve(case, mdr.Path(indentation=d, shift=u))
    counts, errors = np.array([500, 2000, 8000, 32000]), []
    for n in counts.tolist():
        line = friction_foundation(case, d, u, n=n)
        errors.append(
            [
                np.max(np.abs(line.tangential_force - column(exact, "tangential_force"))),
                np.max(np.abs(line.stored_energy - column(exact, "stored_tangential_energy"))),
                np.max(np.abs(line.slip_work - column(exact, "dissipated_energy"))),
            ]
        )
    orders = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert np.all((orders > -2.3) & (orders < -1.7))


class Memory:
    """The anchor curve b(y) as points, cut and clipped by the cone of (d, v) at every straight move (5.4)."""

    def __init__(self):
        self.y, self.b, self.d, self.v = np.zeros(1), np.zeros(1), 0.0, 0.0

    def kinks_of(self, d, v, rough):
        """Times of a straight move at which a border of slip or of contact meets a vertex or a rough depth."""
        dd, dv = d - self.d, v - self.v
        y = np.unique(np.append(self.y, rough))
        b = np.interp(y, self.y, self.b)
        marks, y, b = y, y[y <= max(self.d, 0.0)], b[y <= max(self.d, 0.0)]
        results = [np.array([0.0, 1.0])]
        for side in (1.0, -1.0):
            rate = side * dv - dd
            if rate != 0.0:
                results.append(((side * b - y) - (side * self.v - self.d)) / rate)
        if dd != 0.0:
            results.append((marks - self.d) / dd)
            lag = self.v + dv / dd * (y - self.d) - b
            for i in np.flatnonzero(lag[:-1] * lag[1:] < 0.0):
                cross = y[i] + (y[i + 1] - y[i]) * lag[i] / (lag[i] - lag[i + 1])
                results.append(np.array([(cross - self.d) / dd]))
        times = np.unique(np.concatenate(results))
        return times[(times >= 0.0) & (times <= 1.0)]

    def move(self, d, v):
        if self.d <= 0.0 < d:
            self.b = np.array([self.v + (v - self.v) * -self.d / (d - self.d)])
        y, b = self.y, self.b
        if d <= 0.0:
            self.y, self.b, self.d, self.v = np.zeros(1), np.array([v]), d, v
            return
        if d < self.d:
            kept = y < d
            y, b = np.append(y[kept], d), np.append(b[kept], np.interp(d, y, b))
        new = [y]
        for side in (1.0, -1.0):
            lag = b - (v - side * (d - y))
            for i in np.flatnonzero(lag[:-1] * lag[1:] < 0.0):
                new.append(y[i : i + 1] + (y[i + 1] - y[i]) * lag[i] / (lag[i] - lag[i + 1]))
        whole = np.unique(np.concatenate(new))
        b = np.clip(np.interp(whole, y, b), v - (d - whole), v + (d - whole))
        if whole[-1] < d:
            whole, b = np.append(whole, d), np.append(b, v)
        self.y, self.b, self.d, self.v = whole, b, d, v


NODES, WEIGHTS = np.polynomial.legendre.leggauss(30)
NODES, WEIGHTS = 0.5 + 0.5 * NODES, 0.5 * WEIGHTS
CLUSTERED = NODES**4 * (35 - 84 * NODES + 70 * NODES**2 - 20 * NODES**3)
CLUSTERED_WEIGHTS = WEIGHTS * 140 * NODES**3 * (1.0 - NODES) ** 3


def on_intervals(marks):
    """Nodes and weights of an integral over the pieces between some marks, whose ends may be rough."""
    parts = np.array(list(pairwise(marks)))
    span = parts[:, 1:] - parts[:, :1]
    return (parts[:, :1] + span * CLUSTERED).ravel(), (span * CLUSTERED_WEIGHTS).ravel()


@st.composite
def contacts(draw):
    """Closed profiles, sums, callables and samples of very different sizes, with their size."""
    size = 10.0 ** draw(st.floats(-8, 1))
    part = st.one_of(
        st.builds(lambda n, c: mdr.PowerLaw(n, c * size, size), st.floats(1.0, 6.0), st.floats(0.3, 2.0)),
        st.builds(lambda c: mdr.Cone(slope=c), st.floats(0.3, 2.0)),
        st.builds(lambda c: mdr.Sphere(c * size), st.floats(2.0, 4.0)),
    )
    profile = draw(part)
    kind = draw(st.sampled_from(["closed", "sum", "function", "sampled"]))
    if kind != "closed":
        profile = profile + draw(part)
    if kind == "function":
        profile = mdr.Function(profile.gap, derivative=profile.gap_slope, max_radius=profile.max_radius)
    if kind == "sampled":  # a sphere keeps the spline from dipping beside a flat tip, where there is no disk
        r, profile = np.linspace(0.0, 1.5 * size, 13), profile + mdr.Sphere(2.0 * size)
        profile = mdr.Sampled(r, profile.gap(r))
    return mdr.Contact(
        profile, SOFT, SOFT, friction=mdr.Coulomb(draw(st.sampled_from([0.1, 0.5, 2.0])))
    ), size


depths = st.one_of(st.floats(0.01, 1.0), st.sampled_from([0.25, 0.5, 1.0]))
shifts = st.one_of(st.floats(1e-3, 1.2), st.floats(-1.2, -1e-3), st.sampled_from([-0.5, 0.0, 0.25]))
rows_with_loss = st.lists(
    st.tuples(st.one_of(depths, depths, depths, st.floats(-0.3, -0.01)), shifts), min_size=1, max_size=7
)


def displacements(case, size, history):
    """d and u_x in m of a history in units of the largest depth and of the shift at which it would slide."""
    v, d = 0.3 * size * np.array(history, dtype=float).T[::-1]
    moduli = mdr.effective_moduli(case.body, case.counterbody)
    return d, v * case.friction.coefficient * moduli.normal / moduli.tangential


@settings(max_examples=examples(12), deadline=None)
@given(contacts(), rows_with_loss)
def test_energy_and_forces_by_an_independent_memory(problem, history):
    """Stored energy + slip work = int F_x du_x to 1e-11, and F_x = mu sum sigma_i [F_N(y_i) - F_N(y_(i-1))]."""
    case, size = problem
    d, u = displacements(case, size, history)
    moduli = mdr.effective_moduli(case.body, case.counterbody)
    mu = case.friction.coefficient
    scale = mu * moduli.normal / moduli.tangential
    result = mdr.solve(case, mdr.Path(indentation=d, shift=u))
    rough = np.zeros(1)
    if isinstance(case.profile, mdr.Sampled):  # a(d) is not smooth at the depths that reach a sample
        rough = mdr.equivalent_profile(case.profile).g(case.profile.radius)
    memory, curves, fine, weights = Memory(), [], [], []
    for x, v in zip(d, u / scale, strict=True):
        t, w = on_intervals(memory.kinks_of(x, v, rough))
        t, w = np.append(t, 1.0), np.append(w, 0.0)
        fine.append(np.array([memory.d + (x - memory.d) * t, scale * (memory.v + (v - memory.v) * t)]))
        weights.append(w * scale * (v - memory.v))
        memory.move(x, v)
        curves.append((memory.y, memory.b))
    # the forces of the memory
    known = mdr.solve(
        mdr.Contact(case.profile, SOFT, SOFT), mdr.Path(indentation=np.concatenate([y for y, _ in curves]))
    )
    force = np.split(column(known, "normal_force"), np.cumsum([y.size for y, _ in curves])[:-1])
    carried = mu * max(np.max(f) for f in force)
    for (y, b), f, computed in zip(curves, force, column(result, "tangential_force"), strict=True):
        expected = mu * np.sum(np.diff(b) / np.diff(y) * np.diff(f))
        assert abs(computed - expected) <= 1e-11 * carried
    # the work
    steps = np.concatenate(fine, axis=1)
    pulled = column(mdr.solve(case, mdr.Path(indentation=steps[0], shift=steps[1])), "tangential_force")
    ends = np.cumsum([w.size for w in weights]) - 1
    work = np.cumsum(np.concatenate(weights) * pulled)[ends]
    stored, dissipated = column(result, "stored_tangential_energy"), column(result, "dissipated_energy")
    largest = max(np.max(np.abs(work)), np.max(stored))
    assert np.max(np.abs(stored + dissipated - work)) <= 1e-11 * largest
    assert np.all(np.diff(dissipated, prepend=0.0) >= -1e-13 * largest)


# --- legs -----------------------------------------------------------------------------------------------------


def test_cycles_turn_about_the_value_at_their_start():
    path = mdr.indent(0.1) >> mdr.shift(0.013) >> mdr.cycle(shift=0.021, cycles=3, steps=36)
    result = mdr.solve(contact(), path)
    u = column(result, "shift")[2:]
    assert u[[2, 14, 26]].tolist() == [0.013 + 0.021] * 3
    assert u[[8, 20, 32]].tolist() == [0.013 - 0.021] * 3
    assert u[[5, 11, 17, 23, 29, 35]].tolist() == [0.013] * 6
    assert np.allclose(np.abs(np.diff(u, prepend=0.013)), 0.007, rtol=1e-12)
    # after the first turn every cycle is the same
    for name in ("tangential_force", "stick_radius", "stored_tangential_energy"):
        rows = column(result, name)[2:]
        assert np.max(np.abs(rows[14:24] - rows[26:36])) < 1e-13 * np.max(rows)
    with pytest.raises(mdr.PathError, match=r"Cycle\.steps = 12: .* multiple of 8, .* of 2 cycles"):
        mdr.cycle(shift=1.0, cycles=2, steps=12)


@pytest.mark.parametrize("channel", ["indentation", "normal_force", "travel", "tangential_force"])
def test_cycles_of_other_channels(channel):
    """A cycle is the path of its rows; the other direction stays under the control of the leg before."""
    case = contact()
    start = mdr.load(0.03) >> mdr.ramp(shift=0.02, normal_force=0.05, steps=3)
    before = mdr.solve(case, start, machine_stiffness=0.5)
    centre = last(before, channel)
    swing = 0.2 * centre
    result = mdr.solve(case, start >> mdr.cycle(**{channel: swing}, steps=8), machine_stiffness=0.5)
    rows = centre + swing * np.array([0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0])
    np.testing.assert_allclose(column(result, channel)[4:], rows, rtol=1e-13)
    fixed = "normal_force" if channel == "tangential_force" else "shift"
    assert np.all(column(result, fixed)[4:] == last(before, fixed))
    again = mdr.solve(case, start >> mdr.Path(**{channel: rows}), machine_stiffness=0.5)
    same(result, again, 1e-12)


def test_hold_changes_nothing():
    for start in (
        mdr.indent(0.1) >> mdr.shift(0.02),
        mdr.load(0.05) >> mdr.drag(0.01),
        mdr.travel(0.3) >> mdr.drag(0.002) >> mdr.shift(0.02),
        mdr.indent(-0.1) >> mdr.shift(0.1),
    ):
        result = mdr.solve(contact(), start >> mdr.hold(steps=3), machine_stiffness=0.5)
        first = len(start.legs) - 1
        for name in result.data:
            rows = column(result, name)[first:]
            assert np.max(np.abs(rows - rows[0])) <= 1e-15 * abs(rows[0]), name
    idle = mdr.solve(contact(), mdr.hold(steps=2))
    assert all(np.all(column(idle, name) == 0.0) for name in idle.data)


def test_changes_of_control():
    """Channels start where the leg before left them, under whatever control; the held one stays."""
    case = contact(body=SOFT, profile=mdr.Paraboloid("1 mm"))
    path = (
        mdr.load("0.2 N", steps=2)
        >> mdr.drag("30 mN", steps=2)
        >> mdr.indent("220 um", steps=2)  # holds the force sideways
        >> mdr.shift("10 um", steps=2)
        >> mdr.load("0.3 N", steps=2)  # holds the shift
        >> mdr.travel("240 um", steps=2)
        >> mdr.drag("-20 mN", steps=2)
    )
    result = mdr.solve(case, path, machine_stiffness="20 kN/m")
    at = {name: column(result, name) for name in map(str, result.data)}
    for name, first, stop, value in (
        ("normal_force", 1, 4, 0.2),
        ("tangential_force", 3, 6, 0.03),
        ("indentation", 5, 8, 220e-6),
        ("shift", 7, 12, 10e-6),
        ("normal_force", 9, 10, 0.3),
        ("travel", 11, 14, 240e-6),
    ):
        np.testing.assert_allclose(
            at[name][first:stop], value, rtol=1e-13, err_msg=f"{name} from row {first}"
        )
    assert at["tangential_force"][13] == -0.02
    for channel, row, target in (
        ("indentation", 4, 220e-6),
        ("shift", 6, 10e-6),
        ("travel", 10, 240e-6),
        ("tangential_force", 12, -0.02),
    ):  # half way
        middle = 0.5 * (at[channel][row - 1] + target)
        assert at[channel][row] == pytest.approx(middle, rel=1e-12)
    assert result.starts is not None
    assert len(result.starts) == 7
    for start, row in zip(result.starts[1:], (1, 3, 5, 7, 9, 11), strict=True):
        for name in ("indentation", "normal_force", "travel", "shift", "tangential_force"):
            assert start[name] == pytest.approx(at[name][row], rel=1e-12), name


def test_loss_and_return_of_contact():
    """The memory goes with the contact, which returns free of stress at the shift of first touch."""
    path = mdr.indent(0.1) >> mdr.shift(0.02) >> mdr.indent(-0.1) >> mdr.shift(0.07)
    back = mdr.ramp(indentation=0.1, shift=0.09, steps=4)
    for profile in (BALL, DOME, SAMPLED):
        result = mdr.solve(contact(profile), path >> back)
        for name in (*TANGENTIAL[1:4], "stored_tangential_energy"):
            assert column(result, name)[2:4].tolist() == [0.0, 0.0], name
        # touched half way, at shift 0.08, and on along a straight line within friction
        fresh = mdr.solve(contact(profile), mdr.ramp(indentation=0.1, shift=0.01))
        for name in ("tangential_force", "stick_radius", "stored_tangential_energy"):
            assert last(result, name) == pytest.approx(last(fresh, name), rel=1e-12)
        dissipated = column(result, "dissipated_energy")
        assert dissipated[2] > 0.0
        assert np.all(dissipated[2:] == pytest.approx(dissipated[2], rel=1e-13))
        # what was stored at the moment of unloading is lost, since the shift rests
        assert dissipated[2] == pytest.approx(
            dissipated[1] + float(result["stored_tangential_energy"][1]), rel=1e-12
        )
    # the same between forces
    by_force = mdr.load(0.05) >> mdr.drag(0.01) >> mdr.ramp(normal_force=0.0, tangential_force=0.0)
    result = mdr.solve(contact(), by_force >> mdr.load(0.05) >> mdr.drag(0.01))
    assert float(result["contact_radius"][2]) == 0.0
    np.testing.assert_allclose(
        np.diff(column(result, "shift")[[2, 4]]), column(result, "shift")[1], rtol=1e-12
    )


def test_a_first_leg_without_contact():
    """Where nothing touches yet there is nothing to be mapped far out, whatever the profile."""
    tip = mdr.Sphere("50 um")
    for max_radius in (math.inf, "50 um"):
        end = mdr.Function(tip.gap, derivative=tip.gap_slope, max_radius=max_radius)
        result = mdr.solve(contact(end), mdr.indent("-1 um") >> mdr.shift("1 um"))
        assert last(result, "normal_force") == last(result, "slip_distance") == 0.0
        assert mdr.equivalent_profile(end).g(0.0) == 0.0
    for profile in (BALL, WAVY, SAMPLED):
        case = contact(profile)
        result = mdr.solve(case, mdr.shift(0.3) >> mdr.indent(0.1) >> mdr.shift(0.32))
        plain = mdr.solve(case, mdr.indent(0.1) >> mdr.shift(0.02))
        assert last(result, "tangential_force") == pytest.approx(last(plain, "tangential_force"), rel=1e-12)
        assert last(mdr.solve(case, mdr.load(0.0) >> mdr.load(0.01)), "indentation") > 0.0
    for profile in (BALL, SAMPLED):
        separated = mdr.solve(contact(profile), mdr.indent(-0.1) >> mdr.shift(0.2))
        assert last(separated, "tangential_force") == 0.0
        assert np.isnan(separated.field("slip", r=[0.0, 0.1]).values).all()
        assert separated.field("tangential_displacement", r=[0.0, 0.1]).values.tolist() == [0.0, 0.0]
        assert separated.field("shear_traction", r=[0.0, 0.1]).values.tolist() == [0.0, 0.0]


def test_unloading_at_rest():
    """d falls at a constant shift: F_x = mu [F_N(d) - F_N(d - v)], the memory of the larger load is gone."""
    d0, v = 0.25, 0.1
    for profile in (BALL, mdr.Cone(slope=0.5), WAVY):
        case = contact(profile)
        d = np.linspace(0.2, 0.11, 10)
        result = mdr.solve(case, mdr.indent(d0) >> mdr.shift(MU * v) >> mdr.Path(indentation=d))
        force = [
            column(mdr.solve(mdr.Contact(profile, BODY, BODY), mdr.Path(indentation=x)), "normal_force")
            for x in (d, d - v)
        ]
        np.testing.assert_allclose(
            column(result, "tangential_force")[2:], MU * (force[0] - force[1]), rtol=1e-11
        )
        energy = column(result, "stored_tangential_energy") + column(result, "dissipated_energy")
        assert np.max(np.abs(energy[2:] - energy[1])) < 1e-12 * energy[1]


def test_loading_after_slip_and_small_turns_do_not_slip():
    """New springs come in free of stress, and a turn starts from stick everywhere."""
    result = mdr.solve(contact(), mdr.indent(0.1) >> mdr.shift(0.02) >> mdr.indent(0.2, steps=5))
    assert np.ptp(column(result, "dissipated_energy")[1:]) == 0.0
    assert np.ptp(column(result, "tangential_force")[1:]) < 1e-15
    a, stick = column(result, "contact_radius"), column(result, "stick_radius")
    assert stick[1] < 0.6 * a[1]
    np.testing.assert_array_equal(stick[2:], a[2:])
    # unloading along a line inside the cone of friction: no slip on the way back to a state of full stick
    there = mdr.ramp(indentation=0.1, shift=0.02, steps=3)
    both = there >> mdr.ramp(indentation=0.05, shift=0.01, steps=3)
    result = mdr.solve(contact(), both)
    assert np.max(column(result, "dissipated_energy")) < 1e-16
    np.testing.assert_allclose(column(result, "stick_radius"), column(result, "contact_radius"), rtol=1e-13)


def test_without_friction():
    path = mdr.indent(0.1) >> mdr.cycle(shift=0.05, steps=4) >> mdr.ramp(indentation=-0.1, shift=0.1)
    result = mdr.solve(contact(mu=0.0), path)
    for name in TANGENTIAL:
        if name not in ("shift", "slip_distance"):
            assert np.all(column(result, name) == 0.0), name
    np.testing.assert_allclose(column(result, "slip_distance"), [0, 0.05, 0.1, 0.15, 0.2, 0.25], atol=1e-16)
    assert np.all(result.field("shear_traction", r=[0.0, 0.1], step=2).values == 0.0)
    np.testing.assert_allclose(result.field("slip", r=[0.0, 0.1], step=1).values, 0.05)
    dragged = mdr.solve(contact(mu=0.0), mdr.load(0.01) >> mdr.drag(0.0) >> mdr.shift(0.1))
    assert last(dragged, "slip_distance") == pytest.approx(0.1, rel=1e-15)


@pytest.mark.parametrize("mu", [math.inf, "inf"])
def test_no_slip(mu):
    """Springs stick from touch to parting: F_x = 2 G* a u_x under a constant load, for shifts and forces."""
    case = contact(mu=mu, body=SOFT)
    modulus = mdr.effective_moduli(SOFT, SOFT).tangential
    path = mdr.indent(0.04) >> mdr.shift(0.5) >> mdr.indent(0.01) >> mdr.drag(0.0) >> mdr.drag(1e5)
    result = mdr.solve(case, path)
    force, a, u = (column(result, name) for name in ("tangential_force", "contact_radius", "shift"))
    np.testing.assert_allclose(force[[1, 2]], 2 * modulus * a[[1, 2]] * 0.5, rtol=1e-12)
    np.testing.assert_allclose(u[[3, 4]], [0.0, 1e5 / (2 * modulus * a[4])], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(column(result, "stick_radius"), a, rtol=1e-13)
    assert last(result, "slip_distance") == 0.0
    # springs that part release their energy G* (a0 - a1) u^2
    assert float(result["dissipated_energy"][2]) == pytest.approx(modulus * (a[1] - a[2]) * 0.25, rel=1e-12)
    tau = result.field("shear_traction", r=[0.0, 0.05], step=1).values
    np.testing.assert_allclose(
        tau, modulus * 0.5 / (math.pi * np.sqrt(0.04 - np.array([0.0, 0.05]) ** 2)), rtol=1e-11
    )
    np.testing.assert_allclose(
        result.field("tangential_displacement", r=[0.0, 0.1, 0.4], step=1).values,
        [0.5, 0.5, 0.5 * 2 / math.pi * math.asin(0.5)],
        rtol=1e-12,
    )
    assert result.contact.friction.coefficient == math.inf


def test_time():
    path = mdr.indent(0.1, steps=2, duration="4 s") >> mdr.cycle(shift=0.02, steps=4, duration="1 s")
    result = mdr.solve(contact(), path >> mdr.hold("5 s"))
    assert column(result, "time").tolist() == [2.0, 4.0, 4.25, 4.5, 4.75, 5.0, 10.0]
    assert column(mdr.solve(contact(), path, keep=[0, -1]), "time").tolist() == [2.0, 5.0]
    with pytest.raises(mdr.PathError, match="leg 3 has no time, but legs 1 and 2 have"):
        mdr.solve(contact(), path >> mdr.shift(0.0))


def test_progress_in_parts_is_the_whole(monkeypatch):
    """Long legs are followed in parts where somebody watches: the same rows, numbers and refusals."""
    monkeypatch.setattr(frictional, "_CHUNK", 7)
    rng = np.random.default_rng(12)
    d, u = rng.uniform(-0.05, 0.3, 30), rng.uniform(-0.1, 0.1, 30)
    path = mdr.Path(indentation=d, shift=u) >> mdr.cycle(shift=0.05, steps=4)
    for keep in (None, 4, [0, 6, 7, 33]):
        seen = []
        whole = mdr.solve(contact(), path, keep=keep)
        parts = mdr.solve(contact(), path, keep=keep, progress=lambda done, total: seen.append((done, total)))  # noqa: B023
        assert seen == [(7, 34), (14, 34), (21, 34), (28, 34), (30, 34), (34, 34)]
        xr.testing.assert_equal(
            whole.data.drop_vars("dissipated_energy"), parts.data.drop_vars("dissipated_energy")
        )
        # a part begins with the sum of the parts before, rounded
        dissipated = column(whole, "dissipated_energy")
        assert np.max(np.abs(dissipated - column(parts, "dissipated_energy"))) <= np.spacing(dissipated[-1])
    pulled = mdr.load(1.0) >> mdr.Path(tangential_force=np.linspace(0.0, 0.4, 21))
    for progress in (None, lambda done, total: None):
        with pytest.raises(mdr.PathError, match=r"tangential_force = 320 mN in row 17 of leg 2"):
            mdr.solve(contact(), pulled, progress=progress)


# --- fields ---------------------------------------------------------------------------------------------------

TURNS = (
    mdr.indent(0.15)
    >> mdr.shift(0.03)
    >> mdr.shift(-0.01)
    >> mdr.ramp(indentation=0.2, shift=0.005)
    >> mdr.shift(0.04)
    >> mdr.indent(0.12)
    >> mdr.ramp(indentation=0.14, shift=0.02)
)
FIELDS = ("shear_traction", "tangential_displacement", "slip")


@pytest.fixture(scope="module", params=PROFILES)
def turned(request):
    return mdr.solve(contact(PROFILES[request.param]), TURNS)


def marks(result, step):
    """Radii up to a between which the fields are smooth: disks whose pressures add up to them, and samples."""
    y = result.surface.replay.state(step).y[1:]
    study = mdr.solve(mdr.Contact(result.contact.profile, BODY, BODY), mdr.Path(indentation=y))
    rings = column(study, "contact_radius")
    knots = KNOTS if isinstance(result.contact.profile, mdr.Sampled) else np.zeros(1)
    rings = np.unique([*rings, *knots[knots < rings.max()]])
    return rings[np.append(True, np.diff(rings) > 1e-12)]


def test_traction_integrates_to_the_force(turned):
    for step in range(7):
        rings = marks(turned, step)[:, None]
        # r^2 = high^2 - q^2 takes the root at the edge of a disk; nodes gather at the low end, where a tip may be
        middle = np.sqrt((rings[1:] - rings[:-1]) * (rings[1:] + rings[:-1]))
        q, w = middle * (1.0 - (1.0 - NODES) ** 5), 5.0 * middle * WEIGHTS * (1.0 - NODES) ** 4
        tau = turned.field("shear_traction", np.sqrt((rings[1:] - q) * (rings[1:] + q)).ravel(), step).values
        total = 2 * math.pi * np.dot((w * q).ravel(), tau)
        carried = MU * float(turned["normal_force"][step])
        assert total == pytest.approx(float(turned["tangential_force"][step]), abs=1e-9 * carried)


def test_traction_stays_below_friction(turned):
    for step in range(7):
        a = float(turned["contact_radius"][step])
        # not at a itself, which is known to rounding: there sqrt(a^2 - r^2) has no digits
        r = a * np.concatenate([np.sin(np.linspace(0.0, math.pi / 2, 200)[:-1]), [1.0 - 1e-6, 1.01, 2.0]])
        tau = np.abs(turned.field("shear_traction", r, step).values)
        p = turned.field("pressure", r, step).values
        finite = np.isfinite(p)
        assert np.all(tau[finite] <= MU * p[finite] + 1e-12 * turned["mean_pressure"].values[step])
        assert np.all(tau[r > a] == 0.0)
        # in the slip annulus the two are equal
        b = float(turned["stick_radius"][step])
        slips = finite & (r > b * (1 + 1e-9)) & (r < a)
        np.testing.assert_allclose(tau[slips], MU * p[slips], rtol=1e-9, atol=1e-12)


def test_displacement_and_slip_fields(turned):
    for step in range(7):
        a, u = float(turned["contact_radius"][step]), float(turned["shift"][step])
        r = a * np.array([0.0, 0.3, 0.8, 1.0, 1.0 + 1e-9, 1.5, 2.5])
        moved, slip = (turned.field(name, r, step).values for name in FIELDS[1:])
        np.testing.assert_array_equal(slip[:4], u - moved[:4])
        assert np.isnan(slip[4:]).all()
        # continuous at a, beside a sharp edge as (2/pi) w asin(a/r), and far away u_x -> F_x / (pi G* r)
        edge = float(turned.field("spring_shift", a, step)[0])
        assert moved[4] == pytest.approx(moved[3] - 2 / math.pi * math.sqrt(2e-9) * edge, abs=1e-8 * abs(u))
        far = 1e4 * a
        if not isinstance(turned.contact.profile, mdr.Sampled):
            point = float(turned["tangential_force"][step]) / (math.pi * far)
            assert float(turned.field("tangential_displacement", far, step)[0]) == pytest.approx(
                point, rel=1e-7
            )


def test_springs_carry_the_force(turned):
    for step in range(7):
        a = float(turned["contact_radius"][step])
        x, w = on_intervals(marks(turned, step))
        shift = turned.field("spring_shift", x, step).values
        total = 2.0 * np.dot(w, shift)
        assert total == pytest.approx(float(turned["tangential_force"][step]), rel=1e-12)
        assert float(turned.field("spring_shift", a * (1 + 1e-9), step)[0]) == 0.0
        limit = MU * turned.field("spring_force", x, step).values
        assert np.all(np.abs(shift) <= limit + 1e-12 * np.max(limit))


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("normal", ["indent", "load"])
def test_stuck_disk_moves_with_the_body(name, normal):
    """At a constant load: u_x(r) = u_x and no slip for r < c; beyond, slip of the sign of the sliding."""
    case = contact(PROFILES[name])
    load = last(mdr.solve(case, mdr.indent(0.15)), "normal_force")
    press = mdr.indent(0.15) if normal == "indent" else mdr.load(load)
    result = mdr.solve(case, press >> mdr.Path(shift=[0.02, 0.015, -0.02]))
    a, c = float(result["contact_radius"][1]), float(result["stick_radius"][1])
    inner = c * np.linspace(0.0, 1.0 - 1e-9, 12)
    outer = c + (a - c) * np.array([0.05, 0.3, 0.6, 0.9, 1.0])
    # the table of a(d) and the map of samples are good to 1e-12
    assert np.max(np.abs(result.field("tangential_displacement", inner, 1).values - 0.02)) < 1e-13
    assert np.max(np.abs(result.field("slip", inner, 1).values)) < 1e-13
    slips = result.field("slip", outer, 1).values
    assert np.all(slips > 0.0)
    assert np.all(np.diff(slips) > 0.0)
    # turned back a little, only the outermost annulus slips, the other way
    after = result.field("slip", np.concatenate([inner, outer]), 2).values
    b = float(result["stick_radius"][2])
    assert b > c
    before = np.concatenate([np.zeros(12), slips])
    stuck = np.concatenate([inner, outer]) < b * (1 - 1e-9)
    assert np.max(np.abs(after - before)[stuck]) < 1e-12
    assert np.all((after - before)[np.concatenate([inner, outer]) > b * (1 + 1e-9)] < 0.0)
    # fully turned, the loop is antisymmetric
    for field in FIELDS:
        r = np.concatenate([inner, outer])
        one, other = (result.field(field, r, step).values for step in (1, 3))
        finite = np.isfinite(one)
        assert np.max(np.abs(one[finite] + other[finite])) < 1e-11 * np.max(np.abs(one[finite]))
        np.testing.assert_array_equal(one[~finite], -other[~finite])


def test_hertz_tractions():
    """tau = (3 mu F_N / 2 pi a^3) [sqrt(a^2 - r^2) - sqrt(c^2 - r^2)] (Johnson 7.43)."""
    result = mdr.solve(contact(), mdr.load(0.1) >> mdr.drag(0.02))
    a, c = last(result, "contact_radius"), last(result, "stick_radius")
    assert c / a == pytest.approx((1 - 0.02 / (MU * 0.1)) ** (1 / 3), rel=1e-13)
    r = a * np.linspace(0.0, 1.1, 45)
    inner = np.sqrt(np.maximum(c * c - r * r, 0.0))
    expected = 3 * MU * 0.1 / (2 * math.pi * a**3) * (np.sqrt(np.maximum(a * a - r * r, 0.0)) - inner)
    tau = result.field("shear_traction", r).values
    assert np.max(np.abs(tau - expected)) < 1e-13 * np.max(expected)


def test_tractions_of_a_cone():
    """mu E* tan / 2 [arcosh(a/r) - arcosh(c/r)]: ln(a/c) at the tip while it sticks, infinite while it slides."""
    case = contact(mdr.Cone(slope=0.1))
    result = mdr.solve(case, mdr.indent(0.01) >> mdr.Path(shift=[1e-3, 2e-3, 4e-3, 3e-3, -5e-3]))
    for step in (1, 2):
        a, c = float(result["contact_radius"][step]), float(result["stick_radius"][step])
        tau = result.field("shear_traction", [0.0, 1e-14, 1e-6 * a, 0.3 * a], step).values
        tip = MU * 0.05 * math.log(a / c)
        np.testing.assert_allclose(tau[:3], tip, rtol=1e-10)
        assert tau[3] == pytest.approx(
            MU * 0.05 * (math.acosh(1 / 0.3) - math.acosh(c / (0.3 * a))), rel=1e-12
        )
    tips = [float(result.field("shear_traction", 0.0, step)[0]) for step in (3, 4, 5)]
    assert tips == [math.inf, math.inf, -math.inf]


def test_tractions_at_a_sharp_edge():
    """A stuck cylinder: G* u_x / (pi sqrt(a^2 - r^2)), whose singularity turns with the shift."""
    swing = mdr.indent(0.05) >> mdr.cycle(shift=0.004, steps=8) >> mdr.shift(0.5) >> mdr.shift(0.499)
    for mu, profile in product((MU, math.inf), (mdr.FlatPunch(0.2), DOME)):
        result = mdr.solve(contact(profile, mu), swing >> mdr.ramp(indentation=0.07, shift=0.5))
        edge = 0.2 if isinstance(profile, mdr.FlatPunch) else 0.3
        tau = np.array([result.field("shear_traction", [0.1, edge, 1.1 * edge], i).values for i in range(12)])
        assert np.all(tau[:, 2] == 0.0)
        if isinstance(profile, mdr.FlatPunch):
            assert tau[:, 1].tolist() == [0.0, *[math.inf] * 3, 0.0, *[-math.inf] * 3, 0.0, *[math.inf] * 3]
            shift = column(result, "shift")[:9]
            np.testing.assert_allclose(
                tau[:9, 0], shift / (math.pi * math.sqrt(0.03)), rtol=1e-12, atol=1e-16
            )
            if mu == MU:
                assert float(result["slip_distance"][9]) == pytest.approx(0.5 - MU * 0.05, rel=1e-12)
                p = float(result.field("pressure", 0.1, 9)[0])
                assert tau[9, 0] == pytest.approx(MU * p, rel=1e-12)
        # a rounded end that is not pressed to its edge has no singularity
        assert not np.isnan(tau).any()


@pytest.mark.parametrize("name", ["edge", "function"])
def test_fields_do_not_know_what_comes_later(name):
    case = contact(PROFILES[name])
    rng = np.random.default_rng(13)
    d, u = rng.uniform(-0.02, 0.2, 24), rng.uniform(-0.05, 0.05, 24)
    legs = [mdr.Path(indentation=d[:10], shift=u[:10]), mdr.Path(indentation=d[10:], shift=u[10:])]
    whole = mdr.solve(case, legs[0] >> legs[1])
    r = np.array([0.0, 0.05, 0.15, 0.25, 0.4])
    for step in (-1, 10, 0, 3):  # not in order
        row = step % 24
        part = mdr.solve(case, mdr.Path(indentation=d[: row + 1], shift=u[: row + 1]))
        for field in (*FIELDS, "pressure", "spring_shift"):
            one, other = whole.field(field, r, step).values, part.field(field, r).values
            np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))
            finite = np.isfinite(one)
            # a callable is mapped anew, on other radii
            assert np.max(np.abs(one - other)[finite], initial=0.0) < 5e-13, field
    every = part.field("slip", r, None)
    assert every.dims == ("step", "r")
    np.testing.assert_array_equal(every.values[3], part.field("slip", r, 3).values)


# --- keep -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keep", "rows"), [(1, range(12)), (5, [4, 9]), ([7, 2, 7], [2, 7]), (np.array([-12, -3]), [0, 9])]
)
def test_kept_rows(keep, rows):
    rows = list(rows)
    path = mdr.indent(0.1, steps=4) >> mdr.cycle(shift=0.03, steps=8)
    whole, some = mdr.solve(contact(), path), mdr.solve(contact(), path, keep=keep)
    assert some["shift"].coords["row"].values.tolist() == rows
    xr.testing.assert_equal(whole.data.isel(step=rows), some.data.drop_vars("row"))
    assert all(claim.where.shape == (len(rows),) for claim in some.claims.values())
    assert all(claim.where.all() for claim in some.claims.values())
    frame = some.to_dataframe()
    assert frame["row"].tolist() == rows
    assert frame["tangential_force"].tolist() == column(whole, "tangential_force")[rows].tolist()
    assert f"{len(rows)} step" in some.summary()


@pytest.mark.parametrize("keep", [0, -1, 13, [], [12], [-13], 1.0, True, [1.5], [[1]], "2", [True, False]])
def test_refused_rows(keep):
    path = mdr.indent(0.1, steps=4) >> mdr.cycle(shift=0.03, steps=8)
    words = r"every k-th of 12 rows needs 1 <= k <= 12|there are 12 rows|whole number k \(every k-th row\) or rows"
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.solve(contact(), path, keep=keep)


def test_a_million_rows():
    """Only what is kept is stored: a sixtieth of the history, which is there anyway."""
    count = 1_000_000
    t = np.arange(1, count + 1) / count
    path = mdr.Path(indentation=0.1 + 0.02 * np.sin(300 * t), shift=0.03 * np.sin(1111 * t))
    mdr.solve(
        contact(), mdr.Path(indentation=[0.1, 0.2], shift=[0.0, 0.1])
    )  # modules and kernels are loaded once
    tracemalloc.start()
    result = mdr.solve(contact(), path, keep=1000)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert result.data.sizes["step"] == 1000
    assert result.data.nbytes < 120_000
    assert peak < 8 * count  # half of the two arrays of the path
    assert int(result.data["row"][-1]) == count - 1


def test_batch():
    path = mdr.load(0.02) >> mdr.cycle(shift=0.02, steps=8)
    cases = [contact(p, mu) for p, mu in ((BALL, 0.2), (DOME, math.inf), (SAMPLED, 0.0))]
    seen = []
    study = mdr.solve_batch(
        cases, path, workers=2, keep=3, progress=lambda done, total: seen.append((done, total))
    )
    assert seen == [(1, 3), (2, 3), (3, 3)]
    for case, result in zip(cases, study, strict=True):
        alone = mdr.solve(case, path, keep=3)
        assert (result.contact, result.path) == (case, path)
        assert result.starts == alone.starts
        xr.testing.assert_identical(result.data, alone.data)
        r = [0.0, 0.1]
        np.testing.assert_array_equal(result.field("slip", r).values, alone.field("slip", r).values)
    pulled = mdr.load(0.02) >> mdr.drag(0.005)
    quiet = mdr.solve_batch(cases[:2], pulled, workers=2, throw=False)
    assert isinstance(quiet[0], mdr.PathError)
    assert isinstance(quiet[1], mdr.Result)


def test_bands_of_scattered_samples():
    r = np.linspace(0.0, 1.2, 13)
    rough = mdr.Sampled(r, r * r / 2, scatter=1e-2 * r * r)  # not all alike: that would be an offset
    path = mdr.indent(0.1, steps=2) >> mdr.shift(0.01, steps=2)
    result = mdr.solve(contact(rough), path, keep=[1, 3])
    assert result.data["row"].values.tolist() == [1, 3]
    low, high = result.bands["tangential_force"]
    assert low[1] < column(result, "tangential_force")[1] < high[1]
    assert result.claims["tangential_force"].level is mdr.Level.APPROXIMATE


# --- claims ---------------------------------------------------------------------------------------------------


def assumption(result, name):
    return next(entry for entry in result.assumptions if entry.name == name)


def check_claims(result, normal, tangential, words):
    for name in (*NORMAL, "pressure", "normal_displacement", "gap"):
        assert result.claims[name].level is normal, name
    for name in (*TANGENTIAL, *ENERGIES, *FIELDS):
        assert result.claims[name].level is tangential, name
        assert words in result.claims[name].reason
        assert "Mindlin" in result.claims[name].source
    assert set(map(str, result.data)) - {"time"} <= set(result.claims)


def test_claims():
    exact, approximate = mdr.Level.EXACT, mdr.Level.APPROXIMATE
    path = mdr.indent("1 mm") >> mdr.shift("0.1 mm", steps=3)

    def solved(one, other=None, mu=MU):
        return mdr.solve(mdr.Contact(BALL, one, other or mdr.Rigid(), friction=mdr.Coulomb(mu)), path)

    zero, third, half = (mdr.Elastic("1 MPa", nu) for nu in (0.0, 0.3, 0.5))
    result = solved(zero, zero)
    check_claims(result, exact, exact, "exact for Poisson's ratio 0")
    assert assumption(result, "elastic similarity").met
    check_claims(solved(third, third), exact, approximate, "0.05 % of the largest mu F_N")
    check_claims(solved(half), exact, approximate, "(Poisson's ratio 0.5 here)")  # on a rigid body: similar
    for one, other, mu in ((third, None, MU), (zero, half, MU), (third, None, math.inf)):
        result = solved(one, other, mu)
        beta = mdr.effective_moduli(one, other).dundurs_beta
        check_claims(result, approximate, approximate, f"Dundurs' beta = {beta:.3g}")
        assert f"Dundurs' beta = {beta:.3g}" in result.claims["pressure"].reason
        computed = assumption(result, "elastic similarity")
        assert not computed.met
        assert computed.measure == pytest.approx(abs(beta), rel=1e-15)
        assert computed.limit == 0.01
    # without friction nothing couples pressure and shear, whatever the bodies are
    slides = solved(third, None, 0.0)
    check_claims(slides, exact, exact, "without friction there is no tangential load")
    assert assumption(slides, "elastic similarity").met
    assert "without friction" not in slides.claims["normal_force"].reason
    assert "frictionless" in slides.claims["normal_force"].reason
    assert slides.status is mdr.Status.COMPLETED
    assert any("memory diagrams" in entry for entry in slides.cite())
    assert re.search("elastic similarity: .* NOT MET", solved(third).summary())


def test_travel_is_claimed():
    result = mdr.solve(contact(), mdr.travel(0.2) >> mdr.shift(0.01), machine_stiffness=0.5)
    assert result.claims["travel"].level is mdr.Level.EXACT
    stiff = mdr.solve(contact(), mdr.travel(0.1) >> mdr.shift(0.01), machine_stiffness="inf")
    assert column(stiff, "travel").tolist() == column(stiff, "indentation").tolist() == [0.1, 0.1]
    assert "travel" not in mdr.solve(contact(), mdr.indent(0.1)).data


def test_assessment():
    path = mdr.load("2 N", steps=50) >> mdr.cycle(shift="20 um", cycles=3, steps=1200)
    case = contact(mdr.Paraboloid("10 mm"), body=SOFT)
    assessed = mdr.assess(case, path)
    result = mdr.solve(case, path)
    assert assessed.rows == 1250
    assert assessed.quantities == len(result.data) == 13
    assert assessed.memory == result.data.nbytes == 8 * 1250 * 13
    assert assessed.largest["normal_force"] == 2.0
    for name in ("indentation", "contact_radius"):
        assert assessed.largest[name] == pytest.approx(float(result[name].max()), rel=1e-13)
    for name, claim in result.claims.items():
        assert (assessed.claims[name].level, assessed.claims[name].reason) == (claim.level, claim.reason)
    assert [entry.name for entry in assessed.assumptions] == [entry.name for entry in result.assumptions]
    for one, other in zip(assessed.assumptions, result.assumptions, strict=True):
        assert one.measure == pytest.approx(other.measure, rel=1e-12)
    assert "1250 rows (130 kB)" in assessed.summary()
    # long arrays are read at their ends and extremes only
    t = np.linspace(0.0, 40.0, 200_001)[1:]
    long = mdr.Path(time=t, indentation=1e-5 * (2 + np.sin(t)), shift=2e-6 * np.cos(t))
    assessed = mdr.assess(case, long, machine_stiffness=1e5)
    assert assessed.rows == 200_000
    assert assessed.quantities == 15  # with time and travel
    assert "24 MB" in assessed.summary()
    assert assessed.largest["indentation"] == pytest.approx(3e-5, rel=1e-6)
    with pytest.raises(mdr.PathError, match="friction carries at most"):
        mdr.assess(case, mdr.load("1 N", steps=9) >> mdr.drag("0.31 N", steps=9))


# --- refusals -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [-0.1, "-0.1", -1e-300, math.nan, -math.inf, "nan", "rough", True, "0.3 N"])
def test_meaningless_coefficient(mu):
    with pytest.raises((mdr.ProblemError, mdr.UnitError), match=r"^coefficient"):
        mdr.Coulomb(mu)


PRESSED = mdr.load(0.1)
REFUSED = {
    "too much": (PRESSED >> mdr.drag(0.04, steps=4), r"= 40 mN in row 4 of leg 2: .* = 30 mN"),
    "too much, back": (PRESSED >> mdr.drag(-0.04), r"= -40 mN in row 1 .* at most mu F_N = 30 mN"),
    "held": (PRESSED >> mdr.drag(0.02) >> mdr.load(0.05, steps=10), r"= 20 mN in row 7 .* = 19\.5 mN"),
    "cycle": (PRESSED >> mdr.cycle(tangential_force=0.031, steps=8), r"= 31 mN in row 2 .* = 30 mN"),
    "array": (mdr.Path(normal_force=[1, 1], tangential_force=[0.1, 0.4]), r"= 400 mN in row 2 .* = 300 mN"),
    "by indentation": (mdr.indent(0.25) >> mdr.drag(1.0), r"= 1 N in row 1 .* mu F_N = 50 mN"),
    "no contact": (mdr.drag(1e-9), r"= 1 nN in row 1 .* mu F_N = 0 N"),
    "lifted": (mdr.indent(0.1) >> mdr.indent(-0.1) >> mdr.drag(0.01), r"= 10 mN in row 1 .* mu F_N = 0 N"),
    "unloaded": (PRESSED >> mdr.drag(0.01) >> mdr.load(0.0), r"= 10 mN .* mu F_N = 0 N"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_more_than_friction_carries(name):
    path, words = REFUSED[name]
    with pytest.raises(mdr.PathError, match=f"tangential_force {words} there; reduce it, or move"):
        mdr.solve(contact(), path)
    if name == "no contact":
        for mu in (0.0, math.inf):
            with pytest.raises(mdr.PathError, match=r"mu F_N = 0 N there"):
                mdr.solve(contact(mu=mu), path)


def test_the_limit_itself_is_carried():
    result = mdr.solve(contact(), mdr.load(0.1) >> mdr.drag(MU * 0.1))
    assert last(result, "stick_radius") == last(result, "slip_distance") == 0.0
    assert last(result, "shift") == pytest.approx(MU * float(result["indentation"][0]), rel=1e-10)


RING = mdr.Function(
    lambda r: r * r / 2 - 0.1 * np.sin(3 * r) ** 2, derivative=lambda r: r - 0.3 * np.sin(6 * r)
)
TENSION = "cannot be below 0 N; unload to 0 N, or lift off"
NO_DISK = "friction needs a contact that is a disk at every depth up to"
RADIUS = "a sphere cannot be pressed in by its radius, 1 m"
END = (
    r": the contact would pass r = 1\.2 m, the last radius at which the profile is known \(it is not extrapolated\); "
    r"the largest indentation that it allows is 1\.9929 m \(normal force 3\.36\d* N\): reduce the indentation"
)


@pytest.mark.parametrize(
    ("profile", "path", "words"),
    [
        (BALL, mdr.load(1.0) >> mdr.load(-1.0), f"normal_force = -1 N: .*{TENSION}"),
        (BALL, PRESSED >> mdr.cycle(normal_force=0.15), f"normal_force = -50 mN: .*{TENSION}"),
        (RING, mdr.indent(0.01) >> mdr.shift(0.001), NO_DISK),
        (RING, mdr.load(1e-3) >> mdr.shift(0.001), NO_DISK),
        (mdr.Sphere(1.0), mdr.indent(1.0), RADIUS),
        (mdr.Sphere(1.0), mdr.shift(0.1) >> mdr.indent(0.5, steps=2) >> mdr.indent(1.5), RADIUS),
        (SAMPLED, mdr.indent(3.0) >> mdr.shift(0.1), f"indentation = 3 m{END}"),
        (SAMPLED, mdr.indent(0.1) >> mdr.shift(0.1) >> mdr.load(100.0), f"normal_force = 100 N{END}"),
        (SAMPLED, mdr.indent(1.5) >> mdr.cycle(indentation=1.0), f"indentation = 2\\.5 m{END}"),
    ],
)
def test_what_cannot_be_pressed(profile, path, words):
    with pytest.raises(mdr.ProblemError if profile is RING else mdr.PathError, match=words):
        mdr.solve(contact(profile), path)


def test_tangential_paths_without_a_law():
    for path in (mdr.drag(0.1), mdr.cycle(shift=0.1)):
        with pytest.raises(mdr.PathError, match="the contact has no friction: add Contact"):
            mdr.solve(mdr.Contact(BALL, BODY, BODY), mdr.load(1.0) >> path)
    plain = mdr.solve(mdr.Contact(BALL, BODY, BODY), mdr.load(1.0))
    with pytest.raises(mdr.QuantityError, match="the contact has no friction; solve it with friction"):
        plain.field("slip")
    with pytest.raises(mdr.ProblemError, match=r"^friction = 0\.3: a law such as Coulomb"):
        mdr.Contact(BALL, BODY, BODY, friction=0.3)


def test_a_soft_machine_may_travel_by_more_than_the_radius():
    """What counts is the indentation, not the travel, most of which goes into the machine."""
    path = mdr.travel(2.0) >> mdr.shift(0.01)
    result = mdr.solve(contact(mdr.Sphere(1.0)), path, machine_stiffness=0.02)
    d = last(result, "indentation")
    assert 0.0 < d < 0.1
    direct = mdr.solve(contact(mdr.Sphere(1.0)), mdr.indent(d) >> mdr.shift(0.01))
    for name in TANGENTIAL:
        assert last(result, name) == pytest.approx(last(direct, name), rel=1e-12)
    r = [0.0, 0.1, 0.3]
    np.testing.assert_allclose(
        result.field("shear_traction", r).values, direct.field("shear_traction", r).values, rtol=1e-12
    )


def test_arrays():
    with pytest.raises(mdr.PathError, match="3 samples of indentation and 2 of shift; give equal numbers"):
        mdr.Path(indentation=[1.0, 2.0, 3.0], shift=[0.0, 1.0])
    for bad in (math.nan, math.inf):
        with pytest.raises(mdr.UnitError, match=r"^shift\[1\]: .* is not finite"):
            mdr.Path(indentation=[1.0, 2.0], shift=[0.0, bad])
    with pytest.raises(mdr.PathError, match="shift and tangential_force cannot both be prescribed"):
        mdr.Path(shift=[0.0], tangential_force=[0.0])


# --- files ----------------------------------------------------------------------------------------------------


def check_equal(one, other):
    xr.testing.assert_identical(one.data, other.data)
    assert one.contact == other.contact
    assert one.path == other.path
    for name in ("status", "notes", "references", "assumptions", "machine_stiffness", "starts", "rings"):
        assert getattr(one, name) == getattr(other, name), name
    assert one.claims.keys() == other.claims.keys()
    for name, claim in one.claims.items():
        mate = other.claims[name]
        assert (claim.level, claim.reason, claim.source) == (mate.level, mate.reason, mate.source)
        np.testing.assert_array_equal(claim.where, mate.where)
    assert one.summary() == other.summary()
    assert one.cite() == other.cite()


@pytest.mark.parametrize(("mu", "keep"), [(MU, None), (MU, [0, 150, -1]), (math.inf, 7)])
def test_saved_and_pickled(tmp_path, mu, keep):
    rng = np.random.default_rng(15)
    t = np.arange(1.0, 141.0)
    path = mdr.Path(time=t, indentation=rng.uniform(-0.02, 0.2, 140), shift=rng.uniform(-0.05, 0.05, 140))
    path = path >> mdr.load(0.05, duration=1.0) >> mdr.cycle(shift=0.01, steps=8, duration="2 s")
    path = path >> mdr.travel(0.2, steps=3, duration="1 s")
    result = mdr.solve(contact(mu=mu, body=SOFT), path, keep=keep, machine_stiffness=1e6)
    result.save(tmp_path / "rubbed.nc")
    r = np.linspace(0.0, 0.6, 11)
    for again in (mdr.open_result(tmp_path / "rubbed.nc"), pickle.loads(pickle.dumps(result))):
        check_equal(result, again)
        for field in (*FIELDS, "spring_shift", "pressure"):
            for step in (-1, 1):
                xr.testing.assert_identical(result.field(field, r, step), again.field(field, r, step))


@pytest.mark.parametrize("profile", [SAMPLED, WAVY + mdr.Cone(slope=0.1)])
def test_saved_profiles(tmp_path, profile):
    """Fields of rows that were kept and saved; a callable, mapped less far or saved, is an interpolant to 1e-11."""
    whole, some = (mdr.solve(contact(profile), TURNS, keep=keep) for keep in (None, [1, 6]))
    some.save(tmp_path / "rubbed.nc")
    opened, copied = mdr.open_result(tmp_path / "rubbed.nc"), pickle.loads(pickle.dumps(some))
    for again in (opened, copied):
        xr.testing.assert_identical(some.data, again.data)
        assert some.starts == again.starts
    r = np.linspace(0.0, 0.5, 6)
    for field, (step, row) in product((*FIELDS, "spring_shift"), enumerate((1, 6))):
        one = whole.field(field, r, row).values
        finite = np.isfinite(one)
        for again in (some, opened, copied):
            other = again.field(field, r, step).values
            np.testing.assert_array_equal(one[~finite], other[~finite])
            assert np.max(np.abs(one[finite] - other[finite])) <= 1e-11 * np.max(np.abs(one[finite])), field


BALL_JOINT = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3))


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda: mdr.Coulomb(1e-200), mdr.ProblemError, r"below 1e-30 .* use Coulomb\(0\)"),
        (
            lambda: mdr.Path(indentation=np.ma.array([1e-6, 2e-6], mask=[False, True]), shift=np.zeros(2)),
            mdr.UnitError,
            "some entries are masked",
        ),
        (
            lambda: mdr.friction_loop(BALL_JOINT, "1 um", indentation="2 mm"),
            mdr.PathError,
            "pressed in by its radius, 1 mm",
        ),
        (
            lambda: friction_foundation(BALL_JOINT, [3e-3], [0.0]),
            mdr.PathError,
            "pressed in by its radius, 1 mm",
        ),
        (
            lambda: mdr.solve(BALL_JOINT, mdr.load("1 N")).field("slip", step=1.0),
            mdr.QuantityError,
            "whole number from 0 to 0",
        ),
    ],
)
def test_what_used_to_pass_or_to_fail_without_words(make, kind, words):
    with pytest.raises(kind, match=words):
        make()
    assert math.copysign(1.0, mdr.Coulomb(-0.0).coefficient) == 1.0


def test_an_assessment_counts_the_rows_that_are_kept():
    path = mdr.load("1 N") >> mdr.cycle(shift="0.1 um", steps=400)
    assert (
        mdr.assess(BALL_JOINT, path, keep=10).rows == mdr.solve(BALL_JOINT, path, keep=10).data.sizes["step"]
    )


# --- what lies between rows ------------------------------------------------------------------------------------


STEEL = mdr.Elastic("210 GPa", 0.0)
STEEL_BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))


@settings(max_examples=examples(15), deadline=None)
@given(
    loads=st.lists(st.floats(0.5, 50.0), min_size=2, max_size=4),
    shifts=st.lists(st.floats(-0.6, 0.6), min_size=4, max_size=4),
    machine=st.sampled_from([None, 1e7]),
)
@example(loads=[11.0, 26.0], shifts=[0.17578125, 0.0, 0.0, 0.0], machine=None)
def test_a_shift_under_a_load_follows_both_between_rows(loads, shifts, machine):
    """Against rows in (indentation, shift) that are 24,000 times closer, by the closed form of the load."""
    radius, modulus = 10e-3, mdr.effective_moduli(STEEL, STEEL).normal

    def load(d):
        return 4 / 3 * modulus * np.sqrt(radius * d**3)

    def depth(force):
        return (force / (4 / 3 * modulus * math.sqrt(radius))) ** (2 / 3)

    shifts = 1e-6 * np.array(shifts[: len(loads)])
    ends = np.array(loads) if machine is None else depth(np.array(loads)) + np.array(loads) / machine
    name = "normal_force" if machine is None else "travel"
    result = mdr.solve(STEEL_BALL, mdr.Path(**{name: ends, "shift": shifts}), machine_stiffness=machine)
    closer = 24_000  # which err by 6e-7 of what is dissipated
    part = np.linspace(0.0, 1.0, closer + 1)[1:]
    # short parts where the first touch is
    parts = [part**3, *(part for _ in ends[1:])]
    positions = np.concatenate(
        [a + (b - a) * p for p, (a, b) in zip(parts, pairwise([0.0, *ends]), strict=True)]
    )
    if machine is not None:
        travels, low, high = positions, np.zeros(positions.size), positions
        for _ in range(60):
            positions = 0.5 * (low + high)
            above = positions + load(positions) / machine > travels
            low, high = np.where(above, low, positions), np.where(above, positions, high)
    else:
        positions = depth(positions)
    moved = np.concatenate(
        [a + (b - a) * p for p, (a, b) in zip(parts, pairwise([0.0, *shifts]), strict=True)]
    )
    close = mdr.solve(STEEL_BALL, mdr.Path(indentation=positions, shift=moved))
    for quantity in ("tangential_force", "dissipated_energy", "slip_distance"):
        expected = close[quantity].values[closer - 1 :: closer]
        size = max(np.max(np.abs(close[quantity].values)), 1e-12)
        assert result[quantity].values == pytest.approx(expected, abs=3e-6 * size), quantity
    r = np.linspace(0.0, 0.9, 5) * float(result["contact_radius"][-1])
    assert result.field("shear_traction", r).values == pytest.approx(
        close.field("shear_traction", r).values, abs=1e-4 * 0.3 * float(close.field("pressure", [0.0])[0])
    )


@settings(max_examples=examples(15), deadline=None)
@given(
    force=st.floats(1.0, 50.0),
    moved=st.floats(0.05, 0.5),
    channel=st.sampled_from(["normal_force", "travel"]),
    steps=st.integers(2, 300),
)
def test_a_shift_under_a_load_does_not_depend_on_the_rows(force, moved, channel, steps):
    value = force if channel == "normal_force" else 0.1e-6 * force

    def at_end(steps, keep=None):
        path = mdr.load("1 N") >> mdr.ramp(**{channel: value}, shift=moved * 1e-6, steps=steps)
        return mdr.solve(STEEL_BALL, path, keep=keep, machine_stiffness=1e7)

    one, many, thinned = at_end(1), at_end(steps), at_end(steps, [-1])
    for name in ("tangential_force", "shift", "dissipated_energy", "stored_tangential_energy"):
        assert last(one, name) == pytest.approx(last(many, name), rel=1e-7, abs=1e-18), name
        assert last(thinned, name) == last(many, name)
    tau = [x.field("shear_traction", r="20 um").values for x in (one, many, thinned)]
    assert tau[0] == pytest.approx(tau[1], rel=1e-5)
    assert tau[2].tolist() == tau[1].tolist()
    claim = one.claims["tangential_force"]
    assert claim.level is mdr.Level.EXACT or np.all(claim.error < 1e-8)


@settings(max_examples=examples(10), deadline=None)
@given(
    load=st.floats(0.5, 50.0),
    shifts=st.lists(st.floats(-0.6, 0.6), min_size=3, max_size=30),
    size=st.sampled_from([1e-6, 1.0]),
)
def test_a_shift_under_a_constant_load_is_exact_but_for_its_first_row(load, shifts, size):
    """Only the row that brings the load moves both channels: it is followed between, and the others as after any other way there."""
    joint = mdr.Contact(mdr.Paraboloid(10e-3 * size), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    u, force = 1e-6 * size * np.array(shifts), load * size**2
    at_once = mdr.solve(joint, mdr.Path(normal_force=np.full(u.size, force), shift=u))
    oblique = mdr.solve(joint, mdr.Path(normal_force=[force], shift=u[:1]) >> mdr.Path(shift=u[1:]))
    for name in ("tangential_force", "dissipated_energy", "stick_radius"):
        values, others = at_once[name].values, oblique[name].values
        assert values == pytest.approx(others, rel=1e-8, abs=1e-12 * np.abs(others).max())
    error = at_once.claims["tangential_force"].error
    assert error is None or np.max(error * np.abs(at_once["tangential_force"].values)) <= 1e-8 * 0.3 * force


@pytest.mark.parametrize("seed", range(4))
def test_errors_of_a_profile_propagate_to_its_friction(seed):
    """Heights that lose digits to an offset: what normal contact claims to miss, friction misses too."""
    rng = np.random.default_rng([25, seed])
    radius, exponent = 10.0 ** rng.uniform(-9.0, 0.0), rng.uniform(1.5, 3.0)
    offset = radius * 10.0 ** rng.uniform(1.0, 3.0)
    steel = mdr.Elastic("210 GPa", 0.0)
    depth, mu = radius * 10.0 ** rng.uniform(-3.0, -1.0), rng.uniform(0.1, 1.0)
    path = mdr.indent(depth) >> mdr.Path(shift=mu * depth * rng.uniform(-1.5, 1.5, 6))
    exact, blurred = (
        mdr.solve(mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(mu)), path)
        for profile in (
            mdr.PowerLaw(exponent=exponent, height=radius, radius=radius),
            mdr.Function(lambda r: (offset + radius * (r / radius) ** exponent) - offset),
        )
    )
    plain = mdr.solve(mdr.Contact(blurred.contact.profile, steel, steel), mdr.indent(depth))
    known = float(plain.claims["normal_force"].error[0])
    assert known > 0.0
    assert blurred.claims["normal_force"].error[0] == known
    for name in (
        "tangential_force",
        "stick_radius",
        "dissipated_energy",
        "stored_tangential_energy",
        "slip_distance",
    ):
        error, truth = blurred.claims[name].error, exact[name].values
        moves = truth != 0.0
        miss = np.abs(blurred[name].values[moves] / truth[moves] - 1.0)
        assert np.all(miss <= 10.0 * error[moves] + 1e-12), name
        if name == "tangential_force":
            assert np.all(error[moves] >= known)


def test_the_frame_of_cattaneo_and_mindlin_is_in_the_error_of_the_force():
    path = mdr.load("50 N") >> mdr.cycle(shift="1 um", cycles=1, steps=8) >> mdr.drag("1 N")
    for poisson, fraction in ((0.0, 0.0), (0.15, 0.75e-3), (0.3, 1.5e-3), (0.5, 5e-3)):
        steel = mdr.Elastic("210 GPa", poisson)
        result = mdr.solve(mdr.Contact(BALL, steel, steel, friction=mdr.Coulomb(0.3)), path)
        force, claim = result["tangential_force"].values, result.claims["tangential_force"]
        # the first row has no shift yet, and the force of the last one is prescribed
        assert claim.error[[0, -1]].tolist() == [0.0, 0.0]
        missed = claim.error[1:-1] * np.abs(force[1:-1])
        assert missed[claim.error[1:-1] < 1.0] == pytest.approx(fraction * 0.3 * 50.0, rel=1e-12)
    unlike = mdr.Contact(BALL, steel, mdr.Elastic("1 GPa", 0.3), friction=mdr.Coulomb(0.3))
    assert mdr.solve(unlike, path).claims["tangential_force"].error is None
