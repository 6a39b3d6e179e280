/* Margins of the constraints, feasible where >= 0, and their gradients; as in constraints/. */
#ifndef ELASTOCAL_MARGINS_H
#define ELASTOCAL_MARGINS_H

#include "chain.h"
#include "distances.h"

#define TURN 6.283185307179586

/* The nearest whole number. */
INLINE lanes whole(lanes a) {
    const double magic = 0x1.8p52;
    return (a + magic) - magic;
}

/* The beam from a tracker to a point: direction and length. */
INLINE vector beam_to(vector at, const double *position, lanes *length) {
    vector beam = minus(at, constant(position));
    *length = larger(root(dot(beam, beam)), every(1e-9));
    return times(1.0 / *length, beam);
}

/* 1 / sin of an angle of this cosine; bounded where the angle is next to zero. */
INLINE lanes steepness(lanes cosine) {
    return 1.0 / root(larger(1.0 - cosine * cosine, every(1e-6)));
}

/* Ways of the joints from a configuration, whole turns left out. */
INLINE lanes way_from(const Space *s, const Margin *g, const Place *p, int64_t joint) {
    lanes way = p->x[joint] - g->q[joint];
    if (!s->sliding[s->own[joint]]) way -= TURN * whole(way / TURN);
    return way * g->q[s->joints + joint];
}

static lanes margin_at(const Space *s, const Margin *g, const Place *p) {
    vector at = g->at < s->points ? p->at[g->at] : p->at[0];
    lanes length;
    switch (g->kind) {
    case HALF_SPACE: return dot(constant(g->place), at) - g->bound;
    case MIN_RADIUS: return root(at.x * at.x + at.y * at.y) - g->bound;
    case ELEVATION: {
        lanes rise = between(p->pointing[g->along].z, every(-1.0), every(1.0));
        return g->bound - size_of(arc_sine(rise));
    }
    case TILT: {
        lanes cosine = dot(constant(g->place), p->pointing[g->along]);
        return g->bound - arc_cosine(between(cosine, every(-1.0), every(1.0)));
    }
    case JOINT_LIMIT: return g->sign * (p->x[g->at] - g->bound);
    case HELD_JOINT: return -size_of(p->x[g->at] - g->bound);
    case BEAM_RANGE:
        beam_to(at, g->place, &length);
        return g->sign * (length - g->bound);
    case ACCEPTANCE_CONE: {
        vector unit = beam_to(at, g->place, &length);
        lanes cosine = -dot(unit, p->pointing[g->along]);
        return g->bound - arc_cosine(between(cosine, every(-1.0), every(1.0)));
    }
    case HEAD_ELEVATION: {
        vector unit = beam_to(at, g->place, &length);
        return g->sign * (angle(unit.z, root(unit.x * unit.x + unit.y * unit.y)) - g->bound);
    }
    case HEAD_AZIMUTH: {
        vector unit = beam_to(at, g->place, &length);
        lanes off = angle(unit.y, unit.x) - g->middle;
        return g->bound - size_of(off - TURN * whole(off / TURN));
    }
    case DISTINCT: {
        lanes sum = every(0.0);
        for (int64_t j = 0; j < s->joints; j++) {
            lanes way = way_from(s, g, p, j);
            sum += way * way;
        }
        return root(sum) - g->bound;
    }
    case CLEARANCE:
    case LINE_OF_SIGHT: return nearest_pair(s, g, p, every(g->horizon), 0) - g->bound;
    default: return every(0.0);
    }
}

/* Adds the gradient of a margin times `weight`: to wrenches on the bodies, or to that in x. */
static void pull_margin(const Space *s, const Margin *g, const Place *p, lanes weight, wrench *on,
                        lanes *gradient) {
    wrench *flange = &on[s->last];
    vector at = g->at < s->points ? p->at[g->at] : p->at[0];
    lanes length;
    switch (g->kind) {
    case HALF_SPACE: push(flange, at, times(weight, constant(g->place))); return;
    case MIN_RADIUS: {
        lanes scale = weight / larger(root(at.x * at.x + at.y * at.y), every(1e-12));
        push(flange, at, (vector){scale * at.x, scale * at.y, every(0.0)});
        return;
    }
    case ELEVATION: {
        vector axis = p->pointing[g->along];
        lanes rise = between(axis.z, every(-1.0), every(1.0));
        lanes slope = -sign_of(rise) * steepness(rise) * weight;
        vector up = {every(0.0), every(0.0), slope};
        flange->moment = plus(flange->moment, cross(axis, up));
        return;
    }
    case TILT: {
        vector axis = p->pointing[g->along], towards = constant(g->place);
        lanes cosine = between(dot(towards, axis), every(-1.0), every(1.0));
        vector slope = times(weight * steepness(cosine), towards);
        flange->moment = plus(flange->moment, cross(axis, slope));
        return;
    }
    case JOINT_LIMIT: gradient[g->at] += g->sign * weight; return;
    case HELD_JOINT:
        gradient[g->at] -= sign_of(p->x[g->at] - g->bound) * weight;
        return;
    case BEAM_RANGE: {
        vector unit = beam_to(at, g->place, &length);
        push(flange, at, times(g->sign * weight, unit));
        return;
    }
    case ACCEPTANCE_CONE: {
        vector unit = beam_to(at, g->place, &length), axis = p->pointing[g->along];
        lanes cosine = between(-dot(unit, axis), every(-1.0), every(1.0));
        lanes slope = weight * steepness(cosine);
        push(flange, at, times(-slope / length, plus(axis, times(cosine, unit))));
        flange->moment = plus(flange->moment, cross(axis, times(-slope, unit)));
        return;
    }
    case HEAD_ELEVATION: {
        vector unit = beam_to(at, g->place, &length);
        lanes level = root(unit.x * unit.x + unit.y * unit.y);
        lanes slope = g->sign * weight / (length * larger(level, every(1e-6)));
        vector moved = times(-unit.z * slope, unit);
        moved.z += slope;
        push(flange, at, moved);
        return;
    }
    case HEAD_AZIMUTH: {
        vector unit = beam_to(at, g->place, &length);
        lanes off = angle(unit.y, unit.x) - g->middle;
        off -= TURN * whole(off / TURN);
        lanes level = larger(unit.x * unit.x + unit.y * unit.y, every(1e-12)) * length;
        lanes slope = -sign_of(off) * weight / level;
        push(flange, at, (vector){-unit.y * slope, unit.x * slope, every(0.0)});
        return;
    }
    case DISTINCT: {
        lanes distance = larger(margin_at(s, g, p) + g->bound, every(1e-12));
        for (int64_t j = 0; j < s->joints; j++)
            gradient[j] += way_from(s, g, p, j) * (weight / distance);
        return;
    }
    case CLEARANCE:
    case LINE_OF_SIGHT: pull_nearest(s, g, p, weight, on); return;
    default: return;
    }
}

/* Whether a load has a cone: margin to it, and the gradient of that, in its three variables. */
INLINE lanes cone_margin(const Load *load, const lanes *x, vector *gradient) {
    vector v = {x[0], x[1], x[2]}, axis = constant(load->axis);
    lanes norm = root(dot(v, v));
    vector unit = times(1.0 / norm, v);
    lanes cosine = between(dot(axis, unit), every(-1.0), every(1.0));
    if (gradient)
        *gradient = times(steepness(cosine) / norm, minus(axis, times(cosine, unit)));
    return load->half_angle - arc_cosine(cosine);
}

/* All margins but the foreign ones, which stay as they are. */
static void place_margins(const Space *s, Place *p) {
    if (s->solids) place_solids(s, p);
    for (int64_t c = 0; c < s->margins; c++)
        if (s->margin[c].kind != FOREIGN) p->margins[c] = margin_at(s, &s->margin[c], p);
    int64_t c = s->margins, k = s->joints;
    if (s->force.cone) p->margins[c++] = cone_margin(&s->force, p->x + k, 0);
    k += variables_of(&s->force);
    if (s->moment.cone) p->margins[c] = cone_margin(&s->moment, p->x + k, 0);
}

/* Which of the configurations that were placed hold all margins but the foreign ones. Those that
 * take long come last, and only where it is not decided yet. */
static mask holds_margins(const Space *s, Place *p) {
    mask held = every(0.0) == 0.0;
    int solid = 0;
    int64_t k = s->joints;
    if (s->force.cone) held &= cone_margin(&s->force, p->x + k, 0) >= 0.0;
    k += variables_of(&s->force);
    if (s->moment.cone) held &= cone_margin(&s->moment, p->x + k, 0) >= 0.0;
    for (int costly = 0; costly < 2; costly++)
        for (int64_t c = 0; c < s->margins; c++) {
            const Margin *g = &s->margin[c];
            int measured = g->kind == CLEARANCE || g->kind == LINE_OF_SIGHT;
            if (g->kind == FOREIGN || measured != costly) continue;
            if (!any(held)) return held;
            if (!measured) {
                held &= margin_at(s, g, p) >= 0.0;
                continue;
            }
            if (!solid) place_solids(s, p), solid = 1;
            lanes bound = pick(held, every(g->bound), every(-INFINITY));
            held &= nearest_pair(s, g, p, bound, 1) >= g->bound;
        }
    return held;
}

/* Adds the gradient of the margins times `weights` (C + cones). Returns whether there was any. */
static int pull_margins(const Space *s, const Place *p, const lanes *weights, wrench *on,
                        lanes *gradient) {
    int found = 0;
    for (int64_t c = 0; c < s->margins; c++)
        if (s->margin[c].kind != FOREIGN && any(weights[c] != 0.0)) {
            pull_margin(s, &s->margin[c], p, weights[c], on, gradient);
            found = 1;
        }
    int64_t c = s->margins, k = s->joints;
    vector slope;
    if (s->force.cone) {
        cone_margin(&s->force, p->x + k, &slope);
        slope = times(weights[c++], slope);
        gradient[k] += slope.x, gradient[k + 1] += slope.y, gradient[k + 2] += slope.z;
    }
    k += variables_of(&s->force);
    if (s->moment.cone) {
        cone_margin(&s->moment, p->x + k, &slope);
        slope = times(weights[c], slope);
        gradient[k] += slope.x, gradient[k + 1] += slope.y, gradient[k + 2] += slope.z;
    }
    return found;
}

#endif
