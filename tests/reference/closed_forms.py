"""Closed forms of the normal contact in extended precision, written without pymdr.

Every formula is taken from the literature (Sneddon 1965; Popov, Hess and Willert 2019) and evaluated with
numpy.longdouble, so that the last digit of a double can be judged.
"""

import itertools
import math

import numpy as np

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")


def kappa(n):
    """Factor of r^n -> kappa x^n."""
    return math.sqrt(math.pi) * math.gamma(n / 2 + 1) / math.gamma((n + 1) / 2)


def gauss(n):
    """Nodes and weights on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (nodes.astype(LONG) + 1) / 2, weights.astype(LONG) / 2


def panels(function, edges, n=40):
    """Integral of a function over panels, in extended precision."""
    s, w = gauss(n)
    total = LONG(0)
    for low, high in itertools.pairwise(edges):
        low, high = LONG(low), LONG(high)
        total += (high - low) * (w * function(low + (high - low) * s)).sum()
    return total


def sphere_g(t):
    """The ratio g/R of the sphere at t = x/R."""
    t = np.asarray(t, dtype=LONG)
    return t * np.arctanh(t)


def sphere_slope(t):
    """Slope g' of the sphere."""
    t = np.asarray(t, dtype=LONG)
    return np.arctanh(t) + t / ((1 - t) * (1 + t))


def sphere_force(t):
    """The ratio F/(E* R^2) of the sphere at t = a/R: a series below 0.3, the closed form above."""
    t = np.asarray(t, dtype=LONG)
    j = np.arange(1, 61).astype(LONG)
    low = np.minimum(t, LONG(0.3))
    series = 2 * (2 * j / ((2 * j - 1) * (2 * j + 1)) * low[..., None] ** (2 * j + 1)).sum(axis=-1)
    closed = (1 + t * t) / 2 * np.log((1 + t) / (1 - t)) - t
    return np.where(t < LONG(0.3), series, closed)


def sphere_energy(t):
    """The ratio U/(E* R^3) of the sphere at t = a/R, by Gauss in x = R tanh(u)."""
    s, w = gauss(200)
    top = np.arctanh(np.asarray(t, dtype=LONG))[..., None]
    u = top * s
    depth = top * np.tanh(top)
    return (top * w * (depth - u * np.tanh(u)) ** 2 / np.cosh(u) ** 2).sum(axis=-1)


def sphere_pressure(t, rho):
    """The ratio p/E* of the sphere for a = t R at r = rho R, by Gauss in q = sqrt(x^2 - r^2)."""
    t, rho = LONG(t), LONG(rho)
    top = np.sqrt((t - rho) * (t + rho))

    def integrand(q):
        x = np.sqrt(rho * rho + q * q)
        return sphere_slope(x) / x

    edges = np.append(1 - LONG(0.5) ** np.arange(0, 24), LONG(1))
    return panels(integrand, top * edges, 30) / PI


def truncated_cone_g(x, slope, b):
    """Equivalent profile g of slope (r - b)+."""
    x = np.asarray(x, dtype=LONG)
    b = LONG(b)
    y = np.maximum(x, b)
    return slope * y * np.arctan2(np.sqrt((y - b) * (y + b)), b)


def truncated_cone_force(a, slope, b):
    """The ratio F/E* of slope (r - b)+."""
    a, b = LONG(a), LONG(b)
    root = np.sqrt((a - b) * (a + b))
    return slope * a * a * (np.arctan2(root, b) + b * root / (a * a))


def truncated_paraboloid_g(x, R, b):
    """Equivalent profile g of (r^2 - b^2)+ / 2R."""
    x = np.asarray(x, dtype=LONG)
    y = np.maximum(x, LONG(b))
    return y / R * np.sqrt((y - b) * (y + b))


def truncated_paraboloid_force(a, R, b):
    """The ratio F/E* of (r^2 - b^2)+ / 2R."""
    a, b = LONG(a), LONG(b)
    return 2 / (3 * LONG(R)) * (2 * a * a + b * b) * np.sqrt((a - b) * (a + b))


def rounded_tip_cone_g(x, slope, b):
    """Equivalent profile g of a cone with a parabolic tip up to b."""
    x = np.asarray(x, dtype=LONG)
    b = LONG(b)
    y = np.maximum(x, b)
    root = np.sqrt((y - b) * (y + b))
    return np.where(x <= b, slope * x * x / b, slope * y * (b / (y + root) + np.arctan2(root, b)))


def hertz_displacement(r, a, R):
    """Surface displacement of the paraboloid outside the contact (Johnson 1985, eq. 3.42)."""
    r, a = np.asarray(r, dtype=LONG), LONG(a)
    return ((2 * a * a - r * r) * np.arcsin(a / r) + a * np.sqrt((r - a) * (r + a))) / (PI * R)


def cone_displacement(r, a, slope):
    """Surface displacement of the cone outside the contact."""
    r, a = np.asarray(r, dtype=LONG), LONG(a)
    root = np.sqrt((r - a) * (r + a))
    return slope * (a * np.arcsin(a / r) + root - r)


def hertz_gap(r, a, R):
    """Gap (2/pi) int_a^r (x^2 - a^2) / (R sqrt(r^2 - x^2)) dx of the paraboloid, by Gauss in the angle."""
    r, a = np.asarray(r, dtype=LONG), LONG(a)
    s, w = gauss(60)
    top = np.arctan2(np.sqrt((r - a) * (r + a)), a)[..., None]
    phi = top * s
    product = r[..., None] ** 2 * np.sin(top - phi) * np.sin(top + phi)
    return 2 / PI * (top * w * product).sum(axis=-1) / LONG(R)
