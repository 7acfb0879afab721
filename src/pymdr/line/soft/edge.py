"""Compiled equation of the contact radius behind a zone that is short compared with it. Loads numba."""

from __future__ import annotations

import math

import numpy as np

from pymdr.compiling import compiled, inner
from pymdr.line.soft.kernels import cubics
from pymdr.units import FloatArray

BEGIN, CONTROL, SLOPE, MACHINE, RUBBERY, GLASSY, TOP, CLOSED, WORK, UNIT, SHORTEST = range(11)
"""Time [s], control [m or N] and its rate at the begin of a stretch, stiffness of the machine [N/m], E_inf and E_0 [Pa], end of the profile's
table and the radius at which a contact rests as closed [m], γ [J/m²], π γ E_inf/4σ² [m], logarithm of the shortest passing time [s]."""
MODULUS, TIME = range(2)
"""Rows of the springs: E_i [Pa], τ_i [s]."""
PASSING, MEAN, ADVANCE, FACTOR = range(4)
"""Rows of a zone's table: logarithms of passing times, γ/G of recession, G/γ and M of advance."""


@inner
def interpolated(x: float, table: FloatArray, known: int, wanted: int) -> float:
    """A row of a table at a value within another, which rises."""
    low, high = 0, table.shape[1] - 1
    while high - low > 1:
        middle = (low + high) >> 1
        if table[known, middle] <= x:
            low = middle
        else:
            high = middle
    fraction = (x - table[known, low]) / (table[known, high] - table[known, low])
    return float(table[wanted, low] + fraction * (table[wanted, high] - table[wanted, low]))


@compiled
def speed(release: float, table: FloatArray, unit: float, shortest: float) -> float:
    """da/dt [m/s] of an edge at G/γ, below 0 where it recedes, that of the shortest passing time beyond the limits."""
    last = table.shape[1] - 1
    place = shortest
    if release >= 1.0:
        if 1.0 / release >= table[MEAN, last]:
            return 0.0
        if 1.0 / release > table[MEAN, 0]:
            place = max(interpolated(1.0 / release, table, MEAN, PASSING), shortest)
        return -release * unit / math.exp(place)
    if release >= table[ADVANCE, last]:
        return 0.0
    factor = table[FACTOR, 0]
    if release > table[ADVANCE, 0]:
        place = interpolated(release, table, ADVANCE, PASSING)
        factor = interpolated(place, table, PASSING, FACTOR)
    return float(unit / (factor * math.exp(max(place, shortest))))


@compiled
def state(
    t: float, y: FloatArray, setting: FloatArray, springs: FloatArray, profile: FloatArray
) -> tuple[float, float, float, float]:
    """Depth, force, Q and q_a at a time, for a contact radius and displacements of the dashpots."""
    a, k = max(y[0], 0.1 * setting[CLOSED]), setting[MACHINE]
    g, area = cubics(profile, math.sqrt(a / setting[TOP]) * (profile.shape[1] - 1))
    control = setting[CONTROL] + setting[SLOPE] * (t - setting[BEGIN])
    branches, rest, firm = 0.0, setting[RUBBERY] * area, setting[GLASSY]
    for i in range(springs.shape[1]):
        branches += springs[MODULUS, i] * y[1 + i]
    if k == 0.0:
        Q = (0.5 * control + rest) / a
        d = (Q + branches) / firm
    else:
        d = (control + 2.0 / k * (a * branches + rest)) / (1.0 + 2.0 * a * firm / k)
        Q = firm * d - branches
    return d, 2.0 * (a * Q - rest), Q, Q - setting[RUBBERY] * g


@compiled
def rates(
    t: float,
    y: FloatArray,
    setting: FloatArray,
    springs: FloatArray,
    profile: FloatArray,
    table: FloatArray,
) -> FloatArray:
    """Rates of the contact radius and of the displacements of the dashpots."""
    out = np.empty(y.size)
    d, _, _, load = state(t, y, setting, springs, profile)
    closed = setting[CLOSED]
    released = min(load, 0.0) ** 2 / (2.0 * math.pi * max(y[0], 0.1 * closed) * setting[RUBBERY])
    out[0] = speed(released / setting[WORK], table, setting[UNIT], setting[SHORTEST])
    if out[0] < 0.0:
        # a contact that closes comes to rest, instead of an event that a step may pass
        out[0] *= min(max(y[0] / closed - 1.0, 0.0), 1.0)
    for i in range(springs.shape[1]):
        out[1 + i] = (d - y[1 + i]) / springs[TIME, i]
    return out
