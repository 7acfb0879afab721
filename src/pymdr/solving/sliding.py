"""Sliding over an elastomer: friction by its dissipation below the moving profile."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import xr
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
from pymdr.problem.contact import Contact, refuse_curve
from pymdr.problem.fractional import WIDEST
from pymdr.solving.arguments import positive_load, positive_speeds
from pymdr.solving.bands import no_bands
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.mapped import map_remark, notes_of, refuse_unreachable
from pymdr.solving.memory import assumptions_with_memory, powers_of
from pymdr.solving.study import Column, Study, over_rows
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, metres, written

_SETTLED = 1e-13
_LARGEST_ERROR = 1e-3
"""Largest relative error of the discretisation."""
_MOST = 80
_MISSED = 1e-8
"""Fraction of a power of time that may relax instantaneously, relative to the memory of a passage."""
_DEEPEST = 1e18
"""Largest ratio of the passage time to the fastest term of a power of time."""
_MARGIN = 30.0
"""Margin of the expected passage times."""


@dataclass(frozen=True, kw_only=True)
class SlidingFriction(Study):
    """Friction of a profile that slides over an elastomer, without friction of the surfaces themselves."""

    data: xr.Dataset
    """
    Over ``speed`` (m/s): friction_coefficient F_x/F_N, friction_force (N), normal_force (N), indentation (m), leading_edge
    and trailing_edge (m from the tip, along the sliding direction) of the springs; slow_limit and fast_limit, the limits of
    the coefficient of friction for slow and fast sliding, if they exist and at speeds at which they hold within 5 %; NaN
    elsewhere. ``slow_limit_over_speed`` (s/m) and ``fast_limit_times_speed`` (m/s) in its attributes are the limits themselves,
    ``numerical_error`` the relative numerical errors at every speed, in addition to those of the model.
    """
    subject: ClassVar = "a sliding contact"
    _drawn: ClassVar = ("sliding_study", "data")
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


def sliding_friction(
    contact: Contact,
    speed: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> SlidingFriction:
    """
    Coefficient of friction of a profile in steady sliding over an elastomer, without friction between the surfaces.

    The springs of the line pass below the profile: w' = g' in front of its tip and -g' behind it, q = int E*(t - s) dw(s),
    F_N = int q dx and F_x = int q g' dx from w = d - g = 0 at the leading edge to q = 0 at the trailing edge. For slow sliding the
    exact friction of two half-spaces is half of that, F_x = v int (E* - E*_inf) dt int_0^a g'^2 dx (``slow_limit``); for fast
    sliding of bodies with a glassy modulus it is the same, F_x = (2/v) sum (E_i/tau_i) int_0^a (d - g)^2 dx (``fast_limit``).

    Parameters
    ----------
    contact : Contact
        The flat body, over which the profile slides, is Viscoelastic. The profile g must increase, without a sharp edge.
    speed : array_like or quantity
        Speeds v in m/s, above 0, one row.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.

    Returns
    -------
    SlidingFriction
        Over ``speed`` (m/s): coefficient of friction, forces (N), indentation (m), edges (m), slow and fast limits.

    Raises
    ------
    ProblemError
        If no body, or both, are Viscoelastic, a speed is not above 0, both or none of the loads are given, the profile has a
        sharp edge or a decreasing g, touches springs again after separation, or has a corner over bodies with a parallel
        dashpot, so that the friction is unbounded.
    PathError
        If the profile ends before the load is carried.

    See Also
    --------
    rough_sliding_friction : a rough line.
    rolling : creep forces.

    Notes
    -----
    Popov and Hess (2015), chapter 11. Inertia is neglected: speeds must be well below those of waves.

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

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
    case = _read(contact, normal_force, indentation)
    v = positive_speeds(speed)
    kernel = _kernel(case, v)
    relaxation = kernel.relaxation
    rows = _rows(case, kernel, v)
    columns = _columns(case, rows)
    slow, fast = _slow(case, relaxation), _fast(case, kernel, rows)
    deepest = max(*columns["indentation"], slow.depth, fast.depth)
    states = states_at_depth(case.line, np.array([deepest]))
    mapped = float(np.max(case.line.equivalent.slope_error(states.contact_radius)))
    limits = _limits(relaxation, (slow, fast), v, columns, mapped)
    columns |= {"slow_limit": slow.factor * v} if slow.why is None else {}
    if fast.why is None:
        columns["fast_limit"] = fast.factor / v if limits.glassy else np.array([row.blunt for row in rows])
    remark = map_remark(case.line, states)
    errors = np.array([_error(case, kernel, float(one), row) for one, row in zip(v, rows, strict=True)])
    prescribed = "normal_force" if case.depth is None else "indentation"
    everywhere = np.ones(v.shape, dtype=bool)
    stiffens = relaxation.glassy / relaxation.rubbery if relaxation.rubbery > 0.0 else math.inf
    model = friction_error(contact.profile, prescribed, limits, stiffens, everywhere)
    claims = sliding_claims(prescribed, limits, model, everywhere, errors, remark)
    attributes: dict[str, float | tuple[float, ...]] = {"numerical_error": tuple(errors.tolist())}
    if slow.why is None:
        attributes["slow_limit_over_speed"] = slow.factor
    if fast.why is None and limits.glassy:
        attributes["fast_limit_times_speed"] = fast.factor
    for name in {"slow_limit", "fast_limit"} & set(columns):
        # NaN at speeds at which a limit does not hold
        columns[name] = np.where(claims[name].where, columns[name], math.nan)
    certificate = disks_down_to(contact, case.line, deepest, "sliding friction")
    claims = with_rings(claims, certificate)
    return SlidingFriction(
        data=over_rows("speed", v, columns, SlidingFriction.columns).assign_attrs(attributes),
        claims=claims,
        assumptions=assumptions_with_memory(contact, states.contact_radius),
        notes=notes_of(contact.profile) + kernel.notes + no_bands(contact.profile),
        contact=contact,
    )


def _columns(case: _Case, rows: list[_Row]) -> dict[str, FloatArray]:
    """Forces and edges of all speeds."""
    slid = [row.slid for row in rows]
    loads = [one.load if case.force is None else case.force for one in slid]
    return {
        "friction_coefficient": np.array([one.drag / one.load for one in slid]),
        "friction_force": np.array([one.drag for one in slid]),
        "normal_force": np.array(loads),
        "indentation": np.array([row.pressed.depth for row in rows]),
        "leading_edge": np.array([row.pressed.radius for row in rows]),
        "trailing_edge": np.array([one.trailing for one in slid]),
    }


def _limits(
    relaxation: Relaxation,
    ends: tuple[_Limit, _Limit],
    v: FloatArray,
    columns: Mapping[str, FloatArray],
    mapped: float,
) -> Limits:
    """Where the limits of slow and fast sliding exist, and their errors at every speed, with that of the map."""
    slow, fast = ends
    glassy = math.isfinite(relaxation.glassy)
    friction, a = columns["friction_coefficient"], columns["leading_edge"]
    slow_error = None if slow.why else np.abs(friction / (2.0 * slow.factor * v) - 1.0) + mapped
    fast_error = a / v / _fastest(relaxation) + mapped if fast.why is None and glassy else None
    return Limits(slow.why, fast.why, glassy, slow_error, fast_error)


def _fastest(relaxation: Relaxation) -> float:
    """The inverse mean rate in s of the fast limit, which decides when sliding is fast."""
    rates = 1.0 / relaxation.times
    return float(np.sum(relaxation.moduli * rates) / np.sum(relaxation.moduli * rates**2))


@dataclass(frozen=True)
class _Case:
    """A contact and its load; exactly one of force in N and depth in m."""

    contact: Contact
    line: ElasticLine
    """The line with modulus 1."""
    force: float | None
    depth: float | None


def _read(contact: Contact, normal_force: QuantityLike | None, indentation: QuantityLike | None) -> _Case:
    refuse_curve(contact, "sliding needs the slope of its surface")
    if not contact.is_viscoelastic:
        raise ProblemError(
            "no body is viscoelastic, and elastic bodies dissipate nothing below a moving profile; give for example "
            "Viscoelastic(StandardSolid('1 MPa', '9 MPa', '1 ms'), poisson=0.5)"
        )
    if contact.friction is not None and contact.friction.coefficient > 0.0:
        raise ProblemError(
            f"friction of the surfaces (mu = {contact.friction.coefficient:g}) is not included, only the dissipation of the "
            "body; leave friction out, and add mu to the result if it does not change the contact"
        )
    if contact.body.is_viscoelastic and contact.counterbody.is_viscoelastic:
        raise ProblemError(
            "both bodies are Viscoelastic, but only the one under the profile is cyclically deformed; give the "
            "other one as Elastic with its long-time modulus, or as Rigid()"
        )
    force, depth = positive_load(normal_force, indentation)
    return _Case(contact, ElasticLine(equivalent_profile(contact.profile), 1.0), force, depth)


@dataclass(frozen=True)
class _Kernel:
    relaxation: Relaxation
    exponent: float = 0.0
    """Exponent of a power of time; 0 without one."""
    shortest: float = 0.0
    """The shortest time in s of such a kernel."""
    longest: float = math.inf
    notes: tuple[str, ...] = ()


def _kernel(case: _Case, speed: FloatArray) -> _Kernel:
    """E*(t); powers of time over the range of the passage times."""
    bodies = (case.contact.body, case.contact.counterbody)
    powers = powers_of(case.contact)
    if not powers:
        return _Kernel(relaxation_of(*bodies))
    (power,) = powers

    def passage(v: float) -> float:
        time = power.time
        for _ in range(1 if case.force is None else 40):
            modulus = float(relaxation_of(*bodies, span=(0.1 * time, 10.0 * time))(time))
            states = _elastic(case, modulus)
            time = 2.0 * float(states.contact_radius[0]) / v
            if not 0.0 < time < math.inf:
                refuse_unreachable(case.line, case.contact.profile, states, case.force)
        return time

    fastest, slowest = passage(float(speed.max())), passage(float(speed.min()))
    beyond = _DEEPEST ** min(math.log(_MISSED, 1.0 / _DEEPEST) / (1.0 - power.exponent), 1.0)
    span = fastest / _MARGIN / beyond, _MARGIN * slowest
    if span[0] == 0.0 or span[1] > span[0] * WIDEST:
        raise ProblemError(
            f"speeds from {written(float(speed.min()), 'm/s')} to {written(float(speed.max()), 'm/s')} exceed the range "
            "of the series for a power-law relaxation; use fewer decades of speed at once"
        )
    relaxation = relaxation_of(*bodies, span=span)
    note = (
        f"the power of time is a series of {relaxation.times.size} terms from {written(span[0], 's')} to {written(span[1], 's')}, "
        f"with an error of at most {relaxation.error:.1g}"
    )
    return _Kernel(relaxation, power.exponent, *span, (note,))


def _elastic(case: _Case, modulus: float) -> DiskStates:
    """The state of elastic bodies under the load."""
    if case.force is not None:
        return states_at_force(case.line, np.array([case.force / modulus]))
    return states_at_depth(case.line, np.array([case.depth]))


@dataclass(frozen=True)
class _Row:
    pressed: SlidingLine
    slid: Slid

    @property
    def blunt(self) -> float:
        """The coefficient of friction of dashpots alone, int_0^a g'^2 dx / d."""
        return self.pressed.slope_square / self.pressed.depth


def _rows(case: _Case, kernel: _Kernel, speed: FloatArray) -> list[_Row]:
    """The states at all speeds from the slowest on, each the start of the search for the next."""
    rows: dict[int, _Row] = {}
    depth = None
    for i in np.argsort(speed, kind="stable").tolist():
        v = float(speed[i])
        if case.depth is None:
            row = _under_force(case, kernel.relaxation, v, depth)
        else:
            _refuse(case, case.depth)
            row = _at_depth(case, kernel.relaxation, v, case.depth)
        depth = row.pressed.depth
        _refuse_unbounded(case, kernel.relaxation, row)
        met = find_recontact(row.pressed, case.line, kernel.relaxation, v, row.slid)
        if met is not None:
            raise ProblemError(
                f"at {written(v, 'm/s')} the profile touches springs again at x = {metres(met)} after separation at "
                f"x = {metres(row.slid.trailing)}, because g' decreases behind its tip, which is not covered; use a profile whose "
                "g' increases, or another speed"
            )
        passage = 2.0 * row.pressed.radius / v
        if not kernel.shortest < passage < kernel.longest:
            raise ConvergenceError(
                f"at {written(v, 'm/s')} the passage takes {written(passage, 's')}, outside the range of the series for a power-law "
                "relaxation; use fewer speeds at once"
            )
        rows[i] = row
    return [rows[i] for i in range(speed.size)]


def _refuse(case: _Case, depth: float) -> None:
    """Refuse a depth in m at which springs do not touch the profile smoothly."""
    profile = case.contact.profile
    states = states_at_depth(case.line, np.array([depth]))
    refuse_unreachable(case.line, profile, states, case.force)
    name = type(profile).__name__
    if states.edge_excess[0] > 0.0 or float(states.contact_radius[0]) == case.line.edge:
        raise ProblemError(
            f"the contact of the {name} reaches its sharp edge, at which springs are deformed suddenly; round the "
            "edge, or reduce the load"
        )
    if not rises_to(case.line, depth):
        raise ProblemError(
            f"the equivalent profile of the {name} decreases within the contact, where springs lose contact; "
            "use an increasing profile, or smooth it"
        )


def _refuse_unbounded(case: _Case, relaxation: Relaxation, row: _Row) -> None:
    if relaxation.viscosity > 0.0 and not math.isfinite(row.pressed.slope_square):
        raise ProblemError(
            f"the friction is unbounded: int g'^2 dx diverges for a {type(case.contact.profile).__name__} of such a "
            "corner or tip, and the rheology has a parallel dashpot; use a round profile, or a rheology with a glassy "
            "modulus, such as StandardSolid"
        )


def _at_depth(case: _Case, relaxation: Relaxation, speed: float, depth: float) -> _Row:
    pressed = sliding_line(case.line, states_at_depth(case.line, np.array([depth])))
    return _Row(pressed, slide(pressed, relaxation, speed))


def _under_force(case: _Case, relaxation: Relaxation, speed: float, near: float | None) -> _Row:
    """The state that carries the force; F_N increases with the depth, approximately as a power of it."""
    assert case.force is not None
    low, high, refusal = 0.0, math.inf, None
    if near is None:
        known = [E for E in (relaxation.rubbery, relaxation.glassy) if 0.0 < E < math.inf]
        near = float(_elastic(case, known[0] if known else relaxation.viscosity).indentation[0])
    depth = near if 0.0 < near < math.inf else 1.0
    power, before, row = 1.5, None, None
    for _ in range(_MOST):
        try:
            _refuse(case, depth)
        except (ConvergenceError, PathError, ProblemError) as error:
            # a smaller depth may suffice
            high, refusal, before = depth, error, None
            if high <= low * (1.0 + 1e-12):
                raise
            depth = math.sqrt(low * high) if low > 0.0 else 0.25 * high
            continue
        row = _at_depth(case, relaxation, speed, depth)
        missed = math.log(row.slid.load / case.force) if row.slid.load > 0.0 else -math.inf
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
        _refuse_unbounded(case, relaxation, row)
    raise ConvergenceError(
        f"the search for the depth that carries {case.force:g} N at {speed:g} m/s did not converge (last value {depth:g} m); prescribe the indentation"
    )


@dataclass(frozen=True)
class _Limit:
    """A limit of the coefficient of friction."""

    factor: float = math.nan
    """The limit divided by the speed, or times the speed."""
    depth: float = 0.0
    """The depth in m of its state."""
    why: str | None = None
    """The reason if there is no limit."""


def _slow(case: _Case, relaxation: Relaxation) -> _Limit:
    """The slow limit of the surface, half of that of the springs."""
    if relaxation.rubbery == 0.0:
        return _Limit(
            why="the bodies relax completely: without an equilibrium modulus, friction is not proportional to the speed at low "
            "speeds"
        )
    try:
        states = _elastic(case, relaxation.rubbery)
        _refuse(case, float(states.indentation[0]))
    except (ConvergenceError, PathError, ProblemError) as error:
        return _Limit(why=f"at rest the load is not carried on a smooth disk: {error}")
    drag = 0.5 * slow_drag(sliding_line(case.line, states), relaxation)
    if not math.isfinite(drag):
        return _Limit(
            why="int g'^2 dx diverges for a profile with such a corner or tip: at low speeds friction is a lower power of the speed"
        )
    load = relaxation.rubbery * float(elastic_force(case.line, states)[0])
    return _Limit(drag / load, float(states.indentation[0]))


def _fast(case: _Case, kernel: _Kernel, rows: list[_Row]) -> _Limit:
    """The limit of the friction of the springs at high speeds."""
    if kernel.exponent > 0.0:
        return _Limit(why="a power of time has no glassy modulus, and fast sliding no limit")
    glassy = kernel.relaxation.glassy
    if not math.isfinite(glassy):
        return _Limit(1.0, max(row.pressed.depth for row in rows))
    states = _elastic(case, glassy)
    load = glassy * float(elastic_force(case.line, states)[0])
    drag = fast_drag(case.line, states, kernel.relaxation)
    return _Limit(drag / load, float(states.indentation[0]))


def _error(case: _Case, kernel: _Kernel, speed: float, row: _Row) -> float:
    """The change with fewer nodes, and the errors of map and kernel."""
    states = states_at_depth(case.line, np.array([row.pressed.depth]))
    fewer = slide(sliding_line(case.line, states, FEWER), kernel.relaxation, speed)
    nodes = max(abs(fewer.drag / row.slid.drag - 1.0), abs(fewer.load / row.slid.load - 1.0))
    if not nodes < _LARGEST_ERROR:
        raise ConvergenceError(
            f"at {written(speed, 'm/s')} the friction is {row.slid.drag / row.slid.load:.1g} of the load, below the "
            "rounding error; use slow_limit or fast_limit at such speeds"
        )
    mapped = float(np.max(case.line.equivalent.slope_error(states.contact_radius)))
    if kernel.exponent == 0.0:
        return nodes + mapped
    missed = (kernel.shortest * speed / (2.0 * row.pressed.radius)) ** (1.0 - kernel.exponent)
    return nodes + mapped + kernel.relaxation.error + float(missed)
