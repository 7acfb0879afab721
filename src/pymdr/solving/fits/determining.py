"""What records determine, and the refusal of what they do not."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import (
    Unknown,
    put_into,
)
from pymdr.units import FloatArray, written

_BLIND = 1e-6
"""Of the largest: singular values of unknowns that a record cannot tell apart."""
_LOST = math.log(1e3)
_ALONE = 0.05
"""Of the unknown that moves most: what the others take part in."""
_BEYOND = 1e6
"""Times the start: a size that nothing holds back."""


def refuse_blind(search: Search, free: FloatArray) -> None:
    """
    Refuse unknowns that the records cannot tell apart.

    Raises
    ------
    ProblemError
        With what they do determine.
    """
    own, sizes = _own_slopes(search, search.slopes(free))
    left = np.linalg.norm(own, axis=0)
    unfelt = left <= _BLIND * np.maximum(sizes, sizes.max())
    if unfelt.any():
        raise ProblemError(_unfelt(search, free, unfelt))
    _, singular, rows = np.linalg.svd(own / np.linalg.norm(own, axis=0), full_matrices=False)
    if singular[-1] > _BLIND * singular[0]:
        return
    direction = rows[-1] / np.linalg.norm(own, axis=0)
    raise ProblemError(_combination(search, free, direction / np.abs(direction).max()))


def refuse_lost(search: Search, free: FloatArray, slopes: FloatArray, noise: float) -> None:
    """
    Refuse sizes that the noise of records, in N, moves by more than a factor of a thousand.

    Raises
    ------
    ProblemError
        With what the records do determine.
    """
    if not all(u.is_size for u in search.unknowns) or not search.unknowns:
        return
    own, _ = _own_slopes(search, slopes)
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    if noise <= _LOST * singular[-1]:
        return
    weakest = rows[-1] / np.abs(rows[-1]).max()
    if np.count_nonzero(np.abs(weakest) > _ALONE) > 1:
        raise ProblemError(_combination(search, free, np.where(np.abs(weakest) > _ALONE, weakest, 0.0)))
    lost = np.abs(weakest) == 1.0
    raise ProblemError(_unfelt(search, free, lost))


def _own_slopes(search: Search, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rates of the residuals over the unknowns, without what the origins of the records take up, and how large they were with that."""
    n = len(search.unknowns)
    own, origin = slopes[:, :n], slopes[:, n:]
    sizes = np.linalg.norm(own, axis=0)
    if origin.shape[1]:
        own = own - origin @ np.linalg.lstsq(origin, own, rcond=None)[0]
    return own, sizes


def _unfelt(search: Search, free: FloatArray, unfelt: BoolArray) -> str:
    """What is determined where unknowns leave no trace."""
    values, _ = search.from_free(free)
    told = [_near(u, float(v)) for u, v in zip(search.unknowns, values, strict=True)]
    silent = [one for one, is_silent in zip(told, unfelt, strict=True) if is_silent]
    heard = [one for one, is_silent in zip(told, unfelt, strict=True) if not is_silent]
    rest = f"; it determines {', '.join(heard)}" if heard else ""
    names = " and ".join(u.name for u, is_silent in zip(search.unknowns, unfelt, strict=True) if is_silent)
    return (
        f"fit: the record does not feel {names}, which is fitted best with {', '.join(silent)}{rest}; leave {names} out of free, or take a contact "
        "without it"
    )


def _near(unknown: Unknown, value: float) -> str:
    """A value in words where a search took it beyond all measure."""
    if unknown.is_size and value < unknown.start / _BEYOND:
        return f"{unknown.name} near 0"
    if unknown.is_size and value > unknown.start * _BEYOND:
        return f"{unknown.name} without end"
    return f"{unknown.name} = {written(value, unknown.unit, 4)}"


def _combination(search: Search, free: FloatArray, direction: FloatArray) -> str:
    """What is determined where unknowns may change along a direction without a trace."""
    values, _ = search.from_free(free)
    moving = [i for i in range(direction.size) if abs(direction[i]) > 1e-3]
    names = [search.unknowns[i].name for i in moving]
    told = f"fit: the record cannot tell {' and '.join(names)} apart"
    record = search.curves[0]
    if isinstance(record, ShearRecord):
        stiffness, load = record.stuck(put_into(search.contact, search.unknowns, values))
        told += (
            f": of the bodies it determines the tangential stiffness where they stick, {stiffness:.4g} N/m under "
            f"{written(load, 'N', 4)}"
        )
    elif all(search.unknowns[i].is_size for i in moving):
        last = max(moving, key=lambda i: abs(direction[i]))
        products = []
        for i in moving:
            if i != last:
                power = round(-direction[i] / direction[last], 3)
                value = float(values[i] * values[last] ** power)
                u, v = search.unknowns[i], search.unknowns[last]
                products.append(f"{u.name} x {v.name}^{power:g} = {value:.4g} (in {u.unit} and {v.unit})")
        told += f": it determines {', and '.join(products)}"
    return f"{told}; fix one of them"
