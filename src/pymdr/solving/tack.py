"""Pull-off at a speed after a dwell: tests of tack of bodies with memory, and the pull-off of all bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import ConvergenceError, ProblemError, PymdrError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR, MaugisDugdale
from pymdr.problem.materials import Elastic, Rigid
from pymdr.result import Result
from pymdr.solving.edge_work import EdgeWork, edge_work_of
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.memory import relaxation_along
from pymdr.solving.pulloff import PullOff, adhesive, elastic_pull_off, single
from pymdr.solving.retraction import (
    ROWS,
    TackTest,
    dwell_of_test,
    followed_tests,
    speed_of_test,
    stiffness_of_test,
)
from pymdr.solving.study import number
from pymdr.solving.verb import check_tolerance
from pymdr.units import QuantityLike, shown

_TRIES, _NEAREST = 40, 6
_WORK_TOLERANCE = 1e-7
_JUMPS = {
    "dissipated_energy": "jump_dissipation",
    "jump_in_indentation": "indentation",
    "jump_in_force": "normal_force",
    "jump_in_radius": "contact_radius",
}
"""Numbers of the jumps out of contact and into it, and their columns; the law of a small zone has neither jump."""
_ENERGIES = "external_work", "elastic_energy", "surface_energy"
_OF_ENERGIES = "external_work", "jump_dissipation"
"""Columns whose errors are relative to the largest sum of these energies."""
_WITHOUT_JUMPS = (
    "the law of a small zone has no jump: the contact grows from nothing, and its edge recedes at a finite speed until the contact is lost; "
    "use MaugisDugdale(work, range=...)"
)


@dataclass(frozen=True, kw_only=True)
class TackPullOff(PullOff):
    """The pull-off of bodies with memory, at a speed after a dwell."""

    result: Result
    """The whole test: approach, dwell and retraction."""

    largest_pull_indentation = number("largest_pull_indentation", "Indentation in m at the largest pull.")
    largest_pull_radius = number("largest_pull_radius", "Contact radius in m at the largest pull.")
    effective_work = number(
        "effective_work",
        "Work of adhesion in J/m^2 at which the relaxed body without memory has this largest pull: by JKR for JKR, else by the law of Maugis with the same range.",
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

    @property
    def edge(self) -> EdgeWork:
        """Energy release rate of the receding edge over its speed, beside the formula of a short zone."""
        return edge_work_of([self.result], relaxation_along(self.result.contact, self.result.path))

    def _figure(self) -> mpl.figure.Figure:
        rows = self.result.data
        attached = rows["cohesive_radius"].values > 0.0
        curve = {
            name: np.where(attached, rows[name].values, math.nan) for name in ("indentation", "normal_force")
        }
        return plot.pull_off_figure(curve, self.data, label="approach, dwell and retraction")


def pull_off(
    contact: Contact,
    *,
    machine_stiffness: QuantityLike = math.inf,
    pressed_to: QuantityLike | None = None,
    preload: QuantityLike | None = None,
    dwell: QuantityLike | None = None,
    speed: QuantityLike | None = None,
    approach_speed: QuantityLike | None = None,
    tolerance: float | None = None,
) -> PullOff:
    """
    Loss of an adhesive contact in retraction, and its state after the jump into contact.

    Stable states satisfy dD/da > 0 for the travel D = d + F/k of the machine (Popov and Hess 2015, chapter 4). Bodies with memory
    (`Viscoelastic` with `MaugisDugdale`, `Capillary` or `JKR(work, range=)`) are pressed at a speed of D, rest at that D for the dwell, and are retracted at a speed.

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
    tolerance : float, optional
        As for :func:`solve`: the claimed error of forces over the largest one of the test, except beside jumps.

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
    check_tolerance(adhesive(contact), tolerance)
    if not contact.is_viscoelastic:
        for name, value in (("dwell", dwell), ("speed", speed), ("approach_speed", approach_speed)):
            if value is not None:
                raise ProblemError(
                    f"{name} = {value!r}, but the bodies have no memory, and their pull-off does not depend on time; leave it out, "
                    "or give a viscoelastic body"
                )
        return elastic_pull_off(
            contact, machine_stiffness=machine_stiffness, pressed_to=pressed_to, preload=preload
        )
    for name, value in (("speed", speed), ("dwell", dwell)):
        if np.ndim(value) > 0:  # type: ignore[arg-type]
            raise ProblemError(f"{name} = {shown(value)}; give one value, or call pull_off_curve for several")
    stiffness = stiffness_of_test(machine_stiffness)
    if speed is None:
        raise ProblemError(
            "the pull-off of bodies with memory depends on time; give speed=, such as '10 um/s', and dwell="
        )
    v = speed_of_test(speed, "speed")
    test = TackTest(
        speed=v,
        dwell=0.0 if dwell is None else dwell_of_test(dwell),
        approach_speed=v if approach_speed is None else speed_of_test(approach_speed, "approach_speed"),
    )
    return tack_tests(contact, [test], stiffness, (pressed_to, preload), tolerance=tolerance)[0]


def tack_tests(
    contact: Contact,
    tests: Sequence[TackTest],
    stiffness: float,
    start: tuple[QuantityLike | None, QuantityLike | None],
    workers: int = 1,
    tolerance: float | None = None,
) -> list[TackPullOff]:
    """Pull-offs of tests of one contact."""
    results, modulus = followed_tests(contact, tests, stiffness, start, workers, tolerance)
    elastic = ElasticPulls(contact, modulus) if modulus > 0.0 else None
    return [
        _read(contact, elastic, test, stiffness, result) for test, result in zip(tests, results, strict=True)
    ]


def _read(
    contact: Contact, elastic: ElasticPulls | None, test: TackTest, stiffness: float, result: Result
) -> TackPullOff:
    """The numbers of a test."""
    rows = result.data
    attached = rows["cohesive_radius"].values > 0.0
    first, last = int(np.argmax(attached)), int(np.flatnonzero(attached)[-1])
    end = rows.sizes["step"] - 1
    # rows of the value and of its error; the levels separate in different rows
    jumps = {name: (column, first, first) for name, column in _JUMPS.items()}
    jumps["dissipated_energy"] = "jump_dissipation", last + 1, end
    if "jump_dissipation" not in rows:
        jumps = {}
    force = np.where(attached, rows["normal_force"].values, math.inf)
    retracted = np.arange(force.size) >= ROWS
    lowest = int(np.argmin(np.where(retracted, force, math.inf)))

    def at(name: str, row: int) -> float:
        return float(rows[name].values[row])

    error = partial(_error_in, result, retracted)

    def at_loss(name: str) -> float:
        """The error of the last stable state, which lies between two rows."""
        value = at(name, last)
        change = abs((value - at(name, last - 1)) / value) if value != 0.0 else 0.0
        return error(name, last) + change

    # the largest pull is in a row, or beside one, whose force differs from the lowest by less than its error
    alike = np.flatnonzero(retracted & (force <= force[lowest] * (1.0 - error("normal_force", lowest))))
    beside = np.clip([alike[0] - 1, alike[-1] + 1], 0, last)

    def spread(name: str) -> float:
        """The relative error of a value at the largest pull, whose place is known to some rows."""
        off = float(np.max(np.abs(rows[name].values[beside] - at(name, lowest))))
        return error(name, lowest) + (off / max(abs(at(name, lowest)), off) if off > 0.0 else 0.0)

    bend = force[max(lowest - 1, 0)] - 2.0 * force[lowest] + force[min(lowest + 1, last)]
    missed = abs(float(bend / force[lowest]))
    travel = "travel" if "travel" in rows else "indentation"
    pull = at("normal_force", lowest)
    values = {
        **{name: at(name, last) for name in ("normal_force", "indentation", "contact_radius")},
        "travel": at(travel, last),
        **{name: at(column, row) for name, (column, row, _) in jumps.items()},
        "largest_pull": pull,
        "largest_pull_indentation": at("indentation", lowest),
        "largest_pull_radius": at("contact_radius", lowest),
        "external_work": at("external_work", end),
        "preload": at("normal_force", ROWS - 1),
        "dwell": test.dwell,
        "speed": test.speed,
        "machine_stiffness": stiffness,
    }
    errors = {
        **{name: at_loss(name) for name in ("normal_force", "indentation", "contact_radius")},
        "travel": at_loss(travel),
        **{name: error(column, row, own) for name, (column, own, row) in jumps.items()},
        "largest_pull": error("normal_force", lowest) + missed,
        "largest_pull_indentation": spread("indentation"),
        "largest_pull_radius": spread("contact_radius"),
        "external_work": error("external_work", end),
    }
    everywhere = np.ones(1, dtype=bool)
    exact = replace(result.claims["jumped"], where=everywhere, error=None)
    if not contact.is_cohesive:
        exact = replace(exact, reason=f"{exact.reason}; for each value here relative to itself")
    claims = with_errors(
        dict.fromkeys(errors, exact),
        {name: np.array([min(one, 1.0)]) for name, one in errors.items()},
        cause="from twice the spacing of nodes, longer steps and the distance of rows",
    )
    for name in _JUMPS.keys() - jumps.keys():
        values[name] = math.nan
        claims[name] = Claim(Level.NOT_VALID, _WITHOUT_JUMPS, SOURCES["schapery"], ~everywhere)
    values["effective_work"], claims["effective_work"] = _effective_work(
        elastic, pull, errors["largest_pull"]
    )
    return TackPullOff(
        data=single(values),
        claims=claims,
        assumptions=result.assumptions,
        notes=result.notes,
        contact=contact,
        references=result.references,
        result=result,
    )


def _error_in(
    result: Result, retracted: BoolArray, name: str, row: int, value_row: int | None = None
) -> float:
    """
    The relative error of a column in a row, for the value of that row or another one.

    Where it is not measured, beside jumps, that of the last row before in which it is, and the change since.
    """
    rows, errors = result.data, result.claims[name].error
    if errors is None:
        return 0.0
    column = rows[name].values
    size = max(abs(float(column[row if value_row is None else value_row])), 1e-300)
    if name == "jump_dissipation":
        column = np.cumsum(column)
    measured = np.flatnonzero(errors[: row + 1] < 1.0)
    if not measured.size or (retracted[row] and not retracted[measured[-1]]):
        return 1.0
    near = int(measured[-1])
    if not result.contact.is_cohesive:
        scale = float(np.nanmax(np.abs(column)))
    elif name in _OF_ENERGIES:
        energies = [np.nan_to_num(np.abs(rows[one].values[: near + 1])) for one in _ENERGIES]
        scale = float(np.max(np.sum(energies, axis=0)))
    else:
        scale = abs(float(column[near]))
    return (float(errors[near]) * scale + abs(float(column[row] - column[near]))) / size


def _effective_work(elastic: ElasticPulls | None, pull: float, error: float) -> tuple[float, Claim]:
    """Work of adhesion in J/m^2 of a relaxed body with a pull in N of a relative error, and its claim."""
    everywhere, source = np.ones(1, dtype=bool), SOURCES["maugis"]
    try:
        if elastic is None:
            raise ProblemError("the bodies flow at rest, and a relaxed contact does not exist")
        work = elastic.work(pull)
    except PymdrError as why:
        return math.nan, Claim(
            Level.NOT_VALID, f"no elastic contact has this pull: {why}", source, ~everywhere
        )
    reason = (
        "the work of adhesion that a relaxed body without memory would need for this pull; a number for comparison, not a property of the "
        "surfaces"
    )
    # F grows at least like the root of the work
    errors = np.array([min(2.0 * error + _WORK_TOLERANCE, 1.0)])
    return work, Claim(Level.APPROXIMATE, reason, source, everywhere, errors)


def relaxed_contact(contact: Contact, modulus: float, work: float | None = None) -> Contact:
    """The contact without memory, of a modulus in Pa, with JKR, or the law of Maugis with the range of its law, and a work of adhesion in J/m^2."""
    law = contact.adhesion
    assert law is not None
    work = law.work if work is None else work
    own = MaugisDugdale(work, range=law.attraction_range) if contact.is_cohesive else JKR(work)
    return replace(contact, body=Elastic(modulus, 0.0), counterbody=Rigid(), adhesion=own)


@dataclass
class ElasticPulls:
    """
    Pull-off forces of the relaxed body over its work of adhesion.

    Parameters
    ----------
    contact : Contact
        With a cohesive zone, whose range all works have.
    modulus : float
        E* in Pa.
    """

    contact: Contact
    modulus: float
    known: dict[float, float] = field(default_factory=dict)
    """Logarithm of the work in J/m^2 -> logarithm of the pull in N."""

    def logarithm(self, at: float) -> float:
        """Logarithm of the pull in N at a logarithm of the work in J/m^2."""
        if at not in self.known:
            line = AdhesiveLine(relaxed_contact(self.contact, self.modulus, math.exp(at)))
            last = line.equilibria.states(np.array([line.track(0.0, 0.0).pull_off]))
            self.known[at] = math.log(-float(last.normal_force[0]))
        return self.known[at]

    def work(self, pull: float) -> float:
        """
        Work of adhesion in J/m^2 of a lowest force in N, below 0, by inverse interpolation between logarithms.

        Raises
        ------
        PymdrError
            If there is no such elastic contact.
        """
        law = self.contact.adhesion
        assert law is not None
        goal = math.log(-pull)
        self.logarithm(math.log(law.work))
        for _ in range(_TRIES):
            guess, missed = self._interpolated(goal)
            if missed < _WORK_TOLERANCE:
                return math.exp(guess)
            self.logarithm(guess)
        raise ConvergenceError(
            f"the effective work of adhesion did not converge (last {math.exp(guess):.6g} J/m^2); check the magnitudes of the speed and the relaxation times"
        )

    def _interpolated(self, goal: float) -> tuple[float, float]:
        """Logarithm of the work at a logarithm of the pull, by Neville's polynomial through the nearest known ones, and its last change."""
        near = sorted(self.known, key=lambda at: abs(self.known[at] - goal))[:_NEAREST]
        distance = [self.known[at] - goal for at in near]
        if distance[0] == 0.0:
            return near[0], 0.0
        if len(near) == 1:
            # F grows about like the work
            return near[0] - distance[0], math.inf
        row, last = list(near), near[0]
        for order in range(1, len(near)):
            last = row[0]
            row = [
                (distance[i + order] * row[i] - distance[i] * row[i + 1])
                / (distance[i + order] - distance[i])
                for i in range(len(row) - 1)
            ]
        return row[0], abs(row[0] - last)
