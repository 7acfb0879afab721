"""Steps of contacts that have no law of the depth alone, in C: jumps between branches of adhesion, and balls that yield."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.presentation.c_text import CHEBYSHEV_SUM
from pymdr.units import FloatArray

_RETURNS = (
    "It returns 0, or 1 and leaves the state if d is above the largest indentation or not within 1e60. The state has no pointers: copied or saved "
    "bytes continue."
)


@dataclass(frozen=True, eq=False)
class BranchesInC:
    """The stable branches of a curve of equilibria, with jumps at their ends."""

    branches: FloatArray
    """(n + 1, 10), a free body first: ends in m; branch reached below and above them, each with the energy lost in J and whether that is a
    jump; first and last segment."""
    segments: FloatArray
    """(m, 2) ends in m."""
    cells: FloatArray
    """(k, 3 + 2 terms): key, beginning and width in v; Chebyshev terms of the force in N and of the contact radius in m."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {}

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d) goes straight to the indentation d in m, with all jumps on the way, and writes force, radius and the energy lost "
            f"in jumps into the state, which begins as zeros. {_RETURNS}"
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        terms = (self.cells.shape[1] - 3) // 2
        text = _BRANCHES.replace("TERMS_", str(terms)).replace("SUM_", CHEBYSHEV_SUM)
        for word, table in (("BRANCHES", self.branches), ("SEGMENTS", self.segments), ("CELLS", self.cells)):
            rows = ",\n".join("    {" + ", ".join(map(_number, row)) + "}" for row in table.tolist())
            text = text.replace(f"{word}_COUNT", str(table.shape[0])).replace(
                f"{word}_WIDTH", str(table.shape[1])
            )
            text = text.replace(f"{word}_ROWS", rows)
        return text


@dataclass(frozen=True)
class YieldingInC:
    """A ball that yields, without adhesion."""

    radius: float
    modulus: float
    shear: float
    poisson: float
    strength: float
    yield_depth: float
    walled: bool

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {
            "BALL_RADIUS": (self.radius, "m"),
            "EFFECTIVE_MODULUS": (self.modulus, "Pa"),
            "SHEAR_MODULUS": (self.shear, "Pa"),
            "POISSON_RATIO": (self.poisson, ""),
            "YIELD_STRENGTH": (self.strength, "Pa"),
            # beyond all indentations, if it does not yield
            "YIELD_INDENTATION": (min(self.yield_depth, self.radius), "m"),
        }

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d) goes straight to the indentation d in m and writes force and radius into the state, which begins as zeros. "
            f"{_RETURNS} The work of a program's own steps, minus what unloading returns, is the energy dissipated."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        wall = " * (1.0 + exp(10.7 * d / @@_BALL_RADIUS - 10.0))" if self.walled else ""
        return _YIELDING.replace("WALL_", wall)


StepInC = BranchesInC | YieldingInC


def _number(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "-INFINITY"
    return repr(value)


_BRANCHES = """\
#define @@_TERMS TERMS_

/* A free body first, then the stable branches: ends in d; branch reached below, energy lost, whether that is a jump; the same above; first and
 * last segment. */
static const double @_branches_[BRANCHES_COUNT][BRANCHES_WIDTH] = {
BRANCHES_ROWS
};
/* Ends in d. */
static const double @_segments_[SEGMENTS_COUNT][SEGMENTS_WIDTH] = {
SEGMENTS_ROWS
};
/* Number of the segment plus v, where d = low + (high - low) v^2 / (v^2 + (1 - v)^2); beginning and width in v; Chebyshev terms of force and
 * radius. */
static const double @_cells_[CELLS_COUNT][CELLS_WIDTH] = {
CELLS_ROWS
};

typedef struct {
    double indentation;       /* m */
    double normal_force;      /* N */
    double contact_radius;    /* m, 0 without contact */
    double dissipated_energy; /* J, lost in jumps so far */
    double jumps;             /* number of steps so far that jumped */
    double branch;            /* 0 without contact */
} @_state;

SUM_
static inline int @_advance(@_state *s, double d)
{
    int branch = (int)s->branch, low, high;
    double jumped = 0.0, v, rest, key, u;
    const double *row, *cell;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60)
        return 1;
    d = fabs(d) < 1e-290 ? 0.0 : d; /* as the stepper in Python takes it */
    for (;;) {
        const double *way;
        row = @_branches_[branch];
        if (d > row[1])
            way = row + 5;
        else if (d < row[0])
            way = row + 2;
        else
            break;
        branch = (int)way[0];
        s->dissipated_energy += way[1];
        if (way[2] > jumped)
            jumped = way[2];
    }
    s->indentation = d;
    s->jumps += jumped;
    s->branch = branch;
    if (branch == 0) {
        s->normal_force = s->contact_radius = 0.0;
        return 0;
    }
    low = (int)row[8];
    high = (int)row[9];
    while (low < high) {
        const int middle = (low + high + 1) / 2;
        if (d >= @_segments_[middle][0])
            low = middle;
        else
            high = middle - 1;
    }
    v = d > @_segments_[low][0] ? sqrt(d - @_segments_[low][0]) : 0.0;
    rest = d < @_segments_[low][1] ? sqrt(@_segments_[low][1] - d) : 0.0;
    v /= v + rest;
    key = low + (v < 1.0 - 2.2e-16 ? v : 1.0 - 2.2e-16);
    low = 0;
    high = CELLS_COUNT - 1;
    while (low < high) {
        const int middle = (low + high + 1) / 2;
        if (key >= @_cells_[middle][0])
            low = middle;
        else
            high = middle - 1;
    }
    cell = @_cells_[low];
    u = (v - cell[1]) * (2.0 / cell[2]) - 1.0;
    u = u < -1.0 ? -1.0 : u > 1.0 ? 1.0 : u;
    s->normal_force = @_sum_(cell + 3, u);
    s->contact_radius = @_sum_(cell + 3 + @@_TERMS, u);
    return 0;
}
"""

_YIELDING = """\
typedef struct {
    double indentation;         /* m */
    double normal_force;        /* N */
    double contact_radius;      /* m, 0 without contact */
    double largest_indentation; /* m so far */
} @_state;

static inline int @_advance(@_state *s, double d)
{
    const double first = @@_YIELD_INDENTATION;
    double most, height = 4.0 * @@_BALL_RADIUS, width = 2.0 * @@_BALL_RADIUS, depth = d, t, sliver;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60)
        return 1;
    most = d > s->largest_indentation ? d : s->largest_indentation;
    if (most >= first && first < @@_BALL_RADIUS) {
        const double pressure = @@_YIELD_STRENGTH * (1.0 + 1.75 * exp(-4.4 * most / @@_BALL_RADIUS));
        const double square = most * (2.0 * @@_BALL_RADIUS - most) - first * (@@_BALL_RADIUS - first);
        const double a = sqrt(square > first * @@_BALL_RADIUS ? square : first * @@_BALL_RADIUS);
        const double half = 2.0 * pressure * a / @@_EFFECTIVE_MODULUS, z = @@_BALL_RADIUS - most + half;
        const double far = sqrt(a * a + z * z);
        const double bends = 2.0 * (@@_POISSON_RATIO - 1.0) - (2.0 * @@_POISSON_RATIO - 1.0) * z / (far + z);
        const double lifted = bends * pressure * a * a / (2.0 * @@_SHEAR_MODULUS * far);
        height = 2.0 * half;
        width = 2.0 * a;
        depth = (d - (most - half - lifted)) / (1.0 + lifted / half);
    }
    depth = depth > 0.0 ? depth : 0.0;
    depth = depth < 0.5 * height ? depth : 0.5 * height;
    t = 4.0 * asin(sqrt(depth / height));
    if (t >= 1.0) {
        sliver = t - sin(t);
    } else { /* its series, without cancellation */
        double term = t * t * t / 6.0;
        int k;
        sliver = 0.0;
        for (k = 1; k <= 10; ++k) {
            sliver += term;
            term *= -t * t / ((2.0 * k + 2.0) * (2.0 * k + 3.0));
        }
    }
    s->indentation = d;
    s->largest_indentation = most;
    s->contact_radius = width / height * sqrt(depth * (height - depth));
    s->normal_force = 0.125 * @@_EFFECTIVE_MODULUS * height * width * sliverWALL_;
    return 0;
}
"""
