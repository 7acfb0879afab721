"""Fits of many curves by one family of forces."""

from __future__ import annotations

import logging
import math
from functools import cache

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
from pymdr.solving.fits.kernels import (
    AS_IT_IS,
    BASE,
    NUMBERS,
    POINT,
    SHAPE,
    Batch,
    Engine,
    FamilyTable,
    Found,
    Wanted,
    fit_curves,
)
from pymdr.solving.fits.kernels import TILT as TILTED
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.residuals import hanging
from pymdr.solving.fits.unknowns import BASELINE, CONTACT_POINT, TILT
from pymdr.units import FloatArray, written

_PLACES = {CONTACT_POINT: POINT, BASELINE: BASE, TILT: TILTED}
"""Of the origins among the numbers of the model."""
_DEPTH = NUMBERS + 2

_log = logging.getLogger("pymdr")


def fit_by_family(asked: Asked, ways: Ways, stretch: Stretch) -> FittedStretch:
    """What the search over one family of forces finds in some curves."""
    count, width = stretch.place.shape
    free = len(asked.names)
    found = Found(
        np.full((count, NUMBERS + 4), math.nan),
        np.full((count, free, free), math.nan),
        np.full((count, width), math.nan),
        np.full(count, UNREAD, dtype=np.int8),
    )
    refusals = set()
    wanted, own_ways = _wanted(asked, ways)
    engine = _compiled() if asked.many else AS_IT_IS
    reach = reaches(stretch)
    for deepest in np.unique(reach[reach > 0.0]):
        chosen = np.flatnonzero(reach == deepest)
        try:
            family = asked.family(float(deepest))
        except PymdrError as error:
            found.ended[chosen] = REFUSED
            refusals.add(str(error))
            continue
        own = found.of(chosen)
        curves = Batch(stretch.place[chosen], stretch.force[chosen], stretch.softness[chosen])
        table = FamilyTable(
            family.forces, family.slopes, family.folds, family.first, family.step, family.deepest
        )
        fit_curves(curves, wanted, table, own, engine)
        found.put(chosen, own)
        end = family.end(found.numbers[chosen, SHAPE])
        depths = found.numbers[:, _DEPTH]
        beyond = chosen[(found.ended[chosen] == FOUND) & (depths[chosen] > end)]
        if beyond.size:
            found.ended[beyond] = REFUSED
            refusals.add(
                f"fit_map: pressed to {written(float(depths[beyond].max()), 'm', 4)}, and the profile ends at {written(float(end.min()), 'm', 4)} "
                "of depth; give it farther out"
            )
    if own_ways.shape[1] == 2:
        back = np.eye(free)
        back[:2, :2] = np.linalg.inv(own_ways)
        with np.errstate(invalid="ignore"):  # curves that were not fitted have none
            found = found._replace(covariances=back @ found.covariances @ back.T)
    span = np.fmax.reduce(stretch.force, axis=1) - np.fmin.reduce(stretch.force, axis=1)
    return FittedStretch(_columns(asked, ways, found, span), frozenset(refusals))


def _compiled() -> Engine:
    """The search with what is done at every sample compiled; as it is where numba is missing, which is said once."""
    try:
        from pymdr.solving.fits.kernels import compiled
    except ImportError:
        _say_slow()
        return AS_IT_IS
    return compiled.ENGINE


@cache
def _say_slow() -> None:
    _log.warning(
        "numba cannot be imported: the curves of maps are fitted some fifty times slower; install numba"
    )


def _wanted(asked: Asked, ways: Ways) -> tuple[Wanted, FloatArray]:
    """What the search looks for, and the rates of scale and number of the family over the unknowns."""
    rates, number = ways.columns(), ways.number
    directions = np.zeros((len(asked.names), NUMBERS))
    # both numbers of the family are searched by themselves, so that one of them may rest at its end
    directions[: len(ways.unknowns), :2] = np.eye(2) if rates.shape[1] == 2 else rates.T
    for i, name in enumerate(asked.origins, len(ways.unknowns)):
        directions[i, _PLACES[name]] = 1.0
    known = np.array([0.0, 0.0, *(asked.known.get(name, 0.0) for name in _PLACES)])
    if number is not None and ways.shape is None:
        known[SHAPE] = number.to_free(number.start)
    free = [ways.scale is not None, ways.shape is not None, *(name not in asked.known for name in _PLACES)]
    return Wanted(known, np.array(free), directions, ways.is_tied, asked.contact.adhesion is not None), rates


def reaches(stretch: Stretch) -> FloatArray:
    """Depths in m, rounded up, that the tables for each curve have to reach; 0 where it has none."""
    depth = stretch.place - stretch.softness[:, None] * stretch.force
    depth = np.where(np.isfinite(depth), depth, math.nan)
    spans = np.fmax.reduce(depth, axis=1) - np.fmin.reduce(depth, axis=1)
    return np.array([rounded_up(span) for span in np.nan_to_num(spans).tolist()])


def _columns(asked: Asked, ways: Ways, found: Found, span: FloatArray) -> Columns:
    """What is told of every curve."""
    numbers, ended = found.numbers, found.ended
    out = empty_columns(asked, len(numbers))
    out["ending"][:] = ended
    theta, (misfit, used, depth, grows) = numbers[:, :NUMBERS], numbers[:, NUMBERS:].T
    free = len(asked.names)
    with np.errstate(invalid="ignore", divide="ignore"):
        noise = np.sqrt(misfit / np.maximum(used - free, 1.0))
    correlated = np.ones(len(numbers))
    fitted = np.flatnonzero(np.isfinite(noise))
    if fitted.size:
        some = slice(None) if fitted.size == len(numbers) else fitted
        correlated[some], out[WAVES][some] = hanging(found.residuals[some], span[some])
    with np.errstate(invalid="ignore"):  # no noise in what a constant record leaves undetermined
        error = noise[:, None] * np.sqrt(
            correlated[:, None] * np.abs(np.einsum("ijj->ij", found.covariances))
        )
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
