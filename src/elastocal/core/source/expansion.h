/* The sensitivity about the centre of a box: values, first and second derivatives.
 *
 * A statement of `proof/` as plain numbers: joints by the product of exponentials, springs with
 * their rows of V, markers, loads, constraints. All derivatives here are exact, by the rules
 *     D_i v = a_i x v for a joint i before the spring,   D_i v = s x D_i P for one behind it,
 * the earlier joint always outermost. Source: ours; docs/math.md.
 */
#ifndef ELASTOCAL_EXPANSION_H
#define ELASTOCAL_EXPANSION_H

#include "lanes.h"

#define MOST_JOINTS 12
#define MOST_FORMS 3
#define PAIRS (MOST_JOINTS * (MOST_JOINTS + 1) / 2)

enum { PLANE_BOUND, DIRECTION_BOUND, DISTANCE_BOUND };

/* A constraint g(x) >= 0. */
typedef struct {
    int64_t kind;
    double point[3];   /* or a direction; all joints at zero */
    double normal[3];  /* or a centre */
    double weights[3]; /* of squared coordinates */
    double sign;
    double offset;       /* what is taken off */
    const double *third; /* (n, n, n) least upper bounds of |D_ijk g| */
} Condition;

/* What is to be bounded, and where. */
typedef struct {
    int64_t joints;
    const double *axes, *points; /* (n, 3) all joints at zero */
    const int64_t *slides;       /* (n) */
    const double *links;         /* (n) q_i = x_i - links_i x_{i-1} + starts_i; links_0 is 0 */
    const double *starts;        /* (n) */
    const double *least, *most;  /* (n) limits of q_i, infinite where the box has them */
    int64_t springs;
    const int64_t *bodies; /* (s) joints 0 … body - 1 move it; in order */
    const int64_t *slide;  /* (s) */
    const double *spring_axes, *spring_points; /* (s, 3) */
    const double *values;                      /* (s, r) rows of V in units of the noise */
    int64_t rank;
    int64_t markers;
    const double *marker; /* (k, 3) */
    double turning;       /* weight of the rotation that is read; 0: none is */
    double load_point[3];
    int64_t loaded; /* which marker it is; -1: none */
    int64_t forms;          /* 1: fixed load; 2, 3: the largest over unit vectors */
    const double *forces;   /* (forms, 3) */
    const double *moments;  /* (forms, 3) */
    int64_t twisting;       /* whether there are moments */
    int64_t cone;           /* whether the unit vectors are within a cone */
    double cone_axis[3], cone_cosine;
    int64_t conditions;
    const Condition *condition;
    const double *third;         /* (n, n, n) least upper bounds of |D_ijk B| */
    const double *lower, *upper; /* (n) of the root box */
} Statement;

/* Number of a pair i <= j. */
INLINE int64_t pair_of(int64_t i, int64_t j) { return j * (j + 1) / 2 + i; }

INLINE vector about(vector a, lanes s, lanes c, vector v) {
    return plus(plus(times(c, v), times(s, cross(a, v))), times((1.0 - c) * dot(a, v), a));
}

INLINE vector none(void) { return (vector){every(0.0), every(0.0), every(0.0)}; }

/* A point of the last body, or a direction, with its derivatives. */
typedef struct {
    vector at, first[MOST_JOINTS], second[PAIRS];
} moved;

/* The chain at LANES configurations. */
typedef struct {
    lanes q[MOST_JOINTS];
    vector axis[MOST_JOINTS], origin[MOST_JOINTS];
    frame last;
} Arm;

INLINE int64_t terms_of(const Statement *s) {
    return 1 + s->joints + s->joints * (s->joints + 1) / 2;
}
INLINE int64_t targets_of(const Statement *s) { return s->markers + (s->turning > 0.0); }
INLINE int64_t row_vectors(const Statement *s) { return s->forms * targets_of(s) * s->rank; }

/* Places the arm; the axis and the origin of every spring go to `axes`, `origins`. */
static void place_arm(const Statement *s, const lanes *x, Arm *arm, vector *axes, vector *origins) {
    frame f = {none(), none(), none(), none()};
    f.x.x = f.y.y = f.z.z = every(1.0);
    int64_t spring = 0;
    for (int64_t i = 0; i <= s->joints; i++) {
        for (; spring < s->springs && s->bodies[spring] == i; spring++) {
            axes[spring] = turned(&f, s->spring_axes + 3 * spring);
            origins[spring] = carried_to(&f, s->spring_points + 3 * spring);
        }
        if (i == s->joints) break;
        lanes q = x[i] + s->starts[i];
        if (s->links[i] != 0.0) q -= s->links[i] * x[i - 1];
        arm->q[i] = q;
        vector a = turned(&f, s->axes + 3 * i), o = carried_to(&f, s->points + 3 * i);
        arm->axis[i] = a, arm->origin[i] = o;
        if (s->slides[i]) {
            f.o = plus(f.o, times(q, a));
        } else {
            lanes sine = every(0.0), cosine = sine;
            sine_cosine(q, &sine, &cosine);
            f.x = about(a, sine, cosine, f.x);
            f.y = about(a, sine, cosine, f.y);
            f.z = about(a, sine, cosine, f.z);
            f.o = minus(o, turned(&f, s->points + 3 * i));
        }
    }
    arm->last = f;
}

static void point_moved(const Statement *s, const Arm *arm, const double *point, moved *m) {
    m->at = carried_to(&arm->last, point);
    for (int64_t j = 0; j < s->joints; j++) {
        m->first[j] = s->slides[j] ? arm->axis[j]
                                   : cross(arm->axis[j], minus(m->at, arm->origin[j]));
        for (int64_t i = 0; i <= j; i++)
            m->second[pair_of(i, j)] = s->slides[i] ? none() : cross(arm->axis[i], m->first[j]);
    }
}

static void direction_moved(const Statement *s, const Arm *arm, const double *axis, moved *m) {
    m->at = turned(&arm->last, axis);
    for (int64_t j = 0; j < s->joints; j++) {
        m->first[j] = s->slides[j] ? none() : cross(arm->axis[j], m->at);
        for (int64_t i = 0; i <= j; i++)
            m->second[pair_of(i, j)] = s->slides[i] ? none() : cross(arm->axis[i], m->first[j]);
    }
}

/* The way of a point for a spring with this axis and origin on `body`, with its derivatives. */
static inline void way_moved(const Statement *s, const Arm *arm, int64_t body, int64_t slides,
                             vector axis, vector origin, const moved *point, moved *way) {
    way->at = slides ? axis : cross(axis, minus(point->at, origin));
    for (int64_t j = 0; j < s->joints; j++) {
        if (j < body)
            way->first[j] = s->slides[j] ? none() : cross(arm->axis[j], way->at);
        else
            way->first[j] = slides ? none() : cross(axis, point->first[j]);
        for (int64_t i = 0; i <= j; i++) {
            vector *to = &way->second[pair_of(i, j)];
            if (i < body)
                *to = s->slides[i] ? none() : cross(arm->axis[i], way->first[j]);
            else
                *to = slides ? none() : cross(axis, point->second[pair_of(i, j)]);
        }
    }
}

/* The axis of a spring, with its derivatives. */
static inline void axis_moved(const Statement *s, const Arm *arm, int64_t body, vector axis,
                              moved *way) {
    way->at = axis;
    for (int64_t j = 0; j < s->joints; j++) {
        way->first[j] = j < body && !s->slides[j] ? cross(arm->axis[j], axis) : none();
        for (int64_t i = 0; i <= j; i++)
            way->second[pair_of(i, j)] =
                i < body && !s->slides[i] ? cross(arm->axis[i], way->first[j]) : none();
    }
}

/* From derivatives by the joints to derivatives by x, `width` numbers each, in place. */
static inline void by_coordinates(const Statement *s, lanes *first, lanes *second, int64_t width) {
    const int64_t n = s->joints;
    for (int64_t i = 0; i + 1 < n; i++) {
        if (s->links[i + 1] == 0.0) continue;
        for (int64_t k = 0; k < width; k++)
            first[i * width + k] -= s->links[i + 1] * first[(i + 1) * width + k];
    }
    for (int64_t i = 0; i < n; i++)
        for (int64_t j = i; j < n; j++) {
            const double a = i + 1 < n ? s->links[i + 1] : 0.0;
            const double b = j + 1 < n ? s->links[j + 1] : 0.0;
            if (a == 0.0 && b == 0.0) continue;
            lanes *to = second + pair_of(i, j) * width;
            if (a != 0.0) {
                const int64_t low = i + 1 < j ? i + 1 : j, high = i + 1 < j ? j : i + 1;
                const lanes *from = second + pair_of(low, high) * width;
                for (int64_t k = 0; k < width; k++) to[k] -= a * from[k];
            }
            if (b != 0.0) {
                const lanes *from = second + pair_of(i, j + 1) * width;
                for (int64_t k = 0; k < width; k++) to[k] -= b * from[k];
            }
            if (a != 0.0 && b != 0.0) {
                const lanes *from = second + pair_of(i + 1, j + 1) * width;
                for (int64_t k = 0; k < width; k++) to[k] += a * b * from[k];
            }
        }
}

/* The generalised force of a spring, with its derivatives, for each form. */
typedef struct {
    lanes size; /* of forces times ways, all forms together */
    lanes at[1 + MOST_JOINTS + PAIRS][MOST_FORMS];
} pulled;

INLINE const vector *term_of(const moved *m, int64_t n, int64_t term) {
    return term == 0 ? &m->at : term <= n ? &m->first[term - 1] : &m->second[term - 1 - n];
}

/* What springs make of their rows: weights (s, r), products (s) of v and y. */
INLINE void put_row(const Statement *s, const vector *products, const double *values, vector *to) {
    for (int64_t r = 0; r < s->rank; r++) {
        vector sum = none();
        for (int64_t k = 0; k < s->springs; k++)
            sum = plus(sum, times(every(values[k * s->rank + r]), products[k]));
        to[r] = sum;
    }
}

/* B with its first and second derivatives by x at a placed arm: (terms, forms, targets, rank).
 *
 * Returns the sum of the sizes of what B is made of: what rounding is relative to. The memory is
 * of (s) each. Source: the product rule for v y, twice.
 */
static lanes rows_about(const Statement *s, const Arm *arm, const vector *axes,
                        const vector *origins, const moved *points, const moved *load,
                        moved *ways, pulled *exerted, vector *products, vector *rows) {
    const int64_t n = s->joints, terms = terms_of(s), width = row_vectors(s), rank = s->rank;
    const int64_t springs = s->springs, targets = targets_of(s);
    for (int64_t k = 0; k < springs; k++) {
        const int64_t slides = s->slide[k];
        moved *way = ways + k;
        way_moved(s, arm, s->bodies[k], slides, axes[k], origins[k], load, way);
        const lanes far = root(dot(way->at, way->at));
        exerted[k].size = every(0.0);
        for (int64_t f = 0; f < s->forms; f++) {
            vector force = constant(s->forces + 3 * f);
            exerted[k].size += root(dot(force, force)) * far;
            for (int64_t t = 0; t < terms; t++)
                exerted[k].at[t][f] = dot(force, *term_of(way, n, t));
        }
        if (!s->twisting || slides) continue;
        moved along;
        axis_moved(s, arm, s->bodies[k], axes[k], &along);
        for (int64_t f = 0; f < s->forms; f++) {
            vector moment = constant(s->moments + 3 * f);
            exerted[k].size += root(dot(moment, moment));
            for (int64_t t = 0; t < terms; t++)
                exerted[k].at[t][f] += dot(moment, *term_of(&along, n, t));
        }
    }
    lanes sizes = every(0.0);
    for (int64_t m = 0; m < targets; m++) {
        const double weight = m < s->markers ? 1.0 : s->turning;
        for (int64_t k = 0; k < springs; k++) {
            const int64_t body = s->bodies[k], slides = s->slide[k];
            moved *way = ways + k;
            if (m < s->markers) {
                if (m || m != s->loaded) /* at first the way of the load point is there */
                    way_moved(s, arm, body, slides, axes[k], origins[k], points + m, way);
            } else {
                axis_moved(s, arm, body, slides ? none() : axes[k], way);
            }
            double largest = 0.0;
            for (int64_t r = 0; r < rank; r++) largest += fabs(s->values[k * rank + r]);
            sizes += (weight * largest) * (exerted[k].size * root(dot(way->at, way->at)));
        }
        for (int64_t f = 0; f < s->forms; f++) {
            vector *to = rows + (f * targets + m) * rank;
            for (int64_t k = 0; k < springs; k++)
                products[k] = times(exerted[k].at[0][f], ways[k].at);
            put_row(s, products, s->values, to);
            for (int64_t j = 0; j < n; j++) {
                for (int64_t k = 0; k < springs; k++)
                    products[k] = plus(times(exerted[k].at[0][f], ways[k].first[j]),
                                       times(exerted[k].at[1 + j][f], ways[k].at));
                put_row(s, products, s->values, to + (1 + j) * width);
                for (int64_t i = 0; i <= j; i++) {
                    const int64_t both = pair_of(i, j);
                    for (int64_t k = 0; k < springs; k++) {
                        const moved *v = ways + k;
                        const pulled *y = exerted + k;
                        products[k] = plus(plus(times(y->at[0][f], v->second[both]),
                                                times(y->at[1 + n + both][f], v->at)),
                                           plus(times(y->at[1 + j][f], v->first[i]),
                                                times(y->at[1 + i][f], v->first[j])));
                    }
                    put_row(s, products, s->values, to + (1 + n + both) * width);
                }
            }
            if (weight != 1.0)
                for (int64_t t = 0; t < terms; t++)
                    for (int64_t r = 0; r < rank; r++)
                        to[t * width + r] = times(every(weight), to[t * width + r]);
        }
    }
    by_coordinates(s, (lanes *)(rows + width), (lanes *)(rows + (1 + n) * width), 3 * width);
    return sizes;
}

/* A constraint with its derivatives by x. */
typedef struct {
    lanes at, first[MOST_JOINTS], second[PAIRS];
} scalar;

/* Finds a constraint; returns the size of what it is made of. */
static lanes condition_about(const Statement *s, const Arm *arm, const Condition *c, scalar *g) {
    const int64_t n = s->joints;
    moved m;
    if (c->kind == DIRECTION_BOUND)
        direction_moved(s, arm, c->point, &m);
    else
        point_moved(s, arm, c->point, &m);
    vector normal = constant(c->normal);
    lanes sizes = fabs(c->offset) + root(dot(normal, normal) * dot(m.at, m.at));
    if (c->kind == DISTANCE_BOUND) {
        vector weights = {every(2.0 * c->sign * c->weights[0]), every(2.0 * c->sign * c->weights[1]),
                          every(2.0 * c->sign * c->weights[2])};
        vector away = minus(m.at, normal);
        sizes = root(dot(normal, normal)) + root(dot(m.at, m.at));
        normal = (vector){weights.x * away.x, weights.y * away.y, weights.z * away.z};
        sizes = fabs(c->offset) + root(dot(normal, normal)) * sizes;
        g->at = 0.5 * dot(normal, away) - c->offset;
        for (int64_t j = 0; j < n; j++) {
            vector bent = {weights.x * m.first[j].x, weights.y * m.first[j].y,
                           weights.z * m.first[j].z};
            g->first[j] = dot(normal, m.first[j]);
            for (int64_t i = 0; i <= j; i++)
                g->second[pair_of(i, j)] =
                    dot(normal, m.second[pair_of(i, j)]) + dot(bent, m.first[i]);
        }
    } else {
        g->at = dot(normal, m.at) - c->offset;
        for (int64_t j = 0; j < n; j++) {
            g->first[j] = dot(normal, m.first[j]);
            for (int64_t i = 0; i <= j; i++)
                g->second[pair_of(i, j)] = dot(normal, m.second[pair_of(i, j)]);
        }
    }
    by_coordinates(s, g->first, g->second, 1);
    return sizes;
}

#endif
