"""Contacts of a body whose modulus is a power of time, without exponentials: product integration with the exact kernel."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import beta, betainc


class Power:
    """E*(t) = 4 G1 (t/t1)^-alpha of a body that keeps its volume, with its integral from 0."""

    def __init__(self, modulus, time, exponent):
        self.scale, self.exponent = 4.0 * modulus * time**exponent, exponent

    def __call__(self, t):
        return self.scale * t**-self.exponent

    def integral(self, t):
        return self.scale * np.maximum(t, 0.0) ** (1.0 - self.exponent) / (1.0 - self.exponent)


def ramp_force(kernel, radius, speed, time):
    """int_0^t E*(t - s) dF0, F0 = (4/3) sqrt(R) (v s)^1.5, under a ball that is pressed in at one speed."""
    b = 1.0 - kernel.exponent
    return 2.0 * kernel.scale * math.sqrt(radius) * speed**1.5 * time ** (0.5 + b) * beta(b, 1.5)


def approach_and_retreat(kernel, radius, time, depth):
    """Force and radius of a ball by Ting (1966), of straight moves up to the largest depth and down: by quadrature in s."""
    t, d = np.append(0.0, time), np.append(0.0, depth)
    top = int(np.argmax(d))
    speed = np.diff(d) / np.diff(t)

    def moved(low, high, now):
        """int_low^high E*(now - s) d'(s) ds."""
        ends = np.clip(t, low, high)
        return float(np.sum(speed * (kernel.integral(now - ends[:-1]) - kernel.integral(now - ends[1:]))))

    def pressed(high, now):
        """int_0^high E*(now - s) 2 sqrt(R d) d'(s) ds, of each row by an incomplete beta function or by quadrature."""
        total = 0.0
        for i in np.flatnonzero(t[:-1] < high):
            begin, end = t[i], min(t[i + 1], high)
            if speed[i] <= 0.0:
                continue
            zero = begin - d[i] / speed[i]  # where this straight move would begin
            b, whole = 1.0 - kernel.exponent, now - zero
            part = [betainc(1.5, b, min((s - zero) / whole, 1.0)) for s in (begin, end)]
            fraction = part[1] - part[0]
            if (
                fraction < 0.1 * part[1]
            ):  # the difference loses its digits: over u = (now - s)^b, where nothing is singular
                begin, end = now - begin, now - end
                fraction = quad(
                    lambda u, z=now - zero, b=b: (z - u ** (1.0 / b)) ** 0.5,
                    end**b,
                    begin**b,
                    epsrel=1e-13,
                    epsabs=0.0,
                )[0]
                fraction /= b * beta(1.5, b) * whole ** (0.5 + b)
            total += (
                2.0
                * kernel.scale
                * math.sqrt(radius * speed[i])
                * speed[i]
                * whole ** (0.5 + b)
                * beta(1.5, b)
                * fraction
            )
        return total

    force, contact = np.zeros(time.size), np.zeros(time.size)
    for n in range(1, t.size):
        edge = t[n]
        if n > top:
            if moved(t[0], t[n], t[n]) <= 0.0:
                continue
            edge = brentq(lambda s, n=n: moved(s, t[n], t[n]), 0.0, t[top], xtol=1e-300, rtol=1e-15)
        force[n - 1] = pressed(edge, t[n])
        contact[n - 1] = math.sqrt(radius * np.interp(edge, t, d))
    return force, contact


def springs(kernel, radius, time, target, *, forced, deepest, n=160, parts=24):
    """
    Indentation and force of a ball along any path, by springs whose histories are straight on a mesh graded in each row.

    The load of a spring is the exact integral of the kernel over that mesh; it is let go where it would pull.
    """
    fraction = (np.arange(1, parts + 1) / parts) ** 3
    begin = np.append(0.0, time[:-1])
    t = np.append(0.0, (begin[:, None] + (time - begin)[:, None] * fraction).ravel())
    goal = (np.append(0.0, target[:-1])[:, None] + np.diff(target, prepend=0.0)[:, None] * fraction).ravel()
    ends = math.sqrt(radius * deepest) * 1.05 * (np.arange(n + 1) / n)
    x, width = 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)
    y = x**2 / radius
    moves = np.zeros((t.size - 1, n))
    w, depth, computed = np.zeros(n), 0.0, np.zeros((time.size, 2))
    for k in range(1, t.size):
        weight = -np.diff(kernel.integral(t[k] - t[: k + 1])) / np.diff(t[: k + 1])
        memory = weight[:-1] @ moves[: k - 1] if k > 1 else np.zeros(n)
        free = np.where(w - memory / weight[-1] > 0.0, w - memory / weight[-1], 0.0)

        def loaded(d, weight=weight[-1], memory=memory, w=w, free=free):
            indentation = np.maximum(d - y, 0.0)
            there = np.maximum(indentation, free)
            q = np.where(there > free, memory + weight * (there - w), 0.0)
            return there, 2.0 * float(width @ np.maximum(q, 0.0))

        if forced and goal[k - 1] == 0.0:  # the body rests on what has not crept back
            depth = float(np.min(y + free))
        elif forced:
            depth = brentq(
                lambda d, goal=goal[k - 1], loaded=loaded: loaded(d)[1] - goal,
                0.0,
                1.2 * deepest,
                rtol=1e-13,
                xtol=1e-300,
            )
        else:
            depth = goal[k - 1]
        there, force = loaded(depth)
        moves[k - 1], w = there - w, there
        if k % parts == 0:
            computed[k // parts - 1] = depth, force
    return computed[:, 0], computed[:, 1]
