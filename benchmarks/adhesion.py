"""Paths on folding adhesive curves against np.interp, JKR forces and pull-off against loops over brentq."""

from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

import pymdr as mdr
from benchmarks.timing import Ratio, compare, median_times
from pymdr.line.adhesion import JKR, PullOff, jkr_force, power_law_factor, power_law_pull_off
from pymdr.line.curves import ElasticLine
from pymdr.line.following import Track, energy_balance, follow, trace, under_machine
from pymdr.mapping.equivalent import equivalent_profile

Floats = NDArray[np.float64]
STEPS, INSTABILITIES = 100_000, 50
WAVE_NUMBER, WAVE_HEIGHT, WORK = 400.0, 2e-4, 1e-4
TOP, SEPARATED, MAX_RADIUS = 1.0, -0.1, 1.2
LOADING = np.linspace(SEPARATED, TOP, STEPS // 2)
PATH = np.concatenate([LOADING, LOADING[::-1]])


def require(holds: object, what: str) -> None:
    """Stop a benchmark that does not do what it says."""
    if not holds:
        raise RuntimeError(what)


def wavy() -> mdr.Function:
    """Guduru's profile r^2/2 + h (1 - cos kr), new, so that nothing of it is remembered."""
    k, h = WAVE_NUMBER, WAVE_HEIGHT
    return mdr.Function(
        lambda r: 0.5 * r * r + h * (1.0 - np.cos(k * r)), derivative=lambda r: r + h * k * np.sin(k * r)
    )


@cache
def law() -> JKR:
    """JKR on the mapped profile, in units of E* = R = 1."""
    return JKR(ElasticLine(equivalent_profile(wavy()), 1.0), WORK)


def traced() -> Track:
    """All branches and jumps under displacement control."""
    return trace(under_machine(law(), MAX_RADIUS))


def following() -> Iterator[Ratio]:
    track = traced()
    history = follow(track, PATH)
    instabilities = np.count_nonzero(history.jumped)
    jumps = np.count_nonzero(history.jumped[: LOADING.size])
    require(jumps >= INSTABILITIES, f"the loading meets only {jumps} instabilities")
    states = law().states(history.parameter[history.attached])
    error = np.max(np.abs(states.indentation - PATH[history.attached])) / TOP
    require(error <= 1e-10, f"states are off the curve by {error:.0e}")

    known = np.linspace(SEPARATED, TOP, 1000)
    values = known**2

    def everything() -> object:
        visited = follow(track, PATH)
        return law().states(visited.parameter), energy_balance(track, visited)

    def interpolated() -> Floats:
        return np.asarray(np.interp(PATH, known, values))

    against = f"np.interp of {STEPS} points"
    what = f"follow {STEPS} steps over {instabilities} instabilities"
    off = f"off the curve by {error:.0e} of the depth"
    yield compare(what, lambda: follow(track, PATH), against, interpolated, "aim 20", off)
    yield compare(
        "the same with radii, forces, energies and work", everything, against, interpolated, "no aim"
    )
    map_time, per_path, trace_time = median_times(
        lambda: equivalent_profile(wavy()).squared(np.array(MAX_RADIUS)), lambda: follow(track, PATH), traced
    )
    once = "following the path once"
    waves = f"{MAX_RADIUS * WAVE_NUMBER / (2 * np.pi):.0f} waves"
    yield Ratio(f"in addition, once: the map of {waves}", once, map_time, per_path, "no aim")
    branches = f"{track.low.size} branches and {track.turning.size - 2} folds"
    yield Ratio(f"in addition, once: {branches} of the JKR curve", once, trace_time, per_path, "no aim")


def balls(n: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Depths from the snap-off to a thousand times deeper, radii, moduli and works over decades."""
    rng = np.random.default_rng(7)
    R, E, gamma = 10.0 ** rng.uniform([[-7], [3], [-3]], [[-2], [11], [0]], (3, n))
    scale = np.cbrt(np.pi * gamma * R * R / (8.0 * E))
    reduced = np.where(rng.random(n) < 0.5, rng.uniform(-2.999, 3.0, n), 10.0 ** rng.uniform(0.5, 3.5, n))
    return reduced * scale**2 / R, R, E, gamma


def exact_force(sets: tuple[Floats, ...]) -> NDArray[np.longdouble]:
    """The force in extended precision: Newton's method for y^4 - 4y = dR/L^2 from above."""
    d, R, E, gamma = (x.astype(np.longdouble) for x in sets)
    pi = 4 * np.arctan(np.longdouble(1))
    scale = (pi * gamma * R * R / (8 * E)) ** (np.longdouble(1) / 3)
    reduced = d * R / scale**2
    y = np.maximum(np.longdouble(2), 2 * np.maximum(reduced, 0) ** np.longdouble(0.25))
    for _ in range(60):
        y = y - (y**4 - 4 * y - reduced) / (4 * (y**3 - 1))
    force: NDArray[np.longdouble] = pi * gamma * R * (y**6 / 6 - y**3)
    return force


def brentq_force(d: float, R: float, E: float, gamma: float) -> float:
    """What scripts do: the radius on the stable branch by brentq, then the force."""
    opening = 2.0 * np.pi * gamma / E
    low = (opening * R * R / 16.0) ** (1.0 / 3.0)
    high = 3.0 * low + np.sqrt(2.0 * R * max(d, 0.0))
    a = brentq(lambda a: a * a / R - np.sqrt(opening * a) - d, low, high, xtol=1e-15 * low)
    return float(4.0 * E * a**3 / (3.0 * R) - np.sqrt(8.0 * np.pi * E * gamma * a**3))


def forces() -> Iterator[Ratio]:
    n, few = 1_000_000, 2_000
    sets = balls(n)
    ours = jkr_force(*sets)
    exact = exact_force(sets)
    size = np.maximum(np.abs(exact), np.pi * sets[3] * sets[1])
    error = float(np.max(np.abs(ours - exact) / size))
    require(error <= 1e-12, f"forces err by {error:.0e} of the larger of |F| and pi gamma R")

    def loop() -> Floats:
        return np.array([brentq_force(*row) for row in zip(*(x[:few].tolist() for x in sets), strict=True)])

    require(np.max(np.abs(loop() - ours[:few]) / size[:few]) <= 1e-9, "brentq finds other forces")
    time, one, some = median_times(
        lambda: jkr_force(*sets), lambda: jkr_force(sets[0], 1e-6, 1e9, 0.05), loop
    )
    other = some * n / few
    for what, seconds in (("arrays of d, R, E*, work", time), ("an array of d", one)):
        yield Ratio(
            f"{n} JKR forces, {what}",
            f"brentq, scaled from {few}",
            seconds,
            other,
            "aim 5e6 per second, error 1e-12",
            f"{n / seconds:.2g} per second, by brentq {n / other:.2g}; error {error:.0e}",
        )


def brentq_pull_off(
    n: float, coefficient: float, E: float, gamma: float, k: float
) -> tuple[float, float, float]:
    """The minimum of D = d + F/k over the radius: a root of dD/da, then d and F."""
    kc, opening = float(power_law_factor(n)) * coefficient, 2.0 * np.pi * gamma / E

    def slope(u: float) -> float:
        a = np.exp(u)
        rise, stretch = n * kc * a**n, np.sqrt(opening * a)
        return float((rise - 0.5 * stretch) / (2.0 * E * a) + (rise - 1.5 * stretch) / k)

    middle = np.log(opening / (n * kc) ** 2) / (2.0 * n - 1.0)
    a = np.exp(brentq(slope, middle - 3.0, middle + 3.0, xtol=1e-14))
    stretch = np.sqrt(opening * a)
    return a, kc * a**n - stretch, 2.0 * E * a * (n / (n + 1.0) * kc * a**n - stretch)


def pull_off() -> Iterator[Ratio]:
    n, few = 100_000, 1_000
    rng = np.random.default_rng(3)
    exponent = rng.uniform(1.0, 5.0, n)
    E, gamma = 10.0 ** rng.uniform([[3], [-3]], [[11], [0]], (2, n))
    c = 10.0 ** rng.uniform(-1.0, 1.0, n) * 1e-6 ** (1.0 - exponent)
    stiff = power_law_pull_off(exponent, c, E, gamma)
    k = 10.0 ** rng.uniform(-2.0, 2.0, n) * 2.0 * E * stiff.contact_radius
    for control, machine in (("on machines of any stiffness", k), ("under displacement control", np.inf)):
        stiffness = np.broadcast_to(machine, n)

        def ours(machine: ArrayLike = machine) -> PullOff:
            return power_law_pull_off(exponent, c, E, gamma, machine)

        def loop(stiffness: Floats = stiffness) -> Floats:
            columns = (x[:few].tolist() for x in (exponent, c, E, gamma, stiffness))
            return np.array([brentq_pull_off(*row) for row in zip(*columns, strict=True)]).T

        result = ours()
        a, _, F = loop()
        error = max(
            float(np.max(np.abs(x[:few] / y - 1.0)))
            for x, y in ((result.contact_radius, a), (result.normal_force, F))
        )
        require(error <= 1e-9, f"pull-off differs from brentq by {error:.0e}")
        time, some = median_times(ours, loop)
        yield Ratio(
            f"pull-off of {n} power laws {control}",
            f"brentq for the fold, scaled from {few}",
            time,
            some * n / few,
            "no loop; no number set",
            f"differ by {error:.0e}",
        )


def ratios() -> Iterator[Ratio]:
    yield from forces()
    yield from pull_off()
    yield from following()
