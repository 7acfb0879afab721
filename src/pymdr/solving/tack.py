"""Pull-off at a speed after a dwell: tests of tack of bodies with memory, and the pull-off of all bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from pymdr.errors import ConvergenceError, PathError, ProblemError, PymdrError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.problem.contact import Contact
from pymdr.problem.laws import MaugisDugdale
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.paths import LoadingPath, Path, hold, load
from pymdr.problem.values import within_range
from pymdr.result import Result
from pymdr.solving.batch import Request, solutions
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.memory import relaxation_along
from pymdr.solving.pulloff import PullOff, adhesive, elastic_pull_off, single, start_of_retraction
from pymdr.solving.study import number
from pymdr.solving.verb import read_stiffness, solve
from pymdr.units import FloatArray, QuantityLike, to_si, written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROWS, _FINE = 240, 48
"""Rows of a leg, and rows between two of them where the pull is largest and where the contact is lost."""
_TOUCH = 1e-7
"""Part of the approach at which the first touch is read."""
_DOUBLINGS = 30
_TRIES = 40
_WORK_TOLERANCE = 1e-8


class TackTest(NamedTuple):
    """Speeds and times of a test in SI units."""

    speed: float
    dwell: float
    approach_speed: float


@dataclass(frozen=True, kw_only=True)
class TackPullOff(PullOff):
    """The pull-off of bodies with memory, at a speed after a dwell."""

    result: Result
    """The whole test: approach, dwell and retraction."""

    largest_pull_indentation = number("largest_pull_indentation", "Indentation in m at the largest pull.")
    largest_pull_radius = number("largest_pull_radius", "Contact radius in m at the largest pull.")
    effective_work = number(
        "effective_work",
        "Work of adhesion in J/m^2 at which the relaxed body without memory has this largest pull, by the law of Maugis with the same range.",
    )
    external_work = number("external_work", "Work of the whole test in J.")
    preload = number("preload", "Force in N at the end of the approach.")
    dwell = number("dwell", "In s.")
    speed = number("speed", "Speed of the machine in retraction in m/s.")

    def groups(self) -> dict[str, dict[str, float]]:
        """The numbers under headings."""
        whole = ("effective_work", "external_work", "preload", "dwell", "speed")
        return {
            **super().groups(),
            "largest pull before": {
                "normal_force": self.largest_pull,
                "indentation": self.largest_pull_indentation,
                "contact_radius": self.largest_pull_radius,
            },
            "test": {name: float(self.data[name]) for name in whole},
        }

    def _figure(self) -> Figure:
        from pymdr.presentation.plot import pull_off_figure

        rows = self.result.data
        attached = rows["cohesive_radius"].values > 0.0
        curve = {
            name: np.where(attached, rows[name].values, math.nan) for name in ("indentation", "normal_force")
        }
        return pull_off_figure(curve, self.data, label="approach, dwell and retraction")


def pull_off(
    contact: Contact,
    *,
    machine_stiffness: QuantityLike = math.inf,
    pressed_to: QuantityLike | None = None,
    preload: QuantityLike | None = None,
    dwell: QuantityLike | None = None,
    speed: QuantityLike | None = None,
    approach_speed: QuantityLike | None = None,
) -> PullOff:
    """
    Loss of an adhesive contact in retraction, and its state after the jump into contact.

    Stable states satisfy dD/da > 0 for the travel D = d + F/k of the machine (Popov and Hess 2015, chapter 4). Bodies with memory
    (`Viscoelastic` with `MaugisDugdale` or `Capillary`) are pressed at a speed of D, rest at that D for the dwell, and are retracted at a speed.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.
    machine_stiffness : quantity, optional
        k in N/m: inf (the default) is displacement control, 0 a dead load, which only bodies without memory take.
    pressed_to : quantity, optional
        Indentation in m before the retraction, for wavy profiles and hysteresis of adhesion (JKR with work_receding), whose
        pull-off depends on it; by default that of the unloaded contact. Bodies with memory need it or a preload.
    preload : quantity, optional
        Normal force in N at the end of the approach, at least 0, in place of `pressed_to`.
    dwell : quantity, optional
        Time in s at rest before the retraction; 0 by default. Only for bodies with memory.
    speed : quantity, optional
        Speed of the machine in retraction in m/s, above 0. Only bodies with memory take it, and they need it.
    approach_speed : quantity, optional
        Speed in approach in m/s; that of the retraction by default.

    Returns
    -------
    PullOff
        Radius (m), indentation (m) and force (N) of the last stable state, the dissipated energy (J) and the state
        afterwards; for bodies with memory a TackPullOff, with the effective work of adhesion (J/m^2), the work of the test (J) and
        the result of the whole path.

    Raises
    ------
    ProblemError
        If the contact has no adhesion, a value is outside its limits, a speed or a dwell is given for bodies without memory, or bodies
        with memory have none.
    PathError
        If the profile ends before the state at the start of the retraction, or the force in approach does not reach the preload.

    See Also
    --------
    pull_off_curve : over speeds and dwells.
    adhesion_regime : which law is valid.
    solve : the whole curve.

    References
    ----------
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.
    - Haiat and Barthel (2003), J. Colloid Interface Sci. 264, 94-99.

    Examples
    --------
    >>> import math
    >>> import pymdr as mdr
    >>> gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    >>> round(mdr.pull_off(gel, machine_stiffness=0).normal_force / (math.pi * 5e-5), 12)
    -1.5
    """
    adhesive(contact)
    if not contact.is_viscoelastic:
        for name, value in (("dwell", dwell), ("speed", speed), ("approach_speed", approach_speed)):
            if value is not None:
                raise ProblemError(
                    f"pull_off: {name} = {value!r}, but the bodies have no memory, and their pull-off does not depend on time; leave it out, "
                    "or give a Viscoelastic body"
                )
        return elastic_pull_off(
            contact, machine_stiffness=machine_stiffness, pressed_to=pressed_to, preload=preload
        )
    stiffness = stiffness_of_test(machine_stiffness)
    if speed is None:
        raise ProblemError(
            "pull_off: the pull-off of bodies with memory depends on time; give speed=, such as '10 um/s', and dwell="
        )
    v = speed_of_test(speed, "speed")
    test = TackTest(
        speed=v,
        dwell=0.0 if dwell is None else dwell_of_test(dwell),
        approach_speed=v if approach_speed is None else speed_of_test(approach_speed, "approach_speed"),
    )
    return tack_tests(contact, [test], stiffness, (pressed_to, preload))[0]


def stiffness_of_test(machine_stiffness: QuantityLike) -> float:
    """Machine stiffness in N/m of a test; a dead load is refused."""
    stiffness = read_stiffness(machine_stiffness)
    if stiffness == 0.0:
        raise ProblemError(
            "pull_off: machine_stiffness = 0 N/m: a dead load has no speed; give the stiffness of the machine, or solve(contact, load(...)) with a "
            "rate"
        )
    return stiffness


def speed_of_test(speed: QuantityLike, name: str) -> float:
    """A speed in m/s, checked."""
    v = to_si(speed, "m/s", name=name)
    if not 0.0 < v < math.inf:
        raise ProblemError(f"pull_off: {name} = {speed!r}; a finite speed above 0 m/s is needed")
    within_range(v, "m/s", f"pull_off: {name}", size=True)
    return v


def dwell_of_test(dwell: QuantityLike) -> float:
    """A time at rest in s, checked."""
    time = to_si(dwell, "s", name="dwell")
    if not 0.0 <= time < math.inf:
        raise ProblemError(f"pull_off: dwell = {dwell!r}; a finite time of at least 0 s is needed")
    return time


class _Approach(NamedTuple):
    """The end of an approach."""

    channel: str
    start: float
    """Travel in m at which the attraction begins."""
    top: float
    """Largest travel in m."""
    speed: float

    @property
    def path(self) -> LoadingPath:
        """The path at the speed, up to the largest travel."""
        return self.up_to(self.top)

    def up_to(self, top: float) -> LoadingPath:
        """The path up to a travel in m."""
        fraction = np.linspace(0.0, 1.0, _ROWS)
        # the jump into contact happens in the first row
        fraction = np.concatenate([[0.0, _TOUCH], fraction[2:]])
        travel = self.start + (top - self.start) * fraction
        return Path(time=(top - self.start) / self.speed * fraction, **{self.channel: travel})


def tack_tests(
    contact: Contact,
    tests: Sequence[TackTest],
    stiffness: float,
    start: tuple[QuantityLike | None, QuantityLike | None],
    workers: int = 1,
) -> list[TackPullOff]:
    """
    Tests of one contact.

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

    Raises
    ------
    PymdrError
        The first error of a test.
    """
    target = start_of_retraction(*start)
    if target is None:
        raise ProblemError(
            "pull_off: bodies with memory need the state before the retraction; give preload=, such as '1 mN', or pressed_to="
        )
    quantity = "normal_force" if start[0] is None else "indentation"
    speeds = {test.approach_speed for test in tests}
    approaches = {v: _approach(contact, v, stiffness, quantity, target) for v in speeds}
    machine = None if math.isinf(stiffness) else stiffness

    def solved(which: Sequence[int], retractions: Sequence[LoadingPath]) -> list[Result]:
        requests = []
        for i, away in zip(which, retractions, strict=True):
            path = approaches[tests[i].approach_speed].path
            path = path >> hold(tests[i].dwell) if tests[i].dwell > 0.0 else path
            requests.append(Request(contact, path >> away, machine))
        return [_answer(one) for one in solutions(requests, {}, workers)]

    def begin(i: int) -> tuple[float, float]:
        approach = approaches[tests[i].approach_speed]
        return approach.top, (approach.top - approach.start) / approach.speed + tests[i].dwell

    def away(i: int, lengths: FloatArray) -> LoadingPath:
        approach, (top, time) = approaches[tests[i].approach_speed], begin(i)
        return Path(time=time + lengths / tests[i].speed, **{approach.channel: top - lengths})

    relaxation = relaxation_along(contact, next(iter(approaches.values())).path)
    lengths = {i: _first_length(contact, approaches[tests[i].approach_speed]) for i in range(len(tests))}
    rough: dict[int, Result] = {}
    for _ in range(_DOUBLINGS):
        missing = [i for i in range(len(tests)) if i not in rough]
        each = [away(i, _even(lengths[i])) for i in missing]
        for i, result in zip(missing, solved(missing, each), strict=True):
            if float(result.data["cohesive_radius"].values[-1]) == 0.0:
                rough[i] = result
            else:
                lengths[i] *= 2.0
        if len(rough) == len(tests):
            break
    else:
        raise ConvergenceError(
            f"pull_off: the contact has not been lost after a retraction of {written(max(lengths.values()), 'm', 3)}"
        )
    finer = [away(i, _graded(rough[i], lengths[i])) for i in range(len(tests))]
    results = solved(range(len(tests)), finer)
    return [
        _read(contact, relaxation.rubbery, test, stiffness, result)
        for test, result in zip(tests, results, strict=True)
    ]


def _answer(one: Result | PymdrError) -> Result:
    if isinstance(one, PymdrError):
        raise one
    return one


def _even(length: float) -> FloatArray:
    return np.linspace(0.0, length, _ROWS + 1)[1:]


def _graded(result: Result, length: float) -> FloatArray:
    """Retracted lengths in m up to the loss of contact, closer about the largest pull and before the loss."""
    even = _even(length)
    attached = result.data["cohesive_radius"].values[-_ROWS:] > 0.0
    force = np.where(attached, result.data["normal_force"].values[-_ROWS:], math.inf)
    lowest, lost = int(np.argmin(force)), int(np.flatnonzero(~attached)[0])

    def at(row: int) -> float:
        return float(even[row]) if row >= 0 else 0.0

    parts = [
        np.linspace(0.0, at(lost), _ROWS)[1:],
        np.linspace(at(lowest - 1), at(min(lowest + 1, lost)), _FINE)[1:],
        np.linspace(at(lost - 1), at(lost), _FINE)[1:],
    ]
    rows = np.unique(np.concatenate(parts))
    # rows that rounding has doubled
    return rows[np.diff(rows, append=math.inf) > 1e-9 * at(lost)]


def _first_length(contact: Contact, approach: _Approach) -> float:
    law = contact.adhesion
    assert law is not None
    assert law.cohesive_stress is not None
    return 2.0 * max(approach.top, 0.0) + 4.0 * law.work / law.cohesive_stress


def _approach(contact: Contact, speed: float, stiffness: float, quantity: str, target: float) -> _Approach:
    """The approach at a speed, up to a value of a quantity."""
    law = contact.adhesion
    if law is None or law.cohesive_stress is None:
        raise ProblemError(
            "pull_off: adhesion of bodies with memory needs a range; give MaugisDugdale(work, range=...) or Capillary"
        )
    reach = law.work / law.cohesive_stress
    channel = "indentation" if math.isinf(stiffness) else "travel"
    machine = None if math.isinf(stiffness) else stiffness
    top = target
    if quantity == "normal_force":
        span = Path(time=[0.0, reach / speed], indentation=[-reach, 0.0])
        modulus = relaxation_along(contact, span).rubbery
        if not modulus > 0.0:
            raise ProblemError(
                "pull_off: the body flows at rest, and its contact with adhesion has no limit; use StandardSolid, or Prony with an "
                "equilibrium modulus"
            )
        bare = Contact(contact.profile, Elastic(modulus, 0.0))
        top = float(solve(bare, load(max(target, law.work * reach))).data["indentation"].values[-1])
    approach = _Approach(channel, -reach, top, speed)
    if quantity == channel:
        return approach
    if machine is not None:
        top += max(target if quantity == "normal_force" else 0.0, 0.0) / machine
    for _ in range(_DOUBLINGS):
        rows = solve(contact, approach.up_to(top), machine_stiffness=machine).data
        values, travel = rows[quantity].values, rows[channel].values
        reached = np.flatnonzero((values >= target) & (rows["cohesive_radius"].values > 0.0))
        if reached.size:
            break
        top = approach.start + 1.5 * (top - approach.start)
    else:
        raise PathError(
            f"pull_off: the {quantity.replace('_', ' ')} in approach does not reach {target:g} (largest {float(np.nanmax(values)):.3g})"
        )
    row = int(reached[0])
    if row == 0:
        raise ProblemError(
            f"pull_off: {quantity.replace('_', ' ')} = {target:g} is that at first touch; give a larger value"
        )
    first = max(row - 4, 0)
    part = slice(first, row + 4)
    smooth = scipy.interpolate.PchipInterpolator(travel[part], values[part])
    exact = scipy.optimize.brentq(lambda x: smooth(x) - target, travel[row - 1], travel[row])
    return approach._replace(top=float(exact))


def _read(
    contact: Contact, modulus: float, test: TackTest, stiffness: float, result: Result
) -> TackPullOff:
    """The numbers of a test."""
    rows = result.data
    attached = rows["cohesive_radius"].values > 0.0
    first, last = int(np.argmax(attached)), int(np.flatnonzero(attached)[-1])
    force = np.where(attached, rows["normal_force"].values, math.inf)
    retracted = np.arange(force.size) >= _ROWS
    lowest = int(np.argmin(np.where(retracted, force, math.inf)))

    def at(name: str, row: int) -> float:
        return float(rows[name].values[row])

    def error(name: str, row: int) -> float:
        errors = result.claims[name].error
        return 0.0 if errors is None else float(errors[row])

    def between(name: str) -> float:
        """The change over the last two attached rows, relative to the value."""
        value = at(name, last)
        return abs((value - at(name, last - 1)) / value) if value != 0.0 else 0.0

    travel = "travel" if "travel" in rows else "indentation"
    pull = at("normal_force", lowest)
    values = {
        **{name: at(name, last) for name in ("normal_force", "indentation", "contact_radius")},
        "travel": at(travel, last),
        "dissipated_energy": at("jump_dissipation", last + 1),
        "jump_in_indentation": at("indentation", first),
        "jump_in_force": at("normal_force", first),
        "jump_in_radius": at("contact_radius", first),
        "largest_pull": pull,
        "largest_pull_indentation": at("indentation", lowest),
        "largest_pull_radius": at("contact_radius", lowest),
        "external_work": at("external_work", rows.sizes["step"] - 1),
        "preload": at("normal_force", _ROWS - 1),
        "dwell": test.dwell,
        "speed": test.speed,
        "machine_stiffness": stiffness,
    }
    errors = {
        **{
            name: error(name, last) + between(name)
            for name in ("normal_force", "indentation", "contact_radius")
        },
        "travel": error(travel, last) + between(travel),
        "dissipated_energy": error("jump_dissipation", last + 1),
        "jump_in_indentation": error("indentation", first),
        "jump_in_force": error("normal_force", first),
        "jump_in_radius": error("contact_radius", first),
        "largest_pull": error("normal_force", lowest),
        "largest_pull_indentation": error("indentation", lowest),
        "largest_pull_radius": error("contact_radius", lowest),
        "external_work": error("external_work", rows.sizes["step"] - 1),
    }
    everywhere = np.ones(1, dtype=bool)
    exact = replace(result.claims["jumped"], where=everywhere, error=None)
    claims = with_errors(
        dict.fromkeys(errors, exact),
        {name: np.array([min(one, 1.0)]) for name, one in errors.items()},
        cause="from twice the spacing of nodes, longer steps and the distance of rows",
    )
    try:
        values["effective_work"] = effective_work(contact, modulus, pull)
        claims["effective_work"] = Claim(
            Level.APPROXIMATE,
            "the work of adhesion that a relaxed body without memory would need for this pull; a number for comparison, not a property of the "
            "surfaces",
            SOURCES["maugis"],
            everywhere,
            # F grows at least like the root of the work
            np.array([min(2.0 * errors["largest_pull"] + _WORK_TOLERANCE, 1.0)]),
        )
    except PymdrError as why:
        values["effective_work"] = math.nan
        claims["effective_work"] = Claim(
            Level.NOT_VALID, f"no elastic contact has this pull: {why}", SOURCES["maugis"], ~everywhere
        )
    return TackPullOff(
        data=single(values),
        claims=claims,
        assumptions=result.assumptions,
        notes=result.notes,
        contact=contact,
        references=("popov-hess", "haiat-barthel", "maugis"),
        result=result,
    )


def relaxed_contact(contact: Contact, modulus: float, work: float | None = None) -> Contact:
    """The contact without memory, of a modulus in Pa, with the range of its law and a work of adhesion in J/m^2."""
    law = contact.adhesion
    assert law is not None
    assert law.cohesive_stress is not None
    own = MaugisDugdale(law.work if work is None else work, range=law.work / law.cohesive_stress)
    return replace(contact, body=Elastic(modulus, 0.0), counterbody=Rigid(), adhesion=own)


def effective_work(contact: Contact, modulus: float, pull: float) -> float:
    """
    Work of adhesion in J/m^2 at which an elastic contact of the same range has a largest pull.

    Parameters
    ----------
    contact : Contact
        With a cohesive zone.
    modulus : float
        E* in Pa.
    pull : float
        Lowest force in N, below 0.

    Raises
    ------
    PymdrError
        If there is no such elastic contact.
    """
    law = contact.adhesion
    assert law is not None
    goal, low, high = math.log(-pull), -math.inf, math.inf
    at, before = math.log(law.work), None
    for _ in range(_TRIES):
        line = AdhesiveLine(relaxed_contact(contact, modulus, math.exp(at)))
        last = line.equilibria.states(np.array([line.track(0.0, 0.0).pull_off]))
        excess = math.log(-float(last.normal_force[0])) - goal
        low, high = (at, high) if excess < 0.0 else (low, at)
        if abs(excess) < _WORK_TOLERANCE:
            return math.exp(at)
        slope = 1.0 if before is None or at == before[0] else (excess - before[1]) / (at - before[0])
        before = at, excess
        new = at - excess / slope if slope > 0.1 else math.nan
        if not low < new < high:
            new = 0.5 * (low + high) if math.isfinite(low + high) else at - excess
        at = new
    raise ConvergenceError(f"the effective work of adhesion did not converge (last {math.exp(at):.6g} J/m^2)")
