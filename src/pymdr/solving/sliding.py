"""Sliding over an elastomer: the friction of what it loses below a profile that passes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.sliding import Limits, friction_error, sliding_claims
from pymdr.line.foundation import DiskStates, ElasticLine, rises_to, states_at_depth, states_at_force
from pymdr.line.foundation import normal_force as elastic_force
from pymdr.line.sliding import (
    FEWER,
    Slid,
    SlidingLine,
    fast_drag,
    find_recontact,
    slide,
    sliding_line,
    slow_drag,
)
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.problem.contact import Contact
from pymdr.problem.rheology import WIDEST
from pymdr.problem.values import within_range
from pymdr.solving.bands import scatter_of
from pymdr.solving.closure import refuse_curve
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.memory import assumptions_with_memory, powers_of
from pymdr.solving.reach import map_remark, notes_of, one_load, refuse_unreachable
from pymdr.solving.study import Column, Study, one_row
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, metres, shown, to_si, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_WHO = "sliding_friction"
_SETTLED = 1e-13
_LOST = 1e-3
"""Relative error from which on a number tells nothing."""
_MOST = 80
_MISSED = 1e-8
"""Of the memory of a passage: what a power of time may answer at once."""
_DEEPEST = 1e18
"""How much faster than a passage the fastest term of a power of time is at most."""
_MARGIN = 30.0
"""Of the times of passage that are expected."""


@dataclass(frozen=True, kw_only=True)
class SlidingFriction(Study):
    """Friction of a profile that slides over an elastomer, without friction of the surfaces themselves."""

    data: xr.Dataset
    """
    Over ``speed`` (m/s): friction_coefficient F_x/F_N, friction_force (N), normal_force (N), indentation (m), leading_edge
    and trailing_edge (m from the tip, along the way) of the springs; slow_limit and fast_limit, the coefficients of friction
    to which slow and fast sliding tends, where there are such and at the speeds at which they are the friction to 5 %; nan
    elsewhere. ``slow_limit_over_speed`` (s/m) and ``fast_limit_times_speed`` (m/s) in its attributes are the limits themselves,
    ``numerical_error`` the relative errors of the numbers of the springs at every speed, beside those of the model.
    """
    subject: ClassVar = "a sliding contact"
    columns: ClassVar = {
        "speed": Column("speed", "m/s"),
        "friction_coefficient": Column("F_x/F_N", ""),
        "friction_force": Column("F_x", "N"),
        "normal_force": Column("F_N", "N"),
        "indentation": Column("depth", "m"),
        "leading_edge": Column("leading", "m"),
        "trailing_edge": Column("trailing", "m"),
        "slow_limit": Column("slow limit", ""),
        "fast_limit": Column("fast limit", ""),
    }
    summary_claims: ClassVar = ("friction_coefficient", "slow_limit", "fast_limit")

    def _figure(self) -> Figure:
        """Coefficient of friction against speed between its limits, and where contact ends."""
        from pymdr.presentation.plot import sliding_study

        return sliding_study(self.data)


def sliding_friction(
    contact: Contact,
    speed: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> SlidingFriction:
    """
    Coefficient of friction of a profile that slides steadily over an elastomer, without friction between the surfaces.

    The springs of the line pass below the profile: w' = g' in front of its tip and -g' behind it, q = int E*(t - s) dw(s),
    F_N = int q dx and F_x = int q g' dx from where w = d - g rises from 0 to where q has fallen to 0. For slow sliding the
    exact friction of two half-spaces is half of that, F_x = v int (E* - E*_inf) dt int_0^a g'^2 dx (``slow_limit``); for fast
    sliding of bodies that answer at once it is the same, F_x = (2/v) sum (E_i/tau_i) int_0^a (d - g)^2 dx (``fast_limit``).

    Parameters
    ----------
    contact : Contact
        One body is Viscoelastic, the flat one, over which the profile of the other slides. Its g must rise, without a sharp
        edge.
    speed : array_like or quantity
        Speeds v in m/s, above 0, one row.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.

    Returns
    -------
    SlidingFriction

    Raises
    ------
    ProblemError
        If no body, or both, are Viscoelastic, a speed is not above 0, both or none of the loads are given, the profile has a
        sharp edge or a falling g, meets springs again that it has left, or has a corner over bodies with a dashpot beside
        their springs, whose friction has no bound.
    PathError
        If the profile ends before the load is carried.

    Notes
    -----
    Popov and Hess (2015), chapter 11. Inertia is neglected: speeds are well below those of waves.

    Examples
    --------
    >>> import pymdr as mdr
    >>> rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "9 MPa", "1 ms"), poisson=0.5)
    >>> slid = mdr.sliding_friction(mdr.Contact(mdr.Paraboloid("10 mm"), rubber), ["1 mm/s", "1 m/s"], normal_force="1 N")
    >>> slid["friction_coefficient"].values.round(5).tolist()
    [0.00179, 0.0223]
    >>> slid["slow_limit"].values.round(5).tolist()
    [0.0009, nan]
    """
    asked = _read(contact, normal_force, indentation)
    v = positive_speeds(_WHO, speed)
    kernel = _kernel(asked, v)
    relaxation = kernel.relaxation
    rows = _rows(asked, kernel, v)
    slid = [row.slid for row in rows]
    a = np.array([row.pressed.radius for row in rows])
    force = np.array([one.load for one in slid]) if asked.force is None else np.full(v.size, asked.force)
    columns = {
        "friction_coefficient": np.array([one.drag / one.load for one in slid]),
        "friction_force": np.array([one.drag for one in slid]),
        "normal_force": force,
        "indentation": np.array([row.pressed.depth for row in rows]),
        "leading_edge": a,
        "trailing_edge": np.array([one.trailing for one in slid]),
    }
    slow, fast = _slow(asked, relaxation), _fast(asked, kernel, rows)
    deepest = max(*columns["indentation"], slow.depth, fast.depth)
    states = states_at_depth(asked.line, np.array([deepest]))
    mapped = float(np.max(asked.line.equivalent.slope_error(states.contact_radius)))
    glassy = math.isfinite(relaxation.glassy)
    friction = columns["friction_coefficient"]
    slow_error = None if slow.why else np.abs(friction / (2.0 * slow.factor * v) - 1.0) + mapped
    fast_error = a / v / _fastest(relaxation) + mapped if fast.why is None and glassy else None
    limits = Limits(slow.why, fast.why, glassy, slow_error, fast_error)
    columns |= {"slow_limit": slow.factor * v} if slow.why is None else {}
    if fast.why is None:
        columns["fast_limit"] = fast.factor / v if glassy else np.array([row.blunt for row in rows])
    remark = map_remark(asked.line, states)
    errors = np.array([_error(asked, kernel, float(one), row) for one, row in zip(v, rows, strict=True)])
    prescribed = "normal_force" if asked.depth is None else "indentation"
    everywhere = np.ones(v.shape, dtype=bool)
    stiffens = relaxation.glassy / relaxation.rubbery if relaxation.rubbery > 0.0 else math.inf
    model = friction_error(contact.profile, prescribed, limits, stiffens, everywhere)
    claims = sliding_claims(prescribed, limits, model, everywhere, errors, remark)
    attributes: dict[str, float | tuple[float, ...]] = {"numerical_error": tuple(errors.tolist())}
    if slow.why is None:
        attributes["slow_limit_over_speed"] = slow.factor
    if fast.why is None and glassy:
        attributes["fast_limit_times_speed"] = fast.factor
    for name in ("slow_limit", "fast_limit"):
        if name in columns:
            # a limit is a number where it is one of the speed
            columns[name] = np.where(claims[name].where, columns[name], math.nan)
    certificate = disks_down_to(contact, asked.line, deepest, _WHO)
    claims = with_rings(claims, certificate)
    notes = notes_of(contact.profile) + kernel.notes
    if scatter_of(contact.profile):
        notes += ("the scatter of the samples is smoothed by and makes no bands here",)
    return SlidingFriction(
        data=labelled_over_speed(v, columns).assign_attrs(attributes),
        claims=claims,
        assumptions=assumptions_with_memory(contact, states.contact_radius),
        notes=notes,
        contact=contact,
    )


def _fastest(relaxation: Relaxation) -> float:
    """The relaxation time in s that decides where fast sliding begins: the mean of 1/tau over what the fast limit rests on."""
    rates = 1.0 / relaxation.times
    return float(np.sum(relaxation.moduli * rates) / np.sum(relaxation.moduli * rates**2))


def positive_speeds(who: str, speed: ArrayQuantityLike) -> FloatArray:
    """One row of speeds in m/s, above 0."""
    v = one_row(speed, "m/s", who, "speed")
    if np.any(v <= 0.0):
        raise ProblemError(f"{who}: speed = {written(float(v.min()), 'm/s')}; it must be above 0 m/s")
    for extreme in (v.min(), v.max()):
        within_range(extreme, "m/s", f"{who}: speed", size=True)
    return v


def positive_load(
    who: str, normal_force: QuantityLike | None, indentation: QuantityLike | None, deep: float = 0.0
) -> tuple[float | None, float | None]:
    """Force in N above 0, or depth in m above a least one."""
    one_load(who, normal_force, indentation)
    force = None if normal_force is None else to_si(normal_force, "N", name="normal_force")
    depth = None if indentation is None else to_si(indentation, "m", name="indentation")
    for value, given, unit, least in ((force, normal_force, "N", 0.0), (depth, indentation, "m", deep)):
        if value is not None and value <= least:
            raise ProblemError(
                f"{who}: the load {shown(given)} must be above 0 {unit}; press the bodies together"
            )
        if value is not None:
            within_range(value, unit, f"{who}: the load", size=deep == 0.0)
    return force, depth


def labelled_over_speed(speed: FloatArray, columns: Mapping[str, FloatArray]) -> xr.Dataset:
    """Columns over speed, with their units."""
    import xarray as xr

    units = {name: {"units": column.unit} for name, column in SlidingFriction.columns.items()}
    return xr.Dataset(
        {name: ("speed", values, units[name]) for name, values in columns.items()},
        coords={"speed": ("speed", speed, units["speed"])},
    )


@dataclass(frozen=True)
class _Asked:
    """A contact and its load; exactly one of force in N and depth in m."""

    contact: Contact
    line: ElasticLine
    """Of the modulus 1."""
    force: float | None
    depth: float | None


def _read(contact: Contact, normal_force: QuantityLike | None, indentation: QuantityLike | None) -> _Asked:
    if not isinstance(contact, Contact):
        raise ProblemError(f"{_WHO}: {contact!r} is not a Contact; write Contact(profile, body)")
    refuse_curve(contact, _WHO, "sliding asks for the slope of its surface")
    if not contact.remembers:
        raise ProblemError(
            f"{_WHO}: no body is Viscoelastic: elastic bodies lose nothing below a profile that passes; give for example "
            "Viscoelastic(StandardSolid('1 MPa', '9 MPa', '1 ms'), poisson=0.5)"
        )
    if contact.friction is not None and contact.friction.coefficient > 0.0:
        raise ProblemError(
            f"{_WHO}: friction of the surfaces (mu = {contact.friction.coefficient:g}) is not in it: what is asked is what the body "
            "loses; leave friction out, and add mu to the answer where it does not change the contact"
        )
    if contact.body.remembers and contact.counterbody.remembers:
        raise ProblemError(
            f"{_WHO}: both bodies are Viscoelastic, but only that over which the profile slides is pressed in anew; give the "
            "other one as Elastic with its modulus after a long time, or as Rigid()"
        )
    force, depth = positive_load(_WHO, normal_force, indentation)
    return _Asked(contact, ElasticLine(equivalent_profile(contact.profile), 1.0), force, depth)


@dataclass(frozen=True)
class _Kernel:
    relaxation: Relaxation
    exponent: float = 0.0
    """Of a power of time; 0 without one."""
    shortest: float = 0.0
    """The fastest time in s that such a kernel holds."""
    longest: float = math.inf
    notes: tuple[str, ...] = ()


def _kernel(asked: _Asked, speed: FloatArray) -> _Kernel:
    """E*(t), of powers of time over what the passages below the contact feel."""
    bodies = (asked.contact.body, asked.contact.counterbody)
    powers = powers_of(asked.contact)
    if not powers:
        return _Kernel(relaxation_of(*bodies))
    (power,) = powers

    def passage(v: float) -> float:
        time = power.time
        for _ in range(1 if asked.force is None else 40):
            modulus = float(relaxation_of(*bodies, span=(0.1 * time, 10.0 * time))(time))
            states = _elastic(asked, modulus)
            time = 2.0 * float(states.contact_radius[0]) / v
            if not 0.0 < time < math.inf:
                refuse_unreachable(asked.line, asked.contact.profile, states, asked.force)
        return time

    fastest, slowest = passage(float(speed.max())), passage(float(speed.min()))
    beyond = _DEEPEST ** min(math.log(_MISSED, 1.0 / _DEEPEST) / (1.0 - power.exponent), 1.0)
    span = fastest / _MARGIN / beyond, _MARGIN * slowest
    if span[0] == 0.0 or span[1] > span[0] * WIDEST:
        raise ProblemError(
            f"{_WHO}: speeds from {written(float(speed.min()), 'm/s')} to {written(float(speed.max()), 'm/s')} are more than one "
            "series of terms can stand for the power of time at: ask for fewer decades of speed at once"
        )
    relaxation = relaxation_of(*bodies, span=span)
    note = (
        f"the power of time is a series of {relaxation.times.size} terms from {written(span[0], 's')} to {written(span[1], 's')}, "
        f"whose kernel errs by at most {relaxation.error:.1g}"
    )
    return _Kernel(relaxation, power.exponent, *span, (note,))


def _elastic(asked: _Asked, modulus: float) -> DiskStates:
    """The state under the load of elastic bodies."""
    if asked.force is not None:
        return states_at_force(asked.line, np.array([asked.force / modulus]))
    return states_at_depth(asked.line, np.array([asked.depth]))


@dataclass(frozen=True)
class _Row:
    pressed: SlidingLine
    slid: Slid

    @property
    def blunt(self) -> float:
        """The coefficient of friction of dashpots alone, int_0^a g'^2 dx / d."""
        return self.pressed.slope_square / self.pressed.depth


def _rows(asked: _Asked, kernel: _Kernel, speed: FloatArray) -> list[_Row]:
    """The states at all speeds, from the slowest on: each begins the search of the next."""
    rows: dict[int, _Row] = {}
    depth = None
    for i in np.argsort(speed, kind="stable").tolist():
        v = float(speed[i])
        if asked.depth is None:
            row = _under_force(asked, kernel.relaxation, v, depth)
        else:
            _refuse(asked, asked.depth)
            row = _at_depth(asked, kernel.relaxation, v, asked.depth)
        depth = row.pressed.depth
        _refuse_endless(asked, kernel.relaxation, row)
        met = find_recontact(row.pressed, asked.line, kernel.relaxation, v, row.slid)
        if met is not None:
            raise ProblemError(
                f"{_WHO}: at {written(v, 'm/s')} the profile meets springs again at x = {metres(met)} that it has left at "
                f"x = {metres(row.slid.trailing)}, since g' falls behind its tip: this is not followed; take a profile whose "
                "g' rises, or another speed"
            )
        passage = 2.0 * row.pressed.radius / v
        if not kernel.shortest < passage < kernel.longest:
            raise ConvergenceError(
                f"{_WHO}: at {written(v, 'm/s')} the contact is passed in {written(passage, 's')}, outside the kernel of the power "
                f"of time; ask for fewer speeds at once"
            )
        rows[i] = row
    return [rows[i] for i in range(speed.size)]


def _refuse(asked: _Asked, depth: float) -> None:
    """Refuse a depth in m at which springs do not rest smoothly on the profile."""
    profile = asked.contact.profile
    states = states_at_depth(asked.line, np.array([depth]))
    refuse_unreachable(asked.line, profile, states, asked.force)
    name = type(profile).__name__
    if states.edge_excess[0] > 0.0 or float(states.contact_radius[0]) == asked.line.edge:
        raise ProblemError(
            f"{_WHO}: the contact of the {name} reaches its sharp edge, at which springs are not pressed in smoothly; round the "
            "edge, or press it in less"
        )
    if not rises_to(asked.line, depth):
        raise ProblemError(
            f"{_WHO}: the equivalent profile of the {name} falls somewhere within the contact, where springs do not rest on it; "
            "take one that rises, or smooth it"
        )


def _refuse_endless(asked: _Asked, relaxation: Relaxation, row: _Row) -> None:
    if relaxation.viscosity > 0.0 and not math.isfinite(row.pressed.slope_square):
        raise ProblemError(
            f"{_WHO}: the friction has no bound: int g'^2 dx has none for a {type(asked.contact.profile).__name__} of such a "
            "corner or tip, and a dashpot beside all springs bears it; take a round profile, or a rheology that answers at "
            "once, such as StandardSolid"
        )


def _at_depth(asked: _Asked, relaxation: Relaxation, speed: float, depth: float) -> _Row:
    pressed = sliding_line(asked.line, states_at_depth(asked.line, np.array([depth])))
    return _Row(pressed, slide(pressed, relaxation, speed))


def _under_force(asked: _Asked, relaxation: Relaxation, speed: float, near: float | None) -> _Row:
    """The state that carries the force: F_N rises with the depth, about as a power of it."""
    assert asked.force is not None
    low, high, refusal = 0.0, math.inf, None
    if near is None:
        known = [E for E in (relaxation.rubbery, relaxation.glassy) if 0.0 < E < math.inf]
        near = float(_elastic(asked, known[0] if known else relaxation.viscosity).indentation[0])
    depth = near if 0.0 < near < math.inf else 1.0
    power, before, row = 1.5, None, None
    for _ in range(_MOST):
        try:
            _refuse(asked, depth)
        except (ConvergenceError, PathError, ProblemError) as error:
            # less depth may do
            high, refusal, before = depth, error, None
            if high <= low * (1.0 + 1e-12):
                raise
            depth = math.sqrt(low * high) if low > 0.0 else 0.25 * high
            continue
        row = _at_depth(asked, relaxation, speed, depth)
        missed = math.log(row.slid.load / asked.force) if row.slid.load > 0.0 else -math.inf
        if abs(missed) <= _SETTLED or high <= low * (1.0 + 4e-16):
            return row
        low, high = (depth, high) if missed < 0.0 else (low, depth)
        if before is not None and depth != before[0]:
            power = (missed - before[1]) / math.log(depth / before[0])
        before = (depth, missed)
        after = depth * math.exp(-missed / power) if power > 0.0 and math.isfinite(missed) else math.nan
        if not low < after < high:
            closed = low > 0.0 and high < math.inf
            after = math.sqrt(low * high) if closed else depth * 4.0 ** -math.copysign(1, missed)
        if after == depth:
            return row
        depth = after
    if refusal is not None:
        raise refusal
    if row is not None:
        _refuse_endless(asked, relaxation, row)
    raise ConvergenceError(
        f"{_WHO}: no depth was found that carries {asked.force:g} N at {speed:g} m/s; the last was {depth:g} m"
    )


@dataclass(frozen=True)
class _Limit:
    """A limit of the coefficient of friction."""

    factor: float = math.nan
    """Over the speed, or times it."""
    depth: float = 0.0
    """The depth in m of its state."""
    why: str | None = None
    """Why there is none."""


def _slow(asked: _Asked, relaxation: Relaxation) -> _Limit:
    """Of the surface: half of what the springs have."""
    if relaxation.rubbery == 0.0:
        return _Limit(
            why="the bodies relax to nothing: without a modulus that is left in the end, friction does not begin with the first "
            "power of the speed"
        )
    try:
        states = _elastic(asked, relaxation.rubbery)
        _refuse(asked, float(states.indentation[0]))
    except (ConvergenceError, PathError, ProblemError) as error:
        return _Limit(why=f"at rest the load is not carried on a smooth disk: {error}")
    drag = 0.5 * slow_drag(sliding_line(asked.line, states), relaxation)
    if not math.isfinite(drag):
        return _Limit(
            why="int g'^2 dx has no bound for a profile of such a corner or tip: friction begins with a lower power of the speed"
        )
    load = relaxation.rubbery * float(elastic_force(asked.line, states)[0])
    return _Limit(drag / load, float(states.indentation[0]))


def _fast(asked: _Asked, kernel: _Kernel, rows: list[_Row]) -> _Limit:
    if kernel.exponent > 0.0:
        return _Limit(why="a power of time has no modulus that answers at once, and fast sliding no limit")
    glassy = kernel.relaxation.glassy
    if not math.isfinite(glassy):
        return _Limit(1.0, max(row.pressed.depth for row in rows))
    states = _elastic(asked, glassy)
    load = glassy * float(elastic_force(asked.line, states)[0])
    drag = fast_drag(asked.line, states, kernel.relaxation)
    return _Limit(drag / load, float(states.indentation[0]))


def _error(asked: _Asked, kernel: _Kernel, speed: float, row: _Row) -> float:
    """What fewer nodes make otherwise, and what map and kernel err by."""
    states = states_at_depth(asked.line, np.array([row.pressed.depth]))
    fewer = slide(sliding_line(asked.line, states, FEWER), kernel.relaxation, speed)
    nodes = max(abs(fewer.drag / row.slid.drag - 1.0), abs(fewer.load / row.slid.load - 1.0))
    if not nodes < _LOST:
        raise ConvergenceError(
            f"{_WHO}: at {written(speed, 'm/s')} the friction is {row.slid.drag / row.slid.load:.1g} of the load, less than rounding "
            "leaves of it; such speeds are a matter of slow_limit and fast_limit"
        )
    mapped = float(np.max(asked.line.equivalent.slope_error(states.contact_radius)))
    if kernel.exponent == 0.0:
        return nodes + mapped
    missed = (kernel.shortest * speed / (2.0 * row.pressed.radius)) ** (1.0 - kernel.exponent)
    return nodes + mapped + kernel.relaxation.error + float(missed)
