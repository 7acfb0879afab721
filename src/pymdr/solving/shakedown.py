"""The load of repeated rolling and sliding up to which a body stops yielding after the first passes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl
from pymdr.errors import ConvergenceError, NotValidError, ProblemError
from pymdr.inside import drawn_section
from pymdr.interpretation.interior import Interior, stressed_body
from pymdr.interpretation.layered_stress import LayeredInterior
from pymdr.interpretation.shakedown import Bound, failing_bound, safe_bound
from pymdr.interpretation.solids import IsotropicSolid
from pymdr.interpretation.validity import Claim, Level
from pymdr.line.lines import line_of
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.paths import Path
from pymdr.quantities import quantity
from pymdr.solving.study import Column, Study, dataset
from pymdr.solving.verb import solve
from pymdr.solving.yielding import (
    SLIGHT,
    checked_ratio,
    depth_reaching,
    refuse_unknown_stress,
    refuse_yield_at_touch,
    rough_depth,
    states_of,
)
from pymdr.units import FloatArray, QuantityLike, shown, to_si

_MET, _GUESSES = 3e-6, 20
"""Relative difference of a shear measure from the yield stress at which a load is taken, and the most loads that are tried."""
_PRECISE = 1e-5
"""Error of a bound from its nets and its load."""
_SOURCE = (
    "Melan (1938), Ing.-Arch. 9, 116-126; for rolling and sliding Johnson (1985), Contact Mechanics, section 9.2, and Ponter, Hearle and "
    "Johnson (1985), J. Mech. Phys. Solids 33, 339-362"
)


class _Limits(NamedTuple):
    """Indentations in m at first yield and at the two bounds of shakedown, and what limits shakedown."""

    first: float
    safe: float
    failing: float
    place: Bound


@dataclass(frozen=True, kw_only=True)
class Shakedown(Study):
    """
    Loads up to which a body shakes down under repeated rolling and sliding, by :func:`shakedown`, over ``force_ratio``.

    normal_force (N), with indentation, contact_radius (m) and peak_pressure (Pa), up to which the body certainly shakes down;
    normal_force_high and peak_pressure_high, above which it never does; first_yield_force (N), and yield_multiple, the safe load over it;
    pressure_ratio, pressure_ratio_high and pressure_ratio_yield, their peak pressures over the yield stress in shear; shakedown_y and shakedown_depth (m), the place
    that limits the safe load.
    """

    strength: float
    """Yield strength in uniaxial tension in Pa."""
    side: str | None
    """The body, as it was given."""
    subject: ClassVar[str] = "a shakedown study"
    columns: ClassVar[Mapping[str, Column]] = {
        "force_ratio": Column("Q/F", ""),
        "first_yield_force": Column("first yield", "N"),
        "normal_force": Column("safe load", "N"),
        "normal_force_high": Column("upper bound", "N"),
        "yield_multiple": Column("over yield", ""),
        "pressure_ratio": Column("p_0/k", ""),
        "pressure_ratio_high": Column("upper p_0/k", ""),
        "shakedown_depth": Column("depth", "m"),
    }
    summary_claims: ClassVar[tuple[str, ...]] = ("normal_force", "normal_force_high")

    def _figure(self) -> mpl.figure.Figure:
        """The shakedown map; for one ratio of forces the von Mises stress at the safe load."""
        if self.data.sizes["force_ratio"] > 1:
            from pymdr.presentation.plot import shakedown_map

            return shakedown_map(self.data)
        assert self.contact is not None
        depth, ratio = (float(self.data[name].values[0]) for name in ("indentation", "force_ratio"))
        return drawn_section(states_of(self.contact, self.side, ratio)(depth), "von_mises", 0)


def shakedown(
    contact: Contact,
    *,
    strength: QuantityLike,
    force_ratio: QuantityLike | Sequence[QuantityLike] | None = None,
    side: str | None = None,
) -> Shakedown:
    """
    Bounds of the load up to which an elastic, perfectly plastic body stops yielding under repeated rolling or sliding.

    Parameters
    ----------
    contact : Contact
        Without adhesion and memory, of a homogeneous body that the contact passes along x again and again.
    strength : quantity
        Yield strength in Pa in uniaxial tension, above 0, for the criterion of von Mises; k = strength/sqrt(3) is the yield stress in shear.
    force_ratio : float or sequence of float, optional
        With friction: tangential over normal force, from 0 (free rolling) to the coefficient of friction, increasing; the coefficient (sliding)
        unless given.
    side : str, optional
        ``"body"`` or ``"counterbody"``; the first whose stress is known unless given.

    Returns
    -------
    Shakedown
        Loads of first yield and shakedown over the ratios of forces.

    Raises
    ------
    ProblemError
        If the contact has adhesion, the strength is not above 0, or a ratio of forces is outside its limits.
    NotValidError
        If the stress is not known or has no bound, or the body has layers or is anisotropic.
    ConvergenceError
        If a bound does not converge.

    See Also
    --------
    first_yield : the load at which a body yields first.

    Notes
    -----
    ``normal_force`` is a lower bound by Melan's theorem: residual stresses xx(y, z) and yy(z) are in equilibrium and keep the stress within
    yield. ``normal_force_high`` is an upper bound: at some point no residual stress does. For Hertz's contact in free rolling at nu = 0.3 they
    are p_0 = 4.63 k and 4.675 k, the latter that of the largest shear stress rz; for sliding above mu = 0.3 both are p_0 = k/mu. Between,
    they differ by up to a quarter. The shear traction is the ratio times the pressure, as in sliding. The bodies remain elastic in the
    pressure: the surface is not changed by the yield of the first passes.

    References
    ----------
    - Melan (1938), Ing.-Arch. 9, 116-126.
    - Johnson (1985), Contact Mechanics, section 9.2, doi:10.1017/CBO9781139171731.
    - Ponter, Hearle and Johnson (1985), J. Mech. Phys. Solids 33, 339-362.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> limit = mdr.shakedown(ball, strength="1 GPa")
    >>> [round(float(limit[name][0]), 3) for name in ("pressure_ratio", "pressure_ratio_high", "yield_multiple")]
    [4.632, 4.675, 4.559]
    """
    stressed_body(require_contact(contact), side)
    refuse_unknown_stress(contact, "shakedown")
    if contact.adhesion is not None:
        raise ProblemError(
            f"the contact has adhesion ({type(contact.adhesion).__name__}); leave it out, because its edge is not known in rolling"
        )
    limit = to_si(strength, "Pa", name="strength")
    if not 0.0 < limit < math.inf:
        raise ProblemError(f"strength = {shown(strength)}; one finite strength above 0 Pa is needed")
    several = isinstance(force_ratio, Sequence | np.ndarray) and not isinstance(force_ratio, str)
    given: Sequence[QuantityLike | None] = force_ratio if several else [force_ratio]  # type: ignore[assignment, list-item]
    ratios = [checked_ratio(contact, one) for one in given]
    if not ratios or not np.all(np.diff(ratios) > 0.0):
        raise ProblemError(
            f"force_ratio = {shown(force_ratio)}; at least one ratio is needed, several in increasing order"
        )
    limits = [_limits_of(contact, side, ratio, limit) for ratio in ratios]
    return _study(contact, ratios, limits, (limit, side))


def _limits_of(contact: Contact, side: str | None, ratio: float, strength: float) -> _Limits:
    """The indentations at first yield and at both bounds of shakedown for one ratio of forces."""
    interior, line = states_of(contact, side, ratio), line_of(contact)
    rough = rough_depth(line, strength)
    slight = interior(SLIGHT * rough)
    if isinstance(slight, LayeredInterior) or not isinstance(slight.solid, IsotropicSolid):
        raise NotValidError(
            "shakedown is not valid here: it is computed in homogeneous isotropic bodies of one strength; give the other side="
        )
    refuse_yield_at_touch(slight, strength, adhesive=False, subject="shakedown")
    first = depth_reaching(lambda d: interior(d).largest("von_mises", 0).value / strength, rough)

    def reaching(bound: Callable[[Interior, int], Bound], start: float) -> tuple[float, Bound]:
        """The indentation at which a bound of the shear measure is the yield stress, by secants of logarithms."""
        shear = strength / math.sqrt(3.0)
        at = lru_cache(maxsize=None)(lambda depth: bound(interior(depth), 0))
        points = [(math.log(start), math.log(at(start).shear / shear))]
        power = 0.5
        for _ in range(_GUESSES):
            if len(points) > 1:
                (x0, y0), (x1, y1) = points[-2:]
                power = (y1 - y0) / (x1 - x0) if x1 != x0 else power
            if not power > 0.0:
                break
            x, y = points[-1]
            if abs(y) <= _MET:
                return math.exp(x), at(math.exp(x))
            x -= min(max(y / power, -3.0), 3.0)
            points.append((x, math.log(at(math.exp(x)).shear / shear)))
        raise ConvergenceError(
            f"the load at a ratio of forces of {ratio:g} was not found in {len(points)} guesses, where the shear measure does not "
            "rise steadily with the load; round corners of the profile"
        )

    # stresses grow at most with the square root of the indentation of a round tip
    safe, place = reaching(safe_bound, 2.5 * first)
    failing, _ = reaching(failing_bound, safe)
    return _Limits(first, safe, max(failing, safe), place)


def _study(
    contact: Contact, ratios: list[float], limits: list[_Limits], how: tuple[float, str | None]
) -> Shakedown:
    strength, side = how
    depths = np.array([one[:3] for one in limits])
    order = np.unique(depths)
    result = solve(contact, Path(indentation=order))
    stress = result.claims["stress"]
    stress.require("shakedown")
    if not stress.where.all():
        raise NotValidError(
            "shakedown is not valid here: the contact is not a disk at the load of first yield or shakedown; use an increasing profile"
        )
    force, pressure, radius = (
        result[name].values[np.searchsorted(order, depths)]
        for name in ("normal_force", "peak_pressure", "contact_radius")
    )
    shear = strength / math.sqrt(3.0)
    columns = {
        "first_yield_force": force[:, 0],
        "normal_force": force[:, 1],
        "normal_force_high": force[:, 2],
        "yield_multiple": force[:, 1] / force[:, 0],
        "indentation": depths[:, 1],
        "contact_radius": radius[:, 1],
        "peak_pressure": pressure[:, 1],
        "peak_pressure_high": pressure[:, 2],
        "pressure_ratio": pressure[:, 1] / shear,
        "pressure_ratio_high": pressure[:, 2] / shear,
        "pressure_ratio_yield": pressure[:, 0] / shear,
        "shakedown_y": np.array([one.place.y for one in limits]),
        "shakedown_depth": np.array([one.place.z for one in limits]),
    }

    def attributes(name: str) -> dict[str, str]:
        row = quantity(name.removesuffix("_high").removesuffix("_yield"))
        which = ", upper bound" * name.endswith("_high") + " at first yield" * name.endswith("_yield")
        return {"units": row.unit, "long_name": row.long_name + which}

    return Shakedown(
        data=dataset(
            {name: ("force_ratio", values, attributes(name)) for name, values in columns.items()},
            coords={"force_ratio": ("force_ratio", ratios, {"units": ""})},
        ),
        claims=_claims(columns, stress),
        assumptions=result.assumptions,
        notes=(
            *result.notes,
            "the body is elastic, perfectly plastic; the surface is that of the elastic contact",
        ),
        contact=result.contact,
        references=("stress", *(("shear-stress",) if any(ratios) else ()), *result.references),
        strength=strength,
        side=side,
    )


def _claims(columns: Mapping[str, FloatArray], stress: Claim) -> dict[str, Claim]:
    """Of the bounds: what they prove, and how far the shakedown load may be from the safe one."""
    everywhere = np.ones(columns["normal_force"].size, dtype=bool)
    numerical = _PRECISE + np.max(stress.error if stress.error is not None else 0.0, initial=0.0)
    claims = {}
    for name, values in columns.items():
        if name in ("first_yield_force", "pressure_ratio_yield"):
            reason, error = (
                f"the stress is {stress.level.value} in its model",
                np.full(everywhere.shape, numerical),
            )
        elif name.endswith("_high"):
            reason, error = "upper bound: at one point no residual stress prevents further yield", None
        else:
            reason, error = "lower bound: residual stresses xx(y, z), yy(z) prevent further yield", None
            if f"{name}_high" in columns:
                high = columns[f"{name}_high"]
                error = (high - values) / values + numerical
                reason += f"; the upper bound is {100.0 * np.max(high / values - 1.0):.2g} % higher"
        claims[name] = Claim(Level.APPROXIMATE, reason, _SOURCE, everywhere, error)
    return claims
