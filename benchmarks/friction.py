"""The memory stack over vibrations and random walks against np.cumsum and against a thousand springs."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
from numpy.typing import NDArray

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.independent.wear import wear_by_rings
from pymdr.line.foundation import ElasticLine, states_at_depth
from pymdr.line.friction import (
    ElasticCurves,
    Ending,
    FrictionHistory,
    SpringHistory,
    follow_displacements,
    power_law_curves,
    springs,
    tabulated_curves,
)
from pymdr.line.plane import PlaneLaw, Springs, follow_plane, virgin_plane
from pymdr.mapping.equivalent import EquivalentProfile, equivalent_profile

Floats = NDArray[np.float64]
STEPS = 1_000_000
DEEPEST, FRICTION, MODULUS, TANGENTIAL = 1.0, 0.5, 1.0, 0.8
STRIDES = {"short": 1e-3, "middling": 1e-2, "long": 1e-1}
"""Standard deviations of one step of the walks, in units of the largest depth."""
WAVY = mdr.Function(
    lambda r: 0.5 * r * r + 0.01 * (1.0 - np.cos(6.0 * r)), derivative=lambda r: r + 0.06 * np.sin(6.0 * r)
)


def walk(stride: float, n: int = STEPS) -> tuple[Floats, Floats]:
    """Random walks of the indentation, reflected at 0.05 and 1 of the largest, and of the shift, at -1 and 1."""
    steps = stride * np.random.default_rng(5).standard_normal((2, n))
    d, u = np.cumsum(steps, axis=1)
    return _reflected(d + 0.5, 0.05, DEEPEST), _reflected(u, -1.0, 1.0)


def histories() -> Iterator[tuple[str, tuple[Floats, Floats]]]:
    """A vibration that beats with the load, sampled 200 times a cycle with noise, and random walks."""
    cycle = 2.0 * np.pi / 200.0 * np.arange(STEPS)
    noise = 1e-3 * np.random.default_rng(6).standard_normal((2, STEPS))
    yield "a vibration", (0.5 + 0.3 * np.sin(0.618 * cycle) + noise[0], 0.4 * np.sin(cycle) + noise[1])
    for stride, size in STRIDES.items():
        yield f"a walk of {stride} steps", walk(size)


def _reflected(values: Floats, low: float, high: float) -> Floats:
    folded = np.mod(values - low, 2.0 * (high - low))
    reflected: Floats = low + np.minimum(folded, 2.0 * (high - low) - folded)
    return reflected


def lines() -> dict[str, tuple[ElasticCurves, EquivalentProfile]]:
    """A paraboloid in closed form and a wavy callable as a table, up to a little above the largest depth."""
    ball = equivalent_profile(mdr.Paraboloid(1.0))
    wavy = equivalent_profile(WAVY)
    line = ElasticLine(wavy, MODULUS)
    table = tabulated_curves(lambda d: states_at_depth(line, d).contact_radius, DEEPEST, MODULUS)
    return {"Hertz": (power_law_curves(2.0, 1.0, MODULUS), ball), "a wavy callable": (table, wavy)}


def stack(curves: ElasticCurves, path: tuple[Floats, Floats]) -> FrictionHistory:
    """Force, stick radius and both energies of every step."""
    return follow_displacements(curves, *path, FRICTION, TANGENTIAL)


def springs_over(equivalent: EquivalentProfile, path: tuple[Floats, Floats], n: int) -> SpringHistory:
    """The teaching form with n springs: the same quantities at every step."""
    dx = float(equivalent.inverse(DEEPEST)) / n
    profile = equivalent.g(dx * (np.arange(n) + 0.5))
    return springs(profile, dx, *path, FRICTION, MODULUS, TANGENTIAL)


def per_step() -> Iterator[Ratio]:
    few, n = 20_000, 1000
    values = np.random.default_rng(1).standard_normal(STEPS)
    for kind, path in histories():
        short_path = (path[0][:few], path[1][:few])
        for name, (curves, equivalent) in lines().items():
            run = stack(curves, path)
            if run.ending is not Ending.COMPLETE:
                raise RuntimeError(f"the stack stopped at row {run.stopped}: {run.ending}")
            off = springs_over(equivalent, short_path, n).tangential_force - run.tangential_force[:few]
            error = float(np.max(np.abs(off)) / np.max(np.abs(run.tangential_force[:few])))
            if error > 1e-3:
                raise RuntimeError(f"the springs are off the stack by {error:.1g}")
            ours, cumsum, some = median_times(
                partial(stack, curves, path),
                partial(np.cumsum, values),
                partial(springs_over, equivalent, short_path, n),
            )
            what, note = f"{STEPS:.0e} rows of {kind} on {name}", f"{ours / STEPS * 1e9:.0f} ns a row"
            yield Ratio(what, f"np.cumsum of {STEPS:.0e}", ours, cumsum, "aim 15 times as long", note)
            against = f"{n} springs in numba, scaled from {few} rows"
            yield Ratio(what, against, ours, some * STEPS / few, "aim 50", f"off by {error:.0e}")


def flatness() -> Iterator[Ratio]:
    d, u = walk(STRIDES["middling"])
    sizes = (10_000, 100_000, STEPS)
    for name, (curves, _) in lines().items():
        times = median_times(*(partial(stack, curves, (d[:n], u[:n])) for n in sizes))
        step = {n: time / n for n, time in zip(sizes, times, strict=True)}
        table = ", ".join(f"{value * 1e9:.0f}" for value in step.values())
        yield Ratio(
            f"one step of {STEPS:.0e} on {name}",
            "one step of 1e4",
            step[STEPS],
            step[10_000],
            "aim 1: flat",
            f"ns a step at 1e4, 1e5 and 1e6 steps: {table}",
        )


def tables() -> Iterator[Ratio]:
    """
    Rows on the table of a paraboloid, and on one with the kinks of a measured tip, against the closed form.

    A row with kinks looks up a segment among 300 and reads the 28 numbers of a panel from memory where the closed form takes one
    square root: 1.4 to 1.6 times its time.
    """
    rng = np.random.default_rng(7)
    marks = np.sort(rng.uniform(1e-3, DEEPEST, 300))
    rises = rng.uniform(0.0, 1e-2, marks.size)
    slope, shift = (np.append(0.0, np.cumsum(x)) for x in (rises, rises * marks))

    def kinked(d: Floats) -> Floats:
        above = np.searchsorted(marks, d)
        radius: Floats = np.sqrt(d) + d * slope[above] - shift[above]
        return radius

    curves = {
        "a table of Hertz": tabulated_curves(np.sqrt, DEEPEST, MODULUS),
        "a table with 300 kinks": tabulated_curves(kinked, DEEPEST, MODULUS, marks=marks),
    }
    closed = power_law_curves(2.0, 1.0, MODULUS)
    for kind, path in histories():
        times = median_times(*(partial(stack, c, path) for c in (*curves.values(), closed)))
        for name, time_of in zip(curves, times, strict=False):
            what, note = f"{STEPS:.0e} rows of {kind} on {name}", f"{time_of / STEPS * 1e9:.0f} ns a row"
            yield Ratio(what, "the closed form", time_of, times[-1], "aim 1.6 times as long", note)
    targets: list[Floats] = []

    def sphere(d: Floats) -> Floats:
        targets.append(d)
        return np.sqrt(d * (2.0 - d))

    tabulated_curves(sphere, 0.9, MODULUS)
    count = sum(d.size for d in targets)
    (build,) = median_times(partial(tabulated_curves, lambda d: np.sqrt(d * (2.0 - d)), 0.9, MODULUS))
    yield Ratio(
        "the table of a sphere",
        "its radii at 1 us each",
        build,
        1e-6 * count,
        "aim 30 ms together",
        f"{count} radii",
    )


def batch() -> Iterator[Ratio]:
    """1000 contacts by 1e4 steps, with one process and with two, and what two processes gain here at all."""
    d, u = walk(STRIDES["middling"], 10_000)
    path = mdr.Path(indentation=1e-5 * d, shift=1e-6 * u)
    steel = mdr.Elastic("200 GPa", 0.3)
    contacts = [
        mdr.Contact(mdr.Paraboloid(R), steel, friction=mdr.Coulomb(0.3))
        for R in np.geomspace(1e-3, 1e-1, 1000)
    ]
    mdr.solve(contacts[0], path)
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_busy, (1, 1)))
        one, two = (_timed(partial(_all, pool, n)) for n in (1, 2))
    gain = f"two empty loops gain {2.0 * one / two:.2f}"
    for keep, what in ((None, "all rows kept"), (100, "every 100th row kept")):
        alone, together = (
            _timed(partial(mdr.solve_batch, contacts, path, workers=workers, keep=keep)) for workers in (1, 2)
        )
        yield Ratio(
            f"solve_batch of 1000 contacts by 1e4 steps, {what}, workers=2",
            "workers=1",
            together,
            alone,
            "aim: both cores",
            gain,
        )
    sticky = [
        mdr.Contact(each.profile, mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
        for each in contacts[:300]
    ]
    there = mdr.indent("1 um", steps=100) >> mdr.indent("-5 um", steps=100)
    mdr.solve(sticky[0], there)
    alone, together = (_timed(partial(mdr.solve_batch, sticky, there, workers=workers)) for workers in (1, 2))
    yield Ratio(
        "solve_batch of 300 adhesive contacts, workers=2",
        "workers=1",
        together,
        alone,
        "aim: both cores",
        gain,
    )


def _all(pool: ProcessPoolExecutor, n: int) -> list[int]:
    return list(pool.map(_busy, (4_000_000,) * n))


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _busy(count: int) -> int:
    total = 0
    for i in range(count):
        total += i
    return total


def by_force() -> Iterator[Ratio]:
    """A shift under a constant load from the first row on, against a load before the shift."""
    steel = mdr.Elastic("200 GPa", 0.3)
    joint = mdr.Contact(mdr.Paraboloid("5 mm"), steel, friction=mdr.Coulomb(0.3))
    for rows in (10_000, 100_000):
        u = 0.5e-6 * np.sin(0.05 * np.arange(1.0, rows + 1.0))
        both, after = (
            mdr.Path(normal_force=np.full(rows, 10.0), shift=u),
            mdr.load("10 N") >> mdr.Path(shift=u),
        )
        ours, other = median_times(*(partial(mdr.solve, joint, path) for path in (both, after)))
        yield Ratio(
            f"{rows:.0e} rows of a shift under a constant load",
            "load >> shift",
            ours,
            other,
            "aim 2 times as long",
        )


def numpy_springs(u: Floats, label: Floats, limit: float) -> Floats:
    """Sum of vector springs at constant depth by one return map a row, in NumPy over all springs."""
    most = limit * (1.0 - label)
    t, sums, before = np.zeros((2, label.size)), np.empty_like(u), np.zeros(2)
    for row, here in enumerate(u):
        t += (here - before)[:, None]
        t *= np.minimum(1.0, most / np.maximum(np.hypot(t[0], t[1]), 1e-300))
        sums[row], before = t.sum(axis=1), here
    return sums


def plane() -> Iterator[Ratio]:
    """1e5 rows of circles: the springs alone, against as many in NumPy, and all of `solve`."""
    few, rows, n = 5_000, 100_000, 192
    line = ElasticLine(equivalent_profile(mdr.Paraboloid(1.0)), MODULUS)
    law, some = PlaneLaw(FRICTION, MODULUS, MODULUS), Springs.along(line, 1.0, n)
    angle = 2.0 * np.pi / 256.0 * np.arange(rows)
    u = 0.5 * FRICTION * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    one = np.ones(rows)
    steel = mdr.Elastic("200 GPa", 0.3)
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    path = mdr.load("50 N") >> mdr.circle(shift="0.4 um", turns=rows / 256, steps=rows)
    ours, whole, loop = median_times(
        partial(follow_plane, law, some, one, one, u, virgin_plane(some)),
        partial(mdr.solve, joint, path),
        partial(numpy_springs, u[:few], some.label[1:], FRICTION),
    )
    against = f"{n} springs in NumPy by return maps, scaled from {few} rows"
    yield Ratio(f"1e5 rows of a circle by {n} springs", against, ours, loop * rows / few, "aim 0.5 s")
    yield Ratio("the same through solve, to 1e-4", against, whole, loop * rows / few, "aim 0.5 s")


def worn() -> Iterator[Ratio]:
    """1e6 cycles of wear of a ball to 1e-3 of the volume, against rings solved again after 120 blocks."""
    steel = mdr.Elastic("210 GPa", 0.0)
    ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.5))
    moduli = mdr.effective_moduli(steel, steel)
    cycle = mdr.indent("1 um") >> mdr.cycle(shift="0.2 um")
    method = partial(mdr.wear, ball, cycle, coefficient=1e-14, cycles=1e6)
    rings = partial(
        wear_by_rings,
        np.linspace(0.0, 1.45e-4, 121),
        lambda r: 0.5 * r**2 / 10e-3,
        (moduli.normal, moduli.tangential, 0.5),
        (1e-6, None),
        0.2e-6,
        1e-14,
        np.geomspace(1e1, 1e6, 120),
    )
    study, other = method(), rings()
    off = abs(float(study["worn_volume"][-1]) / float(other.volume[-1]) - 1.0)
    if off > 5e-2:  # the stick radius of rings is that of whole rings
        raise RuntimeError(f"wear is off the rings by {off:.1g}")
    ours, theirs = median_times(method, rings)
    against = "120 rings and 120 implicit Euler blocks"
    yield Ratio("1e6 cycles of wear", against, ours, theirs, "aim 1 s", f"off by {off:.0e}")


def lubkin_springs(twist: Floats, limit: Floats, x: Floats, shear: float) -> Floats:
    """Torque over rows of twist at constant load, by springs at x that stick with dQ = 8 G dphi and slip at Q_max."""
    q, arms = np.zeros(x.size), 2.0 * x * x * (x[1] - x[0])
    torque = np.empty(twist.size)
    for row, change in enumerate(np.diff(twist, prepend=0.0)):
        q = np.clip(q + 8.0 * shear * change, -limit, limit)
        torque[row] = arms @ q
    return torque


def torsion() -> Iterator[Ratio]:
    """Cycles of twist of a ball at constant load, against springs whose Q_max is the integral of Hertz' pressure along cosh."""
    rows, n, mu, force = 192, 1000, 0.3, 10.0
    steel = mdr.Elastic("210 GPa", 0.3)
    ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(mu))
    path = mdr.load(force) >> mdr.cycle(twist="5 mrad", cycles=8, steps=rows)
    result = mdr.solve(ball, path)
    a = float(result["contact_radius"][0])
    x = a * (np.arange(n) + 0.5) / n
    node, weight = np.polynomial.legendre.leggauss(40)
    part = (node + 1.0) / 2.0
    most = np.arccosh(a / x)[:, None]
    p = 1.5 * force / (np.pi * a**2) * np.sqrt(1.0 - (x[:, None] / a * np.cosh(most * (1.0 - part**2))) ** 2)
    limit = 4.0 * mu * np.sum(most * part * weight * p, axis=1)
    twist, torque = result["twist"].values[1:], result["torque"].values[1:]
    plain = partial(lubkin_springs, twist, limit, x, steel.shear / 2.0)
    off = float(np.max(np.abs(plain() - torque)) / np.max(torque))
    if off > 1e-5:
        raise RuntimeError(f"torsion is off the springs by {off:.1g}")
    ours, theirs = median_times(partial(mdr.solve, ball, path), plain)
    yield Ratio(
        f"{rows} rows of torsion at constant load",
        f"{n} springs in NumPy without fields, energies and claims",
        ours,
        theirs,
        "aim 1 ms a row",
        f"{ours / rows * 1e3:.2f} ms a row, off by {off:.0e}",
    )


def ratios() -> Iterator[Ratio]:
    yield from by_force()
    yield from plane()
    yield from worn()
    yield from torsion()
    yield from per_step()
    yield from flatness()
    yield from tables()
    yield from batch()
