"""The recorded force out of contact: an offset and a tilt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from pymdr.errors import ProblemError
from pymdr.problem.facts import Facts
from pymdr.problem.measured import MeasuredSamples, Samples, Step
from pymdr.solving.curves.branches import Branch, branch_of, broken_power, spread
from pymdr.units import FloatArray, QuantityLike, to_si, written

CHECK_SIGNS = "check the signs of force and position (with keep_signs compression is positive)"
"""Remedy for records without contact."""
_LEAST = 10
_SEEN = 5.0
"""Smallest rise of a contact relative to the noise."""
_EVIDENCE = 30.0


@dataclass(frozen=True)
class Baseline:
    r"""
    The line F = offset + tilt (position - middle), with its noise and range.

    Parameters
    ----------
    offset : float
        In N, at the `middle`.
    tilt : float
        In N/m: virtual deflection, or a drift at constant speed.
    middle : float
        Middle of the positions out of contact in m.
    low, high : float
        Ends of those positions in m.
    noise : float
        Standard deviation about the line in N, from the median of absolute deviations.
    samples : int
        Number of samples of the line.
    """

    offset: float
    tilt: float = 0.0
    middle: float = 0.0
    low: float = 0.0
    high: float = 0.0
    noise: float = 0.0
    samples: int = 0

    def force_at(self, position: FloatArray) -> FloatArray:
        """Force in N without contact at positions in m."""
        return np.asarray(self.offset + self.tilt * (position - self.middle))

    def __str__(self) -> str:
        return (
            f"{written(self.offset, 'N')} with a tilt of {written(self.tilt, 'N/m')}, noise {written(self.noise, 'N')}, "
            f"from {self.samples} samples"
        )


def baseline_of(curve: MeasuredSamples) -> Baseline:
    """
    The baseline of a curve: a robust line through the samples before contact.

    The part before contact ends at the start of a fitted power-law rise, less a tenth of its length, or less a quarter if the
    noise hides the beginning of the rise. The line minimises the sum of log(1 + r^2/s^2) (Cauchy's loss), which is robust
    against few outliers, with the scale s of the residuals.

    Parameters
    ----------
    curve : MeasuredCurve
        An approach, a retreat, or a whole record, of which the approach is used; compression positive.

    Raises
    ------
    ProblemError
        If the curve has no contact, or fewer than 10 samples before it.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x = np.linspace(-1e-6, 1e-6, 400)
    >>> force = 2e-3 * x + 1e-9 + 2.0 * np.clip(x, 0.0, None) ** 1.5
    >>> line = mdr.MeasuredCurve(force=force, indentation=x).baseline()
    >>> round(line.tilt, 6)
    0.002
    """
    branch = branch_of(curve)
    leaving = branch.samples[0] > branch.samples[-1]
    seen = broken_power(branch.position, branch.force, jump=leaving)
    check_contact(branch, seen.rise, seen.noise, seen.evidence)
    free_end = float(branch.position[0])
    # with much noise the interval may extend to the free end; then take most of the part before the visible rise
    end = max(seen.low - 0.1 * (seen.low - free_end), free_end + 0.75 * (seen.clear_from - free_end))
    count = int(np.argmax(branch.position > end)) if np.any(branch.position > end) else branch.position.size
    if count < _LEAST:
        raise ProblemError(
            f"{count} samples are before the contact (limit {_LEAST}), too few for a baseline; begin at a larger distance "
            "from the contact, or give the baseline as a force"
        )
    return _line(branch.position[:count], branch.force[:count])


def check_contact(branch: Branch, rise: float, noise: float, evidence: float) -> None:
    """
    Require a rise that exceeds the noise.

    Raises
    ------
    ProblemError
        If it does not, so that the curve has no contact.
    """
    size = float(np.ptp(branch.force))
    if rise <= max(_SEEN * noise, 1e-9 * size) or evidence < _EVIDENCE:
        raise ProblemError(
            f"the curve shows no contact: over {written(float(np.ptp(branch.position)), 'm')} its force deviates from a straight line by "
            f"{written(rise, 'N')}, with a noise of {written(noise, 'N')} (limit {_SEEN:g} times the noise); press "
            f"deeper, begin at a larger distance, or {CHECK_SIGNS}"
        )


def subtract_baseline(curve: Samples, baseline: Baseline | QuantityLike | None = None) -> Samples:
    """
    A curve without its baseline.

    Parameters
    ----------
    curve : MeasuredCurve
        In any of its segments.
    baseline : Baseline or quantity, optional
        That of the approach for a hold or a retreat, or an offset in N; that of the curve by default.

    Returns
    -------
    MeasuredCurve
        With the force F - baseline, and the step.

    Raises
    ------
    ProblemError
        As :meth:`baseline`.
    """
    line = given_baseline(curve, baseline)
    numbers = {name: float(getattr(line, name)) for name in ("offset", "tilt", "middle", "noise", "samples")}
    return replace(
        curve,
        force=curve.force - line.force_at(curve.position),
        step=Step("baseline", f"{line}, subtracted from the force", Facts(numbers)),
        before=curve,
    )


def given_baseline(curve: MeasuredSamples, baseline: Baseline | QuantityLike | None) -> Baseline:
    """The given baseline, or that of the curve."""
    if baseline is None:
        return baseline_of(curve)
    return baseline if isinstance(baseline, Baseline) else Baseline(to_si(baseline, "N", name="baseline"))


def _line(x: FloatArray, f: FloatArray) -> Baseline:
    middle, half = 0.5 * float(x.min() + x.max()), 0.5 * float(np.ptp(x)) or 1.0
    u = (x - middle) / half
    columns = np.stack([np.ones_like(u), u], axis=1)
    start = np.linalg.lstsq(columns, f, rcond=None)[0]
    scale = spread(f - columns @ start)
    if scale > 0.0:
        fitted = scipy.optimize.least_squares(
            lambda p: (f - columns @ (start + scale * p)) / scale,
            np.zeros(2),
            jac=lambda p: -columns,
            loss="cauchy",
            f_scale=2.0,
        )
        start = start + scale * fitted.x
    return Baseline(
        offset=float(start[0]),
        tilt=float(start[1]) / half,
        middle=middle,
        low=float(x.min()),
        high=float(x.max()),
        noise=spread(f - columns @ start),
        samples=x.size,
    )
