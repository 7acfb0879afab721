"""What bodies with memory and friction along a line remember, in C: springs with tangential partners."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pymdr.presentation.memory_header import SPRING, TABLES, MemoryInC, filled


@dataclass(frozen=True, eq=False)
class ShearedInC:
    """Friction along a line of bodies with memory without a parallel dashpot: every spring has a partner, which sticks or slips."""

    pressed: MemoryInC
    """The normal springs."""
    partners: MemoryInC
    """Their tangential partners, on the same springs."""
    friction: float
    """Coefficient, finite and above 0."""
    parts: int
    """Equal parts of each step, on which loads are straight; the first is divided further."""

    @property
    def constants(self) -> dict[str, tuple[float, str]]:
        """Value and unit by name."""
        shortest = min(float(springs.branches[1].min()) for springs in (self.pressed, self.partners))
        own = {
            "FRICTION": (self.friction, ""),
            "SHEAR_MODULUS": (self.partners.equilibrium, "Pa"),
            "SHORTEST_TIME": (shortest, "s"),
        }
        return self.pressed.constants | own

    @property
    def usage(self) -> str:
        """How the state is used."""
        return (
            "@_advance(&state, d, u, duration) goes straight to the indentation d and the shift u in m within a duration in s, 0 for a sudden "
            "step, and writes both forces and the energies into the state, which begins as zeros. It returns 0, or 1 and leaves the state if d "
            "is above the largest indentation, a value is not within 1e60, or the duration is below 0. Loads are straight on each of @@_PARTS equal "
            "parts of a step, of which the first is divided from the shortest relaxation time, two parts a decade; define @@_PARTS before the header "
            "for others. The functions of d alone are those of a sudden indentation of bodies "
            "at rest; the radius is @_contact_radius(&state.pressed). The state has no pointers: copied or saved bytes continue."
        )

    @property
    def body(self) -> str:
        """Type and functions, with @ for the name and @@ for the name in capitals."""
        tables, pair = self.partners.tables, (self.pressed.tables, self.partners.tables)
        capacity = max(len(table) for both in pair for table in both[:2])
        text = replace(self.pressed, capacity=capacity, advance="").body.replace("@_state", "@_pressed")
        own = _SHEARED.replace("PARTS_", str(self.parts)).replace(
            "SPRING_FUNCTIONS", SPRING.replace("@@_VISCOSITY", "0.0")
        )
        own = own.replace("TABLES_", TABLES)
        for word in ("@_branches_", "@_modes_", "@_to_modes_", "@_to_branches_"):
            own = own.replace(word, word.replace("@_", "@_shear_"))
        for word in ("@_release_", "@_touch_", "@_strain_", "@_creep_"):
            own = own.replace(word, word.replace("@_", "@_shear_"))
        for word, other in (
            ("@@_EQUILIBRIUM_MODULUS", "@@_SHEAR_MODULUS"),
            ("@@_BRANCHES", "@@_SHEAR_BRANCHES"),
            ("@@_MODES", "@@_SHEAR_MODES"),
        ):
            own = own.replace(word, other)
        return text + "\n" + filled(own, tables)


_SHEARED = """\
#ifndef @@_PARTS
#define @@_PARTS PARTS_
#endif
#define @@_BRANCHES BRANCHES_
#define @@_MODES MODES_

/* Tables of the tangential partners of springs. */
TABLES_
SPRING_FUNCTIONS
typedef struct {
    double shift;                    /* m */
    double normal_force;             /* N */
    double tangential_force;         /* N, which resists the shift */
    double elastic_energy;           /* J */
    double stored_tangential_energy; /* J */
    double dissipated_energy;        /* J so far, in dashpots and by slip */
    double shear_dissipation;        /* J so far, without that of the normal springs */
    @_pressed pressed;
    @_spring partner[@@_SPRINGS];
} @_state;

/* A part of a step for a spring: shift, duration, and the limits of its force at both ends. */
typedef struct {
    double change, duration, low, high;
} @_pull_;

/* The force of a partner that is moved straight by dv within a duration. */
static inline double @_shear_force_(const @_spring *s, double dv, double duration)
{
    double q = @@_EQUILIBRIUM_MODULUS * (s->deflection + dv);
    int j;
    for (j = 0; j < @@_BRANCHES; ++j) {
        const double x = duration / @_branches_[j][1];
        q += exp(-x) * s->h[j] + @_branches_[j][0] * dv * @_mean_(x);
    }
    return q;
}

/* Move a partner straight by dv; returns its mean force, and adds the energy lost. */
static inline double @_shear_move_(@_spring *s, double dv, double duration, double *lost)
{
    double moments[@@_SIZE][6], mean = @@_EQUILIBRIUM_MODULUS * (s->deflection + 0.5 * dv);
    int j;
    for (j = 0; j < @@_BRANCHES; ++j) {
        @_moments_(duration / @_branches_[j][1], moments[j]);
        mean += moments[j][1] * s->h[j] + moments[j][2] * @_branches_[j][0] * dv;
    }
    *lost += @_strain_(s, dv, (const double(*)[6])moments);
    return mean;
}

/* The fraction of a part in which a partner sticks, whose force exceeds its limit at the end. */
static inline double @_sticks_(const @_pull_ *pull, const @_spring *s, double sign)
{
    @_sum_ f;
    double p;
    int j;
    f.count = @@_BRANCHES;
    f.c = pull->low - sign * @@_EQUILIBRIUM_MODULUS * s->deflection;
    f.s = pull->high - pull->low - sign * @@_EQUILIBRIUM_MODULUS * pull->change;
    for (j = 0; j < @@_BRANCHES; ++j) {
        f.a[j] = -sign * s->h[j];
        f.b[j] = -sign * @_branches_[j][0] * pull->change;
        f.x[j] = pull->duration / @_branches_[j][1];
    }
    p = @_crossing_(&f, 0.0);
    return p < 1.0 ? p : 1.0;
}

/* Move a partner in contact, which sticks or slips; returns its force, and adds the energy lost. */
static inline double @_pull_of_(const @_pull_ *pull, @_spring *s, double *lost)
{
    const double trial = @_shear_force_(s, pull->change, pull->duration), over = fabs(trial) - pull->high;
    const double sign = trial > 0.0 ? 1.0 : -1.0;
    double under, stuck = 0.0, left, lasted, stiffness = @@_EQUILIBRIUM_MODULUS, dv, given;
    int j;
    if (over <= 0.0) {
        @_shear_move_(s, pull->change, pull->duration, lost);
        return trial;
    }
    under = sign * @_shear_force_(s, 0.0, 0.0) - pull->low;
    if (under < -1e-10 * (over - under)) /* at its limit it slips at once, whatever the rounding */
        stuck = @_sticks_(pull, s, sign);
    if (stuck <= 1e-10)
        stuck = 0.0;
    if (stuck > 0.0)
        @_shear_move_(s, pull->change * stuck, pull->duration * stuck, lost);
    left = 1.0 - stuck;
    lasted = pull->duration * left;
    for (j = 0; j < @@_BRANCHES; ++j)
        stiffness += @_branches_[j][0] * @_mean_(lasted / @_branches_[j][1]);
    /* from the force: a long shift minus a long slip would lose its digits */
    dv = (sign * pull->high - @_shear_force_(s, 0.0, lasted)) / stiffness;
    given = pull->change * left * sign * 0.5 * (pull->low + (pull->high - pull->low) * stuck + pull->high);
    *lost += given - dv * @_shear_move_(s, dv, lasted, lost);
    return sign * pull->high;
}

/* A part of a step: press all springs, then pull their partners. */
static inline void @_shear_part_(@_state *s, double d, double du, double duration)
{
    double turned[@@_SPRINGS], before[@@_SPRINGS], force = 0.0, normal = 0.0, area;
    int touched[@@_SPRINGS], i, j, last = -1;
    for (i = 0; i < @@_SPRINGS; ++i) {
        const @_spring *spring = &s->pressed.spring[i];
        turned[i] = 0.0;
        touched[i] = spring->touches != 0.0;
        before[i] = touched[i] ? @_stress_(spring, 0.0) : 0.0;
    }
    @_press_(&s->pressed, d, duration, turned);
    for (i = 0; i < (int)s->pressed.active; ++i)
        if (s->pressed.spring[i].touches != 0.0)
            last = i;
    area = @_stiffness(s->pressed.edge < @@_LARGEST_INDENTATION ? s->pressed.edge : @@_LARGEST_INDENTATION) / @@_GLASSY_MODULUS;
    s->stored_tangential_energy = 0.0;
    for (i = 0; i < (int)s->pressed.active; ++i) {
        @_spring *partner = &s->partner[i];
        const int touches = s->pressed.spring[i].touches != 0.0;
        const double dk = @_springs_[i][1], load = touches ? @_stress_(&s->pressed.spring[i], 0.0) : 0.0;
        double begin = 0.0, end = 1.0, lost = 0.0, stored = 0.0, q = 0.0;
        @_pull_ pull;
        pull.low = @@_FRICTION * (before[i] > 0.0 ? before[i] : 0.0);
        pull.high = @@_FRICTION * (load > 0.0 ? load : 0.0);
        if (touched[i] && !touches)
            end = turned[i];
        else if (!touched[i])
            begin = touches ? turned[i] : 1.0;
        if (partner->touches == 0.0 && begin > 0.0)
            lost += @_creep_(partner, duration * begin);
        if (begin < 1.0) {
            if (partner->touches == 0.0)
                @_touch_(partner);
            pull.change = du * (end - begin);
            pull.duration = duration * (end - begin);
            q = @_pull_of_(&pull, partner, &lost);
            if (!touches) { /* what it bears is released at once */
                const double borne = @_shear_force_(partner, 0.0, 0.0);
                double glassy = @@_EQUILIBRIUM_MODULUS;
                for (j = 0; j < @@_BRANCHES; ++j)
                    glassy += @_branches_[j][0];
                lost += 0.5 * borne * borne / glassy;
                @_release_(partner);
                lost += @_creep_(partner, duration * (1.0 - end));
            }
        }
        if (partner->touches == 0.0) {
            for (j = 0; j < @@_MODES; ++j)
                stored += partner->h[j] * partner->h[j];
        } else {
            double carried = dk;
            if (i == last) {
                carried = area - (i > 0 ? @_springs_[i - 1][3] : 0.0);
                carried = carried > 0.0 ? carried : 0.0;
            }
            force += carried * q;
            normal += carried * pull.high;
            for (j = 0; j < @@_BRANCHES; ++j)
                stored += partner->h[j] * partner->h[j] * @_branches_[j][2];
            stored += @@_EQUILIBRIUM_MODULUS * partner->deflection * partner->deflection;
        }
        s->shear_dissipation += dk * lost;
        s->stored_tangential_energy += 0.5 * dk * stored;
    }
    /* full slip gives exactly mu F_N */
    s->tangential_force = normal > 0.0 ? force * (@@_FRICTION * s->pressed.normal_force / normal) : 0.0;
}

static inline int @_advance(@_state *s, double d, double u, double duration)
{
    const double from = s->pressed.indentation, du = u - s->shift, ratio = duration / (@@_PARTS * @@_SHORTEST_TIME);
    double end, last = 0.0;
    int part, first;
    if (!(d <= @@_LARGEST_INDENTATION) || d < -1e60 || !(fabs(u) <= 1e60) || !(duration >= 0.0 && duration <= 1e60))
        return 1;
    first = ratio > 0.0 ? (int)ceil(2.0 * log10(1.0 + ratio)) : 1; /* parts of the first of equal parts, in which loads relax */
    first = first > 1 ? first : 1;
    for (part = 1; part < first + @@_PARTS; ++part) {
        end = (part < first ? expm1(log1p(ratio) * part / first) / ratio : part - first + 1.0) / @@_PARTS;
        @_shear_part_(s, end < 1.0 ? from + (d - from) * end : d, du * (end - last), duration * (end - last));
        last = end;
    }
    s->shift = u;
    s->normal_force = s->pressed.normal_force;
    s->elastic_energy = s->pressed.elastic_energy;
    s->dissipated_energy = s->pressed.dissipated_energy + s->shear_dissipation;
    return 0;
}
"""
