"""What contacts remember, in C: the stack of friction along a line, and the touch of adhesion."""

from __future__ import annotations

from dataclasses import dataclass

CAPACITY = 64
"""Vertices of a stack, the first of which is the tip."""


@dataclass(frozen=True)
class StackInC:
    """Friction along a line, of half-spaces without adhesion."""

    friction: float
    """Coefficient, finite and above 0."""
    ratio: float
    """G* / E*."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        return {
            "FRICTION": (self.friction, ""),
            "TANGENTIAL_RATIO": (self.ratio, ""),
            "PER_SHIFT": (self.ratio / self.friction, ""),
        }

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d, u) goes straight to the indentation d and the shift u in m and writes both forces into the state, which "
            "begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest indentation or a value is not finite. The "
            "state has no pointers: copied or saved bytes continue. @_tangential_error(&state) bounds the error of the tangential force in N."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        return _STACK.replace("CAPACITY_", str(CAPACITY))


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
            "the state, which begins as zeros. It returns 0, or 1 and leaves the state if d is above the largest indentation or not finite."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        return _TOUCH


HistoryInC = StackInC | TouchInC

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
    if (!(d <= @@_LARGEST_INDENTATION) || !isfinite(d))
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

_STACK = """\
#define @@_CAPACITY CAPACITY_

/* Vertices of the anchor curve b(y): the spring that touches at the indentation y carries mu E* (v - b(y)), v the shift times
 * @@_PER_SHIFT, at most mu E* (d - y). A straight step cuts the curve at the new indentation, replaces what is outside the cone
 * |v - b| <= d - y by its edge, and appends the new point (Jaeger 1993). */
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
    double pull[@@_CAPACITY];  /* tangential force over mu of the part of the curve up to a vertex */
} @_state;

static inline void @_put_(@_state *s, int i, double y, double b, double slope, double force)
{
    s->y[i] = y;
    s->b[i] = b;
    s->slope[i] = slope;
    s->force[i] = force;
    s->pull[i] = s->pull[i - 1] + slope * (force - s->force[i - 1]);
}

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
    s->merged += @@_FRICTION * bend * (@_stiffness(s->y[at + 1]) - @_stiffness(s->y[at - 1]));
    s->slope[at + 1] = (s->b[at + 1] - s->b[at - 1]) / (s->y[at + 1] - s->y[at - 1]);
    change = s->pull[at - 1] + s->slope[at + 1] * (s->force[at + 1] - s->force[at - 1]) - s->pull[at + 1];
    for (i = at; i < top; ++i) {
        s->y[i] = s->y[i + 1];
        s->b[i] = s->b[i + 1];
        s->slope[i] = s->slope[i + 1];
        s->force[i] = s->force[i + 1];
        s->pull[i] = s->pull[i + 1] + change;
    }
    return top - 1;
}

static inline int @_advance(@_state *s, double d, double u)
{
    const double before = s->indentation, v = u * @@_PER_SHIFT;
    double force, lag, g;
    int top = (int)s->top;
    if (!(d <= @@_LARGEST_INDENTATION) || !isfinite(d) || !isfinite(u))
        return 1;
    if (before < 0.0 && d > 0.0) {
        const double was = s->shift * @@_PER_SHIFT;
        @_clear_(s, was + (v - was) * (-before / (d - before)));
    }
    s->indentation = d;
    s->shift = u;
    if (d <= 0.0) {
        s->top = s->normal_force = s->tangential_force = 0.0;
        @_clear_(s, v);
        return 0;
    }
    force = d == before ? s->normal_force : @_force(d);
    if (s->y[top] > d) { /* springs part */
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

/* Tangent stiffness in N/m as the motion goes on; a reversal begins with that of y[top]. */
static inline double @_tangential_stiffness(const @_state *s)
{
    const int top = (int)s->top;
    if (!(s->indentation > 0.0) || top < 1)
        return 0.0;
    return @@_TANGENTIAL_RATIO * @_stiffness(s->y[fabs(s->slope[top]) == 1.0 ? top - 1 : top]);
}

static inline double @_tangential_error(const @_state *s)
{
    const int top = (int)s->top;
    double error = 0.0;
    int i;
    for (i = 1; i <= top; ++i)
        error += fabs(s->slope[i] - (i < top ? s->slope[i + 1] : 0.0)) * s->force[i];
    return @@_FRICTION * @@_ERROR_OF_FORCE * error + s->merged;
}
"""
