"""From a law of adhesion to its curve of equilibrium states, made far enough for what is asked of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.branches import Equilibria, equilibria_of
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import MaugisDugdale as Cohesive
from pymdr.line.adhesion import jkr_opening
from pymdr.line.following import Track, parameter_reaching, trace, under_machine
from pymdr.line.foundation import ElasticLine
from pymdr.mapping.equivalent import (
    EquivalentProfile,
    NumericLine,
    PowerLine,
    ProxyLine,
    SumLine,
    gap_function,
)
from pymdr.mapping.equivalent.samples import Samples
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT, AdhesionLaw, MaugisDugdale
from pymdr.problem.profiles import Profile, Sphere
from pymdr.solving.reach import Mapped, made_fast, map_to_line
from pymdr.units import FloatArray, metres, written

_GROWTH, _BEYOND, _TRIES = 1.5, 1.2, 60


@dataclass
class AdhesiveLine:
    """
    A contact with adhesion on the line: its curve, grown when a path asks for more of it.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.
    """

    contact: Contact
    origin: Mapped = field(init=False)
    line: ElasticLine = field(init=False)
    equilibria: Equilibria = field(init=False)
    _tracks: dict[float, tuple[float, Track]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.origin = map_to_line(self.contact)
        _refuse_endless(self.origin.line.equivalent)
        self._map(self._first_top())
        _refuse_hollow(self.contact.profile, self.line)

    @property
    def law(self) -> AdhesionLaw:
        """The law of adhesion."""
        assert self.contact.adhesion is not None
        return self.contact.adhesion

    def _map(self, top: float) -> None:
        equivalent = self.origin.line.equivalent
        made = equivalent.upto(top) if isinstance(equivalent, NumericLine) else _finite(equivalent)
        self.line = ElasticLine(made, self.origin.line.modulus)
        self.equilibria = equilibria_of(self.law, self.contact.profile, self.line)
        self._tracks.clear()

    def _first_top(self) -> float:
        """A radius beyond that of the contact under no load, where g = sqrt(2 pi a work / E*)."""
        equivalent = self.origin.line.equivalent
        if not isinstance(equivalent, NumericLine):
            return math.inf
        modulus, work = self.origin.line.modulus, self.law.work

        def depth(samples: Samples, x: float) -> float:
            return float(samples.g(np.array([x]))[0] - jkr_opening(x, modulus, work))

        top = 2.0 * equivalent.top_where(depth, 0.0, lambda r, f: f - jkr_opening(r, modulus, work))
        law = self.law
        ranged = isinstance(law, MaugisDugdale) or (isinstance(law, DMT) and law.range is not None)
        for _ in range(_TRIES):
            made = equivalent.upto(top)
            try:
                equilibria_of(law, self.contact.profile, ElasticLine(made, modulus))
                return top
            except ProblemError:
                # the attraction goes farther out
                if top >= min(equivalent.edge, equivalent.reach) or not ranged or not made.rises:
                    raise
                top *= 2.0
        return top

    @property
    def natural_radius(self) -> float:
        """A parameter in m at which the indentation under adhesion is 0: the size of the contact."""
        bare = ShortRange(self.line.equivalent, self.line.modulus, self.law.work)
        at_zero = parameter_reaching(lambda s: bare.states(s).indentation, 0.0, limit=bare.limit)
        offset = self.equilibria.ends[1] if isinstance(self.equilibria, Cohesive) else 0.0
        return min(at_zero + offset, self.equilibria.limit)

    def track(self, machine_stiffness: float, top: float, at_least: float = 0.0) -> Track:
        """
        The curve under a control, traced up to a value of the control coordinate.

        Parameters
        ----------
        machine_stiffness : float
            k in N/m: inf for indentations, 0 for forces.
        top : float
            Largest value of the control coordinate that is asked for.
        at_least : float
            Parameter in m that the curve must include.

        Returns
        -------
        Track

        Raises
        ------
        PathError
            If the profile ends before the value is reached.
        """
        stop, track = self._tracks.get(machine_stiffness, (0.0, None))
        if track is not None and stop >= at_least and track.high[-1] >= top:
            return track
        stop = self._grow(machine_stiffness, top, at_least)
        made = self.traced(stop, machine_stiffness)
        self._tracks[machine_stiffness] = (stop, made)
        return made

    def traced(self, stop: float, machine_stiffness: float) -> Track:
        """The curve up to a parameter in m, or the reason why no state on it is stable."""
        try:
            return trace(under_machine(self.equilibria, stop, machine_stiffness))
        except PathError as error:
            held = {math.inf: "a prescribed indentation", 0.0: "a prescribed force"}.get(
                machine_stiffness, f"a machine of {written(machine_stiffness, 'N/m', 6)}"
            )
            reach = min(self.line.equivalent.reach, self.line.equivalent.edge)
            remedy = "lower the work of adhesion"
            if machine_stiffness < math.inf:
                remedy += ", hold the indentation, or use a stiffer machine"
            if math.isfinite(reach):
                remedy = f"the profile is known up to r = {metres(reach)}: extend it, or {remedy}"
            raise PathError(f"no state of the contact is stable under {held}; {remedy}") from error

    def _grow(self, machine_stiffness: float, top: float, at_least: float) -> float:
        """The parameter up to which the curve is needed; maps more of the profile where that is too short."""
        name, unit = ("normal_force", "N") if machine_stiffness == 0.0 else ("indentation or travel", "m")
        for _ in range(_TRIES):
            end = self._end
            wanted = _BEYOND * max(self.natural_radius, at_least)
            curve = under_machine(self.equilibria, wanted, machine_stiffness)
            # a path that only pulls still needs the stable states from which it falls
            for _ in range(_TRIES):
                if wanted >= end or curve.slope(np.array([wanted / _BEYOND]))[0] > 0.0:
                    break
                wanted *= _GROWTH
            settled = wanted < end or not self._can_grow()
            wanted = min(wanted, end)
            goal = max(top, float(curve.control(np.array([wanted]))[0]))
            stop = parameter_reaching(curve.control, goal, at_least=wanted, limit=end)
            if settled and float(curve.control(np.array([stop]))[0]) >= top:
                return stop
            if not self._can_grow():
                reached = float(curve.control(np.array([stop]))[0])
                why = (
                    "a sphere cannot be pressed in by its radius"
                    if end < self.equilibria.limit
                    else f"the contact would pass r = {metres(self.line.equivalent.reach)}, the last radius at which the "
                    "profile is known"
                )
                raise PathError(
                    f"{name} = {written(top, unit, 6)}: {why}; the largest value that it allows is {written(reached, unit, 6)}"
                )
            self._map(_GROWTH * self.line.equivalent.reach)
        raise PathError(
            f"{name} = {written(top, unit, 6)}: the profile never carries it, its contact has no end"
        )

    @property
    def _end(self) -> float:
        """The largest parameter in m that is followed: that of a sphere before it is pressed in by its radius."""
        profile, limit = self.contact.profile, self.equilibria.limit
        if not isinstance(profile, Sphere):
            return limit
        deepest = (1.0 - 1e-12) * profile.radius
        return parameter_reaching(lambda s: self.equilibria.states(s).indentation, deepest, limit=limit)

    def seen_upto(self, depths: FloatArray) -> ElasticLine:
        """The line on every radius at which the undeformed profile is below the largest of some depths in m."""
        equivalent = self.origin.line.equivalent
        deepest = float(np.nanmax(depths, initial=0.0))
        if not isinstance(equivalent, NumericLine) or equivalent.fixed or deepest <= 0.0:
            return self.line
        widest = made_fast(self.contact, self.origin, deepest, 0.0).line
        return widest if widest.equivalent.reach > self.line.equivalent.reach else self.line

    def _can_grow(self) -> bool:
        equivalent = self.origin.line.equivalent
        if not isinstance(equivalent, NumericLine) or equivalent.fixed:
            return False
        return self.line.equivalent.reach < min(equivalent.edge, equivalent.reach)


def _finite(equivalent: EquivalentProfile) -> EquivalentProfile:
    """A closed form short of the radius at which it is infinite, as that of a sphere is at R."""
    reach = equivalent.reach
    if reach == math.inf or equivalent.edge <= reach or math.isfinite(equivalent.g(np.array([reach]))[0]):
        return equivalent
    return SumLine((equivalent,), equivalent.edge, (1.0 - 1e-4) * reach)


def _refuse_endless(equivalent: EquivalentProfile) -> None:
    """The opening of an adhesive edge grows like a^(1/2): a flatter power never stops it."""
    if isinstance(equivalent, PowerLine) and equivalent.n <= 0.5:
        raise ProblemError(
            f"the tip rises like r^{equivalent.n:g}, not faster than the opening of an adhesive edge, which grows like "
            "r^0.5: the contact would spread without end; adhesion needs an exponent above 0.5"
        )


def _refuse_hollow(profile: Profile, line: ElasticLine) -> None:
    """Adhesive contact begins at the axis; a profile that is lower elsewhere begins on a ring."""
    equivalent = line.equivalent
    if not isinstance(equivalent, ProxyLine) or equivalent.rises:
        return
    r = np.linspace(0.0, min(equivalent.reach, equivalent.edge), 4001)[1:]
    f: FloatArray = gap_function(profile, equivalent)(r)
    lowest = int(np.nanargmin(f))
    if f[lowest] < -1e-9 * float(np.nanmax(np.abs(f))):
        raise ProblemError(
            f"the profile is lowest at r = {metres(r[lowest])} (f = {metres(f[lowest])}), not at its axis: its adhesive "
            "contact would be a ring, which the theory does not cover; leave the adhesion out, or use a profile that "
            "is lowest at r = 0"
        )
