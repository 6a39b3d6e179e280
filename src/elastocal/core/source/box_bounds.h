/* Upper bounds of the sensitivity over LANES boxes.
 *
 * On a box with centre c and half-widths r: |B(c + h)| <= |P(h)| + R with the second-order part P
 * and R = sum r_i r_j r_k T_ijk / 6; |P|^2 is a quadratic q(h) but for 2 b1 b2 + b2^2. What
 * constraints g >= 0 say is added, times multipliers >= 0. Source: ours; docs/math.md.
 */
#ifndef ELASTOCAL_BOX_BOUNDS_H
#define ELASTOCAL_BOX_BOUNDS_H

#include "expansion.h"

#define MOST_CONDITIONS 64
#define EPSILON 0x1p-52
#define CAUTION 1e3 /* times what sums of rounding errors may be */

/* Memory of a search; made once. */
typedef struct {
    vector *axes, *origins, *rows; /* (s), (s), (terms, forms, targets, rank) */
    vector *products;              /* (s) */
    moved *points;                 /* (markers + 1): the load point last */
    moved *ways;                   /* (s) */
    pulled *exerted;               /* (s) */
    scalar *conditions;            /* (conditions + 2 n): constraints, then limits */
} Room;

/* What is known of LANES boxes. */
typedef struct {
    lanes bound;           /* of the sensitivity, INFINITY where none was found */
    mask empty;            /* no point of the box is allowed */
    mask inside;           /* the centre is allowed */
    lanes value;           /* the sensitivity at the centre */
    lanes weight[MOST_JOINTS]; /* how much splitting a variable may help */
} Found;

INLINE int64_t room_size(const Statement *s) {
    const int64_t bytes = (int64_t)sizeof(lanes);
    return 9 * s->springs + 3 * terms_of(s) * row_vectors(s) +
           (s->markers + 1 + s->springs) * (int64_t)sizeof(moved) / bytes +
           s->springs * (int64_t)sizeof(pulled) / bytes +
           (s->conditions + 2 * s->joints) * (int64_t)sizeof(scalar) / bytes;
}

INLINE Room room_in(const Statement *s, lanes *memory) {
    Room room;
    room.axes = (vector *)memory;
    room.origins = room.axes + s->springs;
    room.rows = room.origins + s->springs;
    room.products = room.rows + terms_of(s) * row_vectors(s);
    room.points = (moved *)(room.products + s->springs);
    room.ways = room.points + s->markers + 1;
    room.exerted = (pulled *)(room.ways + s->springs);
    room.conditions = (scalar *)(room.exerted + s->springs);
    return room;
}

/* sum r_i r_j r_k T_ijk / 6 of a symmetric table; each variable's part goes to `share`. */
INLINE lanes third_order(int64_t n, const double *third, const lanes *r, lanes *share) {
    lanes sum = every(0.0);
    if (share)
        for (int64_t i = 0; i < n; i++) share[i] = every(0.0);
    for (int64_t i = 0; i < n; i++)
        for (int64_t j = i; j < n; j++) {
            const double *row = third + (i * n + j) * n;
            /* i = j = k stands once, i = j < k and i < j = k three times, i < j < k six times */
            lanes inner = (i == j ? 1.0 / 6.0 : 0.5) * row[j] * r[j];
            for (int64_t k = j + 1; k < n; k++) {
                lanes term = (i == j ? 0.5 : 1.0) * row[k] * r[k];
                inner += term;
                if (share) share[k] += (1.0 / 3.0) * r[i] * r[j] * term;
            }
            inner *= r[i] * r[j];
            sum += inner;
            if (!share) continue;
            /* what belongs to k is there already */
            lanes last = (i == j ? 1.0 / 6.0 : 0.5) * row[j] * r[j] * r[i] * r[j];
            lanes others = (1.0 / 3.0) * (inner - last);
            share[i] += others + (1.0 / 3.0) * last;
            share[j] += others + (2.0 / 3.0) * last;
        }
    return sum;
}

/* The largest slope h + bend h^2 / 2 for |h| <= r. */
INLINE lanes largest_of_one(lanes slope, lanes bend, lanes r) {
    lanes size = size_of(slope), end = size * r + 0.5 * bend * r * r;
    mask within = (bend < 0.0) & (size < -bend * r);
    return pick(within, size * size / pick(within, -2.0 * bend, every(1.0)), end);
}

/* A bound of g.h + h'Hh / 2 over a box; 1/r where r > 0. Each variable's part goes to `part`.
 *
 * |H_ij h_i h_j| <= |H_ij| (h_i^2 r_j / r_i + h_j^2 r_i / r_j) / 2: equal in the corners.
 */
INLINE lanes largest_of_quadratic(int64_t n, const lanes *g, const lanes *h, const lanes *r,
                                  const lanes *inverse, lanes *part) {
    lanes sum = every(0.0);
    for (int64_t i = 0; i < n; i++) {
        lanes beside = every(0.0);
        for (int64_t j = 0; j < n; j++)
            if (j != i) beside += size_of(h[i < j ? pair_of(i, j) : pair_of(j, i)]) * r[j];
        lanes one = largest_of_one(g[i], h[pair_of(i, i)] + beside * inverse[i], r[i]);
        if (part) part[i] = one;
        sum += one;
    }
    return sum;
}

/* The same, of the least, so that -g is bounded. */
INLINE lanes largest_of_scalar(int64_t n, const scalar *g, lanes rest, const lanes *r,
                               const lanes *inverse) {
    return g->at + rest + largest_of_quadratic(n, g->first, g->second, r, inverse, 0);
}

/* Finds what holds of the limits of joints that coordinates share: linear, so without a rest. */
static inline void limits_about(const Statement *s, const Arm *arm, Room *room, int64_t *count) {
    for (int64_t i = 0; i < s->joints; i++)
        for (int side = 0; side < 2; side++) {
            const double bound = side ? s->most[i] : s->least[i];
            if (!(fabs(bound) < INFINITY)) continue;
            scalar *g = room->conditions + (*count)++;
            memset(g, 0, sizeof *g);
            const double sign = side ? -1.0 : 1.0;
            g->at = sign * (arm->q[i] - bound);
            g->first[i] = every(sign);
            if (s->links[i] != 0.0) g->first[i - 1] = every(-sign * s->links[i]);
        }
}

/* A multiplier >= 0 of a constraint: where the first-order bound is least.
 *
 * sum |G_i + m g_i| r_i + m (g + rest) is convex and piecewise linear in m.
 */
INLINE lanes multiplier_of(int64_t n, const lanes *slope, const scalar *g, lanes level,
                           const lanes *r) {
    lanes best = every(0.0), least = every(0.0);
    for (int64_t i = 0; i < n; i++) least += size_of(slope[i]) * r[i];
    for (int64_t i = 0; i < n; i++) {
        mask usable = (g->first[i] != 0.0);
        lanes m = -slope[i] / pick(usable, g->first[i], every(1.0));
        usable &= m > 0.0;
        lanes sum = m * level;
        for (int64_t j = 0; j < n; j++) sum += size_of(slope[j] + m * g->first[j]) * r[j];
        usable &= sum < least;
        best = pick(usable, m, best);
        least = pick(usable, sum, least);
    }
    return best;
}

/* What is done with multipliers: the objective is bounded by base + largest(slope, bend). */
typedef struct {
    lanes level, slope[MOST_JOINTS], bend[PAIRS];
    lanes lifted; /* sum of multipliers times the largest that their constraints get */
} Objective;

/* Adds constraints, each with the multiplier that suits it best, while that helps. */
static inline lanes with_conditions(const Statement *s, const Room *room, int64_t count,
                                    const lanes *rest, const lanes *r, const lanes *inverse,
                                    Objective *o, lanes *part) {
    const int64_t n = s->joints;
    lanes best = o->level + largest_of_quadratic(n, o->slope, o->bend, r, inverse, part);
    for (int64_t c = 0; c < count; c++) {
        const scalar *g = room->conditions + c;
        lanes m = multiplier_of(n, o->slope, g, g->at + rest[c], r);
        if (!any(m > 0.0)) continue;
        Objective tried;
        lanes parts[MOST_JOINTS];
        tried.level = o->level + m * (g->at + rest[c]);
        for (int64_t i = 0; i < n; i++) tried.slope[i] = o->slope[i] + m * g->first[i];
        for (int64_t k = 0; k < n * (n + 1) / 2; k++)
            tried.bend[k] = o->bend[k] + m * g->second[k];
        lanes sum = tried.level + largest_of_quadratic(n, tried.slope, tried.bend, r, inverse, parts);
        mask better = sum < best;
        if (!any(better)) continue;
        best = pick(better, sum, best);
        o->level = pick(better, tried.level, o->level);
        for (int64_t i = 0; i < n; i++) {
            o->slope[i] = pick(better, tried.slope[i], o->slope[i]);
            part[i] = pick(better, parts[i], part[i]);
        }
        for (int64_t k = 0; k < n * (n + 1) / 2; k++)
            o->bend[k] = pick(better, tried.bend[k], o->bend[k]);
    }
    return best;
}

INLINE lanes product_of(const vector *a, const vector *b, int64_t width) {
    lanes sum = every(0.0);
    for (int64_t k = 0; k < width; k++) sum += dot(a[k], b[k]);
    return sum;
}

/* Fixed loads: the expansion of |B|^2, and the sizes of the derivatives of B. */
static inline void fixed_load(const Statement *s, const Room *room, const lanes *r, Found *found,
                              Objective *o, lanes *b1, lanes *b2, lanes *share) {
    const int64_t n = s->joints, width = row_vectors(s);
    const vector *rows = room->rows, *first = rows + width, *second = first + n * width;
    o->level = found->value = product_of(rows, rows, width);
    *b1 = *b2 = every(0.0);
    for (int64_t i = 0; i < n; i++) share[i] = every(0.0);
    for (int64_t j = 0; j < n; j++) {
        const vector *by_j = first + j * width;
        o->slope[j] = 2.0 * product_of(rows, by_j, width);
        for (int64_t i = 0; i <= j; i++) {
            const vector *both = second + pair_of(i, j) * width;
            lanes across = product_of(first + i * width, by_j, width);
            o->bend[pair_of(i, j)] = 2.0 * (across + product_of(rows, both, width));
            if (i == j) *b1 += r[i] * root(across);
            lanes part = root(product_of(both, both, width)) * r[i] * r[j] * (i == j ? 0.5 : 1.0);
            *b2 += part;
            share[i] += part;
            share[j] += part;
        }
    }
}

#include "free_loads.h"

/* Bounds of LANES boxes: centres and half-widths (n). `aim` is what bounds should be below. */
static void bound_boxes(const Statement *s, const Room *memory, const lanes *x, const lanes *r,
                        double aim, Found *found) {
    const int64_t n = s->joints;
    Room room = *memory;
    Arm arm;
    place_arm(s, x, &arm, room.axes, room.origins);
    lanes inverse[MOST_JOINTS], rest[MOST_CONDITIONS + 2 * MOST_JOINTS];
    for (int64_t i = 0; i < n; i++) inverse[i] = 1.0 / pick(r[i] > 0.0, r[i], every(1.0));
    found->empty = (mask){0};
    found->inside = ~found->empty;
    int64_t count = 0;
    for (; count < s->conditions; count++) {
        const Condition *c = s->condition + count;
        lanes sizes = condition_about(s, &arm, c, room.conditions + count);
        sizes *= CAUTION * EPSILON * (double)(n + 1); /* rounding */
        rest[count] = third_order(n, c->third, r, 0) + sizes;
    }
    limits_about(s, &arm, &room, &count);
    for (int64_t c = 0; c < count; c++) {
        if (c >= s->conditions) rest[c] = every(0.0);
        const scalar *g = room.conditions + c;
        rest[c] += 1e-9 * (size_of(g->at) + 1e-3); /* rounding */
        found->empty |= largest_of_scalar(n, g, rest[c], r, inverse) < 0.0;
        found->inside &= g->at >= 0.0;
    }
    found->bound = every(0.0);
    found->value = every(0.0);
    for (int64_t i = 0; i < n; i++) found->weight[i] = r[i];
    if (!any(~found->empty)) return;
    for (int64_t m = 0; m < s->markers; m++)
        point_moved(s, &arm, s->marker + 3 * m, room.points + m);
    point_moved(s, &arm, s->load_point, room.points + s->markers);
    lanes sizes = rows_about(s, &arm, room.axes, room.origins, room.points,
                             room.points + s->markers, room.ways, room.exerted, room.products,
                             room.rows);
    lanes cubic[MOST_JOINTS], share[MOST_JOINTS], part[MOST_JOINTS];
    lanes third = third_order(n, s->third, r, cubic);
    third += CAUTION * EPSILON * (double)(n + 1) * sizes;
    if (s->forms > 1) {
        bound_free(s, &room, count, rest, r, inverse, third, cubic, aim, found);
        return;
    }
    Objective o;
    lanes b1, b2;
    fixed_load(s, &room, r, found, &o, &b1, &b2, share);
    lanes over = 2.0 * b1 * b2 + b2 * b2;
    lanes most = with_conditions(s, &room, count, rest, r, inverse, &o, part);
    lanes length = root(larger(every(0.0), most + over)); /* not a number stays so */
    found->bound = (length + third) * (length + third);
    found->bound = pick(found->bound >= 0.0, found->bound, every(INFINITY));
    for (int64_t i = 0; i < n; i++)
        found->weight[i] = part[i] + 2.0 * (b1 + b2) * share[i] + 6.0 * length * cubic[i];
}

#endif
