/* How deep two convex solids are in each other: a polytope grows in their difference, which holds
 * the origin, until its nearest face is one of the difference. One lane at a time.
 *
 * Source: van den Bergen 2001.
 */
#ifndef ELASTOCAL_DEPTH_H
#define ELASTOCAL_DEPTH_H

#include "reach.h"

#define MOST_TIPS 96  /* corners of the polytope */
#define FLAT 1e-9     /* thinner has no inside [m] */
#define GROWN 1e-10   /* how much farther than its nearest face the difference may reach [m] */

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

/* A face of a polytope that grows, as one lane sees it. */
typedef struct {
    vector normal; /* outward */
    vector shares; /* of its corners, of its point nearest to the origin */
    double height; /* over the origin */
    double away;   /* of that point from the origin; the height where the origin is outside */
    int corner[3];
} Facet;

typedef struct {
    Tip tip[MOST_TIPS];
    Facet facet[2 * MOST_TIPS];
    int tips, facets;
} Polytope;

/* Adds a face; its corners turn to the left as seen from outside. */
static void add_facet(Polytope *t, int lane, int a, int b, int c) {
    Facet *f = &t->facet[t->facets++];
    vector start = t->tip[a].apart, u = minus(t->tip[b].apart, start);
    vector v = minus(t->tip[c].apart, start), normal = cross(u, v);
    lanes area = larger(dot(normal, normal), every(1e-300)), zero = every(0.0);
    f->corner[0] = a, f->corner[1] = b, f->corner[2] = c;
    f->normal = times(1.0 / root(area), normal);
    lanes height = dot(f->normal, start);
    lanes s = larger(-dot(cross(start, v), normal) / area, zero);
    lanes w = larger(dot(cross(start, u), normal) / area, zero);
    lanes rest = larger(1.0 - s - w, zero), sum = s + w + rest;
    f->shares = (vector){rest / sum, s / sum, w / sum};
    vector near = plus(start, plus(times(f->shares.y, u), times(f->shares.z, v)));
    f->height = height[lane];
    f->away = f->height < 0.0 ? f->height : root(dot(near, near))[lane];
}

/* Puts a new corner on top: faces that it is above of go, and their border joins it. */
static void raise(Polytope *t, int lane, const Tip *fresh) {
    int edges = 0, kept = 0, from[6 * MOST_TIPS], to[6 * MOST_TIPS];
    t->tip[t->tips] = *fresh;
    for (int k = 0; k < t->facets; k++) {
        const Facet f = t->facet[k];
        if (dot(f.normal, fresh->apart)[lane] <= f.height + 1e-2 * GROWN) {
            t->facet[kept++] = f;
            continue;
        }
        for (int i = 0; i < 3; i++) {
            const int a = f.corner[i], b = f.corner[(i + 1) % 3];
            int twin = 0;
            while (twin < edges && (from[twin] != b || to[twin] != a)) twin++;
            if (twin < edges) { /* between two that go */
                from[twin] = from[--edges], to[twin] = to[edges];
            } else {
                from[edges] = a, to[edges++] = b;
            }
        }
    }
    t->facets = kept;
    for (int k = 0; k < edges && t->facets < 2 * MOST_TIPS; k++)
        add_facet(t, lane, from[k], to[k], t->tips);
    t->tips++;
}

/* Of some directions both ways that in which the difference reaches farthest from where `off`
 * says: a further corner. */
static Tip outermost(const Place *p, const Solid *one, const Solid *two, int lane,
                     const vector *ways, int count, const Polytope *t, double *reach) {
    Tip best = {0};
    *reach = -1.0;
    for (int k = 0; k < 2 * count; k++) {
        vector way = times(every(k % 2 ? 1.0 : -1.0), ways[k / 2]);
        Tip tip = against(p, one, two, way, only(lane));
        vector off = t->tips ? minus(tip.apart, t->tip[0].apart) : tip.apart;
        if (t->tips == 2) { /* from the line */
            vector line = minus(t->tip[1].apart, t->tip[0].apart);
            off = times(1.0 / root(dot(line, line)), cross(off, line));
        }
        lanes away = t->tips == 3 ? size_of(dot(off, ways[0])) : root(dot(off, off));
        if (away[lane] > *reach) *reach = away[lane], best = tip;
    }
    return best;
}

static const double axes_of_space[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

/* The faces of a tetrahedron. */
static void close_up(Polytope *t, int lane) {
    vector edge[3];
    for (int i = 0; i < 3; i++) edge[i] = minus(t->tip[i + 1].apart, t->tip[0].apart);
    const int above = dot(cross(edge[0], edge[1]), edge[2])[lane] > 0.0;
    const int b = above ? 2 : 1, c = above ? 1 : 2;
    t->tips = 4, t->facets = 0;
    add_facet(t, lane, 0, b, c), add_facet(t, lane, 0, c, 3);
    add_facet(t, lane, c, b, 3), add_facet(t, lane, b, 0, 3);
}

/* A tetrahedron of far corners. Returns 0 where all is flat: then `way` is square to it. */
static int begin(const Place *p, const Solid *one, const Solid *two, int lane, Polytope *t,
                 vector *way) {
    vector ways[3];
    double reach;
    t->tips = 0;
    for (int i = 0; i < 3; i++) ways[i] = constant(axes_of_space[i]);
    t->tip[0] = outermost(p, one, two, lane, ways, 3, t, &reach), t->tips = 1;
    t->tip[1] = outermost(p, one, two, lane, ways, 3, t, &reach);
    if (reach < FLAT) return 0;
    t->tips = 2;
    vector line = minus(t->tip[1].apart, t->tip[0].apart);
    line = times(1.0 / root(dot(line, line)), line);
    ways[0] = square_to(line, *way), ways[1] = cross(ways[0], line);
    t->tip[2] = outermost(p, one, two, lane, ways, 2, t, &reach);
    if (reach < FLAT) {
        *way = ways[1]; /* the part of it that is square to the line */
        return 0;
    }
    t->tips = 3;
    vector normal = cross(line, minus(t->tip[2].apart, t->tip[0].apart));
    ways[0] = times(1.0 / root(dot(normal, normal)), normal);
    t->tip[3] = outermost(p, one, two, lane, ways, 1, t, &reach);
    if (reach < FLAT) {
        *way = times(signed_as(every(1.0), dot(ways[0], *way)), ways[0]);
        return 0;
    }
    return 1;
}

/* How deep two solids without their skins are in each other, in one lane: the least way that
 * parts them, unless it is found to be less than what is `enough`. Four corners around the origin
 * begin it, if they are known. Where the difference is flat, what is known of the distance stays
 * but for the direction. */
static void deepen(const Place *p, const Solid *one, const Solid *two, const Tip *corners,
                   int lane, double enough, Nearest *n) {
    Polytope t;
    const mask here = only(lane);
    vector way = n->normal;
    if (corners) {
        memcpy(t.tip, corners, 4 * sizeof *corners);
    } else if (!begin(p, one, two, lane, &t, &way)) {
        n->normal = pick_vector(here, way, n->normal);
        n->distance = pick(here, every(0.0), n->distance);
        return;
    }
    close_up(&t, lane);
    double least = INFINITY;
    while (t.tips < MOST_TIPS && t.facets && -least < enough) {
        const Facet *f = &t.facet[0];
        for (int k = 1; k < t.facets; k++)
            if (t.facet[k].away < f->away) f = &t.facet[k];
        way = times(every(-1.0), f->normal);
        const Tip tip = against(p, one, two, way, here);
        const double reach = dot(f->normal, tip.apart)[lane];
        if (reach < least) {
            const Tip *a = &t.tip[f->corner[0]], *b = &t.tip[f->corner[1]];
            const Tip *c = &t.tip[f->corner[2]];
            vector first = plus(times(f->shares.x, a->one), times(f->shares.y, b->one));
            vector second = plus(times(f->shares.x, a->two), times(f->shares.y, b->two));
            n->first = pick_vector(here, plus(first, times(f->shares.z, c->one)), n->first);
            n->second = pick_vector(here, plus(second, times(f->shares.z, c->two)), n->second);
            n->normal = pick_vector(here, way, n->normal);
            least = reach;
        }
        if (reach - f->height <= GROWN) break;
        raise(&t, lane, &tip);
    }
    n->distance = pick(here, every(-least), n->distance);
}

#endif
