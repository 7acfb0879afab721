"""Refusals of unknowns that records do not determine."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import WORKS, Unknown, put_into
from pymdr.units import FloatArray, written

_INDISTINCT = 1e-6
"""Ratio to the largest singular value below which a combination of unknowns is not determined."""
_EQUAL = 1e-6
"""Largest relative difference of equal works."""
_LARGEST_ERROR = math.log(1e3)
_EDGE_ERROR = math.log(4.0) / (2.0 * 1.96)
"""Largest standard error of the logarithm of an unknown or a combination that an adhesive edge with memory determines: its 95 % interval spans a factor of 4."""
_ALONE = 0.05
"""Smallest component of a combination, relative to the largest."""
_BEYOND = 1e6
"""Ratio of a size to its start beyond which it diverges."""


def refuse_undetermined(search: Search, free: FloatArray, slopes: FloatArray) -> None:
    """Refuse unknowns that the records cannot distinguish."""
    own, sizes = _own_slopes(search, slopes)
    left = np.linalg.norm(own, axis=0)
    undetermined = left <= _INDISTINCT * np.maximum(sizes, sizes.max())
    if undetermined.any():
        raise ProblemError(_undetermined_text(search, free, undetermined))
    _, singular, rows = np.linalg.svd(own / np.linalg.norm(own, axis=0), full_matrices=False)
    if singular[-1] > _INDISTINCT * singular[0]:
        return
    direction = rows[-1] / np.linalg.norm(own, axis=0)
    raise ProblemError(_combination_text(search, free, direction / np.abs(direction).max()))


def refuse_equal_works(search: Search, free: FloatArray) -> None:
    """Refuse hysteresis of adhesion that the records do not show, with the work of a law without it."""
    if not search.contact.has_edge_history or WORKS[1] not in search.names:
        return
    law = put_into(search.contact, search.unknowns, search.from_free(free)[0]).adhesion
    assert law is not None
    advancing, receding = law.works
    if receding <= advancing * (1.0 + _EQUAL):
        raise ProblemError(
            f"the record shows no hysteresis of adhesion: both works are {written(advancing, 'J/m^2', 4)} at the best fit; fit JKR(work) without "
            "work_receding"
        )


def refuse_noisy(search: Search, free: FloatArray, slopes: FloatArray, noise: float) -> None:
    """
    Refuse sizes whose error by the noise of the records, in N, exceeds a factor of a thousand.

    For an adhesive edge with memory, an unknown, or a combination such as that of work and range, is refused whose 95 % interval spans more than a
    factor of 4: its rates are differences over such steps.
    """
    if not all(u.is_size for u in search.unknowns) or not search.unknowns:
        return
    own, _ = _own_slopes(search, slopes)
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    weakest = rows[-1] / np.abs(rows[-1]).max()
    combined = np.count_nonzero(np.abs(weakest) > _ALONE) > 1
    limit = _EDGE_ERROR if _adheres_by_rate(search) else _LARGEST_ERROR
    if noise <= limit * singular[-1]:
        return
    if combined:
        raise ProblemError(_combination_text(search, free, np.where(np.abs(weakest) > _ALONE, weakest, 0.0)))
    undetermined = np.abs(weakest) == 1.0
    if _adheres_by_rate(search):
        raise ProblemError(_loose_text(search, free, int(np.argmax(undetermined))))
    raise ProblemError(_undetermined_text(search, free, undetermined))


def _own_slopes(search: Search, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rates of the residuals over the unknowns orthogonal to those of the origins, and their norms before that."""
    n = len(search.unknowns)
    own, origin = slopes[:, :n], slopes[:, n:]
    sizes = np.linalg.norm(own, axis=0)
    if origin.shape[1]:
        own = own - origin @ np.linalg.lstsq(origin, own, rcond=None)[0]
    return own, sizes


def _undetermined_text(search: Search, free: FloatArray, undetermined: BoolArray) -> str:
    """Message on unknowns without an effect, and what is determined."""
    values, _ = search.from_free(free)
    texts = [_value_text(u, float(v)) for u, v in zip(search.unknowns, values, strict=True)]
    unseen = [one for one, is_unseen in zip(texts, undetermined, strict=True) if is_unseen]
    seen = [one for one, is_unseen in zip(texts, undetermined, strict=True) if not is_unseen]
    rest = f"; it determines {', '.join(seen)}" if seen else ""
    names = " and ".join(
        u.name for u, is_unseen in zip(search.unknowns, undetermined, strict=True) if is_unseen
    )
    verb, pronoun = ("has", "it") if len(unseen) == 1 else ("have", "them")
    sizes = all(u.is_size for u, is_unseen in zip(search.unknowns, undetermined, strict=True) if is_unseen)
    more = more_samples_text(search) if sizes else ""
    return (
        f"{names} {verb} no effect on the record; the best fit has {', '.join(unseen)}{rest}; {more}leave {names} out of free, or use a contact "
        f"without {pronoun}"
    )


def more_samples_text(search: Search) -> str:
    """Hint on the samples of short records with adhesion."""
    return (
        ""
        if search.contact.adhesion is None
        else "record more samples (those adjacent to jumps are left out), "
    )


def _loose_text(search: Search, free: FloatArray, i: int) -> str:
    """Message on an unknown whose interval is too wide."""
    values, _ = search.from_free(free)
    unknown = search.unknowns[i]
    return (
        f"the record hardly determines {unknown.name}: the best fit has {_value_text(unknown, float(values[i]))}, but its 95 % interval spans more than a "
        f"factor of 4; leave it out of free, or add retractions at other speeds"
    )


def _value_text(unknown: Unknown, value: float) -> str:
    """Text of a value, in words if it diverges."""
    if unknown.is_size and value < unknown.start / _BEYOND:
        return f"{unknown.name} near 0"
    if unknown.is_size and value > unknown.start * _BEYOND:
        return f"{unknown.name} unbounded"
    return f"{unknown.name} = {written(value, unknown.unit, 4)}"


def _combination_text(search: Search, free: FloatArray, direction: FloatArray) -> str:
    """Message on unknowns of which only a combination is determined."""
    values, _ = search.from_free(free)
    moving = [i for i in range(direction.size) if abs(direction[i]) > 1e-3]
    names = [search.unknowns[i].name for i in moving]
    text = f"the record cannot distinguish {' and '.join(names)}"
    record = search.curves[0]
    if isinstance(record, ShearRecord):
        stiffness, load = record.stuck(put_into(search.contact, search.unknowns, values))
        text += (
            f": it determines the tangential stiffness at full stick, {stiffness:.4g} N/m under "
            f"{written(load, 'N', 4)}"
        )
    elif all(search.unknowns[i].is_size for i in moving):
        last = max(moving, key=lambda i: (round(abs(float(direction[i])), 3), i))
        products = []
        for i in moving:
            if i != last:
                power = round(-direction[i] / direction[last], 3)
                value = float(values[i] * values[last] ** power)
                u, v = search.unknowns[i], search.unknowns[last]
                products.append(f"{u.name} x {v.name}^{power:g} = {value:.4g} (in {u.unit} and {v.unit})")
        text += f": it determines {', and '.join(products)}"
    more = ", or add retractions at other speeds" if _adheres_by_rate(search) else ""
    return f"{text}; fix one of them{more}"


def _adheres_by_rate(search: Search) -> bool:
    """Whether unknowns of adhesion act on a body with memory, where retreats at other speeds tell more."""
    adhesive = any(name.startswith("adhesion.") for name in search.names)
    return adhesive and search.contact.has_edge_history and search.contact.is_viscoelastic
