"""The exact law of a contact, in coordinates in which it is smooth at the tip or the pull-off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.theories import theory_of
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.curves import Line
from pymdr.line.following import pressed, pulled
from pymdr.line.foundation import normal_force, normal_stiffness, states_at_depth
from pymdr.problem.contact import Contact
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.exporting.knots import Knots, Sample
from pymdr.solving.mapped import map_to_line
from pymdr.solving.pulloff import PullOff
from pymdr.units import FloatArray, metres, newtons

_NEXT_TO_KINK = 2e-7
"""Relative distance of the knots on both sides of a kink: the rounding of ln F, over this distance, is an error of the stiffness below 5e-8, and
a jump of da/dd one of the radius below 5e-8."""
_NEAR_FOLD = 1e-9
"""Relative distance from a fold of the first state next to it."""
_BELOW = 73
"""Depths below the first knot at which a law is checked, over twelve decades."""
_CORNER = 1e-3
"""Ratio of the slopes of d at a fold and next to it, above which it is a corner."""
_WIDTHS = np.array([1.0, 0.3, 0.1, 0.03, 0.01, 0.003])
"""Widths of the fit next to a fold: narrow ones avoid a near corner, wide ones rounding."""
_DECADES = (16.0, 30.0)
"""Decades below the largest depth for the power of the tip; the effect of a layer decreases as the root of the depth."""
_ROUNDING = 20.0 * float(np.finfo(float).eps)
_KNOWN = 4.0
"""Decades over which the power must hold."""
_NO_POWER = 1e-12
"""Power of the radius below which the end is flat."""


@dataclass(frozen=True)
class Tip:
    """A law that begins at the tip: ln(F + pull) and ln a over ln d, straight lines below the first knot."""

    power: float
    """d ln F / d ln d below the first knot."""
    radius_power: float
    """d ln a / d ln d there."""
    pull: float
    """Constant pull in N that is subtracted from the force; 0 without adhesion."""

    @property
    def added(self) -> tuple[float, float]:
        """Force in N and stiffness in N/m that are added to |F| and |k| for relative errors."""
        return self.pull, 0.0

    @property
    def tip(self) -> tuple[float, float, float]:
        """Both powers and the pull in N at the tip."""
        return self.power, self.radius_power, self.pull

    def least(self, knots: Knots) -> float:
        """The least coordinate that is interpolated."""
        return float(knots.u[0])

    def before(self, d: FloatArray, knots: Knots) -> FloatArray:
        """Force, stiffness and radius before the first knot at depths in m: powers; 0 without contact."""
        answers = np.zeros((3, d.size))
        made = d > 0.0
        along = np.log(d[made]) - knots.u[0]
        pressing = np.exp(knots.y[0] + self.power * along)
        radius = np.exp(knots.z[0] + self.radius_power * along)
        answers[:, made] = pressing - self.pull, self.power * pressing / d[made], radius
        return answers

    def checked(self, d: FloatArray, first: float) -> FloatArray:
        """Depths in m at which a law is checked: those between its knots, and far below the first."""
        return np.concatenate([first * np.geomspace(1e-12, 1.0, _BELOW), d])

    def outside(self, first: float, pull_off: PullOff | None) -> str:
        """Text on the law outside a table."""
        pull = f", F = -{self.pull!r} N at first touch" if self.pull else ""
        return f"below d = {first!r} m F ~ d^{self.power:.12g}, a ~ d^{self.radius_power:.12g}; d <= 0: no contact{pull}"

    def remark(self, pull_off: PullOff | None) -> str:
        """Short text on the law outside a table."""
        return f"below the table F ~ d^{self.power:.6g}, a ~ d^{self.radius_power:.6g}"

    def relative_to(self) -> dict[str, str]:
        """Text on the reference of relative errors, if it is not the value itself."""
        return {"normal_force": f"|F| + {self.pull:.6g} N, the pull"} if self.pull else {}

    def coordinate(self, d: FloatArray) -> FloatArray:
        """The coordinate u of depths in m."""
        return np.log(d)

    def depth(self, u: FloatArray) -> FloatArray:
        """The depths in m at coordinates u."""
        return np.exp(u)

    def physical(self, knots: Knots) -> tuple[FloatArray, ...]:
        """Depth, force, stiffness, radius and rate of the radius."""
        d, pressing, a = np.exp(knots.u), np.exp(knots.y), np.exp(knots.z)
        return d, pressing - self.pull, knots.y_slope * pressing / d, a, knots.z_slope * a / d

    def error(self, ours: Knots, exact: Knots) -> FloatArray:
        """The largest of the relative errors of F + pull, k and a."""
        pressing = np.expm1(ours.y - exact.y)
        stiffness = (1.0 + pressing) * ours.y_slope / exact.y_slope - 1.0
        radius = np.expm1(ours.z - exact.z)
        return np.maximum(np.maximum(np.abs(pressing), np.abs(stiffness)), np.abs(radius))


@dataclass(frozen=True)
class Fold:
    """A law from the loss of contact on: F and a over u = sqrt(d - d_off)."""

    off: float
    """D_off in m."""
    force: float
    """Force in N added to |F| for relative errors: the largest pull."""
    stiffness: float
    """Stiffness in N/m added to |k| for relative errors: that at the fixed radius of the pull-off."""
    nearest: float
    """Depth in m above d_off below which rounding of d affects the stiffness."""
    jump_in_loss: float
    """Energy in J lost in the jump into contact."""

    tip: ClassVar = None

    @property
    def added(self) -> tuple[float, float]:
        """Force in N and stiffness in N/m that are added to |F| and |k| for relative errors."""
        return self.force, self.stiffness

    def least(self, knots: Knots) -> float:
        """The least coordinate that is interpolated: the stiffness is unbounded at the first knot."""
        return float(_NEAR_FOLD * knots.u[1])

    def before(self, d: FloatArray, knots: Knots) -> FloatArray:
        """Force, stiffness and radius before the first knot: there is no contact."""
        return np.zeros((3, d.size))

    def checked(self, d: FloatArray, first: float) -> FloatArray:
        """Depths in m at which a law is checked: those between its knots where rounding of d does not matter."""
        return d[d - self.off >= self.nearest]

    def outside(self, first: float, pull_off: PullOff | None) -> str:
        """Text on the law outside a table."""
        assert pull_off is not None
        return (
            "in contact: the surfaces touch at d = 0 and jump to "
            f"F = {pull_off.jump_in_force!r} N, a = {pull_off.jump_in_radius!r} m, and separate at d = {pull_off.indentation!r} m, "
            f"F = {pull_off.normal_force!r} N; the largest pull is {-pull_off.largest_pull!r} N"
        )

    def remark(self, pull_off: PullOff | None) -> str:
        """Short text on the law outside a table."""
        assert pull_off is not None
        return f"lost at d = {metres(pull_off.indentation)}, F = {newtons(pull_off.normal_force)}"

    def relative_to(self) -> dict[str, str]:
        """Text on the reference of relative errors."""
        return {
            "normal_force": f"|F| + {self.force:.6g} N, the largest pull",
            "normal_stiffness": f"|k| + {self.stiffness:.6g} N/m, that at the fixed radius of the pull-off",
        }

    def coordinate(self, d: FloatArray) -> FloatArray:
        """The coordinate u of depths in m."""
        return np.sqrt(np.maximum(d - self.off, 0.0))

    def depth(self, u: FloatArray) -> FloatArray:
        """The depths in m at coordinates u."""
        return self.off + u * u

    def physical(self, knots: Knots) -> tuple[FloatArray, ...]:
        """Depth, force, stiffness, radius and rate of the radius."""
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness, rate = (slope / (2.0 * knots.u) for slope in (knots.y_slope, knots.z_slope))
        return self.off + knots.u * knots.u, knots.y, stiffness, knots.z, rate

    def error(self, ours: Knots, exact: Knots) -> FloatArray:
        """The largest of the errors of F, k and a, relative to |F| + force, |k| + stiffness and a."""
        force = np.abs(ours.y - exact.y) / (np.abs(exact.y) + self.force)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.abs(ours.y_slope - exact.y_slope) / (
                np.abs(exact.y_slope) + 2.0 * exact.u * self.stiffness
            )
        radius = np.abs(ours.z - exact.z) / exact.z
        return np.where(exact.u**2 < self.nearest, 0.0, np.maximum(np.maximum(force, slope), radius))


Form = Tip | Fold


@dataclass(frozen=True)
class Source:
    """The exact law for a table."""

    form: Form
    sample: Sample
    marks: FloatArray
    """Parameters between which it is smooth."""


def source_of(contact: Contact, to: float, tolerance: float) -> Source:
    """
    The law of a contact up to a depth in m.

    Raises
    ------
    ProblemError
        If the law does not have one value at each depth.
    ConvergenceError
        If the law is not a power of the depth at its tip.
    """
    law = contact.adhesion
    if law is None:
        return _from_tip(map_to_line(contact).line, 0.0, to, tolerance)
    followed = AdhesiveLine(contact)
    pull = theory_of(law).pull(law, contact.profile, followed.line)
    if pull is not None:
        return _from_tip(followed.line, pull, to, tolerance)
    return _from_fold(followed, to, tolerance)


def _from_tip(line: Line, pull: float, to: float, tolerance: float) -> Source:
    def sample(u: FloatArray) -> Knots:
        d = np.exp(u)
        states = states_at_depth(line, d)
        pressing, a = normal_force(line, states), states.contact_radius
        inside = a < line.edge
        with np.errstate(divide="ignore"):
            rate = np.where(inside, 1.0 / line.depth_rate(states.place), 0.0)
        power = normal_stiffness(line, states) * d / pressing
        return Knots(u, np.log(pressing), power, np.log(a), rate * d / a)

    first, power, radius_power = _closing(sample, math.log(to), tolerance)
    # contacts of layers are solved one by one: avoid unneeded ones
    least, most = states_at_depth(line, [math.exp(first), to]).contact_radius
    radii = np.array([b for b in (*line.breakpoints, line.edge) if least <= b <= most])
    depths = line.depth(radii)
    inner = depths[(depths > math.exp(first)) & (depths < to)]
    kinks = np.log(inner)
    return Source(
        Tip(power, radius_power, pull),
        sample,
        _marked(sample, (first, math.log(to)), kinks, np.full(kinks.shape, _NEXT_TO_KINK), tolerance),
    )


def _closing(sample: Sample, last: float, tolerance: float) -> tuple[float, float, float]:
    """The coordinate below which the law is a power within a quarter of the tolerance, and the powers of F and a."""
    for decades in _DECADES:
        u = last - math.log(10.0) * np.arange(0.0, decades + 0.125, 0.125)
        tip = sample(u)
        power, radius_power = float(tip.y_slope[-1]), float(tip.z_slope[-1])
        if radius_power < _NO_POWER:
            radius_power = 0.0
        # the errors of straight lines from each depth to all smaller ones
        deviation = np.max(
            [
                _range_below(tip.y - power * u),
                _range_below(tip.z - radius_power * u),
                np.maximum.accumulate(np.abs(tip.y_slope / power - 1.0)[::-1])[::-1],
            ],
            axis=0,
        )
        small = np.flatnonzero(deviation <= 0.25 * tolerance)
        if small.size and u[small[0]] >= u[-1] + _KNOWN * math.log(10.0):
            return float(u[max(small[0], 1)]), power, radius_power
    at = int(np.searchsorted(-u, -(u[-1] + _KNOWN * math.log(10.0))))
    raise ConvergenceError(
        f"the force is not a power of the depth at the tip: below d = {metres(math.exp(u[at]))} it differs from one by "
        f"{deviation[at]:.2g} (limit a quarter of the tolerance of {tolerance:g}); use a larger tolerance"
    )


def _range_below(values: FloatArray) -> FloatArray:
    """The range of the values from each one to the end."""
    back = values[::-1]
    return np.asarray((np.maximum.accumulate(back) - np.minimum.accumulate(back))[::-1])


def _marked(
    sample: Sample, ends: tuple[float, float], kinks: FloatArray, offsets: FloatArray, tolerance: float
) -> FloatArray:
    """Both ends, and a knot on each side of every kink where a slope jumps."""
    left, right = kinks - offsets, kinks + offsets
    before, after = sample(left), sample(right)
    jumps = [
        np.abs(b - a) > tolerance * np.abs(b)
        for a, b in ((before.y_slope, after.y_slope), (before.z_slope, after.z_slope))
    ]
    pairs = np.concatenate([left, right])[np.tile(jumps[0] | jumps[1], 2)]
    return np.unique(np.concatenate([ends, pairs[(pairs > ends[0]) & (pairs < ends[1])]]))


def _from_fold(line: AdhesiveLine, to: float, tolerance: float) -> Source:
    curve = line.equilibria
    assert isinstance(curve, ShortRange)
    track = line.track(math.inf, to)
    press = pressed(track, lambda s: curve.states(s).indentation, to)
    pull = pulled(track, press.branch, press.last)
    for passage, text in ((press, "pressed in"), (pull, "pulled out")):
        if passage.begin.size > 1:
            raise ProblemError(
                f"the contact jumps {passage.begin.size - 1} times while it is {text}, so its force is not a function "
                "of the depth; use solve(...), a smoother profile or a smaller work of adhesion"
            )
    begin, end = pull.last, press.last
    knots = np.array([s for s in curve.knots if begin < s < end])
    off = float(curve.states(np.array([begin])).indentation[0])
    radius = float(curve.states(np.array([begin])).contact_radius[0])
    lowest = float(np.min(curve.states(np.linspace(begin, end, 401)).normal_force))
    stiffness = float(line.line.stiffness(np.array([radius]))[0])
    form = Fold(off, abs(lowest), stiffness, _ROUNDING * abs(off) / tolerance, float(track.jumps[2].loss[0]))
    at_fold = _slopes_at_fold(curve, begin, float(np.min(knots, initial=end)), off)

    def sample(s: FloatArray) -> Knots:
        states = curve.states(s)
        u = form.coordinate(states.indentation)
        force, widening = _slopes(curve, s, u)
        fold = s == begin
        return Knots(
            np.where(fold, 0.0, u),
            states.normal_force,
            np.where(fold, at_fold[0], force),
            states.contact_radius,
            np.where(fold, at_fold[1], widening),
        )

    return Source(form, sample, _marked(sample, (begin, end), knots, _NEXT_TO_KINK * knots, tolerance))


def _slopes(curve: ShortRange, s: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """dF/du and da/du."""
    depth_rate, force_rate = curve.slopes(s)
    with np.errstate(divide="ignore", invalid="ignore"):
        per = 2.0 * u / depth_rate
        return force_rate * per, curve.radius_rate(s) * per


def _slopes_at_fold(curve: ShortRange, begin: float, end: float, off: float) -> tuple[float, float]:
    """
    The slopes at the loss of contact.

    At a smooth fold of d both are 0 over 0; their limits are those of polynomials through adjacent states. At a corner, such as
    a sharp edge, F and a are smooth over d, and therefore flat over its root.
    """
    near = 0.05 * min(begin, end - begin)
    at_once, far = curve.slopes(begin + near * np.array([_NEAR_FOLD, 1.0]))[0]
    if at_once > _CORNER * far:
        return 0.0, 0.0
    best, limits = math.inf, (0.0, 0.0)
    for width in near * _WIDTHS:
        s = begin + width * np.linspace(0.2, 1.0, 8)
        u = np.sqrt(curve.states(s).indentation - off)
        force, radius = _slopes(curve, s, u)
        fine, coarse = (_at_zero(u, force, degree) for degree in (7, 4))
        if abs(fine - coarse) < best:
            best, limits = abs(fine - coarse), (fine, _at_zero(u, radius, 7))
    return limits


def _at_zero(u: FloatArray, values: FloatArray, degree: int) -> float:
    return float(np.polynomial.Polynomial.fit(u / u[-1], values, degree)(0.0))
