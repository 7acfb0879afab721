"""Hardness and modulus over depth, from a stiffness that is measured continuously."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from scipy.special import stdtrit

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.problem.materials import Material
from pymdr.problem.profiles import AreaFunction
from pymdr.solving.nanoindentation.analysing import Settings, differences, quantities
from pymdr.solving.nanoindentation.arguments import Known, settings_of
from pymdr.solving.nanoindentation.calibrating import DIAMOND, AreaCalibration
from pymdr.solving.nanoindentation.records import Record, Records, attempted, numbered, records_of, refusals
from pymdr.solving.nanoindentation.unloading import Peak, errors_of, noise_of
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray, QuantityLike, shown, written

if TYPE_CHECKING:
    pass

_FEWEST, _RATIO = 12, 1.3
"""Rows of a point, and the largest ratio of the depths at its ends."""
_TOP, _RISING = 4.0, 0.999
"""Noises above which a force is one of contact; part of the largest depth up to which the loading is read."""
_ROUNDING = 1e-9
"""Relative deviation of columns without noise."""
_MOST = 2000
_NAMES = {
    "indentation": "m",
    "normal_force": "N",
    "stiffness": "N/m",
    "contact_depth": "m",
    "contact_radius": "m",
    "contact_area": "m^2",
    "hardness": "Pa",
    "reduced_modulus": "Pa",
    "plane_strain_modulus": "Pa",
    "young_modulus": "Pa",
}
_WITH_INTERVAL = ("stiffness", "hardness", "reduced_modulus", "plane_strain_modulus", "young_modulus")


class Point(NamedTuple):
    """One depth of one indent."""

    values: Mapping[str, float]
    deviations: Mapping[str, float]
    """Half widths of the 95 % intervals, in logarithms."""
    noise: FloatArray
    """Covariance of ln a and ln E_r from the noise of the rows, shape (2, 2)."""
    calibrated: FloatArray
    """Their derivatives by what was calibrated, and by a deviation of the drift, shape (2, k + 1)."""


@dataclass(frozen=True, kw_only=True)
class ContinuousStiffness(Study):
    """
    Hardness and moduli over ``indent`` and ``point``, from shallow to deep; nan where an indent has fewer points.

    ``indentation``, ``contact_depth``, ``contact_radius`` (m), ``normal_force`` (N), ``contact_area`` (m^2), and ``stiffness`` (N/m), ``hardness``,
    ``reduced_modulus``, ``plane_strain_modulus``, ``young_modulus`` (Pa), each of these with the ends of its 95 % interval, such as ``hardness_low`` and
    ``hardness_high``.
    """

    points: tuple[tuple[Point, ...], ...]
    """Of each indent."""
    settings: Settings
    """Tip, frame and area function."""

    subject: ClassVar[str] = "a continuous stiffness"
    _drawn: ClassVar = ("profile_study", "data")
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "indent": Column("indent", ""),
        "record": Column("record", ""),
        "indentation": Column("h", "m"),
        "normal_force": Column("F", "N"),
        "stiffness": Column("S", "N/m"),
        "contact_depth": Column("h_c", "m"),
        "hardness": Column("H", "Pa"),
        "reduced_modulus": Column("E_r", "Pa"),
        "young_modulus": Column("E", "Pa"),
        "young_modulus_low": Column("E low", "Pa"),
        "young_modulus_high": Column("E high", "Pa"),
    }

    def _remarks(self) -> list[str]:
        attributes = self.data.attrs
        return [
            f"frame compliance {written(attributes['frame_compliance'], 'm/N')}, beta = {attributes['beta']:g}, epsilon = "
            f"{attributes['epsilon']:g}; E low and E high are ends of 95 % intervals"
        ]


def continuous_stiffness(
    records: Records,
    area: AreaFunction | AreaCalibration,
    *,
    frame_compliance: QuantityLike | None = None,
    tip: Material = DIAMOND,
    poisson: QuantityLike | None = None,
    beta: float = 1.0,
    epsilon: float = 0.75,
    points: int = 40,
) -> ContinuousStiffness:
    """
    Hardness and modulus over depth, from the harmonic stiffness that is measured during the loading.

    At every depth the contact depth is h_c = h - epsilon F/S, the hardness F/A(h_c), and the reduced modulus S sqrt(pi/A)/(2 beta), with
    1/S = 1/S_measured - C of the frame.

    Parameters
    ----------
    records : xarray.Dataset or mapping of str to array_like, a sequence of them, or ThermalDrift
        Indents with ``indentation`` (m), ``normal_force`` (N) and ``harmonic_stiffness`` (N/m), such as of :func:`pymdr.read_indents`. Depths count from the
        first contact.
    area : AreaFunction or AreaCalibration
        Area function of the tip. That of :func:`pymdr.calibrate_area` brings its frame compliance and its uncertainty.
    frame_compliance : quantity, optional
        In m/N, of which depths and stiffness are not yet corrected; 0 unless given. It must be left out with a calibration.
    tip, poisson, beta : optional
        As for :func:`pymdr.oliver_pharr`.
    epsilon : float, optional
        The constant epsilon = (h - h_c) S/F of the method; 0.75 unless given.
    points : int, optional
        Number of depths; fewer if a point would have fewer than 12 rows.

    Returns
    -------
    ContinuousStiffness
        Profiles with 95 % intervals, which contain the noise of the rows around each depth, the calibration, and the rate of a drift. Of several
        indents, those that cannot be evaluated are nan, and a note gives the reason.

    Raises
    ------
    ProblemError
        If no record has a harmonic stiffness, enough rows and a valid depth, or an argument is outside its limits.

    See Also
    --------
    film_modulus : modulus of a film on a substrate.
    oliver_pharr : stiffness of the unloading.

    Notes
    -----
    The continuous stiffness of Oliver and Pharr (1992). Each point is the middle of a quadratic through its rows, in the order of measurement, of depth,
    force and stiffness, so that noise of the depth does not bias it. Its rows differ in depth by 30 % at most; shallower rows are left out.

    References
    ----------
    Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> tip, modulus, hardness = mdr.AreaFunction([24.5], unit="1 nm"), 70e9, 9e9
    >>> contact_depth = np.linspace(20e-9, 300e-9, 600)
    >>> area = tip.area_at(contact_depth)
    >>> force, stiffness = hardness * area, 2 * modulus * np.sqrt(area / np.pi)
    >>> record = {"indentation": contact_depth + 0.75 * force / stiffness, "normal_force": force, "harmonic_stiffness": stiffness}
    >>> study = mdr.continuous_stiffness(record, tip, poisson=0.17, points=5)
    >>> study.to("hardness", "GPa").values[0, [0, -1]].round(3).tolist()
    [9.0, 9.0]
    """
    listed = records_of(records)
    if isinstance(points, bool) or not isinstance(points, int) or not 1 <= points <= _MOST:
        raise ProblemError(f"points = {shown(points)}; a whole number from 1 to {_MOST} is needed")
    if epsilon is None:
        raise ProblemError("epsilon = None; without an unloading a number is needed, such as 0.75")
    settings = settings_of(Known(area, frame_compliance, tip, poisson, beta, epsilon), (0.25, 0.98))
    errors: dict[int, ProblemError] = {}
    profiles = attempted(listed, lambda _, record: _profile(record, settings, points), errors)
    notes = refusals(errors)
    notes += [
        f"indent {i}: {shallow} shallow points left out, where the noise is too large for a modulus"
        for i, (_, shallow) in profiles.items()
        if shallow
    ]
    known = [profiles[i][0] if i in profiles else () for i in range(1, len(listed) + 1)]
    return _study(listed, known, notes, settings)


def _profile(record: Record, settings: Settings, count: int) -> tuple[tuple[Point, ...], int]:
    """Points of one indent, and how many had no modulus."""
    rows = _loading(record, settings.frame)
    columns, elapsed = rows[:3], rows[3]
    bins = _bins(columns[1], count)
    if not bins:
        raise ProblemError(
            f"{columns.shape[1]} rows of the loading have a stiffness; at least {_FEWEST} are needed within a ratio of {_RATIO:g} of their depths: "
            "record more rows"
        )
    fits = [_local(columns[:, part]) for part in bins]
    together = np.concatenate([residuals for _, _, residuals in fits], axis=1)
    ones = np.ones((together.shape[1], 1))
    correlated = np.array([errors_of(row, ones).correlated for row in together])
    scale = np.sqrt(np.outer(correlated, correlated))
    points, fault = [], None
    for part, (centre, covariance, _) in zip(bins, fits, strict=True):
        freedom = (part.stop - part.start) / float(np.max(correlated)) - 3.0
        rounding = np.diag((_ROUNDING * centre) ** 2)
        middle = 0.5 * (part.start + part.stop - 1)
        drift = record.rate_error * float(np.interp(middle, np.arange(elapsed.size), elapsed))
        try:
            points.append(_point(centre, scale * covariance + rounding, max(freedom, 1.0), drift, settings))
        except ProblemError as error:
            fault = error
    if not points:
        assert fault is not None
        raise fault
    return tuple(points), len(bins) - len(points)


def _loading(record: Record, frame: float) -> FloatArray:
    """Forces, depths and compliances of the contact during the loading, and times since contact, shape (4, n)."""
    if record.stiffness is None:
        raise ProblemError(
            "the record has no harmonic_stiffness; give records with continuous stiffness, or use oliver_pharr"
        )
    depth = record.depth - frame * record.force
    force, stiffness = record.force, record.stiffness
    end = int(np.argmax(depth >= _RISING * np.max(depth))) + 1
    elapsed = np.zeros(depth.size) if record.elapsed is None else record.elapsed
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = 1.0 / stiffness - frame
        good = np.isfinite(compliance) & (stiffness > 0.0)
    good &= (force > _TOP * noise_of(force)) & (depth > 0.0)
    good[end:] = False
    if np.any(good) and not np.any(compliance[good] > 0.0):
        raise ProblemError(
            f"the frame compliance {written(frame, 'm/N')} is above the measured compliance, {written(float(np.max(1.0 / stiffness[good])), 'm/N')}; "
            "leave frame_compliance out if the instrument has subtracted it"
        )
    return np.stack([force[good], depth[good], compliance[good], elapsed[good]])


def _bins(depth: FloatArray, count: int) -> list[slice]:
    """Stretches of rows of equal number or of a ratio of depths, from the deepest on."""
    top = np.maximum.accumulate(depth)
    size, bins, stop = max(_FEWEST, depth.size // count), [], depth.size
    while stop >= _FEWEST:
        start = max(stop - size, int(np.searchsorted(top, top[stop - 1] / _RATIO)), 0)
        if stop - start < _FEWEST:
            break
        bins.append(slice(start, stop))
        stop = start
    return bins[::-1]


def _local(columns: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The middle of quadratics through columns, its covariance, and the residuals."""
    n = columns.shape[1]
    u = np.linspace(-1.0, 1.0, n)
    design = np.stack([np.ones(n), u, u * u], axis=1)
    inverse = np.linalg.pinv(design)
    parameters = columns @ inverse.T
    residuals = columns - parameters @ design.T
    covariance = residuals @ residuals.T / max(n - 3, 1) * float(inverse[0] @ inverse[0])
    return parameters[:, 0], covariance, residuals


def _point(
    centre: FloatArray, covariance: FloatArray, freedom: float, drift: float, settings: Settings
) -> Point:
    """One depth, of the mean force, depth and compliance with their covariance."""
    assert settings.epsilon is not None

    def read(numbers: FloatArray, known: Settings = settings, further: float = 0.0) -> dict[str, float]:
        force, depth, compliance = (float(x) for x in numbers)
        if not compliance > further:
            raise ProblemError(
                "the stiffness is not above 0 N/m without the frame; check the frame compliance"
            )
        assert known.epsilon is not None
        peak = Peak(force, depth, math.nan, 1.0 / compliance, known.epsilon, math.nan, 1.0)
        result = quantities(peak, known, further)
        result["contact_radius"] = math.sqrt(result["contact_area"] / math.pi)
        result["indentation"], result["normal_force"] = result["max_depth"], force
        return {name: result[name] for name in _NAMES if name in result}

    values = read(centre)
    names = [*values]

    def logarithms(numbers: FloatArray) -> FloatArray:
        return np.asarray(np.log(np.array([*read(numbers).values()])))

    slopes = differences(logarithms, centre, covariance)
    noise = slopes @ covariance @ slopes.T
    known = slopes[:, 1:2] * drift
    if settings.covariance is not None:
        coefficients = settings.area.coefficients
        assert coefficients is not None

        def calibrated(numbers: FloatArray) -> FloatArray:
            area = replace(settings.area, coefficients=numbers[1:])
            changed = read(centre, replace(settings, area=area), float(numbers[0]))
            return np.asarray(np.log(np.array([*changed.values()])))

        by_area = differences(calibrated, np.append(0.0, coefficients), settings.covariance)
        # whose squares are the covariance of the calibration
        known = np.concatenate([by_area @ _root(settings.covariance), known], axis=1)
    total = noise + known @ known.T
    half = float(stdtrit(freedom, 0.975)) * np.sqrt(np.diag(total))
    pair = [names.index("contact_radius"), names.index("reduced_modulus")]
    return Point(values, dict(zip(names, half.tolist(), strict=True)), noise[np.ix_(pair, pair)], known[pair])


def _root(covariance: FloatArray) -> FloatArray:
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    return np.asarray(unit[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _study(
    listed: Sequence[Record],
    profiles: Sequence[tuple[Point, ...]],
    notes: Sequence[str],
    settings: Settings,
) -> ContinuousStiffness:
    longest = max(profiles, key=len)
    width = len(longest)
    columns: dict[str, FloatArray] = {}
    for name in longest[0].values:
        values, half = (np.full((len(profiles), width), math.nan) for _ in range(2))
        for i, profile in enumerate(profiles):
            values[i, width - len(profile) :] = [point.values[name] for point in profile]
            half[i, width - len(profile) :] = [point.deviations[name] for point in profile]
        columns[name] = values
        if name in _WITH_INTERVAL:
            columns[f"{name}_low"], columns[f"{name}_high"] = values * np.exp(-half), values * np.exp(half)
    where = np.isfinite(columns["hardness"]).ravel()
    measured = Claim(
        Level.APPROXIMATE,
        "by the area function at the contact depth: the surface sinks in as that of an elastic half-space and does not pile up",
        f"{SOURCES['oliver-pharr']}; {SOURCES['bolshakov-pharr']}",
        where,
    )
    claims = {name: measured for name in columns if name not in ("indentation", "normal_force")}
    if settings.poisson is None:
        reason = "Poisson's ratio of the sample is not known; give poisson"
        claims["young_modulus"] = Claim(
            Level.NOT_VALID, reason, SOURCES["oliver-pharr"], np.zeros_like(where)
        )
    ratio = columns["normal_force"] / columns["stiffness"] / columns["indentation"]
    return ContinuousStiffness(
        data=dataset(
            {
                name: (
                    ("indent", "point"),
                    values,
                    {"units": _NAMES[name.removesuffix("_low").removesuffix("_high")]},
                )
                for name, values in columns.items()
            },
            coords={
                **numbered(listed),
                "point": ("point", np.arange(1, width + 1), {"units": ""}),
            },
            attrs={
                "frame_compliance": settings.frame,
                "beta": settings.beta,
                "epsilon": settings.epsilon,
            },
        ),
        claims=claims,
        assumptions=(
            Assumption(
                "pile-up",
                "1 - 1.5 F/(S h), about the residual depth over the largest; above the limit the surface may pile up, which the record does not show",
                float(np.nanmax(1.0 - 1.5 * ratio)),
                0.7,
            ),
        ),
        notes=tuple(notes),
        references=("oliver-pharr", "bolshakov-pharr"),
        points=tuple(profiles),
        settings=settings,
    )
