"""Area function and frame compliance from indents in a body of known modulus."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtri, stdtrit

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.materials import Elastic, Material
from pymdr.problem.profiles import AreaFunction
from pymdr.problem.profiles.area import MOST_COEFFICIENTS
from pymdr.solving.fits.spectrum import NORMAL_95
from pymdr.solving.nanoindentation.analysing import (
    STEP,
    common_priors,
    differences,
    peak_with_covariance,
    whiteness,
)
from pymdr.solving.nanoindentation.records import (
    Record,
    Records,
    labels_of,
    named_indent,
    records_of,
    refuse_uncorrected,
)
from pymdr.solving.nanoindentation.unloading import Peak, fit_limits, fitted_power, unloading_of
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray, QuantityLike, shown, to_si, written

if TYPE_CHECKING:
    pass

DIAMOND = Elastic("1141 GPa", 0.07)
SILICA = Elastic("72 GPa", 0.17)
_NANOMETRE = 1e-9
_ROUNDS, _SETTLED = 8, 1e-9
_SCANNED = np.linspace(-0.5, 0.95, 117)
_LARGEST_MISFIT, _LEAST_SINGULAR = 3.0, 1e-7


@dataclass(frozen=True, kw_only=True)
class AreaCalibration(Study):
    """
    The area function of a tip and the compliance of the frame.

    Over ``indent``: ``contact_depth`` and ``max_depth`` (m), ``stiffness`` (N/m), ``measured_area`` (m^2) of each indent, and
    ``contact_area`` (m^2) of the area function with its 95 % interval, ``contact_area_low`` and ``contact_area_high``.
    """

    area: AreaFunction
    """The area function, for :func:`pymdr.oliver_pharr` and as a profile."""
    covariance: FloatArray
    """Of the frame compliance in m/N and the coefficients."""

    subject: ClassVar[str] = "a calibration of an area function"
    _drawn: ClassVar = ("area_study", "data")
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "indent": Column("indent", ""),
        "max_depth": Column("h", "m"),
        "stiffness": Column("S", "N/m"),
        "contact_depth": Column("h_c", "m"),
        "measured_area": Column("measured A", "m^2"),
        "contact_area": Column("A", "m^2"),
        "contact_area_low": Column("low", "m^2"),
        "contact_area_high": Column("high", "m^2"),
    }

    @property
    def frame_compliance(self) -> float:
        """Compliance of the frame in m/N."""
        return float(self.data.attrs["frame_compliance"])

    @property
    def intervals(self) -> FloatArray:
        """Ends of the 95 % intervals of the frame compliance in m/N and of the coefficients, shape (1 + n, 2)."""
        assert self.area.coefficients is not None
        centre = np.append(self.frame_compliance, self.area.coefficients)
        half = NORMAL_95 * np.sqrt(np.diag(self.covariance))
        return np.stack([centre - half, centre + half], axis=1)

    def _remarks(self) -> list[str]:
        attributes = self.data.attrs
        assert self.area.coefficients is not None
        (low, high), *ends = self.intervals.tolist()
        known = (
            "given"
            if attributes["frame_given"]
            else f"95 % between {written(low, 'm/N')} and {written(high, 'm/N')}"
        )
        return [
            f"frame compliance {written(self.frame_compliance, 'm/N')}, {known}",
            "A = C0 h^2 + C1 h + C2 h^(1/2) + ... with h in nm and A in nm^2:",
            *(
                f"  C{i} = {value:.6g}, 95 % between {low:.6g} and {high:.6g}"
                for i, (value, (low, high)) in enumerate(zip(self.area.coefficients, ends, strict=True))
            ),
        ]


def calibrate_area(
    records: Records,
    reference: Elastic = SILICA,
    *,
    tip: Material = DIAMOND,
    terms: int = 3,
    frame_compliance: QuantityLike | None = None,
    beta: float = 1.0,
    epsilon: float | None = 0.75,
    fit_range: Sequence[float] = (0.25, 0.98),
) -> AreaCalibration:
    """
    Area function of a tip and compliance of the frame from indents in a body of known modulus.

    The total compliance of every indent is C + sqrt(pi)/(2 beta E_r sqrt(A(h_c))), where the contact depth h_c depends on the
    compliance C of the frame. C and the coefficients of A are fitted together by least squares, weighted by the noise of each indent.

    Parameters
    ----------
    records : sequence of MeasuredCurve or xarray.Dataset, or ThermalDrift
        Indents with their unloading, of several depths; the deflection of the frame included. Those that :func:`pymdr.thermal_drift` corrected bring
        the uncertainty of their rates.
    reference : Elastic, optional
        The indented body; fused silica, 72 GPa and 0.17, unless given.
    tip : Elastic or Rigid, optional
        Diamond, 1141 GPa and 0.07, unless given.
    terms : int, optional
        Number of coefficients, 1 to 9: C0 h^2 + C1 h + C2 h^(1/2) + ...
    frame_compliance : quantity, optional
        In m/N, such as ``"0.3 nm/mN"``; fitted unless given.
    beta, epsilon, fit_range : optional
        As for :func:`pymdr.oliver_pharr`.

    Returns
    -------
    AreaCalibration
        With ``area``, ``frame_compliance`` and their ``covariance``; :func:`pymdr.oliver_pharr` takes it in place of an area function.

    Raises
    ------
    ProblemError
        If there are fewer indents than unknowns, a record has no unloading, or an argument is outside its limits.

    See Also
    --------
    oliver_pharr : hardness and modulus with the calibrated area.
    AreaFunction : the calibrated profile.

    Notes
    -----
    The calibration of Oliver and Pharr (1992). Depths below those of the indents are extrapolated.

    References
    ----------
    Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> tip = mdr.AreaFunction([24.5, 800.0], unit="1 nm")
    >>> silica = mdr.Contact(tip, mdr.Elastic("72 GPa", 0.17), mdr.Elastic("1141 GPa", 0.07))
    >>> indents = []
    >>> for peak in np.geomspace(0.5e-3, 10e-3, 6):
    ...     result = mdr.solve(silica, mdr.load(peak, steps=100) >> mdr.load(0.0, steps=100))
    ...     force, depth = result["normal_force"].values, result["indentation"].values
    ...     indents.append(mdr.MeasuredCurve(force=force, indentation=depth + 0.5e-6 * force))
    >>> result = mdr.calibrate_area(indents, terms=2, epsilon=None)
    >>> bool(abs(result.frame_compliance / 0.5e-6 - 1) < 0.02)
    True
    """
    listed = records_of(records)
    _check_terms(terms)
    given = None if frame_compliance is None else frame_of(frame_compliance)
    unknowns, limits = terms + (given is None), fit_limits(fit_range)
    if len(listed) <= unknowns:
        raise ProblemError(
            f"{len(listed)} indents for {unknowns} unknowns; give at least {unknowns + 1}, of several depths, or fewer terms"
        )
    check_factors(beta, epsilon)
    priors = _priors(listed, given or 0.0, limits)
    modulus = 1.0 / (tip_compliance(reference) + tip_compliance(tip))
    frame, scale = given or 0.0, 2.0 * beta * modulus / math.sqrt(math.pi)
    for turn in range(_ROUNDS):
        try:
            peaks = _peaks(listed, frame, epsilon, limits, priors)
        except ProblemError as error:
            if turn == 0:
                raise
            # corrected for a frame that the indents do not determine, a record is no unloading any more
            raise _undetermined(unknowns) from error
        model = _Model(peaks, scale, terms, given is not None)
        solved = _solved(model)
        _jacobian(model, solved)
        change = float(solved[0])
        frame += change
        if abs(change) <= _SETTLED * float(np.min(1.0 / peaks.stiffness)):
            break
    return _study(model, solved, frame, (beta, modulus))


def _check_terms(terms: int) -> None:
    if isinstance(terms, bool) or not isinstance(terms, int) or not 1 <= terms <= MOST_COEFFICIENTS:
        raise ProblemError(f"terms = {shown(terms)}; a whole number from 1 to {MOST_COEFFICIENTS} is needed")


def frame_of(given: QuantityLike) -> float:
    """The compliance of a frame in m/N."""
    frame = to_si(given, "m/N", name="frame_compliance")
    if not frame >= 0.0:
        raise ProblemError(f"frame_compliance = {shown(given)}; it must be at least 0 m/N")
    return frame


def tip_compliance(tip: Material) -> float:
    """1/E* of one body in 1/Pa."""
    if not isinstance(tip, Material) or tip.is_viscoelastic or not tip.homogeneous:
        raise ProblemError(f"{shown(tip)}; a homogeneous elastic or rigid body is needed")
    return float(surface_compliances(tip).normal)


def check_factors(beta: float, epsilon: float | None) -> None:
    """Refuse values of beta and epsilon outside their limits."""
    if not 0.5 < to_si(beta, "", name="beta") < 2.0:
        raise ProblemError(
            f"beta = {shown(beta)}; it must be above 0.5 and below 2, such as 1.034 for a Berkovich tip"
        )
    if epsilon is not None and not 0.0 < to_si(epsilon, "", name="epsilon") <= 1.0:
        raise ProblemError(f"epsilon = {shown(epsilon)}; it must be above 0 and at most 1, or None")


def _priors(listed: Sequence[Record], frame: float, limits: tuple[float, float]) -> FloatArray:
    """Prior probability of white noise in each unloading."""
    white = []
    for record, label in zip(listed, labels_of(listed), strict=True):
        with named_indent(label):
            refuse_uncorrected(record)
            white.append(whiteness(record, frame, limits))
    return np.array(common_priors(white))


class _Peaks(NamedTuple):
    """Peaks of all indents, shape (n,)."""

    force: FloatArray
    depth: FloatArray
    stiffness: FloatArray
    epsilon: FloatArray
    covariance: FloatArray
    """Of depth, 1/stiffness, force and epsilon, shape (n, 4, 4)."""


def _peaks(
    listed: Sequence[Record],
    frame: float,
    epsilon: float | None,
    limits: tuple[float, float],
    priors: FloatArray,
) -> _Peaks:
    """The peaks of all indents whose depths are corrected for a frame."""

    def read(peak: Peak) -> FloatArray:
        return np.array([peak.depth, 1.0 / peak.stiffness, peak.force, peak.epsilon])

    result = []
    for record, prior, label in zip(listed, priors.tolist(), labels_of(listed), strict=True):
        with named_indent(label):
            rows = unloading_of(record, frame, limits)
            result.append(peak_with_covariance(rows, fitted_power(rows, prior), epsilon, read))
    values = np.array([centre for centre, _ in result]).T
    return _Peaks(values[2], values[0], 1.0 / values[1], values[3], np.array([c for _, c in result]))


class _Model:
    """Compliances of indents and of an area function, over a change of the frame and coefficients in the largest depth."""

    def __init__(self, peaks: _Peaks, scale: float, terms: int, frame_given: bool) -> None:
        self.peaks = peaks
        self.factor = scale
        self.frame_given = frame_given
        self.length = float(np.max(peaks.depth))
        self.exponents = 2.0 ** (1.0 - np.arange(terms))

    def contact(self, change: float, measured: FloatArray) -> FloatArray:
        """Contact depths in m if the frame is more compliant by a change."""
        depth, compliance, force, epsilon = measured
        return np.asarray(depth - change * force - epsilon * force * (compliance - change))

    def area(self, coefficients: FloatArray, depth: FloatArray) -> FloatArray:
        """Area in m^2 by the area function."""
        powers = (np.maximum(depth, 0.0) / self.length)[:, None] ** self.exponents
        return np.asarray(self.length**2 * np.maximum(powers @ coefficients, 1e-12))

    def excess(self, unknowns: FloatArray, measured: FloatArray) -> FloatArray:
        """Measured compliance of the contact less that of the area function, in m/N."""
        change = float(unknowns[0])
        area = self.area(unknowns[1:], self.contact(change, measured))
        return np.asarray(measured[1] - change - 1.0 / (self.factor * np.sqrt(area)))

    @property
    def measured(self) -> FloatArray:
        """Depths, compliances, forces and epsilon, shape (4, n)."""
        peaks = self.peaks
        return np.array([peaks.depth, 1.0 / peaks.stiffness, peaks.force, peaks.epsilon])

    def deviations(self, unknowns: FloatArray) -> FloatArray:
        """Standard deviations of the excess in m/N, from the noise of the indents."""
        measured = self.measured
        slopes = []
        for k in range(len(measured)):
            step = np.zeros_like(measured)
            step[k] = 1e-6 * measured[k]
            slopes.append(
                (self.excess(unknowns, measured + step) - self.excess(unknowns, measured - step))
                / (2.0 * step[k])
            )
        gradient = np.array(slopes)
        variance = np.einsum("in,nij,jn->n", gradient, self.peaks.covariance, gradient)
        # indents without noise are weighted by their compliance
        return np.asarray(np.sqrt(variance + (1e-9 * measured[1]) ** 2))


def _solved(model: _Model) -> FloatArray:
    """Change of the frame in m/N, and coefficients, by least squares."""
    measured = model.measured
    compliance = measured[1]
    best, least = np.zeros(0), math.inf
    for change in np.array([0.0]) if model.frame_given else _SCANNED * float(compliance.min()):
        contact = model.contact(change, measured)
        if np.any(contact <= 0.0):
            continue
        area = 1.0 / (model.factor * (compliance - change)) ** 2
        powers = (contact / model.length)[:, None] ** model.exponents * model.length**2
        coefficients = np.linalg.lstsq(powers / area[:, None], np.ones(area.size), rcond=None)[0]
        trial = np.append(change, coefficients)
        misfit = float(np.sum((model.excess(trial, measured) / compliance) ** 2))
        if misfit < least:
            best, least = trial, misfit
    if not best.size:
        raise ProblemError("an indent has no contact depth above 0; depths must count from the first contact")
    size = np.append(float(compliance.min()), np.ones(best.size - 1))
    free = slice(1, None) if model.frame_given else slice(0, None)
    for _ in range(3):
        weight = 1.0 / model.deviations(best)

        def residuals(x: FloatArray, weight: FloatArray = weight, start: FloatArray = best) -> FloatArray:
            return weight * model.excess(_filled(start, x * size[free], free), measured)

        result = least_squares(
            residuals, best[free] / size[free], method="lm", x_scale="jac", xtol=1e-12, ftol=1e-12
        )
        best = _filled(best, result.x * size[free], free)
    return best


def _jacobian(model: _Model, solved: FloatArray) -> FloatArray:
    """Derivatives of the excess by what is fitted, over its noise; refused if they do not determine it."""
    measured = model.measured
    weight = 1.0 / model.deviations(solved)
    steps = np.append(1e-4 * float(measured[1].min()), 1e-4 * np.maximum(np.abs(solved[1:]), 1e-6))
    slopes = differences(lambda x: weight * model.excess(x, measured), solved, np.diag((steps / STEP) ** 2))
    jacobian = slopes[:, 1:] if model.frame_given else slopes
    singular = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=0), compute_uv=False)
    if not singular[-1] > _LEAST_SINGULAR * singular[0]:
        raise _undetermined(singular.size)
    return jacobian


def _undetermined(unknowns: int) -> ProblemError:
    return ProblemError(
        f"the indents do not determine {unknowns} unknowns; give indents of more different depths, fewer terms, or "
        "frame_compliance"
    )


def _filled(whole: FloatArray, part: FloatArray, where: slice) -> FloatArray:
    filled = whole.copy()
    filled[where] = part
    return filled


def _study(model: _Model, solved: FloatArray, frame: float, known: tuple[float, float]) -> AreaCalibration:
    measured, peaks = model.measured, model.peaks
    free = slice(1, None) if model.frame_given else slice(0, None)
    weight = 1.0 / model.deviations(solved)
    jacobian = _jacobian(model, solved)
    freedom = measured.shape[1] - jacobian.shape[1]
    scatter = math.sqrt(float(np.sum((weight * model.excess(solved, measured)) ** 2)) / freedom)
    # indents that differ by more than their noise, as chance does once in twenty calibrations
    more = freedom * scatter**2 > float(chdtri(freedom, 0.05))
    widened = scatter * float(stdtrit(freedom, 0.975)) / NORMAL_95 if more else 1.0
    inverse = np.linalg.pinv(jacobian)
    covariance = np.zeros((solved.size, solved.size))
    covariance[free, free] = widened**2 * inverse @ inverse.T
    to_nanometres = np.append(1.0, (model.length / _NANOMETRE) ** (2.0 - model.exponents))
    change = float(solved[0])
    contact = model.contact(change, measured)
    area = model.area(solved[1:], contact)
    by_coefficient = model.length**2 * (contact / model.length)[:, None] ** model.exponents
    half = (
        NORMAL_95
        * np.sqrt(np.einsum("ni,ij,nj->n", by_coefficient, covariance[1:, 1:], by_coefficient))
        / area
    )
    columns = {
        "max_depth": (peaks.depth - change * peaks.force, "m"),
        "stiffness": (1.0 / (measured[1] - change), "N/m"),
        "contact_depth": (contact, "m"),
        "measured_area": (1.0 / (model.factor * (measured[1] - change)) ** 2, "m^2"),
        "contact_area": (area, "m^2"),
        "contact_area_low": (area * np.exp(-half), "m^2"),
        "contact_area_high": (area * np.exp(half), "m^2"),
    }
    everywhere = np.ones(area.size, dtype=bool)
    reason = (
        "least squares over all indents; it relies on the modulus of the reference and on elastic sink-in"
    )
    return AreaCalibration(
        data=dataset(
            {name: ("indent", values, {"units": unit}) for name, (values, unit) in columns.items()},
            coords={"indent": ("indent", np.arange(1, area.size + 1), {"units": ""})},
            attrs={
                "frame_compliance": frame,
                "frame_given": int(model.frame_given),
                "beta": known[0],
                "reduced_modulus": known[1],
                "scatter": scatter,
            },
        ),
        claims={
            name: Claim(Level.APPROXIMATE, reason, SOURCES["oliver-pharr"], everywhere)
            for name in ("contact_area", "contact_depth", "measured_area", "stiffness")
        },
        assumptions=(
            Assumption(
                "scatter",
                "root mean square misfit of the indents over their noise; if significant, intervals are widened by it",
                scatter,
                _LARGEST_MISFIT,
            ),
        ),
        references=("oliver-pharr",),
        area=AreaFunction(solved[1:] * to_nanometres[1:], unit=_NANOMETRE),
        covariance=covariance * np.outer(to_nanometres, to_nanometres),
    )
