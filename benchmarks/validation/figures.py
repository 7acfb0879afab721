"""Figures of docs/validation.md: curves over their closed solutions, and errors of random problems over their claims."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

import pymdr as mdr
from benchmarks.validation.rows import UNIT

matplotlib.style.use("pymdr.figures")
BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#666666"


def draw(axes: Axes, line: tuple, dots: tuple, source: str, labels: tuple[str, str]) -> None:
    """A curve of pymdr, points of a source, and their largest difference relative to the largest value."""
    axes.plot(*line, color=BLUE, label="pymdr")
    axes.plot(*dots, "o", ms=4, mfc="none", color=ORANGE, label=source)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])


def shapes(axes: Axes) -> None:
    """Forces of cone, paraboloid and r^4 over the indentation (Sneddon 1965)."""
    d = np.linspace(0.0, 1.0, 60)[1:]
    few = np.linspace(0.1, 1.0, 7)
    for n in (1, 2, 4):
        force = mdr.solve(mdr.Contact(mdr.PowerLaw(n, 1.0, 1.0), UNIT), mdr.Path(indentation=d))[
            "normal_force"
        ]
        factor = math.sqrt(math.pi) * math.gamma(n / 2 + 1) / math.gamma(n / 2 + 0.5)
        known = 2 * n / (n + 1) * (few / factor) ** (1 / n) * few
        draw(axes, (d, force), (few, known), "Sneddon (1965)", ("indentation (m)", "normal force (N)"))
    axes.set_title("profiles $r$, $r^2$, $r^4$")


def adhesive(axes: Axes) -> None:
    """Force over contact radius with adhesion of short range (Johnson, Kendall and Roberts 1971)."""
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=mdr.JKR(0.1))
    path = mdr.indent(1.0, steps=60) >> mdr.indent(-0.5, steps=90)
    away = mdr.solve(contact, path).data.isel(step=slice(60, None))
    joined = away["contact_radius"].values > 0.0
    a = np.linspace(0.45, 1.2, 9)
    known = 4 * a**3 / 3 - np.sqrt(8 * math.pi * 0.1 * a**3)
    line = away["contact_radius"].values[joined], away["normal_force"].values[joined]
    draw(axes, line, (a, known), "Johnson et al. (1971)", ("contact radius (m)", "normal force (N)"))


def transition(axes: Axes) -> None:
    """Pull-off force over Maugis' parameter (Maugis 1992)."""
    work, dots = 1.0, np.geomspace(0.05, 5.0, 8)
    unit = math.pi * work

    def strength(parameter: float) -> float:
        return parameter / (9 / (2 * math.pi)) ** (1 / 3) * work ** (1 / 3)

    def by_pymdr(parameter: float) -> float:
        law = mdr.MaugisDugdale(work, strength=strength(parameter))
        contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=law)
        return -float(mdr.pull_off(contact, machine_stiffness=0.0).normal_force) / unit

    parameters = np.geomspace(0.05, 5.0, 25)
    line = parameters, [by_pymdr(p) for p in parameters]
    draw(
        axes,
        line,
        (dots, [maugis(p) for p in dots]),
        "Maugis (1992)",
        ("Maugis' parameter", "pull-off force / $\\pi w R$"),
    )
    axes.set_xscale("log")


def maugis(parameter: float) -> float:
    """The pull-off force of a sphere in units of pi w R, from Maugis' equations for a and m = c/a in his units."""

    def force(log_m: float) -> float:
        m = math.exp(log_m)
        root, arc = math.sqrt(m * m - 1), math.acos(1 / m)
        first = parameter / 2 * (root + (m * m - 2) * arc)
        second = 4 * parameter**2 / 3 * (root * arc - m + 1)

        def griffith(a: float) -> float:
            return first * a * a + second * a - 1

        a = brentq(griffith, 1e-9, 1e6, xtol=1e-14)
        return a**3 - parameter * a * a * (root + m * m * arc)

    return -float(minimize_scalar(force, bounds=(1e-4, 9.0), method="bounded", options={"xatol": 1e-10}).fun)


def loop(axes: Axes) -> None:
    """A loop in partial slip (Mindlin and Deresiewicz 1953)."""
    body, depth = mdr.Elastic(1e9, 0.0), 1e-5
    contact = mdr.Contact(mdr.Paraboloid(0.01), body, body, friction=mdr.Coulomb(0.3))
    moduli = mdr.effective_moduli(body, body)
    limit = 0.3 * moduli.normal / moduli.tangential * depth
    result = mdr.solve(contact, mdr.indent(depth) >> mdr.cycle(shift=0.8 * limit, cycles=2, steps=400))
    full = 0.3 * float(result["normal_force"][-1])
    u = np.linspace(-0.8, 0.8, 9)

    def first(part: np.ndarray) -> np.ndarray:
        return 1 - (1 - part) ** 1.5

    back = first(np.array(0.8)) - 2 * first((0.8 - u) / 2)
    line = result["shift"].values[-201:] / limit, result["tangential_force"].values[-201:] / full
    draw(
        axes,
        line,
        (np.r_[u, -u], np.r_[back, -back]),
        "Mindlin, Deresiewicz (1953)",
        ("shift / limit of sliding", "tangential force / $\\mu F_N$"),
    )


def memory(axes: Axes) -> None:
    """Approach and return of a ball on a standard solid (Ting 1966)."""
    body = mdr.Viscoelastic(mdr.StandardSolid(1.0, 3.0, 1.0), poisson=0.5)
    contact = mdr.Contact(mdr.Paraboloid(1.0), body)
    path = mdr.indent(1.0, steps=60, duration=1.0) >> mdr.indent(0.0, steps=60, duration=1.0)
    result = mdr.solve(contact, path)
    times = np.linspace(0.1, 1.9, 13)
    known = [ting(float(t)) for t in times]
    draw(
        axes,
        (result["time"], result["normal_force"]),
        (times, known),
        "Ting (1966)",
        ("time (s)", "normal force (N)"),
    )


def ting(t: float) -> float:
    """The force at a time, d = t up to 1 and 2 - t after it: the radius by its own integral equation."""

    def relaxed(s: float) -> float:
        return 4 * (1 + 3 * math.exp(-s))

    def rate(s: float) -> float:
        return 1.0 if s < 1.0 else -1.0

    def integral(integrand: Callable[[float], float], end: float) -> float:
        middle = [1.0] if 0.0 < 1.0 < end else []
        return quad(integrand, 0.0, end, points=middle or None, epsabs=1e-12)[0]

    if t <= 1.0:
        last = t
    else:
        # Ting: the radius at t is that at last < 1, where the integral of G(t - s) dd from last to t vanishes

        def moved(start: float) -> float:
            return quad(lambda s: relaxed(t - s) * rate(s), start, t, points=[1.0], epsabs=1e-10)[0]

        if moved(0.0) <= 0.0:
            return 0.0
        last = brentq(moved, 0.0, 1.0)
    return 4 / 3 * integral(lambda s: relaxed(t - s) * 1.5 * math.sqrt(s), last)


def under_the_surface(axes: Axes) -> None:
    """Stresses along the axis below a ball (Huber 1904)."""
    body = mdr.Elastic(1.0, 0.3)
    result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), body), mdr.indent(1.0))
    a, peak = (float(result[name][-1]) for name in ("contact_radius", "peak_pressure"))
    z = np.linspace(0.01, 3.0, 80)
    few = np.linspace(0.1, 3.0, 10)
    field = result.field("stress", r=[0.0], z=z * a)
    radial = -1.3 * (1 - few * np.arctan(1 / few)) + 0.5 / (1 + few**2)
    for name, known in (("zz", -1 / (1 + few**2)), ("rr", radial)):
        values = np.asarray(
            field.sel(component=name).values if "component" in field.dims else field[name].values
        ).ravel()
        draw(axes, (z, values / peak), (few, known), "Huber (1904)", ("depth / $a$", "stress / $p_0$"))
    axes.set_title("axial and radial stress")


PANELS: Sequence[Callable[[Axes], None]] = (shapes, adhesive, transition, loop, memory, under_the_surface)


def curves(file: Path) -> None:
    """A panel for each physics with a closed solution."""
    figure = Figure(figsize=(9.6, 5.6), layout="constrained")
    for axes, panel in zip(figure.subplots(2, 3).ravel(), PANELS, strict=True):
        panel(axes)
        handles, names = axes.get_legend_handles_labels()
        axes.legend(handles[:2], names[:2])
    figure.savefig(file, dpi=100)


def claims(file: Path, outcomes: Sequence[Any]) -> None:
    """The error of every value of random problems over its claim."""
    values = [value for outcome in outcomes for value in outcome.values]
    figure = Figure(figsize=(5.2, 4.2), layout="constrained")
    axes = figure.subplots()
    claimed = np.maximum([value.claimed for value in values], 1e-17)
    axes.loglog(
        claimed, np.maximum([value.miss for value in values], 1e-17), ".", ms=3, alpha=0.4, color=BLUE
    )
    ends = np.array([1e-17, 1.0])
    axes.plot(ends, ends, color=GREY, lw=1, label="true error = claimed error")
    axes.set_xlabel("claimed relative error")
    axes.set_ylabel("true relative error")
    beyond = sum(value.violated for value in values)
    title = f"{len(values)} values of {len(outcomes)} random problems, {beyond} of them violate their claims"
    axes.set_title(title)
    axes.legend(loc="upper left")
    figure.savefig(file, dpi=100)
