"""Springs of cohesive zones with memory: their relaxation over the times of a path, and the size of the largest zone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.theories import equilibria_of
from pymdr.line.curves import ElasticLine
from pymdr.line.soft.small_zone import ShortSprings, SmallZone
from pymdr.line.soft.springs import FINE, ROUGH, ZoneLevel, ZoneSetting, ZoneSprings
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.materials import Elastic, Material, Rigid
from pymdr.problem.rheology import Prony
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.memory import powers_of, refuse_flow, refuse_rigid, surfaces_of
from pymdr.units import FloatArray, metres

_GROWTH = 1.1
_LONGEST = 0.2
"""Largest length of a short zone at rest over the contact radius."""
_MANY, _NODES_OF_PROBE, _LEAST_NODES, _SHORTENED = 40_000, (20_000, 150_000), 2.0, 0.5
"""Number of nodes above which zones are measured by a rough solution; its nodes, first and at most, those in the shortest zone, and the part of that zone for
which springs are made, since it is measured in rows only."""
_FIRST, _ERROR = 0.25, 1e-4
"""Shortest time of the series of a power of time over the shortest step of a path, since an edge passes its zone fast; and error of the series."""


def zone_relaxation(
    contact: Contact, span: tuple[float, float] | None, level: ZoneLevel = FINE
) -> Relaxation:
    """
    E*(t) of the bodies of a contact, with an instantaneous modulus.

    Parameters
    ----------
    span : tuple of float or None
        Shortest step and length of a path in s, over which powers of time are represented; None if there are none.
    level : ZoneLevel, optional
        Coarser levels have shorter series, so that their difference contains the error of the series.
    """
    powers = powers_of(contact)
    if not powers:
        return relaxation_of(*surfaces_of(contact))
    assert span is not None
    times = _FIRST * level.spacing * span[0], span[1]
    error = _ERROR * level.spacing
    series: dict[Any, Relaxation] = {one: one.softened(times, error) for one in powers}

    def finite(body: Any) -> Material:
        kernel = series.get(getattr(body, "shear", None))
        changed: Material = body
        if kernel is not None:
            changed = replace(body, shear=Prony(0.0, kernel.moduli, kernel.times))
        return changed

    relaxation = relaxation_of(*map(finite, surfaces_of(contact)))
    return replace(relaxation, error=max(one.error for one in series.values()))


def zone_setting(
    contact: Contact,
    relaxation: Relaxation,
    targets: Mapping[float, float],
    longest: float = math.inf,
) -> ZoneSetting:
    """
    The springs of a contact, and its largest zone: that of an elastic body with the softest modulus of the path.

    Parameters
    ----------
    relaxation : Relaxation
        E*(t) of its bodies.
    targets : mapping of float to float
        Largest targets in m, or in N for 0, by the machine stiffness in N/m.
    longest : float
        Duration of the path in s. Bodies that flow at rest are refused where it is inf.
    """
    refuse_rigid(relaxation)
    if math.isinf(longest):
        refuse_flow(relaxation)
    softest = relaxation.softest(longest)
    law = contact.adhesion
    assert law is not None
    assert law.cohesive_stress is not None
    line = AdhesiveLine(replace(contact, body=Elastic(softest, 0.0), counterbody=Rigid()))
    try:
        stops = [line.stop(k, top) for k, top in sorted(targets.items())]
    except ConvergenceError as error:
        raise ProblemError(str(error)) from error
    # theories of cohesive zones need a profile that increases up to the end
    equilibria_of(law, contact.profile, line.line, max(stops))
    widest = float(np.max(line.equilibria.states(np.array(stops)).cohesive_radius))
    refuse_edge(line, _GROWTH * 1.2 * widest)
    # of a contact that is long compared with it (Maugis 1992)
    shortest = math.pi * law.work * softest / (4.0 * law.cohesive_stress**2)
    return ZoneSetting(
        relaxation, shortest, law.cohesive_stress, law.work, springs_of(line), _GROWTH * widest
    )


def with_measured_zone(
    setting: ZoneSetting, follow: Callable[[ZoneSprings], Mapping[str, FloatArray]]
) -> ZoneSetting:
    """
    A setting with the shortest zone of a path, where the zone of the softest contact at rest needs many nodes.

    Moving zones are longer, and contacts need not reach their size at rest.

    Parameters
    ----------
    follow : callable
        The rows of springs along the path.
    """
    if setting.nodes <= _MANY:
        return setting
    for most in _NODES_OF_PROBE:
        level = ROUGH._replace(spacing=max(ROUGH.spacing, setting.nodes / most), most=math.inf)
        try:
            rows = follow(ZoneSprings(setting, level))
        except ConvergenceError:  # too few nodes
            continue
        a, c = rows["contact_radius"], rows["cohesive_radius"]
        zone = float(np.min((c - a)[c > 0.0], initial=math.inf))
        if _LEAST_NODES * setting.spacing(level) < zone < math.inf:
            shortest, widest = max(_SHORTENED * zone, setting.shortest_zone), _GROWTH * float(c.max())
            return replace(setting, shortest_zone=shortest, widest=min(widest, setting.widest))
    return setting


def short_springs(contact: Contact, relaxation: Relaxation) -> ShortSprings:
    """The springs of a contact of bodies with E*(t) under adhesion of short range, in the name of a verb."""
    refuse_rigid(relaxation)
    if relaxation.rubbery == 0.0:
        raise ProblemError(
            "JKR(work, range=...) needs a body that relaxes to a finite modulus: the energy release rate of the relaxed body moves the edge "
            "(Schapery 1975). This body flows at rest; use MaugisDugdale(work, range=...)"
        )
    law = contact.adhesion
    assert law is not None
    assert law.attraction_range is not None
    zone = SmallZone(relaxation, law.work, law.work / law.attraction_range)
    line = AdhesiveLine(
        replace(contact, body=Elastic(relaxation.rubbery, 0.0), counterbody=Rigid(), adhesion=JKR(law.work))
    )
    size = line.natural_radius
    rest = float(zone.zone_length(law.work))
    if rest > _LONGEST * size:
        raise ProblemError(
            f"adhesion range = {metres(law.attraction_range)}: the cohesive zone at rest would be {metres(rest)} long, more than {_LONGEST:g} of the contact "
            f"radius without load, {metres(size)}; use MaugisDugdale(work, range=...), which has no such limit"
        )
    refuse_edge(line, math.inf)
    return ShortSprings(zone, springs_of(line), size, line.end)


def refuse_edge(line: AdhesiveLine, radius: float) -> None:
    """Refuse zones up to a radius in m that would reach the sharp edge of the profile, in the name of a verb."""
    if line.line.edge < radius:
        raise ProblemError(
            f"the zone would reach the sharp edge of the profile at r = {metres(line.line.edge)}, which is not covered with memory; use a "
            "wider profile or a smaller load"
        )


def springs_of(line: AdhesiveLine) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    """g(x) in m and its integral from 0 in m^2."""
    elastic = line.line
    assert isinstance(elastic, ElasticLine)

    def profile(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        inside = np.minimum(x, min(elastic.max_radius, 1e300))
        g = elastic.depth(inside)
        # F0 = 2 E (a g - int g)
        return g, inside * g - elastic.force(inside) / (2.0 * elastic.modulus)

    return profile
