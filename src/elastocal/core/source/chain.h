/* A group of configurations: where the chain is, the rows of the linear model, and what a
 * gradient in these is in the design variables. Lanes are configurations.
 *
 * Source: paper eqs. (2) to (4), (7); in reverse by one sum along the chain, as
 * elastic/regressor.py has it.
 */
#ifndef ELASTOCAL_CHAIN_H
#define ELASTOCAL_CHAIN_H

#include "lanes.h"
#include "space.h"

/* A force on a body and its moment about the origin of the base. */
typedef struct {
    vector force, moment;
} wrench;

/* The nearest of some pairs: distance, which pair, both points, direction that parts them. */
typedef struct {
    lanes distance;
    lanes pair; /* number, -1 where all are beyond the horizon */
    vector first, second, normal;
} Nearest;

/* What errs in load cases: errors.h. Rows are R = 3 targets numbers. */
typedef struct {
    lanes repeats;     /* that share each load case */
    vector *total;     /* (targets) deflection [m, rad] */
    vector *turned;    /* (3, targets) the same of loads turned by one about x, y, z */
    lanes *exerted;    /* (3, c) their generalised forces */
    vector *rubbed;    /* (c, targets) what friction leaves, in units of the noise, like the rest */
    vector *gained;    /* (targets) by the size of the load */
    vector *tilted;    /* (3, targets) by its direction */
    vector *back;      /* (3, markers) by where the robot comes back to */
    vector *wide;      /* (targets, 3) by what nothing explains */
    lanes root[2];     /* deviation of that at a marker, of the rotation */
    lanes *column;     /* (R) */
    lanes *factor;     /* (R, R) L of the covariance L Lᵀ of all, 1 over its diagonal in place */
} Erring;

/* One group of LANES load cases. */
typedef struct {
    lanes *x;          /* (d) design variables */
    frame *bodies;     /* (moving + 2) base, bodies, flange */
    vector *axes;      /* (T) twists in the base frame */
    vector *origins;   /* (T) */
    vector *at;        /* (points) */
    vector *pointing;  /* (directions) */
    vector *velocity;  /* (points, c) */
    vector *turn;      /* (c) */
    lanes *exerted;    /* (c) generalised force y */
    vector force, moment;
    vector *rows;      /* (markers [+ 1], p) in units of the noise */
    vector *beam;      /* (markers) unit vectors from the tracker */
    lanes *range;      /* (markers) */
    lanes *margins;    /* (C + cones) */
    vector *ends;      /* (solids, 2) */
    Erring erring;     /* if load cases err */
    Nearest *nearest;  /* (C) of margins that are distances */
    int64_t *hints;    /* per pair twice, the face that parted it last, plus 1; then (C) pairs */
} Place;

INLINE int64_t targets(const Space *s) { return s->markers + (s->noise.rotation > 0.0); }
INLINE int64_t rows_of(const Space *s) { return 3 * targets(s); }
INLINE int64_t margins_of(const Space *s) { return s->margins + s->force.cone + s->moment.cone; }

/* Numbers of pairs of all margins. */
INLINE int64_t pairs_of(const Space *s) {
    int64_t pairs = 0;
    for (int64_t c = 0; c < s->margins; c++) pairs += s->margin[c].count;
    return pairs;
}
INLINE int64_t hints_of(const Space *s) {
    return s->solids ? (2 * pairs_of(s) + s->margins) / LANES + 1 : 0;
}

/* Whether loads are turned. */
INLINE int turning(const Space *s) { return s->errors.tilt > 0.0 || s->errors.turning > 0.0; }

static int64_t erring_size(const Space *s) {
    const int64_t t = targets(s), r = rows_of(s);
    return s->errors.any ? 3 * t * (1 + 3 + s->springs + 1 + 3 + 3) + 9 * s->markers +
                               3 * s->springs + r + r * r
                         : 0;
}

static Erring erring_in(const Space *s, lanes *memory) {
    const int64_t t = targets(s);
    Erring e = {0};
    if (!s->errors.any) return e;
    e.total = (vector *)memory, memory += 3 * t;
    e.turned = (vector *)memory, memory += 9 * t;
    e.rubbed = (vector *)memory, memory += 3 * s->springs * t;
    e.gained = (vector *)memory, memory += 3 * t;
    e.tilted = (vector *)memory, memory += 9 * t;
    e.wide = (vector *)memory, memory += 9 * t;
    e.back = (vector *)memory, memory += 9 * s->markers;
    e.exerted = memory, memory += 3 * s->springs;
    e.column = memory, memory += rows_of(s);
    e.factor = memory;
    e.repeats = every(s->errors.together);
    return e;
}

/* Memory, in lanes, and its division. */
static int64_t place_size(const Space *s) {
    return s->variables + 12 * (s->moving + 2) + 6 * s->twists + 3 * s->points +
           3 * s->directions + 3 * s->points * s->springs + 4 * s->springs +
           3 * targets(s) * s->unknowns + 4 * s->markers + margins_of(s) + 6 * s->solids +
           11 * s->margins + erring_size(s) + hints_of(s);
}

static Place place_in(const Space *s, lanes *memory) {
    Place p = {0};
    p.x = memory, memory += s->variables;
    p.bodies = (frame *)memory, memory += 12 * (s->moving + 2);
    p.axes = (vector *)memory, memory += 3 * s->twists;
    p.origins = (vector *)memory, memory += 3 * s->twists;
    p.at = (vector *)memory, memory += 3 * s->points;
    p.pointing = (vector *)memory, memory += 3 * s->directions;
    p.velocity = (vector *)memory, memory += 3 * s->points * s->springs;
    p.turn = (vector *)memory, memory += 3 * s->springs;
    p.exerted = memory, memory += s->springs;
    p.rows = (vector *)memory, memory += 3 * targets(s) * s->unknowns;
    p.beam = (vector *)memory, memory += 3 * s->markers;
    p.range = memory, memory += s->markers;
    p.margins = memory, memory += margins_of(s);
    p.ends = (vector *)memory, memory += 6 * s->solids;
    p.nearest = (Nearest *)memory, memory += 11 * s->margins;
    p.erring = erring_in(s, memory), memory += erring_size(s);
    p.hints = (int64_t *)memory;
    memset(p.hints, 0, (size_t)hints_of(s) * sizeof(lanes));
    return p;
}

/* The frame fixed to another one by a transform (4, 4). */
INLINE frame attached(const double *t, const frame *f) {
    const double x[] = {t[0], t[4], t[8]}, y[] = {t[1], t[5], t[9]};
    const double z[] = {t[2], t[6], t[10]}, o[] = {t[3], t[7], t[11]};
    return (frame){turned(f, x), turned(f, y), turned(f, z), carried_to(f, o)};
}

/* Force or moment of its design variables. */
INLINE vector loaded(const Load *load, const lanes *x) {
    if (load->kind == FIXED) return constant(load->axis);
    if (load->kind == SHARE)
        return times(pick(x[0] > 0.5, every(1.0), every(0.0)), constant(load->axis));
    if (load->kind == DIRECTION) {
        vector v = {x[0], x[1], x[2]};
        return times(load->size / root(dot(v, v)), v);
    }
    lanes scale = load->size / root(x[0] * x[0] + x[1] * x[1]);
    return times(scale, plus(times(x[0], constant(load->basis)),
                             times(x[1], constant(load->basis + 3))));
}

INLINE int64_t variables_of(const Load *load) {
    return load->kind == FIXED ? 0 : load->kind == DIRECTION ? 3 : load->kind == PLANE ? 2 : 1;
}

/* Gradient in the design variables of a gradient in force or moment. */
INLINE void pull_load(const Load *load, const lanes *x, vector bar, lanes *gradient) {
    if (load->kind == DIRECTION) { /* a SHARE is not moved */
        vector v = {x[0], x[1], x[2]};
        lanes norm = root(dot(v, v));
        vector unit = times(1.0 / norm, v);
        vector across = minus(bar, times(dot(unit, bar), unit));
        across = times(load->size / norm, across);
        gradient[0] += across.x, gradient[1] += across.y, gradient[2] += across.z;
    } else if (load->kind == PLANE) {
        lanes a = dot(constant(load->basis), bar), b = dot(constant(load->basis + 3), bar);
        lanes norm = root(x[0] * x[0] + x[1] * x[1]), u = x[0] / norm, v = x[1] / norm;
        lanes along = u * a + v * b;
        gradient[0] += load->size / norm * (a - along * u);
        gradient[1] += load->size / norm * (b - along * v);
    }
}

/* Where the bodies are. */
static void place_bodies(const Space *s, Place *p) {
    const frame base = {{every(1.0), every(0.0), every(0.0)},
                        {every(0.0), every(1.0), every(0.0)},
                        {every(0.0), every(0.0), every(1.0)},
                        {every(0.0), every(0.0), every(0.0)}};
    p->bodies[0] = base;
    for (int64_t i = 0; i < s->moving; i++) {
        lanes value = p->x[i < s->joints ? i : 0];
        if (s->mixing) {
            value = every(s->standing[i]);
            for (int64_t j = 0; j < s->joints; j++) {
                double way = s->mixing[i * s->joints + j];
                if (way != 0.0) value += way * p->x[j];
            }
        }
        frame f = attached(s->links + 16 * i, &p->bodies[s->carriers[i + 1]]);
        if (s->sliding[i]) {
            f.o = plus(f.o, times(value, f.z));
        } else {
            lanes sine, cosine;
            sine_cosine(value, &sine, &cosine);
            vector x = f.x;
            f.x = plus(times(cosine, x), times(sine, f.y));
            f.y = minus(times(cosine, f.y), times(sine, x));
        }
        p->bodies[i + 1] = f;
    }
    const frame *tip = &p->bodies[s->last];
    frame *flange = &p->bodies[s->moving + 1];
    *flange = attached(s->links + 16 * s->moving, tip);
    for (int64_t i = 0; i < s->points; i++) p->at[i] = carried_to(flange, s->locals + 3 * i);
    for (int64_t i = 0; i < s->directions; i++)
        p->pointing[i] = turned(flange, s->pointing + 3 * i);
}

/* Velocity that unit speed of a twist gives to a point. */
INLINE vector velocity_of(const Space *s, const Place *p, int64_t t, vector at) {
    return s->slides[t] ? p->axes[t] : cross(p->axes[t], minus(at, p->origins[t]));
}

/* W v: a vector at a marker in units of its noise; W is symmetric. */
INLINE vector whitened(const Space *s, const Place *p, int64_t marker, vector v) {
    const Noise *n = &s->noise;
    if (n->kind == ISOTROPIC) return times(every(1.0 / n->deviation), v);
    lanes range = p->range[marker];
    lanes a = 0.70710678118654752 / (n->across + n->across_per_metre * range);
    lanes b = 0.70710678118654752 / (n->along + n->along_per_metre * range);
    vector u = p->beam[marker];
    return plus(times(a, v), times((b - a) * dot(u, v), u));
}

/* The row of a spring at a target, given to what makes the spring. */
INLINE void give_row(const Space *s, Place *p, int64_t target, int64_t spring, vector row) {
    vector *to = p->rows + target * s->unknowns;
    if (!s->making) {
        to[spring] = row;
        return;
    }
    for (int64_t i = s->making[spring]; i < s->making[spring + 1]; i++)
        to[s->maker[i]] = plus(to[s->maker[i]], times(every(s->made[i]), row));
}

/* The gradient in the row of a spring, of those in the rows of what makes it. */
INLINE vector taken_row(const Space *s, const vector *bars, int64_t target, int64_t spring) {
    const vector *from = bars + target * s->unknowns;
    if (!s->making) return from[spring];
    vector bar = {every(0.0), every(0.0), every(0.0)};
    for (int64_t i = s->making[spring]; i < s->making[spring + 1]; i++)
        bar = plus(bar, times(every(s->made[i]), from[s->maker[i]]));
    return bar;
}

/* How a tracker's noise changes with the place of a marker: its gradient there. `row` is in units
 * of the noise already. */
INLINE vector pull_whitened(const Space *s, const Place *p, int64_t marker, vector plain,
                            vector bar) {
    const Noise *n = &s->noise;
    lanes range = p->range[marker];
    lanes across = n->across + n->across_per_metre * range;
    lanes along = n->along + n->along_per_metre * range;
    lanes a = 0.70710678118654752 / across, b = 0.70710678118654752 / along;
    vector u = p->beam[marker];
    lanes row_along = dot(u, plain), bar_along = dot(u, bar);
    lanes lengthwise = row_along * bar_along, crosswise = dot(plain, bar) - lengthwise;
    vector turn = plus(times(row_along, bar), times(bar_along, plain));
    turn = times((b - a) / range, turn);
    turn = minus(turn, times(dot(u, turn), u));
    lanes slope = -crosswise * a * n->across_per_metre / across;
    slope -= lengthwise * b * n->along_per_metre / along;
    return plus(turn, times(slope, u));
}

#include "errors.h"

INLINE void push(wrench *w, vector at, vector force) {
    w->force = plus(w->force, force);
    w->moment = plus(w->moment, cross(at, force));
}


/* Whether a spring moves a marker. */
INLINE int moves(const Space *s, int64_t spring, int64_t marker) {
    return s->only[spring] < 0 || s->only[spring] == marker;
}

/* How far a twist goes for a unit of a spring. */
INLINE double share_of(const Space *s, int64_t t, int64_t spring) {
    return s->share ? s->share[t * s->springs + spring] : (double)(t == spring);
}

/* What weights exert on the springs: those that a spring carries. */
static void weigh(const Space *s, Place *p) {
    for (int64_t w = 0; w < s->weights; w++) {
        const int64_t body = s->heavy[w];
        const vector at = carried_to(&p->bodies[body], s->centers + 3 * w);
        const vector force = constant(s->pulls + 3 * w);
        for (int64_t t = 0; t < s->twists && s->body[t] < body; t++) {
            lanes pulled = dot(velocity_of(s, p, t, at), force);
            for (int64_t u = s->share ? 0 : t; u < (s->share ? s->springs : t + 1); u++)
                p->exerted[u] += share_of(s, t, u) * pulled;
        }
    }
}

/* Adds to `on` what a gradient in what weights exert on a spring pushes bodies with. */
static void pull_weights(const Space *s, const Place *p, int64_t spring, lanes bar, wrench *on) {
    for (int64_t t = 0; t < s->twists; t++) {
        const double share = share_of(s, t, spring);
        if (share == 0.0) continue;
        const int64_t own = s->joint[t] >= 0 ? s->joint[t] + 1 : s->body[t];
        for (int64_t w = 0; w < s->weights; w++) {
            const int64_t body = s->heavy[w];
            if (s->body[t] >= body) continue;
            const vector force = times(share * bar, constant(s->pulls + 3 * w));
            vector axis_bar = force;
            if (!s->slides[t]) {
                const vector at = carried_to(&p->bodies[body], s->centers + 3 * w);
                const vector arm = minus(at, p->origins[t]), arm_bar = cross(force, p->axes[t]);
                push(&on[body > s->moving ? s->last : body], at, arm_bar);
                push(&on[own], p->origins[t], times(every(-1.0), arm_bar));
                axis_bar = cross(arm, force);
            }
            on[own].moment = plus(on[own].moment, cross(p->axes[t], axis_bar));
        }
    }
}

/* Rows of the linear model in units of the noise. */
static void place_rows(const Space *s, Place *p) {
    const int64_t n = s->joints, springs = s->springs;
    p->force = loaded(&s->force, p->x + n);
    p->moment = loaded(&s->moment, p->x + n + variables_of(&s->force));
    for (int64_t t = 0; t < s->twists; t++) {
        int64_t j = s->joint[t];
        const frame *f = &p->bodies[j >= 0 ? j + 1 : s->body[t]];
        p->axes[t] = j >= 0 ? f->z : turned(f, s->axes + 3 * t);
        p->origins[t] = j >= 0 ? f->o : carried_to(f, s->origins + 3 * t);
    }
    const vector zero = {every(0.0), every(0.0), every(0.0)};
    for (int64_t u = 0; s->share && u < springs * s->points; u++) p->velocity[u] = zero;
    for (int64_t u = 0; s->share && u < springs; u++) p->turn[u] = zero;
    for (int64_t t = 0; t < s->twists; t++) {
        vector turn = s->slides[t] ? zero : p->axes[t];
        if (!s->share) p->turn[t] = turn;
        for (int64_t u = 0; s->share && u < springs; u++)
            p->turn[u] = plus(p->turn[u], times(every(s->share[t * springs + u]), turn));
        for (int64_t i = 0; i < s->points; i++) {
            vector v = velocity_of(s, p, t, p->at[i]), *to = p->velocity + i * springs;
            if (!s->share) to[t] = v;
            for (int64_t u = 0; s->share && u < springs; u++)
                to[u] = plus(to[u], times(every(s->share[t * springs + u]), v));
        }
    }
    for (int64_t u = 0; u < springs; u++) {
        p->exerted[u] = dot(p->velocity[u], p->force);
        if (!s->moment.zero) p->exerted[u] += dot(p->turn[u], p->moment);
    }
    if (s->weights) weigh(s, p);
    for (int64_t u = 0; u < springs; u++)
        if (s->stiff[u]) p->exerted[u] = every(1.0);
    for (int64_t u = 0; s->making && u < targets(s) * s->unknowns; u++) p->rows[u] = zero;
    for (int64_t m = 0; m < s->markers; m++) {
        int64_t i = s->marker[m];
        if (s->noise.kind == TRACKER) {
            vector beam = minus(p->at[i], constant(s->noise.position));
            p->range[m] = larger(root(dot(beam, beam)), every(1e-9));
            p->beam[m] = times(1.0 / p->range[m], beam);
        }
        for (int64_t u = 0; u < springs; u++) {
            if (!moves(s, u, m)) {
                give_row(s, p, m, u, zero);
                continue;
            }
            vector row = times(p->exerted[u], p->velocity[i * springs + u]);
            give_row(s, p, m, u, whitened(s, p, m, row));
        }
    }
    if (s->noise.rotation > 0.0)
        for (int64_t u = 0; u < springs; u++)
            give_row(s, p, s->markers, u, times(p->exerted[u] / s->noise.rotation, p->turn[u]));
    if (s->errors.any) absorb(s, p);
}

/* Sums over the twists before one: what they push a point with, the moment of that about the base,
 * and what turns them. */
typedef struct {
    vector force, moment, bent;
} Sums;

/* Memory of `pull`, in lanes, besides the wrenches. */
static int64_t pull_size(const Space *s) {
    return 9 * (s->twists + 1) + s->moving + erring_pull_size(s) +
           (s->share ? 3 * (s->points + 1) * s->springs : 0) + 3 * s->points;
}

/* The next sums, with a twist of which the gradients in the velocities it gives to the points are
 * `point_bar`, and that in its axis by which it turns the flange `turn_bar`. */
INLINE Sums summed(const Space *s, const Place *p, int64_t t, const vector *point_bar,
                   vector turn_bar, const Sums *before) {
    const vector axis = p->axes[t], origin = p->origins[t];
    const vector zero = {every(0.0), every(0.0), every(0.0)};
    vector axis_bar = zero, pushed = zero, turns = zero;
    if (s->slides[t]) {
        for (int64_t i = 0; i < s->points; i++) axis_bar = plus(axis_bar, point_bar[i]);
        turns = cross(axis, axis_bar);
    } else {
        axis_bar = turn_bar;
        for (int64_t i = 0; i < s->points; i++) {
            vector arm = minus(p->at[i], origin), arm_bar = cross(point_bar[i], axis);
            axis_bar = plus(axis_bar, cross(arm, point_bar[i]));
            turns = plus(turns, cross(arm, arm_bar));
            pushed = plus(pushed, arm_bar);
        }
    }
    Sums after;
    after.force = plus(before->force, pushed);
    after.moment = before->moment;
    if (!s->slides[t]) {
        after.moment = plus(after.moment, plus(turns, cross(origin, pushed)));
        turns = plus(turns, cross(axis, axis_bar));
    }
    after.bent = plus(before->bent, turns);
    return after;
}

/* Adds the gradient in the design variables to `gradient` (d).
 *
 * bars: (targets, p) gradient in the rows in units of the noise, or 0.
 * on: (moving + 2) gradients in points of the bodies, as wrenches on them; changed.
 * memory: pull_size() lanes.
 */
static void pull(const Space *s, const Place *p, const vector *bars, wrench *on, lanes *memory,
                 lanes *gradient) {
    const int64_t springs = s->springs, n = s->joints;
    const vector zero = {every(0.0), every(0.0), every(0.0)};
    Sums *sums = (Sums *)memory; /* (T + 1) */
    lanes *along = memory + 9 * (s->twists + 1);
    vector *point_bar = (vector *)(along + s->moving); /* of one spring, or of one twist */
    vector *velocity_bar = point_bar + s->points;      /* (points + 1, c) if twists share them */
    lanes *rest = (lanes *)(velocity_bar + (s->share ? (s->points + 1) * springs : 0));
    if (bars) {
        ErringBars erring = {0};
        if (s->errors.any) {
            erring = pull_absorbed(s, p, bars, on, rest);
            bars = erring.rows;
        }
        const int tracking = s->noise.kind == TRACKER;
        const lanes scale = every(1.0 / s->noise.deviation);
        vector force_bar = zero, moment_bar = zero;
        sums[0] = (Sums){zero, zero, zero};
        for (int64_t u = 0; u < springs; u++) {
            const lanes exerted = p->exerted[u];
            lanes bar = every(0.0);
            vector turn_bar = zero;
            for (int64_t i = 0; i < s->points; i++) point_bar[i] = zero;
            for (int64_t m = 0; m < s->markers; m++) {
                if (!moves(s, u, m)) continue;
                vector velocity = p->velocity[s->marker[m] * springs + u];
                vector given = taken_row(s, bars, m, u), plain;
                if (s->errors.any) given = plus(given, erring_row(s, &erring, m, u));
                if (tracking) {
                    plain = whitened(s, p, m, given);
                    vector moved = pull_whitened(s, p, m, times(exerted, velocity), given);
                    push(&on[s->last], p->at[s->marker[m]], moved);
                } else {
                    plain = times(scale, given);
                }
                if (s->errors.any) plain = plus(plain, erring_plain(s, &erring, m, u));
                bar += dot(velocity, plain);
                vector *to = &point_bar[s->marker[m]];
                *to = plus(*to, times(exerted, plain));
            }
            if (s->noise.rotation > 0.0) {
                vector given = taken_row(s, bars, s->markers, u);
                if (s->errors.any) given = plus(given, erring_row(s, &erring, s->markers, u));
                given = times(every(1.0 / s->noise.rotation), given);
                if (s->errors.any) given = plus(given, erring_plain(s, &erring, s->markers, u));
                bar += dot(p->turn[u], given);
                turn_bar = times(exerted, given);
            }
            if (s->stiff[u]) bar = every(0.0);
            if (s->weights && !s->stiff[u]) pull_weights(s, p, u, bar, on);
            if (!s->moment.zero) turn_bar = plus(turn_bar, times(bar, p->moment));
            point_bar[0] = plus(point_bar[0], times(bar, p->force));
            force_bar = plus(force_bar, times(bar, p->velocity[u]));
            moment_bar = plus(moment_bar, times(bar, p->turn[u]));
            if (turning(s))
                pull_turned(s, p, &erring, u, point_bar, &turn_bar, &force_bar, &moment_bar);
            if (!s->share) {
                sums[u + 1] = summed(s, p, u, point_bar, turn_bar, &sums[u]);
                continue;
            }
            velocity_bar[u] = turn_bar;
            for (int64_t i = 0; i < s->points; i++)
                velocity_bar[(i + 1) * springs + u] = point_bar[i];
        }
        pull_load(&s->force, p->x + n, force_bar, gradient + n);
        int64_t k = n + variables_of(&s->force);
        pull_load(&s->moment, p->x + k, moment_bar, gradient + k);
        for (int64_t t = 0; s->share && t < s->twists; t++) {
            vector turn_bar = zero;
            for (int64_t i = 0; i < s->points; i++) point_bar[i] = zero;
            for (int64_t u = 0; u < springs; u++) {
                const lanes way = every(s->share[t * springs + u]);
                turn_bar = plus(turn_bar, times(way, velocity_bar[u]));
                for (int64_t i = 0; i < s->points; i++)
                    point_bar[i] = plus(point_bar[i],
                                        times(way, velocity_bar[(i + 1) * springs + u]));
            }
            sums[t + 1] = summed(s, p, t, point_bar, turn_bar, &sums[t]);
        }
    }
    for (int64_t j = s->moving - 1; j >= 0; j--) {
        const frame *f = &p->bodies[j + 1];
        wrench w = on[j + 1];
        wrench *carrier = &on[s->carriers[j + 1]];
        carrier->force = plus(carrier->force, w.force);
        carrier->moment = plus(carrier->moment, w.moment);
        if (bars && j < s->last) {
            int64_t k = s->carried[j];
            w.force = plus(w.force, sums[k].force);
            w.moment = plus(w.moment, sums[k].moment);
            w.moment = plus(w.moment, minus(sums[s->twists].bent, sums[k].bent));
        }
        along[j] = s->sliding[j] ? dot(f->z, w.force)
                                 : dot(f->z, minus(w.moment, cross(f->o, w.force)));
    }
    if (!s->mixing) {
        for (int64_t j = 0; j < n; j++) gradient[j] += along[j];
        return;
    }
    for (int64_t j = 0; j < n; j++)
        for (int64_t i = 0; i < s->moving; i++) {
            double way = s->mixing[i * n + j];
            if (way != 0.0) gradient[j] += way * along[i];
        }
}

#endif
