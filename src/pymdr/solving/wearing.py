"""Wear in dimensionless form, and its states in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.wear import SMALL
from pymdr.line.wear import History, Wearing, march, outer_radius, wear_limit
from pymdr.line.wear.limits import limiting_profile
from pymdr.line.wear.march import State, contact_edge, touched
from pymdr.line.wear.mesh import Mesh
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact, is_curve
from pymdr.problem.materials import Graded
from pymdr.problem.paths import Cycle, Hold, Leg, LoadingPath, Path, Ramp, legs, named_channels
from pymdr.problem.schedule import is_planar
from pymdr.units import FloatArray, metres, shown

_CELLS, _TOLERANCE = 160, 5e-5
_SCOUT, _ROUGH = 40, 1e-3
"""Cells and tolerance of the history that finds how far the contact grows at constant load."""
_BEYOND, _WIDER, _TRIES = 1.02, 1.6, 8
"""End of a mesh over that of the cells in contact, factor of an extension, and number of meshes."""
_MARGIN = 1.3
_FAINT = 1e-9
"""Pressure over E* d/a below which the bodies only touch."""
_HALVINGS = 80
_MOST_WEAR = 1e30
"""Largest depth of wear at the mean pressure and the slip of sliding, over the first indentation, that is followed."""
_INSIDE: FloatArray = 1.0 - np.linspace(1.0, 0.0, 24, endpoint=False) ** 2
"""Radii over the first stick radius at which the pressure is given, close together at it, where it may be infinite."""
_INNER, _ALIKE = 80, 1e-9
"""Points of a force curve within the first stick radius, and relative difference of depths below which points are one."""

UNITS = {
    "worn_volume": "m^3",
    "worn_depth": "m",
    "worn_radius": "m",
    "contact_radius": "m",
    "stick_radius": "m",
    "indentation": "m",
    "normal_force": "N",
    "normal_stiffness": "N/m",
    "force_amplitude": "N",
    "dissipated_per_cycle": "J",
    "mean_pressure": "Pa",
    "central_pressure": "Pa",
}


class WearCycle(NamedTuple):
    """One cycle: exactly one of the first two is given."""

    indentation: float | None
    normal_force: float | None
    amplitude: float


def refuse_unknown_wear(contact: Contact) -> None:
    """Refuse contacts whose wear is not known."""
    bodies = (contact.body, contact.counterbody)
    profile = contact.profile
    why = ""
    if contact.adhesion is not None:
        why = "friction with adhesion in partial slip is unknown; leave adhesion out"
    elif contact.is_viscoelastic:
        why = "wear of bodies with memory is not available; give Elastic bodies"
    elif any(isinstance(body, Graded) or not body.homogeneous for body in bodies):
        why = "a body is graded or layered; give homogeneous bodies such as Elastic"
    elif is_curve(contact):
        why = "a force curve has no shape that could wear; give the profile itself"
    elif profile.no_radius:
        why = "the profile is not of revolution; give one that is, such as Paraboloid"
    elif math.isfinite(profile.edge):
        why = (
            f"the profile has a sharp edge at r = {metres(profile.edge)}, where the pressure is infinite; give a rounded one, such as "
            "RoundedFlat"
        )
    if why:
        raise ProblemError(why)


def one_cycle(path: LoadingPath) -> WearCycle:
    """
    The constant load and the amplitude of a path of one cycle.

    Examples
    --------
    >>> import pymdr as mdr
    >>> one_cycle(mdr.load("2 N") >> mdr.cycle(shift="1 um"))
    WearCycle(indentation=None, normal_force=2.0, amplitude=1e-06)
    """
    pressed: tuple[str, float] | None = None
    shifts = [0.0]
    if not isinstance(path, LoadingPath):
        raise ProblemError(f"{shown(path)} is not a path; write load('10 N') >> cycle(shift='1 um')")
    if is_planar(path):
        raise ProblemError(
            "the path shifts the body in the plane; wear is followed along one line only, such as cycle(shift='1 um')"
        )
    for number, leg in enumerate(legs(path), 1):
        names = named_channels(leg)
        if isinstance(leg, Hold):
            continue
        if not names or not set(names) <= {"indentation", "normal_force", "shift"}:
            raise ProblemError(
                f"leg {number} moves {', '.join(names) or 'nothing'}; only indentation or normal_force, and then shift, are followed"
            )
        normal = [name for name in names if name != "shift"]
        if normal:
            pressed = _pressed(leg, number, normal[0], pressed, moved=len(shifts) > 1)
        if "shift" in names:
            shifts += _shifts(leg, shifts[-1])
    moved = np.array(shifts[1:] if len(shifts) > 2 else shifts)
    amplitude = 0.5 * float(np.ptp(moved))
    if pressed is None or not amplitude > 0.0:
        missing = "press the bodies together" if pressed is None else "shift them to and fro"
        raise ProblemError(f"the path does not {missing}; write load('10 N') >> cycle(shift='1 um')")
    depth = pressed[1] if pressed[0] == "indentation" else None
    return WearCycle(depth, None if depth is not None else pressed[1], amplitude)


def _pressed(
    leg: Leg, number: int, name: str, before: tuple[str, float] | None, moved: bool
) -> tuple[str, float]:
    """The channel and its constant value after a leg."""
    values = np.atleast_1d(np.asarray(getattr(leg, name), dtype=float))
    last = float(values[-1])
    varied = isinstance(leg, Cycle) or (isinstance(leg, Path) and np.ptp(values) > 0.0)
    if varied or (moved and before != (name, last)):
        raise ProblemError(
            f"leg {number} changes {name} while the bodies shift; wear is followed at constant load or indentation"
        )
    return name, last


def _shifts(leg: Leg, here: float) -> list[float]:
    if isinstance(leg, Cycle):
        assert leg.shift is not None
        return [here + leg.shift, here - leg.shift, here]
    assert isinstance(leg, Ramp | Path)
    return [float(u) for u in np.atleast_1d(np.asarray(leg.shift, dtype=float))]


@dataclass(frozen=True, eq=False)
class WearCase:
    """A contact that is to wear."""

    contact: Contact
    equivalent: EquivalentProfile
    moduli: EffectiveModuli
    depth: float
    """Indentation before wear in m."""
    mu: float
    request: WearCycle
    coefficient: float
    """Archard's, in m^2/N."""

    @cached_property
    def radius(self) -> float:
        """Contact radius before wear in m."""
        return float(np.atleast_1d(self.equivalent.inverse(np.array([self.depth])))[0])

    @property
    def caps(self) -> float:
        """Longest shift of a spring over its length, mu E*/G*."""
        return self.mu * self.moduli.normal / self.moduli.tangential

    @property
    def gross(self) -> bool:
        """Whether the whole contact slips."""
        return self.request.amplitude >= self.caps * self.depth

    @cached_property
    def stick(self) -> float:
        """Stick radius before wear in m; 0 in gross slip."""
        if self.gross:
            return 0.0
        left = self.depth - self.request.amplitude / self.caps
        return float(np.atleast_1d(self.equivalent.inverse(np.array([left])))[0])

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Where g' jumps within the first contact, in m."""
        return tuple(self.equivalent.kinks(self.radius))

    def gap(self, x: FloatArray) -> FloatArray:
        """g(x) in m."""
        return np.asarray(self.equivalent.g(np.asarray(x)))

    def profile(self, r: FloatArray) -> FloatArray:
        """f(r) in m from the apex; infinite beyond the end of the profile."""
        values = self.contact.profile.gap(r)
        first = float(np.ravel(self.contact.profile.gap(np.zeros(1)))[0])
        return np.where(np.isnan(values), math.inf, values - first)


class Followed(NamedTuple):
    """The history of a case, and that on half of the cells, which has chosen the blocks of cycles."""

    wearing: Wearing
    history: History
    half: History


def followed(case: WearCase, rows: FloatArray, progress: Callable[[int, int], None] | None) -> Followed:
    """The history of a case, on a mesh that the contact does not outgrow."""
    if case.gross and case.request.amplitude > SMALL * case.radius:
        raise ProblemError(
            f"gross slip with an amplitude of {metres(case.request.amplitude)} (limit {metres(SMALL * case.radius)}, a tenth of the "
            "contact radius): the track is not of revolution; give a smaller amplitude"
        )
    whole = _dimensionless(case, case.radius, _SCOUT).rate * float(rows[-1])
    if not whole <= _MOST_WEAR:
        raise ProblemError(
            f"{rows[-1]:g} cycles at a coefficient of {case.coefficient:g} m^2/N wear {whole:.2g} times the indentation "
            f"(limit {_MOST_WEAR:g}); give fewer cycles, and check the unit of the coefficient"
        )
    by_force = case.request.normal_force is not None
    farthest = case.contact.profile.max_radius
    end = min(_bound(case, rows), farthest)
    scouting = by_force
    for _ in range(_TRIES):
        wearing = _dimensionless(case, end, _SCOUT if scouting else _CELLS // 2)
        half = march(wearing, rows[-1:], _ROUGH) if scouting else march(wearing, rows, _TOLERANCE)
        reached = touched(*half.states[-1])
        full = by_force and not reached < wearing.end
        if full and end < farthest:
            end = min(end * _WIDER, farthest)
        elif scouting:
            # cells beyond the contact are lost, so that a few first find its end
            end, scouting = min(end, reached * case.radius * _BEYOND), False
        elif full:
            break
        else:
            fine = replace(wearing, cells=_CELLS)
            history = march(fine, rows, _TOLERANCE, progress, blocks=np.array(half.blocks))
            return Followed(fine, history, half)
    raise ProblemError(
        f"after {rows[-1]:g} cycles the contact reaches r = {metres(end)}, up to which the profile is known; give fewer cycles"
    )


def _dimensionless(case: WearCase, end: float, cells: int) -> Wearing:
    """The case in units of its first radius and depth, on cells up to an end in m."""
    a, d = case.radius, case.depth
    return Wearing(
        gap=lambda x: case.gap(x * a) / d,
        profile=lambda r: case.profile(r * a) / d,
        kinks=tuple(k / a for k in case.kinks),
        stick=case.stick / a,
        amplitude=case.request.amplitude / (case.caps * d),
        rate=4.0 * case.coefficient * case.caps * case.moduli.normal * d / a,
        force=None if case.request.normal_force is None else _half_load(case) / (d * a),
        end=end / a,
        cells=cells,
    )


def _half_load(case: WearCase) -> float:
    """int_0^a (d - g) dx in m^2."""
    assert case.request.normal_force is not None
    return case.request.normal_force / (2.0 * case.moduli.normal)


def _bound(case: WearCase, rows: FloatArray) -> float:
    """A radius in m that the contact hardly exceeds."""
    if case.request.normal_force is None:
        return outer_radius(case.depth, case.stick, case.gap, case.profile, case.kinks, case.radius)
    most = 4.0 * case.coefficient * case.request.normal_force * case.request.amplitude * float(rows[-1])
    flat = _flat_of(case, most)
    by_volume = _MARGIN * math.hypot(flat, 1.2 * case.radius)
    if case.gross:
        return by_volume
    # beyond the first stick radius the springs are not negative
    deepest = (_half_load(case) + float(case.equivalent.integral(np.array([case.stick]))[0])) / case.stick
    by_depth = outer_radius(deepest, case.stick, case.gap, case.profile, case.kinks, case.radius)
    return min(by_volume, by_depth)


def _flat_of(case: WearCase, volume: float) -> float:
    """The radius in m at which a flat on the profile has a volume in m^3."""
    part: FloatArray = np.linspace(0.0025, 0.9975, 200)

    def of(b: float) -> float:
        r = b * part
        top = float(case.profile(np.array([b]))[0])
        if not math.isfinite(top):
            return math.inf
        return 2.0 * math.pi * b / 200.0 * float(np.sum((top - case.profile(r)) * r))

    low, high = 0.0, case.radius
    while of(high) < volume:
        low, high = high, 1.5 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of(middle) < volume else (low, middle)
    return high


class Coarser(NamedTuple):
    """The columns of a case on half and a quarter of the cells by the same blocks, and on half the cells by half as many blocks."""

    cells: dict[str, FloatArray]
    quarter: dict[str, FloatArray]
    blocks: dict[str, FloatArray]


def coarser(case: WearCase, solved: Followed, rows: FloatArray) -> Coarser:
    """The same history on coarser cells and blocks; where these do not converge, those of half the cells take their place."""

    def tried(parts: int, ends: list[float]) -> dict[str, FloatArray]:
        fewer = replace(solved.wearing, cells=solved.wearing.cells // parts)
        try:
            return columns_of(case, fewer, march(fewer, rows, _TOLERANCE, blocks=np.array(ends)))
        except ConvergenceError:
            return same

    same = columns_of(case, solved.wearing, solved.half)
    return Coarser(same, tried(4, solved.half.blocks), tried(2, solved.half.blocks[1::2]))


def columns_of(case: WearCase, wearing: Wearing, history: History) -> dict[str, FloatArray]:
    """The quantities of all rows in SI units."""
    a, d, e = case.radius, case.depth, case.moduli.normal
    rows = []
    for mesh, state in history.states:
        edge = _contact(mesh, state)
        half = state.depth * mesh.stick - mesh.inner_load + float(mesh.loading @ state.springs)
        pulled = np.minimum(state.springs, wearing.amplitude)
        sheared = wearing.amplitude * mesh.stick + float(mesh.loading @ pulled)
        slip_work = float(np.sum(mesh.areas * state.pressure * state.slip))
        load = 2.0 * e * half * d * a
        radii, depth = mesh.whole(state.worn)
        worn = depth.max()
        last = radii[min(int(np.flatnonzero(depth)[-1]) + 1, depth.size - 1)] if worn > 0.0 else 0.0
        rows.append(
            (
                mesh.volume(state.worn) * a * a * d,
                worn * d,
                last * a,
                edge * a,
                mesh.stick * a,
                state.depth * d,
                load,
                2.0 * e * edge * a,
                2.0 * case.moduli.tangential * case.caps * d * a * sheared,
                4.0 * case.mu * e * case.caps * d * d * a * slip_work,
                load / (math.pi * (edge * a) ** 2),
                float(_stuck_pressure(case, mesh, state, np.zeros(1))[0]),
            )
        )
    return dict(zip(UNITS, np.array(rows).T, strict=True))


def _contact(mesh: Mesh, state: State) -> float:
    """The contact radius, up to the edge of wear where the bodies only touch."""
    if state.pressure.max() > _FAINT:
        return contact_edge(mesh, state)
    worn = np.flatnonzero(state.worn > 0.0)
    return float(mesh.nodes[worn[-1] + 1]) if worn.size else mesh.stick


def _stuck_pressure(case: WearCase, mesh: Mesh, state: State, r: FloatArray) -> FloatArray:
    """The pressure in Pa at radii in first contact radii up to the stick radius."""
    a, d, first = case.radius, case.depth, float(mesh.stuck.x[0])
    pressure = mesh.pressure_within(r, state.springs, state.depth)
    inside = r < first
    if inside.any():
        pressure[inside] += (
            case.equivalent.pressure_integral(r[inside] * a, np.array(first * a)) * a / d / math.pi
        )
    return pressure * (case.moduli.normal * d / a)


def surface_of_wear(case: WearCase, history: History) -> dict[str, FloatArray]:
    """Radii, worn profile, depth of wear, pressure and slip of all rows in SI units, over nodes."""
    a, d, e = case.radius, case.depth, case.moduli.normal
    rows: dict[str, list[FloatArray]] = {
        name: [] for name in ("r", "profile", "worn_depth", "pressure", "slip", "limiting_profile")
    }
    for mesh, state in history.states:
        radii, depth = mesh.whole(state.worn)
        first = _INSIDE * radii[0] if radii[0] > 0.0 else np.zeros(0)
        radii, depth = np.append(first, radii), np.append(np.zeros(first.size), depth)
        inner = radii.size - mesh.rings.size - 1
        r = radii * a
        rows["r"].append(r)
        rows["worn_depth"].append(depth * d)
        still = case.request.normal_force is None
        rows["limiting_profile"].append(limiting_shape(case, r) if still else np.full(r.size, math.nan))
        rows["profile"].append(case.profile(r) + depth * d)
        stuck = _stuck_pressure(case, mesh, state, radii[:inner])
        rows["pressure"].append(np.concatenate([stuck, state.pressure * (e * d / a), [0.0]]))
        rows["slip"].append(np.concatenate([np.zeros(inner), state.slip * (case.caps * d), [math.nan]]))
    size = max(values.size for values in rows["r"])
    return {
        name: np.array([np.pad(v, (0, size - v.size), mode="edge") for v in values])
        for name, values in rows.items()
    }


def line_of_wear(case: WearCase, history: History) -> dict[str, FloatArray]:
    """Positions x and g(x) in m of the springs between the first stick radius and the contact radius, and of all rows the same number."""
    a, d = case.radius, case.depth
    rows: dict[str, list[FloatArray]] = {"x": [], "equivalent_profile": []}
    for mesh, state in history.states:
        # at the edge of the contact the springs have no length
        count = int(np.flatnonzero(state.springs > 0.0)[-1]) + 1 if state.springs.max() > 0.0 else 0
        springs = np.append(state.springs[:count], 0.0)
        rows["x"].append(np.append(mesh.stuck.x, mesh.nodes[: count + 1]) * a)
        rows["equivalent_profile"].append(np.append(mesh.stuck.gap, state.depth - springs) * d)
    size = max(values.size for values in rows["x"])
    return {
        name: np.array([np.pad(v, (0, size - v.size), mode="edge") for v in values])
        for name, values in rows.items()
    }


def loads_of_wear(original: EquivalentProfile, x: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Indentations in m and int_0^a (d - g) dx in m^2 of a worn line, as points of its force curve.

    Parameters
    ----------
    original : EquivalentProfile
        Up to the first position.
    x, g : ndarray
        Positions and g of the springs beyond, in m; between them g is linear in x^2.
    """
    first = x[:1]
    inner = float(first[0]) * np.linspace(0.0, 1.0, _INNER + 1)[: _INNER + 1 if first[0] > 0.0 else 0]
    before = original.g(inner)
    low, high = x[:-1], x[1:]
    rise = (high - low) * (high + 2.0 * low) / (3.0 * np.where(high > 0.0, high + low, 1.0))
    cells = (high - low) * g[:-1] + rise * np.diff(g)
    start = float(original.integral(first)[0]) if first[0] > 0.0 else 0.0
    half = np.append(
        inner * before - original.integral(inner), x * g - start - np.append(0.0, np.cumsum(cells))
    )
    depth = np.append(before, g)
    kept = np.flatnonzero(np.append(True, np.diff(np.maximum.accumulate(depth)) > _ALIKE * depth[-1]))
    # the curve carries the whole load of the row
    kept[-1] = depth.size - 1
    return depth[kept], half[kept]


def limit_of(case: WearCase) -> dict[str, float]:
    """Volume, radius and load at the end of wear at constant indentation; empty at constant load."""
    if case.request.normal_force is not None:
        return {}
    end = wear_limit(case.depth, case.stick, case.gap, case.profile, case.kinks, case.radius)
    return {
        "limit_volume": end.volume,
        "limit_radius": end.radius,
        "limit_force": 2.0 * case.moduli.normal * end.half_load,
    }


def limiting_shape(case: WearCase, r: FloatArray) -> FloatArray:
    """The limiting profile in m at constant indentation at radii in m."""
    f = case.profile(r)
    if case.stick == 0.0:
        return np.maximum(f, case.depth)
    beyond = limiting_profile(np.maximum(r, case.stick), case.depth, case.stick, case.gap, case.kinks)
    return np.where(r > case.stick, np.maximum(f, beyond), f)
