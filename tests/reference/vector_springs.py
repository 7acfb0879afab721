"""Springs with vectors of force, a fixed number of them, for shifts in the plane under a profile that is a power."""

import re

import numpy as np


def many_springs(depth, shift, image, joint, n=20_000, nodes=0):
    """
    Forces, and slip work by Gauss's rule with some nodes, of springs that turn as tan(theta / 2) falls.

    The profile is g = c x^power with image = (c, power), and joint = (E*, G*, mu).
    """
    (c, power), (E, G, mu) = image, joint
    a = (depth.max() / c) ** (1.0 / power)
    g = c * ((np.arange(n) + 0.5) / n * a) ** power
    q, work, forces, works, d0 = np.zeros(n, dtype=complex), 0.0, [], [], 0.0
    per = G / (mu * E)
    for d, move in zip(depth, per * np.diff(shift @ [1.0, 1.0j], prepend=0.0), strict=True):
        enters = (g >= d0) & (g < d)
        part = np.where(enters, (d - g) / max(d - d0, 1e-300), 1.0)
        m0, m1 = np.where(enters, 0.0, np.maximum(d0 - g, 0.0)), np.maximum(d - g, 0.0)
        leaves = (m0 > 0.0) & (m1 == 0.0)
        part = np.where(leaves, m0 / np.maximum(d0 - d, 1e-300), part)
        step = abs(move) * part
        unit = move / abs(move) if move else 1.0
        t = q / unit
        # where the spring comes to its limit, over the length of its row
        alpha = np.where(step > 0.0, (m1 - m0) / np.where(step > 0.0, step, 1.0), 0.0)
        A, B, C = 1.0 - alpha**2, t.real - alpha * m0, np.minimum(abs(t) ** 2 - m0**2, 0.0)
        with np.errstate(all="ignore"):
            root = np.sqrt(B * B - A * C)
            s = np.where(B > 0.0, -C / (B + root), (root - B) / A)
        s = np.where(np.isfinite(s) & (s < step) & ~((B <= 0.0) & (A <= 0.0)), np.maximum(s, 0.0), step)
        stuck, rest = t + s, step - s
        m = m0 + alpha * s
        slips = (rest > 0.0) & (m0 + m1 > 0.0)
        with np.errstate(all="ignore"):
            tau = np.where(
                m > 0.0, rest / m * np.where(m1 == m, 1.0, np.log(m1 / m) / (m1 / m - 1.0)), np.inf
            )
        tau = np.where(enters, np.inf, tau)
        theta = np.where(enters, 0.0, np.angle(stuck))
        turned = 2.0 * np.arctan(np.tan(theta / 2.0) * np.exp(-tau))
        after = np.where(slips, m1 * np.exp(1j * turned), stuck)
        after = np.where(m1 > 0.0, after, 0.0)
        # work of friction: the work done on the spring less what it stores
        x, w = np.polynomial.legendre.leggauss(nodes) if nodes else ([], [])
        done = 0.0
        for node, weight in zip(0.5 * (np.array(x) + 1.0), 0.5 * np.array(w), strict=True):
            length = rest * node
            now = np.maximum(m + alpha * length, 0.0)
            with np.errstate(all="ignore"):
                at = np.where(now == m, length / m, length / m * np.log(now / m) / (now / m - 1.0))
            at = np.where(enters, np.inf, np.where(m > 0.0, at, np.inf))
            angle = 2.0 * np.arctan(np.tan(theta / 2.0) * np.exp(-at))
            done = done + weight * np.where(now > 0.0, now * (np.cos(angle) - alpha) * rest, 0.0)
        straight = 0.5 * (m + m1) * np.maximum(rest * (1.0 - alpha), 0.0)
        work += np.sum(np.where(slips, np.where(enters, straight, done), 0.0))
        q, d0 = after * unit, d
        forces.append([q.real.sum(), q.imag.sum()])
        works.append(work)
    scale = 2.0 * a / n * mu * E
    return scale * np.array(forces), scale * np.array(works) * mu * E / G


def numerical_errors(result):
    """The numerical errors of the claim: of the force over mu F_N, and of the dissipated energy over the largest."""
    reason = result.claims["tangential_force"].reason
    force = re.search(r"the force by (\S+) of mu F_N", reason)
    work = re.search(r"the dissipated energy by (\S+) of the largest", reason)
    return float(force[1]) * 1.05, float(work[1]) * 1.05
