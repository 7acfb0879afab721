"""Random profiles as users write them, and the same profiles in extended precision.

Every profile is a sum of terms. A term knows its f' and f'' in numpy.longdouble at base + offset, the radii at which
something happens, and radii at which panels of a quadrature should be split; beside it stands what a user would
write with NumPy in double precision. :func:`random_profile` draws one; ``RandomProfile.build(mdr)`` makes the
profile of the package, ``RandomProfile.curve(profile)`` the curve for quadrature.py.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
LN2 = LONG("0.693147180559945309417232121458176568")
ANALYTIC, KINK, BRANCH = 0, 1, 2
VISIBLE = 1e-8


# --- terms in extended precision -------------------------------------------------------------------------


def raised(y, n):
    """The power y^n to 3e-18, several times faster than that of NumPy: y = m 2^k, with k n split into whole and rest."""
    if float(n).is_integer() and 0 <= n <= 3:
        return np.ones_like(y) if n == 0 else y if n == 1 else y * y if n == 2 else y * y * y
    with np.errstate(divide="ignore", under="ignore", over="ignore"):
        m, k = np.frexp(y)
        whole = np.floor(k * n)
        return np.ldexp(np.exp(n * np.log(m) + (k * n - whole) * LN2), whole.astype(np.int32))


@dataclass(frozen=True)
class Power:
    """c ((r - b)_+ / L)^n."""

    c: float
    n: float
    L: float = 1.0
    b: float = 0.0

    def events(self, top):
        whole = float(self.n).is_integer()
        if self.b == 0.0:
            return [] if whole else [(LONG(0), BRANCH, LONG(0))]
        jump = LONG(self.c) / LONG(self.L) if self.n == 1.0 else LONG(0)
        return [(LONG(self.b), KINK if whole else BRANCH, jump)]

    def marks(self, top):
        return []

    def _power(self, base, offset, n):
        inside = base >= LONG(self.b)
        y = np.where(inside, (base - LONG(self.b)) + offset, 1) / LONG(self.L)
        return np.where(inside, raised(y, n), 0)

    def slope(self, base, offset):
        n = LONG(self.n)
        return LONG(self.c) * n / LONG(self.L) * self._power(base, offset, n - 1)

    def bend(self, base, offset):
        n = LONG(self.n)
        if n == 1:
            return np.zeros(offset.shape, dtype=LONG)
        return LONG(self.c) * n * (n - 1) / LONG(self.L) ** 2 * self._power(base, offset, n - 2)


@dataclass(frozen=True)
class Quotient:
    """(r - b)_+^2 / 2R."""

    R: float
    b: float = 0.0

    def events(self, top):
        return [(LONG(self.b), KINK, LONG(0))] if self.b > 0.0 else []

    def marks(self, top):
        return []

    def slope(self, base, offset):
        return np.where(base >= LONG(self.b), (base - LONG(self.b)) + offset, 0) / LONG(self.R)

    def bend(self, base, offset):
        return np.where(base >= LONG(self.b), np.ones_like(offset), 0) / LONG(self.R)


def graded(scale, top, decades=10):
    """Splits for what changes its law at r = scale, with singularities as far from 0."""
    radii = [LONG(scale) * LONG(3) ** k for k in range(int(decades / math.log10(3.0)) + 1)]
    return [r for r in radii if r < top]


@dataclass(frozen=True)
class Hyperboloid:
    """t (sqrt(r^2 + c^2) - c)."""

    t: float
    c: float

    def events(self, top):
        return []

    def marks(self, top):
        return graded(self.c, top)

    def slope(self, base, offset):
        r = base + offset
        return LONG(self.t) * r / np.sqrt(r * r + LONG(self.c) ** 2)

    def bend(self, base, offset):
        r, c = base + offset, LONG(self.c)
        root = np.sqrt(r * r + c * c)
        return LONG(self.t) * (c / root) ** 2 / root


@dataclass(frozen=True)
class Ball:
    """R - sqrt(R^2 - r^2)."""

    R: float

    def events(self, top):
        return []

    def marks(self, top):
        radii = [LONG(self.R) * (1 - LONG(0.5) ** k) for k in range(1, 40)]
        return [m for m in radii if m < top]

    def _root(self, base, offset):
        R = LONG(self.R)
        return np.sqrt(((R - base) - offset) * ((R + base) + offset))

    def slope(self, base, offset):
        return (base + offset) / self._root(base, offset)

    def bend(self, base, offset):
        root = self._root(base, offset)
        return (LONG(self.R) / root) ** 2 / root


@dataclass(frozen=True)
class Logarithm:
    """h log(1 + (r/c)^p), p = 1 or 2."""

    h: float
    c: float
    p: int

    def events(self, top):
        return []

    def marks(self, top):
        return graded(self.c, top)

    def slope(self, base, offset):
        r, h, c = base + offset, LONG(self.h), LONG(self.c)
        return h / (c + r) if self.p == 1 else 2 * h * r / (c * c + r * r)

    def bend(self, base, offset):
        r, h, c = base + offset, LONG(self.h), LONG(self.c)
        if self.p == 1:
            return -h / (c + r) ** 2
        return 2 * h * (c - r) * (c + r) / (c * c + r * r) ** 2


@dataclass(frozen=True)
class Exponential:
    """h (exp(r/c) - 1), or h (cosh(r/c) - 1)."""

    h: float
    c: float
    even: bool

    def events(self, top):
        return []

    def marks(self, top):
        return [4 * LONG(self.c) * k for k in range(1, 200) if 4 * self.c * k < top]

    def slope(self, base, offset):
        y = (base + offset) / LONG(self.c)
        return LONG(self.h) / LONG(self.c) * (np.sinh(y) if self.even else np.exp(y))

    def bend(self, base, offset):
        y = (base + offset) / LONG(self.c)
        return LONG(self.h) / LONG(self.c) ** 2 * (np.cosh(y) if self.even else np.exp(y))


@dataclass(frozen=True)
class Wave:
    """h (1 - cos(k r))."""

    h: float
    k: float

    def events(self, top):
        return []

    def marks(self, top):
        step = 8 * PI / LONG(self.k)
        return [step * j for j in range(1, int(float(top / step)) + 1)]

    def slope(self, base, offset):
        h, k = LONG(self.h), LONG(self.k)
        return h * k * np.sin(k * (base + offset))

    def bend(self, base, offset):
        h, k = LONG(self.h), LONG(self.k)
        return h * k * k * np.cos(k * (base + offset))


@dataclass(frozen=True)
class Bump:
    """h exp(-((r - m) / w)^2 / 2)."""

    h: float
    m: float
    w: float

    def events(self, top):
        return []

    def marks(self, top):
        radii = [LONG(self.m) + 3 * j * LONG(self.w) for j in range(-4, 5)]
        # the image of a narrow bump goes on beside it like that of a kink
        radii += [LONG(self.m) + 12 * LONG(self.w) * LONG(2) ** j for j in range(1, 40)]
        return [r for r in radii if 0 < r < top]

    def _z(self, base, offset):
        return ((base - LONG(self.m)) + offset) / LONG(self.w)

    def slope(self, base, offset):
        z = self._z(base, offset)
        return -LONG(self.h) / LONG(self.w) * z * np.exp(-z * z / 2)

    def bend(self, base, offset):
        z = self._z(base, offset)
        return LONG(self.h) / LONG(self.w) ** 2 * (z - 1) * (z + 1) * np.exp(-z * z / 2)


@dataclass(frozen=True)
class Shoulder:
    """f' = s r/b up to b, s b/r from there on: a plateau over which r f' stays as it is."""

    s: float
    b: float

    def events(self, top):
        return [(LONG(self.b), KINK, LONG(0))]

    def marks(self, top):
        return graded(self.b, top, 300)[1:]

    def slope(self, base, offset):
        r, s, b = base + offset, LONG(self.s), LONG(self.b)
        with np.errstate(divide="ignore"):
            return np.where(base >= b, s * (b / r), s * r / b)

    def bend(self, base, offset):
        r, s, b = base + offset, LONG(self.s), LONG(self.b)
        with np.errstate(divide="ignore"):
            return np.where(base >= b, -s * (b / r) / r, s / b)


@dataclass(frozen=True)
class Polynomials:
    """Cubics: f' = c1 + 2 c2 e + 3 c3 e^2 from each of the knots on."""

    knots: np.ndarray
    c1: np.ndarray
    c2: np.ndarray
    c3: np.ndarray

    def events(self, top):
        return [(LONG(b), KINK, LONG(0)) for b in self.knots[1:]]

    def marks(self, top):
        return []

    def _interval(self, base, offset):
        i = np.searchsorted(self.knots, base, side="right") - 1
        return i, (base - self.knots[i]) + offset

    def slope(self, base, offset):
        i, e = self._interval(base, offset)
        return self.c1[i] + e * (2 * self.c2[i] + 3 * e * self.c3[i])

    def bend(self, base, offset):
        i, e = self._interval(base, offset)
        return 2 * self.c2[i] + 6 * e * self.c3[i]


def cubic_polynomials(breaks, coefficients):
    """The cubics of a scipy PPoly."""
    c = np.asarray(coefficients).astype(LONG)
    return Polynomials(np.asarray(breaks)[:-1].astype(LONG), c[2], c[1], c[0])


def linear_slopes(knots, slopes):
    """f' by linear interpolation between knots, constant beyond the last."""
    knots, slopes = np.asarray(knots).astype(LONG), np.asarray(slopes).astype(LONG)
    curvatures = np.append(np.diff(slopes) / np.diff(knots), LONG(0))
    return Polynomials(knots, slopes, curvatures / 2, np.zeros_like(curvatures))


@dataclass(frozen=True)
class Cut:
    """Another term of which all up to r = b is cut off flat."""

    term: object
    b: float

    def events(self, top):
        b = np.full(1, LONG(self.b))
        return [(LONG(self.b), KINK, self.term.slope(b, np.zeros_like(b))[0]), *self.term.events(top)]

    def marks(self, top):
        return [m for m in self.term.marks(top) if m > self.b]

    def slope(self, base, offset):
        return np.where(base >= LONG(self.b), self.term.slope(base, offset), 0)

    def bend(self, base, offset):
        return np.where(base >= LONG(self.b), self.term.bend(base, offset), 0)


class TermCurve:
    """The sum of terms as a curve for quadrature.py, with panels short beside what happens below them."""

    def __init__(self, terms, top):
        self.terms = tuple(terms)
        top = LONG(top)
        events: dict[np.longdouble, tuple[int, np.longdouble]] = {LONG(0): (ANALYTIC, LONG(0))}
        for radius, kind, jump in (e for t in self.terms for e in t.events(top)):
            known = events.get(radius, (ANALYTIC, LONG(0)))
            events[radius] = (max(kind, known[0]), known[1] + jump)
        for mark in (m for t in self.terms for m in t.marks(top)):
            events.setdefault(LONG(mark), (ANALYTIC, LONG(0)))
        sources: list[np.longdouble] = []
        for low, high in itertools.pairwise([*sorted(r for r in events if r < top), top]):
            here = low
            if events[low][0] != ANALYTIC:
                sources.append(low)
            while sources:
                # what happens at b happens at -b as well, for all that depends on x^2 - b^2
                away = min(
                    [here - b for b in sources if b < here]
                    + [2 * b for b in sources if 0 < b == here]
                    + [top]
                )
                if high - here <= 2 * away:
                    break
                here = here + 2 * away
                events.setdefault(here, (ANALYTIC, LONG(0)))
        radii = sorted(events)
        self.edges = np.array(radii, dtype=LONG)
        self.kinds = np.array([events[r][0] for r in radii])
        self.jumps = np.array([events[r][1] for r in radii], dtype=LONG)

    def slope(self, base, offset):
        """f' at base + offset."""
        return sum(t.slope(base, offset) for t in self.terms)

    def bend(self, base, offset):
        """f'' at base + offset."""
        return sum(t.bend(base, offset) for t in self.terms)


# --- profiles --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RandomProfile:
    """A profile in double precision, as a user gives it, and in extended precision."""

    kind: str
    scale: float
    """A length in m that belongs to it."""
    top: float
    """Largest radius in m at which it is asked."""
    terms: tuple
    f: Callable | None = None
    derivative: Callable | None = None
    gives: str = "both"
    """What the user gives: both, derivative, f or samples."""
    breakpoints: tuple[float, ...] = ()
    """Radii that the user names."""
    hidden: tuple[float, ...] = ()
    """Kinks that the user does not name."""
    max_radius: float = math.inf
    smooth: bool = True
    """Whether what is given determines it to rounding: no hidden kink, no cancellation, no noise."""
    samples: tuple[np.ndarray, np.ndarray] | None = None
    interpolation: str = ""
    words: str = ""
    sources: tuple[float, ...] = field(default=())
    """Radii next to which it should be asked."""

    def build(self, mdr):
        """The profile of the package `mdr`."""
        if self.samples is not None:
            options = {
                "round": lambda: mdr.CubicSpline(),
                "sharp": lambda: mdr.CubicSpline(tip="sharp"),
                "shape": lambda: mdr.ShapePreserving(),
                "smoothing": lambda: mdr.SmoothingSpline(),
            }
            return mdr.Sampled(*self.samples, interpolation=options[self.interpolation]())
        given = {
            "both": (self.f, self.derivative),
            "derivative": (None, self.derivative),
            "f": (self.f, None),
        }
        f, derivative = given[self.gives]
        return mdr.Function(f, self.breakpoints, derivative, max_radius=self.max_radius)

    def curve(self, profile=None):
        """The curve for quadrature.py; of samples, that of the spline of the built profile."""
        if self.samples is None:
            return TermCurve(self.terms, self.top)
        return TermCurve([cubic_polynomials(profile.spline.x, profile.spline.c)], profile.spline.x[-1])


def log_uniform(rng, low, high):
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _exponent(rng):
    if rng.random() < 0.4:
        return float(rng.choice([0.5, 1, 1.5, 2, 3, 4, 6, 10, 20, 40]))
    return log_uniform(rng, 0.3, 40.0)


def power_sum(rng, L):
    """Up to four powers whose crossovers lie decades apart."""
    count = int(rng.integers(1, 5))
    exponents = [_exponent(rng) for _ in range(count)]
    size = log_uniform(rng, 1e-6, 1.0)
    heights = [size * L / n * 10.0 ** (-rng.uniform(0, 20) if i else 0.0) for i, n in enumerate(exponents)]
    return powers_of(list(zip(heights, exponents, strict=True)), L)


def powers_of(pairs, L):
    """The sum of c (r / L)^n."""
    return {
        "f": lambda r: sum(c * (r / L) ** n for c, n in pairs),
        "derivative": lambda r: sum(c * n / L * (r / L) ** (n - 1.0) for c, n in pairs),
        "terms": tuple(Power(c, n, L) for c, n in pairs),
        "words": " + ".join(f"{c!r}*(r/{L!r})**{n!r}" for c, n in pairs),
        "pairs": pairs,
    }


def cones(rng, L):
    """A truncated cone, or a cone of several slopes."""
    count = int(rng.integers(1, 5))
    low = L * log_uniform(rng, 1e-6, 0.1)
    radii = sorted(log_uniform(rng, low, 0.8 * L) for _ in range(count))
    if count > 1 and rng.random() < 0.2:
        radii[1] = radii[0] * (1.0 + log_uniform(rng, 1e-9, 1e-2))
        radii.sort()
    radii = [0.0, *radii] if rng.random() < 0.6 else radii
    slopes = [log_uniform(rng, 1e-6, 0.3) for _ in radii]
    pairs = list(zip(slopes, radii, strict=True))
    return {
        "f": lambda r: sum(t * np.maximum(r - b, 0.0) for t, b in pairs),
        "derivative": lambda r: sum(np.where(r > b, t, 0.0) for t, b in pairs),
        "terms": tuple(Power(t, 1.0, 1.0, b) for t, b in pairs),
        "kinks": [b for b in radii if b > 0.0],
        "words": " + ".join(f"{t!r}*maximum(r-{b!r},0)" for t, b in pairs),
    }


def dead_zones(rng, L):
    """Rounded flats c ((r - b)_+)^n, one or two."""
    pairs = []
    for _ in range(int(rng.integers(1, 3))):
        n = float(rng.choice([1.0, 1.5, 2.0, 3.0, rng.uniform(1.2, 6.0)]))
        b = L * log_uniform(rng, 1e-6, 0.9)
        pairs.append((log_uniform(rng, 1e-6, 1.0) * L / n, n, b))
    return {
        "f": lambda r: sum(c * (np.maximum(r - b, 0.0) / L) ** n for c, n, b in pairs),
        "derivative": lambda r: sum(
            np.where(r > b, c * n / L * (np.maximum(r - b, 0.0) / L) ** (n - 1.0), 0.0) for c, n, b in pairs
        ),
        "terms": tuple(Power(c, n, L, b) for c, n, b in pairs),
        "kinks": [b for _, _, b in pairs],
        "words": " + ".join(f"{c!r}*(maximum(r-{b!r},0)/{L!r})**{n!r}" for c, n, b in pairs),
    }


def rounded_flat(rng, L):
    """A flat with a parabolic edge (r - b)_+^2 / 2R."""
    b = L * log_uniform(rng, 1e-5, 0.95)
    R = L / log_uniform(rng, 1e-6, 1.0)
    return {
        "f": lambda r: np.where(r > b, (r - b) ** 2, 0.0) / (2.0 * R),
        "derivative": lambda r: np.where(r > b, r - b, 0.0) / R,
        "terms": (Quotient(R, b),),
        "kinks": [b],
        "words": f"maximum(r-{b!r},0)**2/(2*{R!r})",
    }


def hyperboloid(rng, L):
    """Stable, or with cancellation."""
    t, c = log_uniform(rng, 1e-6, 1.0), L * log_uniform(rng, 1e-8, 1e2)
    stable = rng.random() < 0.5
    return {
        "f": (lambda r: t * r * r / (np.sqrt(r * r + c * c) + c))
        if stable
        else (lambda r: t * (np.sqrt(r * r + c * c) - c)),
        "derivative": lambda r: t * r / np.sqrt(r * r + c * c),
        "terms": (Hyperboloid(t, c),),
        "cancels": not stable,
        "words": f"{t!r}*(sqrt(r^2+{c!r}^2)-{c!r}){'' if stable else ' cancelling'}",
    }


def ball(rng, L):
    """Stable, or with cancellation."""
    R = L / (log_uniform(rng, 1e-3, 1.0) * 0.97)
    stable = rng.random() < 0.5
    return {
        "f": (lambda r: r * r / (R + np.sqrt(R * R - r * r)))
        if stable
        else (lambda r: R * (1.0 - np.sqrt(1.0 - (r / R) ** 2))),
        "derivative": lambda r: r / np.sqrt((R - r) * (R + r)),
        "terms": (Ball(R),),
        "largest": 0.999 * R,
        "cancels": not stable,
        "words": f"sphere R={R!r}{'' if stable else ' cancelling'}",
    }


def logarithm(rng, L):
    """h log1p(r/c) or h log1p(r^2/c^2)."""
    p = int(rng.integers(1, 3))
    c = L * log_uniform(rng, 1e-6, 1e3)
    h = log_uniform(rng, 1e-6, 1.0) * c
    if p == 1:
        f, derivative = (lambda r: h * np.log1p(r / c)), (lambda r: h / (c + r))
    else:
        f, derivative = (lambda r: h * np.log1p((r / c) ** 2)), (lambda r: 2.0 * h * r / (c * c + r * r))
    return {
        "f": f,
        "derivative": derivative,
        "terms": (Logarithm(h, c, p),),
        "words": f"{h!r}*log1p((r/{c!r})**{p})",
    }


def exponential(rng, L):
    """h expm1(r/c), h (exp(r/c) - 1) or h (cosh(r/c) - 1)."""
    c = L / log_uniform(rng, 1e-4, 20.0)
    even = bool(rng.random() < 0.5)
    h = log_uniform(rng, 1e-6, 1.0) * c * math.exp(-L / c)
    stable = (not even) and rng.random() < 0.5
    if even:
        f, derivative = (lambda r: h * (np.cosh(r / c) - 1.0)), (lambda r: h / c * np.sinh(r / c))
    else:
        f = (lambda r: h * np.expm1(r / c)) if stable else (lambda r: h * (np.exp(r / c) - 1.0))
        derivative = lambda r: h / c * np.exp(r / c)  # noqa: E731
    return {
        "f": f,
        "derivative": derivative,
        "terms": (Exponential(h, c, even),),
        "cancels": not stable,
        "words": f"{h!r}*({'cosh' if even else 'expm1' if stable else 'exp'}(r/{c!r})-1)",
    }


def waves(rng, L):
    """A paraboloid with waves, whose g rises: h k^2 R < 3.18."""
    count = log_uniform(rng, 0.3, 300.0)
    R = L / log_uniform(rng, 1e-6, 1.0)
    k = 2.0 * math.pi * count / L
    h = rng.uniform(0.01, 3.1) / (k * k * R)
    return {
        "f": lambda r: r * r / (2.0 * R) + h * (1.0 - np.cos(k * r)),
        "derivative": lambda r: r / R + h * k * np.sin(k * r),
        "terms": (Wave(h, k),),
        "paraboloid": R,
        "cancels": True,
        "words": f"r**2/(2*{R!r}) + {h!r}*(1-cos({k!r}*r))",
    }


def bump(rng, L):
    """A paraboloid with a narrow bump or hollow, low enough that (r f')' > 0."""
    R = L / log_uniform(rng, 1e-6, 1.0)
    m = L * log_uniform(rng, 1e-4, 0.9)
    w = m * log_uniform(rng, 1e-3, 1.0)
    h = float(rng.choice([-1.0, 1.0])) * log_uniform(rng, 1e-3, 0.95) * 2.0 * w * w / R / (1.0 + 2.0 * w / m)
    return {
        "f": lambda r: r * r / (2.0 * R) + h * np.exp(-0.5 * ((r - m) / w) ** 2),
        "derivative": lambda r: r / R - h / w * ((r - m) / w) * np.exp(-0.5 * ((r - m) / w) ** 2),
        "terms": (Bump(h, m, w),),
        "paraboloid": R,
        "cancels": w > m / 9.0,
        "words": f"r**2/(2*{R!r}) + {h!r}*exp(-0.5*((r-{m!r})/{w!r})**2)",
    }


def shoulder(rng, L):
    """A plateau between two rises: round up to b, f' = s b/r, and a new rise from c."""
    b = L * log_uniform(rng, 1e-5, 0.3)
    s, t = log_uniform(rng, 1e-6, 1.0), log_uniform(rng, 1e-6, 1.0)
    c, n = log_uniform(rng, 1.01 * b, 0.95 * L), float(rng.choice([1.0, 2.0, 3.0]))
    h = t * L / n

    def f(r):
        with np.errstate(divide="ignore"):
            inner = np.where(r > b, s * b / 2.0 + s * b * np.log(r / b), s * r * r / (2.0 * b))
        return inner + h * (np.maximum(r - c, 0.0) / L) ** n

    def derivative(r):
        with np.errstate(divide="ignore"):
            inner = np.where(r > b, s * b / r, s * r / b)
        return inner + np.where(r > c, h * n / L * (np.maximum(r - c, 0.0) / L) ** (n - 1.0), 0.0)

    return {
        "f": f,
        "derivative": derivative,
        "terms": (Shoulder(s, b), Power(h, n, L, c)),
        "kinks": [b, c],
        "words": f"shoulder s={s!r} b={b!r} + {h!r}*(maximum(r-{c!r},0)/{L!r})**{n!r}",
    }


def polynomials(rng, L):
    """f' by linear interpolation, or truncated cubes."""
    count = int(rng.integers(2, 9))
    knots = np.sort(L * np.exp(rng.uniform(np.log(1e-4), np.log(0.9), count)))
    if rng.random() < 0.5:
        knots = np.concatenate([[0.0], knots])
        slopes = np.cumsum(np.append(0.0, rng.exponential(1.0, count)))
        slopes *= log_uniform(rng, 1e-6, 1.0) / slopes[-1]
        return {
            "f": None,
            "derivative": lambda r: np.interp(r, knots, slopes),
            "terms": (linear_slopes(knots, slopes),),
            "kinks": knots[1:].tolist(),
            "words": f"f'=interp(r,{knots.tolist()},{slopes.tolist()})",
        }
    pairs = [(log_uniform(rng, 1e-6, 1.0) * L / 3.0, float(b)) for b in knots]
    R = L / log_uniform(rng, 1e-6, 1.0)
    return {
        "f": lambda r: r * r / (2.0 * R) + sum(c * (np.maximum(r - b, 0.0) / L) ** 3 for c, b in pairs),
        "derivative": lambda r: (
            r / R + sum(3.0 * c / L * (np.maximum(r - b, 0.0) / L) ** 2 for c, b in pairs)
        ),
        "terms": tuple(Power(c, 3.0, L, b) for c, b in pairs),
        "paraboloid": R,
        "kinks": [b for _, b in pairs],
        "words": f"r**2/(2*{R!r}) + " + " + ".join(f"{c!r}*(maximum(r-{b!r},0)/{L!r})**3" for c, b in pairs),
    }


def corners(rng, L):
    """A slope that goes on beside a radius as another one plus a power of the distance from it, whole or broken."""
    b = L * log_uniform(rng, 1e-6, 0.9)
    n = float(rng.choice([1.0, 1.5, 2.0, 3.0, rng.uniform(1.0, 6.0)]))
    p = float(rng.choice([0.25, 1.0 / 3.0, 0.5, 0.75, rng.uniform(0.2, 1.0), rng.uniform(1.0, 3.0)]))
    size = log_uniform(rng, 1e-6, 1.0)
    parts = [(size * L / n, n, 0.0), (size * log_uniform(rng, 1e-6, 1e3) * L / (1.0 + p), 1.0 + p, b)]
    if rng.random() < 0.5:
        parts.append((size * log_uniform(rng, 1e-3, 10.0) * L, 1.0, b))

    def derivative(r):
        return sum(
            np.where(r > b, c * n / L * (np.maximum(r - b, 0.0) / L) ** (n - 1.0), 0.0) for c, n, b in parts
        )

    return {
        "f": lambda r: sum(c * (np.maximum(r - b, 0.0) / L) ** n for c, n, b in parts),
        "derivative": derivative,
        "terms": tuple(Power(c, n, L, b) for c, n, b in parts),
        "kinks": [b],
        "drowns": True,
        "words": " + ".join(f"{c!r}*(maximum(r-{b!r},0)/{L!r})**{n!r}" for c, n, b in parts),
    }


def samples(rng, L):
    """Samples at regular, graded, nearly merged radii, some with noise; the truth is the curve run through them."""
    count = int(rng.integers(6, 41))
    spacing = str(rng.choice(["regular", "geometric", "quadratic", "merged", "random"]))
    t = np.linspace(0.0, 1.0, count)
    if spacing == "regular":
        r = L * t
    elif spacing == "geometric":
        r = L * np.append(0.0, np.geomspace(log_uniform(rng, 1e-5, 0.1), 1.0, count - 1))
    elif spacing == "quadratic":
        r = L * t**2
    else:
        r = L * np.sort(np.append([0.0, 1.0], rng.uniform(0.0, 1.0, count - 2)))
        if spacing == "merged":
            i = int(rng.integers(1, count - 1))
            r = np.sort(np.append(r, r[i] * (1.0 + log_uniform(rng, 1e-9, 1e-3))))
    shape = str(rng.choice(["paraboloid", "power", "hyperboloid", "cone", "flat"]))
    size = log_uniform(rng, 1e-6, 1.0)
    y = r / L
    heights = {
        "paraboloid": y**2 / 2,
        "power": y**1.5 / 1.5,
        "hyperboloid": y * y / (np.hypot(y, 0.1) + 0.1),
        "cone": y,
        "flat": np.maximum(y - 0.3, 0.0) ** 2,
    }
    height = size * L * heights[shape]
    noisy = bool(rng.random() < 0.25)
    if noisy:
        height = height + size * L * log_uniform(rng, 1e-6, 1e-2) * rng.standard_normal(r.size)
    interpolation = str(rng.choice(["round", "sharp", "shape", "smoothing"], p=[0.4, 0.2, 0.25, 0.15]))
    return {
        "samples": (r, height),
        "interpolation": interpolation,
        "noisy": noisy,
        "kinks": [],
        "terms": (),
        "words": f"{r.size} samples, {spacing}, {shape}{', noisy' if noisy else ''}, {interpolation}",
    }


def hides_its_tip(terms, top, offset):
    """Whether the power of a profile changes at radii where it does not rise from an offset: no value of f tells of it."""
    # the narrowest bumps are as wide as a thousandth of their radius
    r = np.geomspace(1e-12 * top, top, 60_000).astype(LONG)
    curve = TermCurve(terms, top)
    panel = np.searchsorted(curve.edges, r, side="right") - 1
    slope = abs(curve.slope(curve.edges[panel], r - curve.edges[panel]))
    risen = np.cumsum(slope * np.gradient(r))
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.diff(np.log(slope)) / np.diff(np.log(r))
    below = (risen[1:] < VISIBLE * offset) & np.isfinite(power)
    return bool(below.any() and np.ptp(power[below]) > 0.05)


KINDS = {
    "powers": power_sum,
    "cones": cones,
    "dead zones": dead_zones,
    "rounded flat": rounded_flat,
    "hyperboloid": hyperboloid,
    "sphere": ball,
    "logarithm": logarithm,
    "exponential": exponential,
    "waves": waves,
    "bump": bump,
    "plateau": shoulder,
    "polynomials": polynomials,
    "samples": samples,
    "corners": corners,
}
WEIGHTS = {"powers": 3.0, "samples": 2.0}


def random_profile(rng, kind=None):
    """
    Draw a profile.

    Parameters
    ----------
    rng : numpy.random.Generator
    kind : str, optional
        One of KINDS; else drawn.
    """
    names = list(KINDS)
    weights = np.array([WEIGHTS.get(n, 1.0) for n in names])
    kind = kind or str(rng.choice(names, p=weights / weights.sum()))
    L = log_uniform(rng, 1e-12, 1e6)
    drawn = KINDS[kind](rng, L)
    terms = drawn["terms"]
    if "paraboloid" in drawn:
        terms = (*terms, Quotient(drawn["paraboloid"]))
    kinks = drawn.get("kinks", [])
    if "samples" in drawn:
        return RandomProfile(
            kind, L, 0.8 * L, (), gives="samples", smooth=not drawn["noisy"], samples=drawn["samples"],
            interpolation=drawn["interpolation"], max_radius=L, words=drawn["words"],
        )  # fmt: skip
    gives = str(rng.choice(["both", "derivative", "f"]))
    if drawn["f"] is None:
        gives = "derivative"
    named = tuple(kinks) if rng.random() < 0.5 else ()
    hidden = () if named else tuple(kinks)
    f, cancels = drawn["f"], drawn.get("cancels", False)
    if f is not None and rng.random() < 0.1:
        offset = log_uniform(rng, 1e-6, 1.0) * L
        if gives == "f" and "pairs" in drawn:
            # a term that drowns in the rounding of the offset is not given
            first, *others = drawn["pairs"]
            drawn = powers_of([first, *(p for p in others if p[0] > VISIBLE * offset)], L)
            f, terms = drawn["f"], drawn["terms"]
        breakpoints_given = gives != "f" or "pairs" in drawn or (kinks and "drowns" not in drawn)
        if breakpoints_given or not hides_its_tip(terms, L, offset):
            plain, cancels = f, True
            f = lambda r: offset + plain(r)  # noqa: E731
            drawn["words"] += f" + {offset!r}"
    return RandomProfile(
        kind, L, L, terms, f, drawn["derivative"], gives, named, hidden, drawn.get("largest", math.inf),
        not hidden and not (gives == "f" and cancels), words=drawn["words"], sources=tuple(kinks),
    )  # fmt: skip


def positions(rng, profile, curve, count):
    """
    Pairs (base, offset) at which to ask: radii over twelve decades, and points close above the kinks.

    Returns arrays of base and offset in extended precision, shuffled.
    """
    low = 1e-12 * profile.top
    sources = [b for b in profile.sources if b < 0.9 * profile.top]
    if profile.samples is not None:
        sources = [float(b) for b in curve.edges[1:] if b < 0.9 * profile.top]
    base, offset = [], []
    for _ in range(count):
        if sources and rng.random() < 0.4:
            b = float(rng.choice(sources))
            base.append(b)
            offset.append(min(b * log_uniform(rng, 1e-12, 1.0), profile.top - b))
        else:
            base.append(0.0)
            offset.append(log_uniform(rng, low, profile.top))
    return np.array(base, dtype=LONG), np.array(offset, dtype=LONG)
