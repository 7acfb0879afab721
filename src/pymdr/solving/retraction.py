"""Paths of tests of tack: approach at a speed to a load or depth, dwell, and retraction until the contact is lost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy

from pymdr.errors import ConvergenceError, PathError, ProblemError, PymdrError
from pymdr.line.soft.small_zone import ShortSprings
from pymdr.line.soft.springs import FINE, ZoneSprings
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.materials import Elastic
from pymdr.problem.paths import LoadingPath, Path, hold, indent, load
from pymdr.problem.values import read_stiffness, within_range
from pymdr.result import Result
from pymdr.solving.batch import Request, solutions
from pymdr.solving.memory import powers_of, refuse_rigid, relaxation_along, times_along
from pymdr.solving.pulloff import elastic_pull_off, start_of_retraction
from pymdr.solving.verb import solve
from pymdr.solving.zones import short_springs, with_measured_zone, zone_relaxation, zone_setting
from pymdr.units import FloatArray, QuantityLike, shown, to_si, written

ROWS, _FINE = 240, 48
"""Rows of a leg, and rows between two of them where the pull is largest and where the contact is lost."""
_TOUCH = 1e-7
"""Part of the approach at which the first touch is read; with powers of time, whose series begins at the shortest time of a path, a row."""
_EVEN_TOUCH = 1.0 / (ROWS - 1)
_DOUBLINGS = 40
_MOST_RANGES, _SPARE = 1e10, 8.0
"""Largest travel in a test over the range of the attraction, for which six digits of that range are left; and the stiffness advised over the one that would just do."""
_GROWTH = 30.0
"""Largest growth of the approach over its length so far."""
_BEYOND = 1.05
"""Length of the retraction over that up to the separation."""
_STEEPEST = 10.0
"""Largest slope of the profile in the contact before the retraction, far beyond the small slopes of the model: no row finds a pull beside such loads."""


class TackTest(NamedTuple):
    """Speeds and times of a test in SI units."""

    speed: float
    dwell: float
    approach_speed: float


def stiffness_of_test(machine_stiffness: QuantityLike) -> float:
    """Machine stiffness in N/m of a test; a dead load is refused."""
    stiffness = read_stiffness(machine_stiffness)
    if stiffness == 0.0:
        raise ProblemError(
            "machine_stiffness = 0 N/m: a dead load has no speed; give the stiffness of the machine, or solve(contact, load(...)) with a "
            "rate"
        )
    return stiffness


def speed_of_test(speed: QuantityLike, name: str) -> float:
    """A speed in m/s, checked."""
    v = to_si(speed, "m/s", name=name)
    if not 0.0 < v < math.inf:
        raise ProblemError(f"{name} = {shown(speed)}; a finite speed above 0 m/s is needed")
    within_range(v, "m/s", name, size=True)
    return v


def dwell_of_test(dwell: QuantityLike) -> float:
    """A time at rest in s, checked."""
    time = to_si(dwell, "s", name="dwell")
    if not 0.0 <= time < math.inf:
        raise ProblemError(f"dwell = {shown(dwell)}; a finite time of at least 0 s is needed")
    return time


class _Approach(NamedTuple):
    """The end of an approach."""

    channel: str
    start: float
    """Travel in m at which the attraction begins, or the surfaces touch."""
    top: float
    """Largest travel in m."""
    speed: float
    bare: Contact
    """Without memory and adhesion, of the modulus at first touch."""
    touch: float = _TOUCH

    @property
    def rows(self) -> tuple[FloatArray, FloatArray]:
        """Times in s and travels in m at the speed, up to the largest travel."""
        fraction = np.linspace(0.0, 1.0, ROWS)
        # the jump into contact happens in the first row
        fraction = np.concatenate([[0.0, self.touch], fraction[2:]])
        whole = self.top - self.start
        return whole / self.speed * fraction, self.start + whole * fraction

    @property
    def path(self) -> LoadingPath:
        """The path through these rows."""
        return self.samples(*self.rows)

    def away(self, test: TackTest, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Times in s and travels in m at retracted lengths in m."""
        begin = (self.top - self.start) / self.speed + test.dwell
        return begin + lengths / test.speed, self.top - lengths

    def whole(self, test: TackTest, lengths: FloatArray) -> LoadingPath:
        """Approach, dwell and retraction to lengths in m."""
        path = self.path >> hold(test.dwell) if test.dwell > 0.0 else self.path
        return path >> self.samples(*self.away(test, lengths))

    def samples(self, time: FloatArray, travel: FloatArray) -> LoadingPath:
        """A leg through travels in m at times in s."""
        if self.channel == "travel":
            return Path(time=time, travel=travel)
        return Path(time=time, indentation=travel)


def followed_tests(
    contact: Contact,
    tests: Sequence[TackTest],
    stiffness: float,
    start: tuple[QuantityLike | None, QuantityLike | None],
    workers: int = 1,
    tolerance: float | None = None,
) -> tuple[list[Result], float]:
    """
    Results of tests of one contact, and its relaxed modulus E* in Pa, 0 if it flows at rest.

    Parameters
    ----------
    contact : Contact
        With memory and a cohesive zone.
    tests : sequence of TackTest
        Speeds and dwells.
    stiffness : float
        Of the machine in N/m, above 0.
    start : pair of quantity or None
        Indentation in m and force in N at the end of the approach, one of them given.
    workers : int
        Number of processes.
    tolerance : float or None
        As for :func:`solve`.

    Raises
    ------
    PymdrError
        The first error of a test.
    """
    target = start_of_retraction(*start)
    if target is None:
        raise ProblemError(
            "bodies with memory need the state before the retraction; give preload=, such as '1 mN', or pressed_to="
        )
    quantity = "normal_force" if start[0] is None else "indentation"
    speeds = {test.approach_speed for test in tests}
    approaches = {v: _approach(contact, v, stiffness, quantity, target) for v in speeds}
    machine = None if math.isinf(stiffness) else stiffness
    options = {"tolerance": tolerance}

    def solved(
        which: Sequence[int], lengths: Sequence[FloatArray], touch: float | None = None
    ) -> list[Result | PymdrError]:
        paths = []
        for i, rows in zip(which, lengths, strict=True):
            approach = approaches[tests[i].approach_speed]
            approach = approach if touch is None else approach._replace(touch=touch)
            paths.append(approach.whole(tests[i], rows))
        return list(solutions([Request(contact, path, machine) for path in paths], options, workers))

    modulus = relaxation_along(contact, next(iter(approaches.values())).path).rubbery
    rest = _AtRest(contact, stiffness, modulus == 0.0)
    retreats = [_retreat(rest, approaches[test.approach_speed], test) for test in tests]
    finest = solved(range(len(tests)), [_graded(*one) for one in retreats])
    # rows too close for the resolution of time: evenly spaced ones, with their distance as error
    coarse = [i for i, one in enumerate(finest) if isinstance(one, ConvergenceError)]
    even = solved(coarse, [_even(retreats[i][0]) for i in coarse], touch=_EVEN_TOUCH)
    for i, one in zip(coarse, even, strict=True):
        finest[i] = _with_coarse_rows(_answer(one))
    return [_answer(one) for one in finest], modulus


@dataclass(frozen=True)
class _AtRest:
    """Springs after approaches and dwells, which tests of solids share unless their zones are measured up to the loss of contact."""

    contact: Contact
    stiffness: float
    """Of the machine in N/m."""
    flows: bool
    """Whether the bodies flow at rest: they spread as long as the test lasts."""
    kept: dict[tuple[TackTest, float], ShortSprings | ZoneSprings] = field(default_factory=dict)
    """By test and retracted length in m; both 0 of springs that serve any speed."""

    def springs(self, approach: _Approach, test: TackTest, length: float) -> ShortSprings | ZoneSprings:
        """A copy of the springs for a retraction to a length in m."""
        shared, own = (test._replace(speed=0.0), 0.0), (test, length)
        if shared not in self.kept and own not in self.kept:
            made, is_shared = self._made(approach, test, length)
            self.kept[shared if is_shared else own] = made
        return deepcopy(self.kept[shared if shared in self.kept else own])

    def _made(
        self, approach: _Approach, test: TackTest, length: float
    ) -> tuple[ShortSprings | ZoneSprings, bool]:
        """The springs, and whether they serve any speed and length."""
        end = approach.away(test, np.zeros(1))
        retreat = approach.away(test, _even(length))

        def press(springs: ShortSprings | ZoneSprings) -> dict[str, FloatArray]:
            time, travel = np.hstack([np.stack(approach.rows), np.stack(end)])
            return springs.follow(np.append(time[0], time), np.append(travel[0], travel), self.stiffness)

        def follow(springs: ZoneSprings) -> dict[str, FloatArray]:
            pressed = press(springs)
            time, travel = np.hstack([np.stack(end), np.stack(retreat)])
            retracted = springs.follow(time, travel, self.stiffness)
            return {name: np.append(pressed[name], rows) for name, rows in retracted.items()}

        springs: ShortSprings | ZoneSprings
        is_shared = not self.flows
        if self.contact.is_cohesive:
            span = times_along(approach.whole(test, _even(length))) if self.flows else (0.0, math.inf)
            relaxation = zone_relaxation(self.contact, span)
            targets = {self.stiffness: max(approach.top, 0.0)}
            setting = zone_setting(self.contact, relaxation, targets, span[1])
            measured = with_measured_zone(setting, follow)
            is_shared &= measured is setting
            springs = ZoneSprings(measured, FINE)
        else:
            springs = short_springs(self.contact, relaxation_along(self.contact, approach.path))
        press(springs)
        return springs, is_shared


def _retreat(rest: _AtRest, approach: _Approach, test: TackTest) -> tuple[float, dict[str, FloatArray]]:
    """A length in m in which the contact is lost, and its evenly spaced rows."""
    length, pull = _first_length(rest.contact, approach), 0.0
    end, _ = approach.away(test, np.zeros(1))
    for _ in range(_DOUBLINGS):
        _refuse_soft(rest.contact, approach.bare, rest.stiffness, length, pull)
        time, travel = approach.away(test, _even(length))
        follow = rest.springs(approach, test, length).follow
        rows = follow(np.append(end, time), np.append(approach.top, travel), rest.stiffness)
        if rows["cohesive_radius"][-1] == 0.0:
            return length, rows
        length, pull = 2.0 * length, max(pull, -float(np.min(rows["normal_force"])))
    raise ConvergenceError(
        f"the contact has not been lost after a retraction of {written(length, 'm', 3)}; check the magnitudes of the speeds and relaxation times"
    )


def _refuse_soft(contact: Contact, bare: Contact, stiffness: float, length: float, force: float) -> None:
    """Refuse a machine that travels so far, a length in m under a force in N, that no digit of the range of the attraction is left."""
    law = contact.adhesion
    assert law is not None
    assert law.attraction_range is not None
    ranges = length / law.attraction_range
    if ranges <= _MOST_RANGES:
        return
    travels = (
        f"travels {written(length, 'm', 3)}, {ranges:.2g} times the range of the attraction (limit {_MOST_RANGES:.0e}), so double precision "
        "cannot resolve the contact"
    )
    if math.isinf(stiffness):
        raise ProblemError(f"the test {travels}; press less deep, or give a longer range")
    # so soft a machine loads slowly
    slow = elastic_pull_off(replace(bare, adhesion=JKR(law.work)), machine_stiffness=0.0)
    least = _SPARE * max(force, -slow.largest_pull) / (_MOST_RANGES * law.attraction_range)
    raise ProblemError(
        f"machine_stiffness = {written(stiffness, 'N/m', 3)}: the machine {travels}; give a stiffness of at least {written(least, 'N/m', 2)}, or "
        "solve(contact, load(...)) with a rate for a dead load"
    )


def _refuse_steep(before: Result, quantity: str, target: float) -> None:
    """Refuse a load or depth, in SI units, under which the slope of the profile in the contact is far beyond small."""
    slope = max((one.measure for one in before.assumptions if one.name == "small slope"), default=0.0)
    if slope > _STEEPEST:
        name, unit = ("preload", "N") if quantity == "normal_force" else ("pressed_to", "m")
        raise ProblemError(
            f"{name} = {written(target, unit, 3)}: the slope of the profile at the edge of the contact would be {slope:.3g} (limit {_STEEPEST:g}; "
            f"the model assumes at most 0.3); give a smaller {name}"
        )


def _answer(one: Result | PymdrError) -> Result:
    if isinstance(one, PymdrError):
        raise one
    return one


def _with_coarse_rows(result: Result) -> Result:
    note = "rows refined around the largest pull did not converge: the values are those of evenly spaced rows"
    return replace(result, notes=(*result.notes, note))


def _even(length: float) -> FloatArray:
    return np.linspace(0.0, length, ROWS + 1)[1:]


def _graded(length: float, rows: dict[str, FloatArray]) -> FloatArray:
    """Retracted lengths in m up to the loss of contact, closer about the largest pull and before the loss, by evenly spaced rows."""
    even = _even(length)
    attached = rows["cohesive_radius"] > 0.0
    force = np.where(attached, rows["normal_force"], math.inf)
    lowest, separated = int(np.argmin(force)), int(np.flatnonzero(~attached)[0])

    def at(row: int) -> float:
        return float(even[row]) if row >= 0 else 0.0

    parts = [
        np.linspace(0.0, at(separated), ROWS)[1:],
        np.linspace(at(lowest - 1), at(min(lowest + 1, separated)), _FINE)[1:],
        np.linspace(at(separated - 1), at(separated), _FINE)[1:],
    ]
    lengths = np.unique(np.concatenate(parts))
    # rows that both spacings share
    lengths = lengths[np.diff(lengths, append=math.inf) > 1e-5 * at(separated)]
    # beyond the error of the instant of separation
    return np.append(lengths, _BEYOND * at(separated))


def _first_length(contact: Contact, approach: _Approach) -> float:
    law = contact.adhesion
    assert law is not None
    assert law.attraction_range is not None
    return 2.0 * max(approach.top, 0.0) + 4.0 * law.attraction_range


def _approach(contact: Contact, speed: float, stiffness: float, quantity: str, target: float) -> _Approach:
    """The approach at a speed, up to a value of a quantity."""
    law = contact.adhesion
    if law is None or law.attraction_range is None:
        raise ProblemError(
            "bodies with memory need an adhesion of known range; give MaugisDugdale(work, range=...), Capillary, or JKR(work, range=...)"
        )
    range_ = law.attraction_range
    channel = "indentation" if math.isinf(stiffness) else "travel"
    machine = None if math.isinf(stiffness) else stiffness
    top = target
    relaxation = relaxation_along(contact, Path(time=[0.0, range_ / speed], indentation=[-range_, 0.0]))
    refuse_rigid(relaxation)
    begin = -range_
    if not contact.is_cohesive:
        # the contact begins where the surfaces touch
        short_springs(contact, relaxation)
        begin = 0.0
    bare = Contact(contact.profile, Elastic(relaxation.softest(range_ / speed), 0.0))
    by_force = quantity == "normal_force"
    if by_force or target > 0.0:
        before = solve(bare, load(max(target, law.work * range_)) if by_force else indent(target))
        _refuse_steep(before, quantity, target)
        top = float(before.data["indentation"].values[-1]) if by_force else top
    touch = _EVEN_TOUCH if powers_of(contact) else _TOUCH
    approach = _Approach(channel, begin, top, speed, bare, touch)
    if quantity == channel:
        return approach
    needed = target if by_force else 0.0
    if machine is not None:
        top += needed / machine
        _refuse_soft(contact, bare, stiffness, top, needed)
    for _ in range(_DOUBLINGS):
        pressed = approach._replace(top=top)
        rows = solve(contact, pressed.path, machine_stiffness=machine).data
        values, travel = rows[quantity].values, pressed.rows[1]
        attached = rows["cohesive_radius"].values > 0.0
        reached = np.flatnonzero((values >= target) & attached)
        row = int(reached[0]) if reached.size else ROWS
        if row < ROWS and (row > ROWS // 2 or not attached[row - 1]):
            break
        if row < ROWS:
            top = float(travel[row + 1])
            continue
        rise = (values[-1] - values[-2]) / (travel[-1] - travel[-2])
        missing = (target - values[-1]) / rise if attached[-2] and rise > 0.0 else 0.0
        whole = top - approach.start
        top += min(max(0.5 * whole, 1.1 * float(missing)), _GROWTH * whole)
        _refuse_soft(contact, bare, stiffness, top, needed)
    else:
        raise PathError(
            f"the {quantity.replace('_', ' ')} in approach does not reach {target:g} (largest {float(np.nanmax(values)):.3g})"
        )
    if row == 0 or not attached[row - 1]:
        raise ProblemError(
            f"{quantity.replace('_', ' ')} = {target:g} is passed at first touch, where the contact jumps to {values[row]:.3g}; give a larger value"
        )
    first = max(row - 4, 0)
    part = slice(first, row + 4)
    smooth = scipy.interpolate.PchipInterpolator(travel[part], values[part])
    exact = scipy.optimize.brentq(lambda x: smooth(x) - target, travel[row - 1], travel[row])
    return approach._replace(top=float(exact))
