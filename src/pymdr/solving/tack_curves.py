"""Pull-off of bodies with memory over speeds and dwells."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, TypedDict, Unpack

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.mapping.relaxation import Relaxation
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.options import with_options
from pymdr.result import Result
from pymdr.solving.edge_work import EdgeWork, edge_work_of
from pymdr.solving.memory import powers_of, relaxation_along
from pymdr.solving.pulloff import adhesive, elastic_pull_off, unit_of
from pymdr.solving.retraction import TackTest, dwell_of_test, speed_of_test, stiffness_of_test
from pymdr.solving.study import Column, Study, dataset
from pymdr.solving.tack import TackPullOff, pull_off, relaxed_contact, tack_tests
from pymdr.solving.verb import check_tolerance
from pymdr.solving.workers import Workers
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si_array, written

_NAMES = (
    "largest_pull",
    "largest_pull_indentation",
    "largest_pull_radius",
    "effective_work",
    "external_work",
    "normal_force",
    "indentation",
    "contact_radius",
    "preload",
)
_LEVELS = (Level.EXACT, Level.APPROXIMATE, Level.NOT_VALID)
_AT_ONCE = 1e-3
"""Duration of the fastest retraction over the shortest time of relaxation, which bounds the relative relaxation of the body in it."""
_LABELS = {
    "largest_pull": "largest pull",
    "largest_pull_indentation": "its indentation",
    "largest_pull_radius": "its radius",
    "effective_work": "effective work",
    "external_work": "work of the test",
}


class TackOptions(TypedDict, total=False):
    """Options of :func:`pull_off` that apply to every test."""

    machine_stiffness: QuantityLike
    pressed_to: QuantityLike | None
    preload: QuantityLike | None
    approach_speed: QuantityLike | None
    tolerance: float | None


@dataclass(frozen=True, kw_only=True)
class PullOffCurve(Study):
    """Pull-off over the speed of the retraction and the dwell."""

    data: xr.Dataset
    """
    Over ``speed`` (m/s) and ``dwell`` (s): largest_pull (N), largest_pull_indentation and largest_pull_radius (m), effective_work
    (J/m^2), external_work (J), and the last stable state; ``slow_limit`` (N) of the relaxed body, and ``fast_limit`` (N) over ``dwell``.
    """
    results: tuple[Result, ...]
    """The whole tests, over speeds and within these over dwells."""
    subject: ClassVar = "a curve of pull-off"
    columns: ClassVar[Mapping[str, Column]] = {
        "speed": Column("speed", "m/s"),
        "dwell": Column("dwell", "s"),
        **{name: Column(label, unit_of(name)) for name, label in _LABELS.items()},
    }
    summary_claims: ClassVar = ("largest_pull", "effective_work", "external_work")

    @property
    def edge(self) -> EdgeWork:
        """Energy release rate of the receding edge over its speed in all tests, beside the formula of a short zone."""
        first = self.results[0]
        return edge_work_of(self.results, relaxation_along(first.contact, first.path))

    def groups(self) -> dict[str, dict[str, float]]:
        """The limits of the largest pull."""
        if not self.claims["slow_limit"].readable:
            return {}
        return {"relaxed body, any speed": {"normal_force": float(self.data["slow_limit"])}}

    def _figure(self) -> mpl.figure.Figure:
        rest = self.data.sizes["dwell"]
        return plot.pull_off_speeds(self.data, [one.data for one in self.results[rest - 1 :: rest]])


@with_options(TackOptions, pull_off)
def pull_off_curve(
    contact: Contact,
    *,
    speed: ArrayQuantityLike,
    dwell: ArrayQuantityLike = 0.0,
    workers: Workers = 1,
    **options: Unpack[TackOptions],
) -> PullOffCurve:
    """
    Pull-off of bodies with memory at all combinations of speeds and dwells, with its slow and fast limits.

    The slow limit is the pull-off of the relaxed body, if it does not flow at rest; the fast one that of a retraction within 1e-3 of the shortest relaxation time
    after the same approach and dwell, to which the body responds with its instantaneous modulus; a PowerLawRheology has none.

    Parameters
    ----------
    contact : Contact
        `Viscoelastic` bodies with `MaugisDugdale`, `Capillary` or `JKR(work, range=)`.
    speed : array_like or quantity
        Speeds of the machine in retraction in m/s, above 0.
    dwell : array_like or quantity
        Times in s at rest before the retraction, at least 0.
    workers : int or dask.distributed.Client
        Number of processes, or the client of a cluster.
    machine_stiffness, pressed_to, preload : quantity, optional
        As for :func:`pull_off`; one of `pressed_to` and `preload` is needed.
    approach_speed : quantity, optional
        Speed in approach in m/s, the same for all; by default the lowest of the speeds.
    tolerance : float, optional
        As for :func:`pull_off`.

    Returns
    -------
    PullOffCurve
        Over ``speed`` and ``dwell``.

    Raises
    ------
    ProblemError
        If the bodies have no memory, or as :func:`pull_off` does.

    See Also
    --------
    pull_off : one test, with its whole path.

    References
    ----------
    Haiat and Barthel (2003), J. Colloid Interface Sci. 264, 94-99.

    Examples
    --------
    >>> import pymdr as mdr
    >>> silicone = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
    >>> probe = mdr.Contact(mdr.Paraboloid("1 mm"), silicone, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="20 um"))
    >>> curve = mdr.pull_off_curve(probe, speed=["1 um/s", "1 mm/s"], dwell="5 s", preload="0.2 mN", approach_speed="10 um/s")
    >>> slow, fast = curve["largest_pull"].values[:, 0]
    >>> bool(float(curve["slow_limit"]) > slow > fast > float(curve["fast_limit"][0]))
    True
    """
    adhesive(contact)
    if not contact.is_viscoelastic:
        raise ProblemError(
            "the bodies have no memory, and their pull-off does not depend on time; call pull_off, or give a viscoelastic body"
        )
    tolerance = options.get("tolerance")
    check_tolerance(contact, tolerance)
    v = _several(speed, "m/s", "speed")
    times = _several(dwell, "s", "dwell")
    for one in v:
        speed_of_test(one, "speed")
    for one in times:
        dwell_of_test(one)
    stiffness = stiffness_of_test(options.get("machine_stiffness", math.inf))
    given = options.get("approach_speed")
    approach = float(v.min()) if given is None else speed_of_test(given, "approach_speed")
    start = options.get("pressed_to"), options.get("preload")
    tests = [TackTest(float(one), float(time), approach) for one in v for time in times]
    followed = partial(
        tack_tests, contact, stiffness=stiffness, start=start, workers=workers, tolerance=tolerance
    )
    answers = followed(tests)
    relaxation = relaxation_along(contact, answers[0].result.path)
    fast, of_fast = _fast_limit(answers, relaxation, tests[: times.size], followed)
    slow, of_slow = _slow_limit(contact, relaxation, stiffness)
    data = _over_both(answers, (v, times), slow, fast)
    claims = {
        name: _claim([one.claims[name] for one in answers]) for name in _NAMES if name in answers[0].claims
    }
    claims["slow_limit"] = of_slow
    claims["fast_limit"] = of_fast
    widest = max(answers, key=lambda one: max((each.measure for each in one.assumptions), default=0.0))
    return PullOffCurve(
        data=data,
        results=tuple(one.result for one in answers),
        claims=claims,
        assumptions=widest.assumptions,
        notes=(f"every test begins with the same approach at {written(approach, 'm/s')}",),
        contact=contact,
        references=answers[0].references,
    )


def _fast_limit(
    answers: list[TackPullOff],
    relaxation: Relaxation,
    tests: list[TackTest],
    followed: Callable[[list[TackTest]], list[TackPullOff]],
) -> tuple[list[float], Claim]:
    """The largest pulls in N of tests that are repeated so fast that the bodies do not relax in the retraction, and their claim."""
    assert answers[0].contact is not None
    if powers_of(answers[0].contact):
        why = "a power of time has no shortest relaxation time"
        return [math.nan] * len(tests), _no_limit(why, len(tests))
    length = max(
        abs(one.travel) + abs(float(one.result.data["indentation"].max())) + one.largest_pull_radius
        for one in answers
    )
    speed = max(length / (_AT_ONCE * float(relaxation.times.min())), *(one.speed for one in answers))
    fast = followed([test._replace(speed=speed) for test in tests])
    return [one.largest_pull for one in fast], _claim([one.claims["largest_pull"] for one in fast], _AT_ONCE)


def _slow_limit(contact: Contact, relaxation: Relaxation, stiffness: float) -> tuple[float, Claim]:
    """The largest pull in N of the relaxed body under a machine stiffness in N/m, and its claim."""
    if relaxation.rubbery > 0.0:
        slow = elastic_pull_off(relaxed_contact(contact, relaxation.rubbery), machine_stiffness=stiffness)
        return slow.largest_pull, slow.claims["largest_pull"]
    return math.nan, _no_limit("the bodies flow at rest: a relaxed contact does not exist", 1)


def _no_limit(reason: str, count: int) -> Claim:
    return Claim(Level.NOT_VALID, reason, SOURCES["haiat-barthel"], np.zeros(count, dtype=bool))


def _several(values: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    """One row of values in SI units."""
    numbers = np.atleast_1d(to_si_array(values, unit, name=name))
    if numbers.ndim != 1 or numbers.size == 0:
        raise ProblemError(f"{name} = {shown(values)}; one row of values is needed")
    return numbers


def _over_both(
    answers: list[TackPullOff], axes: tuple[FloatArray, FloatArray], slow: float, fast: list[float]
) -> xr.Dataset:
    """The numbers of all tests over speed in m/s and dwell in s, and the limits in N."""
    v, times = axes
    shape = (v.size, times.size)
    return dataset(
        {name: (("speed", "dwell"), _grid(answers, name, shape), {"units": unit_of(name)}) for name in _NAMES}
        | {
            "slow_limit": ((), slow, {"units": "N"}),
            "fast_limit": ("dwell", fast, {"units": "N"}),
        },
        coords={
            "speed": ("speed", v, {"units": "m/s", "long_name": "speed of the retraction"}),
            "dwell": ("dwell", times, {"units": "s", "long_name": "time at rest before the retraction"}),
        },
    )


def _grid(answers: list[TackPullOff], name: str, shape: tuple[int, int]) -> FloatArray:
    return np.array([float(one.data[name]) for one in answers]).reshape(shape)


def _claim(each: list[Claim], added: float = 0.0) -> Claim:
    """One claim for all tests: the weakest, with the error of every one and an added one."""
    readable = np.array([one.readable for one in each])
    weakest = max(
        (one for one in each if one.readable), key=lambda one: _LEVELS.index(one.level), default=each[0]
    )
    errors = np.array([0.0 if one.error is None or not one.readable else float(one.error[0]) for one in each])
    return Claim(weakest.level, weakest.reason, weakest.source, readable, errors + added)
