"""What the springs under a mass hold and their dashpots take, from the histories of their branches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymdr.line.memory.modes import modes_of
from pymdr.line.rebound.motion import Motion, branches, motion_rows
from pymdr.units import FloatArray

_AT_ONCE, _FLAT = 1e-9, 0.9
"""Of the first row, when the contact is there at once, and of its radius there."""


class Energies(NamedTuple):
    """One entry per row; of springs touched one after the other on the approach."""

    stored: FloatArray
    """In J."""
    dissipated: FloatArray
    """In J."""
    position: FloatArray
    """(k,) radii of the springs in m, rising."""
    load: FloatArray
    """(m, k) force per length and side in N/m, 0 of those that are free; without that of a dashpot."""


def energies(motion: Motion, time: FloatArray) -> Energies:
    """
    The energy of all springs, those that have parted included, and what dashpots have taken.

    A spring touched at s has w = d(t) - d(s), and its branches are extended by
    e_i = int_s^t exp(-(t - u)/tau_i) dd(u); it stores (E_inf w^2 + sum E_i e_i^2) / 2 and loses
    sum E_i e_i^2 / tau_i + eta d'^2 per time and stiffness. A free one creeps back in its modes.

    Parameters
    ----------
    motion : Motion
    time : ndarray, shape (m,)
        In s, rising from 0, dense enough for trapezia.

    Returns
    -------
    Energies
    """
    body, rows = motion.relaxation, motion_rows(motion, time)
    down = time >= motion.turning_time
    ends = time[: int(np.argmax(down)) + 1] if down.any() else time
    touched, edge = 0.5 * (ends[1:] + ends[:-1]), rows.radius
    flat = float(motion_rows(motion, _AT_ONCE * time[1:2]).radius[0])
    if flat > _FLAT * edge[1]:  # springs that are all touched at once
        touched, edge[0] = np.append(0.0, touched), flat
    share = 2.0 * np.diff(edge[: ends.size], prepend=0.0)[-touched.size :]
    share[0] = 2.0 * edge[ends.size - touched.size]
    at_touch = motion_rows(motion, touched)
    own, then = branches(motion, time), branches(motion, touched)
    held = (touched < rows.touched[:, None]) | ((touched == 0.0) & (rows.touched[:, None] > 0.0))
    if motion.rests:
        held = touched < time[:, None]
    w = np.where(held, rows.depth[:, None] - at_touch.depth, 0.0)
    load = body.equilibrium * w
    stored = 0.5 * body.equilibrium * (w * w @ share)
    rate = body.viscosity * rows.velocity**2 * 2.0 * edge
    wait = np.where(held, time[:, None] - touched, 0.0)
    for modulus, tau, now, before in zip(body.moduli, body.times, own.T, then.T, strict=True):
        # in place: these are the largest arrays there are
        extension = wait * (-1.0 / tau)
        np.exp(extension, out=extension)
        extension *= before
        np.subtract(now[:, None], extension, out=extension)
        extension *= held
        squares = modulus * np.einsum("ij,ij,j->i", extension, extension, share)
        extension *= modulus
        load += extension
        stored += 0.5 * squares
        rate += squares / tau
    lost = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)))
    if not motion.rests:
        modes = modes_of(body)
        parted = np.interp(touched, rows.touched[down][::-1], time[down][::-1])
        last = branches(motion, parted[::-1])[::-1]
        extension = last - np.exp(-(parted - touched)[:, None] / body.times) * then
        lengths = motion_rows(motion, parted[::-1]).depth[::-1] - at_touch.depth
        amplitudes = np.column_stack([extension * body.moduli, lengths]) @ modes.to_modes.T
        wait = np.maximum(time[:, None] - parted, 0.0)
        free = (time[:, None] >= parted) & ~held
        for speed, amplitude in zip(modes.rates, amplitudes.T, strict=True):
            weight = 0.5 * amplitude**2 * share
            gone = wait * (-2.0 * speed)
            left = np.exp(gone)
            left *= free
            np.expm1(gone, out=gone)
            gone *= free
            stored += left @ weight
            lost -= gone @ weight
    return Energies(stored, lost, at_touch.radius, load)
