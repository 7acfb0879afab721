"""The first pop-in of indents, and the shear stress under the tip at its load."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Path
from pymdr.solving.nanoindentation.records import Record, Records, attempted, numbered, records_of, refusals
from pymdr.solving.nanoindentation.unloading import noise_of
from pymdr.solving.study import Column, Study, dataset
from pymdr.solving.verb import solve
from pymdr.solving.yielding import first_yield
from pymdr.units import FloatArray, QuantityLike, metres, newtons, pascals, shown, to_si

_WINDOWS, _GAPS = (6, 12, 24, 48), (0, 1, 3, 7, 15)
"""Rows on either side of a jump, and rows within it, that are tried."""
_SIGNIFICANT, _STANDS_OUT = 6.0, 4.0
"""A jump over its standard deviation, and over the jumps of the smooth curve nearby."""
_FEWEST = 20
_SLOPES = 9
"""Slopes before a jump, of which the median is taken."""
_CONTACT, _ELASTIC = 4.0, 0.2
_NORMAL = 1.959964
_BETWEEN = 3.0
"""Distance from a line in standard deviations from which on a row is within a jump."""
_DRAWN = 6


class _Event(NamedTuple):
    """A jump after one row of the loading."""

    row: int
    """Of the record, the last one before the jump."""
    force: float
    force_low: float
    force_high: float
    depth: float
    jump: float
    jump_half: float


class _Search(NamedTuple):
    """The first jump of one record, if there is one, and the smallest one that its noise would show."""

    event: _Event | None
    smallest: float


@dataclass(frozen=True, kw_only=True)
class PopIn(Study):
    """
    The first pop-in over ``indent``; nan where an indent has none above ``smallest_jump``.

    ``pop_in_force`` (N) and ``pop_in_jump`` (m) with the ends of their 95 % intervals, ``pop_in_depth`` (m) before the jump, ``smallest_jump`` (m) that the
    noise would show; with a contact ``largest_shear`` (Pa) at the load of the pop-in, and with a shear strength ``strength_force`` (N), at which the
    largest shear stress reaches it.
    """

    records: tuple[tuple[FloatArray, FloatArray], ...]
    """Depths in m and forces in N."""

    subject: ClassVar[str] = "a first pop-in"
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "indent": Column("indent", ""),
        "record": Column("record", ""),
        "pop_in_force": Column("F", "N"),
        "pop_in_force_low": Column("low", "N"),
        "pop_in_force_high": Column("high", "N"),
        "pop_in_depth": Column("h", "m"),
        "pop_in_jump": Column("jump", "m"),
        "smallest_jump": Column("smallest", "m"),
        "largest_shear": Column("tau_max", "Pa"),
    }

    def _remarks(self) -> list[str]:
        if "strength_force" not in self.data:
            return []
        return [
            f"the largest shear stress is {pascals(float(self.data.attrs['shear_strength']))} at {newtons(float(self.data['strength_force']))}"
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Loading curves with their pop-ins, and the loads in order."""
        return plot.pop_in_study(self.records[:_DRAWN], self.data)


def first_pop_in(
    records: Records,
    contact: Contact | None = None,
    *,
    shear_strength: QuantityLike | None = None,
    significance: float = _SIGNIFICANT,
) -> PopIn:
    """
    Load of the first pop-in of indents, and the largest shear stress under the tip at this load.

    A pop-in is a jump of h - s F^(2/3) between straight lines through the rows before and after it, with the slope s before it: of the depth at
    constant force, of the force at constant depth, or of both. In the elastic contact of a sphere this quantity is constant.

    Parameters
    ----------
    records : MeasuredCurve, xarray.Dataset or mapping of str to array_like, or a sequence of them
        Indents with their loading, in the order of measurement.
    contact : Contact, optional
        Round tip and bodies, elastic, without adhesion and friction, for the shear stress.
    shear_strength : quantity, optional
        In Pa; the load is computed at which the largest shear stress in the body reaches it. It needs a contact.
    significance : float, optional
        Smallest jump that counts, in standard deviations, 3 or more; 6 unless given, at which noise makes fewer than one jump in 1e5 records.

    Returns
    -------
    PopIn
        Loads, depths and jumps, with intervals. Of several indents, those that cannot be searched are nan, and a note gives the reason.

    Raises
    ------
    ProblemError
        If no record has 20 rows of loading, or an argument is outside its limits.
    NotValidError
        If the shear stress under the tip is not known or has no bound, as at sharp tips.

    See Also
    --------
    first_yield : the load at which a body yields.

    Notes
    -----
    The largest shear stress below a sphere is 0.31 of Hertz's largest pressure for nu = 0.3 (Johnson 1985, section 4.2). The force of the last row before the
    jump is the load; it is certain to half of the distance to the next row, and to the rows that the noise allows. A jump that spreads over more than 16 rows is not found.

    References
    ----------
    Johnson (1985), Contact Mechanics, Cambridge University Press, doi:10.1017/CBO9781139171731.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> force = np.linspace(0, 1e-3, 401)
    >>> depth = 100e-9 * (force / 1e-3) ** (2 / 3) + np.where(force > 0.4e-3, 8e-9, 0.0)
    >>> depth += 0.05e-9 * np.random.default_rng(1).normal(size=401)
    >>> study = mdr.first_pop_in(mdr.MeasuredCurve(force=force, indentation=depth))
    >>> study.to("pop_in_force", "mN").values.round(3).tolist(), study.to("pop_in_jump", "nm").values.round().tolist()
    ([0.4], [8.0])
    """
    listed = records_of(records)
    if (
        isinstance(significance, bool)
        or not isinstance(significance, int | float)
        or not 3.0 <= significance <= 100.0
    ):
        raise ProblemError(f"significance = {shown(significance)}; a number from 3 to 100 is needed")
    strength = None if shear_strength is None else to_si(shear_strength, "Pa", name="shear_strength")
    if strength is not None and not strength > 0.0:
        raise ProblemError(f"shear_strength = {shown(shear_strength)}; it must be above 0 Pa")
    if contact is None and strength is not None:
        raise ProblemError("shear_strength needs a contact; give Contact(Sphere('1 um'), sample, diamond)")
    if contact is not None and not isinstance(contact, Contact):
        raise ProblemError(f"contact = {shown(contact)}; give Contact(Sphere('1 um'), sample, diamond)")
    if contact is not None and (contact.adhesion is not None or contact.friction is not None):
        raise ProblemError(
            "the contact has adhesion or friction, which the analysis of pop-ins does not include; leave both out"
        )
    errors: dict[int, ProblemError] = {}
    by_number = attempted(listed, lambda _, record: _search(record, float(significance)), errors)
    searches = [by_number.get(number, _Search(None, math.nan)) for number in range(1, len(listed) + 1)]
    study = _study(listed, searches, contact, strength)
    return replace(study, notes=(*refusals(errors), *study.notes))


def _search(record: Record, significance: float) -> _Search:
    force, depth = record.force, record.depth
    noise = noise_of(force)
    largest = float(np.max(force))
    if not largest > 0.0:
        raise ProblemError("no force is above 0 N; compressive forces must be positive")
    end = int(np.argmax(force >= largest - _CONTACT * noise)) + 1
    low = np.flatnonzero(force[:end] <= _CONTACT * noise)
    start = int(low[-1]) + 1 if low.size else 0
    rows = slice(start, end)
    if end - start < _FEWEST:
        raise ProblemError(
            f"{end - start} rows of the loading are above the noise of the force; at least {_FEWEST} are needed"
        )
    h, f = depth[rows], force[rows]
    q = np.maximum(f, 0.0) ** (2.0 / 3.0)
    noise_h = noise_of(h)
    noise_q = 2.0 / 3.0 * np.maximum(f, _CONTACT * noise + 1e-300) ** (-1.0 / 3.0) * noise
    best, smallest = None, math.inf
    tables = [
        _jumps(h, q, noise_h, noise_q, window, gap)
        for window in _WINDOWS
        for gap in _GAPS
        if 2 * window + gap <= h.size and gap <= 2 * window
    ]
    smallest = min((float(np.nanmedian(t.deviation)) * significance for t in tables), default=math.nan)
    candidates = [(int(rows_[0]), t) for t in tables if (rows_ := t.significant(significance)).size]
    if candidates:
        first = min(candidates, key=lambda one: (one[0], one[1].window))
        near = first[0] + first[1].window + first[1].gap
        _, row, best = max(
            (
                (float(t.ratio[i]), int(i), t)
                for _, t in candidates
                for i in t.significant(significance)
                if i <= near
            ),
            key=lambda one: one[0],
        )
        return _Search(_event(best, row, (h, q, f), start, noise), smallest)
    return _Search(None, smallest)


class _Jumps(NamedTuple):
    """Jumps after each row by one window and gap; nan near the ends."""

    window: int
    gap: int
    jump: FloatArray
    deviation: FloatArray
    nearby: FloatArray
    """Median of the jumps around, without those of the windows at the row."""
    slope: FloatArray
    """s in m/N^(2/3)."""

    @property
    def ratio(self) -> FloatArray:
        """Over the standard deviation."""
        return self.jump / self.deviation

    def significant(self, level: float) -> np.ndarray:
        """Rows after which there is a jump."""
        with np.errstate(invalid="ignore"):
            return np.flatnonzero((self.ratio > level) & (self.jump > _STANDS_OUT * self.nearby))


def _jumps(
    h: FloatArray, q: FloatArray, noise_h: float, noise_q: FloatArray, window: int, gap: int
) -> _Jumps:
    n = h.size
    x = np.arange(window) - 0.5 * (window - 1)
    out = 0.5 * (window + gap)
    square = float(np.sum(x * x))
    ahead = 1.0 / window + out * x / square
    # what the line through a window is worth half of the gap beyond its end, and before its start
    left_h, left_q = (np.convolve(values, ahead[::-1], mode="valid") for values in (h, q))
    right_h, right_q = (np.convolve(values, ahead, mode="valid") for values in (h, q))
    slope_h, slope_q = (np.convolve(values, (x / square)[::-1], mode="valid") for values in (h, q))
    # the slope before the jump from more rows, in which noise matters less
    wide = max(1, _WINDOWS[-2] // window)
    kernel = np.ones(wide)
    count = np.convolve(np.ones_like(slope_h), kernel)[: slope_h.size]
    mean_h, mean_q = (np.convolve(values, kernel)[: slope_h.size] / count for values in (slope_h, slope_q))
    places = np.arange(window - 1, n - window - gap)
    before, after = places - window + 1, places + gap + 1
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.nan_to_num(mean_h / mean_q, posinf=0.0, neginf=0.0)
    # the median over rows before, among which a jump spoils few
    back = np.linspace(0.0, 3.0 * max(window, _WINDOWS[-2]), _SLOPES).astype(int)
    slope = np.maximum(np.median(ratios[np.maximum(before[:, None] - back, 0)], axis=1), 0.0)
    jumps = right_h[after] - left_h[before] - slope * (right_q[after] - left_q[before])
    sigma = math.sqrt(_variance_of_jump(window, gap)) * np.hypot(noise_h, slope * noise_q[places])
    sigma = np.maximum(sigma, 1e-9 * float(np.ptp(h)))
    # correlated noise makes larger jumps than white noise
    spread = float(np.median(np.abs(jumps / sigma - np.median(jumps / sigma)))) / 0.6745
    sigma = sigma * max(1.0, spread)
    jump, deviation, nearby, slopes = (np.full(n, math.nan) for _ in range(4))
    jump[places], deviation[places], slopes[places] = jumps, sigma, slope
    nearby[places] = _nearby(np.abs(jumps), window + gap)
    return _Jumps(window, gap, jump, deviation, nearby, slopes)


def _nearby(values: FloatArray, inner: int) -> FloatArray:
    """Median of the values between one and three windows away."""
    padded = np.pad(values, 3 * inner, constant_values=math.nan)
    offsets = np.r_[-3 * inner : -inner, inner + 1 : 3 * inner + 1]
    offsets = offsets[:: max(1, offsets.size // 24)]
    at = np.arange(values.size)[:, None] + 3 * inner + offsets
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(np.nan_to_num(np.nanmedian(padded[at], axis=1)))


def _variance_of_jump(window: int, gap: int) -> float:
    """Variance of the jump between lines through windows over that of a row."""
    out, square = 0.5 * (window + gap), window * (window**2 - 1.0) / 12.0
    return 2.0 * (1.0 / window + out**2 / square)


def _event(
    table: _Jumps, row: int, columns: tuple[FloatArray, FloatArray, FloatArray], start: int, noise: float
) -> _Event:
    h, q, f = columns
    window = table.window
    jump, deviation = float(table.jump[row]), float(table.deviation[row])
    low, row, high = _last_rows(table, row, h - table.slope[row] * q)
    part = slice(max(row - window + 1, 0), row + 1)
    x = np.arange(part.start, part.stop) - row
    (fall, force), (_, depth) = np.polyfit(x, f[part], 1), np.polyfit(x, h[part], 1)
    error = _NORMAL * noise * math.sqrt((4.0 * x.size - 2.0) / (x.size * (x.size + 1.0)))
    below, above = sorted((float(fall) * (low - row - 0.5), float(fall) * (high - row + 0.5)))
    return _Event(
        start + row,
        float(force),
        float(force) + below - error,
        float(force) + above + error,
        float(depth),
        jump,
        _NORMAL * deviation,
    )


def _last_rows(table: _Jumps, row: int, y: FloatArray) -> tuple[int, int, int]:
    """
    The last row before a jump of y, between the ends of its 95 % interval, near one found by a window and a gap.

    The gap may begin before the jump. Rows before the jump are on the line of one window and rows after it on the other's; of the rows between them, which
    may be on neither, each must be off both lines by more than noise.
    """
    window, gap = table.window, table.gap
    sigma = float(table.deviation[row]) / math.sqrt(_variance_of_jump(window, gap))
    rows = np.arange(max(row - window // 4, 0), min(row + gap + 1 + window // 4, y.size))
    off = []
    for first in (row - window + 1, row + gap + 1):
        x = np.arange(first, first + window)
        off.append(((y[rows] - np.polyval(np.polyfit(x - row, y[x], 1), rows - row)) / sigma) ** 2)
    # of every last row before the jump, and every first row after it, the misfit
    before, after = np.cumsum(off[0]), np.append(np.cumsum(off[1][::-1])[::-1], 0.0)[1:]
    between = np.arange(rows.size)[None, :] - np.arange(rows.size)[:, None]
    misfit = np.where(between >= 0, before[:, None] + after[None, :] + _BETWEEN**2 * between, math.inf).min(
        axis=1
    )
    likely = rows[misfit <= misfit.min() + _NORMAL**2]
    return int(likely[0]), int(rows[np.argmin(misfit)]), int(likely[-1])


def _study(
    listed: Sequence[Record], searches: Sequence[_Search], contact: Contact | None, strength: float | None
) -> PopIn:
    empty = _Event(0, *[math.nan] * 6)
    events = [one.event or empty for one in searches]
    force = np.array([e.force for e in events])
    jump, wide = np.array([e.jump for e in events]), np.array([e.jump_half for e in events])
    columns = {
        "pop_in_force": (force, "N"),
        "pop_in_force_low": (np.array([e.force_low for e in events]), "N"),
        "pop_in_force_high": (np.array([e.force_high for e in events]), "N"),
        "pop_in_depth": (np.array([e.depth for e in events]), "m"),
        "pop_in_jump": (jump, "m"),
        "pop_in_jump_low": (jump - wide, "m"),
        "pop_in_jump_high": (jump + wide, "m"),
        "smallest_jump": (np.array([one.smallest for one in searches]), "m"),
    }
    there = np.isfinite(force)
    reason = (
        "a jump between straight lines through the rows before and after it, beyond the noise of the record"
    )
    level = Level.APPROXIMATE
    if not there.any():
        level, reason = (
            Level.NOT_VALID,
            f"the loading has no jump above {metres(float(np.nanmax(columns['smallest_jump'][0])))}",
        )
    claim = Claim(level, reason, SOURCES["johnson"], there)
    claims = {name: claim for name in columns if name != "smallest_jump"}
    assumptions: tuple[Assumption, ...] = ()
    single = {}
    if contact is not None:
        columns["largest_shear"], claims["largest_shear"], assumptions = _shear(contact, columns, there)
        if strength is not None:
            # Tresca's stress is twice the largest shear stress
            yields = first_yield(contact, strength=2.0 * strength)
            single["strength_force"] = float(yields["normal_force"].sel(criterion="Tresca"))
            claims["strength_force"] = yields.claims["normal_force"]
    missing = [str(i) for i, one in enumerate(searches, 1) if one.event is None and one.smallest > 0.0]
    return PopIn(
        data=dataset(
            {
                **{name: ("indent", values, {"units": unit}) for name, (values, unit) in columns.items()},
                **{name: ((), value, {"units": "N"}) for name, value in single.items()},
            },
            coords=numbered(listed),
            attrs={} if strength is None else {"shear_strength": strength},
        ),
        claims=claims,
        assumptions=assumptions,
        notes=(f"no pop-in: indent {', '.join(missing[:20])}",) if missing and there.any() else (),
        contact=contact,
        references=("johnson",),
        records=tuple((record.depth, record.force) for record in listed),
    )


def _shear(
    contact: Contact, columns: Mapping[str, tuple[FloatArray, str]], there: np.ndarray
) -> tuple[tuple[FloatArray, str], Claim, tuple[Assumption, ...]]:
    """Largest shear stresses in the body at the loads of pop-ins, their claim, and whether the loading was that of the contact."""
    shear = np.full(there.size, math.nan)
    force, depth = columns["pop_in_force"][0], columns["pop_in_depth"][0]
    if not there.any():
        return (shear, "Pa"), Claim(Level.NOT_VALID, "no pop-in was found", SOURCES["stress"], there), ()
    result = solve(contact, Path(normal_force=np.sort(force[there])))
    claim = result.claims["stress"]
    if not claim.readable:
        raise NotValidError(f"the largest shear stress is not valid here: {claim.reason}")
    order = np.flatnonzero(there)[np.argsort(force[there], kind="stable")]
    shear[order] = result["largest_shear"].values
    ratio = np.abs(result["indentation"].values / depth[order] - 1.0)
    return (
        (shear, "Pa"),
        Claim(claim.level, claim.reason, claim.source, there),
        (
            Assumption(
                "elastic loading",
                "relative difference of the indentations of the contact and of the record at the pop-in; above the limit radius, modulus, zero of the depth or "
                "elasticity are not those of the contact",
                float(np.max(ratio)),
                _ELASTIC,
            ),
            *result.assumptions,
        ),
    )
