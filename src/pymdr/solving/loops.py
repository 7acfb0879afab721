"""Loops of friction at constant load: what an engineer of joints reads off them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import ProblemError, PymdrError
from pymdr.interpretation.accuracy import EXACT_WITHIN, with_errors
from pymdr.interpretation.certificate import Certificate
from pymdr.interpretation.friction import frictional_claims
from pymdr.interpretation.validity import Assumption, Claim, Level, approximated
from pymdr.line.foundation import ElasticLine, states_at_depth, states_at_force
from pymdr.mapping.abel import gauss
from pymdr.problem.contact import Contact
from pymdr.solving.bands import BAND_NOTE, scatter_of, shifted
from pymdr.solving.frictional import disks_down_to, frictional_assumptions
from pymdr.solving.reach import Mapped, map_remark, map_to_line, refuse_unreachable
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, to_si, to_si_array

_NODES, _LEVELS, _SETTLED = 16, 60, 1e-14

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class FrictionLoop:
    """Steady loops of a contact at constant normal load, over their amplitudes."""

    data: xr.Dataset
    """Over ``amplitude`` (m): force_amplitude (N), dissipated_per_cycle (J), damping_ratio, secant_stiffness
    (N/m), stick_ratio; the attribute ``sliding_shift`` in m. The scatter of a sampled profile adds the ends of their
    bands, such as ``damping_ratio_low`` and ``damping_ratio_high``."""
    claim: Claim
    """How far they can be trusted."""
    assumptions: tuple[Assumption, ...]
    """Conditions of the model, measured."""

    def __getitem__(self, name: str) -> xr.DataArray:
        return self.data[name]

    def summary(self) -> str:
        """A line per amplitude, with units, and how far to trust it."""
        head = f"{'amplitude':>12} {'force':>12} {'dissipated':>12} {'damping':>10} {'stiffness':>12} {'stick':>8}"
        units = f"{'m':>12} {'N':>12} {'J per cycle':>12} {'':>10} {'N/m':>12} {'':>8}"
        names = (
            "force_amplitude",
            "dissipated_per_cycle",
            "damping_ratio",
            "secant_stiffness",
            "stick_ratio",
        )
        columns = [self.data["amplitude"].values, *(self.data[name].values for name in names)]
        widths = (12, 12, 12, 10, 12, 8)
        rows = [
            " ".join(f"{value:>{width}.4g}" for value, width in zip(row, widths, strict=True))
            for row in zip(*columns, strict=True)
        ]
        unmet = [
            f"not met: {a.words} {a.measure:.3g}, limit {a.limit:.3g}" for a in self.assumptions if not a.met
        ]
        return "\n".join([head, units, *rows, f"{self.claim.level.value}: {self.claim.reason}", *unmet])

    def __str__(self) -> str:
        return self.summary()

    def plot(self) -> Figure:
        """Dissipation, damping ratio and stiffness against amplitude."""
        from pymdr.presentation.plot import loop_study

        return loop_study(self.data)


def friction_loop(
    contact: Contact,
    amplitude: ArrayQuantityLike,
    *,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> FrictionLoop:
    """
    Dissipation, damping and stiffness of steady loops between -amplitude and +amplitude at constant load.

    Loading from the virgin state is F(u) = mu [F_N(d) - F_N(d - G* u / (mu E*))]; the branches of a loop are that
    curve doubled (Masing), so that a cycle dissipates 8 G* int_c^a t (u - t) dx with t = mu (E*/G*) (d - g(x)),
    where c is the stick radius. Beyond the sliding shift mu (E*/G*) d every cycle slides 4 mu F_N (u - u_s) more.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite.
    amplitude : array_like or quantity
        Amplitudes of the shift in m, above 0.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.

    Returns
    -------
    FrictionLoop

    Raises
    ------
    ProblemError
        If the contact has no friction, both or none of the loads are given, or a value is not above 0.

    Notes
    -----
    Mindlin and Deresiewicz (1953) for the sphere; mdr_math 5.5 for any profile. The damping ratio is
    dissipated_per_cycle / (4 pi U) with U = force_amplitude * amplitude / 2.

    Examples
    --------
    >>> from pymdr.problem.laws import Coulomb
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> joint = Contact(Paraboloid("10 mm"), Elastic("210 GPa", 0.3), friction=Coulomb(0.3))
    >>> loop = friction_loop(joint, ["0.1 um", "0.2 um"], normal_force="100 N")
    >>> bool(6 < loop["dissipated_per_cycle"][1] / loop["dissipated_per_cycle"][0] < 9)
    True
    """
    import xarray as xr

    u = _amplitudes(amplitude)
    found = _study(contact, u, normal_force, indentation)
    columns = {name: found.columns[name] for name in _UNITS}
    claim = found.claim
    if scatter_of(contact.profile):
        ends = [_shifted_study(contact, sign, u, normal_force, indentation) for sign in (-1.0, 1.0)]
        for name in _UNITS:
            values = np.array([columns[name], *(end[name] for end in ends)])
            known = np.isfinite(values).all(axis=0)
            columns[f"{name}_low"] = np.where(known, values.min(axis=0), math.nan)
            columns[f"{name}_high"] = np.where(known, values.max(axis=0), math.nan)
        claim = replace(
            claim, level=Level.APPROXIMATE, reason=f"of the mean profile; {BAND_NOTE}; {claim.reason}"
        )
    data = xr.Dataset(
        {
            name: ("amplitude", values, {"units": _UNITS[name.removesuffix("_low").removesuffix("_high")]})
            for name, values in columns.items()
        },
        coords={"amplitude": ("amplitude", u, {"units": "m"})},
        attrs={"sliding_shift": found.sliding, "normal_force": found.load, "indentation": found.depth},
    )
    return FrictionLoop(data, claim, found.assumptions)


_UNITS = {
    "force_amplitude": "N",
    "dissipated_per_cycle": "J",
    "damping_ratio": "",
    "secant_stiffness": "N/m",
    "stick_ratio": "",
}


@dataclass(frozen=True)
class _Study:
    """The loops of one profile."""

    columns: dict[str, FloatArray]
    claim: Claim
    assumptions: tuple[Assumption, ...]
    sliding: float
    load: float
    depth: float


def _study(
    contact: Contact, u: FloatArray, normal_force: QuantityLike | None, indentation: QuantityLike | None
) -> _Study:
    mapped, d, mu, certificate = _loaded(contact, normal_force, indentation)
    line, moduli = mapped.line, mapped.moduli
    factor = mu * moduli.normal / moduli.tangential
    state = states_at_depth(line, np.array([d]))
    a = float(state.contact_radius[0])
    load = 2.0 * line.modulus * _moment_with_edge(line, d, a)
    sliding = factor * d
    inner = np.minimum(u, sliding)
    c = states_at_depth(line, d - inner / factor).contact_radius
    force, loss, error = _loop_integrals(line, d, a, c, inner, factor, moduli.tangential)
    force = np.where(u >= sliding, mu * load, force)
    loss = loss + 4.0 * mu * load * (u - inner)
    columns = {
        "force_amplitude": force,
        "dissipated_per_cycle": loss,
        "damping_ratio": loss / (2.0 * math.pi * force * u),
        "secant_stiffness": force / u,
        "stick_ratio": c / a,
    }
    name = "dissipated_energy"
    claims = frictional_claims(contact, moduli, (name,), np.ones(u.size, dtype=bool))
    if certificate.error is not None:
        claims = approximated(claims, certificate.remark, float(certificate.error[0]))
    claims = with_errors(claims, {name: error} if error.max() > EXACT_WITHIN else {}, map_remark(line, state))
    met = frictional_assumptions(contact, mapped, np.array([a]))
    return _Study(columns, claims[name], met, sliding, load, d)


def _shifted_study(
    contact: Contact,
    sign: float,
    u: FloatArray,
    normal_force: QuantityLike | None,
    indentation: QuantityLike | None,
) -> dict[str, FloatArray]:
    moved = replace(contact, profile=shifted(contact.profile, sign))
    try:
        return _study(moved, u, normal_force, indentation).columns
    except PymdrError:
        return dict.fromkeys(_UNITS, np.full(u.shape, math.nan))


def _amplitudes(given: ArrayQuantityLike) -> FloatArray:
    u = np.atleast_1d(to_si_array(given, "m", name="amplitude"))
    if u.ndim != 1 or u.size == 0 or not np.all(u > 0.0):
        raise ProblemError(f"friction_loop: amplitude = {given!r}; one row of lengths above 0 m is needed")
    return u


def _loaded(
    contact: Contact, normal_force: QuantityLike | None, indentation: QuantityLike | None
) -> tuple[Mapped, float, float, Certificate]:
    if not isinstance(contact, Contact) or contact.friction is None:
        raise ProblemError(
            "friction_loop: the contact has no friction; give Contact(..., friction=Coulomb(0.3))"
        )
    mu = contact.friction.coefficient
    if not 0.0 < mu < math.inf:
        raise ProblemError(f"friction_loop: mu = {mu:g} has no loops; it must be above 0 and finite")
    if (normal_force is None) == (indentation is None):
        raise ProblemError("friction_loop: give exactly one of normal_force and indentation")
    mapped = map_to_line(contact)
    line = mapped.line
    if indentation is not None:
        d = to_si(indentation, "m", name="indentation")
    else:
        assert normal_force is not None
        force = to_si(normal_force, "N", name="normal_force")
        d = float(states_at_force(line, np.array([max(force, 0.0)])).indentation[0])
    by_force = None if indentation is not None else force
    refuse_unreachable(line, contact.profile, states_at_depth(line, np.array([d])), by_force)
    if d <= 0.0:
        given, unit = (normal_force, "N") if indentation is None else (indentation, "m")
        raise ProblemError(
            f"friction_loop: the load {given!r} must be above 0 {unit}; press the bodies together"
        )
    return mapped, d, mu, disks_down_to(contact, line, d)


def _moment_with_edge(line: ElasticLine, d: float, a: float) -> float:
    at = np.array([a])
    return float(line.equivalent.moment(at)[0] + a * max(d - float(line.equivalent.g(at)[0]), 0.0))


def _loop_integrals(
    line: ElasticLine, d: float, a: float, c: FloatArray, u: FloatArray, factor: float, modulus: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Force amplitude 2 G* [u c + int_c^a t dx], loss 8 G* int_c^a t (u - t) dx, and the relative error of both.

    No term cancels. Between two kinks x runs like the square of the variable of integration, since g begins like a root
    behind a kink, and panels are halved until their halves agree with them.
    """
    slipping, loss, missed = np.zeros(u.shape), np.zeros(u.shape), np.zeros(u.shape)
    marks = np.array([0.0, *line.equivalent.kinks(a), a])
    whose, part = (x.ravel() for x in np.indices((u.size, marks.size - 1)))
    begin = np.sqrt(np.clip((c[whose] - marks[part]) / np.diff(marks)[part], 0.0, 1.0))
    real = begin < 1.0
    whose, part, low, high = whose[real], part[real], begin[real], np.ones(int(real.sum()))

    def panels(low: FloatArray, high: FloatArray) -> FloatArray:
        node, weight = gauss(_NODES)
        s = low[:, None] + (high - low)[:, None] * node
        width = np.diff(marks)[part]
        x = np.minimum(marks[part][:, None] + width[:, None] * s * s, a)
        top = u[whose, None]
        t = np.clip(factor * (d - line.equivalent.g(x)), 0.0, top)
        scale = 2.0 * width[:, None] * s * (high - low)[:, None] * weight
        return np.stack([(t * scale).sum(axis=1), (t * (top - t) * scale).sum(axis=1)])

    for level in range(_LEVELS):
        if whose.size == 0:
            break
        middle = 0.5 * (low + high)
        whole, left, right = panels(low, high), panels(low, middle), panels(middle, high)
        found = left + right
        # what is known so far is a scale for what is left
        size = np.stack([slipping + u * c, loss])
        for total, values in zip(size, np.abs(found), strict=True):
            np.add.at(total, whose, values)
        error = np.max(np.abs(found - whole) / np.maximum(size[:, whose], math.ulp(0.0)), axis=0)
        good = (error <= _SETTLED) | (level == _LEVELS - 1)
        np.add.at(slipping, whose[good], found[0, good])
        np.add.at(loss, whose[good], found[1, good])
        np.add.at(missed, whose[good], error[good])
        whose, part = np.tile(whose[~good], 2), np.tile(part[~good], 2)
        low, high = np.append(low[~good], middle[~good]), np.append(middle[~good], high[~good])
    return 2.0 * modulus * (u * c + slipping), 8.0 * modulus * loss, missed
