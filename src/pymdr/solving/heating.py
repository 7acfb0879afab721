"""Heating of a contact by an electric current or by friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.accuracy import normal_errors, with_errors
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.fields import normal_displacement
from pymdr.interpretation.heating import frictional_heat_claims, joule_claims, slow_sliding, wiedemann_franz
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import DiskStates, states_at_depth
from pymdr.line.foundation import normal_force as elastic_force
from pymdr.line.heating import LORENZ, current_load, frictional_rise, largest_rise, mean_displacement
from pymdr.mapping.equivalent import gap_function
from pymdr.mapping.moduli import Conductivity, conductivity_of
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, is_curve, require_contact
from pymdr.result import Result
from pymdr.solving.arguments import one_row, positive_speeds
from pymdr.solving.frictional import frictional_assumptions, pressed_joint
from pymdr.solving.mapped import map_remark
from pymdr.solving.study import Column, Study, dataset, over_rows
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, written

_NO_AREA = "the area of a contact is not in its force curve; give the shape itself as a profile"
_FINE = 121
_GIVEN = {"temperature": "K", "resistance": "ohm", "voltage": "V", "current": "A"}


@dataclass(frozen=True, kw_only=True)
class JouleHeating(Study):
    """The largest temperature of contacts with an electric current."""

    data: xr.Dataset
    """
    Over ``step``: temperature (K) of the bodies, voltage (V), largest_temperature (K) and temperature_rise (K) above that of the
    bodies; with a cold resistance also current (A), cold_resistance and hot_resistance (ohm).
    """
    subject: ClassVar = "Joule heating"
    columns: ClassVar = {
        "voltage": Column("voltage", "V"),
        "current": Column("current", "A"),
        "cold_resistance": Column("R cold", "ohm"),
        "hot_resistance": Column("R hot", "ohm"),
        "temperature": Column("bodies", "K"),
        "largest_temperature": Column("hottest", "K"),
        "temperature_rise": Column("rise", "K"),
    }
    summary_claims: ClassVar = ("largest_temperature",)

    def _figure(self) -> mpl.figure.Figure:
        """Largest temperature rise against voltage, with that of metals."""
        temperature = float(self.data["temperature"][0])
        voltage = np.linspace(0.0, 1.2 * float(np.abs(self.data["voltage"]).max()), _FINE)
        return plot.joule_study(self.data, voltage, largest_rise(voltage, temperature))


def joule_heating(
    resistance: Result | ArrayQuantityLike | None = None,
    *,
    temperature: ArrayQuantityLike,
    voltage: ArrayQuantityLike | None = None,
    current: ArrayQuantityLike | None = None,
) -> JouleHeating:
    """
    Largest temperature of a contact with an electric current.

    T_max^2 = T0^2 + V^2/(4 L) with a voltage V for any shape of the contact, L = 2.443e-8 V^2/K^2; with a current
    I R0 = 2 T0 sqrt(L) arccos(T0/T_max), which stays below pi T0 sqrt(L), R0 the cold resistance.

    Parameters
    ----------
    resistance : Result or array_like or quantity, optional
        The cold resistance R0 in ohm, above 0, or a result of :func:`~pymdr.solve` that has an ``electrical_resistance``, row by
        row. Needed with a current.
    temperature : array_like or quantity
        T0 of both bodies in K, above 0; also as "20 degC".
    voltage, current : array_like or quantity
        The voltage V between the bodies, or the current I through the contact, at least 0; exactly one.

    Returns
    -------
    JouleHeating
        One row per entry; single values apply to all rows.

    Raises
    ------
    ProblemError
        If both or none of voltage and current are given, a current without a resistance, columns of different lengths, a temperature
        or a resistance that is not above 0, or a current beyond the limit pi T0 sqrt(L)/R0.
    NotValidError
        If the resistance of the result is not valid.

    See Also
    --------
    frictional_heat : heat of slow sliding.

    Notes
    -----
    Kohlrausch (1900); Holm (1967). Both bodies obey rho lambda = L T; the assumptions check
    it if both are given.

    References
    ----------
    - Kohlrausch (1900), Ann. Phys. 306, 132-158.
    - Holm (1967), Electric Contacts: Theory and Application, 4th ed., Springer, doi:10.1007/978-3-662-06688-1.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.joule_heating(voltage="0.12 V", temperature="20 degC")["largest_temperature"].values.round(1).tolist()
    [483.0]
    >>> mdr.joule_heating("1 mohm", current="100 A", temperature="293.15 K")["largest_temperature"].values.round(1).tolist()
    [635.4]
    """
    if (voltage is None) == (current is None):
        raise ProblemError("give exactly one of voltage and current")
    if current is not None and resistance is None:
        raise ProblemError(
            "with a current the temperature depends on the resistance; give resistance, or voltage"
        )
    claim, rows = None, None
    if isinstance(resistance, Result):
        rows = resistance["electrical_resistance"].values
        claim = resistance.claims["electrical_resistance"]
    elif resistance is not None:
        rows = one_row(resistance, "ohm", "resistance")
    given = {"temperature": one_row(temperature, "K", "temperature")}
    given |= {} if rows is None else {"resistance": rows}
    name, unit, values = ("voltage", "V", voltage) if current is None else ("current", "A", current)
    assert values is not None
    given[name] = one_row(values, unit, name)
    columns = _joule_columns(_as_rows(given))
    t0 = columns["temperature"]
    law = wiedemann_franz(resistance.contact, t0) if isinstance(resistance, Result) else None
    unmeasured = (
        "rho lambda = L T is not checked: the bodies do not have both thermal_conductivity and resistivity"
    )
    where = np.ones(t0.size, dtype=bool)
    return JouleHeating(
        data=over_rows("step", np.arange(t0.size), columns, JouleHeating.columns),
        claims=joule_claims(where, by_current=current is not None, resistance=claim, known=rows is not None),
        assumptions=() if law is None else (law,),
        notes=(unmeasured,) if law is None else (),
    )


def _as_rows(given: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Columns of one length, with checked signs."""
    size = max(values.size for values in given.values())
    for name, values in given.items():
        if values.size not in (1, size):
            raise ProblemError(
                f"{name} has {values.size} numbers, another argument {size}; give one, or one for every row"
            )
        low, unit = float(np.nanmin(values, initial=math.inf)), _GIVEN[name]
        if name in ("voltage", "current") and low < 0.0:
            raise ProblemError(
                f"{name} = {low:.6g} {unit}: it must be at least 0 {unit} (its direction does not matter)"
            )
        if name in ("temperature", "resistance") and not low > 0.0:
            raise ProblemError(f"{name} = {low:.6g} {unit}: it must be above 0 {unit}")
        if not np.isfinite(values).all():
            raise ProblemError(
                f"the bodies are not in contact in row {int(np.argmin(np.isfinite(values)))}, or their contact is unknown; use rows "
                "in contact, such as result['electrical_resistance'][1:]"
            )
    return {name: np.broadcast_to(values, (size,)).copy() for name, values in given.items()}


def _joule_columns(given: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    t0, cold = given["temperature"], given.get("resistance")
    if "voltage" in given:
        voltage = given["voltage"]
    else:
        assert cold is not None
        voltage = _voltage(t0, cold, given["current"])
    rise = largest_rise(voltage, t0)
    columns = {
        "temperature": t0,
        "voltage": voltage,
        "largest_temperature": t0 + rise,
        "temperature_rise": rise,
    }
    if cold is not None:
        load = current_load(voltage, t0)
        ratio = np.divide(voltage, load, out=np.ones_like(load), where=load > 0.0)
        current = given["current"] if "current" in given else load / cold
        columns |= {"current": current, "cold_resistance": cold, "hot_resistance": cold * ratio}
    return columns


def _voltage(t0: FloatArray, cold: FloatArray, current: FloatArray) -> FloatArray:
    """The voltage in V of a current; raise if there is none."""
    scale = 2.0 * math.sqrt(LORENZ) * t0
    load = current * cold
    worst = int(np.argmax(load / scale))
    most = 0.5 * math.pi * scale[worst]
    if not load[worst] < most:
        raise ProblemError(
            f"the current {written(float(current[worst]), 'A')} over a cold resistance of "
            f"{written(float(cold[worst]), 'ohm')} (row {worst}) gives I R0 = {written(float(load[worst]), 'V')} (limit "
            f"pi T0 sqrt(L) = {written(float(most), 'V')}, at which the temperature diverges); reduce the current below "
            f"{written(float(most / cold[worst]), 'A')}"
        )
    return np.asarray(scale * np.tan(load / scale))


@dataclass(frozen=True, kw_only=True)
class FrictionalHeat(Study):
    """The temperature of a contact that slides slowly."""

    data: xr.Dataset
    """
    Over ``speed`` (m/s): largest_temperature_rise and mean_temperature_rise (K) over the contact, heat (W) into both bodies,
    and the largest peclet_number.
    """
    surface: xr.Dataset
    """
    Over ``speed`` and ``r`` (m): temperature_rise (K) of the surface in the contact and around it. Empty for a force curve, whose
    shape is unknown.
    """
    subject: ClassVar = "frictional heating"
    _drawn: ClassVar = ("frictional_heat_study", "data", "surface")
    columns: ClassVar = {
        "speed": Column("speed", "m/s"),
        "largest_temperature_rise": Column("largest rise", "K"),
        "mean_temperature_rise": Column("mean rise", "K"),
        "heat": Column("heat", "W"),
        "peclet_number": Column("Pe", ""),
    }
    summary_claims: ClassVar = ("largest_temperature_rise", "mean_temperature_rise")


def frictional_heat(
    contact: Contact,
    speed: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> FrictionalHeat:
    """
    Temperature rise of a contact in slow steady sliding with friction.

    T = mu v E* (d - f)/(2 (lambda_1 + lambda_2)) in the contact, exact in the limit of small Peclet numbers Pe = v a/(2 kappa) of the
    bodies that move relative to it; both bodies have one temperature far away.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite. Both bodies have a ``thermal_conductivity``, and every body that moves
        relative to the contact a ``thermal_diffusivity``; leave it out for the body that always rubs at the same place.
    speed : array_like or quantity
        Speeds v of sliding in m/s, above 0, one row.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.

    Returns
    -------
    FrictionalHeat
        Over ``speed`` (m/s): largest and mean temperature rise (K), heat flow (W) and Peclet number.

    Raises
    ------
    ProblemError
        If there is no friction, conductivity or diffusivity, a speed is not above 0, or not one load is given.

    See Also
    --------
    joule_heating : heat of a current.

    Notes
    -----
    Popov and Hess (2015), chapter 8: temperature and displacement have the same kernel 1/R, so that they are proportional for any
    shape, including a :class:`~pymdr.ForceCurve`. Give an insulating body a very small conductivity.

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> pin = mdr.Rigid(thermal_conductivity="20 W/(m K)")
    >>> disk = mdr.Elastic("1 GPa", 0.3, thermal_conductivity="20 W/(m K)", thermal_diffusivity="5 mm^2/s")
    >>> rubbed = mdr.frictional_heat(
    ...     mdr.Contact(mdr.Paraboloid("10 mm"), pin, disk, friction=mdr.Coulomb(0.3)), ["1 mm/s", "5 mm/s"], normal_force="1 N"
    ... )
    >>> rubbed["largest_temperature_rise"].values.round(4).tolist()
    [0.0148, 0.0741]
    """
    require_contact(contact)
    v = positive_speeds(speed)
    mapped, d, mu, certificate = pressed_joint("heat", contact, normal_force, indentation)
    pair, line = _conductivity(contact), mapped.line
    states = states_at_depth(line, np.array([d]))
    a, load = float(states.contact_radius[0]), float(elastic_force(line, states)[0])
    moving = _moving(contact)
    unit = frictional_rise(1.0, line.modulus, mu, pair.both)
    peclet = {which: 0.5 * v * a / kappa for which, kappa in moving.items()}
    fastest = np.max(list(peclet.values()), axis=0)
    columns = {"largest_temperature_rise": v * unit * d, "heat": mu * load * v, "peclet_number": fastest}
    fractions = {"body": pair.one / pair.both, "counterbody": pair.other / pair.both}
    # the kernel exp(-v (R + x)/(2 kappa))/R of a moving body lacks v/(2 kappa) in the mean; its fraction enters twice
    drift = np.sum([fractions[which] * pe for which, pe in peclet.items()], axis=0)
    largest = drift * load / (math.pi * a * d * line.modulus)
    taken = {"largest_temperature_rise": largest}
    error, why = 0.0, _NO_AREA
    if not is_curve(contact):
        mean, error = mean_displacement(line, a, d)
        columns["mean_temperature_rise"] = v * unit * mean
        # the odd part of the kernel has no mean over the contact
        taken["mean_temperature_rise"], why = largest * d / mean, ""
    claims = frictional_heat_claims(contact, mapped.moduli, np.ones(v.shape, dtype=bool), taken, why)
    numerical = _numerical_errors(line, states, normal_force is not None, error, v.size)
    claims = with_errors(with_rings(claims, certificate), numerical, map_remark(line, states))
    constant = {"normal_force": load, "indentation": d, "contact_radius": a, "friction_coefficient": mu}
    return FrictionalHeat(
        data=over_rows("speed", v, columns, FrictionalHeat.columns, constant),
        surface=_rise_over_radius(contact, line, states, v, unit),
        claims=claims,
        assumptions=(
            *frictional_assumptions(contact, mapped, states.contact_radius),
            slow_sliding(float(fastest.max())),
        ),
        notes=mapped.notes
        + tuple(
            f"the {name} has no thermal_diffusivity: it does not move relative to the contact"
            for name in ("body", "counterbody")
            if name not in moving
        ),
        contact=contact,
    )


def _numerical_errors(
    line: ElasticLine, states: DiskStates, by_force: bool, mean: float, rows: int
) -> dict[str, FloatArray]:
    """Relative numerical errors at every speed; `mean` is that of the mean displacement."""
    known = {
        name: float(error[0]) for name, error in normal_errors(line, states, np.array([by_force])).items()
    }
    errors = {
        "largest_temperature_rise": known.get("indentation", 0.0),
        "mean_temperature_rise": known.get("normal_displacement", 0.0) + mean,
        "heat": known.get("normal_force", 0.0),
    }
    return {name: np.full(rows, error) for name, error in errors.items()}


def _rise_over_radius(
    contact: Contact, line: ElasticLine, states: DiskStates, v: FloatArray, unit: FloatArray
) -> xr.Dataset:
    """The rise in K of the surface by speed, to twice the contact radius; empty for a force curve."""
    speeds = {"speed": ("speed", v, {"units": "m/s"})}
    if is_curve(contact):
        return dataset({}, coords=speeds)
    a, d, excess = (float(one[0]) for one in (states.contact_radius, states.indentation, states.edge_excess))
    r = a * np.concatenate([np.sin(np.linspace(0.0, 0.5 * math.pi, 81)), np.linspace(1.0, 2.0, 41)[1:]])
    u = normal_displacement(
        line, gap_function(contact.profile, line.equivalent), d, states.place.take(0), excess, r
    )
    return dataset(
        {"temperature_rise": (("speed", "r"), np.outer(v * unit, u), {"units": "K"})},
        coords={**speeds, "r": ("r", r, {"units": "m"})},
    )


def _conductivity(contact: Contact) -> Conductivity:
    pair = conductivity_of(contact.body, contact.counterbody, "thermal_conductivity")
    if isinstance(pair, str):
        raise ProblemError(pair)
    return pair


def _moving(contact: Contact) -> dict[str, float]:
    """Diffusivities in m^2/s of the bodies that move relative to the contact."""
    moving = {
        name: body.thermal_diffusivity
        for name, body in (("body", contact.body), ("counterbody", contact.counterbody))
        if body.thermal_diffusivity is not None
    }
    if not moving:
        raise ProblemError(
            "no body has a thermal_diffusivity, which is needed to check that sliding is slow: give it to every body that moves "
            "relative to the contact, as in Elastic(..., thermal_diffusivity='12 mm^2/s')"
        )
    return moving
