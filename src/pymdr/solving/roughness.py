"""The power spectrum of a measured surface, and the equivalent randomly rough surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.mapping.surfaces.spectrum import (
    FEWEST_BINS,
    WITHIN,
    Bins,
    Law,
    Rings,
    anisotropy,
    rings_of,
    self_affine,
)
from pymdr.presentation import plot
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import Topography
from pymdr.problem.topography.preparing import interpolated_fraction
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_PIXELS_PER_WAVE = 4
"""Shortest resolved wave in pixels; shorter ones are aliased."""
_FEWEST_PIXELS = 32
_BAND = (0.16, 0.84)
_MOST_DIRECTED, _MOST_RATIO = 2.0, 2.0
"""Limits of anisotropy and of the ratio of rms heights, which are dominated by a few random long waves."""
_MOST_INTERPOLATED = 0.1
"""Largest fraction of interpolated pixels for a fit."""
_BIAS, _HURST_BIAS = 5.0, 0.25
"""Largest relative decrease of the spectrum and change of H per fraction of interpolated pixels (256 x 256 pixels, gaps of 1 to 60)."""
_DEVIATIONS = 2.0
"""Standard deviations by which an exponent may exceed 1."""


@dataclass(frozen=True)
class SelfAffineFit:
    """C2D ~ q^(-2 (1 + H)) on a range, flat above the roll-off."""

    hurst: float
    """H."""
    hurst_error: float
    """Its standard deviation, by chance and by deviations from the law, plus the effect of interpolated pixels."""
    roll_off: float | None
    """Wavelength in m above which the spectrum is flat; None if the heights show none."""
    roll_off_error: float
    """Relative standard deviation of the roll-off; 0 without one."""
    shortest: float
    """Shortest wavelength in m at which the law holds."""
    longest: float
    """Longest wavelength in m at which the law holds."""
    scatter: float
    """Standard deviation of ln C2D about the law beyond chance."""
    rms: float
    """Root mean square of the heights of the patch in m."""
    law_rms: float
    """Root mean square height of the law in m, from the longer side down to the shortest wavelength."""
    size: tuple[float, float]
    """Sides of the patch in m."""

    @property
    def is_self_affine(self) -> bool:
        """Whether H is above 0, and not above 1 by more than two standard deviations."""
        return 0.0 < self.hurst <= 1.0 + _DEVIATIONS * self.hurst_error

    def rough_surface(self, *, shortest: QuantityLike | None = None, seed: int = 0) -> RoughSurface:
        """
        The randomly rough surface of this law on a patch of the same size and rms height.

        Parameters
        ----------
        shortest : quantity, optional
            Its shortest wavelength in m, by default that of the fit; the law is extrapolated below it.
        seed : int, optional

        Raises
        ------
        NotValidError
            If the exponent is not that of a self-affine surface, 0 < H <= 1.
        """
        if not self.is_self_affine:
            raise NotValidError(
                f"the spectrum has H = {self.hurst:.3g} +- {self.hurst_error:.2g}, and a RoughSurface needs 0 < H <= 1: "
                "check its figure for effects of tip, noise and trends"
            )
        return RoughSurface(
            hurst=min(self.hurst, 1.0),
            rms=self.rms,
            size=np.array(self.size),
            shortest=self.shortest if shortest is None else to_si(shortest, "m", name="shortest"),
            longest=self.roll_off,
            seed=seed,
        )


@dataclass(frozen=True, kw_only=True)
class PowerSpectrum(Study):
    """The radially averaged power spectrum of a surface, and its self-affine law on a range."""

    data: xr.Dataset
    """
    Over ``wave_number`` (1/m), eight in a decade: wavelength (m), power_spectrum (m^4) with ``_low`` and ``_high``, 16th and 84th
    percentiles of random realisations, waves, the number of independent averaged waves, and law (m^4), NaN beyond its range. In the
    attributes: rms (m), shortest_resolved (m).
    """
    rings: xr.Dataset
    """All data: power_spectrum (m^4) over ``wave_number`` (1/m), including unresolved waves."""
    topography: Topography
    fit_or_none: SelfAffineFit | None
    """The fit; None if the law holds on no range."""

    subject: ClassVar = "a power spectrum"
    columns: ClassVar = {
        "wave_number": Column("q", "m^-1"),
        "wavelength": Column("wavelength", "m"),
        "power_spectrum": Column("C2D", "m^4"),
        "power_spectrum_low": Column("low", "m^4"),
        "power_spectrum_high": Column("high", "m^4"),
        "law": Column("law", "m^4"),
    }
    summary_claims: ClassVar = ("power_spectrum", "law")

    @property
    def fit(self) -> SelfAffineFit:
        """The self-affine fit; raise if the law holds on no range."""
        self.claims["law"].require("law")
        assert self.fit_or_none is not None
        return self.fit_or_none

    def _remarks(self) -> list[str]:
        lines = [f"rms height {metres(self.data.attrs['rms'])}"]
        if self.fit_or_none is not None:
            fit = self.fit_or_none
            lines += [
                f"H = {fit.hurst:.3f} +- {fit.hurst_error:.3f} from {metres(fit.shortest)} to {metres(fit.longest)}",
                "the heights show no roll-off"
                if fit.roll_off is None
                else f"roll-off at {metres(fit.roll_off)} +- {100.0 * fit.roll_off_error:.2g} %",
            ]
            if math.isfinite(fit.law_rms):
                lines.append(
                    f"the law has an rms height of {metres(fit.law_rms)} between the longer side and its shortest wave"
                )
        return lines

    def _figure(self) -> mpl.figure.Figure:
        """The surface, and its spectrum with the law and the range on which it holds."""
        return plot.spectrum_study(self.topography.heights, self.topography.size, self.data, self.rings)


def power_spectrum(
    topography: Topography, *, periodic: bool = False, tip_radius: QuantityLike | None = None
) -> PowerSpectrum:
    """
    The radially averaged power spectrum of a surface, and its self-affine law.

    C2D = |z(q)|^2/(4 pi^2 A), with h^2 = 2 pi int C2D q dq, as means over rings and over eight bins a decade of the wave number. The law
    ln C2D = c - 2 (1 + H) ln max(1, q/q_r) is fitted to the logarithms on the widest range on which no bin deviates by more than a
    quarter beyond chance.

    Parameters
    ----------
    topography : Topography
        At least 32 x 32 heights, without missing ones. Remove trends by :meth:`~pymdr.Topography.detrend`.
    periodic : bool, optional
        Whether the patch is one period of the surface. If not, a Hann window in both directions weights the heights to suppress
        the jump from one edge to the other.
    tip_radius : quantity, optional
        Radius in m of the tip of the measurement: shorter waves than it can resolve (:meth:`~pymdr.Topography.tip_cutoff`) are left out.

    Returns
    -------
    PowerSpectrum
        Its ``fit`` has H, the roll-off, the range and their errors, and ``fit.rough_surface()`` the surface for :func:`pymdr.press_rough`.

    Raises
    ------
    ProblemError
        If there are too few heights, some are missing, all are equal, or no wave is resolved by the tip.

    See Also
    --------
    read_topography : heights from a file.
    press_rough : the stiffness of the fitted surface.

    Notes
    -----
    The spectrum of Jacobs, Junge and Pastewka (2017); the tip of Sanner et al. (2022). Waves shorter than four pixels are left out because of aliasing. Interpolated heights have no short waves: a
    fraction of them lowers the spectrum by up to five times that fraction (if deep pixels are missing; by the fraction itself for random
    ones), as the claim states. No law is fitted above 10 %.

    References
    ----------
    - Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001, doi:10.1088/2051-672X/aa51f8.
    - Sanner et al. (2022), Appl. Surf. Sci. Adv. 7, 100190, doi:10.1016/j.apsadv.2021.100190.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> rng = np.random.default_rng(1)
    >>> q = np.hypot(*np.meshgrid(np.fft.fftfreq(256), np.fft.fftfreq(256)))
    >>> q[0, 0] = np.inf
    >>> z = np.fft.ifft2(np.fft.fft2(rng.standard_normal(q.shape)) * q**-1.8).real
    >>> fit = mdr.power_spectrum(mdr.Topography(1e-9 * z, "1 um"), periodic=True).fit
    >>> abs(fit.hurst - 0.8) < 2.0 * fit.hurst_error < 0.08
    True
    """
    if not isinstance(topography, Topography):
        raise ProblemError(
            f"{shown(topography)} is not a Topography; read one with read_topography, or write Topography(heights, size)"
        )
    heights = topography.complete()
    if min(heights.shape) < _FEWEST_PIXELS:
        raise ProblemError(
            f"{heights.shape[0]} x {heights.shape[1]} heights; at least {_FEWEST_PIXELS} x {_FEWEST_PIXELS} are needed for waves "
            "of several lengths"
        )
    rms = float(np.std(heights))
    if rms <= np.finfo(float).eps * float(np.max(np.abs(heights))):
        raise ProblemError(
            f"all heights are {metres(float(heights.flat[0]))}: a smooth plane has no spectrum; check the channel and the unit of the heights"
        )
    pixel = _PIXELS_PER_WAVE * float(topography.spacing.max())
    tip = 0.0 if tip_radius is None else topography.tip_cutoff(tip_radius)
    resolved = max(pixel, tip)
    rings = rings_of(heights, topography.size, periodic)
    bins, law = self_affine(rings, periodic, 2.0 * math.pi / resolved)
    filled = interpolated_fraction(topography)
    if filled > _MOST_INTERPOLATED:
        law = None
    fit = None if law is None else _fit(bins, law, topography, rms, filled)
    data = _columns(bins, law, resolved)
    data.attrs |= {"rms": rms, "shortest_resolved": resolved}
    whole = (2.0 * math.pi / resolved, 2.0 * math.pi / float(topography.size.max()))
    return PowerSpectrum(
        data=data,
        rings=_labelled({"power_spectrum": (rings.spectrum, "m^4")}, np.exp(rings.log_q)),
        topography=topography,
        fit_or_none=fit,
        claims=_claims(topography, data, periodic, tip > pixel, resolved, fit),
        assumptions=_assumptions(rings, fit, whole),
        notes=topography.steps,
    )


def _fit(bins: Bins, law: Law, topography: Topography, rms: float, filled: float) -> SelfAffineFit:
    deviation = np.sqrt(np.diag(law.covariance))
    hurst = 0.5 * law.steepness - 1.0
    width, length = topography.size.tolist()
    shortest = 2.0 * math.pi / math.exp(bins.high[law.last])
    roll_off = 2.0 * math.pi / math.exp(law.corner) if law.rolled else None
    law_rms = math.nan
    if hurst > 0.0:
        # the same spectrum with an rms height of 1 m; beyond H = 1 its waves agree with those of H = 1 to a few percent
        like = RoughSurface(min(hurst, 1.0), 1.0, topography.size, shortest, roll_off)
        place = bins.log_q[law.first]
        law_rms = math.sqrt(math.exp(float(law.log_c(place))) / float(like.spectrum_2d(math.exp(place))))
    return SelfAffineFit(
        hurst=hurst,
        hurst_error=0.5 * float(deviation[1]) + _HURST_BIAS * filled,
        roll_off=roll_off,
        roll_off_error=float(deviation[2]),
        shortest=shortest,
        longest=2.0 * math.pi / math.exp(bins.low[law.first]),
        scatter=law.excess,
        rms=rms,
        law_rms=law_rms,
        size=(width, length),
    )


def _columns(bins: Bins, law: Law | None, resolved: float) -> xr.Dataset:
    from scipy.special import gammaincinv

    spectrum = np.exp(bins.log_c)
    seen = np.exp(bins.high) <= 2.0 * math.pi / resolved * (1.0 + 1e-9)
    ends = [bins.waves / gammaincinv(bins.waves, fraction) for fraction in reversed(_BAND)]
    along = np.full(spectrum.size, np.nan)
    if law is not None:
        fitted = slice(law.first, law.last + 1)
        along[fitted] = np.exp(law.log_c(bins.log_q[fitted]))
    q = np.exp(bins.log_q)
    values = {
        "wavelength": (2.0 * math.pi / q, "m"),
        "power_spectrum": (np.where(seen, spectrum, np.nan), "m^4"),
        "power_spectrum_low": (np.where(seen, spectrum * ends[0], np.nan), "m^4"),
        "power_spectrum_high": (np.where(seen, spectrum * ends[1], np.nan), "m^4"),
        "waves": (bins.waves, ""),
        "law": (along, "m^4"),
    }
    return _labelled(values, q)


def _labelled(values: dict[str, tuple[FloatArray, str]], q: FloatArray) -> xr.Dataset:
    return dataset(
        {name: ("wave_number", column, {"units": unit}) for name, (column, unit) in values.items()},
        coords={"wave_number": ("wave_number", q, {"units": "m^-1"})},
    )


def _claims(
    topography: Topography,
    data: xr.Dataset,
    periodic: bool,
    by_tip: bool,
    resolved: float,
    fit: SelfAffineFit | None,
) -> dict[str, Claim]:
    nx, ny = topography.heights.shape
    how = "taken for one period of the surface" if periodic else "weighted by a Hann window"
    limit = "the resolution of the tip" if by_tip else f"{_PIXELS_PER_WAVE} pixels"
    reason = (
        f"of one patch of {nx} x {ny} pixels, {how}; waves are resolved down to {metres(resolved)}, {limit}; the band is the random "
        "variation of a Gaussian surface"
    )
    filled = interpolated_fraction(topography)
    interpolated = f"{100.0 * filled:.2g} % of the pixels were interpolated"
    if filled > 0.0:
        reason += f"; {interpolated}, and have no short waves: the spectrum is up to {100.0 * min(_BIAS * filled, 1.0):.2g} % too low"
    source = SOURCES["tip" if by_tip else "spectrum"]
    spectrum = Claim(Level.APPROXIMATE, reason, source, np.isfinite(data["power_spectrum"].values))
    claims = dict.fromkeys(("power_spectrum", "power_spectrum_low", "power_spectrum_high"), spectrum)
    where = np.isfinite(data["law"].values)
    percent = f"{100.0 * WITHIN:g} %"
    if fit is None:
        why = (
            f"{interpolated}, more than {100.0 * _MOST_INTERPOLATED:g} %, and distort the spectrum; crop the surface to the measured part by "
            "topography.fill_missing('crop'), or measure it again"
            if filled > _MOST_INTERPOLATED
            else f"no range of {FEWEST_BINS} bins follows a power law, with or without a roll-off, to {percent}"
        )
        claims["law"] = Claim(Level.NOT_VALID, why, SOURCES["spectrum"], where)
        return claims
    kind = "self-affine" if fit.is_self_affine else "a power law, but not self-affine (0 < H <= 1),"
    fitted = (
        f"{kind} from {metres(fit.shortest)} to {metres(fit.longest)}, with ends known to one bin (a third): no bin deviates by "
        f"more than {percent} beyond its scatter; deviations beyond chance have a standard deviation of {100.0 * fit.scatter:.2g} %"
    )
    claims["law"] = Claim(Level.APPROXIMATE, fitted, SOURCES["spectrum"], where)
    return claims


def _assumptions(
    rings: Rings, fit: SelfAffineFit | None, whole: tuple[float, float]
) -> tuple[Assumption, ...]:
    ends = whole if fit is None else (2.0 * math.pi / fit.shortest, 2.0 * math.pi / fit.longest)
    text = "largest over smallest mean of the spectrum by direction"
    listed = [Assumption("isotropy", text, anisotropy(rings, ends[1], ends[0]), _MOST_DIRECTED)]
    if fit is not None and math.isfinite(fit.law_rms):
        ratio = max(fit.law_rms / fit.rms, fit.rms / fit.law_rms)
        text = "rms height of the law over that of the heights, or the reverse"
        listed.append(Assumption("one law", text, ratio, _MOST_RATIO))
    return tuple(listed)
