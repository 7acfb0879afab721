"""The work that a receding edge takes over its speed, of tests of bodies with memory, beside the formula of a short zone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.deferred import xr
from pymdr.interpretation.validity import SOURCES, Claim, Level
from pymdr.line.curves import ElasticLine
from pymdr.line.soft.small_zone import SmallZone
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation
from pymdr.result import Result
from pymdr.solving.memory import refuse_flow
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray

_PARTS = 300
"""Rows of a test: least step of the contact radius as a part of the largest."""
WITHIN = 0.1
"""Largest relative difference at which the formula is said to hold."""
_STEADY = 1.0
"""Lengths of its zone that the edge has receded before the formula may be said to hold: it needs a steady zone."""
_UNITS = {
    "test": "",
    "edge_speed": "m/s",
    "energy_release_rate": "J/m^2",
    "short_zone_work": "J/m^2",
    "difference": "",
    "zone_length": "m",
    "contact_radius": "m",
    "receded": "",
    "holds": "",
}


@dataclass(frozen=True, kw_only=True)
class EdgeWork(Study):
    """Energy release rate of the receding edge over its speed, beside the formula of a short zone, and the range in which that holds."""

    data: xr.Dataset
    """
    Over ``row``: test, edge_speed V (m/s), energy_release_rate G (J/m^2) by force and radius, ``short_zone_work`` (J/m^2) of the formula at
    V, its relative ``difference``, zone_length and contact_radius (m), ``receded``, the lengths of the zone that the edge has
    receded, and whether the formula ``holds``: within 10 % after one length. Single numbers: ``work``, ``fast_limit`` (J/m^2), and,
    of the rows in which it holds, ``lowest_speed``, ``highest_speed`` (m/s) and ``longest_zone`` over the contact radius.
    """
    subject: ClassVar = "the work of an edge"
    _drawn: ClassVar = ("edge_work_figure", "data")
    columns: ClassVar[Mapping[str, Column]] = {
        "test": Column("test", ""),
        "edge_speed": Column("speed of the edge", "m/s"),
        "energy_release_rate": Column("energy release rate", "J/m^2"),
        "short_zone_work": Column("short zone", "J/m^2"),
        "zone_length": Column("zone", "m"),
        "receded": Column("receded, in zones", ""),
        "difference": Column("difference", ""),
    }

    def groups(self) -> dict[str, dict[str, float]]:
        """The limits of the formula, and the range of speeds in which it holds."""
        return {
            "at rest": {"energy_release_rate": float(self.data["work"])},
            "limit of fast edges": {"energy_release_rate": float(self.data["fast_limit"])},
            "formula within 10 %, from": {"edge_speed": float(self.data["lowest_speed"])},
            "formula within 10 %, up to": {"edge_speed": float(self.data["highest_speed"])},
        }

    def _remarks(self) -> list[str]:
        if not self.data["holds"].values.any():
            return ["the formula of a short zone holds within 10 % in no row"]
        return [
            f"the formula of a short zone holds within 10 % for zones of up to {float(self.data['longest_zone']):.2g} contact radii, after the edge "
            "has receded by a length of its zone"
        ]


def edge_work_of(results: Sequence[Result], relaxation: Relaxation) -> EdgeWork:
    """
    The work of the receding edge in some tests of one contact.

    Parameters
    ----------
    results : sequence of Result
        Of a contact of bodies with memory and a cohesive zone.
    relaxation : Relaxation
        E*(t) in Pa.

    Raises
    ------
    ProblemError
        If the bodies flow at rest.

    Notes
    -----
    With the force F, the contact radius a and the relaxed modulus E, that the springs of the contact have one history gives their load
    at the edge, q_a = (F - F_0(a))/2a, and G = q_a^2 / 2 pi a E, whatever they have yet to relax; F_0 is the force of an elastic contact without
    adhesion. Speeds are those between rows.
    """
    contact = results[0].contact
    law = contact.adhesion
    assert law is not None
    assert law.attraction_range is not None
    refuse_flow(relaxation)
    zone = SmallZone(relaxation, law.work, law.work / law.attraction_range)
    line = ElasticLine(equivalent_profile(contact.profile), relaxation.rubbery)
    parts = [_of_test(result, zone, line) for result in results]
    rows = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    rows["test"] = np.repeat(np.arange(len(parts)), [part["edge_speed"].size for part in parts])
    rows["short_zone_work"] = zone.work_at(rows["edge_speed"])
    rows["difference"] = rows["short_zone_work"] / rows["energy_release_rate"] - 1.0
    rows["holds"] = (np.abs(rows["difference"]) <= WITHIN) & (rows["receded"] >= _STEADY)
    return EdgeWork(
        data=_dataset(rows, zone),
        claims=_claims(rows, results[0]),
        assumptions=results[0].assumptions,
        contact=contact,
        references=("haiat-barthel", "schapery"),
    )


def _of_test(result: Result, zone: SmallZone, line: ElasticLine) -> dict[str, FloatArray]:
    """Rows of the recession after the largest radius, and the errors of speed and energy release rate."""
    columns = {
        name: result.data[name].values
        for name in ("time", "contact_radius", "cohesive_radius", "normal_force")
    }
    a = columns["contact_radius"]
    start = a.size - 1 - int(np.argmax(a[::-1]))
    chosen, last = [start], float(a[start])
    for row in np.flatnonzero(a[start:] > 0.0)[1:] + start:
        if last - a[row] >= a[start] / _PARTS:
            chosen.append(int(row))
            last = float(a[row])
    at = np.array(chosen)
    t, a, c, force = (columns[name][at] for name in columns)
    errors = [result.claims[name].error for name in ("contact_radius", "normal_force")]
    wrong_a, wrong_force = (np.zeros(a.size) if one is None else one[at] for one in errors)
    bare = line.force(a)
    excess = bare - force
    G = excess**2 / (8.0 * math.pi * zone.relaxation.rubbery * a**3)
    wrong = wrong_force * np.abs(force) + line.force(a * (1.0 + wrong_a)) - bare
    wrong_G = 2.0 * wrong / np.abs(excess) + 3.0 * wrong_a
    step, middle = -np.diff(a), 0.5 * (G[1:] + G[:-1])
    length = 0.5 * ((c - a)[1:] + (c - a)[:-1])
    return {
        "edge_speed": step / np.diff(t),
        "energy_release_rate": middle,
        "zone_length": length,
        "contact_radius": 0.5 * (a[1:] + a[:-1]),
        "receded": (a[0] - 0.5 * (a[1:] + a[:-1])) / length,
        "speed_error": 2.0 * np.maximum(wrong_a[1:], wrong_a[:-1]) * a[:-1] / np.where(step > 0.0, step, 1.0),
        "rate_error": np.maximum(wrong_G[1:], wrong_G[:-1]) + 0.5 * np.abs(np.diff(G)) / middle,
    }


def _dataset(rows: Mapping[str, np.ndarray], zone: SmallZone) -> xr.Dataset:
    """The rows, and single numbers of the rows in which the formula holds."""
    V, fraction = (
        values[rows["holds"]] for values in (rows["edge_speed"], rows["zone_length"] / rows["contact_radius"])
    )
    single = {
        "work": (zone.work, "J/m^2"),
        "fast_limit": (zone.work * zone.relaxation.glassy / zone.relaxation.rubbery, "J/m^2"),
        "lowest_speed": (float(np.min(V)) if V.size else math.nan, "m/s"),
        "highest_speed": (float(np.max(V)) if V.size else math.nan, "m/s"),
        "longest_zone": (float(np.max(fraction)) if V.size else math.nan, ""),
    }
    return dataset(
        {name: ("row", rows[name], {"units": unit}) for name, unit in _UNITS.items()}
        | {name: ((), value, {"units": unit}) for name, (value, unit) in single.items()}
    )


def _claims(rows: Mapping[str, FloatArray], result: Result) -> dict[str, Claim]:
    everywhere = np.ones(rows["edge_speed"].size, dtype=bool)
    whole = replace(result.claims["jumped"], where=everywhere, error=None)

    def claim(reason: str, error: FloatArray, source: str = whole.source) -> Claim:
        return Claim(Level.APPROXIMATE, reason, source, everywhere, np.minimum(error, 1.0))

    return {
        "energy_release_rate": claim(
            "from force and contact radius, for a cohesive zone that is short compared with the contact; the errors are those of force and radius, and of the spacing of rows",
            rows["rate_error"],
        ),
        "edge_speed": claim("mean between two rows; the error is that of their radii", rows["speed_error"]),
        "short_zone_work": claim(
            "formula of a short zone that moves steadily; the error is the measured difference",
            np.abs(rows["difference"]),
            SOURCES["schapery"],
        ),
    }
