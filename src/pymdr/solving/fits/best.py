"""The smallest misfit of a fit from several starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.laws import Coulomb
from pymdr.solving.curves.baselines import CHECK_SIGNS
from pymdr.solving.fits.determining import more_samples_text
from pymdr.solving.fits.families import RANGES, FamilyAxes, Ladder, whole_ladder
from pymdr.solving.fits.forces import forces_of
from pymdr.solving.fits.kernels import BASE, POINT, point_across_samples, start_near
from pymdr.solving.fits.kernels import TILT as TILTED
from pymdr.solving.fits.limits import Limit, starts_from_limits
from pymdr.solving.fits.minimizing import TOLERANCE, Minimum, minimize_from
from pymdr.solving.fits.quick import depth_ranges, fit_by_family, table_of, wanted_of
from pymdr.solving.fits.records import ListedCurves, Stretch
from pymdr.solving.fits.request import (
    AT_END,
    FITTED,
    NO_CONTACT,
    SEEN,
    Columns,
    FitRequest,
    fewest_in_contact,
)
from pymdr.solving.fits.searching import Modelled, Search
from pymdr.solving.fits.starting import Start, edge_starts, is_pressed_once, pressed_once, starts
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    TILT,
    WORKS,
    put_into,
)
from pymdr.units import FloatArray, written

_STARTS, _NEAR, _COARSE, _SOME, _FINE = 4, 2, 14, 28, 9
_LIKE_NOISE = 1.0
"""Smallest ratio of squared differences between neighbours to squared residuals of noise; 2 for white noise."""
_BOUNDED = f", or free both {' and '.join(WORKS)}: a fixed one bounds the other"
_CROSSINGS = 4
"""Largest number of searches for contact points beyond other samples."""
_SLIGHTLY = 1e-4
"""Relative decrease of the sum of squares with which a search across samples goes on."""
_FINE_ENOUGH = 1e-3
"""Tolerance of a sum of squares that is compared with a limit, relative to that limit."""
_FROM_FAMILY = 1e-5
"""Tolerance of the sum of squares of a search from the end of that over a family or of a limit: it is compared with a limit, and the last search goes on from its end."""
_AS_WELL = 1e-11
"""Relative difference below which two sums of squares are equal."""


class End(NamedTuple):
    """The end of a search."""

    misfit: float
    """In N^2."""
    free: FloatArray
    wide: FloatArray
    """Standard errors of the free numbers where the distance of equally good ends exceeds the curvature's; else 0."""
    scanned: tuple[FloatArray, ...] = ()
    """The free numbers of the ends with fixed ranges, if the range or strength is unknown."""
    limits: tuple[Limit, ...] = ()
    """The limits of the law, if the range or strength is unknown."""


def best_end(search: Search, tolerance: float = TOLERANCE) -> End:
    """The smallest misfit of searches from several starts, to a relative tolerance; approximate for bodies with memory."""
    quick = _quick_start(search)
    nearby = None if quick is not None else starts_from_limits(search, _end_near)
    monotone = _with_monotone_records(search)
    once = search.contact.has_edge_history or (
        not search.shears and all(map(is_pressed_once, search.measured))
    )
    followed = search if once else monotone
    if quick is not None:
        starts_by_curve = [quick[0]]
    elif nearby is not None:
        starts_by_curve = [own[:_NEAR] for own in nearby.starts]
    elif search.contact.has_edge_history:
        starts_by_curve = edge_starts(search, _STARTS)
    else:
        starts_by_curve = [
            starts(monotone.contact, monotone.unknowns, curve, monotone.known, _STARTS)
            for curve in monotone.curves
        ]
    if (quick is not None or nearby is not None) and not followed.jumps:
        tolerance = max(tolerance, _FROM_FAMILY)
    ends = []
    for rank in range(max(map(len, starts_by_curve))):
        chosen = [own[min(rank, len(own) - 1)] for own in starts_by_curve]
        ends.append(minimize_from(followed, _free_of(followed, chosen), tolerance=tolerance))
        if search.contact.has_edge_history and _is_explained(followed, ends[-1].free):
            break  # a search takes seconds
    if followed.jumps:
        ends.append(_across_samples(followed, min(ends, key=lambda end: end.misfit)))
    least = min(end.misfit for end in ends)
    signed = np.array([not u.is_size for u in search.unknowns] + [False] * search.origin_scales.size)
    # of equally good ends, as with Poisson's ratios of either sign, the nearest to the start
    best, misfit, *_ = min(
        (end for end in ends if end.misfit <= least * (1.0 + _AS_WELL)),
        key=lambda end: (float((end.free[signed] ** 2).sum()), end.misfit),
    )
    values, origin = followed.from_free(best)
    pulled = quick if search.contact.adhesion is not None else None
    wide = np.zeros(len(search.names)) if pulled is None else pulled[1]
    end = End(misfit, search.to_free(values.tolist(), origin), wide)
    if nearby is None or not any(u.name in RANGES for u in search.unknowns):
        return end
    scanned = tuple(_free_of(search, own) for own in zip(*nearby.starts, strict=True))
    return end._replace(scanned=scanned, limits=tuple(nearby.limits))


def _end_near(search: Search) -> tuple[float, FloatArray]:
    """The smallest misfit in N^2 and its free numbers, as a start: those of a search over a family are not polished."""
    quick = _quick_start(search, _SOME)
    if quick is None:
        return best_end(search)[:2]
    (one, *_), _ = quick
    free = search.to_free(one.values.tolist(), [_origins_of(search, one)])
    return float((search.residuals(free) ** 2).sum()), free


def _free_of(search: Search, chosen: Sequence[Start]) -> FloatArray:
    """The free numbers of a start of each curve."""
    return search.to_free(chosen[0].values.tolist(), [_origins_of(search, one) for one in chosen])


def _origins_of(search: Search, start: Start) -> dict[str, float]:
    """The origins of a start by name."""
    return {search.place: start.origin, BASELINE: start.baseline, TILT: start.tilt}


def _is_explained(search: Search, free: FloatArray) -> bool:
    """Whether residuals differ between neighbours as much as on the whole, as noise does (von Neumann 1941)."""
    left = search.residuals(free)
    return float((np.diff(left) ** 2).sum()) > _LIKE_NOISE * float((left**2).sum())


def _across_samples(search: Search, minimum: Minimum) -> Minimum:
    """
    The end of a search with contact points moved across samples, where the misfit of a constant pull jumps.

    Only of indentations: on a machine the record decides which samples are in contact.
    """
    if not search.jumps or search.place in search.known:
        return minimum
    for _ in range(_CROSSINGS):
        moved = moved_across_samples(search, minimum.free)
        if np.array_equal(moved, minimum.free):
            break
        other = minimize_from(search, moved)
        if other.misfit >= minimum.misfit * (1.0 - _SLIGHTLY):
            break
        minimum = other
    return minimum


def moved_across_samples(search: Search, free: FloatArray) -> FloatArray:
    """Free numbers with the contact points at which the other numbers fit best, if the force jumps there."""
    on_machine = all(one.compliance != 0.0 for one in search.measured)
    if not search.jumps or search.place in search.known or on_machine:
        return free
    values, origins = search.from_free(free)
    contact = put_into(search.contact, search.unknowns, values)
    moved = [dict(one) for one in origins]
    for own, curve, one in zip(moved, search.measured, search.models(free), strict=True):
        if curve.compliance == 0.0:
            forces = forces_of(contact, float(np.ptp(curve.depth)), 0.0, None)
            own[search.place] = point_across_samples(curve.position, one.force, own[search.place], forces)
    return free if moved == origins else search.to_free(values.tolist(), moved)


def _with_monotone_records(search: Search) -> Search:
    """The search with records of bodies with memory as one approach and one retreat, if they are; these are solved much faster."""
    if not search.contact.is_viscoelastic or search.shears:
        return search
    curves = [pressed_once(one, search.known.get(BASELINE)) for one in search.measured]
    monotone = tuple(one for one in curves if one is not None)
    return replace(search, curves=monotone) if len(monotone) == len(search.curves) else search


def soft_machine_text(place: FloatArray, force: FloatArray, softness: float) -> str:
    """Hint on the spring constant if the machine deflects more than it travels while the force rises."""
    top = int(np.nanargmax(force))
    rise_start = int(
        np.nanargmin(np.where(force > 0.9 * np.nanmin(force) + 0.1 * force[top], place, math.nan))
    )
    rise, travel = float(force[top] - force[rise_start]), float(place[top] - place[rise_start])
    if softness == 0.0 or not 0.0 < travel < softness * rise:
        return ""
    return (
        f"a machine of {written(1.0 / softness, 'N/m', 3)} deflects more than its travel of {written(travel, 'm', 3)} while the force rises by "
        f"{written(rise, 'N', 3)}: check spring_constant; "
    )


def _quick_start(search: Search, rungs: int | None = None) -> tuple[list[Start], FloatArray] | None:
    """Starts from the end of a search over a family of forces, of some rungs, and the errors of its free numbers, if it applies and succeeds."""
    unknowns = search.unknowns
    curves = ListedCurves(search.measured)
    at_start = put_into(search.contact, unknowns, np.array([u.start for u in unknowns]))
    request = FitRequest(at_start, unknowns, search.known, {}, [u.name for u in unknowns])
    axes = request.axes
    if axes is None or not unknowns or len(curves.curves) != 1:
        return None
    stretch = curves.read(0, 1)
    law = search.contact.adhesion
    if (law is not None and law.cohesive_stress is not None) or _is_of_layers(request, axes):
        request = _nearby(request, axes, stretch)
    elif rungs is not None and axes.number is not None:
        whole = whole_ladder(request.contact, axes.number, float(depth_ranges(stretch)[0]))
        request = replace(request, ladder=whole._replace(rungs=rungs))
    fitted = fit_by_family(request, axes, stretch).columns
    if fitted["ending"][0] == AT_END and request.ladder is not None and _is_of_layers(request, axes):
        # coarse steps may lead to another place
        fitted = fit_by_family(replace(request, ladder=None), axes, stretch).columns
    if fitted["ending"][0] == NO_CONTACT:
        raise ProblemError(
            f"the record shows no contact: a constant force increases the sum of squares by less than {SEEN:g} variances of "
            f"the noise; {soft_machine_text(stretch.place[0], stretch.force[0], float(stretch.softness[0]))}{_turned_text(search)}press deeper, {more_samples_text(search)}mark outliers, or {CHECK_SIGNS}"
        )
    if fitted["ending"][0] == AT_END:
        _refuse_beyond_layers(request, axes, stretch)
    if fitted["ending"][0] != FITTED and not _is_inside(request, axes, fitted):
        return None
    origin = {name: float(fitted[name][0]) for name in request.origins}
    values = np.array([fitted[u.name][0] for u in unknowns])
    scales = [*(u.rate(float(v)) for u, v in zip(unknowns, values, strict=True)), *search.origin_scales]
    errors = np.array([fitted[f"{name}_error"][0] for name in request.names]) / scales
    start = Start(0.0, values, *(origin.get(name, 0.0) for name in (CONTACT_POINT, BASELINE, TILT)))
    return [start, *_starts_with_all_samples(request, axes, stretch, start)], errors


def _starts_with_all_samples(
    request: FitRequest, axes: FamilyAxes, stretch: Stretch, start: Start
) -> list[Start]:
    """
    The best place near a start for a constant pull over indentations; else none.

    The end of a search without the samples beside a jump may be samples beyond it, from where a search with all samples does not return.
    """
    wanted = wanted_of(request, axes)
    if not (wanted.pulled and wanted.free[POINT]) or stretch.softness[0] != 0.0:
        return []
    good = np.isfinite(stretch.place[0]) & np.isfinite(stretch.force[0])
    place, force = stretch.place[0][good], stretch.force[0][good]
    middle = 0.5 * (place.min() + place.max()) if wanted.free[TILTED] else 0.0
    theta = np.array([0.0, 0.0, start.origin - middle, start.baseline, start.tilt])
    family = table_of(next(iter(request.families.values())))
    near = start_near(place - middle, force, wanted, family, theta)
    values = axes.values(near[None, 0], near[None, 1])[0][0]
    return [Start(0.0, values, near[POINT] + middle, near[BASE], near[TILTED])]


def _turned_text(search: Search) -> str:
    """Hint on the signs if the force of a record was turned."""
    steps = [step for curve in search.measured for step in curve.steps if step.name == "signs"]
    if not any(step.numbers.get("force") == -1.0 for step in steps):
        return ""
    return "the sign of its force was reversed: if compression was positive, keep it with keep_signs; "


def _is_inside(request: FitRequest, axes: FamilyAxes, fitted: Columns) -> bool:
    """Whether a fit ended because the record shows little of the adhesion, with a number inside of the family: a start like others."""
    values = np.array([[fitted[u.name][0] for u in request.unknowns]])
    if fitted["ending"][0] != AT_END or request.contact.adhesion is None or not np.isfinite(values).all():
        return False
    (number,) = axes.numbers(values)
    family = next(iter(request.families.values()))
    last = family.first + family.step * (family.folds.size - 1)
    return bool(family.first + family.step < number < last - family.step)


def _is_of_layers(request: FitRequest, axes: FamilyAxes) -> bool:
    """Whether an unknown is a length on layers, whose map depends on it."""
    return request.contact.layered is not None and axes.number is not None and axes.number.unit == "m"


def _refuse_beyond_layers(request: FitRequest, axes: FamilyAxes, stretch: Stretch) -> None:
    """Refuse a length on layers beyond the range that is tried."""
    number = axes.number
    if number is None or not _is_of_layers(request, axes) or math.isfinite(number.high):
        return
    tried = whole_ladder(request.contact, number, float(depth_ranges(stretch)[0]))
    low, high = (written(number.from_free(free), number.unit, 4) for free in (tried.first, tried.last))
    raise ProblemError(
        f"the best {number.name} is not between {low} and {high}, a tenth and ten times its start; start nearer to it, give bounds in "
        "free, or leave it out of free; if it diverges, the record determines only its combination with the modulus, or needs another law"
    )


def _nearby(request: FitRequest, axes: FamilyAxes, stretch: Stretch) -> FitRequest:
    """The request with a short ladder of fine steps about the result of coarse steps, because members of the family are slow."""
    number = axes.number
    if number is None or (axes.work is None and not _is_of_layers(request, axes)):
        return request
    whole = whole_ladder(request.contact, number, float(depth_ranges(stretch)[0]))
    coarse = replace(request, ladder=whole._replace(rungs=_COARSE))
    fitted = fit_by_family(coarse, axes, stretch).columns
    if fitted["ending"][0] != FITTED:
        return request
    (middle,) = axes.numbers(np.array([[fitted[u.name][0] for u in request.unknowns]]))
    step = (whole.last - whole.first) / (whole.rungs - 1)
    # on rungs of the whole ladder, so that fits of similar records share them
    low = whole.first + step * (round((float(middle) - whole.first) / step) - _FINE // 2)
    return replace(request, ladder=Ladder(low, low + step * (_FINE - 1), _FINE))


def refuse_few(search: Search, models: Sequence[Modelled]) -> None:
    """Refuse records with too few samples in contact."""
    if search.shears or search.place in search.known:
        return
    pressed = sum(int(one.touches.sum()) for one in models)
    needed = fewest_in_contact(len(search.unknowns), len(search.curves))
    if pressed < needed:
        raise ProblemError(
            f"{pressed} samples of the record are in contact (limit {needed} for {', '.join(u.name for u in search.unknowns)} and the "
            "contact point); record more of the contact, or give contact_point"
        )


def least_of_rising(search: Search) -> float:
    """The smallest misfit in N^2 of forces that do not fall along the record, as without adhesion, whatever the contact point and the baseline."""
    from scipy.optimize import isotonic_regression, minimize_scalar

    least = 0.0
    for i, curve in enumerate(search.measured):
        used = search.used[i] if search.used else np.ones(curve.force.size, dtype=bool)
        place, force = curve.position[used], curve.force[used]
        order = np.argsort(place)
        place, force = place[order], force[order]

        def misfit(tilt: float, place: FloatArray = place, force: FloatArray = force) -> float:
            upright = force - tilt * place
            return float(((upright - isotonic_regression(upright).x) ** 2).sum())

        if TILT in search.known:
            least += misfit(search.known[TILT])
        else:  # a convex function of the tilt
            slope = float(np.ptp(force) / np.ptp(place))
            least += float(minimize_scalar(lambda t, of=misfit, unit=slope: of(t * unit)).fun)
    return least


def refuse_unseen(search: Search, misfit: float, best: FloatArray) -> None:
    """Refuse an adhesion, or a finite friction, without which the record fits as well."""
    law, effect = ("friction", "slip") if search.shears else ("adhesion", "adhesion")
    without = tuple(u for u in search.unknowns if not u.name.startswith(f"{law}."))
    if len(without) == len(search.unknowns):
        return
    contact = (
        replace(search.contact, friction=Coulomb(math.inf))
        if search.shears
        else replace(search.contact, adhesion=None)
    )
    bare = replace(search, contact=contact, unknowns=without)
    samples = search.residuals(best).size
    if (
        law == "adhesion"
        and not search.contact.is_viscoelastic
        and least_of_rising(search) > misfit * (1.0 + 2.0 * SEEN / samples)
    ):
        return
    try:
        larger = (
            best_end(bare, _FINE_ENOUGH * SEEN / samples).misfit
            if bare.names
            else float((bare.residuals(np.zeros(0)) ** 2).sum())
        )
    except ProblemError:  # the record shows the pull only
        return
    grows = (larger / misfit - 1.0) * samples
    if grows < SEEN:
        hysteresis = search.contact.adhesion is not None and search.contact.adhesion.has_hysteresis
        bounded = hysteresis and not set(WORKS) <= set(search.names)
        instead = (
            f"fit the contact without adhesion{_BOUNDED if bounded else ''}"
            if law == "adhesion"
            else "move the bodies over a larger distance, or add their moduli to free"
        )
        raise ProblemError(
            f"the record shows no {effect} of this contact: without it the sum of squares grows by {max(grows, 0.0):.2g} variances of "
            f"the noise (limit {SEEN:g}); {instead}"
        )
