"""Machines: masses, rotors and drives, linked by springs, contacts and forces."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.naming import nearest
from pymdr.problem.values import OptionalArrayField, SIField, Value
from pymdr.units import ArrayQuantityLike, FloatArray, shown, to_si_array

Coefficients = tuple[tuple[str, float], ...]
"""Names of bodies, and the factors by which their positions count."""
Coordinate = str | Sequence[str] | Mapping[str, float] | Coefficients
"""A body, a pair of bodies (first minus second), or bodies with their factors."""


class CoordinateField:
    """A field of bodies and their factors."""

    def __init__(self, description: str, *, needed: bool = True) -> None:
        self.description = description
        self.needed = needed

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> CoordinateField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> Coefficients: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        if instance is not None:
            return instance.__dict__[self.name]
        if self.needed:
            raise AttributeError(self.name)
        return ()

    def __set__(self, instance: object, value: Coordinate) -> None:
        instance.__dict__[self.name] = self.read(value)

    def read(self, value: Coordinate) -> Coefficients:
        """Names of bodies and their factors."""
        return coefficients(value, self.name, needed=self.needed)


class WavesField(OptionalArrayField):
    """A field of one value per wave, given as one value or a list; empty by default."""

    @overload
    def __get__(self, instance: None, owner: type) -> WavesField: ...

    @overload
    def __get__(self, instance: object, owner: type) -> FloatArray: ...

    def __get__(self, instance: object | None, owner: type) -> Any:
        return () if instance is None else instance.__dict__[self.name]

    def __set__(self, instance: object, values: ArrayQuantityLike) -> None:  # type: ignore[override]
        instance.__dict__[self.name] = self.read(values)

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert one value or several to a read-only SI array of one dimension."""
        array = np.array(to_si_array(values, self.unit, name=self.name), ndmin=1)
        array.flags.writeable = False
        return super().read(array)


class Body(Value, ABC):
    """A body that moves along one coordinate."""

    name: str


@dataclass(frozen=True, eq=False)
class Mass(Body):
    """
    A body that moves freely along one line.

    Parameters
    ----------
    name : str
        By which links name it.
    mass : quantity
        In kg, above 0.
    position, velocity : quantity
        At the start, in m and m/s.

    Raises
    ------
    ProblemError
        If the mass is not above 0, or the name is empty.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Mass("slider", "20 g").mass
    0.02
    """

    name: str
    mass: SIField = SIField("kg", above=0.0, description="mass")
    position: SIField = SIField("m", default=0.0, description="position at the start")
    velocity: SIField = SIField("m/s", default=0.0, description="velocity at the start")

    def __post_init__(self) -> None:
        _check_name(self)


@dataclass(frozen=True, eq=False)
class Rotor(Body):
    """
    A body that turns about one axis; its position is the displacement of its rim, radius times angle.

    Parameters
    ----------
    name : str
        By which links name it.
    inertia : quantity
        Moment of inertia in kg m^2, above 0.
    radius : quantity
        Distance in m of the rim from the axis, above 0.
    angle, spin : quantity
        Angle in rad and angular velocity in rad/s at the start.

    Raises
    ------
    ProblemError
        If the inertia or the radius is not above 0, or the name is empty.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Rotor("wheel", "1 g*m^2", radius="5 cm", spin="60 rpm").radius
    0.05
    """

    name: str
    inertia: SIField = SIField("kg*m^2", above=0.0, description="moment of inertia")
    radius: SIField = SIField("m", above=0.0, description="distance of the rim from the axis")
    angle: SIField = SIField("rad", default=0.0, description="angle at the start")
    spin: SIField = SIField("rad/s", default=0.0, description="angular velocity at the start")

    def __post_init__(self) -> None:
        _check_name(self)


@dataclass(frozen=True, eq=False)
class Drive(Body):
    """
    A point with a prescribed motion: x(t) = position + velocity t + sum A_i sin(2 pi f_i t + phase_i).

    Parameters
    ----------
    name : str
        By which links name it.
    position, velocity : quantity
        In m and m/s.
    amplitude, frequency, phase : quantity or list of quantities
        A_i in m, f_i in Hz and the phases in rad of one wave or several; phases are 0 by default.

    Raises
    ------
    ProblemError
        If the waves have different numbers of values, a frequency is not above 0, or the name is empty.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Drive("stage", velocity="1 mm/s", amplitude="1 um", frequency="20 kHz").frequency
    array([20000.])
    """

    name: str
    position: SIField = SIField("m", default=0.0, description="position at time 0 without waves")
    velocity: SIField = SIField("m/s", default=0.0, description="mean velocity")
    amplitude: WavesField = WavesField("m", description="amplitudes of the waves")
    frequency: WavesField = WavesField("Hz", description="frequencies of the waves")
    phase: WavesField = WavesField("rad", description="phases of the waves")

    def __post_init__(self) -> None:
        _check_name(self)
        _check_waves(self)


class Link(Value, ABC):
    """What acts between bodies."""


@dataclass(frozen=True, eq=False)
class Spring(Link):
    """
    A linear spring in parallel with a damper, with the force k e + c de/dt.

    Parameters
    ----------
    between : str, pair of str, or mapping
        The elongation e: the position of a body, the difference of two (first minus second), or a sum with factors.
    stiffness : quantity
        k in N/m, at least 0.
    damping : quantity
        c in N s/m, at least 0; one of both must be above 0.
    elongation : quantity
        e in m where all bodies are at 0.

    Raises
    ------
    ProblemError
        If a value is below 0, both are 0, or `between` names no body.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Spring(("slider", "stage"), "1 N/mm").between
    (('slider', 1.0), ('stage', -1.0))
    """

    between: CoordinateField = CoordinateField("elongation: a body, a pair or bodies with factors")
    stiffness: SIField = SIField("N/m", at_least=0.0, default=0.0, description="stiffness")
    damping: SIField = SIField("N*s/m", at_least=0.0, default=0.0, description="damping")
    elongation: SIField = SIField("m", default=0.0, description="elongation where all bodies are at 0")

    def __post_init__(self) -> None:
        if self.stiffness == 0.0 == self.damping:
            raise ProblemError(
                "stiffness and damping are both 0; give stiffness in N/m, damping in N s/m, or both above 0"
            )


@dataclass(frozen=True, eq=False)
class Joint(Link):
    """
    A contact between bodies of the machine, or of one with the ground.

    Parameters
    ----------
    contact : Contact
        Profile, materials and friction, as for :class:`Stepper`.
    normal : str, pair of str, or mapping, optional
        What adds to the indentation: the position of a body, the difference of two (first minus second), or a sum with factors. Without
        it the indentation is constant.
    tangential : the same, optional
        The shift; without it there is no tangential force.
    indentation : quantity
        In m where all bodies are at 0; below 0 a gap.
    name : str
        Of the joint in the result.

    Raises
    ------
    ProblemError
        If it has neither a normal nor a tangential coordinate, or one of them names no body.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3))
    >>> mdr.Joint(ball, tangential="slider", indentation="1 um").normal
    ()
    """

    contact: Contact
    normal: CoordinateField = CoordinateField("bodies that add to the indentation", needed=False)
    tangential: CoordinateField = CoordinateField("bodies that shift the contact", needed=False)
    indentation: SIField = SIField("m", default=0.0, description="indentation where all bodies are at 0")
    name: str = "contact"

    def __post_init__(self) -> None:
        require_contact(self.contact)
        if not self.normal and not self.tangential:
            raise ProblemError("neither normal nor tangential is given; name the bodies that move it")
        _check_name(self)


@dataclass(frozen=True, eq=False)
class Force(Link):
    """
    A force in time on a coordinate: F(t) = force + sum A_i sin(2 pi f_i t + phase_i).

    Parameters
    ----------
    on : str, pair of str, or mapping
        A body; of a pair or a sum every body takes its factor of the force.
    force : quantity
        The constant part in N.
    amplitude, frequency, phase : quantity or list of quantities
        A_i in N, f_i in Hz and the phases in rad of one wave or several; phases are 0 by default.

    Raises
    ------
    ProblemError
        If `on` names no body, the waves have different numbers of values, or a frequency is not above 0.

    See Also
    --------
    Machine : what it is a part of.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Force("ball", "-2 N").force
    -2.0
    """

    on: CoordinateField = CoordinateField("bodies that it acts on")
    force: SIField = SIField("N", default=0.0, description="constant part")
    amplitude: WavesField = WavesField("N", description="amplitudes of the waves")
    frequency: WavesField = WavesField("Hz", description="frequencies of the waves")
    phase: WavesField = WavesField("rad", description="phases of the waves")

    def __post_init__(self) -> None:
        _check_waves(self)


@dataclass(frozen=True, eq=False)
class Machine(Value):
    """
    Bodies with one coordinate each, and what acts between them.

    Parameters
    ----------
    bodies : sequence of Mass, Rotor and Drive
        A body that moves in several directions is a mass for each of them, and a rotor if it turns.
    links : sequence of Spring, Joint and Force
        What acts between the bodies, and between them and the ground.

    Raises
    ------
    ProblemError
        If names are not unique, a link names a body that does not exist, no body is free to move, or a drive is pushed by a force.

    See Also
    --------
    move : its motion.

    Examples
    --------
    >>> import pymdr as mdr
    >>> pendulum = mdr.Machine([mdr.Mass("bob", "1 kg")], [mdr.Spring("bob", "1 N/m")])
    >>> len(pendulum.links)
    1
    """

    bodies: Sequence[Body]
    links: Sequence[Link] = ()

    def __post_init__(self) -> None:
        for key, kind, words in (
            ("bodies", Body, "Mass, Rotor or Drive"),
            ("links", Link, "Spring, Joint or Force"),
        ):
            values = getattr(self, key)
            parts = tuple(values) if isinstance(values, Iterable) else (values,)
            for part in parts:
                if not isinstance(part, kind):
                    raise ProblemError(f"{key}: {shown(part)} is not a {words}")
            object.__setattr__(self, key, parts)
        _unique([body.name for body in self.bodies], "bodies")
        _unique([joint.name for joint in self.joints], "joints")
        if all(isinstance(body, Drive) for body in self.bodies):
            raise ProblemError("no body is free to move; give a Mass or a Rotor")
        driven = {body.name for body in self.bodies if isinstance(body, Drive)}
        for link in self.links:
            for key in ("between", "normal", "tangential", "on"):
                for name, _ in getattr(link, key, ()):
                    self._require(name, key)
                    if isinstance(link, Force) and name in driven:
                        raise ProblemError(
                            f"on = {name!r} is a Drive, whose motion is given; push a Mass or a Rotor"
                        )

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The contacts."""
        return tuple(link for link in self.links if isinstance(link, Joint))

    def _require(self, name: str, where: str) -> None:
        known = [body.name for body in self.bodies]
        if name not in known:
            near = nearest(name, known)
            words = f"did you mean {near[0]!r}?" if near else f"the bodies are {', '.join(known)}"
            raise ProblemError(f"{where}: there is no body {name!r}; {words}")


def coefficients(given: Any, where: str, *, needed: bool = True) -> Coefficients:
    """
    Names of bodies and their factors.

    Parameters
    ----------
    given : str, pair of str, mapping, or pairs of names and factors
    needed : bool
        Whether it must name a body.

    Examples
    --------
    >>> coefficients(("ball", "wall"), "normal")
    (('ball', 1.0), ('wall', -1.0))
    """
    remedy = "give a body, a pair (first minus second), or bodies with factors such as {'ball': -1}"
    if isinstance(given, str):
        pairs: list[Any] = [(given, 1.0)]
    elif isinstance(given, Mapping):
        pairs = list(given.items())
    elif (
        isinstance(given, Sequence) and all(isinstance(part, str) for part in given) and len(given) in (0, 2)
    ):
        pairs = list(zip(given, (1.0, -1.0), strict=False))
    elif isinstance(given, Sequence) and all(isinstance(part, tuple) and len(part) == 2 for part in given):
        pairs = list(given)
    else:
        raise ProblemError(f"{where} = {shown(given)}: {remedy}")
    if needed and not pairs:
        raise ProblemError(f"{where} names no body; {remedy}")
    for name, factor in pairs:
        number = isinstance(factor, int | float) and not isinstance(factor, bool)
        if not isinstance(name, str) or not number or not math.isfinite(factor) or factor == 0.0:
            raise ProblemError(
                f"{where}: {shown(name)} has the factor {shown(factor)}; {remedy}, finite and not 0"
            )
    _unique([name for name, _ in pairs], where)
    return tuple((name, float(factor)) for name, factor in pairs)


def _unique(names: Sequence[str], where: str) -> None:
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise ProblemError(f"the name {twice!r} occurs twice in {where}; names must differ")


def _check_name(value: Body | Joint) -> None:
    if not isinstance(value.name, str) or not value.name.strip():
        raise ProblemError(f"name = {shown(value.name)}; a text is needed, such as 'slider'")


def _check_waves(value: Drive | Force) -> None:
    """Equal numbers of amplitudes, frequencies and phases; frequencies above 0."""
    count = value.amplitude.size
    if value.phase.size == 0:
        object.__setattr__(value, "phase", np.zeros(count))
    if not value.frequency.size == value.phase.size == count:
        raise ProblemError(
            f"{count} amplitudes, {value.frequency.size} frequencies and {value.phase.size} phases; give one of each for every "
            "wave"
        )
    if not np.all(value.frequency > 0.0):
        raise ProblemError(
            f"frequency = {shown(float(value.frequency.min()))} Hz; it must be above 0 Hz; give a constant by its own key"
        )
