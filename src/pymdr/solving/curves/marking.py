"""Marked samples: single outliers, and the plateau of a saturated detector."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy

from pymdr.errors import ProblemError
from pymdr.problem.facts import Facts
from pymdr.problem.measured import BoolArray, Samples, Step
from pymdr.solving.curves.branches import spread
from pymdr.units import FloatArray, written

_WINDOW, _AROUND = 15, 101
_FAR = 8.0
"""Distance of an outlier relative to the noise; about one normal sample in 10^15 exceeds it."""
_SHORT = 3
SHORTEST, FLAT = 5, 1e-3
"""Samples of a plateau, and the largest spread of its forces relative to their range."""


def mark_outliers(curve: Samples) -> Samples:
    """
    Mark outliers, without removing them.

    An outlier, or up to three in a row, is more than 8 times the noise from the median of its 15 neighbours (Hampel's filter; Davies and
    Gather, J. Am. Stat. Assoc. 88 (1993) 782) and from the lines through four samples before and after it, and three times as far from these
    lines as those samples, so that jumps, cusps and rough parts of the force are not outliers.

    Returns
    -------
    MeasuredCurve
        With `outliers` and the step.
    """
    force = curve.force
    marks = np.zeros(force.size, dtype=bool)
    deviation = force - scipy.ndimage.median_filter(force, size=min(_WINDOW, force.size), mode="nearest")
    steps = np.abs(np.diff(force))
    # coarsely digitised forces are mostly equal
    noise = max(spread(deviation), float(np.median(steps[steps > 0.0])) if np.any(steps) else 0.0)
    around = np.maximum(
        noise,
        1.4826
        * scipy.ndimage.median_filter(np.abs(deviation), size=min(_AROUND, force.size), mode="nearest"),
    )
    for first, end in _runs(np.abs(deviation) > _FAR * around):
        if end - first <= _SHORT and _stands_out(force, first, end, _FAR * float(around[first])):
            marks[first:end] = True
    count = int(np.count_nonzero(marks))
    text = (
        f"{_counted(count, 'outlier')} marked, more than {written(_FAR * noise, 'N')} from the samples around"
    )
    return replace(
        curve,
        outliers=marks,
        step=Step("outliers", text, Facts({"count": float(count), "limit": _FAR * noise})),
        before=curve,
    )


def mark_saturated(curve: Samples) -> Samples:
    """
    Mark the plateau at the largest force, where the detector was saturated.

    At least five samples in a row have the largest force, to a thousandth of its range and a quarter of the noise, while the position
    changed by more than 1 % of its range; then all samples of that force are marked. Apply it to the correct signs and before the baseline
    is subtracted, which tilts the plateau.

    Returns
    -------
    MeasuredCurve
        With `saturated` and the step.
    """
    force, position = curve.force, curve.position
    largest, size = float(force.max()), float(np.ptp(force))
    differences = np.diff(force)
    allowed = min(FLAT * size, 0.25 * spread(differences)) + 1e-9 * size
    largest_of_all = force >= largest - allowed
    plateau = any(
        end - first >= SHORTEST and float(np.ptp(position[first:end])) > 0.01 * float(np.ptp(position))
        for first, end in _runs(largest_of_all)
    )
    marks = largest_of_all & plateau
    count = int(np.count_nonzero(marks))
    text = (
        f"{_counted(count, 'sample')} marked at the largest force, {written(largest, 'N')}, where the detector was saturated"
        if count
        else f"no plateau at the largest force, {written(largest, 'N')}"
    )
    return replace(
        curve,
        saturated=marks,
        step=Step("saturation", text, Facts({"count": float(count), "largest": largest})),
        before=curve,
    )


def leave_out_marked(curve: Samples) -> Samples:
    """
    A curve without the marked samples.

    Returns
    -------
    MeasuredCurve
        With the step; its `before` still has them.

    Raises
    ------
    ProblemError
        If fewer than 8 samples are left.
    """
    kept = ~curve.marked
    count = int(np.count_nonzero(~kept))
    if np.count_nonzero(kept) < 8:
        raise ProblemError(
            f"{count} of {kept.size} samples are marked, which leaves {kept.size - count} (limit 8); measure again with a larger "
            "detector range, or undo() the marks"
        )

    def part(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else values[kept]

    return replace(
        curve,
        force=curve.force[kept],
        indentation=part(curve.indentation),
        travel=part(curve.travel),
        time=part(curve.time),
        outliers=None,
        saturated=None,
        step=Step("left out", f"{_counted(count, 'marked sample')} left out", Facts({"count": float(count)})),
        before=curve,
    )


def _counted(count: int, word: str) -> str:
    return f"{count or 'no'} {word}{'' if count == 1 else 's'}"


def _runs(where: BoolArray) -> Iterator[tuple[int, int]]:
    """First samples and ends of runs of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _stands_out(force: FloatArray, first: int, end: int, least: float) -> bool:
    """Whether samples are off the lines through those before and after them, on the same side of both."""
    places = np.arange(first, end)
    sides = []
    for near in (np.arange(max(first - 4, 0), first), np.arange(end, min(end + 4, force.size))):
        if near.size >= 3:
            slope, at = np.polyfit(near - first, force[near], 1)
            rough = float(np.max(np.abs(force[near] - at - slope * (near - first))))
            least = max(least, 3.0 * rough)
            sides.append(force[places] - (at + slope * (places - first)))
    alike = len({bool(side[0] > 0.0) for side in sides}) == 1
    return alike and all(bool(np.all(np.abs(side) > least)) for side in sides)
