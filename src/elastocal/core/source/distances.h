/* Signed distances of capsules from each other, from planes and from boxes; of many the least.
 *
 * Source: as constraints/collision/segments.py, which says where the formulas are from.
 */
#ifndef ELASTOCAL_DISTANCES_H
#define ELASTOCAL_DISTANCES_H

#include "chain.h"

/* The nearest of some pairs: distance, which pair, both points, direction that parts them. */
typedef struct {
    lanes distance;
    lanes pair; /* number, -1 where all are beyond the horizon */
    vector first, second, normal;
} Nearest;

static void place_solids(const Space *s, Place *p) {
    for (int64_t i = 0; i < s->solids; i++) {
        const frame *f = &p->bodies[s->solid[i].body];
        p->ends[2 * i] = carried_to(f, s->solid[i].ends);
        p->ends[2 * i + 1] = carried_to(f, s->solid[i].ends + 3);
    }
}

INLINE lanes share(lanes a) { return between(a, every(0.0), every(1.0)); }

/* A unit vector square to u and v, to u alone where they are parallel, else any. */
static vector square_to(vector u, vector v) {
    const vector x = {every(1.0), every(0.0), every(0.0)}, y = {every(0.0), every(1.0), every(0.0)};
    vector found = {every(0.0), every(0.0), every(1.0)};
    lanes least = 1e-12 * (1.0 + root(dot(u, u)));
    const vector others[] = {y, x, v};
    for (int i = 0; i < 3; i++) {
        vector normal = cross(u, others[i]);
        lanes length = root(dot(normal, normal));
        mask fine = length > least;
        found = pick_vector(fine, times(1.0 / pick(fine, length, every(1.0)), normal), found);
    }
    return found;
}

/* Closest points of the segments a-b and c-d. */
static Nearest between_segments(vector a, vector b, vector c, vector d) {
    vector u = minus(b, a), v = minus(d, c), r = minus(a, c);
    lanes uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ur = dot(u, r), vr = dot(v, r);
    lanes square = uu * vv - uv * uv;
    mask skew = square > 1e-12 * uu * vv;
    lanes s = pick(skew, (uv * vr - ur * vv) / pick(skew, square, every(1.0)), every(0.5));
    lanes one = 1.0 / larger(uu, every(1e-300)), two = 1.0 / larger(vv, every(1e-300));
    lanes t = every(0.0);
    s = share(s);
    for (int i = 0; i < 2; i++) {
        t = share((uv * s + vr) * two);
        s = share((uv * t - ur) * one);
    }
    Nearest n;
    n.first = plus(a, times(s, u)), n.second = plus(c, times(t, v));
    vector gap = minus(n.first, n.second);
    n.distance = root(dot(gap, gap));
    mask touching = n.distance < 1e-12;
    n.normal = times(1.0 / pick(touching, every(1.0), n.distance), gap);
    if (any(touching)) n.normal = pick_vector(touching, square_to(u, v), n.normal);
    return n;
}

/* A segment from all below z = 0 of a pose. */
INLINE Nearest from_plane(vector a, vector b, const double *pose) {
    vector normal = constant(pose + 6), origin = constant(pose + 9);
    lanes one = dot(normal, minus(a, origin)), two = dot(normal, minus(b, origin));
    mask lower = two < one;
    Nearest n;
    n.distance = pick(lower, two, one);
    n.first = pick_vector(lower, b, a);
    n.second = minus(n.first, times(n.distance, normal));
    n.normal = normal;
    return n;
}

/* The least signed distance of the pairs of a margin, at most its horizon; `nearest` may be 0. */
static lanes nearest_pair(const Space *s, const Margin *g, const Place *p, Nearest *nearest) {
    lanes best = every(g->horizon);
    if (nearest) {
        memset(nearest, 0, sizeof *nearest);
        nearest->distance = best;
        nearest->pair = every(-1.0);
    }
    for (int64_t k = 0; k < g->count; k++) {
        const Pair *pair = &g->pairs[k];
        const Solid *one = &s->solid[pair->first], *two = &s->solid[pair->second];
        vector a = p->ends[2 * pair->first], b = p->ends[2 * pair->first + 1];
        Nearest n;
        if (pair->kind == A_PLANE) {
            n = from_plane(a, b, pair->pose);
        } else {
            vector c = p->ends[2 * pair->second], d = p->ends[2 * pair->second + 1];
            vector apart = times(every(0.5), minus(plus(a, b), plus(c, d)));
            lanes reach = best + (one->ball + two->ball);
            if (!any((reach > 0.0) & (dot(apart, apart) < reach * reach))) continue;
            n = between_segments(a, b, c, d);
            n.distance -= two->radius;
            n.second = plus(n.second, times(every(two->radius), n.normal));
        }
        n.distance -= one->radius;
        mask nearer = n.distance < best;
        best = pick(nearer, n.distance, best);
        if (nearest && any(nearer)) {
            n.first = minus(n.first, times(every(one->radius), n.normal));
            nearest->distance = best;
            nearest->pair = pick(nearer, every((double)k), nearest->pair);
            nearest->first = pick_vector(nearer, n.first, nearest->first);
            nearest->second = pick_vector(nearer, n.second, nearest->second);
            nearest->normal = pick_vector(nearer, n.normal, nearest->normal);
        }
    }
    return best;
}

/* Adds the gradient of that distance times `weight`, as wrenches on the bodies. Both points are
 * held fixed to their bodies: an envelope theorem. */
static void pull_nearest(const Space *s, const Margin *g, const Nearest *n, lanes weight,
                         wrench *on) {
    for (int64_t k = 0; k < g->count; k++) {
        mask here = (n->pair == (double)k) & (weight != 0.0);
        if (!any(here)) continue;
        const Pair *pair = &g->pairs[k];
        vector force = times(pick(here, weight, every(0.0)), n->normal);
        push(&on[s->solid[pair->first].body], n->first, force);
        if (pair->kind == A_SEGMENT)
            push(&on[s->solid[pair->second].body], n->second, times(every(-1.0), force));
    }
}

#endif
