"""The load at which a body under contact yields first."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.interior import Interior, Largest, elastic_body, unknown_stress
from pymdr.interpretation.layered_stress import interior_of
from pymdr.interpretation.surface import surface_of
from pymdr.interpretation.validity import SOURCES
from pymdr.line.curves import Line
from pymdr.line.foundation import states_at_depth
from pymdr.line.lines import line_of
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic
from pymdr.problem.paths import Path
from pymdr.quantities import quantity
from pymdr.result import Result
from pymdr.solving.study import Column, Study
from pymdr.solving.verb import solve
from pymdr.units import QuantityLike, metres, shown, to_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CRITERIA = {"von Mises": "von_mises", "Tresca": "tresca"}
_STEP, _TRIES = 4.0, 20
"""Factor from one indentation to the next in the search for one below and one above first yield, and how many are tried."""
_SLIGHT = 1e-6
"""Of the expected indentation: where the stress has no bound, it has none under any load."""
_HALVINGS = 60
"""How often a radius is halved until the contact is under a moderate stress."""
_CLOSE = 1e-9
"""Of the logarithm of the indentation: how closely it is found."""
_MET = 1e-6
"""Relative difference of stress and strength beyond which the stress has jumped over the strength."""


@dataclass(frozen=True, kw_only=True)
class FirstYield(Study):
    """
    The loads at which a body yields first, by :func:`first_yield`, over ``criterion``.

    normal_force (N), indentation and contact_radius (m), peak_pressure (Pa), and yield_radius and yield_depth (m), the place; of a layered body
    yield_layer, from 0 at the surface.
    """

    side: str | None
    """The body that yields, as it was given."""
    what: ClassVar[str] = "a first yield"
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
    told: ClassVar[tuple[str, ...]] = ("normal_force", "yield_depth")

    def _figure(self) -> Figure:
        """The von Mises stress at first yield by von Mises."""
        assert self.contact is not None
        depth = float(self.data["indentation"].values[0])
        return solve(self.contact, Path(indentation=[depth])).plot_stress(side=self.side)


def first_yield(
    contact: Contact, *, strength: QuantityLike | Sequence[QuantityLike], side: str | None = None
) -> FirstYield:
    """
    The smallest load under which the stress in a body reaches its yield strength, by von Mises and by Tresca.

    Parameters
    ----------
    contact : Contact
        Without adhesion and friction.
    strength : quantity or sequence of quantity
        Yield strength in Pa in uniaxial tension, above 0, the same at every depth; of a layered body also one for every layer,
        from the surface downward, and for its elastic base.
    side : str, optional
        ``"body"`` or ``"counterbody"``; the body unless given, and the counterbody where only that is elastic.

    Returns
    -------
    FirstYield
        Load, indentation, contact radius, largest pressure and the place of first yield.

    Raises
    ------
    ProblemError
        If the contact has adhesion, a strength is not above 0, or there are not as many as layers.
    NotValidError
        If the stress is not known, or has no bound under any load: at sharp and adhesive edges, and under sharp tips where
        nu is below 1/2.

    See Also
    --------
    solve : the contact at any load.

    Notes
    -----
    For Hertz's contact of steel the largest pressure at first yield is 1.61 times the strength (Johnson 1985, section 6.1).

    References
    ----------
    Johnson (1985), Contact Mechanics, Cambridge University Press, doi:10.1017/CBO9781139171731.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> yields = mdr.first_yield(ball, strength="1 GPa")
    >>> (yields["peak_pressure"] / 1e9).values.round(6).tolist()
    [1.612797, 1.612797]
    """
    body = elastic_body(contact, side)
    limits = _strengths(strength, body)
    why = unknown_stress(contact)
    if why:
        raise NotValidError(f"first yield is not valid here: {why} [{SOURCES['stress']}]")
    if contact.adhesion is not None:
        remedy = "its edge yields under any load; " if isinstance(contact.adhesion, JKR) else ""
        raise ProblemError(
            f"first_yield: the contact has adhesion: {remedy}with MaugisDugdale solve a path and read result['largest_mises']"
        )
    line = line_of(contact)

    @lru_cache(maxsize=64)
    def interior(depth: float) -> Interior:
        states = states_at_depth(line, np.array([depth]))
        return interior_of(contact, surface_of(contact, states.indentation, states.contact_radius), side)

    def most_stressed(name: str, depth: float) -> Largest:
        """The place where the stress over the strength is largest, with this ratio."""
        found = interior(depth).largest_by_layer(name, 0)
        return max(one._replace(value=one.value / limit) for one, limit in zip(found, limits, strict=True))

    rough = _rough_depth(line, min(limits))
    slight = interior(_SLIGHT * rough)
    if slight.singular_radius(0) is not None:
        raise NotValidError(f"first yield is not valid here: {slight.unbounded(0)}")
    depths, places, notes = [], [], []
    for criterion, name in _CRITERIA.items():
        depth = _depth_reaching(lambda d: most_stressed(name, d).value, rough)  # noqa: B023
        place = most_stressed(name, depth)
        if abs(place.value - 1.0) > _MET:
            notes.append(
                f"{criterion}: a corner of the profile comes into contact, where the stress has no bound"
            )
            place = most_stressed(name, depth * (1.0 + 10.0 * _CLOSE))
        depths.append(depth)
        places.append(place)
    return _study(solve(contact, Path(indentation=depths)), places, notes, side)


def _strengths(strength: QuantityLike | Sequence[QuantityLike], body: Elastic | Layered) -> list[float]:
    """The strength in Pa of every layer and of an elastic base, or of the half-space."""
    several = isinstance(strength, Sequence | np.ndarray) and not isinstance(strength, str)
    given: Sequence[QuantityLike] = strength if several else [strength]  # type: ignore[assignment, list-item]
    limits = [to_si(one, "Pa", name="strength") for one in given]
    for one, limit in zip(given, limits, strict=True):
        if not limit > 0.0:
            raise ProblemError(f"first_yield: strength = {shown(one)}; it must be above 0 Pa")
    count = 1
    if isinstance(body, Layered):
        count = len(body.layers) + isinstance(body.base, Elastic)
    if len(limits) not in (1, count):
        raise ProblemError(
            f"first_yield: {len(limits)} strengths for {count} elastic part{'s' if count > 1 else ''} of the body; give one for all, or "
            "one for every layer from the surface downward and for an elastic base"
        )
    return limits * (count // len(limits))


def _rough_depth(line: Line, strength: float) -> float:
    """An indentation in m at which stresses are of the size of the strength."""
    radius = min(line.rough_radius(lambda a, d: line.modulus * d >= strength * a), line.edge)
    for _ in range(_HALVINGS):
        with np.errstate(invalid="ignore"):
            depth = float(line.depth(np.array([radius]))[0])
        if line.modulus * depth <= strength * radius:
            break
        radius *= 0.5
    return depth if depth > 0.0 else radius * strength / line.modulus


def _depth_reaching(ratio: Callable[[float], float], rough: float) -> float:
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


def _study(result: Result, places: list[Largest], notes: list[str], side: str | None) -> FirstYield:
    import xarray as xr

    stress = result.claims["stress"]
    stress.require("first yield")
    if not stress.where.all():
        raise NotValidError("first yield is not valid here: the contact is not a disk at the load found")
    columns = {
        name: result[name].values
        for name in ("normal_force", "indentation", "contact_radius", "peak_pressure")
    }
    columns |= {
        "yield_radius": np.array([p.r for p in places]),
        "yield_depth": np.array([p.z for p in places]),
    }
    if isinstance(elastic_body(result.contact, side), Layered):
        columns["yield_layer"] = np.array([float(p.layer) for p in places])
    variables = {
        name: ("criterion", values, {"units": quantity(name).unit, "long_name": quantity(name).long_name})
        for name, values in columns.items()
    }
    claims = {name: result.claims.get(name, stress) for name in columns}
    return FirstYield(
        data=xr.Dataset(variables, coords={"criterion": list(_CRITERIA)}),
        claims=claims,
        assumptions=result.assumptions,
        notes=(*result.notes, *notes),
        contact=result.contact,
        references=("stress", *result.references),
        side=side,
    )
