"""The certificate of the disk: for every row whether the disk solution is the solution, and why not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pymdr.interpretation.disks import (
    RING,
    TOLERANCE,
    Landscape,
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
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, metres, written

_RINGS = 48
"""Most radii at which the ring beside a kink is computed; it shrinks as the contact grows."""
_NOISES = 3.0
"""How many noises either end of a fall may be off."""
_SLOPES = 1.7


@dataclass(frozen=True)
class Certificate:
    """Per step, whether the disk solution is the solution, and why not."""

    disk: BoolArray
    reason: str
    """Why some step is not a disk, or empty."""
    remark: str = ""
    """What a disk passes over that makes it an approximation, or empty."""
    error: FloatArray | None = None
    """Per step, what is passed over, as a share of the load."""


def with_rings(claims: Mapping[str, Claim], certificate: Certificate) -> dict[str, Claim]:
    """
    Claims of disks that pass over rings beside concave kinks.

    Numbers of the whole contact err by the share of the rings in the load; fields are other ones beside the kinks.

    Parameters
    ----------
    claims : mapping of str to Claim
    certificate : Certificate

    Returns
    -------
    dict of str to Claim
    """
    if certificate.error is None:
        return dict(claims)
    return {
        name: replace(claim, level=Level.APPROXIMATE)
        if claim.level is Level.EXACT and "r" in QUANTITIES[name].dims
        else claim
        for name, claim in approximated(claims, certificate.remark, certificate.error).items()
    }


def certify_disk(line: Line, states: DiskStates) -> Certificate:
    """
    Check that the disk solution is the solution: pressure >= 0 inside and gap >= 0 outside.

    Parameters
    ----------
    line : Line
    states : DiskStates
        The disks to be checked, best disks of their depths.

    Returns
    -------
    Certificate

    Notes
    -----
    From the intervals of depth of :func:`~pymdr.interpretation.disks.disk_depths`. A concave kink of f makes the
    pressure beside it logarithmically infinite, so that no disk over it is the solution to the letter; where the ring of
    tension is narrower than 1e-3 of the contact radius, the disk is called an approximation. Contacts on layers are read at the
    radii between which they are tabulated, up to the first that is no disk.

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
    found = disk_depths(line.equivalent, float(np.max(d, initial=-math.inf, where=np.isfinite(d))))
    # a contact presses its surfaces in, so where a disk seems to need no depth something else touches first
    lifted = (d <= 0.0) & (states.contact_radius > 0.0) & (states.contact_radius < line.equivalent.edge)
    if found.landscape is None:
        i = np.flatnonzero(lifted)[-1:]
        return Certificate(
            ~lifted,
            "".join(_lifted(float(x), float(r)) for x, r in zip(d[i], states.contact_radius[i], strict=True)),
        )
    disk = _among(found.nearly, d) & ~lifted
    bad = np.flatnonzero(~disk)
    reason = _why_not(found.landscape, states.take(slice(bad[-1], bad[-1] + 1))) if bad.size else ""
    passed = disk & ~_among(found.strict, d)
    if not passed.any():
        return Certificate(disk, reason)
    remark, error = _rings(found.landscape, states, passed)
    return Certificate(disk, reason, remark, error)


def _certify_layers(line: LayeredLine, states: DiskStates) -> Certificate:
    """Up to the first contact that is no disk."""
    a = states.contact_radius
    fault = first_fault(line, float(np.max(a, initial=0.0)), float(np.max(states.edge_excess, initial=0.0)))
    if fault is None:
        return Certificate(np.ones(a.shape, dtype=bool), "")
    return Certificate(a < fault.before, f"{fault.words}, so the contact is not a disk")


def certify_history(line: ElasticLine, deepest: float) -> Certificate:
    """
    Check that the contact is a disk at every depth between the first touch and a deepest one.

    Parameters
    ----------
    line : ElasticLine
    deepest : float
        In m.

    Returns
    -------
    Certificate
        Of one row, for the whole range.
    """
    found = disk_depths(line.equivalent, deepest)
    if found.landscape is None:
        return Certificate(np.ones(1, dtype=bool), "")
    # what happens before so little of the depth is felt by no later row
    left = [hole for hole in holes(found.nearly, deepest) if hole[1] > TOLERANCE * deepest]
    if left:
        at = np.array([0.5 * (left[0][0] + left[0][1])])
        return Certificate(np.zeros(1, dtype=bool), _why_not(found.landscape, states_at_depth(line, at)))
    # where g falls the contact steps over a ring, of which a sum of disks has no part; beside a concave kink, where the
    # ring is narrow all the way, it is a sum of disks for the kink with its ring filled
    g = line.equivalent.g(np.array([fall.stop for fall in found.landscape.falls]))
    steps = [
        fall
        for fall, lowest in zip(found.landscape.falls, g, strict=True)
        if fall.size > TOLERANCE * abs(lowest)
        and lowest < deepest
        and fall.start not in found.landscape.dents
    ]
    if steps:
        return Certificate(
            np.zeros(1, dtype=bool),
            f"at about d = {metres(float(line.equivalent.g(np.array([steps[0].start]))[0]))} the contact steps over a "
            f"ring at r = {metres(steps[0].start)}",
        )
    missing = holes(found.strict, deepest)
    if not missing:
        return Certificate(np.ones(1, dtype=bool), "")
    # rings are widest beside the first of these depths
    share = 2.0 ** -np.arange(0.0, _RINGS)
    depths = np.unique(np.concatenate([low + (high - low) * share for low, high in missing]))
    states = states_at_depth(line, depths[depths > 0.0])
    remark, error = _rings(found.landscape, states, np.ones(states.indentation.shape, dtype=bool))
    return Certificate(np.ones(1, dtype=bool), "", remark, np.max(error, initial=0.0, keepdims=True))


def valid_ranges(line: ElasticLine, deepest: float) -> list[tuple[float, float]]:
    """
    Force ranges in N in which the contact is a disk.

    Parameters
    ----------
    line : ElasticLine
    deepest : float
        Largest indentation in m.

    Returns
    -------
    list of (lowest, highest) force
    """
    found = disk_depths(line.equivalent, deepest)
    ends = np.array([(max(low, 0.0), min(high, deepest)) for low, high in found.nearly])
    ends = ends[ends[:, 1] > ends[:, 0]]
    forces = normal_force(line, states_at_depth(line, ends.ravel())).reshape(ends.shape)
    return [(float(low), float(high)) for low, high in forces if high > 0.0]


def describe_ranges(ranges: list[tuple[float, float]], deepest_force: float) -> str:
    """The valid load ranges in words."""
    way_out = (
        "; solve(..., solver=Rings()), in a case file [solve] solver = { kind = 'rings' }, solves it by boundary elements "
        "on rings"
    )
    if not ranges:
        return f"; it is a disk for no load up to {written(deepest_force, 'N')}{way_out}"
    words = [
        f"{written(low, 'N')} to {written(high, 'N')}"
        if not math.isclose(high, deepest_force)
        else f"{written(low, 'N')} and more"
        for low, high in ranges
    ]
    return f"; it is a disk for loads of {', '.join(words)} (looked for up to {written(deepest_force, 'N')}){way_out}"


def noise_words(profile: Profile, equivalent: EquivalentProfile, deepest: float) -> str:
    """What to do about falls of g that are no more than the noise of samples; empty where they are more."""
    parts = profile.parts if hasattr(profile, "parts") else (profile,)
    sampled = [part for part in parts if isinstance(part, Sampled)]
    landscape = disk_depths(equivalent, deepest).landscape
    if not sampled or landscape is None:
        return ""
    noise = math.sqrt(sum(part.noise**2 for part in sampled))
    spacing = min(float(np.median(np.diff(part.radius))) for part in sampled)
    falls = [fall for fall in landscape.falls if fall.size > 0.0]
    if not falls:
        return ""
    worst = max(falls, key=lambda fall: fall.size)
    where = (
        f"; the equivalent profile falls by {metres(worst.size)} between r = {metres(worst.start)} and "
        f"{metres(worst.stop)}"
    )
    # slopes of a curve through noise err by 1.7 noises in a spacing h, which makes errors of sqrt(2 x/h) slopes of g
    errors = _SLOPES * noise * max(math.sqrt(2.0 * worst.stop / spacing), 1.0)
    if worst.size > 2.0 * _NOISES * errors:
        return f"{where}, more than the noise of the samples, {metres(noise)}, explains"
    return (
        f"{where}, which the noise of the samples, {metres(noise)}, explains: smooth them with "
        "Sampled(..., interpolation=SmoothingSpline())"
    )


def _among(intervals: tuple[tuple[float, float], ...], d: FloatArray) -> BoolArray:
    """Whether depths are in some interval, but for rounding."""
    inside = np.zeros(d.shape, dtype=bool)
    for low, high in intervals:
        slack = 1e-14 * np.abs(d)
        inside |= (d >= low - slack) & (d <= high + slack)
    return inside


def _lifted(d: float, a: float) -> str:
    return (
        f"at d = {metres(d)} a disk of radius {metres(a)} would need no depth, so something else touches first and the "
        "contact is not a disk"
    )


def _why_not(landscape: Landscape, state: DiskStates) -> str:
    """Why the disk of one row is not the solution, in words."""
    a, d, excess = (float(x[0]) for x in (state.contact_radius, state.indentation, state.edge_excess))
    where = f"at d = {metres(d)}"
    if d <= 0.0 < a < landscape.equivalent.edge:
        return _lifted(d, a)
    if a > 0.0:
        with np.errstate(divide="ignore", invalid="ignore"):
            tension = least_pressure(landscape, a, excess, loose=True)
        if tension.value < -landscape.tolerance:
            beside = [b for b in landscape.dents if abs(tension.radius - b) <= 2.0 * RING * a]
            kink = f", beside the concave kink at {metres(beside[0])}" if beside else ""
            return (
                f"{where} a disk of radius {metres(a)} would need tension at r = {metres(tension.radius)}{kink}, "
                "so the contact is not a disk"
            )
    if a < min(landscape.top, landscape.equivalent.edge):
        touch = least_gap(landscape, a, excess, loose=True)
        return (
            f"{where} the surfaces touch again outside a disk of radius {metres(a)}, at r = {metres(touch.radius)}, "
            "so the contact is not a disk"
        )
    return f"{where} no disk satisfies the conditions of contact, so the contact is not a disk"


def _rings(landscape: Landscape, states: DiskStates, passed: BoolArray) -> tuple[str, FloatArray]:
    """The rings beside concave kinks that disks pass over, in words, and their shares of the load."""
    error = np.zeros(passed.shape)
    order = np.flatnonzero(passed)[np.argsort(states.contact_radius[passed], kind="stable")]
    if order.size == 0:
        return "", error
    picked = np.unique(np.linspace(0, order.size - 1, min(order.size, _RINGS)).astype(int))
    found = [_ring(landscape, states.take(slice(order[i], order[i] + 1))) for i in picked]
    # rings shrink as the disk grows, so that of the next smaller disk bounds them
    which = np.searchsorted(picked, np.arange(order.size), side="right") - 1
    error[order] = np.array([share for _, _, share in found])[which]
    kink, width, share = max(found, key=lambda ring: ring[2])
    size = f"{metres(width)} wide" if width > 0.0 else "too narrow for its width to be written"
    return (
        f"; beside the concave kink at r = {metres(kink)} the disk passes over a ring of tension or overlap {size}, "
        f"which is {share:.1e} of the load",
        error,
    )


def _ring(landscape: Landscape, state: DiskStates) -> tuple[float, float, float]:
    """Radius of the worst kink, width of its ring in m, and the share of all rings in the load."""
    equivalent = landscape.equivalent
    a, excess = float(state.contact_radius[0]), float(state.edge_excess[0])
    jumps = {0.0: apex_kink(equivalent)} | dict(equivalent.corners(landscape.top))
    moment = float(equivalent.moment(state.place)[0]) + a * excess
    worst, total = (0.0, 0.0, -1.0), 0.0
    inside = np.array([b for b in landscape.dents if b < a])
    turns = np.abs([jumps[b] for b in inside.tolist()])
    widths = iter(_widths(landscape, state.place.take(0), excess, inside, turns).tolist())
    for b in landscape.dents:
        if b >= a:
            share, width = _overlap_beside(landscape, a, b)
        else:
            width = next(widths)
            # at the apex the ring is a disk
            share = 0.5 * max(b, width) * abs(jumps[b]) * width / moment if moment > 0.0 else 1.0
        total += share
        if share > worst[2]:
            worst = (b, width, share)
    return worst[0], worst[1], total


def _widths(landscape: Landscape, a: Place, excess: float, b: FloatArray, jump: FloatArray) -> FloatArray:
    """
    Widths in m of the rings about concave kinks between which the pressure is no pressure; 0 if less than any number.

    There p = (E*/pi) [q + (jump/2) log(1/distance)], so Newton steps in the logarithm converge at once.
    """
    edge = float(a.x)
    kink, size, side = np.tile(b, 2), np.tile(jump, 2), np.repeat([-1.0, 1.0], b.size)
    with np.errstate(divide="ignore"):
        most = np.log(0.5 * np.where(side > 0.0, edge - kink, kink))
    log = np.minimum(most, math.log(0.5 * RING * edge))
    left = np.flatnonzero(np.isfinite(most))
    for _ in range(30):
        if left.size == 0:
            break
        at = Place(kink[left], side[left] * np.exp(log[left]))
        q = landscape.equivalent.pressure_integral(at, a)
        if excess > 0.0:
            q = q + excess / np.sqrt((edge - kink[left]) * (edge + kink[left]))
        new = np.minimum(log[left] - 2.0 * q / size[left], most[left])
        going = (new >= _NO_LENGTH) & (np.abs(new - log[left]) >= 1e-9)
        log[left] = new
        left = left[going]
    distance = np.where(log < _NO_LENGTH, 0.0, np.exp(log))
    return np.asarray(distance.reshape(2, -1).sum(axis=0))


_NO_LENGTH = -650.0
"""Logarithm of a distance that no number holds."""


def _overlap_beside(landscape: Landscape, a: float, b: float) -> tuple[float, float]:
    """Overlap over the indentation, and its width in m, behind a concave kink just outside the disk."""
    half = 0.5 * RING * a
    if b - a > half:
        return 0.0, 0.0
    r = max(b, a) + half * 4.0 ** -np.arange(0.0, 20.0, 0.25)
    r = r[r < landscape.top]
    h = gap_ratios(landscape, a, 0.0, r) if r.size else np.zeros(0)
    over = r[h < 0.0]
    return (float(-h.min()), float(over.max() - over.min())) if over.size else (0.0, 0.0)
