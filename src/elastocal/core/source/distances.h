/* Signed distances of capsules from each other, from planes and from boxes; of many the least.
 *
 * Source: as constraints/collision/segments.py, which says where the formulas are from.
 */
#ifndef ELASTOCAL_DISTANCES_H
#define ELASTOCAL_DISTANCES_H

#include "chain.h"
#include "convex.h"

static void place_solids(const Space *s, Place *p) {
    for (int64_t i = 0; i < s->solids; i++) {
        const frame *f = &p->bodies[s->solid[i].body];
        p->ends[2 * i] = carried_to(f, s->solid[i].ends);
        p->ends[2 * i + 1] = carried_to(f, s->solid[i].ends + 3);
    }
}

INLINE lanes share(lanes a) { return between(a, every(0.0), every(1.0)); }

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

/* How deep a segment is in a box, which way out (of the segment) and its deepest point; all in
 * the frame of the box. */
static lanes depth_in_box(vector start, vector along, const double *half, vector *normal,
                          vector *point) {
    vector middle = plus(start, times(every(0.5), along)), reach = times(every(0.5), along);
    lanes least = 1e-9 * (1.0 + root(dot(along, along))), best = every(INFINITY);
    lanes t = every(0.0);
    for (int i = 0; i < 6; i++) {
        const double unit[] = {i % 3 == 0, i % 3 == 1, i % 3 == 2};
        vector axis = constant(unit);
        if (i > 2) axis = cross(axis, along);
        lanes size = root(dot(axis, axis));
        mask flat = size < least;
        axis = times(1.0 / pick(flat, every(1.0), size), axis);
        lanes offset = dot(axis, middle);
        axis = times(pick(offset < 0.0, every(-1.0), every(1.0)), axis);
        lanes overlap = size_of(axis.x) * half[0] + size_of(axis.y) * half[1] +
                        size_of(axis.z) * half[2] + size_of(dot(axis, reach)) - size_of(offset);
        mask better = ~flat & (overlap < best);
        if (!any(better)) continue;
        best = pick(better, overlap, best);
        *normal = pick_vector(better, axis, *normal);
        /* A face is met by an end of the segment, an edge of the box somewhere along it. */
        lanes where = pick(dot(axis, along) > 0.0, every(0.0), every(1.0));
        if (i > 2) {
            vector side = cross(axis, constant(unit));
            vector corner = {pick(axis.x < 0.0, every(-half[0]), every(half[0])),
                             pick(axis.y < 0.0, every(-half[1]), every(half[1])),
                             pick(axis.z < 0.0, every(-half[2]), every(half[2]))};
            lanes over = dot(side, along);
            lanes met = dot(side, minus(corner, start)) / pick(over == 0.0, every(1.0), over);
            where = share(met);
        }
        t = pick(better, where, t);
    }
    *point = plus(start, times(t, along));
    return best;
}

INLINE vector in_box(vector v, const double *half) {
    return (vector){between(v.x, every(-half[0]), every(half[0])),
                    between(v.y, every(-half[1]), every(half[1])),
                    between(v.z, every(-half[2]), every(half[2]))};
}

/* Out of the frame of a pose, but for its origin. */
INLINE vector turned_back(const double *pose, vector v) {
    return plus(plus(times(v.x, constant(pose)), times(v.y, constant(pose + 3))),
                times(v.z, constant(pose + 6)));
}
INLINE vector turned_into(const double *pose, vector v) {
    return (vector){dot(constant(pose), v), dot(constant(pose + 3), v), dot(constant(pose + 6), v)};
}

/* A segment from a box. The squared distance along the segment is convex and piecewise
 * quadratic: its slope passes through zero between two of at most eight places. */
static Nearest from_box(vector a, vector b, const double *pose, const double *half) {
    vector centre = constant(pose + 9);
    vector start = turned_into(pose, minus(a, centre)), end = turned_into(pose, minus(b, centre));
    vector along = minus(end, start);
    const lanes begin[] = {start.x, start.y, start.z}, way[] = {along.x, along.y, along.z};
    lanes left = every(0.0), right = every(1.0), low = left, high = right;
    for (int i = 0; i < 8; i++) {
        lanes knot = every(i == 7);
        if (i < 6) {
            knot = ((i < 3 ? half[i] : -half[i - 3]) - begin[i % 3]) / way[i % 3];
            knot = share(pick(is_finite(knot), knot, every(0.0)));
        }
        vector x = plus(start, times(knot, along));
        lanes slope = dot(along, minus(x, in_box(x, half)));
        mask falling = slope < 0.0;
        mask lower = falling & (knot >= left), upper = ~falling & (knot <= right);
        left = pick(lower, knot, left), low = pick(lower, slope, low);
        right = pick(upper, knot, right), high = pick(upper, slope, high);
    }
    /* No place where it falls: the start is nearest; none where it rises: the end. */
    lanes rise = high - low;
    lanes t = left + share(pick(rise > 0.0, -low / rise, every(0.0))) * (right - left);
    t = pick(low < 0.0, t, every(0.0));
    Nearest n;
    vector point = plus(start, times(t, along)), inside = in_box(point, half);
    vector gap = minus(point, inside);
    n.distance = root(dot(gap, gap));
    mask hit = n.distance < 1e-12;
    n.normal = times(1.0 / pick(hit, every(1.0), n.distance), gap);
    if (any(hit)) {
        vector out = n.normal, deepest = point;
        lanes depth = depth_in_box(start, along, half, &out, &deepest);
        n.distance = pick(hit, -depth, n.distance);
        n.normal = pick_vector(hit, out, n.normal);
        point = pick_vector(hit, deepest, point);
        inside = pick_vector(hit, plus(deepest, times(depth, out)), inside);
    }
    n.first = plus(turned_back(pose, point), centre);
    n.second = plus(turned_back(pose, inside), centre);
    n.normal = turned_back(pose, n.normal);
    return n;
}

/* Two solids, the one with faces as the other's body sees them. */
typedef struct {
    const Solid *one, *two;
    vector x, y, z; /* axes of the other's body, from the own */
    vector shift;   /* its origin, likewise */
} Facing;

static Facing facing(const Place *p, const Solid *one, const Solid *two) {
    const frame *own = &p->bodies[one->body], *other = &p->bodies[two->body];
    vector apart = minus(other->o, own->o);
    return (Facing){one, two,
                    {dot(own->x, other->x), dot(own->y, other->x), dot(own->z, other->x)},
                    {dot(own->x, other->y), dot(own->y, other->y), dot(own->z, other->y)},
                    {dot(own->x, other->z), dot(own->y, other->z), dot(own->z, other->z)},
                    {dot(own->x, apart), dot(own->y, apart), dot(own->z, apart)}};
}

/* How high the first corners of the other are over a face, and which of them is the lowest. */
INLINE lanes height_over(const Facing *f, int64_t face, int64_t corners, vector *lowest) {
    const double *plane = f->one->face + 4 * face;
    vector n = constant(plane), seen = {dot(n, f->x), dot(n, f->y), dot(n, f->z)};
    lanes least = every(INFINITY);
    for (int64_t k = 0; k < corners; k++) {
        vector local = constant(f->two->corner + 3 * k);
        lanes height = dot(seen, local);
        if (lowest) *lowest = pick_vector(height < least, local, *lowest);
        least = smaller(height, least);
    }
    return least + dot(n, f->shift) - (plane[3] + f->two->rounded);
}

/* How high all of `two` is over the best face of `one`: raises `gap` where it is more, with the
 * corner and the point below it. What exceeds `enough` is not looked at further. `hint` is the
 * face that was the best last time, plus 1: it is tried first. */
static mask over_faces(const Place *p, const Solid *one, const Solid *two, lanes *gap,
                       lanes enough, vector *foot, vector *normal, int64_t *hint) {
    const Facing f = facing(p, one, two);
    mask raised = {0};
    vector face = {*gap, *gap, *gap}, corner = face;
    lanes most[MOST_FACES];
    int known = 0;
    for (int64_t chosen = *hint - 1;;) {
        if (chosen >= 0) {
            vector lowest = face;
            lanes height = height_over(&f, chosen, two->corners, &lowest);
            mask better = (*gap < enough) & (height > *gap);
            *gap = pick(better, height, *gap);
            face = pick_vector(better, constant(one->face + 4 * chosen), face);
            corner = pick_vector(better, lowest, corner);
            raised |= better;
            if (any(better)) *hint = chosen + 1;
        }
        mask open = *gap < enough;
        if (!any(open)) break;
        /* Over no face all of it is higher than some of its corners: what these promise most. */
        for (int64_t k = 0; !known && k < one->faces; k++)
            most[k] = height_over(&f, k, two->corners < SENTINELS ? two->corners : SENTINELS, 0);
        if (known || chosen >= 0) most[chosen] = every(-INFINITY);
        known = 1, chosen = -1;
        double promise = 0.0;
        for (int64_t k = 0; k < one->faces; k++) {
            lanes more = pick(open, most[k] - *gap, every(0.0));
            for (int i = 0; i < LANES; i++)
                if (more[i] > promise) promise = more[i], chosen = k;
        }
        if (chosen < 0) break;
    }
    if (!any(raised)) return raised;
    const frame *own = &p->bodies[one->body], *other = &p->bodies[two->body];
    *normal = plus(plus(times(face.x, own->x), times(face.y, own->y)), times(face.z, own->z));
    vector at = plus(plus(times(corner.x, other->x), times(corner.y, other->y)),
                     plus(times(corner.z, other->z), other->o));
    *foot = minus(at, times(*gap + two->rounded, *normal));
    return raised;
}

/* What faces show of two solids beyond what capsules and boxes do. */
static void part_by_faces(const Space *s, const Place *p, const Pair *pair, lanes enough,
                          Nearest *n, int64_t *hints) {
    const Solid *one = &s->solid[pair->first], *two = &s->solid[pair->second];
    vector foot, normal;
    mask raised = over_faces(p, one, two, &n->distance, enough, &foot, &normal, &hints[0]);
    if (any(raised)) {
        n->first = pick_vector(raised, foot, n->first);
        n->second = pick_vector(raised, plus(foot, times(n->distance, normal)), n->second);
        n->normal = pick_vector(raised, times(every(-1.0), normal), n->normal);
    }
    if (!any(n->distance < enough)) return;
    raised = over_faces(p, two, one, &n->distance, enough, &foot, &normal, &hints[1]);
    if (any(raised)) {
        n->first = pick_vector(raised, plus(foot, times(n->distance, normal)), n->first);
        n->second = pick_vector(raised, foot, n->second);
        n->normal = pick_vector(raised, normal, n->normal);
    }
}

/* From a plane the lowest corner is the nearest. */
static void lift_by_corners(const Place *p, const Solid *one, const double *pose, Nearest *n) {
    const frame *f = &p->bodies[one->body];
    vector up = constant(pose + 6), origin = constant(pose + 9), lowest = up;
    vector seen = {dot(f->x, up), dot(f->y, up), dot(f->z, up)};
    lanes least = every(INFINITY);
    for (int64_t k = 0; k < one->corners; k++) {
        vector local = constant(one->corner + 3 * k);
        lanes height = dot(seen, local);
        lowest = pick_vector(height < least, local, lowest);
        least = smaller(height, least);
    }
    lanes distance = least + dot(up, minus(f->o, origin)) - one->rounded;
    mask higher = distance > n->distance;
    if (!any(higher)) return;
    vector at = plus(plus(times(lowest.x, f->x), times(lowest.y, f->y)),
                     plus(times(lowest.z, f->z), f->o));
    at = minus(at, times(every(one->rounded), up));
    n->first = pick_vector(higher, at, n->first);
    n->second = pick_vector(higher, minus(at, times(distance, up)), n->second);
    n->distance = pick(higher, distance, n->distance);
}

/* The piece of a beam from a tracker that is watched. */
INLINE void watched(const double *position, vector at, vector *start, vector *end) {
    lanes length;
    *start = constant(position);
    vector beam = minus(at, *start);
    length = larger(root(dot(beam, beam)), every(1e-9));
    *end = plus(*start, times(larger(length - NEAR_MARKER, every(0.0)) / length, beam));
}

/* The least signed distance of the pairs of a margin, at most `best`; where it is only to be
 * decided whether any is less, that is -INFINITY. The pair that was the nearest last time comes
 * first: the others are seldom nearer. */
static lanes nearest_pair(const Space *s, const Margin *g, const Place *p, lanes best,
                          int deciding) {
    const int beaming = g->kind == LINE_OF_SIGHT;
    Nearest *nearest = &p->nearest[g - s->margin];
    int64_t *hints = p->hints, *front = hints + 2 * pairs_of(s) + (g - s->margin);
    for (const Margin *other = s->margin; other < g; other++) hints += 2 * other->count;
    vector start, end;
    if (beaming) watched(g->place, p->at[g->at], &start, &end);
    memset(nearest, 0, sizeof *nearest);
    nearest->distance = best;
    nearest->pair = every(-1.0);
    for (int64_t turn = -1; turn < g->count; turn++) {
        const int64_t k = turn < 0 ? *front - 1 : turn;
        if (k < 0 || turn == *front - 1) continue;
        const Pair *pair = &g->pairs[k];
        const Solid *one = &s->solid[pair->first], *two = &s->solid[pair->second];
        vector a = beaming ? start : p->ends[2 * pair->first];
        vector b = beaming ? end : p->ends[2 * pair->first + 1];
        lanes radius = every(beaming ? 0.0 : one->radius);
        Nearest n;
        if (pair->kind == A_PLANE) {
            n = from_plane(a, b, pair->pose);
        } else {
            /* Balls first: those beyond what is known are left. */
            vector middle = times(every(0.5), plus(p->ends[2 * pair->second],
                                                   p->ends[2 * pair->second + 1]));
            if (pair->kind == A_BOX) middle = constant(pair->pose + 9);
            vector apart;
            lanes reach;
            if (beaming) {
                vector way = minus(b, a), off = minus(middle, a);
                lanes t = share(dot(way, off) / larger(dot(way, way), every(1e-12)));
                apart = minus(off, times(t, way));
                reach = best + two->ball;
            } else {
                apart = minus(times(every(0.5), plus(a, b)), middle);
                reach = best + (one->ball + two->ball);
            }
            if (!any((reach > 0.0) & (dot(apart, apart) < reach * reach))) continue;
            if (pair->kind == A_BOX) {
                n = from_box(a, b, pair->pose, pair->half);
            } else {
                n = between_segments(a, b, p->ends[2 * pair->second],
                                     p->ends[2 * pair->second + 1]);
                n.distance -= two->radius;
                n.second = plus(n.second, times(every(two->radius), n.normal));
            }
        }
        n.distance -= radius;
        if (!any(n.distance < best)) continue;
        n.first = minus(n.first, times(radius, n.normal));
        if (pair->closer == BY_REACH) {
            if (pair->kind == A_PLANE) drop_by_reach(p, one, pair->pose, &n);
            else part_by_reach(p, one, two, best, deciding, &n);
        } else if (pair->closer == BY_FACES) {
            if (pair->kind == A_PLANE) lift_by_corners(p, one, pair->pose, &n);
            else part_by_faces(s, p, pair, best, &n, hints + 2 * k);
        }
        mask nearer = n.distance < best;
        best = pick(nearer, deciding ? every(-INFINITY) : n.distance, best);
        if (any(nearer)) {
            nearest->distance = best;
            nearest->pair = pick(nearer, every((double)k), nearest->pair);
            nearest->first = pick_vector(nearer, n.first, nearest->first);
            nearest->second = pick_vector(nearer, n.second, nearest->second);
            nearest->normal = pick_vector(nearer, n.normal, nearest->normal);
        }
    }
    for (int i = 0; i < LANES; i++)
        if (nearest->pair[i] >= 0.0) *front = (int64_t)nearest->pair[i] + 1;
    return best;
}

/* Adds the gradient of that distance times `weight`, as wrenches on the bodies. Both points are
 * held fixed, to their bodies or to a share of the beam: an envelope theorem. */
static void pull_nearest(const Space *s, const Margin *g, const Place *p, lanes weight,
                         wrench *on) {
    const Nearest n = p->nearest[g - s->margin];
    weight = pick(n.pair >= 0.0, weight, every(0.0));
    if (g->kind == LINE_OF_SIGHT) {
        vector at = p->at[g->at], start = constant(g->place), beam = minus(at, start);
        lanes length = larger(root(dot(beam, beam)), every(1e-9));
        vector unit = times(1.0 / length, beam), force = times(weight, n.normal);
        /* The watched end is a fixed way before the marker, along a beam that turns. */
        lanes end = larger(length - NEAR_MARKER, every(1e-9));
        lanes part = dot(minus(n.first, start), unit) / end;
        vector along = times(dot(unit, force), unit);
        force = plus(along, times(end / length, minus(force, along)));
        push(&on[s->last], at, times(part, force));
    }
    for (int64_t k = 0; k < g->count; k++) {
        mask here = (n.pair == (double)k) & (weight != 0.0);
        if (!any(here)) continue;
        const Pair *pair = &g->pairs[k];
        vector force = times(pick(here, weight, every(0.0)), n.normal);
        if (g->kind != LINE_OF_SIGHT) push(&on[s->solid[pair->first].body], n.first, force);
        if (pair->kind != A_PLANE)
            push(&on[s->solid[pair->second].body], n.second, times(every(-1.0), force));
    }
}

#endif
