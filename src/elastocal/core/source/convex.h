/* Signed distances of convex solids, each known by how far it reaches in any direction.
 *
 * All that two solids can be apart is one convex set, the points of the one less those of the
 * other. Where the origin is outside of it, the nearest point is looked for among the corners of
 * a tetrahedron that is renewed corner by corner, in all lanes at once; where it is inside, a
 * polytope grows from within until its nearest face is one of the set, lane by lane.
 *
 * Source: Gilbert, Johnson, Keerthi 1988; van den Bergen 2001. Ours: what is nearest in the
 * tetrahedron is the best of all faces at the newest corner, without cases.
 */
#ifndef ELASTOCAL_CONVEX_H
#define ELASTOCAL_CONVEX_H

#include "chain.h"

#define MOST_TURNS 64
#define MOST_TIPS 96   /* corners of the polytope */
#define ALMOST 1e-12   /* of a squared distance, how much it may be less */
#define TOUCHING 1e-9  /* nearer is inside [m] */
#define FLAT 1e-9      /* thinner has no inside [m] */
#define GROWN 1e-10    /* how much farther than its nearest face a polytope may reach [m] */

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

/* A point of the difference, and of both solids: `apart` is `one` less `two`. */
typedef struct {
    vector apart, one, two;
} Tip;

INLINE Tip pick_tip(mask which, Tip a, Tip b) {
    return (Tip){pick_vector(which, a.apart, b.apart), pick_vector(which, a.one, b.one),
                 pick_vector(which, a.two, b.two)};
}

/* The point of a solid, its skin left out, that is farthest along a direction. */
static vector farthest(const Place *p, const Solid *solid, vector along) {
    const frame *f = &p->bodies[solid->body];
    vector seen = {dot(f->x, along), dot(f->y, along), dot(f->z, along)}, local = seen;
    lanes most = every(-INFINITY);
    for (int64_t k = 0; k < solid->tips; k++) {
        vector tip = constant(solid->tip + 3 * k);
        lanes height = dot(seen, tip);
        local = pick_vector(height > most, tip, local);
        most = larger(height, most);
    }
    if (solid->round) {
        vector one = constant(solid->spokes), two = constant(solid->spokes + 3);
        lanes a = dot(seen, one), b = dot(seen, two);
        lanes scale = 1.0 / larger(root(a * a + b * b), every(1e-150));
        local = plus(local, plus(times(scale * a, one), times(scale * b, two)));
    }
    return plus(plus(times(local.x, f->x), times(local.y, f->y)), plus(times(local.z, f->z), f->o));
}

/* The point of the difference that is farthest against a direction. */
static Tip against(const Place *p, const Solid *one, const Solid *two, vector along) {
    Tip tip;
    tip.one = farthest(p, one, times(every(-1.0), along));
    tip.two = farthest(p, two, along);
    tip.apart = minus(tip.one, tip.two);
    return tip;
}

/* Three corners with their shares of the nearest point; a fourth has come. */
typedef struct {
    Tip tip[3];
    lanes part[3];
    vector nearest;
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
        Tip tip = against(p, one, two, times(every(k % 2 ? 1.0 : -1.0), ways[k / 2]));
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

/* A tetrahedron of far corners. Returns 0 where all is flat: then `way` is square to it. */
static int begin(const Place *p, const Solid *one, const Solid *two, int lane, Polytope *t,
                 vector *way) {
    vector ways[3];
    double reach;
    t->tips = t->facets = 0;
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
    t->tips = 4;
    const int above = dot(ways[0], minus(t->tip[3].apart, t->tip[0].apart))[lane] > 0.0;
    const int b = above ? 2 : 1, c = above ? 1 : 2;
    add_facet(t, lane, 0, b, c), add_facet(t, lane, 0, c, 3);
    add_facet(t, lane, c, b, 3), add_facet(t, lane, b, 0, 3);
    return 1;
}

/* How deep two solids without their skins are in each other, in one lane: the least way that
 * parts them. Where the difference is flat, what is known stays but for the direction. */
static void deepen(const Place *p, const Solid *one, const Solid *two, int lane, Nearest *n) {
    Polytope t;
    mask here = {0};
    here[lane] = -1;
    vector way = n->normal;
    if (!begin(p, one, two, lane, &t, &way)) {
        n->normal = pick_vector(here, way, n->normal);
        n->distance = pick(here, every(0.0), n->distance);
        return;
    }
    double least = INFINITY;
    while (t.tips < MOST_TIPS && t.facets) {
        const Facet *f = &t.facet[0];
        for (int k = 1; k < t.facets; k++)
            if (t.facet[k].away < f->away) f = &t.facet[k];
        way = times(every(-1.0), f->normal);
        const Tip tip = against(p, one, two, way);
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

/* The signed distance of two solids where a lower bound, with a direction, is below `enough`;
 * elsewhere that stays. What is not below `enough` need not be right. */
static void part_by_reach(const Place *p, const Solid *one, const Solid *two, lanes enough,
                          Nearest *n) {
    const lanes skin = every(one->skin + two->skin), far = enough + skin;
    const mask asked = n->distance < enough;
    mask inside = {0}, open = asked;
    Nearest found = *n;
    Tip fresh = against(p, one, two, n->normal);
    Simplex x = {{fresh, fresh, fresh}, {every(1.0), every(0.0), every(0.0)}, fresh.apart};
    open &= dot(n->normal, fresh.apart) < far;
    for (int turn = 0; turn < MOST_TURNS && any(open); turn++) {
        lanes square = dot(x.nearest, x.nearest);
        mask close = open & (square < TOUCHING * TOUCHING);
        inside |= close, open &= ~close;
        fresh = against(p, one, two, x.nearest);
        lanes bound = dot(x.nearest, fresh.apart);
        open &= (square - bound > ALMOST * square) & (bound < far * root(square));
        if (any(open)) inside |= renew(&x, &fresh, &open);
    }
    found.first = found.second = times(every(0.0), x.nearest);
    for (int k = 0; k < 3; k++) {
        found.first = plus(found.first, times(x.part[k], x.tip[k].one));
        found.second = plus(found.second, times(x.part[k], x.tip[k].two));
    }
    found.distance = root(dot(x.nearest, x.nearest));
    lanes least = larger(found.distance, every(TOUCHING));
    found.normal = pick_vector(inside, found.normal, times(1.0 / least, x.nearest));
    for (int i = 0; i < LANES; i++)
        if (inside[i]) deepen(p, one, two, i, &found);
    n->distance = pick(asked, found.distance - skin, n->distance);
    n->normal = pick_vector(asked, found.normal, n->normal);
    found.first = minus(found.first, times(every(one->skin), found.normal));
    found.second = plus(found.second, times(every(two->skin), found.normal));
    n->first = pick_vector(asked, found.first, n->first);
    n->second = pick_vector(asked, found.second, n->second);
}

/* From a plane the lowest point of a solid is the nearest. */
static void drop_by_reach(const Place *p, const Solid *one, const double *pose, Nearest *n) {
    vector up = constant(pose + 6), at = farthest(p, one, times(every(-1.0), up));
    n->first = minus(at, times(every(one->skin), up));
    n->distance = dot(up, minus(n->first, constant(pose + 9)));
    n->second = minus(n->first, times(n->distance, up));
    n->normal = up;
}

#endif
