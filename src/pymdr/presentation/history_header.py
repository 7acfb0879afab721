"""What contacts remember, in C: the stack of friction along a line, springs in the plane, and the touch of adhesion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.presentation.memory_header import MemoryInC
from pymdr.presentation.resting_header import RestingInC
from pymdr.presentation.sheared_header import ShearedInC

CAPACITY = 64
"""Vertices of a stack, the first of which is the tip."""


@dataclass(frozen=True)
class StackInC:
    """Friction along a line, of half-spaces without adhesion."""

    friction: float
    """Coefficient above 0; inf where nothing slips."""
    ratio: float
    """G* / E*."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        ratio = {"TANGENTIAL_RATIO": (self.ratio, "")}
        if math.isinf(self.friction):
            return ratio
        return {"FRICTION": (self.friction, ""), **ratio, "PER_SHIFT": (self.ratio / self.friction, "")}

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d, u) goes straight to the indentation d and the shift u in m and writes both forces into the state, which "
            "begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest indentation or a value is not within 1e60. The "
            "state has no pointers: copied or saved bytes continue. @_tangential_error(&state) bounds the error of the tangential force in N; define "
            "@@_CAPACITY, at least 3, before the header for stacks of another length."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        stuck = math.isinf(self.friction)
        text = _CAPACITY.replace("CAPACITY_", str(CAPACITY)) + (_STUCK if stuck else _STACK)
        for word, shared in (
            ("VERTICES_", _VERTICES),
            ("MERGE_", _MERGE),
            ("STIFFNESS_", _STIFFNESS),
            ("BEGIN_", _BEGIN),
            ("SCALE_", "@@_TANGENTIAL_RATIO" if stuck else "@@_PER_SHIFT"),
            ("FACTOR_", "" if stuck else "@@_FRICTION * "),
            ("MEAN_", _MEAN if stuck else _SLOPED),
            ("STICKS_", "top" if stuck else "fabs(s->slope[top]) == 1.0 ? top - 1 : top"),
        ):
            text = text.replace(word, shared)
        return text


@dataclass(frozen=True)
class TouchInC:
    """JKR under a prescribed indentation: contact from the first touch to the pull-off."""

    jump_in_loss: float
    """Energy in J lost in the jump into contact."""
    pull_off_loss: float
    """Energy in J lost in the jump out of it."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {
            "JUMP_IN_DISSIPATION": (self.jump_in_loss, "J"),
            "PULL_OFF_DISSIPATION": (self.pull_off_loss, "J"),
        }

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d) goes straight to the indentation d in m, with the jumps into and out of contact, and writes the force into "
            "the state, which begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest indentation or not within 1e60."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        return _TOUCH


@dataclass(frozen=True)
class SpringsInC:
    """Friction in the plane, of half-spaces without adhesion: every spring carries a vector."""

    touches: tuple[float, ...]
    """Indentations in m at which the springs touch, rising."""
    per_force: float
    """Force in N over the sum of the vectors in m."""
    per_shift: float
    """Shift in m over its normalised value in m."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {"PER_SHIFT": (1.0 / self.per_shift, ""), "PER_FORCE": (self.per_force, "N/m")}

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d, u_x, u_y) goes straight to the indentation d and the shift (u_x, u_y) in m and writes the forces into the "
            "state, which begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest indentation or a value is not "
            "within 1e60. @_rotate(&state, angle) turns shift, force and springs by an angle in rad, for contacts whose plane turns. The state has "
            "no pointers: copied or saved bytes continue. The error of the springs is not in the errors above."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        rows = ",\n".join(f"    {touch!r}" for touch in self.touches)
        return _SPRINGS.replace("COUNT_", str(len(self.touches))).replace("TOUCHES_", rows)


HistoryInC = ShearedInC | StackInC | SpringsInC | TouchInC | RestingInC | MemoryInC

_SPRINGS = """\
#define @@_SPRINGS COUNT_

/* Indentations in m at which the springs touch. */
static const double @_touches_[@@_SPRINGS] = {
TOUCHES_
};

/* A spring that touches at the indentation y carries the vector t, |t| <= d - y, times PER_FORCE. */
typedef struct {
    double indentation;  /* m */
    double shift[2];     /* m */
    double normal_force; /* N */
    double force[2];     /* N, resists the shift */
    double t[@@_SPRINGS][2]; /* m */
} @_state;

/* A spring whose limit goes from low to high while the shift goes by length along e. It sticks until |t| is at its limit; from there it
 * slips along t, and tan(theta / 2) falls as exp(-tau), dtau = ds / limit, with the angle theta of t to e. */
static inline void @_spring_(double t[2], double low, double high, const double e[2], double length)
{
    double change, along, across, a, b, c, begin = INFINITY, until = 1.0;
    int beyond;
    if (low <= 0.0) {
        double bears = 0.0;
        if (high > 0.0) { /* it touches where the shift is then */
            bears = length * (high / (high - low));
            if (bears > high)
                bears = high;
        }
        t[0] = bears * e[0];
        t[1] = bears * e[1];
        return;
    }
    if (high <= 0.0) { /* it parts */
        t[0] = t[1] = 0.0;
        return;
    }
    along = t[0] * e[0] + t[1] * e[1];
    across = t[1] * e[0] - t[0] * e[1];
    change = high - low;
    a = (length - change) * (length + change);
    b = along * length - low * change;
    c = along * along + across * across - low * low;
    if (c > 0.0)
        c = 0.0;
    beyond = (along + length) * (along + length) + across * across > high * high;
    if (beyond) {
        if (b > 0.0 && c >= -1e-15 * low * low) {
            begin = 0.0;
        } else if (b > 0.0) {
            const double inside = b * b - a * c;
            if (inside >= 0.0)
                begin = -c / (b + sqrt(inside));
        } else if (a > 0.0) {
            begin = (sqrt(b * b - a * c) - b) / a;
        }
    }
    if (begin < until)
        until = begin;
    along += until * length;
    low += until * change;
    if (beyond && until == 1.0) { /* by rounding */
        const double part = high / sqrt(along * along + across * across);
        along *= part;
        across *= part;
    } else if (until < 1.0) {
        const double left = length * (1.0 - until), rest = high - low;
        const double tau = left == 0.0 ? 0.0 : rest == 0.0 ? left / low : left * log1p(rest / low) / rest;
        const double turned = exp(-tau), size = sqrt(along * along + across * across);
        double near = size + fabs(along), far = across * across / near, sum;
        if (along < 0.0) {
            const double other = near;
            near = far;
            far = other;
        }
        sum = near + far * turned * turned;
        if (sum > 0.0) { /* else it lies against the shift */
            along = high * (near - far * turned * turned) / sum;
            across = high * 2.0 * across * turned / sum;
        } else {
            along = -high;
        }
    }
    t[0] = along * e[0] - across * e[1];
    t[1] = along * e[1] + across * e[0];
}

/* Depths next to nothing, whose products underflow, are none. */
static inline double @_depth_(double d)
{
    return d > 0.0 && d <= 1e-150 ? 0.0 : d;
}

static inline int @_advance(@_state *s, double d, double u_x, double u_y)
{
    const double v_x = (u_x - s->shift[0]) * @@_PER_SHIFT, v_y = (u_y - s->shift[1]) * @@_PER_SHIFT;
    const double length = sqrt(v_x * v_x + v_y * v_y);
    const double before = @_depth_(s->indentation), after = @_depth_(d);
    double e[2] = {1.0, 0.0};
    int i;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60 || !(fabs(u_x) <= 1e60) || !(fabs(u_y) <= 1e60))
        return 1;
    if (length > 0.0) {
        e[0] = v_x / length;
        e[1] = v_y / length;
    }
    s->force[0] = s->force[1] = 0.0;
    for (i = 0; i < @@_SPRINGS && @_touches_[i] < (before > after ? before : after); ++i) {
        @_spring_(s->t[i], before - @_touches_[i], after - @_touches_[i], e, length);
        s->force[0] += @@_PER_FORCE * s->t[i][0];
        s->force[1] += @@_PER_FORCE * s->t[i][1];
    }
    s->indentation = d;
    s->shift[0] = u_x;
    s->shift[1] = u_y;
    s->normal_force = @_force(d);
    return 0;
}

static inline void @_turn_(double p[2], double cosine, double sine)
{
    const double x = p[0];
    p[0] = cosine * x - sine * p[1];
    p[1] = sine * x + cosine * p[1];
}

static inline void @_rotate(@_state *s, double angle)
{
    const double cosine = cos(angle), sine = sin(angle);
    int i;
    @_turn_(s->shift, cosine, sine);
    @_turn_(s->force, cosine, sine);
    for (i = 0; i < @@_SPRINGS; ++i)
        @_turn_(s->t[i], cosine, sine);
}
"""

_TOUCH = """\
typedef struct {
    double indentation;       /* m */
    double normal_force;      /* N */
    double dissipated_energy; /* J, lost in jumps so far */
    double jumps;             /* number so far */
    double touches;           /* 1 in contact, else 0 */
} @_state;

static inline int @_advance(@_state *s, double d)
{
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60)
        return 1;
    if (s->touches == 0.0 && d >= @@_JUMP_IN_INDENTATION) {
        s->touches = 1.0;
        s->jumps += 1.0;
        s->dissipated_energy += @@_JUMP_IN_DISSIPATION;
    }
    if (s->touches != 0.0 && d < @@_PULL_OFF_INDENTATION) {
        s->touches = 0.0;
        s->jumps += 1.0;
        s->dissipated_energy += @@_PULL_OFF_DISSIPATION;
    }
    s->indentation = d;
    s->normal_force = s->touches != 0.0 ? @_force(d) : 0.0;
    return 0;
}
"""

_SLOPED = "s->slope[at + 1] * (s->force[at + 1] - s->force[at - 1])"
_MEAN = (
    "(s->b[at + 1] - s->b[at - 1]) * @_mean_(s->y[at - 1], s->force[at - 1], s->y[at + 1], s->force[at + 1])"
)

_CAPACITY = """\
#ifndef @@_CAPACITY
#define @@_CAPACITY CAPACITY_
#endif
#if @@_CAPACITY < 3
#error "a stack needs room for at least 3 vertices"
#endif

"""

_VERTICES = """\
typedef struct {
    double indentation;      /* m */
    double shift;            /* m */
    double normal_force;     /* N */
    double tangential_force; /* N, resists the shift */
    double merged;           /* N, bound of the change of the tangential force by merged vertices, until they are forgotten */
    double top;              /* index of the last vertex; that of the tip is 0 */
    double y[@@_CAPACITY];
    double b[@@_CAPACITY];
    double slope[@@_CAPACITY]; /* of the segment below a vertex */
    double force[@@_CAPACITY]; /* normal force at y */
    double pull[@@_CAPACITY];  /* tangential force, over mu if it is finite, of the part of the curve up to a vertex */
} @_state;
"""

_MERGE = """\
static inline void @_clear_(@_state *s, double b)
{
    s->y[0] = s->slope[0] = s->force[0] = s->pull[0] = s->merged = 0.0;
    s->b[0] = b;
}

/* Remove the inner vertex that encloses the least area with its neighbours. */
static inline int @_merge_(@_state *s, int top)
{
    double least = INFINITY, bend, change;
    int i, at = 1;
    for (i = 1; i < top; ++i) {
        const double area = fabs((s->y[i + 1] - s->y[i - 1]) * (s->b[i] - s->b[i - 1])
                                 - (s->y[i] - s->y[i - 1]) * (s->b[i + 1] - s->b[i - 1]));
        if (area < least) {
            least = area;
            at = i;
        }
    }
    bend = least / (s->y[at + 1] - s->y[at - 1]);
    /* the change of b is at most the bend, and stays between both neighbours */
    s->merged += FACTOR_bend * (@_stiffness(s->y[at + 1]) - @_stiffness(s->y[at - 1]));
    s->slope[at + 1] = (s->b[at + 1] - s->b[at - 1]) / (s->y[at + 1] - s->y[at - 1]);
    change = s->pull[at - 1] + MEAN_ - s->pull[at + 1];
    for (i = at; i < top; ++i) {
        s->y[i] = s->y[i + 1];
        s->b[i] = s->b[i + 1];
        s->slope[i] = s->slope[i + 1];
        s->force[i] = s->force[i + 1];
        s->pull[i] = s->pull[i + 1] + change;
    }
    return top - 1;
}

"""

_STIFFNESS = """\
/* Tangent stiffness in N/m as the motion goes on; a reversal begins with that of y[top]. */
static inline double @_tangential_stiffness(const @_state *s)
{
    const int top = (int)s->top;
    if (!(s->indentation > 0.0) || top < 1)
        return 0.0;
    return @@_TANGENTIAL_RATIO * @_stiffness(s->y[STICKS_]);
}

"""

_BEGIN = """\
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60 || !(fabs(u) <= 1e60))
        return 1;
    if (before < 0.0 && d > 1e-150) {
        const double was = s->shift * SCALE_;
        @_clear_(s, was + (v - was) * (-before / (d - before)));
    }
    s->indentation = d;
    s->shift = u;
    if (d <= 1e-150) { /* none: its products underflow */
        s->top = s->normal_force = s->tangential_force = 0.0;
        @_clear_(s, v);
        return 0;
    }
    force = d == before ? s->normal_force : @_force(d);
"""

_STACK = """\
/* Vertices of the anchor curve b(y): the spring that touches at the indentation y carries mu E* (v - b(y)), v the shift times
 * @@_PER_SHIFT, at most mu E* (d - y). A straight step cuts the curve at the new indentation, replaces what is outside the cone
 * |v - b| <= d - y by its edge, and appends the new point (Jaeger 1993). */
VERTICES_
static inline void @_put_(@_state *s, int i, double y, double b, double slope, double force)
{
    s->y[i] = y;
    s->b[i] = b;
    s->slope[i] = slope;
    s->force[i] = force;
    s->pull[i] = s->pull[i - 1] + slope * (force - s->force[i - 1]);
}

MERGE_static inline int @_advance(@_state *s, double d, double u)
{
    const double before = s->indentation, v = u * SCALE_;
    double force, lag, g;
    int top = (int)s->top;
BEGIN_    if (s->y[top] > d) { /* springs part */
        while (s->y[top - 1] >= d)
            --top;
        if (top > 0)
            @_put_(s, top, d, s->b[top - 1] + s->slope[top] * (d - s->y[top - 1]), s->slope[top], force);
    }
    lag = fabs(v - s->b[top]) - (d - s->y[top]);
    if (lag <= 0.0) {
        if (d > s->y[top]) { /* a segment that sticks, joined to one of the same slope */
            const double slope = (v - s->b[top]) / (d - s->y[top]);
            if (top > 0 && fabs(slope - s->slope[top]) <= 1e-14) {
                @_put_(s, top, d, v, s->slope[top], force);
            } else {
                if (top == @@_CAPACITY - 1)
                    top = @_merge_(s, top);
                ++top;
                @_put_(s, top, d, v, slope, force);
            }
        }
    } else {
        g = v > s->b[top] ? 1.0 : -1.0;
        while (top > 0 && (g * v - d) - (g * s->b[top - 1] - s->y[top - 1]) > 0.0)
            --top;
        if (top == 0) { /* the whole contact slides */
            @_clear_(s, v - g * d);
        } else {
            const double below = s->y[top - 1], slope = s->slope[top];
            const double over = g * (v - s->b[top]) - (d - s->y[top]), bend = 1.0 - g * slope;
            const double y = over < bend * (s->y[top] - below) ? s->y[top] - over / bend : below;
            if (y - below > 1.8e-15 * (d + fabs(v))) {
                @_put_(s, top, y, s->b[top - 1] + slope * (y - below), slope, @_force(y));
            } else {
                --top;
                if (top > 0 && s->slope[top] == g)
                    --top;
            }
        }
        if (top == @@_CAPACITY - 1)
            top = @_merge_(s, top);
        ++top;
        @_put_(s, top, d, v, g, force);
    }
    s->top = top;
    s->normal_force = force;
    s->tangential_force = @@_FRICTION * s->pull[top];
    return 0;
}

STIFFNESS_static inline double @_tangential_error(const @_state *s)
{
    const int top = (int)s->top;
    double error = 0.0;
    int i;
    for (i = 1; i <= top; ++i)
        error += fabs(s->slope[i] - (i < top ? s->slope[i + 1] : 0.0)) * s->force[i];
    return @@_FRICTION * @@_ERROR_OF_FORCE * error + s->merged;
}
"""

_STUCK = """\
/* Vertices of the curve b(y): the spring that touches at the indentation y carries E* (v - b(y)), v the shift times @@_TANGENTIAL_RATIO. A
 * straight step cuts the curve at the new indentation and appends the new point; two vertices at one depth are a jump. */
VERTICES_
/* The mean normal stiffness between two depths with their forces. */
static inline double @_mean_(double low, double force_low, double high, double force_high)
{
    const double length = high - low;
    if (length > 1e-3 * high)
        return (force_high - force_low) / length;
    return (@_stiffness(low) + 4.0 * @_stiffness(low + 0.5 * length) + @_stiffness(high)) / 6.0;
}

/* Shift per indentation; 0 for a jump, and where a change of the indentation next to nothing would make it infinite. */
static inline double @_slope_(double step, double length)
{
    return fabs(step) < 1e300 * length ? step / length : 0.0;
}

static inline void @_put_(@_state *s, int i, double y, double b, double force)
{
    const double step = b - s->b[i - 1];
    s->y[i] = y;
    s->b[i] = b;
    s->slope[i] = @_slope_(step, y - s->y[i - 1]);
    s->force[i] = force;
    s->pull[i] = s->pull[i - 1] + step * @_mean_(s->y[i - 1], s->force[i - 1], y, force);
}

MERGE_static inline int @_advance(@_state *s, double d, double u)
{
    const double before = s->indentation, v = u * SCALE_;
    double force;
    int top = (int)s->top, joins = 0;
BEGIN_    if (d < s->y[top]) { /* springs part */
        while (s->y[top - 1] >= d)
            --top;
        @_put_(s, top, d, s->b[top - 1] + s->slope[top] * (d - s->y[top - 1]), force);
    } else if (d > s->y[top]) {
        const double slope = @_slope_(v - s->b[top], d - s->y[top]);
        joins = top > 0 && s->y[top] > s->y[top - 1] && fabs(slope - s->slope[top]) <= 1e-14 * fabs(slope);
    }
    if (d > s->y[top] || v < s->b[top] || v > s->b[top]) {
        if (!joins && !(top > 0 && s->y[top - 1] >= d)) {
            if (top == @@_CAPACITY - 1)
                top = @_merge_(s, top);
            ++top;
        }
        @_put_(s, top, d, v, force);
    }
    s->top = top;
    s->normal_force = force;
    s->tangential_force = s->pull[top];
    return 0;
}

STIFFNESS_static inline double @_tangential_error(const @_state *s)
{
    const int top = (int)s->top;
    double error = 0.0;
    int i;
    for (i = 1; i <= top; ++i)
        error += fabs(s->b[i] - s->b[i - 1]) * @_stiffness(s->y[i]);
    return @@_ERROR_OF_STIFFNESS * error + s->merged;
}
"""
