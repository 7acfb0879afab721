"""Pull-off and jump-in of bodies without memory, without a path."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError, RefusedError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.adhesion import Visited, certify_stretched_disk, is_always_open
from pymdr.interpretation.adhesive_accuracy import fold_errors, loss_error
from pymdr.interpretation.branches import equilibrium_curve
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import Claim, Level
from pymdr.line.adhesion.equivalent_line import States
from pymdr.line.following import Jumps, Route, Track, pressed, pulled, turning_points, under_machine
from pymdr.line.foundation import states_at_depth
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.profiles import Profile
from pymdr.problem.values import read_stiffness
from pymdr.quantities import quantity
from pymdr.solving.adhesive import HystereticLine
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.mapped import assumptions, map_remark
from pymdr.solving.study import Study, dataset, number
from pymdr.units import FloatArray, QuantityLike, to_si

COST = 0.01


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

    def _figure(self) -> mpl.figure.Figure:
        assert self.contact is not None
        curves, lines = [], _curves_of(self.contact)
        for line in lines:
            largest = max(self.jump_in_radius, self.contact_radius)
            track = line.track(math.inf, max(self.indentation, self.jump_in_indentation), largest)
            curves.append(equilibrium_curve(line.equilibria, track.curve.stop, track.turning.tolist()))
        advancing, receding = curves
        if lines[0] is not lines[1]:
            advancing = {
                name: np.concatenate([values, [math.nan], receding[name]])
                for name, values in advancing.items()
            }
        return plot.pull_off_figure(advancing, self.data)


def elastic_pull_off(
    contact: Contact,
    *,
    machine_stiffness: QuantityLike = math.inf,
    pressed_to: QuantityLike | None = None,
    preload: QuantityLike | None = None,
) -> PullOff:
    """
    :func:`pymdr.pull_off` of bodies without memory.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.

    Raises
    ------
    ProblemError
        If the contact has no adhesion, or the stiffness is negative.
    PathError
        If the profile ends before the state at the start of the retraction.
    """
    line, receding = _curves_of(adhesive(contact))
    stiffness = read_stiffness(machine_stiffness)
    track, press = _pressed(line, stiffness, pressed_to, preload)
    if line is receding:
        away, pull = track, pulled(track, press.branch, press.last)
    else:
        away = receding.track(stiffness, -math.inf, press.last)
        pull = pulled(away, None, press.last)
    _refuse_rings(line, (track, away), stiffness, press, pull)
    into = track.jumps[2].after
    state, touched = (
        curve.equilibria.states(np.asarray(s)) for curve, s in ((receding, [pull.last]), (line, into))
    )
    d, force, radius = _numbers(state)
    jump = _numbers(touched)
    lowest = _lowest_force(receding, pull)
    loss = pull.loss if stiffness > 0.0 else receding.fallen(pull.last, force)
    values = {
        "normal_force": force,
        "indentation": d,
        "contact_radius": radius,
        "travel": d + force / stiffness if stiffness > 0.0 else math.nan,
        "dissipated_energy": loss,
        **dict(zip(("jump_in_indentation", "jump_in_force", "jump_in_radius"), jump, strict=True)),
        "largest_pull": float(receding.equilibria.states(np.array([lowest])).normal_force[0]),
        "machine_stiffness": stiffness,
    }
    largest = np.array([radius, jump[2], *line.equilibria.states(press.end).contact_radius])
    opening = theory_of(receding.law).opening(receding.law, line.line, largest)
    errors = _errors((line, receding), away, (pull.last, float(into[0]), lowest), values)
    return PullOff(
        data=single(values),
        claims=_claims(contact, line, values, errors),
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
    "largest_pull_indentation": "m",
    "largest_pull_radius": "m",
    "machine_stiffness": "N/m",
}


def start_of_retraction(pressed_to: QuantityLike | None, preload: QuantityLike | None) -> float | None:
    """Indentation in m, or force in N, at which a retraction starts; None if neither is given."""
    if pressed_to is not None and preload is not None:
        raise ProblemError("both pressed_to and preload given; give one of them")
    if preload is not None:
        force = to_si(preload, "N", name="preload")
        if not 0.0 <= force < math.inf:
            raise ProblemError(f"preload = {preload!r}; a finite force of at least 0 N is needed")
        return force
    if pressed_to is None:
        return None
    depth = to_si(pressed_to, "m", name="pressed_to")
    if not 0.0 < depth < math.inf:
        raise ProblemError(f"pressed_to = {pressed_to!r}; the depth of pressing must be above 0 m")
    return depth


def single(values: Mapping[str, float]) -> xr.Dataset:
    """Single numbers with their units as a dataset."""
    return dataset({name: ((), value, {"units": unit_of(name)}) for name, value in values.items()})


def unit_of(name: str) -> str:
    """The SI unit of a number of a pull-off."""
    return _UNITS[name] if name in _UNITS else quantity(name).unit


def _errors(
    lines: tuple[AdhesiveLine, AdhesiveLine],
    track: Track,
    at: tuple[float, float, float],
    values: Mapping[str, float],
) -> dict[str, float]:
    """Relative errors of the last state, the state after the jump into contact, and the lowest force; of the curves of approach and retraction."""
    k = values["machine_stiffness"]
    last, into, lowest = at
    turning = track.turning[1:-1].tolist()

    def errors(line: AdhesiveLine, s: float, stiffness: float, folds: bool) -> dict[str, float]:
        return fold_errors(line.line, line.equilibria, s, stiffness, folds=folds)

    approaching, line = lines
    at_loss = errors(line, last, k, last in turning)
    jumped = errors(approaching, into, k, False)
    pull = errors(line, lowest, 0.0, True)
    event = Jumps(*(np.array([each]) for each in (0, 0.0, last, math.nan, values["dissipated_energy"])))
    return {
        **at_loss,
        "dissipated_energy": loss_error(line.line, line.equilibria, event, k),
        "jump_in_indentation": jumped["indentation"],
        "jump_in_force": jumped["normal_force"],
        "jump_in_radius": jumped["contact_radius"],
        "largest_pull": max(pull["normal_force"], at_loss["normal_force"] if lowest == last else 0.0),
    }


def _claims(
    contact: Contact, line: AdhesiveLine, values: Mapping[str, float], errors: Mapping[str, float]
) -> dict[str, Claim]:
    """The claims of the law, with the errors of the map at these states."""
    everywhere = np.ones(1, dtype=bool)
    assert contact.adhesion is not None
    level, reason, source = theory_of(contact.adhesion).claim(contact.adhesion, contact.profile, line.line)
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


def _curves_of(contact: Contact) -> tuple[AdhesiveLine, AdhesiveLine]:
    """The curves of an edge that advances and recedes, the same one without hysteresis."""
    if contact.adhesion is not None and contact.adhesion.has_hysteresis:
        lines = HystereticLine(contact)
        return lines.advancing, lines.receding
    line = AdhesiveLine(contact)
    return line, line


def adhesive(contact: Contact) -> Contact:
    """The contact, refused without a law of adhesion."""
    if require_contact(contact).adhesion is None:
        raise ProblemError(
            "the contact has no adhesion; give Contact(..., adhesion=JKR('50 mJ/m^2')) or another law"
        )
    return contact


def _lowest_force(line: AdhesiveLine, passage: Route) -> float:
    """The parameter of the lowest force in a retraction: at an end of a stretch or at a fold of the force."""
    curve = under_machine(line.equilibria, float(np.max(passage.begin)), 0.0)
    folds, _ = turning_points(curve.slope, curve.start, curve.stop, curve.knots)
    visited = (folds[:, None] > passage.end) & (folds[:, None] < passage.begin)
    s = np.concatenate([folds[visited.any(axis=1)], passage.begin, passage.end])
    return float(s[np.argmin(curve.control(s))])


def tip_radius(line: AdhesiveLine, profile: Profile) -> float | None:
    """Radius of curvature in m of a parabolic tip, g = x^2 / R; None for others."""
    if profile.tip_radius is not None:
        return profile.tip_radius
    x = line.natural_radius * np.array([1e-4, 2e-4])
    g = line.line.equivalent.g(x)
    return float(x[0] ** 2 / g[0]) if g[0] > 0.0 and abs(g[1] / g[0] - 4.0) < 1e-3 else None


def _pressed(
    line: AdhesiveLine, stiffness: float, pressed_to: QuantityLike | None, preload: QuantityLike | None
) -> tuple[Track, Route]:
    """The curve under a machine, and the approach to the state at the start of the retraction."""
    target = start_of_retraction(pressed_to, preload)
    quantity = "indentation" if preload is None else "normal_force"

    def measure(s: FloatArray) -> FloatArray:
        if quantity == "parameter":
            return s
        states = line.equilibria.states(s)
        return states.normal_force if quantity == "normal_force" else states.indentation

    if target is None:
        try:
            unloaded = line.track(0.0, 0.0)
        except PathError as error:
            raise line.too_short(
                "the profile ends inside the contact of the unloaded body", math.inf
            ) from error
        target, quantity = _first_touch(line, unloaded, 0.0), "parameter"
        track = unloaded if stiffness == 0.0 else line.track(stiffness, -math.inf, target)
    else:
        reached = line.track(math.inf if preload is None else 0.0, target)
        track = line.track(stiffness, -math.inf, reached.curve.stop)
    _first_touch(line, track, stiffness)
    try:
        return track, pressed(track, measure, target)
    except PathError as error:
        raise line.too_short(
            "the contact would jump beyond the end of the profile in approach", stiffness
        ) from error


def _refuse_rings(
    line: AdhesiveLine, tracks: tuple[Track, Track], stiffness: float, press: Route, pull: Route
) -> None:
    if is_always_open(line.line, line.law):
        return

    def radii(s: FloatArray) -> FloatArray:
        return line.equilibria.states(s).contact_radius

    begin, end = (np.concatenate([getattr(press, name), getattr(pull, name)]) for name in ("begin", "end"))
    at_press = press.end.size - 1
    before = np.delete(np.append(0.0, radii(end)), at_press + 1)
    after = np.delete(np.append(radii(begin), 0.0), at_press + 1)
    levels = [track.curve.control(route.end) for track, route in zip(tracks, (press, pull), strict=True)]
    control = np.delete(np.concatenate([[tracks[0].touch], *levels]), at_press + 1)
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
        raise RefusedError(f"{'; '.join((certificate.reason, *line.unsmoothed))}")


def _first_touch(line: AdhesiveLine, track: Track, stiffness: float) -> float:
    """Parameter in m of the state after the jump into contact."""
    into = track.jumps[2]
    if into.to[0] < 0:
        raise line.too_short("no stable state is known after first touch", stiffness)
    return float(into.after[0])
