"""The curve of equilibrium states of an adhesive contact, traced as far as needed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.branches import Equilibria
from pymdr.interpretation.theories import equilibria_of
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import jkr_opening
from pymdr.line.curves import Line
from pymdr.line.following import Curve, Track, parameter_reaching, trace, under_machine
from pymdr.line.layered import LayeredLine, Limit
from pymdr.mapping.equivalent import EquivalentProfile, PowerLine, SumLine, gap_function
from pymdr.problem.contact import Contact
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.profiles import Profile, Sampled, Sphere, Sum
from pymdr.solving.mapped import Mapped, map_to_line
from pymdr.units import FloatArray, metres, written

_GROWTH, _BEYOND, _TRIES = 1.5, 1.2, 60
_FAINTEST = 1e-140
"""Radius in m below which energies underflow."""


@dataclass
class AdhesiveLine:
    """
    A contact with adhesion on the line, with its curve, which is extended when a path needs it.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.
    """

    contact: Contact
    origin: Mapped = field(init=False)
    line: Line = field(init=False)
    equilibria: Equilibria = field(init=False)
    limit: Limit | None = field(init=False, default=None)
    """The largest smooth contact on layers, after :meth:`is_limited`."""
    _tracks: dict[float, tuple[float, Track]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.origin = map_to_line(self.contact)
        equivalent = self.origin.line.equivalent
        _refuse_endless(equivalent)
        self.line = self.origin.line.under(finite(equivalent))
        _refuse_hollow(self.contact.profile, self.line, self._first_radius, self.unsmoothed)
        self.equilibria = equilibria_of(self.law, self.contact.profile, self.line, 2.0 * self._first_radius)

    @property
    def unsmoothed(self) -> tuple[str, ...]:
        """How to smooth the samples of the profile, if they have noise: an adhesive contact follows the slopes of their curve."""
        parts = (
            self.contact.profile.parts if isinstance(self.contact.profile, Sum) else (self.contact.profile,)
        )
        return tuple(part.unsmoothed for part in parts if isinstance(part, Sampled) and part.unsmoothed)

    @property
    def law(self) -> AdhesionLaw:
        """The law of adhesion."""
        assert self.contact.adhesion is not None
        return self.contact.adhesion

    @cached_property
    def _first_radius(self) -> float:
        """Approximate contact radius in m without load, where d0 is the opening of the edge."""
        line, work = self.line, self.law.work
        radius = line.rough_radius(lambda a, d0: d0 >= jkr_opening(line, a, work))
        if radius < _FAINTEST:
            raise self._faint()
        return radius

    def _faint(self) -> ProblemError:
        """The error for adhesive contacts too small for floating-point numbers."""
        return ProblemError(
            f"adhesion: a work of {written(self.law.work, 'J/m^2', 3)} gives contact radii below {_FAINTEST:g} m, because "
            f"the body is stiffer for smaller contacts (exponent {self.line.exponent:g}): its pull is negligible; leave the adhesion "
            "out, or use an exponent closer to 0"
        )

    @cached_property
    def natural_radius(self) -> float:
        """A parameter in m at which the indentation under adhesion is 0: the size of the contact."""
        bare = ShortRange(self.line, self.law.work)
        try:
            at_zero = parameter_reaching(
                under_machine(bare, bare.limit).control,
                0.0,
                begin=min(self._first_radius, self._widest),
                limit=min(bare.limit, self._widest),
            )
        except PathError as error:
            if bare.states(np.array([_FAINTEST])).indentation[0] >= 0.0:
                raise self._faint() from error
            raise
        if at_zero < _FAINTEST:
            raise self._faint()
        return min(at_zero + self.equilibria.contact, self.equilibria.limit)

    @property
    def _widest(self) -> float:
        """The largest contact radius in m that layers allow, if it is known."""
        return math.inf if self.limit is None else float(self.line.place(self.limit.depth).x)

    def is_limited(self) -> bool:
        """Whether layers limit the size of contacts; the limit is stored and then applies to all curves."""
        if self.limit is None and isinstance(self.line, LayeredLine):
            limit = self.line.limit(lambda *_: False)
            self.limit = limit if limit is not None and limit.depth > 0.0 else None
        return self.limit is not None

    def track(self, machine_stiffness: float, top: float, at_least: float = 0.0) -> Track:
        """
        The curve under a control, traced up to a value of the control coordinate.

        Parameters
        ----------
        machine_stiffness : float
            k in N/m: inf for indentations, 0 for forces.
        top : float
            Largest requested value of the control coordinate.
        at_least : float
            Parameter in m that the curve must include.

        Raises
        ------
        PathError
            If the profile ends before the value is reached.
        ConvergenceError, ProblemError
            If layers do not allow such a large contact.
        """
        stop, track = self._tracks.get(machine_stiffness, (0.0, None))
        if track is not None and stop >= at_least and track.high[-1] >= top:
            return track
        stop = self.stop(machine_stiffness, top, at_least)
        # theories of cohesive zones need a profile that increases up to the end
        equilibria_of(self.law, self.contact.profile, self.line, stop)
        made = self.traced(stop, machine_stiffness)
        self._tracks[machine_stiffness] = (stop, made)
        return made

    def traced(self, stop: float, machine_stiffness: float) -> Track:
        """The curve up to a parameter in m; raise if no state on it is stable."""
        try:
            return trace(under_machine(self.equilibria, stop, machine_stiffness))
        except PathError as error:
            if self.limit is not None:
                raise self.limit.error from error
            control = {math.inf: "a prescribed indentation", 0.0: "a prescribed force"}.get(
                machine_stiffness, f"a machine of {written(machine_stiffness, 'N/m', 6)}"
            )
            raise self.too_short(
                f"no state of the contact is stable under {control}", machine_stiffness
            ) from error

    def fallen(self, parameter: float, force: float) -> float:
        """
        Energy in J dissipated when a dead load tears a contact off.

        That is U + F (d_c - d), with the smallest indentation d_c < d of any contact; the work of the load after separation
        is not included.
        """
        depth, energy = self._depth_and_energy(parameter)
        deepest = self.track(math.inf, depth, parameter)
        last, _ = self._depth_and_energy(deepest.pull_off)
        return energy + force * (min(last, depth) - depth)

    def _depth_and_energy(self, parameter: float) -> tuple[float, float]:
        s = np.array([parameter])
        elastic, surface = self.equilibria.energies(s)
        return float(self.equilibria.states(s).indentation[0]), float(elastic[0] + surface[0])

    def too_short(self, why: str, machine_stiffness: float) -> PathError:
        """The error if no stable state is known, with the remedy."""
        last = min(self.line.equivalent.max_radius, self.line.equivalent.edge)
        remedy = "lower the work of adhesion"
        if machine_stiffness < math.inf:
            remedy += ", hold the indentation, or use a stiffer machine"
        if math.isfinite(last):
            remedy = f"the profile is known up to r = {metres(last)}: extend it, or {remedy}"
        return PathError(f"{why}; {remedy}")

    def stop(
        self, machine_stiffness: float, top: float, at_least: float = 0.0, end: float | None = None
    ) -> float:
        """
        The parameter in m up to which the curve is needed for :meth:`track`, which takes the same arguments and raises the same errors.

        The curve ends at a parameter in m, first where no sphere is pressed in by its radius yet.
        """
        if end is None:
            profile = self.contact.profile
            end = (
                self.end if self.contact.layered or not isinstance(profile, Sphere) else 0.5 * profile.radius
            )
        wanted = _BEYOND * max(self.natural_radius, at_least)
        curve = under_machine(self.equilibria, wanted, machine_stiffness)
        # a path without approach still needs the stable states from which it jumps
        for _ in range(_TRIES):
            if wanted >= end or curve.slope(np.array([wanted / _BEYOND]))[0] > 0.0:
                break
            wanted *= _GROWTH
        wanted = min(wanted, end)
        goal = max(top, float(curve.control(np.array([wanted]))[0]))
        stop = parameter_reaching(curve.control, goal, at_least=wanted, limit=end)
        if stop == end < self.end:
            return self.stop(machine_stiffness, top, at_least, self.end)
        if curve.control(np.array([stop]))[0] >= top:
            return stop
        # the control may decrease before the profile ends
        largest = self._highest(curve, wanted, stop)
        if largest >= top:
            return stop
        if self.limit is not None:
            raise self.limit.error
        name, unit = ("normal_force", "N") if machine_stiffness == 0.0 else ("indentation or travel", "m")
        why = (
            "a sphere cannot be pressed in by its radius"
            if end < self.equilibria.limit
            else f"the contact would pass r = {metres(self.line.equivalent.max_radius)}, the last radius at which the profile "
            "is known"
        )
        raise PathError(
            f"{name} = {written(top, unit, 6)}: {why}; the largest value that it allows is {written(largest, unit, 6)}"
        )

    def _highest(self, curve: Curve, low: float, high: float) -> float:
        """The largest control on a part of the curve."""
        s = np.unique(
            np.concatenate([np.linspace(low, high, 801), [k for k in curve.knots if low < k < high]])
        )
        for _ in range(4):
            best = int(np.argmax(curve.control(s)))
            s = np.linspace(s[max(best - 1, 0)], s[min(best + 1, s.size - 1)], 101)
        values = curve.control(s)
        return float(np.max(values))

    @property
    def end(self) -> float:
        """The largest parameter in m of curves."""
        # contacts of layers are solved one by one: avoid unneeded ones
        return self._deepest if self.contact.layered is None else min(self.equilibria.limit, self._widest)

    @cached_property
    def _deepest(self) -> float:
        """The last parameter in m of the curve, or for a sphere the one before an indentation of its radius."""
        profile, limit = self.contact.profile, self.equilibria.limit
        if not isinstance(profile, Sphere):
            return limit
        deepest = (1.0 - 1e-12) * profile.radius
        control = under_machine(self.equilibria, limit).control
        return parameter_reaching(control, deepest, begin=self._first_radius, limit=limit)


def finite(equivalent: EquivalentProfile) -> EquivalentProfile:
    """A closed form up to just before the radius at which it is infinite, as that of a sphere at R."""
    last = equivalent.max_radius
    if last == math.inf or equivalent.edge <= last or math.isfinite(equivalent.g(np.array([last]))[0]):
        return equivalent
    return SumLine((equivalent,), equivalent.edge, (1.0 - 1e-4) * last, equivalent.exponent)


def _refuse_endless(equivalent: EquivalentProfile) -> None:
    """Refuse profiles flatter than the opening of an adhesive edge, which grows like a^((1-k)/2)."""
    opening = 0.5 * (1.0 - equivalent.exponent)
    if isinstance(equivalent, PowerLine) and equivalent.n <= opening:
        raise ProblemError(
            f"the tip rises like r^{equivalent.n:g}, not faster than the opening of an adhesive edge, r^{opening:g}: the contact "
            f"would spread without limit; adhesion needs an exponent above {opening:g}"
        )


def _refuse_hollow(profile: Profile, line: Line, radius: float, remedies: Sequence[str]) -> None:
    """Refuse profiles that are lowest off the axis, whose contact would start as a ring."""
    equivalent = line.equivalent
    top = min(equivalent.max_radius, equivalent.edge, 2.0 * radius)
    if equivalent.rises or not equivalent.turning_points(top):
        return
    r = np.linspace(0.0, top, 4001)[1:]
    f: FloatArray = gap_function(profile, equivalent)(r)
    lowest = int(np.nanargmin(f))
    if f[lowest] < -1e-9 * float(np.nanmax(np.abs(f))):
        raise ProblemError(
            f"the profile is lowest at r = {metres(r[lowest])} (f = {metres(f[lowest])}), not at its axis: its adhesive "
            "contact would be a ring, which the theory does not cover; "
            + (
                remedies[0]
                if remedies
                else "leave the adhesion out, or use a profile that is lowest at r = 0"
            )
        )
