"""Heat and current through a contact: conductance, resistance, and their flux over the disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import QuantityError
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import SOURCES, Claim, Level, approximated
from pymdr.mapping.moduli import Carrier, conductivity_of, is_carried
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Material
from pymdr.problem.profiles import ForceCurve
from pymdr.units import FloatArray, QuantityLike, shown, to_si


@dataclass(frozen=True)
class Conduction:
    """Conduction of heat or of current through a contact."""

    carrier: Carrier
    quantity: str
    field: str
    resists: bool
    """Whether the quantity is the reciprocal of the conductance."""
    driven_by: str
    """Unit of the driving drop."""
    flows_in: str
    """Unit of the flow."""


CONDUCTIONS = (
    Conduction("thermal_conductivity", "thermal_conductance", "heat_flux", False, "K", "W"),
    Conduction("resistivity", "electrical_resistance", "current_density", True, "V", "A"),
)
CONDUCTION_SOURCES = ("holm", "barber-conductance")

_MODEL = (
    "exact for homogeneous half-spaces in contact on a disk, insulated outside it, each with a uniform temperature (or potential) "
    "far away, and for contacts much larger than a mean free path"
)
_OF_STIFFNESS = "for contacts of any shape, the conductance over that of the line equals the contact stiffness over E*; {}"
_RING_OF_COHESION = (
    "the open ring of cohesion is taken as insulating; the error is the upper bound for a conducting ring, the ratio of its width "
    "to the contact radius"
)
_BEYOND_CONTACT = "conduction between surfaces that attract each other without contact is neglected"


def conductance(contact_radius: ArrayLike, conductivity: float) -> FloatArray:
    """
    Conductance 2 a lambda_eff of a disk between two half-spaces.

    Parameters
    ----------
    contact_radius : array_like
        a in m.
    conductivity : float
        lambda_eff = 2/(rho_1 + rho_2) in W/(m K), or in 1/(ohm m).

    Returns
    -------
    ndarray
        In W/K, or in 1/ohm.

    Notes
    -----
    Holm (1967), section 3; by Barber (2003), Proc. R. Soc. A 459, 53, it is (lambda_eff/E*) dF/dd for contacts of any shape.

    Examples
    --------
    >>> float(conductance(0.5, 0.4))
    0.4
    """
    return np.asarray(2.0 * np.asarray(contact_radius, dtype=float) * conductivity)


def disk_flux(contact_radius: float, conductivity: float, r: ArrayLike) -> FloatArray:
    """
    Flux j = lambda_eff / (pi sqrt(a^2 - r^2)) for a unit of the drop between the bodies.

    Parameters
    ----------
    contact_radius : float
        a in m.
    conductivity : float
        lambda_eff in W/(m K), or in 1/(ohm m).
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        j in W/(m^2 K), or in A/(m^2 V); inf at the edge, 0 outside.

    Notes
    -----
    The flux I/(2 pi a sqrt(a^2 - r^2)) of an isothermal disk (Holm 1967), proportional to the pressure of a flat punch.

    Examples
    --------
    >>> disk_flux(1.0, np.pi, [0.0, 0.6, 1.0, 2.0]).tolist()
    [1.0, 1.25, inf, 0.0]
    """
    radius = np.abs(np.asarray(r, dtype=float))
    a = contact_radius
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = conductivity / (math.pi * np.sqrt((a - radius) * (a + radius)))
    return np.where((radius <= a) & (a > 0.0), inside, 0.0)


def disk_flux_amplitude(contact_radius: float, conductivity: float) -> float:
    """
    Amplitude K of the edge of the flux, j -> K / sqrt(a - r), K = lambda_eff / (pi sqrt(2 a)).

    Examples
    --------
    >>> disk_flux_amplitude(0.5, np.pi)
    1.0
    """
    return conductivity / (math.pi * math.sqrt(2.0 * contact_radius)) if contact_radius > 0.0 else 0.0


@dataclass(frozen=True)
class DiskFlux:
    """The flux over the disks of a history."""

    conductivity: float
    """lambda_eff in W/(m K), or in 1/(ohm m)."""
    contact_radius: FloatArray
    """a of every step in m."""

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values at radii in one step, nan without a contact radius."""
        a = float(self.contact_radius[step])
        return np.full(position.shape, math.nan) if math.isnan(a) else self._at(a, position)

    def _at(self, a: float, position: FloatArray) -> FloatArray:
        return disk_flux(a, self.conductivity, position)

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to 1.5 contact radii, graded to the edge."""
        a = float(self.contact_radius[step])
        if not a > 0.0:
            a = float(np.max(self.contact_radius, initial=0.0, where=self.contact_radius > 0.0)) or 1.0
        inner = a * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        return np.append(inner, a * np.linspace(1.0, 1.5, 11)[1:])

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the singularity at the edge, in the unit of the flux times m^0.5."""
        a = float(self.contact_radius[step])
        return math.nan if math.isnan(a) else disk_flux_amplitude(a, self.conductivity)


def with_conduction(
    contact: Contact,
    columns: Mapping[str, FloatArray],
    claims: Mapping[str, Claim],
    length: FloatArray | None = None,
) -> tuple[dict[str, FloatArray], dict[str, Claim]]:
    """
    Columns and claims with the conductances of a contact, as far as its bodies have conductivities.

    Parameters
    ----------
    length : ndarray, optional
        Half the stiffness over E* in m, for contacts that are not disks; default the contact radius.
    """
    columns, claims = dict(columns), dict(claims)
    base = claims["contact_radius" if length is None else "normal_stiffness"]
    size = columns["contact_radius"] if length is None else length
    for each in CONDUCTIONS:
        if not is_carried(contact.body, contact.counterbody, each.carrier):
            continue
        pair = conductivity_of(contact.body, contact.counterbody, each.carrier)
        names = (each.quantity,) if length is not None else (each.quantity, each.field)
        if isinstance(pair, str):
            none = np.zeros(base.where.shape, dtype=bool)
            claims |= dict.fromkeys(names, Claim(Level.NOT_VALID, pair, SOURCES["holm"], none))
            continue
        claim = _claim(contact, columns, base, length is not None or isinstance(contact.profile, ForceCurve))
        claims |= dict.fromkeys(names, claim)
        through = conductance(size, pair.line)
        with np.errstate(divide="ignore"):
            columns[each.quantity] = 1.0 / through if each.resists else through
    return columns, claims


def conduction_of_stiffness(
    body: Material, counterbody: Material, lengths: Mapping[str, FloatArray], base: Claim
) -> tuple[dict[str, FloatArray], dict[str, Claim]]:
    """
    Conductances of a contact from its stiffness, with their band.

    Parameters
    ----------
    lengths : mapping of str to ndarray
        Half the stiffness over E* in m: "" its mean, "_low" and "_high" the ends of its band.
    base : claim
        Claim of the stiffness.
    """
    columns: dict[str, FloatArray] = {}
    claims: dict[str, Claim] = {}
    other_end = {"": "", "_low": "_high", "_high": "_low"}
    for each in CONDUCTIONS:
        if not is_carried(body, counterbody, each.carrier):
            continue
        pair = conductivity_of(body, counterbody, each.carrier)
        if isinstance(pair, str):
            none = np.zeros(base.where.shape, dtype=bool)
            claims[each.quantity] = Claim(Level.NOT_VALID, pair, SOURCES["holm"], none)
            continue
        source = f"{SOURCES['barber-conductance']}; {base.source}"
        claims[each.quantity] = replace(base, reason=_OF_STIFFNESS.format(base.reason), source=source)
        for end, length in lengths.items():
            through = conductance(length, pair.line)
            name = f"{each.quantity}{other_end[end] if each.resists else end}"
            columns[name] = 1.0 / through if each.resists else through
    return columns, claims


def _claim(contact: Contact, columns: Mapping[str, FloatArray], base: Claim, any_shape: bool) -> Claim:
    source = SOURCES["barber-conductance" if any_shape else "holm"]
    if base.level is Level.NOT_VALID:
        return replace(base, source=source)
    plain = base.level is Level.EXACT and bool(base.where.all())
    reason = _OF_STIFFNESS.format(base.reason) if any_shape else _MODEL
    if not plain and not any_shape:
        reason = f"{reason}; of its radius: {base.reason}"
    claim = replace(base, reason=reason, source=source)
    if "cohesive_radius" in columns:
        a, c = columns["contact_radius"], columns["cohesive_radius"]
        with np.errstate(divide="ignore", invalid="ignore"):
            ring = np.where(c > a, np.minimum((c - a) / a, 1.0), 0.0)
        claim = replace(claim, reason=f"{_RING_OF_COHESION}; {reason}")
        return approximated({"": claim}, "", None if base.error is None else ring)[""]
    if contact.adhesion is not None and theory_of(contact.adhesion).pulls_beyond:
        return replace(claim, reason=f"{_BEYOND_CONTACT}; {reason}")
    return claim


def driven(
    name: str,
    drop: QuantityLike | None,
    flow: QuantityLike | None,
    values_of: Callable[[str], FloatArray],
    rows: int,
) -> tuple[str, FloatArray]:
    """
    The unit of a flux field, and the drop that drives it.

    Parameters
    ----------
    name : str
        The field, a flux.
    drop, flow : quantity or None
        One of them: the difference of temperatures in K or the voltage in V, or the heat in W or the current in A.
    values_of : callable
        Values of a quantity over the rows.
    rows : int
        Number of rows.

    Returns
    -------
    unit : str
    drop : ndarray of shape (rows,)
        In K or V.

    Raises
    ------
    QuantityError
        If the field is not a flux, both are given, or a temperature is given for a difference.
    """
    conduction = next((one for one in CONDUCTIONS if one.field == name), None)
    if conduction is None:
        raise QuantityError(
            f"drop= and flow= are for {' and '.join(one.field for one in CONDUCTIONS)}; leave them out for {name}"
        )
    unit = f"{conduction.flows_in}/m^2"
    if drop is not None and flow is not None:
        raise QuantityError(f"drop = {shown(drop)} and flow = {shown(flow)}; give one of them")
    if drop is not None:
        if isinstance(drop, str) and "deg" in drop and "delta" not in drop:
            raise QuantityError(f"drop = {shown(drop)} is a temperature; write the difference in K")
        return unit, np.full(rows, to_si(drop, conduction.driven_by, name="drop"))
    assert flow is not None
    conducting, whole = values_of(conduction.quantity), to_si(flow, conduction.flows_in, name="flow")
    with np.errstate(divide="ignore"):
        return unit, whole * conducting if conduction.resists else whole / conducting
