"""The load at which a body under contact yields first."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.interior import Interior, Largest, elastic_body, unknown_stress
from pymdr.interpretation.surface import surface_of
from pymdr.interpretation.validity import SOURCES
from pymdr.line.curves import Line
from pymdr.line.foundation import states_at_depth
from pymdr.line.lines import line_of
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
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

    normal_force (N), indentation and contact_radius (m), peak_pressure (Pa), and yield_radius and yield_depth (m), the place.
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
    }
    told: ClassVar[tuple[str, ...]] = ("normal_force", "yield_depth")

    def _figure(self) -> Figure:
        """The von Mises stress at first yield by von Mises."""
        assert self.contact is not None
        depth = float(self.data["indentation"].values[0])
        return solve(self.contact, Path(indentation=[depth])).plot_stress(side=self.side)


def first_yield(contact: Contact, *, strength: QuantityLike, side: str | None = None) -> FirstYield:
    """
    The smallest load under which the stress in a body reaches its yield strength, by von Mises and by Tresca.

    Parameters
    ----------
    contact : Contact
        Without adhesion and friction.
    strength : quantity
        Yield strength in Pa in uniaxial tension, above 0, the same at every depth.
    side : str, optional
        ``"body"`` or ``"counterbody"``; the body unless given, and the counterbody where only that is elastic.

    Returns
    -------
    FirstYield
        Load, indentation, contact radius, largest pressure and the place of first yield.

    Raises
    ------
    ProblemError
        If the contact has adhesion, or the strength is not above 0.
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
    limit = to_si(strength, "Pa", name="strength")
    if not limit > 0.0:
        raise ProblemError(f"first_yield: strength = {shown(strength)}; it must be above 0 Pa")
    body = elastic_body(contact, side)
    why = unknown_stress(contact)
    if why:
        raise NotValidError(f"first yield is not valid here: {why} [{SOURCES['stress']}]")
    if contact.adhesion is not None:
        remedy = "its edge yields under any load; " if isinstance(contact.adhesion, JKR) else ""
        raise ProblemError(
            f"first_yield: the contact has adhesion: {remedy}with MaugisDugdale solve a path and read result['largest_mises']"
        )
    line = line_of(contact)

    def interior(depth: float) -> Interior:
        states = states_at_depth(line, np.array([depth]))
        return Interior(surface_of(contact, states.indentation, states.contact_radius), body)

    rough = _rough_depth(line, limit)
    slight = interior(_SLIGHT * rough)
    if slight.singular_radius(0) is not None:
        raise NotValidError(f"first yield is not valid here: {slight.unbounded(0)}")
    depths, places, notes = [], [], []
    for criterion, name in _CRITERIA.items():
        depth = _depth_reaching(lambda d: interior(d).largest(name, 0).value, rough, limit)  # noqa: B023
        place = interior(depth).largest(name, 0)
        if abs(place.value / limit - 1.0) > _MET:
            notes.append(
                f"{criterion}: a corner of the profile comes into contact, where the stress has no bound"
            )
            place = interior(depth * (1.0 + 10.0 * _CLOSE)).largest(name, 0)
        depths.append(depth)
        places.append(place)
    return _study(solve(contact, Path(indentation=depths)), places, notes, side)


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


def _depth_reaching(largest: Callable[[float], float], rough: float, strength: float) -> float:
    """The indentation in m at which the largest stress in Pa reaches the strength, searched from a rough one."""
    from scipy.optimize import brentq

    def surplus(log_depth: float) -> float:
        return min(largest(math.exp(log_depth)) / strength, 2.0) - 1.0

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
