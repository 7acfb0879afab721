"""From measured curves to the numbers of a contact."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import EXACT_WITHIN, Claim
from pymdr.problem.contact import Contact
from pymdr.problem.laws import Coulomb
from pymdr.problem.paths import Path, indent
from pymdr.result import Result, labelled
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, Asked, fewest_in_contact
from pymdr.solving.fits.families import Ladder, Ways, whole_ladder
from pymdr.solving.fits.found import FitResult, Fitted, force_of
from pymdr.solving.fits.loops import NORMAL, ShearRecord, shear_record
from pymdr.solving.fits.quick import fit_by_family, reaches
from pymdr.solving.fits.records import ListedCurves, Stretch
from pymdr.solving.fits.searching import (
    Modelled,
    Search,
    beside_jumps,
    found_from,
    hanging,
    refuse_blind,
    refuse_lost,
    refuse_unsettled,
)
from pymdr.solving.fits.starting import Start, is_pressed_once, pressed_once, starts
from pymdr.solving.fits.timing import refuse_untimed
from pymdr.solving.fits.unexplained import unexplained
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    ORIGINS,
    SHIFT_ORIGIN,
    TILT,
    Free,
    origins,
    put_into,
    unknowns_of,
    without_tilt,
)
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, written

if TYPE_CHECKING:
    import xarray as xr

LEVENBERG_MARQUARDT = "levenberg-marquardt"
_STARTS, _COARSE, _FINE = 4, 14, 12
_UNFELT = 1e-6
"""Of the largest: rates of the residuals over an origin that a record does not feel."""
_ROUNDED = 1e-12
"""Of the largest: singular values that are rounding."""
_AS_WELL = 1e-11
"""Part by which sums of squares of the same end may differ."""
_NOTED = 0.1
"""Share of a standard error from which a systematic one is noted."""
_WIDER = 1.1
"""Errors of the family of forces that count, which also tell where a pull stands in a few samples."""
_AT_BOUND = 1e-4
"""Of what lies between the bounds in the numbers that the search changes."""


def fit(
    contact: Contact,
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    shift_origin: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
) -> FitResult:
    """
    Find parameters of a contact in measured force curves, or in records of friction.

    Parameters
    ----------
    contact : Contact
        What is known, and the law: elastic bodies with or without adhesion, or bodies with memory; with friction, where
        tangential forces were measured. Lengths that are looked for begin from what it says.
    curve : MeasuredCurve, xarray.Dataset, or sequence of them
        One, or several of the same contact, each with its own origins. Of a contact with friction a record as
        :func:`pymdr.read_record` reads it: ``tangential_force``, ``shift``, and ``normal_force``, or without it ``indentation``,
        which is prescribed; ``used`` is false at samples that are followed and not compared.
    free : sequence of str, or mapping of str to pair of quantities or None
        Parameters that are looked for by their dotted names, such as ``["body.young", "adhesion.work"]``, with bounds where
        there are any. ``"tilt"`` among them, in N/m of the travel or indentation, is the rise of the force along the record before
        contact, as by drift or virtual deflection; the baseline is then that in the middle of the record.
    contact_point : quantity, optional
        The depth of the record in m at which the bodies touch; looked for unless given.
    shift_origin : quantity, optional
        With friction the shift of the record in m at which the bodies were pressed together, before its first sample; looked for
        unless given.
    baseline : quantity, optional
        The force of the record in N when they do not; looked for unless given.

    Returns
    -------
    FitResult

    Raises
    ------
    ProblemError
        If the contact has no number of a name, the records cannot tell the unknowns apart, or show no adhesion or no slip that is
        looked for, or are of another kind than the contact.
    ConvergenceError
        If the search does not settle.

    Notes
    -----
    The depth of a sample is its travel less the deflection of the machine; the noise of the force, which is in both, is taken
    out of the weights. Under adhesion samples between the depths at which bodies jump into contact and leave it belong to the
    branch that is nearer, and those beside a jump are left out. The search begins from the best places of a grid over
    everything that is not linear. Errors are those of the curvature of the misfit, times the root of how many samples tell as
    much as an independent one.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> force = 16e3 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    >>> found = fit(
    ...     Contact(Paraboloid("5 um"), Elastic("10 kPa", 0.5)),
    ...     MeasuredCurve(force=force, indentation=depth + 3e-7),
    ...     ["body.young"],
    ... )
    >>> round(found["body.young"].value, 6), round(1e9 * found["contact_point"].value, 6)
    (1000.0, 300.0)
    """
    if not isinstance(contact, Contact):
        raise ProblemError(f"fit: {contact!r} is not a Contact; write Contact(profile, body)")
    search, marked = _search(
        contact,
        curve,
        free,
        {CONTACT_POINT: contact_point, SHIFT_ORIGIN: shift_origin, BASELINE: baseline},
    )
    found = _interpreted(_estimated(search))
    notes = (f"{marked} samples marked as outliers or saturated are left out",) if marked else ()
    return replace(found, notes=(*notes, *unexplained(found), *found.notes))


def estimate(contact: Contact, curve: MeasuredCurve, free: Free, known: Mapping[str, float]) -> Estimate:
    """What :func:`fit` finds in one force curve with some origins known, not how far to trust the model: that takes bodies with memory longer than the search."""
    return _estimated(Search(contact, unknowns_of(contact, free), (_told(curve),), dict(known)))


def _estimated(search: Search) -> Estimate:
    misfit, best, wide = _best(search)
    _refuse_few(search, best)
    _refuse_unseen(search, misfit, best)
    if not search.contact.remembers:  # whose end is only about the best
        refuse_blind(search, best)
    used = search.used or beside_jumps(search.models(best), search)
    if not all(part.all() for part in used):
        search = replace(search, used=used)
    minimum = found_from(search, best)
    refuse_unsettled(minimum)
    best = minimum.free
    values, _ = search.from_free(best)
    found = put_into(search.contact, search.unknowns, values)
    if found.remembers:
        times = [one.time for one in search.curves if one.time is not None]
        refuse_untimed(found, search.unknowns, values, times)
    refuse_blind(search, best)
    return _with_errors(search, best, wide)


def _search(
    contact: Contact,
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Free,
    given: dict[str, QuantityLike | None],
) -> tuple[Search, int]:
    """What is looked for in which records, and how many marked samples were left out of them."""
    from xarray import Dataset

    listed = (curve,) if isinstance(curve, MeasuredCurve | Dataset) else tuple(curve)
    kind, needed = (
        (MeasuredCurve, "a MeasuredCurve")
        if contact.friction is None
        else (Dataset, "a record of shift and tangential_force, such as read_record reads,")
    )
    if not listed or not all(isinstance(one, kind) for one in listed):
        has = "has friction" if contact.friction is not None else "has no friction"
        raise ProblemError(f"fit: {needed} is needed, or several: the contact {has}")
    unknowns, known = unknowns_of(contact, without_tilt(free)), origins(given, free)
    if contact.friction is None:
        if given.pop(SHIFT_ORIGIN) is not None:
            raise ProblemError(
                "fit: shift_origin= is for contacts with friction; force curves have a contact_point"
            )
        curves = tuple(one for one in listed if isinstance(one, MeasuredCurve))
        marked = sum(int(one.marked.sum()) for one in curves)
        curves = tuple(_told(one) for one in curves)
        return Search(contact, unknowns, curves, known), marked
    if given.pop(CONTACT_POINT) is not None or TILT not in known:
        raise ProblemError(
            "fit: contact_point= and a tilt are for normal forces; records of friction have a shift_origin and a baseline"
        )
    records = tuple(shear_record(one) for one in listed if isinstance(one, Dataset))
    used = () if all(one.used.all() for one in records) else tuple(one.used for one in records)
    return Search(contact, unknowns, records, known, used), 0


def _told(curve: MeasuredCurve) -> MeasuredCurve:
    """The samples of a record that are not marked; refused where they do not change."""
    for name, column in (("force", curve.force), ("depth", curve.position)):
        if float(np.ptp(column)) == 0.0:
            raise ProblemError(f"fit: the {name} of the record does not change: no contact is seen in it")
    return curve.leave_out_marked() if curve.marked.any() else curve


class Estimate(NamedTuple):
    """Where a search ended, and what it tells."""

    search: Search
    best: FloatArray
    """The free numbers."""
    values: dict[str, Fitted]
    contact: Contact
    """With the values that were found."""
    models: list[Modelled]
    felt: NDArray[np.bool_]
    """Which of the free numbers the record feels."""
    errors: FloatArray
    """Standard errors of the free numbers by noise; nan where the record does not feel them."""
    width: float
    """Of half an interval of 95 %, in standard errors."""
    moved: FloatArray
    """By how much a relative error 1 of all forces of the model may move the free numbers."""
    noise: float
    """In N."""
    correlated: float
    waves: float
    aicc: float

    @property
    def deepest(self) -> float:
        """Largest indentation in m."""
        return max(float(one.depth.max()) for one in self.models)


class _End(NamedTuple):
    """Where a search ends."""

    misfit: float
    """In N^2."""
    free: FloatArray
    wide: FloatArray
    """Standard errors of the free numbers where ends that fit as well lie farther apart than the curvature tells; else 0."""


def _best(search: Search) -> _End:
    """The smallest misfit that searches from several starts end at; of bodies with memory about where it lies."""
    quick = _quick_start(search)
    eased = _eased(search)
    once = all(isinstance(one, MeasuredCurve) and is_pressed_once(one) for one in search.curves)
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
    return _End(misfit, search.to_free(values.tolist(), origin), wide)


def _eased(search: Search) -> Search:
    """The search with the records of bodies with memory as one approach and one retreat, which are followed far faster, where they are."""
    if not search.contact.remembers or search.shears:
        return search
    curves = [
        pressed_once(one, search.known.get(BASELINE))
        for one in search.curves
        if isinstance(one, MeasuredCurve)
    ]
    eased = tuple(one for one in curves if one is not None)
    return replace(search, curves=eased) if len(eased) == len(search.curves) else search


def _machine_in_words(place: FloatArray, force: FloatArray, softness: float) -> str:
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
    curves = ListedCurves(tuple(one for one in search.curves if isinstance(one, MeasuredCurve)))
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
            f"the noise; {_machine_in_words(stretch.place[0], stretch.force[0], float(stretch.softness[0]))}press deeper, mark outliers (curve.mark_outliers()), or see with curve.orient() whether a sign is turned"
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


def _refuse_few(search: Search, best: FloatArray) -> None:
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


def _refuse_unseen(search: Search, misfit: float, best: FloatArray) -> None:
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
        larger = _best(bare).misfit if bare.names else float((bare.residuals(np.zeros(0)) ** 2).sum())
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


def _with_errors(search: Search, best: FloatArray, wide: FloatArray) -> Estimate:
    """What a search found, with its errors."""
    from scipy.special import stdtrit

    residuals = search.residuals(best)
    slopes = search.slopes(best)
    n, p = residuals.size, best.size
    noise = math.sqrt(float((residuals**2).sum()) / max(n - p, 1))
    models = search.models(best)
    span = max(float(np.ptp(one.force)) for one in models)
    hang = hanging(residuals[None, :], np.array([span]))
    correlated = float(hang.correlated[0])
    independent = n / correlated
    refuse_lost(search, best, slopes, noise * math.sqrt(correlated))
    scale = np.linalg.norm(slopes, axis=0)
    felt = scale > _UNFELT * scale.max()
    left, singular, rows = np.linalg.svd(slopes[:, felt] / scale[felt], full_matrices=False)
    # what the record cannot tell apart has errors without end, but for the rounding of its slopes
    apart = rows / np.maximum(singular, _ROUNDED * singular.max())[:, None]
    errors = np.full(p, math.nan)
    errors[felt] = noise * np.sqrt(correlated) * np.linalg.norm(apart, axis=0) / scale[felt]
    used = search.used or tuple(np.ones(one.model.size, dtype=bool) for one in models)
    forces = np.concatenate([np.abs(one.model[part]) for one, part in zip(models, used, strict=True)])
    moved = np.zeros(p)
    moved[felt] = np.abs(apart.T @ left.T) @ forces / scale[felt]
    errors = np.where(wide > _WIDER * errors, wide, errors)
    width = float(stdtrit(max(independent - p, 1.0), 0.975))
    inner, _ = search.from_free(best)
    return Estimate(
        search,
        best,
        _fitted(search, best, errors, width),
        put_into(search.contact, search.unknowns, inner),
        models,
        felt,
        errors,
        width,
        moved,
        noise,
        correlated,
        float(hang.waves[0]),
        aicc(float((residuals**2).mean()), independent, p),
    )


def _interpreted(found: Estimate) -> FitResult:
    """How far to trust the model, and what is to be said of the search."""
    search, values = found.search, found.values
    result = judged(found)
    systematic = _systematic(found, result.claims[force_of(found.contact)])
    if systematic.any():
        values = _fitted(search, found.best, found.errors + systematic / found.width, found.width)
    left_out = sum(int((~part).sum()) for part in search.used)
    why = "that the record marks" if search.shears else "beside jumps"
    notes: tuple[str, ...] = (f"{left_out} samples {why} are left out",) if left_out else ()
    notes += tuple(
        f"{name} rests at its bound {written(values[name].value, values[name].unit, 4)}: the record asks for what lies beyond, and its "
        "interval is that of the bounds"
        for name in _at_bounds(search, found.best)
    )
    notes += tuple(
        f"the record does not feel its {name}"
        for name, is_felt in zip(search.names, found.felt, strict=True)
        if not is_felt
    )
    if np.any(systematic > _NOTED * found.errors):
        notes += ("the intervals include the error of the model, which is not small beside the noise",)
    return FitResult(
        contact=found.contact,
        curves=search.curves,
        values=values,
        data=_table(search, found.models),
        noise=found.noise,
        waves=found.waves,
        correlated=found.correlated,
        aicc=found.aicc,
        claims=result.claims,
        assumptions=result.assumptions,
        notes=notes,
        references=(*result.references, LEVENBERG_MARQUARDT),
        search=search,
        free=found.best,
    )


def _systematic(found: Estimate, claim: Claim) -> FloatArray:
    """By how much the error of the forces of the model may move the free numbers, each sample in the direction that moves most."""
    error = 0.0 if claim.error is None else float(np.max(claim.error, initial=0.0, where=claim.where))
    return (error if error > EXACT_WITHIN else 0.0) * found.moved


def judged(found: Estimate) -> Result:
    """The contact that was found, where it is pressed deepest; with memory or friction along the whole record."""
    contact, curve = found.contact, found.search.curves[0]
    if isinstance(curve, ShearRecord):
        return curve.solved(contact, found.search.from_free(found.best)[1][0][SHIFT_ORIGIN])
    if contact.remembers:
        assert curve.time is not None
        return solve(contact, Path(time=curve.time - curve.time[0], indentation=found.models[0].depth))
    if found.deepest <= 0.0:
        softness = 0.0 if curve.travel is None or not curve.spring_constant else 1.0 / curve.spring_constant
        raise ProblemError(
            f"fit: the bodies touch at no sample; {_machine_in_words(curve.position, curve.force, softness)}give contact_point, or a "
            "record that presses them"
        )
    return solve(contact, indent(found.deepest))


def aicc(mean_square: float, independent: float, p: int) -> float:
    """AICc of least squares with an unknown noise (Burnham and Anderson 2002), of the independent samples."""
    k = p + 1
    room = max(independent - k - 1.0, 1.0)
    return independent * math.log(max(mean_square, 1e-300)) + 2.0 * k + 2.0 * k * (k + 1) / room


def _at_bounds(search: Search, best: FloatArray) -> tuple[str, ...]:
    """Unknowns that rest at a bound."""
    rest = []
    for unknown, x, (low, high) in zip(search.unknowns, best, search.bounds(), strict=False):
        room = _AT_BOUND * (high - low if math.isfinite(high - low) else 1.0)
        if min(x - low, high - x) < room:
            rest.append(unknown.name)
    return tuple(rest)


def _fitted(search: Search, best: FloatArray, errors: FloatArray, width: float) -> dict[str, Fitted]:
    found, rest = {}, _at_bounds(search, best)
    bounds = {u.name: (u.low, u.high) for u in search.unknowns}
    units = {u.name: u.unit for u in search.unknowns}
    for i, name in enumerate(search.names):
        if math.isnan(errors[i]):
            continue
        ends = []
        for side in (0.0, -width, width, 1.0):
            moved = best.copy()
            moved[i] += side * errors[i]
            ends.append(search.named(moved)[name])
        value, low, high, one = ends
        unit = units.get(name) or ORIGINS.get(name.partition("[")[0], "")
        if name in rest:
            found[name] = Fitted(name, value, math.nan, *bounds[name], unit)
            continue
        found[name] = Fitted(name, value, abs(one - value), min(low, high), max(low, high), unit)
    return found


def _table(search: Search, models: Sequence[Modelled]) -> xr.Dataset:
    """The samples of all curves, one after another."""
    used = search.used or tuple(np.ones(one.force.size, dtype=bool) for one in models)
    columns = {
        "shift" if search.shears else "indentation": np.concatenate([one.depth for one in models]),
        force_of(search.contact): np.concatenate([one.force for one in models]),
    }
    for name in NORMAL if search.shears else ():
        records = [one for one in search.curves if isinstance(one, ShearRecord) and one.channel == name]
        if len(records) == len(models):
            columns[name] = np.concatenate([one.normal for one in records])
    if search.contact.remembers:
        columns["time"] = np.concatenate([curve.time for curve in search.curves if curve.time is not None])
    table = labelled(columns)
    more = {
        "model": np.concatenate([one.model for one in models]),
        "residual": np.concatenate([one.force - one.model for one in models]),
        "in_contact": np.concatenate([one.touches for one in models]),
        "used": np.concatenate(used),
        "curve": np.repeat(np.arange(len(models)), [one.force.size for one in models]),
    }
    units = {"model": "N", "residual": "N"}
    return table.assign(
        {name: ("step", column, {"units": units.get(name, "")}) for name, column in more.items()}
    )
