/* Nearby feasible points, as `restore` in design/oracle.py: Gauss-Newton steps on all broken margins
 * together, in the bounds. */
#ifndef ELASTOCAL_RESTORE_H
#define ELASTOCAL_RESTORE_H

#include "margins.h"

#define INSIDE 1e-10
#define NEARLY 1e-9 /* margins below this are held while others are mended */

static int64_t restore_size(const Space *s) {
    const int64_t c = margins_of(s), d = s->variables;
    return pull_size(s) + 6 * (s->moving + 2) + c * (d + c + 3) + d;
}

/* The shortest step that mends all broken margins to first order, bounds respected. */
static void correct(const Space *s, const Place *p, const double *lower, const double *upper,
                    lanes *memory, lanes *step) {
    const int64_t c = margins_of(s), d = s->variables;
    lanes *jacobian = memory, *square = jacobian + c * d, *wanted = square + c * c;
    lanes *weight = wanted + c, *least = weight + c;
    wrench *on = (wrench *)(least + c);
    lanes *rest = (lanes *)(on + s->moving + 2);
    lanes trace = every(0.0), lowest = every(INFINITY), *worst = step;
    int64_t active = 0;
    memset(worst, 0, (size_t)d * sizeof *worst);
    memset(weight, 0, (size_t)c * sizeof *weight);
    for (int64_t k = 0; k < c; k++) {
        mask near = p->margins[k] < NEARLY;
        if (!any(near)) continue;
        lanes *row = jacobian + active * d;
        memset(on, 0, (size_t)(s->moving + 2) * sizeof *on);
        memset(row, 0, (size_t)d * sizeof *row);
        weight[k] = pick(near, every(1.0), every(0.0));
        pull_margins(s, p, weight, on, row);
        weight[k] = every(0.0);
        pull(s, p, 0, on, rest, row);
        lanes missing = larger(INSIDE - p->margins[k], every(0.0));
        wanted[active++] = pick(near, missing, every(0.0));
        mask lower_still = p->margins[k] < lowest;
        lowest = pick(lower_still, p->margins[k], lowest);
        for (int64_t j = 0; j < d; j++) worst[j] = pick(lower_still, row[j], worst[j]);
    }
    /* Of the variables at a bound, those that the worst margin pushes outward stay there. */
    for (int64_t j = 0; j < d; j++) {
        mask pinned = ((p->x[j] <= lower[j]) & (worst[j] < 0.0)) |
                      ((p->x[j] >= upper[j]) & (worst[j] > 0.0));
        for (int64_t k = 0; k < active; k++)
            jacobian[k * d + j] = pick(pinned, every(0.0), jacobian[k * d + j]);
    }
    for (int64_t i = 0; i < active; i++)
        for (int64_t k = 0; k <= i; k++) {
            lanes sum = every(0.0);
            for (int64_t j = 0; j < d; j++) sum += jacobian[i * d + j] * jacobian[k * d + j];
            square[i * c + k] = sum;
            if (i == k) trace += sum;
        }
    for (int64_t i = 0; i < active; i++) {
        square[i * c + i] += 1e-9 * trace + 1e-12;
        for (int64_t k = 0; k <= i; k++) {
            lanes sum = square[i * c + k];
            for (int64_t j = 0; j < k; j++) sum -= square[i * c + j] * square[k * c + j];
            square[i * c + k] =
                i == k ? 1.0 / root(larger(sum, every(1e-300))) : sum * square[k * c + k];
        }
    }
    for (int64_t i = 0; i < active; i++) {
        for (int64_t k = 0; k < i; k++) wanted[i] -= square[i * c + k] * wanted[k];
        wanted[i] *= square[i * c + i];
    }
    for (int64_t i = active - 1; i >= 0; i--) {
        for (int64_t k = i + 1; k < active; k++) wanted[i] -= square[k * c + i] * wanted[k];
        wanted[i] *= square[i * c + i];
    }
    for (int64_t j = 0; j < d; j++) {
        step[j] = every(0.0);
        for (int64_t k = 0; k < active; k++) step[j] += jacobian[k * d + j] * wanted[k];
    }
}

static void restore_group(const Space *s, Place *p, const double *lower, const double *upper,
                          int64_t iterations, lanes *memory) {
    const int64_t c = margins_of(s), d = s->variables;
    lanes *step = memory;
    for (int64_t j = 0; j < d; j++)
        p->x[j] = between(p->x[j], every(lower[j]), every(upper[j]));
    for (int64_t k = 0; k < iterations; k++) {
        mask outside = {0};
        place_bodies(s, p);
        place_margins(s, p);
        for (int64_t i = 0; i < c; i++) outside |= p->margins[i] < 0.0;
        if (!any(outside)) return;
        correct(s, p, lower, upper, memory + d, step);
        for (int64_t j = 0; j < d; j++) {
            lanes x = between(p->x[j] + step[j], every(lower[j]), every(upper[j]));
            p->x[j] = pick(outside, x, p->x[j]);
        }
    }
}

#endif
