"""Check, map, solve, interpret: the method as one verb."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError, PymdrError
from pymdr.independent.history import solve_steps
from pymdr.independent.rings import Rings, RingSolution
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.surface import Surface
from pymdr.interpretation.validity import (
    SOURCES,
    Assumption,
    BoolArray,
    Claim,
    Level,
    certify_disk,
    describe_ranges,
    normal_claims,
    ring_claims,
    small_slope_assumptions,
    valid_ranges,
)
from pymdr.line.foundation import (
    DiskStates,
    ElasticLine,
    SpringFoundation,
    elastic_energy,
    line_upto_force,
    mean_pressure,
    normal_force,
    normal_stiffness,
    spring_foundation,
    states_at_depth,
    states_at_force,
)
from pymdr.mapping.equivalent import NumericLine, equivalent_profile, gap_function, samples_of
from pymdr.mapping.moduli import EffectiveModuli, effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Hold, Leg, LoadingPath, Path, Ramp, legs
from pymdr.problem.profiles import FlatPunch, Function, Profile, Sampled, Sphere, Sum
from pymdr.result import Result, Status, labelled
from pymdr.units import FloatArray, QuantityLike, to_si

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and their total."""


@dataclass(frozen=True)
class Mapped:
    """Step 1: the line, its moduli and what was said on the way."""

    line: ElasticLine
    moduli: EffectiveModuli
    notes: tuple[str, ...]


def solve(
    contact: Contact, path: LoadingPath, *, solver: Rings | None = None, progress: Progress | None = None
) -> Result:
    """
    Solve a contact along a loading path.

    Parameters
    ----------
    contact : Contact
        Profile and materials.
    path : LoadingPath
        For example ``load("50 N", steps=50)``.
    solver : Rings, optional
        ``Rings(n=400)`` solves by boundary elements on rings instead of the method, annular contacts
        included.
    progress : callable, optional
        Called as ``progress(done, total)`` between legs.

    Returns
    -------
    Result
        Labelled arrays over the rows of the path, with claims.

    Raises
    ------
    ProblemError, PathError
        If the problem cannot be posed, for example an indentation of a sphere by its radius.
    ConvergenceError
        If a quadrature or root fails; never a physical-looking number instead.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.paths import indent
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = Contact(Paraboloid("10 mm"), Elastic("0.75 MPa", 0.0))
    >>> round(float(solve(ball, indent("0.1 mm"))["normal_force"][-1]), 12)
    0.1
    """
    check_problem(contact, path)
    if solver is not None:
        return solve_by_rings(contact, path, solver, progress)
    mapped = map_to_line(contact)
    mapped, states, prescribed = follow(contact, mapped, path, progress)
    result = interpret(contact, path, mapped, states, prescribed)
    return with_bands(result) if scatter_of(contact.profile) else result


def check_problem(contact: Contact, path: LoadingPath) -> None:
    """Refuse arguments of the wrong kind before any work."""
    if not isinstance(contact, Contact):
        raise ProblemError(f"solve: {contact!r} is not a Contact; write Contact(profile, body)")
    if not isinstance(path, LoadingPath):
        raise PathError(f"solve: {path!r} is not a path; write for example load('50 N', steps=50)")
    timed = [
        leg.time is not None if isinstance(leg, Path) else leg.duration is not None for leg in _known(path)
    ]
    if any(timed) and not all(timed):
        raise PathError(
            "some legs of the path have a duration and others none: give one to every leg, or to none"
        )
    for leg in _known(path):
        force = getattr(leg, "normal_force", None)
        if force is not None and np.min(force) < 0.0:
            raise PathError(
                f"normal_force = {float(np.min(force)):g} N: without adhesion the force cannot be below 0 N; "
                "unload to 0 N, or lift off with indent(...)"
            )


def _known(path: LoadingPath) -> list[Ramp | Hold | Path]:
    found = []
    for leg in legs(path):
        if not isinstance(leg, Ramp | Hold | Path):
            raise PathError(f"solve: legs of the kind {type(leg).__name__} are not known")
        found.append(leg)
    return found


def map_to_line(contact: Contact) -> Mapped:
    """Step 1: effective moduli and equivalent profile."""
    moduli = effective_moduli(contact.body, contact.counterbody)
    return Mapped(
        ElasticLine(equivalent_profile(contact.profile), moduli.normal), moduli, _notes(contact.profile)
    )


def _notes(profile: Profile) -> tuple[str, ...]:
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return tuple(
        f"the offset f(0) = {part.offset:.6g} m of the profile was removed"
        for part in parts
        if isinstance(part, Function | Sampled) and part.offset != 0.0
    )


def follow(
    contact: Contact, mapped: Mapped, path: LoadingPath, progress: Progress | None
) -> tuple[Mapped, DiskStates, FloatArray]:
    """Step 2: the states of every row, leg by leg, and its force where that is prescribed, else nan."""
    mapped = _made_fast(contact, mapped, path)
    line = mapped.line
    rows: list[DiskStates] = []
    forced: list[FloatArray] = []
    d = force = 0.0
    by_force = False
    pieces = _known(path)
    total = sum(_rows_of(leg) for leg in pieces)
    done = 0
    for leg in pieces:
        by_force, targets = _targets(leg, by_force, force if _is_forced(leg, by_force) else d)
        states = states_at_force(line, targets) if by_force else states_at_depth(line, targets)
        _refuse_unreachable(contact.profile, states)
        rows.append(states)
        forced.append(targets if by_force else np.full(targets.size, math.nan))
        last = DiskStates(states.indentation[-1:], states.contact_radius[-1:], states.edge_excess[-1:])
        d, force = float(last.indentation[0]), float(normal_force(line, last)[0])
        if by_force:
            force = float(targets[-1])
        done += targets.size
        if progress is not None:
            progress(done, total)
    states = DiskStates(
        np.concatenate([s.indentation for s in rows]),
        np.concatenate([s.contact_radius for s in rows]),
        np.concatenate([s.edge_excess for s in rows]),
    )
    return mapped, states, np.concatenate(forced)


def _rows_of(leg: Ramp | Hold | Path) -> int:
    if isinstance(leg, Path):
        samples = leg.normal_force if leg.indentation is None else leg.indentation
        assert samples is not None
        return samples.size
    return leg.steps


def _is_forced(leg: Leg, before: bool) -> bool:
    if isinstance(leg, Hold):
        return before
    return getattr(leg, "normal_force", None) is not None


def _targets(leg: Ramp | Hold | Path, before: bool, start: float) -> tuple[bool, FloatArray]:
    """Whether the force is prescribed in a leg, and the prescribed values."""
    by_force = _is_forced(leg, before)
    if isinstance(leg, Hold):
        return by_force, np.full(leg.steps, start)
    target = leg.normal_force if by_force else leg.indentation
    assert target is not None
    if isinstance(leg, Path):
        return by_force, np.asarray(target)
    rows = start + (target - start) * np.arange(1.0, leg.steps + 1.0) / leg.steps
    rows[-1] = target
    return by_force, rows


def _made_fast(contact: Contact, mapped: Mapped, path: LoadingPath) -> Mapped:
    """Interpolate a numerical profile on all radii that the path can reach."""
    line = mapped.line
    if not isinstance(line.equivalent, NumericLine):
        return mapped
    equivalent = line.equivalent
    depth = max((float(np.max(v)) for v in _channel(path, "indentation")), default=-math.inf)
    force = max((float(np.max(v)) for v in _channel(path, "normal_force")), default=0.0)
    top = min(equivalent.edge, equivalent.reach if equivalent.fixed else math.inf)
    if equivalent.fixed:
        _refuse_beyond_data(line, depth, force)
    if not math.isfinite(top):
        if force > 0.0:
            reached = line_upto_force(line, force).equivalent
            depth = max(depth, float(reached.g(np.array([reached.reach]))[0]))
        top, dips = _last_radius_below(contact.profile, equivalent, depth)
        if dips:
            marked = equivalent_profile(_marked(contact.profile, dips))
            assert isinstance(marked, NumericLine)
            equivalent = marked
    return Mapped(ElasticLine(equivalent.upto(top), line.modulus), mapped.moduli, mapped.notes)


def _channel(path: LoadingPath, name: str) -> list[FloatArray]:
    return [np.asarray(v) for leg in _known(path) if (v := getattr(leg, name, None)) is not None]


_DECADES = np.geomspace(1e-16, 1e8, 24 * 16 + 1)
"""Radii in m at which a profile without a length of its own is looked at first."""


def _last_radius_below(
    profile: Profile, equivalent: NumericLine, depth: float
) -> tuple[float, tuple[float, ...]]:
    """
    The largest radius with f <= depth: contact, where u = d - f >= 0, lies inside it.

    Dips of f below `depth` farther out come back by their ends, which become breakpoints, so that no panel
    steps over them.
    """
    first = equivalent.top_for(depth) if depth > 0.0 else _last_below(profile, equivalent, depth, _DECADES)
    if first is None:
        return min(1.0, profile.reach), ()  # no contact: any length will do
    limit = min(profile.reach, 1000.0 * first)
    if limit <= first:
        return first, ()
    r = np.geomspace(first, limit, 20_001)
    with np.errstate(all="ignore"):
        below = _gap_on(profile, equivalent, r) <= depth
    if not below.any():
        return first, ()
    last = _last_below(profile, equivalent, depth, r)
    ends = np.flatnonzero(np.diff(below.astype(int)))
    return max(first, last or 0.0), tuple(float(x) for i in ends for x in (r[i], r[i + 1]))


def _marked(profile: Profile, radii: tuple[float, ...]) -> Profile:
    """The profile with more breakpoints on its callables."""
    if isinstance(profile, Sum):
        return Sum(tuple(_marked(part, radii) for part in profile.parts))
    if not isinstance(profile, Function):
        return profile
    return replace(profile, breakpoints=(*profile.breakpoints, *radii))


def _last_below(profile: Profile, equivalent: NumericLine, depth: float, radii: FloatArray) -> float | None:
    r = radii[radii <= profile.reach]
    with np.errstate(all="ignore"):
        below = np.flatnonzero(_gap_on(profile, equivalent, r) <= depth)
    if below.size == 0:
        return None
    if below[-1] == r.size - 1 and r[-1] < profile.reach:
        raise ProblemError(
            f"the profile is below {depth:g} m again at r = {r[-1]:g} m, so the contact has no end; add "
            "FlatPunch(radius) for a cylinder of that end shape, or state the reach of the Function"
        )
    return float(r[min(below[-1] + 1, r.size - 1)])


def _gap_on(profile: Profile, equivalent: NumericLine, r: FloatArray) -> FloatArray:
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    if all(not isinstance(part, Function) or part.f is not None for part in parts):
        return profile.gap(r)
    slope = samples_of(profile, float(r[-1])).slope(r)
    steps = 0.5 * np.diff(r) * (slope[1:] + slope[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + gap_function(profile, equivalent)(r[:1])


def _refuse_beyond_data(line: ElasticLine, depth: float, force: float) -> None:
    """Samples are not extrapolated: beyond the largest load that they allow nothing can be said."""
    equivalent = line.equivalent
    assert isinstance(equivalent, NumericLine)
    if math.isfinite(equivalent.edge) and equivalent.edge <= equivalent.reach:
        return
    fast = ElasticLine(equivalent.upto(equivalent.reach), line.modulus)
    deepest = float(np.max(_g_samples(fast)))
    hardest = float(normal_force(fast, states_at_depth(fast, np.array([deepest])))[0])
    if depth > deepest or force > hardest:
        asked = f"indentation = {depth:g} m" if depth > deepest else f"normal_force = {force:g} N"
        raise PathError(
            f"{asked}: the samples end at r = {equivalent.reach:g} m and are not extrapolated; the largest "
            f"indentation that they allow is {deepest:.6g} m (normal force {hardest:.6g} N)"
        )


def _refuse_unreachable(profile: Profile, states: DiskStates) -> None:
    """Refuse a sphere pressed in by its radius, and a contact that would pass the end of the profile."""
    parts = [part for part in getattr(profile, "parts", (profile,)) if not isinstance(part, FlatPunch)]
    deepest = float(np.max(states.indentation))
    if profile.edge < profile.reach:
        return
    if len(parts) == 1 and isinstance(parts[0], Sphere) and not deepest < parts[0].radius:
        raise PathError(
            f"indentation = {deepest:g} m: a sphere cannot be pressed in by its radius, {parts[0].radius:g} m; "
            "reduce the indentation or the load"
        )
    if not np.max(states.contact_radius) < profile.reach:
        raise PathError(
            f"indentation = {deepest:g} m: the contact would pass r = {profile.reach:g} m, the last radius at which "
            "the profile is known; reduce the indentation or the load"
        )


def interpret(
    contact: Contact, path: LoadingPath, mapped: Mapped, states: DiskStates, prescribed: FloatArray
) -> Result:
    """Step 3: quantities, claims and assumptions of every row."""
    line = mapped.line
    surface = Surface(line, gap_function(contact.profile, line.equivalent), states)
    certificate = certify_disk(line, states)
    by_force = np.isfinite(prescribed)
    force = np.where(by_force, prescribed, normal_force(line, states))
    claims = normal_claims(
        certificate.disk,
        certificate.reason,
        _range_words(line, surface, certificate.disk),
        {"indentation": ~by_force, "normal_force": by_force},
    )
    columns: dict[str, FloatArray] = {
        "indentation": states.indentation,
        "normal_force": force,
        "contact_radius": states.contact_radius,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(force, states.contact_radius),
        "elastic_energy": elastic_energy(line, states),
        "force_lower_bound": force,
    }
    if math.isfinite(line.equivalent.edge):
        columns["edge_amplitude"] = edge_amplitude(line.modulus, states.contact_radius, states.edge_excess)
    else:
        del claims["edge_amplitude"]
    time = _times(path)
    disk = certificate.disk
    valid = {
        name: values if claims[name].where.all() else np.where(claims[name].where, values, math.nan)
        for name, values in columns.items()
        if claims[name].readable
    }
    if time is not None:
        valid = {"time": time, **valid}
    status = Status.COMPLETED if disk.all() else Status.PARTLY_REFUSED if disk.any() else Status.REFUSED
    return Result(
        contact=contact,
        path=path,
        data=labelled(valid),
        claims=claims,
        assumptions=_assumptions(contact, mapped, states),
        status=status,
        notes=mapped.notes,
        references=("sneddon", "popov-hess", *(() if disk.all() else ("barber",))),
    )


def solve_by_rings(contact: Contact, path: LoadingPath, rings: Rings, progress: Progress | None) -> Result:
    """The same history by boundary elements on rings, without the method."""
    if not isinstance(rings, Rings):
        raise ProblemError(f"solve: solver = {rings!r}; write solver=Rings(n=400), or leave it out")
    moduli = effective_moduli(contact.body, contact.counterbody)
    found: list[RingSolution | None] = []
    prescribed: list[FloatArray] = []
    forced: list[BoolArray] = []
    by_force = False
    pieces = _known(path)
    total = sum(_rows_of(leg) for leg in pieces)
    for leg in pieces:
        last = found[-1] if found else None
        force, d = (0.0, 0.0) if last is None else (last.force, last.indentation)
        by_force, targets = _targets(leg, by_force, force if _is_forced(leg, by_force) else d)
        for target in targets:
            found += solve_steps(contact.profile, moduli.normal, np.array([target]), by_force, rings)
            if progress is not None:
                progress(len(found), total)
        prescribed.append(targets)
        forced.append(np.full(targets.size, by_force))
    wanted, is_forced = np.concatenate(prescribed), np.concatenate(forced)
    zero = np.where(is_forced, 0.0, wanted)
    columns = {
        "indentation": np.array(
            [d if s is None else s.indentation for s, d in zip(found, zero, strict=True)]
        ),
        "normal_force": _each(found, lambda s: s.force),
        "contact_radius": _each(found, lambda s: s.contact_radius),
        "inner_contact_radius": _each(found, lambda s: s.zones[0][0]),
        "contact_area": _each(found, lambda s: s.contact_area),
        "normal_stiffness": _each(found, lambda s: s.stiffness),
        "mean_pressure": _each(found, lambda s: s.mean_pressure),
        "elastic_energy": _each(found, lambda s: s.energy),
    }
    time = _times(path)
    if time is not None:
        columns = {"time": time, **columns}
    radii = columns["contact_radius"]
    states = DiskStates(columns["indentation"], radii, np.zeros(radii.shape))
    mapped = Mapped(
        ElasticLine(equivalent_profile(contact.profile), moduli.normal), moduli, _notes(contact.profile)
    )
    return Result(
        contact=contact,
        path=path,
        data=labelled(columns),
        claims=ring_claims(rings.n, wanted.size),
        assumptions=_assumptions(contact, mapped, states),
        status=Status.BY_RINGS,
        notes=mapped.notes,
        references=("johnson",),
        rings=rings,
    )


def _each(found: list[RingSolution | None], value: Callable[[RingSolution], float]) -> FloatArray:
    return np.array([0.0 if solution is None else value(solution) for solution in found])


BAND_NOTE = (
    "bands are the results for the profile lowered and raised by its scatter: a sensitivity, not a confidence "
    "interval; NaN where such a profile is not a disk contact or not known far enough"
)


def scatter_of(profile: Profile) -> bool:
    """Whether a profile has samples with a scatter."""
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return any(isinstance(part, Sampled) and part.scatter is not None for part in parts)


def with_bands(result: Result) -> Result:
    """Add to every quantity the band between the solutions for f - scatter and f + scatter."""
    data = result.data
    names = [str(name) for name in data if name != "time" and not np.all(np.isnan(data[name].values))]
    ends = [_shifted_solution(result, sign) for sign in (-1.0, 1.0)]
    columns: dict[str, FloatArray] = {}
    for name in names:
        values = np.array(
            [
                data[name].values,
                *(end[name].values if name in end else np.full(data.sizes["step"], math.nan) for end in ends),
            ]
        )
        if np.array_equal(values[0], values[1]) and np.array_equal(values[0], values[2]):
            continue
        known = np.isfinite(values).all(axis=0)
        columns[f"{name}_low"] = np.where(known, values.min(axis=0), math.nan)
        columns[f"{name}_high"] = np.where(known, values.max(axis=0), math.nan)
    return replace(
        result,
        data=data.merge(labelled(columns)),
        claims=_mean_claims(result.claims),
        notes=(*result.notes, BAND_NOTE),
    )


def _shifted_solution(result: Result, sign: float) -> xr.Dataset:
    profile = result.contact.profile
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    shifted = tuple(_shifted(part, sign) for part in parts)
    contact = replace(result.contact, profile=shifted[0] if len(shifted) == 1 else Sum(shifted))
    try:
        return solve(contact, result.path).data
    except (PathError, ConvergenceError):
        return labelled({})


def _shifted(part: Profile, sign: float) -> Profile:
    if not isinstance(part, Sampled) or part.scatter is None:
        return part
    return replace(part, height=part.height + sign * part.scatter, scatter=None)


def _mean_claims(claims: Mapping[str, Claim]) -> dict[str, Claim]:
    """A profile with scatter is the azimuthal mean of a body that is not quite one of revolution."""
    reason = (
        "exact for the mean profile; for the measured body, whose azimuthal mean it is, the force at a given "
        "indentation is a rigorous lower bound, second-order accurate in the asymmetry"
    )
    source = SOURCES["shield"]
    return {
        name: claim
        if claim.level is not Level.EXACT
        or name == "force_lower_bound"
        or claim.reason.startswith("prescribed")
        else replace(claim, level=Level.APPROXIMATE, reason=f"{reason}; {claim.reason}", source=source)
        for name, claim in claims.items()
    }


def _times(path: LoadingPath) -> FloatArray | None:
    """Time of every row, if the legs state it."""
    now = 0.0
    columns: list[FloatArray] = []
    for leg in _known(path):
        if isinstance(leg, Path):
            if leg.time is None:
                return None
            if leg.time[0] <= now and columns:
                raise PathError(
                    f"Path.time begins at {leg.time[0]:g} s, but the legs before it end at {now:g} s; "
                    "times count from the start of the whole history"
                )
            columns.append(np.asarray(leg.time))
        else:
            if leg.duration is None:
                return None
            columns.append(now + leg.duration * np.arange(1.0, leg.steps + 1.0) / leg.steps)
        now = float(columns[-1][-1])
    return np.concatenate(columns)


def _range_words(line: ElasticLine, surface: Surface, disk: BoolArray) -> str:
    """For which loads the contact is a disk, if it is not for all."""
    if disk.all():
        return ""
    deepest = float(np.max(surface.states.indentation))
    if math.isfinite(line.equivalent.edge):
        deepest = max(4.0 * deepest, 4.0 * float(np.max(np.abs(_g_samples(line)))))
    ranges = valid_ranges(line, deepest)
    top = normal_force(line, states_at_depth(line, np.array([deepest])))
    return describe_ranges(ranges, float(top[0]))


def _g_samples(line: ElasticLine) -> FloatArray:
    return line.equivalent.g(np.linspace(0.0, min(line.equivalent.edge, line.equivalent.reach), 65))


def _assumptions(contact: Contact, mapped: Mapped, states: DiskStates) -> tuple[Assumption, ...]:
    a = float(np.max(states.contact_radius, initial=0.0))
    if a == 0.0:
        return ()
    slope = samples_of(contact.profile, a).slope
    return small_slope_assumptions(contact.profile, slope, a, mapped.moduli.dundurs_beta)


@dataclass(frozen=True)
class Assessment:
    """What can be claimed of a contact along a path, before its history is solved."""

    claims: Mapping[str, Claim]
    assumptions: tuple[Assumption, ...]
    notes: tuple[str, ...]
    largest: Mapping[str, float]
    """Largest indentation (m), normal force (N) and contact radius (m) that the path reaches."""

    def summary(self) -> str:
        """The claims and assumptions as a text."""
        from pymdr.presentation.text import assessment

        return assessment(self.largest, self.claims, self.assumptions, self.notes)

    def __str__(self) -> str:
        return self.summary()


def assess(contact: Contact, path: LoadingPath) -> Assessment:
    """
    Map a contact and state its claims for the loads that a path reaches; no history is solved.

    Parameters
    ----------
    contact : Contact
    path : LoadingPath

    Returns
    -------
    Assessment
        Claims for 40 loads up to the largest one, assumptions and notes.

    Raises
    ------
    ProblemError, PathError
        As :func:`solve`.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.paths import load
    >>> from pymdr.problem.profiles import Sphere
    >>> ball = Contact(Sphere("10 mm"), Elastic("210 GPa", 0.3))
    >>> assess(ball, load("50 N")).claims["pressure"].level.name
    'EXACT'
    """
    check_problem(contact, path)
    turning = [_only_ends(leg) for leg in _known(path)]
    route = turning[0]
    for leg in turning[1:]:
        route = route >> leg
    mapped, ends, _ = follow(contact, map_to_line(contact), route, None)
    line = mapped.line
    deepest = float(np.max(ends.indentation, initial=0.0))
    states = states_at_depth(line, deepest * np.arange(1.0, 41.0) / 40.0)
    surface = Surface(line, gap_function(contact.profile, line.equivalent), states)
    certificate = certify_disk(line, states)
    claims = normal_claims(
        certificate.disk, certificate.reason, _range_words(line, surface, certificate.disk)
    )
    largest = {
        "indentation": deepest,
        "normal_force": float(normal_force(line, states)[-1]),
        "contact_radius": float(np.max(states.contact_radius)),
    }
    return Assessment(claims, _assumptions(contact, mapped, states), mapped.notes, largest)


def _only_ends(leg: Ramp | Hold | Path) -> LoadingPath:
    if isinstance(leg, Path):
        channel = "indentation" if leg.indentation is not None else "normal_force"
        samples = np.asarray(getattr(leg, channel))
        chosen = np.unique([samples.argmin(), samples.argmax(), samples.size - 1])
        time = None if leg.time is None else leg.time[chosen]
        return Path(**{channel: samples[chosen], "time": time})
    return replace(leg, steps=1)


def foundation(
    contact: Contact, n: int = 400, *, half_length: QuantityLike | None = None
) -> SpringFoundation:
    """
    The discretised foundation of the founding paper: n springs of stiffness E* dx under g(x).

    It is how the method is taught; :func:`solve` uses the exact integrals instead.

    Parameters
    ----------
    contact : Contact
    n : int
        Number of springs, at least 2.
    half_length : quantity, optional
        Half the length of the line in m; a third of the profile's radius (or 1.2 edges) unless given.

    Returns
    -------
    SpringFoundation

    Raises
    ------
    ProblemError
        If `n` is not a whole number of at least 2, or no half length is given for a profile without one.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> springs = foundation(Contact(Paraboloid(1.0), Elastic(0.75, 0.5)), n=4000, half_length=1.0)
    >>> round(springs.normal_force(0.25), 5), round(springs.contact_radius(0.25), 3)
    (0.16667, 0.5)
    """
    if isinstance(n, bool) or not isinstance(n, int) or n < 2:
        raise ProblemError(f"foundation: n = {n!r} springs; a whole number of at least 2 is needed")
    line = map_to_line(contact).line
    if half_length is not None:
        length = to_si(half_length, "m", name="half_length")
    elif math.isfinite(line.equivalent.edge):
        length = 1.2 * line.equivalent.edge
    elif contact.profile.curvature_radius is not None:
        length = contact.profile.curvature_radius / 3.0
    else:
        raise ProblemError("foundation: this profile has no length of its own; give half_length='1 um' or so")
    if length <= 0.0:
        raise ProblemError(f"foundation: half_length = {length:g} m; it must be above 0 m")
    return spring_foundation(line, length, n)


def solve_batch(
    contacts: Sequence[Contact],
    path: LoadingPath,
    *,
    workers: int = 1,
    throw: bool = True,
    progress: Progress | None = None,
) -> list[Result | PymdrError]:
    """
    Solve many contacts along one path.

    Parameters
    ----------
    contacts : sequence of Contact
    path : LoadingPath
    workers : int
        Number of processes; 1 solves in this one.
    throw : bool
        Whether the first error ends the batch; otherwise errors take the place of results.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    list of Result (or PymdrError)
        In the order of `contacts`.

    Raises
    ------
    PymdrError
        The first error, if `throw`.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.paths import indent
    >>> from pymdr.problem.profiles import Paraboloid
    >>> balls = [Contact(Paraboloid(R), Elastic("1 MPa", 0.5)) for R in ("1 mm", "4 mm")]
    >>> forces = [float(r["normal_force"][-1]) for r in solve_batch(balls, indent("1 um"))]
    >>> round(forces[1] / forces[0], 12)
    2.0
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ProblemError(f"solve_batch: workers = {workers!r}; a whole number of at least 1 is needed")
    jobs = [(contact, path) for contact in contacts]
    answers: list[Result | PymdrError] = []
    if workers > 1:
        from concurrent.futures import ProcessPoolExecutor

        # what cannot be sent to another process, such as a lambda, is solved in this one
        travels = [_can_travel(job) for job in jobs]
        with ProcessPoolExecutor(workers) as pool:
            futures = [
                pool.submit(_solve_quietly, job) if away else None
                for job, away in zip(jobs, travels, strict=True)
            ]
            for job, future in zip(jobs, futures, strict=True):
                answer = _solve_quietly(job) if future is None else future.result()
                if isinstance(answer, Result):
                    answer = replace(answer, contact=job[0])
                _collect(answers, answer, throw, progress, len(jobs))
    else:
        for job in jobs:
            _collect(answers, _solve_quietly(job), throw, progress, len(jobs))
    return answers


def _can_travel(job: tuple[Contact, LoadingPath]) -> bool:
    try:
        pickle.dumps(job)
    except (AttributeError, TypeError, pickle.PicklingError):
        return False
    return True


def _solve_quietly(job: tuple[Contact, LoadingPath]) -> Result | PymdrError:
    try:
        return solve(*job)
    except PymdrError as error:
        return error


def _collect(
    answers: list[Result | PymdrError],
    answer: Result | PymdrError,
    throw: bool,
    progress: Progress | None,
    total: int,
) -> None:
    if throw and isinstance(answer, PymdrError):
        raise answer
    answers.append(answer)
    if progress is not None:
        progress(len(answers), total)
