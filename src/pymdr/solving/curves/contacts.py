"""The contact point by four methods of the literature."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from pymdr.deferred import mpl
from pymdr.errors import ProblemError
from pymdr.presentation import plot
from pymdr.problem.facts import Facts
from pymdr.problem.measured import MeasuredSamples, Samples, Step
from pymdr.solving.curves.baselines import Baseline, check_contact, given_baseline
from pymdr.solving.curves.branches import Branch, IntArray, branch_of, broken_power, spread
from pymdr.units import FloatArray, QuantityLike, to_si, written


@dataclass(frozen=True)
class Estimate:
    """
    The contact point by one method.

    Parameters
    ----------
    value : float
        Contact point in m along the position of the curve.
    low, high : float
        Its resolution, by its windows and the noise.
    source : str
        Its reference.
    """

    value: float
    low: float
    high: float
    source: str


@dataclass(frozen=True)
class ContactPoint:
    """
    The contact point of a curve, with the estimates of all methods.

    Parameters
    ----------
    value : float
        Median of the methods in m, along the position of the curve (travel or indentation).
    low, high : float
        The smallest and the largest estimate of all methods, including their resolutions.
    methods : mapping of str to Estimate
        By name.
    baseline : Baseline
        The baseline that was subtracted.
    """

    value: float
    low: float
    high: float
    methods: Mapping[str, Estimate] = field(repr=False)
    baseline: Baseline = field(repr=False)

    @property
    def disagreement(self) -> float:
        """Largest difference of the estimates in m."""
        values = [one.value for one in self.methods.values()]
        return max(values) - min(values)

    def summary(self) -> str:
        """The estimates relative to the contact point, one line each."""
        width = max(map(len, self.methods))

        def offset(place: float) -> str:
            return written(place - self.value, "m", 3)

        lines = [
            f"  {name:<{width}}  {offset(one.value)}  ({offset(one.low)} to {offset(one.high)})"
            for name, one in self.methods.items()
        ]
        return "\n".join([f"baseline {self.baseline}", f"{self}; from there", *lines])

    def __str__(self) -> str:
        return (
            f"contact point {written(self.value, 'm', 6)}, between {written(self.low, 'm', 6)} and {written(self.high, 'm', 6)}; "
            f"the methods disagree by {written(self.disagreement, 'm', 3)}"
        )

    def plot(self, *curves: MeasuredSamples) -> mpl.figure.Figure:
        """
        The curve with its baseline, and the beginning of its contact with all estimates.

        Parameters
        ----------
        *curves : MeasuredCurve
            The curve of the contact point, or all segments of the record.
        """
        methods = {name: (one.value, one.low, one.high) for name, one in self.methods.items()}
        return plot.measured_curves(
            curves, self.baseline.force_at, methods, (self.value, self.low, self.high)
        )


def contact_point_of(curve: MeasuredSamples, baseline: Baseline | QuantityLike | None = None) -> ContactPoint:
    """
    The contact point by four methods, and their disagreement.

    ``deviation``
        The last sample, from the deep end, whose smoothed force is below the threshold of the baseline (Müller et al. 2019,
        `deviation from baseline`). The contact is earlier, because the noise hides its beginning.
    ``gradient``
        Where the slope of the force, by a regression in a sliding window, decreases to 0 (Müller et al. 2019, `gradient zero
        crossing`).
    ``line and power``
        Least squares of a line followed by a power of the depth, for every contact point (Lin, Dimitriadis and Horkay 2007; Rudoy et
        al. 2010), on the first third of the rise, with exponents from 1 to 3.
    ``ratio of variances``
        The largest ratio of the variances in the windows after and before a sample (Gavara 2016).

    Parameters
    ----------
    curve : MeasuredCurve
        An approach, or a whole record, of which the approach is used.
    baseline : Baseline or quantity, optional
        The baseline of the curve by default.

    Raises
    ------
    ProblemError
        If the curve is a hold or a retreat, has no contact, or too few samples before it.

    Notes
    -----
    With adhesion the bodies jump into contact, and the methods differ by the width of the jump; :func:`pymdr.fit` uses the law of
    adhesion instead.

    Sources: Lin, Dimitriadis and Horkay, J. Biomech. Eng. 129 (2007) 430; Rudoy et
    al., J. R. Stat. Soc. C 59 (2010) 573; Gavara, Sci. Rep. 6 (2016) 21267; Müller et al. (nanite), BMC Bioinformatics 20 (2019) 465.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x = np.linspace(-1e-6, 1e-6, 400)
    >>> noise = 1e-12 * np.random.default_rng(1).normal(size=400)
    >>> point = mdr.MeasuredCurve(force=2.0 * np.clip(x, 0.0, None) ** 1.5 + noise, indentation=x).contact_point()
    >>> point.low < 0.0 < point.high
    True
    """
    if curve.segment == "retreat":
        raise ProblemError(
            "the contact point of a retraction is not defined, because the bodies may stick; give that of the approach, or a position"
        )
    line = given_baseline(curve, baseline)
    branch = branch_of(curve)
    rise = Branch(branch.samples, branch.position, branch.force - line.force_at(branch.position))
    noise = max(line.noise, 1e-9 * float(np.ptp(rise.force)))
    smooth, threshold = _thresholds(rise, line)
    power = _line_and_power(rise, noise)
    # the number of samples in which the rise exceeds all noise
    start = int(np.searchsorted(np.maximum.accumulate(rise.position), power.value))
    clear = np.flatnonzero(smooth[start:] >= max(4.0 * threshold, 6.0 * noise))
    window = int(clear[0]) if clear.size else smooth.size - 1 - start
    methods = {
        "deviation": _deviation(rise, smooth, threshold),
        "gradient": _gradient(rise, noise, window),
        "line and power": power,
        "ratio of variances": _ratio_of_variances(rise, noise, window),
    }
    return ContactPoint(
        value=float(np.median([one.value for one in methods.values()])),
        low=min(one.low for one in methods.values()),
        high=max(one.high for one in methods.values()),
        methods=methods,
        baseline=line,
    )


def set_contact_point(curve: Samples, contact_point: ContactPoint | QuantityLike | None = None) -> Samples:
    """
    A curve with positions relative to the contact point.

    Parameters
    ----------
    curve : MeasuredCurve
        In any of its segments, without its baseline.
    contact_point : ContactPoint or quantity, optional
        That of the approach for a hold or a retreat, or a position in m; that of the curve by default.

    Returns
    -------
    MeasuredCurve
        With the step.

    Raises
    ------
    ProblemError
        As :meth:`contact_point`.
    """
    point = contact_point_of(curve) if contact_point is None else contact_point
    if isinstance(point, ContactPoint):
        place, text = point.value, str(point)
        numbers = {"value": point.value, "low": point.low, "high": point.high}
    else:
        place = to_si(point, "m", name="contact_point")
        text, numbers = f"contact point {written(place, 'm')}, given", {"value": place}
    name = "travel" if curve.indentation is None else "indentation"
    position = curve.position - place
    return replace(
        curve,
        indentation=None if curve.indentation is None else position,
        travel=None if curve.travel is None else position,
        step=Step("contact point", f"{text}; {name} from there", Facts(numbers)),
        before=curve,
    )


def _thresholds(rise: Branch, line: Baseline) -> tuple[FloatArray, float]:
    """The smoothed force, and its threshold."""
    smooth = scipy.ndimage.uniform_filter1d(rise.force, max(1, rise.force.size // 200))
    free = smooth[rise.position <= line.high] if line.samples else smooth[: max(5, smooth.size // 10)]
    size = spread(free) if free.size else line.noise
    largest = float(np.max(np.abs(free), initial=0.0))
    rounding = 1e-9 * float(np.ptp(rise.force))
    return smooth, max(float(np.clip(largest, 3.0 * size, 6.0 * size)), rounding)


def _deviation(rise: Branch, smooth: FloatArray, least: float) -> Estimate:
    below = np.flatnonzero(smooth <= least)
    if not below.size or below[-1] >= smooth.size - 3:
        where = "always above" if not below.size else "never above"
        raise ProblemError(
            f"no contact point: the force is {where} the threshold of {written(least, 'N')} that the noise of the baseline sets; begin at a larger distance, "
            "press deeper, or give the baseline as a force"
        )
    last = int(below[-1])
    above = np.flatnonzero(smooth[last:] >= 4.0 * least)
    window = int(above[0]) if above.size else smooth.size - 1 - last
    x = rise.position
    hidden = abs(float(x[min(last + window, x.size - 1)] - x[last]))
    length = _window_length(rise, last, max(2, x.size // 200))
    # for a power of at most 2 the part below a threshold is no longer than that up to four times the threshold;
    # noise of a third of the threshold at both ends may halve the visible part
    value = float(x[last])
    return Estimate(value, value - 2.0 * hidden - length, value + length, "Müller et al. 2019")


def _window_length(rise: Branch, at: int, samples: int) -> float:
    """Length in m of some samples adjacent to one."""
    x, last = rise.position, rise.position.size - 1
    ends = max(at - samples, 0), min(at + samples, last)
    return max(abs(float(x[at] - x[ends[0]])), abs(float(x[ends[1]] - x[at])), float(np.ptp(x)) / x.size)


def _width(rise: Branch, window: int) -> int:
    return int(np.clip(max(rise.force.size // 100, window, 20), 5, max(5, rise.force.size // 4)))


def _gradient(rise: Branch, noise: float, window: int) -> Estimate:
    """The contact point by the gradient of the force."""
    x, f, width = rise.position, rise.force, _width(rise, window)
    x, f = x - x.mean(), f - f.mean()
    mean_x, mean_f = scipy.ndimage.uniform_filter1d(x, width), scipy.ndimage.uniform_filter1d(f, width)
    spread_x = scipy.ndimage.uniform_filter1d(x * x, width) - mean_x**2
    slope = np.where(
        spread_x > 0.05 * float(np.median(spread_x)),
        (scipy.ndimage.uniform_filter1d(x * f, width) - mean_x * mean_f)
        / np.maximum(spread_x, 1e-12 * float(np.max(x * x))),
        0.0,
    )
    steepest = int(np.argmax(slope))
    limit = 0.01 * float(slope[steepest])
    flat = np.flatnonzero(slope[: steepest + 1] <= limit)
    at = int(flat[-1]) if flat.size else 0
    error = noise / np.sqrt(width * max(float(spread_x[at]), 1e-300))
    clear = np.flatnonzero(slope[at : steepest + 1] >= max(4.0 * error, 4.0 * limit))
    hidden = abs(float(x[at + int(clear[0])] - x[at])) if clear.size else 0.0
    length = _window_length(rise, at, width)
    value = float(rise.position[at])
    return Estimate(value, value - max(length, hidden), value + length, "Müller et al. 2019")


def _line_and_power(rise: Branch, noise: float) -> Estimate:
    x, f = rise.position, rise.force
    whole = broken_power(x, f)
    check_contact(rise, whole.rise, whole.noise, whole.evidence)
    smooth = scipy.ndimage.uniform_filter1d(f, max(1, f.size // 200))
    top = float(smooth.max())
    enough = max(top / 3.0, min(top, 30.0 * noise))
    end = int(np.argmax(smooth >= enough)) + 1
    near = broken_power(x[:end], f[:end]) if end >= 40 else whole
    return Estimate(near.start, near.low, near.high, "Lin et al. 2007; Rudoy et al. 2010")


def _ratio_of_variances(rise: Branch, noise: float, window: int) -> Estimate:
    f = rise.force
    width = min(_width(rise, 2 * window), f.size // 3)
    sums, squares = (np.concatenate([[0.0], np.cumsum(v)]) for v in (f, f * f))
    at: IntArray = np.arange(width, f.size - width)

    def variance(first: IntArray) -> FloatArray:
        mean = (sums[first + width] - sums[first]) / width
        return np.asarray(np.maximum((squares[first + width] - squares[first]) / width - mean**2, 0.0))

    ratio = variance(at) / (variance(at - width) + (0.5 * noise) ** 2)
    best = int(at[int(np.argmax(ratio))])
    # the ratio is largest where the rise fills the window after the sample, up to a window after the contact
    length, value = _window_length(rise, best, width), float(rise.position[best])
    return Estimate(value, value - length, value + length, "Gavara 2016")
