"""Area functions of indenters as profiles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.numerics.roots import rising_root
from pymdr.problem.profiles.base import Profile
from pymdr.problem.profiles.sampled import Sampled, ShapePreserving
from pymdr.problem.values import OptionalArrayField, OptionalSIField, SIField
from pymdr.units import ArrayQuantityLike, FloatArray, metres, to_si_array

MOST_COEFFICIENTS = 9
_GRID = np.linspace(-600.0, 250.0, 8192)
"""Logarithms of depths over the unit of the coefficients, nearly as far as floats reach."""
_STEPS, _SETTLED = 60, 1e-13
_FLATTEST, _FLAT = 0.1, math.log(1e-30)
"""Exponent of A(h) at the apex below which f = r^(2/p) underflows, and the height below which it is a flat instead, in logarithms and
parts of the depth at which the exponent has doubled."""
_TINY = 1e-60
"""Radius in m that replaces 0."""


@dataclass(frozen=True, eq=False)
class AreaFunction(Profile):
    """
    The area function of an indenter, A(h) = C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) + ..., or a table of it.

    The contact radius of a tip of revolution at the contact depth h is sqrt(A(h)/pi), and h is its gap there. The
    inverse of that radius is the profile f(r), so that an area function is used as any other profile.

    Parameters
    ----------
    coefficients : array_like, optional
        C0, C1, ... in powers of `unit`; up to nine, at least one of them not 0.
    unit : quantity, optional
        The length in which the coefficients are given, such as ``"1 nm"``; 1 m by default.
    depth, area : array_like or quantity, optional
        Instead of coefficients, contact depths in m and areas in m^2, both rising; at least 4 of them.
    max_depth : quantity, optional
        Largest depth in m to which the coefficients are known. Needed if the area ceases to rise, as that of a sphere does.

    Raises
    ------
    ProblemError
        If not exactly one of coefficients and table is given, there are too many coefficients or all are 0, or the table does not
        rise. As a profile, if the area does not rise at every depth up to `max_depth`.

    See Also
    --------
    calibrate_area : its coefficients from indents in fused silica.
    read_area_function : the same from a file.

    Notes
    -----
    The area function of Oliver and Pharr (1992). C0 alone is a cone, C1 alone a paraboloid of radius C1/(2 pi), and both
    together are a hyperboloid. Terms beyond C1 flatten the tip.

    References
    ----------
    Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> tip = mdr.AreaFunction([24.5, 1000.0], unit="1 nm")
    >>> round(float(tip.area_at("100 nm")) * 1e18)
    345000
    >>> depth = float(tip.gap(tip.radius_at("100 nm")))
    >>> bool(abs(depth / 100e-9 - 1) < 1e-12)
    True
    """

    coefficients: OptionalArrayField = OptionalArrayField("", description="C0, C1, ... in powers of the unit")
    unit: SIField = SIField("m", description="length in which coefficients are given", above=0.0, default=1.0)
    depth: OptionalArrayField = OptionalArrayField("m", description="contact depths of a table")
    area: OptionalArrayField = OptionalArrayField("m^2", description="areas at these depths")
    max_depth: OptionalSIField = OptionalSIField("m", description="largest calibrated depth", above=0.0)

    def __post_init__(self) -> None:
        table = (self.depth is not None, self.area is not None)
        if (self.coefficients is not None) == any(table) or any(table) != all(table):
            raise ProblemError("give either coefficients, or both depth and area")
        if self.coefficients is None:
            if self.max_depth is not None:
                raise ProblemError("a table ends at its last depth; max_depth is for coefficients")
            self._check_table()
            return
        count = self.coefficients.size
        if not 1 <= count <= MOST_COEFFICIENTS or not np.any(self.coefficients):
            raise ProblemError(
                f"coefficients: {count} given; 1 to {MOST_COEFFICIENTS} are needed, one of them not 0"
            )

    def _check_table(self) -> None:
        depth, area = self.depth, self.area
        assert depth is not None
        assert area is not None
        if depth.shape != area.shape or depth.size < 4:
            raise ProblemError(
                f"{depth.size} depths and {area.size} areas; give at least 4, and one area for each depth"
            )
        if depth[0] < 0.0 or area[0] < 0.0 or np.any(np.diff(depth) <= 0.0) or np.any(np.diff(area) <= 0.0):
            raise ProblemError(
                "depths and areas of a table must rise strictly, from 0 or above; sort the rows and average repeated depths"
            )

    @property
    def exponents(self) -> FloatArray:
        """The exponents of the depth: 2, 1, 1/2, 1/4, ..."""
        assert self.coefficients is not None
        return np.asarray(2.0 ** (1.0 - np.arange(self.coefficients.size)))

    @cached_property
    def sampled(self) -> Sampled | None:
        """The profile of a table, a piecewise cubic that rises as the table does; None for coefficients."""
        if self.depth is None or self.area is None:
            return None
        radius, height = np.sqrt(self.area / math.pi), self.depth
        if radius[0] > 0.0:
            radius, height = np.append(0.0, radius), np.append(0.0, height)
        return Sampled(radius, height - height[0], interpolation=ShapePreserving())

    def area_at(self, depth: ArrayQuantityLike) -> FloatArray:
        """
        The area at contact depths.

        Parameters
        ----------
        depth : array_like or quantity
            Contact depths in m, at least 0.

        Returns
        -------
        ndarray
            In m^2; nan beyond the last depth of a table or the largest one of coefficients.
        """
        h = to_si_array(depth, "m", name="depth")
        if self.sampled is None:
            known = (h >= 0.0) & (h <= (self.max_depth or math.inf))
            powers = (np.maximum(h, 0.0) / self.unit)[..., None] ** self.exponents
            area = self.unit**2 * (powers @ np.asarray(self.coefficients))
            return np.where(known, area, math.nan)
        known = (h >= 0.0) & (h <= self.sampled.gap(self.max_radius))
        inside = np.where(known, h, 0.0)
        radius = rising_root(self.sampled.gap, inside, np.zeros_like(h), np.full_like(h, self.max_radius))
        return np.where(known, math.pi * radius**2, math.nan)

    def radius_at(self, depth: ArrayQuantityLike) -> FloatArray:
        """
        The contact radius sqrt(A/pi) at contact depths.

        Parameters
        ----------
        depth : array_like or quantity
            As for :meth:`area_at`.

        Returns
        -------
        ndarray
            In m.
        """
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(self.area_at(depth) / math.pi))

    def _logarithms(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Logarithm of A and d ln A / d ln h over s = ln h, in the unit of the coefficients; nan where the area is not above 0."""
        coefficients = np.asarray(self.coefficients)
        # beside a power that is not there the others vanish at depths far below or above the unit
        present = coefficients != 0.0
        exponents = self.exponents[present]
        powers = s[..., None] * exponents
        largest = powers.max(axis=-1)
        terms = coefficients[present] * np.exp(powers - largest[..., None])
        area = terms.sum(axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return largest + np.log(area), (terms @ exponents) / area

    @cached_property
    def _rising(self) -> tuple[FloatArray, FloatArray]:
        """Logarithms of depths and areas from which inversions start; refused unless the area rises on all of them."""
        end = math.inf if self.max_depth is None else math.log(self.max_depth / self.unit)
        logs = _GRID[end > _GRID]
        area, slope = self._logarithms(logs)
        bad = ~(slope > 0.0) | ~np.isfinite(area)
        if bad.any():
            first, last = (metres(math.exp(logs[i]) * self.unit) for i in np.flatnonzero(bad)[[0, -1]])
            raise ProblemError(
                f"the area does not rise at depths between {first} and {last}, so no tip has this shape; give "
                "max_depth below them, or coefficients whose last one is above 0"
            )
        if math.isfinite(end):
            logs, area = np.append(logs, end), np.append(area, self._logarithms(np.array(end))[0])
        return logs, area

    @cached_property
    def _flat(self) -> float:
        """Radius in m of the flat at the apex; 0 without one."""
        assert self.coefficients is not None
        exponent = self.exponents[np.flatnonzero(self.coefficients)[-1]]
        if exponent > _FLATTEST:
            return 0.0
        logs = self._rising[0]
        further = np.flatnonzero(self._logarithms(logs)[1] > 2.0 * exponent)
        depth = (logs[further[0]] if further.size else 0.0) + _FLAT
        return self.unit * math.exp(0.5 * (float(self._logarithms(np.array(depth))[0]) - math.log(math.pi)))

    def _solved(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The depth in m at radii above 0, by Newton's method in logarithms, and d ln A / d ln h there."""
        logs, areas = self._rising
        target = math.log(math.pi) + 2.0 * np.log(r / self.unit)
        s = np.interp(target, areas, logs)
        for _ in range(_STEPS):
            area, slope = self._logarithms(s)
            # at the last depth of a sphere the area has its maximum
            step = np.where(slope > 0.0, (area - target) / np.where(slope > 0.0, slope, 1.0), 0.0)
            s = np.clip(s - np.clip(step, -1.0, 1.0), logs[0], logs[-1])
            if np.max(np.abs(step), initial=0.0) < _SETTLED:
                break
        return self.unit * np.exp(s), self._logarithms(s)[1]

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m, the inverse of the contact radius; nan beyond `max_radius`."""
        if self.sampled is not None:
            return self.sampled.gap(r)
        r = np.asarray(r, dtype=float)
        f = np.where(r > self._flat, self._solved(np.maximum(r, _TINY))[0], 0.0)
        return np.where(r <= self.max_radius, f, math.nan)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f' = 2 pi r / (dA/dh); nan beyond `max_radius`."""
        if self.sampled is not None:
            return self.sampled.gap_slope(r)
        radius = np.maximum(np.asarray(r, dtype=float), _TINY)
        h, slope = self._solved(radius)
        with np.errstate(divide="ignore"):
            values = np.where(radius > self._flat, 2.0 * h / (slope * radius), 0.0)
        return np.where(radius <= self.max_radius, values, math.nan)

    @cached_property
    def _end(self) -> float:
        if self.sampled is not None:
            return self.sampled.max_radius
        return math.inf if self.max_depth is None else float(self.radius_at(self.max_depth))

    @property
    def max_radius(self) -> float:
        """The contact radius at the largest known depth."""
        return self._end

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Those of the piecewise cubic of a table, and the edge of the flat of the flattest tips."""
        if self.sampled is not None:
            return self.sampled.breakpoints
        return (self._flat,) if self._flat else ()

    @property
    def tip_radius(self) -> float | None:
        """C1/(2 pi), if no other term is larger at the apex; None for others."""
        if self.coefficients is None or self.coefficients.size < 2 or np.any(self.coefficients[2:]):
            return None
        return self.unit * float(self.coefficients[1]) / (2.0 * math.pi) or None

    @property
    def curvature_radius(self) -> float | None:
        """Radius of curvature of a round apex."""
        return self.tip_radius
