"""The regime of adhesion: which law holds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.branches import equilibrium_curve
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.line.adhesion import DMT_BELOW, JKR_ABOVE, jkr_opening, maugis_parameter, tabor_parameter
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.laws import DMT, JKR, AdhesionLaw, MaugisDugdale
from pymdr.problem.paths import load
from pymdr.result import Result
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.pulloff import COST, PullOff, elastic_pull_off, tip_radius
from pymdr.solving.study import Column, Study, dataset, number
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, to_si


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

    def _figure(self) -> mpl.figure.Figure:
        """Force against indentation, and the pressure of the unloaded contact, under every law."""
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
        return plot.compared_laws(curves, self.pull_off_force, pressures)


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
        Tabor's and Maugis' parameters, pull-off force (N) of every law, and the simplest appropriate law,
        ``recommended``.

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
    >>> result = mdr.adhesion_regime(tip, range="0.5 nm")
    >>> result.regime, round(result.maugis, 3)
    ('DMT', 0.048)
    """
    law = require_contact(contact).adhesion
    if law is None:
        raise ProblemError(
            "the contact has no adhesion; give Contact(..., adhesion=JKR('50 mJ/m^2')) or another law"
        )
    if law.has_hysteresis:
        law = JKR(law.works[1])  # a receding edge decides about pull-off
        contact = replace(contact, adhesion=law)
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
    pull_offs = {name: elastic_pull_off(one, machine_stiffness=0.0) for name, one in contacts.items()}
    force = {name: one.normal_force for name, one in pull_offs.items()}
    error = {name: force[name] / force["MaugisDugdale"] - 1.0 for name in ("JKR", "DMT")}
    best = min(error, key=lambda name: abs(error[name]))
    line = AdhesiveLine(replace(contact, adhesion=JKR(law.work)))
    modulus, radius = line.line.modulus, tip_radius(line, contact.profile)
    tabor = maugis = math.nan
    if radius is not None:
        tabor = float(tabor_parameter(radius, modulus, law.work, distance))
        maugis = float(maugis_parameter(radius, modulus, law.work, stress))
    return _regime_of_laws(
        contacts,
        pull_offs,
        {"tabor": tabor, "maugis": maugis},
        {"MaugisDugdale": 0.0, **error},
        laws[best if abs(error[best]) <= COST else "MaugisDugdale"],
    )


def _regime_of_laws(
    contacts: Mapping[str, Contact],
    pull_offs: Mapping[str, PullOff],
    parameters: Mapping[str, float],
    error: Mapping[str, float],
    recommended: AdhesionLaw,
) -> AdhesionRegime:
    """The regime from the pull-offs of all laws; without errors if no theory of the transition is known."""
    everywhere, maugis = np.ones(len(pull_offs), dtype=bool), parameters["maugis"]
    simpler = {name: value for name, value in error.items() if name != "MaugisDugdale"}
    columns = {
        "pull_off_force": ("law", [one.normal_force for one in pull_offs.values()], {"units": "N"}),
        "error": ("law", [simpler.get(name, math.nan) for name in pull_offs], {"units": ""}),
    }
    single = {name: ((), value, {"units": ""}) for name, value in parameters.items()}
    numerics = [one.claims["normal_force"].error for one in pull_offs.values()]
    if error:
        reason = "each law compared with MaugisDugdale, which is exact for a constant stress up to its range"
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
        data=dataset(columns | single, coords={"law": list(pull_offs)}),
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
    pull_offs = {name: elastic_pull_off(one, machine_stiffness=0.0) for name, one in contacts.items()}
    opening = float(jkr_opening(AdhesiveLine(contacts["JKR"]).line, pull_offs["JKR"].contact_radius, work))
    tabor = opening / (distance * math.sqrt(2.0 * math.pi) * (9.0 * math.pi / 8.0) ** (1.0 / 6.0))
    maugis = 2.0 * (9.0 / (16.0 * math.pi)) ** (1.0 / 3.0) * tabor
    return _regime_of_laws(
        contacts, pull_offs, {"tabor": tabor, "maugis": maugis}, {}, laws["JKR" if maugis > 1.0 else "DMT"]
    )


def _range(law: AdhesionLaw, given: QuantityLike | None) -> float:
    """The range of attraction in m: the given one, or that of the law."""
    own = theory_of(law).range(law)
    if given is not None:
        distance = to_si(given, "m", name="range")
        if distance <= 0.0:
            raise ProblemError(f"range = {given!r}; it must be above 0 m")
        return distance
    if own is None:
        raise ProblemError(
            f"{type(law).__name__} has no range of attraction; give adhesion_regime(contact, range='0.3 nm')"
        )
    return float(own)


def _regime(maugis: float, error: Mapping[str, float]) -> str:
    """By Maugis' parameter for round tips, by the pull-off forces for others."""
    if math.isnan(maugis):
        best = min(error, key=lambda name: abs(error[name]))
        return best if abs(error[best]) <= COST else "transition"
    return "JKR" if maugis > JKR_ABOVE else "DMT" if maugis < DMT_BELOW else "transition"
