"""Bodies without axial symmetry: gaps f(x, y) about their apex."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NoReturn, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.profiles.closed import Flanked, half_angle_field, slope_field
from pymdr.problem.profiles.function import error_text, real_values
from pymdr.problem.topography import HeightsField, Topography, as_topography
from pymdr.problem.values import OptionalSIField, SidesField, SIField, with_named_callables, without_named
from pymdr.units import FloatArray, QuantityLike, metres, shown

PlaneFunction: TypeAlias = Callable[[FloatArray, FloatArray], ArrayLike]

MOST_SIDES = 1000


class Shape(Profile):
    """
    A gap f(x, y) without axial symmetry, pressed without tilting, with its apex at x = y = 0.

    It describes a complete contact: its normal force without adhesion and friction, but no quantity that needs a disk.
    """

    whole: ClassVar[bool] = True
    no_radius: ClassVar[str] = "the contact is not a disk"

    @abstractmethod
    def gap_at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Gap f(x, y) in m above f(0, 0) = 0; nan where the body does not exist."""

    def gap(self, r: ArrayLike) -> NoReturn:
        """Refused: the gap is not a function of the radius."""
        raise ProblemError(
            f"{type(self).__name__} is not axisymmetric: it has gap_at(x, y) but no f(r); azimuthal_mean(shape) gives the "
            "profile of its lower bound"
        )

    def gap_slope(self, r: ArrayLike) -> NoReturn:
        """Refused: the gap is not a function of the radius."""
        self.gap(r)


@dataclass(frozen=True, eq=False)
class EllipticParaboloid(Shape):
    """
    A paraboloid of two curvatures, f = x^2 / (2 R_x) + y^2 / (2 R_y): the contact of Hertz.

    Parameters
    ----------
    radius_x : quantity
        Radius of curvature R_x of the section y = 0 in m, above 0. Two bodies combine as 1/R_x = 1/R_x1 + 1/R_x2.
    radius_y : quantity
        Radius of curvature R_y of the section x = 0 in m, above 0.

    Raises
    ------
    ProblemError
        If a value is outside its limits, or one radius is more than 1e6 times the other.

    See Also
    --------
    Paraboloid : with one radius.

    Notes
    -----
    The contact of Hertz (1882).

    References
    ----------
    Hertz (1882), J. reine angew. Math. 92, 156-171.

    Examples
    --------
    >>> import pymdr as mdr
    >>> float(mdr.EllipticParaboloid("20 mm", "10 mm").gap_at(0.0, 1e-3))
    5e-05
    """

    radius_x: SIField = SIField("m", above=0.0, description="radius of curvature of the section y = 0")
    radius_y: SIField = SIField("m", above=0.0, description="radius of curvature of the section x = 0")

    def __post_init__(self) -> None:
        low, high = sorted((self.radius_x, self.radius_y))
        if high > 1e6 * low * (1.0 + 1e-9):
            raise ProblemError(
                f"the radii {metres(self.radius_x)} and {metres(self.radius_y)} differ by a factor of "
                f"{high / low:.3g} (limit 1e6); such a line contact depends on the length of the body"
            )

    def gap_at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Gap f(x, y) in m."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return np.asarray(x * (x / (2.0 * self.radius_x)) + y * (y / (2.0 * self.radius_y)))


@dataclass(frozen=True, eq=False)
class Pyramid(Shape, Flanked):
    """
    A regular pyramid, f = s max_k r cos(phi - 2 pi k / m): m faces of slope s, with a face along +x.

    Parameters
    ----------
    sides : int
        Number m of its faces, at least 3.
    slope : float, optional
        Slope s of the faces, above 0.
    half_angle : quantity, optional
        Angle between axis and face in rad, above 0 and below pi/2; s = cot(half_angle).

    Raises
    ------
    ProblemError
        If there are too few sides, or not exactly one of slope and half angle is given.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(mdr.Pyramid.vickers().gradient, 4)
    0.404
    >>> round(float(mdr.Pyramid(4, slope=0.5).gap_at(1.0, 1.0)), 12)
    0.5
    """

    sides: int
    slope: OptionalSIField = slope_field()
    half_angle: OptionalSIField = half_angle_field()

    def __post_init__(self) -> None:
        sides = self.sides
        whole = isinstance(sides, int | np.integer) and not isinstance(sides, bool)
        if not whole or not 3 <= sides <= MOST_SIDES:
            raise ProblemError(
                f"sides = {shown(sides)}: a whole number from 3 to {MOST_SIDES} is needed; for more sides use a Cone"
            )
        object.__setattr__(self, "sides", int(sides))
        super().__post_init__()

    @classmethod
    def berkovich(cls) -> Pyramid:
        """The modified Berkovich indenter: 3 sides at 65.27 degrees from the axis."""
        return cls(3, half_angle=math.radians(65.27))

    @classmethod
    def vickers(cls) -> Pyramid:
        """The Vickers indenter: 4 sides, 136 degrees between opposite ones."""
        return cls(4, half_angle=math.radians(68.0))

    @classmethod
    def cube_corner(cls) -> Pyramid:
        """The corner of a cube: 3 sides at 35.26 degrees from the axis, of slope sqrt(2)."""
        return cls(3, slope=math.sqrt(2.0))

    @classmethod
    def four_sided_tip(cls, half_angle: QuantityLike = "35 deg") -> Pyramid:
        """
        The pyramid of a cantilever: 4 sides.

        Parameters
        ----------
        half_angle : quantity
            Angle between axis and face in rad; etched silicon nitride tips have 35 degrees, (111) planes of silicon 35.26 degrees.

        Returns
        -------
        Pyramid
        """
        return cls(4, half_angle=half_angle)

    def gap_at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Gap f(x, y) in m, that of the nearest face."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        sector = 2.0 * math.pi / self.sides
        face = sector * np.round(np.arctan2(y, x) / sector)
        return np.asarray(self.gradient * (x * np.cos(face) + y * np.sin(face)))


@dataclass(frozen=True, eq=False)
class Function2D(Shape):
    """
    Any gap given as a callable f(x, y).

    Parameters
    ----------
    f : callable
        Gap in m as a function of two arrays of positions in m; its lowest value f(0, 0) is removed.
    max_radius : quantity, optional
        Largest distance from the apex in m at which it may be evaluated.

    Raises
    ------
    ProblemError
        If `f` is not a callable of two arrays.

    Examples
    --------
    >>> import pymdr as mdr
    >>> saddle = mdr.Function2D(lambda x, y: x**2 + 2 * y**2 + x**3)
    >>> float(saddle.gap_at(0.5, 0.0))
    0.375
    """

    f: PlaneFunction
    max_radius: SIField = SIField("m", above=0.0, default=math.inf)

    def __post_init__(self) -> None:
        if not callable(self.f):
            raise ProblemError(f"f = {shown(self.f)}: a callable of x and y is needed")

    def __getstate__(self) -> dict[str, Any]:
        return with_named_callables(self, "f")

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(without_named(state))

    @cached_property
    def offset(self) -> float:
        """F(0, 0) in m, which is removed."""
        offset = float(self._values(np.zeros(2), np.zeros(2))[0])
        if not math.isfinite(offset):
            raise ProblemError(f"f(x, y) returns {offset} at its apex x = y = 0, where it must be finite")
        return offset

    def gap_at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Gap f(x, y) - f(0, 0) in m; nan beyond `max_radius`."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        if math.isinf(self.max_radius):
            return np.asarray(self._values(x, y) - self.offset)
        # a computed end may exceed max_radius by rounding
        inside = np.hypot(x, y) <= self.max_radius * (1.0 + 1e-12)
        values = self._values(np.where(inside, x, 0.0), np.where(inside, y, 0.0))
        return np.where(inside, values - self.offset, math.nan)

    def _values(self, x: FloatArray, y: FloatArray) -> FloatArray:
        flat = np.array(np.ravel(x), dtype=float), np.array(np.ravel(y), dtype=float)
        if flat[0].size < 2:
            flat = np.repeat(flat[0], 2), np.repeat(flat[1], 2)
        values = self._evaluated(*flat)
        few = np.array([2 * values.size // 3, values.size // 3])
        again = self._evaluated(flat[0][few], flat[1][few])
        with np.errstate(invalid="ignore"):
            other = np.abs(again - values[few]) > 1e-6 * np.nanmax(np.abs(values), initial=0.0)
        if other.any():
            i = few[np.argmax(other)]
            raise ProblemError(
                f"f(x, y) returns {values[i]:g} and then {again[np.argmax(other)]:g} at x = {metres(flat[0][i])}, y = "
                f"{metres(flat[1][i])}: the value at a point must not depend on other points or chance"
            )
        return values[: np.size(x)].reshape(np.shape(x))

    def _evaluated(self, x: FloatArray, y: FloatArray) -> FloatArray:
        name = getattr(self.f, "__name__", "")
        where = "f(x, y)" + (f" ({name})" if name and name != "<lambda>" else "")
        try:
            with np.errstate(all="ignore"):
                raw = self.f(x.copy(), y.copy())
        except Exception as error:
            raise ProblemError(
                f"{where} fails for {x.size} points out to {metres(float(np.hypot(x, y).max()))} ({error_text(error)}): it must accept "
                "two arrays and return nan where it is not defined; else give Function2D(f, max_radius=...)"
            ) from error
        return real_values(raw, x, where, "m", "points")


@dataclass(frozen=True, eq=False)
class Sampled2D(Shape):
    """
    A body given by heights on a grid with linear interpolation, such as a measured tip.

    Its apex is the highest pixel; the body is known up to the nearest edge of the grid.

    Parameters
    ----------
    heights : array_like of quantity
        Heights in m, (nx, ny), positive out of the body.
    size : quantity or pair of quantities
        Sides of the grid along x and y in m; one length for a square.

    Raises
    ------
    ProblemError
        If the heights are not a matrix, some are missing, all are equal, or the highest is at the edge of the grid.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x = np.linspace(-1e-6, 1e-6, 21)
    >>> tip = mdr.Sampled2D(-(x[:, None] ** 2 + x**2) / 2e-6, 2.1e-6)
    >>> round(float(tip.gap_at(5e-7, 0.0)), 12)
    1.25e-07
    """

    heights: HeightsField = HeightsField("m", description="heights, positive out of the body")
    size: SidesField = SidesField("m", description="sides along x and y, or side of a square")

    def __post_init__(self) -> None:
        missing = int(np.isnan(self.heights).sum())
        if missing:
            raise ProblemError(
                f"heights: {missing} of {self.heights.size} are missing; fill them, or crop to a complete patch"
            )
        if not np.ptp(self.heights) > 0.0:
            raise ProblemError("heights: all are equal; a plane has no apex")
        i, j = self.apex
        if min(i, j, self.heights.shape[0] - 1 - i, self.heights.shape[1] - 1 - j) < 1:
            raise ProblemError(
                f"heights: the highest pixel ({i}, {j}) is at the edge of the grid of {self.heights.shape[0]} x "
                f"{self.heights.shape[1]}; use a patch with the apex inside"
            )

    @classmethod
    def of(cls, topography: Topography) -> Sampled2D:
        """
        The body of a topography.

        Parameters
        ----------
        topography : Topography

        Returns
        -------
        Sampled2D
        """
        as_topography(topography)
        return cls(topography.heights, topography.size)

    @cached_property
    def apex(self) -> tuple[int, int]:
        """The highest pixel."""
        i, j = np.unravel_index(int(np.nanargmax(self.heights)), self.heights.shape)
        return int(i), int(j)

    @property
    def spacing(self) -> FloatArray:
        """Width of a pixel in m along x and y."""
        return np.asarray(self.size / self.heights.shape)

    @property
    def max_radius(self) -> float:
        """Distance in m from the apex to the nearest outermost pixel."""
        last = np.array(self.heights.shape) - 1
        at = np.array(self.apex)
        return float(np.min(np.minimum(at, last - at) * self.spacing))

    def gap_at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Gap f(x, y) in m, linear between pixels in each direction; nan beyond the grid."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        shape = self.heights.shape
        # a computed end may exceed the grid by rounding
        u, v = (
            np.where(np.abs(place - np.round(place)) < 1e-9, np.round(place), place)
            for place in (x / self.spacing[0] + self.apex[0], y / self.spacing[1] + self.apex[1])
        )
        inside = (u >= 0.0) & (u <= shape[0] - 1) & (v >= 0.0) & (v <= shape[1] - 1)
        u, v = np.where(inside, u, 0.0), np.where(inside, v, 0.0)
        i, j = (np.minimum(p.astype(int), n - 2) for p, n in ((u, shape[0]), (v, shape[1])))
        s, t, z = u - i, v - j, self.heights
        low = z[i, j] + t * (z[i, j + 1] - z[i, j])
        high = z[i + 1, j] + t * (z[i + 1, j + 1] - z[i + 1, j])
        return np.where(inside, z[self.apex] - (low + s * (high - low)), math.nan)
