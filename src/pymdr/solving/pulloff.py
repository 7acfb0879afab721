"""Pull-off, jump-in and the choice of the law of adhesion, without a path."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pymdr.errors import PathError, ProblemError, RefusedError
from pymdr.interpretation.accuracy import fold_errors, loss_error, with_errors
from pymdr.interpretation.adhesion import Visited, certify_stretched_disk, is_always_open
from pymdr.interpretation.branches import equilibrium_curve
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.line.adhesion import DMT_BELOW, JKR_ABOVE, jkr_opening, maugis_parameter, tabor_parameter
from pymdr.line.adhesion.equivalent_line import States
from pymdr.line.following import Jumps, Route, Track, pressed, pulled, turning_points, under_machine
from pymdr.line.foundation import states_at_depth
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT, JKR, AdhesionLaw, MaugisDugdale
from pymdr.problem.paths import load
from pymdr.problem.profiles import Profile
from pymdr.quantities import quantity
from pymdr.result import Result
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.reach import assumptions, map_remark
from pymdr.solving.study import Column, Study, number
from pymdr.solving.verb import read_stiffness, solve
from pymdr.units import FloatArray, QuantityLike, to_si

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_COST = 0.01


@dataclass(frozen=True, kw_only=True)
class PullOff(Study):
    """The last stable state of a contact in retraction, and the state after the jump into contact."""

    data: xr.Dataset
    """
    Single numbers: normal_force (N), indentation, contact_radius and travel (m) of the last state, dissipated_energy (J);
    jump_in_indentation (m), jump_in_force (N) and jump_in_radius (m); largest_pull (N); machine_stiffness (N/m).
    """
    subject: ClassVar = "a pull-off"

    normal_force = number("normal_force", "Force in N, below 0.")
    indentation = number("indentation", "In m.")
    contact_radius = number("contact_radius", "In m.")
    travel = number(
        "travel",
        "Travel of the machine in m; the indentation under displacement control, NaN under a dead load.",
    )
    dissipated_energy = number(
        "dissipated_energy",
        "Energy dissipated in the jump out of contact in J; under a dead load without the work of its fall after separation.",
    )
    jump_in_indentation = number(
        "jump_in_indentation", "Indentation in m after the jump into contact at first touch."
    )
    jump_in_force = number("jump_in_force", "Force in N after that jump.")
    jump_in_radius = number("jump_in_radius", "Contact radius in m after that jump.")
    largest_pull = number(
        "largest_pull",
        "Lowest force in N between the pressed state and the loss of contact: what test rigs report as adhesion.",
    )
    machine_stiffness = number("machine_stiffness", "In N/m; inf is displacement control, 0 a dead load.")

    def groups(self) -> dict[str, dict[str, float]]:
        """The numbers under headings."""
        last = ("normal_force", "indentation", "contact_radius", "travel", "dissipated_energy")
        return {
            "pull-off": {name: float(self.data[name]) for name in last},
            "jump into contact": {
                "indentation": self.jump_in_indentation,
                "normal_force": self.jump_in_force,
                "contact_radius": self.jump_in_radius,
            },
            "largest pull before": {"normal_force": self.largest_pull},
        }

    def _figure(self) -> Figure:
        from pymdr.presentation.plot import pull_off_figure

        assert self.contact is not None
        line = AdhesiveLine(self.contact)
        track = line.track(math.inf, max(self.indentation, self.jump_in_indentation), self.jump_in_radius)
        curve = equilibrium_curve(line.equilibria, track.curve.stop, track.turning.tolist())
        return pull_off_figure(curve, self.data)


def pull_off(
    contact: Contact, *, machine_stiffness: QuantityLike = math.inf, pressed_to: QuantityLike | None = None
) -> PullOff:
    """
    Loss of an adhesive contact in retraction, and its state after the jump into contact.

    Stable states satisfy dD/da > 0 for the travel D = d + F/k of the machine (Popov and Hess 2015, chapter 4).

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.
    machine_stiffness : quantity, optional
        k in N/m: inf (the default) is displacement control, 0 a dead load.
    pressed_to : quantity, optional
        Indentation in m before the retraction, for wavy profiles whose pull-off depends on it; by default that of the
        unloaded contact.

    Returns
    -------
    PullOff

    Raises
    ------
    ProblemError
        If the contact has no adhesion, or the stiffness is negative.
    PathError
        If the profile ends before the state at the start of the retraction.

    See Also
    --------
    adhesion_regime : which law is valid.
    solve : the whole curve.

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import math
    >>> import pymdr as mdr
    >>> gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    >>> round(mdr.pull_off(gel, machine_stiffness=0).normal_force / (math.pi * 5e-5), 12)
    -1.5
    """
    line = _adhesive(contact)
    stiffness = read_stiffness(machine_stiffness)
    track, press = _pressed(line, stiffness, pressed_to)
    pull = pulled(track, press.branch, press.last)
    _refuse_rings(line, track, stiffness, press, pull)
    into = track.jumps[2].after
    state, touched = (line.equilibria.states(np.asarray(s)) for s in ([pull.last], into))
    d, force, radius = _numbers(state)
    jump = _numbers(touched)
    lowest = _lowest_force(line, pull)
    loss = pull.loss if stiffness > 0.0 else line.fallen(pull.last, force)
    values = {
        "normal_force": force,
        "indentation": d,
        "contact_radius": radius,
        "travel": d + force / stiffness if stiffness > 0.0 else math.nan,
        "dissipated_energy": loss,
        **dict(zip(("jump_in_indentation", "jump_in_force", "jump_in_radius"), jump, strict=True)),
        "largest_pull": float(line.equilibria.states(np.array([lowest])).normal_force[0]),
        "machine_stiffness": stiffness,
    }
    largest = np.array([radius, jump[2], *line.equilibria.states(press.end).contact_radius])
    opening = theory_of(line.law).opening(line.law, line.line, largest)
    return PullOff(
        data=_single(values),
        claims=_claims(line, values, _errors(line, track, (pull.last, float(into[0]), lowest), values)),
        assumptions=assumptions(contact, line.origin, largest, -opening),
        notes=(*line.origin.notes, *line.unsmoothed),
        contact=contact,
    )


def _numbers(states: States) -> tuple[float, float, float]:
    """Indentation in m, force in N and radius in m of one state."""
    return float(states.indentation[0]), float(states.normal_force[0]), float(states.contact_radius[0])


_UNITS = {
    "travel": "m",
    "jump_in_indentation": "m",
    "jump_in_force": "N",
    "jump_in_radius": "m",
    "largest_pull": "N",
    "machine_stiffness": "N/m",
}


def _single(values: Mapping[str, float]) -> xr.Dataset:
    import xarray as xr

    units = {name: _UNITS[name] if name in _UNITS else quantity(name).unit for name in values}
    return xr.Dataset({name: ((), value, {"units": units[name]}) for name, value in values.items()})


def _errors(
    line: AdhesiveLine, track: Track, at: tuple[float, float, float], values: Mapping[str, float]
) -> dict[str, float]:
    """Relative errors of the last state, the state after the jump into contact, and the lowest force."""
    k = values["machine_stiffness"]
    last, into, lowest = at
    turning = track.turning[1:-1].tolist()

    def errors(s: float, stiffness: float, folds: bool) -> dict[str, float]:
        return fold_errors(line.line, line.equilibria, s, stiffness, folds=folds)

    at_loss = errors(last, k, last in turning)
    jumped = errors(into, k, False)
    pull = errors(lowest, 0.0, True)
    event = Jumps(*(np.array([each]) for each in (0, 0.0, last, math.nan, values["dissipated_energy"])))
    return {
        **at_loss,
        "dissipated_energy": loss_error(line.line, line.equilibria, event, k),
        "jump_in_indentation": jumped["indentation"],
        "jump_in_force": jumped["normal_force"],
        "jump_in_radius": jumped["contact_radius"],
        "largest_pull": max(pull["normal_force"], at_loss["normal_force"] if lowest == last else 0.0),
    }


def _claims(line: AdhesiveLine, values: Mapping[str, float], errors: Mapping[str, float]) -> dict[str, Claim]:
    """The claims of the law, with the errors of the map at these states."""
    everywhere = np.ones(1, dtype=bool)
    level, reason, source = theory_of(line.law).claim(line.law, line.contact.profile, line.line)
    claim = Claim(level, reason, source, everywhere)
    relative_errors = {name: np.array([error]) for name, error in errors.items()}
    states = states_at_depth(line.line, np.array([max(values["jump_in_indentation"], 0.0)]))
    claims = with_errors(
        dict.fromkeys(relative_errors, claim), relative_errors, map_remark(line.line, states)
    )
    if values["machine_stiffness"] == 0.0:
        why = "a dead load has no travel"
        claims["travel"] = Claim(Level.NOT_VALID, why, source, ~everywhere)
    return claims


def _adhesive(contact: Contact) -> AdhesiveLine:
    if not isinstance(contact, Contact) or contact.adhesion is None:
        raise ProblemError(
            "the contact has no adhesion; give Contact(..., adhesion=JKR('50 mJ/m^2')) or another law"
        )
    return AdhesiveLine(contact)


def _lowest_force(line: AdhesiveLine, passage: Route) -> float:
    """The parameter of the lowest force in a retraction: at an end of a stretch or at a fold of the force."""
    curve = under_machine(line.equilibria, float(np.max(passage.begin)), 0.0)
    folds, _ = turning_points(curve.slope, curve.start, curve.stop, curve.knots)
    visited = (folds[:, None] > passage.end) & (folds[:, None] < passage.begin)
    s = np.concatenate([folds[visited.any(axis=1)], passage.begin, passage.end])
    return float(s[np.argmin(curve.control(s))])


def _tip_radius(line: AdhesiveLine, profile: Profile) -> float | None:
    """Radius of curvature in m of a parabolic tip, g = x^2 / R; None for others."""
    if profile.tip_radius is not None:
        return profile.tip_radius
    x = line.natural_radius * np.array([1e-4, 2e-4])
    g = line.line.equivalent.g(x)
    return float(x[0] ** 2 / g[0]) if g[0] > 0.0 and abs(g[1] / g[0] - 4.0) < 1e-3 else None


def _pressed(line: AdhesiveLine, stiffness: float, pressed_to: QuantityLike | None) -> tuple[Track, Route]:
    """The curve under a machine, and the approach to the state at the start of the retraction."""

    def measure(s: FloatArray) -> FloatArray:
        return s if pressed_to is None else line.equilibria.states(s).indentation

    if pressed_to is None:
        try:
            unloaded = line.track(0.0, 0.0)
        except PathError as error:
            raise line.too_short(
                "the profile ends inside the contact of the unloaded body", math.inf
            ) from error
        target = _first_touch(line, unloaded, 0.0)
        track = unloaded if stiffness == 0.0 else line.track(stiffness, -math.inf, target)
    else:
        target = to_si(pressed_to, "m", name="pressed_to")
        if target <= 0.0:
            raise ProblemError(
                f"pull_off: pressed_to = {pressed_to!r}; the depth of pressing must be above 0 m"
            )
        track = line.track(stiffness, -math.inf, line.track(math.inf, target).curve.stop)
    _first_touch(line, track, stiffness)
    try:
        return track, pressed(track, measure, target)
    except PathError as error:
        raise line.too_short(
            "the contact would jump beyond the end of the profile in approach", stiffness
        ) from error


def _refuse_rings(line: AdhesiveLine, track: Track, stiffness: float, press: Route, pull: Route) -> None:
    if is_always_open(line.line, line.law):
        return

    def radii(s: FloatArray) -> FloatArray:
        return line.equilibria.states(s).contact_radius

    begin, end = (np.concatenate([getattr(press, name), getattr(pull, name)]) for name in ("begin", "end"))
    at_press = press.end.size - 1
    before = np.delete(np.append(0.0, radii(end)), at_press + 1)
    after = np.delete(np.append(radii(begin), 0.0), at_press + 1)
    control = np.delete(np.append(track.touch, track.curve.control(end)), at_press + 1)
    visited = Visited(
        row=np.zeros(begin.size, dtype=int),
        begin=radii(begin),
        end=radii(end),
        jump_row=np.zeros(before.size, dtype=int),
        stiffness=np.full(before.size, stiffness),
        control=control,
        before=before,
        after=after,
        loss=np.zeros(before.size),
    )
    certificate = certify_stretched_disk(line.line, visited, 1, line.law)
    if not certificate.disk.all():
        raise RefusedError(f"pull_off: {'; '.join((certificate.reason, *line.unsmoothed))}")


def _first_touch(line: AdhesiveLine, track: Track, stiffness: float) -> float:
    """Parameter in m of the state after the jump into contact."""
    into = track.jumps[2]
    if into.to[0] < 0:
        raise line.too_short("no stable state is known after first touch", stiffness)
    return float(into.after[0])


@dataclass(frozen=True, kw_only=True)
class AdhesionRegime(Study):
    """The appropriate law of adhesion of a contact, and the errors of the simpler ones."""

    data: xr.Dataset
    """
    Over ``law``: pull_off_force (N) under a dead load, and error, its relative difference from that of MaugisDugdale, NaN if
    there is none; tabor and maugis.
    """
    regime: str
    """``"JKR"``, ``"DMT"`` or ``"transition"``."""
    recommended: AdhesionLaw
    """The simplest law whose pull-off force is within 1 %, else MaugisDugdale; for graded bodies the nearer of JKR and DMT."""
    contacts: Mapping[str, Contact]
    """The contact under every law."""

    subject: ClassVar = "a regime of adhesion"
    columns: ClassVar = {
        "law": Column("law", ""),
        "pull_off_force": Column("pull-off", "N"),
        "error": Column("error", ""),
    }
    summary_claims: ClassVar = ("pull_off_force",)

    tabor = number(
        "tabor",
        "Tabor's parameter with the range of the law for z0; NaN for a tip that is not round. For graded bodies the ratio of the "
        "opening of the edge at the pull-off under a dead load to that range, scaled to agree for homogeneous bodies.",
    )
    maugis = number("maugis", "Maugis' parameter; NaN for a tip that is not round.")

    @property
    def pull_off_force(self) -> dict[str, float]:
        """Pull-off force in N under a dead load by law."""
        return self._by_law("pull_off_force")

    @property
    def error(self) -> dict[str, float]:
        """Relative error of the pull-off force of the simpler laws against MaugisDugdale, if there is one."""
        return {name: value for name, value in self._by_law("error").items() if math.isfinite(value)}

    def _by_law(self, name: str) -> dict[str, float]:
        return dict(zip(self.data["law"].values.tolist(), self.data[name].values.tolist(), strict=True))

    def _remarks(self) -> list[str]:
        return [
            f"regime: {self.regime} (Tabor's parameter {self.tabor:.3g}, Maugis' {self.maugis:.3g}; JKR above "
            f"{JKR_ABOVE:g}, DMT below {DMT_BELOW:g})",
            f"recommended: {type(self.recommended).__name__}",
        ]

    def _figure(self) -> Figure:
        """Force against indentation, and the pressure of the unloaded contact, under every law."""
        from pymdr.presentation.plot import compared_laws

        curves = {}
        push = max(-force for force in self.pull_off_force.values())
        for name, contact in self.contacts.items():
            line = AdhesiveLine(contact)
            track = line.track(0.0, push)
            curve = equilibrium_curve(line.equilibria, track.curve.stop, track.turning.tolist())
            drawn = curve["normal_force"] <= push
            curves[name] = {key: values[drawn] for key, values in curve.items()}
        unloaded = {name: solve(contact, load(0.0)) for name, contact in self.contacts.items()}
        widest = max(float(_edges(result).max()) for result in unloaded.values())
        pressures = {}
        for name, result in unloaded.items():
            r = [np.linspace(0.0, 1.5 * widest, 401)]
            for edge in _edges(result):
                r += [
                    edge * np.sin(np.linspace(0.0, 0.5 * np.pi, 121)),
                    edge * np.array([1.0 - 1e-9, 1.0 + 1e-9]),
                ]
            pressures[name] = result.field("pressure", np.unique(np.concatenate(r)))
        return compared_laws(curves, self.pull_off_force, pressures)


def _edges(result: Result) -> FloatArray:
    """Radii in m of the contact and of its cohesive zone, if there is one, in the last step."""
    names = ("contact_radius", "cohesive_radius")
    return np.array([result[name].values[-1] for name in names if name in result.data])


def adhesion_regime(contact: Contact, *, range: QuantityLike | None = None) -> AdhesionRegime:
    """
    The appropriate law of adhesion of a contact.

    mu = (R work^2 / (E*^2 z0^3))^(1/3) (Tabor 1977), lambda = 2 sigma0 (9 R / (16 pi work E*^2))^(1/3)
    (Maugis 1992), with sigma0 = work / range. The laws are compared by their pull-off forces.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion, for its work.
    range : quantity, optional
        Range of the attraction in m, typically 0.2 to 0.5 nm between clean solids; by default that of the law.

    Returns
    -------
    AdhesionRegime

    Raises
    ------
    ProblemError
        If the contact has no adhesion, or no range is known.

    See Also
    --------
    JKR : valid above.
    MaugisDugdale : valid between.
    DMT : valid below.

    References
    ----------
    - Tabor (1977), J. Colloid Interface Sci. 58, 2-13, doi:10.1016/0021-9797(77)90366-6.
    - Maugis (1992), J. Colloid Interface Sci. 150, 243-269, doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import pymdr as mdr
    >>> tip = mdr.Contact(mdr.Paraboloid("20 nm"), mdr.Elastic("70 GPa", 0.2), adhesion=mdr.JKR("50 mJ/m^2"))
    >>> found = mdr.adhesion_regime(tip, range="0.5 nm")
    >>> found.regime, round(found.maugis, 3)
    ('DMT', 0.048)
    """
    law = contact.adhesion if isinstance(contact, Contact) else None
    if law is None:
        raise ProblemError(
            "the contact has no adhesion; give Contact(..., adhesion=JKR('50 mJ/m^2')) or another law"
        )
    distance = _range(law, range)
    stress = law.work / distance
    if effective_moduli(contact.body, contact.counterbody).exponent != 0.0:
        return _graded_regime(contact, law.work, distance)
    laws: dict[str, AdhesionLaw] = {
        "MaugisDugdale": MaugisDugdale(law.work, range=distance),
        "JKR": JKR(law.work),
        "DMT": DMT(law.work, range=distance),
    }
    contacts = {name: replace(contact, adhesion=other) for name, other in laws.items()}
    pull_offs = {name: pull_off(one, machine_stiffness=0.0) for name, one in contacts.items()}
    force = {name: one.normal_force for name, one in pull_offs.items()}
    error = {name: force[name] / force["MaugisDugdale"] - 1.0 for name in ("JKR", "DMT")}
    best = min(error, key=lambda name: abs(error[name]))
    line = AdhesiveLine(replace(contact, adhesion=JKR(law.work)))
    modulus, radius = line.line.modulus, _tip_radius(line, contact.profile)
    tabor = maugis = math.nan
    if radius is not None:
        tabor = float(tabor_parameter(radius, modulus, law.work, distance))
        maugis = float(maugis_parameter(radius, modulus, law.work, stress))
    return _regime_of_laws(
        contacts,
        pull_offs,
        {"tabor": tabor, "maugis": maugis},
        {"MaugisDugdale": 0.0, **error},
        laws[best if abs(error[best]) <= _COST else "MaugisDugdale"],
    )


def _regime_of_laws(
    contacts: Mapping[str, Contact],
    pull_offs: Mapping[str, PullOff],
    parameters: Mapping[str, float],
    error: Mapping[str, float],
    recommended: AdhesionLaw,
) -> AdhesionRegime:
    """The regime from the pull-offs of all laws; without errors if no theory of the transition is known."""
    import xarray as xr

    everywhere, maugis = np.ones(len(pull_offs), dtype=bool), parameters["maugis"]
    simpler = {name: value for name, value in error.items() if name != "MaugisDugdale"}
    columns = {
        "pull_off_force": ("law", [one.normal_force for one in pull_offs.values()], {"units": "N"}),
        "error": ("law", [simpler.get(name, math.nan) for name in pull_offs], {"units": ""}),
    }
    single = {name: ((), value, {"units": ""}) for name, value in parameters.items()}
    numerics = [one.claims["normal_force"].error for one in pull_offs.values()]
    if error:
        reason = "each law against MaugisDugdale, which is exact for a constant stress up to its range"
        size = [
            abs(error[name]) + (0.0 if own is None else float(own[0]))
            for name, own in zip(pull_offs, numerics, strict=True)
        ]
        whole: FloatArray | None = np.minimum(size, 1.0)
    else:
        whole = None
        reason = "each law separately: no theory of the transition is known for graded bodies"
    force = Claim(Level.APPROXIMATE, reason, SOURCES["maugis"], everywhere, whole)
    defined = Claim(
        Level.EXACT, "by its definition, for a round tip", SOURCES["tabor"], np.ones(1, dtype=bool)
    )
    if math.isnan(maugis):
        defined = Claim(Level.NOT_VALID, "the tip is not round", SOURCES["tabor"], np.zeros(1, dtype=bool))
    elif not error:
        defined = replace(
            defined,
            level=Level.APPROXIMATE,
            reason="by the opening of the edge of a graded body, scaled",
            error=None,
        )
    return AdhesionRegime(
        data=xr.Dataset(columns | single, coords={"law": list(pull_offs)}),
        regime=_regime(maugis, simpler),
        recommended=recommended,
        contacts=contacts,
        claims={"pull_off_force": force, "tabor": defined, "maugis": defined},
        assumptions=pull_offs["JKR"].assumptions,
        notes=pull_offs["JKR"].notes,
        contact=contacts[type(recommended).__name__],
    )


def _graded_regime(contact: Contact, work: float, distance: float) -> AdhesionRegime:
    """The regime of a graded body, for which no theory of the transition is known."""
    laws: dict[str, AdhesionLaw] = {"JKR": JKR(work), "DMT": DMT(work, range=distance)}
    contacts = {name: replace(contact, adhesion=law) for name, law in laws.items()}
    pull_offs = {name: pull_off(one, machine_stiffness=0.0) for name, one in contacts.items()}
    opening = float(jkr_opening(AdhesiveLine(contacts["JKR"]).line, pull_offs["JKR"].contact_radius, work))
    tabor = opening / (distance * math.sqrt(2.0 * math.pi) * (9.0 * math.pi / 8.0) ** (1.0 / 6.0))
    maugis = 2.0 * (9.0 / (16.0 * math.pi)) ** (1.0 / 3.0) * tabor
    return _regime_of_laws(
        contacts, pull_offs, {"tabor": tabor, "maugis": maugis}, {}, laws["JKR" if maugis > 1.0 else "DMT"]
    )


def _range(law: AdhesionLaw, given: QuantityLike | None) -> float:
    own = theory_of(law).range(law)
    if given is not None:
        distance = to_si(given, "m", name="range")
        if distance <= 0.0:
            raise ProblemError(f"adhesion_regime: range = {given!r}; it must be above 0 m")
        return distance
    if own is None:
        raise ProblemError(
            f"adhesion_regime: {type(law).__name__} has no range of attraction; give "
            "adhesion_regime(contact, range='0.3 nm')"
        )
    return float(own)


def _regime(maugis: float, error: Mapping[str, float]) -> str:
    """By Maugis' parameter for round tips, by the pull-off forces for others."""
    if math.isnan(maugis):
        best = min(error, key=lambda name: abs(error[name]))
        return best if abs(error[best]) <= _COST else "transition"
    return "JKR" if maugis > JKR_ABOVE else "DMT" if maugis < DMT_BELOW else "transition"
