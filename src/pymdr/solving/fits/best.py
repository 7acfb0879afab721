"""The smallest misfit of a fit, from where it may begin."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.laws import Coulomb
from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, Asked, fewest_in_contact
from pymdr.solving.fits.families import Ladder, Ways, whole_ladder
from pymdr.solving.fits.quick import fit_by_family, reaches
from pymdr.solving.fits.records import ListedCurves, Stretch
from pymdr.solving.fits.searching import Search, found_from
from pymdr.solving.fits.starting import Start, is_pressed_once, pressed_once, starts
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    TILT,
    put_into,
)
from pymdr.units import FloatArray, written

if TYPE_CHECKING:
    pass


_STARTS, _COARSE, _FINE = 4, 14, 12
_AS_WELL = 1e-11
"""Part by which sums of squares of the same end may differ."""


class End(NamedTuple):
    """Where a search ends."""

    misfit: float
    """In N^2."""
    free: FloatArray
    wide: FloatArray
    """Standard errors of the free numbers where ends that fit as well lie farther apart than the curvature tells; else 0."""


def best_end(search: Search) -> End:
    """The smallest misfit that searches from several starts end at; of bodies with memory about where it lies."""
    quick = _quick_start(search)
    eased = _eased(search)
    once = not search.shears and all(map(is_pressed_once, search.measured))
    followed = search if once else eased
    apart = (
        [starts(eased.contact, eased.unknowns, curve, eased.known, _STARTS) for curve in eased.curves]
        if quick is None
        else [[quick[0]]]
    )
    ends = []
    for rank in range(max(len(found) for found in apart)):
        chosen = [found[min(rank, len(found) - 1)] for found in apart]
        places = [{search.place: one.origin, BASELINE: one.baseline, TILT: one.tilt} for one in chosen]
        found = found_from(followed, followed.to_free(chosen[0].values.tolist(), places))
        ends.append((found.misfit, found.free))
    least = min(misfit for misfit, _ in ends)
    signed = np.array([not u.is_size for u in search.unknowns] + [False] * search.origin_scales.size)
    # of those that fit as well, as of Poisson's ratios of either sign, the nearest to what the contact says
    misfit, best = min(
        (end for end in ends if end[0] <= least * (1.0 + _AS_WELL)),
        key=lambda end: (float((end[1][signed] ** 2).sum()), end[0]),
    )
    values, origin = followed.from_free(best)
    pulled = quick if search.contact.adhesion is not None else None
    wide = np.zeros(len(search.names)) if pulled is None else pulled[1]
    return End(misfit, search.to_free(values.tolist(), origin), wide)


def _eased(search: Search) -> Search:
    """The search with the records of bodies with memory as one approach and one retreat, which are followed far faster, where they are."""
    if not search.contact.remembers or search.shears:
        return search
    curves = [pressed_once(one, search.known.get(BASELINE)) for one in search.measured]
    eased = tuple(one for one in curves if one is not None)
    return replace(search, curves=eased) if len(eased) == len(search.curves) else search


def machine_in_words(place: FloatArray, force: FloatArray, softness: float) -> str:
    """That a machine bends farther than it travels while the force rises, where it does."""
    top = int(np.nanargmax(force))
    begun = int(np.nanargmin(np.where(force > 0.9 * np.nanmin(force) + 0.1 * force[top], place, math.nan)))
    rise, way = float(force[top] - force[begun]), float(place[top] - place[begun])
    if softness == 0.0 or not 0.0 < way < softness * rise:
        return ""
    return (
        f"a machine of {written(1.0 / softness, 'N/m', 3)} bends by more than the {written(way, 'm', 3)} that it travels while the force rises by "
        f"{written(rise, 'N', 3)}: see whether spring_constant is that of this record, "
    )


def _quick_start(search: Search) -> tuple[Start, FloatArray] | None:
    """Where the search over a family of forces ends, if there is one and it finds something, and its errors of the free numbers."""
    unknowns = search.unknowns
    curves = ListedCurves(search.measured)
    begun = put_into(search.contact, unknowns, np.array([u.start for u in unknowns]))
    asked = Asked(begun, unknowns, search.known, {}, [u.name for u in unknowns])
    ways = asked.ways
    if ways is None or not unknowns or len(curves.curves) != 1:
        return None
    stretch = curves.read(0, 1)
    law = search.contact.adhesion
    if (law is not None and law.cohesive_stress is not None) or _is_of_layers(asked, ways):
        asked = _nearby(asked, ways, stretch)
    found = fit_by_family(asked, ways, stretch).columns
    if found["ending"][0] == AT_END and asked.ladder is not None and _is_of_layers(asked, ways):
        # coarse steps may have told of another place
        found = fit_by_family(replace(asked, ladder=None), ways, stretch).columns
    if found["ending"][0] == NO_CONTACT:
        raise ProblemError(
            f"fit: no contact is seen in the record: one without any leaves squares that are larger by less than {SEEN:g} variances of "
            f"the noise; {machine_in_words(stretch.place[0], stretch.force[0], float(stretch.softness[0]))}press deeper, mark outliers (curve.mark_outliers()), or see with curve.orient() whether a sign is turned"
        )
    if found["ending"][0] == AT_END:
        _refuse_beyond_layers(asked, ways, stretch)
    if found["ending"][0] != FOUND:
        return None
    origin = {name: float(found[name][0]) for name in asked.origins}
    values = np.array([found[u.name][0] for u in unknowns])
    scales = [*(u.rate(float(v)) for u, v in zip(unknowns, values, strict=True)), *search.origin_scales]
    errors = np.array([found[f"{name}_error"][0] for name in asked.names]) / scales
    return Start(0.0, values, *(origin.get(name, 0.0) for name in (CONTACT_POINT, BASELINE, TILT))), errors


def _is_of_layers(asked: Asked, ways: Ways) -> bool:
    """Whether a length is looked for on layers, which are mapped anew for each."""
    return asked.contact.layered is not None and ways.number is not None and ways.number.unit == "m"


def _refuse_beyond_layers(asked: Asked, ways: Ways, stretch: Stretch) -> None:
    """Refuse a length on layers that is beyond all that are tried, towards which there would be hundreds of steps."""
    number = ways.number
    if number is None or not _is_of_layers(asked, ways) or math.isfinite(number.high):
        return
    tried = whole_ladder(asked.contact, number, float(reaches(stretch)[0]))
    low, high = (written(number.from_free(free), number.unit, 4) for free in (tried.first, tried.last))
    raise ProblemError(
        f"fit: the record asks for a {number.name} that is not between {low} and {high}, a tenth and ten times what the contact says: begin nearer to it, give "
        "bounds in free, or leave it out of free; where it has no end, the record tells only a combination with the modulus, or of another law"
    )


def _nearby(asked: Asked, ways: Ways, stretch: Stretch) -> Asked:
    """The same on a short ladder of fine steps, about what one of coarse steps tells: members of the family take long."""
    number = ways.number
    if number is None or (ways.work is None and not _is_of_layers(asked, ways)):
        return asked
    whole = whole_ladder(asked.contact, number, float(reaches(stretch)[0]))
    coarse = replace(asked, ladder=whole._replace(rungs=_COARSE))
    found = fit_by_family(coarse, ways, stretch).columns
    if found["ending"][0] != FOUND:
        return asked
    (middle,) = ways.numbers(np.array([[found[u.name][0] for u in asked.unknowns]]))
    half = 0.5 * (_FINE - 1) * (whole.last - whole.first) / (whole.rungs - 1)
    return replace(asked, ladder=Ladder(float(middle) - half, float(middle) + half, _FINE))


def refuse_few(search: Search, best: FloatArray) -> None:
    """Refuse a contact of which there are no more samples than numbers that only they tell."""
    if search.shears or search.place in search.known:
        return
    pressed = sum(int(one.touches.sum()) for one in search.models(best))
    needed = fewest_in_contact(len(search.unknowns), len(search.curves))
    if pressed < needed:
        raise ProblemError(
            f"fit: {pressed} samples of the record are in contact, and {needed} at least tell {', '.join(u.name for u in search.unknowns)} and where it begins: "
            "record more of the contact, or give contact_point"
        )


def refuse_unseen(search: Search, misfit: float, best: FloatArray) -> None:
    """Refuse an adhesion, or a friction that is not infinite, without which the record fits as well."""
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
    try:
        larger = best_end(bare).misfit if bare.names else float((bare.residuals(np.zeros(0)) ** 2).sum())
    except ProblemError:  # all that is seen is the pull
        return
    samples = search.residuals(best).size
    grows = (larger / misfit - 1.0) * samples
    if grows < SEEN:
        instead = (
            "fit the contact without adhesion"
            if law == "adhesion"
            else "move the bodies farther, or look for their moduli too"
        )
        raise ProblemError(
            f"fit: the record shows no {effect} of this contact: without it the squares of the differences grow by {max(grows, 0.0):.2g} times "
            f"the variance of the noise, {SEEN:g} are needed; {instead}"
        )
