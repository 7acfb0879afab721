"""Bodies, a case, curves and references that several tests use."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import pymdr as mdr
from pymdr.line.adhesion import DMT as RigidPull
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.curves import ElasticLine

STEEL = mdr.Elastic("210 GPa", 0.3)
GLASS = mdr.Elastic("70 GPa", 0.22)
GEL = mdr.Elastic("30 kPa", 0.5)
UNIT = mdr.Elastic(1.0, 0.0)
"""E* = 1 Pa on a rigid body."""

BALL_CASE = """
title = "A ball"
[profile]
kind = "sphere"
radius = "10 mm"
[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
[[path]]
kind = "load"
normal_force = "50 N"
steps = 3
"""

REFERENCES = json.loads((Path(__file__).parent / "reference" / "refs.json").read_text())["refs"]


def references(topic):
    return [entry for entry in REFERENCES if entry["topic"] == topic]


def JKR(line, modulus, work):
    return ShortRange(ElasticLine(line, modulus), work)


def DMT(line, modulus, pull):
    return RigidPull(ElasticLine(line, modulus), pull)


@dataclass(frozen=True)
class Powers:
    """g = sum of scale x^n, with closed integrals."""

    terms: tuple[tuple[float, float], ...]
    edge: float = np.inf
    max_radius: float = np.inf
    breakpoints: tuple[float, ...] = ()
    exponent: float = 0.0

    def g(self, x):
        return sum(k * x**n for n, k in self.terms) + 0.0 * x

    def slope(self, x):
        with np.errstate(divide="ignore"):
            return sum(k * n * x ** (n - 1.0) for n, k in self.terms) + np.zeros_like(x)

    def moment(self, x):
        return sum(n / (n + 1.0) * k * x ** (n + 1.0) for n, k in self.terms) + 0.0 * x

    def squared(self, x):
        # int (g(x) - g)^2 dt = int 2 g'(t) m(t) dt
        return sum(
            2.0 * k * n * q * m / ((m + 1.0) * (n + m + 1.0)) * x ** (n + m + 1.0)
            for n, k in self.terms
            for m, q in self.terms
        ) + 0.0 * np.asarray(x)


@dataclass(frozen=True)
class Ripple:
    """A cone with a wave: g = t (x + (A/k) sin kx), rising for A < 1; the terrain of many instabilities."""

    t: float
    A: float
    k: float
    edge: float = np.inf
    max_radius: float = np.inf
    breakpoints: tuple[float, ...] = ()
    exponent: float = 0.0

    def g(self, x):
        return self.t * (x + self.A / self.k * np.sin(self.k * x))

    def slope(self, x):
        return self.t * (1.0 + self.A * np.cos(self.k * x))

    def moment(self, x):
        z = self.k * x
        wave = z * np.sin(z) - 2.0 * np.sin(0.5 * z) ** 2
        return self.t * (0.5 * x**2 + self.A / self.k**2 * wave)

    def squared(self, x):
        z, B = self.k * x, self.A / self.k
        first = self.t * (0.5 * x**2 + 2.0 * B / self.k * np.sin(0.5 * z) ** 2)
        second = self.t**2 * (
            x**3 / 3.0
            + 2.0 * B / self.k**2 * (np.sin(z) - z * np.cos(z))
            + B**2 * (0.5 * x - np.sin(2.0 * z) / (4.0 * self.k))
        )
        return x * self.g(x) ** 2 - 2.0 * self.g(x) * first + second
