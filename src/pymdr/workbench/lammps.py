"""Contact laws of LAMMPS next to those of the method: the same histories and collisions of a ball on a wall."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.independent.lammps import Ball, collided, find_lammps, moved, version_of
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT, JKR, Coulomb
from pymdr.problem.materials import Elastic
from pymdr.problem.paths import Path
from pymdr.problem.plasticity import ElasticPlastic
from pymdr.problem.profiles import Paraboloid, Sphere
from pymdr.solving.impacts import Impact, impact
from pymdr.solving.pulloff import elastic_pull_off
from pymdr.solving.study import Column, Study
from pymdr.solving.verb import solve
from pymdr.units import FloatArray

_BALL = Ball(0.01)
_YOUNG, _POISSON, _FRICTION, _SURFACE_ENERGY, _STRENGTH = 1e9, 0.3, 0.3, 2.0, 2e7
_BODY = Elastic(_YOUNG, _POISSON)
_ROUND = Contact(Paraboloid(_BALL.radius), _BODY, _BODY)
_SLIDING = Contact(_ROUND.profile, _BODY, _BODY, friction=Coulomb(_FRICTION))
_YIELDING = Contact(
    Sphere(_BALL.radius), ElasticPlastic(_YOUNG, _POISSON, _STRENGTH, apparent_radius=True, wall_factor=True)
)
_DEEPEST, _DEEP, _SHALLOW, _ROWS = 1e-3, 1e-4, 5e-6, 80
_SLIP = _FRICTION * (2.0 - _POISSON) / (2.0 * (1.0 - _POISSON)) * _DEEP
"""Shift in m at which the contact slips as a whole."""
_PARTED = "JKR to largest pull"
_STEPS = 40_000
"""Of a collision: LAMMPS is of second order in them, and of first at the first touch."""
_MOVES = 4000
"""Rows of a collision by the method."""
_MATERIAL = f"{_YOUNG:g} 0 {_POISSON:g}"


def _sheared(normal: str, tangential: str) -> str:
    """A model of LAMMPS."""
    return f"{normal} tangential {tangential} NULL 0 {_FRICTION:g}"


_HERTZ = f"hertz/material {_MATERIAL}"
_JKR = _sheared(f"jkr {_MATERIAL} {_SURFACE_ENERGY:g}", "mindlin")
_DMT = _sheared(f"dmt {_MATERIAL} {_SURFACE_ENERGY:g}", "mindlin")
_MDR = f"mdr {_YOUNG:g} {_POISSON:g} {_STRENGTH:g} 0 0.5 0 damping mdr 1 tangential linear_history 0 0 0"
# the bodies of a contact share its work of adhesion; the program's surface energy is that of one of them
_STICKING = Contact(_ROUND.profile, _BODY, _BODY, adhesion=JKR(2.0 * _SURFACE_ENERGY))
_PULLING = Contact(_ROUND.profile, _BODY, _BODY, adhesion=DMT(2.0 * _SURFACE_ENERGY))


class _History(NamedTuple):
    """A ball that is moved."""

    name: str
    model: str
    contact: Contact
    depth: FloatArray
    shift: FloatArray
    steps: int = 100
    """Of LAMMPS between two rows."""
    parts_at: float = -math.inf
    """Indentation in m at which the method lets go, if not at the pull-off."""
    series: str = ""
    """Of cases along the largest shift."""
    loop: int = 0
    """Row from which on the history is a closed loop."""


class _Collision(NamedTuple):
    """A ball that flies against the wall."""

    name: str
    model: str
    contact: Contact
    speed: float
    degrees: float
    series: str
    """Of cases along the speed or the angle."""
    parts_at: float = -math.inf
    """As for histories."""


class Pair(NamedTuple):
    """A curve of both programs."""

    along_name: str
    """A quantity, or a label."""
    unit: str
    along: FloatArray
    name: str
    """Name of the quantity."""
    method: FloatArray
    """In its SI unit."""
    other: FloatArray


@dataclass(frozen=True, kw_only=True)
class LammpsComparison(Study):
    """Contact laws of LAMMPS next to those of the method, by :func:`bench_lammps`."""

    data: xr.Dataset
    """
    Over ``case``: model, largest_force (N), force_difference (relative to the largest force, for tangential forces to the largest friction),
    dissipated_energy and lammps_dissipated_energy (J) of histories, restitution and lammps_restitution of collisions, tangential where they are oblique.
    """
    curves: dict[str, Pair]
    """Of both: forces along histories and over time in collisions, the first of each series; energies and restitution along each series."""

    subject: ClassVar = "contact laws of LAMMPS"
    columns: ClassVar = {
        "case": Column("case", ""),
        "model": Column("LAMMPS", ""),
        "largest_force": Column("largest force", "N"),
        "force_difference": Column("difference", ""),
        "dissipated_energy": Column("lost", "J"),
        "lammps_dissipated_energy": Column("LAMMPS", "J"),
        "restitution": Column("restitution", ""),
        "lammps_restitution": Column("LAMMPS", ""),
    }

    def _figure(self) -> mpl.figure.Figure:
        """Forces, energies and restitution of both."""
        return plot.pairs_of_programs(self.curves, "LAMMPS")


def bench_lammps(progress: Callable[[int, int], None] | None = None) -> LammpsComparison:
    """
    Drive contact laws of LAMMPS and those of the method through the same histories and collisions.

    A ball of 10 mm (E = 1 GPa, nu = 0.3) on a wall of the same material; a ball that yields on a rigid wall. LAMMPS runs as a program of its own.

    Returns
    -------
    LammpsComparison
        Differences of force, energy and restitution; what differs is shown, not judged.

    Notes
    -----
    Surface energies of LAMMPS are half of the work of adhesion. Its JKR parts at the fold of force control under prescribed motion too, and is
    compared with JKR up to the pull-off and with JKR that parts there; its Mindlin models are linear until the contact slips as a whole.
    """
    program = find_lammps()
    cases: list[_History | _Collision] = [*_histories(), *_collisions()]
    rows, curves = [], {}
    for i, case in enumerate(cases, 1):
        row, pair = _followed(program, case) if isinstance(case, _History) else _flown(program, case)
        rows.append({"case": case.name, "model": _short(case.model), **row})
        if not case.series or all(case.series != other.series for other in cases[: i - 1]):
            curves[case.name] = pair
        if progress is not None:
            progress(i, len(cases))
    columns = {
        name: ("case", [row.get(name, math.nan) for row in rows], {"units": column.unit})
        for name, column in LammpsComparison.columns.items()
        if name != "case"
    }
    return LammpsComparison(
        data=xr.Dataset(columns, coords={"case": [row["case"] for row in rows]}),
        curves=curves | _series(cases, rows),
        notes=(
            version_of(program),
            "its surface energy is half of the work of adhesion",
            "walls here are plane (fix wall/gran): like pairs they keep the tension of JKR to the largest pull; fix wall/gran/region, "
            "and DMT everywhere, drop it where the bodies do not overlap",
        ),
    )


def _short(model: str) -> str:
    """Names of the normal and of the tangential model."""
    normal, _, tangential = model.partition(" tangential ")
    return f"{normal.split()[0]}, {tangential.split()[0]}"


def _histories() -> Iterator[_History]:
    up, down = np.linspace(0.0, 1.0, _ROWS + 1)[1:], np.linspace(1.0, 0.0, _ROWS + 1)[1:]
    there_and_back = _DEEP * np.concatenate([up, down])
    still = np.zeros(there_and_back.size)
    yield _History("Hertz", _sheared(_HERTZ, "mindlin"), _ROUND, there_and_back, still)
    away = _SHALLOW * np.concatenate([up, np.linspace(1.0, -0.6, 2 * _ROWS + 1)[1:]])
    still = np.zeros(away.size)
    yield _History("JKR", _JKR, _STICKING, away, still)
    yield _History(_PARTED, _JKR, _STICKING, away, still, parts_at=_fold())
    yield _History("DMT", _DMT, _PULLING, away, still)
    # the apparent radius grows with the steps of the program, which are the rows of the method
    deep = _DEEPEST * np.concatenate([np.linspace(0.0, 1.0, 401)[1:], np.linspace(1.0, 0.0, 401)[1:]])
    yield _History("yielding ball", _MDR, _YIELDING, deep, np.zeros(deep.size), steps=1)
    # parts of the shift at which the contact slips as a whole, from stick and beyond
    cycle = np.concatenate(
        [up, np.linspace(1.0, -1.0, 2 * _ROWS + 1)[1:], np.linspace(-1.0, 1.0, 2 * _ROWS + 1)[1:]]
    )
    depth = np.full(_ROWS + cycle.size, _DEEP)
    depth[:_ROWS] = _DEEP * up
    for part in (0.5, 0.25, 0.75, 1.0, 1.5, 2.0):
        shift = part * _SLIP * np.concatenate([np.zeros(_ROWS), cycle])
        yield _History(
            f"shear to {part:g} of gross slip",
            _sheared(_HERTZ, "mindlin"),
            _SLIDING,
            depth,
            shift,
            series="energy lost in a loop of shear",
            loop=2 * _ROWS - 1,
        )
    for rule in ("mindlin", "mindlin_rescale"):
        depth = np.concatenate(
            [
                _DEEP * up,
                _DEEP * np.linspace(1.0, 0.3, _ROWS + 1)[1:],
                _DEEP * np.linspace(0.3, 1.0, _ROWS + 1)[1:],
                _DEEP * down,
            ]
        )
        turns = np.concatenate(
            [
                0.6 * up,
                np.linspace(0.6, 0.2, _ROWS + 1)[1:],
                np.linspace(0.2, 0.5, _ROWS + 1)[1:],
                np.full(_ROWS, 0.5),
            ]
        )
        shift = _SLIP * turns
        yield _History(f"oblique load, {rule}", _sheared(_HERTZ, rule), _SLIDING, depth, shift)


def _fold() -> float:
    """Indentation in m of the pull-off under force control."""
    return float(elastic_pull_off(_STICKING, machine_stiffness=0.0).indentation)


def _collisions() -> Iterator[_Collision]:
    yield _Collision("collision, Hertz", _sheared(_HERTZ, "mindlin"), _ROUND, 1.0, 0.0, "")
    for law, parts_at in (("JKR", -math.inf), (_PARTED, _fold())):
        for speed in (0.02, 0.008, 0.012, 0.04, 0.08):
            name, series = f"collision, {law}, {1e3 * speed:g} mm/s", f"restitution, {law}"
            yield _Collision(name, _JKR, _STICKING, speed, 0.0, series, parts_at)
    for speed in (2.0, 0.5, 1.0, 4.0, 8.0):
        yield _Collision(
            f"collision, yielding, {speed:g} m/s", _MDR, _YIELDING, speed, 0.0, "restitution, yielding"
        )
    for degrees in (30.0, 5.0, 15.0, 45.0, 60.0, 75.0):
        yield _Collision(
            f"collision at {degrees:g} degrees",
            _sheared(_HERTZ, "mindlin_rescale"),
            _SLIDING,
            1.0,
            degrees,
            "restitution, oblique",
        )


def _series(cases: list[_History | _Collision], rows: list[dict[str, Any]]) -> dict[str, Pair]:
    """Energies and restitution along each series of cases."""
    pairs = {}
    for series in dict.fromkeys(case.series for case in cases if case.series):
        among = [(case, row) for case, row in zip(cases, rows, strict=True) if case.series == series]
        name, along_name, unit = "restitution", "velocity", "m/s"
        along = np.array([_along(case) for case, _ in among])
        if isinstance(among[0][0], _History):
            name, along_name, unit = "dissipated_energy", "shift", "m"
        elif among[0][0].degrees:
            name, along_name, unit = "tangential_restitution", "angle of the velocity (degrees)", ""
        column = name.removeprefix("tangential_")
        method, other = (np.array([row[of] for _, row in among]) for of in (column, f"lammps_{column}"))
        order = np.argsort(along)
        pairs[series] = Pair(along_name, unit, along[order], name, method[order], other[order])
    return pairs


def _along(case: _History | _Collision) -> float:
    """Where a case is in its series."""
    return float(case.shift.max()) if isinstance(case, _History) else case.degrees or case.speed


def _followed(program: str, case: _History) -> tuple[dict[str, float], Pair]:
    """A history by both."""
    sheared = bool(case.shift.any())
    path = Path(indentation=case.depth, shift=case.shift) if sheared else Path(indentation=case.depth)
    result = solve(case.contact, path)
    there = moved(program, case.model, _BALL, case.depth, case.shift, case.steps)
    parted = (case.depth < case.parts_at) & (np.arange(case.depth.size) > case.depth.argmax())
    normal = np.where(parted, 0.0, result["normal_force"].values)
    largest = float(np.abs(normal).max())
    dissipated, dissipated_there = (
        _area(normal, case.depth, case.loop),
        _area(there.normal, case.depth, case.loop),
    )
    pair = Pair("indentation", "m", case.depth, "normal_force", normal, there.normal)
    off = float(np.abs(there.normal - normal).max()) / largest
    if sheared:
        along = result["tangential_force"].values
        dissipated += _area(along, case.shift, case.loop)
        dissipated_there += _area(there.tangential, case.shift, case.loop)
        off = float(np.abs(there.tangential - along).max()) / (_FRICTION * largest)
        pair = Pair("shift", "m", case.shift, "tangential_force", along, there.tangential)
    row = {
        "largest_force": largest,
        "force_difference": off,
        "dissipated_energy": dissipated,
        "lammps_dissipated_energy": dissipated_there,
    }
    return row, pair


def _flown(program: str, case: _Collision) -> tuple[dict[str, float], Pair]:
    """A collision by both."""
    angle = math.radians(case.degrees)
    oblique = {"angle": angle} if angle else {}
    method = impact(case.contact, mass=_BALL.mass, speed=case.speed, steps=_MOVES, **oblique)
    along, against = case.speed * math.sin(angle), case.speed * math.cos(angle)
    duration = 1.5 * float(method["contact_time"])
    there = collided(program, case.model, _BALL, (along, against), duration, _STEPS)
    largest = float(method["normal_force"].max())
    leaves, restitution = float(method["contact_time"]), float(method["restitution"])
    if case.parts_at > -math.inf:
        leaves, velocity = _leaving(method, case.parts_at)
        restitution = velocity / case.speed
    # at the first touch the program has no force yet
    joined = (there.time > 0.0) & (there.time < leaves)
    at_rows = np.where(joined, _at(there.time, method, "normal_force"), 0.0)
    pair = Pair("time", "s", there.time, "normal_force", at_rows, there.normal)
    row = {
        "largest_force": largest,
        "force_difference": float(np.abs(there.normal - at_rows).max()) / largest,
        "restitution": restitution,
        "lammps_restitution": there.velocity[1] / against,
    }
    if angle:
        point = there.velocity[0] - there.spin * _BALL.radius
        sheared = _at(there.time, method, "tangential_force")
        pair = Pair("time", "s", there.time, "tangential_force", sheared, there.tangential)
        row |= {
            "force_difference": float(np.abs(there.tangential - sheared).max()) / (_FRICTION * largest),
            "restitution": float(method["tangential_restitution"]),
            "lammps_restitution": -point / along,
        }
    return row, pair


def _leaving(method: Impact, depth: float) -> tuple[float, float]:
    """Time in s and velocity in m/s at which the ball leaves an indentation in m."""
    d, time, velocity = (method[name].values[::-1] for name in ("indentation", "time", "velocity"))
    back = slice(0, int(d.argmax()) + 1)
    at = [float(np.interp(depth, d[back], values[back])) for values in (time, velocity)]
    return at[0], -at[1]


def _at(time: FloatArray, method: Impact, name: str) -> FloatArray:
    """A force of an impact at other times, 0 after it."""
    return np.asarray(np.interp(time, method["time"].values, method[name].values, right=0.0))


def _area(force: FloatArray, along: FloatArray, loop: int) -> float:
    """The integral of a force over its path, or over the loop from a row on."""
    first = slice(loop, None)
    if not loop:
        force, along = np.append(0.0, force), np.append(0.0, along)
    return float(np.trapezoid(force[first], along[first]))
