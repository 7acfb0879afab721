"""Creep of free springs: the modes of Maxwell branches, a spring and a dashpot in parallel to each other."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.spectra import Fractions, zeros_between
from pymdr.units import FloatArray

W, FREE, REST, TURN, BRANCHES = range(5)
"""Columns of a state, one spring per row: w; 1 where it is free; then w less its modes; at which part of a step it last changed
sides; and from BORNE on the forces of its branches, or the amplitudes of the modes of a free one."""


class Modes(NamedTuple):
    """
    Amplitudes m with m' = -rates m, w = rest + participation . m, energy |m|^2 / 2.

    rest is 0 with an equilibrium modulus and stays what it is without one.
    """

    rates: FloatArray
    """(k,) in 1/s, above 0."""
    participation: FloatArray
    """(k,) deflection of a unit amplitude."""
    to_modes: FloatArray
    """(k, n + 1) from the forces of the branches and w to m."""
    to_branches: FloatArray
    """(n, k) back to the forces of the branches."""


@lru_cache(maxsize=32)
def modes_of(body: Relaxation) -> Modes:
    """
    Modes of a body at zero force.

    With u = h / sqrt(E_j), b = sqrt(E_j), D = 1/tau: without a dashpot u' = -(1 - b b^T / E_g) D u, which D^(1/2) makes
    symmetric; with one, and u_0 = sqrt(E_inf) w beside the others, u' = -(D + b b^T / eta) u. The rates are the x at which
    s E*(s) of s = -x is 0. Branches of the same time move as one; what they bear against each other decays alone.
    """
    decay, group = np.unique(1.0 / body.times, return_inverse=True)
    moduli = np.bincount(group, body.moduli, decay.size).astype(float)
    roots = np.sqrt(moduli)
    rates, away = zeros_between(Fractions(body.equilibrium, moduli, decay, body.viscosity))
    if body.viscosity > 0.0:
        solid = body.equilibrium > 0.0
        q, norm = (
            _vectors(np.append(0.0, decay), np.column_stack([-rates, away]))
            if solid
            else _vectors(decay, away)
        )
        rest = q[:, 0] * np.sqrt(body.equilibrium) if solid else np.zeros(rates.size)
        q = q[:, int(solid) :]
        to_modes, to_branches = q / roots, roots[:, None] * q.T
        participation = -norm / (rates * np.sqrt(body.viscosity))
    else:
        rest = np.zeros(rates.size)
        # the flow of a liquid is a mode of the rate 0, which no free spring has
        q, norm = _vectors(decay, away if body.equilibrium > 0.0 else np.vstack([decay, away]))
        q, norm = q[q.shape[0] - rates.size :], norm[norm.size - rates.size :]
        scale = np.sqrt(rates)[:, None]
        to_modes, to_branches = q / scale * (np.sqrt(decay) / roots), (q * scale * (roots / np.sqrt(decay))).T
        participation = -norm / np.sqrt(rates * body.glassy)
    into = [np.column_stack([to_modes[:, group], rest])]
    back = [(body.moduli / moduli[group])[:, None] * to_branches[group]]
    all_rates, all_participations = [rates], [participation]
    for g in np.flatnonzero(np.bincount(group, minlength=decay.size) > 1):
        own = np.flatnonzero(group == g)
        bare = np.sqrt(body.moduli[own])
        distinct = np.zeros((own.size - 1, body.moduli.size + 1))
        distinct[:, own] = np.linalg.qr(bare[:, None], mode="complete")[0][:, 1:].T
        into.append(distinct.copy())
        into[-1][:, own] /= bare
        back.append((distinct[:, :-1] * np.sqrt(body.moduli)).T)
        all_rates.append(np.full(own.size - 1, decay[g]))
        all_participations.append(np.zeros(own.size - 1))
    return Modes(
        np.concatenate(all_rates),
        np.concatenate(all_participations),
        np.ascontiguousarray(np.vstack(into)),
        np.ascontiguousarray(np.hstack(back)),
    )


def _vectors(poles: FloatArray, away: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Eigenvectors norm_i z_j/away_ij, one a row, of diag(poles) + z z^T or - z z^T, and their norms.

    z is that whose eigenvalues are exactly those given, so that the vectors are orthogonal: Gu and Eisenstat (1994), SIAM
    J. Matrix Anal. Appl. 15, 1266. No difference loses digits, however many decades the poles span.
    """
    gaps = poles[:, None] - poles
    np.fill_diagonal(gaps, 1.0)
    z = np.sqrt(np.abs(np.prod(away.T / gaps, axis=1)))
    vectors = z / away
    norm = 1.0 / np.sqrt((vectors**2).sum(axis=1))
    return vectors * norm[:, None], norm


def unpacked(
    deflection: FloatArray,
    branches: FloatArray,
    loose: FloatArray,
    size: int,
    relaxation: Relaxation,
    modes: Modes,
) -> FloatArray:
    """
    The state of the kernels, one spring per row: w, whether it is free, w less its modes, room, and its branches or modes.

    From w, forces of the branches and 1 where a spring is loose, of the first of `size` springs; nothing has touched the rest.
    """
    n, k, known = relaxation.moduli.size, modes.rates.size, deflection.size
    state = np.zeros((size, BRANCHES + max(n, k)))
    state[:, FREE] = 1.0
    if known == 0:
        return state
    state[:known, W], state[:known, FREE] = deflection, loose
    state[:known, BRANCHES : BRANCHES + n] = branches
    free = np.flatnonzero(loose != 0.0)
    amplitudes = np.column_stack([branches[free], deflection[free]]) @ modes.to_modes.T
    state[free, BRANCHES:] = 0.0
    state[free, BRANCHES : BRANCHES + k] = amplitudes
    if relaxation.equilibrium == 0.0:
        state[free, REST] = deflection[free] - amplitudes @ modes.participation
    return state


def packed(
    state: FloatArray, relaxation: Relaxation, modes: Modes
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The inverse of :func:`unpacked`: w, forces of the branches, and 1 where a spring is loose."""
    loose = state[:, FREE] != 0.0
    h = state[:, BRANCHES : BRANCHES + relaxation.moduli.size].copy()
    h[loose] = state[loose, BRANCHES : BRANCHES + modes.rates.size] @ modes.to_branches.T
    return state[:, W].copy(), h, state[:, FREE].copy()


def active_springs(state: FloatArray) -> int:
    """Springs up to the last one that is loaded or has not crept back."""
    active = (state[:, FREE] == 0.0) | (state[:, W] != 0.0) | (state[:, BRANCHES:] != 0.0).any(axis=1)
    return int(np.flatnonzero(active)[-1]) + 1 if active.any() else 0
