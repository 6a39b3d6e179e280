/* How far convex solids reach in a direction, and the difference of two: one convex set, the points
 * of the one less those of the other, at a distance from the origin that is theirs. */
#ifndef ELASTOCAL_REACH_H
#define ELASTOCAL_REACH_H

#include "chain.h"

/* A point of the difference, and of both solids: `apart` is `one` less `two`. */
typedef struct {
    vector apart, one, two;
} Tip;

INLINE Tip pick_tip(mask which, Tip a, Tip b) {
    return (Tip){pick_vector(which, a.apart, b.apart), pick_vector(which, a.one, b.one),
                 pick_vector(which, a.two, b.two)};
}

INLINE mask only(int lane) {
    mask which = {0};
    which[lane] = -1;
    return which;
}

/* Which part of all directions one belongs to: of a cube whose sides have square fields. */
INLINE int64_t field_of(const Solid *solid, const double *along) {
    int axis = fabs(along[1]) > fabs(along[0]);
    if (fabs(along[2]) > fabs(along[axis])) axis = 2;
    const double size = fabs(along[axis]), half = 0.5 * (double)solid->fields;
    int64_t field = 2 * axis + (along[axis] < 0.0);
    for (int i = 1; i < 3; i++) {
        int64_t k = size > 0.0 ? (int64_t)(half + half * along[(axis + i) % 3] / size) : 0;
        field = field * solid->fields + (k < solid->fields ? k : solid->fields - 1);
    }
    return field;
}

/* The tip that is farthest along a direction; of many, those that may be in one of its field. */
static vector farthest_tip(const Solid *solid, vector along, mask wanted) {
    vector found = along;
    if (!solid->fields) {
        lanes most = every(-INFINITY);
        for (int64_t k = 0; k < solid->tips; k++) {
            vector tip = constant(solid->tip + 3 * k);
            lanes height = dot(along, tip);
            found = pick_vector(height > most, tip, found);
            most = larger(height, most);
        }
        return found;
    }
    for (int i = 0; i < LANES; i++) {
        if (!wanted[i]) continue;
        const double way[] = {along.x[i], along.y[i], along.z[i]};
        const int64_t field = field_of(solid, way);
        const double *best = solid->tip;
        double most = -INFINITY;
        for (int64_t k = solid->starts[field]; k < solid->starts[field + 1]; k++) {
            const double *tip = solid->tip + 3 * solid->foremost[k];
            double height = way[0] * tip[0] + way[1] * tip[1] + way[2] * tip[2];
            if (height > most) most = height, best = tip;
        }
        found.x[i] = best[0], found.y[i] = best[1], found.z[i] = best[2];
    }
    return found;
}

/* The point of a solid, its skin left out, that is farthest along a direction. */
static vector farthest(const Place *p, const Solid *solid, vector along, mask wanted) {
    const frame *f = &p->bodies[solid->body];
    vector seen = {dot(f->x, along), dot(f->y, along), dot(f->z, along)};
    vector local = farthest_tip(solid, seen, wanted);
    if (solid->round) {
        vector one = constant(solid->spokes), two = constant(solid->spokes + 3);
        lanes a = dot(seen, one), b = dot(seen, two);
        lanes scale = 1.0 / larger(root(a * a + b * b), every(1e-150));
        local = plus(local, plus(times(scale * a, one), times(scale * b, two)));
    }
    return plus(plus(times(local.x, f->x), times(local.y, f->y)), plus(times(local.z, f->z), f->o));
}

/* The point of the difference that is farthest against a direction. */
static Tip against(const Place *p, const Solid *one, const Solid *two, vector along,
                   mask wanted) {
    Tip tip;
    tip.one = farthest(p, one, times(every(-1.0), along), wanted);
    tip.two = farthest(p, two, along, wanted);
    tip.apart = minus(tip.one, tip.two);
    return tip;
}

#endif
