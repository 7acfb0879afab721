"""What contacts with two works of adhesion remember, in C: an edge that advances, recedes and rests in between."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.presentation.c_text import CHEBYSHEV_SUM
from pymdr.units import FloatArray


@dataclass(frozen=True, eq=False)
class CurveInC:
    """The stable branch of a curve of equilibria."""

    cells: FloatArray
    """(n, 5 + columns * terms): D at the beginning of a cell and at the ends of its segment in m, beginning and width in v; Chebyshev terms of
    the columns."""
    columns: int
    """Force in N, radius in m, stiffness at rest in N/m, D in m of the same edge on the other curve; of an edge that advances also the energy
    in J of that state."""
    rim: float
    """D in m at which the edge is at a sharp edge of the profile, else inf."""
    jump_loss: float
    """Energy in J lost in the jump into contact, or out of it."""


@dataclass(frozen=True, eq=False)
class RestingInC:
    """JKR with two works under a prescribed indentation."""

    advancing: CurveInC
    receding: CurveInC
    touch: float
    """Indentation in m of the first touch."""
    pull_off: tuple[float, float, float]
    """Indentation in m, radius in m and force in N of an edge that recedes."""
    stable_from: float
    """Indentation in m to which an edge has advanced that recedes in stable states; from less it leaves at once."""
    per_area: float
    """Energy in J/m^2 lost where the edge recedes."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {
            "TOUCH_INDENTATION": (self.touch, "m"),
            "JUMP_IN_DISSIPATION": (self.advancing.jump_loss, "J"),
            "RECEDING_PULL_OFF_INDENTATION": (self.pull_off[0], "m"),
            "RECEDING_PULL_OFF_RADIUS": (self.pull_off[1], "m"),
            "RECEDING_PULL_OFF_FORCE": (self.pull_off[2], "N"),
            "RECEDING_PULL_OFF_DISSIPATION": (self.receding.jump_loss, "J"),
            "RECEDES_STABLY_FROM_INDENTATION": (self.stable_from, "m"),
            "DISSIPATION_PER_AREA": (self.per_area, "J/m^2"),
        }

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d) goes straight to the indentation d in m: the edge advances at the smaller work, recedes at the larger one and "
            "rests in between, with the jumps into and out of contact; force, radius and energy lost are in the state, which begins as zeros. It "
            "returns 0, or 1 and leaves the state if d is above the largest indentation or not within 1e60. The functions of d alone are those of an "
            "edge that advances. The state has no pointers: copied or saved bytes continue."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        terms = (self.receding.cells.shape[1] - 5) // self.receding.columns
        text = _RESTING.replace("TERMS_", str(terms)).replace("SUM_", CHEBYSHEV_SUM)
        for word, curve in (("ADVANCING", self.advancing), ("RECEDING", self.receding)):
            rows = ",\n".join("    " + ", ".join(map(repr, row)) for row in curve.cells.tolist())
            for part, value in (
                ("CELLS", str(curve.cells.shape[0])),
                ("WIDTH", str(curve.cells.shape[1])),
                ("RIM", repr(curve.rim) if math.isfinite(curve.rim) else "INFINITY"),
                ("ROWS", rows),
            ):
                text = text.replace(f"{part}_OF_{word}", value)
        return text


_RESTING = """\
#define @@_TERMS TERMS_

/* Curves of equilibria over d, of an edge that advances and of one that recedes. Of a cell: d at its beginning and at the ends of its segment,
 * beginning and width in v, where d = low + (high - low) v^2 / (v^2 + (1 - v)^2); Chebyshev terms of force, radius, stiffness at rest and d
 * of the same edge on the other curve; the first curve also has the energy there. */
static const double @_advancing_[CELLS_OF_ADVANCING * WIDTH_OF_ADVANCING] = {
ROWS_OF_ADVANCING
};
static const double @_receding_[CELLS_OF_RECEDING * WIDTH_OF_RECEDING] = {
ROWS_OF_RECEDING
};

typedef struct {
    double indentation;       /* m */
    double normal_force;      /* N */
    double contact_radius;    /* m, 0 without contact */
    double dissipated_energy; /* J, lost in jumps and by hysteresis so far */
    double jumps;             /* number so far */
    double stiffness;         /* N/m, while the edge rests */
    double base[2];           /* m and N, a state of the edge at rest */
    double rests[2];          /* m, indentations between which it rests */
    double leaves_below;      /* m, indentation at which the contact is lost */
    double tear_off;          /* J, lost there, beyond that by hysteresis */
} @_state;

SUM_
/* The state of an edge that has moved to d on a curve. */
static inline void @_land_(@_state *s, double d, int advances)
{
    const int width = advances ? WIDTH_OF_ADVANCING : WIDTH_OF_RECEDING;
    const double *const curve = advances ? @_advancing_ : @_receding_, *cell, *terms;
    int low = 0, high = (advances ? CELLS_OF_ADVANCING : CELLS_OF_RECEDING) - 1;
    double v, rest, u, other;
    while (low < high) {
        const int middle = (low + high + 1) / 2;
        if (d >= curve[middle * width])
            low = middle;
        else
            high = middle - 1;
    }
    cell = curve + low * width;
    terms = cell + 5;
    v = d > cell[1] ? sqrt(d - cell[1]) : 0.0;
    rest = d < cell[2] ? sqrt(cell[2] - d) : 0.0;
    u = (v / (v + rest) - cell[3]) * (2.0 / cell[4]) - 1.0;
    u = u < -1.0 ? -1.0 : u > 1.0 ? 1.0 : u;
    s->normal_force = @_sum_(terms, u);
    s->contact_radius = @_sum_(terms + @@_TERMS, u);
    if (!advances && s->contact_radius < @@_RECEDING_PULL_OFF_RADIUS) /* by rounding, whose square root counts there */
        s->contact_radius = @@_RECEDING_PULL_OFF_RADIUS;
    s->stiffness = @_sum_(terms + 2 * @@_TERMS, u);
    other = @_sum_(terms + 3 * @@_TERMS, u);
    s->leaves_below = @@_RECEDING_PULL_OFF_INDENTATION;
    s->tear_off = @@_RECEDING_PULL_OFF_DISSIPATION;
    if (advances && d < @@_RECEDES_STABLY_FROM_INDENTATION) {
        s->leaves_below = other;
        s->tear_off = @_sum_(terms + 4 * @@_TERMS, u);
    }
    s->base[0] = d;
    s->base[1] = s->normal_force;
    s->rests[0] = advances ? other : d;
    s->rests[1] = advances ? d : other;
    if (d >= (advances ? RIM_OF_ADVANCING : RIM_OF_RECEDING)) /* a sharp edge of the profile */
        s->rests[1] = INFINITY;
}

static inline int @_advance(@_state *s, double d)
{
    const double before = s->contact_radius;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60)
        return 1;
    d = fabs(d) < 1e-290 ? 0.0 : d; /* as the stepper in Python takes it */
    s->indentation = d;
    if (before == 0.0) {
        if (d >= @@_TOUCH_INDENTATION) {
            s->dissipated_energy += @@_JUMP_IN_DISSIPATION;
            s->jumps += 1.0;
            @_land_(s, d, 1);
        }
        return 0;
    }
    if (d > s->rests[1]) {
        @_land_(s, d, 1);
    } else if (d >= s->rests[0]) {
        s->normal_force = s->base[1] + s->stiffness * (d - s->base[0]);
    } else {
        if (d < s->leaves_below) {
            s->dissipated_energy += s->tear_off;
            s->jumps += 1.0;
            s->normal_force = s->contact_radius = 0.0;
        } else {
            @_land_(s, d, 0);
        }
        s->dissipated_energy += @@_DISSIPATION_PER_AREA * (before * before - s->contact_radius * s->contact_radius);
    }
    return 0;
}
"""
