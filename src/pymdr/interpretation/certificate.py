"""The certificate of the disk: for every row whether the disk solution is the solution, with the reason if not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pymdr.interpretation.disks import (
    RING,
    TOLERANCE,
    ProfileFeatures,
    apex_kink,
    disk_depths,
    gap_ratios,
    holes,
    least_gap,
    least_pressure,
)
from pymdr.interpretation.layers import first_fault
from pymdr.interpretation.validity import Claim, Level, approximated
from pymdr.line.curves import Line
from pymdr.line.foundation import DiskStates, ElasticLine, normal_force, states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.panels import BoolArray, Place
from pymdr.problem.profiles import Profile, Sampled
from pymdr.problem.profiles.sampled import SMOOTHED
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, metres, written

_MAX_RINGS = 48
"""Largest number of contact radii at which the rings next to kinks are computed; they shrink as the contact grows."""
_MAX_NOISE_RATIO = 3.0
"""Largest error of either end of a decreasing interval, over the noise."""
_SLOPE_ERROR = 1.7


@dataclass(frozen=True)
class Certificate:
    """Per step, whether the disk solution is the solution, with the reason if not."""

    disk: BoolArray
    reason: str
    """Why some step is not a disk, or empty."""
    remark: str = ""
    """Which rings the disk neglects, which makes it an approximation; or empty."""
    error: FloatArray | None = None
    """Per step, the neglected fraction of the load."""


def with_rings(claims: Mapping[str, Claim], certificate: Certificate) -> dict[str, Claim]:
    """
    Claims of disks that neglect rings next to concave kinks.

    The relative error of integral quantities is the fraction of the load on the rings; fields differ next to the kinks, and
    have that error elsewhere.
    """
    if certificate.error is None:
        return dict(claims)
    return {
        name: replace(claim, level=Level.APPROXIMATE, excluded="the rings next to concave kinks")
        if claim.level is not Level.NOT_VALID and "r" in QUANTITIES[name].dims
        else claim
        for name, claim in approximated(claims, certificate.remark, certificate.error).items()
    }


def certify_disk(line: Line, states: DiskStates) -> Certificate:
    """
    Check that the disk solution is the solution: pressure >= 0 inside and gap >= 0 outside.

    Parameters
    ----------
    states : DiskStates
        The disks to be checked; at their depths they carry the largest force.

    Notes
    -----
    From the intervals of depth of :func:`~pymdr.interpretation.disks.disk_depths`. The pressure next to a concave kink of f
    is logarithmically infinite, so that no disk over it is the exact solution; where the ring of tension is narrower than
    1e-3 of the contact radius, the disk is an approximation. Contacts on layers are checked at the radii of their table, up
    to the first that is not a disk.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> certify_disk(line, states_at_depth(line, [1.0, 2.0])).disk.tolist()
    [True, True]
    """
    if isinstance(line, LayeredLine):
        return _certify_layers(line, states)
    d = states.indentation
    depths = disk_depths(line.equivalent, float(np.max(d, initial=-math.inf, where=np.isfinite(d))))
    # contact needs a positive depth, so for a disk at d <= 0 other points touch first
    lifted = (d <= 0.0) & (states.contact_radius > 0.0) & (states.contact_radius < line.equivalent.edge)
    if depths.features is None:
        i = np.flatnonzero(lifted)[-1:]
        return Certificate(
            ~lifted,
            "".join(_lifted(float(x), float(r)) for x, r in zip(d[i], states.contact_radius[i], strict=True)),
        )
    disk = _among(depths.nearly, d) & ~lifted
    bad = np.flatnonzero(~disk)
    reason = _why_not(depths.features, states.take(slice(bad[-1], bad[-1] + 1))) if bad.size else ""
    passed = disk & ~_among(depths.strict, d)
    if not passed.any():
        return Certificate(disk, reason)
    remark, error = _rings(depths.features, states, passed)
    return Certificate(disk, reason, remark, error)


def _certify_layers(line: LayeredLine, states: DiskStates) -> Certificate:
    """Certify all rows before the first contact that is not a disk."""
    a = states.contact_radius
    fault = first_fault(line, float(np.max(a, initial=0.0)), float(np.max(states.edge_excess, initial=0.0)))
    if fault is None:
        return Certificate(np.ones(a.shape, dtype=bool), "")
    return Certificate(a < fault.before, f"{fault.description}, so the contact is not a disk")


def certify_history(line: ElasticLine, deepest: float) -> Certificate:
    """
    Check that the contact is a disk at every depth from the first touch to the deepest.

    Parameters
    ----------
    deepest : float
        In m.

    Returns
    -------
    Certificate
        Of one row, for the whole range.
    """
    intervals = disk_depths(line.equivalent, deepest)
    if intervals.features is None:
        return Certificate(np.ones(1, dtype=bool), "")
    # intervals this small have no effect on later rows
    left = [hole for hole in holes(intervals.nearly, deepest) if hole[1] > TOLERANCE * deepest]
    if left:
        at = np.array([0.5 * (left[0][0] + left[0][1])])
        return Certificate(np.zeros(1, dtype=bool), _why_not(intervals.features, states_at_depth(line, at)))
    # where g decreases the contact jumps over a ring, which no sum of disks represents; next to a concave kink the ring is
    # narrow throughout, and a sum of disks represents the kink with its ring filled
    g = line.equivalent.g(np.array([interval.stop for interval in intervals.features.decreasing]))
    steps = [
        interval
        for interval, lowest in zip(intervals.features.decreasing, g, strict=True)
        if interval.drop > TOLERANCE * abs(lowest)
        and lowest < deepest
        and interval.start not in intervals.features.concave_kinks
    ]
    if steps:
        return Certificate(
            np.zeros(1, dtype=bool),
            f"at about d = {metres(float(line.equivalent.g(np.array([steps[0].start]))[0]))} the contact jumps over a "
            f"ring at r = {metres(steps[0].start)}",
        )
    missing = holes(intervals.strict, deepest)
    if not missing:
        return Certificate(np.ones(1, dtype=bool), "")
    # rings are widest at the first of these depths
    fraction = 2.0 ** -np.arange(0.0, _MAX_RINGS)
    sampled = np.unique(np.concatenate([low + (high - low) * fraction for low, high in missing]))
    states = states_at_depth(line, sampled[sampled > 0.0])
    remark, error = _rings(intervals.features, states, np.ones(states.indentation.shape, dtype=bool))
    return Certificate(np.ones(1, dtype=bool), "", remark, np.max(error, initial=0.0, keepdims=True))


def valid_ranges(line: ElasticLine, deepest: float) -> list[tuple[float, float]]:
    """
    Force ranges in N in which the contact is a disk.

    Parameters
    ----------
    deepest : float
        Largest indentation in m.
    """
    depths = disk_depths(line.equivalent, deepest)
    ends = np.array([(max(low, 0.0), min(high, deepest)) for low, high in depths.nearly])
    ends = ends[ends[:, 1] > ends[:, 0]]
    forces = normal_force(line, states_at_depth(line, ends.ravel())).reshape(ends.shape)
    return [(float(low), float(high)) for low, high in forces if high > 0.0]


def describe_ranges(ranges: list[tuple[float, float]], deepest_force: float) -> str:
    """Description of the valid load ranges."""
    remedy = "; use solve(..., solver=Rings()), in a case file [solve] solver = { kind = 'rings' }, for boundary elements on rings"
    if not ranges:
        return f"; it is a disk for no load up to {written(deepest_force, 'N')}{remedy}"
    texts = [
        f"{written(low, 'N')} to {written(high, 'N')}"
        if not math.isclose(high, deepest_force)
        else f"{written(low, 'N')} and more"
        for low, high in ranges
    ]
    return f"; it is a disk for loads of {', '.join(texts)} (searched up to {written(deepest_force, 'N')}){remedy}"


def noise_remark(profile: Profile, equivalent: EquivalentProfile, deepest: float) -> str:
    """Whether the noise of samples explains the largest decrease of g, and the remedy; empty without samples."""
    parts = profile.parts if hasattr(profile, "parts") else (profile,)
    sampled = [part for part in parts if isinstance(part, Sampled)]
    features = disk_depths(equivalent, deepest).features
    if not sampled or features is None:
        return ""
    noise = math.sqrt(sum(part.noise**2 for part in sampled))
    spacing = min(float(np.median(np.diff(part.radius))) for part in sampled)
    decreasing = [interval for interval in features.decreasing if interval.drop > 0.0]
    if not decreasing:
        return ""
    worst = max(decreasing, key=lambda interval: interval.drop)
    where = (
        f"; the equivalent profile decreases by {metres(worst.drop)} between r = {metres(worst.start)} and "
        f"{metres(worst.stop)}"
    )
    # the slopes of a curve through noisy samples of spacing h err by 1.7 noise / h, which g accumulates by sqrt(2 x/h)
    errors = _SLOPE_ERROR * noise * max(math.sqrt(2.0 * worst.stop / spacing), 1.0)
    if worst.drop > 2.0 * _MAX_NOISE_RATIO * errors:
        return f"{where}, more than the noise of the samples ({metres(noise)}) can cause"
    return f"{where}, which the noise of the samples ({metres(noise)}) can cause: {SMOOTHED}"


def _among(intervals: tuple[tuple[float, float], ...], d: FloatArray) -> BoolArray:
    """Whether depths are in some interval, up to rounding."""
    inside = np.zeros(d.shape, dtype=bool)
    for low, high in intervals:
        slack = 1e-14 * np.abs(d)
        inside |= (d >= low - slack) & (d <= high + slack)
    return inside


def _lifted(d: float, a: float) -> str:
    """Reason for a disk that would need no positive depth."""
    return (
        f"at d = {metres(d)} a disk of radius {metres(a)} would need no positive depth, so other points touch first and the "
        "contact is not a disk"
    )


def _why_not(features: ProfileFeatures, state: DiskStates) -> str:
    """Why the disk of one row is not the solution."""
    a, d, excess = (float(x[0]) for x in (state.contact_radius, state.indentation, state.edge_excess))
    where = f"at d = {metres(d)}"
    if d <= 0.0 < a < features.equivalent.edge:
        return _lifted(d, a)
    if a > 0.0:
        with np.errstate(divide="ignore", invalid="ignore"):
            tension = least_pressure(features, a, excess, loose=True)
        if tension.value < -features.tolerance:
            adjacent = [b for b in features.concave_kinks if abs(tension.radius - b) <= 2.0 * RING * a]
            kink = f", next to the concave kink at {metres(adjacent[0])}" if adjacent else ""
            return (
                f"{where} a disk of radius {metres(a)} would need tension at r = {metres(tension.radius)}{kink}, "
                "so the contact is not a disk"
            )
    if a < min(features.top, features.equivalent.edge):
        touch = least_gap(features, a, excess, loose=True)
        return (
            f"{where} the surfaces touch again outside a disk of radius {metres(a)}, at r = {metres(touch.radius)}, "
            "so the contact is not a disk"
        )
    return f"{where} no disk satisfies the conditions of contact, so the contact is not a disk"


def _rings(features: ProfileFeatures, states: DiskStates, passed: BoolArray) -> tuple[str, FloatArray]:
    """Description of the rings next to concave kinks that disks neglect, and their fractions of the load."""
    error = np.zeros(passed.shape)
    order = np.flatnonzero(passed)[np.argsort(states.contact_radius[passed], kind="stable")]
    if order.size == 0:
        return "", error
    picked = np.unique(np.linspace(0, order.size - 1, min(order.size, _MAX_RINGS)).astype(int))
    rings = [_ring(features, states.take(slice(order[i], order[i] + 1))) for i in picked]
    # rings shrink as the disk grows, so the ring of the next smaller disk is a bound
    next_smaller = np.searchsorted(picked, np.arange(order.size), side="right") - 1
    error[order] = np.array([fraction for _, _, fraction in rings])[next_smaller]
    kink, width, fraction = max(rings, key=lambda ring: ring[2])
    size = f"{metres(width)} wide" if width > 0.0 else "narrower than the smallest floating-point number"
    return (
        f"; next to the concave kink at r = {metres(kink)} the disk neglects a ring of tension or overlap {size}, "
        f"with {fraction:.1e} of the load",
        error,
    )


def _ring(features: ProfileFeatures, state: DiskStates) -> tuple[float, float, float]:
    """Radius of the worst kink, width of its ring in m, and the fraction of the load on all rings."""
    equivalent = features.equivalent
    a, excess = float(state.contact_radius[0]), float(state.edge_excess[0])
    jumps = {0.0: apex_kink(equivalent)} | dict(equivalent.corners(features.top))
    moment = float(equivalent.moment(state.place)[0]) + a * excess
    worst, total = (0.0, 0.0, -1.0), 0.0
    inside = np.array([b for b in features.concave_kinks if b < a])
    turns = np.abs([jumps[b] for b in inside.tolist()])
    widths = iter(_widths(features, state.place.take(0), excess, inside, turns).tolist())
    for b in features.concave_kinks:
        if b >= a:
            fraction, width = _overlap_at_kink(features, a, b)
        else:
            width = next(widths)
            # at the apex the ring is a disk
            fraction = 0.5 * max(b, width) * abs(jumps[b]) * width / moment if moment > 0.0 else 1.0
        total += fraction
        if fraction > worst[2]:
            worst = (b, width, fraction)
    return worst[0], worst[1], total


def _widths(
    features: ProfileFeatures, a: Place, excess: float, b: FloatArray, jump: FloatArray
) -> FloatArray:
    """
    Widths in m of the rings of tension about concave kinks; 0 on underflow.

    There p = (E*/pi) [q + (jump/2) log(1/distance)], so Newton steps in the logarithm converge quickly.
    """
    edge = float(a.x)
    kink, size, side = np.tile(b, 2), np.tile(jump, 2), np.repeat([-1.0, 1.0], b.size)
    with np.errstate(divide="ignore"):
        widest = np.log(0.5 * np.where(side > 0.0, edge - kink, kink))
    log = np.minimum(widest, math.log(0.5 * RING * edge))
    active = np.flatnonzero(np.isfinite(widest))
    for _ in range(30):
        if active.size == 0:
            break
        at = Place(kink[active], side[active] * np.exp(log[active]))
        q = features.equivalent.pressure_integral(at, a)
        if excess > 0.0:
            q = q + excess / np.sqrt((edge - kink[active]) * (edge + kink[active]))
        new = np.minimum(log[active] - 2.0 * q / size[active], widest[active])
        unsettled = (new >= _NO_LENGTH) & (np.abs(new - log[active]) >= 1e-9)
        log[active] = new
        active = active[unsettled]
    distance = np.where(log < _NO_LENGTH, 0.0, np.exp(log))
    return np.asarray(distance.reshape(2, -1).sum(axis=0))


_NO_LENGTH = -650.0
"""Logarithm of a distance that underflows."""


def _overlap_at_kink(features: ProfileFeatures, a: float, b: float) -> tuple[float, float]:
    """Overlap over the indentation, and its width in m, at a concave kink just outside the disk."""
    half = 0.5 * RING * a
    if b - a > half:
        return 0.0, 0.0
    r = max(b, a) + half * 4.0 ** -np.arange(0.0, 20.0, 0.25)
    r = r[r < features.top]
    h = gap_ratios(features, a, 0.0, r) if r.size else np.zeros(0)
    over = r[h < 0.0]
    return (float(-h.min()), float(over.max() - over.min())) if over.size else (0.0, 0.0)
