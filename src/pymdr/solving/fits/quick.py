"""Fits of many curves by one family of forces."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from pymdr.errors import PymdrError
from pymdr.solving.fits.asking import (
    AT_END,
    FOUND,
    REFUSED,
    SEEN,
    UNREAD,
    WAVES,
    Asked,
    Columns,
    FittedStretch,
    empty_columns,
)
from pymdr.solving.fits.families import WORK, Ways
from pymdr.solving.fits.forces import rounded_up
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.searching import hanging
from pymdr.solving.fits.unknowns import BASELINE, CONTACT_POINT, TILT
from pymdr.units import FloatArray, written

_PLACES = {CONTACT_POINT: 2, BASELINE: 3, TILT: 4}
"""Of the origins among the numbers of the kernels."""


def fit_by_family(asked: Asked, ways: Ways, stretch: Stretch) -> FittedStretch:
    """What the search over one family of forces finds in some curves."""
    from pymdr.solving.fits import kernels

    count, width = stretch.place.shape
    numbers, residuals = np.full((count, 9), math.nan), np.full((count, width), math.nan)
    covariances = np.full((count, len(asked.names), len(asked.names)), math.nan)
    ended, refusals = np.full(count, UNREAD, dtype=np.int8), set()
    columns = np.zeros((kernels.ALL, len(asked.names)))
    own_ways = ways.columns()
    # both numbers of the family are searched by themselves, so that one of them may rest at its end
    both = own_ways.shape[1] == 2
    columns[:2, : len(ways.unknowns)] = np.eye(2) if both else own_ways
    for i, name in enumerate(asked.origins, len(ways.unknowns)):
        columns[_PLACES[name], i] = 1.0
    number = ways.number
    known = np.array([0.0, 0.0, *(asked.known.get(name, 0.0) for name in _PLACES)])
    if number is not None and ways.shape is None:
        known[kernels.SHAPE] = number.to_free(number.start)
    free = np.array(
        [
            ways.scale is not None,
            ways.shape is not None,
            *(name not in asked.known for name in _PLACES),
        ]
    )
    for deepest, chosen in _by_depth(stretch):
        try:
            family = asked.family(deepest)
        except PymdrError as error:
            ended[chosen] = REFUSED
            refusals.add(str(error))
            continue
        part = slice(None) if chosen.size == count else chosen
        own = numbers[part], covariances[part], residuals[part], ended[part]
        kernels.fit_curves(
            stretch.place[part],
            stretch.force[part],
            stretch.softness[part],
            known,
            free,
            ways.is_tied,
            asked.contact.adhesion is not None,
            columns,
            family.table,
            *own,
        )
        if chosen.size < count:
            numbers[part], covariances[part], residuals[part], ended[part] = own
        end = family.end(numbers[chosen, kernels.SHAPE])
        beyond = chosen[(ended[chosen] == FOUND) & (numbers[chosen, 7] > end)]
        if beyond.size:
            ended[beyond] = REFUSED
            refusals.add(
                f"fit_map: pressed to {written(float(numbers[beyond, 7].max()), 'm', 4)}, and the profile ends at {written(float(end.min()), 'm', 4)} "
                "of depth; give it farther out"
            )
    if both:
        back = np.eye(len(asked.names))
        back[:2, :2] = np.linalg.inv(own_ways)
        with np.errstate(invalid="ignore"):  # curves that were not fitted have none
            covariances = back @ covariances @ back.T
    span = np.fmax.reduce(stretch.force, axis=1) - np.fmin.reduce(stretch.force, axis=1)
    told = _columns(asked, ways, numbers, covariances, residuals, span, ended)
    return FittedStretch(told, frozenset(refusals))


def reaches(stretch: Stretch) -> FloatArray:
    """Depths in m, rounded up, that the tables for each curve have to reach; 0 where it has none."""
    from pymdr.solving.fits import kernels

    spans = kernels.spans(stretch.place, stretch.force, stretch.softness)
    return np.array([rounded_up(float(span)) for span in spans])


def _by_depth(stretch: Stretch) -> Iterator[tuple[float, np.ndarray]]:
    """Curves by the depth that tables have to reach."""
    reach = reaches(stretch)
    for deepest in np.unique(reach[reach > 0.0]):
        yield float(deepest), np.flatnonzero(reach == deepest)


def _columns(
    asked: Asked,
    ways: Ways,
    numbers: FloatArray,
    covariances: FloatArray,
    residuals: FloatArray,
    span: FloatArray,
    ended: np.ndarray,
) -> Columns:
    """What is told of every curve."""
    out = empty_columns(asked, len(numbers))
    out["ending"][:] = ended
    theta, (misfit, used, depth, grows) = numbers[:, :5], numbers[:, 5:].T
    free = len(asked.names)
    with np.errstate(invalid="ignore", divide="ignore"):
        noise = np.sqrt(misfit / np.maximum(used - free, 1.0))
    correlated = np.ones(len(numbers))
    fitted = np.flatnonzero(np.isfinite(noise))
    if fitted.size:
        some = slice(None) if fitted.size == len(numbers) else fitted
        correlated[some], out[WAVES][some] = hanging(residuals[some], span[some])
    with np.errstate(invalid="ignore"):  # no noise in what a constant record leaves undetermined
        error = noise[:, None] * np.sqrt(correlated[:, None] * np.abs(np.einsum("ijj->ij", covariances)))
    values, rates = ways.values(theta[:, 0], theta[:, 1])
    plain = {name: theta[:, place] for name, place in _PLACES.items()}
    for i, name in enumerate(asked.names):
        value = plain[name] if name in plain else values[:, i]
        out[name][:] = value
        with np.errstate(invalid="ignore"):  # a number without end, known without error
            out[f"{name}_error"][:] = error[:, i] * (1.0 if name in plain else np.abs(rates[:, i]))
    for name, (low, high) in asked.bounded.items():
        outside = (out[name] < low) | (out[name] > high)
        out["ending"][outside & (ended == FOUND)] = AT_END
    if WORK in out:
        # the misfit tells where a pull of a few samples widens the error, and the error where the law leaves waves
        unseen = (grows < SEEN * correlated) & (out[WORK] < math.sqrt(SEEN) * out[f"{WORK}_error"])
        out["ending"][unseen & (ended == FOUND)] = AT_END
    out["noise"][:], out["correlated"][:], out["indentation"][:] = noise, correlated, depth
    return out
