"""Modulus of a film on a substrate, from stiffness over depth and the springs of layers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.special import chdtri, stdtrit

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.layered import LayeredLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import Compliance, Kernel, PairCompliance
from pymdr.problem.layers import Layer, Layered
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.profiles import Paraboloid
from pymdr.solving.nanoindentation.continuous import ContinuousStiffness
from pymdr.solving.study import Column, Study, dataset, number
from pymdr.units import FloatArray, QuantityLike, metres, pascals, shown, to_si, written

if TYPE_CHECKING:
    pass

_FACTOR, _TRIED = 30.0, 13
"""Largest ratio of the film's modulus and the apparent one at the shallowest point, and moduli at which layers are solved."""
_FEWEST = 3
_STEP = 1e-3
_WEAK, _SCATTER, _SINK_IN = 0.9, 3.0, 0.5
"""Limits: 1 - fraction of the film in the stiffness, misfit over noise."""
_NORMAL = 1.959964


def reduced_moduli(radius: FloatArray, body: Layered, tip: float) -> FloatArray:
    """
    Reduced moduli S/2a of contacts of given radii between a layered body and a half-space.

    Parameters
    ----------
    radius : ndarray
        Contact radii in m, above 0.
    tip : float
        1/E* of the half-space in 1/Pa.

    Returns
    -------
    ndarray
        In Pa. The profile does not matter: S is the stiffness of a flat punch of the same radius.

    Notes
    -----
    Without friction a wave of pressure displaces the surfaces of both bodies, so that their compliances add for every wavelength.
    """
    line = LayeredLine(equivalent_profile(Paraboloid(1.0)), Kernel(PairCompliance((Compliance(body),), tip)))
    return np.asarray(line.stiffness(radius) / (2.0 * radius))


@dataclass(frozen=True, kw_only=True)
class FilmModulus(Study):
    """
    Young's modulus of a film, ``young_modulus`` (Pa), with its 95 % interval, ``young_modulus_low`` and ``young_modulus_high``.

    Over ``point``: ``contact_radius`` (m), ``width`` a/t, ``reduced_modulus`` and ``fitted_modulus`` (Pa), measured and by the springs of
    the layers, and ``film_modulus`` (Pa), Young's modulus of the film by each point alone, nan where none gives the measured one.
    """

    body: Layered
    """Film and substrate, for :func:`pymdr.solve`."""

    subject: ClassVar[str] = "a modulus of a film"
    _drawn: ClassVar = ("film_study", "data")
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "point": Column("point", ""),
        "contact_radius": Column("a", "m"),
        "width": Column("a / t", ""),
        "reduced_modulus": Column("E_r", "Pa"),
        "fitted_modulus": Column("fitted E_r", "Pa"),
        "film_modulus": Column("E film", "Pa"),
    }
    young_modulus = number("young_modulus", "Of the film in Pa.")

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the 95 % interval of Young's modulus in Pa."""
        return float(self.data["young_modulus_low"]), float(self.data["young_modulus_high"])

    def _remarks(self) -> list[str]:
        low, high = self.interval
        return [
            f"film E = {pascals(self.young_modulus)}, 95 % between {pascals(low)} and {pascals(high)}, thickness "
            f"{metres(self.body.thickness)}"
        ]


class _Data(NamedTuple):
    """Measured points of all indents."""

    radius: FloatArray
    reduced: FloatArray
    noise: FloatArray
    """Covariances of ln a and ln E_r, shape (n, 2, 2)."""
    common: FloatArray
    """Deviations that all points share, shape (n, 2, k)."""


class _Fit(NamedTuple):
    """The film's modulus by all points."""

    young: float
    half: float
    """Half of the 95 % interval of its logarithm."""
    fitted: FloatArray
    single: FloatArray
    fraction: float
    """Largest derivative of ln E_r by ln E of the film."""
    scatter: float


def film_modulus(
    profile: ContinuousStiffness,
    thickness: QuantityLike,
    substrate: Elastic | Rigid,
    *,
    poisson: QuantityLike | None = None,
    thickness_error: QuantityLike = 0.0,
    widths: Sequence[float] = (0.0, 3.0),
) -> FilmModulus:
    """
    Young's modulus of a film on a known substrate, from the stiffness over depth.

    The reduced modulus of a contact of the radius a on a film is that of a flat punch on the layered body, S/2a, which the equation of its springs
    gives for any a/t. The film's modulus is fitted to all points; no weight function is assumed.

    Parameters
    ----------
    profile : ContinuousStiffness
        Of :func:`pymdr.continuous_stiffness`, of one or more indents.
    thickness : quantity
        Of the film in m.
    substrate : Elastic or Rigid
        Half-space below the film.
    poisson : quantity, optional
        Poisson's ratio of the film; that of the profile unless given.
    thickness_error : quantity, optional
        Standard deviation of the thickness in m.
    widths : sequence of two floats, optional
        Range of a/t of the points that are used.

    Returns
    -------
    FilmModulus
        With an interval of 95 % from noise, calibration, drift and thickness.

    Raises
    ------
    ProblemError
        If fewer than 3 points are in the range, no modulus of the film gives the measured stiffness, or an argument is outside its limits.

    See Also
    --------
    continuous_stiffness : the profile.
    Layered : contacts on layers.

    Notes
    -----
    The springs of layers by the equation of Lebedev and Ufliand (1958), with the compliance of the tip added for every wavelength.

    References
    ----------
    Lebedev and Ufliand (1958), J. Appl. Math. Mech. 22, 442-450.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> film, silicon, tip = mdr.Elastic("10 GPa", 0.3), mdr.Elastic("165 GPa", 0.22), mdr.AreaFunction([24.5])
    >>> body = mdr.Layered([mdr.Layer(film, "500 nm")], base=silicon)
    >>> ball = mdr.solve(mdr.Contact(mdr.Paraboloid("20 um"), body, mdr.Elastic("1141 GPa", 0.07)), mdr.load("1 mN", steps=200))
    >>> a, stiffness = ball["contact_radius"].values, ball["normal_stiffness"].values
    >>> area = np.pi * a**2
    >>> force = 1e9 * area
    >>> record = {"indentation": np.sqrt(area / 24.5) + 0.75 * force / stiffness, "normal_force": force, "harmonic_stiffness": stiffness}
    >>> profile = mdr.continuous_stiffness(record, tip, poisson=0.3, points=8)
    >>> study = mdr.film_modulus(profile, "500 nm", silicon)
    >>> round(study.young_modulus / 1e9, 2)
    10.0
    """
    _check(profile, substrate)
    height, error = (
        to_si(thickness, "m", name="thickness"),
        to_si(thickness_error, "m", name="thickness_error"),
    )
    if not height > 0.0:
        raise ProblemError(f"thickness = {shown(thickness)}; it must be above 0 m")
    if not 0.0 <= error < height:
        raise ProblemError(
            f"thickness_error = {shown(thickness_error)}; it must be at least 0 m and below the thickness"
        )
    nu = profile.settings.poisson if poisson is None else to_si(poisson, "", name="poisson")
    if nu is None:
        raise ProblemError("Poisson's ratio of the film is not known; give poisson")
    data = _data(profile, height, widths)

    def body(young: float) -> Layered:
        return Layered([Layer(Elastic(young, nu), height)], base=substrate)

    def model(young: float, radius: FloatArray) -> FloatArray:
        return np.log(reduced_moduli(radius, body(young), profile.settings.tip))

    first = float(np.median(data.reduced[: max(1, data.reduced.size // 8)]))
    apparent = (1.0 - nu**2) / max(1.0 / first - profile.settings.tip, 1e-3 / first)
    return _study(data, _fitted(data, model, apparent, error / height), body, height)


def _check(profile: ContinuousStiffness, substrate: Elastic | Rigid) -> None:
    if not isinstance(profile, ContinuousStiffness):
        raise ProblemError(
            f"profile = {shown(profile)}; give what continuous_stiffness returns, over the depth"
        )
    if not isinstance(substrate, Elastic | Rigid):
        raise ProblemError(f"substrate = {shown(substrate)}; Elastic('165 GPa', 0.22) or Rigid() is needed")


def _data(profile: ContinuousStiffness, height: float, widths: Sequence[float]) -> _Data:
    try:
        low, high = (float(end) for end in widths)
    except (TypeError, ValueError):
        low, high = math.nan, math.nan
    if not 0.0 <= low < high <= 30.0:
        raise ProblemError(
            f"widths = {shown(widths)}; two ratios a/t from 0 to 30 are needed, such as (0, 3)"
        )
    points = [point for indent in profile.points for point in indent]
    a = np.array([point.values["contact_radius"] for point in points])
    used = [i for i in np.argsort(a, kind="stable") if low * height <= a[i] <= high * height]
    if len(used) < _FEWEST:
        raise ProblemError(
            f"{len(used)} points have a/t from {low:g} to {high:g}, the contact radii are from {metres(float(a.min()))} to "
            f"{metres(float(a.max()))}; at least {_FEWEST} are needed: check the thickness, {metres(height)}, or widen widths"
        )
    return _Data(
        a[used],
        np.array([points[i].values["reduced_modulus"] for i in used]),
        np.array([points[i].noise for i in used]),
        np.array([points[i].calibrated for i in used]),
    )


def _fitted(
    data: _Data, model: Callable[[float, FloatArray], FloatArray], apparent: float, error: float
) -> _Fit:
    """The film's modulus by generalised least squares; `model` gives ln E_r over Young's modulus and radii."""
    u = np.cos(math.pi * (np.arange(_TRIED) + 0.5) / _TRIED)
    span = math.log(_FACTOR)
    radius = np.append(data.radius * (1.0 - _STEP), data.radius * (1.0 + _STEP))
    tried = np.array([model(apparent * math.exp(span * x), radius) for x in u])
    series = chebyshev.chebfit(u, tried, _TRIED - 1)
    below, above = np.split(series, 2, axis=1)
    middle, by_radius = 0.5 * (below + above), (above - below) / (2.0 * _STEP)
    measured = np.log(data.reduced)
    single = _inverted(middle, measured)

    def variance(x: float) -> FloatArray:
        slope = np.stack([-chebyshev.chebval(x, by_radius), np.ones_like(measured)], axis=1)
        return np.asarray(np.einsum("ni,nij,nj->n", slope, data.noise, slope))

    grid = np.linspace(-1.0, 1.0, 241)
    misfits = [float(np.sum((measured - chebyshev.chebval(x, middle)) ** 2 / variance(x))) for x in grid]
    x = float(grid[int(np.argmin(misfits))])
    if abs(x) > 0.99:
        raise ProblemError(
            f"no modulus of the film between {pascals(apparent / _FACTOR)} and {pascals(apparent * _FACTOR)} gives the measured stiffness; check "
            "thickness, substrate and tip, or use narrower contacts (widths)"
        )
    rise = chebyshev.chebder(middle)
    for _ in range(20):
        weight = 1.0 / variance(x)
        slope = chebyshev.chebval(x, rise)
        step = float(
            np.sum(weight * slope * (measured - chebyshev.chebval(x, middle))) / np.sum(weight * slope**2)
        )
        x = min(max(x + step, -1.0), 1.0)
        if abs(step) < 1e-12:
            break
    weight, slope = 1.0 / variance(x), chebyshev.chebval(x, rise)
    gain = weight * slope / np.sum(weight * slope**2)
    residuals = measured - chebyshev.chebval(x, middle)
    freedom = measured.size - 1
    square = float(np.sum(weight * residuals**2))
    widened = 1.0
    if square > float(chdtri(freedom, 0.05)):
        widened = math.sqrt(square / freedom) * float(stdtrit(freedom, 0.975)) / _NORMAL
    by = chebyshev.chebval(x, by_radius)
    # ln E_r over ln t falls as it rises over ln a, beside the factor of a half-space, which has none
    shared = np.concatenate(
        [data.common[:, 1] - by[:, None] * data.common[:, 0], (by * error)[:, None]], axis=1
    )
    total = widened**2 / float(np.sum(weight * slope**2)) + float(np.sum((gain @ shared) ** 2))
    return _Fit(
        apparent * math.exp(span * x),
        _NORMAL * span * math.sqrt(total),
        np.exp(measured - residuals),
        np.where(np.isfinite(single), apparent * np.exp(span * single), math.nan),
        float(np.max(slope)) / span,
        math.sqrt(square / freedom),
    )


def _inverted(series: FloatArray, measured: FloatArray) -> FloatArray:
    """The place at which each series has its measured value; NaN without one."""
    grid = np.linspace(-1.0, 1.0, 801)
    values = chebyshev.chebval(grid, series)
    result = np.full(measured.size, math.nan)
    for i, row in enumerate(values):
        above = np.maximum.accumulate(row)
        if above[0] < measured[i] < above[-1]:
            result[i] = float(np.interp(measured[i], above, grid))
    return result


def _study(data: _Data, fit: _Fit, body: Callable[[float], Layered], height: float) -> FilmModulus:
    columns = {
        "contact_radius": (data.radius, "m"),
        "width": (data.radius / height, ""),
        "reduced_modulus": (data.reduced, "Pa"),
        "fitted_modulus": (fit.fitted, "Pa"),
        "film_modulus": (fit.single, "Pa"),
    }
    single = {
        "young_modulus": fit.young,
        "young_modulus_low": fit.young * math.exp(-fit.half),
        "young_modulus_high": fit.young * math.exp(fit.half),
    }
    everywhere = np.ones(data.radius.size, dtype=bool)
    claim = Claim(
        Level.APPROXIMATE,
        "elastic springs of film and substrate at the contact radius of the area function; the radius assumes the sink-in of a half-space",
        f"{SOURCES['oliver-pharr']}; Lebedev and Ufliand (1958), J. Appl. Math. Mech. 22, 442-450",
        everywhere,
    )
    notes = []
    if fit.scatter > _SCATTER:
        notes.append(
            f"the points scatter about one film modulus by {written(fit.scatter, '')} times their noise, and the interval is widened; possible causes: pile-up, plastic flow in film or "
            "substrate, another thickness, or a modulus that varies with depth"
        )
    return FilmModulus(
        data=dataset(
            {
                **{name: ("point", values, {"units": unit}) for name, (values, unit) in columns.items()},
                **{name: ((), value, {"units": "Pa"}) for name, value in single.items()},
            },
            coords={"point": ("point", np.arange(1, data.radius.size + 1), {"units": ""})},
        ),
        claims=dict.fromkeys([*columns, *single], claim),
        assumptions=(
            Assumption(
                "one modulus",
                "root mean square misfit of the points over their noise; if significant, the interval is widened by it",
                fit.scatter,
                _SCATTER,
            ),
            Assumption(
                "influence of the film",
                "smallest value of 1 - d ln E_r / d ln E of the film; near 1 the stiffness is that of the substrate",
                1.0 - fit.fraction,
                _WEAK,
            ),
        ),
        notes=tuple(notes),
        references=("oliver-pharr",),
        body=body(fit.young),
    )
