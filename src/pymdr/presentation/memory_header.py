"""What bodies with memory remember, in C: springs of Maxwell bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.units import FloatArray

_ADVANCE = """\
static inline int @_advance(@_state *s, double d, double duration)
{
    double turned[@@_SPRINGS];
    return @_press_(s, d, duration, turned);
}

"""


@dataclass(frozen=True, eq=False)
class MemoryInC:
    """Normal force of bodies with memory, without adhesion: every spring relaxes in contact and creeps back when it is free."""

    equilibrium: float
    """E_inf in Pa."""
    viscosity: float
    """Of a parallel dashpot in Pa s."""
    springs: FloatArray
    """(4, n): indentation of the touch, stiffness per unit modulus of the spring, at it and at its outer end, in m."""
    branches: FloatArray
    """(2, m): moduli in Pa and relaxation times in s."""
    modes: FloatArray
    """(2, k): rates in 1/s and deflections of a unit amplitude of free springs."""
    to_modes: FloatArray
    """(k, m + 1): from the branches and the deflection to the modes."""
    to_branches: FloatArray
    """(m, k): back to the branches."""
    capacity: int = 0
    """Least number of stresses that each spring can hold."""
    advance: str = _ADVANCE
    """The step, unless another header moves the springs."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {
            "EQUILIBRIUM_MODULUS": (self.equilibrium, "Pa"),
            "VISCOSITY": (self.viscosity, "Pa s"),
            "GLASSY_MODULUS": (self.equilibrium + float(self.branches[0].sum()), "Pa"),
        }

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d, duration) goes straight to the indentation d in m within a duration in s, 0 for a sudden step, and writes "
            "force and energies into the state, which begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest "
            "indentation, a value is not within 1e60, the duration is below 0, or a dashpot would be moved in zero time. The functions of d alone "
            "are those of a sudden indentation of bodies at rest, without a parallel dashpot; radius and stiffness of a state are "
            "@_contact_radius(&state) and @_sudden_stiffness(&state). The state has no pointers: copied or saved bytes continue."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        text = _MEMORY.replace("SPRING_FUNCTIONS", SPRING).replace("ADVANCE", self.advance)
        text = text.replace("ROWS_OF_SPRINGS", rows_of(self.springs.T)).replace("TABLES_", TABLES)
        tables = self.tables
        sizes = {
            "SPRINGS_": self.springs.shape[1],
            "SIZE_": max(self.capacity, *(len(table) for table in tables[:2])),
        }
        for word, size in sizes.items():
            text = text.replace(word, str(size))
        return filled(text, tables)

    @property
    def tables(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Branches, modes, and the ways to and from the modes as they are in C."""
        branches = np.stack([*self.branches, 1.0 / self.branches[0]], axis=1)
        to_modes, to_branches, modes = self.to_modes, self.to_branches, self.modes.T
        if not branches.size:  # C has no arrays of nothing: a branch that bears nothing
            branches, to_branches = np.array([[0.0, 1.0, 0.0]]), np.zeros((1, modes.shape[0]))
            to_modes = np.insert(to_modes, 0, 0.0, axis=1)
        if not modes.size:
            modes = np.zeros((1, 2))
            to_modes, to_branches = np.zeros((1, to_modes.shape[1])), np.zeros((branches.shape[0], 1))
        return branches, modes, to_modes, to_branches


def filled(text: str, tables: tuple[FloatArray, ...]) -> str:
    """A text with the rows and sizes of the tables of a relaxation."""
    for word, table in zip(_TABLES_IN_C, tables, strict=True):
        text = text.replace(word, rows_of(table))
    return text.replace("BRANCHES_", str(tables[0].shape[0])).replace("MODES_", str(tables[1].shape[0]))


def rows_of(table: FloatArray) -> str:
    """The rows of a table in C."""
    return ",\n".join("    {" + ", ".join(repr(float(value)) for value in row) + "}" for row in table)


_TABLES_IN_C = "ROWS_OF_BRANCHES", "ROWS_OF_MODES", "ROWS_TO_MODES", "ROWS_TO_BRANCHES"
TABLES = """\
/* Of a branch: modulus in Pa, relaxation time in s, and 1/modulus. */
static const double @_branches_[@@_BRANCHES][3] = {
ROWS_OF_BRANCHES
};
/* Of a mode in which a free spring creeps back: rate in 1/s and deflection of a unit amplitude. */
static const double @_modes_[@@_MODES][2] = {
ROWS_OF_MODES
};
static const double @_to_modes_[@@_MODES][@@_BRANCHES + 1] = {
ROWS_TO_MODES
};
static const double @_to_branches_[@@_BRANCHES][@@_MODES] = {
ROWS_TO_BRANCHES
};

"""
"""Tables of a relaxation."""
SPRING = """\
/* Convert the branches of a spring without force to modes. */
static inline void @_release_(@_spring *s)
{
    double m[@@_SIZE] = {0.0}, glassy = @@_EQUILIBRIUM_MODULUS, borne = @@_EQUILIBRIUM_MODULUS * s->deflection;
    int j, k;
    if (@@_VISCOSITY == 0.0) { /* the force left by rounding */
        for (j = 0; j < @@_BRANCHES; ++j) {
            borne += s->h[j];
            glassy += @_branches_[j][0];
        }
        for (j = 0; j < @@_BRANCHES; ++j)
            s->h[j] -= @_branches_[j][0] * borne / glassy;
        s->deflection -= borne / glassy;
    }
    s->rest = s->deflection;
    for (k = 0; k < @@_MODES; ++k) {
        m[k] = @_to_modes_[k][@@_BRANCHES] * s->deflection;
        for (j = 0; j < @@_BRANCHES; ++j)
            m[k] += @_to_modes_[k][j] * s->h[j];
        s->rest -= @_modes_[k][1] * m[k];
    }
    if (@@_EQUILIBRIUM_MODULUS != 0.0)
        s->rest = 0.0;
    for (j = 0; j < @@_SIZE; ++j)
        s->h[j] = m[j];
    s->touches = 0.0;
}

/* Convert the modes of a spring that is touched again to branches. */
static inline void @_touch_(@_spring *s)
{
    double h[@@_SIZE] = {0.0};
    int j, k;
    for (j = 0; j < @@_BRANCHES; ++j)
        for (k = 0; k < @@_MODES; ++k)
            h[j] += @_to_branches_[j][k] * s->h[k];
    for (j = 0; j < @@_SIZE; ++j)
        s->h[j] = h[j];
    s->touches = 1.0;
}

/* Move a spring in contact straight by dw; returns the energy lost, without that of a dashpot. */
static inline double @_strain_(@_spring *s, double dw, const double moments[][6])
{
    double lost = 0.0;
    int j;
    for (j = 0; j < @@_BRANCHES; ++j) {
        const double *m = moments[j], e = @_branches_[j][0] * dw, h = s->h[j];
        lost += (m[3] * h * h + e * (2.0 * m[4] * h + m[5] * e)) * @_branches_[j][2];
        s->h[j] = m[0] * h + m[1] * e;
    }
    s->deflection += dw;
    return lost;
}

/* Let a free spring creep; returns the energy lost. */
static inline double @_creep_(@_spring *s, double duration)
{
    double lost = 0.0;
    int k;
    s->deflection = s->rest;
    for (k = 0; k < @@_MODES; ++k) {
        const double x = @_modes_[k][0] * duration;
        lost -= 0.5 * expm1(-2.0 * x) * s->h[k] * s->h[k];
        s->h[k] *= exp(-x);
        s->deflection += @_modes_[k][1] * s->h[k];
    }
    return lost;
}

"""
"""Functions of one spring."""
_MEMORY = """\
#define @@_SPRINGS SPRINGS_
#define @@_BRANCHES BRANCHES_
#define @@_MODES MODES_
#define @@_SIZE SIZE_

/* Of a spring: the indentation at which it touches; its stiffness, and that of the contact at it and at its outer end, in m per modulus. */
static const double @_springs_[@@_SPRINGS][4] = {
ROWS_OF_SPRINGS
};
TABLES_/* A spring in contact has the deflection w = d - d0 and the stresses h of its branches. It parts where its force would pull; a free one has
 * the amplitudes h of the modes in which it creeps back, and is touched again where the indentation overtakes it. */
typedef struct {
    double deflection; /* m */
    double touches;    /* 1 in contact, else 0 */
    double rest;       /* m, deflection that a free spring of a liquid keeps */
    double h[@@_SIZE]; /* Pa m, or amplitudes of modes */
} @_spring;

typedef struct {
    double indentation;       /* m */
    double normal_force;      /* N */
    double elastic_energy;    /* J */
    double dissipated_energy; /* J so far */
    double edge;              /* m, the indentation at which a spring at the edge of the contact touches */
    double active;            /* number of springs that were touched so far */
    @_spring spring[@@_SPRINGS];
} @_state;

/* A straight move of the indentation, the load of a dashpot during it, and the moments of all branches. */
typedef struct {
    double start, change, duration, drag, moments[@@_SIZE][6];
} @_move_;

/* c + s p + sum of a exp(-x p) + b p mean(x p) over 0 <= p <= 1 */
typedef struct {
    double c, s, a[@@_SIZE], b[@@_SIZE], x[@@_SIZE];
    int count;
} @_sum_;

/* Of a sum at one place: value and slope; its falling terms; first and second derivative of its rising and of its falling terms; size. */
typedef struct {
    double value, slope, falling, rise, bend, drop, curl, size;
} @_bounds_;

static inline double @_mean_(double x)
{
    return x > 0.0 ? -expm1(-x) / x : 1.0;
}

/* A Maxwell element of the stress h that is moved straight by e over x relaxation times bears m0 h + m1 e in the end, m1 h + m2 e on
 * average, and loses m3 h^2 + 2 m4 h e + m5 e^2. */
static inline void @_moments_(double x, double m[6])
{
    const double c = -expm1(-x);
    m[0] = x < 0.5 ? 1.0 - c : exp(-x);
    m[1] = x > 0.0 ? c / x : 1.0;
    m[3] = -0.5 * expm1(-2.0 * x);
    m[4] = 0.5 * c * m[1];
    if (x > 0.3) {
        m[2] = (x - c) / (x * x);
        m[5] = (x - c - 0.5 * c * c) / (x * x);
    } else {
        double term = 0.5, power = 2.0;
        int k;
        m[2] = m[5] = 0.0;
        for (k = 2; k < 16; ++k) {
            m[2] += term;
            m[5] += term * (2.0 - power);
            term *= -x / (k + 1);
            power *= 2.0;
        }
    }
}

static inline @_bounds_ @_at_(const @_sum_ *f, double p)
{
    @_bounds_ at = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    int i;
    at.value = f->c + f->s * p;
    at.size = fabs(f->c);
    for (i = 0; i < f->count; ++i) {
        const double x = f->x[i], gone = -expm1(-x * p), left = 1.0 - gone;
        const double term = left * f->a[i] + f->b[i] * (x > 0.0 ? gone / x : p);
        double slope = f->b[i] - x * f->a[i];
        slope = fabs(slope) > 2e-15 * fabs(x * f->a[i]) ? left * slope : 0.0;
        at.value += term;
        at.size += left * fabs(f->a[i]);
        if (slope > 0.0) {
            at.rise += slope;
            at.bend -= x * slope;
        } else {
            at.falling += term;
            at.drop += slope;
            at.curl -= x * slope;
        }
    }
    at.slope = f->s + at.rise + at.drop;
    return at;
}

/* Bound from below of what goes from before to after, with a convex part from fall to fallen of the slopes steep and flat. */
static inline double @_least_(const double v[6])
{
    const double before = v[0], after = v[1], fall = v[2], fallen = v[3], steep = v[4], flat = v[5];
    double least = before < after ? before : after;
    if (steep < flat) {
        double meet = (fallen - flat - fall) / (steep - flat), bound;
        meet = meet < 0.0 ? 0.0 : meet > 1.0 ? 1.0 : meet;
        bound = before + (steep + (after - fallen) - (before - fall)) * meet;
        if (bound < least)
            least = bound;
    }
    return least;
}

/* The zero of a decreasing sum, by Newton's method within a bracket. */
static inline double @_root_(const @_sum_ *f, double low, double high, double guess)
{
    double p = guess < low ? low : guess > high ? high : guess;
    int i;
    for (i = 0; i < 60; ++i) {
        const @_bounds_ here = @_at_(f, p);
        double next;
        if (here.value > 0.0)
            low = p;
        else
            high = p;
        next = here.slope < 0.0 ? p - here.value / here.slope : low;
        if (!(low < next && next < high))
            next = 0.5 * (low + high);
        if (fabs(next - p) <= 2e-15)
            return next;
        p = next;
    }
    return p;
}

/* The first p from begin to 1 at which a sum falls below 0, or 2: intervals are halved until it surely stays above 0, rises or falls. */
static inline double @_crossing_(const @_sum_ *f, double begin)
{
    const double shortest = 1.0 / 1099511627776.0;
    @_bounds_ now = @_at_(f, begin);
    double p = begin, width = 1.0 - begin;
    if (now.value < -2e-15 * now.size)
        return begin;
    while (p < 1.0) {
        const double end = p + width < 1.0 ? p + width : 1.0;
        @_bounds_ ahead;
        double slack;
        int above, stays;
        width = end - p;
        ahead = @_at_(f, end);
        slack = -2e-15 * (now.size > ahead.size ? now.size : ahead.size);
        above = ahead.value >= -2e-15 * ahead.size;
        {
            const double v[6] = {now.value, ahead.value, now.falling, ahead.falling, width * now.drop, width * ahead.drop};
            stays = above && @_least_(v) >= slack;
        }
        if (!stays) {
            const double up[6] = {now.slope, ahead.slope, now.rise, ahead.rise, width * now.bend, width * ahead.bend};
            const double down[6] = {-now.slope, -ahead.slope, -now.drop, -ahead.drop, -width * now.curl, -width * ahead.curl};
            const int rises = @_least_(up) >= 0.0, falls = @_least_(down) >= 0.0, brief = width <= shortest;
            if (falls && !above)
                return @_root_(f, p, end, p + width * now.value / (now.value - ahead.value));
            if (brief && !above)
                return end;
            stays = (above && (rises || falls || brief)) || rises;
        }
        if (stays) {
            p = end;
            width *= 2.0;
            now = ahead;
        } else {
            width *= 0.5;
        }
    }
    return 2.0;
}

SPRING_FUNCTIONS/* Fraction of the rest of a step at which a spring changes sides. */
static inline double @_turn_(const @_move_ *move, const @_spring *s, double done, double level, double begin)
{
    const double left = 1.0 - done, change = move->change * left, duration = move->duration * left;
    @_sum_ f;
    int j;
    if (s->touches == 0.0) {
        f.count = @@_MODES;
        f.c = level;
        f.s = -change;
        for (j = 0; j < @@_MODES; ++j) {
            f.a[j] = @_modes_[j][1] * s->h[j];
            f.b[j] = 0.0;
            f.x[j] = duration * @_modes_[j][0];
        }
    } else {
        f.count = @@_BRANCHES;
        f.c = @@_EQUILIBRIUM_MODULUS * level + move->drag;
        f.s = @@_EQUILIBRIUM_MODULUS * change;
        for (j = 0; j < @@_BRANCHES; ++j) {
            f.a[j] = s->h[j];
            f.b[j] = @_branches_[j][0] * change;
            f.x[j] = duration / @_branches_[j][1];
        }
    }
    return @_crossing_(&f, begin);
}

/* Move a spring that touches at y and may change sides, last after a fraction `turned` of the step; returns the energy lost. */
static inline double @_follow_(const @_move_ *move, @_spring *s, double y, double *turned)
{
    const double shortest = 1.0 / 1099511627776.0;
    double done = 0.0, lost = 0.0, begin = 0.0;
    for (;;) {
        const int is_free = s->touches == 0.0;
        const double level = is_free ? s->rest + y - move->start - done * move->change : s->deflection;
        const double left = 1.0 - done;
        double part = 2.0, fraction, duration;
        int j;
        /* with a dashpot a free spring touches nothing in no time: a gap below 0 is the rounding of its modes */
        if (left > 0.0 && !(is_free && move->duration == 0.0 && @@_VISCOSITY > 0.0))
            part = @_turn_(move, s, done, level, begin);
        fraction = left * (part < 1.0 ? part : 1.0);
        duration = move->duration * fraction;
        if (is_free) {
            lost += @_creep_(s, duration);
        } else {
            double moments[@@_SIZE][6];
            for (j = 0; j < @@_BRANCHES; ++j)
                @_moments_(duration / @_branches_[j][1], moments[j]);
            lost += @_strain_(s, move->change * fraction, (const double(*)[6])moments) + move->change * fraction * move->drag;
        }
        if (part > 1.0)
            break;
        done += fraction;
        if (is_free) {
            const double there = move->start + done * move->change - y, missed = there - s->deflection;
            const double within = (begin > 2e-15 ? begin : 2e-15) * left * move->duration;
            @_touch_(s);
            /* the error of the search is moved within its resolution in time */
            for (j = 0; j < @@_BRANCHES; ++j)
                s->h[j] += @_branches_[j][0] * missed * @_mean_(within / @_branches_[j][1]);
            s->deflection = there;
        } else {
            @_release_(s);
        }
        begin = begin == 0.0 ? shortest : begin < 0.5 ? 2.0 * begin : 0.5;
    }
    if (s->touches != 0.0)
        s->deflection = move->start + move->change - y;
    *turned = done;
    return lost;
}

/* Whether a spring that touches at y surely stays on its side during a step. */
static inline int @_stays_(const @_move_ *move, const @_spring *s, double y)
{
    const double end = move->start + move->change;
    double least;
    int j;
    if (s->touches == 0.0) {
        least = s->rest + y - (end > move->start ? end : move->start);
        for (j = 0; j < @@_MODES; ++j) {
            const double before = @_modes_[j][1] * s->h[j], after = before * exp(-@_modes_[j][0] * move->duration);
            least += before < after ? before : after;
        }
        return least > 0.0;
    }
    least = @@_EQUILIBRIUM_MODULUS * (s->deflection < end - y ? s->deflection : end - y) + move->drag;
    for (j = 0; j < @@_BRANCHES; ++j) {
        const double after = move->moments[j][0] * s->h[j] + move->moments[j][1] * (@_branches_[j][0] * move->change);
        least += s->h[j] < after ? s->h[j] : after;
    }
    return least >= 0.0;
}

/* The stress of a spring in contact. */
static inline double @_stress_(const @_spring *s, double drag)
{
    double q = @@_EQUILIBRIUM_MODULUS * s->deflection + drag;
    int j;
    for (j = 0; j < @@_BRANCHES; ++j)
        q += s->h[j];
    return q;
}

/* The indentation at which a spring at the edge touches, after the last one in contact: the median of three estimates of second order. */
static inline double @_edge_of_(const @_state *s, const @_move_ *move, int last, double q_before, double q_last)
{
    const double end = move->start + move->change, inner = @_springs_[last][0], y = @_springs_[last + 1][0];
    const double here = s->spring[last + 1].deflection, gap = here + y - end;
    double slope = 0.0, outward = inner, inward = y, across = inner, trial, modulus = @@_EQUILIBRIUM_MODULUS, low, high;
    int j;
    if (here == 0.0)
        return end < inner ? inner : end > y ? y : end;
    if (last + 2 < @@_SPRINGS && @_springs_[last + 2][0] > y)
        slope = (s->spring[last + 2].deflection - here) / (@_springs_[last + 2][0] - y);
    if (slope > -1.0) {
        outward = y - gap / (1.0 + slope);
        outward = outward < inner ? inner : outward > y ? y : outward;
    }
    if (move->drag != 0.0 || last == 0)
        return outward;
    if (q_before > q_last) {
        inward = inner + q_last * (inner - @_springs_[last - 1][0]) / (q_before - q_last);
        if (inward > y)
            inward = y;
    }
    for (j = 0; j < @@_BRANCHES; ++j)
        modulus += @_branches_[j][0] * @_mean_(1e-3 * move->duration / @_branches_[j][1]);
    trial = q_last + modulus * gap;
    if (trial > 0.0)
        across = inner + (y - inner) * q_last / trial;
    low = outward < inward ? outward : inward;
    high = outward < inward ? inward : outward;
    return across < low ? low : across > high ? high : across;
}

/* The force that the sum over springs misses up to the edge, by trapezia. */
static inline double @_up_to_edge_(double edge, double drag, int last, double q_before, double q_last)
{
    const double *at = @_springs_[last], inner = at[0], y = @_springs_[last + 1][0], centre = at[2];
    const double k_edge = y > inner ? centre + (@_springs_[last + 1][2] - centre) * ((edge - inner) / (y - inner)) : at[3];
    double border = 0.0, q_border = q_last, slope = 0.0, q_edge = 0.0;
    if (last > 0) {
        border = @_springs_[last - 1][3];
        slope = (q_last - q_before) / (centre - @_springs_[last - 1][2]);
        q_border = q_last - slope * (centre - border);
    }
    if (drag != 0.0 && q_last + slope * (k_edge - centre) > 0.0)
        q_edge = q_last + slope * (k_edge - centre);
    return 0.5 * (q_border + q_last) * (centre - border) + 0.5 * (q_last + q_edge) * (k_edge - centre) - q_last * at[1];
}

/* As @_advance; the fractions of the step at which springs changed sides are written to `turned`. */
static inline int @_press_(@_state *s, double d, double duration, double turned[@@_SPRINGS])
{
    const double before = s->indentation, top = before > d ? before : d;
    const int sudden = @@_VISCOSITY > 0.0 && duration == 0.0;
    double q = 0.0, q_last = 0.0, q_before = 0.0;
    int i, j, last = -1;
    @_move_ move;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60 || !(duration >= 0.0 && duration <= 1e60))
        return 1;
    if (sudden && d != before && top > 0.0)
        return 1;
    move.start = sudden ? d : before;
    move.change = d - move.start;
    move.duration = duration;
    move.drag = @@_VISCOSITY > 0.0 && move.change != 0.0 ? @@_VISCOSITY * move.change / duration : 0.0;
    for (j = 0; j < @@_BRANCHES; ++j)
        @_moments_(duration / @_branches_[j][1], move.moments[j]);
    s->normal_force = s->elastic_energy = s->edge = 0.0;
    for (i = 0; i < @@_SPRINGS && (i < (int)s->active || @_springs_[i][0] < top); ++i) {
        @_spring *spring = &s->spring[i];
        const double y = @_springs_[i][0], dk = @_springs_[i][1];
        double lost, stored = 0.0;
        if (!@_stays_(&move, spring, y)) {
            lost = @_follow_(&move, spring, y, &turned[i]);
        } else if (spring->touches == 0.0) {
            lost = @_creep_(spring, duration);
        } else {
            lost = @_strain_(spring, move.change, (const double(*)[6])move.moments) + move.change * move.drag;
            spring->deflection = d - y;
        }
        s->dissipated_energy += dk * lost;
        if (spring->touches == 0.0) {
            for (j = 0; j < @@_MODES; ++j)
                stored += spring->h[j] * spring->h[j];
        } else {
            for (j = 0; j < @@_BRANCHES; ++j)
                stored += spring->h[j] * spring->h[j] * @_branches_[j][2];
            stored += @@_EQUILIBRIUM_MODULUS * spring->deflection * spring->deflection;
            q = @_stress_(spring, move.drag);
            s->normal_force += dk * q;
            last = i;
            q_before = q_last;
            q_last = q;
        }
        s->elastic_energy += 0.5 * dk * stored;
    }
    s->active = i;
    s->indentation = d;
    if (last == @@_SPRINGS - 1) /* up to a sharp edge of the profile */
        s->edge = @@_LARGEST_INDENTATION;
    if (0 <= last && last < @@_SPRINGS - 1) {
        s->edge = @_edge_of_(s, &move, last, q_before, q_last);
        s->normal_force += @_up_to_edge_(s->edge, move.drag, last, q_before, q_last);
    }
    return 0;
}

ADVANCE/* Contact radius in m after a step. */
static inline double @_contact_radius(const @_state *s)
{
    return @_radius(s->edge < @@_LARGEST_INDENTATION ? s->edge : @@_LARGEST_INDENTATION);
}

/* Stiffness of a sudden step in N/m, of the moduli that have not relaxed; INFINITY in contact where a dashpot resists. */
static inline double @_sudden_stiffness(const @_state *s)
{
    const double edge = s->edge < @@_LARGEST_INDENTATION ? s->edge : @@_LARGEST_INDENTATION;
    return @@_VISCOSITY > 0.0 && edge > 0.0 ? (double)INFINITY : @_stiffness(edge);
}
"""
