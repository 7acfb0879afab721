"""Long records: means of neighbouring samples state what all samples state of a force that is straight between neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pymdr.numerics.panels import IndexArray
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.minimizing import Minimum, minimize_from
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import FULLY_OUT, BoolArray
from pymdr.units import FloatArray

_ENOUGH, _PRESSED, _PULLED = 16_384, 1_000, 200
"""Means of a long record, those of them in contact, and with a pull."""
_ROUNDS, _SETTLED = 8, 1e-3
"""Largest number of steps, and the length in standard errors below which a step is the last."""


def condensed(search: Search) -> Search:
    """
    The search over the means of neighbouring samples of very long records; the same search if a record is not that long.

    As many means remain as show the contact and the pull.
    """
    if search.shears or search.contact.is_viscoelastic or search.used:
        return search
    size = min(_block_size(one) for one in search.measured)
    if size == 1:
        return search
    return replace(search, curves=tuple(_condensed(one, size) for one in search.measured))


def _block_size(curve: MeasuredCurve) -> int:
    """Number of samples of a record of which the mean is enough."""
    level = float(np.median(curve.force[np.argsort(curve.position)[: max(curve.force.size // 20, 1)]]))
    above = curve.force - level
    pressed = np.count_nonzero(above > 0.05 * float(above.max()))
    pulled = np.count_nonzero(above < FULLY_OUT * float(above.min()))
    return max(min(curve.force.size // _ENOUGH, int(pressed) // _PRESSED, int(pulled) // _PULLED), 1)


def _condensed(curve: MeasuredCurve, size: int) -> MeasuredCurve:
    """The record of the means of blocks of about so many samples."""
    starts = _starts(curve.force.size, curve.force.size // size)

    def means(column: FloatArray | None) -> FloatArray | None:
        return None if column is None else block_means(column, starts)

    return MeasuredCurve(
        force=block_means(curve.force, starts),
        indentation=means(curve.indentation),
        travel=means(curve.travel),
        spring_constant=curve.spring_constant,
    )


def _starts(samples: int, blocks: int) -> IndexArray:
    """First samples of blocks of equal size, up to one sample."""
    return np.asarray(np.arange(blocks) * samples // blocks)


def block_means(column: FloatArray, starts: IndexArray) -> FloatArray:
    """Means over the blocks that begin at some samples."""
    return np.asarray(np.add.reduceat(column, starts) / np.diff(np.append(starts, column.size)))


class Blocks:
    """The blocks of long records, those adjacent to jumps left out."""

    def __init__(self, search: Search, few: Search, used: tuple[BoolArray, ...]) -> None:
        pairs = zip(search.measured, few.measured, strict=True)
        self._starts = [_starts(one.force.size, mean.force.size) for one, mean in pairs]
        kept = [np.logical_and.reduceat(one, starts) for one, starts in zip(used, self._starts, strict=True)]
        sizes = [np.diff(np.append(starts, one.size)) for one, starts in zip(used, self._starts, strict=True)]
        self.search = replace(
            search, used=tuple(np.repeat(own, size) for own, size in zip(kept, sizes, strict=True))
        )
        self.few = replace(few, used=tuple(kept))

    @property
    def lengths(self) -> list[int]:
        """Number of used blocks of each record."""
        return [int(one.sum()) for one in self.few.used]

    def means(self, columns: list[FloatArray]) -> FloatArray:
        """Means over the used blocks of a column of each record."""
        rows = zip(columns, self._starts, self.few.used, strict=True)
        return np.concatenate([block_means(column, starts)[used] for column, starts, used in rows])

    def slopes(self, free: FloatArray) -> FloatArray:
        """Rates of the means of the residuals over the free numbers of the search with all samples."""
        few, n = self.few, len(self.search.unknowns)
        values, origins = self.search.from_free(free)
        slopes = few.slopes(few.to_free(values.tolist(), origins))
        slopes[:, n:] *= self.search.origin_scales / few.origin_scales
        return slopes

    def refined(self, start: FloatArray) -> Minimum:
        """
        The least squares of all samples near an end, by steps of Gauss and Newton with the rates at the start.

        If the steps do not settle, or leave the bounds, the end is that of a search with all samples.
        """
        search, free = self.search, start.copy()
        low, high = np.array(search.bounds()).T
        slopes = self.slopes(free)
        scale = np.linalg.norm(slopes, axis=0)
        scale[scale == 0.0] = 1.0
        left, right = np.linalg.qr(slopes / scale)
        residuals = [one.force - one.model for one in search.models(free)]
        for trial in range(1, _ROUNDS + 1):
            means = self.means(residuals)
            toward = left.T @ means
            step = np.linalg.lstsq(right, -toward, rcond=None)[0] / scale
            if not np.all((low < free + step) & (free + step < high)):
                break
            free = free + step
            if float(toward @ toward) <= _SETTLED**2 * float(means @ means) / means.size:
                square = sum(
                    float((one[used] ** 2).sum()) for one, used in zip(residuals, search.used, strict=True)
                )
                return Minimum(free, square, True, trial, "")
            residuals = [one.force - one.model for one in search.models(free)]
        return minimize_from(search, start)
