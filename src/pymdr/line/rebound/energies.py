"""Stored and dissipated energies of the springs under a mass, from the histories of their branches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from pymdr.line.memory.modes import modes_of
from pymdr.line.rebound.motion import Motion, branches, motion_rows
from pymdr.units import FloatArray

_AT_ONCE, _FLAT = 1e-9, 0.9
"""Of the first row, when the contact is there at once, and of its radius there."""
_ROUNDING = 1e-16


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
    The energy of all springs, including separated ones, and the energy dissipated by dashpots.

    A spring touched at s has w = d(t) - d(s), and its branches are extended by
    e_i = int_s^t exp(-(t - u)/tau_i) dd(u); it stores (E_inf w^2 + sum E_i e_i^2) / 2 and loses
    sum E_i e_i^2 / tau_i + eta d'^2 per time and stiffness. A free one creeps back in its modes.

    Parameters
    ----------
    time : ndarray, shape (m,)
        In s, rising from 0, dense enough for trapezia.
    """
    body, rows = motion.relaxation, motion_rows(motion, time)
    down = time >= motion.turning_time
    ends = time[: int(np.argmax(down)) + 1] if down.any() else time
    touched, span, edge = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends), rows.radius
    flat = float(motion_rows(motion, _AT_ONCE * time[1:2]).radius[0])
    if flat > _FLAT * edge[1]:  # springs that are all touched at once
        touched, span, edge[0] = np.append(0.0, touched), np.append(0.0, span), flat
    widths = 2.0 * np.diff(edge[: ends.size], prepend=0.0)[-touched.size :]
    widths[0] = 2.0 * edge[ends.size - touched.size]
    at_touch = motion_rows(motion, touched)
    own, then = branches(motion, time), branches(motion, touched)
    in_contact = (touched < rows.touched[:, None]) | ((touched == 0.0) & (rows.touched[:, None] > 0.0))
    if motion.rests:
        in_contact = touched < time[:, None]
    w = np.where(in_contact, rows.depth[:, None] - at_touch.depth, 0.0)
    load = body.equilibrium * w
    stored = 0.5 * body.equilibrium * (w * w @ widths)
    rate = body.viscosity * rows.velocity**2 * 2.0 * edge
    since = np.where(in_contact, np.maximum(time[:, None] - (touched + 0.5 * span), 0.0), 0.0)
    for modulus, tau, now, before in zip(body.moduli, body.times, own.T, then.T, strict=True):
        recent = np.exp(-since / tau)
        mean, spread = _over_a_part(span / tau)
        load += modulus * np.where(
            in_contact, now[:, None] - recent * (np.exp(-0.5 * span / tau) * before), 0.0
        )
        extension = np.where(in_contact, now[:, None] - recent * (mean * before), 0.0)
        squares = modulus * (
            extension * extension @ widths
            + np.where(in_contact, recent * recent, 0.0) @ (spread * before**2 * widths)
        )
        stored += 0.5 * squares
        rate += squares / tau
    loss = scipy.interpolate.PchipInterpolator(time, rate).antiderivative()(time)
    if not motion.rests:
        modes = modes_of(body)
        parted = np.interp(touched, rows.touched[down][::-1], time[down][::-1])
        last = branches(motion, parted[::-1])[::-1]
        extension = last - np.exp(-(parted - touched)[:, None] / body.times) * then
        lengths = motion_rows(motion, parted[::-1]).depth[::-1] - at_touch.depth
        amplitudes = np.column_stack([extension * body.moduli, lengths]) @ modes.to_modes.T
        wait = np.maximum(time[:, None] - parted, 0.0)
        for speed, amplitude in zip(modes.rates, amplitudes.T, strict=True):
            weight = 0.5 * amplitude**2 * widths
            left = np.where(in_contact, 0.0, np.exp(-2.0 * speed * wait))
            free = (time[:, None] >= parted) & ~in_contact
            stored += np.where(free, left, 0.0) @ weight
            loss += np.where(free, -np.expm1(-2.0 * speed * wait), 0.0) @ weight
    return Energies(stored, loss, at_touch.radius, load)


def _over_a_part(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Mean and variance of exp(-u) over 0 < u < x, in which one part of the springs is touched one after the other.

    A part may be wider than a branch is slow: then those that were touched last have hardly been pulled.
    """
    x = np.maximum(x, _ROUNDING)
    mean = -np.expm1(-x) / x
    return mean, np.maximum(-np.expm1(-2.0 * x) / (2.0 * x) - mean * mean, 0.0)
