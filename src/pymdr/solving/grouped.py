"""Statistics of values that come in groups, such as curves of samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.solving.study import Study, TextTable, dataset
from pymdr.units import ArrayQuantityLike, FloatArray, shown, to_si_array, written

_NORMAL, _FOR_RANKS = 1.959964, 6
"""Half width of a 95 % interval in standard deviations, and the fewest values between whose extremes a median is with 95 %."""


@dataclass(frozen=True, kw_only=True)
class GroupedValues(Study):
    """Medians of groups, and of all groups together."""

    data: xr.Dataset
    """
    Over ``group``: ``count``, ``median``, and ``median_low`` and ``median_high``, the ends of its interval, NaN with one value;
    ``typical``, ``typical_low`` and ``typical_high``, the geometric mean of the medians of all groups and its interval, and ``spread``, the standard deviation of the
    logarithms of these medians.
    """

    subject: ClassVar = "this study"
    claims_of_rows: ClassVar = False

    def _table(self) -> TextTable:
        unit = str(self.data["median"].attrs["units"])

        def text(value: float) -> str:
            return written(value, unit, 4) if math.isfinite(value) else "-"

        rows = [
            [
                str(group),
                str(int(self.data["count"][i])),
                *(text(float(self.data[name][i])) for name in ("median", "median_low", "median_high")),
            ]
            for i, group in enumerate(self.data["group"].values)
        ]
        ends = (text(float(self.data[name])) for name in ("typical", "typical_low", "typical_high"))
        rows.append(["all groups", str(int(self.data["count"].sum())), *ends])
        header = ["group", "values", "median", "95 % from", "to"]
        return (header, [""] * len(header)), rows


def _si_values(values: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    """Values in SI units; NaN of numbers that are missing."""
    if isinstance(values, np.ndarray) or all(
        isinstance(one, int | float) for one in np.atleast_1d(np.array(values, dtype=object))
    ):
        return np.asarray(values, dtype=float)
    return to_si_array(values, unit, name=name)


def summarize_groups(
    values: ArrayQuantityLike,
    groups: Sequence[str],
    *,
    unit: str = "Pa",
    name: str = "values",
    common: float = 0.0,
) -> GroupedValues:
    """
    Medians of values in groups, such as moduli of the curves of several samples, with intervals that respect the groups.

    Parameters
    ----------
    values : array_like of quantity
        Above 0, in the unit; NaN are left out.
    groups : sequence of str
        The group of each value: the sample, the animal, the day.
    unit : str
        The SI unit.
    name : str
        Name of the quantity in messages.
    common : float
        Relative standard uncertainty that all values share, such as that of a spring constant; it enters the interval over groups.

    Returns
    -------
    GroupedValues
        Over ``group``: median with its 95 % interval; ``typical``, the value over all groups with its interval.

    Raises
    ------
    ProblemError
        If `values` and `groups` differ in length, there is no value, a value is not above 0, or `common` is not from 0 to 0.5.

    Notes
    -----
    Curves of one sample are not independent samples. Within a group the interval of the median is that of order statistics, for any
    distribution (Thompson 1936), which needs six values for 95 %. With 2 to 5 it is that of the mean of the logarithms by Student's t, which is the
    interval of the median if the values are log-normal; a note names these groups. Over groups each counts once: with y_i the logarithms of their medians, the interval is
    mean(y) +- t s / sqrt(k) for k groups, with Student's t of k - 1 degrees of freedom, which contains the variation within as well as between groups (a random effect);
    a common uncertainty is added in quadrature. With one group the interval over groups is NaN.

    References
    ----------
    Thompson (1936), Ann. Math. Stat. 7, 122-128, doi:10.1214/aoms/1177732502

    Examples
    --------
    >>> import pymdr as mdr
    >>> study = mdr.summarize_groups([1e3, 1.1e3, 1.2e3, 4e3, 4.2e3, 4.4e3], ["a", "a", "a", "b", "b", "b"])
    >>> study["median"].values.tolist()
    [1100.0, 4200.0]
    >>> round(float(study["typical"]))
    2149
    """
    if not isinstance(common, int | float) or not 0.0 <= common <= 0.5:
        raise ProblemError(f"common = {shown(common)} (limits 0 and 0.5); give a relative uncertainty")
    flat = np.ravel(_si_values(values, unit, name))
    labels = np.array([str(group) for group in groups])
    if flat.size != labels.size:
        raise ProblemError(f"{flat.size} {name} and {labels.size} groups; give one group for each")
    known = np.isfinite(flat)
    if not known.any() or not (flat[known] > 0.0).all():
        raise ProblemError(f"{name} = {shown(values)}; numbers above 0 {unit} are needed")
    distinct = list(dict.fromkeys(labels[known].tolist()))
    rows = [_median_of_group(flat[known & (labels == group)]) for group in distinct]
    count, median, low, high = np.array(rows).T
    over_groups = dict(
        zip(("typical", "typical_low", "typical_high", "spread"), _over_groups(median, common), strict=True)
    )
    attributes = {"units": unit}
    return GroupedValues(
        data=dataset(
            {
                "count": ("group", count, {"units": ""}),
                "median": ("group", median, attributes),
                "median_low": ("group", low, attributes),
                "median_high": ("group", high, attributes),
                **{
                    one: ((), value, {"units": ""} if one == "spread" else attributes)
                    for one, value in over_groups.items()
                },
            },
            coords={"group": ("group", distinct, {"units": ""})},
        ),
        notes=_notes_on_groups(name, distinct, count, common),
    )


def _median_of_group(values: FloatArray) -> tuple[float, float, float, float]:
    """Number, median, and the ends of its interval: by order statistics, of few values by their logarithms, NaN with one."""
    from scipy.special import bdtr

    own = np.sort(values)
    if own.size < _FOR_RANKS:
        _, low, high, _ = _over_groups(own, 0.0)
        return float(own.size), float(np.median(own)), low, high
    # the rank below which the number of values under the median falls with at most 2.5 %
    ranks = bdtr(np.arange(own.size // 2), own.size, 0.5)
    rank = int(np.count_nonzero(ranks <= 0.025)) - 1
    return float(own.size), float(np.median(own)), float(own[rank]), float(own[-1 - rank])


def _notes_on_groups(name: str, groups: Sequence[str], count: FloatArray, common: float) -> tuple[str, ...]:
    """Notes on one group, on a common uncertainty, and on groups whose medians have an interval by a log-normal distribution, or none."""

    def named(chosen: NDArray[np.bool_]) -> str:
        return ", ".join(
            f"{group} ({int(n)})" for group, n, own in zip(groups, count, chosen, strict=True) if own
        )

    few, alone = (count > 1) & (count < _FOR_RANKS), count == 1
    remedy = f"measure {_FOR_RANKS} or more for an interval under any distribution"
    notes: tuple[str, ...] = ()
    if len(groups) == 1:
        notes += ("one group: the variation between groups is unknown",)
    if common > 0.0:
        notes += (
            f"standard uncertainty that all {name} share: {100.0 * common:.2g} %; it is in the interval over groups, not in the intervals of "
            "the medians",
        )
    if few.any():
        notes += (
            f"groups of fewer than {_FOR_RANKS} values: {named(few)}: the interval of the median is by Student's t of the logarithms, for log-normal values; {remedy}",
        )
    if alone.any():
        notes += (
            f"groups of one value: {named(alone)}: the median has no interval; {remedy}, or 2 for one of log-normal values",
        )
    return notes


def _over_groups(medians: FloatArray, common: float) -> tuple[float, float, float, float]:
    """Geometric mean of the medians, the ends of its interval, and the standard deviation of their logarithms."""
    from scipy.special import stdtrit

    logs, k = np.log(medians), medians.size
    mean, spread = float(logs.mean()), float(logs.std(ddof=1)) if k > 1 else math.nan
    half = float(stdtrit(k - 1.0, 0.975)) * spread / math.sqrt(k) if k > 1 else math.nan
    half = math.hypot(half, _NORMAL * common)
    return math.exp(mean), math.exp(mean - half), math.exp(mean + half), spread
