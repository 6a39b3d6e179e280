/* What information is worth: a mean of losses tr(C_kᵀ M⁻¹ C_k), in lanes of plans.
 *
 * φ(M) = (Σ loss_k^s)^(−1/s), with one loss its inverse; its gradient is V Vᵀ. Source: paper
 * eq. (20); design/test_pose.py, design/worst_pose.py and design/power_mean.py.
 */
#ifndef ELASTOCAL_CRITERION_H
#define ELASTOCAL_CRITERION_H

#include "lanes.h"

typedef struct {
    int64_t unknowns;     /* p */
    int64_t losses;       /* K */
    const int64_t *ranks; /* (K) columns of each C_k */
    const double *roots;  /* (p, R) the C_k side by side */
    double sharpness;     /* s; 1 for one loss */
} Criterion;

INLINE int64_t columns_of(const Criterion *c) {
    int64_t columns = 0;
    for (int64_t k = 0; k < c->losses; k++) columns += c->ranks[k];
    return columns;
}

static int64_t worth_size(const Criterion *c) {
    return c->unknowns * (c->unknowns + 1) + c->losses;
}

/* φ of information (p, p), of which the lower triangle is read, and V (p, R). */
static lanes worth(const Criterion *c, const lanes *information, lanes *v, lanes *memory) {
    const int64_t p = c->unknowns, columns = columns_of(c);
    lanes *factor = memory, *scale = factor + p * p, *loss = scale + p;
    for (int64_t i = 0; i < p; i++) {
        lanes diagonal = information[i * p + i];
        scale[i] = 1.0 / root(pick(diagonal > 0.0, diagonal, every(1.0)));
    }
    /* Cholesky's factor, its diagonal inverted, of information scaled to unit diagonal. A ridge
     * makes of a singular matrix one with a huge inverse, as matrices.scaled_inverse has it. */
    for (int64_t i = 0; i < p; i++)
        for (int64_t j = 0; j <= i; j++) {
            lanes sum = information[i * p + j] * scale[i] * scale[j];
            if (i == j) sum += 1e-14;
            for (int64_t k = 0; k < j; k++) sum -= factor[i * p + k] * factor[j * p + k];
            factor[i * p + j] =
                i == j ? 1.0 / root(larger(sum, every(1e-16))) : sum * factor[j * p + j];
        }
    for (int64_t k = 0, column = 0; k < c->losses; k++) {
        loss[k] = every(0.0);
        for (int64_t end = column + c->ranks[k]; column < end; column++) {
            for (int64_t i = 0; i < p; i++) {
                lanes sum = c->roots[i * columns + column] * scale[i];
                for (int64_t j = 0; j < i; j++) sum -= factor[i * p + j] * v[j * columns + column];
                v[i * columns + column] = sum = sum * factor[i * p + i];
                loss[k] += sum * sum;
            }
            for (int64_t i = p - 1; i >= 0; i--) {
                lanes sum = v[i * columns + column];
                for (int64_t j = i + 1; j < p; j++)
                    sum -= factor[j * p + i] * v[j * columns + column];
                v[i * columns + column] = sum * factor[i * p + i];
            }
            for (int64_t i = 0; i < p; i++) v[i * columns + column] *= scale[i];
        }
    }
    lanes largest = loss[0], sum = every(0.0), value;
    for (int64_t k = 1; k < c->losses; k++) largest = larger(loss[k], largest);
    if (c->losses == 1) {
        value = 1.0 / largest;
    } else {
        for (int64_t k = 0; k < c->losses; k++)
            for (int i = 0; i < LANES; i++) sum[i] += pow(loss[k][i] / largest[i], c->sharpness);
        for (int i = 0; i < LANES; i++) value[i] = pow(sum[i], -1.0 / c->sharpness) / largest[i];
    }
    for (int64_t k = 0, column = 0; k < c->losses; k++) {
        lanes weight = value;
        for (int i = 0; c->losses > 1 && i < LANES; i++)
            weight[i] *= sqrt(pow(loss[k][i] * value[i], c->sharpness - 1.0));
        for (int64_t end = column + c->ranks[k]; column < end; column++)
            for (int64_t i = 0; i < p; i++) v[i * columns + column] *= weight;
    }
    return value;
}

#endif
