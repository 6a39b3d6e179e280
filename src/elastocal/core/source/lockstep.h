/* Many small constrained minimisations, LANES side by side; design/lockstep.py says how and why.
 *
 * A problem is the best place of s points: of one the sensitivity is to be large (a climb), or the
 * information of all together is to be worth much (a plan). Between two settlements of the
 * multipliers all is done here: step, margins, worth, gradient, curvature, new direction.
 */
#ifndef ELASTOCAL_LOCKSTEP_H
#define ELASTOCAL_LOCKSTEP_H

#include "criterion.h"
#include "margins.h"

/* What Python is asked. */
enum { ASK_MARGINS, ASK_PULL, ASK_WORTH };

typedef struct {
    int64_t points; /* s of a problem */
    double level;   /* unit of the sensitivity of a climb; 0: a plan */
    int64_t rank;
    const double *root; /* (p, rank) V of the sensitivity of a climb */
    const double *base; /* (p, p) information there is anyway, of a plan */
    Criterion criterion;
    int64_t foreign; /* margins that Python knows */
    int64_t asks_worth;
    /* (what, rows of in, in, out); not 0: stop. */
    int64_t (*ask)(int64_t what, int64_t count, double *in, double *out);
} Goal;

/* The problems, one row each; design/lockstep.py: Batch. */
typedef struct {
    int64_t count;        /* B */
    const double *lower;  /* (D) */
    const double *upper;  /* (D) */
    const double *counts; /* (B, s) repeats, of plans */
    double *x;            /* (B, D) */
    double *value;        /* (B) */
    double *margins;      /* (B, C) */
    double *merit;        /* (B) */
    double *gradient;     /* (B, D) */
    double *multipliers;  /* (B, C) */
    double *penalty;      /* (B, C) */
    double *broken;       /* (B, C) */
    double *checkpoint;   /* (B) */
    double *inverse;      /* (B, D (D + 1) / 2) lower triangles */
    uint8_t *fresh;       /* (B) */
    double *direction;    /* (B, D) */
    double *length;       /* (B) */
    double *gain;         /* (B) of the last settlement */
} Batch;

typedef struct {
    lanes *x, *margins, *gradient, *multipliers, *penalty, *broken, *inverse, *direction, *counts;
    lanes value, merit, checkpoint, fresh, length, gain;
    /* The point that is tried. */
    lanes *tried, *moved, *tried_margins, *tried_gradient, *weights, *total, *v;
    vector *images; /* (targets, R) rows V of the one point of a climb */
    lanes worth; /* φ of a plan */
    lanes tried_value, tried_merit, slope;
    Place *places; /* (s) */
} Group;

#define REACH 0.5 /* longest step in one variable */
#define TINY 1e-200

typedef struct {
    const Space *space;
    const Goal *goal;
    Batch *batch;
    int64_t size, margins, width; /* D and C of a problem, R */
    lanes *memory;                /* for one group at a time */
} Run;

/* Whether the problems are plans, not climbs. */
INLINE int planning(const Run *r) { return r->goal->level <= 0.0; }

static int64_t group_size(const Run *r) {
    const int64_t s = r->goal->points, p = r->space->unknowns, size = r->size;
    return 6 * size + 6 * r->margins + size * (size + 1) / 2 + s + p * p + p * r->width +
           3 * targets(r->space) * r->width + s * place_size(r->space);
}

static int64_t largest_of(int64_t a, int64_t b) { return a > b ? a : b; }

static int64_t memory_size(const Run *r) {
    const int64_t rows = targets(r->space) * r->space->unknowns;
    const int64_t pulling = pull_size(r->space) + 6 * (r->space->moving + 2) + 3 * rows;
    const int64_t worthy = planning(r) ? worth_size(&r->goal->criterion) : 0;
    return largest_of(largest_of(pulling, worthy), 2 * r->size) + 3 * r->width +
           r->space->unknowns * r->space->unknowns;
}

static void group_in(const Run *r, Group *g, lanes *memory) {
    const int64_t s = r->goal->points, p = r->space->unknowns, size = r->size, c = r->margins;
    g->x = memory, memory += size;
    g->gradient = memory, memory += size;
    g->direction = memory, memory += size;
    g->tried = memory, memory += size;
    g->moved = memory, memory += size;
    g->tried_gradient = memory, memory += size;
    g->margins = memory, memory += c;
    g->multipliers = memory, memory += c;
    g->penalty = memory, memory += c;
    g->broken = memory, memory += c;
    g->tried_margins = memory, memory += c;
    g->weights = memory, memory += c;
    g->inverse = memory, memory += size * (size + 1) / 2;
    g->counts = memory, memory += s;
    g->total = memory, memory += p * p;
    g->v = memory, memory += p * r->width;
    g->images = (vector *)memory, memory += 3 * targets(r->space) * r->width;
    for (int64_t k = 0; k < s; k++) {
        g->places[k] = place_in(r->space, memory);
        memory += place_size(r->space);
    }
}

/* Every array of a problem that is kept from call to call. */
static void exchange(const Run *r, Group *g, int64_t first, int reading) {
    const Batch *b = r->batch;
    const int64_t size = r->size, c = r->margins;
    const struct {
        double *rows;
        lanes *group;
        int64_t width;
    } kept[] = {
        {b->x, g->x, size},
        {b->value, &g->value, 1},
        {b->margins, g->margins, c},
        {b->merit, &g->merit, 1},
        {b->gradient, g->gradient, size},
        {b->multipliers, g->multipliers, c},
        {b->penalty, g->penalty, c},
        {b->broken, g->broken, c},
        {b->checkpoint, &g->checkpoint, 1},
        {b->inverse, g->inverse, size * (size + 1) / 2},
        {b->direction, g->direction, size},
        {b->length, &g->length, 1},
        {b->gain, &g->gain, 1},
    };
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) {
        if (reading)
            gather(kept[i].group, kept[i].rows, first, b->count, kept[i].width);
        else
            scatter(kept[i].rows, kept[i].group, first, b->count, kept[i].width);
    }
    for (int i = 0; i < LANES; i++) {
        int64_t row = row_of(first, b->count, i);
        if (reading)
            g->fresh[i] = b->fresh[row];
        else if (first + i < b->count)
            b->fresh[row] = g->fresh[i] != 0.0;
    }
    if (reading && planning(r))
        gather(g->counts, b->counts, first, b->count, r->goal->points);
}

/* Places and rows of the points at `x`, and what they make together. */
static void place_points(const Run *r, Group *g, const lanes *x) {
    const Space *s = r->space;
    const int64_t p = s->unknowns, d = s->variables, c = margins_of(s), rows = targets(s);
    const int plan = planning(r);
    for (int64_t i = 0; plan && i < p; i++)
        for (int64_t j = 0; j <= i; j++) g->total[i * p + j] = every(r->goal->base[i * p + j]);
    for (int64_t k = 0; k < r->goal->points; k++) {
        Place *place = &g->places[k];
        memcpy(place->x, x + k * d, (size_t)d * sizeof(lanes));
        place_bodies(s, place);
        place_margins(s, place);
        if (plan) place->erring.repeats = g->counts[k];
        place_rows(s, place);
        memcpy(g->tried_margins + k * c, place->margins, (size_t)c * sizeof(lanes));
        for (int64_t t = 0; plan && t < rows; t++)
            for (int64_t i = 0; i < p; i++) {
                vector row = times(g->counts[k], place->rows[t * p + i]);
                for (int64_t j = 0; j <= i; j++)
                    g->total[i * p + j] += dot(row, place->rows[t * p + j]);
            }
    }
}

/* Value of the points that were placed. */
static void value_points(const Run *r, Group *g) {
    if (planning(r)) {
        if (!r->goal->asks_worth)
            g->worth = worth(&r->goal->criterion, g->total, g->v, r->memory);
        g->worth = pick(g->worth > TINY, g->worth, every(TINY));
        for (int i = 0; i < LANES; i++) g->tried_value[i] = -log(g->worth[i]);
        return;
    }
    const int64_t p = r->space->unknowns, width = r->width;
    lanes sum = every(0.0);
    for (int64_t t = 0; t < targets(r->space); t++) {
        const vector *row = g->places[0].rows + t * p;
        for (int64_t k = 0; k < width; k++) {
            vector image = {every(0.0), every(0.0), every(0.0)};
            for (int64_t i = 0; i < p; i++)
                image = plus(image, times(every(r->goal->root[i * width + k]), row[i]));
            g->images[t * width + k] = image;
            sum += dot(image, image);
        }
    }
    g->tried_value = -sum / r->goal->level;
}

/* Augmented Lagrangian there, and the weights of the margins in its gradient. */
static void merit_points(const Run *r, Group *g) {
    lanes sum = every(0.0);
    for (int64_t c = 0; c < r->margins; c++) {
        lanes shifted = larger(g->multipliers[c] - g->penalty[c] * g->tried_margins[c], every(0.0));
        shifted = pick(g->tried_margins[c] != g->tried_margins[c], g->tried_margins[c], shifted);
        sum += (shifted * shifted - g->multipliers[c] * g->multipliers[c]) / (2.0 * g->penalty[c]);
        g->weights[c] = -shifted;
    }
    g->tried_merit = g->tried_value + sum;
}

/* Gradient of the merit there, but for what foreign margins add. */
static void pull_points(const Run *r, Group *g) {
    const Space *s = r->space;
    const int64_t p = s->unknowns, d = s->variables, c = margins_of(s), width = r->width;
    const int plan = planning(r);
    lanes *image = r->memory, *square = image + 3 * width;
    vector *bars = (vector *)(square + p * p);
    wrench *on = (wrench *)(bars + targets(s) * p);
    lanes *rest = (lanes *)(on + s->moving + 2);
    lanes factor = every(-2.0 / (plan ? 1.0 : r->goal->level));
    if (plan)
        factor = pick(g->worth > TINY, -2.0 / g->worth, every(0.0));
    /* Few columns: by V and back; many: by V Vᵀ. */
    const int narrow = !plan || 2 * width <= p, asked = plan && r->goal->asks_worth;
    if (!narrow && !asked)
        for (int64_t i = 0; i < p; i++)
            for (int64_t j = 0; j <= i; j++) {
                lanes sum = every(0.0);
                for (int64_t k = 0; k < width; k++)
                    sum += g->v[i * width + k] * g->v[j * width + k];
                square[i * p + j] = square[j * p + i] = sum;
            }
    for (int64_t k = 0; k < r->goal->points; k++) {
        const Place *place = &g->places[k];
        lanes scale = plan ? factor * g->counts[k] : factor;
        for (int64_t t = 0; t < targets(s); t++) {
            const vector *row = place->rows + t * p;
            vector *bar = bars + t * p, *images = plan ? (vector *)image : g->images + t * width;
            if (!narrow || asked) {
                const lanes *slope = asked ? g->v : square;
                for (int64_t i = 0; i < p; i++) {
                    vector sum = {every(0.0), every(0.0), every(0.0)};
                    for (int64_t j = 0; j < p; j++)
                        sum = plus(sum, times(slope[i * p + j], row[j]));
                    bar[i] = times(scale, sum);
                }
                continue;
            }
            for (int64_t j = 0; plan && j < width; j++) {
                vector sum = {every(0.0), every(0.0), every(0.0)};
                for (int64_t i = 0; i < p; i++)
                    sum = plus(sum, times(g->v[i * width + j], row[i]));
                images[j] = sum;
            }
            for (int64_t i = 0; i < p; i++) {
                vector sum = {every(0.0), every(0.0), every(0.0)};
                for (int64_t j = 0; j < width; j++)
                    sum = plus(sum, times(plan ? g->v[i * width + j]
                                               : every(r->goal->root[i * width + j]),
                                          images[j]));
                bar[i] = times(scale, sum);
            }
        }
        memset(on, 0, (size_t)(s->moving + 2) * sizeof *on);
        lanes *gradient = g->tried_gradient + k * d;
        memset(gradient, 0, (size_t)d * sizeof *gradient);
        pull_margins(s, place, g->weights + k * c, on, gradient);
        pull(s, place, bars, on, rest, gradient);
    }
}

/* Directions of search of the problems `which`, among the variables that are free to move. */
static void aim(const Run *r, Group *g, mask which) {
    const int64_t size = r->size;
    lanes *reduced = r->memory, *direction = reduced + size, longest = every(0.0);
    for (int64_t i = 0; i < size; i++) {
        mask held = ((g->x[i] <= r->batch->lower[i]) & (g->gradient[i] > 0.0)) |
                    ((g->x[i] >= r->batch->upper[i]) & (g->gradient[i] < 0.0));
        reduced[i] = pick(held, every(0.0), g->gradient[i]);
    }
    const lanes *row = g->inverse;
    for (int64_t i = 0; i < size; row += ++i) {
        lanes sum = row[i] * reduced[i], own = reduced[i];
        for (int64_t j = 0; j < i; j++) {
            sum += row[j] * reduced[j];
            direction[j] += row[j] * own;
        }
        direction[i] = sum;
    }
    for (int64_t i = 0; i < size; i++) {
        mask held = (g->gradient[i] != reduced[i]);
        direction[i] = pick(held, every(0.0), -direction[i]);
        longest = larger(size_of(direction[i]), longest);
    }
    mask fresh = g->fresh != 0.0;
    lanes limit = pick(fresh, every(0.2 * REACH), every(REACH));
    lanes scale = limit / larger(longest, every(1e-300));
    scale = smaller(pick(fresh | (longest > limit), scale, every(1.0)), every(1e6));
    for (int64_t i = 0; i < size; i++)
        g->direction[i] = pick(which, scale * direction[i], g->direction[i]);
}

/* BFGS: what the step of the problems `which` says of the curvature. */
static void learn(const Run *r, Group *g, mask which) {
    const int64_t size = r->size;
    lanes *change = r->memory, *bent = change + size;
    lanes curvature = every(0.0), norm = every(0.0);
    for (int64_t i = 0; i < size; i++) {
        /* A variable held at its bound says nothing of the curvature among the others. */
        mask still = g->moved[i] == 0.0;
        change[i] = pick(still, every(0.0), g->tried_gradient[i] - g->gradient[i]);
        curvature += g->moved[i] * change[i];
        norm += change[i] * change[i];
    }
    mask use = which & (curvature > 1e-8 * norm) & (norm > 1e-100) & is_finite(norm);
    if (!any(use)) return;
    for (int64_t i = 0; i < size; i++) change[i] = pick(use, change[i], every(0.0));
    mask first = use & (g->fresh != 0.0);
    lanes grown = pick(first, curvature / norm, every(1.0));
    g->fresh = pick(first, every(0.0), g->fresh);
    lanes *row = g->inverse, turned_by = every(0.0);
    for (int64_t i = 0; i < size; row += ++i) {
        if (any(first))
            for (int64_t j = 0; j <= i; j++) row[j] *= grown;
        lanes sum = row[i] * change[i], own = change[i];
        for (int64_t j = 0; j < i; j++) {
            sum += row[j] * change[j];
            bent[j] += row[j] * own;
        }
        bent[i] = sum;
    }
    lanes over = pick(use, 1.0 / pick(use, curvature, every(1.0)), every(0.0));
    for (int64_t i = 0; i < size; i++) turned_by += change[i] * bent[i];
    lanes factor = (1.0 + turned_by * over) / 2.0;
    for (int64_t i = 0; i < size; i++) bent[i] = (factor * g->moved[i] - bent[i]) * over;
    row = g->inverse;
    for (int64_t i = 0; i < size; row += ++i) {
        lanes left = bent[i], step = g->moved[i];
        for (int64_t j = 0; j <= i; j++) row[j] += left * g->moved[j] + step * bent[j];
    }
}

/* The next point to try. */
static void step(const Run *r, Group *g) {
    g->slope = every(0.0);
    for (int64_t i = 0; i < r->size; i++) {
        lanes x = g->x[i] + g->length * g->direction[i];
        g->tried[i] = between(x, every(r->batch->lower[i]), every(r->batch->upper[i]));
        g->moved[i] = g->tried[i] - g->x[i];
        g->slope += g->gradient[i] * g->moved[i];
    }
}

/* Takes the point that was tried as the one it is at. */
static void take(const Run *r, Group *g, mask good) {
    for (int64_t i = 0; i < r->size; i++) {
        g->x[i] = pick(good, g->tried[i], g->x[i]);
        g->gradient[i] = pick(good, g->tried_gradient[i], g->gradient[i]);
    }
    for (int64_t c = 0; c < r->margins; c++)
        g->margins[c] = pick(good, g->tried_margins[c], g->margins[c]);
    g->value = pick(good, g->tried_value, g->value);
    g->merit = pick(good, g->tried_merit, g->merit);
}

/* Whether the merit falls enough at the point that was tried. */
INLINE mask accepted(const Group *g) { return g->tried_merit <= g->merit + 1e-4 * g->slope; }

/* Accepts it where that is so, shortens the step elsewhere. */
static void judge(const Run *r, Group *g) {
    mask good = accepted(g);
    if (any(good)) learn(r, g, good);
    lanes rise = g->tried_merit - g->merit - g->slope;
    rise = pick(is_finite(g->tried_merit), rise, every(INFINITY));
    if (any(good)) take(r, g, good);
    lanes shrink = -0.5 * g->slope / rise;
    shrink = between(pick(is_finite(shrink), shrink, every(0.5)), every(0.1), every(0.5));
    mask stuck = ~good & (g->length < 1e-6);
    if (any(stuck)) {
        lanes *row = g->inverse;
        for (int64_t i = 0; i < r->size; row += ++i)
            for (int64_t j = 0; j <= i; j++) row[j] = pick(stuck, every(i == j), row[j]);
        g->fresh = pick(stuck, every(1.0), g->fresh);
    }
    g->length = pick(good | stuck, every(1.0), g->length * shrink);
    if (any(good | stuck)) aim(r, g, good | stuck);
}

/* Moves the multipliers; penalties rise where a margin stays broken. */
static void settle(const Run *r, Group *g) {
    for (int64_t c = 0; c < r->margins; c++) {
        lanes multiplier = g->multipliers[c] - g->penalty[c] * g->margins[c];
        g->multipliers[c] = larger(multiplier, every(0.0));
        lanes broken = larger(-g->margins[c], every(0.0));
        mask stubborn = (broken > 1e-4) & (broken > 0.5 * g->broken[c]);
        lanes stiffer = smaller(5.0 * g->penalty[c], every(1e4));
        g->penalty[c] = pick(stubborn, stiffer, g->penalty[c]);
        g->broken[c] = broken;
    }
    g->gain = g->checkpoint - g->value;
    g->checkpoint = g->value;
    memcpy(g->tried, g->x, (size_t)r->size * sizeof(lanes));
}

/* Starts from the point that was evaluated, with multipliers and penalties as they are. */
static void restart(const Run *r, Group *g, int begin) {
    const mask everywhere = every(0.0) == 0.0;
    take(r, g, everywhere);
    if (begin) {
        for (int64_t c = 0; c < r->margins; c++) g->broken[c] = larger(-g->margins[c], every(0.0));
        g->checkpoint = g->value;
    }
    g->length = every(1.0);
    aim(r, g, everywhere);
}

/* Asks Python about the points that all groups of a chunk are trying. */
static int64_t ask(const Run *r, int64_t what, Group *groups, int64_t count, double *in,
                   double *out) {
    const Space *s = r->space;
    const int64_t p = s->unknowns, d = s->variables, c = margins_of(s), points = r->goal->points;
    const int64_t foreign = r->goal->foreign, problems = r->batch->count;
    const int64_t width = what == ASK_WORTH ? p * p : what == ASK_PULL ? foreign : d;
    const int64_t height = what == ASK_WORTH ? 1 : points;
    for (int64_t i = 0; i < problems; i++) {
        const Group *g = &groups[i / LANES];
        for (int64_t k = 0; k < height; k++) {
            double *row = in + (i * height + k) * width;
            if (what == ASK_MARGINS)
                for (int64_t j = 0; j < d; j++) row[j] = g->tried[k * d + j][i % LANES];
            if (what == ASK_WORTH)
                for (int64_t j = 0; j < p * p; j++) {
                    int64_t a = j / p, b = j % p;
                    row[j] = g->total[a > b ? j : b * p + a][i % LANES];
                }
            for (int64_t m = 0, f = 0; what == ASK_PULL && m < s->margins; m++)
                if (s->margin[m].kind == FOREIGN) row[f++] = g->weights[k * c + m][i % LANES];
        }
    }
    int64_t stopped = r->goal->ask(what, problems * height, in, out);
    if (stopped) return stopped;
    for (int64_t i = 0; i < count * LANES; i++) {
        int64_t from = i < problems ? i : problems - 1;
        Group *g = &groups[i / LANES];
        int lane = (int)(i % LANES);
        if (what == ASK_WORTH) {
            g->worth[lane] = out[from];
            for (int64_t j = 0; j < p * p; j++) g->v[j][lane] = out[problems + from * p * p + j];
        }
        for (int64_t k = 0; what != ASK_WORTH && k < points; k++) {
            const double *row = out + (from * points + k) * (what == ASK_PULL ? d : foreign);
            for (int64_t j = 0; what == ASK_PULL && j < d; j++)
                g->tried_gradient[k * d + j][lane] += row[j];
            for (int64_t m = 0, f = 0; what == ASK_MARGINS && m < s->margins; m++)
                if (s->margin[m].kind == FOREIGN) g->tried_margins[k * c + m][lane] = row[f++];
        }
    }
    return 0;
}

/* Evaluates what the groups are trying: merit, and its gradient unless the step is refused. */
static int64_t evaluate_groups(const Run *r, Group *groups, int64_t count, int stepping, double *in,
                               double *out) {
    const Goal *goal = r->goal;
    int64_t stopped = 0;
    for (int64_t i = 0; i < count; i++) place_points(r, &groups[i], groups[i].tried);
    if (goal->foreign) stopped = ask(r, ASK_MARGINS, groups, count, in, out);
    if (goal->asks_worth && !stopped) stopped = ask(r, ASK_WORTH, groups, count, in, out);
    for (int64_t i = 0; i < count && !stopped; i++) {
        value_points(r, &groups[i]);
        merit_points(r, &groups[i]);
        if (!stepping || goal->foreign || any(accepted(&groups[i]))) pull_points(r, &groups[i]);
    }
    if (goal->foreign && !stopped) stopped = ask(r, ASK_PULL, groups, count, in, out);
    return stopped;
}

/* Begins, then so many evaluations, then settles; of what is wanted. */
static int64_t run_groups(const Run *r, Group *groups, int64_t count, int begin, int64_t iterations,
                          int settling, double *in, double *out) {
    int64_t stopped = 0;
    if (begin) {
        for (int64_t i = 0; i < count; i++)
            memcpy(groups[i].tried, groups[i].x, (size_t)r->size * sizeof(lanes));
        stopped = evaluate_groups(r, groups, count, 0, in, out);
        for (int64_t i = 0; i < count && !stopped; i++) restart(r, &groups[i], 1);
    }
    for (int64_t k = 0; k < iterations && !stopped; k++) {
        for (int64_t i = 0; i < count; i++) step(r, &groups[i]);
        stopped = evaluate_groups(r, groups, count, 1, in, out);
        for (int64_t i = 0; i < count && !stopped; i++) judge(r, &groups[i]);
    }
    if (settling && !stopped) {
        for (int64_t i = 0; i < count; i++) settle(r, &groups[i]);
        stopped = evaluate_groups(r, groups, count, 0, in, out);
        for (int64_t i = 0; i < count && !stopped; i++) restart(r, &groups[i], 0);
    }
    return stopped;
}

#endif
