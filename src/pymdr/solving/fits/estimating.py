"""The end of the search of a fit, with errors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.soft.springs import COARSE
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Path, indent
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.best import (
    best_end,
    moved_across_samples,
    refuse_few,
    refuse_unseen,
    soft_machine_text,
)
from pymdr.solving.fits.condensing import Blocks, condensed
from pymdr.solving.fits.determining import refuse_equal_works, refuse_noisy, refuse_undetermined
from pymdr.solving.fits.edges import off_jumps, solve_edge
from pymdr.solving.fits.limits import Limit
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.minimizing import (
    GAIN,
    TOLERANCE,
    Minimum,
    minimize_from,
    refuse_unsettled,
    samples_off_jumps,
)
from pymdr.solving.fits.quality import Quality, worst_quality
from pymdr.solving.fits.request import SEEN
from pymdr.solving.fits.residuals import DECIDED, waves_of
from pymdr.solving.fits.results import Fitted
from pymdr.solving.fits.searching import Modelled, Search
from pymdr.solving.fits.spectrum import NORMAL_95, WHITE_PRIOR, NoiseSpectra, noise_spectra
from pymdr.solving.fits.timing import refuse_untimed
from pymdr.solving.fits.touching import ROUNDS_OF_JUMPS, BoolArray, off_changes
from pymdr.solving.fits.unknowns import (
    CONTACT_POINT,
    ORIGINS,
    SHIFT_ORIGIN,
    Free,
    put_into,
    unknowns_of,
)
from pymdr.solving.verb import solve
from pymdr.units import FloatArray

_NEARBY, _FOLLOWED = 1e-3, 1e-2
"""Tolerances of the sum of squares for an edge with a history: of the first search, relative, and of the last, in variances of the noise."""
_UNFELT = 1e-6
"""Rate of the residuals over an origin, relative to the largest, below which the origin has no effect."""
_INDISTINCT, _PART = 1e-6, 0.1
"""Ratio to the largest singular value below which a combination has no effect, and its smallest part that counts."""
_ROUNDED = 1e-12
"""Ratio to the largest singular value below which one is a rounding error."""
_RAISED = 1.44
"""Density at low frequencies relative to the variance from which on residuals are called correlated."""
_ROUNDS, _BETTER = 3, 0.1
"""Largest number of minima of a scan that are compared, and decrease of the sum of squares in variances of the noise by which one is better."""
_AT_BOUND = 1e-4
"""Distance to a bound, relative to the free range, below which a number is at the bound."""


class Estimate(NamedTuple):
    """The end of a search with its statistics."""

    search: Search
    best: FloatArray
    """The free numbers."""
    values: dict[str, Fitted]
    contact: Contact
    """With the fitted values."""
    models: list[Modelled]
    felt: BoolArray
    """Free numbers with an effect on the record."""
    errors: FloatArray
    """Standard errors of the free numbers by noise; NaN for those without an effect."""
    width: FloatArray
    """Widths of the 95 % intervals below and above in standard errors, infinite towards a limit that is not excluded, shape (2, free numbers)."""
    moved: FloatArray
    """Largest change of the free numbers by a relative error of 1 of the force of the model at each used sample or mean, shape (free numbers, samples)."""
    noise: float
    """In N."""
    correlated: float
    widened: dict[str, float]
    """As in :class:`FitResult`."""
    correlation_length: float
    """In samples; 0 for white noise."""
    waves: float
    aicc: float

    @property
    def deepest(self) -> float:
        """Largest indentation in m."""
        return max(float(one.depth.max()) for one in self.models)

    @property
    def quality(self) -> Quality:
        """Measures of the quality of records of normal forces."""
        noises = [self.noise]
        if len(self.models) > 1:
            used = self.search.used or [np.ones(one.force.size, dtype=bool) for one in self.models]
            left = [(one.force - one.model)[part] for one, part in zip(self.models, used, strict=True)]
            noises = [float(np.sqrt(np.mean(each**2))) for each in left]
        origins = self.search.from_free(self.best)[1]
        places = [
            one.position - own[CONTACT_POINT] for one, own in zip(self.search.measured, origins, strict=True)
        ]
        forces = [one.force for one in self.models]
        law = self.contact.adhesion
        range_ = 0.0 if law is None else law.attraction_range or 0.0
        return worst_quality(list(zip(places, forces, strict=True)), noises, range_)


def search_of(contact: Contact, curve: MeasuredCurve, free: Free, known: Mapping[str, float]) -> Search:
    """The search of :func:`fit` from one force curve."""
    return Search(contact, unknowns_of(contact, free), (checked(curve),), dict(known))


def estimated(search: Search) -> Estimate:
    """The estimate of a search; refuse what the records do not determine."""
    follows_edge = search.contact.has_edge_history
    few = (
        replace(search, used=tuple(off_jumps(one, one.force) for one in search.measured), zone=COARSE)
        if follows_edge
        else condensed(search)
    )
    end = best_end(few, _NEARBY if follows_edge else TOLERANCE)
    best = end.free
    refuse_equal_works(few, best)
    refuse_few(few, few.models(best))
    refuse_unseen(few, end.misfit, best)
    if not search.contact.is_viscoelastic and not follows_edge:  # with a history the end is approximate
        refuse_undetermined(few, best, few.slopes(best))
    own = _estimate_near(search, few, best, end.wide)
    if not end.scanned:
        return own
    scanned = [_rival(search, few, free) for free in end.scanned]
    for _ in range(_ROUNDS):
        grows = [_grows(own, one.models) for one in scanned]
        if min(grows) > -_BETTER:
            break
        own = _estimate_near(search, few, end.scanned[int(np.argmin(grows))], end.wide)
    rivals = scanned + [_rival_at(search, one) for one in end.limits]
    return _covering(
        own,
        [
            one.free
            for one in rivals
            if _is_within(search, one.free) and _grows(own, one.models) < _level(own)
        ],
    )


def _estimate_near(search: Search, few: Search, best: FloatArray, wide: FloatArray) -> Estimate:
    """The estimate at the minimum without the samples adjacent to jumps, from the end of a search with all or over means."""
    follows_edge = search.contact.has_edge_history
    if few is not search and not follows_edge:
        values, origins = few.from_free(best)
        best = moved_across_samples(search, search.to_free(values.tolist(), origins))
    sizes = [[one.force.size for one in own.curves] for own in (search, few)]
    widths = [many // means for many, means in zip(*sizes, strict=True)]
    used = search.used or samples_off_jumps(search.models(best), search, widths)
    blocks = None if few is search or follows_edge else Blocks(search, few, used)
    if blocks is not None:
        search = blocks.search
        minimum = blocks.refined(best)
    else:
        samples = sum(one.force.size for one in search.curves)
        tolerance = (_FOLLOWED if follows_edge else GAIN) / samples
        search, minimum = _least_off_jumps(search, used, best, tolerance)
    refuse_unsettled(minimum)
    best = minimum.free
    refuse_equal_works(search, best)
    values, _ = search.from_free(best)
    contact = put_into(search.contact, search.unknowns, values)
    if contact.is_viscoelastic:
        times = [one.time for one in search.curves if one.time is not None]
        refuse_untimed(contact, search.unknowns, values, times)
    slopes = search.slopes(best) if blocks is None else blocks.slopes(best)
    if search.scatters:
        slopes = search.slopes(best, search.steps_of_errors(_white_errors(slopes, minimum.misfit)))
    refuse_undetermined(search, best, slopes)
    return _with_errors(search, best, slopes, wide, blocks)


def _white_errors(slopes: FloatArray, misfit: float) -> FloatArray:
    """Standard errors of the free numbers by white noise, from the rates of the residuals and their sum of squares."""
    n, p = slopes.shape
    scale = np.linalg.norm(slopes, axis=0)
    scale[scale == 0.0] = 1e-300
    variances = np.diag(np.linalg.pinv((slopes / scale).T @ (slopes / scale))) * misfit / max(n - p, 1)
    errors: FloatArray = np.sqrt(variances) / scale
    return errors


def _least_off_jumps(
    search: Search, used: tuple[BoolArray, ...], best: FloatArray, tolerance: float
) -> tuple[Search, Minimum]:
    """
    The least squares of the used samples, and the search over them.

    With adhesion the samples in contact are fixed, and those adjacent to jumps left out. The jumps are those of the end itself, found in turn,
    but for an edge with a history, where a search takes seconds. Where the law with its own samples in contact then has significantly larger
    squares than at the start, it decides in the search: fixed samples may be fitted far beyond the loss of contact.
    """
    law = search if all(part.all() for part in used) else replace(search, used=used)
    if search.used or search.contact.adhesion is None or search.shears or search.contact.has_edge_history:
        return law, minimize_from(law, best, tolerance=tolerance)
    # the samples beside the jump of a constant pull, which are left out, decide between which samples it is
    stays = search.jumps and all(one.compliance == 0.0 for one in search.measured)
    free, touches = best, tuple(one.touches for one in search.models(best))
    for _ in range(ROUNDS_OF_JUMPS):
        own = replace(search, touches=touches, used=tuple(map(off_changes, touches)))
        minimum = minimize_from(own, free, tolerance=tolerance)
        free, left = minimum.free, touches
        touches = left if stays else tuple(one.touches for one in search.models(free))
        if all(np.array_equal(*pair) for pair in zip(left, touches, strict=True)):
            break
    if not stays:
        both = tuple(one & other for one, other in zip(used, own.used, strict=True))
        common = replace(search, used=both)
        least, larger = (float((common.residuals(one) ** 2).sum()) for one in (best, free))
        if larger > least * (1.0 + SEEN / max(sum(map(np.count_nonzero, both)), 1)):
            return law, minimize_from(law, best, tolerance=tolerance)
    return own, minimum


class _Rival(NamedTuple):
    """Another place of the search that may fit as well."""

    free: FloatArray
    """Infinite for a range or strength at a limit of the law."""
    models: list[Modelled]


def _rival(search: Search, few: Search, end: FloatArray) -> _Rival:
    """The place of free numbers of a search over means."""
    values, origins = few.from_free(end)
    free = search.to_free(values.tolist(), origins)
    return _Rival(free, search.models(free))


def _rival_at(search: Search, limit: Limit) -> _Rival:
    """The place of a limit of the law."""
    own = replace(search, contact=limit.search.contact, unknowns=limit.search.unknowns)
    ended = own.to_free(list(limit.values.values()), limit.origins)
    named = dict(zip(own.names, ended.tolist(), strict=True))
    beyond = {"adhesion.range": limit.side * math.inf, "adhesion.strength": -limit.side * math.inf}
    return _Rival(np.array([(named | beyond)[name] for name in search.names]), own.models(ended))


def _is_within(search: Search, free: FloatArray) -> bool:
    """Whether free numbers are within their bounds: given ones exclude limits of a law."""
    return all(low <= x <= high for x, (low, high) in zip(free, search.bounds(), strict=True))


def _level(best: Estimate) -> float:
    """Growth of the sum of squares in variances of the noise up to which the intervals extend."""
    return (NORMAL_95 * max(best.widened.values(), default=1.0)) ** 2


def _covering(best: Estimate, rivals: list[FloatArray]) -> Estimate:
    """The estimate with intervals that cover other free numbers, which fit as well: a limit of a law is reached where the curvature tells little."""
    if not rivals:
        return best
    half, errors = best.width * best.errors, best.errors
    for free in rivals:
        offset = free - best.best
        half = np.maximum(half, [-offset, offset])
        errors = np.maximum(errors, np.where(np.isinf(offset), 0.0, np.abs(offset)) / best.width[0])
    width = half / errors
    values = with_intervals(best.search, best.best, errors, width)
    return best._replace(errors=errors, width=width, values=values)


def _grows(best: Estimate, models: list[Modelled]) -> float:
    """Growth of the sum of squares to other models in variances of the noise, without the samples that are adjacent to jumps of either."""
    search = best.search
    used = samples_off_jumps(models, search)
    if search.used:
        used = tuple(one & own for one, own in zip(used, search.used, strict=True))
    least, larger = (
        float((_used_parts([one.force - one.model for one in ends], used) ** 2).sum())
        for ends in (best.models, models)
    )
    return (larger / least - 1.0) * sum(map(np.count_nonzero, used)) if least > 0.0 else math.inf


def _with_errors(
    search: Search, best: FloatArray, slopes: FloatArray, wide: FloatArray, blocks: Blocks | None
) -> Estimate:
    """The estimate at the end of a search, from the rates of the residuals, or of their means over blocks of samples."""
    models = search.models(best)
    span = max(float(np.ptp(one.force)) for one in models)
    used = search.used or tuple(np.ones(one.model.size, dtype=bool) for one in models)
    residuals = _used_parts([one.force - one.model for one in models], used)
    n, p = residuals.size, best.size
    noise = math.sqrt(float(residuals @ residuals) / max(n - p, 1))
    if blocks is None:
        lengths, means = [int(part.sum()) for part in used], residuals
        forces = _used_parts([one.model for one in models], used)
    else:
        lengths, means = blocks.lengths, blocks.means([one.force - one.model for one in models])
        forces = blocks.means([one.model for one in models])
    size = n / means.size
    white = noise / math.sqrt(size)
    scale = np.linalg.norm(slopes, axis=0)
    seen = scale > _UNFELT * scale.max()
    left, singular, rows = np.linalg.svd(slopes[:, seen] / scale[seen], full_matrices=False)
    # undetermined combinations have huge errors, limited by rounding
    scaled = rows / np.maximum(singular, _ROUNDED * singular.max())[:, None]
    spectra = noise_spectra(means[None], left.T[None], lengths, keep=True)
    variances = np.einsum("ki,kl,li->i", scaled, spectra.covariance[0], scaled)
    with np.errstate(invalid="ignore", divide="ignore"):  # a record without noise
        factors = np.sqrt(variances) / (white * np.linalg.norm(scaled, axis=0))
    correlated = _correlated(factors[: np.count_nonzero(seen[: len(search.unknowns)])])
    independent = n / correlated
    refuse_noisy(search, best, slopes, white * math.sqrt(correlated))
    errors, width = np.full(p, math.nan), np.full((2, p), math.nan)
    errors[seen] = np.sqrt(variances) / scale[seen]
    width[:, seen] = spectra.quantile(scaled.T[None])[0]
    moved = np.zeros((p, means.size))
    moved[seen] = np.abs(scaled.T @ left.T) * np.abs(forces) / scale[seen, None]
    # those of the search over a family account for a pull of a few samples
    errors = np.where(wide > errors, wide, errors)
    # a combination without an effect: each of its numbers can be anything
    unbounded = np.flatnonzero(seen)[
        np.any(np.abs(rows[singular <= _INDISTINCT * singular.max()]) > _PART, axis=0)
    ]
    felt = seen.copy()
    felt[unbounded], errors[unbounded] = False, math.nan
    decided = bool(spectra.white[0] < DECIDED)
    waves = waves_of(residuals[None, :], np.array([span]), spectra.slow if decided else 0.0)
    inner, _ = search.from_free(best)
    return Estimate(
        search,
        best,
        with_intervals(search, best, errors, width),
        put_into(search.contact, search.unknowns, inner),
        models,
        felt,
        errors,
        width,
        moved,
        noise,
        correlated,
        dict(
            zip(
                np.array(search.names)[seen].tolist(),
                (factors * width[0, seen] / NORMAL_95).tolist(),
                strict=True,
            )
        ),
        _correlation_length(spectra, white, size),
        float(waves[0]),
        aicc(float((residuals**2).mean()), independent, p),
    )


def _correlated(factors: FloatArray) -> float:
    """Number of samples that are equivalent to one independent sample, of the ratios of errors to those under white noise."""
    known = factors[np.isfinite(factors)]
    return float(max(known.max(initial=1.0) ** 2, 1.0))


def _used_parts(columns: list[FloatArray], used: Sequence[BoolArray]) -> FloatArray:
    """The used samples of a column of each record."""
    return np.concatenate([column[part] for column, part in zip(columns, used, strict=True)])


def _correlation_length(spectra: NoiseSpectra, white: float, size: float) -> float:
    """
    The correlation length of residuals in samples, 0 of white noise, from the spectrum of means of so many samples.

    Residuals are correlated if they make white noise less probable than it is without data. A length that is short enough to look white
    at low frequencies raises their density by twice itself.
    """
    if spectra.white[0] < WHITE_PRIOR:
        return float(spectra.length[0]) * size
    low = float(spectra.density[0, : spectra.bands.low].min())
    return 0.5 * low / white**2 if low > _RAISED * white**2 else 0.0


def solve_fitted(estimate: Estimate) -> Result:
    """The fitted contact solved at its largest indentation; with memory or friction along the whole record."""
    contact, curve = estimate.contact, estimate.search.curves[0]
    if isinstance(curve, ShearRecord):
        return curve.solved(contact, estimate.search.from_free(estimate.best)[1][0][SHIFT_ORIGIN])
    if contact.has_edge_history:
        return edges_solved(estimate, 1)[0]
    if contact.is_viscoelastic:
        assert curve.time is not None
        return solve(contact, Path(time=curve.time - curve.time[0], indentation=estimate.models[0].depth))
    if estimate.deepest <= 0.0:
        softness = 0.0 if curve.travel is None or not curve.spring_constant else 1.0 / curve.spring_constant
        raise ProblemError(
            f"no sample is in contact; {soft_machine_text(curve.position, curve.force, softness)}give contact_point, or a "
            "record with contact"
        )
    return solve(contact, indent(estimate.deepest))


def edges_solved(estimate: Estimate, count: int) -> list[Result]:
    """The fitted contact of an edge with a history solved along the first records."""
    origins = estimate.search.from_free(estimate.best)[1]
    return [
        solve_edge(estimate.contact, one.time, one.position - own[CONTACT_POINT], one.compliance)
        for one, own in zip(estimate.search.measured[:count], origins, strict=False)
    ]


def with_intervals(
    search: Search, best: FloatArray, errors: FloatArray, width: FloatArray
) -> dict[str, Fitted]:
    """Fitted numbers by name, with intervals from the errors of the free numbers and their widths below and above in errors."""
    values, rest, rates = {}, at_bounds(search, best), search.rates(best)
    bounds = {u.name: (u.low, u.high) for u in search.unknowns}
    units = {u.name: u.unit for u in search.unknowns}
    for i, name in enumerate(search.names):
        if math.isnan(errors[i]):
            continue
        ends = []
        for side in (0.0, -width[0, i], width[1, i]):
            moved = best.copy()
            moved[i] += side * errors[i]
            ends.append(search.named(moved)[name])
        value, low, high = ends
        unit = units.get(name) or ORIGINS.get(name.partition("[")[0], "")
        if name in rest:
            values[name] = Fitted(name, value, math.nan, *bounds[name], unit)
            continue
        low = bounds[name][0] if math.isinf(width[0, i]) else low
        high = bounds[name][1] if math.isinf(width[1, i]) else high
        values[name] = Fitted(name, value, float(rates[i] * errors[i]), low, high, unit)
    return values


def at_bounds(search: Search, best: FloatArray) -> tuple[str, ...]:
    """Unknowns that are at a bound."""
    rest = []
    for unknown, x, (low, high) in zip(search.unknowns, best, search.bounds(), strict=False):
        margin = _AT_BOUND * (high - low if math.isfinite(high - low) else 1.0)
        if min(x - low, high - x) < margin:
            rest.append(unknown.name)
    return tuple(rest)


def aicc(mean_square: float, independent: float, p: int) -> float:
    """AICc of least squares with unknown noise (Burnham and Anderson 2002), for independent samples."""
    k = p + 1
    freedom = max(independent - k - 1.0, 1.0)
    return independent * math.log(max(mean_square, 1e-300)) + 2.0 * k + 2.0 * k * (k + 1) / freedom


def checked(curve: MeasuredCurve) -> MeasuredCurve:
    """The unmarked samples of a record; refuse constant columns."""
    for name, column in (("force", curve.force), ("depth", curve.position)):
        if float(np.ptp(column)) == 0.0:
            raise ProblemError(
                f"the {name} of the record is constant: it shows no contact; give a record with contact"
            )
    return curve.leave_out_marked() if curve.marked.any() else curve
