/* What Python calls. Compiled once for every instruction level: LANES numbers side by side, and
 * LEVEL at the end of every name. */
#include <stdlib.h>

#include "export.h"
#include "lockstep.h"
#include "restore.h"

/* Raised with every change of what is exported; `VERSION` in library.py is the same number. */
#define VERSION 11

EXPORT int NAMED(core_version)(void);
EXPORT int64_t NAMED(evaluate)(const Space *s, int64_t count, const double *x,
                               const double *repeats, double *rows, double *margins);
EXPORT int64_t NAMED(pull)(const Space *s, int64_t count, const double *x, const double *repeats,
                           const double *bars, const double *weights, double *gradient);
EXPORT int64_t NAMED(advance)(const Space *s, const Goal *goal, Batch *batch, int64_t begin,
                              int64_t iterations, int64_t settling);
EXPORT int64_t NAMED(restore)(const Space *s, int64_t count, double *x, const double *lower,
                              const double *upper, int64_t iterations);
EXPORT int64_t NAMED(feasible)(const Space *s, int64_t count, const double *x, uint8_t *held);

EXPORT int NAMED(core_version)(void) { return VERSION; }

/* Rows (N, targets * 3, p) in units of what errs and margins (N, C) at design points (N, d); either
 * may be 0, and so may be the (N) repeats that share a load case. Foreign margins are left as they are. */
EXPORT int64_t NAMED(evaluate)(const Space *s, int64_t count, const double *x,
                               const double *repeats, double *rows, double *margins) {
    void *block;
    lanes *memory = aligned(place_size(s), &block);
    if (!memory) return -1;
    Place p = place_in(s, memory);
    const int64_t width = targets(s), unknowns = s->unknowns, c = margins_of(s);
    for (int64_t first = 0; first < count; first += LANES) {
        gather(p.x, x, first, count, s->variables);
        place_bodies(s, &p);
        if (margins) {
            gather(p.margins, margins, first, count, c);
            place_margins(s, &p);
            scatter(margins, p.margins, first, count, c);
        }
        if (!rows) continue;
        if (repeats) gather(&p.erring.repeats, repeats, first, count, 1);
        place_rows(s, &p);
        for (int i = 0; i < LANES && first + i < count; i++)
            for (int64_t t = 0; t < width; t++)
                for (int64_t u = 0; u < unknowns; u++) {
                    const vector *row = &p.rows[t * unknowns + u];
                    double *to = rows + ((first + i) * width + t) * 3 * unknowns + u;
                    to[0] = row->x[i], to[unknowns] = row->y[i], to[2 * unknowns] = row->z[i];
                }
    }
    free(block);
    return 0;
}

/* Gradients (N, d) of a scalar with gradients `bars` in the rows, as they are above, and `weights`
 * (N, C) in the margins; either may be 0. */
EXPORT int64_t NAMED(pull)(const Space *s, int64_t count, const double *x, const double *repeats,
                           const double *bars, const double *weights, double *gradient) {
    const int64_t width = targets(s), unknowns = s->unknowns, c = margins_of(s), d = s->variables;
    void *block;
    lanes *memory = aligned(place_size(s) + pull_size(s) + 6 * (s->moving + 2) +
                                3 * width * unknowns + c + d,
                            &block);
    if (!memory) return -1;
    Place p = place_in(s, memory);
    memory += place_size(s);
    vector *bar = (vector *)memory;
    lanes *weight = (lanes *)(bar + width * unknowns), *slope = weight + c;
    wrench *on = (wrench *)(slope + d);
    lanes *rest = (lanes *)(on + s->moving + 2);
    for (int64_t first = 0; first < count; first += LANES) {
        gather(p.x, x, first, count, d);
        place_bodies(s, &p);
        memset(on, 0, (size_t)(s->moving + 2) * sizeof *on);
        memset(slope, 0, (size_t)d * sizeof *slope);
        if (weights) {
            place_margins(s, &p);
            gather(weight, weights, first, count, c);
            pull_margins(s, &p, weight, on, slope);
        }
        if (bars) {
            if (repeats) gather(&p.erring.repeats, repeats, first, count, 1);
            place_rows(s, &p);
            for (int i = 0; i < LANES; i++)
                for (int64_t t = 0; t < width; t++)
                    for (int64_t u = 0; u < unknowns; u++) {
                        int64_t row = row_of(first, count, i);
                        const double *from = bars + (row * width + t) * 3 * unknowns + u;
                        vector *to = &bar[t * unknowns + u];
                        to->x[i] = from[0];
                        to->y[i] = from[unknowns];
                        to->z[i] = from[2 * unknowns];
                    }
        }
        pull(s, &p, bars ? bar : 0, on, rest, slope);
        scatter(gradient, slope, first, count, d);
    }
    free(block);
    return 0;
}

/* Moves a batch of problems: begins if wanted, makes so many evaluations, settles if wanted. */
EXPORT int64_t NAMED(advance)(const Space *s, const Goal *goal, Batch *batch, int64_t begin,
                              int64_t iterations, int64_t settling) {
    const int64_t points = goal->points, p = s->unknowns;
    Run run = {s, goal, batch, points * s->variables, points * margins_of(s), 0, 0};
    const int asking = goal->foreign || goal->asks_worth;
    run.width = goal->asks_worth ? p : columns_of(&goal->criterion);
    if (!planning(&run)) run.width = goal->rank;
    const int64_t total = (batch->count + LANES - 1) / LANES, together = asking ? total : 1;
    const int64_t wide =
        largest_of(largest_of(points * s->variables, p * p + 1), points * goal->foreign);
    void *block = 0;
    const int64_t heads = together * (int64_t)(sizeof(Group) / sizeof(lanes)) +
                          together * points * (int64_t)(sizeof(Place) / sizeof(lanes));
    lanes *memory = aligned(heads + memory_size(&run) + together * group_size(&run), &block);
    Group *groups = (Group *)memory;
    Place *places = (Place *)(groups + together);
    double *letters = asking ? malloc((size_t)(2 * batch->count * wide) * sizeof *letters) : 0;
    int64_t stopped = memory && (letters || !asking) ? 0 : -1;
    if (!stopped) {
        memset(groups, 0, (size_t)heads * sizeof(lanes));
        run.memory = memory += heads;
        memory += memory_size(&run);
        for (int64_t i = 0; i < together; i++) {
            groups[i].places = places + i * points;
            group_in(&run, &groups[i], memory + i * group_size(&run));
        }
    }
    for (int64_t first = 0; first < total && !stopped; first += together) {
        for (int64_t i = 0; i < together; i++) exchange(&run, &groups[i], (first + i) * LANES, 1);
        stopped = run_groups(&run, groups, together, begin != 0, iterations, settling != 0, letters,
                             asking ? letters + batch->count * wide : 0);
        for (int64_t i = 0; i < together && !stopped; i++)
            exchange(&run, &groups[i], (first + i) * LANES, 0);
    }
    free(letters);
    free(block);
    return stopped;
}

/* Moves design points (N, d) to nearby feasible ones; a space with foreign margins it leaves. */
EXPORT int64_t NAMED(restore)(const Space *s, int64_t count, double *x, const double *lower,
                              const double *upper, int64_t iterations) {
    void *block;
    lanes *memory = aligned(place_size(s) + restore_size(s), &block);
    if (!memory) return -1;
    Place p = place_in(s, memory);
    for (int64_t first = 0; first < count; first += LANES) {
        gather(p.x, x, first, count, s->variables);
        restore_group(s, &p, lower, upper, iterations, memory + place_size(s));
        scatter(x, p.x, first, count, s->variables);
    }
    free(block);
    return 0;
}

/* Which design points (N, d) hold all margins but the foreign ones: 1 where they do. */
EXPORT int64_t NAMED(feasible)(const Space *s, int64_t count, const double *x, uint8_t *held) {
    void *block;
    lanes *memory = aligned(place_size(s), &block);
    if (!memory) return -1;
    Place p = place_in(s, memory);
    for (int64_t first = 0; first < count; first += LANES) {
        gather(p.x, x, first, count, s->variables);
        place_bodies(s, &p);
        mask found = holds_margins(s, &p);
        for (int i = 0; i < LANES && first + i < count; i++) held[first + i] = found[i] != 0;
    }
    free(block);
    return 0;
}
