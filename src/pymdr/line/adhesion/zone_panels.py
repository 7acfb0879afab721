"""The integrals over a cohesive zone on the panels of a numerical profile, without an adaptive quadrature.

Seen from the outer end c of a zone a panel is one of three: far inside x <= c/8, where the kernels are short series
in x/c and the moments of g' are summed once for all zones; full and away from c, where g' is known at the nodes
of the panel; or cut by a, or next to c, where x = c - v^2 takes out the root of the kernels (on panels behind a
breakpoint b together with that of x - b). Distances are differences of offsets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pymdr.mapping.equivalent.panels import PanelLine
from pymdr.mapping.images import Image
from pymdr.numerics.panels import (
    TERMS,
    Panels,
    Place,
    Position,
    Series,
    as_place,
    evaluate,
    joined,
    joined_series,
)
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray


def zone_root(radius: FloatArray, width: FloatArray) -> FloatArray:
    """Return sqrt(c² - a²) [m] of a zone from a with c = a + δ, without subtraction."""
    return np.sqrt(width * (2.0 * radius + width))


def segment(angle: FloatArray) -> FloatArray:
    """Return ψ - sin ψ cos ψ, by its series where the difference would cancel.

    Examples
    --------
    >>> bool(abs(segment(np.array(1e-4)) / (2e-12 / 3) - 1) < 1e-8)
    True
    """
    z = (2.0 * angle) ** 2
    series = np.ones_like(z)
    for k in (14, 12, 10, 8, 6, 4):
        series = 1.0 - z * series / (k * (k + 1))
    return np.where(angle < 0.4, angle * z * series / 6.0, angle - np.sin(angle) * np.cos(angle))


_Index = NDArray[np.intp]

_NEAR, _FULL = 20, 16
"""Nodes on panels that are cut or next to c, and on others."""
_FAR = 8.0
_ODD = 2.0 * np.arange(11.0) + 1.0
_POWERS = np.concatenate([[0.0], _ODD])
_HALF = np.cumprod(np.concatenate([[1.0], (2.0 * np.arange(1.0, 11.0) - 1.0) / (2.0 * np.arange(1.0, 11.0))]))
# of t/sqrt(1 - t²), arcsin t and arcsin t + t sqrt(1 - t²) in odd powers of t
_ROOT, _ARC = _HALF, _HALF / _ODD
_SEGMENT = -2.0 * _HALF / (_ODD * (_ODD - 2.0))
_KEPT = 0.1
"""Moments are subtracted where at least so much is left."""
_ROWS = 4096


@dataclass(frozen=True)
class _Table:
    """Data of an image for zones of every width."""

    image: Image
    lowest: float
    """Zones with their outer end above this radius in m are covered."""
    panels: Panels
    slope: Series
    start: FloatArray
    stop: FloatArray
    nodes: FloatArray
    """Offsets of the nodes of the panels in m, shape (P, nodes)."""
    weights: FloatArray
    """Weights at the nodes, with g', in m."""
    moments: FloatArray
    """Moments int_0^X g' (x/X)^k dx in m of k = 0, 1, 3, 5 ..., up to the start of every panel and the last stop."""
    tip: float
    """Exponent n of g below the first panel; 0 where g is 0."""


class _Parts(NamedTuple):
    """Parts of panels in zones, flat: which zone and panel, offsets and distances from c of both ends in m."""

    row: _Index
    panel: _Index
    low: FloatArray
    high: FloatArray
    low_gap: FloatArray
    high_gap: FloatArray
    at: FloatArray
    """Offset of c."""

    def take(self, index: NDArray[np.bool_]) -> _Parts:
        row, panel, *rest = self
        return _Parts(row[index], panel[index], *(column[index] for column in rest))


_tables: WeakKeyDictionary[PanelLine, _Table] = WeakKeyDictionary()


def panel_integrals(line: PanelLine, radius: Position, width: FloatArray, *, third: bool) -> FloatArray:
    """
    J0, J1 and J2 of zones, see `pymdr.line.adhesion.cohesive_zone`.

    Parameters
    ----------
    radius : ndarray or Place
        a >= 0 in m, flat.
    width : ndarray
        c - a > 0 in m, of the same length; the profile is known at c.
    third : bool
        Whether J2 is computed; it is 0 otherwise.

    Returns
    -------
    ndarray, shape (3, zones)
        J0 (dimensionless), J1 in m and J2 in m^3, as accurate as the image.
    """
    place, totals = as_place(radius), np.zeros((3, width.size))
    for begin in range(0, width.size, _ROWS):
        part = slice(begin, begin + _ROWS)
        totals[:, part] = _block(line, place.take(part), width[part], third)
    return totals


def _block(line: PanelLine, place: Place, width: FloatArray, third: bool) -> FloatArray:
    a = place.x
    c = a + width
    table = _table_of(line, float(c.max()), float(c.min()), float(np.min(a[a > 0.0], initial=math.inf)))
    panels, tip = table.panels, float(table.start[0])
    first, _ = panels.locate(place)
    # c = base + (offset + width)
    last, _ = panels.locate(Place(place.base, place.offset + width))
    in_tip = a < tip
    first[in_tip], last[c <= tip] = -1, -1
    totals = np.zeros((3, a.size))

    # what lies far inside, up to the start of a panel
    inner = np.searchsorted(table.start, c / _FAR, side="right") - 1
    whole, cut = table.moments[np.maximum(inner, 0), 0], table.moments[first + 1, 0]
    far = (inner >= 0) & (in_tip | ((inner > first + 1) & (np.abs(whole - cut) >= _KEPT * np.abs(whole))))
    i = np.flatnonzero(far)
    totals[:, i] += _series(table.moments[inner[i]], table.start[inner[i]], c[i])
    i = np.flatnonzero(far & ~in_tip)
    totals[:, i] -= _series(table.moments[first[i] + 1], table.stop[first[i]], c[i])
    i = np.flatnonzero(far & in_tip & (a > 0.0))
    below = table.moments[0] * ((a[i] / tip) ** table.tip)[:, None]
    totals[:, i] -= _series(below, a[i], c[i])

    # from there panel by panel, and the panel that a cuts
    begin = np.where(far, inner, first + 1)
    count = np.maximum(last - begin + 1, 0)
    row = np.repeat(np.arange(a.size), count)
    panel = np.arange(row.size) - np.repeat(np.cumsum(count) - count, count) + begin[row]
    cuts = np.flatnonzero(first >= 0)
    row, panel = np.concatenate([row, cuts]), np.concatenate([panel, first[cuts]])
    inner_offset = (place.base[row] - panels.base[panel]) + place.offset[row]
    offset = inner_offset + width[row]
    away = _away(panels, panel, offset) & (panel != first[row])
    r, p = row[away], panel[away]
    nodes = table.nodes[p]
    full = _kernels(offset[away, None] - nodes, panels.base[p, None] + nodes, c[r, None], third)
    _gather(totals, r, full * table.weights[p])

    row, panel, at, entry = (x[~away] for x in (row, panel, offset, inner_offset))
    begins = panel == first[row]
    low = np.where(begins, np.clip(entry, panels.low[panel], panels.high[panel]), panels.low[panel])
    high = np.minimum(panels.high[panel], at)
    low_gap = np.where(begins, width[row], at - low)
    real = high > low
    parts_ = _Parts(row, panel, low, high, low_gap, np.maximum(at - high, 0.0), at).take(real)
    for part, nodes in _near(table, parts_):
        offset, gap, weight = nodes
        x = panels.base[part.panel][:, None] + offset
        weight = weight * evaluate(panels, table.slope, part.panel, offset)
        _gather(totals, part.row, _kernels(gap, x, c[part.row, None], third) * weight)
    return np.asarray(totals / c ** np.array([[1.0], [0.0], [-2.0]]))


def _kernels(gap: FloatArray, x: FloatArray, c: FloatArray, third: bool) -> FloatArray:
    """The kernels x / sqrt(c² - x²), arccos(x / c) and ½ (ψ - sin ψ cos ψ) at distances c - x, shape (3, ...)."""
    angle = 2.0 * np.arcsin(np.sqrt(np.minimum(0.5 * gap / c, 1.0)))
    outer = 0.5 * segment(angle) if third else np.zeros(angle.shape)
    return np.stack([x / np.sqrt(gap * (c + x)), angle, outer])


def _gather(totals: FloatArray, row: _Index, values: FloatArray) -> None:
    """Add the sums over nodes to the zones."""
    for total, part in zip(totals, values.sum(axis=2), strict=True):
        total += np.bincount(row, weights=part, minlength=total.size)


def _series(moments: FloatArray, x: FloatArray, c: FloatArray) -> FloatArray:
    """The integrals up to x <= c/8 from the moments, shape (3, zones)."""
    t = x / c
    odd = moments[:, 1:] * t[:, None] ** _ODD
    level = 0.5 * math.pi * moments[:, 0]
    return np.stack([odd @ _ROOT, level - odd @ _ARC, 0.5 * (level - odd @ _SEGMENT)])


def _away(panels: Panels, panel: _Index, at: FloatArray) -> NDArray[np.bool_]:
    """Whether c is so far beyond panels that the kernels are smooth on them."""
    low, high = panels.low[panel], panels.high[panel]
    plain = at - high >= high - low
    if not panels.rooted.any():
        return plain
    root = np.sqrt(np.maximum(at, 0.0))
    return np.where(panels.rooted[panel], root - np.sqrt(high) >= np.sqrt(high) - np.sqrt(low), plain)


def _near(
    table: _Table, parts_: _Parts
) -> Iterator[tuple[_Parts, tuple[FloatArray, FloatArray, FloatArray]]]:
    """Offsets, distances from c and weights of the nodes on segments that are cut or next to c, by kind."""
    panels = table.panels
    rooted = panels.rooted[parts_.panel]
    corner = rooted & (parts_.low == 0.0)
    s, w = gauss(_NEAR)
    if not rooted.all():
        part = parts_.take(~rooted)
        inner, outer = np.sqrt(part.low_gap)[:, None], np.sqrt(part.high_gap)[:, None]
        v = outer + (inner - outer) * s
        yield part, (_inside(part, part.at[:, None] - v * v), v * v, 2.0 * v * (inner - outer) * w)
    if (rooted & ~corner).any():
        # sqrt(offset) = sqrt(at) cos φ
        part = parts_.take(rooted & ~corner)
        outer = np.arctan2(np.sqrt(part.high_gap), np.sqrt(part.high))[:, None]
        inner = np.arctan2(np.sqrt(part.low_gap), np.sqrt(part.low))[:, None]
        angle = outer + (inner - outer) * s
        at, sine = part.at[:, None], np.sin(angle)
        offset = _inside(part, at * np.cos(angle) ** 2)
        yield part, (offset, at * sine**2, 2.0 * at * sine * np.cos(angle) * (inner - outer) * w)
    if corner.any():
        # g' begins like a power of the offset, which the weights of the rule hold
        powers = table.slope.power[parts_.panel]
        for power in np.unique(powers[corner]):
            part = parts_.take(corner & (powers == power))
            n = 2.0 * float(power) + 1.0
            s, w = gauss(_NEAR, n)
            whole = np.arctan2(np.sqrt(part.high), np.sqrt(part.high_gap))[:, None]
            angle, at = whole * s, part.at[:, None]
            sine, cosine = np.sin(angle), np.cos(angle)
            weight = 2.0 * at * sine * cosine * whole * (w / s**n)
            yield part, (at * sine**2, at * cosine**2, weight)


def _inside(part: _Parts, offset: FloatArray) -> FloatArray:
    return np.clip(offset, part.low[:, None], part.high[:, None])


def _table_of(line: PanelLine, top: float, least: float, inner: float) -> _Table:
    """The table of the present image, made anew when the image has grown."""
    image = line.map_to(top, min(least, inner))
    known = _tables.get(line)
    if known is None or known.image is not image or least < known.lowest:
        known = _made(line, image, least)
        _tables[line] = known
    return known


def _made(line: PanelLine, image: Image, least: float) -> _Table:
    panels, slope = image.panels, image.slope
    tip = float(panels.start[0])
    # values of the line at the tip would map it further inward and rebuild this table repeatedly
    power, height, radius = line.tip_power()
    height *= (tip / radius) ** power
    n = power if height > 0.0 else 0.0
    lowest = 0.0
    if n > 0.0 and tip > least / _FAR:
        # g is a power to the tip: add the octaves that the smallest zone needs
        octaves = math.ceil(math.log2(_FAR * tip / least)) + 10
        panels, slope = _with_tail(panels, slope, n * height / tip, n, octaves)
        height *= 2.0 ** (-n * octaves)
        tip *= 2.0**-octaves
        lowest = _FAR * tip
    elif n > 0.0:
        lowest = _FAR * tip
    nodes, weights = _rule_of(panels, slope)
    start, stop = panels.start, panels.stop
    moments = np.empty((panels.count + 1, _POWERS.size))
    moments[0] = height * (n / (n + _POWERS) if n > 0.0 else 0.0)
    fraction = (panels.base[:, None] + nodes) / stop[:, None]
    own = np.einsum("pj,pjk->pk", weights, fraction[:, :, None] ** _POWERS)
    shrink = (start / stop)[:, None] ** _POWERS
    for i in range(panels.count):
        moments[i + 1] = moments[i] * shrink[i] + own[i]
    return _Table(image, lowest, panels, slope, start, stop, nodes, weights, moments, n)


def _with_tail(panels: Panels, slope: Series, steep: float, n: float, octaves: int) -> tuple[Panels, Series]:
    """Panels with octaves of the power g' = steep (x / tip)^(n - 1) below them."""
    high = float(panels.start[0]) * 2.0 ** -np.arange(octaves - 1.0, -1.0, -1.0)
    below = Panels(np.zeros(octaves), 0.5 * high, high, np.zeros(octaves, dtype=bool))
    coefficients = np.zeros((octaves, TERMS))
    coefficients[:, 0] = steep * (high / high[-1]) ** (n - 1.0)
    powers = Series(np.full(octaves, n - 1.0), coefficients)
    return joined([below, panels]), joined_series([powers, slope])


def _rule_of(panels: Panels, slope: Series) -> tuple[FloatArray, FloatArray]:
    """Offsets of nodes on whole panels, and weights times g' there."""
    s, w = gauss(_FULL)
    nodes, weights = np.tile(s, (panels.count, 1)), np.tile(w, (panels.count, 1))
    for i in np.flatnonzero(panels.begins & panels.rooted):
        n = 2.0 * float(slope.power[i]) + 1.0
        nodes[i], weights[i] = gauss(_FULL, n)
        weights[i] /= nodes[i] ** n
    offset = panels.offsets(nodes)
    low, high = np.sqrt(panels.low)[:, None], np.sqrt(panels.high)[:, None]
    jacobian = np.where(
        panels.rooted[:, None], 2.0 * (low + (high - low) * nodes) * (high - low), panels.width[:, None]
    )
    return offset, weights * jacobian * evaluate(panels, slope, np.arange(panels.count), offset)
