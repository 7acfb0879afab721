"""The load at which a body under contact yields first."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import NotValidError, ProblemError
from pymdr.inside import drawn_section
from pymdr.interpretation.dragged import Dragged
from pymdr.interpretation.interior import Interior, stressed_body, unknown_stress
from pymdr.interpretation.layered_stress import interior_of
from pymdr.interpretation.searching import Largest
from pymdr.interpretation.surface import surface_of
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import SOURCES
from pymdr.line.curves import Line
from pymdr.line.foundation import states_at_depth
from pymdr.line.lines import line_of
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.laws import JKR
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic, Material
from pymdr.problem.paths import Path
from pymdr.quantities import quantity
from pymdr.solving.study import Column, Study, dataset
from pymdr.solving.verb import solve
from pymdr.units import QuantityLike, metres, shown, to_si, written

_CRITERIA = {"von Mises": "von_mises", "Tresca": "tresca"}
_STEP, _TRIES = 4.0, 20
"""Factor from one indentation to the next in the search for one below and one above first yield, and how many are tried."""
SLIGHT = 1e-6
"""Fraction of the expected indentation at which an unbounded stress is detected: it is unbounded under any load."""
_HALVINGS = 60
"""Largest number of halvings of a radius in the search for a moderate stress."""
_NOTHING = 1e-9
"""Ratio of stress to strength at a typical load below which the stress counts as 0."""
_CLOSE = 1e-9
"""Tolerance of the logarithm of the indentation."""
_MET = 1e-6
"""Relative difference of stress and strength above which the stress has jumped over the strength."""


@dataclass(frozen=True, kw_only=True)
class FirstYield(Study):
    """
    The loads at which a body yields first, by :func:`first_yield`, over ``criterion``.

    normal_force (N), indentation and contact_radius (m), peak_pressure (Pa), and yield_radius and yield_depth (m), the place; of a layered body
    yield_layer, from 0 at the surface.
    """

    side: str | None
    """The body that yields, as it was given."""
    force_ratio: float = 0.0
    """Tangential over normal force."""
    subject: ClassVar[str] = "a first yield"
    columns: ClassVar[Mapping[str, Column]] = {
        "criterion": Column("criterion", ""),
        "normal_force": Column("force", "N"),
        "indentation": Column("indentation", "m"),
        "contact_radius": Column("radius", "m"),
        "peak_pressure": Column("p_max", "Pa"),
        "yield_radius": Column("r of yield", "m"),
        "yield_depth": Column("z of yield", "m"),
        "yield_layer": Column("layer", ""),
    }
    summary_claims: ClassVar[tuple[str, ...]] = ("normal_force", "yield_depth")

    def _figure(self) -> mpl.figure.Figure:
        """The von Mises stress at first yield by von Mises."""
        assert self.contact is not None
        depth = float(self.data["indentation"].values[0])
        return drawn_section(states_of(self.contact, self.side, self.force_ratio)(depth), "von_mises", 0)


def first_yield(
    contact: Contact,
    *,
    strength: QuantityLike | Sequence[QuantityLike],
    tensile_strength: QuantityLike | Sequence[QuantityLike] | None = None,
    bond_strength: QuantityLike | None = None,
    side: str | None = None,
    force_ratio: float | None = None,
) -> FirstYield:
    """
    The smallest load under which the stress in a body reaches its strength: by von Mises, by Tresca, and by other criteria on request.

    Parameters
    ----------
    contact : Contact
        Without adhesion, or with that of MaugisDugdale; without memory.
    strength : quantity or sequence of quantity
        Yield strength in Pa in uniaxial tension, above 0, the same at every depth; of a layered body also one for every layer,
        from the surface downward, and for its elastic base.
    tensile_strength : quantity or sequence of quantity, optional
        Stress in Pa, above 0, that the largest principal stress reaches at the first crack; of a layered body also one for every layer.
    bond_strength : quantity, optional
        Of a layered body: the shear stress in Pa, above 0, that its interfaces bear.
    side : str, optional
        ``"body"`` or ``"counterbody"``; the first whose stress is known unless given.
    force_ratio : float, optional
        With friction: tangential over normal force while both rise together, from 0 to the coefficient of friction; the coefficient
        unless given, in which case the bodies slide.

    Returns
    -------
    FirstYield
        Load, indentation, contact radius, largest pressure and the place, over the criteria.

    Raises
    ------
    ProblemError
        If the contact has the adhesion of JKR or DMT, a strength is not above 0, there are not as many as layers, a bond strength is
        given for a body without layers, or the ratio of forces is outside its limits.
    NotValidError
        If the stress is not known, has no bound under any load (at sharp and adhesive edges, and under sharp tips where nu is below
        1/2), or if adhesion alone reaches the strength.

    See Also
    --------
    solve : the contact at any load.

    Notes
    -----
    For Hertz's contact of steel the largest pressure at first yield is 1.61 times the strength (Johnson 1985, section 6.1). Under a
    ratio of forces below the coefficient the contact sticks everywhere, and the shear traction is that ratio times the pressure
    (Mindlin and Deresiewicz 1953), as in sliding. Adhesion is loaded without a machine, at prescribed indentation.

    References
    ----------
    - Johnson (1985), Contact Mechanics, Cambridge University Press, doi:10.1017/CBO9781139171731.
    - Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327-344.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> yields = mdr.first_yield(ball, strength="1 GPa")
    >>> (yields["peak_pressure"] / 1e9).values.round(6).tolist()
    [1.612797, 1.612797]
    """
    body, _ = stressed_body(require_contact(contact), side)
    criteria = _criteria(body, strength, tensile_strength, bond_strength)
    limits = criteria[0][2]
    refuse_unknown_stress(contact)
    ratio = checked_ratio(contact, force_ratio)
    interior = states_of(contact, side, ratio)
    line = line_of(contact)

    def most_stressed(name: str, limits: Sequence[float], depth: float) -> Largest:
        """The place where the stress over the strength is largest, with this ratio."""
        peaks = interior(depth).largest_by_layer(name, 0)
        return max(one._replace(value=one.value / limit) for one, limit in zip(peaks, limits, strict=True))

    rough = rough_depth(line, min(limits))
    refuse_yield_at_touch(interior(SLIGHT * rough), min(limits), contact.adhesion is not None)
    depths, places, notes = [], [], []
    for criterion, name, most in criteria:
        if most_stressed(name, most, rough).value <= _NOTHING:
            raise NotValidError(
                f"first yield is not valid here: there is no {criterion} in this body under any load"
            )
        depth = depth_reaching(lambda d: most_stressed(name, most, d).value, rough)  # noqa: B023
        place = most_stressed(name, most, depth)
        if abs(place.value - 1.0) > _MET:
            notes.append(
                f"{criterion}: a corner of the profile comes into contact, where the stress has no bound"
            )
            place = most_stressed(name, most, depth * (1.0 + 10.0 * _CLOSE))
        if ratio:
            notes.append(f"{criterion}: yield begins at {_where(place)}")
        depths.append(depth)
        places.append(place)
    return _study(contact, [label for label, *_ in criteria], (depths, places), notes, (side, ratio))


def _criteria(
    body: Material,
    strength: QuantityLike | Sequence[QuantityLike],
    tensile_strength: QuantityLike | Sequence[QuantityLike] | None,
    bond_strength: QuantityLike | None,
) -> list[tuple[str, str, list[float]]]:
    """Label, measure of stress and limits in Pa of every criterion, that of yield first."""
    limits = _strengths("strength", strength, body)
    criteria = [(label, measure, limits) for label, measure in _CRITERIA.items()]
    if tensile_strength is not None:
        tensions = _strengths("tensile_strength", tensile_strength, body)
        criteria.append(("largest tension", "principal_stress", tensions))
    if bond_strength is not None:
        if not isinstance(body, Layered):
            raise ProblemError("bond_strength is for a body of layers; leave it out, or give the other side=")
        bond = _strengths("bond_strength", bond_strength, body)[: len(body.layers)]
        criteria.append(("interface shear", "interface_shear", bond))
    return criteria


def refuse_unknown_stress(contact: Contact, subject: str = "first yield") -> None:
    """Refuse a contact whose stress is not known, or has no bound under any load."""
    why = (
        unknown_stress(contact) or contact.is_viscoelastic * "in bodies with memory it depends on the history"
    )
    if why:
        raise NotValidError(f"{subject} is not valid here: {why} [{SOURCES['stress']}]")
    if isinstance(contact.adhesion, JKR):
        raise ProblemError(
            "the contact has the adhesion of JKR: its edge yields under any load; use MaugisDugdale"
        )
    law = contact.adhesion
    if law is not None and law.cohesive_stress is None and not theory_of(law).pulls_beyond:
        raise ProblemError(
            f"{type(law).__name__} has no cohesive stress, so the stress at its edge is not known; use MaugisDugdale"
        )


def refuse_yield_at_touch(
    slight: Interior, strength: float, adhesive: bool, subject: str = "first yield"
) -> None:
    """Refuse a contact that yields as soon as the bodies touch."""
    if slight.singular_radius(0) is not None:
        raise NotValidError(f"{subject} is not valid here: {slight.unbounded(0)}")
    if adhesive and slight.largest("tresca", 0).value >= strength:
        raise NotValidError(
            f"first yield is not valid here: adhesion alone reaches the strength of {written(strength, 'Pa')} as the bodies touch"
        )


def _where(place: Largest) -> str:
    """The place in fixed directions."""
    across = 0.0 if abs(place.angle) == math.pi else place.r * math.sin(place.angle)
    return f"x = {metres(place.r * math.cos(place.angle))}, y = {metres(across)}"


def checked_ratio(contact: Contact, force_ratio: QuantityLike | None) -> float:
    """Tangential over normal force."""
    if contact.friction is None:
        if force_ratio is not None:
            raise ProblemError(
                f"force_ratio = {shown(force_ratio)}, but the contact has no friction; give it friction=Coulomb(0.3)"
            )
        return 0.0
    most = contact.friction.coefficient
    ratio = most if force_ratio is None else to_si(force_ratio, "", name="force_ratio")
    if not 0.0 <= ratio <= most or math.isinf(ratio):
        raise ProblemError(
            f"force_ratio = {shown(ratio)}; a number from 0 to the coefficient of friction, {most:g}, is needed"
        )
    return ratio


def states_of(contact: Contact, side: str | None, ratio: float) -> Callable[[float], Interior]:
    """The inside of a body at any indentation in m."""
    line = line_of(contact)

    @lru_cache(maxsize=64)
    def interior(depth: float) -> Interior:
        if contact.adhesion is not None:
            result = solve(contact, Path(indentation=[depth]))
            radii = [
                result.data[name].values for name in ("indentation", "contact_radius", "cohesive_radius")
            ]
            return interior_of(contact, surface_of(contact, *radii), side)
        states = states_at_depth(line, np.array([depth]))
        surface = surface_of(contact, states.indentation, states.contact_radius)
        return interior_of(contact, Dragged(surface, ratio) if ratio else surface, side)

    return interior


def _strengths(name: str, strength: QuantityLike | Sequence[QuantityLike], body: Material) -> list[float]:
    """The strength in Pa of every layer and of an elastic base, or of the half-space."""
    several = isinstance(strength, Sequence | np.ndarray) and not isinstance(strength, str)
    given: Sequence[QuantityLike] = strength if several else [strength]  # type: ignore[assignment, list-item]
    limits = [to_si(one, "Pa", name=name) for one in given]
    for one, limit in zip(given, limits, strict=True):
        if not limit > 0.0:
            raise ProblemError(f"{name} = {shown(one)}; it must be above 0 Pa")
    count = 1
    if isinstance(body, Layered):
        count = len(body.layers) + isinstance(body.base, Elastic)
    if len(limits) not in (1, count):
        raise ProblemError(
            f"{len(limits)} values of {name} for {count} elastic part{'s' if count > 1 else ''} of the body; give one for all, or "
            "one for every layer from the surface downward and for an elastic base"
        )
    return limits * (count // len(limits))


def rough_depth(line: Line, strength: float) -> float:
    """An indentation in m at which stresses are of the size of the strength."""
    radius = min(line.rough_radius(lambda a, d: line.modulus * d >= strength * a), line.edge)
    for _ in range(_HALVINGS):
        with np.errstate(invalid="ignore"):
            depth = float(line.depth(np.array([radius]))[0])
        if line.modulus * depth <= strength * radius:
            break
        radius *= 0.5
    return depth if depth > 0.0 else radius * strength / line.modulus


def depth_reaching(ratio: Callable[[float], float], rough: float) -> float:
    """The indentation in m at which the largest stress reaches the strength, searched from a rough one."""
    from scipy.optimize import brentq

    def surplus(log_depth: float) -> float:
        return min(ratio(math.exp(log_depth)), 2.0) - 1.0

    at = math.log(rough)
    step = math.copysign(math.log(_STEP), -surplus(at))
    for _ in range(_TRIES):
        if surplus(at + step) * step >= 0.0:
            return math.exp(brentq(surplus, *sorted((at, at + step)), xtol=_CLOSE, rtol=_CLOSE))
        at += step
    raise NotValidError(
        f"first yield is not valid here: at indentations from {metres(rough)} to {metres(math.exp(at))} the largest stress stays "
        f"on one side of the strength; under a cone it does not depend on the load"
    )


def _study(
    contact: Contact,
    criteria: list[str],
    results: tuple[list[float], list[Largest]],
    notes: list[str],
    how: tuple[str | None, float],
) -> FirstYield:
    # rising, so that nothing is unloaded
    depths, places = results
    order = np.argsort(depths)
    result = solve(contact, Path(indentation=np.array(depths)[order]))
    stress = result.claims["stress"]
    stress.require("first yield")
    if not stress.where.all():
        raise NotValidError(
            "first yield is not valid here: the contact is not a disk at the load of first yield; use an increasing profile"
        )
    columns = {
        name: result[name].values[np.argsort(order)]
        for name in ("normal_force", "indentation", "contact_radius", "peak_pressure")
    }
    columns |= {
        "yield_radius": np.array([p.r for p in places]),
        "yield_depth": np.array([p.z for p in places]),
    }
    side, ratio = how
    if isinstance(stressed_body(contact, side)[0], Layered):
        columns["yield_layer"] = np.array([float(p.layer) for p in places])
    variables = {
        name: ("criterion", values, {"units": quantity(name).unit, "long_name": quantity(name).long_name})
        for name, values in columns.items()
    }
    claims = {name: result.claims.get(name, stress) for name in columns}
    return FirstYield(
        data=dataset(variables, coords={"criterion": criteria}),
        claims=claims,
        assumptions=result.assumptions,
        notes=(*result.notes, *notes),
        contact=result.contact,
        references=("stress", *(("shear-stress",) if ratio else ()), *result.references),
        side=side,
        force_ratio=ratio,
    )
