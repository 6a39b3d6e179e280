/* Signed distances of convex solids, each known by how far it reaches in any direction.
 *
 * The point of their difference that is nearest to the origin is looked for among the corners of
 * a tetrahedron that is renewed corner by corner, in all lanes at once.
 *
 * Source: Gilbert, Johnson, Keerthi 1988. Ours: what is nearest in the tetrahedron is the best of
 * all faces at the newest corner, without cases.
 */
#ifndef ELASTOCAL_CONVEX_H
#define ELASTOCAL_CONVEX_H

#include "depth.h"

#define MOST_TURNS 64
#define ALMOST 1e-12  /* of a squared distance, how much it may be less */
#define TOUCHING 1e-9 /* nearer is inside [m] */
#define THICK 1e-6    /* squared volume over squared edges of what has an inside beyond doubt */

/* Three corners with their shares of the nearest point. Where the origin is inside of them and a
 * fourth, that is kept; `thick` where they are far from flat. */
typedef struct {
    Tip tip[4];
    lanes part[3];
    vector nearest;
    mask thick;
} Simplex;

/* Where shares of two edges from the new corner are nearer to the origin, they are taken. */
INLINE void try_shares(Simplex *x, vector fresh, const vector *edge, int i, lanes s, int j,
                       lanes t, mask valid, lanes *least) {
    vector point = plus(fresh, times(s, edge[i]));
    if (j != i) point = plus(point, times(t, edge[j]));
    lanes square = dot(point, point);
    mask better = valid & (square < *least);
    *least = pick(better, square, *least);
    x->nearest = pick_vector(better, point, x->nearest);
    for (int k = 0; k < 3; k++)
        x->part[k] = pick(better, k == i ? s : k == j ? t : every(0.0), x->part[k]);
}

/* The nearest point of all faces at the new corner; corners without a share count, too, for they
 * are points of the set. Returns where the origin is inside; `open` where it came nearer. */
static mask renew(Simplex *x, const Tip *fresh, mask *open) {
    const vector w = fresh->apart;
    const Simplex before = *x;
    vector edge[3], normal[3], turned[3];
    lanes size[3], least = dot(x->nearest, x->nearest);
    const lanes was = least;
    for (int i = 0; i < 3; i++) {
        edge[i] = minus(x->tip[i].apart, w);
        turned[i] = cross(w, edge[i]);
        size[i] = dot(edge[i], edge[i]);
    }
    const mask all = every(0.0) == 0.0;
    for (int i = 0; i < 3; i++) {
        lanes t = -dot(w, edge[i]) / larger(size[i], every(1e-300));
        try_shares(x, w, edge, i, between(t, every(0.0), every(1.0)), i, every(0.0), all, &least);
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        normal[k] = cross(edge[i], edge[j]);
        lanes area = dot(normal[k], normal[k]);
        mask thick = area > 1e-24 * size[i] * size[j];
        area = pick(thick, area, every(1.0));
        lanes s = -dot(turned[j], normal[k]) / area, t = dot(turned[i], normal[k]) / area;
        mask valid = thick & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0);
        try_shares(x, w, edge, i, s, j, t, valid, &least);
    }
    lanes volume = dot(edge[0], normal[0]), sum = every(0.0);
    mask inside = volume * volume > 1e-24 * size[0] * size[1] * size[2];
    volume = pick(inside, volume, every(1.0));
    for (int k = 0; k < 3; k++) {
        lanes share = -dot(w, normal[k]) / volume;
        inside &= share > 0.0;
        sum += share;
    }
    inside &= (sum < 1.0) & *open;
    x->tip[3] = pick_tip(inside, *fresh, x->tip[3]);
    x->thick |= inside & (volume * volume > THICK * size[0] * size[1] * size[2]);
    *open &= (least < was) & ~inside;
    /* The new corner replaces one that has no share. */
    mask placed = ~*open;
    lanes rest = 1.0 - (x->part[0] + x->part[1] + x->part[2]);
    for (int k = 0; k < 3; k++) {
        mask here = ~placed & (x->part[k] == 0.0);
        placed |= here;
        x->tip[k] = pick_tip(here, *fresh, x->tip[k]);
        x->part[k] = pick(*open, pick(here, rest, x->part[k]), before.part[k]);
    }
    x->nearest = pick_vector(*open, x->nearest, before.nearest);
    return inside;
}

/* The signed distance of two solids where a lower bound, with a direction, is below `enough`;
 * elsewhere that stays. What is not below `enough` need not be right, nor, where it is only to be
 * decided whether it is, what is. */
static void part_by_reach(const Place *p, const Solid *one, const Solid *two, lanes enough,
                          int deciding, Nearest *n) {
    const lanes skin = every(one->skin + two->skin), far = enough + skin;
    const mask asked = n->distance < enough;
    mask inside = {0}, open = asked;
    Nearest found = *n;
    Tip fresh = against(p, one, two, n->normal, asked);
    Simplex x = {{fresh, fresh, fresh, fresh}, {every(1.0), every(0.0), every(0.0)},
                 fresh.apart, {0}};
    open &= dot(n->normal, fresh.apart) < far;
    for (int turn = 0; turn < MOST_TURNS && any(open); turn++) {
        lanes square = dot(x.nearest, x.nearest);
        mask close = open & (square < TOUCHING * TOUCHING);
        inside |= close, open &= ~close;
        fresh = against(p, one, two, x.nearest, open);
        lanes bound = dot(x.nearest, fresh.apart);
        open &= (square - bound > ALMOST * square) & (bound < far * root(square));
        if (any(open)) inside |= renew(&x, &fresh, &open);
    }
    found.first = found.second = times(every(0.0), x.nearest);
    for (int k = 0; k < 3; k++) {
        found.first = plus(found.first, times(x.part[k], x.tip[k].one));
        found.second = plus(found.second, times(x.part[k], x.tip[k].two));
    }
    found.distance = pick(inside, every(-TOUCHING), root(dot(x.nearest, x.nearest)));
    lanes least = larger(found.distance, every(TOUCHING));
    found.normal = pick_vector(inside, found.normal, times(1.0 / least, x.nearest));
    for (int i = 0; i < LANES; i++)
        if (inside[i] && (!deciding || enough[i] < 0.0))
            deepen(p, one, two, x.thick[i] ? x.tip : 0, i, far[i], &found);
    n->distance = pick(asked, found.distance - skin, n->distance);
    n->normal = pick_vector(asked, found.normal, n->normal);
    found.first = minus(found.first, times(every(one->skin), found.normal));
    found.second = plus(found.second, times(every(two->skin), found.normal));
    n->first = pick_vector(asked, found.first, n->first);
    n->second = pick_vector(asked, found.second, n->second);
}

/* From a plane the lowest point of a solid is the nearest. */
static void drop_by_reach(const Place *p, const Solid *one, const double *pose, Nearest *n) {
    vector up = constant(pose + 6), at = farthest(p, one, times(every(-1.0), up), ~(mask){0});
    n->first = minus(at, times(every(one->skin), up));
    n->distance = dot(up, minus(n->first, constant(pose + 9)));
    n->second = minus(n->first, times(n->distance, up));
    n->normal = up;
}

#endif
