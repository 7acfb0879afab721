"""Friction loops at constant load: dissipation, damping and stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError, PymdrError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.closure import closure_claims
from pymdr.interpretation.friction import frictional_claims
from pymdr.interpretation.validity import EXACT_WITHIN, SOURCES, Assumption, Claim, Level, total_error
from pymdr.line.foundation import ElasticLine, elastic_energy, states_at_depth, states_at_force
from pymdr.line.foundation import normal_force as force_of
from pymdr.mapping.closure import closure_of
from pymdr.numerics.quadrature import gauss
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, is_curve, require_contact
from pymdr.problem.laws import Coulomb
from pymdr.problem.profiles import ForceCurve
from pymdr.solving.bands import band_note, scatter_of, shifted
from pymdr.solving.frictional import frictional_assumptions, pressed_joint
from pymdr.solving.mapped import Springs, map_remark
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, newtons, shown, to_si_array

_NODES, _LEVELS, _SETTLED = 16, 60, 1e-14
_ROUNDED = 4.0 * float(np.finfo(float).eps)
"""Relative precision of d - g(x), over d."""


@dataclass(frozen=True, kw_only=True)
class FrictionLoop(Study):
    """Steady loops of a contact at constant normal load, over their amplitudes."""

    data: xr.Dataset
    """Over ``amplitude`` (m) or ``force_amplitude`` (N), whichever was given: the other, dissipated_per_cycle (J),
    damping_ratio, secant_stiffness (N/m), stick_ratio, and sliding_shift (m), beyond which all slides; over
    ``coefficient`` too where several coefficients of friction were given. The scatter of a sampled profile adds the
    ends of their bands, such as ``damping_ratio_low`` and ``damping_ratio_high``."""

    subject: ClassVar = "a friction loop"
    columns: ClassVar = {
        "coefficient": Column("mu", ""),
        "amplitude": Column("amplitude", "m"),
        "force_amplitude": Column("force", "N"),
        "dissipated_per_cycle": Column("dissipated", "J"),
        "damping_ratio": Column("damping", ""),
        "secant_stiffness": Column("stiffness", "N/m"),
        "stick_ratio": Column("stick", ""),
    }
    summary_claims: ClassVar = ("dissipated_per_cycle",)

    @property
    def claim(self) -> Claim:
        """The claim of the dissipation."""
        return self.claims["dissipated_per_cycle"]

    def by_coefficient(self) -> list[tuple[float | None, xr.Dataset]]:
        """The loops of every coefficient of friction; None stands for the one of the contact."""
        if "coefficient" not in self.data.dims:
            return [(None, self.data)]
        return [
            (float(mu), self.data.isel(coefficient=i)) for i, mu in enumerate(self.data["coefficient"].values)
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Dissipation, damping ratio and stiffness against amplitude."""
        return plot.loop_study(self.by_coefficient())


def friction_loop(
    contact: Contact,
    amplitude: ArrayQuantityLike | None = None,
    *,
    force_amplitude: ArrayQuantityLike | None = None,
    coefficient: ArrayQuantityLike | None = None,
    normal_force: QuantityLike | None = None,
    indentation: QuantityLike | None = None,
) -> FrictionLoop:
    """
    Dissipation, damping and stiffness of steady loops between two amplitudes of opposite sign at constant load.

    Loading from the virgin state is F(u) = mu [F_N(d) - F_N(d - G* u / (mu E*))]; the branches of a loop are that
    curve doubled (Masing), so that a cycle dissipates 8 G* int_c^a t (u - t) dx with t = mu (E*/G*) (d - g(x)),
    where c is the stick radius. Beyond the sliding shift mu (E*/G*) d every cycle dissipates 4 mu F_N (u - u_s) more.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite.
    amplitude : array_like or quantity, optional
        Amplitudes of the shift in m, above 0.
    force_amplitude : array_like or quantity, optional
        Amplitudes of the tangential force in N, above 0 and below mu F_N, instead.
    coefficient : array_like, optional
        Coefficients of friction, above 0 and finite, in place of that of the contact: a dimension of the result.
    normal_force, indentation : quantity
        The constant load in N, or depth in m; exactly one.

    Returns
    -------
    FrictionLoop
        Over the amplitudes: dissipation per cycle (J), damping ratio, secant stiffness (N/m) and stick ratio.

    Raises
    ------
    ProblemError
        If the contact has no friction, both or none of the loads or of the amplitudes are given, a value is not
        above 0, or a force reaches mu F_N, where everything slides.

    See Also
    --------
    measured_loops : the same of a record.

    Notes
    -----
    Mindlin and Deresiewicz (1953) for the sphere, and Jaeger (1995) for any profile. The damping ratio is
    dissipated_per_cycle / (4 pi U) with U = force_amplitude * amplitude / 2.

    References
    ----------
    - Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327-344.
    - Jaeger (1995), Arch. Appl. Mech. 65, 478-487.

    Examples
    --------
    >>> import pymdr as mdr
    >>> joint = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3))
    >>> loop = mdr.friction_loop(joint, ["0.1 um", "0.2 um"], normal_force="100 N")
    >>> bool(6 < loop["dissipated_per_cycle"][1] / loop["dissipated_per_cycle"][0] < 9)
    True
    """
    require_contact(contact)
    if (amplitude is None) == (force_amplitude is None):
        raise ProblemError("give exactly one of amplitude and force_amplitude")
    by_shift = amplitude is not None
    given = _amplitudes(amplitude, "m", "amplitude") if by_shift else None
    pulls = None if by_shift else _amplitudes(force_amplitude, "N", "force_amplitude")
    if coefficient is None:
        return _one_loop(contact, given, pulls, normal_force, indentation)
    studies = []
    for mu in _amplitudes(coefficient, "", "coefficient"):
        law = Coulomb(float(mu))
        studies.append(_one_loop(replace(contact, friction=law), given, pulls, normal_force, indentation))
    names = ["coefficient", "amplitude" if by_shift else "force_amplitude"]
    mus = xr.DataArray(
        [float(mu) for mu in _amplitudes(coefficient, "", "coefficient")],
        dims="coefficient",
        attrs={"long_name": "coefficient of friction"},
        name="coefficient",
    )
    data = xr.concat([study.data for study in studies], dim=mus, combine_attrs="override", join="exact")
    claims = {name: _weakest([study.claims[name] for study in studies]) for name in studies[0].claims}
    return replace(
        studies[0], data=data.transpose(*names, ...), claims=claims, contact=replace(contact, friction=None)
    )


def _weakest(claims: list[Claim]) -> Claim:
    """The claim that holds for all of several studies, with the largest error at every amplitude."""
    levels = list(Level)
    weakest = max(claims, key=lambda claim: (levels.index(claim.level), claim.error is not None))
    errors = [claim.error for claim in claims if claim.error is not None]
    return replace(weakest, error=np.max(errors, axis=0) if len(errors) == len(claims) else None)


def _one_loop(
    contact: Contact,
    given: FloatArray | None,
    pulls: FloatArray | None,
    normal_force: QuantityLike | None,
    indentation: QuantityLike | None,
) -> FrictionLoop:
    study = _study(contact, given, pulls, normal_force, indentation)
    dimension = "amplitude" if given is not None else "force_amplitude"
    columns, claims = dict(study.columns), dict(study.claims)
    if scatter_of(contact.profile):
        ends = [
            _shifted_study(contact, sign, study, given, pulls, normal_force, indentation)
            for sign in (-1.0, 1.0)
        ]
        for name in _UNITS:
            if name == dimension:
                continue
            values = np.array([columns[name], *(end[name] for end in ends)])
            known = np.isfinite(values).all(axis=0)
            columns[f"{name}_low"] = np.where(known, values.min(axis=0), math.nan)
            columns[f"{name}_high"] = np.where(known, values.max(axis=0), math.nan)
        for name, claim in claims.items():
            if claim.readable and name != dimension:
                reason = f"of the mean profile; {band_note(contact.profile)}; {claim.reason}"
                error = total_error(_spread(columns, name), claim.error)
                claims[name] = replace(claim, level=Level.APPROXIMATE, reason=reason, error=error)
    arrays = {
        name: (dimension, values, {"units": _UNITS[name.removesuffix("_low").removesuffix("_high")]})
        for name, values in columns.items()
    }
    data = dataset(
        {name: array for name, array in arrays.items() if name != dimension}
        | {"sliding_shift": ((), study.sliding, {"units": "m"})},
        coords={dimension: arrays[dimension]},
        attrs={"sliding_shift": study.sliding, "normal_force": study.load, "indentation": study.depth},
    )
    return FrictionLoop(
        data=data,
        claims=claims,
        assumptions=study.assumptions,
        notes=study.notes,
        contact=contact,
    )


def _spread(columns: Mapping[str, FloatArray], name: str) -> FloatArray | None:
    """Half of a band over the number; None where an end is not known."""
    ends = [columns[f"{name}_{end}"] for end in ("low", "high")]
    with np.errstate(divide="ignore", invalid="ignore"):
        half_width = np.max([np.abs(end / columns[name] - 1.0) for end in ends], axis=0)
    return half_width if np.isfinite(half_width).all() else None


_UNITS = {
    "amplitude": "m",
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
    claims: dict[str, Claim]
    assumptions: tuple[Assumption, ...]
    notes: tuple[str, ...]
    sliding: float
    load: float
    depth: float


def _study(
    contact: Contact,
    given: FloatArray | None,
    pulls: FloatArray | None,
    normal_force: QuantityLike | None,
    indentation: QuantityLike | None,
) -> _Study:
    mapped, d, mu, certificate = pressed_joint("loops", contact, normal_force, indentation)
    line, moduli = mapped.line, mapped.moduli
    factor = mu * moduli.normal / moduli.tangential
    state = states_at_depth(line, np.array([d]))
    a = float(state.contact_radius[0])
    load = float(force_of(line, state)[0])
    sliding = factor * d

    if given is not None:
        u = given
        force, loss, c, error = _loops_at(mapped, mu, np.full(u.shape, d), u)
    else:
        assert pulls is not None
        if np.max(pulls) >= mu * load:
            raise ProblemError(
                f"force_amplitude = {newtons(float(np.max(pulls)))}: the whole contact slides at mu F_N = "
                f"{newtons(mu * load)}; give forces below, or amplitudes of the shift"
            )
        force = pulls
        depths = np.full(pulls.shape, d)
        u = _shifts_at(pulls, mu, load, line, d, factor, lambda u: _loops_at(mapped, mu, depths, u)[0])
        _, loss, c, error = _loops_at(mapped, mu, depths, u)
    columns = {
        "amplitude": u,
        "force_amplitude": force,
        "dissipated_per_cycle": loss,
        "damping_ratio": loss / (2.0 * math.pi * force * u),
        "secant_stiffness": force / u,
        # of a force curve, no part of an area
        "stick_ratio": np.full(u.shape, math.nan) if is_curve(contact) else c / a,
    }
    # as of a history: the tangential force of a force curve may be known where its dissipation is not
    likes = dict.fromkeys(columns, "tangential_force") | {
        "dissipated_per_cycle": "dissipated_energy",
        "damping_ratio": "dissipated_energy",
    }
    names = ("tangential_force", "dissipated_energy")
    claims = frictional_claims(contact, moduli, names, np.ones(u.size, dtype=bool))
    claims = with_rings(claims, certificate)
    missed = {name: own for name, own in zip(names, error, strict=True) if own.max() > EXACT_WITHIN}
    claims = with_errors(claims, missed, map_remark(line, state))
    if isinstance(contact.profile, ForceCurve):
        known = closure_of(contact.profile)
        # beyond the sliding shift a loop is the work 4 mu F_N u less 8 times the largest stored energy, mu^2 (E*/G*) U
        most = mu * factor * float(elastic_energy(line, state)[0])
        with np.errstate(divide="ignore", invalid="ignore"):
            balance = np.where(
                u >= sliding, np.array([4.0 * mu * load * u, np.full(u.shape, 8.0 * most)]) / loss, math.inf
            )
        claims = closure_claims(claims, known, np.full(u.shape, d), sheared=True, balance=balance)
    met = frictional_assumptions(contact, mapped, np.array([a]))
    by_name = {name: claims[like] for name, like in likes.items()}
    by_name["amplitude" if given is not None else "force_amplitude"] = Claim(
        Level.EXACT, "prescribed", claims["tangential_force"].source, np.ones(u.size, dtype=bool)
    )
    if is_curve(contact):
        why = "the area of a contact is not in its force curve; give the shape itself as a profile"
        by_name["stick_ratio"] = Claim(Level.NOT_VALID, why, SOURCES["closure"], np.zeros(u.size, dtype=bool))
    return _Study(columns, by_name, met, mapped.notes, sliding, load, d)


def loops_at_loads(
    contact: Contact, amplitude: FloatArray, normal_force: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Force amplitude in N and dissipation per cycle in J of loops of given amplitude in m, each at its own load in N."""
    mapped, _, mu, _ = pressed_joint("loops", contact, float(np.max(normal_force)), None)
    depth = states_at_force(mapped.line, normal_force).indentation
    force, loss, _, _ = _loops_at(mapped, mu, depth, amplitude)
    return force, loss


def _loops_at(
    mapped: Springs, mu: float, d: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Force amplitude, dissipation, stick radius, and relative errors of the first two of loops of amplitudes u at depths d."""
    line, moduli = mapped.line, mapped.moduli
    factor = mu * moduli.normal / moduli.tangential
    state = states_at_depth(line, d)
    limit = mu * force_of(line, state)
    inner = np.minimum(u, factor * d)
    c = states_at_depth(line, d - inner / factor).contact_radius
    force, loss, error = _loop_integrals(line, d, state.contact_radius, c, inner, factor, moduli.tangential)
    force = np.where(u >= factor * d, limit, force)
    whole = loss + 4.0 * limit * (u - inner)
    error[1] *= np.divide(loss, whole, out=np.ones(u.shape), where=whole > 0.0)
    return force, whole, c, error


def _shifted_study(
    contact: Contact,
    sign: float,
    mean: _Study,
    given: FloatArray | None,
    pulls: FloatArray | None,
    normal_force: QuantityLike | None,
    indentation: QuantityLike | None,
) -> dict[str, FloatArray]:
    moved = replace(contact, profile=shifted(contact.profile, sign))
    try:
        return _study(moved, given, pulls, normal_force, indentation).columns
    except PymdrError:
        return dict.fromkeys(_UNITS, np.full(mean.columns["amplitude"].shape, math.nan))


_SMALL_FRACTION = 1e-3
"""Fraction of mu F_N below which forces lose digits in the difference of two loads."""


def _shifts_at(
    pulls: FloatArray,
    mu: float,
    load: float,
    line: ElasticLine,
    d: float,
    factor: float,
    force_at: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """
    The shifts at which the virgin curve has given forces: F_N(d - u / factor) = F_N(d) - F / mu.

    That difference loses the digits of small forces; secants through F(u), which cancels nowhere and is all but straight
    there, bring them back.
    """
    depth = states_at_force(line, load - pulls / mu).indentation
    u = np.clip(factor * (d - depth), factor * d * 1e-16, factor * d)
    small = pulls < _SMALL_FRACTION * mu * load
    # all but straight: one secant is enough
    if small.any():
        u = np.where(small, u * pulls / force_at(u), u)
    return u


def _amplitudes(given: ArrayQuantityLike | None, unit: str, name: str) -> FloatArray:
    assert given is not None
    u = np.atleast_1d(to_si_array(given, unit, name=name))
    if u.ndim != 1 or u.size == 0 or not np.all(u > 0.0):
        kind = {"m": "lengths above 0 m", "N": "forces above 0 N", "": "numbers above 0"}[unit]
        raise ProblemError(f"{name} = {shown(given)}; one row of {kind} is needed")
    return u


def _loop_integrals(
    line: ElasticLine,
    d: FloatArray,
    a: FloatArray,
    c: FloatArray,
    u: FloatArray,
    factor: float,
    modulus: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Force amplitude 2 G* [u c + int_c^a t dx], loss 8 G* int_c^a t (u - t) dx, and the relative errors of both.

    No term cancels. Between two kinks x runs like the square of the variable of integration, since g begins like a root
    behind a kink, and panels are halved until their halves agree with them, or differ by the rounding of d - g alone.
    """
    slipping, loss, missed = np.zeros(u.shape), np.zeros(u.shape), np.zeros((2, u.size))
    kinks = np.unique([0.0, *line.equivalent.kinks(float(a.max())), math.inf])
    marks = np.minimum(kinks, a[:, None])
    widths = np.diff(marks, axis=1)
    whose, part = np.nonzero((widths > 0.0) & (c[:, None] < marks[:, 1:]))
    low = np.sqrt(np.clip((c[whose] - marks[whose, part]) / widths[whose, part], 0.0, 1.0))
    real = low < 1.0
    whose, part, low, high = whose[real], part[real], low[real], np.ones(int(real.sum()))

    def panels(low: FloatArray, high: FloatArray) -> FloatArray:
        node, weight = gauss(_NODES)
        s = low[:, None] + (high - low)[:, None] * node
        width = widths[whose, part]
        x = np.minimum(marks[whose, part][:, None] + width[:, None] * s * s, a[whose, None])
        top = u[whose, None]
        t = np.clip(factor * (d[whose, None] - line.equivalent.g(x)), 0.0, top)
        scale = 2.0 * width[:, None] * s * (high - low)[:, None] * weight
        return np.stack([(t * scale).sum(axis=1), (t * (top - t) * scale).sum(axis=1)])

    for level in range(_LEVELS):
        if whose.size == 0:
            break
        middle = 0.5 * (low + high)
        whole, left, right = panels(low, high), panels(low, middle), panels(middle, high)
        integrals = left + right
        # what is known so far is a scale for what is left
        size = np.stack([slipping + u * c, loss])
        for total, values in zip(size, np.abs(integrals), strict=True):
            np.add.at(total, whose, values)
        least = np.maximum(size[:, whose], math.ulp(0.0))
        error = np.abs(integrals - whole) / least
        spread = _ROUNDED * factor * d[whose] * widths[whose, part] * (high - low) * (high + low)
        rounded = np.stack([spread, spread * u[whose]]) / least
        good = (error.max(axis=0) <= np.maximum(_SETTLED, rounded.max(axis=0))) | (level == _LEVELS - 1)
        error += rounded
        np.add.at(slipping, whose[good], integrals[0, good])
        np.add.at(loss, whose[good], integrals[1, good])
        np.add.at(missed.T, whose[good], error[:, good].T)
        whose, part = np.tile(whose[~good], 2), np.tile(part[~good], 2)
        low, high = np.append(low[~good], middle[~good]), np.append(middle[~good], high[~good])
    return 2.0 * modulus * (u * c + slipping), 8.0 * modulus * loss, missed
