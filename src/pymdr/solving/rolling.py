"""Rolling with creep: the friction force of a body that rolls on another."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.rolling import (
    DIRECTIONS,
    LAWS,
    calibrated_modulus,
    creep_error,
    rolling_claims,
    saturation_error,
    unknown_error_reason,
)
from pymdr.line.foundation import states_at_depth
from pymdr.line.rolling import RollingLine, line_load, rolled_path, rolling_line, steady_rolling
from pymdr.problem.contact import Contact, refuse_curve
from pymdr.problem.profiles import Paraboloid
from pymdr.solving.arguments import one_row
from pymdr.solving.bands import no_bands
from pymdr.solving.frictional import frictional_assumptions, pressed_joint
from pymdr.solving.mapped import Springs, map_remark
from pymdr.solving.study import Column, Study, dataset, over_rows
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, metres, shown, to_si_array, written

_LARGEST = 2.0
"""A creepage is a difference of speeds over their mean."""
_CURVE, _POSITIONS = 65, 201
_OF_STEADY = ("slip_length", "saturation_creepage")
_BEYOND = 1.25
"""End of the curves relative to the saturation."""


@dataclass(frozen=True, kw_only=True)
class Rolling(Study):
    """Creep forces of a contact that rolls under a constant load."""

    data: xr.Dataset
    """
    Over ``creepage``, or over ``distance`` (m) rolled along a path: creep_force (N), traction_coefficient F_x/F_N; of
    steady rolling slip_length (m) on the line, and saturation_creepage, from which on all springs
    slip; inf if they never do.
    """
    springs: xr.Dataset | None
    """
    For steady rolling, over ``creepage`` and ``x`` (m) on the line, rolling toward +x: line_load and cap (N/m). They are an
    intermediate step, not the traction of the surface. None along a path.
    """
    curves: xr.Dataset
    """Steady creep_force (N) over ``creepage`` up to beyond saturation by every applicable ``law``."""

    subject: ClassVar = "a rolling contact"
    _drawn: ClassVar = ("rolling_study", "data", "curves", "springs")
    columns: ClassVar = {
        "distance": Column("rolled", "m"),
        "creepage": Column("creepage", ""),
        "creep_force": Column("force", "N"),
        "traction_coefficient": Column("F_x/F_N", ""),
        "slip_length": Column("slip", "m"),
    }
    summary_claims: ClassVar = ("creep_force",)

    def _remarks(self) -> list[str]:
        if "saturation_creepage" not in self.data:
            return []
        return [
            f"all springs slip from a creepage of {written(float(self.data['saturation_creepage']), '')} on"
        ]


@dataclass(frozen=True)
class _Pressed:
    """A contact under its load, ready to roll."""

    mapped: Springs
    line: RollingLine
    friction: float

    @property
    def unit(self) -> float:
        """The factor mu E* in Pa by which lengths are line loads."""
        return self.friction * self.mapped.moduli.normal

    @property
    def load(self) -> float:
        """The normal force in N."""
        return self.mapped.moduli.normal * self.line.whole

    @property
    def attributes(self) -> dict[str, Any]:
        """The load and the size of the contact."""
        return {"normal_force": self.load, "contact_radius": self.line.radius}


def rolling(
    contact: Contact,
    creepage: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
    direction: str = "longitudinal",
    law: str = "plain",
    path: ArrayQuantityLike | None = None,
) -> Rolling:
    """
    Creep force of a contact that rolls under a constant load.

    Springs enter the line free of stress at its leading edge x = a and are sheared by the creepage, q = G* zeta (a - x),
    until friction caps them at mu E* (d - g). For a paraboloid F_x = mu F_N [1 - (1 - xi)^3], xi = G* zeta R/(2 a mu E*),
    and the length 2 a xi slips at the trailing edge.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite. Its g must increase.
    creepage : array_like
        The creepage zeta, difference of the speeds of the surfaces over the speed of rolling, one row; of either sign.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.
    direction : str, optional
        "longitudinal", or "lateral": different in calibration and claims, equal for the springs.
    law : str, optional
        "plain", the springs of the method; or "calibrated", C G/2 in place of G* with C = C11 or C22 of Kalker, so that
        xi is that of Shen, Hedrick and Elkins, C G a^2 zeta/(3 mu F_N): for round tips of elastically similar,
        isotropic bodies.
    path : array_like or quantity, optional
        Distances rolled in m, increasing, above 0, one per creepage, which applies from the distance before up to its own,
        starting without traction. By default rolling is steady.

    Returns
    -------
    Rolling
        Over ``creepage`` or ``distance`` (m): creep force (N), traction coefficient and slip length (m).

    Raises
    ------
    ProblemError
        If the contact has no friction, both or none of the loads are given, a creepage is beyond 2, the direction or the law
        is unknown, the calibration does not hold for the contact, or the distances do not increase.

    See Also
    --------
    friction_loop : oscillating shifts.
    sliding_friction : friction by relaxation.

    Notes
    -----
    Popov and Hess (2015), chapter 6; Vermeulen and Johnson (1964) have the same cubic. Spin, contacts along a line
    (Carter 1926), and tractions and slip on the surface are not representable by springs on one line.

    References
    ----------
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.
    - Vermeulen and Johnson (1964), J. Appl. Mech. 31, 338-340.
    - Carter (1926), Proc. R. Soc. A 112, 151-157.

    Examples
    --------
    >>> import pymdr as mdr
    >>> steel = mdr.Elastic("210 GPa", 0.3)
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    >>> creep = mdr.rolling(ball, [1e-3, 5e-3], normal_force="100 N", law="calibrated")
    >>> creep["traction_coefficient"].values.round(4).tolist()
    [0.1056, 0.2895]
    """
    refuse_curve(contact, "rolling needs the contact area")
    _check_options(direction, law, path)
    zeta = _creepages(creepage)
    mapped, d, mu, certificate = pressed_joint("creep force", contact, normal_force, indentation)
    states = states_at_depth(mapped.line, np.array([d]))
    pressed = _Pressed(mapped, rolling_line(mapped.line, states), mu)
    modulus = _modulus(contact, mapped, direction, law)
    rise = modulus * zeta / pressed.unit
    errors = {} if path is not None else _errors(contact, pressed, direction, zeta, rise)
    claims = rolling_claims(contact, mapped.moduli, direction, law, errors, np.ones(zeta.shape, dtype=bool))
    claims = with_errors(with_rings(claims, certificate), {}, map_remark(mapped.line, states))
    notes = mapped.notes + no_bands(contact.profile)
    if path is None:
        data = _steady(pressed, rise, zeta, modulus)
    else:
        data, missed = _along(pressed, rise, zeta, _distances(path, zeta))
        claims = {name: claims[name] for name in claims if name not in _OF_STEADY}
        notes += (f"the integration along the path has an error of about {missed:.1g} of mu F_N",)
    attributes = {"indentation": d, "friction_coefficient": mu, "direction": direction, "law": law}
    return Rolling(
        data=data.assign_attrs(pressed.attributes | attributes),
        springs=_springs(pressed, rise, zeta) if path is None else None,
        curves=_curves(contact, pressed, direction, float(np.max(np.abs(zeta)))),
        claims=claims,
        assumptions=frictional_assumptions(contact, mapped, np.array([pressed.line.radius])),
        notes=notes,
        contact=contact,
    )


def _errors(
    contact: Contact, pressed: _Pressed, direction: str, zeta: FloatArray, rise: FloatArray
) -> dict[str, FloatArray]:
    """Relative errors of the law against the exact theory of rolling, as far as they are known."""
    if unknown_error_reason(contact, pressed.mapped.moduli):
        return {}
    size, line = np.abs(zeta), pressed.line
    modulus = calibrated_modulus(contact, pressed.mapped.moduli, direction)
    # the springs carry mu E* rise x 2 a^2 before any of them slips
    known = modulus * size / pressed.unit
    fraction, calibrated = (steady_rolling(line, np.abs(each)).load / line.whole for each in (rise, known))
    # a sphere is a paraboloid to the order (a/R)^2
    radius = contact.profile.curvature_radius or line.radius
    other = 0.0 if isinstance(contact.profile, Paraboloid) else (line.radius / radius) ** 2
    force = creep_error(fraction, calibrated, 2.0 * line.radius**2 * known / line.whole) + other
    ratio = float(np.max(known) / np.max(np.abs(rise))) if np.any(rise) else 1.0
    whole = np.full(zeta.shape, min(saturation_error(ratio) + other, 1.0))
    force = np.minimum(force, 1.0)
    return {"creep_force": force, "saturation_creepage": whole}


def _check_options(direction: str, law: str, path: ArrayQuantityLike | None) -> None:
    if direction == "spin":
        raise ProblemError(
            "direction='spin' is not covered: springs on one line have no spin; "
            "use 'longitudinal' or 'lateral'"
        )
    for name, given, known in (("direction", direction, DIRECTIONS), ("law", law, LAWS)):
        if given not in known:
            raise ProblemError(f"{name} = {shown(given)}; give {' or '.join(map(repr, known))}")
    if path is not None and law != "plain":
        raise ProblemError(
            f"law={law!r} is for steady rolling: Kalker's coefficients do not describe transients; "
            "use law='plain', or leave the path out"
        )


def _creepages(given: ArrayQuantityLike) -> FloatArray:
    zeta = one_row(given, "", "creepage")
    if np.any(np.abs(zeta) > _LARGEST):
        worst = float(zeta[np.argmax(np.abs(zeta))])
        raise ProblemError(
            f"creepage = {worst:g} (limit {_LARGEST:g}, the largest difference of two speeds over their mean); "
            "give it as a number, not in per cent"
        )
    return zeta


def _distances(given: ArrayQuantityLike, zeta: FloatArray) -> FloatArray:
    """Rolled distances in m, one for every creepage, increasing."""
    distance = np.atleast_1d(to_si_array(given, "m", name="path"))
    if distance.shape != zeta.shape:
        raise ProblemError(
            f"path has {distance.size} distances and creepage {zeta.size} numbers; give one distance for every creepage"
        )
    falling = np.flatnonzero(np.diff(distance, prepend=0.0) <= 0.0)
    if falling.size:
        i = int(falling[0])
        raise ProblemError(
            f"path[{i}] = {metres(float(distance[i]))} does not increase; distances must increase from above 0 m"
        )
    return distance


def _modulus(contact: Contact, mapped: Springs, direction: str, law: str) -> float:
    if law == "calibrated":
        return calibrated_modulus(contact, mapped.moduli, direction)
    return mapped.moduli.tangential


def _steady(pressed: _Pressed, rise: FloatArray, zeta: FloatArray, modulus: float) -> xr.Dataset:
    # opposite creepages have the same solution
    size, which = np.unique(np.abs(rise), return_inverse=True)
    solution = steady_rolling(pressed.line, size)
    force = np.sign(zeta) * pressed.unit * solution.load[which]
    columns = {
        "creep_force": force,
        "traction_coefficient": force / pressed.load,
        "slip_length": solution.slip_length[which],
    }
    saturation = ((), pressed.unit / modulus * pressed.line.saturation, {"units": ""})
    return over_rows("creepage", zeta, columns, Rolling.columns).assign(saturation_creepage=saturation)


def _along(
    pressed: _Pressed, rise: FloatArray, zeta: FloatArray, distance: FloatArray
) -> tuple[xr.Dataset, float]:
    """Creep forces over the distance, and the error of the integration."""
    solution = rolled_path(pressed.line, distance, rise)
    force = pressed.unit * solution.load
    columns = {"creepage": zeta, "creep_force": force, "traction_coefficient": force / pressed.load}
    return over_rows("distance", distance, columns, Rolling.columns), solution.error


def _springs(pressed: _Pressed, rise: FloatArray, zeta: FloatArray) -> xr.Dataset:
    x = np.linspace(-pressed.line.radius, pressed.line.radius, _POSITIONS)
    load = np.sign(rise)[:, None] * line_load(pressed.line, np.abs(rise), x)
    return dataset(
        {
            "line_load": (("creepage", "x"), pressed.unit * load, {"units": "N/m"}),
            "cap": ("x", pressed.unit * pressed.line.cap(x), {"units": "N/m"}),
        },
        coords={
            "creepage": ("creepage", zeta, {"units": ""}),
            "x": ("x", x, {"units": "m"}),
        },
    )


def _curves(contact: Contact, pressed: _Pressed, direction: str, largest: float) -> xr.Dataset:
    """Creep forces by every applicable law."""
    moduli = {"plain": pressed.mapped.moduli.tangential}
    with contextlib.suppress(ProblemError):
        moduli["calibrated"] = calibrated_modulus(contact, pressed.mapped.moduli, direction)
    saturation = pressed.unit / moduli["plain"] * pressed.line.saturation
    end = _BEYOND * saturation if math.isfinite(saturation) else 2.0 * largest or 0.01
    zeta = np.linspace(0.0, min(end, _LARGEST), _CURVE)
    forces = [
        pressed.unit * steady_rolling(pressed.line, modulus * zeta / pressed.unit).load
        for modulus in moduli.values()
    ]
    return dataset(
        {"creep_force": (("law", "creepage"), np.array(forces), {"units": "N"})},
        coords={"law": list(moduli), "creepage": ("creepage", zeta, {"units": ""})},
        attrs={"limit": pressed.friction * pressed.load},
    )
